"""A block on a ring: published values, volumes by hand, its own names, and every command on one run."""

import json
import math
import re
import shutil
from dataclasses import replace

import numpy as np
import pytest
from folders import SAMPLES, replace_in
from hypothesis import given
from hypothesis import strategies as st

from tribopipe.base.errors import ContactError, ManifestError
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import DefaultUncertainty, MonteCarloRecipe, Recipe
from tribopipe.documents.record import read_document
from tribopipe.evaluation.checks.registry import check_run
from tribopipe.evaluation.measurements.sliding_distance import distance_share
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.evaluation.wear.local import local_scenario, wear_locally
from tribopipe.evaluation.wear.prediction import predict_wear, wear_scenario
from tribopipe.evaluation.wear.scenario import given_wear
from tribopipe.physics.geometry import cap_radius, segment_area, segment_height
from tribopipe.physics.pin_on_disc import BlockOnCylinder
from tribopipe.readers.draft.known_values import problem_of
from tribopipe.readers.harmonize import read_run
from tribopipe.results.finding import title
from tribopipe.results.run import RawRun

BLOCK = {"width": "6.35 mm", "material": "bronze", "youngs_modulus": "110 GPa", "poisson_ratio": 0.34}
RING = {"radius": "17.5 mm", "material": "4620 steel", "youngs_modulus": "210 GPa", "poisson_ratio": 0.3}
FIRST_ORDER = Recipe(monte_carlo=MonteCarloRecipe(significant_digits=0))
LOAD, SLID, WIDTH, RADIUS = 134.0, 586.0, 6.35e-3, 17.5e-3


def block_on_ring(**changes: object) -> dict:
    """Return a run.toml as a document."""
    return {
        "schema": "tribopipe.run/1",
        "id": "ring",
        "contact": {"kind": "block-on-ring", "block": BLOCK, "ring": RING},
        "conditions": {"normal_load": "134 N", "rotational_speed": "197 rpm"},
        "signals": [{"file": "ring.csv"}],
        **changes,
    }


def read(document: dict) -> RunManifest:
    return read_document(document, RunManifest, where="run.toml")


def predicted(**coefficients: float):
    run = read(block_on_ring())
    known = {name: Quantity(value=k, unit="m^2/N") for name, k in coefficients.items()}
    (point,) = predict_wear(wear_scenario(run, given_wear(run.described, known, Recipe())), [SLID]).prediction
    return point


def test_both_wear_as_published():
    """The check value, mm: 134 N, 586 m, k 5e-9 and 2e-10 mm³/(N·mm)."""
    point = predicted(block=5e-15, ring=2e-16)
    assert 2 * point.contact.half_length.value == pytest.approx(2.34932615e-3, rel=1e-8)
    assert point.bodies["block"].wear_depth.value == pytest.approx(0.0394683170e-3, rel=1e-8)
    assert point.bodies["ring"].wear_depth.value == pytest.approx(2.24926574e-8, rel=1e-8)
    assert point.bodies["block"].wear_volume.value == pytest.approx(5e-15 * LOAD * SLID, rel=1e-12)
    assert point.bodies["ring"].wear_volume.value == pytest.approx(2e-16 * LOAD * SLID, rel=1e-12)
    pressed = LOAD / (WIDTH * 2.34932615e-3)
    assert point.contact.mean_pressure.value == pytest.approx(pressed, rel=1e-8)


@pytest.mark.parametrize(
    ("origin", "relative"),
    [("derived from rotations", 0.002), ("derived from nominal speed", math.hypot(0.002, 0.005))],
)
def test_a_ring_gives_its_uncertainty_to_the_distance(origin, relative):
    run = RawRun(read(block_on_ring()), {}, {"sliding_distance": origin}, {}, {}, ())
    assert distance_share(run, DefaultUncertainty()) == pytest.approx(relative, rel=1e-12)


def test_block_alone_wears_alike():
    alone, both = predicted(block=5e-15), predicted(block=5e-15, ring=2e-16)
    assert alone.bodies["block"].wear_depth.value == pytest.approx(both.bodies["block"].wear_depth.value, rel=1e-12)
    assert alone.contact.mean_pressure.value == pytest.approx(both.contact.mean_pressure.value, rel=1e-12)
    assert alone.contact.half_width.value == pytest.approx(WIDTH / 2)


@pytest.mark.parametrize("both", [{}, {"ring": 2e-16}])
def test_the_radius_of_a_prediction_has_the_name_of_the_ring(both):
    run = read(block_on_ring())
    known = {name: Quantity(value=k, unit="m^2/N") for name, k in {"block": 5e-15, **both}.items()}
    found = predict_wear(wear_scenario(run, given_wear(run.described, known, Recipe())), [SLID])
    assert found.conditions["ring_radius"].value == RADIUS
    assert "pin_radius" not in found.conditions


def run_of(**ends: object) -> RawRun:
    distance = np.linspace(0.0, SLID, 50)
    manifest = read(block_on_ring(end_values=ends))
    columns = {"time": distance / 0.361, "sliding_distance": distance}
    return RawRun(manifest, columns, dict.fromkeys(columns, "measured"), {}, {}, ())


def test_k_d_by_the_scar_is_that_of_the_standard_formula():
    b = 2.35e-3
    fit = fit_wear(
        run_of(block_scar_width={"value": "2.35 mm", "standard_uncertainty": "10 um"}), "archard", recipe=FIRST_ORDER
    )
    lost = WIDTH * (RADIUS**2 * np.arcsin(b / 2 / RADIUS) - b / 4 * np.sqrt(4 * RADIUS**2 - b**2))
    assert fit.k_d.value == pytest.approx(lost / (LOAD * SLID), rel=1e-9)
    assert list(fit.bodies) == ["block"]
    # V ∝ b³ nearly.
    share = np.sqrt((3 * 0.01 / 2.35) ** 2 + 0.01**2 + 0.002**2)
    assert fit.k_d.standard_uncertainty == pytest.approx(share * fit.k_d.value, rel=0.02)


def test_k_d_of_both_follows_where_both_were_measured():
    ends = {"block_scar_width": {"value": "2.35 mm", "standard_uncertainty": "10 um"}}
    ends["ring_wear_volume"] = {"value": "0.0157 mm^3", "standard_uncertainty": "0.001 mm^3"}
    fit = fit_wear(run_of(**ends), "archard", recipe=FIRST_ORDER)
    assert fit.bodies["ring"].wear_coefficient.value == pytest.approx(0.0157e-9 / (LOAD * SLID), rel=1e-9)
    alone = fit_wear(run_of(block_scar_width=ends["block_scar_width"]), "archard", recipe=FIRST_ORDER)
    block = fit.bodies["block"].wear_coefficient
    assert block.value == pytest.approx(alone.k_d.value, rel=1e-9)
    assert block.standard_uncertainty == pytest.approx(alone.k_d.standard_uncertainty, rel=1e-3)


def places(run: RawRun, code: str) -> list[str]:
    """Return where a check finds something."""
    return [one.where for one in check_run(run) if one.code == code]


@pytest.mark.parametrize(("mass", "found"), [("1 g", []), ("5 g", ["end_values of the block"])])
def test_block_worn_to_a_scar_as_wide_as_the_ring_radius_is_named(mass, found):
    """Of a scar of 17.5 mm: 444 mm³ by hand, 3.7 g of this block."""
    contact = {"kind": "block-on-ring", "block": BLOCK | {"density": "8.4 g/cm^3"}, "ring": RING}
    run = read(block_on_ring(end_values={"block_mass_loss": mass}, contact=contact))
    assert places(replace(run_of(), manifest=run), "implausible_wear") == found


@pytest.mark.parametrize(("depth", "found"), [("1 mm", []), ("2 mm", ["end_values of the ring"])])
def test_ring_worn_by_more_than_a_tenth_of_its_radius_is_named(depth, found):
    manifest = read(block_on_ring(end_values={"ring_wear_depth": depth}))
    assert places(replace(run_of(), manifest=manifest), "implausible_wear") == found


def test_ring_worn_away_is_refused():
    with pytest.raises(ManifestError, match=r"ring_wear_depth: found 18000 µm, not less than the ring radius"):
        read(block_on_ring(end_values={"ring_wear_depth": "18 mm"}))


@pytest.mark.parametrize(
    ("ring", "found"),
    [
        ({"radius": "35 mm"}, ["contact.ring.radius"]),
        ({"radius": "49.22 mm"}, ["contact.ring.radius"]),
        ({"radius": "35 mm", "diameter": "70 mm"}, []),
        ({"diameter": "17.5 mm"}, ["contact.ring.radius"]),
        ({"diameter": "34.99 mm"}, []),
        ({"radius": "17.495 mm"}, []),
        ({"radius": "30 mm"}, []),
    ],
)
def test_diameter_of_a_standard_ring_as_its_radius_is_named(ring, found):
    contact = {"kind": "block-on-ring", "block": BLOCK, "ring": without_radius(RING) | ring}
    run = replace(run_of(), manifest=read(block_on_ring(contact=contact)))
    assert places(run, "radius_or_diameter") == found


def without_radius(ring):
    return {name: value for name, value in ring.items() if name != "radius"}


def test_ring_can_be_described_by_its_diameter():
    ring = without_radius(RING) | {"diameter": {"value": "34.99 mm", "standard_uncertainty": "2 um"}}
    manifest = read(block_on_ring(contact={"kind": "block-on-ring", "block": BLOCK, "ring": ring}))
    radius = manifest.contact.ring.radius
    assert (radius.value, radius.standard_uncertainty) == (pytest.approx(17.495e-3), pytest.approx(1e-6))
    assert manifest.conditions.track_radius.value == radius.value


def test_template_may_state_the_diameter_of_a_ring_alone():
    assert problem_of({"contact.kind": "block-on-ring", "contact.ring.diameter": "34.99 mm"}) is None


@pytest.mark.parametrize(("diameter", "key"), [("35", "contact.ring.diameter"), (None, "contact.ring.radius")])
def test_ring_without_a_size_is_refused_with_its_key(diameter, key):
    ring = without_radius(RING) | ({} if diameter is None else {"diameter": diameter})
    with pytest.raises(ManifestError, match=re.escape(key)):
        read(block_on_ring(contact={"kind": "block-on-ring", "block": BLOCK, "ring": ring}))


@given(share=st.floats(1e-9, 0.999), radius=st.floats(1e-3, 0.1))
def test_segments_go_there_and_back(share, radius):
    height = share * radius
    area = segment_area(half_chord=cap_radius(height=height, sphere_radius=radius), radius=radius)
    assert segment_height(area=area, radius=radius) == pytest.approx(height, rel=1e-7)
    assert segment_height(area=-area, radius=radius) == pytest.approx(-height, rel=1e-7)
    block = BlockOnCylinder(radius, 0.01)
    assert block.worn(block.volume(height)).depth == pytest.approx(height, rel=1e-7)


def test_more_than_half_a_cylinder_is_refused():
    block = BlockOnCylinder(RADIUS, WIDTH)
    with pytest.raises(ContactError, match="more than the volume of the tip"):
        block.worn(1.01 * block.most_volume)
    with pytest.raises(ContactError, match="found a wear depth of"):
        block.volume(1.01 * RADIUS)


def test_local_wear_of_a_line_contact_is_refused():
    scenario = local_scenario(read(block_on_ring()), {"block": Quantity(value=5e-15, unit="m^2/N")})
    with pytest.raises(ContactError, match="found a block on a ring, a line contact"):
        wear_locally(scenario, [1.0, 10.0])


def test_what_was_read_goes_there_and_back():
    run = read(block_on_ring(end_values={"block_scar_width": "2 mm", "ring_mass_loss": "1 mg"}))
    assert run.end_values.pin_scar_length.value == pytest.approx(2e-3)
    stated = json.loads(run.model_dump_json(by_alias=True))
    assert "track_radius" not in stated["conditions"]
    assert stated["end_values"]["block_scar_width"]["value"] == pytest.approx(2e-3)
    assert RunManifest.model_validate(stated) == run


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"end_values": {"block_scar_diameter": "2 mm"}},
            "block_scar_diameter: found this key for a block",
        ),
        ({"end_values": {"block_scar_width": "36 mm"}}, r"block_scar_width: found .* not less than"),
        ({"end_values": {"block_scar_width": "1 mm", "pin_scar_length": "1 mm"}}, "found this key in addition to"),
        (
            {"conditions": {"normal_load": "134 N", "track_radius": "17.5 mm"}},
            r"conditions\.track_radius: found a track radius in addition to contact\.ring\.radius",
        ),
        (
            {"end_values": {"block_scar_width": "2 mm", "block_scar_length": "6.35 mm"}},
            r"block_scar_length: found a scar length; expected block_scar_width",
        ),
        (
            {"contact": {"kind": "block-on-ring", "block": BLOCK, "ring": RING | {"diameter": "17.5 mm"}}},
            r"ring\.radius: found 17\.5 mm for a ring diameter of 17\.5 mm",
        ),
        ({"contact": {"kind": "block-on-ring", "block": BLOCK, "ring": BLOCK}}, r"contact\.ring\.width: unknown key"),
    ],
)
def test_what_does_not_fit_is_refused_in_the_names_of_the_test(changes, words):
    with pytest.raises(ManifestError, match=words):
        read(block_on_ring(**changes))


PLAN = """\
schema = "tribopipe.plan/1"
[[series]]
title = "Bronze on steel in oil"
medium = "oil"
sliding_speed = { value = "361 mm/s", standard_uncertainty = "0.5 %" }
sliding_distance = "1000 m"
depth_scale = { value = 1, standard_uncertainty = "0.5 %" }
sensors = { sampling_rate = "1 Hz" }
[series.contact]
kind = "block-on-ring"
[series.contact.block]
width = "6.35 mm"
material = "bronze"
youngs_modulus = { value = "110 GPa", standard_uncertainty = "2 %" }
poisson_ratio = 0.34
[series.contact.ring]
radius = { value = "17.5 mm", standard_uncertainty = "0.1 %" }
material = "4620 steel"
youngs_modulus = { value = "210 GPa", standard_uncertainty = "2 %" }
poisson_ratio = 0.3
[[series.runs]]
id = "ring-1"
started = 2026-03-01T09:30:00+01:00
seed = 5
normal_load = { value = "134 N", standard_uncertainty = "1 %" }
wear_coefficient = "3e-9 mm^3/(N*mm)"
friction = { amplitude = 0.03, steady_state = 0.12, running_in_distance = "60 m" }
zero_offset = "1.8 um"
drift_rate = "-9 nm/min"
"""
K_D = 3e-15


@pytest.fixture
def workspace(tmp_path, run_cli, few_draws):  # noqa: ARG001 - few while it is there
    """A run of a block on a ring, simulated."""
    (tmp_path / "plan.toml").write_text(PLAN, encoding="utf-8")
    done = run_cli("simulate", ".", "--plan", "plan.toml", cwd=tmp_path)
    assert done.exit_code == 0, done.stderr
    return tmp_path


@pytest.mark.slow
def test_missing_measurement_is_that_of_the_block(workspace, run_cli):
    run = workspace / "ring-1" / "run.toml"
    replace_in(run, "(?m)^block_scar_width = .*", "")
    done = run_cli("process", "ring-1", "--no-figures", cwd=workspace)
    assert "found no post-test measurement of the block" in done.stderr
    assert title("no_post_test_measurement") == "k_D from the depth signal alone"  # whichever body it is
    drafted = run_cli("study", "new", cwd=workspace)
    assert "ring-1: excluded: missing: a post-test measurement of the block" in drafted.stderr
    planned = run_cli("plan", "ring-1", "--interval", "2 %", cwd=workspace)
    assert "found a run without a post-test measurement of the block" in planned.stderr
    assert "add what is missing" in planned.stderr


@pytest.mark.slow
def test_k_d_follows_from_the_curve(workspace, run_cli):
    assert "block_scar_width" in (workspace / "ring-1" / "run.toml").read_text(encoding="utf-8")
    done = run_cli("process", "ring-1", "--json", cwd=workspace)
    assert done.exit_code == 0, done.stderr
    fit = json.loads(done.stdout)["runs"][0]["wear_fits"]["archard"]
    found = fit["bodies"]["block"]["wear_coefficient"]
    assert (fit["engine"], fit["sensor"] is not None) == ("volume", True)
    assert abs(found["value"] - K_D) < 2.5 * found["standard_uncertainty"]
    assert found["standard_uncertainty"] < 0.05 * K_D


def test_larger_ring_that_turns_as_fast_slides_faster(run_cli, tmp_path):
    ring = SAMPLES / "peek-block-on-ring-50N"
    run = tmp_path / "ring"
    shutil.copytree(ring, run)
    replace_in(run / "run.toml", "(?m)^sliding_speed = .*", 'rotational_speed = "300 rpm"')
    words = ("predict", "--run", run, "--wear-coefficient", "1e-15 m^2/N", "--at", "100 m", "--json")
    times = []
    for size in ((), ("--radius", "35 mm")):
        done = run_cli(*words, *size, cwd=tmp_path)
        assert done.exit_code == 0, done.stderr
        times.append(json.loads(done.stdout)["prediction"][0]["time"]["value"])
    radius = read_run(ring).manifest.described.own_track_radius.value
    assert times == pytest.approx([100 / (2 * math.pi * 5 * r) for r in (radius, 35e-3)], rel=1e-6)


@pytest.mark.slow
def test_every_command_takes_a_block_on_a_ring(workspace, run_cli):
    def tribopipe(*words: object) -> str:
        done = run_cli(*words, cwd=workspace)
        assert done.exit_code == 0, done.stderr
        assert "pin_" not in done.stderr
        return done.stdout

    tribopipe("check", "ring-1")
    tribopipe("ingest", "ring-1")
    tribopipe("correct-drift", "ring-1")
    tribopipe("fit", "ring-1", "--model", "sarkar")
    tribopipe("process", "ring-1")
    assert "block" in tribopipe("predict", "ring-1", "--at", "400 m")
    tribopipe("predict", "ring-1", "--radius", "30 mm", "--at", "400 m")
    assert "ring" in tribopipe("show", "ring-1")
    assert '"block-on-ring"' in tribopipe("ls", "--json")
    tribopipe("plan", "ring-1", "--interval", "3 %")
    tribopipe("live", "ring-1", "--once")
    tribopipe("report", "ring-1")
    tribopipe("export", "csv", "ring-1", "--output", "csv")
    tribopipe("export", "dataset", "--ro-crate", "crate.zip")
    tribopipe("verify")
    tribopipe("reproduce")
    refused = run_cli("export", "umeshmotion", "ring-1", cwd=workspace)
    assert refused.exit_code == 1
    assert "a line contact" in refused.stderr

"""`tribopipe local-wear` where pin and counterbody wear: volumes, limits, check values, the archive, bad input."""

import json
from functools import cache, partial

import numpy as np
import pytest
from folders import SAMPLES
from printable import faults
from test_archive import nxcheck, run_with, step
from test_predict_both import K_1, SI3N4, folder

from tribopipe.archive.local_wear_tables import archived_local_wear, local_wear_tables
from tribopipe.archive.store import Archive
from tribopipe.base.errors import ContactError
from tribopipe.contacts import surfaces
from tribopipe.documents.manifest import RunManifest, read_manifest
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe
from tribopipe.evaluation.wear.local import LocalOptions, local_scenario, wear_locally
from tribopipe.physics.local.track import tip_on_track
from tribopipe.pipeline.stages import process, wear_archived_locally
from tribopipe.results.local_wear import LocalCurves, LocalPairPoint
from tribopipe.views.local_wear_figures import local_wear_figures

RECIPROCATING, FOUR_BALL, BLOCK = "al2o3-reciprocating-5N", "steel-four-ball-147N", "peek-block-on-ring-50N"
QUICK = LocalOptions(steps_per_decade=4)
FLAT_PIN = 'shape = "flat"\nradius = "1.5 mm"'
MM = 1e-3


@pytest.fixture(autouse=True)
def _coarse(monkeypatch):
    """Take a coarse grid."""
    monkeypatch.setattr(surfaces, "tip_on_track", partial(tip_on_track, cells=(24, 24)))


def worn(manifest: RunManifest, at: list[float], *coefficients: float, how: LocalOptions = QUICK) -> LocalCurves:
    values = (Quantity(value=k, unit="m^2/N") for k in coefficients)
    known = dict(zip(manifest.described.body_names, values, strict=False))
    return wear_locally(local_scenario(manifest, known), at, how)


@cache
def sample(run_id: str) -> RunManifest:
    return read_manifest(SAMPLES / run_id / "run.toml")[0]


@pytest.fixture
def manifest(tmp_path) -> RunManifest:
    return read_manifest(folder(tmp_path) / "run.toml")[0]


def values(point: LocalPairPoint) -> dict[str, tuple[float, float]]:
    return {name: (one.wear_depth.value, one.wear_volume.value) for name, one in point.bodies.items()}


# --- Archard's law ---


@pytest.mark.slow
@pytest.mark.parametrize(("run_id", "contacts"), [(RECIPROCATING, 1), (FOUR_BALL, 3)])
def test_each_body_loses_k_f_s_at_every_place(run_id, contacts):
    run = sample(run_id)
    load = run.described.pressed_by(run.conditions.normal_load).value
    curves = worn(run, [1.0, 100.0], 2e-16, 6e-16)
    for point in curves.result.points:
        (first, second), s = values(point).items(), point.sliding_distance.value
        assert first[1][1] == pytest.approx(2e-16 * load * s, rel=1e-9)
        assert second[1][1] == pytest.approx(contacts * 6e-16 * load * s, rel=1e-9)
    assert [first[0], second[0]] == list(run.described.body_names)
    assert curves.result.track_wear_coefficient.value == 6e-16


@pytest.mark.slow
@pytest.mark.parametrize("distance", [0.1, 10.0, 500.0])
def test_a_counterbody_that_does_not_wear_leaves_the_pin_as_rings_do(manifest, distance):
    alone, both = (worn(manifest, [distance], *known).result for known in ([K_1], [K_1, 0.0]))
    assert (alone.engine, both.engine) == ("rings", "half-space")
    (ring,), (point,) = alone.points, both.points
    (depth, volume), (groove, lost) = values(point).values()
    assert (groove, lost) == (0, 0)
    assert depth == pytest.approx(ring.wear_depth.value, rel=0.01)
    assert volume == pytest.approx(ring.wear_volume.value, rel=1e-9)
    assert not any("elastic deformation" in note for note in both.notes)
    assert [point.half_width.value, point.half_length.value] == pytest.approx([ring.contact_radius.value] * 2, rel=0.03)


# --- check values ---


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [0.1, 10, 300])
def test_deep_wear_has_the_shape_of_rigid_bodies(manifest, ratio):
    (point,) = worn(manifest, [500.0], K_1, ratio * K_1).result.points
    pin, groove, approach, half_width, half_length, section = SI3N4[ratio]
    (depth, _), (track, _) = values(point).values()
    assert [depth, track] == pytest.approx([pin * MM, groove * MM], rel=0.01)
    assert point.wear_depth.value == pytest.approx(approach * MM, rel=0.01)
    assert [point.half_width.value, point.half_length.value] == pytest.approx(
        [half_width * MM, half_length * MM], rel=0.01
    )
    assert point.bodies["disc"].track_cross_section.value == pytest.approx(section * MM**2, rel=1e-3)
    assert point.giwm_depth.value == pytest.approx(approach * MM, rel=1e-6)
    assert abs(point.difference) < 0.01


# µm, by another program on 128 × 128 points with 12 steps a decade; from one Hertzian approach on.
@pytest.mark.slow
@pytest.mark.parametrize(
    ("ratio", "distance", "pin", "groove"),
    [(10, 0.1, 0.3219, 0.00393), (10, 10.0, 3.2455, 0.12378), (300, 0.1, 0.2953, 0.10359), (300, 1.0, 0.8992, 0.54255)],
)
def test_shallow_wear_is_that_of_another_program(tmp_path, ratio, distance, pin, groove):
    # Of equal bodies, this modulus makes E_c 161.3 GPa.
    run = read_manifest(folder(tmp_path, modulus="304.0 GPa") / "run.toml")[0]
    (point,) = worn(run, [distance], K_1, ratio * K_1, how=LocalOptions(steps_per_decade=12)).result.points
    (depth, _), (track, _) = values(point).values()
    assert [1e6 * depth, 1e6 * track] == pytest.approx([pin, groove], rel=0.02)


@pytest.mark.slow
def test_a_hard_ball_cuts_a_deep_groove(tmp_path):
    pin = 'shape = "spherical"\nradius = "3 mm"'
    run = read_manifest(folder(tmp_path, pin=pin, load="5 N", path='track_radius = "6 mm"') / "run.toml")[0]
    (point,) = worn(run, [1000.0], 1e-15, 4e-13).result.points
    (depth, _), (track, _) = values(point).values()
    found = [depth, track, point.half_width.value, point.half_length.value]
    assert found == pytest.approx([0.0145437434 * MM, 0.0607353411 * MM, 0.667837979 * MM, 0.295043963 * MM], rel=0.01)


@pytest.mark.slow
def test_a_flat_pin_is_crowned_by_its_groove(tmp_path):
    run = read_manifest(folder(tmp_path, pin=FLAT_PIN, load="20 N", path='track_radius = "10 mm"') / "run.toml")[0]
    (point,) = worn(run, [2000.0], 3e-15, 8e-15).result.points
    pin, disc = point.bodies.values()
    assert pin.wear_depth.value == pytest.approx(0.0166799670 * MM, rel=0.02)
    assert pin.wear_depth_edge.value == pytest.approx(0.0188037263 * MM, rel=0.02)
    assert disc.wear_depth.value == pytest.approx(0.0021237594 * MM, rel=0.02)
    assert pin.wear_volume.value == pytest.approx(3e-15 * 20 * 2000, rel=1e-9)


@pytest.mark.slow
def test_uncertainty_is_that_of_the_engine_volume(manifest):
    known = {
        "pin": Quantity(value=K_1, unit="m^2/N", standard_uncertainty=0.1 * K_1),
        "disc": Quantity(value=10 * K_1, unit="m^2/N", standard_uncertainty=2 * K_1),
    }
    (point,) = wear_locally(local_scenario(manifest, known), [10.0], QUICK).result.points
    for name, body in point.bodies.items():
        other = point.uniform_pressure.bodies[name]
        for one, like in ((body.wear_depth, other.wear_depth), (body.wear_volume, other.wear_volume)):
            assert one.standard_uncertainty / one.value == pytest.approx(like.standard_uncertainty / like.value)
    assert point.bodies["disc"].wear_volume.standard_uncertainty > 0.2 * point.bodies["disc"].wear_volume.value


# --- command, archive and figures ---


def given_both(first: str, second: str) -> list[str]:
    return ["--wear-coefficient", f"{first}=13.5e-9 mm^2/N", "--wear-coefficient", f"{second}=135e-9 mm^2/N"]


@pytest.mark.slow
def test_people_read_both_bodies_and_why_the_engine_is_another(run_cli, tmp_path):
    told = run_cli("local-wear", folder(tmp_path), *given_both("disc", "pin"), "--at", "10 m", "--steps-per-decade", 4)
    assert told.exit_code == 0
    text = " ".join(told.stdout.split())
    assert "k_D = 1.35×10⁻⁷ mm³/(N·mm) (pin), 1.35×10⁻⁸ mm³/(N·mm) (disc)" in text
    assert "pin: wear depth" in text
    assert "disc: wear depth" in text
    assert "the disc wears as well as the pin, so that the contact is not axisymmetric: half-space engine" in text


@pytest.mark.slow
def test_both_come_back_from_the_archive_whole_and_as_nexus(bare_run, tmp_path, manifest):
    archive = Archive(tmp_path / "archive")
    archive.add(run_with(bare_run, np.arange(10.0)))
    curves = worn(manifest, [0.1, 10.0], K_1, 10 * K_1)
    made = step("local_wear_archard", curves.result)
    archive.put_step("bare", made.__class__(**{**vars(made), "tables": local_wear_tables(curves)}))
    back = archived_local_wear(archive.step("bare", "local_wear_archard"))
    assert back.result == curves.result
    assert list(back.giwm) == ["giwm"]
    for name, column in curves.track.items():
        np.testing.assert_array_equal(back.track[name], column)
    assert back.course.pressure.shape[1:] == (24, 24)
    warnings, errors, printed = nxcheck(archive.path("bare"))
    assert (warnings, errors) == (0, 0), printed


@pytest.mark.slow
def test_figures_show_the_groove(manifest):
    figures = local_wear_figures(worn(manifest, [0.1, 10.0], K_1, 10 * K_1), "both")
    labels = [ax.get_ylabel() for ax in figures["local-wear"].axes]
    assert labels == ["wear depth / µm", "groove depth / µm", "pressure p / MPa", "half-width $a_x$ / µm"]
    assert [one.get_text() for one in figures["local-wear"].legends[0].get_texts()][:2] == ["local", "uniform pressure"]
    assert np.nanmax([np.nanmax(line.get_ydata()) for line in figures["local-wear"].axes[2].lines]) < 1e5
    for name, figure in figures.items():
        assert not faults(figure), name


@pytest.mark.slow
def test_an_archived_run_wears_by_both_of_its_fitted_coefficients(tmp_path, few_draws, run_cli):  # noqa: ARG001
    archive = Archive(tmp_path / "archive")
    list(process([SAMPLES / RECIPROCATING], archive, Recipe()))
    outcome = wear_archived_locally(archive, RECIPROCATING, "archard", Recipe(), QUICK, at=[1.0, 180.0])
    fitted = archive.step(RECIPROCATING, "wear_fit_archard").result.bodies
    assert [outcome.result.wear_coefficient, outcome.result.track_wear_coefficient] == [
        fitted[name].wear_coefficient for name in ("ball", "flat")
    ]
    assert abs(outcome.result.points[-1].difference) < 0.005
    again = wear_archived_locally(archive, RECIPROCATING, "archard", Recipe(), QUICK, at=[1.0, 180.0])
    assert again.status == "unchanged"
    shown = json.loads(run_cli("show", RECIPROCATING, "--archive", archive.folder, "--json").stdout)
    assert set(shown["local_wear"]["archard"]["points"][0]["bodies"]) == {"ball", "flat"}
    assert run_cli("report", RECIPROCATING, "--archive", archive.folder, cwd=tmp_path).exit_code == 0


# --- bad input ---


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "words"),
    [
        (given_both("pin", "flat"), "found 'flat'; expected one value for the pin and one for the disc"),
        (given_both("pin", "pin"), "found two values for the pin"),
        (["--wear-coefficient", "disc=1e-9 mm^2/N"], "found no wear coefficient of the pin"),
        ([*given_both("pin", "disc"), "--engine", "rings"], "found the engine 'rings' for a pin on a counterbody that"),
        ([*given_both("pin", "disc"), "--engine", "fe"], "found the engine 'fe' for a pin on a counterbody that wears"),
        ([*given_both("pin", "disc"), "--at", "1e9 m"], "check wear coefficients, load and sliding distance"),
    ],
)
def test_bad_input_is_one_sentence(run_cli, tmp_path, options, words):
    told = run_cli("local-wear", folder(tmp_path), *options, "--at", "1 m")
    assert told.exit_code == 1
    assert words in " ".join(told.stderr.split())
    assert told.stderr.count("error: ") == 1
    assert "Traceback" not in told.output


def test_a_line_contact_has_no_local_engine(run_cli):
    told = run_cli("local-wear", SAMPLES / BLOCK, *given_both("block", "ring"), "--at", "1 m")
    assert told.exit_code == 1
    assert "found a block on a ring, a line contact" in told.stderr


def test_a_track_of_unknown_length_is_one_sentence(run_cli):
    told = run_cli("local-wear", SAMPLES / "si3n4-air-200mN", *given_both("pin", "disc"), "--at", "1 m")
    assert told.exit_code == 1
    assert "length of the wear track on the disc; add one to run.toml" in " ".join(told.stderr.split())


def test_a_pin_that_does_not_wear_is_refused(manifest):
    with pytest.raises(ContactError, match="found a pin that does not wear; expected a positive wear coefficient"):
        worn(manifest, [1.0], 0.0, K_1)

"""Wear of a pin and of its track together, by ``predict``: published check values, limits, uncertainty, bad input."""

import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from folders import SAMPLES
from hypothesis import given, settings
from hypothesis import strategies as st
from sweeps import others_slow

from tribopipe.archive.store import Archive
from tribopipe.base.errors import ContactError, FitError
from tribopipe.contacts.kinds import Terms, wear_of
from tribopipe.documents.manifest import StatedFriction, read_manifest
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe
from tribopipe.evaluation.wear.coating import worn_coatings
from tribopipe.evaluation.wear.prediction import predict_wear, wear_scenario
from tribopipe.evaluation.wear.scenario import given_wear
from tribopipe.pipeline.stages import ingest, predict_with
from tribopipe.readers.harmonize import read_run

pytestmark = pytest.mark.usefixtures("few_draws")

MM, K_1 = 1e-3, 1.35e-14
SI3N4 = {
    # k_2/k_1: pin depth, groove depth, approach, half width, half length in mm, cross-section in mm².
    0.1: (0.0233712674, 2.37804834e-5, 0.0233950479, 0.191321739, 0.191225931, 5.37147933e-6),
    1: (0.0233035236, 2.36774693e-4, 0.0235402983, 0.191905831, 0.190952720, 5.37147933e-5),
    10: (0.0226845810, 2.27431338e-3, 0.0249588944, 0.197513994, 0.188437057, 5.37147933e-4),
    60: (0.0203924148, 0.0116358510, 0.0320282658, 0.223237712, 0.178794027, 3.22288760e-3),
    300: (0.0163057319, 0.0416306776, 0.0579364095, 0.297735437, 0.160086306, 0.0161144380),
}
RUN = SAMPLES / "si3n4-air-200mN"
AT = np.array([500.0])


def folder(
    tmp_path,
    *,
    pin='shape = "spherical"\nradius = "0.794 mm"',
    load="0.2 N",
    path='track_radius = "4 mm"',
    modulus="304 GPa",
):
    """Write a run folder that has a run.toml and nothing else."""
    elastic = f'material = "Si3N4"\nyoungs_modulus = "{modulus}"\npoisson_ratio = 0.24\n'
    (tmp_path / "run.toml").write_text(
        f'schema = "tribopipe.run/1"\nid = "both"\nstarted = 2026-11-25T09:00:00+00:00\ntitle = "both"\n'
        f'instrument = "none"\n[contact]\nkind = "pin-on-disc"\n[contact.pin]\n{pin}\n{elastic}'
        f'[contact.disc]\n{elastic}[conditions]\nnormal_load = "{load}"\n{path}\n[[signals]]\nfile = "signals.csv"\n',
        encoding="utf-8",
    )
    (tmp_path / "signals.csv").write_text("sliding_distance [m]\n0\n1\n", encoding="utf-8")
    return tmp_path


@pytest.fixture
def point(run_cli, tmp_path):
    """Return the point that ``predict --json`` states of both bodies."""

    def predicted(at, k_1, k_2, **stated):
        both = [text for name, k in (("pin", k_1), ("disc", k_2)) if k is not None for text in (f"{name}={k} m^2/N",)]
        options = [part for text in both for part in ("--wear-coefficient", text)]
        found = run_cli("predict", "--run", folder(tmp_path, **stated), *options, "--at", at, "--json")
        assert found.exit_code == 0, found.stderr
        return json.loads(found.stdout)["prediction"][0]

    return predicted


def values(point, *names):
    bodies, contact = point["bodies"], point["contact"]
    flat = {"h_p": ("pin", "wear_depth"), "edge": ("pin", "wear_depth_edge"), "h_d": ("disc", "wear_depth")}
    flat |= {"section": ("disc", "track_cross_section")}
    found = {name: bodies[body][what]["value"] for name, (body, what) in flat.items() if bodies[body].get(what)}
    found |= {"D": contact["approach"]["value"], "a": contact["half_width"]["value"]}
    found |= {"b": contact["half_length"]["value"]}
    return [found[name] / (MM**2 if name == "section" else MM) for name in names]


@pytest.mark.parametrize("ratio", SI3N4)
def test_ball_and_disc_wear_as_published(point, ratio):
    found = point("500 m", K_1, ratio * K_1)
    assert values(found, "h_p", "h_d", "D", "a", "b", "section") == pytest.approx(list(SI3N4[ratio]), rel=1e-6)
    lost = [found["bodies"][body]["wear_volume"]["value"] for body in ("pin", "disc")]
    assert lost == pytest.approx([K_1 * 100, ratio * K_1 * 100], rel=1e-12)


def test_steel_ball_and_soft_disc_wear_as_published(point):
    ball = 'shape = "spherical"\nradius = "3 mm"'
    found = point("1000 m", 1e-15, 4e-13, pin=ball, load="5 N", path='track_radius = "6 mm"')
    expected = [0.0145437434, 0.0607353411, 0.667837979, 0.295043963, 0.0530516477]
    assert values(found, "h_p", "h_d", "a", "b", "section") == pytest.approx(expected, rel=1e-6)


@pytest.mark.slow
def test_a_stroke_is_the_path_of_a_reciprocating_ball(point):
    """Between very soft bodies, whose groove does not even out along the stroke, as published; else as in the test."""
    ball = 'shape = "spherical"\nradius = "3 mm"'
    stated = {"pin": ball, "load": "10 N", "path": 'stroke = "20 mm"'}
    found = point("400 m", 2e-14, 5e-14, modulus="1 kPa", **stated)
    expected = [0.0893282519, 0.0108507144, 0.768789941, 0.726629187]
    assert values(found, "h_p", "h_d", "a", "b") == pytest.approx(expected, rel=1e-6)
    stiff = point("400 m", 2e-14, 5e-14, **stated)
    assert values(stiff, "h_d")[0] / expected[1] == pytest.approx(0.984, abs=0.003)
    volumes = [one["bodies"]["disc"]["wear_volume"]["value"] for one in (found, stiff)]
    assert volumes == pytest.approx([5e-14 * 10 * 400] * 2, rel=1e-9)


@pytest.mark.parametrize("flat", ["0.1 mm", "0.3 mm"])
def test_truncated_ball_and_its_track_begin_unworn(point, flat):
    """A rounding error of the unworn flat was taken for a pin worn through."""
    pin = f'shape = "truncated-sphere"\nradius = "3 mm"\nflat_radius = "{flat}"'
    stated = {"pin": pin, "load": "10 N", "path": 'track_radius = "8 mm"'}
    assert values(point("0 m", 5e-15, 1e-13, **stated), "h_p", "h_d") == [0.0, 0.0]
    assert values(point("1000 m", 5e-15, 1e-13, **stated), "h_p")[0] > 0


def test_flat_pin_ends_crowned_as_published(point):
    pin = 'shape = "flat"\nradius = "1.5 mm"'
    found = point("2000 m", 3e-15, 8e-15, pin=pin, load="20 N", path='track_radius = "10 mm"')
    expected = [0.0188037263, 0.0188037263, 0.0166799670, 0.0021237594]
    assert values(found, "D", "edge", "h_p", "h_d") == pytest.approx(expected, rel=1e-6)


def test_pressure_is_the_load_over_the_contact(point):
    even = point("2000 m", 3e-15, 8e-15, pin='shape = "flat"\nradius = "1.5 mm"', load="20 N")
    assert even["contact"]["mean_pressure"]["value"] == pytest.approx(20 / (math.pi * 2.25e-6), rel=1e-12)


def test_a_ball_that_does_not_wear_leaves_its_own_shape(point):
    found = point("500 m", None, 60 * K_1)
    h_d, half, section = values(found, "h_d", "a", "section")
    radius = 0.794
    assert half == pytest.approx(math.sqrt(h_d * (2 * radius - h_d)), rel=1e-9)
    angle = math.asin(half / radius)
    assert section == pytest.approx(radius**2 * (angle - math.sin(angle) * math.cos(angle)), rel=1e-6)
    assert found["bodies"]["pin"]["wear_volume"]["value"] == 0


# --- as a scenario ---


def known(pin=K_1, disc=60 * K_1, spread=0.1):
    both = {"pin": pin, "disc": disc}
    return {
        name: Quantity(value=k, unit="m^2/N", standard_uncertainty=spread * k)
        for name, k in both.items()
        if k is not None
    }


@pytest.fixture(scope="module")
def manifest(tmp_path_factory):
    return read_manifest(folder(tmp_path_factory.mktemp("both")) / "run.toml")[0]


def scenario(manifest, law="archard", **coefficients):
    return wear_scenario(manifest, given_wear(manifest.described, known(**coefficients), Recipe()), law)


def test_engine_is_named_where_both_wear(manifest):
    found = predict_wear(scenario(manifest), [500.0])
    assert (found.engine, list(found.bodies)) == ("volume", ["pin", "disc"])
    assert any("wear volume of each body" in note for note in found.notes)


def test_a_body_without_a_k_d_is_said_to_be_taken_as_unworn(manifest):
    alone = predict_wear(scenario(manifest, pin=None), [500.0]).notes
    assert any("the pin is assumed to be unworn" in note for note in alone)
    assert not any("unworn" in note for note in predict_wear(scenario(manifest), [500.0]).notes)


def test_first_order_uncertainty_is_that_of_draws(manifest):
    one = scenario(manifest)
    rng, at = np.random.default_rng(7), np.array([500.0])
    drawn = {
        name: (given.quantity.value + given.spread * rng.standard_normal(4000))[:, None]
        for name, given in one.inputs.items()
    }
    state = one.worn(at, {name: np.abs(column) for name, column in drawn.items()})
    for name, spread in one.uncertainties(at).items():
        assert float(spread[0]) == pytest.approx(float(np.std(state[name])), rel=0.08), name


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "share"), [("sarkar", 3 * 0.5 * 0.1 / 1.75), ("dissipated_energy", 0.2), ("archard", 0)]
)
def test_uncertainty_of_stated_friction_is_that_of_what_it_wears(manifest, law, share):
    """S of Sarkar's law is s·√(1 + 3b²), so that u(S)/S = 3b·u(b)/(1 + 3b²); friction work goes with b."""

    def spread(of_steady_state: float | None) -> float:
        told = StatedFriction(
            amplitude=Quantity(value=0.0, unit="1"),
            steady_state=Quantity(value=0.5, unit="1", standard_uncertainty=of_steady_state),
            running_in_distance=Quantity(value=20.0, unit="m"),
        )
        one = wear_scenario(manifest, given_wear(manifest.described, known(), Recipe()), law, told)
        return float(one.uncertainties(AT)["pin_volume"][0] / one.worn(AT)["pin_volume"][0])

    assert math.sqrt(max(0.0, spread(0.1) ** 2 - spread(None) ** 2)) == pytest.approx(share, rel=1e-3, abs=1e-6)


@pytest.mark.slow
@settings(max_examples=30, deadline=None)
@given(st.floats(-3, 3), st.floats(0.5, 1000.0))
def test_rate_is_the_slope_of_the_depth(manifest, power, place):
    one = scenario(manifest, disc=K_1 * 10**power)
    step = place * np.array([1 - 1e-4, 1.0, 1 + 1e-4])
    state = one.worn(step)
    slope = (state["wear_depth"][2] - state["wear_depth"][0]) / (step[2] - step[0])
    assert float(one.rate(step)[1]) == pytest.approx(float(slope), rel=1e-5)
    assert np.all(np.diff(state["approach"]) > 0)


def test_disc_of_zero_wear_is_the_pin_by_volume(manifest):
    both = predict_wear(scenario(manifest, disc=0.0), [500.0]).prediction[0]
    alone = wear_of(manifest.described, Terms(engine="volume"))
    values = {**scenario(manifest).values, "pin_modulus": 3e11, "disc_modulus": 3e11}
    depth = float(alone.worn(values, np.array([500.0]))["wear_depth"][0])
    assert both.bodies["pin"].wear_depth.value == pytest.approx(depth, rel=1e-9)
    assert both.bodies["disc"].wear_depth.value == 0


# --- elastic start ---


def local(manifest, **k):
    recipe = Recipe.model_validate({"wear": {"engine": "local"}})
    return wear_scenario(manifest, given_wear(manifest.described, known(**k), recipe), recipe=recipe)


@pytest.mark.slow
@pytest.mark.parametrize(("pin", "disc", "body"), [(K_1, 60 * K_1, "pin"), (K_1, 0.0, "pin"), (None, 60 * K_1, "disc")])
@pytest.mark.parametrize(
    ("engine", "depth"), others_slow([("volume", 5e-6), ("local", 5e-6), ("local", 0.1e-6)], ("volume", 5e-6))
)
def test_a_depth_is_reached_where_it_is_predicted(manifest, pin, disc, body, engine, depth):
    one = scenario(manifest, pin=pin, disc=disc) if engine == "volume" else local(manifest, pin=pin, disc=disc)
    reached = predict_wear(one, depths=[depth]).reached[0]
    back = predict_wear(one, [reached.sliding_distance.value]).prediction[0]
    assert back.bodies[body].wear_depth.value == pytest.approx(depth, rel=1e-7)
    rate = float(one.rate(np.array([reached.sliding_distance.value]))[0])
    spread = back.bodies[body].wear_depth.standard_uncertainty / rate
    assert reached.sliding_distance.standard_uncertainty == pytest.approx(spread, rel=1e-3)


def test_local_pressure_makes_shallow_wear_shallower_and_deep_wear_no_different(manifest):
    # Local wear at every point, on 128 × 128 points: 0.32245 and 0.0039336 µm after 0.1 m, κb = 0.006.
    tens = {"pin": K_1, "disc": 10 * K_1}
    early, late = predict_wear(local(manifest, **tens), [0.1, 500.0]).prediction
    assert early.bodies["pin"].wear_depth.value == pytest.approx(0.32245e-6, rel=1e-2)
    assert early.bodies["disc"].wear_depth.value == pytest.approx(0.0039336e-6, rel=1e-2)
    rigid = predict_wear(scenario(manifest, **tens), [500.0]).prediction[0]
    for body in ("pin", "disc"):
        assert late.bodies[body].wear_depth.value == pytest.approx(rigid.bodies[body].wear_depth.value, rel=1e-4)
        assert late.bodies[body].wear_volume.value == rigid.bodies[body].wear_volume.value
    assert not elastic(predict_wear(local(manifest, **tens), [0.01]))


def test_moduli_count_only_where_the_contact_is_elastic(manifest):
    assert {"pin_modulus", "disc_modulus"} <= local(manifest).inputs.keys()
    assert not {"pin_modulus", "disc_modulus"} & scenario(manifest).inputs.keys()


def test_local_pressure_of_a_truncated_ball_is_refused(manifest):
    pin = manifest.contact.pin.model_copy(update={"flat_radius": Quantity(value=1e-5, unit="m")})
    truncated = manifest.model_copy(update={"contact": manifest.contact.model_copy(update={"pin": pin})})
    with pytest.raises(ContactError, match="found a truncated sphere with a flat of 10 µm"):
        predict_wear(local(truncated), [1.0])


# --- bad input ---


def test_giwm_knows_no_wear_of_the_disc(manifest):
    recipe = Recipe.model_validate({"wear": {"engine": "giwm"}})
    with pytest.raises(FitError, match="engine giwm, which computes only the wear of the pin"):
        given_wear(manifest.described, known(), recipe)


def test_a_track_of_unknown_length_is_asked_for(manifest):
    unknown = manifest.model_copy(
        update={"conditions": manifest.conditions.model_copy(update={"track_radius": None, "stroke": None})}
    )
    with pytest.raises(ContactError, match="neither track_radius nor stroke"):
        predict_wear(scenario(unknown), [500.0])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("pin", "disc"),
    others_slow([(K_1, 1e5 * K_1), (1e5 * K_1, 0.0), (None, 1e6 * K_1), (1e6 * K_1, 1e7 * K_1)]),
)
def test_a_groove_deeper_than_the_ball_is_refused(manifest, pin, disc):
    with pytest.raises(ContactError, match="less than the tip height"):
        predict_wear(scenario(manifest, pin=pin, disc=disc), [500.0])


def test_a_depth_beyond_the_tip_is_refused(manifest):
    with pytest.raises(ContactError, match="less than the tip height"):
        predict_wear(scenario(manifest), depths=[0.7e-3])


def test_a_track_shorter_than_the_contact_is_warned_of(manifest):
    short = Quantity(value=0.3e-3, unit="m")
    found = predict_wear(replace(scenario(manifest, disc=K_1), path=short), [500.0])
    assert any("never leave the contact" in note for note in found.notes)


@pytest.mark.slow
def test_a_coating_that_is_worn_through_is_warned_of(manifest):
    film = {"coating_thickness": Quantity(value=10e-6, unit="m")}
    disc = manifest.contact.disc.model_copy(update=film)
    coated = manifest.model_copy(update={"contact": manifest.contact.model_copy(update={"disc": disc})})
    deep, shallow = (predict_wear(scenario(coated), [place]).notes for place in (500.0, 100.0))
    assert any(
        "a wear depth of 11.6" in note and "on the disc" in note and "more than its coating thickness of 10 µm" in note
        for note in deep
    )
    assert not any("coating" in note for note in shallow)


@pytest.mark.slow
@pytest.mark.parametrize("body", ["pin", "disc"])
def test_the_place_at_which_a_coating_is_worn_through_is_where_the_wear_is_as_deep(manifest, body):
    film = {"coating_thickness": Quantity(value=8e-6, unit="m", standard_uncertainty=0.0)}
    coated = {body: getattr(manifest.contact, body).model_copy(update=film)}
    asked = scenario(manifest.model_copy(update={"contact": manifest.contact.model_copy(update=coated)}))
    (worn,) = worn_coatings(asked, 500.0)
    assert worn.body == body
    (there,) = predict_wear(asked, [worn.place.value]).prediction
    assert there.bodies[body].wear_depth.value == pytest.approx(8e-6, rel=1e-6)
    (note,) = [note for note in predict_wear(asked, [500.0]).notes if "coating" in note]
    assert f"exceeded from {worn.place.shown('m')} on" in note
    if body == "pin":
        (reached,) = predict_wear(asked, depths=[8e-6]).reached
        assert worn.place.value == pytest.approx(reached.sliding_distance.value, rel=1e-6)
        assert worn.place.u == pytest.approx(reached.sliding_distance.u, rel=1e-3)


def elastic(prediction):
    return [note for note in prediction.notes if "elastic deformation is neglected" in note]


@pytest.mark.slow
def test_a_scar_as_small_as_the_elastic_contact_is_warned_of(manifest):
    # By local wear, these depths are 12 and 6 % less after 0.01 m, and 1.2 and 0.5 % after 0.15 m.
    (early,) = elastic(predict_wear(scenario(manifest), [0.01]))
    assert early.startswith("warning: found a contact 26.06 µm wide and 25.54 µm long after wear, compared with 18.08 ")
    assert "the wear depth is overestimated by about 13 % for the pin and 7 % for the disc" in early
    assert not elastic(predict_wear(scenario(manifest), [0.15]))
    (groove,) = elastic(predict_wear(scenario(manifest, pin=0.0), [0.01]))
    assert re.search(r"the wear depth is overestimated by about \d+ % for the disc;", groove)
    assert not elastic(predict_wear(scenario(manifest, pin=0.0), [500.0]))
    truncated = manifest.contact.pin.model_copy(update={"flat_radius": Quantity(value=1e-5, unit="m")})
    contact = manifest.contact.model_copy(update={"pin": truncated})
    assert not elastic(predict_wear(scenario(manifest.model_copy(update={"contact": contact})), [0.01]))


@pytest.mark.slow
def test_a_stroke_that_is_short_for_its_groove_is_warned_of(tmp_path):
    ball = 'shape = "spherical"\nradius = "3 mm"'
    short = read_manifest(folder(tmp_path, pin=ball, load="10 N", path='stroke = "10 mm"') / "run.toml")[0]
    wearing = {"pin": 2e-14, "disc": 5e-14}

    def warned(manifest, **coefficients):
        notes = predict_wear(scenario(manifest, **{**wearing, **coefficients}), [400.0]).notes
        return [note for note in notes if "found a stroke of" in note]

    (note,) = warned(short)
    assert "found a stroke of 10 mm, 13 times the half-width of the wear track" in note
    assert "the wear depths at mid-stroke are overestimated by up to 4 %" in note
    assert not warned(short, disc=0.0)
    long = read_manifest(folder(tmp_path, pin=ball, load="10 N", path='stroke = "60 mm"') / "run.toml")[0]
    circle = read_manifest(folder(tmp_path, pin=ball, load="10 N", path='track_radius = "4 mm"') / "run.toml")[0]
    assert not warned(long)
    assert not warned(circle)


@pytest.mark.parametrize("coefficients", [{"pin": 2e-14}, {"pin": 2e-14, "disc": 5e-14}])
def test_a_stroke_within_the_contact_is_one_finding(tmp_path, coefficients):
    ball = 'shape = "spherical"\nradius = "3 mm"'
    short = read_manifest(folder(tmp_path, pin=ball, load="10 N", path='stroke = "0.3 mm"') / "run.toml")[0]
    notes = predict_wear(scenario(short, **{"disc": 0.0, **coefficients}), [400.0]).notes
    (note,) = [one for one in notes if one.startswith("warning")]
    assert note.startswith("warning: found a stroke of 0.3 mm, not longer than the contact of 1.")
    assert "both bodies never leave the contact (fretting)" in note
    assert "do not use the wear depths; the wear volumes, k_D·F_N·s, remain valid" in note


def test_published_scheme_is_refused(manifest):
    with pytest.raises(ContactError, match="published scheme"):
        predict_wear(scenario(manifest), [500.0], scheme="published")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("ball=1e-14 m^2/N",), "'ball'"),
        (("pin=1e-14 m^2/N", "pin=1e-14 m^2/N"), "found two values for the pin"),
        (("1e-14 m^2/N", "1e-14 m^2/N"), "too many values"),
        (("disc=1e-14 N",), "the unit 'N'"),
    ],
)
def test_coefficients_are_of_bodies_of_the_contact(run_cli, tmp_path, options, words):
    given_ = [part for text in options for part in ("--wear-coefficient", text)]
    found = run_cli("predict", "--run", folder(tmp_path), *given_, "--at", "1 m")
    assert found.exit_code in (1, 2)
    assert words in " ".join(found.stderr.split())


def test_people_read_both_bodies(run_cli, tmp_path):
    both = ("--wear-coefficient", "pin=1.35e-8 mm^2/N", "--wear-coefficient", "disc=81e-8 mm^2/N")
    found = run_cli("predict", "--run", folder(tmp_path), *both, "--at", "500 m")
    assert found.exit_code == 0
    assert "pin wear depth 20.39" in found.stdout
    assert "disc wear depth 11.64" in found.stdout


@pytest.mark.parametrize(("newtons", "note"), [(0.05, False), (0.8, False), (2.0, "10 times"), (0.01, "0.05 times")])
def test_a_load_far_from_that_of_k_d_is_named(newtons, note):
    manifest, *_ = read_manifest(RUN / "run.toml")
    load = Quantity(value=newtons, unit="N", standard_uncertainty=0.01 * newtons)
    k_d = Quantity(value=K_1, unit="m^2/N", standard_uncertainty=0.01 * K_1)
    known = given_wear(manifest.described, {"pin": k_d}, Recipe())
    scenario = wear_scenario(manifest, known, normal_load=load)
    fitted = predict_wear(scenario, [100.0], reference_load=manifest.conditions.normal_load)
    found = [one for one in fitted.notes if one.startswith("extrapolation: the load is")]
    assert [note in one for one in found] == ([True] if note else [])
    assert not any("the load is" in one for one in predict_wear(scenario, [100.0]).notes)


@pytest.mark.slow
def test_an_impossible_prediction_names_the_run_whose_k_d_it_is(tmp_path):
    strokes = SAMPLES / "al2o3-reciprocating-5N"
    archive = Archive(tmp_path / "archive")
    ingest(strokes, archive)
    contact = read_run(strokes).manifest.described
    stated = {name: Quantity(value=1e-8, unit="m^2/N") for name in ("ball", "flat")}
    with pytest.raises(ContactError, match=r" \(in the prediction with the k_D from another-run\); check both runs"):
        predict_with(archive, strokes.name, "another-run", "archard", given_wear(contact, stated, Recipe()), Recipe())


@pytest.mark.parametrize(
    ("recorded", "reference", "share"),
    [
        ("friction coefficient", "another-run", 0.1),
        ("friction coefficient", "both", 0.0),
        ("sliding_distance [m]", "another-run", 0.0),
    ],
)
def test_an_archived_prediction_is_as_uncertain_as_the_distance_of_its_run(tmp_path, recorded, reference, share):
    """Depth k_D·F_N·s/πr² of a flat pin: shares of its factors in quadrature, without s by k_D of the run itself."""
    pin = 'shape = "flat"\nradius = "3 mm"'
    speed = 'sliding_speed = { value = "1 m/s", standard_uncertainty = "10 %" }'
    run = folder(tmp_path, pin=pin, load="50 N", path=speed)
    (run / "signals.csv").write_text(f"time [s],{recorded}\n0,0\n1000,1000\n2000,2000\n", encoding="utf-8")
    archive = Archive(tmp_path / "archive")
    ingest(run, archive)
    k_d = Quantity(value=6.4e-15, unit="m^2/N", standard_uncertainty=0.04 * 6.4e-15)
    known = given_wear(read_run(run).manifest.described, {"pin": k_d}, Recipe())
    (point,) = predict_with(archive, "both", reference, "archard", known, Recipe()).result.prediction
    depth = point.bodies["pin"].wear_depth
    assert depth.value == pytest.approx(6.4e-15 * 50 * 2000 / (math.pi * 3e-3**2), rel=1e-9)
    assert depth.standard_uncertainty / depth.value == pytest.approx(math.hypot(0.04, 0.01, 2 * 0.002, share), rel=1e-4)

"""k_D of bodies by the volumes that they have lost: by hand, under any law, uncertain as it is, and where none is."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from end_value_runs import CIRCLE, RADIUS, described, run_of, si
from folders import SAMPLES
from sweeps import others_slow

from tribopipe.documents.manifest import read_manifest
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import MonteCarloRecipe, Recipe
from tribopipe.evaluation.friction import fit_friction
from tribopipe.evaluation.measurements.specific_wear import specific_wear
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.evaluation.wear.prediction import fitted_curves, predict_wear, run_scenario
from tribopipe.evaluation.wear.scenario import known_wear
from tribopipe.physics.friction_path import ExponentialFriction
from tribopipe.physics.pin_on_track import SphereOnTrack
from tribopipe.readers.harmonize import read_run

FIRST_ORDER = Recipe(monte_carlo=MonteCarloRecipe(significant_digits=0))
PIN, DISC, LOAD, SLID = 2e-12, 6e-12, 0.2, 500.0


def run_with(*, path=CIRCLE, **lost):
    """A run without a depth signal, its bodies weighed or measured after it."""
    given = {"pin": (PIN, 0.03), "disc": (DISC, 0.04), **lost}
    end = {f"{body}_wear_volume": si(v[0], "m^3", v[1] * v[0]) for body, v in given.items() if v is not None}
    return run_of(described(conditions={"normal_load": si(LOAD, "N", 0.002), **path}, **end))


def coefficients(fit):
    return {name: body.wear_coefficient.value for name, body in fit.bodies.items()}


def test_k_d_is_the_volume_over_load_and_distance():
    fit = fit_wear(run_with(), "archard", recipe=FIRST_ORDER)
    by_hand = {"pin": PIN / (LOAD * SLID), "disc": DISC / (LOAD * SLID)}
    assert coefficients(fit) == pytest.approx(by_hand, rel=1e-12)
    assert (fit.engine, fit.basis, fit.outcome) == ("volume", "measurement", "fitted")
    pin, disc = (math.hypot(share, 0.01) for share in (0.03, 0.04))
    for body, share in (("pin", pin), ("disc", disc)):
        found = fit.bodies[body].wear_coefficient
        assert found.standard_uncertainty == pytest.approx(share * found.value, rel=1e-3)
    assert fit.correlation == pytest.approx(0.01**2 / (pin * disc), rel=1e-3)
    assert any("whether the law holds" in note for note in fit.notes)


@pytest.mark.parametrize("alone", ["pin", "disc"])
def test_one_body_is_enough(alone):
    other = {"pin": "disc", "disc": "pin"}[alone]
    fit = fit_wear(run_with(**{other: None}), "archard", recipe=FIRST_ORDER)
    assert list(fit.bodies) == [alone]
    assert fit.k_d.value == pytest.approx({"pin": PIN, "disc": DISC}[alone] / (LOAD * SLID), rel=1e-12)


def test_sarkars_distance_is_that_of_the_friction():
    run = run_with()
    friction = 0.5 + 0.2 * np.exp(-run.sliding_distance / 40.0)
    columns = {**run.columns, "friction_coefficient": friction}
    run = replace(run, columns=columns, origins=dict.fromkeys(columns, "measured"))
    fit = fit_wear(run, "sarkar", fit_friction(run), FIRST_ORDER)
    effective = ExponentialFriction(0.2, 0.5, 40.0)
    s = np.linspace(0, SLID, 200_001)
    distance = np.trapezoid(np.sqrt(1 + 3 * effective.coefficient(s) ** 2), s)
    assert coefficients(fit)["disc"] == pytest.approx(DISC / (LOAD * distance), rel=1e-6)


def test_interval_of_draws_is_that_of_the_quotient():
    fit = fit_wear(run_with(), "archard")
    rng = np.random.default_rng(5)
    k = DISC * (1 + 0.04 * rng.standard_normal(400_000)) / (LOAD * (1 + 0.01 * rng.standard_normal(400_000)) * SLID)
    low, high = (end.value for end in fit.bodies["disc"].interval)
    assert [low, high] == pytest.approx(np.quantile(k, [0.025, 0.975]), rel=0.01)


def test_a_depth_that_gives_the_volume_does_as_well():
    """A scar on a disc that does not wear: the cap, as the specific wear rate has it."""
    run = run_of(described(conditions={"normal_load": si(LOAD, "N")}, pin_scar_diameter=si(0.2e-3, "m", 1e-6)))
    height = RADIUS - math.sqrt(RADIUS**2 - 0.1e-3**2)
    cap = math.pi * height**2 * (3 * RADIUS - height) / 3
    assert fit_wear(run, "archard", recipe=FIRST_ORDER).k_d.value == pytest.approx(cap / (LOAD * SLID), rel=1e-9)


SCAR = {"pin_scar_length": si(0.59e-3, "m", 5e-6)}


def of_materials(pin, disc, path=CIRCLE, **end):
    run = run_of(described(conditions={"normal_load": si(LOAD, "N"), **path}, **end))
    contact = run.manifest.contact
    bodies = {
        name: contact.bodies[name].model_copy(update={"material": one}) for name, one in (("pin", pin), ("disc", disc))
    }
    return replace(run, manifest=run.manifest.model_copy(update={"contact": contact.model_copy(update=bodies)}))


def unseen(fit):
    return {finding.severity for finding in fit.findings if finding.code == "disc_not_measured"}


@pytest.mark.parametrize(("disc", "severity"), [("steel", "warning"), ("Al2O3", "note")])
def test_a_scar_on_a_disc_that_nobody_measured_does_not_give_a_sure_volume(disc, severity):
    """On a soft disc the scar lies in a groove, and the ball has lost more than the cap, perhaps several times."""
    fit = fit_wear(of_materials("Al2O3", disc, **SCAR), recipe=FIRST_ORDER)
    relative = fit.k_d.standard_uncertainty / fit.k_d.value
    assert unseen(fit) == {severity}
    assert 0.05 < relative < 0.07
    known = fit_wear(of_materials("Al2O3", disc, **SCAR, disc_wear_depth=si(0.0, "m", 2e-8)), recipe=FIRST_ORDER)
    assert unseen(known) == set()
    pin = known.bodies["pin"].wear_coefficient
    assert pin.value == pytest.approx(fit.k_d.value, rel=0.01)
    assert pin.standard_uncertainty < 0.8 * fit.k_d.standard_uncertainty


def test_a_track_as_wide_as_a_scar_of_unknown_direction_leaves_the_groove_unknown():
    """Both are the width of the scar, however deep the groove is; beside the length, they leave no groove."""
    across = {"pin_scar_diameter": si(0.59e-3, "m", 5e-6)}
    for wide, severities in ((0.588e-3, {"warning"}), (0.593e-3, {"warning"}), (0.68e-3, set())):
        width = {"disc_track_width": si(wide, "m", 5e-6)}
        assert unseen(fit_wear(of_materials("Al2O3", "steel", **across, **width), recipe=FIRST_ORDER)) == severities
    width = {"disc_track_width": si(0.588e-3, "m", 5e-6)}
    assert unseen(fit_wear(of_materials("Al2O3", "steel", **SCAR, **width), recipe=FIRST_ORDER)) == set()


@pytest.mark.parametrize(
    "end", [{"pin_wear_volume": si(PIN, "m^3", 0.03 * PIN)}, {**SCAR, "pin_scar_width": si(0.6e-3, "m", 5e-6)}]
)
def test_a_volume_and_both_axes_of_a_scar_need_no_look_at_the_disc(end):
    assert unseen(fit_wear(of_materials("Al2O3", "steel", **end), recipe=FIRST_ORDER)) == set()


# --- with a depth signal ---


def sample(*, track=True, **ends):
    """The sample run on a circle of 4 mm, or of unknown radius, with these post-test measurements for its own."""
    manifest, _ = read_manifest(SAMPLES / "si3n4-air-200mN" / "run.toml")
    run = read_run(SAMPLES / "si3n4-air-200mN")
    stated = {**manifest.model_dump(mode="json", exclude_unset=True), "end_values": ends}
    stated["conditions"].pop("track_radius", None)
    stated["conditions"] |= {"track_radius": si(4e-3, "m", 1e-5)} if track else {}
    return replace(run, manifest=type(manifest).model_validate(stated))


SCAR = {"pin_scar_diameter": si(383.672e-6, "m", 2e-6)}


@pytest.mark.slow
def test_disc_that_wears_has_a_k_d_beside_that_of_the_pin():
    fit = fit_wear(sample(**SCAR, disc_wear_depth=si(2.5e-6, "m", 5e-8)), recipe=FIRST_ORDER)
    assert (list(fit.bodies), fit.engine) == (["pin", "disc"], "volume")
    tip = SphereOnTrack(RADIUS)
    groove = tip.at_depths(fit.bodies["pin"].fitted_end_depth.value, 2.5e-6).groove_area
    by_hand = 2 * math.pi * 4e-3 * float(groove) / (LOAD * SLID)
    assert coefficients(fit)["disc"] == pytest.approx(by_hand, rel=0.02)
    assert 0 < fit.correlation < 1


@pytest.mark.slow
def test_disc_that_hardly_wears_has_none():
    fit = fit_wear(sample(**SCAR, disc_wear_depth=si(115e-9, "m", 2e-8)), recipe=FIRST_ORDER)
    assert (list(fit.bodies), fit.engine) == (["pin"], "giwm")


@pytest.mark.slow
@pytest.mark.parametrize("pin", [SCAR, {}])
def test_a_track_of_unknown_length_is_no_unworn_disc_beside_a_depth_signal(pin):
    run = sample(**pin, disc_wear_volume=si(4e-11, "m^3", 1e-12), track=False)
    fit = fit_wear(run, recipe=FIRST_ORDER)
    assert "track_length_unknown" in {finding.code for finding in fit.findings}
    assert list(fit.bodies) == ["pin", "disc"]
    assert "unseen groove" in {line.name for line in fit.bodies["pin"].budget}
    assert coefficients(fit)["disc"] == pytest.approx(4e-11 / (LOAD * SLID), rel=1e-3)
    assert "track_depth" not in fitted_curves(run, fit).bands


@pytest.mark.slow
def test_reading_of_pin_and_disc_is_not_taken_for_the_pin_alone():
    """A hard ball on a soft disc: the depth sensor reads the groove."""
    fit = fit_wear(sample(disc_wear_depth=si(15e-6, "m", 2e-7)), recipe=FIRST_ORDER)
    unworn = fit_wear(sample(disc_wear_depth=si(0.0, "m", 2e-8)), recipe=FIRST_ORDER)
    assert coefficients(fit)["pin"] < 0.4 * coefficients(unworn)["pin"]
    fit = fit_wear(sample(disc_wear_depth=si(24e-6, "m", 2e-7)), recipe=FIRST_ORDER)
    assert list(fit.bodies) == ["disc"]
    fit = fit_wear(sample(disc_wear_volume=si(0.12e-9, "m^3", 4e-12)), recipe=FIRST_ORDER)
    assert coefficients(fit)["disc"] == pytest.approx(0.12e-9 / (LOAD * SLID), rel=1e-3)


def read_of_both(k_pin, k_disc, seed, drift=250e-9, path=2 * math.pi * 4e-3):
    """A run of which the sensor reads both bodies, with drift, noise and scale, and only the groove was measured."""
    rng = np.random.default_rng(seed)
    by = iter(1 + np.array([0.01, 0.01, 0.002, 0.005, 0.01]) * rng.standard_normal(5))
    distance, load = np.linspace(0, SLID, 1001), LOAD * next(by)
    tip = SphereOnTrack(RADIUS * next(by))
    worn = tip.worn(k_pin * load * distance, k_disc * load * distance / (path * next(by)))
    read = next(by) * (worn.pin_depth + worn.groove_depth)
    read = read + drift * rng.standard_normal() * distance / SLID + 30e-9 * rng.standard_normal(distance.size)
    groove = float(worn.groove_depth[-1])
    conditions = {"normal_load": si(LOAD, "N", 0.01 * LOAD), "track_radius": si(4e-3, "m", 4e-5)}
    run = run_of(described(conditions=conditions, disc_wear_depth=si(groove * next(by), "m", 0.01 * groove)))
    columns = {**run.columns, "depth": np.asarray(read)}
    return replace(run, columns=columns, origins=dict.fromkeys(columns, "measured"))


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [10, 200])
def test_reading_and_groove_give_k_d_of_both(ratio):
    k_pin = 1.35e-14
    fit = fit_wear(read_of_both(k_pin, ratio * k_pin, seed=ratio), recipe=FIRST_ORDER)
    for body, true in (("pin", k_pin), ("disc", ratio * k_pin)):
        found = fit.bodies[body].wear_coefficient
        assert found.standard_uncertainty < 0.08 * found.value
        assert abs(found.value - true) < 3 * found.standard_uncertainty, body
    (warned,) = (finding for finding in fit.findings if finding.code == "no_post_test_measurement")
    assert "based on the depth signal minus the wear depth of the disc" in warned.message


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "drift"), others_slow([(1, 250e-9), (6, 2e-6)]))
def test_a_ball_that_does_not_wear_gets_no_k_d_by_reading_and_groove(seed, drift):
    """Not even where the sensor drifts more than anybody expects."""
    fit = fit_wear(read_of_both(0.0, 1.35e-12, seed, drift), recipe=FIRST_ORDER)
    assert list(fit.bodies) == ["disc"]
    found = fit.k_d
    assert found.standard_uncertainty < 0.08 * found.value
    assert abs(found.value - 1.35e-12) < 3 * found.standard_uncertainty


@pytest.mark.slow
def test_curve_follows_the_wear_of_both():
    run = sample(**SCAR, disc_wear_depth=si(2.5e-6, "m", 5e-8))
    fit = fit_wear(run, recipe=FIRST_ORDER)
    band = fitted_curves(run, fit).bands["wear_depth"]
    assert band.best[-1] == pytest.approx(fit.bodies["pin"].fitted_end_depth.value, rel=1e-4)
    assert np.all(band.lower <= band.best)


# --- where there is none ---


def test_no_volume_is_reported_as_before():
    fit = fit_wear(run_with(pin=None, disc=None), "archard", recipe=FIRST_ORDER)
    assert (fit.outcome, fit.missing) == ("not fitted", ("a depth signal",))


def test_sarkars_law_asks_for_friction():
    assert fit_wear(run_with(), "sarkar", recipe=FIRST_ORDER).missing == ("a friction signal",)


@pytest.mark.slow
def test_a_body_that_lost_nothing_has_none():
    assert list(fit_wear(run_with(pin=(0.0, 0.0)), "archard", recipe=FIRST_ORDER).bodies) == ["disc"]


@pytest.mark.parametrize("lost", [0.0, -1e-12, -4e-12])
def test_no_wear_and_a_gain_within_the_uncertainty_are_a_k_d_with_its_sign(lost):
    end = {"pin_wear_volume": si(lost, "m^3", 3e-12)}
    run = run_of(described(conditions={"normal_load": si(LOAD, "N", 0.0)}, **end))
    for recipe in (FIRST_ORDER, Recipe()):
        pin = fit_wear(run, "archard", recipe=recipe).first
        k, spread = lost / (LOAD * SLID), 3e-12 / (LOAD * SLID)
        assert pin.wear_coefficient.value == pytest.approx(k, rel=1e-12)
        assert pin.wear_coefficient.standard_uncertainty == pytest.approx(spread, rel=0.02)
        ends = [end.value for end in pin.interval]
        assert ends == pytest.approx([k - 1.96 * spread, k + 1.96 * spread], rel=0.03)


def test_a_track_of_unknown_length_gives_k_d_of_both_bodies_from_their_volumes():
    """V/(F_N·S) needs no length of the track."""
    known, unknown = (fit_wear(run_with(path=path), "archard", recipe=FIRST_ORDER) for path in (CIRCLE, {}))
    assert coefficients(unknown) == pytest.approx(coefficients(known), rel=1e-12)
    assert not unknown.findings


LENGTH = {"pin_scar_length": si(0.59e-3, "m", 5e-6)}
LOST = {"disc_wear_volume": si(1e-10, "m^3", 3e-12)}


@pytest.mark.parametrize("way", ["pin_scar_length", "pin_scar_diameter", "pin_wear_depth"])
def test_a_groove_of_unknown_depth_is_no_unworn_disc(way):
    """Without the length of the track a lost volume is a groove of unknown depth, which nobody has seen."""
    pin = {way: si(14.5e-6, "m", 1e-7) if way == "pin_wear_depth" else si(0.2e-3, "m", 2e-6)}
    conditions = {"normal_load": si(LOAD, "N")}
    lost, unmeasured = (
        fit_wear(run_of(described(conditions=conditions, **pin, **disc)), recipe=FIRST_ORDER) for disc in (LOST, {})
    )
    (found,) = [finding for finding in lost.findings if finding.code == "track_length_unknown"]
    assert found.severity == "warning"
    assert "conditions.track_radius" in found.where
    assert "track_radius" in found.remedy
    assert "stroke" in found.remedy
    assert list(lost.bodies) == ["pin", "disc"]
    pin_k = lost.bodies["pin"].wear_coefficient
    assert pin_k.standard_uncertainty >= unmeasured.bodies["pin"].wear_coefficient.standard_uncertainty > 0
    assert coefficients(lost)["disc"] == pytest.approx(1e-10 / (LOAD * SLID), rel=1e-12)


@pytest.mark.parametrize("lost", [0.0, -1e-12])
def test_a_disc_that_lost_nothing_has_no_groove_of_unknown_depth(lost):
    end = {**LENGTH, "disc_wear_volume": si(lost, "m^3", 0.0)}
    assert not fit_wear(of_materials("Al2O3", "steel", path={}, **end), recipe=FIRST_ORDER).findings


@pytest.mark.slow
@pytest.mark.parametrize(
    "groove",
    [
        {"disc_wear_depth": si(20e-6, "m", 2e-7)},
        {"disc_track_width": si(0.9e-3, "m", 5e-6)},
        {"disc_track_area": si(12e-9, "m^2", 1e-10)},
    ],
)
def test_a_measured_groove_needs_no_length_of_the_track(groove):
    """The depth, width or cross-section of the groove determine the shape of the scar by themselves."""
    fits = [
        fit_wear(of_materials("Al2O3", "steel", path=path, **LENGTH, **groove), recipe=FIRST_ORDER)
        for path in (CIRCLE, {})
    ]
    (known, unknown) = (fit.bodies["pin"].wear_coefficient for fit in fits)
    assert unknown.value == pytest.approx(known.value, rel=1e-9)
    assert unknown.standard_uncertainty == pytest.approx(known.standard_uncertainty, rel=1e-6)
    assert not fits[1].findings


def test_along_a_track_of_unknown_length_the_wear_of_the_pin_alone_is_predicted():
    run = run_with(path={})
    known = known_wear(fit_wear(run, "archard", recipe=FIRST_ORDER))
    found = predict_wear(run_scenario(run, "archard", known, None, Recipe()), [SLID])
    assert list(found.prediction[0].bodies) == ["pin"]
    assert any("track_radius or stroke is missing, so the wear of the disc" in note for note in found.notes)


def test_the_depth_of_a_pin_beside_a_groove_of_unknown_depth_is_noted():
    notes = [specific_wear(run_with(path=path)).notes for path in ({}, CIRCLE)]
    told = [any("those on an unworn disc" in note for note in found) for found in notes]
    assert told == [True, False]


def test_the_distance_at_which_a_coating_wore_through_is_that_of_the_fitted_course():
    """The volume of a cap is in proportion to the distance."""
    run = run_of(described(conditions={"normal_load": si(LOAD, "N")}, pin_wear_volume=si(PIN, "m^3", 0.03 * PIN)))
    contact = run.manifest.contact
    film = contact.pin.model_copy(update={"coating_thickness": Quantity(value=10e-6, unit="m")})
    coated = run.manifest.model_copy(update={"contact": contact.model_copy(update={"pin": film})})
    findings = fit_wear(replace(run, manifest=coated), "archard", recipe=FIRST_ORDER).findings
    (worn,) = [finding for finding in findings if finding.code == "coating_worn_through"]
    assert worn.where == "contact.pin.coating_thickness"
    cap = math.pi * 10e-6**2 * (3 * RADIUS - 10e-6) / 3
    distance, spread = (float(part) for part in re.search(r"from ([\d.]+) ± ([\d.]+) m on", worn.message).groups())
    assert distance == pytest.approx(SLID * cap / PIN, rel=0.01)
    assert spread == pytest.approx(distance * math.hypot(0.03, 0.01), rel=0.1)


def test_another_engine_asks_for_a_depth_signal():
    recipe = FIRST_ORDER.model_copy(update={"wear": FIRST_ORDER.wear.model_copy(update={"engine": "giwm"})})
    assert fit_wear(run_with(), "archard", recipe=recipe).outcome == "not fitted"


def test_there_is_no_curve_without_one():
    run = run_with()
    assert fitted_curves(run, fit_wear(run, "archard", recipe=FIRST_ORDER)) is None

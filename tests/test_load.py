"""The load that wear and friction are evaluated with, and what its uncertainty does to friction and k_D."""

import math
from dataclasses import replace

import numpy as np
import pytest
from disc_runs import BARE
from end_value_runs import RADIUS, described, run_of, si

from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.recipe import DefaultUncertainty, Recipe
from tribopipe.evaluation.derived_columns import coefficient
from tribopipe.evaluation.friction import fit_friction
from tribopipe.evaluation.load_and_friction import applied_load, load_course, load_path
from tribopipe.evaluation.measurements.sliding_distance import distance_share
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.evaluation.wear.inputs import (
    contact_inputs,
    distance_scale,
    friction_along,
    instrument_inputs,
    law_friction,
)
from tribopipe.physics.friction_path import ExponentialFriction
from tribopipe.physics.geometry import scar_radius_at, worn_depth
from tribopipe.physics.laws import law_named
from tribopipe.physics.load_course import effective_distance
from tribopipe.results.run import RawRun

DISTANCE = np.linspace(0, 500, 1001)


def pressed(load=None, stated=None, mu=None):
    """A run under a nominal load of 0.2 N, with a recorded load (N) and a friction force of μ times that."""
    run = run_of(described(conditions={"normal_load": si(0.2, "N", stated) if stated else {"value": 0.2, "unit": "N"}}))
    columns, origins = dict(run.columns), dict(run.origins)
    if load is not None:
        columns["normal_force"], origins["normal_force"] = np.broadcast_to(load, DISTANCE.shape) * 1.0, "measured"
    if mu is not None:
        columns["friction_force"] = mu * columns.get("normal_force", 0.2)
        columns["friction_coefficient"], origins["friction_coefficient"] = coefficient(columns, run.manifest)
    return replace(run, columns=columns, origins=origins)


def test_recorded_load_is_the_load():
    rng = np.random.default_rng(1)
    load = applied_load(pressed(0.21 + 0.002 * rng.standard_normal(len(DISTANCE))), Recipe())
    assert load.value == pytest.approx(0.21, rel=1e-3)
    assert load.standard_uncertainty == pytest.approx(0.01 * 0.21, rel=0.01)


def test_recorded_load_counts_over_the_distance_not_over_the_samples():
    run = pressed(np.where(DISTANCE < 100, 0.1, 0.2))
    slow = np.concatenate([np.linspace(0, 100, 801), np.linspace(100, 500, 200)])
    load = np.where(slow < 100, 0.1, 0.2)
    run = replace(run, columns={**run.columns, "sliding_distance": slow, "normal_force": load})
    assert applied_load(run, Recipe()).value == pytest.approx(0.18, rel=0.01)


@pytest.mark.parametrize("end", [200, 400])
def test_load_path_goes_on_with_the_last_load_that_was_recorded(end):
    load = np.where(end < DISTANCE, np.nan, 0.1 + 1e-3 * DISTANCE)
    found = load_path(pressed(load), np.array([0.0, 100.0, end, 450.0, 500.0, 501.0]))
    assert found[:2].tolist() == pytest.approx([0.0, 15.0])
    until, last = 0.1 * end + 0.5e-3 * end**2, 0.1 + 1e-3 * end
    assert found[2:].tolist() == pytest.approx([until + last * (slid - end) for slid in (end, 450, 500, 501)])


def test_calibration_is_as_uncertain_as_the_nominal_load_is_stated_to_be():
    load = applied_load(pressed(0.21, stated=0.004), Recipe())
    assert load.standard_uncertainty == pytest.approx(0.02 * 0.21)


@pytest.mark.parametrize("load", [None, np.nan, 0.0, -0.2])
def test_nominal_load_is_the_fallback_as_it_is_stated(load):
    run = pressed(load, stated=0.004)
    assert applied_load(run, Recipe()) == run.manifest.conditions.normal_load


@pytest.mark.parametrize(("stated", "source", "share"), [(None, "default", 0.03), (0.004, "manifest", 0.02)])
@pytest.mark.parametrize("load", [None, 0.21])
def test_wear_takes_the_recorded_load_and_says_who_stated_its_uncertainty(load, stated, source, share):
    recipe = Recipe(uncertainty=DefaultUncertainty(normal_load=0.03))
    given = contact_inputs(pressed(load, stated), recipe)["normal_load"]
    assert (given.quantity.value, given.source) == (pytest.approx(load or 0.2), source)
    assert given.spread == pytest.approx(share * given.quantity.value)


MU = 0.2 * np.exp(-DISTANCE / 60) + 0.5


def noisy(**known):
    return pressed(mu=MU + 0.005 * np.random.default_rng(3).standard_normal(len(DISTANCE)), **known)


@pytest.mark.parametrize("load", [None, 0.21])
def test_load_makes_a_and_b_uncertain_together_and_leaves_c_alone(load):
    run = noisy(load=load, stated=0.006)
    with_load = fit_friction(run)
    assert with_load.load_uncertainty.value == pytest.approx(0.03)
    noise, both = np.asarray(with_load.noise_covariance), np.asarray(with_load.covariance)
    a, b = with_load.amplitude, with_load.steady_state
    np.testing.assert_allclose(
        both - noise, 0.03**2 * np.outer([a.value, b.value, 0], [a.value, b.value, 0]), atol=1e-12
    )
    assert b.standard_uncertainty == pytest.approx(math.sqrt(both[1, 1]))
    assert b.standard_uncertainty > 0.03 * b.value
    assert with_load.running_in_distance.standard_uncertainty == pytest.approx(math.sqrt(noise[2, 2]))


@pytest.mark.parametrize(("speed", "share"), [(si(0.4, "m/s", 0.002), 0.005), (si(0.4, "m/s", 0.012), 0.03)])
def test_running_in_distance_is_as_uncertain_as_the_speed_that_distance_was_derived_from(speed, share):
    run = noisy()
    conditions = run.manifest.conditions.model_validate(run.manifest.conditions.model_dump() | {"sliding_speed": speed})
    told = replace(
        run,
        manifest=run.manifest.model_copy(update={"conditions": conditions}),
        origins={**run.origins, "sliding_distance": "derived from nominal speed"},
    )
    recorded, derived = fit_friction(run), fit_friction(told)
    c = derived.running_in_distance
    assert recorded.distance_uncertainty is None
    assert derived.distance_uncertainty.value == pytest.approx(share)
    assert c.standard_uncertainty == pytest.approx(
        math.hypot(recorded.running_in_distance.standard_uncertainty, share * c.value)
    )
    assert derived.covariance[2][2] == pytest.approx(c.standard_uncertainty**2)
    np.testing.assert_allclose(derived.noise_covariance, recorded.noise_covariance, rtol=1e-9)


@pytest.mark.parametrize(
    ("turns", "share"),
    [("measured", math.hypot(0.02, 0.003)), ("derived from nominal speed", math.hypot(0.02, 0.004))],
)
def test_running_in_distance_of_two_discs_is_as_uncertain_as_their_slip(turns, share):
    document = BARE.model_dump(by_alias=True)
    document["conditions"] |= {
        "slip": {"value": 0.04, "unit": "1", "standard_uncertainty": 0.0008},
        "curved_disc_speed": si(0.8, "m/s", 0.0032),
    }
    document["contact"]["curved_disc"]["rolling_radius"] = si(4e-3, "m", 12e-6)
    columns = {"rotations": DISTANCE / 1e-3, "sliding_distance": DISTANCE, "time": DISTANCE / 0.032}
    columns["friction_coefficient"] = MU + 0.005 * np.random.default_rng(3).standard_normal(len(DISTANCE))
    origins = dict.fromkeys(columns, "measured")
    recorded = RawRun(RunManifest.model_validate(document), columns, origins, {}, {}, ())
    slipped = replace(recorded, origins=origins | {"sliding_distance": "derived from nominal slip", "rotations": turns})
    known, c = fit_friction(recorded).running_in_distance, fit_friction(slipped).running_in_distance
    assert c.standard_uncertainty == pytest.approx(math.hypot(known.standard_uncertainty, share * c.value))


@pytest.mark.parametrize(("stated", "share"), [(None, 0.01), (60e-6, 0.006)])
def test_distance_by_counted_cycles_is_as_uncertain_as_the_stroke(stated, share):
    """k_D, wear rate and c are all by 2 stroke times the count."""
    run, stroke = noisy(), si(10e-3, "m", stated) if stated else {"value": 10e-3, "unit": "m"}
    changes = {"sliding_speed": None, "stroke": stroke, "frequency": si(20, "1/s", 0.01)}
    conditions = run.manifest.conditions.model_validate(run.manifest.conditions.model_dump() | changes)
    manifest = run.manifest.model_copy(update={"conditions": conditions})
    counted = replace(run, manifest=manifest, origins={**run.origins, "sliding_distance": "derived from rotations"})
    assert fit_friction(counted).distance_uncertainty.value == pytest.approx(share)
    assert instrument_inputs(counted, Recipe())["stroke"].spread == pytest.approx(share * 10e-3)
    assert distance_scale({"stroke": 10.2e-3}, {"stroke": 10e-3}) == pytest.approx(1.02)


def test_default_uncertainty_of_the_load_counts_where_none_is_stated():
    assert fit_friction(noisy(), defaults=DefaultUncertainty(normal_load=0.05)).load_uncertainty.value == 0.05


def test_steady_value_is_uncertain_by_the_load_too():
    fit = fit_friction(pressed(mu=0.4 + 0.001 * np.random.default_rng(5).standard_normal(len(DISTANCE)), stated=0.004))
    assert fit.outcome == "steady-only"
    assert fit.steady_state.standard_uncertainty == pytest.approx(0.02 * 0.4, rel=0.01)


def test_friction_that_the_instrument_recorded_was_divided_by_a_load_of_its_own():
    run = noisy(stated=0.02)
    fit = fit_friction(replace(run, origins={**run.origins, "friction_coefficient": "measured"}))
    assert fit.load_uncertainty is None
    assert fit.steady_state.standard_uncertainty < 0.01 * fit.steady_state.value


@pytest.mark.slow
def test_intervals_of_a_and_b_hold_the_truth_with_the_load_off():
    held, runs = np.zeros(2), 100
    for seed in range(runs):
        rng = np.random.default_rng(seed)
        off = 1 + 0.01 * rng.standard_normal()
        fit = fit_friction(pressed(mu=off * MU + 0.005 * rng.standard_normal(len(DISTANCE))))
        for place, (found, truth) in enumerate(((fit.amplitude, 0.2), (fit.steady_state, 0.5))):
            held[place] += abs(found.value - truth) < 1.96 * found.standard_uncertainty
    assert np.all(held / runs >= 0.9)


def test_wear_law_does_not_count_the_load_twice():
    run = noisy(stated=0.006)
    fit = fit_friction(run)
    known = law_friction(run, "sarkar", fit, "fitted")
    np.testing.assert_allclose(known.covariance, fit.noise_covariance)
    best = {name: given.quantity.value for name, given in known.inputs.items()} | {"normal_load": 0.2}
    # The friction force stays, so that μ is lower by as much as the load is higher.
    path = friction_along(known.path, best | {"normal_load": 0.22}, best)
    np.testing.assert_allclose(path.coefficient(DISTANCE) * 0.22, known.path.coefficient(DISTANCE) * 0.2, rtol=1e-12)


def test_load_does_not_move_a_friction_coefficient_that_was_recorded():
    path = ExponentialFriction(0.2, 0.5, 60.0)
    values = {"friction_amplitude": 0.2, "friction_steady_state": 0.5, "running_in_distance": 60.0}
    moved = friction_along(path, values | {"normal_load": 0.3}, values | {"normal_load": 0.2})
    np.testing.assert_allclose(moved.coefficient(DISTANCE), path.coefficient(DISTANCE), rtol=1e-15)


def test_covariance_without_a_load_is_that_of_the_noise():
    run = noisy()
    fit = fit_friction(replace(run, origins={**run.origins, "friction_coefficient": "measured"}))
    assert fit.noise_covariance == fit.covariance
    assert fit.model_copy(update={"covariance": None}).noise_covariance is None


# A load that changes along the test

RAMP = 0.1 + 0.2 * DISTANCE / 500
RUNNING_IN = ExponentialFriction(1.3, 0.2, 60.0)


def worn_along(law, load):
    """∫ F/F̄·f ds along the test, by the trapezoidal rule on a fine grid."""
    fine = np.linspace(0, 500, 200_001)
    force = np.interp(fine, DISTANCE, load)
    rate = force / np.mean(force) * law.rate_factor(fine, RUNNING_IN)
    return np.interp(DISTANCE, fine, np.concatenate([[0], np.cumsum((rate[1:] + rate[:-1]) / 2 * np.diff(fine))]))


@pytest.mark.parametrize("load", [RAMP, RAMP[::-1], np.where(DISTANCE < 200, 0.1, 0.3)], ids=["up", "down", "step"])
@pytest.mark.parametrize("name", ["archard", "sarkar", "dissipated_energy"])
def test_a_law_wears_by_the_load_where_it_was(name, load):
    law = law_named(name)
    course = load_course(pressed(load))
    found = effective_distance(law, DISTANCE, RUNNING_IN, course)
    assert found == pytest.approx(worn_along(law, load), rel=2e-3, abs=0.2)
    assert effective_distance(law, DISTANCE[:, None] * [1.0, 0.5], RUNNING_IN, course)[:, 0] == pytest.approx(
        found, rel=1e-12
    )


def test_archard_s_law_ends_where_it_would_under_the_mean_load():
    found = effective_distance(law_named("archard"), DISTANCE, None, load_course(pressed(RAMP)))
    assert found[[0, -1]] == pytest.approx([0, 500], rel=1e-12)


def test_draws_of_friction_have_each_their_own_course():
    law, course = law_named("sarkar"), load_course(pressed(RAMP))
    draws = ExponentialFriction(np.array([[1.3], [0.5]]), np.array([[0.2], [0.3]]), 60.0)
    one_by_one = [ExponentialFriction(1.3, 0.2, 60.0), ExponentialFriction(0.5, 0.3, 60.0)]
    together = effective_distance(law, DISTANCE, draws, course)
    assert together == pytest.approx(np.stack([effective_distance(law, DISTANCE, one, course) for one in one_by_one]))
    own = np.stack([DISTANCE, DISTANCE[::-1]])
    assert effective_distance(law, own, draws, course)[1, ::-1] == pytest.approx(together[1])


def test_noise_of_the_channel_and_one_load_are_no_course():
    rng = np.random.default_rng(3)
    assert load_course(pressed(0.2 * (1 + 0.05 * rng.standard_normal(len(DISTANCE))))) is None
    assert load_course(pressed()) is None
    assert load_course(pressed(np.zeros(len(DISTANCE)))) is None


def test_a_channel_below_zero_without_contact_undoes_no_wear():
    """Noise about zero before the contact adds up to less than nothing; a negative volume has no depth."""
    course = load_course(pressed(np.where(DISTANCE < 50, -0.001, 0.2)))
    assert course is not None
    assert np.all(np.diff(course.path) >= 0)
    assert np.all(course.path[course.distance < 50] == 0)


@pytest.mark.parametrize("load", [0.4 * RAMP / 0.2, 0.4 * RAMP[::-1] / 0.2], ids=["up", "down"])
@pytest.mark.parametrize("scar", [True, False], ids=["with the scar", "by the depth signal alone"])
def test_k_d_of_a_ball_under_a_ramp_is_that_of_its_depth_signal(load, scar):
    """Under a rising load a ball wears faster and faster, which is no drift and no settling."""
    true, rng = 2e-14, np.random.default_rng(4)
    volume = true * np.concatenate([[0], np.cumsum((load[1:] + load[:-1]) / 2 * np.diff(DISTANCE))])
    depth = worn_depth(volume=volume, sphere_radius=RADIUS)
    diameter = 2 * float(scar_radius_at(depth=depth[-1], sphere_radius=RADIUS))
    ends = {"pin_scar_diameter": si(diameter, "m", 1e-6)} if scar else {}
    manifest = described(conditions={"normal_load": si(0.4, "N", 1e-3)}, disc_wear_depth=si(0, "m", 1e-9), **ends)
    run = run_of(manifest)
    columns = {**run.columns, "normal_force": load, "depth": depth + 20e-9 * rng.standard_normal(len(depth))}
    run = replace(run, columns=columns, origins=dict.fromkeys(columns, "measured"))
    fit = fit_wear(run, "archard", recipe=Recipe.model_validate({"wear": {"engine": "volume"}}))
    assert fit.first.wear_coefficient.value == pytest.approx(true, rel=0.01 if scar else 0.03)
    assert not [one for one in fit.findings if one.code in ("reading_settles", "curve_shape", "wear_rate_changes")]


@pytest.mark.slow
def test_k_d_by_a_volume_under_a_ramp_is_that_of_the_law():
    law, true = law_named("dissipated_energy"), 3e-14
    volume = true * 0.2 * float(worn_along(law, RAMP)[-1])
    run = pressed(RAMP, mu=RUNNING_IN.coefficient(DISTANCE))
    manifest = described(conditions={"normal_load": si(0.2, "N", 1e-3)}, pin_wear_volume=si(volume, "m^3"))
    run = replace(run, manifest=manifest)
    fit = fit_wear(run, "dissipated_energy", fit_friction(run))
    assert fit.bodies["pin"].wear_coefficient.value == pytest.approx(true, rel=2e-3)


def test_distance_by_a_recorded_speed_on_a_circle_is_as_uncertain_as_its_radius():
    stated = {"track_radius": {"value": 8e-3, "unit": "m", "standard_uncertainty": 0.8e-3}}
    run = run_of(described(conditions=stated))
    run = replace(run, origins={**run.origins, "sliding_distance": "derived from measured speed"})
    assert distance_share(run, DefaultUncertainty()) == pytest.approx(0.1)
    back_and_forth = run_of(described(conditions={"stroke": si(5e-3, "m")}))
    origins = {**back_and_forth.origins, "sliding_distance": "derived from measured speed"}
    assert distance_share(replace(back_and_forth, origins=origins), DefaultUncertainty()) is None


def test_mean_friction_is_uncertain_by_the_load_that_it_was_divided_by():
    fit = fit_friction(pressed(0.2, stated=0.01, mu=0.5))
    assert fit.mean.standard_uncertainty == pytest.approx(0.05 * 0.5, rel=1e-6)

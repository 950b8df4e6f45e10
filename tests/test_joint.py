"""Drift and wear in one fit, and k_D by Monte Carlo, against virtual runs whose truth is known."""

import math
from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from joint_fit import JointFit, fit_joint
from scipy.integrate import cumulative_trapezoid
from scipy.optimize import minimize_scalar
from sweeps import others_slow
from test_identify import CASES, quiet, record

from tribopipe.base.errors import FitError
from tribopipe.contacts.pin_on_disc import pin_contact
from tribopipe.documents.manifest import EndValues, Interruption
from tribopipe.documents.quantity import EndValue, Quantity
from tribopipe.documents.recipe import DefaultUncertainty, MonteCarloRecipe, Recipe, WearRecipe
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.friction import fit_friction
from tribopipe.evaluation.wear.drift_and_wear import JointProblem, joint_problem
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.evaluation.wear.inputs import FRICTION_INPUTS, draw_values
from tribopipe.evaluation.wear.problem import PRESSURE, WearProblem, wear_problem
from tribopipe.evaluation.wear.uncertainty import coefficient_draws, solve_draws
from tribopipe.extras.simulate import VirtualTest
from tribopipe.physics.pin_on_track import SphereOnTrack, depth_growth
from tribopipe.results.evaluation import COVERAGE_FACTOR
from tribopipe.results.run import RawRun


def giwm(correction: str = "model", digits: int = 1) -> Recipe:
    """A recipe for runs as they are simulated: by the GIWM, on discs that everybody knows not to wear."""
    return Recipe(
        wear=WearRecipe(correction=correction, engine="giwm"),
        monte_carlo=MonteCarloRecipe(significant_digits=digits),
        uncertainty=DefaultUncertainty(unseen_groove=0.0),
    )


GIWM, FIRST_ORDER, MODEL = giwm(), giwm("two-step", 0), giwm("model", 0)
SILICON_NITRIDE = [run_id for run_id in CASES if run_id.startswith("si3n4")]
HERTZ, USUAL = Quantity(value=1.0, unit="1/s"), Quantity(value=5.0, unit="1/s")
"""Sampling rates at which depth noise is about as informative as at the ten of the samples, and everything quicker."""


def metres(value: float, spread: float | None = None) -> EndValue:
    return EndValue(value=float(value), unit="m", standard_uncertainty=spread)


def with_end(raw: RawRun, **values: EndValue) -> RawRun:
    """The run with nothing but these end values."""
    return replace(raw, manifest=raw.manifest.model_copy(update={"end_values": EndValues(**values)}))


def with_stops(raw: RawRun, *stops: Interruption) -> RawRun:
    return replace(raw, manifest=raw.manifest.model_copy(update={"interruptions": stops}))


def with_depth(raw: RawRun, depth) -> RawRun:
    return replace(raw, columns={**raw.columns, "depth": depth})


def virtual(run_id: str, **changes) -> tuple[VirtualTest, RawRun]:
    """A virtual run without disc wear: its truth, and what was recorded of it."""
    series, run = CASES[run_id]
    sensors = series.sensors.model_copy(update={"sampling_rate": USUAL, **changes.pop("sensors", {})})
    series = series.model_copy(update={"sensors": sensors})
    run = run.model_copy(update={"disc_wear_depth": None, **changes})
    return VirtualTest(series, run), record(series, run)


def stop_at(truth: VirtualTest, distance: float, spread: float, *, remounted: bool = False) -> Interruption:
    """An interruption at which the true depth was measured."""
    return Interruption(
        sliding_distance=Quantity(value=distance, unit="m"),
        remounted=remounted,
        pin_wear_depth=metres(np.interp(distance, truth.distance, truth.worn.pin_depth), spread),
    )


def problems(raw: RawRun, law="archard") -> tuple[WearProblem, JointProblem]:
    """The two fits of a run by the simulator's GIWM, posed."""
    corrected = correct_drift(raw, GIWM)
    problem = wear_problem(corrected, law, fit_friction(raw) if law == "sarkar" else None, GIWM)
    assert isinstance(problem, WearProblem)
    return problem, joint_problem(problem, corrected, GIWM)


def joint_fit(raw: RawRun) -> JointFit:
    return fit_joint(problems(raw)[1])


def drift_error(found: Quantity, truth: VirtualTest) -> float:
    """What a drift rate that is off adds up to over the run, m."""
    return (found.value - truth.run.drift_rate.value) * truth.time[-1]


def coefficient_error(found: Quantity, truth: VirtualTest) -> float:
    """How far off a k_D is, over its true value."""
    return found.value / truth.run.wear_coefficient.value - 1


def relative(found: Quantity) -> float:
    return found.standard_uncertainty / found.value


def alike(found: float, expected: float, rel: float) -> bool:
    """Compare numbers as small as k_D is in SI, far below what approx takes for nothing."""
    return abs(found / expected - 1) <= rel


# --- the truth ---


@pytest.mark.parametrize("disc_share", [0.0, 0.1])
@pytest.mark.parametrize("run_id", CASES)
def test_truth_comes_back_without_noise(run_id, disc_share):
    truth, raw = virtual(run_id, sensors=quiet())
    worn = truth.worn.pin_depth[-1]
    ends = {"disc_wear_depth": metres(disc_share * worn, 20e-9)} if disc_share else {}
    truth, raw = virtual(run_id, sensors=quiet(), **ends)
    raw = with_end(raw, pin_wear_depth=metres(worn, 250e-9), **ends)
    # The simulated pin wears as on a disc that does not: beside a groove it would be deeper on its way, and the groove
    # deepens with the area that the middle slice of the pin loses, ∫2a·dh.
    tip = SphereOnTrack(raw.manifest.described.sliding_tip.radius.value)
    grown = depth_growth(tip, truth.distance / truth.distance[-1], worn, disc_share * worn)
    pin = truth.worn.pin_depth * grown
    posed = problems(raw)[1]
    curve = posed.pin(posed.values)
    chord = curve.worn(curve.volume(truth.worn.pin_depth)).radius * np.sqrt(grown)
    lost = cumulative_trapezoid(chord, pin, initial=0)
    groove = disc_share * worn * lost / lost[-1]
    raw = with_depth(raw, raw.columns["depth"] + pin + groove - truth.worn.pin_depth - truth.worn.disc_depth)
    joint = joint_fit(raw)
    # An end value of ±250 nm says next to nothing of WC-Co: what is found, the law's shape has said.
    # And it would have lost more.
    more = float(tip.at_depths(worn, disc_share * worn).pin_volume / tip.at_depths(worn, 0.0).pin_volume)
    assert (1 + coefficient_error(joint.wear_coefficient, truth)) / more == pytest.approx(1, abs=1e-3)
    assert [zero.value for zero in joint.zero_offsets] == pytest.approx(
        [truth.run.zero_offset.value], abs=1e-9 + 2e-3 * disc_share * worn
    )
    assert drift_error(joint.drift_rate, truth) == pytest.approx(0, abs=2e-9 + 2e-3 * disc_share * worn)
    assert joint.end_wear_depth.value == pytest.approx(worn, rel=5e-4)
    assert joint.end_value_deviation == pytest.approx(0, abs=0.02)
    assert joint.anchors == 1


@pytest.mark.filterwarnings("error")
def test_search_starts_where_no_wear_was_measured():
    """A depth of 0 ± 0.25 µm, as it is read from a pin with little wear: the reading still shows a k_D."""
    _, raw = virtual("wc-co-water-400mN")
    found, near = (
        float(joint.solve(joint.values))
        for _, joint in (problems(with_end(raw, pin_wear_depth=metres(depth, 2.5e-7))) for depth in (0.0, 1e-11))
    )
    assert found == pytest.approx(near, rel=1e-3)


@pytest.mark.parametrize("run_id", CASES)
def test_both_corrections_agree_where_the_end_value_is_exact(run_id):
    truth, raw = virtual(run_id, sensors=quiet())
    corrected = correct_drift(with_end(raw, pin_wear_depth=metres(truth.worn.pin_depth[-1], 1e-12)), GIWM)
    fit = fit_wear(corrected, recipe=FIRST_ORDER)
    joint = fit_joint(joint_problem(wear_problem(corrected, "archard", None, GIWM), corrected, GIWM))
    assert alike(joint.wear_coefficient.value, fit.first.wear_coefficient.value, 3e-4)
    # Two steps take what drifts within the window at the start for no drift at all.
    assert alike(joint.drift_rate.value, corrected.correction.two_step_rate.value, 0.01)


@pytest.mark.slow
@pytest.mark.parametrize("run_id", others_slow(CASES, first=2))
def test_wrong_end_value_spoils_the_joint_fit_less(run_id):
    truth, raw = virtual(run_id)
    corrected = correct_drift(with_end(raw, pin_wear_depth=metres(truth.worn.pin_depth[-1] + 1e-6, 1e-6)))
    fit = fit_wear(corrected, recipe=FIRST_ORDER)
    joint = fit_joint(joint_problem(wear_problem(corrected, "archard", None, GIWM), corrected, GIWM))
    k_two, k_joint = (coefficient_error(one.wear_coefficient, truth) for one in (fit.first, joint))
    rates = corrected.correction.two_step_rate, joint.drift_rate
    drift_two, drift_joint = (drift_error(rate, truth) for rate in rates)
    assert abs(k_joint) < 0.5 * abs(k_two)
    assert abs(drift_joint) < 0.5 * abs(drift_two)
    assert joint.end_value_deviation == pytest.approx(1, abs=0.4)


def without_the_last_fifth(run_id: str) -> tuple[VirtualTest, RawRun]:
    """A run whose depth signal stops at 400 m, whose end value was measured after 500 m all the same."""
    truth, raw = virtual(run_id, sensors=quiet())
    depth = np.where(truth.distance > 400, np.nan, raw.columns["depth"])
    return truth, with_depth(with_end(raw, pin_wear_depth=metres(truth.worn.pin_depth[-1], 1e-7)), depth)


@pytest.mark.parametrize("run_id", ["si3n4-air-200mN", "wc-co-water-400mN"])
def test_depth_lost_at_the_end_leaves_the_end_value_where_it_was_measured(run_id):
    truth, raw = without_the_last_fifth(run_id)
    joint = joint_fit(raw)
    assert coefficient_error(joint.wear_coefficient, truth) == pytest.approx(0, abs=2e-3)
    assert joint.end_value_deviation == pytest.approx(0, abs=0.1)
    assert drift_error(joint.drift_rate, truth) == pytest.approx(0, abs=10e-9)


@pytest.mark.parametrize("run_id", ["si3n4-air-200mN", "wc-co-water-400mN"])
def test_fitted_end_depth_is_that_at_the_end_of_the_run_where_depth_was_lost(run_id):
    truth, raw = without_the_last_fifth(run_id)
    fit = fit_wear(correct_drift(raw, GIWM), recipe=FIRST_ORDER)
    assert alike(fit.first.fitted_end_depth.value, truth.worn.pin_depth[-1], 0.02)


# --- interruptions ---


@pytest.mark.slow
@pytest.mark.parametrize("spread", [25e-9, 250e-9])
@pytest.mark.parametrize(
    "run_id", others_slow(["si3n4-air-200mN", "wc-co-water-400mN", "wc-co-water-800mN"], "si3n4-air-200mN")
)
def test_each_interruption_makes_the_coefficient_more_certain(run_id, spread):
    truth, raw = virtual(run_id)
    raw = with_end(raw, pin_wear_depth=metres(truth.worn.pin_depth[-1], spread))
    stops = [stop_at(truth, distance, spread) for distance in (50.0, 150.0, 300.0)]
    fits = [joint_fit(with_stops(raw, *stops[:count])) for count in range(4)]
    assert [fit.anchors for fit in fits] == [1, 2, 3, 4]
    spreads = [relative(fit.wear_coefficient) for fit in fits]
    assert np.all(np.diff(spreads) < 0)
    # Depth grows at least as the root of k_D, so that this is what its measurements say without any curve.
    depths = [truth.worn.pin_depth[-1], *(stop.pin_wear_depth.value for stop in stops)]
    pressure = problems(raw)[1].inputs.get(PRESSURE)
    systematic = math.hypot(0.015, pressure.spread if pressure else 0.0)
    assert spreads[-1] < 2 * spread / np.linalg.norm(depths) + systematic
    for fit in fits:
        assert abs(coefficient_error(fit.wear_coefficient, truth)) < 2.5 * relative(fit.wear_coefficient)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("factor", "codes"), others_slow([(1.0, []), (1.2, ["wear_rate_changes"]), (0.8, ["wear_rate_changes"])], first=2)
)
def test_interruption_that_contradicts_the_end_leaves_k_d_to_the_measurement_at_the_end(factor, codes):
    truth, raw = virtual("si3n4-air-400mN")
    raw = with_end(raw, pin_wear_depth=metres(truth.worn.pin_depth[-1], 100e-9))
    stop = stop_at(truth, 100.0, 100e-9, remounted=True)
    moved = stop.pin_wear_depth.model_copy(update={"value": factor * stop.pin_wear_depth.value})
    raw = with_stops(raw, stop.model_copy(update={"pin_wear_depth": moved}))
    fit = fit_wear(correct_drift(raw, GIWM), recipe=MODEL)
    found = fit.first.wear_coefficient
    assert abs(coefficient_error(found, truth)) < 2.5 * relative(found)
    assert [one.code for one in fit.findings if "after 100 m" in one.message] == codes
    assert fit.basis == ("measurement" if codes else "reading and measurement")


def test_interruption_without_a_measurement_changes_nothing():
    _, raw = virtual("si3n4-air-200mN", sensors={"sampling_rate": HERTZ})
    stop = Interruption(sliding_distance=Quantity(value=200.0, unit="m"))
    assert joint_fit(with_stops(raw, stop)) == joint_fit(raw)


def started_anew(
    run_id: str, step: float, *, remounted: bool = True, sampling_rate: Quantity = USUAL
) -> tuple[VirtualTest, RawRun]:
    """A run whose depth signal has a step at 200 m, where the pin was measured."""
    truth, raw = virtual(run_id, sensors={"sampling_rate": sampling_rate})
    depth = raw.columns["depth"] + np.where(truth.distance > 200, step, 0)
    raw = with_end(with_depth(raw, depth), pin_wear_depth=metres(truth.worn.pin_depth[-1], 25e-9))
    return truth, with_stops(raw, stop_at(truth, 200.0, 25e-9, remounted=remounted))


def assert_both_offsets_found(joint: JointFit, truth: VirtualTest, step: float) -> None:
    first, second = joint.zero_offsets
    zero = truth.run.zero_offset.value
    assert abs(first.value - zero) < 3 * first.standard_uncertainty < 0.2e-6
    assert abs(second.value - zero - step) < 3 * second.standard_uncertainty < 0.3e-6
    found = joint.wear_coefficient
    assert abs(coefficient_error(found, truth)) < 2.5 * relative(found) < 0.2  # pressure distribution included


RESTARTS = pytest.mark.parametrize(
    ("run_id", "step"),
    [
        (run_id, step)
        for run_id in ("si3n4-air-400mN", "wc-co-water-400mN", "wc-co-water-1600mN")
        for step in (-3e-6, 3e-6)
    ],
)


@pytest.mark.slow
@RESTARTS
def test_sensor_that_started_anew_has_a_second_zero_offset(run_id, step):
    truth, raw = started_anew(run_id, step)
    assert_both_offsets_found(joint_fit(raw), truth, step)


@pytest.mark.slow
@RESTARTS
def test_model_knows_new_starts_that_two_steps_do_not(run_id, step):
    truth, raw = started_anew(run_id, step)
    fit = fit_wear(correct_drift(raw, GIWM), recipe=MODEL)
    first, second = (zero.value for zero in fit.sensor.zero_offsets)
    spread = 4 * max(zero.standard_uncertainty for zero in fit.sensor.zero_offsets)
    assert second - first == pytest.approx(step, abs=spread)
    assert abs(coefficient_error(fit.first.wear_coefficient, truth)) < 3.5 * relative(fit.first.wear_coefficient)
    assert not any("was restarted" in note for note in fit.notes)


def test_two_steps_that_know_no_new_start_end_in_a_fit_or_say_that_there_is_none():
    # Of a WC-Co pin the step leaves no wear to see: a k_D of any size, or a FitError, but no other.
    _, raw = started_anew("wc-co-water-400mN", -3e-6, sampling_rate=Quantity(value=10.0, unit="1/s"))
    with suppress(FitError):
        assert fit_wear(correct_drift(raw, GIWM), recipe=FIRST_ORDER).outcome == "fitted"


@pytest.mark.slow
def test_correction_in_two_steps_says_that_it_does_not_know_of_a_new_start():
    runs = [started_anew("si3n4-air-400mN", 3e-6, remounted=remounted) for remounted in (True, False)]
    fits = [fit_wear(correct_drift(raw, GIWM), recipe=FIRST_ORDER) for _, raw in runs]
    assert [any("was restarted at 200 m" in note for note in fit.notes) for fit in fits] == [True, False]
    truth, _ = runs[0]
    assert abs(coefficient_error(joint_fit(runs[0][1]).wear_coefficient, truth)) < 0.01
    assert abs(coefficient_error(fits[0].first.wear_coefficient, truth)) > 0.02


# --- which fit is the headline ---


@pytest.mark.slow
@pytest.mark.parametrize("run_id", ["si3n4-air-200mN", "wc-co-water-400mN"])
def test_recipe_says_how_drift_is_corrected_for(run_id):
    _, raw = virtual(run_id)
    two_step, model = (fit_wear(correct_drift(raw, recipe), recipe=recipe) for recipe in (FIRST_ORDER, MODEL))
    assert (two_step.correction, model.correction) == ("two-step", "model")
    assert (two_step.basis, model.basis) == (None, "reading and measurement")
    assert (two_step.first.by_reading, two_step.first.by_measurement) == (
        model.first.by_reading,
        model.first.by_measurement,
    )
    low, high = (end.value for end in model.first.interval)
    assert low < model.first.wear_coefficient.value < high
    # Zero offset and end reading are fitted along, and no longer inputs.
    assert {line.name for line in two_step.first.budget} - {line.name for line in model.first.budget} == {
        "zero offset",
        "end reading",
    }


@pytest.mark.parametrize("run_id", ["si3n4-air-200mN", "wc-co-water-400mN"])
def test_fitted_end_depth_is_that_at_the_end_of_the_run(run_id):
    truth, raw = virtual(run_id, sensors=quiet())
    fit = fit_wear(correct_drift(raw, GIWM), recipe=MODEL)
    assert alike(fit.first.fitted_end_depth.value, truth.worn.pin_depth[-1], 2e-3)


@pytest.mark.parametrize("run_id", others_slow(SILICON_NITRIDE))
def test_depth_of_the_wrong_sign_is_not_trusted(run_id):
    _, raw = virtual(run_id)
    fit = fit_wear(correct_drift(with_depth(raw, -raw.columns["depth"])), recipe=MODEL)
    assert fit.basis == "measurement"
    assert alike(fit.first.wear_coefficient.value, fit.first.by_measurement.value, 5e-3)


# --- Monte Carlo ---


@pytest.mark.slow
@pytest.mark.parametrize("law", others_slow(["archard", "sarkar"], "archard"))
@pytest.mark.parametrize("correction", ["two-step", "model"])
def test_monte_carlo_and_first_order_agree_where_the_model_is_nearly_linear(correction, law):
    _, raw = virtual("si3n4-air-400mN")
    corrected, friction = correct_drift(raw, GIWM), fit_friction(raw)
    drawn, linear = (
        fit_wear(
            corrected,
            law,
            friction,
            giwm(correction, digits),
        )
        for digits in (1, 0)
    )
    assert drawn.first.wear_coefficient.value == linear.first.wear_coefficient.value
    assert relative(drawn.first.wear_coefficient) == pytest.approx(relative(linear.first.wear_coefficient), rel=0.04)
    for end, first_order in zip(drawn.first.interval, linear.first.interval, strict=True):
        assert alike(end.value, first_order.value, 0.005)
    monte_carlo = drawn.first.monte_carlo
    assert monte_carlo.stable
    assert monte_carlo.agrees_with_first_order
    assert monte_carlo.first_order_interval == linear.first.interval
    assert not any("disagree" in note for note in drawn.notes)
    assert linear.first.monte_carlo is None


@pytest.mark.slow
def test_uncertain_end_value_gives_an_interval_that_no_first_order_one_comes_near():
    truth, raw = virtual("wc-co-water-400mN", sensors=quiet())
    end, spread = 725e-9, 250e-9
    raw = with_end(raw, pin_wear_depth=metres(end, spread))
    two_step = giwm("two-step")
    fit = fit_wear(correct_drift(raw, two_step), recipe=two_step)
    best = fit.first.wear_coefficient.value
    low, high = (one.value / best for one in fit.first.interval)
    lognormal = [one.value / best for one in fit.first.monte_carlo.first_order_interval]
    symmetric = 1 - np.log(lognormal[1]), 1 + np.log(lognormal[1])
    assert symmetric[0] + 0.2 < low < 0.8 * lognormal[0]
    assert symmetric[1] + 0.2 < high < 0.9 * lognormal[1]
    assert not fit.first.monte_carlo.agrees_with_first_order
    assert any("first-order propagation and Monte Carlo disagree" in note for note in fit.notes)

    # All else is as good as certain, and k_D grows with the end value: its ends are those of the end value.
    pin = pin_contact(raw.manifest.contact, problems(raw)[0].values)

    def least_squares(end_value: float) -> float:
        depth = truth.worn.pin_depth + (end_value - truth.worn.pin_depth[-1]) * truth.distance / truth.distance[-1]

        def squares(log_ratio: float) -> float:
            volume = np.exp(log_ratio) * best * 0.4 * truth.distance
            return float(np.sum((depth - pin.worn(volume).depth) ** 2)) * 1e15

        return np.exp(minimize_scalar(squares, bounds=(-4, 2), method="bounded").x)

    ends = [least_squares(end + sign * COVERAGE_FACTOR * spread) for sign in (-1, 1)]
    assert (low, high) == pytest.approx(ends, rel=0.05)


@pytest.mark.parametrize("disc", [None, metres(0.1e-6, 20e-9)])
@pytest.mark.parametrize("run_id", ["si3n4-air-200mN", "wc-co-water-400mN"])
def test_draws_with_no_wear_left_have_a_coefficient_of_zero(run_id, disc):
    truth, raw = virtual(run_id, sensors={"sampling_rate": HERTZ})
    worn = truth.worn.pin_depth[-1]
    raw = with_end(raw, pin_wear_depth=metres(worn, 250e-9), disc_wear_depth=disc)
    for problem in (problems(raw)[0].pooled(), problems(raw)[1]):
        ends = np.array([1.0, 0.3, -10.0, -20.0]) * worn
        values = {name: np.full((len(ends), 1), best) for name, best in problem.values.items()}
        values["pin_end_value"] = ends[:, None]
        found = problem.solve(values)
        assert alike(found[0], problem.coefficient(), 1e-9)
        assert 0 < found[1] < found[0]
        np.testing.assert_array_equal(found[2:], 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("end", [0.0, -0.25, -0.5, -1.0])
def test_joint_coefficient_is_where_the_squares_are_least_however_low_the_end_value(end):
    truth, raw = virtual("wc-co-water-400mN")
    worn = truth.worn.pin_depth[-1]
    _, joint = problems(with_end(raw, pin_wear_depth=metres(worn, 250e-9)))
    values = {**joint.values, "pin_end_value": end * worn}
    tried = np.geomspace(1e-3, 5.0, 300) * truth.run.wear_coefficient.value

    def squares(coefficient: float) -> float:
        depth, _ = joint.model(np.log(coefficient), values)
        residual = (joint.rows(values) - depth) * joint.root_weights
        residual = residual - joint.free @ (joint.free.T @ residual)
        return float(residual @ residual)

    best = tried[np.argmin([squares(coefficient) for coefficient in tried])]
    assert alike(float(joint.solve(values)), best, 0.03)


@pytest.mark.parametrize("law", ["archard", "sarkar"])
@pytest.mark.parametrize("which", [0, 1], ids=["two-step", "model"])
def test_solving_columns_of_draws_is_solving_one_by_one(which, law):
    _, raw = virtual("si3n4-air-400mN", sensors={"sampling_rate": HERTZ})
    problem = problems(raw, law)[which].pooled()
    rng = np.random.default_rng(3)
    values = draw_values(problem.inputs, problem.friction_covariance, rng, 25)
    noise = problem.draw_noise(rng, 25)
    at_once = problem.solve(values, noise)
    alone = [
        float(problem.solve({name: column[row, 0] for name, column in values.items()}, noise[row])) for row in range(25)
    ]
    np.testing.assert_allclose(at_once, alone, rtol=1e-9)
    assert np.std(at_once) > 0.003 * np.mean(at_once)
    np.testing.assert_allclose(solve_draws(problem, values, noise), at_once, rtol=1e-5)


def test_each_draw_is_the_same_however_the_draws_are_sliced(monkeypatch):
    _, raw = virtual("si3n4-air-200mN", sensors={"sampling_rate": HERTZ})
    draw = coefficient_draws(problems(raw)[0])
    whole = draw(np.random.default_rng(1), 50)
    monkeypatch.setattr("tribopipe.evaluation.wear.uncertainty._SLICE", 7)
    np.testing.assert_allclose(draw(np.random.default_rng(1), 50), whole, rtol=1e-5)


def test_noise_of_pooled_rows_is_that_of_means_of_correlated_samples():
    truth, raw = virtual("si3n4-air-200mN")
    _, problem = problems(raw)
    drawn = problem.draw_noise(np.random.default_rng(1), 4000)
    sensors = truth.series.sensors
    time = sensors.depth_correlation_time.value * sensors.sampling_rate.value
    # Of n samples with memory φ = exp(−1/time), the variance of the mean is σ²/n·(1 + φ)/(1 − φ), but for the ends.
    inflation = 1 / np.tanh(0.5 / time)
    rows = len(problem.distance)
    expected = sensors.depth_noise.value * np.sqrt(inflation / problem.weights)
    assert np.mean(np.std(drawn[:, :rows], axis=0) / expected) == pytest.approx(1, rel=0.2)
    # What is uncertain of an end value is drawn as an input.
    np.testing.assert_array_equal(drawn[:, rows:], 0.0)
    assert drawn.shape[1] == rows + 1


def test_friction_is_drawn_with_its_covariance():
    _, raw = virtual("si3n4-air-200mN")
    problem, _ = problems(raw, "sarkar")
    drawn = draw_values(problem.inputs, problem.friction_covariance, np.random.default_rng(1), 20_000)
    found = np.cov([drawn[name][:, 0] for name in FRICTION_INPUTS])
    scale = np.sqrt(np.diag(problem.friction_covariance))
    np.testing.assert_allclose(
        found / np.outer(scale, scale), problem.friction_covariance / np.outer(scale, scale), atol=0.05
    )


# --- fewer rows, the same answer ---


@pytest.mark.parametrize("run_id", others_slow(CASES, first=2))
@pytest.mark.parametrize("law", ["archard", "sarkar"])
def test_pooled_samples_give_the_coefficient_of_all_of_them(run_id, law):
    problem, _ = problems(record(*CASES[run_id]), law)
    few = problem.pooled()
    assert len(few.distance) <= 40 < len(problem.distance)
    assert np.sum(few.weights) == len(problem.distance)
    assert alike(few.coefficient(), problem.coefficient(), 1e-3)


def flat_pin(**changes) -> tuple[VirtualTest, RawRun]:
    """The truth of a run with a flat pin, and what was recorded of it."""
    series, run = CASES["si3n4-air-200mN"]
    pin = series.contact.pin.model_copy(update={"shape": "flat", "radius": Quantity(value=0.5e-3, unit="m")})
    series = series.model_copy(update={"contact": series.contact.model_copy(update={"pin": pin})})
    run = run.model_copy(update={"disc_wear_depth": None, "wear_coefficient": Quantity(value=135e-15, unit="m^2/N")})
    return VirtualTest(series, run), record(series, run, **changes)


def test_pooled_samples_give_the_coefficient_of_all_of_them_for_a_flat_pin():
    problem, _ = problems(flat_pin()[1])
    assert alike(problem.pooled().coefficient(), problem.coefficient(), 1e-3)


@pytest.mark.parametrize("sensors", [{}, quiet()], ids=["noisy", "quiet"])
def test_wear_of_a_flat_pin_is_known_by_its_end_value_alone(sensors):
    # Its wear is as straight a line as drift is.
    truth, raw = flat_pin(sensors=sensors)
    worn = truth.worn.pin_depth[-1]
    joint = joint_fit(with_end(raw, pin_wear_depth=metres(worn, 250e-9)))
    # The mean of the recorded load is that of the truth but for its noise.
    assert coefficient_error(joint.wear_coefficient, truth) == pytest.approx(0, abs=1e-5)
    assert joint.end_value_deviation == pytest.approx(0, abs=1e-3)
    # Area and load matter beside the depth.
    systematic = np.hypot(2 * 0.002, 0.01)
    assert relative(joint.wear_coefficient) == pytest.approx(np.hypot(250e-9 / worn, systematic), rel=0.1)


# --- how far off it is, and says it is ---


@pytest.mark.slow
@pytest.mark.parametrize("spread", [25e-9, 100e-9])
def test_standardised_errors_of_the_joint_fit_scatter_as_those_of_a_standard_distribution(spread):
    series, run = CASES["wc-co-water-400mN"]
    assert not series.systematic_errors
    sensors = {
        "sampling_rate": HERTZ,
        "pin_end_value": "pin_wear_depth",
        "height_loss_uncertainty": Quantity(value=spread, unit="m"),
    }
    errors = []
    for seed in range(60):
        joint = joint_fit(record(series, run, seed=20_000 + seed, sensors=sensors))
        pairs = (
            (joint.wear_coefficient, run.wear_coefficient),
            (joint.zero_offsets[0], run.zero_offset),
            (joint.drift_rate, run.drift_rate),
        )
        errors.append([(found.value - true.value) / found.standard_uncertainty for found, true in pairs])
    assert np.all(np.abs(np.mean(errors, axis=0)) < 0.5)
    spreads = np.std(errors, axis=0)
    assert np.all((spreads > 0.6) & (spreads < 1.2)), spreads


@pytest.mark.slow
def test_zero_offset_taken_from_little_wear_is_as_uncertain_as_repeated_runs_say():
    # Within the window of correction in two steps WC-Co wears some 50 nm.
    series, run = CASES["wc-co-water-400mN"]
    sensors = {"sampling_rate": HERTZ, "scar_uncertainty": Quantity(value=1e-9, unit="m")}
    found = [
        correct_drift(record(series, run, seed=30_000 + seed, sensors=sensors)).correction.zero_offset
        for seed in range(60)
    ]
    scatter = np.std([zero.value for zero in found])
    assert np.mean([zero.standard_uncertainty for zero in found]) == pytest.approx(scatter, rel=0.3)


@pytest.mark.slow
@settings(max_examples=15)
@given(st.floats(-5e-6, 5e-6), st.floats(-2e-9, 2e-9))
def test_offset_and_drift_added_to_a_reading_are_found_and_change_nothing_else(offset, rate):
    _, raw = virtual("wc-co-water-400mN", sensors={"sampling_rate": HERTZ})
    depth = raw.columns["depth"]
    plain, moved = (
        joint_fit(with_depth(raw, reading)) for reading in (depth, depth + offset + rate * raw.columns["time"])
    )
    assert alike(moved.wear_coefficient.value, plain.wear_coefficient.value, 1e-6)
    assert moved.zero_offsets[0].value - plain.zero_offsets[0].value == pytest.approx(offset, abs=1e-12)
    assert moved.drift_rate.value - plain.drift_rate.value == pytest.approx(rate, abs=1e-15)

"""The wear coefficient of one run: recovered, with an uncertainty that simulated runs bear out."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sweeps import others_slow

from tribopipe.base.errors import FitError
from tribopipe.documents.manifest import EndValues, RunManifest
from tribopipe.documents.plan import Plan, Series, VirtualRun
from tribopipe.documents.quantity import EndValue, Quantity
from tribopipe.documents.recipe import MonteCarloRecipe, Recipe, WearRecipe
from tribopipe.documents.record import load_toml
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.friction import fit_friction
from tribopipe.evaluation.wear.depth_problem import depth_problem
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.evaluation.wear.inputs import draw_values
from tribopipe.evaluation.wear.problem import WearProblem, wear_problem
from tribopipe.extras.simulate import VirtualTest
from tribopipe.results.run import RawRun

PLAN = load_toml(Path(__file__).parents[1] / "sample_runs" / "plan.toml", Plan)
FIRST_ORDER = Recipe(monte_carlo=MonteCarloRecipe(significant_digits=0))
UNWORN = EndValue(value=0.0, unit="m", standard_uncertainty=1e-12)
CASES = {run.id: (series, run) for series in PLAN.series for run in series.runs if series.contact.kind == "pin-on-disc"}


def record(series: Series, run: VirtualRun, **changes) -> RawRun:
    """One virtual run as if it had been ingested, with sensors or the run itself changed."""
    sensors = series.sensors.model_copy(update=changes.pop("sensors", {}))
    series, run = series.model_copy(update={"sensors": sensors}), run.model_copy(update=changes)
    test = VirtualTest(series, run)
    columns, ends = test.record()
    columns |= {
        "sliding_distance": series.sliding_speed.value * test.time,
        "friction_coefficient": columns["friction_force"] / columns["normal_force"],
    }
    origins = dict.fromkeys(columns, "measured") | {
        "friction_coefficient": "derived from measured load",
        "sliding_distance": "derived from nominal speed",
    }
    manifest = RunManifest.model_validate(
        {
            "schema": "tribopipe.run/1",
            "id": run.id,
            "started": run.started,
            "contact": series.contact.model_dump(),
            "conditions": {
                "normal_load": run.normal_load.model_dump(),
                "sliding_speed": series.sliding_speed.model_dump(),
            },
            "signals": [{"file": "signals.csv"}],
            "sensors": {"depth_scale": series.depth_scale.model_dump()},
            "end_values": {name: value.model_dump() for name, value in ends.items()},
        }
    )
    return RawRun(manifest, columns, origins, {}, {}, ())


def quiet() -> dict:
    """Sensors that add almost nothing to the truth."""
    tiny = EndValue(value=1e-15, unit="m")
    nothing = EndValue(value=1e-12, unit="1")
    return {
        "depth_noise": tiny,
        "depth_resolution": tiny,
        "scar_uncertainty": tiny,
        "friction_noise": nothing,
        "load_noise": nothing,
    }


@pytest.mark.slow
@pytest.mark.parametrize("run_id", others_slow(CASES, first=3))
@pytest.mark.parametrize("law", ["archard", "sarkar"])
def test_true_coefficient_comes_back_without_noise(run_id, law):
    series, run = CASES[run_id]
    raw = record(series.model_copy(update={"law": law}), run, sensors=quiet(), disc_wear_depth=UNWORN)
    fit = fit_wear(correct_drift(raw), law, fit_friction(raw), FIRST_ORDER)
    assert fit.first.wear_coefficient.value == pytest.approx(run.wear_coefficient.value, rel=0.03, abs=0)
    assert fit.first.fitted_end_depth.value == pytest.approx(fit.first.measured_end_depth.value, rel=0.003, abs=20e-9)


@pytest.mark.slow
@pytest.mark.parametrize("correction", ["model", "two-step"])
@pytest.mark.parametrize("law", ["archard", "sarkar"])
def test_uncertainty_of_the_end_depth_is_that_of_draws_and_knows_no_load(law, correction):
    series, run = CASES["si3n4-air-200mN"]
    raw, recipe = record(series, run), FIRST_ORDER.model_copy(update={"wear": WearRecipe(correction=correction)})
    friction, ends = fit_friction(raw), []
    for share in (0.001, 0.05):
        load = raw.manifest.conditions.normal_load.model_copy(update={"standard_uncertainty": share * 0.2})
        conditions = raw.manifest.conditions.model_copy(update={"normal_load": load})
        known = replace(raw, manifest=raw.manifest.model_copy(update={"conditions": conditions}))
        corrected = correct_drift(known, recipe)
        ends.append(fit_wear(corrected, law, friction, recipe).first.fitted_end_depth.standard_uncertainty)
    assert ends[1] == pytest.approx(ends[0], rel=0.02)
    problem = wear_problem(corrected, law, friction, recipe)
    if correction == "model":
        problem = depth_problem(problem, corrected, recipe)
    rng, draws = np.random.default_rng(5), 2_000 if correction == "model" else 500
    values = draw_values(problem.inputs, problem.friction_covariance, rng, draws)
    coefficients = problem.solve(values, problem.draw_noise(rng, draws))
    drawn = problem.depth(np.asarray(coefficients)[:, None], values, np.asarray([problem.trace.slid]))
    assert ends[1] == pytest.approx(np.std(drawn), rel=0.1)


def test_measured_friction_serves_sarkar_s_law_as_well_as_the_fitted():
    series, run = CASES["si3n4-air-200mN"]
    raw = record(series.model_copy(update={"law": "sarkar"}), run, sensors=quiet())
    recipe = FIRST_ORDER.model_copy(update={"wear": WearRecipe(friction="measured")})
    fitted, measured = (fit_wear(correct_drift(raw), "sarkar", fit_friction(raw), how) for how in (FIRST_ORDER, recipe))
    assert measured.first.wear_coefficient.value == pytest.approx(fitted.first.wear_coefficient.value, rel=1e-4, abs=0)
    assert measured.friction == "measured"


@pytest.mark.slow
def test_friction_without_an_exponential_enters_sarkar_s_law_as_measured():
    series, run = CASES["si3n4-air-200mN"]
    raw = record(series, run, sensors=quiet())
    rising = np.linspace(0.5, 0.8, len(raw.sliding_distance))
    raw = replace(raw, columns={**raw.columns, "friction_coefficient": rising})
    friction = fit_friction(raw)
    assert friction.outcome == "steady-only"
    fit = fit_wear(correct_drift(raw), "sarkar", friction)
    as_measured = fit_wear(correct_drift(raw), "sarkar", friction, Recipe(wear=WearRecipe(friction="measured")))
    assert fit.first.wear_coefficient == as_measured.first.wear_coefficient
    assert fit.friction == "measured"
    assert any("changes linearly" in note for note in fit.notes)


def test_friction_enters_the_budget_with_its_covariance():
    raw = record(*CASES["si3n4-air-400mN"])
    friction = fit_friction(raw)
    fit = fit_wear(correct_drift(raw), "sarkar", friction, FIRST_ORDER)
    (line,) = [line for line in fit.first.budget if line.name == "friction fit"]
    problem = problem_of(raw)
    alone = [
        problem.sensitivity(name, fit.first.wear_coefficient.value) * given.spread
        for name, given in problem.inputs.items()
        if name in ("friction_amplitude", "friction_steady_state")
    ]
    # A and b make up for each other: together they matter far less than either alone.
    assert line.relative < 0.3 * min(map(abs, alone))


def problem_of(raw: RawRun) -> WearProblem:
    problem = wear_problem(correct_drift(raw), "sarkar", fit_friction(raw), Recipe())
    assert isinstance(problem, WearProblem)
    return problem


@pytest.mark.slow
def test_first_order_sensitivities_are_those_of_refitting():
    problem = problem_of(record(*CASES["si3n4-air-200mN"]))
    best = problem.solve(problem.values)
    for name, given in problem.inputs.items():
        shifted = {**problem.values, name: problem.values[name] + 0.1 * given.spread}
        refitted = np.log(problem.solve(shifted) / best) / (0.1 * given.spread)
        assert problem.sensitivity(name, best) == pytest.approx(refitted, rel=0.05, abs=1e-4 / given.spread)


def test_the_budget_is_that_of_all_samples():
    problem = problem_of(record(*CASES["si3n4-air-200mN"]))
    best, names = problem.coefficient(), [*problem.inputs]
    of_all, condensed = problem.sensitivities(best, names), problem.condensed().sensitivities(best, names)
    assert len(problem.condensed().distance) < 0.1 * len(problem.distance)
    assert condensed == pytest.approx(of_all, rel=1e-5)


def test_combined_uncertainty_is_the_root_sum_of_squares_of_the_budget():
    raw = record(*CASES["wc-co-water-400mN"])
    fit = fit_wear(correct_drift(raw), "archard", recipe=FIRST_ORDER)
    combined = np.sqrt(sum(line.relative**2 for line in fit.first.budget))
    assert fit.first.wear_coefficient.standard_uncertainty / fit.first.wear_coefficient.value == pytest.approx(
        combined, rel=1e-12
    )
    assert {line.name for line in fit.first.budget} >= {
        "normal load",
        "pin radius",
        "pin modulus",
        "disc modulus",
        "pin end value",
    }
    assert fit.first.random_uncertainty.value < fit.first.wear_coefficient.standard_uncertainty


@pytest.mark.slow
def test_larger_end_value_uncertainty_widens_the_interval():
    series, run = CASES["si3n4-air-200mN"]
    fits = []
    for spread in (1e-6, 4e-6):
        raw = record(series, run)
        end = raw.manifest.end_values
        scar = end.pin_scar_diameter.model_copy(update={"standard_uncertainty": spread})
        manifest = raw.manifest.model_copy(update={"end_values": end.model_copy(update={"pin_scar_diameter": scar})})
        fits.append(fit_wear(correct_drift(replace(raw, manifest=manifest)), "archard"))
    assert (
        fits[1].first.wear_coefficient.standard_uncertainty > 1.4 * fits[0].first.wear_coefficient.standard_uncertainty
    )


def test_defaults_used_are_named():
    raw = record(*CASES["si3n4-air-200mN"])
    conditions = raw.manifest.conditions
    load = conditions.normal_load.model_copy(update={"standard_uncertainty": None})
    manifest = raw.manifest.model_copy(update={"conditions": conditions.model_copy(update={"normal_load": load})})
    fit = fit_wear(correct_drift(replace(raw, manifest=manifest)), "archard")
    assert fit.notes == ("default uncertainty used for normal load 200.0 ± 2.0 mN",)
    assert {line.source for line in fit.first.budget if line.name == "normal load"} == {"default"}


def test_end_value_of_no_wear_is_refused_in_two_steps_and_bounds_k_d_by_the_model():
    raw = record(*CASES["wc-co-water-400mN"])
    end = raw.manifest.end_values.model_copy(
        update={"pin_scar_diameter": None, "pin_wear_depth": EndValue(value=0.0, unit="m", standard_uncertainty=1e-8)}
    )
    raw = replace(raw, manifest=raw.manifest.model_copy(update={"end_values": end}))
    in_two_steps = Recipe(wear=WearRecipe(correction="two-step"))
    with pytest.raises(FitError, match="shows no wear of the pin"):
        fit_wear(correct_drift(raw, in_two_steps), "archard", recipe=in_two_steps)
    fit = fit_wear(correct_drift(raw), "archard")
    truth = CASES["wc-co-water-400mN"][1].wear_coefficient.value
    assert fit.first.interval[0].value < fit.first.wear_coefficient.value < 0.01 * truth


def test_run_without_what_the_fit_needs_says_what_it_lacks():
    raw = record(*CASES["si3n4-air-200mN"])
    no_friction = {name: column for name, column in raw.columns.items() if not name.startswith("friction")}
    fit = fit_wear(
        correct_drift(replace(raw, columns=no_friction)), "sarkar", fit_friction(replace(raw, columns=no_friction))
    )
    assert (fit.outcome, fit.missing) == ("not fitted", ("a friction signal",))
    no_depth = {name: column for name, column in raw.columns.items() if name != "depth"}
    no_end = raw.manifest.model_copy(update={"end_values": EndValues()})
    nothing = replace(raw, manifest=no_end, columns=no_depth)
    assert fit_wear(correct_drift(nothing)).missing == ("a depth signal",)
    assert fit_wear(correct_drift(replace(raw, columns=no_depth))).basis == "measurement"


@pytest.mark.slow
def test_missing_depth_samples_change_little():
    raw = record(*CASES["si3n4-air-200mN"])
    depth = raw.columns["depth"].copy()
    depth[2000:2600] = np.nan
    holed = replace(raw, columns={**raw.columns, "depth": depth})
    whole, part = (fit_wear(correct_drift(one)).first.wear_coefficient for one in (raw, holed))
    assert part.value == pytest.approx(whole.value, abs=whole.standard_uncertainty)


def three_deviations(count: int) -> float:
    """Return how far a share of 95 % of so many may stray."""
    return 3 * np.sqrt(0.95 * 0.05 / count)


@pytest.mark.slow
@pytest.mark.parametrize("run_id", ["si3n4-air-200mN", "wc-co-water-400mN"])
def test_intervals_of_friction_hold_the_truth_as_often_as_they_say(run_id):
    series, run = CASES[run_id]
    series = series.model_copy(update={"systematic_errors": True})
    held, count = np.zeros(3), 300
    for seed in range(count):
        friction = fit_friction(record(series, run, seed=10_000 + seed))
        for index, name in enumerate(("amplitude", "steady_state", "running_in_distance")):
            found, truth = getattr(friction, name), getattr(run.friction, name).value
            held[index] += found is not None and abs(found.value - truth) < 1.96 * found.standard_uncertainty
    assert held / count == pytest.approx(0.95, abs=three_deviations(count))


@pytest.mark.slow
@pytest.mark.parametrize("correction", ["two-step", "model"])
@pytest.mark.parametrize("run_id", ["si3n4-air-200mN", "wc-co-water-400mN"])
def test_intervals_of_the_coefficient_hold_the_truth_as_often_as_they_say(run_id, correction, monkeypatch):
    monkeypatch.setattr("tribopipe.physics.uncertainty.BLOCK", 1_000)
    series, run = CASES[run_id]
    series = series.model_copy(update={"systematic_errors": True})
    recipe = Recipe(wear=WearRecipe(correction=correction))
    held, count = 0, 50
    for seed in range(count):
        fit = fit_wear(correct_drift(record(series, run, seed=20_000 + seed)), recipe=recipe)
        low, high = (end.value for end in fit.first.interval)
        held += low <= run.wear_coefficient.value <= high
    assert held / count == pytest.approx(0.95, abs=three_deviations(count))


def test_depth_that_contradicts_the_end_value_is_said_to_be_in_doubt():
    raw = record(*CASES["si3n4-air-200mN"])
    fit = fit_wear(correct_drift(replace(raw, columns={**raw.columns, "depth": -raw.columns["depth"]})))
    assert "reading_contradicts_measurement" in {finding.code for finding in fit.findings}
    assert fit.first.wear_coefficient.value == pytest.approx(fit.first.by_measurement.value, rel=5e-3, abs=0)


def test_k_d_is_as_uncertain_as_the_track_radius_its_distance_was_derived_from():
    raw = record(*CASES["si3n4-air-200mN"])
    conditions = raw.manifest.conditions.model_copy(
        update={"track_radius": Quantity(value=8e-3, unit="m", standard_uncertainty=1.6e-4)}
    )
    by_rotations = replace(
        raw,
        manifest=raw.manifest.model_copy(update={"conditions": conditions}),
        origins={**raw.origins, "sliding_distance": "derived from rotations"},
    )
    fit = fit_wear(correct_drift(by_rotations), "archard", None, FIRST_ORDER)
    (line,) = [line for line in fit.first.budget if line.name == "track radius"]
    assert line.relative == pytest.approx(-0.02, rel=1e-3)
    assert line.value is not None
    assert line.value.shown(line.shown_in) == "8.00 ± 0.16 mm"

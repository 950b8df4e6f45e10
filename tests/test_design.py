"""Experimental design: what a longer test, replicates or a better known input would do, and whether it really does."""

import math
from dataclasses import replace

import numpy as np
import pytest
from test_identify import CASES, FIRST_ORDER, record

from tribopipe.base.errors import ContactError, FitError
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe, WearRecipe
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.friction import fit_friction
from tribopipe.evaluation.study.further_tests import designs
from tribopipe.evaluation.study.member import Member, PosedRun, at_length
from tribopipe.evaluation.wear.problem import WearProblem, wear_problem
from tribopipe.evaluation.wear.uncertainty import budget
from tribopipe.results.evaluation import COVERAGE_FACTOR
from tribopipe.results.input_quantities import input_label

TWO_STEP = Recipe(wear=WearRecipe(correction="two-step"))
WC_CO, SI3N4 = "wc-co-water-400mN", "si3n4-air-200mN"
HERTZ = Quantity(value=1.0, unit="1/s")
"""A sampling rate at which depth noise is about as informative as at the usual ten, and everything quicker."""


def posed(run_id: str, recipe: Recipe | None = None, law: str = "archard", **changes) -> PosedRun:
    raw = record(*CASES[run_id], sensors={"sampling_rate": HERTZ}, **changes)
    return Member(correct_drift(raw), fit_friction(raw)).pose(law, recipe or TWO_STEP)


def design(run: PosedRun, law: str, wanted: float, shared=(), scatter: float | None = None):
    """What it takes to know k_D of a pin."""
    (plan,) = designs(run, law, wanted, shared, [scatter])
    return plan


@pytest.fixture(scope="module")
def wc_co() -> PosedRun:
    """A run whose k_D is known poorly, by its depth."""
    return posed(WC_CO)


@pytest.fixture(scope="module")
def si3n4() -> PosedRun:
    """A run whose k_D is known well."""
    return posed(SI3N4)


def half_width(run: PosedRun, length: float) -> float:
    """Half width of the 95 % interval of k_D over k_D in a test so many times as long."""
    return COVERAGE_FACTOR * relative(budget(at_length(run.problem, run.coefficient, length), run.coefficient))


def relative(lines) -> float:
    return math.hypot(*(line.relative for line in lines))


# --- longer tests ---


@pytest.mark.parametrize("run_id", [WC_CO, SI3N4])
@pytest.mark.parametrize("law", ["archard", "sarkar"])
@pytest.mark.parametrize("recipe", [TWO_STEP], ids=["two-step"])
def test_test_as_long_as_the_run_has_the_budget_of_the_run(run_id, law, recipe):
    run = posed(run_id, recipe, law)
    as_it_is = {line.name: line.relative for line in budget(run.problem, run.coefficient)}
    as_planned = {
        line.name: line.relative for line in budget(at_length(run.problem, run.coefficient, 1.0), run.coefficient)
    }
    assert set(as_planned) == set(as_it_is)
    combined = math.hypot(*as_it_is.values())
    assert math.hypot(*as_planned.values()) == pytest.approx(combined, rel=0.05)
    for name, value in as_it_is.items():
        assert as_planned[name] == pytest.approx(value, rel=0.1, abs=0.05 * combined), name


def test_longer_test_slides_farther_with_as_many_samples_a_metre(wc_co):
    longer = at_length(wc_co.problem, wc_co.coefficient, 4.0)
    assert longer.trace.slid == pytest.approx(4 * wc_co.problem.trace.slid)
    np.testing.assert_allclose(longer.distance, 4 * wc_co.problem.distance)
    assert np.sum(longer.weights) == pytest.approx(4 * np.sum(wc_co.problem.weights))
    assert longer.noise == wc_co.problem.noise
    assert longer.inputs["pin_end_value"].spread == wc_co.problem.inputs["pin_end_value"].spread
    end = float(longer.end_depth(longer.values))
    law = wc_co.problem.depth(wc_co.coefficient, wc_co.problem.values, np.array([4 * wc_co.problem.trace.slid]))
    assert end == pytest.approx(float(law[0]), rel=1e-9, abs=0)
    # The law fits the planned curve: a deeper sphere in a groove is a little less like a paraboloid.
    assert float(longer.solve(longer.values)) / wc_co.coefficient == pytest.approx(1, rel=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("recipe", [TWO_STEP], ids=["two-step"])
def test_longer_tests_know_k_d_of_hard_metal_better_until_a_floor(recipe):
    run = posed(WC_CO, recipe)
    lengths = np.geomspace(1, 100, 7)
    widths = np.array([half_width(run, length) for length in lengths])
    assert np.all(np.diff(widths) < 0)
    assert widths[0] > 2 * widths[-1]
    # What no length makes better known.
    systematic = [
        line for line in budget(run.problem, run.coefficient) if line.name in ("normal load", "sliding speed")
    ]
    floor = COVERAGE_FACTOR * relative(systematic)
    assert widths[-1] > floor
    plan = design(run, "archard", 0.9 * widths[-1])
    assert plan.sliding_distance is None
    assert plan.by_distance == pytest.approx(widths[-1] * max(1.0, plan.half_width / widths[0]), rel=1e-9)
    assert "a longer test is not sufficient" in str(plan)
    # Far beyond, nothing changes any more but for what grows with the depth.
    assert (widths[-2] - widths[-1]) / (widths[0] - widths[1]) < 0.3


def test_a_longer_test_is_no_worse_than_the_run():
    """Fitted together, the scale of the sensor made a longer test worse than the present one."""
    raw = record(*CASES[SI3N4], sensors={"sampling_rate": HERTZ})
    scale = Quantity(value=1.0, unit="1", standard_uncertainty=0.03)
    sensors = raw.manifest.sensors.model_copy(update={"depth_scale": scale})
    raw = replace(raw, manifest=raw.manifest.model_copy(update={"sensors": sensors}))
    run = Member(correct_drift(raw), None).pose("archard", Recipe())
    (now,), (longer,) = run.budgets(), run.budgets(4.0)
    assert relative(longer) <= relative(now)


def test_a_test_as_long_as_the_run_is_not_sufficient_where_the_run_is_not():
    """The budget of a test planned as long is that of planned samples, and may be a little less than the run's."""
    run = posed(WC_CO)
    (own,), (planned,) = run.budgets(), run.budgets(1.0)
    assert relative(planned) < relative(own)
    plan = design(run, "archard", COVERAGE_FACTOR * (relative(planned) + relative(own)) / 2)
    assert plan.sliding_distance.value > run.end.value


@pytest.mark.slow
@pytest.mark.parametrize("wanted", [0.3, 0.12])
def test_distance_of_the_plan_gives_the_interval_wanted(wc_co, wanted):
    plan = design(wc_co, "archard", wanted)
    length = plan.sliding_distance.value / wc_co.problem.trace.slid
    assert length > 1
    beyond = max(1.0, plan.half_width / half_width(wc_co, 1.0))
    assert half_width(wc_co, length) * beyond == pytest.approx(wanted, rel=0.005)
    assert f"one test of {plan.sliding_distance.value:,.0f} m would be sufficient" in str(plan)


@pytest.mark.slow
def test_sharper_wish_needs_a_longer_test_and_more_replicates(wc_co):
    plans = [design(wc_co, "archard", wanted) for wanted in (0.3, 0.2, 0.15)]
    distances = [plan.sliding_distance.value for plan in plans]
    assert distances == sorted(distances)
    assert [plan.replicates for plan in plans] == sorted({plan.replicates for plan in plans})


@pytest.mark.slow
def test_length_at_which_the_tip_would_be_gone_is_not_planned(si3n4):
    # Depth grows about as √s: 0.794 mm take about a thousand times the length that 23.5 µm did.
    with pytest.raises(ContactError):
        at_length(si3n4.problem, si3n4.coefficient, 2000.0)
    soft = posed(SI3N4, wear_coefficient=Quantity(value=1e-12, unit="m^2/N"))
    with pytest.raises(ContactError):
        at_length(soft.problem, soft.coefficient, 100.0)
    plan = design(soft, "archard", 0.001)
    assert plan.sliding_distance is None
    assert math.isfinite(plan.by_distance)


# --- replicates ---


def lines_of(run: PosedRun) -> dict[str, float]:
    return {line.name: line.relative for line in budget(run.problem, run.coefficient)}


@pytest.mark.slow
@pytest.mark.parametrize("scatter", [None, 0.0, 0.1])
@pytest.mark.parametrize("shared", [(), ("normal_load", "pin_modulus", "depth_scale")])
@pytest.mark.parametrize("wanted", [0.3, 0.15])
def test_replicates_average_out_all_that_is_not_shared(wc_co, scatter, shared, wanted):
    parts = lines_of(wc_co)
    common = sum(parts[name.replace("_", " ")] ** 2 for name in (*shared, "pressure_distribution"))
    own = sum(value**2 for value in parts.values()) - common + (scatter or 0.0) ** 2
    plan = design(wc_co, "archard", wanted, shared, scatter)

    def reached(count: int) -> float:
        return COVERAGE_FACTOR * math.sqrt(common + own / count)

    assert reached(plan.replicates) <= wanted * (1 + 1e-9)
    assert plan.replicates == 1 or reached(plan.replicates - 1) > wanted
    assert plan.scatter == scatter
    assert ("scatter between runs is unknown" in str(plan)) == (scatter is None)


@pytest.mark.slow
def test_replicates_by_hand(si3n4):
    parts = lines_of(si3n4)
    load = parts["normal load"]
    own = math.sqrt(sum(value**2 for value in parts.values()) - load**2)
    wanted = COVERAGE_FACTOR * math.hypot(load, own / math.sqrt(6.5))
    plan = design(si3n4, "archard", wanted, ["normal_load"])
    assert plan.replicates == 7
    assert "7 tests like this one would be sufficient" in str(plan)


@pytest.mark.slow
def test_what_runs_share_is_a_floor_that_no_number_of_replicates_gets_below(si3n4):
    floor = COVERAGE_FACTOR * abs(lines_of(si3n4)["normal load"])
    plan = design(si3n4, "archard", 0.99 * floor, ["normal_load"])
    assert plan.by_replicates == pytest.approx(floor, rel=1e-12)
    assert plan.replicates is None
    assert f"replicates are not sufficient: at best {100 * floor:.1f} %" in str(plan)
    above = design(si3n4, "archard", 1.01 * floor, ["normal_load"])
    assert above.replicates > 10
    assert design(si3n4, "archard", 0.1).by_replicates == 0.0


def test_scatter_between_runs_is_in_the_half_width_of_one_test_however_long(si3n4):
    """One test is off by the scatter, the mean of n tests by its nth part in square."""
    scatter, own = 0.1, sum(value**2 for value in lines_of(si3n4).values())
    plan = design(si3n4, "archard", 0.05, scatter=scatter)
    assert plan.half_width == pytest.approx(COVERAGE_FACTOR * math.sqrt(own + scatter**2), rel=1e-12)
    assert plan.sliding_distance is None
    least = min(half_width(si3n4, length) for length in np.geomspace(1, 100, 61))
    assert plan.by_distance == pytest.approx(math.hypot(least, COVERAGE_FACTOR * scatter), rel=1e-9)
    assert plan.replicates == math.ceil((plan.half_width / 0.05) ** 2)
    assert (plan.levers[0].name, plan.levers[0].relative) == ("scatter between runs", scatter)
    halved = COVERAGE_FACTOR * math.sqrt(own + scatter**2 / 4)
    assert f"the variance; halving it would reduce the half-width to {100 * halved:.1f} %" in str(plan)
    assert f"the mean of {plan.replicates} tests like this one would be sufficient" in str(plan)
    without = design(si3n4, "archard", 0.05)
    assert "no further test is needed" in str(without)
    assert without.wear_coefficient == plan.wear_coefficient


# --- levers ---


@pytest.mark.slow
@pytest.mark.parametrize("run_id", [WC_CO, SI3N4])
@pytest.mark.parametrize("law", ["archard", "sarkar"])
def test_levers_share_the_variance_and_the_first_pays_most(run_id, law):
    run = posed(run_id, law=law)
    plan = design(run, law, 0.01)
    lines = {line.name: abs(line.relative) for line in budget(run.problem, run.coefficient)}
    assert {lever.name: lever.relative for lever in plan.levers} == lines
    assert sum(lever.share for lever in plan.levers) == pytest.approx(1)
    assert plan.half_width == pytest.approx(COVERAGE_FACTOR * math.hypot(*lines.values()))
    assert min(plan.levers, key=lambda lever: lever.if_halved) is plan.levers[0]
    for lever in plan.levers:
        others = [value for name, value in lines.items() if name != lever.name]
        assert lever.if_halved == pytest.approx(COVERAGE_FACTOR * math.hypot(*others, lines[lever.name] / 2))
        assert plan.levers[0].if_halved <= lever.if_halved <= plan.half_width
    assert f"largest contribution: {input_label(plan.levers[0].name)}, " in str(plan)


@pytest.mark.slow
def test_halved_lever_is_what_half_the_uncertainty_gives(si3n4):
    plan = design(si3n4, "archard", 0.01)
    (lever,) = [lever for lever in plan.levers if lever.name == "normal load"]
    _, run = CASES[SI3N4]
    load = run.normal_load.model_copy(update={"standard_uncertainty": run.normal_load.standard_uncertainty / 2})
    assert design(posed(SI3N4, normal_load=load), "archard", 0.01).half_width == pytest.approx(
        lever.if_halved, rel=1e-3
    )


# --- what is wanted ---


@pytest.mark.slow
def test_run_that_is_good_enough_needs_nothing_more(si3n4):
    now = design(si3n4, "archard", 0.01).half_width
    plan = design(si3n4, "archard", 1.01 * now)
    assert plan.replicates == 1
    assert plan.sliding_distance.value == pytest.approx(si3n4.problem.trace.slid)
    said = str(plan)
    assert said.endswith("no further test is needed")
    assert "sufficient" not in said
    assert "no further test is needed" not in str(design(si3n4, "archard", 0.99 * now))


@pytest.mark.parametrize("wanted", [0.0, -0.05, math.nan])
def test_interval_that_is_not_above_zero_is_refused(si3n4, wanted):
    with pytest.raises(FitError, match=r"plan: --interval: found .*; expected a positive value, such as '10 %'"):
        design(si3n4, "archard", wanted)


@pytest.mark.slow
@pytest.mark.parametrize(("wanted", "scatter"), [(1e-6, None), (0.01, 0.1), (0.05, None), (0.5, 2.0), (1e3, 0.0)])
def test_every_wish_gets_a_plan_that_can_be_said(wanted, scatter, si3n4):
    plan = design(si3n4, "archard", wanted, ["normal_load"], scatter)
    assert (plan.replicates is None) == (wanted <= plan.by_replicates)
    assert plan.sliding_distance is None or plan.sliding_distance.value >= si3n4.problem.trace.slid * (1 - 1e-9)
    assert (plan.sliding_distance is None) == (wanted < plan.by_distance)
    of = "k_D" if scatter is None else "k_D from one test, including the scatter between runs,"
    head = f"{SI3N4}, archard: half-width of the 95 % interval for {of} is {100 * plan.half_width:.1f} %, target "
    assert str(plan).startswith(f"{head}{100 * wanted:.1f} %")


# --- whether it is so ---


WANTED = 0.2


@pytest.fixture(scope="module")
def recorded(wc_co) -> list[tuple[WearProblem, float]]:
    """Sixty runs over the distance that was planned, each with systematic errors of its own, and their k_D."""
    series, run = CASES[WC_CO]
    distance = design(wc_co, "archard", WANTED).sliding_distance
    series = series.model_copy(update={"sliding_distance": distance, "systematic_errors": True})
    found = []
    for seed in range(60):
        raw = record(series, run, seed=40_000 + seed, sensors={"sampling_rate": HERTZ})
        problem = wear_problem(correct_drift(raw), "archard", None, FIRST_ORDER).pooled()
        found.append((problem, problem.coefficient()))
    return found


@pytest.mark.slow
def test_planned_distance_gives_the_interval_wanted_in_simulated_runs(recorded):
    found = [coefficient for _, coefficient in recorded]
    spread, truth = WANTED / COVERAGE_FACTOR, CASES[WC_CO][1].wear_coefficient.value
    assert np.std(found) / truth == pytest.approx(spread, rel=0.35)
    assert np.mean(found) / truth == pytest.approx(1, abs=3 * spread / len(found) ** 0.5)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["pin end value", "end reading", "zero offset", "normal load"])
def test_planned_budget_is_that_of_runs_of_this_length(wc_co, recorded, name):
    length = recorded[0][0].trace.slid / wc_co.problem.trace.slid
    assert length > 2
    (planned,) = [
        abs(line.relative)
        for line in budget(at_length(wc_co.problem, wc_co.coefficient, length), wc_co.coefficient)
        if line.name == name
    ]
    squares = [
        line.relative**2
        for problem, coefficient in recorded
        for line in budget(problem, coefficient)
        if line.name == name
    ]
    assert planned == pytest.approx(np.sqrt(np.mean(squares)), rel=0.3)

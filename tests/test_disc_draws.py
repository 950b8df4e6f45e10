"""Draws of a twin-disc fit, solved together with the state, against those that the problem solves one by one."""

from dataclasses import replace

import numpy as np
import pytest
from disc_runs import CONVENTIONS, K_1, K_2, TYPICAL, exact_run, recipe
from test_disc_fit import MIXTURES, STOPS, VOLUMES
from test_twin_disc import CASES, discs_of

from tribopipe.evaluation.wear.inputs import draw_values
from tribopipe.evaluation.wear.measurement_problem import MeasurementProblem, measurement_problem
from tribopipe.physics.uncertainty import Inputs, extended

COUNT = 1_500


def posed(mixture, stops="none", convention="full-slip", **changes) -> MeasurementProblem:
    run = exact_run(mixture, STOPS[stops], convention=convention, **changes)
    problem = measurement_problem(run, "archard", None, recipe(convention))
    assert isinstance(problem, MeasurementProblem)
    return problem


@pytest.fixture
def by_itself(monkeypatch):
    """Count the draws that are left to the problem itself."""
    left = [0]
    solve = MeasurementProblem.solve

    def counted(self, values, start, tolerance=1e-12):
        left[0] += np.size(values["normal_load"]) if np.ndim(values["normal_load"]) else 0
        return solve(self, values, start, tolerance)

    monkeypatch.setattr(MeasurementProblem, "solve", counted)
    return left


@pytest.mark.slow
@pytest.mark.parametrize("convention", CONVENTIONS)
@pytest.mark.parametrize(("mixture", "stops"), [("volumes", "none"), ("depth and width", "one"), ("all", "two")])
def test_draws_are_those_that_the_quadrature_finds(mixture, stops, convention, by_itself):
    problem = posed(MIXTURES[mixture], stops, convention)
    start = np.array([K_1, K_2]) * TYPICAL[convention]
    values = problem.draw(np.random.default_rng(3), COUNT)
    found = problem.solve_draws(values, start)
    assert by_itself[0] < 0.01 * COUNT
    few = {name: column[::10] for name, column in values.items()}
    np.testing.assert_allclose(found[::10], problem.solve(few, start, 1e-10), rtol=1e-7)


@pytest.mark.slow
def test_draws_under_sarkar_s_law_are_those_that_the_quadrature_finds(by_itself):
    run = exact_run(VOLUMES, STOPS["one"], mu=0.6)
    how = recipe(friction="measured")
    problem = measurement_problem(run, "sarkar", None, how)
    assert isinstance(problem, MeasurementProblem)
    values = problem.draw(np.random.default_rng(3), COUNT)
    start = problem.coefficients()
    found = problem.solve_draws(values, start)
    assert by_itself[0] == 0
    np.testing.assert_allclose(found, problem.solve(values, start, 1e-10), rtol=1e-7)


def test_without_a_flat_disc_measured_one_coefficient_is_drawn(by_itself):
    problem = posed({"curved_disc_wear_volume": 0.05}, second=0.0)
    start = np.array([K_1 * TYPICAL["full-slip"], 0.0])
    values = problem.draw(np.random.default_rng(3), COUNT)
    found = problem.solve_draws(values, start)
    assert by_itself[0] == 0
    np.testing.assert_allclose(found, problem.solve(values, start, 1e-10), rtol=1e-7)
    assert np.all(found[:, 1] == 0)


def test_draws_without_wear_are_left_to_the_problem(by_itself):
    problem = posed(VOLUMES | {"flat_disc_wear_volume": 0.6})
    start = np.array([K_1, K_2]) * TYPICAL["full-slip"]
    values = problem.draw(np.random.default_rng(3), COUNT)
    found = problem.solve_draws(values, start)
    (flat,) = (one.name for one in problem.measurements if one.body == "flat_disc")
    unworn = values[flat][:, 0] <= 0
    assert 0.01 < np.mean(unworn) < 0.1
    np.testing.assert_array_equal(found[:, 1] == 0, unworn)
    assert np.sum(unworn) <= by_itself[0] < 0.2 * COUNT
    few = {name: column[::20] for name, column in values.items()}
    np.testing.assert_allclose(found[::20], problem.solve(few, start, 1e-10), rtol=1e-6)


def test_without_wear_at_the_best_estimates_all_is_left_to_the_problem(by_itself):
    problem = posed(VOLUMES)
    values = problem.draw(np.random.default_rng(3), 200)
    start = np.array([K_1 * TYPICAL["full-slip"], 0.0])
    found = problem.solve_draws(values, start)
    assert by_itself[0] == 200
    np.testing.assert_array_equal(found, problem.solve(values, start, 1e-6))


def test_few_draws_do_without_a_quadratic(monkeypatch, by_itself):
    problem = posed(VOLUMES)
    start = np.array([K_1, K_2]) * TYPICAL["full-slip"]
    values = problem.draw(np.random.default_rng(3), COUNT)
    whole = problem.solve_draws(values, start)
    monkeypatch.setattr("tribopipe.evaluation.wear.measurement_problem._FIRST", 20)
    np.testing.assert_allclose(problem.solve_draws(values, start), whole, rtol=1e-7)
    assert by_itself[0] == 0


@pytest.mark.parametrize("convention", ["contact-width", "line-load", "full-slip", "volume-conserving"])
@pytest.mark.parametrize("case", CASES.values(), ids=list(CASES))
@pytest.mark.parametrize("share", [1e-6, 1e-3, 1.0])
def test_cut_undoes_worn_to_nine_digits(case, convention, share):
    discs = discs_of(case, convention)
    state = discs.worn(share * case.rotations, case.k_1, case.k_2)
    cut = discs.cut(discs.growth(share * case.rotations, case.k_1, case.k_2), case.k_1, case.k_2)
    assert float(cut.rotations) == pytest.approx(share * case.rotations, rel=1e-9, abs=0)
    for name in ("half_width", "curved_depth", "flat_depth", "curved_volume", "flat_volume", "curved_rate"):
        assert float(getattr(cut, name)) == pytest.approx(float(getattr(state, name)), rel=1e-9, abs=0), name


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_slope_of_a_cut_is_that_of_growth_against_rotations(convention):
    case = CASES["Section 3.5"]
    discs, step = discs_of(case, convention), 1e-4
    low, middle, high = (
        float(discs.growth(case.rotations * np.exp(shift), case.k_1, case.k_2)) for shift in (-step, 0.0, step)
    )
    slope = float(discs.cut(middle, case.k_1, case.k_2).slope)
    assert slope == pytest.approx(np.log(high / low) / (2 * step), rel=1e-6)


def test_a_quadratic_of_logarithms_is_found_again():
    rng = np.random.default_rng(5)
    columns = np.concatenate([rng.uniform(1, 2, (400, 3)), rng.normal(size=(400, 1)), np.full((400, 1), 7.0)], axis=1)
    logs = np.log(columns[:, :3])
    truth = np.stack([logs[:, 0] * logs[:, 1] - columns[:, 3] ** 2 + 2, logs @ [1.0, -2.0, 3.0]], axis=1)
    inputs, known = Inputs.of(columns), np.arange(50)
    assert inputs.terms.shape == (400, 1 + 4 + 10)
    np.testing.assert_allclose(extended(inputs, known, truth[known]), truth, atol=1e-10)


@pytest.mark.parametrize("sign", [1, -1])
def test_a_slip_that_is_hardly_known_keeps_its_direction(sign):
    problem = posed(VOLUMES)
    slip = problem.inputs["slip"]
    known = slip.quantity.model_copy(update={"value": sign * 0.04, "standard_uncertainty": 0.02})
    drawn = draw_values({"slip": replace(slip, quantity=known)}, None, np.random.default_rng(3), COUNT)["slip"]
    assert np.all(sign * drawn > 0)
    assert abs(np.median(drawn) / (sign * 0.04) - 1) < 0.1

"""Parameters that a wear law has in addition to k_D: their covariance, against fitting again with each input moved."""

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Annotated

import numpy as np
import pytest
from independent.noise import Walk, White
from independent.regimes import REGIMES, Regime
from independent.runs import simulate
from independent.score import raw_run
from numpy.typing import ArrayLike
from test_identify import CASES, quiet, record

from tribopipe.base.arrays import Column, Numbers
from tribopipe.documents.recipe import Recipe, WearRecipe
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.friction import fit_friction
from tribopipe.evaluation.wear.depth_problem import DepthProblem, _within
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.evaluation.wear.inputs import FRICTION_INPUTS
from tribopipe.evaluation.wear.law_parameters import with_fitted_law
from tribopipe.evaluation.wear.problem import WearProblem, wear_problem
from tribopipe.physics.depth_model.mixture import _inverse
from tribopipe.physics.friction_path import FrictionPath
from tribopipe.physics.laws import LawParameter, WearLaw

TWO_STEP = Recipe(wear=WearRecipe(correction="two-step"))
MOVED = np.array([0.01, -0.006, 2.0])
"""How far A, b and c of the friction fit are off together; c in m."""


@dataclass(frozen=True)
class Weighted(WearLaw):
    """Wear grows in a straight line with friction: f = 1 + w·μ."""

    name = "weighted"
    title = "wear by weighted friction"
    rate = "k_D·p·(1 + w·μ)"
    citation = "none"
    needs_friction = True

    weight: Annotated[Numbers, LawParameter("w: what friction weighs", "ratio", low=0.0, high=1e3)] = 1.0

    def rate_factor(self, distance: ArrayLike, friction: FrictionPath | None) -> Column:
        return np.asarray(1 + self.weight * friction.coefficient(distance))

    def effective_distance(self, distance: ArrayLike, friction: FrictionPath | None) -> Column:
        s, c = np.asarray(distance, dtype=float), friction.running_in_distance
        sliding = friction.steady_state * s - friction.amplitude * c * np.expm1(-s / c)
        return np.asarray(s + self.weight * sliding)


@pytest.fixture(scope="module")
def problem() -> WearProblem:
    """A run by Sarkar's law, whose friction runs in, posed for the other law, without its friction's uncertainty."""
    series, run = CASES["si3n4-air-200mN"]
    raw = record(series.model_copy(update={"law": "sarkar"}), run, sensors=quiet())
    posed = wear_problem(correct_drift(raw, TWO_STEP), "sarkar", fit_friction(raw), TWO_STEP)
    assert set(FRICTION_INPUTS) < set(posed.inputs)
    return replace(posed.reduced(), law=Weighted(), friction_covariance=((0.0,) * 3,) * 3)


def fitted(problem: WearProblem, moved: float = 0.0) -> Column:
    """ln k_D and w with A, b and c off together by a share of MOVED."""
    inputs = dict(problem.inputs)
    for name, by in zip(FRICTION_INPUTS, moved * MOVED, strict=True):
        quantity = inputs[name].quantity
        inputs[name] = replace(inputs[name], quantity=quantity.model_copy(update={"value": quantity.value + by}))
    found = with_fitted_law(replace(problem, inputs=inputs))
    assert found.fitted_parameters == ("weight",)
    return np.array([np.log(found.coefficient()), found.law.values()["weight"]])


def test_friction_that_is_off_together_moves_k_d_and_parameters_together(problem):
    found = with_fitted_law(problem)
    best = found.coefficient()
    together = replace(found, friction_covariance=tuple(map(tuple, np.outer(MOVED, MOVED).tolist())))
    added = together.law_covariance(best) - found.law_covariance(best)
    shift = (fitted(problem, 0.3) - fitted(problem, -0.3)) / 0.6
    np.testing.assert_allclose(added, np.outer(shift, shift), rtol=0.05)


def test_errors_of_independent_friction_parameters_add_up_in_squares(problem):
    found = with_fitted_law(problem)
    best, without = found.coefficient(), found.law_covariance(found.coefficient())
    each = [
        replace(found, friction_covariance=tuple(map(tuple, np.diag(row).tolist()))).law_covariance(best) - without
        for row in np.diag(MOVED**2)
    ]
    whole = replace(found, friction_covariance=tuple(map(tuple, np.diag(MOVED**2).tolist())))
    np.testing.assert_allclose(whole.law_covariance(best) - without, sum(each), rtol=1e-9)


# --- by the whole reading, on runs of a simulator that shares nothing with the package ---


def growing(s, power=1.5):
    return (1 + s / 10) ** (power - 1)


def off(regime: Regime, seeds: range) -> Column:
    """By how many stated standard uncertainties the power and k_D are off, of runs by Archard's law; (runs, 2)."""
    found = []
    for seed in seeds:
        recorded = simulate(regime, np.random.default_rng([3107, seed]))
        fit = fit_wear(raw_run(recorded), growing)
        power, k_d = fit.params["power"], fit.k_d
        found.append([(power.value - 1) / power.u, (k_d.value - recorded.truth.coefficient) / k_d.u])
    return np.array(found)


@pytest.mark.slow
def test_parameter_is_as_uncertain_as_drift_and_end_value_leave_it():
    apart = off(replace(REGIMES["Si3N4"], distance=50.0), range(2))
    assert np.all(np.abs(apart) < 3)


@pytest.mark.slow
def test_parameter_and_coefficient_are_those_of_the_model_where_the_reading_walks():
    walking = replace(REGIMES["Si3N4"], noise=(White(0.05e-6), Walk(0.3e-6)))
    spread = np.sqrt(np.mean(off(walking, range(12)) ** 2, axis=0))
    assert np.all((spread > 0.6) & (spread < 1.5))


def test_a_parameter_goes_most_of_the_way_to_a_limit_at_most():
    known = LawParameter("anything", "ratio", 0.0, 10.0)
    assert _within(known, 1.0, -0.5) == 0.5
    assert _within(known, 1.0, -3.0) == pytest.approx(0.1)
    assert _within(known, 1.0, 100.0) == pytest.approx(9.1)
    assert _within(known, 0.0, -1.0) == 0.0


def test_covariance_is_that_of_the_draws_that_wear_at_all():
    posed = SimpleNamespace(
        fitted_parameters=("weight",),
        inputs={},
        friction_covariance=None,
        draw_scores=lambda rng, count: rng.standard_normal((count, 2)),
        _drawn=lambda _, scores: (np.maximum(scores[:, 0], 0.0), {"weight": scores[:, 1:]}),
        _coefficients=lambda depth, _: depth,
    )
    covariance = DepthProblem.parameter_covariance(posed, 1.0)
    # The logarithm of half a normal distribution has the variance π²/8.
    np.testing.assert_allclose(np.diag(covariance), [np.pi**2 / 8, 1.0], rtol=0.15)


def test_a_term_that_changes_nothing_is_left_wide_open_and_others_as_they_are():
    matrix = np.array([[4.0, 1.0], [1.0, 2.0]])
    bordered = np.zeros((1, 3, 3))
    bordered[0, :2, :2] = matrix
    inverse, log_det = _inverse(bordered)
    assert np.all(np.isfinite(log_det))
    assert inverse[0, :2, :2] == pytest.approx(np.linalg.inv(matrix), rel=1e-9)
    assert inverse[0, 2, 2] > 1e9
    assert inverse[0, 2, :2] == pytest.approx(0.0)

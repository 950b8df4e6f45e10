"""Parameters that a wear law has beside k_D: their covariance, against fitting again with each input moved."""

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
import pytest
from numpy.typing import ArrayLike
from test_identify import CASES, quiet, record

from tribopipe.base.arrays import Column, Numbers
from tribopipe.documents.recipe import Recipe, WearRecipe
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.friction import fit_friction
from tribopipe.evaluation.wear.inputs import FRICTION_INPUTS
from tribopipe.evaluation.wear.law_parameters import with_fitted_law
from tribopipe.evaluation.wear.problem import WearProblem, wear_problem
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

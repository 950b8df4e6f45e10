"""k_D of each body of one run by what was measured on the bodies, with what their uncertainties are made of.

In first order, a change of an input x moves ln k by (JᵀJ)⁻¹Jᵀ·∂(y − h)/∂x with J = ∂h/∂ln k and rows over their
standard uncertainties (JCGM 100:2008, 5.1.3): that is the budget. In draws all inputs are drawn, what was measured
among them (JCGM 102:2011).
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.random import Generator

from tribopipe.base.arrays import Column
from tribopipe.contacts.inputs import Input
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.quantity import Quantity, wear_coefficient
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.evaluation.wear.budget import budget_lines, input_covariance
from tribopipe.evaluation.wear.measurement_problem import MeasurementProblem, measurement_problem
from tribopipe.physics.friction_path import FrictionPath
from tribopipe.results.evaluation import COVERAGE_FACTOR, FrictionFit
from tribopipe.results.run import CorrectedRun
from tribopipe.results.wear_fit import BodyWear, Contribution, ConventionCoefficients, FittedValue, WearFit

_SURE = 0.01
"""Probability under the law below which disagreement is worth a word."""


def measurement_fit(
    corrected: CorrectedRun, model: LawName, friction: FrictionFit | None, recipe: Recipe
) -> "MeasurementFit | tuple[str, ...]":
    """Fit k_D to what was measured on the bodies of a run, or report what is missing for it.

    Raises ``FitError`` where the first body shows no wear to fit.
    """
    problem = measurement_problem(corrected.run, model, friction, recipe)
    return MeasurementFit(model, problem) if isinstance(problem, MeasurementProblem) else problem


@dataclass(frozen=True)
class MeasurementFit:
    """k_D of the bodies of a run, from measurements at the end and at interruptions together."""

    model: LawName
    problem: MeasurementProblem

    @property
    def inputs(self) -> Mapping[str, Input]:
        """Everything uncertain that k_D depends on."""
        return self.problem.inputs

    @property
    def friction(self) -> FrictionPath | None:
        """Friction along the test."""
        return self.problem.friction

    @cached_property
    def coefficients(self) -> Column:
        """k_D of both bodies, m²/N, at the best estimates."""
        return self.problem.coefficients()

    def draw(self, rng: Generator, count: int) -> Column:
        """Draw k_D of each body that is fitted, m²/N: (draws, bodies)."""
        values = self.problem.draw(rng, count)
        return self.problem.solve_draws(values, self.coefficients)[:, : self.problem.unknowns]

    def result(self) -> WearFit:
        """Return k_D by first-order propagation, with all that the measurements show."""
        problem, found = self.problem, self.coefficients
        # Where no wear was found there is no logarithm; it is taken where wear would have been noticed.
        at = np.where(found > 0, found, problem.scale)
        sensitivities = problem.sensitivities(at)
        covariance = _covariance(problem, sensitivities)
        spreads = at[: problem.unknowns] * np.sqrt(np.diag(covariance))
        lines = _budgets(problem, sensitivities)
        bodies = {
            body: BodyWear(
                wear_coefficient=wear_coefficient(found[place], spreads[place]),
                interval=first_order_interval(found[place], spreads[place]),
                budget=lines[place] if found[place] > 0 else (),
            )
            for place, body in enumerate(problem.bodies)
        }
        p_value = self._p_value()
        return WearFit(
            model=self.model,
            outcome="fitted",
            start=problem.wearing.start(problem.values),
            bodies=bodies,
            correlation=None if problem.one_sided else correlation(covariance),
            measurements=self._fitted_values(),
            p_value=p_value,
            notes=(*problem.limits(found), *_one_sided(problem), *_disagreement(p_value)),
            equivalents=self._equivalents(),
        )

    def _fitted_values(self) -> tuple[FittedValue, ...]:
        modelled = self.problem.modelled(self.coefficients, self.problem.values)
        return tuple(
            FittedValue(
                name=one.name,
                place=one.rotations,
                measured=one.quantity,
                fitted=Quantity(value=float(value), unit=one.quantity.unit),
            )
            for one, value in zip(self.problem.measurements, modelled, strict=True)
        )

    def _p_value(self) -> float | None:
        from scipy.stats import chi2

        problem, values = self.problem, self.problem.values
        residual = (problem.rows(values) - problem.modelled(self.coefficients, values)) * problem.root_weights
        spare = len(residual) - problem.unknowns
        return float(chi2.sf(residual @ residual, spare)) if spare > 0 else None

    def _equivalents(self) -> tuple[ConventionCoefficients, ...]:
        """Return k_D of the other ways of counting the distance that reach the same wear at the end."""
        problem = self.problem
        turns = problem.effective(problem.values, np.asarray(problem.places[-1]))
        found = problem.wearing.equivalents(problem.values, turns, self.coefficients)
        return tuple(
            ConventionCoefficients(
                distance_per_rotation=convention,
                bodies=dict(zip(problem.bodies, map(wear_coefficient, coefficients), strict=False)),
            )
            for convention, coefficients in found.items()
        )


def measurement_budgets(problem: MeasurementProblem, found: Column) -> list[tuple[Contribution, ...]]:
    """Return for each k_D that is found its uncertainty budget by first-order propagation, the largest part first."""
    return _budgets(problem, problem.sensitivities(found))


def _budgets(problem: MeasurementProblem, sensitivities: Mapping[str, Column]) -> list[tuple[Contribution, ...]]:
    each = ({name: float(both[place]) for name, both in sensitivities.items()} for place in range(problem.unknowns))
    return [budget_lines(problem.inputs, problem.friction_covariance, mine) for mine in each]


def _covariance(problem: MeasurementProblem, sensitivities: Mapping[str, Column]) -> Column:
    """Return the covariance of ln k of each body."""
    names = [*problem.inputs]
    slopes = np.array([sensitivities[name] for name in names])
    return np.asarray(slopes.T @ input_covariance(problem.inputs, problem.friction_covariance, names) @ slopes)


def correlation(covariance: Column) -> float | None:
    """Return that of both k; none where one of them is exact."""
    product = math.sqrt(covariance[0, 0] * covariance[1, 1])
    return float(covariance[0, 1]) / product if product > 0 else None


def first_order_interval(value: float, spread: float) -> tuple[Quantity, Quantity]:
    """Return the 95 % interval by first-order propagation: measurements are normal, and k about in proportion."""
    half = COVERAGE_FACTOR * spread
    return wear_coefficient(max(0.0, value - half)), wear_coefficient(value + half)


def _one_sided(problem: MeasurementProblem) -> tuple[str, ...]:
    if not problem.one_sided:
        return ()
    unmeasured = spoken(problem.contact.fitted_bodies[-1])
    return (f"the {unmeasured} was not measured and is assumed to be unworn, as in the one-sided model",)


def _disagreement(p_value: float | None) -> tuple[str, ...]:
    if p_value is None or p_value > _SURE:
        return ()
    return (
        f"the measurements disagree with the law by more than their uncertainties (probability {p_value:.1g}): the "
        "uncertainties are too small, or the law does not apply",
    )

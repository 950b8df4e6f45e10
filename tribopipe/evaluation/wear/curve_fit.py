"""k_D of one body by the depth signal of a run: least squares on its wear curve, and what the uncertainty is made of.

By first-order propagation, a change of an input x moves k_D by

    dk/dx = J·∂(y − h)/∂x / J·J,     J = ∂h/∂k

with y the corrected depth (JCGM 100:2008, 5.1.3): that is the budget. In draws the sensor's noise is drawn with its
autocorrelation.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.random import Generator

from tribopipe.base.arrays import Column
from tribopipe.base.errors import FitError
from tribopipe.base.units import KINDS, show
from tribopipe.documents.quantity import Quantity, wear_coefficient
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.evaluation.depth_reading import depth_model
from tribopipe.evaluation.wear.depth_problem import DepthProblem, depth_problem
from tribopipe.evaluation.wear.findings import engine_findings, prior_findings, wear_findings
from tribopipe.evaluation.wear.law_parameters import held_notes, undetermined_notes, with_fitted_law
from tribopipe.evaluation.wear.problem import WearProblem, wear_problem
from tribopipe.evaluation.wear.uncertainty import (
    NOISE,
    budget,
    coefficient_draws,
    input_covariance,
    relative_uncertainty,
)
from tribopipe.physics.autocorrelation import effective_samples
from tribopipe.physics.friction_path import FrictionPath
from tribopipe.results.evaluation import COVERAGE_FACTOR, FrictionFit
from tribopipe.results.finding import Finding
from tribopipe.results.input_quantities import Input
from tribopipe.results.run import CorrectedRun
from tribopipe.results.wear_fit import BodyWear, LawValue, WearFit

_FEWEST_SAMPLES = 10
_WIDEST = 100.0
"""Half width of ln k_D beyond which an interval has no meaning and would overflow."""


def curve_fit(
    corrected: CorrectedRun, model: LawName, friction: FrictionFit | None, recipe: Recipe
) -> "CurveFit | tuple[str, ...]":
    """Fit k_D to the depth signal of a run, or report what is missing for it.

    Raises ``FitError`` where it shows no wear to fit.
    """
    problem = wear_problem(corrected, model, friction, recipe)
    if not isinstance(problem, WearProblem):
        return problem
    if len(problem.distance) < _FEWEST_SAMPLES:
        raise FitError(
            f"{corrected.id}: found {len(problem.distance)} valid depth samples; expected at least "
            f"{_FEWEST_SAMPLES}; use a higher sampling rate"
        )
    whole = _posed_whole(problem, corrected, recipe)
    chosen = whole if whole is not None and recipe.wear.correction == "model" else with_fitted_law(problem)
    return CurveFit(corrected, model, recipe, chosen, whole)


def _posed_whole(problem: WearProblem, corrected: CorrectedRun, recipe: Recipe) -> DepthProblem | None:
    """Return the fit by the whole reading; None if it would only be compared, and cannot be made."""
    try:
        return depth_problem(problem, corrected, recipe)
    except FitError:
        if recipe.wear.correction == "model":
            raise
        return None


@dataclass(frozen=True)
class CurveFit:
    """k_D of a run, corrected in two steps or by the whole reading."""

    corrected: CorrectedRun
    model: LawName
    recipe: Recipe
    problem: WearProblem
    whole: DepthProblem | None
    """Fit of the complete depth signal, which gives k_D or is reported for comparison."""

    @property
    def inputs(self) -> Mapping[str, Input]:
        """Everything uncertain that k_D depends on."""
        return self.problem.inputs

    @property
    def friction(self) -> FrictionPath | None:
        """Friction along the test."""
        return self.problem.friction

    @cached_property
    def _draws(self) -> Callable[[Generator, int], Column]:
        return coefficient_draws(self.problem)

    def draw(self, rng: Generator, count: int) -> Column:
        """Draw k_D, m²/N: (draws, 1)."""
        return self._draws(rng, count)[:, None]

    def result(self) -> WearFit:
        """Return k_D by first-order propagation, with all that the curve shows."""
        problem, whole = self.problem, self.whole
        coefficient = problem.coefficient()
        covariance = problem.parameter_covariance(coefficient)
        body = _first_order(problem, coefficient, covariance).model_copy(update=_by_either(whole))
        residuals = problem.measured(problem.values, np.asarray(coefficient)) - problem.depth(
            coefficient, problem.values
        )
        return WearFit(
            model=self.model,
            engine=problem.engine,
            outcome="fitted",
            bodies={problem.contact.fitted_bodies[0]: body},
            residual_deviation=Quantity(value=float(np.std(residuals)), unit="m"),
            effective_samples=effective_samples(residuals),
            correction=self.recipe.wear.correction,
            notes=(
                *problem.contact.limits,
                *_doubts(self.corrected, self.recipe),
                *held_notes(problem),
                *undetermined_notes(problem, covariance),
            ),
            findings=self._findings(body.wear_coefficient),
            **_law_values(problem, covariance),
            **_by_whole_reading(whole, self.recipe),
        )

    def _findings(self, coefficient: Quantity) -> tuple[Finding, ...]:
        if self.whole is None:
            return ()
        by_engine = engine_findings(self.whole, coefficient)
        if self.problem is not self.whole:
            return *wear_findings(self.whole, coefficient), *by_engine
        return *wear_findings(self.whole), *prior_findings(self.whole, coefficient), *by_engine


def _by_whole_reading(whole: DepthProblem | None, recipe: Recipe) -> dict[str, Any]:
    """Return what k_D is based on, and what else the sensor reads."""
    if whole is None:
        return {}
    return {
        "basis": whole.basis if recipe.wear.correction == "model" else None,
        "deviation": whole.deviation if whole.measured_after else None,
        "sensor": depth_model(whole.posterior, whole.trace.duration, whole.inputs["depth_scale"].quantity),
    }


def _by_either(whole: DepthProblem | None) -> dict[str, Any]:
    """Return k_D by reading and by measurement alone."""
    if whole is None:
        return {}
    ways = {name: wear_coefficient(*found) for name, found in whole.coefficients_by_ways().items()}
    return {"by_reading": ways["reading"], "by_measurement": ways.get("measurement")}


def _doubts(corrected: CorrectedRun, recipe: Recipe) -> tuple[str, ...]:
    """Report what two-step correction does not take into account."""
    anew = [stop for stop in corrected.run.manifest.interruptions if stop.remounted]
    if not anew or recipe.wear.correction == "model":
        return ()
    where = ", ".join(show(stop.place, None, "m") for stop in anew)
    return (
        f"the depth sensor was restarted at {where}, which the two-step correction does not take into account; use the "
        "default "
        'correction, correction = "model"',
    )


def _law_values(problem: WearProblem, covariance: Column | None) -> dict[str, Any]:
    """Return the parameters of the law with their covariance; nothing where it has none."""
    law, free = problem.law, problem.fitted_parameters
    spreads = {} if covariance is None else dict(zip(free, np.sqrt(np.diag(covariance))[1:].tolist(), strict=True))
    found = []
    for name, known in law.parameters().items():
        value = Quantity(value=law.values()[name], unit=KINDS[known.kind].si, standard_uncertainty=spreads.get(name))
        given = problem.inputs.get(law.input_of(name))
        found.append(LawValue(name=name, value=given.quantity if given else value, source="recipe" if given else "fit"))
    return {
        "parameters": tuple(found) or None,
        "parameter_covariance": None if covariance is None else tuple(map(tuple, covariance.tolist())),
    }


def _first_order(problem: WearProblem, coefficient: float, covariance: Column | None) -> BodyWear:
    """Return k_D with its uncertainty, interval, budget and end depth, by first-order propagation."""
    lines = budget(problem.condensed(), coefficient)
    relative = relative_uncertainty(lines)
    (random,) = (line.relative for line in lines if line.name == NOISE)
    factor = math.exp(min(COVERAGE_FACTOR * relative, _WIDEST))
    together = np.array([[relative**2]]) if covariance is None else covariance
    return BodyWear(
        wear_coefficient=Quantity(value=coefficient, unit="m^2/N", standard_uncertainty=coefficient * relative),
        interval=(wear_coefficient(coefficient / factor), wear_coefficient(coefficient * factor)),
        random_uncertainty=wear_coefficient(coefficient * random),
        budget=lines,
        measured_end_depth=problem.measured_end_depth,
        fitted_end_depth=_end_depth(problem, coefficient, together),
    )


def _end_depth(problem: WearProblem, coefficient: float, covariance: Column) -> Quantity:
    """Return the depth at the end by the fit, m, with what k_D, its parameters and the inputs leave uncertain.

    What an input does at a given k_D may undo what it does to k_D: half the load doubles k_D, and the depth stays.
    """
    end, names = np.asarray([problem.trace.slid]), [*problem.inputs]
    volume = coefficient * problem.unit_volume(problem.values, end)
    state = problem.pin(problem.values).worn(volume)
    slopes = volume / state.area
    by_coefficient = float(slopes[0])
    if problem.fitted_parameters:
        beside = problem.law_slopes(lambda moved: moved.depth(coefficient, moved.values, end))
        slopes = np.append(slopes, beside)
    variance = float(slopes @ covariance @ slopes)
    by_inputs = problem.condensed().sensitivities(coefficient, names)
    low, high = np.split(problem.depth(coefficient, problem.moved(names), end)[:, 0], 2)
    spreads = np.array([problem.inputs[name].spread for name in names])
    direct = np.divide(high - low, 2 * spreads, out=np.zeros(len(names)), where=spreads > 0)
    whole = direct + 2 * by_coefficient * np.array([by_inputs[name] for name in names])
    variance += float(direct @ input_covariance(problem.inputs, problem.friction_covariance, names) @ whole)
    return Quantity(value=float(state.depth[0]), unit="m", standard_uncertainty=math.sqrt(max(0.0, variance)))

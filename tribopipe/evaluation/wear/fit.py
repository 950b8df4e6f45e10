"""The wear coefficients k_D of one run. Of a pin: least squares on its wear curve, and what the uncertainty is made of.

To first order a change of an input x moves k_D by

    dk/dx = J·∂(y − h)/∂x / J·J,     J = ∂h/∂k

with y the corrected depth (JCGM 100:2008, 5.1.3): that is the budget. The interval is that of a Monte Carlo (JCGM
101:2008) in which every systematic input is drawn once a run and the sensor's noise with its autocorrelation.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.errors import FitError
from tribopipe.base.units import KINDS, show
from tribopipe.documents.quantity import Quantity, wear_coefficient
from tribopipe.documents.recipe import FrictionSource, LawName, MonteCarloRecipe, Recipe
from tribopipe.evaluation.depth_model_summary import depth_model
from tribopipe.evaluation.wear.depth_problem import DepthProblem, depth_problem
from tribopipe.evaluation.wear.draws import coefficient_draws
from tribopipe.evaluation.wear.findings import prior_findings, wear_findings
from tribopipe.evaluation.wear.inputs import FRICTION_INPUTS, default_notes, shown_unit
from tribopipe.evaluation.wear.law_parameters import held_notes, law_columns, with_fitted_law
from tribopipe.evaluation.wear.monte_carlo import with_draws
from tribopipe.evaluation.wear.problem import WearProblem, wear_problem
from tribopipe.evaluation.wear.twin_disc.fit import fit_discs
from tribopipe.physics.autocorrelation import effective_samples
from tribopipe.physics.friction_path import ExponentialFriction
from tribopipe.physics.uncertainty import propagate
from tribopipe.results.evaluation import COVERAGE_FACTOR, FrictionFit
from tribopipe.results.run import CorrectedRun
from tribopipe.results.wear_fit import BodyWear, Contribution, LawValue, WearFit
from tribopipe.results.wording import reworded

_FEWEST_SAMPLES = 10
_NOISE = "noise of the depth signal"
_WIDEST = 100.0
"""Half width of ln k_D beyond which an interval says nothing and would overflow."""


def fit_wear(
    corrected: CorrectedRun,
    model: LawName = "archard",
    friction: FrictionFit | None = None,
    recipe: Recipe | None = None,
) -> WearFit:
    """Identify k_D of the bodies of one run, whatever its contact, under a wear law.

    Sarkar's law takes μ from ``friction`` (Eq. 7), or from the measured curve where the recipe says so. A run that
    lacks depth, end value or friction passes through, and the result says what it lacks.

    Parameters
    ----------
    corrected
        The run, its depth corrected for drift.
    model
        Name of the wear law.
    friction
        Fit of the friction coefficient, for laws that need it.
    recipe
        How to fit.

    Returns
    -------
    WearFit
        k_D of each body, m²/N.

    Raises
    ------
    FitError
        Where the run shows no wear to fit.
    """
    recipe = recipe or Recipe()
    if corrected.run.manifest.rolls:
        return fit_discs(corrected.run, model, friction, recipe)
    return _fit_pin(corrected, model, friction, recipe)


def _fit_pin(corrected: CorrectedRun, model: LawName, friction: FrictionFit | None, recipe: Recipe) -> WearFit:
    problem = wear_problem(corrected, model, friction, recipe)
    if not isinstance(problem, WearProblem):
        return WearFit(model=model, engine=recipe.wear.engine or "giwm", outcome="not fitted", lacks=problem)
    if len(problem.distance) < _FEWEST_SAMPLES:
        raise FitError(
            f"{corrected.id}: found {len(problem.distance)} samples of depth; expected at least "
            f"{_FEWEST_SAMPLES}; record at a higher rate"
        )
    source: FrictionSource | None = None
    if problem.law.needs_friction:
        source = "fitted" if isinstance(problem.friction, ExponentialFriction) else "measured"
    notes = friction.notes if friction and source == "measured" and recipe.wear.friction == "fitted" else ()
    whole = _posed_whole(problem, corrected, recipe)
    chosen = whole if whole is not None and recipe.wear.correction == "model" else with_fitted_law(problem)
    coefficient = chosen.coefficient()
    covariance = chosen.parameter_covariance(coefficient)
    fit = _assess(chosen, model, coefficient, covariance).model_copy(
        update={
            "correction": recipe.wear.correction,
            "friction": source,
            "notes": (
                *problem.contact.limits,
                *_doubts(corrected, recipe),
                *held_notes(chosen),
                *default_notes(chosen.inputs),
                *notes,
            ),
            **_by_whole_reading(whole, recipe),
        }
    )
    pin = _first_order(chosen, coefficient, covariance).model_copy(update=_by_either(whole))
    if whole is not None:
        two_step = pin.wear_coefficient if chosen is not whole else None
        findings = [*wear_findings(whole, two_step)]
        if chosen is whole:
            findings += prior_findings(whole, pin.wear_coefficient)
        fit = fit.model_copy(update={"findings": tuple(findings)})
    pin, notes = _with_monte_carlo(pin, chosen, recipe.monte_carlo)
    update = {"bodies": {corrected.run.manifest.described.fitted_bodies[0]: pin}, "notes": (*fit.notes, *notes)}
    return reworded(fit.model_copy(update=update), corrected.run.manifest.worded)


def _posed_whole(problem: WearProblem, corrected: CorrectedRun, recipe: Recipe) -> DepthProblem | None:
    """Return the fit by the whole reading; none where it would only be compared, and cannot be made."""
    try:
        return depth_problem(problem, corrected, recipe)
    except FitError:
        if recipe.wear.correction == "model":
            raise
        return None


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
    """Say what two-step correction does not know of."""
    anew = [stop for stop in corrected.run.manifest.interruptions if stop.remounted]
    if not anew or recipe.wear.correction == "model":
        return ()
    where = ", ".join(show(stop.place, None, "m") for stop in anew)
    return (
        f"the depth sensor started anew at {where}, which two-step correction does not know; use the default "
        'correction, correction = "model"',
    )


def _assess(problem: WearProblem, model: LawName, coefficient: float, covariance: Column | None) -> WearFit:
    values = problem.values
    residuals = problem.measured(values, np.asarray(coefficient)) - problem.depth(coefficient, values)
    return WearFit(
        model=model,
        engine=problem.engine,
        outcome="fitted",
        residual_deviation=Quantity(value=float(np.std(residuals)), unit="m"),
        effective_samples=effective_samples(residuals),
        **_law_values(problem, covariance),
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
    """Return k_D with its uncertainty, interval, budget and end depth, to first order."""
    lines = budget(problem.condensed(), coefficient)
    relative = math.hypot(*(line.relative for line in lines))
    (random,) = (line.relative for line in lines if line.name == _NOISE)
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
        beside = law_columns(problem, lambda moved: moved.depth(coefficient, moved.values, end))
        slopes = np.append(slopes, beside)
    variance = float(slopes @ covariance @ slopes)
    by_inputs = problem.condensed().sensitivities(coefficient, names)
    low, high = np.split(problem.depth(coefficient, problem.moved(names), end)[:, 0], 2)
    spreads = np.array([problem.inputs[name].spread for name in names])
    direct = np.divide(high - low, 2 * spreads, out=np.zeros(len(names)), where=spreads > 0)
    whole = direct + 2 * by_coefficient * np.array([by_inputs[name] for name in names])
    variance += float(direct @ _input_covariance(problem, names) @ whole)
    return Quantity(value=float(state.depth[0]), unit="m", standard_uncertainty=math.sqrt(max(0.0, variance)))


def _input_covariance(problem: WearProblem, names: Sequence[str]) -> Column:
    """Return the covariance of inputs, of which A, b and c of friction are far from independent."""
    found = np.diag([problem.inputs[name].spread ** 2 for name in names])
    if problem.friction_covariance is not None:
        places = [names.index(name) for name in FRICTION_INPUTS]
        found[np.ix_(places, places)] = problem.friction_covariance
    return found


def budget(problem: WearProblem, coefficient: float) -> tuple[Contribution, ...]:
    """Return what the uncertainty of k_D is made of, to first order, the largest part first."""
    random, moved = problem.random_uncertainty(coefficient), problem.sensitivities(coefficient, [*problem.inputs])
    lines = [Contribution(name=_NOISE, source="fit", relative=random)]
    lines += _friction_line(problem, moved)
    lines += [
        Contribution(
            name=name.replace("_", " "),
            value=given.quantity,
            shown_in=shown_unit(name, given.quantity),
            source=given.source,
            relative=moved[name] * given.spread,
        )
        for name, given in problem.inputs.items()
        if name not in FRICTION_INPUTS
    ]
    return tuple(sorted(lines, key=lambda line: -abs(line.relative)))


def _friction_line(problem: WearProblem, sensitivities: Mapping[str, float]) -> list[Contribution]:
    """Combine A, b and c by their covariance: they are far from independent (JCGM 100:2008, 5.2.2)."""
    if problem.friction_covariance is None:
        return []
    slopes = np.array([sensitivities[name] for name in FRICTION_INPUTS])
    variance = float(slopes @ np.array(problem.friction_covariance) @ slopes)
    return [Contribution(name="friction fit", source="fit", relative=math.sqrt(max(0.0, variance)))]


def _with_monte_carlo(pin: BodyWear, problem: WearProblem, how: MonteCarloRecipe) -> tuple[BodyWear, tuple[str, ...]]:
    """Replace the first-order interval by that of a Monte Carlo, and say where the two disagree."""
    if not how.significant_digits:
        return pin, ()
    found = propagate(coefficient_draws(problem), digits=how.significant_digits, seed=how.seed)
    return with_draws(pin, found, how.significant_digits)

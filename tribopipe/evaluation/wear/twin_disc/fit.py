"""k₁ and k₂ of one twin-disc run, with what their uncertainties are made of.

To first order a change of an input x moves ln k by (JᵀJ)⁻¹Jᵀ·∂(y − h)/∂x with J = ∂h/∂ln k and rows over their
standard uncertainties (JCGM 100:2008, 5.1.3): that is the budget. The intervals are those of a Monte Carlo over all
inputs, what was measured among them (JCGM 102:2011).
"""

import math

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError
from tribopipe.contacts.twin_disc import disc_pair
from tribopipe.documents.contact import DISCS
from tribopipe.documents.quantity import Quantity, wear_coefficient
from tribopipe.documents.recipe import FrictionSource, LawName, MonteCarloRecipe, Recipe
from tribopipe.evaluation.wear.inputs import FRICTION_INPUTS, default_notes, shown_unit
from tribopipe.evaluation.wear.monte_carlo import with_draws
from tribopipe.evaluation.wear.twin_disc.problem import DiscProblem, disc_problem
from tribopipe.physics.conventions import DistanceConvention
from tribopipe.physics.friction_path import ExponentialFriction
from tribopipe.physics.laws import law_named
from tribopipe.physics.uncertainty import propagate_together
from tribopipe.results.evaluation import COVERAGE_FACTOR, FrictionFit
from tribopipe.results.run import RawRun
from tribopipe.results.wear_fit import BodyWear, Contribution, ConventionCoefficients, FittedValue, WearFit, spoken

_CONVENTIONS: tuple[DistanceConvention, ...] = ("full-slip", "contact-width", "line-load", "volume-conserving")
_SURE = 0.01
"""Probability under the law below which disagreement is worth a word."""


def fit_discs(
    run: RawRun, model: LawName = "archard", friction: FrictionFit | None = None, recipe: Recipe | None = None
) -> WearFit:
    """Identify k_D of both discs of a run, m²/N, under a wear law.

    From volumes, depths and track widths of both discs at the end and at interruptions, together. A run that lacks an
    end value of the curved disc, or friction for Sarkar's law, passes through, and the result says what it lacks.
    Raises ``FitError`` where the curved disc shows no wear to fit.
    """
    recipe = recipe or Recipe()
    problem = disc_problem(run, model, friction, recipe)
    convention = recipe.wear.distance_per_rotation
    if not isinstance(problem, DiscProblem):
        return WearFit(model=model, outcome="not fitted", distance_per_rotation=convention, lacks=problem)
    found = problem.coefficients()
    source: FrictionSource | None = None
    if law_named(model).needs_friction:
        source = "fitted" if isinstance(problem.friction, ExponentialFriction) else "measured"
    fit = _first_order(problem, found, model).model_copy(update={"friction": source})
    notes = (*run_notes(problem, found), *_one_sided(problem), *_disagreement(fit), *default_notes(problem.inputs))
    fit = fit.model_copy(update={"notes": notes, "equivalents": _equivalents(problem, found)})
    return _with_monte_carlo(fit, problem, found, recipe.monte_carlo)


def _first_order(problem: DiscProblem, found: Column, model: LawName) -> WearFit:
    # Where no wear was found there is no logarithm; it is taken where wear would have been noticed.
    at = np.where(found > 0, found, problem.scale)
    sensitivities = problem.sensitivities(at)
    covariance = _covariance(problem, sensitivities)
    relative = np.sqrt(np.diag(covariance))
    residual = (problem.rows(problem.values) - problem.modelled(found, problem.values)) * problem.root_weights
    discs: dict[str, BodyWear] = {
        disc: BodyWear(
            wear_coefficient=wear_coefficient(found[place], at[place] * relative[place]),
            interval=_interval(found[place], at[place] * relative[place]),
            budget=_budget(problem, sensitivities, place) if found[place] > 0 else (),
        )
        for place, disc in enumerate(DISCS[: problem.unknowns])
    }
    return WearFit(
        model=model,
        outcome="fitted",
        distance_per_rotation=problem.distance,
        start=problem.wearing.start(problem.values),
        bodies=discs,
        correlation=None if problem.one_sided else _correlation(covariance),
        measurements=_fitted_values(problem, found),
        p_value=_p_value(residual, problem.unknowns),
    )


def _correlation(covariance: Column) -> float | None:
    """Return that of both k; none where one of them is exact."""
    product = math.sqrt(covariance[0, 0] * covariance[1, 1])
    return float(covariance[0, 1]) / product if product > 0 else None


def disc_budgets(problem: DiscProblem, found: Column) -> list[tuple[Contribution, ...]]:
    """Return for each k_D that is found what its uncertainty is made of, to first order, the largest part first."""
    sensitivities = problem.sensitivities(found)
    return [_budget(problem, sensitivities, place) for place in range(problem.unknowns)]


def _covariance(problem: DiscProblem, sensitivities: dict[str, Column]) -> Column:
    """Return the covariance of ln k₁ and ln k₂: inputs are independent but for A, b and c of the friction fit."""
    free = [name for name in problem.inputs if problem.friction_covariance is None or name not in FRICTION_INPUTS]
    slopes = np.array([sensitivities[name] * problem.inputs[name].spread for name in free])
    covariance = slopes.T @ slopes
    if problem.friction_covariance is not None:
        friction = np.array([sensitivities[name] for name in FRICTION_INPUTS])
        covariance = covariance + friction.T @ np.asarray(problem.friction_covariance) @ friction
    return np.asarray(covariance)


def _budget(problem: DiscProblem, sensitivities: dict[str, Column], place: int) -> tuple[Contribution, ...]:
    """Return what the uncertainty of one disc's k_D is made of, the largest part first."""
    lines = [
        Contribution(
            name=name.replace("_", " "),
            value=given.quantity,
            shown_in=shown_unit(name, given.quantity),
            source=given.source,
            relative=float(sensitivities[name][place]) * given.spread,
        )
        for name, given in problem.inputs.items()
        if name not in FRICTION_INPUTS
    ]
    if problem.friction_covariance is not None:
        slopes = np.array([sensitivities[name][place] for name in FRICTION_INPUTS])
        variance = float(slopes @ np.asarray(problem.friction_covariance) @ slopes)
        lines.append(Contribution(name="friction fit", source="fit", relative=math.sqrt(max(0.0, variance))))
    return tuple(sorted(lines, key=lambda line: -abs(line.relative)))


def _fitted_values(problem: DiscProblem, found: Column) -> tuple[FittedValue, ...]:
    modelled = problem.modelled(found, problem.values)
    return tuple(
        FittedValue(
            name=one.name,
            place=one.rotations,
            measured=one.quantity,
            fitted=Quantity(value=float(value), unit=one.quantity.unit),
        )
        for one, value in zip(problem.measurements, modelled, strict=True)
    )


def _p_value(residual: Column, unknowns: int) -> float | None:
    from scipy.stats import chi2

    spare = len(residual) - unknowns
    return float(chi2.sf(residual @ residual, spare)) if spare > 0 else None


def _interval(value: float, spread: float) -> tuple[Quantity, Quantity]:
    """Return the 95 % interval to first order: what was measured is normal, and k about in proportion to it."""
    half = COVERAGE_FACTOR * spread
    return wear_coefficient(max(0.0, value - half)), wear_coefficient(value + half)


def run_notes(problem: DiscProblem, coefficients: Column) -> tuple[str, ...]:
    """Say where the discs of a run leave what the model describes at its end."""
    last = problem.wear(coefficients, problem.values, problem.places[-1])
    return problem.wearing.notes(problem.values, {"half_width": last.half_width, "slip": last.slip})


def _one_sided(problem: DiscProblem) -> tuple[str, ...]:
    if not problem.one_sided:
        return ()
    return ("nothing was measured on the flat disc: it counts as unworn, as in the one-sided model",)


def _disagreement(fit: WearFit) -> tuple[str, ...]:
    if fit.p_value is None or fit.p_value > _SURE:
        return ()
    return (
        f"what was measured disagrees with the law by more than its uncertainties (probability {fit.p_value:.1g}): the "
        "uncertainties are too small, or the law does not hold",
    )


def _equivalents(problem: DiscProblem, found: Column) -> tuple[ConventionCoefficients, ...]:
    """Return k_D of the other conventions that reach the same volumes, or depth, at the end."""
    last, result = problem.places[-1:], []
    worn = problem.wear(found, problem.values, last)
    turns = problem.effective_rotations(problem.values, last)
    for convention in _CONVENTIONS:
        if convention == problem.distance:
            continue
        try:
            pair = _equivalent(problem, convention, float(worn.curved_volume[0]), float(worn.flat_volume[0]), turns)
        except ContactError:  # that way of counting would lose the slip before
            continue
        result.append(
            ConventionCoefficients(
                distance_per_rotation=convention,
                bodies=dict(zip(DISCS[: problem.unknowns], map(wear_coefficient, pair), strict=False)),
            )
        )
    return tuple(result)


def _equivalent(
    problem: DiscProblem, convention: DistanceConvention, curved: float, flat: float, turns: Column
) -> tuple[float, float]:
    """Return k₁ and k₂ by which a convention reaches two volumes: by fixed point, since V grows about as k."""
    discs = disc_pair(problem.contact, problem.values, convention)
    total = float(discs.depth_of_area(curved / (2 * np.pi * problem.values["curved_radius"])))
    first = float(discs.rotations(total, 1.0)) / float(turns[0])
    second = first * flat / curved
    for _ in range(100):
        reached = discs.worn(turns, first, second)
        ratios = (curved / float(reached.curved_volume[0]), flat / float(reached.flat_volume[0]) if flat else 1.0)
        first, second = first * ratios[0], second * ratios[1]
        if max(abs(ratio - 1) for ratio in ratios) < 1e-12:
            break
    return first, second


def _with_monte_carlo(fit: WearFit, problem: DiscProblem, found: Column, how: MonteCarloRecipe) -> WearFit:
    """Replace the first-order intervals by those of a Monte Carlo, and say where they disagree."""
    if not how.significant_digits:
        return fit
    count = len(fit.bodies)

    def model(rng: np.random.Generator, draws: int) -> Column:
        return problem.solve_draws(problem.draw(rng, draws), found)[:, :count]

    found_together = propagate_together(model, digits=how.significant_digits, seed=how.seed)
    bodies: dict[str, BodyWear] = {}
    notes: list[str] = []
    for (name, body), distribution in zip(fit.bodies.items(), found_together, strict=True):
        bodies[name], doubts = with_draws(body, distribution, how.significant_digits)
        notes += [f"{spoken(name)}: {doubt}" for doubt in doubts]
    correlation = fit.correlation
    if count == len(DISCS):
        correlation = _correlation(np.cov([one.draws for one in found_together]))
    return fit.model_copy(update={"bodies": bodies, "correlation": correlation, "notes": (*fit.notes, *notes)})

"""Runs of a study along which a sensor recorded the wear: curve and post-test measurement compared with a law."""

from collections.abc import Sequence

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe
from tribopipe.evaluation.depth_reading import engine_of
from tribopipe.evaluation.measurements.pin_on_disc import end_wear
from tribopipe.evaluation.study.engines import compare_engines, engine_notes
from tribopipe.evaluation.study.life import end_of_life
from tribopipe.evaluation.study.member import Member, PosedRun, RunDraws
from tribopipe.evaluation.study.shape import Shape
from tribopipe.evaluation.study.verdict import Comparison, Judgment, KnownCoefficient, Question, body_verdict, decide
from tribopipe.evaluation.wear.depth_problem import DepthProblem
from tribopipe.evaluation.wear.findings import shape_is_rejected, wear_findings
from tribopipe.physics.conventions import WearEngine
from tribopipe.physics.hertz import HARDNESS_UNIT, contact_modulus, hertz_radius
from tribopipe.results.agreement import EndOfLife, Exponent, Verdict
from tribopipe.results.study_curves import MeasuredCurve, StudyCurve

_LATER_PART = 0.25
"""Share of the distance after which the local exponent is taken."""


def one_engine(recipe: Recipe, fit: Sequence[Member]) -> Recipe:
    """Return the recipe with one engine for all runs: the GIWM where it is right for each of those fitted."""
    runs = [member.corrected.run for member in fit]
    engines = {engine_of(run.manifest.sliding_pin.pin, end_wear(run, recipe.uncertainty), recipe) for run in runs}
    engine: WearEngine = "giwm" if engines == {"giwm"} else engines.difference({"giwm"}).pop()
    return recipe.model_copy(update={"wear": recipe.wear.model_copy(update={"engine": engine})})


def judge_recorded(draws: RunDraws, asked: Question, shape: Shape) -> Judgment:
    """Hold a law against the curve of a run and its end."""
    run, (best,), coefficients = draws.run, asked.best.tolist(), asked.coefficients[:, 0]
    comparison = compare(draws, best, coefficients)
    engines = compare_engines(draws) if asked.role == "fitted" else None
    outcome = _withheld(decide(comparison, lambda factor: run.predicted(best * factor)), run)
    known = KnownCoefficient(run.coefficient, draws.coefficient, best, coefficients)
    places = [_meters(place) for place in run.places.tolist()]
    body = body_verdict(comparison, outcome, "wear_depth", places, known).model_copy(
        update={
            "trend": shape.trend(),
            "exponent": exponent(draws, comparison, run.predicted(run.coefficient)),
            "change_point": shape.change_point(asked.recipe.monte_carlo.seed),
            "engines": engines,
        }
    )
    wanted = asked.study.end_of_life
    return Judgment(
        bodies={run.bodies[0]: body},
        curves=(_curve(asked, run, comparison),),
        end_of_life=None if wanted is None else life_of_pin(draws, coefficients, wanted.value),
        notes=(*engine_notes(engines), *_extrapolations(run, comparison)),
        findings=tuple(wear_findings(run.problem)) if isinstance(run.problem, DepthProblem) else (),
    )


def compare(draws: RunDraws, coefficient: float, coefficients: Column) -> Comparison:
    """Compare a run with a law whose k_D is known with draws."""
    return Comparison(
        draws.run.measured(), draws.run.predicted(coefficient), draws.measured(), draws.predicted(coefficients)
    )


def life_of_pin(draws: RunDraws, coefficients: Column, depth: float) -> EndOfLife | None:
    """Return where a pin reaches a depth, m. Raises ``ContactError`` for a depth past the tip."""
    problem, values = draws.run.problem, draws.values
    volume = problem.pin(values).volume(depth) / values["normal_load"]
    wearing = (coefficients > 0)[:, None]
    wanted = np.where(wearing, volume / np.where(wearing, coefficients[:, None], 1.0), np.nan)
    return end_of_life(depth, wanted, lambda reached: problem.effective_distance(values, reached), "m")


def exponent(draws: RunDraws, comparison: Comparison, own: Column) -> Exponent | None:
    """Return the local exponent of h(s) late in the run; none where the curve does not rise above zero there."""
    places = draws.run.places[:-1]
    late = places > _LATER_PART * places[-1]
    measured, drawn = comparison.measured[:-1][late], comparison.measured_draws[:, :-1][:, late]
    risen = np.all(drawn > 0, axis=1)
    if np.any(measured <= 0) or np.count_nonzero(risen) < len(risen) / 2:
        return None
    x = np.log(places[late])
    x = x - np.mean(x)
    pull = x / (x @ x)
    spread = float(np.std(np.log(drawn[risen]) @ pull))
    return Exponent(
        measured=Quantity(value=float(np.log(measured) @ pull), unit="1", standard_uncertainty=spread),
        by_law=float(np.log(own[:-1][late]) @ pull),
    )


def _withheld(outcome: Verdict, run: PosedRun) -> Verdict:
    """Return the outcome; a curve that steps, or whose shape rejects a law, does not support it by its end."""
    problem = run.problem
    doubtful = isinstance(problem, DepthProblem) and (
        problem.basis == "measurement" or bool(problem.record.steps) or shape_is_rejected(problem.posterior)
    )
    return "not decidable" if outcome == "supported" and doubtful else outcome


def _meters(value: float) -> Quantity:
    return Quantity(value=float(value), unit="m")


def _curve(asked: Question, run: PosedRun, comparison: Comparison) -> StudyCurve:
    return StudyCurve(
        run.member.id,
        asked.law,
        asked.role,
        run.bodies[0],
        "wear_depth",
        run.problem.contact.progress.signal,
        run.places,
        comparison.predicted,
        *comparison.law_band(),
        MeasuredCurve(comparison.measured, *comparison.measurement_band()),
    )


def _extrapolations(run: PosedRun, comparison: Comparison) -> list[str]:
    """Report where the contact leaves what the wear model describes."""
    contact, values = run.problem.contact, run.problem.values
    notes: list[str] = []
    if contact.pin.shape != "spherical":
        return notes
    load, radius = values["normal_load"], values["pin_radius"]
    pin = run.problem.pin(values)
    worn = float(pin.worn(pin.volume(comparison.predicted[-1])).radius)
    if worn > radius / 2:
        notes.append(
            f"extrapolation: the predicted contact radius of {_meters(worn).shown('um')} is more than half the tip "
            f"radius of {_meters(radius).shown('um')}, beyond the range in which the model was tested"
        )
    modulus = contact_modulus(
        pin_modulus=values["pin_modulus"],
        pin_ratio=contact.pin.poisson_ratio.value,
        disc_modulus=values["disc_modulus"],
        disc_ratio=contact.counterbody.poisson_ratio.value,
    )
    start = float(hertz_radius(normal_load=load, pin_radius=radius, modulus=modulus))
    pressure = 1.5 * load / (np.pi * start**2)
    hardness = [
        body.vickers_hardness for body in (contact.pin, contact.counterbody) if body.vickers_hardness is not None
    ]
    if hardness and pressure > min(hardness) * HARDNESS_UNIT:
        found, softer = (
            Quantity(value=value, unit="Pa").shown("GPa") for value in (pressure, min(hardness) * HARDNESS_UNIT)
        )
        notes.append(
            f"extrapolation: the Hertzian pressure of {found} at the start exceeds the hardness of the softer body, "
            f"{softer}: the material yields before it wears"
        )
    return notes

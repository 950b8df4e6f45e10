"""Runs of a study whose wear was measured on the bodies alone: comparison of each with a law.

The end is judged first, the volume before depth and width, and everything measured on that body together. The law is
rejected for a run where it is for either body; each body has half the probability of a false alarm that a pin has.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.random import Generator

from tribopipe.base.arrays import Column
from tribopipe.base.errors import FitError
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.evaluation.measurements.body_wear import BodyMeasurement
from tribopipe.evaluation.study.member import BodyDraws, Member, at_rotations
from tribopipe.evaluation.study.verdict import (
    CURVE_DRAWS,
    CURVE_PLACES,
    DECISIVE,
    MEASURED_IN,
    Comparison,
    Judgment,
    KnownCoefficient,
    Question,
    body_verdict,
    decide,
    end_of_life,
    volume_curve,
)
from tribopipe.evaluation.wear.inputs import DISC_INPUTS
from tribopipe.evaluation.wear.measurement_fit import measurement_budgets
from tribopipe.evaluation.wear.measurement_problem import MeasurementProblem, measurement_problem
from tribopipe.physics.calculation_methods import WearEngine
from tribopipe.results.input_quantities import Inputs
from tribopipe.results.study import BodyVerdict, EndOfLife, StudyCurve
from tribopipe.results.wear_fit import Contribution


@dataclass(frozen=True)
class MeasuredRun:
    """A run and a law."""

    member: Member
    problem: MeasurementProblem

    engine: ClassVar[WearEngine] = "giwm"
    by_volume: ClassVar[Collection[str]] = ()

    @property
    def inputs(self) -> Inputs:
        """Everything uncertain that k_D depends on."""
        return self.problem.inputs

    @property
    def bodies(self) -> tuple[str, ...]:
        """The bodies whose k_D is found."""
        return self.problem.bodies

    @property
    def end(self) -> Quantity:
        """Sliding distance or rotations at the end of the test."""
        return Quantity(value=float(self.problem.places[-1]), unit="1")

    @cached_property
    def coefficients(self) -> Column:
        """k_D of both bodies by this run alone, m²/N. Raises ``FitError`` where it shows no wear."""
        try:
            return self.problem.coefficients()
        except FitError as error:
            raise FitError(f"{self.member.id}: {error}") from None

    @property
    def scale(self) -> Column:
        """k_D that the budget of each body is relative to, m²/N: without wear, what would have been noticed."""
        found = self.coefficients
        fitted = np.arange(len(found)) < self.problem.unknowns
        return np.where((found > 0) | ~fitted, found, self.problem.scale)

    def may_share(self, names: Sequence[str]) -> tuple[str, ...]:
        """Return which inputs may be off by the same in several runs."""
        return tuple(name for name in names if name in (*DISC_INPUTS, "slip"))

    def budgets(self, length: float | None = None) -> list[tuple[Contribution, ...]]:
        """Return what u of each k_D is made of, for a test ``length`` times as long where that is named."""
        problem = self.problem if length is None else at_rotations(self.problem, self.coefficients, length)
        return measurement_budgets(problem, self.scale)

    def draw(self, rng: Generator, count: int, shared: Mapping[str, Column]) -> "MeasuredDraws":
        """Draw everything uncertain of this run; ``shared`` inputs are taken over from other runs of the study."""
        values = self.problem.draw(rng, count, shared)
        return MeasuredDraws(self, values, self.problem.solve_draws(values, self.coefficients))

    def rows_of(self, body: str) -> list[int]:
        """Return the rows measured on a body, what it is judged by first at the end."""
        rows = [place for place, one in enumerate(self.problem.measurements) if one.body == body]
        return sorted(rows, key=lambda place: _rank(self.problem.measurements[place]))


def _rank(one: BodyMeasurement) -> tuple[float, int]:
    best_last = [*MEASURED_IN][::-1]
    return one.place, best_last.index(one.what)


class MeasuredDraws(BodyDraws[MeasuredRun]):
    """What is drawn of a run, what was measured on its bodies among the values."""


def posed_measurements(member: Member, law: LawName, recipe: Recipe) -> MeasuredRun:
    """Pose the fit of a law to a run. Raises ``FitError`` where the run is missing something for it."""
    problem = measurement_problem(member.corrected.run, law, member.friction, recipe)
    if not isinstance(problem, MeasurementProblem):
        raise FitError(
            f"{member.id}: found a run without {' and '.join(problem)}; expected post-test measurements and, for "
            "a law that includes friction, a friction signal; remove this run from the study"
        )
    return MeasuredRun(member, problem)


def judge_measured(draws: MeasuredDraws, asked: Question) -> Judgment:
    """Hold a law against what was measured on each body whose k_D the study found."""
    run, problem, found = draws.run, draws.run.problem, asked.best.shape[-1]
    best, coefficients = (_all_bodies(problem, one) for one in (asked.best, asked.coefficients))
    bodies = {
        body: _body(place, draws, best, coefficients)
        for place, body in enumerate(problem.contact.fitted_bodies[:found])
        if run.rows_of(body)
    }
    wanted = asked.study.end_of_life
    return Judgment(
        bodies=bodies,
        curves=tuple(_curves(asked, draws, best, coefficients)),
        end_of_life=None if wanted is None else _life(draws, coefficients, wanted.value),
        notes=problem.limits(best),
    )


def _all_bodies(problem: MeasurementProblem, coefficients: Column) -> Column:
    """Return k_D of all bodies, of which one that was not found counts as unworn."""
    missing = len(problem.contact.fitted_bodies) - coefficients.shape[-1]
    return np.concatenate([coefficients, np.zeros((*coefficients.shape[:-1], missing))], axis=-1)


def _body(place: int, draws: MeasuredDraws, best: Column, coefficients: Column) -> BodyVerdict:
    run, problem = draws.run, draws.run.problem
    rows = run.rows_of(problem.contact.fitted_bodies[place])
    comparison = Comparison(
        problem.rows(problem.values)[rows],
        problem.modelled(best, problem.values)[rows],
        problem.rows(draws.values)[:, rows],
        problem.modelled(coefficients, draws.values)[:, rows],
    )

    def with_factor(factor: float) -> Column:
        changed = best.copy()
        changed[place] *= factor
        return np.asarray(problem.modelled(changed, problem.values)[rows])

    own = KnownCoefficient(
        float(run.coefficients[place]), draws.coefficients[:, place], float(best[place]), coefficients[:, place]
    )
    measured = [problem.measurements[row] for row in rows]
    outcome = decide(comparison, with_factor, DECISIVE / 2)
    return body_verdict(comparison, outcome, measured[-1].what, [one.name for one in measured], own)


def _curves(asked: Question, draws: MeasuredDraws, best: Column, coefficients: Column) -> list[StudyCurve]:
    """Return what the law gives for the volumes of both bodies along a run."""
    run, problem = draws.run, draws.run.problem
    places = np.linspace(0.0, 1.0, CURVE_PLACES) ** 1.5 * problem.places[-1]
    some = {name: column[:CURVE_DRAWS] for name, column in draws.values.items()}
    line = problem.wear(best, problem.values, places)
    band = problem.wear(coefficients[:CURVE_DRAWS], some, places)
    along = problem.contact.progress.signal
    volumes = {body: named["wear_volume"] for body, named in problem.wearing.bodies.items()}
    return [
        volume_curve(run.member.id, body, asked, along, places, line[volume], band[volume])
        for body, volume in volumes.items()
    ]


def _life(draws: MeasuredDraws, coefficients: Column, depth: float) -> EndOfLife | None:
    """Return where the first body reaches a depth, m."""
    problem, values = draws.run.problem, draws.values
    each = [coefficients[:, place, None] for place in range(coefficients.shape[-1])]
    known = dict(zip(problem.wearing.coefficients, each, strict=True))
    wanted = problem.wearing.progress_to({**values, **known}, depth)
    return end_of_life(depth, wanted, lambda reached: problem.effective(values, reached), "1")

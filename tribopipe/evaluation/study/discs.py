"""A study of twin-disc runs: k₁ and k₂ of the fitted runs, every run's prediction, and a verdict on each.

As for pins (study/evaluate.py), with what was measured on each disc in the place of a curve: the volume at the end is
judged first, and everything measured on that disc together. The law is called off for a run where it is for either
disc; each disc has half the probability of a false alarm that a pin has.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError, FitError
from tribopipe.base.units import show, show_force, signed
from tribopipe.documents.contact import DISCS, DiscName
from tribopipe.documents.quantity import Quantity, wear_coefficient
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.documents.slip import slip
from tribopipe.documents.study import Study
from tribopipe.evaluation.measurements.twin_disc import DiscMeasurement
from tribopipe.evaluation.study.combine import Combination, combine
from tribopipe.evaluation.study.member import Member, chosen
from tribopipe.evaluation.study.verdict import DECISIVE, Comparison, decide, ratio, single_run_note
from tribopipe.evaluation.wear.inputs import DISC_INPUTS, default_notes
from tribopipe.evaluation.wear.measurement_problem import MeasurementProblem, measurement_problem
from tribopipe.physics.laws import law_heading, law_named
from tribopipe.physics.uncertainty import TAILS, propagate_together
from tribopipe.results.agreement import (
    BodyVerdict,
    EndOfLife,
    LawResult,
    LeftOut,
    Role,
    RunVerdict,
    StudiedBody,
    StudyResult,
    Verdict,
)
from tribopipe.results.study_curves import Evaluation, StudyCurve
from tribopipe.results.wear_fit import spoken

_FIRST = ("track_width", "wear_depth", "wear_volume")
"""What a disc is judged by first, the best last."""
_SHOWN = {"wear_volume": "mm^3", "wear_depth": "um", "track_width": "um"}
_PLACES = 30
_CURVE_DRAWS = 1_000
"""Of a band; its ends lie on a smooth curve."""
_ITERATIONS = 40


def evaluate_discs(
    study: Study, members: Mapping[str, Member], recipe: Recipe | None = None, left_out: Sequence[LeftOut] = ()
) -> Evaluation:
    """Evaluate a study of twin-disc runs, ``members`` by id; runs left out are only named.

    Raises ``FitError`` where no run is left to fit, where runs differ in bodies or medium, or where a run lacks
    something that the law needs.
    """
    recipe = recipe or Recipe()
    fit, predict = chosen(study, members, left_out)
    laws = [_Law(study, law, recipe, fit, predict) for law in study.laws]
    results = tuple(law.result() for law in laws)
    notes = single_run_note([member.id for member in fit])
    result = StudyResult(
        id=study.id,
        title=study.title,
        tribometer=fit[0].corrected.run.manifest.described.kind,
        laws=results,
        left_out=tuple(left_out),
        notes=notes,
    )
    return Evaluation(result, tuple(curve for law in laws for curve in law.curves))


@dataclass(frozen=True)
class PosedDiscs:
    """A run and a law."""

    member: Member
    problem: MeasurementProblem

    @cached_property
    def coefficients(self) -> Column:
        """k₁ and k₂ of this run alone, m²/N. Raises ``FitError`` where it shows no wear."""
        try:
            return self.problem.coefficients()
        except FitError as error:
            raise FitError(f"{self.member.id}: {error}") from None

    def draw(self, rng: Generator, count: int, shared: Mapping[str, Column]) -> "_Draws":
        """Draw everything uncertain of this run; ``shared`` inputs are taken over from other runs of the study."""
        values = self.problem.draw(rng, count, shared)
        return _Draws(self, values, self.problem.solve_draws(values, self.coefficients))

    def rows_of(self, disc: DiscName) -> list[int]:
        """Return the rows measured on a disc, what it is judged by first at the end."""
        rows = [place for place, one in enumerate(self.problem.measurements) if one.disc == disc]
        return sorted(rows, key=lambda place: _rank(self.problem.measurements[place]))


def _rank(one: DiscMeasurement) -> tuple[float, int]:
    return one.rotations, _FIRST.index(one.what)


@dataclass(frozen=True)
class _Draws:
    """A run's inputs, what was measured among them, and own k₁ and k₂ in each draw."""

    run: PosedDiscs
    values: dict[str, Column]
    coefficients: Column
    """m²/N, (draws, 2); NaN where a draw has no solution."""

    def kept(self, accepted: NDArray[np.bool_]) -> "_Draws":
        values = {name: column[accepted] for name, column in self.values.items()}
        return _Draws(self.run, values, self.coefficients[accepted])


class _Law:
    """One law of a study."""

    def __init__(
        self, study: Study, law: LawName, recipe: Recipe, fit: Sequence[Member], predict: Sequence[Member]
    ) -> None:
        self.study, self.law, self.recipe = study, law, recipe
        self.fitted = [posed_discs(member, law, recipe) for member in fit]
        self.predicted = [posed_discs(member, law, recipe) for member in predict]
        self.one_sided = all(run.problem.one_sided for run in self.fitted)
        _refuse_mixture(study.id, self.fitted)
        _refuse_no_wear(study.id, self.fitted, self.discs)
        self.curves: list[StudyCurve] = []
        self._combined: list[Combination] = []
        self._first: list[tuple[Generator, dict[str, Column], list[_Draws], Column]] = []

    @property
    def discs(self) -> tuple[DiscName, ...]:
        """The discs whose k_D is found."""
        return DISCS[:1] if self.one_sided else DISCS

    def result(self) -> LawResult:
        """Identify k₁ and k₂, and hold the law against every run."""
        how = self.recipe.monte_carlo
        found = propagate_together(self._draw, digits=max(1, how.significant_digits), seed=how.seed)
        rng, shared, fitted, following = self._first[0]
        best = self._best()
        judged = [self._judge(one, "fitted", best, following) for one in fitted]
        judged += [
            self._judge(run.draw(rng, len(following), shared), "predicted", best, following) for run in self.predicted
        ]
        return LawResult(
            model=self.law,
            distance_per_rotation=self.recipe.wear.distance_per_rotation,
            bodies={
                disc: StudiedBody(
                    wear_coefficient=wear_coefficient(best[place], found[place].standard_uncertainty),
                    interval=(wear_coefficient(found[place].interval[0]), wear_coefficient(found[place].interval[1])),
                    between_runs=self._combined[place].summary,
                )
                for place, disc in enumerate(self.discs)
            },
            correlation=None if self.one_sided else float(np.corrcoef(found[0].draws, found[1].draws)[0, 1]),
            draws=len(found[0].draws),
            rejected=found[0].rejected,
            runs=tuple(judged),
        )

    def _draw(self, rng: Generator, count: int) -> Column:
        """Draw k₁ and k₂ of the study: the model of JCGM 102."""
        names = [name for name in self.study.shared if name in (*DISC_INPUTS, "slip")]
        shared = {name: rng.standard_normal(count) for name in (*names, *law_named(self.law).inputs())}
        drawn = [run.draw(rng, count, shared) for run in self.fitted]
        solved = np.stack([one.coefficients for one in drawn], axis=1)
        if not self._combined:
            sound = solved[np.all(np.isfinite(solved), axis=(1, 2))]
            ids = [run.member.id for run in self.fitted]
            self._combined = [
                combine(ids, [float(run.coefficients[place]) for run in self.fitted], sound[:, :, place])
                for place in range(len(self.discs))
            ]
        both = [one.draw(solved[:, :, place], rng) for place, one in enumerate(self._combined)]
        mean, following = (np.stack([pair[which] for pair in both], axis=-1) for which in (0, 1))
        if not self._first:
            accepted = np.all(np.isfinite(mean), axis=1)
            kept = {name: errors[accepted] for name, errors in shared.items()}
            self._first.append((rng, kept, [one.kept(accepted) for one in drawn], _both(following[accepted])))
        return mean

    def _best(self) -> Column:
        roots = np.sqrt([run.coefficients for run in self.fitted])
        return _both(np.array([float(roots[:, place] @ one.weights) ** 2 for place, one in enumerate(self._combined)]))

    def _judge(self, draws: _Draws, role: Role, best: Column, coefficients: Column) -> RunVerdict:
        try:
            return self._verdict(draws, role, best, coefficients)
        except ContactError as error:
            raise ContactError(f"{draws.run.member.id}: {error}") from None

    def _verdict(self, draws: _Draws, role: Role, best: Column, coefficients: Column) -> RunVerdict:
        run, problem = draws.run, draws.run.problem
        self.curves += _curves(self.law, role, draws, best, coefficients)
        discs: dict[str, BodyVerdict] = {
            disc: self._disc(disc, draws, best, coefficients) for disc in self.discs if run.rows_of(disc)
        }
        manifest = run.member.corrected.run.manifest
        verdict = RunVerdict(
            id=run.member.id,
            role=role,
            normal_load=manifest.conditions.normal_load,
            slip=slip(manifest),
            end=_turns(problem.places[-1]),
            outcome=_worst([*discs.values()]),
            sentence="",
            notes=(*problem.limits(best), *default_notes(problem.inputs)),
            bodies=discs,
            end_of_life=self._end_of_life(draws, coefficients),
        )
        return verdict.model_copy(update={"sentence": _sentence(self.law, verdict)})

    def _disc(self, disc: DiscName, draws: _Draws, best: Column, coefficients: Column) -> BodyVerdict:
        run, problem, rows, place = draws.run, draws.run.problem, draws.run.rows_of(disc), DISCS.index(disc)
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

        last, together = problem.measurements[rows[-1]], comparison.along(0.05)
        worst = int(np.argmax(np.abs(together)))
        unit = last.quantity.unit
        own, drawn = float(run.coefficients[place]), draws.coefficients[:, place]
        return BodyVerdict(
            outcome=decide(comparison, with_factor, DECISIVE / 2),
            what=last.what,
            measured=_spread(comparison.measured, comparison.measured_draws, unit),
            predicted=_spread(comparison.predicted, comparison.predicted_draws, unit),
            predicted_interval=_ends(comparison.law_band(), unit),
            measurement_interval=_ends(comparison.measurement_band(), unit),
            e_n=float(comparison.deviation[-1] / comparison.limits(0.05)[-1]),
            e_n_all=float(together[worst]),
            e_n_all_at=problem.measurements[rows[worst]].name,
            wear_coefficient=wear_coefficient(own, float(np.nanstd(drawn))),
            coefficient_ratio=ratio(own, drawn, float(best[place]), coefficients[:, place]),
        )

    def _end_of_life(self, draws: _Draws, coefficients: Column) -> EndOfLife | None:
        wanted = self.study.end_of_life
        return None if wanted is None else _rotations_to(draws, coefficients, wanted.value)


def posed_discs(member: Member, law: LawName, recipe: Recipe) -> PosedDiscs:
    """Pose the fit of a law to a run. Raises ``FitError`` where the run lacks something for it."""
    problem = measurement_problem(member.corrected.run, law, member.friction, recipe)
    if not isinstance(problem, MeasurementProblem):
        raise FitError(
            f"{member.id}: found a run that lacks {' and '.join(problem)}; expected end values and, for Sarkar's law, "
            "friction; take it out of the study"
        )
    return PosedDiscs(member, problem)


def _refuse_mixture(study_id: str, fitted: Sequence[PosedDiscs]) -> None:
    """Refuse to take one k₂ from runs of which some say nothing of the flat disc."""
    silent = [run.member.id for run in fitted if run.problem.one_sided]
    if silent and len(silent) < len(fitted):
        raise FitError(
            f"{study_id}: found nothing measured on the flat disc of {silent[0]}, but on that of other runs; expected "
            "the same on all runs that identify k_D; take it out of fit, or measure it"
        )


def _refuse_no_wear(study_id: str, fitted: Sequence[PosedDiscs], discs: Sequence[DiscName]) -> None:
    """Refuse a disc that no run shows any wear of: nothing could be predicted from it."""
    for place, disc in enumerate(discs):
        if not any(run.coefficients[place] > 0 for run in fitted):
            raise FitError(
                f"{study_id}: found no wear of the {spoken(disc)} in any run that identifies k_D; expected some; leave "
                "its end values out of run.toml, so that it counts as unworn"
            )


def _both(coefficients: Column) -> Column:
    """Return k₁ and k₂ where the flat disc may count as unworn."""
    missing = 2 - coefficients.shape[-1]
    return np.concatenate([coefficients, np.zeros((*coefficients.shape[:-1], missing))], axis=-1)


def _worst(discs: Sequence[BodyVerdict]) -> Verdict:
    departing = [disc for disc in discs if disc.outcome in ("over-predicts", "under-predicts")]
    if departing:
        return max(departing, key=lambda disc: abs(disc.e_n)).outcome
    return "not decidable" if any(disc.outcome == "not decidable" for disc in discs) else "supported"


def _curves(law: LawName, role: Role, draws: _Draws, best: Column, coefficients: Column) -> list[StudyCurve]:
    """Return what the law says of both discs' volumes along a run."""
    run, problem = draws.run, draws.run.problem
    rotations = np.linspace(0.0, 1.0, _PLACES) ** 1.5 * problem.places[-1]
    some = {name: column[:_CURVE_DRAWS] for name, column in draws.values.items()}
    line = problem.wear(best, problem.values, rotations)
    band = problem.wear(coefficients[:_CURVE_DRAWS], some, rotations)
    found = []
    for disc, field in zip(DISCS, ("curved_volume", "flat_volume"), strict=True):
        low, high = np.quantile(band[field], TAILS, axis=0)
        best_volume = line[field]
        along = problem.contact.progress.signal
        found.append(
            StudyCurve(run.member.id, law, role, disc, "wear_volume", along, rotations, best_volume, low, high)
        )
    return found


def _rotations_to(draws: _Draws, coefficients: Column, depth: float) -> EndOfLife | None:
    """Return where the curved disc reaches a depth, m, for draws of k₁ and k₂; none where k₁ is rather zero.

    N_eff(N) = N* is solved by N ← N·N*/N_eff(N): N_eff/N changes slowly.
    """
    problem, values = draws.run.problem, draws.values
    known = dict(zip(problem.wearing.coefficients, (coefficients[:, :1], coefficients[:, 1:]), strict=True))
    wanted = problem.wearing.progress_to({**values, **known}, depth)
    reached = np.where(np.isfinite(wanted), wanted, np.nan)
    for _ in range(_ITERATIONS):
        reached = reached * wanted / problem.effective(values, reached)
    low, middle, high = np.quantile(
        np.where(np.isfinite(reached), reached, np.inf), [TAILS[0], 0.5, TAILS[1]], method="inverted_cdf"
    )
    if not np.isfinite(middle):
        return None
    return EndOfLife(
        wear_depth=Quantity(value=depth, unit="m"),
        place=_turns(middle),
        interval=(_turns(low), _turns(high) if np.isfinite(high) else None),
    )


def _turns(value: float) -> Quantity:
    return Quantity(value=float(value), unit="1")


def _spread(values: Column, draws: Column, unit: str) -> Quantity:
    return Quantity(value=float(values[-1]), unit=unit, standard_uncertainty=float(np.std(draws[:, -1])))


def _ends(band: tuple[Column, Column], unit: str) -> tuple[Quantity, Quantity]:
    low, high = (float(side[-1]) for side in band)
    return Quantity(value=max(low, 0.0), unit=unit), Quantity(value=high, unit=unit)


def _sentence(law: LawName, verdict: RunVerdict) -> str:
    """Say the outcome as a tribologist would."""
    load, slipping = (
        show_force(verdict.normal_load.value),
        "" if verdict.slip is None else show(verdict.slip.value, None, "1", "%"),
    )
    where = f"at {load} and {slipping} slip"
    parts = []
    for name, disc in verdict.bodies.items():
        unit = _SHOWN[disc.what]
        low, high = (end.shown(unit) for end in disc.predicted_interval)
        parts.append(
            f"{spoken(name)} {disc.predicted.shown(unit)} {verdict.role} (95 % interval {low} to {high}) against "
            f"{disc.measured.shown(unit)} measured, E_n = {signed(disc.e_n, 2)}"
        )
    said = f"after {verdict.end.value:,.0f} rotations {'; '.join(parts)}"
    law_name = law_heading(law)
    ratios = " and ".join(f"{disc.coefficient_ratio}" for disc in verdict.bodies.values())
    if verdict.outcome == "supported":
        way = "follows" if verdict.role == "fitted" else "predicts"
        return f"{law_name} {way} the wear {where}: {said}."
    by_itself = f"by itself this run has {ratios} times those k_D"
    if verdict.outcome == "not decidable":
        return f"Whether {law_name} holds {where} cannot be decided with this uncertainty: {said}; {by_itself}."
    return f"{law_name} {verdict.outcome} the wear {where}: {said}; {by_itself}."

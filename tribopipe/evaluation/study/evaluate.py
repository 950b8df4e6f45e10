"""A study from beginning to end: k_D of the fitted runs, every run's prediction, and the agreement of each.

It is the same for every contact; runs are compared with a law as they are known: by the wear that a
sensor recorded along them, or by what was measured on the bodies alone.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.random import Generator

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError, FitError
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.quantity import wear_coefficient
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.documents.study import Study
from tribopipe.evaluation.study.measured_runs import MeasuredDraws, MeasuredRun, judge_measured, posed_measurements
from tribopipe.evaluation.study.member import Member, PosedRun, RunDraws, chosen
from tribopipe.evaluation.study.random_effects import Combination, combine
from tribopipe.evaluation.study.recorded_runs import Shape, compare_laws, judge_recorded, one_engine
from tribopipe.evaluation.study.verdict import Question, sentence, single_run_note, worst_outcome
from tribopipe.evaluation.wear.inputs import default_notes
from tribopipe.physics.laws import law_named
from tribopipe.physics.uncertainty import propagate_together
from tribopipe.results.study import (
    Evaluation,
    LawComparison,
    LawResult,
    LeftOut,
    Role,
    RunVerdict,
    StudiedBody,
    StudyCurve,
    StudyResult,
)


def evaluate(
    study: Study, members: Mapping[str, Member], recipe: Recipe | None = None, left_out: Sequence[LeftOut] = ()
) -> Evaluation:
    """Evaluate a study on its runs, ``members`` by id; runs left out are only named.

    Raises ``FitError`` where no run is left to fit, where runs differ in bodies or environment, or where a run does
    not have something that the law needs.
    """
    recipe = recipe or Recipe()
    fit, predict = chosen(study, members, left_out)
    recorded = is_recorded(fit[0].corrected.run.manifest)
    recipe = one_engine(recipe, fit) if recorded else recipe
    laws = {law: _Law(study, law, recipe, fit, predict) for law in study.laws}
    results = tuple(law.result() for law in laws.values())
    comparisons: dict[str, LawComparison] = {}
    if {"archard", "sarkar"} <= laws.keys():
        archard, sarkar = laws["archard"].shapes, laws["sarkar"].shapes
        comparisons = {run_id: compare_laws(archard[run_id], sarkar[run_id]) for run_id in archard}
    result = StudyResult(
        id=study.id,
        title=study.title,
        tribometer=fit[0].corrected.run.manifest.described.kind,
        correction=recipe.wear.correction if recorded else None,
        laws=results,
        comparisons=comparisons,
        left_out=tuple(left_out),
        notes=(*_limits([*fit, *predict]), *single_run_note([member.id for member in fit])),
    )
    return Evaluation(result, tuple(curve for law in laws.values() for curve in law.curves))


def is_recorded(manifest: RunManifest) -> bool:
    """Return whether the wear of a run is known by what a sensor recorded along it."""
    return manifest.contact is None or manifest.contact.sensor_tells


def posed(member: Member, law: LawName, recipe: Recipe) -> PosedRun | MeasuredRun:
    """Pose the fit of a law to a run. Raises ``FitError`` where the run is missing something for it."""
    if is_recorded(member.corrected.run.manifest):
        return member.pose(law, recipe)
    return posed_measurements(member, law, recipe)


def _limits(members: Sequence[Member]) -> tuple[str, ...]:
    """Return what the contacts of runs assume, each once."""
    contacts = (member.corrected.run.manifest.described for member in members)
    return tuple(dict.fromkeys(limit for contact in contacts for limit in contact.limits))


class _Law:
    """One law of a study."""

    def __init__(
        self, study: Study, law: LawName, recipe: Recipe, fit: Sequence[Member], predict: Sequence[Member]
    ) -> None:
        self.study, self.law, self.recipe = study, law, recipe
        self.fitted = [posed(member, law, recipe) for member in fit]
        self.predicted = [posed(member, law, recipe) for member in predict]
        self.bodies = max((run.bodies for run in self.fitted), key=len)
        _refuse_mixture(study.id, self.fitted, self.bodies)
        _refuse_no_wear(study.id, self.fitted, self.bodies)
        every = (*self.fitted, *self.predicted)
        self.shapes = {run.member.id: Shape(run) for run in every if isinstance(run, PosedRun)}
        self.curves: list[StudyCurve] = []
        self._combined: list[Combination] = []
        self._first: list[tuple[Generator, dict[str, Column], list[RunDraws | MeasuredDraws], Column]] = []

    def result(self) -> LawResult:
        """Identify k_D of each body, and hold the law against every run."""
        how = self.recipe.monte_carlo
        found = propagate_together(self._draw, digits=max(1, how.significant_digits), seed=how.seed)
        rng, shared, fitted, following = self._first[0]
        best = self._best()
        judged = [self._judge(one, "fitted", best, following) for one in fitted]
        judged += [
            self._judge(run.draw(rng, len(following), shared), "predicted", best, following) for run in self.predicted
        ]
        first = self.fitted[0]
        rolling = first.member.corrected.run.manifest.slip is not None
        return LawResult(
            model=self.law,
            engine=first.problem.engine if isinstance(first, PosedRun) else "giwm",
            distance_per_rotation=self.recipe.wear.distance_per_rotation if rolling else None,
            bodies={
                body: StudiedBody(
                    wear_coefficient=wear_coefficient(float(value), one.standard_uncertainty),
                    interval=(wear_coefficient(one.interval[0]), wear_coefficient(one.interval[1])),
                    between_runs=combined.summary,
                )
                for body, value, one, combined in zip(self.bodies, best, found, self._combined, strict=True)
            },
            correlation=float(np.corrcoef(found[0].draws, found[1].draws)[0, 1]) if len(found) > 1 else None,
            draws=len(found[0].draws),
            rejected=found[0].rejected,
            runs=tuple(judged),
        )

    def _draw(self, rng: Generator, count: int) -> Column:
        """Draw k_D of each body by the study: the model of JCGM 102."""
        names = (*self.fitted[0].may_share(self.study.shared), *law_named(self.law).inputs())
        shared = {name: rng.standard_normal(count) for name in names}
        drawn = [run.draw(rng, count, shared) for run in self.fitted]
        solved = np.stack([one.coefficients for one in drawn], axis=1)
        if not self._combined:
            self._combined = self._combine(solved[np.all(np.isfinite(solved), axis=(1, 2))])
        both = [one.draw(solved[:, :, place], rng) for place, one in enumerate(self._combined)]
        mean, following = (np.stack([pair[which] for pair in both], axis=-1) for which in (0, 1))
        if not self._first:
            accepted = np.all(np.isfinite(mean), axis=1)
            kept = {name: errors[accepted] for name, errors in shared.items()}
            self._first.append((rng, kept, [one.kept(accepted) for one in drawn], following[accepted]))
        return mean

    def _combine(self, solved: Column) -> list[Combination]:
        ids = [run.member.id for run in self.fitted]
        return [
            combine(ids, [float(run.coefficients[place]) for run in self.fitted], solved[:, :, place])
            for place in range(len(self.bodies))
        ]

    def _best(self) -> Column:
        roots = np.sqrt([run.coefficients for run in self.fitted])
        return np.array([float(roots[:, place] @ one.weights) ** 2 for place, one in enumerate(self._combined)])

    def _judge(self, draws: RunDraws | MeasuredDraws, role: Role, best: Column, coefficients: Column) -> RunVerdict:
        run, asked = draws.run, Question(self.study, self.law, self.recipe, role, best, coefficients)
        name, manifest = run.member.id, run.member.corrected.run.manifest
        try:
            found = (
                judge_recorded(draws, asked, self.shapes[name])
                if isinstance(draws, RunDraws)
                else judge_measured(draws, asked)
            )
        except ContactError as error:
            raise ContactError(f"{name}: {error}") from None
        self.curves += found.curves
        verdict = RunVerdict(
            id=name,
            role=role,
            normal_load=manifest.conditions.normal_load,
            slip=manifest.slip,
            end=run.end,
            outcome=worst_outcome(found.bodies.values()),
            sentence="",
            notes=(*found.notes, *default_notes(run.problem.inputs)),
            findings=found.findings,
            bodies=found.bodies,
            end_of_life=found.end_of_life,
        )
        return verdict.model_copy(update={"sentence": sentence(self.law, verdict)})


def _refuse_mixture(study_id: str, fitted: Sequence[PosedRun | MeasuredRun], bodies: Sequence[str]) -> None:
    """Refuse to take k_D of a body from runs some of which do not have it."""
    for body in bodies:
        silent = [run.member.id for run in fitted if body not in run.bodies]
        if silent:
            raise FitError(
                f"{study_id}: found no measurement of the {spoken(body)} in {silent[0]}, although other runs have "
                "one; expected the same for all runs that identify k_D; remove the run from fit, or add the measurement"
            )


def _refuse_no_wear(study_id: str, fitted: Sequence[PosedRun | MeasuredRun], bodies: Sequence[str]) -> None:
    """Refuse a second body that no run shows any wear of: nothing could be predicted from it."""
    for place, body in enumerate(bodies[1:], 1):
        if not any(run.coefficients[place] > 0 for run in fitted):
            raise FitError(
                f"{study_id}: found no wear of the {spoken(body)} in any run that identifies k_D; expected wear; "
                "remove its measurements from run.toml, so that it is assumed to be unworn"
            )

"""A study from beginning to end: k_D of the fitted runs, every run's prediction, and the agreement of each.

It is the same for every contact; runs are compared with a law as they are known: by the wear that a
sensor recorded along them, or by what was measured on the bodies alone.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.random import Generator

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError, FitError
from tribopipe.documents.contact_kinds import body_like, spoken
from tribopipe.documents.quantity import wear_coefficient
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.documents.study import Study, in_another_geometry
from tribopipe.evaluation.study.measured_runs import MeasuredDraws, MeasuredRun, judge_measured, posed_measurements
from tribopipe.evaluation.study.member import Member, PosedRun, RunDraws, chosen, copies_note
from tribopipe.evaluation.study.pressure_exponent import pressed_run, pressure_exponent
from tribopipe.evaluation.study.random_effects import DEPTHS, VOLUMES, Combination, combine
from tribopipe.evaluation.study.recorded_pairs import PairDraws, RecordedPair, judge_pair, with_counterbody
from tribopipe.evaluation.study.recorded_runs import Shape, compare_laws, judge_recorded, one_engine
from tribopipe.evaluation.study.verdict import Judgment, Question, sentence, single_run_note, worst_outcome
from tribopipe.evaluation.study.volume_runs import VolumeDraws, VolumeRun, judge_volumes, posed_volumes
from tribopipe.evaluation.wear.inputs import default_notes
from tribopipe.physics.laws import law_named
from tribopipe.physics.uncertainty import propagate_together
from tribopipe.results.study import (
    Evaluation,
    LawResult,
    LeftOut,
    PressureExponent,
    Role,
    RunVerdict,
    StudiedBody,
    StudyCurve,
    StudyResult,
)

StudiedRun = PosedRun | MeasuredRun | VolumeRun | RecordedPair
Draws = RunDraws | MeasuredDraws | VolumeDraws | PairDraws


def evaluate(
    study: Study, members: Mapping[str, Member], recipe: Recipe | None = None, left_out: Sequence[LeftOut] = ()
) -> Evaluation:
    """Evaluate a study on its runs, ``members`` by id; runs left out are only named.

    Raises ``FitError`` where no run is left to fit, where runs differ in bodies or environment, or where a run does
    not have something that the law needs.
    """
    recipe = recipe or Recipe()
    fit, predict = chosen(study, members, left_out)
    recorded = [member for member in fit if member.has_curve]
    recipe = one_engine(recipe, recorded) if recorded else recipe
    laws = {law: _Law(study, law, recipe, fit, predict) for law in study.laws}
    results = tuple(law.result() for law in laws.values())
    compared = {
        run_id: compare_laws({name: law.shapes[run_id] for name, law in laws.items()})
        for run_id in next(iter(laws.values())).shapes
        if len(laws) > 1
    }
    result = StudyResult(
        id=study.id,
        title=study.title,
        tribometer=fit[0].corrected.run.manifest.described.kind,
        correction=recipe.wear.correction if recorded else None,
        laws=results,
        comparisons={run_id: found for run_id, found in compared.items() if found is not None},
        left_out=tuple(left_out),
        notes=(
            *_limits([*fit, *predict]),
            *single_run_note([member.id for member in fit]),
            *copies_note([*fit, *predict]),
            *_geometry_note(fit, predict),
        ),
    )
    return Evaluation(result, tuple(curve for law in laws.values() for curve in law.curves))


def posed(member: Member, law: LawName, recipe: Recipe) -> StudiedRun:
    """Pose the fit of a law to a run. Raises ``FitError`` where the run is missing something for it."""
    manifest = member.corrected.run.manifest
    if manifest.contact is not None and not manifest.contact.sensor_tells:
        return posed_measurements(member, law, recipe)
    by_volume = None if member.has_curve or manifest.contact is None else posed_volumes(member, law, recipe)
    return by_volume or with_counterbody(member.pose(law, recipe), law, recipe)


def _limits(members: Sequence[Member]) -> tuple[str, ...]:
    """Return what the contacts of runs assume, each once."""
    contacts = (member.corrected.run.manifest.described for member in members)
    return tuple(dict.fromkeys(limit for contact in contacts for limit in contact.limits))


def _geometry_note(fit: Sequence[Member], predict: Sequence[Member]) -> tuple[str, ...]:
    first, *_ = (member.corrected.run.manifest for member in fit)
    others = in_another_geometry(first, [member.corrected.run.manifest for member in predict])
    if not others:
        return ()
    return (
        f"{', '.join(others)}: predicted with the same k_D for a contact or geometry different from that of "
        f"{first.id}: the bands account for the effect of pressure, but not for other effects, such as those of heat, "
        "debris or surface finish",
    )


class _Law:
    """One law of a study."""

    def __init__(
        self, study: Study, law: LawName, recipe: Recipe, fit: Sequence[Member], predict: Sequence[Member]
    ) -> None:
        self.study, self.law, self.recipe = study, law, recipe
        self.fitted = [posed(member, law, recipe) for member in fit]
        self.predicted = [posed(member, law, recipe) for member in predict]
        self.bodies = _bodies(study.id, self.fitted)
        self.fitted, self.predicted = (
            [_restricted(study.id, run, self._named_by(run)) for run in runs] for runs in (self.fitted, self.predicted)
        )
        every = (*self.fitted, *self.predicted)
        self.shapes = {run.member.id: Shape(run) for run in map(_recorded, every) if run is not None}
        self.curves: list[StudyCurve] = []
        self._combined: list[Combination] = []
        self._first: tuple[Generator, dict[str, Column], list[Draws], Column]
        """From the first draws: shared errors, draws of each run, and k_D of a further run."""

    def result(self) -> LawResult:
        """Identify k_D of each body, and hold the law against every run."""
        how = self.recipe.monte_carlo
        found = propagate_together(self._draw, digits=max(1, how.significant_digits), seed=how.seed)
        rng, shared, fitted, following = self._first
        best = self._best()
        predicted = [run.draw(rng, len(following), shared) for run in self.predicted]
        judged = [self._judge(one, "fitted", best, following) for one in fitted]
        judged += [self._judge(one, "predicted", best, following) for one in predicted]
        first = self.fitted[0]
        rolling = first.member.corrected.run.manifest.slip is not None
        return LawResult(
            model=self.law,
            engine=next((run.engine for run in self.fitted if _recorded(run) is not None), first.engine),
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
            pressure_exponent=self._pressure_exponent([*fitted, *predicted]),
            draws=len(found[0].draws),
            rejected=found[0].rejected,
            runs=tuple(judged),
        )

    def _pressure_exponent(self, draws: Sequence[Draws]) -> PressureExponent | None:
        """Return how the wear rate of the first body depends on the pressure of all runs."""
        pressed = [
            pressed_run(
                one.run.member,
                dict(zip(one.run.bodies, one.run.coefficients.tolist(), strict=False)),
                one.coefficients[:, 0],
                one.run.end.value,
                self.law,
                self.recipe,
            )
            for one in draws
            if one.run.bodies[0] == _name_in(one.run, self.bodies[0])
        ]
        return pressure_exponent([run for run in pressed if run is not None])

    def _draw(self, rng: Generator, count: int) -> Column:
        """Draw k_D of each body by the study: the model of JCGM 102."""
        names = (name for run in self.fitted for name in run.may_share(self.study.shared))
        shared = {name: rng.standard_normal(count) for name in dict.fromkeys((*names, *law_named(self.law).inputs()))}
        drawn = [run.draw(rng, count, shared) for run in self.fitted]
        solved = np.stack([one.coefficients for one in drawn], axis=1)
        is_first = not self._combined
        if is_first:
            self._combined = self._combine(solved[np.all(np.isfinite(solved), axis=(1, 2))])
        both = [one.draw(solved[:, :, place], rng) for place, one in enumerate(self._combined)]
        mean, following = (np.stack([pair[which] for pair in both], axis=-1) for which in (0, 1))
        if is_first:
            accepted = np.all(np.isfinite(mean), axis=1)
            kept = {name: errors[accepted] for name, errors in shared.items()}
            self._first = rng, kept, [one.kept(accepted) for one in drawn], following[accepted]
        return mean

    def _combine(self, solved: Column) -> list[Combination]:
        ids = [run.member.id for run in self.fitted]
        return [
            combine(
                ids,
                [float(run.coefficients[place]) for run in self.fitted],
                solved[:, :, place],
                VOLUMES if any(_name_in(run, body) in run.by_volume for run in self.fitted) else DEPTHS,
            )
            for place, body in enumerate(self.bodies)
        ]

    def _best(self) -> Column:
        each = np.array([run.coefficients for run in self.fitted])
        return np.array([one.best(each[:, place]) for place, one in enumerate(self._combined)])

    def _judge(self, draws: Draws, role: Role, best: Column, coefficients: Column) -> RunVerdict:
        run, asked = (
            draws.run,
            Question(self.study, self.law, self.recipe, role, best, coefficients, self._named_by(draws.run)),
        )
        name, manifest = run.member.id, run.member.corrected.run.manifest
        try:
            found = self._judgment(draws, asked)
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
            notes=(*found.notes, *default_notes(run.inputs)),
            findings=found.findings,
            bodies=found.bodies,
            end_of_life=found.end_of_life,
        )
        return verdict.model_copy(update={"sentence": sentence(self.law, verdict)})

    def _named_by(self, run: StudiedRun) -> tuple[str, ...]:
        """Return the bodies of the study as a run names them: a pin may be a ball in another one, or a block."""
        return tuple(_name_in(run, body) for body in self.bodies)

    def _judgment(self, draws: Draws, asked: Question) -> Judgment:
        if isinstance(draws, RunDraws):
            return judge_recorded(draws, asked, self.shapes[draws.run.member.id])
        if isinstance(draws, PairDraws):
            return judge_pair(draws, asked, self.shapes[draws.run.member.id])
        return judge_volumes(draws, asked) if isinstance(draws, VolumeDraws) else judge_measured(draws, asked)


def _bodies(study_id: str, fitted: Sequence[StudiedRun]) -> tuple[str, ...]:
    """Return the bodies whose k_D the runs identify: of two discs all, otherwise those that each run has measured.

    Raises ``FitError`` where there is none, or none that has worn.
    """
    most = max((run.bodies for run in fitted), key=len)
    if isinstance(fitted[0], MeasuredRun):
        _refuse_mixture(study_id, fitted, most)
        _refuse_no_wear(study_id, fitted, most[1:])
        return most
    most = tuple(_name_in(fitted[0], body) for body in most)
    common = tuple(body for body in most if all(_name_in(run, body) in run.bodies for run in fitted))
    if not common:
        _refuse_mixture(study_id, fitted, most)
    worn = tuple(body for body in common if any(_coefficient(run, body) > 0 for run in fitted))
    if not worn:
        _refuse_no_wear(study_id, fitted, common)
    return worn


def _name_in(run: StudiedRun, body: str) -> str:
    """Return what a run calls a body of the study."""
    return body_like(run.member.corrected.run.manifest.described, body)


def _coefficient(run: StudiedRun, body: str) -> float:
    """Return k_D of a body of the study by one run alone, m²/N."""
    return float(run.coefficients[run.bodies.index(_name_in(run, body))])


def _recorded(run: StudiedRun) -> PosedRun | None:
    """Return the part of a run whose wear a sensor recorded; None if there is none."""
    run = run.pin if isinstance(run, RecordedPair) else run
    return run if isinstance(run, PosedRun) else None


def _restricted(study_id: str, run: StudiedRun, bodies: Sequence[str]) -> StudiedRun:
    """Return a run as it identifies k_D of some bodies. Raises ``FitError`` where it has measured none of them."""
    some = run.of(bodies) if isinstance(run, VolumeRun | RecordedPair) else run
    if some is None or not set(some.bodies) & set(bodies):
        raise FitError(
            f"{study_id}: found no measurement of the {' or '.join(map(spoken, bodies))} in {run.member.id}; expected "
            "one, since the study does not identify k_D of any other body; remove the run from the study, or add the "
            "measurement"
        )
    return some


def _refuse_mixture(study_id: str, fitted: Sequence[StudiedRun], bodies: Sequence[str]) -> None:
    """Refuse to take k_D of a body from runs some of which do not have it."""
    for body in bodies:
        silent = [run.member.id for run in fitted if _name_in(run, body) not in run.bodies]
        if silent:
            raise FitError(
                f"{study_id}: found no measurement of the {spoken(body)} in {silent[0]}, although other runs have one; "
                "expected the same measurements in all runs from which k_D is identified; remove the run from fit, or "
                "add the measurement"
            )


def _refuse_no_wear(study_id: str, fitted: Sequence[StudiedRun], bodies: Sequence[str]) -> None:
    """Refuse a body that no run shows any wear of: nothing could be predicted from it."""
    for body in bodies:
        if not any(_coefficient(run, body) > 0 for run in fitted):
            raise FitError(
                f"{study_id}: found no wear of the {spoken(body)} in any run from which k_D is identified; expected a "
                "positive measurement in at least one; to treat this body as unworn, remove these measurements from "
                "run.toml"
            )

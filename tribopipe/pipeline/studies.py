"""Studies on archived runs: found next to run folders, evaluated, archived, and their predictions put into the runs."""

import os
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import cached_property, partial
from itertools import count
from operator import itemgetter
from pathlib import Path
from typing import Any

from tribopipe.archive.deferred_write import OneRun
from tribopipe.archive.provenance import digest, environment
from tribopipe.archive.step_names import METHODS
from tribopipe.archive.store import Archive
from tribopipe.archive.studyfile import StoredStudy
from tribopipe.base.errors import ArchiveError, FitError, ManifestError, TribopipeError, did_you_mean
from tribopipe.base.executor import ALONE, Crew
from tribopipe.base.files import found_below
from tribopipe.base.units import from_si
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.documents.record import load_toml, quoted
from tribopipe.documents.study import STUDY_NAME, STUDY_SUFFIX, Study, bodies, severity
from tribopipe.evaluation.checks.samples import broken_off
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.friction import fit_friction
from tribopipe.evaluation.preprocessing.cleaning import clean_run
from tribopipe.evaluation.study.evaluate import evaluate, posed
from tribopipe.evaluation.study.further_tests import designs
from tribopipe.evaluation.study.member import Member
from tribopipe.evaluation.wear.measurement_fit import VolumeFit, volume_fit
from tribopipe.evaluation.wear.measurement_problem import measurement_problem
from tribopipe.evaluation.wear.problem import WearProblem, wear_problem
from tribopipe.evaluation.wear.scenario import KnownWear
from tribopipe.physics.laws import law_named, law_package
from tribopipe.pipeline.stages import Outcome, advance, attempted, in_groups, predict_with, stored, whole
from tribopipe.results.run import RawRun
from tribopipe.results.study import Design, Evaluation, LawResult, LeftOut, StudyResult
from tribopipe.version import VERSION


def find_studies(path: Path) -> list[Path]:
    """Return the study documents in a folder or below it: study.toml, and all whose names end in .study.toml."""
    if not path.is_dir():
        return []
    return sorted(found_below(path, STUDY_NAME, f"*{STUDY_SUFFIX}"))


def load_studies(paths: Sequence[Path]) -> list[Study]:
    """Read studies, each document once. Raises ``ManifestError`` where one is wrong, or two have the same id."""
    studies: dict[str, tuple[Path, Study]] = {}
    for path in {os.path.realpath(path): path for path in paths}.values():
        study = load_toml(path, Study)
        if study.id in studies:
            raise ManifestError(
                f"{path}: id: found {study.id!r}, which is also used in {studies[study.id][0]}; expected a unique ID "
                f"for each study; change one of the IDs"
            )
        studies[study.id] = (path, study)
    return [study for _, study in studies.values()]


def members(archive: Archive, run_ids: Sequence[str], recipe: Recipe) -> tuple[dict[str, Member], list[LeftOut]]:
    """Return archived runs as a study takes them, and those marked bad. Nothing is written.

    Raises ``ArchiveError`` for a run that is not in the archive.
    """
    sound, left_out = _sound(archive, run_ids)
    return {run_id: _member(archive, run_id, recipe) for run_id in sound}, left_out


def _sound(archive: Archive, run_ids: Sequence[str]) -> tuple[list[str], list[LeftOut]]:
    """Return the runs that are not marked bad, and those that are. Raises ``ArchiveError`` for one that is unknown."""
    marks = {run_id: archive.bad(run_id) for run_id in run_ids}
    left_out = [
        LeftOut(id=run_id, reason=f"marked bad: {mark.reason}") for run_id, mark in marks.items() if mark is not None
    ]
    return [run_id for run_id, mark in marks.items() if mark is None], left_out


def _member(archive: Archive, run_id: str, recipe: Recipe) -> Member:
    run = clean_run(archive.raw(run_id), recipe).run
    return Member(correct_drift(run, recipe), fit_friction(run, recipe.friction, recipe.uncertainty))


@dataclass(frozen=True)
class PlannedStudy:
    """A study of archived runs, ready to be evaluated."""

    archive: Archive
    study: Study
    recipe: Recipe
    left_out: Sequence[LeftOut]
    stands_on: Mapping[str, str]
    """Its runs, each with the SHA-256 of what was ingested."""

    @property
    def options(self) -> dict[str, Any]:
        """What it is given, as JSON types, by which methods it is evaluated, and which packages its laws are of."""
        packages = [package for law in self.study.laws if (package := law_package(law)) is not None]
        told = self.recipe.model_dump(mode="json", by_alias=True)
        return told | {"methods": METHODS} | ({"law_packages": packages} if packages else {})

    @property
    def inputs_sha256(self) -> str:
        """Fingerprint of all it is made from."""
        return digest(VERSION, self.study, self.options, *self.left_out, *self.stands_on.values())

    @cached_property
    def runs(self) -> dict[str, Member]:
        """Its runs as it takes them, which only an evaluation needs."""
        with _about(self.study):
            return {run_id: _member(self.archive, run_id, self.recipe) for run_id in self.stands_on}

    def evaluate(self) -> Evaluation:
        """Evaluate it; runs of different tribometers are refused."""
        return evaluate(self.study, self.runs, self.recipe, self.left_out)

    def take(self) -> StoredStudy:
        """Evaluate it, and return it as it is archived."""
        found = self.evaluate()
        return StoredStudy(
            study=self.study,
            result=found.result,
            inputs_sha256=self.inputs_sha256,
            options=self.options,
            program_version=VERSION,
            date=datetime.now(UTC).isoformat(timespec="seconds"),
            curves=found.curves,
            stands_on=self.stands_on,
            environment=environment(),
        )


def planned_study(archive: Archive, study: Study, recipe: Recipe) -> PlannedStudy:
    """Plan a study on archived runs. Raises ``ArchiveError`` for a run that is not in the archive."""
    with _about(study):
        sound, left_out = _sound(archive, (*study.fit, *study.predict))
        stands_on = {run_id: archive.raw_sha256(run_id) for run_id in sound}
    return PlannedStudy(archive, study, recipe, left_out, stands_on)


@contextmanager
def _about(study: Study) -> Iterator[None]:
    """Have errors name a study."""
    try:
        yield
    except TribopipeError as error:
        raise type(error)(f"study {study.id}: {error}") from None


def evaluate_archived(archive: Archive, study: Study, recipe: Recipe) -> Evaluation:
    """Evaluate a study on archived runs; nothing of it is kept."""
    return planned_study(archive, study, recipe).evaluate()


def run_study(archive: Archive, study: Study, recipe: Recipe, *, force: bool = False) -> Iterator[Outcome]:
    """Evaluate a study, archive it, and put its predictions into the runs; yield what became of each step.

    A study whose runs, options and version are unchanged is skipped.
    """
    outcome = attempted(study.id, "study", partial(_keep, archive, study, recipe, force=force))
    yield outcome
    if not isinstance(outcome.result, StudyResult):
        return
    left_out = {one.id for one in outcome.result.left_out}
    for run_id in (run_id for run_id in (*study.fit, *study.predict) if run_id not in left_out):
        yield from _complete(archive, run_id, recipe)
    predict = partial(predict_with, reference=study_reference(study), recipe=recipe, force=force)
    for run_id in (run_id for run_id in study.predict if run_id not in left_out):
        own = OneRun(archive, run_id)
        known = [(law.model, known_by(law)) for law in outcome.result.laws]
        yield from stored(
            own,
            [
                attempted(run_id, "prediction", partial(predict, own, run_id, law=name, known=found))
                for name, found in known
            ],
        )


def study_reference(study: Study) -> str:
    """Return what predictions with a study's k_D call it: the run that alone identified it, or the study."""
    return study.fit[0] if len(study.fit) == 1 else f"study {study.id}"


def known_by(law: LawResult) -> KnownWear:
    """Return the wear coefficients a study found under a law."""
    return KnownWear(
        {name: body.wear_coefficient for name, body in law.bodies.items()},
        engine=law.engine,
        distance=law.distance_per_rotation or "full-slip",
        correlation=law.correlation or 0.0,
    )


def _complete(archive: Archive, run_id: str, recipe: Recipe) -> Iterator[Outcome]:
    """Run the steps that a run of a study still needs for its figures and prediction; existing steps are kept."""
    done = archive.step_names(run_id)
    for name in ("drift_correction", "friction_fit"):
        if name not in done:
            yield advance(archive, run_id, name, recipe)


def process_studies(
    archive: Archive, studies: Sequence[Study], recipe: Recipe, *, force: bool = False, crew: Crew = ALONE
) -> Iterator[Outcome]:
    """Run studies; one that fails does not stop the others.

    A crew takes several at once, but those that have a run in common one after the other; their outcomes have the
    place of their study.
    """
    take = partial(_studied, archive=archive, recipe=recipe, force=force)
    if crew.is_alone:
        for place, study in enumerate(studies):
            yield from (replace(outcome, place=place) for outcome in take(study))
        return
    for place, study, answer in in_groups(partial(whole, take), _with_runs_in_common(studies), crew):
        outcomes = [Outcome.failed(study.id, "study", answer)] if isinstance(answer, TribopipeError) else answer
        yield from (replace(outcome, place=place) for outcome in outcomes)


def _studied(study: Study, archive: Archive, recipe: Recipe, *, force: bool) -> Iterator[Outcome]:
    try:
        yield from run_study(archive, study, recipe, force=force)
    except Exception as error:  # noqa: BLE001 - as in ``attempted``
        yield Outcome.failed(study.id, "study", error)


def _with_runs_in_common(studies: Sequence[Study]) -> list[list[tuple[int, Study]]]:
    """Put studies together, each with its place, that have a run in common, or have one in common with a third."""
    groups: list[tuple[set[str], list[tuple[int, Study]]]] = []
    for place, study in enumerate(studies):
        runs = {*study.fit, *study.predict}
        touched = [group for group in groups if group[0] & runs]
        groups = [group for group in groups if not group[0] & runs]
        members_of = [one for _, placed in touched for one in placed]
        groups.append(
            (runs.union(*(ids for ids, _ in touched)), sorted([*members_of, (place, study)], key=itemgetter(0)))
        )
    return [placed for _, placed in groups]


def _keep(archive: Archive, study: Study, recipe: Recipe, *, force: bool) -> Outcome:
    planned = planned_study(archive, study, recipe)
    if study.id in archive.study_ids() and not force:
        stored = archive.study_outline(study.id)
        if stored.inputs_sha256 == planned.inputs_sha256:
            return Outcome(study.id, "study", "unchanged", stored.result)
    taken = planned.take()
    archive.put_study(taken)
    return Outcome(study.id, "study", "done", taken.result)


def plan_archived(archive: Archive, name: str, law: LawName, wanted: float, recipe: Recipe) -> tuple[Design, ...]:
    """Plan from an archived run, or from the first run that identifies k_D in an archived study; for each disc of two.

    ``wanted`` is the half width of the 95 % interval of k_D over k_D. Raises ``ArchiveError`` for an unknown name, or
    where all that could be planned from is marked bad.
    """
    fit: tuple[str, ...] = (name,)
    scatter: Sequence[float | None] = ()
    shared = Study.model_fields["shared"].default
    if name not in archive.ids():
        if name not in archive.study_ids():
            known = [*archive.ids(), *archive.study_ids()]
            raise ArchiveError(
                f"{archive.folder}: found no run or study {name!r}; expected the ID of an archived run or study; "
                f"{did_you_mean(name, known)}"
            )
        stored = archive.study(name)
        fit, shared = stored.study.fit, stored.study.shared
        scatter = _scatter(stored.result, law)
    runs, left_out = members(archive, fit, recipe)
    if not runs:
        raise ArchiveError(
            f"{name}: found no run on which to base the plan: {left_out[0].id} is {left_out[0].reason}; expected a run "
            "that is not marked bad; specify another run, or remove the mark with `tribopipe mark-bad --undo`"
        )
    run = next(iter(runs.values()))
    return designs(posed(run, law, recipe), law, wanted, shared, scatter)


def _scatter(result: StudyResult, law: LawName) -> list[float | None]:
    """Return the scatter between runs over k_D, of each body; none where it is not known."""
    found = [body.between_runs for one in result.laws if one.model == law for body in one.bodies.values()]
    return [None if between is None else between.scatter for between in found]


def unfit_for_study(run: RawRun, recipe: Recipe) -> str | None:
    """Return why a study cannot use a run: it was aborted, or what k_D needs is missing; none of a sound run."""
    short = broken_off(run)
    if short is not None:
        return f"aborted: {short}"
    try:
        missing = _missing(clean_run(run, recipe).run, recipe)
    except TribopipeError as error:
        return str(error)
    return f"missing: {' and '.join(missing)}" if missing else None


def _missing(run: RawRun, recipe: Recipe) -> tuple[str, ...]:
    """Return what is missing for a k_D under Archard's law. Raises ``TribopipeError`` where its wear gives none."""
    if run.manifest.contact is not None and not run.manifest.contact.sensor_tells:
        discs = measurement_problem(run, "archard", None, recipe)
        return discs if isinstance(discs, tuple) else ()
    # Two-step correction needs what a study needs, a post-test measurement, and takes a moment.
    recipe = recipe.model_copy(update={"wear": recipe.wear.model_copy(update={"correction": "two-step"})})
    pin = wear_problem(correct_drift(run, recipe), "archard", None, recipe)
    if isinstance(pin, WearProblem):
        pin.coefficient()
        return ()
    return () if isinstance(volume_fit(run, "archard", None, recipe), VolumeFit) else pin


def draft_studies(manifests: Sequence[RunManifest], without_friction: Collection[str] = ()) -> list[Study]:
    """Propose a study for each set of runs of the same bodies: the lightest load identifies k_D, as in the paper.

    Of twin-disc runs it is the lightest load with the least slip. Laws that need friction are left out of a study with
    a run ``without_friction``.

    Raises ``FitError`` where no two runs belong together.
    """
    groups: dict[tuple[object, ...], list[RunManifest]] = {}
    for manifest in manifests:
        groups.setdefault(bodies(manifest), []).append(manifest)
    drafts: list[Study] = []
    for group in groups.values():
        if len(group) > 1:
            drafted = _draft(group, {draft.id for draft in drafts})
            silent = any(manifest.id in without_friction for manifest in group)
            laws = tuple(law for law in drafted.laws if not (silent and law_named(law).needs_friction))
            drafts.append(drafted.model_copy(update={"laws": laws}))
    if not drafts:
        raise FitError(
            f"study: found {len(manifests)} runs, but no two with the same bodies and environment; expected at "
            "least one run to fit and one to predict; check materials, radii and environment in run.toml"
        )
    return drafts


def _draft(group: Sequence[RunManifest], taken: Collection[str]) -> Study:
    by_load = sorted(group, key=severity)
    fit = [manifest.id for manifest in by_load if severity(manifest) == severity(by_load[0])]
    predict = [manifest.id for manifest in by_load if manifest.id not in fit]
    first = by_load[0]
    upper, lower = (body.material for body in first.bodies.values())
    words = [upper, first.contact_class.study_word, first.conditions.medium or ""]
    name = re.sub("[^a-z0-9]+", "-", " ".join(words).lower()).strip("-")
    # A word more keeps Windows' device names away, a number other studies' names.
    name = name[:80] if name and name not in ("con", "prn", "aux", "nul") else f"study-{name}".rstrip("-")
    numbered = (f"{name}-{number}" for number in count(2))
    name = name if name not in taken else next(other for other in numbered if other not in taken)
    title = f"{upper} on {lower}"
    return Study(
        id=name,
        title=f"{title} in {first.conditions.medium}" if first.conditions.medium else title,
        fit=tuple(fit),
        predict=tuple(predict),
        shared=first.contact_class.modulus_inputs,
    )


def study_toml(study: Study) -> str:
    """Write a study as people read it."""
    lines = [
        'schema = "tribopipe.study/1"',
        f'id = "{study.id}"',
        f"title = {quoted(study.title or study.id)}",
        "",
        "fit = [                              # k_D is identified from these runs",
        *(f"    {quoted(run_id)}," for run_id in study.fit),
        "]",
        "predict = [                          # wear of these runs is predicted with this k_D and compared",
        *(f"    {quoted(run_id)}," for run_id in study.predict),
        "]",
        f"laws = [{', '.join(quoted(law) for law in study.laws)}]",
        "# Inputs with the same error in all runs; add normal_load if all loads were measured with the same load cell.",
        f"shared = [{', '.join(quoted(name) for name in study.shared)}]",
    ]
    depth = study.end_of_life
    if depth is None:
        lines.append(
            '# end_of_life = "50 um"             # wear depth for which the sliding distance or number of rotations is '
            "calculated"
        )
    else:
        value = f'"{from_si(depth.value, "m", "um"):.15g} um"'
        spread = depth.standard_uncertainty
        if spread is not None:
            value = f'{{ value = {value}, standard_uncertainty = "{from_si(spread, "m", "um"):.15g} um" }}'
        lines.append(f"end_of_life = {value}")
    return "\n".join(lines) + "\n"

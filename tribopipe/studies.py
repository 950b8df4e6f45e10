"""Studies on archived runs: found beside run folders, evaluated, archived, and their predictions put into the runs."""

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path

from tribopipe.archive.digest import digest
from tribopipe.archive.store import Archive
from tribopipe.archive.studyfile import StoredStudy
from tribopipe.errors import ArchiveError, FitError, TribopipeError
from tribopipe.pipeline import (
    Outcome,
    archived_correction,
    archived_friction,
    correct_archived_drift,
    fit_archived_friction,
    predict_with,
)
from tribopipe.records.base import load_toml
from tribopipe.records.design import Design
from tribopipe.records.manifest import RunManifest
from tribopipe.records.recipe import LawName, Recipe
from tribopipe.records.study import STUDY_NAME, STUDY_SUFFIX, Study
from tribopipe.records.verdict import LeftOut, StudyResult
from tribopipe.study.bodies import bodies
from tribopipe.study.design import design
from tribopipe.study.evaluate import Evaluation, evaluate
from tribopipe.study.member import Member
from tribopipe.version import VERSION


def find_studies(path: Path) -> list[Path]:
    """Return the study documents in a folder or below it: study.toml, and all whose names end in .study.toml."""
    if not path.is_dir():
        return []
    return sorted({*path.rglob(STUDY_NAME), *path.rglob(f"*{STUDY_SUFFIX}")})


def load_studies(paths: Sequence[Path]) -> list[Study]:
    """Read studies. Raises ``ManifestError`` where one is wrong, or two have the same id."""
    studies: dict[str, tuple[Path, Study]] = {}
    for path in paths:
        study = load_toml(path, Study)
        if study.id in studies:
            raise ArchiveError(
                f"{path}: id: found {study.id!r}, which {studies[study.id][0]} has too; expected each study under "
                "an id of its own; change one of them"
            )
        studies[study.id] = (path, study)
    return [study for _, study in studies.values()]


def members(archive: Archive, study: Study, recipe: Recipe) -> tuple[dict[str, Member], list[LeftOut]]:
    """Return the runs of a study as the archive holds them, corrected on the way, and those marked bad.

    Raises ``ArchiveError`` for a run that is not in the archive.
    """
    found: dict[str, Member] = {}
    left_out: list[LeftOut] = []
    for run_id in (*study.fit, *study.predict):
        try:
            mark = archive.bad(run_id)
            if mark is not None:
                left_out.append(LeftOut(id=run_id, reason=f"marked bad: {mark.reason}"))
                continue
            correct_archived_drift(archive, run_id, recipe)
            fit_archived_friction(archive, run_id, recipe)
            found[run_id] = Member(archived_correction(archive, run_id), archived_friction(archive, run_id))
        except TribopipeError as error:
            raise type(error)(f"study {study.id}: {error}") from None
    return found, left_out


def evaluate_archived(archive: Archive, study: Study, recipe: Recipe) -> Evaluation:
    """Evaluate a study on archived runs; nothing of it is kept."""
    runs, left_out = members(archive, study, recipe)
    return evaluate(study, runs, recipe, left_out)


def run_study(archive: Archive, study: Study, recipe: Recipe, *, force: bool = False) -> Iterator[Outcome]:
    """Evaluate a study, archive it, and put its predictions into the runs; yield what became of each step.

    A study whose runs, options and version are unchanged is skipped.
    """
    try:
        outcome = _keep(archive, study, recipe, force=force)
    except TribopipeError as error:
        yield Outcome(study.id, "study", "failed", error=error)
        return
    yield outcome
    if not isinstance(outcome.result, StudyResult):
        return
    left_out = {one.id for one in outcome.result.left_out}
    for law in outcome.result.laws:
        for run_id in (run_id for run_id in study.predict if run_id not in left_out):
            try:
                reference = study.fit[0] if len(study.fit) == 1 else f"study {study.id}"
                yield predict_with(archive, run_id, reference, law.model, law.wear_coefficient, recipe, force=force)
            except TribopipeError as error:
                yield Outcome(run_id, "prediction", "failed", error=error)


def process_studies(
    archive: Archive, studies: Sequence[Study], recipe: Recipe, *, force: bool = False
) -> Iterator[Outcome]:
    """Run studies one after the other; one that fails does not stop the others."""
    for study in studies:
        yield from run_study(archive, study, recipe, force=force)


def _keep(archive: Archive, study: Study, recipe: Recipe, *, force: bool) -> Outcome:
    runs, left_out = members(archive, study, recipe)
    options = recipe.model_dump(mode="json", by_alias=True)
    inputs = digest(VERSION, study, options, *left_out, *_fingerprints(archive, runs))
    if study.id in archive.study_ids() and not force:
        stored = archive.study(study.id)
        if stored.inputs_sha256 == inputs:
            return Outcome(study.id, "study", "unchanged", stored.result)
    found = evaluate(study, runs, recipe, left_out)
    date = datetime.now(UTC).isoformat(timespec="seconds")
    archive.put_study(StoredStudy(study, found.result, found.curves, inputs, options, VERSION, date))
    return Outcome(study.id, "study", "done", found.result)


def _fingerprints(archive: Archive, runs: Mapping[str, Member]) -> list[str]:
    prints = []
    for run_id in runs:
        steps = [archive.fingerprints(run_id, name) for name in ("drift_correction", "friction_fit")]
        prints += [archive.raw_sha256(run_id), *("" if step is None else step.result for step in steps)]
    return prints


def plan_archived(archive: Archive, name: str, law: LawName, wanted: float, recipe: Recipe) -> Design:
    """Plan from an archived run, or from the first run that identifies k_D in an archived study.

    ``wanted`` is the half width of the 95 % interval of k_D over k_D. Raises ``ArchiveError`` for an unknown name.
    """
    study, scatter = Study(id=name, fit=(name,)), None
    if name not in archive.ids() and name in archive.study_ids():
        stored = archive.study(name)
        study, between = stored.study, [result.between_runs for result in stored.result.laws if result.model == law]
        scatter = between[0].scatter if between and between[0] is not None else None
    runs, _ = members(archive, study.model_copy(update={"predict": ()}), recipe)
    first = next(run for run_id, run in runs.items() if run_id in study.fit)
    return design(first.pose(law, recipe), law, wanted, study.shared, scatter)


def draft_studies(manifests: Sequence[RunManifest]) -> list[Study]:
    """Propose a study for each set of runs of the same bodies: the lightest load identifies k_D, as in the paper.

    Raises ``FitError`` where no two runs belong together.
    """
    groups: dict[tuple[object, ...], list[RunManifest]] = {}
    for manifest in manifests:
        groups.setdefault(bodies(manifest), []).append(manifest)
    drafts = [_draft(group) for group in groups.values() if len(group) > 1]
    if not drafts:
        raise FitError(
            f"study: found {len(manifests)} runs, of which no two are of the same bodies in the same medium; expected "
            "at least one to fit and one to predict; check material, radius and medium in run.toml"
        )
    return drafts


def _draft(group: Sequence[RunManifest]) -> Study:
    by_load = sorted(group, key=lambda manifest: manifest.conditions.normal_load.value)
    lightest = by_load[0].conditions.normal_load.value
    fit = [manifest.id for manifest in by_load if manifest.conditions.normal_load.value == lightest]
    predict = [manifest.id for manifest in by_load if manifest.id not in fit]
    first = by_load[0]
    words = [first.contact.pin.material, first.conditions.medium or ""]
    name = re.sub("[^a-z0-9]+", "-", " ".join(words).lower()).strip("-")
    title = f"{first.contact.pin.material} on {first.contact.disc.material}"
    return Study(
        id=name or "study",
        title=f"{title} in {first.conditions.medium}" if first.conditions.medium else title,
        fit=tuple(fit),
        predict=tuple(predict),
    )


def study_toml(study: Study) -> str:
    """Write a study as people read it."""
    lines = [
        'schema = "tribopipe.study/1"',
        f'id = "{study.id}"',
        f"title = {_quoted(study.title or study.id)}",
        "",
        "fit = [                              # these runs identify k_D",
        *(f"    {_quoted(run_id)}," for run_id in study.fit),
        "]",
        "predict = [                          # these are predicted with it, and judged",
        *(f"    {_quoted(run_id)}," for run_id in study.predict),
        "]",
        f"laws = [{', '.join(_quoted(law) for law in study.laws)}]",
        "# Inputs that are off by the same error in all runs; add normal_load where one load cell weighed them all.",
        f"shared = [{', '.join(_quoted(name) for name in study.shared)}]",
    ]
    if study.end_of_life is not None:
        lines.append(f"end_of_life = {_quoted(study.end_of_life.shown('um').replace('µ', 'u'))}")
    else:
        lines.append('# end_of_life = "50 um"             # wear depth whose sliding distance is wanted')
    return "\n".join(lines) + "\n"


def _quoted(text: str) -> str:
    """Write a TOML string, whose escapes are JSON's."""
    return json.dumps(text, ensure_ascii=False)

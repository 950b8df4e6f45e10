"""The complete processing line as plain calls: each step reads its inputs from the archive and appends its result.

A step is skipped where its version, its options and all that it stands on are unchanged; ``force`` redoes it.
"""

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, Literal, TypeVar

from tribopipe.archive.deferred_write import OneRun
from tribopipe.archive.step_names import STEPS, WEAR_FITS, StepName, StepStage, stage_of
from tribopipe.archive.store import Archive
from tribopipe.base.errors import ArchiveError, ContactError, ManifestError, TribopipeError
from tribopipe.base.executor import ALONE, Crew, at_work, in_turn
from tribopipe.base.failures import in_a_sentence
from tribopipe.base.files import found_below, natural_order
from tribopipe.documents.manifest import MANIFEST_NAME, manifest_path
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.documents.record import Record
from tribopipe.documents.toml import parse_toml, read_bytes
from tribopipe.evaluation.checks.registry import check_run, refuse_errors
from tribopipe.evaluation.wear.local import LocalOptions
from tribopipe.evaluation.wear.scenario import KnownWear, known_wear
from tribopipe.pipeline.archived_results import References, archived_fit
from tribopipe.pipeline.step_definitions import PLANS, PlannedStep, local_wear, planned, prediction
from tribopipe.readers.harmonize import read_run
from tribopipe.results.finding import Finding
from tribopipe.results.main_values import Headline, headline

Stage = Literal["ingest"] | StepStage | Literal["figures"]
Status = Literal["done", "unchanged", "failed"]
Item = TypeVar("Item")
Answer = TypeVar("Answer")


@dataclass(frozen=True)
class Outcome:
    """Outcome of one step of one run."""

    run_id: str
    """Id of the run, or of the study; its path where it could not be read."""
    stage: Stage
    status: Status
    result: Record | None = None
    findings: tuple[Finding, ...] = ()
    error: TribopipeError | None = None
    place: int = 0
    """Place of its run in a batch, by which outcomes are put in order whichever came first."""
    step: StepName | None = None
    """Step of the run that it is about, which names the law; none of ingest, studies and figures."""
    previous: Headline | None = None
    """Main values of the result that this one has replaced; none where there was none, or where they are the same."""
    dropped: tuple[StepName, ...] | None = None
    """Steps that stood on the run.toml before it was amended; none where it was not."""
    worded: Callable[[str], str] = str
    """Puts what the result states about the bodies in the names of the contact."""

    @classmethod
    def failed(cls, run_id: str, stage: Stage, error: Exception) -> "Outcome":
        """Return the outcome of a step that failed, for whatever reason."""
        return cls(run_id, stage, "failed", error=in_a_sentence(error, run_id))

    def as_json(self) -> dict[str, Any]:
        """Return the outcome as JSON types, without its result."""
        return {
            "id": self.run_id,
            "stage": self.stage,
            "step": self.step,
            "status": self.status,
            "previous": None if self.previous is None else {name: _json(old) for name, old in self.previous.items()},
            "findings": [finding.model_dump(mode="json") for finding in self.findings],
            "error": None if self.error is None else str(self.error),
        }


def _json(quantity: Quantity | None) -> dict[str, Any] | None:
    return None if quantity is None else quantity.model_dump(mode="json")


def attempted(run_id: str, stage: Stage, step: Callable[[], Outcome]) -> Outcome:
    """Take a step of a batch; where it fails, for whatever reason, that is its outcome, and the batch can go on."""
    try:
        return step()
    except Exception as error:  # noqa: BLE001 - a fault in one run is no reason to leave the others
        return Outcome.failed(run_id, stage, error)


def find_runs(path: Path) -> list[Path]:
    """Return the run folders at or below a path. Raises ``ManifestError`` where there is none."""
    if path.is_file() and path.suffix.lower() != ".toml":
        raise ManifestError(
            f"{path}: found a file; expected a run folder; to create a run folder from an instrument file, run: "
            f"tribopipe new {_as_typed(path)}"
        )
    if manifest_path(path).is_file() or not path.is_dir():
        return [path]
    manifests = found_below(path, MANIFEST_NAME)
    found = sorted((manifest.parent for manifest in manifests), key=lambda run: natural_order(str(run)))
    if not found:
        raise ManifestError(
            f"{path}: found no {MANIFEST_NAME} in it or its subfolders; expected a run folder; to create run folders "
            f"from instrument files, run: tribopipe new {_as_typed(path)}"
        )
    return found


def _as_typed(path: Path) -> str:
    """Write a path as a shell takes it."""
    return f'"{path}"' if re.search(r"[^\w./\\:+,-]", str(path)) else str(path)


def ingest(path: Path, archive: Archive, *, force: bool = False, amend: bool = False) -> Outcome:
    """Read, check and archive one run folder; ``amend`` has another run.toml take the place of the archived one.

    Raises ``TribopipeError`` where the run cannot be read, has errors, or its id is taken by other content.
    """
    run = read_run(path)
    findings = check_run(run)
    refuse_errors(run, findings)
    before = archive.step_names(run.id) if amend and archive.path(run.id).exists() else []
    status = archive.add(run, findings, force=force, amend=amend)
    return Outcome(
        run.id,
        "ingest",
        "unchanged" if status == "unchanged" else "done",
        findings=tuple(findings),
        dropped=tuple(before) if status == "amended" else None,
    )


def ingest_each(
    paths: Sequence[Path], archive: Archive, *, force: bool = False, amend: bool = False, crew: Crew = ALONE
) -> Iterator[Outcome]:
    """Ingest run folders; yield what became of each, with its place. One that fails stops no other."""
    for place, path, answer in _by_run(partial(_ingest_one, archive=archive, force=force, amend=amend), paths, crew):
        outcome = Outcome.failed(str(path), "ingest", answer) if isinstance(answer, TribopipeError) else answer
        yield replace(outcome, place=place)


def _ingest_one(path: Path, archive: Archive, *, force: bool, amend: bool) -> Outcome:
    return attempted(str(path), "ingest", partial(ingest, path, archive, force=force, amend=amend))


def advance(archive: Archive, run_id: str, name: StepName, recipe: Recipe, *, force: bool = False) -> Outcome:
    """Take a step that its recipe defines, and archive it; steps it stands on are taken first where they are not."""
    for earlier in STEPS[name].stands_on:
        _advance(archive, planned(archive, run_id, earlier, recipe))
    return _advance(archive, planned(archive, run_id, name, recipe), force=force)


def predict_archived(
    archive: Archive, run_id: str, reference: str, law: LawName, recipe: Recipe, *, force: bool = False
) -> Outcome:
    """Predict a run's wear from the k_D of another run, over the run's own distance, and archive the prediction."""
    fit = archived_fit(archive, reference, law)
    known = known_wear(fit)
    if known is None:
        raise TribopipeError(
            f"{reference}: found no wear coefficient to predict from; missing: {' and '.join(fit.missing)}"
        )
    return predict_with(archive, run_id, reference, law, known, recipe, force=force)


def predict_with(
    archive: Archive,
    run_id: str,
    reference: str,
    law: LawName,
    known: KnownWear,
    recipe: Recipe,
    *,
    force: bool = False,
) -> Outcome:
    """Predict a run's wear from the k_D that ``reference`` found, over the run's own distance, and archive it."""
    _clean_first(archive, run_id, recipe)
    try:
        return _advance(archive, prediction(archive, run_id, recipe, law, reference, known), force=force)
    except ContactError as error:
        # The run that k_D is from may be at fault, rather than the one that is predicted.
        raise ContactError(f"{error} (in the prediction with the k_D from {reference}); check both runs") from error


def wear_archived_locally(
    archive: Archive,
    run_id: str,
    law: LawName,
    recipe: Recipe,
    how: LocalOptions,
    *,
    coefficients: Mapping[str, Quantity] | None = None,
    at: Sequence[float] = (),
    force: bool = False,
) -> Outcome:
    """Wear a run locally to places ``at``, m or rotations, or over its own course, and archive it with its fields.

    k_D of the bodies is what the fit under the law found, unless ``coefficients`` are given by body, as Archard's law
    has them. Raises ``FitError`` where neither is there.
    """
    _clean_first(archive, run_id, recipe)
    step = local_wear(archive, run_id, recipe, law, how, coefficients=coefficients, at=at)
    return _advance(archive, step, force=force)


def _clean_first(archive: Archive, run_id: str, recipe: Recipe) -> None:
    """Preprocess a run that was not yet; one that was stays as it is."""
    if "clean_up" not in archive.step_names(run_id):
        advance(archive, run_id, "clean_up", recipe)


def _advance(archive: Archive, step: PlannedStep, *, force: bool = False) -> Outcome:
    """Take a step and archive it, unless it is there already, made from the same."""
    stage = stage_of(step.name)
    there = archive.fingerprints(step.run_id, step.name)
    if there is not None and there.inputs == step.inputs_sha256 and not force:
        found = archive.result(step.run_id, step.name, Record)
        return Outcome(step.run_id, stage, "unchanged", found, step=step.name, findings=_findings_of(found))
    taken = step.take()
    archive.put_step(step.run_id, taken)
    findings, worded = _findings_of(taken.result), archive.manifest(step.run_id).worded
    return Outcome(step.run_id, stage, "done", taken.result, step=step.name, findings=findings, worded=worded)


def _findings_of(result: Record | None) -> tuple[Finding, ...]:
    """Return what speaks against a result; nothing of results that are not judged."""
    return tuple(getattr(result, "findings", ()))


def compared(archive: Archive, run_id: str, outcomes: Iterator[Outcome]) -> Iterator[Outcome]:
    """Yield outcomes of steps of a run, each with the main values that the archive had before the first of them.

    All of these are read at the start, since a step whose result has changed drops those that stand on it.
    """
    earlier = _headlines(archive, run_id)
    for outcome in outcomes:
        before = earlier.get(outcome.step) if outcome.step else None
        replaced = outcome.status == "done" and outcome.result is not None and before is not None
        yield replace(outcome, previous=before) if replaced and before != headline(outcome.result) else outcome


def _headlines(archive: Archive, run_id: str) -> dict[StepName, Headline]:
    """Return the main values of each archived step; nothing of one whose result cannot be read any more."""
    found = {}
    for name in archive.step_names(run_id):
        with suppress(ArchiveError):
            found[name] = headline(archive.result(run_id, name, Record))
    return {name: values for name, values in found.items() if values}


def process(
    paths: Sequence[Path],
    archive: Archive,
    recipe: Recipe | None = None,
    *,
    force: bool = False,
    amend: bool = False,
    studied: Collection[str] = (),
    crew: Crew = ALONE,
) -> Iterator[Outcome]:
    """Take run folders through all steps; yield the outcome of each step when it is done.

    Runs of the same bodies in the same environment are predicted from the one under the lightest load, as in the
    paper, except those that are ``studied``: a study states the runs that they are predicted from. A run that fails
    does not stop the others. A crew takes several runs at once; their outcomes come in the order of the runs all the
    same, and have the place of their run.
    """
    recipe = recipe or Recipe()
    with at_work(crew) as at_hand:
        places: dict[str, int] = {}
        for outcome in process_each(paths, archive, recipe, force=force, amend=amend, crew=at_hand):
            if outcome.stage == "ingest" and outcome.error is None:
                places[outcome.run_id] = outcome.place
            elif outcome.error is not None:
                places.pop(outcome.run_id, None)
            yield outcome
        left = sorted((run_id for run_id in places if run_id not in studied), key=places.__getitem__)
        for outcome in predict_from_lightest(archive, left, recipe.wear.models, recipe, force=force, crew=at_hand):
            yield replace(outcome, place=places.get(outcome.run_id, len(paths)))
    _tidy(archive, crew)


def process_each(
    paths: Sequence[Path],
    archive: Archive,
    recipe: Recipe,
    *,
    force: bool = False,
    amend: bool = False,
    crew: Crew = ALONE,
) -> Iterator[Outcome]:
    """Take run folders through all that needs no other run; yield what became of each step, as ``process`` does."""
    take = partial(_process_one, archive=archive, recipe=recipe, force=force, amend=amend)
    for place, outcomes in _each_run(paths, archive, take, crew):
        for outcome in outcomes:
            yield replace(outcome, place=place)
    _tidy(archive, crew)


def _tidy(archive: Archive, crew: Crew) -> None:
    """Take away what workers left that were killed; what they did was done again by others."""
    if not crew.is_alone:
        archive.tidy()


def _each_run(
    paths: Sequence[Path], archive: Archive, take: Callable[[Path], Iterator[Outcome]], crew: Crew
) -> Iterator[tuple[int, Iterable[Outcome]]]:
    """Give the place of each run with its outcomes: step by step, or those of a run together where a crew takes it."""
    if crew.is_alone:
        yield from enumerate(map(take, paths))
        return
    with suppress(ArchiveError):  # which each run will tell
        archive.begin()
    for place, path, answer in _by_run(partial(whole, take), paths, crew):
        if isinstance(answer, TribopipeError):
            yield place, [Outcome.failed(str(path), "ingest", answer)]
        else:
            yield place, answer


def _by_run(
    take: Callable[[Path], Answer], paths: Sequence[Path], crew: Crew
) -> Iterator[tuple[int, Path, Answer | TribopipeError]]:
    """Take each run folder by a crew; give its place, and what came of it.

    Folders of one id are taken one after the other, so that it is the first of them that is archived.
    """
    same: dict[str, list[tuple[int, Path]]] = {}
    for place, path in enumerate(paths):
        same.setdefault(_id_said(path), []).append((place, path))
    return in_groups(take, same.values(), crew)


def in_groups(
    take: Callable[[Item], Answer], groups: Iterable[Sequence[tuple[int, Item]]], crew: Crew
) -> Iterator[tuple[int, Item, Answer | TribopipeError]]:
    """Take items by a crew, those of a group one after the other; give the place of each, and what came of it."""
    for placed, answers in in_turn(partial(_take_group, take), groups, crew):
        for number, (place, item) in enumerate(placed):
            yield place, item, answers if isinstance(answers, TribopipeError) else answers[number]


def _take_group(take: Callable[[Item], Answer], group: Sequence[tuple[int, Item]]) -> list[Answer]:
    return [take(item) for _, item in group]


def _id_said(path: Path) -> str:
    """Return the id in a run.toml; a file that cannot be read counts as a separate run."""
    try:
        where = manifest_path(path)
        return str(parse_toml(where, read_bytes(where))["id"])
    except (TribopipeError, OSError, LookupError):
        return str(path)


def whole(take: Callable[[Item], Iterator[Outcome]], item: Item) -> list[Outcome]:
    """Return all outcomes of an item, which a worker gives back together."""
    return list(take(item))


def _process_one(path: Path, archive: Archive, recipe: Recipe, *, force: bool, amend: bool) -> Iterator[Outcome]:
    ingested = attempted(str(path), "ingest", partial(ingest, path, archive, force=force, amend=amend))
    yield ingested
    if ingested.error is not None:
        return
    run_id, archive = ingested.run_id, OneRun(archive, ingested.run_id)
    names = (*PLANS, *(WEAR_FITS[law] for law in recipe.wear.models))
    take = partial(advance, archive, run_id, recipe=recipe, force=force)
    taken = compared(archive, run_id, (attempted(run_id, stage_of(name), partial(take, name)) for name in names))
    yield from stored(archive, list(taken))


def stored(archive: OneRun, outcomes: list[Outcome]) -> list[Outcome]:
    """Put steps of a run into its file; where that fails, none of them is done, and the first has failed by it."""
    try:
        archive.store()
    except Exception as error:  # noqa: BLE001 - as in ``attempted``
        kept = [outcome for outcome in outcomes if outcome.status != "done"]
        stage = next((outcome.stage for outcome in outcomes if outcome.status == "done"), outcomes[-1].stage)
        return [Outcome.failed(archive.run_id, stage, error), *kept]
    return outcomes


def predict_from_lightest(
    archive: Archive,
    run_ids: Sequence[str],
    laws: Sequence[LawName],
    recipe: Recipe,
    *,
    force: bool = False,
    crew: Crew = ALONE,
) -> Iterator[Outcome]:
    """Predict each run from the comparable run under the lightest load; nothing for a run that is itself that one.

    Files that could not be predicted from, since they cannot be read, are failures too.
    """
    references = References(archive, laws)
    for name, why in references.unreadable:
        yield Outcome.failed(Path(name).stem, "prediction", ArchiveError(why))
    predict = partial(_predict_under_each, archive=archive, recipe=recipe, force=force)
    for (run_id, _), outcomes in in_turn(predict, _with_references(run_ids, laws, references), crew):
        if isinstance(outcomes, TribopipeError):
            yield Outcome.failed(run_id, "prediction", outcomes)
        else:
            yield from outcomes


_Known = Mapping[LawName, str] | TribopipeError
"""The run to predict from under each law, or why there is none."""


def _with_references(
    run_ids: Iterable[str], laws: Sequence[LawName], references: References
) -> Iterator[tuple[str, _Known]]:
    for run_id in run_ids:
        try:
            found = {law: references.lightest(run_id, law) for law in laws}
        except TribopipeError as error:
            yield run_id, error
        else:
            if known := {law: reference for law, reference in found.items() if reference is not None}:
                yield run_id, known


def _predict_under_each(known: tuple[str, _Known], archive: Archive, recipe: Recipe, *, force: bool) -> list[Outcome]:
    run_id, references = known
    if isinstance(references, TribopipeError):
        raise references
    own = OneRun(archive, run_id)
    outcomes = [
        attempted(run_id, "prediction", partial(predict_archived, own, run_id, reference, law, recipe, force=force))
        for law, reference in references.items()
    ]
    return stored(own, outcomes)

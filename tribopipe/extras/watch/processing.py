"""Creation of run folders from exports, and their processing as with `tribopipe process`.

A run folder is made once for the same bytes, under whatever names they come.
"""

import hashlib
import shutil
from collections.abc import Iterable, Iterator
from contextlib import suppress
from datetime import UTC, datetime
from functools import partial
from itertools import chain, count
from pathlib import Path

from tribopipe.archive.store import Archive
from tribopipe.base.errors import (
    ArchiveError,
    CheckError,
    ContactError,
    FitError,
    ManifestError,
    ReaderError,
    TribopipeError,
)
from tribopipe.base.executor import ALONE, as_done
from tribopipe.base.failures import in_a_sentence
from tribopipe.base.files import sha256_of
from tribopipe.documents.annotation import Mark
from tribopipe.documents.recipe import Recipe
from tribopipe.extras.watch.drops import Drop, moves, stamp_of
from tribopipe.extras.watch.journal import Entry, Event, Journal
from tribopipe.extras.watch.lab import Lab
from tribopipe.pipeline.stages import Outcome, attempted, process
from tribopipe.readers.draft.folder import NewRun, Wanted, fit_for_id, make_run
from tribopipe.views.archived_figures import figure_steps

_ROOM = 90
"""Characters of an id, of the hundred it may have, before a number."""
_CHUNK = 1 << 20


def content_of(drop: Drop) -> str:
    """Return the SHA-256 of a file, or that of the checksums of several. Raises ``OSError``."""
    sums = sorted(map(sha256_of, drop.files))
    return sums[0] if len(sums) == 1 else hashlib.sha256("".join(sums).encode()).hexdigest()


def id_for(drop: Drop, runs: Path, archive: Archive, begun: str | None = None) -> str:
    """Return the id of the run that was begun of a drop, or else one made of its name that nothing else has."""
    name = fit_for_id(Path(drop.name).name)
    numbered: Iterator[str] = (f"{name[:_ROOM]}-{number}" for number in count(2))
    candidates = chain([begun] if begun else [], [name], numbered)
    return next(one for one in candidates if _is_free(one, drop, runs, archive))


def clear_begun(run_id: str, runs: Path) -> None:
    """Remove what a crash left of a run folder that was being made."""
    for part in runs.glob(f".{run_id}.????????.part"):
        shutil.rmtree(part, ignore_errors=True)


def goes_on(drop: Drop, run: Path) -> bool:
    """Return whether a drop holds all that a run folder was made of, and more after it."""
    now = {path.name: path for path in drop.files}
    with suppress(OSError):
        copies = [path for path in run.iterdir() if path.suffix != ".toml"]
        return bool(copies) and all(copy.name in now and _begins(copy, now[copy.name]) for copy in copies)
    return False


def _is_free(run_id: str, drop: Drop, runs: Path, archive: Archive) -> bool:
    """Return whether an id is nobody's, or that of a run which was made of the same bytes."""
    folder = runs / run_id
    if folder.exists():
        return _sums(drop.files) <= _sums(folder.iterdir())
    if not archive.path(run_id).exists():
        return True
    with suppress(ArchiveError):
        return _sums(drop.files) <= {source.sha256 for source in archive.outline(run_id).sources}
    return False


def _sums(paths: Iterable[Path]) -> set[str]:
    return {sha256_of(path) for path in paths if path.is_file()}


def _begins(copy: Path, export: Path) -> bool:
    """Return whether an export begins with all that a copy of it holds."""
    with copy.open("rb") as old, export.open("rb") as new:
        while part := old.read(_CHUNK):
            if new.read(len(part)) != part:
                return False
    return True


def take(drop: Drop, lab: Lab, journal: Journal) -> Iterator[Event]:
    """Make a run folder of what has settled; what fails is left alone until it changes."""
    if drop.is_run:
        journal.note(Entry(name=drop.name, stamp=drop.stamp, state="made"))
        return
    try:
        yield from _taken(drop, lab, journal)
    except Exception as error:  # noqa: BLE001 - a fault in one export is no reason to leave the others
        if not moves(drop):
            yield _left(drop, journal, in_a_sentence(error, drop.name))


def _taken(drop: Drop, lab: Lab, journal: Journal) -> Iterator[Event]:
    sha256 = content_of(drop)
    twin = journal.run_of(sha256)
    if twin is not None and twin.state != "begun":
        yield from _same(drop, journal, twin)
        return
    run_id = id_for(drop, lab.runs, Archive(lab.archive), twin.run if twin else None)
    entry = Entry(
        name=drop.name,
        stamp=drop.stamp,
        sha256=sha256,
        state="begun",
        run=run_id,
        instead_of=_half(drop, run_id, lab, journal),
    )
    journal.note(entry)
    made = _make(drop, run_id, lab)
    if not moves(drop):
        yield _made(entry, made, lab, journal)
    elif made is not None:
        shutil.rmtree(made.folder)  # it was read while it went on


def _same(drop: Drop, journal: Journal, twin: Entry) -> Iterator[Event]:
    """Pass over bytes that are a run already; those of a file that was merely written again without a message."""
    again = {"name": drop.name, "stamp": drop.stamp}
    if twin.name == drop.name:
        journal.note(twin.model_copy(update=again))
        return
    journal.note(twin.model_copy(update=again | {"state": "same"}))
    yield Event("same", f"{drop.name}: same content as {twin.name}, archived as {twin.run}", drop.name, twin.run)


def _half(drop: Drop, run_id: str, lab: Lab, journal: Journal) -> str | None:
    """Return the run that was made of an export before it went on; None if it is another export."""
    before = journal.newest(drop.name)
    if before is None or before.run in (None, run_id) or not goes_on(drop, lab.run(before)):
        return None
    return before.run


def _make(drop: Drop, run_id: str, lab: Lab) -> NewRun | None:
    """Make a run folder; None if a watch has made it before, which did not come to note that."""
    clear_begun(run_id, lab.runs)
    if (lab.runs / run_id).exists():
        return None
    return make_run(Wanted(drop.files, lab.runs, run_id, lab.template))


def _made(entry: Entry, made: NewRun | None, lab: Lab, journal: Journal) -> Event:
    """Report for a run folder, which is processed unless something has to be filled in."""
    said = f"{entry.name}: run {entry.run}"
    if entry.instead_of:
        said += f", since data were added to the file after run {entry.instead_of} was created from it"
    missing = made and (", ".join(made.missing) or made.problem)
    if not missing:
        journal.note(entry.model_copy(update={"state": "made"}))
        return Event("made", said, entry.name, entry.run)
    journal.note(lab.failed(entry))
    said += f"; still to be filled in: {missing}; the run is processed automatically after these values have been "
    said += f"entered in {lab.manifest(entry)}"
    return Event("waiting", said, entry.name, entry.run)


def _left(drop: Drop, journal: Journal, error: TribopipeError) -> Event:
    """Leave a drop alone; where it is not its own fault, until the next start."""
    begun = journal.newest(drop.name)
    sha256 = begun.sha256 if begun is not None and begun.stamp == drop.stamp else ""
    entry = Entry(name=drop.name, stamp=drop.stamp, sha256=sha256, state="left")
    (journal.note if isinstance(error, ReaderError) else journal.hold)(entry)
    said = str(error).removeprefix(f"{drop.files[0].name}: ").removeprefix(f"{drop.name}: ")
    return Event("left", f"{drop.name}: no run was created from it; {said}", drop.name)


_OF_THE_RUN = (CheckError, ContactError, FitError, ManifestError, ReaderError)
"""Errors that remain until run.toml changes."""


def processed(lab: Lab, journal: Journal) -> Iterator[Event]:
    """Process the runs that are made, by an earlier watch too, and yield what became of each."""
    made = {lab.run(entry): lab.seen(entry) for entry in journal.that_are("made")}
    crew = lab.crew if len(made) > 1 else ALONE  # what is one alone is done before others are there
    take = partial(_through_the_line, archive=lab.archive, recipe=lab.recipe, figures=lab.figures)
    for folder, answer in as_done(take, list(made), crew):
        yield _ended(made[folder], _outcomes(folder, answer), lab, journal)


def changed(lab: Lab, journal: Journal) -> Iterator[Drop]:
    """Return the runs that have another run.toml than when they were taken, each as what is to settle."""
    for entry in (*journal.that_are("failed"), *journal.that_are("done")):
        manifest = lab.manifest(entry)
        if entry.run is None or not manifest.is_file() or (entry.state == "done" and not entry.run_stamp):
            continue
        if (stamp := stamp_of([manifest])) != entry.run_stamp:
            yield Drop(entry.name, (manifest,), stamp)


def try_again(run: Drop, journal: Journal) -> None:
    """Have a run processed once more."""
    entry = journal.newest(run.name)
    if entry is not None:
        journal.note(entry.model_copy(update={"state": "made"}))


def _through_the_line(run: Path, archive: Path, recipe: Recipe, *, figures: bool) -> tuple[Outcome, ...]:
    store = Archive(archive)
    outcomes = [
        outcome for outcome in process([run], store, recipe, amend=True) if not outcome.place
    ]  # others are of other runs
    drawn = figure_steps(store, outcomes) if figures else []
    return (*outcomes, *(attempted(name, "figures", step) for name, step in drawn))


def _outcomes(folder: Path, answer: tuple[Outcome, ...] | TribopipeError) -> tuple[Outcome, ...]:
    """Return the outcomes of the steps of a run; if its process was lost, one outcome that reports this."""
    return answer if isinstance(answer, tuple) else (Outcome.failed(str(folder), "ingest", answer),)


def _ended(entry: Entry, outcomes: tuple[Outcome, ...], lab: Lab, journal: Journal) -> Event:
    if outcomes[0].error is None:
        outcomes += tuple(_set_aside(entry, Archive(lab.archive)))
    errors = [outcome.error for outcome in outcomes if outcome.error is not None]
    if not errors:
        journal.note(entry.model_copy(update={"state": "done"}))
    else:
        own = all(isinstance(error, _OF_THE_RUN) for error in errors)
        (journal.note if own else journal.hold)(entry.model_copy(update={"state": "failed"}))
    return _event(entry, outcomes)


def _set_aside(entry: Entry, archive: Archive) -> Iterator[Outcome]:
    """Mark the run as bad that was made of the same export before that went on; give an outcome where that fails."""
    half = entry.instead_of
    if half is None or not archive.path(half).exists():
        return
    reason = f"data were added to the file after ingestion; run {entry.run} contains the complete test"
    now = datetime.now(UTC).isoformat(timespec="seconds")
    try:
        if archive.bad(half) is None:
            archive.mark(half, Mark(kind="bad", reason=reason, date=now, operator="tribopipe watch"))
    except ArchiveError as error:
        yield Outcome.failed(half, "ingest", error)


def _event(entry: Entry, outcomes: tuple[Outcome, ...]) -> Event:
    errors = [str(outcome.error) for outcome in outcomes if outcome.error is not None]
    is_archived = outcomes[0].error is None
    run = outcomes[0].run_id if is_archived else entry.run
    said = f"{run or entry.name}: "
    return Event(
        kind="failed" if errors else "done",
        text=said + "archived; " * is_archived + (errors[0].removeprefix(said) if errors else "evaluated"),
        file=entry.name,
        run=run,
        details=tuple(line for outcome in outcomes for line in _details(outcome)),
        more={"steps": [outcome.as_json() for outcome in outcomes]},
    )


def _details(outcome: Outcome) -> Iterator[str]:
    """Yield the fitted values and the warnings."""
    if outcome.dropped is not None:
        yield "run.toml amended; the earlier version is kept"
    if outcome.stage in ("friction_fit", "wear_fit") and outcome.result is not None:
        yield str(outcome.result)
    yield from (f"warning: {finding}" for finding in outcome.findings if finding.severity == "warning")

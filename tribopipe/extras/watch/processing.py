"""From a run folder into the archive, through the whole line as `tribopipe process` takes it."""

from collections.abc import Iterator
from datetime import UTC, datetime
from functools import partial
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
from tribopipe.documents.mark import Mark
from tribopipe.documents.recipe import Recipe
from tribopipe.extras.watch.drops import Drop, stamp_of
from tribopipe.extras.watch.event import Event
from tribopipe.extras.watch.journal import Entry, Journal
from tribopipe.extras.watch.lab import Lab
from tribopipe.pipeline.stages import Outcome, attempted, process
from tribopipe.views.figure_updates import figure_steps

_OF_THE_RUN = (CheckError, ContactError, FitError, ManifestError, ReaderError)
"""What does not go away before run.toml changes."""


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
    reason = f"its file went on after it was archived; run {entry.run} has the whole"
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
        yield "run.toml amended; the earlier one is kept"
    if outcome.stage in ("friction_fit", "wear_fit") and outcome.result is not None:
        yield str(outcome.result)
    yield from (f"warning: {finding}" for finding in outcome.findings if finding.severity == "warning")

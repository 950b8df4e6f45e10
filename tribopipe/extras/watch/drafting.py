"""From what was dropped to a run folder: made once for the same bytes, under whatever names they come."""

import shutil
from collections.abc import Iterator

from tribopipe.archive.store import Archive
from tribopipe.base.errors import ReaderError, TribopipeError
from tribopipe.base.failures import in_a_sentence
from tribopipe.extras.watch.content import clear_begun, content_of, goes_on, id_for
from tribopipe.extras.watch.drops import Drop, moves
from tribopipe.extras.watch.event import Event
from tribopipe.extras.watch.journal import Entry, Journal
from tribopipe.extras.watch.lab import Lab
from tribopipe.readers.draft.folder import NewRun, Wanted, make_run


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
    yield Event("same", f"{drop.name}: holds the bytes of {twin.name}, which is run {twin.run}", drop.name, twin.run)


def _half(drop: Drop, run_id: str, lab: Lab, journal: Journal) -> str | None:
    """Return the run that was made of an export before it went on; none where it is another export."""
    before = journal.newest(drop.name)
    if before is None or before.run in (None, run_id) or not goes_on(drop, lab.run(before)):
        return None
    return before.run


def _make(drop: Drop, run_id: str, lab: Lab) -> NewRun | None:
    """Make a run folder; none where a watch has made it before, which did not come to note that."""
    clear_begun(run_id, lab.runs)
    if (lab.runs / run_id).exists():
        return None
    return make_run(Wanted(drop.files, lab.runs, run_id, lab.template))


def _made(entry: Entry, made: NewRun | None, lab: Lab, journal: Journal) -> Event:
    """Report for a run folder, which is processed unless something has to be filled in."""
    said = f"{entry.name}: run {entry.run}"
    if entry.instead_of:
        said += f", as the file went on after run {entry.instead_of} was made of it"
    lacks = made and (", ".join(made.lacks) or made.problem)
    if not lacks:
        journal.note(entry.model_copy(update={"state": "made"}))
        return Event("made", said, entry.name, entry.run)
    journal.note(lab.failed(entry))
    said += f"; still to be filled in: {lacks}; it is processed once that stands in {lab.manifest(entry)}"
    return Event("waiting", said, entry.name, entry.run)


def _left(drop: Drop, journal: Journal, error: TribopipeError) -> Event:
    """Leave a drop alone; where it is not its own fault, until the next start."""
    begun = journal.newest(drop.name)
    sha256 = begun.sha256 if begun is not None and begun.stamp == drop.stamp else ""
    entry = Entry(name=drop.name, stamp=drop.stamp, sha256=sha256, state="left")
    (journal.note if isinstance(error, ReaderError) else journal.hold)(entry)
    said = str(error).removeprefix(f"{drop.files[0].name}: ").removeprefix(f"{drop.name}: ")
    return Event("left", f"{drop.name}: no run is made of it; {said}", drop.name)

"""Events of a watch, and the state of each export, kept over restarts.

An event is a sentence for people and JSON for programs; the journal has one line of JSON for each drop that something
became of, and survives crashes.
"""

import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal

from pydantic import ValidationError

from tribopipe.base.errors import ArchiveError
from tribopipe.base.files import clear_leftovers_of, put_on_disk, write_file
from tribopipe.documents.record import Record
from tribopipe.extras.watch.drops import Drop

Kind = Literal["made", "done", "waiting", "failed", "same", "left", "gone", "back"]
_COUNTED: dict[Kind, str] = {
    "done": "archived",
    "waiting": "to be filled in",
    "failed": "failed",
    "same": "with the content of another file",
    "left": "ignored",
}


@dataclass(frozen=True)
class Event:
    """Something that happened."""

    kind: Kind
    text: str
    """One sentence."""
    file: str | None = None
    """Path of the export in the watched folder."""
    run: str | None = None
    """Id of the run, or the path of a run folder that was dropped."""
    details: tuple[str, ...] = ()
    """Further sentences: what was fitted, and what a person should look at."""
    more: Mapping[str, Any] = field(default_factory=dict)
    """Further JSON."""

    def as_json(self) -> dict[str, Any]:
        """Return the event as JSON types, with the current time."""
        now = datetime.now(UTC).isoformat(timespec="milliseconds")
        told = {"event": self.kind, "time": now, "file": self.file, "id": self.run, "text": self.text}
        return told | {"details": list(self.details)} | dict(self.more)


def counted(kinds: Iterable[Kind]) -> str:
    """Return how many drops came to which end."""
    kinds = list(kinds)
    counts = [f"{kinds.count(kind)} {words}" for kind, words in _COUNTED.items() if kind in kinds]
    return ", ".join(counts) or "nothing new"


FOLDER = ".watch"
_LINES, _LOCK = "journal.jsonl", "lock"
State = Literal["begun", "made", "done", "failed", "same", "left"]


class Entry(Record):
    """State of an export."""

    name: str
    """Path in the watched folder."""
    stamp: str
    """What it looked like."""
    sha256: str = ""
    """Checksum of its bytes; empty for a run folder."""
    state: State
    """Begun, and its run folder may be there or not; made; done, with the run archived; failed, until run.toml changes;
    same bytes as another; left alone, since no run can be made of it."""
    run: str | None = None
    """Id of the run that was made of it; None for a run folder, which stays where it is."""
    run_stamp: str = ""
    """What run.toml looked like when it was processed, or failed."""
    instead_of: str | None = None
    """Run made of the same export before it went on."""


class Journal:
    """The entries of a folder of runs. They are written as they come, and each is whole or not there at all."""

    def __init__(self, runs: Path) -> None:
        self._path = runs / FOLDER / _LINES
        self._entries: dict[tuple[str, str], Entry] = {}
        self._newest: dict[str, Entry] = {}
        self._by_content: dict[str, Entry] = {}
        for entry in self._read():
            self.hold(entry)
        # What a crash cut in the middle, and what is out of date, goes.
        clear_leftovers_of(self._path)
        write_file(self._path, "".join(map(_line, self._entries.values())).encode())

    def note(self, entry: Entry) -> None:
        """Remember an entry for ever."""
        with self._path.open("a", encoding="ascii", newline="\n") as file:
            file.write(_line(entry))
            file.flush()
            put_on_disk(file.fileno())
        self.hold(entry)

    def hold(self, entry: Entry) -> None:
        """Remember an entry until the watch ends; what was noted of it before counts again then."""
        key = (entry.name, entry.sha256)
        self._entries.pop(key, None)
        self._entries[key] = self._newest[entry.name] = entry
        if entry.state != "same":
            self._by_content[entry.sha256] = entry

    def newest(self, name: str) -> Entry | None:
        """Return what became of the last drop of a name."""
        return self._newest.get(name)

    def knows(self, drop: Drop) -> bool:
        """Return whether a drop was dealt with as it lies there."""
        entry = self._newest.get(drop.name)
        return entry is not None and entry.stamp == drop.stamp and entry.state != "begun"

    def run_of(self, sha256: str) -> Entry | None:
        """Return the entry of the run that was made, or begun, of these bytes, under whatever name."""
        entry = self._by_content.get(sha256)
        return entry if entry is not None and entry.run is not None else None

    def that_are(self, state: State) -> list[Entry]:
        """Return the newest entries in a state."""
        return [entry for entry in self._newest.values() if entry.state == state]

    def _read(self) -> Iterator[Entry]:
        if not self._path.exists():
            return
        for line in self._path.read_bytes().splitlines():
            try:
                yield Entry.model_validate_json(line)
            except ValidationError:
                continue  # cut in the middle by a crash: what it was about is begun again


def _line(entry: Entry) -> str:
    return json.dumps(entry.model_dump(exclude_defaults=True)) + "\n"


@contextmanager
def alone(runs: Path) -> Iterator[None]:
    """Be the only one who makes runs of exports in a folder, which is made where it is not there.

    Raises ``ArchiveError`` where another is at it.
    """
    from filelock import FileLock, Timeout

    try:
        (runs / FOLDER).mkdir(parents=True, exist_ok=True)
        with FileLock(runs / FOLDER / _LOCK, timeout=0, mode=0o666):
            yield
    except Timeout:
        raise ArchiveError(
            f"{runs}: found another `tribopipe watch` writing to this folder; expected only one; stop it, or "
            "choose another folder with --runs"
        ) from None

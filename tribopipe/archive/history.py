"""The history of an archive: one line for each write, chained by checksums, by which loss and exchange are seen.

A line is JSON, and its hash is the SHA-256 of its bytes without the line end. The state of a file is the checksum that
it is sealed with; none where there is no such file.

A write is announced before its file takes its place, and confirmed afterwards. Whoever is killed in between leaves the
old file or the new one, both of which the announcement names; any other is an exchange. Each line is on the disk
before the next step. A line that a killed process left half-written stays, and counts as one that proves nothing. The
hash of the last line is also kept next to the locks, so that a history that lost its end is noticed.

``Account`` reads what the history states about each file, and what is wrong with the history itself.
"""

import hashlib
import os
import re
import stat
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, BinaryIO, Literal, NamedTuple, TypeAlias, get_args

from pydantic import ConfigDict, Field, ValidationError

from tribopipe.archive.file_signature import STUDIES, SUFFIX, stamps
from tribopipe.archive.lock import LOCKS, history_lock
from tribopipe.archive.seal import state_of
from tribopipe.base.errors import ArchiveError
from tribopipe.base.files import put_on_disk, replacing
from tribopipe.documents.record import Record

FILE_NAME = "history.jsonl"
FIRST = "0" * 64
"""What stands in the place of the hash of the line before the first one."""
LONGEST_LINE = 1 << 16
"""Bytes; those we write have some hundreds."""
State: TypeAlias = str | None
Change = Literal["written", "imported", "removed", "restored"]
"""Announced before the file takes its place, or leaves it."""
Event = Literal[Change, "done", "settled", "adopted", "accepted", "begun", "broken"]
_NAME = rf"^(({STUDIES}/)?[^./\\:\x00-\x1f][^/\\:\x00-\x1f]{{0,250}}\{SUFFIX}|{FILE_NAME}|)$"


class Entry(Record):
    """One line of the history."""

    model_config = ConfigDict(extra="ignore")

    previous: str = FIRST
    """Hash of the line before."""
    date: str
    """When it was written, ISO 8601."""
    event: Event
    """What happened. Changes are announced before they are made, and "done" follows; "settled" follows in its place
    where the writer was killed in between; "adopted" is a file that was put in by hand, "accepted" what somebody has
    acknowledged; "begun" and "broken" show what the history itself has gone through."""
    file: Annotated[str, Field(pattern=_NAME)] = ""
    """Path in the archive."""
    before: State = None
    """State that a change was made from."""
    after: State = None
    """State after it, or as it was found."""
    by: str | None = None
    """Who accepted, removed or restored; none where nobody is known by name."""
    files: int = 0
    """Runs and studies that were there when the history began."""
    lost: str = ""
    """Hash of the last line that was known to be written, and was not found."""
    problems: str = ""
    """Fingerprint of all that was wrong with the history itself when that was accepted."""


def entry(event: Event, file: str = "", **more: State | int) -> Entry:
    """Return a history line with the current time, not yet chained."""
    return Entry(date=datetime.now(UTC).isoformat(timespec="seconds"), event=event, file=file, **more)  # type: ignore[arg-type]


def can_be_named(file: str) -> bool:
    """Return whether a file name is allowed in the history; tribopipe itself writes no others."""
    return re.search(_NAME, file) is not None


def chained(entries: Iterable[Entry], previous: str = FIRST) -> tuple[bytes, str]:
    """Return lines that follow the one of a hash, and the hash of the last."""
    lines = []
    for one in entries:
        lines.append(one.model_copy(update={"previous": previous}).model_dump_json(exclude_defaults=True).encode())
        previous = hash_of(lines[-1])
    return b"".join(line + b"\n" for line in lines), previous


def hash_of(line: bytes) -> str:
    """Return the hash of a line without its end."""
    return hashlib.sha256(line).hexdigest()


def parsed(line: bytes) -> Entry | None:
    """Return what a line holds; none where it is no line of a history, but half of one."""
    try:
        return Entry.model_validate_json(line)
    except ValidationError:
        return None


_HEAD = "history.head"
"""File with the locks that holds the hash of the last line."""
_TAIL = 4096
"""Bytes at the end that are read first."""
_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH


@contextmanager
def placed(archive: Path, path: Path, event: Change) -> Iterator[Path]:
    """Yield a temporary file that replaces a file of the archive, recorded in the history before and after.

    Whoever calls it holds the lock of the file's writers. Raises ``OSError`` and ``ArchiveError`` where the file or the
    history cannot be written; the file is then as it was.
    """
    before = state_of(path)
    with replacing(path, lambda part: announced(archive, path, event, before, state_of(part))) as part:
        yield part


@contextmanager
def announced(
    archive: Path, path: Path, event: Change, before: State, after: State, by: str | None = None
) -> Iterator[None]:
    """Announce a change of a file, and confirm it once it is done; a done one fails no more."""
    name = path.relative_to(archive).as_posix()
    append(archive, [entry(event, name, before=before, after=after, by=by)])
    yield
    with suppress(OSError, ArchiveError):
        append(archive, [entry("done", name)])


def append(archive: Path, entries: Sequence[Entry]) -> None:
    """Add lines to the history, all or none; one that is lost or cut is gone on with, and a warning is given.

    Raises ``ArchiveError`` where another process holds its lock for minutes, or its end is no line of a history;
    ``OSError`` where it cannot be written.
    """
    with history_lock(archive):
        path = archive / FILE_NAME
        try:
            with _opened(path, archive) as file:
                head = _added(archive, file, entries)
        except PermissionError:
            # It belongs to another account, which lets us write into its folder.
            with replacing(path) as part, part.open("r+b") as copy, path.open("rb") as old:
                while piece := old.read(1 << 20):
                    copy.write(piece)
                head = _added(archive, copy, entries)
        _keep_head(archive, head)


def known_head(archive: Path) -> str | None:
    """Return the hash of the last line that is stored next to the history; none if there is none."""
    try:
        kept = (archive / LOCKS / _HEAD).read_bytes()[:64].decode("ascii", "replace")
    except OSError:
        return None
    return kept if len(kept) == len(FIRST) else None


def _keep_head(archive: Path, head: str) -> None:
    """Keep the hash of the last line in the place of the one before; it helps, so that nothing fails without it."""
    path = archive / LOCKS / _HEAD
    with suppress(OSError):
        try:
            with path.open("r+b") as file:
                file.write(head.encode("ascii"))
        except FileNotFoundError:
            path.write_bytes(head.encode("ascii"))
            path.chmod(0o666)  # as the locks are: all who may write into the archive use it


def _opened(path: Path, archive: Path) -> BinaryIO:
    """Open the history, which those may write who may write into the archive."""
    with suppress(FileNotFoundError):
        return path.open("r+b")
    file = path.open("x+b")
    with suppress(OSError):
        path.chmod(stat.S_IMODE(path.stat().st_mode) | archive.stat().st_mode & _OTHERS_WRITE)
    return file


def _added(archive: Path, file: BinaryIO, entries: Sequence[Entry]) -> str:
    """Append lines after the last one; return the hash of the new last one."""
    size, known = file.seek(0, os.SEEK_END), known_head(archive)
    last = _last_line(archive, file, size)
    previous = hash_of(last.rstrip(b"\n")) if size else FIRST
    ended = last.endswith(b"\n")
    if len(last) == size and not ended:  # there is nothing yet, or half of a first line
        entries = [entry("begun", files=len(stamps(archive)), lost=known or ""), *entries]
    elif known not in (None, previous) and not _has_line(file, known):
        entries = [entry("broken", lost=known), *entries]
    lines, head = chained(entries, previous)
    file.seek(size)
    try:
        file.write(lines if ended or not size else b"\n" + lines)
        file.flush()
        put_on_disk(file.fileno())
    except OSError:
        with suppress(OSError):
            os.truncate(file.fileno(), size)
        raise
    return head


def _last_line(archive: Path, file: BinaryIO, size: int) -> bytes:
    """Return the last line, with its end if it has one; nothing of an empty file."""
    tail = min(_TAIL, LONGEST_LINE)
    while size:
        start = max(0, size - tail)
        file.seek(start)
        read = file.read(size - start)
        begins = read.rfind(b"\n", 0, -1) + 1
        if begins or not start:
            return read[begins:]
        if tail > LONGEST_LINE:
            raise ArchiveError(
                f"{archive / FILE_NAME}: found a last line of more than {LONGEST_LINE:,} bytes; expected shorter "
                "lines, as written by tribopipe; restore the history from a backup"
            )
        tail *= 4
    return b""


def _has_line(file: BinaryIO, wanted: str | None) -> bool:
    """Return whether a line of a hash is there."""
    file.seek(0)
    return any(hash_of(line.rstrip(b"\n")) == wanted for line in file)


_CHANGES = get_args(Change)


@dataclass
class Known:
    """What the history states about one file."""

    states: frozenset[State]
    """Possible states of the file: one, or two if a writer was killed before it confirmed its change."""
    date: str
    """Date of the last line about the file."""
    by_hand: bool = False
    """Whether it was put in by hand and is not reported yet."""
    foreign: str = ""
    """When it was written on top of a state that the history does not know; empty where it was not."""
    earlier: dict[State, str] = field(default_factory=dict)
    """States that it was in, and since when."""
    announced: State = None
    """State after the last change."""

    @property
    def unconfirmed(self) -> bool:
        """Whether a writer was killed, or still writes."""
        return len(self.states) > 1


class Problem(NamedTuple):
    """Something wrong with the history itself."""

    line: int
    hash: str
    """Of that line, as it is."""
    found: str
    """In words: "found … ; expected …"."""


class Account:
    """The history of an archive as far as it was read; ``read`` goes on from there.

    Attributes
    ----------
    files
        What it states about each file, by its path in the archive.
    problems
        What is wrong with the history itself and was not accepted.
    lines, head
        Number of lines, and hash of the last.
    begun
        Whether there is a valid line.
    """

    def __init__(self, archive: Path) -> None:
        self.files: dict[str, Known] = {}
        self.problems: list[Problem] = []
        self.lines, self.head, self.begun = 0, FIRST, False
        self._archive = archive
        self._hashes: set[bytes] = set()
        self._read = 0

    def read(self) -> "Account":
        """Read the lines that were added since. Raises ``OSError`` where it cannot be read."""
        path = self._archive / FILE_NAME
        if not path.is_file():
            return self
        with path.open("rb") as file:
            file.seek(self._read)
            while (line := file.readline(LONGEST_LINE + 1)).endswith(b"\n"):
                self._read += len(line)
                self._take(line[:-1])
            if len(line) > LONGEST_LINE:
                self._doubt(
                    f"found a line of more than {LONGEST_LINE:,} bytes; expected shorter lines, as written by tribopipe"
                )
        return self

    def missing(self) -> str | None:
        """Return the hash of a line that is known to have been written and is not there; none where all is."""
        known = known_head(self._archive)  # before its line is looked for, since others may write
        return None if known is None or self.read().has(known) else known

    def has(self, head: str) -> bool:
        """Return whether a line is there whose hash begins so."""
        if len(head) == len(FIRST):
            return bytes.fromhex(head) in self._hashes if _is_hex(head) else False
        return any(one.hex().startswith(head) for one in self._hashes)

    @property
    def is_whole(self) -> bool:
        """Whether nothing is wrong with the history itself, or all of it was accepted."""
        return not self.problems and self.missing() is None

    @property
    def fingerprint(self) -> str:
        """A text that is another one whenever another problem of the history is open."""
        return hashlib.sha256("".join(f"{line} {hashed}\n" for line, hashed, _ in self.problems).encode()).hexdigest()

    def _take(self, line: bytes) -> None:
        before, self.head = self.head, hash_of(line)
        self.lines += 1
        self._hashes.add(bytes.fromhex(self.head))
        one = parsed(line)
        if one is None:
            return  # half of a line, by a writer that was killed; an edited one is told by the line after it
        if not self.begun and one.event != "begun":
            self._doubt(
                "found a history without its first lines; expected every line since the creation of the archive"
            )
        self.begun = True
        if one.previous != before:
            self._doubt("found a line that does not match the line before it; expected unmodified lines")
        for problem in _of_itself(one):
            self._doubt(problem)
        if one.file == FILE_NAME:
            if one.event == "accepted" and one.problems == self.fingerprint:
                self.problems.clear()
        elif one.file:
            self._note(one)

    def _doubt(self, found: str) -> None:
        self.problems.append(Problem(self.lines, self.head, found))

    def _note(self, one: Entry) -> None:
        known = self.files.get(one.file)
        if known is None:
            known = self.files[one.file] = Known(frozenset([None]), one.date)
        if one.event in _CHANGES:
            _change(known, one)
        elif one.event == "done":
            _settle(known, known.announced, one.date)
        elif one.event == "settled" and one.after in known.states:
            _settle(known, one.after, one.date)
        elif one.event in ("adopted", "accepted"):
            known.by_hand, known.foreign = False, ""
            _settle(known, one.after, one.date)


def _change(known: Known, one: Entry) -> None:
    if one.before not in known.states:
        if known.states == {None}:
            known.by_hand = True
        else:
            known.foreign = one.date
    known.states, known.announced = frozenset([one.before, one.after]), one.after
    known.date = one.date


def _settle(known: Known, state: State, date: str) -> None:
    known.states, known.date = frozenset([state]), date
    known.earlier[state] = date


def _of_itself(one: Entry) -> Iterator[str]:
    """Report what a line states about the history itself."""
    if one.event == "broken" or (one.event == "begun" and one.lost):
        yield (
            f"found that history lines were missing when the archive was changed on {one.date} (hash of the last "
            f"missing line: {one.lost[:16]}); expected a complete history"
        )
    elif one.event == "begun" and one.files:
        count = f"{one.files} runs and studies" if one.files > 1 else "one run or study"
        yield (
            f"found a history that starts on {one.date}, after {count} were archived; expected a history that "
            "begins when the archive was created"
        )


def _is_hex(text: str) -> bool:
    return set(text) <= set("0123456789abcdef")

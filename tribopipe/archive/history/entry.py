"""One line of the history: what was done to which file, and the checksum of the line before it.

A line is JSON, and its hash is the SHA-256 of its bytes without the line end. The state of a file is the checksum that
it is sealed with; none where there is no such file.
"""

import hashlib
import re
from collections.abc import Iterable
from datetime import UTC, datetime
from typing import Annotated, Literal, TypeAlias

from pydantic import ConfigDict, Field, ValidationError

from tribopipe.archive.file_signature import STUDIES, SUFFIX
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

"""What the history of an archive states about each of its files, and what is wrong with the history itself."""

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple, get_args

from tribopipe.archive.history.chain import known_head
from tribopipe.archive.history.entry import FILE_NAME, FIRST, LONGEST_LINE, Change, Entry, State, hash_of, parsed

_CHANGES = get_args(Change)


@dataclass
class Known:
    """What the history states about one file."""

    states: frozenset[State]
    """Those that it may be in: one, or two where a writer was killed before it confirmed what it had announced."""
    date: str
    """Of the last line about it."""
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
                    f"found a line of more than {LONGEST_LINE:,} bytes; expected lines as tribopipe writes them"
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
            self._doubt("found a history without its first lines; expected one from the creation of the archive")
        self.begun = True
        if one.previous != before:
            self._doubt("found a line that does not follow the one before it; expected each as it was written")
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
            f"found that lines were gone when the archive was written to on {one.date}, the last of them "
            f"{one.lost[:16]}; expected all that were written"
        )
    elif one.event == "begun" and one.files:
        count = f"{one.files} runs and studies" if one.files > 1 else "one run or study"
        yield f"found that it begins on {one.date}, after {count} were archived; expected their origin in the history"


def _is_hex(text: str) -> bool:
    return set(text) <= set("0123456789abcdef")

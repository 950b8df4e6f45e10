"""Which readers there are: those of the entry points in the group ``tribopipe.readers``.

tribopipe's own readers are declared the same way. Nothing is imported before a reader is asked for.
"""

import warnings
from collections.abc import Sequence
from functools import cache
from importlib.metadata import EntryPoint
from operator import attrgetter
from typing import NamedTuple

from tribopipe.base.errors import ReaderError, did_you_mean
from tribopipe.base.plugins import Plugins
from tribopipe.readers.reader import Holds, Match, Reader
from tribopipe.results.run import SourceFile

GROUP = "tribopipe.readers"
_CONFIDENT = 0.5
_PLAIN = "delimited"
"""Reader that takes what is a table at all, so that it knows best what is missing in a file."""
_KNOWN = (
    "; expected one of the formats listed by `tribopipe formats list`; name it as reader, describe it in a reader "
    "profile, or export the file as a plain table"
)
_HOLD: dict[Holds, str] = {"signals": "signals of a test", "profile": "a profile"}
_MEND: dict[Holds, str] = {
    "signals": "name it under [[signals]] in run.toml",
    "profile": "name it as a profile under [end_values] in run.toml",
}


def readers() -> dict[str, Reader]:
    """Give all readers by name. One that cannot be loaded is left out, with a warning."""
    return dict(_loaded())


def reader_named(name: str) -> Reader:
    """Give the reader a manifest names; ``ReaderError`` names the nearest where there is none."""
    known = _loaded()
    found = dict(known).get(name)
    if found is None:
        raise ReaderError(
            f"found the unknown reader {name!r}; expected the name of an installed one; "
            f"{did_you_mean(name, dict(known))}"
        )
    return found


class Judged(NamedTuple):
    """A reader and what it makes of a file."""

    reader: Reader
    match: Match


def candidates(source: SourceFile, holds: Holds | None = None) -> list[Judged]:
    """Give the readers, or those for what a file should hold, each with its match; the surest first."""
    asked = [reader for _, reader in _loaded() if holds is None or reader.holds == holds]
    return sorted((Judged(reader, _match(reader, source)) for reader in asked), key=lambda one: -one.match.confidence)


def is_sure(match: Match) -> bool:
    """Return whether a reader claims a file."""
    return match.confidence >= _CONFIDENT


def detect(source: SourceFile, holds: Holds | None = None) -> Reader:
    """Find the reader for a file by its content, among those for what it should hold.

    Raises ``ReaderError`` where no reader is confident, saying why, or where two are equally so.
    """
    found = candidates(source)
    right = [one for one in found if holds is None or one.reader.holds == holds]
    best = next(iter(found), None)
    if holds and best and best.reader.holds != holds and is_sure(best.match) and not any(is_sure(m) for _, m in right):
        raise ReaderError(
            f"{source.name}: found a file of {best.reader.title}, which holds {_HOLD[best.reader.holds]}; expected one "
            f"with {_HOLD[holds]}; {_MEND[best.reader.holds]}"
        )
    return chosen(source, right)[0].reader


def chosen(source: SourceFile, found: Sequence[Judged]) -> list[Judged]:
    """Give those that claim a file, the surest first.

    Raises ``ReaderError`` where there is none, where two are equally sure, or where the file is known to hold nothing.
    """
    known_as = next((match.known_as for _, match in found if match.known_as), None)
    if known_as is not None:
        raise ReaderError(
            f"{source.name}: found {known_as}; expected a tribometer recording or a profile; omit this file"
        )
    sure = [one for one in found if is_sure(one.match)]
    if not sure:
        why = next((match.why for reader, match in found if reader.name == _PLAIN), "no reader recognizes it")
        remedy = "" if "; " in why else _KNOWN
        raise ReaderError(f"{source.name}: found no known format, and as a plain table: {why}{remedy}")
    best = [reader.name for reader, match in sure if match.confidence == sure[0].match.confidence]
    if len(best) > 1:
        raise ReaderError(
            f"{source.name}: found a file that {' and '.join(best)} both recognize with equal confidence; expected one "
            f'format; name it, as reader = "{best[0]}" in run.toml or with --reader {best[0]}'
        )
    return sure


@cache
def _loaded() -> tuple[tuple[str, Reader], ...]:
    return tuple(Plugins(GROUP, "reader", _made, attrgetter("name")).items())


def _made(entry: EntryPoint) -> Reader:
    reader = entry.load()()
    if not isinstance(reader, Reader):
        raise TypeError("has no name, title, holds, match or read")
    return reader


def _match(reader: Reader, source: SourceFile) -> Match:
    try:
        return reader.match(source)
    except Exception as error:  # noqa: BLE001 - somebody else's code may raise anything
        warnings.warn(f"reader {reader.name!r} failed on {source.name}: {error!r}", stacklevel=3)
        return Match(0.0, f"failed ({error!r})")

"""Which readers there are: those of the entry points in the group ``tribopipe.readers``.

tribopipe's own readers are declared the same way. Nothing is imported before a reader is asked for.
"""

import warnings
from collections.abc import Iterator
from functools import cache
from importlib.metadata import EntryPoint, entry_points

from tribopipe.errors import ReaderError, did_you_mean
from tribopipe.ingest.reader import Match, Reader
from tribopipe.run import SourceFile

GROUP = "tribopipe.readers"
_CONFIDENT = 0.5


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


def detect(source: SourceFile) -> Reader:
    """Find the reader for a file by its content.

    Raises ``ReaderError`` where no reader is confident, saying why, or where two are equally so.
    """
    matches = {name: _match(reader, source) for name, reader in _loaded()}
    top = max((match.confidence for match in matches.values()), default=0.0)
    if top < _CONFIDENT:
        tried = "; ".join(f"{name}: {match.why}" for name, match in matches.items()) or "no reader is installed"
        raise ReaderError(
            f"{source.name}: found no known format; expected one that an installed reader knows; name the reader in "
            f"run.toml, or export the file as a plain table; tried {tried}"
        )
    best = [name for name, match in matches.items() if match.confidence == top]
    if len(best) > 1:
        raise ReaderError(
            f"{source.name}: found a file that {' and '.join(best)} both know; expected one format; say which in "
            f'run.toml: reader = "{best[0]}"'
        )
    return reader_named(best[0])


@cache
def _loaded() -> tuple[tuple[str, Reader], ...]:
    found: dict[str, Reader] = {}
    for entry in _entries():
        reader = _load(entry)
        if reader is None:
            continue
        if reader.name in found:
            warnings.warn(f"{entry.value}: left out, since a reader {reader.name!r} is installed already", stacklevel=3)
            continue
        found[reader.name] = reader
    return tuple(found.items())


def _entries() -> Iterator[EntryPoint]:
    """Give tribopipe's own first, so that nothing can take their names."""
    entries = sorted(entry_points(group=GROUP), key=lambda entry: entry.name)
    yield from (entry for entry in entries if entry.module.startswith("tribopipe."))
    yield from (entry for entry in entries if not entry.module.startswith("tribopipe."))


def _load(entry: EntryPoint) -> Reader | None:
    try:
        reader = entry.load()()
    except Exception as error:  # noqa: BLE001 - somebody else's code may raise anything
        warnings.warn(f"reader {entry.name!r} left out: {entry.value} cannot be loaded ({error!r})", stacklevel=4)
        return None
    if isinstance(reader, Reader):
        return reader
    warnings.warn(f"reader {entry.name!r} left out: {entry.value} lacks name, title, match or read", stacklevel=4)
    return None


def _match(reader: Reader, source: SourceFile) -> Match:
    try:
        return reader.match(source)
    except Exception as error:  # noqa: BLE001 - somebody else's code may raise anything
        warnings.warn(f"reader {reader.name!r} failed at {source.name}: {error!r}", stacklevel=3)
        return Match(0.0, f"failed ({error!r})")

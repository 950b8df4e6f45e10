"""Profiles across wear tracks, from the text files that run.toml names beside the end values."""

from collections.abc import Iterator
from pathlib import Path, PurePath

import numpy as np

from tribopipe.errors import ReaderError
from tribopipe.ingest.columns import column_in_si, find_column, read_source
from tribopipe.ingest.reader import Hints, ReadTable
from tribopipe.ingest.registry import reader_named
from tribopipe.records.manifest import DISCS, ColumnSource, EndValues, ProfileSource, RunManifest
from tribopipe.run import Column, Profile, SourceFile
from tribopipe.units import show

_FEWEST = 20
"""Points by which shoulders and track can be told apart."""


def read_profiles(
    manifest: RunManifest, folder: Path, sources: list[SourceFile], headers: dict[str, str], notes: list[str]
) -> dict[str, Profile]:
    """Return the profiles of a run by where run.toml names them, such as "interruptions[0].flat_disc_profile".

    Their files are added to the sources, each once, with what stands above the numbers and what there is to note.
    Raises ``ReaderError`` with file, key or line, what was found and what was expected.
    """
    profiles: dict[str, Profile] = {}
    tables: dict[PurePath, ReadTable] = {}
    for key, named in _named(manifest):
        path = PurePath(named.file)
        if path not in tables:
            tables[path] = _read_table(folder, key, named, sources, headers, notes)
        profiles[key] = _profile(tables[path], named, key)
    return profiles


def _named(manifest: RunManifest) -> Iterator[tuple[str, ProfileSource]]:
    stops: list[tuple[str, EndValues]] = [
        (f"interruptions[{number}]", stop) for number, stop in enumerate(manifest.interruptions)
    ]
    for where, values in [("end_values", manifest.end_values), *stops]:
        for disc in DISCS:
            named: ProfileSource | None = getattr(values, f"{disc}_profile")
            if named is not None:
                yield f"{where}.{disc}_profile", named


def _read_table(
    folder: Path, key: str, named: ProfileSource, sources: list[SourceFile], headers: dict[str, str], notes: list[str]
) -> ReadTable:
    """Read a file, which may be one of the sources already."""
    there = next((source for source in sources if PurePath(source.name) == PurePath(named.file)), None)
    source = there or read_source(folder, named.file, f"{key}.file", "profile")
    table = reader_named("delimited").read(source, Hints())
    if there is None:
        sources.append(source)
        headers[source.name] = table.header
        notes += [f"{source.name}: {note}" for note in table.notes]
    return table


def _profile(table: ReadTable, named: ProfileSource, key: str) -> Profile:
    position, height = (
        _column(table, source, what, named.file)
        for what, source in (("position", named.position), ("height", named.height))
    )
    seen = np.isfinite(position) & np.isfinite(height)
    order = np.argsort(position[seen], kind="stable")
    profile = Profile(position[seen][order], height[seen][order])
    if len(order) < _FEWEST:
        raise ReaderError(
            f"{named.file}: found {len(order)} points with position and height for {key}; expected at least {_FEWEST}; "
            "export the profile with all its points"
        )
    _refuse_repeats(profile.position, named)
    return profile


def _column(table: ReadTable, source: ColumnSource, what: str, file: str) -> Column:
    return column_in_si(find_column(table, source.column, what, file), source, what, "length", file)


def _refuse_repeats(position: Column, named: ProfileSource) -> None:
    """Refuse what is no single pass across the track: then height does not follow from position."""
    where = f"{named.file}, column {named.position.column!r}"
    repeated = np.flatnonzero(np.diff(position) == 0)
    if position[0] == position[-1]:
        raise ReaderError(
            f"{where}: found the same position in all {len(position)} rows; expected positions across the track; map "
            "the column that holds them"
        )
    if len(repeated):
        first = float(position[repeated[0]])
        raise ReaderError(
            f"{where}: found the position {show(first, None, 'm', 'mm')} {np.count_nonzero(position == first)} times; "
            "expected each once; export a single pass across the track, with enough digits of the position"
        )

"""Profiles across wear tracks and worn pins, from the files that run.toml names with the post-test measurements.

A file is read by the reader that run.toml names, by one that knows its content to be a profile, or as any other table.
Which columns are position and height is for run.toml to state, else for the format. Where neither does, columns called
x, y and z are taken, or the two columns of a table that has just two, both of them lengths: by their names, such as
height and lateral position, or else the first as the position. A column of positions that runs back over more than
jitter is refused, since it is of several passes, or of something else.

A file may hold several profiles: several columns of heights, one for each pass, or a map. A map gives one profile for
each scan line along x, or along the column that run.toml names as position, with the position of that line across the
others. Positions across have the unit that run.toml states for positions, else their own, else that of x.

Each profile has a key by its place in run.toml: "end_values.disc_profile" where there is one, and
"end_values.disc_profile[0]", "[1]", … in the order of the files and of the lines in them where there are several.
Scan lines of a map measured before the test have keys of their own: "end_values.disc_profile.before[0]", ….
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePath

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ReaderError
from tribopipe.base.units import is_unit_of, show
from tribopipe.documents.contact_kinds import ROLES
from tribopipe.documents.manifest import ColumnSource, EndValues, ProfileSource, RunManifest, is_described
from tribopipe.readers.column_mapping import column_in_si, find_column, read_source
from tribopipe.readers.column_meanings import names_of, plain
from tribopipe.readers.number_fields import remarks
from tribopipe.readers.reader import (
    Axis,
    Hints,
    ReadColumn,
    Reader,
    ReadTable,
    candidates,
    detect,
    is_sure,
    reader_named,
)
from tribopipe.readers.tables import bare_name
from tribopipe.results.run import Profile, SourceFile, before_key

_FEWEST = 20
"""Points by which shoulders and track can be distinguished."""
_FARTHEST_BACK = 0.1
"""Share of all positions by which a single pass may run back, because of jitter."""
_EITHER = frozenset(("displacement", "przemieszczenie", "位移", "変位"))
"""Synonyms of the depth of a signal that may be a position in a profile."""
_HEIGHTS = (
    "z height vertical elevation topography profile hoehe höhe profilhöhe profilhoehe vertikal profil hauteur "
    "altitude altura altezza quota perfil profilo wysokość głębokość výška hloubka höjd djup 高度 高さ 深度 深さ"
)
_POSITIONS = (
    "x position pos lateral horizontal abscissa length width scan path tastweg messweg verfahrweg taststrecke "
    "messstrecke länge laenge breite horizontale abscisse largeur longueur posición abscisa longitud ancho "
    "posizione ascissa lunghezza larghezza pozycja położenie długość szerokość poloha läge 位置 長さ 长度"
)
_HEIGHT_WORDS = frozenset(map(plain, _HEIGHTS.split())) | (frozenset(names_of("depth")) - _EITHER)
_POSITION_WORDS = frozenset(map(plain, _POSITIONS.split())) | frozenset(names_of("sliding_distance"))
_WORD = re.compile(r"[^\W\d_]+")


@dataclass
class _Read:
    """Files read so far as sources of the run, and their tables."""

    folder: Path
    sources: list[SourceFile]
    headers: dict[str, str]
    notes: list[str]
    tables: dict[tuple[str, str | None], ReadTable] = field(default_factory=dict)
    """Tables of the files by name and reader, shared by all profiles from one file."""

    def table(self, source: SourceFile, named: ProfileSource, key: str) -> ReadTable:
        """Read a file, once."""
        known = source.name, named.reader
        if known not in self.tables:
            self.tables[known] = self._reader(source, named, key).read(source, Hints())
        return self.tables[known]

    def _reader(self, source: SourceFile, named: ProfileSource, key: str) -> Reader:
        if named.reader is None or not is_described(named.reader):
            return _reader_for(source, named, key)
        from tribopipe.readers.toml_reader import reader_in

        return reader_in(self.folder, named.reader, self.sources, f"{key}.reader")

    def source(self, key: str, file: str) -> SourceFile:
        """Return a file, which may be a source already."""
        there = next((source for source in self.sources if PurePath(source.name) == PurePath(file)), None)
        return there or read_source(self.folder, file, f"{key}.file", "profile")

    def keep(self, source: SourceFile, table: ReadTable, notes: list[str]) -> None:
        """Make a file a source of the run, once."""
        if source not in self.sources:
            self.sources.append(source)
            self.headers[source.name] = table.header
            self.notes += [f"{source.name}: {note}" for note in (*remarks(table), *notes)]


def read_profiles(
    manifest: RunManifest, folder: Path, sources: list[SourceFile], headers: dict[str, str], notes: list[str]
) -> dict[str, Profile]:
    """Return the profiles of a run by where run.toml names them, such as "interruptions[0].flat_disc_profile".

    Their files are added to the sources, each once, with what stands above the numbers and what there is to note.
    Raises ``ReaderError`` with file, key or line, what was found and what was expected.
    """
    profiles: dict[str, Profile] = {}
    read = _Read(folder, sources, headers, notes)
    for key, files in _named(manifest):
        profiles |= _read_files(read, key, key, files)
        earlier = [one.model_copy(update={"file": one.before, "before": None}) for one in files if one.before]
        if earlier:
            _refuse_copies(read, key, files)
            profiles |= _read_files(read, before_key(key), key, earlier)
    return profiles


def _read_files(read: _Read, key: str, where: str, files: Sequence[ProfileSource]) -> dict[str, Profile]:
    """Return the profiles of some files by their keys; errors name where run.toml lists the files."""
    found: list[Profile] = []
    for number, named in enumerate(files):
        at = where if len(files) == 1 else f"{where}[{number}]"
        source = read.source(at, named.file)
        table = read.table(source, named, at)
        lines, said = _profiles_of(table, named, at, Units.of(named))
        read.keep(source, table, said)
        found += lines
    return dict(zip(_keys(key, len(found)), found, strict=True))


def _refuse_copies(read: _Read, key: str, files: Sequence[ProfileSource]) -> None:
    """Refuse a map before the test that is a copy of the one after it."""
    for one in files:
        if one.before is not None and read.source(key, one.before).sha256 == read.source(key, one.file).sha256:
            raise ReaderError(
                f"run.toml: {key}.before: found that {one.before} is a copy of {one.file}; expected the map measured "
                "before the test; correct the name, or export the map again"
            )


def _named(manifest: RunManifest) -> Iterator[tuple[str, tuple[ProfileSource, ...]]]:
    stops: list[tuple[str, EndValues]] = [
        (f"interruptions[{number}]", stop) for number, stop in enumerate(manifest.interruptions)
    ]
    for where, values in [("end_values", manifest.end_values), *stops]:
        for body in ROLES:
            files: tuple[ProfileSource, ...] = getattr(values, f"{body}_profile")
            if files:
                yield f"{where}.{body}_profile", files


def _keys(key: str, count: int) -> list[str]:
    return [key] if count == 1 else [f"{key}[{number}]" for number in range(count)]


@dataclass(frozen=True)
class Units:
    """Stated units of positions and heights; they take precedence over those in the file."""

    position: str | None = None
    height: str | None = None

    @classmethod
    def of(cls, named: ProfileSource) -> "Units":
        """Return those of run.toml."""
        return cls(*(None if column is None else column.unit for column in (named.position, named.height)))


def profiles_in(
    source: SourceFile, named: ProfileSource, key: str, units: Units | None = None
) -> tuple[ReadTable, list[Profile], list[str]]:
    """Read all profiles of one file, in SI, and report what there is to note of them.

    ``key`` is where run.toml names the file, for errors. Raises ``ReaderError``.
    """
    table = _reader_for(source, named, key).read(source, Hints())
    return table, *_profiles_of(table, named, key, units or Units.of(named))


def _profiles_of(table: ReadTable, named: ProfileSource, key: str, units: Units) -> tuple[list[Profile], list[str]]:
    columns = _columns(table, named, key)
    position = _in_si(columns.position, units.position, "position", named.file)
    across = _across(columns, units, named.file)
    lines, places = _scan_lines(across, len(position)), across if columns.lies_across else None
    profiles: list[Profile] = []
    notes: list[str] = []
    fewest = len(position)
    for column in columns.heights:
        height = _in_si(column, units.height, "height", named.file)
        scan = named.file if len(columns.heights) == 1 else f"{named.file}, {column.name}"
        for line in lines:
            seen = line[np.isfinite(position[line]) & np.isfinite(height[line])]
            if len(seen) >= _FEWEST:
                profile = _profile(position[seen], height[seen], columns.position.name, named.file, notes)
                profiles.append(profile if places is None else _placed(profile, float(places[seen[0]]), scan))
            fewest = min(fewest, len(seen))
    _account(len(columns.heights) * len(lines), profiles, fewest, named.file, key, notes)
    if columns.across is not None and places is None:
        notes.append(f"column {columns.across.name!r} has no unit of length: the scan lines are evaluated separately")
    return profiles, list(dict.fromkeys(notes))


def _account(lines: int, profiles: list[Profile], fewest: int, file: str, key: str, notes: list[str]) -> None:
    """Note what was left out. Raises ``ReaderError`` where nothing is left."""
    if not profiles:
        raise ReaderError(
            f"{file}: found {fewest} points with both position and height for {key}; expected at least {_FEWEST}; "
            "export the complete profile"
        )
    if len(profiles) < lines:
        notes.append(
            f"{lines - len(profiles)} of {lines} scan lines omitted, since they have fewer than {_FEWEST} points each"
        )


def _reader_for(source: SourceFile, named: ProfileSource, key: str) -> Reader:
    """Return the reader named, or one that knows the content as a profile, or as a table at least."""
    if named.reader is not None:
        try:
            return reader_named(named.reader)
        except ReaderError as error:
            raise ReaderError(f"run.toml: {key}.reader of {named.file}: {error}") from None
    if is_sure(candidates(source, "profile")[0][1]):
        return detect(source, "profile")
    return detect(source) if is_sure(candidates(source)[0][1]) else reader_named("delimited")


@dataclass(frozen=True)
class _Columns:
    """Which columns of a table are what."""

    position: ReadColumn
    """Along a scan line."""
    heights: list[ReadColumn]
    """Profiles, each from one scan line."""
    across: ReadColumn | None = None
    """Values that distinguish the scan lines of a map."""

    @property
    def lies_across(self) -> bool:
        """Whether these values are positions; without a unit of their own they are in that of the other positions."""
        return self.across is not None and (self.across.unit is None or _is_length(self.across))


def _columns(table: ReadTable, named: ProfileSource, key: str) -> _Columns:
    """Find position and heights. Raises ``ReaderError`` where run.toml has to state which they are."""
    axes = _axes(table)
    along, heights = axes["x"][:1], axes["z"]
    if named.position is not None:
        along = [find_column(table, named.position.column, "position", named.file)]
        heights = _without(along[0], heights, axes["x"])
    if named.height is not None:
        heights = [find_column(table, named.height.column, "height", named.file)]
        along = along if named.position is not None else _without(heights[0], along, axes["z"])
    if not along or not heights:
        names = ", ".join(repr(column.name) for column in table.columns[:8])
        raise ReaderError(
            f"{named.file}: found the columns {names}, in which position and height cannot be identified; "
            "expected unambiguous column names; specify the columns in run.toml "
            f'under {key}: position = "…", height = "…"'
        )
    others = [column for column in (*axes["x"], *axes["y"]) if column.name not in (along[0].name, heights[0].name)]
    return _Columns(along[0], heights, others[0] if axes["y"] and others else None)


def _without(taken: ReadColumn, columns: list[ReadColumn], others: list[ReadColumn]) -> list[ReadColumn]:
    """Return columns without the one that run.toml names as something else; the others where it was the only one."""
    if [column.name for column in columns] != [taken.name]:
        return [column for column in columns if column.name != taken.name]
    return [column for column in others if column.name != taken.name]


def tells_axes(table: ReadTable) -> bool:
    """Return whether position and height are known though nobody names their columns."""
    axes = _axes(table)
    return bool(axes["x"] and axes["z"])


def _axes(table: ReadTable) -> dict[Axis, list[ReadColumn]]:
    """Sort columns by axis: by the format's word, else by their names, else by being two lengths."""
    wanted: tuple[Axis, ...] = ("x", "y", "z")
    columns = table.columns
    if any(column.axis for column in columns):
        return {axis: [column for column in columns if column.axis == axis] for axis in wanted}
    by_name = {axis: [column for column in columns if bare_name(column.name).lower() == axis] for axis in wanted}
    if (by_name["x"] and by_name["z"]) or len(columns) != 2 or not all(map(_is_length, columns)):
        return by_name
    position, height = sorted(columns, key=_place_by_name)
    return {"x": [position], "y": [], "z": [height]}


def _place_by_name(column: ReadColumn) -> int:
    """Return -1 for a name of positions and 1 for one of heights; 0 where it is neither, or both: "z position"."""
    name = bare_name(column.name)
    words = {plain(name), *map(plain, _WORD.findall(name))}
    return int(not words.isdisjoint(_HEIGHT_WORDS)) - int(not words.isdisjoint(_POSITION_WORDS))


def _is_length(column: ReadColumn) -> bool:
    return column.unit is not None and is_unit_of(column.unit, "length")


def _in_si(column: ReadColumn, unit: str | None, what: str, file: str) -> Column:
    return column_in_si(column, ColumnSource(column=column.name, unit=unit), what, "length", file)


def _across(columns: _Columns, units: Units, file: str) -> Column | None:
    """Return what distinguishes the scan lines: their position across, m, if that is known."""
    if columns.across is None:
        return None
    unit = units.position or columns.across.unit or columns.position.unit
    return _in_si(columns.across, unit if columns.lies_across else "m", "scan lines", file)


def _scan_lines(places: Column | None, count: int) -> list[NDArray[np.intp]]:
    """Return which of so many rows make up each scan line, in the order of the file."""
    if places is None:
        return [np.arange(count)]
    _, first, line, rows = np.unique(places, return_index=True, return_inverse=True, return_counts=True)
    lines = np.split(np.argsort(line, kind="stable"), np.cumsum(rows)[:-1])
    return [lines[number] for number in np.argsort(first)]


def _placed(profile: Profile, across: float, scan: str) -> Profile:
    """Return a scan line with its position across those of its map, m, if that is known."""
    return replace(profile, across=across, scan=scan) if np.isfinite(across) else profile


def _profile(position: Column, height: Column, column: str, file: str, notes: list[str]) -> Profile:
    """Return one pass across the track, sorted."""
    position = _spread_evenly(position, notes)
    order = np.argsort(position, kind="stable")
    profile = Profile(position[order], height[order])
    _refuse_repeats(profile.position, column, file)
    _refuse_several_passes(position, column, file)
    return profile


def _spread_evenly(position: Column, notes: list[str]) -> Column:
    """Give samples that were rounded to the same position their own, where all of them are even but for that."""
    steps = np.diff(position)
    if np.all(steps > 0) or not (np.all(steps >= 0) and np.any(steps)):
        return position
    even = np.linspace(position[0], position[-1], len(position))
    rounded = float(np.min(steps[steps > 0]))
    if np.max(np.abs(position - even)) > rounded:
        return position
    notes.append(
        "positions are rounded, so that some are identical; they are replaced by uniformly spaced positions "
        "between the first and the last"
    )
    return even


def _refuse_repeats(position: Column, column: str, file: str) -> None:
    """Refuse what is no single pass across the track: then height does not follow from position."""
    where = f"{file}, column {column!r}"
    repeated = np.flatnonzero(np.diff(position) == 0)
    if position[0] == position[-1]:
        raise ReaderError(
            f"{where}: found the same position in all {len(position):,} rows; expected positions across the track; "
            f"map the column that contains the positions"
        )
    if len(repeated):
        first = float(position[repeated[0]])
        raise ReaderError(
            f"{where}: found the position {show(first, None, 'm', 'mm')} {np.count_nonzero(position == first)} times; "
            "expected each position once; export a single pass across the track, with enough digits in the positions"
        )


def _refuse_several_passes(position: Column, column: str, file: str) -> None:
    """Refuse positions that run back over more than jitter: to sort them would merge passes, or scramble a profile."""
    rises = np.max(np.maximum.accumulate(position) - position)
    falls = np.max(position - np.minimum.accumulate(position))
    back = float(min(rises, falls))
    if back > _FARTHEST_BACK * np.ptp(position):
        raise ReaderError(
            f"{file}, column {column!r}: found positions that run back by {show(back, None, 'm', 'mm')}; expected a "
            "single pass across the track; export each pass as a separate file, or map the column that contains the "
            "positions"
        )

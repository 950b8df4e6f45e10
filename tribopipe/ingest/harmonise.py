"""The one place where what readers found becomes a run: named, in SI, completed, with its origins."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tribopipe.derived import derive_missing
from tribopipe.errors import ReaderError
from tribopipe.ingest.columns import column_in_si, find_column, is_a_weight, needs_unit, read_source, unit_of
from tribopipe.ingest.names import bare_name
from tribopipe.ingest.profiles import read_profiles
from tribopipe.ingest.reader import Hints, ReadColumn, Reader, ReadTable
from tribopipe.ingest.registry import detect, reader_named
from tribopipe.records.manifest import (
    ColumnSource,
    RunManifest,
    SignalFile,
    is_described,
    manifest_path,
    read_manifest,
)
from tribopipe.records.signals import SIGNALS, SignalName
from tribopipe.run import Column, ExtraColumn, Origin, RawRun, SourceFile


@dataclass
class _Gathered:
    """Columns of all files so far."""

    columns: dict[SignalName, Column] = field(default_factory=dict)
    extras: dict[str, ExtraColumn] = field(default_factory=dict)
    headers: dict[str, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    @property
    def length(self) -> int | None:
        """Number of samples; none before the first file."""
        return next((len(values) for values in self.columns.values()), None)


class _Part(NamedTuple):
    """Columns of one file, or of several that continue each other."""

    columns: dict[SignalName, Column]
    extras: dict[str, ExtraColumn]


def read_run(path: Path | str) -> RawRun:
    """Read a run folder (or its run.toml) as a run in SI.

    Time, sliding distance and a disc's rotations are derived from one another where some are missing, the friction
    coefficient from friction force and normal force, or the nominal load where the force was not recorded.

    Raises ``ManifestError`` or ``ReaderError`` with file, key or line, what was found and what was expected.
    """
    where = manifest_path(Path(path))
    manifest, content = read_manifest(where)
    try:
        return _read_files(manifest, where.parent, SourceFile(where.name, content))
    except ReaderError as error:
        raise ReaderError(f"{where.parent}: {error}") from None


def _read_files(manifest: RunManifest, folder: Path, written: SourceFile) -> RawRun:
    sources, gathered = [written], _Gathered()
    for signals in manifest.signals:
        reader = _named_reader(signals, folder, sources)
        parts = []
        for name in signals.names:
            sources.append(read_source(folder, name))
            # Files that continue each other are of one format, which the first may show better than a short one.
            reader = reader or detect(sources[-1], holds="signals")
            parts.append(_read_part(gathered, sources[-1], reader, signals))
        _add(gathered, _joined(signals.names, parts, gathered.notes), _spoken(signals.names))
    origins: dict[SignalName, Origin] = dict.fromkeys(gathered.columns, "measured")
    derive_missing(gathered.columns, origins, manifest)
    ordered = {name: gathered.columns[name] for name in SIGNALS if name in gathered.columns}
    profiles = read_profiles(manifest, folder, sources, gathered.headers, gathered.notes)
    return RawRun(
        manifest, ordered, origins, gathered.extras, gathered.headers, tuple(sources), tuple(gathered.notes), profiles
    )


def _named_reader(signals: SignalFile, folder: Path, sources: list[SourceFile]) -> Reader | None:
    """Return the reader that the manifest names, whose description joins the sources where it is a file of the run.

    None where it is to be found by the content; a separator named means delimited text.
    """
    if signals.reader is None:
        return None if signals.separator is None else reader_named("delimited")
    if is_described(signals.reader):
        from tribopipe.ingest.described import described_reader, load_reader_profile

        if all(source.name != signals.reader for source in sources):
            sources.append(read_source(folder, signals.reader, "signals.reader", "description of a reader"))
        return described_reader(load_reader_profile(folder / signals.reader))
    try:
        return reader_named(signals.reader)
    except ReaderError as error:
        raise ReaderError(f"run.toml: signals.reader of {signals.names[0]}: {error}") from None


def _read_part(gathered: _Gathered, source: SourceFile, reader: Reader, signals: SignalFile) -> _Part:
    """Read one file: its signals in SI, and what no signal is made of."""
    hints = Hints(encoding=signals.encoding, separator=signals.separator, decimal=signals.decimal)
    table = reader.read(source, hints)
    gathered.headers[source.name] = table.header
    gathered.notes += [f"{source.name}: {note}" for note in table.notes]
    meanings = _meanings(table, signals, source.name)
    part = _Part({}, {})
    for column in table.columns:
        for name, told in meanings.get(column.name, []):
            kind = SIGNALS[name].kind
            part.columns[name] = column_in_si(column, told, name, kind, source.name)
            if is_a_weight(column, told, kind):
                gathered.notes.append(
                    f"{source.name}: {name} in {unit_of(column, told)} is taken as the weight of that mass"
                )
        if column.name not in meanings:
            part.extras[column.name] = ExtraColumn(column.values, column.unit)
    return part


def _spoken(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{names[0]} … {names[-1]}"


def _joined(names: Sequence[str], parts: Sequence[_Part], notes: list[str]) -> _Part:
    """Put the rows of files that continue each other one after the other, and say from which file each row came."""
    first = parts[0]
    if len(parts) == 1:
        return first
    for name, part in zip(names, parts, strict=True):
        if part.columns.keys() != first.columns.keys():
            raise ReaderError(
                f"{name}: found the signals {', '.join(part.columns)}, where {names[0]} has "
                f"{', '.join(first.columns)}; expected the same in files that continue each other; map them "
                "under [signals.columns] in run.toml, or take out the file that is of another test"
            )
    extras = {
        label: ExtraColumn(np.concatenate([part.extras[label].values for part in parts]), extra.unit)
        for label, extra in first.extras.items()
        if all(_alike(part.extras.get(label), extra) for part in parts)
    }
    others = dict.fromkeys(label for part in parts for label in part.extras if label not in extras)
    if others:
        spoken = ", ".join(map(repr, others))
        notes.append(f"{_spoken(names)}: left out {spoken}, which not every file has, or not in the same unit")
    rows = [len(next(iter(part.columns.values()))) for part in parts]
    extras[_free_name("file", extras)] = ExtraColumn(np.repeat(np.arange(1.0, len(parts) + 1), rows), "1")
    return _Part({name: np.concatenate([part.columns[name] for part in parts]) for name in first.columns}, extras)


def _alike(one: ExtraColumn | None, other: ExtraColumn) -> bool:
    return one is not None and one.unit == other.unit and one.values.dtype == other.values.dtype


def _add(gathered: _Gathered, part: _Part, file: str) -> None:
    """Add the columns of a file, or several, to those before, sample by sample."""
    found, length = len(next(iter(part.columns.values()))), gathered.length
    if length is not None and found != length:
        raise ReaderError(
            f"{file}: found {found} rows where the files before have {length}; "
            "expected one row a sample in every file; merge them on one time base first"
        )
    for name, values in part.columns.items():
        if name in gathered.columns:
            _refuse_difference(name, gathered.columns[name], values, file)
        gathered.columns[name] = values
    for label, extra in part.extras.items():
        gathered.extras[_free_name(label, gathered.extras)] = extra


def _refuse_difference(name: SignalName, before: Column, values: Column, file: str) -> None:
    """Accept a signal a second time where it is the same: several files of one test share their time base."""
    different = np.flatnonzero(~(np.isclose(before, values, rtol=1e-9, atol=0) | (np.isnan(before) & np.isnan(values))))
    if len(different):
        raise ReaderError(
            f"{file}: found another {name} than in the files before, first at sample {different[0] + 1}; expected each "
            "signal once, or the same in every file; map it in one file only, or merge the files on one time base first"
        )


def _free_name(name: str, taken: Mapping[str, Any]) -> str:
    return name if name not in taken else _free_name(f"{name} (again)", taken)


Meanings = dict[str, list[tuple[SignalName, ColumnSource | None]]]


def _meanings(table: ReadTable, signals: SignalFile, file: str) -> Meanings:
    """Say for each column by name which signals it is: by the manifest's word, else by the format's or its own name."""
    meanings: Meanings = {}
    for name, source in signals.columns.items():
        meanings.setdefault(find_column(table, source.column, name, file).name, []).append((name, source))
    taken = set(signals.columns)
    for column in table.columns:
        known = column.signal or _by_own_name(column.name)
        if known is None or known in taken or column.name in meanings or not _usable(column, known):
            continue
        meanings[column.name] = [(known, None)]
        taken.add(known)
    if not meanings:
        names = ", ".join(repr(column.name) for column in table.columns[:8])
        raise ReaderError(
            f"{file}: found the columns {names}, none with a known meaning; expected to be told; "
            "map signals to columns under [signals.columns] in run.toml"
        )
    return meanings


def _usable(column: ReadColumn, signal: SignalName) -> bool:
    """Tell whether a column may be taken by its name alone: numbers, with a unit where one is needed."""
    return column.first_bad is None and (column.unit is not None or not needs_unit(SIGNALS[signal].kind))


def _by_own_name(name: str) -> SignalName | None:
    wanted = bare_name(name).lower().replace(" ", "_")
    return next((signal for signal in SIGNALS if signal == wanted), None)

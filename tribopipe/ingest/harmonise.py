"""The one place where what readers found becomes a run: named, in SI, completed, with its origins."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tribopipe.errors import ReaderError
from tribopipe.ingest.axes import complete_axes
from tribopipe.ingest.columns import column_in_si, find_column, read_source
from tribopipe.ingest.names import bare_name
from tribopipe.ingest.profiles import read_profiles
from tribopipe.ingest.reader import Hints, ReadColumn, Reader, ReadTable
from tribopipe.ingest.registry import detect, reader_named
from tribopipe.records.manifest import ColumnSource, RunManifest, SignalFile, manifest_path, read_manifest
from tribopipe.records.signals import SIGNALS, SignalName
from tribopipe.run import Column, ExtraColumn, Origin, RawRun, SourceFile


@dataclass
class _Gathered:
    """Columns of all files so far."""

    columns: dict[SignalName, Column]
    extras: dict[str, ExtraColumn]
    headers: dict[str, str]
    notes: list[str]


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
    sources = [written]
    gathered = _Gathered({}, {}, {}, [])
    for signals in manifest.signals:
        source = read_source(folder, signals.file)
        sources.append(source)
        table = _reader_for(signals, source).read(
            source, Hints(encoding=signals.encoding, separator=signals.separator, decimal=signals.decimal)
        )
        _gather(gathered, table, signals)
    origins: dict[SignalName, Origin] = dict.fromkeys(gathered.columns, "measured")
    _complete(gathered.columns, origins, manifest)
    ordered = {name: gathered.columns[name] for name in SIGNALS if name in gathered.columns}
    profiles = read_profiles(manifest, folder, sources, gathered.headers, gathered.notes)
    return RawRun(
        manifest, ordered, origins, gathered.extras, gathered.headers, tuple(sources), tuple(gathered.notes), profiles
    )


def _reader_for(signals: SignalFile, source: SourceFile) -> Reader:
    """Return the reader the manifest names, or the one for the content; a separator named means delimited text."""
    if signals.reader is None:
        return detect(source) if signals.separator is None else reader_named("delimited")
    try:
        return reader_named(signals.reader)
    except ReaderError as error:
        raise ReaderError(f"run.toml: signals.reader of {signals.file}: {error}") from None


def _gather(gathered: _Gathered, table: ReadTable, signals: SignalFile) -> None:
    gathered.headers[signals.file] = table.header
    gathered.notes += [f"{signals.file}: {note}" for note in table.notes]
    meanings = _meanings(table, signals)
    length = len(next(iter(gathered.columns.values()))) if gathered.columns else None
    for column in table.columns:
        if length is not None and len(column.values) != length:
            raise ReaderError(
                f"{signals.file}: found {len(column.values)} rows where the files before have {length}; "
                "expected one row a sample in every file; merge them on one time base first"
            )
        for name, source in meanings.get(column.name, []):
            values = column_in_si(column, source, name, SIGNALS[name].kind, signals.file)
            if name in gathered.columns:
                _refuse_difference(name, gathered.columns[name], values, signals.file)
            gathered.columns[name] = values
        if column.name not in meanings:
            gathered.extras[_free_name(column.name, gathered.extras)] = ExtraColumn(column.values, column.unit)


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


def _meanings(table: ReadTable, signals: SignalFile) -> Meanings:
    """Say for each column by name which signals it is: by the manifest's word, else by the format's or its own name."""
    meanings: Meanings = {}
    for name, source in signals.columns.items():
        meanings.setdefault(find_column(table, source.column, name, signals.file).name, []).append((name, source))
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
            f"{signals.file}: found the columns {names}, none with a known meaning; expected to be told; "
            "map signals to columns under [signals.columns] in run.toml"
        )
    return meanings


def _usable(column: ReadColumn, signal: SignalName) -> bool:
    """Tell whether a column may be taken by its name alone: numbers, with a unit where one is needed."""
    return column.first_bad is None and (column.unit is not None or SIGNALS[signal].unit == "1")


def _by_own_name(name: str) -> SignalName | None:
    wanted = bare_name(name).lower().replace(" ", "_")
    return next((signal for signal in SIGNALS if signal == wanted), None)


def _complete(columns: dict[SignalName, Column], origins: dict[SignalName, Origin], manifest: RunManifest) -> None:
    complete_axes(columns, origins, manifest)
    if "friction_coefficient" in columns or "friction_force" not in columns:
        return
    measured = "normal_force" in columns
    force = columns["normal_force"] if measured else np.asarray(manifest.conditions.normal_load.value)
    with np.errstate(divide="ignore", invalid="ignore"):
        mu = columns["friction_force"] / force
    columns["friction_coefficient"] = np.where(np.isfinite(mu), mu, np.nan)
    origins["friction_coefficient"] = "derived from measured load" if measured else "derived from nominal load"

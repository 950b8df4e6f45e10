"""The one place where what readers found becomes a run: named, in SI, completed, with its origins."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ReaderError
from tribopipe.documents.manifest import RunManifest, SignalFile, is_described, manifest_path, read_manifest
from tribopipe.documents.signals import SIGNALS, SignalName
from tribopipe.evaluation.derived_columns import derive_missing
from tribopipe.readers.column_mapping import (
    Arms,
    Meanings,
    Part,
    doubts_on,
    hints_of,
    meanings_in,
    notes_on,
    part_of,
    read_source,
    spoken,
)
from tribopipe.readers.column_meanings import definitions_note
from tribopipe.readers.long_runs import Condensed, LongRun, long_run
from tribopipe.readers.profiles import read_profiles
from tribopipe.readers.reader import Reader, detect, reader_named
from tribopipe.readers.steps import Steps
from tribopipe.readers.table_parts import refuse_sheet
from tribopipe.results.run import ExtraColumn, Origin, RawRun, Recording, SourceFile


@dataclass
class _Gathered:
    """Columns of all files so far."""

    columns: dict[SignalName, Column] = field(default_factory=dict)
    extras: dict[str, ExtraColumn] = field(default_factory=dict)
    headers: dict[str, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    unused: list[str] = field(default_factory=list)
    earlier_steps: set[int] = field(default_factory=set)

    @property
    def length(self) -> int | None:
        """Number of samples; none before the first file."""
        return next((len(values) for values in self.columns.values()), None)


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
    long, recording = long_run(manifest, folder), None
    if long is None:
        _read_whole(manifest, folder, sources, gathered)
    else:
        recording = _read_long(long, manifest, sources, gathered)
    origins: dict[SignalName, Origin] = dict.fromkeys(gathered.columns, "measured")
    derive_missing(gathered.columns, origins, manifest)
    ordered = {name: gathered.columns[name] for name in SIGNALS if name in gathered.columns}
    profiles = read_profiles(manifest, folder, sources, gathered.headers, gathered.notes)
    return RawRun(
        manifest=manifest,
        columns=ordered,
        origins=origins,
        extras=gathered.extras,
        headers=gathered.headers,
        sources=tuple(sources),
        notes=tuple(gathered.notes),
        unused=tuple(gathered.unused),
        earlier_steps=tuple(sorted(gathered.earlier_steps)),
        profiles=profiles,
        recording=recording,
    )


def _read_whole(manifest: RunManifest, folder: Path, sources: list[SourceFile], gathered: _Gathered) -> None:
    for signals in manifest.signals:
        reader = _named_reader(signals, folder, sources)
        parts, arms = [], Arms.of(manifest)
        for name in signals.names:
            sources.append(read_source(folder, name))
            # Consecutive files are of one format, which the first may show better than a short one.
            reader = reader or detect(sources[-1], holds="signals")
            parts.append(_read_part(gathered, sources[-1], reader, signals, arms))
        _add(gathered, _joined(signals.names, parts, gathered.notes), spoken(signals.names))


def _read_long(run: LongRun, manifest: RunManifest, sources: list[SourceFile], gathered: _Gathered) -> Recording | None:
    """Read signal files that are too long to be held; return what was recorded where they come to means."""
    condensed: list[list[Condensed]] = []
    for number, signals in enumerate(manifest.signals):
        condensed.append(run.condensed(number))
        for one in condensed[-1]:
            sources.append(one.source)
            gathered.headers[one.source.name] = one.header
            gathered.notes += one.notes
            gathered.unused += one.unused
            gathered.earlier_steps |= one.earlier_steps
        parts = [one.part for one in condensed[-1]]
        _add(gathered, _joined(signals.names, parts, gathered.notes), spoken(signals.names))
    return run.recording(condensed[0])


def _named_reader(signals: SignalFile, folder: Path, sources: list[SourceFile]) -> Reader | None:
    """Return the reader that the manifest names, whose description joins the sources where it is a file of the run.

    None where it is to be found by the content; a separator named means delimited text.
    """
    if signals.reader is None:
        return None if signals.separator is None else reader_named("delimited")
    if is_described(signals.reader):
        from tribopipe.readers.toml_reader import reader_in

        return reader_in(folder, signals.reader, sources, "signals.reader")
    try:
        return reader_named(signals.reader)
    except ReaderError as error:
        raise ReaderError(f"run.toml: signals.reader of {signals.names[0]}: {error}") from None


def _read_part(gathered: _Gathered, source: SourceFile, reader: Reader, signals: SignalFile, arms: Arms) -> Part:
    """Read one file: its signals in SI, and what no signal is made of; of the steps that run.toml chooses."""
    refuse_sheet(signals.sheet, reader, source.name)
    table = reader.read(source, hints_of(signals))
    meanings = meanings_in(table, signals, source.name)
    gathered.headers[source.name] = table.header
    gathered.notes += notes_on(table, meanings, source.name, arms)
    gathered.unused += doubts_on(table, signals, source.name)
    definitions = definitions_note(table.columns, _taken_for("friction_coefficient", meanings))
    gathered.notes += [f"{source.name}: {definitions}"] if definitions else []
    steps = Steps(signals, source.name)
    part = steps.chosen(part_of(table, meanings, source.name, arms=arms), table.line_of)
    steps.refuse_missing()
    gathered.earlier_steps |= steps.earlier
    return part


def _taken_for(signal: SignalName, meanings: Meanings) -> str | None:
    """Name the column that is taken for a signal."""
    return next((name for name, meant in meanings.items() if any(one == signal for one, _ in meant)), None)


def _joined(names: Sequence[str], parts: Sequence[Part], notes: list[str]) -> Part:
    """Put the rows of consecutive files one after the other, and state from which file each row came."""
    first = parts[0]
    if len(parts) == 1:
        return first
    for name, part in zip(names, parts, strict=True):
        if part.columns.keys() != first.columns.keys():
            raise ReaderError(
                f"{name}: found the signals {', '.join(part.columns)}, but {', '.join(first.columns)} in "
                f"{names[0]}; expected the same signals in all consecutive files of a test; map them under "
                "[signals.columns] in run.toml, or remove the file that belongs to a different test"
            )
    extras = {
        label: ExtraColumn(np.concatenate([part.extras[label].values for part in parts]), extra.unit)
        for label, extra in first.extras.items()
        if all(_alike(part.extras.get(label), extra) for part in parts)
    }
    others = dict.fromkeys(label for part in parts for label in part.extras if label not in extras)
    if others:
        labels = ", ".join(map(repr, others))
        notes.append(f"{spoken(names)}: columns omitted, since not all files contain them in the same unit: {labels}")
    rows = [len(next(iter(part.columns.values()))) for part in parts]
    extras[_free_name("file", extras)] = ExtraColumn(np.repeat(np.arange(1.0, len(parts) + 1), rows), "1")
    return Part({name: np.concatenate([part.columns[name] for part in parts]) for name in first.columns}, extras)


def _alike(one: ExtraColumn | None, other: ExtraColumn) -> bool:
    return one is not None and one.unit == other.unit and one.values.dtype == other.values.dtype


def _add(gathered: _Gathered, part: Part, file: str) -> None:
    """Add the columns of a file, or several, to those before, sample by sample."""
    found, length = len(next(iter(part.columns.values()))), gathered.length
    if length is not None and found != length:
        raise ReaderError(
            f"{file}: found {found:,} rows, but {length:,} in the previous files; expected one row per sample in "
            "every file; first merge the files on a common time base"
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
            f"{file}: found values of {name} that differ from those in the previous files, first at sample "
            f"{different[0] + 1}; expected each signal once, or the same values in every file; map it in one file "
            "only, or first merge the files on a common time base"
        )


def _free_name(name: str, taken: Mapping[str, Any]) -> str:
    return name if name not in taken else _free_name(f"{name} (again)", taken)

"""Runs whose signal files are longer than memory should hold: means of their samples, and each sample again when asked.

The means take the place of the samples in all that follows; what was recorded is parsed a second time where it is
archived. No file is held whole, and no temporary one is written.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column
from tribopipe.base.files import pieces_of
from tribopipe.documents.manifest import RunManifest, SignalFile
from tribopipe.documents.signals import SignalName
from tribopipe.readers import long_text
from tribopipe.readers.block_means import Means, Places, samples_in_a_mean
from tribopipe.readers.column_mapping import (
    NO_ARMS,
    Arms,
    Meanings,
    Part,
    doubts_on,
    hints_of,
    meanings_in,
    notes_on,
    part_of,
)
from tribopipe.readers.columns import with_file
from tribopipe.readers.fields import together
from tribopipe.readers.long_text import LongText, OtherWords, Words, changed
from tribopipe.readers.reader import ReadColumn, ReadTable
from tribopipe.readers.registry import detect
from tribopipe.readers.steps import Steps
from tribopipe.results.run import ExtraColumn, Recording, SourceFile, UnheldSource


class _Rows(NamedTuple):
    """Some rows of a file as they stand in it, and as they are understood."""

    table: ReadTable
    meanings: Meanings
    part: Part


class Condensed(NamedTuple):
    """What a long file comes to."""

    source: UnheldSource
    part: Part
    """Means of its samples."""
    starts: Places
    """Number of the first sample of each, from 0."""
    rows: int
    """Samples in the file."""
    header: str
    notes: tuple[str, ...]
    unused: list[str]
    """Columns that seem to be signals and are not used."""


@dataclass
class _Seen:
    """What a person should know of the blocks of a file so far."""

    notes: dict[str, None] = field(default_factory=dict)
    columns: list[ReadColumn] = field(default_factory=list)
    """Those of the first block, with the placeholders of all."""

    def add(self, table: ReadTable) -> None:
        """Add a block."""
        self.notes |= dict.fromkeys(table.notes)
        before = self.columns or table.columns
        self.columns = [
            replace(first, placeholders=together([first, column] if first is not column else [first]))
            for first, column in zip(before, table.columns, strict=True)
        ]

    def table(self) -> ReadTable:
        """Return the first block as one with the notes and placeholders of all."""
        return ReadTable(tuple(self.columns), notes=tuple(self.notes))


@dataclass
class _LongFile:
    text: LongText
    signals: SignalFile
    arms: Arms = NO_ARMS
    words: Words = field(default_factory=dict)
    """Columns that were found to hold words."""

    def rows(self) -> Iterator[_Rows]:
        """Give the rows block by block. Raises ``OtherWords`` where a column that began with numbers has words."""
        meanings: Meanings = {}
        before, name = 0, self.text.source.name
        steps = Steps(self.signals, name)
        for table in self.text.tables(self.words):
            meanings = meanings or meanings_in(table, self.signals, name)
            part = steps.chosen(part_of(table, meanings, name, before, self.arms), table.line_of)
            before += len(table.columns[0].values)
            if len(next(iter(part.columns.values()))):
                yield _Rows(table, meanings, part)
        steps.refuse_missing()

    def beginning(self) -> dict[SignalName, Column]:
        """Return the signals of the first block."""
        return next(self.rows()).part.columns

    def condensed(self, samples: int) -> Condensed:
        """Read the file whole, and keep means of so many samples of it."""
        while True:
            try:
                return self._condensed(samples)
            except OtherWords as other:
                self.words = other.found

    def _condensed(self, samples: int) -> Condensed:
        means, seen = Means(samples), _Seen()
        every = self.rows()
        first = next(every)
        for table, _, part in chain([first], every):
            means.add(dict(part.columns) | dict(enumerate(extra.values for extra in part.extras.values())))
            seen.add(table)
        columns, starts = means.finish()
        extras = {
            label: ExtraColumn(columns[number], extra.unit)
            for number, (label, extra) in enumerate(first.part.extras.items())
            if label not in self.text.unnamed or not _is_empty(columns[number])
        }
        kept = Part({name: columns[name] for name in first.part.columns}, extras)
        name, whole = self.text.source.name, seen.table()
        notes, unused = notes_on(whole, first.meanings, name, self.arms), doubts_on(whole, self.signals, name)
        return Condensed(self.text.source, kept, starts, means.rows, first.table.header, tuple(notes), unused)


def _is_empty(column: NDArray[Any]) -> bool:
    return column.dtype != object and bool(np.all(np.isnan(column)))


@dataclass(frozen=True)
class LongRun:
    """The signal files of a run that is too long to be held, group by group as run.toml has them."""

    groups: Sequence[Sequence[_LongFile]]
    samples: int
    """Samples in a mean."""

    def condensed(self, group: int) -> list[Condensed]:
        """Read the files of a group, and keep means of what they hold."""
        return [file.condensed(self.samples) for file in self.groups[group]]

    def recording(self, condensed: Sequence[Condensed]) -> Recording | None:
        """Return what was recorded, by what the first group came to; none where every sample is held."""
        if self.samples == 1:
            return None
        before = np.cumsum([0, *(one.rows for one in condensed)])
        starts = [one.starts + rows for one, rows in zip(condensed, before.tolist(), strict=False)]
        return Recording(int(before[-1]), self.samples, np.concatenate(starts), partial(_recorded, self.groups))


def _recorded(groups: Sequence[Sequence[_LongFile]]) -> Iterator[Mapping[SignalName, Column]]:
    """Give every sample in SI, block by block; of a signal that several groups have, those of the first."""
    taken: set[SignalName] = set()
    for group in groups:
        seen: set[SignalName] = set()
        for part in chain.from_iterable(map(_same_rows, group)):
            seen.update(part.columns)
            yield {name: values for name, values in part.columns.items() if name not in taken}
        taken |= seen


def _same_rows(file: _LongFile) -> Iterator[Part]:
    """Give the rows of a file that was read before. Raises ``ReaderError`` where it is another by now."""
    try:
        for rows in file.rows():
            yield rows.part
    except OtherWords:
        raise changed(file.text.source.name) from None


def long_run(manifest: RunManifest, folder: Path) -> LongRun | None:
    """Open the signal files of a run that is too long to be held; none where it is to be read whole.

    Raises ``ReaderError`` where a file cannot be read, or is no table.
    """
    if all(_bytes(signals, folder) <= long_text.LARGE for signals in manifest.signals):
        return None
    groups: list[list[_LongFile]] = []
    for signals in manifest.signals:
        group = _opened(signals, folder, Arms.of(manifest))
        if group is None:
            return None
        groups.append(group)
    rows = max(sum(file.text.most_rows for file in group) for group in groups)
    beginning = {name: values for group in groups for name, values in group[0].beginning().items()}
    return LongRun(groups, samples_in_a_mean(rows, manifest, beginning))


def _bytes(signals: SignalFile, folder: Path) -> int:
    """Return how long files are together; those that are not there are missed when they are read."""
    size = 0
    for name in signals.names:
        with suppress(OSError):
            size += (folder / name).stat().st_size
    return size


def _opened(signals: SignalFile, folder: Path, arms: Arms) -> list[_LongFile] | None:
    """Go through files once each; none where one cannot be read block by block."""
    named = signals.reader or (long_text.READER if signals.separator is not None else None)
    if (named or with_file(folder, signals.names[0], _detected)) != long_text.READER:
        return None
    files = []
    for name in signals.names:
        text = with_file(folder, name, partial(long_text.long_text, name=name, hints=hints_of(signals)))
        if text is None:
            return None
        files.append(_LongFile(text, signals, arms))
    return files


def _detected(path: Path) -> str:
    head = next(pieces_of(path, long_text.HEAD), b"")
    return detect(SourceFile(path.name, head), holds="signals").name

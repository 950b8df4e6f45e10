"""Runs whose files are longer than memory should hold: means of their samples, and each sample again on request.

The means take the place of the samples in all that follows; what was recorded is parsed a second time where it is
archived. No file is held whole, and no temporary one is written.

Least squares on means of n samples each is least squares on what the samples state about a curve that bends little
within n. So that restarts and faults of an axis stay what they are, the samples on both sides of a place where one
goes back stand alone, and so do the first and the last of all. Missing samples are left out of means, and so are error
codes: a thousand times what is usual, in the midst of samples that are not.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import chain, pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column
from tribopipe.base.files import pieces_of
from tribopipe.documents.manifest import RunManifest, SignalFile
from tribopipe.documents.signals import AXES, SignalName
from tribopipe.evaluation.preprocessing.workbench import fewer
from tribopipe.readers import long_text
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
    with_file,
)
from tribopipe.readers.long_text import LongText, OtherWords, Words, changed
from tribopipe.readers.number_fields import together
from tribopipe.readers.reader import ReadColumn, ReadTable, detect
from tribopipe.readers.steps import Steps
from tribopipe.results.run import ExtraColumn, Recording, SourceFile, UnheldSource

MOST = 1_000_000
"""Means that stand for a recording, about."""
_IN_A_STROKE = 20
"""Samples that a stroke of a test there and back is left with at least."""
_FAR_OFF = 1000.0
"""An error code is so many times as large as nine tenths of the samples about it."""

Places = NDArray[np.int64]
Name = str | int
Block = Mapping[Name, NDArray[Any]]
"""Columns of one length, signals by their names and others by number: numbers, of which NaN are missing, or texts."""


def samples_in_a_mean(rows: int, manifest: RunManifest, first: Mapping[SignalName, Column]) -> int:
    """Return how many of so many samples to take the mean of, by the ``first`` of them: 1 to hold them all."""
    wanted = max(1, -(-rows // MOST))
    if manifest.conditions.stroke is None:
        return wanted
    return max(1, min(wanted, _samples_in_a_stroke(manifest, first) // _IN_A_STROKE))


def _samples_in_a_stroke(manifest: RunManifest, first: Mapping[SignalName, Column]) -> int:
    """Return how many samples one stroke has; 0 where nothing shows."""
    stroke, speed = manifest.conditions.stroke, manifest.conditions.nominal_speed
    if stroke is None:
        return 0
    if "sliding_distance" in first:
        length, axis = stroke.value, first["sliding_distance"]
    elif "time" in first and speed is not None:
        length, axis = stroke.value / speed.value, first["time"]
    else:
        return 0
    steps = np.diff(axis)
    growing = steps[steps > 0]
    return round(length / float(np.median(growing))) if len(growing) else 0


class Means:
    """Means of columns that come in blocks: the same whatever the blocks are, but for what is an error code in one."""

    rows: int
    """Samples that were added, once all are."""

    def __init__(self, samples: int) -> None:
        self._samples = samples
        self._rows = 0
        self._carried: dict[Name, NDArray[Any]] = {}
        self._first_alone = True
        self._means: dict[Name, list[NDArray[Any]]] = {}
        self._starts: list[Places] = [np.empty(0, np.int64)]

    def add(self, block: Mapping[Any, NDArray[Any]]) -> None:
        """Add a block of samples, a ``Block``; those since the last whole mean wait for more."""
        if not self._carried:
            self._carried = {name: values[:0] for name, values in block.items()}
        joined = {name: np.concatenate([self._carried[name], values]) for name, values in block.items()}
        starts, alone = self._places(joined)
        last = int(starts[-1])
        self._take(joined, starts[:-1], last)
        self._carried = {name: values[last:].copy() for name, values in joined.items()}
        self._first_alone = last + 1 in alone
        self._rows += last

    def finish(self) -> tuple[dict[Name, NDArray[Any]], Places]:
        """Return the means of each column, and how many samples were added before each of them."""
        length = len(next(iter(self._carried.values())))
        self._take(self._carried, np.unique([0, length - 1]), length)
        self.rows = self._rows + length
        found = {name: np.concatenate(self._means.pop(name)) for name in list(self._means)}  # one after the other freed
        return found, np.concatenate(self._starts)

    def _places(self, block: Block) -> tuple[Places, set[int]]:
        """Return where means begin, and where one has to, whatever stands before it."""
        length = len(next(iter(block.values())))
        forced = {0, 1} if self._first_alone else {0}
        for name in AXES:
            if name in block:
                falls = np.flatnonzero(block[name][1:] < block[name][:-1]) + 1
                forced.update(falls.tolist(), (falls - 1).tolist(), (falls + 1).tolist())
        bounds = [*sorted(place for place in forced if place < length), length]
        starts = [np.arange(start, end, self._samples) for start, end in pairwise(bounds)]
        return np.concatenate(starts), forced

    def _take(self, block: Block, starts: Places, end: int) -> None:
        if not len(starts):
            return
        counts = np.diff(starts, append=end)
        self._starts.append(starts + self._rows)
        for name, values in block.items():
            part = values[:end]
            mean = part[starts] if part.dtype == object else _means(part, starts, counts, axis=name in AXES)
            self._means.setdefault(name, []).append(mean)


def _means(values: Column, starts: Places, counts: Places, *, axis: bool) -> Column:
    """Return the mean of each stretch; of an axis that of all its samples, missing where one is."""
    if len(starts) == len(values):
        return values.copy()
    if axis:
        return np.asarray(np.add.reduceat(values, starts) / counts)
    known = _without_codes(values, starts, counts)
    seen = np.isfinite(known)
    sums, found = np.add.reduceat(np.where(seen, known, 0.0), starts), np.add.reduceat(seen, starts, dtype=np.int64)
    means = np.divide(sums, found, out=np.full(len(starts), np.nan), where=found > 0)
    # What does not change has itself as its mean, to the last digit.
    return np.asarray(np.clip(means, np.fmin.reduceat(known, starts), np.fmax.reduceat(known, starts)))


def _without_codes(values: Column, starts: Places, counts: Places) -> Column:
    """Make error codes missing. Where all samples of a stretch are so large, a level may have changed: they stay."""
    size = np.abs(values)
    some = fewer(size)
    limit = _FAR_OFF * float(np.percentile(some, 90)) if len(some) else 0.0
    beyond = size > limit
    if not limit or not np.any(beyond):
        return values
    mixed = np.add.reduceat(beyond, starts, dtype=np.int64) < counts
    return np.where(beyond & np.repeat(mixed, counts), np.nan, values)


class _Rows(NamedTuple):
    """Some rows of a file as they stand in it, and as they are understood."""

    table: ReadTable
    meanings: Meanings
    part: Part


class Condensed(NamedTuple):
    """Result of reading a long file."""

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
    earlier_steps: set[int]
    """Steps of the file, before the last that run.toml chooses, that it does not choose."""


@dataclass
class _Seen:
    """Notes to the user about the blocks of a file read so far."""

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
    earlier_steps: set[int] = field(default_factory=set)
    """The same, once the rows have been read."""

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
        self.earlier_steps = steps.earlier

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
        header, earlier = first.table.header, self.earlier_steps
        return Condensed(self.text.source, kept, starts, means.rows, header, tuple(notes), unused, earlier)


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

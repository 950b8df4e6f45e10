"""Steps of a test, or tests in one file, that a column numbers: which there are, and the rows of those chosen.

Time either begins again with each step or goes on through all of them. A column of numbers that fits neither is
refused with its line: its rows cannot be distinguished.
"""

import re
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ReaderError, did_you_mean
from tribopipe.documents.manifest import SignalFile
from tribopipe.documents.signals import AXES, SignalName
from tribopipe.readers.column_mapping import Part
from tribopipe.readers.reader import ReadTable
from tribopipe.readers.tables import bare_name
from tribopipe.results.run import ExtraColumn

_NAMES = (
    *("step", "thisstep", "currentstep", "stepno", "stepnumber", "stepid", "schritt", "schrittnr", "etape", "krok"),
    *("paso", "passo", "sequenceid", "sequence", "stage", "recipestep", "segment"),
)
"""Names of step columns in the form of ``_plain``: recorded steps before steps of the recipe."""
_MOST_STEPS = 1000
"""A column of more different numbers counts rows or cycles."""
_SMOOTH = 1.5
"""Sampling intervals within which time goes on from one row to the next."""
_SHORT = 0.1
"""Rows, per row kept, of a step that only approaches and loads the specimens."""
_FEWEST_ROWS = 10
"""Rows before a change of step from which the sampling interval is known."""

LineOf = Callable[[int], int] | None


class Step(NamedTuple):
    """One step: its number, and how many rows it has."""

    number: int
    rows: int


def step_column(columns: Mapping[str, NDArray[Any]]) -> str | None:
    """Return the name of the column that numbers the steps, where a column has such a name and more than one number."""
    named = {name: _NAMES.index(plain) for name in columns if (plain := _plain(name)) in _NAMES}
    return next((name for name in sorted(named, key=lambda name: named[name]) if _counts_steps(columns[name])), None)


def steps_in(table: ReadTable, column: str, file: str) -> list[Step]:
    """Return the steps of a file by the column of a name, in the order of the file.

    Raises ``ReaderError`` with the line where it does not hold whole numbers.
    """
    values = {one.name: one.values for one in table.columns}
    numbers = _numbers(values, column, file, table.line_of)
    found, first, rows = np.unique(numbers, return_index=True, return_counts=True)
    return [Step(int(found[at]), int(rows[at])) for at in np.argsort(first)]


def _plain(name: str) -> str:
    return re.sub(r"[^a-z]", "", bare_name(name).casefold())


def _counts_steps(values: NDArray[Any]) -> bool:
    if values.dtype.kind != "f" or not len(values) or not np.all(np.isfinite(values) & (values == np.round(values))):
        return False
    return 1 < len(np.unique(values)) <= _MOST_STEPS


def _name_among(names: Collection[str], wanted: str, file: str) -> str:
    """Find a column by its name, with or without its unit. Raises ``ReaderError`` where there is none."""
    found = [name for name in names if wanted in (name, bare_name(name))]
    if not found:
        raise ReaderError(
            f"{file}: found no column {wanted!r} with step numbers; expected this column in the header; "
            f"{did_you_mean(wanted, list(names))}"
        )
    return found[0]


def _numbers(columns: Mapping[str, NDArray[Any]], name: str, file: str, line_of: LineOf) -> Column:
    """Return the numbers of steps. Raises ``ReaderError`` with the line where one is none."""
    values = columns[name]
    if values.dtype.kind == "f":
        whole = np.isfinite(values) & (values == np.round(values))
    else:
        whole = np.array([re.fullmatch(r"[+-]?\d+(?:[.,]0*)?", str(value)) is not None for value in values], dtype=bool)
    if not np.all(whole):
        row = int(np.flatnonzero(~whole)[0])
        found = repr(str(values[row])) if str(values[row]) else "an empty field"
        raise ReaderError(
            f"{file}, {_place(row, line_of)}, column {name!r}: found {found}; expected a step number; "
            "correct that line, or specify another column"
        )
    return np.asarray(values, dtype=float)


def _place(row: int, line_of: LineOf) -> str:
    return f"row {row + 1} of the table" if line_of is None else f"line {line_of(row)}"


@dataclass(frozen=True)
class _Row:
    """The last row of what was read before."""

    number: float
    axes: Mapping[SignalName, float]
    starts: Mapping[SignalName, float]
    """Origin of each axis from there on."""


class _Change(NamedTuple):
    """End of a step after which time continues: place, numbers of both steps, and times."""

    place: str
    numbers: tuple[float, float]
    times: tuple[float, float]


@dataclass
class Steps:
    """Reads the steps of one file, part after part, and keeps the rows of those that run.toml chooses.

    Time, rotations and sliding distance of what is kept are counted from its start, whatever the file counts from.
    """

    signals: SignalFile
    file: str
    seen: set[int] = field(default_factory=set)
    """Numbers of all steps that were read."""
    _before: Counter[int] = field(default_factory=Counter)
    """Rows of the steps that are left out before the last row kept."""
    _left_out: Counter[int] = field(default_factory=Counter)
    """Rows left out since then."""
    _kept: int = 0
    """Rows kept."""
    _last: _Row | None = None
    _anew: str | None = None
    """Place at which time began again with a step."""
    _on: _Change | None = None
    """The first change of step at which time went on."""

    def chosen(self, part: Part, line_of: LineOf) -> Part:
        """Return the rows of the steps chosen, or all. Raises ``ReaderError`` where the steps contradict the time."""
        values = {name: extra.values for name, extra in part.extras.items()}
        name = self._column(values)
        if name is None:
            return part
        numbers = _numbers(values, name, self.file, line_of)
        self.seen.update(map(int, np.unique(numbers)))
        axes = {axis: part.columns[axis] for axis in AXES if axis in part.columns}
        last, carried = self._last, int(self._last is not None)
        if last is not None:
            numbers = np.concatenate([[last.number], numbers])
            axes = {axis: np.concatenate([[last.axes[axis]], one]) for axis, one in axes.items()}

        def place(row: int) -> str:
            return _place(row - carried, line_of)

        if "time" in axes:
            self._refuse_contradiction(numbers, axes["time"], place)
        if not self.signals.steps:
            self._last = _Row(float(numbers[-1]), {axis: float(one[-1]) for axis, one in axes.items()}, {})
            return part
        kept = np.isin(numbers, self.signals.steps)
        self._note_earlier(numbers[carried:], kept[carried:])
        starts = {axis: _starts(one, kept, last.starts[axis] if last else 0.0) for axis, one in axes.items()}
        ends, begun = ({axis: float(one[axis][-1]) for axis in axes} for one in (axes, starts))
        self._last = _Row(float(numbers[-1]), ends, begun)
        counted = {axis: (one - starts[axis])[carried:] for axis, one in axes.items()}
        return _rows(Part({**part.columns, **counted}, part.extras), kept[carried:])

    @property
    def earlier(self) -> set[int]:
        """Numbers of the steps left out before the last row kept, without those too short for much wear."""
        return {number for number, rows in self._before.items() if rows >= _SHORT * self._kept}

    def _note_earlier(self, numbers: Column, kept: NDArray[np.bool_]) -> None:
        self._kept += int(np.count_nonzero(kept))
        end = int(np.flatnonzero(kept)[-1]) if np.any(kept) else 0
        self._left_out.update(numbers[:end][~kept[:end]].astype(int).tolist())
        if np.any(kept):
            self._before, self._left_out = self._before + self._left_out, Counter()
        self._left_out.update(numbers[end:][~kept[end:]].astype(int).tolist())

    def refuse_missing(self) -> None:
        """Raise ``ReaderError`` where a step that run.toml chooses is not in the file."""
        missing = [step for step in self.signals.steps if step not in self.seen]
        if missing:
            listed = ", ".join(map(str, sorted(self.seen)))
            raise ReaderError(
                f"{self.file}: found the steps {listed}; expected step {missing[0]}, which is selected in "
                "run.toml; correct signals.steps"
            )

    def _column(self, values: Mapping[str, NDArray[Any]]) -> str | None:
        """Name the column that numbers the steps. Raises ``ReaderError`` where steps are chosen and none does."""
        if self.signals.step_column is not None:
            return _name_among(values, self.signals.step_column, self.file)
        name = step_column(values) or next((name for name in values if self.seen and _plain(name) in _NAMES), None)
        if name is None and self.signals.steps:
            known = next((one for one in values if _plain(one) in _NAMES and values[one].dtype.kind == "f"), None)
            if known is None:
                raise ReaderError(
                    f"{self.file}: found no column with step numbers; expected one, since run.toml selects steps; "
                    'specify step_column = "Step", or delete the key steps'
                )
            return known
        return name

    def _refuse_contradiction(self, numbers: Column, time: Column, place: Callable[[int], str]) -> None:
        """Refuse time that begins again within a step, or with some steps and not with others."""
        known = np.flatnonzero(np.isfinite(time))
        time, numbers = time[known], numbers[known]
        if len(time) < 2:
            return
        fall, change = np.diff(time) < 0, np.diff(numbers) != 0
        if np.any(change) or len(self.seen) > 1:
            self._refuse_falls(np.flatnonzero(fall & ~_beside(change)) + 1, known, time, numbers, place)
        if self._anew is None and np.any(fall):
            self._anew = place(int(known[np.argmax(fall) + 1]))
        going_on = np.flatnonzero(change & ~_beside(fall)) + 1
        smooth = next((row for row in going_on.tolist() if _goes_on(time, row)), None)
        if self._on is None and smooth is not None:
            both = slice(smooth - 1, smooth + 1)
            self._on = _Change(place(int(known[smooth])), tuple(numbers[both]), tuple(time[both]))
        if self._anew is not None and self._on is not None:
            before, after = self._on.numbers
            raise ReaderError(
                f"{self.file}, {self._on.place}: found step {after:g} after step {before:g}, but time continues from "
                f"{self._on.times[0]:g} s to {self._on.times[1]:g} s; expected time to restart with each step, as at "
                f"{self._anew}; correct the steps, or export the test again"
            )

    def _refuse_falls(
        self,
        rows: NDArray[np.intp],
        known: NDArray[np.intp],
        time: Column,
        numbers: Column,
        place: Callable[[int], str],
    ) -> None:
        if len(rows):
            row = int(rows[0])
            raise ReaderError(
                f"{self.file}, {place(int(known[row]))}: found a time of {time[row]:g} s after {time[row - 1]:g} s "
                "within step "
                f"{numbers[row]:g}; expected time to increase within a step; correct the rows, or export the test again"
            )


def _beside(flags: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Extend flags to both neighbors: a channel may be a row late where a step begins."""
    near = flags.copy()
    near[1:] |= flags[:-1]
    near[:-1] |= flags[1:]
    return near


def _goes_on(time: Column, row: int) -> bool:
    """Return whether time goes on smoothly to a row, by the sampling interval before it."""
    if row < _FEWEST_ROWS:
        return False
    interval = float(np.median(np.diff(time[row - _FEWEST_ROWS : row])))
    return bool(time[row] - time[row - 1] <= _SMOOTH * interval)


def _starts(axis: Column, kept: NDArray[np.bool_], first: float) -> Column:
    """Return what an axis is counted from at each row: its value before the first row of each stretch that is kept.

    Zero where the axis begins again there or later; ``first`` at the very first row.
    """
    starts = np.zeros(len(axis))
    edges = np.flatnonzero(np.diff(kept, prepend=False, append=False)).reshape(-1, 2)
    for begin, end in edges.tolist():
        before = axis[:begin][np.isfinite(axis[:begin])]
        start = float(before[-1]) if len(before) else first
        with np.errstate(invalid="ignore"):
            below = np.flatnonzero(axis[begin:end] < start)
        starts[begin : begin + int(below[0]) if len(below) else end] = start
    return starts


def _rows(part: Part, kept: NDArray[np.bool_]) -> Part:
    extras = {name: ExtraColumn(extra.values[kept], extra.unit) for name, extra in part.extras.items()}
    return Part({name: values[kept] for name, values in part.columns.items()}, extras)


def spoken_steps(steps: Sequence[Step]) -> str:
    """Name steps for people: "4, 7, 10 and 13", or "1, 2, 3 … 40"."""
    numbers = [str(step.number) for step in steps]
    if len(numbers) > 8:
        return f"{', '.join(numbers[:3])} … {numbers[-1]}"
    return " and ".join([", ".join(numbers[:-1]), numbers[-1]] if len(numbers) > 1 else numbers)

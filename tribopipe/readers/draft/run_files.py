"""Which files, sheets and steps a run is made of, and which profiles were measured on its specimens.

Files are consecutive, or hold further channels over the same time base; a file may hold several tests, one in each
sheet of a workbook or in each step that a column numbers.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ManifestError, ReaderError, did_you_mean
from tribopipe.base.files import file_order
from tribopipe.documents.contact_kinds import contacts
from tribopipe.documents.manifest import SignalFile
from tribopipe.readers.column_mapping import Part, find_column
from tribopipe.readers.draft.known_values import Known, run_key, shared_key, toml
from tribopipe.readers.export_files import Export, chosen_reader, open_export, read_export
from tribopipe.readers.formats.matlab import MatlabReader
from tribopipe.readers.formats.workbook import WorkbookReader
from tribopipe.readers.profiles import tells_axes
from tribopipe.readers.reader import Hints, ReadColumn, detect
from tribopipe.readers.steps import Step, Steps, spoken_steps, step_column, steps_in
from tribopipe.results.run import ExtraColumn


@dataclass(frozen=True)
class Group:
    """Consecutive files of one format and the same columns: one [[signals]] of run.toml."""

    exports: tuple[Export, ...]

    @property
    def first(self) -> Export:
        """The file with which the test starts."""
        return self.exports[0]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the files in the order of the test."""
        return tuple(export.name for export in self.exports)

    @property
    def rows(self) -> int:
        """Rows of all files."""
        return sum(export.rows for export in self.exports)

    @property
    def clocks_begin_anew(self) -> bool:
        """Whether time falls back from each file to the next, as it does between tests too."""
        return len(self._spans) > 1 and all(later[0] < before[1] for before, later in pairwise(self._spans))

    @property
    def order_of_times(self) -> tuple[str, ...] | None:
        """Names in the order of the recorded times; none where these overlap, or are in the order of the test."""
        spans = sorted(zip(self._spans, self.names, strict=False))
        names = tuple(name for _, name in spans)
        overlap = any(later[0] < before[1] for (before, _), (later, _) in pairwise(spans))
        return None if overlap or names == self.names or not spans else names

    @cached_property
    def _spans(self) -> list[tuple[float, float]]:
        """First and last time of each file; none where a file has no time."""
        times = [found[np.isfinite(found)] for export in self.exports if (found := _time(export)) is not None]
        known = len(times) == len(self.exports) and all(map(len, times))
        return [(float(time[0]), float(time[-1])) for time in times] if known else []

    def __str__(self) -> str:
        return self.names[0] if len(self.names) == 1 else f"{self.names[0]} … {self.names[-1]}"


def grouped(exports: Sequence[Export]) -> list[Group]:
    """Put consecutive files together, in natural order.

    Raises ``ReaderError`` where what is left does not share its rows, so that it cannot be of one test.
    """
    alike: dict[object, list[Export]] = {}
    for export in exports:
        columns = tuple((column.name, column.unit) for column in export.table.columns)
        alike.setdefault((export.reader.name, columns), []).append(export)
    groups = [Group(tuple(sorted(found, key=lambda export: file_order(export.name)))) for found in alike.values()]
    for group in groups[1:]:
        _refuse_another_base(groups[0], group)
    return groups


def _refuse_another_base(first: Group, other: Group) -> None:
    if other.rows != first.rows:
        raise ReaderError(
            f"{other}: found {other.rows:,} rows and columns that differ from those of {first}, which has "
            f"{first.rows:,} rows; "
            "expected consecutive files with the same columns, or channels with the same time base and the same "
            "number of rows; create one run per test, or first merge channels of one test on a common time base"
        )
    before, found = _times(first), _times(other)
    if before is None or found is None:
        return
    seen = min(len(before), len(found))  # of long files the beginnings, which need not be as long
    if np.allclose(before[:seen], found[:seen], rtol=1e-9, atol=0, equal_nan=True):
        return
    raise ReaderError(
        f"{other}: found times that differ from those in {first}; expected channels with the same time base; create "
        "one run "
        "per test, or first merge the files on a common time base"
    )


def _times(group: Group) -> Column | None:
    """Give the times of a group in s as far as all files write them so."""
    found = [times for export in group.exports if (times := _time(export)) is not None]
    return np.concatenate(found) if len(found) == len(group.exports) else None


def _time(export: Export) -> Column | None:
    """Give the times of a file in s if it writes them so, as numbers."""
    for column in export.table.columns:
        meaning = export.meanings.get(column.name)
        if column.unit == "s" and meaning and meaning.signal == "time" and column.values.dtype.kind == "f":
            return column.values
    return None


@dataclass(frozen=True)
class StepOfFiles:
    """One step of a test, and the files that hold rows of it."""

    number: int
    column: str
    """Column that numbers the steps."""
    exports: tuple[Export, ...]


def sheets_of(files: Sequence[Path], reader: str | None) -> list[str]:
    """Name the sheets of a workbook that each hold a test. Raises ``ReaderError`` where it is none."""
    if len(files) != 1:
        raise ReaderError(
            f"--each-sheet: found {len(files)} files; expected one workbook; create the runs of each workbook "
            "separately"
        )
    source = open_export(files[0])
    found = detect(source, holds="signals") if reader is None else chosen_reader(reader)
    if not isinstance(found, WorkbookReader | MatlabReader):
        raise ReaderError(
            f"{source.name}: found a file in the format {found.name}; expected a workbook or a MAT-file, since "
            "--each-sheet applies to sheets and structs; remove --each-sheet"
        )
    return found.sheets(source, Hints())


def split_steps(exports: Sequence[Export], column: str) -> list[StepOfFiles]:
    """Return the steps of files by a column that numbers them, in the order in which they come.

    Raises ``ReaderError`` where a file has no such column, or where its steps contradict its time.
    """
    signals = [export for export in exports if export.reader.holds == "signals"]
    if not signals:
        return []
    names = {export.name: find_column(export.table, column, "the steps", export.name).name for export in signals}
    found = {export.name: _steps(export, names[export.name]) for export in signals}
    numbers = dict.fromkeys(step.number for steps in found.values() for step in steps)

    def holds(export: Export, number: int) -> bool:
        return export.name not in found or any(step.number == number for step in found[export.name])

    return [
        StepOfFiles(number, names[signals[0].name], tuple(export for export in exports if holds(export, number)))
        for number in numbers
    ]


def _steps(export: Export, column: str) -> list[Step]:
    """Return the steps of a file. Raises ``ReaderError`` where they contradict its time, or it is too long."""
    if export.most_rows is not None:
        raise ReaderError(
            f"{export.name}: found a file that is too large to be split; expected a file that fits in memory; create "
            "one run folder and enter steps = [1] under [[signals]] in its run.toml"
        )
    steps, time = steps_in(export.table, column, export.name), _column(export, "time")
    if time is not None:
        numbers = next(one.values for one in export.table.columns if one.name == column)
        part = Part({"time": np.asarray(time.values, dtype=float)}, {column: ExtraColumn(numbers)})
        Steps(SignalFile(file=export.name, step_column=column), export.name).chosen(part, export.table.line_of)
    return steps


def _column(export: Export, signal: str) -> ReadColumn | None:
    """Return the column of numbers that is taken for a signal."""
    names = [name for name, meaning in export.meanings.items() if meaning.signal == signal and not meaning.doubt]
    return next((one for one in export.table.columns if one.name in names and one.first_bad is None), None)


def steps_left_together(export: Export) -> str | None:
    """Report that steps of a file are taken as one test; nothing where it has none."""
    name = step_column({column.name: column.values for column in export.table.columns})
    if name is None or export.reader.holds != "signals":
        return None
    steps = steps_in(export.table, name, export.name)
    return (
        f"{export.name}: column {name!r} contains the step numbers {spoken_steps(steps)}; all steps are treated "
        "as one test; if load, speed or track radius differ between steps, create one run per step: tribopipe new "
        f"{export.name} --split {name!r}"
    )


def _bodies() -> list[str]:
    """Name the bodies of all types of tribometer."""
    return list(dict.fromkeys(name for contact in contacts().values() for name in contact.body_names))


class Measured(NamedTuple):
    """A profile, and the body it was measured on."""

    body: str
    export: Export


def read_profile(written: str) -> Measured:
    """Read the profile that "disc=track.txt" names.

    Raises ``ManifestError`` where it names no body, ``ReaderError`` where there is no such file or no reader for it.
    """
    body, equals, file = (part.strip() for part in written.partition("="))
    if not equals or body not in _bodies():
        found = f"no body {body!r}" if equals else "no '='"
        raise ManifestError(
            f"--profile {written}: found {found}; expected a body and its profile file, such as disc=track.txt; "
            f"{did_you_mean(body, _bodies()) if equals else 'specify both'}"
        )
    try:
        return Measured(body, read_export(Path(file), holds="profile"))
    except ReaderError:
        return Measured(body, read_export(Path(file)))  # a table, whose columns somebody has to name


def add_profiles(known: Known, measured: Sequence[Measured]) -> None:
    """Take profiles as post-test measurements. Raises ``ManifestError`` where the tribometer has no such body."""
    for body in dict.fromkeys(one.body for one in measured):
        exports = [one.export for one in measured if one.body == body]
        key, files = f"end_values.{body}_profile", [_named(export) for export in exports]
        untold = [export for export in exports if not tells_axes(export.table)]
        if untold:
            known.doubt(shared_key(key), files, _ask_for_columns(untold[0]))
            continue
        problem = known.take(key, files[0] if len(files) == 1 else files)
        if problem is not None:
            raise ManifestError(f"--profile {body}={exports[0].name}: {problem}")


def which_profile(known: Known, exports: Sequence[Export]) -> None:
    """Note profiles of which nobody has stated what they were measured on."""
    for export in exports:
        known.doubt(
            "end_values.disc_profile", {"file": export.name}, "a profile: of the disc, or of the pin (pin_profile)?"
        )


def profiles_left_open(known: Known) -> list[str]:
    """Report for which profiles run.toml holds but a comment, and why."""
    return [
        f"{run_key(key, known.kind)} is commented out in run.toml: {doubt.why}"
        for key, doubts in known.doubts.items()
        if key.endswith("_profile")
        for doubt in doubts
    ]


def _named(export: Export) -> dict[str, Any]:
    columns = {} if tells_axes(export.table) else {"position": "…", "height": "…"}
    return {"file": export.name} | columns


def _ask_for_columns(export: Export) -> str:
    names = ", ".join(toml(column.name) for column in export.table.columns)
    return f"specify the columns of position and height: {names}"

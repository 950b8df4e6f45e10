"""Several tests in one file: a run of each sheet of a workbook, or of each step that a column numbers."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tribopipe.base.errors import ReaderError
from tribopipe.documents.manifest import SignalFile
from tribopipe.readers.column_mapping import Part
from tribopipe.readers.columns import find_column
from tribopipe.readers.export_files import Export, chosen_reader, open_export
from tribopipe.readers.formats.workbook import WorkbookReader
from tribopipe.readers.reader import Hints, ReadColumn
from tribopipe.readers.registry import detect
from tribopipe.readers.steps import Step, Steps, spoken_steps, step_column, steps_in
from tribopipe.results.run import ExtraColumn


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
            f"--each-sheet: found {len(files)} files; expected one workbook; make the runs of each workbook separately"
        )
    source = open_export(files[0])
    found = detect(source, holds="signals") if reader is None else chosen_reader(reader)
    if not isinstance(found, WorkbookReader):
        raise ReaderError(
            f"{source.name}: found a file of the format {found.name}; expected a workbook, whose sheets --each-sheet "
            "takes; remove --each-sheet"
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
            f"{export.name}: found a file too long to be split at once; expected one that fits in memory; make one run "
            "folder and write steps = [1] under [[signals]] in its run.toml"
        )
    steps, time = steps_in(export.table, column, export.name), _column(export, "time")
    if time is not None:
        numbers = next(one.values for one in export.table.columns if one.name == column)
        part = Part({"time": np.asarray(time.values, dtype=float)}, {column: ExtraColumn(numbers)})
        Steps(SignalFile(file=export.name, step_column=column), export.name).chosen(part, export.table.line_of)
    return steps


def _column(export: Export, signal: str) -> ReadColumn | None:
    """Return the column of numbers that is taken for a signal."""
    names = [name for name, meaning in export.meanings.items() if meaning.signal == signal and not meaning.lacks]
    return next((one for one in export.table.columns if one.name in names and one.first_bad is None), None)


def steps_left_together(export: Export) -> str | None:
    """Report that steps of a file are taken as one test; nothing where it has none."""
    name = step_column({column.name: column.values for column in export.table.columns})
    if name is None or export.reader.holds != "signals":
        return None
    steps = steps_in(export.table, name, export.name)
    return (
        f"{export.name}: column {name!r} numbers the steps {spoken_steps(steps)}, which are treated as one test; if "
        f"load, speed or track differ between steps, make one run per step: tribopipe new {export.name} --split "
        f"{name!r}"
    )

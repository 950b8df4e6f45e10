"""Cases of a sweep: every combination of what is varied, the rows that a case finds, and the file that keeps them.

The file is CSV, with units in its heads.
"""

import csv
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from typing import NamedTuple

from tribopipe.base.errors import ManifestError
from tribopipe.base.files import write_file
from tribopipe.documents.quantity import Quantity
from tribopipe.extras.sweep.subject import Cell, Parameter, Settings, Value
from tribopipe.views.csv_files import csv_lines

FAILED = "failed"


@dataclass(frozen=True)
class Head:
    """A column of numbers or texts."""

    name: str
    unit: str | None = None
    uncertain: bool = False
    """True if each value has a standard uncertainty."""
    written: Mapping[Cell, str] = field(default_factory=dict)
    """Original text of some of its values."""

    @property
    def names(self) -> tuple[str, ...]:
        """Heads in the file: "normal_load [N]", "normal_load uncertainty [N]"."""
        unit = "" if self.unit is None else f" [{self.unit}]"
        return (f"{self.name}{unit}", f"{self.name} uncertainty{unit}") if self.uncertain else (f"{self.name}{unit}",)


@dataclass(frozen=True)
class Row:
    """Result of a case for one body or place."""

    body: str
    outcome: str
    found: Mapping[str, Quantity]
    """Numbers by the names of their columns."""
    why: str = ""
    """Why there are none."""


@dataclass(frozen=True)
class Case:
    """One task of a sweep."""

    labels: Mapping[str, Cell]
    """Values that distinguish the case, with column names as keys."""
    fingerprint: str
    """Fingerprint of all sources of its rows, including the program version."""
    job: Callable[[], list[Row]]
    """Finds its rows; picklable."""

    @property
    def name(self) -> str:
        """The message where it fails."""
        return ", ".join(
            f"{name} {cell:g}" if isinstance(cell, float) else cell for name, cell in self.labels.items() if cell != ""
        )


@dataclass(frozen=True)
class Ensemble:
    """All cases of a sweep, and the columns of its table."""

    labels: tuple[Head, ...]
    numbers: tuple[Head, ...]
    cases: Sequence[Case]

    @property
    def heads(self) -> list[str]:
        """Heads of the file."""
        inner = [name for head in (*self.labels, Head("body"), Head("outcome"), *self.numbers) for name in head.names]
        return [*inner, "why", "fingerprint"]


Found = Mapping[str, Sequence[Row]]
"""Rows of cases by their fingerprints."""


class Answer(NamedTuple):
    """A row and the case it belongs to."""

    case: Case
    row: Row


def answers(ensemble: Ensemble, found: Found) -> Iterator[Answer]:
    """Give the rows that are there, in the order of the cases."""
    for case in ensemble.cases:
        for row in found.get(case.fingerprint, ()):
            yield Answer(case, row)


def write_rows(path: Path, ensemble: Ensemble, found: Found) -> None:
    """Write the rows that are there, in the order of the cases, whole or not at all."""
    lines = (_line(ensemble, *answer) for answer in answers(ensemble, found))
    write_file(path, csv_lines([ensemble.heads, *lines]))


def _line(ensemble: Ensemble, case: Case, row: Row) -> list[Cell]:
    cells: list[Cell] = [case.labels[head.name] for head in ensemble.labels]
    cells += [row.body, row.outcome]
    for head in ensemble.numbers:
        cells += _numbers(row.found.get(head.name), uncertain=head.uncertain)
    return [*cells, row.why, case.fingerprint]


def _numbers(quantity: Quantity | None, *, uncertain: bool) -> Iterator[float]:
    yield math.nan if quantity is None else quantity.value
    if uncertain:
        spread = None if quantity is None else quantity.standard_uncertainty
        yield math.nan if spread is None else spread


def read_rows(path: Path, ensemble: Ensemble) -> dict[str, list[Row]]:
    """Return the rows of a file by fingerprint, those of cases that failed left out.

    Raises ``ManifestError`` where it is no table of such a sweep.
    """
    found: dict[str, list[Row]] = {}
    try:
        with path.open(encoding="utf-8", newline="") as file:
            lines = csv.reader(file)
            if next(lines, None) != ensemble.heads:
                raise _other_table(path)
            for line in lines:
                row, fingerprint = _row(dict(zip(ensemble.heads, line, strict=True)), ensemble.numbers)
                found.setdefault(fingerprint, []).append(row)
    except (ValueError, csv.Error):
        raise _other_table(path) from None
    return {fingerprint: rows for fingerprint, rows in found.items() if all(row.outcome != FAILED for row in rows)}


def _other_table(path: Path) -> ManifestError:
    return ManifestError(
        f"{path}: found the table of another sweep; expected the table of this sweep, or no file; choose another "
        "file, or replace the table with --force"
    )


def _row(line: Mapping[str, str], numbers: Iterable[Head]) -> tuple[Row, str]:
    quantities = {}
    for head in numbers:
        value, *spread = (float(line[name]) if line[name] else None for name in head.names)
        if value is not None:
            uncertainty = spread[0] if spread else None
            quantities[head.name] = Quantity(value=value, unit=head.unit or "1", standard_uncertainty=uncertainty)
    return Row(line["body"], line["outcome"], quantities, line["why"]), line["fingerprint"]


_MOST_CASES = 1_000_000
REPEAT = "repeat"


@dataclass(frozen=True)
class Combination:
    """One value of each key that is varied."""

    settings: Settings
    cells: Mapping[str, Cell]
    repeat: int
    """Number of the repeat, from 1."""

    def labels(self, run_id: str) -> dict[str, Cell]:
        """Return what distinguishes its case of a run from all others."""
        return {"run": run_id, **self.cells, REPEAT: float(self.repeat)}


def combinations(parameters: Sequence[Parameter], repeats: int, seed: int) -> Iterator[Combination]:
    """Give every combination of the values that are listed, the last key's changing fastest, each so often.

    What is drawn depends on seed, repeat and path alone: a repeat has the same luck in every combination.
    """
    for chosen in product(*(listed(parameter) for parameter in parameters)):
        for repeat in range(1, repeats + 1):
            values = {
                parameter.path: value or parameter.draw(seed, repeat)
                for parameter, value in zip(parameters, chosen, strict=True)
            }
            yield Combination(
                {path: value.given for path, value in values.items()},
                {path: value.cell for path, value in values.items()},
                repeat,
            )


def listed(parameter: Parameter) -> tuple[Value | None, ...]:
    """Return the values of a key that make combinations: one, not yet known, where it is drawn."""
    return parameter.values if parameter.drawn is None else (None,)


def label_heads(varied: Sequence[Parameter], repeats: int | None) -> tuple[Head, ...]:
    """Return the columns that distinguish cases; that of repeats only where there are some."""
    return (Head("run"), *map(_head, varied), *([] if repeats is None else [Head(REPEAT)]))


def _head(varied: Parameter) -> Head:
    return Head(varied.path, varied.unit, written={value.cell: value.shown for value in varied.values if value.shown})


def refuse_endless(parameters: Sequence[Parameter], times: int, where: str) -> None:
    """Raise ``ManifestError`` where more cases are asked for than anyone waits for."""
    count = times * math.prod(len(listed(parameter)) for parameter in parameters)
    if count > _MOST_CASES:
        raise ManifestError(
            f"{where}: found {count} cases; expected at most {_MOST_CASES}; vary fewer keys at once, or use fewer "
            "repeats"
        )

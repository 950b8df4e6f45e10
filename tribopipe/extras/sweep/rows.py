"""Cases of a sweep and the rows of its table, and the file that keeps them: CSV, with units in its heads."""

import csv
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from tribopipe.base.errors import ManifestError
from tribopipe.base.files import write_file
from tribopipe.documents.quantity import Quantity
from tribopipe.extras.sweep.subject import Cell
from tribopipe.views.csv_files import csv_lines

FAILED = "failed"


@dataclass(frozen=True)
class Head:
    """A column of numbers or texts."""

    name: str
    unit: str | None = None
    uncertain: bool = False
    """Whether a standard uncertainty stands next to each number."""
    written: Mapping[Cell, str] = field(default_factory=dict)
    """How people wrote some of its values."""

    @property
    def names(self) -> tuple[str, ...]:
        """Heads in the file: "normal_load [N]", "normal_load uncertainty [N]"."""
        unit = "" if self.unit is None else f" [{self.unit}]"
        return (f"{self.name}{unit}", f"{self.name} uncertainty{unit}") if self.uncertain else (f"{self.name}{unit}",)


@dataclass(frozen=True)
class Row:
    """What a case found: of one body, or at one place."""

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
    """What distinguishes it from the others, by the names of columns."""
    fingerprint: str
    """Of all that its rows are made from, the program's version among it."""
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
        f"{path}: found a table that is not of this sweep; expected its own table or none; name another file, or "
        "replace it with --force"
    )


def _row(line: Mapping[str, str], numbers: Iterable[Head]) -> tuple[Row, str]:
    quantities = {}
    for head in numbers:
        value, *spread = (float(line[name]) if line[name] else None for name in head.names)
        if value is not None:
            uncertainty = spread[0] if spread else None
            quantities[head.name] = Quantity(value=value, unit=head.unit or "1", standard_uncertainty=uncertainty)
    return Row(line["body"], line["outcome"], quantities, line["why"]), line["fingerprint"]

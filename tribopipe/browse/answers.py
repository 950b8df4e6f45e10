"""What the server answers, as ui/src/api.ts has it: pages, lists of runs and studies, offered and drawn plots.

A plot is given in the units that people read, in about as many points as the window has pixels side by side.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import fields
from typing import Any

import numpy as np

from tribopipe.archive.catalog.catalog import Catalogue
from tribopipe.archive.catalog.listing import COLUMNS, ListedColumn, ListedRun, shown_number, texts_of
from tribopipe.archive.catalog.query import Asked
from tribopipe.archive.file_signature import STUDIES, SUFFIX
from tribopipe.archive.store import Archive
from tribopipe.base.arrays import Column
from tribopipe.base.column_formatting import Number, number_column
from tribopipe.base.units import from_si
from tribopipe.browse.plots import PlotOffer
from tribopipe.physics.laws import law_label
from tribopipe.results.finding import TITLES, Finding
from tribopipe.version import VERSION
from tribopipe.views.csv_files import CSV_KINDS
from tribopipe.views.decimation import Points, Shown, Window, shown
from tribopipe.views.page import LawPage, RunPage, StudyPage
from tribopipe.views.plot import Curve, Panel, Plot, Unit, axis_label

_COLOURED = ("archard", "sarkar")
"""Laws with their own color; others take the next that is free."""
_SPARKLINE_WIDTH = 32
"""Pixels of a small curve in the table."""


def plot_answer(name: str, plot: Plot, window: Window) -> dict[str, Any]:
    """Return a plot as the server answers it: what a window shows, in the units that people read."""
    axes = {id(curve.x): curve.x for panel in plot.panels for curve in panel.curves}
    span = window.span(list(axes.values()))
    parts = {key: shown(x, span, window.width) for key, x in axes.items()}
    panels = [_panel(panel, parts, span) for panel in plot.panels]
    return {
        "name": name,
        "title": plot.title,
        "words": plot.words,
        "x": {"name": plot.axis, "label": plot.axis_label, "from": span[0], "to": span[1]},
        "panels": panels,
        "samples": max((len(part.x) for part in parts.values()), default=0),
        "points": max(_lengths(panels), default=0),
    }


def sparkline_answer(offers: Sequence[PlotOffer]) -> dict[str, Any]:
    """Answer the first curve of the first plot of a run in a few points; no points of a run without a plot."""
    panels = offers[0].drawing().panels if offers else ()
    panel = next((panel for panel in panels if panel.curves), None)
    if panel is None:
        return {"name": "", "x": [], "y": []}
    curve = panel.curves[0]
    whole = Window(None, None, _SPARKLINE_WIDTH)
    points = shown(curve.x, whole.span([curve.x]), whole.width).thinned(curve.y)
    return {"name": panel.label, "x": np.ascontiguousarray(points.x), "y": _drawn(points.y, curve.unit)}


def _lengths(panels: Sequence[dict[str, Any]]) -> Iterator[int]:
    return (len(line["x"]) for panel in panels for line in panel["lines"])


def _panel(panel: Panel, parts: dict[int, Shown], span: tuple[float, float]) -> dict[str, Any]:
    return {
        "label": panel.label,
        "lines": [
            _line(curve, parts[id(curve.x)].thinned(curve.y, curve.lower, curve.upper)) for curve in panel.curves
        ],
        "marks": [one for one in panel.marks if span[0] <= one.x <= span[1]],
    }


def _line(curve: Curve, points: Points) -> dict[str, Any]:
    return {
        "name": curve.name,
        "run": curve.run,
        "role": curve.role,
        "law": curve.law if curve.law in _COLOURED else None,
        "x": np.ascontiguousarray(points.x, dtype=np.float64),
        "y": _drawn(points.y, curve.unit),
        "lower": None if points.lower is None else _drawn(points.lower, curve.unit),
        "upper": None if points.upper is None else _drawn(points.upper, curve.unit),
        "path": curve.path,
    }


def _drawn(values: Column, unit: Unit) -> Any:
    """Return values in the shown unit, in single precision: seven digits are more than a screen has."""
    return np.ascontiguousarray(from_si(values, unit.si, unit.shown), dtype=np.float32)


Cell = str | tuple[float, str] | tuple[float, str, float] | None


def archive_answer(archive: Archive, catalogue: Catalogue, revision: str) -> dict[str, Any]:
    """Answer what archive this is, its columns, and which files cannot be read."""
    unreadable = catalogue.unreadable
    return {
        "name": archive.folder.resolve().name,
        "folder": str(archive.folder.resolve()),
        "version": VERSION,
        "revision": revision,
        "runs": catalogue.count,
        "studies": len(archive.study_ids()),
        "columns": [_column(column) for column in COLUMNS.values()],
        "unreadable": [{"file": file, "error": error} for file, error in unreadable],
    }


def _column(column: ListedColumn) -> dict[str, Any]:
    told = ("name", "label", "unit", "help", "kind", "shown", "joint")
    answer = {name: getattr(column, name) for name in told}
    if column.kind == "number":
        answer |= {"factor": shown_number(column, spread=True)(1.0), "offset": shown_number(column)(0.0)}
    return answer


def runs_answer(catalogue: Catalogue, revision: str, asked: Asked, start: int, most: int | None) -> dict[str, Any]:
    """Answer all columns of runs that were asked for, and how many there are.

    A part of them has no common powers of ten, since another part may need others. Raises ``QueryError`` where what is
    asked cannot be understood.
    """
    total, runs = catalogue.listed(asked, start, most)
    cells = {name: _cells(runs, column) for name, column in COLUMNS.items()}
    return {
        "revision": revision,
        "total": total,
        "start": start,
        "ids": [run.id for run in runs],
        "columns": list(COLUMNS),
        "rows": list(zip(*cells.values(), strict=True)),
        "aligned": {
            name: _aligned(cells[name], column)
            for name, column in COLUMNS.items()
            if len(runs) == total and any(isinstance(cell, tuple) and "×10" in cell[1] for cell in cells[name])
        },
    }


def _aligned(cells: list[Cell], column: ListedColumn) -> dict[str, Any]:
    """Return numbers as they read beneath each other, with one power of ten in the unit."""
    value_of, spread_of = shown_number(column), shown_number(column, spread=True)

    def number(cell: Cell) -> Number | None:
        if not isinstance(cell, tuple) or (value := value_of(cell[0])) is None:
            return None
        return value, spread_of(cell[2]) if len(cell) > 2 else None

    found = number_column([number(cell) for cell in cells])
    texts = ["" if cell is None else text.strip() for cell, text in zip(cells, found.cells, strict=True)]
    return {"unit": found.unit(column.unit), "texts": texts}


def _cells(runs: list[ListedRun], column: ListedColumn) -> list[Cell]:
    texts = texts_of(runs, column)
    if column.kind != "number":
        return [text or None for text in texts]
    return [_number(run, column, text) if text else None for run, text in zip(runs, texts, strict=True)]


def _number(run: ListedRun, column: ListedColumn, text: str) -> Cell:
    """Return a number in SI, its text, and its standard uncertainty in as many digits as an error bar needs."""
    spread = run.uncertainty(column.name)
    return (run[column.name], text) if spread is None else (run[column.name], text, float(f"{spread:.3g}"))


def run_answer(run_id: str, page: RunPage, plots: Iterable[PlotOffer], tables: Iterable[str]) -> dict[str, Any]:
    """Answer the page of a run by the name of its file, which somebody may have changed.

    ``tables`` are those of ``CSV_KINDS`` that it has.
    """
    return {
        **_shallow(page),
        "id": run_id,
        "file": f"{run_id}{SUFFIX}",
        "findings": [_finding(finding) for finding in page.findings],
        "plots": [_offer(plot) for plot in plots],
        "csv": [{"name": name, "meaning": CSV_KINDS[name]} for name in tables],
    }


def _finding(finding: Finding) -> dict[str, Any]:
    """Return a finding with its help topic; checks of other packages have none."""
    help_topic = finding.code if finding.code in TITLES else None
    return {"severity": finding.severity, "text": str(finding), "help": help_topic}


def study_answer(study_id: str, page: StudyPage, plots: Iterable[PlotOffer]) -> dict[str, Any]:
    """Answer the page of a study, as that of a run."""
    return {
        **_shallow(page),
        "id": study_id,
        "file": f"{STUDIES}/{study_id}{SUFFIX}",
        "plots": [_offer(plot) for plot in plots],
    }


def _shallow(page: RunPage | StudyPage) -> dict[str, Any]:
    return {field.name: getattr(page, field.name) for field in fields(page)}


def _offer(plot: PlotOffer) -> dict[str, Any]:
    axes = [{"name": name, "label": axis_label(name)} for name in plot.axes]
    return {"name": plot.name, "title": plot.title, "stage": plot.stage, "path": plot.path, "axes": axes}


def study_line(page: StudyPage) -> dict[str, Any]:
    """Answer a study in one line: its runs, and how many of the predicted ones agree with each law."""
    tallies = ((law_label(law.model), _of_predicted(law)) for law in page.laws)
    return {
        "id": page.id,
        "title": page.title,
        "fitted": page.fitted,
        "predicted": page.predicted,
        "agreement": "; ".join(f"{law}: {tally}" for law, tally in tallies if tally),
    }


def _of_predicted(law: LawPage) -> str:
    outcomes = Counter(line.outcome for line in law.agreement if line.role == "predicted")
    return ", ".join(f"{count} {outcome}" for outcome, count in outcomes.items())

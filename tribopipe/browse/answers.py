"""What the server answers, as ui/src/api.ts has it: pages, lists of runs and studies, plots that are offered."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import fields
from typing import Any

from tribopipe.archive.catalog.catalog import Catalogue
from tribopipe.archive.catalog.columns import COLUMNS, ListedColumn
from tribopipe.archive.catalog.listed import ListedRun, shown_number, texts_of
from tribopipe.archive.store import STUDIES, SUFFIX, Archive
from tribopipe.browse.plots import PlotOffer
from tribopipe.physics.laws import law_label
from tribopipe.version import VERSION
from tribopipe.views.csv_files import CSV_KINDS
from tribopipe.views.page import RunPage, StudyPage
from tribopipe.views.plot import axis_label

Cell = str | tuple[float, str] | tuple[float, str, float] | None


def archive_answer(archive: Archive, catalogue: Catalogue) -> dict[str, Any]:
    """Answer what archive this is, its columns, and which files cannot be read."""
    unreadable = catalogue.unreadable
    return {
        "name": archive.folder.resolve().name,
        "folder": str(archive.folder.resolve()),
        "version": VERSION,
        "revision": catalogue.revision,
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


def runs_answer(catalogue: Catalogue, where: str) -> dict[str, Any]:
    """Answer all columns of the runs that were asked for. Raises ``QueryError`` where that cannot be understood."""
    revision, runs = catalogue.revision, catalogue.runs(where)
    return {
        "revision": revision,
        "ids": [run.id for run in runs],
        "columns": list(COLUMNS),
        "rows": list(zip(*(_cells(runs, column) for column in COLUMNS.values()), strict=True)),
    }


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
        "findings": [{"severity": finding.severity, "text": str(finding)} for finding in page.findings],
        "plots": [_offer(plot) for plot in plots],
        "csv": [{"name": name, "meaning": CSV_KINDS[name]} for name in tables],
    }


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
    """Answer a study in one line: its runs, and how many agree with each law."""
    laws = (f"{law_label(law.model)}: {_counted(verdict.outcome for verdict in law.verdicts)}" for law in page.laws)
    return {
        "id": page.id,
        "title": page.title,
        "fitted": page.fitted,
        "predicted": page.predicted,
        "verdicts": "; ".join(laws),
    }


def _counted(outcomes: Iterable[str]) -> str:
    return ", ".join(f"{count} {outcome}" for outcome, count in Counter(outcomes).items())

"""Tables, figures and notebook displays of objects in Python: runs, fits, archived runs and archives."""

from base64 import b64encode
from collections.abc import Mapping, Sequence
from functools import singledispatch
from html import escape
from io import BytesIO
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tribopipe.archive.catalog.catalog import Catalogue
from tribopipe.archive.catalog.listing import columns_named, usual_columns
from tribopipe.archive.store import Archive, ArchivedRun
from tribopipe.base.errors import FitError, unknown_name
from tribopipe.base.files import replacing
from tribopipe.base.optional_packages import required
from tribopipe.base.units import WEAR_COEFFICIENT
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.quantity import between
from tribopipe.pipeline.output_paths import require_free
from tribopipe.results.evaluation import FrictionFit
from tribopipe.results.interactive import UnitColumn
from tribopipe.results.run import CorrectedRun, RawRun
from tribopipe.results.wear_fit import WearFit
from tribopipe.results.wear_prediction import WearCurves
from tribopipe.views.archived_figures import run_figures
from tribopipe.views.csv_files import csv_columns, csv_kinds, csv_of, head_of
from tribopipe.views.page import shown
from tribopipe.views.run_figures import plot_depth, plot_friction, plot_signals, plot_wear
from tribopipe.views.run_tables import si_columns

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame, Series

Columns = Mapping[str, UnitColumn]
_MOST_ROWS = 20
"""Rows of a table in a notebook display, which has at most 30 lines."""


def frame(columns: Columns) -> "DataFrame":
    """Return columns with their units in ``attrs["units"]``."""
    from pandas import DataFrame

    table = DataFrame({name: one.values for name, one in columns.items()})
    table.attrs["units"] = {name: one.unit for name, one in columns.items()}
    return table


def column(name: str, values: UnitColumn) -> "Series[float]":
    """Return one column with its unit in ``attrs["units"]``."""
    from pandas import Series

    found = Series(values.values, name=name)
    found.attrs["units"] = values.unit
    return found


def dataset(columns: Columns) -> Any:
    """Return columns as an xarray Dataset. Raises ``NotInstalledError`` if xarray is not installed."""
    variables = {name: ("sample", one.values, {"units": one.unit}) for name, one in columns.items()}
    return required("xarray", "xarray", "datasets").Dataset(variables)


def datatree(run: ArchivedRun) -> Any:
    """Return the tables of an archived run as an xarray DataTree: a group for each."""
    archive, kinds = run.archive, csv_kinds(run.archive, run.id)
    groups = {what: dataset(_by_name(csv_columns(archive, run.id, what))) for what in kinds}
    tree = required("xarray", "xarray", "datasets").DataTree.from_dict(groups, name=run.id)
    tree.attrs["run"] = run.id
    return tree


def _by_name(columns: Mapping[str, Any]) -> dict[str, UnitColumn]:
    """Return columns by their names, without the units in the headers of CSV files: "depth [m]"."""
    parted = {head: head.removesuffix("]").rpartition(" [") for head in columns}
    return {name or head: UnitColumn(columns[head], unit if name else "") for head, (name, _, unit) in parted.items()}


def write_csv(columns: Columns, path: str | PathLike[str], *, force: bool) -> None:
    """Write columns as a CSV file. Raises ``OutputError`` if the file exists, unless forced."""
    target = Path(path)
    require_free([target], force=force)
    with replacing(target) as part, part.open("wb") as file:
        file.writelines(csv_of({head_of(name, one.unit): one.values for name, one in columns.items()}))


def runs_table(archive: Path, where: str, sort: str, columns: str | None) -> "DataFrame":
    """Return the runs of an archive: one row per run, numbers in SI with their standard uncertainty."""
    from pandas import DataFrame

    catalogue = Catalogue(archive)
    catalogue.refresh()
    found = si_columns(catalogue.runs(where, sort), columns_named(columns) if columns else None)
    table = DataFrame(found.values).astype(dict.fromkeys(found.units, float))
    table.attrs["units"] = found.units
    return table


def fit_frame(fit: WearFit) -> "DataFrame":
    """Return measured and fitted wear along a run. Raises ``FitError`` if the run is unknown."""
    run, curves = _fitted_run(fit), _curves(fit)
    progress = run.run.manifest.progress
    columns = {progress.signal: run.run.unit_columns()[progress.signal]}
    measured = run.pin_wear_depth
    if measured is not None:
        columns["measured_wear_depth"] = UnitColumn(measured, "m")
    for name, band in curves.bands.items():
        columns |= {
            f"{name}{end}": UnitColumn(line, band.unit)
            for end, line in (("", band.best), ("_lower", band.lower), ("_upper", band.upper))
        }
    if measured is not None and "wear_depth" in curves.bands:
        columns["residual"] = UnitColumn(measured - curves.bands["wear_depth"].best, "m")
    return frame(columns)


def residual(fit: WearFit) -> "Series[float]":
    """Return measured minus fitted wear along a run."""
    table = fit_frame(fit)
    if "residual" not in table:
        raise unknown_name(
            f"{fit.model} fit", "residual", map(str, table), "fit.measurements contains each value with the fitted one"
        )
    found: Series[float] = table["residual"]
    found.attrs["units"] = "m"
    return found


def _fitted_run(fit: WearFit | FrictionFit) -> Any:
    run = fit._fitted_to.run  # noqa: SLF001 - kept for these views alone
    if run is None:
        raise FitError(
            "fit: found a fit that was read without its run; expected a fit from this session or from an archive; use "
            'archive[run_id].fits["archard"]'
        )
    return run


def _curves(fit: WearFit) -> WearCurves:
    curves: WearCurves | None = None if (made := fit._fitted_to.curves) is None else made()  # noqa: SLF001 - as above
    if curves is None:
        raise FitError(f"{fit}; expected a fit with curves")
    return curves


@singledispatch
def plot(thing: object) -> "Figure":
    """Draw the figure used in reports."""
    raise TypeError(f"found {type(thing).__name__}, for which there is no figure; expected a run or a fit")


@plot.register(RawRun)
def _(run: RawRun) -> "Figure":
    return plot_signals(run)


@plot.register(CorrectedRun)
def _(run: CorrectedRun) -> "Figure":
    return plot_depth(run)


@plot.register(FrictionFit)
def _(fit: FrictionFit) -> "Figure":
    return plot_friction(_fitted_run(fit), fit)


@plot.register(WearFit)
def _(fit: WearFit) -> "Figure":
    run, curves = _fitted_run(fit), _curves(fit)
    return plot_wear(run, [curves])


@plot.register(ArchivedRun)
def _(run: ArchivedRun) -> "Figure":
    figures = run_figures(run.archive, run.id)
    return figures.get("wear") or next(iter(figures.values()), None) or plot_signals(run.run)


def page(thing: Any) -> str:
    """Return a notebook display: a title, a table of at most 20 rows, and the figure if there is one."""
    title, heads, rows = _summary(thing)
    left = len(rows) - _MOST_ROWS
    lines = [f"<p><b>{escape(title)}</b></p>", "<table>", _row("th", heads)]
    lines += [_row("td", row) for row in rows[:_MOST_ROWS]]
    lines += ["</table>", *([f"<p>… and {left} more</p>"] if left > 0 else []), *_picture(thing)]
    return "\n".join(lines)


def _row(tag: str, cells: Sequence[str]) -> str:
    return f"<tr>{''.join(f'<{tag}>{escape(cell)}</{tag}>' for cell in cells)}</tr>"


def _picture(thing: Any) -> list[str]:
    if isinstance(thing, Archive):
        return []
    try:
        figure = plot(thing)
    except FitError:  # nothing was fitted, or the run is not known: the table says what there is
        return []
    picture = BytesIO()
    figure.savefig(picture, format="png")
    return [f'<img src="data:image/png;base64,{b64encode(picture.getvalue()).decode()}" style="max-width: 100%">']


@singledispatch
def _summary(thing: Any) -> tuple[str, Sequence[str], list[Sequence[str]]]:
    """Return the title and the table of a display; for objects with columns, the columns."""
    columns = thing.unit_columns()
    rows: list[Sequence[str]] = [
        (name, one.unit, *(f"{number:.4g}" for number in _extent(one.values))) for name, one in columns.items()
    ]
    return str(thing), ("column", "SI unit", "first", "least", "most", "last"), rows


def _extent(values: Any) -> tuple[float, float, float, float]:
    known = values[~np.isnan(values)]
    if not len(known):
        return (float("nan"),) * 4
    return float(known[0]), float(known.min()), float(known.max()), float(known[-1])


@_summary.register(FrictionFit)
def _(fit: FrictionFit) -> tuple[str, Sequence[str], list[Sequence[str]]]:
    known = {"A": fit.amplitude, "b": fit.steady_state, "c": fit.running_in_distance, "mean": fit.mean}
    rows: list[Sequence[str]] = [(name, value.shown()) for name, value in known.items() if value is not None]
    return "friction μ(s) = A·exp(−s/c) + b", ("quantity", "value ± u"), rows + [("note", note) for note in fit.notes]


@_summary.register(WearFit)
def _(fit: WearFit) -> tuple[str, Sequence[str], list[Sequence[str]]]:
    rows: list[Sequence[str]] = []
    for name, body in fit.bodies.items():
        rows.append((f"k_D, {spoken(name)}", shown(body.wear_coefficient) or ""))
        rows.append((f"95 % CI, {spoken(name)}", between(body.interval, WEAR_COEFFICIENT)))
    rows += [(known.name.replace("_", " "), str(known.value)) for known in fit.parameters or ()]
    rows += [("finding", finding.message) for finding in fit.findings] + [("note", note) for note in fit.notes]
    title = f"wear fit: {fit.model}" if fit.bodies else str(fit)
    return title, ("quantity", "value ± u"), rows


@_summary.register(Archive)
def _(archive: Archive) -> tuple[str, Sequence[str], list[Sequence[str]]]:
    catalogue = Catalogue(archive.folder)
    catalogue.refresh()
    runs = catalogue.runs()
    columns = usual_columns(runs)
    rows: list[Sequence[str]] = [[run.text(column.name) for column in columns] for run in runs]
    return repr(archive), [column.heading for column in columns], rows

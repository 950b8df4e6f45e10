"""Plots of what was recorded: signals, columns without a meaning, and what preprocessing changed."""

from tribopipe.base.arrays import Column
from tribopipe.browse.run_results import raw_run
from tribopipe.browse.samples import RunFile
from tribopipe.documents.signals import SignalName
from tribopipe.views.plot import RATIO, Curve, Panel
from tribopipe.views.run_plots import AXES, CLEANED, clean_up_panels, signal_panels

_SHOWN_ELSEWHERE: tuple[SignalName, ...] = (*AXES, "depth", "friction_coefficient")


def recorded(run: RunFile) -> list[SignalName]:
    """Return the signals that have no plot of their own."""
    return [name for name in run.outline.origins if name not in _SHOWN_ELSEWHERE]


def draw_signals(run: RunFile, x: Column) -> tuple[Panel, ...]:
    """Draw forces, speed, temperature and humidity as recorded, each in a panel."""
    return signal_panels(x, raw_run(run, recorded=True), recorded(run))


def changed(run: RunFile) -> list[SignalName]:
    """Return the signals that preprocessing changed, but for axes."""
    return [name for name in run.outline.origins if name not in AXES and CLEANED + name in run.datasets]


def draw_clean_up(run: RunFile, x: Column) -> tuple[Panel, ...]:
    """Draw each signal that preprocessing changed, before and after."""
    return clean_up_panels(x, raw_run(run, recorded=True), raw_run(run), changed(run))


def extras(run: RunFile) -> dict[str, str]:
    """Return the paths of numeric columns that are no signals, by their names in the file."""
    with run.archive.open(run.id) as file:
        kept = file["entry"].get("extra_columns", {})
        numbers = {column.name: column for column in kept.values() if column.dtype.kind in "fiu"}
        return {f"{column.attrs['column_name']}": path for path, column in numbers.items()}


def draw_extra(run: RunFile, x: Column, name: str, path: str) -> tuple[Panel, ...]:
    """Draw a column as it was found."""
    curve = Curve(name, "measured", x, run.sampled(path), RATIO, run.id, path=path)
    return (Panel(name, RATIO, (curve,)),)

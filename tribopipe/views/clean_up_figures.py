"""Figure of preprocessing: each signal that a step changed, as recorded and as preprocessed."""

from textwrap import wrap
from typing import TYPE_CHECKING

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.units import axis, from_si
from tribopipe.documents.preprocessing import CleanUp
from tribopipe.documents.signals import SIGNALS, SignalName
from tribopipe.results.run import RawRun
from tribopipe.views.decimation import thinned
from tribopipe.views.plot import Panel
from tribopipe.views.run_figures import GREY, PALETTE, finish, key, styled
from tribopipe.views.run_plots import AXES, clean_up_panels

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BLUE = PALETTE[0]
_MOST_PANELS = 6
_MOST_LETTERS, _MOST_LINES = 94, 2
"""Largest number of letters per line, and of lines, of the text above a panel."""
_GAP = 0.01
"""Smallest share of the samples that a gap must have for the line to be interrupted."""
_FAR_OFF = 20.0
"""Ratio of the median raw value to the largest preprocessed value above which a raw signal is off the scale."""
_USUAL = (1, 99)
"""Percentiles between which the raw signal is shown in any case."""
_ROOM, _EDGE = 0.5, 0.05
"""Shares of the scale: by which masked samples may extend it, and margin above and below."""


def changed_signals(raw: RawRun, cleaned: RawRun, record: CleanUp) -> list[SignalName]:
    """Return the signals that a step changed, the axes last, except those that are only recalculated from them."""
    touched = {change.signal for change in record.changes}
    changed = [name for name in SIGNALS if name in touched & raw.columns.keys() and _differs(name, raw, cleaned)]
    return sorted(changed, key=lambda name: name in AXES)


def _differs(name: SignalName, raw: RawRun, cleaned: RawRun) -> bool:
    after = cleaned.columns.get(name)
    return after is None or not np.array_equal(raw.columns[name], after, equal_nan=True)


@styled
def plot_clean_up(raw: RawRun, cleaned: RawRun, record: CleanUp) -> "Figure":
    """Draw each signal changed by preprocessing over time, raw and preprocessed, with a description of the changes."""
    from tribopipe.views.canvas import ShownFigure

    changed = changed_signals(raw, cleaned, record)
    names, count = changed[:_MOST_PANELS], max(min(len(changed), _MOST_PANELS), 1)
    figure = ShownFigure(figsize=(6.3, 1.3 + 1.6 * count), dpi=150, layout="constrained")
    panels = figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0]
    drawn = clean_up_panels(cleaned.columns["time"], raw, cleaned, names)
    for ax, name, panel in zip(panels, names, drawn, strict=False):
        _draw_signal(ax, _short(name), panel)
        ax.set_title(_words(name, record), loc="left", fontsize=8)
        ax.margins(x=0.01)
    some = f", {len(names)} of {len(changed)} signals" if len(changed) > len(names) else ""
    finish(panels[0], f"{raw.id}: preprocessing{some}", _words(names[0], record) if names else str(record))
    panels[-1].set_xlabel(axis("time", "s"))
    key(figure, panels)
    return figure


def _draw_signal(ax: "Axes", name: str, panel: Panel) -> None:
    """Draw a signal as recorded and as preprocessed; only as recorded if it was excluded."""
    time, unit = panel.curves[0].x, panel.unit
    shown = {curve.name: from_si(curve.y, unit.si, unit.shown) for curve in panel.curves}
    before, after = shown["as recorded"], shown.get("preprocessed", np.full_like(time, np.nan))
    ax.set_ylabel(axis(name, unit.shown))
    ax.ticklabel_format(axis="y", style="plain", useOffset=False)
    if _is_far_off(before, after):
        ax.text(0.99, 0.04, "as recorded (off scale)", transform=ax.transAxes, ha="right", color=GREY, fontsize=8)
    else:
        ax.plot(*thinned(time, before), color=GREY, lw=0.8, label="as recorded")
    if np.any(np.isfinite(after)):
        ax.plot(*_broken(time, after), color=_BLUE, lw=0.9, label="preprocessed")
        ax.set_ylim(*_scale(before, after))


def _short(name: SignalName) -> str:
    short = {"friction_coefficient": "μ", "sliding_distance": "distance", "relative_humidity": "humidity"}
    return short.get(name, name.replace("_", " "))


def _broken(x: Column, y: Column) -> tuple[Column, Column]:
    """Thin out a line, and interrupt it at longer gaps."""
    thin_x, thin_y = thinned(x, y)
    missing = np.searchsorted(x[np.isfinite(x) & ~np.isfinite(y)], thin_x)
    gaps = np.flatnonzero(np.diff(missing) > _GAP * len(x)) + 1
    return np.insert(thin_x, gaps, np.nan), np.insert(thin_y, gaps, np.nan)


def _is_far_off(before: Column, after: Column) -> bool:
    """Return whether a raw signal is so large that the preprocessed one would look like a flat line next to it."""
    kept = before[np.isfinite(before) & np.isfinite(after)]
    return bool(len(kept)) and np.median(np.abs(kept)) > _FAR_OFF * np.nanmax(np.abs(after))


def _scale(before: Column, after: Column) -> tuple[float, float]:
    """Choose a scale that shows the preprocessed signal, and as much of the raw one as does not flatten it."""
    masked = ~np.isfinite(after)
    low, high = np.nanmin(after), np.nanmax(after)
    if not _is_far_off(before, after):
        kept = before[~masked & np.isfinite(before)]
        least, most = np.percentile(kept, _USUAL) if len(kept) else (low, high)
        low, high = min(low, least), max(high, most)
    span = high - low or abs(high) or 1.0
    hidden = np.append(before[masked], [low, high])
    low, high = max(np.nanmin(hidden), low - _ROOM * span), min(np.nanmax(hidden), high + _ROOM * span)
    return float(low - _EDGE * span), float(high + _EDGE * span)


def _words(name: SignalName, record: CleanUp) -> str:
    """Return the changes to a signal in a line or two."""
    done = "; ".join(change.what for change in record.changes if change.signal == name)
    sentence = f"{name.replace('_', ' ')}: {done}"
    return "\n".join(wrap(sentence, _MOST_LETTERS, max_lines=_MOST_LINES, placeholder=" …"))

"""A figure of a sweep: what was found against one or two of the keys that are varied."""

from collections.abc import Sequence
from dataclasses import dataclass
from textwrap import fill
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from tribopipe.base.errors import ManifestError
from tribopipe.base.units import WEAR_COEFFICIENT, axis, from_si
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.sweep import Sweep
from tribopipe.extras.sweep.cases import Answer, Ensemble, Found, Head, Row, answers
from tribopipe.extras.sweep.choices import COEFFICIENT
from tribopipe.extras.sweep.predictions import asked_for
from tribopipe.extras.sweep.subject import Cell
from tribopipe.extras.sweep.virtual_tests import TRUTH
from tribopipe.physics.uncertainty import TAILS
from tribopipe.results.evaluation import COVERAGE_FACTOR
from tribopipe.views.plot import power_of, powered_axis
from tribopipe.views.run_figures import BLACK, PALETTE, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_PANELS = 12
_MOST_ABREAST = 3
_LETTERS = 42
"""Number of characters that fit above a panel in one line."""
_APART, _CLOSE = 0.08, 0.008
"""Distance of colors: between two texts, and over all values."""
_SMALL = 1e-2
"""Lengths below are read in µm, m."""
_DECADES = 20
"""Ratio of the largest to the smallest value from which an axis is logarithmic."""
_RELATIVE = "relative to the true value"
"""Text shown instead of a unit."""


class _Key(NamedTuple):
    """Position in the figure."""

    panel: tuple[str, ...]
    line: Cell
    place: Cell


class _Point(NamedTuple):
    """Something found, SI."""

    key: _Key
    quantity: str
    unit: str
    interval: tuple[float, float, float]
    """Middle and ends."""


@dataclass(frozen=True)
class _Layout:
    """Keys of panels, x-axis and colors."""

    along: Head
    lines: Head | None
    panels: tuple[Head, ...]


@styled
def plot_sweep(sweep: Sweep, ensemble: Ensemble, found: Found) -> "Figure":
    """Draw what a sweep found against what is varied: one key along the axis, another by color, the rest in panels.

    k_D of choices and predictions have their 95 % intervals; draws and virtual tests, as k_D over the true one, those
    that hold 95 % of them. Raises ``ManifestError`` where nothing is varied, or too much.
    """
    told = [answer for answer in answers(ensemble, found) if answer.row.found]
    layout = _layout(sweep, ensemble, told)
    points = _points(sweep, layout, told)
    panels = list(dict.fromkeys(point.key.panel for point in points))
    if len(panels) > _MOST_PANELS:
        raise ManifestError(
            f"--figure: found {len(panels)} panels to draw; expected at most {_MOST_PANELS}; vary fewer keys at once, "
            "or choose fewer runs"
        )
    figure, grid = _panels(len(panels))
    for ax, panel in zip(grid, panels, strict=True):
        _draw(ax, layout, [point for point in points if point.key.panel == panel])
        ax.set_title(fill(", ".join(panel), _LETTERS), loc="left", fontsize=8)
    if layout.lines is not None:
        handles, names = grid[0].get_legend_handles_labels()
        figure.legend(handles, names, loc="outside lower center", ncols=3, title=_plain(layout.lines))
    if sweep.title:
        across = min(len(panels), _MOST_ABREAST)
        figure.suptitle(fill(sweep.title, _LETTERS * across), x=0.01, ha="left", fontsize=10, fontweight="bold")
    return figure


def _layout(sweep: Sweep, ensemble: Ensemble, told: Sequence[Answer]) -> _Layout:
    drawn = {path for path, values in sweep.vary.items() if not isinstance(values, tuple)} | {"repeat"}
    fixed = [head for head in ensemble.labels if head.name not in drawn]
    several = [head for head in fixed if len({answer.case.labels[head.name] for answer in told}) > 1]
    if not several:
        raise ManifestError(
            "--figure: found no values for the x-axis; expected a key with at least two values, and computed cases; "
            "vary a key"
        )
    varied = sorted(several, key=lambda head: head.name == "run")
    numeric = (head for head in varied if isinstance(told[0].case.labels[head.name], float))
    along = next(numeric, varied[0])
    lines = next((head for head in varied if head is not along and head.name != "run"), None)
    panels = tuple(head for head in fixed if head.name == "run" or head in several if head not in (along, lines))
    return _Layout(along, lines, panels)


def _points(sweep: Sweep, layout: _Layout, told: Sequence[Answer]) -> list[_Point]:
    groups: dict[_Key, list[Answer]] = {}
    for answer in told:
        labels, row = answer.case.labels, answer.row
        where = [row.body, row.outcome] if sweep.predictions is not None else [row.body]
        panel = (*(_text(head, labels[head.name]) for head in layout.panels), *where)
        line = "" if layout.lines is None else labels[layout.lines.name]
        groups.setdefault(_Key(panel, line, labels[layout.along.name]), []).append(answer)
    return [_point(sweep, key, [answer.row for answer in group]) for key, group in groups.items()]


def _point(sweep: Sweep, key: _Key, rows: Sequence[Row]) -> _Point:
    """Return the middle and the ends of a group's interval; of virtual tests relative to the true value."""
    name = COEFFICIENT.name if sweep.predictions is None else asked_for(rows[0])
    values, first = np.asarray([row.found[name].value for row in rows]), rows[0].found
    unit, interval = first[name].unit, (float(values[0]),) * 3
    if sweep.virtual_tests is not None:
        values, unit = values / np.asarray([row.found[TRUTH.name].value for row in rows]), _RELATIVE
    if sweep.draws:
        low, middle, high = np.quantile(values, [TAILS[0], 0.5, TAILS[1]])
        interval = float(middle), float(low), float(high)
    elif sweep.choices is not None:
        interval = interval[0], first["interval_lower"].value, first["interval_upper"].value
    else:
        half = COVERAGE_FACTOR * first[name].u_or_zero
        interval = interval[0], interval[0] - half, interval[0] + half
    return _Point(key, name, unit, interval)


def _panels(count: int) -> "tuple[Figure, list[Axes]]":
    from tribopipe.views.canvas import ShownFigure

    across = min(count, _MOST_ABREAST)
    down = -(-count // across)
    figure = ShownFigure(figsize=(max(4.2, 3.1 * across), 1.0 + 2.6 * down), dpi=150, layout="constrained")
    grid = figure.subplots(down, across, squeeze=False).ravel().tolist()
    for ax in grid[count:]:
        ax.set_visible(False)
    return figure, grid[:count]


def _draw(ax: "Axes", layout: _Layout, points: Sequence[_Point]) -> None:
    """Draw one panel."""
    places = list(dict.fromkeys(point.key.place for point in points))
    lines = list(dict.fromkeys(point.key.line for point in points))
    label, unit = _scale(points)
    if points[0].unit == _RELATIVE:
        ax.axhline(1.0, color=BLACK, lw=0.8)
    for number, line in enumerate(lines):
        mine = [point for point in points if point.key.line == line]
        middle, low, high = np.asarray([point.interval for point in mine]).T / unit
        ax.errorbar(
            _along(places, mine, number - (len(lines) - 1) / 2),
            middle,
            yerr=[np.maximum(middle - low, 0.0), np.maximum(high - middle, 0.0)],
            fmt="o-" if _are_numbers(places) else "o",
            ms=4,
            capsize=2,
            color=PALETTE[number % len(PALETTE)],
            label=None if layout.lines is None else _text(layout.lines, line),
        )
    _finish(ax, layout.along, places)
    ax.set_ylabel(label)


def _along(places: Sequence[Cell], mine: Sequence[_Point], beside: float) -> list[float]:
    """Return the positions of points along the axis; overlapping lines are drawn side by side."""
    if not _are_numbers(places):
        return [places.index(point.key.place) + _APART * beside for point in mine]
    values = [float(place) for place in places]
    if _over_decades(places):
        stretched = (max(values) / min(values)) ** (_CLOSE * beside)
        return [float(point.key.place) * stretched for point in mine]
    return [float(point.key.place) + _CLOSE * beside * (max(values) - min(values)) for point in mine]


def _are_numbers(places: Sequence[Cell]) -> bool:
    return all(isinstance(place, float) for place in places)


def _over_decades(places: Sequence[Cell]) -> bool:
    values = [float(place) for place in places]
    return min(values) > 0 and max(values) / min(values) >= _DECADES


def _finish(ax: "Axes", along: Head, places: Sequence[Cell]) -> None:
    if not _are_numbers(places):
        ax.set_xticks(range(len(places)), [_text(along, place) for place in places])
        ax.set_xlabel(_plain(along))
        ax.margins(x=0.2)
        return
    if _over_decades(places):
        ax.set_xscale("log")
    ax.set_xlabel(axis(_plain(along), along.unit or "1"))


def _scale(points: Sequence[_Point]) -> tuple[str, float]:
    """Return the label of what was found, and its unit in SI."""
    si, most = points[0].unit, max(abs(point.interval[-1]) for point in points)
    if si == _RELATIVE:
        return "$k_\\mathrm{D}$ / true $k_\\mathrm{D}$", 1.0
    if si == COEFFICIENT.unit:
        shown = float(from_si(1.0, si, WEAR_COEFFICIENT))
        power = power_of(most * shown)
        return powered_axis("$k_\\mathrm{D}$", power, WEAR_COEFFICIENT), 10.0**power / shown
    unit = "um" if si == "m" and most < _SMALL else si
    return axis(spoken(points[0].quantity), unit), 1 / float(from_si(1.0, si, unit))


def _text(head: Head, cell: Cell) -> str:
    return cell if isinstance(cell, str) else head.written.get(cell) or f"{cell:.4g} {head.unit or ''}".strip()


def _plain(head: Head) -> str:
    return head.name.partition(".")[2] or head.name.replace("_", " ")

"""Figures of local wear: its course, compared with the Global Incremental Wear Model, and the evolving pressure.

The course has four panels as the paper's Figure 9, discs have maps of pressure as its Figure 8, and a pin its profile.
"""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tribopipe.archive.local_wear_tables import local_wear_tables
from tribopipe.base.arrays import Column
from tribopipe.base.units import WEAR_COEFFICIENT, axis, from_si, show
from tribopipe.physics.laws import law_label
from tribopipe.results.local_wear import LocalCurves, LocalDiscPoint, LocalPairPoint, LocalPinPoint
from tribopipe.views.layout import TWO_COLUMNS
from tribopipe.views.plot import turned
from tribopipe.views.run_figures import BLACK, GREY, PALETTE, four_panels, head_figure, key, save_figure, styled
from tribopipe.views.run_plots import local_wear_panels

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

_MOST_SNAPSHOTS = 5
_MAP_WIDTH, _MAP_HEIGHT = 4.9, 1.8
"""Largest width and height of a pressure map, inches."""
_CHANGED = 0.05
"""Relative change of the central pressure above which a state is drawn in addition to the unworn one."""
_BODY = "#E3E3E3"
_SEEN = 1.3
"""Half range of the drawing, relative to the half width of the contact."""


def local_wear_figures(curves: LocalCurves, run_id: str) -> "dict[str, Figure]":
    """Draw local wear. Return the figures by the names under which they are saved."""
    pressure = plot_pressure_maps if curves.discs or curves.track else plot_pin_profiles
    return {"local-wear": plot_local_wear(curves, run_id), "local-pressure": pressure(curves, run_id)}


def save_local_wear_figures(curves: LocalCurves, run_id: str, folder: Path) -> list[Path]:
    """Draw local wear, and return the files written: <folder>/<id>-<what>.png."""
    figures = local_wear_figures(curves, run_id)
    paths = {what: folder / f"{run_id}-{what}.png" for what in figures}
    for what, path in paths.items():
        save_figure(figures[what], path)
    return list(paths.values())


@styled
def plot_local_wear(curves: LocalCurves, run_id: str) -> "Figure":
    """Draw wear depth, pressure and contact size along a run, local and from the GIWM (paper, Fig. 9).

    For a round contact, the relative difference of the depths is drawn next to its radius, on logarithmic axes, since
    it is large only at the start.
    """
    from matplotlib.ticker import StrMethodFormatter

    discs = curves.discs
    along, label = turned(curves.along) if discs else (curves.along, axis("sliding distance s", "m"))
    columns = {name: values for name, (values, _) in local_wear_tables(curves)["course"].arrays.items()}
    # The peak jumps from cell to cell of the grid.
    columns["middle_pressure"] = curves.middle_pressure
    del columns["peak_pressure"]
    panels = local_wear_panels(along, columns, run_id)
    figure, axes = four_panels(panels, label)
    for ax, panel in zip(axes, panels, strict=False):
        if discs:
            ax.set_ylim(bottom=0.0)
            continue
        ax.set_xscale("log")
        ax.set_yscale("log" if np.nanmin(panel.curves[0].y[1:]) > 0 else "linear")
        for numbers in (ax.xaxis, ax.yaxis):
            numbers.set_major_formatter(StrMethodFormatter("{x:g}"))
    head_figure(axes[0], f"{run_id}: local wear", _words(curves))
    key(figure, axes, 4)
    return figure


@styled
def plot_pin_profiles(curves: LocalCurves, run_id: str) -> "Figure":
    """Draw the pressure under a pin, and its worn tip, at several sliding distances."""
    from tribopipe.views.canvas import ShownFigure

    places = _snapshots(curves)
    figure = ShownFigure(figsize=(TWO_COLUMNS, 3.9), dpi=150, layout="constrained")
    rows = figure.subplots(2, len(places), sharex="col", squeeze=False)
    position, at = _both_sides(curves.course.places[0])
    gap = _middle(curves, curves.gap)[at]
    for place, above, below in zip(places, *rows, strict=True):
        near = np.abs(position) <= _SEEN * curves.course.half_width[place]
        pressure, worn = (_middle(curves, field[place])[at] for field in (curves.course.pressure, curves.course.worn))
        x, p = from_si(position[near], "m", "um"), from_si(pressure[near], "Pa", "MPa")
        above.fill_between(x, p, color=PALETTE[0], alpha=0.25, lw=0)
        above.plot(x, p, color=PALETTE[0])
        above.set_ylim(bottom=0.0)
        _draw_tip(below, x, gap[near], worn[near])
        above.set_title(_place_words(curves, place), fontsize=9)
    rows[0][0].set_ylabel(axis("pressure", "MPa"))
    rows[1][0].set_ylabel(axis("tip", "um"))
    rows[1][len(places) // 2].set_xlabel(axis("position across the contact", "um"))
    _title(figure, f"{run_id}: pressure and worn tip")
    key(figure, rows[1], 2)
    return figure


def _draw_tip(ax: "Axes", x: Column, gap: Column, worn: Column) -> None:
    """Draw the unworn and the worn tip, with height above the disc."""
    before, after = (np.where(np.isfinite(gap), from_si(height, "m", "um"), np.nan) for height in (gap, gap + worn))
    top = 1.05 * float(np.nanmax(after)) or 1.0
    ax.fill_between(x, after, top, color=_BODY, lw=0)
    ax.plot(x, before, color=GREY, ls=(0, (5, 1.6)), lw=1.0, label="tip before the test")
    ax.plot(x, after, color=BLACK, label="worn tip")
    ax.set_ylim(-0.04 * top, top)


def _both_sides(places: Column) -> "tuple[Column, NDArray[np.intp]]":
    """Return positions from one side of a contact to the other, m, and the index of the radius of each."""
    count = np.arange(places.size)
    if places[0] < 0:
        return places, count
    other = count[:0:-1] if places[0] == 0 else count[::-1]
    return np.concatenate([-places[other], places]), np.concatenate([other, count])


def _middle(curves: LocalCurves, field: Column) -> Column:
    """Return a field across the middle of the contact."""
    return field if field.ndim == 1 else field[:, np.argmin(np.abs(curves.course.places[1]))]


@styled
def plot_pressure_maps(curves: LocalCurves, run_id: str) -> "Figure":
    """Draw the pressure between two bodies that wear at several positions, all on the same length scale."""
    from tribopipe.views.canvas import ShownFigure

    places = _snapshots(curves)
    most = (curves.course.half_width, curves.course.half_length)
    reach = [1.1 * float(from_si(np.max(half), "m", "um")) for half in most]
    each = 0.55 + min(max(0.4, _MAP_WIDTH * reach[1] / reach[0]), _MAP_HEIGHT)
    figure = ShownFigure(figsize=(6.3, 0.7 + each * len(places)), dpi=150, layout="constrained")
    axes = figure.subplots(len(places), 1, sharex=True, squeeze=False)[:, 0]
    (x, across), (z, along) = (_both_sides(half) for half in curves.course.places)
    for place, ax in zip(places, axes, strict=True):
        pressure = from_si(curves.course.pressure[place][np.ix_(across, along)], "Pa", "MPa")
        seen = np.ma.masked_equal(pressure, 0.0).T
        drawn = ax.pcolormesh(
            from_si(x, "m", "um"), from_si(z, "m", "um"), seen, vmin=0.0, shading="nearest", rasterized=True
        )
        ax.set_aspect("equal")
        ax.set_xlim(-reach[0], reach[0])
        ax.set_ylim(-reach[1], reach[1])
        ax.set_title(_place_words(curves, place), fontsize=9, loc="left")
        ax.set_ylabel(axis("z", "um"))
        figure.colorbar(drawn, ax=ax, label=axis("p", "MPa"), aspect=6, pad=0.02)
    direction = "direction of rolling" if curves.discs else "sliding direction"
    axes[-1].set_xlabel(axis(f"x, across the {direction}", "um"))
    _title(figure, f"{run_id}: contact pressure")
    return figure


def _snapshots(curves: LocalCurves) -> list[int]:
    """Return the unworn state, and up to four of the requested positions at which the pressure has changed."""
    wanted = np.unique(np.searchsorted(curves.along, [_place_of(point) for point in curves.result.points]))
    change = np.abs(curves.middle_pressure[wanted] / curves.middle_pressure[0] - 1)
    changed = wanted[(change > _CHANGED) | (wanted == wanted[-1])]
    kept = np.linspace(0, len(changed) - 1, min(len(changed), _MOST_SNAPSHOTS - 1)).round().astype(int)
    return [0, *changed[kept].tolist()]


def _place_of(point: LocalPinPoint | LocalPairPoint | LocalDiscPoint) -> float:
    """Return the sliding distance, m, or the rotations at a point."""
    place = point.rotations if isinstance(point, LocalDiscPoint) else point.sliding_distance
    return place.value


def _place_words(curves: LocalCurves, place: int) -> str:
    along = float(curves.along[place])
    if along == 0:
        return "unworn"
    if curves.discs:
        return f"{show(along, None, '1')} rotations"
    unit = next((unit for unit in ("mm", "m") if from_si(along, "m", unit) < 1000), "m")
    return show(along, None, "m", unit)


def _words(curves: LocalCurves) -> list[str]:
    result = curves.result
    how = f"{law_label(result.model)}, {result.engine}, {result.scheme}"
    known = f"$k_\\mathrm{{D}}$ = {result.wear_coefficient.shown(WEAR_COEFFICIENT)}"
    if result.track_wear_coefficient is None:
        return [f"{how}: {known}"]
    return [how, f"{known} and {result.track_wear_coefficient.shown(WEAR_COEFFICIENT)}"]


def _title(figure: "Figure", words: str) -> None:
    figure.suptitle(words, x=0.01, ha="left", fontsize=10, fontweight="bold")

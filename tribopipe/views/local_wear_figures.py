"""Figures of local wear: its course beside the Global Incremental Wear Model, and the pressure as the surface wears.

Discs have the four panels of the paper's Figure 9 and maps of pressure; wear engines beside each other are its Figures
10 and 11. Local wear and the two readings of the GIWM differ in line style as well as in colour (Okabe–Ito).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.units import WEAR_COEFFICIENT, axis, from_si, show
from tribopipe.physics.laws import law_label
from tribopipe.results.local_wear import LocalDiscPoint, LocalPinPoint
from tribopipe.results.local_wear_curves import GlobalWear, LocalCurves
from tribopipe.views.layout import TWO_COLUMNS, letter
from tribopipe.views.number_format import power_of, powered_axis, turned
from tribopipe.views.run_figures import BLACK, GREY, PALETTE, RED, finish, key, save_figure, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

_DASHED, _DOTTED, _MIXED = (0, (5, 1.6)), (0, (1.2, 1.2)), (0, (5, 1.4, 1.2, 1.4))
_LOCAL: Any = {"color": BLACK, "ls": "-", "label": "local"}
_GIWM: dict[str, Any] = {
    "giwm": {"color": PALETTE[0], "ls": _DASHED, "label": "GIWM"},
    "giwm_as_printed": {"color": RED, "ls": _DOTTED, "label": "GIWM as printed, Eq. 11"},
}
_MOST_SNAPSHOTS = 5
_STYLES: tuple[Any, ...] = ("-", _DASHED, _MIXED, _DOTTED)
_MAP_WIDTH = 4.9
"""Of a map of pressure, inches."""
_CHANGED = 0.05
"""Share by which the pressure in the middle has changed where a state is worth a picture beside the unworn one."""
_BODY = "#E3E3E3"
_SEEN = 1.3
"""Share of the contact's half width that is drawn to either side."""


def local_wear_figures(curves: LocalCurves, run_id: str) -> "dict[str, Figure]":
    """Draw local wear by the names that its figures are saved under."""
    if curves.discs:
        return {
            "local-wear": plot_local_discs(curves, run_id),
            "local-pressure": plot_pressure_maps(curves, run_id),
        }
    return {"local-wear": plot_local_pin(curves, run_id), "local-pressure": plot_pin_profiles(curves, run_id)}


def save_local_wear_figures(curves: LocalCurves, run_id: str, folder: Path, suffix: str = ".png") -> list[Path]:
    """Draw local wear, and return the files written: <folder>/<id>-<what>.png."""
    figures = local_wear_figures(curves, run_id)
    paths = {what: folder / f"{run_id}-{what}{suffix}" for what in figures}
    for what, path in paths.items():
        save_figure(figures[what], path)
    return list(paths.values())


@styled
def plot_local_pin(curves: LocalCurves, run_id: str) -> "Figure":
    """Draw a pin's wear depth against sliding distance, local and by the GIWM, and by how much they differ."""
    from matplotlib.ticker import StrMethodFormatter

    from tribopipe.views.canvas import ShownFigure

    figure = ShownFigure(figsize=(6.3, 5.0), dpi=150, layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[3, 2])
    worn, giwm = slice(1, None), curves.giwm["giwm"]
    above.loglog(curves.along[worn], from_si(curves.course.depth[worn], "m", "um"), **_LOCAL)
    above.loglog(curves.along[worn], from_si(giwm.depth[worn], "m", "um"), **_GIWM["giwm"])
    difference = 100 * (curves.course.depth[worn] / giwm.depth[worn] - 1)
    for sign, look in ((1, {"color": BLACK}), (-1, {"color": RED, "label": "local shallower than GIWM"})):
        if np.any(sign * difference > 0):
            below.loglog(curves.along[worn], np.where(sign * difference > 0, np.abs(difference), np.nan), **look)
    below.axhline(1.0, color=GREY, lw=0.8)
    for numbers in (above.yaxis, below.yaxis, below.xaxis):
        numbers.set_major_formatter(StrMethodFormatter("{x:g}"))
    above.set_ylabel(axis("wear depth", "um"))
    below.set_ylabel(axis("local − GIWM", "%"))
    below.set_xlabel(axis("sliding distance s", "m"))
    finish(above, f"{run_id}: local wear", _words(curves))
    key(figure, (above, below), 4)
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
    """Draw the tip as it was and as it is left, upwards out of the disc."""
    before, after = (np.where(np.isfinite(gap), from_si(height, "m", "um"), np.nan) for height in (gap, gap + worn))
    top = 1.05 * float(np.nanmax(after)) or 1.0
    ax.fill_between(x, after, top, color=_BODY, lw=0)
    ax.plot(x, before, color=GREY, ls=_DASHED, lw=1.0, label="tip before the test")
    ax.plot(x, after, color=BLACK, label="worn tip")
    ax.set_ylim(-0.04 * top, top)


def _both_sides(places: Column) -> "tuple[Column, NDArray[np.intp]]":
    """Return positions from one side of a contact to the other, m, and which of the places each one is."""
    count = np.arange(places.size)
    if places[0] < 0:
        return places, count
    other = count[:0:-1] if places[0] == 0 else count[::-1]
    return np.concatenate([-places[other], places]), np.concatenate([other, count])


def _middle(curves: LocalCurves, field: Column) -> Column:
    """Return a field across the middle of the contact."""
    return field if field.ndim == 1 else field[:, np.argmin(np.abs(curves.course.places[1]))]


class _Panel(NamedTuple):
    """One of the four panels of Fig. 9."""

    quantity: str
    """As ``GlobalWear`` names it."""
    label: str
    si: str
    unit: str
    side: Literal["left", "right"]
    """Where curves leave room for the letter."""


_PANELS = (
    _Panel("depth", "wear depth", "m", "um", "left"),
    _Panel("pressure", "pressure p", "Pa", "MPa", "right"),
    _Panel("half_width", "$a_x$", "m", "um", "left"),
    _Panel("half_length", "$a_z$", "m", "um", "right"),
)


@styled
def plot_local_discs(curves: LocalCurves, run_id: str) -> "Figure":
    """Draw wear depth, pressure, a_x and a_z against rotations, local and by the GIWM (paper, Fig. 9)."""
    from tribopipe.views.canvas import ShownFigure

    figure = ShownFigure(figsize=(6.3, 5.6), dpi=150, layout="constrained")
    axes = list(figure.subplots(2, 2, sharex=True).flat)
    along, label = turned(curves.along)
    course = curves.course
    local = GlobalWear(course.depth, curves.mean_pressure, course.half_width, course.half_length)
    for name, ax, panel in zip("abcd", axes, _PANELS, strict=True):
        for states, look in ((local, _LOCAL), *((curves.giwm[model], look) for model, look in _GIWM.items())):
            ax.plot(along, from_si(getattr(states, panel.quantity), panel.si, panel.unit), **look)
        ax.set_ylabel(axis(panel.label, panel.unit))
        ax.margins(x=0.02)
        place = 0.03 if panel.side == "left" else 0.97
        ax.text(place, 0.97, f"({name})", transform=ax.transAxes, ha=panel.side, va="top")
    middle = from_si(curves.middle_pressure, "Pa", "MPa")
    axes[1].plot(along, middle, color=GREY, ls=_MIXED, label="local, in the middle")
    for ax in axes:
        ax.set_ylim(bottom=0.0)
    for ax in axes[2:]:
        ax.set_xlabel(label)
    finish(axes[0], f"{run_id}: local wear", _words(curves))
    axes[0].texts[-1].set_in_layout(False)
    key(figure, axes, 4)
    return figure


@styled
def plot_pressure_maps(curves: LocalCurves, run_id: str) -> "Figure":
    """Draw the pressure between two discs after several rotations, all on one scale of length."""
    from tribopipe.views.canvas import ShownFigure

    places = _snapshots(curves)
    most = (curves.course.half_width, curves.course.half_length)
    reach = [1.1 * float(from_si(np.max(half), "m", "um")) for half in most]
    each = 0.55 + max(0.4, _MAP_WIDTH * reach[1] / reach[0])
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
    axes[-1].set_xlabel(axis("x, across the direction of rolling", "um"))
    _title(figure, f"{run_id}: contact pressure")
    return figure


@dataclass(frozen=True)
class EngineCurve:
    """The course of wear by one engine or scheme."""

    name: str
    rotations: Column
    """Of the curved disc."""
    depth: Column
    """m."""
    pressure: Column
    """In the middle of the contact, or on average, Pa."""


@styled
def plot_engines(curves: Sequence[EngineCurve], title: str = "") -> "Figure":
    """Draw pressure and wear depth by several engines, and how far depths are off the first one's (Fig. 10 and 11)."""
    from tribopipe.views.canvas import ShownFigure

    figure = ShownFigure(figsize=(7.2, 3.3), dpi=150, layout="constrained")
    axes = list(figure.subplots(1, 3))
    power, first = power_of(max(float(curve.rotations[-1]) for curve in curves)), curves[0]
    for number, curve in enumerate(curves):
        along = curve.rotations / 10.0**power
        look = {"color": PALETTE[number % len(PALETTE)], "ls": _STYLES[number % len(_STYLES)], "label": curve.name}
        axes[0].plot(along, from_si(curve.pressure, "Pa", "MPa"), **look)
        axes[1].plot(along, from_si(curve.depth, "m", "um"), **look)
        reference = np.interp(curve.rotations, first.rotations, first.depth)
        worn = (reference > 0) & (curve.rotations <= first.rotations[-1])
        axes[2].plot(along[worn], 100 * (curve.depth[worn] / reference[worn] - 1), **look)
    labels = (axis("pressure", "MPa"), axis("wear depth", "um"), axis(f"depth off {first.name}", "%"))
    for place, (ax, words) in enumerate(zip(axes, labels, strict=True)):
        ax.set_ylabel(words)
        ax.set_xlabel(powered_axis("rotations", power))
        letter(ax, place, "", len(axes))
    for ax in axes[:2]:
        ax.set_ylim(bottom=0.0)
    _title(figure, title)
    key(figure, axes, 4)
    return figure


def _snapshots(curves: LocalCurves) -> list[int]:
    """Return the unworn state, and up to four of the wanted places by which the pressure has changed."""
    wanted = np.unique(np.searchsorted(curves.along, [_place_of(point) for point in curves.result.points]))
    change = np.abs(curves.middle_pressure[wanted] / curves.middle_pressure[0] - 1)
    changed = wanted[(change > _CHANGED) | (wanted == wanted[-1])]
    kept = np.linspace(0, len(changed) - 1, min(len(changed), _MOST_SNAPSHOTS - 1)).round().astype(int)
    return [0, *changed[kept].tolist()]


def _place_of(point: LocalPinPoint | LocalDiscPoint) -> float:
    """Return the sliding distance of a point, m, or its rotations."""
    place = point.sliding_distance if isinstance(point, LocalPinPoint) else point.rotations
    return place.value


def _place_words(curves: LocalCurves, place: int) -> str:
    along = float(curves.along[place])
    if along == 0:
        return "unworn"
    if curves.discs:
        return f"{show(along, None, '1')} rotations"
    unit = next((unit for unit in ("mm", "m") if from_si(along, "m", unit) < 1000), "m")
    return show(along, None, "m", unit)


def _words(curves: LocalCurves) -> str:
    result = curves.result
    how = f"{law_label(result.model)}, {result.engine}, {result.scheme}"
    return f"{how}: $k_\\mathrm{{D}}$ = {result.wear_coefficient.shown(WEAR_COEFFICIENT)}"


def _title(figure: "Figure", words: str) -> None:
    figure.suptitle(words, x=0.01, ha="left", fontsize=10, fontweight="bold")

"""Figures of profiles across wear tracks and worn tips: unworn surface, groove and pile-up."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from tribopipe.base.arrays import Column
from tribopipe.base.units import axis, from_si
from tribopipe.documents.quantity import Quantity
from tribopipe.evaluation.measurements.profile_levelling import Mask
from tribopipe.evaluation.measurements.track_profile import Level, Track
from tribopipe.results.run import Profile
from tribopipe.views.decimation import thinned
from tribopipe.views.run_figures import BLACK, GREEN, GREY, ORANGE, PALETTE, RED, finish, in_lines, save_figure, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BLUE = PALETTE[0]
_UNITS = ("nm", "um", "mm")
_MOST_FIGURES = 8
"""Largest number of figures for one run or file, which may be a map with many scan lines."""


def drawn_of(names: Sequence[str]) -> list[str]:
    """Choose the profiles to draw: all if they are few, otherwise a selection at equal steps."""
    count = len(names)
    return [names[round(place)] for place in np.linspace(0, count - 1, min(count, _MOST_FIGURES))]


def save_profile_figures(
    profiles: Mapping[str, Profile], found: Mapping[str, Track | Level], folder: Path, what: str
) -> dict[str, Path]:
    """Draw profiles by their keys, or a selection, and return the files written: <folder>/<what>-<key>.png."""
    written = {}
    for key in drawn_of(list(profiles)):
        name = re.sub(r"[^\w-]+", "-", key).strip("-")
        written[key] = folder / f"{what}-{name}.png"
        save_figure(draw_profile(profiles[key], found[key], f"{what}: {key}"), written[key])
    return written


class _Drawn(NamedTuple):
    """A profile in its display units."""

    x: Column
    z: Column
    unworn: Column
    levelled: Column
    """Height above the unworn surface."""
    along: str
    raw_up: str
    up: str
    """Units of positions, of heights as measured, and of leveled ones."""

    def place(self, position: float) -> float:
        """Return a position, m, in the unit of the axis."""
        return float(from_si(position, "m", self.along))


@styled
def draw_profile(profile: Profile, found: Track | Level, title: str) -> "Figure":
    """Draw a profile as measured with its unworn surface, and below it the leveled profile.

    In the leveled profile, the groove and the pile-up are filled, with their areas, width and depth.
    A profile without a track is only leveled, and the figure states why.
    """
    from tribopipe.views.canvas import ShownFigure

    figure = ShownFigure(figsize=(6.3, 5.4), dpi=150, layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[2, 3])
    drawn = _drawn(profile, found)
    _draw_raw(above, drawn, found)
    below.plot(*thinned(drawn.x, drawn.levelled), color=GREY, lw=0.8)
    below.axhline(0, color=BLACK, lw=0.8)
    if isinstance(found, Track):
        _draw_track(below, drawn, found)
        finish(above, title, _words(found))
    else:
        why = found.why.partition(";")[0].removeprefix("found ")
        finish(above, title, in_lines(f"wear track not evaluated: {why}"))
    above.set_ylabel(axis("height", drawn.raw_up))
    below.set_ylabel(axis("height above unworn surface", drawn.up))
    below.set_xlabel(axis("position", drawn.along))
    figure.legend(loc="outside lower center", ncols=3)
    return figure


def _drawn(profile: Profile, found: Track | Level) -> _Drawn:
    above = profile.height - found.unworn
    along, raw_up, up = map(_unit, (profile.position - profile.position[0], np.ptp(profile.height), above))
    return _Drawn(
        from_si(profile.position, "m", along),
        from_si(profile.height, "m", raw_up),
        from_si(found.unworn, "m", raw_up),
        from_si(above, "m", up),
        along,
        raw_up,
        up,
    )


def _unit(values: ArrayLike) -> str:
    """Return the unit in which the largest of some lengths has one to three digits before the decimal point."""
    largest = float(np.max(np.abs(values)))
    return next((unit for unit in _UNITS if from_si(largest, "m", unit) < 1000), _UNITS[-1])


def _draw_raw(ax: "Axes", drawn: _Drawn, found: Track | Level) -> None:
    ax.plot(*thinned(drawn.x, drawn.z), color=GREY, lw=0.8, label="as measured")
    form = "an arc" if found.form == "arc" else f"a {found.form}"
    ax.plot(drawn.x, np.where(found.reference, drawn.z, np.nan), color=_BLUE, lw=1.6, label="assumed unworn")
    ax.plot(*thinned(drawn.x, drawn.unworn), color=BLACK, ls=(0, (5, 1.6)), lw=0.9, label=f"unworn surface, {form}")
    if isinstance(found, Track) and np.any(found.dust):
        ax.plot(drawn.x[found.dust], drawn.z[found.dust], ".", ms=3, color=ORANGE, label="dust (interpolated)")


def _draw_track(ax: "Axes", drawn: _Drawn, track: Track) -> None:
    """Fill groove and pile-up, and mark width and depth."""
    surface = np.where(track.dust, np.nan, drawn.levelled)
    inside = _between(drawn, track.bounds)
    ax.fill_between(
        drawn.x,
        surface,
        0,
        where=inside & (surface < 0),
        color=RED,
        alpha=0.35,
        lw=0,
        label=f"groove: {track.area.shown('um^2')}",
    )
    for number, ridge in enumerate(track.ridges):
        label = "" if number else f"pile-up: {track.pile_up.shown('um^2')}"
        ax.fill_between(
            drawn.x, surface, 0, where=_between(drawn, ridge), color=GREEN, alpha=0.45, lw=0, label=label or None
        )
    _mark(ax, drawn, track)


def _between(drawn: _Drawn, ends: tuple[float, float]) -> Mask:
    return np.asarray((drawn.x >= drawn.place(ends[0])) & (drawn.x <= drawn.place(ends[1])))


def _mark(ax: "Axes", drawn: _Drawn, track: Track) -> None:
    """Draw arrows along width and depth, clear of the profile."""
    depth = float(from_si(track.depth.value, "m", drawn.up))
    left, right = (drawn.place(end) for end in track.bounds)
    low = min(float(np.min(drawn.levelled)), -depth)
    high = max(float(np.max(drawn.levelled)), 0.0)
    room = 0.16 * (high - low)
    ax.set_ylim(low - 1.6 * room, high + 0.5 * room)
    arrow = {"arrowstyle": "<->", "lw": 0.8, "color": BLACK, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", (left, low - 0.5 * room), (right, low - 0.5 * room), arrowprops=arrow)
    ax.text((left + right) / 2, low - 0.65 * room, f"width {_shown(track.width)}", fontsize=8, ha="center", va="top")
    inside = _between(drawn, track.bounds)
    deepest = drawn.x[inside][int(np.argmin(np.where(track.dust, np.inf, drawn.levelled)[inside]))]
    ax.annotate("", (deepest, 0.0), (deepest, -depth), arrowprops=arrow)
    at, side = _beside(drawn, left, right) or (deepest, "left")
    clear = {"fc": "white", "ec": "none", "alpha": 0.8, "pad": 1.5}
    ax.text(at, -depth / 2, f"  depth {_shown(track.depth)}  ", fontsize=8, ha=side, va="center", bbox=clear)


def _beside(drawn: _Drawn, left: float, right: float) -> tuple[float, str] | None:
    """Return the position and alignment of the text next to a groove, if it fits on one side."""
    needed = 0.26 * float(np.ptp(drawn.x))
    if drawn.x[-1] - right >= needed:
        return right, "left"
    return (left, "right") if left - drawn.x[0] >= needed else None


def _shown(length: Quantity) -> str:
    return length.shown(_unit(length.value))


def _words(track: Track) -> str:
    lost = (
        f"groove {track.area.shown('um^2')}, pile-up {track.pile_up.shown('um^2')}, net {track.net_area.shown('um^2')}"
    )
    return f"{lost}\nwidth {_shown(track.width)}, depth {_shown(track.depth)}"

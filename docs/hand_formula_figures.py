"""Figures of the formulas that standards give for calculation by hand: each over the volume that was worn."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from tribopipe.base.arrays import Column
from tribopipe.physics.geometry import segment_area
from tribopipe.physics.pin_on_track import SphereOnTrack, WornContact
from tribopipe.physics.stroke_ends import Stroke
from tribopipe.views.run_figures import BLACK, GREY, PALETTE, finish, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BLUE, RED, GREEN = PALETTE[:3]
BALL, APPROACH = 3e-3, 20e-6
"""Radius of the ball and approach of both bodies, m; ratios of one body hardly depend on them."""
STIFFNESS = np.asarray(115e9 / 10.0)
"""Reduced modulus of steel bodies over a load of 10 N, 1/m²."""
SIZE = (7.0, 2.9)


def worn_ball(groove_over_pin: Column) -> WornContact:
    """Return contacts of one ball in which the groove is so many times as deep as the ball has lost in height."""
    pin_depth = APPROACH / (1 + groove_over_pin)
    return SphereOnTrack(BALL).at_depths(pin_depth, APPROACH - pin_depth)


def flat_cap_ratio(size: Column, worn: WornContact) -> Column:
    """Return πd⁴/(64R) for a scar of this half size, over the volume that the ball has lost."""
    return np.asarray(np.pi * (2 * size) ** 4 / (64 * BALL) / worn.pin_volume)


def groove_ratio(worn: WornContact) -> Column:
    """Return the segment of the unworn ball as wide as the groove, over the cross-section of the groove."""
    return np.asarray(segment_area(half_chord=worn.half_width, radius=BALL) / worn.groove_area)


def middle_ratio(stroke_over_width: Column, worn: WornContact) -> Column:
    """Return cross-section in the middle times stroke, over the volume of the groove with both of its ends."""
    stroke = stroke_over_width * 2 * worn.half_width
    return np.asarray(stroke / Stroke(stroke, STIFFNESS).extended(worn))


def taper_ratio(taper: Column, half_width: float, ring: float) -> Column:
    """Return the segment of the mean scar width over the mean segment, for widths b·(1 ± taper) at both sides."""
    across = np.linspace(-1.0, 1.0, 401)
    widths = half_width * (1 + taper[:, None] * across)
    mean = np.trapezoid(segment_area(half_chord=widths, radius=ring), across, axis=1) / 2
    return np.asarray(segment_area(half_chord=half_width, radius=ring) / mean)


def elastic_ratio(size: Column, power: int) -> Column:
    """Return the volume under a scar over its share of wear, for scars so many times as wide as the elastic contact."""
    return np.asarray(1 / (1 - size**-power))


@styled
def plot_g99() -> Figure:
    """Draw what the formulas of ASTM G99 make of a ball and of a disc that both wear."""
    figure = Figure(figsize=SIZE, layout="constrained")
    pin, disc = figure.subplots(1, 2)
    depths = np.geomspace(0.01, 100.0, 181)
    worn = worn_ball(depths)
    _draw_ball(pin, depths, worn)
    disc.loglog(depths, groove_ratio(worn), color=BLUE)
    _against_depths(disc)
    finish(disc, "Disc", "segment of the unworn ball")
    return figure


@styled
def plot_g133() -> Figure:
    """Draw what a cross-section times the stroke makes of a groove with ends, and the cap of a ball that wears it."""
    figure = Figure(figsize=SIZE, layout="constrained")
    flat, ball = figure.subplots(1, 2)
    strokes = np.geomspace(1.5, 100.0, 181)
    for depth, colour, style, name in ((100.0, BLUE, "-", "unworn ball"), (1.0, RED, "--", "ball worn as deep")):
        worn = worn_ball(np.array([depth]))
        flat.semilogx(strokes, middle_ratio(strokes, worn), color=colour, ls=style, label=name)
    flat.axhline(1.0, color=GREY, lw=0.8)
    flat.set_xlabel("stroke / groove width")
    flat.set_ylabel("formula / wear volume")
    flat.legend()
    finish(flat, "Flat", "cross-section at mid-stroke × stroke")
    depths = np.geomspace(0.01, 100.0, 181)
    _draw_ball(ball, depths, worn_ball(depths))
    return figure


@styled
def plot_g77() -> Figure:
    """Draw what a mean scar width makes of a tapered scar of a block, and of one that is partly elastic."""
    figure = Figure(figsize=SIZE, layout="constrained")
    taper, elastic = figure.subplots(1, 2)
    shares = np.linspace(0.0, 0.5, 101)
    taper.plot(100 * shares, taper_ratio(shares, 0.5e-3, 17.5e-3), color=BLUE)
    taper.set_xlabel("deviation of the width at the sides, %")
    taper.set_ylabel("formula / wear volume")
    finish(taper, "Tapered scar", "with the mean width")
    _draw_elastic(elastic, 2, (("segment", BLUE, "-", 1.0),))
    finish(elastic, "Partly elastic scar", "")
    return figure


@styled
def plot_d4172() -> Figure:
    """Draw what a cap on a flat, and between two balls, makes of the scar of a four-ball test."""
    figure = Figure(figsize=(3.6, 2.9), layout="constrained")
    ax = figure.subplots()
    _draw_elastic(ax, 3, (("πd⁴/(32R)", BLUE, "-", 1.0), ("πd⁴/(64R)", RED, "--", 0.5)))
    ax.legend()
    finish(ax, "Four-ball", "")
    return figure


def _draw_ball(ax: "Axes", depths: Column, worn: WornContact) -> None:
    mean = (worn.half_length + worn.half_width) / 2
    for size, colour, style, name in (
        (worn.half_width, RED, "--", "d: width"),
        (mean, BLACK, ":", "d: mean"),
        (worn.half_length, BLUE, "-", "d: length"),
    ):
        ax.loglog(depths, flat_cap_ratio(size, worn), color=colour, ls=style, label=name)
    _against_depths(ax)
    ax.set_ylim(0.2, 50)
    ax.legend()
    finish(ax, "Ball", "πd⁴/(64R)")


def _against_depths(ax: "Axes") -> None:
    ax.axhline(1.0, color=GREY, lw=0.8)
    ax.set_xlabel("groove depth / wear depth of the ball")
    ax.set_ylabel("formula / wear volume")


def _draw_elastic(ax: "Axes", power: int, formulas: tuple[tuple[str, str, str, float], ...]) -> None:
    sizes = np.linspace(1.2, 5.0, 191)
    for name, colour, style, factor in formulas:
        ax.plot(sizes, factor * elastic_ratio(sizes, power), color=colour, ls=style, label=name)
    ax.axhline(1.0, color=GREY, lw=0.8)
    ax.set_ylim(0, 2.5)
    ax.set_xlabel("scar size / elastic contact size")
    ax.set_ylabel("formula / wear volume")

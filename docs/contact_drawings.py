"""Drawings of the contacts: what is pressed, what slides, and what is measured."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Circle, FancyArrowPatch, Polygon, Rectangle
from matplotlib.path import Path

from tribopipe.base.arrays import Column
from tribopipe.views.run_figures import BLACK, GREY, PALETTE, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BLUE, RED = PALETTE[0], PALETTE[1]
_PALE = "#e4e7ea"
_SIZE = (4.6, 2.9)


@styled
def draw_pin_on_disc() -> Figure:
    """Draw a ball in the groove of its disc, in a section across the track, and the disc from above."""
    figure, ax = _empty((5.6, 2.9), (-4.6, 6.6), (-2.1, 3.7))
    half, level = 1.05, -0.3
    ax.add_patch(Rectangle((-4.4, -1.7), 4.9, 1.7, facecolor=_PALE, edgecolor=BLACK, lw=0.8))
    middle, ball = -2.0, 1.5
    x = np.linspace(-half, half, 100)
    groove = level * np.sqrt(1 - (x / half) ** 2)
    ax.fill_between(middle + x, groove, 0.02, color="white", lw=0)
    around = np.linspace(-np.pi / 2 + np.arcsin(half / ball), 1.5 * np.pi - np.arcsin(half / ball), 200)
    center = np.sqrt(ball**2 - half**2)
    outline = [*zip(middle + ball * np.cos(around), center + ball * np.sin(around), strict=True)]
    outline += [*zip(middle + x, groove, strict=True)]
    ax.add_patch(Polygon(outline, closed=True, facecolor="white", edgecolor=BLACK, lw=0.8))
    ax.plot(middle + x, groove, color=RED, lw=1.6)
    _arrow(ax, (middle, 3.5), (middle, center + ball + 0.05), "normal_load", (middle + 0.15, 3.2), "left")
    _span(ax, (middle - half, middle + half), -0.75, "")
    ax.text(middle, -0.85, "disc_track_width,\npin_scar_width", ha="center", va="top")
    for place in (-half, half):
        ax.plot([middle + place, middle + place], [-0.85, 0], color=GREY, lw=0.6)
    ax.text(middle, center, "pin", ha="center", va="center")
    ax.text(0.4, -1.6, "disc", ha="right", va="bottom")
    disc, track = np.array([3.9, 0.9]), 1.75
    ax.add_patch(Circle(tuple(disc), 2.3, facecolor=_PALE, edgecolor=BLACK, lw=0.8))
    for radius in (track - 0.14, track + 0.14):
        ax.add_patch(Circle(tuple(disc), radius, facecolor="none", edgecolor=RED, lw=0.8))
    place = disc + track * np.array([-np.cos(0.6), np.sin(0.6)])
    ax.add_patch(Circle(tuple(place), 0.42, facecolor="white", edgecolor=BLACK, lw=0.8))
    end = disc + track * np.array([np.cos(0.35), np.sin(0.35)])
    ax.add_patch(FancyArrowPatch(tuple(disc), tuple(end), arrowstyle="->", mutation_scale=8, lw=0.8))
    ax.text(disc[0] - 0.2, disc[1] + 0.5, "track_radius", ha="center", va="bottom")
    _turn(ax, disc, 0.8, (200, 340))
    ax.text(disc[0], disc[1] - 0.95, "rotational_speed", ha="center", va="top")
    return figure


@styled
def draw_twin_disc() -> Figure:
    """Draw two discs that roll and slip, from the side and along the direction of rolling."""
    figure, ax = _empty((5.6, 3.3), (-5.2, 6.0), (-3.3, 3.9))
    radius = 1.45
    for height, words in ((radius, "curved_disc"), (-radius, "flat_disc")):
        upper = height > 0
        ax.add_patch(Circle((-2.6, height), radius, facecolor="white" if upper else _PALE, edgecolor=BLACK, lw=0.8))
        ax.text(-4.2, height, words, ha="right", va="center", rotation=90)
        end = (-2.6 + 0.95 * radius * np.cos(0.5), height + 0.95 * radius * np.sin(0.5))
        ax.add_patch(FancyArrowPatch((-2.6, height), end, arrowstyle="->", mutation_scale=8, lw=0.8))
        ax.text(-2.6, height - 0.1, "rolling_radius", ha="center", va="top")
    _turn(ax, np.array([-2.6, radius]), 1.1, (110, 165))
    _turn(ax, np.array([-2.6, -radius]), 1.1, (165, 110))
    ax.text(-1.0, 0.0, "slip = (v₂ − v₁)/v₁", ha="left", va="center")
    _arrow(ax, (-2.6, 3.8), (-2.6, 2.95), "normal_load", (-2.45, 3.5), "left")
    half, worn, crown = 1.5, 0.55, 1.75
    x = np.linspace(-half, half, 200)
    profile = np.maximum(crown - np.sqrt(crown**2 - x**2), crown - np.sqrt(crown**2 - worn**2))
    profile -= profile.min()
    body = [*zip(3.6 + x, profile, strict=True), (3.6 + half, 2 * radius), (3.6 - half, 2 * radius)]
    ax.add_patch(Polygon(body, closed=True, facecolor="white", edgecolor=BLACK, lw=0.8))
    ax.add_patch(Rectangle((3.6 - half, -2 * radius), 2 * half, 2 * radius, facecolor=_PALE, edgecolor=BLACK, lw=0.8))
    ax.plot([3.6 - worn, 3.6 + worn], [0, 0], color=RED, lw=2.2)
    _span(ax, (3.6 - worn, 3.6 + worn), -0.6, "")
    ax.text(3.6, -0.75, "curved_disc_track_width", ha="center", va="top")
    for place in (-worn, worn):
        ax.plot([3.6 + place, 3.6 + place], [-0.7, 0], color=GREY, lw=0.6)
    top = np.array([3.6, crown])
    end = top + crown * np.array([np.sin(0.65), -np.cos(0.65)])
    ax.add_patch(FancyArrowPatch(tuple(top), tuple(end), arrowstyle="->", mutation_scale=8, lw=0.8))
    ax.text(top[0], top[1] + 0.08, "crown_radius", ha="center", va="bottom")
    return figure


@styled
def draw_reciprocating() -> Figure:
    """Draw a ball that slides back and forth in its groove, from the side."""
    figure, ax = _empty(_SIZE, (-4.2, 4.2), (-1.6, 3.6))
    ax.add_patch(Rectangle((-4, -1.1), 8, 1.1, facecolor=_PALE, edgecolor=BLACK, lw=0.8))
    groove = np.linspace(-2.4, 2.4, 200)
    depth = -0.28 * np.minimum(1.0, np.sqrt(np.maximum(0.0, 1 - (np.maximum(np.abs(groove) - 1.4, 0.0)) ** 2)))
    ax.fill_between(groove, depth, 0.0, color="white", lw=0)
    ax.plot(groove, depth, color=RED, lw=1.2)
    bottom, half = -0.28, 0.78
    middle = bottom + np.sqrt(1.5**2 - half**2)
    around = np.linspace(-np.pi / 2 + np.arcsin(half / 1.5), 1.5 * np.pi - np.arcsin(half / 1.5), 200)
    ball = np.column_stack([0.6 + 1.5 * np.cos(around), middle + 1.5 * np.sin(around)])
    ax.add_patch(Polygon(ball, closed=True, facecolor="white", edgecolor=BLACK, lw=0.8))
    ax.plot([0.6 - half, 0.6 + half], [bottom, bottom], color=BLUE, lw=2.2)
    _arrow(ax, (0.6, 3.4), (0.6, 2.6), "normal_load", (0.75, 3.1), "left")
    _span(ax, (-1.6, 1.6), -0.85, "stroke")
    _span(ax, (0.6 - half, 0.6 + half), 0.05, "scar length")
    line = {"arrowstyle": "-", "color": GREY, "lw": 0.6}
    ax.annotate("groove", (-1.6, -0.26), (-3.2, 0.6), color=RED, arrowprops=line)
    ax.text(0.6, 1.3, "pin or ball", ha="center", va="center")
    ax.text(3.85, -0.95, "flat", ha="right", va="bottom")
    ax.annotate("", (2.4, 1.2), (3.8, 1.2), arrowprops={"arrowstyle": "<->", "color": BLACK, "lw": 0.8})
    ax.text(3.1, 1.3, "frequency", ha="center", va="bottom")
    return figure


@styled
def draw_block_on_ring() -> Figure:
    """Draw a block on a ring, from the side."""
    figure, ax = _empty(_SIZE, (-4.0, 4.0), (-3.6, 3.3))
    ring = 2.2
    ax.add_patch(Circle((0, -1.2), ring, facecolor=_PALE, edgecolor=BLACK, lw=0.8))
    half = 0.95
    level = -1.2 + np.sqrt(ring**2 - half**2)
    x = np.linspace(-half, half, 100)
    arc = -1.2 + np.sqrt(ring**2 - x**2)
    corners = [(-1.6, level), (-1.6, level + 1.1), (1.6, level + 1.1), (1.6, level), (half, level)]
    outline = [*corners, *zip(x[::-1], arc[::-1], strict=True)]
    ax.add_patch(Polygon(outline, closed=True, facecolor="white", edgecolor=BLACK, lw=0.8))
    ax.plot(x, arc, color=BLUE, lw=2.2)
    _arrow(ax, (0, level + 2.1), (0, level + 1.15), "normal_load", (0.15, level + 1.75), "left")
    _span(ax, (-half, half), level - 0.55, "block_scar_width")
    for place in (-half, half):
        ax.plot([place, place], [level - 0.65, level - 0.02], color=GREY, lw=0.6)
    ax.add_patch(FancyArrowPatch((0, -1.2), (ring * 0.8, -1.2 - ring * 0.6), arrowstyle="->", mutation_scale=8, lw=0.8))
    ax.text(0.75, -2.35, "radius", ha="center")
    ax.add_patch(Arc((0, -1.2), 2.4, 2.4, theta1=120, theta2=240, color=BLACK, lw=0.8))
    ax.annotate("", (-0.72, -2.16), (-0.6, -2.24), arrowprops={"arrowstyle": "<-", "color": BLACK, "lw": 0.8})
    ax.text(1.75, level + 0.55, "block", va="center")
    ax.text(-2.3, -1.2, "ring", ha="right", va="center")
    return figure


@styled
def draw_four_ball() -> Figure:
    """Draw a ball on three others, in a section through the axis and one contact."""
    figure, ax = _empty(_SIZE, (-3.4, 3.9), (-1.2, 3.9))
    away, height = 2 / np.sqrt(3), 2 * np.sqrt(2 / 3)
    ax.add_patch(Circle((away, 0), 1, facecolor=_PALE, edgecolor=BLACK, lw=0.8))
    ax.add_patch(Circle((-away / 2, 0), 1, facecolor=_PALE, edgecolor=GREY, lw=0.6, ls="--", alpha=0.6))
    ax.add_patch(Circle((0, height), 1, facecolor="white", edgecolor=BLACK, lw=0.8))
    ax.plot([0, 0], [-1.3, 3.0], color=GREY, lw=0.6, ls=(0, (6, 2, 1, 2)))
    touch = np.array([away, height]) / 2
    normal = np.array([away, -height]) / 2
    ax.plot([0, away], [height, 0], color=GREY, lw=0.6)
    _arrow(ax, tuple(touch - 0.75 * normal), tuple(touch - 0.05 * normal), "", (0, 0), "left")
    ax.text(*(touch - 0.55 * normal + [0.14, 0.02]), "F/√6", color=BLUE)
    ax.plot([0, touch[0]], [touch[1], touch[1]], color=RED, lw=1.2)
    ax.text(0.3, touch[1] - 0.42, "R/√3", color=RED, ha="left", va="center")
    _arrow(ax, (0, 3.8), (0, 2.68), "normal_load F", (0.15, 3.5), "left")
    line = {"arrowstyle": "-", "color": GREY, "lw": 0.6}
    ax.annotate("ball_scar_diameter", tuple(touch), (1.4, 1.7), arrowprops=line)
    ax.text(away + 1.1, 0, "ball", va="center")
    ax.text(-1.1, height, "top_ball", ha="right", va="center")
    ax.add_patch(Arc((0, 2.95), 1.0, 0.3, theta1=200, theta2=520, color=BLACK, lw=0.8))
    ax.text(-0.6, 3.0, "rotational_speed", ha="right", va="center")
    return figure


def _empty(size: tuple[float, float], x: tuple[float, float], y: tuple[float, float]) -> "tuple[Figure, Axes]":
    figure = Figure(figsize=size, layout="none")
    ax = figure.add_axes((0, 0, 1, 1))
    ax.set(xlim=x, ylim=y, aspect="equal")
    ax.set_axis_off()
    return figure, ax


def _turn(ax: "Axes", center: Column, radius: float, angles: tuple[float, float]) -> None:
    """Draw an arrow along a circle from one angle to another, degrees."""
    around = np.radians(np.linspace(*angles, 60))
    line = center + radius * np.column_stack([np.cos(around), np.sin(around)])
    ax.add_patch(FancyArrowPatch(path=Path(line), arrowstyle="->", mutation_scale=8, lw=0.8))


def _arrow(
    ax: "Axes", start: tuple[float, float], end: tuple[float, float], words: str, at: tuple[float, float], side: str
) -> None:
    ax.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "color": BLUE, "lw": 1.2})
    ax.text(*at, words, ha=side, va="center", color=BLUE)


def _span(ax: "Axes", ends: tuple[float, float], y: float, words: str) -> None:
    ax.annotate("", (ends[1], y), (ends[0], y), arrowprops={"arrowstyle": "<->", "color": BLACK, "lw": 0.8})
    ax.text(sum(ends) / 2, y + 0.08, words, ha="center", va="bottom")

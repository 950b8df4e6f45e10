"""A plot before it is decimated: curves at all their samples in SI, and what is written beside them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.units import from_si, interval_from_si
from tribopipe.browse.decimate import Points, Shown, Window, shown
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName
from tribopipe.results.evaluation import COVERAGE_FACTOR

Role = Literal["measured", "fit", "prediction", "drift", "wander", "residual"]


_COLOURED = ("archard", "sarkar")
"""Laws that have a colour of their own; others take the next that is free."""


@dataclass(frozen=True)
class Unit:
    """What numbers are in, and what they are shown in."""

    si: str
    shown: str


MICRONS, RATIO, VOLUME = Unit("m", "um"), Unit("1", "1"), Unit("m^3", "mm^3")


@dataclass(frozen=True)
class Curve:
    """One line: a value in SI at each place of an axis, which is in the unit it is shown in."""

    name: str
    role: Role
    x: Column
    y: Column
    unit: Unit
    run: str
    law: LawName | None = None
    lower: Column | None = None
    upper: Column | None = None
    """95 % band."""
    path: str | None = None
    """The dataset it was read from, if it is one as it stands."""


@dataclass(frozen=True)
class Mark:
    """A measured value with its 95 % interval, in the units that are shown."""

    name: str
    run: str
    x: float
    y: float
    half_width: float


@dataclass(frozen=True)
class Panel:
    """Curves on one vertical axis."""

    label: str
    curves: tuple[Curve, ...]
    marks: tuple[Mark, ...] = ()


@dataclass(frozen=True)
class Drawing:
    """A whole plot."""

    title: str
    words: str
    axis: str
    """Name of the horizontal axis."""
    axis_label: str
    panels: tuple[Panel, ...]


def mark(name: str, run: str, x: Column | float, value: Quantity | None, unit: Unit) -> tuple[Mark, ...]:
    """Mark a measured quantity at a place, or at the end of a run; nothing where it was not measured."""
    known = np.atleast_1d(x)[np.isfinite(np.atleast_1d(x))]
    if value is None or not known.size:
        return ()
    spread = COVERAGE_FACTOR * interval_from_si(value.standard_uncertainty or 0.0, unit.si, unit.shown)
    return (Mark(name, run, float(known[-1]), from_si(value.value, unit.si, unit.shown), spread),)


def plot_answer(name: str, drawing: Drawing, window: Window) -> dict[str, Any]:
    """Return a plot as the server answers it: what a window shows, in the units that people read."""
    axes = {id(curve.x): curve.x for panel in drawing.panels for curve in panel.curves}
    span = window.span(list(axes.values()))
    parts = {key: shown(x, span, window.width) for key, x in axes.items()}
    panels = [_panel(panel, parts, span) for panel in drawing.panels]
    return {
        "name": name,
        "title": drawing.title,
        "words": drawing.words,
        "x": {"name": drawing.axis, "label": drawing.axis_label, "from": span[0], "to": span[1]},
        "panels": panels,
        "samples": max((len(part.x) for part in parts.values()), default=0),
        "points": max(_lengths(panels), default=0),
    }


def _lengths(panels: Sequence[dict[str, Any]]) -> Iterator[int]:
    return (len(line["x"]) for panel in panels for line in panel["lines"])


def _panel(panel: Panel, parts: dict[int, Shown], span: tuple[float, float]) -> dict[str, Any]:
    return {
        "label": panel.label,
        "lines": [
            _line(curve, parts[id(curve.x)].thinned(curve.y, curve.lower, curve.upper)) for curve in panel.curves
        ],
        "marks": [one for one in panel.marks if span[0] <= one.x <= span[1]],
    }


def _line(curve: Curve, points: Points) -> dict[str, Any]:
    return {
        "name": curve.name,
        "run": curve.run,
        "role": curve.role,
        "law": curve.law if curve.law in _COLOURED else None,
        "x": np.ascontiguousarray(points.x, dtype=np.float64),
        "y": _drawn(points.y, curve.unit),
        "lower": None if points.lower is None else _drawn(points.lower, curve.unit),
        "upper": None if points.upper is None else _drawn(points.upper, curve.unit),
        "path": curve.path,
    }


def _drawn(values: Column, unit: Unit) -> Any:
    """Return values in the shown unit, in single precision: seven digits are more than a screen has."""
    return np.ascontiguousarray(from_si(values, unit.si, unit.shown), dtype=np.float32)

"""A plot as the web client gets it: decimated to what a window shows, in the units that people read."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.units import from_si
from tribopipe.browse.decimate import Points, Shown, Window, shown
from tribopipe.views.plot import Curve, Panel, Plot, Unit

_COLOURED = ("archard", "sarkar")
"""Laws with their own color; others take the next that is free."""


def plot_answer(name: str, plot: Plot, window: Window) -> dict[str, Any]:
    """Return a plot as the server answers it: what a window shows, in the units that people read."""
    axes = {id(curve.x): curve.x for panel in plot.panels for curve in panel.curves}
    span = window.span(list(axes.values()))
    parts = {key: shown(x, span, window.width) for key, x in axes.items()}
    panels = [_panel(panel, parts, span) for panel in plot.panels]
    return {
        "name": name,
        "title": plot.title,
        "words": plot.words,
        "x": {"name": plot.axis, "label": plot.axis_label, "from": span[0], "to": span[1]},
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

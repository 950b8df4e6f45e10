"""A plot as data: curves at all their samples in SI, bands and measured values, with the labels and units of its axes.

Figures (``tribopipe.views.run_figures``) and the web client's drawings are both made of it.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.units import KINDS, WEAR_COEFFICIENT, axis, force_unit, from_si, interval_from_si
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName
from tribopipe.documents.signals import SIGNALS, SignalName
from tribopipe.results.agreement import Role as RunRole
from tribopipe.results.agreement import Verdict
from tribopipe.results.evaluation import COVERAGE_FACTOR
from tribopipe.views.number_format import powered_axis

Role = Literal["measured", "fit", "prediction", "drift", "wander", "residual"]


@dataclass(frozen=True)
class Unit:
    """What numbers are in, and what they are shown in."""

    si: str
    shown: str


MICRONS, RATIO, VOLUME = Unit("m", "um"), Unit("1", "1"), Unit("m^3", "mm^3")
COEFFICIENT = Unit("m^2/N", WEAR_COEFFICIENT)
_AXES: dict[str, tuple[str, str]] = {
    "sliding_distance": ("sliding distance s", "m"),
    "time": ("time", "s"),
    "rotations": ("rotations of the crowned disc", "1"),
    "sample": ("sample", "1"),
    "friction": ("friction coefficient μ", "1"),
}
"""What plots are drawn against: in words, and the unit."""


def axis_label(name: str, power: int = 0) -> str:
    """Return how a horizontal axis is labeled whose numbers leave out a power of ten."""
    words, unit = _AXES[name]
    return powered_axis(words, power, unit)


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
    """The dataset it was read from, if it is one as it stands, or the name of the signal that it is."""
    series: int | None = None
    """Place among those that share a panel and differ by it, such as bodies or models; 0 for the usual one."""


@dataclass(frozen=True)
class Mark:
    """A measured value with its 95 % interval, in the units that are shown."""

    name: str
    run: str
    x: float
    y: float
    half_width: float
    """Of the 95 % interval."""
    value: str = ""
    """As people read it, with its standard uncertainty: "33.16 ± 0.30 µm (± u)"."""
    role: RunRole | None = None
    """Of the run in a study."""
    outcome: Verdict | None = None
    """Its agreement with the law that it is drawn with."""
    law: LawName | None = None
    """The law that it is a residual of."""


@dataclass(frozen=True)
class Panel:
    """Curves on one vertical axis."""

    quantity: str
    unit: Unit
    curves: tuple[Curve, ...]
    marks: tuple[Mark, ...] = ()
    body: str = ""
    """The body it is of, where each has a panel."""
    left_out: tuple[float, float] | None = None
    """Between which places nothing was fitted although it was measured."""
    limit: float | None = None
    """Between this and its negative lie 95 % of residuals."""

    @property
    def label(self) -> str:
        """What stands at the vertical axis where the panel has no heading."""
        return axis(f"{self.body}, {self.quantity}" if self.body else self.quantity, self.unit.shown)


@dataclass(frozen=True)
class Plot:
    """Panels on one horizontal axis, from the top."""

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
    half_width = COVERAGE_FACTOR * interval_from_si(value.standard_uncertainty or 0.0, unit.si, unit.shown)
    words = f"{value.shown(unit.shown)} (± u)" if value.standard_uncertainty else value.shown(unit.shown)
    return (Mark(name, run, float(known[-1]), from_si(value.value, unit.si, unit.shown), half_width, words),)


def signal_unit(name: SignalName, run: RunManifest) -> Unit:
    """Return the unit in which a signal is shown; of forces that of the normal load."""
    kind = KINDS[SIGNALS[name].kind]
    return Unit(kind.si, force_unit(run.conditions.normal_load.value) if kind.si == "N" else kind.shown)

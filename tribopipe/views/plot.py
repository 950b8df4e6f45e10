"""A plot as data: curves at all samples in SI units, bands and measured values, with labels, units and powers of ten.

Figures (``tribopipe.views.run_figures``) and the web client's drawings are both made of it.
"""

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.units import KINDS, WEAR_COEFFICIENT, axis, force_unit, from_si, interval_from_si, pretty
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName
from tribopipe.documents.signals import SIGNALS, SignalName
from tribopipe.results.evaluation import COVERAGE_FACTOR
from tribopipe.results.run import RawRun
from tribopipe.results.study import Role as RunRole
from tribopipe.results.study import Verdict


def power_of(largest: float) -> int:
    """Return the power of a thousand that leaves one to three digits before the decimal point."""
    return 3 * math.floor(math.log10(largest) / 3) if largest > 0 else 0


def powered(power: int, unit: str = "1") -> str:
    """Format a power of ten and a unit: 10⁻³ mm³."""
    return " ".join(part for part in (f"$10^{{{power}}}$" if power else "", pretty(unit)) if part)


def powered_axis(label: str, power: int, unit: str = "1") -> str:
    """Label an axis whose numbers omit a power of ten: "volume / 10⁻³ mm³"."""
    return f"{label} / {powered(power, unit)}" if powered(power, unit) else label


def coefficient_power(coefficient: Quantity) -> int:
    """Return the power of a thousand that leaves one to three digits of k_D before the decimal point."""
    return power_of(float(scaled_coefficient(coefficient.value, 0)))


def scaled_coefficient(values: Any, power: int) -> Any:
    """Return k_D, or its uncertainty, m²/N, in its display unit without the power of ten."""
    return from_si(values, "m^2/N", WEAR_COEFFICIENT) / 10.0**power


def coefficient_words(coefficient: Quantity, power: int | None = None) -> str:
    """Format k_D with its uncertainty: (13.5 ± 0.3)×10⁻⁹ mm³/(N·mm)."""
    power = coefficient_power(coefficient) if power is None else power
    spread = coefficient.standard_uncertainty
    number = Quantity(
        value=scaled_coefficient(coefficient.value, power),
        unit="1",
        standard_uncertainty=None if spread is None else scaled_coefficient(spread, power),
    )
    return f"({number})×{powered(power, WEAR_COEFFICIENT)}"


def slid(run: RawRun) -> str:
    """Label the axis of sliding distance, which for two discs is the slip distance."""
    contact = run.manifest.contact
    return axis(f"{'sliding distance' if contact is None else contact.slid} s", "m")


def turned(rotations: Column) -> tuple[Column, str]:
    """Return rotations without a power of a thousand, and the axis label that includes this power."""
    power = power_of(float(np.nanmax(rotations)))
    return rotations / 10.0**power, powered_axis("rotations of the crowned disc", power)


def course(run: RawRun) -> tuple[Column, str]:
    """Return the horizontal axis for wear and its label: sliding distance, or rotations of the crowned disc."""
    return turned(run.progress) if run.manifest.progress.kind == "count" else slide(run)


def slide(run: RawRun) -> tuple[Column, str]:
    """Return the horizontal axis for friction and its label: sliding distance, or time if distance is unknown."""
    known = run.origins["sliding_distance"] != "unknown"
    return (run.sliding_distance, slid(run)) if known else (run.columns["time"], axis("time", "s"))


Role = Literal["measured", "fit", "prediction", "drift", "wander", "residual"]


@dataclass(frozen=True)
class Unit:
    """Unit of stored and of displayed numbers."""

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
"""Names and units of horizontal axes."""


def axis_label(name: str, power: int = 0) -> str:
    """Return the label of a horizontal axis whose numbers omit a power of ten."""
    words, unit = _AXES[name]
    return powered_axis(words, power, unit)


@dataclass(frozen=True)
class Curve:
    """One curve: a value in SI units at each position of an axis, which is in its display unit."""

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
    """The dataset it was read from, if it is unchanged, or the name of its signal."""
    series: int | None = None
    """Index among the curves of a panel that differ in body or model; 0 for the default."""


@dataclass(frozen=True)
class Mark:
    """A measured value with its 95 % interval, in display units."""

    name: str
    run: str
    x: float
    y: float
    half_width: float
    """Ends of the 95 % interval."""
    value: str = ""
    """Displayed text with standard uncertainty: "33.16 ± 0.30 µm (± u)"."""
    role: RunRole | None = None
    """Role of the run in a study."""
    outcome: Verdict | None = None
    """Its agreement with the law shown with it."""
    law: LawName | None = None
    """The law of which it is a residual."""


@dataclass(frozen=True)
class Panel:
    """Curves with a common vertical axis."""

    quantity: str
    unit: Unit
    curves: tuple[Curve, ...]
    marks: tuple[Mark, ...] = ()
    body: str = ""
    """The body it shows, if each has a panel."""
    left_out: tuple[float, float] | None = None
    """Positions between which measured values were not fitted."""
    limit: float | None = None
    """Limit that contains 95 % of the residuals on both sides of zero."""

    @property
    def label(self) -> str:
        """Label of the vertical axis if the panel has no heading."""
        return axis(f"{self.body}, {self.quantity}" if self.body else self.quantity, self.unit.shown)


@dataclass(frozen=True)
class Plot:
    """Panels with a common horizontal axis, from the top."""

    title: str
    words: str
    axis: str
    """Name of the horizontal axis."""
    axis_label: str
    panels: tuple[Panel, ...]


def mark(name: str, run: str, x: Column | float, value: Quantity | None, unit: Unit) -> tuple[Mark, ...]:
    """Mark a measured quantity at a position, or at the end of a run; nothing if it was not measured."""
    known = np.atleast_1d(x)[np.isfinite(np.atleast_1d(x))]
    if value is None or not known.size:
        return ()
    half_width = COVERAGE_FACTOR * interval_from_si(value.u_or_zero, unit.si, unit.shown)
    words = f"{value.shown(unit.shown)} (± u)" if value.standard_uncertainty else value.shown(unit.shown)
    return (Mark(name, run, float(known[-1]), from_si(value.value, unit.si, unit.shown), half_width, words),)


def signal_unit(name: SignalName, run: RunManifest) -> Unit:
    """Return the unit in which a signal is shown; for forces, that of the normal load."""
    kind = KINDS[SIGNALS[name].kind]
    return Unit(kind.si, force_unit(run.conditions.normal_load.value) if kind.si == "N" else kind.shown)

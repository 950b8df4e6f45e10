"""Numbers along the axes of figures: powers of a thousand, wear coefficients, rotations."""

import math
from typing import Any

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.units import WEAR_COEFFICIENT, axis, from_si, pretty
from tribopipe.documents.quantity import Quantity
from tribopipe.results.run import RawRun


def power_of(largest: float) -> int:
    """Return the power of a thousand in which a number reads with one to three digits before the point."""
    return 3 * math.floor(math.log10(largest) / 3) if largest > 0 else 0


def powered(power: int, unit: str = "1") -> str:
    """Write a power of ten and a unit as people read them: 10⁻³ mm³."""
    return " ".join(part for part in (f"$10^{{{power}}}$" if power else "", pretty(unit)) if part)


def powered_axis(label: str, power: int, unit: str = "1") -> str:
    """Label an axis whose numbers leave out a power of ten: "volume / 10⁻³ mm³"."""
    return f"{label} / {powered(power, unit)}" if powered(power, unit) else label


def coefficient_power(coefficient: Quantity) -> int:
    """Return the power of a thousand in which k_D reads as a number of one to three digits."""
    return power_of(float(scaled_coefficient(coefficient.value, 0)))


def scaled_coefficient(values: Any, power: int) -> Any:
    """Return k_D, or its uncertainty, m²/N, in the power of its usual unit that it is written with."""
    return from_si(values, "m^2/N", WEAR_COEFFICIENT) / 10.0**power


def coefficient_words(coefficient: Quantity, power: int | None = None) -> str:
    """Write k_D with its uncertainty: (13.5 ± 0.3)×10⁻⁹ mm³/(N·mm)."""
    power = coefficient_power(coefficient) if power is None else power
    spread = coefficient.standard_uncertainty
    number = Quantity(
        value=scaled_coefficient(coefficient.value, power),
        unit="1",
        standard_uncertainty=None if spread is None else scaled_coefficient(spread, power),
    )
    return f"({number})×{powered(power, WEAR_COEFFICIENT)}"


def slid(run: RawRun) -> str:
    """Label the axis of sliding distance, which for two discs is that of their slip."""
    contact = run.manifest.contact
    return axis(f"{'sliding distance' if contact is None else contact.slid} s", "m")


def turned(rotations: Column) -> tuple[Column, str]:
    """Return rotations without a power of a thousand, and the label of an axis that has it."""
    power = power_of(float(np.nanmax(rotations)))
    return rotations / 10.0**power, powered_axis("rotations of the crowned disc", power)


def course(run: RawRun) -> tuple[Column, str]:
    """Return what wear is drawn against, and its label: sliding distance, or rotations of the crowned disc."""
    return turned(run.progress) if run.manifest.progress.kind == "count" else slide(run)


def slide(run: RawRun) -> tuple[Column, str]:
    """Return what friction is drawn against, and its label: sliding distance, or time where nothing shows distance."""
    known = run.origins["sliding_distance"] != "unknown"
    return (run.sliding_distance, slid(run)) if known else (run.columns["time"], axis("time", "s"))

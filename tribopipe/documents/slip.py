"""Slip of two discs."""

import math

from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.quantity import Quantity


def slip(manifest: RunManifest) -> Quantity:
    """Return (v₂ − v₁)/v₁ of a twin-disc run; its uncertainty is that stated, or follows from those of both speeds."""
    conditions = manifest.conditions
    stated, curved, flat = conditions.slip, conditions.curved_disc_speed, conditions.flat_disc_speed
    if stated is not None or curved is None or flat is None:
        return stated or Quantity(value=0.0, unit="1")
    ratio, spread = flat.value / curved.value, None
    if curved.standard_uncertainty is not None and flat.standard_uncertainty is not None:
        spread = ratio * math.hypot(curved.standard_uncertainty / curved.value, flat.standard_uncertainty / flat.value)
    return Quantity(value=ratio - 1, unit="1", standard_uncertainty=spread)


def stated_slip(manifest: RunManifest) -> Quantity | None:
    """Return the slip of bodies that roll on each other; None for others."""
    return slip(manifest) if manifest.rolls else None


def slip_per_rotation(manifest: RunManifest) -> float:
    """Return the slip distance 2π·r₁·|slip| in one rotation of the unworn crowned disc, m."""
    return 2 * math.pi * manifest.twin_disc.curved_disc.rolling_radius.value * abs(slip(manifest).value)

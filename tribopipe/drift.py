"""Linear drift of the depth sensor, anchored on what was measured after the test.

The paper (Section 2) assumes that the capacitive sensor drifts linearly and matches its curve at the largest sliding
distance to the wear found on the pin. Here:

    wear(t) = g·(reading(t) − z) − ρ·(t − t₀),     ρ = (g·(reading(t_end) − z) − h_end) / (t_end − t₀)

with g the sensor's scale (1 unless run.toml says otherwise), the zero offset z at the start t₀ of sliding and h_end the
wear of pin plus disc, or of both discs, by the end values. z is the intercept of a fit z + q·h(s) to the first samples,
with h(s) the wear of a pin, or of two discs, that reaches the end value at the end, so that wear within the window is
not taken for offset. The end reading is the value at the end of sliding of a straight line through the last samples.
"""

import math
from dataclasses import dataclass

import numpy as np

from tribopipe.contact.pin_on_disc import pin_contact
from tribopipe.contact.twin_disc import disc_pair, nominal_values
from tribopipe.end_values.pin_on_disc import EndWear, end_wear
from tribopipe.end_values.twin_disc import DiscEndWear, disc_end_wear
from tribopipe.errors import FitError
from tribopipe.noise import inflation, left_of
from tribopipe.records.manifest import TwinDisc
from tribopipe.records.quantity import Quantity
from tribopipe.records.recipe import Recipe
from tribopipe.records.results import DriftCorrection
from tribopipe.run import Column, CorrectedRun, Numbers, RawRun

_FEWEST_IN_WINDOW = 8
_LEAST_WEAR = 1e-9
"""Depth, m, whose shape serves where none was measured."""


@dataclass(frozen=True)
class SensorTrace:
    """The depth reading and what the correction takes from it."""

    reading: Column
    ramp: Column
    """0 at the start of sliding, 1 at the last sample."""
    duration: float
    slid: float
    """Sliding distance at the end of the run, m, whether or not depth was still recorded there."""
    zero_offset: Quantity
    end_reading: Quantity

    def wear(self, end_wear: Numbers, zero: Numbers, end: Numbers, scale: Numbers) -> Column:
        """Return the corrected depth, m, for an end value, zero offset, end reading (m) and scale of the sensor."""
        return np.asarray(scale * (self.reading - zero - self.ramp * (end - zero)) + self.ramp * end_wear)


def read_trace(run: RawRun, end: EndWear | DiscEndWear, recipe: Recipe) -> SensorTrace:
    """Take zero offset and end reading from the depth signal of a run with this wear at its end.

    Raises ``FitError`` where fewer than 16 samples of depth are left.
    """
    placed = np.isfinite(run.sliding_distance) & np.isfinite(run.columns["time"])
    distance, time, reading = run.sliding_distance, run.columns["time"], run.columns["depth"]
    seen = placed & np.isfinite(reading)
    if np.count_nonzero(seen) < 2 * _FEWEST_IN_WINDOW:
        raise FitError(
            f"{run.id}: found {np.count_nonzero(seen)} samples of depth; expected at least {2 * _FEWEST_IN_WINDOW} for "
            "a drift correction; record at a higher rate"
        )
    start, duration = _sliding_time(distance[placed], time[placed])
    slid = float(distance[placed][-1])
    share = np.maximum(distance[seen], 0.0) / slid
    wear = _pin_wear(run, end, share) if isinstance(end, EndWear) else _disc_wear(run, end, share, recipe)
    zero, last = _ends(distance[seen], reading[seen], wear, slid, recipe.drift.window)
    return SensorTrace(
        reading=reading,
        ramp=(time - start) / duration,
        duration=duration,
        slid=slid,
        zero_offset=zero,
        end_reading=last,
    )


def _pin_wear(run: RawRun, end: EndWear, share: Column) -> Column:
    """Return the wear depth of a pin that reaches its end value at the end, m, against the share of the distance."""
    contact = run.manifest.pin_on_disc
    nominal = {
        "normal_load": run.manifest.conditions.normal_load.value,
        "pin_radius": contact.pin.radius.value,
        "pin_modulus": contact.pin.youngs_modulus.value,
        "disc_modulus": contact.disc.youngs_modulus.value,
    }
    pin = pin_contact(contact, nominal)
    return pin.worn(pin.volume(max(end.pin_depth.value, _LEAST_WEAR)) * share).depth


def _disc_wear(run: RawRun, end: DiscEndWear, share: Column, recipe: Recipe) -> Column:
    """Return the wear depth of two discs that reach their end value at the end, m, against the share of the rotations.

    As if the curved one alone wore: how wear is shared changes next to nothing of the shape of its sum.
    """
    discs = disc_pair(run.manifest.twin_disc, nominal_values(run.manifest), recipe.wear.distance_per_rotation)
    rotations = discs.rotations(max(end.total.value, _LEAST_WEAR), 1.0)
    return discs.worn(rotations * share, 1.0).curved_depth


def _ends(s: Column, y: Column, wear: Column, slid: float, share: float) -> tuple[Quantity, Quantity]:
    """Return the reading at the start of sliding and after the whole distance ``slid``, m."""
    noise = _noise(np.stack([np.ones_like(s), wear, s]), y)
    window = share * (s[-1] - s[0])
    first = max(_FEWEST_IN_WINDOW, int(np.searchsorted(s, s[0] + window, side="right")))
    last = min(len(s) - _FEWEST_IN_WINDOW, int(np.searchsorted(s, s[-1] - window)))
    return _intercept(wear[:first], y[:first], noise), _intercept(s[last:] - slid, y[last:], noise)


def _noise(smooth: Column, reading: Column) -> float:
    """Return the variance of the sensor's noise times its autocorrelation time, about a smooth curve, m².

    From the whole run: a window at its end holds too few independent samples to tell.
    """
    left, _ = left_of(reading, smooth)
    return inflation(left, len(smooth))


def _intercept(x: Column, y: Column, noise: float) -> Quantity:
    # Wear is micrometres: in units of its own largest value it weighs as much as the offset.
    design = np.column_stack([np.ones_like(x), x / np.max(np.abs(x))])
    (value, _), *_ = np.linalg.lstsq(design, y, rcond=None)
    variance = noise * float(np.linalg.pinv(design.T @ design)[0, 0])
    return Quantity(value=float(value), unit="m", standard_uncertainty=math.sqrt(max(0.0, variance)))


def _sliding_time(distance: Column, time: Column) -> tuple[float, float]:
    """Return when sliding began, by the mean speed, and how long it lasted until the last sample."""
    if not distance[-1] > distance[0] or not time[-1] > time[0]:
        raise FitError(
            "drift correction: found no sliding between first and last sample of depth; expected time and "
            "sliding distance to grow; check both columns"
        )
    start = time[0] - distance[0] * (time[-1] - time[0]) / (distance[-1] - distance[0])
    return float(start), float(time[-1] - start)


def correct_drift(run: RawRun, recipe: Recipe | None = None) -> CorrectedRun:
    """Take the linear drift off a run's depth, m.

    A run without depth or without an end value passes through, and its correction says what it lacks.
    """
    recipe = recipe or Recipe()
    manifest = run.manifest
    end: EndWear | DiscEndWear | None
    if isinstance(manifest.contact, TwinDisc):
        end, needed = disc_end_wear(run, recipe), "an end value of the curved disc (depth, track width or volume)"
    elif manifest.contact is None:
        end, needed = None, "the two bodies ([contact])"
    else:
        end = end_wear(run, recipe.uncertainty)
        needed = "an end value of the pin (its depth, scar, volume, mass or profile)"
    lacks = [] if "depth" in run.columns else ["a depth signal"]
    if end is None:
        lacks.append(needed)
    if end is None or lacks:
        return CorrectedRun(run, DriftCorrection(outcome="uncorrected", lacks=tuple(lacks)), None)
    trace, scale = read_trace(run, end, recipe), run.manifest.sensors.depth_scale.value
    wear = trace.wear(end.total.value, trace.zero_offset.value, trace.end_reading.value, scale)
    return CorrectedRun(run, _describe(trace, end, scale, recipe), wear)


def _describe(trace: SensorTrace, end: EndWear | DiscEndWear, scale: float, recipe: Recipe) -> DriftCorrection:
    gap = scale * (trace.end_reading.value - trace.zero_offset.value) - end.total.value
    spread = math.hypot(
        *(part.standard_uncertainty or 0.0 for part in (end.total, trace.zero_offset, trace.end_reading))
    )
    return DriftCorrection(
        outcome="corrected",
        anchor=end.anchor,
        zero_offset=trace.zero_offset,
        drift_rate=Quantity(value=gap / trace.duration, unit="m/s", standard_uncertainty=spread / trace.duration),
        discrepancy=Quantity(value=gap, unit="m", standard_uncertainty=spread),
        within_discrepancy_limit=abs(gap) <= recipe.drift.discrepancy_limit.value,
        within_sensor_resolution=abs(gap) <= recipe.drift.sensor_resolution.value,
        end_wear_depth=end.total,
        pin_wear_depth=end.pin_depth if isinstance(end, EndWear) else None,
        disc_wear_depth=end.disc.quantity if isinstance(end, EndWear) and end.disc else None,
    )

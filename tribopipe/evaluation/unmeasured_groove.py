"""The groove next to a pin that was measured, where nobody measured the counterbody: by the depth signal of the test.

The sensor shows the wear of both bodies, D = h_p + h_d, and h_p was measured, so that D has the course of both as they
wear together. It is fitted next to a drift ten times as large as expected of a sensor. The groove is taken
for one where it is larger than that, where the course alone, next to a drift of any size, agrees, and where all else
in the signal is small next to it. In any other case it could be drift, and the measurement of the pin alone gives k_D.
"""

import math
from dataclasses import replace

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe
from tribopipe.evaluation.depth_reading import DepthRecord, Groove, best_pin, depth_record, sensor_scale
from tribopipe.evaluation.measurements.kinds import end_wear
from tribopipe.physics.depth_model.posterior import DepthPosterior, depth_posterior
from tribopipe.physics.pin_on_disc import PinContact
from tribopipe.results.run import RawRun

_CERTAIN = 3.0
"""Standard uncertainties from which on wear of one body in the depth of both is distinguished from none."""
_LEAST_PART = 0.2
"""Its part in what the sensor shows from which on a drift beyond all expectation would be noticed elsewhere, too."""
_BEYOND_DRIFT = 10.0
"""By how much more a sensor may drift than is expected of it."""
_MOST_PASSES, _NEARLY = 4, 0.01
"""Passes, and the share of the pin's depth that the last one changes."""
_UNWORN = Quantity(value=0.0, unit="m", standard_uncertainty=0.0)


def is_shown(part: Quantity, other: Quantity) -> bool:
    """Return whether the wear depth of one body is shown by the depth signal of both, and is no drift or error."""
    certain = part.value > _CERTAIN * part.u_or_zero
    return certain and part.value > _LEAST_PART * (part.value + other.value)


def wear_of_both(run: RawRun, recipe: Recipe) -> Quantity | None:
    """Return the wear depth of both bodies by the depth signal of a run, m; None where it shows no groove.

    Parameters
    ----------
    run
        With a depth signal, and a measurement of the pin alone.
    recipe
        Prior of the drift, and default uncertainties.

    Returns
    -------
    Quantity or None
        D at the end, m.
    """
    end = end_wear(run, recipe.uncertainty)
    if end is None or end.disc is not None or not end.tip.widens:
        return None
    record, pin = depth_record(run), best_pin(run, end, recipe)
    depth = end.pin_depth
    found = _told(run, record, pin, Groove(end.tip, _UNWORN, depth.value), recipe)
    for _ in range(_MOST_PASSES):
        # In a groove, a scar of the same mean diameter is that of less wear.
        end = None if found is None else end_wear(run, recipe.uncertainty, approach=found)
        if found is None or end is None:
            return None
        before, depth = depth, end.pin_depth
        if abs(depth.value - before.value) < _NEARLY * depth.value:
            break
        found = _told(run, record, pin, Groove(end.tip, _UNWORN, depth.value), recipe)
    return found if found is not None and is_shown(_beyond(found, depth), depth) else None


def _told(run: RawRun, record: DepthRecord, pin: PinContact, beside: Groove, recipe: Recipe) -> Quantity | None:
    """Return the wear depth of both bodies, m, where that of the pin is as measured; None without a clear groove."""
    measured, prior = beside.pin_depth or 0.0, recipe.drift.prior.value
    if not measured > 0 or _read(record) - measured < _BEYOND_DRIFT * prior:
        return None
    wide, free = (_posterior(record, pin, beside, drift) for drift in (_BEYOND_DRIFT * prior, None))
    depth, spread = wide.alone
    least = min(depth, free.alone[0]) - measured
    if least < max(_BEYOND_DRIFT * prior, wide.range_beyond_line / _LEAST_PART):
        return None
    scale = sensor_scale(run, recipe)
    spread = math.hypot(spread, depth * scale.u_or_zero / scale.value)
    return Quantity(value=depth, unit="m", standard_uncertainty=spread)


def _beyond(both: Quantity, pin: Quantity) -> Quantity:
    spread = math.hypot(both.u_or_zero, pin.u_or_zero)
    return Quantity(value=both.value - pin.value, unit="m", standard_uncertainty=spread)


def _posterior(record: DepthRecord, pin: PinContact, beside: Groove, drift: float | None) -> DepthPosterior:
    """Return the posterior of D where the drift over the test has a standard deviation, m, or any size."""
    samples, measured = record.samples, beside.pin_depth or 0.0
    most = float(beside.tip.on_track(beside.tip.radius).most)
    guess = min(max(_read(record), (1 + _LEAST_PART) * measured), most)
    groove = _deep(beside, guess - measured)

    def course(both: float, distance: Column) -> Column:
        return _course(pin, _deep(beside, both - measured), both, distance / record.slid)

    def of_pin(_: float, distance: Column) -> Column:
        return _beside(groove, pin, distance / record.slid)

    _, by_another_course = groove.terms(samples, of_pin, in_course=True)
    return depth_posterior(
        samples.reading(course, (), drift_deviation=drift, known=(by_another_course,), guess=guess, most=most)
    )


def _read(record: DepthRecord) -> float:
    """Return the range of the depth signal, m."""
    return float(np.ptp(record.samples.blocks.mean(record.samples.depth)))


def _deep(groove: Groove, depth: float) -> Groove:
    return replace(groove, measured=_UNWORN.model_copy(update={"value": max(depth, 0.0)}))


def _course(pin: PinContact, groove: Groove, both: float, worn: Column) -> Column:
    """Return the depth of both bodies, m, where these shares of the pin's volume are worn; ``both`` at the end."""
    measured, depth = groove.pin_depth or 0.0, _beside(groove, pin, worn)
    if both <= measured:
        return depth * (both / measured)
    return depth + groove.measured.value * groove.share(depth, measured)


def _beside(groove: Groove, pin: PinContact, worn: Column) -> Column:
    """Return the depth of a pin next to a groove, m, for these shares of the volume at its measured depth."""
    measured = groove.pin_depth or 0.0
    return groove.deepened(pin.worn(pin.volume(measured) * worn).depth, worn, measured)

"""The groove beside a pin that was measured, where nobody measured the counterbody: by the depth signal of the test.

The sensor shows the wear of both bodies, D = h_p + h_d, and h_p was measured, so that D has the course of both as they
wear beside each other. It is fitted next to a drift of any rate: a straight line is no groove. The groove is taken
for one where it is far more than a sensor drifts, whichever drift is allowed for, and where nothing but wear, a line
and noise is in the signal. In any other case it could be drift, and the measurement of the pin alone gives k_D.
"""

import math
from functools import partial

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe
from tribopipe.evaluation.depth_reading import DECISIVE, DepthRecord, Groove, best_pin, depth_record, sensor_scale
from tribopipe.evaluation.measurements.pin_on_disc import EndWear
from tribopipe.physics.depth_model.posterior import DepthPosterior, depth_posterior
from tribopipe.physics.pin_on_disc import PinContact
from tribopipe.results.run import RawRun

CERTAIN = 3.0
"""Standard uncertainties from which on wear of one body in the depth of both is distinguished from none."""
LEAST_PART = 0.2
"""Its part in what the sensor shows from which on a drift beyond all expectation would be noticed elsewhere, too."""
_BEYOND_DRIFT = 10.0
"""Standard deviations of the drift that is expected of a sensor beyond which none reaches by its own."""


def is_shown(part: Quantity, other: Quantity) -> bool:
    """Return whether the wear depth of one body is shown by the depth signal of both, and is no drift or error."""
    certain = part.value > CERTAIN * (part.standard_uncertainty or 0.0)
    return certain and part.value > LEAST_PART * (part.value + other.value)


def wear_of_both(run: RawRun, end: EndWear, recipe: Recipe) -> Quantity | None:
    """Return the wear depth of both bodies by the depth signal of a run, m; None where it shows no groove.

    Parameters
    ----------
    run
        With a depth signal.
    end
        What was measured on the pin after the test.
    recipe
        Prior of the drift, and default uncertainties.

    Returns
    -------
    Quantity or None
        D at the end, m.
    """
    if end.disc is not None or not end.tip.widens or not end.pin_depth.value > 0:
        return None
    record, pin = depth_record(run), best_pin(run, end, recipe)
    prior = recipe.drift.prior.value
    free, expected = (_posterior(record, pin, end, drift) for drift in (None, prior))
    if free.log_odds > DECISIVE or expected.alone[0] - end.pin_depth.value < _BEYOND_DRIFT * prior:
        return None
    depth, spread = free.alone
    if abs(depth - expected.alone[0]) > CERTAIN * spread:
        return None
    scale = sensor_scale(run, recipe)
    spread = math.hypot(spread, depth * (scale.standard_uncertainty or 0.0) / scale.value)
    both = Quantity(value=depth, unit="m", standard_uncertainty=spread)
    return both if is_shown(_beyond(both, end.pin_depth), end.pin_depth) else None


def _beyond(both: Quantity, pin: Quantity) -> Quantity:
    spread = math.hypot(both.standard_uncertainty or 0.0, pin.standard_uncertainty or 0.0)
    return Quantity(value=both.value - pin.value, unit="m", standard_uncertainty=spread)


def _posterior(record: DepthRecord, pin: PinContact, end: EndWear, drift: float | None) -> DepthPosterior:
    """Return the posterior of D, the drift being of any rate or of an expected size over the test, m."""
    samples, most, measured = record.samples, float(end.tip.on_track(end.tip.radius).most), end.pin_depth.value
    read = float(np.ptp(samples.blocks.mean(samples.depth)))
    guess = min(max(read, (1 + LEAST_PART) * measured), most)
    groove = _groove(end, guess)

    def of_pin(_: float, distance: Column) -> Column:
        return _beside(groove, pin, measured, distance / record.slid)

    _, by_another_course = groove.terms(samples, of_pin, in_course=True)
    return depth_posterior(
        samples.reading(
            partial(_course, pin, end, record.slid),
            (),
            drift_deviation=drift,
            known=(by_another_course,),
            guess=guess,
            most=most,
        )
    )


def _groove(end: EndWear, both: float) -> Groove:
    depth = max(both - end.pin_depth.value, 0.0)
    return Groove(end.tip, Quantity(value=depth, unit="m", standard_uncertainty=0.0), end.pin_depth.value)


def _course(pin: PinContact, end: EndWear, slid: float, both: float, distance: Column) -> Column:
    """Return the depth of both bodies along a test at whose end it is ``both``, m."""
    measured, groove = end.pin_depth.value, _groove(end, both)
    depth = _beside(groove, pin, measured, distance / slid)
    if both <= measured:
        return depth * (both / measured)
    return depth + groove.measured.value * groove.share(depth, measured)


def _beside(groove: Groove, pin: PinContact, measured: float, worn: Column) -> Column:
    """Return the depth of a pin beside a groove, m, where these shares of the volume at its measured depth are worn."""
    return groove.deepened(pin.worn(pin.volume(measured) * worn).depth, worn, measured)

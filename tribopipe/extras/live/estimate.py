"""The state of a running test: k_D, the wear now and at the planned end, and the drift, with intervals."""

import math

from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName
from tribopipe.documents.record import Record
from tribopipe.extras.live.posterior import Posterior
from tribopipe.physics.uncertainty import Distribution

Interval = tuple[Quantity, Quantity]


class Estimate(Record):
    """The samples so far, judged by a wear law; intervals are of 95 %."""

    law: LawName
    """Wear law."""
    sliding_distance: Quantity
    """How far the run has come."""
    wear_coefficient: Quantity
    """k_D by least squares; 0 where no wear fits best."""
    interval: Interval
    """Of k_D."""
    wear_depth: Quantity
    """Wear of the pin by now."""
    wear_depth_interval: Interval
    """Of the wear by now."""
    planned_distance: Quantity | None = None
    """Where the test is to end; none where it is not stated."""
    predicted_depth: Quantity | None = None
    """Wear of the pin at the planned end."""
    predicted_interval: Interval | None = None
    """Of the wear at the planned end."""
    drift_rate: Quantity
    """Slope against time of what the sensor reads in addition to wear."""
    finished: bool
    """Whether the wear at the end was measured, so that this is the joint fit of the whole run."""


def estimated(found: Posterior, law: LawName, planned: float | None) -> Estimate:
    """Report what the samples so far show."""
    problem = found.problem
    slid, duration = problem.trace.slid, problem.trace.duration
    best = math.exp(found.best)
    k, now = Distribution(found.coefficient), Distribution(found.depth(slid))
    ahead = None if planned is None else Distribution(found.depth(planned))
    drift, spread = found.drift()
    return Estimate(
        law=law,
        sliding_distance=_metres(slid),
        wear_coefficient=Quantity(value=best, unit="m^2/N", standard_uncertainty=k.standard_uncertainty),
        interval=_interval(k, "m^2/N"),
        wear_depth=_of(now),
        wear_depth_interval=_interval(now, "m"),
        planned_distance=None if planned is None else _metres(planned),
        predicted_depth=None if ahead is None else _of(ahead),
        predicted_interval=None if ahead is None else _interval(ahead, "m"),
        drift_rate=Quantity(value=drift / duration, unit="m/s", standard_uncertainty=spread / duration),
        finished=problem.finished,
    )


def _metres(value: float) -> Quantity:
    return Quantity(value=value, unit="m")


def _of(drawn: Distribution) -> Quantity:
    return Quantity(value=drawn.mean, unit="m", standard_uncertainty=drawn.standard_uncertainty)


def _interval(drawn: Distribution, unit: str) -> Interval:
    low, high = drawn.interval
    return Quantity(value=low, unit=unit), Quantity(value=high, unit=unit)

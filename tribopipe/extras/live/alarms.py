"""Alarms of a running test: constant sensor signal, lost load, jump in friction, departure from the wear law.

The wear law is watched by the CUSUM of recursive residuals. The test is divided into blocks of equal distance. Each
block's mean is predicted by the law with zero offset, drift and k_D fitted to the blocks before it; what it differs
by, over what that may differ by, is its recursive residual. As long as the law holds these are independent and of unit
variance, so that their sum W_j crosses

±a·(√n + 2·j/√n), a = 1.143

at any of the n blocks of the whole test in 1 % of tests (R. L. Brown, J. Durbin, J. M. Evans, Journal of the Royal
Statistical Society B 37 (1975) 149). Wear that changes, a drift that bends and a sensor that slips all show; which of
them it is, the sum does not show.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.units import WEAR_COEFFICIENT, show, show_force
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.quantity import Quantity, wear_coefficient
from tribopipe.documents.record import Record
from tribopipe.evaluation.depth_reading import remountings
from tribopipe.extras.live.estimate import Posterior
from tribopipe.extras.live.problem import mean_distance
from tribopipe.extras.live.state import Means, State

AlarmKind = Literal["law", "sensor", "load", "nominal load", "friction", "stalled", "replaced", "counterbody", "drift"]


class Alarm(Record):
    """Something amiss with a run that goes on."""

    kind: AlarmKind
    """Kind of alarm; only the first of each kind is reported."""
    sliding_distance: Quantity | None = None
    """Sliding distance at which it was noticed."""
    message: str
    """One sentence on what was found, and what to look at."""

    def __str__(self) -> str:
        return self.message


def alarm_at(kind: AlarmKind, distance: float, message: str) -> Alarm:
    """Return an alarm at a sliding distance, m."""
    return Alarm(kind=kind, sliding_distance=Quantity(value=distance, unit="m"), message=message)


_STILL = 100
"""Samples all the same after which a sensor may be stuck."""
_LONGER = 20
"""Times as long as ever before."""
_CHANGES = 20
"""Changes of a reading by which it is known how often it changes."""
_LOAD_OFF = 0.2
"""Relative difference of a block's load from the nominal one."""
_CLEARLY, _USUALLY_OFF = 3.0, 0.02
"""Standard uncertainties of the nominal load, and share of it, by which the median load differs."""
_FRICTION_JUMP = 0.5
"""Relative difference of a block's friction from that of the blocks before it."""
_LEAST_JUMP = 0.05
_BEFORE = 3
"""Blocks to which one is held: friction that runs in changes less from one to the next."""


class StuckSensor:
    """Duration of a constant depth signal."""

    def __init__(self) -> None:
        self._last = np.nan
        self._same = self._longest = self._changes = 0
        self._since = 0.0

    def add(self, depth: Column, distance: Column) -> None:
        """See samples of the reading, m, at sliding distances, m."""
        seen = np.isfinite(depth)
        depth, distance = depth[seen], distance[seen]
        if not len(depth):
            return
        changes = np.flatnonzero(np.diff(depth, prepend=self._last))
        if len(changes):
            ended = np.diff(changes, prepend=-self._same)
            self._longest = max(self._longest, int(ended.max()))
            self._since, self._same = float(distance[changes[-1]]), -int(changes[-1])
        self._same += len(depth)
        self._changes += len(changes)
        self._last = float(depth[-1])

    def alarms(self) -> Iterator[Alarm]:
        """Report that the sensor stands still."""
        if self._changes > _CHANGES and self._same > max(_STILL, _LONGER * self._longest):
            shown = Quantity(value=self._last, unit="m").shown("um")
            yield alarm_at(
                "sensor",
                self._since,
                f"the depth signal has been exactly {shown} since {show(self._since, None, 'm')} ({self._same} "
                "samples): the sensor is at the end of its range, or its channel is dead",
            )


def load_alarms(means: Means, nominal: float, spread: float) -> Iterator[Alarm]:
    """Report where the measured load is not the nominal one, N, with its standard uncertainty, and if it never is.

    The first block may be the loading ramp.
    """
    load, distance = means.load[1:], means.sliding_distance[1:]
    stated, usual = show_force(nominal, None), _usual(load)
    for off in np.flatnonzero(np.abs(load - nominal) > _LOAD_OFF * nominal)[:1]:
        yield alarm_at(
            "load",
            float(distance[off]),
            f"found a load of {show_force(float(load[off]), None)} at {show(float(distance[off]), None, 'm')}, "
            f"although the nominal load is {stated}: the weight was removed, or the load cell is faulty",
        )
    if abs(usual - nominal) > max(_CLEARLY * spread, _USUALLY_OFF * nominal):
        yield alarm_at(
            "nominal load",
            float(distance[-1]),
            f"found a median load of {show_force(usual, None)}, although the nominal load is {stated}; k_D is "
            "calculated with the measured load: correct conditions.normal_load, or check the unit and zero of the "
            "load cell",
        )


def _usual(load: Column) -> float:
    """Return the median of the loads that are known; NaN without any."""
    known = load[np.isfinite(load)]
    return float(np.median(known)) if len(known) else math.nan


def friction_alarms(means: Means) -> Iterator[Alarm]:
    """Report where friction jumps."""
    mu = means.friction
    if len(mu) <= _BEFORE:
        return
    before = np.convolve(mu, np.full(_BEFORE, 1 / _BEFORE), "valid")[:-1]
    after = mu[_BEFORE:]
    for jump in np.flatnonzero(np.abs(after - before) > np.maximum(_FRICTION_JUMP * before, _LEAST_JUMP))[:1]:
        distance = float(means.sliding_distance[_BEFORE + jump])
        yield alarm_at(
            "friction",
            distance,
            f"friction changed from {before[jump]:.2g} to {after[jump]:.2g} at {show(distance, None, 'm')}: check the "
            "contact, the lubricant and the load",
        )


def counterbody_alarms(found: Posterior) -> Iterator[Alarm]:
    """Report a drift that is more than a sensor has, and whether it may be wear of the counterbody."""
    both, problem = found.both_worn, found.problem
    if not found.excess_drift or problem.contact.sliding_tip.constant_area or (both is None and problem.finished):
        return
    slid, (expected, spread) = problem.trace.slid, problem.plausible_drift
    plausible = Quantity(value=expected, unit="m", standard_uncertainty=spread).shown("nm")
    drift = f"found a linear drift of {_microns(found.drift()[0])} by {show(slid, None, 'm')}, where a sensor has "
    if both is None:
        what = "the sign of the depth signal" if found.excess_drift < 0 else "the sensor"
        remedy = f"check {what}, and for thermal drift and a standstill before the test"
        yield alarm_at("drift", slid, f"{drift}{plausible}: {remedy}")
        return
    body = problem.contact.counterbody_name().replace("_", " ")
    alone, beside = (wear_coefficient(k).shown(WEAR_COEFFICIENT) for k in (math.exp(found.centre), both.coefficient))
    yield alarm_at(
        "counterbody",
        slid,
        f"{drift}{plausible}: the {body} may be wearing; k_D would be {beside} with "
        f"{_microns(both.depths(slid)[1])} wear of the {body}, and "
        f"{alone} without; measure the wear of the {body} after the test",
    )


def _microns(depth: float) -> str:
    return Quantity(value=depth, unit="m").shown("um")


BLOCKS = 100
"""Number of blocks into which a test is divided."""
_BOUND = 1.143
"""a of the bound that 1 % of sound tests cross."""
_FEWEST_BLOCKS = 10
_SINGULAR = 1e-9


@dataclass(frozen=True)
class Departure:
    """Departure of a run from its wear law."""

    noticed: float
    """Sliding distance, m, at which it was sure."""
    since: float
    """Sliding distance, m, from which on the residuals are farthest from those of a law that holds."""
    deeper: bool
    """True if the depth signal is deeper than predicted."""

    @property
    def alarm(self) -> Alarm:
        """Return the warning."""
        where = "deeper" if self.deeper else "shallower"
        return alarm_at(
            "law",
            self.noticed,
            f"the depth signal has deviated from the wear law since about {show(self.since, None, 'm')}, {where} than "
            "predicted from the earlier signal: the wear rate has changed, the counterbody wears, or the drift is not "
            "steady",
        )


def blocks(state: State, planned: float) -> Means:
    """Return means over the blocks of a test that are whole by now, up to a planned distance, m."""
    number = np.floor(state.means.sliding_distance / planned * BLOCKS)
    found = state.pooled(number)
    return found[: len(found) - 1]


def departure(found: Posterior, manifest: RunManifest, state: State, planned: float) -> Departure | None:
    """Return where a run left the law; None if it follows it, or is too short to show."""
    means = blocks(state, planned)
    if not found.shows_wear or len(means) < _FEWEST_BLOCKS:
        return None
    design, measured = _linear(found, manifest, means)
    # Taken for smaller than it is, the noise would raise alarms.
    root = np.sqrt(means.samples / found.problem.most_noise)
    places, residuals = recursive_residuals(design * root[:, None], measured * root)
    whole = max(BLOCKS, len(means)) - (len(means) - len(places))
    return _crossing(means.sliding_distance[places], residuals, whole)


def _linear(found: Posterior, manifest: RunManifest, means: Means) -> tuple[Column, Column]:
    """Return the law, linear about the fit so far, at each block, and what was read beyond that fit, m.

    Columns are ln k_D, drift and zero offsets.
    """
    problem, values = found.problem, found.problem.values
    distance = mean_distance(problem.contact, means)
    posed = replace(problem, distance=distance)
    depth, slope = (rows[: len(distance)] for rows in posed.model(np.asarray(found.best), values))
    segments = remountings(manifest, means.sliding_distance)
    offsets = np.equal.outer(segments, np.unique(segments)).astype(float)
    columns = np.column_stack([slope, means.time, offsets])
    return columns / np.linalg.norm(columns, axis=0), values["depth_scale"] * means.depth - depth


def recursive_residuals(design: Column, measured: Column) -> tuple[list[int], Column]:
    """Return the rows that those before them foretell by least squares, and what they differ by, in unit variances."""
    places, residuals = [], []
    for row in range(1, len(design)):
        before = np.linalg.pinv(design[:row], rcond=_SINGULAR)
        weights = design[row] @ before
        if np.allclose(weights @ design[:row], design[row], rtol=1e-6):
            places.append(row)
            residuals.append((measured[row] - weights @ measured[:row]) / math.sqrt(1 + weights @ weights))
    return places, np.asarray(residuals)


def _crossing(distance: Column, residuals: Column, whole: int) -> Departure | None:
    """Return the departure from the law where the sum of residuals crosses its bound; None if it does not."""
    total, number = np.cumsum(residuals), np.arange(1, len(residuals) + 1)
    crossed = np.flatnonzero(np.abs(total) > _BOUND * (math.sqrt(whole) + 2 * number / math.sqrt(whole)))
    if not len(crossed):
        return None
    first = int(crossed[0])
    deeper = bool(total[first] > 0)
    before = np.concatenate([[0.0], total[:first]])
    change = int(np.argmax(np.abs(total[first] - before) / np.sqrt(first + 1 - np.arange(first + 1))))
    return Departure(float(distance[first]), float(distance[change]), deeper)

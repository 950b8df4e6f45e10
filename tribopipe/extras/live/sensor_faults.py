"""What happens in labs while a test runs: a sensor that stands still, a load that is lost, friction that jumps."""

from collections.abc import Iterator

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.units import show_force
from tribopipe.documents.quantity import Quantity
from tribopipe.extras.live.alarm import Alarm, alarm_at
from tribopipe.extras.live.state import Means

_STILL = 100
"""Samples all the same after which a sensor may be stuck."""
_LONGER = 20
"""Times as long as ever before."""
_CHANGES = 20
"""Changes of a reading by which it is known how often it changes."""
_LOAD_OFF = 0.2
"""Relative difference of a block's load from the nominal one."""
_FRICTION_JUMP = 0.5
"""Relative difference of a block's friction from that of the blocks before it."""
_LEAST_JUMP = 0.05
_BEFORE = 3
"""Blocks to which one is held: friction that runs in changes less from one to the next."""


class StuckSensor:
    """How long the depth reading has not changed."""

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
                f"the depth has stood at exactly {shown} since {self._since:.4g} m, for {self._same} samples: the "
                "sensor is at the end of its range, or its channel is dead",
            )


def load_alarms(means: Means, nominal: float) -> Iterator[Alarm]:
    """Report where the measured load is not the nominal one, N; the first block may be the loading ramp."""
    load, distance = means.load[1:], means.sliding_distance[1:]
    for off in np.flatnonzero(np.abs(load - nominal) > _LOAD_OFF * nominal)[:1]:
        found, stated = (show_force(float(force), None) for force in (load[off], nominal))
        yield alarm_at(
            "load",
            float(distance[off]),
            f"found a load of {found} at {distance[off]:.4g} m where {stated} is nominal: the weight is off, or the "
            "load cell",
        )


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
            f"friction went from {before[jump]:.2g} to {after[jump]:.2g} at {distance:.4g} m: look at the contact, the "
            "lubricant and the load",
        )

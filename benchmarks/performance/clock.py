"""Times of works taken in turn, so that whatever else the machine does falls on all of them alike."""

import math
import statistics
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from case import Clock, Growth, Pair, Work


class Times(NamedTuple):
    """Times of one work, s."""

    median: float
    least: float
    greatest: float

    def scaled(self, factor: float) -> "Times":
        """Return the times of a work that is so many times as large."""
        return Times(*(factor * one for one in self))

    def __str__(self) -> str:
        """Say the median, and the range in brackets."""
        return f"{self.short} ({_shown(self.least)} to {_shown(self.greatest)})"

    @property
    def short(self) -> str:
        """Say the median."""
        return _shown(self.median)


def in_turn(works: Sequence[Work], repeats: int, clock: Clock) -> list[Times]:
    """Return the times of works that are each done once unobserved, and then in turn."""
    for work in works:
        work()
    taken = [[_timed(work, clock) for work in works] for _ in range(repeats)]
    return [Times(statistics.median(one), min(one), max(one)) for one in zip(*taken, strict=True)]


def both(pair: Pair, repeats: int) -> tuple[Times, Times]:
    """Return our times and the peer's."""
    ours, peer = in_turn([pair.ours, pair.peer], min(repeats, pair.repeats or repeats), pair.clock)
    return ours, peer.scaled(pair.scaled)


def grown(growth: Growth, repeats: int) -> tuple[list[Times], float]:
    """Return the times of each size, and the exponent n of time ∝ sizeⁿ by least squares of their logarithms."""
    works = [growth.at(size) for size in growth.sizes]
    times = in_turn(works, min(repeats, growth.repeats or repeats), growth.clock)
    slope, _ = np.polyfit(np.log(growth.sizes), [math.log(one.median) for one in times], 1)
    return times, float(slope)


def _timed(work: Work, clock: Clock) -> float:
    start = clock()
    work()
    return clock() - start


def _shown(seconds: float) -> str:
    for factor, unit in ((1.0, "s"), (1e3, "ms")):
        if seconds * factor >= 1:
            return f"{seconds * factor:.3g} {unit}"
    return f"{seconds * 1e6:.3g} µs"

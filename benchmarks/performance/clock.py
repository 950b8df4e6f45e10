"""Times of works taken in turn, so that whatever else the machine does falls on all of them alike."""

import math
import statistics
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from case import Clock, Command, Growth, Pair, Work
from own_process import Taken


class Times(NamedTuple):
    """Times of one work, s."""

    median: float
    least: float
    greatest: float
    peak: float | None = None
    """Most memory that it told of, bytes; a command does."""

    def scaled(self, factor: float) -> "Times":
        """Return the times of a work that is so many times as large."""
        return Times(factor * self.median, factor * self.least, factor * self.greatest, self.peak)

    def __str__(self) -> str:
        """Say the median, and the range in brackets."""
        return f"{self.short} ({_shown(self.least)} to {_shown(self.greatest)})"

    @property
    def short(self) -> str:
        """Say the median."""
        return _shown(self.median)


def in_turn(works: Sequence[Work], repeats: int, clock: Clock) -> list[Times]:
    """Return the times of works that are done in turn, each once unobserved before; not commands, which start anew."""
    for work in works:
        if not isinstance(work, Command):
            work()
    rounds = [[_taken(work, clock) for work in works] for _ in range(repeats)]
    return [_times(one) for one in zip(*rounds, strict=True)]


def _times(taken: Sequence[Taken]) -> Times:
    seconds = [one.seconds for one in taken]
    peak = max((one.peak for one in taken if one.peak is not None), default=None)
    return Times(statistics.median(seconds), min(seconds), max(seconds), peak)


def both(pair: Pair, repeats: int) -> tuple[Times, Times]:
    """Return our times and the peer's."""
    ours, peer = in_turn([pair.ours, pair.peer], min(repeats, pair.repeats or repeats), pair.clock)
    return ours, peer.scaled(pair.scaled)


def grown(growth: Growth, works: Sequence[Work], repeats: int) -> tuple[list[Times], float]:
    """Return the times of the work of each size, and the exponent n of time ∝ sizeⁿ by least squares of logarithms."""
    times = in_turn(works, min(repeats, growth.repeats or repeats), growth.clock)
    slope, _ = np.polyfit(np.log(growth.sizes), [math.log(one.median) for one in times], 1)
    return times, float(slope)


def _taken(work: Work, clock: Clock) -> Taken:
    start = clock()
    told = work()
    return told if isinstance(told, Taken) else Taken(clock() - start, None)


def _shown(seconds: float) -> str:
    for factor, unit in ((1.0, "s"), (1e3, "ms")):
        if seconds * factor >= 1:
            return f"{seconds * factor:.3g} {unit}"
    return f"{seconds * 1e6:.3g} µs"

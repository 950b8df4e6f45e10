"""Samples of a depth reading: where they step, their block averages, and the mean of what is not wear.

Blocks are evenly spaced in time, finer where wear begins, over whole revolutions or cycles: what a reading repeats
with each revolution, as runout, is not wear and averages out over whole ones.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tribopipe.base.arrays import Column, robust_deviation
from tribopipe.physics.autocorrelation import left_of
from tribopipe.physics.depth_model.posterior import DepthPosterior, DepthReading, KnownTerm, MeasuredDepth
from tribopipe.physics.depth_model.terms import settling

_BINS = 400
_FEWEST = 60
"""Bins below which a step cannot be distinguished from noise."""
_TERMS = 9
_DECISIVE = 8.0
"""Standard deviations of usual changes from bin to bin beyond which one is a step."""
_LEAST = 2e-4
"""Usual change, over the range of the reading, below which no step matters."""
_KEPT = 0.6
"""Share of a step that has to last."""
_SPAN = 6
"""Bins on either side over which it has to last."""
_MOST = 5


def steps(time: Column, progress: Column, depth: Column) -> list[int]:
    """Return the numbers of the samples at which a reading steps.

    Parameters
    ----------
    time, progress, depth
        Time, what wear grows along, and the reading, m, of each sample; shape (samples,).

    Returns
    -------
    list of int
        First sample after each step, ascending; None if there are fewer than 60 samples, or more than five steps,
        which are no steps then but another kind of disturbance.
    """
    edges = np.unique(np.linspace(0, len(time), min(_BINS, len(time)) + 1).astype(int))
    if len(edges) <= _FEWEST:
        return []
    counts = np.diff(edges)
    mean = np.add.reduceat(depth, edges[:-1]) / counts
    root = np.sqrt(np.maximum(np.add.reduceat(progress, edges[:-1]) / counts, 0.0) / progress[-1])
    curves = np.polynomial.chebyshev.chebvander(2 * root - 1, _TERMS).T
    found: list[int] = []
    # The smooth curve rings about a step until it is fitted as one: the next is sought beside all found so far.
    while (place := _largest(left_of(mean, curves)[0], float(np.ptp(mean)), found)) is not None:
        found.append(place)
        curves = np.vstack([curves, np.arange(len(mean)) > place])
        if len(found) > _MOST:
            return []
    return sorted(_sample(depth, edges[place], edges[place + 3]) for place in found)


def _largest(smooth: Column, reach: float, found: list[int]) -> int | None:
    """Return the bin before the largest step of what is left of a reading; None if no change is one."""
    change = smooth[2:] - smooth[:-2]
    center = np.median(change)
    scale = max(robust_deviation(change - center), _LEAST * reach)
    for place in np.argsort(-np.abs(change - center)).tolist():
        size = change[place] - center
        if abs(size) <= _DECISIVE * scale:
            return None
        if all(abs(place - other) > _SPAN for other in found) and _lasts(smooth, place + 1, size):
            return int(place)
    return None


def _lasts(smooth: Column, middle: int, size: float) -> bool:
    before, after = smooth[max(0, middle - _SPAN) : middle], smooth[middle + 1 : middle + 1 + _SPAN]
    if min(len(before), len(after)) < _SPAN // 2:
        return False
    return bool((np.median(after) - np.median(before)) / size > _KEPT)


def _sample(depth: Column, first: int, last: int) -> int:
    """Return where samples are best divided into two levels."""
    some = depth[first:last]
    count = np.arange(1, len(some))
    before = np.cumsum(some)[:-1] / count
    after = (np.sum(some) - np.cumsum(some)[:-1]) / (len(some) - count)
    return int(first + 1 + np.argmax(np.abs(after - before) * np.sqrt(count * (len(some) - count))))


BLOCKS = 100
"""Blocks over a test: enough for whatever is slower than a fiftieth of it."""
_FIRST_BLOCKS = 6
"""The first block is halved so often: wear of a sphere begins steeply, as √s."""
_FEWEST_CYCLES = 50
"""Of a test: with fewer of them, blocks of whole ones would be too few."""
_NODES = 4
"""Places in a block at which a smooth curve is averaged."""


@dataclass(frozen=True)
class Blocks:
    """Which block each sample belongs to."""

    place: NDArray[np.intp]
    """Number of the block of each sample."""
    counts: Column
    """Samples in each block, shape (blocks,)."""

    def mean(self, samples: Column) -> Column:
        """Return the mean over each block, shape (blocks,)."""
        return np.asarray(np.bincount(self.place, samples, len(self.counts)) / self.counts)

    def nodes(self, distance: Column) -> "Nodes":
        """Return the nodes by which a function of the distance is averaged over each block."""
        first = np.concatenate([[0], np.cumsum(self.counts)[:-1]]).astype(int)
        within = (np.arange(len(self.place)) - first[self.place]) * _NODES // self.counts[self.place].astype(int)
        node = self.place * _NODES + within
        filled = np.flatnonzero(counts := np.bincount(node))
        root = np.sqrt(np.maximum(distance, 0.0))
        return Nodes(
            distance=(np.bincount(node, root)[filled] / counts[filled]) ** 2,
            share=counts[filled] / self.counts[filled // _NODES],
            first=np.searchsorted(filled, np.arange(len(self.counts)) * _NODES),
        )


@dataclass(frozen=True)
class Nodes:
    """Sliding distances by which a smooth function is averaged over each block."""

    distance: Column
    """Square of the mean root of the sliding distance around each node, m: exact for wear that grows as √s."""
    share: Column
    """Share of its block that a node stands for."""
    first: NDArray[np.intp]
    """Number of the first node of each block."""

    def averaged(self, at_nodes: Column) -> Column:
        """Return block means of a function known at the nodes, shape (..., nodes) to (..., blocks)."""
        return np.asarray(np.add.reduceat(at_nodes * self.share, self.first, axis=-1))


def blocks_of(time: ArrayLike, segments: ArrayLike | None = None, cycles: ArrayLike | None = None) -> Blocks:
    """Divide a test into blocks.

    Parameters
    ----------
    time
        Time of each sample as a share of the sliding time, ascending, shape (samples,); below 0 before sliding began.
    segments
        Number of the segment of each sample, ascending; no block reaches across the end of a segment.
    cycles
        Revolutions, or strokes there and back, before each sample, ascending; None if they is unknown.

    Returns
    -------
    Blocks
        At most about 100 blocks of time, the first of them divided further, empty ones left out.
    """
    share = np.asarray(time, dtype=float)
    few = len(share) <= 2 * BLOCKS
    edges = share if few else _edges(share)
    if cycles is not None and not few:
        edges = _whole(edges, share, np.asarray(cycles, dtype=float))
    place = np.arange(len(share)) if few else np.searchsorted(edges, share, side="right")
    if segments is not None:
        place = place + (len(edges) + 1) * np.asarray(segments).astype(np.intp)
    _, dense, counts = np.unique(place, return_inverse=True, return_counts=True)
    return Blocks(dense, counts.astype(float))


def _edges(share: Column) -> Column:
    even = np.linspace(share[0], share[-1], BLOCKS + 1)[1:-1]
    width = 1.0 / BLOCKS
    fine = width * 0.5 ** np.arange(_FIRST_BLOCKS, -1, -1.0)
    return np.unique(np.concatenate([even, fine, [0.0]]))


def _whole(edges: Column, share: Column, cycles: Column) -> Column:
    """Move edges to where a cycle ends."""
    if cycles[-1] < _FEWEST_CYCLES:
        return edges
    ends = np.unique(np.round(np.interp(edges, share, cycles)))
    inside = ends[(ends > 0) & (ends < cycles[-1])]
    return np.concatenate([[0.0], np.interp(inside, cycles, share)])


@dataclass(frozen=True)
class DepthSamples:
    """A depth reading sample by sample, without missing ones."""

    time: Column
    """Share of the sliding time, ascending; below 0 before sliding began."""
    progress: Column
    """Quantity that wear increases with: sliding distance, m, or rotations."""
    depth: Column
    """Reading in true displacement, m."""
    segments: NDArray[np.intp]
    """Number of zero offsets that began before each sample."""
    temperature: Column | None = None
    """K; None if it was not recorded throughout."""
    cycle: float | None = None
    """Progress after which whatever turns or goes there and back is where it was; None if that is unknown."""

    @cached_property
    def blocks(self) -> Blocks:
        """Which block each sample belongs to."""
        return blocks_of(self.time, self.segments, None if self.cycle is None else self.progress / self.cycle)

    @cached_property
    def nodes(self) -> Nodes:
        """Places by which wear is averaged over each block."""
        return self.blocks.nodes(self.progress)

    def reading(
        self,
        course: Callable[[float, Column], Column],
        measured: tuple[MeasuredDepth, ...],
        *,
        drift_deviation: float | None = None,
        known: tuple[KnownTerm, ...] = (),
        free: Column | None = None,
        most: float = np.inf,
        guess: float | None = None,
    ) -> DepthReading:
        """Return block averages of the reading with all that is known of it.

        Parameters
        ----------
        course
            Wear, m, along the progress of a run that ends at a depth H, m.
        measured
            What was measured on the specimens, the end first.
        drift_deviation
            Prior standard deviation of the drift over the test, m; None for a flat prior.
        known
            Terms of known shape and size.
        free
            Columns of what else is free, shape (blocks, n).
        most
            Depth, m, that the specimen holds.
        guess
            First estimate of H, m; None for what was measured, or else for all that the sensor reads.
        """
        mean = self.blocks.mean
        return DepthReading(
            time=mean(self.time),
            depth=mean(self.depth),
            samples=self.blocks.counts,
            course=lambda depth: self.nodes.averaged(course(depth, self.nodes.distance)),
            segments=np.round(mean(self.segments.astype(float))),
            measured=measured,
            drift_deviation=drift_deviation,
            known=known,
            free=free,
            temperature=None if self.temperature is None else mean(self.temperature),
            most=most,
            guess=guess,
        )


def baseline(
    posterior: DepthPosterior, time: Column, segments: NDArray[np.intp], temperature: Column | None = None
) -> Column:
    """Return the mean reading without wear and wander at times, m: offsets, line, settling, temperature.

    Parameters
    ----------
    posterior
        Of the reading.
    time
        Share of the sliding time, shape (samples,).
    segments
        Number of zero offsets that began before each sample.
    temperature
        K, where the reading has it.
    """
    reading, (mean, _) = posterior.reading, posterior.terms
    offsets = len(np.unique(reading.segments))
    free = 0 if reading.free is None else reading.free.shape[1]
    line, optional = offsets + free, offsets + free + 1 + len(reading.known)
    place = np.searchsorted(np.unique(reading.segments), segments)
    found = mean[np.clip(place, 0, offsets - 1)] + mean[line] * time
    start = reading.time[0]
    for coefficient, constant in zip(mean[optional:], reading.optional.time_constants, strict=True):
        if constant is not None:
            found = found + coefficient * settling(np.concatenate([[start], time]), constant)[1:]
        elif temperature is not None and reading.temperature is not None:
            warmed = reading.temperature
            found = found + coefficient * (temperature - warmed[0]) / float(np.ptp(warmed))
    return np.asarray(found)

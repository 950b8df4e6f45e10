"""Block averages of a depth reading: evenly spaced in time, finer where wear begins, over whole revolutions or cycles.

What a reading repeats with each revolution, as runout, is not wear: it averages out over whole ones.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tribopipe.base.arrays import Column

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
        Revolutions, or strokes there and back, before each sample, ascending; none where they are not known.

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

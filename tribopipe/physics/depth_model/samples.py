"""Samples of a depth reading: their block averages, and the mean of what is not wear at each of them."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column
from tribopipe.physics.depth_model.blocks import Blocks, Nodes, blocks_of
from tribopipe.physics.depth_model.posterior import DepthPosterior, DepthReading, KnownTerm, MeasuredDepth
from tribopipe.physics.depth_model.terms import settling


@dataclass(frozen=True)
class DepthSamples:
    """A depth reading sample by sample, without missing ones."""

    time: Column
    """Share of the sliding time, ascending; below 0 before sliding began."""
    progress: Column
    """What wear grows along: sliding distance, m, or rotations."""
    depth: Column
    """Reading in true displacement, m."""
    segments: NDArray[np.intp]
    """Number of zero offsets that began before each sample."""
    temperature: Column | None = None
    """K; none where it was not recorded throughout."""
    cycle: float | None = None
    """Progress after which whatever turns or goes there and back is where it was; none where that is not known."""

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
    ) -> DepthReading:
        """Return block averages of the reading with all that is known of it.

        Parameters
        ----------
        course
            Wear, m, along the progress of a run that ends at a depth H, m.
        measured
            What was measured on the specimens, the end first.
        drift_deviation
            Prior standard deviation of the drift over the test, m; none for a flat prior.
        known
            Terms of known shape and size.
        free
            Columns of what else is free, shape (blocks, n).
        most
            Depth, m, that the specimen holds.
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

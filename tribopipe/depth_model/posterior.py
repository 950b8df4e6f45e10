"""Wear at the end of a test by its depth reading and by what was measured after it, everything else averaged over.

The reading is wear h(s; H) of a run that ends at the depth H, a line z + r·t, optional terms, slow wander and noise
(tribopipe.depth_model.mixture). H has a flat prior, so that its intervals hold as often as they say where the reading
alone, or the measurement alone, tells it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tribopipe.depth_model.mixture import Anchor, Regression, Way, noise_of_differences, ways
from tribopipe.depth_model.terms import OptionalTerms, optional_terms
from tribopipe.depth_model.wander import wanders
from tribopipe.run import Column

SCORES = np.linspace(-8.0, 8.0, 65)
"""Standard uncertainties by which a measurement is moved to see what depth it means."""
_NEARLY = 0.02
"""Change of H, in its standard deviation or in itself, after which the slope of the wear is not taken anew."""
_MOST_PASSES = 3
_STEP = 1e-3
"""Relative, of the difference by which the slope of the wear is found."""
_NEGLIGIBLE = 1e-4
"""Probability below which a way does not matter."""
_REACH = np.linspace(-8.0, 8.0, 65)
"""Standard deviations about each way at which the density of H is known."""
_MOVED = (-0.03, -0.01, -0.003, 0.003, 0.01, 0.03)
"""Shares of H by which errors of the inputs move what was measured."""
_FACTORS = 33
_LEAST_NOISE = 1e-12
"""Standard deviation, m, below which a reading counts as without noise."""
_LEAST_WEAR = 1e-9
"""m."""


@dataclass(frozen=True)
class MeasuredDepth:
    """A wear depth that was measured on a specimen, at the end or in between."""

    depths: Column
    """What depth it means, m, were the measurement off by each of ``SCORES``: ascending."""
    course: Callable[[Column], Column]
    """Wear depth where it was measured, m, of runs that end at depths H, m."""

    @property
    def depth(self) -> float:
        """Best estimate, m."""
        return float(self.depths[len(SCORES) // 2])

    @property
    def uncertainty(self) -> float:
        """Standard uncertainty, m, to first order."""
        low, high = np.interp([-1.0, 1.0], SCORES, self.depths)
        return max(float(high - low) / 2, _LEAST_NOISE)

    def score(self, end_depth: Column, factor: float = 1.0) -> Column:
        """Return how many standard uncertainties the measurement is off, for H and depths a factor larger."""
        depth, depths = self.course(end_depth), factor * self.depths
        beyond = np.where(depth < depths[0], depth - depths[0], np.maximum(depth - depths[-1], 0.0))
        return np.asarray(np.interp(depth, depths, SCORES) + beyond / self.uncertainty)


@dataclass(frozen=True)
class KnownTerm:
    """Something else that the sensor reads, of known shape, and how large it is."""

    shape: Column
    """At each block, of size one."""
    size: float
    """m."""
    uncertainty: float
    """Standard uncertainty of the size, m."""


@dataclass(frozen=True)
class DepthReading:
    """Block averages of a depth reading and what is known of what they are made of."""

    time: Column
    """Mean time of each block, as a share of the sliding time; shape (blocks,)."""
    depth: Column
    """Mean reading, m."""
    samples: Column
    """Samples behind each block."""
    course: Callable[[float], Column]
    """Wear at each block, m, of a run that ends at a depth H, m."""
    segments: Column
    """Number of the zero offset that each block has."""
    measured: tuple[MeasuredDepth, ...] = ()
    """What was measured on the specimens, the end first; none where the sensor alone has to tell."""
    drift_deviation: float | None = None
    """Prior standard deviation of the drift over the test, m; none for a flat prior."""
    known: tuple[KnownTerm, ...] = ()
    free: Column | None = None
    """Columns of what else is free, shape (blocks, n)."""
    temperature: Column | None = None
    """K, at each block."""
    most: float = np.inf
    """Depth, m, that the specimen holds."""

    @cached_property
    def weights(self) -> Column:
        """Samples behind each block over their mean."""
        return np.asarray(self.samples / np.mean(self.samples))

    @property
    def expected(self) -> float:
        """First estimate of H, m."""
        return self.measured[0].depth if self.measured else float(np.ptp(self.depth))

    @property
    def scale(self) -> float:
        """Size of H, m, of which prior deviations of optional terms are shares."""
        return max(abs(self.expected), 3 * self.measured[0].uncertainty if self.measured else 0.0, _LEAST_WEAR)

    @property
    def flat_columns(self) -> int:
        """Number of terms with flat priors: the first of all columns."""
        free = 0 if self.free is None else self.free.shape[1]
        return int(self.offsets.shape[1] + free + (self.drift_deviation is None))

    @property
    def offsets(self) -> Column:
        """Columns of the zero offsets, shape (blocks, offsets)."""
        return np.equal.outer(self.segments, np.unique(self.segments)).astype(float)

    @cached_property
    def optional(self) -> OptionalTerms:
        """Settling and temperature."""
        return optional_terms(self.time, self.temperature)

    @property
    def columns(self) -> Column:
        """All terms besides wear: offsets, line, what else is free, known and optional ones; (blocks, terms)."""
        free = np.empty((len(self.time), 0)) if self.free is None else self.free
        known = [term.shape for term in self.known]
        return np.column_stack([self.offsets, free, self.time, *known, self.optional.columns])


@dataclass(frozen=True)
class DepthPosterior:
    """All ways in which a reading may have come about, each with its evidence."""

    reading: DepthReading
    ways: tuple[Way, ...]
    reference: float
    """H about which the wear was taken for linear in H, m."""
    anchor: Anchor | None
    """H − reference as it was measured, to first order."""

    @cached_property
    def weights(self) -> Column:
        """Probability of each way, by reading and measurement."""
        return _normalized(np.array([way.log_anchored for way in self.ways]))

    @cached_property
    def weights_alone(self) -> Column:
        """Probability of each way by the reading alone."""
        return _normalized(np.array([way.log_evidence for way in self.ways]))

    @cached_property
    def _means(self) -> Column:
        return np.array([way.mean for way in self.ways])

    @cached_property
    def _covariances(self) -> Column:
        return np.array([way.covariance for way in self.ways])

    @property
    def alone(self) -> tuple[float, float]:
        """H and its standard uncertainty by the reading alone, m."""
        mean, deviation = _moments(self.weights_alone, self._means[:, 0], self._covariances[:, 0, 0])
        return self.reference + mean, deviation

    @property
    def together(self) -> tuple[float, float]:
        """H and its standard uncertainty by reading and measurement, m, to first order."""
        means, covariances = self._anchored
        mean, deviation = _moments(self.weights, means[:, 0], covariances[:, 0, 0])
        return self.reference + mean, deviation

    @cached_property
    def _anchored(self) -> tuple[Column, Column]:
        """Means and covariances of the coefficients in each way, with the measurement."""
        if self.anchor is None:
            return self._means, self._covariances
        gain = self._covariances[:, :, 0] / (self._covariances[:, :1, 0] + self.anchor.uncertainty**2)
        means = self._means + gain * (self.anchor.value - self._means[:, :1])
        return means, self._covariances - gain[:, :, None] * self._covariances[:, None, :, 0]

    @cached_property
    def terms(self) -> tuple[Column, Column]:
        """Mean and standard uncertainty of the coefficient of each column, by reading and measurement."""
        means, covariances = self._anchored
        mean = self.weights @ means
        variance = self.weights @ (np.einsum("wii->wi", covariances) + (means - mean) ** 2)
        return mean[1:], np.sqrt(variance[1:])

    @cached_property
    def terms_per_depth(self) -> Column:
        """By how much the coefficient of each column changes with H."""
        means, covariances = self._anchored
        mean = self.weights @ means
        centered = means - mean
        covariance = self.weights @ (covariances[:, :, 0] + centered * centered[:, :1])
        return np.asarray(covariance[1:] / covariance[0])

    @cached_property
    def wander(self) -> Column:
        """Mean of f at each block, m."""
        root = np.sqrt(self.reading.weights)
        rows = self.reading.depth - self.reading.course(self.reference)
        columns = np.column_stack([self._slope, self.reading.columns])
        means, found = self._anchored[0], np.zeros(len(root))
        for probability, way, mean in zip(self.weights, self.ways, means, strict=True):
            if way.wander is not None and probability > _NEGLIGIBLE:
                left = way.wander.basis.T @ (root * (rows - columns @ mean))
                precise = left / (way.deviations[1] ** 2 + way.deviations[0] ** 2 * way.wander.powers)
                pulled = way.wander.correlation @ (root * (way.wander.basis @ precise))
                found += probability * way.deviations[0] ** 2 * pulled
        return found

    @cached_property
    def disturbance(self) -> Column:
        """Covariance of wander and noise at the blocks, averaged over all ways, m²; shape (blocks, blocks)."""
        found = np.diag(self._average(lambda way: way.deviations[1] ** 2) / self.reading.weights)
        both = list(zip(self.weights.tolist(), self.ways, strict=True))
        wanders = {id(way.wander): way.wander for way in self.ways if way.wander is not None}
        for key, wander in wanders.items():
            share = float(np.sum([w * way.deviations[0] ** 2 for w, way in both if id(way.wander) == key]))
            found = found + share * wander.correlation
        return found

    @property
    def noise(self) -> float:
        """Standard deviation of the noise of a block of mean size, m."""
        return float(np.sqrt(self._average(lambda way: way.deviations[1] ** 2)))

    @cached_property
    def log_odds(self) -> float:
        """Evidence, as a logarithm of odds, that the reading is more than wear by the law, a line and noise."""
        plain = np.array([way.wander is None and way.alternative.name == "none" for way in self.ways])
        logs = np.array([way.log_anchored for way in self.ways])
        if not np.any(plain):
            return np.inf
        return float(np.logaddexp.reduce(logs[~plain], initial=-np.inf) - np.logaddexp.reduce(logs[plain])) - _PRIOR

    def probability_of(self, name: str) -> float:
        """Return the probability of an alternative of terms."""
        return float(self._average(lambda way: float(way.alternative.name == name)))

    def _average(self, of: Callable[[Way], float]) -> float:
        return float(self.weights @ [of(way) for way in self.ways])

    @cached_property
    def _slope(self) -> Column:
        return _slope(self.reading, self.reference)

    def end_depths(self, probability: Column, factor: Column, *, measured: bool = True) -> Column:
        """Return H, m, at cumulative probabilities.

        Parameters
        ----------
        probability
            Between 0 and 1, shape (draws,).
        factor
            By which the depths that were measured are larger than by the best estimates of the inputs, shape (draws,).
        measured
            Whether what was measured counts; otherwise the reading alone.

        Returns
        -------
        Column
            H, at least 0 and no deeper than the specimen, shape (draws,).
        """
        used = self.reading.measured if measured else ()
        grid, log_density = self._density
        nodes = np.linspace(np.min(factor), np.max(factor), _FACTORS) if used and np.ptp(factor) > 0 else np.ones(1)
        place = np.zeros(len(factor))
        if len(nodes) > 1:
            place = (factor - nodes[0]) / (nodes[1] - nodes[0])
        # A factor between two nodes takes one of them, the nearer one more often.
        chosen = np.minimum(np.floor(place + np.modf(probability * 1e4)[0]), len(nodes) - 1).astype(int)
        found = np.empty(len(probability))
        for node, value in enumerate(nodes.tolist()):
            some = chosen == node
            if np.any(some):
                scores = sum((one.score(grid, value) ** 2 for one in used), np.zeros(len(grid)))
                found[some] = np.interp(probability[some], _cumulative(grid, log_density - scores / 2), grid)
        return found

    @cached_property
    def _density(self) -> tuple[Column, Column]:
        """A grid of H, m, and the logarithm of its density by the reading alone."""
        means, deviations = self._means[:, 0], np.sqrt(self._covariances[:, 0, 0])
        mattering = np.flatnonzero(np.maximum(self.weights, self.weights_alone) > _NEGLIGIBLE)
        grid = self._grid(mattering)
        logs = np.array([way.log_evidence for way in self.ways])[mattering] - np.log(deviations[mattering])
        apart = (grid[:, None] - self.reference - means[mattering]) / deviations[mattering]
        terms = logs - 0.5 * apart**2
        top = np.max(terms, axis=1)
        return grid, top + np.log(np.sum(np.exp(terms - top[:, None]), axis=1))

    def _grid(self, mattering: NDArray[np.intp]) -> Column:
        """Return places that resolve every way in which H may have come about."""
        found = []
        for means, covariances in (self._anchored, (self._means, self._covariances)):
            for way in self._typical(mattering):
                reach = means[way, 0] + _REACH * np.sqrt(covariances[way, 0, 0])
                found += [reach, *(reach[::8] + by * self.reference for by in _MOVED)]
        grid = np.unique(np.concatenate(found)) + self.reference
        return np.asarray(grid[(grid >= 0) & (grid < self.reading.most)])

    def _typical(self, mattering: NDArray[np.intp]) -> list[int]:
        """Return the most probable way with each process and each kind of terms."""
        best: dict[tuple[int, str], int] = {}
        for way in sorted(mattering.tolist(), key=lambda place: -self.weights[place]):
            best.setdefault((id(self.ways[way].wander), self.ways[way].alternative.name), way)
        return list(best.values())


_PRIOR = float(np.log((1 - 0.3 * 0.5) / (0.3 * 0.5)))
"""Logarithm of the prior odds of anything but wear, a line and noise."""


def depth_posterior(reading: DepthReading) -> DepthPosterior:
    """Return what a reading, with what was measured on the specimens, tells of the wear at the end."""
    processes = wanders(reading.time, reading.weights)
    reference = min(max(reading.expected, 0.1 * reading.scale), 0.9 * reading.most)
    for _ in range(_MOST_PASSES):
        regression = regression_of(reading, reference)
        posterior = DepthPosterior(reading, tuple(ways(regression, processes)), reference, regression.anchor)
        mean, deviation = posterior.together
        moved = min(max(mean, 0.1 * reading.scale), 0.9 * reading.most)
        if abs(moved - reference) < max(_NEARLY * deviation, _NEARLY * reference):
            break
        reference = moved
    return posterior


def regression_of(reading: DepthReading, reference: float) -> Regression:
    """Return a reading with its wear taken for linear in H about a reference, m."""
    columns, flat = reading.columns, reading.flat_columns
    line = [] if reading.drift_deviation is None else [(0.0, reading.drift_deviation)]
    known = [*line, *((term.size, max(term.uncertainty, _LEAST_NOISE)) for term in reading.known)]
    return Regression(
        reading=reading.depth - reading.course(reference),
        weights=reading.weights,
        flat=np.column_stack([_slope(reading, reference), columns[:, :flat]]),
        normal=columns[:, flat:],
        known_mean=np.array([mean for mean, _ in known]),
        known_deviation=np.array([deviation for _, deviation in known]),
        alternatives=reading.optional.alternatives,
        scale=reading.scale,
        noise=max(noise_of_differences(reading.depth, reading.weights), _LEAST_NOISE),
        anchor=_anchor(reading.measured, reference),
    )


def _slope(reading: DepthReading, reference: float) -> Column:
    step = _STEP * reference
    return (reading.course(reference + step) - reading.course(reference - step)) / (2 * step)


def _anchor(measured: Sequence[MeasuredDepth], reference: float) -> Anchor | None:
    """Return what was measured of H − reference, to first order; none where nothing was measured."""
    if not measured:
        return None
    step = _STEP * reference
    values, precisions = [], []
    for one in measured:
        low, middle, high = one.course(np.array([reference - step, reference, reference + step]))
        slope = (high - low) / (2 * step)
        values.append((one.depth - middle) / slope)
        precisions.append((slope / one.uncertainty) ** 2)
    together = float(np.sum(precisions))
    return Anchor(float(np.average(values, weights=precisions)), together**-0.5)


def _normalized(logs: Column) -> Column:
    found = np.exp(logs - np.max(logs))
    return np.asarray(found / np.sum(found))


def _moments(weights: Column, means: Column, variances: Column) -> tuple[float, float]:
    mean = float(weights @ means)
    return mean, float(np.sqrt(weights @ (variances + (means - mean) ** 2)))


def _cumulative(grid: Column, log_density: Column) -> Column:
    density = np.exp(log_density - np.max(log_density))
    panels = np.diff(grid) * (density[1:] + density[:-1]) / 2
    found = np.concatenate([[0.0], np.cumsum(panels)])
    return np.asarray(found / found[-1])

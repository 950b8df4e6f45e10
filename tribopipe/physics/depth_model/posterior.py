"""Wear at the end of a test by its depth reading and by what was measured after it, everything else averaged over.

The reading is wear h(s; H) of a run that ends at the depth H, a line z + r·t, optional terms, slow wander and noise
(tribopipe.physics.depth_model.mixture). H has Jeffreys' prior, the root of the information that both sources have of
it, with which intervals hold as often as stated (B. L. Welch, H. W. Peers, J. R. Stat. Soc. B 25, 1963, 318),

    π(H) ∝ √(1/σ² + Σ (∂z/∂H)²),

with σ of the reading alone and z the scores of what was measured. It is flat in H where the reading shows H, and flat
in the diameter, volume or depth that was measured where that does.
"""

import pickle
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from tribopipe.base.arrays import Column
from tribopipe.physics.depth_model.mixture import NO_WANDER, Anchor, Regression, Ways, noise_of_differences, ways
from tribopipe.physics.depth_model.terms import OptionalTerms, Wander, optional_terms, wanders

SCORES = np.linspace(-8.0, 8.0, 65)
"""Standard uncertainties by which a measurement is moved to see what depth it means."""
_NEARLY = 0.02
"""Change of H, in its standard deviation or in itself, after which the slope of the wear is not taken again."""
_MOST_PASSES = 3
SLOPE_STEP = 1e-3
"""Relative, of the difference by which the slope of the wear is found."""
_NEGLIGIBLE = 1e-4
"""Probability below which a way does not matter."""
_REACH = np.linspace(-8.0, 8.0, 65)
"""Standard deviations about each way at which the density of H is known."""
_WIDER, _BESIDE = 1.2, 0.5
"""A way no wider than another by this factor, nor farther from it in its standard deviations, needs no places more."""
_MOVED = (-0.03, -0.01, -0.003, 0.003, 0.01, 0.03)
"""Shares of H by which errors of the inputs move what was measured."""
_NODE = 0.25
"""Standard uncertainties of the measurement between factors for which the distribution of H is known,"""
_LEAST_SPACING = 2e-5
"""and the least difference of these."""
_ALIKE = 0.1
"""Relative difference of standard deviations, and half of that of means in these, of ways that are merged."""
_SLOPE_REACH = 0.25
"""Standard uncertainties of a measurement over which, to either side, the slope of its score is taken."""
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
        """Standard uncertainty, m, by first-order propagation."""
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
    """What was measured on the specimens, the end first; None if the sensor alone is used."""
    drift_deviation: float | None = None
    """Prior standard deviation of the drift over the test, m; None for a flat prior."""
    known: tuple[KnownTerm, ...] = ()
    free: Column | None = None
    """Columns of what else is free, shape (blocks, n)."""
    temperature: Column | None = None
    """K, at each block."""
    most: float = np.inf
    """Depth, m, that the specimen holds."""
    guess: float | None = None
    """First estimate of H, m; None for what was measured, or else for all that the sensor reads."""

    @cached_property
    def weights(self) -> Column:
        """Samples behind each block over their mean."""
        return np.asarray(self.samples / np.mean(self.samples))

    @property
    def expected(self) -> float:
        """First estimate of H, m."""
        if self.guess is not None:
            return self.guess
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
        """All terms in addition to wear: offsets, line, what else is free, known and optional ones; (blocks, terms)."""
        free = np.empty((len(self.time), 0)) if self.free is None else self.free
        known = [term.shape for term in self.known]
        return np.column_stack([self.offsets, free, self.time, *known, self.optional.columns])


@dataclass(frozen=True)
class DepthPosterior:
    """All ways in which a reading may have come about, each with its evidence."""

    reading: DepthReading
    ways: Ways
    processes: tuple[Wander, ...]
    """Those that the ways number."""
    reference: float
    """H about which the wear was taken for linear in H, m."""
    anchor: Anchor | None
    """H − reference as it was measured, by first-order propagation."""

    @cached_property
    def weights(self) -> Column:
        """Probability of each way, by reading and measurement."""
        return _normalized(self.ways.log_anchored)

    @cached_property
    def weights_alone(self) -> Column:
        """Probability of each way by the reading alone."""
        return _normalized(self.ways.log_evidence)

    @property
    def alone(self) -> tuple[float, float]:
        """H and its standard uncertainty by the reading alone, m."""
        mean, deviation = _moments(self.weights_alone, self.ways.mean[:, 0], self.ways.covariance[:, 0, 0])
        return self.reference + mean, deviation

    @property
    def together(self) -> tuple[float, float]:
        """H and its standard uncertainty by reading and measurement, m, by first-order propagation."""
        means, covariances = self._anchored
        mean, deviation = _moments(self.weights, means[:, 0], covariances[:, 0, 0])
        return self.reference + mean, deviation

    @cached_property
    def _anchored(self) -> tuple[Column, Column]:
        """Means and covariances of the coefficients in each way, with the measurement."""
        if self.anchor is None:
            return self.ways.mean, self.ways.covariance
        means = self.ways.mean + self._gain * (self.anchor.value - self.ways.mean[:, :1])
        return means, self.ways.covariance - self._gain[:, :, None] * self.ways.covariance[:, None, :, 0]

    @cached_property
    def _gain(self) -> Column:
        """By how much the coefficients in each way change with the measurement."""
        measured = 0.0 if self.anchor is None else self.anchor.uncertainty**2
        return np.asarray(self.ways.covariance[:, :, 0] / (self.ways.covariance[:, :1, 0] + measured))

    @property
    def shared_variance(self) -> float:
        """Covariance of the errors of H and of the measurement, m²; in one way alone it is the variance of H."""
        if self.anchor is None:
            return 0.0
        known, measured = self.ways.covariance[:, 0, 0], self.anchor.uncertainty**2
        return float(self.weights @ (known * measured / (known + measured)))

    @cached_property
    def terms(self) -> tuple[Column, Column]:
        """Mean and standard uncertainty of the coefficient of each column, by reading and measurement."""
        means, covariances = self._anchored
        mean = self._by_column(self.weights[:, None] * means)
        plain = means.shape[1] - 1
        off = np.column_stack([means[:, :plain] - mean[:plain], means[:, plain]])
        square = self._by_column(self.weights[:, None] * (np.einsum("wii->wi", covariances) + off**2))
        square[plain:] -= mean[plain:] ** 2
        return mean[1:], np.sqrt(np.maximum(square, 0.0))[1:]

    @property
    def first_known(self) -> int:
        """Number of the first term of known shape among the coefficients of columns."""
        reading = self.reading
        return int(reading.columns.shape[1] - reading.optional.columns.shape[1] - len(reading.known))

    @cached_property
    def terms_per_depth(self) -> Column:
        """By how much the coefficient of each column changes with H."""
        means, covariances = self._anchored
        off = means[:, :1] - self.weights @ means[:, 0]
        covariance = self._by_column(self.weights[:, None] * (covariances[:, :, 0] + means * off))
        return np.asarray(covariance[1:] / covariance[0])

    @cached_property
    def terms_per_scale(self) -> Column:
        """By how much the coefficient of each column changes with the logarithm of the sensor's scale, m.

        A reading that is larger by a factor is one of so much more wear, drift and all else; what was measured on the
        specimens stays, and the terms take the difference.
        """
        means, _ = self._anchored
        if self.anchor is not None:
            means = means - self._gain * (self.anchor.value + self.reference)
        return self._by_column(self.weights[:, None] * means)[1:]

    def term_quantiles(self, column: int, probability: Column, more: float = 0.0) -> Column:
        """Return the coefficient of a column other than settling at cumulative probabilities, averaged over all ways.

        Parameters
        ----------
        column
            Number of the column.
        probability
            Between 0 and 1, ascending.
        more
            Standard uncertainty of the coefficient, m, in addition, that the reading knows nothing of.
        """
        from scipy.optimize import brentq

        some = self.weights > _NEGLIGIBLE / 100
        means, covariances = (found[some, column + 1] for found in self._anchored)
        deviations = np.sqrt(covariances[:, column + 1] + more**2)
        weights = self.weights[some] / np.sum(self.weights[some])
        low, high = np.min(means + _REACH[0] * deviations), np.max(means + _REACH[-1] * deviations)

        def excess(value: float, wanted: float) -> float:
            return float(weights @ ndtr((value - means) / deviations)) - wanted

        close = 1e-6 * float(np.min(deviations))
        return np.array([brentq(excess, low, high, (wanted,), xtol=close) for wanted in probability.tolist()])

    def _by_column(self, found: Column) -> Column:
        """Add up what belongs to the coefficients of each way: those of each settling by themselves."""
        settled = self._settling >= 0
        count = self.reading.optional.settling.shape[1]
        return np.append(np.sum(found[:, :-1], axis=0), np.bincount(self._settling[settled], found[settled, -1], count))

    @cached_property
    def _settling(self) -> NDArray[np.intp]:
        """Number of the settling in each way; −1 where there is none."""
        columns = [-1 if one.column is None else one.column for one in self.reading.optional.alternatives]
        return np.array(columns, dtype=np.intp)[self.ways.alternative]

    @cached_property
    def wander(self) -> Column:
        """Mean of f at each block, m."""
        root, ways, optional = np.sqrt(self.reading.weights), self.ways, self.reading.optional
        rows = self.reading.depth - self.reading.course(self.reference)
        plain = np.column_stack([self._slope, self.reading.columns[:, : -optional.settling.shape[1]]])
        found = np.zeros(len(root))
        for number, process in enumerate(self.processes):
            mine = np.flatnonzero((ways.wander == number) & (self.weights > _NEGLIGIBLE))
            means, settling = self._anchored[0][mine], optional.settling[:, self._settling[mine]].T
            left = root * (rows - means[:, :-1] @ plain.T - means[:, -1:] * settling)
            precision = 1 / (ways.noise[mine, None] ** 2 + ways.slow[mine, None] ** 2 * process.powers)
            weighted = (self.weights * ways.slow**2)[mine, None] * precision * (left @ process.basis)
            found += process.correlation @ (root * (process.basis @ np.sum(weighted, axis=0)))
        return found

    @property
    def range_beyond_line(self) -> float:
        """Range of what the reading has beyond wear, offsets and a line, m: settling, temperature and wander."""
        count = self.reading.optional.columns.shape[1]
        other = self.reading.columns[:, -count:] @ self.terms[0][-count:] + self.wander
        return float(np.ptp(other))

    def disturbance(self, misfit: float = 1.0) -> Column:
        """Return the covariance of noise and wander at the blocks, averaged over all ways, m²; shape (blocks, blocks).

        ``misfit`` is the share of the wander, noise with a short memory aside, that counts.
        """
        found = np.diag(self.noise**2 / self.reading.weights)
        for number, process in enumerate(self.processes):
            power = float(self.weights @ (self.ways.slow**2 * (self.ways.wander == number)))
            found = found + (1.0 if process.is_noise else misfit**2) * power * process.correlation
        return found

    @property
    def noise(self) -> float:
        """Standard deviation of the noise of a block of mean size, m."""
        return float(np.sqrt(self.weights @ self.ways.noise**2))

    @property
    def log_evidence(self) -> float:
        """Logarithm of the probability of reading and measurement, whatever way they came about."""
        return float(np.logaddexp.reduce(self.ways.log_anchored))

    @cached_property
    def log_odds(self) -> float:
        """Evidence, as a logarithm of odds, that the reading is more than wear by the law, a line and noise."""
        noisy = np.array([False, *(process.is_noise for process in self.processes)])
        plain = ((self.ways.wander < 0) | noisy[self.ways.wander + 1]) & (self.ways.alternative == 0)
        if not np.any(plain):
            return np.inf
        logs = self.ways.log_anchored
        others = np.logaddexp.reduce(logs[~plain], initial=-np.inf)
        noise = NO_WANDER + (1 - NO_WANDER) * float(np.mean(noisy[1:]))
        prior = noise * self.reading.optional.alternatives[0].probability
        return float(others - np.logaddexp.reduce(logs[plain]) - np.log((1 - prior) / prior))

    @property
    def settling_probability(self) -> float:
        """Probability that the reading settles."""
        return self._probability([one.column is not None for one in self.reading.optional.alternatives])

    @property
    def thermal_probability(self) -> float:
        """Probability that the reading follows the temperature."""
        return self._probability([one.warmed > 0 for one in self.reading.optional.alternatives])

    def _probability(self, some: Sequence[bool]) -> float:
        return min(1.0, float(self.weights @ np.array(some)[self.ways.alternative]))

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
        if not measured or not self.reading.measured:
            grid, log_density = self._density
            return np.asarray(np.interp(probability, _cumulative(grid, log_density), grid))
        # A factor between two nodes takes one of them, the nearer one more often.
        place = (factor - 1) / self._node_spacing + np.modf(probability * 1e4)[0]
        nodes = np.floor(place).astype(int)
        found = np.empty(len(probability))
        for node in np.unique(nodes).tolist():
            some = nodes == node
            found[some] = np.interp(probability[some], self._measured_cumulative(node), self._density[0])
        return found

    @cached_property
    def _node_spacing(self) -> float:
        """Difference of factors between which the distribution of H hardly changes."""
        end = self.reading.measured[0]
        return max(_NODE * end.uncertainty / max(abs(end.depth), end.uncertainty), _LEAST_SPACING)

    def _measured_cumulative(self, node: int) -> Column:
        """Return the cumulative distribution of H, with what was measured, at the grid of its density."""
        if node not in self._known_nodes:
            grid, log_density = self._density
            factor = 1 + node * self._node_spacing
            information, squares = np.full(len(grid), self.alone[1] ** -2.0), np.zeros(len(grid))
            for one in self.reading.measured:
                score = one.score(grid, factor)
                squares += score**2
                information += _slope_about(grid, score, _SLOPE_REACH * one.uncertainty) ** 2
            self._known_nodes[node] = _cumulative(grid, log_density + (np.log(information) - squares) / 2)
        return self._known_nodes[node]

    @cached_property
    def _known_nodes(self) -> dict[int, Column]:
        return {}

    @cached_property
    def _density(self) -> tuple[Column, Column]:
        """A grid of H, m, and the logarithm of its density by the reading alone."""
        means, deviations = self.ways.mean[:, 0], np.sqrt(self.ways.covariance[:, 0, 0])
        logs, means, deviations = _merged(self.ways.log_evidence, self.ways.log_anchored, means, deviations)
        grid = self._grid()
        terms = (grid[:, None] - (self.reference + means)) * (np.sqrt(0.5) / deviations)
        np.subtract(logs - np.log(deviations), np.square(terms, out=terms), out=terms)
        top = np.max(terms, axis=1)
        np.exp(np.subtract(terms, top[:, None], out=terms), out=terms)
        return grid, top + np.log(np.sum(terms, axis=1))

    def _grid(self) -> Column:
        """Return a grid of H that resolves all alternatives."""
        found = []
        for means, covariances in (self._anchored, (self.ways.mean, self.ways.covariance)):
            typical = self._typical
            spreads = zip(np.sqrt(covariances[typical, 0, 0]).tolist(), means[typical, 0].tolist(), strict=True)
            resolved: list[tuple[float, float]] = []
            for deviation, mean in sorted(spreads):
                if not any(deviation < _WIDER * d and abs(mean - m) < _BESIDE * d for d, m in resolved):
                    resolved.append((deviation, mean))
                    reach = mean + _REACH * deviation
                    found += [reach, *(reach[::8] + by * self.reference for by in _MOVED)]
        grid = np.unique(np.concatenate(found)) + self.reference
        return np.asarray(grid[(grid >= 0) & (grid < self.reading.most)])

    @cached_property
    def _typical(self) -> list[int]:
        """Return the most probable way with each process and each kind of terms."""
        kinds = np.array(
            [(one.column is not None) + 2 * (one.warmed > 0) for one in self.reading.optional.alternatives]
        )
        order = np.argsort(-self.weights, kind="stable")
        alike = 4 * self.ways.wander + kinds[self.ways.alternative]
        return [int(way) for way in order[np.unique(alike[order], return_index=True)[1]]]


def _merged(alone: Column, anchored: Column, means: Column, deviations: Column) -> tuple[Column, Column, Column]:
    """Return Gaussians of H, those that are nearly alike merged: logarithms of their weights, means, deviations."""
    mattering = np.maximum(_normalized(alone), _normalized(anchored)) > _NEGLIGIBLE / 100
    alone, means, deviations = alone[mattering], means[mattering], deviations[mattering]
    size = np.round(np.log(deviations) / _ALIKE)
    place = np.round(means / (2 * _ALIKE * np.exp(size * _ALIKE)))
    _, group = np.unique(size + 1j * place, return_inverse=True)
    top = np.full(int(group.max()) + 1, -np.inf)
    np.maximum.at(top, group, alone)
    share = np.exp(alone - top[group])
    weight = np.bincount(group, share)
    mean = np.bincount(group, share * means) / weight
    variance = np.bincount(group, share * (deviations**2 + (means - mean[group]) ** 2)) / weight
    return top + np.log(weight), mean, np.sqrt(variance)


def depth_posterior(reading: DepthReading) -> DepthPosterior:
    """Return what a reading, with what was measured on the specimens, shows of the wear at the end."""
    processes = tuple(wanders(reading.time, reading.weights))
    reference = min(max(reading.expected, 0.1 * reading.scale), 0.9 * reading.most)
    for _ in range(_MOST_PASSES):
        regressions = regressions_of(reading, reference)
        found = _ways(_Asked(reading.time, regressions, processes))
        posterior = DepthPosterior(reading, found, processes, reference, regressions[0].anchor)
        mean, deviation = posterior.together
        moved = min(max(mean, 0.1 * reading.scale), 0.9 * reading.most)
        if abs(moved - reference) < max(_NEARLY * deviation, _NEARLY * reference):
            break
        reference = moved
    return posterior


@dataclass(frozen=True, eq=False)
class _Asked:
    """Regressions whose ways are asked for; two are equal where their numbers are."""

    time: Column
    regressions: tuple[Regression, ...]
    processes: tuple[Wander, ...]
    """They follow from the times and weights of the blocks."""

    @cached_property
    def _content(self) -> bytes:
        return pickle.dumps((self.time, self.regressions))

    def __hash__(self) -> int:
        return hash(self._content)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Asked) and self._content == other._content


@lru_cache(maxsize=8)
def _ways(asked: _Asked) -> Ways:
    """Return the ways of regressions; drift correction and the fit under Archard's law ask for the same ones."""
    return ways(asked.regressions, asked.processes)


def regressions_of(reading: DepthReading, reference: float) -> tuple[Regression, ...]:
    """Return a reading with its wear taken for linear in H about a reference, m: without temperature, and with it."""
    columns, flat, alternatives = reading.columns, reading.flat_columns, reading.optional.alternatives
    line = [] if reading.drift_deviation is None else [(0.0, reading.drift_deviation)]
    known = [*line, *((term.size, max(term.uncertainty, _LEAST_NOISE)) for term in reading.known)]
    temperatures = reading.optional.temperature.shape[1]
    plain = Regression(
        reading=reading.depth - reading.course(reference),
        weights=reading.weights,
        flat=np.column_stack([_slope(reading, reference), columns[:, :flat]]),
        normal=columns[:, flat:],
        known_mean=np.array([*(mean for mean, _ in known), *[0.0] * temperatures]),
        known_deviation=np.array([*(deviation for _, deviation in known), *[_LEAST_NOISE] * temperatures]),
        alternatives=[one for one in alternatives if not one.warmed],
        scale=reading.scale,
        noise=max(noise_of_differences(reading.depth, reading.weights), _LEAST_NOISE),
        anchor=_anchor(reading.measured, reference),
    )
    warmed = [one for one in alternatives if one.warmed]
    if not warmed:
        return (plain,)
    deviations = np.append(plain.known_deviation[:-1], warmed[0].warmed * reading.scale)
    return plain, replace(plain, known_deviation=deviations, alternatives=warmed)


def _slope(reading: DepthReading, reference: float) -> Column:
    step = SLOPE_STEP * reference
    return (reading.course(reference + step) - reading.course(reference - step)) / (2 * step)


def _slope_about(grid: Column, values: Column, reach: float) -> Column:
    """Return the slope of values between two places at a distance about each place of an ascending grid."""
    low, high = np.maximum(grid - reach, grid[0]), np.minimum(grid + reach, grid[-1])
    return np.asarray((np.interp(high, grid, values) - np.interp(low, grid, values)) / (high - low))


def _anchor(measured: Sequence[MeasuredDepth], reference: float) -> Anchor | None:
    """Return what was measured of H − reference, by first-order propagation; None if nothing was measured."""
    if not measured:
        return None
    step = SLOPE_STEP * reference
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

"""A depth reading as wear, terms of known shape and slow wander: one Gaussian regression for each way it may be.

    y = X·β + f(t) + e,    f ~ N(0, σ_f²·M(ℓ)),    e ~ N(0, σ_e²/w)

For a correlation length ℓ, the two standard deviations and an alternative of terms this is generalized least squares,
whose marginal likelihood has a closed form (C. E. Rasmussen, C. K. I. Williams, Gaussian Processes for Machine
Learning, 2006, 2.7). All of them together, each with its evidence, are the posterior; nothing is fitted or chosen.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tribopipe.depth_model.terms import Alternative
from tribopipe.depth_model.wander import Wander
from tribopipe.run import Column

_COARSE = (0.7, 0.3)
"""Spacing of ln σ_f and of ln σ_e where their posterior is looked for,"""
_FINE = (0.35, 0.15)
"""and where it is."""
_NOISE_RANGE = 0.6
"""ln σ_e is sought so far on either side of what differences of neighboring blocks tell."""
_LEAST_WANDER, _MOST_WANDER = 0.1, 3.0
"""σ_f is sought from this share of σ_e to this many times the wear."""
NO_WANDER = 0.3
"""Prior probability that there is none."""
_WIDE = 30.0
"""Prior standard deviation of H about its reference, in times the wear."""
_SAME = 1e-12
"""What is added to a squared correlation of one, so that columns that are the same have an inverse."""
_WINDOW = 9.0
"""Ways whose logarithm of evidence is lower by more than this do not matter."""


@dataclass(frozen=True)
class Anchor:
    """A coefficient as it was measured otherwise, and its standard uncertainty."""

    value: float
    uncertainty: float

    def log_evidence(self, mean: Column, variance: Column) -> Column:
        """Return the logarithm of the probability of the measurement where a coefficient is known so well."""
        together = variance + self.uncertainty**2
        return np.asarray(-0.5 * (np.log(together) + (mean - self.value) ** 2 / together))


@dataclass(frozen=True)
class Regression:
    """What a reading is made of, at each block."""

    reading: Column
    """m, shape (blocks,)."""
    weights: Column
    """Samples behind each block over their mean."""
    flat: Column
    """Columns with flat priors, shape (blocks, flat)."""
    normal: Column
    """Columns of all terms with normal priors, shape (blocks, normal): the known ones first."""
    known_mean: Column
    """Prior means of the known ones, m."""
    known_deviation: Column
    """Prior standard deviations of the known ones, m."""
    alternatives: Sequence[Alternative]
    scale: float
    """Wear at the end, m, of which prior deviations of optional terms are shares."""
    noise: float
    """First estimate of σ_e, m."""
    anchor: Anchor | None = None
    """What was measured of the coefficient of the first flat column."""


@dataclass(frozen=True)
class Ways:
    """All ways in which a reading may have come about that matter, each a Gaussian posterior of its coefficients."""

    log_evidence: Column
    """By the reading alone, prior probability included; shape (ways,)."""
    log_anchored: Column
    """With the anchor; without one the same."""
    alternative: NDArray[np.intp]
    """Number of the alternative of terms."""
    wander: NDArray[np.intp]
    """Number of the process; −1 where nothing wanders."""
    slow: Column
    """σ_f, m."""
    noise: Column
    """σ_e, m."""
    mean: Column = field(repr=False)
    """Of all coefficients, those that are not part of a way 0; shape (ways, coefficients)."""
    covariance: Column = field(repr=False)
    """Shape (ways, coefficients, coefficients)."""


def noise_of_differences(reading: Column, weights: Column) -> float:
    """Return σ_e by second differences of neighboring blocks, m, robustly (median absolute deviation)."""
    second = reading[2:] - 2 * reading[1:-1] + reading[:-2]
    expected = np.sqrt(1 / weights[2:] + 4 / weights[1:-1] + 1 / weights[:-2])
    return float(1.4826 * np.median(np.abs(second / expected)))


def ways(regression: Regression, wanders: Sequence[Wander]) -> Ways:
    """Return all ways in which a reading may have come about that matter, with their evidence."""
    share = (1 - NO_WANDER) / max(1, len(wanders))
    found = []
    for number, wander in enumerate((None, *wanders), start=-1):
        projected = _Projected(regression, wander)
        grid = _grid(regression, wander, _COARSE)
        prior = float(np.log(NO_WANDER if wander is None else share))
        found.append((number, projected, prior, grid, projected.log_evidences(*grid)))
    refined = []
    for (number, projected, prior, grid, _), near in zip(found, _mattering([one[-1] for one in found]), strict=True):
        if np.any(near):
            fine = _refined(grid, np.any(near, axis=0), with_wander=projected.wander is not None)
            refined.append((number, projected, fine, projected.log_evidences(*fine[:2]) + prior + fine[2]))
    parts = [
        part
        for (number, projected, fine, evidence), near in zip(refined, _mattering([r[-1] for r in refined]), strict=True)
        for part in _kept(number, projected, fine[:2], evidence, near)
    ]
    return Ways(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))


def _mattering(evidences: Sequence[Column]) -> list[NDArray[np.bool_]]:
    """Say which alternatives at which points matter: by the reading alone, or with the anchor."""
    best = np.max([np.max(evidence, axis=(1, 2)) for evidence in evidences], axis=0)
    return [np.any(evidence > best[:, None, None] - _WINDOW, axis=0) for evidence in evidences]


def _kept(
    number: int,
    projected: "_Projected",
    deviations: tuple[Column, Column],
    evidence: Column,
    near: NDArray[np.bool_],
) -> Iterator[tuple[Any, ...]]:
    """Give the columns of ``Ways`` for each alternative that matters with a process."""
    for place, alternative in enumerate(projected.regression.alternatives):
        points = np.flatnonzero(near[place])
        if len(points):
            slow, noise = deviations[0][points], deviations[1][points]
            same = np.ones(len(points), dtype=np.intp)
            alone, anchored = evidence[:, place, points]
            yield (
                alone,
                anchored,
                place * same,
                number * same,
                slow,
                noise,
                *projected.coefficients(alternative, slow, noise),
            )


def _grid(regression: Regression, wander: Wander | None, spacing: tuple[float, float]) -> tuple[Column, Column]:
    """Return pairs of σ_f and σ_e."""
    noise = np.log(regression.noise) + np.arange(-_NOISE_RANGE, _NOISE_RANGE + 1e-9, spacing[1])
    if wander is None:
        return np.zeros(len(noise)), np.exp(noise)
    low, high = np.log(_LEAST_WANDER * regression.noise), np.log(_MOST_WANDER * regression.scale)
    slow = np.arange(low, max(high, low + 2.0), spacing[0])
    pairs = np.stack(np.meshgrid(slow, noise, indexing="ij"), axis=-1).reshape(-1, 2)
    return np.exp(pairs[:, 0]), np.exp(pairs[:, 1])


def _refined(grid: tuple[Column, Column], near: Column, *, with_wander: bool) -> tuple[Column, Column, float]:
    """Return a finer grid about the points that matter, and the logarithm of the prior of each of its points."""
    axes, log_prior = [], 0.0
    for values, coarse, fine, used in zip(grid, _COARSE, _FINE, (with_wander, True), strict=True):
        if not used:
            axes.append(np.zeros(1))
            continue
        logs = np.log(values)
        low, high = np.min(logs[near]) - coarse, np.max(logs[near]) + coarse
        axes.append(np.exp(np.arange(low, high + 1e-9, fine)))
        log_prior += float(np.log(fine / (np.ptp(logs) + coarse)))
    pairs = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    return pairs[:, 0], pairs[:, 1], log_prior


class _Projected:
    """A regression in the basis in which wander and noise are diagonal."""

    def __init__(self, regression: Regression, wander: Wander | None) -> None:
        self.regression, self.wander = regression, wander
        root = np.sqrt(regression.weights)
        known = regression.normal[:, : len(regression.known_mean)]
        rows = regression.reading - known @ regression.known_mean
        # What has a flat prior may be taken out before: squares of small rows lose no digits.
        beside = regression.flat[:, 1:]
        self.taken = np.linalg.lstsq(beside * root[:, None], rows * root, rcond=None)[0]
        rows = rows - beside @ self.taken
        columns = np.column_stack([regression.flat, regression.normal, rows]) * root[:, None]
        if wander is not None:
            columns = wander.basis.T @ columns
        self.powers = np.zeros(len(root)) if wander is None else wander.powers
        self.count = columns.shape[1]
        self.products = (columns[:, :, None] * columns[:, None, :]).reshape(len(root), -1)

    def log_evidences(self, wander: Column, noise: Column) -> Column:
        """Return the logarithm of the marginal likelihood, alone and with the anchor: (2, alternatives, points)."""
        normal, log_weights = self._normal(wander, noise)
        anchor, found = self.regression.anchor, []
        for alternative in self.regression.alternatives:
            matrix, pull, square, log_prior = self._equations(alternative, normal)
            inverse, log_det = _inverse(matrix)
            solution = (inverse @ pull[..., None])[..., 0]
            left = square - np.vecdot(pull, solution)
            alone = np.log(alternative.probability) + 0.5 * (log_weights - log_det - log_prior - left)
            with_anchor = 0.0 if anchor is None else anchor.log_evidence(solution[:, 0], np.asarray(inverse[:, 0, 0]))
            found.append((alone, alone + with_anchor))
        return np.swapaxes(np.asarray(found), 0, 1)

    def coefficients(self, alternative: Alternative, wander: Column, noise: Column) -> tuple[Column, Column]:
        """Return mean and covariance of all coefficients, those that are not part of the alternative 0."""
        normal, _ = self._normal(wander, noise)
        matrix, pull, *_ = self._equations(alternative, normal)
        inverse, _ = _inverse(matrix)
        used = self._used(alternative)
        mean = np.zeros((len(wander), self.count - 1))
        mean[:, used] = (inverse @ pull[..., None])[..., 0]
        flat = self.regression.flat.shape[1]
        mean[:, 1:flat] += self.taken
        mean[:, flat : flat + len(self.regression.known_mean)] += self.regression.known_mean
        covariance = np.zeros((len(wander), self.count - 1, self.count - 1))
        covariance[:, np.asarray(used)[:, None], used] = inverse
        return mean, covariance

    def _normal(self, wander: Column, noise: Column) -> tuple[Column, Column]:
        precision = 1 / (noise[:, None] ** 2 + wander[:, None] ** 2 * self.powers)
        normal = (precision @ self.products).reshape(-1, self.count, self.count)
        return normal, np.sum(np.log(precision), axis=1)

    def _used(self, alternative: Alternative) -> list[int]:
        flat, known = self.regression.flat.shape[1], len(self.regression.known_mean)
        return [*range(flat + known), *(flat + known + place for place in alternative.columns)]

    def _equations(self, alternative: Alternative, normal: Column) -> tuple[Column, Column, Column, float]:
        """Return the normal matrix with priors, its right side, the rows' square, and ln det of the priors."""
        used = self._used(alternative)
        optional = [alternative.deviation * self.regression.scale] * len(alternative.columns)
        deviations = np.asarray([*self.regression.known_deviation, *optional])
        matrix = normal[:, np.asarray(used)[:, None], used].copy()
        # So wide a prior of H changes nothing but where drift and wear cannot be told apart, as on a flat pin.
        matrix[:, 0, 0] += (_WIDE * self.regression.scale) ** -2.0
        diagonal = np.arange(len(used))[self.regression.flat.shape[1] :]
        matrix[:, diagonal, diagonal] += deviations**-2.0
        return matrix, normal[:, used, -1], normal[:, -1, -1], float(2 * np.sum(np.log(deviations)))


def _inverse(matrices: Column) -> tuple[Column, Column]:
    """Return inverses and logarithms of determinants of normal matrices, whatever the units of their columns.

    Where columns are as good as the same, what each has of them is left wide open.
    """
    size = np.sqrt(np.einsum("pii->pi", matrices))
    outer = size[:, :, None] * size[:, None, :]
    scaled = matrices / outer + _SAME * np.eye(matrices.shape[-1])
    return np.linalg.inv(scaled) / outer, np.linalg.slogdet(scaled)[1] + 2 * np.sum(np.log(size), axis=1)

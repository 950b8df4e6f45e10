"""A depth reading as wear, terms of known shape and slow wander: one Gaussian regression for each way it may be.

    y = X·β + f(t) + e,    f ~ N(0, σ_f²·M(ℓ)),    e ~ N(0, σ_e²/w)

For a correlation length ℓ, the two standard deviations and an alternative of terms this is generalized least squares,
whose marginal likelihood has a closed form (C. E. Rasmussen, C. K. I. Williams, Gaussian Processes for Machine
Learning, 2006, 2.7). All of them together, each with its evidence, are the posterior; nothing is fitted or chosen.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import accumulate
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column, robust_deviation
from tribopipe.physics.depth_model.terms import Alternative, Wander

_COARSE = (0.7, 0.3)
"""Spacing of ln σ_f and of ln σ_e where their posterior is looked for,"""
_FINE = (0.35, 0.15)
"""and where it is."""
_NOISE_RANGE = 0.6
"""ln σ_e is sought so far on either side of what differences of neighboring blocks show."""
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
    """Contributions to the depth signal, at each block."""

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
    """Of settling: what else they hold is among the known terms."""
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
    """Of the coefficients of all flat and known columns, and last of the way's own settling, 0 where there is none;
    shape (ways, coefficients)."""
    covariance: Column = field(repr=False)
    """Shape (ways, coefficients, coefficients)."""


def noise_of_differences(reading: Column, weights: Column) -> float:
    """Return σ_e by second differences of neighboring blocks, m, robustly (median absolute deviation)."""
    second = reading[2:] - 2 * reading[1:-1] + reading[:-2]
    expected = np.sqrt(1 / weights[2:] + 4 / weights[1:-1] + 1 / weights[:-2])
    return robust_deviation(second / expected)


def ways(regressions: Sequence[Regression], wanders: Sequence[Wander]) -> Ways:
    """Return all ways in which a reading may have come about that matter, with their evidence.

    Alternatives are numbered through all regressions, which differ in the priors of their terms alone.
    """
    share, cases = (1 - NO_WANDER) / max(1, len(wanders)), []
    first = accumulate((len(one.alternatives) for one in regressions[:-1]), initial=0)
    for start, regression in zip(first, regressions, strict=True):
        for number, wander in enumerate((None, *wanders), start=-1):
            grid = _grid(regression, wander, _COARSE)
            prior = float(np.log(NO_WANDER if wander is None else share))
            cases.append(_Case(number, start, _Projected(regression, wander), grid, prior))
    found, refined = [one.projected.solved(*one.grid).log_evidences() for one in cases], []
    for one, near in zip(cases, _mattering(found), strict=True):
        if np.any(near):
            slow, noise, prior = _refined(one.grid, np.any(near, axis=0), with_wander=one.number >= 0)
            solved = one.projected.solved(slow, noise)
            refined.append((one, solved, solved.log_evidences() + one.log_prior + prior))
    parts = [_kept(*one, near) for one, near in zip(refined, _mattering([r[-1] for r in refined]), strict=True)]
    return Ways(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))


def log_evidence_of_noise(regression: Regression) -> float:
    """Return the logarithm of the probability of reading and anchor where nothing wanders, prior included."""
    reach = _NOISE_RANGE + _COARSE[1]
    spread = np.arange(-reach, reach + 1e-9, _FINE[1])
    solved = _Projected(regression, None).solved(np.zeros(len(spread)), regression.noise * np.exp(spread))
    _, anchored = solved.log_evidences()
    return float(np.logaddexp.reduce(anchored, axis=None) + np.log(NO_WANDER / len(spread)))


def _mattering(evidences: Sequence[Column]) -> list[NDArray[np.bool_]]:
    """Report which alternatives at which points matter: by the reading alone, or with the anchor."""
    best = np.max([np.max(evidence, axis=(1, 2)) for evidence in evidences], axis=0)
    return [np.any(evidence > best[:, None, None] - _WINDOW, axis=0) for evidence in evidences]


def _kept(case: "_Case", solved: "_Solved", evidence: Column, near: NDArray[np.bool_]) -> tuple[Any, ...]:
    """Return the columns of ``Ways`` for the alternatives and points that matter with a process."""
    places, points = np.nonzero(near)
    alone, anchored = evidence[:, places, points]
    numbers = case.first_alternative + places, np.full(len(points), case.number)
    return alone, anchored, *numbers, solved.slow[points], solved.noise[points], *solved.coefficients(places, points)


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
        self.taken: Column = np.asarray(np.linalg.lstsq(beside * root[:, None], rows * root, rcond=None)[0])
        rows = rows - beside @ self.taken
        columns = np.column_stack([regression.flat, regression.normal, rows]) * root[:, None]
        if wander is not None:
            columns = wander.basis.T @ columns
        self.powers = np.zeros(len(root)) if wander is None else wander.powers
        self.count = columns.shape[1]
        self.products = (columns[:, :, None] * columns[:, None, :]).reshape(len(root), -1)

    def solved(self, slow: Column, noise: Column) -> "_Solved":
        """Solve the equations without optional terms for pairs of σ_f and σ_e, m."""
        regression, plain = self.regression, self.regression.flat.shape[1] + len(self.regression.known_mean)
        precision = 1 / (noise[:, None] ** 2 + slow[:, None] ** 2 * self.powers)
        normal = (precision @ self.products).reshape(-1, self.count, self.count)
        pull, cross = normal[:, :plain, -1], normal[:, :plain, plain:-1]

        matrix = normal[:, :plain, :plain].copy()
        # So wide a prior of H changes nothing but where drift and wear cannot be told apart, as on a flat pin.
        matrix[:, 0, 0] += (_WIDE * regression.scale) ** -2.0
        diagonal = np.arange(regression.flat.shape[1], plain)
        matrix[:, diagonal, diagonal] += regression.known_deviation**-2.0
        inverse, log_det = _inverse(matrix)

        solution, shared = (inverse @ pull[..., None])[..., 0], inverse @ cross
        left = normal[:, -1, -1] - np.vecdot(pull, solution)
        log_prior = 2 * float(np.sum(np.log(regression.known_deviation)))
        own = np.einsum("pii->pi", normal)[:, plain:-1]
        return _Solved(
            regression=regression,
            taken=self.taken,
            slow=slow,
            noise=noise,
            inverse=inverse,
            solution=solution,
            log_marginal=0.5 * (np.sum(np.log(precision), axis=1) - log_det - log_prior - left),
            shared=shared,
            unexplained=np.maximum(own - np.sum(cross * shared, axis=1), 0.0),
            residual=normal[:, plain:-1, -1] - np.sum(cross * solution[:, :, None], axis=1),
        )


class _Case(NamedTuple):
    """A regression with one process."""

    number: int
    """Index of the process; −1 without a process."""
    first_alternative: int
    """Number of the first alternative of the regression."""
    projected: _Projected
    grid: tuple[Column, Column]
    """Pairs of σ_f and σ_e, m, where the posterior is looked for."""
    log_prior: float
    """Of the process."""


@dataclass(frozen=True)
class _Solved:
    """Equations without optional terms, for pairs of deviations; an optional term is a border of their inverse."""

    regression: Regression
    taken: Column
    """What was taken out before of the columns with flat priors, m."""
    slow: Column
    """σ_f, m, shape (points,)."""
    noise: Column
    """σ_e, m."""
    inverse: Column
    """Of the normal matrix with priors, shape (points, plain, plain)."""
    solution: Column
    """Shape (points, plain)."""
    log_marginal: Column
    """Logarithm of the likelihood without an optional term."""
    shared: Column
    """What the others take of each optional column, shape (points, plain, optional),"""
    unexplained: Column
    """what they leave of its square, shape (points, optional),"""
    residual: Column
    """and of its product with the reading."""

    def log_evidences(self) -> Column:
        """Return the logarithm of the marginal likelihood, alone and with the anchor: (2, alternatives, points)."""
        alternatives, anchor = self.regression.alternatives, self.regression.anchor
        there = np.array([one.column is not None for one in alternatives])
        place = [one.column or 0 for one in alternatives]
        deviation = np.where(there, [one.deviation * self.regression.scale for one in alternatives], 1.0)
        border = np.where(there, self.unexplained[:, place] + deviation**-2.0, 1.0)
        pulled, moved = there * self.residual[:, place], there * self.shared[:, 0, place]
        log_probability = np.log([one.probability for one in alternatives])
        gained = 0.5 * (pulled**2 / border - np.log(border)) - np.log(deviation)
        alone = log_probability + self.log_marginal[:, None] + gained
        if anchor is None:
            return np.stack([alone.T, alone.T])
        mean = self.solution[:, :1] - moved * pulled / border
        variance = self.inverse[:, :1, 0] + moved**2 / border
        return np.stack([alone.T, (alone + anchor.log_evidence(mean, variance)).T])

    def coefficients(self, places: NDArray[np.intp], points: NDArray[np.intp]) -> tuple[Column, Column]:
        """Return mean and covariance of the coefficients for alternatives at points, that of the settling last."""
        flat, plain = self.regression.flat.shape[1], self.shared.shape[1]
        alternatives = self.regression.alternatives
        there = np.array([one.column is not None for one in alternatives])[places]
        column = np.array([one.column or 0 for one in alternatives])[places]
        prior = np.array([one.deviation or 1.0 for one in alternatives])[places] * self.regression.scale
        variance = there / (self.unexplained[points, column] + prior**-2.0)
        shared, settled = self.shared[points, :, column], self.residual[points, column] * variance

        mean = np.empty((len(points), plain + 1))
        mean[:, :plain], mean[:, plain] = self.solution[points] - shared * settled[:, None], settled
        mean[:, 1:flat] += self.taken
        mean[:, flat:plain] += self.regression.known_mean

        taken = shared * variance[:, None]
        covariance = np.empty((len(points), plain + 1, plain + 1))
        covariance[:, :plain, :plain] = self.inverse[points] + taken[:, :, None] * shared[:, None, :]
        covariance[:, :plain, plain] = covariance[:, plain, :plain] = -taken
        covariance[:, plain, plain] = variance
        return mean, covariance


def _inverse(matrices: Column) -> tuple[Column, Column]:
    """Return inverses and logarithms of determinants of normal matrices, whatever the units of their columns.

    Where columns are as good as the same, what each has of them is left wide open, as is one that is zero throughout.
    """
    size = np.sqrt(np.einsum("pii->pi", matrices))
    size = np.where(size > 0, size, 1.0)
    outer = size[:, :, None] * size[:, None, :]
    scaled = matrices / outer + _SAME * np.eye(matrices.shape[-1])
    return np.linalg.inv(scaled) / outer, np.linalg.slogdet(scaled)[1] + 2 * np.sum(np.log(size), axis=1)

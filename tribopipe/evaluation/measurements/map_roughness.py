"""The roughness of the unworn surface in a height map, and what it does to a volume.

Neighboring heights deviate alike, so that their mean is less certain than their number suggests.
"""

import math
from dataclasses import dataclass

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.evaluation.measurements.height_map import HeightMap
from tribopipe.evaluation.measurements.profile_levelling import Mask

_FEWEST_PAIRS = 0.5
"""Pairs of cells; fewer are rounding."""


@dataclass(frozen=True)
class Roughness:
    """Covariance of the heights of the unworn surface, m², by the distance between cells."""

    values: Column
    """On a grid twice as large as the map, whose first cell is the variance."""

    @classmethod
    def of(cls, grid: HeightMap, unworn: Mask, lost: Column, parameters: int) -> "Roughness":
        """Return the covariance of what a fitted surface leaves of the unworn cells, up to where it is first none.

        Parameters
        ----------
        grid
            The map.
        unworn
            Cells to which the surface was fitted.
        lost
            By how much each cell is below the surface, m.
        parameters
            Number of fitted parameters.
        """
        kept = unworn.astype(float)
        shape = 2 * kept.shape[0], 2 * kept.shape[1]
        pairs = _correlated(kept, shape)
        covariance = np.divide(_correlated(kept * lost, shape), pairs, out=np.zeros(shape), where=pairs > _FEWEST_PAIRS)
        near = _up_to_first_zero(covariance, grid)
        independent = np.sum(kept) * covariance[0, 0] / max(float(np.sum(covariance[near])), covariance[0, 0])
        # The fit takes as many of the independent deviations as it has parameters.
        left = max(1 - parameters / independent, 0.5)
        return cls(np.where(near, covariance, 0.0) / left)

    def spread(self, weights: Column) -> float:
        """Return the standard deviation of a weighted sum of heights."""
        total = float(np.sum(self.values * _correlated(weights, self.values.shape)))
        return math.sqrt(max(total, float(self.values[0, 0] * np.sum(weights**2))))


def _correlated(values: Column, shape: tuple[int, ...]) -> Column:
    """Return the sum of products of values by the distance between their cells."""
    return np.asarray(np.fft.irfft2(np.abs(np.fft.rfft2(values, shape)) ** 2, shape))


def _up_to_first_zero(covariance: Column, grid: HeightMap) -> Mask:
    """Return the distances within that at which the covariance, averaged over all directions, is first not positive."""
    rows, columns = covariance.shape
    steps = float(np.ptp(grid.y)) / (len(grid.y) - 1), float(np.ptp(grid.x)) / (len(grid.x) - 1)
    down, right = (np.fft.fftfreq(count, 1 / count) * step for count, step in zip((rows, columns), steps, strict=True))
    away = np.hypot(down[:, None], right)
    bins = np.rint(away / max(steps)).astype(int)
    means = np.bincount(bins.ravel(), covariance.ravel()) / np.bincount(bins.ravel())
    means = means[: max(len(grid.x), len(grid.y)) // 2]
    ends = int(np.argmax(means <= 0)) if np.any(means <= 0) else len(means)
    return np.asarray(bins < max(ends, 1))


def through_fit(weights: Column, gradients: Column, unworn: Mask, solver: Column) -> Column:
    """Return the weights with which the heights of all cells make up a volume, directly and through a fitted surface.

    Parameters
    ----------
    weights
        Weight of each cell's lost height in the volume, m².
    gradients
        Derivatives of the surface in each cell by its parameters, the last axis.
    unworn
        Cells to which it was fitted.
    solver
        Matrix that turns deviations of these cells into steps of the parameters.
    """
    through = -weights
    through[unworn] += np.tensordot(weights, gradients, axes=2) @ solver
    return through


def by_sampling(grid: HeightMap, region: Mask, lost: Column) -> float:
    """Return how far a volume may be off because heights are known at some places only, m³.

    By maps of every second line and column: of four, which a trapezoidal rule makes four times as wrong.
    """
    share = np.where(region, grid.area * lost, 0.0)
    coarse = [4 * float(np.sum(share[row::2, column::2])) for row in (0, 1) for column in (0, 1)]
    return float(np.std(coarse)) / 3

"""Where a height map made before the test lies in the map made after it.

The map before is shifted in both directions, raised, tilted and, where the maps clearly show it, rotated, until it fits
the surroundings of the scar, which did not wear. For the fit both maps are smoothed alike: the noise of single cells
would draw it to places between them.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from tribopipe.base.arrays import Column, robust_deviation
from tribopipe.base.errors import FitError
from tribopipe.evaluation.measurements.height_map import HeightMap, bridged, from_edge
from tribopipe.evaluation.measurements.map_roughness import Roughness
from tribopipe.evaluation.measurements.map_scars import frame
from tribopipe.evaluation.measurements.profile_levelling import Mask

_STEPS, _CONVERGED = 20, 1e-3
"""Most steps of a fit; share of what is left within which it has converged."""
_MEASURED = 0.5
"""Weight of the measured cells around a position from which on its height is known."""
_LEAST_OVERLAP = 0.3
"""Share of the map after the test that the map before it has to show."""
_SMOOTHED, _SPOILT = 0.7, 4.0
"""Standard deviation of the smoothing, in cells of the coarser map; and its own ones from the edge that it spoils."""
_AROUND = 8
"""Cells by which a map is continued."""
_LOOSE = 0.1
"""Share of the map by which a shift may plausibly be off that no roughness determines."""
_ROUGH, _CLIPPED = (0.5, 1.5), 4.0
"""Standard deviations of the Gaussian filters, in cells, between which the roughness is compared; and its own ones to
which what stands out is cut."""
_BETTER = 0.7
"""Share of what is left without a shift below which a shift by the roughness is no accident."""
_MOST_ROTATED, _CLEARLY = 0.05, 5.0
"""Largest rotation, rad; and standard uncertainties by which it must exceed zero."""
_NEAR = 0.05
"""Cells between which a slope is taken."""
_SHIFTS, _LEVEL, _TURNED = 2, 5, 6
"""Parameters of a shift; with height and slopes; with a rotation."""


@dataclass(frozen=True)
class _Surface:
    """A map between its cells."""

    x: Column
    y: Column
    spline: Column
    """Coefficients of a cubic spline through the heights and some more around them."""
    known: Column
    """1 in cells that were measured, 0 in others."""

    @classmethod
    def of(cls, grid: HeightMap, heights: Column) -> "_Surface":
        """Return heights in all cells of a map as a surface, known where the map was measured."""
        from scipy.ndimage import spline_filter

        spline = np.asarray(spline_filter(_continued(heights), order=3, mode="nearest"))
        return cls(grid.x, grid.y, spline, grid.measured.astype(float))

    def height(self, x: Column, y: Column) -> Column:
        """Return heights at these positions, m."""
        from scipy.ndimage import map_coordinates

        cells = self._cells(x, y) + _AROUND
        return np.asarray(map_coordinates(self.spline, cells, order=3, mode="nearest", prefilter=False))

    def slopes(self, x: Column, y: Column) -> tuple[Column, Column]:
        """Return the slopes along and across the scan lines at these positions."""
        wide, long = _NEAR * _step(self.x), _NEAR * _step(self.y)
        along = (self.height(x + wide, y) - self.height(x - wide, y)) / (2 * wide)
        return along, (self.height(x, y + long) - self.height(x, y - long)) / (2 * long)

    def shows(self, x: Column, y: Column) -> Mask:
        """Return which of these positions lie in or next to measured cells."""
        from scipy.ndimage import map_coordinates

        known = map_coordinates(self.known, self._cells(x, y), order=1, mode="constant", cval=0.0)
        return np.asarray(known > _MEASURED)

    def _cells(self, x: Column, y: Column) -> Column:
        return np.array([(y - self.y[0]) / _step(self.y), (x - self.x[0]) / _step(self.x)])


def _step(places: Column) -> float:
    return float(places[-1] - places[0]) / (len(places) - 1)


def _filled(grid: HeightMap) -> Column:
    """Return the heights of a map with those that are missing interpolated, or as the nearest ones."""
    from scipy.ndimage import distance_transform_edt

    filled, _ = bridged(grid.height)
    nearest = distance_transform_edt(np.isnan(filled), return_distances=False, return_indices=True)
    return np.asarray(filled[tuple(nearest)])


def _continued(heights: Column) -> Column:
    """Return heights with those around them that continue the slope, which a filter would bend otherwise."""
    return np.pad(heights, _AROUND, mode="reflect", reflect_type="odd")


def _smoothed(grid: HeightMap, width: float) -> tuple[HeightMap, Column]:
    """Return a map smoothed over a width, m, without the cells along its edge; and the heights in all its cells."""
    from scipy.ndimage import gaussian_filter

    cells = width / _step(grid.y), width / _step(grid.x)
    inner = slice(_AROUND, -_AROUND)
    smooth = gaussian_filter(_continued(_filled(grid)), cells, truncate=_SPOILT)[inner, inner]
    spoilt = from_edge(grid.inside()) <= math.ceil(_SPOILT * max(cells))
    return replace(grid, height=np.where(spoilt | ~grid.measured, np.nan, smooth)), smooth


@dataclass(frozen=True)
class Placed:
    """The surface before the test in the cells of the map after it."""

    grid: HeightMap
    """The map after the test."""
    smooth: HeightMap
    """The same, smoothed."""
    before: _Surface
    smooth_before: _Surface
    start: Column
    """Shift that is taken to be likeliest, m."""
    parameters: Column
    """Shift along and across, m; height, m; both slopes; and rotation, rad, where there is one."""

    @property
    def shift(self) -> tuple[float, float]:
        """By how much the map after is shifted, m."""
        return float(self.parameters[0]), float(self.parameters[1])

    @property
    def rotation(self) -> float:
        """Rotation of the map after, rad."""
        return float(self.parameters[_LEVEL]) if len(self.parameters) == _TURNED else 0.0

    @cached_property
    def height(self) -> Column:
        """Its height in each cell, m."""
        return self._plane(...) + self.before.height(*self._places(...))

    @cached_property
    def measured(self) -> Mask:
        """The cells of which the map before shows the surface."""
        return self.before.shows(*self._places(...))

    @property
    def gradients(self) -> Column:
        """Derivatives of the height in each cell by the parameters, the last axis."""
        return self._gradients(...)

    def without(self, cells: Mask) -> "Placed":
        """Return it on a map after the test in which some cells count as missing."""
        grid, smooth = (replace(one, height=np.where(cells, np.nan, one.height)) for one in (self.grid, self.smooth))
        return replace(self, grid=grid, smooth=smooth)

    def solver(self, cells: Mask) -> Column:
        """Return the matrix that turns deviations of some cells into steps of the parameters."""
        gradients = self._gradients(cells)
        scale = np.linalg.norm(gradients, axis=0)
        spread = robust_deviation(self.left(cells))
        rows = np.vstack([gradients / scale, self._loosely(spread) / scale])
        return np.asarray(np.linalg.pinv(rows)[:, : len(gradients)] / scale[:, None])

    def left(self, cells: Mask) -> Column:
        """Return by how much the map after, smoothed, is higher in some cells, m."""
        height = self._plane(cells) + self.smooth_before.height(*self._places(cells))
        return np.asarray(self.smooth.height[cells] - height)

    def overlap(self) -> Mask:
        """Return the cells that both maps show. Raises ``FitError`` where they are few."""
        both = self.grid.measured & self.measured
        share = np.count_nonzero(both) / np.count_nonzero(self.grid.measured)
        if share < _LEAST_OVERLAP:
            raise FitError(
                f"map: found that the map before the test shows {100 * share:.0f} % of the map after it; expected at "
                f"least {100 * _LEAST_OVERLAP:.0f} %; measure the same place, and check the units of both maps"
            )
        return both

    def comparable(self) -> Mask:
        """Return the cells in which both smoothed maps can be compared."""
        return self.overlap() & self.smooth.measured & self.smooth_before.shows(*self._places(...))

    def fitted(self, cells: Mask) -> "Placed":
        """Return it where it fits some of the cells by least squares."""
        placed = self
        for _ in range(_STEPS):
            kept = cells & placed.comparable()
            left = placed.left(kept)
            placed, change = placed.stepped(kept, left, np.ones_like(left))
            if change <= _CONVERGED * float(np.std(left)):
                break
        return placed

    def fitted_to_frame(self) -> tuple[float, "Placed", Mask]:
        """Fit along the edge of the overlap by least absolute deviations, which a scar there does not draw off.

        Returns the median of what is left, m, the surface and the cells.
        """
        placed, cells = self, _frame(self.comparable())
        for _ in range(_STEPS):
            left = placed.left(cells)
            if not np.any(placed.parameters[_SHIFTS:]):
                placed = replace(placed, parameters=np.array([*placed.shift, float(np.median(left)), 0.0, 0.0]))
                left = placed.left(cells)
            middle = float(np.median(np.abs(left))) + np.finfo(float).tiny
            weights = np.sqrt(middle / np.maximum(np.abs(left), 0.1 * middle))
            placed, change = placed.stepped(cells, left, weights)
            cells = _frame(placed.comparable())
            if change <= _CONVERGED * middle:
                break
        return float(np.median(np.abs(placed.left(cells)))), placed, cells

    def rotated(self, cells: Mask) -> "Placed":
        """Return it with a rotation where the maps clearly show a small one."""
        if len(self.parameters) == _TURNED:
            return self
        turned = replace(self, parameters=np.append(self.parameters, 0.0)).fitted(cells)
        kept = cells & turned.comparable()
        lost = np.zeros(kept.shape)
        lost[kept] = -turned.left(kept)
        by_heights = np.zeros(kept.shape)
        by_heights[kept] = turned.solver(kept)[-1]
        spread = Roughness.of(self.grid, kept, lost, _TURNED).spread(by_heights)
        return turned if _CLEARLY * spread < abs(turned.rotation) < _MOST_ROTATED else self

    def stepped(self, cells: Mask, left: Column, weights: Column) -> tuple["Placed", float]:
        """Return it after one step of a weighted fit to some cells, and the largest change of its height there, m."""
        gradients = self._gradients(cells)
        scale = np.linalg.norm(gradients, axis=0)
        loose = self._loosely(robust_deviation(left))
        off = np.append(self.parameters[:_SHIFTS] - self.start, np.zeros(len(self.parameters) - _SHIFTS))
        rows = np.vstack([gradients * weights[:, None], loose]) / scale
        steps = np.linalg.lstsq(rows, np.append(left * weights, -loose @ off), rcond=None)[0] / scale
        return replace(self, parameters=self.parameters + steps), float(np.max(np.abs(gradients @ steps)))

    def _loosely(self, spread: float) -> Column:
        """Return rows that hold a shift where it was, as loosely as one that nothing else determines may be off."""
        reach = float(np.ptp(self.grid.x)), float(np.ptp(self.grid.y))
        rows = np.zeros((_SHIFTS, len(self.parameters)))
        rows[range(_SHIFTS), range(_SHIFTS)] = [spread / (_LOOSE * length) for length in reach]
        return rows

    def _at(self, cells: Any) -> tuple[Column, Column]:
        x, y = np.broadcast_arrays(self.grid.x, self.grid.y[:, None])
        return x[cells], y[cells]

    def _places(self, cells: Any) -> tuple[Column, Column]:
        x, y = self._at(cells)
        along, across = self.shift
        cosine, sine = math.cos(self.rotation), math.sin(self.rotation)
        return cosine * x + sine * y - along, cosine * y - sine * x - across

    def _plane(self, cells: Any) -> Column:
        x, y = self._at(cells)
        _, _, top, along, across = self.parameters[:_LEVEL]
        return np.asarray(top + along * x + across * y)

    def _gradients(self, cells: Any) -> Column:
        (x, y), (right, up) = self._at(cells), self._places(cells)
        along, across = self.smooth_before.slopes(right, up)
        turning = (up + self.shift[1]) * along - (right + self.shift[0]) * across
        columns = [-along, -across, np.ones_like(along), x, y, turning]
        return np.stack(columns[: len(self.parameters)], axis=-1)


def placed(after: HeightMap, before: HeightMap) -> tuple[Placed, Mask]:
    """Return the surface before the test where it fits the edge of the map after it, and the cells there.

    The fit is begun where the middles of both maps coincide, and where their roughness correlates best. The latter is
    used where it leaves clearly less, since without common roughness it is an accident.

    Raises ``FitError`` where the maps overlap too little.
    """
    width = _SMOOTHED * max(_step(places) for grid in (after, before) for places in (grid.x, grid.y))
    smooth, _ = _smoothed(after, width)
    surfaces = _Surface.of(before, _filled(before)), _Surface.of(*_smoothed(before, width))
    found, failed = [], None
    for shift, favor in (((0.0, 0.0), _BETTER), (_by_roughness(after, before, surfaces[0]), 1.0)):
        begun = Placed(after, smooth, *surfaces, np.array(shift), np.array([*shift, 0.0, 0.0, 0.0]))
        try:
            left, fitted, cells = begun.fitted_to_frame()
            found.append((favor * left, fitted, cells))
        except FitError as error:
            failed = error
    if failed is not None and not found:
        raise failed
    _, best, cells = min(found, key=lambda one: one[0])
    return best, cells


def _by_roughness(after: HeightMap, before: HeightMap, surface: _Surface) -> tuple[float, float]:
    """Return the shift, m, by whole cells, at which the roughness of both maps correlates best."""
    wide, long = _step(after.x), _step(after.y)
    x, y = (_evenly(places, step) for places, step in ((before.x, wide), (before.y, long)))
    across, along = np.meshgrid(y, x, indexing="ij")
    there = np.where(surface.shows(along, across), surface.height(along, across), np.nan)
    one, other = _roughness(after), _roughness(HeightMap(x, y, there, np.ones_like(there), y))
    shape = one.shape[0] + other.shape[0], one.shape[1] + other.shape[1]

    def correlated(first: Column, second: Column) -> Column:
        return np.asarray(np.fft.irfft2(np.fft.rfft2(first, shape) * np.conj(np.fft.rfft2(second, shape)), shape))

    pairs = correlated(np.isfinite(after.height).astype(float), np.isfinite(there).astype(float))
    likely = pairs >= _LEAST_OVERLAP * np.count_nonzero(after.measured)
    score = np.where(likely, correlated(one, other) / np.sqrt(np.maximum(pairs, 1.0)), -np.inf)
    row, column = np.unravel_index(int(np.argmax(score)), shape)
    rows, columns = (
        int(place) - size * (place >= part) for place, size, part in zip((row, column), shape, one.shape, strict=True)
    )
    return float(after.x[0] + columns * wide - x[0]), float(after.y[0] + rows * long - y[0])


def _evenly(places: Column, step: float) -> Column:
    return np.arange(places[0], places[-1] + step / 2, step)


def _roughness(grid: HeightMap) -> Column:
    """Return the roughness of a map, in its own standard deviations; 0 where it was not measured."""
    from scipy.ndimage import gaussian_filter

    filled = _filled(grid)
    fine, coarse = (gaussian_filter(filled, width) for width in _ROUGH)
    found = fine - coarse
    # At the border a filter shows the slope of the form, which is there at no shift at all.
    seen = grid.measured & (from_edge(grid.inside()) > 2 * _ROUGH[1])
    if not np.any(seen):
        return np.zeros(filled.shape)
    found -= np.median(found[seen])  # which is the curvature of the form
    spread = robust_deviation(found[seen]) or 1.0
    return np.where(seen, np.clip(found / spread, -_CLIPPED, _CLIPPED), 0.0)


def _frame(both: Mask) -> Mask:
    """Return the cells along the edge of what two maps have in common."""
    return frame(both, from_edge(without_holes(both)))


def without_holes(cells: Mask) -> Mask:
    """Return some cells of a map with the holes among them."""
    from scipy.ndimage import binary_closing, binary_fill_holes

    closed = binary_closing(np.pad(cells, 2), np.ones((3, 3)))[2:-2, 2:-2]
    return np.asarray(binary_fill_holes(closed | cells))

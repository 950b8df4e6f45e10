"""What a specimen has lost between two height maps of the same place, one before and one after the test.

The map before is placed on the map after by the surroundings of the scar, which did not wear: shifted in both
directions, raised, tilted, and rotated if the maps clearly show a small rotation. Both maps contain the form of the
specimen and its roughness, so both cancel. Material gained counts as negative.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.errors import FitError
from tribopipe.base.units import show
from tribopipe.documents.quantity import Quantity
from tribopipe.evaluation.measurements.height_map import HeightMap, bridged, height_map
from tribopipe.evaluation.measurements.profile_levelling import Mask
from tribopipe.evaluation.measurements.tip_map import (
    EDGE,
    FEWEST_ACROSS,
    FEWEST_UNWORN,
    FRAME,
    IN_FORM,
    MAD,
    MARGIN,
    MOST_MISSING,
    NO_NOISE,
    SMOOTHED,
    SPIKE,
    SPIKE_WIDTH,
    STANDS_OUT,
    Roughness,
    by_sampling,
    dilated,
    from_edge,
    least_squares,
    through_fit,
)
from tribopipe.results.run import Profile

_ROUNDS, _STEPS, _CONVERGED = 15, 20, 1e-3
"""Searches for the scar; steps of a fit; share of the residual within which a fit has converged."""
_MEASURED = 0.5
"""Weight of the measured cells around a position from which on its height is known."""
_LEAST_OVERLAP = 0.3
"""Share of the map after the test that the map before it has to show."""
_TEXTURES, _CLIPPED = ((0.5, 1.5), (1.0, 3.0)), 4.0
"""Standard deviations of the Gaussian filters, in cells, between which the roughness is compared; and its own ones to
which what stands out is cut."""
_WAVINESS = 4.0
"""Standard deviation of the Gaussian filter, in cells, below which a surface is rough."""
_MOST_ROTATED, _CLEARLY = 0.05, 5.0
"""Largest rotation, rad; and standard uncertainties by which it must exceed zero."""
_OTHER_PLACE = 3.0
"""Residual of the registration over the roughness above which the maps show different surfaces."""
_FEWEST_AROUND = 0.5
"""Share of the cells around the scar that have to be unchanged."""
_WITHOUT_ROTATION, _WITH_ROTATION = 5, 6


@dataclass(frozen=True)
class _Before:
    """The map before the test, between its cells."""

    x: Column
    y: Column
    spline: Column
    """Coefficients of a cubic spline; beyond the map, those of its nearest cells."""
    known: Column
    """1 in cells that were measured, 0 in others."""

    @classmethod
    def of(cls, grid: HeightMap) -> _Before:
        """Return a map with its gaps filled."""
        from scipy.ndimage import distance_transform_edt, spline_filter

        filled, _ = bridged(grid.height)
        nearest = distance_transform_edt(np.isnan(filled), return_distances=False, return_indices=True)
        spline = spline_filter(filled[tuple(nearest)], order=3, mode="nearest")
        return cls(grid.x, grid.y, np.asarray(spline), grid.measured.astype(float))

    @property
    def steps(self) -> tuple[float, float]:
        """Distances between columns and between rows, m."""
        return _step(self.x), _step(self.y)

    def height(self, x: Column, y: Column) -> Column:
        """Return heights at these positions, m."""
        from scipy.ndimage import map_coordinates

        cells = self._cells(x, y)
        return np.asarray(map_coordinates(self.spline, cells, order=3, mode="nearest", prefilter=False))

    def measured(self, x: Column, y: Column) -> Mask:
        """Return which of these positions lie in or next to measured cells."""
        from scipy.ndimage import map_coordinates

        known = map_coordinates(self.known, self._cells(x, y), order=1, mode="constant", cval=0.0)
        return np.asarray(known > _MEASURED)

    def _cells(self, x: Column, y: Column) -> Column:
        along, across = self.steps
        return np.array([(y - self.y[0]) / across, (x - self.x[0]) / along])


def _step(places: Column) -> float:
    return float(places[1] - places[0])


@dataclass(frozen=True)
class _Unworn:
    """The surface before the test in the positions of the map after it."""

    before: _Before
    parameters: Column
    """Shift along and across, m; height, m; both slopes; rotation, rad."""

    @property
    def shift(self) -> tuple[float, float]:
        """By how much the map after is shifted, m."""
        return float(self.parameters[0]), float(self.parameters[1])

    def _places(self, grid: HeightMap) -> tuple[Column, Column]:
        x, y = np.broadcast_arrays(grid.x, grid.y[:, None])
        rotation = self.parameters[5]
        return np.asarray(x - self.parameters[0] + rotation * y), np.asarray(y - self.parameters[1] - rotation * x)

    def height(self, grid: HeightMap) -> Column:
        """Return its height in each cell, m."""
        _, _, top, along, across, _ = self.parameters
        return np.asarray(self.before.height(*self._places(grid)) + top + along * grid.x + across * grid.y[:, None])

    def measured(self, grid: HeightMap) -> Mask:
        """Return the cells of which the map before shows the surface."""
        return self.before.measured(*self._places(grid))

    def gradients(self, grid: HeightMap, parameters: int = _WITH_ROTATION) -> Column:
        """Return the derivatives of the height by its first parameters, the last axis."""
        x, y = self._places(grid)
        wide, long = (step / 2 for step in self.before.steps)
        along = (self.before.height(x + wide, y) - self.before.height(x - wide, y)) / (2 * wide)
        across = (self.before.height(x, y + long) - self.before.height(x, y - long)) / (2 * long)
        right, up = np.broadcast_arrays(grid.x, grid.y[:, None])
        columns = [-along, -across, np.ones_like(along), right, up, up * along - right * across]
        return np.stack(columns[:parameters], axis=-1)

    def moved(self, steps: Column) -> _Unworn:
        """Return the surface after steps of its first parameters."""
        return replace(self, parameters=self.parameters + np.append(steps, np.zeros(_WITH_ROTATION - len(steps))))

    def overlap(self, grid: HeightMap) -> Mask:
        """Return the cells that both maps show. Raises ``FitError`` where they are few."""
        both = grid.measured & self.measured(grid)
        share = np.count_nonzero(both) / np.count_nonzero(grid.measured)
        if share < _LEAST_OVERLAP:
            raise FitError(
                f"map: found that the map before the test shows {100 * share:.0f} % of the map after it; expected at "
                f"least {100 * _LEAST_OVERLAP:.0f} %; measure the same place, and check the units of both maps"
            )
        return both


@dataclass(frozen=True)
class MapDifference:
    """What a specimen has lost by two height maps, registered to each other by what did not wear."""

    grid: HeightMap
    surface: _Unworn
    parameters: int
    """Fitted parameters of the registration: with or without the rotation."""
    unworn: Mask
    """Cells by which the maps were registered."""
    overlap: Mask
    """Cells within both maps."""
    changed: Mask
    """Cells where the maps clearly differ."""
    lost: Column
    """Height lost in each cell, m, negative where material was gained; missing ones interpolated; 0 beyond the maps."""
    apart: Column
    """By how much two ways of interpolating missing cells differ, m."""

    @property
    def shift(self) -> tuple[float, float]:
        """By how much the map after the test is shifted along and across its scan lines, m."""
        return self.surface.shift

    @property
    def rotation(self) -> float:
        """Rotation, rad; 0 where the maps do not clearly show one."""
        return float(self.surface.parameters[5])

    @cached_property
    def scar(self) -> Mask:
        """The largest connected part of what has changed."""
        from scipy.ndimage import label

        parts, count = label(self.changed)
        volumes = np.bincount(parts.ravel(), (self.grid.area * np.abs(self.lost)).ravel(), count + 1)
        return np.asarray(parts == 1 + int(np.argmax(volumes[1:])))

    @property
    def reaches_edge(self) -> bool:
        """Whether the scar continues beyond the maps, as a wear track does."""
        return bool(np.any(dilated(self.scar, self.margin) & self._edge))

    @property
    def _edge(self) -> Mask:
        return np.asarray(from_edge(self.overlap) <= 1)

    @property
    def margin(self) -> int:
        """Cells by which the scar is taken wider than it is seen to be."""
        return _margin(self.changed)

    @property
    def lines(self) -> list[Profile]:
        """Scan lines of the map after the test minus the map before it, m, where both were measured."""
        found = []
        for place, lost, kept in zip(self.grid.y, self.lost, self.overlap, strict=True):
            if np.count_nonzero(kept) > len(kept) / 2:
                found.append(Profile(self.grid.x[kept], -lost[kept], float(place)))
        return found

    def volume(self) -> Quantity:
        """Return the volume lost, m³, with its standard uncertainty; negative where material was gained.

        It is V = Σ(before − after)·(area of a cell) over everything that has changed and a small margin around it.
        Changes that continue beyond the edge of the maps, apart from the scar, are uncertain as a whole.

        The standard uncertainty contains the difference of the two maps where nothing has changed, with its correlation
        in both directions, in the scar and through the registration; the distance between points; the boundary of the
        scar; and missing cells.

        Raises
        ------
        FitError
            If the scar reaches the edge of the maps, or too much of it is missing.
        """
        if self.reaches_edge:
            raise FitError(
                "map: found a change that reaches the edge of the two maps; expected surroundings that did not wear "
                "all around the scar in both maps; measure larger maps of the same place"
            )
        self._refuse_unmeasured()
        outside = self._beyond_edge()
        inner = self.changed & ~outside
        region = dilated(inner, self.margin) & ~outside
        weights = np.where(region, self.grid.area, 0.0)
        ring = dilated(inner, 2 * self.margin) & ~self.changed
        gradients = self.surface.gradients(self.grid, self.parameters)
        spread = math.hypot(
            Roughness.of(self.grid, self.unworn, self.lost, self.parameters).spread(
                through_fit(weights, gradients, self.unworn)
            ),
            by_sampling(self.grid, region, self.lost),
            self._within(ring) / math.sqrt(3),
            self._within(outside) / math.sqrt(3),
            float(np.sum(weights * self.apart)) / 2,
        )
        return Quantity(value=float(np.sum(weights * self.lost)), unit="m^3", standard_uncertainty=spread)

    def _within(self, part: Mask) -> float:
        return float(np.sum((self.grid.area * self.lost)[part]))

    def _beyond_edge(self) -> Mask:
        """Return the changes that continue beyond the edge of the maps."""
        from scipy.ndimage import label

        parts, _ = label(self.changed)
        return np.asarray(self.changed & np.isin(parts, np.unique(parts[self._edge])))

    def _refuse_unmeasured(self) -> None:
        both = self.grid.measured & self.surface.measured(self.grid)
        missing = float(np.mean(~both[self.scar]))
        if missing > MOST_MISSING:
            raise FitError(
                f"map: found no height values in {100 * missing:.0f} % of the scar, before or after the test; expected "
                f"at most {100 * MOST_MISSING:.0f} %; measure again with more light or a larger aperture"
            )


def map_difference(after: Sequence[Profile], before: Sequence[Profile]) -> MapDifference:
    """Register two height maps of the same place to each other, and return their difference.

    Shift, height and two slopes are fitted by least squares to the surroundings of the scar, from which everything that
    has changed is excluded iteratively; a rotation as well, if it is small and exceeds five standard uncertainties. The
    first shift is that at which the roughness of both maps correlates best. Heights of the map before are interpolated
    by a cubic spline, so that the distances between points may differ.

    Parameters
    ----------
    after, before
        Scan lines of the two maps, each with its position across.

    Returns
    -------
    MapDifference
        Height lost in each cell of the map after the test.

    Raises
    ------
    FitError
        If the maps are identical, overlap too little, differ in their surroundings, or do not show any change.
    """
    grid, earlier = height_map(after), height_map(before)
    if grid.height.shape == earlier.height.shape and np.array_equal(grid.height, earlier.height, equal_nan=True):
        raise FitError(
            "map: found identical maps before and after the test; expected two measurements; correct before in run.toml"
        )
    return _without_spikes(_find(grid, *_at_first(grid, earlier)))


def _at_first(grid: HeightMap, earlier: HeightMap) -> tuple[_Unworn, Mask]:
    """Return the surface registered by the edge of the map, and the cells there."""
    before, failed = _Before.of(earlier), None
    found: list[tuple[float, _Unworn, Mask]] = []
    for shift in (*(_likeliest_shift(grid, earlier, band) for band in _TEXTURES), (0.0, 0.0)):
        try:
            found.append(_robust(grid, _Unworn(before, np.array([*shift, 0.0, 0.0, 0.0, 0.0]))))
        except FitError as error:
            failed = error
    if failed is not None and not found:
        raise failed
    _, surface, frame = min(found, key=lambda one: one[0])
    return surface, frame


def _likeliest_shift(grid: HeightMap, earlier: HeightMap, band: tuple[float, float]) -> tuple[float, float]:
    """Return the shift, m, by whole cells, at which the roughness of both maps correlates most significantly."""
    wide, long = _step(grid.x), _step(grid.y)
    x, y = (_evenly(places, step) for places, step in ((earlier.x, wide), (earlier.y, long)))
    before = _Before.of(earlier)
    across, along = np.meshgrid(y, x, indexing="ij")
    there = np.where(before.measured(along, across), before.height(along, across), np.nan)
    one, other = _texture(grid.height, band), _texture(there, band)
    shape = one.shape[0] + other.shape[0], one.shape[1] + other.shape[1]

    def correlated(first: Column, second: Column) -> Column:
        return np.asarray(np.fft.irfft2(np.fft.rfft2(first, shape) * np.conj(np.fft.rfft2(second, shape)), shape))

    seen, shown = (np.isfinite(values).astype(float) for values in (grid.height, there))
    pairs = correlated(seen, shown)
    powers = correlated(one**2, shown) * correlated(seen, other**2)
    likely = pairs >= _LEAST_OVERLAP * np.sum(seen)
    agreement = correlated(one, other) * np.sqrt(np.abs(pairs) / np.maximum(powers, 1e-300))
    score = np.where(likely & (powers > 0), agreement, -1.0)
    row, column = np.unravel_index(int(np.argmax(score)), shape)
    rows, columns = (
        int(place) - size * (place >= part) for place, size, part in zip((row, column), shape, one.shape, strict=True)
    )
    return grid.x[0] + columns * wide - x[0], grid.y[0] + rows * long - y[0]


def _evenly(places: Column, step: float) -> Column:
    return np.arange(places[0], places[-1] + step / 2, step)


def _texture(heights: Column, band: tuple[float, float]) -> Column:
    """Return the roughness of a map, in its own standard deviations; 0 where it was not measured."""
    from scipy.ndimage import gaussian_filter

    filled, _ = bridged(heights)
    seen = np.isfinite(heights)
    y, x = (places - np.mean(places) for places in np.indices(heights.shape))
    shape = np.stack([np.ones(x.shape), x, y, x**2, x * y, y**2], axis=-1)
    form = shape @ least_squares(shape[seen], heights[seen])
    left = np.where(np.isfinite(filled), filled - form, 0.0)
    fine, coarse = (gaussian_filter(left, width) for width in band)
    found = fine - coarse
    # At the border a filter shows the slope of the form, which is there at no shift at all.
    seen &= from_edge(np.isfinite(filled)) > band[1]
    if not np.any(seen):
        return np.zeros(heights.shape)
    spread = MAD * float(np.median(np.abs(found[seen]))) or 1.0
    return np.where(seen, np.clip(found / spread, -_CLIPPED, _CLIPPED), 0.0)


def _frame(both: Mask) -> Mask:
    """Return the cells along the edge of the overlap."""
    away = from_edge(_filled(both))
    return np.asarray(both & (away <= max(1.0, FRAME * float(np.max(away)))))


def _filled(cells: Mask) -> Mask:
    from scipy.ndimage import binary_closing, binary_fill_holes

    closed = binary_closing(np.pad(cells, 2), np.ones((3, 3)))[2:-2, 2:-2]
    return np.asarray(binary_fill_holes(closed | cells))


def _robust(grid: HeightMap, surface: _Unworn) -> tuple[float, _Unworn, Mask]:
    """Register by least absolute deviations along the edge; return also the median of what is left, and the cells."""
    for _ in range(_STEPS):
        cells = _frame(surface.overlap(grid))
        left = (grid.height - surface.height(grid))[cells]
        if not np.any(surface.parameters[2:]):
            surface = surface.moved(np.array([0.0, 0.0, float(np.median(left)), 0.0, 0.0]))
            left = left - np.median(left)
        size = np.abs(left)
        weights = 1 / np.sqrt(np.maximum(size, 0.1 * float(np.median(size)) + np.finfo(float).tiny))
        gradients = surface.gradients(grid, _WITHOUT_ROTATION)[cells]
        steps = least_squares(gradients * weights[:, None], left * weights)
        surface = surface.moved(steps)
        if np.max(np.abs(gradients @ steps)) <= _CONVERGED * float(np.median(size)):
            break
    cells = _frame(surface.overlap(grid))
    return float(np.median(np.abs(grid.height - surface.height(grid))[cells])), surface, cells


def _fitted(grid: HeightMap, cells: Mask, surface: _Unworn, parameters: int) -> _Unworn:
    for _ in range(_STEPS):
        kept = cells & surface.overlap(grid)
        left = (grid.height - surface.height(grid))[kept]
        gradients = surface.gradients(grid, parameters)[kept]
        steps = least_squares(gradients, left)
        surface = surface.moved(steps)
        if np.max(np.abs(gradients @ steps)) <= _CONVERGED * float(np.std(left)):
            break
    return surface


def _rotated(grid: HeightMap, cells: Mask, surface: _Unworn) -> tuple[_Unworn, int]:
    """Return the surface with a rotation, if the maps clearly show a small one, and its number of parameters."""
    rotated = _fitted(grid, cells, surface, _WITH_ROTATION)
    kept = cells & rotated.overlap(grid)
    lost = np.where(kept, rotated.height(grid) - grid.height, 0.0)
    by_heights = np.zeros(kept.shape)
    by_heights[kept] = np.linalg.pinv(rotated.gradients(grid)[kept])[-1]
    spread = Roughness.of(grid, kept, lost, _WITH_ROTATION).spread(by_heights)
    clear = _CLEARLY * spread < abs(rotated.parameters[5]) < _MOST_ROTATED
    return (rotated, _WITH_ROTATION) if clear else (surface, _WITHOUT_ROTATION)


def _find(grid: HeightMap, surface: _Unworn, unworn: Mask) -> MapDifference:
    """Register the maps and find what has changed, each by the other, from a first guess on."""
    parameters = _WITHOUT_ROTATION
    for number in range(_ROUNDS):
        before, unworn = unworn, _seen(grid, surface, unworn, parameters).unworn
        if np.count_nonzero(unworn) < FEWEST_UNWORN * np.count_nonzero(grid.inside()):
            raise _different()
        surface = _fitted(grid, unworn, surface, parameters)
        if number == 1:
            surface, parameters = _rotated(grid, unworn, surface)
        elif np.array_equal(before, unworn):
            break
    found = replace(_seen(grid, surface, unworn, parameters), unworn=unworn & surface.overlap(grid))
    _refuse_other_surface(found)
    _refuse_coarse(found)
    return found


def _seen(grid: HeightMap, surface: _Unworn, unworn: Mask, parameters: int) -> MapDifference:
    """Return what a registration lets be seen of the change, and which cells are unworn then."""
    from scipy.ndimage import label, uniform_filter

    both = surface.overlap(grid)
    unworn = unworn & both
    lost, apart = bridged(np.where(both, surface.height(grid) - grid.height, np.nan))
    overlap = _filled(both) & np.isfinite(lost)
    lost, apart = (np.where(overlap, values, 0.0) for values in (lost, apart))
    smooth = uniform_filter(lost, SMOOTHED)
    noise = MAD * float(np.median(np.abs(smooth[unworn])))
    size = np.where(overlap, np.abs(smooth), 0.0)
    most = float(np.max(size))
    parts, count = label(size > max(EDGE * noise, IN_FORM / 4 * most))
    clear = max(STANDS_OUT * noise, IN_FORM * most)
    strong = np.bincount(parts.ravel(), (size > max(NO_NOISE * noise, IN_FORM * most)).ravel(), count + 1) > 0
    changed = strong[parts] & (parts > 0)
    if not np.any(changed):
        raise FitError(
            f"map: found no change: the maps differ by at most {show(most, None, 'm', 'um')} with a noise of "
            f"{show(noise, None, 'm', 'um')}; expected a scar with surroundings that did not wear in both maps; "
            "measure larger maps, or remove before from run.toml"
        )
    single = MAD * float(np.median(np.abs(lost[unworn])))
    level = both & (size <= clear) & (np.abs(lost) <= max(STANDS_OUT * single, clear))
    return MapDifference(
        grid, surface, parameters, level & ~dilated(changed, 2 * _margin(changed)), overlap, changed, lost, apart
    )


def _margin(changed: Mask) -> int:
    return max(2, math.ceil(MARGIN * math.sqrt(np.count_nonzero(changed) / math.pi)))


def _without_spikes(found: MapDifference) -> MapDifference:
    """Return the difference with spikes of either map treated as missing."""
    from scipy.ndimage import median_filter

    grid = found.grid
    level = median_filter(found.lost, SPIKE_WIDTH)
    off = np.abs(found.lost - level)
    spread = MAD * float(np.median(off[found.overlap]))
    spikes = found.overlap & (off > max(NO_NOISE * spread, SPIKE * float(np.max(np.abs(level)))))
    if not np.any(spikes):
        return found
    grid = replace(grid, height=np.where(spikes, np.nan, grid.height))
    return _find(grid, found.surface, found.unworn & ~spikes)


def _different(found: str = "surroundings that differ between the maps before and after the test") -> FitError:
    return FitError(
        f"map: found {found}; expected the same place with surroundings that did not wear; measure the same place "
        "again in the same orientation, and check the units of both maps"
    )


def _refuse_other_surface(found: MapDifference) -> None:
    """Refuse maps whose surroundings agree much worse than their roughness."""
    from scipy.ndimage import gaussian_filter

    grid = found.grid
    rough = grid.height - gaussian_filter(np.where(grid.measured, grid.height, found.surface.height(grid)), _WAVINESS)
    roughness, residual = (MAD * float(np.median(np.abs(one[found.unworn]))) for one in (rough, found.lost))
    around = found.overlap & ~dilated(found.scar, 2 * found.margin) & grid.measured
    if np.count_nonzero(found.unworn) < _FEWEST_AROUND * np.count_nonzero(around):
        raise _different()
    depth = float(np.max(np.abs(found.lost[found.scar])))
    if residual > max(_OTHER_PLACE * roughness, IN_FORM * depth):
        raise _different(
            f"surroundings that differ by {show(residual, None, 'm', 'um')} between the maps before and after the "
            f"test, with a roughness of {show(roughness, None, 'm', 'um')}"
        )


def _refuse_coarse(found: MapDifference) -> None:
    rows, columns = (int(np.count_nonzero(np.any(found.scar, axis=axis))) for axis in (1, 0))
    if min(rows, columns) < FEWEST_ACROSS:
        raise FitError(
            f"map: found {min(rows, columns)} points across the change; expected at least {FEWEST_ACROSS}; measure "
            "with a smaller distance between points and between scan lines"
        )

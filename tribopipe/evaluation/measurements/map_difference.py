"""What a specimen has lost between two height maps of the same place, one before and one after the test.

Both maps contain the form of the specimen and its roughness, so both cancel. Material gained counts as negative.
"""

import hashlib
import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache

import numpy as np

from tribopipe.base.arrays import Column, robust_deviation
from tribopipe.base.errors import FitError
from tribopipe.base.units import show
from tribopipe.documents.quantity import Quantity
from tribopipe.evaluation.measurements.height_map import HeightMap, bridged, dilated, from_edge, height_map, sags
from tribopipe.evaluation.measurements.map_registration import Placed, placed, without_holes
from tribopipe.evaluation.measurements.map_roughness import Roughness, by_sampling, through_fit
from tribopipe.evaluation.measurements.map_scars import (
    EDGE,
    FEWEST_ACROSS,
    FEWEST_UNWORN,
    IN_FORM,
    MOST_MISSING,
    NO_NOISE,
    SMOOTHED,
    STANDS_OUT,
    despiked,
    margin,
    spikes,
)
from tribopipe.evaluation.measurements.profile_levelling import Mask
from tribopipe.results.run import Profile

_ROUNDS, _ROTATED_IN = 15, 1
"""Searches for the scar; the one after which a rotation is looked for."""
_WAVINESS, _NO_NOISE = 4.0, 0.3
"""Standard deviation of the Gaussian filter, in cells, that leaves waviness; and its share of what single cells differ
by, above which it is no noise: of noise, a fourteenth is left."""
_OTHER_FORM = 3e-3
"""Waviness of the difference over the depth above which the maps show different surfaces."""
_FEWEST_AROUND = 0.5
"""Share of the cells around the scar that have to be unchanged."""


@dataclass(frozen=True)
class MapDifference:
    """What a specimen has lost by two height maps, registered to each other by what did not wear."""

    surface: Placed
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
    def grid(self) -> HeightMap:
        """The map after the test."""
        return self.surface.grid

    @property
    def shift(self) -> tuple[float, float]:
        """By how much the map after the test is shifted along and across its scan lines, m."""
        return self.surface.shift

    @property
    def rotation(self) -> float:
        """Rotation, rad; 0 where the maps do not clearly show one."""
        return self.surface.rotation

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
        return margin(self.changed)

    @cached_property
    def waviness(self) -> float:
        """By how much the maps differ over many cells where nothing wore, m; 0 if no more than their noise suggests."""
        from scipy.ndimage import gaussian_filter

        share = gaussian_filter(self.unworn.astype(float), _WAVINESS)
        wavy = gaussian_filter(np.where(self.unworn, self.lost, 0.0), _WAVINESS) / np.maximum(
            share, np.finfo(float).eps
        )
        found, single = (robust_deviation(one[self.unworn]) for one in (wavy, self.lost))
        return found if found > _NO_NOISE * single else 0.0

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
        in both directions, in the scar and through the registration, and its waviness; the distance between points; the
        boundary of the scar; and missing cells.

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
        through = through_fit(weights, self.surface.gradients, self.unworn, self.surface.solver(self.unworn))
        spread = math.hypot(
            Roughness.of(self.grid, self.unworn, self.lost, len(self.surface.parameters)).spread(through),
            by_sampling(self.grid, region, self.lost),
            self.waviness * float(np.sum(weights)),
            self._within(ring) / math.sqrt(3),
            self._within(outside) / math.sqrt(3),
            float(np.sum(weights * self.apart)) / 2,
            float(np.sum(weights * np.where(self.overlap, sags(self._seen), 0.0))),
        )
        return Quantity(value=float(np.sum(weights * self.lost)), unit="m^3", standard_uncertainty=spread)

    @property
    def _seen(self) -> Column:
        """Height lost in each cell, m; NaN where missing in one of the maps."""
        return np.where(self.surface.overlap(), self.surface.height - self.grid.height, np.nan)

    def _within(self, part: Mask) -> float:
        return float(np.sum((self.grid.area * self.lost)[part]))

    def _beyond_edge(self) -> Mask:
        """Return the changes that continue beyond the edge of the maps."""
        from scipy.ndimage import label

        parts, _ = label(self.changed)
        return np.asarray(self.changed & np.isin(parts, np.unique(parts[self._edge])))

    def _refuse_unmeasured(self) -> None:
        both = self.grid.measured & self.surface.measured
        missing = float(np.mean(~both[self.scar]))
        if missing > MOST_MISSING:
            raise FitError(
                f"map: found no height values in {100 * missing:.0f} % of the scar, before or after the test; expected "
                f"at most {100 * MOST_MISSING:.0f} %; measure again with more light or a larger aperture"
            )


def map_difference(after: Sequence[Profile], before: Sequence[Profile]) -> MapDifference:
    """Register two height maps of the same place to each other, and return their difference.

    Shift, height and two slopes are fitted to the surroundings of the scar, from which everything that has changed is
    excluded by turns; a rotation as well, where it is small and exceeds five standard uncertainties. Heights of the map
    before are interpolated by a cubic spline, so that the distances between points may differ.

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
    return _difference(_Scanned.of(after), _Scanned.of(before))


@dataclass(frozen=True)
class _Scanned:
    """Scan lines, equal to others of the same content."""

    content: bytes
    lines: Sequence[Profile] = field(compare=False)

    @classmethod
    def of(cls, lines: Sequence[Profile]) -> "_Scanned":
        """Return scan lines with a hash of their content."""
        found = hashlib.sha256()
        for line in lines:
            found.update(repr((line.across, len(line.position))).encode())
            found.update(np.ascontiguousarray(line.position).tobytes() + np.ascontiguousarray(line.height).tobytes())
        return cls(found.digest(), lines)


@lru_cache(maxsize=8)  # a run is asked for it several times: by its checks, its volumes, its depths
def _difference(after: _Scanned, before: _Scanned) -> MapDifference:
    grid, earlier = height_map(after.lines), height_map(before.lines)
    if grid.height.shape == earlier.height.shape and np.array_equal(grid.height, earlier.height, equal_nan=True):
        raise FitError(
            "map: found identical maps before and after the test; expected two measurements; correct before in run.toml"
        )
    return _without_spikes(_find(*placed(grid, earlier)))


def _find(surface: Placed, unworn: Mask) -> MapDifference:
    """Register the maps and find what has changed, each by the other, from a first guess on."""
    grid = surface.grid
    for number in range(_ROUNDS):
        before, unworn = unworn, _seen(surface, unworn).unworn
        if np.count_nonzero(unworn) < FEWEST_UNWORN * np.count_nonzero(grid.inside()):
            raise _different()
        surface = surface.fitted(unworn)
        if number == _ROTATED_IN:
            surface = surface.rotated(unworn)
        elif np.array_equal(before, unworn):
            break
    found = replace(_seen(surface, unworn), unworn=unworn & surface.comparable())
    _refuse_other_surface(found)
    _refuse_coarse(found)
    return found


def _seen(surface: Placed, unworn: Mask) -> MapDifference:
    """Return what a registration lets be seen of the change, and which cells are unworn then."""
    from scipy.ndimage import label, uniform_filter

    grid, both = surface.grid, surface.overlap()
    unworn = unworn & both
    lost, apart = bridged(np.where(both, surface.height - grid.height, np.nan))
    overlap = without_holes(both) & np.isfinite(lost)
    lost, apart = (np.where(overlap, values, 0.0) for values in (lost, apart))
    smooth = uniform_filter(lost, SMOOTHED)
    noise = robust_deviation(smooth[unworn])
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
    single = robust_deviation(lost[unworn])
    level = both & (size <= clear) & (np.abs(lost) <= max(STANDS_OUT * single, clear))
    unworn = level & ~dilated(changed, 2 * margin(changed))
    return MapDifference(surface, unworn, overlap, changed, lost, apart)


def _without_spikes(found: MapDifference) -> MapDifference:
    """Return the difference with spikes of either map treated as missing."""
    depth = float(np.max(np.abs(despiked(found.lost))))
    cells = spikes(found.lost, found.overlap, depth)
    return _find(found.surface.without(cells), found.unworn & ~cells) if np.any(cells) else found


def _different(found: str = "surroundings that differ between the maps before and after the test") -> FitError:
    return FitError(
        f"map: found {found}; expected the same place with surroundings that did not wear; measure the same place "
        "again in the same orientation, and check the units of both maps"
    )


def _refuse_other_surface(found: MapDifference) -> None:
    """Refuse maps whose surroundings differ, other than by noise, by too much in comparison with the depth."""
    around = found.overlap & ~dilated(found.scar, 2 * found.margin) & found.grid.measured
    if np.count_nonzero(found.unworn) < _FEWEST_AROUND * np.count_nonzero(around):
        raise _different()
    depth = float(np.max(np.abs(found.lost[found.scar])))
    if found.waviness > _OTHER_FORM * depth:
        raise _different(
            f"surroundings that differ by {show(found.waviness, None, 'm', 'um')} over many points between the maps "
            f"before and after the test, with a depth of {show(depth, None, 'm', 'um')}"
        )


def _refuse_coarse(found: MapDifference) -> None:
    rows, columns = (int(np.count_nonzero(np.any(found.scar, axis=axis))) for axis in (1, 0))
    if min(rows, columns) < FEWEST_ACROSS:
        raise FitError(
            f"map: found {min(rows, columns)} points across the change; expected at least {FEWEST_ACROSS}; measure "
            "with a smaller distance between points and between scan lines"
        )

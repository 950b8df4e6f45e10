"""The volume that a spherical tip has lost, from a height map of it.

The unworn sphere is fitted around the scar and the volume between it and the measured surface is integrated over the
scar, whatever the shape of the worn surface. A tilt of the specimen needs no parameter of its own: a sphere that is
turned is a sphere with its apex elsewhere, and the volume does not change.

The volume depends on the radius of the sphere some six times as strongly as that of a scar of known diameter does. The
map shows this radius as well, in its own scale of lengths. Both radii are combined with their uncertainties.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from tribopipe.base.arrays import Column, robust_deviation
from tribopipe.base.errors import FitError
from tribopipe.base.units import show
from tribopipe.documents.quantity import Quantity
from tribopipe.evaluation.measurements.height_map import HeightMap, bridged, dilated, from_edge, height_map
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
    frame,
    margin,
    spikes,
)
from tribopipe.evaluation.measurements.profile_levelling import Mask
from tribopipe.physics.geometry import cap_height
from tribopipe.results.run import Profile

_ROUNDS, _STEPS, _CONVERGED = 15, 10, 1e-9
_CERTAIN = 5.0
"""Standard uncertainties by which a volume must exceed zero."""
_CLEAR, _WRONG = 3.0, 0.25
"""Standard uncertainties of their difference by which the radius of the unworn surface contradicts that stated; and the
relative difference that is no error of scale."""
_PARAMETERS = 4
"""Position and height of the apex, and the radius."""


class MapVolume(NamedTuple):
    """Volume that a tip has lost below its sphere, by a map."""

    volume: Quantity
    """m³, with its standard uncertainty; that of the stated radius is not in it."""
    per_radius: float
    """Its derivative by the stated radius of the tip, m²; 0 where the map alone gives the radius."""
    radius: Quantity
    """Radius of the unworn surface by the map alone, m."""


def volume_below_sphere(lines: Sequence[Profile], radius: Quantity) -> MapVolume:
    """Return the volume between a sphere and the worn surface, by a height map.

    The volume is V = Σ(sphere − measured)·(area of a cell) over the scar and a small margin around it, on which the
    lost height is zero on average. Position and height of the apex, and the radius, are fitted to the unworn surface
    around the scar, from which worn and piled-up places and spikes are excluded by turns. The radius is the weighted
    mean of this one and that stated; where they contradict each other, that of the map, as the scale of an instrument
    or the form of a tip may be a little off.

    The standard uncertainty contains the roughness of the unworn surface, with its correlation in both directions, in
    the scar and through the fitted sphere; the distance between points; the boundary of the scar; and missing cells.

    Parameters
    ----------
    lines
        Scan lines of the map, each with its position across.
    radius
        Stated radius of the tip, m, with its standard uncertainty.

    Returns
    -------
    MapVolume
        The volume, its derivative by the stated radius, and the radius of the unworn surface.

    Raises
    ------
    FitError
        If the map shows no scar, only a part of it, or no sphere of this radius.
    """
    grid = height_map(lines)
    _refuse_too_wide(grid, radius.value)
    scar = _without_spikes(_find(grid, *_at_first(grid, radius.value)))
    _refuse_missing(scar)
    return _integrated(scar, radius)


def _refuse_too_wide(grid: HeightMap, radius: float) -> None:
    reach = max(float(grid.x[-1]), float(grid.y[-1]))
    if reach >= radius:
        raise FitError(
            f"map: found a map {show(2 * reach, None, 'm', 'mm')} long on a tip of radius "
            f"{show(radius, None, 'm', 'mm')}; expected a length less than the diameter of the tip; check the unit "
            "of the positions, and the radius"
        )


@dataclass(frozen=True)
class _Sphere:
    """Unworn surface of a tip."""

    radius: float
    x: float
    y: float
    top: float
    """Position and height of its apex, m."""

    def _below(self, grid: HeightMap) -> Column:
        return cap_height(scar_radius=np.hypot(grid.x - self.x, (grid.y - self.y)[:, None]), sphere_radius=self.radius)

    def height(self, grid: HeightMap) -> Column:
        """Return its height in each cell, m."""
        return np.asarray(self.top - self._below(grid))

    def gradients(self, grid: HeightMap) -> Column:
        """Return the derivatives of the height by x, y and height of the apex, the last axis, and by the radius."""
        below = self._below(grid)
        centre = self.radius - below
        along, across = np.broadcast_arrays(grid.x - self.x, (grid.y - self.y)[:, None])
        return np.stack([along / centre, across / centre, np.ones_like(below), below / centre], axis=-1)

    def moved(self, steps: Column, grid: HeightMap) -> "_Sphere":
        """Return the sphere after steps of its parameters. Raises ``FitError`` where the map would leave it."""
        x, y, top, radius = (old + float(step) for old, step in zip(self._parameters, steps, strict=True))
        if math.hypot(abs(x) + grid.x[-1], abs(y) + grid.y[-1]) >= math.sqrt(2) * radius:
            raise FitError(
                "map: found no spherical surface around the scar; expected the unworn tip there; check the units of "
                "positions and heights, and that heights increase outward from the tip"
            )
        return _Sphere(radius, x, y, top)

    @property
    def _parameters(self) -> tuple[float, float, float, float]:
        return self.x, self.y, self.top, self.radius


@dataclass(frozen=True)
class _Scar:
    """A worn tip in its map."""

    grid: HeightMap
    sphere: _Sphere
    unworn: Mask
    """Cells to which the sphere was fitted."""
    worn: Mask
    """Cells where the surface is seen to be below the sphere."""
    piled_up: Mask
    """Cells where it is clearly above."""
    lost: Column
    """Height lost in each cell, m, with missing ones interpolated; 0 where there is no map."""
    apart: Column
    """By how much two ways of interpolating missing cells differ, m."""

    @property
    def margin(self) -> int:
        """Cells by which the scar is taken wider than it is seen to be."""
        return margin(self.worn)

    @property
    def depth(self) -> float:
        """Greatest depth, m, of what is wider than a spike."""
        return float(np.max(despiked(self.lost)[self.worn]))

    def widened(self, cells: int) -> Mask:
        """Return the scar with so many cells around it, but no pile-up."""
        return dilated(self.worn, cells) & ~self.piled_up

    @property
    def solver(self) -> Column:
        """The matrix that turns deviations of the unworn cells into steps of the apex of a sphere of known radius."""
        return np.asarray(np.linalg.pinv(self.sphere.gradients(self.grid)[self.unworn][:, :3]))


def _at_first(grid: HeightMap, radius: float) -> tuple[_Sphere, Mask]:
    """Return the sphere along the edge of the map, and the cells there."""
    cells = frame(grid.measured, from_edge(grid.inside()))
    return _robust(grid, cells, _Sphere(radius, 0.0, 0.0, float(np.nanmax(grid.height)))), cells


def _find(grid: HeightMap, sphere: _Sphere, unworn: Mask) -> _Scar:
    """Find the unworn sphere and the scar, each by the other, from a first guess on."""
    away = from_edge(grid.inside())
    inside = away > 0
    for _ in range(_ROUNDS):
        scar = _seen(grid, inside, sphere, unworn)
        before, unworn = unworn, scar.unworn
        if np.count_nonzero(unworn) < FEWEST_UNWORN * np.count_nonzero(inside):
            _refuse_coarse(scar)
            raise _at_the_edge()
        sphere = _fitted(grid, unworn, sphere)
        if np.array_equal(before, unworn):
            break
    _refuse_coarse(scar)
    if np.any(dilated(scar.worn, scar.margin) & (away <= 1)):
        raise _at_the_edge()
    return replace(_seen(grid, inside, sphere, unworn), unworn=unworn)


def _robust(grid: HeightMap, cells: Mask, sphere: _Sphere) -> _Sphere:
    """Fit by least absolute deviations, which a scar in less than half of the cells does not draw off."""
    weights = np.ones(int(np.count_nonzero(cells)))
    for _ in range(_STEPS):
        gradients = sphere.gradients(grid)[cells]
        left = (grid.height - sphere.height(grid))[cells]
        steps = _least_squares(gradients * weights[:, None], left * weights)
        sphere = sphere.moved(steps, grid)
        left = np.abs(left - gradients @ steps)
        weights = 1 / np.sqrt(np.maximum(left, 0.1 * float(np.median(left)) + np.finfo(float).tiny))
    return sphere


def _least_squares(gradients: Column, left: Column) -> Column:
    scale = np.linalg.norm(gradients, axis=0)
    return np.asarray(np.linalg.lstsq(gradients / scale, left, rcond=None)[0] / scale, dtype=np.float64)


def _fitted(grid: HeightMap, cells: Mask, sphere: _Sphere) -> _Sphere:
    for _ in range(_STEPS):
        gradients = sphere.gradients(grid)[cells]
        steps = _least_squares(gradients, (grid.height - sphere.height(grid))[cells])
        sphere = sphere.moved(steps, grid)
        if np.max(np.abs(gradients @ steps)) <= _CONVERGED * float(np.ptp(grid.height[cells])):
            break
    return sphere


def _seen(grid: HeightMap, inside: Mask, sphere: _Sphere, unworn: Mask) -> _Scar:
    """Return what a sphere lets be seen of the scar, and which cells are unworn then."""
    from scipy.ndimage import label, uniform_filter

    lost, apart = bridged(sphere.height(grid) - grid.height)
    lost = np.where(inside & np.isfinite(lost), lost, 0.0)
    smooth = uniform_filter(lost, SMOOTHED)
    noise = robust_deviation(smooth[unworn])
    deepest = np.unravel_index(int(np.argmax(smooth)), smooth.shape)
    depth = float(smooth[deepest])
    if depth <= NO_NOISE * noise:
        raise FitError(
            f"map: found no scar: the deepest point is {show(depth, None, 'm', 'um')} below the sphere; expected a "
            "worn tip; check the radius of the tip, and that heights increase outward from it"
        )
    parts, _ = label(smooth > max(EDGE * noise, IN_FORM / 4 * depth))
    worn = parts == parts[deepest]
    single = robust_deviation(lost[unworn])
    clear = max(STANDS_OUT * noise, IN_FORM * depth)
    scar = _Scar(grid, sphere, unworn, worn, smooth < -clear, lost, apart)
    level = grid.measured & (np.abs(smooth) <= clear) & (np.abs(lost) <= max(STANDS_OUT * single, clear))
    return replace(scar, unworn=level & ~dilated(worn, 2 * scar.margin))


def _at_the_edge() -> FitError:
    return FitError(
        "map: found a scar that reaches the edge of the map; expected the unworn sphere all around the scar; measure "
        "a larger map, and check the radius of the tip"
    )


def _without_spikes(scar: _Scar) -> _Scar:
    """Return the scar with spikes treated as missing."""
    found = spikes(scar.lost, scar.grid.measured, scar.depth)
    if not np.any(found):
        return scar
    grid = replace(scar.grid, height=np.where(found, np.nan, scar.grid.height))
    return _find(grid, scar.sphere, scar.unworn & ~found)


def _refuse_coarse(scar: _Scar) -> None:
    grid, worn = scar.grid, scar.worn
    rows = grid.y[np.any(worn, axis=1)]
    through = int(np.count_nonzero((grid.lines >= rows[0]) & (grid.lines <= rows[-1])))
    columns = int(np.count_nonzero(np.any(worn, axis=0)))
    if min(through, columns) < FEWEST_ACROSS:
        found = f"{through} scan lines" if through < FEWEST_ACROSS else f"{columns} points of a scan line"
        raise FitError(
            f"map: found {found} across the scar; expected at least {FEWEST_ACROSS}; measure with a smaller distance "
            "between points and between scan lines, or export only the line through the middle of the scar"
        )


def _refuse_missing(scar: _Scar) -> None:
    grid, worn = scar.grid, scar.worn
    missing = float(np.sum(grid.area[worn & ~grid.measured]) / np.sum(grid.area[worn]))
    if missing > MOST_MISSING:
        raise FitError(
            f"map: found no height values in {100 * missing:.0f} % of the scar; expected at most "
            f"{100 * MOST_MISSING:.0f} %; measure again with more light or a larger aperture, or measure the "
            "diameter of the scar"
        )


def _integrated(scar: _Scar, radius: Quantity) -> MapVolume:
    """Return the volume with its uncertainty. Raises ``FitError`` where it is no larger than that allows."""
    region = scar.widened(scar.margin)
    weights = np.where(region, scar.grid.area, 0.0)
    missing, roughness = _in_holes(scar), Roughness.of(scar.grid, scar.unworn, scar.lost, _PARAMETERS)
    by_radius = _by_radius(scar, weights)
    seen = Quantity(value=scar.sphere.radius, unit="m", standard_uncertainty=roughness.spread(by_radius.of_heights))
    share = _share_of_stated(radius, seen)
    volume = float(np.sum(weights * (scar.lost + missing)))
    volume += share * by_radius.volume * (radius.value - seen.value)
    ring = scar.widened(2 * scar.margin) & ~scar.worn
    fitted = through_fit(weights, scar.sphere.gradients(scar.grid)[..., :3], scar.unworn, scar.solver)
    through = fitted + (1 - share) * by_radius.volume * by_radius.of_heights
    spread = math.hypot(
        roughness.spread(through),
        by_sampling(scar.grid, region, scar.lost),
        float(np.sum((scar.grid.area * scar.lost)[ring])) / math.sqrt(3),
        float(np.sum(weights * scar.apart)) / 2,
        float(np.sum(weights * missing)) / math.sqrt(3),
    )
    found = Quantity(value=volume, unit="m^3", standard_uncertainty=spread)
    if volume <= _CERTAIN * spread:
        raise FitError(
            f"map: found a volume of {found.shown('um^3')} below the sphere; expected a volume well above "
            "its uncertainty; check that the map shows the scar, and measure a larger map"
        )
    return MapVolume(found, share * by_radius.volume, seen)


def radii_differ(stated: Quantity, seen: Quantity) -> bool:
    """Return whether the radius of the unworn surface, m, contradicts the stated one."""
    spread = math.hypot(stated.u_or_zero, seen.u_or_zero)
    return abs(seen.value - stated.value) > _CLEAR * spread


def _share_of_stated(stated: Quantity, seen: Quantity) -> float:
    """Return the weight of the stated radius in the mean of both; 0 where they contradict each other.

    Raises ``FitError`` where they have nothing to do with each other.
    """
    off, spreads = seen.value - stated.value, (stated.u_or_zero, seen.u_or_zero)
    if abs(off) > max(_WRONG * stated.value, _CLEAR * spreads[1]):
        raise FitError(
            f"map: found a sphere of radius {seen.shown('mm')} around the scar; expected the radius of the tip, "
            f"{show(stated.value, None, 'm', 'mm')}; check the units of positions and heights, and the radius"
        )
    if radii_differ(stated, seen):
        return 0.0
    return spreads[1] ** 2 / (spreads[0] ** 2 + spreads[1] ** 2)


def _in_holes(scar: _Scar) -> Column:
    """Return what missing cells of the scar have lost more, m, if the worn surface is level there.

    Where the scar is looked for, missing cells are as deep as those around them, as if curved like the sphere.
    """
    height, _ = bridged(scar.grid.height)
    level = scar.sphere.height(scar.grid) - height
    return np.where(scar.worn & ~scar.grid.measured & np.isfinite(level), level - scar.lost, 0.0)


class _ByRadius(NamedTuple):
    """What the radius of the sphere does to a volume, and what heights do to that radius."""

    volume: float
    """∂V/∂R, m², the apex following."""
    of_heights: Column
    """∂R/∂z of each cell."""


def _by_radius(scar: _Scar, weights: Column) -> _ByRadius:
    gradients = scar.sphere.gradients(scar.grid)
    slope = gradients[..., 3]
    alone = slope - gradients[..., :3] @ (scar.solver @ slope[scar.unworn])
    shown = np.where(scar.unworn, alone, 0.0)
    return _ByRadius(float(np.sum(weights * alone)), shown / float(np.sum(shown**2)))

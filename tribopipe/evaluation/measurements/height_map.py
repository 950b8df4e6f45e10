"""A height map made of its scan lines: heights in cells of a grid, what is missing in it, and where it ends."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column
from tribopipe.base.errors import FitError
from tribopipe.base.units import show
from tribopipe.evaluation.measurements.profile_levelling import Mask
from tribopipe.results.run import Profile

FEWEST_LINES = 8
"""Scan lines below which a map is used line by line."""
_MOST_CELLS = 150
"""Cells along either side; of more points in a line, and of more lines, the means of blocks are taken."""
_BRIDGED = 0.02
"""Share of a scan line up to which a gap in it is bridged."""
_HALF_STEP = 0.51
"""Distance from a measured point, in steps, within which a height was measured."""
_MOST_STRETCHED = 4
"""Points of the grid along a line over those of the longest scan line, and missing lines over all lines, at most."""


@dataclass(frozen=True)
class HeightMap:
    """Heights in cells, one row per scan line or per block of them."""

    x: Column
    """Position of the columns along the scan lines, m, about the middle of the map."""
    y: Column
    """Position of the rows across them, m, about the middle of the map."""
    height: Column
    """Mean height of each cell, m, rows by columns; NaN where it was not measured."""
    area: Column
    """Area of each cell, m²."""
    lines: Column
    """Position of each measured scan line across, m, about the middle of the map."""

    @property
    def measured(self) -> Mask:
        """Cells with a height."""
        return np.isfinite(self.height)

    def inside(self) -> Mask:
        """Return the cells of the map: those measured, and those between two such in their row or column."""
        return _between(self.measured, 0) | _between(self.measured, 1)


def _between(cells: Mask, axis: int) -> Mask:
    before = np.logical_or.accumulate(cells, axis)
    after = np.flip(np.logical_or.accumulate(np.flip(cells, axis), axis), axis)
    return np.asarray(before & after)


def maps_of(profiles: Mapping[str, Profile]) -> dict[str, list[Profile]]:
    """Return the scan lines of each map, if all profiles are lines of maps with enough lines; else nothing."""
    found: dict[str, list[Profile]] = {}
    for profile in profiles.values():
        found.setdefault(profile.scan, []).append(profile)
    whole = all(len(lines) >= FEWEST_LINES and None not in [line.across for line in lines] for lines in found.values())
    return found if whole else {}


def height_map(lines: Sequence[Profile]) -> HeightMap:
    """Return the map that scan lines make up.

    Lines need not begin at the same position, nor have points at the same ones: heights are interpolated along each.
    Gaps of up to 2 % of a line are bridged, longer ones are missing, as are lines in a gap between lines.

    Raises ``FitError`` where two lines have the same position across.
    """
    lines = sorted(lines, key=lambda line: line.across or 0.0)
    across = np.array([line.across for line in lines], dtype=float)
    steps = np.diff(across)
    if np.any(steps <= 0):
        twice = show(float(across[np.argmin(steps)]), None, "m", "mm")
        raise FitError(
            f"map: found two scan lines at {twice}; expected a different position for each line; list the file once in "
            "run.toml, and export the map again"
        )
    along = _grid(lines)
    places, heights = _with_missing_lines(across, np.array([_heights(along, line) for line in lines]))
    middle = float(np.mean(across[[0, -1]]))
    return _in_cells(along - np.mean(along[[0, -1]]), places - middle, heights, across - middle)


def _with_missing_lines(across: Column, heights: Column) -> tuple[Column, Column]:
    """Return positions and heights of lines with empty ones in the gaps between them."""
    steps = np.diff(across)
    missing = np.rint(steps / np.median(steps)).astype(int) - 1
    missing = np.clip(missing, 0, _MOST_STRETCHED * len(across))
    parts = [
        np.linspace(start, start + step, count + 1, endpoint=False)
        for start, step, count in zip(across[:-1], steps, missing, strict=True)
    ]
    places = np.concatenate([*parts, across[-1:]])
    filled = np.full((len(places), heights.shape[1]), np.nan)
    filled[np.append(0, np.cumsum(missing + 1))] = heights
    return places, filled


def _grid(lines: Sequence[Profile]) -> Column:
    """Return evenly spaced positions along all of the lines."""
    first, last = min(line.position[0] for line in lines), max(line.position[-1] for line in lines)
    step = float(np.median(np.concatenate([np.diff(line.position) for line in lines])))
    most = _MOST_STRETCHED * max(len(line.position) for line in lines)
    return np.linspace(first, last, min(round((last - first) / step) + 1, most))


def _heights(along: Column, line: Profile) -> Column:
    """Return the heights of one line at these positions, m; NaN outside it and in its wide gaps."""
    position = line.position
    after = np.clip(np.searchsorted(position, along), 1, len(position) - 1)
    before = after - 1
    step, bridged = along[1] - along[0], _BRIDGED * (along[-1] - along[0])
    away = np.minimum(np.abs(along - position[before]), np.abs(along - position[after]))
    known = (along >= position[0]) & (along <= position[-1]) & (position[after] - position[before] <= bridged)
    return np.where(known | (away <= _HALF_STEP * step), np.interp(along, position, line.height), np.nan)


def _in_cells(along: Column, across: Column, heights: Column, lines: Column) -> HeightMap:
    """Return means of blocks; a block counts as measured by at least half of its points."""
    wide, long = np.gradient(along), np.gradient(across)
    rows, columns = _starts(len(across)), _starts(len(along))
    known = np.isfinite(heights)

    def added(values: NDArray[np.generic]) -> Column:
        return np.asarray(np.add.reduceat(np.add.reduceat(values.astype(float), rows, axis=0), columns, axis=1))

    count, points = added(known), added(np.ones_like(known))
    mean = np.divide(added(np.where(known, heights, 0.0)), count, out=np.full(count.shape, np.nan), where=count > 0)
    return HeightMap(
        np.add.reduceat(along, columns) / np.diff(np.append(columns, len(along))),
        np.add.reduceat(across, rows) / np.diff(np.append(rows, len(across))),
        np.where(2 * count >= points, mean, np.nan),
        np.outer(np.add.reduceat(long, rows), np.add.reduceat(wide, columns)),
        lines,
    )


def _starts(count: int) -> NDArray[np.intp]:
    """Return where each of at most so many blocks begins; blocks are alike."""
    return np.arange(0, count, -(-count // _MOST_CELLS))


def from_edge(inside: Mask) -> Column:
    """Return the distance of each cell from the edge of a map, in cells; 1 at the edge, 0 outside."""
    from scipy.ndimage import distance_transform_edt

    return np.asarray(distance_transform_edt(np.pad(inside, 1))[1:-1, 1:-1])


def dilated(part: Mask, cells: int) -> Mask:
    """Return a part of a map with so many cells around it."""
    from scipy.ndimage import binary_dilation

    return np.asarray(binary_dilation(part, iterations=cells)) if cells else part


def bridged(values: Column) -> tuple[Column, Column]:
    """Return values with those missing interpolated along rows and columns, and how much both ways differ.

    Of two ways the shorter gap counts more. What cannot be reached by either stays NaN.
    """
    along, gap_along = _interpolated(values)
    across, gap_across = (one.T for one in _interpolated(values.T))
    share = gap_across / (gap_along + gap_across)
    both = np.where(np.isnan(across), along, np.where(np.isnan(along), across, share * along + (1 - share) * across))
    missing = np.isnan(values)
    apart = np.where(missing & np.isfinite(along) & np.isfinite(across), np.abs(along - across), 0.0)
    return np.where(missing, both, values), apart


def sags(values: Column) -> Column:
    """Return how far off the values between those measured may be because these lie on a curve.

    What is interpolated across a hole is compared with what would be if the hole were twice as wide: for a parabola,
    that is off by four times as much.
    """
    near, _ = bridged(values)
    holes = np.isnan(values) & np.isfinite(near)
    if not np.any(holes):
        return np.zeros(values.shape)
    wider, _ = bridged(np.where(_around(holes), np.nan, values))
    return np.where(holes, np.abs(np.nan_to_num(wider - near)) / 3, 0.0)


def _around(holes: Mask) -> Mask:
    """Return holes, each made wider on all sides by half its width."""
    from scipy.ndimage import distance_transform_edt, label, maximum

    parts, count = label(holes)
    half = np.asarray(maximum(distance_transform_edt(holes), parts, np.arange(count + 1)))
    away, (rows, columns) = distance_transform_edt(~holes, return_indices=True)
    return np.asarray(away <= half[parts[rows, columns]])


def _interpolated(values: Column) -> tuple[Column, Column]:
    """Return each row with its gaps interpolated, NaN beyond its ends, and the length of the gap at each place."""
    filled, gaps = values.copy(), np.ones(values.shape)
    for row, gap in zip(filled, gaps, strict=True):
        there = np.flatnonzero(np.isfinite(row))
        if len(there) in (0, len(row)):
            continue
        holes = np.flatnonzero(np.isnan(row))
        row[holes] = np.interp(holes, there, row[there], left=np.nan, right=np.nan)
        after = np.clip(np.searchsorted(there, holes), 1, max(len(there) - 1, 1))
        gap[holes] = np.maximum(there[np.minimum(after, len(there) - 1)] - there[after - 1], 1)
    return filled, gaps

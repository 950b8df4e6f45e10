"""Scars in height maps: limits by which they are distinguished from the surface around them, and spikes in them."""

import math

import numpy as np

from tribopipe.base.arrays import Column, robust_deviation
from tribopipe.evaluation.measurements.profile_levelling import Mask

_FRAME = 0.2
"""Share of the greatest distance from the edge of the map within which the surface is first taken to be unworn."""
SMOOTHED = 3
"""Cells along either side over which heights are averaged where the scar is looked for."""
EDGE, STANDS_OUT, NO_NOISE = 2.0, 4.0, 8.0
"""Standard deviations of the noise: where the scar ends; what is not unworn; what is no noise in any cell."""
IN_FORM = 0.02
"""Share of the depth within which a surface may be unworn."""
_MARGIN = 0.06
"""Share of the scar's radius by which it is taken wider than where it is seen to end."""
_SPIKE, _SPIKE_WIDTH = 0.1, 5
"""Share of the depth, and cells of the median, by which a spike stands out of its neighborhood."""
FEWEST_UNWORN = 0.1
"""Share of the map that has to be unworn."""
FEWEST_ACROSS = 8
"""Scan lines, and columns of cells, that have to lead through a scar."""
MOST_MISSING = 0.25
"""Share of the scar that may be missing."""


def frame(cells: Mask, away: Column) -> Mask:
    """Return those of some cells that lie along the edge of a map, by the distance of each cell from it."""
    return np.asarray(cells & (away <= max(1.0, _FRAME * float(np.max(away)))))


def margin(scar: Mask) -> int:
    """Return the number of cells by which a scar is taken wider than it is seen to be."""
    return max(2, math.ceil(_MARGIN * math.sqrt(np.count_nonzero(scar) / math.pi)))


def despiked(lost: Column) -> Column:
    """Return the median of the height lost around each cell, m, in which no spike is left."""
    from scipy.ndimage import median_filter

    return np.asarray(median_filter(lost, _SPIKE_WIDTH))


def spikes(lost: Column, seen: Mask, depth: float) -> Mask:
    """Return the seen cells that differ from their neighborhood by more than noise and a share of the depth, m."""
    off = np.abs(lost - despiked(lost))
    return np.asarray(seen & (off > max(NO_NOISE * robust_deviation(off[seen]), _SPIKE * depth)))

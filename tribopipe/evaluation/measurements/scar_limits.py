"""Limits by which a scar is distinguished from the surface around it in a height map."""

FRAME = 0.2
"""Share of the greatest distance from the edge of the map within which the surface is first taken to be unworn."""
SMOOTHED = 3
"""Cells along either side over which heights are averaged where the scar is looked for."""
EDGE, STANDS_OUT, NO_NOISE = 2.0, 4.0, 8.0
"""Standard deviations of the noise: where the scar ends; what is not unworn; what is no noise in any cell."""
IN_FORM = 0.02
"""Share of the depth within which a surface may be unworn."""
MARGIN = 0.06
"""Share of the scar's radius by which it is taken wider than where it is seen to end."""
SPIKE, SPIKE_WIDTH = 0.1, 5
"""Share of the depth, and cells of the median, by which a spike stands out of its neighborhood."""
FEWEST_UNWORN = 0.1
"""Share of the map that has to be unworn."""
FEWEST_ACROSS = 8
"""Scan lines, and columns of cells, that have to lead through a scar."""
MOST_MISSING = 0.25
"""Share of the scar that may be missing."""

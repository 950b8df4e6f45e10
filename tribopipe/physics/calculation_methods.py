"""Names of what a computation can be done by: wear engines, ways of counting distance, contact solvers, wear laws."""

from typing import Literal

LAW_GROUP = "tribopipe.laws"
"""Group of entry points that declare wear laws."""
LAW_PATTERN = "(?!(.*_)?disc$)[a-z][a-z0-9_]*"
"""Pattern of the names of wear laws."""
WearEngine = Literal["giwm", "volume", "local"]
"""How the depth of a pin follows from its worn volume: under uniform pressure and elastic approach, as the GIWM has
it; by
its shape alone, so that k_D·F_N·s is the volume missing from its shape; or by the local contact pressure."""
DistanceConvention = Literal["full-slip", "contact-width", "line-load", "volume-conserving"]
"""Convention for the sliding distance of a point of a disc in one rotation (tribopipe.physics.twin_disc)."""
Engine = Literal["rings", "half-space", "fe"]
"""Contact solvers: rings, a half space under rectangles, or finite elements."""
Scheme = Literal["implicit", "explicit"]
Course = Literal["implicit", "explicit", "economy"]
"""A scheme that solves the contact at each step, or UMESHMOTION's correction (tribopipe.physics.local.economy)."""

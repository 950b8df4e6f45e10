"""Points that are fine where a contact begins, and further out as fine as its radius there needs."""

import numpy as np

from tribopipe.base.arrays import Column


def graded(finest: float, last: float, share: float) -> Column:
    """Return points from 0 to ``last``, m: spacings are the finest near 0, further out a share of the distance."""
    points = [0.0]
    while points[-1] < last:
        points.append(points[-1] + max(finest, share * points[-1]))
    return np.asarray(np.array(points) * (last / points[-1]))

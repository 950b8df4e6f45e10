"""Arrays of numbers in SI, inputs of which many values are drawn at once, and the scatter of noisy values."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

Column = NDArray[np.float64]
Numbers = float | Column
"""One value, or as many as are drawn."""
Values = Mapping[str, Numbers]
"""One value of each uncertain input, or columns of draws of shape (draws, 1), which broadcast against samples."""
MAD_TO_DEVIATION = 1.4826
"""Standard deviation of a normal distribution over its median absolute deviation."""


def robust_deviation(values: Column) -> float:
    """Return the standard deviation about zero by the median of the absolute values, which outliers hardly affect."""
    return MAD_TO_DEVIATION * float(np.median(np.abs(values)))

"""Arrays of numbers in SI, and inputs of which many values are drawn at once."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

Column = NDArray[np.float64]
Numbers = float | Column
"""One value, or as many as are drawn."""
Values = Mapping[str, Numbers]
"""One value of each uncertain input, or columns of draws of shape (draws, 1), which broadcast against samples."""

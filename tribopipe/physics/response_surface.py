"""A quadratic in many inputs, fitted to points that were computed, and a good guess of all others.

Inputs above zero enter by their logarithm, since what wears is about a product of powers of them.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column


@dataclass(frozen=True)
class Inputs:
    """Rows of inputs that vary, scaled so that each is about as large as 1."""

    scaled: Column
    """(rows, inputs)."""

    @classmethod
    def of(cls, columns: Column) -> "Inputs":
        """Scale inputs, (rows, inputs); those that do not vary are left out."""
        columns = columns[:, np.ptp(columns, axis=0) > 0]
        positive = np.min(columns, axis=0, initial=np.inf) > 0
        columns = np.where(positive, np.log(np.where(positive, columns, 1.0)), columns)
        return cls((columns - np.mean(columns, axis=0)) / np.std(columns, axis=0))

    @cached_property
    def terms(self) -> Column:
        """1, each input, and each product of two: (rows, terms)."""
        first, second = np.triu_indices(self.scaled.shape[1])
        products = self.scaled[:, first] * self.scaled[:, second]
        return np.concatenate([np.ones((len(products), 1)), self.scaled, products], axis=1)


def extended(inputs: Inputs, known: NDArray[np.intp], results: Column) -> Column:
    """Return results of all rows, by a quadratic through those ``known``, (rows,): indices of ``results``' rows."""
    coefficients, *_ = np.linalg.lstsq(inputs.terms[known], results, rcond=None)
    return np.asarray(inputs.terms @ coefficients)

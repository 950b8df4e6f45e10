"""Wear coefficients of thousands of draws where the course of wear is explicit in some growth of the contact.

A search for k_D that asks for the wear after some progress inverts the course in each round: some thirty integrals for
a draw of two discs. Here the growth at each place is found along with k_D by Newton's method, so that a round takes
one integral, and most draws start next to their solution: a quadratic in the inputs through the first of them gives it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError
from tribopipe.contacts.wear import ExplicitWear, Row
from tribopipe.evaluation.wear.least_squares import least_squares
from tribopipe.physics.response_surface import Inputs, extended

_FIRST = 500
"""Draws that the others' start is interpolated from."""
_SLICE = 2_000
"""Draws solved at a time, so that their arrays stay in the processor's cache."""
_MOST_ROUNDS = 12
_MISSED = 1e-5
"""Relative difference of progress to which a state is corrected by its slope; what is left is about its square."""


@dataclass(frozen=True)
class ExplicitDraws:
    """Draws of what was measured on the bodies, and of the inputs that their wear depends on."""

    wearing: ExplicitWear
    rows: Sequence[Row]
    root_weights: Column
    """Inverse standard uncertainty of each row."""
    unknowns: int
    """Number of k_D that are found; those of further bodies are 0."""
    values: dict[str, Column]
    """Columns of shape (draws, 1)."""
    measured: Column
    """(draws, rows)."""
    progress: Column
    """Effective progress at each place, (draws, places)."""

    def solved(self, start: Column, tolerance: float) -> Column:
        """Return the logarithms of k_D of each draw, (draws, bodies), NaN where one does not settle.

        ``start`` has the logarithms of k_D of each body and of the growth at each place, (bodies + places,).
        """
        starts = np.broadcast_to(start, (len(self.measured), len(start)))
        found = np.full(starts.shape, np.nan)
        for first, last in pairwise([0, *range(_FIRST, len(found), _SLICE), len(found)]):
            part = np.arange(first, last)
            found[part] = self._of(part).settled(starts[part], tolerance)
            if first == 0 and last < len(found):
                starts = self._foreseen(found, starts)
        return found[:, : len(start) - self.progress.shape[1]]

    def _of(self, draws: NDArray[np.intp]) -> "ExplicitDraws":
        values = {name: column[draws] for name, column in self.values.items()}
        return replace(self, values=values, measured=self.measured[draws], progress=self.progress[draws])

    def _foreseen(self, found: Column, starts: Column) -> Column:
        """Return starts of all draws by a quadratic through those that are found, where there are enough of these."""
        inputs = Inputs.of(np.concatenate(list(self.values.values()), axis=1))
        (known,) = np.nonzero(np.all(np.isfinite(found), axis=1))
        return extended(inputs, known, found[known]) if len(known) > 2 * inputs.terms.shape[1] else starts

    def settled(self, starts: Column, tolerance: float) -> Column:
        """Return logarithms of k_D and of growth from a start, NaN where a draw does not settle."""
        try:
            with np.errstate(all="ignore"):
                return self._newton(starts, tolerance)
        except (ContactError, np.linalg.LinAlgError):  # one of them is no contact, which the others are not to suffer
            return np.full(starts.shape, np.nan)

    def _newton(self, starts: Column, tolerance: float) -> Column:
        course, bodies = self.wearing.course(self.values), starts.shape[1] - self.progress.shape[1]
        log_k, log_growth = starts[:, :bodies].copy(), starts[:, bodies:]
        places = [row.place for row in self.rows]
        settled = np.zeros(len(starts), dtype=bool)
        for _ in range(_MOST_ROUNDS):
            coefficients = self._coefficients(log_k)
            reached = course.at(np.exp(log_growth), *(coefficients[:, [body]] for body in range(bodies)))
            missed = np.log(self.progress / reached.progress)
            slopes = self.wearing.slopes(self.values, reached.state, reached.progress, self.rows)
            # All k_D together count as progress does.
            model = self.wearing.measured(reached.state, self.rows) + np.sum(slopes, axis=-1) * missed[:, places]
            design = slopes[..., : self.unknowns] * self.root_weights[:, None]
            step = np.clip(least_squares(design, (self.measured - model) * self.root_weights), -1.0, 1.0)
            log_k[:, : self.unknowns] += step
            more = np.log(np.sum(self._coefficients(log_k), axis=1) / np.sum(coefficients, axis=1))
            log_growth = log_growth + np.clip(reached.slope * (missed + more[:, None]), -1.0, 1.0)
            settled = (np.max(np.abs(step), axis=1) < tolerance) & (np.max(np.abs(missed), axis=1) < _MISSED)
            if np.all(settled):
                break
        return np.where(settled[:, None], np.concatenate([log_k, log_growth], axis=1), np.nan)

    def _coefficients(self, log_k: Column) -> Column:
        coefficients = np.exp(log_k)
        coefficients[:, self.unknowns :] = 0.0
        return coefficients

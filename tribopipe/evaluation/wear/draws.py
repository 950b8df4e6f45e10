"""k_D of one run for draws of everything uncertain (JCGM 101:2008).

What is systematic is drawn once per run; the sensor's noise is drawn row by row, with the variance its autocorrelation
leaves the mean of a row.
"""

from collections.abc import Callable

import numpy as np
from numpy.random import Generator

from tribopipe.base.arrays import Column, Values
from tribopipe.evaluation.wear.inputs import draw_values
from tribopipe.evaluation.wear.problem import WearProblem

_SLICE = 1_000
"""Draws solved at a time, so that their rows stay in the processor's cache."""
_TOLERANCE = 1e-7
"""Of ln k_D in a draw: far below any uncertainty of k_D."""


def solve_draws(problem: WearProblem, values: Values, noise: Column) -> Column:
    """Return k_D, m²/N, of each draw of the inputs, columns of shape (draws, 1), and of the noise on each row."""
    solved = []
    for first in range(0, len(noise), _SLICE):
        part = slice(first, first + _SLICE)
        some = {name: np.asarray(column)[part] for name, column in values.items()}
        solved.append(problem.solve(some, noise[part], _TOLERANCE))
    return np.concatenate(solved)


def coefficient_draws(problem: WearProblem) -> Callable[[Generator, int], Column]:
    """Return the model of a Monte Carlo: k_D, m²/N, for as many draws as asked for."""
    reduced = problem.pooled()

    def draw(rng: Generator, count: int) -> Column:
        values = draw_values(reduced.inputs, reduced.friction_covariance, rng, count)
        return solve_draws(reduced, values, reduced.draw_scores(rng, count))

    return draw

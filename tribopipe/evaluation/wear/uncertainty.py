"""Uncertainty of a wear coefficient: first-order budget, and draws for Monte Carlo.

First-order propagation after JCGM 100:2008, 5.1.3 and 5.2.2; Monte Carlo after JCGM 101:2008. What is systematic is
drawn once per run; the sensor's noise is drawn row by row, with the variance its autocorrelation leaves the mean of a
row.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np
from numpy.random import Generator

from tribopipe.base.arrays import Column, Values
from tribopipe.evaluation.wear.inputs import FRICTION_INPUTS, FrictionCovariance, draw_values
from tribopipe.evaluation.wear.problem import WearProblem
from tribopipe.results.input_quantities import Inputs, shown_unit
from tribopipe.results.wear_fit import FRICTION_FIT, Contribution

NOISE = "noise of the depth signal"


def budget(problem: WearProblem, coefficient: float) -> tuple[Contribution, ...]:
    """Return what the uncertainty of k_D by a depth signal is made of, the largest part first."""
    moved = problem.sensitivities(coefficient, [*problem.inputs])
    noise = Contribution(name=NOISE, source="fit", relative=problem.random_uncertainty(coefficient))
    return budget_lines(problem.inputs, problem.friction_covariance, moved, noise)


def budget_lines(
    inputs: Inputs, friction: FrictionCovariance, sensitivities: Mapping[str, float], *others: Contribution
) -> tuple[Contribution, ...]:
    """Return the lines of a budget from ∂ln k_D/∂x of each input, the largest first."""
    lines = [*others]
    if friction is not None:
        slopes = np.array([sensitivities[name] for name in FRICTION_INPUTS])
        variance = float(slopes @ np.asarray(friction) @ slopes)
        lines.append(Contribution(name=FRICTION_FIT, source="fit", relative=math.sqrt(max(0.0, variance))))
    lines += [
        Contribution(
            name=name.replace("_", " "),
            value=given.quantity,
            shown_in=shown_unit(name, given.quantity),
            source=given.source,
            relative=sensitivities[name] * given.spread,
        )
        for name, given in inputs.items()
        if name not in FRICTION_INPUTS
    ]
    return tuple(sorted(lines, key=lambda line: -abs(line.relative)))


def relative_uncertainty(lines: Iterable[Contribution]) -> float:
    """Return the standard uncertainty of k_D over k_D, by a budget."""
    return math.hypot(*(line.relative for line in lines))


def input_covariance(inputs: Inputs, friction: FrictionCovariance, names: Sequence[str]) -> Column:
    """Return the covariance of inputs, which are independent but for the friction fit."""
    found = np.diag([inputs[name].spread ** 2 for name in names])
    if friction is not None:
        places = [names.index(name) for name in FRICTION_INPUTS]
        found[np.ix_(places, places)] = friction
    return found


_SLICE = 1_000
"""Draws solved at a time, so that their rows stay in the processor's cache."""
_TOLERANCE = 1e-7
"""Tolerance of ln k_D in a draw: far below any uncertainty of k_D."""


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

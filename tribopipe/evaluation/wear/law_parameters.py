"""Parameters of a wear law in addition to k_D that nobody gave, found with it.

They are found by least squares over the parameters alone, k_D being solved for at each try (variable projection). From
then on they are free by first-order propagation: what they can explain of rows is projected out of them, as zero
offsets and drift are in a joint fit. So budget and draws of k_D have them free as well.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from typing import TypeVar

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.errors import FitError
from tribopipe.evaluation.wear.inputs import indistinct
from tribopipe.evaluation.wear.problem import Tangent, WearProblem
from tribopipe.physics.laws import WearLaw

P = TypeVar("P", bound=WearProblem)
_STARTS = 7
"""Starting points of a search over a positive parameter, spread over its decades."""
_AS_GOOD = 4.0
"""Difference of χ² that noise makes."""
_NEAR = 1e-3
"""Relative distance from a bound below which a parameter is taken to be at the bound."""


def with_fitted_law(problem: P) -> P:
    """Return a problem with those parameters of its law fitted that are not among its inputs.

    One that is found at 0 is held there, and so is one that has no effect. Raises ``FitError`` where the depth shows no
    wear, or where one is found at another end of where it is sought.
    """
    names = _sought(problem)
    if not names:
        return problem
    law, free = _Search(problem.condensed(), names).best()
    found = replace(problem, law=law)
    return replace(found, tangent=Tangent(free, found.coefficient()))


def _sought(problem: WearProblem) -> tuple[str, ...]:
    """Return the parameters of the law that nobody gave."""
    return tuple(name for name in problem.law.parameters() if problem.law.input_of(name) not in problem.inputs)


def _end(law: WearLaw, name: str) -> float | None:
    """Return the end of where a parameter is sought that it stands at; None if it stands between them."""
    known, value = law.parameters()[name], law.values()[name]
    near = (end for end in (known.low, known.high) if abs(value - end) < _NEAR * law.scale_of(name, end))
    return next(near, None)


def held_notes(problem: WearProblem) -> tuple[str, ...]:
    """State for each fitted parameter that is held why it is."""
    return tuple(_held(problem.law, name) for name in _sought(problem) if name not in problem.fitted_parameters)


def undetermined_notes(problem: WearProblem, covariance: Column | None) -> tuple[str, ...]:
    """State which fitted parameters have a standard uncertainty larger than their value.

    ``covariance`` is that of ln k_D and the fitted parameters, SI.
    """
    if covariance is None:
        return ()
    spreads, values = np.sqrt(np.diag(covariance))[1:], problem.law.values()
    pairs = zip(problem.fitted_parameters, spreads.tolist(), strict=True)
    wide = [name.replace("_", " ") for name, spread in pairs if spread > abs(values[name])]
    if not wide:
        return ()
    return (
        f"the run does not determine {' and '.join(wide)} of {problem.law.title}: the standard uncertainty is larger "
        f"than the value; state known values under [wear.parameters.{problem.law.name}] in a recipe, or fit a law "
        "without these parameters",
    )


def _held(law: WearLaw, name: str) -> str:
    called = name.replace("_", " ")
    if _end(law, name) == 0:
        return (
            f"{called} is fixed at its fitted value of 0, so that k_D and its uncertainty are those of a fit without it"
        )
    return f"{called} has no effect on the wear of this run: its value is meaningless"


class _Search:
    """Search for the law parameters that fit a run best; positive parameters as logarithms.

    Others are counted in what they start at.
    """

    def __init__(self, problem: WearProblem, names: Sequence[str]) -> None:
        self.problem, self.names = problem, names
        known, start = problem.law.parameters(), problem.law.values()
        self.known = [known[name] for name in names]
        self.logarithmic = np.array([one.low > 0 for one in self.known])
        self.unit = np.array([problem.law.scale_of(name, 1.0 if known[name].low > 0 else 0.0) for name in names])
        self.start = self._sought([start[name] for name in names])
        self.bounds = self._sought([one.low for one in self.known]), self._sought([one.high for one in self.known])
        self.rows = problem.rows(problem.values)
        self.length = float(np.linalg.norm(self.rows * problem.root_weights))

    def law(self, sought: Column) -> WearLaw:
        """Return the law with its parameters as they are sought."""
        values = np.where(self.logarithmic, np.exp(np.where(self.logarithmic, sought, 0.0)), sought * self.unit)
        return replace(self.problem.law, **dict(zip(self.names, values.tolist(), strict=True)))

    def left(self, sought: Column) -> Column:
        """Return what the law with its best k_D leaves of each weighted row, over the length of them all."""
        tried = replace(self.problem, law=self.law(sought))
        coefficient = float(tried.solve(tried.values))
        log_k = np.log(coefficient) if coefficient > 0 else -np.inf
        depth, _ = tried.model(np.asarray(log_k), tried.values)
        return tried.without_free((self.rows - depth) * tried.root_weights) / self.length

    def best(self) -> tuple[WearLaw, tuple[str, ...]]:
        """Return the law with which the misfit is least, and which of its parameters are free.

        The search begins at each start with a few tries and goes on from the best of them; from others that are as good
        where a parameter runs away. Raises ``FitError`` where one always does.
        """
        rough = [self._least(np.array(start), most=20) for start in product(*self._starts())]
        misfits = [self._misfit(sought) for sought in rough]
        as_good = [place for place in np.argsort(misfits) if misfits[place] < min(misfits) + _AS_GOOD]
        found = (self._settled(self.law(self._least(rough[place], most=200))) for place in as_good)
        for law, free in found:
            if all(_end(law, name) is None for name in free):
                return law, free
        raise FitError(indistinct(self.problem.law, self.names))

    def _settled(self, law: WearLaw) -> tuple[WearLaw, tuple[str, ...]]:
        """Return a law with what is found at 0 held there, and the parameters that then have an effect."""
        zero = {name: 0.0 for name in self.names if _end(law, name) == 0}
        problem = replace(self.problem, law=replace(law, **zero))

        def matters(name: str) -> bool:
            return bool(np.any(problem.law_slope(name, lambda moved: moved.effective_distance(moved.values))))

        return problem.law, tuple(name for name in self.names if name not in zero and matters(name))

    def _misfit(self, sought: Column) -> float:
        """Return the sum of squares that is left, over the variance of the noise."""
        problem = self.problem
        one_sample = problem.root_weights[0] ** 2 * problem.noise / problem.weights[0]
        return float(np.sum(self.left(sought) ** 2) * self.length**2 / one_sample)

    def _least(self, start: Column, most: int) -> Column:
        from scipy.optimize import least_squares

        inside = np.clip(start, *self.bounds)
        found = least_squares(self.left, inside, bounds=self.bounds, xtol=1e-12, ftol=1e-14, gtol=1e-14, max_nfev=most)
        return np.asarray(found.x)

    def _starts(self) -> list[list[float]]:
        ends = zip(self.start, self.logarithmic, *self.bounds, strict=True)
        return [
            np.linspace(low, high, _STARTS + 2)[1:-1].tolist() if logarithmic else [start]
            for start, logarithmic, low, high in ends
        ]

    def _sought(self, values: Sequence[float]) -> Column:
        column = np.asarray(values, dtype=float)
        return np.where(self.logarithmic, np.log(np.where(self.logarithmic, column, 1.0)), column / self.unit)

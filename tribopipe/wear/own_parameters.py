"""Parameters of a wear law beside k_D: given in a recipe, or found with it.

What is given is an input like any other. What is not is found by least squares over the parameters alone, k_D being
solved for at each try (variable projection). From then on it is free to first order: what it can explain of rows is
projected out of them, as zero offsets and drift are in a joint fit. So budget and draws of k_D have it free as well.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from tribopipe.errors import FitError, did_you_mean
from tribopipe.records.quantity import Quantity, read_quantity
from tribopipe.records.recipe import LawName, Recipe
from tribopipe.run import Column
from tribopipe.units import show
from tribopipe.wear.laws import LawParameter, WearLaw, law_named

if TYPE_CHECKING:
    from tribopipe.wear.problem import WearProblem

P = TypeVar("P", bound="WearProblem")
_STARTS = 7
"""Of a search over a parameter that is above zero, spread over its decades."""
_STEP = 1e-4
"""Of a difference quotient, relative."""


@dataclass(frozen=True)
class Tangent:
    """The parameters of a law that are free, to first order about the best estimate."""

    names: tuple[str, ...]
    coefficient: float
    """k_D there, m²/N."""


def given_parameters(law: WearLaw, recipe: Recipe) -> dict[str, Quantity]:
    """Return the parameters that a recipe gives of a law. Raises ``FitError`` where it cannot have them."""
    written, known = recipe.wear.parameters.get(law.name, {}), law.parameters()
    return {name: _read(law, name, said, known) for name, said in written.items()}


def _read(law: WearLaw, name: str, said: Any, known: Mapping[str, LawParameter]) -> Quantity:
    where = f"wear.parameters.{law.name}.{name}"
    if name not in known:
        raise FitError(f"{where}: found a parameter that {law.title} has not; {did_you_mean(name, known)}")
    try:
        quantity = read_quantity(said, known[name].kind)
    except ValueError as error:
        raise FitError(f"{where}: {error}") from None
    low, high = known[name].low, known[name].high
    if not low <= quantity.value <= high:
        ends = " to ".join(show(end, None, quantity.unit) for end in (low, high))
        raise FitError(f"{where}: found {quantity}; expected {ends}; correct it")
    return quantity


def law_as_given(name: LawName, recipe: Recipe) -> WearLaw:
    """Return a law with its parameters as a recipe gives them.

    Raises ``FitError`` where the law is not installed here, or has a parameter that is not given.
    """
    law = law_named(name)
    values = {law.input_of(known): given.value for known, given in given_parameters(law, recipe).items()}
    require_all(law, values)
    return law.at(values)


def require_all(law: WearLaw, values: Mapping[str, float]) -> None:
    """Raise ``FitError`` where a parameter of a law is not among the values of inputs."""
    if missing := [parameter for parameter in law.parameters() if law.input_of(parameter) not in values]:
        raise FitError(
            f"{law.title}: found no {' and no '.join(missing)}; expected them given, since only the fit of one pin "
            f"finds them; write them under [wear.parameters.{law.name}] in a recipe"
        )


def with_fitted_law(problem: P) -> P:
    """Return a problem with those parameters of its law fitted that are not among its inputs.

    Raises ``FitError`` where the depth shows no wear.
    """
    names = tuple(name for name in problem.law.parameters() if problem.law.input_of(name) not in problem.inputs)
    if not names:
        return problem
    search = _Search(problem.condensed(), names)
    law = search.law(search.polished(min(search.rough(), key=search.misfit)))
    found = replace(problem, law=law)
    return replace(found, tangent=Tangent(names, found.coefficient()))


class _Search:
    """For the parameters of a law with which k_D follows a run best; those above zero by their logarithms."""

    def __init__(self, problem: "WearProblem", names: Sequence[str]) -> None:
        self.problem, self.names = problem, names
        known, start = problem.law.parameters(), problem.law.values()
        self.known = [known[name] for name in names]
        self.logarithmic = np.array([one.low > 0 for one in self.known])
        self.start = self._sought([start[name] for name in names])
        self.bounds = self._sought([one.low for one in self.known]), self._sought([one.high for one in self.known])
        self.rows = problem.rows(problem.values)
        self.unit = float(np.linalg.norm(self.rows * problem.root_weights))

    def law(self, sought: Column) -> WearLaw:
        """Return the law with its parameters as they are sought."""
        values = np.where(self.logarithmic, np.exp(np.where(self.logarithmic, sought, 0.0)), sought)
        return replace(self.problem.law, **dict(zip(self.names, values.tolist(), strict=True)))

    def left(self, sought: Column) -> Column:
        """Return what the law with its best k_D leaves of each weighted row, over the length of them all."""
        tried = replace(self.problem, law=self.law(sought))
        coefficient = float(tried.solve(tried.values))
        log_k = np.log(coefficient) if coefficient > 0 else -np.inf
        depth, _ = tried.model(np.asarray(log_k), tried.values)
        return tried.without_free((self.rows - depth) * tried.root_weights) / self.unit

    def misfit(self, sought: Column) -> float:
        """Return the sum of squares that is left."""
        return float(np.sum(self.left(sought) ** 2))

    def rough(self) -> list[Column]:
        """Return where the search ends that begins at each start, with a few tries."""
        return [self._least(np.array(start), most=20) for start in product(*self._starts())]

    def polished(self, sought: Column) -> Column:
        """Return the least misfit near a place."""
        return self._least(sought, most=200)

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
        return np.where(self.logarithmic, np.log(np.where(self.logarithmic, column, 1.0)), column)


def law_columns(problem: "WearProblem", tangent: Tangent, rows_of: Callable[["WearProblem"], Column]) -> Column:
    """Return how each row of the model moves with the parameters of its law that are free: rows by parameters."""
    values, known = problem.law.values(), problem.law.parameters()
    columns = []
    for name in tangent.names:
        step = _STEP * (abs(values[name]) or known[name].high - known[name].low)
        low, high = (
            rows_of(replace(problem, law=replace(problem.law, **{name: values[name] + sign * step}), tangent=None))
            for sign in (-1, 1)
        )
        columns.append((high - low) / (2 * step))
    return np.stack(columns, axis=-1)


def law_covariance(problem: "WearProblem", coefficient: float) -> Column:
    """Return the covariance of ln k_D and the parameters that are free, in SI, to first order (JCGM 100:2008, 5.2).

    Of the noise of the reading and of every input, those of the friction fit by their own covariance.
    """
    _, slope = problem.model(np.log(coefficient), problem.values)
    design = np.column_stack([slope * problem.root_weights, problem.law_columns, problem.linear])
    length = np.linalg.norm(design, axis=0)
    pull = (np.linalg.pinv(design / length) / length[:, None])[: 1 + problem.law_columns.shape[1]]
    samples = len(problem.distance)
    noisy = pull[:, :samples] * problem.root_weights[:samples] * np.sqrt(problem.noise / problem.weights)
    names = [name for name in problem.inputs if problem.inputs[name].spread]
    moved = dict(zip(names, problem.shifts(names, coefficient) * problem.root_weights @ pull.T, strict=True))
    together, covariance = problem.friction_together(), problem.friction_covariance
    alone = [shift for name, shift in moved.items() if name not in together]
    found = noisy @ noisy.T + sum((np.outer(shift, shift) for shift in alone), np.zeros((len(pull), len(pull))))
    if together:
        per_unit = np.column_stack([moved[name] / problem.inputs[name].spread for name in together])
        found = found + per_unit @ np.asarray(covariance) @ per_unit.T
    return np.asarray(found)

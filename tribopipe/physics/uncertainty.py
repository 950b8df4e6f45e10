"""Propagation of uncertainty: term by term (JCGM 100:2008), and of distributions by Monte Carlo (JCGM 101:2008).

A model is anything that turns a random generator and a number of draws into that many values of the measurand, or of
several that belong together (JCGM 102:2011). The number of draws is chosen as in 7.9.4: blocks of 10 000 are added
until value, standard uncertainty and both ends of the 95 % interval are stable in the digits asked for.

Where a model is too slow for that many draws, a quadratic in its inputs, a response surface, is fitted to some of
them. Inputs above zero enter by their logarithm, since what wears is about a product of powers of them.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from tribopipe.base.arrays import Column
from tribopipe.base.errors import FitError


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


BLOCK = 10_000
"""Draws in a block: at least 10⁴ and 100/(1 − p) for a coverage probability p (JCGM 101:2008, 7.9.4 b)."""
TAILS = (0.025, 0.975)
"""Ends of the probabilistically symmetric 95 % interval (7.7.2)."""
_MOST_BLOCKS = 100


@dataclass(frozen=True)
class Distribution:
    """Values of a measurand drawn as its inputs vary."""

    draws: Column
    stable: bool = True
    """Whether the digits asked for were reached before the draws ran out."""
    rejected: int = 0
    """Number of draws for which the model had no value."""

    @property
    def mean(self) -> float:
        """Estimate of the measurand (7.6)."""
        return float(np.mean(self.draws))

    @property
    def standard_uncertainty(self) -> float:
        """Standard deviation of the draws (7.6)."""
        return float(np.std(self.draws, ddof=1))

    @cached_property
    def interval(self) -> tuple[float, float]:
        """Probabilistically symmetric 95 % coverage interval (7.7)."""
        low, high = np.quantile(self.draws, TAILS)
        return float(low), float(high)


def numerical_tolerance(standard_uncertainty: float, digits: int) -> float:
    """Return half a unit of the last of the significant digits of a standard uncertainty (7.9.2)."""
    if not standard_uncertainty > 0:
        return 0.0
    exponent = math.floor(math.log10(standard_uncertainty)) - digits + 1
    return 0.5 * 10.0**exponent


def propagate(model: Callable[[Generator, int], Column], *, digits: int = 1, seed: int = 0) -> Distribution:
    """Draw from a model of one measurand until ``digits`` significant digits of its uncertainty are stable (7.9.4).

    Draws for which the model has no value, NaN, are not accepted.
    """
    (found,) = propagate_together(lambda rng, count: model(rng, count)[:, None], digits=digits, seed=seed)
    return found


def propagate_together(
    model: Callable[[Generator, int], Column], *, digits: int = 1, seed: int = 0
) -> tuple[Distribution, ...]:
    """Draw from a model of several measurands, (draws, measurands), until each is stable as in ``propagate``.

    Draw i of one belongs to draw i of the others; where one has no value, none is accepted.

    Every block has a generator of its own, spawned from ``seed``, so that the first blocks are the same however many
    follow.
    """
    blocks: list[Column] = []
    told: list[list[tuple[float, ...]]] = []
    for child in np.random.SeedSequence(seed).spawn(_MOST_BLOCKS):
        drawn = model(np.random.Generator(np.random.PCG64(child)), BLOCK)
        blocks.append(drawn[np.all(np.isfinite(drawn), axis=1)])
        told.append([(one.mean, one.standard_uncertainty, *one.interval) for one in _columns(blocks[-1])])
        whole = np.concatenate(blocks)
        if not len(whole):
            raise FitError(
                f"Monte Carlo: found no solution in {BLOCK} draws; expected the inputs to determine k_D; check "
                "the standard uncertainties"
            )
        stable = len(blocks) > 1 and _settled(np.asarray(told), _columns(whole), digits)
        if stable:
            break
    rejected = len(blocks) * BLOCK - len(whole)
    return tuple(Distribution(one.draws, stable, rejected) for one in _columns(whole))


def _columns(draws: Column) -> list[Distribution]:
    return [Distribution(draws[:, place]) for place in range(draws.shape[1])]


def _settled(told: Column, whole: list[Distribution], digits: int) -> bool:
    """Return whether twice the standard deviation of each block mean is below the tolerance (7.9.4 g to i)."""
    scatter = np.std(told, axis=0, ddof=1) / math.sqrt(len(told))
    tolerance = [[numerical_tolerance(one.standard_uncertainty, digits)] for one in whole]
    return bool(np.all(2 * scatter <= tolerance))


def first_order_holds(first_order: tuple[float, float], distribution: Distribution, digits: int) -> bool:
    """Return whether both ends of a first-order interval agree with those of the Monte Carlo (8.1.3)."""
    tolerance = numerical_tolerance(distribution.standard_uncertainty, digits)
    return all(abs(a - b) <= tolerance for a, b in zip(first_order, distribution.interval, strict=True))

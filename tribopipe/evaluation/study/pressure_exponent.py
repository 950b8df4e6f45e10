"""Exponent m of a wear rate that is proportional to p^m, from runs whose contacts differ in pressure.

With the mean pressure p = F_N/A of the contact, dV/ds = k·F_N·(p/p₀)^(m−1) wears a volume V over the effective distance
s. A law of m = 1 then finds the wear coefficient k_D = V/(F_N·s), so that

    ln k = ln k_D + ln⟨(p/p₀)^(1−m)⟩,

with the mean over the volume that was lost, on which p depends by the shape of the contact alone. k is the same in all
runs: m is found by generalized least squares of ln k_D, with the covariance of the runs' own k_D, and as much scatter
between runs as makes χ² as large as its degrees of freedom (Paule and Mandel).
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError
from tribopipe.documents.quantity import Quantity, wear_coefficient
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.evaluation.study.member import Member
from tribopipe.evaluation.wear.prediction import run_scenario
from tribopipe.evaluation.wear.scenario import given_wear
from tribopipe.results.study import PressureExponent

_FEWEST_RUNS = 4
"""With three, scatter between runs is hardly seen."""
_SURELY_WORN = 0.99
"""Share of the draws in which a body has worn."""
_LEAST_RANGE = math.log(1.15)
"""Range of ln F_N and of ln p below which loads and pressures are as good as the same.

Tests of different length differ in pressure as well, but what changes with time would count as an effect of pressure.
"""
_OWN = 1e-6
"""Share of its variance that each run has for itself at least: with none, their covariance has no inverse."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)
_CONVERGED = 1e-10
_MOST_ITERATIONS = 100
_BOUND = 5.0
"""|m − 1| beyond which no exponent is looked for."""


@dataclass(frozen=True)
class PressedRun:
    """A run's own wear coefficient, and the pressure of its contact while it wore."""

    load: float
    """N."""
    log_coefficient: float
    """ln k_D by the law."""
    log_draws: Column
    """The same in each draw."""
    log_pressure: Column
    """ln p at the nodes of an integral over the lost volume."""


def pressed_run(
    member: Member, coefficients: Mapping[str, float], draws: Column, end: float, law: LawName, recipe: Recipe
) -> PressedRun | None:
    """Return the pressure of a run up to its end; None where its first body has not worn.

    ``coefficients`` are the run's own k_D by body, ``draws`` those of the first one, m²/N.
    """
    best = next(iter(coefficients.values()))
    if not best > 0 or np.mean(draws > 0) < _SURELY_WORN:
        return None
    run = member.corrected.run
    stated = {body: wear_coefficient(value) for body, value in coefficients.items()}
    scenario = run_scenario(run, law, given_wear(run.manifest.described, stated, recipe), member.friction, recipe)
    lost = scenario.effective(np.asarray(end)) * ((1 + _NODES) / 2) ** 2
    try:
        pressure = np.asarray(scenario.wear.worn(scenario.values, lost)["pressure"], dtype=float)
    except ContactError:
        return None
    load = scenario.normal_load.value
    return PressedRun(load, math.log(best), np.log(np.where(draws > 0, draws, best)), np.log(pressure))


def pressure_exponent(runs: Sequence[PressedRun]) -> PressureExponent | None:
    """Return m with its 95 % interval; None of few runs, or where loads or pressures do not differ."""
    if len(runs) < _FEWEST_RUNS or np.ptp(np.log([run.load for run in runs])) < _LEAST_RANGE:
        return None
    pressure = np.stack([run.log_pressure for run in runs])
    if np.ptp(_mean_power(pressure, 0.0)[1]) < _LEAST_RANGE:
        return None
    y = np.array([run.log_coefficient for run in runs])
    own = np.cov(np.stack([run.log_draws for run in runs]))
    own += _OWN * np.diag(np.diag(own))
    scatter = _scatter(y, pressure, own)
    found = _fitted(y, pressure, own + scatter**2 * np.eye(len(runs)))
    if found is None:
        return None
    m, spread, _ = found
    half = _coverage(len(runs) - 2 if scatter else math.inf) * spread
    return PressureExponent(
        exponent=Quantity(value=m, unit="1", standard_uncertainty=spread),
        interval=(Quantity(value=m - half, unit="1"), Quantity(value=m + half, unit="1")),
        runs=len(runs),
        scatter=scatter,
    )


def _coverage(freedom: float) -> float:
    from scipy.stats import t

    return float(t.ppf(0.975, freedom))


def _mean_power(log_pressure: Column, power: float) -> tuple[Column, Column]:
    """Return ln⟨p^power⟩ over the lost volume of each run, and its derivative by the power."""
    # Over V ∝ x², in whose root p is smooth at the start.
    weight = _WEIGHTS * (1 + _NODES) / 2
    top = log_pressure.max(axis=-1, keepdims=True) * power if power else np.zeros((len(log_pressure), 1))
    raised = weight * np.exp(power * log_pressure - top)
    total = raised.sum(axis=-1)
    return np.log(total / weight.sum()) + top[:, 0], (raised * log_pressure).sum(axis=-1) / total


def _fitted(y: Column, pressure: Column, covariance: Column) -> tuple[float, float, float] | None:
    """Return m, its standard uncertainty and χ², by Gauss and Newton; None where they find none."""
    inverse = np.linalg.inv(covariance)
    m = 1.0
    for _ in range(_MOST_ITERATIONS):
        logs, slope = _mean_power(pressure, 1 - m)
        design = np.stack([np.ones(len(y)), slope], axis=1)
        normal = design.T @ inverse @ design
        solved = np.linalg.solve(normal, design.T @ inverse @ (y + logs))
        step = float(solved[1])
        m += step
        if abs(m - 1) > _BOUND:
            return None
        if abs(step) < _CONVERGED:
            residual = y + logs - solved[0]
            return m, math.sqrt(float(np.linalg.inv(normal)[1, 1])), float(residual @ inverse @ residual)
    return None


def _scatter(y: Column, pressure: Column, own: NDArray[np.float64]) -> float:
    """Return the scatter of ln k between runs for which χ² is as large as its degrees of freedom."""
    from scipy.optimize import brentq

    freedom, unit = len(y) - 2, np.eye(len(y))

    def excess(scatter: float) -> float:
        found = _fitted(y, pressure, own + scatter**2 * unit)
        return -float(freedom) if found is None else found[2] - freedom

    most = float(np.ptp(y)) + 1e-12
    if excess(0.0) <= 0 or excess(most) >= 0:
        return 0.0 if excess(0.0) <= 0 else most
    return float(brentq(excess, 0.0, most))

"""Effective k_D against friction, from a measured curve (paper, Fig. 5).

By Archard's law the worn volume grows as dV = k·F_N·ds, whatever the contact. So over a window from s₁ to s₂

k_eff = [V(h₂) − V(h₁)] / [F_N·(s₂ − s₁)]

with V(h) the pin's exact volume at a measured depth, next to the groove of the disc: no derivative is taken and no
pressure estimated. Sarkar's law gives k_eff = k_D·√(1 + 3μ²). Windows are of about equal wear, several pooled stretches
wide; that is the smoothing, and its bias is what the same windows make of Sarkar's own curve.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.evaluation.load_and_friction import measured_path
from tribopipe.evaluation.study.member import PosedRun
from tribopipe.evaluation.wear.inputs import distance_scale
from tribopipe.physics.friction_path import junction_factor

_DRAWS = 2_000
_STRETCHES = 3
"""Pooled stretches in a window."""


@dataclass(frozen=True)
class EffectiveCoefficient:
    """k_eff of one run in windows along its distance."""

    run_id: str
    sliding_distance: Column
    """Middle of each window, m."""
    friction: Column
    """Mean measured friction coefficient in each window."""
    coefficient: Column
    """k_eff, m²/N."""
    standard_uncertainty: Column
    """Standard uncertainty of k_eff, m²/N: sensor noise, zero offset, post-test measurement, load and the like."""
    bias: Column
    """Relative error that the windows make of Sarkar's own curve."""


def effective_coefficient(run: PosedRun, seed: int = 1) -> EffectiveCoefficient | None:
    """Return k_eff along a run; None if no friction was measured."""
    path = measured_path(run.member.corrected.run)
    if path is None:
        return None
    # What Sarkar's law misses is what the figure is to show: no part of the error bars.
    run = replace(run, problem=replace(run.problem, missed=0.0))
    edges = np.arange(0, len(run.places) - 1, _STRETCHES)
    places = run.places[edges]
    draws = run.draw(np.random.Generator(np.random.PCG64(seed)), _DRAWS, {})
    drawn = _slopes(run, draws.measured()[:, edges], draws.values)
    best = _slopes(run, run.measured()[edges], run.problem.values)
    friction = _means(path.coefficient, places)
    law = _slopes(run, run.predicted(run.coefficient)[edges], run.problem.values)
    return EffectiveCoefficient(
        run_id=run.member.id,
        sliding_distance=(places[1:] + places[:-1]) / 2,
        friction=friction,
        coefficient=best,
        standard_uncertainty=np.std(drawn, axis=0),
        bias=law / (run.coefficient * junction_factor(friction)) - 1,
    )


def _slopes(run: PosedRun, depth: Column, values: dict[str, float] | dict[str, Column]) -> Column:
    problem = run.problem
    distance = run.places[np.arange(0, len(run.places) - 1, _STRETCHES)]
    # Noise about the very start may read as wear below zero.
    volume = problem.volume(np.maximum(depth, 0.0), values, distance)
    scale, load = distance_scale(values, problem.values), problem.load
    path = distance if load is None else np.interp(distance, load.distance, load.path)
    return np.asarray(np.diff(volume, axis=-1) / (values["normal_load"] * scale * np.diff(path)))


def _means(coefficient: Callable[[Column], Column], edges: Column) -> Column:
    fine = np.linspace(edges[:-1], edges[1:], 200)
    return np.asarray(np.mean(coefficient(fine), axis=0))

"""The joint fit by first-order propagation, to compare the fits of the package with."""

from dataclasses import dataclass

import numpy as np

from tribopipe.base.arrays import Column, Values
from tribopipe.documents.quantity import Quantity
from tribopipe.evaluation.wear.drift_and_wear import JointProblem
from tribopipe.evaluation.wear.inputs import FRICTION_INPUTS

_LEAST_SPREAD = 1e-12
"""Standard uncertainty, m, of a post-test measurement stated as exact: it cannot be weighted without bound."""


@dataclass(frozen=True)
class JointFit:
    """Zero offsets, drift rate and k_D estimated together, by first-order propagation."""

    zero_offsets: tuple[Quantity, ...]
    """Sensor reading at the start of sliding, and after each remounting less what drift had added."""
    drift_rate: Quantity
    """Drift rate of the sensor: slope of the linear drift against time."""
    wear_coefficient: Quantity
    """k_D."""
    end_wear_depth: Quantity
    """Pin wear depth at the end by the fitted law."""
    end_value_deviation: float
    """Post-test measurement of the pin minus fitted depth, over the post-test measurement's standard uncertainty."""
    anchors: int
    """Number of depths measured on the pin, at interruptions and at the end."""


def fit_joint(problem: JointProblem) -> JointFit:
    """Estimate zero offsets, drift rate and k_D together, by first-order propagation (JCGM 100:2008, 5.1.2 and 5.2)."""
    values = problem.values
    best = problem.coefficient()
    covariance = _statistical_covariance(problem, best) + _systematic_covariance(problem)
    *offsets, drift = problem.offsets_and_drift(np.asarray(best), values)
    log_spread, *offset_spreads, drift_spread = np.sqrt(np.diag(covariance))
    duration, end = problem.trace.duration, problem.end.pin_depth
    depths = problem.model(np.log(best), values)[0][len(problem.distance) :]
    return JointFit(
        zero_offsets=tuple(
            Quantity(value=value, unit="m", standard_uncertainty=spread)
            for value, spread in zip(offsets, offset_spreads, strict=True)
        ),
        drift_rate=Quantity(value=drift / duration, unit="m/s", standard_uncertainty=drift_spread / duration),
        wear_coefficient=Quantity(value=best, unit="m^2/N", standard_uncertainty=best * log_spread),
        end_wear_depth=Quantity(value=float(depths[0]), unit="m"),
        end_value_deviation=(end.value - float(depths[0])) / max(end.standard_uncertainty or 0.0, _LEAST_SPREAD),
        anchors=len(problem.anchors),
    )


def _parameters(problem: JointProblem, values: Values) -> Column:
    """Return ln k_D, zero offsets and drift, one row a draw."""
    coefficient = problem.solve(values)
    return np.concatenate([np.log(coefficient)[..., None], problem.offsets_and_drift(coefficient, values)], axis=-1)


def _statistical_covariance(problem: JointProblem, coefficient: float) -> Column:
    """Return the covariance of ln k_D, zero offsets and drift by noise and post-test measurements, (JᵀWJ)⁻¹."""
    _, slope = problem.model(np.log(coefficient), problem.values)
    design = np.column_stack([slope * problem.root_weights, problem.linear, problem.law_columns])
    # Columns of length one: ln k_D and metres differ by many orders of magnitude.
    length = np.linalg.norm(design, axis=0)
    root = np.linalg.inv(np.linalg.qr(design / length)[1]) / length[:, None]
    found = 1 + problem.linear.shape[1]
    return np.asarray(root @ root.T)[:found, :found]


def _systematic_covariance(problem: JointProblem) -> Column:
    """Return what the inputs add, friction by its covariance; anchors are among the rows and their weights."""
    anchors = {anchor.name for anchor in problem.anchors}
    friction = FRICTION_INPUTS if problem.friction_covariance is not None else ()
    names = [name for name, given in problem.inputs.items() if given.spread and name not in anchors]
    low, high = np.split(_parameters(problem, problem.moved(names)), 2)
    moved = dict(zip(names, (high - low) / 2, strict=True))
    alone = [shift for name, shift in moved.items() if name not in friction]
    covariance = np.sum([np.outer(shift, shift) for shift in alone], axis=0)
    if problem.friction_covariance is not None:
        spreads = np.array([problem.inputs[name].spread for name in friction])
        slopes = np.column_stack([moved[name] for name in friction]) / spreads
        covariance = covariance + slopes @ np.asarray(problem.friction_covariance) @ slopes.T
    return np.asarray(covariance)

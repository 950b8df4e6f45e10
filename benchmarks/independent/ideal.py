"""The least uncertainty of k_D: generalized least squares that knows the noise and that drift is a line.

    reading = z + r·t + h(t; k, inputs) + noise,     anchor = h_m(k, inputs) + error,     inputs = stated + errors

with z and r unknown, the noise's covariance known, everything linear about the truth. The reading enters as block
means. The variance of ln k is that of the inverse information matrix (JCGM 100:2008, H.3 in matrix form).
"""

from collections.abc import Callable

import numpy as np

from independent.noise import Column
from independent.regimes import UNCERTAIN, Regime
from independent.runs import anchor_spread, course

_BLOCKS = 200
_STEP = 1e-3


def ideal_spread(regime: Regime) -> float:
    """Return the relative standard uncertainty of k_D that an ideal estimator has."""
    disc, disc_spread = regime.disc_wear or (0.0, 0.0)
    blocks = min(_BLOCKS, regime.samples)
    size = regime.samples // blocks
    time = _means(np.arange(regime.samples) / regime.rate, blocks)
    inputs = ["k", *UNCERTAIN, *(["disc"] if disc else [])]

    def model(moved: str, step: float) -> Column:
        off = {moved: step}
        worn = course(regime, off, regime.coefficient * (1 + off.get("k", 0)), disc * (1 + off.get("disc", 0)))
        return np.append(_means(worn.shown, blocks), worn.anchor)

    slopes = np.column_stack([_slope(model, name) for name in inputs])
    lines = np.vstack([np.column_stack([np.ones(blocks), time / time[-1]]), np.zeros(2)])
    design = np.hstack([slopes, lines])
    noise = sum((one.covariance(size * blocks, 1 / regime.rate, blocks) for one in regime.noise), np.zeros(()))
    curve, anchor = design[:-1], design[-1:]
    information = curve.T @ np.linalg.solve(noise, curve)
    information += anchor.T @ anchor / anchor_spread(regime, model("k", 0.0)[-1]) ** 2
    known = dict(UNCERTAIN) | ({"disc": disc_spread / disc} if disc else {})
    information += np.diag([known[name] ** -2 if name in known else 0.0 for name in inputs] + [0.0, 0.0])
    return float(np.sqrt(_inverse(information)[0, 0]))


def _slope(model: Callable[[str, float], Column], name: str) -> Column:
    return np.asarray((model(name, _STEP) - model(name, -_STEP)) / (2 * _STEP))


def _means(values: Column, blocks: int) -> Column:
    size = len(values) // blocks
    return np.asarray(values[: blocks * size].reshape(blocks, size).mean(axis=1))


def _inverse(information: Column) -> Column:
    """Invert after scaling: offsets are micrometres and errors are shares."""
    scale = np.sqrt(np.diag(information))
    return np.asarray(np.linalg.inv(information / np.outer(scale, scale)) / np.outer(scale, scale))

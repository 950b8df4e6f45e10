"""The definitions of the friction coefficient of a reciprocating test, side by side."""

import numpy as np

from tribopipe.base.arrays import Column, Numbers
from tribopipe.documents.preprocessing import StrokeMethod, StrokeWiseFriction, UnloadedFriction
from tribopipe.documents.quantity import Quantity
from tribopipe.evaluation.derived_columns import coefficient
from tribopipe.evaluation.preprocessing.strokes import Parts, Stroke, stroke_values, whole_strokes
from tribopipe.results.evaluation import StrokeFriction
from tribopipe.results.run import RawRun

_MIDDLE: float = StrokeWiseFriction.model_fields["middle"].default
_MOST = 0.5
"""Share of the strokes whose coefficient must be that of a definition, and of samples at which distance must grow."""
_METHODS: tuple[StrokeMethod, ...] = ("half-difference", "middle-of-stroke")


def stroke_friction(run: RawRun) -> StrokeFriction | None:
    """Return the friction coefficient of a run by each definition; None without a signed force or whole strokes.

    Parameters
    ----------
    run
        A run after preprocessing: its friction force has its sign, its coefficient may be given stroke by stroke.

    Returns
    -------
    StrokeFriction or None
        Means over the whole strokes, by the middle half of each where a definition takes the middle.
    """
    if run.manifest.conditions.stroke is None or "friction_force" not in run.columns:
        return None
    signed = _under_load(run)
    mu = run.columns.get("friction_coefficient", signed)
    whole = whole_strokes(signed, any_offset=True)
    values = {
        method: {one: value for one, value in stroke_values(signed, whole, _MIDDLE, method) if np.isfinite(value)}
        for method in _METHODS
    }
    if not values["half-difference"]:
        return None
    paired = [*values["half-difference"]]
    whole_parts, directions = Parts([one.whole for one in paired]), np.array([one.direction for one in paired])
    friction = signed[whole_parts.sample]
    peaks = np.full(len(paired), -np.inf)
    np.fmax.at(peaks, whole_parts.part, np.abs(friction))
    return StrokeFriction(
        used=next((method for method in _METHODS if _given_by(mu, values[method])), None),
        half_difference=_ratio(np.array([*values["half-difference"].values()])),
        middle_of_stroke=_ratio(np.array([*values["middle-of-stroke"].values()])),
        loop_energy=_ratio(directions * _over_distance(run, signed, whole_parts)),
        root_mean_square=_ratio(np.sqrt(np.nanmean(friction**2))),
        peak=_ratio(peaks),
        offset=_ratio(Parts([one.middle(_MIDDLE) for one in paired]).means(signed)),
    )


def _over_distance(run: RawRun, signed: Column, strokes: Parts) -> Column:
    """Return the mean friction coefficient of each stroke over the sliding distance, ∫μ dx/∫dx.

    Over time where the distance is too coarse for that: at most samples, or during a whole stroke, it does not grow.
    """
    slid = np.gradient(run.sliding_distance)
    fine = np.mean(slid[strokes.sample] > 0) > _MOST and np.all(strokes.means(slid) > 0)
    weights = np.where(np.isfinite(signed), slid if fine else 1.0, np.nan)
    return np.asarray(strokes.means(signed * weights) / strokes.means(weights))


def _under_load(run: RawRun) -> Column:
    """Return the signed friction coefficient where the bodies are pressed together, otherwise NaN."""
    signed = coefficient({**run.columns}, run.manifest)[0]
    load = run.columns.get("normal_force")
    least = UnloadedFriction.model_fields["share"].default * run.manifest.conditions.normal_load.value
    return signed if load is None else np.where(load >= least, signed, np.nan)


def _ratio(values: Numbers) -> Quantity:
    return Quantity(value=float(np.mean(values)), unit="1")


def _given_by(mu: Column, values: dict[Stroke, float]) -> bool:
    """Return whether the coefficient of most strokes is that of a definition."""
    parts, own = Parts([one.whole for one in values]), np.array([*values.values()])
    taken = mu[parts.sample]
    other = np.isfinite(taken) & ~np.isclose(taken, own[parts.part], rtol=1e-12)
    differing = np.unique(parts.part[other])
    return bool(1 - len(differing) / parts.count > _MOST and np.any(np.isfinite(mu)))

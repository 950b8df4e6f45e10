"""Normal load and friction coefficient along a run: as recorded, else as fitted or as run.toml states them.

Where the load that is applied rests on several contacts, as in a four-ball test, each takes its share.

Wear is proportional to ∫F_N ds, so a recorded load counts by its mean over the sliding distance. How far its
calibration may be off, nobody but the lab knows: it is taken to be as uncertain, relatively, as the nominal load is
stated to be.
"""

import math

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.documents.manifest import StatedFriction
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import DefaultUncertainty, FrictionSource, Recipe
from tribopipe.physics.friction_path import ExponentialFriction, FrictionPath, MeasuredFriction
from tribopipe.physics.load_course import LoadCourse
from tribopipe.results.evaluation import FrictionFit
from tribopipe.results.run import RawRun

_STEADY = 0.005
"""Share of the load path by which it may differ from that of a constant load, as that of a noisy channel does."""
_STRETCHES = 200
"""Of the sliding distance, over each of which a load that changes counts as constant."""


def load_share(run: RawRun, defaults: DefaultUncertainty) -> float:
    """Return the relative standard uncertainty of a run's load by its calibration, stated or by default."""
    stated = run.manifest.conditions.normal_load
    if stated.standard_uncertainty is None:
        return defaults.normal_load
    return stated.standard_uncertainty / stated.value


def load_path(run: RawRun, distances: Column) -> Column:
    """Return ∫F_N ds of one contact until these sliding distances, N·m: by the recorded load, else the nominal one."""
    share = 1.0 if run.manifest.contact is None else run.manifest.contact.load_share
    force, slid = run.columns.get("normal_force"), run.columns["sliding_distance"]
    if force is None or run.recorded_load is None:
        return share * run.manifest.conditions.normal_load.value * distances
    seen = np.isfinite(force) & np.isfinite(slid)
    force, slid = force[seen], slid[seen]
    # The first sample stands for what was slid before it, the last for what was slid after it.
    end = np.max(distances, initial=slid[-1])
    force, slid = np.concatenate([force[:1], force, force[-1:]]), np.concatenate([[0.0], slid, [end]])
    path = np.append(0.0, np.cumsum((force[1:] + force[:-1]) / 2 * np.diff(slid)))
    return np.asarray(share * np.interp(distances, slid, path))


def load_course(run: RawRun, per_progress: float = 1.0) -> LoadCourse | None:
    """Return how the recorded load changes along the sliding distance; None where it counts as constant.

    ``per_progress`` is the sliding distance in a unit of progress, such as a rotation of two discs, m.
    """
    if run.recorded_load is None:
        return None
    distance = np.linspace(0.0, float(np.nanmax(run.columns["sliding_distance"])), _STRETCHES + 1)
    # Without contact the channel reads noise about zero, or a little less: no wear is undone.
    path = np.maximum.accumulate(load_path(run, distance))
    if not path[-1] > 0:
        return None
    path = path * (distance[-1] / path[-1])
    if np.max(np.abs(path - distance)) <= _STEADY * distance[-1]:
        return None
    scale = per_progress * float(np.nanmax(run.progress)) / distance[-1]
    return LoadCourse(scale * distance, scale * path)


def contact_load(run: RawRun, recipe: Recipe) -> Quantity:
    """Return the load on one contact for the evaluation of wear, N, as ``applied_load`` of a run with bodies."""
    return run.manifest.described.pressed_by(applied_load(run, recipe))


def applied_load(run: RawRun, recipe: Recipe) -> Quantity:
    """Return the load that is applied, N: recorded, else nominal.

    Parameters
    ----------
    run
        A run after preprocessing, which leaves out a load channel that recorded nothing.
    recipe
        Where run.toml states no uncertainty of the load, that of ``recipe.uncertainty.normal_load`` counts.

    Returns
    -------
    Quantity
        The recorded load: its mean over the sliding distance, N, uncertain by calibration and noise. The nominal load:
        as run.toml states it, without an uncertainty where none is stated.

    """
    recorded = run.recorded_load
    if recorded is None:
        return run.manifest.conditions.normal_load
    calibration = load_share(run, recipe.uncertainty) * recorded.value
    spread = math.hypot(calibration, recorded.u_or_zero)
    return Quantity(value=recorded.value, unit="N", standard_uncertainty=spread)


def stated_path(friction: StatedFriction) -> ExponentialFriction:
    """Return μ(s) by stated parameters of Eq. 7."""
    return ExponentialFriction(
        friction.amplitude.value, friction.steady_state.value, friction.running_in_distance.value
    )


def fitted_path(fit: FrictionFit | None) -> FrictionPath | None:
    """Return μ(s) as fitted: Eq. 7, or the steady value where that is all there is; none without friction."""
    if fit is None or fit.steady_state is None:
        return None
    divided = fit.load_uncertainty is not None
    if fit.amplitude is None or fit.running_in_distance is None:
        return ExponentialFriction(0.0, fit.steady_state.value, divided_by_load=divided)
    return ExponentialFriction(
        fit.amplitude.value, fit.steady_state.value, fit.running_in_distance.value, divided_by_load=divided
    )


def measured_path(run: RawRun) -> FrictionPath | None:
    """Return μ(s) as recorded, missing samples left out; none without friction."""
    mu = run.columns.get("friction_coefficient")
    if mu is None or not np.any(np.isfinite(mu)):
        return None
    seen = np.isfinite(mu)
    return MeasuredFriction(run.sliding_distance[seen], mu[seen])


def run_path(run: RawRun, fit: FrictionFit | None, source: FrictionSource) -> FrictionPath | None:
    """Return μ(s) of a run from where the recipe wants it; as measured where Eq. 7 was not identified."""
    if source == "measured" or fit is None or fit.outcome != "exponential":
        return measured_path(run)
    return fitted_path(fit)

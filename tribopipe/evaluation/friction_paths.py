"""The friction coefficient along a run: as stated, as fitted, or as recorded."""

import numpy as np

from tribopipe.documents.manifest import StatedFriction
from tribopipe.documents.recipe import FrictionSource
from tribopipe.physics.friction_path import ExponentialFriction, FrictionPath, MeasuredFriction
from tribopipe.results.evaluation import FrictionFit
from tribopipe.results.run import RawRun


def stated_path(friction: StatedFriction) -> FrictionPath:
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

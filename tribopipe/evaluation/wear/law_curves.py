"""A law along a run: the fitted or predicted wear at each sample, with its 95 % band."""

from dataclasses import dataclass, replace

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.evaluation.applied_load import applied_load
from tribopipe.evaluation.friction_paths import run_path
from tribopipe.evaluation.wear.known import KnownWear, known_wear
from tribopipe.evaluation.wear.predict import WearScenario
from tribopipe.results.evaluation import COVERAGE_FACTOR, FrictionFit
from tribopipe.results.run import RawRun
from tribopipe.results.wear_fit import WearFit
from tribopipe.results.wear_prediction import WearPrediction


@dataclass(frozen=True)
class LawCurve:
    """Wear depth of the pin along a run by a law, m."""

    result: WearFit | WearPrediction
    wear_depth: Column
    lower: Column
    upper: Column


def run_scenario(
    run: RawRun, law: LawName, known: KnownWear, friction: FrictionFit | None, recipe: Recipe
) -> WearScenario:
    """Return the scenario of a run's own contact, load and friction under a known k_D."""
    conditions = run.manifest.conditions
    path = run_path(run, friction, recipe.wear.friction)
    return WearScenario(
        run.manifest.pin_on_disc,
        applied_load(run, recipe),
        known.first,
        law,
        path,
        recipe,
        conditions.nominal_speed,
        known.engine,
        known.parameters,
        known.covariance,
    )


def fitted_curve(
    run: RawRun, fit: WearFit, friction: FrictionFit | None = None, recipe: Recipe | None = None
) -> LawCurve | None:
    """Return the fitted law along its run, with the band of what was fitted; none where nothing was."""
    known, pin = known_wear(fit), fit.first
    if known is None or pin is None or pin.fitted_end_depth is None:
        return None
    scenario = run_scenario(run, fit.model, known, friction, recipe or Recipe())
    if known.covariance is not None:
        return _band(fit, scenario.worn(run.sliding_distance).depth, scenario.fitted_uncertainty(run.sliding_distance))
    # On a disc that wears, a pin loses more volume at the same depth: the curve ends on the fitted one.
    share = _volume_share(scenario, run, pin.fitted_end_depth.value)
    depth, lower, upper = (
        replace(scenario, wear_coefficient=k.model_copy(update={"value": share * k.value}))
        .worn(run.sliding_distance)
        .depth
        for k in (known.first, *pin.interval)
    )
    return LawCurve(fit, depth, lower, upper)


def _volume_share(scenario: WearScenario, run: RawRun, depth: float) -> float:
    """Return the volume of the pin at its depth at the end over that worn, k_D·F_N·S."""
    pin = scenario.pin(scenario.values)
    end = np.asarray([np.nanmax(run.sliding_distance)])
    worn = float(np.asarray(pin.volume(scenario.worn(end).depth))[0])
    return float(np.asarray(pin.volume(depth))) / worn if worn > 0 else 1.0


def predicted_curve(run: RawRun, scenario: WearScenario, prediction: WearPrediction) -> LawCurve:
    """Return a prediction along the run it is made for; the band is that of k_D, load, tip radius and moduli."""
    distance = run.sliding_distance
    return _band(prediction, scenario.worn(distance).depth, scenario.depth_uncertainty(distance))


def _band(result: WearFit | WearPrediction, depth: Column, uncertainty: Column) -> LawCurve:
    half_width = COVERAGE_FACTOR * uncertainty
    return LawCurve(result, depth, np.maximum(depth - half_width, 0.0), depth + half_width)

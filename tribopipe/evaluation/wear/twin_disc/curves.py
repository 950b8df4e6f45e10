"""A law along a twin-disc run: the wear of both discs and their contact at each sample, with 95 % bands."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.documents.slip import slip
from tribopipe.evaluation.applied_load import applied_load
from tribopipe.evaluation.friction_paths import run_path
from tribopipe.evaluation.wear.known import KnownWear, known_wear
from tribopipe.evaluation.wear.twin_disc.predict import COEFFICIENTS, DiscScenario
from tribopipe.results.evaluation import COVERAGE_FACTOR, FrictionFit
from tribopipe.results.run import RawRun
from tribopipe.results.wear_fit import WearFit
from tribopipe.results.wear_prediction import OUTCOMES, Outcome, WearPrediction

_MOST_PLACES = 600
"""At so many places the law is evaluated; samples between lie on straight lines."""


@dataclass(frozen=True)
class DiscBand:
    """A value at each sample, and its 95 % band."""

    best: Column
    lower: Column
    upper: Column


@dataclass(frozen=True)
class DiscCurves:
    """Two discs along a run by a law."""

    result: WearFit | WearPrediction
    bands: Mapping[Outcome, DiscBand]


def disc_scenario(
    run: RawRun,
    law: LawName,
    known: KnownWear,
    friction: FrictionFit | None,
    recipe: Recipe,
) -> DiscScenario:
    """Return the scenario of a run's own contact, load, slip and friction under known k₁ and k₂."""
    conditions = run.manifest.conditions
    return DiscScenario(
        contact=run.manifest.twin_disc,
        normal_load=applied_load(run, recipe),
        slip=slip(run.manifest),
        known=known,
        model=law,
        friction=run_path(run, friction, recipe.wear.friction),
        recipe=recipe,
        curved_disc_speed=conditions.curved_disc_speed,
    )


def fitted_discs(
    run: RawRun, fit: WearFit, friction: FrictionFit | None = None, recipe: Recipe | None = None
) -> DiscCurves | None:
    """Return the fitted law along its run; the bands are those of k₁ and k₂. None where nothing was fitted."""
    known = known_wear(fit)
    if known is None:
        return None
    scenario = disc_scenario(run, fit.model, known, friction, recipe or Recipe())
    return DiscCurves(fit, _bands(run, scenario, COEFFICIENTS))


def predicted_discs(run: RawRun, scenario: DiscScenario, prediction: WearPrediction) -> DiscCurves:
    """Return a prediction along the run it is made for; the bands are those of all its inputs."""
    return DiscCurves(prediction, _bands(run, scenario, None))


def _bands(run: RawRun, scenario: DiscScenario, of: tuple[str, ...] | None) -> dict[Outcome, DiscBand]:
    rotations = np.maximum(run.columns["rotations"], 0.0)
    last = float(np.nanmax(rotations))
    places = np.unique(np.concatenate([np.linspace(0.0, 1.0, _MOST_PLACES // 2) ** power for power in (1, 3)])) * last
    worn, spreads = scenario.worn(places), scenario.uncertainties(places, of)
    found: dict[Outcome, DiscBand] = {}
    for name in OUTCOMES:
        best = worn.curved_depth + worn.flat_depth if name == "depth" else getattr(worn, name)
        half = COVERAGE_FACTOR * spreads[name]
        lines = (best, np.maximum(best - half, 0.0), best + half)
        found[name] = DiscBand(*(np.interp(rotations, places, line) for line in lines))
    return found

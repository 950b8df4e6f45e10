"""A law along a run: fitted or predicted wear at each sample, with its 95 % band, for any contact."""

from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.documents.slip import stated_slip
from tribopipe.evaluation.applied_load import applied_load
from tribopipe.evaluation.friction_paths import run_path
from tribopipe.evaluation.wear.known import KnownWear, known_wear
from tribopipe.evaluation.wear.scenario import Scenario
from tribopipe.physics.friction_path import FrictionPath
from tribopipe.results.evaluation import FrictionFit
from tribopipe.results.run import RawRun
from tribopipe.results.wear_curves import WearCurves
from tribopipe.results.wear_fit import WearFit
from tribopipe.results.wear_prediction import WearPrediction


def wear_scenario(
    manifest: RunManifest,
    known: KnownWear,
    law: LawName = "archard",
    friction: FrictionPath | None = None,
    recipe: Recipe | None = None,
    normal_load: Quantity | None = None,
) -> Scenario:
    """Return what run.toml states as a scenario, whatever its contact, under a law and a known k_D.

    Parameters
    ----------
    manifest
        What run.toml states: bodies, load, slip and speed.
    known
        k_D of each body, m²/N.
    law
        Name of the wear law.
    friction
        μ along the test, for laws that need it.
    recipe
        Default uncertainties and given parameters of laws.
    normal_load
        Another load than that of run.toml, N, such as the one that was recorded.

    Raises
    ------
    ContactError
        Where run.toml does not describe the bodies.
    """
    load = normal_load or manifest.conditions.normal_load
    speed, slip = manifest.nominal_speed, stated_slip(manifest)
    path = manifest.path
    return Scenario(manifest.described, load, known, law, friction, recipe or Recipe(), speed, slip, path)


def run_scenario(run: RawRun, law: LawName, known: KnownWear, friction: FrictionFit | None, recipe: Recipe) -> Scenario:
    """Return the scenario of a run's own contact, load and friction under a known k_D."""
    path = run_path(run, friction, recipe.wear.friction)
    return wear_scenario(run.manifest, known, law, path, recipe, applied_load(run, recipe))


def fitted_curves(
    run: RawRun, fit: WearFit, friction: FrictionFit | None = None, recipe: Recipe | None = None
) -> WearCurves | None:
    """Return the fitted law along its run, with bands of what was fitted; none where nothing was, or along no run."""
    known = known_wear(fit)
    if known is None or not _along(fit):
        return None
    scenario = run_scenario(run, fit.model, known, friction, recipe or Recipe())
    return WearCurves(fit, scenario.fitted_bands(run, fit))


def _along(fit: WearFit) -> bool:
    """Whether wear was fitted along the run, rather than k_D found by a lost volume."""
    return bool(fit.measurements) or any(body.fitted_end_depth is not None for body in fit.bodies.values())


def predicted_curves(run: RawRun, scenario: Scenario, prediction: WearPrediction) -> WearCurves:
    """Return a prediction along the run it is made for; the bands are those of all its inputs."""
    return WearCurves(prediction, scenario.bands(run))

"""Wear from a known k_D for any contact: along a run, at other loads, distances and geometries.

`wear_scenario` makes the scenario of what run.toml states, `predict_wear` predicts it; `fitted_curves` and
`predicted_curves` give a law at each sample of a run with its 95 % band.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError, FitError
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.manifest import RunManifest, StatedFriction
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.evaluation.load_and_friction import applied_load, load_course, run_path, stated_path
from tribopipe.evaluation.wear.coating import coating_notes
from tribopipe.evaluation.wear.inputs import default_notes, friction_inputs, given_parameters
from tribopipe.evaluation.wear.scenario import KnownWear, Scenario, known_wear
from tribopipe.physics.friction_path import FrictionPath
from tribopipe.results.evaluation import FrictionFit
from tribopipe.results.finding import reworded
from tribopipe.results.input_quantities import Input
from tribopipe.results.run import RawRun
from tribopipe.results.wear_fit import LawValue, WearFit
from tribopipe.results.wear_prediction import PredictedPoint, UsedCoefficient, WearCurves, WearPrediction


def wear_scenario(
    manifest: RunManifest,
    known: KnownWear,
    law: LawName = "archard",
    friction: FrictionPath | StatedFriction | None = None,
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
        μ along the test, for laws that need it; as stated, with its uncertainties.
    recipe
        Default uncertainties and given parameters of laws.
    normal_load
        Another load than that of run.toml, N, such as the one that was recorded.

    Raises
    ------
    ContactError
        Where run.toml does not describe the bodies, or they do not wear each other under its conditions, which may be
        other ones than were read.
    """
    try:
        manifest.described.refuse_conditions(manifest.conditions)
    except ValueError as error:
        raise ContactError(f"{manifest.id}: {error}") from None
    load = normal_load or manifest.conditions.normal_load
    recipe = recipe or Recipe()
    speed, slip = manifest.nominal_speed, manifest.slip_with(recipe.uncertainty.slip)
    path, stroke = manifest.path, manifest.conditions.stroke is not None
    uncertain: dict[str, Input] = {}
    if isinstance(friction, StatedFriction):
        uncertain, friction = friction_inputs(friction), stated_path(friction)
    return Scenario(manifest.described, load, known, law, friction, recipe, speed, slip, path, stroke, uncertain)


def run_scenario(run: RawRun, law: LawName, known: KnownWear, friction: FrictionFit | None, recipe: Recipe) -> Scenario:
    """Return the scenario of a run's own contact, load and friction under a known k_D.

    Of a pin on a track of unknown length only the wear of the pin is predicted.
    """
    path, manifest = run_path(run, friction, recipe.wear.friction), run.manifest
    # Two discs roll, so that no length of a track is missing.
    known = known if manifest.pin is None else known.along(manifest.path, manifest.described.fitted_bodies)
    scenario = wear_scenario(manifest, known, law, path, recipe, applied_load(run, recipe))
    return replace(scenario, load=load_course(run, scenario.wear.slid))


def fitted_curves(
    run: RawRun, fit: WearFit, friction: FrictionFit | None = None, recipe: Recipe | None = None
) -> WearCurves | None:
    """Return the fitted law along its run, with bands of what was fitted; None if nothing was, or along no run."""
    known = known_wear(fit)
    if known is None or not _along(fit):
        return None
    scenario = run_scenario(run, fit.model, known, friction, recipe or Recipe())
    return WearCurves(fit, scenario.fitted_bands(run, fit))


def _along(fit: WearFit) -> bool:
    """Return whether wear was fitted along the run, rather than k_D found from a wear volume."""
    return bool(fit.measurements) or any(body.fitted_end_depth is not None for body in fit.bodies.values())


def predicted_curves(run: RawRun, scenario: Scenario, prediction: WearPrediction) -> WearCurves:
    """Return a prediction along the run it is made for; the bands are those of all its inputs."""
    return WearCurves(prediction, scenario.bands(run))


_NOTABLE_STEP_ERROR = 1e-3
_FAR_LOAD = 5.0
"""Ratio of loads beyond which a prediction is an extrapolation; the paper predicts up to four times the load."""


def predict_wear(
    scenario: Scenario,
    at: Sequence[float] = (),
    *,
    depths: Sequence[float] = (),
    scheme: Literal["exact", "published"] = "exact",
    steps: int | None = None,
    reference: str | None = None,
    reference_load: Quantity | None = None,
) -> WearPrediction:
    """Predict wear of a contact, and where its first body, the pin or the crowned disc, reaches given depths.

    Parameters
    ----------
    scenario
        What wear is predicted for.
    at
        Places to predict at: sliding distances, m, or rotations of the crowned disc.
    depths
        Wear depths, m, whose place is wanted; found by the exact scheme in either case.
    scheme
        The limit of small steps, or the paper's explicit Euler steps, equal ones up to the largest place.
    steps
        Number of these steps; 50 000 for a pin, one per rotation for discs, by default.
    reference
        Run that k_D was identified from.
    reference_load
        Load of that run, N.

    Returns
    -------
    WearPrediction
        Wear at each place, in the order asked for, and how far off the published scheme is.

    Raises
    ------
    ContactError
        Where a body would be worn away.
    FitError
        Where a place or depth is below zero, or a depth is never reached.
    """
    places = _checked(scenario, at, depths)
    state, error, taken = scenario.worn(places), None, None
    if scheme == "published" and places.size:
        end, last = float(places.max()), int(places.argmax())
        taken = scenario.wear.usual_steps(end) if steps is None else steps
        exact = float(scenario.first_depth(state)[last])
        state = scenario.published(places, taken)
        error = float(scenario.first_depth(state)[last]) / exact - 1 if exact else 0.0
    prediction = WearPrediction(
        model=scenario.model,
        engine=scenario.known.engine,
        scheme=scheme,
        distance_per_rotation=None if scenario.slip is None else scenario.known.distance,
        bodies={name: UsedCoefficient(wear_coefficient=found) for name, found in scenario.known.bodies.items()},
        reference=reference,
        normal_load=scenario.normal_load,
        conditions=scenario.wear.conditions,
        start=scenario.start,
        steps=taken,
        step_error=error,
        notes=(
            *_load_notes(scenario, reference_load),
            *_notes(scenario, places),
            *_step_notes(scenario, places, error, taken),
        ),
        prediction=tuple(_timed(scenario, places, scenario.points(places, state))),
        reached=tuple(_reached(scenario, depth) for depth in depths),
        parameters=_law_values(scenario),
    )
    return reworded(prediction, scenario.contact.worded)


def _checked(scenario: Scenario, at: Sequence[float], depths: Sequence[float]) -> Column:
    places = np.asarray(at, dtype=float)
    if not np.all(np.isfinite(places)) or np.any(places < 0):
        what = scenario.contact.progress.words
        raise FitError(f"prediction: found {what} {list(at)}; expected no negative values; check --at")
    if any(not depth >= 0 for depth in depths):
        raise FitError(f"prediction: found depths {list(depths)} m; expected no negative values; check --depth")
    return places


def _timed(scenario: Scenario, places: Column, points: Iterator[PredictedPoint]) -> Iterator[PredictedPoint]:
    for place, point in zip(places.tolist(), points, strict=True):
        yield point.model_copy(update={"time": _time(scenario, place)})


def _reached(scenario: Scenario, depth: float) -> PredictedPoint:
    """Report where a depth is reached; its uncertainty is that of the depth there over the wear rate."""
    place = scenario.place_at(depth)
    first = scenario.first
    if np.isinf(place):
        raise FitError(
            f"prediction: found a {spoken(first)} that does not wear; expected a positive wear coefficient, or no "
            "--depth"
        )
    at = np.asarray([place])
    (point,) = scenario.points(at, scenario.worn(at))
    worn, exact = point.bodies[first], Quantity(value=depth, unit="m")
    spread = worn.wear_depth.u_or_zero / float(scenario.rate(at)[0])
    progress = scenario.contact.progress
    there: Quantity = getattr(point, progress.signal)
    return point.model_copy(
        update={
            progress.signal: there.model_copy(update={"standard_uncertainty": spread}),
            "time": _time(scenario, place, spread),
            "contact": point.contact if len(point.bodies) > 1 else point.contact.model_copy(update={"approach": exact}),
            "bodies": point.bodies | {first: worn.model_copy(update={"wear_depth": exact})},
        }
    )


def _time(scenario: Scenario, place: float, spread: float | None = None) -> Quantity | None:
    if scenario.speed is None:
        return None
    one = scenario.contact.travel / scenario.speed.value
    return Quantity(value=place * one, unit="s", standard_uncertainty=None if spread is None else spread * one)


def _law_values(scenario: Scenario) -> tuple[LawValue, ...] | None:
    """Return the parameters of the law that a prediction was made with; None if it has none."""
    fitted = {one.name for one in scenario.known.parameters}
    given = given_parameters(scenario.law, scenario.recipe).items()
    stated = (LawValue(name=name, value=value, source="recipe") for name, value in given if name not in fitted)
    return (*scenario.known.parameters, *stated) or None


def _load_notes(scenario: Scenario, known: Quantity | None) -> Iterator[str]:
    ratio = 1.0 if known is None else scenario.normal_load.value / known.value
    if not 1 / _FAR_LOAD <= ratio <= _FAR_LOAD:
        yield (
            f"extrapolation: the load is {ratio:.2g} times that of the test from which k_D was determined; the "
            "uncertainty does not account for a change in wear mechanism"
        )


def _notes(scenario: Scenario, places: Column) -> Iterator[str]:
    if scenario.known.first.standard_uncertainty is None:
        yield "k_D is assumed to be exact, since its standard uncertainty is unknown"
    for name in scenario.wear.bodies:
        if name not in scenario.known.bodies:
            yield f"the {spoken(name)} is assumed to be unworn, since it has no positive k_D"
    for name, known in scenario.known.bodies.items():
        if known.value < 0:
            yield f"k_D of the {spoken(name)} is negative; it is assumed to be 0, with the same standard uncertainty"
    for name in scenario.known.left_out:
        yield (
            f"track_radius or stroke is missing, so the wear of the {spoken(name)} is not predicted; the wear depth of "
            f"the {spoken(scenario.first)} is that on a counterbody that does not wear"
        )
    yield from scenario.notes(places)
    if places.size:
        yield from coating_notes(scenario, float(places.max()))
    yield from default_notes(scenario.inputs)


def _step_notes(scenario: Scenario, places: Column, error: float | None, steps: int | None) -> Iterator[str]:
    if error is None or steps is None or abs(error) < _NOTABLE_STEP_ERROR:
        return
    side, step = "large" if error > 0 else "small", float(places.max()) / steps
    yield (
        f"with {steps:,} Euler steps of {step:.3g} {scenario.contact.progress.unit}, the final depth is "
        f"{100 * abs(error):.2f} % too {side}; the exact scheme does not have this error"
    )

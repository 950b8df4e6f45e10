"""Everything uncertain that wear depends on: each input with its standard uncertainty and who stated it.

Parameters of a wear law in addition to k_D, as a recipe or a plan gives them, are inputs like any other.
"""

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.random import Generator

from tribopipe.base.arrays import Column, Numbers, Values
from tribopipe.base.errors import FitError, did_you_mean
from tribopipe.base.units import show
from tribopipe.contacts.kinds import Terms, wear_of
from tribopipe.documents.manifest import StatedFriction
from tribopipe.documents.quantity import Quantity, read_quantity
from tribopipe.documents.recipe import FrictionSource, GivenParameter, LawName, Recipe
from tribopipe.evaluation.load_and_friction import contact_load, run_path
from tribopipe.evaluation.measurements.sliding_distance import told_by
from tribopipe.physics.friction_path import ExponentialFriction, FrictionPath
from tribopipe.physics.laws import WearLaw, law_named
from tribopipe.results.evaluation import FrictionFit
from tribopipe.results.input_quantities import Input, Inputs, input_label, relative_input, shown_unit
from tribopipe.results.run import RawRun

FrictionCovariance = tuple[tuple[float, ...], ...] | None
"""Covariance of A, b and c, which are far from independent; None if friction is not from Eq. 7."""


def given_parameters(law: WearLaw, recipe: Recipe) -> dict[str, Quantity]:
    """Return the parameters that a recipe gives of a law. Raises ``FitError`` where it cannot have them."""
    return read_parameters(law, recipe.wear.parameters.get(law.name, {}), f"wear.parameters.{law.name}")


def read_parameters(law: WearLaw, written: Mapping[str, GivenParameter], where: str) -> dict[str, Quantity]:
    """Return parameters as they are written at a place. Raises ``FitError`` where a law cannot have them."""
    return {name: _read(law, name, said, f"{where}.{name}") for name, said in written.items()}


def _read(law: WearLaw, name: str, said: GivenParameter, where: str) -> Quantity:
    known = law.parameters()
    if name not in known:
        raise FitError(f"{where}: found a parameter that {law.title} does not have; {did_you_mean(name, known)}")
    try:
        quantity = read_quantity(said, known[name].kind)
    except ValueError as error:
        raise FitError(f"{where}: {error}") from None
    low, high = known[name].low, known[name].high
    if not low <= quantity.value <= high:
        ends = " to ".join(show(end, None, quantity.unit) for end in (low, high))
        raise FitError(f"{where}: found {quantity}; expected {ends}; correct it")
    return quantity


def law_as_given(name: LawName, recipe: Recipe) -> WearLaw:
    """Return a law with its parameters as a recipe gives them.

    Raises ``FitError`` where the law is not installed here, or has a parameter that is not given.
    """
    law = law_named(name)
    return law_with(law, given_parameters(law, recipe))


def law_with(law: WearLaw, given: Mapping[str, Quantity], place: str | None = None) -> WearLaw:
    """Return a law with parameters. Raises ``FitError`` where one is missing, saying where it belongs."""
    values = {law.input_of(name): quantity.value for name, quantity in given.items()}
    require_all(law, values, place)
    return law.at(values)


def require_all(law: WearLaw, values: Mapping[str, float], place: str | None = None) -> None:
    """Raise ``FitError`` where a parameter of a law is not among the values of inputs.

    It states where they belong: in a recipe, unless stated otherwise.
    """
    if missing := [parameter for parameter in law.parameters() if law.input_of(parameter) not in values]:
        raise FitError(
            f"{law.title}: found no {' or '.join(missing)}; expected values, since only the fit to a "
            f"single pin identifies them; state them under {place or f'[wear.parameters.{law.name}] in a recipe'}"
        )


def indistinct(law: WearLaw, names: Sequence[str]) -> str:
    """Report that a run does not separate k_D from the parameters of its law."""
    return (
        f"wear fit: found a depth signal from which k_D and {' and '.join(names)} of {law.title} cannot be "
        "determined together; expected a signal on which each has a different effect; state some of them under "
        f"[wear.parameters.{law.name}] in a recipe, or fit another law"
    )


FRICTION_INPUTS = ("friction_amplitude", "friction_steady_state", "running_in_distance")
"""A, b and c of Eq. 7, in the order of their covariance."""
CONTACT_INPUTS = ("normal_load", "pin_radius", "pin_modulus", "disc_modulus")
DISTANCE_INPUTS = ("sliding_speed", "track_radius", "stroke")
"""Inputs of a derived sliding distance; the one that it is derived from is used."""
PIN_SHARED = (*CONTACT_INPUTS, *DISTANCE_INPUTS, "depth_scale")
"""Inputs of pins that may be off by the same in several runs."""
DISC_INPUTS = (
    "normal_load",
    "crown_radius",
    "curved_radius",
    "flat_radius",
    "curved_modulus",
    "flat_modulus",
)
"""Inputs of a twin-disc test, including slip."""


def load_input(run: RawRun, recipe: Recipe) -> Input:
    """Return the load on one contact, recorded or nominal, and who stated how far its calibration may be off."""
    stated = run.manifest.conditions.normal_load.standard_uncertainty is not None
    load = relative_input(contact_load(run, recipe), recipe.uncertainty.normal_load)
    return Input(load.quantity, "manifest" if stated else "default", above_zero=True)


def contact_inputs(run: RawRun, recipe: Recipe) -> dict[str, Input]:
    """Collect load, geometry, moduli and slip of a run, the load as it was recorded."""
    load, manifest = load_input(run, recipe), run.manifest
    wear = wear_of(manifest.described, Terms(manifest.slip_with(recipe.uncertainty.slip)))
    return wear.inputs(load.quantity, recipe) | {"normal_load": load}


def instrument_inputs(run: RawRun, recipe: Recipe) -> dict[str, Input]:
    """Collect the sensor's scale, and the speed, track radius or stroke that sliding distance was derived from."""
    scale = relative_input(run.manifest.depth_scale, recipe.uncertainty.depth_scale)
    return {"depth_scale": scale} | distance_inputs(run, recipe)


def distance_inputs(run: RawRun, recipe: Recipe) -> dict[str, Input]:
    """Collect the speed, track radius or stroke that sliding distance was derived from."""
    told = told_by(run, recipe.uncertainty)
    return {} if told is None else {told.name: told.given}


def distance_scale(values: Values, best: Values) -> Numbers:
    """Return by how much sliding distances are longer than by the best estimates of what they were derived from."""
    return next((values[name] / best[name] for name in DISTANCE_INPUTS if name in values), 1.0)


def friction_inputs(friction: FrictionFit | StatedFriction) -> dict[str, Input]:
    """Collect A, b and c as fitted or stated."""
    known = (friction.amplitude, friction.steady_state, friction.running_in_distance)
    fitted = isinstance(friction, FrictionFit)
    return {
        name: Input(quantity, "fit" if fitted else "manifest")
        for name, quantity in zip(FRICTION_INPUTS, known, strict=True)
        if quantity is not None
    }


def law_inputs(law: WearLaw, recipe: Recipe) -> dict[str, Input]:
    """Collect the parameters of a law that a recipe gives."""
    return {law.input_of(name): Input(given, "recipe") for name, given in given_parameters(law, recipe).items()}


class LawFriction(NamedTuple):
    """Friction as a wear law uses it; empty if the law does not depend on friction."""

    path: FrictionPath | None = None
    inputs: Mapping[str, Input] = MappingProxyType({})
    """A, b and c, where the path is Eq. 7 as fitted."""
    covariance: FrictionCovariance = None
    """Covariance of (A, b, c) at a given load; ``friction_along`` adds the effect of the load on A and b."""


def law_friction(run: RawRun, law: LawName, fit: FrictionFit | None, source: FrictionSource) -> LawFriction | None:
    """Return a run's friction as a law needs it; None if it needs some and the run has none."""
    if not law_named(law).needs_friction:
        return LawFriction()
    path = run_path(run, fit, source)
    if path is None:
        return None
    if isinstance(path, ExponentialFriction) and fit is not None:
        return LawFriction(path, friction_inputs(fit), fit.noise_covariance)
    return LawFriction(path)


def friction_along(path: FrictionPath | None, values: Values, best: Values) -> FrictionPath | None:
    """Return the friction that values of the inputs stand for: Eq. 7 by A, b and c, or the path as it is.

    The friction force is what was measured, so that A and b are lower by the share by which the load is higher than its
    best estimate, unless the instrument recorded μ itself.
    """
    if "friction_steady_state" not in values:
        return path
    divided = isinstance(path, ExponentialFriction) and path.divided_by_load
    share = best["normal_load"] / values["normal_load"] if divided else 1.0
    amplitude, steady, running_in = (values[name] for name in FRICTION_INPUTS)
    return ExponentialFriction(amplitude * share, steady * share, running_in, divided_by_load=divided)


def draw_values(
    inputs: Inputs,
    friction_covariance: FrictionCovariance,
    rng: Generator,
    count: int,
    shared: Mapping[str, Column] | None = None,
) -> dict[str, Column]:
    """Draw each input ``count`` times, as columns of shape (count, 1).

    ``shared`` gives errors in standard uncertainties for inputs that are off by the same in other runs. Inputs that
    must be above zero are drawn again where they come out below. The running-in distance is log-normal.
    """
    drawn: dict[str, Column] = {}
    for name, given in inputs.items():
        if shared is not None and name in shared:
            drawn[name] = (given.quantity.value + given.spread * shared[name])[:, None]
        elif friction_covariance is None or name not in FRICTION_INPUTS:
            drawn[name] = _normal(given, rng, count, above_zero=given.above_zero)[:, None]
    if friction_covariance is not None:
        drawn |= _draw_friction(inputs, np.asarray(friction_covariance), rng, count)
    return drawn


def _normal(given: Input, rng: Generator, count: int, *, above_zero: bool) -> Column:
    drawn = given.quantity.value + given.spread * rng.standard_normal(count)
    sign = math.copysign(1.0, given.quantity.value)
    while above_zero and np.any(low := sign * drawn <= 0):
        drawn[low] = given.quantity.value + given.spread * rng.standard_normal(np.count_nonzero(low))
    return np.asarray(drawn)


def _draw_friction(inputs: Inputs, covariance: Column, rng: Generator, count: int) -> dict[str, Column]:
    amplitude, steady, running_in = (inputs[name].quantity.value for name in FRICTION_INPUTS)
    scale = np.array([1.0, 1.0, 1.0 / running_in])
    centre = np.array([amplitude, steady, 0.0])
    drawn = rng.multivariate_normal(centre, covariance * np.outer(scale, scale), count, method="eigh")
    drawn[:, 2] = running_in * np.exp(np.clip(drawn[:, 2], -5.0, 5.0))
    return {name: drawn[:, [place]] for place, name in enumerate(FRICTION_INPUTS)}


def per_draw(values: Numbers) -> Column:
    """Drop the axis that a column of draws, (draws, 1), has for broadcasting against samples; one value stays one."""
    column = np.asarray(values, dtype=float)
    return column[..., 0] if column.ndim else column


def default_notes(inputs: Inputs) -> tuple[str, ...]:
    """Name the inputs whose uncertainty is a default, in one sentence; nothing where all were stated."""
    named = [
        f"{input_label(part)} {quantity.shown(shown_unit(part, quantity))}"
        for name, given in inputs.items()
        if given.source == "default"
        for part, quantity in given.factors or ((name, given.quantity),)
    ]
    return (f"default uncertainty used for {', '.join(named)}",) if named else ()

"""Local wear of a pin or of both bodies from a known k_D, at every point of the contact, with uniform pressure.

The amount of wear that local wear counts in (tribopipe.physics.local.contact_solvers) is k_D·S(s) of a pin, with the
law's effective distance S, m³/N, whether its counterbody wears or not, and for discs, m²/N,

    (k₁ + k₂·r₁/r₂)·N_s,    N_s = N·|slip|

with the rotations N_s of one disc against the other (Eq. 9). Both discs wear where they touch, in the ratio
k₁/r₁ : k₂/r₂, so that their sum wears as one; slip and radii are those of the unworn discs. k₁ and k₂ are Archard's,
by which V = k·F_N·s: those of the GIWM's volume-conserving way of counting.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column
from tribopipe.base.errors import FitError
from tribopipe.contacts.surfaces import economy_refused, surface_of, usual_engine, worn_bodies
from tribopipe.contacts.wear import State
from tribopipe.documents.contact import Contact
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.manifest import RunManifest, StatedFriction
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.evaluation.wear.prediction import wear_scenario
from tribopipe.evaluation.wear.scenario import KnownWear, Scenario, given_wear, known_wear
from tribopipe.physics.calculation_methods import Course, DistanceConvention, Engine
from tribopipe.physics.friction_path import FrictionPath
from tribopipe.physics.local.contact_solvers import Surface
from tribopipe.physics.local.course import STEPS_PER_DECADE, LocalWear, wear
from tribopipe.physics.local.economy import Elastic, wear_economically
from tribopipe.results.local_wear import (
    GlobalWear,
    LocalCurves,
    LocalDiscPoint,
    LocalPairPoint,
    LocalPinPoint,
    LocalWearResult,
)
from tribopipe.results.wear_fit import WearFit
from tribopipe.results.wear_prediction import PredictedBody

ARCHARDS: DistanceConvention = "volume-conserving"
"""The way of counting distance by which the k_D of discs is Archard's."""
Indices = NDArray[np.intp]
_DECADES = 5
"""Powers of ten before the last place that a course is shown over."""
_PLACES_PER_DECADE = 12
_VOLUME_INPUTS = ("wear_coefficient", "normal_load")
_DISC_OUTCOMES = ("curved_depth", "flat_depth", "curved_volume", "flat_volume")
_STABLE_SHARE = 0.5
"""Share of the longest stable increment in the scheme economy, whose pressure is one increment late."""
_ROUNDING = 1e-9
"""Relative tolerance for the length of a decade."""
_FEWEST_POINTS = 8
"""Points to the radius of a contact, with which local wear is within about one per cent."""


@dataclass(frozen=True)
class LocalOptions:
    """Numerical method of local wear."""

    engine: Engine | None = None
    """None for that which suits the tribometer: rings under a pin, a half space under discs."""
    scheme: Course = "implicit"
    steps_per_decade: int = STEPS_PER_DECADE
    """Wear steps for each power of ten; with so many, depths are off by less than the grid makes them."""
    update_mesh_every: int = 50
    """Steps after which elasticity is computed for the worn shape, where it depends on it; 0 for never."""
    stress_loss: float = 0.0
    """Share of its stresses that an increment of the economy loses."""


def default_places(end: float) -> list[float]:
    """Return the powers of ten in the five decades before an end, and the end."""
    powers = 10.0 ** np.arange(math.floor(math.log10(end)) - _DECADES, math.floor(math.log10(end)) + 1)
    return [*(power for power in powers.tolist() if end / 10**_DECADES <= power < end), end]


def local_scenario(
    manifest: RunManifest,
    coefficients: Mapping[str, Quantity],
    law: LawName = "archard",
    friction: FrictionPath | StatedFriction | None = None,
    recipe: Recipe | None = None,
) -> Scenario:
    """Return what a run is worn under: its own contact, load and slip, a law, and k_D of bodies as Archard has it.

    A body without k_D does not wear. Where both wear, the model with uniform pressure is that of the engine volume.
    Raises ``FitError`` without k_D of the first body.
    """
    first = manifest.described.body_names[0]
    if first not in coefficients:
        raise FitError(
            f"{manifest.id}: found no wear coefficient of the {spoken(first)}; expected one for each body that wears, "
            f'and that of the {spoken(first)} always; add --wear-coefficient {first}="13.5e-9 mm^3/(N*mm)"'
        )
    known = replace(given_wear(manifest.described, coefficients, Recipe()), distance=ARCHARDS)
    return wear_scenario(manifest, known, law, friction, recipe)


def wear_locally(
    scenario: Scenario,
    at: Sequence[float],
    options: LocalOptions | None = None,
    *,
    reference: str | None = None,
) -> LocalCurves:
    """Wear a pin to sliding distances, m, or two discs to rotations of the crowned one.

    ``reference`` names the run that k_D was identified from. Raises ``FitError`` where a place is not above zero, and
    ``ContactError`` past the tip or crown, where no contact is found, or explicit steps are too many.
    """
    how, along, values = options or LocalOptions(), _along(at), scenario.values
    amounts = scenario.wear.local_amount(values, scenario.effective(along))
    known, places = scenario.worn(along), np.searchsorted(along, at)
    last = {name: column[-1] for name, column in known.items()}
    surface = surface_of(scenario.contact, values, float(amounts[-1]), last, how.engine)
    course = _worn(scenario.contact, surface, amounts[1:], last, how)
    rolling, both = scenario.slip is not None, worn_bodies(surface, course, last)
    # What a pin touches is round, unless its track wears; the points of a grid in contact are those of others.
    gridded = rolling or both
    areas = np.sum((course.pressure > 0) * surface.areas, axis=(1, 2)) if gridded else np.pi * course.half_width**2
    mean, giwm = values["normal_load"] / areas, {"giwm": _global(scenario, known)}
    if rolling:
        giwm["giwm_as_printed"] = _global(scenario, _as_printed(scenario, along))
    points: Iterator[LocalPinPoint | LocalPairPoint | LocalDiscPoint]
    if both:
        points = _pair_points(scenario, places, along, course, mean, both)
    else:
        points = (_disc_points if rolling else _pin_points)(scenario, places, along, course, mean, giwm["giwm"])
    first, *second = (scenario.known.of(body) for body in scenario.wear.bodies)
    result = LocalWearResult(
        model=scenario.model,
        wear_coefficient=first,
        flat_disc_wear_coefficient=second[0] if rolling else None,
        track_wear_coefficient=second[0] if both else None,
        reference=reference,
        normal_load=scenario.normal_load,
        notes=(
            *_notes(scenario, along[-1], course.half_width[-1]),
            *_engine_notes(scenario, bool(both)),
            *_coarseness(course, along, places),
        ),
        points=tuple(points),
        **_told(how, usual_engine(scenario.contact, last), course),
    )
    track = {name: both[name] for name in ("track_depth", "track_section") if both}
    if both:
        track["giwm_track_depth"] = known["track_depth"]
    return LocalCurves(result, along, course, surface.gap, mean, giwm, track)


def _pin_points(
    scenario: Scenario, places: Indices, along: Column, course: LocalWear, mean: Column, giwm: GlobalWear
) -> Iterator[LocalPinPoint]:
    """Yield the wanted places, with the relative uncertainties that the GIWM has there."""
    shares = _shares(scenario.uncertainties(along)["wear_depth"], giwm.depth)
    of_volume = math.hypot(*(scenario.inputs[name].spread / scenario.values[name] for name in _VOLUME_INPUTS))
    for place in places.tolist():
        yield LocalPinPoint(
            sliding_distance=_quantity(along[place], "m"),
            contact_radius=_quantity(course.half_width[place], "m"),
            wear_volume=_quantity(course.volume[place], "m^3", of_volume),
            **_common(place, course, mean, giwm, shares),
        )


def _pair_points(
    scenario: Scenario, places: Indices, along: Column, course: LocalWear, mean: Column, both: State
) -> Iterator[LocalPairPoint]:
    """Yield the wanted places, with the relative uncertainties that the engine volume has there."""
    known = scenario.worn(along)
    giwm, spreads = _global(scenario, known), scenario.uncertainties(along)
    shares = {name: _shares(spreads[name], known[name]) for name in spreads}
    at = along[places]
    for place, uniform in zip(places.tolist(), scenario.points(at, scenario.worn(at)), strict=True):

        def told(name: str, unit: str = "m", place: int = place) -> Quantity:
            return _quantity(both[name][place], unit, float(shares[name][place]))

        bodies = {
            body: PredictedBody(
                **{field: told(name, getattr(uniform.bodies[body], field).unit) for field, name in named.items()}
            )
            for body, named in scenario.wear.bodies.items()
        }
        yield LocalPairPoint(
            sliding_distance=_quantity(along[place], "m"),
            half_width=told("half_width"),
            half_length=told("half_length"),
            bodies=bodies,
            uniform_pressure=uniform,
            **_common(place, course, mean, giwm, shares[scenario.wear.displacement]),
        )


def _global(scenario: Scenario, worn: State) -> GlobalWear:
    # Unworn rigid bodies touch in a point.
    pressure = np.where(worn["half_width"] > 0, worn["pressure"], np.nan)
    return GlobalWear(worn[scenario.wear.displacement], pressure, worn["half_width"], worn["half_length"])


def _as_printed(scenario: Scenario, along: Column) -> State:
    """Return the discs by Eq. 11, with the length of the contact as sliding distance in each rotation of slip."""
    printed = replace(scenario, known=replace(scenario.known, distance="contact-width"))
    turns = scenario.effective(along) * abs(scenario.values["slip"])
    return printed.wear.worn(printed.values, turns)


def _disc_points(
    scenario: Scenario, places: Indices, along: Column, course: LocalWear, mean: Column, giwm: GlobalWear
) -> Iterator[LocalDiscPoint]:
    """Yield the wanted places, with the relative uncertainties that the GIWM has there."""
    values = scenario.values
    ratio = values["curved_radius"] / values["flat_radius"]
    share = values["curved_coefficient"] / (values["curved_coefficient"] + values["flat_coefficient"] * ratio)
    known, spreads = scenario.worn(along), scenario.uncertainties(along)
    shares = {name: _shares(spreads[name], known[name]) for name in ("depth", *_DISC_OUTCOMES)}
    for place in places.tolist():
        depth, area = course.depth[place], course.volume[place]
        own = {name: float(column[place]) for name, column in shares.items()}
        yield LocalDiscPoint(
            rotations=_quantity(along[place], "1"),
            slip_rotations=_quantity(along[place] * abs(values["slip"]), "1"),
            half_width=_quantity(course.half_width[place], "m"),
            half_length=_quantity(course.half_length[place], "m"),
            curved_disc_wear_depth=_quantity(share * depth, "m", own["curved_depth"]),
            flat_disc_wear_depth=_quantity((1 - share) * depth, "m", own["flat_depth"]),
            curved_disc_wear_volume=_quantity(
                2 * np.pi * values["curved_radius"] * share * area, "m^3", own["curved_volume"]
            ),
            flat_disc_wear_volume=_quantity(
                2 * np.pi * values["flat_radius"] * (1 - share) * area, "m^3", own["flat_volume"]
            ),
            **_common(place, course, mean, giwm, shares["depth"]),
        )


def _notes(scenario: Scenario, end: float, half_width: float) -> Iterator[str]:
    exact = _exactness(scenario.known.first)
    last = {**scenario.worn(np.asarray(end)), "half_width": np.asarray(half_width)}
    # Local wear neglects no elastic deformation, as the model with uniform pressure beside it may.
    local = replace(scenario, known=replace(scenario.known, engine="local"))
    limits = local.wear.notes(scenario.values, last)
    yield from (*exact, *limits) if scenario.slip is not None else (*limits, *exact)


def _engine_notes(scenario: Scenario, both: bool) -> Iterator[str]:
    """State why a pin is simulated with another engine, and which length a stroke was given."""
    if not both:
        return
    first, second = map(spoken, scenario.wear.bodies)
    yield f"the {second} wears as well as the {first}, so that the contact is not axisymmetric: half-space engine"
    if scenario.there_and_back:
        yield (
            "the groove is longer than the stroke by the extension at the end of the simulation; groove depths at "
            "shorter sliding distances are underestimated by a few percent at most"
        )


def archards_wear(fit: WearFit) -> KnownWear | None:
    """Return k_D of a fit as Archard's law has it, whatever way of counting distance it was made with; none without."""
    fitted = known_wear(fit)
    if fitted is None or fit.distance_per_rotation in (None, ARCHARDS):
        return fitted
    same = next((other for other in fit.equivalents if other.distance_per_rotation == ARCHARDS), None)
    if same is None:
        return None
    bodies = {name: _as_uncertain(same.bodies[name], found) for name, found in fitted.bodies.items()}
    return replace(fitted, bodies=bodies, distance=ARCHARDS)


def _as_uncertain(coefficient: Quantity, fitted: Quantity) -> Quantity:
    """Return a coefficient with the relative uncertainty of another one that gives the same wear."""
    if not (fitted.value and fitted.standard_uncertainty):
        return coefficient
    return _quantity(coefficient.value, coefficient.unit, fitted.standard_uncertainty / fitted.value)


def _along(at: Sequence[float]) -> Column:
    """Return the places of a course: 0, the wanted ones, and some before and between them, even in their logarithm."""
    asked = np.asarray(at, dtype=float)
    if not (asked.size and np.all(np.isfinite(asked) & (asked > 0))):
        raise FitError(f"--at: found {list(at)}; expected one or more positive distances")
    anchors = np.unique(np.append(asked, asked.max() / 10**_DECADES))
    counts = np.ceil(_PLACES_PER_DECADE * np.diff(np.log10(anchors)) - _ROUNDING).astype(int)
    stretches = map(np.geomspace, anchors[:-1], anchors[1:], counts + 1)
    return np.unique(np.concatenate([np.zeros(1), *stretches]))


def _worn(contact: Contact, surface: Surface, amounts: Column, last: State, how: LocalOptions) -> LocalWear:
    every = how.update_mesh_every or None
    if how.scheme != "economy":
        return wear(surface, amounts, scheme=how.scheme, steps_per_decade=how.steps_per_decade, refresh_every=every)
    if not isinstance(surface, Elastic):
        raise economy_refused(contact, last)
    unworn = surface.press(np.zeros_like(surface.gap))
    return wear_economically(
        surface,
        amounts,
        increment=_STABLE_SHARE * surface.stable_amount(unworn),
        correct_every=every,
        stress_loss=how.stress_loss,
    )


def _told(how: LocalOptions, usual: Engine, course: LocalWear) -> dict[str, Any]:
    """Return how a result was computed."""
    return {
        "engine": how.engine or usual,
        "scheme": how.scheme,
        "steps_per_decade": how.steps_per_decade,
        "update_mesh_every": how.update_mesh_every,
        "stress_loss": how.stress_loss,
        "grid": course.pressure.shape[1:],
        "finest": _quantity(min(np.diff(axis).min() for axis in course.places), "m"),
    }


def _common(place: int, course: LocalWear, mean: Column, giwm: GlobalWear, shares: Column) -> dict[str, Any]:
    """Return what every contact has at a place; ``shares`` are relative uncertainties of its depth."""
    depth, other = float(course.depth[place]), float(giwm.depth[place])
    return {
        "wear_depth": _quantity(depth, "m", float(shares[place])),
        "peak_pressure": _quantity(course.peak_pressure[place], "Pa"),
        "middle_pressure": _quantity(course.middle_pressure[place], "Pa"),
        "mean_pressure": _quantity(mean[place], "Pa"),
        "giwm_depth": _quantity(other, "m", float(shares[place])),
        "difference": depth / other - 1 if other else None,
    }


def _coarseness(course: LocalWear, along: Column, places: Indices) -> Iterator[str]:
    """Report up to which of the wanted places the contact is too small for the points of the surface."""
    spacing = min(np.diff(axis).min() for axis in course.places)
    coarse = [place for place in places.tolist() if course.half_length[place] < _FEWEST_POINTS * spacing]
    if coarse:
        points = course.half_length[min(coarse)] / spacing
        yield (
            f"the contact radius spans only {points:.1f} grid points at {along[min(coarse)]:g}, and fewer than "
            f"{_FEWEST_POINTS} up to {along[max(coarse)]:g}: depths there may be wrong by a few percent"
        )


def _exactness(coefficient: Quantity) -> Iterator[str]:
    if coefficient.standard_uncertainty is None:
        yield "k_D is assumed to be exact, since its standard uncertainty is unknown"


def _quantity(value: float, unit: str, share: float | None = None) -> Quantity:
    """Return a quantity, with the share of it that its standard uncertainty is where that is known."""
    return Quantity(value=float(value), unit=unit, standard_uncertainty=None if share is None else share * abs(value))


def _shares(spreads: Column, values: Column) -> Column:
    """Return relative standard uncertainties; 0 where there is nothing."""
    return np.divide(spreads, np.abs(values), out=np.zeros_like(spreads), where=values != 0)

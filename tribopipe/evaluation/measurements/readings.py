"""Post-test measurements before conversion to wear: name, uncertainty and source.

`combined` gives functions of measured quantities with their combined standard uncertainty (JCGM 100:2008).
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from tribopipe.base.errors import FitError
from tribopipe.documents.quantity import EndValue, Quantity, of_readings
from tribopipe.documents.recipe import DefaultUncertainty
from tribopipe.evaluation.measurements.height_map import FEWEST_LINES, maps_of
from tribopipe.evaluation.measurements.map_difference import MapDifference, map_difference
from tribopipe.evaluation.measurements.track_profile import Track, worn_area
from tribopipe.physics.autocorrelation import effective_samples
from tribopipe.results.input_quantities import Source, stated_or_default
from tribopipe.results.run import Profile, RawRun, before_key

_NODES = ((math.sqrt(3), 1 / 6),)
"""Nodes of Gauss–Hermite quadrature above the best value, in standard uncertainties, and their weights."""
_NODES_AT_ZERO = tuple((math.sqrt(5 + side * math.sqrt(10)), (7 - side * 2 * math.sqrt(10)) / 60) for side in (-1, 1))
"""Nodes of a value of zero, where the volume of a scar goes with the fourth power of its size."""


class SignalDepths(NamedTuple):
    """Wear depths, m, that only the depth signal of a test gives."""

    pin: Quantity | None = None
    """That of a pin that was not measured: the shape of a groove depends on it."""
    pin_is_certain: bool = False
    """Whether that is wear beyond doubt, next to a groove that was measured."""
    both: Quantity | None = None
    """That of both bodies next to a pin that was measured, where the signal shows a groove that was not."""


def combined(function: Callable[..., float], given: Sequence[Quantity], unit: str) -> Quantity:
    """Return a function of independent quantities with its combined standard uncertainty (JCGM 100:2008, 5.1).

    What each contributes is the root mean square of f − f(best) over a normal distribution, by Gauss–Hermite quadrature
    with the nodes −√3u, 0 and √3u: u·|df/dx| where f is linear. Terms of second order are exact as well, so that a
    derivative that vanishes, as that of a cap's volume at no wear, does not make the result certain (5.1.2, note). At a
    value of zero five nodes make terms of fourth order exact, too. Of a rectangular distribution the nodes are its ends
    and its middle, and the rule is Simpson's.
    """
    best = [float(one.value) for one in given]
    value = float(function(*best))
    shares: list[float] = []
    for place, one in enumerate(given):
        spread = one.u_or_zero
        for node, weight in (_NODES if best[place] else _NODES_AT_ZERO) if spread else ():
            moved = ([*best[:place], best[place] + step * spread, *best[place + 1 :]] for step in (-node, node))
            shares += [math.sqrt(weight) * (function(*there) - value) for there in moved]
    return Quantity(value=value, unit=unit, standard_uncertainty=math.hypot(*shares))


PinWay = Literal[
    "pin_wear_depth",
    "pin_scar_diameter",
    "pin_scar_length",
    "pin_scar_width",
    "pin_wear_volume",
    "pin_mass_loss",
    "pin_profile",
]
SCARS = ("pin_scar_diameter", "pin_scar_length", "pin_scar_width")
PIN_MAP = "pin_height_map"
"""Volume by a height map of the tip."""
PIN_DIFFERENCE = "pin_height_map_difference"
"""Volume by height maps of the tip before and after the test."""
PIN_VOLUMES = ("pin_wear_volume", "pin_mass_loss", PIN_MAP, PIN_DIFFERENCE)
DISC_DIFFERENCE = "disc_height_map_difference"
"""Volume by height maps of the whole track before and after the test."""
VOLUMES = (*PIN_VOLUMES, "disc_wear_volume", "disc_mass_loss", DISC_DIFFERENCE)
AREA = "disc_track_area"
"""Cross-section of a track, which gives its volume but not its depth."""
WIDTHS = ("disc_track_width", "pin_scar_width")
BY_SIGNAL = "depth_signal"
"""Wear depth of both bodies by the depth signal of the test, m."""
APPROACHES = (*WIDTHS, BY_SIGNAL)
"""Readings that show the wear depth of both bodies together, but not what share of it each has."""
FEWEST_PLACES = 4
"""Places along a track at which it should be measured (ASTM G99)."""
A_MAP = 20
"""Profiles of one specimen that no one takes singly."""


@dataclass(frozen=True)
class EndValueUsed:
    """One post-test measurement as it enters the correction."""

    name: str
    quantity: Quantity
    """Measured quantity of the pin (a mass as its volume); wear depth of the disc."""
    source: Source
    per_radius: float = 0.0
    """Its derivative by the pin's radius, where a profile was leveled on a sphere of that radius."""
    on_unworn_track: float = 1.0
    """What a pin worn as deep on a track that does not wear would have of it: less volume, a narrower scar."""


def certain(value: EndValue, default: float) -> tuple[Quantity, Source]:
    """Return a post-test measurement as a plain quantity with its standard uncertainty, stated or by default."""
    plain = Quantity(value=value.value, unit=value.unit, standard_uncertainty=value.standard_uncertainty)
    return stated_or_default(plain, default)


def volume_of_mass(mass: Quantity, density: Quantity) -> Quantity:
    """Return the volume m/ρ of a mass, m³."""
    return combined(lambda m, rho: m / rho, (mass, density), "m^3")


def known_density(run: RawRun, body: str, key: str, defaults: DefaultUncertainty) -> Quantity:
    """Return the density of a body. Raises ``FitError`` where run.toml does not state it."""
    contact = run.manifest.described
    density, name = contact.in_roles[body].density, contact.body_name(body)
    if density is None:
        raise FitError(
            f"{run.id}: {key}: found a mass loss of the {body} without a density; expected contact.{name}.density, "
            'which converts it to a wear volume; add this key, such as density = "3.21 g/cm^3"'
        )
    known, _ = stated_or_default(density, defaults.density * density.value)
    return known


def profiles_at(run: RawRun, key: str) -> dict[str, Profile]:
    """Return the profiles that run.toml names under a key such as "end_values.disc_profile", one or several."""
    return {name: profile for name, profile in run.profiles.items() if name == key or name.startswith(f"{key}[")}


def differences_at(run: RawRun, key: str) -> list[MapDifference]:
    """Return the difference of each pair of height maps, before and after the test, that run.toml names under a key.

    Raises ``FitError``, naming the map, where one of a pair is no map, or they cannot be registered.
    """
    after, before = (profiles_at(run, one) for one in (key, before_key(key)))
    if not before:
        return []
    scans = [_scans(run, profiles, name) for profiles, name in ((after, key), (before, before_key(key)))]
    if len(scans[0]) != len(scans[1]):
        raise FitError(
            f"{run.id}: {key}: map: found {len(scans[0])} maps after the test and {len(scans[1])} before it; expected "
            "one before each; list each file once"
        )
    found = []
    for name, one, other in zip(scans[0], scans[0].values(), scans[1].values(), strict=True):
        try:
            found.append(map_difference(one, other))
        except FitError as error:
            raise FitError(f"{run.id}: {key} of {name}: {error}") from None
    return found


def _scans(run: RawRun, profiles: Mapping[str, Profile], key: str) -> dict[str, list[Profile]]:
    if found := maps_of(profiles):
        return found
    raise FitError(
        f"{run.id}: {key}: map: found {len(profiles)} profiles that are no height map; expected at least "
        f"{FEWEST_LINES} scan lines with their positions across, both before and after the test; export columns x, y "
        "and z, or remove before from run.toml"
    )


def tracks_in(run: RawRun, profiles: Mapping[str, Profile], radius: float | None) -> list[Track]:
    """Return the track of each profile. Raises ``FitError``, naming the profile, where there is none."""
    found = []
    for name, profile in profiles.items():
        try:
            found.append(worn_area(profile, radius))
        except FitError as error:
            raise FitError(f"{run.id}: {name}: {error}") from None
    return found


def over_places(found: Sequence[Quantity]) -> Quantity:
    """Return the mean of what was measured at several places, with their scatter and what each is uncertain by itself.

    u² = q²·s²/n + Σu²/n², with q as of repeated readings; what each is uncertain by is its own noise. Of so many
    that they may be the lines of a map, n counts as many as are independent of each other, in both terms.
    """
    own = math.hypot(*(one.u_or_zero for one in found)) / len(found)
    values = [one.value for one in found]
    value, scatter = of_readings(values)
    shared = len(values) / effective_samples(np.asarray(values)) if len(values) >= A_MAP else 1.0
    spread = math.sqrt(shared) * math.hypot(scatter or 0.0, own)
    return Quantity(value=value, unit=found[0].unit, standard_uncertainty=spread)


def volume_lost(run: RawRun, key: str, differences: Sequence[MapDifference]) -> Quantity:
    """Return the volume lost by differences of height maps, m³. Raises ``FitError``, naming the key."""
    try:
        return over_places([one.volume() for one in differences])
    except FitError as error:
        raise FitError(f"{run.id}: {key}: {error}") from None

"""What was measured on a pin, each as the reading that the worn tip follows from.

A height map is integrated as a whole: its volume does not depend on whether the scar is flat, or lies square to the
axis of the pin.
"""

import math
from collections.abc import Iterator, Mapping, Sequence

from tribopipe.base.errors import FitError
from tribopipe.documents.manifest import EndValues
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import DefaultUncertainty
from tribopipe.evaluation.measurements.readings import (
    A_MAP,
    PIN_DIFFERENCE,
    PIN_MAP,
    SCARS,
    EndValueUsed,
    certain,
    differences_at,
    known_density,
    over_places,
    profiles_at,
    tracks_in,
    volume_lost,
    volume_of_mass,
)
from tribopipe.evaluation.measurements.tip_map import volume_below_sphere
from tribopipe.evaluation.measurements.worn_tip import WornTip, tip_maps, tip_radius
from tribopipe.results.run import Profile, RawRun, before_key

_STEP = 1e-4
"""Share of the tip's radius by which it is varied to see what it does to a profile's depth."""


def pin_values(run: RawRun, where: str, end: EndValues, defaults: DefaultUncertainty) -> Iterator[EndValueUsed]:
    """Yield each post-test measurement of the pin with its uncertainty; masses and maps as volumes, profiles as depths.

    Raises ``FitError`` for a mass without density, and for a profile or map that shows no scar on a sphere.
    """
    if end.pin_wear_depth is not None:
        yield EndValueUsed("pin_wear_depth", *certain(end.pin_wear_depth, defaults.wear_depth.value))
    for name in SCARS:
        scar = getattr(end, name)
        if scar is not None:
            yield EndValueUsed(name, *certain(scar, defaults.pin_scar_diameter.value))
    if end.pin_wear_volume is not None:
        spread = defaults.wear_volume * abs(end.pin_wear_volume.value)
        yield EndValueUsed("pin_wear_volume", *certain(end.pin_wear_volume, spread))
    if end.pin_mass_loss is not None:
        mass, source = certain(end.pin_mass_loss, defaults.mass_loss.value)
        density = known_density(run, "pin", f"{where}.pin_mass_loss", defaults)
        yield EndValueUsed("pin_mass_loss", volume_of_mass(mass, density), source)
    if differences := differences_at(run, f"{where}.pin_profile"):
        yield EndValueUsed(PIN_DIFFERENCE, volume_lost(run, f"{where}.pin_profile", differences), "manifest")
    elif profiles := profiles_at(run, f"{where}.pin_profile"):
        yield _profiled(run, f"{where}.pin_profile", profiles, defaults)


def _profiled(run: RawRun, key: str, profiles: Mapping[str, Profile], defaults: DefaultUncertainty) -> EndValueUsed:
    """Return the depth of the scar's middle below the sphere, m, and what the sphere's radius does to it."""
    tip = WornTip.of(run.manifest.described.equivalent_pin)
    if not tip.widens:
        raise FitError(
            f"{run.id}: {key}: found a profile of a flat pin or block, which has no unworn surface for "
            "leveling; expected a profile of a spherical tip; use pin_wear_depth or pin_mass_loss instead"
        )
    if maps := tip_maps(run, key.removesuffix(".pin_profile")):
        return _mapped(run, key, maps, tip_radius(run, defaults))
    through = _through_the_middle(run, profiles, tip.radius)

    def depth(radius: float) -> Quantity:
        return over_places([track.depth for track in tracks_in(run, through, radius)])

    low, high = (depth(tip.radius * (1 + step)).value for step in (-_STEP, _STEP))
    return EndValueUsed("pin_profile", depth(tip.radius), "manifest", (high - low) / (2 * _STEP * tip.radius))


def _mapped(run: RawRun, key: str, maps: Mapping[str, Sequence[Profile]], radius: Quantity) -> EndValueUsed:
    """Return the volume lost by maps of the tip, m³, without that of its flat, and what the radius does to it."""
    tip, below = WornTip.of(run.manifest.described.equivalent_pin), []
    for name, lines in maps.items():
        try:
            below.append(volume_below_sphere(lines, radius))
        except FitError as error:
            raise FitError(f"{run.id}: {key} of {name}: {error}") from None
    volume = over_places([one.volume for one in below])
    missing, low, high = (tip.flat_volume(tip.radius * (1 + step)) for step in (0.0, -_STEP, _STEP))
    lost = volume.model_copy(update={"value": volume.value - missing})
    per_radius = math.fsum(one.per_radius for one in below) / len(below) - (high - low) / (2 * _STEP * tip.radius)
    return EndValueUsed(PIN_MAP, lost, "manifest", per_radius)


def pin_notes(run: RawRun, where: str) -> Iterator[str]:
    """Report a map of the tip that cannot be integrated because nothing is known of where its lines are."""
    key = f"{where}.pin_profile"
    single = not profiles_at(run, before_key(key))
    if single and len(profiles_at(run, key)) >= A_MAP and not tip_maps(run, where):
        yield (
            f"{where}.pin_profile is a height map without positions across its scan lines: its deepest line is used, "
            "which is exact only for a flat scar; export the map with columns x, y and z"
        )


def _through_the_middle(run: RawRun, profiles: Mapping[str, Profile], radius: float) -> Mapping[str, Profile]:
    """Return the profiles themselves, or of a map whose lines have no position across, the one that is deepest.

    Raises ``FitError`` where no line of a map shows a flat.
    """
    if len(profiles) < A_MAP:
        return profiles
    depths: dict[str, float] = {}
    failed: FitError | None = None
    for name, profile in profiles.items():
        try:
            (track,) = tracks_in(run, {name: profile}, radius)
            depths[name] = track.depth.value
        except FitError as error:
            failed = error
    if failed is not None and not depths:
        raise failed
    deepest = max(depths, key=lambda name: depths[name])
    return {deepest: profiles[deepest]}

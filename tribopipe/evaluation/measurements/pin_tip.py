"""The worn tip of a pin: its depth and volume by whatever was measured on it, and back.

A spherical tip is worn flat: a scar of diameter d is the base of a cap, whose height is the depth and whose volume was
lost. A truncated sphere has lost what lies between its flat and the scar. A flat pin keeps its area. What was measured
is kept as it is, a scar as a scar, so that the radius of the tip can vary independently. A height map is integrated as
a whole: its volume does not depend on whether the scar is flat, or lies square to the axis of the pin.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tribopipe.base.arrays import Column
from tribopipe.base.errors import FitError
from tribopipe.documents.contact import Shape, Tip
from tribopipe.documents.manifest import EndValues
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import DefaultUncertainty
from tribopipe.evaluation.measurements.height_map import maps_of
from tribopipe.evaluation.measurements.map_difference import MapDifference
from tribopipe.evaluation.measurements.readings import (
    A_MAP,
    EndValueUsed,
    certain,
    differences_at,
    over_places,
    profiles_at,
    tracks_in,
    volume_of_mass,
)
from tribopipe.evaluation.measurements.tip_map import volume_below_sphere
from tribopipe.physics.geometry import (
    cap_height,
    scar_depth,
    scar_radius_at,
    segment_area,
    segment_height,
    worn_depth,
    worn_volume,
)
from tribopipe.physics.pin_on_track import BlockOnTrack, FlatOnTrack, OnTrack, SphereOnTrack
from tribopipe.results.input_quantities import stated_or_default
from tribopipe.results.run import Profile, RawRun, before_key

PIN_MAP = "pin_height_map"
"""Volume by a height map of the tip."""
PIN_DIFFERENCE = "pin_height_map_difference"
"""Volume by height maps of the tip before and after the test."""
PIN_VOLUMES = ("pin_wear_volume", "pin_mass_loss", PIN_MAP, PIN_DIFFERENCE)
SCARS = ("pin_scar_diameter", "pin_scar_length", "pin_scar_width")
_STEP = 1e-4
"""Share of the tip's radius by which it is varied to see what it does to a profile's depth."""


@dataclass(frozen=True)
class PinTip:
    """A pin's tip before the test."""

    shape: Shape
    radius: float
    """Radius of the sphere, or of the end face of a flat pin, m."""
    flat_radius: float = 0.0
    """a₀ of a truncated sphere, m."""
    line: float = 0.0
    """Length of a line contact across the sliding, m; 0 of any other."""

    @property
    def widens(self) -> bool:
        """Whether wear makes the contact wider across the sliding, so that a groove shapes it."""
        return self.shape in ("spherical", "truncated-sphere")

    @classmethod
    def of(cls, pin: Tip) -> "PinTip":
        """Return the tip that run.toml describes."""
        return cls(pin.shape, pin.radius.value, pin.flat, pin.line)

    def depth(self, used: EndValueUsed, value: ArrayLike, radius: ArrayLike) -> Column:
        """Return the wear depth, m, were this post-test measurement and the tip's radius these; odd about no wear."""
        measured, r = used.on_unworn_track * np.asarray(value, dtype=float), np.asarray(radius, dtype=float)
        if used.name in SCARS:
            depth = scar_depth(scar_radius=np.abs(measured) / 2, sphere_radius=r, flat_radius=self.flat_radius)
            return np.where(measured < 0, -depth, depth)
        if used.name in PIN_VOLUMES:
            return self.depth_of_volume(used.on_unworn_track * self.volume_read(used, value, r), r)
        if used.name == "pin_profile":
            below_sphere = measured + used.per_radius * (r - self.radius)
            return np.asarray(below_sphere - cap_height(scar_radius=self.flat_radius, sphere_radius=r))
        return measured

    def volume_read(self, used: EndValueUsed, value: ArrayLike, radius: ArrayLike) -> Column:
        """Return the volume lost, m³, by a reading of a volume, were the tip's radius this."""
        return np.asarray(value, dtype=float) + used.per_radius * (np.asarray(radius, dtype=float) - self.radius)

    def value(self, used: EndValueUsed, depth: float) -> float:
        """Return what this way of measuring would find at a depth, m, the track worn in proportion."""
        if used.name in SCARS:
            return 2 * float(self.scar_radius(depth, self.radius)) / used.on_unworn_track
        if used.name in PIN_VOLUMES:
            return float(self.volume(depth, self.radius)) / used.on_unworn_track
        if used.name == "pin_profile":
            return depth + float(cap_height(scar_radius=self.flat_radius, sphere_radius=self.radius))
        return depth

    def volume(self, depth: ArrayLike, radius: ArrayLike) -> Column:
        """Return the volume lost at a depth, m³: of a cap, of what lies between two flats, or of a cylinder."""
        h, r = np.asarray(depth, dtype=float), np.asarray(radius, dtype=float)
        if self.shape == "flat":
            return np.asarray(np.pi * r**2 * h)
        if self.line:
            return np.asarray(self.line * segment_area(half_chord=self.scar_radius(h, r), radius=r))
        return worn_volume(depth=h, sphere_radius=r, flat_radius=self.flat_radius)

    def flat_volume(self, radius: float) -> float:
        """Return what a truncated sphere of this radius, m, was missing before the test, m³."""
        height = cap_height(scar_radius=self.flat_radius, sphere_radius=radius)
        return float(worn_volume(depth=height, sphere_radius=radius))

    def depth_of_volume(self, volume: Column, radius: Column) -> Column:
        """Return the depth, m, at which the tip alone has lost a volume, m³; at most all of the tip."""
        if self.shape == "flat":
            return np.asarray(volume / (np.pi * radius**2))
        if self.line:
            return segment_height(area=volume / self.line, radius=radius)
        return worn_depth(volume=volume, sphere_radius=radius, flat_radius=self.flat_radius)

    def on_track(self, radius: float) -> OnTrack:
        """Return the contact of such a tip, of this radius, m, with a track that wears as well."""
        if self.line:
            return BlockOnTrack(radius, self.line)
        return FlatOnTrack(radius) if self.shape == "flat" else SphereOnTrack(radius, self.flat_radius)

    def scar_radius(self, depth: ArrayLike, radius: ArrayLike) -> Column:
        """Return the radius of the flat at a depth, m."""
        if self.shape == "flat":
            return np.asarray(radius, dtype=float)
        return scar_radius_at(depth=depth, sphere_radius=radius, flat_radius=self.flat_radius)


def tip_radius(run: RawRun, defaults: DefaultUncertainty) -> Quantity:
    """Return the radius of the pin with its standard uncertainty, stated or by default."""
    radius = run.manifest.sliding_pin.equivalent_pin.radius
    known, _ = stated_or_default(radius, defaults.pin_radius * radius.value)
    return known


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


def _profiled(run: RawRun, key: str, profiles: Mapping[str, Profile], defaults: DefaultUncertainty) -> EndValueUsed:
    """Return the depth of the scar's middle below the sphere, m, and what the sphere's radius does to it."""
    tip = PinTip.of(run.manifest.sliding_pin.equivalent_pin)
    if not tip.widens:
        raise FitError(
            f"{run.id}: {key}: found a profile of a flat pin or block, which has no unworn surface for "
            "leveling; expected a profile of a spherical tip; use pin_wear_depth or pin_mass_loss instead"
        )
    if maps := pin_maps(run, key.removesuffix(".pin_profile")):
        return _mapped(run, key, maps, tip_radius(run, defaults))
    through = _through_the_middle(run, profiles, tip.radius)

    def depth(radius: float) -> Quantity:
        return over_places([track.depth for track in tracks_in(run, through, radius)])

    low, high = (depth(tip.radius * (1 + step)).value for step in (-_STEP, _STEP))
    return EndValueUsed("pin_profile", depth(tip.radius), "manifest", (high - low) / (2 * _STEP * tip.radius))


def _mapped(run: RawRun, key: str, maps: Mapping[str, Sequence[Profile]], radius: Quantity) -> EndValueUsed:
    """Return the volume lost by maps of the tip, m³, without that of its flat, and what the radius does to it."""
    tip, below = PinTip.of(run.manifest.sliding_pin.equivalent_pin), []
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


def volume_lost(run: RawRun, key: str, differences: Sequence[MapDifference]) -> Quantity:
    """Return the volume lost by differences of height maps, m³. Raises ``FitError``, naming the key."""
    try:
        return over_places([one.volume() for one in differences])
    except FitError as error:
        raise FitError(f"{run.id}: {key}: {error}") from None


def pin_maps(run: RawRun, where: str) -> dict[str, list[Profile]]:
    """Return the height maps of a spherical tip by name, each as its scan lines; none where only profiles were taken.

    ``where`` is the key of the measurements, such as "end_values".
    """
    tip = PinTip.of(run.manifest.sliding_pin.equivalent_pin)
    key = f"{where}.pin_profile"
    return maps_of(profiles_at(run, key)) if tip.widens and not profiles_at(run, before_key(key)) else {}


def pin_notes(run: RawRun, where: str) -> Iterator[str]:
    """Report a map of the tip that cannot be integrated because nothing is known of where its lines are."""
    key = f"{where}.pin_profile"
    single = not profiles_at(run, before_key(key))
    if single and len(profiles_at(run, key)) >= A_MAP and not pin_maps(run, where):
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

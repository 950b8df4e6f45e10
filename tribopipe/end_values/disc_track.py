"""The track on the disc that a pin rubs on: its depth and volume by whatever was measured across it.

A profile tells depth and cross-section A; a circle of radius R_t makes of it the volume 2πR_t·A, a stroke there and
back A times its length and the rounded ends. A depth or width alone tells the cross-section where the groove is taken
to be that of the pin as it is worn at the end: as deep across its middle as the flat on the pin, its walls the pin's
sphere. With a pin that has not worn that is the groove of ASTM G99. Nothing else tells a volume from a depth or a
width, so that a flat pin tells none; and a track no wider than the flat on the pin tells no depth.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Literal

from tribopipe.end_values.measured import (
    FEWEST_PLACES,
    BodyWear,
    DiscWay,
    Source,
    certain,
    over_places,
    profiles_at,
    stated_or_default,
    surest,
    tracks_in,
    volume_of_mass,
)
from tribopipe.end_values.pin_tip import known_density
from tribopipe.geometry import (
    circle_volume,
    groove_area,
    scar_depth,
    scar_radius_at,
    stroke_volume,
    worn_volume,
)
from tribopipe.profile.track import Track
from tribopipe.records.manifest import Conditions, EndValues
from tribopipe.records.quantity import Quantity
from tribopipe.records.recipe import DefaultUncertainty
from tribopipe.run import RawRun
from tribopipe.uncertainty import first_order


@dataclass(frozen=True)
class SlidingPath:
    """Where a pin slides on its disc."""

    length: Quantity
    """Radius of the circle, or the stroke, m."""
    there_and_back: bool

    @classmethod
    def of(cls, conditions: Conditions, defaults: DefaultUncertainty) -> "SlidingPath | None":
        """Return the path that run.toml describes; none where it does not."""
        length = conditions.stroke or conditions.track_radius
        if length is None:
            return None
        known, _ = stated_or_default(length, defaults.track_radius * length.value)
        return cls(known, there_and_back=conditions.stroke is not None)

    def volume(self, area: float, length: float, ends: float) -> float:
        """Return the volume of a track with this cross-section, m², and these rounded ends, m³, if it has any."""
        if self.there_and_back:
            return float(stroke_volume(area=area, stroke=length, ends=ends))
        return float(circle_volume(area=area, track_radius=length))


@dataclass(frozen=True)
class ToldBy:
    """What a derived sliding distance is proportional to."""

    name: Literal["sliding_speed", "track_radius"]
    quantity: Quantity
    source: Source


def told_by(run: RawRun, defaults: DefaultUncertainty) -> ToldBy | None:
    """Return the speed or track radius that a sliding distance was derived from; none of one that was measured.

    A speed that is itself made of rotational speed and radius, or of frequency and stroke, is as uncertain as both.
    """
    conditions, origin = run.manifest.conditions, run.origins.get("sliding_distance")
    radius, speed = conditions.track_radius, conditions.nominal_speed
    if origin == "derived from rotations" and radius is not None:
        return ToldBy("track_radius", *stated_or_default(radius, defaults.track_radius * radius.value))
    if origin != "derived from nominal speed" or speed is None:
        return None
    path = SlidingPath.of(conditions, defaults) if conditions.sliding_speed is None else None
    along = 0.0 if path is None else (path.length.standard_uncertainty or 0.0) / path.length.value
    share = math.hypot(defaults.sliding_speed, along)
    return ToldBy("sliding_speed", *stated_or_default(speed, share * speed.value))


@dataclass(frozen=True)
class Groove:
    """The groove that a round pin leaves, as it is worn at the end, along its path."""

    radius: Quantity
    """Of the sphere, m."""
    flat: Quantity
    """Radius of the flat worn on it, m."""
    path: SlidingPath | None

    def depth_of_width(self, width: Quantity) -> Quantity:
        """Return the depth of a track of this width, m."""
        return first_order(_depth_of_width, (width, self.radius, self.flat), "m")

    def volume_of_width(self, width: Quantity) -> Quantity | None:
        """Return the volume of a track of this width, m³; none where the path is not known."""

        def volume(path: SlidingPath, wide: float, radius: float, flat: float, length: float) -> float:
            return _volume(path, _depth_of_width(wide, radius, flat), radius, flat, length)

        return self._along_path(volume, width, "m^3")

    def volume_of_depth(self, depth: Quantity) -> Quantity | None:
        """Return the volume of a track of this depth, m³; none where the path is not known."""
        return self._along_path(_volume, depth, "m^3")

    def depth_of_volume(self, volume: Quantity) -> Quantity | None:
        """Return the depth of a track of this volume, m; none where the path is not known."""
        return self._along_path(_depth_of_volume, volume, "m")

    def _along_path(self, function: Callable[..., float], measured: Quantity, unit: str) -> Quantity | None:
        if self.path is None:
            return None
        given = (measured, self.radius, self.flat, self.path.length)
        return first_order(partial(function, self.path), given, unit)


def _depth_of_width(width: float, radius: float, flat: float) -> float:
    return float(scar_depth(scar_radius=width / 2, sphere_radius=radius, flat_radius=flat))


def _volume(path: SlidingPath, depth: float, radius: float, flat: float, length: float) -> float:
    half = scar_radius_at(depth=depth, sphere_radius=radius, flat_radius=flat)
    area = float(groove_area(half_width=half, sphere_radius=radius, flat_radius=flat))
    return path.volume(area, length, float(worn_volume(depth=depth, sphere_radius=radius, flat_radius=flat)))


def _depth_of_volume(path: SlidingPath, lost: float, radius: float, flat: float, length: float) -> float:
    """Invert ``_volume`` by bracketing, between no groove and one as wide as the sphere."""
    from scipy.optimize import brentq

    most = float(scar_depth(scar_radius=radius, sphere_radius=radius, flat_radius=flat))
    if lost <= 0:
        return 0.0
    if _volume(path, most, radius, flat, length) <= lost:
        return most

    def excess(depth: float) -> float:
        return _volume(path, depth, radius, flat, length) - lost

    return float(brentq(excess, 0.0, most, xtol=1e-15 * most, rtol=1e-13))


def disc_wear(
    run: RawRun, where: str, end: EndValues, groove: Groove | None, defaults: DefaultUncertainty
) -> Iterator[BodyWear]:
    """Yield depth and volume of the track by each thing measured on the disc; ``groove`` is none for a flat pin.

    Raises ``FitError`` for a mass without density, and for a profile that shows no track.
    """
    if end.disc_wear_depth is not None:
        depth, source = certain(end.disc_wear_depth, defaults.wear_depth.value)
        volume = None if groove is None else groove.volume_of_depth(depth)
        yield BodyWear("disc_wear_depth", source, depth, volume, frozenset({"volume"}))
    if end.disc_track_width is not None:
        yield _by_width(*certain(end.disc_track_width, defaults.track_width.value), groove)
    if end.disc_wear_volume is not None:
        volume, source = certain(end.disc_wear_volume, defaults.wear_volume * end.disc_wear_volume.value)
        yield _by_volume("disc_wear_volume", volume, source, groove)
    if end.disc_mass_loss is not None:
        mass, source = certain(end.disc_mass_loss, defaults.mass_loss.value)
        density = known_density(run, "disc", f"{where}.disc_mass_loss", defaults)
        yield _by_volume("disc_mass_loss", volume_of_mass(mass, density), source, groove)
    if profiles := profiles_at(run, f"{where}.disc_profile"):
        yield _by_profiles(tracks_in(run, profiles, None), SlidingPath.of(run.manifest.conditions, defaults))


def _by_width(width: Quantity, source: Source, groove: Groove | None) -> BodyWear:
    if groove is None or width.value <= 2 * groove.flat.value:
        return BodyWear("disc_track_width", source)
    depth, volume = groove.depth_of_width(width), groove.volume_of_width(width)
    return BodyWear("disc_track_width", source, depth, volume, frozenset({"depth", "volume"}))


def _by_volume(name: DiscWay, volume: Quantity, source: Source, groove: Groove | None) -> BodyWear:
    depth = None if groove is None else groove.depth_of_volume(volume)
    return BodyWear(name, source, depth, volume, frozenset({"depth"}))


def _by_profiles(found: list[Track], path: SlidingPath | None) -> BodyWear:
    """Return mean depth and volume by profiles at one or several places of the track."""
    depth, area = over_places([track.depth for track in found]), over_places([track.area for track in found])
    if path is None:
        return BodyWear("disc_profile", "manifest", depth)
    # Both ends hold as much as this length more of the stroke, however large the section.
    longer = sum(track.cap.value for track in found) / len(found) / area.value

    def volume(section: float, length: float) -> float:
        return path.volume(section, length, section * longer)

    return BodyWear("disc_profile", "manifest", depth, first_order(volume, (area, path.length), "m^3"))


def disc_notes(run: RawRun, end: EndValues, ways: Sequence[BodyWear], groove: Groove | None) -> Iterator[str]:
    """Say what stands in the way of the disc's depth and volume, and what they take for granted."""
    conditions, best = run.manifest.conditions, surest(ways, "volume")
    if ways and best is None:
        lacking = conditions.track_radius is None and conditions.stroke is None
        yield (
            "track_radius, or stroke, is missing: no volume of the disc"
            if lacking
            else "depth or width of the track alone tell no volume of the disc"
        )
    if best is not None and "volume" in best.assumed:
        yield f"{best.name} alone was measured: its volume takes the groove to be that of the pin as it is worn"
    width = end.disc_track_width
    if groove is not None and width is not None and width.value <= 2 * groove.flat.value:
        flat = Quantity(value=2 * groove.flat.value, unit="m").shown("um")
        yield f"the track, {width.shown('um')} wide, is no wider than the flat of {flat} on the pin: it tells no depth"
    if 0 < len(end.disc_profile) < FEWEST_PLACES:
        yield (
            f"the track was measured at {len(end.disc_profile)} of at least {FEWEST_PLACES} places: how it varies is "
            "hardly known"
        )

"""The worn tip of the body that stays in contact: its depth and volume by whatever was measured on it, and back.

A spherical tip is worn flat: a scar of diameter d is the base of a cap, whose height is the depth and whose volume was
lost. A truncated sphere has lost what lies between its flat and the scar. A flat pin keeps its area. What was measured
is kept as it is, a scar as a scar, so that the radius of the tip can vary independently.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tribopipe.base.arrays import Column
from tribopipe.documents.contact import Tip
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import DefaultUncertainty
from tribopipe.evaluation.measurements.height_map import maps_of
from tribopipe.evaluation.measurements.readings import PIN_VOLUMES, SCARS, EndValueUsed, profiles_at
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


@dataclass(frozen=True)
class WornTip:
    """A tip before the test."""

    radius: float
    """Radius of the sphere, or of the end face of a flat pin, m."""
    widens: bool = True
    """Whether wear makes the contact wider across the sliding, so that a groove shapes it."""
    constant_area: bool = False
    """Whether the contact area stays the same as the tip wears: a flat end."""
    flat_radius: float = 0.0
    """a₀ of a truncated sphere, m."""
    line: float = 0.0
    """Length of a line contact across the sliding, m; 0 of any other."""

    @classmethod
    def of(cls, pin: Tip) -> "WornTip":
        """Return the tip that run.toml describes."""
        return cls(pin.radius.value, pin.widens, pin.constant_area, pin.flat, pin.line)

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
        if self.constant_area:
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
        if self.constant_area:
            return np.asarray(volume / (np.pi * radius**2))
        if self.line:
            return segment_height(area=volume / self.line, radius=radius)
        return worn_depth(volume=volume, sphere_radius=radius, flat_radius=self.flat_radius)

    def on_track(self, radius: float) -> OnTrack:
        """Return the contact of such a tip, of this radius, m, with a track that wears as well."""
        if self.line:
            return BlockOnTrack(radius, self.line)
        return FlatOnTrack(radius) if self.constant_area else SphereOnTrack(radius, self.flat_radius)

    def scar_radius(self, depth: ArrayLike, radius: ArrayLike) -> Column:
        """Return the radius of the flat at a depth, m."""
        if self.constant_area:
            return np.asarray(radius, dtype=float)
        return scar_radius_at(depth=depth, sphere_radius=radius, flat_radius=self.flat_radius)


def tip_radius(run: RawRun, defaults: DefaultUncertainty) -> Quantity:
    """Return the radius of the pin with its standard uncertainty, stated or by default."""
    radius = run.manifest.described.equivalent_pin.radius
    known, _ = stated_or_default(radius, defaults.pin_radius * radius.value)
    return known


def tip_maps(run: RawRun, where: str) -> dict[str, list[Profile]]:
    """Return the height maps of a spherical tip by name, each as its scan lines; none where only profiles were taken.

    ``where`` is the key of the measurements, such as "end_values".
    """
    tip = run.manifest.described.equivalent_pin
    key = f"{where}.pin_profile"
    return maps_of(profiles_at(run, key)) if tip.widens and not profiles_at(run, before_key(key)) else {}

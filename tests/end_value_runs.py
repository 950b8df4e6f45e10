"""Runs of a pin on a disc whose end values are made of a known depth, whatever they are."""

import math

import numpy as np
from conftest import MANIFEST
from scipy.integrate import quad
from scipy.optimize import brentq

from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.quantity import Quantity
from tribopipe.physics.geometry import scar_depth, scar_radius_at, worn_volume
from tribopipe.physics.pin_on_track import SphereOnTrack
from tribopipe.physics.stroke_ends import Stroke
from tribopipe.results.run import Profile, RawRun

RADIUS, FLAT, DENSITY = 0.794e-3, 60e-6, 3210.0
SHAPES = ("spherical", "truncated-sphere", "flat")
PIN_WAYS = ("pin_wear_depth", "pin_scar_diameter", "pin_wear_volume", "pin_mass_loss", "pin_profile")


def flat_of(shape):
    return FLAT if shape == "truncated-sphere" else 0.0


def described(shape="spherical", conditions=None, density=True, **end) -> RunManifest:
    pin = {**MANIFEST["contact"]["pin"], "shape": shape, "radius": {"value": RADIUS, "unit": "m"}}
    if shape == "truncated-sphere":
        pin["flat_radius"] = {"value": FLAT, "unit": "m"}
    contact = {"kind": "pin-on-disc", "pin": pin, "disc": dict(MANIFEST["contact"]["disc"])}
    if density:
        contact["pin"]["density"] = contact["disc"]["density"] = {"value": DENSITY, "unit": "kg/m^3"}
    stated = {**MANIFEST["conditions"], **(conditions or {})}
    return RunManifest.model_validate({**MANIFEST, "contact": contact, "conditions": stated, "end_values": end})


def run_of(manifest: RunManifest, profiles=None) -> RawRun:
    distance = np.linspace(0, 500, 1001)
    columns = {"time": distance / 0.4, "sliding_distance": distance}
    return RawRun(manifest, columns, dict.fromkeys(columns, "measured"), {}, {}, (), profiles=profiles or {})


def si(value, unit, spread=0.0):
    return {"value": float(value), "unit": unit, "standard_uncertainty": float(spread)}


def volume_at(shape, depth):
    if shape == "flat":
        return math.pi * RADIUS**2 * depth
    return float(worn_volume(depth=depth, sphere_radius=RADIUS, flat_radius=flat_of(shape)))


def worn_tip(shape, depth, x):
    """Height across the middle of a tip worn by this depth."""
    scar = float(scar_radius_at(depth=depth, sphere_radius=RADIUS, flat_radius=flat_of(shape)))
    return np.sqrt(RADIUS**2 - np.maximum(np.abs(x), scar) ** 2) - RADIUS


def measured(way, shape, depth, share=0.0):
    """A run on whose pin this depth was measured in this way, uncertain by a share of what was measured."""
    scar = 2 * float(scar_radius_at(depth=depth, sphere_radius=RADIUS, flat_radius=flat_of(shape)))
    volume = volume_at(shape, depth)
    found = {
        "pin_wear_depth": (depth, "m"),
        "pin_scar_diameter": (scar, "m"),
        "pin_wear_volume": (volume, "m^3"),
        "pin_mass_loss": (volume * DENSITY, "kg"),
    }
    if way == "pin_profile":
        x = np.linspace(-1.6 * scar, 1.6 * scar, 4001)
        profile = Profile(x, worn_tip(shape, depth, x) + 3e-6)
        return run_of(described(shape, pin_profile={"file": "tip.csv"}), {"end_values.pin_profile": profile})
    value, unit = found[way]
    manifest = described(shape, **{way: si(value, unit, share * value)})
    bodies = {"density": Quantity(value=DENSITY, unit="kg/m^3", standard_uncertainty=0.0)}
    contact = manifest.contact.model_copy(update={"pin": manifest.contact.pin.model_copy(update=bodies)})
    return run_of(manifest.model_copy(update={"contact": contact}))


CIRCLE = {"track_radius": si(8e-3, "m")}
STROKE = {"stroke": si(5e-3, "m"), "sliding_speed": "400 mm/s"}


def track(path, half, flat):
    """Depth and volume of a track along a circle of 8 mm, or along a stroke of 5 mm with its ends."""
    depth, profile = groove(half, flat)
    area = 2 * quad(profile, 0, half, epsabs=0, epsrel=1e-11)[0]
    if path is CIRCLE:
        return depth, 2 * math.pi * 8e-3 * area
    manifest = described(conditions=path)
    stiffness = manifest.contact.reduced_modulus() / manifest.conditions.normal_load.value
    worn = SphereOnTrack(RADIUS).at_depths(scar_depth(scar_radius=flat, sphere_radius=RADIUS), depth)
    return depth, float(Stroke(np.asarray(5e-3), stiffness).extended(worn)) * area


def groove(half, scar):
    """Depth of the groove of a ball worn to a scar of this half length, and its profile, each slice by bracketing."""
    depth = float(scar_depth(scar_radius=half, sphere_radius=RADIUS, flat_radius=scar))

    def lost(rho, chord):
        return rho**2 * math.asin(chord / rho) - chord * math.sqrt(rho**2 - chord**2)

    def profile(x):
        rho, most = math.sqrt(RADIUS**2 - x**2), math.sqrt(max(half**2 - x**2, 0.0))
        if scar == 0 or most == 0:
            return float(scar_depth(scar_radius=half, sphere_radius=RADIUS, flat_radius=x))
        kappa = depth / lost(RADIUS, scar)

        def left(chord):
            below = scar_depth(scar_radius=half, sphere_radius=RADIUS, flat_radius=math.hypot(x, chord))
            return kappa * lost(rho, chord) - float(below)

        return kappa * lost(rho, brentq(left, 0.0, most, xtol=1e-18, rtol=1e-14))

    return depth, profile

"""Uncertainty of a sliding distance: of what it was derived from, and of the length of the path."""

import math
from dataclasses import dataclass
from typing import Literal

from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import DefaultUncertainty
from tribopipe.results.input_quantities import Input, relative_input, stated_or_default
from tribopipe.results.run import RawRun


def path_length(manifest: RunManifest, defaults: DefaultUncertainty) -> Quantity | None:
    """Return the stroke, or the radius of the circle, m, with its uncertainty; None if run.toml states neither."""
    length = manifest.conditions.stroke or manifest.conditions.track_radius
    return None if length is None else stated_or_default(length, _path_share(manifest, defaults) * length.value)[0]


def _path_share(manifest: RunManifest, defaults: DefaultUncertainty) -> float:
    """Return the relative default of the stroke or track radius: that of the body by which the path is given."""
    contact = manifest.contact
    return defaults.track_radius if contact is None or contact.track_key is None else defaults.pin_radius


@dataclass(frozen=True)
class ToldBy:
    """Input to which a derived sliding distance is proportional."""

    name: Literal["sliding_speed", "track_radius", "stroke"]
    given: Input
    """The input with its standard uncertainty, stated or by default."""


_FACTORS = ("rotational_speed", "frequency", "track_radius", "stroke")
"""What a speed is a product of, in pairs."""


def _speed_of_motion(speed: Quantity, manifest: RunManifest, defaults: DefaultUncertainty) -> Input:
    """Return a speed that is a product; each factor is as uncertain as stated, or else by its own default."""
    path = _path_share(manifest, defaults)
    factors = {
        name: relative_input(factor, path if name in ("track_radius", "stroke") else defaults.sliding_speed)
        for name in _FACTORS
        if (factor := getattr(manifest.conditions, name)) is not None
    }
    share = math.hypot(*(factor.spread / factor.quantity.value for factor in factors.values()))
    product = speed.model_copy(update={"standard_uncertainty": share * speed.value})
    unstated = tuple((name, factor.quantity) for name, factor in factors.items() if factor.source == "default")
    return Input(product, "default" if unstated else "manifest", factors=unstated)


def told_by(run: RawRun, defaults: DefaultUncertainty) -> ToldBy | None:
    """Return the speed, track radius or stroke that a sliding distance was derived from; none of a measured one.

    A recorded speed along a circle is as uncertain as its radius.
    A speed that is itself made of rotational speed and radius, or of frequency and stroke, is as uncertain as both.
    """
    conditions, origin = run.manifest.conditions, run.origins.get("sliding_distance")
    length, speed = conditions.stroke or conditions.track_radius, conditions.nominal_speed
    # A rotating rig records n and makes v of it, or run.toml does, by the radius that was set.
    turned = origin == "derived from measured speed" and conditions.stroke is None
    if (origin == "derived from rotations" or turned) and length is not None:
        name: Literal["stroke", "track_radius"] = "track_radius" if conditions.stroke is None else "stroke"
        return ToldBy(name, relative_input(length, _path_share(run.manifest, defaults)))
    if origin != "derived from nominal speed" or speed is None:
        return None
    if conditions.sliding_speed is None:
        return ToldBy("sliding_speed", _speed_of_motion(speed, run.manifest, defaults))
    return ToldBy("sliding_speed", relative_input(speed, defaults.sliding_speed))


def distance_share(run: RawRun, defaults: DefaultUncertainty) -> float | None:
    """Return the relative standard uncertainty of the sliding distance; None of one that was measured."""
    if told := told_by(run, defaults):
        return told.given.spread / told.given.quantity.value
    slip = run.manifest.slip_with(defaults.slip)
    if run.origins.get("sliding_distance") != "derived from nominal slip" or slip is None or not slip.value:
        return None
    speed, radius = run.manifest.conditions.curved_disc_speed, run.manifest.described.rolling_radii[0]
    rolled = stated_or_default(radius, defaults.rolling_radius * radius.value)
    if run.origins.get("rotations") == "derived from nominal speed" and speed is not None:
        rolled = stated_or_default(speed, defaults.sliding_speed * speed.value)
    known = (stated_or_default(slip, defaults.slip * abs(slip.value)), rolled)
    return math.hypot(*(one.u_or_zero / one.value for one, _ in known))

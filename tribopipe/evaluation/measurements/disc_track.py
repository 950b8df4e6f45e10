"""The track on the disc that a pin rubs on: its depth and volume by whatever was measured across it.

A profile shows depth and cross-section A; a circle of radius R_t makes of it the volume 2πR_t·A, a stroke there and
back A times its length and what its ends hold, as does A itself. A depth, width or volume alone is one reading of two
that are needed: the other is what was measured on the pin, or the width of the track with its depth. Where there is
none, the pin has had any share of the wear.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from tribopipe.documents.manifest import EndValues
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import DefaultUncertainty
from tribopipe.evaluation.measurements.body_wear import BodyWear, Pair, surest
from tribopipe.evaluation.measurements.readings import (
    APPROACHES,
    AREA,
    BY_SIGNAL,
    DISC_DIFFERENCE,
    FEWEST_PLACES,
    VOLUMES,
    WIDTHS,
    EndValueUsed,
    certain,
    combined,
    differences_at,
    known_density,
    over_places,
    profiles_at,
    tracks_in,
    volume_lost,
    volume_of_mass,
)
from tribopipe.evaluation.measurements.track_profile import Track
from tribopipe.evaluation.measurements.worn_pair import UNKNOWN_ENDS, UNKNOWN_SHARE, WornPair
from tribopipe.results.run import RawRun

_SECTION_DIFFERENCE = "disc_profile_difference"
"""Sections of a track by height maps before and after the test."""


def disc_readings(run: RawRun, where: str, end: EndValues, defaults: DefaultUncertainty) -> Iterator[EndValueUsed]:
    """Yield each reading of the disc with its uncertainty, profiles as the depth of the track, a mass as a volume.

    Raises ``FitError`` for a mass without density, and for a profile that shows no track.
    """
    if end.disc_wear_depth is not None:
        yield EndValueUsed("disc_wear_depth", *certain(end.disc_wear_depth, defaults.wear_depth.value))
    if end.disc_track_width is not None:
        yield EndValueUsed("disc_track_width", *certain(end.disc_track_width, defaults.track_width.value))
    if end.disc_track_area is not None:
        spread = defaults.wear_volume * end.disc_track_area.value
        yield EndValueUsed("disc_track_area", *certain(end.disc_track_area, spread))
    if end.disc_wear_volume is not None:
        spread = defaults.wear_volume * abs(end.disc_wear_volume.value)
        yield EndValueUsed("disc_wear_volume", *certain(end.disc_wear_volume, spread))
    if end.disc_mass_loss is not None:
        mass, source = certain(end.disc_mass_loss, defaults.mass_loss.value)
        density = known_density(run, "disc", f"{where}.disc_mass_loss", defaults)
        yield EndValueUsed("disc_mass_loss", volume_of_mass(mass, density), source)
    key = f"{where}.disc_profile"
    differences = differences_at(run, key)
    if differences and not any(one.reaches_edge for one in differences):
        yield EndValueUsed(DISC_DIFFERENCE, volume_lost(run, key, differences), "manifest")
    elif found := _tracks(run, where):
        name = _SECTION_DIFFERENCE if differences else "disc_profile"
        yield EndValueUsed(name, over_places([track.depth for track in found]), "manifest")


def _tracks(run: RawRun, where: str) -> list[Track]:
    """Return the track in each profile, or in each scan line of the difference of two height maps."""
    key = f"{where}.disc_profile"
    differences = differences_at(run, key)
    lines = {
        f"{key}, line {number}": line for number, line in enumerate(line for one in differences for line in one.lines)
    }
    return tracks_in(run, lines if differences else profiles_at(run, key), None)


def disc_wear(run: RawRun, where: str, readings: Sequence[EndValueUsed], pair: WornPair) -> Iterator[BodyWear]:
    """Yield depth and volume of the track by each reading, with that of the pin in ``pair``, or its own width."""
    widths = [one for one in readings if one.name in WIDTHS and pair.tip.widens]
    for one in readings:
        if one.name in ("disc_profile", _SECTION_DIFFERENCE):
            yield _by_profiles(_tracks(run, where), replace(pair, disc=one))
            continue
        others = [pair.pin] if pair.pin is not UNKNOWN_SHARE else []
        partners = [pin for pin in (*others, *widths) if not {pin.name, one.name} <= set(APPROACHES)]
        pairs = [replace(pair, disc=one, pin=pin) for pin in partners or [UNKNOWN_SHARE]]
        yield min((_by_pair(one) for one in pairs), key=_spread)


def _spread(way: BodyWear) -> float:
    """Return the relative uncertainty of the volume."""
    found = way.volume
    return math.inf if found is None or not found.value else abs(found.u_or_zero / found.value)


def _by_pair(pair: WornPair) -> BodyWear:
    """Return depth and volume, as far as the reading gives them: of a disc that has gained, a measured volume only."""
    name, quantity = pair.disc.name, pair.disc.quantity
    way = BodyWear(name, pair.disc.source, pair=pair, assumed=frozenset({"depth", "volume"}))
    if name in VOLUMES and quantity.value < 0:
        return replace(way, volume=quantity, assumed=frozenset(), pair=None)
    if name in VOLUMES:
        depth = None if pair.path is None else pair.find("disc_depth")
        known = None if pair.path is None else pair
        return replace(way, depth=depth, volume=quantity, assumed=frozenset({"depth"}), pair=known)
    if name == AREA:
        volume = None if pair.path is None else pair.find("disc_volume")
        return replace(way, depth=pair.find("disc_depth"), volume=volume, assumed=frozenset({"depth"}))
    if name in APPROACHES:
        depth = pair.find("disc_depth") if pair.tip.widens else None
        if depth is None or depth.value <= 0:
            return replace(way, pair=None)
    else:
        depth, way = quantity, replace(way, assumed=frozenset({"volume"}))
    return replace(way, depth=depth, volume=None if pair.path is None else pair.find("disc_volume"))


def _by_profiles(found: list[Track], pair: WornPair) -> BodyWear:
    """Return mean depth and volume by profiles at one or several places of the track."""
    depth, area = over_places([track.depth for track in found]), over_places([track.area for track in found])
    path = pair.path
    if path is None:
        return BodyWear(pair.disc.name, "manifest", depth)
    worn = pair.contact()

    def volume(section: float, length: float, ends: float) -> float:
        return path.volume(replace(worn, groove_area=np.asarray(section)), length, ends)

    ends = UNKNOWN_ENDS if path.there_and_back else Quantity(value=0.0, unit="1", standard_uncertainty=0.0)
    return BodyWear(pair.disc.name, "manifest", depth, combined(volume, (area, path.length, ends), "m^3"))


def disc_notes(
    run: RawRun, end: EndValues, ways: Sequence[BodyWear], pin_depth: Quantity | None = None
) -> Iterator[str]:
    """Report why the disc's depth or volume is missing, and what they assume.

    ``pin_depth`` is that of a pin that was not measured, m, by a depth signal.
    """
    conditions, best = run.manifest.conditions, surest(ways, "volume")
    if ways and best is None:
        lacking = conditions.track_radius is None and conditions.stroke is None
        yield (
            "track_radius or stroke is missing, so the wear volume of the disc is not calculated"
            if lacking
            else "the wear volume of the disc cannot be determined from the depth or width of the wear track alone"
        )
    widens = run.manifest.described.sliding_tip.widens
    if any(way.hides_groove for way in ways) and surest(ways, "depth") is None and widens:
        yield (
            "track_radius or stroke is missing, so the depth of the wear track is not calculated; wear depth and "
            "volume of the pin are those on an unworn disc, unless they were measured directly"
        )
    if best is not None and "volume" in best.assumed and best.pair is not None:
        yield from _assumed(best.pair, pin_depth)
    if best is not None and conditions.stroke is not None and best.name not in VOLUMES:
        yield f"{best.name} is assumed to have been measured at mid-stroke"
    for way in ways:
        if way.name in WIDTHS and way.depth is None and widens:
            yield f"{way.name} does not exceed the scar on the pin, so the depth of the wear track cannot be calculated"
    if 0 < len(end.disc_profile) < FEWEST_PLACES:
        yield (
            f"the wear track was measured at {len(end.disc_profile)} of the {FEWEST_PLACES} recommended positions: its "
            "variation along the track is largely unknown"
        )


def _assumed(pair: Pair, pin_depth: Quantity | None) -> Iterator[str]:
    """Report what the volume of a track follows from."""
    if pair.pin is UNKNOWN_SHARE:
        yield (
            f"the wear of the pin is unknown: {pair.disc.name} alone gives only a rough wear volume of the disc; "
            "measure "
            'the pin, or both depth and width of the track, or state pin_wear_depth = "0 um" if the pin has not worn'
        )
    else:
        pin = "the depth signal" if pair.pin.quantity is pin_depth else pair.pin.name
        disc = "the depth signal" if pair.disc.name == BY_SIGNAL else pair.disc.name
        yield f"wear volume of the disc calculated from {disc}, {pin} and the shape of the groove"

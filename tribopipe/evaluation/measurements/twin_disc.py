"""Measurements on both discs of a twin-disc test, at its end and at interruptions."""

import math
import re
from collections.abc import Iterator
from typing import get_args

import numpy as np

from tribopipe.contacts.twin_disc import nominal_pair
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.manifest import EndValues
from tribopipe.documents.quantity import EndValue, Quantity
from tribopipe.documents.recipe import DefaultUncertainty, Recipe
from tribopipe.documents.twin_disc import DISCS, DiscName, TwinDisc
from tribopipe.evaluation.measurements.body_wear import BodyMeasurement, BodyWear, MeasuredQuantity, WornBodies, surest
from tribopipe.evaluation.measurements.end_wear import TotalLimit, TotalWear
from tribopipe.evaluation.measurements.readings import (
    certain,
    known_density,
    over_places,
    profiles_at,
    tracks_in,
    volume_of_mass,
)
from tribopipe.physics.twin_disc import DiscPair
from tribopipe.results.input_quantities import Source, stated_or_default
from tribopipe.results.run import RawRun


def disc_measurements(run: RawRun, defaults: DefaultUncertainty) -> tuple[BodyMeasurement, ...]:
    """Return everything measured on the discs of a run, in the order of the test, the end last."""
    found: list[BodyMeasurement] = []
    for number, stop in enumerate(run.manifest.interruptions):
        found += _measured(run, stop, stop.place, defaults, number)
    end = float(np.nanmax(run.columns["rotations"]))
    return (*found, *_measured(run, run.manifest.end_values, end, defaults, None))


def _measured(
    run: RawRun, values: EndValues, rotations: float, defaults: DefaultUncertainty, number: int | None
) -> Iterator[BodyMeasurement]:
    for disc in DISCS:
        for what in get_args(MeasuredQuantity):
            stated, by = getattr(values, f"{disc}_{what}"), ""
            if stated is None and what == "wear_volume":
                stated, by = _profiled_volume(run, disc, defaults, number), "profile"
            if stated is None and what == "wear_volume":
                stated, by = _weighed_volume(run, disc, values, defaults), "mass_loss"
            if stated is not None:
                yield BodyMeasurement(disc, what, rotations, *_certain(stated, what, defaults), number, by)


def _certain(stated: Quantity, what: MeasuredQuantity, defaults: DefaultUncertainty) -> tuple[Quantity, Source]:
    spread = {
        "wear_volume": defaults.wear_volume * abs(stated.value),
        "wear_depth": defaults.wear_depth.value,
        "track_width": defaults.track_width.value,
    }[what]
    plain = Quantity(value=stated.value, unit=stated.unit, standard_uncertainty=stated.standard_uncertainty)
    return stated_or_default(plain, spread)


def _profiled_volume(run: RawRun, disc: DiscName, defaults: DefaultUncertainty, number: int | None) -> EndValue | None:
    """Return the volume by profiles across the track, 2π·r times the mean area it has lost, m³; none without one.

    Its uncertainty is that of the profile and of the crown radius that the unworn surface is drawn with.
    """
    where = "end_values" if number is None else f"interruptions[{number}]"
    discs = TwinDisc.of(run.manifest.described, run.id)
    crown = discs.curved_disc.crown_radius if disc == "curved_disc" else None
    body = discs.flat_disc if crown is None else discs.curved_disc
    found = tracks_in(run, profiles_at(run, f"{where}.{disc}_profile"), None if crown is None else crown.value)
    if not found:
        return None
    area, off = over_places([track.area for track in found]), 0.0
    if crown is not None:
        known, _ = stated_or_default(crown, defaults.crown_radius * crown.value)
        off = sum(track.area_per_crown_radius for track in found) / len(found) * known.u_or_zero
    around = 2 * math.pi * body.rolling_radius.value
    spread = around * math.hypot(area.u_or_zero, off)
    return EndValue(value=around * area.value, unit="m^3", standard_uncertainty=spread, method="profile")


def _weighed_volume(run: RawRun, disc: DiscName, values: EndValues, defaults: DefaultUncertainty) -> EndValue | None:
    """Return the volume of the mass that a disc has lost, m³; None if it was not weighed.

    Raises ``FitError`` where run.toml does not state the density.
    """
    mass: EndValue | None = getattr(values, f"{disc}_mass_loss")
    if mass is None:
        return None
    density = known_density(run, disc, f"{disc}_mass_loss", defaults)
    volume = volume_of_mass(certain(mass, defaults.mass_loss.value)[0], density)
    return EndValue(**volume.model_dump(), method="mass loss")


def twin_disc_wear(run: RawRun, defaults: DefaultUncertainty, interruption: int | None) -> WornBodies:
    """Return depths and volumes of both discs as they were measured: of a width alone no disc's own part follows."""
    worn: dict[str, tuple[BodyWear, ...]] = dict.fromkeys(DISCS, ())
    for one in disc_measurements(run, defaults):
        if one.interruption == interruption:
            depth = one.quantity if one.what == "wear_depth" else None
            volume = one.quantity if one.what == "wear_volume" else None
            worn[one.body] = (*worn[one.body], BodyWear(f"{one.body}_{one.by or one.what}", one.source, depth, volume))
    notes = (
        f"no wear volume of the {spoken(name)} was measured"
        for name, ways in worn.items()
        if ways and surest(ways, "volume") is None
    )
    return WornBodies(worn, tuple(notes))


def disc_end_wear(run: RawRun, recipe: Recipe) -> TotalWear | None:
    """Return the wear of both discs at the end of a run, by the most certain of what was measured; none without any.

    A disc on which nothing was measured counts as unworn, but for the crowned one.
    """
    found = [one for one in disc_totals(run, recipe) if re.match("curved_disc|.*track_width", one.names[0])]
    return min(found, key=lambda wear: wear.total.u_or_zero, default=None)


def disc_totals(run: RawRun, recipe: Recipe) -> list[TotalWear]:
    """Return the wear of both discs at the end of a run by each kind of measurement that all measured discs have.

    Depths add up. Volumes give the cross-section lost by both, and a track its width, of which the depth follows by the
    geometry of the worn flat (tribopipe.physics.twin_disc).
    """
    everything = disc_measurements(run, recipe.uncertainty)
    ends = {one.name: one for one in everything if one.interruption is None}
    measured_on = {one.body for one in everything}
    groups = [[one] for one in ends.values() if one.what == "track_width"]
    for what in ("wear_depth", "wear_volume"):
        names = [f"{disc}_{what}" for disc in DISCS if disc in measured_on]
        if names and all(name in ends for name in names):
            groups.append([ends[name] for name in names])
    discs = nominal_pair(run.manifest, recipe.wear.distance_per_rotation)
    return [_total(group, discs, TwinDisc.of(run.manifest.described, run.id)) for group in groups]


def widest_contact(run: RawRun) -> TotalLimit | None:
    """Return the wear at which the flat between two discs is as wide as the narrower one; None without their widths."""
    discs = TwinDisc.of(run.manifest.described, run.id)
    width = min((one.width.value for one in (discs.curved_disc, discs.flat_disc) if one.width), default=math.inf)
    if not width < 2 * discs.curved_disc.crown_radius.value:
        return None
    pair = nominal_pair(run.manifest, Recipe().wear.distance_per_rotation)
    return TotalLimit(width, float(pair.depth_of_width(np.array(width))))


def _total(measured: list[BodyMeasurement], discs: DiscPair, contact: TwinDisc) -> TotalWear:
    """Return h₁ + h₂ by measurements of one kind; its uncertainty is theirs, by first-order propagation."""
    around = {
        "curved_disc": 2 * math.pi * contact.curved_disc.rolling_radius.value,
        "flat_disc": 2 * math.pi * contact.flat_disc.rolling_radius.value,
    }
    scales = [1 / around[one.body] if one.what == "wear_volume" else 1.0 for one in measured]
    value = sum(one.quantity.value * scale for one, scale in zip(measured, scales, strict=True))
    spread = math.hypot(*(one.quantity.u_or_zero * scale for one, scale in zip(measured, scales, strict=True)))
    turned = {"wear_depth": lambda x: x, "wear_volume": discs.depth_of_area, "track_width": discs.depth_of_width}[
        measured[0].what
    ]
    low, middle, high = (float(turned(max(0.0, value + step))) for step in (-spread, 0.0, spread))
    total = Quantity(value=middle, unit="m", standard_uncertainty=(high - low) / 2)
    return TotalWear(total, tuple(one.name for one in measured))

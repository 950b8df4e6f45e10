"""The specific wear rate k = V/(F_N·s) of each body: overall, between measurements, and after running-in.

V is the volume by the most certain post-test measurement, s the sliding distance, F_N the normal load: its mean over
that distance where it was recorded, else as run.toml states it.

Of an interrupted test each measurement gives the volume V lost until then, so that V against the load path W = ∫F_N ds
is a curve whose slope is the specific wear rate. After running-in it is straight: its slope there is found by weighted
least squares with a free intercept. Where running-in ends is decided by the Bayesian information criterion (G.
Schwarz, Annals of Statistics 6 (1978) 461) among all measurements that leave three for the line, and averaged over
them with the weights it gives. What all measurements share, such as the density, the radius of the tip and the load,
scales the slope and is no scatter.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.documents.contact import SLIDING
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.quantity import Quantity, scaled
from tribopipe.documents.recipe import DefaultUncertainty, Recipe
from tribopipe.evaluation.load_and_friction import contact_load, load_path, load_share
from tribopipe.evaluation.measurements.body_wear import BodyWear, surest
from tribopipe.evaluation.measurements.kinds import measurements_of, worn_bodies
from tribopipe.evaluation.measurements.readings import SignalDepths, combined
from tribopipe.evaluation.measurements.sliding_distance import distance_share
from tribopipe.results.finding import reworded
from tribopipe.results.input_quantities import stated_or_default
from tribopipe.results.run import RawRun
from tribopipe.results.specific_wear import BodyWearRate, MeasuredWear, SpecificWear, WearInterval

CLEARLY = 3.0
"""Standard uncertainties of their difference by which overall and steady rate must at least differ for a report."""
_FEWEST = 4
"""Measurements from which a steady rate follows."""
_ON_THE_LINE = 3
"""Measurements that are left at least for the steady rate."""


class _Lost(NamedTuple):
    """The volume, m³, lost until a sliding distance, m, uncertain by its own measurement alone."""

    distance: float
    volume: float
    own: float
    common: float
    """Relative uncertainty by what all measurements share: density, radius, path."""


class _Line(NamedTuple):
    """The straight line after running-in: its slope, m²/N, with its standard uncertainty by scatter alone."""

    slope: float
    spread: float
    first: int
    """Number of the measurement at which running-in is over; 0 is the start of the test."""


def interval_wear(run: RawRun, recipe: Recipe, body: str) -> dict[str, Any]:
    """Return intervals and steady rate of a body, as fields of ``BodyWearRate``; nothing of a test in one piece."""
    lost = _measured(run, recipe.uncertainty, body) if run.manifest.interruptions else []
    if len(lost) <= 1:
        return {}
    points = [_Lost(0.0, 0.0, 0.0, 0.0), *lost]
    path = load_path(run, np.array([point.distance for point in points]))
    path = run.manifest.described.contacts_of(body) * path
    # What was slid without load has worn nothing, and has no rate.
    under_load = np.append(True, np.diff(path) > 0)
    points, path = [point for point, kept in zip(points, under_load, strict=True) if kept], path[under_load]
    if len(points) == 1:
        return {}
    shares = (load_share(run, recipe.uncertainty), distance_share(run, recipe.uncertainty) or 0.0)
    common = math.hypot(lost[-1].common, *shares)
    found: dict[str, Any] = {"intervals": tuple(_intervals(points, path, common))}
    line = _steady(points, path) if len(points) > _FEWEST else None
    if line is None:
        return found
    mean = lost[-1].volume / path[-1]
    apart = math.hypot(line.spread, lost[-1].own / path[-1])
    return found | {
        "steady_rate": _interval_rate(line.slope, line.spread, common),
        "steady_from": Quantity(value=points[line.first].distance, unit="m"),
        "steady_deviation": (mean - line.slope) / apart if apart else None,
    }


def _measured(run: RawRun, defaults: DefaultUncertainty, body: str) -> list[_Lost]:
    """Return what the body had lost at each interruption and at the end, by the way that gives it most often."""
    stops = range(len(run.manifest.interruptions))
    slid = [_distance_at(run, stop) for stop in stops] + [float(np.nanmax(run.sliding_distance))]
    whole = [_volumes(run, defaults, body, stop) for stop in (*stops, None)]
    exact = with_exact_dimensions(run), without_unseen_groove(defaults)
    known = [_volumes(*exact, body, stop) for stop in (*stops, None)]
    names = [name for volumes in whole for name in volumes]
    if not names:
        return []
    way = max(names, key=names.count)
    found = [
        _lost(distance, one[way], other[way])
        for distance, one, other in zip(slid, whole, known, strict=True)
        if way in one
    ]
    return [
        point
        for point, before in zip(found, (0.0, *(one.distance for one in found)), strict=False)
        if point.distance > before
    ]


def _lost(distance: float, whole: Quantity, known: Quantity) -> _Lost:
    """Part the uncertainty of a volume into that of its own measurement and the relative one of what all share."""
    spread, own = whole.u_or_zero, known.u_or_zero
    common = math.sqrt(max(0.0, spread**2 - own**2)) / whole.value if whole.value > 0 else 0.0
    return _Lost(distance, whole.value, own, common)


def _distance_at(run: RawRun, stop: int) -> float:
    """Return the sliding distance at an interruption, m; of two discs by the rotations until then."""
    place = run.manifest.interruptions[stop].place
    slides = run.manifest.progress is SLIDING
    return place if slides else float(np.interp(place, run.progress, run.sliding_distance))


def _volumes(run: RawRun, defaults: DefaultUncertainty, body: str, stop: int | None) -> dict[str, Quantity]:
    """Return the volume of a body by each way of measuring at an interruption, or at the end."""
    ways = worn_bodies(run, defaults, stop).bodies[body]
    return {way.name: way.volume for way in ways if way.volume is not None}


def with_exact_dimensions(run: RawRun) -> RawRun:
    """Return a run whose density, radius and path are known exactly: they are the same in all measurements."""
    return replace(run, manifest=_exact(run.manifest))


def without_unseen_groove(defaults: DefaultUncertainty) -> DefaultUncertainty:
    """Return the defaults of a disc without a groove: one that nobody measured is there in all measurements."""
    return defaults.model_copy(update={"unseen_groove": 0.0})


def _exact(manifest: RunManifest) -> RunManifest:
    contact, conditions = manifest.contact, manifest.conditions
    if contact is None:
        return manifest
    bodies = {
        name: body.model_copy(update=_exactly(body, "density", "radius", "diameter", "crown_radius", "rolling_radius"))
        for name, body in contact.bodies.items()
    }
    paths = conditions.model_copy(update=_exactly(conditions, "track_radius", "stroke"))
    return manifest.model_copy(update={"contact": contact.model_copy(update=bodies), "conditions": paths})


def _exactly(record: Any, *names: str) -> dict[str, Quantity]:
    stated = {name: getattr(record, name, None) for name in names}
    return {
        name: one.model_copy(update={"standard_uncertainty": 0.0}) for name, one in stated.items() if one is not None
    }


def _intervals(points: Sequence[_Lost], path: Column, common: float) -> Iterator[WearInterval]:
    for (before, after), slid in zip(pairwise(points), np.diff(path).tolist(), strict=True):
        volume, own = after.volume - before.volume, math.hypot(before.own, after.own)
        yield WearInterval(
            start=Quantity(value=before.distance, unit="m"),
            end=Quantity(value=after.distance, unit="m"),
            volume=Quantity(value=volume, unit="m^3", standard_uncertainty=own),
            specific_wear_rate=_interval_rate(volume / slid, own / slid, common),
        )


def _interval_rate(value: float, own: float, common: float) -> Quantity:
    return Quantity(value=value, unit="m^2/N", standard_uncertainty=math.hypot(own, common * value))


def _steady(points: Sequence[_Lost], path: Column) -> _Line | None:
    """Return the slope after running-in; None if the measurements state no uncertainty and do not scatter."""
    volume, own = np.array([point.volume for point in points]), np.array([point.own for point in points])
    own[0] = own[1]  # before the test it was measured in the same way
    if not np.all(own > 0):
        return None
    own = own * _scatter(path, volume, own)
    candidates = range(len(points) - _ON_THE_LINE + 1)
    lines = [_line(path[first:], volume[first:], own[first:]) for first in candidates]
    # Each measurement before the line is met by a parameter of its own.
    criteria = np.array([misfit + first * math.log(len(points)) for first, (_, _, misfit) in enumerate(lines)])
    weights = np.exp(-(criteria - np.min(criteria)) / 2)
    weights /= np.sum(weights)
    slopes, variances = (np.array([line[place] for line in lines]) for place in (0, 1))
    slope = float(weights @ slopes)
    spread = math.sqrt(float(weights @ (variances + (slopes - slope) ** 2)))
    return _Line(slope, spread, int(np.argmax(weights)))


def _line(path: Column, volume: Column, own: Column) -> tuple[float, float, float]:
    """Return slope, its variance and χ² of a weighted straight line."""
    weights = 1 / own**2
    middle = float(weights @ path / np.sum(weights))
    lever = float(weights @ (path - middle) ** 2)
    level = float(weights @ volume / np.sum(weights))
    slope = float(weights @ ((path - middle) * volume)) / lever
    misfit = float(weights @ (volume - level - slope * (path - middle)) ** 2)
    return slope, 1 / lever, misfit


def _scatter(path: Column, volume: Column, own: Column) -> float:
    """Return by how much the later measurements scatter more than they are uncertain by, at least 1.

    About the straight line between their neighbors, so that running-in is not taken for scatter.
    """
    share = (path[1:-1] - path[:-2]) / (path[2:] - path[:-2])
    about = volume[1:-1] - (1 - share) * volume[:-2] - share * volume[2:]
    spread = np.sqrt(own[1:-1] ** 2 + ((1 - share) * own[:-2]) ** 2 + (share * own[2:]) ** 2)
    later = (about / spread)[len(about) // 2 :]
    return max(1.0, math.sqrt(float(np.mean(later**2))))


def specific_wear(run: RawRun, recipe: Recipe | None = None, signal: SignalDepths | None = None) -> SpecificWear:
    """Return wear volume, depth and specific wear rate of each body at the end of a run.

    ``signal`` is what only the depth signal shows: a pin next to a measured groove, or a groove next to a measured pin.

    A run without bodies, without post-test measurements or without a volume passes through, and the result states what
    is missing.

    Raises ``FitError`` for a mass without density, and for profiles of which nothing can be taken.
    """
    recipe = recipe or Recipe()
    defaults = recipe.uncertainty
    contact = run.manifest.contact
    if contact is None:
        return SpecificWear(outcome="not evaluated", notes=("the bodies are not described in run.toml",))
    worn, notes = measurements_of(contact).worn(run, defaults, None, signal or SignalDepths())
    distance = _distance(run, defaults)
    if distance is None:
        return SpecificWear(outcome="not evaluated", notes=(*notes, "no sliding distance"))
    load = _load(run, recipe)
    rates = {name: _rate(ways, scaled(load, contact.contacts_of(name)), distance) for name, ways in worn.items()}
    rates = {name: rate.model_copy(update=interval_wear(run, recipe, name)) for name, rate in rates.items()}
    volumes = [
        scaled(rate.volume, 1 / contact.contacts_of(name)) for name, rate in rates.items() if rate.volume is not None
    ]
    lacking = [f"no wear measurement of the {spoken(name)}" for name, rate in rates.items() if not rate.measured]
    found = SpecificWear(
        outcome="evaluated" if volumes else "not evaluated",
        notes=(*lacking, *notes, *_running_in(rates)),
        sliding_distance=distance,
        normal_load=load,
        load="nominal" if run.recorded_load is None else "measured",
        total=_together(volumes, load, distance) if len(volumes) == len(rates) else None,
        **rates,
    )
    return reworded(found, contact.worded)


def _distance(run: RawRun, defaults: DefaultUncertainty) -> Quantity | None:
    """Return the sliding distance, m, uncertain by the speed, radius or slip it was derived from; none without any."""
    slid = run.columns.get("sliding_distance")
    if slid is None or not np.any(np.isfinite(slid)) or not np.nanmax(slid) > 0:
        return None
    distance, share = float(np.nanmax(slid)), distance_share(run, defaults)
    return Quantity(value=distance, unit="m", standard_uncertainty=None if share is None else share * distance)


def _load(run: RawRun, recipe: Recipe) -> Quantity:
    """Return the load on one contact over the distance, N, with its standard uncertainty, stated or by default."""
    load = contact_load(run, recipe)
    known, _ = stated_or_default(load, recipe.uncertainty.normal_load * load.value)
    return known


def _rate(ways: Iterable[BodyWear], load: Quantity, distance: Quantity) -> BodyWearRate:
    """Return wear and specific wear rate of a body by the most certain of what was measured on it."""
    ways = tuple(ways)
    deep, lost = surest(ways, "depth"), surest(ways, "volume")
    volume = None if lost is None else lost.volume
    return BodyWearRate(
        depth=None if deep is None else deep.depth,
        depth_by=None if deep is None else deep.name,
        volume=volume,
        volume_by=None if lost is None else lost.name,
        specific_wear_rate=None if volume is None else _together([volume], load, distance),
        measured=tuple(MeasuredWear(by=way.name, depth=way.depth, volume=way.volume) for way in ways),
    )


def _running_in(rates: Mapping[str, BodyWearRate]) -> Iterator[str]:
    """Name the bodies whose overall rate is not that after running-in."""
    for name, rate in rates.items():
        overall, steady = rate.specific_wear_rate, rate.steady_rate
        if overall is not None and steady is not None and abs(rate.steady_deviation or 0.0) > CLEARLY:
            certain = abs(steady.value) > CLEARLY * steady.u_or_zero
            times = f"{overall.value / steady.value:.2g} times" if certain else "clearly different from"
            about = "" if certain else ", which is zero within its uncertainty"
            why = "because of running-in" if overall.value > steady.value else "because the rate has increased"
            yield f"the overall wear rate of the {spoken(name)} is {times} its steady-state rate{about}, {why}"


def _together(volumes: Iterable[Quantity], load: Quantity, distance: Quantity) -> Quantity:
    """Return ΣV/(F_N·s), m²/N; load and distance are the same for all volumes."""

    def rate(force: float, slid: float, *lost: float) -> float:
        return math.fsum(lost) / (force * slid)

    return combined(rate, (load, distance, *volumes), "m^2/N")

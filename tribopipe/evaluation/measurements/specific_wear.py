"""The specific wear rate k = V/(F_N·s) of each body of a run, mm³/(N·m), from its post-test measurements.

V is the volume by the most certain post-test measurement, s the sliding distance, F_N the normal load: its mean over
that distance where it was recorded, else as run.toml states it.
"""

import math
from collections.abc import Iterable, Iterator, Mapping

import numpy as np

from tribopipe.contacts.inputs import stated_or_default
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.quantity import Quantity, scaled
from tribopipe.documents.recipe import DefaultUncertainty, Recipe
from tribopipe.evaluation.applied_load import contact_load, recorded_load
from tribopipe.evaluation.combined_quantity import combined
from tribopipe.evaluation.measurements.body_wear import BodyWear, surest
from tribopipe.evaluation.measurements.disc_track import told_by
from tribopipe.evaluation.measurements.interval_wear import CLEARLY, interval_wear
from tribopipe.evaluation.measurements.kinds import measurements_of
from tribopipe.results.run import RawRun
from tribopipe.results.specific_wear import BodyWearRate, MeasuredWear, SpecificWear
from tribopipe.results.wording import reworded


def specific_wear(run: RawRun, recipe: Recipe | None = None) -> SpecificWear:
    """Return wear volume, depth and specific wear rate of each body at the end of a run.

    A run without bodies, without post-test measurements or without a volume passes through, and the result states what
    is missing.

    Raises ``FitError`` for a mass without density, and for profiles of which nothing can be taken.
    """
    recipe = recipe or Recipe()
    defaults = recipe.uncertainty
    contact = run.manifest.contact
    if contact is None:
        return SpecificWear(outcome="not evaluated", notes=("the bodies are not described in run.toml",))
    worn, notes = measurements_of(contact).worn(run, defaults, None)
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
        load="nominal" if recorded_load(run) is None else "measured",
        total=_together(volumes, load, distance) if len(volumes) == len(rates) else None,
        **rates,
    )
    return reworded(found, contact.worded)


def _distance(run: RawRun, defaults: DefaultUncertainty) -> Quantity | None:
    """Return the sliding distance, m, uncertain by the speed or radius it was derived from; none without any."""
    slid = run.columns.get("sliding_distance")
    if slid is None or not np.any(np.isfinite(slid)) or not np.nanmax(slid) > 0:
        return None
    distance, told = float(np.nanmax(slid)), told_by(run, defaults)
    spread = None if told is None else distance * (told.quantity.standard_uncertainty or 0.0) / told.quantity.value
    return Quantity(value=distance, unit="m", standard_uncertainty=spread)


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
            times = overall.value / steady.value
            yield f"the overall rate of the {spoken(name)} is {times:.2g} times its steady rate: running-in"


def _together(volumes: Iterable[Quantity], load: Quantity, distance: Quantity) -> Quantity:
    """Return ΣV/(F_N·s), m²/N; load and distance are the same for all volumes."""

    def rate(force: float, slid: float, *lost: float) -> float:
        return math.fsum(lost) / (force * slid)

    return combined(rate, (load, distance, *volumes), "m^2/N")

"""Checks of what run.toml states: magnitudes that cannot be right, statements that contradict each other."""

from collections.abc import Iterator
from datetime import UTC, datetime
from typing import Any, NamedTuple, get_args

import numpy as np

import tribopipe.evaluation.checks.plausibility
import tribopipe.evaluation.checks.restarts
import tribopipe.evaluation.checks.runout
import tribopipe.evaluation.checks.scars  # noqa: F401 - all register further checks
from tribopipe.documents.manifest import Conditions, EndValues, RunManifest
from tribopipe.documents.quantity import Quantity
from tribopipe.evaluation.checks.material_ranges import DENSEST_SOLID, LIGHTEST_SOLID
from tribopipe.evaluation.checks.registry import Trouble, check
from tribopipe.evaluation.measurements.readings import PinWay
from tribopipe.results.run import AT_A_LEVER, OF_ANOTHER_KIND, READ_IN, RawRun


def _bodies(run: RawRun) -> Iterator[tuple[str, Quantity | None, Quantity]]:
    for name, body in run.manifest.bodies.items():
        yield f"contact.{name}", body.density, body.youngs_modulus


@check("error")
def implausible_density(run: RawRun) -> Iterator[Trouble]:
    """Catch g/cm³ written as kg/m³, as in the paper's Table 1, and the reverse."""
    for where, density, _ in _bodies(run):
        if density is None or LIGHTEST_SOLID <= density.value <= DENSEST_SOLID:
            continue
        meant = density.value * 1000 if density.value < LIGHTEST_SOLID else density.value / 1000
        as_meant = Quantity(value=meant, unit=density.unit).shown("g/cm^3")
        yield Trouble(
            f"{where}.density",
            f"found {density.shown('kg/m^3')}; expected the density of a solid, 30 to 23,000 kg/m³",
            f"did you mean {as_meant}?",
        )


@check("warning")
def implausible_modulus(run: RawRun) -> Iterator[Trouble]:
    """Catch MPa written as GPa and the like: rubber has 1e6 Pa, diamond 1.2e12 Pa."""
    for where, _, modulus in _bodies(run):
        if not 1e6 <= modulus.value <= 1.3e12:
            yield Trouble(
                f"{where}.youngs_modulus", f"found {modulus.shown('GPa')}; expected 0.001 to 1300 GPa", "check its unit"
            )


class _Size(NamedTuple):
    """A quantity of run.toml, within which bounds it may be, SI, and the unit to show it in."""

    where: str
    quantity: Quantity | None
    low: float
    high: float
    unit: str


@check("warning")
def implausible_conditions(run: RawRun) -> Iterator[Trouble]:
    """Catch a wrong unit in radii, load, speeds, slip, distance, time and mass losses."""
    manifest = run.manifest
    load = _Size("conditions.normal_load", manifest.conditions.normal_load, 1e-6, 1e5, "N")
    for size in (*_sizes(manifest), load):
        if size.quantity is not None and not size.low <= size.quantity.value <= size.high:
            found = size.quantity.shown(size.unit)
            expected = " to ".join(
                Quantity(value=end, unit=size.quantity.unit).shown(size.unit) for end in (size.low, size.high)
            )
            yield Trouble(size.where, f"found {found}; expected {expected}", "check its unit")
    yield from _odd_frequency(manifest.conditions)
    yield from _odd_slip(manifest)
    yield from _odd_duration(run)
    yield from _odd_mass(manifest)


_RADII = {"radius": (1e-6, 0.5), "crown_radius": (1e-5, 10.0), "rolling_radius": (1e-4, 2.0)}
"""Bounds, m, of the radii that bodies may have."""


def _sizes(manifest: RunManifest) -> Iterator[_Size]:
    conditions = manifest.conditions
    for name, body in manifest.bodies.items():
        for radius, (low, high) in _RADII.items():
            yield _Size(f"contact.{name}.{radius}", getattr(body, radius, None), low, high, "mm")
    yield _Size("conditions.sliding_speed", conditions.nominal_speed, 1e-9, 200.0, "m/s")
    yield _Size("conditions.sliding_distance", conditions.sliding_distance, 1e-6, 1e8, "m")
    yield _Size("conditions.curved_disc_speed", conditions.curved_disc_speed, 1e-9, 200.0, "m/s")
    yield _Size("conditions.flat_disc_speed", conditions.flat_disc_speed, 1e-9, 200.0, "m/s")
    yield _Size(_slip_key(manifest), _slip_share(manifest), 1e-5, 10.0, "%")


_MOST_TURNS, _MOST_CYCLES = 10_000 / 60, 1000.0
"""Frequencies, 1/s, of rotation and of strokes beyond which a unit is wrong, rather than the tribometer fast."""


def _odd_frequency(conditions: Conditions) -> Iterator[Trouble]:
    """Catch m/s for mm/s, rad/s for rpm, and mm for m of stroke or track radius."""
    speed, cycle = conditions.nominal_speed, conditions.cycle
    if speed is None or cycle is None:
        return
    what, most = ("stroke", _MOST_CYCLES) if conditions.stroke is not None else ("track radius", _MOST_TURNS)
    if speed.value > most * cycle:
        where = next(name for name in ("sliding_speed", "rotational_speed", "frequency") if getattr(conditions, name))
        yield Trouble(
            f"conditions.{where}",
            f"found a frequency of {speed.value / cycle:.4g} Hz at {speed.shown('m/s')}; expected at most "
            f"{most:.4g} Hz",
            f"check the units of {where} and of {what}",
        )


_LONGEST_TEST = 30.0
"""Longest duration of a test, days; milliseconds that are read as seconds exceed it after 43 minutes."""


def _odd_duration(run: RawRun) -> Iterator[Trouble]:
    """Catch time in ms that is read as s."""
    time = run.columns.get("time")
    days = 0.0 if time is None or not np.any(np.isfinite(time)) else float(np.nanmax(time) - np.nanmin(time)) / 86400
    if days > _LONGEST_TEST:
        yield Trouble(
            "time", f"found a test of {days:.0f} days; expected at most {_LONGEST_TEST:.0f} days", "check its unit"
        )


_LEAST_MASS = 1e-9
"""Smallest mass loss that a balance can show, kg."""


def _odd_mass(manifest: RunManifest) -> Iterator[Trouble]:
    """Catch a mass loss in µg or ng that was meant in mg."""
    for name, lost in manifest.end_values:
        if not name.endswith("_mass_loss") or lost is None:
            continue
        if 0 < abs(lost.value) + 3 * lost.u_or_zero < _LEAST_MASS:
            yield Trouble(
                f"end_values.{name}",
                f"found {lost.shown('mg')}; expected at least {_LEAST_MASS * 1e6:g} mg, the resolution of a balance",
                "check its unit",
            )


def _slip_key(manifest: RunManifest) -> str:
    return "conditions.flat_disc_speed" if manifest.conditions.slip is None else "conditions.slip"


def _slip_share(manifest: RunManifest) -> Quantity | None:
    slip = manifest.slip
    return None if slip is None else Quantity(value=abs(slip.value), unit="1")


def _odd_slip(manifest: RunManifest) -> Iterator[Trouble]:
    """Note a slip that may be meant but is seldom run: 4 for 4 %, or 0.0004."""
    share = _slip_share(manifest)
    if share is not None and (1e-5 <= share.value < 1e-3 or 1 < share.value <= 10):
        yield Trouble(
            _slip_key(manifest),
            f"found a slip of {share.shown('%')}; expected 0.1 to 100 %, as in most tests",
            'write four percent as "4 %" or 0.04, and check both speeds',
        )


@check("warning")
def future_start(run: RawRun) -> Iterator[Trouble]:
    """Catch a wrong clock or a mistyped year."""
    started = run.manifest.started
    if started is None:
        return
    now = datetime.now(UTC) if started.tzinfo else datetime.now(UTC).replace(tzinfo=None)
    if started > now:
        yield Trouble(
            "started",
            f"found {started.isoformat()}, a date in the future; expected the start of the test",
            "check the year",
        )


@check("note")
def missing_input(run: RawRun) -> Iterator[Trouble]:
    """Report early what is missing for a wear coefficient."""
    if run.manifest.contact is None:
        yield Trouble(
            "contact",
            "found no [contact]; expected a description of both bodies, from which the wear coefficient is calculated",
            "describe both bodies, unless only friction is of interest",
        )
        return
    yield from _needed_of_a_pin(run) if run.manifest.contact.sensor_tells else _needed_of_discs(run)


def _needed_of_a_pin(run: RawRun) -> Iterator[Trouble]:
    end = run.manifest.end_values
    if all(getattr(end, name) in (None, ()) for name in get_args(PinWay)):
        yield Trouble(
            "end_values",
            "found no wear measurement of the pin; expected a scar, wear depth, wear volume, mass loss or profile; "
            "without a measurement, the wear coefficient is determined from the depth sensor alone",
            "add the measurement if there is one",
        )
    if "depth" not in run.columns:
        yield Trouble(
            "signals",
            "found no depth signal; expected a depth signal, from which the wear coefficient is determined",
            "map its column if it was recorded",
        )


def _needed_of_discs(run: RawRun) -> Iterator[Trouble]:
    """Name what is missing of each disc."""
    parts = (run.manifest.end_values, *run.manifest.interruptions)
    measured = {name for part in parts for name in type(part).model_fields if getattr(part, name) not in (None, ())}
    if not any(name.startswith("curved_disc_") for name in measured):
        yield Trouble(
            "end_values",
            "found no wear measurement of the crowned disc; expected its depth, track width, volume or profile, "
            "from which the wear coefficient is determined",
            "add the measurement if there is one",
        )
    elif not any(name.startswith("flat_disc_") for name in measured):
        yield Trouble(
            "end_values",
            "found no wear measurement of the cylindrical disc; expected its depth, track width, volume or profile; "
            "otherwise, the disc is assumed to be unworn, as in the one-sided model",
            "add its depth, track width, volume or profile if it has worn",
        )


@check("note")
def reader_assumption(run: RawRun) -> Iterator[Trouble]:
    """Pass on what a reader had to guess or change."""
    for note in run.notes:
        if AT_A_LEVER not in note and READ_IN not in note:
            yield Trouble(
                "signals",
                f"found an assumption made when reading the file: {note}; expected an unambiguous file",
                "check the assumption; run.toml can specify how to read the file",
            )


@check("warning")
def friction_lever(run: RawRun) -> Iterator[Trouble]:
    """Find a friction force where several contacts share the load, so that it depends on the lever of the load cell."""
    for note in run.notes:
        if AT_A_LEVER in note:
            yield Trouble(
                "signals",
                f"found a force with an unknown lever arm: {note}; expected the friction torque",
                'state its lever arm, friction_force = { column = …, arm = "150 mm" }, or map the torque',
            )


@check("warning")
def units_disagree(run: RawRun) -> Iterator[Trouble]:
    """Find a column that is read in another unit than the file states for it."""
    for note in run.notes:
        if READ_IN in note:
            yield Trouble(
                "signals",
                f"found two units for a signal: {note}; expected the unit of the file",
                "map another column, or convert this one in a reader description, unless the file states a wrong unit"
                if OF_ANOTHER_KIND in note
                else "remove the stated unit, unless the file states a wrong one",
            )


@check("warning")
def unused_signal(run: RawRun) -> Iterator[Trouble]:
    """Name columns that seem to be signals and are not used."""
    for why in run.unused:
        yield Trouble(
            "signals",
            f"found that {why}; expected each recorded signal to be used",
            "map it under [signals.columns] in run.toml, with its unit",
        )


@check("warning")
def worn_before(run: RawRun) -> Iterator[Trouble]:
    """Find a step before which earlier ones of the file may have worn the same specimens.

    A pin described with the flat that it has by then is none of these.
    """
    contact = run.manifest.contact
    if contact is None or not run.earlier_steps or (contact.tip is not None and contact.tip.flat_radius is not None):
        return
    first, last = run.earlier_steps[0], run.earlier_steps[-1]
    earlier = f"{first}" if first == last else f"{first} to {last}"
    yield Trouble(
        "signals",
        f"found earlier steps in the file ({earlier}), which may have worn the same specimens; expected unworn "
        "specimens at the start of a run; otherwise k_D is wrong",
        "if the specimens were not replaced, remove steps under [[signals]]: a single k_D is then determined from all "
        'steps, with the recorded load; or describe the worn pin with shape = "truncated-sphere" and its flat_radius',
    )


@check("note")
def unstated_uncertainty(run: RawRun) -> Iterator[Trouble]:
    """Name the inputs for which a default uncertainty will be used."""
    silent = [
        name
        for name, quantity in _inputs(run.manifest).items()
        if quantity is not None and quantity.standard_uncertainty is None
    ]
    if silent:
        yield Trouble(
            ", ".join(silent),
            "found no standard_uncertainty; expected one for each value",
            "state it; otherwise the default from the recipe is used",
        )


def _inputs(manifest: RunManifest) -> dict[str, Any]:
    """Return the inputs of a wear coefficient by their keys, with the value None for each that is not stated."""
    conditions, found = manifest.conditions, {"conditions.normal_load": manifest.conditions.normal_load}
    if manifest.contact is None:
        return found
    slipping = ("slip",) if conditions.slip is not None else ("curved_disc_speed", "flat_disc_speed")
    measured = (name for name in EndValues.model_fields if not name.endswith("_profile"))
    return {
        **found,
        **{f"contact.{key}": quantity for key, quantity in manifest.contact.inputs.items()},
        **{f"conditions.{name}": getattr(conditions, name) for name in slipping},
        **{f"end_values.{name}": getattr(manifest.end_values, name) for name in measured},
    }

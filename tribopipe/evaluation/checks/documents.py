"""Checks of what run.toml says: magnitudes that cannot be right, statements that contradict each other."""

from collections.abc import Iterator
from datetime import UTC, datetime
from typing import NamedTuple, get_args

import tribopipe.evaluation.checks.plausibility  # noqa: F401 - registers further checks of what run.toml says
from tribopipe.documents.contact import DISCS, TwinDisc
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.slip import slip
from tribopipe.evaluation.checks.materials import DENSEST_SOLID, LIGHTEST_SOLID
from tribopipe.evaluation.checks.registry import Trouble, check
from tribopipe.evaluation.measurements.measured import DiscWay, PinWay
from tribopipe.results.run import RawRun


def _bodies(run: RawRun) -> Iterator[tuple[str, Quantity | None, Quantity]]:
    for name, body in run.manifest.bodies.items():
        yield f"contact.{name}", body.density, body.youngs_modulus


@check("error")
def density_is_that_of_a_solid(run: RawRun) -> Iterator[Trouble]:
    """Catch g/cm³ written as kg/m³, as in the paper's Table 1, and the reverse."""
    for where, density, _ in _bodies(run):
        if density is None or LIGHTEST_SOLID <= density.value <= DENSEST_SOLID:
            continue
        meant = density.value * 1000 if density.value < LIGHTEST_SOLID else density.value / 1000
        as_meant = Quantity(value=meant, unit=density.unit).shown("g/cm^3")
        yield Trouble(
            f"{where}.density",
            f"found {density.shown('kg/m^3')}; expected the density of a solid, 30 to 23000 kg/m³",
            f"probably {as_meant} was meant",
        )


@check("warning")
def modulus_is_plausible(run: RawRun) -> Iterator[Trouble]:
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
def sizes_and_speeds_are_plausible(run: RawRun) -> Iterator[Trouble]:
    """Catch a wrong unit in radii, load, speeds, slip and distance."""
    manifest = run.manifest
    load = _Size("conditions.normal_load", manifest.conditions.normal_load, 1e-6, 1e5, "N")
    own = _disc_sizes if isinstance(manifest.contact, TwinDisc) else _pin_sizes
    for size in (*own(manifest), load):
        if size.quantity is not None and not size.low <= size.quantity.value <= size.high:
            found = size.quantity.shown(size.unit)
            expected = " to ".join(
                Quantity(value=end, unit=size.quantity.unit).shown(size.unit) for end in (size.low, size.high)
            )
            yield Trouble(size.where, f"found {found}; expected {expected}", "check its unit")
    if isinstance(manifest.contact, TwinDisc):
        yield from _odd_slip(manifest)


def _pin_sizes(manifest: RunManifest) -> Iterator[_Size]:
    conditions = manifest.conditions
    if manifest.contact is not None:
        yield _Size("contact.pin.radius", manifest.sliding_pin.pin.radius, 1e-6, 0.5, "mm")
    yield _Size("conditions.sliding_speed", conditions.nominal_speed, 1e-9, 200.0, "m/s")
    yield _Size("conditions.sliding_distance", conditions.sliding_distance, 1e-6, 1e8, "m")


def _disc_sizes(manifest: RunManifest) -> Iterator[_Size]:
    curved, flat, conditions = manifest.twin_disc.curved_disc, manifest.twin_disc.flat_disc, manifest.conditions
    yield _Size("contact.curved_disc.crown_radius", curved.crown_radius, 1e-5, 10.0, "mm")
    yield _Size("contact.curved_disc.rolling_radius", curved.rolling_radius, 1e-4, 2.0, "mm")
    yield _Size("contact.flat_disc.rolling_radius", flat.rolling_radius, 1e-4, 2.0, "mm")
    yield _Size("conditions.curved_disc_speed", conditions.curved_disc_speed, 1e-9, 200.0, "m/s")
    yield _Size("conditions.flat_disc_speed", conditions.flat_disc_speed, 1e-9, 200.0, "m/s")
    yield _Size(_slip_key(manifest), _slip_share(manifest), 1e-5, 10.0, "%")


def _slip_key(manifest: RunManifest) -> str:
    return "conditions.flat_disc_speed" if manifest.conditions.slip is None else "conditions.slip"


def _slip_share(manifest: RunManifest) -> Quantity:
    return Quantity(value=abs(slip(manifest).value), unit="1")


def _odd_slip(manifest: RunManifest) -> Iterator[Trouble]:
    """Say a word on slip that may be meant but is seldom run: 4 for 4 %, or 0.0004."""
    share = _slip_share(manifest)
    if 1e-5 <= share.value < 1e-3 or 1 < share.value <= 10:
        yield Trouble(
            _slip_key(manifest),
            f"found a slip of {share.shown('%')}; expected 0.1 to 100 % in most tests",
            'write four per cent as "4 %" or 0.04, and check both speeds',
        )


@check("warning")
def start_is_in_the_past(run: RawRun) -> Iterator[Trouble]:
    """Catch a wrong clock or a mistyped year."""
    started = run.manifest.started
    if started is None:
        return
    now = datetime.now(UTC) if started.tzinfo else datetime.now(UTC).replace(tzinfo=None)
    if started > now:
        yield Trouble(
            "started",
            f"found {started.isoformat()}, which is yet to come; expected the start of the test",
            "check the year",
        )


@check("note")
def needed_for_a_wear_coefficient(run: RawRun) -> Iterator[Trouble]:
    """Say early what a run lacks for a wear coefficient."""
    if run.manifest.contact is None:
        yield Trouble(
            "contact",
            "found no [contact]; expected the two bodies for a wear coefficient",
            "describe them if friction is not all that is wanted",
        )
        return
    yield from _needed_of_discs(run) if run.manifest.rolls else _needed_of_a_pin(run)


def _needed_of_a_pin(run: RawRun) -> Iterator[Trouble]:
    end = run.manifest.end_values
    if all(getattr(end, name) in (None, ()) for name in get_args(PinWay)):
        yield Trouble(
            "end_values",
            "found no wear of the pin; expected pin_wear_depth or pin_scar_diameter, its volume, mass or profile; "
            "without one the wear coefficient is by the depth sensor alone",
            "add one if it was measured",
        )
    if "depth" not in run.columns:
        yield Trouble(
            "signals", "found no depth; expected one for a wear coefficient", "map a column if it was recorded"
        )


def _needed_of_discs(run: RawRun) -> Iterator[Trouble]:
    """Name what is missing of each disc."""
    parts = (run.manifest.end_values, *run.manifest.interruptions)
    measured = {name for part in parts for name in type(part).model_fields if getattr(part, name) not in (None, ())}
    if not any(name.startswith("curved_disc_") for name in measured):
        yield Trouble(
            "end_values",
            "found no wear of the curved disc; expected its depth, track width, volume or profile for a wear "
            "coefficient",
            "add one if it was measured",
        )
    elif not any(name.startswith("flat_disc_") for name in measured):
        yield Trouble(
            "end_values",
            "found no wear of the flat disc; expected some, or it is taken as not wearing, in the one-sided model",
            "add its depth, track width, volume or profile if it wore",
        )


@check("note")
def files_were_read_as_they_stand(run: RawRun) -> Iterator[Trouble]:
    """Pass on what a reader had to guess or change."""
    for note in run.notes:
        yield Trouble(
            "signals",
            f"found something to note in reading: {note}; expected a file that leaves nothing open",
            "see that this is meant; run.toml can say how a file is to be read",
        )


@check("warning")
def recorded_signals_are_used(run: RawRun) -> Iterator[Trouble]:
    """Name columns that seem to be signals and are not used."""
    for why in run.unused:
        yield Trouble(
            "signals",
            f"found that {why}; expected each recorded signal to be used",
            "map it under [signals.columns] in run.toml, with its unit",
        )


@check("note")
def uncertainties_are_stated(run: RawRun) -> Iterator[Trouble]:
    """Name the inputs for which a default uncertainty will be used."""
    given = _disc_inputs if run.manifest.rolls else _pin_inputs
    silent = [
        name
        for name, quantity in given(run.manifest).items()
        if quantity is not None and quantity.standard_uncertainty is None
    ]
    if silent:
        yield Trouble(
            ", ".join(silent),
            "found no standard_uncertainty; expected one",
            "state it, or the recipe's default is used",
        )


_STATED_WAYS = [name for name in (*get_args(PinWay), *get_args(DiscWay)) if not name.endswith("_profile")]


def _pin_inputs(manifest: RunManifest) -> dict[str, Quantity | None]:
    load, end = {"conditions.normal_load": manifest.conditions.normal_load}, manifest.end_values
    if manifest.contact is None:
        return {**load}
    contact = manifest.sliding_pin
    return {
        **load,
        "contact.pin.radius": contact.pin.radius,
        "contact.pin.youngs_modulus": contact.pin.youngs_modulus,
        f"contact.{contact.counterbody_name()}.youngs_modulus": contact.counterbody.youngs_modulus,
        **{f"end_values.{name}": getattr(end, name) for name in _STATED_WAYS},
    }


def _disc_inputs(manifest: RunManifest) -> dict[str, Quantity | None]:
    contact, conditions = manifest.twin_disc, manifest.conditions
    slipping = ("slip",) if conditions.slip is not None else ("curved_disc_speed", "flat_disc_speed")
    measured = (f"{disc}_{what}" for disc in DISCS for what in ("wear_depth", "track_width", "wear_volume"))
    return {
        "conditions.normal_load": conditions.normal_load,
        "contact.curved_disc.crown_radius": contact.curved_disc.crown_radius,
        "contact.curved_disc.rolling_radius": contact.curved_disc.rolling_radius,
        "contact.flat_disc.rolling_radius": contact.flat_disc.rolling_radius,
        "contact.curved_disc.youngs_modulus": contact.curved_disc.youngs_modulus,
        "contact.flat_disc.youngs_modulus": contact.flat_disc.youngs_modulus,
        **{f"conditions.{name}": getattr(conditions, name) for name in slipping},
        **{f"end_values.{name}": getattr(manifest.end_values, name) for name in measured},
    }

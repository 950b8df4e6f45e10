"""Checks of what run.toml says: magnitudes that cannot be right, statements that contradict each other."""

from collections.abc import Iterator
from datetime import UTC, datetime

from tribopipe.checks.registry import Trouble, check
from tribopipe.end_values import EndValueUsed, EndWear
from tribopipe.records.quantity import Quantity
from tribopipe.run import RawRun

_LIGHTEST_SOLID, _DENSEST_SOLID = 30.0, 23_000.0
"""kg/m³: lighter than any foam a specimen is made of; denser than osmium (22 590)."""


def _bodies(run: RawRun) -> Iterator[tuple[str, Quantity | None, Quantity]]:
    for name, body in run.manifest.contact.bodies.items():
        yield f"contact.{name}", body.density, body.youngs_modulus


@check("error")
def density_is_that_of_a_solid(run: RawRun) -> Iterator[Trouble]:
    """Catch g/cm³ written as kg/m³, as in the paper's Table 1, and the reverse."""
    for where, density, _ in _bodies(run):
        if density is None or _LIGHTEST_SOLID <= density.value <= _DENSEST_SOLID:
            continue
        meant = density.value * 1000 if density.value < _LIGHTEST_SOLID else density.value / 1000
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


@check("warning")
def sizes_and_speeds_are_plausible(run: RawRun) -> Iterator[Trouble]:
    """Catch a wrong unit in tip radius, load, speed and distance."""
    conditions, radius = run.manifest.conditions, run.manifest.contact.pin.radius
    for where, quantity, low, high, unit in (
        ("contact.pin.radius", radius, 1e-6, 0.5, "mm"),
        ("conditions.normal_load", conditions.normal_load, 1e-6, 1e5, "N"),
        ("conditions.sliding_speed", conditions.sliding_speed, 1e-9, 200.0, "m/s"),
        ("conditions.sliding_distance", conditions.sliding_distance, 1e-6, 1e8, "m"),
    ):
        if quantity is not None and not low <= quantity.value <= high:
            expected = " to ".join(Quantity(value=end, unit=quantity.unit).shown(unit) for end in (low, high))
            yield Trouble(where, f"found {quantity.shown(unit)}; expected {expected}", "check its unit")


@check("warning")
def end_values_agree(run: RawRun) -> Iterator[Trouble]:
    """Compare a measured wear depth with the cap height of the scar, where both are given."""
    end, radius = run.manifest.end_values, run.manifest.contact.pin.radius.value
    if end.pin_wear_depth is None or end.pin_scar_diameter is None:
        return
    cap = EndWear(EndValueUsed("pin_scar_diameter", end.pin_scar_diameter, "manifest"), None, radius).pin_depth
    gap = abs(cap.value - end.pin_wear_depth.value)
    spread = (cap.standard_uncertainty or 0.0) + (end.pin_wear_depth.standard_uncertainty or 0.0)
    if gap > max(3 * spread, 0.05 * cap.value):
        yield Trouble(
            "end_values",
            f"found a pin wear depth of {end.pin_wear_depth.shown('um')} beside a scar whose cap is "
            f"{cap.shown('um')} high; expected them to agree",
            "measure again, or check both units",
        )


@check("warning")
def start_is_in_the_past(run: RawRun) -> Iterator[Trouble]:
    """Catch a wrong clock or a mistyped year."""
    started = run.manifest.started
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
    end = run.manifest.end_values
    if end.pin_wear_depth is None and end.pin_scar_diameter is None:
        yield Trouble(
            "end_values",
            "found no wear of the pin; expected pin_wear_depth or pin_scar_diameter for a drift "
            "correction and a wear coefficient",
            "add one if it was measured",
        )
    if "depth" not in run.columns:
        yield Trouble(
            "signals", "found no depth; expected one for a wear coefficient", "map a column if it was recorded"
        )


@check("note")
def files_were_read_as_they_stand(run: RawRun) -> Iterator[Trouble]:
    """Pass on what a reader had to guess or change."""
    for note in run.notes:
        yield Trouble(
            "signals",
            f"found a file that took a decision to read: {note}; expected none",
            "say in run.toml how it is written",
        )


@check("note")
def uncertainties_are_stated(run: RawRun) -> Iterator[Trouble]:
    """Name the inputs for which a default uncertainty will be used."""
    manifest = run.manifest
    end = manifest.end_values
    given = {
        "conditions.normal_load": manifest.conditions.normal_load,
        "contact.pin.radius": manifest.contact.pin.radius,
        "contact.pin.youngs_modulus": manifest.contact.pin.youngs_modulus,
        "contact.disc.youngs_modulus": manifest.contact.disc.youngs_modulus,
        "end_values.pin_wear_depth": end.pin_wear_depth,
        "end_values.pin_scar_diameter": end.pin_scar_diameter,
        "end_values.disc_wear_depth": end.disc_wear_depth,
    }
    silent = [
        name for name, quantity in given.items() if quantity is not None and quantity.standard_uncertainty is None
    ]
    if silent:
        yield Trouble(
            ", ".join(silent),
            "found no standard_uncertainty; expected one",
            "state it, or the recipe's default is used",
        )

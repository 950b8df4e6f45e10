"""Checks of inputs against what the material, the ball, the contact and the recording make likely."""

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from typing import NamedTuple

import numpy as np

from tribopipe.base.errors import ContactError, FitError
from tribopipe.base.units import SPECIFIC_WEAR_RATE, show
from tribopipe.documents.contact import Contact, Specimen, Tip
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.quantity import EndValue, Quantity
from tribopipe.documents.recipe import Recipe
from tribopipe.evaluation.checks.material_ranges import DENSEST_SOLID, LIGHTEST_SOLID, Expected, Range, expected_of
from tribopipe.evaluation.checks.registry import Trouble, check, check_cleaned
from tribopipe.evaluation.load_and_friction import contact_load
from tribopipe.evaluation.measurements.kinds import Measurements, measurements_of
from tribopipe.evaluation.measurements.specific_wear import CLEARLY
from tribopipe.evaluation.measurements.worn_tip import WornTip
from tribopipe.evaluation.preprocessing.cleaning import CleanedRun
from tribopipe.physics.hertz import HARDNESS_UNIT, hertz_ellipse, hertz_radius
from tribopipe.results.run import RawRun
from tribopipe.results.specific_wear import WearInterval

_FAR_OFF = 10.0
"""Factor beyond its range from which a modulus is taken to be in a wrong unit."""
_YIELDING = 0.6
"""Mean pressure over hardness: yield begins at 0.4, full plasticity at 1 (K. L. Johnson, Contact Mechanics, §6.3)."""
SAME = 0.01
"""Relative difference within which two lengths are one."""
_RING_WORN = 0.1
"""Wear depth of a ring over its radius from which on volumes calculated with a constant radius are wrong by 5 %."""
_ARCHARD = (1e-11, 0.3)
"""Least and largest k·H that passes without a word: wide enough that a unit is wrong, rather than wear unusual."""
_FEWEST_INTERVALS, _STEADY, _FALLEN = 3, 1.3, 0.3
"""Fewest intervals in which losses are distinguished from totals; largest over smallest rate if they are losses, and
lowest over first rate if they are totals."""
_ANOTHER_RATE = 1.5
"""Factor by which the rate of the last interval differs from that of the entire test at least for a report."""
_BALLS = (
    *(0.3, 0.397, 0.5, 0.794, 1.0, 1.5, 1.588, 2.0, 2.381, 2.5, 3.0, 3.175, 3.969, 4.0, 4.763, 5.0, 5.5, 5.556, 6.0),
    *(6.35, 7.938, 8.0, 9.0, 9.525, 10.0, 12.7, 19.05, 25.4),
)
"""Diameters, mm, of balls that tribometers are run with; nominal diameters are those of ISO 3290-1."""


class _Property(NamedTuple):
    """A property of a body, and the range that the name of its material makes likely."""

    key: str
    shown: str
    value: float
    """Value in the unit of the range."""
    expected: Range
    unit: str


def _properties(body: Specimen, known: Expected) -> Iterator[_Property]:
    modulus, density, hardness = body.youngs_modulus, body.density, body.vickers_hardness
    yield _Property("youngs_modulus", modulus.shown("GPa"), modulus.value / 1e9, known.modulus, "GPa")
    if density is not None and LIGHTEST_SOLID <= density.value <= DENSEST_SOLID:
        yield _Property("density", density.shown("g/cm^3"), density.value / 1e3, known.density, "g/cm³")
    if hardness is not None and known.hardness is not None:
        yield _Property("vickers_hardness", f"{hardness:g}", hardness, known.hardness, "HV")


def _unlikely(run: RawRun) -> Iterator[tuple[float, Trouble]]:
    """Yield each property outside the range of its material, after the factor by which it is outside."""
    for name, body in run.manifest.bodies.items():
        known = expected_of(body.material)
        for one in () if known is None else _properties(body, known):
            low, high = one.expected
            if not low <= one.value <= high:
                factor = low / one.value if one.value < low else one.value / high
                yield (
                    factor,
                    Trouble(
                        f"contact.{name}.{one.key}",
                        f"found {one.shown} for {body.material!r}; expected {low:g} to {high:g} {one.unit} for "
                        f"{known.title if known else body.material}",
                        "check its unit, or the material",
                    ),
                )


@check("error")
def modulus_unit(run: RawRun) -> Iterator[Trouble]:
    """Refuse a modulus ten times beyond what the named material has: MPa for GPa."""
    for factor, trouble in _unlikely(run):
        if trouble.where.endswith("youngs_modulus") and factor >= _FAR_OFF:
            yield trouble


@check("warning")
def material_properties(run: RawRun) -> Iterator[Trouble]:
    """Compare modulus, density and hardness with what the named material has."""
    for factor, trouble in _unlikely(run):
        if not (trouble.where.endswith("youngs_modulus") and factor >= _FAR_OFF):
            yield trouble


def _is_ball(diameter: float) -> bool:
    return any(abs(diameter / (ball * 1e-3) - 1) < SAME for ball in _BALLS)


def _diameter_unless_radius(pin: Tip) -> Trouble | None:
    """Report a spherical tip whose radius is its stated diameter, or a radius usual only as the diameter of a ball."""
    radius, twice = pin.radius.value, 2 * pin.radius.value
    stated = None if pin.diameter is None else pin.diameter.value
    if stated is not None and abs(radius / stated - 1) < SAME:
        found = f"a radius of {pin.radius.shown('mm')}, which is the diameter of the pin"
        return Trouble(
            "contact.pin.radius", f"found {found}; expected half the diameter for a ball", "enter half the diameter"
        )
    if stated is None and _is_ball(radius) and not _is_ball(twice):
        found = f"{pin.radius.shown('mm')} (a ball {show(twice, None, 'm', 'mm')} in diameter)"
        return Trouble(
            "contact.pin.radius",
            f"found {found}, which is unusual; expected the radius, since {show(radius, None, 'm', 'mm')} is a common "
            "diameter",
            "enter half the diameter of the ball; if the radius is correct, state contact.pin.diameter",
        )
    return None


@check("warning")
def radius_or_diameter(run: RawRun) -> Iterator[Trouble]:
    """Find the diameter of a ball, or of a flat pin, written as its radius."""
    pin = run.manifest.pin
    if pin is None:
        return
    contact = run.manifest.described
    if contact.usual_diameters:
        trouble = _twice_or_half_the_usual(contact)
    else:
        trouble = _flat_wider_than_the_pin(pin) if pin.constant_area else _diameter_unless_radius(pin)
    if trouble is not None:
        yield trouble


def _twice_or_half_the_usual(contact: Contact) -> Trouble | None:
    """Report a ring or ball with twice or half the diameter of the standards; not a large ring of stated diameter."""
    key, twice = str(contact.track_key), 2e3 * contact.sliding_tip.radius.value
    _, body, size = key.split(".")
    usual = (one for one in contact.usual_diameters if min(abs(twice / one - 2), abs(2 * twice / one - 1)) < SAME)
    meant = next(usual, None)
    # A radius may have been stated as the diameter, and the radius follow from it.
    if meant is None or (size == "radius" and contact.counterbody.diameter is not None and twice > meant):
        return None
    large = size == "radius" and twice > meant
    state = f"; if the radius is correct, state contact.{body}.diameter" if large else ""
    return Trouble(
        key,
        f"found a {body} {twice:.4g} mm in diameter; expected {meant:g} mm, as in the standards",
        f"check that radius and diameter are not confused{state}",
    )


def _flat_wider_than_the_pin(pin: Tip) -> Trouble | None:
    if pin.diameter is None or 2 * pin.radius.value <= (1 + SAME) * pin.diameter.value:
        return None
    return Trouble(
        "contact.pin.radius",
        f"found an end face {show(2 * pin.radius.value, None, 'm', 'mm')} in diameter on a pin "
        f"{pin.diameter.shown('mm')} in diameter; expected an end face no wider than the pin",
        "enter half the diameter of the end face",
    )


@check("note")
def radius_unchecked(run: RawRun) -> Iterator[Trouble]:
    """Report which ball a radius stands for, where no diameter is stated to compare it with."""
    pin = run.manifest.pin
    if pin is None or pin.line or pin.diameter is not None:
        return
    what = "an end face" if pin.constant_area else "a ball"
    if _diameter_unless_radius(pin) is None or pin.constant_area:
        yield Trouble(
            "contact.pin.radius",
            f"found a radius of {pin.radius.shown('mm')} ({what} {show(2 * pin.radius.value, None, 'm', 'mm')} in "
            "diameter), but no stated diameter; expected contact.pin.diameter, to check the radius",
            "check that it is the radius, and state the diameter",
        )


def _mean_pressure(run: RawRun) -> float | None:
    """Return the mean pressure at the start, Pa: by Hertz, or over a flat that is larger; none without bodies."""
    contact = run.manifest.contact
    if contact is None:
        return None
    load = contact_load(run, Recipe()).value
    modulus, (across, along) = float(contact.reduced_modulus()), contact.unworn_radii
    if run.manifest.pin is not None and run.manifest.pin.line:
        return math.sqrt(math.pi * load * modulus / (16 * run.manifest.pin.line * along))
    if across == along:
        return load / (math.pi * start_radius(contact, load, modulus) ** 2)
    try:
        ellipse = hertz_ellipse(normal_load=load, radius_x=across, radius_z=along, modulus=modulus)
    except ContactError:
        return None
    return ellipse.peak_pressure / 1.5


def start_radius(contact: Contact, load: float, modulus: float) -> float:
    """Return the radius of a round contact at the start, m."""
    hertz = float(hertz_radius(normal_load=load, pin_radius=contact.unworn_radii[0], modulus=modulus))
    return max(hertz, contact.flat_end)


class _Softer(NamedTuple):
    """The hardness of the softer body, Pa, as it is stated, or at most for its material."""

    hardness: float
    words: str


def _softer(run: RawRun) -> _Softer | None:
    found = []
    for name, body in run.manifest.bodies.items():
        hardness = _hardness(body)
        if body.vickers_hardness is not None:
            found.append(_Softer(hardness[1], f"the hardness of the {spoken(name)}"))
        elif known := expected_of(body.material):
            found.append(_Softer(hardness[1], f"the highest hardness of {known.title}"))
    return min(found, key=lambda one: one.hardness, default=None)


def _hardness(body: Specimen) -> tuple[float, float]:
    """Return the lowest and highest hardness of a body, Pa: as stated, or of its material; unlimited if unknown."""
    known = expected_of(body.material)
    low, high = (0.0, math.inf) if known is None or known.hardness is None else known.hardness
    stated = body.vickers_hardness
    return (low if stated is None else stated) * HARDNESS_UNIT, (high if stated is None else stated) * HARDNESS_UNIT


@check("warning")
def initial_yielding(run: RawRun) -> Iterator[Trouble]:
    """Find a mean pressure at which the softer body yields, where Hertz's contact does not hold: kN for N."""
    pressure, softer = _mean_pressure(run), _softer(run)
    if pressure is None or softer is None or pressure <= _YIELDING * softer.hardness:
        return
    shown, limit = (Quantity(value=value, unit="Pa").shown("GPa") for value in (pressure, _YIELDING * softer.hardness))
    yield Trouble(
        "conditions.normal_load",
        f"found a mean contact pressure of {shown} at the start; expected less than {limit}, {100 * _YIELDING:.0f} % "
        f"of {softer.words}",
        "check load, radius and Young's moduli with their units, and vickers_hardness",
    )


@check_cleaned("warning")
def rate_not_steady(run: RawRun, cleaned: CleanedRun) -> Iterator[Trouble]:
    """Find running-in or a transition that the overall specific wear rate of an interrupted test includes."""
    if not run.manifest.interruptions or run.manifest.contact is None:
        return
    try:
        bodies = cleaned.wear.bodies
    except (ContactError, FitError):
        return
    for name, body in bodies.items():
        overall, steady = body.specific_wear_rate, body.steady_rate
        if overall is not None and steady is not None and abs(body.steady_deviation or 0.0) > CLEARLY:
            yield Trouble(
                f"interruptions, end_values of the {spoken(name)}",
                f"found an overall specific wear rate of {overall.shown(SPECIFIC_WEAR_RATE)} and a steady-state rate "
                f"of {steady.shown(SPECIFIC_WEAR_RATE)}; expected them to agree after a short running-in",
                "report the steady-state rate for long tests; the overall rate and k_D apply to this distance only",
            )
        elif overall is not None and body.intervals and _is_another_rate(body.intervals[-1], overall.value):
            last = body.intervals[-1]
            yield Trouble(
                f"interruptions, end_values of the {spoken(name)}",
                f"found an overall specific wear rate of {overall.shown(SPECIFIC_WEAR_RATE)} and a rate of "
                f"{last.specific_wear_rate.shown(SPECIFIC_WEAR_RATE)} from {last.start.shown('m')} on; expected "
                "them to agree",
                "evaluate the parts of the test separately; the overall rate and k_D apply to this distance only",
            )


def _is_another_rate(interval: WearInterval, overall: float) -> bool:
    """Return whether the rate of an interval differs from the overall one by far and clearly; both share the load."""
    rate, volume = interval.specific_wear_rate.value, interval.volume
    far = not overall / _ANOTHER_RATE < rate < overall * _ANOTHER_RATE
    own = abs(rate) * volume.u_or_zero / abs(volume.value) if volume.value else math.inf
    return far and abs(rate - overall) > CLEARLY * own


@check_cleaned("warning")
def wear_decreases(run: RawRun, cleaned: CleanedRun) -> Iterator[Trouble]:
    """Find less wear at one interruption than at an earlier one, as where losses of single intervals are given."""
    if not run.manifest.interruptions or run.manifest.contact is None:
        return
    with suppress(ContactError, FitError):
        for name, body in cleaned.wear.bodies.items():
            if _are_increments(body.intervals):
                yield Trouble(
                    f"interruptions, end_values of the {spoken(name)}",
                    "found wear proportional to the distance since the previous measurement; expected the total wear "
                    "since the start of the test in each measurement",
                    "add up the values if each is the loss since the previous measurement",
                )
                continue
            for interval in body.intervals:
                gained = -interval.volume.value
                if gained > CLEARLY * interval.volume.u_or_zero and gained > 0:
                    yield Trouble(
                        f"interruptions, end_values of the {spoken(name)}",
                        f"found less wear after {interval.end.shown('m')} than after {interval.start.shown('m')}; "
                        "expected the total wear since the start of the test in each measurement",
                        "add up the values if each is the loss since the previous measurement",
                    )


def _are_increments(intervals: Sequence[WearInterval]) -> bool:
    """Return whether wear is steady if each measurement is the loss of its interval, and far from it if a total is."""
    lengths = np.array([interval.end.value - interval.start.value for interval in intervals])
    losses = np.array([interval.volume.value for interval in intervals])
    if len(losses) < _FEWEST_INTERVALS or not losses[0] > 0 or not np.all(lengths > 0):
        return False
    rates, as_increments = losses / lengths, np.cumsum(losses) / lengths
    steady = float(np.max(as_increments)) <= _STEADY * float(np.min(as_increments))
    return steady and float(np.min(rates)) < _FALLEN * float(rates[0])


@check_cleaned("warning")
def material_gained(run: RawRun, cleaned: CleanedRun) -> Iterator[Trouble]:
    """Find a body that has clearly gained material, so that its volume does not measure what was removed."""
    measured = (value for _, value in run.manifest.end_values)
    if run.manifest.contact is None or not any(isinstance(one, EndValue) and one.value < 0 for one in measured):
        return
    with suppress(ContactError, FitError):
        for name, body in cleaned.wear.bodies.items():
            volume = body.volume
            if volume is not None and volume.value < -CLEARLY * volume.u_or_zero:
                yield Trouble(
                    f"end_values of the {spoken(name)}",
                    f"found a negative wear volume, {volume.shown('mm^3')}, which is a gain of material; expected a "
                    "loss; wear rate and k_D are reported as negative values",
                    "check the sign, and repeat the measurement; material may have come from the counterbody",
                )


@check_cleaned("warning")
def coating_worn_through(run: RawRun, cleaned: CleanedRun) -> Iterator[Trouble]:
    """Find wear deeper than the coating of a body, so that k_D is that of coating and substrate together."""
    bodies = run.manifest.bodies.items()
    coatings = {name: body.coating_thickness for name, body in bodies if body.coating_thickness is not None}
    if not coatings or run.manifest.contact is None:
        return
    contact = run.manifest.contact
    with suppress(ContactError, FitError):
        worn = {contact.body_name(role): rate.depth for role, rate in cleaned.wear.bodies.items()}
        for name, coating in coatings.items():
            depth = worn.get(name)
            if depth is not None and depth.value > coating.value:
                yield Trouble(
                    f"contact.{name}.coating_thickness",
                    f"found a wear depth of {depth.shown('um')} in a coating {coating.shown('um')} thick; expected "
                    "wear within the coating",
                    "repeat the test over a shorter distance; k_D and wear rate of this test apply to coating and "
                    "substrate combined",
                )


@check_cleaned("warning")
def implausible_wear(run: RawRun, cleaned: CleanedRun) -> Iterator[Trouble]:
    """Find wear that no sliding leaves behind, as by a measurement or a load in a wrong unit."""
    contact = run.manifest.contact
    if contact is None:
        return
    with suppress(ContactError, FitError):
        yield from _wider_than_body(run, measurements_of(contact))
    with suppress(ContactError, FitError):
        for role, body in cleaned.wear.bodies.items():
            where = f"end_values of the {spoken(contact.body_name(role))}"
            if role == contact.tip_role and body.depth is not None:
                yield from _worn_away(where, body.depth, contact)
            elif body.depth is not None and contact.tip is not None and contact.tip.line:
                yield from _ring_worn(where, body.depth, contact)
            if body.specific_wear_rate is not None:
                yield from _beyond_archard(where, body.specific_wear_rate, contact.in_roles[role])


def _wider_than_body(run: RawRun, measured: Measurements) -> Iterator[Trouble]:
    """Find bodies worn so deep that the contact between them would be wider than one of them."""
    limit = measured.widest(run)
    if limit is None or measured.totals is None:
        return
    for found in measured.totals(run, Recipe()):
        if found.total.value > limit.total + CLEARLY * found.total.u_or_zero:
            yield Trouble(
                "end_values",
                f"found a total wear depth of {found.total.shown('um')} from {found.anchor}, at which the contact "
                f"would be wider than the disc ({show(limit.width, None, 'm', 'mm')}); expected at most "
                f"{show(limit.total, None, 'm', 'um')}",
                "check the units of the measurement and of the density, crown_radius and the width of the discs",
            )


def _worn_away(where: str, depth: Quantity, contact: Contact) -> Iterator[Trouble]:
    """Find a flat pin worn by more than its radius, and a block with a scar wider than the radius of its ring."""
    tip = WornTip.of(contact.sliding_tip)
    name, radius = contact.worn_radius
    flat = contact.sliding_tip.constant_area
    size = depth.value if flat else 2 * float(tip.scar_radius(min(depth.value, tip.radius), tip.radius))
    if not tip.widens and size > radius.value:
        what = "a wear depth" if flat else "a scar width"
        yield Trouble(
            where,
            f"found {what} of {show(size, None, 'm', 'mm')}; expected less than the {name} of {radius.shown('mm')}",
            "check the units of the measurement and of the density",
        )


def _ring_worn(where: str, depth: Quantity, contact: Contact) -> Iterator[Trouble]:
    """Find a ring worn so deep that its radius is no longer about the one that everything is calculated with."""
    name, radius = contact.worn_radius
    if depth.value > _RING_WORN * radius.value:
        yield Trouble(
            where,
            f"found a wear depth of {depth.shown('mm')}; expected less than {100 * _RING_WORN:.0f} % of the {name} of "
            f"{radius.shown('mm')}, which is assumed to be constant",
            "check the units of the measurement and of the density",
        )


def _beyond_archard(where: str, rate: Quantity, body: Specimen) -> Iterator[Trouble]:
    """Find a dimensionless wear coefficient k·H that is too large or too small for sliding wear."""
    (softest, hardest), spread = _hardness(body), CLEARLY * rate.u_or_zero
    highest = (rate.value - spread) * softest > _ARCHARD[1]
    # A body with a wear of zero within its uncertainty has not worn.
    if highest or spread < rate.value < _ARCHARD[0] / hardest - spread:
        shown = rate.value * (softest if highest else hardest)
        yield Trouble(
            where,
            f"found a dimensionless wear coefficient (wear rate times hardness) of {shown:.2g}; expected "
            f"{_ARCHARD[0]:g} to {_ARCHARD[1]:g}",
            "check the units of the measurement, of the load and of the sliding distance",
        )

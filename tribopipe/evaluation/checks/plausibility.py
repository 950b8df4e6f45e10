"""Checks of inputs against what the material, the ball, the contact and the recording make likely."""

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from typing import NamedTuple

import numpy as np

from tribopipe.base.errors import ContactError, FitError
from tribopipe.base.units import SPECIFIC_WEAR_RATE, show
from tribopipe.contacts.twin_disc import nominal_pair
from tribopipe.documents.contact import Contact, SlidingPin, Specimen, Tip
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.manifest import EndValues
from tribopipe.documents.quantity import EndValue, Quantity
from tribopipe.documents.recipe import DefaultUncertainty, Recipe
from tribopipe.evaluation.checks.material_ranges import DENSEST_SOLID, LIGHTEST_SOLID, Expected, Range, expected_of
from tribopipe.evaluation.checks.registry import Trouble, check, check_cleaned
from tribopipe.evaluation.load_and_friction import contact_load
from tribopipe.evaluation.measurements.pin_on_disc import pin_wear, track_wear
from tribopipe.evaluation.measurements.pin_tip import SCARS, PinTip
from tribopipe.evaluation.measurements.specific_wear import CLEARLY
from tribopipe.evaluation.measurements.track_profile import reference_radius, worn_area
from tribopipe.evaluation.measurements.twin_disc import disc_totals
from tribopipe.evaluation.measurements.worn_pair import WIDTHS, surest
from tribopipe.evaluation.preprocessing.cleaning import CleanedRun
from tribopipe.physics.hertz import HARDNESS_UNIT, hertz_ellipse, hertz_radius
from tribopipe.results.run import RawRun
from tribopipe.results.specific_wear import WearInterval

_FAR_OFF = 10.0
"""Factor beyond its range from which a modulus is taken to be in a wrong unit."""
_YIELDING = 0.6
"""Mean pressure over hardness: yield begins at 0.4, full plasticity at 1 (K. L. Johnson, Contact Mechanics, §6.3)."""
_SAME = 0.01
"""Relative difference within which two lengths are one."""
_NARROW, _WIDE = 0.6, 1.6
"""A track is as wide as the scar of the pin that made it; half or twice as wide, one of both is a radius."""
_LONGER = 1.05
"""Length over width of a scar from which on they cannot be of one contact; debris can make a scar a little longer."""
_ELASTIC = 0.05
"""Fraction of the wear volume calculated from a scar that is due to elastic deformation and above which it is reported,
if it exceeds the uncertainty of the volume."""
_RING_WORN = 0.1
"""Wear depth of a ring over its radius from which on volumes calculated with a constant radius are wrong by 5 %."""
_ROUND = 1.1
"""Width over length of a scar from which on k_D is wrong by about a quarter if one is taken for the mean of both."""
_UNEVEN = 1.3
"""Largest over smallest reading of one scar, from which on it is named: by V ~ d⁴, nearly three times the volume."""
_ARCHARD = (1e-11, 0.3)
"""Least and largest k·H that passes without a word: wide enough that a unit is wrong, rather than wear unusual."""
_FEWEST_INTERVALS, _STEADY, _FALLEN = 3, 1.3, 0.3
"""Fewest intervals in which losses are distinguished from totals; largest over smallest rate if they are losses, and
lowest over first rate if they are totals."""
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
    return any(abs(diameter / (ball * 1e-3) - 1) < _SAME for ball in _BALLS)


def _diameter_unless_radius(pin: Tip) -> Trouble | None:
    """Report a spherical tip whose radius is its stated diameter, or a radius usual only as the diameter of a ball."""
    radius, twice = pin.radius.value, 2 * pin.radius.value
    stated = None if pin.diameter is None else pin.diameter.value
    if stated is not None and abs(radius / stated - 1) < _SAME:
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
    if run.manifest.sliding_pin.usual_diameters:
        trouble = _twice_or_half_the_usual(run.manifest.sliding_pin)
    else:
        trouble = _flat_wider_than_the_pin(pin) if pin.constant_area else _diameter_unless_radius(pin)
    if trouble is not None:
        yield trouble


def _twice_or_half_the_usual(contact: SlidingPin) -> Trouble | None:
    """Report a ring or ball with twice or half the diameter of the standards; not a large ring of stated diameter."""
    key, twice = str(contact.track_key), 2e3 * contact.pin.radius.value
    _, body, size = key.split(".")
    usual = (one for one in contact.usual_diameters if min(abs(twice / one - 2), abs(2 * twice / one - 1)) < _SAME)
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
    if pin.diameter is None or 2 * pin.radius.value <= (1 + _SAME) * pin.diameter.value:
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
        return load / (math.pi * _start_radius(contact, load, modulus) ** 2)
    try:
        ellipse = hertz_ellipse(normal_load=load, radius_x=across, radius_z=along, modulus=modulus)
    except ContactError:
        return None
    return ellipse.peak_pressure / 1.5


def _start_radius(contact: Contact, load: float, modulus: float) -> float:
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
    """Find running-in that the overall specific wear rate of an interrupted test includes."""
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
    with suppress(ContactError, FitError):  # a pin is no disc
        yield from _wider_than_disc(run)
    with suppress(ContactError, FitError):
        for role, body in cleaned.wear.bodies.items():
            where = f"end_values of the {spoken(contact.body_name(role))}"
            if role == contact.tip_role and body.depth is not None:
                yield from _worn_away(where, body.depth, run.manifest.sliding_pin)
            elif body.depth is not None and contact.tip is not None and contact.tip.line:
                yield from _ring_worn(where, body.depth, run.manifest.sliding_pin)
            if body.specific_wear_rate is not None:
                yield from _beyond_archard(where, body.specific_wear_rate, contact.in_roles[role])


def _wider_than_disc(run: RawRun) -> Iterator[Trouble]:
    """Find discs worn so deep that the flat between them would be wider than one of them."""
    discs = run.manifest.twin_disc
    width = min((one.width.value for one in (discs.curved_disc, discs.flat_disc) if one.width), default=math.inf)
    if not width < 2 * discs.curved_disc.crown_radius.value:
        return
    pair = nominal_pair(run.manifest, Recipe().wear.distance_per_rotation)
    most = float(pair.depth_of_width(np.array(width)))
    for found in disc_totals(run, Recipe()):
        if found.total.value > most + CLEARLY * found.total.u_or_zero:
            yield Trouble(
                "end_values",
                f"found a total wear depth of {found.total.shown('um')} from {found.anchor}, at which the contact "
                f"would be wider than the disc ({show(width, None, 'm', 'mm')}); expected at most "
                f"{show(most, None, 'm', 'um')}",
                "check the units of the measurement and of the density, crown_radius and the width of the discs",
            )


def _worn_away(where: str, depth: Quantity, contact: SlidingPin) -> Iterator[Trouble]:
    """Find a flat pin worn by more than its radius, and a block with a scar wider than the radius of its ring."""
    tip = PinTip.of(contact.pin)
    name, radius = contact.worn_radius
    flat = contact.pin.constant_area
    size = depth.value if flat else 2 * float(tip.scar_radius(min(depth.value, tip.radius), tip.radius))
    if not tip.widens and size > radius.value:
        what = "a wear depth" if flat else "a scar width"
        yield Trouble(
            where,
            f"found {what} of {show(size, None, 'm', 'mm')}; expected less than the {name} of {radius.shown('mm')}",
            "check the units of the measurement and of the density",
        )


def _ring_worn(where: str, depth: Quantity, contact: SlidingPin) -> Iterator[Trouble]:
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


@check("warning")
def scar_or_radius(run: RawRun) -> Iterator[Trouble]:
    """Find a scar smaller than the contact it began with, and a track twice or half as wide as the scar."""
    pin, end = run.manifest.pin, run.manifest.end_values
    if pin is None or pin.constant_area:
        return
    start = _start_width(run)
    for name, scar in _scars(run):
        if scar.value + 3 * scar.u_or_zero >= start:
            continue
        yield Trouble(
            f"end_values.{name}",
            f"found {scar.shown('um')}, smaller than the initial contact diameter of {show(start, None, 'm', 'um')}; "
            "expected a larger scar",
            "check that the value is a diameter, and check its unit, the load and the radius of the pin",
        )
    if pin.line:
        yield from _scar_across(run, pin.line)
        return
    if end.pin_scar_diameter is not None and end.pin_scar_diameter.value:
        yield from _track_beside(end.pin_scar_diameter, end)
        yield from _groove_beside(end.pin_scar_diameter, run)
    yield from _longer_than_wide(end)


@check("warning")
def profile_width(run: RawRun) -> Iterator[Trouble]:
    """Find a groove in a profile far wider or narrower than a pin of this shape is in contact at its depth."""
    pin = run.manifest.pin
    if pin is None or not pin.widens or pin.line:
        return
    tip, worn, start = PinTip.of(run.manifest.sliding_pin.equivalent_pin), _pin_depth(run), _start_width(run)
    for where, profile in run.single_profiles.items():
        if not where.startswith("end_values.disc_profile") or reference_radius(run.manifest, where) is not None:
            continue
        with suppress(FitError):
            track = worn_area(profile, None)
            approach = track.depth.value + (worn or 0.0)
            across = 2 * float(tip.on_track(tip.radius).half_width_at(min(approach, tip.radius)))
            # Of a pin that was not measured, any part may be worn, which makes the groove wider.
            too_wide = worn is not None and track.width.value > _WIDE * math.hypot(across, start)
            if too_wide or track.width.value < _NARROW * across or approach > tip.radius:
                yield Trouble(
                    where,
                    f"found a groove {track.width.shown('um')} wide and {track.depth.shown('um')} deep; expected a "
                    f"width of about {show(across, None, 'm', 'um')}, the contact width of the pin at this depth",
                    "check the units of position and height, that the height increases away from the specimen, and "
                    "the radius of the pin",
                )
                return


def _pin_depth(run: RawRun) -> float | None:
    """Return the wear depth of the pin, m, by what was measured on it; None without a measurement."""
    with suppress(ContactError, FitError):
        way = surest(pin_wear(run, DefaultUncertainty()), "depth")
        return None if way is None or way.depth is None else max(way.depth.value, 0.0)
    return None


@check("warning")
def scar_not_round(run: RawRun) -> Iterator[Trouble]:
    """Find one diameter of a scar that the groove made wider than long, from which the wear of the pin follows."""
    scar = run.manifest.end_values.pin_scar_diameter
    if scar is None:
        return
    try:
        used = surest(pin_wear(run, DefaultUncertainty()), "volume")
    except (ContactError, FitError):
        return
    if used is None or used.name != "pin_scar_diameter" or used.pair is None:
        return
    shape = used.pair.contact()
    width, length = float(shape.half_width), float(shape.half_length)
    both_ways = scar.readings and max(scar.readings) * length > min(scar.readings) * (width + length) / 2
    if width > _ROUND * length > 0 and not both_ways:
        yield Trouble(
            "end_values.pin_scar_diameter",
            f"found a single diameter, {scar.shown('um')}, although the groove makes the scar about "
            f"{width / length:.2g} times as wide as it is long; expected length and width",
            "enter pin_scar_length, along the sliding direction, and pin_scar_width; the diameter is assumed to be "
            "their mean, so k_D is wrong if only one of them was measured",
        )


@check("warning")
def uneven_scars(run: RawRun) -> Iterator[Trouble]:
    """Find readings of a scar that differ as those of balls or places that carry unequal loads do."""
    for name, scar in _scars(run):
        low, high = min(scar.readings or (scar.value,)), max(scar.readings or (scar.value,))
        if high > _UNEVEN * low > 0:
            yield Trouble(
                f"end_values.{name}",
                f"found readings from {show(low, None, scar.unit, 'um')} to {show(high, None, scar.unit, 'um')}; "
                f"expected the largest to be at most {_UNEVEN:.1f} times the smallest",
                "check the alignment of the specimens: the load may be shared unequally",
            )


@check("warning")
def stroke_within_scar(run: RawRun) -> Iterator[Trouble]:
    """Find strokes shorter than the contact, as in fretting, where parts of both bodies never leave it."""
    stroke, pin = run.manifest.conditions.stroke, run.manifest.pin
    if stroke is None or pin is None:
        return
    sizes = [("the scar", scar.value) for name, scar in _scars(run) if name != "pin_scar_width"]
    if not sizes:
        sizes += [("the worn contact", length) for length in _contact_length(run)]
    if not pin.line:
        sizes.append(("the initial contact", _start_width(run)))
    what, longest = max(sizes, key=lambda size: size[1], default=("", 0.0))
    if stroke.value <= longest:
        yield Trouble(
            "conditions.stroke",
            f"found a stroke of {stroke.shown('mm')}, not longer than {what} of {show(longest, None, 'm', 'mm')}; "
            "expected a longer stroke: at this stroke, parts of both bodies never leave the contact (fretting)",
            "check the units of both values; in fretting, report the wear volumes and do not predict depths from k_D",
        )


def _contact_length(run: RawRun) -> Iterator[float]:
    """Yield the length of the contact along the sliding direction, m, by the surest measurement of pin or track."""
    with suppress(FitError):
        pin, track = (worn(run, DefaultUncertainty()) for worn in (pin_wear, track_wear))
        way = surest(pin, "volume") or surest(track, "volume")
        if way is not None and way.pair is not None:
            yield 2 * float(way.pair.contact().half_length)


def _scars(run: RawRun) -> Iterator[tuple[str, EndValue]]:
    """Yield the measured sizes of the scar by their keys; none of a scar that is not there."""
    for name in SCARS:
        scar = getattr(run.manifest.end_values, name)
        if scar is not None and scar.value:
            yield name, scar


def _start_width(run: RawRun) -> float:
    """Return the width of the contact without wear, along the sliding direction in a line contact, m."""
    contact, load = run.manifest.sliding_pin, contact_load(run, Recipe()).value
    modulus = float(contact.reduced_modulus())
    if contact.pin.line:
        per_length = load / contact.pin.line
        return 2 * math.sqrt(4 * per_length * contact.pin.radius.value / (math.pi * modulus))
    return 2 * _start_radius(contact, load, modulus)


@check("warning")
def elastic_scar(run: RawRun) -> Iterator[Trouble]:
    """Find a scar or track not much wider than the unworn contact: elastic deformation is counted as its wear.

    A contact of radius a rubs its scar while the bodies are deflected. Under Hertz's pressure with the radius a_H
    without wear, (a_H/a)³ of the calculated wear volume is due to elastic deformation; local wear gives the same within
    4 % of that volume from a = 1.3·a_H on. In a line contact, it is (a_H/a)². A scar that may be as wide as the unworn
    contact may be no wear at all, and a track is worn no deeper than its pin.
    """
    pin = run.manifest.pin
    if pin is None or not (pin.line or pin.shape == "spherical"):
        return
    start, power = _start_width(run), 2 if pin.line else 3
    # By V ~ a⁴ + 2a*³a − 3a*⁴ of the GIWM at the depth a²/2R, with a*³ = 4/3·a_H³.
    by_giwm = not pin.line and "depth" in run.columns
    fitted = ", and k_D from a GIWM fit to the depth signal by several times this fraction" if by_giwm else ""
    for name, size, what in (*_rubbed(run, start), *_track_by_width(run)):
        share = min((start / size.value) ** power, 1.0)
        if share <= max(_ELASTIC, (power + 1) * size.u_or_zero / size.value):
            continue
        part = "all" if share == 1 else f"about {100 * share:.0f} %"
        yield Trouble(
            f"end_values.{name}",
            f"found {size.shown('um')}, but the unworn elastic contact is {show(start, None, 'm', 'um')} wide: "
            f"{part} of the wear volume calculated from the {what} is due to elastic deformation; expected "
            f"a {what} at least {_ELASTIC ** (-1 / power):.1f} times as wide as the unworn contact",
            f"volume and k_D are too large by about this fraction{fitted}; enter a profile or a wear depth instead, or "
            "run a longer test",
        )


def _rubbed(run: RawRun, start: float) -> Iterator[tuple[str, EndValue, str]]:
    """Yield the sizes of the scar, unless they are smaller than any contact can be, m."""
    for name, scar in _scars(run):
        if scar.value + 3 * scar.u_or_zero >= start:
            yield name, scar, "scar"


def _track_by_width(run: RawRun) -> Iterator[tuple[str, EndValue, str]]:
    """Yield the width of the track if its volume follows from it alone."""
    width = run.manifest.end_values.disc_track_width
    with suppress(ContactError, FitError):
        way = surest(track_wear(run, DefaultUncertainty()), "volume")
        if width is not None and width.value and way is not None and way.name == "disc_track_width":
            yield "disc_track_width", width, "track"


def _scar_across(run: RawRun, contact_length: float) -> Iterator[Trouble]:
    """Find the size of a scar on a block that is that of the block, across the sliding direction."""
    for name, scar in _scars(run):
        if abs(scar.value / contact_length - 1) < _SAME:
            yield Trouble(
                f"end_values.{name}",
                f"found {scar.shown('mm')}, the length of the contact across the sliding direction; expected the size "
                "of the scar along the sliding direction",
                "enter the size along the sliding direction; keep the value if the two sizes happen to be equal",
            )


def _longer_than_wide(end: EndValues) -> Iterator[Trouble]:
    """Find a scar longer than it, or its track, is wide: a groove makes a scar wider, never narrower."""
    length, default = end.pin_scar_length, DefaultUncertainty().track_width.value
    for name in WIDTHS:
        width = getattr(end, name)
        if length is None or width is None:
            continue
        spread = math.hypot(*(one.standard_uncertainty or default for one in (length, width)))
        if length.value > max(_LONGER * width.value, width.value + 3 * spread):
            yield Trouble(
                f"end_values.pin_scar_length, end_values.{name}",
                f"found a length of {length.shown('um')} and a width of {width.shown('um')}; expected a width no "
                "smaller than the length, since a groove makes the scar wider than it is long",
                "check that the length is measured along the sliding direction and the width across it, and that "
                "neither value is a half-length or half-width",
            )


def _track_beside(scar: EndValue, end: EndValues) -> Iterator[Trouble]:
    width = end.disc_track_width
    if width is not None and not _NARROW <= width.value / scar.value <= _WIDE:
        yield Trouble(
            "end_values.pin_scar_diameter, end_values.disc_track_width",
            f"found a scar {scar.shown('um')} wide and a track {width.shown('um')} wide; expected about the same width",
            "check that the diameter of the scar is given, not its radius, and check the units of both values",
        )


def _groove_beside(scar: EndValue, run: RawRun) -> Iterator[Trouble]:
    """Find a groove that the unworn pin would touch over more than the scar is wide."""
    try:
        ways = track_wear(run, DefaultUncertainty())
    except FitError:
        return
    groove = surest([way for way in ways if way.name not in WIDTHS], "depth")
    if groove is None or groove.depth is None or groove.depth.value <= 0:
        return
    tip = PinTip.of(run.manifest.sliding_pin.equivalent_pin)
    width = 2 * float(tip.on_track(tip.radius).half_width_at(groove.depth.value))
    if width > _WIDE * scar.value:
        yield Trouble(
            f"end_values.pin_scar_diameter, end_values.{groove.name}",
            f"found a scar {scar.shown('um')} wide and a groove {groove.depth.shown('um')} deep, in which the pin "
            f"has a contact width of at least {show(width, None, 'm', 'um')}; expected about the same width",
            "check that the diameter of the scar is given, not its radius, and check the units of both values",
        )

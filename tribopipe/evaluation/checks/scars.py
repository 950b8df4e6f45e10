"""Checks of scars and tracks against the contact that makes them, and against each other."""

import math
from collections.abc import Iterator
from contextlib import suppress

from tribopipe.base.errors import ContactError, FitError
from tribopipe.base.units import show
from tribopipe.documents.manifest import EndValues
from tribopipe.documents.quantity import EndValue
from tribopipe.documents.recipe import DefaultUncertainty, Recipe
from tribopipe.evaluation.checks.plausibility import SAME, start_radius
from tribopipe.evaluation.checks.registry import Trouble, check
from tribopipe.evaluation.load_and_friction import contact_load
from tribopipe.evaluation.measurements.body_wear import BodyWear, surest
from tribopipe.evaluation.measurements.kinds import worn_bodies
from tribopipe.evaluation.measurements.readings import SCARS, WIDTHS
from tribopipe.evaluation.measurements.track_profile import reference_radius, worn_area
from tribopipe.evaluation.measurements.worn_tip import WornTip
from tribopipe.physics.hertz import hertz_ellipse
from tribopipe.results.run import RawRun

_NARROW, _WIDE = 0.6, 1.6
"""A track is as wide as the scar of the pin that made it; half or twice as wide, one of both is a radius."""
_LONGER = 1.05
"""Length over width of a scar from which on they cannot be of one contact; debris can make a scar a little longer."""
_ELASTIC = 0.05
"""Fraction of the wear volume calculated from a scar that is due to elastic deformation and above which it is reported,
if it exceeds the uncertainty of the volume."""
_ROUND = 1.1
"""Width over length of a scar from which on k_D is wrong by about a quarter if one is taken for the mean of both."""
_UNEVEN = 1.3
"""Largest over smallest reading of one scar, from which on it is named: by V ~ d⁴, nearly three times the volume."""


@check("warning")
def scar_or_radius(run: RawRun) -> Iterator[Trouble]:
    """Find a scar smaller than the contact it began with, and a track twice or half as wide as the scar."""
    pin, end = run.manifest.pin, run.manifest.end_values
    if pin is None:
        yield from _tracks_of_rolling_bodies(run)
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


def _tracks_of_rolling_bodies(run: RawRun) -> Iterator[Trouble]:
    """Find tracks narrower than the contact they began with."""
    contact = run.manifest.contact
    if contact is None:
        return
    across, along = contact.unworn_radii
    load, modulus = contact_load(run, Recipe()).value, float(contact.reduced_modulus())
    with suppress(ContactError):
        start = 2 * hertz_ellipse(normal_load=load, radius_x=across, radius_z=along, modulus=modulus).half_width
        for role in contact.roles:
            name = f"{role}_track_width"
            width = getattr(run.manifest.end_values, name)
            if width is not None and width.value + 3 * width.u_or_zero < start:
                yield Trouble(
                    f"end_values.{name}",
                    f"found {width.shown('um')}, smaller than the initial contact width of "
                    f"{show(start, None, 'm', 'um')}; expected a wider track",
                    "check that it is the width rather than half of it, and check its unit, the load and the radii",
                )


@check("warning")
def profile_width(run: RawRun) -> Iterator[Trouble]:
    """Find a groove in a profile far wider or narrower than a pin of this shape is in contact at its depth."""
    pin = run.manifest.pin
    if pin is None or not pin.widens or pin.line:
        return
    tip, worn, start = WornTip.of(run.manifest.described.equivalent_pin), _pin_depth(run), _start_width(run)
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


def _tip_and_track(run: RawRun) -> tuple[tuple[BodyWear, ...], ...]:
    """Return the wear of the body that stays in contact and of its track by each measurement at the end."""
    return tuple(worn_bodies(run, DefaultUncertainty()).bodies.values())


def _pin_depth(run: RawRun) -> float | None:
    """Return the wear depth of the pin, m, by what was measured on it; None without a measurement."""
    with suppress(ContactError, FitError):
        way = surest(_tip_and_track(run)[0], "depth")
        return None if way is None or way.depth is None else max(way.depth.value, 0.0)
    return None


@check("warning")
def scar_not_round(run: RawRun) -> Iterator[Trouble]:
    """Find one diameter of a scar that the groove made wider than long, from which the wear of the pin follows."""
    scar = run.manifest.end_values.pin_scar_diameter
    if scar is None:
        return
    try:
        used = surest(_tip_and_track(run)[0], "volume")
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
        pin, track = _tip_and_track(run)
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
    contact, load = run.manifest.described, contact_load(run, Recipe()).value
    modulus = float(contact.reduced_modulus())
    if contact.sliding_tip.line:
        per_length = load / contact.sliding_tip.line
        return 2 * math.sqrt(4 * per_length * contact.sliding_tip.radius.value / (math.pi * modulus))
    return 2 * start_radius(contact, load, modulus)


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
        way = surest(_tip_and_track(run)[1], "volume")
        if width is not None and width.value and way is not None and way.name == "disc_track_width":
            yield "disc_track_width", width, "track"


def _scar_across(run: RawRun, contact_length: float) -> Iterator[Trouble]:
    """Find the size of a scar on a block that is that of the block, across the sliding direction."""
    for name, scar in _scars(run):
        if abs(scar.value / contact_length - 1) < SAME:
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
        _, ways = _tip_and_track(run)
    except FitError:
        return
    groove = surest([way for way in ways if way.name not in WIDTHS], "depth")
    if groove is None or groove.depth is None or groove.depth.value <= 0:
        return
    tip = WornTip.of(run.manifest.described.equivalent_pin)
    width = 2 * float(tip.on_track(tip.radius).half_width_at(groove.depth.value))
    if width > _WIDE * scar.value:
        yield Trouble(
            f"end_values.pin_scar_diameter, end_values.{groove.name}",
            f"found a scar {scar.shown('um')} wide and a groove {groove.depth.shown('um')} deep, in which the pin "
            f"has a contact width of at least {show(width, None, 'm', 'um')}; expected about the same width",
            "check that the diameter of the scar is given, not its radius, and check the units of both values",
        )

"""Checks of what was measured on the specimens: what cannot be, what contradicts itself, what gives no wear."""

import math
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from itertools import chain, combinations

from tribopipe.base.errors import ContactError, FitError
from tribopipe.base.units import show
from tribopipe.documents.contact import Contact
from tribopipe.documents.manifest import EndValues, RunManifest
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import DefaultUncertainty, Recipe
from tribopipe.evaluation.checks.registry import Trouble, check
from tribopipe.evaluation.measurements.body_wear import names_used
from tribopipe.evaluation.measurements.end_wear import TotalWear
from tribopipe.evaluation.measurements.kinds import Measurements, measurements_of, worn_bodies
from tribopipe.evaluation.measurements.profile_gaps import has_gaps
from tribopipe.evaluation.measurements.readings import differences_at
from tribopipe.evaluation.measurements.tip_map import radii_differ, volume_below_sphere
from tribopipe.evaluation.measurements.track_profile import GAP_REMEDY, gap_found, reference_radius, worn_area
from tribopipe.evaluation.measurements.worn_tip import WornTip, tip_maps, tip_radius
from tribopipe.physics.geometry import scar_depth
from tribopipe.results.run import Profile, RawRun, paired_key

_ITEM = re.compile(r"\[\d+\]$")
"""Number of a scan line at the end of its key."""
_GROOVES = {
    "disc_wear_depth": ("a wear depth", "um"),
    "disc_track_area": ("a cross-section", "um^2"),
    "disc_wear_volume": ("a wear volume", "mm^3"),
    "disc_mass_loss": ("a wear volume", "mm^3"),
}
"""What a measurement of a groove gives, and its unit."""
_TRACK = ".disc_profile"
"""End of the key of a track, which may lead beyond the edge of its map."""
_SMOOTHEST, _SHALLOW, _SHALLOWEST = 0.05e-9, 100e-9, 5e-9
"""m: heights of the smoothest polished surface scatter by more, and no groove of a tribometer is that shallow; that
smooth around a deeper groove, a profile is simulated."""


@check("error")
def impossible_measurement(run: RawRun) -> Iterator[Trouble]:
    """Refuse a mass without density, and more wear than a pin holds."""
    contact = run.manifest.contact
    if contact is None:
        return
    for number, (where, end) in enumerate(_parts(run.manifest), start=-1):
        yield from _masses_without_density(where, end, contact)
        if run.manifest.pin is None:
            continue
        yield from _impossible_on_the_pin(where, end, contact)
        yield from _impossible_track(where, end, run.manifest)
        yield from _groove_beyond_the_tip(where, run, None if number < 0 else number)


def _parts(manifest: RunManifest) -> Iterator[tuple[str, EndValues]]:
    yield "end_values", manifest.end_values
    for number, stop in enumerate(manifest.interruptions):
        yield f"interruptions[{number}]", stop


def _masses_without_density(where: str, end: EndValues, contact: Contact) -> Iterator[Trouble]:
    for role, (name, body) in zip(contact.roles, contact.bodies.items(), strict=True):
        if getattr(end, f"{role}_mass_loss") is not None and body.density is None:
            yield Trouble(
                f"{where}.{role}_mass_loss",
                f"found a mass loss of the {name} without a density; expected contact.{name}.density, which converts "
                "it to a wear volume",
                'add this key, such as density = "3.21 g/cm^3"',
            )


def _impossible_on_the_pin(where: str, end: EndValues, contact: Contact) -> Iterator[Trouble]:
    """Find more wear than half a sphere, a scar within the flat that was there, and profiles of what has no cap."""
    tip = WornTip.of(contact.equivalent_pin)
    if not tip.widens:
        if any(one.before is None for one in end.pin_profile):
            yield Trouble(
                f"{where}.pin_profile",
                "found a profile of a flat pin or block, which has no unworn surface for leveling; expected a "
                "spherical tip",
                "use pin_wear_depth or pin_mass_loss instead",
            )
        return
    most = float(scar_depth(scar_radius=tip.radius, sphere_radius=tip.radius, flat_radius=tip.flat_radius))
    held, volume = float(tip.volume(most, tip.radius)), _pin_volume(end, contact)
    if volume is not None and volume.value >= held:
        yield Trouble(
            f"{where}.{'pin_wear_volume' if end.pin_wear_volume is not None else 'pin_mass_loss'}",
            f"found a wear volume of {volume.shown('mm^3')} on a tip with a volume of "
            f"{show(held, None, 'm^3', 'mm^3')}; expected a wear volume smaller than the volume of the tip",
            "check the units of both values",
        )
    scar = end.pin_scar_diameter or end.pin_scar_length or end.pin_scar_width
    if scar is not None and scar.value + 3 * scar.u_or_zero < 2 * tip.flat_radius:
        yield Trouble(
            f"{where}.pin_scar_diameter",
            f"found {scar.shown('um')}, smaller than the initial flat of {show(2 * tip.flat_radius, None, 'm', 'um')}; "
            "expected a scar larger than the flat",
            "check flat_radius and both units",
        )


def _pin_volume(end: EndValues, contact: Contact) -> Quantity | None:
    """Return the volume stated for the pin, or that of its mass, m³."""
    if end.pin_wear_volume is not None:
        return end.pin_wear_volume
    if end.pin_mass_loss is None or contact.sliding_tip.density is None:
        return None
    return Quantity(value=end.pin_mass_loss.value / contact.sliding_tip.density.value, unit="m^3")


def _impossible_track(where: str, end: EndValues, manifest: RunManifest) -> Iterator[Trouble]:
    """Find tracks wider than the pin, or than the circle they lie on."""
    width, pin, circle = end.disc_track_width, manifest.described.sliding_tip, manifest.conditions.track_radius
    tip = pin.radius if pin.widens else None
    for size, radius in (("diameter of the pin", tip), ("diameter of the circular wear track", circle)):
        if width is not None and radius is not None and width.value >= 2 * radius.value:
            yield Trouble(
                f"{where}.disc_track_width",
                f"found {width.shown('um')}, not less than the {size} "
                f"({show(2 * radius.value, None, 'm', 'mm')}); expected a narrower track",
                "check the units of both values",
            )


def _groove_beyond_the_tip(where: str, run: RawRun, interruption: int | None) -> Iterator[Trouble]:
    """Find a groove so deep that, with the wear of the pin, the contact would be wider than the pin."""
    try:
        bodies = worn_bodies(run, DefaultUncertainty(), interruption).bodies.values()
    except FitError:
        return
    for way in chain.from_iterable(bodies):
        what, unit = _GROOVES.get(way.name, ("", ""))
        pair = way.pair
        if what and pair is not None and pair.tip.widens and pair.beyond_tip:
            tip = show(pair.tip_height, None, "m", "um")
            yield Trouble(
                f"{where}.{way.name}",
                f"found {what} of {pair.disc.quantity.shown(unit)}, at which scar and groove would have a combined "
                f"depth of {tip} or more; expected less than the tip height of {tip}",
                "check the units, the radius of the pin and the length of the wear track",
            )


@check("note")
def no_wear_in_profile(run: RawRun) -> Iterator[Trouble]:
    """Name profiles of which no depth or volume can be taken."""
    maps = _maps(run)
    for where, profile in run.single_profiles.items():
        radius = reference_radius(run.manifest, where)
        try:
            if _ITEM.sub("", where) not in maps:
                worn_area(profile, None if radius is None else radius.value)
        except FitError as error:
            yield _no_wear(where, error)
    for where, lines in maps.items():
        try:
            for one in lines.values():
                volume_below_sphere(one, tip_radius(run, DefaultUncertainty()))
        except FitError as error:
            yield _no_wear(where, error)
    yield from _no_difference(run)


@check("warning")
def gap_in_profile(run: RawRun) -> Iterator[Trouble]:
    """Name the widest gap between heights in the track, of the profiles of each key."""
    maps, widest = _maps(run), dict[str, tuple[float, str]]()
    for where, profile in run.single_profiles.items():
        key, radius = _ITEM.sub("", where), reference_radius(run.manifest, where)
        if key not in maps and has_gaps(profile.position):
            with suppress(FitError):
                gap = worn_area(profile, None if radius is None else radius.value).gap
                widest[key] = max(widest.get(key, (0.0, where)), (gap, where))
    for gap, where in widest.values():
        if gap:
            yield Trouble(where, gap_found(gap), GAP_REMEDY)


@check("warning")
def profile_height(run: RawRun) -> Iterator[Trouble]:
    """Find a groove too shallow, or a surface around it too smooth, for heights in the stated unit."""
    first = {_ITEM.sub("", where): where for where in reversed(run.single_profiles)}
    for where in reversed(first.values()):
        if reference_radius(run.manifest, where) is not None:
            continue
        with suppress(FitError):
            track = worn_area(run.single_profiles[where], None)
            smooth = track.roughness < _SMOOTHEST and track.depth.value < _SHALLOW
            if smooth or track.depth.value < _SHALLOWEST:
                yield Trouble(
                    where,
                    f"found a groove {show(track.depth.value, None, 'm', 'nm')} deep in a surface with a standard "
                    f"deviation of the heights of {show(track.roughness, None, 'm', 'nm')}; expected at least "
                    f"{1e9 * _SHALLOWEST:g} nm and {1e9 * _SMOOTHEST:g} nm",
                    "check the unit of the heights: of heights in mm read as µm, wear volumes are 1000 times too small",
                )


def _no_difference(run: RawRun) -> Iterator[Trouble]:
    """Name height maps before and after the test of which no volume can be taken."""
    for where in dict.fromkeys(paired for key in run.profiles if (paired := paired_key(key)) is not None):
        try:
            for one in differences_at(run, where):
                if not (one.reaches_edge and where.endswith(_TRACK)):
                    one.volume()
        except FitError as error:
            yield _no_wear(where, FitError("map: " + str(error).rpartition("map: ")[2]))


@check("warning")
def map_radius_differs(run: RawRun) -> Iterator[Trouble]:
    """Name height maps whose unworn surface is a sphere of another radius than the tip has by run.toml."""
    for where, maps in _maps(run).items():
        stated = tip_radius(run, DefaultUncertainty())
        for lines in maps.values():
            with suppress(FitError):
                if radii_differ(stated, seen := volume_below_sphere(lines, stated).radius):
                    yield Trouble(
                        where,
                        f"found an unworn surface with a radius of {seen.shown('mm')} in the height map; expected "
                        f"{stated.shown('mm')}, that of the tip; the wear volume is calculated with the radius from "
                        "the map",
                        "check the radius of the tip, and the scale of the map in x, y and z",
                    )


def _maps(run: RawRun) -> dict[str, dict[str, list[Profile]]]:
    """Return the maps of the pin that are integrated as a whole, by the key of their files."""
    if run.manifest.contact is None or run.manifest.pin is None:
        return {}
    found = {f"{where}.pin_profile": tip_maps(run, where) for where, _ in _parts(run.manifest)}
    return {key: maps for key, maps in found.items() if maps}


def _no_wear(where: str, error: FitError) -> Trouble:
    found, _, mend = str(error).partition(": ")[2].rpartition("; ")
    return Trouble(where, found, mend)


@check("warning")
def measurements_disagree(run: RawRun) -> Iterator[Trouble]:
    """Compare what several post-test measurements state about one wear depth or volume."""
    if run.manifest.contact is not None:
        measured = measurements_of(run.manifest.contact)
        yield from _bodies_contradict(run, measured)
        yield from () if measured.totals is None else _totals_contradict(run, measured.totals)


def _bodies_contradict(run: RawRun, measured: Measurements) -> Iterator[Trouble]:
    """Compare what was measured on the pin, and on the disc, with each other, each as the depth or volume it means."""
    try:
        worn = worn_bodies(run, DefaultUncertainty())
    except FitError:
        return
    for found in measured.contradictions(worn):
        unit, used = "um" if found.what == "depth" else "mm^3", _used(names_used(worn.bodies[found.body]))
        first, second = (getattr(way, found.what).shown(unit) for way in (found.one, found.other))
        apart = f", {found.deviation:.1f} standard uncertainties apart" if math.isfinite(found.deviation) else ""
        yield Trouble(
            "end_values",
            f"found two values for the wear {found.what} of the {found.body}: {first} from {found.one.name} and "
            f"{second} from {found.other.name}{apart}; expected agreement; {used}, not their mean",
            "repeat the measurement, or check the units of both values",
        )


def _used(names: Sequence[str]) -> str:
    """State which measurements of a body its depth and volume follow from."""
    first, *others = names
    return f"{first} is used for the depth and {others[0]} for the volume" if others else f"{first} is used"


def _totals_contradict(run: RawRun, totals: Callable[[RawRun, Recipe], Iterable[TotalWear]]) -> Iterator[Trouble]:
    """Compare the depth h₁ + h₂ of the one flat that both discs share, by depths, volumes and track widths."""
    for (one, first), (other, second) in combinations(_total_depths(run, totals).items(), 2):
        gap, spread = abs(first.value - second.value), math.hypot(first.u_or_zero, second.u_or_zero)
        if gap > max(3 * spread, 0.2 * max(first.value, second.value)):
            yield Trouble(
                "end_values",
                f"found total wear depths (sum for both discs) of {first.shown('um')} from {one} and of "
                f"{second.shown('um')} from {other}; expected agreement within 20 %, because both discs are worn over "
                "the same contact width",
                "repeat the measurement, measure both discs, or check the units",
            )


def _total_depths(run: RawRun, totals: Callable[[RawRun, Recipe], Iterable[TotalWear]]) -> dict[str, Quantity]:
    """Return h₁ + h₂, m, by each kind of post-test measurement; a disc without any counts as unworn."""
    try:
        return {" and ".join(f"the {name}" for name in one.names): one.total for one in totals(run, Recipe())}
    except (ContactError, FitError):
        return {}

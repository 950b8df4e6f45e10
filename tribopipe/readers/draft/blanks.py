"""Keys of run.toml that only the lab can fill in, with an example, a description and a question for each."""

import re
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from typing import Any, NamedTuple

from tribopipe.documents.contact_kinds import ASSUMED, SHIPPED, kind_of
from tribopipe.readers.draft.known_values import (
    LOAD,
    Known,
    bodies_of,
    example_of,
    needed_conditions_of,
    sections,
    toml,
    value_of,
)
from tribopipe.readers.draft.value_sources import offer_typical, take_radius


class Blank(NamedTuple):
    """A key that may be left open."""

    example: str
    """Example as written in run.toml."""
    words: str

    @property
    def value(self) -> Any:
        """The example as a value."""
        return value_of(self.example)


_SPECIMEN = {
    "material": Blank('"Si3N4"', "name of the material"),
    "youngs_modulus": Blank('"304 GPa"', "Young's modulus E"),
    "poisson_ratio": Blank("0.24", "Poisson's ratio, without unit"),
    "density": Blank('"3.21 g/cm^3"', "density, required to convert a mass loss"),
    "surface_roughness": Blank('"0.07 um"', "roughness Ra before the test"),
    "vickers_hardness": Blank("1600.0", "Vickers hardness HV, without unit"),
}
_SIZES = {
    "shape": Blank('"spherical"', 'shape of the pin: "spherical", "flat" or "truncated-sphere"'),
    "radius": Blank('"3 mm"', "radius of the sphere, or of the flat end of a flat pin"),
    "flat_radius": Blank('"0.2 mm"', "radius of the flat on a truncated sphere before the test"),
    "rolling_radius": Blank('"20 mm"', "radius in the rolling direction"),
    "crown_radius": Blank('"20 mm"', "crown radius, transverse to the rolling direction"),
}
_BODIES = {
    name: [key for key in (_SIZES | _SPECIMEN) if key in kind.specimen(name).model_fields]
    for kind in SHIPPED.values()
    if kind.body_names == kind.roles
    for name in kind.body_names
}
"""Keys of the bodies that have the names of their roles."""
_DEPTH = Blank('{ value = "12.3 um", standard_uncertainty = "0.5 um" }', "wear depth")
_WIDTH = Blank('{ value = "410 um", standard_uncertainty = "5 um" }', "width of the wear track")
_VOLUME = Blank('{ value = "2.7e-3 mm^3", standard_uncertainty = "5 %" }', "wear volume")
_MASS = Blank('{ value = "1.2 mg", standard_uncertainty = "0.1 mg" }', "mass loss; requires the density")
_PROFILE = Blank('{ file = "profile.txt" }', "profile file in this folder; for several: [{ … }, { … }]")

BLANKS: dict[str, Blank] = {
    "started": Blank("2006-03-01T09:30:00+01:00", "start of the test"),
    "title": Blank('"Si3N4 on Si3N4 in air"', "title of the run, on one line"),
    "operator": Blank('"A. Tester"', "operator"),
    "instrument": Blank('"pin-on-disc tribometer no. 2"', "name of the tribometer"),
    "comment": Blank('"…"', "further remarks"),
    "contact.kind": Blank(toml(kind_of(ASSUMED)), "type of tribometer: " + ", ".join(map(toml, SHIPPED))),
    **{f"contact.{body}.{key}": (_SIZES | _SPECIMEN)[key] for body, keys in _BODIES.items() for key in keys},
    "conditions.normal_load": Blank('"50 N"', "nominal normal load"),
    "conditions.sliding_speed": Blank('"400 mm/s"', "nominal sliding speed"),
    "conditions.track_radius": Blank('"6 mm"', "radius of the wear track; required with rotational_speed"),
    "conditions.rotational_speed": Blank('"328 rpm"', "rotational speed of the disc; replaces sliding_speed"),
    "conditions.stroke": Blank('"10 mm"', "stroke length of a reciprocating test"),
    "conditions.frequency": Blank('"5 Hz"', "frequency in full cycles per second; with stroke, replaces sliding_speed"),
    "conditions.sliding_distance": Blank('"500 m"', "planned sliding distance"),
    "conditions.curved_disc_speed": Blank('"800 mm/s"', "surface speed of the crowned disc"),
    "conditions.flat_disc_speed": Blank('"832 mm/s"', "surface speed of the cylindrical disc; or specify slip"),
    "conditions.slip": Blank('"4 %"', "slip ratio (v2 - v1)/v1: crowned disc 1, cylindrical disc 2"),
    "conditions.rotations": Blank("1e6", "planned number of rotations of the crowned disc"),
    "conditions.medium": Blank('"air"', "environment or lubricant of the contact"),
    "conditions.temperature": Blank('"23 degC"', "room temperature"),
    "conditions.relative_humidity": Blank('"45 %"', "relative humidity"),
    "end_values.pin_scar_diameter": Blank(_WIDTH.example, "diameter of the flat scar on the pin"),
    "end_values.pin_scar_length": Blank(
        _WIDTH.example, "length of the scar in the sliding direction, if the disc has worn"
    ),
    "end_values.pin_scar_width": Blank(
        _WIDTH.example, "width of the scar transverse to the sliding direction, if the disc has worn"
    ),
    "end_values.pin_wear_depth": Blank(_DEPTH.example, "wear depth of the pin"),
    "end_values.pin_wear_volume": _VOLUME,
    "end_values.pin_mass_loss": _MASS,
    "end_values.pin_profile": _PROFILE,
    "end_values.disc_wear_depth": Blank(_DEPTH.example, "maximum depth of the wear track"),
    "end_values.disc_track_width": _WIDTH,
    "end_values.disc_track_area": Blank('"480 um^2"', "cross-sectional area of the wear track"),
    "end_values.disc_wear_volume": _VOLUME,
    "end_values.disc_mass_loss": _MASS,
    "end_values.disc_profile": _PROFILE,
    "end_values.curved_disc_wear_depth": _DEPTH,
    "end_values.curved_disc_track_width": _WIDTH,
    "end_values.curved_disc_wear_volume": _VOLUME,
    "end_values.curved_disc_profile": _PROFILE,
    "end_values.flat_disc_wear_depth": _DEPTH,
    "end_values.flat_disc_track_width": _WIDTH,
    "end_values.flat_disc_wear_volume": _VOLUME,
    "end_values.flat_disc_profile": _PROFILE,
    "sensors.depth_scale": Blank(
        "{ value = 1, standard_uncertainty = 0.005 }", "true displacement divided by the indicated displacement"
    ),
}
"""Descriptions and examples by key of run.toml."""


@cache
def blanks_of(kind: str) -> Mapping[str, Blank]:
    """Return the keys that may be left open for a type of tribometer, including bodies from other packages."""
    added: dict[str, Blank] = {}
    for table in bodies_of(kind):
        if f"{table}.material" not in BLANKS:
            own = {
                name: Blank(toml(example_of(sections()[table], name)), (field.description or "").rstrip(".").lower())
                for name, field in sections()[table].model_fields.items()
                if field.is_required() and name not in _SPECIMEN
            }
            added |= {f"{table}.{name}": blank for name, blank in (own | _SPECIMEN).items()}
    return BLANKS | added


Ask = Callable[[str], str]
"""Shows a question and gives the answer, "" for none."""
Say = Callable[[str], None]

_YES = ("y", "yes")
_BALL = re.compile(r"(?:D|dia[a-z]*|[Ø⌀∅])[\s=]*(?=\d)", re.IGNORECASE)
_PIN = "contact.pin"
_SHAPE = f"{_PIN}.shape"
_SPEED = "conditions.sliding_speed"
_OF_THE_RUN = (LOAD, _SPEED)
_OF_A_PIN = ("shape", "radius", "flat_radius")
_OF_EACH = ("material", "youngs_modulus", "poisson_ratio")
_MORE_WORDS = {
    LOAD: "; required",
    f"{_PIN}.radius": '; or "D = 6 mm" for a diameter',
    _SHAPE: "; without a description of the bodies, only friction is evaluated",
}


def ask_for_missing(known: Known, ask: Ask, say: Say) -> None:
    """Ask for what is not known, what is needed first; no answer leaves a key open."""
    for key in _open_questions(known):
        offer_typical(known)  # of the material that the last answer may be
        while answer := ask(_question(known, key)).strip():
            problem = _answered(known, key, answer)
            if problem is None:
                break
            say(problem)


def _answered(known: Known, key: str, answer: str) -> str | None:
    """Take an answer: y for what is offered, a ball by its diameter as "D = 6 mm", or a value."""
    offer, ball = known.offered(key), _BALL.match(answer)
    if offer is not None and answer.casefold() in _YES:
        return known.take(key, offer.value, f"{offer.why}, accepted")
    if key != f"{_PIN}.radius" or ball is None:
        return known.take_typed(key, answer)
    problem = known.take_typed(f"{_PIN}.diameter", answer[ball.end() :])
    take_radius(known)
    return problem


def _open_questions(known: Known) -> Iterator[str]:
    """Give the keys to ask for, judged again after each answer; of a pin whose shape is left open nothing is asked."""
    for key in (*_OF_THE_RUN, *needed_conditions_of(known.kind), *_of_the_bodies(known.kind)):
        shapeless = key.startswith("contact.") and key != _SHAPE and _SHAPE not in known.given
        answered = key in known.given or (key == _SPEED and known.conditions.nominal_speed is not None)
        if not answered and not shapeless and known.fits(key, blanks_of(known.kind)[key].value):
            yield key


def _of_the_bodies(kind: str) -> Iterator[str]:
    """Give the keys of a pin and its counterbody, and none of two discs."""
    if _PIN not in bodies_of(kind):
        return
    for table in bodies_of(kind):
        needed = (name for name, field in sections()[table].model_fields.items() if field.is_required())
        own = _OF_A_PIN if table == _PIN else tuple(name for name in needed if name not in _OF_EACH)
        yield from (f"{table}.{name}" for name in (*own, *_OF_EACH))


def _question(known: Known, key: str) -> str:
    blank = blanks_of(known.kind)[key]
    doubts = [f"{doubt.value}: {doubt.why}" for doubt in known.doubts.get(key, [])]
    yes = ["enter y to accept"] if known.offered(key) else []
    told = "; ".join([*(doubts or [f"such as {blank.value}"]), *yes, "press Enter to skip"])
    return f"{key}, {blank.words}{_MORE_WORDS.get(key, '')} ({told})"

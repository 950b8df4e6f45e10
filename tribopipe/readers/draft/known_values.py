"""What is known of a run before its run.toml is written: by key, and by whose word."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from datetime import date, datetime
from typing import Any, NamedTuple

from pydantic import ValidationError

from tribopipe.base.errors import did_you_mean
from tribopipe.documents.contact import CurvedDisc, FlatDisc, Pin, PinOnDisc, Specimen
from tribopipe.documents.manifest import MANIFEST_SCHEMA, Conditions, EndValues, RunManifest, Sensors, StatedFriction
from tribopipe.documents.record import Record, first_problem
from tribopipe.readers.draft.toml import value_of

Values = Mapping[str, Any]
"""By dotted key of run.toml, as run.toml writes them."""

SECTIONS: dict[str, type[Record]] = {
    "": RunManifest,
    "contact": PinOnDisc,
    "contact.pin": Pin,
    "contact.disc": Specimen,
    "contact.curved_disc": CurvedDisc,
    "contact.flat_disc": FlatDisc,
    "conditions": Conditions,
    "conditions.friction": StatedFriction,
    "end_values": EndValues,
    "sensors": Sensors,
}
"""Tables of run.toml that are filled key by key."""
_ELSEWHERE = ("schema", "schema_version", "id", "signals", "interruptions")
"""Keys of run.toml that are not among the values."""
BODIES = {
    "pin-on-disc": ("contact.pin", "contact.disc"),
    "twin-disc": ("contact.curved_disc", "contact.flat_disc"),
}
"""Tables of the two bodies by the type of tribometer."""
_STAND_INS = {
    "material": "unknown",
    "youngs_modulus": "1 GPa",
    "poisson_ratio": 0.3,
    "shape": "spherical",
    "radius": "1 km",
    "flat_radius": "1 nm",
    "rolling_radius": "1 km",
    "crown_radius": "1 km",
}
"""In the place of what is not known yet, where what is known is checked: nothing that could be known is larger."""
LOAD = "conditions.normal_load"


class Given(NamedTuple):
    """A value, and who says so; nobody beside the person who makes the run where that is empty."""

    value: Any
    origin: str = ""


class Doubt(NamedTuple):
    """A value that is not taken, and why."""

    value: Any
    why: str


@dataclass
class Known:
    """What is known of a run, and what was told but cannot be taken."""

    given: dict[str, Given] = field(default_factory=dict)
    doubts: dict[str, list[Doubt]] = field(default_factory=dict)

    @property
    def values(self) -> dict[str, Any]:
        """Values by key."""
        return {key: given.value for key, given in self.given.items()}

    @property
    def kind(self) -> str:
        """Type of tribometer."""
        return _kind(self.values)

    @property
    def lacks(self) -> list[str]:
        """Keys without which a run.toml cannot be processed."""
        needed = [LOAD]
        if self.kind == "twin-disc" and "conditions.flat_disc_speed" not in self.given:
            needed.append("conditions.slip")
        return [key for key in needed if key not in self.given]

    @property
    def bodies_lack(self) -> list[str]:
        """Keys without which the bodies are not described, so that wear cannot be computed."""
        return [key for key in _needed_of_bodies(self.values) if key not in self.given]

    def completed(self) -> "Known":
        """Give the same with stand-ins for what it lacks, by which everything else can be tried."""
        return replace(self, given=self.given | {key: Given(_stand_ins(self.values)[key]) for key in self.lacks})

    def problem(self, more: Values | None = None) -> str | None:
        """Say what is wrong with what is known, and more, whatever else may come; nothing where all fits."""
        return problem_of(self.values | dict(more or {}))

    def fits(self, key: str, value: Any) -> bool:
        """Tell whether a value could stand beside what is known, on this type of tribometer."""
        return self.problem({"contact.kind": self.kind, key: value}) is None

    def take(self, key: str, value: Any, origin: str = "") -> str | None:
        """Take a value where it fits, in the place of any before it, or say why it does not."""
        problem = _strange(key) or self.problem({key: value})
        if problem is None:
            self.given[key] = Given(value, origin)
            self.doubts.pop(key, None)
        return problem

    def take_text(self, key: str, text: str, origin: str = "") -> str | None:
        """Take a value from a text: a number, a date, or the text itself."""
        value = value_of(text)
        if isinstance(value, int | float | datetime | date) and self.take(key, value, origin) is None:
            return None
        return self.take(key, text, origin)

    def doubt(self, key: str, value: Any, why: str) -> None:
        """Keep a value that is not taken, for a comment."""
        self.doubts.setdefault(key, []).append(Doubt(value, why))


def problem_of(values: Values) -> str | None:
    """Say what is wrong with values by key, with stand-ins for what a whole run.toml needs beside them."""
    frame = {"schema": MANIFEST_SCHEMA, "id": "run", "signals": [{"file": "signals"}]}
    try:
        RunManifest.model_validate(nested(frame | _stand_ins(values) | dict(values)))
    except ValidationError as error:
        return first_problem(error, RunManifest)
    return None


def _stand_ins(values: Values) -> dict[str, Any]:
    used: dict[str, Any] = {LOAD: "1 N"}
    if any(key.startswith("contact.") for key in values):
        used["contact.kind"] = _kind(values)
        used |= {key: _STAND_INS[key.rpartition(".")[2]] for key in _needed_of_bodies(values)}
    if _kind(values) == "twin-disc" and "conditions.flat_disc_speed" in values:
        used["conditions.curved_disc_speed"] = "1 nm/s"
    elif _kind(values) == "twin-disc":
        used["conditions.slip"] = "1 %"
    return used


def _kind(values: Values) -> str:
    """Give the type of tribometer: a pin on a disc unless something is known of two discs."""
    discs = any(key.startswith(("contact.curved_disc.", "contact.flat_disc.")) for key in values)
    return str(values.get("contact.kind", "twin-disc" if discs else "pin-on-disc"))


def _needed_of_bodies(values: Values) -> list[str]:
    needed = [
        f"{body}.{name}"
        for body in BODIES.get(_kind(values), ())
        for name, key in SECTIONS[body].model_fields.items()
        if key.is_required()
    ]
    truncated = values.get("contact.pin.shape") == "truncated-sphere"
    return [*needed, "contact.pin.flat_radius"] if truncated else needed


def _strange(key: str) -> str | None:
    """Say why a key is none that can be filled."""
    table, _, name = key.rpartition(".")
    names = {field.alias or name for name, field in SECTIONS.get(table, RunManifest).model_fields.items()}
    if key in SECTIONS or key in _ELSEWHERE or table not in SECTIONS:
        example = f"{key}.{next(iter(SECTIONS[key].model_fields))}" if key in SECTIONS else LOAD
        return f"{key}: found what is no key to be filled; expected one such as {example}"
    return None if name in names else f"{key}: unknown key; {did_you_mean(name, names)}"


def nested(values: Values) -> dict[str, Any]:
    """Turn values by dotted key into the document that they are of."""
    document: dict[str, Any] = {}
    for key, value in values.items():
        *tables, name = key.split(".")
        inner = document
        for table in tables:
            inner = inner.setdefault(table, {})
        inner[name] = value
    return document


def flat(document: Mapping[str, Any], table: str = "") -> dict[str, Any]:
    """Turn a document, or one table of it, into values by dotted key."""
    values: dict[str, Any] = {}
    for name, value in document.items():
        key = f"{table}.{name}" if table else name
        values |= flat(value, key) if key in SECTIONS and isinstance(value, Mapping) else {key: value}
    return values

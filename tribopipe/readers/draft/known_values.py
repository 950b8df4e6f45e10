"""Values known about a run before its run.toml is written, by key, with the source of each.

With how single values are written as TOML, and read from what a person types.
"""

import json
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from datetime import date, datetime, time
from functools import cache, partial
from typing import Annotated, Any, NamedTuple, cast, get_args

from pydantic import TypeAdapter, ValidationError

from tribopipe.base.errors import UnitError, did_you_mean
from tribopipe.base.units import with_point
from tribopipe.documents.contact_kinds import ASSUMED, contact_named, contacts
from tribopipe.documents.manifest import MANIFEST_SCHEMA, Conditions, EndValues, RunManifest, Sensors, StatedFriction
from tribopipe.documents.record import Record, first_problem, quoted

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
_LONGEST_COMMENT = 200


def toml(value: Any) -> str:
    """Write a value as TOML does."""
    if isinstance(value, str):
        return quoted(value)
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{toml_key(key)} = {toml(inner)}' for key, inner in value.items())} }}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(toml, value))}]"
    if isinstance(value, datetime | date | time):
        return value.isoformat()
    return json.dumps(value)


def toml_key(key: str) -> str:
    """Write a key, in quotes where it needs them."""
    return key if _BARE_KEY.fullmatch(key) else quoted(key)


def one_line(text: str) -> str:
    """Write a text in one line, without control characters."""
    return " ".join("".join(sign if sign.isprintable() else " " for sign in text).split())


def comment(text: str) -> str:
    """Write a text so that it can stand behind #."""
    plain = one_line(text)
    return plain if len(plain) <= _LONGEST_COMMENT else plain[: _LONGEST_COMMENT - 1] + "…"


def value_of(text: str) -> Any:
    """Give the value that a text is in TOML: 0.24, 2006-03-01, { value = "50 N" }; the text itself where it is none."""
    try:
        document = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return document["value"] if list(document) == ["value"] else text


Values = Mapping[str, Any]
"""Values by dotted key of run.toml, as written in run.toml."""

_SECTIONS: dict[str, type[Record]] = {
    "": RunManifest,
    "contact": ASSUMED,
    "conditions": Conditions,
    "conditions.friction": StatedFriction,
    "end_values": EndValues,
    "sensors": Sensors,
}
_ELSEWHERE = ("schema", "schema_version", "id", "signals", "interruptions")
"""Keys of run.toml that are not among the values."""


@cache
def sections() -> Mapping[str, type[Record]]:
    """Return the tables of run.toml that are filled key by key."""
    bodies = {
        f"contact.{name}": cast("type[Record]", kind.model_fields[name].annotation)
        for kind in contacts().values()
        for name in kind.body_names
    }
    return _SECTIONS | bodies


def bodies_of(kind: str) -> tuple[str, ...]:
    """Return the tables of the two bodies on a type of tribometer; none of a type that is not installed."""
    contact = contact_named(kind)
    return () if contact is None else tuple(f"contact.{name}" for name in contact.body_names)


def needed_bodies_of(kind: str) -> tuple[str, ...]:
    """Return the tables of the bodies that a run.toml has to describe."""
    contact = contact_named(kind)
    like = () if contact is None else contact.like
    return tuple(table for table in bodies_of(kind) if table.removeprefix("contact.") not in like)


def needed_conditions_of(kind: str) -> list[str]:
    """Return the conditions that a type of tribometer needs in addition to the load."""
    contact = contact_named(kind)
    return [] if contact is None else [f"conditions.{name}" for name in contact.needed_conditions]


def replaced_conditions_of(kind: str) -> dict[str, str]:
    """Return the conditions that a type of tribometer needs unless another is stated, and that other one."""
    replaced = getattr(contact_named(kind), "replaced_conditions", {})
    return {f"conditions.{key}": f"conditions.{instead}" for key, instead in replaced.items()}


def speed_key_of(kind: str) -> str:
    """Return the key that states the speed by which the progress of wear follows from time."""
    contact = contact_named(kind) or ASSUMED
    return f"conditions.{contact.progress.speed}"


def track_key_of(kind: str) -> str:
    """Return the key that states the radius of the track on a type of tribometer."""
    return (contact_named(kind) or ASSUMED).track_key or "conditions.track_radius"


def counterbody_key(key: str, kind: str) -> str:
    """Return a key of the disc as the type of tribometer calls the counterbody of its pin."""
    pin, other = bodies_of(kind) or ("", "")
    return key.replace("contact.disc.", f"{other}.") if pin == "contact.pin" else key


def run_key(key: str, kind: str) -> str:
    """Return a key as a run.toml of a type of tribometer has it."""
    contact = contact_named(kind)
    return key if contact is None or not key.startswith("end_values.") else contact.worded(key)


def run_words(words: str, kind: str) -> str:
    """Return words about the bodies of a type of tribometer in the names that it has for them."""
    contact = contact_named(kind)
    return words if contact is None else contact.worded(words)


def shared_key(key: str) -> str:
    """Return a key as all types of tribometer of a family share it."""
    table, dot, name = key.rpartition(".")
    for kind in contacts().values() if table == "end_values" else ():
        ends = kind.completed({table: {name: None}})
        name = next(iter(ends[table]))
    return f"{table}{dot}{name}"


_STAND_INS = {
    "material": "unknown",
    "youngs_modulus": "1 GPa",
    "poisson_ratio": 0.3,
    "shape": "spherical",
    "radius": "1 km",
    "flat_radius": "1 nm",
    "rolling_radius": "1 km",
    "crown_radius": "1 km",
    "stroke": "1 km",
    "slip": "1 %",
    "curved_disc_speed": "1 nm/s",
}
"""Stand-ins for unknown values in checks of the known ones; no possible length is larger."""
LOAD = "conditions.normal_load"
_ALIKE = 0.1
"""Largest difference between two suggested values of one key that agree, relative to the larger one."""


class Given(NamedTuple):
    """A value, and who states it; if that is empty, the person who makes the run."""

    value: Any
    origin: str = ""


class Doubt(NamedTuple):
    """A value that is not taken, and why."""

    value: Any
    why: str
    offered: bool = False
    """Whether it may be accepted as it is."""


@dataclass
class Known:
    """Known values of a run, and values that were given but cannot be used."""

    given: dict[str, Given] = field(default_factory=dict)
    doubts: dict[str, list[Doubt]] = field(default_factory=dict)
    of_headers: set[str] = field(default_factory=set)
    """Keys that headers state."""
    of_tables: set[str] = field(default_factory=set)
    """Keys that a table of measured values states."""
    dissent: list[str] = field(default_factory=list)
    """Contradictions to known values."""

    @property
    def values(self) -> dict[str, Any]:
        """Values by key."""
        return {key: given.value for key, given in self.given.items()}

    @property
    def kind(self) -> str:
        """Type of tribometer."""
        return _kind(self.values)

    @property
    def missing(self) -> list[str]:
        """Keys without which a run.toml cannot be processed."""
        needed = [LOAD, *needed_conditions_of(self.kind)]
        needed += [key for key, instead in replaced_conditions_of(self.kind).items() if instead not in self.given]
        return [key for key in needed if key not in self.given]

    @property
    def bodies_lack(self) -> list[str]:
        """Keys without which the bodies are not described, so that wear cannot be computed."""
        return [key for key in _needed_of_bodies(self.values) if key not in self.given]

    def completed(self) -> "Known":
        """Give the same with stand-ins for what is missing, by which everything else can be tried."""
        return replace(self, given=self.given | {key: Given(_stand_ins(self.values)[key]) for key in self.missing})

    @property
    def conditions(self) -> Conditions:
        """Conditions as far as they are known, with the track radius that known bodies determine."""
        document, contact = nested(self.completed().values), contact_named(self.kind)
        completed = document if contact is None else contact.completed(document)
        return Conditions.model_validate(completed["conditions"])

    def problem(self, more: Values | None = None) -> str | None:
        """Report what is wrong with what is known, and more, whatever else may come; nothing where all fits."""
        return problem_of(self.values | dict(more or {}))

    def fits(self, key: str, value: Any) -> bool:
        """Return whether a value could stand next to what is known, on this type of tribometer."""
        return _refusal(self.values | {"contact.kind": self.kind, key: value}) is None

    def take(self, key: str, value: Any, origin: str = "") -> str | None:
        """Take a value where it fits, in the place of any before it, or report why it does not."""
        key = shared_key(key)
        problem = _strange(key, self.kind) or self.problem({key: value})
        if problem is None:
            self.given[key] = Given(value, origin)
            self.doubts.pop(key, None)
        return problem

    def take_text(self, key: str, text: str, origin: str = "") -> str | None:
        """Take a value from a text: a number, a date, or the text itself."""
        value = value_of(text)
        if not isinstance(value, int | float | datetime | date):
            return self.take(key, text, origin)
        problem = self.take(key, value, origin)
        if problem is None or _is_a_number(shared_key(key)):
            return problem
        return self.take(key, text, origin)

    def take_typed(self, key: str, text: str) -> str | None:
        """Take a value as a person types it, with a decimal comma perhaps: "0,1 m/s"."""
        problem = self.take_text(key, text)
        if problem is None:
            return None
        try:
            written = with_point(text)
        except UnitError as error:
            return f"{key}: {error}"
        return problem if written == text else self.take_text(key, written)

    def doubt(self, key: str, value: Any, why: str) -> None:
        """Keep a value that is not taken, for a comment."""
        self.doubts.setdefault(key, []).append(Doubt(value, why))

    def offer(self, key: str, value: Any, why: str) -> None:
        """Keep a value that is not taken unless a person accepts it."""
        self.doubts.setdefault(key, []).append(Doubt(value, why, offered=True))

    def object(self, key: str, other: str) -> None:
        """Note what contradicts a value that is known."""
        given = self.given[key]
        self.dissent.append(
            f"{key}: found {given.value} {given.origin or 'as stated'}, but {other}; expected both to agree; "
            "check which one is correct"
        )

    def offered(self, key: str) -> Doubt | None:
        """Return what is offered for a key, the first of what agrees; none where something else is stated, too."""
        found = self.doubts.get(key, [])
        if not found or not all(one.offered and alike(key, found[0].value, one.value) for one in found):
            return None
        return found[0]

    def in_dispute(self) -> list[str]:
        """Name the keys for which different values are offered, so that none is taken."""
        return [
            f"{key} is not filled in: " + "; ".join(f"{one.value}, {one.why}" for one in found)
            for key, found in self.doubts.items()
            if key not in self.given and len(found) > 1 and self.offered(key) is None
        ]

    def accept(self) -> list[str]:
        """Take what is offered and fits; return what was taken, with where it comes from."""
        taken = []
        for key in list(self.doubts):
            offer = self.offered(key)
            if (
                offer is not None
                and key not in self.given
                and self.take(key, offer.value, f"{offer.why}, accepted") is None
            ):
                taken.append(f"{key} = {offer.value}, {offer.why}")
        return taken


def alike(key: str, one: Any, other: Any, within: float = _ALIKE) -> bool:
    """Return whether two values of a key differ by no more than a share of the larger one."""
    table, _, name = key.rpartition(".")
    rules = sections()[table].model_fields[name]
    written: Any = Annotated[rules.annotation, *rules.metadata] if rules.metadata else rules.annotation
    reads: TypeAdapter[Any] = TypeAdapter(written)
    try:
        first, second = (reads.validate_python(value).value for value in (one, other))
    except (ValidationError, AttributeError):
        return bool(one == other)
    return bool(abs(first - second) <= within * max(abs(first), abs(second)))


def problem_of(values: Values) -> str | None:
    """Report what is wrong with values by key, with stand-ins for what a whole run.toml needs next to them."""
    refused, document = _refusal(values), nested(values)
    return None if refused is None else first_problem(refused, RunManifest, partial(RunManifest.known_in, document))


def _refusal(values: Values) -> ValidationError | None:
    frame = {"schema": MANIFEST_SCHEMA, "id": "run", "signals": [{"file": "signals"}]}
    try:
        RunManifest.model_validate(nested(frame | _stand_ins(values) | dict(values)))
    except ValidationError as error:
        return error
    return None


def _stand_in(key: str) -> Any:
    table, _, name = key.rpartition(".")
    return _STAND_INS[name] if name in _STAND_INS else example_of(sections()[table], name)


def example_of(record: type[Record], name: str) -> Any:
    """Return a value that a field of a record could have: the example of its kind of quantity, or a text."""
    schema = record.model_json_schema()["properties"][name]
    return (schema.get("examples") or ["…"])[0]


def _stand_ins(values: Values) -> dict[str, Any]:
    used: dict[str, Any] = {LOAD: "1 N"}
    if any(key.startswith("contact.") for key in values):
        kind = used["contact.kind"] = _kind(values)
        used |= {key: _stand_in(key) for key in (*needed_conditions_of(kind), *_needed_of_bodies(values))}
    for key, instead in replaced_conditions_of(kind := _kind(values)).items():
        missing = speed_key_of(kind) if instead in values else key
        used[missing] = _stand_in(missing)
    return used


def _kind(values: Values) -> str:
    """Give the type of tribometer: a pin on a disc, unless known values are of bodies that it does not have."""
    if "contact.kind" in values:
        return str(values["contact.kind"])
    tables = {key.rpartition(".")[0] for key in values}
    tables -= set(bodies_of(next(iter(contacts()))))
    described = {kind: sum(table in tables for table in bodies_of(kind)) for kind in contacts()}
    return max(described, key=lambda kind: described[kind])


def _needed_of_bodies(values: Values) -> list[str]:
    needed = [
        f"{body}.{name}"
        for body in needed_bodies_of(_kind(values))
        for name, key in sections()[body].model_fields.items()
        # A radius beside a stated diameter is half of it, or its own mistake.
        if key.is_required() and not (name == "radius" and f"{body}.diameter" in values and body != "contact.pin")
    ]
    truncated = values.get("contact.pin.shape") == "truncated-sphere"
    return [*needed, "contact.pin.flat_radius"] if truncated else needed


def _is_a_number(key: str) -> bool:
    """Return whether a key of run.toml holds a number that no text can be."""
    table, _, name = key.rpartition(".")
    field = sections()[table].model_fields.get(name) if table in sections() else None
    kinds = () if field is None else get_args(field.annotation) or (field.annotation,)
    return float in (getattr(kind, "__origin__", kind) for kind in kinds)


def _strange(key: str, kind: str) -> str | None:
    """Report why a key is none that can be filled, with those of a type of tribometer."""
    table, _, name = key.rpartition(".")
    names = {field.alias or name for name, field in sections().get(table, RunManifest).model_fields.items()}
    if key in sections() or key in _ELSEWHERE or table not in sections():
        example = f"{key}.{next(iter(sections()[key].model_fields))}" if key in sections() else LOAD
        return f"{key}: found a key that cannot be set; expected a key such as {example}"
    own = RunManifest.known_in({"contact": {"kind": kind}}, names)
    return None if name in names else f"{key}: unknown key; {did_you_mean(name, own)}"


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
        values |= flat(value, key) if key in sections() and isinstance(value, Mapping) else {key: value}
    return values

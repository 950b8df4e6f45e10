r"""Anton Paar and CSM tribometers: the tab-separated text that TRB³, nano tribometer and their forerunners export.

    Time [s]\tDistance [m]\tLaps\tSequence ID\tCycle ID\tMax Linear Speed [m/s]\tNominal Load [N]\tµ\tAngle [°]\t…
    0.05\t0.001\t0.01\t1\t1\t0.1\t5\t0.153\t12.4\t…

* One row of names with units in brackets; tabs; decimal point or comma; UTF-8 with a byte order mark, UTF-16 or cp1252.
* TRB³: forces in N; Friction Force, Temperature, Humidity and Penetration Depth (wear of both bodies, µm) follow.
* Nano tribometer: forces in mN, small letters ("laps", "Friction force [mN]"), and Normal force [mN] as measured.
* Rotating tests have Angle [°], reciprocating ones Linear Position [mm]; Max Linear Speed is the highest of a cycle.
* Older exports, or trimmed ones, name columns `Time`, `Distance`, `Laps`, `mu`, `FrictionForce`, with stray blanks and
  without units: time is in s and distance in m, but the force may be in N or mN, so that its unit is left open.
* Signs beyond ASCII may be lost, to "?" above all: "?" alone is µ, "[?m]" is µm, "[?C]" is °C.
* Lines above may show settings as `key: value` or `key\tvalue`.

Apart from the nano tribometer the load is not measured: Nominal Load is what was set, no signal; where it is one
value throughout, it is a fact of the run. Columns may come in any order, and others with these.
"""

import re
from collections.abc import Iterator, Set
from dataclasses import replace

import numpy as np

from tribopipe.base.errors import UnitError
from tribopipe.base.units import is_unit, parse
from tribopipe.documents.signals import SignalName
from tribopipe.readers.headed_tables import HeaderRowReader, bare_key, moment
from tribopipe.readers.reader import ReadColumn, ReadTable

_SEPARATOR = "\t"
_FRICTION_COEFFICIENTS = ("µ", "μ", "mu", "âμ", "?", "\ufffd", "cof", "frictioncoefficient", "coefficientoffriction")
_SIGNALS: dict[str, SignalName] = {
    "time": "time",
    "distance": "sliding_distance",
    **dict.fromkeys(_FRICTION_COEFFICIENTS, "friction_coefficient"),
    "normalforce": "normal_force",
    "frictionforce": "friction_force",
    "temperature": "temperature",
    "humidity": "relative_humidity",
    "penetrationdepth": "depth",
}
_MARKS = frozenset({"time", "distance", "laps"})
_FRICTION = frozenset({*_FRICTION_COEFFICIENTS, "frictionforce"})
_BY_DEFINITION = {"time": "s", "distance": "m", "laps": "1", **dict.fromkeys(_FRICTION_COEFFICIENTS, "1")}
_LOST_SIGNS = {"?m": "um", "?C": "degC", "?": "deg"}
_SETTING = re.compile(r"(?P<key>[^:\s][^:\t]{0,38}[^:\s])(?:\s*:|[^\S\t]*\t)\s*+(?P<value>\S.*)", re.DOTALL)
_QUANTITY = re.compile(r"(?P<number>[+-]?\d+(?:[.,]\d+)?)\s*\[?(?P<unit>[^\[\]]{1,40}?)\]?")
_QUANTITIES = {
    "normal load": ("conditions.normal_load", "force"),
    "nominal load": ("conditions.normal_load", "force"),
    "radius": ("conditions.track_radius", "length"),
    "lin. speed": ("conditions.sliding_speed", "speed"),
    "linear speed": ("conditions.sliding_speed", "speed"),
    "temperature": ("conditions.temperature", "temperature"),
    "humidity": ("conditions.relative_humidity", "percentage"),
}
_TEXTS = {"atmosphere": "conditions.medium", "operator": "operator", "user": "operator", "instrument": "instrument"}
_MODEL = re.compile("TRB ?[3³]|(?:Ultra )?Nano ?Tribometer", re.IGNORECASE)
_OF_ROTATION = ("conditions.track_radius", "conditions.sliding_speed")


class AntonPaarReader(HeaderRowReader):
    """Exports of Anton Paar's and CSM's tribometers."""

    name = "anton-paar"
    title = "Anton Paar and CSM tribometers (TRB³, nano, older ones)"
    separator = _SEPARATOR
    sought = "with Time, Distance, Laps and µ or Friction Force, separated by tabs"
    whose = "an Anton Paar or CSM tribometer"

    def is_header(self, line: str, names: Set[str]) -> bool:  # noqa: ARG002
        """Judge by the names alone."""
        return names >= _MARKS and bool(names & _FRICTION)

    def understood(self, table: ReadTable, lines: list[str], at: int) -> ReadTable:
        """Return the table with signals, units and facts of the header."""
        columns = tuple(map(_with_meaning, table.columns))
        facts = _header_facts(lines[:at], columns) | _column_facts(columns)
        return replace(table, columns=columns, notes=(*table.notes, *_notes(table.columns, columns)), facts=facts)


def _with_meaning(column: ReadColumn) -> ReadColumn:
    key = bare_key(column.name)
    unit = _mended_unit(column.name) or column.unit or _BY_DEFINITION.get(key)
    return replace(column, unit=unit, signal=_SIGNALS.get(key))


def _mended_unit(name: str) -> str | None:
    """Give the unit of a name whose signs beyond ASCII were lost or decoded twice."""
    written = re.search(r"\[([^\[\]]*)\]$", name)
    unit = written[1].replace("\ufffd", "?").replace("Â", "") if written else ""
    return _LOST_SIGNS.get(unit) or (unit if unit and is_unit(unit) else None)


def _notes(written: tuple[ReadColumn, ...], columns: tuple[ReadColumn, ...]) -> Iterator[str]:
    assumed = [
        f"{column.name} in {column.unit}"
        for before, column in zip(written, columns, strict=True)
        if before.unit is None and column.signal in ("time", "sliding_distance")
    ]
    if assumed:
        yield f"the file contains no units; the usual units of these tribometers are assumed: {', '.join(assumed)}"
    open_force = next((column for column in columns if column.signal == "friction_force" and not column.unit), None)
    if open_force is not None:
        yield f"{open_force.name!r} may be in N or mN; map it with its unit in run.toml"
    loads, _ = _set_values(columns, "nominalload")
    if len(loads) > 1:
        yield f"the nominal load has {len(loads)} values from {min(loads):g} to {max(loads):g}"


def _set_values(columns: tuple[ReadColumn, ...], key: str) -> tuple[list[float], str | None]:
    """Give the values that a setting takes, each once, and their unit; none where it is not in the file."""
    column = next((each for each in columns if bare_key(each.name) == key and each.first_bad is None), None)
    if column is None:
        return [], None
    return [float(value) for value in np.unique(column.values) if np.isfinite(value)], column.unit


def _column_facts(columns: tuple[ReadColumn, ...]) -> dict[str, str]:
    """Give load and speed where they are set to the same throughout."""
    facts = {}
    for key, fact in (("nominalload", "conditions.normal_load"), ("maxlinearspeed", "conditions.sliding_speed")):
        values, unit = _set_values(columns, key)
        if unit and len(values) == 1 and values[0] > 0:
            facts[fact] = f"{values[0]:.12g} {unit}"
    return _without_rotation(facts, columns)


def _without_rotation(facts: dict[str, str], columns: tuple[ReadColumn, ...]) -> dict[str, str]:
    """Leave out radius and speed unless the pin is known to run in a circle: else it has the one at times only."""
    if any(bare_key(column.name) == "angle" for column in columns):
        return facts
    return {key: value for key, value in facts.items() if key not in _OF_ROTATION}


def _header_facts(lines: list[str], columns: tuple[ReadColumn, ...]) -> dict[str, str]:
    """Give what the lines above the names state about the run, where they state it once."""
    settings: dict[str, set[str]] = {}
    for line in lines:
        setting = _SETTING.fullmatch(line.strip())
        if setting is not None:
            settings.setdefault(setting["key"].casefold(), set()).add(setting["value"])
    once = {key: values.pop() for key, values in settings.items() if len(values) == 1}
    facts = {fact: once[key] for key, fact in _TEXTS.items() if key in once}
    for key, (fact, kind) in _QUANTITIES.items():
        quantity = _quantity(once.get(key, ""), kind)
        if quantity is not None:
            facts[fact] = quantity
    started = moment(f"{once.get('date', '')} {once.get('time', '')}")
    model = _MODEL.search("".join(lines))
    if started is not None:
        facts["started"] = started
    if model is not None:
        facts.setdefault("instrument", f"Anton Paar {model[0]}")
    return _without_rotation(facts, columns)


def _quantity(text: str, kind: str) -> str | None:
    """Write "5,00 [N]" as run.toml does; none where it is no such quantity."""
    found = _QUANTITY.fullmatch(text)
    if found is None:
        return None
    quantity = f"{found['number'].replace(',', '.')} {found['unit']}"
    try:
        parse(quantity, kind)
    except UnitError:
        return None
    return quantity

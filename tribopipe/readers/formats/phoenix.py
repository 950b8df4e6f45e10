"""Phoenix Tribology Compend (TE67, TE77 and others): the tab-separated file of a test.

    Data file⟨TAB⟩⟨TAB⟩TEST_2.TSV
    Configuration file⟨TAB⟩…, Calibration file⟨TAB⟩…, Test control file⟨TAB⟩…, number, operator
    Test started at 20:09:56 on 2019-04-09
    ⟨TAB⟩Time⟨TAB⟩This Step⟨TAB⟩Step Time⟨TAB⟩…⟨TAB⟩Mass⟨TAB⟩Load⟨TAB⟩TOTAL REVOLUTIONS⟨TAB⟩…⟨TAB⟩Friction Force
    ⟨TAB⟩1⟨TAB⟩1⟨TAB⟩3600,⟨TAB⟩…

* Names and rows begin with a tab. Decimal commas; a number may end in one ("3600,").
* The header holds no units. They are those of the program: m/s, rpm, g, N, °C, mV, mm, m, µm, s. Each is taken where
  the identities it appears in hold with it (m·g = F_N, F_f/F_N = μ, 2πR·n = v, 2πR·N = s, ds/dt = v), and left open
  where they do not; no identity contains the displacement.
* What somebody wrote in square brackets behind a name is its unit; text that is none is reported and leaves it open.
* Two columns may have one name. Of two friction forces the one for which F_f/F_N = μ holds is taken.
* This Step numbers the steps of the test. Radius is a whole number of mm.
"""

import re
from collections.abc import Mapping, Sequence, Set
from dataclasses import replace

import numpy as np

from tribopipe.base.units import is_unit, is_unit_of, to_si
from tribopipe.documents.signals import SignalName
from tribopipe.physics.identities import Identity, Role, ratios
from tribopipe.readers.column_meanings import NEAR, roles_of, unit_kind
from tribopipe.readers.headed_tables import HeaderRowReader, bare_key, cells_of
from tribopipe.readers.reader import ReadColumn, ReadTable
from tribopipe.readers.tables import is_number
from tribopipe.readers.text import Text

_SEPARATOR = "\t"
_MARKS = frozenset({"thisstep", "steptime", "testtime"})
_UNITS = {
    "time": "s",
    "steptime": "s",
    "testtime": "s",
    "slidingvelocity": "m/s",
    "speed": "rpm",
    "mass": "g",
    "load": "N",
    "totalrevolutions": "1",
    "specimentemp": "degC",
    "contactpotential": "mV",
    "radius": "mm",
    "distance": "m",
    "frictionforce": "N",
    "frictioncoefficient": "1",
    "displacement": "um",
}
_SIGNALS: dict[str, SignalName] = {
    "time": "time",
    "slidingvelocity": "sliding_speed",
    "load": "normal_force",
    "distance": "sliding_distance",
    "frictionforce": "friction_force",
    "frictioncoefficient": "friction_coefficient",
    "displacement": "depth",
    "specimentemp": "temperature",
}
_LONE_COMMA = re.compile(rb"(?<=\d),(?=[ \t\r\n])")
_IN_BRACKETS = re.compile(r"\[([^\[\]]*)\](?: \(\d+\))?$")
_STARTED = re.compile(r"Test started at (\d{1,2}:\d\d:\d\d) on (\d{4}-\d\d-\d\d)")
_MOST_ROWS = 100_000


class PhoenixReader(HeaderRowReader):
    """Files of Phoenix Tribology's Compend."""

    name = "phoenix-compend"
    title = "Phoenix Tribology Compend (TE67, TE77; .tsv)"
    suffixes = (".tsv",)
    separator = _SEPARATOR
    sought = "with This Step, Step Time and Test Time"
    whose = "a Compend file"

    def is_header(self, line: str, names: Set[str]) -> bool:
        """Judge by a tab before the names as well."""
        return line.startswith(_SEPARATOR) and names >= _MARKS

    def prepared(self, text: Text) -> Text:
        """Leave out commas behind which nothing stands."""
        return replace(text, content=_LONE_COMMA.sub(b"", text.content))

    def understood(self, table: ReadTable, lines: list[str], at: int) -> ReadTable:
        """Return the table with signals, units and the start of the test."""
        columns, notes = _understood(table.columns)
        notes += _unknown_units(cells_of(lines[at], _SEPARATOR), at + 1)
        facts = {"instrument": "Phoenix Tribology (Compend)"} | _started(table.header)
        return replace(table, columns=columns, notes=(*table.notes, *notes), facts=facts)


def _key(column: ReadColumn) -> str:
    """Write a name bare, without the number that a second column of the same name was given."""
    return bare_key(re.sub(r" \(\d+\)$", "", column.name))


def _programs_unit(column: ReadColumn) -> str | None:
    """Return the unit that the program writes a column in; none where the header has one, whatever it means."""
    return None if _bracketed(column.name) else _UNITS.get(_key(column))


def _bracketed(name: str) -> str | None:
    """Return what stands in the brackets behind a name; none where there are none, or they are empty."""
    found = _IN_BRACKETS.search(name)
    return (found[1].strip() or None) if found else None


def _unknown_units(names: Sequence[str], line: int) -> list[str]:
    """Report which units of the header are none."""
    written = ((number, name, _bracketed(name)) for number, name in enumerate(names, start=1))
    return [
        f"line {line}, column {number}: {name!r} has the unknown unit {unit!r}; specify its unit in run.toml"
        for number, name, unit in written
        if unit is not None and not is_unit(unit)
    ]


def _understood(columns: Sequence[ReadColumn]) -> tuple[tuple[ReadColumn, ...], list[str]]:
    """Give columns their units and meanings, and report which units the recording contradicts."""
    told = [replace(one, unit=one.unit or _programs_unit(one)) for one in columns]
    friction = _friction_force(told)
    roles = _roles_with_units([one for one in told if _key(one) != "frictionforce" or one.name == friction])
    open_, notes = _contradicted(roles)
    meant: list[ReadColumn] = []
    for column in told:
        signal = _SIGNALS.get(_key(column))
        known = signal != "friction_force" or column.name == friction
        unit = None if column.name in open_ else column.unit
        meant.append(replace(column, unit=unit, signal=signal if known else None))
    if any(one.signal == "depth" and _bracketed(one.name) is None for one in meant):
        notes.append(
            "Displacement is assumed to be in µm, the unit used by the program; other columns cannot confirm this"
        )
    return tuple(meant), notes


def _roles_with_units(columns: Sequence[ReadColumn]) -> dict[Role, ReadColumn]:
    """Report which quantities columns are; those of other names than the program's have no unit, and are none."""
    return roles_of([one for one in columns if one.unit is not None])


def _friction_force(columns: Sequence[ReadColumn]) -> str | None:
    """Name the friction force that is μ times the load, or else the first one."""
    forces = [one for one in columns if _key(one) == "frictionforce"]
    others = _roles_with_units([one for one in columns if _key(one) != "frictionforce"])

    def misfit(force: ReadColumn) -> float:
        if not is_unit_of(force.unit or "", "force"):
            return np.inf
        values = _in_si({**others, "friction_force": force})
        return min((abs(ratio - 1) for one, ratio in ratios(values) if "friction_force" in one.roles), default=np.inf)

    return min(forces, key=misfit).name if forces else None


def _in_si(roles: Mapping[Role, ReadColumn]) -> dict[Role, np.ndarray]:
    return {
        role: np.asarray(to_si(_numbers(column), column.unit or "", unit_kind(role))) for role, column in roles.items()
    }


def _numbers(column: ReadColumn) -> np.ndarray:
    """Return the first rows of a column as numbers; NaN where one is none, so that its column can still be judged."""
    some = column.values[:_MOST_ROWS]
    if column.first_bad is None:
        return np.asarray(some, dtype=float)
    return np.array(
        [float(text) if is_number(text := str(one).strip(",").replace(",", "."), ".") else np.nan for one in some]
    )


def _contradicted(roles: Mapping[Role, ReadColumn]) -> tuple[set[str], list[str]]:
    """Name the columns of which no identity holds in these units, and report it."""
    held = dict(ratios(_in_si(roles)))
    good = {role for one, ratio in held.items() if abs(ratio - 1) <= NEAR for role in one.roles}
    broken = {one: ratio for one, ratio in held.items() if abs(ratio - 1) > NEAR}
    names = {roles[role].name for one in broken for role in one.roles if role not in good and role != "time"}
    notes = [
        f"{one.formula} does not hold in {_units_of(one, roles)}: the ratio of the left side to the right side is "
        f"{ratio:.3g}"
        for one, ratio in broken.items()
    ]
    listed = ", ".join(map(repr, sorted(names)))
    return names, notes + ([f"the units of {listed} are unknown; the header contains none"] if names else [])


def _units_of(identity: Identity, roles: Mapping[Role, ReadColumn]) -> str:
    return ", ".join(str(roles[role].unit) for role in identity.roles)


def _started(header: str) -> dict[str, str]:
    found = _STARTED.search(header)
    return {"started": f"{found[2]}T{found[1]:0>8}"} if found else {}

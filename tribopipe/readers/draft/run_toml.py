"""run.toml as a draft: what is known stands in it with its origin, what is not is a commented line with an example.

With the columns that are taken for signals, by whose word, and those that could be.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from textwrap import wrap
from typing import Any, NamedTuple

import numpy as np

from tribopipe.base.errors import ReaderError
from tribopipe.base.units import KINDS, is_unit_of, pretty, to_si
from tribopipe.documents.manifest import MANIFEST_SCHEMA
from tribopipe.documents.signals import AXES, SIGNALS, SignalName
from tribopipe.readers.column_mapping import contradiction, find_column
from tribopipe.readers.column_meanings import (
    NO_UNIT,
    UNKNOWN_UNIT,
    definitions_note,
    friction_definitions,
    may_be_friction,
)
from tribopipe.readers.draft.blanks import blanks_of
from tribopipe.readers.draft.known_values import (
    Known,
    alike,
    bodies_of,
    comment,
    needed_bodies_of,
    one_line,
    run_key,
    run_words,
    sections,
    toml,
    track_key_of,
)
from tribopipe.readers.draft.run_files import Group, StepOfFiles
from tribopipe.readers.draft.value_sources import rotational_speeds
from tribopipe.readers.export_files import Export
from tribopipe.readers.reader import ReadColumn


class Mapped(NamedTuple):
    """One line of [signals.columns]."""

    signal: SignalName
    column: ReadColumn
    by: str
    unit: str | None = None
    """Unit that takes precedence over that in the file."""
    doubt: str = ""
    """Why the line is commented out."""

    @property
    def code(self) -> str:
        """The line as TOML."""
        unit = KINDS[SIGNALS[self.signal].kind].shown if self.doubt == NO_UNIT else self.unit
        source = {"column": self.column.name, "unit": unit} if unit else self.column.name
        return f"{'# ' if self.doubt else ''}{self.signal} = {toml(source)}"

    @property
    def remark(self) -> str:
        """Return the comment after the line."""
        shown = pretty(self.unit or self.column.unit or "")
        return ", ".join(part for part in (shown, self.by, self.doubt) if part)


ONE_OF_SEVERAL = "one of"
_TELLS_SPEED: tuple[SignalName, ...] = ("sliding_speed", "sliding_distance", "rotations")


def mapped_columns(export: Export, told: Mapping[str, Any], told_by: str, track_lacks: str = "") -> list[Mapped]:
    """Map columns to signals by a template, as far as the file has those columns, and by their meanings.

    A rotational speed is the sliding speed where no other column shows how far the pin slides; ``track_lacks`` is the
    key of the radius of its track, if it is unknown.
    """
    found = [mapped for signal, source in told.items() if (mapped := _as_told(export, signal, source, told_by))]
    signals, names = {mapped.signal for mapped in found}, {mapped.column.name for mapped in found}
    for column in export.table.columns:
        meaning = export.meanings.get(column.name)
        if meaning is not None and meaning.signal not in signals and column.name not in names:
            found.append(Mapped(meaning.signal, column, meaning.by, doubt=meaning.doubt))
    turning = rotational_speeds(export)
    needed = f"needs {track_lacks}" if track_lacks else ""
    if len(turning) == 1 and not any(one.signal in _TELLS_SPEED and not one.doubt for one in found):
        found = [one for one in found if one.signal != "sliding_speed"]
        found.append(Mapped("sliding_speed", turning[0], "times the track radius", doubt=needed))
    found = _with_definitions(export, _with_open_units(export, found))
    order = list(SIGNALS)
    return sorted(found, key=lambda mapped: order.index(mapped.signal))


def _with_open_units(export: Export, found: list[Mapped]) -> list[Mapped]:
    """Propose the units that the header leaves open, by the identities that hold with them."""
    return [
        one._replace(unit=unit.unit, doubt=f"{NO_UNIT}; {unit.unit} is suggested by {unit.why}")
        if one.doubt == NO_UNIT and (unit := export.open_units.get(one.column.name))
        else one
        for one in found
    ]


def _with_definitions(export: Export, found: list[Mapped]) -> list[Mapped]:
    """Offer the columns that define friction differently, where none of them is taken."""
    names = [one.column for one in friction_definitions(export.table.columns)]
    found = [one for one in found if one.column.name not in names or not one.doubt.endswith(UNKNOWN_UNIT)]
    if any(one.signal == "friction_coefficient" for one in found):
        return found
    columns = {column.name: column for column in export.table.columns}
    doubt = f"{ONE_OF_SEVERAL} {len(names)} definitions of friction"
    return found + [Mapped("friction_coefficient", columns[name], "from its name", doubt=doubt) for name in names]


def units_contradicted(export: Export, told: Mapping[str, Any], told_by: str) -> Iterator[str]:
    """Report the units of a template that contradict those of a file."""
    for signal, source in told.items():
        mapped = _as_told(export, signal, source, "")
        why = contradiction(mapped.column, mapped.unit, told_by) if mapped else None
        if why:
            yield f"{export.name}: {why}"


def _as_told(export: Export, signal: Any, source: Any, told_by: str) -> Mapped | None:
    named = {"column": source} if isinstance(source, str) else source
    try:
        column = find_column(export.table, named["column"], signal, export.name)
    except ReaderError:
        return None
    return Mapped(signal, column, told_by + _contradicted(export, signal, column), named.get("unit"))


def _contradicted(export: Export, signal: SignalName, column: ReadColumn) -> str:
    """Name the column that the format itself takes for the signal, where that is another one."""
    other = next((one for one in export.table.columns if one.signal == signal and one.name != column.name), None)
    return "" if other is None else f"; the format defines {other.name!r} as this signal"


def unmapped_columns(export: Export, mapped: list[Mapped]) -> list[str]:
    """Name the columns that no signal is made of, with their units."""
    names = {one.column.name for one in mapped}
    return [
        f"{toml(column.name)} ({pretty(column.unit) or 'ratio' if column.unit else 'no unit'})"
        for column in export.table.columns
        if column.name not in names
    ]


_LARGEST_DEPTH_UNIT = 1e-4
"""m; positions are recorded in larger units."""


def depth_left_open(export: Export, told: Mapping[str, Any]) -> str | None:
    """Report columns of lengths that may be the depth, where no column is known to be it."""
    mapped = mapped_columns(export, told, "")
    if export.reader.holds != "signals" or any(one.signal == "depth" for one in mapped):
        return None
    found = [repr(column.name) for column in export.table.columns if column.unit and _is_small(column.unit)]
    if not found:
        return None
    return (
        f"{export.name}: no column was identified as the depth signal; if {' or '.join(found)} is the depth, map it to "
        "depth under [signals.columns]"
    )


def _is_small(unit: str) -> bool:
    return is_unit_of(unit, "length") and to_si(1.0, unit, "length") < _LARGEST_DEPTH_UNIT


def friction_left_open(export: Export, told: Mapping[str, Any]) -> str | None:
    """Report columns that define friction differently, or may be the friction where no column is known to be it."""
    if export.reader.holds != "signals":
        return None
    if note := definitions_note(export.table.columns, export.friction):
        return f"{export.name}: {note}"
    found = [repr(column.name) for column in export.table.columns if may_be_friction(column)]
    if not found or any(one.signal in _FRICTION for one in mapped_columns(export, told, "")):
        return None
    return (
        f"{export.name}: no column was identified as the friction signal; if {' or '.join(found)} is the friction, map "
        "it to friction_force or friction_coefficient under [signals.columns]"
    )


_FRICTION: tuple[SignalName, ...] = ("friction_force", "friction_coefficient")
_NEEDED: tuple[tuple[SignalName, ...], ...] = (AXES, _FRICTION, ("depth",))
"""Signals of which one at least is used where it was recorded."""
_MOST_NAMED = 3


def left_in_doubt(export: Export, draft: "Draft") -> Iterator[str]:
    """Report needed signals for which there are columns, none of which is used."""
    if export.reader.holds != "signals":
        return
    mapped = _with_strokes_in_doubt(mapped_columns(export, draft.columns, ""), draft)
    for signals in _NEEDED:
        found = [one for one in mapped if one.signal in signals]
        if not all(one.doubt for one in found):
            continue
        for one in [one for one in found if not one.doubt.startswith(ONE_OF_SEVERAL)][:_MOST_NAMED]:
            remedy = "" if one.column.first_bad else "; if it is correct, remove the # from its line in run.toml"
            yield (
                f"{export.name}: column {one.column.name!r} seems to be {one.signal} and is not used: "
                f"{one.doubt}{remedy}"
            )


_STROKE = "conditions.stroke"
_ABOUT_THE_STROKE = 0.2
"""Largest relative difference between a range and the stroke."""


def _with_strokes_in_doubt(mapped: Sequence[Mapped], draft: "Draft") -> list[Mapped]:
    """Doubt a displacement whose range is the stroke: it is the position of a body rather than its wear."""
    stroke = draft.known.given.get(_STROKE)
    if stroke is None or "depth" in draft.columns:
        return list(mapped)
    why = "its range is the stroke, so that it may be the position along the stroke"
    return [
        one._replace(doubt=why)
        if one.signal == "depth" and not one.doubt and alike(_STROKE, _range(one), stroke.value, _ABOUT_THE_STROKE)
        else one
        for one in mapped
    ]


def _range(mapped: Mapped) -> str:
    """Return the range of a recorded length, without single values far off."""
    values = mapped.column.values if mapped.column.first_bad is None else np.array([])
    low, high = np.nanpercentile(values, (1, 99)) if np.any(np.isfinite(values)) else (0.0, 0.0)
    return f"{high - low:.6g} {mapped.unit or mapped.column.unit}"


_WIDTH = 110
_WIDEST_CODE = 76
"""Maximum width of lines whose comments are aligned."""
_WITHOUT_BODIES = (
    "# The two bodies; without them, only friction is evaluated. Once you have described both bodies, remove the #",
    "# at the start of the names of these tables, and of the lines that apply: lines without a source are examples.",
)
_AFTERWARDS = "# Post-test measurements of the specimens; remove the # at the start of the lines that you fill in."


@dataclass(frozen=True)
class Draft:
    """Everything of which run.toml is made."""

    id: str
    groups: Sequence[Group]
    known: Known
    reader: str | None = None
    """Reader that a person named, by its name or its file."""
    template: str = "the template"
    """Name of the template for the following."""
    dialect: Mapping[str, str] = field(default_factory=dict)
    """Encoding, column and decimal separators of all files."""
    columns: Mapping[str, Any] = field(default_factory=dict)
    """Meanings of the columns."""
    sheet: str | None = None
    """Sheet of a workbook."""
    step: StepOfFiles | None = None
    """Step of which the run is made."""
    is_recorded: bool = True
    """Whether the files are a recording, and not only start and end of a test."""


class _Line(NamedTuple):
    code: str
    remark: str = ""


def manifest_text(draft: Draft) -> str:
    """Write run.toml."""
    known = draft.known
    head = [_Line(f"schema = {toml(MANIFEST_SCHEMA)}"), _Line(f"id = {toml(draft.id)}")]
    friction = "conditions.friction"
    parts = [
        _aligned([*head, *_lines(known, "")]),
        *_bodies(known),
        _table(known, "conditions"),
        *([_table(known, friction)] if _has(known, friction) else []),
        *(_signals(group, draft) for group in draft.groups),
        [_AFTERWARDS, *_table(known, "end_values", open_=_has(known, "end_values"))],
        _table(known, "sensors", open_=_has(known, "sensors")),
    ]
    return "\n\n".join("\n".join(part) for part in parts) + "\n"


def _has(known: Known, table: str) -> bool:
    return any(key.rpartition(".")[0] == table for key in known.given)


def _bodies(known: Known) -> list[list[str]]:
    """Write the tables of the bodies: open where they are all described, since half of them are none."""
    whole = not known.bodies_lack
    needed = needed_bodies_of(known.kind)
    bodies = (table for table in bodies_of(known.kind) if table in needed or _has(known, table))
    parts = [_table(known, table, open_=whole) for table in ("contact", *bodies)]
    return parts if whole else [[*_WITHOUT_BODIES, *parts[0]], *parts[1:]]


def _table(known: Known, table: str, *, open_: bool = True) -> list[str]:
    """Write one table; where it is not open, every line of it is a comment."""
    lines = [_Line(f"[{table}]"), *_lines(known, table)]
    if not open_:
        lines = [_Line(f"# {line.code.removeprefix('# ')}", line.remark) for line in lines]
    return _aligned(lines)


def _lines(known: Known, table: str) -> list[_Line]:
    """Write what is known, doubted or left open under a table."""
    every = dict.fromkeys([*blanks_of(known.kind), *known.given, *known.doubts])
    keys = [key for key in every if _table_of(key) == table]
    return [line for key in keys for line in _lines_of(known, key, table)]


def _table_of(key: str) -> str:
    """Name the table under which a key is written: the top for what run.toml has no table for."""
    table = key.rpartition(".")[0]
    return table if table in sections() else ""


def _lines_of(known: Known, key: str, table: str) -> Iterator[_Line]:
    # Without the bodies, nothing in run.toml says what the counterbody is called.
    named, blanks = key if known.bodies_lack else run_key(key, known.kind), blanks_of(known.kind)
    name = named.removeprefix(f"{table}.") if table else named
    doubts = known.doubts.get(key, [])
    for doubt in doubts:
        yield _Line(f"# {one_line(f'{name} = {toml(doubt.value)}')}", doubt.why)
    if key in known.given:
        given = known.given[key]
        yield _Line(f"{name} = {toml(given.value)}", given.origin)
    elif key == "contact.kind":
        yield _Line(f"{name} = {toml(known.kind)}", blanks[key].words if known.bodies_lack else "")
    elif key in blanks and not doubts and known.fits(key, blanks[key].value):
        own = run_key(key, known.kind)
        words = run_words(blanks[key].words, known.kind)
        yield _Line(f"# {own.removeprefix(f'{table}.') if table else own} = {blanks[key].example}", words)


def _aligned(lines: Sequence[_Line]) -> list[str]:
    """Write lines with their remarks below each other."""
    width = max((len(line.code) for line in lines if line.remark and len(line.code) <= _WIDEST_CODE), default=0)
    return [f"{line.code:<{width}}   # {comment(line.remark)}" if line.remark else line.code for line in lines]


def _signals(group: Group, draft: Draft) -> list[str]:
    """Write what run.toml states about consecutive files."""
    track_key = track_key_of(draft.known.kind)
    is_known = track_key in draft.known.given and not (track_key.startswith("contact.") and draft.known.bodies_lack)
    needed = "" if is_known else track_key
    first = group.first
    mapped = _with_strokes_in_doubt(mapped_columns(first, draft.columns, f"from {draft.template}", needed), draft)
    lines = [
        _Line("[[signals]]"),
        *_files(group),
        _Line(f"reader = {toml(draft.reader or first.reader.name)}", first.match.why),
        *(_Line(f"{name} = {toml(value)}", f"from {draft.template}") for name, value in draft.dialect.items()),
        *_part_of_file(draft),
    ]
    named = any(not one.doubt for one in mapped)
    columns = [_Line(f"{'' if named else '# '}[signals.columns]"), *(_Line(one.code, one.remark) for one in mapped)]
    return [*_aligned(lines), *_aligned(columns), *_unmapped(first, mapped)]


def _part_of_file(draft: Draft) -> Iterator[_Line]:
    """Write which sheet and step of the files the run is made of."""
    if draft.sheet is not None:
        yield _Line(f"sheet = {toml(draft.sheet)}")
    if draft.step is not None:
        yield _Line(f"step_column = {toml(draft.step.column)}")
        yield _Line(f"steps = [{draft.step.number}]")


def _files(group: Group) -> list[_Line]:
    if len(group.names) == 1:
        return [_Line(f"file = {toml(group.names[0])}", f"{group.rows:,} rows")]
    inside = [_Line(f"    {toml(name)},") for name in group.names]
    return [_Line("files = [", f"{len(group.names)} files, {group.rows:,} rows"), *inside, _Line("]")]


def _unmapped(export: Export, mapped: list[Mapped]) -> list[str]:
    names = ", ".join(unmapped_columns(export, mapped))
    told = f"Kept, but not used as signals: {one_line(names)}" if names else ""
    return [f"# {line}" for line in wrap(told, _WIDTH)]

"""Which columns of a file are taken for which signals, by whose word, and which could be."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from tribopipe.base.errors import ReaderError
from tribopipe.base.units import KINDS, pretty
from tribopipe.documents.signals import SIGNALS, SignalName
from tribopipe.readers.column_aliases import NO_UNIT
from tribopipe.readers.columns import find_column
from tribopipe.readers.draft.recorded import rotational_speeds
from tribopipe.readers.draft.toml import toml
from tribopipe.readers.export_files import Export
from tribopipe.readers.friction_definitions import definitions_note, friction_definitions
from tribopipe.readers.reader import ReadColumn


class Mapped(NamedTuple):
    """One line of [signals.columns]."""

    signal: SignalName
    column: ReadColumn
    by: str
    unit: str | None = None
    """Where somebody's word is to win over the file's own."""
    lacks: str = ""
    """Why the line is commented out."""

    @property
    def code(self) -> str:
        """The line as TOML."""
        unit = KINDS[SIGNALS[self.signal].kind].shown if self.lacks == NO_UNIT else self.unit
        source = {"column": self.column.name, "unit": unit} if unit else self.column.name
        return f"{'# ' if self.lacks else ''}{self.signal} = {toml(source)}"

    @property
    def remark(self) -> str:
        """What stands behind it."""
        shown = pretty(self.unit or self.column.unit or "")
        return ", ".join(part for part in (shown, self.by, self.lacks) if part)


_TELLS_SPEED: tuple[SignalName, ...] = ("sliding_speed", "sliding_distance", "rotations")
NO_RADIUS = "needs conditions.track_radius"


def mapped_columns(export: Export, told: Mapping[str, Any], told_by: str, *, on_track: bool = False) -> list[Mapped]:
    """Map columns to signals by a template, as far as the file has those columns, and by their meanings.

    A rotational speed is the sliding speed where no other column shows how far the pin slides; ``on_track`` states that
    the radius of its track is known.
    """
    found = [mapped for signal, source in told.items() if (mapped := _as_told(export, signal, source, told_by))]
    signals, names = {mapped.signal for mapped in found}, {mapped.column.name for mapped in found}
    for column in export.table.columns:
        meaning = export.meanings.get(column.name)
        if meaning is not None and meaning.signal not in signals and column.name not in names:
            found.append(Mapped(meaning.signal, column, meaning.by, lacks=meaning.lacks))
    turning = rotational_speeds(export)
    if len(turning) == 1 and not any(one.signal in _TELLS_SPEED and not one.lacks for one in found):
        found = [one for one in found if one.signal != "sliding_speed"]
        found.append(Mapped("sliding_speed", turning[0], "times the track radius", lacks="" if on_track else NO_RADIUS))
    found = _with_definitions(export, _with_open_units(export, found))
    order = list(SIGNALS)
    return sorted(found, key=lambda mapped: order.index(mapped.signal))


def _with_open_units(export: Export, found: list[Mapped]) -> list[Mapped]:
    """Propose the units that the header leaves open, by the identities that hold with them."""
    return [
        one._replace(unit=unit.unit, lacks=f"{NO_UNIT}; {unit.unit} is proposed by {unit.why}")
        if one.lacks == NO_UNIT and (unit := export.open_units.get(one.column.name))
        else one
        for one in found
    ]


def _with_definitions(export: Export, found: list[Mapped]) -> list[Mapped]:
    """Offer the columns that define friction differently, where none of them is taken."""
    if any(one.signal == "friction_coefficient" for one in found):
        return found
    columns = {column.name: column for column in export.table.columns}
    names = [one.column for one in friction_definitions(export.table.columns)]
    lacks = f"one of {len(names)} definitions of friction"
    return found + [Mapped("friction_coefficient", columns[name], "by its name", lacks=lacks) for name in names]


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
    return "" if other is None else f"; by the format it is {other.name!r}"


def unmapped_columns(export: Export, mapped: list[Mapped]) -> list[str]:
    """Name the columns that no signal is made of, with their units."""
    names = {one.column.name for one in mapped}
    return [
        f"{toml(column.name)} ({pretty(column.unit) or 'ratio' if column.unit else 'no unit'})"
        for column in export.table.columns
        if column.name not in names
    ]


def friction_left_open(export: Export) -> str | None:
    """Report which columns of a file define friction differently; nothing where there is one at most."""
    note = definitions_note(export.table.columns, export.friction) if export.reader.holds == "signals" else None
    return note and f"{export.name}: {note}"

r"""CETR / Bruker UMT, as its Data Viewer exports a test: a head and rows for each step, in one text.

    Created by CETR Data Viewer ver.2.19.106 05/12/22 14:43:46
    Created by CETR UMT ver.1.136.257 12 May 2022 12:21:50
    Total number of steps = 2
    ...
    Step No. 1

    Radius       = 3.9493
    Set Force    = -200
    Data Count   = 110
    Started at: 12:21:58.029 12 May 2022

    Fx,Fz,Z,Y,X,V1,V2,V3,T,Ff,COF
    g,g,mm,mm,mm,mm/sec,mm/sec,mm/sec,sec,g,

    7.683862,-198.963455,-0.6908,0.000000,3.949250,0.055864,0.000000,0.000000,0.0000,7.683862,0.038619

* The head of a step ends in a row of names and, below it, one of units, empty where a number has none; units may
  stand in brackets, there or behind the names. Channels come in any order. A linear test writes a file a stroke or
  two, so that one test may be a hundred files; the head repeats within a file, step after step.
* Fields are separated by commas, by tabs, or by blanks; semicolons are taken as well, and decimal commas where the
  separator is none.
* Forces "g" and "kg" are gram-force and kilogram-force. Fz presses downwards and is negative; Fx changes its sign
  with the stroke. Signs stay as they are.
* T counts seconds from the start of the step.

Channels: T time, Fz normal force, COF the friction coefficient, Z depth; the friction force is Fx where it changes its
sign stroke by stroke, since Ff has lost that sign, and else Ff, or Fx where there is no Ff. Others are
kept without a meaning, and ``segment`` counts the steps that have rows. The header holds no material and no
environment; the units of radius and speed are not written, those of the set force are those of Fz.
"""

import re
from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime

import numpy as np

from tribopipe.base.errors import ReaderError
from tribopipe.documents.signals import SignalName
from tribopipe.evaluation.preprocessing.strokes import whole_strokes
from tribopipe.readers.headed_tables import judge_lines
from tribopipe.readers.layout import Layout
from tribopipe.readers.reader import Hints, Holds, Match, ReadColumn, ReadTable
from tribopipe.readers.tables import bare_name, count_in, is_unit_row, without_brackets
from tribopipe.readers.text import BLANKS, LINE_END, Text, decode, sampled_rows, trimmed
from tribopipe.readers.text_blocks import (
    Block,
    Segment,
    find_blocks,
    line_at,
    read_segments,
    refuse_torn_rows,
    row_layout,
    with_meaning,
)
from tribopipe.results.run import SourceFile

_CREATOR = re.compile(
    r"\s*Created by (?:CETR|Bruker|UMT)\b.*|\s*Created by .*\bData Viewer\b.*", re.IGNORECASE | re.DOTALL
)
_INSTRUMENT = re.compile(r"Created by ((?:CETR |Bruker )?UMT\b.*?)(?:(?<! ) +ver\b.*)?$", re.IGNORECASE | re.DOTALL)
_STEP = re.compile(r"Step No\. *\d+\s*", re.IGNORECASE)
_SETTING = re.compile(r"(?P<key>[A-Za-z][\w #.]*+)[=-] *(?P<value>[+-]?\d+(?:[.,]\d+)?)", re.ASCII)
_STARTED = re.compile(
    r"(?:Started at:|Run date) *(?:(?P<early>\d{1,2}:\d\d:\d\d)\S* +)?"
    r"(?P<day>\d{1,2}) +(?P<month>[A-Za-z]{3})[a-z]*\.? +(?P<year>\d{4})(?: +(?P<late>\d{1,2}:\d\d:\d\d))?"
)
_CHANNELS = frozenset({"FX", "FY", "FZ", "FF", "COF", "T", "TIME", "X", "Y", "Z"})
_MEANINGS: dict[str, SignalName] = {
    "T": "time",
    "TIME": "time",
    "FZ": "normal_force",
    "COF": "friction_coefficient",
    "Z": "depth",
}
_FORCES = {"g": "gf", "kg": "kgf", "lb": "lbf"}
_CLOSE = 0.2
"""Share by which the median load may differ from the set one that is taken for it."""


class UmtReader:
    """Tests of a CETR or Bruker UMT, exported by its Data Viewer."""

    name = "bruker-umt"
    title = "CETR / Bruker UMT, exported by Data Viewer"
    holds: Holds = "signals"

    @judge_lines
    def match(self, lines: list[str]) -> Match:
        """Judge by the first line, or by a step with UMT's names of channels."""
        lines = [line for line in lines if line.strip()]
        if lines and _CREATOR.fullmatch(lines[0].rstrip()):
            return Match(0.95, f"the first line is {lines[0].strip()[:40]!r}")
        if any(map(_STEP.fullmatch, lines)) and any(map(_is_names, lines)):
            return Match(0.9, "a line 'Step No. …' and UMT channel names, such as 'Fx,Fz,Z'")
        return Match(0.0, "the first line is not 'Created by CETR Data Viewer …', and no step follows")

    def read(self, source: SourceFile, hints: Hints) -> ReadTable:
        """Parse the file; ``ReaderError`` with file and line where it is broken."""
        text = decode(source, hints.encoding)
        blocks = find_blocks(text)
        segments = _segments(text, blocks, hints)
        table = read_segments(text, segments)
        names = {bare_name(column.name).upper() for column in table.columns}
        reciprocates = "FF" in names and any(map(_is_signed_by_stroke, table.columns))
        columns = tuple(_with_meaning(column, "FX" if reciprocates else "FF", names) for column in table.columns)
        facts, notes = _facts(blocks, columns)
        if reciprocates:
            notes.append("Fx changes sign with each stroke and is the friction force; Ff is unsigned and is not used")
        return replace(
            table, columns=columns, facts=facts, notes=(*table.notes, *_missing_steps(blocks, segments), *notes)
        )


def _separator(line: str) -> str:
    return next((sign for sign in ("\t", ";", ",") if sign in line.strip()), BLANKS)


def _cells(line: str, separator: str) -> list[str]:
    """Split a row of names or units; between blanks, a unit in brackets belongs to the name before it."""
    if separator == BLANKS:
        return re.findall(r"[^\s\[(]\S*(?:[ \t]*(?:\[[^\[\]]*\]|\([^()]*\)))?|\[[^\[\]]*\]|\([^()]*\)", line)
    return [cell for row in sampled_rows([line], separator) for cell in row.cells]


def _is_names(line: str) -> bool:
    cells = {bare_name(cell).upper() for cell in _cells(line, _separator(line))}
    return len(cells & _CHANNELS) > 1


def _segments(text: Text, blocks: Sequence[Block], hints: Hints) -> list[Segment]:
    """Find the rows of the steps; numbers above the first row of names belong to the header."""
    segments: list[Segment] = []
    for block in blocks:
        if block.start == block.end:
            continue
        at = max((number for number, line in enumerate(block.head) if _is_names(line)), default=None)
        if at is not None:
            rows, head = _with_units(text, block, block.head[at:])
            segments.append(Segment(rows, _layout(text, rows, head, hints), _setting(block.head, "Data Count")))
        elif segments:
            raise ReaderError(
                f"{text.name}, line {line_at(text, block.start)}: found data with no header line above them; "
                "expected column names at the beginning of the step, such as 'Fx,Fz,Z,T'; add or correct the header "
                "line, or export the test again"
            )
    if not segments:
        raise ReaderError(
            f"{text.name}: found no data rows below the UMT channel names; expected a step with column names such "
            "as 'Fx,Fz,Z,T', units and data; export the test again with its data"
        )
    refuse_torn_rows(text, segments, blocks)
    return segments


def _with_units(text: Text, block: Block, head: Sequence[str]) -> tuple[Block, tuple[str, ...]]:
    """Move a row of units that begins with an empty field from the rows to the head."""
    first = LINE_END.search(text.content, block.start, block.end)
    line = text.content[block.start : first.start() if first else block.end].decode()
    if first is None or len(head) > 1 or not is_unit_row(_cells(line, _separator(head[0]))):
        return block, tuple(head)
    return block._replace(start=first.end()), (*head, line)


def _layout(text: Text, block: Block, head: Sequence[str], hints: Hints) -> Layout:
    line, *below = head
    separator = hints.separator or _separator(line)
    names = trimmed(_cells(line, separator))
    if len(below) > 1:
        raise ReaderError(
            f"{text.name}, line {line_at(text, block.start)}: found {below[-1][:40]!r} above the data; expected "
            "one row of units below the column names; correct that line"
        )
    units = _cells(below[0], separator) if below else []
    layout = row_layout(text, block, names, separator, hints.decimal)
    return replace(layout, units=_placed(units, names, separator))


def _placed(units: list[str], names: Sequence[str], separator: str) -> tuple[str, ...]:
    """Give each name its unit; between blanks, only COF can be without one."""
    if separator == BLANKS and len(units) != len(names):
        without = [name.upper() == "COF" for name in names]
        if len(units) != without.count(False):
            return ()
        rest = iter(units)
        return tuple("" if missing else next(rest) for missing in without)
    return tuple(without_brackets(unit) for unit in units)


def _setting(head: Sequence[str], key: str) -> int | None:
    """Give the last whole number that a head gives for a key."""
    found = [
        setting for line in head if (setting := _SETTING.match(line)) and setting["key"].strip().lower() == key.lower()
    ]
    return count_in(found[-1]["value"]) if found else None


def _is_signed_by_stroke(column: ReadColumn) -> bool:
    """Return whether a column is Fx and goes there and back."""
    is_fx = bare_name(column.name).upper() == "FX" and column.first_bad is None
    return is_fx and bool(whole_strokes(np.asarray(column.values, dtype=float)))


def _with_meaning(column: ReadColumn, friction: str, names: set[str]) -> ReadColumn:
    """Give a column its unit and meaning; ``friction`` names the friction force, in the place of which Fx may stand."""
    name = bare_name(column.name).upper()
    if name.startswith("F") and column.unit in _FORCES:
        column = replace(column, unit=_FORCES[column.unit])
    if name in ("FX", "FF"):
        is_friction = name == (friction if friction in names else "FX")
        return with_meaning(column, "friction_force" if is_friction else None)
    return with_meaning(column, _MEANINGS.get(name))


def _missing_steps(blocks: Sequence[Block], segments: Sequence[Segment]) -> list[str]:
    """Report where the header counts more steps than the file has rows of."""
    lines = [line for block in blocks for line in block.head]
    claimed = _setting(lines, "Total number of steps")
    if claimed is None or claimed <= len(segments):
        return []
    return [f"the header declares {claimed} steps; {len(segments)} of them contain data"]


def _facts(blocks: Sequence[Block], columns: Sequence[ReadColumn]) -> tuple[dict[str, str], list[str]]:
    lines = [line for block in blocks for line in block.head]
    facts, notes = {}, []
    instrument = next((found[1] for line in lines if (found := _INSTRUMENT.match(line))), None)
    if instrument:
        facts["instrument"] = instrument
    dated = [line for key in ("Started at", "Run date") for line in lines if line.startswith(key)]
    started = next((moment for line in dated if (moment := _started(line))), None)
    if started:
        facts["started"] = started
    elif dated:
        notes.append(
            "the start time of the test is not taken from the header, since the date is not in the form '12 May 2022'"
        )
    load = _load(lines, columns)
    if load:
        facts["conditions.normal_load"] = load
    return facts, notes


def _started(line: str) -> str | None:
    """Read '12:21:58.029 12 May 2022', or the same with the time behind the date, as ISO 8601."""
    found = _STARTED.match(line)
    if found is None or not (found["early"] or found["late"]):
        return None
    months = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
    if found["month"].lower() not in months:
        return None
    month = 1 + months.index(found["month"].lower())
    hour, minute, second = map(int, (found["early"] or found["late"]).split(":"))
    try:
        return datetime(int(found["year"]), month, int(found["day"]), hour, minute, second).isoformat()  # noqa: DTZ001
    except ValueError:
        return None


def _load(lines: Sequence[str], columns: Sequence[ReadColumn]) -> str | None:
    """Give the set force where all steps have the same one and Fz bears it out, its unit with it."""
    found = {
        setting["value"]
        for line in lines
        if (setting := _SETTING.match(line)) and setting["key"].strip() == "Set Force"
    }
    force = next((column for column in columns if column.signal == "normal_force"), None)
    if len(found) != 1 or force is None or force.unit is None or force.first_bad:
        return None
    load = found.pop().lstrip("+-").replace(",", ".")
    held = float(np.nanquantile(np.abs(force.values), 0.5, method="lower"))  # no mean, which may overflow
    return f"{load} {force.unit}" if abs(held - float(load)) <= _CLOSE * float(load) else None

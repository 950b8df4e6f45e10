r"""Rtec MFT: the CSV file that the software of Rtec's multi-function tribometers logs of a test.

    Recipe, UpperSample,…,TestDate, Operator,…\r                                names of what is known of the test
    Stribeck.Rx,,…,9/22/2026 3:42:07 AM,Ana,…\r\n                               and their values
    Step, Timestamp, RecipeStep, DAQ.Fz (N),DAQ.Fx (N),DAQ.COF (),XYZ.Z Depth (mm),\r\n
    1,0.01,1,5.02,1.11,0.221,0.013,\n
    \n
    TotalTime\n
    00:01:08.2500000\n

* A lone CR parts the names of the first line from their values. Either may be missing. Dates are written as the
  computer's language has them; which of day and month comes first is taken from a date that allows one reading only.
  Radius is 1 where nobody has set it, and no fact.
* The row of names has Timestamp in it, and channels called "device.channel (unit)", in any order and any choice; the
  brackets of a friction coefficient are empty or name a force: "DAQ.COF ()", "DAQ.COF (Fx)".
* Fields are separated by commas, names by commas and blanks; rows, and some rows of names, end in one comma more.
* Timestamp counts seconds from the start of a step and begins again with each one. Step counts steps that were logged
  and may skip numbers; both are kept as they are.
* A blank line, TotalTime and the duration as hh:mm:ss close the file. Where they are missing, it has been cut.

Channels: Timestamp time, DAQ.Fz normal force, DAQ.Fx friction force, DAQ.COF friction coefficient, "… Z Depth" depth.
"Z Position" is where the stage stands and is kept without a meaning, as all others are. Material, radius of the track
and nominal load are not in the file.
"""

import re
from collections.abc import Sequence
from dataclasses import replace

from tribopipe.base.errors import ReaderError
from tribopipe.documents.signals import SignalName
from tribopipe.readers.headed_tables import cells_of, judge_lines, start_from
from tribopipe.readers.reader import Hints, Holds, Match, ReadColumn, ReadTable
from tribopipe.readers.tables import PLACEHOLDER, bare_name
from tribopipe.readers.text import Text, decode, trimmed
from tribopipe.readers.text_blocks import (
    Block,
    Segment,
    find_blocks,
    line_at,
    read_segments,
    row_layout,
    with_meaning,
)
from tribopipe.results.run import SourceFile

_SEPARATORS = (",", ";", "\t")
_CHANNEL = re.compile(r"[A-Za-z]\w*\.[A-Za-z][\w .]*\([^)]*\)")
_FIRST = re.compile(rf"[,;\t\d.+-]|{PLACEHOLDER} *[,;\t]", re.IGNORECASE)
"""How a row begins."""
_MOST_ABOVE = 5
"""Lines among which the names have to be: they come first, or below names and values of what is known of the test."""
_DEVICES = ("DAQ.", "XYZ.", "ROTARY.")
_CLOSING = re.compile(r"TotalTime \d+:\d\d:\d\d(?:\.\d+)?")
_CUT_CLOSING = re.compile(r"TotalTime [\d:.]*")
_MEANINGS: tuple[tuple[str, SignalName], ...] = (
    (r"Timestamp", "time"),
    (r"DAQ\.Fz", "normal_force"),
    (r"DAQ\.Fx", "friction_force"),
    (r"DAQ\.COF(?: *\(Fx\))?", "friction_coefficient"),
    (r"DAQ\.COF *\(\w+\)", "friction_coefficient"),
    (r"(?:\w+\.)?Z ?Depth", "depth"),
)
_FACTS = {"operator": "operator", "user": "operator", "comment": "comment", "comments": "comment"}


class RtecReader:
    """Logs of Rtec's multi-function tribometers."""

    name = "rtec-mft"
    title = "Rtec MFT (CSV)"
    holds: Holds = "signals"

    @judge_lines
    def match(self, lines: list[str]) -> Match:
        """Judge by a row of names that has Timestamp and channels of devices in it."""
        lines = [line for line in lines if line.strip()]
        at = next((number for number, line in enumerate(lines[:_MOST_ABOVE]) if _names(line)), None)
        if at is None:
            return Match(0.0, "no header row with Timestamp and channels such as 'DAQ.Fz (N)' at the top")
        # A last line may be cut: it is for reading to say so.
        if len(lines) > at + 2 and not _FIRST.match(lines[at + 1]):
            return Match(
                0.0, f"the channel names are followed by {lines[at + 1].strip()[:40]!r}, which is not a data row"
            )
        channels = [name for name in _names(lines[at]) if _CHANNEL.fullmatch(name)]
        if any(name.upper().startswith(_DEVICES) for name in channels):
            return Match(0.95, f"the header row contains Timestamp and {channels[0]!r}, as in Rtec files")
        return Match(
            0.2, f"the header row contains Timestamp and {channels[0]!r}, but no channel of a DAQ, XYZ or Rotary device"
        )

    def read(self, source: SourceFile, hints: Hints) -> ReadTable:
        """Parse the file; ``ReaderError`` with file and line where it is broken."""
        text = decode(source, hints.encoding)
        blocks = find_blocks(text)
        _refuse_words_below_names(text, blocks)
        at = next((n for n, block in enumerate(blocks) if block.head and _names(block.head[-1])), None)
        if at is None or blocks[at].start == blocks[at].end:
            lacking = "no header row" if at is None else "no numbers below the header row"
            raise ReaderError(
                f"{text.name}: found {lacking} with Timestamp and channels such as 'DAQ.Fz (N)'; expected a header row "
                "and data rows; export the test again with its data"
            )
        facts, notes = _facts(text, blocks[at])
        notes += _closing_notes(text, blocks[at])
        table = read_segments(text, [_rows(text, blocks[at], hints)], numbered=False)
        columns = tuple(map(_with_unit, table.columns))
        return replace(table, columns=_with_meanings(columns), notes=(*table.notes, *notes), facts=facts)


def _refuse_words_below_names(text: Text, blocks: Sequence[Block]) -> None:
    """Refuse a first row that begins with a word."""
    for block in blocks:
        if block.start < block.end and any(map(_names, block.head)) and not _names(block.head[-1]):
            raise ReaderError(
                f"{text.name}, line {line_at(text, block.start) - 1}: found {block.head[-1][:60]!r} between the "
                "header row and the data; expected a data row; correct or delete that line"
            )


def _names(line: str) -> list[str]:
    """Split the row of names; nothing where the line is another."""
    for separator in _SEPARATORS:
        cells = trimmed(cells_of(line, separator))
        if "TIMESTAMP" in (bare_name(cell).upper() for cell in cells) and any(map(_CHANNEL.fullmatch, cells)):
            return cells
    return []


def _rows(text: Text, block: Block, hints: Hints) -> Segment:
    line = block.head[-1]
    separator = hints.separator or next(sign for sign in _SEPARATORS if sign in line)
    names = trimmed(cells_of(line, separator))
    return Segment(block, row_layout(text, block, names, separator, hints.decimal))


def _closing_notes(text: Text, rows: Block) -> list[str]:
    """Refuse anything below the rows but TotalTime and a duration; state where that is missing."""
    below = text.content[rows.end :].decode()
    closing = " ".join(re.split(r"[\s,;]+", below)).strip()
    if _CLOSING.fullmatch(closing):
        return []
    if "TotalTime".startswith(closing) or _CUT_CLOSING.fullmatch(closing):
        return ["TotalTime is missing below the data, so the file may be truncated"]
    first = len(text.content) - len(below.lstrip().encode())
    raise ReaderError(
        f"{text.name}, line {line_at(text, first)}: found {closing[:60]!r} below the data; expected only "
        "TotalTime and a duration; correct or delete these lines"
    )


def _with_unit(column: ReadColumn) -> ReadColumn:
    if column.unit is None and column.name.upper() == "TIMESTAMP":
        return replace(column, unit="s")
    # A coulomb has no place on a tribometer.
    return replace(column, unit="degC") if column.unit == "C" and "TEMP" in column.name.upper() else column


def _with_meanings(columns: Sequence[ReadColumn]) -> tuple[ReadColumn, ...]:
    """Give each meaning to one column, the first whose name has it."""
    meanings: dict[str, SignalName] = {}
    for pattern, signal in _MEANINGS:
        name = next((c.name for c in columns if re.fullmatch(pattern, bare_name(c.name), re.IGNORECASE)), None)
        if name and signal not in meanings.values():
            meanings[name] = signal
    return tuple(with_meaning(column, meanings.get(column.name)) for column in columns)


def _facts(text: Text, block: Block) -> tuple[dict[str, str], list[str]]:
    """Take what the first line, or two, states about the test: names there, values below."""
    lines = re.split(r"\r\n?|\n", text.content[text.start : block.start].decode())
    filled = [line for line in lines if line.strip()][:-1]
    if len(filled) != 2:
        return {}, []
    names, values = (cells_of(line, ",") for line in filled)
    known = dict(zip(map(str.lower, names), values, strict=False))
    facts = {key: known[name] for name, key in _FACTS.items() if known.get(name)}
    started, notes = start_from(known.get("testdate", ""), values)
    return facts | started, notes

r"""PCS Instruments: the test data file of their EHD and MTM rigs, a text with a table for each step that has one.

    EHD261 Test Data File
    Profile description:⟨TAB⟩New EHD profile
    Disc track radius:⟨TAB⟩36.273
    Lubricant name:
    Number of steps completed:⟨TAB⟩7
    Test started at 28/02/2017 15:47

    Step 1 "New spacer zero step" started at 28/02/2017 15:48
    Step type⟨TAB⟩FILM_ZERO⟨TAB⟩Step description⟨TAB⟩New spacer zero step
           Ball load = 19.9 N

    Step 2 "New film step" started at 28/02/2017 16:09
    Step type⟨TAB⟩FILM⟨TAB⟩Step description⟨TAB⟩New film step
    Rolling Speed (mm/s)⟨TAB⟩Average Film (nm)⟨TAB⟩⟨TAB⟩Step Time (s)⟨TAB⟩…⟨TAB⟩Traction Coeff (-)⟨TAB⟩
    20.2⟨TAB⟩24.4⟨TAB⟩⟨TAB⟩10⟨TAB⟩…⟨TAB⟩⟨TAB⟩
    …
    All steps completed, test completed normally at 28/02/2017 16:35

* Names carry their units in round brackets; ball and disc speeds have none. Names repeat, and some columns have
  neither name nor values: those are left out.
* Steps that zero, check or heat have lines of words and no table. ``segment`` counts the tables; a note says which
  steps they belong to. Step Time begins again with each step.
* A line "All steps completed …" or "Test stopped …" closes the file. Where it is missing, the file has been cut.
* Dates are written as the computer's language has them; which of day and month comes first is taken from a date
  that allows one reading only, and not guessed where none does.
* The radius of the track on the disc is in mm. The ball's radius and the materials are not in the file.

Channels: Step Time time, Ball Load normal force, Sliding Speed sliding speed, Traction Force friction force, Traction
Coeff friction coefficient, Lube Temp temperature; a channel that was not recorded is empty and has no meaning.

The same software writes files that are no tests, such as "Mapper Spacer Calibration File", the colours of a spacer
layer: those are refused.
"""

import re
from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime
from typing import NoReturn

from tribopipe.errors import ReaderError
from tribopipe.ingest.formats.blocks import (
    Block,
    Segment,
    decimal_sign,
    find_blocks,
    line_at,
    read_segments,
    sample_rows,
    with_meaning,
)
from tribopipe.ingest.headed import cells_of, head_lines, refused
from tribopipe.ingest.layout import Layout
from tribopipe.ingest.names import bare_name
from tribopipe.ingest.reader import Hints, Holds, Match, ReadTable
from tribopipe.ingest.text import Text, decode, trimmed
from tribopipe.records.signals import SignalName
from tribopipe.run import SourceFile

_TITLE = re.compile(r"(?P<rig>[A-Za-z][\w .+-]{0,30}?) Test Data File")
_NO_TEST = re.compile(r"(?:[A-Za-z]\w* )*Calibration File")
_MARK = re.compile(r"Profile description:.*|Number of steps .*|Step \d+ \".*")
_STEP = re.compile(r"Step (?P<number>\d+) \"(?P<name>.*)\" started at .*")
_CLOSING = re.compile(r"All steps completed.*|Test (?:stopped|aborted|completed|ended|finished).*", re.IGNORECASE)
_DATE = re.compile(
    r"\b(?P<first>\d{1,2})[/.-](?P<second>\d{1,2})[/.-](?P<year>\d{4}) +(?P<hour>\d{1,2}):(?P<minute>\d\d)"
    r"(?::(?P<seconds>\d\d))?(?: *(?P<half>[AaPp])[Mm])?(?!\d)"
)
_MEANINGS: dict[str, SignalName] = {
    "step time": "time",
    "ball load": "normal_force",
    "sliding speed": "sliding_speed",
    "traction force": "friction_force",
    "traction coeff": "friction_coefficient",
    "lube temp": "temperature",
}
_FACTS = {"Profile description": "title", "Lubricant name": "conditions.medium", "Comments": "comment"}


class PcsReader:
    """Test data files of PCS Instruments' rigs."""

    name = "pcs-instruments"
    title = "PCS Instruments test data file (EHD, MTM)"
    holds: Holds = "signals"

    def match(self, source: SourceFile) -> Match:
        """Judge by the first line and by what the lines below are called."""
        try:
            first, *others = [line.strip() for line in head_lines(source) if line.strip()] or [""]
        except ReaderError as error:
            return refused(source, error)
        if _NO_TEST.fullmatch(first):
            return Match(0.0, f"the first line is {first[:60]!r}, which is no test data", f"a {first[:60]!r}")
        if not _TITLE.fullmatch(first):
            return Match(0.0, "the first line is not '… Test Data File'")
        if any(map(_MARK.fullmatch, others)):
            return Match(0.95, f"the first line is {first!r}, and profile and steps follow")
        return Match(0.2, f"the first line is {first!r}, but neither profile nor steps follow")

    def read(self, source: SourceFile, hints: Hints) -> ReadTable:
        """Parse the file; ``ReaderError`` with file and line where it is broken or no test."""
        text = decode(source, hints.encoding)
        blocks = find_blocks(text)
        _refuse_others(text, blocks[0].head if blocks else ())
        segments, steps = _segments(text, blocks, hints)
        table = read_segments(text, segments)
        columns = tuple(with_meaning(column, _meaning(column.name)) for column in table.columns)
        lines = [line.strip() for block in blocks for line in block.head]
        facts, notes = _facts(lines)
        notes = [f"segments are the tables of {', '.join(steps)}", *_unfinished(lines), *notes]
        return replace(table, columns=columns, facts=facts, notes=(*table.notes, *notes))


def _refuse_others(text: Text, head: Sequence[str]) -> None:
    line = head[0].strip() if head else ""
    if not _TITLE.fullmatch(line):
        raise ReaderError(
            f"{text.name}, line 1: found {line[:60]!r}; expected a test, such as 'EHD261 Test Data File'; "
            + ("this file holds no test data" if _NO_TEST.fullmatch(line) else "name another reader in run.toml")
        )


def _segments(text: Text, blocks: Sequence[Block], hints: Hints) -> tuple[list[Segment], list[str]]:
    """Find the tables, and name the step of each; numbers among the words of a header or step are words too."""
    segments: list[Segment] = []
    steps: list[str] = []
    step = None
    for block in blocks:
        step = next((found for line in reversed(block.head) if (found := _STEP.fullmatch(line.strip()))), step)
        separator = hints.separator or "\t"
        names = trimmed(cells_of(block.head[-1], separator)) if block.head else []
        rows = sample_rows(text, block, separator)
        if step is None or not any(len(row) > 1 for row in rows):
            continue
        if len(names) < 2 or names[0] == "Step type":
            _refuse_nameless(text, block)
        width = max(len(names), *(len(row) for row in rows if not any(row[len(names) :])), 0)
        decimal = hints.decimal or decimal_sign(rows, separator)
        segments.append(Segment(block, Layout(separator, decimal, tuple(names), 1, "", width, len(names))))
        steps.append(f"step {step['number']} {step['name']!r}")
    if not segments:
        raise ReaderError(
            f"{text.name}: found no step with a table of numbers; expected at least one; export the test again with "
            "its data"
        )
    return segments, steps


def _refuse_nameless(text: Text, block: Block) -> NoReturn:
    raise ReaderError(
        f"{text.name}, line {line_at(text, block.start)}: found numbers without names above; expected names such as "
        "'Step Time (s)' in the line before; mend that line, or export the test again"
    )


def _meaning(name: str) -> SignalName | None:
    return _MEANINGS.get(bare_name(name).lower())


def _unfinished(lines: Sequence[str]) -> list[str]:
    """Say where the line that closes a test is missing."""
    if any(map(_CLOSING.fullmatch, lines)):
        return []
    return ["no line says that all steps were completed or the test was stopped, so the file may have lost its end"]


def _facts(lines: Sequence[str]) -> tuple[dict[str, str], list[str]]:
    facts = {"instrument": f"PCS Instruments {lines[0].removesuffix(' Test Data File')}"}
    notes = []
    values = dict(line.split(":", 1) for line in lines[1:] if ":" in line and not _STEP.fullmatch(line))
    facts |= {key: values[name].strip() for name, key in _FACTS.items() if values.get(name, "").strip()}
    radius = values.get("Disc track radius", "").strip()
    if re.fullmatch(r"\d+(\.\d+)?", radius):
        facts["conditions.track_radius"] = f"{radius} mm"
        notes.append(f"the track radius of the disc, {radius}, is taken to be in mm: the file does not say so")
    started = next(
        (found for line in lines if line.startswith("Test started at") and (found := _DATE.search(line))), None
    )
    moment = _moment(started, _day_first(lines)) if started else None
    if moment:
        facts["started"] = moment
    elif started:
        notes.append(f"when the test started, {started[0]}, may be day or month first and is not taken from the header")
    return facts, notes


def _day_first(lines: Sequence[str]) -> bool | None:
    """Tell by all dates of the file whether the day comes before the month; None where they leave it open."""
    dates = [found for line in lines for found in _DATE.finditer(line)]
    day_first = any(int(date["first"]) > 12 for date in dates)
    month_first = any(int(date["second"]) > 12 for date in dates)
    return None if day_first == month_first else day_first


def _moment(date: re.Match[str], day_first: bool | None) -> str | None:
    if day_first is None:
        return None
    day, month = (int(date[name]) for name in (("first", "second") if day_first else ("second", "first")))
    hour = int(date["hour"])
    if date["half"]:
        hour = hour % 12 + (12 if date["half"] in "Pp" else 0)
    try:
        return datetime(  # noqa: DTZ001
            int(date["year"]), month, day, hour, int(date["minute"]), int(date["seconds"] or 0)
        ).isoformat()
    except ValueError:
        return None

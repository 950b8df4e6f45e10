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
* Steps that zero, check, heat or take pictures have lines of words and no table. ``segment`` counts the tables; a note
  states which steps they belong to. Step Time begins again with each step.
* The MTM names a step in the line below its first, and may give it a track radius of its own:

    Step 2 started at 23/03/2018 10:12:01
    Step type⟨TAB⟩BOD_TIMED⟨TAB⟩Step description⟨TAB⟩Running in⟨TAB⟩Step duration⟨TAB⟩00:05:00
    Disc track radius used for this step (mm)⟨TAB⟩21.232

  Its first two columns repeat others, for the plot of the step. Files from which the lines above the first step have
  been subtracted are read as well.
* A line "All steps completed …" or "Test stopped …" closes the file. Where it is missing, the file has been cut.
* Dates are written as the computer's language has them; which of day and month comes first is taken from a date
  that allows one reading only, and not guessed where none does.
* The radius of the track on the disc, above the steps, is in mm. The radius of the ball and the materials are not in
  the file.

Channels: Step Time time, Ball Load normal force (with a pin, whose balls carry none, Pin Load), Sliding Speed sliding
speed, Traction Force friction force, Traction Coeff friction coefficient, Lube Temp or Lube RTD Temp temperature; a
channel that was not recorded is empty and has no meaning.

The same software writes files that are no tests, such as "Mapper Spacer Calibration File" and "SLIM Mapper Analysis
File", the colors of a spacer layer and of a film: those are refused.
"""

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NoReturn

from tribopipe.base.errors import ReaderError
from tribopipe.documents.signals import SignalName
from tribopipe.readers.headed_tables import cells_of, judge_lines, start_from
from tribopipe.readers.reader import Hints, Holds, Match, ReadColumn, ReadTable
from tribopipe.readers.tables import bare_name, is_number
from tribopipe.readers.text import Text, decode, trimmed
from tribopipe.readers.text_blocks import (
    Block,
    Segment,
    find_blocks,
    line_at,
    listed,
    read_segments,
    refuse_torn_rows,
    row_layout,
    sample_rows,
    with_meaning,
)
from tribopipe.results.run import SourceFile

_TITLE = re.compile(r"(?P<rig>[A-Za-z][\w .+-]{0,30}?) Test Data File")
_NO_TEST = re.compile(r"(?:[A-Za-z]\w* )*(?:Calibration|Mapper Analysis) File")
_STEP = re.compile(r"Step (?P<number>\d+) (?:\"(?P<name>.*)\" )?started at .*", re.DOTALL)
_STEP_TYPE = re.compile(r"Step type\t.*?(?:\tStep description\t(?P<name>[^\t]*).*)?", re.DOTALL)
_MARK = re.compile(rf"Profile description:.*|Number of steps .*|{_STEP.pattern}", re.DOTALL)
_STEP_RADIUS = re.compile(r"Disc track radius used for this step \(mm\)\t(?P<radius>\d+(?:\.\d+)?)")
_CLOSING = re.compile(r"All steps completed.*|Test (?:stopped|aborted|completed|ended|finished).*", re.IGNORECASE)
_MEANINGS: dict[str, SignalName] = {
    "step time": "time",
    "ball load": "normal_force",
    "pin load": "normal_force",
    "sliding speed": "sliding_speed",
    "traction force": "friction_force",
    "traction coeff": "friction_coefficient",
    "lube temp": "temperature",
    "lube rtd temp": "temperature",
}
_FACTS = {"Profile description": "title", "Lubricant name": "conditions.medium", "Comments": "comment"}


class PcsReader:
    """Test data files of PCS Instruments' rigs."""

    name = "pcs-instruments"
    title = "PCS Instruments test data file (EHD, MTM)"
    holds: Holds = "signals"

    @judge_lines
    def match(self, lines: list[str]) -> Match:
        """Judge by the first line and by what the lines below are called."""
        first, *others = [line.strip() for line in lines if line.strip()] or [""]
        if _NO_TEST.fullmatch(first):
            return Match(0.0, f"the first line, {first[:60]!r}, is not that of a test data file", f"a {first[:60]!r}")
        if _begins_with_step((first, *others)):
            return Match(0.95, f"the first lines are {first!r} and the type of that step")
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
        columns = _with_meanings(table.columns)
        lines = [line.strip() for block in blocks for line in block.head]
        facts, notes = _facts(lines)
        notes = [f"segments are the tables of {listed(steps)}", *_unfinished(lines), *notes]
        return replace(table, columns=columns, facts=facts, notes=(*table.notes, *notes))


def _begins_with_step(lines: Sequence[str]) -> bool:
    return len(lines) > 1 and bool(_STEP.fullmatch(lines[0].strip()) and _STEP_TYPE.fullmatch(lines[1].strip()))


def _refuse_others(text: Text, head: Sequence[str]) -> None:
    line = head[0].strip() if head else ""
    if not _TITLE.fullmatch(line) and not _begins_with_step(head):
        raise ReaderError(
            f"{text.name}, line 1: found {line[:60]!r}; expected the first line of a test, such as 'EHD261 Test "
            "Data File'; "
            + ("this file contains no test data" if _NO_TEST.fullmatch(line) else "specify another reader in run.toml")
        )


def _segments(text: Text, blocks: Sequence[Block], hints: Hints) -> tuple[list[Segment], list[str]]:
    """Find the tables, and name the step of each; numbers among the words of a header or step are words too."""
    segments: list[Segment] = []
    steps: list[str] = []
    step = None
    for block in blocks:
        step = _last_step(block.head) or step
        separator = hints.separator or "\t"
        names = trimmed(cells_of(block.head[-1], separator)) if block.head else []
        rows = sample_rows(text, block, separator)
        if not step or not any(len(row) > 1 for row in rows):
            continue
        if len(names) < 2 or names[0] == "Step type" or any(is_number(name, ".,") for name in names):
            _refuse_nameless(text, block)
        segments.append(Segment(block, row_layout(text, block, names, separator, hints.decimal)))
        steps.append(step)
    if not segments:
        raise ReaderError(
            f"{text.name}: found no step with data; expected at least one step with data; export the test again with "
            "its data"
        )
    refuse_torn_rows(text, segments, blocks)
    return segments, steps


def _last_step(head: Sequence[str]) -> str | None:
    """Give number and name of the step that a head ends in: named there, or in the line below."""
    lines = [line.strip() for line in head]
    for line, below in reversed([*pairwise([*lines, ""])]):
        step, kind = _STEP.fullmatch(line), _STEP_TYPE.fullmatch(below)
        if step:
            name = step["name"] or (kind["name"] if kind else None)
            return f"step {step['number']}" + (f" {name!r}" if name else "")
    return None


def _refuse_nameless(text: Text, block: Block) -> NoReturn:
    raise ReaderError(
        f"{text.name}, line {line_at(text, block.start)}: found data with no header line above them; expected "
        "column names such as 'Step Time (s)' in the line above the data; add or correct the header line, or export "
        "the test again"
    )


def _with_meanings(columns: Sequence[ReadColumn]) -> tuple[ReadColumn, ...]:
    """Report what the columns are; of the loads on ball and pin, the first that was recorded is the normal force."""
    found: list[ReadColumn] = []
    for column in columns:
        signal = _MEANINGS.get(bare_name(column.name).lower())
        taken = any(other.signal == signal for other in found)
        found.append(with_meaning(column, None if taken else signal))
    return tuple(found)


def _unfinished(lines: Sequence[str]) -> list[str]:
    """Report where the line that closes a test is missing."""
    if any(map(_CLOSING.fullmatch, lines)):
        return []
    return ["no line states that all steps were completed or that the test was stopped, so the file may be truncated"]


def _facts(lines: Sequence[str]) -> tuple[dict[str, str], list[str]]:
    rig = _TITLE.fullmatch(lines[0])
    facts = {"instrument": f"PCS Instruments {rig['rig']}" if rig else "PCS Instruments"}
    values = dict(line.split(":", 1) for line in lines[1:] if ":" in line and not _STEP.fullmatch(line))
    facts |= {key: values[name].strip() for name, key in _FACTS.items() if values.get(name, "").strip()}
    radius, notes = _track_radius(values.get("Disc track radius", "").strip(), lines)
    facts |= radius
    line = next((line for line in lines if line.startswith("Test started at")), "")
    started, ambiguous = start_from(line, lines)
    return facts | started, notes + ambiguous


def _track_radius(of_test: str, lines: Sequence[str]) -> tuple[dict[str, str], list[str]]:
    """Give the radius of the track on the disc, by the test's own line or by those of its steps."""
    key = "conditions.track_radius"
    if re.fullmatch(r"\d+(\.\d+)?", of_test):
        note = (
            f"the track radius of the disc, {of_test}, is assumed to be in mm, since the file does not state the unit"
        )
        return {key: f"{of_test} mm"}, [note]
    radii = [*dict.fromkeys(found["radius"] for line in lines if (found := _STEP_RADIUS.fullmatch(line)))]
    if len(radii) > 1:
        return {}, [f"the track radius of the disc differs between steps: {listed(radii)} mm"]
    return ({key: f"{radii[0]} mm"} if radii else {}), []

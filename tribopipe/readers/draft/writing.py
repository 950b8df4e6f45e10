"""run.toml as a draft: what is known stands in it with its origin, what is not is a commented line with an example."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from textwrap import wrap
from typing import Any, NamedTuple

from tribopipe.documents.manifest import MANIFEST_SCHEMA
from tribopipe.readers.draft.blanks import blanks_of
from tribopipe.readers.draft.columns import Mapped, mapped_columns, unmapped_columns
from tribopipe.readers.draft.grouping import Group
from tribopipe.readers.draft.known_values import Known, bodies_of, needed_bodies_of, run_key, run_words, sections
from tribopipe.readers.draft.splitting import StepOfFiles
from tribopipe.readers.draft.toml import comment, one_line, toml
from tribopipe.readers.export_files import Export

_WIDTH = 110
_WIDEST_CODE = 76
"""Of lines whose remarks are put below each other."""
_WITHOUT_BODIES = (
    "# The two bodies; without them only friction is evaluated. Remove the # at the start of these lines, in all",
    "# tables at the same time, once the bodies are described.",
)
_AFTERWARDS = "# Post-test measurements of the specimens; remove the # at the start of those that are known."


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
    """Encoding, separator and decimal sign of all files."""
    columns: Mapping[str, Any] = field(default_factory=dict)
    """What columns mean."""
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
    elif key == "contact.kind" and not known.bodies_lack:
        yield _Line(f"{name} = {toml(known.kind)}")
    elif key in blanks and not doubts and known.fits(key, blanks[key].value):
        own = run_key(key, known.kind)
        words = run_words(blanks[key].words, known.kind)
        yield _Line(f"# {own.removeprefix(f'{table}.') if table else own} = {blanks[key].example}", words)


def _aligned(lines: Sequence[_Line]) -> list[str]:
    """Write lines with their remarks below each other."""
    width = max((len(line.code) for line in lines if line.remark and len(line.code) <= _WIDEST_CODE), default=0)
    return [f"{line.code:<{width}}   # {comment(line.remark)}" if line.remark else line.code for line in lines]


def _signals(group: Group, draft: Draft) -> list[str]:
    """Write what run.toml states about files that continue each other."""
    on_track = "conditions.track_radius" in draft.known.given
    first, mapped = group.first, mapped_columns(group.first, draft.columns, f"by {draft.template}", on_track=on_track)
    lines = [
        _Line("[[signals]]"),
        *_files(group),
        _Line(f"reader = {toml(draft.reader or first.reader.name)}", first.match.why),
        *(_Line(f"{name} = {toml(value)}", f"from {draft.template}") for name, value in draft.dialect.items()),
        *_part_of_file(draft),
    ]
    named = any(not one.lacks for one in mapped)
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
        return [_Line(f"file = {toml(group.names[0])}", f"{group.rows} rows")]
    inside = [_Line(f"    {toml(name)},") for name in group.names]
    return [_Line("files = [", f"{len(group.names)} files, {group.rows} rows"), *inside, _Line("]")]


def _unmapped(export: Export, mapped: list[Mapped]) -> list[str]:
    names = ", ".join(unmapped_columns(export, mapped))
    told = f"Kept, but not used as signals: {one_line(names)}" if names else ""
    return [f"# {line}" for line in wrap(told, _WIDTH)]

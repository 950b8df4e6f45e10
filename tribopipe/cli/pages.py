"""Pages of runs and studies on a terminal: headings, aligned facts, wrapped texts and tables."""

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import typer

from tribopipe.cli.output import fits, line_width, print_result, seen, table, wrapped

if TYPE_CHECKING:
    from tribopipe.views.page import Fact, Remark, RunPage, StagePage, StudyPage, TextTable

_SAID = {
    "bad": "marked bad",
    "good": "bad mark removed",
    "tag": "tagged",
    "untag": "no longer tagged",
    "note": "note",
    "amended": "run.toml amended",
}


def show_run_page(page: "RunPage") -> None:
    """Show a run in full."""
    show_head(page)
    width = _widest(fact for group in page.facts for fact in group.facts)
    for group in page.facts:
        heading(group.title)
        show_facts(group.facts, width)
    _section("Findings", [f"{finding.severity}: {finding}" for finding in page.findings])
    _section("Remarks", [_remark(one) for one in page.remarks])
    beneath_table = [False, *(bool(stage.tables) for stage in page.stages)]
    for stage, beneath in zip(page.stages, beneath_table, strict=False):
        _show_stage(stage, apart=not beneath)
    files = [f"{one.name}: {one.size:,} bytes, SHA-256 {one.sha256}" for one in page.sources]
    _section("Source files", files, apart=not beneath_table[-1])
    _section("Studies", page.studies)


def show_head(page: "RunPage") -> None:
    """Show the title of a run, its mark if it is marked bad, and its tags."""
    heading(page.id, apart=False)
    paragraph("" if page.title == page.id else page.title)
    paragraph("" if page.bad is None else f"marked bad: {page.bad}")
    paragraph(f"tags: {', '.join(page.tags)}" if page.tags else "")


def _remark(one: "Remark") -> str:
    return f"{_SAID[one.kind]}{f' by {one.operator}' if one.operator else ''}, {one.date}: {one.text}"


def _show_stage(stage: "StagePage", *, apart: bool) -> None:
    heading(stage.title, f"({stage.name}, tribopipe {stage.program_version}, {stage.date})", apart=apart)
    paragraph(stage.sentence)
    show_facts(stage.facts, _widest(stage.facts))
    for note in stage.notes:
        paragraph(_noted(note))
    for told in stage.tables:
        _show_table(told)


def _noted(note: str) -> str:
    """Label a note as such, unless it is a finding, which has its own severity."""
    return note if note.startswith(("warning: ", "note: ")) else f"note: {note}"


def show_study_page(page: "StudyPage", *, in_full: bool = True) -> None:
    """Show a study: its tables, and in full also the text on each run."""
    heading(page.id, f"(tribopipe {page.program_version}, {page.date})" if page.date else "", apart=False)
    paragraph("" if page.title == page.id else page.title)
    for law in page.laws:
        heading(f"{page.id}, {law.title}")
        for told in law.tables:
            _show_table(told)
        for sentence in law.sentences if in_full else ():
            paragraph(sentence, "")
        for verdict in law.agreement if in_full else ():
            paragraph(f"{verdict.run_id}: {verdict.sentence}", "")
            for note in verdict.notes:
                paragraph(f"{verdict.run_id}: {_noted(note)}", "")
    for sentence in page.sentences if in_full else ():
        paragraph(sentence, "")


def heading(text: str, more: str = "", *, apart: bool = True) -> None:
    """Print a heading after a blank line, in bold if the terminal can show it."""
    print_result(("\n" if apart else "") + f"{typer.style(seen(text), bold=True)} {seen(more)}".rstrip())


def paragraph(text: str, indent: str = "  ") -> None:
    """Print a paragraph, wrapped on a terminal, on one line elsewhere; nothing if it is empty."""
    if text:
        print_result(_wrapped(text, indent, f"{indent}  "))


def show_facts(facts: "Sequence[Fact]", width: int) -> None:
    """Print facts, with aligned values after names of a given width."""
    for fact in facts:
        print_result(_wrapped(fact.value, f"  {seen(fact.name):<{width}}  ", " " * (width + 4)))


def _wrapped(text: str, first: str, others: str) -> str:
    width = line_width()
    if width is None:
        return f"{first}{seen(text)}"
    return "\n".join(wrapped(seen(text), width, first, others))


def _widest(facts: "Iterable[Fact]") -> int:
    return max((len(seen(fact.name)) for fact in facts), default=0)


def _section(title: str, lines: Sequence[str], *, apart: bool = True) -> None:
    if lines:
        heading(title, apart=apart)
    for line in lines:
        paragraph(line)


def _show_table(told: "TextTable") -> None:
    width = line_width()
    shown = told if width is None or fits(told.columns, told.rows, width) else told.without_spare()
    table(f"  {shown.title}", shown.columns, shown.rows)

"""What commands print: results on stdout, as text or as one JSON document; progress and messages on stderr."""

import json
import os
import re
import shutil
import sys
import unicodedata
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import typer

if TYPE_CHECKING:
    from tribopipe.base.errors import TribopipeError
    from tribopipe.pipeline.stages import Outcome

DONE, FAILED, USAGE, PARTLY_FAILED = 0, 1, 2, 3
_JSON_ASKED = ContextVar("json_asked", default=False)


_UNSEEN = "[\x00-\x1f\x7f-\x9f\u061c\u200b-\u200f\u2028-\u202e\u2060-\u206f\ufeff\ud800-\udfff]"
"""Characters that would steer a terminal, or turn and hide what stands beside them."""
_NO_LAYOUT = re.compile(rf"(?![\n\t]|\x1b\[[01]m){_UNSEEN}")
"""Those that are neither ends of lines nor tabs, nor begin or end what is bold."""


def say(text: str) -> None:
    """Put a message on stderr. No name of a file within it steers the terminal."""
    typer.echo(_NO_LAYOUT.sub(_escaped, text), err=True)


def print_result(text: str) -> None:
    """Put a result on stdout, or on stderr where ``--json`` asks for a document there; as safely as ``say``."""
    typer.echo(_NO_LAYOUT.sub(_escaped, text), err=_JSON_ASKED.get())


def keep_stdout_for_json(asked: bool) -> bool:
    """Keep stdout for the document that ``--json`` asks for, or for results."""
    _JSON_ASKED.set(asked)
    return asked


def print_json(document: Any) -> None:
    """Put one JSON document on stdout, in ASCII, which every console and pipe can carry."""
    typer.echo(json.dumps(document, indent=2))


def record_json(record: Any) -> Any:
    """Turn a record, or nothing, into JSON types."""
    return None if record is None else record.model_dump(mode="json", by_alias=True)


def table(title: str, columns: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Show a table; no cell is cut, however narrow the terminal."""
    print_result("\n".join(_lines(title, columns, rows)))


def split_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]], *, at: int) -> None:
    """Show a table, or two beneath each other that share the first column where the terminal is too narrow for it."""
    if not sys.stdout.isatty() or sum(_widths(columns, rows)) + len(_GAP) * len(columns) <= terminal_width():
        table(title, columns, rows)
        return
    table(title, columns[:at], [row[:at] for row in rows])
    table("", [columns[0], *columns[at:]], [[row[0], *row[at:]] for row in rows])


_GAP = "   "


def seen(text: str) -> str:
    """Return a text on one line in which every character can be seen, so that none steers the terminal."""
    if text.isprintable():
        return text
    return re.sub(_UNSEEN, _escaped, " ".join(text.split()))


def _escaped(found: re.Match[str]) -> str:
    return found[0].encode("unicode_escape").decode()


def _lines(title: str, columns: Sequence[str], rows: Iterable[Sequence[str]]) -> Iterator[str]:
    """Write a table: its title, the heads of its columns in bold over a rule, and its rows."""
    shown = [[seen(cell) for cell in row] for row in (columns, *rows)]
    widths = _widths(columns, shown)
    head, *rest = (_line(row, widths) for row in shown)
    yield from [seen(title), ""] if title else [""]
    yield typer.style(head, bold=True)
    yield " " + "─" * (sum(widths) + len(_GAP) * (len(widths) - 1))
    yield from rest
    yield ""


def _line(row: Sequence[str], widths: Sequence[int]) -> str:
    cells = (cell + " " * (width - _width(cell)) for cell, width in zip(row, widths, strict=True))
    return f" {_GAP.join(cells)}".rstrip()


def _widths(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> list[int]:
    """Return how wide each column is shown, in characters of a terminal."""
    return [max(map(_width, cells)) for cells in zip(columns, *rows, strict=True)]


@cache
def _width(text: str) -> int:
    """Return how many places of a terminal a text takes: two for a wide character, none for an accent put on it."""
    if text.isascii():
        return len(text)
    return sum(_places(character) for character in text)


@cache
def _places(character: str) -> int:
    if unicodedata.combining(character):
        return 0
    return 2 if unicodedata.east_asian_width(character) in "WF" else 1


def terminal_width() -> int:
    """Return the width of the terminal that people read on, as COLUMNS says, or the terminal itself."""
    try:
        own = os.get_terminal_size(sys.stdout.fileno())
    except OSError:
        own = os.terminal_size((80, 24))
    return shutil.get_terminal_size(own).columns


class Advance(Protocol):
    """Moves a bar."""

    def __call__(self, name: str, *, by: int = 1) -> None:
        """Show the name of the work just done, and move by as much."""


def _go_unseen(name: str, *, by: int = 1) -> None: ...


@contextmanager
def progress(what: str, total: int | None) -> Iterator[Advance]:
    """Show a bar on a terminal, and nothing elsewhere; call what is given with the name of the work just done."""
    if not sys.stderr.isatty():
        yield _go_unseen
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    from tribopipe.base.interrupts import undone_by

    layout = (TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    # Rich would print on stderr what goes to stdout meanwhile.
    shown = Progress(*layout, console=Console(stderr=True), transient=True, redirect_stdout=sys.stdout.isatty())
    with undone_by(_clear_line), shown as bar:
        task = bar.add_task(what, total=total)

        def advance(name: str, *, by: int = 1) -> None:
            bar.update(task, advance=by, description=seen(f"{what} {name}"))

        yield advance


def _clear_line() -> None:
    """Take a bar off a terminal, and show the cursor that it hid; by no stream, for one may be half-way through."""
    os.write(sys.stderr.fileno(), b"\r\x1b[K\x1b[?25h")


def say_where_to_read(codes: Iterable[str]) -> None:
    """Name the sections that say more of errors and findings, on a terminal; nothing where they were not installed."""
    asked = dict.fromkeys(codes)
    if not asked or not sys.stderr.isatty():
        return
    from tribopipe.base.errors import TribopipeError
    from tribopipe.cli.manual import links, sections

    with suppress(TribopipeError, OSError):
        known = [code for code in asked if code in sections()]
        if known:
            say("\n".join([f"more on this: tribopipe help {' '.join(known)}", *links(known)]))


def located(path: Path, error: "TribopipeError") -> "TribopipeError":
    """Say in which folder the file is that an error names."""
    inside = str(error).startswith(path.name) and path.parent != Path()
    return type(error)(f"{path.parent}: {error}") if inside else error


def in_order(outcomes: "Iterable[Outcome]") -> "list[Outcome]":
    """Return outcomes of a batch in the order of its runs, whichever came first."""
    return sorted(outcomes, key=lambda outcome: outcome.place)


def finish(outcomes: "Sequence[Outcome]") -> None:
    """Tell every failure, and exit accordingly; a run of which one step failed counts as failed."""
    failed_runs = {outcome.run_id for outcome in outcomes if outcome.error is not None}
    some_done = any(outcome.run_id not in failed_runs for outcome in outcomes)
    warned = [one.code for outcome in outcomes for one in outcome.findings if one.severity == "warning"]
    errors = [outcome.error for outcome in outcomes if outcome.error is not None]
    exit_with(errors, some_done=some_done, warned=warned)


def exit_with(errors: "Sequence[TribopipeError]", *, some_done: bool, warned: Sequence[str] = ()) -> None:
    """Tell every error once, and exit with 0, 1 (nothing done) or 3 (part of the batch failed).

    ``warned`` names the checks that have warned of something meanwhile.
    """
    for message in dict.fromkeys(str(error) for error in errors):
        say(f"error: {message}")
    say_where_to_read([*(error.code for error in errors), *warned])
    if errors:
        raise typer.Exit(PARTLY_FAILED if some_done else FAILED)

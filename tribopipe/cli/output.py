"""What commands print: results on stdout, as text or as one JSON document; progress and messages on stderr."""

import itertools
import json
import os
import re
import shutil
import sys
import textwrap
import unicodedata
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from contextlib import contextmanager, nullcontext, suppress
from contextvars import ContextVar
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

import typer

from tribopipe.base.column_formatting import WITHIN_NUMBER

if TYPE_CHECKING:
    from tribopipe.base.errors import TribopipeError
    from tribopipe.pipeline.stages import Outcome

Item = TypeVar("Item", bound=Hashable)
Result = TypeVar("Result")
DONE, FAILED, USAGE, PARTLY_FAILED = 0, 1, 2, 3
_JSON_ASKED = ContextVar("json_asked", default=False)


_UNSEEN = "[\x00-\x1f\x7f-\x9f\u061c\u200b-\u200f\u2028-\u202e\u2060-\u206f\ufeff\ud800-\udfff]"
"""Characters that would control a terminal, or reverse or hide adjacent text."""
_NO_LAYOUT = re.compile(rf"(?![\n\t]|\x1b\[[01]m){_UNSEEN}")
"""Those characters, except line ends, tabs, and the start and end of bold text."""


def safe(text: str) -> str:
    """Return a text without characters that control the terminal; lines, tabs and bold are kept."""
    return _NO_LAYOUT.sub(_escaped, text)


def say(text: str) -> None:
    """Print a message to stderr, wrapped to the terminal; control characters in file names are escaped."""
    _put(text, on_stderr=True)


def print_result(text: str) -> None:
    """Print a result to stdout, or to stderr if ``--json`` requests a document on stdout; as safely as ``say``."""
    _put(text, on_stderr=_JSON_ASKED.get())


def _put(text: str, *, on_stderr: bool) -> None:
    lines, width = safe(text).split("\n"), line_width(on_stderr=on_stderr)
    if width is not None:
        lines = [part for line in lines for part in _wrapped(line, width)]
    typer.echo("\n".join(lines), err=on_stderr)


def line_width(*, on_stderr: bool | None = None) -> int | None:
    """Return the maximum line width, from COLUMNS or the terminal; None for output to a file or a pipe.

    By default, that of results.
    """
    stream = sys.stderr if (_JSON_ASKED.get() if on_stderr is None else on_stderr) else sys.stdout
    if not stream.isatty():
        return None
    try:
        own = os.get_terminal_size(stream.fileno())
    except OSError:
        own = os.terminal_size((80, 24))
    return max(_NARROWEST, shutil.get_terminal_size(own).columns)


_NARROWEST = 40
"""Smallest width for which text is laid out; a narrower terminal wraps lines itself."""
_BOLD = re.compile(r"\x1b\[[01]m")


def _wrapped(line: str, width: int) -> Sequence[str]:
    """Break a line that is wider than the terminal at its spaces, with further lines indented."""
    if _width(_BOLD.sub("", line)) <= width:
        return [line]
    return wrapped(line, width, "", " " * (len(line) - len(line.lstrip()) + 2))


_COMMAND = re.compile("`[^`]*`")


def wrapped(text: str, width: int, first: str, others: str) -> list[str]:
    """Break a text at spaces into lines of a width, but not within numbers or commands that fit on a line."""

    def whole(command: re.Match[str]) -> str:
        return command[0].replace(" ", "\u00a0") if len(command[0]) < width - len(others) else command[0]

    lines = textwrap.wrap(
        _COMMAND.sub(whole, WITHIN_NUMBER.sub("\u00a0", text)),
        width,
        initial_indent=first,
        subsequent_indent=others,
        break_long_words=False,
        break_on_hyphens=False,
        expand_tabs=False,
    )
    return [line.replace("\u00a0", " ") for line in lines]


def keep_stdout_for_json(asked: bool) -> bool:
    """Reserve stdout for the document requested by ``--json``, or for results."""
    _JSON_ASKED.set(asked)
    return asked


def print_json(document: Any, *, indent: int | None = 2) -> None:
    """Print one JSON document to stdout in printable ASCII, which every console and pipe can encode."""
    typer.echo(json.dumps(document, indent=indent).replace("\x7f", r"\u007f"))


def print_file(content: bytes) -> None:
    """Print a text file to stdout: unchanged bytes, or escaped lines on a terminal."""
    if not sys.stdout.isatty():
        typer.echo(content, nl=False)
        return
    for line in content.decode(errors="backslashreplace").removesuffix("\r\n").split("\r\n"):
        typer.echo(seen(line))


def record_json(record: Any) -> Any:
    """Convert a record, or None, to JSON types."""
    return None if record is None else record.model_dump(mode="json", by_alias=True)


def table(title: str, columns: Sequence[str], rows: Iterable[Sequence[str]], *, spaced: bool = True) -> None:
    """Show a table; no cell is truncated or wider than the terminal.

    On a terminal that is too narrow, texts within cells are broken, or each row is shown on separate lines.
    With ``spaced``, blank lines separate it from its title and from the text below.
    """
    print_result("\n".join(_lines(title, columns, rows, spaced=spaced)))


_GAP, _NARROW_GAP = "   ", "  "


def seen(text: str) -> str:
    """Return a text on one line without control characters, so that it cannot control the terminal."""
    if text.isprintable():
        return text
    return re.sub(_UNSEEN, _escaped, " ".join(text.split()))


def _escaped(found: re.Match[str]) -> str:
    return found[0].encode("unicode_escape").decode()


def _lines(title: str, columns: Sequence[str], rows: Iterable[Sequence[str]], *, spaced: bool) -> Iterator[str]:
    """Yield the lines of a table: its title, the column headers in bold above a rule, and its rows."""
    shown = [[seen(cell) for cell in row] for row in (columns, *rows)]
    between = [""] if spaced else []
    yield from [seen(title), *between] if title else between
    yield from laid_out(shown, line_width())
    yield from between


def laid_out(shown: Sequence[Sequence[str]], width: int | None) -> Iterator[str]:
    """Lay out rows, the first of which contains the headers, within a width if there is one."""
    gap, widths = _GAP, _widths(shown[0], shown)
    if width is not None and _total(widths, gap) > width:
        gap = _NARROW_GAP
        narrowed = _narrowed(shown, width - 1 - len(gap) * (len(widths) - 1))
        if narrowed is None:
            yield from _one_by_one(shown)
            return
        widths = narrowed
    head, *rest = ([_broken(cell, limit) for cell, limit in zip(row, widths, strict=True)] for row in shown)
    yield from (typer.style(line, bold=True) for line in _beneath(head, widths, gap))
    yield " " + "─" * (_total(widths, gap) - 1)
    for row in rest:
        yield from _beneath(row, widths, gap)


def fits(heads: Sequence[str], rows: Sequence[Sequence[str]], width: int) -> bool:
    """Return whether a table fits into a width without breaking cells other than headers."""
    bodies = (max([_least(head), *map(_width, cells)]) for head, cells in _columns_of(heads, rows))
    return _total(list(bodies), _NARROW_GAP) <= width


def _total(widths: Sequence[int], gap: str) -> int:
    return 1 + sum(widths) + len(gap) * (len(widths) - 1)


def _narrowed(shown: Sequence[Sequence[str]], room: int) -> list[int] | None:
    """Return column widths that fit the available width, wrapping headers before cells; None if none fit."""
    heads, *rows = shown
    natural = _widths(heads, shown)
    bodies = [max([_least(head), *map(_width, cells)]) for head, cells in _columns_of(heads, rows)]
    least = [max(map(_least, (head, *cells))) for head, cells in _columns_of(heads, rows)]
    named = [bodies[0], *least[1:]]  # what a row is called stays on its line if it can
    for wide, narrow in ((natural, bodies), (bodies, named), (bodies, least)):
        if sum(narrow) <= room:
            return _shared(wide, narrow, room)
    return None


def _columns_of(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[tuple[str, Sequence[str]]]:
    """Yield the header and the cells of each column."""
    yield from ((head, [row[at] for row in rows]) for at, head in enumerate(heads))


def _shared(wide: Sequence[int], narrow: Sequence[int], room: int) -> list[int]:
    """Reduce the widest columns until all fit, none below its minimum width."""
    widths = list(wide)
    while sum(widths) > room:
        at = max(range(len(widths)), key=lambda place: (widths[place] > narrow[place], widths[place]))
        widths[at] -= 1
    return widths


_BREAK = re.compile(r"(?<![±\d ]) ++(?!±)")
"""Positions at which a cell may be broken: not within a number with its uncertainty and unit."""


_LONG_WORD = 24
"""Length from which a word is broken after its points and slashes, such as the path of a value."""
_WITHIN_WORD = re.compile(r"(?<=[./:])(?=\w)")


def _pieces(cell: str) -> Iterator[tuple[str, str]]:
    """Yield the unbreakable parts of a cell, each with the space before it on the same line."""
    for word in _BREAK.split(cell):
        parts = _WITHIN_WORD.split(word) if len(word) > _LONG_WORD and "±" not in word else [word]
        yield from ((part, "" if at else " ") for at, part in enumerate(parts))


def _least(cell: str) -> int:
    return max((_width(part) for part, _ in _pieces(cell)), default=0)


def _broken(cell: str, width: int) -> list[str]:
    """Break the text of a cell into lines no wider than its column."""
    if _width(cell) <= width:
        return [cell]
    lines = [""]
    for part, before in _pieces(cell):
        longer = f"{lines[-1]}{before}{part}".lstrip()
        if lines[-1] and _width(longer) > width:
            lines.append(part)
        else:
            lines[-1] = longer
    return lines


def _beneath(cells: Sequence[Sequence[str]], widths: Sequence[int], gap: str) -> Iterator[str]:
    """Write the cells of a row side by side, each on as many lines as needed."""
    for parts in itertools.zip_longest(*cells, fillvalue=""):
        padded = (part + " " * (width - _width(part)) for part, width in zip(parts, widths, strict=True))
        yield f" {gap.join(padded)}".rstrip()


def _one_by_one(shown: Sequence[Sequence[str]]) -> Iterator[str]:
    """Write each row on separate lines: its name, then the cell of each other column."""
    (_, *heads), *rows = shown
    widest = max(map(_width, heads), default=0)
    for called, *cells in rows:
        if called:
            yield typer.style(f" {called}", bold=True)
        for head, cell in zip(heads, cells, strict=True):
            if cell:
                yield f"   {head}{' ' * (widest - _width(head))}  {cell}"


def _widths(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> list[int]:
    """Return the width of each column, in terminal cells."""
    return [max(map(_width, cells)) for cells in zip(columns, *rows, strict=True)]


@cache
def _width(text: str) -> int:
    """Return the width of a text in terminal cells: two for a wide character, none for a combining accent."""
    if text.isascii():
        return len(text)
    return sum(_places(character) for character in text)


@cache
def _places(character: str) -> int:
    if unicodedata.combining(character):
        return 0
    return 2 if unicodedata.east_asian_width(character) in "WF" else 1


class Advance(Protocol):
    """Advances a progress bar."""

    def __call__(self, name: str, *, by: int = 1) -> None:
        """Show the name of the work just done, and advance by its amount."""


def _go_unseen(name: str, *, by: int = 1) -> None: ...


@contextmanager
def progress(what: str, total: int | None) -> Iterator[Advance]:
    """Show a progress bar on a terminal, nothing elsewhere; call the yielded object with the name of the work done."""
    if not sys.stderr.isatty():
        yield _go_unseen
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    from tribopipe.base.process_lifecycle import undone_by

    layout = (TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    # Rich would print on stderr what goes to stdout meanwhile.
    shown = Progress(*layout, console=Console(stderr=True), transient=True, redirect_stdout=sys.stdout.isatty())
    with undone_by(_clear_line), shown as bar:
        task = bar.add_task(what, total=total)

        def advance(name: str, *, by: int = 1) -> None:
            bar.update(task, advance=by, description=seen(f"{what} {name}"))

        yield advance


def followed(
    outcomes: "Iterable[Outcome]", what: str, total: int | None, tell: "Callable[[Outcome], object] | None" = None
) -> "list[Outcome]":
    """Collect outcomes as they come, with a progress bar, and report each."""
    found = []
    with progress(what, total) as advance:
        for outcome in outcomes:
            found.append(outcome)
            if tell is not None:
                tell(outcome)
            advance(outcome.run_id)
    return found


def attempt_each(
    items: Iterable[Item], take: Callable[[Item], Result], what: str | None = None
) -> "tuple[dict[Item, Result], dict[Item, TribopipeError]]":
    """Do something with each item, once, whatever becomes of the others; return results, and errors.

    ``what`` is what a progress bar calls it; none without a bar.
    """
    from tribopipe.base.failures import in_a_sentence

    each = dict.fromkeys(items)
    done: dict[Item, Result] = {}
    errors: dict[Item, TribopipeError] = {}
    with nullcontext(_go_unseen) if what is None else progress(what, len(each)) as advance:
        for item in each:
            try:
                done[item] = take(item)
            except Exception as error:  # noqa: BLE001 - a fault in one is no reason to leave the others
                errors[item] = in_a_sentence(error, str(item))
            advance(item.name if isinstance(item, Path) else str(item))
    return done, errors


def _clear_line() -> None:
    """Remove a progress bar from a terminal and show the cursor, without a stream, which may be in use."""
    os.write(sys.stderr.fileno(), b"\r\x1b[K\x1b[?25h")


def say_where_to_read(codes: Iterable[str]) -> None:
    """Name the sections with more on errors and findings, on a terminal only; nothing if they are not installed."""
    asked = dict.fromkeys(codes)
    if not asked or not sys.stderr.isatty():
        return
    from tribopipe.base.errors import TribopipeError
    from tribopipe.cli.documentation import links, sections

    with suppress(TribopipeError, OSError):
        known = [code for code in asked if code in sections()]
        if known:
            say("\n".join([f"more on this: tribopipe help {' '.join(known)}", *links(known)]))


def located(path: Path, error: "TribopipeError") -> "TribopipeError":
    """Add the folder of the file to an error that names only the file."""
    inside = str(error).startswith(path.name) and path.parent != Path()
    return type(error)(f"{path.parent}: {error}") if inside else error


def in_order(outcomes: "Iterable[Outcome]") -> "list[Outcome]":
    """Return outcomes of a batch in the order of its runs, regardless of which finished first."""
    return sorted(outcomes, key=lambda outcome: outcome.place)


def print_outcomes(outcomes: "Iterable[Outcome]") -> None:
    """Print what steps of runs found as one document."""
    print_json(
        {"runs": [{"id": outcome.run_id} | record_json(outcome.result) for outcome in outcomes if outcome.result]}
    )


def finish(outcomes: "Sequence[Outcome]", *, in_full: bool = True) -> None:
    """Report every failure, and exit accordingly; a run with a failed step counts as failed.

    ``in_full`` is set if warnings were printed as sentences, which the documentation explains.
    """
    failed_runs = {outcome.run_id for outcome in outcomes if outcome.error is not None}
    some_done = any(outcome.run_id not in failed_runs for outcome in outcomes)
    warned = [one.code for outcome in outcomes for one in outcome.findings if one.severity == "warning"]
    errors = [outcome.error for outcome in outcomes if outcome.error is not None]
    exit_with(errors, some_done=some_done, warned=warned if in_full else ())


def exit_with(errors: "Sequence[TribopipeError]", *, some_done: bool, warned: Sequence[str] = ()) -> None:
    """Report every error once, and exit with 0, 1 (nothing done) or 3 (part of the batch failed).

    ``warned`` names the checks that have produced warnings.
    """
    for message in dict.fromkeys(str(error) for error in errors):
        say(f"error: {message}")
    say_where_to_read([*(error.code for error in errors), *warned])
    if errors:
        raise typer.Exit(PARTLY_FAILED if some_done else FAILED)

"""How results are shown: tables and sentences on stderr for people, one JSON document on stdout for programs."""

import json
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from rich.table import Table

    from tribopipe.errors import TribopipeError
    from tribopipe.pipeline import Outcome

DONE, FAILED, USAGE, PARTLY_FAILED = 0, 1, 2, 3


def say(text: str) -> None:
    """Tell people something."""
    typer.echo(text, err=True)


def print_json(document: Any) -> None:
    """Put one JSON document on stdout, in ASCII, which every console and pipe can carry."""
    typer.echo(json.dumps(document, indent=2))


def record_json(record: Any) -> Any:
    """Turn a record, or nothing, into JSON types."""
    return None if record is None else record.model_dump(mode="json", by_alias=True)


def table(title: str, columns: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Show a table on stderr; no cell is cut, however narrow the terminal."""
    from rich.console import Console

    shown = _table(title, columns, rows)
    Console(stderr=True, width=max(_width(shown), Console(stderr=True).width)).print(shown, soft_wrap=True)


def split_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]], *, at: int) -> None:
    """Show a table, or two beneath each other that share the first column where the terminal is too narrow for it."""
    from rich.console import Console

    console = Console(stderr=True)
    if not console.is_terminal or _width(_table(title, columns, rows)) <= console.width:
        table(title, columns, rows)
        return
    table(title, columns[:at], [row[:at] for row in rows])
    table("", [columns[0], *columns[at:]], [[row[0], *row[at:]] for row in rows])


def _table(title: str, columns: Sequence[str], rows: Iterable[Sequence[str]]) -> "Table":
    from rich import box
    from rich.table import Table
    from rich.text import Text

    shown = Table(title=Text(title), box=box.SIMPLE_HEAD, title_justify="left", title_style="bold", pad_edge=False)
    for name in columns:
        shown.add_column(name, no_wrap=True)
    for row in rows:
        shown.add_row(*map(Text, row))
    return shown


def _width(shown: "Table") -> int:
    from rich.console import Console

    return Console(width=10_000).measure(shown).maximum


@contextmanager
def progress(what: str, total: int | None) -> Iterator[Callable[[str], None]]:
    """Show a bar on a terminal, and nothing elsewhere; call what is given with the name of the work just done."""
    if not sys.stderr.isatty():
        yield lambda _: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    layout = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*layout, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(what, total=total)

        def advance(name: str) -> None:
            bar.update(task, advance=1, description=f"{what} {name}")

        yield advance


def located(path: Path, error: "TribopipeError") -> "TribopipeError":
    """Say in which folder the file is that an error names."""
    inside = str(error).startswith(path.name) and path.parent != Path()
    return type(error)(f"{path.parent}: {error}") if inside else error


def finish(outcomes: "Sequence[Outcome]") -> None:
    """Tell every failure, and exit accordingly; a run of which one step failed counts as failed."""
    failed_runs = {outcome.run_id for outcome in outcomes if outcome.error is not None}
    some_done = any(outcome.run_id not in failed_runs for outcome in outcomes)
    exit_with([outcome.error for outcome in outcomes if outcome.error is not None], some_done=some_done)


def exit_with(errors: "Sequence[TribopipeError]", *, some_done: bool) -> None:
    """Tell every error once, and exit with 0, 1 (nothing done) or 3 (part of the batch failed)."""
    for message in dict.fromkeys(str(error) for error in errors):
        say(f"error: {message}")
    if errors:
        raise typer.Exit(PARTLY_FAILED if some_done else FAILED)

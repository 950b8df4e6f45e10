"""The command that repeats a computation for many values: sweep."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tribopipe.cli.options import (
    DEFAULT_ARCHIVE,
    ArchiveFolder,
    AsJson,
    Jobs,
    RecipeFile,
    Scheduler,
    Shard,
    crew,
    load_recipe,
    require_archive,
    seen_by,
)
from tribopipe.cli.output import exit_with, print_json, print_result, progress, record_json, say

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tribopipe.base.errors import TribopipeError
    from tribopipe.base.executor import Crew
    from tribopipe.documents.sweep import Sweep
    from tribopipe.extras.sweep.cases import Case, Head, Row
    from tribopipe.extras.sweep.execution import Table


_PICTURES = (".svg", ".png", ".pdf")


def sweep(
    document: Annotated[Path, typer.Argument(help="TOML file with the parameters to vary.", metavar="SWEEP.toml")],
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    recipe: RecipeFile = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", help="CSV file for the results; existing rows are not recomputed.", metavar="FILE"),
    ] = None,
    reuse: Annotated[
        list[Path] | None,
        typer.Option(
            "--reuse",
            help="CSV file with results of the same sweep, such as those of a shard; may be repeated.",
            metavar="FILE",
        ),
    ] = None,
    figure: Annotated[
        Path | None, typer.Option("--figure", help="Figure of the results: SVG, PNG or PDF.", metavar="FILE")
    ] = None,
    jobs: Jobs = None,
    scheduler: Scheduler = None,
    shard: Shard = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Show the number of cases without computing them.")
    ] = False,
    force: Annotated[bool, typer.Option("--force", help="Compute all cases again.")] = False,
    as_json: AsJson = False,
) -> None:
    """Evaluate, predict or simulate for every combination of values.

    The TOML file defines the purpose: effect of evaluation choices on k_D, wear and service life under other
    conditions, or recovery of k_D from virtual tests.
    """
    from tribopipe.documents.record import load_toml
    from tribopipe.documents.sweep import Sweep
    from tribopipe.extras.sweep.execution import Table, ensemble
    from tribopipe.pipeline.output_paths import made_here, require_free

    if figure is not None and figure.suffix not in _PICTURES:
        raise typer.BadParameter(
            f"--figure: found {figure.name}; expected a file name that ends in {', '.join(_PICTURES)}"
        )
    require_free([] if figure is None else [figure], force=force, own=made_here)
    require_free([] if out is None else [out], force=True)  # the rows that are there are taken over
    asked = load_toml(document, Sweep)
    if asked.needs_archive:
        require_archive(archive)
    who = crew(jobs, scheduler)
    whole = ensemble(asked, document, seen_by(who, archive), load_recipe(recipe))
    table = Table(whole, whole.cases if shard is None else shard.chosen(whole.cases), out)
    _take_over(table, reuse or [], force=force)
    if dry_run:
        _tell_size(table, as_json=as_json)
        return
    errors = _fill(table, who)
    _show(asked, table, as_json=as_json)
    if figure is not None:
        _draw(asked, table, figure)
    exit_with(errors, some_done=table.has_answers)


def _take_over(table: "Table", reuse: "Sequence[Path]", *, force: bool) -> None:
    """Reuse existing rows."""
    there = [table.path] if table.path is not None and table.path.exists() and not force else []
    for path in (*reuse, *there):
        others = table.reuse(path)
        if others:
            say(f"{path}: ignored the rows of {others} cases with different inputs or from another tribopipe version")
    kept = len(table.cases) - len(table.missing)
    if kept:
        say(f"{kept} of {len(table.cases)} cases are already computed; use --force to recompute them.")


def _tell_size(table: "Table", *, as_json: bool) -> None:
    todo = len(table.missing)
    say(f"{len(table.cases)} cases, {todo} to compute: {', '.join(head.name for head in table.ensemble.labels)}")
    if as_json:
        print_json({"cases": len(table.cases), "missing": todo})


def _fill(table: "Table", who: "Crew") -> "list[TribopipeError]":
    """Compute the missing cases; return the errors, with one for all cases that failed for the same reason."""
    failed: dict[str, tuple[TribopipeError, list[str]]] = {}
    with progress("sweep", len(table.missing)) as advance:
        for case, error in table.fill(who):
            if error is not None:
                failed.setdefault(str(error), (error, []))[1].append(case.name)
            advance(case.name)
    if table.path is not None:
        say(f"{table.path}: {sum(map(len, table.rows.values()))} rows")
    return [type(error)(f"{_named(cases)}: {error}") for error, cases in failed.values()]


def _named(cases: list[str]) -> str:
    return cases[0] if len(cases) == 1 else f"{cases[0]} and {len(cases) - 1} other cases"


def _show(asked: "Sweep", table: "Table", *, as_json: bool) -> None:
    from tribopipe.cli.sweep_tables import show_rows, show_summaries
    from tribopipe.extras.sweep.cases import answers
    from tribopipe.extras.sweep.summary import summarised

    summaries = summarised(asked, table.ensemble, table.rows)
    if not as_json:
        show_rows(asked, table.ensemble, table.rows)
        show_summaries(table.ensemble.labels, summaries)
        return
    rows = [_row_json(table.ensemble.labels, *answer) for answer in answers(table.ensemble, table.rows)]
    print_json({"sweep": record_json(asked), "rows": rows, "summary": [record_json(one) for one in summaries]})


def _row_json(labels: "Sequence[Head]", case: "Case", row: "Row") -> dict[str, Any]:
    told = {head.name: case.labels[head.name] for head in labels}
    found = {name: record_json(quantity) for name, quantity in row.found.items()}
    return {"case": told, "body": row.body, "outcome": row.outcome, **found, "why": row.why or None}


def _draw(asked: "Sweep", table: "Table", path: Path) -> None:
    from tribopipe.extras.sweep.figures import plot_sweep
    from tribopipe.views.run_figures import save_figure

    save_figure(plot_sweep(asked, table.ensemble, table.rows), path)
    print_result(str(path))

"""The command that computes again what is archived: reproduce."""

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Annotated

import typer

from tribopipe.cli.options import DEFAULT_ARCHIVE, ArchiveFolder, AsJson, archived_ids, chosen_ids, load_archive
from tribopipe.cli.output import FAILED, exit_with, print_json, print_result, progress, seen, table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tribopipe.archive.store import Archive
    from tribopipe.pipeline.reproduce import Redone, Reproduction

_MOST_SHOWN = 3
_WIDEST = 60


def reproduce(
    ids: Annotated[
        list[str] | None,
        typer.Argument(
            help="IDs of archived runs and studies; default: all.", metavar="ID", autocompletion=archived_ids
        ),
    ] = None,
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    as_json: AsJson = False,
) -> None:
    """Recompute archived results and compare every number.

    Runs and studies are computed from their source files.

    Nothing is written. Exit code 1 if a result differs or cannot be compared.
    """
    from tribopipe.base.errors import TribopipeError

    store = load_archive(archive)
    chosen, found, errors = _chosen(store, ids or []), [], []
    with progress("reproduce", len(chosen)) as advance:
        for name, compute in chosen:
            try:
                found.append(compute(store, name))
            except TribopipeError as error:
                errors.append(error)
            advance(name)
    _show(found)
    if as_json:
        print_json({"reproduced": [one.as_json() for one in found], "errors": [str(error) for error in errors]})
    same = all(one.same for one in found)
    exit_with(errors, some_done=same and bool(found))
    if not same:
        raise typer.Exit(FAILED)


def _chosen(store: "Archive", ids: "Sequence[str]") -> "list[tuple[str, Callable[[Archive, str], Reproduction]]]":
    """Return the runs and studies to compute again, each with its function.

    Raises ``ArchiveError`` for an id that is not in the archive, or where there is nothing.
    """
    from tribopipe.base.errors import ArchiveError, did_you_mean
    from tribopipe.pipeline.reproduce import reproduce, reproduce_study

    runs, studies = chosen_ids(store, None), store.study_ids()
    for name in ids:
        if name not in (*runs, *studies):
            raise ArchiveError(
                f"{store.folder}: found no run and no study {name!r}; expected one in the archive; "
                f"{did_you_mean(name, [*runs, *studies])}"
            )
    wanted = set(ids or (*runs, *studies))
    return [
        *((name, reproduce) for name in runs if name in wanted),
        *((name, reproduce_study) for name in studies if name in wanted),
    ]


def _show(found: "Sequence[Reproduction]") -> None:
    """Show a line for each run and study, or for each step of a single one, and beneath what is not the same."""
    if len(found) == 1:
        (one,) = found
        title, rows = f"{one.id}, computed again", [_row(step.name, [step]) for step in one.steps]
    else:
        title, rows = "computed again", [_row(one.id, one.steps) for one in found]
    if rows:
        table(title, ["", "values", "outcome", "largest difference", "where"], rows)
    for one in found:
        for step in one.steps:
            for line in _told(step):
                print_result(f"{one.id}: {step.name}: {seen(line)}")
    _say_environments(found)


def _row(name: str, steps: "Sequence[Redone]") -> list[str]:
    worst = max(steps, key=lambda step: step.apart)
    values = f"{sum(step.compared for step in steps):,}"
    if not worst.differences:
        return [name, values, worst.outcome, "–", "–" if worst.same else worst.name]
    first = worst.differences[0]
    apart = "–" if first.relative is None else f"{first.relative:.1e}"
    return [name, values, worst.outcome, apart, f"{worst.name}: {first.where}"]


def _told(step: "Redone") -> Iterator[str]:
    """Yield the differences of a step, the largest first."""
    if step.why is not None:
        yield f"not compared: {step.why}"
    if step.outcome != "different":
        return
    for one in step.differences[:_MOST_SHOWN]:
        yield f"{one.where} is archived as {_short(one.then)}, and now {_short(one.now)}"
    if len(step.differences) > _MOST_SHOWN:
        yield f"and {len(step.differences) - _MOST_SHOWN} more; --json lists all"


def _short(value: object) -> str:
    text = str(value)
    return text if len(text) <= _WIDEST else f"{text[: _WIDEST - 1]}…"


def _say_environments(found: "Sequence[Reproduction]") -> None:
    """State once with which other versions the steps were computed when they were archived."""
    changed = {(name, *both): None for one in found for step in one.steps for name, both in step.environment.items()}
    for name, then, now in changed:
        print_result(f"archived with {name} {then}, computed now with {now}")

"""Commands on the integrity of an archive: verify, reproduce, rescue."""

import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tribopipe.cli.options import (
    DEFAULT_ARCHIVE,
    ArchiveFolder,
    AsJson,
    JobsOnAllCores,
    archived_ids,
    chosen_ids,
    crew,
    load_archive,
    on_this_computer,
)
from tribopipe.cli.output import FAILED, attempt_each, exit_with, print_json, print_result, progress, say, seen, table

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from tribopipe.archive.rescue import Rescued
    from tribopipe.archive.store import Archive
    from tribopipe.base.errors import TribopipeError
    from tribopipe.pipeline.recomputed_values import Redone, Reproduction


_SHOWN = 16
"""Number of digits of a hash that are shown for copying."""
_FEW = 12
"""Files that are verified before other processes have begun."""
_HASH = re.compile("[0-9a-f]{8,64}")


def _hash(text: str) -> str:
    """Read the hash of a line of the history, or its first digits."""
    if not _HASH.fullmatch(text.lower()):
        raise typer.BadParameter(
            f"found {text!r}; expected 8 to 64 hexadecimal digits (0 to 9, a to f) from the output of `tribopipe "
            "verify`"
        )
    return text.lower()


def verify(
    folder: Annotated[
        Path | None,
        typer.Argument(
            help="Archive folder; default: that of --archive.", metavar="ARCHIVE", callback=on_this_computer
        ),
    ] = None,
    run_ids: Annotated[
        list[str] | None,
        typer.Option("--run", help="Verify only this run; may be repeated.", autocompletion=archived_ids),
    ] = None,
    recompute: Annotated[
        bool, typer.Option("--recompute", help="Recompute every step from the source files and compare.")
    ] = False,
    against: Annotated[
        str | None,
        typer.Option(
            "--against",
            help="Hash printed by an earlier `tribopipe verify`; detects a different or older copy of the archive.",
            metavar="HASH",
            parser=_hash,
        ),
    ] = None,
    accepted: Annotated[
        list[str] | None,
        typer.Option(
            "--accept",
            help="Accept the present state of a run or study that was removed or replaced, or of history.jsonl; may be "
            "repeated.",
            metavar="ID",
        ),
    ] = None,
    jobs: JobsOnAllCores = None,
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    as_json: AsJson = False,
) -> None:
    """Verify an archive: checksums, structure and history.

    Runs and studies are not changed. Exit code 1 on errors and warnings.
    """
    from tribopipe.base.executor import at_work
    from tribopipe.pipeline.verify.archive import files_of, verify

    if folder is not None and archive not in (DEFAULT_ARCHIVE, folder):
        raise typer.BadParameter(f"found two archives, {folder} and {archive}; expected one")
    store, chosen = load_archive(folder or archive), run_ids or []
    _accept(store, accepted or ())
    files, who = len(files_of(store.folder, chosen)), crew(jobs, None, usual=0)
    few = jobs is None and files < (2 if recompute else _FEW)
    with (
        at_work(replace(who, jobs=1) if few else who) as at_hand,
        progress("verify", files * (1 + recompute)) as advance,
    ):
        verified = verify(store, chosen, again=recompute, against=against or "", advance=advance, crew=at_hand)
    for finding in verified.findings:
        print_result(f"{finding.severity}: {seen(str(finding))}")
    if verified.lines:
        print_result(f"{store.folder}: history of {verified.lines} lines, last hash {verified.head[:_SHOWN]}")
    print_result(f"{store.folder}: {verified}")
    if as_json:
        print_json({"archive": str(store.folder)} | verified.as_json())
    if not verified.sound:
        raise typer.Exit(FAILED)


def _accept(store: "Archive", wanted: "Iterable[str]") -> None:
    from tribopipe.cli.curation import logged_in
    from tribopipe.pipeline.verify.history import accept

    for one in wanted:
        for name in accept(store.folder, one, logged_in()):
            print_result(seen(f"{name}: accepted as it is"))


Files = Annotated[list[Path], typer.Argument(help="Files of archived runs.", metavar="FILE")]
Into = Annotated[Path, typer.Option("--to", help="Output folder for run folders.")]


def rescue(files: Files, into: Into, as_json: AsJson = False) -> None:
    """Recover the source files from damaged files of an archive.

    Intact source files are written into run folders. The damaged files are not changed. Recompute the results with
    `tribopipe process`; marks, tags and notes cannot be recovered from source files.
    """
    from tribopipe.archive.rescue import rescue as save
    from tribopipe.pipeline.output_paths import require_folder

    require_folder(into)
    saved, errors = attempt_each(files, lambda path: save(path, into), "rescue")
    for path, found in saved.items():
        say(f"{path}: {len(found.whole)} source files saved in {found.folder}")
        if found.damaged or not found.listed:
            errors[path] = _lacking(path, found)
    if as_json:
        print_json(
            {"runs": [_rescued_document(path, saved.get(path), errors.get(path)) for path in dict.fromkeys(files)]}
        )
    if saved:
        say(f"Next: move the damaged files out of the archive, then run `tribopipe process {into}`.")
    exit_with([errors[path] for path in dict.fromkeys(files) if path in errors], some_done=bool(saved))


def _lacking(path: Path, found: "Rescued") -> "TribopipeError":
    from tribopipe.base.errors import ArchiveError

    if not found.listed:
        lacking = "a damaged list of source files"
        mend = f"compare the files in {found.folder} with those named in its run.toml, and copy the missing ones"
    else:
        lacking = f"damaged source files: {', '.join(map(seen, found.damaged))}"
        mend = f"copy the missing ones into {found.folder}"
    return ArchiveError(f"{path}: found {lacking}; expected intact source files; {mend} from the instrument")


def _rescued_document(path: Path, found: "Rescued | None", error: Exception | None) -> dict[str, Any]:
    return {
        "file": str(path),
        "folder": None if found is None else str(found.folder),
        "saved": [] if found is None else list(found.whole),
        "damaged": [] if found is None else list(found.damaged),
        "listed": found is not None and found.listed,
        "error": None if error is None else str(error),
    }


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
    _show_reproduced(found)
    if as_json:
        print_json({"reproduced": [one.as_json() for one in found], "errors": [str(error) for error in errors]})
    same = all(one.same for one in found)
    exit_with(errors, some_done=same and bool(found))
    if not same:
        raise typer.Exit(FAILED)


def _chosen(store: "Archive", ids: "Sequence[str]") -> "list[tuple[str, Callable[[Archive, str], Reproduction]]]":
    """Return the runs and studies to recompute, each with its function.

    Raises ``ArchiveError`` for an id that is not in the archive, or if the archive is empty.
    """
    from tribopipe.base.errors import ArchiveError, did_you_mean
    from tribopipe.pipeline.reproduce import reproduce, reproduce_study

    runs, studies = chosen_ids(store, None), store.study_ids()
    for name in ids:
        if name not in (*runs, *studies):
            raise ArchiveError(
                f"{store.folder}: found no run or study {name!r}; expected the ID of an archived run or study; "
                f"{did_you_mean(name, [*runs, *studies])}"
            )
    wanted = set(ids or (*runs, *studies))
    return [
        *((name, reproduce) for name in runs if name in wanted),
        *((name, reproduce_study) for name in studies if name in wanted),
    ]


def _show_reproduced(found: "Sequence[Reproduction]") -> None:
    """Show a line for each run and study, or for each step of a single one, followed by the differences."""
    if len(found) == 1:
        (one,) = found
        title, rows = f"{one.id}, recomputed", [_reproduced_row(step.name, [step]) for step in one.steps]
    else:
        title, rows = "recomputed", [_reproduced_row(one.id, one.steps) for one in found]
    if rows:
        table(title, ["", "values", "outcome", "largest difference", "where"], rows)
    for one in found:
        for step in one.steps:
            for line in _told(step):
                print_result(f"{one.id}: {step.name}: {seen(line)}")
    _say_environments(found)


def _reproduced_row(name: str, steps: "Sequence[Redone]") -> list[str]:
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
        yield f"{one.where}: archived {_short(one.then)}, recomputed {_short(one.now)}"
    if len(step.differences) > _MOST_SHOWN:
        yield f"and {len(step.differences) - _MOST_SHOWN} more; --json lists all"


def _short(value: object) -> str:
    text = str(value)
    return text if len(text) <= _WIDEST else f"{text[: _WIDEST - 1]}…"


def _say_environments(found: "Sequence[Reproduction]") -> None:
    """State once which other versions were used when the steps were archived."""
    changed = {(name, *both): None for one in found for step in one.steps for name, both in step.environment.items()}
    for name, then, now in changed:
        print_result(f"archived with {name} {then}, recomputed with {now}")

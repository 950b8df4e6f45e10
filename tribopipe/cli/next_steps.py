"""What to do next from where somebody stands: said by `tribopipe` alone."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import typer

from tribopipe.cli.options import DEFAULT_ARCHIVE
from tribopipe.cli.output import say, seen
from tribopipe.cli.pages import paragraph
from tribopipe.cli.whereabouts import RUN_TOML, Whereabouts, ids_in, look_around

if TYPE_CHECKING:
    from tribopipe.archive.catalogue.listed import ListedRun

_NAMED = 3
"""As many are named one by one."""
_BEFORE_A_FIT = {"ingested", "cleaned", "corrected", "friction", "wear rate"}
"""How far runs are, as the catalogue calls it, that were not fitted."""


class NextStep(NamedTuple):
    """One thing to do."""

    why: str
    commands: tuple[str, ...]


def say_next_steps() -> None:
    """Say what there is in the current folder, and what to do next with it."""
    found = look_around(Path(), DEFAULT_ARCHIVE)
    say(_standing(found))
    for step in next_steps(found):
        say("")
        paragraph(step.why, "")
        for command in step.commands:
            say(f"    {typer.style(seen(command), bold=True)}")
    say("\n`tribopipe --help` lists all commands, `tribopipe help` the pages of the documentation.")


def next_steps(found: Whereabouts) -> Iterator[NextStep]:
    """Give what to do next, the most urgent first."""
    if not found.runs and not found.archived:
        yield from _beginnings()
        return
    new, amended = _not_as_archived(found)
    counting = [run for run in found.archived if not run.text("mark")]
    yield from _of_folders(new, amended, found)
    yield from _of_archived(counting, found)
    yield from _lacking([run for run in counting if found.folder_of(run) not in amended], found)
    yield from _of_studies(found)
    if found.archived:
        yield NextStep("Look at what is there in the web browser", ("tribopipe browse",))


def _standing(found: Whereabouts) -> str:
    here = [_counted(len(found.runs), "run folder")] if found.runs else []
    if found.archived or found.unreadable:
        here.append(f"{_counted(len(found.archived), 'run')} in {DEFAULT_ARCHIVE}")
    if found.studied:
        here.append(_counted(len(found.studied), "study", "studies"))
    return f"Here: {', '.join(here)}." if here else "No run folders and no archive here."


def _beginnings() -> Iterator[NextStep]:
    yield NextStep("See what tribopipe does, on sample runs", ("tribopipe demo",))
    yield NextStep("Make a run folder of what your tribometer exported", ("tribopipe new EXPORT",))
    yield NextStep("Read how it is done, in ten minutes", ("tribopipe help tutorial",))


def _not_as_archived(found: Whereabouts) -> tuple[list[Path], list[Path]]:
    """Return the run folders that are not in the archive, and those that are with another run.toml."""
    kept, archived = {run.text("run_toml") for run in found.archived}, {run.id for run in found.archived}
    others = [folder for folder, sha256 in found.runs.items() if sha256 not in kept]
    said = ids_in(folder / RUN_TOML for folder in others)
    amended = [folder for folder in others if said.get(folder / RUN_TOML) in archived]
    return [folder for folder in others if folder not in amended], amended


def _of_folders(new: Sequence[Path], amended: Sequence[Path], found: Whereabouts) -> Iterator[NextStep]:
    """Say what to do with run folders that are not in the archive as they are."""
    if new:
        places = _places(new, within=found.runs)
        commands = (f"tribopipe check {places}", f"tribopipe process {places}")
        yield NextStep(f"{_are(new, 'run folder')} not archived yet: look over, then evaluate", commands)
    if amended:
        why = f"{RUN_TOML} of {_counted(len(amended), 'run')} has changed since it was archived: take in what was added"
        yield NextStep(why, (f"tribopipe process {_places(amended, within=amended)} --amend",))


def _of_archived(runs: "Sequence[ListedRun]", found: Whereabouts) -> Iterator[NextStep]:
    """Find runs that were not taken all the way, or to which somebody should look."""
    uncorrected = [run for run in runs if "drift" not in run.texts("steps")]
    unfitted = [run for run in runs if run.text("stage") in _BEFORE_A_FIT]
    if uncorrected:
        yield NextStep(f"{_are(uncorrected, 'run')} not corrected for drift", ("tribopipe correct-drift",))
    if unfitted:
        yield NextStep(f"{_are(unfitted, 'run')} not fitted", ("tribopipe fit",))
    warned = [run for run in runs if run.value("findings")]
    if warned:
        told = f"tribopipe show {warned[0].id}" if len(warned) == 1 else 'tribopipe ls --where "findings>0"'
        yield NextStep(f"The checks warn of {_counted(len(warned), 'run')}: {_named(warned)}", (told,))
    if found.unreadable:
        yield NextStep(f"{_counted(found.unreadable, 'file')} of the archive cannot be read", ("tribopipe verify",))


def _lacking(runs: "Sequence[ListedRun]", found: Whereabouts) -> Iterator[NextStep]:
    """Say which runs with a [contact] have no wear coefficient, and what has to be written to their run.toml first."""
    fitted = [run for run in runs if run.text("tribometer") and run.text("stage") not in _BEFORE_A_FIT]
    runs = [run for run in fitted if run.text("lacks")]
    if not runs:
        return
    first = runs[0]
    folder = found.folder_of(first)
    where = _quoted(Path(first.id) if folder is None else folder)
    why = f"{_are(runs, 'run')} without a wear coefficient ({_named(runs)}), for lack of {first.text('lacks')}"
    yield NextStep(
        f"{why}: write what was measured to {where}/{RUN_TOML}, then", (f"tribopipe process {where} --amend",)
    )


def _of_studies(found: Whereabouts) -> Iterator[NextStep]:
    said = ids_in(found.studies)
    left = [path for path in found.studies if said.get(path) not in found.studied]
    if left and found.archived:
        yield NextStep(f"{_are(left, 'study', 'studies')} not run yet", (f"tribopipe study run {_quoted(left[0])}",))


def _are(things: Sequence[object], one: str, many: str = "") -> str:
    return f"{_counted(len(things), one, many)} {'is' if len(things) == 1 else 'are'}"


def _counted(count: int, one: str, many: str = "") -> str:
    return f"{count} {one if count == 1 else many or f'{one}s'}"


def _named(runs: "Sequence[ListedRun]") -> str:
    more = f" and {len(runs) - _NAMED} more" if len(runs) > _NAMED else ""
    return ", ".join(run.id for run in runs[:_NAMED]) + more


def _places(folders: Sequence[Path], within: "Sequence[Path] | dict[Path, str]") -> str:
    """Name folders for a command line: each where they are few, else the folder that all lie in."""
    if len(folders) <= _NAMED and len(folders) < len(within):
        return " ".join(map(_quoted, folders))
    parents = list(dict.fromkeys(folder.parent for folder in folders))
    return " ".join(map(_quoted, parents if len(folders) > 1 else folders))


def _quoted(path: Path) -> str:
    return f'"{path}"' if " " in str(path) else str(path)

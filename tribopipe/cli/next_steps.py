"""The content of a folder, and what to do next with it: shown by `tribopipe` without a command."""

import os
from collections import Counter, deque
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import typer

from tribopipe.base.errors import counted
from tribopipe.cli.options import DEFAULT_ARCHIVE, RUN_TOML
from tribopipe.cli.output import print_result, seen
from tribopipe.cli.pages import paragraph

if TYPE_CHECKING:
    from tribopipe.archive.catalog.listing import ListedRun


_OF_INSTRUMENTS = {".asc", ".csv", ".dat", ".dwf", ".lvm", ".tdms", ".tsv", ".txt", ".xls", ".xlsx"}
"""Suffixes of exports; their readers identify the content."""
_LEVELS, _MOST_ENTRIES = 2, 20_000
"""Largest depth and number of files examined, so that a home folder does not take long."""


@dataclass
class Whereabouts:
    """Content of a folder."""

    runs: dict[Path, str] = field(default_factory=dict)
    """SHA-256 of the run.toml in each run folder."""
    studies: list[Path] = field(default_factory=list)
    exports: list[Path] = field(default_factory=list)
    """Files outside run folders that are named like exports of instruments."""
    archived: "list[ListedRun]" = field(default_factory=list)
    studied: set[str] = field(default_factory=set)
    """Ids of the studies in the archive."""
    unreadable: dict[str, str] = field(default_factory=dict)
    """Why files in the archive cannot be read, and the remedy, by the ids in their names."""

    def folder_of(self, run: "ListedRun") -> Path | None:
        """Return the folder of an archived run: the one with its run.toml, or with the name of the run."""
        same = (path for path, sha256 in self.runs.items() if sha256 == run.text("run_toml"))
        called = (path for path in self.runs if path.name == run.id)
        return next(same, None) or next(called, None)


def look_around(folder: Path, archive: Path) -> Whereabouts:
    """Examine a folder, and the catalog of its archive if there is one."""
    from tribopipe.base.files import sha256_of

    found = Whereabouts()
    for files in _below(folder, archive):
        manifest = next((path for path in files if path.name == RUN_TOML), None)
        if manifest is not None:
            with suppress(OSError):
                found.runs[manifest.parent] = sha256_of(manifest)
        else:
            found.exports += [path for path in files if path.suffix.lower() in _OF_INSTRUMENTS]
        found.studies += [path for path in files if path.name == "study.toml" or path.name.endswith(".study.toml")]
    if archive.is_dir():
        _look_into(archive, found)
    return found


def _look_into(archive: Path, found: Whereabouts) -> None:
    from tribopipe.archive.file_signature import STUDIES, SUFFIX
    from tribopipe.cli.listing import up_to_date

    catalogue = up_to_date(archive)
    found.archived = catalogue.runs()
    found.unreadable = {Path(name).stem: error for name, error in catalogue.unreadable}
    found.studied = {path.stem for path in (archive / STUDIES).glob(f"*{SUFFIX}")}


def _below(folder: Path, archive: Path) -> Iterator[list[Path]]:
    """Yield the files in a folder and in a few levels below it, except in run folders and hidden folders."""
    left, room = deque([(folder, 0)]), _MOST_ENTRIES
    while left and room > 0:
        here, level = left.popleft()
        files, folders = _in(here)
        room -= len(files) + len(folders)
        yield files
        if level < _LEVELS and not any(path.name == RUN_TOML for path in files):
            left += [(path, level + 1) for path in folders if path != archive]


def _in(folder: Path) -> tuple[list[Path], list[Path]]:
    """Return the visible files and folders in a folder, sorted by name; none if it cannot be read."""
    try:
        with os.scandir(folder) as entries:
            seen = [entry for entry in entries if not entry.name.startswith(".")]
            folders = {entry.path for entry in seen if entry.is_dir(follow_symlinks=False)}
    except OSError:
        return [], []
    paths = sorted(entry.path for entry in seen)
    return [Path(path) for path in paths if path not in folders], [Path(path) for path in paths if path in folders]


def ids_in(documents: Iterable[Path]) -> dict[Path, str]:
    """Return the id of each document; documents that cannot be read are skipped."""
    import tomllib

    from tribopipe.base.files import read_file

    said = {}
    for path in documents:
        with suppress(OSError, ValueError, LookupError):
            said[path] = str(tomllib.loads(read_file(path).decode("utf-8"))["id"])
    return said


_NAMED = 3
"""Largest number of runs that are named."""
_BEFORE_A_FIT = {"ingested", "preprocessed", "corrected", "friction", "wear rate"}
"""Stages in the catalog of runs that have not been fitted."""

_DEPTH = "a depth signal"
_SIGNALS = {_DEPTH, "a friction signal"}
"""Missing signals, which cannot be added in run.toml."""
_END_VALUE = "a post-test measurement of the pin"
_MEASURED = ("end_depth", "wear_rate")
"""Columns of post-test measurements."""


class NextStep(NamedTuple):
    """One suggested step."""

    why: str
    commands: tuple[str, ...]


def say_next_steps() -> None:
    """Report the content of the current folder, and what to do next with it."""
    found = look_around(Path(), DEFAULT_ARCHIVE)
    print_result(_standing(found))
    for step in next_steps(found):
        print_result("")
        paragraph(step.why, "")
        for command in step.commands:
            print_result(f"    {typer.style(seen(command), bold=True)}")
    print_result("\n`tribopipe --help` lists all commands, `tribopipe help` the pages of the documentation.")


def next_steps(found: Whereabouts) -> Iterator[NextStep]:
    """Yield what to do next, the most urgent first."""
    if not found.runs and not found.archived and not found.unreadable:
        yield from _beginnings(found)
        return
    left, counting = list(_left_over(found)), _counting(found)
    yield from left
    yield from _by_sensor_alone(_as_archived(found), found)
    yield from _of_warnings(counting)
    if not left:
        yield from _onwards(counting, found)
    if found.archived:
        yield NextStep("Browse the archive in a web browser", ("tribopipe browse",))


def _left_over(found: Whereabouts) -> Iterator[NextStep]:
    """Find unfinished work."""
    new, amended = _not_as_archived(found)
    yield from _of_unreadable(found)
    yield from _of_folders(new, amended, found)
    yield from _of_archived(_counting(found))
    yield from _lacking(_as_archived(found), found)
    if not new:  # which are processed with the studies beside them
        yield from _of_studies(found)


def _counting(found: Whereabouts) -> "list[ListedRun]":
    return [run for run in found.archived if not run.text("mark")]


def _as_archived(found: Whereabouts) -> "list[ListedRun]":
    """Return the runs that are not marked bad and whose run.toml has not changed since."""
    _, amended = _not_as_archived(found)
    return [run for run in _counting(found) if found.folder_of(run) not in amended]


def _standing(found: Whereabouts) -> str:
    here = [counted(len(found.runs), "run folder")] if found.runs else []
    if found.archived or found.unreadable:
        here.append(f"{counted(len(found.archived), 'run')} in {DEFAULT_ARCHIVE}")
    if found.studied:
        here.append(counted(len(found.studied), "study", "studies"))
    return f"Here: {', '.join(here)}." if here else "No run folders and no archive here."


def _beginnings(found: Whereabouts) -> Iterator[NextStep]:
    yield NextStep("Try tribopipe on sample runs", ("tribopipe demo",))
    export = _quoted(found.exports[0]) if found.exports else "EXPORT"
    yield NextStep("Create a run folder from the export of a test", (f"tribopipe new {export}",))
    if len(found.exports) > 1:
        why = f"Or create a run from each of {len(found.exports)} files, with a template of common settings"
        yield NextStep(why, ("tribopipe help watch",))
    yield NextStep("Read the ten-minute tutorial", ("tribopipe help tutorial",))


def _not_as_archived(found: Whereabouts) -> tuple[list[Path], list[Path]]:
    """Return the run folders that are not in the archive, and those archived with a different run.toml."""
    kept, archived = {run.text("run_toml") for run in found.archived}, {run.id for run in found.archived}
    others = [folder for folder, sha256 in found.runs.items() if sha256 not in kept]
    said = ids_in(folder / RUN_TOML for folder in others)
    amended = [folder for folder in others if said.get(folder / RUN_TOML) in archived]
    taken = archived | found.unreadable.keys()
    return [folder for folder in others if said.get(folder / RUN_TOML) not in taken], amended


def _of_unreadable(found: Whereabouts) -> Iterator[NextStep]:
    """Report what to do about files in the archive that cannot be read."""
    if found.unreadable:
        why = f"{counted(len(found.unreadable), 'file')} in the archive cannot be read: show the reasons"
        yield NextStep(why, ("tribopipe verify",))


def _of_folders(new: Sequence[Path], amended: Sequence[Path], found: Whereabouts) -> Iterator[NextStep]:
    """Report what to do with run folders that are new or have changed since they were archived."""
    if new:
        places = _places(new, within=found.runs)
        commands = (f"tribopipe check {places}", f"tribopipe process {places}")
        yield NextStep(f"{_are(new, 'run folder')} not archived yet: check, then evaluate", commands)
    if amended:
        why = f"{RUN_TOML} of {counted(len(amended), 'run')} has changed since it was archived: archive the changes"
        # With the runs beside it, since predictions and studies of them may stand on it.
        yield NextStep(why, (f"tribopipe process {_all_in(amended)} --amend",))


def _of_archived(runs: "Sequence[ListedRun]") -> Iterator[NextStep]:
    """Find runs whose processing is incomplete."""
    uncorrected = [run for run in runs if "drift_correction" not in run.texts("steps")]
    unfitted = [run for run in runs if run.text("stage") in _BEFORE_A_FIT]
    if uncorrected:
        yield NextStep(f"{_are(uncorrected, 'run')} not corrected for drift", ("tribopipe correct-drift",))
    if unfitted:
        yield NextStep(f"{_are(unfitted, 'run')} not fitted", ("tribopipe fit",))


def _of_warnings(runs: "Sequence[ListedRun]") -> Iterator[NextStep]:
    warned = [run for run in runs if run.value("findings")]
    if warned:
        told = f"tribopipe show {warned[0].id}" if len(warned) == 1 else 'tribopipe ls --where "findings>0"'
        yield NextStep(f"Warnings from the checks on {counted(len(warned), 'run')}: {_named(warned)}", (told,))


def _lacking(runs: "Sequence[ListedRun]", found: Whereabouts) -> Iterator[NextStep]:
    """Report which runs with a [contact] have no wear coefficient, and what to add to their run.toml."""
    runs = [run for run in _fitted(runs) if run.value("k_d") is None and _to_be_added(run)]
    if runs:
        missing = " and ".join(_to_be_added(runs[0]))
        why = f"No wear coefficient for {counted(len(runs), 'run')} ({_named(runs)}); missing: {missing}"
        yield _amending(runs[0], f"{why}: add the measured values to", found)


def _by_sensor_alone(runs: "Sequence[ListedRun]", found: Whereabouts) -> Iterator[NextStep]:
    """Report which wear coefficients are based on the depth sensor alone, and how to add a post-test measurement."""
    runs = [run for run in _fitted(runs) if run.value("k_d") is not None and not _was_measured(run)]
    if runs:
        why = f"k_D of {counted(len(runs), 'run')} ({_named(runs)}) is based on the depth sensor alone"
        yield _amending(runs[0], f"{why}: measure the wear scar and add it to", found)


def _fitted(runs: "Sequence[ListedRun]") -> "list[ListedRun]":
    return [run for run in runs if run.text("tribometer") and run.text("stage") not in _BEFORE_A_FIT]


def _was_measured(run: "ListedRun") -> bool:
    """Return whether wear was measured after a test, which is always true of two discs with a fit."""
    from tribopipe.documents.contact_kinds import contact_named

    contact = contact_named(run.text("tribometer"))
    needed = contact is not None and not contact.sensor_tells
    return needed or any(run.value(name) is not None for name in _MEASURED)


def _to_be_added(run: "ListedRun") -> list[str]:
    """Return the keys of run.toml that would allow a k_D; a scar is sufficient even without a depth signal."""
    missing = [lack for lack in run.texts("missing") if lack not in _SIGNALS]
    return missing or ([_END_VALUE] if _DEPTH in run.texts("missing") and not _was_measured(run) else [])


def _amending(run: "ListedRun", why: str, found: Whereabouts) -> NextStep:
    folder = found.folder_of(run)
    where = _quoted(Path(run.id) if folder is None else folder)
    return NextStep(f"{why} {where}/{RUN_TOML}, then", (f"tribopipe process {where} --amend",))


def _of_studies(found: Whereabouts) -> Iterator[NextStep]:
    said = ids_in(found.studies)
    left = [path for path in found.studies if said.get(path) not in found.studied]
    if left and found.archived:
        yield NextStep(f"{_are(left, 'study', 'studies')} not run yet", (f"tribopipe study run {_quoted(left[0])}",))


def _onwards(runs: "Sequence[ListedRun]", found: Whereabouts) -> Iterator[NextStep]:
    """Report what can be done with wear coefficients and wear rates once all runs are evaluated."""
    known = [run for run in runs if run.value("k_d") is not None]
    rated = [run for run in runs if run.value("k_d") is None and run.value("wear_rate") is not None]
    if known:
        yield from _of_wear_coefficients(known, found)
    if rated:
        count = counted(len(rated), "run")
        why = f"No fitted k_D for {count}: predict from the wear rate, which equals k_D in Archard's law"
        yield NextStep(why, ("tribopipe help scar_only",))
    subject = min(found.studied, default=next((run.id for run in known + rated), None))
    if subject is not None and not Path(f"{subject}.html").exists():
        yield NextStep("Write a report as one HTML file", (f"tribopipe report {subject}",))


def _of_wear_coefficients(known: "Sequence[ListedRun]", found: Whereabouts) -> Iterator[NextStep]:
    alike = Counter(_bodies(run) for run in known if not run.text("studies"))
    if not found.studies and max(alike.values(), default=0) > 1:
        why = "Test the wear law: fit the run at the lightest load and predict the other runs with the same bodies"
        yield NextStep(why, ("tribopipe study new",))
    twice = 2 * (known[0].number("load") or 0)
    load = f"{twice:g} mN" if twice < 1000 else f"{twice / 1000:g} N"
    yield NextStep("Predict wear at another load", (f'tribopipe predict {known[0].id} --load "{load}"',))


def _bodies(run: "ListedRun") -> tuple[str, ...]:
    return tuple(run.text(name) for name in ("tribometer", "material", "medium", "shape", "radius"))


def _are(things: Sequence[object], one: str, many: str = "") -> str:
    return f"{counted(len(things), one, many)} {'is' if len(things) == 1 else 'are'}"


def _named(runs: "Sequence[ListedRun]") -> str:
    more = f" and {len(runs) - _NAMED} more" if len(runs) > _NAMED else ""
    return ", ".join(run.id for run in runs[:_NAMED]) + more


def _places(folders: Sequence[Path], within: Collection[Path]) -> str:
    """Name folders for a command line: each if there are few, else the folder that contains them all."""
    if len(folders) == 1 or (len(folders) <= _NAMED and len(folders) < len(within)):
        return " ".join(map(_quoted, folders))
    return _all_in(folders)


def _all_in(folders: Sequence[Path]) -> str:
    return " ".join(map(_quoted, dict.fromkeys(folder.parent for folder in folders)))


def _quoted(path: Path) -> str:
    return f'"{path}"' if " " in str(path) else str(path)

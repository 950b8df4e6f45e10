"""A run folder from files of an instrument: made next to its place, and given its name once it is whole."""

import re
import secrets
import shutil
import unicodedata
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from tribopipe.base.errors import ManifestError, ReaderError
from tribopipe.base.files import move
from tribopipe.base.process_lifecycle import undone_by
from tribopipe.documents.lab_template import read_template
from tribopipe.documents.manifest import MANIFEST_NAME, MANIFEST_SCHEMA, EndValues, RunManifest, is_described
from tribopipe.documents.record import read_document
from tribopipe.readers.draft.blanks import Ask, Say, ask_for_missing
from tribopipe.readers.draft.known_values import Given, Known
from tribopipe.readers.draft.measurements_table import is_of_tests
from tribopipe.readers.draft.run_files import (
    Group,
    Measured,
    add_profiles,
    grouped,
    profiles_left_open,
    read_profile,
    sheets_of,
    split_steps,
    steps_left_together,
    which_profile,
)
from tribopipe.readers.draft.run_toml import (
    Draft,
    depth_left_open,
    friction_left_open,
    left_in_doubt,
    manifest_text,
    units_contradicted,
)
from tribopipe.readers.draft.value_sources import doubt_names, gather, offer_typical, propose_recorded, take_radius
from tribopipe.readers.export_files import Export, chosen_reader, open_export, read_export
from tribopipe.readers.harmonize import read_run
from tribopipe.readers.reader import Hints
from tribopipe.results.run import SourceFile

_LONGEST_ID = 100
_LETTERS = str.maketrans(
    {"ß": "ss", "æ": "ae", "Æ": "AE", "œ": "oe", "Œ": "OE", "ø": "o", "Ø": "O", "ł": "l", "Ł": "L"}
)
"""Letters without an accent to remove."""
_SUFFIX = re.compile(r"\.[A-Za-z][A-Za-z0-9]{0,9}$")
_DEVICE = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)(\..*)?", re.IGNORECASE)
_NOTHING_MEASURED = (
    "found no post-test measurement; expected at least one, since no signals were recorded; add a scar dimension, "
    "a mass loss or a wear volume under [end_values] in run.toml"
)
_DIALECT = ("encoding", "separator", "decimal")


@dataclass(frozen=True)
class Wanted:
    """Files and options from which a run is made."""

    files: Sequence[Path]
    into: Path = Path()
    """Folder in which the run's folder is made."""
    id: str | None = None
    template: Path | None = None
    reader: str | None = None
    """Name of a reader, or the file that describes one."""
    settings: Sequence[str] = ()
    """Keys of run.toml with their values: "conditions.normal_load=50 N"."""
    profiles: Sequence[str] = ()
    """Bodies with files of profiles measured on them: "disc=track.txt"."""
    sheet: str | None = None
    """Sheet of a workbook."""
    each_sheet: bool = False
    """Whether each sheet of a workbook is a run."""
    each_row: bool = False
    """Whether each row of a table is a run of which nothing was recorded."""
    split: str | None = None
    """Column that numbers the steps of a file, each of which is a run."""
    accept: bool = False
    """Whether values that names of files, recordings and materials offer are accepted."""
    measured: Mapping[str, Given] = field(default_factory=dict)
    """Row of this run in a table of many runs."""


@dataclass(frozen=True)
class NewRun:
    """A run folder that has been made."""

    folder: Path
    groups: tuple[Group, ...]
    missing: tuple[str, ...]
    """Keys without which it cannot be processed."""
    bodies_lack: tuple[str, ...]
    """Keys without which wear cannot be computed."""
    problem: str | None
    """Other problems that prevent processing."""
    notes: tuple[str, ...]
    """Notes to the user about how the files were read."""
    accepted: tuple[str, ...] = ()
    """Suggested values that were accepted, each with its source."""
    suggested: tuple[str, ...] = ()
    """Keys of missing values that run.toml suggests."""


@dataclass(frozen=True)
class _Defaults:
    """How all files are read, by a person's or a template's word."""

    template: dict[str, Any]
    name: str
    reader: str | None
    """Name of the reader in run.toml."""
    description: Path | None
    """The file that describes the reader, where one does."""

    @property
    def signals(self) -> dict[str, Any]:
        """Return the entries of the template about signal files."""
        return dict(self.template.get("signals", {}))

    @property
    def dialect(self) -> dict[str, str]:
        """How text is written."""
        return {name: self.signals[name] for name in _DIALECT if name in self.signals}

    def read(self, path: Path, sheet: str | None = None) -> Export:
        """Read a file of signals, or a sheet of it."""
        hints: Any = self.dialect | ({} if sheet is None else {"sheet": sheet})
        named = self.reader or ("delimited" if "separator" in hints else None)
        if named is None:
            return read_export(path, hints=Hints(**hints))
        reader = chosen_reader(named if self.description is None else str(self.description))
        return read_export(path, reader, Hints(**hints))


@dataclass(frozen=True)
class RunPlan:
    """A run folder to be made."""

    draft: Draft
    exports: Sequence[Export]
    sources: Sequence[SourceFile]
    target: Path


def make_run(wanted: Wanted, ask: Ask | None = None, say: Say = print) -> NewRun:
    """Make the run folder of one test; see ``make_runs``."""
    return make_runs(wanted, ask, say)[0]


def make_runs(wanted: Wanted, ask: Ask | None = None, say: Say = print) -> list[NewRun]:
    """Make a run folder, or one of each sheet or step, asking once for what is missing where there is somebody to ask.

    Raises ``ManifestError`` or ``ReaderError`` where that cannot be done, and then leaves nothing behind.
    """
    plans = [plan for each in _by_sheet(wanted) for plan in planned(each)]
    refuse_places(plans)
    return make_planned(plans, wanted, ask, say)


def make_planned(plans: Sequence[RunPlan], wanted: Wanted, ask: Ask | None, say: Say) -> list[NewRun]:
    """Make the run folders of plans, all or none of them."""
    for plan in plans:
        offer_typical(plan.draft.known)
    accepted = [plan.draft.known.accept() if wanted.accept else [] for plan in plans]
    if ask is not None:
        _ask_once([plan.draft.known for plan in plans], ask, say)
    for plan in plans:
        take_radius(plan.draft.known)
    wanted.into.mkdir(parents=True, exist_ok=True)
    with ExitStack() as stack:
        parts = [stack.enter_context(_building(plan.target)) for plan in plans]
        problems = [_fill(part, plan.draft, plan.sources) for part, plan in zip(parts, plans, strict=True)]
        for part, plan in zip(parts, plans, strict=True):
            _take_place(part, plan.target)
            stack.enter_context(undone_by(partial(shutil.rmtree, plan.target, ignore_errors=True)))
    return [_new_run(*one) for one in zip(plans, problems, accepted, strict=True)]


def _by_sheet(wanted: Wanted) -> list[Wanted]:
    """Return what is wanted of each sheet, where each is a run."""
    if not wanted.each_sheet:
        return [wanted]
    names = sheets_of(wanted.files, wanted.reader)
    base = fit_for_id(wanted.files[0].name) if wanted.id is None else wanted.id
    return [replace(wanted, sheet=name, each_sheet=False, id=_id_of_sheet(base, name)) for name in names]


def _id_of_sheet(base: str, sheet: str) -> str:
    """Make the id of a sheet; its name has no suffix, as that of a file has."""
    return fit_for_id(f"{base}-{sheet}".replace(").", "-").replace("(", "-"))


def planned(wanted: Wanted) -> list[RunPlan]:
    """Return the run folder that is wanted, or one for each step.

    Raises ``ManifestError`` or ``ReaderError`` where it cannot be made.
    """
    defaults = _defaults(wanted)
    wanted = replace(wanted, sheet=wanted.sheet or defaults.signals.get("sheet"))
    exports = [defaults.read(path, wanted.sheet) for path in wanted.files]
    for export in exports:
        _refuse_tests(export)
    measured = [read_profile(written) for written in wanted.profiles]
    if wanted.split is None:
        return [_plan(wanted, defaults, exports, measured)]
    plans = []
    for step in split_steps(exports, wanted.split):
        plan = _plan(wanted, defaults, step.exports, measured, (step.column, step.number))
        draft = replace(plan.draft, id=f"{plan.draft.id}-step-{step.number}", step=step)
        plans.append(replace(plan, draft=draft, target=wanted.into / draft.id))
    return plans


def _refuse_tests(export: Export) -> None:
    if is_of_tests([column.name for column in export.table.columns]):
        raise ReaderError(
            f"{export.name}: found a table of finished tests, one per row; expected the recording of one test; "
            "add --each-row to create one run folder per row, or specify the table with --ends and the recordings "
            "as files"
        )


def _plan(
    wanted: Wanted,
    defaults: _Defaults,
    exports: Sequence[Export],
    measured: list[Measured],
    step: tuple[str, int] | None = None,
) -> RunPlan:
    draft = replace(_drafted(wanted, defaults, exports, measured), sheet=wanted.sheet, is_recorded=not wanted.each_row)
    propose_recorded(draft.known, exports, step)
    described = [open_export(defaults.description)] if defaults.description else []
    sources = [export.source for export in [*exports, *(one.export for one in measured)]] + described
    return RunPlan(draft, exports, sources, wanted.into / draft.id)


def refuse_places(plans: Sequence[RunPlan]) -> None:
    """Refuse names that run.toml cannot hold, and places that are taken or wanted twice."""
    taken: set[Path] = set()
    for plan in plans:
        _refuse_names(plan.draft.id, plan.sources)
        _refuse_taken(plan.target)
        if plan.target in taken:
            raise ManifestError(
                f"{plan.target}: found two runs with that ID; expected a unique ID for each run; rename the "
                "sheets or rows, or create each run separately with --sheet and --id"
            )
        taken.add(plan.target)


def _ask_once(known: Sequence[Known], ask: Ask, say: Say) -> None:
    """Ask for what is missing in the first of several runs, and take the answers for all of them."""
    first, *others = known
    before = dict(first.given)
    ask_for_missing(first, ask, say)
    for other in others:
        for key in first.given.keys() - before.keys():
            other.take(key, first.given[key].value)


def _new_run(plan: RunPlan, problem: str | None, accepted: Sequence[str]) -> NewRun:
    draft = plan.draft
    notes = dict.fromkeys(f"{export.name}: {note}" for export in plan.exports for note in export.notes)
    notes |= dict.fromkeys([*draft.known.dissent, *draft.known.in_dispute(), *profiles_left_open(draft.known)])
    notes |= dict.fromkeys(note for group in draft.groups if (note := _one_test(group)))
    notes |= dict.fromkeys(note for export in plan.exports if (note := friction_left_open(export, draft.columns)))
    notes |= dict.fromkeys(note for group in draft.groups for note in left_in_doubt(group.first, draft))
    notes |= dict.fromkeys(note for export in plan.exports if (note := depth_left_open(export, draft.columns)))
    for export in plan.exports:
        notes |= dict.fromkeys(units_contradicted(export, draft.columns, draft.template))
    if draft.step is None:
        notes |= dict.fromkeys(note for export in plan.exports if (note := steps_left_together(export)))
    missing, bodies_lack = draft.known.missing, draft.known.bodies_lack
    if not draft.is_recorded:  # there is no friction to be evaluated without the bodies
        missing, bodies_lack = [*missing, *bodies_lack], []
    return NewRun(
        plan.target,
        tuple(draft.groups),
        tuple(missing),
        tuple(bodies_lack),
        problem,
        tuple(notes),
        tuple(accepted),
        tuple(key for key in (*missing, *bodies_lack) if draft.known.offered(key)),
    )


def _one_test(group: Group) -> str | None:
    """Report that files are taken as one test where their times contradict their order."""
    count = len(group.exports)
    if group.order_of_times:
        return (
            f"{count} files are treated as one test in the order of their names, although their recorded times give "
            f"the order {', '.join(group.order_of_times)}; if the times are correct, correct the order of files in "
            "run.toml"
        )
    if group.clocks_begin_anew:
        return (
            f"{count} files are treated as one test, in sequence, although the clock restarts in each; "
            "for separate tests, create one run per file, or use `tribopipe watch FOLDER`"
        )
    return None


def _defaults(wanted: Wanted) -> _Defaults:
    template = read_template(wanted.template) if wanted.template else {}
    if wanted.each_row:
        template.pop("signals", None)  # it is about recordings
    name = wanted.template.name if wanted.template else ""
    told = template.get("signals", {}).get("reader")
    reader = wanted.reader or told
    if reader is None or not is_described(reader):
        return _Defaults(template, name, reader, None)
    beside = wanted.template.parent if wanted.template and not wanted.reader else Path()
    return _Defaults(template, name, Path(reader).name, beside / reader)


def _drafted(wanted: Wanted, defaults: _Defaults, exports: Sequence[Export], measured: list[Measured]) -> Draft:
    groups = grouped([export for export in exports if export.reader.holds == "signals"])
    if not groups:
        raise ReaderError(
            f"{exports[0].name}: found a profile ({exports[0].reader.title}); expected at least one signal file "
            "as well, since a run is the recording of a test; specify the signal file too"
        )
    in_order = [export for group in groups for export in group.exports]
    known = gather(defaults.template, defaults.name, wanted.settings, in_order, wanted.measured)
    add_profiles(known, measured)
    which_profile(known, [export for export in exports if export.reader.holds == "profile"])
    doubt_names(known, [export.name for export in in_order])
    run_id = fit_for_id(in_order[0].name) if wanted.id is None else wanted.id
    columns = defaults.signals.get("columns", {})
    return Draft(run_id, groups, known, defaults.reader, defaults.name, defaults.dialect, columns)


def fit_for_id(file: str) -> str:
    """Make an id of a file's name, which the archive file can be named after too."""
    latin = unicodedata.normalize("NFKD", _SUFFIX.sub("", file).translate(_LETTERS)).encode("ascii", "ignore").decode()
    name = re.sub(r"[^A-Za-z0-9._+-]+", "-", latin).lstrip("._+-")[:_LONGEST_ID].rstrip("._+-")
    return f"run-{name}"[:_LONGEST_ID] if not name or _DEVICE.fullmatch(name) else name


def _refuse_names(run_id: str, sources: Sequence[SourceFile]) -> None:
    """Refuse an id or names of files that run.toml cannot hold."""
    names = [source.name for source in sources]
    frame = {"schema": MANIFEST_SCHEMA, "id": run_id, "conditions": {"normal_load": "1 N"}}
    read_document(frame | {"signals": [{"files": list(dict.fromkeys(names))}]}, RunManifest, where=f"run {run_id}")
    taken = {MANIFEST_NAME: "the manifest of the run"}
    for name in names:
        if name.lower() in taken:
            raise ReaderError(
                f"{name}: found the same name for {taken[name.lower()]}; expected files with "
                "different names, since they are stored in one folder; rename one of them"
            )
        taken[name.lower()] = "another file"


def _refuse_taken(target: Path) -> None:
    if target.exists() or target.is_symlink():
        raise ManifestError(
            f"{target}: found an existing folder; expected no folder of this name, since runs are never "
            "overwritten; choose another ID with --id, or another folder with --into"
        )


@contextmanager
def _building(target: Path) -> Iterator[Path]:
    """Give a temporary folder next to ``target`` that vanishes on failure."""
    part = target.with_name(f".{target.name}.{secrets.token_hex(4)}.part")
    with undone_by(partial(shutil.rmtree, part, ignore_errors=True)):
        try:
            part.mkdir()
        except PermissionError as error:
            raise _not_created(target, error) from error
        yield part


def _take_place(part: Path, target: Path) -> None:
    """Give a temporary folder its name; on Windows once no other program, such as a virus scanner, reads in it."""
    _refuse_taken(target)
    try:
        move(part, target)
    except PermissionError as error:
        raise _not_created(target, error) from error


def _not_created(target: Path, error: OSError) -> ManifestError:
    return ManifestError(
        f"{target}: cannot be created ({error.strerror}); expected a folder with write permission; "
        "specify another folder with --into"
    )


def _fill(part: Path, draft: Draft, sources: Sequence[SourceFile]) -> str | None:
    """Write files and run.toml; state what is in the way of reading the run, once what is missing is filled in."""
    for source in sources:
        with (part / source.name).open("wb") as file:
            file.writelines(source.pieces())
    manifest = part / MANIFEST_NAME
    manifest.write_bytes(manifest_text(replace(draft, known=draft.known.completed())).encode())
    problem = _problem(part, is_recorded=draft.is_recorded)
    manifest.write_bytes(manifest_text(draft).encode())
    return problem


def _problem(folder: Path, *, is_recorded: bool) -> str | None:
    """Report what is in the way of processing a run."""
    try:
        run = read_run(folder)
    except ReaderError as error:
        return str(error).removeprefix(f"{folder}: ")
    if "friction_coefficient" in run.columns or "depth" in run.columns:
        return None
    if not is_recorded:
        return None if run.manifest.end_values != EndValues() else _NOTHING_MEASURED
    measured = [signal for signal, origin in run.origins.items() if origin == "measured"]
    return (
        f"found {', '.join(measured)} among the signals, but neither friction nor depth; expected at least one of "
        "them; map friction_force, friction_coefficient or depth under [signals.columns] in run.toml"
    )

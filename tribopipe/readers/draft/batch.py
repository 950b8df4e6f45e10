"""Run folders of many tests: one of each export in a folder, or one of each row of a table.

Of a folder, duplicates, aborted tests and what is no export are named. A table is of finished tests of which nothing
was recorded:

    run;normal load [N];sliding speed [m/s];sliding distance [m];ball diameter [mm];pin_scar_diameter [um];lab book
    A1;5;0.1;500;6;412;page 12

run.toml is filled from the row. The file of signals holds the start and the end of the test, by its distance and
speed; nothing else is put in the place of a recording. Columns that are no key of run.toml are kept in its comment.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from tribopipe.base.errors import ManifestError, ReaderError
from tribopipe.base.files import file_order
from tribopipe.base.units import is_unit_of, to_si
from tribopipe.documents.contact import Progress
from tribopipe.documents.contact_kinds import ASSUMED, contact_named
from tribopipe.documents.lab_template import read_template
from tribopipe.documents.manifest import Conditions
from tribopipe.documents.quantity import read_quantity
from tribopipe.readers.draft.blanks import Ask, Say
from tribopipe.readers.draft.folder import NewRun, RunPlan, Wanted, fit_for_id, make_planned, planned, refuse_places
from tribopipe.readers.draft.known_values import Given, Known, speed_key_of, value_of
from tribopipe.readers.draft.measurements_table import EndsRow, EndsTable, read_ends
from tribopipe.readers.draft.value_sources import gather
from tribopipe.readers.export_files import Export, open_export
from tribopipe.readers.reader import candidates, is_sure

_NO_EXPORTS = (".toml", ".ini", ".db", ".md", ".pdf", ".png", ".jpg", ".jpeg", ".docx", ".h5")
_FEWEST = 3
"""Tests from which on one is compared with the others."""
_ABORTED = 0.5
"""Share of the usual duration below which a test may have been aborted."""


class LeftOut(NamedTuple):
    """A file of which no run was made."""

    file: str
    why: str
    is_broken: bool = False
    """Whether it is an export that could not be read."""


def are_many(paths: Sequence[Path]) -> bool:
    """Return whether a folder is among the paths, of whose files each is a run."""
    return any(path.is_dir() for path in paths)


def make_each(
    wanted: Wanted, ends: Path | None = None, ask: Ask | None = None, say: Say = print
) -> tuple[list[NewRun], list[LeftOut]]:
    """Make a run folder of each file, or of each in a folder, and return what was left out.

    A table ``ends`` shows loads, scars and volumes of the runs. Raises ``ManifestError`` or ``ReaderError`` where that
    table cannot be taken, or a run cannot be made, and then leaves nothing behind.
    """
    if wanted.id is not None:
        raise ManifestError(
            f"--id {wanted.id}: found one ID for several runs; expected no ID, since each run is named after its file; "
            "remove --id"
        )
    measured = None if ends is None else read_ends(ends)
    files = [path for path in _files(wanted.files) if ends is None or path.resolve() != ends.resolve()]
    if measured is not None:
        measured.refuse_unknown([name for path in files for name in _names(path)])
    plans, left_out = _plans_of_files(files, wanted, measured)
    if not plans:
        why = f" ({left_out[0].file}: {left_out[0].why})" if left_out else ""
        raise ReaderError(
            f"{wanted.files[0]}: found no file from which a run can be created{why}; expected at least one recording "
            "of a test; specify its files by name"
        )
    _name_aborted(plans)
    if measured is not None:
        for name in measured.unused:
            say(f"{measured.name}: column {name!r} is not a key of run.toml and is not used")
    made = make_planned(plans, wanted, ask, say)
    return [_with_notes(run, measured) for run in made], left_out


def _files(paths: Sequence[Path]) -> Iterator[Path]:
    for path in paths:
        if path.is_dir():
            inside = (one for one in path.iterdir() if one.is_file() and not one.name.startswith((".", "~")))
            yield from sorted(inside, key=lambda one: file_order(one.name))
        else:
            yield path


def _names(path: Path) -> tuple[str, str, str]:
    """Return the names by which a table may call the run of a file."""
    return path.name, path.stem, fit_for_id(path.name)


def _plans_of_files(
    files: Sequence[Path], wanted: Wanted, measured: EndsTable | None
) -> tuple[list[RunPlan], list[LeftOut]]:
    plans: list[RunPlan] = []
    left_out: list[LeftOut] = []
    taken: dict[str, str] = {}
    for path in files:
        row = None if measured is None else measured.row_of(*_names(path))
        try:
            why = _no_export(path, taken)
            found = [] if why else planned(replace(wanted, files=[path], measured={} if row is None else row.values))
        except ReaderError as error:
            left_out.append(LeftOut(path.name, str(error).removeprefix(path.name).lstrip(":, "), is_broken=True))
            continue
        for plan in found:
            if plan.target.exists():
                why = f"{plan.target} already exists"
            elif any(plan.target == other.target for other in plans):
                why = f"another file is already used for the run {plan.draft.id}; specify a different ID with --id"
            else:
                plans.append(plan)
        if why:
            left_out.append(LeftOut(path.name, why))
    return plans, left_out


def _no_export(path: Path, taken: dict[str, str]) -> str:
    """Report why no run is made of a file: nothing reads it, or another one has the same bytes."""
    if path.suffix.lower() in _NO_EXPORTS:
        return "not an instrument export"
    source = open_export(path)
    before = taken.setdefault(source.sha256, path.name)
    if before != path.name:
        return f"an exact duplicate of {before}"
    found = [one for one in candidates(source) if is_sure(one.match)]
    if not found:
        return "no reader recognizes its format"
    return (
        "" if found[0].reader.holds == "signals" else f"a profile ({found[0].reader.title}); specify it with --profile"
    )


def _name_aborted(plans: Sequence[RunPlan]) -> None:
    """Note in their drafts which tests are much shorter than the others."""
    lengths = [_length(plan.exports) for plan in plans]
    usual = float(np.median(lengths)) if len(lengths) >= _FEWEST else 0.0
    for plan, length in zip(plans, lengths, strict=True):
        if length < _ABORTED * usual:
            share = f"{100 * length / usual:.0f} %"
            plan.draft.known.doubt("comment", "aborted", f"this test is {share} as long as the others in the folder")
            plan.draft.known.dissent.append(
                f"this test is {share} as long as the others in the folder: was it stopped early?"
            )


def _length(exports: Sequence[Export]) -> float:
    """Return the duration of a test, s, or how many rows it has."""
    for export in exports:
        for column in export.table.columns:
            meaning = export.meanings.get(column.name)
            if meaning is not None and meaning.signal == "time" and column.values.dtype.kind == "f":
                known = column.values[np.isfinite(column.values)]
                unit = column.unit if is_unit_of(column.unit or "", "time") else "s"
                return float(to_si(np.ptp(known), unit or "s", "time")) if len(known) else 0.0
    return float(sum(export.rows for export in exports))


def _with_notes(run: NewRun, measured: EndsTable | None) -> NewRun:
    names = [name for group in run.groups for file in group.names for name in _names(Path(file))]
    if measured is None or measured.row_of(*names) is not None:
        return run
    return replace(run, notes=(*run.notes, f"{measured.name} has no row for this run"))


_SIGNALS_FILE = "signals.csv"
_SHAPE = "contact.pin.shape"
_DISTANCE, _ROTATIONS = "conditions.sliding_distance", "conditions.rotations"
_TURNING_RADIUS = "contact.curved_disc.rolling_radius"
"""Radius of the disc whose rotations are counted."""
_ALIKE = 0.02
"""How far two values of one quantity in a row may be apart, relative to one of them."""


def make_of_rows(wanted: Wanted, ask: Ask | None = None, say: Say = print) -> list[NewRun]:
    """Make a run folder of each row of a table.

    Raises ``ManifestError`` with file and line where a row is incomplete or contradicts itself, and then leaves nothing
    behind.
    """
    if len(wanted.files) != 1:
        raise ReaderError(
            f"--each-row: found {len(wanted.files)} files; expected one table, .csv or .xlsx; specify one table "
            "at a time"
        )
    table = read_ends(wanted.files[0])
    for name in table.unused:
        say(f"{table.name}: column {name!r} is not a key of run.toml and is kept in the comment of each run")
    with TemporaryDirectory() as folder:
        plans = [
            plan
            for row in table.rows
            for plan in _plans_of_row(wanted, row, f"{table.name}, line {row.line}", Path(folder))
        ]
    refuse_places(plans)
    return make_planned(plans, wanted, ask, say)


def _plans_of_row(wanted: Wanted, row: EndsRow, where: str, folder: Path) -> list[RunPlan]:
    measured = {**row.values, **_row_comment(row, where)}
    template = read_template(wanted.template) if wanted.template else {}
    counted = measured.pop(_ROTATIONS, None)
    known = gather(template, "", wanted.settings, [], measured)
    if counted is not None:
        measured |= _length_of(counted, known, where)
        known = gather(template, "", wanted.settings, [], measured)
    _refuse_two_sizes(row, where)
    if row.is_ball and _SHAPE not in known.given:
        measured[_SHAPE] = Given("spherical", f"from {where}, a ball")
    signals = folder / _SIGNALS_FILE
    signals.write_text(_start_and_end(known, where), encoding="utf-8")
    return planned(replace(wanted, files=[signals], id=fit_for_id(f"{row.run}.csv"), measured=measured))


def _length_of(counted: Given, known: Known, where: str) -> dict[str, Given]:
    """Return the length of a test with so many rotations: of a pin the sliding distance, by the track or the stroke.

    Raises ``ManifestError`` where the distance per rotation is unknown, or the row states another distance.
    """
    if _progress(known).kind == "count":
        return {_ROTATIONS: counted}
    try:
        number = read_quantity(value_of(str(counted.value)), "count").value
    except ValueError as error:
        raise ManifestError(f"{where}: {_ROTATIONS}: {error}") from None
    cycle, stated = known.conditions.cycle, known.conditions.sliding_distance
    if cycle is None:
        raise ManifestError(
            f"{where}: found rotations without a track radius; expected both, since the distance per rotation is 2πR; "
            "add a column track_radius, or track_radius to the template"
        )
    if stated is not None and abs(stated.value - number * cycle) > _ALIKE * stated.value:
        raise ManifestError(
            f"{where}: found a sliding_distance of {stated.shown('m')}, but {number * cycle:.6g} m from rotations; "
            "expected the two distances to agree; correct one of them"
        )
    if stated is not None:
        return {}
    return {_DISTANCE: Given(f"{number * cycle:.6g} m", f"{counted.origin}, {number:g} rotations")}


def _progress(known: Known) -> Progress:
    """Return what wear increases with on a type of tribometer."""
    return (contact_named(known.kind) or ASSUMED).progress


def _row_comment(row: EndsRow, where: str) -> dict[str, Given]:
    """Return the comment of a run, with the fields that have no key of their own."""
    given = row.values.get("comment")
    parts = [*([str(given.value)] if given else []), *(f"{name}: {field}" for name, field in row.other.items())]
    return {"comment": Given("; ".join(parts), f"from {where}")} if parts else {}


def _start_and_end(known: Known, where: str) -> str:
    """Write start and end of a test, by its distance and speed; no more is known of its course."""
    if _progress(known).kind == "count":
        return _turned(known, where)
    conditions = known.conditions
    distance, speed = conditions.sliding_distance, conditions.nominal_speed
    if distance is None or speed is None:
        missing = "sliding_distance" if distance is None else "sliding_speed (or rotational_speed and track_radius)"
        raise ManifestError(
            f"{where}: found no {missing}; expected the distance and the speed of each test; add a column, fill "
            "in the field, or, if the value is the same for all tests, enter it in the template"
        )
    _refuse_two_speeds(conditions, where)
    return f"time [s],sliding distance [m]\n0,0\n{distance.value / speed.value:.12g},{distance.value:.12g}\n"


def _turned(known: Known, where: str) -> str:
    """Write start and end of a test by its rotations and the speed of the disc that turns so often."""
    rotations, speed = known.conditions.rotations, known.conditions.curved_disc_speed
    radius = known.values.get(_TURNING_RADIUS)
    missing = [
        key
        for key, value in ((_ROTATIONS, rotations), (speed_key_of(known.kind), speed), (_TURNING_RADIUS, radius))
        if value is None
    ]
    if rotations is None or speed is None or radius is None:
        raise ManifestError(
            f"{where}: found no {missing[0]}; expected the rotations, the speed and the radius of the disc of each "
            "test; add a column, fill in the field, or, if the value is the same for all tests, enter it in the "
            "template"
        )
    duration = rotations * 2 * math.pi * read_quantity(radius, "length").value / speed.value
    return f"time [s],rotations [1]\n0,0\n{duration:.12g},{rotations:.12g}\n"


def _refuse_two_speeds(conditions: Conditions, where: str) -> None:
    stated, other = conditions.sliding_speed, conditions.model_copy(update={"sliding_speed": None}).nominal_speed
    if stated is not None and other is not None and abs(stated.value - other.value) > _ALIKE * stated.value:
        motion = "rotational_speed and track_radius" if conditions.track_radius else "stroke and frequency"
        raise ManifestError(
            f"{where}: found a sliding_speed of {stated.shown('mm/s')}, but {other.shown('mm/s')} from {motion}; "
            "expected the two speeds to agree; correct one of them"
        )


def _refuse_two_sizes(row: EndsRow, where: str) -> None:
    sizes = [
        row.values[f"contact.pin.{name}"] for name in ("diameter", "radius") if f"contact.pin.{name}" in row.values
    ]
    if len(sizes) == 2:
        diameter, radius = (read_quantity(size.value, "length") for size in sizes)
        if abs(diameter.value / 2 - radius.value) > _ALIKE * radius.value:
            raise ManifestError(
                f"{where}: found a ball {diameter.shown('mm')} in diameter with a radius of {radius.shown('mm')}; "
                "expected a radius of half the diameter; correct one of them, or delete one column"
            )

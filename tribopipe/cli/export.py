"""Commands that write files for other programs: export umeshmotion, export csv, export runs, export dataset."""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from tribopipe.base.errors import counted
from tribopipe.cli.datasets import ExportGroup, export_dataset
from tribopipe.cli.listing import Columns, Sort, Where, tell_unreadable, up_to_date
from tribopipe.cli.options import (
    DEFAULT_ARCHIVE,
    ArchivedIds,
    AsJson,
    Friction,
    Law,
    ReadableArchive,
    Replace,
    Speed,
    archived_ids,
    load_archive,
    quantity,
)
from tribopipe.cli.output import attempt_each, exit_with, print_file, print_json, print_result, record_json, say
from tribopipe.cli.subject import Given, Subject, archived_subject, folder_subject, is_folder, no_coefficient

if TYPE_CHECKING:
    from tribopipe.archive.store import Archive
    from tribopipe.base.errors import TribopipeError
    from tribopipe.documents.manifest import RunManifest
    from tribopipe.extras.abaqus.case import WearCase
    from tribopipe.physics.friction_path import ExponentialFriction


_Job = tuple[str, str, Path]
"""Id, kind of table, and output file."""


def export_csv(
    ids: ArchivedIds,
    what: Annotated[
        str | None,
        typer.Option(
            help="Tables, separated by commas: raw, cleaned, other-columns, corrected, friction, wear, fit, "
            "prediction, local-wear; default: all tables of the run."
        ),
    ] = None,
    output: Annotated[Path, typer.Option("--output", "-o", help="Output folder.")] = Path("csv"),
    archive: ReadableArchive = DEFAULT_ARCHIVE,
    force: Replace = False,
    as_json: AsJson = False,
) -> None:
    """Write columns of runs as CSV.

    The files are called <id>-<what>.csv. Numbers have full precision and the units of the archive.

    A run folder with the raw columns and the run.toml of the run yields the same run.
    """
    from tribopipe.pipeline.output_paths import require_free

    store, wanted = load_archive(archive), None if what is None else _chosen(what)
    jobs: list[_Job] = []
    errors: list[TribopipeError] = []
    for run_id in dict.fromkeys(ids):
        found, lacking = _jobs(store, run_id, wanted, output)
        jobs += found
        errors += lacking
    require_free((path for _, _, path in jobs), force=force)
    written = _written(store, jobs, output, errors)
    if as_json:
        print_json({"files": [{"id": run_id, "what": kind, "file": str(path)} for run_id, kind, path in written]})
    exit_with(errors, some_done=bool(written))


def _written(store: "Archive", jobs: Sequence[_Job], folder: Path, errors: "list[TribopipeError]") -> list[_Job]:
    """Write files, and return those that were written; the reason for each failure is added to the errors."""
    folder.mkdir(parents=True, exist_ok=True)
    of_path = {path: (run_id, kind) for run_id, kind, path in jobs}
    done, failed = attempt_each(of_path, lambda path: _write(store, *of_path[path], path), "csv")
    errors += failed.values()
    for path in done:
        print_result(str(path))
    return [(*of_path[path], path) for path in done]


def _chosen(text: str) -> list[tuple[str, ...]]:
    """Return the kinds that each word selects: "fit" for the fits of all laws."""
    from tribopipe.base.errors import did_you_mean
    from tribopipe.views.csv_files import CSV_KINDS

    chosen = []
    for word in (part.strip() for part in text.split(",")):
        kinds = tuple(kind for kind in CSV_KINDS if kind == word or kind.startswith(f"{word}-"))
        if not kinds:
            raise typer.BadParameter(f"--what: found {word!r}; expected a table; {did_you_mean(word, CSV_KINDS)}")
        chosen.append(kinds)
    return chosen


def _jobs(
    store: "Archive", run_id: str, wanted: "Sequence[tuple[str, ...]] | None", folder: Path
) -> "tuple[list[_Job], list[TribopipeError]]":
    """Return the tables of a run to write, and an error for each requested kind that is missing."""
    from tribopipe.base.errors import TribopipeError
    from tribopipe.views.csv_files import csv_kinds, lacking

    try:
        there = csv_kinds(store, run_id)
    except TribopipeError as error:
        return [], [error]
    asked = [(kind,) for kind in there] if wanted is None else wanted
    found = dict.fromkeys(kind for kinds in asked for kind in kinds if kind in there)
    missing: list[TribopipeError] = [lacking(run_id, kinds[0], there) for kinds in asked if not set(kinds) & set(there)]
    return [(run_id, kind, folder / f"{run_id}-{kind}.csv") for kind in found], missing


def _write(store: "Archive", run_id: str, kind: str, path: Path) -> None:
    from tribopipe.base.files import replacing
    from tribopipe.views.csv_files import csv_parts

    parts: Iterator[bytes] = csv_parts(store, run_id, kind)
    with replacing(path) as part, part.open("wb") as file:
        file.writelines(parts)


def export_runs(
    where: Where = "",
    sort: Sort = "id",
    columns: Columns = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            help="File to write: .csv, .xlsx (Excel, Origin), .tex (LaTeX with booktabs and siunitx), .md (Markdown) "
            "or .parquet (pandas, Polars, DuckDB, R; SI units); default: CSV on stdout.",
        ),
    ] = None,
    decimal_comma: Annotated[
        bool,
        typer.Option(
            "--decimal-comma",
            help="Use a decimal comma (0,5 instead of 0.5) in LaTeX and CSV files; CSV columns are then separated by "
            "semicolons, as Excel expects in most European locales.",
        ),
    ] = False,
    archive: ReadableArchive = DEFAULT_ARCHIVE,
    force: Replace = False,
) -> None:
    """Write the list of runs for spreadsheets, scripts and papers.

    Numbers are in the unit given in the heading, with their standard uncertainties u. CSV files, workbooks and Parquet
    files contain all columns, with u in separate columns; LaTeX and Markdown files contain the columns that ls shows.
    """
    from tribopipe.archive.catalog.listing import columns_named
    from tribopipe.base.files import write_file
    from tribopipe.pipeline.output_paths import require_free
    from tribopipe.views.run_tables import FORMS, WITH_COMMAS

    suffix = ".csv" if output is None else output.suffix.lower() or ".csv"
    if suffix not in FORMS:
        raise typer.BadParameter(f"--output: found the suffix {suffix}; expected one of {', '.join(FORMS)}")
    if decimal_comma and suffix not in WITH_COMMAS:
        raise typer.BadParameter(
            f"--decimal-comma: found a {suffix} file; expected {' or '.join(WITH_COMMAS)}; omit this option for "
            "other files; the decimal separator of a workbook depends on the program that opens it"
        )
    require_free([] if output is None else [output], force=force)
    chosen = None if columns is None else columns_named(columns)
    catalogue = up_to_date(archive)
    runs = catalogue.runs(where, sort)
    written = FORMS[suffix](runs, chosen, **({"decimal_comma": True} if decimal_comma else {}))
    if output is None:
        print_file(written)
    else:
        write_file(output, written)
        say(f"{counted(len(runs), 'run')} written to {output}")
    tell_unreadable(catalogue, some_done=bool(runs))


export_app = typer.Typer(cls=ExportGroup, help="Export data for other programs.", no_args_is_help=True)
export_app.command("csv")(export_csv)
export_app.command("runs")(export_runs)
export_app.command("dataset")(export_dataset)


@export_app.command("umeshmotion")
def umeshmotion(
    run: Annotated[
        str,
        typer.Argument(
            help="ID of an archived run, or a run folder.", metavar="ID|RUN_FOLDER", autocompletion=archived_ids
        ),
    ],
    law: Law = "archard",
    wear_coefficient: Annotated[
        str | None,
        typer.Option(
            help='k_D of the pin or the crowned disc, for example "13.5e-9 mm^3/(N*mm)"; default: value from '
            "the archived fit."
        ),
    ] = None,
    friction: Friction = None,
    speed: Speed = None,
    until: Annotated[
        str | None,
        typer.Option(
            help='Sliding distance to simulate, for example "500 m", or number of rotations of the crowned disc, for '
            'example "1e6".'
        ),
    ] = None,
    element_size: Annotated[
        str | None,
        typer.Option(
            help='Mesh size in the contact, for example "1 um"; default: a tenth of the radius of the unworn contact.'
        ),
    ] = None,
    jtyp: Annotated[
        Literal["0", "1", "none"],
        typer.Option(
            help=(
                "Argument JTYP of GETVRMAVGATNODE: 0 for extrapolation to the node, 1 for a volume-weighted average, "
                "none to omit the argument, as documented for ABAQUS 6.5 and 6.6."
            ),
        ),
    ] = "0",
    output: Annotated[Path | None, typer.Option("--output", help="Output folder; default: umeshmotion-ID.")] = None,
    archive: ReadableArchive = DEFAULT_ARCHIVE,
    force: Replace = False,
    as_json: AsJson = False,
) -> None:
    """Write a user subroutine for ABAQUS with an identified wear law.

    It also writes the step for an input file, a harness that calls the subroutine without ABAQUS, and notes. The
    subroutine has been compiled and run with the harness, but not in ABAQUS.
    """
    from tribopipe.documents.recipe import Recipe
    from tribopipe.extras.abaqus.texts import texts

    subject = _subject(run, archive, Given(law, Recipe(), wear_coefficient is not None, friction, eq_7=True))
    case, run_id = _case(subject, law, wear_coefficient, speed, until, element_size), subject.manifest.id
    files = _write_texts(texts(case, jtyp), output or Path(f"umeshmotion-{run_id}"), force=force)
    print_result(str(case))
    for note in case.known.notes:
        say(f"{run_id}: note: {note}")
    say(f"{run_id}: written to {files[0].parent}; not tested in ABAQUS; see README.txt in this folder")
    if as_json:
        print_json(_document(case, files))


def _subject(run: str, archive: Path, given: Given) -> Subject:
    """Return the run to export. Raises ``FitError`` for a law for which no subroutine can be written."""
    from tribopipe.base.errors import FitError

    if given.law not in ("archard", "sarkar"):
        raise FitError(
            f"{run}: found the wear law {given.law}; expected archard or sarkar, for which a subroutine can be "
            "written; fit one of these laws"
        )
    if is_folder(run, archive):
        if not given.has_coefficient:
            raise typer.BadParameter(no_coefficient(Path(run)))
        return folder_subject(Path(run), given)
    return archived_subject(load_archive(archive), run, given)


def _friction(subject: Subject, law: Law) -> "ExponentialFriction | None":
    """Return μ(s) from Eq. 7 if the law needs it. Raises ``FitError`` if there is none."""
    from tribopipe.base.errors import FitError
    from tribopipe.documents.manifest import StatedFriction
    from tribopipe.evaluation.load_and_friction import stated_path
    from tribopipe.physics.friction_path import ExponentialFriction

    if law == "archard":
        return None
    friction = subject.friction
    if isinstance(friction, StatedFriction):
        return stated_path(friction)
    if isinstance(friction, ExponentialFriction):
        return friction
    raise FitError(
        f"{subject.manifest.id}: found no fit of μ(s) (Eq. 7), which Sarkar's law requires; expected its parameters; "
        'specify --friction "A=0.226 b=0.496 c=32.877 m", or run `tribopipe fit` if friction was recorded'
    )


def _case(
    subject: Subject, law: Law, coefficient: str | None, speed: str | None, until: str | None, element_size: str | None
) -> "WearCase":
    from tribopipe.extras.abaqus.case import WearCase, fitted_wear, given_wear

    manifest = subject.manifest
    if subject.fit is not None:
        known = fitted_wear(manifest.id, subject.fit)
    else:
        known = given_wear(manifest.id, quantity("--wear-coefficient", coefficient or "", "wear coefficient"))
    contact, nominal = manifest.described, _speed(manifest, speed)
    end = _end(manifest, until, subject.end)
    return WearCase(
        contact=contact,
        normal_load=manifest.described.pressed_by(manifest.conditions.normal_load).value,
        known=known,
        speed=nominal if manifest.slip is None else nominal * abs(manifest.slip.value),
        duration=end * contact.travel / nominal,
        friction=_friction(subject, law),
        element_size=None if element_size is None else quantity("--element-size", element_size, "length").value,
    )


def _speed(manifest: "RunManifest", given: str | None) -> float:
    """Return the sliding speed, or the speed of the crowned disc, m/s. Raises ``ContactError`` if it is unknown."""
    from tribopipe.base.errors import ContactError

    if given is not None:
        return float(quantity("--speed", given, "speed").value)
    stated = manifest.nominal_speed
    if stated is None:
        raise ContactError(
            f"{manifest.id}: found no conditions.{manifest.progress.speed}; expected the speed, from which the "
            "wear rate of the nodes is calculated; add it to run.toml and ingest the run again, or specify "
            '--speed "400 mm/s"'
        )
    return stated.value


def _end(manifest: "RunManifest", given: str | None, own: float | None) -> float:
    """Return the sliding distance to simulate, m, or the rotations of the crowned disc."""
    if given is not None:
        return float(quantity("--until", given, manifest.progress.kind).value)
    if own is None:
        raise typer.BadParameter(f'specify the end of the simulation: --until "{manifest.progress.example}"')
    return own


def _write_texts(texts: dict[str, str], folder: Path, *, force: bool) -> list[Path]:
    """Write all files. Raises ``OutputError``, and writes none, if one of them must not be written."""
    from tribopipe.base.files import write_file
    from tribopipe.pipeline.output_paths import require_free

    paths = {folder / name: text for name, text in texts.items()}
    require_free(paths, force=force)
    for path, text in paths.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        write_file(path, text.encode("ascii"))
    return list(paths)


def _document(case: "WearCase", files: list[Path]) -> dict[str, object]:
    from tribopipe.documents.quantity import Quantity

    return {
        "id": case.known.run_id,
        "law": case.law,
        "wear_coefficient": record_json(case.known.coefficient),
        "step_limit": record_json(Quantity(value=case.step_limit, unit="s")),
        "element_size": record_json(Quantity(value=case.element, unit="m")),
        "increments": math.ceil(case.increments),
        "notes": list(case.known.notes),
        "files": [str(path) for path in files],
    }

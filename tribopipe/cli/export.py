"""Commands that write what other programs take: export umeshmotion, export csv, export runs, export dataset."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from tribopipe.cli.datasets import ExportGroup, export_dataset
from tribopipe.cli.export_tables import export_csv, export_runs
from tribopipe.cli.options import (
    DEFAULT_ARCHIVE,
    ArchiveFolder,
    AsJson,
    Law,
    archived_ids,
    friction_path,
    load_archive,
    quantity,
)
from tribopipe.cli.output import print_json, print_result, record_json, say

if TYPE_CHECKING:
    from tribopipe.archive.store import Archive
    from tribopipe.documents.manifest import RunManifest
    from tribopipe.extras.abaqus.case import KnownWear, WearCase
    from tribopipe.physics.friction_path import ExponentialFriction, FrictionPath

export_app = typer.Typer(cls=ExportGroup, help="Export data for other programs.", no_args_is_help=True)
export_app.command("csv")(export_csv)
export_app.command("runs")(export_runs)
export_app.command("dataset")(export_dataset)


@dataclass(frozen=True)
class _Subject:
    """Wear as known from a run and from the command line."""

    manifest: "RunManifest"
    known: "KnownWear"
    friction: "ExponentialFriction | None"
    end: float | None
    """m or rotations."""


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
            help='k_D of the pin or the crowned disc, such as "13.5e-9 mm^3/(N*mm)"; default: from the archived fit.'
        ),
    ] = None,
    friction: Annotated[
        str | None, typer.Option(help='μ(s) for Sarkar\'s law, such as "A=0.226 b=0.496 c=32.877 m".')
    ] = None,
    speed: Annotated[str | None, typer.Option(help="Different sliding speed, or speed of the crowned disc.")] = None,
    until: Annotated[
        str | None, typer.Option(help='Sliding distance to simulate, "500 m", or rotations of the crowned disc, "1e6".')
    ] = None,
    element_size: Annotated[
        str | None,
        typer.Option(help='Mesh size in the contact, "1 um"; default: a tenth of the radius of the unworn contact.'),
    ] = None,
    jtyp: Annotated[
        Literal["0", "1", "none"],
        typer.Option(
            help=(
                "JTYP of GETVRMAVGATNODE: 0 extrapolates to the node, 1 weights by volume; none omits the "
                "argument, as documented for ABAQUS 6.5 and 6.6."
            ),
        ),
    ] = "0",
    output: Annotated[Path | None, typer.Option("--output", help="Output folder; default: umeshmotion-ID.")] = None,
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    force: Annotated[bool, typer.Option("--force", help="Replace existing files.")] = False,
    as_json: AsJson = False,
) -> None:
    """Write a user subroutine of an identified wear law for ABAQUS.

    It also writes the step for an input file, a harness that calls the subroutine without ABAQUS, and notes. The
    subroutine has been compiled and run with the harness, but not in ABAQUS.
    """
    from tribopipe.extras.abaqus.texts import texts

    if Path(run).exists() and not (archive / f"{run}.h5").is_file():
        subject = _of_folder(Path(run), law, wear_coefficient, friction)
    else:
        subject = _of_archive(load_archive(archive), run, law, wear_coefficient, friction)
    case, run_id = _case(subject, speed, until, element_size), subject.manifest.id
    files = _write(texts(case, jtyp), output or Path(f"umeshmotion-{run_id}"), force=force)
    print_result(str(case))
    for note in case.known.notes:
        say(f"{run_id}: note: {note}")
    say(f"{run_id}: written to {files[0].parent}; not run in ABAQUS, see README.txt there")
    if as_json:
        print_json(_document(case, files))


def _of_folder(folder: Path, law: Law, coefficient: str | None, friction: str | None) -> _Subject:
    """Return the conditions of run.toml with k_D from the command line."""
    from tribopipe.documents.manifest import manifest_path, read_manifest
    from tribopipe.evaluation.load_and_friction import stated_path

    if coefficient is None:
        raise typer.BadParameter('a run folder has no k_D: give one, --wear-coefficient "13.5e-9 mm^3/(N*mm)"')
    manifest, _ = read_manifest(manifest_path(folder))
    conditions = manifest.conditions
    stated = None if conditions.friction is None else stated_path(conditions.friction)
    known = _given(manifest.id, coefficient)
    return _Subject(manifest, known, _friction(manifest.id, law, friction, stated), manifest.planned)


def _of_archive(store: "Archive", run_id: str, law: Law, coefficient: str | None, friction: str | None) -> _Subject:
    """Return the subject for an archived run, with its own fit unless a k_D is given."""
    from tribopipe.evaluation.load_and_friction import fitted_path
    from tribopipe.pipeline.archived_results import archived_friction

    run = store.cleaned(run_id)
    path = _friction(run_id, law, friction, fitted_path(archived_friction(store, run_id)))
    known = _fitted(store, run_id, law) if coefficient is None else _given(run_id, coefficient)
    return _Subject(run.manifest, known, path, float(run.progress[-1]))


def _given(run_id: str, text: str) -> "KnownWear":
    from tribopipe.extras.abaqus.case import given_wear

    return given_wear(run_id, quantity("--wear-coefficient", text, "wear coefficient"))


def _friction(run_id: str, law: Law, given: str | None, known: "FrictionPath | None") -> "ExponentialFriction | None":
    """Return μ(s) by Eq. 7 where the law needs it. Raises ``FitError`` where there is none."""
    from tribopipe.base.errors import FitError
    from tribopipe.physics.friction_path import ExponentialFriction

    if law not in ("archard", "sarkar"):
        raise FitError(
            f"{run_id}: found the wear law {law}; expected archard or sarkar, for which a subroutine can be written; "
            "fit one of these laws"
        )
    if law == "archard":
        return None
    path = known if given is None else friction_path(given)
    if not isinstance(path, ExponentialFriction):
        raise FitError(
            f"{run_id}: found no fit of μ(s) (Eq. 7), which Sarkar's law requires; expected its parameters; specify "
            "--friction "
            '"A=0.226 b=0.496 c=32.877 m", or run `tribopipe fit` where friction was recorded'
        )
    return path


def _fitted(store: "Archive", run_id: str, law: Law) -> "KnownWear":
    """Return the k_D of an archived fit. Raises ``FitError`` where there is none."""
    from tribopipe.archive.steps import WEAR_FITS
    from tribopipe.base.errors import FitError
    from tribopipe.extras.abaqus.case import fitted_wear
    from tribopipe.physics.laws import law_title
    from tribopipe.results.wear_fit import WearFit

    fit = store.result(run_id, WEAR_FITS[law], WearFit)
    if fit is not None:
        return fitted_wear(run_id, fit)
    raise FitError(
        f"{run_id}: found no k_D of {law_title(law)}; expected a fitted k_D; run `tribopipe fit {run_id} --law {law}`, "
        "or specify k_D with --wear-coefficient"
    )


def _case(subject: _Subject, speed: str | None, until: str | None, element_size: str | None) -> "WearCase":
    from tribopipe.extras.abaqus.case import WearCase

    manifest = subject.manifest
    contact, nominal = manifest.described, _speed(manifest, speed)
    end = _end(manifest, until, subject.end)
    return WearCase(
        contact=contact,
        normal_load=manifest.described.pressed_by(manifest.conditions.normal_load).value,
        known=subject.known,
        speed=nominal * _slip(manifest),
        duration=end * contact.travel / nominal,
        friction=subject.friction,
        element_size=None if element_size is None else quantity("--element-size", element_size, "length").value,
    )


def _slip(manifest: "RunManifest") -> float:
    """Return |V₁ − V₂| over the crowned disc's speed; 1 for a pin."""
    from tribopipe.documents.slip import stated_slip

    slip = stated_slip(manifest)
    return 1.0 if slip is None else abs(slip.value)


def _speed(manifest: "RunManifest", given: str | None) -> float:
    """Return the speed of sliding, or of the crowned disc, m/s. Raises ``ContactError`` where it is not known."""
    from tribopipe.base.errors import ContactError

    if given is not None:
        return float(quantity("--speed", given, "speed").value)
    stated = manifest.nominal_speed
    if stated is None:
        raise ContactError(
            f"{manifest.id}: found no conditions.{manifest.progress.speed}; expected the speed, from which the wear "
            'rate of the mesh is calculated; add it to run.toml and ingest the run again, or specify --speed "400 mm/s"'
        )
    return stated.value


def _end(manifest: "RunManifest", given: str | None, own: float | None) -> float:
    """Return how far to wear: m, or rotations of the crowned disc."""
    if given is not None:
        return float(quantity("--until", given, manifest.progress.kind).value)
    if own is None:
        raise typer.BadParameter(f'specify the end of the simulation: --until "{manifest.progress.example}"')
    return own


def _write(texts: dict[str, str], folder: Path, *, force: bool) -> list[Path]:
    """Write every file. Raises ``OutputError``, and writes none, where one must not be written."""
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

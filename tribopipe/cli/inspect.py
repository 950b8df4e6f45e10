"""Commands that look: ls, show, schema."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from tribopipe.cli.options import DEFAULT_ARCHIVE, ArchiveFolder, AsJson, archived_ids, load_archive
from tribopipe.cli.output import exit_with, print_json, record_json, say, table
from tribopipe.cli.profiles import (
    HeightUnit,
    Plot,
    PositionUnit,
    ProfileOptions,
    Radius,
    show_profile_file,
    show_run_profiles,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tribopipe.archive.steps import Step, StepName
    from tribopipe.archive.store import Archive
    from tribopipe.errors import ArchiveError
    from tribopipe.records.disc_results import TwinDiscFit
    from tribopipe.records.manifest import RunManifest
    from tribopipe.records.mark import Mark
    from tribopipe.records.results import Contribution

schema_app = typer.Typer(help="JSON Schemas of the documents people write.", no_args_is_help=True)


class _Listed(NamedTuple):
    """What is said of a run in a list."""

    manifest: "RunManifest"
    steps: "list[StepName]"
    bad: "Mark | None"


def ls(archive: ArchiveFolder = DEFAULT_ARCHIVE, as_json: AsJson = False) -> None:
    """List the runs of an archive."""
    from tribopipe.errors import ArchiveError

    store, held, unreadable = load_archive(archive), [], []
    for run_id in store.ids():
        try:
            held.append(_Listed(store.manifest(run_id), store.step_names(run_id), store.bad(run_id)))
        except ArchiveError as error:
            unreadable.append(error)
    if as_json:
        print_json({"runs": [_line(run) for run in held]})
    elif held or not unreadable:
        marked = any(run.bad for run in held)
        table(
            f"{len(held)} runs in {archive}",
            ["run", *(["mark"] if marked else []), "tribometer", "materials", "medium", "load", "started", "steps"],
            [_row(run, marked=marked) for run in held],
        )
    exit_with(unreadable, some_done=bool(held))


def _line(run: _Listed) -> dict[str, Any]:
    manifest, conditions, contact = run.manifest, run.manifest.conditions, run.manifest.contact
    return {
        "id": manifest.id,
        "tribometer": None if contact is None else contact.kind,
        **{f"{name}_material": body.material for name, body in manifest.bodies.items()},
        "medium": conditions.medium,
        "normal_load": record_json(conditions.normal_load),
        "started": None if manifest.started is None else manifest.started.isoformat(),
        "steps": run.steps,
        "marked_bad": run.bad.reason if run.bad else None,
    }


_SHORT: "dict[StepName, str]" = {
    "clean_up": "clean-up",
    "drift_correction": "drift",
    "friction_fit": "friction",
    "specific_wear": "specific wear",
    "wear_fit_archard": "Archard",
    "wear_fit_sarkar": "Sarkar",
    "prediction_archard": "predicted by Archard",
    "prediction_sarkar": "predicted by Sarkar",
    "local_wear_archard": "local wear by Archard",
    "local_wear_sarkar": "local wear by Sarkar",
}


def _row(run: _Listed, *, marked: bool) -> list[str]:
    """Return the cells of a run, that of its mark only in a list where a run is marked."""
    from tribopipe.units import show_force

    manifest, conditions, contact = run.manifest, run.manifest.conditions, run.manifest.contact
    return [
        manifest.id,
        *(["bad" if run.bad else "–"] if marked else []),
        "–" if contact is None else contact.kind,
        " / ".join(dict.fromkeys(body.material for body in manifest.bodies.values())) or "–",
        conditions.medium or "–",
        show_force(conditions.normal_load.value, conditions.normal_load.standard_uncertainty),
        "–" if manifest.started is None else f"{manifest.started:%Y-%m-%d %H:%M}",
        ", ".join(_SHORT[name] for name in run.steps) or "ingested",
    ]


def show(
    run_id: Annotated[
        str,
        typer.Argument(
            help="Id of an archived run, or a file with a profile.", metavar="ID|FILE", autocompletion=archived_ids
        ),
    ],
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    plot: Plot = False,
    radius: Radius = None,
    position_unit: PositionUnit = None,
    height_unit: HeightUnit = None,
    as_json: AsJson = False,
) -> None:
    """Show what the archive holds of one run, or the wear track in a profile."""
    archived = (archive / f"{run_id}.h5").exists()
    if Path(run_id).is_file() and not archived:
        asked = ProfileOptions(plot, radius, position_unit, height_unit)
        show_profile_file(Path(run_id), asked, as_json=as_json)
        return
    if not archived and Path(run_id).suffix:
        raise _neither_file_nor_run(run_id, archive)
    _show_run(load_archive(archive), run_id, plot=plot, as_json=as_json)


def _neither_file_nor_run(name: str, archive: Path) -> "ArchiveError":
    """Refuse what may have been meant as a file as well as a run."""
    from tribopipe.errors import ArchiveError, did_you_mean

    there, folder = load_archive(archive, must_exist=False).ids() if archive.is_dir() else [], Path(name).parent
    beside = [str(path) for path in folder.iterdir() if path.is_file()] if folder.is_dir() else []
    return ArchiveError(
        f"{name}: found no such file, and no such run in {archive}; expected a file with a profile, or the id of an "
        f"archived run; {did_you_mean(name, [*there, *beside])}"
    )


def _show_run(store: "Archive", run_id: str, *, plot: bool, as_json: bool) -> None:
    from tribopipe.cli.summary import run_summary

    if as_json:
        findings = [record_json(finding) for finding in store.findings(run_id)]
        manifest, steps = record_json(store.manifest(run_id)), store.step_names(run_id)
        marks = [record_json(mark) for mark in store.marks(run_id)]
        told = {"manifest": manifest, "findings": findings, "steps": steps, "marks": marks}
        if plot:
            told["profiles"] = show_run_profiles(store, run_id)
        print_json(run_summary(store, run_id) | told)
        return
    _show_page(store, run_id)
    if plot:
        show_run_profiles(store, run_id)


def _show_page(store: "Archive", run_id: str) -> None:
    raw = store.raw(run_id)
    say(str(raw))
    for name, origin in raw.origins.items():
        say(f"  {name}: {origin}")
    for finding in store.findings(run_id):
        say(f"  {finding.severity}: {finding}")
    for mark in store.marks(run_id):
        say(f"  {mark}")
    for step in store.steps(run_id).values():
        say(f"\n{step.name} (tribopipe {step.program_version}, {step.date})")
        say(f"  {step.result}")
        _show_fit(step)
        _show_wear(step)
    say(f"\n{store.path(run_id)}")


def _show_fit(step: "Step") -> None:
    """Show what stands behind a wear fit: its notes and its budget."""
    from tribopipe.records.disc_results import TwinDiscFit
    from tribopipe.records.results import WearFit

    fit = step.result
    if not isinstance(fit, WearFit | TwinDiscFit):
        return
    for note in fit.notes:
        say(f"  note: {note}")
    if isinstance(fit, TwinDiscFit):
        _show_disc_fit(fit)
        return
    if fit.joint is not None:
        say(f"  drift and wear in one fit: {fit.joint}")
    _show_budget("k_D", fit.budget)


def _show_wear(step: "Step") -> None:
    """Show what each end value says of the wear of its body."""
    from tribopipe.records.specific_wear import SpecificWear

    if not isinstance(step.result, SpecificWear):
        return
    measured = [(name, one) for name, body in step.result.bodies.items() for one in body.measured]
    if measured:
        table(
            "  wear by each end value",
            ["body", "by", "depth", "volume"],
            [
                [
                    name.replace("_", " "),
                    one.by,
                    "–" if one.depth is None else one.depth.shown("um"),
                    "–" if one.volume is None else one.volume.shown("mm^3"),
                ]
                for name, one in measured
            ],
        )


def _show_budget(what: str, budget: "Sequence[Contribution]") -> None:
    if not budget:
        return
    table(
        f"  budget of {what}",
        ["input", "value", "stated by", "share of k_D"],
        [
            [line.name, line.value.shown(line.shown_in) if line.value else "–", line.source, f"{line.relative:+.2%}"]
            for line in budget
        ],
    )


def _show_disc_fit(fit: "TwinDiscFit") -> None:
    """Show what was fitted, both budgets, and k_D under the other ways of counting the distance slid."""
    from tribopipe.records.disc_results import spoken

    if not fit.coefficients:
        return
    table(
        "  what was measured, and what the law makes of it",
        ["measured", "rotations", "value", "by the law"],
        [
            [
                spoken(one.name),
                f"{one.rotations:,.0f}",
                *(value.shown("mm^3" if value.unit == "m^3" else "um") for value in (one.measured, one.fitted)),
            ]
            for one in fit.measurements
        ],
    )
    for one in fit.coefficients:
        _show_budget(f"k_D of the {spoken(one.disc)}", one.budget)
    table(
        "  k_D that would wear as much, were distance counted otherwise",
        ["distance per rotation", "curved disc", "flat disc"],
        [
            [one.distance_per_rotation, one.curved_disc.shown("mm^3/(N*mm)"), one.flat_disc.shown("mm^3/(N*mm)")]
            for one in fit.equivalents
        ],
    )


@schema_app.command("export")
def export_schemas(
    folder: Annotated[Path, typer.Argument(help="Folder to write *.schema.json into.")] = Path("schemas"),
) -> None:
    """Write the JSON Schemas, by which editors complete and check run.toml, recipes and plans."""
    from tribopipe.records.export import write_schemas

    for path in write_schemas(folder):
        say(str(path))


COMMANDS = {"ls": ls, "show": show}

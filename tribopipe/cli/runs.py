"""Commands that take or make run folders: check, ingest, simulate."""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tribopipe.cli.batch_options import Jobs, Part, Scheduler, Shard, crew, seen_by
from tribopipe.cli.options import DEFAULT_ARCHIVE, Amend, ArchiveFolder, AsJson, Force, load_archive
from tribopipe.cli.output import (
    FAILED,
    finish,
    in_order,
    print_json,
    print_result,
    progress,
    record_json,
    say,
    say_where_to_read,
    table,
)

if TYPE_CHECKING:
    from tribopipe.base.executor import Crew
    from tribopipe.documents.plan import TwinDiscTruth
    from tribopipe.pipeline.stages import Outcome

_UNCOMPARED = {"radius_can_be_compared"}
"""Notes on inputs of which nothing else in a run shows that they are wrong, though the wear coefficient would be."""
RunPaths = Annotated[list[Path], typer.Argument(help="Run folders, or folders of run folders.", metavar="RUN")]


def run_folders(
    paths: list[Path], shard: Part | None = None, who: "Crew | None" = None
) -> "tuple[list[Path], list[Outcome]]":
    """Return the run folders at or below the paths, or those of a shard, as a crew finds them.

    With them, a failure for each path that has none.
    """
    from tribopipe.base.errors import ManifestError
    from tribopipe.pipeline.stages import Outcome, find_runs

    folders: list[Path] = []
    failures: list[Outcome] = []
    for path in paths:
        try:
            folders += find_runs(path if who is None else seen_by(who, path))
        except ManifestError as error:
            failures.append(Outcome.failed(str(path), "ingest", error))
    return (folders if shard is None else shard.chosen(folders)), failures


def check(paths: RunPaths, as_json: AsJson = False) -> None:
    """Check run folders before they are archived.

    Schema, units, order of time, gaps, signs and magnitudes are checked. Exit code 1 on errors and warnings.
    """
    from tribopipe.pipeline.stages import attempted

    folders, failures = run_folders(paths)
    documents, sound, codes = [], True, []
    for path in folders:
        looked = attempted(str(path), "ingest", partial(_looked_over, path))
        if looked.error is not None:
            failures.append(looked)
            continue
        findings = looked.findings
        sound = sound and all(finding.severity == "note" for finding in findings)
        codes += [finding.code for finding in findings if finding.severity != "note"]
        told = [record_json(finding) for finding in findings]
        documents.append({"path": str(path), "id": looked.run_id, "findings": told})
        for finding in findings:
            print_result(f"{looked.run_id}: {finding.severity}: {finding}")
        if not findings:
            print_result(f"{looked.run_id}: nothing to complain about")
    for failure in failures:
        say(f"error: {failure.error}")
    say_where_to_read([*(failure.error.code for failure in failures if failure.error is not None), *codes])
    if as_json:
        unread = [{"path": failure.run_id, "error": str(failure.error), "findings": []} for failure in failures]
        print_json({"runs": documents + unread})
    if failures or not sound:
        raise typer.Exit(FAILED)


def _looked_over(path: Path) -> "Outcome":
    from tribopipe.evaluation.checks.registry import check_run
    from tribopipe.pipeline.stages import Outcome
    from tribopipe.readers.harmonize import read_run

    run = read_run(path)
    return Outcome(run.id, "ingest", "unchanged", findings=tuple(check_run(run)))


def ingest(
    paths: RunPaths,
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    force: Force = False,
    amend: Amend = False,
    as_json: AsJson = False,
    jobs: Jobs = None,
    scheduler: Scheduler = None,
    shard: Shard = None,
) -> None:
    """Read, check and archive run folders."""
    from tribopipe.pipeline import stages

    who = crew(jobs, scheduler)
    store = load_archive(seen_by(who, archive), must_exist=False)
    folders, outcomes = run_folders(paths, shard, who)
    with progress("ingest", len(folders)) as advance:
        for outcome in stages.ingest_each(folders, store, force=force, amend=amend, crew=who):
            if outcome.error is None:
                print_result(
                    f"{outcome.run_id}: {'archived' if outcome.status == 'done' else 'unchanged, nothing to do'}"
                )
            say_amended(outcome)
            say_warnings(outcome)
            outcomes.append(outcome)
            advance(outcome.run_id)
    outcomes = in_order(outcomes)
    if as_json:
        print_json({"runs": [outcome.as_json() for outcome in outcomes]})
    finish(outcomes)


def say_amended(outcome: "Outcome") -> None:
    """Say which steps stood on the run.toml before it was amended."""
    if outcome.dropped is None:
        return
    names = ", ".join(name.replace("_", " ") for name in outcome.dropped)
    dropped = f"; steps that stood on it are dropped: {names}" if names else ""
    say(f"{outcome.run_id}: run.toml amended, the earlier one is kept{dropped}")


def say_warnings(outcome: "Outcome") -> None:
    """Say what the checks warn of, and which inputs nothing in the run can be compared with."""
    for finding in outcome.findings:
        if finding.severity == "warning" or finding.code in _UNCOMPARED:
            say(f"{outcome.run_id}: {finding.severity}: {finding}")


def simulate(
    folder: Annotated[Path, typer.Argument(help="Folder to write run folders into.")],
    plan: Annotated[Path, typer.Option("--plan", help="TOML file that says what to simulate.")],
    as_json: AsJson = False,
) -> None:
    """Record runs with known wear on a virtual tribometer."""
    from tribopipe.base.units import WEAR_COEFFICIENT
    from tribopipe.documents.plan import Plan, Truth, TwinDiscTruth
    from tribopipe.documents.record import load_toml
    from tribopipe.extras.simulate import simulate_plan
    from tribopipe.pipeline.output_paths import require_outside

    require_outside(folder / "run")
    truths = simulate_plan(load_toml(plan, Plan), folder)
    if as_json:
        print_json({"runs": [record_json(truth) for truth in truths]})
    title = f"Simulated into {folder}"
    pins = [truth for truth in truths if isinstance(truth, Truth)]
    if pins:
        table(
            title,
            ["run", "law", "true k_D", "true pin wear at the end"],
            [
                [
                    truth.id,
                    truth.law,
                    truth.wear_coefficient.shown(WEAR_COEFFICIENT),
                    truth.end_pin_wear_depth.shown("um"),
                ]
                for truth in pins
            ],
        )
    discs = [truth for truth in truths if isinstance(truth, TwinDiscTruth)]
    if discs:
        table(
            title if not pins else "",
            ["run", "law", "disc", "true k_D", "true wear at the end", "true volume at the end"],
            [row for truth in discs for row in _disc_rows(truth)],
        )


def _disc_rows(truth: "TwinDiscTruth") -> list[list[str]]:
    from tribopipe.base.units import WEAR_COEFFICIENT

    ends = (
        ("curved", truth.curved_wear_coefficient, truth.end_curved_wear_depth, truth.end_curved_wear_volume),
        ("flat", truth.flat_wear_coefficient, truth.end_flat_wear_depth, truth.end_flat_wear_volume),
    )
    law = truth.law if truth.fatigue is None else f"{truth.law}, fatigue"
    return [
        [truth.id, law, disc, k.shown(WEAR_COEFFICIENT), depth.shown("um"), volume.shown("mm^3")]
        for disc, k, depth, volume in ends
    ]


COMMANDS = {"check": check, "ingest": ingest, "simulate": simulate}

"""Commands that read or create run folders: check, ingest, simulate."""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tribopipe.base.column_formatting import number_column
from tribopipe.cli.listing import Cells
from tribopipe.cli.options import (
    DEFAULT_ARCHIVE,
    RUN_TOML,
    Amend,
    ArchiveFolder,
    AsJson,
    Force,
    Jobs,
    Part,
    Scheduler,
    Shard,
    crew,
    load_archive,
    seen_by,
)
from tribopipe.cli.output import (
    FAILED,
    finish,
    followed,
    in_order,
    line_width,
    print_json,
    print_result,
    record_json,
    say,
    say_where_to_read,
    table,
)

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from tribopipe.base.executor import Crew
    from tribopipe.documents.plan import TwinDiscTruth
    from tribopipe.documents.quantity import Quantity
    from tribopipe.pipeline.stages import Outcome
    from tribopipe.results.finding import Finding

RunPaths = Annotated[list[Path], typer.Argument(help="Run folders, or folders that contain them.", metavar="RUN")]


def run_folders(
    paths: list[Path], shard: Part | None = None, who: "Crew | None" = None
) -> "tuple[list[Path], list[Outcome]]":
    """Return the run folders at or below the paths, or those of a shard, with paths valid for the workers.

    Also return a failure for each path without any.
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

    Schema, units, time order, gaps, signs and magnitudes are checked. Exit code 1 on errors and warnings.
    """
    folders, failures = run_folders(paths)
    documents, sound, codes = [], True, []
    first: dict[tuple[str, str], str] = {}
    for path, looked in _checked(folders):
        if looked.error is not None:
            failures.append(looked)
            continue
        findings = looked.findings
        sound = sound and all(finding.severity == "note" for finding in findings)
        codes += [finding.code for finding in findings if finding.severity != "note"]
        told = [record_json(finding) for finding in findings]
        documents.append({"path": str(path), "id": looked.run_id, "findings": told})
        for finding in findings:
            print_result(f"{looked.run_id}: {finding.severity}: {_once(finding, looked.run_id, first)}")
        if not findings:
            print_result(f"{looked.run_id}: no problems found")
    for failure in failures:
        say(f"error: {failure.error}")
    say_where_to_read([*(failure.error.code for failure in failures if failure.error is not None), *codes])
    if as_json:
        unread = [{"path": failure.run_id, "error": str(failure.error), "findings": []} for failure in failures]
        print_json({"runs": documents + unread})
    if failures or not sound:
        raise typer.Exit(FAILED)


def _once(finding: "Finding", run_id: str, first: dict[tuple[str, str], str]) -> str:
    """Return a finding; on a terminal, refer to the first run that has the same. ``first`` has the run of each."""
    other = first.setdefault((finding.severity, str(finding)), run_id)
    if other == run_id or line_width() is None:
        return str(finding)
    return f"{finding.where}: same as {other}"


def _checked(folders: list[Path]) -> "Iterator[tuple[Path, Outcome]]":
    """Check each run; one whose ID an earlier one has is a failure."""
    from tribopipe.base.errors import ManifestError
    from tribopipe.pipeline.stages import Outcome, attempted

    first: dict[str, Path] = {}
    for path in folders:
        looked = attempted(str(path), "ingest", partial(_looked_over, path))
        other = path if looked.error else first.setdefault(looked.run_id, path)
        if other != path:
            error = ManifestError(
                f"{path / RUN_TOML}: found the ID {looked.run_id!r}, which {other / RUN_TOML} has as well; expected a "
                "different ID for each run; change id in one of them"
            )
            looked = Outcome.failed(str(path), "ingest", error)
        yield path, looked


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
    ingested = stages.ingest_each(folders, store, force=force, amend=amend, crew=who)
    outcomes += followed(ingested, "ingest", len(folders), _say_ingested)
    outcomes = in_order(outcomes)
    if as_json:
        print_json({"runs": [outcome.as_json() for outcome in outcomes]})
    finish(outcomes)


def _say_ingested(outcome: "Outcome") -> None:
    if outcome.error is None:
        print_result(f"{outcome.run_id}: {'archived' if outcome.status == 'done' else 'unchanged, nothing to do'}")
    say_amended(outcome)
    say_warnings(outcome)


def say_amended(outcome: "Outcome") -> None:
    """Report the steps that were removed because they depend on the earlier run.toml."""
    if outcome.dropped is None:
        return
    from tribopipe.archive.step_names import step_in_words

    names = ", ".join(map(step_in_words, outcome.dropped))
    dropped = f"; steps that depend on it are removed: {names}" if names else ""
    say(f"{outcome.run_id}: run.toml amended, the earlier version is kept{dropped}")


def say_warnings(outcome: "Outcome") -> None:
    """Report the warnings of the checks, and the inputs that cannot be checked against other data of the run."""
    from tribopipe.cli.process_table import UNCOMPARED

    for finding in outcome.findings:
        if finding.severity == "warning" or finding.code in UNCOMPARED:
            say(f"{outcome.run_id}: {finding.severity}: {finding}")


def simulate(
    folder: Annotated[Path, typer.Argument(help="Output folder for run folders.")],
    plan: Annotated[Path, typer.Option("--plan", help="TOML file with the simulation plan.")],
    as_json: AsJson = False,
) -> None:
    """Simulate runs with known wear."""
    from tribopipe.base.units import WEAR_COEFFICIENT
    from tribopipe.documents.plan import Plan, Truth, TwinDiscTruth
    from tribopipe.documents.record import load_toml
    from tribopipe.extras.simulate import simulate_plan
    from tribopipe.pipeline.output_paths import require_folder

    require_folder(folder)
    truths = simulate_plan(load_toml(plan, Plan), folder)
    if as_json:
        print_json({"runs": [record_json(truth) for truth in truths]})
    title = f"Simulated runs in {folder}"
    pins = [truth for truth in truths if isinstance(truth, Truth)]
    if pins:
        k_d = _column("true k_D", [truth.wear_coefficient for truth in pins], WEAR_COEFFICIENT)
        worn = _column("true pin wear at the end", [truth.end_pin_wear_depth for truth in pins], "um")
        rows = zip([truth.id for truth in pins], [truth.law for truth in pins], k_d.cells, worn.cells, strict=True)
        table(title, ["run", "law", k_d.heading, worn.heading], list(rows))
    discs = [truth for truth in truths if isinstance(truth, TwinDiscTruth)]
    if discs:
        _show_discs(title if not pins else "", discs)


_DISCS = {"curved_": "crowned", "flat_": "cylindrical"}
"""Discs of a virtual test, by how its keys begin."""


def _show_discs(title: str, truths: "Sequence[TwinDiscTruth]") -> None:
    from tribopipe.base.units import WEAR_COEFFICIENT

    known = "wear_coefficient"
    keys = [key.removesuffix(known) for key in type(truths[0]).model_fields if key.endswith(known)]
    names, discs = [truth.id for truth in truths for _ in keys], [_DISCS[key] for key in keys]
    laws = [truth.law if truth.fatigue is None else f"{truth.law}, fatigue" for truth in truths for _ in keys]
    columns = [
        _column(head, [getattr(truth, key.format(disc)) for truth in truths for disc in keys], unit)
        for head, key, unit in (
            ("true k_D", "{}wear_coefficient", WEAR_COEFFICIENT),
            ("true wear at the end", "end_{}wear_depth", "um"),
            ("true wear volume at the end", "end_{}wear_volume", "mm^3"),
        )
    ]
    rows = zip(names, laws, discs * len(truths), *(one.cells for one in columns), strict=True)
    table(title, ["run", "law", "disc", *(one.heading for one in columns)], list(rows))


def _column(head: str, quantities: "Sequence[Quantity]", unit: str) -> Cells:
    """Return quantities as a column, with unit and power of ten in its header."""
    from tribopipe.base.units import pretty
    from tribopipe.cli.overview import number

    shown = number_column([number(one, unit) for one in quantities])
    return Cells(head, f"{head}, {shown.unit(pretty(unit))}", shown.cells)

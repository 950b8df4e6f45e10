"""Commands that take run folders: check, ingest, process, simulate."""

from functools import partial
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tribopipe.cli.options import DEFAULT_ARCHIVE, ArchiveFolder, AsJson, Force, RecipeFile, load_archive, load_recipe
from tribopipe.cli.output import FAILED, finish, print_json, progress, record_json, say, table
from tribopipe.cli.steps import say_clean_up

if TYPE_CHECKING:
    from tribopipe.archive.store import Archive
    from tribopipe.pipeline import Outcome
    from tribopipe.records.plan import TwinDiscTruth

_K_D = "mm^3/(N*mm)"
RunPaths = Annotated[list[Path], typer.Argument(help="Run folders, or folders of run folders.", metavar="RUN...")]


def _run_folders(paths: list[Path]) -> "tuple[list[Path], list[Outcome]]":
    """Return the run folders at or below the paths, and a failure for each path that has none."""
    from tribopipe.errors import ManifestError
    from tribopipe.pipeline import Outcome, find_runs

    folders: list[Path] = []
    failures: list[Outcome] = []
    for path in paths:
        try:
            folders += find_runs(path)
        except ManifestError as error:
            failures.append(Outcome.failed(str(path), "ingest", error))
    return folders, failures


def check(paths: RunPaths, as_json: AsJson = False) -> None:
    """Look a run over: schema, units, order of time, gaps, signs, magnitudes. Exit code 1 on errors and warnings."""
    from tribopipe.pipeline import attempted

    folders, failures = _run_folders(paths)
    documents, sound = [], True
    for path in folders:
        looked = attempted(str(path), "ingest", partial(_looked_over, path))
        if looked.error is not None:
            failures.append(looked)
            continue
        findings = looked.findings
        sound = sound and all(finding.severity == "note" for finding in findings)
        told = [record_json(finding) for finding in findings]
        documents.append({"path": str(path), "id": looked.run_id, "findings": told})
        for finding in findings:
            say(f"{looked.run_id}: {finding.severity}: {finding}")
        if not findings:
            say(f"{looked.run_id}: nothing to complain about")
    for failure in failures:
        say(f"error: {failure.error}")
    if as_json:
        unread = [{"path": failure.run_id, "error": str(failure.error), "findings": []} for failure in failures]
        print_json({"runs": documents + unread})
    if failures or not sound:
        raise typer.Exit(FAILED)


def _looked_over(path: Path) -> "Outcome":
    from tribopipe.checks.registry import check_run
    from tribopipe.ingest.harmonise import read_run
    from tribopipe.pipeline import Outcome

    run = read_run(path)
    return Outcome(run.id, "ingest", "unchanged", findings=tuple(check_run(run)))


def ingest(
    paths: RunPaths, archive: ArchiveFolder = DEFAULT_ARCHIVE, force: Force = False, as_json: AsJson = False
) -> None:
    """Read, check and archive run folders."""
    from tribopipe import pipeline

    store = load_archive(archive, must_exist=False)
    folders, outcomes = _run_folders(paths)
    with progress("ingest", len(folders)) as advance:
        for folder in folders:
            outcome = pipeline.attempted(str(folder), "ingest", partial(pipeline.ingest, folder, store, force=force))
            if outcome.error is None:
                say(f"{outcome.run_id}: {'archived' if outcome.status == 'done' else 'unchanged, nothing to do'}")
            _say_warnings(outcome)
            outcomes.append(outcome)
            advance(outcome.run_id)
    if as_json:
        print_json({"runs": [outcome.as_json() for outcome in outcomes]})
    finish(outcomes)


def process(
    paths: RunPaths,
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    recipe: RecipeFile = None,
    force: Force = False,
    as_json: AsJson = False,
    figures: Annotated[bool, typer.Option(help="Save figures beside the archive.")] = True,
) -> None:
    """Take run folders through the whole line: ingest, drift, friction, wear under both laws, prediction, figures.

    Studies beside the runs, study.toml or *.study.toml, say which runs are fitted together and which are predicted.
    """
    from tribopipe import pipeline
    from tribopipe.cli.pages import show_study_page
    from tribopipe.cli.summary import run_summary, show_summaries
    from tribopipe.report.study_page import study_page
    from tribopipe.studies import find_studies, load_studies, process_studies

    store, how = load_archive(archive, must_exist=False), load_recipe(recipe)
    folders, outcomes = _run_folders(paths)
    studies = load_studies([document for path in paths for document in find_studies(path)])
    studied = {run_id for study in studies for run_id in (*study.fit, *study.predict)}
    with progress("process", None) as advance:
        for outcome in chain(
            pipeline.process(folders, store, how, force=force, studied=studied),
            process_studies(store, studies, how, force=force),
        ):
            outcomes.append(outcome)
            advance(f"{outcome.run_id}: {outcome.stage.replace('_', ' ')}")
            _say_warnings(outcome)
            say_clean_up(outcome)
            _say_doubts(outcome)
    archived = (outcome for outcome in outcomes if outcome.stage == "ingest" and outcome.status != "failed")
    ids = list(dict.fromkeys(outcome.run_id for outcome in archived))
    evaluated = [outcome for outcome in outcomes if outcome.stage == "study" and outcome.error is None]
    drawn = _draw(store, outcomes) if figures else []
    outcomes += [outcome for outcome in drawn if outcome.error is not None]
    ids = [run_id for run_id in ids if store.path(run_id).exists()]  # as the folder may have gone meanwhile
    if as_json:
        documents = [run_summary(store, run_id) for run_id in ids]
        results = [record_json(outcome.result) for outcome in evaluated]
        print_json({"runs": documents, "studies": results, "steps": [outcome.as_json() for outcome in outcomes]})
    elif ids:
        show_summaries(store, ids)
        for outcome in evaluated:
            show_study_page(study_page(store, outcome.run_id))
    _say_what_was_done(outcomes, archive, drawn=any(outcome.status == "done" for outcome in drawn))
    finish(outcomes)


def _draw(store: "Archive", outcomes: "list[Outcome]") -> "list[Outcome]":
    """Save figures that are not up to date; one that cannot be saved does not stop the others."""
    from tribopipe.pipeline import attempted
    from tribopipe.report.drawn import figure_steps

    steps, drawn = figure_steps(store, outcomes), []
    with progress("figures", len(steps)) as advance:
        for name, step in steps:
            drawn.append(attempted(name, "figures", step))
            advance(name)
    return drawn


def _say_warnings(outcome: "Outcome") -> None:
    for finding in outcome.findings:
        if finding.severity == "warning":
            say(f"{outcome.run_id}: warning: {finding}")


def _say_doubts(outcome: "Outcome") -> None:
    """Say where the depth contradicts the end value, and what a run lacks for a correction."""
    from tribopipe.records.results import DriftCorrection

    correction = outcome.result
    if not isinstance(correction, DriftCorrection):
        return
    if correction.within_sensor_resolution is False:
        say(f"{outcome.run_id}: warning: {correction}")
    elif correction.lacks:
        say(f"{outcome.run_id}: {correction}")


def _say_what_was_done(outcomes: "list[Outcome]", archive: Path, *, drawn: bool) -> None:
    done = sum(outcome.status == "done" for outcome in outcomes)
    skipped = sum(outcome.status == "unchanged" for outcome in outcomes)
    where = f"; figures in {archive / 'figures'}" if drawn else ""
    if done or drawn:
        say(f"{done} steps done, {skipped} unchanged, in {archive}{where}")
    elif skipped:
        say(f"Nothing to do: all {skipped} steps are unchanged; --force redoes them.")


def simulate(
    folder: Annotated[Path, typer.Argument(help="Folder to write run folders into.")],
    plan: Annotated[Path, typer.Option("--plan", help="TOML file that says what to simulate.")],
    as_json: AsJson = False,
) -> None:
    """Record runs on a virtual tribometer: run folders whose truth is known."""
    from tribopipe.records.base import load_toml
    from tribopipe.records.plan import Plan, Truth, TwinDiscTruth
    from tribopipe.simulate import simulate_plan

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
                [truth.id, truth.law, truth.wear_coefficient.shown(_K_D), truth.end_pin_wear_depth.shown("um")]
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
    ends = (
        ("curved", truth.curved_wear_coefficient, truth.end_curved_wear_depth, truth.end_curved_wear_volume),
        ("flat", truth.flat_wear_coefficient, truth.end_flat_wear_depth, truth.end_flat_wear_volume),
    )
    law = truth.law if truth.fatigue is None else f"{truth.law}, fatigue"
    return [
        [truth.id, law, disc, k.shown(_K_D), depth.shown("um"), volume.shown("mm^3")] for disc, k, depth, volume in ends
    ]


COMMANDS = {"check": check, "ingest": ingest, "process": process, "simulate": simulate}

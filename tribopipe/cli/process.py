"""The command that takes run folders through all steps: process."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from tribopipe.base.errors import counted
from tribopipe.cli.options import (
    DEFAULT_ARCHIVE,
    Amend,
    ArchiveFolder,
    AsJson,
    FigureFormats,
    Figures,
    Force,
    JobsOnAllCores,
    Part,
    RecipeFile,
    Scheduler,
    Shard,
    Verbose,
    crew,
    load_archive,
    load_recipe,
    seen_by,
)
from tribopipe.cli.output import Advance, finish, followed, in_order, line_width, print_json, progress, record_json, say
from tribopipe.cli.runs import RunPaths, run_folders, say_amended, say_warnings
from tribopipe.cli.steps import say_change, say_clean_up

if TYPE_CHECKING:
    from tribopipe.archive.store import Archive
    from tribopipe.base.executor import Crew
    from tribopipe.documents.recipe import Recipe
    from tribopipe.documents.study import Study
    from tribopipe.pipeline.stages import Outcome


def process(
    paths: RunPaths,
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    recipe: RecipeFile = None,
    force: Force = False,
    amend: Amend = False,
    as_json: AsJson = False,
    figures: Figures = True,
    figure_formats: FigureFormats = None,
    jobs: JobsOnAllCores = None,
    scheduler: Scheduler = None,
    shard: Shard = None,
    verbose: Verbose = 0,
) -> None:
    """Process run folders: all steps from raw data to figures.

    The steps are ingest, preprocessing, drift, friction, wear under each law, prediction, studies and figures.

    Study documents next to the runs, study.toml or *.study.toml, state which runs are fitted together and which are
    predicted. With --shard, predictions, studies and figures are skipped; afterwards, run `process` on all runs once
    more without --shard to create them.
    """
    from tribopipe.pipeline.last_pass import keep_pass, state_before, steps_unchanged

    drawn_as: list[str] = [*(figure_formats or ("screen",))] if figures else []
    plain = not (force or amend or as_json or verbose or scheduler or shard)
    before = state_before(paths, archive, recipe, figures=drawn_as) if plain else None
    if before is not None and (steps := steps_unchanged(archive, before)) is not None:
        say(_nothing_to_do(steps))
        return
    from tribopipe.base.executor import at_work
    from tribopipe.pipeline.studies import find_studies, load_studies, process_studies

    how, asked = load_recipe(recipe), crew(jobs, scheduler, usual=0)
    folders, outcomes = run_folders(paths, shard, asked)
    # A run alone is done sooner than another process has begun.
    with at_work(replace(asked, jobs=1) if jobs is None and len(folders) < 2 else asked) as who:
        store = load_archive(seen_by(who, archive), must_exist=False)
        studies = load_studies([document for path in paths for document in find_studies(path)]) if shard is None else []
        with progress("process", len(folders)) as advance:
            taken = _taken(folders, store, how, who, studies=studies, alone=shard is not None, force=force, amend=amend)
            in_full = bool(verbose) or as_json or line_width(on_stderr=True) is None
            outcomes += _followed(taken, advance, in_full=in_full)
            outcomes += _followed(process_studies(store, studies, how, force=force, crew=who), advance, in_full=in_full)
        drawn = _draw(store, outcomes, who, figure_formats or ()) if figures and shard is None else []
    outcomes += [outcome for outcome in drawn if outcome.error is not None]
    outcomes += _unseen(store, outcomes) if who.scheduler else []
    new_figures = any(outcome.status == "done" for outcome in drawn)
    doubtful = _show(store, outcomes, as_json=as_json, verbose=verbose, in_full=in_full)
    _say_what_was_done(outcomes, archive, drawn=new_figures, doubtful=doubtful)
    if shard is not None:
        _say_what_is_left(shard)
    if before is not None and all(outcome.status == "unchanged" for outcome in [*outcomes, *drawn]):
        keep_pass(archive, before, len(outcomes))
    finish(outcomes, in_full=in_full)


def _taken(
    folders: "list[Path]",
    store: "Archive",
    how: "Recipe",
    who: "Crew",
    *,
    studies: "list[Study]",
    alone: bool,
    force: bool,
    amend: bool,
) -> "Iterator[Outcome]":
    """Process run folders: each on its own if ``alone``, otherwise including the steps that need other runs."""
    from tribopipe.pipeline import stages

    if alone:
        return stages.process_each(folders, store, how, force=force, amend=amend, crew=who)
    studied = {run_id for study in studies for run_id in (*study.fit, *study.predict)}
    return stages.process(folders, store, how, force=force, amend=amend, studied=studied, crew=who)


def _followed(coming: "Iterable[Outcome]", advance: "Advance", *, in_full: bool) -> "list[Outcome]":
    """Report steps as they finish; return them in the order of the runs, without results except those of studies.

    ``in_full`` shows every finding as a sentence; otherwise they are summarized at the end. Results of thousands of
    runs would fill the memory, and are in the archive.
    """
    from tribopipe.archive.step_names import step_in_words

    kept: list[Outcome] = []
    warned: set[tuple[str, str, str]] = set()
    told: set[str] = set()
    for outcome in coming:
        advance(f"{outcome.run_id}: {step_in_words(outcome.stage)}", by=int(outcome.stage == "ingest"))
        say_amended(outcome)
        if in_full:
            say_warnings(_less_repeated(outcome, warned))
            say_clean_up(outcome)
            _say_missing(outcome, told)
        say_change(outcome)
        kept.append(outcome if outcome.stage == "study" else replace(outcome, result=None))
    return in_order(kept)


def _less_repeated(outcome: "Outcome", warned: "set[tuple[str, str, str]]") -> "Outcome":
    """Omit findings of a fit that an earlier fit of the run has also had; ``warned`` contains these."""
    if outcome.stage != "wear_fit":
        return outcome
    fresh = tuple(one for one in outcome.findings if (outcome.run_id, one.code, one.where) not in warned)
    warned.update((outcome.run_id, one.code, one.where) for one in fresh)
    return replace(outcome, findings=fresh)


def _draw(store: "Archive", outcomes: "list[Outcome]", who: "Crew", formats: "Sequence[str]") -> "list[Outcome]":
    """Save figures that are not up to date."""
    from tribopipe.views.archived_figures import drawn, figure_steps

    steps = figure_steps(store, outcomes, formats)
    return followed(drawn(steps, who), "figures", len(steps))


def _unseen(store: "Archive", outcomes: "list[Outcome]") -> "Iterator[Outcome]":
    """Return failures of the runs that workers report as archived but this process cannot find."""
    from tribopipe.base.errors import ArchiveError
    from tribopipe.pipeline.stages import Outcome

    for run_id in _archived(outcomes):
        path = store.path(run_id)
        if not path.exists():
            error = ArchiveError(
                f"{path}: found no file, although a worker reported that the run was archived; expected an archive "
                "folder that all machines share; specify it with --archive"
            )
            yield Outcome.failed(run_id, "ingest", error)


def _archived(outcomes: "list[Outcome]") -> list[str]:
    archived = (outcome for outcome in outcomes if outcome.stage == "ingest" and outcome.status != "failed")
    return list(dict.fromkeys(outcome.run_id for outcome in archived))


def _show(store: "Archive", outcomes: "list[Outcome]", *, as_json: bool, verbose: int, in_full: bool) -> str | None:
    """Show the current results of the runs, and of studies; nothing if there was nothing to do.

    Return the first run that has a warning, if warnings were looked for.
    """
    from tribopipe.cli.pages import show_study_page
    from tribopipe.cli.process_table import say_problems, show_processed
    from tribopipe.cli.summary import run_summary, show_summaries
    from tribopipe.results.study import StudyResult
    from tribopipe.views.study_page import study_page

    ids = [run_id for run_id in _archived(outcomes) if store.path(run_id).exists()]  # the folder may have gone
    evaluated = [outcome for outcome in outcomes if outcome.stage == "study" and outcome.error is None]
    if as_json:
        documents = [run_summary(store, run_id) for run_id in ids]
        results = [record_json(outcome.result) for outcome in evaluated]
        print_json({"runs": documents, "studies": results, "steps": [outcome.as_json() for outcome in outcomes]})
    elif ids and verbose:
        show_summaries(store, ids)
        for outcome in evaluated:
            show_study_page(study_page(store, outcome.run_id), in_full=verbose > 1)
    elif ids and any(outcome.status != "unchanged" for outcome in outcomes):
        found = [outcome.result for outcome in evaluated if isinstance(outcome.result, StudyResult)]
        failed = {outcome.run_id for outcome in outcomes if outcome.error is not None}
        rows = show_processed(store, ids, found, failed)
        if not in_full:
            say_problems(rows)
        return next((row.id for row in rows if any(one.severity != "note" for one in row.problems)), None)
    return None


def _say_missing(outcome: "Outcome", told: set[str]) -> None:
    """Report what is missing for the first incomplete result of a run; ``told`` are the runs reported before."""
    from tribopipe.results.evaluation import DriftCorrection
    from tribopipe.results.wear_fit import WearFit

    found = outcome.result
    if isinstance(found, DriftCorrection | WearFit) and found.missing and outcome.run_id not in told:
        say(f"{outcome.run_id}: {found}")
        told.add(outcome.run_id)


def _say_what_was_done(outcomes: "list[Outcome]", archive: Path, *, drawn: bool, doubtful: str | None) -> None:
    done = sum(outcome.status == "done" for outcome in outcomes)
    skipped = sum(outcome.status == "unchanged" for outcome in outcomes)
    where = f"; figures in {archive / 'figures'}" if drawn else ""
    if done or drawn:
        steps = f"{counted(done, 'step')} done, {skipped} unchanged, in {archive}{where}."
        say(f"{steps} Next: {_next_command(outcomes, archive, doubtful)}")
    elif skipped:
        say(_nothing_to_do(skipped))


def _nothing_to_do(steps: int) -> str:
    return f"Nothing to do: all {steps} steps are unchanged; --force repeats them."


def _next_command(outcomes: "list[Outcome]", archive: Path, doubtful: str | None) -> str:
    """Return the next command: the page of a run with problems, a report of a study, or the list."""
    study = next((one.run_id for one in outcomes if one.stage == "study" and one.error is None), None)
    runs = _archived(outcomes)
    run = doubtful or (runs[0] if len(runs) == 1 else None)
    command = f"show {run}" if run and not (study and not doubtful) else f"report {study}" if study else "ls"
    at = "" if archive == DEFAULT_ARCHIVE else f" --archive {archive}"
    return f"`tribopipe {command}{at}`"


def _say_what_is_left(shard: Part) -> None:
    say(
        f"Part {shard.number} of {shard.of} is done; run `process` without --shard for predictions, studies and "
        "figures."
    )

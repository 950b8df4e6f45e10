"""Commands for single steps of runs: correct-drift, fit."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from tribopipe.cli.options import (
    DEFAULT_ARCHIVE,
    ArchiveFolder,
    AsJson,
    Force,
    Jobs,
    Law,
    Pressure,
    RecipeFile,
    RunIds,
    Scheduler,
    Verbose,
    chosen_ids,
    crew,
    load_archive,
    load_recipe,
    seen_by,
)
from tribopipe.cli.output import finish, print_json, print_outcomes, print_result, progress, say
from tribopipe.cli.runs import say_warnings
from tribopipe.cli.studies import show_together

if TYPE_CHECKING:
    from tribopipe.archive.store import Archive
    from tribopipe.base.executor import Crew
    from tribopipe.documents.recipe import Recipe
    from tribopipe.pipeline.stages import Outcome


def correct_drift(
    ids: RunIds = None,
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    recipe: RecipeFile = None,
    force: Force = False,
    as_json: AsJson = False,
    jobs: Jobs = None,
    scheduler: Scheduler = None,
) -> None:
    """Correct the depth signal of archived runs for drift.

    The correction is anchored to the post-test measurement.
    """
    who = crew(jobs, scheduler)
    store, how = load_archive(seen_by(who, archive)), load_recipe(recipe)
    names = ("clean_up", "drift_correction")
    steps = partial(_advanced, store=store, how=how, names=names, forced=names[1:] if force else ())
    outcomes = _each(chosen_ids(store, ids), "drift_correction", steps, who)
    if as_json:
        print_outcomes(outcomes)
    finish(outcomes)


def fit(
    ids: RunIds = None,
    model: Law = "archard",
    together: Annotated[
        bool,
        typer.Option("--together", help="Fit one k_D to all these runs, taking the between-run scatter into account."),
    ] = False,
    engine: Pressure = None,
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    recipe: RecipeFile = None,
    force: Force = False,
    as_json: AsJson = False,
    jobs: Jobs = None,
    scheduler: Scheduler = None,
    verbose: Verbose = 0,
) -> None:
    """Fit friction and the wear coefficient k_D of archived runs."""
    from tribopipe.archive.step_names import WEAR_FITS

    who = crew(jobs, scheduler)
    store, how = load_archive(seen_by(who, archive)), load_recipe(recipe, engine)
    if together:
        show_together(store, chosen_ids(store, ids), (), model, how, verbose=verbose, as_json=as_json)
        return
    names = ("clean_up", "drift_correction", "friction_fit", "specific_wear", WEAR_FITS[model])
    steps = partial(_advanced, store=store, how=how, names=names, forced=names[2:] if force else ())
    outcomes = _each(chosen_ids(store, ids), "wear_fit", steps, who)
    if as_json:
        fitted = [outcome.run_id for outcome in outcomes if outcome.stage == "wear_fit" and outcome.result]
        print_json({"runs": [_fit_json(store, run_id, model) for run_id in fitted]})
    finish(outcomes)


def _fit_json(store: "Archive", run_id: str, law: Law) -> dict[str, Any]:
    from tribopipe.cli.summary import run_summary

    summary = run_summary(store, run_id)
    numbers = {name: summary[name] for name in ("friction", "drift_rate", "end_wear_depth")}
    fitted = summary["wear_fits"][law]
    return {"id": run_id, **fitted, **numbers, "friction_source": fitted["friction"]}


def _advanced(
    run_id: str, store: "Archive", how: "Recipe", names: Sequence[str], forced: Sequence[str]
) -> "Iterator[Outcome]":
    from tribopipe.pipeline.stages import advance, compared

    steps = (advance(store, run_id, name, how, force=name in forced) for name in names)
    for outcome in compared(store, run_id, steps):
        asked = outcome.status == "unchanged" and outcome.step == names[-1]
        yield replace(outcome, worded=store.manifest(run_id).worded) if asked else outcome


_Stage = Literal["drift_correction", "wear_fit"]
_Steps = Callable[[str], "Iterator[Outcome]"]


def _each(ids: list[str], stage: _Stage, steps: _Steps, who: "Crew") -> "list[Outcome]":
    """Process and report each run; one that fails does not stop the others. Omits outcomes of preprocessing."""
    from tribopipe.archive.step_names import step_in_words
    from tribopipe.base.errors import TribopipeError
    from tribopipe.base.executor import in_turn
    from tribopipe.pipeline.stages import Outcome

    found: dict[str, list[Outcome]] = {}
    with progress(step_in_words(stage), len(ids)) as moved:
        for run_id, answer in in_turn(partial(_taken, stage=stage, steps=steps), ids, who):
            outcomes = [Outcome.failed(run_id, stage, answer)] if isinstance(answer, TribopipeError) else answer
            for outcome in outcomes:
                tell(outcome)
                # Whoever asks again is told again.
                if outcome.stage == stage and outcome.status == "unchanged":
                    print_result(f"{run_id}: {outcome.worded(str(outcome.result))}")
            found[run_id] = [outcome for outcome in outcomes if outcome.stage != "clean_up"]
            moved(run_id)
    return [outcome for run_id in ids for outcome in found[run_id]]


def _taken(run_id: str, stage: _Stage, steps: _Steps) -> "list[Outcome]":
    """Perform the steps of a run, until one fails."""
    from tribopipe.pipeline.stages import Outcome

    outcomes: list[Outcome] = []
    try:
        outcomes.extend(steps(run_id))
    except Exception as error:  # noqa: BLE001 - a fault in one run is no reason to leave the others
        outcomes.append(Outcome.failed(run_id, stage, error))
    return outcomes


def say_clean_up(outcome: "Outcome") -> None:
    """Report the changes made by preprocessing in this call, if any."""
    from tribopipe.documents.preprocessing import CleanUp

    if outcome.status == "done" and isinstance(outcome.result, CleanUp) and outcome.result.changes:
        say(f"{outcome.run_id}: {outcome.result}")


def say_change(outcome: "Outcome") -> None:
    """Report which main values differ from those of an earlier result in the displayed digits."""
    if outcome.previous is None:
        return
    from tribopipe.results.main_values import changes

    for told in changes(outcome.previous, outcome.result):
        say(f"{outcome.run_id}: {told}")


def tell(outcome: "Outcome") -> None:
    """Report the outcome of a step."""
    from tribopipe.archive.step_names import step_in_words

    say_change(outcome)
    if outcome.stage == "clean_up":
        say_clean_up(outcome)
    elif outcome.status == "unchanged":
        say(f"{outcome.run_id}: {step_in_words(outcome.stage)} unchanged, nothing to do")
    elif outcome.result is not None:
        print_result(f"{outcome.run_id}: {outcome.worded(str(outcome.result))}")
        for note in getattr(outcome.result, "notes", ()) if outcome.stage == "wear_fit" else ():
            say(f"{outcome.run_id}: note: {note}")
    say_warnings(outcome)

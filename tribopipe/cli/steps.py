"""Commands that take a run a step further: correct-drift, fit."""

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from tribopipe.cli.options import (
    DEFAULT_ARCHIVE,
    ArchiveFolder,
    AsJson,
    Force,
    Law,
    Pressure,
    RecipeFile,
    RunIds,
    chosen_ids,
    load_archive,
    load_recipe,
)
from tribopipe.cli.output import finish, print_json, progress, record_json, say
from tribopipe.cli.studies import show_together

if TYPE_CHECKING:
    from tribopipe.archive.store import Archive
    from tribopipe.pipeline import Outcome


def correct_drift(
    ids: RunIds = None,
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    recipe: RecipeFile = None,
    force: Force = False,
    as_json: AsJson = False,
) -> None:
    """Correct the linear drift of archived runs, anchored on the end value."""
    from tribopipe import pipeline

    store, how = load_archive(archive), load_recipe(recipe)

    def advance(run_id: str) -> "Iterable[Outcome]":
        say_clean_up(pipeline.clean_archived(store, run_id, how))
        yield pipeline.correct_archived_drift(store, run_id, how, force=force)

    outcomes = _each(chosen_ids(store, ids), "drift_correction", advance)
    if as_json:
        print_json(
            {"runs": [{"id": outcome.run_id} | record_json(outcome.result) for outcome in outcomes if outcome.result]}
        )
    finish(outcomes)


def fit(
    ids: RunIds = None,
    model: Annotated[Law, typer.Option("--model", "--law", help="Wear law.")] = "archard",
    together: Annotated[
        bool, typer.Option("--together", help="One k_D from all these runs, with the scatter between them.")
    ] = False,
    engine: Pressure = None,
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    recipe: RecipeFile = None,
    force: Force = False,
    as_json: AsJson = False,
) -> None:
    """Fit friction and identify the wear coefficient k_D of archived runs under a wear law."""
    from tribopipe import pipeline

    store, how = load_archive(archive), load_recipe(recipe, engine)
    if together:
        show_together(store, chosen_ids(store, ids), (), model, how, as_json=as_json)
        return

    def advance(run_id: str) -> "Iterable[Outcome]":
        say_clean_up(pipeline.clean_archived(store, run_id, how))
        yield pipeline.correct_archived_drift(store, run_id, how)
        yield pipeline.fit_archived_friction(store, run_id, how, force=force)
        yield pipeline.evaluate_archived_wear(store, run_id, how, force=force)
        yield pipeline.fit_archived_wear(store, run_id, model, how, force=force)

    outcomes = _each(chosen_ids(store, ids), "wear_fit", advance)
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


def _each(
    ids: list[str],
    stage: Literal["drift_correction", "wear_fit"],
    advance: "Callable[[str], Iterable[Outcome]]",
) -> "list[Outcome]":
    """Take each run further; one that fails does not stop the others."""
    from tribopipe.pipeline import Outcome

    outcomes: list[Outcome] = []
    with progress(stage.replace("_", " "), len(ids)) as moved:
        for run_id in ids:
            try:
                for outcome in advance(run_id):
                    outcomes.append(outcome)
                    tell(outcome)
            except Exception as error:  # noqa: BLE001 - a fault in one run is no reason to leave the others
                outcomes.append(Outcome.failed(run_id, stage, error))
            moved(run_id)
    return outcomes


def say_clean_up(outcome: "Outcome") -> None:
    """Say what a clean-up has changed just now, if anything."""
    from tribopipe.records.clean_up import CleanUp

    if outcome.status == "done" and isinstance(outcome.result, CleanUp) and outcome.result.changes:
        say(f"{outcome.run_id}: {outcome.result}")


def tell(outcome: "Outcome") -> None:
    """Say what became of a step."""
    if outcome.status == "unchanged":
        say(f"{outcome.run_id}: {outcome.stage.replace('_', ' ')} unchanged, nothing to do")
    elif outcome.result is not None:
        say(f"{outcome.run_id}: {outcome.result}")
        for note in getattr(outcome.result, "notes", ()) if outcome.stage == "wear_fit" else ():
            say(f"{outcome.run_id}: note: {note}")


COMMANDS = {"correct-drift": correct_drift, "fit": fit}

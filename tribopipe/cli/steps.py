"""Commands that take a run a step further: correct-drift, fit, predict."""

import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from tribopipe.cli.options import (
    DEFAULT_ARCHIVE,
    ArchiveFolder,
    AsJson,
    Force,
    Law,
    RecipeFile,
    RunIds,
    archived_ids,
    chosen_ids,
    load_archive,
    load_recipe,
    parsed,
)
from tribopipe.cli.output import finish, print_json, progress, record_json, say
from tribopipe.cli.studies import show_together

if TYPE_CHECKING:
    from tribopipe.archive.store import Archive
    from tribopipe.pipeline import Outcome
    from tribopipe.records.recipe import Recipe
    from tribopipe.records.results import WearPrediction
    from tribopipe.wear.friction_path import FrictionPath
    from tribopipe.wear.predict import WearScenario


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
    outcomes = _each(
        chosen_ids(store, ids),
        "drift_correction",
        lambda run_id: [pipeline.correct_archived_drift(store, run_id, how, force=force)],
    )
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
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    recipe: RecipeFile = None,
    force: Force = False,
    as_json: AsJson = False,
) -> None:
    """Fit friction and identify the wear coefficient k_D of archived runs under a wear law."""
    from tribopipe import pipeline

    store, how = load_archive(archive), load_recipe(recipe)
    if together:
        show_together(store, chosen_ids(store, ids), (), model, how, as_json=as_json)
        return

    def advance(run_id: str) -> "Iterable[Outcome]":
        yield pipeline.correct_archived_drift(store, run_id, how)
        yield pipeline.fit_archived_friction(store, run_id, how, force=force)
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
    from tribopipe.errors import TribopipeError
    from tribopipe.pipeline import Outcome

    outcomes: list[Outcome] = []
    with progress(stage.replace("_", " "), len(ids)) as moved:
        for run_id in ids:
            try:
                for outcome in advance(run_id):
                    outcomes.append(outcome)
                    _tell(outcome)
            except TribopipeError as error:
                outcomes.append(Outcome(run_id, stage, "failed", error=error))
            moved(run_id)
    return outcomes


def _tell(outcome: "Outcome") -> None:
    if outcome.status == "unchanged":
        say(f"{outcome.run_id}: {outcome.stage.replace('_', ' ')} unchanged, nothing to do")
    elif outcome.result is not None:
        say(f"{outcome.run_id}: {outcome.result}")
        for note in getattr(outcome.result, "notes", ()) if outcome.stage == "wear_fit" else ():
            say(f"{outcome.run_id}: note: {note}")


def predict(
    ids: RunIds = None,
    run: Annotated[Path | None, typer.Option("--run", help="Run folder to predict without an archive.")] = None,
    wear_coefficient: Annotated[
        str | None, typer.Option(help='k_D to use, such as "13.5e-9 mm^3/(N*mm)"; by default the archived fit\'s.')
    ] = None,
    law: Annotated[Law, typer.Option("--law", "--model", help="Wear law.")] = "archard",
    scheme: Annotated[
        Literal["exact", "published"], typer.Option(help="Closed form, or the paper's Euler steps.")
    ] = "exact",
    steps: Annotated[int, typer.Option(min=1, help="Euler steps of the published scheme.")] = 50_000,
    friction: Annotated[
        str | None, typer.Option(help='μ(s) for Sarkar\'s law, such as "A=0.226 b=0.496 c=32.877 m".')
    ] = None,
    at: Annotated[
        list[str] | None, typer.Option(help='Sliding distance to predict at, "500 m"; may be repeated.')
    ] = None,
    depth: Annotated[
        list[str] | None, typer.Option(help='Wear depth to find the distance of, "30 um"; may be repeated.')
    ] = None,
    load: Annotated[str | None, typer.Option(help='Another normal load, "400 mN".')] = None,
    speed: Annotated[str | None, typer.Option(help='Another sliding speed, "200 mm/s".')] = None,
    source: Annotated[
        list[str] | None,
        typer.Option("--from", help="Archived run that identifies k_D; may be repeated.", autocompletion=archived_ids),
    ] = None,
    target: Annotated[
        list[str] | None,
        typer.Option("--onto", help="Archived run to predict and judge; may be repeated.", autocompletion=archived_ids),
    ] = None,
    radius: Annotated[str | None, typer.Option(help='Another pin radius, "2 mm".')] = None,
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    recipe: RecipeFile = None,
    force: Force = False,
    as_json: AsJson = False,
) -> None:
    """Predict wear at other loads, speeds, distances or radii.

    With a run (an id, or a folder and a k_D) and what to change, the prediction is shown. With --from and --onto, runs
    are predicted from others, with bands and a verdict on the law. With none of these, every archived run is predicted
    from the comparable run under the lightest load, and the prediction is archived.
    """
    asked = [wear_coefficient, friction, at, depth, load, speed, radius, scheme == "published"]
    how = load_recipe(recipe)
    if source or target:
        _predict_onto(archive, source, target, law, how, any(asked) or ids or run, as_json=as_json)
        return
    if run is None and not any(asked):
        _predict_archived(archive, ids, law, how, force=force, as_json=as_json)
        return
    if run is None and not ids:
        raise typer.BadParameter("name a run: an archived ID, or --run DIR with --wear-coefficient")
    if run is not None and ids:
        raise typer.BadParameter("name either archived runs or --run DIR, not both")
    scenarios = (
        [_folder_scenario(run, wear_coefficient, law, friction, how)]
        if run
        else [
            _archived_scenario(load_archive(archive), run_id, wear_coefficient, law, friction, how)
            for run_id in ids or []
        ]
    )
    results = [
        _predict(_changed(scenario, load, speed, radius), scenario_distance, at, depth, scheme, steps, reference)
        for scenario, scenario_distance, reference in scenarios
    ]
    for result in results:
        say(str(result))
    if as_json:
        documents = [record_json(result) for result in results]
        print_json(documents[0] if len(documents) == 1 else {"predictions": documents})


def _predict_onto(
    folder: Path,
    source: list[str] | None,
    target: list[str] | None,
    law: Law,
    recipe: "Recipe",
    beside: object,
    *,
    as_json: bool,
) -> None:
    if not source or not target or beside:
        raise typer.BadParameter("give runs to fit, --from ID, and runs to predict, --onto ID, and nothing else")
    show_together(load_archive(folder), source, target, law, recipe, as_json=as_json)


def _predict_archived(
    folder: Path, ids: list[str] | None, law: Law, recipe: "Recipe", *, force: bool, as_json: bool
) -> None:
    from tribopipe import pipeline

    store = load_archive(folder)
    chosen, outcomes = chosen_ids(store, ids), []
    with progress("prediction", len(chosen)) as moved:
        for outcome in pipeline.predict_from_lightest(store, chosen, law, recipe, force=force):
            outcomes.append(outcome)
            _tell(outcome)
            moved(outcome.run_id)
    if not outcomes:
        say(f"Nothing to predict: no run has a comparable one under a lighter load with a k_D under {law}.")
    if as_json:
        print_json(
            {"runs": [{"id": outcome.run_id} | record_json(outcome.result) for outcome in outcomes if outcome.result]}
        )
    finish(outcomes)


_Scenario = tuple["WearScenario", float | None, str | None]


def _folder_scenario(run: Path, coefficient: str | None, law: Law, friction: str | None, recipe: "Recipe") -> _Scenario:
    """Build a scenario from a run folder and a given k_D."""
    from tribopipe.records.manifest import manifest_path, read_manifest
    from tribopipe.wear.friction_path import stated_path
    from tribopipe.wear.predict import WearScenario

    if coefficient is None:
        raise typer.BadParameter('a run folder has no k_D: give one, --wear-coefficient "13.5e-9 mm^3/(N*mm)"')
    manifest, _ = read_manifest(manifest_path(run))
    conditions = manifest.conditions
    path: FrictionPath | None = None
    if law == "sarkar":
        if friction is not None:
            path = _parse_friction(friction)
        elif conditions.friction is not None:
            path = stated_path(conditions.friction)
        else:
            path = _measured_friction(run, recipe)
    scenario = WearScenario(
        manifest.pin_on_disc,
        conditions.normal_load,
        _quantity("--wear-coefficient", coefficient, "wear coefficient"),
        law,
        path,
        recipe,
        conditions.sliding_speed,
    )
    return scenario, conditions.sliding_distance.value if conditions.sliding_distance else None, None


def _measured_friction(run: Path, recipe: "Recipe") -> "FrictionPath | None":
    from tribopipe.friction import fit_friction
    from tribopipe.ingest.harmonise import read_run
    from tribopipe.wear.friction_path import run_path

    read = read_run(run)
    return run_path(read, fit_friction(read, recipe.friction), recipe.wear.friction)


def _archived_scenario(
    store: "Archive", run_id: str, coefficient: str | None, law: Law, friction: str | None, recipe: "Recipe"
) -> _Scenario:
    """Build a scenario from an archived run, with its own k_D unless another is given."""
    from tribopipe.errors import FitError
    from tribopipe.pipeline import archived_fit, archived_friction
    from tribopipe.wear.friction_path import run_path
    from tribopipe.wear.predict import WearScenario

    raw = store.raw(run_id)
    if coefficient is not None:
        known = _quantity("--wear-coefficient", coefficient, "wear coefficient")
    else:
        fitted = archived_fit(store, run_id, law)
        if fitted.wear_coefficient is None:
            raise FitError(
                f"{run_id}: found no k_D; the run lacks {' and '.join(fitted.lacks)}; give one with --wear-coefficient"
            )
        known = fitted.wear_coefficient
    path = None
    if law == "sarkar":
        path = (
            _parse_friction(friction)
            if friction
            else run_path(raw, archived_friction(store, run_id), recipe.wear.friction)
        )
    conditions = raw.manifest.conditions
    scenario = WearScenario(
        raw.manifest.pin_on_disc, conditions.normal_load, known, law, path, recipe, conditions.sliding_speed
    )
    return scenario, float(raw.sliding_distance[-1]), None if coefficient else run_id


def _changed(scenario: "WearScenario", load: str | None, speed: str | None, radius: str | None) -> "WearScenario":
    """Put other conditions into a scenario."""
    from dataclasses import replace

    if load is not None:
        scenario = replace(scenario, normal_load=_quantity("--load", load, "force"))
    if speed is not None:
        scenario = replace(scenario, sliding_speed=_quantity("--speed", speed, "speed"))
    if radius is not None:
        pin = scenario.contact.pin.model_copy(update={"radius": _quantity("--radius", radius, "length")})
        scenario = replace(scenario, contact=scenario.contact.model_copy(update={"pin": pin}))
    return scenario


def _predict(
    scenario: "WearScenario",
    own_distance: float | None,
    at: list[str] | None,
    depth: list[str] | None,
    scheme: Literal["exact", "published"],
    steps: int,
    reference: str | None,
) -> "WearPrediction":
    from tribopipe.wear.predict import predict_wear

    distances = [parsed("--at", text, "distance") for text in at or []]
    depths = [parsed("--depth", text, "length") for text in depth or []]
    if not distances and not depths:
        if own_distance is None:
            raise typer.BadParameter('say where to predict: --at "500 m"')
        distances = [own_distance]
    return predict_wear(scenario, distances, depths=depths, scheme=scheme, steps=steps, reference=reference)


def _quantity(option: str, text: str, kind: str) -> Any:
    """Read an option as a quantity above zero."""
    from tribopipe.errors import UnitError
    from tribopipe.records.quantity import Quantity
    from tribopipe.units import KINDS

    value = parsed(option, text, kind)
    if not value > 0:
        raise UnitError(f"{option}: found {text!r}; expected a {kind} above zero, such as {KINDS[kind].example!r}")
    return Quantity(value=value, unit=KINDS[kind].si)


_FRICTION = re.compile(r"\s*A\s*=\s*(\S+)[\s,;]+b\s*=\s*(\S+)[\s,;]+c\s*=\s*(.+?)\s*")


def _parse_friction(text: str) -> "FrictionPath":
    """Read "A=0.226 b=0.496 c=32.877 m"."""
    from tribopipe.errors import UnitError
    from tribopipe.wear.friction_path import ExponentialFriction

    found = _FRICTION.fullmatch(text)
    if found is None:
        raise UnitError(
            f'--friction: found {text!r}; expected the three of Eq. 7, such as "A=0.226 b=0.496 c=32.877 m"'
        )
    amplitude, steady, distance = found.groups()
    running_in = parsed("--friction", distance, "distance")
    if not running_in > 0:
        raise UnitError(f"--friction: found c = {distance}; expected a distance above zero")
    start, end = (parsed("--friction", ratio.rstrip(",;"), "ratio") for ratio in (amplitude, steady))
    return ExponentialFriction(start, end, running_in)


COMMANDS = {"correct-drift": correct_drift, "fit": fit, "predict": predict}

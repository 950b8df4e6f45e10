"""The command that predicts wear, from archived runs or from a run folder and given wear coefficients."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from tribopipe.cli.options import (
    DEFAULT_ARCHIVE,
    ArchiveFolder,
    AsJson,
    Force,
    Friction,
    Law,
    Pressure,
    RecipeFile,
    RunIds,
    Speed,
    Verbose,
    archived_ids,
    chosen_ids,
    load_archive,
    load_recipe,
    parsed,
    place,
    quantity,
)
from tribopipe.cli.output import finish, followed, print_json, print_outcomes, print_result, record_json, say
from tribopipe.cli.steps import tell
from tribopipe.cli.studies import show_together
from tribopipe.cli.subject import Given, Subject, archived_subject, coefficients_by_body, folder_subject, no_coefficient
from tribopipe.physics.calculation_methods import DistanceConvention, WearEngine

if TYPE_CHECKING:
    from tribopipe.documents.manifest import RunManifest
    from tribopipe.documents.quantity import Quantity
    from tribopipe.documents.recipe import Recipe
    from tribopipe.evaluation.wear.scenario import KnownWear
    from tribopipe.results.wear_prediction import WearPrediction

Scheme = Literal["exact", "published"]


@dataclass(frozen=True)
class _Asked:
    """Options of a prediction, as given on the command line."""

    law: Law
    scheme: Scheme
    recipe: "Recipe"
    steps: int | None
    coefficients: list[str]
    friction: str | None
    at: list[str]
    depth: list[str]
    changes: dict[str, str]
    """What is different from run.toml, by its option."""
    distance: DistanceConvention | None
    engine: WearEngine | None

    @property
    def anything(self) -> bool:
        """Whether any option other than the law is given."""
        how = (self.steps, self.distance, self.scheme == "published", self.friction)
        return any((*how, self.changes, self.coefficients, self.at, self.depth))


def predict(
    ids: RunIds = None,
    run: Annotated[
        Path | None, typer.Option("--run", help="Run folder to use for the prediction, without an archive.")
    ] = None,
    wear_coefficient: Annotated[
        list[str] | None,
        typer.Option(
            help='k_D to use, for example "13.5e-9 mm^3/(N*mm)"; default: value from the archived fit. For both '
            'bodies, specify the option twice, with the names of the bodies: pin="1e-9 mm^2/N", disc="4e-7 mm^2/N".'
        ),
    ] = None,
    law: Law = "archard",
    scheme: Annotated[Scheme, typer.Option(help="Exact solution, or Euler steps as in the paper.")] = "exact",
    steps: Annotated[
        int | None,
        typer.Option(
            min=1,
            help="Number of Euler steps in the published scheme; default: 50,000, or one per rotation for twin discs.",
        ),
    ] = None,
    friction: Friction = None,
    at: Annotated[
        list[str] | None,
        typer.Option(
            help='Sliding distance at which to predict wear, for example "500 m", or number of rotations for discs, '
            'for example "1e6"; may be repeated.'
        ),
    ] = None,
    depth: Annotated[
        list[str] | None,
        typer.Option(
            help='Wear depth for which to calculate the sliding distance, for example "30 um"; may be repeated.'
        ),
    ] = None,
    load: Annotated[
        str | None, typer.Option(help='Normal load, for example "400 mN"; default: that of the run.')
    ] = None,
    speed: Speed = None,
    source: Annotated[
        list[str] | None,
        typer.Option(
            "--from", help="Archived run from which k_D is identified; may be repeated.", autocompletion=archived_ids
        ),
    ] = None,
    target: Annotated[
        list[str] | None,
        typer.Option(
            "--onto",
            help="Archived run whose wear is predicted and compared with the measurement; may be repeated.",
            autocompletion=archived_ids,
        ),
    ] = None,
    radius: Annotated[
        str | None, typer.Option(help='Pin radius, for example "2 mm"; default: that of the run.')
    ] = None,
    slip: Annotated[
        str | None, typer.Option(help='Slip of twin discs, for example "10 %"; default: that of the run.')
    ] = None,
    crown_radius: Annotated[
        str | None, typer.Option(help='Crown radius of the crowned disc, for example "8 mm"; default: that of the run.')
    ] = None,
    distance: Annotated[
        DistanceConvention | None,
        typer.Option(
            "--distance-per-rotation", help="Convention for the sliding distance of two discs; overrides the recipe."
        ),
    ] = None,
    engine: Pressure = None,
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    recipe: RecipeFile = None,
    force: Force = False,
    verbose: Verbose = 0,
    as_json: AsJson = False,
) -> None:
    """Predict wear at other loads, speeds, sliding distances or slip ratios.

    If you specify a run (an ID, or a folder and a k_D) and the conditions to change, the prediction is shown. With
    --from and --onto, k_D is identified from some runs, and the wear of others is predicted with it and compared with
    the measurement. Without these, every archived run is predicted from the comparable run at the lightest load, and
    the prediction is archived.
    """
    how = load_recipe(recipe, engine)
    options = {"--load": load, "--speed": speed, "--radius": radius, "--slip": slip, "--crown-radius": crown_radius}
    changes = {option: text for option, text in options.items() if text is not None}
    places = (at or [], depth or [])
    asked = _Asked(law, scheme, how, steps, wear_coefficient or [], friction, *places, changes, distance, engine)
    if source or target:
        _predict_onto(archive, source, target, law, how, asked.anything or ids or run, verbose=verbose, as_json=as_json)
        return
    if run is None and not asked.anything and engine is None:
        _predict_archived(archive, ids, law, how, force=force, as_json=as_json)
        return
    _show_predictions(_subjects(run, ids, archive, asked), asked, as_json=as_json)


def _predict_onto(
    folder: Path,
    source: list[str] | None,
    target: list[str] | None,
    law: Law,
    recipe: "Recipe",
    beside: object,
    *,
    verbose: int,
    as_json: bool,
) -> None:
    if not source or not target or beside:
        raise typer.BadParameter(
            "specify only the runs to fit (--from ID) and the runs to compare with the prediction (--onto ID)"
        )
    show_together(load_archive(folder), source, target, law, recipe, verbose=verbose, as_json=as_json)


def _predict_archived(
    folder: Path, ids: list[str] | None, law: Law, recipe: "Recipe", *, force: bool, as_json: bool
) -> None:
    from tribopipe.physics.laws import law_title
    from tribopipe.pipeline import stages

    store = load_archive(folder)
    chosen = chosen_ids(store, ids)
    predicted = stages.predict_from_lightest(store, chosen, [law], recipe, force=force)
    outcomes = followed(predicted, "prediction", len(chosen), tell)
    if not outcomes:
        under = law_title(law)
        say(
            f"Nothing to predict: no comparable run at a lighter load has a k_D fitted under {under}; to predict from "
            'the k_D of the run itself, state what to predict, such as --at "500 m".'
        )
    if as_json:
        print_outcomes(outcomes)
    finish(outcomes)


def _subjects(
    run: Path | None, ids: list[str] | None, archive: Path, asked: _Asked
) -> list[tuple[Subject, str | None]]:
    """Return the runs to predict, each with the name of the run whose k_D it is predicted from."""
    if run is None and not ids:
        raise typer.BadParameter("specify an archived run by its ID, or --run DIR with --wear-coefficient")
    if run is not None and ids:
        raise typer.BadParameter("specify either archived runs or --run DIR, not both")
    given = Given(asked.law, asked.recipe, bool(asked.coefficients), asked.friction)
    if run is not None:
        if not asked.coefficients:
            raise typer.BadParameter(no_coefficient(run))
        return [(folder_subject(run, given), None)]
    store = load_archive(archive)
    return [(archived_subject(store, one, given), None if asked.coefficients else one) for one in ids or []]


def _show_predictions(subjects: list[tuple[Subject, str | None]], asked: _Asked, *, as_json: bool) -> None:
    results = [_predict(subject, asked, reference) for subject, reference in subjects]
    for (subject, _), result in zip(subjects, results, strict=True):
        print_result(subject.manifest.worded(str(result)))
    if as_json:
        documents = [record_json(result) for result in results]
        print_json(documents[0] if len(documents) == 1 else {"predictions": documents})


def _predict(subject: Subject, asked: _Asked, reference: str | None) -> "WearPrediction":
    from tribopipe.evaluation.wear.prediction import predict_wear, wear_scenario

    manifest = _changed(subject.manifest, asked)
    scenario = wear_scenario(manifest, _known(subject, asked), asked.law, subject.friction, asked.recipe)
    at, depths = _places(subject, asked)
    load = None if reference is None else subject.manifest.conditions.normal_load
    return predict_wear(
        scenario,
        at,
        depths=depths,
        scheme=asked.scheme,
        steps=asked.steps,
        reference=reference,
        reference_load=load,
    )


_OF_A_PIN = {
    "--radius": "a pin; for the crowned disc, use --crown-radius",
    "--engine": "a pin; wear of two discs is predicted with the GIWM",
}
_OF_DISCS = {
    "--slip": "two discs; a pin has no slip",
    "--crown-radius": "two discs; for a pin, use --radius",
    "--distance-per-rotation": "two discs; a pin slides over the whole distance",
}


def _changed(manifest: "RunManifest", asked: _Asked) -> "RunManifest":
    """Return the manifest with the load, speed, slip and radius specified on the command line."""
    contact: Any = manifest.described
    given: dict[str, str | None] = {
        **asked.changes,
        "--engine": asked.engine,
        "--distance-per-rotation": asked.distance,
    }
    rolls = manifest.slip is not None
    for option, whose in (_OF_A_PIN if rolls else _OF_DISCS).items():
        if given.get(option) is not None:
            raise typer.BadParameter(f"{option} applies to {whose}")
    changed: dict[str, Quantity | None] = {}
    for option, key, kind in (("--load", "normal_load", "force"), ("--speed", contact.progress.speed, "speed")):
        if option in asked.changes:
            changed[key] = quantity(option, asked.changes[option], kind)
    if rolls:
        slip = asked.changes.get("--slip")
        kept = manifest.slip_with(asked.recipe.uncertainty.slip)
        changed |= {"slip": kept if slip is None else _slip(slip), "flat_disc_speed": None}
    contact = _resized(contact, asked.changes)
    if not rolls and contact.own_track_radius is not None:  # a larger ring, turning as fast, slides faster
        changed["track_radius"] = contact.own_track_radius
    conditions = manifest.conditions.model_copy(update=changed)
    return manifest.model_copy(update={"contact": contact, "conditions": conditions})


def _resized(contact: Any, changes: dict[str, str]) -> Any:
    """Return a contact with the specified radius: of a tip, or of a crown."""
    radius = next((option for option in ("--radius", "--crown-radius") if option in changes), None)
    return contact if radius is None else contact.resized(quantity(radius, changes[radius], "length"))


def _known(subject: Subject, asked: _Asked) -> "KnownWear":
    """Return the given k_D, or else the fitted one, with its engine and its distance convention."""
    from tribopipe.base.errors import FitError
    from tribopipe.evaluation.wear.scenario import given_wear, known_wear

    manifest = subject.manifest
    fitted = None if subject.fit is None else known_wear(subject.fit)
    if fitted is None:
        known = given_wear(
            manifest.described, coefficients_by_body(manifest.described, asked.coefficients), asked.recipe
        )
        return known if asked.distance is None else replace(known, distance=asked.distance)
    if asked.engine not in (None, fitted.engine):
        raise FitError(
            f"{manifest.id}: found a k_D fitted with --engine {fitted.engine}; expected --engine {asked.engine}, "
            f"because k_D is valid only for the engine it was fitted with; fit again with --engine {asked.engine}"
        )
    if asked.distance not in (None, fitted.distance):
        raise FitError(
            f'{manifest.id}: found a k_D fitted with distance_per_rotation = "{fitted.distance}"; expected '
            f'"{asked.distance}", because k_D is valid only for the convention with which it was fitted; set '
            f'distance_per_rotation = "{asked.distance}" under [wear] in the recipe and fit again'
        )
    return fitted


def _places(subject: Subject, asked: _Asked) -> tuple[list[float], list[float]]:
    """Return the positions at which to predict wear, and the depths, m, to reach; by default, the end of the run."""
    progress = subject.manifest.progress
    at = [place("--at", text, progress) for text in asked.at]
    depths = [_depth(text) for text in asked.depth]
    if not at and not depths:
        if subject.end is None:
            raise typer.BadParameter(f'specify a sliding distance: --at "{progress.example}"')
        at = [subject.end]
    return at, depths


def _depth(text: str) -> float:
    """Read a wear depth, m."""
    from tribopipe.base.errors import UnitError

    depth = parsed("--depth", text, "length")
    if depth < 0:
        raise UnitError(f"--depth: found {text!r}; expected a wear depth of zero or more, such as '30 um'")
    return depth


def _slip(text: str) -> "Quantity":
    """Read a slip, which may be negative but not zero."""
    from tribopipe.base.errors import UnitError
    from tribopipe.documents.quantity import Quantity

    value = parsed("--slip", text, "percentage")
    if value == 0 or value <= -1:
        raise UnitError(
            f"--slip: found {text!r}; expected a nonzero slip greater than -100 %; discs in pure rolling have no "
            "sliding wear"
        )
    return Quantity(value=value, unit="1")

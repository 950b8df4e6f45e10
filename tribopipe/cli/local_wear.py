"""The command that simulates local wear: of archived runs, or of run folders with a given wear coefficient."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tribopipe.cli.options import (
    DEFAULT_ARCHIVE,
    ArchiveFolder,
    AsJson,
    Force,
    Law,
    RecipeFile,
    archived_ids,
    chosen_ids,
    load_archive,
    load_recipe,
    place,
)
from tribopipe.cli.output import finish, followed, print_outcomes, print_result
from tribopipe.cli.steps import tell
from tribopipe.cli.subject import Given, coefficients_by_body, folder_subject, is_folder, no_coefficient
from tribopipe.physics.calculation_methods import Course, Engine

if TYPE_CHECKING:
    from tribopipe.archive.store import Archive
    from tribopipe.documents.manifest import RunManifest
    from tribopipe.documents.quantity import Quantity
    from tribopipe.documents.recipe import Recipe
    from tribopipe.evaluation.wear.local import LocalOptions
    from tribopipe.pipeline.stages import Outcome
    from tribopipe.results.local_wear import LocalCurves


@dataclass(frozen=True)
class _Asked:
    """Options of local-wear, as given on the command line."""

    law: Law
    recipe: "Recipe"
    how: "LocalOptions"
    coefficients: tuple[str, ...]
    at: tuple[str, ...]
    figures: Path | None
    force: bool

    def by_body(self, manifest: "RunManifest") -> "dict[str, Quantity]":
        """Return the given k_D by body. Raises ``FitError``, so that runs with other bodies are still simulated."""
        from tribopipe.base.errors import FitError

        try:
            return coefficients_by_body(manifest.described, self.coefficients)
        except typer.BadParameter as error:
            raise FitError(f"{manifest.id}: {error.message}") from error

    def places(self, manifest: "RunManifest") -> list[float]:
        """Return the sliding distances, m, or rotations to simulate; nothing if none are specified."""
        return [place("--at", text, manifest.progress) for text in self.at]


def local_wear(
    runs: Annotated[
        list[str] | None,
        typer.Argument(
            help="IDs of archived runs, or run folders; default: all archived runs.",
            metavar="ID|RUN",
            autocompletion=archived_ids,
        ),
    ] = None,
    law: Law = "archard",
    wear_coefficient: Annotated[
        list[str] | None,
        typer.Option(
            help='Wear coefficient k_D in V = k_D·F_N·s, for example "13.5e-9 mm^3/(N*mm)"; default: value from '
            "the archived fit. If both bodies wear, specify the option twice, with the names of the bodies: "
            'pin="1e-9 mm^2/N", disc="4e-7 mm^2/N"; for two discs, the names can be omitted: first the crowned disc, '
            "then the cylindrical disc."
        ),
    ] = None,
    engine: Annotated[
        Engine | None,
        typer.Option(
            help="Contact solver; default: rings for a pin, half-space for discs or if the counterbody wears too."
        ),
    ] = None,
    scheme: Annotated[
        Course,
        typer.Option(
            help=(
                "Scheme: implicit uses the pressure at the end of each step; explicit, as in the paper, uses the "
                "pressure at the start; economy corrects the contact instead of solving it again, as in UMESHMOTION."
            ),
        ),
    ] = "implicit",
    at: Annotated[
        list[str] | None,
        typer.Option(
            help='Sliding distance to simulate, for example "500 m", or number of rotations for discs, for example '
            '"1e6"; may be repeated.'
        ),
    ] = None,
    steps_per_decade: Annotated[int, typer.Option(min=1, help="Number of wear steps per decade of wear.")] = 16,
    update_mesh_every: Annotated[
        int,
        typer.Option(
            min=0,
            help=(
                "Number of wear steps between updates of the finite-element mesh to the worn shape (with economy: "
                "between contact solutions); 0 disables updates."
            ),
        ),
    ] = 50,
    stress_loss: Annotated[
        float,
        typer.Option(min=0, max=0.5, help="Fraction of the stresses lost per increment of the economy scheme."),
    ] = 0.0,
    figures: Annotated[Path | None, typer.Option(help="Output folder for figures.")] = None,
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    recipe: RecipeFile = None,
    force: Force = False,
    as_json: AsJson = False,
) -> None:
    """Simulate wear with the local contact pressure.

    The result is compared with the Global Incremental Wear Model, which uses the mean pressure.

    Archived runs are simulated with their own k_D up to the end of the test, and the result is archived with the
    pressure fields. A run folder requires --wear-coefficient; its result is shown, but not archived.
    """
    from tribopipe.evaluation.wear.local import LocalOptions
    from tribopipe.pipeline.output_paths import require_folder
    from tribopipe.pipeline.stages import find_runs

    if figures is not None:
        require_folder(figures)
    asked = _Asked(
        law,
        load_recipe(recipe),
        LocalOptions(engine, scheme, steps_per_decade, update_mesh_every, stress_loss),
        tuple(wear_coefficient or ()),
        tuple(at or ()),
        figures,
        force,
    )
    folders = [folder for run in runs or () if is_folder(run, archive) for folder in find_runs(Path(run))]
    ids = [run for run in runs or () if not is_folder(run, archive)]
    store = load_archive(archive) if ids or not folders else None
    chosen = [] if store is None else chosen_ids(store, ids)
    worn = _worn(folders, store, chosen, asked)
    outcomes = followed(worn, "local wear", len(folders) + len(chosen), tell)
    if as_json:
        print_outcomes(outcomes)
    finish(outcomes)


def _worn(folders: list[Path], store: "Archive | None", ids: list[str], asked: _Asked) -> "Iterator[Outcome]":
    """Simulate each run; one that fails does not stop the others."""
    from tribopipe.pipeline.stages import attempted

    steps: list[tuple[str, Callable[[], Outcome]]]
    steps = [(str(run), partial(_wear_folder, run, asked)) for run in folders]
    if store is not None:
        steps += [(run, partial(_wear_archived, store, run, asked)) for run in ids]
    for run, step in steps:
        yield attempted(run, "local_wear", step)


def _wear_folder(folder: Path, asked: _Asked) -> "Outcome":
    from tribopipe.base.errors import FitError
    from tribopipe.evaluation.wear.local import default_places, local_scenario, wear_locally
    from tribopipe.pipeline.stages import Outcome

    if not asked.coefficients:
        raise FitError(no_coefficient(folder))
    subject = folder_subject(folder, Given(asked.law, asked.recipe, has_coefficient=True))
    manifest, end = subject.manifest, subject.end
    places = asked.places(manifest) or (default_places(end) if end else [])
    if not places:
        raise FitError(
            f"{folder}: found no sliding distance in run.toml; expected the end of the simulation; add "
            f'--at "{manifest.progress.example}"'
        )
    scenario = local_scenario(manifest, asked.by_body(manifest), asked.law, subject.friction, asked.recipe)
    curves = wear_locally(scenario, places, asked.how)
    _save_figures(curves, manifest.id, asked.figures)
    return Outcome(manifest.id, "local_wear", "done", curves.result)


def _wear_archived(store: "Archive", run_id: str, asked: _Asked) -> "Outcome":
    from tribopipe.archive.local_wear_tables import archived_local_wear
    from tribopipe.archive.step_names import LOCAL_WEAR
    from tribopipe.pipeline.stages import wear_archived_locally

    manifest = store.manifest(run_id)
    outcome = wear_archived_locally(
        store,
        run_id,
        asked.law,
        asked.recipe,
        asked.how,
        coefficients=asked.by_body(manifest),
        at=asked.places(manifest),
        force=asked.force,
    )
    if asked.figures is not None:
        _save_figures(archived_local_wear(store.step(run_id, LOCAL_WEAR[asked.law])), run_id, asked.figures)
    return outcome


def _save_figures(curves: "LocalCurves | None", run_id: str, folder: Path | None) -> None:
    from tribopipe.views.local_wear_figures import save_local_wear_figures

    if curves is not None and folder is not None:
        for path in save_local_wear_figures(curves, run_id, folder):
            print_result(f"{run_id}: {path}")

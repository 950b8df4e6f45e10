"""The run for which wear is calculated: an archived run with its fit, or a run folder with a given k_D."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from tribopipe.base.errors import FitError
from tribopipe.cli.options import friction_path, quantity

if TYPE_CHECKING:
    from tribopipe.archive.store import Archive
    from tribopipe.cli.options import Law
    from tribopipe.documents.contact import Contact
    from tribopipe.documents.manifest import RunManifest, StatedFriction
    from tribopipe.documents.quantity import Quantity
    from tribopipe.documents.recipe import Recipe
    from tribopipe.physics.friction_path import FrictionPath
    from tribopipe.results.wear_fit import WearFit


@dataclass(frozen=True)
class Subject:
    """Conditions, k_D and friction of the run for which wear is calculated."""

    manifest: "RunManifest"
    end: float | None
    """End of the test, m or rotations; None if run.toml does not state it."""
    friction: "FrictionPath | StatedFriction | None"
    """μ(s) for a law that needs it, with its uncertainties if run.toml states it; None if it is unknown."""
    fit: "WearFit | None" = None
    """Archived fit; None if k_D is given."""


@dataclass(frozen=True)
class Given:
    """Wear law and recipe, and whether k_D and friction are given on the command line."""

    law: "Law"
    recipe: "Recipe"
    has_coefficient: bool
    friction: str | None = None
    eq_7: bool = False
    """Whether μ(s) must be Eq. 7, not the recorded friction."""


def is_folder(run: str, archive: Path) -> bool:
    """Distinguish a run folder from the ID of an archived run, which has priority."""
    return Path(run).exists() and not (archive / f"{run}.h5").exists()


def no_coefficient(folder: Path) -> str:
    """Return the error for a run folder without --wear-coefficient."""
    return (
        f"{folder}: found no k_D for a run folder; expected a wear coefficient; specify --wear-coefficient "
        '"13.5e-9 mm^3/(N*mm)", or process the folder and use the archived run'
    )


def coefficients_by_body(contact: "Contact", texts: Iterable[str]) -> "dict[str, Quantity]":
    """Read k_D by body; without a name, for the next of the bodies that are usually fitted."""
    found: dict[str, Quantity] = {}
    for text in texts:
        name, equals, value = text.rpartition("=")
        body = name.strip() if equals else next((one for one in contact.fitted_bodies if one not in found), None)
        if body not in contact.body_names or body in found:
            what = "too many values" if not equals else f"two values for the {body}" if body in found else repr(name)
            raise typer.BadParameter(
                f"--wear-coefficient: found {what}; expected one value for the "
                f"{' and one for the '.join(contact.body_names)}, such as "
                f'{contact.body_names[0]}="13.5e-9 mm^3/(N*mm)"'
            )
        found[body] = quantity("--wear-coefficient", value, "wear coefficient")
    return found


def folder_subject(folder: Path, given: Given) -> Subject:
    """Read a run folder, and its signals only if friction must be fitted."""
    from tribopipe.documents.manifest import manifest_path, read_manifest

    manifest, _ = read_manifest(manifest_path(folder))

    def known() -> "FrictionPath | StatedFriction | None":
        stated = manifest.conditions.friction
        return stated or (None if given.eq_7 else _recorded_friction(folder, given.recipe))

    return Subject(manifest, manifest.planned, _friction(given, known))


def archived_subject(store: "Archive", run_id: str, given: Given) -> Subject:
    """Return an archived run, with its own fit unless k_D is given. Raises ``FitError`` if it has no fitted k_D."""
    from tribopipe.archive.step_names import WEAR_FITS
    from tribopipe.evaluation.load_and_friction import fitted_path, run_path
    from tribopipe.physics.laws import law_title
    from tribopipe.pipeline.archived_results import archived_friction
    from tribopipe.results.wear_fit import WearFit

    run, fit = store.cleaned(run_id), None
    if not given.has_coefficient:
        fit = store.result(run_id, WEAR_FITS[given.law], WearFit)
        if fit is None:
            raise FitError(
                f"{run_id}: found no k_D under {law_title(given.law)}; expected a fitted k_D; run `tribopipe fit "
                f"{run_id} --law {given.law}`, or specify k_D with --wear-coefficient"
            )
        if fit.outcome == "not fitted":
            raise FitError(
                f"{run_id}: found no k_D (missing: {' and '.join(fit.missing)}); expected a fitted k_D; specify k_D "
                "with --wear-coefficient"
            )

    def known() -> "FrictionPath | None":
        fitted = archived_friction(store, run_id)
        return fitted_path(fitted) if given.eq_7 else run_path(run, fitted, given.recipe.wear.friction)

    return Subject(run.manifest, run.end, _friction(given, known), fit)


def _friction(
    given: Given, known: "Callable[[], FrictionPath | StatedFriction | None]"
) -> "FrictionPath | StatedFriction | None":
    from tribopipe.physics.laws import law_named

    stated = None if given.friction is None else friction_path(given.friction)
    return stated or known() if law_named(given.law).needs_friction else None


def _recorded_friction(folder: Path, recipe: "Recipe") -> "FrictionPath | None":
    from tribopipe.evaluation.friction import fit_friction
    from tribopipe.evaluation.load_and_friction import run_path
    from tribopipe.evaluation.preprocessing.cleaning import clean_run
    from tribopipe.readers.harmonize import read_run

    read = clean_run(read_run(folder), recipe).run
    return run_path(read, fit_friction(read, recipe.friction, recipe.uncertainty), recipe.wear.friction)

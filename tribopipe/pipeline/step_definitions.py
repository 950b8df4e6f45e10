"""Definition of each step of an archived run: its options, its inputs and its computation.

Nothing is written here. A planned step reads what it stands on from the archive when it is taken.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from typing import Any

import numpy as np

from tribopipe.archive.local_wear_tables import local_wear_tables
from tribopipe.archive.provenance import digest, environment
from tribopipe.archive.step_names import (
    LOCAL_WEAR,
    PREDICTIONS,
    WEAR_FITS,
    Step,
    StepName,
    Table,
    inputs_digest,
    method_number,
)
from tribopipe.archive.store import Archive
from tribopipe.base.arrays import Column
from tribopipe.base.errors import TribopipeError
from tribopipe.documents.contact import Contact
from tribopipe.documents.contact_kinds import body_like
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.documents.record import Record, read_document
from tribopipe.documents.signals import SIGNALS
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.friction import fit_friction
from tribopipe.evaluation.load_and_friction import fitted_path, run_path
from tribopipe.evaluation.measurements.specific_wear import specific_wear
from tribopipe.evaluation.preprocessing.cleaning import clean_run
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.evaluation.wear.inputs import distance_inputs
from tribopipe.evaluation.wear.local import LocalOptions, default_places, local_scenario, wear_locally
from tribopipe.evaluation.wear.prediction import fitted_curves, predict_wear, predicted_curves, run_scenario
from tribopipe.evaluation.wear.problem import depths_by_signal
from tribopipe.evaluation.wear.scenario import KnownWear
from tribopipe.physics.laws import law_package
from tribopipe.pipeline.archived_results import archived_coefficients, archived_correction, archived_friction
from tribopipe.results.local_wear import LocalWearResult
from tribopipe.results.wear_fit import WearFit
from tribopipe.results.wear_prediction import WearCurves
from tribopipe.version import VERSION

Curves = Mapping[str, tuple[Column, str]]
_APART = 0.01
"""Relative difference of the final wear depths above which a k_D from the GIWM is reported with a note."""


@dataclass(frozen=True)
class Found:
    """Result of a step with its curves and tables."""

    result: Record
    curves: Curves = field(default_factory=dict)
    """Over the samples of the run."""
    tables: Mapping[str, Table] = field(default_factory=dict)
    """Over other axes."""


@dataclass(frozen=True)
class PlannedStep:
    """A step of a run, ready to be taken."""

    run_id: str
    name: StepName
    options: Mapping[str, Any]
    """What it is given, as JSON types."""
    stands_on: Mapping[str, str]
    """What it is made from, each with its SHA-256, as a ``Step`` has it."""
    compute: Callable[[], Found]

    @property
    def inputs_sha256(self) -> str:
        """Fingerprint of all it is made from."""
        return inputs_digest(VERSION, self.name, self.options, self.stands_on)

    def take(self) -> Step:
        """Run the step. Raises ``TribopipeError``, with the name of the run, if it fails."""
        try:
            found = self.compute()
        except TribopipeError as error:
            raise error if self.run_id in str(error) else type(error)(f"{self.run_id}: {error}") from None
        return Step(
            name=self.name,
            inputs_sha256=self.inputs_sha256,
            options=self.options,
            program_version=VERSION,
            date=datetime.now(UTC).isoformat(timespec="seconds"),
            stands_on=self.stands_on,
            environment=environment(),
            **vars(found),
        )


def _planned(
    archive: Archive,
    run_id: str,
    name: StepName,
    options: Mapping[str, Any],
    compute: Callable[[], Found],
    **told: str,
) -> PlannedStep:
    """Plan a step that stands on the raw run, on the steps before it, and on fingerprints of what else it is given."""
    by_method = {**options, "method": method_number(name)}
    return PlannedStep(run_id, name, by_method, archive.stands_on(run_id, name) | told, compute)


def clean_up(archive: Archive, run_id: str, recipe: Recipe) -> PlannedStep:
    """Plan to preprocess signals; its curves are those that came out changed."""

    def compute() -> Found:
        found = clean_run(archive.raw(run_id), recipe)
        return Found(found.record, {name: (values, SIGNALS[name].unit) for name, values in found.columns.items()})

    return _planned(archive, run_id, "clean_up", {"clean_up": [_told(step) for step in recipe.clean_up]}, compute)


def drift_correction(archive: Archive, run_id: str, recipe: Recipe) -> PlannedStep:
    """Plan to correct the drift of the depth signal."""

    def compute() -> Found:
        corrected = correct_drift(archive.cleaned(run_id), recipe)
        curves = {name: getattr(corrected, name) for name in ("wear_depth", "pin_wear_depth", "wander")}
        return Found(corrected.correction, {name: (curve, "m") for name, curve in curves.items() if curve is not None})

    options = {
        "drift": _told(recipe.drift),
        "uncertainty": _told(recipe.uncertainty),
        "wear": {"correction": recipe.wear.correction},
    }
    return _planned(archive, run_id, "drift_correction", options | _convention(archive, run_id, recipe), compute)


def friction_fit(archive: Archive, run_id: str, recipe: Recipe) -> PlannedStep:
    """Plan to fit the friction coefficient."""

    def compute() -> Found:
        run = archive.cleaned(run_id)
        fit = fit_friction(run, recipe.friction, recipe.uncertainty)
        path = fitted_path(fit)
        curves = {} if path is None else {"friction_coefficient": (path.coefficient(run.sliding_distance), "1")}
        return Found(fit, curves)

    options = {"friction": _told(recipe.friction), "uncertainty": _told(recipe.uncertainty)}
    return _planned(archive, run_id, "friction_fit", options, compute)


def specific_wear_rates(archive: Archive, run_id: str, recipe: Recipe) -> PlannedStep:
    """Plan to evaluate the specific wear rate of each body by its post-test measurements and the depth signal."""

    def compute() -> Found:
        corrected = archived_correction(archive, run_id)
        return Found(specific_wear(corrected.run, recipe, depths_by_signal(corrected, recipe)))

    return _planned(archive, run_id, "specific_wear", {"uncertainty": _told(recipe.uncertainty)}, compute)


def wear_fit(archive: Archive, run_id: str, recipe: Recipe, law: LawName) -> PlannedStep:
    """Plan to identify k_D under a wear law."""

    def compute() -> Found:
        corrected, friction = archived_correction(archive, run_id), archived_friction(archive, run_id)
        fit = fit_wear(corrected, law, friction, recipe)
        return Found(fit, _curves(fitted_curves(corrected.run, fit, friction, recipe)))

    options = {
        "wear": {
            "engine": recipe.wear.engine,
            "friction": recipe.wear.friction,
            "correction": recipe.wear.correction,
            **_given(recipe, law),
        },
        "drift": _told(recipe.drift),
        "uncertainty": _told(recipe.uncertainty),
        "monte_carlo": _told(recipe.monte_carlo),
        **_by(law),
    }
    return _planned(archive, run_id, WEAR_FITS[law], options | _convention(archive, run_id, recipe), compute)


def _by(law: LawName) -> dict[str, Any]:
    """Return whose a law is, where another package adds it: a later version of that may be different."""
    package = law_package(law)
    return {} if package is None else {"law_package": package}


def _given(recipe: Recipe, law: LawName) -> dict[str, Any]:
    """Return what a step under a law is given in addition: its parameters, where the recipe gives some."""
    given = recipe.wear.parameters.get(law)
    return {"parameters": {law: given}} if given else {}


def _curves(curves: WearCurves | None) -> Curves:
    found: dict[str, tuple[Column, str]] = {}
    for name, band in curves.bands.items() if curves is not None else ():
        lines = {name: band.best, f"{name}_lower": band.lower, f"{name}_upper": band.upper}
        found |= {line: (values, band.unit) for line, values in lines.items()}
    return found


def _convention(archive: Archive, run_id: str, recipe: Recipe) -> dict[str, Any]:
    """Return the extra argument of steps for rolling bodies: the sliding distance counted per rotation."""
    slides = archive.manifest(run_id).slip is None
    return {} if slides else {"distance_per_rotation": recipe.wear.distance_per_rotation}


def prediction(
    archive: Archive, run_id: str, recipe: Recipe, law: LawName, reference: str, known: KnownWear
) -> PlannedStep:
    """Plan to predict a run's wear from the k_D that ``reference`` found, over the run's own distance."""

    def compute() -> Found:
        run, friction = archive.cleaned(run_id), archived_friction(archive, run_id)
        own = {body_like(run.manifest.described, name): value for name, value in known.bodies.items()}
        scenario = run_scenario(run, law, replace(known, bodies=own), friction, recipe)
        # k_D of another run does not make up for an error of this one's distance.
        if reference != run_id:
            scenario = replace(scenario, distance_inputs=distance_inputs(run, recipe))
        # A study, whose runs may have several loads, is no run of the archive.
        is_run = archive.path(reference).is_file()
        load = archive.manifest(reference).conditions.normal_load if is_run else None
        end = [float(np.nanmax(run.progress))]
        result = predict_wear(scenario, end, reference=reference, reference_load=load)
        return Found(result, _curves(predicted_curves(run, scenario, result)))

    options = {
        "reference": reference,
        "wear": {"friction": recipe.wear.friction, **_given(recipe, law)},
        "uncertainty": _told(recipe.uncertainty),
        **_by(law),
    }
    fingerprint = digest(*known.parts)
    return _planned(archive, run_id, PREDICTIONS[law], options, compute, wear_coefficient=fingerprint)


def local_wear(
    archive: Archive,
    run_id: str,
    recipe: Recipe,
    law: LawName,
    how: LocalOptions,
    *,
    coefficients: Mapping[str, Quantity] | None = None,
    at: Sequence[float] = (),
) -> PlannedStep:
    """Plan to wear a run locally to places ``at``, m or rotations, or over its own course.

    k_D of the bodies is what the fit under the law found, unless ``coefficients`` are given by body, as Archard's law
    has them. Raises ``FitError`` where neither is there.
    """
    known = coefficients or archived_coefficients(archive, run_id, law)

    def compute() -> Found:
        run = archive.cleaned(run_id)
        path = run_path(run, archived_friction(archive, run_id), recipe.wear.friction)
        end = float(np.nanmax(run.progress))
        scenario = local_scenario(run.manifest, known, law, path, recipe)
        reference = None if coefficients else run_id
        curves = wear_locally(scenario, at or default_places(end), how, reference=reference)
        fit = None if coefficients else archive.result(run_id, WEAR_FITS[law], Record)
        return Found(curves.result.told(_engine_notes(fit, curves.result)), tables=local_wear_tables(curves))

    options = {
        "local_wear": asdict(how),
        "at": list(at),
        "wear_coefficient": {body: _told(given) for body, given in (coefficients or {}).items()} or [],
        "wear": {"friction": recipe.wear.friction, **_given(recipe, law)},
        "uncertainty": _told(recipe.uncertainty),
        **_by(law),
    }
    return _planned(archive, run_id, LOCAL_WEAR[law], options, compute, wear_coefficient=digest(*known.values()))


def _engine_notes(fit: Record | None, worn: LocalWearResult) -> Iterator[str]:
    """Report for a k_D by the GIWM that local wear has another, where the two depths differ."""
    apart = worn.points[-1].difference
    if isinstance(fit, WearFit) and fit.engine == "giwm" and apart is not None and abs(apart) > _APART:
        yield (
            f"k_D was identified with the GIWM, whose wear depth differs here from that of the local-wear model by "
            f"{100 * abs(apart):.1f} %; to identify k_D with local wear, run `tribopipe fit --engine local`"
        )


def _told(record: Record) -> dict[str, Any]:
    """Return a record as a step is given it, in JSON types."""
    return record.model_dump(mode="json")


PLANS: Mapping[StepName, Callable[[Archive, str, Recipe], PlannedStep]] = {
    "clean_up": clean_up,
    "drift_correction": drift_correction,
    "friction_fit": friction_fit,
    "specific_wear": specific_wear_rates,
}
"""Steps that a recipe defines completely, in the order in which they are taken; fits come after these."""


def planned(archive: Archive, run_id: str, name: StepName, recipe: Recipe) -> PlannedStep:
    """Plan a step that a recipe defines completely, but for the law of a fit."""
    law = WEAR_FITS.law_of(name)
    return PLANS[name](archive, run_id, recipe) if law is None else wear_fit(archive, run_id, recipe, law)


def recipe_of(options: Mapping[str, Any]) -> Recipe:
    """Return the recipe of a step; what the step was not given has its default."""
    document = {name: options[name] for name in Recipe.model_fields if name in options}
    if "distance_per_rotation" in options:
        document["wear"] = {**document.get("wear", {}), "distance_per_rotation": options["distance_per_rotation"]}
    return read_document(document, Recipe, where="options")


def _by_body(contact: Contact, given: Any) -> dict[str, Quantity]:
    """Return k_D as a step was given it: by body, or in the order of the bodies by earlier versions."""
    named = given if isinstance(given, Mapping) else dict(zip(contact.fitted_bodies, given, strict=False))
    return {body: Quantity.model_validate(one) for body, one in named.items()}


def local_wear_as_told(archive: Archive, run_id: str, law: LawName, options: Mapping[str, Any]) -> PlannedStep:
    """Plan local wear by the options of an archived one."""
    return local_wear(
        archive,
        run_id,
        recipe_of(options),
        law,
        LocalOptions(**options["local_wear"]),
        coefficients=_by_body(archive.manifest(run_id).described, options["wear_coefficient"]),
        at=options["at"],
    )

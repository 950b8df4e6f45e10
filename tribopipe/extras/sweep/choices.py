"""k_D of archived runs in every way of evaluating it. Nothing in the archive changes."""

from collections.abc import Iterator
from functools import partial
from pathlib import Path

from tribopipe.archive.provenance import digest
from tribopipe.archive.store import Archive
from tribopipe.base.errors import ArchiveError
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.documents.record import Record
from tribopipe.documents.sweep import Choices, Sweep
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.friction import fit_friction
from tribopipe.evaluation.preprocessing.cleaning import clean_run
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.extras.sweep.cases import Case, Ensemble, Head, Row, combinations, label_heads, refuse_endless
from tribopipe.extras.sweep.subject import Subject, parameters
from tribopipe.results.run import RawRun
from tribopipe.results.wear_fit import BodyWear, WearFit
from tribopipe.version import VERSION

COEFFICIENT = Head("wear_coefficient", "m^2/N", uncertain=True)
FIT_NUMBERS = (
    COEFFICIENT,
    Head("interval_lower", "m^2/N"),
    Head("interval_upper", "m^2/N"),
    Head("end_wear_depth", "m", uncertain=True),
)
"""Columns of a fit in the table."""


class Choice(Record):
    """One way of evaluating a run."""

    recipe: Recipe
    """Recipe."""
    law: LawName = "archard"
    """Wear law."""


def choices(sweep: Sweep, asked: Choices, archive: Archive, recipe: Recipe, where: str) -> Ensemble:
    """Return the cases of every run in every way, runs after another.

    Raises ``ManifestError`` where a key or value is wrong, ``ArchiveError`` where a run is not there.
    """
    base = Choice(recipe=recipe).model_dump(mode="json", by_alias=True)
    subject = Subject(Choice, base, where)
    varied, runs = parameters(sweep.vary, subject), asked.runs or tuple(archive.ids())
    if not runs:
        raise ArchiveError(f"{archive.folder}: found no runs; expected at least one; run `tribopipe ingest` first")
    repeats = sweep.repeats or 1
    refuse_endless(varied, repeats * len(runs), where)
    cases = []
    for run_id in runs:
        raw = archive.raw_sha256(run_id)
        for one in combinations(varied, repeats, sweep.seed):
            choice = subject.changed(one.settings)
            fingerprint = digest(VERSION, raw, choice)[:16]
            cases.append(Case(one.labels(run_id), fingerprint, partial(evaluated, archive.folder, run_id, choice)))
    return Ensemble(label_heads(varied, sweep.repeats), FIT_NUMBERS, cases)


def evaluated(folder: Path, run_id: str, choice: Choice) -> list[Row]:
    """Evaluate an archived run in one way. Raises ``TribopipeError`` where that cannot be done."""
    return list(fit_rows(fitted(Archive(folder).raw(run_id), choice)))


def fitted(run: RawRun, choice: Choice) -> WearFit:
    """Take a run through the whole line in memory. Raises ``FitError`` where nothing is to be found."""
    recipe = choice.recipe
    cleaned = clean_run(run, recipe).run
    friction = fit_friction(cleaned, recipe.friction, recipe.uncertainty)
    return fit_wear(correct_drift(cleaned, recipe), choice.law, friction, recipe)


def fit_rows(fit: WearFit) -> Iterator[Row]:
    """Give a row for each body that a k_D was sought of."""
    if fit.outcome == "not fitted":
        yield Row("", fit.outcome, {}, f"missing: {' and '.join(fit.missing)}")
    for name, body in fit.bodies.items():
        yield Row(spoken(name), fit.outcome, _kept(body))


def _kept(body: BodyWear) -> dict[str, Quantity]:
    values = (body.wear_coefficient, *body.interval, body.fitted_end_depth)
    return {head.name: value for head, value in zip(FIT_NUMBERS, values, strict=True) if value is not None}

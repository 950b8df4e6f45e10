"""One archived run on less than a screen: what was tested, what was found, and what speaks against it."""

from collections.abc import Iterator
from contextlib import suppress
from typing import TYPE_CHECKING

from tribopipe.archive.steps import PREDICTIONS
from tribopipe.base.errors import ArchiveError
from tribopipe.base.units import SPECIFIC_WEAR_RATE, WEAR_COEFFICIENT
from tribopipe.cli.output import print_result
from tribopipe.cli.pages import heading, paragraph, show_facts, show_head
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.preprocessing import CleanUp
from tribopipe.documents.quantity import between
from tribopipe.physics.laws import law_heading, law_title
from tribopipe.results.agreement import AGREEMENT
from tribopipe.results.evaluation import DriftCorrection, FrictionFit
from tribopipe.results.finding_titles import title
from tribopipe.results.specific_wear import SpecificWear
from tribopipe.results.wear_fit import WearFit, by, fits_of
from tribopipe.results.wear_prediction import WearPrediction
from tribopipe.views.page import Fact, RunPage
from tribopipe.views.run_page import run_page

if TYPE_CHECKING:
    from tribopipe.archive.outline import RunOutline
    from tribopipe.archive.store import Archive
    from tribopipe.documents.preprocessing import CleanUp
from tribopipe.documents.quantity import Quantity

_OF_BODIES = ("material", "shape", "radius", "radius of the flat", "crown radius", "diameter")
"""What is stated about a body; of its radius and diameter the first one."""
_WARNINGS, _REMARKS = 4, 2
"""As many findings and remarks are named."""


def show_run_overview(store: "Archive", run_id: str) -> None:
    """Show a run to people in short."""
    page, outline = run_page(store, run_id), store.outline(run_id)
    show_head(page)
    tested, found = list(_tested(page, outline)), list(_found(store, outline))
    width = max((len(fact.name) for fact in (*tested, *found)), default=0)
    print_result("")
    show_facts(tested, width)
    if found:
        heading("Results", "(± is one standard uncertainty)")
        show_facts(found, width)
    _show_warnings(page)
    print_result(f"\n{store.path(run_id)}")
    print_result(f"All details: `tribopipe show {run_id} -v`")


def _tested(page: RunPage, outline: "RunOutline") -> Iterator[Fact]:
    groups = {group.title: group.facts for group in page.facts}
    for name in outline.manifest.bodies:
        facts = {fact.name: fact.value for fact in groups.get(spoken(name).capitalize(), ())}
        words = [facts[one] if one in _OF_BODIES[:2] else f"{one} {facts[one]}" for one in _OF_BODIES if one in facts]
        yield Fact(spoken(name), ", ".join(words[:3]))
    for group in ("Conditions", "Recorded", "Post-test measurements"):
        if groups.get(group):
            yield Fact(group.lower(), "; ".join(f"{fact.name} {fact.value}" for fact in groups[group]))
    cleaned = next((step.result for name, step in outline.steps.items() if name == "clean_up"), None)
    if isinstance(cleaned, CleanUp) and cleaned.changes:
        yield Fact("preprocessing", ", ".join(dict.fromkeys(change.step for change in cleaned.changes)))
    for remark in page.remarks[-_REMARKS:]:
        yield Fact(remark.kind, f"{remark.text} ({remark.date[:10]})")
    if page.studies:
        yield Fact("studies", ", ".join(page.studies))


def _found(store: "Archive", outline: "RunOutline") -> Iterator[Fact]:
    results = {name: step.result for name, step in outline.steps.items()}
    friction, drift, wear = (results.get(name) for name in ("friction_fit", "drift_correction", "specific_wear"))
    if isinstance(friction, FrictionFit):
        yield from _of_friction(friction)
    if isinstance(drift, DriftCorrection) and drift.drift_rate is not None:
        yield Fact("drift", drift.drift_rate.shown("nm/min"))
    if isinstance(wear, SpecificWear):
        yield from _of_wear(wear, outline)
    for fit in fits_of(results.values()):
        yield from _of_fit(fit, outline)
        predicted = results.get(PREDICTIONS[fit.model])
        if isinstance(predicted, WearPrediction):
            yield from _of_prediction(predicted, outline)
    yield from _of_studies(store, outline)


def _of_friction(friction: FrictionFit) -> Iterator[Fact]:
    if friction.steady_state is not None:
        yield Fact("steady-state μ", str(friction.steady_state))
    if friction.mean is not None:
        yield Fact("mean μ", str(friction.mean))
    if friction.running_in_distance is not None:
        yield Fact("running-in distance c", friction.running_in_distance.shown("m"))


def _of_wear(wear: SpecificWear, outline: "RunOutline") -> Iterator[Fact]:
    for name, body in wear.bodies.items():
        told = (
            _shown(body.volume, "mm^3"),
            f"{body.depth.shown('um')} deep" if body.depth else "",
            _shown(body.specific_wear_rate, SPECIFIC_WEAR_RATE),
        )
        if any(told):
            yield Fact(outline.manifest.worded(f"wear of the {spoken(name)}"), "; ".join(filter(None, told)))


def _shown(quantity: "Quantity | None", unit: str) -> str:
    return "" if quantity is None else quantity.shown(unit)


def _of_fit(fit: WearFit, outline: "RunOutline") -> Iterator[Fact]:
    counted = "" if fit.distance_per_rotation is None else f", {fit.distance_per_rotation}"
    law = f"by {law_title(fit.model)}{by(fit.engine)}{counted}"
    for name, body in fit.bodies.items():
        of = outline.manifest.worded(f"k_D of the {spoken(name)}")
        yield Fact(of, f"{body.wear_coefficient.shown(WEAR_COEFFICIENT)}, {law}")
        yield Fact("  95 % CI", between(body.interval, WEAR_COEFFICIENT))
    if fit.parameters:
        yield Fact("  parameters", ", ".join(map(str, fit.parameters)))
    if not fit.bodies and fit.lacks:
        yield Fact("k_D", f"not found {law}: {' and '.join(fit.lacks)} missing")


"""State once with what else the steps were computed when they were archived."""


def _of_prediction(predicted: WearPrediction, outline: "RunOutline") -> Iterator[Fact]:
    end = predicted.prediction[0]
    bodies = "; ".join(f"{outline.manifest.worded(spoken(name))} {body}" for name, body in end.bodies.items())
    source = f" from {predicted.reference}" if predicted.reference else ""
    yield Fact("  predicted wear", f"{bodies}{source}")


def _of_studies(store: "Archive", outline: "RunOutline") -> Iterator[Fact]:
    """Give how the run agrees with each law of each study; a damaged study is passed over."""
    run_id = outline.manifest.id
    for study_id in store.studies_of(run_id):
        with suppress(ArchiveError):
            laws = store.study_outline(study_id).result.laws
            words = [
                f"{AGREEMENT[one.outcome]} with {law_heading(law.model)} ({one.role})"
                for law in laws
                for one in law.runs
                if one.id == run_id
            ]
            if words:
                yield Fact("agreement", f"{'; '.join(words)}: study {study_id}")


def _show_warnings(page: RunPage) -> None:
    """Name what speaks against the run; each is given in full with -v."""
    named = [f"{one.severity}: {one.where}: {title(one.code)}" for one in page.findings if one.severity != "note"]
    notes = len(page.findings) - len(named)
    if notes:
        named.append(f"{notes} note{'' if notes == 1 else 's'}")
    if not named:
        return
    heading("Findings")
    shown = named if len(named) <= _WARNINGS else named[: _WARNINGS - 1]
    for line in shown:
        paragraph(line)
    if len(shown) < len(named):
        paragraph(f"and {len(named) - len(shown)} more")

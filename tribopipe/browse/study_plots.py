"""Plots of a study: every run under a law together and by itself, and k_D against friction."""

from collections.abc import Callable, Iterator, Sequence

from tribopipe.base.arrays import Column
from tribopipe.base.units import axis
from tribopipe.browse.drawing import MICRONS, VOLUME, Curve, Mark, Panel, Role, Unit, mark
from tribopipe.browse.local_plots import COEFFICIENT_LABEL, law_curves, measured_curve
from tribopipe.browse.plots import PlotOffer, coefficient_offer
from tribopipe.browse.samples import StudyFile
from tribopipe.documents.contact import DISCS, DiscName
from tribopipe.evaluation.study.effective import EffectiveCoefficient, effective_coefficient
from tribopipe.evaluation.study.member import Member
from tribopipe.physics.laws import law_label, law_title
from tribopipe.pipeline.archived_results import archived_correction, archived_friction
from tribopipe.pipeline.step_definitions import recipe_of
from tribopipe.results.agreement import LawResult, StudyResult
from tribopipe.results.disc_agreement import TwinDiscLawResult, TwinDiscStudyResult
from tribopipe.results.study_curves import DiscStudyCurve, StudyCurve
from tribopipe.results.wear_fit import spoken

_STAGE = "study"


def study_plots(study: StudyFile) -> list[PlotOffer]:
    """Return the plots of a study, all runs under its first law first."""
    result = study.stored.result
    if isinstance(result, TwinDiscStudyResult):
        return [*_together(study, _disc_panels), *_each(study, _disc_panels)]
    return [*_together(study, _pin_panels), *_coefficient(study, result), *_each(study, _pin_panels)]


Panels = Callable[[StudyFile, str, Sequence[str]], tuple[Panel, ...]]
"""Draws some runs under a law."""


def _together(study: StudyFile, panels: Panels) -> Iterator[PlotOffer]:
    for law in study.stored.result.laws:
        runs = [run.id for run in law.runs]
        yield _offer(study, f"wear-{law.model}", f"Wear by {law_title(law.model)}", panels, law, runs)


def _each(study: StudyFile, panels: Panels) -> Iterator[PlotOffer]:
    for law in study.stored.result.laws:
        for run in law.runs:
            title = f"{run.id}: {run.role} by {law_title(law.model)}"
            yield _offer(study, f"wear-{law.model}-{run.id}", title, panels, law, [run.id])


def _offer(
    study: StudyFile, name: str, title: str, panels: Panels, law: LawResult | TwinDiscLawResult, runs: list[str]
) -> PlotOffer:
    along = "rotations" if isinstance(law, TwinDiscLawResult) else "sliding_distance"
    path = _path(study, law.model, runs)
    return PlotOffer(name, title, _STAGE, path, (along,), lambda _: panels(study, law.model, runs))


def _path(study: StudyFile, law: str, runs: Sequence[str]) -> str:
    """Return the first curve that is drawn."""
    numbered = enumerate(study.stored.curves)
    found = (number for number, curve in numbered if curve.model == law and curve.run_id in runs)
    return f"/entry/curve_{next(found, 0):03}"


def _pin_panels(study: StudyFile, law: str, runs: Sequence[str]) -> tuple[Panel, ...]:
    curves: list[Curve] = []
    for number, curve in enumerate(study.stored.curves):
        if isinstance(curve, StudyCurve) and curve.model == law and curve.run_id in runs:
            curves += _pin_curves(curve, f"/entry/curve_{number:03}")
    return (Panel(axis("pin wear depth", "um"), tuple(curves)),)


def _pin_curves(curve: StudyCurve, path: str) -> Iterator[Curve]:
    x, run, low, high = curve.sliding_distance, curve.run_id, curve.measurement_lower, curve.measurement_upper
    yield Curve(f"{run}, measured", "measured", x, curve.measured, MICRONS, run, None, low, high, f"{path}/measured")
    yield _law_curve(curve, x, MICRONS, f"{path}/predicted")


def _law_curve(curve: StudyCurve | DiscStudyCurve, x: Column, unit: Unit, path: str) -> Curve:
    """Draw what a law says of a run, with its 95 % band."""
    role: Role = "fit" if curve.role == "fitted" else "prediction"
    name = f"{curve.run_id}, {law_label(curve.model)}, {curve.role}"
    return Curve(name, role, x, curve.predicted, unit, curve.run_id, curve.model, curve.lower, curve.upper, path)


def _disc_panels(study: StudyFile, law: str, runs: Sequence[str]) -> tuple[Panel, ...]:
    return tuple(_disc_panel(study, law, runs, disc) for disc in DISCS)


def _disc_panel(study: StudyFile, law: str, runs: Sequence[str], disc: DiscName) -> Panel:
    curves = []
    for number, curve in enumerate(study.stored.curves):
        if isinstance(curve, DiscStudyCurve) and (curve.model, curve.disc) == (law, disc) and curve.run_id in runs:
            curves.append(_law_curve(curve, curve.rotations, VOLUME, f"/entry/curve_{number:03}/predicted"))
    marks = tuple(_disc_marks(study, law, runs, disc))
    return Panel(axis(f"{spoken(disc)}, volume worn off", "mm^3"), tuple(curves), marks)


def _disc_marks(study: StudyFile, law: str, runs: Sequence[str], disc: DiscName) -> Iterator[Mark]:
    result = study.stored.result
    judged = [
        one
        for found in result.laws
        if isinstance(found, TwinDiscLawResult) and found.model == law
        for one in found.runs
    ]
    for run in judged:
        for one in run.discs:
            if run.id in runs and one.disc == disc and one.what == "wear_volume":
                yield from mark(f"{run.id}, measured", run.id, run.rotations.value, one.measured, VOLUME)


def _coefficient(study: StudyFile, result: StudyResult) -> Iterator[PlotOffer]:
    if any(law.model == "sarkar" for law in result.laws):
        path = _path(study, "sarkar", [run.id for run in result.laws[0].runs])
        yield coefficient_offer(_STAGE, path, lambda _: _draw_coefficient(study, result))


def _draw_coefficient(study: StudyFile, result: StudyResult) -> tuple[Panel, ...]:
    runs = [run.id for run in result.laws[0].runs]
    measured = study.keep("effective k_D", lambda: _effective(study, runs))
    curves = [measured_curve(one) for one in measured]
    for law in result.laws:
        curves += law_curves(measured, law.model, law.wear_coefficient, law.interval)
    return (Panel(COEFFICIENT_LABEL, tuple(curves)),)


def _effective(study: StudyFile, runs: Sequence[str]) -> list[EffectiveCoefficient]:
    recipe = recipe_of(study.stored.options)
    members = [Member(archived_correction(study.archive, run), archived_friction(study.archive, run)) for run in runs]
    found = [effective_coefficient(member.pose("sarkar", recipe), recipe.monte_carlo.seed) for member in members]
    return [one for one in found if one is not None]

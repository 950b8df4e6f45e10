"""Plots of a study: every run under a law together and by itself, and k_D against friction."""

from collections.abc import Iterator, Mapping, Sequence

from tribopipe.browse.plots import PlotOffer, coefficient_offer
from tribopipe.browse.samples import StudyFile
from tribopipe.evaluation.study.effective import EffectiveCoefficient, effective_coefficient
from tribopipe.evaluation.study.member import Member
from tribopipe.physics.laws import law_label, law_title
from tribopipe.pipeline.archived_results import archived_correction, archived_friction
from tribopipe.pipeline.step_definitions import recipe_of
from tribopipe.results.agreement import LawResult, StudyResult
from tribopipe.results.study_curves import CurveQuantity, StudyCurve
from tribopipe.results.wear_fit import spoken
from tribopipe.views.coefficient_plot import LawCoefficient, coefficient_panel
from tribopipe.views.plot import MICRONS, VOLUME, Curve, Mark, Panel, Role, Unit, mark

_STAGE = "study"
_UNITS: Mapping[CurveQuantity, Unit] = {"wear_depth": MICRONS, "wear_volume": VOLUME}


def study_plots(study: StudyFile) -> list[PlotOffer]:
    """Return the plots of a study, all runs under its first law first."""
    result = study.stored.result
    return [*_together(study), *_coefficient(study, result), *_each(study)]


def _together(study: StudyFile) -> Iterator[PlotOffer]:
    for law in study.stored.result.laws:
        runs = [run.id for run in law.runs]
        yield _offer(study, f"wear-{law.model}", f"Wear by {law_title(law.model)}", law, runs)


def _each(study: StudyFile) -> Iterator[PlotOffer]:
    for law in study.stored.result.laws:
        for run in law.runs:
            title = f"{run.id}: {run.role} by {law_title(law.model)}"
            yield _offer(study, f"wear-{law.model}-{run.id}", title, law, [run.id])


def _offer(study: StudyFile, name: str, title: str, law: LawResult, runs: list[str]) -> PlotOffer:
    along = next(curve.along for curve in study.stored.curves)
    path = _path(study, law.model, runs)
    return PlotOffer(name, title, _STAGE, path, (along,), lambda _: _panels(study, law, runs))


def _path(study: StudyFile, law: str, runs: Sequence[str]) -> str:
    """Return the first curve that is drawn."""
    numbered = enumerate(study.stored.curves)
    found = (number for number, curve in numbered if curve.model == law and curve.run_id in runs)
    return f"/entry/curve_{next(found, 0):03}"


def _panels(study: StudyFile, law: LawResult, runs: Sequence[str]) -> tuple[Panel, ...]:
    """Draw some runs under a law: a panel for each body."""
    bodies = dict.fromkeys(curve.body for curve in study.stored.curves if curve.model == law.model)
    return tuple(_panel(study, law, runs, body) for body in bodies)


def _panel(study: StudyFile, law: LawResult, runs: Sequence[str], body: str) -> Panel:
    shown = {
        f"/entry/curve_{number:03}": curve
        for number, curve in enumerate(study.stored.curves)
        if (curve.model, curve.body) == (law.model, body) and curve.run_id in runs
    }
    lines = tuple(line for path, curve in shown.items() for line in _lines(curve, path))
    (what,) = {curve.what for curve in study.stored.curves if curve.body == body}
    recorded = any(curve.measured is not None for curve in shown.values())
    marks = () if recorded else tuple(_marks(law, runs, body, what))
    return Panel(spoken(what), _UNITS[what], lines, marks, spoken(body))


def _lines(curve: StudyCurve, path: str) -> Iterator[Curve]:
    """Draw what was measured along a run, where it was, and what a law says of it, with 95 % bands."""
    x, run, unit = curve.places, curve.run_id, _UNITS[curve.what]
    if (found := curve.measured) is not None:
        name = f"{run}, measured"
        yield Curve(name, "measured", x, found.best, unit, run, None, found.lower, found.upper, f"{path}/measured")
    role: Role = "fit" if curve.role == "fitted" else "prediction"
    name, path = f"{run}, {law_label(curve.model)}, {curve.role}", f"{path}/predicted"
    yield Curve(name, role, x, curve.predicted, unit, run, curve.model, curve.lower, curve.upper, path)


def _marks(law: LawResult, runs: Sequence[str], body: str, what: CurveQuantity) -> Iterator[Mark]:
    """Draw what was measured on a body at the end of runs."""
    for run in law.runs:
        one = run.bodies.get(body)
        if run.id in runs and one is not None and one.what == what:
            yield from mark(f"{run.id}, measured", run.id, run.end.value, one.measured, _UNITS[what])


def _coefficient(study: StudyFile, result: StudyResult) -> Iterator[PlotOffer]:
    if any(curve.model == "sarkar" and curve.measured is not None for curve in study.stored.curves):
        path = _path(study, "sarkar", [run.id for run in result.laws[0].runs])
        yield coefficient_offer(_STAGE, path, lambda _: _draw_coefficient(study, result))


def _draw_coefficient(study: StudyFile, result: StudyResult) -> tuple[Panel, ...]:
    runs = [run.id for run in result.laws[0].runs]
    measured = study.keep("effective k_D", lambda: _effective(study, runs))
    laws = (LawCoefficient(law.model, law.first.wear_coefficient, law.first.interval) for law in result.laws)
    return (coefficient_panel(measured, laws),)


def _effective(study: StudyFile, runs: Sequence[str]) -> list[EffectiveCoefficient]:
    recipe = recipe_of(study.stored.options)
    members = [Member(archived_correction(study.archive, run), archived_friction(study.archive, run)) for run in runs]
    found = [effective_coefficient(member.pose("sarkar", recipe), recipe.monte_carlo.seed) for member in members]
    return [one for one in found if one is not None]

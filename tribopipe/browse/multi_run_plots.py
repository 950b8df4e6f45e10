"""Plots of several runs: one plot of each on one axis, and the plots of a study."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace

from starlette.exceptions import HTTPException

from tribopipe.browse.file_cache import RunFile, StudyFile
from tribopipe.browse.plots import PlotOffer, coefficient_offer, run_plots
from tribopipe.evaluation.study.k_d_along_test import EffectiveCoefficient, effective_coefficient
from tribopipe.physics.laws import law_title
from tribopipe.pipeline.archived_results import archived_member
from tribopipe.pipeline.step_definitions import recipe_of
from tribopipe.results.study import LawResult
from tribopipe.views.plot import Panel, Plot, axis_label
from tribopipe.views.study_plots import LawCoefficient, coefficient_panel, study_panels

COMPARED = {"wear": "Wear", "friction": "Friction", "depth": "Depth signal"}
"""What can be compared, with its title."""


def compare(what: str, runs: Sequence[RunFile], extra: Collection[str], against: str | None) -> Plot:
    """Draw one plot of several runs; of laws those that are asked for: "fit", "prediction".

    Panels of one label become one. Raises ``HTTPException`` where none of the runs has such a plot, or they share no
    axis.
    """
    offers = [offer for run in runs for offer in run_plots(run) if offer.name == what]
    if not offers:
        raise HTTPException(
            404, f"found no {what} in these runs; expected at least one run with this plot; choose other runs"
        )
    axes = [name for name in offers[0].axes if all(name in offer.axes for offer in offers)]
    chosen = against if against in axes else axes[0]
    wanted = {"measured", *extra}
    panels: dict[str, Panel] = {}
    for offer in offers:
        for panel in offer.drawing(chosen).panels:
            kept = tuple(curve for curve in panel.curves if curve.role in wanted)
            there = panels.get(panel.label, replace(panel, curves=(), marks=()))
            if kept or panel.marks:
                curves, marks = (*there.curves, *kept), (*there.marks, *panel.marks)
                panels[panel.label] = replace(there, curves=curves, marks=marks)
    return Plot(COMPARED[what], "", chosen, axis_label(chosen), tuple(panels.values()))


_STAGE = "study"


def study_plots(study: StudyFile) -> list[PlotOffer]:
    """Return the plots of a study, all runs under its first law first."""
    return [*_together(study), *_coefficient(study), *_each(study)]


def _together(study: StudyFile) -> Iterator[PlotOffer]:
    for law in study.stored.result.laws:
        runs = [run.id for run in law.runs]
        yield _offer(study, f"wear-{law.model}", f"Wear ({law_title(law.model)})", law, runs)


def _each(study: StudyFile) -> Iterator[PlotOffer]:
    for law in study.stored.result.laws:
        for run in law.runs:
            title = f"{run.id}: {run.role}, {law_title(law.model)}"
            yield _offer(study, f"wear-{law.model}-{run.id}", title, law, [run.id])


def _offer(study: StudyFile, name: str, title: str, law: LawResult, runs: list[str]) -> PlotOffer:
    curves = study.stored.curves
    found = (number for number, curve in enumerate(curves) if curve.model == law.model and curve.run_id in runs)
    path = f"/entry/curve_{next(found, 0):03}"
    return PlotOffer(
        name, title, _STAGE, path, (curves[0].along,), lambda _: tuple(study_panels(law, study.stored.curves, runs))
    )


def _coefficient(study: StudyFile) -> Iterator[PlotOffer]:
    found = (
        number
        for number, curve in enumerate(study.stored.curves)
        if curve.model == "sarkar" and curve.measured is not None
    )
    for number in list(found)[:1]:
        yield coefficient_offer(_STAGE, f"/entry/curve_{number:03}", lambda _: _draw_coefficient(study))


def _draw_coefficient(study: StudyFile) -> tuple[Panel, ...]:
    result = study.stored.result
    measured = study.keep("effective k_D", lambda: _effective(study, [run.id for run in result.laws[0].runs]))
    laws = (LawCoefficient(law.model, law.first.wear_coefficient, law.first.interval) for law in result.laws)
    return (coefficient_panel(measured, laws),)


def _effective(study: StudyFile, runs: list[str]) -> list[EffectiveCoefficient]:
    recipe = recipe_of(study.stored.options)
    members = [archived_member(study.archive, run) for run in runs]
    posed = [member.pose("sarkar", recipe) for member in members if member.has_curve]
    found = [effective_coefficient(run, recipe.monte_carlo.seed) for run in posed]
    return [one for one in found if one is not None]

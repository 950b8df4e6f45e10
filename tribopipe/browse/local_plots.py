"""Plots over axes of their own: local wear, and k_D against friction."""

from tribopipe.archive.steps import WEAR_FITS, StepName
from tribopipe.base.arrays import Column
from tribopipe.browse.run_results import ReadOnDemand
from tribopipe.browse.samples import RunFile
from tribopipe.documents.recipe import Recipe
from tribopipe.evaluation.study.effective import EffectiveCoefficient, effective_coefficient
from tribopipe.evaluation.study.member import Member
from tribopipe.pipeline.archived_results import archived_correction, archived_friction
from tribopipe.pipeline.step_definitions import recipe_of
from tribopipe.results.wear_fit import WearFit
from tribopipe.views.plot import Panel
from tribopipe.views.run_plots import local_wear_panels
from tribopipe.views.study_plots import LawCoefficient, coefficient_panel


def course_axis(run: RunFile, step: StepName) -> str | None:
    """Return the name of the axis of local wear; none where it was not computed."""
    names = ("sliding_distance", "rotations")
    return next((name for name in names if f"/entry/{step}/course/{name}" in run.datasets), None)


def draw_course(run: RunFile, x: Column, step: StepName) -> tuple[Panel, ...]:
    """Draw the course of local wear with the model with uniform pressure."""
    folder = f"/entry/{step}/course/"
    names = [path.removeprefix(folder) for path in run.datasets if path.startswith(folder)]
    return local_wear_panels(x, ReadOnDemand(names, lambda name: run.column(folder + name)), run.id, folder)


def effective(run: RunFile) -> EffectiveCoefficient | None:
    """Return k_D by the measured curve in windows along a run, as Sarkar's law was fitted; none without friction."""
    step = run.outline.steps.get("wear_fit_sarkar")
    recipe = Recipe() if step is None else recipe_of(step.options)
    return run.keep("effective k_D", lambda: _effective(run, recipe))


def _effective(run: RunFile, recipe: Recipe) -> EffectiveCoefficient | None:
    member = Member(archived_correction(run.archive, run.id), archived_friction(run.archive, run.id))
    return effective_coefficient(member.pose("sarkar", recipe), recipe.monte_carlo.seed)


def draw_coefficient(run: RunFile) -> tuple[Panel, ...]:
    """Draw effective k_D against the friction coefficient, with the values of the fitted laws (paper, Fig. 5)."""
    found = effective(run)
    fits = (run.result(name, WearFit) for name in WEAR_FITS.values())
    laws = [
        LawCoefficient(fit.model, fit.first.wear_coefficient, fit.first.interval)
        for fit in fits
        if fit is not None and fit.first is not None
    ]
    return (coefficient_panel([] if found is None else [found], laws),)

"""Plots over axes of their own: local wear, and k_D against friction."""

from collections.abc import Iterator, Sequence

import numpy as np

from tribopipe.archive.steps import WEAR_FITS, StepName
from tribopipe.base.arrays import Column
from tribopipe.browse.samples import RunFile
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.evaluation.study.effective import EffectiveCoefficient, effective_coefficient
from tribopipe.evaluation.study.member import Member
from tribopipe.physics.friction_path import junction_factor
from tribopipe.physics.laws import law_title
from tribopipe.pipeline.archived_results import archived_correction, archived_friction
from tribopipe.pipeline.step_definitions import recipe_of
from tribopipe.results.evaluation import COVERAGE_FACTOR
from tribopipe.results.wear_fit import WearFit
from tribopipe.views.plot import COEFFICIENT, MICRONS, Curve, Panel, Unit

_COURSE = (
    ("wear depth", MICRONS, {"local": "depth", "GIWM": "giwm_depth"}),
    ("pressure", Unit("Pa", "GPa"), {"local, peak": "peak_pressure", "local, mean": "mean_pressure"}),
    ("half width of the contact", MICRONS, {"local": "half_width", "GIWM": "giwm_half_width"}),
)
"""What is drawn of the course of local wear: label, unit, and columns by what they are called."""


def course_axis(run: RunFile, step: StepName) -> str | None:
    """Return the name of the axis of local wear; none where it was not computed."""
    names = ("sliding_distance", "rotations")
    return next((name for name in names if f"/entry/{step}/course/{name}" in run.datasets), None)


def draw_course(run: RunFile, x: Column, step: StepName) -> tuple[Panel, ...]:
    """Draw wear depth, pressure and width of the contact by local wear, beside the model with even pressure."""
    panels = []
    for label, unit, columns in _COURSE:
        paths = {name: f"/entry/{step}/course/{column}" for name, column in columns.items()}
        curves = tuple(
            Curve(name, "prediction" if name == "GIWM" else "fit", x, run.column(path), unit, run.id, path=path)
            for name, path in paths.items()
            if path in run.datasets
        )
        panels.append(Panel(label, unit, curves))
    return tuple(panels)


def effective(run: RunFile) -> EffectiveCoefficient | None:
    """Return k_D by the measured curve in windows along a run, as Sarkar's law was fitted; none without friction."""
    step = run.outline.steps.get("wear_fit_sarkar")
    recipe = Recipe() if step is None else recipe_of(step.options)
    return run.keep("effective k_D", lambda: _effective(run, recipe))


def _effective(run: RunFile, recipe: Recipe) -> EffectiveCoefficient | None:
    member = Member(archived_correction(run.archive, run.id), archived_friction(run.archive, run.id))
    return effective_coefficient(member.pose("sarkar", recipe), recipe.monte_carlo.seed)


def draw_coefficient(run: RunFile) -> tuple[Panel, ...]:
    """Draw effective k_D against the friction coefficient, beside what the fitted laws say of it (paper, Fig. 5)."""
    found = effective(run)
    measured = [] if found is None else [found]
    fits = [fit for name in WEAR_FITS.values() if (fit := run.result(name, WearFit)) is not None]
    laws = [
        curve
        for fit in fits
        if (body := fit.first) is not None
        for curve in law_curves(measured, fit.model, body.wear_coefficient, body.interval)
    ]
    return (Panel("effective k_D", COEFFICIENT, (*map(measured_curve, measured), *laws)),)


def measured_curve(found: EffectiveCoefficient) -> Curve:
    """Draw effective k_D of a run, in the order of sliding, with its 95 % band."""
    half = COVERAGE_FACTOR * found.standard_uncertainty
    low, high = found.coefficient - half, found.coefficient + half
    name = f"{found.run_id}, measured"
    return Curve(name, "measured", found.friction, found.coefficient, COEFFICIENT, found.run_id, lower=low, upper=high)


def law_curves(
    measured: Sequence[EffectiveCoefficient], law: LawName, best: Quantity, interval: tuple[Quantity, Quantity]
) -> Iterator[Curve]:
    """Draw what a law says of effective k_D over the friction that was measured; nothing where none was."""
    if not measured or law not in ("archard", "sarkar"):
        return
    friction = np.concatenate([one.friction for one in measured])
    mu = np.linspace(np.min(friction), np.max(friction), 100)
    factor = junction_factor(mu) if law == "sarkar" else np.ones_like(mu)
    lines = [quantity.value * factor for quantity in (best, *interval)]
    yield Curve(law_title(law), "fit", mu, lines[0], COEFFICIENT, "", law, lines[1], lines[2])

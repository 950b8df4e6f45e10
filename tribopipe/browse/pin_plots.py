"""Plots of a run's depth signal, friction, and the wear of a pin beside the laws."""

from collections.abc import Iterator

import numpy as np

from tribopipe.archive.steps import PREDICTIONS, WEAR_FITS, StepName
from tribopipe.base.arrays import Column
from tribopipe.base.units import axis
from tribopipe.browse.drawing import MICRONS, RATIO, Curve, Mark, Panel, Role, mark
from tribopipe.browse.samples import RunFile
from tribopipe.documents.recipe import LawName
from tribopipe.physics.laws import law_label
from tribopipe.results.evaluation import DriftCorrection, FrictionFit
from tribopipe.results.wear_prediction import WearPrediction
from tribopipe.views.run_figures import WANDER_NAME

CORRECTED, PIN_WEAR = "/entry/drift_correction/data/wear_depth", "/entry/drift_correction/data/pin_wear_depth"
WANDER = "/entry/drift_correction/data/wander"
FITTED_FRICTION = "/entry/friction_fit/data/friction_coefficient"


def draw_depth(run: RunFile, x: Column) -> tuple[Panel, ...]:
    """Draw the depth reading, what drift adds to it, and the corrected wear with the end value."""
    reading, wear = run.signal("depth"), run.curve(CORRECTED)
    correction = run.result("drift_correction", DriftCorrection)
    contact = run.outline.manifest.contact
    both = "both bodies" if contact is None else contact.both
    curves = []
    if reading is not None:
        curves.append(Curve("sensor reading", "measured", x, reading, MICRONS, run.id, path=run.signal_path("depth")))
    if reading is not None and wear is not None:
        curves.append(Curve("zero offset and drift", "drift", x, reading - wear, MICRONS, run.id))
        curves.append(Curve(f"corrected wear, {both}", "measured", x, wear, MICRONS, run.id, path=CORRECTED))
    if (wander := run.curve(WANDER)) is not None:
        curves.append(Curve(WANDER_NAME, "wander", x, wander, MICRONS, run.id, path=WANDER))
    marks: tuple[Mark, ...] = ()
    if correction is not None:
        anchor = (correction.anchor or "end value").replace("_", " ")
        marks = mark(f"measured after the test: {anchor}", run.id, x, correction.end_wear_depth, MICRONS)
    return (Panel(axis("depth", "um"), tuple(curves), marks),)


def draw_friction(run: RunFile, x: Column) -> tuple[Panel, ...]:
    """Draw the friction coefficient with Eq. 7 as fitted, and the residuals below."""
    measured, fit = run.signal("friction_coefficient"), run.result("friction_fit", FrictionFit)
    path, fitted = run.signal_path("friction_coefficient"), _fitted_friction(run, fit)
    curves, residuals = [], []
    if measured is not None:
        curves.append(Curve("measured", "measured", x, measured, RATIO, run.id, path=path))
    if fitted is not None and measured is not None and fit is not None:
        name = "A·exp(−s/c) + b" if fit.outcome == "exponential" else "steady value"
        curves.append(Curve(name, "fit", x, fitted, RATIO, run.id, path=FITTED_FRICTION))
        residuals.append(Curve("measured less fitted", "residual", x, measured - fitted, RATIO, run.id))
    above = Panel("friction coefficient μ", tuple(curves))
    return (above, Panel("residual of μ", tuple(residuals))) if residuals else (above,)


def _fitted_friction(run: RunFile, fit: FrictionFit | None) -> Column | None:
    """Return fitted friction where it was fitted, missing elsewhere; none where there is none."""
    fitted, slid = run.curve(FITTED_FRICTION), run.signal("sliding_distance")
    if fit is None or fitted is None or fit.window is None or slid is None:
        return fitted
    return np.where((slid >= fit.window[0].value) & (slid <= fit.window[1].value), fitted, np.nan)


def draw_pin_wear(run: RunFile, x: Column) -> tuple[Panel, ...]:
    """Draw the pin's wear with the laws and their 95 % bands, predictions, and the residuals of fitted laws below."""
    wear, laws = run.curve(PIN_WEAR), list(_laws(run, x))
    measured = (
        () if wear is None else (Curve("pin wear, corrected", "measured", x, wear, MICRONS, run.id, path=PIN_WEAR),)
    )
    residuals = tuple(
        Curve(f"measured less {law.name}", "residual", x, wear - law.y, MICRONS, run.id, law.law)
        for law in laws
        if wear is not None and law.role == "fit"
    )
    correction = run.result("drift_correction", DriftCorrection)
    ended = None if correction is None else correction.pin_wear_depth
    marks = mark("pin wear measured after the test", run.id, x, ended, MICRONS)
    above = Panel(axis("pin wear depth", "um"), (*measured, *laws), marks)
    return (above, Panel(axis("residual", "um"), residuals)) if residuals else (above,)


def _laws(run: RunFile, x: Column) -> Iterator[Curve]:
    for law, name in WEAR_FITS.items():
        yield from _law(run, x, law, name, "fit", f"{law_label(law)}, fitted")
    for law, name in PREDICTIONS.items():
        prediction = run.result(name, WearPrediction)
        source = prediction.reference if prediction is not None else None
        said = f"{law_label(law)}, predicted from {source or 'a given k_D'}"
        yield from _law(run, x, law, name, "prediction", said)


def _law(run: RunFile, x: Column, law: LawName, step: StepName, role: Role, name: str) -> Iterator[Curve]:
    path = f"/entry/{step}/data/wear_depth"
    best, lower, upper = (run.curve(f"{path}{end}") for end in ("", "_lower", "_upper"))
    if best is not None:
        yield Curve(name, role, x, best, MICRONS, run.id, law, lower, upper, path)

"""What plots a run offers, against which axes, and each as a drawing."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from tribopipe.archive.steps import LOCAL_WEAR, PREDICTIONS, WEAR_FITS, StepName
from tribopipe.base.arrays import Column
from tribopipe.browse.local_plots import course_axis, draw_coefficient, draw_course
from tribopipe.browse.run_results import corrected_run, located, raw_run, wear_curves
from tribopipe.browse.samples import RunFile
from tribopipe.browse.signal_plots import changed, draw_clean_up, draw_extra, draw_signals, extras, recorded
from tribopipe.documents.preprocessing import CleanUp
from tribopipe.physics.laws import law_title
from tribopipe.results.evaluation import FrictionFit
from tribopipe.results.wear_fit import WearFit
from tribopipe.views.plot import Panel, Plot, axis_label
from tribopipe.views.run_figures import basis_words
from tribopipe.views.run_plots import (
    AXES,
    CORRECTED,
    PIN_WEAR,
    contact_panels,
    depth_panels,
    friction_panels,
    wear_panels,
)

Draw = Callable[[str], tuple[Panel, ...]]
"""Draws a plot against an axis: its panels from the top."""
RAW = "raw"
"""Where plots stand that belong to no step."""


@dataclass(frozen=True)
class PlotOffer:
    """A plot that a run or a study has."""

    name: str
    title: str
    stage: str
    """The step with which it is shown, or "raw"."""
    path: str
    """What a viewer of HDF5 opens for it."""
    axes: tuple[str, ...]
    """Names of the axes it can be drawn against, the usual one first."""
    draw: Draw = field(repr=False)
    words: str = ""
    """What a reader has to be given of it, which its page does not state anyway."""

    def drawing(self, against: str | None = None) -> Plot:
        """Draw it against an axis, or the usual one."""
        chosen = against if against in self.axes else self.axes[0]
        return Plot(self.title, self.words, chosen, axis_label(chosen), self.draw(chosen))


def coefficient_offer(stage: str, path: str, draw: Draw) -> PlotOffer:
    """Offer a plot of k_D against the friction coefficient."""
    words = "Worn volume over load and distance in windows along each run; Sarkar's law expects k_D·√(1 + 3μ²)."
    return PlotOffer("coefficient", "Wear coefficient against friction", stage, path, ("friction",), draw, words)


def run_plots(run: RunFile) -> list[PlotOffer]:
    """Return the plots of a run, the wear curve first."""
    return [*_wear(run), *_from_signals(run), *_over_own_axes(run), *_recorded(run)]


def run_axes(run: RunFile) -> tuple[str, ...]:
    """Return what the samples of a run can be drawn against, the usual first."""
    known = [name for name in AXES if name in run.outline.ends]
    usual = run.outline.manifest.progress.signal
    return (*sorted(known, key=lambda name: name != usual), "sample")


def _place(run: RunFile, name: str) -> Column:
    """Return the place of each sample on an axis; all axes are shown in SI."""
    if name == "sample":
        return run.keep("sample", lambda: np.arange(run.outline.samples, dtype=np.float64))
    column = next((run.signal(known) for known in AXES if known == name), None)
    return np.full(run.outline.samples, np.nan) if column is None else column


def _sampled(
    run: RunFile,
    name: str,
    title: str,
    stage: str,
    path: str,
    draw: Callable[[RunFile, Column], tuple[Panel, ...]],
    words: str = "",
) -> PlotOffer:
    """Offer a plot of samples."""

    def panels(against: str) -> tuple[Panel, ...]:
        return located(run, draw(run, _place(run, against)))

    return PlotOffer(name, title, stage, path, run_axes(run), panels, words)


def _first_step(run: RunFile, *steps: StepName) -> str:
    return next((step for step in steps if step in run.outline.steps), RAW)


def _group(run: RunFile, stage: str) -> str:
    """Return the HDF5 group to plot for a step: its curves, else the raw signals."""
    return (
        f"/entry/{stage}/data"
        if any(path.startswith(f"/entry/{stage}/data/") for path in run.datasets)
        else "/entry/raw"
    )


def _wear(run: RunFile) -> Iterator[PlotOffer]:
    stage = _first_step(run, *WEAR_FITS.values(), "drift_correction")
    path = "/entry/wear" if any(path.startswith("/entry/wear/") for path in run.datasets) else _group(run, stage)
    curves = [f"/entry/{step}/data/" for step in run.outline.steps if step.startswith(("wear_fit", "prediction"))]
    if any(f"{curve}curved_volume" in run.datasets for curve in curves):
        yield _sampled(run, "wear", "Wear of both discs", stage, path, _draw_wear)
        yield _sampled(run, "contact", "Contact", stage, _group(run, stage), _draw_contact)
    elif PIN_WEAR in run.datasets or any(f"{curve}wear_depth" in run.datasets for curve in curves):
        fits = (run.result(step, WearFit) for step in WEAR_FITS.values())
        words = "; ".join(basis_words(fit for fit in fits if fit is not None))
        yield _sampled(run, "wear", "Wear of the pin", stage, path, _draw_wear, words)


def _draw_wear(run: RunFile, x: Column) -> tuple[Panel, ...]:
    return wear_panels(x, corrected_run(run), wear_curves(run, WEAR_FITS), wear_curves(run, PREDICTIONS))


def _draw_contact(run: RunFile, x: Column) -> tuple[Panel, ...]:
    return contact_panels(x, corrected_run(run), wear_curves(run, WEAR_FITS))


def _draw_depth(run: RunFile, x: Column) -> tuple[Panel, ...]:
    return depth_panels(x, corrected_run(run), run.result("clean_up", CleanUp))


def _draw_friction(run: RunFile, x: Column) -> tuple[Panel, ...]:
    return friction_panels(x, raw_run(run), run.result("friction_fit", FrictionFit), run.result("clean_up", CleanUp))


def _from_signals(run: RunFile) -> Iterator[PlotOffer]:
    if "depth" in run.outline.origins:
        stage = _first_step(run, "drift_correction")
        yield _sampled(run, "depth", "Depth signal", stage, _group(run, stage), _draw_depth)
    if "friction_coefficient" in run.outline.origins:
        stage = _first_step(run, "friction_fit")
        yield _sampled(run, "friction", "Friction", stage, _group(run, stage), _draw_friction)


def _over_own_axes(run: RunFile) -> Iterator[PlotOffer]:
    fit = run.result("wear_fit_sarkar", WearFit)
    if CORRECTED in run.datasets and fit is not None and fit.correction is not None:
        path = _group(run, "wear_fit_sarkar")
        yield coefficient_offer("wear_fit_sarkar", path, lambda _: draw_coefficient(run))
    for law, step in LOCAL_WEAR.items():
        along = course_axis(run, step)
        if along is not None:
            path = f"/entry/{step}/course"
            draw = partial(_course, run, step, f"{path}/{along}")
            title = f"Local wear by {law_title(law)}"
            yield PlotOffer(f"local-wear-{law}", title, step, path, (along,), draw)


def _course(run: RunFile, step: StepName, axis_path: str, _: str) -> tuple[Panel, ...]:
    return draw_course(run, run.column(axis_path), step)


def _recorded(run: RunFile) -> Iterator[PlotOffer]:
    if changed(run):
        yield _sampled(run, "clean-up", "Changes by preprocessing", "clean_up", "/entry/clean_up/data", draw_clean_up)
    if recorded(run):
        yield _sampled(run, "signals", "Recorded signals", RAW, "/entry/raw", draw_signals)
    for number, (name, path) in enumerate(run.keep("extras", lambda: extras(run)).items()):
        draw = partial(draw_extra, name=name, path=path)
        yield _sampled(run, f"column-{number}", name, RAW, path, draw)

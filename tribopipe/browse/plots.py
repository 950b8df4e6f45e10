"""The plots that a run offers and their axes, and each as a drawing; columns are read as they are drawn."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Generic, TypeVar

import numpy as np

from tribopipe.archive.step_names import LOCAL_WEAR, PREDICTIONS, WEAR_FITS, StepName
from tribopipe.base.arrays import Column
from tribopipe.browse.file_cache import RunFile
from tribopipe.documents.preprocessing import CleanUp
from tribopipe.documents.recipe import Recipe
from tribopipe.documents.signals import SIGNALS, SignalName
from tribopipe.evaluation.study.k_d_along_test import EffectiveCoefficient, effective_coefficient
from tribopipe.physics.laws import law_title
from tribopipe.pipeline.archived_results import archived_member
from tribopipe.pipeline.step_definitions import recipe_of
from tribopipe.results.evaluation import DriftCorrection, FrictionFit
from tribopipe.results.run import CorrectedRun, RawRun
from tribopipe.results.wear_fit import WearFit
from tribopipe.results.wear_prediction import Band, WearCurves, WearPrediction
from tribopipe.views.plot import RATIO, Curve, Panel, Plot, axis_label
from tribopipe.views.run_figures import basis_words
from tribopipe.views.run_plots import (
    AXES,
    CLEANED,
    CORRECTED,
    PIN_WEAR,
    RAW,
    WANDER,
    clean_up_panels,
    contact_panels,
    depth_panels,
    friction_panels,
    local_wear_panels,
    signal_panels,
    wear_panels,
)
from tribopipe.views.study_plots import LawCoefficient, coefficient_panel

K = TypeVar("K", bound=str)
V = TypeVar("V")


class ReadOnDemand(Mapping[K, V], Generic[K, V]):
    """Values of some names, each read whenever it is asked for."""

    def __init__(self, names: Iterable[K], read: Callable[[K], V]) -> None:
        self._names, self._read = tuple(names), read

    def __getitem__(self, name: K) -> V:
        if name not in self._names:
            raise KeyError(name)
        return self._read(name)

    def __iter__(self) -> Iterator[K]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


def raw_run(run: RunFile, *, recorded: bool = False) -> RawRun:
    """Return a run, by the name of its file, with its preprocessed signals, or as recorded."""
    found = {name: RAW + name if recorded else run.signal_path(name) for name in SIGNALS}
    paths = {name: path for name, path in found.items() if path and path in run.datasets}
    columns = ReadOnDemand(paths, lambda name: run.sampled(paths[name]))
    manifest = run.outline.manifest.model_copy(update={"id": run.id})
    return RawRun(manifest, columns, run.outline.origins, {}, {}, ())


def corrected_run(run: RunFile) -> CorrectedRun:
    """Return a run with its drift-corrected wear; without wear if drift was not corrected."""
    correction = run.result("drift_correction", DriftCorrection) or DriftCorrection(outcome="uncorrected")
    return CorrectedRun(raw_run(run), correction, *(run.curve(path) for path in (CORRECTED, WANDER, PIN_WEAR)))


def wear_curves(run: RunFile, steps: Mapping[str, StepName]) -> list[WearCurves]:
    """Return wear by each law that has curves."""
    return [curves for step in steps.values() if (curves := _curves(run, step)) is not None]


def _curves(run: RunFile, step: StepName) -> WearCurves | None:
    result = run.result(step, WearFit) or run.result(step, WearPrediction)
    data, end = f"/entry/{step}/data/", "_lower"
    names = [path[len(data) : -len(end)] for path in run.datasets if path.startswith(data) and path.endswith(end)]

    def read(name: str) -> Band:
        best, lower, upper = (run.sampled(f"{data}{name}{edge}") for edge in ("", "_lower", "_upper"))
        return Band(best, lower, upper, unit="")

    return WearCurves(result, ReadOnDemand(names, read)) if result is not None and names else None


def located(run: RunFile, panels: Iterable[Panel]) -> tuple[Panel, ...]:
    """Return panels with the paths of the datasets that their curves are; none of those that the file does not hold."""

    def path(name: str | None) -> str | None:
        signal = next((known for known in SIGNALS if known == name), None)
        found = name if signal is None else run.signal_path(signal)
        return found if found in run.datasets else None

    return tuple(
        replace(panel, curves=tuple(replace(curve, path=path(curve.path)) for curve in panel.curves))
        for panel in panels
    )


_SHOWN_ELSEWHERE: tuple[SignalName, ...] = (*AXES, "depth", "friction_coefficient")


def recorded(run: RunFile) -> list[SignalName]:
    """Return the signals that have no plot of their own."""
    return [name for name in run.outline.origins if name not in _SHOWN_ELSEWHERE]


def draw_signals(run: RunFile, x: Column) -> tuple[Panel, ...]:
    """Draw forces, speed, temperature and humidity as recorded, each in a panel."""
    return signal_panels(x, raw_run(run, recorded=True), recorded(run))


def changed(run: RunFile) -> list[SignalName]:
    """Return the signals that preprocessing changed, but for axes."""
    return [name for name in run.outline.origins if name not in AXES and CLEANED + name in run.datasets]


def draw_clean_up(run: RunFile, x: Column) -> tuple[Panel, ...]:
    """Draw each signal that preprocessing changed, before and after."""
    return clean_up_panels(x, raw_run(run, recorded=True), raw_run(run), changed(run))


def extras(run: RunFile) -> dict[str, str]:
    """Return the paths of numeric columns that are no signals, by their names in the file."""
    with run.archive.open(run.id) as file:
        kept = file["entry"].get("extra_columns", {})
        numbers = {column.name: column for column in kept.values() if column.dtype.kind in "fiu"}
        return {f"{column.attrs['column_name']}": path for path, column in numbers.items()}


def draw_extra(run: RunFile, x: Column, name: str, path: str) -> tuple[Panel, ...]:
    """Draw a column as it was found."""
    curve = Curve(name, "measured", x, run.sampled(path), RATIO, run.id, path=path)
    return (Panel(name, RATIO, (curve,)),)


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
    member = archived_member(run.archive, run.id)
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


Draw = Callable[[str], tuple[Panel, ...]]
"""Draws a plot against an axis: its panels from the top."""
RAW_STAGE = "raw"
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
    words = (
        "Effective k_D: wear volume per unit load and sliding distance, in windows along each run; Sarkar's law "
        "predicts k_D·√(1 + 3μ²)."
    )
    return PlotOffer(
        "coefficient", "Wear coefficient vs. friction coefficient", stage, path, ("friction",), draw, words
    )


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
    return next((step for step in steps if step in run.outline.steps), RAW_STAGE)


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
        heading = run.outline.manifest.worded("Wear of the pin")
        yield _sampled(run, "wear", heading, stage, path, _draw_wear, words)


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
            title = f"Local wear ({law_title(law)})"
            yield PlotOffer(f"local-wear-{law}", title, step, path, (along,), draw)


def _course(run: RunFile, step: StepName, axis_path: str, _: str) -> tuple[Panel, ...]:
    return draw_course(run, run.column(axis_path), step)


def _recorded(run: RunFile) -> Iterator[PlotOffer]:
    if changed(run):
        yield _sampled(run, "clean-up", "Changes in preprocessing", "clean_up", "/entry/clean_up/data", draw_clean_up)
    if recorded(run):
        yield _sampled(run, "signals", "Recorded signals", RAW_STAGE, "/entry/raw", draw_signals)
    for number, (name, path) in enumerate(run.keep("extras", lambda: extras(run)).items()):
        draw = partial(draw_extra, name=name, path=path)
        yield _sampled(run, f"column-{number}", name, RAW_STAGE, path, draw)

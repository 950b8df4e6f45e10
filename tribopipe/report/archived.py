"""Figures of archived runs, saved beside the archive."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from tribopipe.archive.steps import PREDICTIONS, WEAR_FITS, Step, StepName
from tribopipe.archive.store import Archive
from tribopipe.pipeline import archived_correction, archived_friction
from tribopipe.records.disc_results import TwinDiscFit, TwinDiscPrediction
from tribopipe.records.results import WearFit, WearPrediction
from tribopipe.report.disc_figures import plot_disc_contact, plot_disc_wear
from tribopipe.report.figures import plot_depth, plot_friction, plot_wear, save_figure
from tribopipe.run import CorrectedRun
from tribopipe.wear.curves import LawCurve
from tribopipe.wear.twin_disc.curves import OUTCOMES, DiscBand, DiscCurves

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FOLDER = "figures"


def save_run_figures(archive: Archive, run_id: str, suffix: str = ".png") -> list[Path]:
    """Draw what a run has: depth, friction, wear, and the contact of two discs.

    Return the files written, <archive>/figures/<id>-<what>.png.

    Nothing is drawn of a run that could not be corrected for want of samples.
    """
    if "drift_correction" not in archive.step_names(run_id):
        return []
    corrected, friction = archived_correction(archive, run_id), archived_friction(archive, run_id)
    figures: dict[str, Figure] = {}
    if "depth" in corrected.run.columns:
        figures["depth"] = plot_depth(corrected)
    if friction is not None and friction.outcome != "none":
        figures["friction"] = plot_friction(corrected.run, friction)
    draw_wear = _disc_figures if corrected.run.manifest.rolls else _pin_figures
    figures |= draw_wear(corrected, archive.steps(run_id))
    written = []
    for what, figure in figures.items():
        written.append(archive.folder / FOLDER / f"{run_id}-{what}{suffix}")
        save_figure(figure, written[-1])
    return written


def _pin_figures(corrected: CorrectedRun, steps: Mapping[StepName, Step]) -> "dict[str, Figure]":
    fits, predictions = (
        [curve for name in names.values() if (curve := _curve(steps.get(name)))] for names in (WEAR_FITS, PREDICTIONS)
    )
    return {"wear": plot_wear(corrected, fits, predictions)} if fits else {}


def _disc_figures(corrected: CorrectedRun, steps: Mapping[StepName, Step]) -> "dict[str, Figure]":
    """Draw wear by all laws, and the contact by the first of them."""
    fits, predictions = (
        [curves for name in names.values() if (curves := _disc_curves(steps.get(name)))]
        for names in (WEAR_FITS, PREDICTIONS)
    )
    if not fits:
        return {}
    return {
        "wear": plot_disc_wear(corrected.run, fits, predictions),
        "contact": plot_disc_contact(corrected, fits[0]),
    }


def _curve(step: Step | None) -> LawCurve | None:
    if step is None or not step.curves or not isinstance(step.result, WearFit | WearPrediction):
        return None
    return LawCurve(
        step.result, *(step.curves[name][0] for name in ("wear_depth", "wear_depth_lower", "wear_depth_upper"))
    )


def _disc_curves(step: Step | None) -> DiscCurves | None:
    if step is None or not step.curves or not isinstance(step.result, TwinDiscFit | TwinDiscPrediction):
        return None
    lines = {name: [step.curves[f"{name}{end}"][0] for end in ("", "_lower", "_upper")] for name in OUTCOMES}
    return DiscCurves(step.result, {name: DiscBand(*three) for name, three in lines.items()})

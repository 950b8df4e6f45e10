"""Figures of archived runs, saved beside the archive."""

from pathlib import Path

from tribopipe.archive.steps import PREDICTIONS, WEAR_FITS, Step
from tribopipe.archive.store import Archive
from tribopipe.pipeline import archived_correction, archived_friction
from tribopipe.records.results import WearFit, WearPrediction
from tribopipe.report.figures import plot_depth, plot_friction, plot_wear, save_figure
from tribopipe.wear.curves import LawCurve

FOLDER = "figures"


def save_run_figures(archive: Archive, run_id: str, suffix: str = ".png") -> list[Path]:
    """Draw what a run has: depth, friction, wear. Return the files written, <archive>/figures/<id>-<what>.png.

    Nothing is drawn of a run that could not be corrected for want of samples.
    """
    if "drift_correction" not in archive.step_names(run_id):
        return []
    corrected, friction = archived_correction(archive, run_id), archived_friction(archive, run_id)
    steps = archive.steps(run_id)
    figures = {}
    if "depth" in corrected.raw.columns:
        figures["depth"] = plot_depth(corrected)
    if friction is not None and friction.outcome != "none":
        figures["friction"] = plot_friction(corrected.raw, friction)
    fits = [curve for name in WEAR_FITS.values() if (curve := _curve(steps.get(name)))]
    predictions = [curve for name in PREDICTIONS.values() if (curve := _curve(steps.get(name)))]
    if fits:
        figures["wear"] = plot_wear(corrected, fits, predictions)
    written = []
    for what, figure in figures.items():
        written.append(archive.folder / FOLDER / f"{run_id}-{what}{suffix}")
        save_figure(figure, written[-1])
    return written


def _curve(step: Step | None) -> LawCurve | None:
    if step is None or not step.curves or not isinstance(step.result, WearFit | WearPrediction):
        return None
    return LawCurve(
        step.result, *(step.curves[name][0] for name in ("wear_depth", "wear_depth_lower", "wear_depth_upper"))
    )

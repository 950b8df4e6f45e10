"""Figures of archived studies, saved next to the archive."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from tribopipe.archive.file_signature import FIGURES
from tribopipe.archive.store import Archive
from tribopipe.archive.studyfile import StoredStudy
from tribopipe.base.arrays import Column
from tribopipe.documents.recipe import Recipe
from tribopipe.evaluation.study.effective_coefficient import effective_coefficient
from tribopipe.evaluation.study.member import Member
from tribopipe.pipeline.archived_results import archived_correction, archived_friction
from tribopipe.pipeline.step_definitions import recipe_of
from tribopipe.views.archived_figures import is_since, study_caption
from tribopipe.views.run_figures import save_beside, save_figures
from tribopipe.views.study_figures import plot_study_coefficient, plot_study_friction, plot_study_wear

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_USUAL = ("svg", "png")


def study_figures(archive: Archive, study_id: str) -> "dict[str, Figure]":
    """Draw wear under each law of a study, friction, and effective k_D. Return the figures by name, in this order.

    Friction is drawn where a run has it, effective k_D where the study also tried Sarkar's law on pins. Raises
    ``ArchiveError`` where the study or one of its runs is not in the archive.
    """
    stored = archive.study(study_id)
    recipe = recipe_of(stored.options)
    runs = [
        Member(archived_correction(archive, run.id), archived_friction(archive, run.id))
        for run in stored.result.laws[0].runs
    ]
    return _figures(stored, runs, recipe)


def save_study_figures(
    archive: Archive, study_id: str, into: Path | None = None, formats: Sequence[str] = ()
) -> list[Path]:
    """Draw a study. Return the files, <into>/<study>-<what>; SVG and PNG unless ``formats`` are specified.

    In these, figures are for print, with their captions as text. ``into`` is the archive's own figures/ unless named.
    Raises as ``study_figures`` does.
    """
    figures = study_figures(archive, study_id)
    named = {f"{study_id}-{what}.{kind}": figure for what, figure in figures.items() for kind in formats or _USUAL}
    laws = archive.study_outline(study_id).result.laws
    discs = any(law.distance_per_rotation is not None for law in laws)
    captions = {f"{study_id}-{what}.txt": study_caption(what, discs=discs) for what in figures} if formats else None
    folder = into or archive.folder / FIGURES
    if into is None:
        save_beside(archive, study_id, named, captions)
    else:
        save_figures(folder, named, captions)
    return [folder / name for name in named]


def study_is_drawn(archive: Archive, study_id: str, formats: Sequence[str] = ()) -> bool:
    """Return whether all figures of a study were saved after it was evaluated."""
    study = archive.study_outline(study_id)
    name = f"{study_id}-wear-{study.result.laws[0].model}"  # which is written last
    first = [archive.folder / FIGURES / f"{name}.{kind}" for kind in formats or _USUAL]
    return all(path.exists() and is_since(path, study.date) for path in first)


def _figures(stored: StoredStudy, runs: Sequence[Member], recipe: Recipe) -> "dict[str, Figure]":
    result = stored.result
    recorded = any(curve.measured is not None for curve in stored.curves)
    depths = _recorded(runs) if result.correction == "two-step" else {}
    figures = {f"wear-{law.model}": plot_study_wear(result, law.model, stored.curves, depths) for law in result.laws}
    if any(run.friction is not None and run.friction.outcome != "none" for run in runs):
        figures["friction"] = plot_study_friction(runs)
    if recorded and any(law.model == "sarkar" for law in result.laws):
        found = [
            effective_coefficient(run.pose("sarkar", recipe), recipe.monte_carlo.seed) for run in runs if run.has_curve
        ]
        effective = [one for one in found if one is not None]
        if effective:
            figures["coefficient"] = plot_study_coefficient(result, effective)
    return figures


def _recorded(runs: Sequence[Member]) -> Mapping[str, tuple[Column, Column]]:
    """Return the corrected wear of the pins; a fit of drift together with k_D has its own, which the study contains."""
    curves = {run.id: (run.corrected.run.sliding_distance, run.corrected.pin_wear_depth) for run in runs}
    return {run_id: (distance, depth) for run_id, (distance, depth) in curves.items() if depth is not None}

"""Figures of archived runs and studies, saved next to the archive, and their captions.

Captions are also the text for screen readers. After a batch, figures are updated, including those that an earlier,
interrupted batch did not draw.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from tribopipe.archive.file_signature import FIGURES
from tribopipe.archive.local_wear_tables import archived_local_wear
from tribopipe.archive.outline import RunOutline, archived_curves
from tribopipe.archive.step_names import LOCAL_WEAR, PREDICTIONS, WEAR_FITS, Step, StepName
from tribopipe.archive.store import Archive
from tribopipe.archive.studyfile import StoredStudy
from tribopipe.base.arrays import Column
from tribopipe.base.errors import TribopipeError
from tribopipe.base.executor import ALONE, Crew, in_turn
from tribopipe.documents.preprocessing import CleanUp
from tribopipe.documents.recipe import Recipe
from tribopipe.evaluation.study.k_d_along_test import effective_coefficient
from tribopipe.evaluation.study.member import Member
from tribopipe.physics.laws import law_title
from tribopipe.pipeline.archived_results import archived_correction, archived_friction, archived_member
from tribopipe.pipeline.stages import Outcome, attempted
from tribopipe.pipeline.step_definitions import recipe_of
from tribopipe.results.run import CorrectedRun, RawRun
from tribopipe.views.clean_up_figures import changed_signals, plot_clean_up
from tribopipe.views.local_wear_figures import local_wear_figures
from tribopipe.views.run_figures import plot_contact, plot_depth, plot_friction, plot_wear, save_beside, save_figures
from tribopipe.views.study_figures import plot_study_coefficient, plot_study_friction, plot_study_wear

if TYPE_CHECKING:
    from matplotlib.figure import Figure


RUN_CAPTIONS = {
    "depth": (
        "Depth signal: sensor reading, its zero offset and drift, and the corrected wear, if available (bar: post-test "
        "measurement, 95 % interval)."
    ),
    "friction": "Measured friction coefficient with its fit; below, the residuals.",
    "clean-up": "Signals as recorded and after preprocessing.",
    "wear": "Measured, fitted and predicted wear with 95 % bands (bar: post-test measurement, 95 % interval).",
    "contact": "Wear depth, mean pressure, and half-width and half-length of the contact, calculated with the "
    "fitted law, with 95 % bands.",
    "local-wear": "Wear simulated with the local contact pressure, compared with the GIWM.",
    "local-pressure": "Distribution of the contact pressure at several stages of wear.",
}
_STUDY_CAPTIONS = {
    "friction": "Friction coefficient of each run, with its fit.",
    "coefficient": (
        "Effective k_D of each run (wear volume per unit load and sliding distance, in windows along the wear curve) "
        "against the friction coefficient in each window, with both laws."
    ),
}


def study_caption(what: str, *, discs: bool) -> str:
    """Return the caption of a study's figure, by its name, for two discs or for a pin."""
    if what in _STUDY_CAPTIONS:
        return _STUDY_CAPTIONS[what]
    law = law_title(what.removeprefix("wear-"))
    if discs:
        return (
            f"Wear volume of each disc with {law} and its 95 % band; below, ratio of measured to predicted wear. "
            "Filled markers: runs from which k_D is identified; open markers: predicted runs."
        )
    return (
        f"Pin wear depth of each run with {law} and its 95 % band; the law is fitted to the runs marked as fitted, and "
        "predicts the others."
    )


_DRAWN = ("depth", "friction", "clean-up", "wear", "contact", "local-wear", "local-pressure")


def run_figures(archive: Archive, run_id: str) -> "dict[str, Figure]":
    """Draw the available figures of a run: depth, friction, preprocessing, wear, contact of two discs, and local wear.

    Return the figures by these names, in this order. Nothing is drawn of a run that could not be corrected for want of
    samples. Raises ``ArchiveError`` if the run is not in the archive.
    """
    if "drift_correction" not in archive.step_names(run_id):
        return {}
    corrected, friction = archived_correction(archive, run_id), archived_friction(archive, run_id)
    clean_up = archive.result(run_id, "clean_up", CleanUp) or CleanUp()
    figures = _clean_up_figures(archive, corrected.run, clean_up)
    if "depth" in corrected.run.columns:
        figures["depth"] = plot_depth(corrected, clean_up)
    if friction is not None and friction.outcome != "none":
        figures["friction"] = plot_friction(corrected.run, friction, clean_up)
    steps = archive.steps(run_id)
    figures |= _wear_figures(corrected, steps) | _local_figures(steps, run_id)
    return {what: figures[what] for what in _DRAWN if what in figures}


def save_run_figures(
    archive: Archive, run_id: str, formats: Sequence[str] = (), into: Path | None = None
) -> list[Path]:
    """Draw the available figures of a run. Return the files written, <into>/<id>-<what>.png.

    In ``formats`` that are named, figures are for print, with their captions as text. ``into`` is the archive's own
    figures/ unless named; there, a figure that was drawn before of what the run no longer has is deleted. Raises
    ``ArchiveError`` if the run is not in the archive, or figures cannot be written.
    """
    figures, kinds = run_figures(archive, run_id), formats or ("png",)
    saved = _save(archive, run_id, figures, kinds, RUN_CAPTIONS if formats else None, into)
    if into is None:
        for what in set(_DRAWN) - figures.keys():
            for kind in (*kinds, "txt"):
                (archive.folder / FIGURES / f"{run_id}-{what}.{kind}").unlink(missing_ok=True)
    return saved


def _save(
    archive: Archive,
    identifier: str,
    figures: "Mapping[str, Figure]",
    kinds: Sequence[str],
    captions: Mapping[str, str] | None,
    into: Path | None,
) -> list[Path]:
    """Write figures of a run or study as files of these kinds, with captions for print. Return the files."""
    named = {f"{identifier}-{what}.{kind}": figure for what, figure in figures.items() for kind in kinds}
    texts = None if captions is None else {f"{identifier}-{what}.txt": captions[what] for what in figures}
    if into is None:
        save_beside(archive, identifier, named, texts)
    else:
        save_figures(into, named, texts)
    return [(into or archive.folder / FIGURES) / name for name in named]


def run_is_drawn(archive: Archive, run_id: str, formats: Sequence[str] = ()) -> bool:
    """Return whether all figures of a run were saved after its last step, even if a later command was interrupted."""
    run = archive.outline(run_id)
    if "drift_correction" not in run.steps:
        return True
    last = max(step.date for step in run.steps.values())
    return all(_is_drawn_as(archive, run, f".{name}", last) for name in formats or ("png",))


def _is_drawn_as(archive: Archive, run: RunOutline, ending: str, last: str) -> bool:
    names = (archive.folder / FIGURES / f"{run.manifest.id}-{what}{ending}" for what in _DRAWN)
    saved = [path for path in names if path.exists()]
    complete = saved and ("depth" not in run.origins or saved[0].stem.endswith("-depth"))  # the first is written last
    return bool(complete) and is_since(saved[0], last)


def is_since(path: Path, date: str) -> bool:
    """Return whether a file was written on or after a date, ISO 8601."""
    return path.stat().st_mtime >= datetime.fromisoformat(date).timestamp()


def _clean_up_figures(archive: Archive, cleaned: RawRun, clean_up: CleanUp) -> "dict[str, Figure]":
    if not clean_up.changes:
        return {}
    raw = archive.raw(cleaned.id)
    return {"clean-up": plot_clean_up(raw, cleaned, clean_up)} if changed_signals(raw, cleaned, clean_up) else {}


def _wear_figures(corrected: CorrectedRun, steps: Mapping[StepName, Step]) -> "dict[str, Figure]":
    """Draw wear with all laws, and the contact with the first of them if it is known along the run."""
    fits, predictions = (
        [curves for name in names.values() if (curves := archived_curves(steps.get(name)))]
        for names in (WEAR_FITS, PREDICTIONS)
    )
    if not fits:
        return {}
    figures = {"wear": plot_wear(corrected, fits, predictions)}
    if "pressure" in fits[0].bands:
        figures["contact"] = plot_contact(corrected, fits[0])
    return figures


def _local_figures(steps: Mapping[StepName, Step], run_id: str) -> "dict[str, Figure]":
    """Draw local wear with the first law for which it was computed."""
    found = (archived_local_wear(steps.get(name)) for name in LOCAL_WEAR.values())
    return next((local_wear_figures(curves, run_id) for curves in found if curves is not None), {})


_USUAL = ("svg", "png")


def study_figures(archive: Archive, study_id: str) -> "dict[str, Figure]":
    """Draw wear under each law of a study, friction, and effective k_D. Return the figures by name, in this order.

    Friction is drawn where a run has it, effective k_D where the study also tried Sarkar's law on pins. Raises
    ``ArchiveError`` where the study or one of its runs is not in the archive.
    """
    stored = archive.study(study_id)
    recipe = recipe_of(stored.options)
    runs = [archived_member(archive, run.id) for run in stored.result.laws[0].runs]
    return _figures(stored, runs, recipe)


def save_study_figures(
    archive: Archive, study_id: str, formats: Sequence[str] = (), into: Path | None = None
) -> list[Path]:
    """Draw a study. Return the files, <into>/<study>-<what>; SVG and PNG unless ``formats`` are specified.

    In these, figures are for print, with their captions as text. ``into`` is the archive's own figures/ unless named.
    Raises as ``study_figures`` does.
    """
    figures = study_figures(archive, study_id)
    laws = archive.study_outline(study_id).result.laws
    discs = any(law.distance_per_rotation is not None for law in laws)
    captions = {what: study_caption(what, discs=discs) for what in figures} if formats else None
    return _save(archive, study_id, figures, formats or _USUAL, captions, into)


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


_Update = tuple[str, Callable[[], Outcome]]
"""A run or study by its id, and the function that updates its figures."""


def figure_steps(archive: Archive, outcomes: Sequence[Outcome], formats: Sequence[str] = ()) -> list[_Update]:
    """Return what to draw after these steps: each study and run by its id, and the function that draws it.

    Studies have the most to draw: a worker that began one last would keep the others waiting. ``formats`` are those
    for print; none for figures of the screen.
    """
    sound = [outcome for outcome in outcomes if outcome.error is None]
    runs = _changed([outcome for outcome in sound if outcome.stage != "study"])
    studies = _changed([outcome for outcome in sound if outcome.stage == "study"])
    return [
        *((name, partial(_update_study, archive, name, formats, changed)) for name, changed in studies),
        *((name, partial(_update_run, archive, name, formats, changed)) for name, changed in runs),
    ]


def drawn(steps: Sequence[_Update], crew: Crew = ALONE) -> Iterator[Outcome]:
    """Draw the figures; yield the outcome for each run and study. One that fails does not stop the others."""
    for (name, _), answer in in_turn(_attempted, steps, crew):
        yield Outcome.failed(name, "figures", answer) if isinstance(answer, TribopipeError) else answer


def _attempted(step: _Update) -> Outcome:
    name, update = step
    return attempted(name, "figures", update)


def _changed(outcomes: Sequence[Outcome]) -> list[tuple[str, bool]]:
    """Return each id with whether any of its steps was performed in this batch."""
    done = {outcome.run_id for outcome in outcomes if outcome.status == "done"}
    return [(name, name in done) for name in dict.fromkeys(outcome.run_id for outcome in outcomes)]


def _update_run(archive: Archive, run_id: str, formats: Sequence[str], changed: bool) -> Outcome:
    if not changed and run_is_drawn(archive, run_id, formats):
        return Outcome(run_id, "figures", "unchanged")
    save_run_figures(archive, run_id, formats)
    return Outcome(run_id, "figures", "done")


def _update_study(archive: Archive, study_id: str, formats: Sequence[str], changed: bool) -> Outcome:
    if not changed and study_is_drawn(archive, study_id, formats):
        return Outcome(study_id, "figures", "unchanged")
    save_study_figures(archive, study_id, formats)
    return Outcome(study_id, "figures", "done")

"""Figures brought up to date after a batch, those too that an earlier one was interrupted before."""

from collections.abc import Callable, Sequence
from functools import partial

from tribopipe.archive.store import Archive
from tribopipe.pipeline import Outcome
from tribopipe.report.archived import run_is_drawn, save_run_figures
from tribopipe.report.studies import save_study_figures, study_is_drawn

_Call = Callable[[Archive, str], object]


def figure_steps(archive: Archive, outcomes: Sequence[Outcome]) -> list[tuple[str, Callable[[], Outcome]]]:
    """Return what is to be drawn after these steps: each run and study by its id, and how its outcome is reached."""
    sound = [outcome for outcome in outcomes if outcome.error is None]
    runs = _changed([outcome for outcome in sound if outcome.stage != "study"])
    studies = _changed([outcome for outcome in sound if outcome.stage == "study"])
    return [
        *((name, partial(_draw, archive, name, new, run_is_drawn, save_run_figures)) for name, new in runs),
        *((name, partial(_draw, archive, name, new, study_is_drawn, save_study_figures)) for name, new in studies),
    ]


def _changed(outcomes: Sequence[Outcome]) -> list[tuple[str, bool]]:
    """Return each id with whether any of its steps was done just now."""
    done = {outcome.run_id for outcome in outcomes if outcome.status == "done"}
    return [(name, name in done) for name in dict.fromkeys(outcome.run_id for outcome in outcomes)]


def _draw(archive: Archive, name: str, changed: bool, is_drawn: _Call, save: _Call) -> Outcome:
    if not changed and is_drawn(archive, name):
        return Outcome(name, "figures", "unchanged")
    save(archive, name)
    return Outcome(name, "figures", "done")

"""Figures brought up to date after a batch, those too that an earlier one was interrupted before."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial

from tribopipe.archive.store import Archive
from tribopipe.base.errors import TribopipeError
from tribopipe.base.executor import ALONE, Crew, as_done
from tribopipe.pipeline.stages import Outcome, attempted
from tribopipe.views.archived_figures import run_is_drawn, save_run_figures
from tribopipe.views.archived_study_figures import save_study_figures, study_is_drawn

_Call = Callable[..., object]
Step = tuple[str, Callable[[], Outcome]]
"""A run or study by its id, and how its figures are brought up to date."""


def figure_steps(archive: Archive, outcomes: Sequence[Outcome], formats: Sequence[str] = ()) -> list[Step]:
    """Return what is to be drawn after these steps: each run and study by its id, and how its outcome is reached.

    ``formats`` are those for print; none for figures of the screen.
    """
    how = {"formats": formats} if formats else {}
    sound = [outcome for outcome in outcomes if outcome.error is None]
    runs = _changed([outcome for outcome in sound if outcome.stage != "study"])
    studies = _changed([outcome for outcome in sound if outcome.stage == "study"])
    return [
        *((name, partial(_draw, archive, name, new, run_is_drawn, save_run_figures, how)) for name, new in runs),
        *((name, partial(_draw, archive, name, new, study_is_drawn, save_study_figures, how)) for name, new in studies),
    ]


def drawn(steps: Sequence[Step], crew: Crew = ALONE) -> Iterator[Outcome]:
    """Take such steps; yield what became of the figures of each run and study. One that fails stops no other."""
    for (place, (name, _)), answer in as_done(_taken, enumerate(steps), crew):
        outcome = Outcome.failed(name, "figures", answer) if isinstance(answer, TribopipeError) else answer
        yield replace(outcome, place=place)


def _taken(placed: tuple[int, Step]) -> Outcome:
    _, (name, draw) = placed
    return attempted(name, "figures", draw)


def _changed(outcomes: Sequence[Outcome]) -> list[tuple[str, bool]]:
    """Return each id with whether any of its steps was done just now."""
    done = {outcome.run_id for outcome in outcomes if outcome.status == "done"}
    return [(name, name in done) for name in dict.fromkeys(outcome.run_id for outcome in outcomes)]


def _draw(
    archive: Archive, name: str, changed: bool, is_drawn: _Call, save: _Call, how: Mapping[str, Sequence[str]]
) -> Outcome:
    if not changed and is_drawn(archive, name, **how):
        return Outcome(name, "figures", "unchanged")
    save(archive, name, **how)
    return Outcome(name, "figures", "done")

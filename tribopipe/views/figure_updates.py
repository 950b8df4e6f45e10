"""Updates of figures after a batch, including those that an earlier, interrupted batch did not draw."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial

from tribopipe.archive.store import Archive
from tribopipe.base.errors import TribopipeError
from tribopipe.base.executor import ALONE, Crew, in_turn
from tribopipe.pipeline.stages import Outcome, attempted
from tribopipe.views.archived_figures import run_is_drawn, save_run_figures, save_study_figures, study_is_drawn

_Call = Callable[..., object]
Step = tuple[str, Callable[[], Outcome]]
"""A run or study by its id, and the function that updates its figures."""


def figure_steps(archive: Archive, outcomes: Sequence[Outcome], formats: Sequence[str] = ()) -> list[Step]:
    """Return what to draw after these steps: each study and run by its id, and the function that draws it.

    Studies have the most to draw: a worker that began one last would keep the others waiting. ``formats`` are those
    for print; none for figures of the screen.
    """
    how = {"formats": formats} if formats else {}
    sound = [outcome for outcome in outcomes if outcome.error is None]
    runs = _changed([outcome for outcome in sound if outcome.stage != "study"])
    studies = _changed([outcome for outcome in sound if outcome.stage == "study"])
    return [
        *((name, partial(_draw, archive, name, new, study_is_drawn, save_study_figures, how)) for name, new in studies),
        *((name, partial(_draw, archive, name, new, run_is_drawn, save_run_figures, how)) for name, new in runs),
    ]


def drawn(steps: Sequence[Step], crew: Crew = ALONE) -> Iterator[Outcome]:
    """Draw the figures; yield the outcome for each run and study. One that fails does not stop the others."""
    for (name, _), answer in in_turn(_taken, steps, crew):
        yield Outcome.failed(name, "figures", answer) if isinstance(answer, TribopipeError) else answer


def _taken(step: Step) -> Outcome:
    name, draw = step
    return attempted(name, "figures", draw)


def _changed(outcomes: Sequence[Outcome]) -> list[tuple[str, bool]]:
    """Return each id with whether any of its steps was performed in this batch."""
    done = {outcome.run_id for outcome in outcomes if outcome.status == "done"}
    return [(name, name in done) for name in dict.fromkeys(outcome.run_id for outcome in outcomes)]


def _draw(
    archive: Archive, name: str, changed: bool, is_drawn: _Call, save: _Call, how: Mapping[str, Sequence[str]]
) -> Outcome:
    if not changed and is_drawn(archive, name, **how):
        return Outcome(name, "figures", "unchanged")
    save(archive, name, **how)
    return Outcome(name, "figures", "done")

"""Many tasks at once, in processes of this machine or on a Dask cluster; each answer comes as soon as it is there.

    for task, answer in as_done(work, tasks, Crew(jobs=2)):
        ...

Who has several batches keeps the workers for all of them:

    with at_work(Crew(jobs=2)) as crew:
        ...
"""

from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Any, Protocol, TypeVar

from tribopipe.base.errors import BatchError, TribopipeError
from tribopipe.base.failures import in_a_sentence

Task = TypeVar("Task")
Answer = TypeVar("Answer")
REDONE = 3
"""How often a task is done again that loses its workers."""


def answer_of(work: Callable[[Task], Answer], task: Task) -> Answer | TribopipeError:
    """Do a task; where it fails, return that as one sentence, for not every exception can be sent to who asked."""
    try:
        return work(task)
    except Exception as error:  # noqa: BLE001 - a fault in one task is no reason to leave the others
        return in_a_sentence(error, name_of(task))


def lost(task: object) -> BatchError:
    """Return what is stated about a task that has lost its workers too often."""
    name = name_of(task)
    return BatchError(
        f"{f'{name}: ' if name else ''}found that {REDONE + 1} workers were killed or ran out of memory; expected a "
        "worker to complete the task; if memory is short, use fewer workers"
    )


def name_of(task: object) -> str:
    """Return what a task is called, as far as it is a name or a path."""
    return str(task) if isinstance(task, str | Path) else ""


class Workers(Protocol):
    """Workers at work; one that is lost is replaced, and what it did is done again."""

    def room(self) -> int:
        """Return how many more tasks they take now."""

    def begin(self, work: Callable[[Task], Answer], task: Task) -> None:
        """Have a task done."""

    def is_busy(self) -> bool:
        """Return whether a task is not answered yet."""

    def ended(self) -> Iterable[tuple[Any, Any]]:
        """Wait for a while, and return the tasks that have ended meanwhile with their answers."""

    def forget(self) -> None:
        """Want no answer of what is not answered yet."""


def _say_nothing(_: str) -> None: ...


@dataclass(frozen=True)
class Crew:
    """Who does the tasks of a batch."""

    jobs: int = 1
    """Processes on this machine; 1: this process itself."""
    scheduler: str | None = None
    """Address of a Dask scheduler, such as "tcp://10.0.0.1:8786"; "local" for a cluster of ``jobs`` processes here."""
    tell: Callable[[str], object] = _say_nothing
    """Receives the address of the cluster's dashboard, and what a batch waits for."""
    workers: Workers | None = None
    """Those that are at work already; none: each batch begins its own."""

    @property
    def is_alone(self) -> bool:
        """Whether tasks are done by this process itself."""
        return self.jobs == 1 and self.scheduler is None


ALONE = Crew()


def as_done(
    work: Callable[[Task], Answer], tasks: Iterable[Task], crew: Crew = ALONE
) -> Iterator[tuple[Task, Answer | TribopipeError]]:
    """Yield each task with its answer as it is ready, or with the one sentence why there is none.

    Work and tasks are picklable: functions of a module, and partials of them. Only as many tasks are taken at a time as
    keep the workers busy. The task of a worker that is lost (killed, out of memory) is done by another, up to three
    times. Raises ``BatchError`` where the scheduler does not answer, or its library is not installed.
    """
    with at_work(crew) as at_hand:
        if at_hand.workers is None:
            yield from ((task, answer_of(work, task)) for task in tasks)
        else:
            yield from _as_done(work, tasks, at_hand.workers)


def _as_done(
    work: Callable[[Task], Answer], tasks: Iterable[Task], workers: Workers
) -> Iterator[tuple[Task, Answer | TribopipeError]]:
    left = iter(tasks)
    try:
        while True:
            for task in islice(left, workers.room()):
                workers.begin(work, task)
            if not workers.is_busy():
                return
            yield from workers.ended()
    finally:
        workers.forget()


@contextmanager
def at_work(crew: Crew) -> Iterator[Crew]:
    """Give a crew whose workers stay for several batches, one after the other, and end with the block.

    Raises ``BatchError`` as ``as_done`` does.
    """
    if crew.is_alone or crew.workers is not None:
        yield crew
        return
    with _workers(crew) as workers:
        yield replace(crew, workers=workers)


def _workers(crew: Crew) -> AbstractContextManager[Workers]:
    if crew.scheduler is None:
        from tribopipe.base.process_workers import processes

        return processes(crew.jobs)
    from tribopipe.base.dask_workers import cluster

    return cluster(crew.scheduler, crew.jobs, crew.tell)

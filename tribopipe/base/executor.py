"""Many tasks at once, in processes of this machine or on a Dask cluster.

    for task, answer in in_turn(work, tasks, Crew(jobs=2)):
        ...

Who has several batches keeps the workers for all of them:

    with at_work(Crew(jobs=2)) as crew:
        ...
"""

from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, replace
from functools import partial
from itertools import count, islice

from tribopipe.base.errors import TribopipeError
from tribopipe.base.tasks import Answer, Numbered, Task, Workers, answer_of, numbered_answer


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


def in_turn(
    work: Callable[[Task], Answer], tasks: Iterable[Task], crew: Crew = ALONE
) -> Iterator[tuple[Task, Answer | TribopipeError]]:
    """As ``as_done``, in the order of the tasks, so that what is printed of them depends on no worker's speed."""
    early: dict[int, tuple[Task, Answer | TribopipeError]] = {}
    due = 0
    for numbered, answer in as_done(partial(numbered_answer, work), map(Numbered, count(), tasks), crew):
        early[numbered.number] = numbered.task, answer
        while due in early:
            yield early.pop(due)
            due += 1


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

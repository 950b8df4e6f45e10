"""Workers of a Dask cluster: one that runs already, or one of processes on this machine.

Dask itself notices workers that are lost and has their tasks done by others. A worker does one task at a time, however
many threads it has, for what tribopipe calls is not made for several.
"""

import logging
import os
import re
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from importlib import import_module
from itertools import count
from queue import Empty, SimpleQueue
from threading import Lock, Thread
from typing import Any

from tribopipe.base.errors import BatchError, TribopipeError
from tribopipe.base.optional_packages import required
from tribopipe.base.process_lifecycle import inherited, undo_all, undone_by
from tribopipe.base.tasks import Answer, Task, answer_of, lost, name_of
from tribopipe.version import VERSION

LOCAL = "local"
_ADDRESS = re.compile(r"[a-z]+://.+:[0-9]+/?")
_ANSWERS_WITHIN = 10
"""How long a scheduler may take to answer, s."""
_LOOK_EVERY = 5.0
"""How often it is seen to whether there are workers, s."""
_NOT_TOLD = "ignore:resource_tracker:UserWarning"
"""What Python reports of a process that ends at once, after it has tidied up."""
_LOST_AFTER, _NEVER = "distributed.deploy.lost-worker-timeout", "1000 days"
"""How long a worker of this machine may be away until Dask gives it up for good. On a busy machine, one that was killed
may take longer to begin again than the 15 s it usually has."""
_TO_END = 2.0
"""How long the workers of this machine may take to end, s."""
_one_at_a_time = Lock()
_numbers = count()


class Cluster:
    """Workers of a Dask cluster, which may come and go."""

    def __init__(self, client: Any, tell: Callable[[str], object]) -> None:
        self._client, self._tell = client, tell
        self._begun: dict[Any, Any] = {}
        self._ended: SimpleQueue[Any] = SimpleQueue()
        self._waits = False

    def room(self) -> int:
        """Return how many tasks are wanted: one for each worker, for Dask blames one too that waits behind a killer."""
        return max(max(self._workers(), 1) - len(self._begun), 0)

    def begin(self, work: Callable[[Task], Answer], task: Task) -> None:
        """Hand a task to the scheduler."""
        key = f"tribopipe-{os.getpid()}-{next(_numbers)}"
        future = self._client.submit(_answer_on_worker, VERSION, work, task, pure=False, key=key)
        self._begun[future] = task
        future.add_done_callback(self._ended.put)

    def is_busy(self) -> bool:
        """Return whether a task is not answered yet."""
        return bool(self._begun)

    def ended(self) -> Iterator[tuple[Any, Any]]:
        """Wait for the next task to end, or a while. Raises ``BatchError`` where the scheduler has gone."""
        try:
            future = self._ended.get(timeout=_LOOK_EVERY)
        except Empty:
            self._say_what_is_waited_for()
            return
        if future not in self._begun:  # of a batch that was given up
            return
        if future.status == "cancelled":
            raise BatchError(
                "--scheduler: found that the scheduler ended before all tasks were done; expected it to keep running; "
                "restart it and run the same command again: archived results are kept"
            )
        if future.status in ("finished", "error"):
            task = self._begun.pop(future)
            yield task, _answer(future, task)
        else:  # its worker was lost before the answer was fetched, and another does it again
            future.add_done_callback(self._ended.put)

    def forget(self) -> None:
        """Have nothing more done of what is not answered yet; workers end what they do."""
        self._client.cancel(list(self._begun))
        self._begun.clear()

    def _workers(self) -> int:
        return len(self._client.nthreads())

    def _say_what_is_waited_for(self) -> None:
        waits = not self._workers()
        if waits and not self._waits:
            self._tell("waiting for workers: the scheduler has none at present")
        self._waits = waits


def _answer(future: Any, task: object) -> Any:
    killed = import_module("distributed").KilledWorker
    try:
        return future.result()
    except killed:
        return lost(task)
    except Exception as error:  # noqa: BLE001 - whatever it is that a worker cannot even begin
        return BatchError(
            f"{name_of(task) or 'a task'}: could not be run on a worker ({type(error).__name__}: {error}); "
            f"expected workers with tribopipe {VERSION} installed; check their environment"
        )


@contextmanager
def cluster(scheduler: str, jobs: int, tell: Callable[[str], object]) -> Iterator[Cluster]:
    """Give the workers of a scheduler, or of a cluster on this machine, which ends with the block.

    Raises ``BatchError`` where there is no scheduler, or Dask is not installed.
    """
    problem = "--scheduler: found no Python package 'distributed'"
    distributed = required("distributed", "hpc", "workers of Dask", problem=problem, error=BatchError)
    with ExitStack() as ending:
        ending.enter_context(_quiet())
        if scheduler == LOCAL:
            scheduler = ending.enter_context(_local(distributed, jobs, tell))
            client = ending.enter_context(_connected(distributed, scheduler))
            ending.enter_context(undone_by(partial(_end_all, client)))
        else:
            client = ending.enter_context(_connected(distributed, scheduler))
        yield Cluster(client, tell)


@contextmanager
def _local(distributed: Any, jobs: int, tell: Callable[[str], object]) -> Iterator[str]:
    """Begin a cluster on this machine, on ports that are free; give the address of its scheduler."""
    patient = import_module("dask.config").set({_LOST_AFTER: _NEVER})
    with inherited({"PYTHONWARNINGS": _NOT_TOLD}):
        begun = distributed.LocalCluster(
            n_workers=jobs, threads_per_worker=1, dashboard_address="127.0.0.1:0", silence_logs=logging.CRITICAL
        )
    with patient, begun as here:
        tell(f"cluster of {jobs} workers; dashboard at {here.dashboard_link}")
        yield here.scheduler_address


@contextmanager
def _connected(distributed: Any, scheduler: str) -> Iterator[Any]:
    if _ADDRESS.fullmatch(scheduler) is None:
        raise BatchError(
            f'--scheduler: found {scheduler!r}; expected an address such as tcp://10.0.0.1:8786, or "{LOCAL}" for a '
            "cluster on this machine"
        )
    try:
        client = distributed.Client(scheduler, timeout=_ANSWERS_WITHIN, set_as_default=False)
    except OSError:
        raise BatchError(
            f"--scheduler: found no Dask scheduler at {scheduler}; expected a scheduler that responds within "
            f"{_ANSWERS_WITHIN} s; start it with `dask scheduler`, or check the address"
        ) from None
    with client:
        yield client


def _end_all(client: Any) -> None:
    """Have all workers take away what they are writing, and end."""
    asking = Thread(target=client.run, args=(_end,), kwargs={"on_error": "ignore"}, daemon=True)
    asking.start()
    asking.join(_TO_END)


def _end() -> None:
    undo_all()
    os._exit(1)


@contextmanager
def _quiet() -> Iterator[None]:
    """Have Dask keep its logs to itself: the outcomes of the tasks report the same."""
    log = logging.getLogger("distributed")
    before = log.level
    log.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        log.setLevel(before)


def _answer_on_worker(version: str, work: Callable[[Task], Answer], task: Task) -> Answer | TribopipeError:
    """Do a task as a worker, unless that is of another version than who asks."""
    if version != VERSION:
        return BatchError(
            f"found a worker with tribopipe {VERSION}; expected {version}, as on this machine; install the same version"
        )
    with _one_at_a_time:
        return answer_of(work, task)

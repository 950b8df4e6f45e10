"""Workers that are processes of this machine.

They begin as new interpreters, which all systems know, with one thread for linear algebra. They leave Ctrl-C to who
began them, and end with that process, however it ends: what they were writing is taken away.
"""

import multiprocessing
import os
import signal
import threading
import time
from _thread import interrupt_main
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection, wait
from typing import Any

from tribopipe.base.failures import in_a_sentence
from tribopipe.base.process_lifecycle import ONE_THREAD, inherited, undo_all
from tribopipe.base.tasks import REDONE, Answer, Task, answer_of, lost

_SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
_TO_END = 1.0
"""How long a worker may take to come out of what it computes once it has to end, s."""


class _Worker:
    """One process, to which tasks are sent and which sends answers back."""

    def __init__(self) -> None:
        start = multiprocessing.get_context("spawn")
        self.connection, theirs = start.Pipe()
        self._process = start.Process(target=_serve, args=(theirs,), daemon=True)
        with inherited(ONE_THREAD), _signals_held_back():
            self._process.start()
        theirs.close()

    def dismiss(self) -> None:
        """Let it end."""
        self.connection.close()

    def end(self) -> None:
        """Let it end, and wait until it has."""
        self.dismiss()
        self._process.join()


@dataclass(frozen=True)
class _Begun:
    """A task, and how many workers were lost over it."""

    work: Callable[[Any], Any]
    task: Any
    losses: int = 0


class Processes:
    """Processes of this machine, each begun with its first task."""

    def __init__(self, count: int) -> None:
        self._count = count
        self._idle: list[_Worker] = []
        self._busy: dict[Connection, tuple[_Worker, _Begun]] = {}

    def room(self) -> int:
        """Return how many of them have nothing to do."""
        return self._count - len(self._busy)

    def begin(self, work: Callable[[Task], Answer], task: Task) -> None:
        """Have a task done by one of those."""
        self._begin(_Begun(work, task))

    def is_busy(self) -> bool:
        """Return whether a task is not answered yet."""
        return bool(self._busy)

    def ended(self) -> Iterator[tuple[Any, Any]]:
        """Wait until tasks end, and return them with their answers."""
        for connection in wait(list(self._busy)):
            worker, begun = self._busy.pop(connection)  # type: ignore[call-overload]
            try:
                answer = worker.connection.recv()
            except (EOFError, OSError):
                worker.end()
                if begun.losses < REDONE:
                    self._begin(replace(begun, losses=begun.losses + 1))
                    continue
                answer = lost(begun.task)
            else:
                self._idle.append(worker)
            yield begun.task, answer

    def forget(self) -> None:
        """Wait until all have ended, and want no answer of them."""
        while self._busy:
            for _ in self.ended():
                pass

    def end(self) -> None:
        """End them, once they have done what they do."""
        self.forget()
        for worker in self._idle:
            worker.dismiss()
        while self._idle:
            self._idle.pop().end()

    def _begin(self, begun: _Begun) -> None:
        worker = self._idle.pop() if self._idle else _Worker()
        try:
            worker.connection.send((begun.work, begun.task))
        except OSError:  # it was lost while it had nothing to do
            worker.end()
            worker = _Worker()
            worker.connection.send((begun.work, begun.task))
        self._busy[worker.connection] = worker, begun


@contextmanager
def processes(count: int) -> Iterator[Processes]:
    """Give so many workers, which end with the block."""
    workers = Processes(count)
    try:
        yield workers
    finally:
        workers.end()


@contextmanager
def _signals_held_back() -> Iterator[None]:
    """Have processes that begin meanwhile get signals only once they know what to do then."""
    _let_through(_SIGNALS, through=False)
    try:
        yield
    finally:
        _let_through(_SIGNALS)


def _let_through(signals: list[signal.Signals], *, through: bool = True) -> None:
    """Let signals through to this thread, or hold them back, and from processes that it begins; Windows cannot."""
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK if through else signal.SIG_BLOCK, signals)


def _serve(connection: Connection) -> None:
    """Do tasks until there are no more."""
    for number in _SIGNALS:
        signal.signal(number, _end if number is signal.SIGTERM else signal.SIG_IGN)
    _let_through(_SIGNALS)
    threading.Thread(target=_end_with_who_began, daemon=True).start()
    with suppress(EOFError, OSError):  # there are no more, or who asked has ended
        while True:
            _send(connection, _next_answer(connection))
    os._exit(0)  # all is written: taking apart what was loaded would take as long as loading it


def _next_answer(connection: Connection) -> Any:
    try:
        work, task = connection.recv()
    except (ImportError, AttributeError) as error:  # what is sent by its name is not found here
        return in_a_sentence(error)
    return answer_of(work, task)


def _send(connection: Connection, answer: object) -> None:
    """Send an answer, or the one sentence why it cannot be sent."""
    try:
        connection.send(answer)
    except OSError:
        raise
    except Exception as error:  # noqa: BLE001 - whatever keeps it from being written down
        connection.send(in_a_sentence(error))


def _end_with_who_began() -> None:
    """Wait until the process that began this one has ended, and end this one too."""
    began = multiprocessing.parent_process()
    if began is not None:
        began.join()
        interrupt_main(signal.SIGTERM)
        time.sleep(_TO_END)  # what waits or computes outside Python sees to no signals
        _end()


def _end(*_: object) -> None:
    undo_all()
    os._exit(1)

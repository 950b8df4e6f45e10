"""Work in a process of its own, which is ended where it does not answer, and begun again where it ended by itself."""

import sys
from collections.abc import Callable
from contextlib import suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection
from types import TracebackType
from typing import Any, Self

_MEMORY = 4 << 30
"""Of address space, bytes; libraries reserve much of it without using it."""


class NoAnswerError(Exception):
    """The process ended, or had to be ended; the text says which."""


class Apart:
    """A process that answers one question after the other; what is asked of it and what it answers can be pickled."""

    def __init__(self, answer: Callable[[Any], Any], patience: float) -> None:
        self._answer, self._patience = answer, patience
        self._begin()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._end()

    def ask(self, question: Any) -> Any:
        """Return the answer. Raises ``NoAnswerError`` where there is none within the time that is waited."""
        self._ours.send(question)
        try:
            if self._ours.poll(self._patience):
                return self._ours.recv()
            why = "hangs"
        except EOFError:
            why = "ends the process"
        self._end()
        self._begin()
        raise NoAnswerError(why)

    def _begin(self) -> None:
        context = get_context("spawn")
        self._ours, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(self._answer, theirs), daemon=True)
        self._process.start()
        theirs.close()

    def _end(self) -> None:
        self._process.kill()
        self._process.join()
        self._ours.close()


def _serve(answer: Callable[[Any], Any], connection: Connection) -> None:
    if sys.platform != "win32":
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
    with suppress(EOFError):
        while True:
            connection.send(answer(connection.recv()))

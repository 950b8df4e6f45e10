"""One task, wherever it is done: what comes of it is an answer, or the one sentence why there is none."""

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

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
        f"{f'{name}: ' if name else ''}found {REDONE + 1} workers lost over it (killed, or out of memory); expected "
        "one to end; see whether memory is short, with fewer workers at once or one alone"
    )


def name_of(task: object) -> str:
    """Return what a task is called, as far as it is a name or a path."""
    return str(task) if isinstance(task, str | Path) else ""

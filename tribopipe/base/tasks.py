"""A task of a batch: how it is answered, and what workers of any kind do with it."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, Generic, NamedTuple, Protocol, TypeVar

from tribopipe.base.errors import BatchError, TribopipeError
from tribopipe.base.failures import in_a_sentence

Task = TypeVar("Task")
Answer = TypeVar("Answer")
REDONE = 3
"""How often a task is done again that loses its workers."""


class Numbered(NamedTuple, Generic[Task]):
    """A task with its place in its batch."""

    number: int
    task: Task


def numbered_answer(work: Callable[[Task], Answer], numbered: Numbered[Task]) -> Answer:
    """Do a task that has a number."""
    return work(numbered.task)


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
    if isinstance(task, Numbered):
        return name_of(task.task)
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

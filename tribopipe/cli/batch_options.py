"""Options of commands that do many things at once, and what is read of them."""

import os
import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple, TypeVar

import typer

from tribopipe.cli.output import say

if TYPE_CHECKING:
    from tribopipe.base.executor import Crew

T = TypeVar("T")
_LOCAL = "local"
_SHARD = re.compile(r"([0-9]{1,9})/([0-9]{1,9})")


class Part(NamedTuple):
    """Which part of a batch is done here."""

    number: int
    """From 1."""
    of: int

    def chosen(self, items: Sequence[T]) -> list[T]:
        """Return every n-th run, starting with the first of this part."""
        return list(items[self.number - 1 :: self.of])


def _part(text: str) -> Part:
    found = _SHARD.fullmatch(text)
    if found is None or not 1 <= int(found[1]) <= int(found[2]):
        raise typer.BadParameter(f"found {text!r}; expected i/n with i from 1 to n, such as 3/8")
    return Part(int(found[1]), int(found[2]))


Jobs = Annotated[
    int | None,
    typer.Option("-j", "--jobs", min=0, help="Number of parallel processes; 0 for all cores.", show_default="1"),
]
JobsOnAllCores = Annotated[
    int | None,
    typer.Option(
        "-j", "--jobs", min=0, help="Number of parallel processes; 0 for all cores.", show_default="all cores"
    ),
]
Scheduler = Annotated[
    str | None,
    typer.Option(
        "--scheduler",
        metavar="ADDRESS",
        help='Dask scheduler, such as tcp://10.0.0.1:8786, or "local" for one on this computer.',
    ),
]
Shard = Annotated[
    Part | None,
    typer.Option("--shard", parser=_part, metavar="I/N", help="Process only every n-th run, starting with the i-th."),
]


def crew(jobs: int | None, scheduler: str | None, usual: int = 1) -> "Crew":
    """Return who does a batch, with so many processes at once by default; 0 for as many as there are cores.

    Raises ``BadParameter`` for a number of jobs where a scheduler has its own workers.
    """
    from tribopipe.base.executor import Crew

    if jobs is not None and scheduler not in (None, _LOCAL):
        raise typer.BadParameter("found -j with a scheduler, which has its own workers; expected one of the two")
    if jobs is None:
        jobs = usual if scheduler is None else _cores()
    return Crew(jobs or _cores(), scheduler, say)


def seen_by(who: "Crew", path: Path) -> Path:
    """Return a path as the crew finds it: workers of a scheduler stand in folders of their own."""
    return path if who.scheduler is None else path.absolute()


def _cores() -> int:
    """Return the number of cores that the queueing system allows for this process."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1

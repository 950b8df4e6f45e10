"""What a case of these benchmarks is made of.

A case is a module with one function, which yields what is timed. It prepares each just before it yields it:

    def rows(setting: Setting) -> Iterator[Row]:
        path = write_table(setting.folder, setting.of(1_250_000, small=5_000))
        yield Pair("ingest", ours=…, peer=…, beside="pandas.read_csv and h5py", at_most=1.6)
        yield Growth("ingest", sizes=setting.decades(1_250_000, small=5_000), at=…, at_most=1.1)

`__main__.py` names the modules. Works are called without arguments, each as often as the others, in turn.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from own_process import Taken, taken

Work = Callable[[], object]
Clock = Callable[[], float]


@dataclass(frozen=True)
class Command:
    """A command to run: a work that tells its time and its peak memory itself."""

    words: Sequence[str]

    def __call__(self) -> Taken:
        """Run it. Raises ``CalledProcessError`` where it fails."""
        return taken(self.words)


@dataclass(frozen=True)
class Pair:
    """Something of ours beside what a user would run instead, or beside the least it could cost."""

    what: str
    ours: Work
    peer: Work
    beside: str
    """What the peer is."""
    scaled: float = 1.0
    """What the peer's time is multiplied by: it may do a share of the work only, which ``beside`` says then."""
    at_most: float | None = None
    """Bound of our time over the peer's."""
    allowance: float = 0.0
    """Time that ours may take beyond that bound, s."""
    at_least: float | None = None
    """Bound of how many times as fast we are as the peer."""
    repeats: int | None = None
    """The most repeats it is worth; as many as the command line says where that is not told."""
    clock: Clock = time.perf_counter
    """Wall time; ``time.process_time`` for what needs neither disk nor other processes, since others' work on the
    machine counts little there."""


@dataclass(frozen=True)
class Growth:
    """Something whose time should grow no faster than its size."""

    what: str
    sizes: Sequence[int]
    at: Callable[[int], Work]
    """Prepares the work of a size."""
    of: str = "samples"
    """What sizes are numbers of."""
    at_most: float | None = None
    """Bound of the exponent n of time ∝ sizeⁿ."""
    repeats: int | None = None
    clock: Clock = time.perf_counter


Row = Pair | Growth


def unbound(row: Row) -> Row:
    """Return a row for which nothing is asked."""
    return replace(row, at_most=None, at_least=None) if isinstance(row, Pair) else replace(row, at_most=None)


@dataclass(frozen=True)
class Setting:
    """Where a case runs, and how large."""

    folder: Path
    """Empty, and deleted afterwards."""
    small: bool = False
    """Whether everything is to end within seconds; nothing is held against a bound then."""
    earlier: Path | None = None
    """Work tree of an earlier commit to be held against, if any."""

    def of(self, full: int, *, small: int) -> int:
        """Return one of two sizes."""
        return small if self.small else full

    def decades(self, largest: int, *, small: int) -> list[int]:
        """Return four sizes over three decades."""
        return [self.of(largest, small=small) // 10**power for power in (3, 2, 1, 0)]

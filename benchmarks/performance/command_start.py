"""(g) Start of the command line beside the import of typer alone, the least it could cost."""

from collections.abc import Iterator

from case import Command, Pair, Row, Setting
from start_up import CASES


def rows(_: Setting) -> Iterator[Row]:
    """Yield the pair."""
    least, ours = CASES.items()
    yield Pair(ours[0], Command(ours[1]), Command(least[1]), beside=least[0])

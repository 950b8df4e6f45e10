"""(k) `tribopipe process` where every step was done before, compared with `tribopipe --version`.

It finds that nothing has changed by the stamps of files and the catalog of the archive.
"""

import sys
import time
from collections.abc import Iterator
from pathlib import Path

from case import Command, Pair, Row, Setting
from own_process import taken
from whole_line import COMMAND

sys.path.append(str(Path(__file__).parents[1] / "reliability"))

from short_runs import quick_recipe, short_runs

_SAMPLES = Path(__file__).parents[2] / "sample_runs"
_MANY, _FEW = 1000, 4
_UNTIL_STAMPS_COUNT = 3.0
"""How long after a change of a file its stamp may still be that of another change, s."""


def rows(setting: Setting) -> Iterator[Row]:
    """Yield the pairs."""
    version = Command([str(COMMAND), "--version"])
    if not setting.small:
        yield Pair(
            "`process` on the sample runs, nothing to do",
            _done(_SAMPLES, setting.folder / "samples"),
            version,
            "`tribopipe --version`",
            at_most=1.5,
            allowance=0.2,
        )
    count = setting.of(_MANY, small=_FEW)
    short_runs(setting.folder / "runs", count)
    plain = "-j", "2", "--no-figures", "--recipe", str(quick_recipe(setting.folder))
    yield Pair(
        f"`process` on {count} runs, nothing to do",
        _done(setting.folder / "runs", setting.folder / "many", *plain),
        version,
        "`tribopipe --version`",
        at_most=1.5,
        allowance=1.0,
    )


def _done(runs: Path, archive: Path, *options: str) -> Command:
    """Process these runs and return the same command again."""
    command = Command([str(COMMAND), "process", str(runs), "--archive", str(archive), *options])
    taken(command.words)
    time.sleep(_UNTIL_STAMPS_COUNT)
    taken(command.words)
    return command

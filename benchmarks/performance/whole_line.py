"""(h) `tribopipe process` of many runs, with two workers beside one, and how it grows with runs and with samples.

Each command starts anew, its workers too, and does all steps again (`--force`): ingest to wear fits, predictions and
figures. Growth is told without figures, whose time is the same for each run, and without Monte Carlo, of which case (d)
tells.
"""

import sys
from collections.abc import Iterator
from pathlib import Path

from case import Command, Growth, Pair, Row, Setting

sys.path.append(str(Path(__file__).parents[1] / "reliability"))

from short_runs import quick_recipe, short_runs

COMMAND = Path(sys.executable).with_name("tribopipe.exe" if sys.platform == "win32" else "tribopipe")
_RUNS, _FEW = 96, 4
_SHORTEST = 126
"""Samples of a run."""
_REPEATS, _REPEATS_OF_GROWTH = 3, 1


def rows(setting: Setting) -> Iterator[Row]:
    """Yield the pair, and growth in both directions."""
    count = setting.of(_RUNS, small=_FEW)
    runs = made(setting, count)
    yield Pair(
        f"`process` on {count} runs, two workers",
        ours=processed(setting, runs, "-j", "2"),
        peer=processed(setting, runs, "-j", "1"),
        beside="one worker",
        at_least=1.7,
        repeats=_REPEATS,
    )
    plain = "--no-figures", "--recipe", str(quick_recipe(setting.folder))
    yield Growth(
        "`process -j 2`",
        sizes=[1, 2] if setting.small else [1, 10, 100, 1000],
        at=lambda size: processed(setting, made(setting, size), "-j", "2", *plain),
        of="runs",
        at_most=1.1,
        repeats=_REPEATS_OF_GROWTH,
    )
    yield Growth(
        "`process` on one run",
        sizes=[size * _SHORTEST for size in ([1, 2] if setting.small else [1, 10, 100, 1000])],
        at=lambda size: processed(setting, made(setting, 1, times=size // _SHORTEST), *plain),
        at_most=1.1,
        repeats=_REPEATS,
    )


def made(setting: Setting, count: int, times: int = 1) -> Path:
    """Return a folder of so many runs, so many times as long as the shortest."""
    folder = setting.folder / f"runs-{count}-{times}"
    if not folder.exists():
        short_runs(folder, count, times)
    return folder


def processed(setting: Setting, runs: Path, *options: str) -> Command:
    """Return the command that does all steps of these runs, whether they were done before or not."""
    archive = setting.folder / f"archive-of-{runs.name}{''.join(options[:2])}"
    return Command([str(COMMAND), "process", str(runs), "--archive", str(archive), "--force", *options])

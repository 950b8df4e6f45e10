"""Start-up of the command line beside the least it could cost: of Python alone, and of the import of typer.

    python benchmarks/start_up.py

Prints the median wall time of each over alternating runs in this order, their ratio to Python alone, and that of --help
to the import of typer. Tab and `tribopipe` alone are timed in a folder with an archive of a thousand runs, which are
copies of one; Tab completes commands, and ids of runs, as bash asks for them.
"""

import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

RUNS = 1000
REPEATS = 25
COMMAND = Path(sys.executable).with_name("tribopipe.exe" if sys.platform == "win32" else "tribopipe")
SAMPLE = Path(__file__).parents[1] / "sample_runs" / "si3n4-air-200mN"


class Case(NamedTuple):
    """A command, and what stands in its environment."""

    command: list[str]
    variables: Mapping[str, str] = MappingProxyType({})


def tab(line: str) -> Case:
    """Return what bash runs when somebody presses Tab at the end of a line."""
    words = line.split(" ")
    told = {"COMP_WORDS": "\n".join(words), "COMP_CWORD": str(len(words) - 1)}
    return Case([str(COMMAND)], {"_TRIBOPIPE_COMPLETE": "complete_bash", **told})


PYTHON, TYPER, HELP = "python -c pass", 'python -c "import typer"', "tribopipe --help"
CASES = {TYPER: [sys.executable, "-c", "import typer"], HELP: [str(COMMAND), "--help"]}
TIMED = {
    PYTHON: Case([sys.executable, "-c", "pass"]),
    **{name: Case(command) for name, command in CASES.items()},
    "Tab after `tribopipe `": tab("tribopipe "),
    f"Tab after `tribopipe show `, {RUNS} runs": tab("tribopipe show "),
    f"tribopipe, {RUNS} runs": Case([str(COMMAND)]),
}


def wall_time(case: Case, folder: Path) -> float:
    """Run a command in a folder and return how long it took, s."""
    start = time.perf_counter()
    # All modules are compiled, as pip leaves them, whatever the environment says of that.
    compiled = {"PYTHONDONTWRITEBYTECODE": "", "PYTHONPYCACHEPREFIX": str(folder / "compiled")}
    told = {**os.environ, **compiled, **case.variables}
    subprocess.run(case.command, check=True, cwd=folder, env=told, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return time.perf_counter() - start


def fill(archive: Path) -> None:
    """Archive one run, copy it until there are as many as wanted, and have all of them listed once."""
    subprocess.run(
        [COMMAND, "ingest", SAMPLE, "--archive", archive],
        check=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    for number in range(1, RUNS):
        shutil.copyfile(archive / f"{SAMPLE.name}.h5", archive / f"run-{number}.h5")
    time.sleep(3)  # until no later change of a file could leave it looking the same
    subprocess.run(
        [COMMAND, "ls", "--archive", archive], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )


def main() -> None:
    """Time all in turn and print medians and ratios."""
    times: dict[str, list[float]] = {name: [] for name in TIMED}
    with tempfile.TemporaryDirectory() as folder:
        fill(Path(folder) / "archive")
        for _ in range(REPEATS + 1):
            for name, case in TIMED.items():
                times[name].append(wall_time(case, Path(folder)))
    medians = {name: statistics.median(taken[1:]) for name, taken in times.items()}
    for name, median in medians.items():
        print(f"{median * 1e3:7.1f} ms  {median / medians[PYTHON]:5.1f}  {name}")
    print(f"{medians[HELP] / medians[TYPER]:7.2f} times the import of typer for --help")


if __name__ == "__main__":
    main()

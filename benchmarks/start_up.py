"""Start-up of the command line beside the import of typer alone, the least it could cost.

    python benchmarks/start_up.py

Prints the median wall time of each over alternating runs in this order, and their ratio.
"""

import statistics
import subprocess
import sys
import time
from pathlib import Path

REPEATS = 25
COMMAND = Path(sys.executable).with_name("tribopipe.exe" if sys.platform == "win32" else "tribopipe")
CASES: dict[str, list[str]] = {
    'python -c "import typer"': [sys.executable, "-c", "import typer"],
    "tribopipe --help": [str(COMMAND), "--help"],
}


def wall_time(command: list[str]) -> float:
    """Run a command and return how long it took, s."""
    start = time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - start


def main() -> None:
    """Time both in turn and print medians and ratio."""
    times: dict[str, list[float]] = {name: [] for name in CASES}
    for _ in range(REPEATS):
        for name, command in CASES.items():
            times[name].append(wall_time(command))
    medians = {name: statistics.median(taken) for name, taken in times.items()}
    for name, median in medians.items():
        print(f"{median * 1e3:7.1f} ms  {name}")
    least, ours = medians.values()
    print(f"{ours / least:7.2f} times the import of typer")


if __name__ == "__main__":
    main()

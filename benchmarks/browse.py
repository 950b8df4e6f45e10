"""What the server of `tribopipe browse` takes to answer about a run of two million samples.

    python benchmarks/browse.py FOLDER

Records such a run on a virtual tribometer into FOLDER and takes it through the whole line, unless it is there already.
Prints how long the page of the run and its first plots took in a server just started, and the median of zooms.
"""

import statistics
import sys
import time
from http.client import HTTPConnection
from pathlib import Path
from random import Random

from tribopipe.archive.store import Archive
from tribopipe.browse.server import HOST, running
from tribopipe.pipeline import process
from tribopipe.records.base import load_toml
from tribopipe.records.plan import Plan
from tribopipe.simulate import simulate_plan

SAMPLES = Path(__file__).parent.parent / "sample_runs"
RUN = "si3n4-air-200mN"
LAST = 80_000
"""Distance that the run slides, m."""
ZOOMS = 20
PLOTS = ("wear", "depth", "friction", "signals")


def long_archive(folder: Path) -> Path:
    """Return an archive of the lightest sample run, 160 times as long: two million samples."""
    archive = folder / "archive"
    if not (archive / f"{RUN}.h5").exists():
        text = (SAMPLES / "plan.toml").read_text(encoding="utf-8")
        first = text.partition('[[series.runs]]\nid = "si3n4-air-400mN"')[0]
        plan = folder / "plan.toml"
        plan.write_text(first.replace('sliding_distance = "500 m"', f'sliding_distance = "{LAST} m"'), encoding="utf-8")
        simulate_plan(load_toml(plan, Plan), folder / "runs")
        print(*(outcome.error for outcome in process([folder / "runs" / RUN], Archive(archive)) if outcome.error))
    return archive


def answer_time(port: int, target: str) -> tuple[float, int]:
    """Ask, and return how long the whole answer took, s, and its bytes."""
    connection = HTTPConnection(HOST, port)
    start = time.perf_counter()
    connection.request("GET", target)
    answer = connection.getresponse()
    body = answer.read()
    taken = time.perf_counter() - start
    connection.close()
    if answer.status != 200:
        raise SystemExit(f"{target}: {body[:300]!r}")
    return taken, len(body)


def time_plots(port: int) -> None:
    """Time the page of the run and each of its plots, first whole, then at random zooms."""
    random = Random(1)  # noqa: S311, no secret
    for what, target in {"list of runs": "/api/runs", "page of the run": f"/api/runs/{RUN}"}.items():
        taken, size = answer_time(port, target)
        print(f"{taken * 1e3:7.0f} ms  {what} ({size / 1e3:.0f} kB)")
    for plot in PLOTS:
        target = f"/api/runs/{RUN}/plots/{plot}?width=1200"
        first, size = answer_time(port, target)
        zooms = []
        for _ in range(ZOOMS):
            start, end = sorted(random.uniform(0, LAST) for _ in range(2))
            zooms.append(answer_time(port, f"{target}&from={start}&to={end}")[0])
        print(
            f"{first * 1e3:7.0f} ms  {plot}, first ({size / 1e3:.0f} kB); zooms: median "
            f"{statistics.median(zooms) * 1e3:.0f} ms, longest {max(zooms) * 1e3:.0f} ms"
        )


def main() -> None:
    """Make the archive, and time what the server answers about it."""
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    with running(long_archive(folder)) as port:
        time_plots(port)


if __name__ == "__main__":
    main()

"""What `tribopipe browse` takes to show a table of thousands of runs, and a run of two million samples.

    python benchmarks/browse.py --write docs/results/browse.md

The marks to hold: the table of 5000 runs can be used within 2 s, the first plot of 2,000,000 samples is seen within
2 s, and each zoom takes the server less than 300 ms. The catalogue is there, as when `tribopipe browse` says its
address; each page is opened in a Chromium that has seen nothing yet, by a server that was started at that moment.
`--keep FOLDER` keeps the archives for the next time.
"""

import shutil
import statistics
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from http.client import HTTPConnection
from pathlib import Path
from random import Random

from labs import Report, arguments
from many_runs import many_runs
from playwright.sync_api import Browser, Page, sync_playwright

from tribopipe.archive.catalog.catalog import Catalogue
from tribopipe.archive.store import Archive
from tribopipe.browse.server import HOST, Site, running
from tribopipe.documents.plan import Plan
from tribopipe.documents.record import load_toml
from tribopipe.extras.simulate import simulate_plan
from tribopipe.pipeline.stages import process

SAMPLES = Path(__file__).parent.parent / "sample_runs"
RUN = "si3n4-air-200mN"
RATE = 25
"""Samples in a metre."""
ZOOMS = 20
PLOTS = ("wear", "depth", "friction", "signals")
REPEATS = 5
USABLE, FIRST_PLOT, ZOOM = 2.0, 2.0, 0.3
"""Marks, s."""
_QUIET = ["--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-component-update"]


def table_archive(folder: Path, runs: int) -> Path:
    """Return an archive of so many runs, with its catalogue."""
    if not folder.exists():
        many_runs(folder, runs)
    Catalogue(folder).refresh()
    return folder


def long_archive(folder: Path, samples: int) -> Path:
    """Return an archive of the lightest sample run that slid until there were so many samples."""
    archive, end = folder / "archive", samples // RATE
    if not (archive / f"{RUN}.h5").exists():
        folder.mkdir(parents=True, exist_ok=True)
        text = (SAMPLES / "plan.toml").read_text(encoding="utf-8")
        first = text.partition('[[series.runs]]\nid = "si3n4-air-400mN"')[0]
        plan = folder / "plan.toml"
        plan.write_text(first.replace('sliding_distance = "500 m"', f'sliding_distance = "{end} m"'), encoding="utf-8")
        simulate_plan(load_toml(plan, Plan), folder / "runs")
        failed = [outcome.error for outcome in process([folder / "runs" / RUN], Archive(archive)) if outcome.error]
        if failed:
            raise SystemExit(str(failed[0]))
    Catalogue(archive).refresh()
    return archive


def answer_time(site: Site, target: str) -> float:
    """Ask, and return how long the whole answer took, s."""
    connection = HTTPConnection(HOST, site.port)
    start = time.perf_counter()
    connection.request("GET", target, headers=site.headers)
    answer = connection.getresponse()
    body = answer.read()
    taken = time.perf_counter() - start
    connection.close()
    if answer.status != 200:
        raise SystemExit(f"{target}: {body[:300]!r}")
    return taken


@contextmanager
def chromium() -> Iterator[Browser]:
    """Start Chromium without a window. Ends the benchmark where there is none."""
    found = shutil.which("chromium") or shutil.which("google-chrome")
    if found is None:
        raise SystemExit("found no Chromium on PATH; expected one to look at the pages with; install it")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=found, args=_QUIET)
        yield browser
        browser.close()


def opening_times(browser: Browser, archive: Path, path: str, there: str) -> list[float]:
    """Return how long a page of a server just started takes until something is there, s, several times."""
    times = []
    for _ in range(REPEATS):
        with running(archive) as site:
            page = browser.new_context().new_page()
            start = time.perf_counter()
            page.goto(site.address(path))
            page.wait_for_selector(there)
            times.append(time.perf_counter() - start)
            page.context.close()
    return times


def search_time(browser: Browser, archive: Path) -> float:
    """Return how long the table takes to follow what is typed into its search, s."""
    with running(archive) as site:
        page: Page = browser.new_page()
        page.goto(site.address())
        page.wait_for_selector("tbody tr.run")
        start = time.perf_counter()
        page.get_by_label("Search", exact=True).fill("DLC water")
        page.wait_for_function("document.querySelector('[role=status] strong').textContent.length < 4")
        taken = time.perf_counter() - start
        page.close()
    return taken


def plot_times(site: Site, plot: str, end: int) -> tuple[float, list[float]]:
    """Return what the server takes for a plot of the whole run, and for random parts of it, s."""
    random, target = Random(1), f"/api/runs/{RUN}/plots/{plot}?width=1200"  # noqa: S311, no secret
    first = answer_time(site, target)
    parts = [sorted(random.uniform(0, end) for _ in range(2)) for _ in range(ZOOMS)]
    return first, [answer_time(site, f"{target}&from={start}&to={stop}") for start, stop in parts]


def time_table(report: Report, browser: Browser, archive: Path, runs: int) -> bool:
    """Report on the table of runs, and return whether its mark is held."""
    usable = statistics.median(opening_times(browser, archive, "/", "tbody tr.run"))
    with running(archive) as site:
        revisions = [answer_time(site, "/api/revision") for _ in range(ZOOMS)]
    rows = [
        [f"display the table of {runs:,} runs", f"{usable:.2f} s", f"{USABLE:g} s"],
        ["update the table after a search", f"{search_time(browser, archive):.2f} s", "–"],
        ["check for changes on the server, every 3 s", f"{statistics.median(revisions) * 1e3:.0f} ms", "–"],
    ]
    report.table(["Operation", "Time", "Limit"], rows)
    return usable < USABLE


def time_long_run(report: Report, browser: Browser, archive: Path, samples: int) -> bool:
    """Report on the page of the long run, and return whether its marks are held."""
    seen = statistics.median(opening_times(browser, archive, f"/runs/{RUN}", ".uplot canvas"))
    report.table(
        ["Operation", "Time", "Limit"],
        [[f"display the first plot of {samples:,} samples", f"{seen:.2f} s", f"{FIRST_PLOT:g} s"]],
    )
    with running(archive) as site:
        times = {plot: plot_times(site, plot, samples // RATE) for plot in PLOTS}
    report.table(
        ["Plot (server time)", "first", "zoom, median", f"zoom, longest of {ZOOMS}"],
        [
            [plot, *(f"{taken * 1e3:.0f} ms" for taken in (first, statistics.median(zooms), max(zooms)))]
            for plot, (first, zooms) in times.items()
        ],
    )
    return seen < FIRST_PLOT and max(max(zooms) for _, zooms in times.values()) < ZOOM


def main() -> None:
    """Make the archives, look at them, and hold the times against the marks."""
    parser = arguments(__doc__ or "")
    parser.add_argument("--runs", type=int, default=5000, help="runs in the table (%(default)s)")
    parser.add_argument("--samples", type=int, default=2_000_000, help="samples of the long run (%(default)s)")
    parser.add_argument("--keep", type=Path, default=None, help="folder in which the archives stay")
    options = parser.parse_args()
    report = Report("A large archive in the web browser", options)
    with tempfile.TemporaryDirectory() as scratch, chromium() as browser:
        folder: Path = options.keep or Path(scratch)
        held = [
            time_table(report, browser, table_archive(folder / "many", options.runs), options.runs),
            time_long_run(report, browser, long_archive(folder / "long", options.samples), options.samples),
        ]
    report.say("All limits are met." if all(held) else "A limit is NOT MET.")
    report.finish()


if __name__ == "__main__":
    main()

"""The screenshots in the documentation: `python docs/make_screenshots.py` takes them in Chromium before it is built.

They show `tribopipe browse` on what the tutorial archives: three pins of Si3N4, and the study of them. None is
committed; each build takes them anew, so that they show the pages as they are.
"""

import shutil
from pathlib import Path
from tempfile import TemporaryDirectory

from playwright.sync_api import Page, sync_playwright

from tribopipe.archive.store import Archive
from tribopipe.browse.server import running
from tribopipe.documents.recipe import Recipe
from tribopipe.pipeline.stages import process
from tribopipe.pipeline.studies import load_studies, run_study

SCREENSHOTS = Path(__file__).parent / "screenshots"
SAMPLES = Path(__file__).parents[1] / "sample_runs"
RUN, OTHER, STUDY = "si3n4-air-200mN", "si3n4-air-400mN", "si3n4-air"
PAGES = {
    "tutorial-runs": ("", 1320, 340),
    "tutorial-run": (f"runs/{RUN}", 1200, 1144),
    "tutorial-study": (f"studies/{STUDY}", 1200, 1266),
    "scatter": ("scatter?x=load&y=k_d", 1200, 821),
    "compare": (f"compare?runs={RUN},{OTHER}", 1200, 821),
    "viewer": (f"file?file={RUN}.h5", 1200, 750),
}
"""Names of the pictures, what is on them, and how wide and high they are, in pixels: each ends where a card ends."""


def main() -> None:
    """Archive the runs of the tutorial, and take a picture of each page."""
    SCREENSHOTS.mkdir(exist_ok=True)
    with TemporaryDirectory() as folder:
        fill(Archive(Path(folder) / "archive"))
        with running(Path(folder) / "archive") as site, sync_playwright() as playwright:
            chromium = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
            page = chromium.new_page(color_scheme="light")
            for name, (address, width, height) in PAGES.items():
                page.set_viewport_size({"width": width, "height": height})
                page.goto(site.address(f"/{address}"))
                take(page, SCREENSHOTS / f"{name}.png")


def fill(archive: Archive) -> None:
    """Take three sample runs and their study through the whole line."""
    outcomes = [*process(sorted(SAMPLES.glob(f"{STUDY}-*")), archive)]
    for study in load_studies([SAMPLES / f"{STUDY}.study.toml"]):
        outcomes += run_study(archive, study, Recipe())
    for outcome in outcomes:
        if outcome.error is not None:
            raise outcome.error


def take(page: Page, path: Path) -> None:
    """Take a picture of a page once nothing on it is loading."""
    page.wait_for_load_state("networkidle")
    page.wait_for_function("document.querySelectorAll('[aria-busy=true]').length === 0")
    page.screenshot(path=path)


if __name__ == "__main__":
    main()

"""A server started as a user starts it, and Chromium to look at it, for tests and benchmarks of `tribopipe browse`."""

import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Browser, Page, sync_playwright

_NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome", "msedge")
_QUIET = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
)
"""The last four keep it from talking to anybody but the page's own server."""


def chromium() -> str | None:
    """Return where this machine's Chromium is; none where it has none."""
    return next((found for name in _NAMES if (found := shutil.which(name))), None)


@contextmanager
def served(archive: Path) -> Iterator[str]:
    """Run `tribopipe browse` on an archive, and say where it listens."""
    command = [sys.executable, "-m", "tribopipe.cli.app", "browse", "--archive", str(archive), "--no-browser"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, encoding="utf-8")
    try:
        yield _address(process)
    finally:
        process.terminate()
        process.wait(10)
        assert process.stderr is not None
        process.stderr.close()


def _address(process: "subprocess.Popen[str]") -> str:
    assert process.stderr is not None
    for line in process.stderr:
        if found := re.search(r"http://127\.0\.0\.1:\d+", line):
            return found.group()
    raise AssertionError("the server ended without saying where it listens")


@contextmanager
def browser() -> Iterator[Browser]:
    """Start Chromium without a window."""
    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=chromium(), args=list(_QUIET))
        yield started
        started.close()


def complaints(page: Page) -> list[str]:
    """Return a list that fills with what the console warns of, and with errors that nobody caught.

    What a graphics driver made of software says of its own speed is no complaint about the page.
    """
    heard: list[str] = []

    def hear(kind: str, text: str) -> None:
        if kind in ("error", "warning") and "GL Driver Message" not in text:
            heard.append(text)

    page.on("console", lambda said: hear(said.type, said.text))
    page.on("pageerror", lambda error: heard.append(str(error)))
    return heard

"""Chromium, to look at the pages of `tribopipe browse`."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager

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

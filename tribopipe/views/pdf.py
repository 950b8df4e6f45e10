"""A page as PDF, printed by a browser that is installed: Chromium, Chrome or Edge."""

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from tribopipe.base.errors import TribopipeError

_ON_PATH = (
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "chrome",
    "microsoft-edge",
    "msedge",
)
_ELSEWHERE = {
    "win32": ("Google/Chrome/Application/chrome.exe", "Microsoft/Edge/Application/msedge.exe"),
    "darwin": (
        "Google Chrome.app/Contents/MacOS/Google Chrome",
        "Chromium.app/Contents/MacOS/Chromium",
        "Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
    ),
}
"""Where installers put browsers that no PATH names, below the folders of programs."""
_LONGEST = 180
"""How long a browser may take, s."""


def printed(document: str) -> bytes:
    """Return an HTML document that loads nothing as PDF.

    Raises
    ------
    TribopipeError
        Where no browser is installed, or it does not print.
    """
    browser = next(_browsers(), None)
    if browser is None:
        raise TribopipeError(
            "report: found no Chromium, Chrome or Edge; expected one of them to make the PDF; install one, or leave "
            "out --pdf and print the HTML file from any browser"
        )
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        page, pdf = Path(folder, "report.html"), Path(folder, "report.pdf")
        page.write_text(document, encoding="utf-8")
        words = [
            browser,
            "--headless",
            "--disable-gpu",
            "--no-first-run",
            "--no-pdf-header-footer",
            f"--user-data-dir={Path(folder, 'profile')}",
            *(
                ["--no-sandbox"] if getattr(os, "geteuid", lambda: 1)() == 0 else []
            ),  # as which it does not start otherwise
            f"--print-to-pdf={pdf}",
            page.as_uri(),
        ]
        try:
            done = subprocess.run(words, capture_output=True, timeout=_LONGEST, check=False)  # noqa: S603, none of a shell
        except subprocess.TimeoutExpired:
            raise TribopipeError(f"report: {browser} took over {_LONGEST} s to print; leave out --pdf") from None
        if not pdf.is_file():
            last = (done.stderr.decode("utf-8", "replace").splitlines() or ["no message"])[-1]
            raise TribopipeError(f"report: {browser} printed nothing ({last}); leave out --pdf and print the HTML file")
        return pdf.read_bytes()


def _browsers() -> Iterator[str]:
    yield from (found for name in _ON_PATH if (found := shutil.which(name)))
    folders = [os.environ.get(name, "") for name in ("PROGRAMFILES", "PROGRAMFILES(X86)", "LOCALAPPDATA")]
    for folder in folders if sys.platform == "win32" else ["/Applications"]:
        for name in _ELSEWHERE.get(sys.platform, ()):
            if (path := Path(folder, name)).is_file():
                yield str(path)

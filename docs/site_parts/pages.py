"""Which reference pages there are."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

from site_parts.archive_layout import archive_page
from site_parts.commands import commands_page
from site_parts.documents import DOCUMENTS, document_page, results_page
from site_parts.python_api import python_page, types_page
from site_parts.quantities import quantities_page
from site_parts.questions import questions_page

PAGES: dict[str, Callable[[], str]] = {
    "commands": commands_page,
    "quantities": quantities_page,
    "questions": questions_page,
    **{name: partial(document_page, name) for name in DOCUMENTS},
    "results": results_page,
    "archive": archive_page,
    "python": python_page,
    "python_types": types_page,
}


def write_reference(docs: Path) -> None:
    """Write each page into docs/reference, where it is not there as it should be already; take away any other."""
    folder = docs / "reference"
    folder.mkdir(exist_ok=True)
    for path in folder.glob("*.md"):
        if path.stem not in PAGES:
            path.unlink()
    for name, page in PAGES.items():
        path, text = folder / f"{name}.md", page()
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8", newline="\n")

"""Whether built pages can be read where there is no network."""

import re
from pathlib import Path

from sphinx.errors import ExtensionError

_LOADED = re.compile(r'<(?:script|link|img|iframe|source)\b[^>]*\b(?:src|href)="(https?:)?//[^"]*"')


def refuse_network(built: Path) -> None:
    """Raise ``ExtensionError`` where a built page would load something from the network."""
    for page in sorted(built.rglob("*.html")):
        found = _LOADED.search(page.read_text(encoding="utf-8"))
        if found is not None:
            raise ExtensionError(f"{page}: found {found.group()}; expected pages that load nothing from the network")

"""Screenshots where they were taken: `python docs/make_screenshots.py` needs a browser, which not everybody has."""

import re
from pathlib import Path

_SHOWN = re.compile(r"!\[([^]]*)\]\((screenshots/[\w-]+\.png)\)")


def as_far_as_taken(text: str, docs: Path) -> str:
    """Return a page's text, with its words in the place of each screenshot that was not taken."""
    return _SHOWN.sub(lambda shown: shown[0] if (docs / shown[2]).is_file() else f"*{shown[1]}*", text)

"""The documentation as it comes with the package: pages by name, and the text on each error and finding by code."""

import re
from functools import cache
from pathlib import Path

from tribopipe.shipped import shipped

_MESSAGES = "messages"
_OF_THE_SITE = {"index", "changelog", "contributing", "evidence"}
"""Pages that show others."""
_COMMENT = re.compile(r"<!--.*?(?:-->\n?|\Z)", re.DOTALL)
_SECTION = re.compile(r"^### (\S+)\n", re.MULTILINE)
_NEXT_PART = re.compile(r"^## ", re.MULTILINE)


@cache
def sections() -> dict[str, str]:
    """Return the manual entry of each error and finding code, as Markdown.

    Raises ``InternalError`` where the pages were not installed.
    """
    _, *found = _SECTION.split(page(_MESSAGES))
    return {code: _NEXT_PART.split(said)[0].strip() for code, said in zip(found[::2], found[1::2], strict=True)}


def pages() -> list[str]:
    """Return the names of the pages. Raises ``InternalError`` where they were not installed."""
    return sorted({path.stem for path in _folder().glob("*.md")} - _OF_THE_SITE)


def page(name: str) -> str:
    """Return a page as Markdown, without its notes for tests."""
    return _COMMENT.sub("", (_folder() / f"{name}.md").read_text(encoding="utf-8")).lstrip()


def title(name: str) -> str:
    """Return the title of a page."""
    return page(name).partition("\n")[0].lstrip("# ")


def pages_about(words: str) -> list[str]:
    """Return the names of the pages with some words: first those with them in a heading, then those with them often."""
    sought = re.compile(rf"(?<!\w){re.escape(words)}(?!\w)", re.IGNORECASE)
    found = {}
    for name in pages():
        text = page(name)
        headings = [line for line in text.splitlines() if line.startswith("#")]
        found[name] = (len(sought.findall("\n".join(headings))), len(sought.findall(text)))
    return sorted((name for name, counts in found.items() if any(counts)), key=lambda name: found[name], reverse=True)


def links(codes: list[str]) -> list[str]:
    """Return where the site has the sections of some codes; nothing as long as the package names no site."""
    from importlib.metadata import PackageNotFoundError, metadata

    try:
        named = metadata("tribopipe").get_all("Project-URL") or []
    except PackageNotFoundError:
        return []
    sites = [site.partition(",")[2].strip().rstrip("/") for site in named if site.startswith("Documentation,")]
    return [f"{site}/{_MESSAGES}.html#{code.replace('_', '-')}" for site in sites for code in codes]


def _folder() -> Path:
    return shipped(f"docs/{_MESSAGES}.md").parent

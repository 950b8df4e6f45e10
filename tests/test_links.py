import json
import re
from itertools import pairwise
from pathlib import Path
from urllib.parse import unquote

import pytest
from markdown_it import MarkdownIt

REPOSITORY = Path(__file__).parents[1]
DOCS = REPOSITORY / "docs"
GENERATED = {DOCS / f"{name}.md" for name in re.findall(r"\breference/\w+", (DOCS / "index.md").read_text("utf-8"))}
"""Pages that the build of the documentation makes; it looks after links into them itself."""
PAGES = sorted(
    page
    for folder in (REPOSITORY, DOCS, DOCS / "results", REPOSITORY / "sample_runs")
    for kind in ("*.md", "*.ipynb")
    for page in folder.glob(kind)
)
MADE_BY_THE_BUILD = DOCS / "screenshots"


def text_of(page: Path) -> str:
    text = page.read_text("utf-8")
    if page.suffix != ".ipynb":
        return text
    return "\n\n".join("".join(cell["source"]) for cell in json.loads(text)["cells"] if cell["cell_type"] == "markdown")


def links(page: Path) -> set[str]:
    """Return where a page links to within the repository."""
    found = set()
    for token in MarkdownIt().parse(text_of(page)):
        for part in token.children or ():
            found.add(str(part.attrGet("href") or part.attrGet("src") or ""))
    return {link for link in found if link and not re.match(r"\w+:", link)}


def headings(page: Path) -> set[str]:
    """Return by what headings of a page are linked to, as GitHub and MyST have it."""
    tokens = MarkdownIt().parse(text_of(page))
    titles = [after.children or () for token, after in pairwise(tokens) if token.type == "heading_open"]
    written = ("".join(part.content for part in title).strip().lower() for title in titles)
    return {re.sub(r"[^\w\- ]", "", title).replace(" ", "-") for title in written}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(REPOSITORY).as_posix())
def test_links_lead_somewhere(page):
    for link in links(page):
        path, _, heading = unquote(link).partition("#")
        target = (page.parent / path).resolve() if path else page
        if target in GENERATED or target.parent == MADE_BY_THE_BUILD:
            continue
        assert target.exists(), f"{page.name} links to {link}, which is not there"
        assert target.is_relative_to(REPOSITORY), f"{page.name} links to {link}, outside the repository"
        if heading:
            assert heading in headings(target), f"{page.name} links to {link}, where no such heading is"


def test_there_are_pages():
    assert len(PAGES) > 40
    assert len(GENERATED) > 10

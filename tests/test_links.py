import json
import re
from itertools import pairwise
from pathlib import Path
from urllib.parse import unquote, urlsplit

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
SHOWN_ON_THE_SITE = [REPOSITORY / "CHANGELOG.md", REPOSITORY / "CONTRIBUTING.md"]
ELSEWHERE = {
    "doi.org",
    "filesystem-spec.readthedocs.io",
    "github.com",
    "h5web.panosc.eu",
    "jobqueue.dask.org",
    "kubernetes.dask.org",
    "orcid.org",
    "www.astm.org",
    "py-filelock.readthedocs.io",
    "qudt.org",
    "ror.org",
    "s3fs.readthedocs.io",
    "semver.org",
    "www.nexusformat.org",
    "www.researchobject.org",
}
"""Sites that pages may link to: few, and such as stay where they are."""


def text_of(page: Path) -> str:
    text = page.read_text("utf-8")
    if page.suffix != ".ipynb":
        return text
    return "\n\n".join("".join(cell["source"]) for cell in json.loads(text)["cells"] if cell["cell_type"] == "markdown")


def all_links(page: Path) -> set[str]:
    """Return where a page links to."""
    found = set()
    for token in MarkdownIt().parse(text_of(page)):
        for part in token.children or ():
            found.add(str(part.attrGet("href") or part.attrGet("src") or ""))
    return found - {""}


def links(page: Path) -> set[str]:
    """Return where a page links to within the repository."""
    return {link for link in all_links(page) if not re.match(r"\w+:", link)}


def headings(page: Path) -> set[str]:
    """Return by what headings of a page, or of the one that it shows, are linked to, as GitHub and MyST have it."""
    if shown := re.match(r"```{include} (\S+)", text_of(page)):
        return headings(page.parent / shown[1])
    tokens = MarkdownIt().parse(text_of(page))
    titles = [after.children or () for token, after in pairwise(tokens) if token.type == "heading_open"]
    written = ("".join(part.content for part in title).strip().lower() for title in titles)
    return {re.sub(r"[^\w\- ]", "", title).replace(" ", "-") for title in written}


@pytest.mark.slow
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


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(REPOSITORY).as_posix())
def test_links_to_elsewhere_are_few_and_well_formed(page):
    for link in all_links(page) - links(page):
        site = urlsplit(link)
        assert site.scheme == "https", f"{page.name} links to {link}; expected https"
        assert site.hostname in ELSEWHERE, f"{page.name} links to {link}, which ELSEWHERE does not name"


@pytest.mark.parametrize("page", SHOWN_ON_THE_SITE, ids=lambda page: page.name)
def test_pages_shown_on_the_site_link_into_docs_alone(page):
    assert {link for link in links(page) if not link.startswith(("docs/", "#"))} == set()


@pytest.mark.parametrize("page", sorted(DOCS.glob("*.md")), ids=lambda page: page.name)
def test_pages_of_the_site_link_to_no_page_above_it(page):
    above = {link for link in links(page) if re.match(r"\.\./\w+\.md", link)}
    assert above == set(), f"{page.name} links to {above}; expected the page of docs/ that shows it"


def test_there_are_pages():
    assert len(PAGES) > 40
    assert len(GENERATED) > 10

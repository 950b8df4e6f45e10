"""The page of questions, by which the site's search finds pages that use other words."""

import json
from collections.abc import Iterator

from site_parts.markdown import code, plain, titled
from tribopipe.cli.documentation import ENDINGS, PASSED_OVER, SHORTEST, Entry, entries, title, weights


def questions_page() -> str:
    """Return the page: each question a heading, under it the answer, the command, and the page to read."""
    return titled(1, "Questions") + "".join(part for name, one in entries().items() for part in _answers(name, one))


def _answers(name: str, one: Entry) -> Iterator[str]:
    command = f" {code(one.command)}" if one.command else ""
    for question in one.questions:
        yield titled(2, plain(question))
        yield f"{plain(one.answer)}{command}\n\nRead [{plain(title(name))}](../{name}.md).\n\n"
    yield f"Also: {plain(one.words)}.\n\n"


def questions_json() -> str:
    """Return by what the site's search finds the page that answers a question, for _static/questions.js_t."""
    return json.dumps(
        {"weights": weights(), "endings": ENDINGS, "shortest": SHORTEST, "passed_over": sorted(PASSED_OVER)}
    )

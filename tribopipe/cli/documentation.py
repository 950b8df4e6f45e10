"""The documentation in the package: pages, texts on errors and findings, and answers to questions.

docs/questions.toml has for each page a one-line answer, a command, questions, and other words for what it is about. A
page is as close to a question as it has words of it; a word counts for more, the fewer pages have it.
"""

import re
import tomllib
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from math import log
from pathlib import Path

from tribopipe.shipped import shipped

_MESSAGES = "messages"
_OF_THE_SITE = {"index", "changelog", "contributing", "evidence"}
"""Pages that list others."""
_COMMENT = re.compile(r"<!--.*?(?:-->\n?|\Z)", re.DOTALL)
_SECTION = re.compile(r"^### (\S+)\n", re.MULTILINE)
_NEXT_PART = re.compile(r"^## ", re.MULTILINE)


@cache
def sections() -> dict[str, str]:
    """Return the manual entry of each error and finding code, as Markdown.

    Raises ``InternalError`` if the pages are not installed.
    """
    _, *found = _SECTION.split(page(_MESSAGES))
    return {code: _NEXT_PART.split(said)[0].strip() for code, said in zip(found[::2], found[1::2], strict=True)}


def pages() -> list[str]:
    """Return the names of the pages. Raises ``InternalError`` if they are not installed."""
    return sorted({path.stem for path in _folder().glob("*.md")} - _OF_THE_SITE)


def page(name: str) -> str:
    """Return a page as Markdown, without its notes for tests."""
    return _COMMENT.sub("", (_folder() / f"{name}.md").read_text(encoding="utf-8")).lstrip()


def title(name: str) -> str:
    """Return the title of a page."""
    return page(name).partition("\n")[0].lstrip("# ")


def pages_about(words: str) -> list[str]:
    """Return the pages that contain some words: first those with the words in a heading, then by occurrences."""
    sought = re.compile(rf"(?<!\w){re.escape(words)}(?!\w)", re.IGNORECASE)
    found = {}
    for name in pages():
        text = page(name)
        headings = [line for line in text.splitlines() if line.startswith("#")]
        found[name] = (len(sought.findall("\n".join(headings))), len(sought.findall(text)))
    return sorted((name for name, counts in found.items() if any(counts)), key=lambda name: found[name], reverse=True)


def links(codes: list[str]) -> list[str]:
    """Return the addresses of the sections on some codes; nothing if the package does not specify a site."""
    from importlib.metadata import PackageNotFoundError, metadata

    try:
        named = metadata("tribopipe").get_all("Project-URL") or []
    except PackageNotFoundError:
        return []
    sites = [site.partition(",")[2].strip().rstrip("/") for site in named if site.startswith("Documentation,")]
    return [f"{site}/{_MESSAGES}.html#{code.replace('_', '-')}" for site in sites for code in codes]


def _folder() -> Path:
    return shipped(f"docs/{_MESSAGES}.md").parent


_FILE = "docs/questions.toml"
_WORD = re.compile(r"±|[^\W_]+(?:_[^\W_]+)*")
ENDINGS = ("ing", "ed", "es", "s", "e")
SHORTEST = 3
"""Smallest number of letters left when the ending of a word is removed."""
PASSED_OVER = frozenset(
    [
        "a",
        "about",
        "an",
        "and",
        "any",
        "are",
        "as",
        "at",
        "be",
        "by",
        "can",
        "do",
        "does",
        "for",
        "from",
        "get",
        "has",
        "have",
        "how",
        "i",
        "if",
        "in",
        "into",
        "is",
        "it",
        "its",
        "me",
        "my",
        "of",
        "on",
        "or",
        "our",
        "so",
        "that",
        "the",
        "their",
        "them",
        "there",
        "they",
        "this",
        "to",
        "up",
        "use",
        "used",
        "using",
        "was",
        "we",
        "what",
        "when",
        "where",
        "which",
        "who",
        "why",
        "will",
        "with",
        "you",
        "your",
    ]
)
_SIMILAR = 0.8
"""Similarity at which an unknown word counts as one of the entries, so that typing errors do not matter."""
_AGAIN = 0.3
"""Weight of a second mention in the same entry, relative to the first."""


@dataclass(frozen=True, kw_only=True)
class Entry:
    """Content of a page, for answering questions."""

    answer: str
    """One or two sentences."""
    command: str | None = None
    """Command to type."""
    questions: Sequence[str]
    words: str
    """Other words for the same content."""


@cache
def entries() -> dict[str, Entry]:
    """Return the entries by the names of their pages. Raises ``InternalError`` if they are not installed."""
    with shipped(_FILE).open("rb") as file:
        return {name: Entry(**entry) for name, entry in tomllib.load(file).items()}


@cache
def weights() -> dict[str, dict[str, float]]:
    """Return the weight of each stem for each page that contains it, by the stem and the name of the page."""
    counts = {name: Counter(stems(" ".join((*one.questions, one.words)))) for name, one in entries().items()}
    pages_with = Counter(stem for count in counts.values() for stem in count)
    found: dict[str, dict[str, float]] = {}
    for name, count in counts.items():
        for one, times in count.items():
            rare = log(len(counts) / pages_with[one])
            found.setdefault(one, {})[name] = round(rare * (1 + _AGAIN * min(times - 1, 2)), 3)
    return found


def pages_for(question: str) -> list[str]:
    """Return the names of the pages that answer a question, the best first; none if none of its words is known."""
    scores: Counter[str] = Counter()
    for one in dict.fromkeys(map(_known, stems(question))):
        scores.update(weights().get(one, {}))
    return [name for name, _ in scores.most_common()]


def has_words_of(topic: str) -> bool:
    """Return whether each word of a topic occurs unchanged in an entry."""
    asked = stems(topic)
    return bool(asked) and all(one in weights() for one in asked)


def stems(text: str) -> list[str]:
    """Return the significant words of a text, without their endings."""
    return [stem(word) for word in _WORD.findall(text.lower()) if word not in PASSED_OVER]


def stem(word: str) -> str:
    """Return a word in lower case without its ending: "spik" of "spike" and of "spikes"."""
    for ending in ENDINGS:
        left = word.removesuffix(ending)
        if left != word and len(left) >= SHORTEST:
            return left[:-1] if ending in ("ing", "ed") and left[-1] == left[-2] and len(left) > SHORTEST else left
    return word


def _known(one: str) -> str:
    return one if one in weights() else next(iter(get_close_matches(one, weights(), n=1, cutoff=_SIMILAR)), one)

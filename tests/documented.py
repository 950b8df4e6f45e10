"""Pages of the documentation: the blocks they show, what comments say of them, and how they are run.

A page says itself what it needs, in HTML comments before its blocks::

    <!-- given: archive, run/ = sample_runs/si3n4-air-200mN -->  lays things into the page's folder
    <!-- file: lab.toml -->                                       the block below is written there
    <!-- as: recipe -->                                           the TOML below is part of such a record
    <!-- exit: 1 -->                                              the commands below end so
    <!-- until: watching exports -->                              the command below is ended by Ctrl-C once it said that
    <!-- output -->                                               the block below is what the one before printed
    <!-- formula -->                                              the block below is mathematics
    <!-- not run: installs a service on a server -->              and why
"""

import difflib
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache

from folders import ROOT
from markdown_it import MarkdownIt
from markdown_it.token import Token

SAYINGS = ("given", "file", "as", "exit", "until", "output", "formula", "not run")
"""What a comment before a block may begin with."""
EXCUSES = ("not run", "formula")
"""What a comment may say of a block that nothing is done with."""
DIRECTIVES = ("{toctree}", "{include}")
"""Blocks that the build of the documentation sees to."""
PROGRAMS = (
    *("tribopipe", "python", "python3", "py", "pip", "pytest", "dask", "silx", "nexpy", "h5glance", "systemctl"),
    *("git", "cp", "mkdir", "unzip", "cd"),
)
"""Programs by which a block without a language is known to hold commands."""
_COMMENT = re.compile(r"<!--\s*(.*?)\s*-->", re.DOTALL)


@dataclass(frozen=True)
class Command:
    """A line for the shell, and the lines that the page shows as its output, if it shows any."""

    line: str
    output: tuple[str, ...] = ()


@dataclass(frozen=True)
class Block:
    """A block of a page: where it begins, its language, its text, and what comments say of it."""

    page: str
    line: int
    language: str
    text: str
    said: dict[str, str] = field(default_factory=dict)

    @property
    def place(self) -> str:
        """Return where the block is, as editors know it."""
        return f"{self.page}:{self.line}"

    @property
    def kind(self) -> str:
        """Return what is done with the block, or why nothing is: "" where neither is known."""
        for said in (*EXCUSES, "output"):
            if said in self.said:
                return said
        if self.language in ("toml", "json", "python", *DIRECTIVES):
            return self.language
        return "commands" if self.commands else "file" if "file" in self.said else ""

    @property
    def commands(self) -> list[Command]:
        """Return the commands that the block holds: none where it is of another kind."""
        lines = self.text.replace("\\\n", "").splitlines()
        if self.language == "console":
            return list(_prompted(lines))
        if self.language == "bash" or (not self.language and any(_program(line) in PROGRAMS for line in lines)):
            return [Command(line.strip()) for line in lines if line.strip() and not line.startswith("#")]
        return []


def _program(line: str) -> str:
    """Return the name of the program that a line would start."""
    return re.split(r"[/\\]", line.partition(" ")[0])[-1]


def _prompted(lines: list[str]) -> Iterator[Command]:
    """Read commands after a prompt, each with the lines below it."""
    starts = [at for at, line in enumerate(lines) if line.startswith("$ ")]
    for start, end in zip(starts, [*starts[1:], len(lines)], strict=True):
        yield Command(lines[start].removeprefix("$ "), tuple(lines[start + 1 : end]))


def pages() -> list[str]:
    """Name the pages whose blocks are run, by their paths in the repository."""
    named = ("README.md", "CONTRIBUTING.md", "SECURITY.md", "paper.md", "sample_runs/README.md")
    found = [*(path for name in named if (path := ROOT / name).exists()), *sorted((ROOT / "docs").glob("*.md"))]
    return [path.relative_to(ROOT).as_posix() for path in found]


@cache
def tokens(page: str) -> list[Token]:
    """Parse a page."""
    text = (ROOT / page).read_text(encoding="utf-8")
    return MarkdownIt("commonmark").enable("table").parse(text)


def blocks(page: str) -> Iterator[Block]:
    """Give the blocks of a page in order; what is given without a block below it is a block without text."""
    said: dict[str, str] = {}
    line = 0
    for token in tokens(page):
        line = token.map[0] + 1 if token.map else line
        if token.type == "html_block":
            said |= _sayings(token.content, f"{page}:{line}")
        elif token.type in ("fence", "code_block"):
            yield Block(page, line, token.info.strip().partition(" ")[0], token.content, said)
            said = {}
        elif said and token.type in ("inline", "hr"):
            assert set(said) == {"given"}, f"{page}:{line}: found text; expected the block of {said}"
            yield Block(page, line, "", "", said)
            said = {}
    if said:
        assert set(said) == {"given"}, f"{page}: found the end; expected the block of {said}"


def shown_file(page: str, name: str) -> str:
    """Return the text of a file that a page shows."""
    return next(block.text for block in blocks(page) if block.said.get("file") == name)


def _sayings(html: str, place: str) -> dict[str, str]:
    """Read what comments say, by what it is."""
    said = {}
    for comment in _COMMENT.findall(html):
        what, _, text = comment.partition(":")
        assert what in SAYINGS, f"{place}: found a comment {comment!r}; expected one of {SAYINGS}"
        said[what] = " ".join(text.split())
    return said


def code_spans(page: str) -> Iterator[str]:
    """Give the texts of a page that are set as code within sentences and tables."""
    for token in tokens(page):
        yield from (child.content for child in token.children or () if child.type == "code_inline")


def difference(shown: tuple[str, ...], printed: str) -> str:
    """Return what a page shows otherwise than it was printed, or nothing.

    An ellipsis in a line stands for any text there, a line of an ellipsis alone for one line or more.
    """
    expected = "\n".join(line.rstrip() for line in shown).rstrip("\n")
    found = "\n".join(line.rstrip() for line in printed.splitlines()).strip("\n")
    pattern = "\n".join(
        r"[^\n]*(?:\n[^\n]*)*?" if line.strip() == "…" else r"[^\n]*".join(map(re.escape, line.split("…")))
        for line in expected.strip("\n").split("\n")
    )
    if re.fullmatch(pattern, found):
        return ""
    lines = expected.splitlines(), found.splitlines()
    return "\n".join(difflib.unified_diff(*lines, "as the page shows it", "as it was printed", lineterm=""))

"""The words of messages, docstrings, pages and the web client: no phrase of banned_phrases.toml is among them.

`python tests/test_words.py [PATH ...]` lists every hit with its file and line.
"""

import ast
import re
import sys
import tomllib
from collections.abc import Iterator
from fnmatch import fnmatch
from pathlib import Path
from typing import NamedTuple

import pytest
from folders import ROOT

RULES = tomllib.loads((ROOT / "tests" / "banned_phrases.toml").read_text(encoding="utf-8"))
PHRASES = [
    (re.compile(rule["pattern"], re.IGNORECASE), rule["write"], tuple(rule.get("not_in", ())))
    for rule in RULES["phrases"]
]
_ANY = re.compile("|".join(rule["pattern"] for rule in RULES["phrases"]), re.IGNORECASE)
KEYS = frozenset(RULES["keys"])
"""Texts of several words that are keys of results."""
PACKAGE, CLIENT = ROOT / "tribopipe", ROOT / "tribopipe" / "browse" / "ui" / "src"
_CODE = re.compile(r"``.*?``|`[^`\n]*`|\{[^{}]*\}")
_QUOTED = re.compile(r"“[^”\n]*”|(?<!\w)\"[^\"\n]*\"")
_KEY = re.compile(r"\w*[a-z]\w*[_.]\w+(?:[_.]\w+)*|--[\w-]+|\[+[\w.-]+\]+|\w+\.md\b")
_SQL = re.compile(r"\s*(SELECT|INSERT|CREATE|PRAGMA|UPDATE|DELETE)\b")
_WORDS = re.compile(r"\s|^[A-Z][a-z]+$")
"""What is no key: several words, or one with a capital."""


class Text(NamedTuple):
    path: str
    line: int
    words: str


class Hit(NamedTuple):
    path: str
    line: int
    found: str
    write: str

    def __str__(self) -> str:
        return f"{self.path}:{self.line}: found {self.found!r}; write {self.write}"


def relative(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def hits(texts: Iterator[Text]) -> list[Hit]:
    """Find the phrases in texts, each with the line it begins in."""
    found = []
    for path, line, words in texts:
        if not _ANY.search(words):
            continue
        plain = _KEY.sub(" ", _QUOTED.sub(" ", _CODE.sub(" ", words)))
        for pattern, write, not_in in PHRASES:
            if any(fnmatch(path, glob) for glob in not_in):
                continue
            found += [
                Hit(path, line + words[: words.find(match[0])].count("\n"), match[0], write)
                for match in pattern.finditer(plain)
            ]
    return found


def python_texts(*, docstrings: bool) -> Iterator[Text]:
    """Give the docstrings of the package, a line each; or its other texts of several words."""
    for path in sorted(PACKAGE.rglob("*.py")):
        if CLIENT.parent not in path.parents:
            tree = ast.parse(path.read_text(encoding="utf-8"))
            yield from (docstring_lines if docstrings else spoken)(tree, relative(path))


def documents(tree: ast.Module) -> Iterator[ast.Constant]:
    """Give the texts that stand alone: docstrings, and those below fields."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            yield node.value


def docstring_lines(tree: ast.Module, path: str) -> Iterator[Text]:
    for node in documents(tree):
        for number, line in enumerate(node.value.splitlines()):
            if not re.match(r"\s*(>>>|\.\.\. )", line):
                yield Text(path, node.lineno + number, line)


def spoken(tree: ast.Module, path: str) -> Iterator[Text]:
    """Give texts of several words, f-strings with {} for what is filled in; not patterns, SQL, or names."""
    silent = {id(node) for node in documents(tree)}
    silent |= {id(part) for node in ast.walk(tree) for within in unspoken(node) for part in ast.walk(within)}
    for node in ast.walk(tree):
        words = None if id(node) in silent else written(node)
        if words and words not in KEYS and _WORDS.search(words.strip()) and not _SQL.match(words):
            yield Text(path, node.lineno, words)


def unspoken(node: ast.AST) -> list[ast.AST]:
    """Return the parts of a node whose texts nobody reads, or are read as part of it."""
    match node:
        case ast.Call(func=ast.Attribute(value=ast.Name(id="re"))):
            return node.args[:1]
        case ast.Assign(targets=[ast.Name(id="__all__")]):
            return [node.value]
        case ast.JoinedStr():
            return [part for part in node.values if isinstance(part, ast.Constant)]
    return [annotation] if (annotation := getattr(node, "annotation", None) or getattr(node, "returns", None)) else []


def written(node: ast.AST) -> str | None:
    if isinstance(node, ast.JoinedStr):
        return "".join(part.value if isinstance(part, ast.Constant) else "{}" for part in node.values)
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else None


def prose(path: Path) -> Iterator[Text]:
    """Give the lines of a page without its code, comments and addresses."""
    fenced = commented = False
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        fenced ^= line.lstrip().startswith(("```", ":::"))
        commented = commented or line.startswith("<!--")
        if not (fenced or commented or line.startswith("    ")):
            yield Text(relative(path), number, re.sub(r"\]\([^)]*\)|<[^>]*>|\{[^}]*\}|^\(.*\)=$", " ", line))
        commented = commented and "-->" not in line


def client_texts() -> Iterator[Text]:
    """Give what the web client writes: texts in quotes that are no key, and what stands between tags."""
    for path in sorted((*CLIENT.rglob("*.ts"), *CLIENT.rglob("*.tsx"))):
        if path.name.endswith(".test.ts"):
            continue
        code = re.sub(r"/\*.*?\*/|(?<!:)//[^\n]*", _blank, path.read_text(encoding="utf-8"), flags=re.DOTALL)
        code = re.sub(
            r"(?m)^(import|export .* from)\b.*$|\b(className|id|key|href|to|colourBy)=\"[^\"]*\"", _blank, code
        )
        code = code.replace("aria-labelledby", "")
        for match in re.finditer(r"\"([^\"\n]*)\"|`([^`]*)`|>([^<>{}=;()]+)(?=[<{])", code):
            words = next(group for group in match.groups() if group is not None)
            if _WORDS.search(words.strip()):
                yield Text(relative(path), code.count("\n", 0, match.start()) + 1, re.sub(r"\$\{[^}]*\}", " ", words))


def template_texts() -> Iterator[Text]:
    for path in sorted((PACKAGE / "views").rglob("*.html")):
        plain = re.sub(
            r"\{[%#{].*?[%#}]\}|<(style|script)\b.*?</\1>|<[^>]*>", _blank, path.read_text("utf-8"), flags=re.DOTALL
        )
        yield from (Text(relative(path), number, line) for number, line in enumerate(plain.splitlines(), 1))


def _blank(match: re.Match[str]) -> str:
    return "\n" * match[0].count("\n")


def listed(found: list[Hit]) -> str:
    return "\n".join(map(str, found))


@pytest.mark.slow
def test_messages_and_help_have_plain_words():
    assert not (found := hits(python_texts(docstrings=False))), listed(found)


@pytest.mark.slow
def test_reports_have_plain_words():
    assert not (found := hits(template_texts())), listed(found)


@pytest.mark.slow
def test_the_web_client_has_plain_words():
    assert not (found := hits(client_texts())), listed(found)


@pytest.mark.slow
def test_the_readme_has_plain_words():
    assert not (found := hits(prose(ROOT / "README.md"))), listed(found)


@pytest.mark.slow
def test_docstrings_have_plain_words():
    assert not (found := hits(python_texts(docstrings=True))), listed(found)


def pages() -> list[Path]:
    """Name the pages of the documentation but those that its build makes of docstrings."""
    return [path for path in sorted(ROOT.glob("docs/**/*.md")) if path.parent.name != "reference"]


@pytest.mark.slow
@pytest.mark.parametrize("page", [path.relative_to(ROOT / "docs").as_posix() for path in pages()])
def test_pages_get_no_more_of_these_phrases(page):
    found, most = hits(prose(ROOT / "docs" / page)), RULES.get("pages", {}).get(page, 0)
    assert len(found) <= most, f"{len(found)} hits, at most {most}:\n{listed(found)}"


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("The file says so.", ["says"]),
        ('`says` is code, "said" a quotation, end_values a key', []),
        ("End values are measured", ["End values"]),
        ("once a run", ["once a run"]),
    ],
)
def test_a_phrase_is_found_but_not_in_code_keys_and_quotations(text, found):
    assert [hit.found for hit in hits(iter([Text("", 1, text)]))] == found


def test_the_texts_of_python_are_those_that_users_read():
    tree = ast.parse(
        '"""Said."""\nre.compile("was told")\n__all__ = ["Verdict"]\nraise ValueError(f"found {x} worn off")\n'
    )
    assert [text.words for text in spoken(tree, "")] == ["found {} worn off"]


def everything() -> Iterator[Text]:
    yield from python_texts(docstrings=False)
    yield from python_texts(docstrings=True)
    yield from template_texts()
    yield from client_texts()
    for page in (ROOT / "README.md", *pages()):
        yield from prose(page)


if __name__ == "__main__":
    found = [hit for hit in hits(everything()) if not sys.argv[1:] or hit.path.startswith(tuple(sys.argv[1:]))]
    sys.stdout.write(f"{listed(found)}\n{len(found)} hits\n")

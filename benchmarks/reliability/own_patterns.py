"""Every regular expression of the package, found by walking its code, and the calls it is used by.

Patterns that a module keeps are taken from there; those that a call of ``re`` is given are computed in their module.
What depends on a value of a running function cannot be, and is named for who asks.
"""

import ast
import importlib
import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import tribopipe
from tribopipe.base import units

PACKAGE = Path(tribopipe.__file__).parent
CALLS = ("match", "fullmatch", "search", "finditer", "findall", "sub", "subn", "split")
_FLAGS_AT = {"compile": 1, "sub": 4, "subn": 4, "split": 3} | dict.fromkeys(CALLS[:5], 2)
LONGEST = {"base/units.py: _UNIT": vars(units)["_LONGEST_UNIT"]}
"""Patterns that can read a text in more than one way, and how long a text they are given at most."""
Kept = Iterator[tuple[str, "re.Pattern[Any]"]]


class OwnPattern(NamedTuple):
    """A pattern and a call that it is used by."""

    where: str
    """Such as "readers/text.py: LINE_END"."""
    pattern: "re.Pattern[Any]"
    call: str


class Walked(NamedTuple):
    """What was found in the package."""

    patterns: Sequence[OwnPattern]
    built: Sequence[str]
    """Calls with a pattern that only a running function knows, such as "readers/rtec.py: re.fullmatch(pattern, …)"."""


class _Module:
    """The code of a module, and the module."""

    def __init__(self, path: Path) -> None:
        self.place = path.relative_to(PACKAGE).as_posix()
        self.tree = ast.parse(path.read_text(encoding="utf-8"))
        parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
        self.known = vars(importlib.import_module(".".join(parts).removesuffix(".__init__")))
        assigned = [one for one in self.tree.body if isinstance(one, ast.Assign | ast.AnnAssign)]
        self.kept_code = {id(node) for one in assigned for node in ast.walk(one)}
        names = (node for one in assigned for node in ast.walk(one) if isinstance(node, ast.Name))
        self.names = {node.id for node in names if isinstance(node.ctx, ast.Store)}

    def kept(self) -> Kept:
        """Give the patterns that the module makes and keeps."""
        for name in sorted(self.names & self.known.keys()):
            yield from ((f"{name}{place}", pattern) for place, pattern in _within(self.known[name]))

    def given(self) -> Iterator[tuple[ast.Call, str]]:
        """Give the calls of ``re`` with a pattern in functions, and the name of what is called."""
        for node in ast.walk(self.tree):
            if isinstance(node, ast.Call) and id(node) not in self.kept_code:
                call = _of_re(node.func)
                if call in (*CALLS, "compile"):
                    yield node, str(call)


def own_patterns() -> Walked:
    """Walk the package."""
    paths = [path for path in sorted(PACKAGE.rglob("*.py")) if "ui" not in path.relative_to(PACKAGE).parts]
    modules = [_Module(path) for path in paths]
    everywhere = _used(module.tree for module in modules)
    found: list[OwnPattern] = []
    built: list[str] = []
    for module in modules:
        within = _used([module.tree])
        calls: dict[int, set[str]] = defaultdict(set)  # of a pattern, which may be kept by several names
        for name, pattern in module.kept():
            plain = name.partition("[")[0]
            calls[id(pattern)] |= (within if plain.startswith("_") else everywhere)[plain]  # nobody else uses _names
        for name, pattern in module.kept():
            # One that no call is seen of may be used by any.
            where = f"{module.place}: {name}"
            found += [OwnPattern(where, pattern, call) for call in sorted(calls[id(pattern)] or {"search"})]
        for node, call in module.given():
            where = f"{module.place}: {ast.unparse(node)}"
            compiled = _computed(node, call, module.known)
            if compiled is None:
                built.append(where)
            else:
                found.append(OwnPattern(where, compiled, "search" if call == "compile" else call))
    return Walked(found, built)


def _used(trees: Iterable[ast.Module]) -> dict[str, set[str]]:
    """Return the calls of patterns by the name before the point."""
    used: dict[str, set[str]] = defaultdict(set)
    for tree in trees:
        for node in ast.walk(tree):
            if isinstance(node, ast.Attribute) and node.attr in CALLS:
                named = node.value
                while isinstance(named, ast.Subscript):
                    named = named.value
                if isinstance(named, ast.Name | ast.Attribute):
                    used[named.id if isinstance(named, ast.Name) else named.attr].add(node.attr)
        for node in ast.walk(tree):
            if isinstance(node, ast.For | ast.comprehension) and isinstance(node.iter, ast.Name):
                used[node.iter.id] |= {call for one in ast.walk(node.target) for call in used.get(_name(one), ())}
    return used


def _name(node: ast.AST) -> str:
    return node.id if isinstance(node, ast.Name) else ""


def _of_re(called: ast.expr) -> str | None:
    if isinstance(called, ast.Attribute) and isinstance(called.value, ast.Name) and called.value.id == "re":
        return called.attr
    return None


def _within(value: Any) -> Kept:
    if isinstance(value, re.Pattern):
        yield "", value
    elif isinstance(value, tuple | list):
        for index, one in enumerate(value):
            yield from ((f"[{index}]{place}", pattern) for place, pattern in _within(one))
    elif isinstance(value, Mapping):
        for key, one in value.items():
            yield from ((f"[{key!r}]{place}", pattern) for place, pattern in _within(one))


def _computed(node: ast.Call, call: str, known: dict[str, Any]) -> "re.Pattern[Any] | None":
    """Compile what a call is given, where its module knows it."""
    at = _FLAGS_AT[call]
    named = [one.value for one in node.keywords if one.arg == "flags"]
    given = [node.args[0], *(named or node.args[at : at + 1])]
    try:
        values = [eval(compile(ast.Expression(one), "", "eval"), known) for one in given]  # noqa: S307
    except NameError:
        return None
    return values[0] if isinstance(values[0], re.Pattern) else re.compile(*values)

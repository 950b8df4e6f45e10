"""Places where one change of meaning can be made in a module, found in its syntax tree, and a draw from them.

The rule: groups of modules take turns. Within a group modules come in a shuffled order, and again from its start once
all had their turn. In a module a kind of change is drawn, then a place for it, then what it is changed to. A place
counts only where its line is the only one of its text in its function. Nothing is changed in annotations, decorators,
texts, refusals (``raise``) and arguments that only say how they are called (``strict``, ``kw_only``).
"""

import ast
import random
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

COMPARED: Mapping[type, tuple[str, tuple[str, ...]]] = {
    ast.Lt: ("<", ("<=", ">")),
    ast.LtE: ("<=", ("<", ">")),
    ast.Gt: (">", (">=", "<")),
    ast.GtE: (">=", (">", "<")),
    ast.Eq: ("==", ("!=",)),
    ast.NotEq: ("!=", ("==",)),
    ast.Is: ("is", ("is not",)),
    ast.IsNot: ("is not", ("is",)),
    ast.In: ("in", ("not in",)),
    ast.NotIn: ("not in", ("in",)),
}
REPLACED: Mapping[type, tuple[str, tuple[str, ...]]] = {
    ast.Add: ("+", ("-",)),
    ast.Sub: ("-", ("+",)),
    ast.Mult: ("*", ("/",)),
    ast.Div: ("/", ("*",)),
    ast.Pow: ("**", ("*",)),
}
SWAPPED: Mapping[str, str] = {
    one: other
    for pair in (("min", "max"), ("minimum", "maximum"), ("nanmin", "nanmax"), ("argmin", "argmax"), ("any", "all"))
    for one, other in (pair, pair[::-1])
}
KINDS = ("comparison", "arithmetic", "sign", "constant", "extreme", "index", "boolean")
_PASSED_OVER = (ast.JoinedStr, ast.Raise)
_KEYWORDS_PASSED_OVER = ("kw_only", "strict")
_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
_NAMED = (*_FUNCTIONS, ast.ClassDef)


@dataclass(frozen=True)
class Site:
    """A place in a module, by line and columns, and what may stand there instead."""

    kind: str
    line: int
    start: int
    end: int
    choices: tuple[str, ...]
    within: str
    """The function it is in, with its class; empty outside of functions."""


@dataclass(frozen=True)
class Draw:
    """A mutant that was drawn: the line that changes, as it is and as it becomes."""

    file: str
    within: str
    old: str
    new: str
    kind: str


def draw(root: Path, groups: Mapping[str, Sequence[str]], seed: int, count: int) -> list[Draw]:
    """Draw mutants of the modules that the patterns of each group match below a folder."""
    chance = random.Random(seed)  # noqa: S311, for a draw that can be repeated
    orders = [_turns(chance, root, patterns) for _, patterns in sorted(groups.items())]
    drawn: list[Draw] = []
    while len(drawn) < count:
        one = _drawn_from(chance, root, next(orders[len(drawn) % len(orders)]))
        if one not in drawn:
            drawn.append(one)
    return drawn


def _turns(chance: random.Random, root: Path, patterns: Sequence[str]) -> Iterator[str]:
    """Yield modules in a shuffled order, over and over: those in which anything can be changed."""
    found = {path for pattern in patterns for path in root.glob(pattern) if sites(path.read_text(encoding="utf-8"))}
    modules = sorted(path.relative_to(root).as_posix() for path in found)
    chance.shuffle(modules)
    while True:
        yield from modules


def _drawn_from(chance: random.Random, root: Path, module: str) -> Draw:
    source = (root / module).read_text(encoding="utf-8")
    found = sites(source)
    kind = chance.choice([one for one in KINDS if any(site.kind == one for site in found)])
    site = chance.choice([site for site in found if site.kind == kind])
    line = source.splitlines()[site.line - 1]
    changed = line[: site.start] + chance.choice(site.choices) + line[site.end :]
    within = "" if source.count(line.strip()) == 1 else site.within
    return Draw(module, within, line.strip(), changed.strip(), kind)


def sites(source: str) -> list[Site]:
    """Return all places of a module where something can be changed, in the order they stand."""
    tree, lines = ast.parse(source), source.splitlines()
    parts = _parts(tree, lines)
    found = [site for node, within in _changeable(tree, "") for site in _sites_of(node, lines, within)]
    alone = [site for site in found if "\n".join(parts[site.within]).count(lines[site.line - 1].strip()) == 1]
    return sorted(alone, key=lambda site: (site.line, site.start, site.kind))


def bounds(source: str, within: str) -> tuple[int, int]:
    """Return the lines of a function or class, from the first, counted from 0, to before the last.

    It is named with the class it is in; none at all is the whole source. Raises ``LookupError`` where there is no such
    function, or more than one.
    """
    tree = ast.parse(source)
    if not within:
        return 0, len(source.splitlines())
    found = [node for node, name in named(tree) if name == within]
    if len(found) != 1:
        raise LookupError(f"found {len(found)} functions named {within}, expected one")
    return found[0].lineno - 1, found[0].end_lineno


def function_at(source: str, line: int) -> str:
    """Return the name of the innermost function that a line, counted from 1, is in; empty outside of functions."""
    found = ""
    for node, name in named(ast.parse(source)):
        if isinstance(node, _FUNCTIONS) and node.lineno <= line <= node.end_lineno:
            found = name
    return found


def _parts(tree: ast.Module, lines: Sequence[str]) -> dict[str, Sequence[str]]:
    """Return the lines of each function and class by its name; of none where a name is not that of one alone."""
    found = list(named(tree))
    parts = {name: lines[node.lineno - 1 : node.end_lineno] for node, name in found}
    several = [name for name, count in Counter(name for _, name in found).items() if count > 1]
    return {"": lines} | parts | {name: [] for name in several}


def named(tree: ast.AST, above: str = "") -> Iterator[tuple[ast.stmt, str]]:
    """Yield all functions and classes with their names, which begin with those they are in."""
    for node in ast.iter_child_nodes(tree):
        name = _name(node, above)
        if isinstance(node, _NAMED):
            yield node, name
        yield from named(node, name)


def _name(node: ast.AST, above: str) -> str:
    return f"{above}.{node.name}".lstrip(".") if isinstance(node, _NAMED) else above


def _changeable(tree: ast.AST, within: str) -> Iterator[tuple[ast.AST, str]]:
    """Yield all nodes where a change is one of meaning, with the function they are in."""
    for name, value in ast.iter_fields(tree):
        if name in ("annotation", "returns", "decorator_list", "type_params"):
            continue
        for node in value if isinstance(value, list) else [value]:
            if not isinstance(node, ast.AST) or isinstance(node, _PASSED_OVER):
                continue
            if isinstance(node, ast.keyword) and node.arg in _KEYWORDS_PASSED_OVER:
                continue
            inside = _name(node, within)
            if isinstance(tree, ast.Subscript) and node is tree.slice and _end(node) is not None:
                continue
            yield node, inside
            yield from _changeable(node, inside)


def _sites_of(node: ast.AST, lines: Sequence[str], within: str) -> Iterator[Site]:  # noqa: C901
    match node:
        case ast.Compare():
            for left, operator, right in zip([node.left, *node.comparators], node.ops, node.comparators, strict=False):
                old, choices = COMPARED[type(operator)]
                yield from _between("comparison", left, right, old, choices, lines, within)
        case ast.BinOp(op=operator) if type(operator) in REPLACED and not _text(node.left) and not _text(node.right):
            old, choices = REPLACED[type(operator)]
            yield from _between("arithmetic", node.left, node.right, old, choices, lines, within)
        case ast.UnaryOp(op=ast.USub()):
            yield _site("sign", node, lines, within, ("",), length=1)
        case ast.UnaryOp(op=ast.Not()):
            yield _site("boolean", node, lines, within, ("",), length=len("not "))
        case ast.BoolOp(op=operator):
            old, new = ("and", "or") if isinstance(operator, ast.And) else ("or", "and")
            for left, right in zip(node.values, node.values[1:], strict=False):
                yield from _between("boolean", left, right, old, (new,), lines, within)
        case ast.Constant(value=bool() as value):
            yield _site("boolean", node, lines, within, (str(not value),))
        case ast.Constant(value=int() as value):
            yield _site("constant", node, lines, within, (str(value + 1),))
        case ast.Constant(value=float() as value):
            yield _site("constant", node, lines, within, (str(2 * value or 1.0),))
        case ast.Subscript(slice=index) if _end(index) is not None:
            yield _site("index", index, lines, within, ("-1" if _end(index) == 0 else "0",))
        case ast.Name(id=name) if name in SWAPPED:
            yield _site("extreme", node, lines, within, (SWAPPED[name],))
        case ast.Attribute(attr=name) if name in SWAPPED:
            end = _column(lines, node.end_lineno, node.end_col_offset)
            yield Site("extreme", node.end_lineno, end - len(name), end, (SWAPPED[name],), within)


def _end(index: ast.expr) -> int | None:
    """Return 0 or -1 where that is what a subscript is."""
    match index:
        case ast.Constant(value=0):
            return 0
        case ast.UnaryOp(op=ast.USub(), operand=ast.Constant(value=1)):
            return -1
    return None


def _text(node: ast.AST) -> bool:
    return isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, str))


def _column(lines: Sequence[str], line: int, offset: int) -> int:
    """Return a column in characters: syntax trees count bytes."""
    return len(lines[line - 1].encode()[:offset].decode())


def _site(
    kind: str, node: ast.expr, lines: Sequence[str], within: str, choices: tuple[str, ...], length: int | None = None
) -> Site:
    start = _column(lines, node.lineno, node.col_offset)
    end = start + length if length else _column(lines, node.end_lineno, node.end_col_offset)
    return Site(kind, node.lineno, start, end, choices, within)


def _between(
    kind: str,
    left: ast.expr,
    right: ast.expr,
    old: str,
    choices: tuple[str, ...],
    lines: Sequence[str],
    within: str,
) -> Iterator[Site]:
    """Yield the place of an operator between two expressions, where all three stand on one line."""
    if left.end_lineno != right.lineno:
        return
    start = _column(lines, left.end_lineno, left.end_col_offset)
    end = _column(lines, right.lineno, right.col_offset)
    found = re.search(rf"\b{old}\b" if old[0].isalpha() else re.escape(old), lines[right.lineno - 1][start:end])
    if found:
        yield Site(kind, right.lineno, start + found.start(), start + found.end(), choices, within)

r"""Equations as MathML, written in the little of TeX that they need.

Letters, numbers and signs stand for themselves; ``_`` and ``^`` with one of them or a group in braces; \frac{}{},
\sqrt{}, \text{} and \quad. So "k_D = \frac{V}{F_N s}" is a fraction with two subscripts.
"""

import re
from collections import deque

from markupsafe import Markup, escape

_TOKEN = re.compile(r"\\text\{[^{}]*\}|\\[a-z]+|\d+(?:\.\d+)?|\S")
_COMMANDS = {"\\frac": ("mfrac", 2), "\\sqrt": ("msqrt", 1)}
_QUAD = Markup('<mspace width="1.5em"></mspace>')
_SCRIPTS = {"_": "msub", "^": "msup", "_^": "msubsup"}


def mathml(source: str) -> Markup:
    """Return an equation as a <math> element in a line of its own."""
    return Markup('<math display="block">{}</math>').format(_row(deque(_TOKEN.findall(source))))


def _row(tokens: deque[str]) -> Markup:
    """Take what stands up to a closing brace, or the end."""
    parts: list[Markup] = []
    while tokens and tokens[0] != "}":
        parts.append(_scripted(tokens))
    if tokens:
        tokens.popleft()
    return Markup("<mrow>{}</mrow>").format(Markup("").join(parts))


def _scripted(tokens: deque[str]) -> Markup:
    """Take one thing with its subscript and superscript."""
    parts, signs = [_one(tokens)], ""
    while tokens and tokens[0] in ("_", "^"):
        signs += tokens.popleft()
        parts.append(_one(tokens))
    return _element(_SCRIPTS[signs], *parts) if signs else parts[0]


def _one(tokens: deque[str]) -> Markup:
    token = tokens.popleft()
    if token == "{":  # noqa: S105, a brace
        return _row(tokens)
    if token in _COMMANDS:
        name, arguments = _COMMANDS[token]
        return _element(name, *[_one(tokens) for _ in range(arguments)])
    if token == "\\quad":  # noqa: S105, a space
        return _QUAD
    if token.startswith("\\text"):
        return _element("mtext", escape(token[len("\\text{") : -1]))
    return _element(_kind(token), escape(token))


def _kind(token: str) -> str:
    if token[0].isdigit():
        return "mn"
    return "mi" if token.isalpha() else "mo"


def _element(name: str, *parts: Markup) -> Markup:
    return Markup("<{0}>{1}</{0}>").format(name, Markup("").join(parts))

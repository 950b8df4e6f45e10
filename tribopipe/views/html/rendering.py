r"""Rendering of reports: templates that escape text from users, MathML equations, SVG figures, and PDF.

Equations are written in the little of TeX that they need. Letters, numbers and signs stand for themselves; ``_`` and
``^`` with one of them or a group in braces; \frac{}{}, \sqrt{}, \text{} and \quad. So "k_D = \frac{V}{F_N s}" is a
fraction with two subscripts. Parentheses are as tall as a letter; those after \left and \right, as tall as what they
enclose. Nothing in a figure runs or loads, and no two figures share a name. PDF is printed by a
browser that is installed: Chromium, Chrome or Edge.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections import deque
from collections.abc import Iterator
from datetime import datetime
from functools import cache, partial
from io import StringIO
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

from tribopipe.base.column_formatting import WITHIN_NUMBER
from tribopipe.base.errors import TribopipeError
from tribopipe.version import VERSION
from tribopipe.views.run_figures import own_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure


_TOKEN = re.compile(r"\\text\{[^{}]*\}|\\[a-z]+|\d+(?:\.\d+)?|\S")
_COMMANDS = {"\\frac": ("mfrac", 2), "\\sqrt": ("msqrt", 1)}
_QUAD = Markup('<mspace width="1.5em"></mspace>')
_SCRIPTS = {"_": "msub", "^": "msup", "_^": "msubsup"}


def mathml(source: str) -> Markup:
    """Return an equation as a <math> element on a separate line."""
    return Markup('<math display="block">{}</math>').format(_row(deque(_TOKEN.findall(source))))


def _row(tokens: deque[str]) -> Markup:
    """Parse up to a closing brace, or the end."""
    parts: list[Markup] = []
    while tokens and tokens[0] != "}":
        parts.append(_scripted(tokens))
    if tokens:
        tokens.popleft()
    return Markup("<mrow>{}</mrow>").format(Markup("").join(parts))


def _scripted(tokens: deque[str]) -> Markup:
    """Parse one item with its subscript and superscript."""
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
    if token in ("\\left", "\\right"):
        return _element("mo", escape(tokens.popleft()))
    if token in ("(", ")"):
        # Without a font for mathematics, browsers stretch them to twice the height of a line.
        return Markup('<mo stretchy="false">{}</mo>').format(token)
    return _element(_kind(token), escape(token))


def _kind(token: str) -> str:
    if token[0].isdigit():
        return "mn"
    return "mi" if token.isalpha() else "mo"


def _element(name: str, *parts: Markup) -> Markup:
    return Markup("<{0}>{1}</{0}>").format(name, Markup("").join(parts))


_KEPT = frozenset(("svg", "g", "defs", "path", "use", "text", "tspan", "rect", "clipPath", "image"))
"""Elements that are kept in a drawing."""
_ATTRIBUTES = frozenset(
    (
        *("id", "href", "d", "x", "y", "dx", "dy", "width", "height", "viewBox", "preserveAspectRatio", "transform"),
        *("style", "clip-path", "clip-rule", "opacity"),
    )
)
_REFERENCE = re.compile(r"url\(#([^()]*)\)")
_FONT = re.compile(r"font-family: [^;]*(; )?")
"""Removed, since the page specifies one font family for all texts."""
_CONTROL = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f]")
"""Characters that XML cannot represent."""


def inline_svg(figure: "Figure", name: str, label: str) -> Markup:
    """Return a figure as an <svg> element whose ids begin with a name, with a label for screen readers."""
    drawing = ElementTree.fromstring(_CONTROL.sub("", _drawn(figure)))  # noqa: S314, matplotlib's own
    drawing = _plain_svg(drawing)
    _rename(drawing, name)
    for size in ("width", "height"):
        drawing.attrib.pop(size, None)
    drawing.attrib |= {"role": "img", "aria-label": label}
    return Markup(ElementTree.tostring(drawing, encoding="unicode", short_empty_elements=False))  # noqa: S704, of kept parts only


def _drawn(figure: "Figure") -> str:
    written = StringIO()
    with own_style():
        figure.savefig(written, format="svg", metadata={"Date": None, "Creator": None})
    return written.getvalue()


def _plain_svg(element: ElementTree.Element) -> ElementTree.Element:
    """Copy an element without unneeded parts and without namespaces."""
    attributes = {_local(name): value for name, value in element.attrib.items() if _local(name) in _ATTRIBUTES}
    copied = ElementTree.Element(_local(element.tag), {name: _short(value) for name, value in attributes.items()})
    copied.text = element.text if copied.tag in ("text", "tspan") else None
    for child in element:
        if _local(child.tag) in _KEPT:
            copied.append(_plain_svg(child))
            copied[-1].tail = child.tail if copied.tag in ("text", "tspan") else None
    return copied


def _local(name: str) -> str:
    return name.rpartition("}")[2]


def _short(value: str) -> str:
    """Write a path, style or picture on one line."""
    return _FONT.sub("", " ".join(value.split())).replace("base64, ", "base64,")


def _rename(drawing: ElementTree.Element, name: str) -> None:
    """Rename ids that are referred to, and remove all other ids and external references."""
    targets = {target for element in drawing.iter() for target in _targets(element)}
    known = [element.get("id", "") for element in drawing.iter() if element.get("id") in targets]
    ids = {old: f"{name}-{number}" for number, old in enumerate(dict.fromkeys(known))}
    for element in drawing.iter():
        own = element.attrib.pop("id", None)
        if own in ids:
            element.set("id", ids[own])
        href = element.attrib.pop("href", "")
        if href.startswith("#") and href[1:] in ids:
            element.set("href", f"#{ids[href[1:]]}")
        elif element.tag == "image" and href.startswith("data:image/png;base64,"):
            element.set("href", href)
        for attribute, value in element.attrib.items():
            element.set(attribute, _REFERENCE.sub(lambda found: f"url(#{ids.get(found[1], '')})", value))


def _targets(element: ElementTree.Element) -> Iterator[str]:
    """Yield the ids that an element refers to."""
    if element.get("href", "").startswith("#"):
        yield element.get("href", "")[1:]
    for value in element.attrib.values():
        yield from _REFERENCE.findall(value)


_UNSEEN = re.compile(
    "[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u061c\u200b-\u200f\u2028-\u202e\u2060-\u206f\ufeff\ud800-\udfff]"
)
"""Characters that are invisible, or reverse the order of others."""
_SYMBOL = re.compile(r"\b([kEFRKha])_(D|n|N|P|Ic|end|d|p|s|x|z|c)\b")
_LOWER_WORD = re.compile(r"[a-z]{2,}\b")


def rendered(template: str, **shown: Any) -> str:
    """Fill a template, including the program with its version and a counter of tables."""
    program, next_table = f"tribopipe {VERSION}", partial(next, count(1))
    return _environment().get_template(template).render(program=program, next_table=next_table, **shown)


@cache
def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("tribopipe.views.html"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=_visible,
    )
    environment.filters |= {"mathml": mathml, "moment": _moment, "sentence": _sentence, "symbols": _symbols}
    return environment


def _visible(value: Any) -> Any:
    """Make invisible characters visible; markup by tribopipe is unchanged."""
    return _UNSEEN.sub("\ufffd", value) if isinstance(value, str) and not isinstance(value, Markup) else value


def _symbols(text: str) -> Markup:
    """Write k_D and similar symbols with a subscript, and numbers with their units without line breaks."""
    whole = WITHIN_NUMBER.sub("\u00a0", _visible(text))
    return Markup(_SYMBOL.sub(r"\1<sub>\2</sub>", str(escape(whole))))  # noqa: S704, escaped


def _moment(date: str) -> str:
    """Format an ISO 8601 date for readers; other texts are unchanged."""
    try:
        return f"{datetime.fromisoformat(date):%Y-%m-%d %H:%M %Z}".strip()
    except ValueError:
        return date


def _sentence(text: str) -> str:
    """Begin a text with a capital letter, except symbols such as k_D and μ."""
    return text[:1].upper() + text[1:] if _LOWER_WORD.match(text) else text


_ON_PATH = (
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "chrome",
    "microsoft-edge",
    "msedge",
)
_ELSEWHERE = {
    "win32": ("Google/Chrome/Application/chrome.exe", "Microsoft/Edge/Application/msedge.exe"),
    "darwin": (
        "Google Chrome.app/Contents/MacOS/Google Chrome",
        "Chromium.app/Contents/MacOS/Chromium",
        "Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
    ),
}
"""Locations of browsers that are not on PATH, below the program folders."""
_LONGEST = 180
"""Longest time that a browser may take, s."""


def printed(document: str) -> bytes:
    """Return a self-contained HTML document as PDF.

    Raises
    ------
    TribopipeError
        Where no browser is installed, or it does not print.
    """
    browser = next(_browsers(), None)
    if browser is None:
        raise TribopipeError(
            "report: found no Chromium, Chrome or Edge; expected one of them to create the PDF; install one, or omit "
            "--pdf, open the HTML file in any browser and save it as PDF"
        )
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        page, pdf = Path(folder, "report.html"), Path(folder, "report.pdf")
        page.write_text(document, encoding="utf-8")
        words = [
            browser,
            "--headless",
            "--disable-gpu",
            "--no-first-run",
            "--no-pdf-header-footer",
            f"--user-data-dir={Path(folder, 'profile')}",
            *(
                ["--no-sandbox"] if getattr(os, "geteuid", lambda: 1)() == 0 else []
            ),  # as which it does not start otherwise
            f"--print-to-pdf={pdf}",
            page.as_uri(),
        ]
        try:
            done = subprocess.run(words, capture_output=True, timeout=_LONGEST, check=False)  # noqa: S603, none of a shell
        except subprocess.TimeoutExpired:
            raise _no_pdf(f"running {browser} for {_LONGEST} s") from None
        if not pdf.is_file():
            last = (done.stderr.decode("utf-8", "replace").splitlines() or ["no message"])[-1]
            raise _no_pdf(f"running {browser} ({last})")
        return pdf.read_bytes()


def _no_pdf(done: str) -> TribopipeError:
    return TribopipeError(
        f"report: found no PDF file after {done}; expected the browser to create one; omit --pdf, open the HTML file "
        "in a browser and save it as PDF"
    )


def _browsers() -> Iterator[str]:
    yield from (found for name in _ON_PATH if (found := shutil.which(name)))
    folders = [os.environ.get(name, "") for name in ("PROGRAMFILES", "PROGRAMFILES(X86)", "LOCALAPPDATA")]
    for folder in folders if sys.platform == "win32" else ["/Applications"]:
        for name in _ELSEWHERE.get(sys.platform, ()):
            if (path := Path(folder, name)).is_file():
                yield str(path)

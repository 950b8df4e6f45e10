"""Figures as SVG within a page: nothing that runs or loads, and no name that two figures share."""

import re
from collections.abc import Iterator
from io import StringIO
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from markupsafe import Markup

from tribopipe.views.run_figures import own_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_KEPT = frozenset(("svg", "g", "defs", "path", "use", "text", "tspan", "rect", "clipPath", "image"))
"""Elements that a drawing needs."""
_ATTRIBUTES = frozenset(
    (
        *("id", "href", "d", "x", "y", "dx", "dy", "width", "height", "viewBox", "preserveAspectRatio", "transform"),
        *("style", "clip-path", "clip-rule", "opacity"),
    )
)
_REFERENCE = re.compile(r"url\(#([^()]*)\)")
_FONT = re.compile(r"font-family: [^;]*(; )?")
"""Left to the page, which names a family for all texts alike."""
_CONTROL = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f]")
"""Characters that XML has no way to write."""


def inline_svg(figure: "Figure", name: str, label: str) -> Markup:
    """Return a figure as an <svg> element whose ids begin with a name, and that a screen reader calls by a label."""
    drawing = ElementTree.fromstring(_CONTROL.sub("", _drawn(figure)))  # noqa: S314, matplotlib's own
    drawing = _plain(drawing)
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


def _plain(element: ElementTree.Element) -> ElementTree.Element:
    """Copy an element without what a drawing does not need, and without namespaces."""
    attributes = {_local(name): value for name, value in element.attrib.items() if _local(name) in _ATTRIBUTES}
    copied = ElementTree.Element(_local(element.tag), {name: _short(value) for name, value in attributes.items()})
    copied.text = element.text if copied.tag in ("text", "tspan") else None
    for child in element:
        if _local(child.tag) in _KEPT:
            copied.append(_plain(child))
            copied[-1].tail = child.tail if copied.tag in ("text", "tspan") else None
    return copied


def _local(name: str) -> str:
    return name.rpartition("}")[2]


def _short(value: str) -> str:
    """Write a path, style or picture in one line."""
    return _FONT.sub("", " ".join(value.split())).replace("base64, ", "base64,")


def _rename(drawing: ElementTree.Element, name: str) -> None:
    """Give what is referred to an id of its own, drop all other ids, and references to anything outside."""
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
    """Name the ids that an element refers to."""
    if element.get("href", "").startswith("#"):
        yield element.get("href", "")[1:]
    for value in element.attrib.values():
        yield from _REFERENCE.findall(value)

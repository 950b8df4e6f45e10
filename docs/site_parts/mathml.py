"""Equations as MathML, which browsers draw themselves: no script, and nothing from the network."""

from typing import TYPE_CHECKING

from docutils import nodes
from latex2mathml.converter import convert

if TYPE_CHECKING:
    from sphinx.application import Sphinx
    from sphinx.writers.html5 import HTML5Translator


def as_mathml(app: "Sphinx") -> None:
    """Add the renderer `html_math_renderer = "mathml"`."""
    app.add_html_math_renderer("mathml", (_inline, None), (_displayed, None))


def _inline(translator: "HTML5Translator", node: nodes.math) -> None:
    translator.body.append(_mathml(node, "inline"))
    raise nodes.SkipNode


def _displayed(translator: "HTML5Translator", node: nodes.math_block) -> None:
    translator.body.append(translator.starttag(node, "div", CLASS="math-block"))
    translator.body.append(_mathml(node, "block") + "</div>\n")
    raise nodes.SkipNode


def _mathml(node: nodes.Element, display: str) -> str:
    # The converter knows the rows of "split", which those of "aligned" are set like.
    return convert(node.astext().replace("{aligned}", "{split}"), display=display)

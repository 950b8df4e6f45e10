"""What is wrong with a figure on paper: texts that overlap, leave the picture or are too small to be read."""

from collections.abc import Iterator
from itertools import combinations

from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.mathtext import MathTextParser
from matplotlib.text import Text
from matplotlib.transforms import Bbox

SMALLEST = 6.0
"""Size of the smallest letters, pt: subscripts, too."""
_SLACK = 0.5
"""Points by which boxes of texts, which are larger than their letters, may overlap."""


def faults(figure: Figure) -> list[str]:
    """Return a sentence for each fault; none if the figure can be printed as it is."""
    boxes = {text: text.get_window_extent() for text in drawn_texts(figure)}
    return [*_cut_off(figure, boxes), *_overlaps(figure, boxes), *map(_too_small, filter(_is_small, boxes))]


def drawn_texts(figure: Figure) -> list[Text]:
    """Return the texts that are drawn, which are not all that axes have: ticks out of range are not."""
    drawn: list[Text] = []
    draw = Text.draw

    def noted(text: Text, *args: object, **kwargs: object) -> None:
        if text.get_visible() and text.get_text().strip():
            drawn.append(text)
        draw(text, *args, **kwargs)

    Text.draw = noted  # type: ignore[method-assign]
    try:
        figure.draw_without_rendering()
    finally:
        Text.draw = draw  # type: ignore[method-assign]
    return list(dict.fromkeys(drawn))


def _cut_off(figure: Figure, boxes: dict[Text, Bbox]) -> Iterator[str]:
    page = figure.bbox
    for text, box in boxes.items():
        if min(box.x0, box.y0, page.x1 - box.x1, page.y1 - box.y1) < 0:
            yield f"cut off: {text.get_text()!r}"


def _overlaps(figure: Figure, boxes: dict[Text, Bbox]) -> Iterator[str]:
    slack = _SLACK * figure.dpi / 72
    inner = {text: box.padded(-slack) for text, box in boxes.items() if min(box.width, box.height) > 2 * slack}
    for (one, box), (other, its) in combinations(inner.items(), 2):
        if box.overlaps(its):
            yield f"overlap: {one.get_text()!r} and {other.get_text()!r}"
    for legend in figure.legends:
        frame = legend.get_window_extent().padded(-slack)
        yield from (f"a legend lies on {ax.get_ylabel()!r}" for ax in figure.axes if frame.overlaps(ax.get_tightbbox()))


def _is_small(text: Text) -> bool:
    return min(letter_sizes(text)) < SMALLEST


def letter_sizes(text: Text) -> set[float]:
    """Return the sizes of all letters, pt, those of subscripts among them."""
    size = text.get_fontsize()
    if "$" not in text.get_text():
        return {size}
    lines = [line for line in text.get_text().splitlines() if line.strip()]
    parsed = (MathTextParser("path").parse(line, 72, FontProperties(size=size)) for line in lines)
    return {float(glyph[1]) for found in parsed for glyph in found.glyphs}


def _too_small(text: Text) -> str:
    return f"letters of {min(letter_sizes(text)):.1f} pt: {text.get_text()!r}"

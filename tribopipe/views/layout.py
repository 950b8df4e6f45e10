"""Column widths of journals, and grids of panels."""

import math
from collections.abc import Callable, Sequence
from string import ascii_lowercase
from typing import TYPE_CHECKING, Any

from tribopipe.views.run_figures import FORMULA, STYLE, P, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ONE_COLUMN, TWO_COLUMNS = 3.5, 7.2
"""Widths of a journal's columns, inches."""
_MOST_COLUMNS = 4
"""Largest number of panels side by side."""
_LETTER, _MARGIN = 0.068, 0.25
"""Width of a letter in a panel's title, and of the space next to a panel, inches."""
_SMALL: Any = {
    **STYLE,
    "font.size": 8,
    "axes.titlesize": FORMULA,
    "axes.labelsize": FORMULA,
    "legend.fontsize": 7,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "axes.linewidth": 0.6,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "lines.linewidth": 1.2,
    "figure.constrained_layout.w_pad": 0.04,
    "figure.constrained_layout.h_pad": 0.04,
}


def in_columns(plot: "Callable[P, Figure]") -> "Callable[P, Figure]":
    """Draw at the font sizes of a journal's column."""
    return styled(plot, _SMALL)


def rows_and_columns(count: int, titles: Sequence[str] = ()) -> tuple[int, int]:
    """Lay out panels, at most four side by side, or as many as their titles leave room for."""
    letters = max((len(line) for title in titles for line in title.splitlines()), default=0)
    beside = max(1, min(_MOST_COLUMNS, int(TWO_COLUMNS / (_LETTER * letters + _MARGIN))))
    rows = math.ceil(count / beside)
    return rows, math.ceil(count / rows)


def grid(count: int, key_lines: int, titles: Sequence[str] = ()) -> "tuple[Figure, list[Axes]]":
    """Lay out panels with common axes above a legend with a number of lines."""
    from tribopipe.views.canvas import ShownFigure

    rows, columns = rows_and_columns(count, titles)
    width = ONE_COLUMN if count == 1 else TWO_COLUMNS
    figure = ShownFigure(figsize=(width, 0.3 + 2.1 * rows + 0.16 * key_lines), dpi=300, layout="constrained")
    axes = list(figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).flat)
    for ax in axes[count:]:
        ax.remove()
    for ax in axes[max(0, count - columns) : count]:
        ax.tick_params(labelbottom=True)
    return figure, axes[:count]


def label_outer(axes: "Sequence[Axes]", x: str, y: str) -> None:
    """Label the outer axes of a grid."""
    columns = axes[0].get_gridspec().ncols  # type: ignore[union-attr]
    for number, ax in enumerate(axes):
        if number >= len(axes) - columns:
            ax.set_xlabel(x)
        if number % columns == 0:
            ax.set_ylabel(y)


def letter(ax: "Axes", number: int, words: str, count: int) -> None:
    """Write the title of a panel, with its letter if there are several."""
    named = f"({ascii_lowercase[number % 26]}) " if count > 1 else ""
    ax.set_title(f"{named}{words}", loc="left")

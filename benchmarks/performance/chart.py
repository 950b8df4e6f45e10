"""Cost against work: the times of each growth as a figure."""

import math
from collections.abc import Sequence
from textwrap import fill

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from page import Grown

from tribopipe.views.layout import TWO_COLUMNS, in_columns
from tribopipe.views.run_figures import GREY, PALETTE

_COLUMNS, _LETTERS = 3, 28


@in_columns
def plot_growth(grown: Sequence[tuple[str, Grown]]) -> Figure:
    """Draw the median time of each case against its size, and time ∝ sizeⁿ as it was fitted."""
    rows = math.ceil(len(grown) / _COLUMNS)
    figure = Figure(figsize=(TWO_COLUMNS, 0.2 + 2.1 * rows), layout="constrained")
    axes = list(figure.subplots(rows, _COLUMNS, squeeze=False).flat)
    for place, (ax, (case, one)) in enumerate(zip(axes, grown, strict=False)):
        _draw(ax, one)
        title = fill(f"({case}) {one.growth.what}".replace("`", ""), _LETTERS)
        ax.set_title(title.replace("k_D", "$k_D$"), loc="left")
        if place % _COLUMNS == 0:
            ax.set_ylabel("time (s)")
    for ax in axes[len(grown) :]:
        ax.remove()
    return figure


def _draw(ax: Axes, one: Grown) -> None:
    sizes, medians = np.asarray(one.growth.sizes, dtype=float), np.asarray([times.median for times in one.times])
    middle = np.exp(np.mean(np.log(medians))) * (sizes / np.exp(np.mean(np.log(sizes)))) ** one.exponent
    ax.loglog(sizes, middle, color=GREY, ls="--")
    for size, times in zip(sizes, one.times, strict=True):
        ax.loglog([size, size], [times.least, times.greatest], color=PALETTE[0], lw=0.8)
    ax.loglog(sizes, medians, color=PALETTE[0], marker="o", ms=3.5, ls="none")
    ax.text(0.05, 0.93, f"n = {one.exponent:.2f}", transform=ax.transAxes, va="top")
    # Of less than a decade, no tick would have a label.
    low, high = (math.log10(end) for end in ax.get_ylim())
    ax.set_ylim(10.0 ** math.floor(low), 10.0 ** math.ceil(high))
    ax.set_xlabel(f"number of {one.growth.of}")
    ax.minorticks_off()

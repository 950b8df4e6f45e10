"""The figure of a run that goes on: its wear so far, the law fitted to it, and what is predicted to the planned end."""

from typing import TYPE_CHECKING

import numpy as np

from tribopipe.base.units import WEAR_COEFFICIENT, axis, from_si, interval_from_si
from tribopipe.documents.quantity import between
from tribopipe.extras.live.estimate import Estimate, Posterior
from tribopipe.extras.live.state import Means
from tribopipe.physics.laws import law_label
from tribopipe.physics.uncertainty import TAILS
from tribopipe.views.decimation import thinned
from tribopipe.views.run_figures import GREY, RED, finish, law_look, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PLACES = 24


@styled
def plot_live(run_id: str, found: Posterior, estimate: Estimate, means: Means) -> "Figure":
    """Draw a run that goes on by what was found of its samples so far, as means."""
    from tribopipe.views.canvas import ShownFigure

    figure = ShownFigure(figsize=(6.3, 3.9), dpi=150, layout="constrained")
    ax = figure.subplots()
    worn = found.worn(means.sliding_distance, means.depth)
    x, y = thinned(means.sliding_distance, worn)
    ax.plot(x, from_si(y, "m", "um"), color=GREY, lw=0.8, label="depth signal, corrected for zero offset and drift")
    _draw_law(ax, found, estimate)
    ax.set_xlabel(axis("sliding distance", "m"))
    ax.set_ylabel(axis("pin wear depth", "um"))
    finish(ax, f"{run_id}: after {estimate.sliding_distance.shown('m')}", _words(estimate))
    figure.legend(loc="outside lower center", ncols=2)
    return figure


def _draw_law(ax: "Axes", found: Posterior, estimate: Estimate) -> None:
    """Draw the law as far as the run has come, and beyond in dashes, with its 95 % band."""
    reached = estimate.sliding_distance.value
    end = max(reached, estimate.planned_distance.value if estimate.planned_distance else reached)
    places = end * np.linspace(0.0, 1.0, _PLACES + 1)[1:] ** 2
    drawn = np.asarray([found.depth(place) for place in np.sort([*places, reached])])
    along = np.sort([0.0, *places, reached])
    low, middle, high = (
        from_si(np.concatenate([[0.0], np.quantile(drawn, share, axis=1)]), "m", "um")
        for share in (TAILS[0], 0.5, TAILS[1])
    )
    colour, so_far = law_look(estimate.law).colour, along <= reached
    ax.plot(along[so_far], middle[so_far], color=colour, label=f"{law_label(estimate.law)}, fitted so far")
    if end > reached:
        ax.plot(along[~so_far | (along == reached)], middle[~so_far | (along == reached)], color=colour, ls="--")
    ax.fill_between(along, low, high, color=colour, alpha=0.15, lw=0, label="95 %")
    _mark_prediction(ax, estimate)


def _mark_prediction(ax: "Axes", estimate: Estimate) -> None:
    if estimate.planned_distance is None or estimate.predicted_depth is None or estimate.predicted_interval is None:
        return
    expected = estimate.predicted_depth.value
    off = [[interval_from_si(abs(end.value - expected), "m", "um")] for end in estimate.predicted_interval]
    ax.errorbar(
        estimate.planned_distance.value,
        from_si(expected, "m", "um"),
        yerr=off,
        fmt="o",
        ms=4,
        capsize=3,
        color=RED,
        label="expected at the planned end, 95 %",
        zorder=5,
    )


def _words(estimate: Estimate) -> str:
    found, interval = estimate.wear_coefficient.shown(WEAR_COEFFICIENT), between(estimate.interval, WEAR_COEFFICIENT)
    return f"$k_\\mathrm{{D}}$ = {found}, 95 % CI: {interval}"

"""Figures of two discs against rotations of the curved one: wear of a run beside the laws, contact, and a study.

They hold what Figures 9 and 12 of the paper do, with the uncertainties besides. The discs differ in colour
(Okabe–Ito), in marker and in line style, so that the figures survive greyscale.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.units import WEAR_COEFFICIENT, axis, from_si, pretty
from tribopipe.contacts.wear import State
from tribopipe.documents.quantity import Quantity
from tribopipe.evaluation.wear.scenario import Scenario
from tribopipe.physics.laws import law_label
from tribopipe.results.evaluation import COVERAGE_FACTOR, DriftCorrection
from tribopipe.results.run import CorrectedRun, RawRun
from tribopipe.results.wear_curves import WearCurves
from tribopipe.results.wear_fit import WearFit, spoken
from tribopipe.results.wear_prediction import OUTCOMES, Outcome, WearPrediction
from tribopipe.views.layout import TWO_COLUMNS, four, in_columns, name_four
from tribopipe.views.number_format import course, power_of, turned
from tribopipe.views.plot import VOLUME, Panel
from tribopipe.views.run_figures import BLACK, GREY, MOST_LETTERS, PALETTE, draw_panel, finish, key, law_look, styled
from tribopipe.views.run_plots import QUANTITIES, contact_panels, measured_points, place_on, wear_panels

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_DASHED, _DOTTED = (0, (5, 1.6)), (0, (1.2, 1.2))
_MOST_PLACES = 240
_DOTTED_PLACES = np.linspace(0, _MOST_PLACES - 1, 41).astype(int)
"""Where states of the published scheme are drawn."""
_STEPS = "the paper's steps"
_LEAST_SHARE = 1e-5
"""Of all rotations: where an axis of powers of ten begins."""
_STYLES: tuple[Any, ...] = ("-", _DASHED, (0, (5, 1.4, 1.2, 1.4)), _DOTTED)


@styled
def plot_disc_wear(run: RawRun, fits: Sequence[WearCurves], predictions: Sequence[WearCurves] = ()) -> "Figure":
    """Draw the wear of each disc with the fitted laws, and predictions from other runs, with 95 % bands.

    What is drawn is the volume; the depth, or the track width, where that alone was measured. A disc that neither wears
    nor was measured has no panel. Where more was measured than is fitted, residuals stand below.
    """
    from tribopipe.views.canvas import ShownFigure

    along, label = course(run)
    panels = wear_panels(along, CorrectedRun(run, DriftCorrection(outcome="uncorrected"), None), fits, predictions)
    spare = any(isinstance(curves.result, WearFit) and curves.result.p_value is not None for curves in fits)
    figure = ShownFigure(figsize=(6.3, 5.2 if spare else 4.1), dpi=150, layout="constrained")
    rows = figure.subplots(
        2 if spare else 1, len(panels), sharex=True, sharey="row", squeeze=False, height_ratios=[3, 1][: 1 + spare]
    )
    power = _power(panels)
    for place, (ax, panel) in enumerate(zip(rows[0], panels, strict=True)):
        draw_panel(ax, panel, power)
        if len(panels) > 1:
            _name(ax, f"({'ab'[place]}) {panel.body}")
    rows[0][0].set_ylim(bottom=0.0)
    if spare:
        _draw_residuals(rows[1], fits, [panel.body for panel in panels], run, along)
    for ax in rows[-1]:
        ax.set_xlabel(label)
    for ax in rows[0][1:]:
        ax.set_ylabel("")
    _head(rows[0][0], f"{run.id}: wear of {'both discs' if len(panels) > 1 else f'the {panels[0].body}'}", fits)
    key(figure, rows.flat)
    return figure


def _power(panels: Sequence[Panel]) -> int:
    """Return the power of a thousand to leave out of the axis; of volumes only, which are as small as that."""
    if panels[0].unit != VOLUME:
        return 0
    ends = [float(from_si(np.nanmax(curve.y), "m^3", "mm^3")) for panel in panels for curve in panel.curves]
    return power_of(max([*ends, *(one.y for panel in panels for one in panel.marks)]))


def _draw_residuals(
    axes: "Sequence[Axes]", fits: Sequence[WearCurves], discs: Sequence[str], run: RawRun, along: Column
) -> None:
    """Draw what is left of everything measured, over its standard uncertainty."""
    for ax, disc in zip(axes, discs, strict=True):
        ax.axhline(0, color=BLACK, lw=0.8)
        for limit in (-COVERAGE_FACTOR, COVERAGE_FACTOR):
            ax.axhline(limit, color=GREY, ls=_DASHED, lw=0.8)
        for curves in fits:
            for point in measured_points([curves]):
                spread = point.value.measured.standard_uncertainty
                if spoken(point.disc) != disc or not spread:
                    continue
                mark = QUANTITIES[point.what].marker
                ax.plot(
                    place_on(along, run, point.value.place),
                    [(point.value.measured.value - point.value.fitted.value) / spread],
                    ls="",
                    ms=4,
                    marker=mark,
                    mec=law_look(curves.result.model).colour,
                    mfc="none",
                )
                ax.plot(
                    [], [], ls="", marker=mark, ms=4, mec=GREY, mfc="none", label=f"residual of {spoken(point.what)}"
                )
    axes[0].set_ylabel("residual / u")
    low, high = axes[0].get_ylim()
    axes[0].set_ylim(min(low, -2.5), max(high, 2.5))


@styled
def plot_disc_contact(corrected: CorrectedRun, curves: WearCurves) -> "Figure":
    """Draw wear depth, mean pressure, a_x and a_z by a law along a run, with 95 % bands (paper, Fig. 9).

    The depth signal, corrected, stands beside the depth of both discs.
    """
    along, label = course(corrected.run)
    figure, axes = four(6.3)
    for ax, panel in zip(axes, contact_panels(along, corrected, [curves]), strict=True):
        draw_panel(ax, panel)
    name_four(axes, label)
    _head(axes[0], f"{corrected.id}: contact", [curves])
    key(figure, axes, 3)
    return figure


class _Panel(NamedTuple):
    """One of the four panels of Fig. 9."""

    outcome: Outcome
    label: str
    unit: str
    side: Literal["left", "right"]
    """Where curves leave room for the letter."""


_PANELS = (
    _Panel("depth", "wear depth", "um", "left"),
    _Panel("pressure", "mean pressure p", "GPa", "right"),
    _Panel("half_width", "$a_x$", "um", "left"),
    _Panel("half_length", "$a_z$", "um", "right"),
)


@in_columns
def plot_disc_model(scenarios: Mapping[str, Scenario], rotations: float, steps: int | None = None) -> "Figure":
    """Draw wear depth, mean pressure, a_x and a_z of named scenarios up to some rotations (paper, Fig. 9).

    Beside them, as dots, the paper's scheme in so many equal ``steps``, where that is given; it starts from Hertz's
    ellipse. The depth is that of both discs. Rotations, depth and a_x have logarithmic axes where there are several
    scenarios, which may wear at very different rates.
    """
    figure, axes = four(TWO_COLUMNS)
    several = len(scenarios) > 1
    share = np.geomspace(_LEAST_SHARE, 1.0, _MOST_PLACES) if several else np.linspace(0.0, 1.0, _MOST_PLACES) ** 1.5
    along, label = (share * rotations, "rotations of the curved disc") if several else turned(share * rotations)
    for number, (name, scenario) in enumerate(scenarios.items()):
        look = {"color": PALETTE[number % len(PALETTE)], "ls": _STYLES[number % len(_STYLES)], "label": name}
        _draw_states(axes, along, scenario.worn(share * rotations), **look)
    for scenario in scenarios.values() if steps is not None else ():
        grid = np.linspace(0.0, rotations, (steps or 1) + 1)
        at = np.unique(np.rint(np.interp(share[_DOTTED_PLACES] * rotations, grid, np.arange(len(grid)))).astype(int))
        states = scenario.published(grid[at], steps or 1)
        dots = {"color": BLACK, "ls": "", "marker": "o", "ms": 1.6, "mew": 0, "zorder": 4, "label": _STEPS}
        _draw_states(axes, grid[at] * along[-1] / rotations, states, **dots)
    if several:
        _magnify(axes)
    _finish_four(axes, label)
    for ax, named in zip(axes, "abcd", strict=True):
        ax.set_title(f"({named})", loc="left")
    key(figure, axes, 4)
    return figure


def _magnify(axes: "Sequence[Axes]") -> None:
    """Make the axes logarithmic of what spreads over powers of ten: rotations, wear depth and a_x."""
    from matplotlib.ticker import LogLocator, NullFormatter, ScalarFormatter

    for ax, panel in zip(axes, _PANELS, strict=True):
        ax.set_xscale("log")
        if panel.outcome in ("depth", "half_width"):
            ax.set_yscale("log")
        if panel.outcome == "half_width":
            ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            ax.yaxis.set_major_formatter(ScalarFormatter())
            ax.yaxis.set_minor_formatter(NullFormatter())


def _draw_states(axes: "Sequence[Axes]", along: Column, worn: State, **look: Any) -> None:
    for ax, panel in zip(axes, _PANELS, strict=True):
        ax.plot(along, from_si(worn[panel.outcome], OUTCOMES[panel.outcome], panel.unit), **look)


def _finish_four(axes: "Sequence[Axes]", label: str) -> None:
    for ax, panel in zip(axes, _PANELS, strict=True):
        ax.set_ylabel(axis(panel.label, panel.unit))
        ax.margins(x=0.02)
    for ax in axes[2:]:
        ax.set_xlabel(label)


def _head(ax: "Axes", title: str, laws: Sequence[WearCurves]) -> None:
    """Put title and coefficients over a figure; they may be wider than its first panel."""
    finish(ax, title, "\n".join(_words(curves.result) for curves in laws))
    ax.texts[-1].set_in_layout(False)
    ax.margins(x=0.02)


def _words(result: WearFit | WearPrediction) -> str:
    found = _coefficients(result)
    unit = pretty(WEAR_COEFFICIENT)
    numbers = {disc: value.shown(WEAR_COEFFICIENT).removesuffix(f" {unit}") for disc, value in found.items()}
    each = ", ".join(f"{number} ({disc.removesuffix('_disc')})" for disc, number in numbers.items())
    head = f"{law_label(result.model)}, {result.distance_per_rotation}:"
    between = "\n" if len(head + each) + len(unit) > MOST_LETTERS - 8 else " "
    return f"{head}{between}$k_\\mathrm{{D}}$ / {unit} = {each}"


def _coefficients(result: WearFit | WearPrediction) -> dict[str, Quantity]:
    return {name: body.wear_coefficient for name, body in result.bodies.items() if body.wear_coefficient.value}


def _name(ax: "Axes", words: str, side: Literal["left", "right"] = "left") -> None:
    ax.text(0.03 if side == "left" else 0.97, 0.97, words, transform=ax.transAxes, ha=side, va="top")

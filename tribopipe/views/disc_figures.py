"""Figures of two discs against rotations of the curved one: wear of a run beside the laws, contact, and a study.

They hold what Figures 9 and 12 of the paper do, with the uncertainties besides. The discs differ in colour
(Okabe–Ito), in marker and in line style, so that the figures survive greyscale.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, get_args

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.units import WEAR_COEFFICIENT, axis, from_si, pretty
from tribopipe.documents.contact import DISCS, DiscName
from tribopipe.documents.quantity import Quantity
from tribopipe.evaluation.measurements.twin_disc import Measured
from tribopipe.evaluation.wear.twin_disc.scenario import DiscScenario, published_discs
from tribopipe.physics.laws import law_label
from tribopipe.physics.twin_disc import DiscWear
from tribopipe.results.evaluation import COVERAGE_FACTOR
from tribopipe.results.run import CorrectedRun, RawRun
from tribopipe.results.wear_curves import Band, WearCurves
from tribopipe.results.wear_fit import FittedValue, WearFit, spoken
from tribopipe.results.wear_prediction import OUTCOMES, Outcome, WearPrediction
from tribopipe.views.decimation import thinned
from tribopipe.views.layout import TWO_COLUMNS, in_columns
from tribopipe.views.number_format import course, power_of, powered_axis, turned
from tribopipe.views.run_figures import BLACK, GREEN, GREY, PALETTE, RED, finish, law_look, styled

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


class ShownQuantity(NamedTuple):
    """How a quantity is drawn: of each disc, what a law calls it, the axis, and the unit of that."""

    outcomes: tuple[Outcome, Outcome]
    label: str
    unit: str
    marker: str
    factor: float = 1.0


QUANTITIES: dict[Measured, ShownQuantity] = {
    "wear_volume": ShownQuantity(("curved_volume", "flat_volume"), "volume worn off", "mm^3", "o"),
    "wear_depth": ShownQuantity(("curved_depth", "flat_depth"), "wear depth", "um", "s"),
    "track_width": ShownQuantity(("half_width", "half_width"), "track width", "um", "^", 2.0),
}
"""What can be measured on a disc, the usual first."""


@dataclass(frozen=True)
class MeasuredPoint:
    """One thing measured on a disc of a run."""

    disc: DiscName
    what: Measured
    value: FittedValue

    @property
    def spread(self) -> float:
        """Half width of its 95 % interval, in its own unit."""
        return COVERAGE_FACTOR * (self.value.measured.standard_uncertainty or 0.0)


@styled
def plot_disc_wear(run: RawRun, fits: Sequence[WearCurves], predictions: Sequence[WearCurves] = ()) -> "Figure":
    """Draw the wear of each disc with the fitted laws, and predictions from other runs, with 95 % bands.

    What is drawn is the volume; the depth, or the track width, where that alone was measured. A disc that neither wears
    nor was measured has no panel. Where more was measured than is fitted, residuals stand below.
    """
    from tribopipe.views.canvas import ShownFigure

    points = _points(fits)
    measured = [kind for kind in QUANTITIES if any(point.what == kind for point in points)]
    what: Measured = measured[0] if measured else "wear_volume"
    shown, discs = QUANTITIES[what], _drawn(points, [*fits, *predictions])
    spare = any(isinstance(curves.result, WearFit) and curves.result.p_value is not None for curves in fits)
    figure = ShownFigure(figsize=(6.3, 5.2 if spare else 4.1), dpi=150, layout="constrained")
    rows = figure.subplots(
        2 if spare else 1, len(discs), sharex=True, sharey="row", squeeze=False, height_ratios=[3, 1][: 1 + spare]
    )
    along, label = course(run)
    scale = _scale(what, points, [*fits, *predictions])
    for place, (ax, disc) in enumerate(zip(rows[0], discs, strict=True)):
        for curves, colour, style, name in _laws(fits, predictions):
            outcome = shown.outcomes[DISCS.index(disc)]
            band = _scaled(curves.bands[outcome], OUTCOMES[outcome], shown.unit, shown.factor / 10.0**scale)
            _draw_band(ax, along, band, color=colour, ls=style, label=name)
        _draw_measured(ax, [one for one in points if (one.disc, one.what) == (disc, what)], shown.unit, scale, run)
        if len(discs) > 1:
            _name(ax, f"({'ab'[place]}) {spoken(disc)}")
    rows[0][0].set_ylim(bottom=0.0)
    rows[0][0].set_ylabel(powered_axis(shown.label, scale, shown.unit))
    if spare:
        _draw_residuals(rows[1], fits, discs, run)
    for ax in rows[-1]:
        ax.set_xlabel(label)
    _head(rows[0][0], f"{run.id}: wear of {'both discs' if len(discs) > 1 else f'the {spoken(discs[0])}'}", fits)
    _key(figure, rows.flat, 2)
    return figure


def _points(fits: Sequence[WearCurves]) -> list[MeasuredPoint]:
    """Return what was measured on the discs, by the first fit, which is the same in all."""
    for curves in fits:
        if isinstance(curves.result, WearFit):
            return [measured_point(value) for value in curves.result.measurements]
    return []


def measured_point(value: FittedValue) -> MeasuredPoint:
    """Return on which disc something was measured, and what it was."""
    disc = next(disc for disc in DISCS if value.name.startswith(disc))
    what: Measured = next(kind for kind in get_args(Measured) if value.name.startswith(f"{disc}_{kind}"))
    return MeasuredPoint(disc, what, value)


def _drawn(points: Sequence[MeasuredPoint], curves: Sequence[WearCurves]) -> list[DiscName]:
    """Return the discs that were measured, or that a law wears."""
    worn = {
        disc: any(np.any(one.bands[outcome].best > 0) for one in curves)
        for disc, outcome in zip(DISCS, QUANTITIES["wear_volume"].outcomes, strict=True)
    }
    return [disc for disc in DISCS if worn[disc] or any(point.disc == disc for point in points)]


def _scale(what: Measured, points: Sequence[MeasuredPoint], curves: Sequence[WearCurves]) -> int:
    """Return the power of a thousand to leave out of the axis; of volumes only, which are as small as that."""
    if what != "wear_volume":
        return 0
    ends = [float(np.nanmax(one.bands[outcome].best)) for one in curves for outcome in QUANTITIES[what].outcomes]
    ends += [point.value.measured.value for point in points if point.what == what]
    return power_of(float(from_si(max(ends), "m^3", "mm^3")))


def _laws(fits: Sequence[WearCurves], predictions: Sequence[WearCurves]) -> Iterator[tuple[WearCurves, str, str, str]]:
    """Give each law its colour, line style and name."""
    for curves in fits:
        law = curves.result.model
        yield curves, law_look(law).colour, law_look(law).fitted, f"{law_label(law)}, fitted"
    for curves in predictions:
        law = curves.result.model
        source = curves.result.reference if isinstance(curves.result, WearPrediction) else None
        yield curves, GREEN, law_look(law).predicted, f"{law_label(law)}, predicted from {source or 'given k_D'}"


def _draw_measured(ax: "Axes", points: Sequence[MeasuredPoint], unit: str, scale: int, run: RawRun) -> None:
    if not points:
        return
    si = points[0].value.measured.unit
    ax.errorbar(
        _turned(run, [point.value.place for point in points]),
        [from_si(point.value.measured.value, si, unit) / 10.0**scale for point in points],
        yerr=[from_si(point.spread, si, unit) / 10.0**scale for point in points],
        fmt="o",
        ms=4,
        capsize=3,
        color=RED,
        label="measured, 95 %",
        zorder=5,
    )


def _turned(run: RawRun, rotations: Sequence[float]) -> Column:
    """Return rotations in the power of a thousand that a run's are drawn in."""
    return np.asarray(rotations) / 10.0 ** power_of(float(np.nanmax(run.columns["rotations"])))


def _draw_residuals(axes: "Sequence[Axes]", fits: Sequence[WearCurves], discs: Sequence[DiscName], run: RawRun) -> None:
    """Draw what is left of everything measured, over its standard uncertainty."""
    for ax, disc in zip(axes, discs, strict=True):
        ax.axhline(0, color=BLACK, lw=0.8)
        for limit in (-COVERAGE_FACTOR, COVERAGE_FACTOR):
            ax.axhline(limit, color=GREY, ls=_DASHED, lw=0.8)
        for curves, *_ in _laws(fits, ()):
            for point in _points([curves]):
                spread = point.value.measured.standard_uncertainty
                if point.disc != disc or not spread:
                    continue
                mark = QUANTITIES[point.what].marker
                ax.plot(
                    _turned(run, [point.value.place]),
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
    run = corrected.run
    along, label = course(run)
    figure, axes = _four(6.3)
    if corrected.wear_depth is not None:
        x, y = thinned(along, corrected.wear_depth)
        axes[0].plot(x, from_si(y, "m", "um"), color=GREY, lw=0.6, label="depth signal, corrected")
    worn = _drawn((), [curves])
    for outcome, look in _depth_looks(worn).items():
        _draw_band(axes[0], along, _scaled(curves.bands[outcome], "m", "um"), **look)
    for ax, panel in zip(axes[1:], _PANELS[1:], strict=True):
        band = _scaled(curves.bands[panel.outcome], OUTCOMES[panel.outcome], panel.unit)
        _draw_band(ax, along, band, color=BLACK, label="")
    _finish_four(axes, label)
    for ax, panel, named in zip(axes, _PANELS, "abcd", strict=True):
        _name(ax, f"({named})", panel.side)
    _head(axes[0], f"{run.id}: contact", [curves])
    _key(figure, axes, 4)
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


def _depth_looks(worn: Sequence[DiscName]) -> dict[Outcome, dict[str, Any]]:
    """Give wear depths their looks: of both discs, and of each where both wear."""
    looks: dict[Outcome, dict[str, Any]] = {"depth": {"color": BLACK, "ls": "-", "label": "both discs"}}
    looks["curved_depth"] = {"color": PALETTE[0], "ls": _DASHED, "label": "curved disc"}
    looks["flat_depth"] = {"color": PALETTE[1], "ls": _DOTTED, "label": "flat disc"}
    if len(worn) == 2:
        return looks
    only: Outcome = "flat_depth" if worn == ["flat_disc"] else "curved_depth"
    return {only: {**looks[only], "ls": "-"}}


@in_columns
def plot_disc_model(scenarios: Mapping[str, DiscScenario], rotations: float, steps: int | None = None) -> "Figure":
    """Draw wear depth, mean pressure, a_x and a_z of named scenarios up to some rotations (paper, Fig. 9).

    Beside them, as dots, the paper's scheme in so many equal ``steps``, where that is given; it starts from Hertz's
    ellipse. The depth is that of both discs. Rotations, depth and a_x have logarithmic axes where there are several
    scenarios, which may wear at very different rates.
    """
    figure, axes = _four(TWO_COLUMNS)
    several = len(scenarios) > 1
    share = np.geomspace(_LEAST_SHARE, 1.0, _MOST_PLACES) if several else np.linspace(0.0, 1.0, _MOST_PLACES) ** 1.5
    along, label = (share * rotations, "rotations of the curved disc") if several else turned(share * rotations)
    for number, (name, scenario) in enumerate(scenarios.items()):
        look = {"color": PALETTE[number % len(PALETTE)], "ls": _STYLES[number % len(_STYLES)], "label": name}
        _draw_states(axes, along, scenario.worn(share * rotations), **look)
    for scenario in scenarios.values() if steps is not None else ():
        grid, worn = published_discs(scenario, rotations, steps or 1)
        at = np.unique(np.rint(np.interp(share[_DOTTED_PLACES] * rotations, grid, np.arange(len(grid)))).astype(int))
        states = DiscWear(*(getattr(worn, one.name)[at] for one in fields(DiscWear)))
        dots = {"color": BLACK, "ls": "", "marker": "o", "ms": 1.6, "mew": 0, "zorder": 4, "label": _STEPS}
        _draw_states(axes, grid[at] * along[-1] / rotations, states, **dots)
    if several:
        _magnify(axes)
    _finish_four(axes, label)
    for ax, named in zip(axes, "abcd", strict=True):
        ax.set_title(f"({named})", loc="left")
    _key(figure, axes, 4)
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


def _draw_states(axes: "Sequence[Axes]", along: Column, worn: DiscWear, **look: Any) -> None:
    for ax, panel in zip(axes, _PANELS, strict=True):
        depth = worn.curved_depth + worn.flat_depth
        values = depth if panel.outcome == "depth" else getattr(worn, panel.outcome)
        ax.plot(along, from_si(values, OUTCOMES[panel.outcome], panel.unit), **look)


def _four(width: float) -> "tuple[Figure, list[Axes]]":
    from tribopipe.views.canvas import ShownFigure

    figure = ShownFigure(figsize=(width, 5.4), dpi=150, layout="constrained")
    return figure, list(figure.subplots(2, 2, sharex=True).flat)


def _finish_four(axes: "Sequence[Axes]", label: str) -> None:
    for ax, panel in zip(axes, _PANELS, strict=True):
        ax.set_ylabel(axis(panel.label, panel.unit))
        ax.margins(x=0.02)
    for ax in axes[2:]:
        ax.set_xlabel(label)


def _scaled(band: Band, si: str, unit: str, factor: float = 1.0) -> Band:
    return Band(*(from_si(line, si, unit) * factor for line in (band.best, band.lower, band.upper)), unit=unit)


def _draw_band(ax: "Axes", along: Column, band: Band, **look: Any) -> None:
    x, best, lower, upper = _smooth(along, band.best, band.lower, band.upper)
    ax.plot(x, best, **look)
    ax.fill_between(x, lower, upper, color=look["color"], alpha=0.15, lw=0)


def _smooth(along: Column, *lines: Column) -> list[Column]:
    """Take as many samples as a smooth curve needs, closer where wear is steepest."""
    placed = np.isfinite(along)
    last = int(np.count_nonzero(placed)) - 1
    steep, even = np.geomspace(1, max(last, 1), _MOST_PLACES // 2), np.linspace(0, last, _MOST_PLACES // 2)
    kept = np.unique(np.concatenate([[0], steep, even]).astype(int).clip(0, last))
    return [column[placed][kept] for column in (along, *lines)]


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
    return f"{law_label(result.model)}, {result.distance_per_rotation}: $k_\\mathrm{{D}}$ / {unit} = {each}"


def _coefficients(result: WearFit | WearPrediction) -> dict[str, Quantity]:
    return {name: body.wear_coefficient for name, body in result.bodies.items() if body.wear_coefficient.value}


def _name(ax: "Axes", words: str, side: Literal["left", "right"] = "left") -> None:
    ax.text(0.03 if side == "left" else 0.97, 0.97, words, transform=ax.transAxes, ha=side, va="top")


def _key(figure: "Figure", axes: "Iterable[Axes]", columns: int) -> None:
    """Put one legend of all panels below them."""
    handles = {label: line for ax in axes for line, label in zip(*ax.get_legend_handles_labels(), strict=True)}
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=columns)

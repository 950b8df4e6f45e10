"""Figures of a study at the column widths of journals: wear of all runs under one law, friction, and effective k_D.

They have the content of Figures 1, 3, 4, 5, 6 and 12 of the paper, and also show uncertainties. Runs are in the order
of their loads. Runs, or bodies, differ in color (Okabe–Ito), line style and marker, so that the figures can be printed
in grayscale.
"""

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import cycle
from textwrap import wrap
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.units import WEAR_COEFFICIENT, axis, from_si, show, show_force
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName
from tribopipe.evaluation.study.k_d_along_test import EffectiveCoefficient
from tribopipe.evaluation.study.member import Member
from tribopipe.physics.laws import law_heading
from tribopipe.results.evaluation import FrictionFit
from tribopipe.results.study import AGREEMENT, LawResult, RunVerdict, StudyCurve, StudyResult, Verdict
from tribopipe.views.decimation import thinned
from tribopipe.views.layout import ONE_COLUMN, TWO_COLUMNS, grid, in_columns, label_outer, letter, rows_and_columns
from tribopipe.views.plot import (
    MICRONS,
    RATIO,
    VOLUME,
    Panel,
    axis_label,
    coefficient_power,
    coefficient_words,
    power_of,
    powered_axis,
    scaled_coefficient,
    slid,
)
from tribopipe.views.run_figures import BLACK, FORMULA, GREY, PALETTE, key
from tribopipe.views.run_plots import friction_panels
from tribopipe.views.study_plots import LawCoefficient, friction_range, law_curves, study_panels

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MARKERS = ("o", "s", "^", "D", "v", "P")
_DASHES = ((0, (5, 1.6)), (0, (5, 1.4, 1.2, 1.4)), (0, (2.2, 1.2)), (0, (7, 1.2, 1.2, 1.2, 1.2, 1.2)))
_DEPARTING: dict[Verdict | None, tuple[str, str]] = {
    "under-predicts": ("x", "under-predicted"),
    "over-predicts": ("+", "over-predicted"),
    "not decidable": ("$?$", "inconclusive"),
}
"""Marks of measurements that are not consistent with the law."""
_KEY_ORDER = ("measured", "smoothing", "Archard", "Sarkar")
"""Order of the legend of effective k_D."""
_EVERY = 2
"""Every n-th average is drawn."""
_LETTERS = 32
"""Largest number of letters on a line above a panel."""
_APART, _ASIDE = 0.04, 0.01
"""Shares of the axis: distance below which runs end together, and offset of bodies that would hide each other."""


class _Look(NamedTuple):
    """Style of one run, or one body, in all panels."""

    name: str
    """Name in the legend."""
    color: str
    dashes: Any
    marker: str

    def marks(self, size: float, *, filled: bool) -> dict[str, Any]:
        """Return the style of its markers: those of runs that identify k_D are filled."""
        fill = None if filled else "white"
        return {"color": self.color, "marker": self.marker, "ms": size, "mew": size / 4.5, "mfc": fill}


_GREY = _Look("", GREY, "", "o")
_AVERAGE, _MEASURED = 2.3, 3.2
"""Sizes of markers, points."""


@in_columns
def plot_study_wear(
    result: StudyResult,
    law: LawName,
    curves: Sequence[StudyCurve],
    recorded: Mapping[str, tuple[Column, Column]] | None = None,
) -> "Figure":
    """Draw the wear of all runs with one law, 95 % bands and post-test measurements.

    Wear that was recorded along the runs is in one panel, a color for each run (paper, Figs. 1, 4 and 6); the small
    markers are what the study compares, averages over sections of the distance. ``recorded`` holds sliding distance
    and wear depth, m, by run, for the thin lines. The volume of a counterbody has a panel of its own.

    Runs that were measured only at the end share a panel if they have the same load and slip, with a color for each
    body; the law is drawn along the longest of them (paper, Fig. 12). A panel below shows measured over predicted wear.
    Runs on which another quantity was measured are counted in the legend.
    In a study of both kinds of runs, only those with a recorded wear curve are drawn.
    """
    found, own = result.law(law), [curve for curve in curves if curve.model == law]
    by_curve = {curve.run_id for curve in own if curve.measured is not None}
    along = bool(by_curve)
    runs = [run for run in sorted(found.runs, key=_severity) if run.id in (by_curve or {curve.run_id for curve in own})]
    content = list(_by_body(found, curves, runs) if along else _by_conditions(found, curves, runs))
    looks, single = _looks_of_runs(runs) if along else _looks_of_bodies(found), len(content) == 1
    last = max(run.end.value for run in runs)
    far = power_of(last)
    lines = sum(0.2 + 0.14 * look.name.count("\n") for look in looks.values()) if along else 0.0
    figure, columns = _columns(len(content), lines)
    groups = [runs] if along else [one.runs for one in content]
    shifts = {name: shift for some in groups for name, shift in _shifts(some, last, along=along).items()}
    for number, (one, axes) in enumerate(zip(content, columns, strict=True)):
        for place, panel in enumerate(one.panels):
            row = place % len(axes)
            aside = row * _ASIDE * last * (place - len(one.panels) / 2)
            draw = _Drawing(axes[row], looks, {name: shift + aside for name, shift in shifts.items()})
            draw.panel(panel, far, 0 if row else one.power)
        if one.heading:
            letter(axes[0], number, one.heading, len(content))
    for run_id, line in (recorded or {}).items():
        if run_id in looks:
            x, y = thinned(*line)
            depth = from_si(y, MICRONS.si, MICRONS.shown)
            columns[0][0].plot(x, depth, color=looks[run_id].color, lw=0.4, alpha=0.35, zorder=1.5)
    _finish(columns, axis_label(curves[0].along, far), [one.label for one in content])
    columns[0][0].set_xlim(*(end / 10.0**far for end in (-0.01 * last, 1.03 * last + max(shifts.values()))))
    figure.suptitle(_law_words(found, ",\n" if single else ", "), x=0.01, ha="left", fontsize=FORMULA)
    panels = [panel for one in content for panel in one.panels]
    figure.legend(
        handles=[*_looks_key(looks), *_key(runs, panels, thin=bool(recorded))],
        loc="outside right upper" if along and single else "outside lower center",
        ncols=1 if single else 2 if along else 4,
        handlelength=3.0,
    )
    return figure


class _Column(NamedTuple):
    """What is drawn in the axes of a column."""

    heading: str
    runs: list[RunVerdict]
    panels: list[Panel]
    power: int
    """Power of ten of the wear axis."""
    label: str
    """Of that axis."""


def _by_body(found: LawResult, curves: Sequence[StudyCurve], runs: list[RunVerdict]) -> Iterator[_Column]:
    """Yield one column for each body, the runs in it one by one."""
    for panel in study_panels(found, curves, [run.id for run in runs]):
        if panel.unit != RATIO:
            power = power_of(_highest([panel])) if panel.unit == VOLUME else 0
            label = powered_axis(f"{panel.body} {panel.quantity}", power, panel.unit.shown)
            yield _Column("", runs, [panel], power, label)


def _by_conditions(found: LawResult, curves: Sequence[StudyCurve], runs: list[RunVerdict]) -> Iterator[_Column]:
    """Yield one column for each load and slip, with both bodies."""
    groups: dict[str, list[RunVerdict]] = {}
    for run in runs:
        groups.setdefault(_conditions(run.normal_load, run.slip), []).append(run)
    drawn = {words: list(study_panels(found, curves, [run.id for run in some])) for words, some in groups.items()}
    wear = next(iter(drawn.values()))[0]
    power = power_of(max(map(_highest, drawn.values()))) if wear.unit == VOLUME else 0
    label = powered_axis(wear.quantity, power, wear.unit.shown)
    for words, panels in drawn.items():
        yield _Column(words, groups[words], panels, power, label)


def _looks_of_runs(runs: Sequence[RunVerdict]) -> dict[str, _Look]:
    """Return the line styles of runs, the most severe first; runs that identify k_D have solid lines."""
    dashes = cycle(_DASHES)
    looks = {}
    for number, (run, (words, below)) in enumerate(zip(runs, _names(runs).values(), strict=True)):
        role = "fitted" if run.role == "fitted" else AGREEMENT[run.outcome]
        line = "-" if run.role == "fitted" else next(dashes)
        color, marker = PALETTE[number % len(PALETTE)], _MARKERS[number % len(_MARKERS)]
        looks[run.id] = _Look(f"{words}, {role}{below}", color, line, marker)
    return dict(reversed(looks.items()))


def _looks_of_bodies(law: LawResult) -> dict[str, _Look]:
    # Bodies of another contact have names of their own.
    names = map(spoken, dict.fromkeys((*law.bodies, *(body for run in law.runs for body in run.bodies))))
    looks = map(_Look._make, zip(names, cycle(PALETTE), cycle(("-", *_DASHES)), cycle(_MARKERS), strict=False))
    return {look.name: look for look in looks}


def _shifts(runs: Sequence[RunVerdict], last: float, *, along: bool) -> dict[str, float]:
    """Return shifts of runs that end close together, so that their error bars do not hide each other, nor curves."""
    near: list[list[str]] = []
    before = -math.inf
    for run in runs if along else sorted(runs, key=lambda run: run.end.value):
        if (along and near) or run.end.value - before < _APART / 2 * last:
            near[-1].append(run.id)
        else:
            near.append([run.id])
        before = run.end.value
    step = (_APART / 2 if along else _APART) * last
    return {
        name: (place + (0.8 if along else (1 - len(some)) / 2)) * step if len(some) > 1 else 0.0
        for some in near
        for place, name in enumerate(some)
    }


class _Drawing(NamedTuple):
    """Axes and styles of the panels of a study."""

    ax: "Axes"
    looks: Mapping[str, _Look]
    """Styles by run, or by body."""
    shifts: Mapping[str, float]
    """Shifts of the post-test measurements, by run."""

    def panel(self, panel: Panel, *powers: int) -> None:
        """Draw curves and marks; if bodies are distinguished, the law only along the longest run."""
        x_unit, y_unit = (10.0**power for power in powers)
        body = self.looks.get(panel.body)
        curves = [max(panel.curves, key=lambda one: float(one.x[-1]))] if body else panel.curves
        for curve in curves:
            values = (curve.y, curve.lower, curve.upper)
            shown = [from_si(one, curve.unit.si, curve.unit.shown) / y_unit for one in values if one is not None]
            draw = self._averages if curve.role == "measured" else self._share if panel.unit == RATIO else self._law
            draw(body or self.looks[curve.run], curve.x / x_unit, *shown)
        for one in panel.marks:
            look = body or self.looks[one.run]
            x, value, half = (one.x + self.shifts[one.run]) / x_unit, one.y / y_unit, one.half_width / y_unit
            marks = look.marks(_MEASURED, filled=one.role == "fitted")
            self.ax.errorbar(x, value, yerr=half, ls="", elinewidth=0.9, capsize=2, zorder=5, **marks)
            if one.outcome in _DEPARTING:
                self._cross(x, value + half, one.outcome)

    def _averages(self, look: _Look, x: Column, y: Column, low: Column, high: Column) -> None:
        for edge in (low, high):
            self.ax.plot(x, edge, color=look.color, ls=":", lw=0.6, alpha=0.9, zorder=2)
        marks = look.marks(_AVERAGE, filled=False)
        self.ax.plot(x[1::_EVERY], y[1::_EVERY], ls="", zorder=4, **marks)

    def _law(self, look: _Look, x: Column, y: Column, low: Column, high: Column) -> None:
        from matplotlib.patheffects import withStroke

        halo = withStroke(linewidth=1.8, foreground="white")
        self.ax.fill_between(x, low, high, color=look.color, alpha=0.2, lw=0, zorder=1.8)
        self.ax.plot(x, y, color=look.color, ls=look.dashes, zorder=3, path_effects=[halo])

    def _share(self, look: _Look, x: Column, y: Column, low: Column, high: Column) -> None:
        self.ax.fill_between(x, low, high, color=look.color, alpha=0.2, lw=0)
        self.ax.plot(x, y, color=GREY, lw=0.6, zorder=1)

    def _cross(self, x: float, top: float, outcome: Verdict | None) -> None:
        from matplotlib.transforms import offset_copy

        above = offset_copy(self.ax.transData, self.ax.figure, y=6, units="points")  # type: ignore[arg-type]
        self.ax.plot(x, top, transform=above, clip_on=False, **_cross(outcome))


def _cross(outcome: Verdict | None) -> dict[str, Any]:
    return {"color": BLACK, "marker": _DEPARTING[outcome][0], "ls": "", "ms": 4.5, "mew": 1.0, "zorder": 6}


def _highest(panels: Sequence[Panel]) -> float:
    """Return the largest wear by a law or a measurement, in the shown unit."""
    wear = [panel for panel in panels if panel.unit != RATIO]
    ends = [float(from_si(curve.y[-1], curve.unit.si, curve.unit.shown)) for panel in wear for curve in panel.curves]
    return max([*ends, *(one.y for panel in wear for one in panel.marks)], default=0.0)


def _columns(count: int, beside: float) -> "tuple[Figure, list[tuple[Axes, ...]]]":
    """Lay out one wide panel next to a legend of a given height, or several panels, each with a smaller one below."""
    from tribopipe.views.canvas import ShownFigure

    rows, columns = rows_and_columns(count)
    width = ONE_COLUMN if count == 1 and not beside else TWO_COLUMNS
    recorded = max(3.7, 1.9 + beside) if count == 1 else 3.4 + beside
    height = recorded if beside else (1.9 if count == 1 else 0.9) + 2.9 * rows
    figure = ShownFigure(figsize=(width, height), dpi=300, layout="constrained")
    each = [1.0] if beside else [2.4, 1.0]
    axes = figure.subplots(
        rows * len(each),
        columns,
        sharex=True,
        sharey=False if beside else "row",
        squeeze=False,
        height_ratios=each * rows,
    )
    found = []
    for number in range(rows * columns):
        row, column = divmod(number, columns)
        own = tuple(axes[len(each) * row : len(each) * (row + 1), column])
        found.append(own)
        for ax in own if number >= count else ():
            ax.remove()
        own[-1].tick_params(labelbottom=True)
    return figure, found[:count]


def _finish(columns: "Sequence[tuple[Axes, ...]]", along: str, wear: Sequence[str]) -> None:
    """Label the axes, of equal ones the outer ones, and leave room above error bars; points at the axis stay whole."""
    _, beside = rows_and_columns(len(columns))
    for number, axes in enumerate(columns):
        axes[-1].set_xlabel(along)
        for ax, label, least in zip(axes, (wear[number], "measured /\npredicted"), (None, 0.9), strict=False):
            if number % beside == 0 or label != wear[number - 1]:
                low, high = ax.get_ylim()
                usual = low if low < -0.08 * high else -0.02 * high
                ax.set_ylim(usual if least is None else min(least, low), high + 0.08 * (high - low))
                ax.set_ylabel(label)


def _looks_key(looks: Mapping[str, _Look]) -> "list[Artist]":
    """Name runs or bodies."""
    from matplotlib.lines import Line2D

    return [
        Line2D([], [], ls=look.dashes, label=look.name, **look.marks(_MEASURED, filled=True)) for look in looks.values()
    ]


def _key(runs: Sequence[RunVerdict], panels: Sequence[Panel], *, thin: bool) -> "list[Artist]":
    """Return the legend entries common to all runs."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    marks = [one for panel in panels for one in panel.marks]
    averaged = any(curve.role == "measured" for panel in panels for curve in panel.curves)

    def grey(label: str, size: float, *, filled: bool) -> Line2D:
        return Line2D([], [], ls="", label=label, **_GREY.marks(size, filled=filled))

    def words(label: str) -> Line2D:
        return Line2D([], [], color="none", label=label)

    handles: list[Artist] = [words(" ")] if averaged else []
    handles += [Line2D([], [], color=GREY, lw=0.6, label="measured")] if thin else []
    handles += [grey("measured, averaged", _AVERAGE, filled=False)] if averaged else []
    handles += [
        grey(f"measured, 95 % CI ({role} run)", _MEASURED, filled=role == "fitted")
        for role in ("fitted", "predicted")
        if any(run.role == role for run in runs)
    ]
    handles.append(Patch(color=GREY, alpha=0.35, lw=0, label="wear law, 95 % band"))
    handles += [Line2D([], [], color=GREY, ls=":", lw=0.9, label="95 % band of averages")] if averaged else []
    handles += [
        Line2D([], [], label=label, **_cross(outcome))
        for outcome, (_, label) in _DEPARTING.items()
        if any(one.outcome == outcome for one in marks)
    ]
    if len(runs) > 1:
        handles.append(words("(bars shifted right)" if averaged else "(offset to avoid overlap)"))
    silent = len(runs) - len({one.run for one in marks})
    if silent:
        handles.append(words(f"runs without measured {panels[0].quantity.removeprefix('wear ')}: {silent}"))
    return handles


@in_columns
def plot_study_friction(runs: Sequence[Member]) -> "Figure":
    """Draw the friction coefficient of each run with the fit of Eq. 7 and its parameters (paper, Fig. 3).

    Runs without friction are left out. Raises ``ValueError`` if no run has any.
    """
    shown = [(run, run.friction) for run in runs if run.friction is not None and run.friction.outcome != "none"]
    if not shown:
        raise ValueError("found no run with friction; expected at least one")
    names = _told_apart({run.id: words for run, _ in shown for _, words in [_known(run)]})
    shown.sort(key=lambda one: _known(one[0])[0])
    titles = ["".join(names[run.id]) for run, _ in shown]
    figure, axes = grid(len(shown), 1, titles)
    for number, (ax, (run, fit)) in enumerate(zip(axes, shown, strict=True)):
        _draw_friction(ax, run, fit)
        letter(ax, number, titles[number], len(shown))
    low, high = axes[0].get_ylim()
    # Room for the parameters above all samples.
    axes[0].set_ylim(low, low + (high - low) / 0.76)
    label_outer(axes, slid(shown[0][0].corrected.run), "friction coefficient μ")
    key(figure, axes, columns=3)
    return figure


def _draw_friction(ax: "Axes", run: Member, fit: FrictionFit) -> None:
    raw = run.corrected.run
    exponential = fit.outcome == "exponential"
    fitted = {"color": PALETTE[0] if exponential else PALETTE[1], "ls": "-" if exponential else "--", "lw": 1.4}
    for curve in friction_panels(raw.sliding_distance, raw, fit)[0].curves:
        look: Any = {"color": GREY, "lw": 0.4} if curve.role == "measured" else fitted
        ax.plot(*thinned(curve.x, curve.y), label=curve.name, **look)
    words = {"A": fit.amplitude, "b": fit.steady_state, "c": fit.running_in_distance}
    text = "\n".join(f"{name} = {value}" for name, value in words.items() if value is not None)
    ax.text(0.97, 0.97, text, transform=ax.transAxes, ha="right", va="top", fontsize=7, linespacing=1.25)
    ax.margins(x=0.02)


@in_columns
def plot_study_coefficient(result: StudyResult, effective: Sequence[EffectiveCoefficient]) -> "Figure":
    """Draw each run's effective k_D against friction, with both laws of the study (paper, Fig. 5).

    Raises ``KeyError`` if the study has not tried Sarkar's law.
    """
    by_run = {one.run_id: one for one in effective}
    runs = [run for run in sorted(result.law("sarkar").runs, key=_severity) if run.id in by_run]
    names, shown = _names(runs), [by_run[run.id] for run in runs]
    power = coefficient_power(result.law("sarkar").first.wear_coefficient)
    last = max(float(np.max(one.sliding_distance)) for one in shown)
    bias = max(float(np.max(np.abs(one.bias))) for one in shown)
    titles = [f", {run.role}".join(names[run.id]) for run in runs]
    figure, axes = grid(len(shown), 4 if len(shown) > 1 else 7, titles)
    mu = friction_range(shown)
    for number, (ax, one) in enumerate(zip(axes, shown, strict=True)):
        points = _draw_effective(ax, one, power, last)
        ax.plot([], [], ls="", label=f"(smoothing bias at most {100 * bias:.1f} %)")
        ends = [end for law in result.laws for end in _draw_coefficient(ax, law, mu, power)]
        letter(ax, number, titles[number], len(shown))
    axes[0].set_xlim(mu[0], mu[-1])
    axes[0].set_ylim(*_coefficient_range(shown, ends, power))
    label_outer(axes, "friction coefficient μ", powered_axis("effective $k_\\mathrm{D}$", power, WEAR_COEFFICIENT))
    bar = figure.colorbar(points, ax=axes, aspect=30, pad=0.01)
    bar.set_label(axis("sliding distance s", "m"))
    handles, labels = axes[0].get_legend_handles_labels()
    order = sorted(range(len(labels)), key=lambda i: [word in labels[i] for word in _KEY_ORDER].index(True))
    columns = 1 if len(shown) == 1 else 2
    ordered = [handles[i] for i in order], [labels[i] for i in order]
    figure.legend(*ordered, loc="outside lower center", ncols=columns, fontsize=FORMULA)
    return figure


def _draw_coefficient(ax: "Axes", law: LawResult, mu: Column, power: int) -> list[float]:
    """Draw effective k_D of the law against the friction coefficient; return its range on the axis."""
    found = law.first
    words = f"$k_\\mathrm{{D}}$ = {coefficient_words(found.wear_coefficient, power)}"
    for curve in law_curves(mu, [LawCoefficient(law.model, found.wear_coefficient, found.interval)]):
        best, low, high = (
            scaled_coefficient(line, power) for line in (curve.y, curve.lower, curve.upper) if line is not None
        )
        if law.model == "archard":
            ax.plot(mu, best, color=PALETTE[0], ls=_DASHES[0], zorder=2.5, label=f"Archard, {words}")
            return [best[0]]
        ax.plot(mu, best, color=PALETTE[1], zorder=2.5, label=f"Sarkar, $k_\\mathrm{{D}}$·√(1 + 3μ²),\n{words}")
        ax.fill_between(mu, low, high, color=PALETTE[1], alpha=0.2, lw=0, label="Sarkar, 95 % band")
        return [low[0], high[-1]]
    return []


def _draw_effective(ax: "Axes", one: EffectiveCoefficient, power: int, last: float) -> Any:
    """Draw the windows, colored and connected in the order of sliding, so that running-in is visible."""
    from matplotlib.colors import PowerNorm

    x, y, spread = (
        one.friction,
        scaled_coefficient(one.coefficient, power),
        scaled_coefficient(one.standard_uncertainty, power),
    )
    ax.errorbar(
        x,
        y,
        yerr=spread,
        color=GREY,
        lw=0.5,
        marker="o",
        ms=3.4,
        mec=BLACK,
        mew=0.4,
        elinewidth=0.6,
        ecolor=BLACK,
        capsize=1.5,
        capthick=0.6,
        zorder=3,
        label="measured, with standard uncertainty",
    )
    norm = PowerNorm(0.5, vmin=0.0, vmax=last)
    return ax.scatter(
        x, y, c=one.sliding_distance, cmap="cividis", norm=norm, s=13, edgecolors=BLACK, linewidths=0.4, zorder=4
    )


def _coefficient_range(shown: Sequence[EffectiveCoefficient], ends: Sequence[float], power: int) -> tuple[float, float]:
    """Include all points and laws; error bars that are much longer than others may extend beyond the axes."""
    usual = float(np.median(np.concatenate([one.standard_uncertainty for one in shown])))
    reached = list(ends)
    for one in shown:
        bar = np.minimum(one.standard_uncertainty, 4 * usual)
        reached += [
            *scaled_coefficient(one.coefficient - bar, power),
            *scaled_coefficient(one.coefficient + bar, power),
        ]
    room = 0.04 * (max(reached) - min(reached))
    return min(reached) - room, max(reached) + room


def _severity(run: RunVerdict) -> tuple[float, float]:
    return (0.0 if run.slip is None else run.slip.value, run.normal_load.value)


def _known(member: Member) -> tuple[tuple[float, float], str]:
    """Return the sort key and the name of a run."""
    manifest = member.corrected.run.manifest
    load, slip = manifest.conditions.normal_load, manifest.slip
    return (0.0 if slip is None else slip.value, load.value), _conditions(load, slip)


def _conditions(load: Quantity, slip: Quantity | None) -> str:
    """Name a run by its load, and by the slip of rolling bodies."""
    words = show_force(load.value)
    return words if slip is None else f"{words}, {show(slip.value, None, '1', '%')} slip"


def _names(runs: Sequence[RunVerdict]) -> dict[str, tuple[str, str]]:
    """Name runs by their conditions, and on a line below by their ids if several have the same."""
    return _told_apart({run.id: _conditions(run.normal_load, run.slip) for run in runs})


def _told_apart(shown: Mapping[str, str]) -> dict[str, tuple[str, str]]:
    count = Counter(shown.values())
    return {
        run_id: (words, "" if count[words] == 1 else "".join(f"\n{line}" for line in wrap(run_id, _LETTERS)))
        for run_id, words in shown.items()
    }


def _law_words(law: LawResult, between: str) -> str:
    """Format the law with the runs it was fitted to, and k_D of each body."""
    fitted = [run for run in law.runs if run.role == "fitted"]
    alone = f"at {_conditions(fitted[0].normal_load, fitted[0].slip)}" if len(fitted) == 1 else f"to {len(fitted)} runs"
    head = [law_heading(law.model), *filter(None, [law.distance_per_rotation]), f"fitted {alone}"]
    each = between.join(
        coefficient_words(body.wear_coefficient) + (f" ({spoken(name)})" if len(law.bodies) > 1 else "")
        for name, body in law.bodies.items()
    )
    return f"{', '.join(head)}\n$k_\\mathrm{{D}}$ = {each}"

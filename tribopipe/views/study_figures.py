"""Figures of a study in the size of a journal's columns: wear of all runs under one law, friction, and effective k_D.

They hold what Figures 1, 3, 4, 5 and 6 of the paper do, with the uncertainties besides. Runs stand in the order of
their loads; they differ in colour (Okabe–Ito), in line style and in marker, so that the figures survive greyscale.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.units import WEAR_COEFFICIENT, axis, from_si, interval_from_si, show, show_force
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName
from tribopipe.documents.slip import stated_slip
from tribopipe.evaluation.friction_paths import fitted_path
from tribopipe.evaluation.study.effective import EffectiveCoefficient
from tribopipe.evaluation.study.member import Member
from tribopipe.physics.laws import law_heading
from tribopipe.results.agreement import LawResult, RunVerdict, StudyResult
from tribopipe.results.evaluation import COVERAGE_FACTOR, FrictionFit
from tribopipe.results.run import RawRun
from tribopipe.results.study_curves import StudyCurve
from tribopipe.views.coefficient_plot import LawCoefficient, friction_range, law_curves
from tribopipe.views.decimation import thinned
from tribopipe.views.layout import TWO_COLUMNS, grid, in_columns, label_outer, letter
from tribopipe.views.number_format import coefficient_power, coefficient_words, powered_axis, scaled_coefficient, slid
from tribopipe.views.run_figures import BLACK, GREY, PALETTE

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MARKERS = ("o", "s", "^", "D", "v", "P")
_DASHES = ((0, (5, 1.6)), (0, (5, 1.4, 1.2, 1.4)), (0, (2.2, 1.2)), (0, (7, 1.2, 1.2, 1.2, 1.2, 1.2)))
_KEY_ORDER = ("measured", "smoothing", "Archard", "Sarkar")
"""Of the legend of effective k_D."""
_EVERY = 2
"""One of so many averages is drawn."""


class _Look(NamedTuple):
    """How one run is drawn wherever it stands."""

    colour: str
    dashes: Any
    marker: str


@in_columns
def plot_study_wear(
    result: StudyResult,
    law: LawName,
    curves: Sequence[StudyCurve],
    measured: Mapping[str, tuple[Column, Column]] | None = None,
) -> "Figure":
    """Draw pin wear of all runs beside one law, with 95 % bands and end values (paper, Figs. 1, 4 and 6).

    ``measured`` holds sliding distance and pin wear depth, m, by run, for the thin lines. The open markers are what the
    study compares: the same averaged over stretches of the distance.
    """
    from tribopipe.views.canvas import ShownFigure

    found, by_run = result.law(law), {curve.run_id: curve for curve in curves if curve.model == law}
    runs = [run for run in _by_load(found.runs) if run.id in by_run]
    names = _names({run.id: run.normal_load for run in runs})
    key = sum(0.34 if below else 0.2 for _, below in names.values())
    figure = ShownFigure(figsize=(TWO_COLUMNS, max(3.7, 1.5 + key)), dpi=300, layout="constrained")
    ax = figure.subplots()
    handles: list[Artist] = []
    for number, run in enumerate(runs):
        look = _look(number, run, runs)
        if measured is not None and run.id in measured:
            distance, depth = thinned(*measured[run.id])
            ax.plot(distance, _micro(depth), color=look.colour, lw=0.4, alpha=0.35, zorder=1.5)
        _draw_law(ax, by_run[run.id], look)
        handles.append(_run_handle(look, _role(run).join(names[run.id])))
    _draw_ends(ax, runs)
    if ax.dataLim.y0 > -0.02 * ax.dataLim.y1:
        ax.set_ylim(bottom=0.0)
    ax.set_xlabel(axis("sliding distance s", "m"))
    ax.set_ylabel(axis("pin wear depth", "um"))
    ax.set_title(_law_words(found, names), loc="left")
    handles = [*handles[::-1], *_wear_key(ax, thin=bool(measured), apart=len(runs) > 1)]
    figure.legend(handles=handles, loc="outside right upper", labelspacing=0.7, handlelength=4.0)
    return figure


def _draw_law(ax: "Axes", curve: StudyCurve, look: _Look) -> None:
    """Draw a law from zero on and its band; the averages compared with it, and the edges between which they belong."""
    from matplotlib.patheffects import withStroke

    distance = np.concatenate([[0.0], curve.places])
    depth, lower, upper = (
        np.concatenate([[0.0], _micro(values)]) for values in (curve.predicted, curve.lower, curve.upper)
    )
    ax.fill_between(distance, lower, upper, color=look.colour, alpha=0.2, lw=0, zorder=1.8)
    halo = withStroke(linewidth=1.8, foreground="white")
    ax.plot(distance, depth, color=look.colour, ls=look.dashes, zorder=3, path_effects=[halo])
    # The last place is that of the end value, which is no reading of the sensor.
    if (measured := curve.measured) is None:
        return
    for edge in (measured.lower, measured.upper):
        ax.plot(distance[1:-1], _micro(edge[:-1]), color=look.colour, ls=":", lw=0.6, alpha=0.9, zorder=2)
    every = slice(1, -1, _EVERY)
    averages = _marks(look.colour, look.marker, open_=True)
    ax.plot(curve.places[every], _micro(measured.best[every]), ls="", zorder=4, **averages)


def _marks(colour: str, marker: str, *, open_: bool) -> dict[str, Any]:
    """Give averages small open markers, and end values larger ones that are filled."""
    if open_:
        return {"color": colour, "marker": marker, "ms": 2.3, "mfc": "white", "mec": colour, "mew": 0.5}
    return {"color": colour, "marker": marker, "ms": 3.2, "mec": BLACK, "mew": 0.4}


def _draw_ends(ax: "Axes", runs: Sequence[RunVerdict]) -> None:
    """Draw the end values; several of them side by side behind the curves, where error bars do not hide each other."""
    last = max(run.end.value for run in runs)
    for number, run in enumerate(runs):
        look, (body,) = _look(number, run, runs), run.bodies.values()
        spread = COVERAGE_FACTOR * interval_from_si(body.measured.standard_uncertainty or 0.0, "m", "um")
        shift = 0.0 if len(runs) == 1 else 0.018 * last * (number + 0.8)
        ax.errorbar(
            run.end.value + shift,
            from_si(body.measured.value, "m", "um"),
            yerr=spread,
            ls="",
            elinewidth=0.9,
            capsize=2,
            zorder=5,
            **_marks(look.colour, look.marker, open_=False),
        )
    ax.set_xlim(-0.01 * last, last * (1.018 + 0.018 * len(runs)))


def _run_handle(look: _Look, name: str) -> "Artist":
    from matplotlib.lines import Line2D

    return Line2D([], [], ls=look.dashes, label=name, **_marks(look.colour, look.marker, open_=False))


def _wear_key(ax: "Axes", *, thin: bool, apart: bool) -> "list[Any]":
    """Say what is drawn of every run."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    end = "end value, 95 % (shifted right)" if apart else "end value, 95 %"
    return [
        Line2D([], [], color="none", label=" "),
        *([Line2D([], [], color=GREY, lw=0.6, label="measured")] if thin else []),
        Line2D([], [], ls="", label="measured, averaged", **_marks(GREY, "o", open_=True)),
        ax.errorbar([], [], yerr=[], ls="", elinewidth=0.9, capsize=2, label=end, **_marks(GREY, "o", open_=False)),
        Patch(color=GREY, alpha=0.35, lw=0, label="law, 95 % band"),
        Line2D([], [], color=GREY, ls=":", lw=0.9, label="averages, 95 % band"),
    ]


@in_columns
def plot_study_friction(runs: Sequence[Member]) -> "Figure":
    """Draw the friction coefficient of each run with Eq. 7 as fitted and its parameters (paper, Fig. 3).

    Runs without friction are left out. Raises ``ValueError`` where no run has any.
    """
    shown = [(run, run.friction) for run in runs if run.friction is not None and run.friction.outcome != "none"]
    if not shown:
        raise ValueError("found no run with friction; expected at least one")
    shown.sort(key=lambda one: _place(one[0].corrected.run))
    names = _told_apart({run.id: _conditions(run.corrected.run) for run, _ in shown})
    figure, axes = grid(len(shown), 1)
    for number, (ax, (run, fit)) in enumerate(zip(axes, shown, strict=True)):
        _draw_friction(ax, run, fit)
        letter(ax, number, "".join(names[run.id]), len(shown))
    low, high = axes[0].get_ylim()
    # Room for the parameters above all samples.
    axes[0].set_ylim(low, low + (high - low) / 0.76)
    label_outer(axes, slid(shown[0][0].corrected.run), "friction coefficient μ")
    handles = {label: line for ax in axes for line, label in zip(*ax.get_legend_handles_labels(), strict=True)}
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=3)
    return figure


def _draw_friction(ax: "Axes", run: Member, fit: FrictionFit) -> None:
    raw, path = run.corrected.run, fitted_path(fit)
    distance = raw.sliding_distance
    mu = raw.columns.get("friction_coefficient", np.full_like(distance, np.nan))
    ax.plot(*thinned(distance, mu), color=GREY, lw=0.4, label="measured")
    if path is not None and fit.window is not None:
        inside = np.linspace(fit.window[0].value, fit.window[1].value, 400)
        exponential = fit.outcome == "exponential"
        ax.plot(
            inside,
            path.coefficient(inside),
            color=PALETTE[0] if exponential else PALETTE[1],
            ls="-" if exponential else "--",
            lw=1.4,
            label="fit, μ = A·exp(−s/c) + b" if exponential else "steady value b",
        )
    words = {"A": fit.amplitude, "b": fit.steady_state, "c": fit.running_in_distance}
    text = "\n".join(f"{name} = {value}" for name, value in words.items() if value is not None)
    ax.text(0.97, 0.97, text, transform=ax.transAxes, ha="right", va="top", fontsize=7, linespacing=1.25)
    ax.margins(x=0.02)


@in_columns
def plot_study_coefficient(result: StudyResult, effective: Sequence[EffectiveCoefficient]) -> "Figure":
    """Draw each run's effective k_D against friction, with Sarkar's law and Archard's by the study (paper, Fig. 5).

    Raises ``KeyError`` where the study has not tried Sarkar's law.
    """
    by_run = {one.run_id: one for one in effective}
    runs = [run for run in _by_load(result.law("sarkar").runs) if run.id in by_run]
    names, shown = _names({run.id: run.normal_load for run in runs}), [by_run[run.id] for run in runs]
    power = coefficient_power(result.law("sarkar").first.wear_coefficient)
    last = max(float(np.max(one.sliding_distance)) for one in shown)
    bias = max(float(np.max(np.abs(one.bias))) for one in shown)
    figure, axes = grid(len(shown), 3 if len(shown) > 1 else 5)
    mu = friction_range(shown)
    for number, (ax, one, run) in enumerate(zip(axes, shown, runs, strict=True)):
        points = _draw_effective(ax, one, power, last)
        ax.plot([], [], ls="", label=f"(smoothing bias at most {100 * bias:.1f} %)")
        ends = [end for law in result.laws for end in _draw_coefficient(ax, law, mu, power)]
        letter(ax, number, f", {run.role}".join(names[run.id]), len(shown))
    axes[0].set_xlim(mu[0], mu[-1])
    axes[0].set_ylim(*_coefficient_range(shown, ends, power))
    label_outer(axes, "friction coefficient μ", powered_axis("effective $k_\\mathrm{D}$", power, WEAR_COEFFICIENT))
    bar = figure.colorbar(points, ax=axes, aspect=30, pad=0.01)
    bar.set_label(axis("sliding distance s", "m"))
    handles, labels = axes[0].get_legend_handles_labels()
    order = sorted(range(len(labels)), key=lambda i: [word in labels[i] for word in _KEY_ORDER].index(True))
    columns = 1 if len(shown) == 1 else 2
    figure.legend([handles[i] for i in order], [labels[i] for i in order], loc="outside lower center", ncols=columns)
    return figure


def _draw_coefficient(ax: "Axes", law: LawResult, mu: Column, power: int) -> list[float]:
    """Draw what the law says effective k_D is at a friction coefficient; return how far it reaches on the axis."""
    found = law.first
    words = f"$k_\\mathrm{{D}}$ = {coefficient_words(found.wear_coefficient, power)}"
    for curve in law_curves(mu, [LawCoefficient(law.model, found.wear_coefficient, found.interval)]):
        best, low, high = (
            scaled_coefficient(line, power) for line in (curve.y, curve.lower, curve.upper) if line is not None
        )
        if law.model == "archard":
            ax.plot(mu, best, color=PALETTE[0], ls=_DASHES[0], zorder=2.5, label=f"Archard, {words}")
            return [best[0]]
        ax.plot(mu, best, color=PALETTE[1], zorder=2.5, label=f"Sarkar, $k_\\mathrm{{D}}$·√(1 + 3μ²), {words}")
        ax.fill_between(mu, low, high, color=PALETTE[1], alpha=0.2, lw=0, label="Sarkar, 95 % band")
        return [low[0], high[-1]]
    return []


def _draw_effective(ax: "Axes", one: EffectiveCoefficient, power: int, last: float) -> Any:
    """Draw the windows, coloured and joined in the order of sliding, so that running-in can be followed."""
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
    """Hold all points and laws; error bars far longer than others may leave the axes."""
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


def _by_load(runs: Sequence[RunVerdict]) -> list[RunVerdict]:
    return sorted(runs, key=lambda run: run.normal_load.value)


def _names(loads: Mapping[str, Quantity]) -> dict[str, tuple[str, str]]:
    """Name runs by their loads, and on a line below by their ids where several have the same."""
    return _told_apart(
        {run_id: show_force(load.value, load.standard_uncertainty) for run_id, load in _without_spread(loads).items()}
    )


def _told_apart(shown: Mapping[str, str]) -> dict[str, tuple[str, str]]:
    count = Counter(shown.values())
    return {run_id: (words, "" if count[words] == 1 else f"\n{run_id}") for run_id, words in shown.items()}


def _place(run: RawRun) -> tuple[float, ...]:
    """Return what runs are ordered by: load, and for two discs slip and rotations."""
    load, found = run.manifest.conditions.normal_load.value, stated_slip(run.manifest)
    return (load,) if found is None else (load, found.value, float(np.nanmax(run.progress)))


def _conditions(run: RawRun) -> str:
    """Name a run by its load, and for two discs by slip too."""
    load, found = show_force(run.manifest.conditions.normal_load.value), stated_slip(run.manifest)
    return load if found is None else f"{load}, {show(found.value, None, '1', '%')} slip"


def _without_spread(loads: Mapping[str, Quantity]) -> dict[str, Quantity]:
    return {run_id: Quantity(value=load.value, unit=load.unit) for run_id, load in loads.items()}


def _look(number: int, run: RunVerdict, runs: Sequence[RunVerdict]) -> _Look:
    predicted = sum(other.role == "predicted" for other in runs[:number])
    dashes = "-" if run.role == "fitted" else _DASHES[predicted % len(_DASHES)]
    return _Look(PALETTE[number % len(PALETTE)], dashes, _MARKERS[number % len(_MARKERS)])


def _role(run: RunVerdict) -> str:
    return ", fitted" if run.role == "fitted" else f", predicted: {run.outcome}"


def _law_words(law: LawResult, names: Mapping[str, tuple[str, str]]) -> str:
    fitted = [run.id for run in law.runs if run.role == "fitted"]
    source = f"at {names[fitted[0]][0]}" if len(fitted) == 1 and fitted[0] in names else f"to {len(fitted)} runs"
    coefficient = coefficient_words(law.first.wear_coefficient)
    return f"{law_heading(law.model)}, $k_\\mathrm{{D}}$ = {coefficient}, fitted {source}"


def _micro(depth: Column) -> Column:
    return from_si(depth, "m", "um")

"""Figures of one run: the depth signal and its correction, friction, and the wear curve beside the laws.

Colours are from the Okabe–Ito palette, which people with any colour vision can tell apart. The figures are made without
pyplot, so that they need no display and leave no state behind; in a notebook they show themselves.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from functools import wraps
from io import BytesIO
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Any, NamedTuple, ParamSpec

import numpy as np

from tribopipe.archive.file_signature import FIGURES
from tribopipe.archive.store import Archive
from tribopipe.base.arrays import Column
from tribopipe.base.errors import ArchiveError
from tribopipe.base.files import clear_leftovers_of, replacing
from tribopipe.base.units import WEAR_COEFFICIENT, from_si
from tribopipe.documents.preprocessing import CleanUp
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName
from tribopipe.physics.laws import LAWS, law_label
from tribopipe.pipeline.output_paths import MADE_BY, made_here, require_free
from tribopipe.results.evaluation import DriftCorrection, FrictionFit
from tribopipe.results.finding import first_of_each_code
from tribopipe.results.run import CorrectedRun, RawRun
from tribopipe.results.wear_curves import WearCurves
from tribopipe.results.wear_fit import WearFit
from tribopipe.results.wear_prediction import WearPrediction
from tribopipe.views.decimation import thinned
from tribopipe.views.number_format import course, powered_axis, slid, slide
from tribopipe.views.plot import Curve, Panel
from tribopipe.views.run_plots import depth_panels, friction_panels, signal_panels, wear_panels

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BLACK, ORANGE, _BLUE, GREEN, RED, GREY = "#000000", "#E69F00", "#0072B2", "#009E73", "#D55E00", "#8C8C8C"
PALETTE = (_BLUE, RED, GREEN, "#CC79A7", ORANGE, "#56B4E9", BLACK)
"""Colours of several runs in one figure."""
_OTHER_LAWS = ("#CC79A7", "#56B4E9", BLACK)


class LawLook(NamedTuple):
    """How the lines of a law are drawn."""

    colour: str
    fitted: Any = (0, (7, 1.2, 1.2, 1.2, 1.2, 1.2))
    """Dashes of what was fitted."""
    predicted: Any = (0, (2.2, 1.2, 1.2, 1.2))
    """Dashes of what was predicted."""


_LOOKS: dict[LawName, LawLook] = {"archard": LawLook(_BLUE, "-", "-."), "sarkar": LawLook(ORANGE, "--", ":")}


def law_look(law: LawName) -> LawLook:
    """Return how a law is drawn: those of other packages in colours that are left, in their order."""
    others = [name for name in LAWS if name not in _LOOKS]
    place = others.index(law) if law in others else len(others)
    return _LOOKS.get(law) or LawLook(_OTHER_LAWS[place % len(_OTHER_LAWS)])


_ON_BASIS = ("reading_contradicts_measurement", "no_post_test_measurement")
"""Codes of findings by which a fitted curve is not what the reading or a measurement would have one expect."""
MOST_LETTERS = 84
"""That fit above a figure in one line."""
STYLE: Any = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.8,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "lines.linewidth": 1.4,
    "svg.hashsalt": "tribopipe",
    "svg.fonttype": "none",
    "pdf.fonttype": 42,  # journals take no Type 3 fonts
    "figure.constrained_layout.use": True,
}


P = ParamSpec("P")


@contextmanager
def own_style(style: Any = STYLE) -> Iterator[None]:
    """Draw with matplotlib's defaults and a style, whatever a matplotlibrc says: of TeX, sizes or colors."""
    from matplotlib import rc_context, rcParams, rcParamsDefault

    with rc_context():
        rcParams.update({name: value for name, value in rcParamsDefault.items() if name != "backend"} | style)
        yield


def styled(plot: "Callable[P, Figure]", style: Any = STYLE) -> "Callable[P, Figure]":
    """Draw in the style of this module."""

    @wraps(plot)
    def drawn(*args: P.args, **kwargs: P.kwargs) -> "Figure":
        with own_style(style):
            return plot(*args, **kwargs)

    return drawn


class _Look(NamedTuple):
    """How a curve is drawn."""

    color: str
    ls: Any = "-"
    lw: float = 1.4
    alpha: float = 1.0


_SERIES = (
    _Look(BLACK),
    _Look(_BLUE, (0, (5, 1.6))),
    _Look(RED, (0, (1.2, 1.2))),
    _Look(GREY, (0, (5, 1.4, 1.2, 1.4))),
)
"""Both bodies together, and each; or models beside each other."""
_MEASURED = (_Look(GREY, lw=0.8), _Look(_BLUE, lw=0.9))
"""As recorded, and what was made of it."""
_MOST_PLACES = 240


def _look(curve: Curve, before: Sequence[Curve]) -> _Look:
    """Give a curve its look after those before it in its panel."""
    law = law_look(curve.law) if curve.law else LawLook(_BLUE, "-", "-.")
    if curve.series is not None:
        return _SERIES[curve.series]
    if curve.role == "measured":
        return _MEASURED[sum(one.role == "measured" for one in before) % 2]
    return {
        "fit": _Look(law.colour, law.fitted),
        "prediction": _Look(GREEN, law.predicted),
        "drift": _Look(ORANGE, "--"),
        "wander": _Look(GREEN, lw=0.8, alpha=0.7),
        "residual": _Look(law.colour if curve.law else GREY, lw=0.6),
    }[curve.role]


def draw_panel(ax: "Axes", panel: Panel, power: int = 0) -> None:
    """Draw curves with their bands and what was measured, in the shown unit less a power of ten."""
    for number, curve in enumerate(panel.curves):
        look = _look(curve, panel.curves[:number])
        y, *band = (
            from_si(line, curve.unit.si, curve.unit.shown) / 10.0**power
            for line in (curve.y, curve.lower, curve.upper)
            if line is not None
        )
        x, y, *band = _smooth(curve.x, y, *band) if band else thinned(curve.x, y)
        ax.plot(x, y, **look._asdict(), label="" if curve.role == "residual" else curve.name)
        if band:
            ax.fill_between(x, band[0], band[1], color=look.color, alpha=0.15, lw=0)
    if any(curve.role == "residual" for curve in panel.curves):
        ax.axhline(0, color=BLACK, lw=0.8)
    if panel.left_out is not None:
        ax.axvspan(*panel.left_out, color=ORANGE, alpha=0.25, lw=0, label="left out")
    for one in panel.marks:
        value, half = one.y / 10.0**power, one.half_width / 10.0**power
        ax.errorbar(one.x, value, yerr=half, fmt="o", ms=4, capsize=3, color=RED, label=one.name, zorder=5)
    ax.set_ylabel(powered_axis(_mathtext(panel.quantity), power, panel.unit.shown))
    ax.margins(x=0.01)


def _mathtext(words: str) -> str:
    """Set a_x and k_D as formulas are set."""
    return re.sub(r"\b(a_[xz])\b", r"$\1$", words).replace("k_D", r"$k_\mathrm{D}$")


def _smooth(x: Column, *lines: Column) -> list[Column]:
    """Take as many samples as a smooth curve needs, closer where wear is steepest."""
    placed = np.isfinite(x)
    last = max(int(np.count_nonzero(placed)) - 1, 0)
    steep, even = np.geomspace(1, max(last, 1), _MOST_PLACES // 2), np.linspace(0, last, _MOST_PLACES // 2)
    kept = np.unique(np.concatenate([[0], steep, even]).astype(int).clip(0, last))
    return [column[placed][kept] for column in (x, *lines)]


def key(figure: "Figure", axes: "Iterable[Axes]", columns: int = 2) -> None:
    """Put one legend of all panels below them."""
    handles = {label: line for ax in axes for line, label in zip(*ax.get_legend_handles_labels(), strict=True)}
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=columns)


@styled
def plot_signals(run: RawRun) -> "Figure":
    """Draw each recorded signal of a run in a panel, as it is held."""
    x, label = course(run)
    return _stacked(signal_panels(x, run), f"{run.id}: signals", run.samples, label)


@styled
def plot_depth(corrected: CorrectedRun, clean_up: CleanUp | None = None) -> "Figure":
    """Draw the depth reading, what drift adds to it, and the corrected wear with the post-test measurement."""
    x, label = course(corrected.run)
    words = _drift_words(corrected.correction)
    return _stacked(depth_panels(x, corrected, clean_up), f"{corrected.id}: depth signal", words, label)


def _drift_words(correction: DriftCorrection) -> str:
    if correction.end_wear_depth is None:
        return in_lines(str(correction))
    return f"drift {_shown(correction.drift_rate, 'nm/min')}, discrepancy {_shown(correction.discrepancy, 'um')}"


@styled
def plot_friction(run: RawRun, fit: FrictionFit, clean_up: CleanUp | None = None) -> "Figure":
    """Draw the friction coefficient with Eq. 7 as fitted and the residuals, or the steady value alone against time."""
    x, label = slide(run)
    panels = friction_panels(x, run, fit, clean_up)
    return _stacked(panels, f"{run.id}: friction", in_lines(_friction_words(fit)), label)


def _friction_words(fit: FrictionFit) -> str:
    if fit.steady_state is not None and fit.window is None:
        return f"b = {fit.steady_state}, the mean of the later half; the sliding distance is not known"
    if fit.outcome != "exponential":
        return f"b = {fit.steady_state}: {fit.notes[-2]}" if fit.steady_state else "; ".join(fit.notes)
    return f"A = {fit.amplitude}, b = {fit.steady_state}, c = {fit.running_in_distance}"


@styled
def plot_wear(corrected: CorrectedRun, fits: Sequence[WearCurves], predictions: Sequence[WearCurves] = ()) -> "Figure":
    """Draw the pin's wear with the fitted laws, their residuals, and predictions from another run, with 95 % bands."""
    run = corrected.run
    coefficients = (_wear_words(curve.result) for curve in fits)
    told = basis_words(curve.result for curve in fits if isinstance(curve.result, WearFit))
    words = "\n".join([*coefficients, *map(in_lines, told)])
    panels = wear_panels(run.sliding_distance, corrected, fits, predictions)
    figure = _stacked(panels, f"{run.id}: wear", words, slid(run))
    figure.axes[0].set_ylim(bottom=min(0.0, figure.axes[0].get_ylim()[0]))
    return figure


def _wear_words(fit: WearFit | WearPrediction) -> str:
    known = None if fit.first is None else fit.first.wear_coefficient
    return f"{law_label(fit.model)}: $k_\\mathrm{{D}}$ = {_shown(known, WEAR_COEFFICIENT)}"


def basis_words(fits: Iterable[WearFit]) -> list[str]:
    """Say of k_D that reading and measurement do not give together what gives it, in the words of its findings."""
    findings = first_of_each_code(finding for fit in fits for finding in fit.findings)
    return [f"{finding.where}: {finding.message}" for finding in findings if finding.code in _ON_BASIS]


def _shown(quantity: Quantity | None, unit: str) -> str:
    return "unknown" if quantity is None else quantity.shown(unit)


def _stacked(panels: Sequence[Panel], title: str, words: str, label: str) -> "Figure":
    """Draw panels below each other, the first of them large."""
    from tribopipe.views.canvas import ShownFigure

    few = len(panels) <= 2
    size = 3.9 if len(panels) == 1 else 5.0 if few else 1.6 * len(panels)
    figure = ShownFigure(figsize=(6.3, size), dpi=150, layout="constrained")
    heights = [3, 1][: len(panels)] if few else [1] * len(panels)
    axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
    for ax, panel in zip(axes, panels, strict=True):
        draw_panel(ax, panel)
    finish(axes[0], title, words)
    axes[-1].set_xlabel(label)
    key(figure, axes)
    return figure


def finish(ax: "Axes", title: str, words: str) -> None:
    """Put a title over a figure's first panel, and words between them."""
    size = 8.6 if "$" in words else 8.0  # a subscript has seven tenths of it, and at least 6 pt
    ax.set_title(title, loc="left", fontsize=10, fontweight="bold", pad=6 + 11 * (words.count("\n") + 1))
    ax.text(0.0, 1.02, words, transform=ax.transAxes, fontsize=size, va="bottom")
    ax.margins(x=0.01)


def in_lines(sentence: str) -> str:
    """Break a sentence into lines that fit above a figure."""
    return "\n".join(wrap(sentence, MOST_LETTERS))


def save_figure(figure: "Figure", path: Path) -> None:
    """Write a figure in the format of the file's suffix, whole or not at all, and the same each time.

    Raises ``ArchiveError`` where the folder cannot be written.
    """
    save_figures(path.parent, {path.name: figure})


def save_figures(folder: Path, figures: "Mapping[str, Figure]") -> None:
    """Write figures under these names as ``save_figure`` does.

    None takes its place before all are written, and the first takes it last. Raises ``OutputError`` where something
    else than a figure of ours is there.
    """
    try:
        require_free((folder / name for name in figures), own=made_here, beside_run=True)
        folder.mkdir(parents=True, exist_ok=True)
        with ExitStack() as written:
            for name, figure in figures.items():
                path = folder / name
                written.enter_context(replacing(path)).write_bytes(_picture(figure, path.suffix))
    except OSError as error:
        raise ArchiveError(
            f"{folder}: figures cannot be written ({error.strerror or error}); expected a folder with room and write "
            "permission; see to that, and give the same command again"
        ) from None


def save_beside(archive: Archive, identifier: str, figures: "Mapping[str, Figure]") -> None:
    """Write figures of a run or study beside its archive, as ``save_figures`` does, alone among those who draw it.

    What somebody left of them who was killed goes. Raises ``ArchiveError`` and ``OutputError``.
    """
    folder = archive.folder / FIGURES
    with archive.alone_with(identifier):
        for name in figures:
            clear_leftovers_of(folder / name)
        save_figures(folder, figures)


def _picture(figure: "Figure", suffix: str) -> bytes:
    picture = BytesIO()
    told = {
        ".svg": {"Creator": MADE_BY, "Date": None},
        ".pdf": {"Creator": MADE_BY, "CreationDate": None},
        ".png": {"Software": MADE_BY},
    }.get(suffix, {})
    with own_style():
        figure.savefig(picture, format=suffix.removeprefix("."), metadata=told)
    return picture.getvalue()

"""Figures of one run: the depth signal and its correction, friction, and the wear curve with the laws.

Colors are from the Okabe–Ito palette, which people with any color vision can distinguish. The figures are made
without pyplot, so that they need no display and leave no state behind; in a notebook they show themselves.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from functools import wraps
from io import BytesIO
from pathlib import Path
from textwrap import fill, wrap
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, ParamSpec

import numpy as np

from tribopipe.archive.file_signature import FIGURES
from tribopipe.archive.store import Archive
from tribopipe.base.arrays import Column
from tribopipe.base.errors import ArchiveError
from tribopipe.base.files import clear_leftovers_of, replacing
from tribopipe.base.units import WEAR_COEFFICIENT, from_si, pretty
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.preprocessing import CleanUp
from tribopipe.documents.quantity import in_unit
from tribopipe.documents.recipe import LawName
from tribopipe.physics.laws import LAWS, law_label
from tribopipe.pipeline.output_paths import MADE_BY, made_here, require_free
from tribopipe.results.evaluation import FrictionFit
from tribopipe.results.finding import first_of_each_code
from tribopipe.results.run import CorrectedRun, RawRun
from tribopipe.results.wear_fit import WearFit
from tribopipe.results.wear_prediction import WearCurves
from tribopipe.views.decimation import thinned
from tribopipe.views.plot import VOLUME, Curve, Mark, Panel, course, power_of, powered_axis, slide
from tribopipe.views.run_plots import contact_panels, depth_panels, friction_panels, signal_panels, wear_panels

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BLACK, ORANGE, _BLUE, GREEN, RED, GREY = "#000000", "#E69F00", "#0072B2", "#009E73", "#D55E00", "#8C8C8C"
PALETTE = (_BLUE, RED, GREEN, "#CC79A7", ORANGE, "#56B4E9", BLACK)
"""Colors of several runs in one figure."""
_OTHER_LAWS = ("#CC79A7", "#56B4E9", BLACK)


class LawLook(NamedTuple):
    """Line styles of a law."""

    colour: str
    fitted: Any = (0, (7, 1.2, 1.2, 1.2, 1.2, 1.2))
    """Dashes of fitted curves."""
    predicted: Any = (0, (2.2, 1.2, 1.2, 1.2))
    """Dashes of predicted curves."""


_LOOKS: dict[LawName, LawLook] = {"archard": LawLook(_BLUE, "-", "-."), "sarkar": LawLook(ORANGE, "--", ":")}


def law_look(law: LawName) -> LawLook:
    """Return the line styles of a law; other laws have the remaining colors, in their order."""
    others = [name for name in LAWS if name not in _LOOKS]
    place = others.index(law) if law in others else len(others)
    return _LOOKS.get(law) or LawLook(_OTHER_LAWS[place % len(_OTHER_LAWS)])


_ON_BASIS = ("reading_contradicts_measurement", "no_post_test_measurement")
"""Codes of findings that explain why a fitted curve does not follow the depth signal or a measurement."""
_PRINT_DPI = 600.0
"""Resolution of PNG files for print, as journals require for line art."""
_PNG_LEVEL = 3
"""Compression of PNG files: half the time of the usual 6, for files 4 % larger."""
MOST_LETTERS = 84
"""Number of letters that fit above a figure on one line."""
FORMULA = 8.6
"""Size of texts with subscripts, pt: these have seven tenths of it, and at least 6 pt."""
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
    """Draw with matplotlib's defaults and a style, regardless of TeX, sizes or colors in a matplotlibrc."""
    from matplotlib import rc_context, rcParams, rcParamsDefault

    with rc_context():
        rcParams.update({name: value for name, value in rcParamsDefault.items() if name != "backend"} | style)
        yield


def styled(plot: "Callable[P, Figure]", style: Any = STYLE) -> "Callable[P, Figure]":
    """Apply the style of this module to a drawing function."""

    @wraps(plot)
    def drawn(*args: P.args, **kwargs: P.kwargs) -> "Figure":
        with own_style(style):
            return plot(*args, **kwargs)

    return drawn


class _Look(NamedTuple):
    """Line style of a curve."""

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
"""Line styles of both bodies together and of each, or of several models."""
_MEASURED = (_Look(GREY, lw=0.8), _Look(_BLUE, lw=0.9))
"""Line styles of recorded and of preprocessed signals."""
_MOST_PLACES = 240


def _look(curve: Curve, before: Sequence[Curve]) -> _Look:
    """Return the line style of a curve, given those before it in its panel."""
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
    """Draw curves with bands and measured values, in the display unit without a power of ten."""
    for number, curve in enumerate(panel.curves):
        look = _look(curve, panel.curves[:number])
        y, *band = (
            from_si(line, curve.unit.si, curve.unit.shown) / 10.0**power
            for line in (curve.y, curve.lower, curve.upper)
            if line is not None
        )
        x, y, *band = _smooth(curve.x, y, *band) if band else thinned(curve.x, y)
        name, above = "" if curve.role == "residual" else curve.name, 2.5 if curve.role == "drift" else 2.0
        ax.plot(x, y, **look._asdict(), label=name, zorder=above)
        if band:
            ax.fill_between(x, band[0], band[1], color=look.color, alpha=0.15, lw=0)
    _draw_lines(ax, panel)
    _draw_marks(ax, panel.marks, power)
    ax.set_ylabel(powered_axis(_mathtext(panel.quantity), power, panel.unit.shown))
    ax.margins(x=0.01)


def _draw_lines(ax: "Axes", panel: Panel) -> None:
    """Draw zero and limits of residuals, and the ranges that were not fitted."""
    limits = () if panel.limit is None else (-panel.limit, panel.limit)
    if limits or any(curve.role == "residual" for curve in panel.curves):
        ax.axhline(0, color=BLACK, lw=0.8)
    for limit in limits:
        ax.axhline(limit, color=GREY, ls=(0, (5, 1.6)), lw=0.8)
    if panel.left_out is not None:
        ax.axvspan(*panel.left_out, color=ORANGE, alpha=0.25, lw=0, label="excluded")


def _draw_marks(ax: "Axes", marks: Sequence[Mark], power: int) -> None:
    """Draw measured values with error bars, and their residuals as open markers in the color of their law."""
    kinds = list(dict.fromkeys(one.name for one in marks))
    for one in marks:
        value, half = one.y / 10.0**power, one.half_width / 10.0**power
        if one.law is None:
            ax.errorbar(one.x, value, yerr=half, fmt="o", ms=4, capsize=3, color=RED, label=one.name, zorder=5)
            continue
        look: Any = {"ls": "", "ms": 4, "marker": "os^"[kinds.index(one.name)], "mfc": "none"}
        ax.plot(one.x, value, mec=law_look(one.law).colour, **look)
        ax.plot([], [], mec=GREY, label=one.name, **look)


def _mathtext(words: str) -> str:
    """Typeset a_x and k_D as in formulas."""
    return re.sub(r"\b(a_[xz])\b", r"$\1$", words).replace("k_D", r"$k_\mathrm{D}$")


def _smooth(x: Column, *lines: Column) -> list[Column]:
    """Choose the samples needed for a smooth curve, closer together where wear is steepest."""
    placed = np.isfinite(x)
    last = max(int(np.count_nonzero(placed)) - 1, 0)
    steep, even = np.geomspace(1, max(last, 1), _MOST_PLACES // 2), np.linspace(0, last, _MOST_PLACES // 2)
    kept = np.unique(np.concatenate([[0], steep, even]).astype(int).clip(0, last))
    return [column[placed][kept] for column in (x, *lines)]


def key(figure: "Figure", axes: "Iterable[Axes]", columns: int = 2) -> None:
    """Draw one legend for all panels below them."""
    handles = {label: line for ax in axes for line, label in zip(*ax.get_legend_handles_labels(), strict=True)}
    legend = figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=columns)
    if legend.get_window_extent().width > figure.bbox.width:
        for text in legend.get_texts():
            text.set_text(fill(text.get_text(), MOST_LETTERS // columns - 8, break_on_hyphens=False))


@styled
def plot_signals(run: RawRun) -> "Figure":
    """Draw each recorded signal of a run in a panel."""
    x, label = course(run)
    return _stacked(signal_panels(x, run), f"{run.id}: signals", run.samples, label)


@styled
def plot_depth(corrected: CorrectedRun, clean_up: CleanUp | None = None) -> "Figure":
    """Draw the depth signal, its drift, and the corrected wear with the post-test measurement."""
    x, label = course(corrected.run)
    words = _drift_words(corrected)
    return _stacked(depth_panels(x, corrected, clean_up), f"{corrected.id}: depth signal", words, label)


def _drift_words(corrected: CorrectedRun) -> str:
    correction = corrected.correction
    if correction.end_wear_depth is None:
        return in_lines(_with_minus(corrected.run.manifest.worded(str(correction))))
    rate, discrepancy = in_unit(correction.drift_rate, "nm/min"), in_unit(correction.discrepancy, "um")
    return _with_minus(f"drift {rate}, discrepancy {discrepancy}")


def _with_minus(words: str) -> str:
    """Write negative numbers with the minus sign of the axes; hyphens in words and ids stay."""
    return re.sub(r"(?<!\S)-(?=\d)", "−", words)


@styled
def plot_friction(run: RawRun, fit: FrictionFit, clean_up: CleanUp | None = None) -> "Figure":
    """Draw the friction coefficient with the fit of Eq. 7 and the residuals, or the steady-state value over time."""
    x, label = slide(run)
    panels = friction_panels(x, run, fit, clean_up)
    return _stacked(panels, f"{run.id}: friction", in_lines(_friction_words(fit)), label)


def _friction_words(fit: FrictionFit) -> str:
    if fit.steady_state is not None and fit.window is None:
        return f"b = {fit.steady_state}, the mean of the second half; sliding distance unknown"
    if fit.outcome != "exponential":
        return f"b = {fit.steady_state}: {fit.notes[-2]}" if fit.steady_state else "; ".join(fit.notes)
    return f"A = {fit.amplitude}, b = {fit.steady_state}, c = {fit.running_in_distance}"


@styled
def plot_wear(corrected: CorrectedRun, fits: Sequence[WearCurves], predictions: Sequence[WearCurves] = ()) -> "Figure":
    """Draw the wear of each body with the fitted laws, and predictions from other runs, with 95 % bands.

    For discs, wear is the volume, or the depth or the track width if only that was measured. A disc that neither wears
    nor was measured has no panel. Residuals are shown below wear that was recorded along the run, and below
    measurements if there are more than are fitted.
    """
    from tribopipe.views.canvas import ShownFigure

    run = corrected.run
    along, label = course(run)
    bodies: dict[str, list[Panel]] = {}
    for panel in wear_panels(along, corrected, fits, predictions):
        bodies.setdefault(panel.body, []).append(panel)
    count = max(map(len, bodies.values()))
    figure = ShownFigure(figsize=(6.3, 3.9 if count == 1 else 5.0), dpi=150, layout="constrained")
    axes = figure.subplots(count, len(bodies), sharex=True, sharey="row", squeeze=False, height_ratios=[3, 1][:count])
    power = _power([panels[0] for panels in bodies.values()])
    for place, (body, panels) in enumerate(bodies.items()):
        for row, panel in enumerate(panels):
            draw_panel(axes[row][place], panel, 0 if row else power)
            axes[row][place].set_ylabel("" if place else axes[row][place].get_ylabel())
            axes[row][place].margins(x=0.02)
        if len(bodies) > 1:
            _name(axes[0][place], f"({'ab'[place]}) {body}")
        axes[-1][place].set_xlabel(label)
    lowest = min(float(ax.dataLim.y0) for ax in axes[0])
    axes[0][0].set_ylim(bottom=0.0 if lowest >= 0 else None)
    if panels[-1].limit is not None:
        low, high = axes[-1][0].get_ylim()
        axes[-1][0].set_ylim(min(low, -2.5), max(high, 2.5))
    both = f" of {'both discs' if len(bodies) > 1 else f'the {body}'}" if body else ""
    told = basis_words(curve.result for curve in fits if isinstance(curve.result, WearFit))
    head_figure(axes[0][0], f"{run.id}: wear{both}", [*map(_wear_words, fits), *map(in_lines, told)])
    key(figure, axes.flat)
    return figure


def _power(panels: Sequence[Panel]) -> int:
    """Return the power of a thousand to omit from the axis, for volumes only."""
    if panels[0].unit != VOLUME:
        return 0
    ends = [float(from_si(np.nanmax(curve.y), "m^3", "mm^3")) for panel in panels for curve in panel.curves]
    return power_of(max([*ends, *(one.y for panel in panels for one in panel.marks)]))


def head_figure(ax: "Axes", title: str, words: Sequence[str]) -> None:
    """Write title and coefficients above a figure; they may be wider than its first panel."""
    finish(ax, title, "\n".join(words))
    ax.texts[-1].set_in_layout(False)


def _name(ax: "Axes", words: str, side: Literal["left", "right"] = "left") -> None:
    """Write the letter of a panel and its content into its upper corner."""
    ax.text(0.03 if side == "left" else 0.97, 0.97, words, transform=ax.transAxes, ha=side, va="top")


def four_panels(panels: Iterable[Panel], label: str) -> "tuple[Figure, list[Axes]]":
    """Draw four panels with a common axis, as in Fig. 9 of the paper, with letters where curves leave room."""
    from tribopipe.views.canvas import ShownFigure

    figure = ShownFigure(figsize=(6.3, 5.4), dpi=150, layout="constrained")
    axes = list(figure.subplots(2, 2, sharex=True).flat)
    for number, (ax, panel) in enumerate(zip(axes, panels, strict=False)):
        draw_panel(ax, panel)
        _name(ax, f"({'abcd'[number]})", "right" if number % 2 else "left")
        ax.set_xlabel(label if number > 1 else "")
    return figure, axes


@styled
def plot_contact(corrected: CorrectedRun, curves: WearCurves) -> "Figure":
    """Draw wear depth, mean pressure, a_x and a_z from a law along a run, with 95 % bands (paper, Fig. 9).

    The corrected depth signal is drawn with the depth of both bodies.
    """
    along, label = course(corrected.run)
    figure, axes = four_panels(contact_panels(along, corrected, [curves]), label)
    head_figure(axes[0], f"{corrected.id}: contact", [_wear_words(curves)])
    for ax in axes:
        ax.margins(x=0.02)
    key(figure, axes, 3)
    return figure


def _wear_words(curves: WearCurves) -> str:
    """Format a law with k_D of each body."""
    result, unit = curves.result, pretty(WEAR_COEFFICIENT)
    known = {name: body.wear_coefficient for name, body in result.bodies.items()}
    if result.distance_per_rotation is None:
        first = next(iter(known.values()), None)
        return f"{law_label(result.model)}: $k_\\mathrm{{D}}$ = {in_unit(first, WEAR_COEFFICIENT)}"
    each = ", ".join(
        f"{value.shown(WEAR_COEFFICIENT).removesuffix(f' {unit}')} ({spoken(name)})"
        for name, value in known.items()
        if value.value
    )
    head = f"{law_label(result.model)}, {result.distance_per_rotation}:"
    between = "\n" if len(head + each) + len(unit) > MOST_LETTERS - 8 else " "
    return f"{head}{between}$k_\\mathrm{{D}}$ / {unit} = {each}"


def basis_words(fits: Iterable[WearFit]) -> list[str]:
    """State the source of a k_D that is not from both depth signal and measurement, in the words of its findings."""
    findings = first_of_each_code(finding for fit in fits for finding in fit.findings)
    return [f"{finding.where}: {finding.message}" for finding in findings if finding.code in _ON_BASIS]


def _stacked(panels: Sequence[Panel], title: str, words: str, label: str) -> "Figure":
    """Draw panels below each other, the first one large."""
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
    """Write a title above a figure's first panel, and a text between them."""
    size = FORMULA if "$" in words else 8.0
    ax.set_title(title, loc="left", fontsize=10, fontweight="bold", pad=6 + 11 * (words.count("\n") + 1))
    ax.text(0.0, 1.02, words, transform=ax.transAxes, fontsize=size, va="bottom")
    ax.margins(x=0.01)


def in_lines(sentence: str) -> str:
    """Break a sentence into lines that fit above a figure."""
    return "\n".join(wrap(sentence, MOST_LETTERS))


def save_figure(figure: "Figure", path: Path) -> None:
    """Write a figure in the format of the file's suffix, completely or not at all, and reproducibly.

    Raises ``ArchiveError`` if the folder cannot be written.
    """
    save_figures(path.parent, {path.name: figure})


def save_figures(folder: Path, figures: "Mapping[str, Figure]", captions: Mapping[str, str] | None = None) -> None:
    """Write figures under these names as ``save_figure`` does.

    With captions, which are written as text files of these names, figures are for print: PNG has 600 dpi. None takes
    its place before all are written, and the first takes it last. Raises ``OutputError`` if something else than a
    figure of this package is there.
    """
    texts = captions or {}
    _require_free(folder, (*figures, *texts))
    _save(folder, _drawn(figures, for_print=captions is not None), texts)


def save_beside(
    archive: Archive, identifier: str, figures: "Mapping[str, Figure]", captions: Mapping[str, str] | None = None
) -> None:
    """Write figures of a run or study next to its archive, as ``save_figures`` does, in one process at a time.

    Remains of an interrupted process are removed. Raises ``ArchiveError`` and ``OutputError``.
    """
    folder, texts = archive.folder / FIGURES, captions or {}
    _require_free(folder, (*figures, *texts))
    # Drawing takes seconds, for which no other process has to wait.
    pictures = _drawn(figures, for_print=captions is not None)
    with archive.alone_with(identifier):
        for name in (*pictures, *texts):
            clear_leftovers_of(folder / name)
        _save(folder, pictures, texts)


def _drawn(figures: "Mapping[str, Figure]", *, for_print: bool) -> dict[str, bytes]:
    """Draw figures in the formats of their names' suffixes."""
    return {name: _picture(figure, Path(name).suffix, for_print=for_print) for name, figure in figures.items()}


def _require_free(folder: Path, names: Iterable[str]) -> None:
    """Refuse names that other files have, before figures are drawn, which takes seconds."""
    with _explained(folder):
        require_free((folder / name for name in names), own=made_here, beside_run=True)


@contextmanager
def _explained(folder: Path) -> Iterator[None]:
    """Report a folder that cannot be written."""
    try:
        yield
    except OSError as error:
        raise ArchiveError(
            f"{folder}: figures cannot be written ({error.strerror or error}); expected a folder with free space and "
            "write permission; correct this and run the same command again"
        ) from None


def _save(folder: Path, pictures: Mapping[str, bytes], texts: Mapping[str, str]) -> None:
    _require_free(folder, (*pictures, *texts))
    with _explained(folder):
        folder.mkdir(parents=True, exist_ok=True)
        with ExitStack() as written:
            for name, picture in pictures.items():
                written.enter_context(replacing(folder / name)).write_bytes(picture)
            for name, text in texts.items():
                written.enter_context(replacing(folder / name)).write_text(f"{text}\n", encoding="utf-8")


def _picture(figure: "Figure", suffix: str, *, for_print: bool) -> bytes:
    if suffix == ".png":
        return _png(figure, _PRINT_DPI if for_print else figure.dpi)
    picture = BytesIO()
    told = {
        ".svg": {"Creator": MADE_BY, "Date": None},
        ".pdf": {"Creator": MADE_BY, "CreationDate": None},
    }.get(suffix, {})
    with own_style():
        figure.savefig(picture, format=suffix.removeprefix("."), metadata=told)
    return picture.getvalue()


def _png(figure: "Figure", dpi: float) -> bytes:
    """Draw a figure once: ``savefig`` would draw it twice, the first time for its layout alone."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    picture, canvas, usual = BytesIO(), figure.canvas, figure.dpi
    with own_style():
        figure.set_dpi(dpi)
        FigureCanvasAgg(figure).print_png(  # type: ignore[no-untyped-call]
            picture, metadata={"Software": MADE_BY}, pil_kwargs={"compress_level": _PNG_LEVEL}
        )
        figure.set_dpi(usual)
    figure.set_canvas(canvas)  # the pixels, some 15 MB, are not kept with the figure
    return picture.getvalue()

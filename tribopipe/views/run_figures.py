"""Figures of one run: the depth signal and its correction, friction, and the wear curve beside the laws.

Colours are from the Okabe–Ito palette, which people with any colour vision can tell apart. The figures are made without
pyplot, so that they need no display and leave no state behind; in a notebook they show themselves.
"""

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
from tribopipe.base.units import WEAR_COEFFICIENT, axis, from_si, interval_from_si
from tribopipe.documents.preprocessing import CleanUp
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName
from tribopipe.documents.signals import SignalName
from tribopipe.evaluation.friction_paths import fitted_path
from tribopipe.physics.laws import LAWS, law_label
from tribopipe.pipeline.output_paths import MADE_BY, made_here, require_free
from tribopipe.results.evaluation import COVERAGE_FACTOR, DriftCorrection, FrictionFit
from tribopipe.results.finding import first_of_each_code
from tribopipe.results.run import CorrectedRun, RawRun
from tribopipe.results.wear_curves import WearCurves
from tribopipe.results.wear_fit import WearFit
from tribopipe.results.wear_prediction import WearPrediction
from tribopipe.views.decimation import thinned
from tribopipe.views.number_format import course, slid, slide

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


WANDER_NAME = "wander: slow, neither wear nor drift"
"""What the slow process of the model is called in legends."""
_ON_BASIS = ("reading_contradicts_measurement", "no_post_test_measurement")
"""Codes of findings by which a fitted curve is not what the reading or a measurement would have one expect."""
_MOST_LETTERS = 90
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


@styled
def plot_depth(corrected: CorrectedRun, clean_up: CleanUp | None = None) -> "Figure":
    """Draw the depth reading, what drift adds to it, and the corrected wear with the end value."""
    run, correction = corrected.run, corrected.correction
    figure, axes = _panels(1)
    ax = axes[0]
    along, label = course(run)
    reading = run.columns.get("depth")
    if reading is not None:
        name = f"sensor reading{_mended(clean_up, 'depth')}"
        ax.plot(*_micro(*thinned(along, reading)), color=GREY, lw=0.8, label=name)
    if corrected.wear_depth is not None and reading is not None:
        ax.plot(
            *_micro(*thinned(along, reading - corrected.wear_depth)),
            color=ORANGE,
            ls="--",
            label="zero offset and drift",
        )
        ax.plot(
            *_micro(*thinned(along, corrected.wear_depth)), color=_BLUE, lw=0.9, label=f"corrected wear, {_both(run)}"
        )
    if corrected.wander is not None:
        ax.plot(*_micro(*thinned(along, corrected.wander)), color=GREEN, lw=0.8, alpha=0.7, label=WANDER_NAME)
    anchor = f"end value, 95 % ({correction.anchor})".replace("_", " ")
    _mark_end(ax, along[-1], correction.end_wear_depth, anchor)
    finish(ax, f"{run.id}: depth signal", _drift_words(correction))
    ax.set_xlabel(label)
    ax.set_ylabel(axis("depth", "um"))
    figure.legend(loc="outside lower center", ncols=2)
    return figure


def _mended(clean_up: CleanUp | None, signal: SignalName) -> str:
    """Say of a recorded signal whether it is drawn as cleaned up."""
    if clean_up is None or not clean_up.changed(signal):
        return ""
    strokes = any((change.step, change.signal) == ("stroke-wise-friction", signal) for change in clean_up.changes)
    return ", cleaned up: one value a stroke" if strokes else ", cleaned up"


def _mark_end(ax: "Axes", last: float, end: Quantity | None, label: str) -> None:
    """Draw a depth measured after the test, where there is one, at the test's end."""
    if end is not None:
        ax.errorbar(
            last,
            from_si(end.value, "m", "um"),
            yerr=COVERAGE_FACTOR * interval_from_si(end.standard_uncertainty or 0.0, "m", "um"),
            fmt="o",
            ms=4,
            capsize=3,
            color=RED,
            label=label,
            zorder=5,
        )


def _drift_words(correction: DriftCorrection) -> str:
    if correction.end_wear_depth is None:
        return in_lines(str(correction))
    return f"drift {_shown(correction.drift_rate, 'nm/min')}, discrepancy {_shown(correction.discrepancy, 'um')}"


def _both(run: RawRun) -> str:
    return "both bodies" if run.manifest.contact is None else run.manifest.contact.both


@styled
def plot_friction(run: RawRun, fit: FrictionFit, clean_up: CleanUp | None = None) -> "Figure":
    """Draw the friction coefficient with Eq. 7 as fitted and the residuals, or the steady value alone against time."""
    figure, (ax, *residuals) = _panels(1 if fit.window is None else 2)
    along, label = slide(run)
    mu = run.columns.get("friction_coefficient", np.full_like(along, np.nan))
    ax.plot(*thinned(along, mu), color=GREY, lw=0.6, label=f"measured{_mended(clean_up, 'friction_coefficient')}")
    if residuals:
        _draw_fit(ax, residuals[0], along, mu, fit)
    elif fit.steady_state is not None:
        ax.axhline(fit.steady_state.value, color=_BLUE, label="steady value")
    ax.set_ylabel("friction coefficient μ")
    finish(ax, f"{run.id}: friction", in_lines(_friction_words(fit)))
    figure.axes[-1].set_xlabel(label)
    figure.legend(loc="outside lower center", ncols=2)
    return figure


def _draw_fit(ax: "Axes", below: "Axes", distance: Column, mu: Column, fit: FrictionFit) -> None:
    """Draw fitted friction where it was fitted, and in the panel below what measured friction differs from it."""
    path = fitted_path(fit)
    if path is None or fit.window is None:
        return
    inside = (distance >= fit.window[0].value) & (distance <= fit.window[1].value)
    fitted = path.coefficient(distance)
    name = "A·exp(−s/c) + b" if fit.outcome == "exponential" else "steady value"
    ax.plot(distance[inside], fitted[inside], color=_BLUE, label=name)
    below.plot(*thinned(distance[inside], (mu - fitted)[inside]), color=GREY, lw=0.6)
    below.axhline(0, color=BLACK, lw=0.8)
    below.set_ylabel("residual of μ")
    _mark_left_out(ax, distance, fit)


def _mark_left_out(ax: "Axes", distance: Column, fit: FrictionFit) -> None:
    if fit.window is None:
        return
    if fit.window[0].value > distance[0]:
        ax.axvspan(distance[0], fit.window[0].value, color=ORANGE, alpha=0.25, lw=0, label="left out")


def _friction_words(fit: FrictionFit) -> str:
    if fit.steady_state is not None and fit.window is None:
        return f"b = {fit.steady_state}, the mean of the later half; the sliding distance is not known"
    if fit.outcome != "exponential":
        return f"b = {fit.steady_state}: {fit.notes[-2]}" if fit.steady_state else "; ".join(fit.notes)
    return f"A = {fit.amplitude}, b = {fit.steady_state}, c = {fit.running_in_distance}"


@styled
def plot_wear(corrected: CorrectedRun, fits: Sequence[WearCurves], predictions: Sequence[WearCurves] = ()) -> "Figure":
    """Draw the pin's wear with the fitted laws, their residuals, and predictions from another run, with 95 % bands."""
    figure, (ax, below) = _panels(2)
    run, wear, distance = corrected.run, corrected.pin_wear_depth, corrected.run.sliding_distance
    if wear is not None:
        ax.plot(*_micro(*thinned(distance, wear)), color=GREY, lw=0.8, label="pin wear, corrected")
    for curve in fits:
        colour = law_look(curve.result.model).colour
        _draw_law(
            ax, distance, curve, colour, law_look(curve.result.model).fitted, f"{law_label(curve.result.model)}, fitted"
        )
        if wear is not None:
            below.plot(*_micro(*thinned(distance, wear - curve.bands["wear_depth"].best)), color=colour, lw=0.6)
    for curve in predictions:
        source = curve.result.reference if isinstance(curve.result, WearPrediction) else None
        name = f"{law_label(curve.result.model)}, predicted from {source or 'a given k_D'}"
        _draw_law(ax, distance, curve, GREEN, law_look(curve.result.model).predicted, name)
    _mark_end(ax, distance[-1], corrected.correction.pin_wear_depth, "pin wear measured after the test, 95 %")
    below.axhline(0, color=BLACK, lw=0.8)
    below.set_ylabel(axis("residual", "um"))
    ax.set_ylabel(axis("pin wear depth", "um"))
    coefficients = (_wear_words(curve.result) for curve in fits)
    told = basis_words(curve.result for curve in fits if isinstance(curve.result, WearFit))
    finish(ax, f"{run.id}: wear", "\n".join([*coefficients, *map(in_lines, told)]))
    below.set_xlabel(slid(run))
    ax.set_ylim(bottom=min(0.0, ax.get_ylim()[0]))
    figure.legend(loc="outside lower center", ncols=2)
    return figure


def _draw_law(ax: "Axes", distance: Column, curve: WearCurves, colour: str, style: str, name: str) -> None:
    band = curve.bands["wear_depth"]
    ax.plot(*_smooth(distance, band.best), color=colour, ls=style, label=name)
    x, lower, upper = _smooth(distance, band.lower, band.upper)
    ax.fill_between(x, lower, upper, color=colour, alpha=0.15, lw=0)


def _wear_words(fit: WearFit | WearPrediction) -> str:
    known = None if fit.first is None else fit.first.wear_coefficient
    return f"{law_label(fit.model)}: $k_\\mathrm{{D}}$ = {_shown(known, WEAR_COEFFICIENT)}"


def basis_words(fits: Iterable[WearFit]) -> list[str]:
    """Say of k_D that reading and measurement do not give together what gives it, in the words of its findings."""
    findings = first_of_each_code(finding for fit in fits for finding in fit.findings)
    return [f"{finding.where}: {finding.message}" for finding in findings if finding.code in _ON_BASIS]


def _shown(quantity: Quantity | None, unit: str) -> str:
    return "unknown" if quantity is None else quantity.shown(unit)


def _micro(distance: Column, depth: Column) -> tuple[Column, Column]:
    return distance, from_si(depth, "m", "um")


def _smooth(distance: Column, *curves: Column) -> list[Column]:
    """Take as many points as a smooth curve needs, closer where wear is steepest; depths in µm."""
    last = len(distance) - 1
    steep, even = np.geomspace(1, max(last, 1), 120), np.linspace(0, last, 120)
    kept = np.unique(np.concatenate([[0], steep, even]).astype(int).clip(0, last))
    return [distance[kept], *(from_si(curve[kept], "m", "um") for curve in curves)]


def _panels(count: int) -> "tuple[Figure, list[Axes]]":
    from tribopipe.views.canvas import ShownFigure

    figure = ShownFigure(figsize=(6.3, 3.9 if count == 1 else 5.0), dpi=150, layout="constrained")
    grid = figure.subplots(count, 1, sharex=True, squeeze=False, height_ratios=[3, 1][:count])
    return figure, [row[0] for row in grid]


def finish(ax: "Axes", title: str, words: str) -> None:
    """Put a title over a figure's first panel, and words between them."""
    ax.set_title(title, loc="left", fontsize=10, fontweight="bold", pad=6 + 11 * (words.count("\n") + 1))
    ax.text(0.0, 1.02, words, transform=ax.transAxes, fontsize=8, va="bottom")
    ax.margins(x=0.01)


def in_lines(sentence: str) -> str:
    """Break a sentence into lines that fit above a figure."""
    return "\n".join(wrap(sentence, _MOST_LETTERS))


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

"""Figure of a study of twin-disc runs in the size of a journal's columns: volume worn off each disc under one law.

It holds what Figure 12 of the paper does, with the uncertainties besides, and below how far what was measured lies
from the law. The discs differ in colour (Okabe–Ito), in marker and in line style, so that it survives greyscale.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from tribopipe.base.units import from_si, show, show_force
from tribopipe.documents.recipe import LawName
from tribopipe.physics.laws import law_heading
from tribopipe.results.agreement import BodyVerdict, LawResult, RunVerdict, StudyResult, Verdict
from tribopipe.results.evaluation import COVERAGE_FACTOR
from tribopipe.results.study_curves import StudyCurve
from tribopipe.results.wear_fit import spoken
from tribopipe.views.layout import ONE_COLUMN, TWO_COLUMNS, in_columns, letter, rows_and_columns
from tribopipe.views.number_format import coefficient_words, power_of, powered_axis
from tribopipe.views.run_figures import BLACK, GREY, PALETTE

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class _Look(NamedTuple):
    """How a disc is drawn wherever it stands."""

    colour: str
    dashes: Any
    marker: str
    aside: float
    """Shift against the other disc where both would hide each other, in shares of the axis."""


_LOOKS: dict[str, _Look] = {
    "curved_disc": _Look(PALETTE[0], "-", "o", -0.01),
    "flat_disc": _Look(PALETTE[1], (0, (5, 1.6)), "s", 0.01),
}
_CALLED_OFF: dict[Verdict, tuple[str, str]] = {
    "under-predicts": ("x", "law under-predicts"),
    "over-predicts": ("+", "law over-predicts"),
    "not decidable": ("$?$", "not decidable"),
}
"""Marks of runs on which the law is not supported."""
_APART = 0.04
"""Between runs that end together, in shares of the axis."""


_KEY_COLUMNS = (1, 4)
"""Of the legend below one panel, and below several."""


class _Scales(NamedTuple):
    """Powers of a thousand left out of the axes, and the most rotations of any run."""

    rotations: int
    volume: int
    last: float

    def turns(self, values: Any) -> Any:
        return values / 10.0**self.rotations

    def volumes(self, values: Any) -> Any:
        return from_si(values, "m^3", "mm^3") / 10.0**self.volume


@in_columns
def plot_disc_study(result: StudyResult, law: LawName, curves: Sequence[StudyCurve]) -> "Figure":
    """Draw the volume worn off each disc in all runs beside one law, with 95 % bands (paper, Fig. 12).

    Runs of one slip and load share a panel, in which the law is drawn along the longest of them. Below, what was
    measured stands over what the law says. Runs on which no volume was measured are counted in the legend.
    """
    found = result.law(law)
    groups = _groups(found.runs)
    lines = {words: _lines(found, runs, curves) for words, runs in groups.items()}
    scales = _scales(found, [line for some in lines.values() for line in some.values()])
    figure, pairs = _pairs(len(groups))
    for number, ((words, runs), (ax, below)) in enumerate(zip(groups.items(), pairs, strict=True)):
        for disc, curve in lines[words].items():
            _draw_law(ax, below, curve, _LOOKS[disc], scales)
        for run, shift in _side_by_side(runs, scales.last):
            for disc, one in _volumes(run).items():
                _draw_measured((ax, below), run, disc, one, shift, scales)
        below.axhline(1, color=GREY, lw=0.6, zorder=1)
        letter(ax, number, words, len(groups))
    _finish(figure, pairs, scales)
    figure.suptitle(_words(found, ", " if len(groups) > 1 else "\n$k_\\mathrm{D}$ = "), x=0.01, ha="left", fontsize=8.6)
    figure.legend(
        handles=_key(found), loc="outside lower center", ncols=_KEY_COLUMNS[len(groups) > 1], handlelength=3.0
    )
    return figure


def _groups(runs: Sequence[RunVerdict]) -> dict[str, list[RunVerdict]]:
    """Put runs of the same slip and load together, by these in words, in their order."""
    found: dict[str, list[RunVerdict]] = {}
    for run in sorted(runs, key=lambda run: (_slip(run), run.normal_load.value)):
        words = f"{show(_slip(run), None, '1', '%')} slip, {show_force(run.normal_load.value)}"
        found.setdefault(words, []).append(run)
    return found


def _slip(run: RunVerdict) -> float:
    return 0.0 if run.slip is None else run.slip.value


def _lines(law: LawResult, runs: Sequence[RunVerdict], curves: Sequence[StudyCurve]) -> Mapping[str, StudyCurve]:
    """Return what the law says of each disc along the longest of some runs."""
    ids = {run.id for run in runs}
    found: dict[str, StudyCurve] = {}
    for name in law.bodies:
        of_body = [one for one in curves if (one.model, one.body) == (law.model, name) and one.run_id in ids]
        if of_body:
            found[name] = max(of_body, key=lambda one: float(one.places[-1]))
    return found


def _volumes(run: RunVerdict) -> dict[str, BodyVerdict]:
    return {name: one for name, one in run.bodies.items() if one.what == "wear_volume"}


def _scales(law: LawResult, lines: Sequence[StudyCurve]) -> _Scales:
    last = max(run.end.value for run in law.runs)
    volumes = [float(line.predicted[-1]) for line in lines]
    volumes += [one.measured.value for run in law.runs for one in _volumes(run).values()]
    return _Scales(power_of(last), power_of(float(from_si(max(volumes, default=0.0), "m^3", "mm^3"))), last)


def _side_by_side(runs: Sequence[RunVerdict], last: float) -> Iterator[tuple[RunVerdict, float]]:
    """Shift runs that end close together, so that their error bars do not hide each other; in rotations."""
    near: list[list[RunVerdict]] = []
    for run in sorted(runs, key=lambda run: run.end.value):
        if near and run.end.value - near[-1][-1].end.value < _APART / 2 * last:
            near[-1].append(run)
        else:
            near.append([run])
    for some in near:
        for place, run in enumerate(some):
            yield run, (place - (len(some) - 1) / 2) * _APART * last


def _draw_law(ax: "Axes", below: "Axes", curve: StudyCurve, look: _Look, scales: _Scales) -> None:
    turns = scales.turns(curve.places)
    line, low, high = (scales.volumes(values) for values in (curve.predicted, curve.lower, curve.upper))
    ax.fill_between(turns, low, high, color=look.colour, alpha=0.2, lw=0)
    ax.plot(turns, line, color=look.colour, ls=look.dashes)
    worn = line > 0
    below.fill_between(turns[worn], low[worn] / line[worn], high[worn] / line[worn], color=look.colour, alpha=0.2, lw=0)


def _draw_measured(
    pair: "tuple[Axes, Axes]", run: RunVerdict, disc: str, one: BodyVerdict, shift: float, scales: _Scales
) -> None:
    from matplotlib.transforms import offset_copy

    (ax, below), look, place = pair, _LOOKS[disc], run.end.value + shift
    spread = COVERAGE_FACTOR * (one.measured.standard_uncertainty or 0.0)
    said = one.predicted.value
    points = [(ax, place, scales.volumes(one.measured.value), scales.volumes(spread))]
    if said > 0:
        points.append((below, place + look.aside * scales.last, one.measured.value / said, spread / said))
    for panel, rotations, value, half in points:
        panel.errorbar(
            scales.turns(rotations),
            value,
            yerr=half,
            ls="",
            elinewidth=0.9,
            capsize=2,
            zorder=5,
            **_marks(look, filled=run.role == "fitted"),
        )
        if one.outcome in _CALLED_OFF:
            above = offset_copy(panel.transData, panel.figure, y=6, units="points")  # type: ignore[arg-type]
            cross = _cross(one.outcome)
            panel.plot(scales.turns(rotations), value + half, transform=above, clip_on=False, **cross)


def _marks(look: _Look, *, filled: bool) -> dict[str, Any]:
    """Fill the markers of runs that identify k_D."""
    return {"color": look.colour, "marker": look.marker, "ms": 3.6, "mew": 0.8, "mfc": None if filled else "white"}


def _cross(outcome: Verdict) -> dict[str, Any]:
    return {"color": BLACK, "marker": _CALLED_OFF[outcome][0], "ls": "", "ms": 4.5, "mew": 1.0, "zorder": 6}


def _pairs(count: int) -> "tuple[Figure, list[tuple[Axes, Axes]]]":
    """Lay out so many panels, each with a smaller one below, on common axes."""
    from tribopipe.views.canvas import ShownFigure

    rows, columns = rows_and_columns(count)
    width = ONE_COLUMN if count == 1 else TWO_COLUMNS
    figure = ShownFigure(figsize=(width, (1.9 if count == 1 else 0.9) + 2.9 * rows), dpi=300, layout="constrained")
    grid = figure.add_gridspec(2 * rows, columns, height_ratios=[2.4, 1] * rows)
    pairs: list[tuple[Axes, Axes]] = []
    for number in range(count):
        row, column = divmod(number, columns)
        first = pairs[0] if pairs else (None, None)
        ax = figure.add_subplot(grid[2 * row, column], sharex=first[0], sharey=first[0])
        below = figure.add_subplot(grid[2 * row + 1, column], sharex=ax, sharey=first[1])
        pairs.append((ax, below))
        ax.tick_params(labelbottom=False, labelleft=column == 0)
        below.tick_params(labelleft=column == 0)
    return figure, pairs


def _finish(figure: "Figure", pairs: "Sequence[tuple[Axes, Axes]]", scales: _Scales) -> None:
    ax, below = pairs[0]
    ax.set_xlim(0.0, scales.turns(1.06 * scales.last))
    for one, least in ((ax, 0.0), (below, 0.9)):
        low, high = one.get_ylim()
        # Room for marks above error bars; points at the axis stay whole.
        one.set_ylim(min(least, low) if one is below else -0.02 * high, high + 0.08 * (high - low))
    _, columns = rows_and_columns(len(pairs))
    for number, (panel, below) in enumerate(pairs):
        below.set_xlabel(powered_axis("rotations of the curved disc", scales.rotations))
        if number % columns == 0:
            panel.set_ylabel(powered_axis("volume worn off", scales.volume, "mm^3"))
            below.set_ylabel("measured\nover law")
    figure.align_ylabels()


def _words(law: LawResult, between: str) -> str:
    fitted = [run.id for run in law.runs if run.role == "fitted"]
    source = fitted[0] if len(fitted) == 1 else f"{len(fitted)} runs"
    each = between.join(
        f"{coefficient_words(found.wear_coefficient)} ({spoken(name)})" for name, found in law.bodies.items()
    )
    name = f"{law_heading(law.model)}, {law.distance_per_rotation}, fitted to {source}"
    return f"{name}\n$k_\\mathrm{{D}}$ = {each}"


def _key(law: LawResult) -> "list[Artist]":
    """Say what is drawn of every run."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    drawn = [one for run in law.runs for one in _volumes(run).values()]
    handles: list[Artist] = []
    for name in law.bodies:
        look = _LOOKS[name]
        handles.append(Line2D([], [], ls=look.dashes, label=spoken(name), **_marks(look, filled=True)))
    grey = _Look(GREY, "", "o", 0.0)
    for role in ("fitted", "predicted"):
        if any(run.role == role for run in law.runs):
            marks = _marks(grey, filled=role == "fitted")
            handles.append(Line2D([], [], ls="", label=f"measured, 95 %, run {role}", **marks))
    handles.append(Patch(color=GREY, alpha=0.35, lw=0, label="law, 95 % band"))
    for outcome, (_, words) in _CALLED_OFF.items():
        if any(one.outcome == outcome for one in drawn):
            handles.append(Line2D([], [], label=words, **_cross(outcome)))
    handles.append(Line2D([], [], color="none", label="(side by side where they would overlap)"))
    silent = sum(not _volumes(run) for run in law.runs)
    if silent:
        handles.append(Line2D([], [], color="none", label=f"runs without measured volume: {silent}"))
    return handles

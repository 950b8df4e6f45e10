"""The plots of one run, each defined once: depth, friction, wear of each body with the laws, and contact."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tribopipe.archive.step_names import PREDICTIONS, WEAR_FITS
from tribopipe.base.arrays import Column
from tribopipe.documents.contact_kinds import ROLLING_ROLES, spoken
from tribopipe.documents.preprocessing import CleanUp
from tribopipe.documents.signals import SignalName
from tribopipe.evaluation.load_and_friction import fitted_path
from tribopipe.evaluation.measurements.body_wear import MeasuredQuantity
from tribopipe.physics.laws import law_label
from tribopipe.results.evaluation import COVERAGE_FACTOR, FrictionFit
from tribopipe.results.run import CorrectedRun, RawRun
from tribopipe.results.specific_wear import measured_quantities
from tribopipe.results.wear_fit import FittedValue, WearFit
from tribopipe.results.wear_prediction import Outcome, WearCurves, WearPrediction
from tribopipe.views.plot import MICRONS, RATIO, VOLUME, Curve, Mark, Panel, Role, Unit, mark, signal_unit

CORRECTED, PIN_WEAR = "/entry/drift_correction/data/wear_depth", "/entry/drift_correction/data/pin_wear_depth"
WANDER = "/entry/drift_correction/data/wander"
_FRICTION = "/entry/friction_fit/data/friction_coefficient"
WANDER_NAME = "low-frequency fluctuations (neither wear nor drift)"
"""Name of the slow process of the model in legends."""
RAW, CLEANED = "/entry/raw/", "/entry/clean_up/data/"
"""Paths of recorded and of preprocessed signals."""
AXES: tuple[SignalName, ...] = ("rotations", "sliding_distance", "time")
"""Signals of horizontal axes."""


def signal_panels(x: Column, run: RawRun, names: Iterable[SignalName] | None = None) -> tuple[Panel, ...]:
    """Draw signals, each in its own panel: those specified, or all except the axes."""
    shown = [name for name in run.columns if name not in AXES] if names is None else names
    return tuple(_signal_panel(x, name, {name.replace("_", " "): (run, RAW)}) for name in shown)


def clean_up_panels(x: Column, raw: RawRun, cleaned: RawRun, names: Iterable[SignalName]) -> tuple[Panel, ...]:
    """Draw signals changed by preprocessing, before and after; only before if a signal was excluded."""
    runs = {"as recorded": (raw, RAW), "preprocessed": (cleaned, CLEANED)}
    return tuple(_signal_panel(x, name, runs) for name in names)


def _signal_panel(x: Column, name: SignalName, runs: Mapping[str, tuple[RawRun, str]]) -> Panel:
    manifest = next(iter(runs.values()))[0].manifest
    unit = signal_unit(name, manifest)
    curves = tuple(
        Curve(said, "measured", x, run.columns[name], unit, manifest.id, path=folder + name)
        for said, (run, folder) in runs.items()
        if name in run.columns
    )
    return Panel(name.replace("_", " "), unit, curves)


def depth_panels(x: Column, corrected: CorrectedRun, clean_up: CleanUp | None = None) -> tuple[Panel, ...]:
    """Draw the depth signal, its drift, and the corrected wear with the post-test measurement."""
    run, wear, curves = corrected.run, corrected.wear_depth, []
    read, scale = run.columns.get("depth"), run.manifest.depth_scale.value
    both = "both bodies" if run.manifest.contact is None else run.manifest.contact.both
    # Only what the bodies approach by is comparable with wear; the rest of the difference is then drift.
    approach = None if read is None else scale * read
    if approach is not None:
        name = f"sensor reading{'' if scale == 1 else f' × {scale:.4g}'}{_cleaned(clean_up, 'depth')}"
        curves.append(Curve(name, "measured", x, approach, MICRONS, run.id, path="depth"))
    if approach is not None and wear is not None:
        curves.append(Curve("zero offset and drift", "drift", x, approach - wear, MICRONS, run.id))
        curves.append(Curve(f"corrected wear, {both}", "measured", x, wear, MICRONS, run.id, path=CORRECTED))
    if corrected.wander is not None:
        curves.append(Curve(WANDER_NAME, "wander", x, corrected.wander, MICRONS, run.id, path=WANDER))
    anchor = corrected.correction.anchor
    name = "measured, 95 % CI" + (f" ({measured_quantities(anchor)})" if anchor else "")
    marks = mark(name, run.id, x, corrected.correction.end_wear_depth, MICRONS)
    return (Panel("depth", MICRONS, tuple(curves), marks),)


def _cleaned(clean_up: CleanUp | None, signal: SignalName) -> str:
    """Return the label suffix of a recorded signal that is drawn as preprocessed."""
    if clean_up is None or not clean_up.changed(signal):
        return ""
    strokes = any((change.step, change.signal) == ("stroke-wise-friction", signal) for change in clean_up.changes)
    return ", preprocessed: one value per stroke" if strokes else ", preprocessed"


def friction_panels(
    x: Column, run: RawRun, fit: FrictionFit | None, clean_up: CleanUp | None = None
) -> tuple[Panel, ...]:
    """Draw the friction coefficient with the fit of Eq. 7 and the residuals, or with the steady-state value."""
    mu, fitted = run.columns.get("friction_coefficient"), _fitted_friction(run, fit)
    left_out, curves, residuals = None, [], []
    if mu is not None:
        name = f"measured{_cleaned(clean_up, 'friction_coefficient')}"
        curves.append(Curve(name, "measured", x, mu, RATIO, run.id, path="friction_coefficient"))
    if fitted is not None and fit is not None:
        name = "fit, μ = A·exp(−s/c) + b" if fit.outcome == "exponential" else "steady-state value b"
        curves.append(Curve(name, "fit", x, fitted, RATIO, run.id, path=_FRICTION))
        if mu is not None and fit.window is not None:
            residuals.append(Curve("measured − fitted", "residual", x, mu - fitted, RATIO, run.id))
        left_out = _not_fitted(x, mu, fitted)
    above = Panel("friction coefficient μ", RATIO, tuple(curves), left_out=left_out)
    return (above, Panel("residual of μ", RATIO, tuple(residuals))) if residuals else (above,)


def _not_fitted(x: Column, mu: Column | None, fitted: Column) -> tuple[float, float] | None:
    """Return the range of measured friction before the fit; None if there is none, as before the first stroke."""
    first = int(np.argmax(np.isfinite(fitted)))
    measured = first > 0 if mu is None else bool(np.isfinite(mu[:first]).any())
    return (float(x[0]), float(x[first])) if measured else None


def _fitted_friction(run: RawRun, fit: FrictionFit | None) -> Column | None:
    """Return fitted friction where it was fitted, NaN elsewhere; along the whole run if its distance is unknown."""
    path = fitted_path(fit)
    if fit is None or path is None:
        return None
    if fit.window is None:
        return None if fit.steady_state is None else np.full(len(run), fit.steady_state.value)
    slid = run.sliding_distance
    inside = (slid >= fit.window[0].value) & (slid <= fit.window[1].value)
    return np.where(inside, path.coefficient(slid), np.nan)


class _Shown(NamedTuple):
    """Displayed wear of one body."""

    body: str
    quantity: str
    outcome: str
    """Key of this quantity in ``WearCurves.bands``, such as "curved_depth"."""
    unit: Unit
    marks: tuple[Mark, ...]
    measured: Column | None = None
    factor: float = 1.0


class ShownQuantity(NamedTuple):
    """Display of a quantity: its name in a law for each disc, axis label, and unit."""

    outcomes: tuple[Outcome, Outcome]
    label: str
    unit: Unit
    factor: float = 1.0


QUANTITIES: dict[MeasuredQuantity, ShownQuantity] = {
    "wear_volume": ShownQuantity(("curved_volume", "flat_volume"), "wear volume", VOLUME),
    "wear_depth": ShownQuantity(("curved_depth", "flat_depth"), "wear depth", MICRONS),
    "track_width": ShownQuantity(("half_width", "half_width"), "track width", MICRONS, 2.0),
}
"""Quantities that can be measured on a disc, the usual ones first."""


class MeasuredPoint(NamedTuple):
    """One measurement on a disc of a run."""

    disc: str
    what: MeasuredQuantity
    value: FittedValue


def wear_panels(
    x: Column, corrected: CorrectedRun, fits: Sequence[WearCurves], predictions: Sequence[WearCurves] = ()
) -> tuple[Panel, ...]:
    """Draw the wear of each body with the laws, predictions, 95 % bands and measured values.

    For discs, wear is the volume, or the depth or the track width if only that was measured. A disc that neither wears
    nor was measured has no panel. Residuals are shown below wear that was recorded along the run.
    """
    run, laws, panels = corrected.run, [*fits, *predictions], []
    rolls = any("wear_depth" not in curves.bands for curves in laws)
    for shown in _discs(x, run, laws) if rolls else [_pin(x, corrected)]:
        lines = [_law(x, run.id, curves, shown.outcome, shown.unit, shown.factor) for curves in laws]
        wear = shown.measured
        if wear is not None:
            lines.insert(
                0, Curve(f"corrected {_pin_name(run)} wear", "measured", x, wear, shown.unit, run.id, path=PIN_WEAR)
            )
        panels.append(Panel(shown.quantity, shown.unit, tuple(lines), shown.marks, shown.body))
        left = tuple(
            Curve(f"measured − {line.name}", "residual", x, wear - line.y, shown.unit, run.id, line.law)
            for line in lines
            if wear is not None and line.role == "fit"
        )
        panels += [Panel("residual", shown.unit, left)] if left else []
        panels += _spare(x, run, fits, shown.body) if shown.body else []
    return tuple(panels)


def _spare(x: Column, run: RawRun, fits: Sequence[WearCurves], body: str) -> list[Panel]:
    """Draw residuals of measurements on a body over their standard uncertainty, if more were made than are fitted."""
    if not any(isinstance(curves.result, WearFit) and curves.result.p_value is not None for curves in fits):
        return []
    marks = [
        Mark(
            f"residual of {spoken(point.what)}",
            run.id,
            place_on(x, run, point.value.place),
            residual,
            0.0,
            f"{residual:.2f}".replace("-", "−"),
            law=curves.result.model,
        )
        for curves in fits
        for point in measured_points([curves])
        if spoken(point.disc) == body and (spread := point.value.measured.standard_uncertainty)
        for residual in [(point.value.measured.value - point.value.fitted.value) / spread]
    ]
    return [Panel("residual / u", RATIO, (), tuple(marks), body, limit=COVERAGE_FACTOR)]


def _pin(x: Column, corrected: CorrectedRun) -> _Shown:
    pin = _pin_name(corrected.run)
    name = f"{pin} wear measured after the test, 95 % CI"
    marks = mark(name, corrected.id, x, corrected.correction.pin_wear_depth, MICRONS)
    return _Shown("", f"{pin} wear depth", "wear_depth", MICRONS, marks, corrected.pin_wear_depth)


def _pin_name(run: RawRun) -> str:
    """Return the name of the body in the role of the pin, such as "ball" or "block"."""
    return run.manifest.worded("the pin").removeprefix("the ")


def _discs(x: Column, run: RawRun, laws: Sequence[WearCurves]) -> Iterator[_Shown]:
    points = measured_points(laws)
    measured = {point.what for point in points}
    what = next((kind for kind in QUANTITIES if kind in measured), next(iter(QUANTITIES)))
    shown = QUANTITIES[what]
    for disc, outcome in zip(ROLLING_ROLES, shown.outcomes, strict=True):
        if disc in drawn_discs(points, laws):
            here = [point.value for point in points if (point.disc, point.what) == (disc, what)]
            marks = tuple(
                one
                for value in here
                for one in mark("measured, 95 % CI", run.id, place_on(x, run, value.place), value.measured, shown.unit)
            )
            yield _Shown(spoken(disc), shown.label, outcome, shown.unit, marks, factor=shown.factor)


def place_on(x: Column, run: RawRun, place: float) -> float:
    """Return the position on an axis of a point along the progress of a run."""
    known = np.isfinite(run.progress) & np.isfinite(x)
    return float(np.interp(place, run.progress[known], x[known])) if np.any(known) else np.nan


def measured_points(laws: Sequence[WearCurves]) -> list[MeasuredPoint]:
    """Return the measurements on the discs, from the first fit; they are the same in all."""
    fits = (curves.result for curves in laws if isinstance(curves.result, WearFit))
    return next(([_point(value) for value in fit.measurements] for fit in fits), [])


def _point(value: FittedValue) -> MeasuredPoint:
    disc = next(disc for disc in ROLLING_ROLES if value.name.startswith(disc))
    what = next(kind for kind in QUANTITIES if value.name.startswith(f"{disc}_{kind}"))
    return MeasuredPoint(disc, what, value)


def drawn_discs(points: Sequence[MeasuredPoint], laws: Sequence[WearCurves]) -> list[str]:
    """Return the discs that were measured, or that wear according to a law."""
    worn = {
        disc: any(np.any(one.bands[outcome].best > 0) for one in laws)
        for disc, outcome in zip(ROLLING_ROLES, QUANTITIES["wear_volume"].outcomes, strict=True)
    }
    return [disc for disc in ROLLING_ROLES if worn[disc] or any(point.disc == disc for point in points)]


def _law(x: Column, run: str, curves: WearCurves, outcome: str, unit: Unit, factor: float = 1.0) -> Curve:
    """Draw one quantity from a law along a run."""
    result, band = curves.result, curves.bands[outcome]
    name, steps = f"{law_label(result.model)}, fitted", WEAR_FITS
    role: Role = "fit"
    if isinstance(result, WearPrediction):
        name = f"{law_label(result.model)}, predicted from {result.reference or 'a given k_D'}"
        role, steps = "prediction", PREDICTIONS
    if factor == 1.0:
        path = f"/entry/{steps.get(result.model)}/data/{outcome}"
        return Curve(name, role, x, band.best, unit, run, result.model, band.lower, band.upper, path)
    best, low, high = (factor * line for line in (band.best, band.lower, band.upper))
    return Curve(name, role, x, best, unit, run, result.model, low, high)


_CONTACT: Mapping[Outcome, tuple[str, Unit]] = {
    "depth": ("wear depth of both discs", MICRONS),
    "pressure": ("mean pressure p", Unit("Pa", "GPa")),
    "half_width": ("half-width a_x", MICRONS),
    "half_length": ("half-length a_z", MICRONS),
}


def contact_panels(x: Column, corrected: CorrectedRun, fits: Sequence[WearCurves]) -> tuple[Panel, ...]:
    """Draw wear depth, mean pressure, a_x and a_z from the fitted laws along a run (paper, Fig. 9).

    The corrected depth signal is drawn with the depth of both discs, and for a single law also with that of each disc.
    """
    first, *others = (
        Panel(label, unit, tuple(_law(x, corrected.id, curves, outcome, unit) for curves in fits))
        for outcome, (label, unit) in _CONTACT.items()
    )
    if len(fits) == 1:
        first = Panel("wear depth", MICRONS, tuple(_depths(first.curves[0], fits[0])))
    if (signal := corrected.wear_depth) is not None:
        name = "depth signal, corrected"
        curve = Curve(name, "measured", x, signal, MICRONS, corrected.id, path=CORRECTED)
        first = replace(first, curves=(curve, *first.curves))
    return (first, *others)


def _depths(both: Curve, curves: WearCurves) -> Iterator[Curve]:
    """Draw the depth of both discs from a law, and of each; if only one disc wears, only its depth."""
    worn = drawn_discs((), [curves])
    if len(worn) > 1:
        yield replace(both, name="both discs", law=None, series=0)
    for number, (disc, outcome) in enumerate(zip(ROLLING_ROLES, QUANTITIES["wear_depth"].outcomes, strict=True), 1):
        if disc in worn:
            own = _law(both.x, both.run, curves, outcome, MICRONS)
            yield replace(own, name=spoken(disc), law=None, series=number)


_MODELS = {"local": "", "GIWM": "giwm_", "GIWM, Eq. 11 as published": "giwm_as_printed_"}
"""Models drawn for local wear, with the prefixes of their columns."""
_UNIFORM = {"GIWM": "uniform pressure"}
"""Other name of the model with uniform pressure where the counterbody of a pin wears."""
_COURSE = (
    ("wear depth", MICRONS, "depth"),
    ("groove depth", MICRONS, "track_depth"),
    ("pressure p", Unit("Pa", "MPa"), "pressure"),
    ("half-width a_x", MICRONS, "half_width"),
    ("half-length a_z", MICRONS, "half_length"),
)


def local_wear_panels(x: Column, columns: Mapping[str, Column], run: str, folder: str = "") -> tuple[Panel, ...]:
    """Draw depth, pressure and contact of local wear and of the GIWM (paper, Fig. 9), and the difference in depth.

    ``columns`` are those of the course in the archive, in ``folder``. A circular contact has one radius.
    """
    panels, names = [], _UNIFORM if "track_depth" in columns else {}
    for label, unit, what in _COURSE:
        if what not in columns and f"mean_{what}" not in columns:
            continue
        named = {names.get(name, name): f"{model}{what}" for name, model in _MODELS.items()}
        if what == "pressure":
            named |= {"local": "mean_pressure", "local, at the center": "middle_pressure"}
            named |= {"local, peak": "peak_pressure"}
        curves = []
        for number, (name, column) in enumerate(named.items()):
            if column in columns:
                role: Role = "prediction" if "giwm" in column else "fit"
                path = folder + column
                curves.append(Curve(name, role, x, columns[column], unit, run, path=path, series=min(number, 3)))
        panels.append(Panel(label, unit, tuple(curves)))
    if np.array_equal(columns["half_length"], columns["half_width"]):
        panels[-2:] = [replace(panels[-2], quantity="contact radius a")]
    local, giwm = columns["depth"], columns["giwm_depth"]
    share = local / np.where(giwm > 0, giwm, np.nan) - 1
    percent = Unit("1", "%")
    difference = Curve("local", "fit", x, share, percent, run, series=0)
    return (*panels, Panel(f"local − {names.get('GIWM', 'GIWM')}", percent, (difference,)))

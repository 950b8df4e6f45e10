"""Plots of two discs: the wear of each beside the laws, and their contact."""

from collections.abc import Iterator
from typing import NamedTuple

from tribopipe.archive.steps import PREDICTIONS, WEAR_FITS, StepName
from tribopipe.base.arrays import Column
from tribopipe.base.units import axis
from tribopipe.browse.drawing import MICRONS, Curve, Mark, Panel, Role, Unit, mark
from tribopipe.browse.pin_plots import CORRECTED
from tribopipe.browse.samples import RunFile
from tribopipe.documents.contact import DISCS, DiscName
from tribopipe.documents.recipe import LawName
from tribopipe.physics.laws import law_label
from tribopipe.results.wear_fit import WearFit, spoken
from tribopipe.results.wear_prediction import OUTCOMES, Outcome, WearPrediction
from tribopipe.views.disc_figures import QUANTITIES, MeasuredPoint, ShownQuantity, measured_point


class _Drawn(NamedTuple):
    """A step whose curves are drawn."""

    step: StepName
    law: LawName
    role: Role
    name: str


def draw_disc_wear(run: RunFile, x: Column) -> tuple[Panel, ...]:
    """Draw the wear of each disc with the laws, predictions, and what was measured.

    What is drawn is the volume; the depth, or the track width, where that alone was measured.
    """
    points = _points(run)
    shown = next((QUANTITIES[kind] for kind in QUANTITIES if any(p.what == kind for p in points)), None)
    shown = shown or QUANTITIES["wear_volume"]
    return tuple(_disc_panel(run, x, disc, shown, points) for disc in DISCS)


def _points(run: RunFile) -> list[MeasuredPoint]:
    fits = (run.result(name, WearFit) for name in WEAR_FITS.values())
    return next(([measured_point(value) for value in fit.measurements] for fit in fits if fit is not None), [])


def _disc_panel(run: RunFile, x: Column, disc: DiscName, shown: ShownQuantity, points: list[MeasuredPoint]) -> Panel:
    outcome = shown.outcomes[DISCS.index(disc)]
    unit = Unit(OUTCOMES[outcome], shown.unit)
    curves = tuple(curve for drawn in _steps(run) for curve in _band(run, x, drawn, outcome, unit, shown.factor))
    marks: list[Mark] = []
    for point in points:
        if point.disc == disc and QUANTITIES[point.what] is shown:
            marks += mark("measured", run.id, point.value.place, point.value.measured, unit)
    return Panel(axis(f"{spoken(disc)}, {shown.label}", shown.unit), curves, tuple(marks))


def _steps(run: RunFile) -> Iterator[_Drawn]:
    for law, name in WEAR_FITS.items():
        yield _Drawn(name, law, "fit", f"{law_label(law)}, fitted")
    for law, name in PREDICTIONS.items():
        prediction = run.result(name, WearPrediction)
        source = prediction.reference if prediction is not None else None
        yield _Drawn(name, law, "prediction", f"{law_label(law)}, predicted from {source or 'given k_D'}")


def _band(run: RunFile, x: Column, drawn: _Drawn, outcome: Outcome, unit: Unit, factor: float = 1.0) -> Iterator[Curve]:
    path = f"/entry/{drawn.step}/data/{outcome}"
    best, lower, upper = (run.curve(f"{path}{end}") for end in ("", "_lower", "_upper"))
    if best is None:
        return
    low, high = (None if line is None else line * factor for line in (lower, upper))
    stands = path if factor == 1.0 else None
    yield Curve(drawn.name, drawn.role, x, best * factor, unit, run.id, drawn.law, low, high, stands)


_CONTACT: tuple[tuple[Outcome, str, str], ...] = (
    ("depth", "wear depth of both discs", "um"),
    ("pressure", "mean pressure p", "GPa"),
    ("half_width", "half width a_x", "um"),
    ("half_length", "half length a_z", "um"),
)


def draw_contact(run: RunFile, x: Column) -> tuple[Panel, ...]:
    """Draw wear depth, mean pressure, a_x and a_z by the fitted laws along a run (paper, Fig. 9)."""
    fitted = [drawn for drawn in _steps(run) if drawn.role == "fit"]
    panels = []
    for outcome, label, unit in _CONTACT:
        curves = [curve for drawn in fitted for curve in _band(run, x, drawn, outcome, Unit(OUTCOMES[outcome], unit))]
        signal = run.curve(CORRECTED) if outcome == "depth" else None
        if signal is not None:
            curves.insert(0, Curve("depth signal, corrected", "measured", x, signal, MICRONS, run.id, path=CORRECTED))
        panels.append(Panel(axis(label, unit), tuple(curves)))
    return tuple(panels)

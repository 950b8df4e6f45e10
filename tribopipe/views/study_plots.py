"""The plots of a study, each defined once: wear of each body with a law, and effective k_D (paper, Fig. 5).

Wear recorded along the runs is shown as averages with the law. If wear was measured only at the end, a panel below
shows measured over predicted wear.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName
from tribopipe.evaluation.study.k_d_along_test import EffectiveCoefficient
from tribopipe.physics.friction_path import junction_factor
from tribopipe.physics.laws import law_label, law_title
from tribopipe.results.evaluation import COVERAGE_FACTOR
from tribopipe.results.study import CurveQuantity, LawResult, StudyCurve
from tribopipe.views.plot import COEFFICIENT, MICRONS, RATIO, VOLUME, Curve, Mark, Panel, Role, Unit, mark

BY_FRICTION = ("archard", "sarkar")
"""Laws under which effective k_D depends only on the friction coefficient."""
_UNITS: Mapping[CurveQuantity, Unit] = {"wear_depth": MICRONS, "wear_volume": VOLUME}


def study_panels(law: LawResult, curves: Sequence[StudyCurve], runs: Collection[str]) -> Iterator[Panel]:
    """Draw the wear of each body in some runs of a study with a law, 95 % bands and measured values.

    ``curves`` are all those of the study, in their order in the archive.
    """
    own = {
        f"/entry/curve_{number:03}": curve
        for number, curve in enumerate(curves)
        if curve.model == law.model and curve.run_id in runs
    }
    # In another contact, a body of the study has another name.
    for body in dict.fromkeys((*law.bodies, *(body for run in law.runs for body in run.bodies))):
        for what in _UNITS:
            shown = {path: curve for path, curve in own.items() if (curve.body, curve.what) == (body, what)}
            if shown:
                yield from _panels(law, body, shown)


def _panels(law: LawResult, body: str, shown: Mapping[str, StudyCurve]) -> Iterator[Panel]:
    what = next(iter(shown.values())).what
    unit, runs = _UNITS[what], {curve.run_id for curve in shown.values()}
    lines = [line for path, curve in shown.items() for line in _lines(curve, path, unit)]
    marks: list[Mark] = []
    shares: list[Mark] = []
    for run in law.runs:
        one = run.bodies.get(body)
        if run.id in runs and one is not None and one.what == what:
            share = _over(one.measured, one.predicted.value) if one.predicted.value > 0 else None
            for found, value, shown_in in ((marks, one.measured, unit), (shares, share, RATIO)):
                drawn = mark(f"{run.id}, measured, 95 % CI", run.id, run.end.value, value, shown_in)
                found += [replace(point, role=run.role, outcome=one.outcome) for point in drawn]
    yield Panel(spoken(what), unit, tuple(lines), tuple(marks), spoken(body))
    if all(curve.measured is None for curve in shown.values()):
        bands = tuple(_relative(curve) for curve in lines)
        yield Panel("measured / predicted", RATIO, bands, tuple(shares), spoken(body))


def _lines(curve: StudyCurve, path: str, unit: Unit) -> Iterator[Curve]:
    """Draw averages of the recorded signal along a run, and the law from its start."""
    run = curve.run_id
    if (found := curve.measured) is not None:
        # The last place is that of the post-test measurement, which is no reading of the sensor.
        best, low, high = (values[:-1] for values in (found.best, found.lower, found.upper))
        name = f"{run}, measured, averaged"
        yield Curve(name, "measured", curve.places[:-1], best, unit, run, None, low, high, f"{path}/measured")
    start = np.zeros(int(curve.places[0] > 0))
    x, best, low, high = (
        np.concatenate([start, values]) for values in (curve.places, curve.predicted, curve.lower, curve.upper)
    )
    name = f"{run}, {law_label(curve.model)}, {curve.role}"
    role: Role = "fit" if curve.role == "fitted" else "prediction"
    yield Curve(name, role, x, best, unit, run, curve.model, low, high, f"{path}/predicted")


def _relative(curve: Curve) -> Curve:
    """Draw the band of a law relative to the law."""
    worn = np.where(curve.y > 0, curve.y, np.nan)
    low, high = (None if edge is None else edge / worn for edge in (curve.lower, curve.upper))
    return replace(curve, y=worn / worn, unit=RATIO, lower=low, upper=high, path=None)


def _over(measured: Quantity, said: float) -> Quantity:
    spread = measured.standard_uncertainty
    return Quantity(
        value=measured.value / said, unit="1", standard_uncertainty=None if spread is None else spread / said
    )


class LawCoefficient(NamedTuple):
    """k_D from a law, and its 95 % interval."""

    law: LawName
    best: Quantity
    interval: tuple[Quantity, Quantity]


def coefficient_panel(measured: Sequence[EffectiveCoefficient], laws: Iterable[LawCoefficient]) -> Panel:
    """Draw effective k_D of each run in the order of sliding, and that of the laws, with 95 % bands."""
    curves = [_measured(one) for one in measured]
    if measured:
        curves += law_curves(friction_range(measured), laws)
    return Panel("effective k_D", COEFFICIENT, tuple(curves))


def _measured(found: EffectiveCoefficient) -> Curve:
    half = COVERAGE_FACTOR * found.standard_uncertainty
    low, high = found.coefficient - half, found.coefficient + half
    name = f"{found.run_id}, measured"
    return Curve(name, "measured", found.friction, found.coefficient, COEFFICIENT, found.run_id, lower=low, upper=high)


def friction_range(measured: Sequence[EffectiveCoefficient]) -> Column:
    """Return friction coefficients from slightly below to slightly above all measured values."""
    friction = np.concatenate([one.friction for one in measured])
    room = 0.08 * max(float(np.ptp(friction)), 0.02)
    return np.linspace(np.min(friction) - room, np.max(friction) + room, 100)


def law_curves(friction: Column, laws: Iterable[LawCoefficient]) -> Iterator[Curve]:
    """Draw effective k_D of the laws under which it depends only on friction."""
    for law, best, interval in laws:
        if law in BY_FRICTION:
            factor = junction_factor(friction) if law == "sarkar" else np.ones_like(friction)
            line, low, high = (quantity.value * factor for quantity in (best, *interval))
            yield Curve(law_title(law), "fit", friction, line, COEFFICIENT, "", law, low, high)

"""What a test that lasts longer would measure if the law held exactly: the problem that it would pose.

The same sensors, the same noise at the same sampling rate; post-test measurements of depths and widths as uncertain as
they are, volumes as uncertain relative to themselves.
"""

from dataclasses import replace

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.contacts.inputs import Input
from tribopipe.documents.quantity import Quantity
from tribopipe.evaluation.wear.joint import END_ANCHOR, Anchor, JointProblem
from tribopipe.evaluation.wear.measurement_problem import MeasurementProblem
from tribopipe.evaluation.wear.problem import WearProblem


def at_length(problem: WearProblem, coefficient: float, length: float) -> WearProblem:
    """Return the problem that a test ``length`` times as long would pose if the law held exactly.

    Raises ``ContactError`` where the tip would be worn away.
    """
    values = problem.values
    longer = replace(
        problem,
        distance=problem.distance * length,
        weights=problem.weights * length,
        trace=replace(problem.trace, slid=problem.trace.slid * length),
    )
    end = float(longer.depth(coefficient, values, np.asarray([longer.trace.slid]))[0])
    wear = problem.end.grown(end)
    share = 1 + (wear.disc.quantity.value / end if wear.disc is not None else 0.0)
    # Windows are a share of the distance: they hold as many more samples.
    scale, zero = values["depth_scale"], _better(problem.trace.zero_offset, length)
    curve = zero.value + longer.depth(coefficient, values, longer.distance) * share / scale
    last = _better(problem.trace.end_reading, length).model_copy(update={"value": zero.value + end * share / scale})
    trace = replace(
        longer.trace,
        reading=curve,
        zero_offset=zero,
        end_reading=last,
        unworn_end=zero.value,
        duration=problem.trace.duration * length,
    )
    inputs = dict(problem.inputs) | {END_ANCHOR: Input(wear.pin.quantity, problem.inputs[END_ANCHOR].source)}
    if wear.disc is not None:
        inputs["disc_end_value"] = Input(wear.disc.quantity, problem.inputs["disc_end_value"].source)
    if "end_reading" in inputs:
        inputs |= {"zero_offset": Input(zero, "fit"), "end_reading": Input(last, "fit")}
    longer = replace(longer, trace=trace, end=wear, inputs=inputs)
    if isinstance(longer, JointProblem):
        longer = replace(longer, anchors=(Anchor(END_ANCHOR, longer.trace.slid, wear),))
    return longer


def _better(reading: Quantity, length: float) -> Quantity:
    """Return a reading that is the mean of ``length`` times as many samples."""
    return reading.model_copy(update={"standard_uncertainty": (reading.standard_uncertainty or 0.0) / length**0.5})


def at_rotations(problem: MeasurementProblem, found: Column, length: float) -> MeasurementProblem:
    """Return the problem that a test of ``length`` times the rotations would pose if the law held exactly.

    Raises ``ContactError`` where the crown would be worn away.
    """
    longer = replace(
        problem,
        measurements=tuple(replace(one, rotations=one.rotations * length) for one in problem.measurements),
    )
    inputs = dict(problem.inputs)
    for one, value in zip(longer.measurements, longer.modelled(found, problem.values), strict=True):
        given = problem.inputs[one.name]
        scale = float(value) / one.quantity.value if one.what == "wear_volume" and one.quantity.value else 1.0
        quantity = Quantity(value=float(value), unit=one.quantity.unit, standard_uncertainty=given.spread * scale)
        inputs[one.name] = Input(quantity, given.source)
    return replace(longer, inputs=inputs)

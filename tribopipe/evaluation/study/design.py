"""Experimental design: what a longer test, replicates, or a better known input would do for k_D.

To first order (JCGM 100:2008, 5.1.2) on the run as it would be: the law with the k_D found, the same sensors, the same
absolute uncertainties of end values, and the same noise at the same sampling rate.
"""

import math
from collections.abc import Callable, Collection
from dataclasses import replace

import numpy as np

from tribopipe.base.errors import ContactError, FitError
from tribopipe.contacts.inputs import Input
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName
from tribopipe.evaluation.study.member import PosedRun
from tribopipe.evaluation.wear.budget import budget
from tribopipe.evaluation.wear.joint import END_ANCHOR, Anchor, JointProblem
from tribopipe.evaluation.wear.problem import WearProblem
from tribopipe.physics.laws import law_named
from tribopipe.results.evaluation import COVERAGE_FACTOR
from tribopipe.results.test_design import Design, Lever
from tribopipe.results.wear_fit import Contribution

_LENGTHS = np.geomspace(1.0, 100.0, 61)
"""Test lengths looked at, in lengths of the run."""


def design(
    run: PosedRun, law: LawName, wanted: float, shared: Collection[str] = (), scatter: float | None = None
) -> Design:
    """Say what it takes to know k_D to ``wanted``, the half width of its 95 % interval over k_D.

    ``shared`` inputs are off by the same error in all replicates; ``scatter`` is that of k_D between runs over k_D.
    """
    if not wanted > 0:
        raise FitError(f"plan: found a wanted interval of {wanted:g}; expected one above zero, such as '10 %'")
    lines = budget(run.problem.condensed(), run.coefficient)
    now = half_width(lines)
    common = {name.replace("_", " ") for name in (*shared, *law_named(law).inputs())}
    by_shared = half_width([line for line in lines if line.name in common])
    length, by_distance = _length(run, wanted)
    return Design(
        id=run.member.id,
        model=law,
        half_width=now,
        wanted=wanted,
        levers=tuple(
            lever.model_copy(update={"name": run.problem.contact.worded(lever.name)}) for lever in levers(lines)
        ),
        sliding_distance=None if length is None else Quantity(value=length * run.problem.trace.slid, unit="m"),
        by_distance=by_distance,
        replicates=replicates(now, by_shared, COVERAGE_FACTOR * (scatter or 0.0), wanted),
        by_replicates=by_shared,
        scatter=scatter,
    )


def half_width(lines: Collection[Contribution]) -> float:
    """Return the half width of the 95 % interval of k_D over k_D, by a budget."""
    return COVERAGE_FACTOR * math.hypot(*(line.relative for line in lines))


def levers(lines: Collection[Contribution]) -> list[Lever]:
    """Return what each line of a budget costs, the most rewarding first."""
    variance = sum(line.relative**2 for line in lines)
    return [
        Lever(
            name=line.name,
            value=line.value,
            shown_in=line.shown_in,
            relative=abs(line.relative),
            share=line.relative**2 / variance,
            if_halved=COVERAGE_FACTOR * math.sqrt(variance - 0.75 * line.relative**2),
        )
        for line in sorted(lines, key=lambda line: -abs(line.relative))
    ]


def _length(run: PosedRun, wanted: float) -> tuple[float | None, float]:
    return shortest(
        lambda length: half_width(budget(at_length(run.plain, run.coefficient, length), run.coefficient)), wanted
    )


def shortest(width_at: Callable[[float], float], wanted: float) -> tuple[float | None, float]:
    """Return the length of a test that does, in lengths of the run, and the least half width of any.

    ``width_at`` gives the half width; it raises ``ContactError`` where the specimen would be worn away.
    """
    best = math.inf
    before = (1.0, math.inf)
    for length in _LENGTHS.tolist():
        try:
            width = width_at(length)
        except ContactError:
            break
        best = min(best, width)
        if width <= wanted:
            return _between(before, (length, width), wanted), best
        before = (length, width)
    return None, best


def _between(before: tuple[float, float], after: tuple[float, float], wanted: float) -> float:
    """Return the length at which the half width is as wanted, by interpolation of logarithms."""
    (short, wide), (long, narrow) = before, after
    if not math.isfinite(wide):
        return long
    share = math.log(wide / wanted) / math.log(wide / narrow)
    return float(short * (long / short) ** share)


def replicates(now: float, shared: float, scatter: float, wanted: float) -> int | None:
    """Return how many tests like this one it takes; none where what they share is too much."""
    room = wanted**2 - shared**2
    if room <= 0:
        return None
    return max(1, math.ceil((now**2 - shared**2 + scatter**2) / room - 1e-9))


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

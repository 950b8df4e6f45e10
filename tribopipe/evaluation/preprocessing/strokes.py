"""Friction of reciprocating tests, stroke by stroke.

The friction force changes its sign at each turning point, where the speed passes through zero and the force through
whatever the contact does at rest. A stroke's coefficient is taken over its middle, by one of two methods:

- middle-of-stroke: the mean of |μ|;
- half-difference: half the difference of the means forth and back of one cycle, in which an offset of the sensor and
  a tilt of the specimen cancel.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.documents.preprocessing import StrokeMethod, StrokeWiseFriction
from tribopipe.evaluation.derived_columns import coefficient
from tribopipe.evaluation.preprocessing.workbench import Bench

_CLEARLY = 0.3
"""Share of the usual amplitude beyond which a direction counts, so that noise at a turning point makes no stroke."""
_REGULAR = 0.35
"""A stroke whose length differs from the median by more than this share of it is not whole."""
_BESIDE = 0.1
"""Share of the swing by which friction with a large offset stays off zero."""
_MOST_WHOLE = 0.8
_FEWEST_STROKES, _FEWEST_SAMPLES = 4, 5


class Stroke(NamedTuple):
    """One stroke: its first sample, the first one after it, and its direction."""

    start: int
    end: int
    direction: float

    @property
    def whole(self) -> slice:
        """All of its samples."""
        return slice(self.start, self.end)

    def middle(self, share: float) -> slice:
        """Return the samples of its middle part."""
        trimmed = round((self.end - self.start) * (1 - share) / 2)
        return slice(self.start + trimmed, max(self.end - trimmed, self.start + trimmed + 1))

    def center(self, count: int) -> slice:
        """Return so many samples in its middle."""
        first = (self.start + self.end - count) // 2
        return slice(first, first + count)


class Parts:
    """Samples of several strokes, or of their middles, one after the other: there may be thousands."""

    def __init__(self, parts: Sequence[slice]) -> None:
        self.count = len(parts)
        starts, ends = (np.array([getattr(part, edge) for part in parts], dtype=int) for edge in ("start", "stop"))
        self.part = np.repeat(np.arange(self.count), ends - starts)
        """Number of the part that a sample is in."""
        before = np.cumsum(ends - starts) - (ends - starts)
        self.sample = np.arange(len(self.part)) + (starts - before)[self.part]
        """Its place in the recording."""

    def means(self, values: Column) -> Column:
        """Return the mean of the finite values of each part; NaN where there is none."""
        seen = np.isfinite(values[self.sample])
        part, seen_values = self.part[seen], values[self.sample[seen]]
        counts = np.bincount(part, minlength=self.count)
        with np.errstate(invalid="ignore"):
            return np.asarray(np.bincount(part, seen_values, self.count) / counts)


def average_strokes(bench: Bench, step: StrokeWiseFriction) -> None:
    """Replace the friction coefficient by that of the stroke; nothing where friction does not go there and back."""
    if step.only_with_stroke and bench.manifest.conditions.stroke is None:
        return
    if "friction_coefficient" not in bench.columns:
        return
    mu = bench.columns["friction_coefficient"]
    forces = bench.measured("friction_force") is not None
    signed = coefficient(bench.columns, bench.manifest)[0] if forces else mu
    signed = np.where(np.isfinite(mu), signed, np.nan)
    whole = whole_strokes(signed, any_offset=step.method == "half-difference")
    if not whole:
        return
    averaged = np.full(len(mu), np.nan)
    # Each stroke counts alike: a drive may be slower forth than back, and with an offset both differ in friction.
    count = min(middle.stop - middle.start for middle in (stroke.middle(step.middle) for stroke in whole))
    for stroke, value in stroke_values(signed, whole, step.middle, step.method):
        averaged[stroke.center(count)] = value
    averaged[~np.isfinite(mu)] = np.nan
    if not np.array_equal(averaged, mu, equal_nan=True):
        what = (
            f"one value for each of {len(whole)} strokes, with {step.method} over the middle "
            f"{100 * step.middle:.0f} % of each"
        )
        bench.put("friction_coefficient", averaged, what, "reciprocating sliding", parts=len(whole))


def whole_strokes(signed: Column, *, any_offset: bool = False) -> list[Stroke]:
    """Return the whole strokes; an empty list if friction does not change its sign regularly, offset or not."""
    found = list(_strokes(signed, any_offset=any_offset))
    if len(found) < _FEWEST_STROKES:
        return []
    usual = float(np.median([stroke.end - stroke.start for stroke in found]))
    whole = [stroke for stroke in found if abs(stroke.end - stroke.start - usual) <= _REGULAR * usual]
    return whole if usual >= _FEWEST_SAMPLES and len(whole) >= _MOST_WHOLE * (len(found) - 2) else []


def _strokes(signed: Column, *, any_offset: bool) -> Iterator[Stroke]:
    seen = signed[np.isfinite(signed)]
    if not any_offset and not np.min(seen, initial=0.0) < 0 < np.max(seen, initial=0.0):
        return
    low, high = np.percentile(seen, [25, 75]) if len(seen) else (0.0, 0.0)
    if not low < 0 < high and not (any_offset and _beside_zero(seen, high - low)):
        return
    centred, clear = signed - (low + high) / 2, _CLEARLY * (high - low) / 2
    with np.errstate(invalid="ignore"):
        sure = np.flatnonzero(np.abs(centred) > clear)
    directions = np.sign(centred[sure])
    turns = np.flatnonzero(directions[1:] != directions[:-1])
    bounds = [0, *((sure[turns] + sure[turns + 1] + 1) // 2).tolist(), len(signed)]
    for number, first in enumerate([0, *(turns + 1).tolist()]):
        yield Stroke(bounds[number], bounds[number + 1], float(directions[first]))


def _beside_zero(seen: Column, swing: float) -> bool:
    """Return whether friction swings next to zero without touching it, as a magnitude does at each turn."""
    return bool(swing > 0 and np.percentile(np.abs(seen), 1) > _BESIDE * swing)


def stroke_values(
    signed: Column, strokes: list[Stroke], share: float, method: StrokeMethod
) -> Iterator[tuple[Stroke, float]]:
    """Yield the coefficient of each stroke; of two that follow each other the same one by half-difference."""
    parts = Parts([stroke.middle(share) for stroke in strokes])
    means = parts.means(np.abs(signed) if method == "middle-of-stroke" else signed).tolist()
    if method == "middle-of-stroke":
        yield from zip(strokes, means, strict=True)
        return
    number = 0
    while number + 1 < len(strokes):
        forth, back = strokes[number : number + 2]
        if forth.end != back.start:
            number += 1
            continue
        value = abs(means[number] - means[number + 1]) / 2
        yield from ((forth, value), (back, value))
        number += 2

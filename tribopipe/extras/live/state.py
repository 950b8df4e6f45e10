"""State of a running test: sums over equally many samples, in an array whose size does not grow.

Where the array is full, sums are added in pairs, so that each is over twice as many samples as before. However the
samples came in pieces, the same ones stand in the same sum.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.documents.signals import SignalName

_MOST_SUMS = 4096
_FIELDS = ("samples", "time", "sliding_distance", "root", "depth", "friction", "with_friction", "load", "with_load")
_BESIDE: tuple[SignalName, ...] = ("friction_coefficient", "normal_force")
_PLACED: tuple[SignalName, ...] = ("time", "sliding_distance", "depth")
_AVERAGED = ("time", "sliding_distance", "root", "depth")


@dataclass(frozen=True)
class Means:
    """Means over stretches of samples; friction and load are NaN where a stretch has none."""

    samples: Column
    time: Column
    """s"""
    sliding_distance: Column
    """m"""
    root: Column
    """Square root of the sliding distance, m^0.5; the depth on a sphere grows about in proportion."""
    depth: Column
    """Depth signal, m."""
    friction: Column
    """Its magnitude, a ratio."""
    load: Column
    """Magnitude of the normal force, N."""

    def __len__(self) -> int:
        return len(self.samples)

    def __getitem__(self, part: slice) -> "Means":
        return Means(**{name: values[part] for name, values in vars(self).items()})


class State:
    """The samples so far, condensed; those that do not have time, sliding distance or depth are passed over."""

    def __init__(self) -> None:
        self._sums = np.zeros((_MOST_SUMS, len(_FIELDS)))
        self._behind_each = 1
        self.samples = 0
        """Number of samples so far."""

    def add(self, columns: Mapping[SignalName, Column]) -> None:
        """Add samples in the order of the test, in SI."""
        whole = np.logical_and.reduce([np.isfinite(columns[name]) for name in _PLACED])
        rows = _rows({name: values[whole] for name, values in columns.items()})
        while self.samples + len(rows) > _MOST_SUMS * self._behind_each:
            self._merge()
        places = (self.samples + np.arange(len(rows))) // self._behind_each
        if len(rows):
            first = np.flatnonzero(np.diff(places, prepend=-1))
            self._sums[places[first]] += np.add.reduceat(rows, first, axis=0)
        self.samples += len(rows)

    def _merge(self) -> None:
        half = _MOST_SUMS // 2
        self._sums[:half] = self._sums.reshape(half, 2, -1).sum(axis=1)
        self._sums[half:] = 0.0
        self._behind_each *= 2

    @property
    def means(self) -> Means:
        """The finest means there are, each over as many samples but for the last."""
        return _means(self._sums[: -(-self.samples // self._behind_each)])

    def pooled(self, stretches: Column) -> Means:
        """Return means over stretches, numbered upwards, of ``means``."""
        first = np.flatnonzero(np.diff(stretches, prepend=np.nan))
        return _means(np.add.reduceat(self._sums[: len(stretches)], first, axis=0))


def _rows(columns: Mapping[SignalName, Column]) -> Column:
    distance = columns["sliding_distance"]
    rows = [np.ones_like(distance), columns["time"], distance, np.sqrt(np.maximum(distance, 0.0)), columns["depth"]]
    for name in _BESIDE:
        values = np.abs(columns.get(name, np.full_like(distance, np.nan)))  # there and back alike
        seen = np.isfinite(values)
        rows += [np.where(seen, values, 0.0), seen.astype(float)]
    return np.column_stack(rows)


def _means(sums: Column) -> Means:
    of = dict(zip(_FIELDS, sums.T, strict=True))
    with np.errstate(invalid="ignore"):
        beside = {name: of[name] / of[f"with_{name}"] for name in ("friction", "load")}
    return Means(samples=of["samples"], **{name: of[name] / of["samples"] for name in _AVERAGED}, **beside)

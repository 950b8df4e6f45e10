"""Check of running-in that repeats within a recording, as where a second test was recorded in the same file."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.documents.signals import SignalName
from tribopipe.evaluation.checks.registry import Trouble, check
from tribopipe.physics.axis_faults import segments
from tribopipe.results.run import RawRun

_PARTS, _FEWEST = 20, 100
"""Parts of a piece whose medians are compared, and least size of a piece."""
_OFF, _PAUSE = 0.05, 3
"""Share of the usual friction below which it is off, and samples for which it is if the bodies are apart."""
_CHANGE = 0.05
"""Change of friction in running-in, as a share of it, from which on it shows."""
_START = slice(1, 4)
"""Parts that show the start: a peak in the first one comes from any stop."""
_ALIKE = 0.8
"""Correlation of two runnings-in from which on one is the other once more."""


@check("warning")
def running_in_repeats(run: RawRun) -> Iterator[Trouble]:
    """Find friction that, after a restart or a pause, begins as it began at the start, and not as it ended before."""
    name: SignalName = "friction_coefficient" if "friction_coefficient" in run.columns else "friction_force"
    if name not in run.columns or run.manifest.interruptions:
        return
    mu = np.abs(run.columns[name])
    pauses = _pauses(mu) if run.manifest.conditions.stroke is None else []
    starts = sorted({*segments(run.columns["time"]).starts, *(pause.stop for pause in pauses if pause.start)})
    for pause in pauses:
        mu[pause] = np.nan
    pieces = [
        (start, piece[np.isfinite(piece)]) for start, piece in zip([0, *starts], np.split(mu, starts), strict=True)
    ]
    long = [(start, piece) for start, piece in pieces if len(piece) >= _FEWEST]
    repeated = [start for (_, before), (start, after) in pairwise(long) if _runs_in_again(long[0][1], before, after)]
    if repeated:
        yield Trouble(
            name,
            f"found a second running-in starting at {run.numbered(repeated[0])}; expected the recording of one test",
            "create one run per test, with steps = [n] under [[signals]] or from one file per test; if the specimens "
            "were only removed and remounted, enter this under [[interruptions]]",
        )


def _pauses(mu: Column) -> list[slice]:
    """Return the samples in which friction is off for a while, and then on again."""
    off = mu < _OFF * np.nanmedian(mu) if np.any(np.isfinite(mu)) else np.zeros(len(mu), dtype=bool)
    edges = np.flatnonzero(np.diff([False, *off, False]))
    return [slice(a, b) for a, b in edges.reshape(-1, 2).tolist() if b - a >= _PAUSE and b < len(mu)]


def _runs_in_again(first: Column, before: Column, after: Column) -> bool:
    """Return whether friction takes the course once more that it took at first, from there and not from the end."""
    count = min(len(first), len(after))
    one, other = _course(first[:count]), _course(after[:count])
    start, again, end = (float(np.mean(part)) for part in (one[_START], other[_START], _course(before)[-3:]))
    back = abs(again - start) < abs(again - end) and abs(end - start) > _CHANGE * end
    with np.errstate(invalid="ignore", divide="ignore"):  # of a constant
        return back and float(np.corrcoef(one[1:], other[1:])[0, 1]) > _ALIKE


def _course(mu: Column) -> Column:
    """Return the median of each part."""
    return np.array([np.median(part) for part in np.array_split(mu, _PARTS)])

"""Check of running-in that repeats within a recording, as where a second test was recorded in the same file."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.documents.signals import SignalName
from tribopipe.evaluation.checks.registry import Trouble, check
from tribopipe.physics.axis_faults import segments
from tribopipe.results.run import RawRun

_PARTS, _FEWEST = 20, 5
"""Parts of the shorter piece, by the size of which its start and the end before it are compared, and least size."""
_OFF, _PAUSE = 0.05, 3
"""Share of the usual friction below which it is off, and samples for which it is if the bodies are apart."""
_CHANGE, _CLEARLY = 0.1, 3.0
"""Change of friction in running-in, as a share of it and in standard deviations of noise, from which on it shows."""
_ALIKE = 0.5
"""Share of that change within which friction is back at its start."""


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
    long = [(start, piece) for start, piece in pieces if len(piece) >= 2 * _FEWEST]
    repeated = [start for (_, before), (start, after) in pairwise(long) if _runs_in_again(long[0][1], before, after)]
    if repeated:
        yield Trouble(
            name,
            f"found running-in once more from {run.numbered(repeated[0])} on; expected the recording of one test",
            "create one run per test, with steps = [n] under [[signals]] or from one file per test; if the specimens "
            "were only removed and mounted again, state it under [[interruptions]]",
        )


def _pauses(mu: Column) -> list[slice]:
    """Return the samples in which friction is off for a while, and then on again."""
    off = mu < _OFF * np.nanmedian(mu) if np.any(np.isfinite(mu)) else np.zeros(len(mu), dtype=bool)
    edges = np.flatnonzero(np.diff([False, *off, False]))
    return [slice(a, b) for a, b in edges.reshape(-1, 2).tolist() if b - a >= _PAUSE and b < len(mu)]


def _runs_in_again(first: Column, before: Column, after: Column) -> bool:
    """Return whether friction is again as it was at first, after it had run in."""
    size = max(_FEWEST, min(len(before), len(after)) // _PARTS)
    start, end, again = (float(np.median(part)) for part in (first[:size], before[-size:], after[:size]))
    noise = float(np.std(before[-size:]))
    change = abs(end - start)
    return change > max(_CHANGE * end, _CLEARLY * noise) and abs(again - start) < _ALIKE * change

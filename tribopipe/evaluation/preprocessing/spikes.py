"""Lone samples far off their neighbors (F. R. Hampel, Journal of the American Statistical Association 69 (1974) 383).

A sample is a spike where it differs from the running median by more than some standard deviations. The standard
deviation is 1.4826 times the median absolute deviation from that median: of the neighbors, but no less than of the
whole record, nor than the finest step that the record shows.
"""

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.documents.preprocessing import Despike
from tribopipe.evaluation.preprocessing.workbench import Bench, Selection

_TO_DEVIATION = 1.4826


def mask_spikes(bench: Bench, step: Despike) -> None:
    """Mask the spikes of measured signals."""
    for name in step.signals:
        values = bench.measured(name)
        if values is not None:
            what = f"more than {step.threshold:g} standard deviations from the median of {step.window} samples"
            bench.mask(name, spikes(values, step.window, step.threshold), what, "a spike")


def spikes(values: Column, window: int, threshold: float) -> Selection:
    """Find the spikes of a signal; missing samples are passed over."""
    from scipy.ndimage import median_filter

    seen = np.isfinite(values)
    known = values[seen]
    found = np.zeros(len(values), dtype=bool)
    if len(known) <= window:
        return found
    off = np.abs(known - median_filter(known, size=window, mode="reflect"))
    local = _TO_DEVIATION * median_filter(off, size=window, mode="reflect")
    steps = np.abs(np.diff(known))
    finest = float(np.min(steps[steps > 0], initial=np.inf))
    least = max(_TO_DEVIATION * float(np.median(off)), finest if np.isfinite(finest) else 0.0)
    found[seen] = off > threshold * np.maximum(local, least)
    return found

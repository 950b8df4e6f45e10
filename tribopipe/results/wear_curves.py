"""Wear of a run by a law at each of its samples, fitted or predicted, whatever its contact."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from tribopipe.base.arrays import Column
from tribopipe.results.wear_fit import WearFit
from tribopipe.results.wear_prediction import WearPrediction


@dataclass(frozen=True)
class Band:
    """A value at each sample, and its 95 % band."""

    best: Column
    lower: Column
    upper: Column
    unit: str = field(kw_only=True)
    """SI."""


@dataclass(frozen=True)
class WearCurves:
    """Wear and contact along a run by a law."""

    result: WearFit | WearPrediction
    bands: Mapping[str, Band]
    """By what they are of: ``wear_depth`` of a pin, ``depth``, ``curved_volume`` and so on of two discs."""

"""Wear of one body of a run by measurement and by the law of a study, along the run."""

from dataclasses import dataclass
from typing import Literal

from tribopipe.base.arrays import Column
from tribopipe.documents.recipe import LawName
from tribopipe.documents.signals import SignalName
from tribopipe.results.agreement import Role, StudyResult

CurveQuantity = Literal["wear_depth", "wear_volume"]


@dataclass(frozen=True)
class MeasuredCurve:
    """Wear as measured at the places of a curve, with its 95 % band."""

    best: Column
    lower: Column
    upper: Column


@dataclass(frozen=True)
class StudyCurve:
    """Wear of one body by a law along one run, with its 95 % band."""

    run_id: str
    model: LawName
    role: Role
    body: str
    what: CurveQuantity
    """Depth, m, or volume, m³."""
    along: SignalName
    """What the places are counted in."""
    places: Column
    predicted: Column
    lower: Column
    upper: Column
    measured: MeasuredCurve | None = None
    """None where wear was not recorded along the run."""


@dataclass(frozen=True)
class Evaluation:
    """A study's result and the curves behind it."""

    result: StudyResult
    curves: tuple[StudyCurve, ...]

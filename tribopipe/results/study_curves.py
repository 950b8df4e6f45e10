"""Wear of one run by measurement and by the law of a study, along the run."""

from dataclasses import dataclass

from tribopipe.base.arrays import Column
from tribopipe.documents.contact import DiscName
from tribopipe.documents.recipe import LawName
from tribopipe.results.agreement import Role


@dataclass(frozen=True)
class StudyCurve:
    """Wear of one run's pin by measurement and by a law along the run, m, with 95 % bands."""

    run_id: str
    model: LawName
    role: Role
    sliding_distance: Column
    measured: Column
    predicted: Column
    lower: Column
    upper: Column
    """Band of the law."""
    measurement_lower: Column
    measurement_upper: Column
    """Band of measurements."""


@dataclass(frozen=True)
class DiscStudyCurve:
    """Volume worn off one disc by a law along one run, m³, against rotations, with its 95 % band."""

    run_id: str
    model: LawName
    role: Role
    disc: DiscName
    rotations: Column
    predicted: Column
    lower: Column
    upper: Column

"""The steps of processing as the archive knows them: their names, results, and what each stands on."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache, reduce
from operator import or_
from typing import Literal, NamedTuple

from pydantic import TypeAdapter

from tribopipe.archive.digest import Part, digest
from tribopipe.records.base import Record
from tribopipe.records.clean_up import CleanUp
from tribopipe.records.disc_results import TwinDiscFit, TwinDiscPrediction
from tribopipe.records.local_wear import LocalWearResult
from tribopipe.records.recipe import LawName
from tribopipe.records.results import DriftCorrection, FrictionFit, WearFit, WearPrediction
from tribopipe.records.specific_wear import SpecificWear
from tribopipe.run import Column

StepName = Literal[
    "clean_up",
    "drift_correction",
    "friction_fit",
    "specific_wear",
    "wear_fit_archard",
    "wear_fit_sarkar",
    "prediction_archard",
    "prediction_sarkar",
    "local_wear_archard",
    "local_wear_sarkar",
]


class StepKind(NamedTuple):
    """What a step returns, by tribometer, and the steps of the same run it stands on."""

    records: tuple[type[Record], ...]
    stands_on: tuple[StepName, ...]

    def parse(self, text: str) -> Record:
        """Read a result back from its JSON; the records of different tribometers have different keys."""
        return _parser(self.records).validate_json(text)


@cache
def _parser(records: tuple[type[Record], ...]) -> TypeAdapter[Record]:
    return TypeAdapter(reduce(or_, records))


_FITS, _PREDICTIONS = (WearFit, TwinDiscFit), (WearPrediction, TwinDiscPrediction)
STEPS: dict[StepName, StepKind] = {
    "clean_up": StepKind((CleanUp,), ()),
    "drift_correction": StepKind((DriftCorrection,), ("clean_up",)),
    "friction_fit": StepKind((FrictionFit,), ("clean_up",)),
    "specific_wear": StepKind((SpecificWear,), ("clean_up",)),
    "wear_fit_archard": StepKind(_FITS, ("clean_up", "drift_correction")),
    "wear_fit_sarkar": StepKind(_FITS, ("clean_up", "drift_correction", "friction_fit")),
    "prediction_archard": StepKind(_PREDICTIONS, ("clean_up",)),
    "prediction_sarkar": StepKind(_PREDICTIONS, ("clean_up", "friction_fit")),
    "local_wear_archard": StepKind((LocalWearResult,), ("clean_up", "wear_fit_archard")),
    "local_wear_sarkar": StepKind((LocalWearResult,), ("clean_up", "friction_fit", "wear_fit_sarkar")),
}

WEAR_FITS: dict[LawName, StepName] = {"archard": "wear_fit_archard", "sarkar": "wear_fit_sarkar"}
PREDICTIONS: dict[LawName, StepName] = {"archard": "prediction_archard", "sarkar": "prediction_sarkar"}
LOCAL_WEAR: dict[LawName, StepName] = {"archard": "local_wear_archard", "sarkar": "local_wear_sarkar"}


class Fingerprints(NamedTuple):
    """What a step was made from, and what it found, each as one SHA-256."""

    inputs: str
    result: str


class Table(NamedTuple):
    """Arrays over axes of their own rather than the samples of a run, each with its SI unit."""

    axes: Mapping[str, tuple[Column, str]]
    """One for each dimension of the arrays, in their order."""
    arrays: Mapping[str, tuple[Column, str]]


@dataclass(frozen=True)
class Step:
    """One step of one run: its result, its curves and tables, and the fingerprint of all it was made from."""

    name: StepName
    result: Record
    inputs_sha256: str
    """Fingerprint of version, options, and all this one stands on: see ``inputs_digest``."""
    options: Mapping[str, object]
    """What the step was told, as JSON types."""
    program_version: str
    date: str
    """When it was done, ISO 8601."""
    curves: Mapping[str, tuple[Column, str]] = field(default_factory=dict)
    """Arrays over the samples of the run, with their SI unit."""
    tables: Mapping[str, Table] = field(default_factory=dict)
    """Arrays over other axes."""
    stands_on: Mapping[str, str] = field(default_factory=dict)
    """What it was made from, each with its SHA-256: "raw", the steps before it, empty where the run lacked one, and
    what was told besides, such as "wear_coefficient". Nothing where the file does not say."""
    environment: Mapping[str, str] = field(default_factory=dict)
    """What it was computed with, as ``tribopipe.environment`` tells it. Nothing where the file does not say."""

    @property
    def result_sha256(self) -> str:
        """Fingerprint of what the step found."""
        return digest(self.result, *self.arrays)

    @property
    def arrays(self) -> list[Part]:
        """What a fingerprint of the step tells beside its result: curves and tables by name, with unit and values."""
        kept = [self.curves, *(arrays for table in self.tables.values() for arrays in table)]
        return [part for arrays in kept for name, (values, unit) in arrays.items() for part in (name, unit, values)]


def inputs_digest(version: str, name: StepName, options: Mapping[str, object], stands_on: Mapping[str, str]) -> str:
    """Return the fingerprint of all that a step is made from; ``stands_on`` in its order."""
    return digest(version, name, options, *stands_on.values())


def downstream(name: StepName) -> set[StepName]:
    """Return every step that stands on this one, directly or not."""
    direct = {other for other, kind in STEPS.items() if name in kind.stands_on}
    return direct.union(*(downstream(other) for other in direct))

"""The steps of processing as the archive knows them: their names, results, and what each stands on."""

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache, reduce
from operator import or_
from typing import Literal, NamedTuple, TypeAlias

from pydantic import TypeAdapter

from tribopipe.archive.provenance import Part, digest
from tribopipe.base.arrays import Column
from tribopipe.documents.preprocessing import CleanUp
from tribopipe.documents.recipe import LawName, WearRecipe
from tribopipe.documents.record import Record
from tribopipe.physics.laws import LAWS
from tribopipe.results.evaluation import DriftCorrection, FrictionFit
from tribopipe.results.local_wear import LocalWearResult
from tribopipe.results.specific_wear import SpecificWear
from tribopipe.results.wear_fit import WearFit
from tribopipe.results.wear_prediction import WearPrediction

StepName: TypeAlias = str
"""Such as "drift_correction" or "wear_fit_archard": steps under a wear law end in its name."""


StepStage = Literal[
    "clean_up", "drift_correction", "friction_fit", "specific_wear", "wear_fit", "prediction", "local_wear", "study"
]
"""A step under any wear law, or a study."""
METHODS: dict[StepStage, int] = {
    "clean_up": 5,
    "drift_correction": 13,
    "friction_fit": 9,
    "specific_wear": 10,
    "wear_fit": 17,
    "prediction": 11,
    "local_wear": 1,
    "study": 15,
}
"""Number of the method of each step, under any law. Raise it by one where a change gives other numbers from the same
inputs: archived steps are then done again, and `process` shows the earlier and the new values."""


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


_PLAIN: dict[StepName, StepKind] = {
    "clean_up": StepKind((CleanUp,), ()),
    "drift_correction": StepKind((DriftCorrection,), ("clean_up",)),
    "friction_fit": StepKind((FrictionFit,), ("clean_up",)),
    "specific_wear": StepKind((SpecificWear,), ("clean_up", "drift_correction")),
}


class StepsByLaw(Mapping[LawName, StepName]):
    """The name of a step under each wear law: of those installed when gone through, of any other when asked for."""

    def __init__(self, name: str) -> None:
        self._begins = f"{name}_"

    def __getitem__(self, law: LawName) -> StepName:
        return self._begins + law

    def __iter__(self) -> Iterator[LawName]:
        return iter(LAWS)

    def __len__(self) -> int:
        return len(LAWS)

    def law_of(self, step: StepName) -> LawName | None:
        """Return the law that a step is under; none where it is another step."""
        return step.removeprefix(self._begins) if step.startswith(self._begins) else None


WEAR_FITS, PREDICTIONS, LOCAL_WEAR = StepsByLaw("wear_fit"), StepsByLaw("prediction"), StepsByLaw("local_wear")


def _fit_kind(law: LawName) -> StepKind:
    return StepKind((WearFit,), ("clean_up", "drift_correction", *_friction(law)))


def _prediction_kind(law: LawName) -> StepKind:
    return StepKind((WearPrediction,), ("clean_up", *_friction(law)))


def _local_wear_kind(law: LawName) -> StepKind:
    return StepKind((LocalWearResult,), ("clean_up", *_friction(law), WEAR_FITS[law]))


def _friction(law: LawName) -> tuple[StepName, ...]:
    """Return the friction fit where a law needs friction, as one that is not installed here may."""
    return ("friction_fit",) if law not in LAWS or LAWS[law].needs_friction else ()


_UNDER_LAWS = ((WEAR_FITS, _fit_kind), (PREDICTIONS, _prediction_kind), (LOCAL_WEAR, _local_wear_kind))


class _Steps(Mapping[StepName, StepKind]):
    """Every step: those under the laws of the default recipe before those under others, so that their numbers stay."""

    def __getitem__(self, name: StepName) -> StepKind:
        if name in _PLAIN:
            return _PLAIN[name]
        for steps, kind in _UNDER_LAWS:
            if (law := steps.law_of(name)) is not None:
                return kind(law)
        raise KeyError(name)

    def __iter__(self) -> Iterator[StepName]:
        yield from _PLAIN
        usual = WearRecipe().models
        for laws in (usual, [law for law in LAWS if law not in usual]):
            yield from (steps[law] for steps, _ in _UNDER_LAWS for law in laws)

    def __len__(self) -> int:
        return len(_PLAIN) + len(_UNDER_LAWS) * len(LAWS)


STEPS = _Steps()


def step_in_words(name: str) -> str:
    """Return a step or stage in words: "preprocessing" for ``clean_up``."""
    return "preprocessing" if name == "clean_up" else name.replace("_", " ")


def stage_of(name: StepName) -> StepStage:
    """Return a step without its wear law: "wear_fit" for ``wear_fit_archard``."""
    return next(stage for stage in METHODS if name == stage or name.startswith(f"{stage}_"))


def method_number(name: StepName) -> int:
    """Return the current method number of a step."""
    return METHODS[stage_of(name)]


def steps_among(names: Iterable[str]) -> list[StepName]:
    """Return the names that are steps, in order; steps under laws that are not installed come last."""
    there = {name for name in names if name in STEPS}
    known = [name for name in STEPS if name in there]
    return [*known, *sorted(there.difference(known))]


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
class StepBase:
    """What ``Step`` and ``StepOutline`` have in common: the result of one step of one run, and its origin."""

    name: StepName
    result: Record
    inputs_sha256: str
    """Fingerprint of version, options, and all this one stands on: see ``inputs_digest``."""
    options: Mapping[str, object]
    """Options of the step, as JSON types."""
    program_version: str
    date: str
    """Date of the computation, ISO 8601."""
    environment: Mapping[str, str] = field(default_factory=dict, kw_only=True)
    """Versions and machine, from ``tribopipe.archive.provenance``; empty if the file does not state them."""


@dataclass(frozen=True)
class StepOutline(StepBase):
    """One step of one run without its curves and tables."""

    result_sha256: str = field(kw_only=True)
    """Fingerprint of what the step found, as its file states it."""


@dataclass(frozen=True)
class Step(StepBase):
    """One step of one run: its result, its curves and tables, and the fingerprint of all it was made from."""

    curves: Mapping[str, tuple[Column, str]] = field(default_factory=dict)
    """Arrays over the samples of the run, with their SI unit."""
    tables: Mapping[str, Table] = field(default_factory=dict)
    """Arrays over other axes."""
    stands_on: Mapping[str, str] = field(default_factory=dict)
    """What it was made from, each with its SHA-256: "raw", the steps before it, empty where the run did not have one,
    and what was given in addition, such as "wear_coefficient". Nothing where the file does not state it."""

    @property
    def result_sha256(self) -> str:
        """Fingerprint of what the step found, computed from its result, curves and tables."""
        return digest(self.result, *self.arrays)

    @property
    def arrays(self) -> list[Part]:
        """What a fingerprint of the step shows with its result: curves and tables by name, with unit and values."""
        kept = [self.curves, *(arrays for table in self.tables.values() for arrays in table)]
        return [part for arrays in kept for name, (values, unit) in arrays.items() for part in (name, unit, values)]


def inputs_digest(version: str, name: StepName, options: Mapping[str, object], stands_on: Mapping[str, str]) -> str:
    """Return the fingerprint of all that a step is made from; ``stands_on`` in its order."""
    return digest(version, name, options, *stands_on.values())


def downstream(name: StepName, among: Collection[StepName] = STEPS) -> set[StepName]:
    """Return every step among some that stands on this one, directly or not."""
    direct = {other for other in among if name in STEPS[other].stands_on}
    return direct.union(*(downstream(other, among) for other in direct))

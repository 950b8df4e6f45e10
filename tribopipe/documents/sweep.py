"""sweep.toml: one computation done many times over, with other values of a document's keys."""

from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal, Self, TypeAlias

from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from tribopipe.documents.manifest import RunId
from tribopipe.documents.quantity import Length, Percentage, WearCoefficient
from tribopipe.documents.record import Record
from tribopipe.documents.toml import shortened, written_key


class Choices(Record):
    """k_D of archived runs for all combinations; ``recipe`` and ``law`` can be varied. The archive is not changed."""

    runs: tuple[RunId, ...] = ()
    """Archived runs; default: all."""


class Predictions(Record):
    """Wear of one run under other conditions.

    You can vary ``run`` (keys of its run.toml), ``wear_coefficient``, ``flat_wear_coefficient``, ``recipe`` and
    ``law``.
    """

    run: RunId | None = None
    """Archived run whose wear is predicted."""
    folder: str | None = None
    """Run folder to use instead, next to this document."""
    wear_coefficient: WearCoefficient | None = None
    """k_D of the pin, or of the crowned disc; default: from the archived fit with this law."""
    flat_wear_coefficient: WearCoefficient | None = None
    """k_D of the cylindrical disc; default: no wear of this disc."""
    at: tuple[str, ...] = ()
    """Sliding distances at which to predict wear, such as "500 m", or numbers of rotations for discs, such as "1e6";
    default: the end of the run."""
    depth: tuple[Length, ...] = ()
    """Wear depths of the pin or crowned disc for which to calculate the distance or rotations, that is, the life."""

    @model_validator(mode="after")
    def _one_run(self) -> Self:
        if (self.run is None) == (self.folder is None):
            found = "neither run nor folder" if self.run is None else "both run and folder"
            raise ValueError(f"found {found}; expected one of the two; specify an archived run or a run folder")
        if self.folder is not None and self.wear_coefficient is None:
            raise ValueError(
                "wear_coefficient: missing; expected a wear coefficient, since a run folder contains none; add this "
                "key, such as "
                'wear_coefficient = "13.5e-9 mm^3/(N*mm)"'
            )
        return self


class VirtualTests(Record):
    """Tests simulated and evaluated; you can vary ``series``, ``run``, ``recipe`` and ``law``.

    For each test, new errors are drawn for the uncertain quantities of the plan.
    """

    plan: str
    """Plan file, next to this document."""
    runs: tuple[RunId, ...] = ()
    """Runs of the plan that are repeated; default: all."""
    within: Percentage | None = None
    """Largest deviation from the true k_D; the tests with a smaller deviation are counted."""


class Uniform(Record):
    """A value drawn from a uniform distribution."""

    uniform: tuple[Any, Any]
    """Lowest and highest value."""


class Normal(Record):
    """A value drawn from a normal distribution."""

    normal: Any
    """Mean."""
    standard_uncertainty: Any
    """Standard deviation, or a percentage of the mean such as "2 %"."""


Drawn = Uniform | Normal
Values: TypeAlias = Drawn | tuple[Any, ...]
"""Values of a varied key: a list, or a distribution."""


def _by_path(written: Any) -> Any:
    """Turn nested tables into paths: {"recipe": {"drift": {"window": […]}}} into {"recipe.drift.window": […]}."""
    return dict(_leaves("", written)) if isinstance(written, Mapping) else written


def _leaves(path: str, written: Any) -> Iterator[tuple[str, Any]]:
    if isinstance(written, Mapping) and not {"uniform", "normal"} & set(written):
        for key, inner in written.items():
            yield from _leaves(f"{path}.{key}" if path else key, inner)
    elif isinstance(written, Mapping):
        yield path, _read_drawn(path, written)
    else:
        yield path, _read_listed(path, written)


def _read_drawn(path: str, written: Mapping[str, Any]) -> Drawn:
    known = {"uniform"} if "uniform" in written else {"normal", "standard_uncertainty"}
    if set(written) != known:
        raise ValueError(
            f"{path}: found a table with {', '.join(map(written_key, written))}; expected "
            f"{{ uniform = [minimum, maximum] }} or {{ normal = mean, standard_uncertainty = deviation }}; correct the "
            "table"
        )
    if "normal" in written:
        return Normal.model_validate(written)
    ends = written["uniform"]
    if not isinstance(ends, list | tuple) or len(ends) != len(("least", "greatest")):
        raise ValueError(f"{path}: found uniform = {shortened(repr(ends))}; expected [minimum, maximum]; enter both")
    return Uniform.model_validate(written)


def _read_listed(path: str, written: Any) -> tuple[Any, ...]:
    if not isinstance(written, list | tuple) or not written:
        raise ValueError(
            f"{path}: found {shortened(repr(written))}; expected a list of values, or a distribution such as "
            '{ uniform = ["180 mN", "220 mN"] }; put the value in brackets'
        )
    twice = [one for one, count in Counter(map(repr, written)).items() if count > 1]
    if twice:
        raise ValueError(f"{path}: found {shortened(twice[0])} twice; expected each value once; remove one of the two")
    return tuple(written)


_VARIED = {"type": "object", "additionalProperties": {"anyOf": [{"type": "object"}, {"type": "array", "minItems": 1}]}}
Vary = Annotated[dict[str, Any], BeforeValidator(_by_path), WithJsonSchema(_VARIED)]


class Sweep(Record):
    """Evaluation choices, predictions or virtual tests for every combination of the varied values."""

    schema_version: Literal["tribopipe.sweep/1"] = Field(default="tribopipe.sweep/1", alias="schema")
    """Version of this document."""
    title: str | None = None
    """Title of the sweep, one line."""
    choices: Choices | None = None
    """Sensitivity of k_D to choices of evaluation."""
    predictions: Predictions | None = None
    """Dependence of wear and life on conditions."""
    virtual_tests: VirtualTests | None = None
    """Accuracy of k_D from virtual tests, and coverage of its intervals."""
    vary: Vary = Field(default_factory=dict)
    """Keys of other documents, with a list of values or a distribution in place of a value."""
    repeats: int | None = Field(default=None, ge=1)
    """Number of repeats of each combination, each with new random values or as a new virtual test."""
    seed: int = Field(default=1, ge=0)
    """Seed of the random numbers."""

    @property
    def needs_archive(self) -> bool:
        """Whether it is of archived runs."""
        return self.choices is not None or (self.predictions is not None and self.predictions.run is not None)

    @property
    def draws(self) -> bool:
        """Whether chance has a part in it."""
        return self.virtual_tests is not None or any(isinstance(one, Drawn) for one in self.vary.values())

    @model_validator(mode="after")
    def _is_of_one_kind(self) -> Self:
        kinds = ("choices", "predictions", "virtual_tests")
        found = [kind for kind in kinds if getattr(self, kind) is not None]
        if len(found) != 1:
            raise ValueError(
                f"found {' and '.join(found) or 'none'} of {', '.join(kinds)}; expected one of these tables, which "
                "defines the task; " + ("remove the others" if found else "add one")
            )
        return self

    @model_validator(mode="after")
    def _repeats_what_is_drawn(self) -> Self:
        if self.draws and self.repeats is None:
            raise ValueError(
                "repeats: missing; expected the number of repeats of each combination, since values are random; add "
                "this key, such as repeats = 100"
            )
        if not self.draws and self.repeats is not None:
            raise ValueError(
                f"repeats: found {self.repeats}, although no value is random and all repeats would be identical; "
                "expected no repeats; remove repeats, or specify a distribution"
            )
        return self

"""The documents that a sweep changes keys of, and the values that it gives them."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Generic, TypeAlias, TypeVar

import numpy as np
from numpy.random import PCG64, Generator, SeedSequence

from tribopipe.base.errors import ManifestError
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.record import Record, read_document
from tribopipe.documents.sweep import Drawn, Normal, Values

R = TypeVar("R", bound=Record)
Cell: TypeAlias = str | float
"""Cell of a table: a text, or a number in SI units."""
Settings: TypeAlias = Mapping[str, Any]
"""Values of keys by their paths, as JSON types."""


@dataclass(frozen=True)
class Subject(Generic[R]):
    """Documents put together as one record, of which some keys are given other values."""

    record: type[R]
    base: Mapping[str, Any]
    """The documents as they are, as JSON types."""
    where: str
    """File of the sweep, for error messages."""

    def changed(self, settings: Settings) -> R:
        """Return the record with other values. Raises ``ManifestError`` where a key is unknown, or a value wrong."""
        document: Mapping[str, Any] = self.base
        for path, given in settings.items():
            document = _put(document, path.split("."), given)
        return read_document(document, self.record, where=self.where)

    def value(self, path: str, given: Any) -> "Value":
        """Return a value that a key is given, as the document takes it.

        A quantity without an uncertainty keeps the relative one of what it replaces. Raises ``ManifestError``.
        """
        taken, shown = _at(self.changed({path: given}), path), given if isinstance(given, str) else ""
        if not isinstance(taken, Quantity):
            return Value(given, _cell(taken, given), _unit_above(self, path), shown)
        before = _look(self.base, path)
        stated = isinstance(before, Mapping) and before.get("value") and before.get("standard_uncertainty")
        if taken.standard_uncertainty is None and stated:
            share = before["standard_uncertainty"] / abs(before["value"])
            taken = taken.model_copy(update={"standard_uncertainty": abs(taken.value) * share})
        return Value(taken.model_dump(mode="json", exclude_none=True), taken.value, taken.unit, shown)


@dataclass(frozen=True)
class Value:
    """One value of a key."""

    given: Any
    """Value as JSON types."""
    cell: Cell
    unit: str | None
    """SI unit of a number that has one."""
    shown: str = ""
    """Text of the value in the sweep file, if it is a text."""


@dataclass(frozen=True)
class Parameter:
    """A key that is varied, and what it is varied over."""

    path: str
    values: tuple[Value, ...]
    """All of them; of a distribution the two that define it: its ends, or mean and one standard deviation above."""
    drawn: Drawn | None = None

    @property
    def unit(self) -> str | None:
        """SI unit of the values; None for texts and plain numbers."""
        return self.values[0].unit

    def draw(self, seed: int, repeat: int) -> Value:
        """Draw the value of one repeat, the same whatever else is varied."""
        rng = generator(seed, repeat, self.path)
        first, second = (float(value.cell) for value in self.values)
        drawn = first + (second - first) * (rng.standard_normal() if isinstance(self.drawn, Normal) else rng.random())
        given = self.values[0].given
        if not isinstance(given, Mapping):
            return Value(f"{drawn!r} {self.unit}" if self.unit else drawn, drawn, self.unit)
        told = {**given, "value": drawn}
        if first and "standard_uncertainty" in given:
            told["standard_uncertainty"] = given["standard_uncertainty"] * abs(drawn / first)
        return Value(told, drawn, self.unit)


def generator(seed: int, repeat: int, name: str) -> Generator:
    """Return the random number generator for a name in one repeat."""
    words = np.frombuffer(hashlib.sha256(name.encode()).digest()[:16], dtype="<u4")
    return Generator(PCG64(SeedSequence([seed, repeat, *words.tolist()])))


def parameters(vary: Mapping[str, Values], subject: Subject[Any]) -> tuple[Parameter, ...]:
    """Return what is varied, each value checked. Raises ``ManifestError`` at the first that is wrong."""
    return tuple(_parameter(path, values, subject) for path, values in vary.items())


def _parameter(path: str, values: Values, subject: Subject[Any]) -> Parameter:
    if isinstance(values, tuple):
        return Parameter(path, tuple(subject.value(path, given) for given in values))
    told = _ends(path, values, subject)
    if not all(isinstance(one.cell, float) for one in told):
        raise ManifestError(
            f"{subject.where}: vary.{path}: found a distribution for a key that is not numeric; expected a list of "
            "values; write the values in brackets"
        )
    if not told[0].cell < told[1].cell:  # type: ignore[operator]
        expected = (
            "a mean with a positive standard_uncertainty"
            if isinstance(values, Normal)
            else "a minimum less than the maximum"
        )
        raise ManifestError(
            f"{subject.where}: vary.{path}: found an empty range, {told[0].cell:g} to {told[1].cell:g}; "
            f"expected {expected}; correct these values"
        )
    return Parameter(path, told, values)


def _ends(path: str, values: Drawn, subject: Subject[Any]) -> tuple[Value, ...]:
    """Return the two values that define a distribution."""
    if not isinstance(values, Normal):
        return tuple(subject.value(path, given) for given in values.uniform)
    mean, spread = subject.value(path, values.normal), values.standard_uncertainty
    if isinstance(mean.given, Mapping):
        stated = subject.changed({path: {"value": values.normal, "standard_uncertainty": spread}})
        spread = _at(stated, path).standard_uncertainty
    if not isinstance(mean.cell, float) or isinstance(spread, bool) or not isinstance(spread, int | float):
        raise ManifestError(
            f"{subject.where}: vary.{path}: found standard_uncertainty = {spread!r}; expected a value in the "
            "unit of the mean; correct this value"
        )
    return mean, Value(mean.given, mean.cell + spread, mean.unit)


def _put(document: Mapping[str, Any], path: list[str], given: Any) -> Mapping[str, Any]:
    """Return a document in which the key at a path has another value; the one given stays as it is."""
    key, *rest = path
    if not rest:
        return {**document, key: given}
    found = document.get(key)
    inner: Mapping[str, Any] = found if isinstance(found, Mapping) else {}
    return {**document, key: _put(_as_written(inner) if rest in _PARTS else inner, rest, given)}


_PARTS = (["value"], ["standard_uncertainty"])


def _as_written(quantity: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return a quantity as people write it, so that either of its numbers may be given as a text."""
    if quantity.get("unit") in (None, "1"):
        return {name: part for name, part in quantity.items() if name != "unit"}
    unit, parts = quantity["unit"], ("value", "standard_uncertainty")
    return {name: f"{quantity[name]!r} {unit}" for name in parts if quantity.get(name) is not None}


def _at(record: Any, path: str) -> Any:
    for name in path.split("."):
        record = record[name] if isinstance(record, Mapping) else getattr(record, name)
    return record


def _look(document: Any, path: str) -> Any:
    for name in path.split("."):
        document = document.get(name) if isinstance(document, Mapping) else None
    return document


def _unit_above(subject: Subject[Any], path: str) -> str | None:
    """Return the unit of the quantity that a path names a part of."""
    above, _, part = path.rpartition(".")
    unit = _look(subject.base, f"{above}.unit") if [part] in _PARTS else None
    return None if unit == "1" else unit


def _cell(taken: Any, given: Any) -> Cell:
    if isinstance(taken, bool) or not isinstance(taken, int | float | str):
        return json.dumps(given)
    return taken if isinstance(taken, str) else float(taken)

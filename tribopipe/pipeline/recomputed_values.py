"""Values computed again, compared with those archived: each number, text and array by its dotted key."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tribopipe.archive.provenance import environment
from tribopipe.base.failures import in_a_sentence
from tribopipe.documents.record import Record

Value = float | int | str | bool | None
Outcome = Literal["identical", "within 1e-9", "different", "not compared"]
"""Every value the same bit for bit; the same but for relative differences up to 1e-9; not; or nothing to compare."""


@dataclass(frozen=True)
class Difference:
    """One value that came out other than it is archived."""

    where: str
    """Its key, such as "result.wear_coefficient.value", or an array and its element: "curves.wear_depth[12]"."""
    then: Value
    """As archived; none where there was no such value."""
    now: Value
    relative: float | None
    """Over the larger of the two; none where one is no number."""

    @property
    def apart(self) -> float:
        """The relative difference; infinite where no number expresses it."""
        return math.inf if self.relative is None else self.relative


@dataclass(frozen=True)
class Redone:
    """One step computed again, and compared with what is archived of it."""

    name: str
    """"raw", the name of a step, or "study"."""
    outcome: Outcome
    compared: int = 0
    """Values that were compared: every number of result, curves and tables, and every text."""
    differences: tuple[Difference, ...] = ()
    """One for each value, and for each array its largest; the largest first."""
    why: str | None = None
    """Why nothing could be compared, in one sentence; none where it could."""
    environment: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    """Versions and the like that were others when it was archived: then, and now."""

    @property
    def same(self) -> bool:
        """Whether every value came out the same, to 1e-9."""
        return self.outcome in ("identical", "within 1e-9")

    @property
    def apart(self) -> float:
        """The largest relative difference; infinite where no number expresses it."""
        if self.outcome == "not compared":
            return math.inf
        return self.differences[0].apart if self.differences else 0.0

    def as_json(self) -> dict[str, Any]:
        """Return it as JSON types."""
        return {
            **vars(self),
            "differences": [vars(one) for one in self.differences],
            "environment": {name: {"then": then, "now": now} for name, (then, now) in self.environment.items()},
        }


@dataclass(frozen=True)
class Reproduction:
    """A run or a study computed again."""

    id: str
    kind: Literal["run", "study"]
    steps: tuple[Redone, ...]

    @property
    def outcome(self) -> Outcome:
        """The outcome of the step that came out worst: not compared, or with the largest difference."""
        return max(self.steps, key=lambda step: step.apart).outcome

    @property
    def same(self) -> bool:
        """Whether every value of every step came out the same, to 1e-9."""
        return all(step.same for step in self.steps)

    def as_json(self) -> dict[str, Any]:
        """Return it as JSON types."""
        told = {"id": self.id, "kind": self.kind, "outcome": self.outcome}
        return {**told, "steps": [step.as_json() for step in self.steps]}


Leaf: TypeAlias = Value | NDArray[Any]
LIMIT = 1e-9
"""Relative difference up to which a number counts as the same."""


def redo(
    name: str, then: Mapping[str, Any], compute: Callable[[], Mapping[str, Any]], versions: Mapping[str, str]
) -> Redone:
    """Compute a step again, and compare what it found with what is archived of it."""
    try:
        now = compute()
    except Exception as error:  # noqa: BLE001 - behind a seal that was forged anything may stand
        return Redone(name, "not compared", why=str(in_a_sentence(error)), environment=_changed(versions))
    return compare(name, then, now, versions)


def compare(name: str, then: Mapping[str, Any], now: Mapping[str, Any], versions: Mapping[str, str]) -> Redone:
    """Compare what a step found now with what is archived of it, made with other ``versions`` perhaps."""
    before, after = dict(_leaves(then)), dict(_leaves(now))
    keys = dict.fromkeys([*before, *after])
    found = [_difference(key, before.get(key), after.get(key)) for key in keys]
    differences = sorted((one for one in found if one is not None), key=lambda one: one.apart, reverse=True)
    return Redone(
        name,
        _outcome(differences),
        compared=sum(np.asarray(leaf).size for leaf in before.values()),
        differences=tuple(differences),
        environment=_changed(versions),
    )


def _changed(versions: Mapping[str, str]) -> dict[str, tuple[str, str]]:
    now = environment()
    return {name: (then, now.get(name, "none")) for name, then in versions.items() if then != now.get(name)}


def _leaves(content: Any, key: str = "") -> Iterator[tuple[str, Leaf]]:
    """Yield every value within records, mappings and sequences by its dotted key; arrays are yielded whole."""
    if isinstance(content, Record):
        content = content.model_dump(mode="json")
    if isinstance(content, Mapping):
        for name, member in content.items():
            yield from _leaves(member, f"{key}.{name}" if key else str(name))
    elif isinstance(content, list | tuple):
        for place, member in enumerate(content):
            yield from _leaves(member, f"{key}[{place}]")
    else:
        yield key, content


def _outcome(differences: Sequence[Difference]) -> Outcome:
    if not differences:
        return "identical"
    return "within 1e-9" if differences[0].apart <= LIMIT else "different"


def _difference(key: str, then: Leaf, now: Leaf) -> Difference | None:
    """Return the largest difference of a value, or of the elements of an array; none where all bits are the same."""
    first, second = np.asarray(then), np.asarray(now)
    if first.shape != second.shape:
        return Difference(key, _shape(then), _shape(now), None)
    differs = _differing(first, second)
    if not differs.any():
        return None
    relative = _relative(first, second)
    worst = int(np.argmax(np.where(differs, np.nan_to_num(relative, nan=np.inf), -1.0)))
    size = float(relative.flat[worst])
    place = np.unravel_index(worst, first.shape)
    where = f"{key}[{','.join(map(str, place))}]" if place else key
    return Difference(where, _plain(first, worst), _plain(second, worst), size if np.isfinite(size) else None)


def _shape(leaf: Leaf) -> Value:
    return f"{' × '.join(map(str, leaf.shape))} values" if isinstance(leaf, np.ndarray) else leaf


def _are_numbers(values: NDArray[Any]) -> bool:
    return values.dtype.kind in "iuf"


def _differing(then: NDArray[Any], now: NDArray[Any]) -> NDArray[np.bool_]:
    """Report which elements differ in any bit; two that are NaN are the same."""
    if not (_are_numbers(then) and _are_numbers(now)):
        return np.asarray(then.astype(object) != now.astype(object))
    unequal = (then != now) & ~(np.isnan(then) & np.isnan(now))
    return np.asarray(unequal | ((then == 0) & (np.signbit(then) != np.signbit(now))))


def _relative(then: NDArray[Any], now: NDArray[Any]) -> NDArray[np.float64]:
    """Return differences over the larger of the two; NaN where one is no number."""
    if not (_are_numbers(then) and _are_numbers(now)):
        return np.full(then.shape, np.nan)
    larger = np.maximum(np.abs(then), np.abs(now))
    with np.errstate(all="ignore"):
        return np.asarray(np.where(larger == 0, 0.0, np.abs(np.subtract(then, now, dtype=np.float64)) / larger))


def _plain(values: NDArray[Any], place: int) -> Value:
    """Return an element as JSON has it: what JSON cannot hold, such as NaN, as a text."""
    value: Any = values.flat[place]
    value = value.item() if isinstance(value, np.generic) else value
    return str(value) if isinstance(value, float) and not np.isfinite(value) else value

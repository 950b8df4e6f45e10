"""What came of computing again what is archived."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

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

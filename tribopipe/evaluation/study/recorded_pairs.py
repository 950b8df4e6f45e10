"""Runs of a study in which a sensor recorded the wear of a pin, and the volume of its counterbody was measured.

The pin is compared with a law along its curve, the counterbody by its volume at the end. What both depend on, such as
the load, is off by the same in each draw. The law is rejected for a run where it is for either body; each body has half
the probability of a false alarm that a pin has.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from tribopipe.base.arrays import Column
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.evaluation.study.member import Member, PosedRun, RunDraws
from tribopipe.evaluation.study.recorded_runs import Shape, judge_recorded
from tribopipe.evaluation.study.verdict import Judgment, Question
from tribopipe.evaluation.study.volume_runs import VolumeDraws, VolumeRun, judge_volumes, posed_volumes
from tribopipe.physics.calculation_methods import WearEngine
from tribopipe.results.input_quantities import Inputs
from tribopipe.results.wear_fit import Contribution


@dataclass(frozen=True)
class RecordedPair:
    """A run and a law."""

    pin: PosedRun
    counterbody: VolumeRun

    @property
    def member(self) -> Member:
        """The run."""
        return self.pin.member

    @property
    def engine(self) -> WearEngine:
        """Pressure that k_D of the pin is found by."""
        return self.pin.engine

    @property
    def bodies(self) -> tuple[str, ...]:
        """The bodies whose k_D is found."""
        return (*self.pin.bodies, *self.counterbody.bodies)

    @property
    def by_volume(self) -> Collection[str]:
        """Those whose k_D is found by a volume."""
        return self.counterbody.bodies

    @property
    def coefficients(self) -> Column:
        """k_D of each body by this run alone, m²/N."""
        return np.concatenate([self.pin.coefficients, self.counterbody.coefficients])

    @property
    def scale(self) -> Column:
        """k_D that the budget of each body is relative to, m²/N."""
        return np.concatenate([self.pin.scale, self.counterbody.scale])

    @property
    def end(self) -> Quantity:
        """Sliding distance at the end of the test."""
        return self.pin.end

    @property
    def inputs(self) -> Inputs:
        """Everything uncertain that k_D of either body depends on."""
        return {**self.counterbody.inputs, **self.pin.inputs}

    def of(self, bodies: Sequence[str]) -> "RecordedPair | PosedRun | VolumeRun | None":
        """Return the run as some bodies have it; None if none of them was measured."""
        pin = self.pin if set(self.pin.bodies) & set(bodies) else None
        counterbody = self.counterbody.of(bodies)
        return (pin or counterbody) if pin is None or counterbody is None else replace(self, counterbody=counterbody)

    def may_share(self, names: Sequence[str]) -> tuple[str, ...]:
        """Return which inputs may be off by the same in several runs."""
        return tuple(dict.fromkeys((*self.pin.may_share(names), *self.counterbody.may_share(names))))

    def budgets(self, length: float | None = None) -> list[tuple[Contribution, ...]]:
        """Return what u of each k_D is made of, for a test ``length`` times as long where that is named."""
        return [*self.pin.budgets(length), *self.counterbody.budgets(length)]

    def draw(self, rng: Generator, count: int, shared: dict[str, Column]) -> "PairDraws":
        """Draw everything uncertain of this run; ``shared`` inputs are taken over from other runs of the study."""
        pin = self.pin.draw(rng, count, shared)
        return PairDraws(self, pin, self.counterbody.draw(rng, count, shared, pin.values))


@dataclass(frozen=True)
class PairDraws:
    """What is drawn of pin and counterbody."""

    run: RecordedPair
    pin: RunDraws
    counterbody: VolumeDraws

    @property
    def coefficients(self) -> Column:
        """k_D of each body, m²/N, (draws, bodies); NaN where a draw has no solution."""
        return np.concatenate([self.pin.coefficients, self.counterbody.coefficients], axis=1)

    def kept(self, accepted: NDArray[np.bool_]) -> "PairDraws":
        """Return the draws that were accepted."""
        return PairDraws(self.run, self.pin.kept(accepted), self.counterbody.kept(accepted))


def with_counterbody(pin: PosedRun, law: LawName, recipe: Recipe) -> PosedRun | RecordedPair:
    """Return a run with its counterbody, where that was measured and wears enough to matter for the pin.

    Raises ``FitError`` where the run is missing something that the law needs.
    """
    manifest = pin.member.corrected.run.manifest
    if pin.engine != "volume" or manifest.contact is None:
        return pin
    volumes = posed_volumes(pin.member, law, recipe)
    counterbody = volumes and volumes.of([body for body in volumes.bodies if body not in pin.bodies])
    return RecordedPair(pin, counterbody) if counterbody else pin


def judge_pair(draws: PairDraws, asked: Question, shape: Shape) -> Judgment:
    """Hold a law against the curve of the pin and the volume of its counterbody."""
    pin, counterbody = judge_recorded(draws.pin, asked, shape), judge_volumes(draws.counterbody, asked)
    return replace(
        pin,
        bodies={**pin.bodies, **counterbody.bodies},
        curves=(*pin.curves, *counterbody.curves),
        notes=tuple(dict.fromkeys((*pin.notes, *counterbody.notes))),
    )

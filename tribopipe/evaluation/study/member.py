"""One run as it enters a study: its wear as measured and as a law has it, for draws of everything uncertain.

`at_length` and `at_rotations` pose what a test that lasts longer would measure if the law held exactly. The same
sensors, the same noise at the same sampling rate; post-test measurements of depths and widths as uncertain as they
are, volumes as uncertain relative to themselves.
"""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar, Generic, Self, TypeVar

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from tribopipe.base.arrays import Column
from tribopipe.base.errors import FitError
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.documents.study import Study, check_bodies
from tribopipe.evaluation.wear.depth_problem import DepthProblem, depth_problem
from tribopipe.evaluation.wear.drift_and_wear import END_ANCHOR, Anchor, JointProblem, joint_problem
from tribopipe.evaluation.wear.inputs import PIN_SHARED, draw_values, law_as_given
from tribopipe.evaluation.wear.measurement_problem import MeasurementProblem
from tribopipe.evaluation.wear.problem import PRESSURE, WearProblem, wear_problem
from tribopipe.evaluation.wear.uncertainty import budget, relative_uncertainty, solve_draws
from tribopipe.physics.calculation_methods import WearEngine
from tribopipe.results.evaluation import FrictionFit
from tribopipe.results.input_quantities import Input, Inputs
from tribopipe.results.run import CorrectedRun
from tribopipe.results.study import LeftOut
from tribopipe.results.wear_fit import Contribution

_FEWEST_COPIED = 16
"""Samples from which on two equal recordings are of one test."""


_DEAFENING = 1e12
"""Factor of the variance of a reading that leaves it no weight."""


def at_length(problem: WearProblem, coefficient: float, length: float) -> WearProblem:
    """Return the problem that a test ``length`` times as long would pose if the law held exactly.

    Raises ``ContactError`` where the tip would be worn away.
    """
    values = problem.values
    longer = replace(
        problem,
        distance=problem.distance * length,
        weights=problem.weights * length,
        trace=replace(problem.trace, slid=problem.trace.slid * length),
    )
    end = float(longer.depth(coefficient, values, np.asarray([longer.trace.slid]))[0])
    wear = problem.end.grown(end)
    share = 1 + (wear.disc.quantity.value / end if wear.disc is not None else 0.0)
    # Windows are a share of the distance: they hold as many more samples.
    scale, zero = values["depth_scale"], _better(problem.trace.zero_offset, length)
    curve = zero.value + longer.depth(coefficient, values, longer.distance) * share / scale
    last = _better(problem.trace.end_reading, length).model_copy(update={"value": zero.value + end * share / scale})
    trace = replace(
        longer.trace,
        reading=curve,
        zero_offset=zero,
        end_reading=last,
        unworn_end=zero.value,
        duration=problem.trace.duration * length,
    )
    inputs = dict(problem.inputs) | {END_ANCHOR: Input(wear.pin.quantity, problem.inputs[END_ANCHOR].source)}
    if wear.disc is not None:
        inputs["disc_end_value"] = Input(wear.disc.quantity, problem.inputs["disc_end_value"].source)
    if "end_reading" in inputs:
        inputs |= {"zero_offset": Input(zero, "fit"), "end_reading": Input(last, "fit")}
    longer = replace(longer, trace=trace, end=wear, inputs=inputs)
    if isinstance(longer, JointProblem):
        longer = replace(longer, anchors=(Anchor(END_ANCHOR, longer.trace.slid, wear),))
    return longer


def _better(reading: Quantity, length: float) -> Quantity:
    """Return a reading that is the mean of ``length`` times as many samples."""
    return reading.model_copy(update={"standard_uncertainty": reading.u_or_zero / length**0.5})


def at_rotations(problem: MeasurementProblem, found: Column, length: float) -> MeasurementProblem:
    """Return the problem that a test of ``length`` times the rotations would pose if the law held exactly.

    Raises ``ContactError`` where the crown would be worn away.
    """
    longer = replace(
        problem,
        measurements=tuple(replace(one, place=one.place * length) for one in problem.measurements),
    )
    inputs = dict(problem.inputs)
    for one, value in zip(longer.measurements, longer.modelled(found, problem.values), strict=True):
        given = problem.inputs[one.name]
        scale = float(value) / one.quantity.value if one.what == "wear_volume" and one.quantity.value else 1.0
        quantity = Quantity(value=float(value), unit=one.quantity.unit, standard_uncertainty=given.spread * scale)
        inputs[one.name] = Input(quantity, given.source)
    return replace(longer, inputs=inputs)


@dataclass(frozen=True)
class Member:
    """A corrected run with its friction."""

    corrected: CorrectedRun
    friction: FrictionFit | None

    @property
    def id(self) -> str:
        """Name of the run."""
        return self.corrected.id

    @property
    def has_curve(self) -> bool:
        """Whether a sensor recorded the wear of a pin along the run, and the pin was measured after it."""
        contact = self.corrected.run.manifest.contact
        return self.corrected.correction.anchor is not None and (contact is None or contact.sensor_tells)

    def pose(self, law: LawName, recipe: Recipe) -> "PosedRun":
        """Pose the fit of a law to this run. Raises ``FitError`` where the run is missing something for it."""
        law_as_given(law, recipe)
        problem = wear_problem(self.corrected, law, self.friction, recipe)
        if isinstance(problem, WearProblem) and not self.has_curve:
            problem = ("a post-test measurement of the pin (wear depth, scar, wear volume, mass or profile)",)
        if not isinstance(problem, WearProblem):
            missing = self.corrected.run.manifest.worded(" and ".join(problem))
            raise FitError(
                f"{self.id}: found a run without {missing}; expected a depth signal, a post-test measurement and, for "
                "a law that includes friction, a friction signal; add what is missing, or remove the run from the study"
            )
        joint = joint_problem(problem, self.corrected, recipe)
        by_model = recipe.wear.correction == "model"
        chosen = depth_problem(problem, self.corrected, recipe) if by_model else problem.pooled()
        return PosedRun(self, chosen, joint)


def chosen(
    study: Study, members: Mapping[str, Member], left_out: Sequence[LeftOut]
) -> tuple[list[Member], list[Member]]:
    """Return the runs of a study that identify k_D and those that are predicted, without those left out.

    Raises ``FitError`` where no run is left to fit, or where runs differ in bodies or environment.
    """
    out = {one.id for one in left_out}
    fit, predict = ([members[i] for i in ids if i not in out] for ids in (study.fit, study.predict))
    if not fit:
        raise FitError(
            f"{study.id}: found no run left from which to identify k_D; expected at least one; list another run in "
            "fit, or remove the mark of a bad run with `tribopipe mark-bad --undo`"
        )
    check_bodies(study.id, *([member.corrected.run.manifest for member in some] for some in (fit, predict)))
    return fit, predict


def copies_note(members: Sequence[Member]) -> tuple[str, ...]:
    """Report runs with the same recording: one test that counts as several makes k_D seem too certain."""
    first: dict[bytes, str] = {}
    for member in members:
        columns = member.corrected.run.columns
        recorded = [columns[name] for name in ("depth", "friction_force") if name in columns]
        if recorded and len(recorded[0]) >= _FEWEST_COPIED and np.ptp(recorded[0]) > 0:
            original = first.setdefault(np.concatenate(recorded).tobytes(), member.id)
            if original != member.id:
                return (
                    f"warning: found the same recording in {original} and {member.id}; expected independent tests, "
                    "since u(k_D) is too small if one test is counted twice; remove one of them from the study",
                )
    return ()


@dataclass(frozen=True)
class PosedRun:
    """A run and a law."""

    member: Member
    problem: WearProblem
    """Problem posed with the correction method of the recipe."""
    joint: JointProblem
    """Drift left free, by which the shape of the curve is judged."""

    @property
    def engine(self) -> WearEngine:
        """Pressure that k_D is found by."""
        return self.problem.engine

    by_volume: ClassVar[Collection[str]] = ()

    @property
    def inputs(self) -> Inputs:
        """Everything uncertain that k_D depends on."""
        return self.problem.inputs

    @property
    def bodies(self) -> tuple[str, ...]:
        """The body whose k_D is found."""
        return self.problem.contact.fitted_bodies[:1]

    @property
    def coefficients(self) -> Column:
        """Its k_D of this run alone, m²/N."""
        return np.array([self.coefficient])

    @property
    def scale(self) -> Column:
        """k_D that its budget is relative to, m²/N."""
        return self.coefficients

    @property
    def end(self) -> Quantity:
        """Sliding distance or rotations at the end of the test."""
        return Quantity(value=self.problem.trace.slid, unit="m")

    def may_share(self, names: Sequence[str]) -> tuple[str, ...]:
        """Return which inputs may be off by the same in several runs: discs nobody looked at are as good as one."""
        return (
            *(name for name in names if name in PIN_SHARED),
            "unseen_groove",
            *{PRESSURE}.intersection(self.problem.inputs),
        )

    def budgets(self, length: float | None = None) -> list[tuple[Contribution, ...]]:
        """Return what u of k_D is made of, for a test ``length`` times as long where that is named.

        A longer test is no worse than this one: what comes after it can be left out.
        """
        if length is None:
            return [self._budget]
        other = budget(at_length(self._alike, self.coefficient, length), self.coefficient)
        return [min(self._budget, other, key=relative_uncertainty) if length > 1 else other]

    @cached_property
    def _budget(self) -> tuple[Contribution, ...]:
        return budget(self.problem.condensed(), self.coefficient)

    @cached_property
    def _alike(self) -> WearProblem:
        """The plain run, or the measurement alone where that has an uncertainty more like the run's.

        Least squares of both do not know that the scale of the sensor is off for all samples alike.
        """
        if self.problem is self.plain:
            return self.problem

        def unlike(way: WearProblem) -> float:
            as_long = budget(at_length(way, self.coefficient, 1.0), self.coefficient)
            return abs(math.log(relative_uncertainty(as_long) / relative_uncertainty(self._budget)))

        return min((self.plain, self.by_measurement), key=unlike)

    @cached_property
    def coefficient(self) -> float:
        """k_D of this run alone, m²/N."""
        return self.problem.coefficient()

    @cached_property
    def plain(self) -> WearProblem:
        """The same run with noise alone, as much of it as leaves k_D as uncertain: what tests of other lengths are.

        A wander that was seen once gives no information on a longer test.
        """
        if not isinstance(self.problem, DepthProblem):
            return self.problem
        white = self.joint.random_uncertainty(self.coefficient)
        louder = self.problem.random_uncertainty(self.coefficient) / white if white else 1.0
        return replace(self.joint, noise=self.joint.noise * max(1.0, louder) ** 2)

    @property
    def by_measurement(self) -> WearProblem:
        """The same run with a depth signal so noisy that k_D follows from what was measured on the pin."""
        return replace(self.joint, noise=self.joint.noise * _DEAFENING)

    @cached_property
    def places(self) -> Column:
        """Sliding distances at which wear is compared, m: one for each pooled stretch, and the end."""
        return np.append(self.problem.distance, self.problem.trace.slid)

    def measured(self) -> Column:
        """Return the pin's wear at the places, m: the corrected curve, and the post-test measurement."""
        return self._measured(self.problem.values, np.asarray(self.coefficient), np.zeros(1))

    def predicted(self, coefficient: float) -> Column:
        """Return the law's wear at the places, m, for a k_D."""
        return self.problem.depth(coefficient, self.problem.values, self.places)

    def draw(self, rng: Generator, count: int, shared: dict[str, Column]) -> "RunDraws":
        """Draw everything uncertain of this run; ``shared`` inputs are taken over from other runs of the study."""
        problem = self.problem
        values = draw_values(problem.inputs, problem.friction_covariance, rng, count, shared)
        noise = problem.draw_noise(rng, count)
        return RunDraws(self, values, noise, solve_draws(problem, values, noise))

    def _measured(self, values: dict[str, float] | dict[str, Column], coefficient: Column, noise: Column) -> Column:
        curve = self.problem.measured(values, coefficient, noise)
        end = np.broadcast_to(self.problem.end_depth(values), (*curve.shape[:-1], 1))
        return np.concatenate([curve, end], axis=-1)


@dataclass(frozen=True)
class RunDraws:
    """A run's inputs, noise and own k_D in each draw."""

    run: PosedRun
    values: dict[str, Column]
    """Inputs, columns of shape (draws, 1)."""
    noise: Column
    """Noise of each row, m."""
    coefficient: Column
    """k_D of this run alone, m²/N; NaN where a draw has no solution."""

    @property
    def coefficients(self) -> Column:
        """The same as (draws, bodies)."""
        return self.coefficient[:, None]

    def kept(self, accepted: NDArray[np.bool_]) -> "RunDraws":
        """Return the draws that were accepted."""
        values = {name: column[accepted] for name, column in self.values.items()}
        return RunDraws(self.run, values, self.noise[accepted], self.coefficient[accepted])

    def measured(self) -> Column:
        """Return the pin's wear as it would have been measured, m: draws by places."""
        known = np.where(self.coefficient > 0, self.coefficient, self.run.coefficient * 1e-6)
        return self.run._measured(self.values, known, self.noise)  # noqa: SLF001

    def predicted(self, coefficient: Column) -> Column:
        """Return the law's wear, m, with a k_D for each draw: draws by places."""
        return self.run.problem.depth(coefficient[:, None], self.values, self.run.places)


Run = TypeVar("Run")


@dataclass(frozen=True)
class BodyDraws(Generic[Run]):
    """Inputs of a run without a depth signal, and its own k_D of each body in each draw."""

    run: Run
    values: dict[str, Column]
    """Columns of shape (draws, 1)."""
    coefficients: Column
    """m²/N, (draws, bodies); NaN where a draw has no solution."""

    def kept(self, accepted: NDArray[np.bool_]) -> Self:
        """Return the draws that were accepted."""
        values = {name: column[accepted] for name, column in self.values.items()}
        return replace(self, values=values, coefficients=self.coefficients[accepted])

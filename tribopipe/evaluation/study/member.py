"""One run as it enters a study: its wear as measured and as a law has it, for draws of everything uncertain."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from tribopipe.base.arrays import Column
from tribopipe.base.errors import FitError
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.documents.study import Study
from tribopipe.evaluation.study.bodies import check_bodies
from tribopipe.evaluation.study.longer_tests import at_length
from tribopipe.evaluation.wear.budget import budget
from tribopipe.evaluation.wear.depth_problem import DepthProblem, depth_problem
from tribopipe.evaluation.wear.draws import solve_draws
from tribopipe.evaluation.wear.given_parameters import law_as_given
from tribopipe.evaluation.wear.inputs import PIN_SHARED, draw_values
from tribopipe.evaluation.wear.joint import JointProblem, joint_problem
from tribopipe.evaluation.wear.problem import WearProblem, wear_problem
from tribopipe.results.agreement import LeftOut
from tribopipe.results.evaluation import FrictionFit
from tribopipe.results.run import CorrectedRun
from tribopipe.results.wear_fit import Contribution


@dataclass(frozen=True)
class Member:
    """A corrected run with its friction."""

    corrected: CorrectedRun
    friction: FrictionFit | None

    @property
    def id(self) -> str:
        """Name of the run."""
        return self.corrected.id

    def pose(self, law: LawName, recipe: Recipe) -> "PosedRun":
        """Pose the fit of a law to this run. Raises ``FitError`` where the run is missing something for it."""
        law_as_given(law, recipe)
        problem = wear_problem(self.corrected, law, self.friction, recipe)
        if isinstance(problem, WearProblem) and self.corrected.correction.anchor is None:
            problem = ("a post-test measurement of the pin (depth, scar, volume, mass or profile)",)
        if not isinstance(problem, WearProblem):
            raise FitError(
                f"{self.id}: found a run without {' and '.join(problem)}; expected depth, a post-test measurement "
                "and, for Sarkar's law, friction; remove it from the study"
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
            f"{study.id}: found no run left to identify k_D; expected at least one; list another run in fit, or remove "
            "a mark with `tribopipe mark-bad --undo`"
        )
    check_bodies(study.id, [member.corrected.run.manifest for member in (*fit, *predict)])
    return fit, predict


@dataclass(frozen=True)
class PosedRun:
    """A run and a law."""

    member: Member
    problem: WearProblem
    """By the correction that the recipe wants."""
    joint: JointProblem
    """Drift left free, by which the shape of the curve is judged."""

    @property
    def bodies(self) -> tuple[str, ...]:
        """The body whose k_D is found."""
        return self.problem.contact.fitted_bodies[:1]

    @property
    def coefficients(self) -> Column:
        """Its k_D of this run alone, m²/N."""
        return np.array([self.coefficient])

    @property
    def end(self) -> Quantity:
        """How far the test went."""
        return Quantity(value=self.problem.trace.slid, unit="m")

    def may_share(self, names: Sequence[str]) -> tuple[str, ...]:
        """Return which inputs may be off by the same in several runs: discs nobody looked at are as good as one."""
        return (*(name for name in names if name in PIN_SHARED), "unseen_groove")

    def budgets(self, length: float | None = None) -> list[tuple[Contribution, ...]]:
        """Return what u of k_D is made of, for a test ``length`` times as long where that is named."""
        if length is None:
            return [budget(self.problem.condensed(), self.coefficient)]
        return [budget(at_length(self.plain, self.coefficient, length), self.coefficient)]

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

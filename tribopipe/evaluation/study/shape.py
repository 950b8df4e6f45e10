"""Whether the curve of one run has the shape of the law, whatever its k_D, zero offset and drift.

Residuals of the pooled reading are divided by their standard deviation, and what k_D, zero offsets and drift can
describe is projected out of them and out of every alternative. What is left is white noise if the law holds, so that
the gain of an alternative is χ² (trend) or, where its place is searched for, drawn.
"""

import math

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName
from tribopipe.evaluation.study.member import PosedRun
from tribopipe.results.agreement import ChangePoint, LawComparison, Trend

_PLAYED = 4_000
"""Draws of pure noise that a searched gain is held against."""
_START = 1e-9
"""Effective distance, m, of what is recorded before any sliding."""
_EDGE = 4
"""Stretches at either end in which no change is looked for."""
_PREFERENCE = 2.0
"""Difference of AIC below which two models are about as good (K. P. Burnham, D. R. Anderson, 2002, 2.6)."""


class Shape:
    """What k_D, zero offsets and drift leave of one run's reading under a law."""

    def __init__(self, run: PosedRun) -> None:
        problem = run.joint
        self.problem = problem
        free = float(problem.solve(problem.values))
        self.coefficient = free if free > 0 else run.coefficient
        count = len(problem.distance)
        depth, slope = problem.model(np.log(self.coefficient), problem.values)
        self.slope = slope[:count]
        self.root = problem.root_weights[:count]
        nuisance = np.column_stack([self.slope * self.root, problem.linear[:count]])
        self._basis = np.linalg.qr(nuisance)[0]
        self.residual = self.left_of((problem.rows(problem.values) - depth)[:count])

    def left_of(self, rows: Column) -> Column:
        """Return what nothing else explains of a column, m, in standard deviations."""
        weighted = rows * self.root
        return np.asarray(weighted - self._basis @ (self._basis.T @ weighted))

    @property
    def sum_of_squares(self) -> float:
        """χ² of the shape."""
        return float(self.residual @ self.residual)

    def trend(self) -> Trend:
        """Look for what is smooth in the residuals: the next powers of √s."""
        from scipy.stats import chi2

        share = np.sqrt(self.problem.distance / self.problem.distance[-1])
        columns = np.column_stack([share**3, share**4])
        left = np.column_stack([self.left_of(column) for column in columns.T])
        amount, *_ = np.linalg.lstsq(left, self.residual)
        gain = float(np.sum((left @ amount) ** 2))
        amplitude = math.sqrt(float(np.average((left @ amount / self.root) ** 2, weights=self.problem.weights)))
        return Trend(p_value=float(chi2.sf(gain, 2)), amplitude=Quantity(value=amplitude, unit="m"))

    def change_point(self, seed: int = 1) -> ChangePoint | None:
        """Look for the place after which another k_D holds; none where the run has too few stretches.

        ``seed`` is that of the noise which the gain is held against.
        """
        problem = self.problem
        effective = problem.effective_distance(problem.values)
        places = np.arange(_EDGE, len(effective) - _EDGE)
        if not len(places):
            return None
        slid = np.maximum(effective, _START)
        columns = [self.slope * np.maximum(0.0, 1 - effective[place] / slid) for place in places]
        left = np.column_stack([self.left_of(column) for column in columns])
        left /= np.linalg.norm(left, axis=0)
        gains = (left.T @ self.residual) ** 2
        best = int(np.argmax(gains))
        # The columns are orthogonal to what was projected out, so plain noise is as good as projected noise.
        noise = np.random.Generator(np.random.PCG64(seed)).standard_normal((_PLAYED, len(effective)))
        played = np.max((noise @ left) ** 2, axis=1)
        at = float(problem.distance[places[best]])
        return ChangePoint(
            sliding_distance=Quantity(value=at, unit="m"),
            rate_ratio=self._rate_ratio(float(effective[places[best]]), effective),
            p_value=float((np.count_nonzero(played >= gains[best]) + 1) / (_PLAYED + 1)),
        )

    def _rate_ratio(self, change: float, effective: Column) -> float:
        """Return k_D after over k_D before a change at an effective distance, by Gauss–Newton with drift left free."""
        problem = self.problem
        values, load = problem.values, problem.values["normal_load"]
        pin = problem.pin(values)
        count = len(effective)
        # The disc's wear as without the change: it is small.
        disc = problem.model(np.log(self.coefficient), values)[0][:count] - problem.depth(self.coefficient, values)
        reading, free = problem.rows(values)[:count] - disc, np.linalg.qr(problem.linear[:count])[0]
        before, after = np.minimum(effective, change), np.maximum(effective - change, 0.0)
        log_k = np.full(2, np.log(self.coefficient))
        for _ in range(30):
            k = np.exp(log_k)
            state = pin.worn(load * (k[0] * before + k[1] * after))
            slopes = load * np.column_stack([k[0] * before, k[1] * after]) / state.area[:, None]
            rows = np.column_stack([reading - state.depth, slopes]) * self.root[:, None]
            rows -= free @ (free.T @ rows)
            step, *_ = np.linalg.lstsq(rows[:, 1:], rows[:, 0])
            log_k = log_k + np.clip(step, -0.5, 0.5)
        return float(np.exp(log_k[1] - log_k[0]))


def compare_laws(archard: Shape, sarkar: Shape) -> LawComparison:
    """Compare two laws by Akaike's criterion n·ln(χ²/n) + 2p on the shape of one run; both have as many parameters."""
    delta = len(archard.residual) * float(np.log(sarkar.sum_of_squares / archard.sum_of_squares))
    better: LawName = "archard" if delta > 0 else "sarkar"
    preferred = better if abs(delta) >= _PREFERENCE else None
    return LawComparison(delta_aic=delta, preferred=preferred)

"""(d) 10 000 draws of k_D beside a fit to all samples for each draw, and how they grow with their number.

Load, tip radius, moduli, speed, sensor scale, end values, offsets and noise are drawn in both. The naive way draws them
one after the other and fits each by `curve_fit`, which is as accurate; some are timed, and scaled to all.
"""

import time
from collections.abc import Iterator
from functools import partial

import numpy as np
from case import Growth, Pair, Row, Setting
from fits import SAMPLES_A_RUN, TYPICAL, TestRun
from scipy.optimize import curve_fit

from tribopipe.evaluation.wear.inputs import draw_values
from tribopipe.evaluation.wear.problem import WearProblem
from tribopipe.evaluation.wear.uncertainty import coefficient_draws
from tribopipe.physics.uncertainty import BLOCK

DRAWS, _MOST = 10_000, 1_000_000


def rows(setting: Setting) -> Iterator[Row]:
    """Yield the pair and the growth."""
    problem = TestRun(SAMPLES_A_RUN).problem
    count, naive = setting.of(DRAWS, small=1000), setting.of(100, small=5)
    yield Pair(
        f"Monte Carlo uncertainty of k_D, {count:,} draws",
        partial(drawn, problem, count),
        partial(drawn_one_by_one, problem, naive),
        f"curve_fit to all samples for each draw; extrapolated from {naive} draws",
        scaled=count / naive,
        repeats=7,
        clock=time.process_time,
    )
    sizes = setting.decades(_MOST, small=20_000)
    yield Growth(
        "Monte Carlo uncertainty of k_D",
        sizes,
        lambda size: partial(drawn, problem, size),
        of="draws",
        repeats=3,
        clock=time.process_time,
    )


def drawn(problem: WearProblem, count: int) -> None:
    """Draw k_D so often, in blocks as a fit does."""
    draw, rng = coefficient_draws(problem), np.random.default_rng(1)
    for begun in range(0, count, BLOCK):
        draw(rng, min(BLOCK, count - begun))


def drawn_one_by_one(problem: WearProblem, count: int) -> None:
    """Fit k_D to all samples anew for each draw."""
    rng, deviation = np.random.default_rng(1), np.sqrt(problem.noise)
    for _ in range(count):
        values = {name: float(one[0, 0]) for name, one in draw_values(problem.inputs, None, rng, 1).items()}
        measured = problem.pin_wear(values) + deviation * rng.standard_normal(len(problem.distance))
        pin, unit = problem.pin(values), problem.unit_volume(values)
        curve_fit(lambda volume, k, pin=pin: pin.worn(k * volume).depth, unit, measured, (TYPICAL,))

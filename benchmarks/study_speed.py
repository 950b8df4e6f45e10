"""Time of a study with 10 000 draws beside that of one least-squares fit by plain Euler steps.

    python benchmarks/study_speed.py

The study identifies k_D from the Si3N4 sample run at 200 mN and predicts 400 and 800 mN; its runs are in memory,
corrected for drift. The fit is of one k_D to the same three runs by `scipy.optimize.least_squares`, the model being a
loop of one explicit step for each recorded sample. Both are run in turn in one process. Times are of the processor, so
that other work on the machine counts little; the target is a ratio of at most 5.
"""

import math
import statistics
import time
from collections.abc import Callable

import numpy as np
from labs import SAMPLES, LabRun, Report, arguments
from scipy.optimize import least_squares

from tribopipe.base.arrays import Column
from tribopipe.documents.recipe import LawName
from tribopipe.documents.study import Study
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.friction import fit_friction
from tribopipe.evaluation.study.evaluate import evaluate
from tribopipe.evaluation.study.member import Member
from tribopipe.extras.simulate import VirtualTest
from tribopipe.extras.sweep.virtual_tests import recorded_run
from tribopipe.physics.hertz import contact_modulus
from tribopipe.results.evaluation import FrictionFit
from tribopipe.results.study import Evaluation

RUNS = ("si3n4-air-200mN", "si3n4-air-400mN", "si3n4-air-800mN")


def sample(name: str) -> LabRun:
    """Return a sample run in memory."""
    series, run = SAMPLES[name]
    test = VirtualTest(series, run)
    return LabRun(correct_drift(recorded_run(series, test)), test.truth())


def study_of(laws: tuple[LawName, ...], members: dict[str, Member]) -> Evaluation:
    """Evaluate the study."""
    return evaluate(Study(id="speed", fit=RUNS[:1], predict=RUNS[1:], laws=laws), members)


def euler_depth(coefficient: float, load: float, radius: float, modulus: float, distance: Column) -> Column:
    """Return the wear depth, m, by one explicit step from each sample to the next."""
    start = (3 * load * radius / (4 * modulus)) ** (1 / 3)
    depth, a = np.zeros_like(distance), start
    for i in range(len(distance) - 1):
        pressure = load / (np.pi * a * a)
        depth[i + 1] = depth[i] + coefficient * pressure * (distance[i + 1] - distance[i])
        total = depth[i + 1] + load / (2 * modulus * a)
        a = np.sqrt(max(2 * radius * total - total * total, start * start * 0.25))
    return depth


def euler_fit(runs: dict[str, LabRun]) -> tuple[float, int]:
    """Fit one k_D, m²/N, to all runs, and say how often the model was computed."""
    evaluations = 0

    def residuals(log_k: Column) -> Column:
        nonlocal evaluations
        evaluations += 1
        return np.concatenate([_residuals(math.exp(log_k[0]), run) for run in runs.values()])

    true = runs[RUNS[0]].truth.wear_coefficient.value
    found = least_squares(residuals, [math.log(1.3 * true)])
    return math.exp(found.x[0]), evaluations


def _residuals(coefficient: float, run: LabRun) -> Column:
    raw, measured = run.corrected.run, run.corrected.pin_wear_depth
    if measured is None:
        raise ValueError(f"{raw.id}: expected a run corrected for drift")
    contact, load = raw.manifest.described, raw.manifest.conditions.normal_load.value
    modulus = contact_modulus(
        pin_modulus=contact.sliding_tip.youngs_modulus.value,
        pin_ratio=contact.sliding_tip.poisson_ratio.value,
        disc_modulus=contact.counterbody.youngs_modulus.value,
        disc_ratio=contact.counterbody.poisson_ratio.value,
    )
    model = euler_depth(coefficient, load, contact.sliding_tip.radius.value, float(modulus), raw.sliding_distance)
    return np.asarray((model - measured) / 1e-7)


def timed(work: Callable[[], object]) -> tuple[float, float]:
    """Return the time of the processor and of the clock, s."""
    wall, start = time.perf_counter(), time.process_time()
    work()
    return time.process_time() - start, time.perf_counter() - wall


def main() -> None:
    """Time all in turn and print medians and ratios."""
    parser = arguments(__doc__ or "")
    parser.add_argument("--repeats", type=int, default=7, help="number of repeats (%(default)s)")
    options = parser.parse_args()
    report = Report("Speed of a study", options)
    runs = {name: sample(name) for name in RUNS}
    members = {name: run.member for name, run in runs.items()}
    with_friction: dict[str, FrictionFit] = {name: fit_friction(run.corrected.run) for name, run in runs.items()}
    rubbed = {name: Member(run.corrected, with_friction[name]) for name, run in runs.items()}
    one = study_of(("archard",), members).result.law("archard")
    _, evaluations = euler_fit(runs)
    cases: dict[str, Callable[[], object]] = {
        "least-squares fit with Euler steps": lambda: euler_fit(runs),
        "study, Archard's law": lambda: study_of(("archard",), members),
        "study, both laws": lambda: study_of(("archard", "sarkar"), rubbed),
    }
    times: dict[str, list[tuple[float, float]]] = {name: [] for name in cases}
    for _ in range(options.repeats):
        for name, work in cases.items():
            times[name].append(timed(work))
    report.say(
        f"{one.draws} accepted draws of k_D with Archard's law, {one.rejected} rejected; the fit evaluates the model "
        f"{evaluations} times for {sum(len(run.corrected.run) for run in runs.values())} samples. Medians of "
        f"{options.repeats} alternating repeats; minimum and maximum in parentheses."
    )
    medians = {name: statistics.median(taken for taken, _ in times[name]) for name in cases}
    least = medians["least-squares fit with Euler steps"]
    rows = []
    for name, taken in times.items():
        processor, clock = zip(*taken, strict=True)
        cell = f"{medians[name]:.2f} s ({min(processor):.2f} to {max(processor):.2f})"
        rows.append([name, cell, f"{statistics.median(clock):.2f} s", f"{medians[name] / least:.2f}"])
    report.table(["", "CPU time", "elapsed time", "ratio"], rows)
    report.finish()


if __name__ == "__main__":
    main()

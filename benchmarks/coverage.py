"""Coverage of the intervals of k_D and of the bands of predictions, over simulated laboratories.

    python benchmarks/coverage.py --labs 1000 --jobs 2

Every laboratory identifies k_D from one run and predicts others under the same law (`labs.py` says what varies). Each
end value is a height loss of the pin known to ±250 nm (standard uncertainty, normal). A 95 % interval should hold in
93 to 97 % of laboratories.
"""

import statistics
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from labs import (
    CORRECTIONS,
    NO_ANSWER,
    LabRun,
    Planned,
    Report,
    arguments,
    draw_blocks_of,
    height_loss,
    in_parallel,
    laboratory,
    reason,
    recipe,
    share,
    with_blocks,
)
from labs import planned as run

from tribopipe.documents.recipe import Correction
from tribopipe.documents.study import Study
from tribopipe.evaluation.study.evaluate import evaluate
from tribopipe.results.study import Interval, RunVerdict, StudyCurve

END_VALUE = 250e-9
PLACES = (0.1, 0.5, 0.9)
MATERIALS: dict[str, tuple[Planned, ...]] = {
    "Si3N4": (run("si3n4-air-200mN"), run("si3n4-air-400mN")),
    "WC-Co": (run("wc-co-water-400mN"), run("wc-co-water-400mN", "-again"), run("wc-co-water-800mN")),
}
"""The first run of each identifies k_D."""


@dataclass(frozen=True)
class Task:
    """One laboratory and how it corrects drift."""

    material: str
    correction: Correction
    seed: int
    block: int


@dataclass(frozen=True)
class RunHeld:
    """What one run's intervals held."""

    true_end: bool
    """The law's interval: the true depth at the end."""
    end: bool
    """The interval of measurements: the depth measured at the end."""
    curve: float
    """The band of measurements: this share of the places of the measured curve."""
    places: tuple[bool, ...]
    """The same at ``PLACES``."""


@dataclass(frozen=True)
class Held:
    """What one laboratory's intervals held."""

    coefficient: bool
    ratio: float
    """k_D over the true one."""
    uncertainty: float
    """Relative standard uncertainty of k_D."""
    below: bool
    """The true k_D lies below the interval."""
    runs: dict[str, RunHeld]


def held(task: Task) -> Held | str:
    """Evaluate one laboratory; where it has no k_D, return why."""
    planned = MATERIALS[task.material]
    draw_blocks_of(task.block)
    try:
        runs = laboratory(planned, task.seed, height_loss(END_VALUE))
        study = Study(
            id="coverage", fit=(planned[0].id,), predict=tuple(one.id for one in planned[1:]), laws=("archard",)
        )
        found = evaluate(study, {name: one.member for name, one in runs.items()}, recipe(task.correction))
    except NO_ANSWER as error:
        return reason(error)
    law, truth = found.result.law("archard"), runs[planned[0].id].truth.wear_coefficient.value
    curves = {curve.run_id: curve for curve in found.curves}
    best = law.first.wear_coefficient
    return Held(
        coefficient=_holds(law.first.interval, truth),
        ratio=best.value / truth,
        uncertainty=(best.standard_uncertainty or 0.0) / best.value,
        below=truth < law.first.interval[0].value,
        runs={one.id: _run_held(one, curves[one.id], runs[one.id]) for one in law.runs},
    )


def _holds(interval: Interval, value: float) -> bool:
    return interval[0].value <= value <= interval[1].value


def _run_held(verdict: RunVerdict, curve: StudyCurve, lab: LabRun) -> RunHeld:
    measured = curve.measured
    if measured is None:
        raise TypeError("coverage: found a curve without measurements; expected those of a pin")
    inside = ((measured.lower <= measured.best) & (measured.best <= measured.upper))[:-1]
    at = [int(np.argmin(np.abs(curve.places[:-1] - place * curve.places[-1]))) for place in PLACES]
    return RunHeld(
        true_end=_holds(verdict.first.predicted_interval, lab.truth.end_pin_wear_depth.value),
        end=_holds(verdict.first.measurement_interval, verdict.first.measured.value),
        curve=float(np.mean(inside)),
        places=tuple(bool(inside[place]) for place in at),
    )


def rows(material: str, correction: Correction, answers: Sequence[Held | str]) -> list[list[str]]:
    """Return a row for each thing that should be held; a laboratory without an answer holds nothing."""
    good, total = [one for one in answers if isinstance(one, Held)], len(answers)
    first, *others = (one.id for one in MATERIALS[material])
    table = [["true k_D", *share(sum(one.coefficient for one in good), total)]]
    kept = [one.runs[first] for one in good]
    table.append([f"true final depth, {first} (fitted), interval of the fitted law", *share(_true_ends(kept), total)])
    for other in others:
        kept = [one.runs[other] for one in good]
        table.append([f"true final depth, {other}, interval of the predicted wear", *share(_true_ends(kept), total)])
        table.append(
            [f"measured final depth, {other}, prediction interval", *share(sum(one.end for one in kept), total)]
        )
        for index, place in enumerate(PLACES):
            within = sum(one.places[index] for one in kept)
            table.append([f"measured curve, {other}, at {100 * place:.0f} % of the distance", *share(within, total)])
        mean = sum(one.curve for one in kept) / total
        table.append([f"measured curve, {other}, mean fraction within the band", "", f"{100 * mean:.1f} %", ""])
    return [[material, correction, *row] for row in table]


def _true_ends(kept: Sequence[RunHeld]) -> int:
    return sum(one.true_end for one in kept)


def spread(material: str, correction: Correction, answers: Sequence[Held | str]) -> list[str]:
    """Return how k_D scatters about the true one, beside its stated uncertainty."""
    good = [one for one in answers if isinstance(one, Held)]
    ratios = np.array([one.ratio for one in good])
    missed = [one for one in good if not one.coefficient]
    below = sum(one.below for one in missed)
    return [
        material,
        correction,
        f"{100 * float(np.mean(ratios) - 1):+.2f} %",
        f"{100 * float(np.median(ratios) - 1):+.2f} %",
        f"{100 * float(np.std(ratios, ddof=1)):.2f} %",
        f"{100 * statistics.median(one.uncertainty for one in good):.2f} %",
        str(below),
        str(len(missed) - below),
        str(len(answers) - len(good)),
    ]


def main() -> None:
    """Count, and print."""
    parser = arguments(__doc__ or "", labs=1000)
    with_blocks(parser)
    parser.add_argument("--corrections", nargs="+", choices=CORRECTIONS, default=CORRECTIONS)
    parser.add_argument("--materials", nargs="+", choices=tuple(MATERIALS), default=tuple(MATERIALS))
    options = parser.parse_args()
    report = Report("Coverage of k_D and of predictions", options)
    report.say(
        "The table lists how often 95 % intervals contain the true or measured value in simulated laboratories. "
        "Standard uncertainties: load 1 %, tip radius 0.2 %, moduli 2 % (drawn once per laboratory), speed and "
        "sensor scale 0.5 %, post-test wear depth 250 nm, wear depth of the disc 20 nm (Si3N4). Drift rates of up to "
        "15 nm/min and correlated noise are added. A laboratory without a k_D counts as not covered. The last column "
        "is the exact binomial 95 % interval."
    )
    cases = [(material, correction) for material in options.materials for correction in options.corrections]
    seeds = range(options.first_seed, options.first_seed + options.labs)
    tasks = (Task(*case, seed, options.block) for seed in seeds for case in cases)
    start = time.perf_counter()
    answers = in_parallel(held, tasks, options)
    done = len(answers) // len(cases)
    report.say(
        f"For each case, {done} laboratories were evaluated, in {(time.perf_counter() - start) / 60:.0f} minutes in "
        f"total; the Monte Carlo calculation used blocks of {options.block} draws."
    )
    table, spreads, reasons = [], [], set()
    for place, (material, correction) in enumerate(cases):
        mine = answers[place : done * len(cases) : len(cases)]
        table += rows(material, correction, mine)
        spreads.append(spread(material, correction, mine))
        reasons |= {f"* {material}, {correction}: {one}" for one in mine if isinstance(one, str)}
    report.table(["material", "correction", "quantity", "count", "fraction", "95 % CI"], table)
    report.say(
        "Relative deviation of k_D from the true value: mean, median and standard deviation over all laboratories, "
        "median of the calculated standard uncertainties, number of laboratories with the true k_D below or above the "
        "interval, and number of laboratories without a k_D."
    )
    head = [
        "material",
        "correction",
        "mean",
        "median",
        "scatter",
        "median u",
        "true value below",
        "true value above",
        "no k_D",
    ]
    report.table(head, spreads)
    if reasons:
        report.say("\n".join(["Reasons for a missing k_D:", "", *sorted(reasons)]))
    report.finish()


if __name__ == "__main__":
    main()

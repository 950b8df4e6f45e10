"""How often studies of twin-disc runs cover the true values and reject a law, over simulated laboratories.

    python benchmarks/disc_studies.py --labs 200 --jobs 2

Each laboratory makes the sample runs of Section 3.5 anew: 4 % slip at 100,000 to 1,000,000 rotations identifies k_D of
both discs; 10 % slip at 1,000,000 and 4 % slip at 2,000,000 rotations are predicted. Load 1 %, radii 0.1 and 0.2 %,
moduli 2 %, slip 1 % and sensor scale are off within what is stated, once a run, and each volume is off by 8 %. In the
last two rows both k_D change after 1,200,000 rotations: to three times (fatigue), and to a third.
"""

import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from labs import NO_ANSWER, PLAN, Report, arguments, draw_blocks_of, in_parallel, reason, share, with_blocks

from tribopipe.documents.plan import Fatigue, TwinDiscVirtualRun
from tribopipe.documents.recipe import Recipe, WearRecipe
from tribopipe.documents.study import Study
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.study.evaluate import evaluate
from tribopipe.evaluation.study.member import Member
from tribopipe.extras.simulate import VirtualTwinDiscTest
from tribopipe.physics.calculation_methods import DistanceConvention
from tribopipe.readers.harmonize import read_run
from tribopipe.results.study import AGREEMENT, BodyVerdict, LawResult, Verdict

(SERIES,) = PLAN.twin_disc_series
SAMPLES = {run.id: run for run in SERIES.runs}
FITTED = tuple(f"si3n4-twin-disc-4pct-{rotations}" for rotations in ("100k", "250k", "500k", "1000k"))
SLIPPING, LONG = "si3n4-twin-disc-10pct-1000k-a", "si3n4-twin-disc-4pct-2000k"
CHANGES = {SLIPPING: None, LONG: None, f"{LONG}-fatigue": 3.0, f"{LONG}-milder": 1 / 3}
"""What is predicted, and what both k_D are multiplied by late in it."""
OUTCOMES: tuple[Verdict, ...] = ("supported", "not decidable", "over-predicts", "under-predicts")
FALSE = OUTCOMES[2:]


@dataclass(frozen=True)
class Task:
    """One laboratory, and how it counts the sliding distance."""

    seed: int
    block: int
    convention: DistanceConvention


Answer = LawResult | str


def made(run: TwinDiscVirtualRun, folder: Path) -> Member:
    """Record a run within the laboratory's errors, and read it as a lab would."""
    series = SERIES.model_copy(update={"systematic_errors": True, "runs": (run,)})
    VirtualTwinDiscTest(series, run).write(folder / run.id)
    return Member(correct_drift(read_run(folder / run.id)), None)


def judged(task: Task) -> Answer:
    """Return the result of one laboratory's study; where it has none, why."""
    draw_blocks_of(task.block)
    rng = np.random.default_rng(np.random.SeedSequence([task.seed, 35]))
    runs = [SAMPLES[name].model_copy(update={"seed": int(rng.integers(2**31))}) for name in FITTED]
    for name, factor in CHANGES.items():
        sample = SAMPLES[SLIPPING if name == SLIPPING else LONG]
        fatigue = None if factor is None else Fatigue(from_rotations=1_200_000, factor=factor)
        update = {"id": name, "seed": int(rng.integers(2**31)), "fatigue": fatigue}
        runs.append(sample.model_copy(update=update))
    study = Study(id="labs", fit=FITTED, predict=tuple(CHANGES), laws=("archard",), shared=())
    recipe = Recipe(wear=WearRecipe(distance_per_rotation=task.convention))
    try:
        with tempfile.TemporaryDirectory() as folder:
            members = {run.id: made(run, Path(folder)) for run in runs}
        return evaluate(study, members, recipe).result.law("archard")
    except NO_ANSWER as error:
        return reason(error)


def held(labs: Sequence[LawResult]) -> list[list[str]]:
    """Return how often each k_D, and each volume predicted, lay in its 95 % interval."""
    truth = (SERIES.runs[0].curved_wear_coefficient.value, SERIES.runs[0].flat_wear_coefficient.value)
    rows = []
    for place, true in enumerate(truth):
        name = ("crowned disc", "cylindrical disc")[place]
        count = sum(
            low.value <= true <= high.value for low, high in ([*lab.bodies.values()][place].interval for lab in labs)
        )
        rows.append([f"k_D of the {name}", *share(count, len(labs))])
    for name in (SLIPPING, LONG):
        for place, disc in enumerate(("crowned disc", "cylindrical disc")):
            found = [_disc(lab, name, place) for lab in labs]
            count = sum(
                one.measurement_interval[0].value <= one.measured.value <= one.measurement_interval[1].value
                for one in found
            )
            rows.append([f"measured volume, {disc}, {name}", *share(count, len(labs))])
    return rows


def _disc(lab: LawResult, name: str, place: int) -> BodyVerdict:
    return [*next(run for run in lab.runs if run.id == name).bodies.values()][place]


def called(labs: Sequence[LawResult]) -> list[list[str]]:
    """Return how often each run was given each verdict."""
    rows = []
    for name in (*FITTED, *CHANGES):
        outcomes = [next(run for run in lab.runs if run.id == name).outcome for lab in labs]
        counts = [outcomes.count(one) for one in OUTCOMES]
        rows.append([name, *(f"{count} ({100 * count / len(labs):.1f} %)" for count in counts)])
    return rows


def main() -> None:
    """Count, and print."""
    parser = arguments(__doc__ or "", labs=200)
    with_blocks(parser)
    parser.add_argument(
        "--convention", default="full-slip", help="how the fit counts the sliding distance (%(default)s)"
    )
    options = parser.parse_args()
    report = Report("Twin-disc studies", options)
    start = time.perf_counter()
    seeds = range(options.first_seed, options.first_seed + options.labs)
    answers = in_parallel(judged, (Task(seed, options.block, options.convention) for seed in seeds), options)
    labs = [answer for answer in answers if not isinstance(answer, str)]
    minutes = (time.perf_counter() - start) / 60
    report.say(
        f"{len(answers)} laboratories were evaluated in {minutes:.0f} minutes; {len(labs)} have a result. The Monte "
        f"Carlo calculation used blocks of {options.block} draws. Convention for the sliding distance: full-slip in "
        f"the simulation, {options.convention} in the fit. The ranges are exact binomial 95 % intervals."
    )
    report.say("How often the 95 % intervals contain the true k_D and the measured wear volumes.")
    report.table(["quantity", "covered", "fraction", "95 % CI"], held(labs))
    sound = [name for name in (*FITTED, *CHANGES) if CHANGES.get(name) is None]
    raised = sum(any(run.outcome in FALSE for run in lab.runs if run.id in sound) for lab in labs)
    report.say(
        "Laboratories with a false alarm: the law is rejected for at least one of the six runs to which it applies."
    )
    report.table(
        ["quantity", "count", "fraction", "95 % CI"], [["laboratories with a false alarm", *share(raised, len(labs))]]
    )
    report.say("Agreement of each run with the law.")
    report.table(["run", *(AGREEMENT[one] for one in OUTCOMES)], called(labs))
    report.finish()


if __name__ == "__main__":
    main()

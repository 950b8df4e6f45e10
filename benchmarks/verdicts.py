"""How often a study rejects a law that holds, and one that does not, over simulated laboratories.

    python benchmarks/verdicts.py --labs 200 --jobs 2

(1) One k_D holds at all loads: Si3N4 fitted at 200 mN and predicted at 400 and 800 mN; WC-Co fitted at 400 mN and
predicted at 800, 1200 and 1600 mN. (2) k_D of Si3N4 is half as large at 800 mN as at 200 mN, where it was fitted.
`labs.py` says what varies; the end value of the pin is a scar diameter known to ±2 µm.
"""

import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from labs import (
    CORRECTIONS,
    NO_ANSWER,
    Planned,
    Report,
    arguments,
    draw_blocks_of,
    in_parallel,
    laboratory,
    planned,
    reason,
    recipe,
    share,
    with_blocks,
)

from tribopipe.documents.recipe import Correction
from tribopipe.documents.study import Study
from tribopipe.evaluation.study.evaluate import evaluate
from tribopipe.results.study import AGREEMENT, RunVerdict, Verdict

SI3N4, WC_CO, HALVED = "Si3N4, law holds", "WC-Co, law holds", "Si3N4, k_D halved at 800 mN"
CASES: dict[str, tuple[Planned, ...]] = {
    SI3N4: (planned("si3n4-air-200mN"), planned("si3n4-air-400mN"), planned("si3n4-air-800mN")),
    WC_CO: (
        planned("wc-co-water-400mN"),
        planned("wc-co-water-800mN"),
        planned("wc-co-water-1200mN"),
        planned("wc-co-water-1600mN"),
    ),
    HALVED: (planned("si3n4-air-200mN"), planned("si3n4-air-800mN", coefficient=0.5)),
}
"""The first run of each identifies k_D."""
OUTCOMES: tuple[Verdict, ...] = ("supported", "not decidable", "over-predicts", "under-predicts")
FALSE = ("over-predicts", "under-predicts")
UNLIKELY = 0.01


@dataclass(frozen=True)
class Task:
    """One laboratory and how it corrects drift."""

    case: str
    correction: Correction
    seed: int
    block: int


Answer = tuple[RunVerdict, ...] | str


def judged(task: Task) -> Answer:
    """Return the verdicts of one laboratory; where it has no k_D, why."""
    runs = CASES[task.case]
    draw_blocks_of(task.block)
    try:
        members = {name: one.member for name, one in laboratory(runs, task.seed).items()}
        study = Study(id="verdicts", fit=(runs[0].id,), predict=tuple(one.id for one in runs[1:]), laws=("archard",))
        return evaluate(study, members, recipe(task.correction)).result.law("archard").runs
    except NO_ANSWER as error:
        return reason(error)


def outcomes(case: str, correction: str, labs: Sequence[Answer]) -> list[list[str]]:
    """Return how often each verdict was given on each run."""
    table = []
    for place, run in enumerate(CASES[case]):
        found = [lab[place].outcome for lab in labs if not isinstance(lab, str)]
        role = "predicted" if place else "fitted"
        counts = [f"{found.count(one)} ({100 * found.count(one) / max(1, len(found)):.1f} %)" for one in OUTCOMES]
        table.append([case, correction, f"{run.id} ({role})", str(len(found)), *counts])
    return table


def alarms(case: str, correction: str, labs: Sequence[Answer]) -> list[list[str]]:
    """Return how often a law that holds was rejected."""
    answered = [lab for lab in labs if not isinstance(lab, str)]
    every = [one for lab in answered for one in lab]
    foretold = [one for one in every if one.role == "predicted"]
    raised = sum(any(one.outcome in FALSE for one in lab) for lab in answered)
    return [
        [case, correction, "laboratories with a false alarm", *share(raised, len(answered))],
        [case, correction, "ratings, all runs", *share(_false(every), len(every))],
        [case, correction, "ratings, predicted runs", *share(_false(foretold), len(foretold))],
    ]


def _false(verdicts: Iterable[RunVerdict]) -> int:
    return sum(one.outcome in FALSE for one in verdicts)


def rates(case: str, correction: str, labs: Sequence[Answer]) -> list[list[str]]:
    """Return how often each test was significant although the law holds."""
    every = [one for lab in labs if not isinstance(lab, str) for one in lab]
    foretold = [one for one in every if one.role == "predicted"]
    trends = [one.first.trend.p_value < UNLIKELY for one in every if one.first.trend]
    changes = [one.first.change_point.p_value < UNLIKELY for one in every if one.first.change_point]
    rows = [
        ["trend, p < 0.01, all runs (1 % expected)", *share(sum(trends), len(trends))],
        ["change point, p < 0.01, all runs (1 %)", *share(sum(changes), len(changes))],
        [
            "E_n beyond ±1 at the end, predicted runs (5 %)",
            *share(sum(abs(one.first.e_n) > 1 for one in foretold), len(foretold)),
        ],
        [
            "E_n beyond ±1 along the curve, predicted runs (5 %)",
            *share(sum(abs(one.first.e_n_all) > 1 for one in foretold), len(foretold)),
        ],
    ]
    return [[case, correction, *row] for row in rows]


def main() -> None:
    """Count, and print."""
    parser = arguments(__doc__ or "", labs=200)
    with_blocks(parser)
    options = parser.parse_args()
    report = Report("Agreement with a law: error rates", options)
    kinds: list[tuple[str, Correction]] = [(case, correction) for case in CASES for correction in CORRECTIONS]
    seeds = range(options.first_seed, options.first_seed + options.labs)
    tasks = (Task(*kind, seed, options.block) for seed in seeds for kind in kinds)
    start = time.perf_counter()
    answers = in_parallel(judged, tasks, options)
    done = len(answers) // len(kinds)
    report.say(
        f"For each case, {done} laboratories were evaluated, in {(time.perf_counter() - start) / 60:.0f} minutes in "
        f"total; the Monte Carlo calculation used blocks of {options.block} draws. The ranges are exact binomial 95 % "
        "intervals."
    )
    by_kind = {kind: answers[place : done * len(kinds) : len(kinds)] for place, kind in enumerate(kinds)}
    report.say("False alarms if the same k_D applies at all loads (target: at most 5 % of laboratories).")
    sound = {kind: labs for kind, labs in by_kind.items() if kind[0] != HALVED}
    head = ["case", "correction"]
    report.table(
        [*head, "quantity", "count", "fraction", "95 % CI"],
        [row for kind, labs in sound.items() for row in alarms(*kind, labs)],
    )
    report.say("Detection of a law that does not hold: k_D of Si3N4 halves at 800 mN (target: detected in 95 %).")
    found = []
    for (case, correction), labs in by_kind.items():
        if case == HALVED:
            said = [lab[1].outcome for lab in labs if not isinstance(lab, str)]
            found.append([case, correction, *share(said.count("over-predicts"), len(labs))])
    report.table([*head, AGREEMENT["over-predicts"], "fraction", "95 % CI"], found)
    report.say("Agreement of each run with the law.")
    verdicts = [row for kind, labs in by_kind.items() for row in outcomes(*kind, labs)]
    report.table([*head, "run", "results", *(AGREEMENT[one] for one in OUTCOMES)], verdicts)
    report.say("Additional significance tests if the law holds.")
    report.table(
        [*head, "test", "count", "fraction", "95 % CI"],
        [row for kind, labs in sound.items() for row in rates(*kind, labs)],
    )
    reasons = {
        f"* {kind[0]}, {kind[1]}: {lab}" for kind, labs in by_kind.items() for lab in labs if isinstance(lab, str)
    }
    if reasons:
        report.say("\n".join(["Laboratories without a result:", "", *sorted(reasons)]))
    report.finish()


if __name__ == "__main__":
    main()

"""Runs followed while they go on: how often the intervals hold the truth, false alarms, delays, and what a look costs.

    python benchmarks/live.py --labs 200 --jobs 2

`labs.py` says what varies from laboratory to laboratory. Each run is cut off at shares of its planned 500 m, as if the
test had come so far, its end value unknown; and it is looked at every 10 m for alarms, as recorded, and with something
that changes at 250 m. Exit code 1 where intervals hold the truth too seldom or do not narrow, where sound runs alarm in
more than 1 %, or where a doubled k_D is missed.
"""

import argparse
import pickle
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from labs import LabRun, Planned, Report, arguments, in_parallel, laboratory, planned, share
from scipy.stats import binomtest

from tribopipe.base.arrays import Column
from tribopipe.base.errors import FitError
from tribopipe.documents.manifest import EndValues
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.signals import SignalName
from tribopipe.evaluation.wear.scenario import KnownWear, Scenario
from tribopipe.extras.live.alarms import counterbody_alarms, departure
from tribopipe.extras.live.estimate import posterior
from tribopipe.extras.live.problem import Asked, Known, live_problem
from tribopipe.extras.live.state import State
from tribopipe.physics.uncertainty import TAILS
from tribopipe.results.run import RawRun

END = 500.0
"""Planned sliding distance, m."""
SHARES = (0.1, 0.25, 0.5, 1.0)
LOOKS = 50
HALF = 250.0
"""Sliding distance, m, at which something changes."""
BEFORE = 200.0
"""Sliding distance, m, from which a run that changes is looked at."""
RUNS: dict[str, Planned] = {"Si3N4, 200 mN": planned("si3n4-air-200mN"), "WC-Co, 400 mN": planned("wc-co-water-400mN")}
DRIFT = Quantity(value=0.0, unit="m/s", standard_uncertainty=15e-9 / 60 / 3**0.5)
DISC = Quantity(value=0.0, unit="m", standard_uncertainty=250e-9)
"""Stated, lest the contribution of an unseen groove, which is none of the reading, hide the others."""
KNOWN = {"nothing": Known(disc_wear=DISC), "drift 0 ± 9 nm/min": Known(drift_rate=DRIFT, disc_wear=DISC)}
NM_PER_MIN = 1e-9 / 60
Columns = Mapping[SignalName, Column]


@dataclass(frozen=True)
class Held:
    """What the intervals of one run hold at one share, and their half-widths: k_D relative, the end depth in m."""

    coefficient: bool
    depth: bool
    widths: tuple[float, ...]


def _unended(lab: LabRun) -> RawRun:
    """Return a run whose end values nobody knows yet."""
    run = lab.corrected.run
    return replace(run, manifest=run.manifest.model_copy(update={"end_values": EndValues()}))


def _until(columns: Columns, first: int, last: int) -> dict[SignalName, Column]:
    return {name: values[first:last] for name, values in columns.items()}


def held(task: tuple[str, str, int]) -> dict[float, Held]:
    """Follow one run of a laboratory, and say what its intervals hold."""
    material, known, seed = task
    (lab,) = laboratory([RUNS[material]], seed).values()
    run, asked = _unended(lab), Asked(_unended(lab), known=KNOWN[known], planned=END)
    true_k, true_end = lab.truth.wear_coefficient.value, lab.truth.end_pin_wear_depth.value
    found = {}
    for part in SHARES:
        state = State()
        state.add(_until(run.columns, 0, round(part * len(run))))
        told = posterior(live_problem(asked, state), asked.recipe.monte_carlo)
        ends = [np.quantile(drawn, TAILS) for drawn in (told.coefficient / true_k, told.depth(END))]
        k, depth = (bool(low <= true <= high) for (low, high), true in zip(ends, (1.0, true_end), strict=True))
        found[part] = Held(k, depth, tuple(float(high - low) / 2 for low, high in ends))
    return found


def _sound(run: RawRun, _: LabRun) -> Columns:
    return run.columns


def _worn(run: RawRun, lab: LabRun, factor: float) -> Columns:
    """Let k_D be another one from half-way on."""
    manifest = run.manifest
    scenario = Scenario(
        manifest.described, manifest.conditions.normal_load, KnownWear({"pin": lab.truth.wear_coefficient})
    )
    further = run.sliding_distance + (factor - 1) * np.maximum(run.sliding_distance - HALF, 0.0)
    added = scenario.worn(further)["wear_depth"] - scenario.worn(run.sliding_distance)["wear_depth"]
    return {**run.columns, "depth": run.columns["depth"] + added}


def _drifting(run: RawRun, _: LabRun) -> Columns:
    """Let the sensor drift otherwise from half-way on."""
    time = run.columns["time"]
    late = np.maximum(time - np.interp(HALF, run.sliding_distance, time), 0.0)
    return {**run.columns, "depth": run.columns["depth"] + 30 * NM_PER_MIN * late}


def _slipping(run: RawRun, _: LabRun) -> Columns:
    """Let the sensor slip by 0.5 µm half-way."""
    return {**run.columns, "depth": run.columns["depth"] - 0.5e-6 * (run.sliding_distance > HALF)}


CHANGES: dict[str, Callable[[RawRun, LabRun], Columns]] = {
    "none": _sound,
    "k_D × 2 at 250 m": lambda run, lab: _worn(run, lab, 2.0),
    "k_D × 1.2 at 250 m": lambda run, lab: _worn(run, lab, 1.2),
    "drift + 30 nm/min at 250 m": _drifting,
    "sensor slips by 0.5 µm at 250 m": _slipping,
}


MUST_BE_SEEN = ("Si3N4, 200 mN", "k_D × 2 at 250 m")


def noticed(task: tuple[str, str, int]) -> float | None:
    """Return the sliding distance, m, at the look that alarms first; none where none does."""
    material, change, seed = task
    (lab,) = laboratory([RUNS[material]], seed).values()
    run = _unended(lab)
    columns, asked, state = CHANGES[change](run, lab), Asked(run, planned=END), State()
    bounds = np.linspace(0, len(run), LOOKS + 1).round().astype(int).tolist()
    if change != "none":
        del bounds[1 : round(LOOKS * BEFORE / END)]  # until then it is as a sound run
    for first, last in pairwise(bounds):
        state.add(_until(columns, first, last))
        try:
            told = posterior(live_problem(asked, state), asked.recipe.monte_carlo)
        except FitError:
            continue
        worn = change == "none" and any(counterbody_alarms(told))
        if worn or departure(told, run.manifest, state, END) is not None:
            return float(run.sliding_distance[last - 1])
    return None


def coverage(report: Report, options: argparse.Namespace) -> bool:
    """Tell how often intervals hold the truth; return whether it is often enough, and whether they narrow."""
    kinds = [(material, known) for material in RUNS for known in KNOWN]
    seeds = range(options.first_seed, options.first_seed + options.labs)
    answers = in_parallel(held, [(*kind, seed) for seed in seeds for kind in kinds], options)
    done, table, sound = len(answers) // len(kinds), [], True
    for place, kind in enumerate(kinds):
        mine = answers[place : done * len(kinds) : len(kinds)]
        widths = np.median([[one[part].widths for part in SHARES] for one in mine], axis=0)
        sound = sound and bool(np.all(np.diff(widths, axis=0) < 0))
        for row, part in enumerate(SHARES):
            counts = [sum(getattr(one[part], name) for one in mine) for name in ("coefficient", "depth")]
            sound = sound and all(binomtest(count, done).proportion_ci(0.95).high >= 0.94 for count in counts)
            told = [" ".join(share(count, done)[1:]) for count in counts]
            width, depth = widths[row]
            table.append([*kind, f"{100 * part:.0f} %", *told, f"±{100 * width:.3g} %", f"±{1e6 * depth:.3g} µm"])
    report.say(f"Fraction of {done} runs whose 95 % interval contains the true value, and its median half-width.")
    head = ["run", "known", "distance", "true k_D", "true depth at 500 m", "k_D", "depth at 500 m"]
    report.table(head, table)
    return sound


def alarms(report: Report, options: argparse.Namespace) -> bool:
    """Tell how often the law is said not to hold, and how late; return whether that is as it should be."""
    kinds = [(material, change) for material in RUNS for change in CHANGES]
    seeds = range(options.first_seed, options.first_seed + options.labs)
    answers = in_parallel(noticed, [(*kind, seed) for seed in seeds for kind in kinds], options)
    done, table, sound = len(answers) // len(kinds), [], True
    for place, (material, change) in enumerate(kinds):
        mine = answers[place : done * len(kinds) : len(kinds)]
        found = [at for at in mine if at is not None]
        if change == "none":
            sound = sound and binomtest(len(found), done).proportion_ci(0.95).low <= 0.01
            table.append([material, change, " ".join(share(len(found), done)[1:]), "", "", ""])
            continue
        late = [at - HALF for at in found if at > HALF]
        if (material, change) == MUST_BE_SEEN:
            sound = sound and len(late) >= 0.95 * done
        median, most = (f"{np.quantile(late, q):.0f} m" if late else "" for q in (0.5, 0.95))
        table.append([material, change, "", share(len(late), done)[1], median, most])
    report.say(
        f"Alarms of {done} runs looked at every {END / LOOKS:.0f} m, by the CUSUM that is to alarm in 1 % of tests; of "
        "runs without a change also by the drift that no sensor has."
    )
    head = ["run", "change", "false alarms", "noticed", "after (median)", "after (95 % of the noticed)"]
    report.table(head, table)
    return sound


def cost(report: Report, options: argparse.Namespace) -> bool:
    """Tell what a look costs as a run grows; return whether it stays the same."""
    (lab,) = laboratory([RUNS["Si3N4, 200 mN"]], 1).values()
    run, rng = _unended(lab), np.random.default_rng(1)
    asked, state, table, looks = Asked(run, planned=END), State(), [], []
    piece, goal = 100_000, 100_000
    while state.samples < options.samples:
        along = (state.samples + np.arange(1, piece + 1)) / options.samples * END
        depth = 1e-6 * np.sqrt(along) + 1e-7 * rng.standard_normal(piece)
        state.add({"time": along / 0.4, "sliding_distance": along, "depth": depth})
        if state.samples >= goal:
            looks.append(_look(asked, state))
            kept = len(pickle.dumps(state)) / 2**20
            table.append([f"{state.samples:,}", f"{1e3 * looks[-1]:.0f} ms", f"{kept:.2f} MB"])
            goal *= 10
    report.say("A look at samples that are there: time (the fastest of five), and what is kept of them.")
    report.table(["samples", "estimate and alarms", "kept"], table)
    return looks[-1] < 3 * looks[0]


def _look(asked: Asked, state: State) -> float:
    took: Sequence[float] = []
    for _ in range(5):
        start = time.perf_counter()
        told = posterior(live_problem(asked, state), asked.recipe.monte_carlo)
        told.depth(END), told.coefficient, departure(told, asked.run.manifest, state, END)
        took = [*took, time.perf_counter() - start]
    return min(took)


def main() -> None:
    """Follow, and print."""
    parser = arguments(__doc__ or "", labs=200)
    parser.add_argument("--samples", type=int, default=10_000_000, help="of the longest run looked at (%(default)s)")
    options = parser.parse_args()
    report = Report("Runs followed while they go on", options)
    sound = [part(report, options) for part in (coverage, alarms, cost)]
    report.finish()
    sys.exit(0 if all(sound) else 1)


if __name__ == "__main__":
    main()

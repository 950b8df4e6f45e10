"""Simulated laboratories: runs of sample_runs/plan.toml with errors drawn anew in each, and how results are written.

A laboratory draws its zero offsets (0.5–2.5 µm), drift rates (±15 nm/min) and noise run by run. Load, tip radius,
sliding speed and sensor scale of each run are off within what the plan states for them (`systematic_errors`). The
moduli are those of the material, so they are drawn once for all runs of a laboratory, as a study takes them by default.
What the laboratory knows is its manifest, with nominal values, and a sliding distance that is nominal speed times time.
"""

import argparse
import math
import os
import platform
import re
import shlex
import sys
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import partial
from itertools import takewhile
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.random import Generator
from pydantic import ValidationError
from scipy.stats import binomtest

from tribopipe import __version__
from tribopipe.base.errors import TribopipeError
from tribopipe.base.executor import Crew, as_done
from tribopipe.documents.contact import SlidingPin
from tribopipe.documents.plan import Plan, Series, Truth, VirtualRun
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Correction, Recipe, WearRecipe
from tribopipe.documents.record import load_toml
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.study.member import Member
from tribopipe.extras.simulate import VirtualTest
from tribopipe.extras.sweep.virtual_tests import recorded_run
from tribopipe.physics import uncertainty
from tribopipe.results.run import CorrectedRun

PLAN = load_toml(Path(__file__).parents[1] / "sample_runs" / "plan.toml", Plan)
SAMPLES: dict[str, tuple[Series, VirtualRun]] = {run.id: (series, run) for series in PLAN.series for run in series.runs}
CORRECTIONS: tuple[Correction, ...] = ("two-step", "model")
_ZERO_OFFSET = (0.5e-6, 2.5e-6)
_DRIFT_RATE = 15e-9 / 60

NO_ANSWER = (TribopipeError, ValidationError)
"""What a laboratory runs into that has no k_D; a loss below zero is refused with its manifest already."""

Task = TypeVar("Task")
Answer = TypeVar("Answer")


@dataclass(frozen=True)
class Planned:
    """One run that every laboratory makes."""

    sample: str
    """Run of the plan that it is made after."""
    id: str
    """Its own name."""
    coefficient: float = 1.0
    """Its true k_D over that of the series' first run."""


@dataclass(frozen=True)
class LabRun:
    """One run of a laboratory: what was recorded, corrected for drift, and what was true."""

    corrected: CorrectedRun
    truth: Truth

    @property
    def member(self) -> Member:
        """The run as it enters a study of Archard's law."""
        return Member(self.corrected, None)


def planned(sample: str, suffix: str = "", coefficient: float = 1.0) -> Planned:
    """Plan a run after one of the sample runs."""
    return Planned(sample, sample + suffix, coefficient)


def laboratory(plan: Iterable[Planned], seed: int, sensors: Mapping[str, object] | None = None) -> dict[str, LabRun]:
    """Make the runs of one laboratory, by their names, with its sensors changed where told."""
    rng = np.random.default_rng(np.random.SeedSequence([seed, 2006]))
    runs: dict[str, LabRun] = {}
    moduli: tuple[float, float] | None = None
    for one in plan:
        series, sample = SAMPLES[one.sample]
        if moduli is None:
            moduli = _moduli(series.contact, rng)
        instrument = series.sensors.model_copy(update=dict(sensors or {}))
        series = series.model_copy(update={"sensors": instrument, "systematic_errors": True})
        run = sample.model_copy(update=_drawn(one, series, rng))
        runs[one.id] = _recorded(series, run, moduli)
    return runs


def _moduli(contact: SlidingPin, rng: Generator) -> tuple[float, float]:
    pin, disc = contact.pin.youngs_modulus, contact.counterbody.youngs_modulus
    true = [one.value + (one.standard_uncertainty or 0.0) * float(rng.standard_normal()) for one in (pin, disc)]
    return true[0], true[1]


def _drawn(one: Planned, series: Series, rng: Generator) -> dict[str, object]:
    coefficient = series.runs[0].wear_coefficient
    return {
        "id": one.id,
        "seed": int(rng.integers(2**31)),
        "wear_coefficient": Quantity(value=one.coefficient * coefficient.value, unit=coefficient.unit),
        "zero_offset": Quantity(value=float(rng.uniform(*_ZERO_OFFSET)), unit="m"),
        "drift_rate": Quantity(value=float(rng.uniform(-_DRIFT_RATE, _DRIFT_RATE)), unit="m/s"),
    }


def _recorded(series: Series, run: VirtualRun, moduli: tuple[float, float]) -> LabRun:
    """Run the virtual test with the laboratory's true moduli, which its manifest does not know."""
    pin, other = ({"youngs_modulus": Quantity(value=true, unit="Pa", standard_uncertainty=0.0)} for true in moduli)
    contact = series.contact
    true_contact = contact.with_bodies(contact.pin.model_copy(update=pin), contact.counterbody.model_copy(update=other))
    test = VirtualTest(series.model_copy(update={"contact": true_contact}), run)
    return LabRun(correct_drift(recorded_run(series, test)), test.truth())


def reason(error: Exception) -> str:
    """Say in one line, without its numbers, why there is no answer."""
    text = error.errors()[0]["msg"] if isinstance(error, ValidationError) else str(error)
    return re.sub(r"[-−]?\d[\d.]*", "…", text)


def height_loss(spread: float) -> dict[str, object]:
    """Return sensors that measure the height lost by the pin with a standard uncertainty, m."""
    loss = Quantity(value=spread, unit="m")
    return {"pin_end_value": "pin_wear_depth", "height_loss_uncertainty": loss}


def recipe(correction: Correction) -> Recipe:
    """Return the default recipe with one of the two corrections."""
    return Recipe(wear=WearRecipe(correction=correction))


def in_parallel(work: Callable[[Task], Answer], tasks: Iterable[Task], options: argparse.Namespace) -> list[Answer]:
    """Do tasks as ``--jobs`` or ``--scheduler`` say; return the answers of those begun within ``--minutes``, in order.

    Raises ``TribopipeError`` where a task fails.
    """
    end = math.inf if options.minutes is None else time.monotonic() + 60 * options.minutes
    begun = takewhile(lambda _: time.monotonic() <= end, enumerate(tasks))
    answers: dict[int, Answer] = {}
    for (place, _), answer in as_done(partial(_numbered, work), begun, Crew(options.jobs, options.scheduler, print)):
        if isinstance(answer, TribopipeError):
            raise answer
        answers[place] = answer
    return [answers[place] for place in sorted(answers)]


def _numbered(work: Callable[[Task], Answer], task: tuple[int, Task]) -> Answer:
    return work(task[1])


def draw_blocks_of(count: int) -> None:
    """Draw as many values at a time in this process; a Monte Carlo takes at least two such blocks."""
    uncertainty.BLOCK = count


def arguments(description: str, labs: int | None = None) -> argparse.ArgumentParser:
    """Return a parser of what all benchmarks understand."""
    parser = argparse.ArgumentParser(description=description.partition("\n")[0])
    parser.add_argument("--write", type=Path, metavar="PATH", help="write the result as Markdown")
    if labs is not None:
        parser.add_argument("--labs", type=int, default=labs, help="number of laboratories (%(default)s)")
        parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="processes (%(default)s)")
        parser.add_argument(
            "--scheduler", metavar="ADDRESS", help='Dask scheduler, or "local"; its workers need PYTHONPATH=benchmarks'
        )
        parser.add_argument("--first-seed", type=int, default=1, help="seed of the first one (%(default)s)")
        parser.add_argument("--minutes", type=float, help="begin no laboratory after so many minutes")
    return parser


def with_blocks(parser: argparse.ArgumentParser) -> None:
    """Let the command line choose a smaller Monte Carlo, which is faster and has noisier ends of intervals."""
    parser.add_argument("--block", type=int, default=uncertainty.BLOCK, help="draws in a block (%(default)s)")


def share(count: int, total: int) -> list[str]:
    """Return a count as cells of a table: how many, per cent, and the exact binomial 95 % interval of that."""
    if not total:
        return ["0 of 0", "", ""]
    within = binomtest(count, total).proportion_ci(0.95)
    return [f"{count} of {total}", f"{100 * count / total:.1f} %", f"{100 * within.low:.1f}–{100 * within.high:.1f} %"]


class Report:
    """A result, printed as it comes and written as Markdown at the end."""

    def __init__(self, title: str, options: argparse.Namespace) -> None:
        self._options = options
        self._parts = [f"# {title}"]
        self.say("\n".join(self._origin()))

    def _origin(self) -> list[str]:
        words = [word for word in sys.argv[1:] if word != "--"]
        if "--write" in words:
            place = words.index("--write")
            del words[place : place + 2]
        given = vars(self._options)
        lines = [f"* Command: `{shlex.join(['python', f'benchmarks/{Path(sys.argv[0]).name}', *words])}`"]
        if "labs" in given:
            first, labs = given["first_seed"], given["labs"]
            lines.append(f"* Laboratories: {labs} simulated, seeds {first} to {first + labs - 1}")
        return [
            *lines,
            f"* Date: {datetime.now(UTC):%Y-%m-%d}",
            f"* tribopipe {__version__}, Python {platform.python_version()}, numpy {np.__version__}",
            f"* Machine: {platform.machine()}, {os.cpu_count()} processors",
        ]

    def say(self, text: str) -> None:
        """Add a paragraph."""
        self._parts.append(text)
        print(text, end="\n\n", flush=True)

    def table(self, head: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
        """Add a table."""
        cells = [list(head), *(list(row) for row in rows)]
        widths = [max(len(row[column]) for row in cells) for column in range(len(head))]
        lines = [[cell.ljust(width) for cell, width in zip(row, widths, strict=True)] for row in cells]
        lines.insert(1, ["-" * width for width in widths])
        self.say("\n".join(f"| {' | '.join(line)} |" for line in lines))

    def finish(self) -> None:
        """Write what was said where the command line wants it."""
        if self._options.write is not None:
            self._options.write.write_text("\n\n".join(self._parts) + "\n", encoding="utf-8")

"""Tests of a plan recorded on the virtual tribometer again and again, each evaluated with its truth.

A virtual test stands in memory as if its run folder had been written and ingested.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TypeAlias, cast

from pydantic import ValidationError

from tribopipe.archive.provenance import digest
from tribopipe.base.arrays import Column
from tribopipe.base.errors import FitError, ManifestError, did_you_mean
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.plan import Plan, Series, TwinDiscSeries, TwinDiscVirtualRun, VirtualRun
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.documents.record import Record, first_problem, load_toml
from tribopipe.documents.signals import SignalName
from tribopipe.documents.sweep import Sweep, VirtualTests
from tribopipe.evaluation.derived_columns import derive_missing
from tribopipe.extras.simulate import VirtualTest, VirtualTwinDiscTest
from tribopipe.extras.simulate.instrument import AnyVirtualTest
from tribopipe.extras.sweep.cases import Case, Ensemble, Head, Row, combinations, label_heads, refuse_endless
from tribopipe.extras.sweep.choices import FIT_NUMBERS, Choice, fit_rows, fitted
from tribopipe.extras.sweep.subject import Parameter, Settings, Subject, generator, parameters
from tribopipe.results.run import Origin, RawRun
from tribopipe.version import VERSION


def recorded_run(series: Series | TwinDiscSeries, test: AnyVirtualTest) -> RawRun:
    """Return a virtual test as ingested; a distance that was not counted follows from the nominal speed."""
    columns, ends = test.record()
    slid: dict[SignalName, Column] = {}
    if isinstance(series, Series):
        slid["sliding_distance"] = series.sliding_speed.value * test.time
    manifest = series.manifest(test.run, ends)  # type: ignore[arg-type]  # the test is of this series
    signals = cast("dict[SignalName, Column]", {**columns, **slid})
    origins: dict[SignalName, Origin] = dict.fromkeys(signals, "measured")
    origins |= dict.fromkeys(slid, "derived from nominal speed")
    derive_missing(signals, origins, manifest)
    return RawRun(manifest, signals, origins, {}, {}, ())


TRUTH = Head("true_wear_coefficient", "m^2/N")
NUMBERS = (*FIT_NUMBERS, TRUTH)
_SEED = "run.seed"


class PinTest(Record):
    """One test of a pin, and how it is evaluated."""

    series: Series
    """Series of the plan."""
    run: VirtualRun
    """Run of the series."""
    recipe: Recipe
    """Recipe."""
    law: LawName
    """Wear law by which k_D is sought."""

    def recorded(self) -> tuple[RawRun, dict[str, Quantity]]:
        """Return the run as ingested, and the true k_D of each body."""
        test = VirtualTest(self.series, self.run)
        coefficients = (self.run.wear_coefficient, self.run.disc_wear_coefficient)
        bodies = zip(self.series.contact.body_names, coefficients, strict=True)
        return recorded_run(self.series, test), {spoken(body): k for body, k in bodies if k is not None}


class DiscTest(Record):
    """One test of two discs, and how it is evaluated."""

    series: TwinDiscSeries
    """Series of the plan."""
    run: TwinDiscVirtualRun
    """Run of the series."""
    recipe: Recipe
    """Recipe."""
    law: LawName
    """Wear law by which k_D is sought."""

    def recorded(self) -> tuple[RawRun, dict[str, Quantity]]:
        """Return the run as ingested, and the true k_D of each body."""
        test = VirtualTwinDiscTest(self.series, self.run)
        true = {"crowned disc": self.run.curved_wear_coefficient, "cylindrical disc": self.run.flat_wear_coefficient}
        return recorded_run(self.series, test), true


AnyTest: TypeAlias = PinTest | DiscTest


def virtual_tests(sweep: Sweep, asked: VirtualTests, beside: Path, recipe: Recipe, where: str) -> Ensemble:
    """Return the cases of every test in every combination.

    Raises ``ManifestError`` where the plan, a key or a value is wrong.
    """
    if _SEED in sweep.vary:
        raise ManifestError(
            f"{where}: vary.{_SEED}: found a seed; expected no seed, since each repeat has its own; remove this "
            "key, and use the keys repeats and seed instead"
        )
    varied: tuple[Parameter, ...] = ()
    cases, repeats = [], sweep.repeats or 1
    subjects = _subjects(beside / asked.plan, asked, recipe, where)
    for run_id, subject in subjects.items():
        varied = parameters(sweep.vary, subject)
        refuse_endless(varied, repeats * len(subjects), where)
        made_from = digest(VERSION, subject.base)
        for one in combinations(varied, repeats, sweep.seed):
            seed = int(generator(sweep.seed, one.repeat, run_id).integers(2**31))
            settings = {**one.settings, _SEED: seed}
            cases.append(Case(one.labels(run_id), digest(made_from, settings)[:16], partial(tested, subject, settings)))
    return Ensemble(label_heads(varied, sweep.repeats), NUMBERS, cases)


def _subjects(path: Path, asked: VirtualTests, recipe: Recipe, where: str) -> dict[str, Subject[AnyTest]]:
    """Return the runs of the plan that are asked for, by their ids."""
    there = dict(_planned(load_toml(path, Plan), recipe, where))
    unknown = next((run_id for run_id in asked.runs if run_id not in there), None)
    if unknown is not None:
        raise ManifestError(
            f"{where}: virtual_tests.runs: found {unknown!r}, which is not a run of {path}; "
            f"{did_you_mean(unknown, there)}"
        )
    return {run_id: there[run_id] for run_id in asked.runs or there}


def _planned(plan: Plan, recipe: Recipe, where: str) -> Iterator[tuple[str, Subject[AnyTest]]]:
    kinds: tuple[tuple[type[AnyTest], tuple[Series | TwinDiscSeries, ...]], ...] = (
        (PinTest, plan.series),
        (DiscTest, plan.twin_disc_series),
    )
    for kind, many in kinds:
        for series in many:
            alone = series.model_copy(update={"systematic_errors": True, "runs": series.runs[:1]})
            for run in series.runs:
                test = kind.model_construct(series=alone, run=run, recipe=recipe, law=series.law)
                yield run.id, Subject(kind, test.model_dump(mode="json", by_alias=True), where)


def tested(subject: Subject[AnyTest], settings: Settings) -> list[Row]:
    """Record one test and evaluate it; where it has no k_D, the row states why.

    Raises ``TribopipeError`` where there can be no such test.
    """
    test = subject.changed(settings)
    try:
        run, true = test.recorded()
        fit = fitted(run, Choice(recipe=test.recipe, law=test.law))
    except FitError as error:
        return [Row("", "not fitted", {}, str(error))]
    except ValidationError as error:  # an end value that no manifest takes, such as a loss below zero
        return [Row("", "not fitted", {}, first_problem(error, RunManifest))]
    return [
        replace(row, found={**row.found, TRUTH.name: true[row.body]} if row.body in true else row.found)
        for row in fit_rows(fit)
    ]

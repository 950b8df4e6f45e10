"""What tribopipe makes of a simulated run, held against what was true. The one place that knows tribopipe."""

import time
import zlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from pydantic import ValidationError

from independent.bench_cases import CASES
from independent.noise import Column
from independent.regimes import REGIMES
from independent.runs import Recorded, Truth, simulate
from tribopipe.base.errors import TribopipeError
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe
from tribopipe.documents.signals import SIGNALS, SignalName
from tribopipe.documents.study import Study
from tribopipe.evaluation.checks.registry import check_run
from tribopipe.evaluation.derived_columns import derive_missing
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.friction import fit_friction
from tribopipe.evaluation.measurements.specific_wear import specific_wear
from tribopipe.evaluation.preprocessing.cleaning import clean_run
from tribopipe.evaluation.study.evaluate import evaluate
from tribopipe.evaluation.study.member import Member
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.results.evaluation import COVERAGE_FACTOR, FrictionFit
from tribopipe.results.run import CorrectedRun, Origin, RawRun
from tribopipe.results.wear_fit import WearFit

_FAR = 3.0
"""Standard uncertainties from which a number is wrong."""
Task = tuple[str, int, int, bool]
"""Name of a regime or bench case, seed, number of the run, and whether a study is to judge it."""


@dataclass(frozen=True)
class Outcome:
    """One run: its k_D and what was said about it."""

    ratio: float
    """k_D over the true one."""
    spread: float
    """Stated relative standard uncertainty."""
    interval: tuple[float, float]
    """95 % interval over the true k_D."""
    flags: tuple[str, ...]
    """Codes of warnings and errors."""
    friction: dict[str, bool] | None
    """Whether the intervals of A, b and c hold them; none where no exponential was fitted."""
    drift: bool | None
    """Whether the interval of the drift rate holds it."""
    against_rate: float | None
    """k_D less the specific wear rate of the post-test measurement, over the uncertainty of the difference at most."""
    verdict: str | None
    cpu: float
    """Time of the fit, s."""

    @property
    def held(self) -> bool:
        """Whether the interval holds the true k_D."""
        return self.interval[0] <= 1 <= self.interval[1]

    def beyond(self, factor: float) -> bool:
        """Say whether k_D is off by more than so many stated standard uncertainties."""
        return abs(self.ratio - 1) > factor * self.spread

    @property
    def silent(self) -> bool:
        """Whether k_D is wrong and nothing says so."""
        return self.beyond(_FAR) and not self.flags

    @property
    def contradicts(self) -> bool:
        """Whether k_D and the post-test rate differ and nothing says so."""
        return self.against_rate is not None and abs(self.against_rate) > _FAR and not self.flags


def raw_run(recorded: Recorded) -> RawRun:
    """Return a run as ingested from its files."""
    manifest = RunManifest.model_validate(recorded.document)
    columns = cast("dict[SignalName, Column]", dict(recorded.columns))
    origins: dict[SignalName, Origin] = dict.fromkeys(columns, "measured")
    derive_missing(columns, origins, manifest)
    ordered = {name: columns[name] for name in SIGNALS if name in columns}
    return RawRun(manifest, ordered, origins, {}, {}, ())


def outcomes(task: Task) -> list[Outcome | str]:
    """Simulate and evaluate one run, or the runs of one bench case; a string says why there is no k_D."""
    name, seed, number, judged = task
    rng = np.random.default_rng(np.random.SeedSequence([seed, zlib.crc32(name.encode()), number]))
    if name in REGIMES:
        return [outcome(simulate(REGIMES[name], rng), REGIMES[name].law, judged=judged)]
    runs = CASES[name](rng)
    found = [outcome(one, "archard", judged=judged) for one in runs]
    return found if len(runs) == 1 else [*found, together(runs)]


def outcome(recorded: Recorded, law: str, *, judged: bool) -> Outcome | str:
    """Evaluate one run as `process` does."""
    try:
        raw, recipe = raw_run(recorded), Recipe()
        corrected = correct_drift(clean_run(raw, recipe).run, recipe)
        friction = fit_friction(corrected.run, recipe.friction)
        begun = time.process_time()
        fit = fit_wear(corrected, law, friction, recipe)
        cpu = time.process_time() - begun
        flags = tuple(sorted({*_codes(check_run(raw)), *_codes(_findings(corrected.correction, friction, fit))}))
        rate = specific_wear(corrected.run, recipe).pin
        verdict = _verdict(corrected, friction, law, recipe) if judged else None
    except Exception as error:  # noqa: BLE001 - a crash is an answer to be counted, too
        return _reason(error)
    if (pin := fit.first) is None:
        return f"missing {', '.join(fit.missing)}"
    true = recorded.truth.coefficient
    measured = None if law != "archard" or rate is None else rate.specific_wear_rate
    return Outcome(
        ratio=pin.wear_coefficient.value / true,
        spread=_spread(pin.wear_coefficient) / true,
        interval=(pin.interval[0].value / true, pin.interval[1].value / true),
        flags=flags,
        friction=_friction_held(friction, recorded.truth),
        drift=_drift_held(corrected, fit, recorded.truth.drift),
        against_rate=None if measured is None else _apart(pin.wear_coefficient, measured),
        verdict=verdict,
        cpu=cpu,
    )


def together(runs: Sequence[Recorded]) -> Outcome | str:
    """Evaluate replicates as a study; what is true of it is the mean of their coefficients."""
    recipe, members = Recipe(), {}
    try:
        for place, one in enumerate(runs):
            raw = raw_run(one)
            name = f"{raw.id}-{place + 1}"
            raw = RawRun(raw.manifest.model_copy(update={"id": name}), raw.columns, raw.origins, {}, {}, ())
            corrected = correct_drift(clean_run(raw, recipe).run, recipe)
            members[name] = Member(corrected, fit_friction(corrected.run, recipe.friction))
        found = evaluate(Study(id="replicates", fit=tuple(members), laws=("archard",)), members, recipe).result
    except Exception as error:  # noqa: BLE001 - as above
        return _reason(error)
    law, true = found.law("archard"), float(np.mean([one.truth.coefficient for one in runs]))
    best, (low, high) = law.first.wear_coefficient, law.first.interval
    flags = tuple(sorted(set(_codes(_findings(found, law)))))
    interval = (low.value / true, high.value / true)
    return Outcome(best.value / true, _spread(best) / true, interval, flags, None, None, None, None, 0.0)


def _reason(error: Exception) -> str:
    expected = isinstance(error, TribopipeError | ValidationError)
    return str(error).splitlines()[0] if expected else f"crash: {error!r}"


def _findings(*records: object) -> list[Any]:
    """Return the findings that results carry themselves."""
    return [finding for record in records for finding in getattr(record, "findings", ())]


def _codes(findings: Iterable[Any]) -> list[str]:
    return [finding.code for finding in findings if finding.severity != "note"]


def _verdict(corrected: CorrectedRun, friction: FrictionFit, law: str, recipe: Recipe) -> str:
    study = Study(id="alone", fit=(corrected.id,), laws=(law,))
    found = evaluate(study, {corrected.id: Member(corrected, friction)}, recipe)
    return found.result.law(law).runs[0].outcome


def _drift_held(corrected: CorrectedRun, fit: WearFit, true: float) -> bool | None:
    """Return whether the interval of the drift rate that belongs to the headline k_D holds the truth."""
    if fit.sensor is None or fit.correction != "model":
        return _holds(corrected.correction.drift_rate, true)
    low, high = fit.sensor.drift_interval
    return low.value <= true <= high.value


def _friction_held(fit: FrictionFit, truth: Truth) -> dict[str, bool] | None:
    if fit.outcome != "exponential":
        return None
    pairs = (
        ("A", fit.amplitude, truth.friction.amplitude),
        ("b", fit.steady_state, truth.friction.steady),
        ("c", fit.running_in_distance, truth.friction.running_in),
    )
    return {name: bool(_holds(found, true)) for name, found, true in pairs}


def _holds(found: Quantity | None, true: float) -> bool | None:
    return None if found is None else abs(found.value - true) <= COVERAGE_FACTOR * _spread(found)


def _apart(one: Quantity, other: Quantity) -> float:
    """Return a difference over its uncertainty; what both share makes that smaller, which is left out of account."""
    return (one.value - other.value) / float(np.hypot(_spread(one), _spread(other)))


def _spread(quantity: Quantity) -> float:
    return quantity.standard_uncertainty or 0.0

"""Drift rate and k_D by correction in two steps and by one model, against the truth of simulated laboratories.

    python benchmarks/joint_drift.py --labs 200 --jobs 2

`labs.py` says what varies. The pin's end value is a height loss, either exact (standard uncertainty 1e-12 m, and so is
that of the disc's wear) or known to ±250 nm. Uncertainties are those to first order.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from labs import (
    NO_ANSWER,
    SAMPLES,
    LabRun,
    Planned,
    Report,
    arguments,
    height_loss,
    in_parallel,
    laboratory,
    planned,
    reason,
)

from tribopipe.base.arrays import Column
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import MonteCarloRecipe, Recipe, WearRecipe
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.results.run import RawRun

MATERIALS: dict[str, Planned] = {
    "Si3N4, 200 mN": planned("si3n4-air-200mN"),
    "WC-Co, 400 mN": planned("wc-co-water-400mN"),
}
EXACT = 1e-12
END_VALUES = {"exact": EXACT, "±250 nm": 250e-9}
MODEL = Recipe(monte_carlo=MonteCarloRecipe(significant_digits=0))
TWO_STEP = MODEL.model_copy(update={"wear": WearRecipe(correction="two-step")})
NM_PER_MIN = 60e9


@dataclass(frozen=True)
class Task:
    """One laboratory."""

    material: str
    end_value: str
    seed: int


@dataclass(frozen=True)
class Errors:
    """Estimates minus truth and their standard uncertainties: two-step, then by one model."""

    drift: tuple[float, float]
    """m/s"""
    drift_spread: tuple[float, float]
    coefficient: tuple[float, float]
    """Relative."""
    coefficient_spread: tuple[float, float]


def errors(task: Task) -> Errors | str:
    """Estimate both ways; where there is no k_D, return why."""
    plan, spread = MATERIALS[task.material], END_VALUES[task.end_value]
    try:
        (lab,) = laboratory([plan], task.seed, height_loss(spread)).values()
        corrected = correct_drift(_exact_disc(lab)) if spread == EXACT else lab.corrected
        fits = [fit_wear(corrected, "archard", None, how) for how in (TWO_STEP, MODEL)]
    except NO_ANSWER as error:
        return reason(error)
    two_step, model = (None if fit.first is None else fit.first.wear_coefficient for fit in fits)
    rate, sensor = corrected.correction.two_step_rate, fits[1].sensor
    if two_step is None or model is None or rate is None or sensor is None:
        return "no k_D"
    true_drift, true_k = lab.truth.drift_rate.value, lab.truth.wear_coefficient.value
    drifts, coefficients = (rate, sensor.drift_rate), (two_step, model)
    return Errors(
        drift=(drifts[0].value - true_drift, drifts[1].value - true_drift),
        drift_spread=_spreads(*drifts),
        coefficient=(coefficients[0].value / true_k - 1, coefficients[1].value / true_k - 1),
        coefficient_spread=_spreads(*coefficients, over=true_k),
    )


def _exact_disc(lab: LabRun) -> RawRun:
    """Give the manifest the true disc wear."""
    raw = lab.corrected.run
    ends = raw.manifest.end_values
    if ends.disc_wear_depth is None:
        return raw
    true = {"value": lab.truth.end_disc_wear_depth.value, "standard_uncertainty": EXACT}
    ends = ends.model_copy(update={"disc_wear_depth": ends.disc_wear_depth.model_copy(update=true)})
    manifest = raw.manifest.model_copy(update={"end_values": ends})
    return RawRun(manifest, raw.columns, raw.origins, raw.extras, raw.headers, raw.sources)


def _spreads(two_step: Quantity, model: Quantity, over: float = 1.0) -> tuple[float, float]:
    return (two_step.standard_uncertainty or 0.0) / over, (model.standard_uncertainty or 0.0) / over


def _rms(values: Column) -> float:
    return float(np.sqrt(np.mean(values**2)))


def rows(material: str, end_value: str, good: Sequence[Errors]) -> list[list[str]]:
    """Return two rows of each quantity, one for each way of estimating it."""
    table = []
    for name, scale, unit in (("drift", NM_PER_MIN, "nm/min"), ("coefficient", 100.0, "%")):
        off = np.array([getattr(one, name) for one in good])
        spread = np.array([getattr(one, f"{name}_spread") for one in good])
        for way, label in enumerate(("two-step", "model")):
            mine, stated = off[:, way] * scale, spread[:, way] * scale
            uncertain = float(np.std(mine, ddof=1)) / len(good) ** 0.5
            table.append(
                [
                    material,
                    end_value,
                    "drift rate" if name == "drift" else "k_D",
                    label,
                    f"{_rms(mine):.3g} {unit}",
                    f"{float(np.mean(mine)):+.2g} ± {uncertain:.1g} {unit}",
                    f"{float(np.median(stated)):.3g} {unit}",
                    f"{_rms(mine / stated):.2f}",
                ]
            )
    return table


def agreement(material: str, end_value: str, good: Sequence[Errors]) -> list[list[str]]:
    """Return how far both ways differ, over the standard uncertainty of either."""
    table = []
    for name in ("drift", "coefficient"):
        off = np.array([getattr(one, name) for one in good])
        spread = np.array([getattr(one, f"{name}_spread") for one in good])
        difference = off[:, 1] - off[:, 0]
        both = [_rms(difference / spread[:, way]) for way in (0, 1)]
        label = "drift rate" if name == "drift" else "k_D"
        table.append([material, end_value, label, *(f"{one:.2f}" for one in both)])
    return table


def main() -> None:
    """Estimate, and print."""
    options = arguments(__doc__ or "", labs=200).parse_args()
    report = Report("Two-step correction compared with the model fit", options)
    loads = " and ".join(str(SAMPLES[one.sample][1].id) for one in MATERIALS.values())
    report.say(f"The simulated runs are based on {loads}.")
    kinds = [(material, end_value) for material in MATERIALS for end_value in END_VALUES]
    seeds = range(options.first_seed, options.first_seed + options.labs)
    answers = in_parallel(errors, (Task(*kind, seed) for seed in seeds for kind in kinds), options)
    done = len(answers) // len(kinds)
    table, agreed, without = [], [], []
    for place, kind in enumerate(kinds):
        mine = answers[place : done * len(kinds) : len(kinds)]
        good = [one for one in mine if isinstance(one, Errors)]
        table += rows(*kind, good)
        agreed += agreement(*kind, good)
        without.append(f"{kind[0]}, {kind[1]}: {len(mine) - len(good)} of {len(mine)}")
    report.say(
        "Root-mean-square (RMS) error, bias with its standard error, median of the calculated standard uncertainties "
        "u, and RMS error divided by u."
    )
    head = ["run", "post-test depth"]
    report.table([*head, "quantity", "method", "RMS error", "bias", "u (median)", "RMS error / u"], table)
    report.say(
        "RMS difference between the results of the model fit and the two-step correction, divided by the standard "
        "uncertainty u of each."
    )
    report.table([*head, "quantity", "divided by u, two-step", "divided by u, model"], agreed)
    report.say("Runs without a result: " + "; ".join(without) + ".")
    report.finish()


if __name__ == "__main__":
    main()

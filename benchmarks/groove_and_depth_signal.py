"""k_D of a ball and of its disc from a depth signal and one of both alone: how often intervals hold, and how wide.

    python benchmarks/groove_and_depth_signal.py --labs 200 --write docs/results/groove_and_depth_signal.md

Either the depth of the groove or the length of the scar on the ball is measured. The sensor shows the wear of both with
noise, drift and, in half of the laboratories, thermal settling; its scale, the load, the radii and the measurement are
off within what run.toml states. The wear of both is integrated slice by slice, without a line of tribopipe.

The ideal estimator knows the laws of all that and the variances, but no value: its standard uncertainty is that of
generalized least squares at the truth. It knows whether the sensor settles, and how fast.
"""

import math
from collections.abc import Callable, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
from independent.wear import WornPair, worn_pair
from labs import Report, arguments, in_parallel, share
from numpy.random import Generator

from tribopipe.base.arrays import Column
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.recipe import MonteCarloRecipe, Recipe
from tribopipe.documents.signals import SignalName
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.results.run import RawRun

LOAD, RADIUS, TRACK, SLID, SPEED = 5.0, 3e-3, 6e-3, 1000.0, 0.4
SHAPE = (2 / 3 - 3 * np.pi / 16) / (2 / 3 + 3 * np.pi / 16) / np.sqrt(3)
"""Relative standard uncertainty of the section of a real groove: between those of rigid bodies at the extremes."""
RELATIVE = {"load": 0.01, "radius": 0.001, "track": 0.005, "scale": 0.005, "shape": SHAPE}
NOISE, DRIFT, SETTLING = 30e-9, 250e-9, 200e-9
"""Standard deviations, m: of a sample, of the drift over the test, and of what settles in a tenth of it."""
GROOVE, SCAR = 0.02, 2e-6
"""Standard uncertainties: of the depth of the groove, relative; of the length of the scar, m."""
SAMPLES, BLOCKS = 1000, 40
PAIRS = {
    "both bodies": (2e-14, 4e-13),
    "mainly the ball": (5e-14, 5e-14),
    "mainly the disc": (2e-15, 1e-12),
    "only the disc": (0.0, 1e-12),
}
"""Usual k_D of ball and disc, m²/N."""
BODIES = ("pin", "disc")
_SPREAD = np.log(2.0)
"""Coefficients are between half and twice the usual ones."""
_SETTLING_TIME = 0.1
"""Share of the test."""
_STEP = 1e-4
FIRST_ORDER = Recipe(monte_carlo=MonteCarloRecipe(significant_digits=0))


class Measurement(NamedTuple):
    """What is measured after the test."""

    key: str
    value: Callable[[WornPair, float], float]
    """Of what is worn at the end, and the radius of the ball, m."""
    spread: Callable[[float], float]
    """Standard uncertainty of a value, m."""


def _scar_length(worn: WornPair, radius: float) -> float:
    depth = float(worn.ball[-1])
    return 2 * math.sqrt(depth * (2 * radius - depth))


MEASURED = {
    "groove": Measurement("disc_wear_depth", lambda worn, _: float(worn.groove[-1]), lambda value: GROOVE * value),
    "scar": Measurement("pin_scar_length", _scar_length, lambda _: SCAR),
}


class Truth(NamedTuple):
    """What is true in a laboratory: coefficients, and the factors by which its inputs are off."""

    ball: float
    disc: float
    load: float = 1.0
    radius: float = 1.0
    track: float = 1.0
    scale: float = 1.0
    shape: float = 1.0

    def readings(self, places: Column, measured: Measurement) -> Column:
        """Return what the sensor shows at sliding distances, without noise and drift, and the measurement, m."""
        work = LOAD * self.load * np.append(places, SLID)
        section = self.disc * work / (2 * np.pi * TRACK * self.track) / self.shape
        radius = RADIUS * self.radius
        worn = worn_pair(radius, self.ball * work, section)
        return np.append(self.scale * (worn.ball + worn.groove)[:-1], measured.value(worn, radius))

    def ideal(self, measured: Measurement, *, settles: bool) -> dict[str, float]:
        """Return the relative standard uncertainty of both k_D by the ideal estimator."""
        places = SLID * (np.arange(BLOCKS) + 0.5) / BLOCKS
        best = self.readings(places, measured)
        slopes = {name: self._slope(name, places, measured) for name in self._fields}
        noise = np.full(BLOCKS, NOISE**2 * BLOCKS / SAMPLES)
        covariance = np.diag(np.append(noise, measured.spread(float(best[-1])) ** 2))
        for course in (DRIFT * places / SLID, settles * settled(places / SLID)):
            disturbing = np.append(course, 0.0)
            covariance += np.outer(disturbing, disturbing)
        for name, relative in RELATIVE.items():
            covariance += relative**2 * np.outer(slopes[name], slopes[name])
        offset = np.append(np.ones(BLOCKS), 0.0)
        design = np.column_stack([slopes["ball"], slopes["disc"], offset])
        found = np.linalg.inv(design.T @ np.linalg.solve(covariance, design))
        return dict(zip(BODIES, np.sqrt(np.diag(found))[:2].tolist(), strict=True))

    def _slope(self, name: str, places: Column, measured: Measurement) -> Column:
        """Return how the readings change with the logarithm of a coefficient or factor, m."""
        value = getattr(self, name)
        low, high = (
            self._replace(**{name: value * near}).readings(places, measured) for near in (1 - _STEP, 1 + _STEP)
        )
        return np.asarray((high - low) / (2 * _STEP))


def settled(progress: Column) -> Column:
    """Return what a sensor that settles reads in addition, one standard deviation, m, at shares of the test."""
    return np.asarray(SETTLING * (1 - np.exp(-progress / _SETTLING_TIME)))


def true(pair: str, rng: Generator) -> Truth:
    """Draw what is true."""
    off = {name: 1 + relative * float(rng.standard_normal()) for name, relative in RELATIVE.items()}
    ball, disc = (usual * float(np.exp(rng.uniform(-_SPREAD, _SPREAD))) for usual in PAIRS[pair])
    return Truth(ball, disc, **off)


def run_of(truth: Truth, measured: Measurement, rng: Generator, *, settles: bool) -> RawRun:
    """Return the run as the laboratory writes it down."""
    distance = np.linspace(0.0, SLID, SAMPLES)
    *shown, value = truth.readings(distance, measured)
    progress = distance / SLID
    depth = np.array(shown) + NOISE * rng.standard_normal(SAMPLES) + DRIFT * rng.standard_normal() * progress
    if settles:
        depth += rng.standard_normal() * settled(progress)
    body = {"youngs_modulus": "210 GPa", "poisson_ratio": 0.3}
    document = {
        "schema": "tribopipe.run/1",
        "id": "lab",
        "signals": [{"file": "none.csv"}],
        "contact": {
            "kind": "pin-on-disc",
            "pin": {"shape": "spherical", "radius": _stated(RADIUS, "m", "radius"), "material": "ball"} | body,
            "disc": {"material": "steel"} | body,
        },
        "conditions": {
            "normal_load": _stated(LOAD, "N", "load"),
            "track_radius": _stated(TRACK, "m", "track"),
            "sliding_speed": f"{SPEED} m/s",
        },
        "end_values": {
            measured.key: {
                "value": value + measured.spread(value) * float(rng.standard_normal()),
                "unit": "m",
                "standard_uncertainty": measured.spread(value),
            }
        },
    }
    columns: dict[SignalName, Column] = {"time": distance / SPEED, "sliding_distance": distance, "depth": depth}
    manifest = RunManifest.model_validate(document)
    return RawRun(manifest, columns, dict.fromkeys(columns, "measured"), {}, {}, ())


def _stated(value: float, unit: str, name: str) -> dict[str, object]:
    return {"value": value, "unit": unit, "standard_uncertainty": RELATIVE[name] * value}


class Found(NamedTuple):
    """What was found of one body; NaN where it has no k_D."""

    measured: str
    pair: str
    settles: bool
    body: str
    held: bool
    ratio: float
    relative: float
    over_ideal: float


def outcomes(seed: int) -> list[Found]:
    """Test each pair in one laboratory, by the groove and by the scar, which a ball without wear does not have."""
    found, settles = [], bool(seed % 2)
    tests = [(name, number, pair) for name in MEASURED for number, pair in enumerate(PAIRS)]
    for name, number, pair in tests:
        measured = MEASURED[name]
        rng = np.random.default_rng(np.random.SeedSequence([seed, number]))
        truth = true(pair, rng)
        if name == "scar" and not truth.ball:
            continue
        fit = fit_wear(run_of(truth, measured, rng, settles=settles), "archard", recipe=FIRST_ORDER)
        ideal = truth.ideal(measured, settles=settles) if truth.ball else {}
        for body, k_d in zip(BODIES, (truth.ball, truth.disc), strict=True):
            one = fit.bodies.get(body)
            if one is None:
                found.append(Found(name, pair, settles, body, False, np.nan, np.nan, np.nan))
                continue
            (low, high), k = one.interval, one.wear_coefficient
            relative = (k.standard_uncertainty or 0.0) / k.value
            held, ratio = low.value <= k_d <= high.value, k.value / k_d if k_d else np.nan
            over_ideal = relative / ideal.get(body, np.nan)
            found.append(Found(name, pair, settles, body, held, ratio, relative, over_ideal))
    return found


def _group(found: Found) -> tuple[str, str, bool, str]:
    return found.measured, found.pair, found.settles, found.body


def _summary(found: Sequence[Found]) -> list[str]:
    """Return the columns for a group of tests: with k_D, covered, fraction, its interval, bias, u, u over ideal."""
    given = [one for one in found if np.isfinite(one.relative)]
    claimed = f"{len(given)} of {len(found)}"
    if not given:
        return [claimed] + [""] * 6
    bias = float(np.mean([one.ratio for one in given if np.isfinite(one.ratio)])) - 1
    u = float(np.median([one.relative for one in given]))
    over_ideal = [one.over_ideal for one in given if np.isfinite(one.over_ideal)]
    return [
        claimed,
        *share(sum(one.held for one in given), len(given)),
        f"{100 * bias:+.1f} %",
        f"{100 * u:.1f} %",
        f"{np.median(over_ideal):.2f}" if over_ideal else "–",
    ]


def main(words: Sequence[str] | None = None) -> None:
    """Count how often intervals hold."""
    options = arguments(__doc__ or "", labs=200).parse_args(words)
    report = Report("k_D of both bodies from depth signal and groove or scar", options)
    seeds = range(options.first_seed, options.first_seed + options.labs)
    answers = [found for part in in_parallel(outcomes, seeds, options) for found in part]
    groups = dict.fromkeys(_group(one) for one in answers)
    rows = [
        [
            measured,
            pair,
            "yes" if settles else "no",
            body,
            *_summary([one for one in answers if _group(one) == (measured, pair, settles, body)]),
        ]
        for measured, pair, settles, body in groups
    ]
    rows += [
        [
            measured,
            "all",
            "yes or no",
            body,
            *_summary([one for one in answers if (one.measured, one.body) == (measured, body)]),
        ]
        for measured, body in product(MEASURED, BODIES)
    ]
    report.say(
        "Only runs with a k_D are evaluated. The 95 % intervals of k_D are from first-order propagation. The bias is "
        "the mean of k_D divided by the true value, minus 1. u is the standard uncertainty of k_D; the last column "
        "is the median of u divided by that of the ideal estimator."
    )
    report.table(
        [
            "measured",
            "wear",
            "sensor settling",
            "body",
            "with k_D",
            "covered",
            "fraction",
            "95 % CI",
            "bias",
            "median u",
            "u / ideal",
        ],
        rows,
    )
    report.finish()


if __name__ == "__main__":
    main()

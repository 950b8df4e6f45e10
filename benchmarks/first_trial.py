"""The standard uncertainty of k_D by Monte Carlo beside that of the covariance, as a first trial found them.

    python benchmarks/first_trial.py

The recipe: 2000 samples of pin wear spaced geometrically over 500 m, noise of 0.3 µm (first-order autoregressive, 0.98
from sample to sample), and in each draw an error of the end value of ±250 nm that grows with distance, as the drift
correction makes of it, a load off by 1 % and a tip radius off by 0.2 %. That was done with 60 draws, one series of
noise and Euler's method: 1.6 % for Si3N4 at 200 mN and 33 % for WC-Co at 400 mN, against 0.22 % and 4.8 % from the
covariance. Here the same is done with the exact model, with the very same 60 draws, with many more, with other series
of noise, and with samples equally spaced in time, as instruments record them.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from labs import Report, arguments
from numpy.random import Generator
from scipy.signal import lfilter

from tribopipe.base.arrays import Column
from tribopipe.physics.hertz import contact_modulus
from tribopipe.physics.pin_on_disc import SphericalPin

RADIUS, MODULUS_SI3N4, RATIO = 0.794e-3, 304e9, 0.24
SLID, SAMPLES = 500.0, 2000
NOISE, MEMORY = 0.3e-6, 0.98
END_VALUE, LOAD, TIP = 250e-9, 0.01, 0.002
TRIAL_DRAWS, SERIES = 60, 20
_SLICE = 250
_LEAST_LOG_K = 14.0
"""A k_D this many e-folds below the true one is none."""


@dataclass(frozen=True)
class Case:
    """One run of the trial; the modulus was that of Si3N4 throughout."""

    name: str
    coefficient: float
    load: float
    trial: str
    trial_covariance: str


CASES = (
    Case("Si3N4, 200 mN", 13.5e-15, 0.2, "1.6 %", "0.22 %"),
    Case("WC-Co, 400 mN", 0.75e-17, 0.4, "33 %", "4.8 %"),
)
SPACINGS = {
    "logarithmic": np.concatenate([[0.0], np.geomspace(SLID * 1e-6, SLID, SAMPLES)]),
    "equal in time": np.linspace(0.0, SLID, SAMPLES + 1),
}
MODULUS = float(
    contact_modulus(pin_modulus=MODULUS_SI3N4, pin_ratio=RATIO, disc_modulus=MODULUS_SI3N4, disc_ratio=RATIO)
)


@dataclass(frozen=True)
class Errors:
    """What is off in each draw: end value, m, and load and tip radius as factors."""

    end: Column
    load: Column
    radius: Column


def draw_errors(rng: Generator, count: int) -> Errors:
    """Draw in the order of the trial."""
    drawn = rng.standard_normal((count, 3)) * [END_VALUE, LOAD, TIP] + [0.0, 1.0, 1.0]
    return Errors(*drawn.T)


def draw_noise(rng: Generator, count: int) -> Column:
    """Draw one series, which starts at 0."""
    white = NOISE * math.sqrt(1 - MEMORY**2) * rng.standard_normal(count)
    white[0] = 0.0
    return np.asarray(lfilter([1.0], [1.0, -MEMORY], white))


def depth(case: Case, distance: Column) -> Column:
    """Return the true wear depth, m."""
    return SphericalPin(case.load, RADIUS, MODULUS).worn(case.coefficient * case.load * distance).depth


def covariance(case: Case, distance: Column) -> float:
    """Return the relative standard uncertainty of k_D that least squares state with independent noise."""
    slope = _slope(case, distance)
    return NOISE / math.sqrt(float(slope @ slope))


def _slope(case: Case, distance: Column) -> Column:
    volume = case.coefficient * case.load * distance
    state = SphericalPin(case.load, RADIUS, MODULUS).worn(volume)
    return np.asarray(volume / (np.pi * state.radius**2))


def end_value_share(case: Case, distance: Column) -> float:
    """Return, to first order, the relative change of k_D that one standard uncertainty of the end value makes."""
    slope = _slope(case, distance)
    return float(END_VALUE * (distance / SLID) @ slope / (slope @ slope))


def fitted(case: Case, distance: Column, reading: Column, errors: Errors) -> Column:
    """Return k_D over the true one for each draw, by Gauss–Newton on ln k_D; 0 where no wear fits best."""
    found = []
    for first in range(0, len(errors.end), _SLICE):
        part = slice(first, first + _SLICE)
        end, load, tip = (column[part, None] for column in (errors.end, errors.load, errors.radius))
        found.append(_solved(case, distance, reading + end * distance / SLID, load * case.load, tip * RADIUS))
    return np.concatenate(found)


def _solved(case: Case, distance: Column, measured: Column, load: Column, radius: Column) -> Column:
    pin, log_k = SphericalPin(load, radius, MODULUS), np.zeros(len(load))
    for _ in range(60):
        volume = case.coefficient * np.exp(log_k)[:, None] * load * distance
        state = pin.worn(volume)
        slope = volume / (np.pi * state.radius**2)
        step = np.vecdot(measured - state.depth, slope) / np.vecdot(slope, slope)
        moved = np.maximum(log_k + np.clip(step, -1.0, 1.0), -_LEAST_LOG_K)
        change, log_k = np.abs(moved - log_k), moved
        if np.all(change < 1e-6):
            break
    return np.where(log_k <= -_LEAST_LOG_K, 0.0, np.exp(log_k))


def relative(ratios: Column) -> float:
    """Return the standard deviation over the mean."""
    return float(np.std(ratios) / np.mean(ratios))


@dataclass(frozen=True)
class Repeated:
    """What the trial's own noise and draws give with the exact model."""

    relative: float
    """Standard deviation of k_D over its mean."""
    fitted: float
    """k_D by the noise alone, over the true one."""
    covariance: float
    """Relative standard uncertainty by the covariance at that k_D."""


def trial() -> dict[str, Repeated]:
    """Repeat the trial's own 60 draws of each case, noise and errors from its generator in its order."""
    rng = np.random.default_rng(0)
    found: dict[str, Repeated] = {}
    none = Errors(np.zeros(1), np.ones(1), np.ones(1))
    distance = SPACINGS["logarithmic"]
    for case in CASES:
        reading = depth(case, distance) + draw_noise(rng, len(distance))
        alone = float(fitted(case, distance, reading, none)[0])
        found[case.name] = Repeated(
            relative=relative(fitted(case, distance, reading, draw_errors(rng, TRIAL_DRAWS))),
            fitted=alone,
            covariance=covariance(replace(case, coefficient=alone * case.coefficient), distance),
        )
    return found


def other_noise(case: Case, distance: Column, draws: int) -> tuple[float, float, float]:
    """Return the median, least and greatest relative standard deviation over series of noise."""
    found = []
    for seed in range(SERIES):
        rng = np.random.default_rng([seed, 1])
        reading = depth(case, distance) + draw_noise(rng, len(distance))
        found.append(relative(fitted(case, distance, reading, draw_errors(rng, draws))))
    return float(np.median(found)), min(found), max(found)


def percent(value: float) -> str:
    """Write a share."""
    return f"{100 * value:.2g} %"


def main() -> None:
    """Draw, fit and print."""
    parser = arguments(__doc__ or "")
    parser.add_argument("--draws", type=int, default=10_000, help="number of draws (%(default)s)")
    options = parser.parse_args()
    report = Report("Uncertainty of k_D: comparison with an earlier trial", options)
    report.say(
        f"In an earlier trial, the uncertainty of k_D was calculated from {TRIAL_DRAWS} Monte Carlo draws, with one "
        "realization of the noise and Euler's method. Here the calculation is repeated with the exact model: with "
        f"the same {TRIAL_DRAWS} draws, with {options.draws:,} draws, with other realizations of the noise, and with "
        "samples that are equally spaced in time. The table lists the relative standard deviation of k_D. With "
        f"{TRIAL_DRAWS} normally distributed draws, the standard deviation itself has a relative uncertainty of "
        f"1/√(2·{TRIAL_DRAWS - 1}) = {percent(1 / math.sqrt(2 * (TRIAL_DRAWS - 1)))}."
    )
    again, rows, weights, ends = trial(), [], [], []
    for case in CASES:
        for spacing, distance in SPACINGS.items():
            rng = np.random.default_rng([1, 2])
            true = depth(case, distance)
            clean = fitted(case, distance, true, errors := draw_errors(rng, options.draws))
            middle, least, most = other_noise(case, distance, options.draws // SERIES)
            like = spacing == "logarithmic"
            rows.append(
                [
                    case.name,
                    spacing,
                    case.trial if like else "",
                    percent(again[case.name].relative) if like else "",
                    percent(relative(clean)),
                    f"{percent(middle)} ({percent(least)} to {percent(most)})",
                    percent(covariance(case, distance)),
                    case.trial_covariance if like else "",
                ]
            )
            share = end_value_share(case, distance)
            per_end = share / (END_VALUE / true[-1])
            weights.append([case.name, spacing, percent(END_VALUE / true[-1]), f"{per_end:.2f}", percent(share)])
            low = true[-1] + errors.end
            few = low < 0.1 * true[-1]
            quantiles = " to ".join(f"{one:.2f}" for one in np.quantile(clean, [0.025, 0.975]))
            ends.append(
                [
                    case.name,
                    spacing,
                    percent(float(np.mean(few))),
                    percent(float(np.mean(clean == 0))),
                    percent(relative(clean)),
                    percent(relative(clean[~few])),
                    quantiles,
                ]
            )
    head = ["run", "spacing"]
    report.table(
        [
            *head,
            "trial",
            f"same {TRIAL_DRAWS} draws, exact model",
            f"{options.draws:,} draws, no noise",
            f"{SERIES} noise realizations: median (range)",
            "covariance",
            "covariance, trial",
        ],
        rows,
    )
    report.say(
        "Effect of the noise in the trial: ratio of the k_D fitted with this noise alone to the true k_D, and the "
        "relative standard uncertainty from the covariance at the fitted k_D."
    )
    report.table(
        ["run", "fitted k_D / true k_D", "covariance", "covariance, trial"],
        [
            [case.name, f"{of.fitted:.3f}", percent(of.covariance), case.trial_covariance]
            for case in CASES
            for of in [again[case.name]]
        ],
    )
    report.say(
        "Effect of the spacing. If the samples are equally spaced in the logarithm of distance, the first meters, "
        "where the error of the post-test depth has little effect, have as much weight as the last meters. If they "
        "are equally spaced in time, the end of the test has most of the weight. For h ∝ √s, the relative error of "
        "k_D is 4/3 times that of the final depth with logarithmic spacing, and 8/5 times with spacing in time. "
        "First-order results of the exact model:"
    )
    report.table([*head, "u of the final depth", "ratio", "u of k_D"], weights)
    report.say(
        "Effect of draws with a final depth close to zero, without noise. The columns list the fraction of draws "
        "with less than a tenth of the true depth, the fraction of draws for which zero wear fits best, the relative "
        "standard deviation of k_D with all draws and without those with less than a tenth of the true depth, and "
        "the 95 % interval of k_D divided by the true k_D."
    )
    report.table(
        [*head, "depth below 10 %", "zero wear", "all draws", "without depths below 10 %", "95 % interval"], ends
    )
    report.finish()


if __name__ == "__main__":
    main()

"""One k_D from several runs, held against sets of runs whose truth and scatter are known."""

import math
from itertools import count, islice
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2

from tribopipe.evaluation.study.member import copies_note
from tribopipe.evaluation.study.random_effects import Combination, combine, paule_mandel

TRUE = 1.35e-14
"""k_D of Si3N4 in air, m²/N."""

# R. Paule, J. Mandel's equation on data of others: G. A. Colditz et al., JAMA 271 (1994) 698, log risk ratios of 13
# trials of the BCG vaccine, for which metafor 4 (method "PM") reports τ² = 0.318.
BCG = np.array(
    [-0.8893, -1.5854, -1.3481, -1.4416, -0.2175, -0.7861, -1.6209, 0.0120, -0.4694, -1.3713, -0.3394, 0.4459, -0.0173]
)
BCG_VARIANCE = np.array(
    [0.3256, 0.1946, 0.4154, 0.0200, 0.0512, 0.0069, 0.2230, 0.0040, 0.0564, 0.0730, 0.0124, 0.5325, 0.0714]
)

# R. N. Kacker, Metrologia 41 (2004) 132, table 1: nine laboratories and their variances.
NINE_LABORATORIES = np.array([61.00, 61.40, 62.21, 62.30, 62.34, 62.60, 62.70, 62.84, 65.90])
NINE_VARIANCES = np.array([0.2025, 1.2100, 0.0900, 0.2025, 0.3844, 0.5625, 0.0676, 0.0225, 1.8225])


def names(number: int) -> list[str]:
    return [f"run-{place}" for place in range(number)]


def exact_draws(roots: np.ndarray, spreads: np.ndarray, shared: float = 0.0, number: int = 400) -> np.ndarray:
    """Draws of k_D whose √k_D have these means, and to the last digit the covariance diag(spreads²) + shared²."""
    white = np.random.default_rng(3).standard_normal((number, len(roots) + 1))
    white = np.linalg.qr(white - white.mean(axis=0))[0] * math.sqrt(number - 1)
    drawn = roots + white[:, 1:] * spreads + white[:, :1] * shared
    assert np.all(drawn > 0), "roots have to be drawn above zero for their squares to be as good as they"
    return drawn**2


def excess(x: np.ndarray, variance: np.ndarray, scatter: float) -> float:
    """Σ wᵢ (xᵢ − x̄)² − (n − 1), which is 0 at Paule and Mandel's τ."""
    weights = 1 / (variance + scatter**2)
    return float(weights @ (x - weights @ x / weights.sum()) ** 2) - (len(x) - 1)


class Lab:
    """Seeded sets of runs: true k_D with scatter, each measured with an error of its own and one that all share."""

    def __init__(self, seed: int, runs: int, *, scatter: float, own: float, shared: float = 0.0) -> None:
        """Take relative standard deviations of k_D, half of which are those of √k_D."""
        self.rng = np.random.default_rng([seed, runs])
        self.scatter, own, shared = (math.sqrt(TRUE) * share / 2 for share in (scatter, own, shared))
        true = self.true_roots(runs)
        roots = true + own * self.rng.standard_normal(runs) + shared * self.rng.standard_normal()
        drawn = roots + own * self.rng.standard_normal((2_000, runs)) + shared * self.rng.standard_normal((2_000, 1))
        self.best, self.draws = roots**2, drawn**2

    def true_roots(self, runs: int) -> np.ndarray:
        return math.sqrt(TRUE) + self.scatter * self.rng.standard_normal(runs)

    def combined(self) -> Combination:
        return combine(names(len(self.best)), self.best, self.draws)


# --- the weighted mean and the scatter ---


def test_one_run_passes_through_as_it_is():
    draws = np.random.default_rng(1).uniform(0, TRUE, (500, 1))
    combination = combine(["alone"], [TRUE], draws)
    assert combination.summary is None
    assert combination.scatter == 0
    rng = np.random.default_rng(2)
    mean, following = combination.draw(draws, rng)
    assert mean == pytest.approx(draws[:, 0], rel=1e-14, abs=0)
    assert np.array_equal(following, mean)


def test_scatter_of_published_data_is_paule_and_mandel_s():
    x = BCG + 10  # τ does not care where zero lies, but √k_D is above it
    combination = combine(names(13), x**2, exact_draws(x, np.sqrt(BCG_VARIANCE)))
    assert combination.scatter == pytest.approx(paule_mandel(x, BCG_VARIANCE), rel=1e-9)
    assert combination.scatter**2 == pytest.approx(0.318, abs=5e-4)
    weights = 1 / (BCG_VARIANCE + combination.scatter**2)
    assert combination.weights == pytest.approx(weights / weights.sum(), rel=1e-9)
    plain = 1 / BCG_VARIANCE
    q = float(plain @ (BCG - plain @ BCG / plain.sum()) ** 2)
    assert q == pytest.approx(152.2, abs=0.5)  # as published
    assert combination.summary.p_value == pytest.approx(chi2.sf(q, 12), rel=1e-6, abs=0)


def test_scatter_of_interlaboratory_results_is_as_published():
    assert paule_mandel(NINE_LABORATORIES, NINE_VARIANCES) == pytest.approx(0.8399, abs=5e-5)


@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e6])
@pytest.mark.parametrize(
    ("x", "own", "scatter"),
    [
        # Two runs: (x₁ − x₂)² = u₁² + u₂² + 2τ².
        ([1.0, 1.2], [0.05, 0.1], math.sqrt((0.04 - 0.0125) / 2)),
        # Equal variances: τ² = s² − u².
        ([1.0, 1.1, 0.8, 1.3], [0.1] * 4, math.sqrt(0.13 / 3 - 0.01)),
        # Two runs at ±d about a third: τ² = d² − u², whatever the uncertainty of the third.
        ([0.9, 1.0, 1.1], [0.06, 7.0, 0.06], 0.08),
        # A third that says nothing: (x₁ − x₂)² = 4(u² + τ²), with τ far less than the variance of x.
        ([0.0, 2e-6, 1.0], [6e-7, 6e-7, 1e8], 8e-7),
        # Runs that agree as well as they state, or better.
        ([1.0, 1.1], [0.0708, 0.0708], 0.0),
        ([1.0, 1.0, 1.0], [0.01, 0.02, 0.03], 0.0),
    ],
)
def test_scatter_has_a_closed_form_in_special_cases(x, own, scatter, unit):
    found = paule_mandel(unit * np.array(x), (unit * np.array(own)) ** 2)
    assert found == pytest.approx(unit * scatter, rel=1e-9, abs=0)


@given(
    offs=st.lists(st.integers(-100, 100), min_size=2, max_size=9),
    spreads=st.lists(st.floats(1e-3, 10), min_size=9, max_size=9),
    unit=st.sampled_from([1e-9, math.sqrt(TRUE), 1.0, 1e9]),
)
def test_scatter_solves_paule_and_mandel_s_equation_whatever_the_unit_and_the_zero(offs, spreads, unit):
    x, variance = unit * np.array(offs) / 100, (unit * np.array(spreads[: len(offs)])) ** 2
    scatter = paule_mandel(x, variance)
    assert paule_mandel(x + unit, variance) == pytest.approx(scatter, rel=1e-9, abs=1e-6 * math.sqrt(variance.min()))
    if scatter:
        assert excess(x, variance, scatter) == pytest.approx(0, abs=1e-9)
    else:
        assert excess(x, variance, 0.0) <= 0


def test_runs_that_agree_better_than_they_claim_are_weighed_by_their_own_variance_alone():
    x, own = np.array([1.0, 1.001, 0.999, 1.0005]), np.array([0.01, 0.02, 0.04, 0.01])
    combination = combine(names(4), x**2, exact_draws(x, own))
    assert combination.scatter == 0
    assert combination.summary.scatter == 0
    inverse = 1 / own**2
    assert combination.weights == pytest.approx(inverse / inverse.sum(), rel=1e-9)
    assert combination.summary.weights == pytest.approx(combination.weights, rel=1e-15)
    q = float(inverse @ (x - inverse @ x / inverse.sum()) ** 2)
    assert combination.summary.p_value == pytest.approx(chi2.sf(q, 3), rel=1e-9)


def test_runs_that_scatter_far_beyond_their_own_uncertainty_weigh_the_same():
    x, own = np.array([1.0, 1.4, 0.7, 1.1]), np.array([0.001, 0.002, 0.004, 0.001])
    combination = combine(names(4), x**2, exact_draws(x, own))
    assert combination.weights == pytest.approx(np.full(4, 0.25), rel=1e-3)
    assert combination.scatter == pytest.approx(np.std(x, ddof=1), rel=1e-3)


def test_scatter_and_own_uncertainty_are_said_of_k_d_itself():
    x, own = np.array([0.95, 1.05]), np.array([0.01, 0.01])
    summary = combine(names(2), x**2, exact_draws(x, own)).summary
    # τ² = s² − u², and dk/k is twice dx/x.
    assert summary.scatter == pytest.approx(2 * math.sqrt(0.005 - 0.0001), rel=1e-6)
    assert summary.within == pytest.approx(0.02, rel=1e-6)
    assert summary.runs == 2


def test_runs_that_agree_to_the_last_digit_are_combined_without_complaint():
    x = np.ones(3)
    combination = combine(names(3), x**2, exact_draws(x, np.full(3, 0.01)))
    assert combination.scatter == 0
    assert combination.weights == pytest.approx(np.full(3, 1 / 3), rel=1e-9)
    assert combination.summary.p_value == pytest.approx(1)


def test_without_scatter_the_uncertainty_of_the_mean_is_that_of_inverse_variances():
    x, own = np.array([1.0, 1.001, 0.999, 1.0005]), np.array([0.01, 0.02, 0.04, 0.01])
    draws = exact_draws(x, own)
    mean = combine(names(4), x**2, draws).draw(draws, np.random.default_rng(1))[0]
    assert np.std(np.sqrt(mean), ddof=1) == pytest.approx(1 / math.sqrt(np.sum(1 / own**2)), rel=1e-9)


# --- what runs share ---


@pytest.mark.parametrize("shared", [0.01, 0.05])
def test_a_shared_error_is_not_averaged_away(shared):
    x, own = 1 + 1e-3 * np.arange(8), np.full(8, 0.02)
    draws = exact_draws(x, own, shared)
    mean = combine(names(8), x**2, draws).draw(draws, np.random.default_rng(1))[0]
    assert np.std(np.sqrt(mean), ddof=1) == pytest.approx(math.hypot(shared, 0.02 / math.sqrt(8)), rel=1e-9)


def test_a_shared_error_neither_hides_scatter_nor_weighs():
    x, own = np.array([1.0, 1.1, 0.93, 1.02]), np.array([0.01, 0.02, 0.03, 0.015])
    apart, together = (combine(names(4), x**2, exact_draws(x, own, shared)) for shared in (0.0, 0.1))
    assert together.scatter == pytest.approx(apart.scatter, rel=1e-6)
    assert together.weights == pytest.approx(apart.weights, rel=1e-6)
    assert together.summary.within == pytest.approx(apart.summary.within, rel=1e-6)
    assert together.summary.p_value == pytest.approx(apart.summary.p_value, rel=1e-6)


# --- many seeded labs ---


@pytest.mark.slow
def test_scatter_between_runs_comes_back_over_many_labs():
    found = [Lab(seed, 8, scatter=0.10, own=0.04).combined().summary.scatter for seed in range(150)]
    assert np.mean(found) == pytest.approx(0.10, rel=0.2)
    # A standard deviation of eight has a relative uncertainty of 1/√14, a little more where own errors come off it.
    assert 0.5 / math.sqrt(14) < np.std(found) / np.mean(found) < 2 / math.sqrt(14)


@pytest.mark.slow
def test_no_scatter_is_found_in_half_of_the_labs_without_any():
    none = [Lab(seed, 5, scatter=0.0, own=0.04).combined().scatter == 0 for seed in range(200)]
    # Cochran's Q lies below its mean n − 1 with this probability.
    assert np.mean(none) == pytest.approx(chi2.cdf(4, 4), abs=3 * math.sqrt(0.24 / 200))


@pytest.mark.slow
def test_p_values_of_disagreement_are_uniform_among_runs_of_one_k_d():
    told = [Lab(seed, 5, scatter=0.0, own=0.04).combined().summary.p_value for seed in range(200)]
    for level in (0.1, 0.5, 0.9):
        assert np.mean(np.array(told) < level) == pytest.approx(level, abs=3 * math.sqrt(level * (1 - level) / 200))


@pytest.mark.slow
@pytest.mark.parametrize(("own", "shared"), [(0.02, 0.0), (0.04, 0.0), (0.04, 0.04)])
def test_intervals_of_the_mean_hold_the_truth_as_often_as_they_say(own, shared):
    held = []
    for seed in range(400):
        lab = Lab(seed, 4, scatter=0.10, own=own, shared=shared)
        low, high = np.quantile(lab.combined().draw(lab.draws, lab.rng)[0], (0.025, 0.975))
        held.append(low <= TRUE <= high)
    assert 0.92 <= np.mean(held) <= 0.98


def test_a_further_run_is_less_certain_than_the_mean():
    for seed in range(20):
        lab = Lab(seed, 6, scatter=0.10, own=0.02)
        combination = lab.combined()
        mean, following = combination.draw(lab.draws, lab.rng)
        assert np.std(following) > np.std(mean)
        assert np.var(np.sqrt(following)) - np.var(np.sqrt(mean)) >= 0.85 * combination.scatter**2


@pytest.mark.slow
def test_intervals_of_a_further_run_hold_it_as_often_as_they_say():
    held = []
    for seed in range(1500):
        lab = Lab(seed, 4, scatter=0.10, own=0.02)
        combination = lab.combined()
        _, following = combination.draw(lab.draws, lab.rng)
        low, high = np.quantile(following, (0.025, 0.975))
        held.append(low <= lab.true_roots(1)[0] ** 2 <= high)
    assert np.mean(held) >= 0.92


# --- outliers ---


def outliers(seed: int, runs: int, factor: float, scatter: float = 0.04, own: float = 0.03) -> tuple[str, ...]:
    """Outliers of a set whose second run has ``factor`` times the k_D."""
    lab = Lab(seed, runs, scatter=scatter, own=own)
    lab.best[1] *= factor
    lab.draws[:, 1] *= factor
    return lab.combined().summary.outliers


def test_a_run_with_twice_the_k_d_is_found_among_six():
    assert [outliers(seed, 6, 2.0) for seed in range(30)] == [("run-1",)] * 30


def test_a_run_with_half_the_k_d_is_found_among_six():
    assert [outliers(seed, 6, 0.5) for seed in range(30)] == [("run-1",)] * 30


@pytest.mark.slow
@pytest.mark.parametrize("scatter", [0.0, 0.10])
def test_sound_sets_have_no_outlier(scatter):
    found = [bool(outliers(seed, 6, 1.0, scatter)) for seed in range(200)]
    assert np.mean(found) <= 0.06


@pytest.mark.parametrize("runs", [2, 3])
def test_fewer_than_four_runs_never_have_an_outlier(runs):
    assert outliers(1, runs, 1e6, scatter=0.0) == ()


def test_four_runs_may_have_one():
    assert outliers(1, 4, 4.0) == ("run-1",)


def test_an_outlier_still_counts():
    lab = Lab(5, 6, scatter=0.04, own=0.03)
    lab.best[1] *= 2
    lab.draws[:, 1] *= 2
    combination = lab.combined()
    assert combination.summary.outliers == ("run-1",)
    assert combination.weights[1] > 0.1
    assert np.median(combination.draw(lab.draws, lab.rng)[0]) > 1.05 * TRUE


# --- draws at zero ---


@pytest.mark.parametrize("share", [0.3, 0.97])
def test_draws_without_wear_give_finite_results(share):
    rng = np.random.default_rng(4)
    draws = TRUE * rng.uniform(0.5, 1.5, (4_000, 3))
    draws[: int(share * len(draws)), 0] = 0.0
    combination = combine(names(3), [TRUE, 0.9 * TRUE, 1.1 * TRUE], draws)
    mean, following = combination.draw(draws, rng)
    for found in (combination.weights, mean, following):
        assert np.all(np.isfinite(found))
        assert np.all(found >= 0)
    assert combination.weights.sum() == pytest.approx(1)
    assert all(map(math.isfinite, (combination.summary.scatter, combination.summary.within)))
    assert 0 <= combination.summary.p_value <= 1


def test_a_run_that_may_not_have_worn_at_all_weighs_little():
    rng = np.random.default_rng(4)
    draws = TRUE * rng.uniform(0.9, 1.1, (4_000, 3))
    draws[:2_000, 0] = 0.0
    weights = combine(names(3), [TRUE] * 3, draws).weights
    assert weights[0] < 0.02
    assert weights[1] == pytest.approx(weights[2], rel=0.1)


@given(st.data())
def test_order_of_the_runs_does_not_matter(data):
    number = data.draw(st.integers(2, 6))
    order = data.draw(st.permutations(range(number)))
    seed = data.draw(st.integers(0, 1_000))
    lab = Lab(seed, number, scatter=0.10, own=0.04)
    ids = list(islice((f"r{place}" for place in count()), number))
    plain = combine(ids, lab.best, lab.draws)
    mixed = combine([ids[place] for place in order], lab.best[order], lab.draws[:, order])
    assert mixed.weights == pytest.approx(plain.weights[order], rel=1e-6)
    assert mixed.scatter == pytest.approx(plain.scatter, rel=1e-6, abs=1e-6 * math.sqrt(TRUE))
    assert set(mixed.summary.outliers) == set(plain.summary.outliers)


@pytest.mark.parametrize(("step", "noted"), [(0.0, True), (1e-9, False)])
def test_study_notes_a_recording_that_counts_twice(step, noted):
    depth = np.linspace(0, 1e-6, 20)
    members = [
        SimpleNamespace(id=name, corrected=SimpleNamespace(run=SimpleNamespace(columns={"depth": depth + more})))
        for name, more in (("a", 0.0), ("b", step))
    ]
    notes = copies_note(members)
    assert [note.startswith("warning: found the same recording in a and b; ") for note in notes] == [True] * noted

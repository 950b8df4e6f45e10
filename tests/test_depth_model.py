"""What a depth sensor reads besides wear: the model against closed forms, and against disturbances of known size."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.stats import chi2, multivariate_normal, norm
from sweeps import others_slow
from test_identify import CASES, record

from tribopipe.documents.manifest import EndValues
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import DefaultUncertainty, Recipe
from tribopipe.evaluation.depth_reading import depth_model
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.wear.depth_problem import DECISIVE, depth_problem
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.evaluation.wear.problem import wear_problem
from tribopipe.physics.depth_model.block_averages import blocks_of, steps
from tribopipe.physics.depth_model.mixture import Anchor, Regression, _Projected
from tribopipe.physics.depth_model.posterior import SCORES, DepthReading, MeasuredDepth, depth_posterior
from tribopipe.physics.depth_model.prior_sensitivity import widened
from tribopipe.physics.depth_model.terms import AMPLITUDES, optional_terms, wanders
from tribopipe.physics.pin_on_track import volume_growth

DEPTH, NOISE, SAMPLES = 20e-6, 50e-9, 4000


def reading(rng, disturbance=0.0, spread=0.2e-6) -> DepthReading:
    """Block averages of √s wear with an offset, a drift, noise and a disturbance, and a measured end."""
    time = np.arange(1, SAMPLES + 1) / SAMPLES
    disturbed = disturbance(time, rng) if callable(disturbance) else disturbance
    depth = DEPTH * np.sqrt(time) + 2e-6 - 0.4e-6 * time + NOISE * rng.standard_normal(SAMPLES) + disturbed
    blocks = blocks_of(time)
    nodes = blocks.nodes(500 * time)
    shape = nodes.averaged(np.sqrt(nodes.distance / 500))
    measured = DEPTH + spread * rng.standard_normal() + spread * SCORES
    return DepthReading(
        time=blocks.mean(time),
        depth=blocks.mean(depth),
        samples=blocks.counts,
        course=lambda end: end * shape,
        segments=np.zeros(len(shape)),
        measured=(MeasuredDepth(measured, lambda end: end),),
    )


def test_block_means_of_wear_are_those_over_the_samples():
    time = np.arange(1, 12_001) / 12_000
    blocks = blocks_of(time)
    nodes = blocks.nodes(500 * time)
    exact = blocks.mean(np.sqrt(time))
    np.testing.assert_allclose(nodes.averaged(np.sqrt(nodes.distance / 500)), exact, rtol=1e-9)


def test_runout_averages_out_over_whole_revolutions():
    time = np.arange(180_001) / 180_000
    for count in (3600.0, 1274.4, 60.3):
        runout = np.sin(2 * np.pi * count * time + 0.7)
        whole, divided = blocks_of(time, None, count * time), blocks_of(time)
        # The last block ends with the test, wherever the disc is.
        assert np.max(np.abs(whole.mean(runout)[:-1])) < 0.04
        assert np.max(np.abs(divided.mean(runout))) > 0.3


def test_few_revolutions_leave_the_blocks_as_they_are():
    time = np.arange(10_001) / 10_000
    np.testing.assert_array_equal(blocks_of(time, None, 49 * time).counts, blocks_of(time).counts)


def test_evidence_is_that_of_a_multivariate_normal():
    rng, count = np.random.default_rng(1), 30
    time = np.linspace(0.02, 1, count)
    weights = rng.uniform(0.5, 1.5, count)
    weights /= np.mean(weights)
    optional = optional_terms(time, None)
    # With proper priors on every column the marginal likelihood is that of one normal distribution.
    regression = Regression(
        reading=rng.standard_normal(count),
        weights=weights,
        flat=np.empty((count, 0)),
        normal=np.column_stack([np.sqrt(time), np.ones(count), time, optional.columns]),
        known_mean=np.array([0.1, 0.2, -0.1]),
        known_deviation=np.array([30.0, 2.0, 3.0]),
        alternatives=optional.alternatives,
        scale=1.0,
        noise=1.0,
    )
    wander = wanders(time, weights)[1]
    found = _Projected(regression, wander).solved(np.array([0.7]), np.array([0.4])).log_evidences()[0, :, 0]
    # The first column has the wide prior of H besides: as one more independent statement about it.
    deviations = regression.known_deviation.copy()
    for place in (0, 3, 30):
        one = optional.alternatives[place]
        covariance = np.diag(0.4**2 / weights) + 0.7**2 * wander.correlation
        columns = regression.normal[:, :3]
        precision = deviations**-2.0
        precision[0] += 30.0**-2.0
        covariance = covariance + (columns / precision) @ columns.T
        if one.column is not None:
            covariance = covariance + one.deviation**2 * np.outer(*2 * [optional.settling[:, one.column]])
        mean = columns @ regression.known_mean
        expected = multivariate_normal(mean, covariance).logpdf(regression.reading) + np.log(one.probability)
        reference = multivariate_normal(mean, np.eye(count)).logpdf(mean)
        if place == 0:
            offset = found[place] - (expected - reference)
        assert found[place] - (expected - reference) == pytest.approx(offset, abs=1e-8)


@pytest.mark.parametrize("seed", range(6))
def test_sound_reading_tells_the_wear_and_is_not_doubted(seed):
    posterior = depth_posterior(reading(np.random.default_rng(seed)))
    depth, spread = posterior.together
    assert abs(depth - DEPTH) < 3.5 * spread
    assert spread < 0.1e-6
    assert posterior.log_odds < DECISIVE


DISTURBED = {
    "settling": lambda time, _: 2e-6 * -np.expm1(-time / 0.2),
    "sine": lambda time, _: 0.5e-6 * np.sin(14 * time),
    "falling rate": lambda time, _: 2e-6 * np.minimum(time, 0.3),
}


@pytest.mark.parametrize("name", DISTURBED)
def test_disturbed_reading_tells_the_wear_and_is_doubted(name):
    for seed in range(3):
        posterior = depth_posterior(reading(np.random.default_rng(seed), DISTURBED[name]))
        depth, spread = posterior.together
        assert abs(depth - DEPTH) < 3.5 * spread
        assert posterior.log_odds > DECISIVE


WARMING_TIME = np.arange(1, SAMPLES + 1) / SAMPLES
WARMING = np.sin(9 * WARMING_TIME) + 4 * WARMING_TIME
"""Temperature of a room, K."""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("disturbance", "thermal", "settles"),
    [
        (0.0, (0.0, 0.1), (0.0, 0.1)),
        (0.3e-6 * WARMING, (0.99, 1.0), (0.0, 0.1)),
        (lambda time, _: 3e-6 * -np.expm1(-time / 0.15), (0.0, 0.1), (0.99, 1.0)),
        (lambda time, _: 0.3e-6 * WARMING - 2e-6 * np.expm1(-time / 0.15), (0.99, 1.0), (0.99, 1.0)),
    ],
    ids=["neither", "temperature", "settling", "both"],
)
def test_reading_may_follow_the_temperature_settle_or_both(disturbance, thermal, settles):
    for seed in range(3):
        one = reading(np.random.default_rng(seed), disturbance)
        posterior = depth_posterior(replace(one, temperature=295 + blocks_of(WARMING_TIME).mean(WARMING)))
        depth, spread = posterior.together
        assert abs(depth - DEPTH) < 3.5 * spread
        assert thermal[0] <= posterior.thermal_probability <= thermal[1]
        assert settles[0] <= posterior.settling_probability <= settles[1]


def test_walk_of_the_sensor_leaves_the_wear_to_the_measurement():
    def walk(time, rng):
        return 2e-6 * np.cumsum(rng.standard_normal(len(time))) / np.sqrt(len(time))

    posterior = depth_posterior(reading(np.random.default_rng(5), walk))
    depth, spread = posterior.together
    assert abs(depth - DEPTH) < 3.5 * spread
    assert spread > 0.1e-6


def test_draws_of_the_end_depth_have_its_moments():
    posterior = depth_posterior(reading(np.random.default_rng(3)))
    probability = (np.arange(4000) + 0.5) / 4000
    drawn = posterior.end_depths(probability, np.ones(4000))
    depth, spread = posterior.together
    assert np.mean(drawn) == pytest.approx(depth, abs=0.05 * spread)
    assert np.std(drawn) == pytest.approx(spread, rel=0.05)


@pytest.mark.parametrize("share", [0.02, 0.1])
def test_reading_that_tells_nothing_leaves_the_wear_as_the_scar_has_it(share):
    """Wear as straight as drift, and a depth that grows with the square of the diameter that was measured."""
    one = reading(np.random.default_rng(9))
    straight = replace(one, course=lambda end: end * one.time, depth=one.depth - one.course(DEPTH) + DEPTH * one.time)
    measured = MeasuredDepth(DEPTH * (1 + share * SCORES) ** 2, lambda end: end)
    posterior = depth_posterior(replace(straight, measured=(measured,)))
    scores = np.array([-1.96, -1.0, 0.0, 1.0, 1.96])
    drawn = posterior.end_depths(norm.cdf(scores), np.ones(len(scores)))
    np.testing.assert_allclose(drawn, DEPTH * (1 + share * scores) ** 2, atol=0.01 * measured.uncertainty)


@pytest.mark.parametrize("spread", [10e-9, 0.2e-6, 5e-6])
def test_terms_change_with_the_scale_of_the_reading_as_if_it_were_fitted_anew(spread):
    found = reading(np.random.default_rng(7), spread=spread)
    low, high = (depth_posterior(replace(found, depth=found.depth * (1 + by))).terms[0] for by in (-1e-5, 1e-5))
    offset, drift = depth_posterior(found).terms_per_scale[:2]
    np.testing.assert_allclose([offset, drift], (high - low)[:2] / 2e-5, rtol=0.05, atol=0.02e-6)


@pytest.mark.parametrize("beside", [0.0, 30e-9])
def test_quantiles_of_the_drift_are_those_of_draws_from_all_ways(beside):
    rng = np.random.default_rng(12)
    posterior = depth_posterior(reading(rng, spread=0.2e-6))
    means, covariances = posterior._anchored
    way = rng.choice(len(posterior.weights), size=200_000, p=posterior.weights)
    spread = np.hypot(np.sqrt(covariances[way, 2, 2]), beside)
    drawn = means[way, 2] + spread * rng.standard_normal(len(way))
    found = posterior.term_quantiles(1, np.array([0.025, 0.5, 0.975]), beside)
    np.testing.assert_allclose(found, np.quantile(drawn, [0.025, 0.5, 0.975]), atol=0.02 * np.std(drawn))


@pytest.mark.slow
@pytest.mark.parametrize("spread", [10e-9, 0.2e-6])
def test_drift_is_off_by_what_its_uncertainty_says_where_the_scale_is_off(spread):
    """The scale takes 100 nm of 20 µm, ten times what an exact measurement of the end may be off by."""
    scale, off = Quantity(value=1.0, unit="1", standard_uncertainty=0.005), []
    for seed in range(30):
        rng = np.random.default_rng([seed, 11])
        found = reading(rng, spread=spread)
        found = replace(found, depth=found.depth * (1 + 0.005 * rng.standard_normal()))
        drift = depth_model(depth_posterior(found), 1.0, scale).drift_rate
        off.append((drift.value + 0.4e-6) / drift.standard_uncertainty)
    low, high = np.sqrt(chi2.ppf([0.001, 0.999], len(off)) / len(off))
    assert low < np.sqrt(np.mean(np.square(off))) < high


def test_measurement_and_wear_differ_as_each_way_has_it():
    """One way follows the curve, which is sure of another depth, and one the measurement, whose curve knows little."""
    known = depth_posterior(reading(np.random.default_rng(4)))
    anchor, tight, wide, apart = 0.2e-6, 0.02e-6, 2e-6, 0.6e-6

    def of(*ways):
        count = len(ways)
        columns = np.zeros((count, known.ways.mean.shape[1]))
        columns[:, 0] = [mean for mean, _ in ways]
        covariance = np.zeros((count, columns.shape[1], columns.shape[1]))
        covariance[:, 0, 0] = [deviation**2 for _, deviation in ways]
        logs = np.zeros(count)
        changed = replace(known.ways, mean=columns, covariance=covariance, log_evidence=logs, log_anchored=logs)
        return replace(known, ways=changed, anchor=Anchor(0.0, anchor))

    alone = of((apart, tight))
    assert alone.shared_variance == pytest.approx(alone.together[1] ** 2, rel=1e-6)
    both = of((apart, tight), (0.0, wide))
    assert both.together[1] > anchor
    assert anchor**2 - both.shared_variance == pytest.approx(anchor**2 / 2, rel=0.02)


@settings(max_examples=25, deadline=None)
@given(st.floats(0.1, 0.9), st.sampled_from([-1.0, 1.0]), st.integers(0, 1000))
@example(0.3125, -1.0, 500)
def test_step_is_found_at_its_sample(place, sign, seed):
    rng = np.random.default_rng(seed)
    time = np.arange(1, SAMPLES + 1) / SAMPLES
    at = int(place * SAMPLES)
    depth = DEPTH * np.sqrt(time) + NOISE * rng.standard_normal(SAMPLES) + sign * 1e-6 * (np.arange(SAMPLES) >= at)
    (found,) = steps(time, 500 * time, depth)
    assert abs(found - at) <= 1


@pytest.mark.parametrize("name", DISTURBED)
def test_smooth_curves_have_no_steps(name):
    rng = np.random.default_rng(7)
    time = np.arange(1, SAMPLES + 1) / SAMPLES
    depth = DEPTH * np.sqrt(time) + NOISE * rng.standard_normal(SAMPLES) + DISTURBED[name](time, rng)
    assert steps(time, 500 * time, depth) == []


@pytest.mark.parametrize("disturbance", ["none", "settling", "line"])
@pytest.mark.parametrize("prior", ["drift", "settling"])
def test_wider_prior_without_a_fit_is_that_of_another_fit(prior, disturbance, monkeypatch):
    added = {**DISTURBED, "none": 0.0, "line": lambda time, _: -2e-6 * time}[disturbance]
    one = reading(np.random.default_rng(2), added)
    if prior == "drift":
        one = replace(one, measured=(), drift_deviation=0.5e-6)
        again = replace(one, drift_deviation=1e-6)
    else:
        again = replace(one)
        with monkeypatch.context() as patch:
            patch.setattr("tribopipe.physics.depth_model.terms.AMPLITUDES", tuple(2 * share for share in AMPLITUDES))
            assert again.optional.alternatives[1].deviation == 2 * AMPLITUDES[0]
    before = depth_posterior(one)
    found, fitted = widened(before, prior), depth_posterior(again)
    assert found.together[0] == pytest.approx(fitted.together[0], abs=0.1 * fitted.together[1])
    assert found.together[1] == pytest.approx(fitted.together[1], rel=0.1)
    if (prior, disturbance) == ("drift", "line"):
        assert abs(found.together[0] - before.together[0]) > 0.1 * before.together[1]


def test_run_without_measurement_is_fitted_by_the_sensor_alone_and_says_so():
    raw = record(*CASES["si3n4-air-200mN"])
    bare = replace(raw, manifest=raw.manifest.model_copy(update={"end_values": EndValues()}))
    fit = fit_wear(correct_drift(bare), "archard")
    assert (fit.basis, fit.first.measured_end_depth) == ("reading", None)
    assert "no_post_test_measurement" in {finding.code for finding in fit.findings}
    truth = CASES["si3n4-air-200mN"][1].wear_coefficient.value
    assert abs(fit.first.wear_coefficient.value - truth) < 3.5 * fit.first.wear_coefficient.standard_uncertainty


@pytest.mark.slow
@pytest.mark.parametrize(
    ("drift", "codes"), others_slow([(0.0, set()), (2e-6, {"depends_on_drift_prior"}), (-0.2e-6, set())], first=2)
)
def test_k_d_by_the_sensor_alone_says_whether_it_depends_on_the_prior_of_the_drift(drift, codes):
    raw = record(*CASES["si3n4-air-200mN"])
    ramp = drift * raw.columns["time"] / raw.columns["time"][-1]
    manifest = raw.manifest.model_copy(update={"end_values": EndValues()})
    corrected = correct_drift(
        replace(raw, manifest=manifest, columns={**raw.columns, "depth": raw.columns["depth"] + ramp})
    )
    fit = fit_wear(corrected, recipe=Recipe(uncertainty=DefaultUncertainty(unseen_groove=0.0)))
    found = [finding for finding in fit.findings if finding.code.startswith("depends_on")]
    assert {finding.code for finding in found} == codes
    assert {finding.severity for finding in found} <= {"note"}
    measured = fit_wear(correct_drift(replace(raw, columns={**raw.columns, "depth": raw.columns["depth"] + ramp})))
    assert not [finding for finding in measured.findings if finding.code.startswith("depends_on")]


@pytest.mark.parametrize(("groove", "pin"), [(2.27431338e-3, 0.0226845810), (0.0116358510, 0.0203924148)])
def test_pin_on_a_wearing_track_has_lost_the_volume_that_archard_s_law_says(groove, pin):
    radius, volume = 0.794, 1.35e-8 * 0.2 * 500e3
    cap = np.pi * pin**2 * (radius - pin / 3)
    assert cap * volume_growth(groove / pin) == pytest.approx(volume, rel=3e-3)


def test_noise_of_a_curve_does_not_depend_on_the_directions_that_lapack_finds(monkeypatch):
    corrected, recipe, eigh = correct_drift(record(*CASES["si3n4-air-200mN"])), Recipe(), np.linalg.eigh
    problem = depth_problem(wear_problem(corrected, "archard", None, recipe), corrected, recipe)
    drawn = problem.draw_noise(np.random.default_rng(1), 3)
    again = replace(problem)
    assert again.posterior.noise > 0

    def turned(matrix):
        powers, along = eigh(matrix)
        return powers[::-1], -along[:, ::-1]

    monkeypatch.setattr(np.linalg, "eigh", turned)
    np.testing.assert_allclose(again.draw_noise(np.random.default_rng(1), 3), drawn, rtol=1e-9, atol=1e-15)

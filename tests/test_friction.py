"""Eq. 7 recovered where it is there, and not claimed where it is not."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import FrictionRecipe
from tribopipe.evaluation.friction import fit_friction
from tribopipe.results.run import RawRun

TABLE_2 = {200: (0.226, 0.496, 32.877), 400: (0.244, 0.396, 607.837), 800: (0.284, 0.404, 81.704)}


def with_friction(run: RawRun, mu, distance=None, **origins) -> RawRun:
    """The run with another friction coefficient, as an instrument that gives μ itself records it."""
    distance = np.linspace(0, 500, len(mu)) if distance is None else distance
    columns = {
        "time": distance / 0.4,
        "sliding_distance": distance,
        "friction_coefficient": np.asarray(mu, dtype=float),
    }
    return replace(run, columns=columns, origins=dict.fromkeys(columns, "measured") | origins)


def exponential(distance, amplitude, steady, running_in):
    return amplitude * np.exp(-distance / running_in) + steady


@pytest.mark.parametrize("load", TABLE_2)
def test_parameters_of_table_2_come_back_from_noiseless_data(bare_run, load):
    distance = np.linspace(0, 500, 5001)
    fit = fit_friction(with_friction(bare_run, exponential(distance, *TABLE_2[load]), distance))
    found = [fit.amplitude.value, fit.steady_state.value, fit.running_in_distance.value]
    np.testing.assert_allclose(found, TABLE_2[load], rtol=1e-6)
    assert fit.outcome == "exponential"


@pytest.mark.slow
@settings(max_examples=30, deadline=None)
@example(0.5, 0.0546875, 10.0, -1.0, 1689)  # starts at nothing, within its uncertainty below it
@example(0.05, 0.0508, 10.0, -1.0, 11943)
@given(
    st.floats(0.05, 0.6),
    st.floats(0.05, 0.8),
    st.floats(10, 150),
    st.sampled_from([1.0, -1.0]),
    st.integers(0, 2**32 - 1),
)
def test_parameters_come_back_within_four_standard_uncertainties(bare_run, amplitude, steady, running_in, sign, seed):
    truth = (sign * min(amplitude, 0.9 * steady) if sign < 0 else amplitude, steady, running_in)
    distance = np.linspace(0, 500, 2501)
    noise = 0.01 * np.random.default_rng(seed).standard_normal(len(distance))
    # A start below half of the later level is a loading ramp unless the window is given.
    fit = fit_friction(
        with_friction(bare_run, exponential(distance, *truth) + noise, distance), window_from_the_start()
    )
    assert fit.outcome == "exponential"
    for found, wanted in zip((fit.amplitude, fit.steady_state, fit.running_in_distance), truth, strict=True):
        assert abs(found.value - wanted) < 4.5 * found.standard_uncertainty


def window_from_the_start() -> FrictionRecipe:
    return FrictionRecipe(start=Quantity(value=1e-12, unit="m"))


def test_running_in_longer_than_the_run_is_flagged(bare_run):
    distance = np.linspace(0, 500, 5001)
    fit = fit_friction(with_friction(bare_run, exponential(distance, *TABLE_2[400]), distance))
    assert any("exceeds the fitted length" in note for note in fit.notes)


@pytest.mark.parametrize(
    ("shape", "reason"),
    [
        (lambda s: np.full_like(s, 0.4), "constant"),
        (lambda s: 0.6 - 0.2 * s / 500, "changes linearly"),
        (lambda s: 0.3 + 0.1 * s / 500, "changes linearly"),
        (lambda s: 0.4 + 0.05 * np.sin(s / 40), None),
    ],
)
def test_what_is_no_running_in_gives_the_steady_value_and_the_reason(bare_run, shape, reason):
    distance = np.linspace(0, 500, 2501)
    noise = 0.02 * np.random.default_rng(7).standard_normal(len(distance))
    fit = fit_friction(with_friction(bare_run, shape(distance) + noise, distance))
    assert fit.outcome == "steady-only"
    assert fit.amplitude is None
    assert fit.running_in_distance is None
    assert fit.steady_state.value == pytest.approx(float(np.mean(shape(distance)[1250:])), abs=0.02)
    if reason:
        assert reason in " ".join(fit.notes)


def test_one_odd_first_point_is_no_running_in(bare_run):
    mu = 0.4 + 0.01 * np.random.default_rng(3).standard_normal(500)
    mu[0] = 0.9
    assert fit_friction(with_friction(bare_run, mu)).outcome == "steady-only"


@pytest.mark.slow
def test_a_running_in_of_few_samples_is_not_stretched_to_more(bare_run):
    """Four samples of running-in by chance look like six in one run of fifty: longer by half, and sure of it."""
    distance = np.linspace(0, 500, 60)
    for seed in range(150):
        mu = exponential(distance, *TABLE_2[200]) + 0.02 * np.random.default_rng(seed).standard_normal(60)
        assert fit_friction(with_friction(bare_run, mu, distance)).outcome == "steady-only"


def test_loading_ramp_is_left_out(bare_run):
    distance = np.linspace(0.1, 500, 5000)
    mu = exponential(distance, 0.2, 0.4, 60.0)
    ramp = distance < 5
    mu[ramp] *= distance[ramp] / 5
    fit = fit_friction(with_friction(bare_run, mu, distance))
    assert fit.window[0].value == pytest.approx(5.0, abs=0.2)
    assert fit.amplitude.value == pytest.approx(0.2, rel=1e-3)
    assert "loading ramp" in fit.notes[0]


@pytest.mark.parametrize("share", [1.0, 0.93])
def test_loading_ramp_is_seen_in_the_measured_load(bare_run, share):
    distance = np.linspace(0.1, 500, 5000)
    run = with_friction(bare_run, exponential(distance, 0.2, 0.4, 60.0), distance)
    load = share * run.manifest.conditions.normal_load.value
    columns = dict(run.columns) | {"normal_force": load * np.clip(distance / 8, 0, 1)}
    fit = fit_friction(replace(run, columns=columns, origins=dict(run.origins) | {"normal_force": "measured"}))
    assert fit.window[0].value == pytest.approx(0.95 * 8, abs=0.2)


def test_friction_under_a_small_part_of_a_slowly_rising_load_is_not_fitted(bare_run):
    distance = np.linspace(0.3, 500, 1500)
    load = np.minimum(distance / 150, 1.0)
    held = np.zeros(3)
    for seed in range(20):
        noise = np.random.default_rng(seed).normal(0, 0.01, len(distance))
        run = with_friction(bare_run, exponential(distance, 0.25, 0.45, 40.0) + noise / load, distance)
        columns = dict(run.columns) | {"normal_force": load * run.manifest.conditions.normal_load.value}
        fit = fit_friction(replace(run, columns=columns, origins=dict(run.origins) | {"normal_force": "measured"}))
        found = (fit.amplitude, fit.steady_state, fit.running_in_distance)
        held += [
            abs(one.value - true) < 1.96 * one.u_or_zero for one, true in zip(found, (0.25, 0.45, 40.0), strict=True)
        ]
        assert fit.window[0].value == pytest.approx(75, abs=0.5)
        assert "A is extrapolated" in fit.notes[1]
    assert np.all(held >= 16)


@pytest.mark.parametrize("digits", [6, 1], ids=["fine", "coarse"])
@pytest.mark.parametrize("where", ["before", "during", "after", "creeping"])
def test_friction_at_rest_is_none_of_the_path(bare_run, where, digits):
    moving = np.ones(4900, dtype=bool)
    moving[{"before": slice(0, 90), "after": slice(-120, None)}.get(where, slice(2000, 2120))] = False
    rng = np.random.default_rng(7)
    speed = 0.1 * moving + (1e-6 if where == "creeping" else 0.0)
    distance = np.cumsum(speed)
    mu = np.where(moving, exponential(distance, 0.2, 0.55, 40.0), 0.0) + rng.normal(0, 0.01, len(moving))
    fit = fit_friction(with_friction(bare_run, mu, np.round(distance, digits)))
    for found, true in ((fit.amplitude, 0.2), (fit.steady_state, 0.55), (fit.running_in_distance, 40.0)):
        assert abs(found.value - true) < 3.5 * found.standard_uncertainty < 0.2 * true
    assert ("loading ramp" if where == "before" else "does not increase") in fit.notes[0]


def test_slow_sliding_and_coarse_distances_are_no_rest(bare_run):
    speed = np.concatenate([np.full(1000, 0.1), np.full(1000, 0.001), np.full(1000, 0.1)])
    distance = np.round(np.cumsum(speed), 1)
    mu = exponential(distance, 0.2, 0.55, 40.0) + np.random.default_rng(7).normal(0, 0.01, len(speed))
    assert not any("does not increase" in note for note in fit_friction(with_friction(bare_run, mu, distance)).notes)


def test_mean_and_deviation_are_those_of_everything_recorded(bare_run):
    mu = np.concatenate([[0.0, 0.1], np.random.default_rng(0).normal(0.5, 0.05, 400), [np.nan]])
    fit = fit_friction(with_friction(bare_run, mu))
    assert fit.mean.value == pytest.approx(np.nanmean(mu), rel=1e-12)
    assert fit.standard_deviation.value == pytest.approx(np.nanstd(mu, ddof=1), rel=1e-12)


def test_missing_samples_are_left_out(bare_run):
    distance = np.linspace(0, 500, 5001)
    mu = exponential(distance, *TABLE_2[200])
    mu[::7] = np.nan
    fit = fit_friction(with_friction(bare_run, mu, distance))
    assert fit.running_in_distance.value == pytest.approx(32.877, rel=1e-6)


def test_window_of_the_recipe_is_kept(bare_run):
    distance = np.linspace(0, 500, 5001)
    recipe = FrictionRecipe(start=Quantity(value=20.0, unit="m"), end=Quantity(value=300.0, unit="m"))
    fit = fit_friction(with_friction(bare_run, exponential(distance, *TABLE_2[200]), distance), recipe)
    assert (fit.window[0].value, fit.window[1].value) == (pytest.approx(20.0), pytest.approx(300.0))
    assert fit.amplitude.value == pytest.approx(0.226, rel=1e-5)


def test_run_without_friction_says_so(bare_run):
    distance = np.linspace(0, 500, 100)
    run = replace(bare_run, columns={"time": distance, "sliding_distance": distance}, origins={})
    fit = fit_friction(run)
    assert fit.outcome == "none"
    assert "has no friction signal" in str(fit)


@pytest.mark.parametrize(
    ("mu", "reason"),
    [
        (np.zeros(500), "is constant"),
        (np.full(500, 0.4), "is constant"),
        (-0.4 - 0.2 * np.exp(-np.linspace(0, 10, 500)), "negative"),
        (np.concatenate([np.full(3, 500.0), np.full(2000, 0.4) + 1e-3 * np.sin(np.arange(2000))]), "shorter than 5"),
    ],
)
def test_what_no_friction_looks_like_is_said_to_be_so(bare_run, mu, reason):
    fit = fit_friction(with_friction(bare_run, mu))
    assert fit.outcome == "steady-only"
    assert reason in " ".join(fit.notes)


def test_a_clock_coarser_than_the_sampling_rate_still_identifies_running_in(bare_run):
    """Three samples in four share their place with the one before, so that half of the steps and more are nothing."""
    place = np.repeat(np.linspace(0, 500, 1251), 4)
    distance = np.linspace(0, 500, len(place))
    fit = fit_friction(with_friction(bare_run, exponential(distance, 0.226, 0.496, 32.877), place))
    found = [fit.amplitude.value, fit.steady_state.value, fit.running_in_distance.value]
    np.testing.assert_allclose(found, [0.226, 0.496, 32.877], rtol=0.01)


def test_a_distance_that_never_grows_gives_the_steady_value(bare_run):
    mu = 0.5 + 0.01 * np.sin(np.arange(500))
    fit = fit_friction(with_friction(bare_run, mu, np.zeros(500)))
    assert fit.outcome == "steady-only"
    assert "distance" in fit.notes[0]

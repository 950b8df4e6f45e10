"""Drift correction, against depth signals whose drift and wear are known."""

from dataclasses import replace

import numpy as np
import pytest
from folders import SAMPLES
from hypothesis import given, settings
from hypothesis import strategies as st

from tribopipe.base.errors import FitError
from tribopipe.documents.manifest import EndValues
from tribopipe.documents.quantity import EndValue
from tribopipe.documents.recipe import Recipe, WearRecipe
from tribopipe.evaluation.depth_reading import sliding_time
from tribopipe.evaluation.drift import correct_drift
from tribopipe.extras.simulate.instrument import correlated as _correlated
from tribopipe.physics.pin_on_disc import SphericalPin
from tribopipe.readers.harmonize import read_run
from tribopipe.results.run import RawRun

WEAR_END = 23e-6


TWO_STEP = Recipe(wear=WearRecipe(correction="two-step"))


def with_depth(run: RawRun, reading, end: EndValues, distance=None) -> RawRun:
    distance = np.linspace(0, 500, len(reading)) if distance is None else distance
    columns = {"time": distance / 0.4, "sliding_distance": distance, "depth": np.asarray(reading, dtype=float)}
    manifest = run.manifest.model_copy(update={"end_values": end})
    return replace(run, manifest=manifest, columns=columns, origins=dict.fromkeys(columns, "measured"))


def metres(value: float, spread: float | None = None) -> EndValue:
    return EndValue(value=value, unit="m", standard_uncertainty=spread)


PIN = SphericalPin(normal_load=0.2, radius=0.794e-3, modulus=304e9 / (2 * (1 - 0.24**2)))
"""The bare run's pin under its load."""


def worn_pin(spread: float | None = None) -> EndValues:
    """The pin measured, and a disc that has not worn."""
    return EndValues(pin_wear_depth=metres(WEAR_END, spread), disc_wear_depth=metres(0.0, 1e-9))


def wear_curve(distance):
    return PIN.worn(PIN.volume(WEAR_END) * distance / distance[-1]).depth


@pytest.mark.slow
@settings(max_examples=20, deadline=None)
@given(st.floats(-50e-6, 50e-6), st.floats(-5e-9, 5e-9))
def test_offset_and_drift_of_a_noiseless_signal_come_back(bare_run, offset, rate):
    distance = np.linspace(0, 500, 2001)
    reading = offset + wear_curve(distance) + rate * distance / 0.4
    corrected = correct_drift(with_depth(bare_run, reading, worn_pin(1e-7), distance))
    # A straight line through the last samples is not the curve that they are of.
    assert corrected.correction.zero_offset.value == pytest.approx(offset, abs=4e-9)
    assert corrected.correction.drift_rate.value == pytest.approx(rate, abs=1e-11)
    np.testing.assert_allclose(corrected.wear_depth, wear_curve(distance), atol=1e-8)


@pytest.mark.parametrize("slid", [-4.0, 0.0, 100.0])
def test_drift_counts_from_where_sliding_began_wherever_the_record_begins(bare_run, slid):
    distance = np.linspace(slid, 500, 2001)
    started, time = -slid / 0.4, (distance - slid) / 0.4
    wear = PIN.worn(PIN.volume(WEAR_END) * np.maximum(distance, 0.0) / 500).depth
    run = with_depth(bare_run, 3e-6 + wear + 2e-9 * (time - started), worn_pin(1e-9), distance)
    correction = correct_drift(replace(run, columns=run.columns | {"time": time}), TWO_STEP).correction
    # The discrepancy at the end has built up over 500 m at 0.4 m/s, recorded or not.
    assert correction.drift_rate.value == pytest.approx(correction.discrepancy.value / 1250, rel=1e-12)
    assert correction.drift_rate.value == pytest.approx(2e-9, rel=0.001)
    assert correction.zero_offset.value == pytest.approx(3e-6, abs=1e-8)


def test_a_record_that_rests_throughout_the_first_window_has_an_offset_all_the_same(bare_run):
    """Nothing wears before sliding begins, so that the window has no wear to tell from the offset."""
    distance = np.linspace(-40, 500, 2001)
    wear = PIN.worn(PIN.volume(WEAR_END) * np.maximum(distance, 0.0) / 500).depth
    corrected = correct_drift(with_depth(bare_run, 3e-6 + wear, worn_pin(1e-9), distance), TWO_STEP).correction
    assert corrected.zero_offset.value == pytest.approx(3e-6, rel=1e-5)
    assert corrected.drift_rate.value == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(("slid", "start"), [(-40.0, 107.0), (0.0, 7.0), (100.0, -243.0)])
def test_sliding_began_where_the_distance_is_nothing(slid, start):
    distance = np.linspace(slid, 500, 11)
    began, lasted = sliding_time(distance, 7.0 + (distance - slid) / 0.4)
    assert began == pytest.approx(start, rel=1e-12)
    assert lasted == pytest.approx(500 / 0.4, rel=1e-12)


def test_corrected_curve_ends_on_the_end_value_and_starts_at_zero(bare_run):
    distance = np.linspace(0, 500, 2001)
    reading = 3e-6 + wear_curve(distance) - 1e-9 * distance / 0.4
    end = EndValues(pin_wear_depth=metres(WEAR_END), disc_wear_depth=metres(0.15e-6))
    corrected = correct_drift(with_depth(bare_run, reading, end), TWO_STEP)
    assert corrected.wear_depth[-1] == pytest.approx(WEAR_END + 0.15e-6, abs=1e-9)
    assert corrected.correction.anchor == "pin_wear_depth + disc_wear_depth"
    assert corrected.pin_wear_depth[-1] == pytest.approx(WEAR_END, abs=1e-9)


def test_scar_diameter_counts_as_the_height_of_its_cap(bare_run):
    radius = bare_run.manifest.contact.pin.radius.value
    scar = 2 * np.sqrt(WEAR_END * (2 * radius - WEAR_END))
    reading = wear_curve(np.linspace(0, 500, 2001))
    correction = correct_drift(
        with_depth(bare_run, reading, EndValues(pin_scar_diameter=metres(scar, 2e-6)))
    ).correction
    assert correction.pin_wear_depth.value == pytest.approx(WEAR_END, rel=1e-12)
    step = 1e-9
    above = correct_drift(
        with_depth(bare_run, reading, EndValues(pin_scar_diameter=metres(scar + step, 2e-6)))
    ).correction
    slope = (above.pin_wear_depth.value - correction.pin_wear_depth.value) / step
    assert correction.pin_wear_depth.standard_uncertainty == pytest.approx(2e-6 * slope, rel=1e-4)


def test_of_depth_and_scar_the_more_certain_one_is_the_anchor(bare_run):
    reading = wear_curve(np.linspace(0, 500, 2001))
    end = EndValues(pin_wear_depth=metres(WEAR_END, 1e-7), pin_scar_diameter=metres(380e-6, 10e-6))
    assert correct_drift(with_depth(bare_run, reading, end)).correction.anchor == "pin_wear_depth"


@pytest.mark.parametrize("discrepancy", [0.1e-6, 0.6e-6, 2e-6])
def test_discrepancy_is_what_sensor_and_end_value_differ_by(bare_run, discrepancy):
    distance = np.linspace(0, 500, 2001)
    reading = wear_curve(distance) + discrepancy * distance / 500
    correction = correct_drift(with_depth(bare_run, reading, worn_pin())).correction
    assert correction.discrepancy.value == pytest.approx(discrepancy, rel=0.05)


@pytest.mark.parametrize(("memory", "slid"), [(0.01, 0.0), (4.0, 0.0), (4.0, 200.0)])
def test_stated_uncertainties_are_those_of_repeated_runs(bare_run, memory, slid):
    distance, rng = np.linspace(slid, 500, 4001), np.random.default_rng(2)
    found = []
    for _ in range(200):
        scale = 1 + TWO_STEP.uncertainty.depth_scale * rng.standard_normal()
        reading = scale * wear_curve(distance) + 1e-7 * _correlated(rng, 4001, memory)
        end = EndValues(pin_wear_depth=metres(WEAR_END + 2e-8 * rng.standard_normal(), 2e-8))
        found.append(correct_drift(with_depth(bare_run, reading, end, distance), TWO_STEP).correction)
    for name in ("zero_offset", "drift_rate"):
        values = [getattr(one, name).value for one in found]
        stated = np.mean([getattr(one, name).standard_uncertainty for one in found])
        assert stated == pytest.approx(np.std(values), rel=0.2)


@pytest.mark.parametrize(
    ("end", "missing"),
    [(EndValues(), "post-test measurement"), (EndValues(disc_wear_depth=metres(1e-7)), "post-test measurement")],
)
def test_run_without_an_end_value_of_the_pin_passes_through(bare_run, end, missing):
    corrected = correct_drift(with_depth(bare_run, np.linspace(0, 1e-5, 100), end), TWO_STEP)
    assert corrected.wear_depth is None
    assert missing in str(corrected.correction)


@pytest.mark.parametrize("noise", [20e-9, 0.5e-6])
def test_wander_is_found_where_it_rises_above_the_noise(bare_run, noise):
    distance, rng = np.linspace(0, 500, 2001), np.random.default_rng(3)
    wave = 0.3e-6 * np.sin(12 * np.pi * distance / 500)
    reading = wear_curve(distance) + noise * rng.standard_normal(2001)
    end = EndValues(pin_wear_depth=metres(WEAR_END, 1e-7))
    assert correct_drift(with_depth(bare_run, reading, end)).wander is None
    found = correct_drift(with_depth(bare_run, reading + wave, end))
    # Offset, drift and wear take what a wave has of their shapes.
    shapes = np.column_stack([wave, np.ones(2001), distance, wear_curve(distance)])
    share, *_ = np.linalg.lstsq(shapes, found.wander, rcond=None)[0]
    assert 0.75 < share < 1.05  # noise draws it towards zero
    assert np.std(found.wander - shapes @ np.linalg.lstsq(shapes, found.wander, rcond=None)[0]) < 20e-9 + noise / 5


def test_all_wear_that_a_sensor_shows_is_of_the_pin_where_nothing_was_measured(bare_run):
    distance, rng = np.linspace(0, 500, 1001), np.random.default_rng(5)
    reading = wear_curve(distance) + 50e-9 * rng.standard_normal(1001)
    alone = correct_drift(with_depth(bare_run, reading, EndValues()))
    np.testing.assert_array_equal(alone.pin_wear_depth, alone.wear_depth)
    np.testing.assert_allclose(alone.pin_wear_depth, wear_curve(distance), atol=0.5e-6)
    groove = EndValues(disc_wear_depth=metres(2e-6, 1e-7))
    assert correct_drift(with_depth(bare_run, reading, groove)).pin_wear_depth is None


def test_run_without_depth_passes_through(bare_run):
    run = with_depth(bare_run, np.linspace(0, 1e-5, 100), worn_pin())
    del run.columns["depth"]
    assert "depth signal" in str(correct_drift(run).correction)


def test_missing_samples_stay_missing(bare_run):
    reading = wear_curve(np.linspace(0, 500, 2001))
    reading[100:200] = np.nan
    corrected = correct_drift(with_depth(bare_run, reading, worn_pin()))
    assert np.count_nonzero(np.isnan(corrected.wear_depth)) == 100


def test_too_few_samples_are_refused(bare_run):
    with pytest.raises(FitError, match="5 valid depth samples"):
        correct_drift(with_depth(bare_run, np.linspace(0, 1e-5, 5), worn_pin()))


def test_wear_before_the_first_and_after_the_last_sample_is_reckoned_with(bare_run):
    distance = np.linspace(0, 500, 12_501)
    reading = 2e-6 + wear_curve(distance) + 1e-9 * distance / 0.4
    reading[:250] = np.nan
    reading[-500:] = np.nan
    corrected = correct_drift(with_depth(bare_run, reading, worn_pin(), distance))
    np.testing.assert_allclose(corrected.wear_depth[250:-500], wear_curve(distance)[250:-500], atol=0.05e-6)


@pytest.mark.slow
@pytest.mark.parametrize(("scale", "codes"), [(1.0, set()), (5.0, {"reading_contradicts_measurement"})])
def test_reading_of_two_discs_is_held_against_what_was_measured_on_them(scale, codes):
    run = read_run(SAMPLES / "si3n4-twin-disc-10pct-1000k-a")
    depth = run.columns["depth"]
    read = replace(run, columns={**run.columns, "depth": depth[0] + scale * (depth - depth[0])})
    correction = correct_drift(read).correction
    assert {finding.code for finding in correction.findings} == codes
    assert all("both discs" in finding.message for finding in correction.findings)

"""A groove that nobody measured, next to a scar that was: told by the depth signal, and not mistaken for drift."""

from collections.abc import Callable

import numpy as np
import pytest
from groove_and_depth_signal import FIRST_ORDER, MEASURED, NOISE, PAIRS, RADIUS, SAMPLES, SCAR, SLID, Truth, run_of
from independent.wear import worn_pair

from tribopipe.documents.manifest import EndValue
from tribopipe.documents.recipe import Recipe
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.measurements.specific_wear import specific_wear
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.evaluation.wear.problem import depths_by_signal
from tribopipe.results.run import RawRun

PROGRESS = np.linspace(0.0, 1.0, SAMPLES)
DISTURBING: dict[str, Callable[[np.random.Generator], np.ndarray]] = {
    "drift": lambda _: 20e-6 * PROGRESS,
    "settling": lambda _: 4e-6 * (1 - np.exp(-PROGRESS / 0.2)),
    "creep": lambda _: 8e-6 * np.log1p(PROGRESS / 0.1) / np.log(11),
    "both": lambda _: 4e-6 * (1 - np.exp(-PROGRESS / 0.1)) + 4e-6 * PROGRESS,
    "wander": lambda rng: 3e-6 * np.cumsum(rng.standard_normal(SAMPLES)) / np.sqrt(SAMPLES),
}


def with_scar(raw: RawRun, key: str, value: float) -> RawRun:
    """Return a run of which one size of the scar was measured and nothing else."""
    ends = type(raw.manifest.end_values)(**{key: EndValue(value=value, unit="m", standard_uncertainty=SCAR)})
    manifest = raw.manifest.model_copy(update={"end_values": ends})
    return RawRun(manifest, raw.columns, raw.origins, {}, {}, ())


def both_worn(pair: str, seed: int) -> tuple[Truth, RawRun]:
    truth = Truth(*PAIRS[pair])
    return truth, run_of(truth, MEASURED["scar"], np.random.default_rng(seed), settles=False)


@pytest.mark.parametrize("pair", ["both bodies", "mainly the disc"])
def test_signal_and_scar_give_k_d_of_both(pair):
    truth, raw = both_worn(pair, 1)
    fit = fit_wear(raw, recipe=FIRST_ORDER)
    for body, k_d in (("pin", truth.ball), ("disc", truth.disc)):
        found = fit.bodies[body].wear_coefficient
        assert abs(found.value - k_d) < 3 * found.standard_uncertainty < 0.25 * k_d
    (warned,) = (finding for finding in fit.findings if finding.code == "disc_by_depth_signal")
    assert warned.severity == "warning"


@pytest.mark.slow
def test_mean_diameter_of_a_scar_does_as_well():
    truth, raw = both_worn("both bodies", 2)
    section = truth.disc * 5.0 * np.array([SLID]) / (2 * np.pi * 6e-3)
    worn = worn_pair(RADIUS, truth.ball * 5.0 * np.array([SLID]), section)
    ball, approach = worn.ball[-1], worn.ball[-1] + worn.groove[-1]
    mean = float(sum(np.sqrt(h * (2 * RADIUS - h)) for h in (ball, approach)))
    fit = fit_wear(with_scar(raw, "pin_scar_diameter", mean), recipe=FIRST_ORDER)
    found = fit.bodies["pin"].wear_coefficient
    assert abs(found.value - truth.ball) < 3 * found.standard_uncertainty


def test_correction_is_anchored_on_both():
    truth, raw = both_worn("both bodies", 3)
    correction = correct_drift(raw).correction
    assert correction.anchor == "pin_scar_length + depth_signal"
    both = truth.readings(np.array([SLID]), MEASURED["scar"])[0]
    assert abs(correction.approach.value - both) < 3 * correction.approach.standard_uncertainty
    assert correction.end_wear_depth.value == pytest.approx(correction.approach.value, rel=1e-6)
    assert abs(correction.drift_rate.value) * SLID / 0.4 < 3e-6


def approach_beside(depth: float, disturbing: Callable[[np.random.Generator], np.ndarray], seed: int):
    """Return what the signal shows of both bodies beside a pin on a disc that does not wear."""
    rng = np.random.default_rng(seed)
    _, raw = both_worn("both bodies", seed)
    shown = depth * np.sqrt(PROGRESS) + NOISE * rng.standard_normal(SAMPLES) + disturbing(rng)
    raw = RawRun(raw.manifest, raw.columns | {"depth": shown}, raw.origins, {}, {}, ())
    scar = 2 * np.sqrt(depth * (2 * RADIUS - depth)) + SCAR * rng.standard_normal()
    return correct_drift(with_scar(raw, "pin_scar_diameter", float(scar)), Recipe()).correction.approach


@pytest.mark.parametrize("disturbance", DISTURBING)
@pytest.mark.parametrize("depth", [5e-6, 15e-6])
def test_what_else_a_sensor_shows_is_no_groove(disturbance, depth):
    for seed in range(2):
        assert approach_beside(depth, DISTURBING[disturbance], seed) is None


@pytest.mark.slow
def test_what_a_sensor_may_drift_is_no_groove_whatever_its_course():
    assert approach_beside(2e-6, lambda _: 2.2e-6 * np.sqrt(PROGRESS), 1) is None
    assert approach_beside(2e-6, lambda _: 4e-6 * np.sqrt(PROGRESS), 1) is not None


@pytest.mark.slow
def test_width_of_a_scar_alone_is_not_the_wear_of_the_pin():
    """It is as wide as the groove: k_D of the ball was ten times too large, and its depth stated within 1 %."""
    truth, raw = both_worn("both bodies", 4)
    section = truth.disc * 5.0 * np.array([SLID]) / (2 * np.pi * 6e-3)
    worn = worn_pair(RADIUS, truth.ball * 5.0 * np.array([SLID]), section)
    approach = float(worn.ball[-1] + worn.groove[-1])
    width = 2 * np.sqrt(approach * (2 * RADIUS - approach))
    fit = fit_wear(with_scar(raw, "pin_scar_width", float(width)), recipe=FIRST_ORDER)
    for body, k_d in (("pin", truth.ball), ("disc", truth.disc)):
        found = fit.bodies[body].wear_coefficient
        assert abs(found.value - k_d) < 3 * found.standard_uncertainty


@pytest.mark.slow
def test_specific_wear_is_that_of_the_fit():
    truth, raw = both_worn("both bodies", 5)
    corrected = correct_drift(raw)
    found = specific_wear(corrected.run, None, depths_by_signal(corrected, Recipe()))
    fit = fit_wear(corrected, recipe=FIRST_ORDER)
    for body, k_d in (("pin", truth.ball), ("disc", truth.disc)):
        rate = getattr(found, body).specific_wear_rate
        assert abs(rate.value - k_d) < 3 * rate.standard_uncertainty < 0.5 * k_d
        assert rate.value == pytest.approx(fit.bodies[body].wear_coefficient.value, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("pair", ["both bodies", "mainly the disc"])
def test_part_of_the_pin_is_its_own_wear_all_along(pair):
    truth, raw = both_worn(pair, 6)
    corrected = correct_drift(raw)
    work = 5.0 * raw.sliding_distance
    worn = worn_pair(RADIUS * truth.radius, truth.ball * work, truth.disc * work / (2 * np.pi * 6e-3))
    end = corrected.correction.pin_wear_depth
    allowed = 4 * end.standard_uncertainty * worn.ball / worn.ball[-1] + 10 * NOISE
    assert np.all(np.abs(corrected.pin_wear_depth - worn.ball) < allowed)


@pytest.mark.parametrize("ratio", [1e-9, 5.0, 10.0])
def test_volume_of_a_pin_is_not_overruled_by_a_groove_that_the_sensor_has_read(ratio):
    """The signal of both bodies, taken for that of the pin alone, gave k_D 5 to 10 % too large, within 1 %."""
    volume, rng = 2e-14 * 5.0 * SLID, np.random.default_rng(7)
    worn = worn_pair(RADIUS, volume * PROGRESS, ratio * volume * PROGRESS / (2 * np.pi * 6e-3))
    _, raw = both_worn("both bodies", 7)
    shown = worn.ball + worn.groove + NOISE * rng.standard_normal(SAMPLES)
    ends = type(raw.manifest.end_values)(
        pin_wear_volume=EndValue(value=volume, unit="m^3", standard_uncertainty=0.1 * volume)
    )
    manifest = raw.manifest.model_copy(update={"end_values": ends})
    fit = fit_wear(RawRun(manifest, raw.columns | {"depth": shown}, raw.origins, {}, {}, ()), recipe=FIRST_ORDER)
    found = fit.bodies["pin"].wear_coefficient
    assert abs(found.value - 2e-14) < 2 * found.standard_uncertainty < 0.1 * 2e-14
    (told,) = (one for one in fit.findings if one.code in ("disc_not_measured", "disc_by_depth_signal"))
    assert "e-" not in told.message

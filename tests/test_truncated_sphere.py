"""The wear model of a truncated sphere: against the whole sphere, a flat pin, and its differential equation."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import MANIFEST
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from tribopipe.base.errors import ContactError
from tribopipe.contacts.pin_on_disc import pin_contact
from tribopipe.documents.manifest import EndValues, RunManifest
from tribopipe.documents.pin_on_flat import PinOnDisc
from tribopipe.documents.plan import Plan
from tribopipe.documents.quantity import EndValue, Quantity
from tribopipe.documents.recipe import MonteCarloRecipe, Recipe, WearRecipe
from tribopipe.documents.record import load_toml
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.measurements.specific_wear import specific_wear
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.evaluation.wear.prediction import predict_wear
from tribopipe.evaluation.wear.scenario import KnownWear, Scenario
from tribopipe.extras.simulate import simulate_plan
from tribopipe.physics.geometry import cap_height
from tribopipe.physics.hertz import contact_modulus, elastic_approach, hertz_radius
from tribopipe.physics.pin_on_disc import FlatPin, SphericalPin
from tribopipe.readers.harmonize import read_run
from tribopipe.results.run import RawRun

RADIUS, FLAT, LOAD, K_D = 0.794e-3, 80e-6, 0.2, 13.5e-15
MODULUS = contact_modulus(pin_modulus=304e9, pin_ratio=0.24, disc_modulus=304e9, disc_ratio=0.24)
SPHERE = SphericalPin(normal_load=LOAD, radius=RADIUS, modulus=MODULUS)


def truncated(flat: float, load: float = LOAD, modulus=MODULUS) -> SphericalPin:
    return SphericalPin(normal_load=load, radius=RADIUS, modulus=modulus, flat_radius=flat)


@given(st.floats(1e-6, 0.7e-3), st.floats(-3, 1).map(lambda x: 10.0**x), st.floats(1e-3, 0.9))
def test_goes_on_along_the_curve_of_the_whole_sphere(flat, load, share):
    whole, pin = truncated(0.0, load), truncated(flat, load)
    before = whole.volume(cap_height(scar_radius=flat, sphere_radius=RADIUS))
    volume = share * pin.most_volume
    state, reached = pin.worn(volume), whole.worn(before + volume)
    assert float(state.radius) == pytest.approx(float(reached.radius), rel=1e-9)
    missing = cap_height(scar_radius=flat, sphere_radius=RADIUS)
    assert float(state.depth + missing) == pytest.approx(float(reached.depth), rel=1e-9)
    assert float(pin.most_volume + before) == pytest.approx(float(whole.most_volume), rel=1e-12)


def test_without_a_flat_is_the_whole_sphere():
    volume = np.geomspace(1e-18, 1e-12, 20)
    for flat, tolerance in ((0.0, 0.0), (1e-8, 1e-5), (1e-10, 1e-9)):
        np.testing.assert_allclose(truncated(flat).worn(volume).depth, SPHERE.worn(volume).depth, rtol=tolerance)


def test_wears_at_first_as_a_flat_pin():
    volume = np.geomspace(1e-22, 1e-19, 7)
    stiff = truncated(FLAT, modulus=1e6 * MODULUS).worn(volume)
    np.testing.assert_allclose(stiff.depth, FlatPin(FLAT).worn(volume).depth, rtol=1e-5)
    start = float(truncated(FLAT).worn(0.0).radius)
    np.testing.assert_allclose(truncated(FLAT).worn(volume).depth, volume / (np.pi * start**2), rtol=1e-5)


@given(st.floats(1e-7, 0.5e-3), st.floats(-4, 1).map(lambda x: 10.0**x))
def test_contact_begins_wider_than_flat_and_elastic_contact(flat, load):
    start, elastic = float(truncated(flat, load).worn(0.0).radius), float(truncated(0.0, load).worn(0.0).radius)
    assert start >= max(flat, elastic) * (1 - 1e-12)
    approach = elastic_approach(normal_load=load, modulus=MODULUS, contact_radius=start)
    height = cap_height(scar_radius=start, sphere_radius=RADIUS)
    missing = cap_height(scar_radius=flat, sphere_radius=RADIUS)
    assert float(height) == pytest.approx(float(missing + approach), rel=1e-9)


def test_agrees_with_an_integration_of_the_differential_equation():
    pin, missing = truncated(FLAT), float(cap_height(scar_radius=FLAT, sphere_radius=RADIUS))
    distances = np.array([1.0, 10.0, 100.0, 500.0])

    def rate(_: float, depth: np.ndarray) -> np.ndarray:
        def gap(a: float) -> float:
            sunk = missing + float(depth[0]) + LOAD / (2 * float(MODULUS) * a)
            return a**2 / (RADIUS + np.sqrt(RADIUS**2 - a**2)) - sunk

        return np.array([K_D * LOAD / (np.pi * brentq(gap, 1e-6, RADIUS, xtol=1e-18, rtol=1e-14) ** 2)])

    solved = solve_ivp(rate, (0, 500.0), [0.0], method="DOP853", rtol=1e-12, atol=1e-20, t_eval=distances)
    np.testing.assert_allclose(pin.worn(K_D * LOAD * distances).depth, solved.y[0], rtol=1e-9)


@given(st.floats(1e-6, 0.6e-3), st.floats(1e-12, 0.99))
def test_volume_and_depth_invert_each_other(flat, share):
    pin = truncated(flat)
    volume = share * float(pin.most_volume)
    assume(volume > 0)
    assert float(pin.volume(pin.worn(volume).depth)) == pytest.approx(volume, rel=1e-11)


def test_published_scheme_starts_from_the_flat_and_converges():
    volume, pin = K_D * LOAD * 500.0, truncated(FLAT)
    first = pin.published_depth([1e-20])[-1]
    assert first == pytest.approx(1e-20 / (np.pi * FLAT**2), rel=1e-12)
    exact = float(pin.worn(volume).depth)
    steps = np.array([500, 1000, 2000])
    errors = [pin.published_depth(np.full(n, volume / n))[-1] / exact - 1 for n in steps]
    np.testing.assert_allclose(-np.diff(np.log(np.abs(errors))) / np.diff(np.log(steps)), 1.0, atol=0.05)
    tiny = truncated(1e-7).published_depth([1e-20])[-1]
    hertz = float(hertz_radius(normal_load=LOAD, pin_radius=RADIUS, modulus=MODULUS))
    assert tiny == pytest.approx(1e-20 / (np.pi * hertz**2), rel=1e-12)


def test_wear_beyond_the_tip_is_refused_with_its_height():
    with pytest.raises(ContactError, match=r"0 and the tip height of 312\.3"):
        truncated(0.73e-3).volume(0.6e-3)
    with pytest.raises(ContactError, match="as large as the tip"):
        truncated(0.79e-3, load=1e5)


def manifest(**end: object) -> RunManifest:
    document = {**MANIFEST, "contact": {**MANIFEST["contact"]}, "end_values": end}
    shape = {"shape": "truncated-sphere", "flat_radius": f"{FLAT * 1e6} um"}
    document["contact"]["pin"] = {**MANIFEST["contact"]["pin"], **shape}
    return RunManifest.model_validate(document)


def recorded(**end: object) -> RawRun:
    """A run of 500 m without noise, of a truncated sphere."""
    distance = np.linspace(0, 500, 1001)
    depth = 2e-6 + truncated(FLAT).worn(K_D * LOAD * distance).depth + 1e-10 * distance
    columns = {"time": distance / 0.4, "sliding_distance": distance, "depth": depth}
    return RawRun(manifest(**end), columns, dict.fromkeys(columns, "measured"), {}, {}, ())


def test_pin_contact_takes_the_flat_of_run_toml():
    contact = manifest().contact
    assert isinstance(contact, PinOnDisc)
    values = {"normal_load": LOAD, "pin_radius": RADIUS, "pin_modulus": 304e9, "disc_modulus": 304e9}
    assert float(pin_contact(contact, values).worn(1e-13).depth) == float(truncated(FLAT).worn(1e-13).depth)


@pytest.mark.parametrize("correction", ["two-step", "model"])
def test_coefficient_comes_back_from_a_scar(correction):
    end = truncated(FLAT).worn(K_D * LOAD * 500.0)
    missing = float(cap_height(scar_radius=FLAT, sphere_radius=RADIUS))
    scar = 2 * np.sqrt((end.depth + missing) * (2 * RADIUS - end.depth - missing))
    run = recorded(pin_scar_diameter={"value": float(scar), "unit": "m", "standard_uncertainty": 2e-6})
    recipe = Recipe(wear=WearRecipe(correction=correction), monte_carlo=MonteCarloRecipe(significant_digits=0))
    fit = fit_wear(correct_drift(run, recipe), "archard", None, recipe)
    assert fit.first.wear_coefficient.value == pytest.approx(K_D, rel=2e-3)
    assert fit.first.measured_end_depth.value == pytest.approx(float(end.depth), rel=1e-9)


def test_prediction_starts_from_the_flat():
    contact = manifest().contact
    assert isinstance(contact, PinOnDisc)
    load, known = Quantity(value=LOAD, unit="N"), Quantity(value=K_D, unit="m^2/N", standard_uncertainty=0.02 * K_D)
    exact = predict_wear(Scenario(contact, load, KnownWear({"pin": known})), [500.0], depths=[5e-6])
    published = predict_wear(Scenario(contact, load, KnownWear({"pin": known})), [500.0], scheme="published")
    depth = float(truncated(FLAT).worn(K_D * LOAD * 500.0).depth)
    assert exact.prediction[0].contact.approach.value == pytest.approx(depth, rel=1e-12)
    assert published.prediction[0].contact.approach.value == pytest.approx(depth, rel=1e-4)
    distance = exact.reached[0].sliding_distance.value
    assert float(truncated(FLAT).worn(K_D * LOAD * distance).depth) == pytest.approx(5e-6, rel=1e-9)


def test_simulated_run_of_a_truncated_sphere_tells_its_coefficient(short_plan, tmp_path):
    text = short_plan.read_text(encoding="utf-8")
    plan = tmp_path / "plan.toml"
    plan.write_text(
        text.replace('shape = "spherical"', 'shape = "truncated-sphere"\nflat_radius = "60 um"'), encoding="utf-8"
    )
    truth, *_ = simulate_plan(load_toml(plan, Plan), tmp_path)
    recipe = Recipe(monte_carlo=MonteCarloRecipe(significant_digits=0))
    run = read_run(tmp_path / truth.id)
    assert run.manifest.described.sliding_tip.flat_radius.value == pytest.approx(60e-6)
    found = fit_wear(correct_drift(run, recipe), "archard", None, recipe).first.wear_coefficient
    assert abs(found.value - truth.wear_coefficient.value) < 2.5 * found.standard_uncertainty
    rate = specific_wear(run, recipe).pin.specific_wear_rate
    assert abs(rate.value - truth.wear_coefficient.value) < 2.5 * rate.standard_uncertainty


def test_a_scar_within_the_flat_is_no_wear():
    run = recorded(pin_scar_diameter="159 um")
    correction = correct_drift(run, Recipe()).correction
    assert correction.pin_wear_depth.value < 0
    deeper = replace(run, manifest=run.manifest.model_copy(update={"end_values": EndValues(pin_wear_depth=none())}))
    assert correct_drift(deeper, Recipe()).correction.pin_wear_depth.value == 0


def none() -> EndValue:
    return EndValue(value=0.0, unit="m", standard_uncertainty=1e-8)

"""k_D of a ball whose disc wears as well: the volume that the ball lacks, and the course of both depths."""

import numpy as np
import pytest
from scipy.integrate import quad
from test_identify import CASES, record

from tribopipe.base.errors import ContactError
from tribopipe.documents.manifest import EndValue, EndValues
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import DefaultUncertainty, Recipe, WearRecipe
from tribopipe.evaluation.depth_reading import engine_of
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.measurements.pin_on_disc import beside_unseen_groove, end_wear
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.physics.geometry import worn_volume
from tribopipe.physics.pin_on_disc import RigidSphere, SphericalPin
from tribopipe.physics.pin_on_track import SphereOnTrack, depth_growth
from tribopipe.results.run import RawRun

RADIUS = 0.794e-3
SHARE = np.linspace(0.0, 1.0, 21)


def depth(value: float, spread: float) -> EndValue:
    return EndValue(value=value, unit="m", standard_uncertainty=spread)


def recorded(pin: EndValue, disc: EndValue | None) -> RawRun:
    raw = record(*CASES["si3n4-air-200mN"])
    ends = EndValues(pin_wear_depth=pin, disc_wear_depth=disc)
    return RawRun(raw.manifest.model_copy(update={"end_values": ends}), raw.columns, raw.origins, {}, {}, ())


def recorded_by_the_volume(coefficient: float, disc_share: float) -> RawRun:
    """A reading of rigid bodies without noise: pin and groove by the volumes of both, slice by slice."""
    raw = recorded(depth(1e-5, 5e-8), None)
    conditions = raw.manifest.conditions
    root = np.linspace(0.0, np.sqrt(raw.sliding_distance[-1]), 500)
    volume = coefficient * conditions.normal_load.value * root**2
    path = 2 * np.pi * 4e-3
    worn = SphereOnTrack(RADIUS).worn(volume, disc_share * volume / path)
    both = np.interp(np.sqrt(np.maximum(raw.sliding_distance, 0.0)), root, worn.approach)
    ends = EndValues(
        pin_wear_depth=depth(float(worn.pin_depth[-1]), 5e-8),
        disc_wear_depth=depth(float(worn.groove_depth[-1]), 2e-8),
    )
    manifest = raw.manifest.model_copy(update={"end_values": ends})
    return RawRun(manifest, raw.columns | {"depth": both + 3e-6}, raw.origins, {}, {}, ())


@pytest.mark.parametrize("flat", [0.0, 60e-6])
def test_rigid_sphere_lacks_what_it_has_lost(flat):
    pin = RigidSphere(RADIUS, flat)
    depths = np.array([0.0, 1e-9, 1e-6, 3e-5, 4e-4])
    np.testing.assert_allclose(pin.worn(pin.volume(depths)).depth, depths, rtol=1e-11)
    volumes = worn_volume(depth=depths, sphere_radius=RADIUS, flat_radius=flat)
    np.testing.assert_allclose(pin.volume(depths), volumes, rtol=1e-14)


def test_rigid_sphere_is_the_limit_of_a_hard_one():
    volumes = np.array([1e-15, 1e-13, 1e-11])
    hard = SphericalPin(normal_load=0.2, radius=RADIUS, modulus=1e20)
    np.testing.assert_allclose(RigidSphere(RADIUS).worn(volumes).depth, hard.worn(volumes).depth, rtol=1e-6)


@pytest.mark.parametrize("depth", [-1e-6, 1.0e-3])
def test_depth_that_a_rigid_sphere_cannot_have_is_refused(depth):
    with pytest.raises(ContactError, match="tip height of 794 µm"):
        RigidSphere(RADIUS).volume(depth)


def test_volume_that_a_rigid_sphere_does_not_hold_is_refused():
    with pytest.raises(ContactError, match="more than the volume of the tip"):
        RigidSphere(RADIUS).worn(2e-9)


@pytest.mark.parametrize("ratio", [1.0, 10.0, 60.0, 300.0])
def test_pin_is_deeper_on_its_way_than_its_share_of_the_last_volume_says(ratio):
    volume = 1.35e-14 * 0.2 * 500 * SHARE
    tip = SphereOnTrack(RADIUS)
    worn = tip.worn(volume, ratio * volume / (2 * np.pi * 4e-3))
    pin, groove = float(worn.pin_depth[-1]), float(worn.groove_depth[-1])
    alone = RigidSphere(RADIUS)
    plain = alone.worn(SHARE[1:] * alone.volume(pin)).depth
    np.testing.assert_allclose(plain * depth_growth(tip, SHARE[1:], pin, groove), worn.pin_depth[1:], rtol=2e-5)


def test_a_groove_as_deep_as_the_tip_leaves_no_way_to_look_at():
    assert depth_growth(SphereOnTrack(RADIUS), SHARE, 1e-6, RADIUS).tolist() == [1.0] * len(SHARE)


@pytest.mark.parametrize(
    ("disc", "engine"),
    [
        (None, "volume"),
        (depth(0.0, 20e-9), "giwm"),
        (depth(50e-9, 40e-9), "giwm"),
        (depth(90e-9, 10e-9), "giwm"),
        (depth(150e-9, 20e-9), "volume"),
        (depth(3e-6, 1e-6), "volume"),
    ],
)
def test_giwm_is_for_discs_that_were_looked_at_and_have_hardly_worn(disc, engine):
    run = recorded(depth(10e-6, 5e-8), disc)
    end, pin = end_wear(run, DefaultUncertainty()), run.manifest.described.sliding_tip
    assert engine_of(pin, end, Recipe()) == engine
    assert engine_of(pin, end, Recipe(wear=WearRecipe(engine="local"))) == "local"


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [10.0, 60.0])
def test_both_worn_by_archard_s_law_give_k_d_of_the_pin(ratio):
    raw = recorded_by_the_volume(1.35e-14, ratio)
    fit = fit_wear(correct_drift(raw))
    assert (fit.engine, fit.basis) == ("volume", "reading and measurement")
    assert fit.first.by_reading.value == pytest.approx(1.35e-14, rel=5e-3)
    assert fit.first.wear_coefficient.value == pytest.approx(1.35e-14, rel=5e-3)
    assert not [finding for finding in fit.findings if finding.severity != "note"]


def by_paraboloid(way: str, q: float) -> float:
    """Volume of a pin beside a groove q times as deep, over that without one, where ``way`` was measured the same."""
    t = (np.arange(2000) + 0.5) / 2000
    wider = 16 / np.pi * np.mean(t**2 * np.sqrt(1 - t**2 + q * (1 - t**3)))
    shallower = {"depth": 1.0, "scar": (2 / (1 + np.sqrt(1 + q))) ** 4, "sensor": (1 + q) ** -2.0}[way]
    return wider * shallower


@pytest.mark.parametrize("way", ["depth", "scar", "sensor"])
@pytest.mark.parametrize("share", [0.05, 0.15])
def test_groove_that_nobody_saw_changes_the_volume_as_that_of_a_paraboloid(way, share):
    raw = recorded(depth(1e-5, 5e-8), None)
    if way == "scar":
        ends = EndValues(pin_scar_diameter=depth(2.5e-4, 2e-6))
        raw = RawRun(raw.manifest.model_copy(update={"end_values": ends}), raw.columns, raw.origins, {}, {}, ())
    found = beside_unseen_groove(end_wear(raw, DefaultUncertainty()), share, by_sensor=way == "sensor")
    # The share is of the depth that a scar has without a groove; beside one the pin is less deep.
    q = share * (1 + share / 2) if way == "scar" else share
    assert found - 1 == pytest.approx(by_paraboloid(way, q) - 1, rel=0.03)


@pytest.mark.slow
def test_groove_in_another_material_is_a_warning_though_depth_and_scar_agree():
    """A ball on a softer disc: the scar across sliding and the depth signal tell of 1.6 times its wear, or more."""
    raw = recorded_by_the_volume(1.35e-14, 100.0)
    width = 2 * np.sqrt(2 * RADIUS * float(np.ptp(raw.columns["depth"])))
    contact = raw.manifest.contact
    steel = contact.model_copy(update={"disc": contact.disc.model_copy(update={"material": "42CrMo4"})})
    ends = EndValues(pin_scar_diameter=depth(width, 3e-6))
    manifest = raw.manifest.model_copy(update={"contact": steel, "end_values": ends})
    fit = fit_wear(correct_drift(RawRun(manifest, raw.columns, raw.origins, {}, {}, ())))
    assert fit.first.wear_coefficient.value > 1.6 * 1.35e-14
    assert {finding.severity for finding in fit.findings if finding.code == "disc_not_measured"} == {"warning"}


@pytest.mark.slow
def test_disc_that_nobody_looked_at_is_in_the_budget_and_a_note():
    fits = [fit_wear(correct_drift(recorded(depth(2.35e-5, 2e-7), disc))) for disc in (None, depth(0.0, 2e-8))]
    noted = [{finding.code for finding in fit.findings} >= {"disc_not_measured"} for fit in fits]
    named = [any(line.name == "unseen groove" for line in fit.first.budget) for fit in fits]
    assert noted == named == [True, False]
    assert fits[0].first.wear_coefficient.standard_uncertainty > 2 * fits[1].first.wear_coefficient.standard_uncertainty


def beside_a_measured_groove(disc_share: float, *, gain: float = 1.0) -> RawRun:
    """A reading without noise of a pin that nobody measured, in a groove that somebody did, within 2 %."""
    raw = recorded_by_the_volume(1.35e-14, disc_share)
    groove = raw.manifest.end_values.disc_wear_depth.value
    ends = EndValues(disc_wear_depth=depth(groove, 0.02 * groove))
    manifest = raw.manifest.model_copy(update={"end_values": ends})
    return RawRun(manifest, raw.columns | {"depth": gain * raw.columns["depth"]}, raw.origins, {}, {}, ())


def fitted_pin(raw: RawRun):
    # The disc of the sample is said not to wear: what tells the pin from the groove is the reading alone.
    return fit_wear(raw, recipe=Recipe(uncertainty=DefaultUncertainty(unseen_groove=0.0))).bodies["pin"]


@pytest.mark.slow
@pytest.mark.parametrize("disc_share", [20.0, 60.0])
def test_pin_that_nobody_measured_has_its_k_d_beside_a_deep_groove(disc_share):
    found = fitted_pin(beside_a_measured_groove(disc_share)).wear_coefficient
    assert found.value == pytest.approx(1.35e-14, rel=0.002, abs=0.0)


@pytest.mark.slow
def test_a_sensor_that_reads_too_much_is_not_all_wear_of_the_pin():
    # 0.5 % of pin and groove are 1.2 % of the pin, but the groove takes its part.
    low, high = (fitted_pin(beside_a_measured_groove(60.0, gain=gain)) for gain in (0.995, 1.005))
    by_scale = next(line.relative for line in high.budget if line.name == "depth scale")
    moved = np.log(high.wear_coefficient.value / low.wear_coefficient.value) / 2
    assert by_scale == pytest.approx(moved, rel=0.2)


@pytest.mark.parametrize("ratio", [0.5, 3.0])
@pytest.mark.parametrize("spread", [2e-8, 2e-7])
def test_flat_pin_in_a_groove_has_worn_more_at_its_sides(ratio, spread):
    """A slice at x loses w = D/(1 + 2κ·√(r² − x²)), by Archard's law at each point; D is what the sensor reads."""
    radius, coefficient, path = 1.5e-3, 3e-13, 2 * np.pi * 10e-3
    raw = record(*CASES["si3n4-air-200mN"])
    load, slid = raw.manifest.conditions.normal_load.value, raw.sliding_distance[-1]
    crowned, _ = quad(
        lambda x: 2 * np.sqrt(radius**2 - x**2) / (1 + ratio * np.sqrt(1 - (x / radius) ** 2)), -radius, radius
    )
    approach = coefficient * load * slid / crowned
    pin = approach / (1 + ratio)
    kappa = ratio / (2 * radius)
    document = raw.manifest.model_dump(exclude_none=True)
    document["contact"]["pin"] |= {"shape": "flat", "radius": {"value": radius, "unit": "m"}}
    del document["contact"]["pin"]["diameter"], document["contact"]["disc"]["diameter"]
    document["conditions"] |= {"track_radius": {"value": 10e-3, "unit": "m"}}
    document["end_values"] = {
        "pin_wear_depth": depth(pin, spread).model_dump(exclude_none=True),
        "disc_wear_depth": depth(approach - pin, spread).model_dump(exclude_none=True),
    }
    read = approach * raw.sliding_distance / slid + 2e-6
    manifest = type(raw.manifest).model_validate(document)
    fit = fit_wear(correct_drift(RawRun(manifest, raw.columns | {"depth": read}, raw.origins, {}, {}, ())))
    found = {name: body.wear_coefficient.value for name, body in fit.bodies.items()}
    assert found == pytest.approx({"pin": coefficient, "disc": kappa * coefficient * path}, rel=0.01)


@pytest.mark.parametrize(("by_sensor", "less"), [(False, 1.0), (True, 1.15)])
def test_flat_pin_next_to_an_unmeasured_groove_may_have_lost_more(by_sensor, less):
    """The mean over the pin of (1 + q)/(1 + q·√(1 − x²)), along chords, by the midpoint rule."""
    pin = {"shape": "flat", "radius": Quantity(value=1e-3, unit="m"), "diameter": None}
    raw = recorded(depth(1e-5, 1e-7), None)
    contact = raw.manifest.contact.model_copy(update={"pin": raw.manifest.contact.pin.model_copy(update=pin)})
    raw = RawRun(raw.manifest.model_copy(update={"contact": contact}), raw.columns, raw.origins, {}, {}, ())
    x = (np.arange(4000) + 0.5) / 4000
    chord = np.sqrt(1 - x**2)
    growth = np.sum(chord * 1.15 / (1 + 0.15 * chord)) / np.sum(chord)
    found = beside_unseen_groove(end_wear(raw, DefaultUncertainty()), 0.15, by_sensor=by_sensor)
    assert found == pytest.approx(growth / less, rel=1e-3)

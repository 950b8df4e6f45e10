"""Errors of a virtual tribometer: drawn once a run, as far off as the plan says, and known to nobody but the truth."""

import json

import numpy as np
import pytest
from pydantic import ValidationError
from test_identify import CASES

from tribopipe.documents.manifest import read_manifest
from tribopipe.documents.plan import Sensors, Series, VirtualRun
from tribopipe.documents.quantity import Quantity
from tribopipe.extras.simulate import VirtualTest
from tribopipe.physics.geometry import cap_radius

SERIES, RUN = CASES["si3n4-air-200mN"]
SHORT = SERIES.model_copy(update={"sliding_distance": Quantity(value=10.0, unit="m")})


def virtual(seed: int = RUN.seed, *, errors: bool = True, **changes) -> VirtualTest:
    series = SHORT.model_copy(update={"systematic_errors": errors, **changes})
    return VirtualTest(series, RUN.model_copy(update={"seed": seed}))


def certain(quantity: Quantity) -> Quantity:
    return quantity.model_copy(update={"standard_uncertainty": None})


def friction_noise(test: VirtualTest) -> np.ndarray:
    columns, _ = test.record()
    # The load cell shows the nominal load; friction acts under the true one.
    pressed = columns["normal_force"] * test.load.value / test.run.normal_load.value
    return columns["friction_force"] / pressed - test.friction.coefficient(test.distance)


def depth_noise(test: VirtualTest) -> np.ndarray:
    columns, _ = test.record()
    true = (test.worn.pin_depth + test.worn.disc_depth) / test.depth_scale + test.run.drift_rate.value * test.time
    return columns["depth"] - true - test.run.zero_offset.value


def test_noise_is_the_same_with_errors_and_without():
    with_errors, without = virtual(errors=True), virtual(errors=False)
    np.testing.assert_array_equal(with_errors.time, without.time)
    np.testing.assert_array_equal(with_errors.record()[0]["normal_force"], without.record()[0]["normal_force"])
    np.testing.assert_allclose(friction_noise(with_errors), friction_noise(without), atol=1e-12)
    # What is left of the depth is noise to within the step of the digits.
    step = SHORT.sensors.depth_resolution.value
    np.testing.assert_allclose(depth_noise(with_errors), depth_noise(without), atol=1.01 * step)
    assert not np.array_equal(with_errors.distance, without.distance)


def test_friction_at_a_certain_speed_is_the_same_with_errors_and_without():
    speed = certain(SHORT.sliding_speed)
    with_errors, without = (virtual(errors=errors, sliding_speed=speed) for errors in (True, False))
    (one, one_end), (other, other_end) = with_errors.record(), without.record()
    for name in ("time", "normal_force"):
        np.testing.assert_array_equal(one[name], other[name])
    off = with_errors.load.value / without.load.value
    assert off != 1
    np.testing.assert_allclose(one["friction_force"], off * other["friction_force"], rtol=1e-12)
    assert not np.array_equal(one["depth"], other["depth"])
    # The end value is off by the same, about another truth.
    assert one_end["pin_scar_diameter"] != other_end["pin_scar_diameter"]


def test_run_without_errors_is_what_its_manifest_says():
    test = virtual(errors=False)
    assert test.depth_scale == SHORT.depth_scale.value
    assert test.pin_radius == SHORT.contact.pin.radius.value
    np.testing.assert_array_equal(test.distance, SHORT.sliding_speed.value * test.time)


def test_inputs_stated_as_certain_are_not_off():
    test = virtual(depth_scale=certain(SHORT.depth_scale), sliding_speed=certain(SHORT.sliding_speed))
    assert test.depth_scale == SHORT.depth_scale.value
    np.testing.assert_array_equal(test.distance, SHORT.sliding_speed.value * test.time)
    assert test.pin_radius != SHORT.contact.pin.radius.value


@pytest.fixture(scope="module")
def many() -> list[VirtualTest]:
    """Three hundred runs that differ by their seed."""
    return [virtual(seed) for seed in range(300)]


DRAWN = {
    "depth scale": (lambda test: test.depth_scale, SHORT.depth_scale),
    "sliding distance": (lambda test: test.distance[-1] / test.time[-1], SHORT.sliding_speed),
    "tip radius": (lambda test: test.pin_radius, SHORT.contact.pin.radius),
}


def errors_of(name: str, tests: list[VirtualTest]) -> np.ndarray:
    """Errors in standard uncertainties."""
    true, stated = DRAWN[name]
    return np.array([(true(test) - stated.value) / stated.standard_uncertainty for test in tests])


@pytest.mark.parametrize("name", DRAWN)
def test_errors_are_as_large_as_stated(many, name):
    errors = errors_of(name, many)
    # Four standard deviations of what 300 draws of a normal distribution tell.
    assert np.std(errors) == pytest.approx(1, abs=4 / np.sqrt(2 * len(many)))
    assert np.mean(errors) == pytest.approx(0, abs=4 / np.sqrt(len(many)))
    assert np.mean(np.abs(errors) < 1) == pytest.approx(0.683, abs=4 * np.sqrt(0.683 * 0.317 / len(many)))


def test_errors_of_different_inputs_have_nothing_to_do_with_each_other(many):
    together = np.corrcoef([errors_of(name, many) for name in DRAWN])
    assert np.max(np.abs(together - np.eye(len(DRAWN)))) < 3.5 / np.sqrt(len(many))


def test_errors_have_nothing_to_do_with_the_noise(many):
    first = np.array([depth_noise(test)[:20] for test in many]).T
    for name in DRAWN:
        found = np.corrcoef(errors_of(name, many), first)[0, 1:]
        assert np.max(np.abs(found)) < 4.5 / np.sqrt(len(many))


def test_load_and_moduli_are_off_too():
    # With all else certain, what moves the wear is the load; at 10 m the elastic approach still tells the moduli.
    sure = {"sliding_speed": certain(SHORT.sliding_speed), "depth_scale": certain(SHORT.depth_scale)}
    radius = SHORT.contact.pin.model_copy(update={"radius": certain(SHORT.contact.pin.radius)})
    contact = SHORT.contact.model_copy(update={"pin": radius})
    true = virtual(errors=False, contact=contact, **sure).worn.pin_depth[-1]
    off = [virtual(seed, contact=contact, **sure).worn.pin_depth[-1] / true - 1 for seed in range(100)]
    # Depth goes about as the root of the load, whose standard uncertainty is 1 %.
    assert np.std(off) == pytest.approx(0.005, rel=0.3)


@pytest.mark.parametrize("errors", [True, False])
def test_manifest_states_what_was_meant_whatever_is_off(tmp_path, errors):
    series = SHORT.model_copy(update={"systematic_errors": errors})
    truth = VirtualTest(series, RUN).write(tmp_path)
    manifest, _ = read_manifest(tmp_path / "run.toml")
    assert manifest.contact == SHORT.contact
    assert manifest.conditions.sliding_speed == SHORT.sliding_speed
    assert manifest.conditions.normal_load == RUN.normal_load
    assert manifest.sensors.depth_scale == SHORT.depth_scale
    told = json.loads((tmp_path / "truth.json").read_text(encoding="utf-8"))
    test = VirtualTest(series, RUN)
    assert told["end_pin_wear_depth"]["value"] == pytest.approx(test.worn.pin_depth[-1], rel=1e-12)
    assert truth.end_pin_wear_depth.value == test.worn.pin_depth[-1]


# --- what is measured on a spherical pin afterwards ---


def measured_by(pin_end_value: str) -> Sensors:
    return SHORT.sensors.model_copy(update={"pin_end_value": pin_end_value})


def test_scar_of_a_spherical_pin_is_measured_unless_the_plan_says_otherwise():
    assert set(virtual().record()[1]) == {"pin_scar_diameter", "disc_wear_depth"}


def test_height_loss_of_a_spherical_pin_is_measured_where_the_plan_says_so():
    spread = SHORT.sensors.height_loss_uncertainty.value
    errors = []
    for seed in range(200):
        test = virtual(seed, sensors=measured_by("pin_wear_depth"))
        ends = test.record()[1]
        assert set(ends) == {"pin_wear_depth", "disc_wear_depth"}
        assert ends["pin_wear_depth"].standard_uncertainty == spread
        errors.append((ends["pin_wear_depth"].value - test.worn.pin_depth[-1]) / spread)
    assert np.std(errors) == pytest.approx(1, abs=4 / np.sqrt(2 * len(errors)))
    assert np.mean(errors) == pytest.approx(0, abs=4 / np.sqrt(len(errors)))


def test_scar_is_that_of_the_true_tip_and_not_of_the_stated_one():
    exact = SHORT.sensors.model_copy(update={"scar_uncertainty": Quantity(value=1e-15, unit="m")})
    test = virtual(sensors=exact)
    scar = test.record()[1]["pin_scar_diameter"].value
    worn = test.worn.pin_depth[-1]
    assert scar == pytest.approx(2 * float(cap_radius(height=worn, sphere_radius=test.pin_radius)), rel=1e-9)
    assert scar != pytest.approx(
        2 * float(cap_radius(height=worn, sphere_radius=SHORT.contact.pin.radius.value)), rel=1e-5
    )


def test_height_loss_is_written_into_the_manifest(tmp_path):
    VirtualTest(SHORT.model_copy(update={"sensors": measured_by("pin_wear_depth")}), RUN).write(tmp_path)
    manifest, _ = read_manifest(tmp_path / "run.toml")
    worn = virtual(errors=False, sensors=measured_by("pin_wear_depth")).record()[1]["pin_wear_depth"]
    assert manifest.end_values.pin_scar_diameter is None
    assert manifest.end_values.pin_wear_depth.value == pytest.approx(worn.value, rel=1e-5)
    assert manifest.end_values.pin_wear_depth.standard_uncertainty == pytest.approx(2.5e-7, rel=1e-6)


# --- both bodies wear ---


def on_flat(**changes) -> tuple[Series, VirtualRun]:
    """The steel ball whose flat wears 400 times as fast, of which coordinates and quadrature gave the shape."""
    series = {
        "title": "a ball on a softer disc",
        "medium": "air",
        "sliding_speed": "1 m/s",
        "sliding_distance": "1000 m",
        "track_radius": "6 mm",
        "sensors": {"sampling_rate": "1 Hz"},
        "contact": {
            "kind": "pin-on-disc",
            "ball": {"diameter": "6 mm", "material": "a", "youngs_modulus": "210 GPa", "poisson_ratio": 0.3},
            "disc": {"material": "b", "youngs_modulus": "70 GPa", "poisson_ratio": 0.3},
        },
        "runs": [
            {
                "id": "both",
                "started": "2026-01-05T09:00:00+01:00",
                "seed": 5,
                "normal_load": "5 N",
                "wear_coefficient": "1e-9 mm^2/N",
                "disc_wear_coefficient": "4e-7 mm^2/N",
                "friction": {"amplitude": 0.1, "steady_state": 0.4, "running_in_distance": "20 m"},
                "zero_offset": "1 um",
                "drift_rate": "10 nm/min",
            }
        ],
    }
    made = Series.model_validate(series | changes)
    return made, made.runs[0]


def test_wear_of_both_bodies_has_the_shape_of_the_check_values():
    series, run = on_flat()
    test = VirtualTest(series, run)
    truth = test.truth()
    depths = [truth.end_pin_wear_depth.value, truth.end_disc_wear_depth.value]
    assert depths == pytest.approx([0.0145437434e-3, 0.0607353411e-3], rel=1e-6)
    assert truth.end_disc_wear_volume.value == pytest.approx(4e-13 * 5 * 1000, rel=1e-12)
    assert test.worn.scars["pin_scar_width"] == pytest.approx(2 * 0.667837979e-3, rel=1e-6)
    assert test.worn.scars["pin_scar_length"] == pytest.approx(2 * 0.295043963e-3, rel=1e-6)


def test_scar_and_volume_of_both_bodies_are_measured(tmp_path):
    VirtualTest(*on_flat()).write(tmp_path / "both")
    manifest, _ = read_manifest(tmp_path / "both" / "run.toml")
    ends = manifest.end_values
    volume = ends.disc_wear_volume
    assert volume.standard_uncertainty == pytest.approx(0.05 * 2e-9, rel=1e-6)
    assert abs(volume.value - 2e-9) < 4 * volume.standard_uncertainty
    assert ends.pin_scar_width.value == pytest.approx(2 * 0.667837979e-3, abs=1e-5)
    assert manifest.conditions.track_radius.value == pytest.approx(6e-3)
    assert "Fn [N]" in (tmp_path / "both" / "signals.csv").read_text(encoding="ascii").splitlines()[0]


def test_two_statements_of_the_wear_of_a_disc_are_refused():
    _, run = on_flat()
    with pytest.raises(
        ValidationError, match="disc_wear_depth: found a wear depth in addition to disc_wear_coefficient"
    ):
        VirtualRun.model_validate(run.model_dump() | {"disc_wear_depth": "100 nm"})


def test_disc_that_wears_needs_the_length_of_its_track():
    with pytest.raises(
        ValidationError, match=r"disc_wear_coefficient: found a wear coefficient, but neither track_radius nor stroke"
    ):
        on_flat(track_radius=None)


def test_motion_that_the_contact_does_not_know_is_refused():
    with pytest.raises(ValidationError, match=r"stroke: found stroke in addition to track_radius"):
        on_flat(stroke="10 mm")


def test_run_toml_states_all_that_the_plan_states_of_the_bodies(tmp_path):
    coating = {"coating_thickness": Quantity(value=2e-6, unit="m"), "vickers_hardness": 1600.0}
    contact = SHORT.contact.model_copy(update={"disc": SHORT.contact.disc.model_copy(update=coating)})
    VirtualTest(SHORT.model_copy(update={"contact": contact}), RUN).write(tmp_path)
    manifest, _ = read_manifest(tmp_path / "run.toml")
    assert manifest.contact == contact

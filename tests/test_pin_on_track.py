"""Scar and groove of a pin on a track: published check values, limits, quadrature by brackets, and inversion."""

import math

import numpy as np
import pytest
from end_value_runs import RADIUS, groove
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from tribopipe.physics.geometry import scar_radius_at, segment_area, worn_volume
from tribopipe.physics.pin_on_track import SHAPE_LEAST, FlatOnTrack, SphereOnTrack

MM, UM = 1e-3, 1e-6
SI3N4 = {"load": 0.2, "distance": 500.0, "path": 2 * math.pi * 4 * MM, "k_1": 1.35e-14}
CASES = {
    # k_2/k_1: pin depth, groove depth, approach, half width, half length in mm, cross-section in mm².
    0.1: (0.0233712674, 2.37804834e-5, 0.0233950479, 0.191321739, 0.191225931, 5.37147933e-6),
    1: (0.0233035236, 2.36774693e-4, 0.0235402983, 0.191905831, 0.190952720, 5.37147933e-5),
    10: (0.0226845810, 2.27431338e-3, 0.0249588944, 0.197513994, 0.188437057, 5.37147933e-4),
    60: (0.0203924148, 0.0116358510, 0.0320282658, 0.223237712, 0.178794027, 3.22288760e-3),
    300: (0.0163057319, 0.0416306776, 0.0579364095, 0.297735437, 0.160086306, 0.0161144380),
}


def worn(pin, load, distance, path, k_1, k_2):
    return pin.worn(k_1 * load * distance, k_2 * load * distance / path)


def lengths(state):
    found = (state.pin_depth, state.groove_depth, state.approach, state.half_width, state.half_length)
    return [float(one) / MM for one in found]


def near(values):
    """Within half a unit of the last of the digits that are published."""
    return pytest.approx(values, rel=6e-9)


@pytest.mark.parametrize("ratio", CASES)
def test_ball_on_a_disc_is_as_published(ratio):
    state = worn(SphereOnTrack(0.794 * MM), k_2=ratio * SI3N4["k_1"], **SI3N4)
    assert [*lengths(state), float(state.groove_area) / MM**2] == near(list(CASES[ratio]))


def test_steel_ball_is_as_published():
    state = worn(SphereOnTrack(3 * MM), 5.0, 1000.0, 2 * math.pi * 6 * MM, 1e-15, 4e-13)
    found = lengths(state)
    assert [*found[:2], *found[3:]] == near([0.0145437434, 0.0607353411, 0.667837979, 0.295043963])
    assert float(state.groove_area) / MM**2 == near(0.0530516477)


def test_reciprocating_ball_is_as_published():
    found = lengths(worn(SphereOnTrack(3 * MM), 10.0, 400.0, 20 * MM, 2e-14, 5e-14))
    assert [*found[:2], *found[3:]] == near([0.0893282519, 0.0108507144, 0.768789941, 0.726629187])


def test_flat_pin_is_as_published():
    found = lengths(worn(FlatOnTrack(1.5 * MM), 20.0, 2000.0, 2 * math.pi * 10 * MM, 3e-15, 8e-15))
    assert found[:3] == pytest.approx([0.0166799670, 0.0021237594, 0.0188037263], abs=1e-10)


@pytest.mark.parametrize("pin", [SphereOnTrack(RADIUS), SphereOnTrack(RADIUS, 60 * UM), FlatOnTrack(RADIUS)])
def test_volumes_stand_as_the_coefficients(pin):
    """S = κ·V_1, and κ = h_d/A in the middle slice, whatever the shape."""
    depths = np.geomspace(1e-9, 1e-4, 6)
    state = pin.at_depths(depths[:, None], depths)
    kappa = depths / np.asarray(pin.middle_slice(depths[:, None]))
    np.testing.assert_allclose(state.groove_area, kappa * state.pin_volume, rtol=1e-7)


def test_draws_are_solved_together():
    volumes = 1e-12 * np.exp(np.linspace(-1, 1, 7))
    pin = SphereOnTrack(RADIUS)
    together = pin.worn(volumes, 1e-9)
    single = [float(pin.worn(volume, 1e-9).groove_depth) for volume in volumes]
    np.testing.assert_allclose(together.groove_depth, single, rtol=1e-12)


@pytest.mark.slow
@settings(max_examples=50, deadline=None)
@given(st.floats(-8, -4.2), st.floats(-8, -4.2), st.sampled_from([0.0, 60 * UM]))
@example(-8.0, -4.25, 0.0)
@example(-8.0, -4.2, 0.0)
def test_volumes_lead_back_to_the_depths(pin, groove_depth, flat):
    tip = SphereOnTrack(RADIUS, flat)
    state = tip.at_depths(10**pin, 10**groove_depth)
    again = tip.worn(state.pin_volume, state.groove_area)
    assert float(again.pin_depth) == pytest.approx(10**pin, rel=1e-8)
    assert float(again.groove_depth) == pytest.approx(10**groove_depth, rel=1e-8)


@pytest.mark.parametrize("scar", [0.05e-3, 0.15e-3, 0.24e-3])
def test_section_is_that_of_slices_found_by_bracketing(scar):
    half = 0.25e-3
    depth, profile = groove(half, scar)
    state = SphereOnTrack(RADIUS).at_depths(SphereOnTrack(RADIUS).approach_at(scar), depth)
    assert float(state.half_width) == pytest.approx(half, rel=1e-13)
    assert float(state.groove_area) == pytest.approx(2 * quad(profile, 0, half, epsrel=1e-11, epsabs=0)[0], rel=1e-10)


def test_limits_are_the_cap_and_the_segment():
    tip = SphereOnTrack(RADIUS)
    cap = tip.at_depths(5 * UM, 0.0)
    assert float(cap.pin_volume) == pytest.approx(float(worn_volume(depth=5 * UM, sphere_radius=RADIUS)), rel=1e-11)
    hard = tip.at_depths(0.0, 5 * UM)
    half = scar_radius_at(depth=5 * UM, sphere_radius=RADIUS)
    assert float(hard.groove_area) == pytest.approx(float(segment_area(half_chord=half, radius=RADIUS)), rel=1e-12)
    little = tip.at_depths(1 * UM, 1e-12)
    assert float(little.groove_area / (2 * little.half_width * 1e-12)) == pytest.approx(SHAPE_LEAST, rel=1e-3)
    ground = SphereOnTrack(RADIUS, 60 * UM).at_depths(5 * UM, 0.0)
    lost = worn_volume(depth=5 * UM, sphere_radius=RADIUS, flat_radius=60 * UM)
    assert float(ground.pin_volume) == pytest.approx(float(lost), rel=1e-10)


@pytest.mark.slow
@given(st.floats(-8, -3.5), st.floats(-4, -2), st.sampled_from([0.0, 1e-16]))
def test_a_body_that_hardly_wears_leaves_the_other_one_its_own_shape(power, size, little):
    """κ → 0: the cap of a ball on a plane; κ → ∞: the segment that a ball cuts. By hand, on balls of any size."""
    depth, radius = 10**power, 10**size
    assume(depth < 0.5 * radius)
    cap, half = math.pi * depth**2 * (3 * radius - depth) / 3, math.sqrt(depth * (2 * radius - depth))
    angle = math.asin(half / radius)
    # Half an angle less its sine, by the series where the difference would be lost.
    series = sum((-1) ** (n + 1) * (2 * angle) ** (2 * n + 1) / math.factorial(2 * n + 1) for n in range(1, 18))
    segment, tip = radius**2 / 2 * series, SphereOnTrack(radius)
    on_plane, cut = tip.worn(cap, little * segment), tip.worn(little * cap, segment)
    assert float(on_plane.pin_depth) == pytest.approx(depth, rel=1e-9)
    assert float(on_plane.half_width) == pytest.approx(half, rel=1e-9)
    assert float(cut.approach) == pytest.approx(depth, rel=1e-9)
    assert float(cut.half_width) == pytest.approx(half, rel=1e-9)


@pytest.mark.parametrize("pin", [SphereOnTrack(RADIUS), SphereOnTrack(RADIUS, 60 * UM), FlatOnTrack(RADIUS)])
@pytest.mark.parametrize("kappa", [1e-6, 1.0, 1e3, 1e6])
def test_slopes_are_those_of_the_course(pin, kappa):
    volumes = 1e-13 * np.array([1 - 1e-4, 1.0, 1 + 1e-4])
    state = pin.worn(volumes, kappa * volumes)
    groove_slope = kappa * (volumes[2] - volumes[0]) / (state.groove_depth[2] - state.groove_depth[0])
    assert float(state.groove_slope[1]) == pytest.approx(groove_slope, rel=1e-6)


def test_slope_and_area_in_the_limits():
    tip = SphereOnTrack(RADIUS)
    cap = tip.at_depths(5 * UM, 0.0)
    round_area = math.pi * float(cap.half_width) ** 2
    assert float(cap.area) == pytest.approx(round_area, rel=1e-10)
    hard = tip.at_depths(0.0, 5 * UM)
    assert float(hard.groove_slope) == pytest.approx(2 * float(hard.half_width), rel=1e-10)
    assert float(hard.area) == 0


def test_area_is_that_of_chords_found_by_bracketing():
    half, scar = 0.25e-3, 0.15e-3
    depth, profile = groove(half, scar)
    tip = SphereOnTrack(RADIUS)
    state = tip.at_depths(tip.approach_at(scar), depth)
    approach = float(state.approach)

    def chord(x: float) -> float:
        level = approach - profile(x)
        return 2 * math.sqrt(max(RADIUS**2 - (RADIUS - level) ** 2 - x**2, 0.0))

    assert float(state.area) == pytest.approx(2 * quad(chord, 0, half, epsrel=1e-9, epsabs=0)[0], rel=1e-7)

"""A half space of rectangles against integrals and Hertz's sphere, its contact against what that is, pins on it."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tribopipe.base.errors import ContactError
from tribopipe.physics.geometry import cap_height
from tribopipe.physics.hertz import hertz_radius
from tribopipe.physics.local import contact_solvers
from tribopipe.physics.local.contact_solvers import Contact, solve_by_conjugate_gradients
from tribopipe.physics.local.course import wear
from tribopipe.physics.local.grids import DiscTrack, PinGrid, round_pin
from tribopipe.physics.local.half_space import HalfSpace, MirroredHalfSpace
from tribopipe.physics.local.rings import Rings, ring_edges

MODULUS, LOAD, RADIUS = 161e9, 0.2, 0.794e-3
START = float(hertz_radius(normal_load=LOAD, pin_radius=RADIUS, modulus=MODULUS))
RANDOM = np.random.default_rng(1)


def sphere(radius: np.ndarray) -> np.ndarray:
    return cap_height(scar_radius=radius, sphere_radius=RADIUS)


def paraboloid(radius: np.ndarray) -> np.ndarray:
    return radius**2 / (2 * RADIUS)


def flat(radius: np.ndarray) -> np.ndarray:
    return np.where(radius <= 50e-6, 0.0, np.inf)


def unworn(surface: PinGrid | DiscTrack) -> Contact:
    return surface.press(np.zeros_like(surface.gap))


def unit(space: HalfSpace) -> np.ndarray:
    """Displacement by unit pressure on the first point."""
    pressure = np.zeros(space.shape)
    pressure[0, 0] = 1.0
    return space.convolved(pressure, space.compliance)


def test_displacement_by_one_rectangle():
    displacement = unit(HalfSpace(2.0, (3.0, 0.5), (5, 7)))
    # In the middle, 1/(πE_c)·∫∫ 1/√(x² + z²).
    inside = 2 * (1.5 * np.arcsinh(0.25 / 1.5) + 0.25 * np.arcsinh(1.5 / 0.25)) * 2
    assert displacement[0, 0] == pytest.approx(inside / (2 * np.pi), rel=1e-12)
    points = (np.arange(600) + 0.5) / 600 - 0.5
    distance = np.hypot(3 * 3 + 3 * points[:, None], 5 * 0.5 + 0.5 * points)
    assert displacement[3, 5] == pytest.approx(1.5 * np.mean(1 / distance) / (2 * np.pi), rel=1e-7)


def test_nothing_repeats_beyond_the_grid():
    near, wide = unit(HalfSpace(1.0, (1.0, 2.0), (7, 11))), unit(HalfSpace(1.0, (1.0, 2.0), (90, 64)))
    assert near == pytest.approx(wide[:7, :11], rel=1e-11)
    assert wide[89, 0] == pytest.approx(2 / (np.pi * 89), rel=1e-4)


@pytest.mark.parametrize("shape", [(4, 6), (5, 7), (13, 1), (1, 1)])
def test_a_quarter_is_as_good_as_the_whole(shape):
    quarter, spacing = RANDOM.random(shape), (0.7, 1.9)
    whole = np.block([[quarter[::-1, ::-1], quarter[::-1]], [quarter[:, ::-1], quarter]])
    half_space = HalfSpace(3.0, spacing, whole.shape)
    mirrored = MirroredHalfSpace(3.0, spacing, shape)
    displacement = half_space.convolved(whole, half_space.compliance)[shape[0] :, shape[1] :]
    assert mirrored.convolved(quarter, mirrored.compliance) == pytest.approx(displacement, rel=1e-12)
    along = np.broadcast_to(2 * spacing[1] * quarter.sum(axis=1, keepdims=True), shape)
    assert mirrored.convolved(quarter, mirrored.streamlines) == pytest.approx(along, rel=1e-12)
    assert half_space.convolved(whole, half_space.streamlines)[shape[0] :, shape[1] :] == pytest.approx(
        along, rel=1e-12
    )
    assert mirrored.cell == 4 * half_space.cell
    for part, all_of in zip(mirrored.places, half_space.places, strict=True):
        assert part == pytest.approx(all_of[len(part) :], rel=1e-12)


@pytest.mark.parametrize("extent", [1.1, 1.23, 1.3, 1.37, 1.5])
def test_hertz_s_sphere_on_128_by_128(extent):
    spacing = 2 * extent * START / 128
    half_space = MirroredHalfSpace(MODULUS, (spacing, spacing), (64, 64))
    across, along = half_space.places
    check_hertz(DiscTrack(LOAD, half_space, paraboloid(np.hypot(across[:, None], along))))


def test_hertz_s_sphere_without_symmetry():
    check_hertz(round_pin(normal_load=LOAD, modulus=MODULUS, tip=paraboloid, reach=1.3 * START))


def check_hertz(grid: PinGrid | DiscTrack) -> None:
    contact = unworn(grid)
    assert contact.pressure.max() == pytest.approx(1.5 * LOAD / (np.pi * START**2), rel=2e-4)
    assert contact.approach == pytest.approx(START**2 / RADIUS, rel=1e-4)
    assert np.vdot(grid.areas, contact.pressure) == pytest.approx(LOAD, rel=1e-13)
    assert grid.extent(contact).half_width == pytest.approx(START, rel=4e-3)
    assert grid.extent(contact).half_length == pytest.approx(START, rel=4e-3)


SHAPES = st.tuples(st.integers(1, 12), st.integers(1, 12))
ROUGH = SHAPES.flatmap(lambda shape: arrays(float, shape, elements=st.floats(0, 1) | st.just(np.inf)))


@given(
    gap=ROUGH.filter(lambda gap: np.isfinite(gap).any()),
    load=st.floats(1e-6, 1e3),
    length=st.floats(0.1, 10),
    amount=st.floats(0, 1e3),
    disc=st.booleans(),
)
@example(gap=np.ones((3, 7)), load=1e-6, length=7.0, amount=0.0, disc=True)
@example(gap=np.ones((3, 3)), load=1e-6, length=7.75, amount=0.0, disc=True)
def test_what_is_found_is_a_contact(gap, load, length, amount, disc):
    space = (MirroredHalfSpace if disc else HalfSpace)(1.0, (1.0, length), gap.shape)
    spectrum = space.compliance + amount * (space.streamlines if disc else 1.0)
    contact = solve_by_conjugate_gradients(lambda pressure: space.convolved(pressure, spectrum), gap, space.cell, load)
    left = gap + space.convolved(contact.pressure, spectrum) - contact.approach
    closed = contact.approach - gap.min()
    assert np.all(contact.pressure >= 0)
    assert space.cell * contact.pressure.sum() == pytest.approx(load, rel=1e-12)
    assert np.all(left > -1e-7 * closed)
    assert np.all(np.abs(left[contact.pressure > 0]) < 1e-7 * closed)


def test_a_contact_not_found_is_said(monkeypatch):
    monkeypatch.setattr(contact_solvers, "_MOST_STEPS", 5)
    with pytest.raises(ContactError, match=r"found a contact area that still changes after 5 iterations"):
        unworn(round_pin(normal_load=LOAD, modulus=MODULUS, tip=sphere, reach=1.3 * START, cells=32))


def test_a_contact_wider_than_the_grid_is_said():
    with pytest.raises(ContactError, match="reaches the edge of the grid"):
        unworn(round_pin(normal_load=LOAD, modulus=MODULUS, tip=sphere, reach=0.9 * START, cells=32))


@pytest.mark.slow
@pytest.mark.parametrize("distance", [0.1, 10.0, 500.0])
def test_a_sphere_wears_as_it_does_in_rings(distance):
    amount = np.array([13.5e-15 * distance])
    reach = 1.15 * (START**4 + 4 * RADIUS * amount[0] * LOAD / np.pi) ** 0.25
    edges = ring_edges(START, reach)
    rings = wear(Rings(LOAD, MODULUS, edges, sphere((edges[1:] + edges[:-1]) / 2)), amount)
    grid = wear(round_pin(normal_load=LOAD, modulus=MODULUS, tip=sphere, reach=reach, cells=64), amount)
    assert grid.depth[-1] == pytest.approx(rings.depth[-1], rel=2e-3)
    assert grid.pressure[-1][32, 32] == pytest.approx(rings.pressure[-1][0], rel=0.03)
    assert grid.approach[-1] == pytest.approx(rings.approach[-1], rel=2e-3)
    assert grid.half_width[-1] == pytest.approx(rings.half_width[-1], rel=3e-2)
    assert grid.volume[-1] == pytest.approx(amount[0] * LOAD, rel=1e-12)


def test_a_flat_pin_s_pressure_is_boussinesq_s():
    grid = round_pin(normal_load=2.0, modulus=MODULUS, tip=flat, reach=50e-6, cells=96)
    contact = unworn(grid)
    assert contact.approach == pytest.approx(2.0 / (2 * MODULUS * 50e-6), rel=1e-2)
    assert contact.pressure[48, 48] == pytest.approx(2.0 / (2 * np.pi * (50e-6) ** 2), rel=1e-2)
    assert grid.extent(contact).half_width == pytest.approx(50e-6, rel=2e-2)
    assert grid.roughness(contact) < 0.01


@pytest.mark.slow
@pytest.mark.parametrize(("share", "smooth"), [(0.8, True), (0.95, True), (1.2, False), (1.5, False)])
def test_explicit_steps_are_stable_below_the_limit_only(share, smooth):
    grid = round_pin(normal_load=LOAD, modulus=MODULUS, tip=sphere, reach=2.5 * START, cells=32)
    worn, contact = np.zeros_like(grid.gap), unworn(grid)
    for _ in range(40):
        worn = worn + share * grid.stable_amount(contact) * grid.exposure(contact.pressure)
        contact = grid.press(worn, start=contact)
    assert (grid.roughness(contact) < 0.02) == smooth
    assert (grid.roughness(contact) < 0.2) == smooth

"""A track worn on a disc (paper, Table 3, radii of 4 mm): Hertz's ellipse, converged depths, similarity, balance."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tribopipe.base.errors import ContactError
from tribopipe.physics.hertz import contact_modulus, hertz_ellipse
from tribopipe.physics.local.contact_solvers import Contact
from tribopipe.physics.local.course import wear
from tribopipe.physics.local.grids import DiscTrack, disc_track
from tribopipe.physics.twin_disc import DiscPair

LOAD, RADIUS, COEFFICIENT = 0.3, 4e-3, 1e-16
MODULUS = float(contact_modulus(pin_modulus=152e9, pin_ratio=0.32, disc_modulus=152e9, disc_ratio=0.32))
TURNS = np.array([1e5, 1e6, 2e6])
WORN = COEFFICIENT * TURNS
COARSE = (32, 16)


def track(amount: float = WORN[-1], load: float = LOAD, radius: float = RADIUS, **more) -> DiscTrack:
    radii = dict.fromkeys(("crown_radius", "curved_radius", "flat_radius"), radius)
    return disc_track(**{"normal_load": load, "modulus": MODULUS, "amount": amount, **radii, **more})


def unworn(surface: DiscTrack) -> Contact:
    return surface.press(np.zeros_like(surface.gap))


@pytest.fixture(scope="module")
def course():
    return wear(track(), WORN)


@pytest.mark.parametrize("crown", [1e-3, 2e-3, 4e-3, 12e-3])
def test_hertz_s_ellipse(crown):
    surface = track(0.0, crown_radius=crown)
    contact = unworn(surface)
    hertz = hertz_ellipse(normal_load=LOAD, radius_x=crown, radius_z=RADIUS / 2, modulus=MODULUS)
    assert contact.pressure.max() == pytest.approx(hertz.peak_pressure, rel=3e-4)
    assert contact.approach == pytest.approx(hertz.approach, rel=1e-4)
    assert surface.extent(contact).half_width == pytest.approx(hertz.half_width, rel=3e-3)
    assert surface.extent(contact).half_length == pytest.approx(hertz.half_length, rel=3e-3)
    assert np.vdot(surface.areas, contact.pressure) == pytest.approx(LOAD, rel=1e-13)


def test_wear_of_the_paper_s_disc(course):
    assert course.depth[1:] == pytest.approx(np.array([0.07280, 0.39241, 0.62771]) * 1e-6, rel=5e-3)
    assert np.all(np.diff(course.half_width) > 0)
    assert np.all(np.diff(course.half_length) < 0)
    assert np.all(np.diff(course.pressure[:, 0, 0]) < 0)
    assert course.volume[1:] == pytest.approx(WORN * LOAD, rel=1e-12)
    assert course.worn == pytest.approx(np.broadcast_to(course.worn[..., :1], course.worn.shape), rel=0, abs=0)


@pytest.mark.slow
def test_a_coarser_grid_changes_little(course):
    coarse = wear(track(cells=(40, 20)), WORN)
    assert coarse.depth[1:] == pytest.approx(course.depth[1:], rel=1e-3)
    assert coarse.half_width == pytest.approx(course.half_width, rel=4e-2)
    assert coarse.half_length == pytest.approx(course.half_length, rel=4e-2)


@pytest.fixture(scope="module")
def usual():
    return wear(track(cells=COARSE), WORN)


def test_a_hundredfold_load_is_a_larger_picture_of_it(usual):
    """With k_D·N the same. A circle is a parabola as long as a²/r² is small: a_x here is 73 µm at the most."""
    lighter = wear(track(load=LOAD / 100, cells=COARSE), WORN)
    assert lighter.depth * 100 ** (2 / 3) == pytest.approx(usual.depth, rel=1e-4)
    assert lighter.half_width * 100 ** (1 / 3) == pytest.approx(usual.half_width, rel=1e-3)
    assert lighter.half_length * 100 ** (1 / 3) == pytest.approx(usual.half_length, rel=1e-3)
    assert lighter.pressure[:, 0, 0] * 100 ** (1 / 3) == pytest.approx(usual.pressure[:, 0, 0], rel=1e-3)


@pytest.mark.slow
def test_a_hundredfold_load_on_ten_times_the_radius_is_the_same_picture(usual):
    larger = wear(track(load=100 * LOAD, radius=10 * RADIUS, cells=COARSE), WORN)
    assert larger.worn == pytest.approx(10 * usual.worn, rel=1e-6, abs=1e-15)
    assert larger.pressure == pytest.approx(usual.pressure, rel=1e-6, abs=1e2)


@pytest.mark.slow
@pytest.mark.parametrize(("distance", "ratio"), [("line-load", 1.0), ("contact-width", (4 / np.pi) ** (2 / 3))])
def test_what_the_global_model_tends_to(distance, ratio):
    """κ = 1, or π/4 by which a wear rate π/4 times as high makes depths (π/4)^⅔ times as large."""
    turns = np.array([1e7, 1e8, 1e9])
    local = wear(track(COEFFICIENT * turns[-1], cells=(48, 12)), COEFFICIENT * turns).depth[1:]
    pair = DiscPair(LOAD, RADIUS, RADIUS, RADIUS, MODULUS, 0.1, distance)
    excess = np.abs(local / pair.worn(turns, COEFFICIENT).curved_depth / ratio - 1)
    assert np.all(np.diff(excess) < 0)
    assert excess[-1] < 3e-3


@pytest.mark.slow
def test_explicit_steps_come_to_the_same():
    surface, amount = track(2e-11, cells=(24, 12)), [5e-12, 2e-11]
    implicit = wear(surface, amount, steps_per_decade=32)
    explicit = wear(surface, amount, scheme="explicit", steps_per_decade=32)
    assert explicit.depth == pytest.approx(implicit.depth, rel=1e-2)
    assert explicit.volume[1:] == pytest.approx(np.multiply(amount, LOAD), rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(("share", "smooth"), [(0.8, True), (0.95, True), (1.2, False), (1.5, False)])
def test_explicit_steps_are_stable_below_the_limit_only(share, smooth):
    surface = track(cells=(32, 8))
    contact, worn = unworn(surface), np.zeros_like(surface.gap)
    extent = surface.extent(contact)
    by_wave = 4 * surface.half_space.spacing[0] / (np.pi * MODULUS * 2 * extent.half_length)
    assert surface.stable_amount(contact) == pytest.approx(1.16 * by_wave, rel=0.01)
    for _ in range(55):
        worn = worn + share * surface.stable_amount(contact) * surface.exposure(contact.pressure)
        contact = surface.press(worn, start=contact)
    assert (surface.roughness(contact) < 0.02) == smooth
    assert (surface.roughness(contact) < 0.2) == smooth


@pytest.mark.slow
@settings(max_examples=12)
@given(
    load=st.floats(1e-3, 1e3),
    crown=st.floats(1e-3, 1e-2),
    curved=st.floats(1e-3, 1e-2),
    flat=st.floats(1e-3, 1e-2),
    growth=st.floats(1e-3, 1e2),
)
def test_the_grid_is_wide_enough(load, crown, curved, flat, growth):
    """Wear to any width that is small beside the crown."""
    modulus = 1e6 * load / crown**2
    equivalent = curved * flat / (curved + flat)
    first = hertz_ellipse(normal_load=load, radius_x=crown, radius_z=equivalent, modulus=modulus)
    amount = growth * first.half_width**3 / (crown * load)
    surface = disc_track(
        normal_load=load,
        modulus=modulus,
        crown_radius=crown,
        curved_radius=curved,
        flat_radius=flat,
        amount=amount,
        cells=(20, 12),
    )
    course = wear(surface, [amount])
    assert course.volume[-1] == pytest.approx(amount * load, rel=1e-10)


def test_wear_beyond_the_grid_is_said():
    with pytest.raises(ContactError, match="reaches the edge of the grid"):
        wear(track(WORN[0], cells=(24, 12)), WORN)


def test_wear_of_all_the_crown_is_said():
    with pytest.raises(
        ContactError, match=r"found a final track width of 12\.4. mm on a crown of radius 4 mm; expected a narrower"
    ):
        track(1e-4)


def test_discs_that_do_not_touch_are_said():
    with pytest.raises(ContactError, match="found a load of 0"):
        track(load=0.0)

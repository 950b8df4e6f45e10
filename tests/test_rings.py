"""The round contact against Hertz's, and its wear against the volume law and converged numbers."""

import numpy as np
import pytest

from tribopipe.base.errors import ContactError
from tribopipe.physics.hertz import contact_modulus, hertz_radius
from tribopipe.physics.local.course import wear
from tribopipe.physics.local.rings import Rings, ring_edges
from tribopipe.physics.pin_on_disc import SphericalPin

LOAD, RADIUS = 0.2, 0.794e-3
MODULUS = float(contact_modulus(pin_modulus=304e9, pin_ratio=0.24, disc_modulus=304e9, disc_ratio=0.24))
START = float(hertz_radius(normal_load=LOAD, pin_radius=RADIUS, modulus=MODULUS))
COEFFICIENT = 13.5e-15
DISTANCES = np.array([0.1, 1.0, 10.0, 100.0, 500.0])


def sphere(edges: np.ndarray, load: float = LOAD) -> Rings:
    middle = (edges[1:] + edges[:-1]) / 2
    return Rings(load, MODULUS, edges, RADIUS - np.sqrt(RADIUS**2 - middle**2))


WORN = sphere(ring_edges(START, 0.21e-3))


@pytest.mark.parametrize("rings", [20, 20.3, 20.5, 20.7, 40])
def test_hertz_s_contact(rings):
    surface = sphere(np.arange(int(2 * rings) + 1) * START / rings)
    contact = surface.press(np.zeros_like(surface.gap))
    assert contact.pressure.max() == pytest.approx(1.5 * LOAD / (np.pi * START**2), rel=5e-4)
    assert contact.approach == pytest.approx(START**2 / RADIUS, rel=5e-4)
    assert surface.extent(contact).half_width == pytest.approx(START, rel=4e-3)
    assert surface.areas @ contact.pressure == pytest.approx(LOAD, rel=1e-12)


def test_wear_of_the_paper_s_pin():
    course = wear(WORN, COEFFICIENT * DISTANCES)
    assert course.depth[1:] == pytest.approx(np.array([0.32352, 1.03758, 3.29059, 10.42579, 23.37819]) * 1e-6, rel=3e-3)
    assert course.volume[1:] == pytest.approx(COEFFICIENT * LOAD * DISTANCES, rel=1e-12)
    assert np.all(np.diff(course.half_width) > 0)
    assert np.all(np.diff(course.peak_pressure) < 0)


def test_the_global_model_comes_close_once_wear_is_deep():
    distances = np.array([0.01, 0.1, 1.0, 10.0, 100.0, 500.0])
    local = wear(WORN, COEFFICIENT * distances).depth[1:]
    pin = SphericalPin(normal_load=LOAD, radius=RADIUS, modulus=MODULUS)
    excess = local / pin.worn(COEFFICIENT * LOAD * distances).depth - 1
    assert np.all(np.diff(np.abs(excess)) < 0)
    assert excess[0] > 0.1
    assert abs(excess[-1]) < 1e-3


@pytest.mark.slow
def test_more_steps_and_finer_rings_change_little():
    distance = COEFFICIENT * np.array([500.0])
    usual = wear(WORN, distance).depth[-1]
    assert wear(WORN, distance, steps_per_decade=40).depth[-1] == pytest.approx(usual, rel=2e-5)
    fine = sphere(np.linspace(0, 0.21e-3, 841))
    assert wear(fine, distance).depth[-1] == pytest.approx(usual, rel=3e-4)


def test_steps_are_of_second_order():
    amounts = COEFFICIENT * np.array([0.1])
    *coarser, fine = (wear(WORN, amounts, steps_per_decade=steps).depth[-1] for steps in (8, 16, 128))
    eight, sixteen = (abs(depth / fine - 1) for depth in coarser)
    assert eight < 1e-3
    assert sixteen < eight / 3


def test_a_flat_pin_wears_evenly_in_the_end():
    edges = np.linspace(0, 0.1e-3, 101)
    flat = Rings(LOAD, MODULUS, edges, np.zeros(100))
    course = wear(flat, COEFFICIENT * np.array([10.0, 1e4]))
    even = LOAD / (np.pi * edges[-1] ** 2)
    assert course.pressure[0, -1] > 3 * even
    assert course.pressure[-1] == pytest.approx(np.full(100, even), rel=1e-3)
    assert course.volume[-1] == pytest.approx(COEFFICIENT * LOAD * 1e4, rel=1e-12)


def test_explicit_steps_agree_where_they_are_short():
    coarse = sphere(np.linspace(0, 4 * START, 41))
    amounts = COEFFICIENT * np.array([0.01, 0.1])
    explicit, implicit = (
        wear(coarse, amounts, scheme=scheme, steps_per_decade=40).depth for scheme in ("explicit", "implicit")
    )
    assert explicit[1:] == pytest.approx(implicit[1:], rel=0.02)


def test_explicit_steps_beyond_the_limit_make_a_checkerboard():
    surface = sphere(np.linspace(0, 4 * START, 81))

    def roughness(share: float) -> float:
        worn, contact = np.zeros_like(surface.gap), surface.press(np.zeros_like(surface.gap))
        for _ in range(200):
            worn = worn + share * surface.stable_amount(contact) * surface.exposure(contact.pressure)
            contact = surface.press(worn, start=contact)
        return surface.roughness(contact)

    assert roughness(0.8) < 0.02
    assert roughness(1.3) > 0.2


def test_explicit_steps_are_refused_where_there_would_be_too_many(monkeypatch):
    monkeypatch.setattr("tribopipe.physics.local.course._MOST_EXPLICIT_STEPS", 100)
    with pytest.raises(ContactError, match="expected at most 100; use the implicit scheme"):
        wear(sphere(np.linspace(0, 4 * START, 81)), [COEFFICIENT * 500], scheme="explicit")


def test_a_checkerboard_is_never_returned(monkeypatch):
    monkeypatch.setattr("tribopipe.physics.local.course._STABLE_SHARE", 1.4)
    with pytest.raises(ContactError, match=r"oscillates by .* use the implicit scheme"):
        wear(sphere(np.linspace(0, 4 * START, 81)), [COEFFICIENT * 0.3], scheme="explicit")


def test_rings_have_to_reach_beyond_the_contact():
    with pytest.raises(ContactError, match="reaches the last ring"):
        sphere(np.linspace(0, 0.7 * START, 21)).press(np.zeros(20))
    with pytest.raises(ContactError, match="reaches the last ring"):
        wear(sphere(ring_edges(START, 0.15e-3)), [COEFFICIENT * 500])


@pytest.mark.parametrize("amounts", [[], [0.0], [1e-15, 1e-15], [2e-15, 1e-15]])
def test_places_have_to_increase(amounts):
    with pytest.raises(ContactError, match="are not positive and increasing"):
        wear(WORN, amounts)


def test_pressure_shown_has_no_ridge_at_the_edge():
    course = wear(WORN, COEFFICIENT * DISTANCES)
    assert course.peak_pressure == pytest.approx(course.pressure[:, 0], rel=0.02)
    assert course.pressure[-1, 0] == pytest.approx(LOAD / (np.pi * course.half_width[-1] ** 2), rel=0.08)

"""Local wear of a pin as a curve of its worn volume: held against contacts solved step by step, and against limits."""

import numpy as np
import pytest
from conftest import MANIFEST
from sweeps import others_slow

from tribopipe.base.errors import ContactError
from tribopipe.contacts.pin_on_disc import pin_curve
from tribopipe.documents.manifest import RunManifest
from tribopipe.physics.geometry import cap_height
from tribopipe.physics.hertz import contact_modulus, hertz_radius
from tribopipe.physics.local.course import wear
from tribopipe.physics.local.rings import Rings, ring_edges
from tribopipe.physics.local.sphere import LocalSphere, excess
from tribopipe.physics.pin_on_disc import FlatPin, SphericalPin

RADIUS = 0.794e-3
PLACES = np.array([0.1, 1.0, 10.0, 100.0, 500.0])
SI3N4 = float(contact_modulus(pin_modulus=304e9, pin_ratio=0.24, disc_modulus=304e9, disc_ratio=0.24))
WC_CO = float(contact_modulus(pin_modulus=320e9, pin_ratio=0.24, disc_modulus=305e9, disc_ratio=0.24))
CERAMIC, CARBIDE = 13.5e-15, 0.75e-17
"""k_D, m²/N."""
VALUES = {"normal_load": 0.2, "pin_radius": RADIUS, "pin_modulus": 304e9, "disc_modulus": 304e9}


def sphere(load: float, modulus: float) -> LocalSphere:
    return LocalSphere(SphericalPin(normal_load=load, radius=RADIUS, modulus=modulus))


def by_rings(load: float, modulus: float, coefficient: float) -> np.ndarray:
    """Depths at the places by contacts of the sphere itself, at steps of length zero as three lengths tell."""
    first = float(hertz_radius(normal_load=load, pin_radius=RADIUS, modulus=modulus))
    end = sphere(load, modulus).worn(coefficient * load * PLACES[-1])
    edges = ring_edges(first / 2, 1.1 * float(end.radius))
    gap = cap_height(scar_radius=(edges[1:] + edges[:-1]) / 2, sphere_radius=RADIUS)
    surface = Rings(load, modulus, edges, gap)
    long, half, short = (wear(surface, coefficient * PLACES, steps_per_decade=n).depth for n in (16, 32, 64))
    return ((8 * short - 6 * half + long) / 3)[1:]


def test_depths_are_those_the_issue_asks_for():
    depth = sphere(0.2, SI3N4).worn(CERAMIC * 0.2 * PLACES).depth
    np.testing.assert_allclose(depth, np.array([0.32352, 1.03758, 3.29059, 10.42579, 23.37819]) * 1e-6, rtol=5e-4)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("load", "modulus", "coefficient"),
    others_slow([(0.2, SI3N4, CERAMIC), (0.8, SI3N4, CERAMIC), (0.4, WC_CO, CARBIDE), (1.6, WC_CO, CARBIDE)], first=2),
)
def test_one_curve_holds_for_every_load_and_material(load, modulus, coefficient):
    depth = sphere(load, modulus).worn(coefficient * load * PLACES).depth
    np.testing.assert_allclose(depth, by_rings(load, modulus, coefficient), rtol=2e-4)


@pytest.mark.parametrize(("load", "more"), [(0.4, 0.061), (0.8, 0.071), (1.2, 0.078), (1.6, 0.083)])
def test_carbide_wears_six_to_eight_percent_deeper_than_by_the_giwm(load, more):
    pin = sphere(load, WC_CO)
    volume = CARBIDE * load * 500.0
    assert float(pin.worn(volume).depth / pin.even.worn(volume).depth) - 1 == pytest.approx(more, abs=0.001)


def test_wear_begins_as_hertz_s_contact():
    pin = sphere(0.2, SI3N4)
    hertz = float(hertz_radius(normal_load=0.2, pin_radius=RADIUS, modulus=SI3N4))
    start = pin.worn(np.array([0.0, 1e-24]))
    # The pressure in the middle is 1.5 times the mean.
    np.testing.assert_allclose(start.area, np.pi * hertz**2 / 1.5, rtol=1e-3)
    np.testing.assert_allclose(start.radius, hertz, rtol=1e-3)
    assert start.depth[0] == 0


def test_late_excess_of_depth_is_that_of_even_pressure_on_a_half_space():
    load, modulus, volume = 1e-5, SI3N4, 1e-15
    pin = LocalSphere(SphericalPin(normal_load=load, radius=RADIUS, modulus=modulus))
    local, even = pin.worn(volume), pin.even.worn(volume)
    more = (1 - 2 / np.pi + 16 / (3 * np.pi**2)) * load / (modulus * even.radius)
    assert float(local.depth - even.depth) == pytest.approx(float(more), rel=0.02)
    assert float(local.area / even.area) == pytest.approx(1, rel=1e-3)


@pytest.mark.parametrize("seam", [1e-3, 10**1.5, 1e4])
def test_excess_goes_on_smoothly_where_one_way_of_finding_it_gives_way_to_the_next(seam):
    below, above = excess(np.asarray(seam * (1 - 1e-9))), excess(np.asarray(seam * (1 + 1e-9)))
    assert float(above.depth) == pytest.approx(float(below.depth), rel=1e-6)
    assert float(above.rate) == pytest.approx(float(below.rate), rel=0.01)
    assert float(above.radius_ratio) == pytest.approx(float(below.radius_ratio), rel=1e-6)


def test_pressure_in_the_middle_only_falls():
    state = sphere(0.2, SI3N4).worn(np.geomspace(1e-24, 1e-10, 4000))
    assert np.all(np.diff(state.depth) > 0)
    assert np.all(np.diff(state.area) > -1e-9 * state.area[1:])


def test_area_is_the_slope_of_volume_against_depth():
    pin, volume = sphere(0.4, WC_CO), np.geomspace(1e-21, 1e-11, 41)
    more, less = (pin.worn(volume * (1 + sign * 1e-5)).depth for sign in (1, -1))
    np.testing.assert_allclose(2e-5 * volume / (more - less), pin.worn(volume).area, rtol=1e-4)


def test_volume_inverts_depth_for_draws_of_all_inputs():
    rng = np.random.Generator(np.random.PCG64(1))
    load, radius, modulus = (best * (1 + 0.05 * rng.standard_normal((50, 1))) for best in (0.4, RADIUS, WC_CO))
    pin = LocalSphere(SphericalPin(normal_load=load, radius=radius, modulus=modulus))
    volume = np.concatenate([[0.0], np.geomspace(1e-22, 1e-11, 30)]) * np.ones((50, 1))
    np.testing.assert_allclose(pin.volume(pin.worn(volume).depth), volume, rtol=1e-9, atol=0)


@pytest.mark.parametrize("depth", [-1e-9, RADIUS])
def test_depth_beyond_the_tip_is_refused(depth):
    with pytest.raises(ContactError, match="depth"):
        sphere(0.2, SI3N4).volume(np.array([1e-6, depth]))


def test_more_wear_than_the_tip_holds_is_refused():
    with pytest.raises(ContactError, match="more than the volume of the tip"):
        sphere(0.2, SI3N4).worn(1e-8)


def test_steps_of_the_paper_s_flow_chart_are_the_giwm_s():
    with pytest.raises(ContactError, match="--engine giwm"):
        sphere(0.2, SI3N4).published_depth([1e-15, 1e-15])


def pin_of(**changes: object):
    document = {**MANIFEST, "contact": {**MANIFEST["contact"]}}
    document["contact"]["pin"] = {**MANIFEST["contact"]["pin"], **changes}
    return RunManifest.model_validate(document).described


def test_engine_chooses_the_curve_of_a_sphere():
    giwm, local = (pin_curve(pin_of(), VALUES, engine) for engine in ("giwm", "local"))
    assert (type(giwm), type(local)) == (SphericalPin, LocalSphere)
    assert float(local.even.worn(1e-14).depth) == float(giwm.worn(1e-14).depth)


def test_truncated_sphere_is_left_to_the_giwm():
    with pytest.raises(ContactError, match=r"flat of 60 µm.*--engine giwm"):
        pin_curve(pin_of(shape="truncated-sphere", flat_radius="60 um"), VALUES, "local")


def test_flat_pin_is_worn_alike_by_both_engines():
    pin = pin_curve(pin_of(shape="flat"), VALUES, "local")
    assert isinstance(pin, FlatPin)
    edges = np.linspace(0, RADIUS, 61)
    course = wear(Rings(0.2, SI3N4, edges, np.zeros(60)), [1e-13, 1e-12])
    short = pin.worn(0.2 * course.amount[1:]).depth - course.worn[1:, 0]
    # The middle lacks what even pressure presses it in beyond the mean, and no more of it later.
    np.testing.assert_allclose(short, (2 / np.pi - 16 / (3 * np.pi**2)) * 0.2 / (SI3N4 * RADIUS), rtol=0.01)

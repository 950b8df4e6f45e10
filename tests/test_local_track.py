"""A spherical pin and its track worn at every point: rings, rigid bodies, depths from another program, balance."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tribopipe.base.errors import ContactError
from tribopipe.physics.elastic_start import ElasticSphereOnTrack
from tribopipe.physics.geometry import cap_height
from tribopipe.physics.hertz import hertz_radius
from tribopipe.physics.local.course import wear
from tribopipe.physics.local.grids import PinGrid, round_pin
from tribopipe.physics.local.rings import Rings, ring_edges
from tribopipe.physics.local.track import PinOnTrack, WornPinAndTrack, pin_on_track, wear_pin_and_track
from tribopipe.physics.pin_on_track import SphereOnTrack

LOAD, RADIUS, MODULUS, COEFFICIENT, PATH = 0.2, 0.794e-3, 161.3e9, 1.35e-14, 2 * np.pi * 4e-3
SMALL = (32, 32)
BALL = {"normal_load": LOAD, "modulus": MODULUS, "radius": RADIUS, "track_ratio": 10 / PATH, "cells": SMALL}
TIP = SphereOnTrack(RADIUS)


def ball(ratio: float, distance: float, **more) -> PinOnTrack:
    return pin_on_track(**{**BALL, "track_ratio": ratio / PATH, "amount": COEFFICIENT * distance, **more})


@cache
def worn(ratio: float, distance: float) -> WornPinAndTrack:
    return wear_pin_and_track(ball(ratio, distance), COEFFICIENT * distance)


class Both(PinGrid):
    """The whole contact of the ball on a track of 300 times its wear coefficient."""

    def exposure(self, pressure: np.ndarray) -> np.ndarray:
        return pressure + 300 / PATH * self.half_space.spacing[1] * pressure.sum(axis=1, keepdims=True)

    @property
    def _exposed(self) -> np.ndarray:
        return 1 + 300 / PATH * self.half_space.streamlines


# Of a paraboloid: pin and groove by another program, on 128 × 128 points with 12 steps a decade.
@pytest.mark.parametrize(
    ("ratio", "distance", "pin", "groove"),
    [
        (0, 0.1, 0.3231e-6, 0.0),
        (0, 500, 23.2594e-6, 0.0),
        (10, 0.1, 0.3219e-6, 0.00393e-6),
        (10, 10, 3.2455e-6, 0.12378e-6),
        (300, 0.1, 0.2953e-6, 0.10359e-6),
        (300, 1, 0.8992e-6, 0.54255e-6),
        (300, 500, 16.1769e-6, 41.28964e-6),
    ],
)
def test_depths_of_another_program(ratio, distance, pin, groove):
    surface = ball(ratio, distance)
    across, along = surface.places
    surface = replace(surface, gap=(across[:, None] ** 2 + along**2) / (2 * RADIUS))
    found = wear_pin_and_track(surface, COEFFICIENT * distance)
    assert found.pin_depth == pytest.approx(pin, rel=2e-3)
    assert found.groove_depth == pytest.approx(groove, rel=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("distance", [0.1, 10.0, 500.0])
def test_a_track_that_does_not_wear(distance):
    amount = COEFFICIENT * distance
    found = worn(0, distance)
    start = float(hertz_radius(normal_load=LOAD, pin_radius=RADIUS, modulus=MODULUS))
    reach = 1.15 * (start**4 + 4 * RADIUS * amount * LOAD / np.pi) ** 0.25
    edges = ring_edges(start, reach)
    tip = cap_height(scar_radius=(edges[1:] + edges[:-1]) / 2, sphere_radius=RADIUS)
    rings = wear(Rings(LOAD, MODULUS, edges, tip), [amount])
    assert found.pin_depth == pytest.approx(rings.depth[-1], rel=1e-3)
    whole = round_pin(
        normal_load=LOAD,
        modulus=MODULUS,
        tip=lambda radius: cap_height(scar_radius=radius, sphere_radius=RADIUS),
        reach=reach,
        cells=64,
    )
    assert found.pin_depth == pytest.approx(wear(whole, [amount]).depth[-1], rel=1e-3)
    assert found.groove_depth == 0
    assert found.half_width == pytest.approx(found.half_length, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(("ratio", "distance"), [(0.1, 500.0), (10, 500.0), (300, 500.0), (3e3, 200.0)])
def test_deep_wear_is_that_of_rigid_bodies(ratio, distance):
    found, volume = worn(ratio, distance), COEFFICIENT * distance * LOAD
    rigid = TIP.worn(volume, ratio / PATH * volume)
    assert found.pin_depth == pytest.approx(rigid.pin_depth, rel=2e-3)
    assert found.groove_depth == pytest.approx(rigid.groove_depth, rel=1e-3)
    assert found.half_width == pytest.approx(rigid.half_width, rel=1e-3)
    assert found.half_length == pytest.approx(rigid.half_length, rel=3e-3)


START = float(hertz_radius(normal_load=LOAD, pin_radius=RADIUS, modulus=MODULUS))
ELASTIC = ElasticSphereOnTrack(TIP, START)


@pytest.mark.slow
@pytest.mark.parametrize(("track_share", "depth"), [(0.5, 1.0), (5.0, 1.0), (50.0, 4.0), (0.02, 4.0)])
def test_the_elastic_start_is_local_wear_within_2_percent(track_share, depth):
    pin = depth * START**2 / RADIUS / (1 + 4 / 3 * track_share)
    ratio = float(track_share / TIP.half_width_at(pin))
    volume = float(TIP.worn_to(pin, ratio).pin_volume)
    local = wear_pin_and_track(pin_on_track(**{**BALL, "track_ratio": ratio, "amount": volume / LOAD}), volume / LOAD)
    found = ELASTIC.worn(volume, ratio * volume)
    for name in ("pin_depth", "groove_depth", "half_width", "half_length"):
        assert getattr(found, name) == pytest.approx(getattr(local, name), rel=0.02), name


def test_wear_starts_under_hertz_s_pressure():
    first = ELASTIC.worn(volume := 1e-30, 0.0)
    assert first.pin_depth == pytest.approx(1.5 * volume / (np.pi * START**2), rel=1e-6)
    assert first.area == pytest.approx(np.pi * START**2, rel=1e-4)
    unworn = ELASTIC.worn(0.0, 0.0)
    assert unworn.pin_slope == pytest.approx(np.pi * START**2 / 1.5)
    assert [unworn.half_width, unworn.half_length] == pytest.approx([START, START])


@pytest.mark.slow
@settings(max_examples=15, deadline=None)
@given(log_volume=st.floats(-19, -10.5), log_ratio=st.floats(-2, 6))
def test_the_elastic_start_can_be_inverted_and_its_slopes_are_derivatives(log_volume, log_ratio):
    volume, ratio = 10.0**log_volume, 10.0**log_ratio
    assume(ratio * volume < 0.6 * np.pi * RADIUS**2 / 2)  # beyond about 0.8, the groove would be deeper than the ball
    found = ELASTIC.worn(volume, ratio * volume)
    again = ELASTIC.worn_to(found.pin_depth, ratio)
    assert again.pin_volume == pytest.approx(volume, rel=1e-6)
    assert again.groove_area == pytest.approx(ratio * volume, rel=1e-6)
    low, high = (ELASTIC.worn(volume * by, ratio * volume * by) for by in (0.999, 1.001))
    slope = 0.002 * volume / (high.pin_depth - low.pin_depth)
    assert found.pin_slope == pytest.approx(slope, rel=2e-3)
    slope = 0.002 * ratio * volume / (high.groove_depth - low.groove_depth)
    assert found.groove_slope == pytest.approx(slope, rel=2e-3)


def test_a_groove_under_a_ball_that_does_not_wear():
    found = ELASTIC.worn_to(1e-7, np.inf)
    assert [found.pin_depth, found.pin_volume] == [0, 0]
    assert found.groove_depth == pytest.approx(1e-7, rel=1e-9)


@settings(max_examples=8, deadline=None)
@given(ratio=st.floats(0, 1e3), distance=st.floats(0.01, 1e3))
def test_both_bodies_lose_what_archard_s_law_removes(ratio, distance):
    volume = COEFFICIENT * distance * LOAD
    found = wear_pin_and_track(ball(ratio, distance, cells=(16, 16)), COEFFICIENT * distance, steps_per_decade=4)
    assert found.pin_volume == pytest.approx(volume, rel=1e-12)
    assert PATH * found.groove_area == pytest.approx(ratio * volume, rel=1e-12)


def test_each_body_loses_its_share_of_every_step():
    surface, step = ball(300, 1.0, cells=(12, 12)), 1.0
    pin, groove = np.zeros_like(surface.gap), np.zeros((12, 1))
    contact = surface.press(pin)
    for _ in range(20):
        step = 0.8 * surface.stable_amount(contact)
        pin = pin + step * contact.pressure
        groove = groove + step * 300 / PATH * 2 * surface.half_space.spacing[1] * contact.pressure.sum(axis=1)[:, None]
        contact = surface.press(pin + groove)
    assert surface.roughness(contact) < 0.02
    parts = surface.bodies(pin + groove)
    assert parts.pin == pytest.approx(pin, rel=1e-9)
    assert parts.groove == pytest.approx(groove[:, 0], rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [0, 10, 1e4])
def test_explicit_steps_end_alike_and_too_long_ones_are_rough(ratio):
    surface, amount = ball(ratio, 0.01, cells=(12, 12)), COEFFICIENT * 0.01
    explicit = surface.bodies(wear(surface, [amount], scheme="explicit").worn[-1])
    implicit = wear_pin_and_track(surface, amount, steps_per_decade=64)
    assert explicit.pin_depth == pytest.approx(implicit.pin_depth, rel=0.02)
    assert explicit.groove_depth == pytest.approx(implicit.groove_depth, rel=0.02)
    surface = ball(ratio, 10.0, cells=(24, 24))
    worn, contact = np.zeros_like(surface.gap), surface.press(np.zeros_like(surface.gap))
    for _ in range(40):
        worn = worn + 1.5 * surface.stable_amount(contact) * surface.exposure(contact.pressure)
        contact = surface.press(worn, start=contact)
    assert surface.roughness(contact) > 0.2


@pytest.mark.slow
def test_a_quarter_is_as_good_as_both_sides():
    found = worn(300, 1.0)
    assert np.all(found.pin[:, 1:] <= found.pin[:, :-1])
    assert np.all(np.diff(found.groove) <= 0)
    whole = round_pin(
        normal_load=LOAD,
        modulus=MODULUS,
        tip=lambda radius: cap_height(scar_radius=radius, sphere_radius=RADIUS),
        reach=60e-6,
        cells=64,
    )
    both = Both(whole.normal_load, whole.half_space, whole.gap)
    sides = wear(both, [COEFFICIENT]).worn[-1]
    assert sides == pytest.approx(sides[::-1], rel=1e-5)
    assert sides == pytest.approx(sides[:, ::-1], rel=1e-5)
    assert sides.max() == pytest.approx(found.pin_depth + found.groove_depth, rel=2e-3)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"track_ratio": -1.0}, r"found k_2/\(k_1·L\) of -1 /m .*; check the wear coefficients"),
        ({"track_ratio": np.nan}, "expected the first to be zero or more"),
        ({"amount": 0.0}, r"and k_1·S of 0 m²/N; expected .* the second to be positive"),
        ({"normal_load": -0.2}, "found a load of -0.2; expected a positive value"),
        ({"modulus": 0.0}, "found a modulus of 0"),
        ({"radius": np.inf}, "found a radius of curvature"),
        ({"amount": 1e-8}, "the scar is as wide as the sphere of radius 0.794 mm"),
    ],
)
def test_what_cannot_be_worn_is_refused(wrong, message):
    with pytest.raises(ContactError, match=message):
        pin_on_track(**{**BALL, "amount": COEFFICIENT, **wrong})


def test_a_contact_beyond_the_grid_is_said():
    surface = ball(10, 1.0)
    with pytest.raises(ContactError, match="reaches the edge of the grid"):
        wear_pin_and_track(surface, 10 * COEFFICIENT)

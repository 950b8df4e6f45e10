"""Functions of few variables at many places by interpolation: closed forms, worn contacts one by one, refusals."""

from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tribopipe.physics import pin_on_track
from tribopipe.physics.interpolation import at_many
from tribopipe.physics.pin_on_track import SphereOnTrack, WornContact

RNG = np.random.default_rng(7)
BOX = RNG.uniform([[-3.0], [1.0], [0.5]], [[3.0], [1.2], [0.5]], (3, 4000))


def test_a_smooth_function_is_known_to_ten_digits():
    def smooth(places):
        x, y, z = places
        return np.stack([np.exp(-x) / 20 + y * z, np.sqrt(4 + x) * np.sin(y)])

    assert at_many(smooth, BOX) == pytest.approx(smooth(BOX), abs=1e-10)


@pytest.mark.parametrize("function", [np.abs, lambda x: np.where(x > 2.9, np.nan, x)])
def test_a_function_with_a_kink_or_without_a_number_is_not(function):
    assert at_many(lambda places: function(places[:1]), BOX) is None


def test_few_places_are_not_worth_it():
    assert at_many(lambda places: places, BOX[:, :20]) is None


def one_by_one(tip, volume, area):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pin_on_track, "_MANY", np.inf)
        return tip.worn(volume, area)


@pytest.mark.slow
@pytest.mark.parametrize(("log_volume", "log_area", "flat"), [(-5.0, -6.0, 0.0), (-3.0, -4.0, 0.02)])
def test_two_sets_of_contacts_are_those_one_by_one(log_volume, log_area, flat):
    check_one_by_one(log_volume, log_area, flat)


@pytest.mark.slow
@settings(max_examples=6, deadline=None)
@given(log_volume=st.floats(-9, -2), log_area=st.floats(-10, -2), flat=st.sampled_from([0.0, 0.02]))
def test_many_contacts_are_those_one_by_one(log_volume, log_area, flat):
    check_one_by_one(log_volume, log_area, flat)


def check_one_by_one(log_volume, log_area, flat):
    """Whatever wears: draws at several places, one of them before wear has begun."""
    rng = np.random.default_rng(1)
    radius, by, ratio = (1 + u * rng.standard_normal((400, 1)) for u in (0.002, 0.05, 0.07))
    volume = by * 10.0**log_volume * np.array([0.0, 0.01, 0.3, 1.0])
    area = volume * ratio * 10.0 ** (log_area - log_volume)
    found = SphereOnTrack(radius, flat).worn(volume, area)
    some = slice(0, 400, 133)
    true = one_by_one(SphereOnTrack(radius[some], flat), volume[some], area[some])
    for field in fields(WornContact):
        got, wanted = getattr(found, field.name)[some], getattr(true, field.name)
        assert got == pytest.approx(np.broadcast_to(wanted, got.shape), rel=1e-9, abs=1e-300, nan_ok=True), field.name

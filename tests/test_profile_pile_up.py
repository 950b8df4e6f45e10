"""Grooves with material piled up, worn balls, form, dust: truth comes back, and within what is stated."""

import math

import numpy as np
import pytest
from sweeps import others_slow
from test_profile import correlated, flattened

from tribopipe.base.errors import FitError
from tribopipe.evaluation.measurements.readings import over_places
from tribopipe.evaluation.measurements.track_profile import Level, Track, examined, worn_area
from tribopipe.physics.geometry import cap_height, worn_volume
from tribopipe.results.run import Profile

X = np.linspace(-0.6e-3, 0.6e-3, 3001)
DEPTH, HALF, WIDE = 1e-6, 0.15e-3, 0.06e-3
AREA = 4 / 3 * DEPTH * HALF
BALL, SCAR = 3e-3, 0.3e-3
CAP = float(worn_volume(depth=cap_height(scar_radius=SCAR, sphere_radius=BALL), sphere_radius=BALL))


def ridged(x, high, wide=WIDE):
    """A groove with half a sine piled up on either side."""
    beside = (np.abs(x) - HALF) / wide
    pile = high * np.where((beside > 0) & (beside < 1), np.sin(np.pi * np.clip(beside, 0, 1)), 0)
    return pile - DEPTH * np.maximum(0, 1 - (x / HALF) ** 2)


def piled_up(high, wide=WIDE):
    return 2 * high * wide * 2 / np.pi


def with_dust(rng, z, grains=4):
    """Grains up to three times as high as the groove is deep, up to 4 µm wide, anywhere."""
    z = z.copy()
    for start in rng.integers(100, len(z) - 100, grains):
        z[start : start + rng.integers(2, 11)] += rng.uniform(0.5, 3) * DEPTH
    return z


CASES = {
    "white noise": {},
    "correlated noise": {"length": 5.0},
    "pile-up": {"high": 0.3e-6},
    "pile-up, correlated noise": {"high": 0.3e-6, "length": 5.0},
    "more piled up than lost": {"high": 2e-6, "wide": 0.1e-3},
    "form": {"bend": 3.0},
    "dust": {"grains": 4},
    "everything": {"high": 0.3e-6, "length": 5.0, "bend": -5.0, "grains": 4, "tilt": 0.05},
}


def scan(seed, high=0.0, wide=WIDE, length=0.0, bend=0.0, grains=0, tilt=0.01) -> Profile:
    rng = np.random.default_rng(seed)
    noise = correlated(rng, len(X), length) if length else rng.standard_normal(len(X))
    z = ridged(X - rng.uniform(-0.1e-3, 0.1e-3), high, wide) + tilt * X + bend * X**2 + 20e-9 * noise
    return Profile(X + 2e-3, with_dust(rng, z, grains))


def misses(tracks, what, true):
    found = [getattr(track, what) for track in tracks]
    return np.array([(one.value - true) / one.standard_uncertainty for one in found])


def check(case, seeds):
    """Hold areas against truth: the mean to a percent, each within its uncertainty, as often as two of them promise."""
    options = CASES[case]
    tracks = [worn_area(scan(seed, **options), None) for seed in range(seeds)]
    gained = piled_up(options.get("high", 0.0), options.get("wide", WIDE))
    for what, true in (("area", AREA), ("pile_up", gained), ("net_area", AREA - gained)):
        found = np.array([getattr(track, what).value for track in tracks])
        assert abs(np.mean(found) - true) <= 0.01 * AREA
        assert np.mean(np.abs(misses(tracks, what, true)) <= 2) >= 0.9
    assert all(abs(track.area.value / AREA - 1) < 0.03 for track in tracks)
    assert {track.form for track in tracks} == {"parabola" if options.get("bend") else "line"}


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_areas_lie_within_their_uncertainty(case):
    check(case, 40)


def test_signs_and_what_is_where():
    track = worn_area(scan(1, high=0.3e-6), None)
    assert track.area.value > 0
    assert track.pile_up.value > 0
    assert track.net_area.value == pytest.approx(track.area.value - track.pile_up.value, rel=1e-12)
    (before, first), (last, behind) = track.ridges
    assert before < first == pytest.approx(track.bounds[0], abs=4e-6)
    assert behind > last == pytest.approx(track.bounds[1], abs=4e-6)
    for start, end in track.ridges:
        assert end - start == pytest.approx(WIDE, rel=0.25)
    inside = (before < X + 2e-3) & (behind > X + 2e-3)
    assert not np.any(track.reference & inside)
    assert np.mean(track.reference[~inside]) > 0.8


def test_net_is_below_zero_where_more_is_piled_up_than_lost():
    track = worn_area(scan(1, high=2e-6, wide=0.1e-3), None)
    assert track.net_area.value == pytest.approx(AREA - piled_up(2e-6, 0.1e-3), rel=0.03)
    assert track.net_area.value < 0


def test_pile_up_on_one_side_only():
    one_sided = np.where(X > 0, ridged(X, 0.3e-6), ridged(X, 0.0))
    track = worn_area(Profile(X, one_sided + 5e-9 * np.random.default_rng(2).standard_normal(len(X))), None)
    assert len(track.ridges) == 1
    assert track.pile_up.value == pytest.approx(piled_up(0.3e-6) / 2, rel=0.03)
    assert track.area.value == pytest.approx(AREA, rel=0.01)


def test_nothing_piled_up_counts_as_nothing():
    track = worn_area(scan(4), None)
    assert (track.pile_up.value, track.ridges) == (0.0, ())
    assert track.pile_up.standard_uncertainty > 0


@pytest.mark.parametrize("high", [0.0, 0.3e-6, 2e-6])
@pytest.mark.parametrize("bend", [0.0, 5.0])
def test_without_noise_areas_are_exact(high, bend):
    track = worn_area(Profile(X, ridged(X, high) + 0.02 * X + bend * X**2), None)
    assert track.area.value == pytest.approx(AREA, rel=3e-3)
    assert track.pile_up.value == pytest.approx(piled_up(high), rel=5e-3)


@pytest.mark.slow
def test_parabola_only_where_the_shoulders_show_it():
    forms = {bend: [worn_area(scan(seed, bend=bend), None).form for seed in range(8)] for bend in (0.0, 1e-3, 0.05)}
    assert forms[0.0] == forms[1e-3] == ["line"] * 8
    assert forms[0.05] == ["parabola"] * 8


def test_what_a_line_may_hide_is_among_its_uncertainties():
    sure, unsure = (worn_area(scan(3, bend=bend), None) for bend in (0.0, 0.012))
    assert sure.form == unsure.form == "line"
    assert unsure.area.standard_uncertainty > 1.5 * sure.area.standard_uncertainty


# Balls


def ball(seed, turned=0.0, length=0.0, grains=0, noise=50e-9) -> Profile:
    rng = np.random.default_rng(seed)
    random = correlated(rng, len(X), length) if length else rng.standard_normal(len(X))
    z = flattened(X, BALL, SCAR, centre=rng.uniform(-0.03e-3, 0.03e-3), turned=turned)
    return Profile(X, with_dust(rng, z + noise * random, grains))


@pytest.mark.slow
@pytest.mark.parametrize("options", others_slow([{}, {"turned": 0.05}, {"length": 5.0}, {"grains": 4}]), ids=str)
def test_flat_on_a_ball(options):
    tracks = [worn_area(ball(seed, **options), BALL) for seed in range(15)]
    depth = float(cap_height(scar_radius=SCAR, sphere_radius=BALL))
    for what, true in (("width", 2 * SCAR), ("depth", depth), ("cap", CAP)):
        assert np.mean([getattr(track, what).value for track in tracks]) == pytest.approx(true, rel=2e-3)
        assert np.mean(np.abs(misses(tracks, what, true)) <= 2) >= 0.85
    assert {track.form for track in tracks} == {"arc"}


def test_levelling_software_that_shears_changes_the_cap_little():
    sheared = flattened(X, BALL, SCAR) + 0.02 * X
    assert worn_area(Profile(X, sheared), BALL).cap.value == pytest.approx(CAP, rel=5e-3)


def test_cap_follows_the_radius_as_stated():
    profile, step = ball(1, noise=0.0), 1e-4 * BALL
    change = worn_area(profile, BALL + step).cap.value - worn_area(profile, BALL - step).cap.value
    assert worn_area(profile, BALL).cap_per_crown_radius == pytest.approx(change / (2 * step), rel=0.05)


@pytest.mark.parametrize("share", [0.03, 0.3, 0.6])
def test_scars_small_and_large(share):
    half = share * BALL
    x = np.linspace(-1.3 * half, 1.3 * half, 2001)
    true = float(worn_volume(depth=cap_height(scar_radius=half, sphere_radius=BALL), sphere_radius=BALL))
    track = worn_area(Profile(x, flattened(x, BALL, half)), BALL)
    assert track.cap.value == pytest.approx(true, rel=1e-3)
    assert track.width.value == pytest.approx(2 * half, rel=5e-3)


# Several places along a track


@pytest.mark.slow
def test_mean_over_places_with_their_spread():
    rng = np.random.default_rng(8)
    within = 0
    for trial in range(12):
        deep = 1 + 0.05 * rng.standard_normal(5)
        noise = rng.standard_normal((5, len(X)))
        heights = deep[:, None] * ridged(X, 0.2e-6) + 20e-9 * noise
        tracks = [worn_area(Profile(X, z), None) for z in heights]
        area = over_places([track.area for track in tracks])
        assert area.standard_uncertainty > max(track.area.standard_uncertainty for track in tracks), trial
        within += abs(area.value - AREA) <= 2 * area.standard_uncertainty
    assert within >= 11


# Profiles without a track


def test_profile_without_a_track_is_only_levelled():
    rng = np.random.default_rng(9)
    found = examined(Profile(X, 0.01 * X + 2 * X**2 + 20e-9 * rng.standard_normal(len(X))), None)
    assert isinstance(found, Level)
    assert found.form == "parabola"
    assert np.allclose(found.unworn, 0.01 * X + 2 * X**2, atol=5e-9)
    assert found.why.startswith("found ")
    assert isinstance(examined(scan(1), None), Track)


def test_ends_that_drop_off_do_not_tilt_what_is_levelled():
    z = -np.maximum(0.0, np.abs(X) - 0.5e-3) * 0.3 + 0.01 * X
    found = examined(Profile(X, z + 20e-9 * np.random.default_rng(1).standard_normal(len(X))), None)
    assert isinstance(found, Level)
    assert np.allclose(found.unworn, 0.01 * X, atol=20e-9)


def test_piled_up_material_that_reaches_the_edge_is_refused():
    with pytest.raises(FitError, match="on both sides"):
        worn_area(
            Profile(X, ridged(X, 0.5e-6, wide=0.44e-3) + 1e-9 * np.random.default_rng(1).standard_normal(3001)), None
        )


def test_depth_of_a_groove_that_is_no_parabola():
    sharp = -DEPTH * np.maximum(0, 1 - np.abs(X) / HALF)
    track = worn_area(Profile(X, sharp + 5e-9 * np.random.default_rng(1).standard_normal(len(X))), None)
    assert track.depth.value == pytest.approx(DEPTH, rel=0.05)
    assert track.area.value == pytest.approx(DEPTH * HALF, rel=5e-3)
    assert math.isclose(track.width.value, 2 * HALF, rel_tol=0.15)


# Depth and width of grooves that are no parabola

PRESSED = 0.2e-3
"""Half the width of each."""
PRESSED_DEPTH = float(cap_height(scar_radius=PRESSED, sphere_radius=BALL))


def pressed(x, flat=0.0):
    """What a ball leaves that is worn flat over so much on either side of its middle."""
    walls = cap_height(scar_radius=np.clip(np.abs(x), flat, PRESSED), sphere_radius=BALL)
    return PRESSED_DEPTH - walls


def v_shaped(x, apex=0.0):
    return PRESSED_DEPTH * np.clip(np.minimum((PRESSED + x) / (PRESSED + apex), (PRESSED - x) / (PRESSED - apex)), 0, 1)


def cosine(x):
    return PRESSED_DEPTH * (1 + np.cos(np.pi * np.clip(x / PRESSED, -1, 1))) / 2


SHAPES = {
    "cap": pressed,
    "flat over a quarter": lambda x: pressed(x, PRESSED / 4),
    "flat over half": lambda x: pressed(x, PRESSED / 2),
    "flat over three quarters": lambda x: pressed(x, 0.75 * PRESSED),
    "nearly a box": lambda x: pressed(x, 0.95 * PRESSED),
    "V": v_shaped,
    "V, one wall steeper": lambda x: v_shaped(x, apex=-PRESSED / 4),
    "cosine": cosine,
}


def check_shape(shape, noise, length, seeds, least=0.9):
    """Hold depth, width and area of a groove, or of a flat on a ball, against truth."""
    x, centres = np.linspace(-0.6e-3, 0.6e-3, 2401), np.linspace(-0.05e-3, 0.05e-3, seeds)
    fine = np.linspace(-PRESSED, PRESSED, 20001)
    lost = SHAPES[shape or "cap"](fine)
    deep = float(np.max(lost))
    tracks = []
    for seed, centre in enumerate(centres):
        rng = np.random.default_rng(seed)
        random = correlated(rng, len(x), length) if length else rng.standard_normal(len(x))
        z = flattened(x, BALL, PRESSED, centre) if shape is None else -SHAPES[shape](x - centre)
        tracks.append(worn_area(Profile(x, z + noise * deep * random), BALL if shape is None else None))
    area = np.trapezoid(lost, fine)
    for what, true in (("depth", deep), ("width", 2 * PRESSED), ("area", area)):
        assert np.mean(np.abs(misses(tracks, what, true)) <= 2) >= least, what
    return tracks


@pytest.mark.slow
@pytest.mark.parametrize("shape", [*SHAPES, None])
def test_grooves_of_any_shape_lie_within_their_uncertainties(shape):
    check_shape(shape, 0.02, 0.0, 10)
    check_shape(shape, 0.005, 5.0, 10)


@pytest.mark.slow
@pytest.mark.parametrize("shape", [*SHAPES, None])
@pytest.mark.parametrize(("noise", "length"), [(0.002, 5.0), (0.01, 0.0), (0.02, 5.0)])
def test_grooves_of_any_shape_over_many_seeds(shape, noise, length):
    check_shape(shape, noise, length, 60, least=0.85)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("shape", "depth", "width"),
    [("cap", 0.005, 0.005), ("flat over a quarter", 0.01, 0.005), ("nearly a box", 0.005, 0.005), ("V", 0.02, 0.06)],
)
def test_uncertainties_of_grooves_are_no_wider_than_need_be(shape, depth, width):
    for track in check_shape(shape, 0.02, 0.0, 10):
        assert track.depth.standard_uncertainty < 2 * depth * track.depth.value
        assert track.width.standard_uncertainty < 2 * width * track.width.value

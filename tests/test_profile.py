"""Profiles across wear tracks: the area that was cut away comes back, within its uncertainty, through files as well."""

import math

import h5py
import numpy as np
import pytest
from conftest import MANIFEST
from hypothesis import given
from hypothesis import strategies as st

from tribopipe.archive.provenance import raw_digest
from tribopipe.archive.runfile import read_raw, write_raw
from tribopipe.base.errors import FitError, ReaderError
from tribopipe.documents.manifest import RunManifest
from tribopipe.evaluation.measurements.track_profile import worn_area
from tribopipe.readers.profiles import read_profiles
from tribopipe.results.run import Profile, RawRun, SourceFile

CROWN = 10e-3
HALF = 0.1e-3


def segment(crown: float, half: float) -> float:
    """Area of a circle's segment whose chord is 2a, m²."""
    if half < 1e-2 * crown:  # its series, where the closed form loses its digits
        return half**3 / crown * (2 / 3 + (half / crown) ** 2 / 5)
    return crown**2 * math.asin(half / crown) - half * math.sqrt(crown**2 - half**2)


def flattened(x, crown=CROWN, half=HALF, centre=0.0, turned=0.0):
    """A crown worn flat over 2a, turned by an angle about the centre of its circle; the flat's middle at ``centre``."""
    apart = math.sqrt(crown**2 - half**2)
    across = x - centre + apart * math.sin(turned)
    floor = (apart - across * math.sin(turned)) / math.cos(turned)
    return np.minimum(np.sqrt(crown**2 - across**2), floor) - crown


def grooved(x, depth=0.3e-6, half=HALF, centre=0.0, tilt=0.0):
    return tilt * x - depth * np.maximum(0.0, 1 - ((x - centre) / half) ** 2)


def correlated(rng, count, length):
    memory = math.exp(-1 / length)
    kicks = rng.standard_normal(count + 100) * math.sqrt(1 - memory**2)
    noise = np.zeros(count + 100)
    for i in range(1, len(noise)):
        noise[i] = memory * noise[i - 1] + kicks[i]
    return noise[100:]


X = np.linspace(-0.3e-3, 0.3e-3, 1001)


def test_flat_on_a_crown_is_a_segment():
    track = worn_area(Profile(X, flattened(X) + 4e-6), CROWN)
    assert track.area.value == pytest.approx(segment(CROWN, HALF), rel=1e-4)
    assert track.width.value == pytest.approx(2 * HALF, rel=2e-3)
    assert track.depth.value == pytest.approx(CROWN - math.sqrt(CROWN**2 - HALF**2), rel=1e-3)
    assert track.bounds == pytest.approx((-HALF, HALF), rel=5e-3)
    np.testing.assert_allclose(track.unworn, np.sqrt(CROWN**2 - X**2) - CROWN + 4e-6, atol=1e-12)


def test_groove_in_a_flat_disc_is_two_thirds_of_its_box():
    track = worn_area(Profile(X, grooved(X, tilt=0.02, centre=0.05e-3)), None)
    assert track.area.value == pytest.approx(2 / 3 * 0.3e-6 * 2 * HALF, rel=1e-4)
    assert track.depth.value == pytest.approx(0.3e-6, rel=1e-3)
    assert track.bounds == pytest.approx((-0.05e-3, 0.15e-3), abs=1e-6)
    assert track.area_per_crown_radius == 0


@pytest.mark.slow
@given(
    crown=st.floats(1e-3, 0.1),
    share=st.floats(0.005, 0.1),
    beside=st.floats(0.3, 2.0),
    more=st.floats(0.3, 2.0),
    turned=st.floats(-0.1, 0.1),
    mirrored=st.booleans(),
)
def test_area_does_not_depend_on_how_the_profile_lies(crown, share, beside, more, turned, mirrored):
    half = share * crown
    x = np.linspace(-half * (1 + beside), half * (1 + more), 2001)
    z = flattened(x, crown, half, turned=turned) + 1e-3
    profile = Profile(-x[::-1] + 2.0, z[::-1]) if mirrored else Profile(x + 1.0, z)
    track = worn_area(profile, crown)
    assert track.area.value == pytest.approx(segment(crown, half), rel=2e-3)
    assert track.width.value == pytest.approx(2 * half * math.cos(turned), rel=0.02)


@pytest.mark.slow
@given(
    depth=st.floats(1e-8, 1e-4),
    half=st.floats(1e-5, 1e-3),
    centre=st.floats(-0.5, 0.5),
    tilt=st.floats(-0.1, 0.1),
)
def test_groove_comes_back_under_any_tilt(depth, half, centre, tilt):
    x = np.linspace(-2 * half, 2 * half, 2001)
    track = worn_area(Profile(x, grooved(x, depth, half, centre * half, tilt)), None)
    assert track.area.value == pytest.approx(4 / 3 * depth * half, rel=2e-3)
    assert track.depth.value == pytest.approx(depth, rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("length", [0.3, 3.0, 8.0])
@pytest.mark.parametrize("crown", [CROWN, None])
def test_area_lies_within_its_uncertainty(crown, length):
    rng = np.random.default_rng(3)
    true = segment(CROWN, HALF) if crown else 4 / 3 * 0.3e-6 * HALF
    shape = flattened(X, centre=0.02e-3, turned=0.01) if crown else grooved(X, tilt=0.02, centre=0.04e-3)
    misses = []
    for _ in range(80):
        track = worn_area(Profile(X, shape + 20e-9 * correlated(rng, len(X), length)), crown)
        misses.append((track.area.value - true) / track.area.standard_uncertainty)
    assert np.mean(np.abs(misses) <= 2) >= 0.9
    assert 0.6 < np.std(misses) < 1.4


def test_error_of_the_crown_radius_goes_into_the_area_as_stated():
    profile = Profile(X, flattened(X, centre=0.03e-3))
    track = worn_area(profile, CROWN)
    step = 1e-4 * CROWN
    change = worn_area(profile, CROWN + step).area.value - worn_area(profile, CROWN - step).area.value
    assert track.area_per_crown_radius == pytest.approx(change / (2 * step), rel=0.05)


def test_dust_and_piled_up_material_on_the_shoulders_change_little():
    rng = np.random.default_rng(5)
    z = grooved(X) + 5e-9 * rng.standard_normal(len(X))
    clean = worn_area(Profile(X, z), None).area
    soiled = z.copy()
    soiled[[60, 61, 930]] += 2e-6
    soiled += 0.1e-6 * np.exp(-(((np.abs(X) - 1.1 * HALF) / 4e-6) ** 2)) * (np.abs(X) > HALF)
    dirty = worn_area(Profile(X, soiled), None).area
    assert dirty.value == pytest.approx(clean.value, rel=0.02)


FLAT_BOTTOM = "flat bottom"


def with_gap(shape, middle, share, seed=0):
    """A groove 6 µm deep and 500 µm wide without a share of it, the middle of which is in half widths of the groove."""
    x = np.linspace(0, 3e-3, 1501)
    across = (x - 1.5e-3) / 250e-6
    lost = 6e-6 * np.clip(1 - np.abs(across) ** (8 if shape == FLAT_BOTTOM else 2), 0.0, None)
    z = 3e-3 * x - lost + 30e-9 * np.random.default_rng(seed).standard_normal(len(x))
    seen = np.abs(across - middle) > share
    return Profile(x[seen], z[seen])


def refused(profile, crown=None):
    with pytest.raises(FitError) as caught:
        worn_area(profile, crown)
    text = str(caught.value)
    assert text.startswith("profile: found ")
    assert "; expected " in text
    return text


@pytest.mark.parametrize("middle", [-1.0, -0.6, 0.0, 0.3, 0.8])
@pytest.mark.parametrize("share", [0.1, 0.2, 0.4])
@pytest.mark.parametrize("shape", ["parabola", FLAT_BOTTOM])
def test_heights_missing_in_a_track_make_it_uncertain(shape, share, middle):
    area = 500e-6 * 6e-6 * (8 / 9 if shape == FLAT_BOTTOM else 2 / 3)
    track = worn_area(with_gap(shape, middle, share), None)
    for found, true in ((track.area, area), (track.depth, 6e-6), (track.width, 500e-6)):
        assert abs(found.value - true) <= 3 * found.standard_uncertainty
    assert track.area.standard_uncertainty < share**1.5 * area
    assert track.gap == pytest.approx(share, rel=0.2)


def test_curves_of_a_profile_with_a_gap_are_those_of_its_points():
    profile = with_gap("parabola", 0.0, 0.4)
    track = worn_area(profile, None)
    assert len(track.unworn) == len(track.reference) == len(track.dust) == len(profile.position)
    np.testing.assert_allclose(track.unworn, 3e-3 * profile.position, atol=20e-9)
    assert not np.any(track.dust)


def test_track_that_is_missing_for_the_most_part_is_refused():
    text = refused(with_gap("parabola", 0.0, 0.6))
    assert "found a gap without heights over 60 % of the width of the wear track; expected at most 50 %" in text


def test_single_missing_points_and_gaps_on_the_shoulders_are_none():
    whole = with_gap("parabola", 9.0, 0.0)
    few = np.random.default_rng(1).random(len(whole.position)) > 0.05
    beside = (whole.position < 0.3e-3) | (whole.position > 0.9e-3)
    for seen in (few, beside):
        track = worn_area(Profile(whole.position[seen], whole.height[seen]), None)
        assert track.gap == 0
        assert abs(track.area.value - 2000e-12) <= 3 * track.area.standard_uncertainty < 10e-12


def test_points_that_are_denser_in_the_walls_are_no_gaps_to_speak_of():
    x = np.unique(np.concatenate([np.linspace(0, 3e-3, 101), np.linspace(1.2e-3, 1.3e-3, 401)]))
    z = -6e-6 * np.clip(1 - ((x - 1.5e-3) / 250e-6) ** 2, 0.0, None)
    area = worn_area(Profile(x, z), None).area
    assert abs(area.value - 2000e-12) <= 2 * area.standard_uncertainty < 5e-12


@pytest.mark.parametrize("crown", [CROWN, None])
def test_profile_without_a_track_is_refused(crown):
    rng = np.random.default_rng(7)
    unworn = flattened(X, half=1e-9) if crown else 0.01 * X
    for noise in (0.0, 20e-9):
        for _ in range(20):
            assert "wear track" in refused(Profile(X, unworn + noise * rng.standard_normal(len(X))), crown)


def test_heights_that_count_downwards_are_no_track():
    assert "outward" in refused(Profile(X, -grooved(X)))


def test_constant_height_is_no_track():
    assert "wear track" in refused(Profile(X, np.zeros(len(X))))


@pytest.mark.parametrize("side", [-1, 1])
def test_track_at_the_edge_is_refused(side):
    assert "on both sides" in refused(Profile(X, grooved(X, centre=side * 0.29e-3)))
    assert "on both sides" in refused(Profile(X, flattened(X, half=0.295e-3)), CROWN)


def test_wrong_units_are_refused():
    assert "check the unit" in refused(Profile(X * 1000, flattened(X)), CROWN)
    assert "units of position and height" in refused(Profile(X, 1000 * X + flattened(X)), CROWN)


# Files

TWIN = MANIFEST | {
    "contact": {
        "kind": "twin-disc",
        "curved_disc": {
            "material": "Si3N4",
            "youngs_modulus": "304 GPa",
            "poisson_ratio": 0.24,
            "rolling_radius": "10 mm",
            "crown_radius": "10 mm",
        },
        "flat_disc": {
            "material": "Si3N4",
            "youngs_modulus": "304 GPa",
            "poisson_ratio": 0.24,
            "rolling_radius": "10 mm",
        },
    },
    "conditions": {"normal_load": "250 mN", "curved_disc_speed": "800 mm/s", "slip": "4 %"},
}
SOURCE = {"file": "curved.csv", "position": {"column": "x", "unit": "mm"}, "height": {"column": "z", "unit": "um"}}


def manifest_with(*, end=None, stop=None) -> RunManifest:
    stops = [] if stop is None else [{"rotations": 1000, **stop}]
    return RunManifest.model_validate(TWIN | {"end_values": end or {}, "interruptions": stops})


def rows(x, z) -> str:
    return "x,z\n" + "".join(f"{a:.9g},{b:.9g}\n" for a, b in zip(x, z, strict=True))


def read(folder, manifest, sources=()):
    taken, headers, notes = list(sources), {}, []
    return read_profiles(manifest, folder, taken, headers, notes), taken, headers


def test_profile_is_read_in_si_and_sorted(tmp_path):
    text = rows(X[::-1] * 1e3, flattened(X)[::-1] * 1e6).replace("\n", "\n0.31,\n", 1)
    (tmp_path / "curved.csv").write_text("Scan 3\n" + text, encoding="utf-8")
    manifest = manifest_with(end={"curved_disc_profile": SOURCE}, stop={"curved_disc_profile": SOURCE})
    profiles, sources, headers = read(tmp_path, manifest)
    assert list(profiles) == ["end_values.curved_disc_profile", "interruptions[0].curved_disc_profile"]
    profile = profiles["end_values.curved_disc_profile"]
    np.testing.assert_allclose(profile.position, X, atol=1e-12)
    np.testing.assert_allclose(profile.height, flattened(X), atol=1e-12)
    assert [source.name for source in sources] == ["curved.csv"]
    assert "Scan 3" in headers["curved.csv"]
    assert worn_area(profile, CROWN).area.value == pytest.approx(segment(CROWN, HALF), rel=1e-3)


def test_file_that_is_a_source_already_is_kept_once(tmp_path):
    (tmp_path / "curved.csv").write_text(rows(X * 1e3, X), encoding="utf-8")
    there = SourceFile("./curved.csv", (tmp_path / "curved.csv").read_bytes())
    profiles, sources, headers = read(tmp_path, manifest_with(end={"flat_disc_profile": SOURCE}), [there])
    assert (len(profiles), sources, headers) == (1, [there], {})


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (rows(X[:19] * 1e3, X[:19]), "found 19 points"),
        (rows(np.zeros(30), np.arange(30)), "same position in all 30 rows"),
        (rows(np.append(np.arange(30), 7), np.arange(31)), "found the position 7 mm 2 times"),
        (rows(X * 1e3, X).replace("x,z", "y,z"), "no column 'x' for position"),
        (rows(np.arange(30), np.arange(30)).replace("\n7,7\n", "\n7,bad\n"), "line 9, column 'z': found 'bad'"),
        (rows(X, X).replace("x,z", "x [s],z"), None),
    ],
)
def test_profile_that_is_none_is_refused(tmp_path, text, said):
    (tmp_path / "curved.csv").write_text(text, encoding="utf-8")
    manifest = manifest_with(end={"curved_disc_profile": SOURCE})
    if said is None:  # run.toml wins over the file
        assert read(tmp_path, manifest)
        return
    with pytest.raises(ReaderError) as caught:
        read(tmp_path, manifest)
    assert said in str(caught.value)
    assert "curved.csv" in str(caught.value)


def test_profile_without_a_file_or_unit_is_refused(tmp_path):
    with pytest.raises(ReaderError, match=r"curved.csv: no such file; expected the profile specified in run.toml"):
        read(tmp_path, manifest_with(end={"curved_disc_profile": SOURCE}))
    (tmp_path / "curved.csv").mkdir()
    with pytest.raises(ReaderError, match=r"specify the file in run.toml under end_values.curved_disc_profile.file"):
        read(tmp_path, manifest_with(end={"curved_disc_profile": SOURCE}))
    (tmp_path / "flat.csv").write_text(rows(X, X), encoding="utf-8")
    bare = {"file": "flat.csv", "position": "x", "height": "z"}
    with pytest.raises(ReaderError, match="found no unit; expected a unit for position"):
        read(tmp_path, manifest_with(end={"flat_disc_profile": bare}))


def archived(run: RawRun) -> RawRun:
    with h5py.File("memory", "w", driver="core", backing_store=False, track_order=True) as file:
        write_raw(file, run, ())
        for data in file["entry/profiles"].values() if run.profiles else ():
            assert dict(data.attrs)["signal"] == "height"
            assert data["position"].attrs["units"] == data["height"].attrs["units"] == "m"
        assert ("profiles" in file["entry"]) == bool(run.profiles)
        return read_raw(file)


def test_profiles_come_back_from_an_archive():
    turns = np.arange(10.0)
    columns = {"time": turns, "rotations": turns, "sliding_distance": turns, "depth": turns}
    manifest = manifest_with(end={"curved_disc_profile": SOURCE}, stop={"curved_disc_profile": SOURCE})
    profiles = {
        "end_values.curved_disc_profile": Profile(X, flattened(X)),
        "interruptions[0].curved_disc_profile": Profile(X[:30], flattened(X)[:30]),
    }
    sources = (SourceFile("run.toml", b""), SourceFile("curved.csv", b"x,z\n"))
    run = RawRun(manifest, columns, dict.fromkeys(columns, "measured"), {}, {}, sources, profiles=profiles)
    back = archived(run)
    assert list(back.profiles) == list(profiles)
    for name, profile in profiles.items():
        np.testing.assert_array_equal(back.profiles[name].position, profile.position)
        np.testing.assert_array_equal(back.profiles[name].height, profile.height)
    assert raw_digest(back) == raw_digest(run)
    other = (sources[0], SourceFile("curved.csv", b"x,z\n1,2\n"))
    assert raw_digest(RawRun(manifest, columns, run.origins, {}, {}, other, profiles=profiles)) != raw_digest(run)
    assert archived(RawRun(manifest, columns, run.origins, {}, {}, sources)).profiles == {}

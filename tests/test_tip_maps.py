"""A height map of a worn ball is integrated as a whole: volume, uncertainty, refusals, and k_D of a run folder."""

import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from end_value_runs import FLAT, RADIUS, described, run_of
from tip_maps import WornBall, lines_of

from tribopipe.archive.store import Archive
from tribopipe.base.errors import FitError
from tribopipe.documents.manifest import ProfileSource
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import DefaultUncertainty
from tribopipe.evaluation.checks.registry import check_run
from tribopipe.evaluation.measurements.pin_on_disc import end_wear, pin_on_disc_wear
from tribopipe.evaluation.measurements.readings import over_places
from tribopipe.evaluation.measurements.tip_map import volume_below_sphere
from tribopipe.evaluation.measurements.track_profile import worn_area
from tribopipe.physics.geometry import worn_volume
from tribopipe.readers.profiles import Units, profiles_in
from tribopipe.results.run import Profile, SourceFile

KEY = "end_values.pin_profile"
BALLS = {
    "plane": WornBall(),
    "small ball, wide scar": WornBall(radius=1.5e-3, scar=1e-3, size=1.7),
    "large ball, narrow scar": WornBall(radius=5e-3, scar=0.2e-3, correlated=5e-6, rough=10e-9),
    "pin not square": WornBall(tilt=0.05),
    "convex": WornBall(curvature=0.6),
    "concave": WornBall(curvature=-1.5),
    "plane subtracted": WornBall(shear=0.01),
    "off the middle": WornBall(off=(0.12e-3, -0.1e-3)),
    "long correlation": WornBall(correlated=20e-6, rough=100e-9),
    "spikes": WornBall(spike=20e-6),
    "pits": WornBall(spike=-20e-6),
    "missing pixels": WornBall(missing=0.2),
    "hole": WornBall(hole=0.08e-3),
    "lines past the middle": WornBall(lines=50, off=(0.0, 7e-6)),
    "large map": WornBall(points=401, lines=301),
    "all of it": WornBall(
        tilt=0.03, shear=0.005, off=(50e-6, 50e-6), spike=-5e-6, missing=0.1, rough=60e-9, correlated=15e-6
    ),
}


def stated(radius, share=0.005):
    return Quantity(value=radius, unit="m", standard_uncertainty=share * radius)


@pytest.mark.slow
@pytest.mark.parametrize("name", BALLS)
def test_volume_is_that_of_the_simulated_scar(name):
    ball = BALLS[name]
    found = volume_below_sphere(ball.map(seed=1), stated(ball.radius))
    spread = found.volume.standard_uncertainty
    assert abs(found.volume.value - ball.volume) < max(2.5 * spread, 0.002 * ball.volume)
    assert spread < 0.02 * ball.volume


@pytest.mark.slow
@pytest.mark.parametrize(("name", "wrong"), [("convex", 0.3), ("concave", 0.5)])
def test_deepest_line_alone_is_wrong_where_the_scar_is_not_plane(name, wrong):
    ball = BALLS[name]
    depth = max(worn_area(line, ball.radius).depth.value for line in ball.map()[40:61])
    assert abs(float(worn_volume(depth=depth, sphere_radius=ball.radius)) / ball.volume - 1) > wrong
    assert volume_below_sphere(ball.map(), stated(ball.radius)).volume.value == pytest.approx(ball.volume, rel=5e-3)


@pytest.mark.slow
def test_intervals_cover_the_volume():
    small = [replace(ball, points=81, lines=81) for name, ball in BALLS.items() if name not in ("large map", "hole")]
    covered = []
    for seed in range(12):
        for number, ball in enumerate(small):
            found = volume_below_sphere(ball.map(seed=100 * seed + number), stated(ball.radius)).volume
            covered.append(abs(found.value - ball.volume) <= 1.96 * found.standard_uncertainty)
    assert len(covered) > 160
    assert np.mean(covered) >= 0.91


@pytest.mark.parametrize("off", [-0.05, -0.01, 0.01, 0.05])
def test_radius_of_the_map_counts_where_the_stated_one_is_wrong(off):
    ball = WornBall()
    found = volume_below_sphere(ball.map(), stated((1 + off) * ball.radius))
    assert found.volume.value == pytest.approx(ball.volume, rel=3e-3)
    assert abs(found.radius.value - ball.radius) < 3 * found.radius.standard_uncertainty
    assert abs(found.per_radius) * 0.005 * ball.radius < 1e-3 * ball.volume


def test_exact_radius_counts_where_the_map_shows_it_badly():
    ball = WornBall(radius=5e-3, scar=0.2e-3, correlated=5e-6)
    known, unknown = (volume_below_sphere(ball.map(), stated(ball.radius, share)) for share in (0.0, 0.1))
    assert known.volume.standard_uncertainty < unknown.volume.standard_uncertainty
    assert abs(known.volume.value - ball.volume) < 2.5 * known.volume.standard_uncertainty
    other = volume_below_sphere(ball.map(), stated(1.001 * ball.radius, 0.0))
    assert other.volume.value - known.volume.value == pytest.approx(known.per_radius * 1e-3 * ball.radius, rel=0.1)


def scaled(lines, along=1.0, across=1.0, up=1.0):
    return [
        replace(line, position=along * line.position, across=across * line.across, height=up * line.height)
        for line in lines
    ]


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        (WornBall(off=(0.3e-3, 0.0)).map(), "found a scar that reaches the edge of the map"),
        (WornBall(size=0.8).map(), "reaches the edge"),
        (scaled(WornBall().map(), up=-1.0), "heights increase outward"),
        (scaled(WornBall().map(), along=10, across=10), "found a map 10 mm long on a tip of radius 3 mm"),
        (scaled(WornBall().map(), up=1.5), r"found a sphere of radius .* expected the radius of the tip, 3 mm"),
        (scaled(WornBall().map(), across=0.5), "found no scar"),
        (WornBall(scar=1e-6, size=1000).map(), "found no scar"),
        (WornBall().map()[::13], "found 6 scan lines across the scar; expected at least 8"),
        (WornBall().map() + WornBall().map()[:1], "found two scan lines at -0.5 mm"),
        (WornBall(hole=0.15e-3).map(), "found no height values in 3. % of the scar; expected at most 25 %"),
    ],
)
def test_what_cannot_be_integrated_is_refused_in_one_sentence(lines, message):
    with pytest.raises(FitError, match=message) as refused:
        volume_below_sphere(lines, stated(3e-3))
    assert str(refused.value).startswith("map: found ")
    assert "; expected " in str(refused.value)


def test_missing_lines_are_interpolated_with_their_uncertainty():
    ball = WornBall()
    whole = ball.map()
    found = volume_below_sphere([*whole[:46], *whole[52:]], stated(ball.radius)).volume
    assert abs(found.value - ball.volume) < 2 * found.standard_uncertainty < 0.01 * ball.volume


# --- runs ---


def mapped_run(ball, shape="spherical", **end):
    lines = {f"{KEY}[{number}]": line for number, line in enumerate(ball.map())}
    return run_of(described(shape, pin_profile={"file": "tip.csv"}, **end), lines)


def test_depth_and_volume_of_the_pin_follow_from_its_map():
    ball = WornBall(radius=RADIUS, scar=0.25e-3, size=1.8, curvature=0.4)
    run = mapped_run(ball)
    (way,) = pin_on_disc_wear(run, DefaultUncertainty()).bodies["pin"]
    assert (way.name, end_wear(run, DefaultUncertainty()).anchor) == ("pin_height_map", "pin_height_map")
    assert way.volume.value == pytest.approx(ball.volume, rel=5e-3)
    assert float(worn_volume(depth=way.depth.value, sphere_radius=RADIUS)) == pytest.approx(way.volume.value, rel=1e-3)


def test_flat_before_the_test_is_not_counted():
    ball = WornBall(radius=RADIUS, scar=0.25e-3, size=1.8)
    (way,) = pin_on_disc_wear(mapped_run(ball, "truncated-sphere"), DefaultUncertainty()).bodies["pin"]
    flat = RADIUS - math.sqrt(RADIUS**2 - FLAT**2)
    before = float(worn_volume(depth=flat, sphere_radius=RADIUS))
    assert way.volume.value == pytest.approx(ball.volume - before, rel=5e-3)
    assert way.depth.value == pytest.approx(ball.depth - flat, rel=5e-3)


@pytest.mark.parametrize("disc", [{"disc_wear_depth": "1 um"}, {"disc_track_width": "280 um"}])
def test_map_is_a_volume_beside_a_worn_track_as_well(disc):
    ball = WornBall(radius=RADIUS, scar=0.25e-3, size=1.8)
    ways = pin_on_disc_wear(mapped_run(ball, **disc), DefaultUncertainty()).bodies
    assert ways["pin"][0].volume.value == pytest.approx(ball.volume, rel=5e-3)
    assert ways["pin"][0].depth.value < ball.depth
    assert ways["disc"][0].depth.value > 0


@pytest.mark.slow
def test_map_without_positions_across_is_used_by_its_deepest_line_with_a_note():
    ball = WornBall(radius=RADIUS, scar=0.25e-3, size=1.8)
    run = mapped_run(ball)
    bare = {name: Profile(line.position, line.height) for name, line in run.profiles.items()}
    found = pin_on_disc_wear(replace(run, profiles=bare), DefaultUncertainty())
    assert found.bodies["pin"][0].name == "pin_profile"
    assert any("deepest line is used" in note for note in found.notes)
    assert not any("deepest" in note for note in pin_on_disc_wear(run, DefaultUncertainty()).notes)


@pytest.mark.slow
def test_map_without_a_scar_is_one_finding():
    run = mapped_run(WornBall(radius=RADIUS, scar=1e-6, size=400))
    (finding,) = [one for one in check_run(run) if one.code == "no_wear_in_profile"]
    assert finding.where == KEY
    assert "found no scar" in finding.message
    with pytest.raises(FitError, match=r"bare: end_values\.pin_profile of map: map: found no scar"):
        end_wear(run, DefaultUncertainty())


@pytest.mark.slow
@pytest.mark.parametrize(("off", "named"), [(0.0, 0), (0.002, 0), (0.05, 1), (-0.1, 1)])
def test_radius_that_is_not_that_of_the_tip_is_named(off, named):
    run = mapped_run(WornBall(radius=(1 + off) * RADIUS, scar=0.25e-3, size=1.8))
    found = [one for one in check_run(run) if one.code == "map_radius_differs"]
    assert len(found) == named
    for finding in found:
        assert (finding.severity, finding.where) == ("warning", KEY)
        shown = re.search(r"radius of ([\d.]+) ± [\d.]+ mm in the height map", finding.message)
        assert float(shown[1]) == pytest.approx((1 + off) * RADIUS * 1e3, rel=5e-3)


def test_mean_of_the_lines_of_a_map_is_as_uncertain_as_lines_that_share_their_noise():
    wander = np.convolve(np.random.default_rng(3).standard_normal(500), np.ones(50) / 50, mode="valid")
    found = [Quantity(value=10 + one, unit="m", standard_uncertainty=0.5) for one in wander]
    assert over_places(found).standard_uncertainty > 0.5 / math.sqrt(len(found) / 20)


# --- files ---


@pytest.mark.slow
def test_map_in_a_file_is_shown_as_a_volume_and_few_of_its_lines(tmp_path, run_cli):
    ball = WornBall()
    (tmp_path / "tip.csv").write_text("x [mm],y [mm],z [um]\n" + points(ball.map()), encoding="utf-8")
    shown = run_cli("show", "tip.csv", "--radius", "3 mm", cwd=tmp_path)
    assert len(shown.stdout.splitlines()) < 20
    assert "8 of 101 scan lines of the height map listed" in shown.stderr
    said = json.loads(run_cli("show", "tip.csv", "--radius", "3 mm", "--json", cwd=tmp_path).stdout)
    assert said["worn_tip"]["volume"]["value"] == pytest.approx(ball.volume, rel=3e-3)
    assert len(said["profiles"]) == 101
    flat = run_cli("show", "tip.csv", "--radius", "1 mm", cwd=tmp_path)
    assert "tip.csv: map: found a sphere of radius" in flat.stderr
    assert json.loads(run_cli("show", "tip.csv", "--json", cwd=tmp_path).stdout)["worn_tip"] is None


def points(lines, scale=(1e3, 1e3, 1e6)) -> str:
    rows = (
        f"{x * scale[0]:.6f},{line.across * scale[1]:.6f},{z * scale[2]:.6f}\n"
        for line in lines
        for x, z in zip(line.position, line.height, strict=True)
    )
    return "".join(rows)


@pytest.mark.parametrize(
    ("head", "scale", "units"),
    [
        ("x [mm],y [um],z [um]", (1e3, 1e6, 1e6), None),
        ("x [mm],y,z [um]", (1e3, 1e3, 1e6), None),
        ("x,y,z", (1e3, 1e3, 1e6), Units("mm", "um")),
    ],
)
def test_lines_know_their_position_across(head, scale, units):
    lines = WornBall(lines=25).map()
    source = SourceFile("tip.csv", f"{head}\n{points(lines, scale)}".encode())
    _, read, _ = profiles_in(source, ProfileSource(file="tip.csv"), KEY, units)
    np.testing.assert_allclose([one.across for one in read], [one.across for one in lines], atol=1e-9)
    assert {one.scan for one in read} == {"tip.csv"}


def test_numbers_of_lines_are_no_positions():
    lines = WornBall(lines=25).map()
    text = "x [mm],y [s],z [um]\n" + points(lines)
    _, read, notes = profiles_in(SourceFile("tip.csv", text.encode()), ProfileSource(file="tip.csv"), KEY)
    assert (len(read), {one.across for one in read}) == (25, {None})
    assert notes == ["column 'y [s]' has no unit of length: the scan lines are evaluated separately"]


RUN = """schema = "tribopipe.run/1"
id = "mapped"
started = 2026-03-01T09:30:00+01:00

[contact]
kind = "pin-on-disc"
pin = { shape = "spherical", radius = "3 mm", material = "100Cr6", youngs_modulus = "210 GPa", poisson_ratio = 0.3 }
disc = { material = "steel", youngs_modulus = "210 GPa", poisson_ratio = 0.3 }

[conditions]
normal_load = "5 N"
sliding_speed = "100 mm/s"
track_radius = "8 mm"

[[signals]]
file = "signals.csv"

[signals.columns]
time = { column = "t", unit = "s" }
friction_force = { column = "F", unit = "N" }

[end_values]
pin_profile = { file = "tip.csv" }
"""


@pytest.mark.slow
def test_k_d_of_the_pin_follows_from_a_map_in_its_run_folder(tmp_path, run_cli, few_draws):  # noqa: ARG001
    ball, slid = WornBall(curvature=0.4, missing=0.05), 500.0
    folder = tmp_path / "mapped"
    folder.mkdir()
    (folder / "run.toml").write_text(RUN, encoding="utf-8")
    time = np.linspace(0, slid / 0.1, 501)
    signals = "".join(f"{t:.1f},{2 + 0.02 * math.sin(t):.4f}\n" for t in time)
    (folder / "signals.csv").write_text("t,F\n" + signals, encoding="utf-8")
    (folder / "tip.csv").write_text("x [mm],y [mm],z [um]\n" + points(ball.map()), encoding="utf-8")
    done = run_cli("process", "mapped", "--json", cwd=tmp_path)
    assert done.exit_code == 0, done.stderr
    (run,) = json.loads(done.stdout)["runs"]
    pin = run["specific_wear"]["pin"]
    assert pin["volume_by"] == "pin_height_map"
    assert pin["volume"]["value"] == pytest.approx(ball.volume, rel=5e-3)
    k_d = run["wear_fits"]["archard"]["bodies"]["pin"]["wear_coefficient"]
    assert k_d["value"] == pytest.approx(ball.volume / (5 * slid), rel=0.03)
    assert run_cli("verify", cwd=tmp_path).exit_code == 0
    assert run_cli("reproduce", cwd=tmp_path).exit_code == 0
    report = run_cli("report", "mapped", cwd=tmp_path)
    assert report.exit_code == 0, report.stderr
    assert "from the height map" in (tmp_path / "mapped.html").read_text(encoding="utf-8")
    again = Archive(tmp_path / "archive").raw("mapped").profiles
    assert again[f"{KEY}[0]"].across == pytest.approx(-0.5e-3)
    assert again[f"{KEY}[0]"].scan == "tip.csv"


def test_lines_of_a_map_may_differ_in_their_positions():
    x, y = np.linspace(-0.5e-3, 0.5e-3, 121), np.linspace(-0.5e-3, 0.5e-3, 101)
    ball = WornBall()
    lines = []
    for number, place in enumerate(y):
        along = x[number % 3 :] + 1e-6 * math.sin(number)
        heights = np.minimum(*ball.surfaces(along, place))
        lines += lines_of(along, [place], [heights + 1e-8 * np.sin(1e7 * along**2 * (1 + number))])
    assert volume_below_sphere(lines, stated(ball.radius)).volume.value == pytest.approx(ball.volume, rel=2e-3)

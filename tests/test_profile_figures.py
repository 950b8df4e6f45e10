"""`tribopipe show` of profiles: what is said, what is drawn, and where it is saved."""

import json

import numpy as np
import pytest
from printable import faults
from test_profile import flattened, with_gap
from test_profile_files import bare
from test_profile_pile_up import AREA, BALL, SCAR, X, piled_up, ridged, scan

from tribopipe.evaluation.measurements.track_profile import examined
from tribopipe.results.run import Profile
from tribopipe.views.profile_figures import draw_profile, drawn_of


def legend(figure) -> list[str]:
    return [text.get_text() for text in figure.legends[0].get_texts()]


def words(figure) -> str:
    return " ".join(text.get_text() for ax in figure.axes for text in [*ax.texts, ax.title])


def drawn(profile, radius=None):
    return draw_profile(profile, examined(profile, radius), "run: key")


@pytest.mark.slow
def test_track_with_pile_up_and_dust():
    figure = drawn(scan(1, high=0.3e-6, grains=4, bend=3.0))
    assert [ax.get_ylabel() for ax in figure.axes] == ["height / µm", "height above unworn surface / µm"]
    assert figure.axes[1].get_xlabel() == "position / mm"
    named = " ".join(legend(figure))
    for word in (
        "as measured",
        "assumed unworn",
        "unworn surface, a parabola",
        "dust",
        "groove: ",
        "pile-up: ",
    ):
        assert word in named
    assert "width 300.19" in words(figure)
    assert "depth 999.0" in words(figure)
    assert "run: key" in figure.axes[0].get_title(loc="left")
    assert faults(figure) == []


@pytest.mark.slow
def test_worn_ball():
    figure = drawn(Profile(X, flattened(X, BALL, SCAR)), BALL)
    assert "unworn surface, an arc" in legend(figure)
    assert not any("pile-up" in name for name in legend(figure))
    assert faults(figure) == []


def test_profile_without_a_track_is_levelled_and_says_so():
    figure = drawn(Profile(X, 0.02 * X + 20e-9 * np.random.default_rng(1).standard_normal(len(X))))
    assert "wear track not evaluated: no feature deeper than the noise" in words(figure)
    assert not any("groove" in name for name in legend(figure))
    assert figure.axes[1].get_ylabel() == "height above unworn surface / nm"


@pytest.mark.parametrize(("middle", "at", "side"), [(0.0, 0.15, "left"), (0.2e-3, 0.05, "right")])
def test_the_depth_is_written_beside_the_groove_where_there_is_room(middle, at, side):
    noise = 5e-9 * np.random.default_rng(1).standard_normal(len(X))
    figure = drawn(Profile(X, ridged(X - middle, 0.0) + noise))
    (depth,) = [text for text in figure.axes[1].texts if "depth" in text.get_text()]
    assert depth.get_ha() == side
    assert depth.get_position()[0] == pytest.approx(at, abs=0.01)


def test_of_many_profiles_some_are_drawn():
    assert drawn_of(["a", "b"]) == ["a", "b"]
    chosen = drawn_of([str(number) for number in range(101)])
    assert (len(chosen), chosen[0], chosen[-1]) == (8, "0", "100")


@pytest.fixture
def track(tmp_path):
    z = ridged(X, 0.3e-6) + 5e-9 * np.random.default_rng(1).standard_normal(len(X))
    (tmp_path / "track.txt").write_text("mm um\n" + bare(X, z), encoding="utf-8")
    return tmp_path


@pytest.mark.slow
def test_show_a_file(run_cli, track):
    told = run_cli("show", "track.txt", "--plot", "--json", cwd=track)
    assert told.exit_code == 0
    document = json.loads(told.stdout)
    (profile,) = document["profiles"]
    assert (document["file"], profile["points"], profile["unworn_surface"]) == ("track.txt", 3001, "line")
    assert profile["track"]["area"]["value"] == pytest.approx(AREA, rel=5e-3)
    assert profile["track"]["pile_up"]["value"] == pytest.approx(piled_up(0.3e-6), rel=0.03)
    assert (track / profile["figure"]).read_bytes().startswith(b"\x89PNG")


def test_show_a_file_to_people(run_cli, track):
    told = run_cli("show", "track.txt", cwd=track)
    assert told.exit_code == 0
    assert "µm²" in told.output
    assert not (track / "figures").exists()


def test_show_a_file_whose_units_nobody_said(run_cli, track):
    (track / "bare.txt").write_text(bare(X, ridged(X, 0.0)), encoding="utf-8")
    told = run_cli("show", "bare.txt", cwd=track)
    assert told.exit_code == 1
    assert "specify --position-unit and --height-unit" in told.stderr
    assert run_cli("show", "bare.txt", "--position-unit", "mm", "--height-unit", "um", cwd=track).exit_code == 0


def test_show_a_file_without_a_track_names_it_once(run_cli, track):
    (track / "short.txt").write_text("mm um\n0 1\n1 2\n2 1\n", encoding="utf-8")
    told = run_cli("show", "short.txt", cwd=track)
    assert told.stderr.startswith("error: short.txt: found 3 points")


def test_show_tells_of_heights_missing_in_a_track(run_cli, tmp_path):
    whole = with_gap("parabola", 9.0, 0.0)
    rows = bare(whole.position, whole.height).splitlines()
    missing = [f"{x:.6f}\t" if abs(x - 1.5) < 0.1 else row for x, row in zip(1e3 * whole.position, rows, strict=True)]
    path = tmp_path / "gap.txt"
    path.write_text("x [mm]\tz [um]\n" + "\n".join(missing), encoding="utf-8")
    told = run_cli("show", path)
    assert "profile: found a gap without heights over 40 % of the width of the wear track; expected" in told.stderr
    (shown,) = json.loads(run_cli("show", path, "--json").stdout)["profiles"]
    area = shown["track"]["area"]
    assert abs(area["value"] - 2000e-12) < 2 * area["standard_uncertainty"] < 400e-12


def test_of_many_profiles_without_a_track_the_first_says_why(run_cli, track):
    flat = "".join(f"{x / 100} {y / 100} {(x * 7 + y) % 5}\n" for y in range(6) for x in range(40))
    (track / "map.txt").write_text("mm mm nm\n" + flat, encoding="utf-8")
    told = run_cli("show", "map.txt", cwd=track)
    assert "wear track not evaluated in 6 of 6 profiles, which are only leveled" in told.stderr
    assert told.stderr.count("expected a wear track") == 1


def test_a_file_that_is_not_there_is_no_run_either(run_cli, track):
    told = run_cli("show", "trak.txt", cwd=track)
    assert told.exit_code == 1
    assert "trak.txt: found neither a file nor a run with this name in archive" in told.stderr
    assert "did you mean 'track.txt'?" in told.stderr


def test_show_a_ball(run_cli, track):
    (track / "ball.txt").write_text("mm um\n" + bare(X, flattened(X, BALL, SCAR)), encoding="utf-8")
    told = run_cli("show", "ball.txt", "--radius", "3 mm", "--json", cwd=track)
    (profile,) = json.loads(told.stdout)["profiles"]
    assert profile["unworn_surface"] == "arc"
    assert profile["track"]["width"]["value"] == pytest.approx(2 * SCAR, rel=2e-3)
    assert profile["track"]["cap"]["unit"] == "m^3"
    assert run_cli("show", "ball.txt", "--radius", "3", cwd=track).exit_code == 1


@pytest.mark.slow
def test_show_a_run(run_cli, archive):
    told = run_cli("show", "si3n4-air-200mN", "--plot", "--json", "--archive", archive)
    assert told.exit_code == 0
    assert json.loads(told.stdout)["profiles"] == []


@pytest.mark.slow
def test_show_a_run_with_profiles(run_cli, sample_run, track):
    for name in ("track.txt", "track-2.txt"):
        (sample_run / name).write_bytes((track / "track.txt").read_bytes())
    manifest = (sample_run / "run.toml").read_text(encoding="utf-8")
    twice = 'disc_profile = [{ file = "track.txt" }, { file = "track-2.txt" }]'
    manifest = manifest.replace("[end_values]", f"[end_values]\n{twice}", 1)
    (sample_run / "run.toml").write_text(manifest, encoding="utf-8")
    assert run_cli("ingest", sample_run, "--archive", track / "kept").exit_code == 0
    told = run_cli("show", "si3n4-air-400mN", "--plot", "--archive", track / "kept")
    assert told.exit_code == 0
    assert "end_values.disc_profile[1]" in told.output
    drawn = sorted(path.name for path in (track / "kept" / "figures").iterdir())
    assert drawn == [f"si3n4-air-400mN-end_values-disc_profile-{number}.png" for number in (0, 1)]

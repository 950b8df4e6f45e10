"""From files to profiles: which reader, which columns, scan lines of maps, several passes, units."""

import numpy as np
import pytest
from sweeps import others_slow
from test_profile import HALF, X, grooved, manifest_with, rows

from tribopipe.base.errors import ReaderError
from tribopipe.documents.manifest import ProfileSource, RunManifest
from tribopipe.evaluation.measurements.readings import profiles_at
from tribopipe.evaluation.measurements.track_profile import reference_radius, worn_area
from tribopipe.readers.profiles import Units, profiles_in, read_profiles
from tribopipe.results.run import RawRun, SourceFile

END = "end_values.flat_disc_profile"
LINES = (0.0, 0.1, 0.25, 0.3)


def named(**keys) -> ProfileSource:
    return ProfileSource.model_validate({"file": "p.txt"} | keys)


def profiles(text: str, units: Units | None = None, **keys):
    return profiles_in(SourceFile("p.txt", text.encode()), named(**keys), END, units)


def bare(x, z, scale=1e3, up=1e6) -> str:
    return "".join(f"{a * scale:.6f}\t{b * up:.6f}\n" for a, b in zip(x, z, strict=True))


def scan_lines(*columns: int) -> str:
    """A map with a groove along y, deeper from line to line; x in mm, y in mm, z in um."""
    points = [(a * 1e3, y, b * 1e6) for y in LINES for a, b in zip(X, grooved(X) * (1 + y), strict=True)]
    return "".join(" ".join(f"{point[column]:.6f}" for column in columns) + "\n" for point in points)


def run_with(folder, source) -> tuple[dict, list, list]:
    sources, notes = [], []
    found = read_profiles(manifest_with(end={"flat_disc_profile": source}), folder, sources, {}, notes)
    return found, [one.name for one in sources], notes


def test_bare_columns_with_units_from_run_toml():
    keys = {"position": {"column": "x", "unit": "mm"}, "height": {"column": "z", "unit": "um"}}
    table, (profile,), notes = profiles(bare(X, grooved(X)), **keys)
    assert (len(table.columns), notes) == (2, [])
    np.testing.assert_allclose(profile.position, X, atol=1e-9)
    np.testing.assert_allclose(profile.height, grooved(X), atol=1e-12)
    (other,) = profiles(bare(X, grooved(X)), Units("mm", "um"))[1]
    np.testing.assert_array_equal(profile.height, other.height)


def test_units_that_the_file_says_need_no_column():
    _, (profile,), _ = profiles("mm um\n" + bare(X, grooved(X)))
    assert worn_area(profile, None).area.value == pytest.approx(4 / 3 * 0.3e-6 * HALF, rel=1e-3)


@pytest.mark.parametrize(
    "header", others_slow(["x [mm],z [um]", "X (mm),Z (um)", "Position [mm],Height [um]", "s [mm],h [um]"])
)
def test_tables_with_names(header):
    _, (profile,), _ = profiles(rows(X * 1e3, grooved(X) * 1e6).replace("x,z", header))
    np.testing.assert_allclose(profile.height, grooved(X), atol=1e-12)


@pytest.mark.parametrize(
    "header",
    [
        "Height [µm];Position [mm]",
        *others_slow(
            [
                "Höhe [µm];Weg [mm]",
                "Profile (µm);Lateral (mm)",
                "Wear track depth [µm];A [mm]",
                "B [µm];Distance [mm]",
                "Z position [µm];X position [mm]",
                "Hauteur [µm];Déplacement horizontal [mm]",
                "高さ [µm];位置 [mm]",
                "z [µm];y [mm]",
            ]
        ),
    ],
)
def test_height_may_come_before_position_where_names_tell(header):
    text = header + "\n" + "".join(f"{b * 1e6:.6f};{a * 1e3:.6f}\n" for a, b in zip(X, grooved(X), strict=True))
    _, (profile,), _ = profiles(text)
    np.testing.assert_allclose(profile.position, X, atol=1e-9)
    np.testing.assert_allclose(profile.height, grooved(X), atol=1e-12)


def test_with_one_column_in_run_toml_the_other_length_is_the_other():
    text = "A [µm],B [mm]\n" + "".join(f"{b * 1e6:.6f},{a * 1e3:.6f}\n" for a, b in zip(X, grooved(X), strict=True))
    for keys in ({"height": "A"}, {"position": "B"}):
        _, (profile,), _ = profiles(text, **keys)
        np.testing.assert_allclose(profile.position, X, atol=1e-9)
        np.testing.assert_allclose(profile.height, grooved(X), atol=1e-12)


def test_scan_forth_and_back_is_refused():
    back = X[::-1] + 0.1e-6
    text = bare([*X, *back], grooved(np.array([*X, *back])))
    with pytest.raises(ReaderError, match=r"p\.txt, column .*: found positions that run back by 0\.6 mm.*single pass"):
        profiles("mm um\n" + text)


def test_heights_under_the_name_of_positions_are_refused():
    wavy = (np.sin(X / 20e-6) + X) * 1e-6
    text = "A [µm],B [mm]\n" + "".join(f"{b * 1e6:.12f},{a * 1e3:.6f}\n" for a, b in zip(X, wavy, strict=True))
    with pytest.raises(ReaderError, match=r"column 'A.*: found positions that run back.*position"):
        profiles(text)


@pytest.mark.parametrize("x", others_slow([X, X[::-1]]))
def test_jitter_of_positions_is_no_second_pass(x):
    jitter = np.random.default_rng(1).normal(0, 3e-6, len(x))  # five times the spacing
    pairs = zip(x + jitter, grooved(x + jitter), strict=True)
    text = "mm um\n" + "".join(f"{a * 1e3:.9f}\t{b * 1e6:.6f}\n" for a, b in pairs)
    _, (profile,), notes = profiles(text)
    assert notes == []
    np.testing.assert_allclose(profile.position, np.sort(x + jitter), atol=1e-9)


def test_columns_that_cannot_be_told_have_to_be_said():
    text = rows(X * 1e3, grooved(X) * 1e6)
    for header in ("position [mm],time [s]", "a,b"):
        with pytest.raises(ReaderError, match=r"in which position and height cannot be identified.*under end_values"):
            profiles(text.replace("x,z", header))
    keys = {"position": {"column": "a", "unit": "mm"}, "height": {"column": "b", "unit": "um"}}
    assert profiles(text.replace("x,z", "a,b"), **keys)[1]


def test_map_gives_a_profile_for_each_scan_line():
    _, lines, notes = profiles(scan_lines(0, 1, 2), Units("mm", "um"))
    assert notes == []
    areas = [worn_area(line, None).area.value for line in lines]
    assert areas == pytest.approx([4 / 3 * 0.3e-6 * HALF * (1 + y) for y in LINES], rel=1e-3)


def test_scan_lines_run_along_the_column_that_run_toml_names():
    text = scan_lines(1, 0, 2)
    _, lines, _ = profiles(text, Units("mm", "um"), position="y")
    assert len(lines) == len(LINES)
    with pytest.raises(ReaderError, match="found 4 points with both position and height"):
        profiles(text, Units("mm", "um"))


def test_scan_lines_with_too_few_points_are_left_out():
    points = scan_lines(0, 1, 2).splitlines(keepends=True)
    _, lines, notes = profiles("".join(points[: 3 * len(X) + 5]), Units("mm", "um"))
    assert len(lines) == 3
    assert notes == ["1 of 4 scan lines omitted, since they have fewer than 20 points each"]


def test_keys_count_profiles_over_files_and_lines(tmp_path):
    (tmp_path / "map.txt").write_text(scan_lines(0, 1, 2), encoding="utf-8")
    (tmp_path / "one.txt").write_text("mm um\n" + bare(X, grooved(X)), encoding="utf-8")
    unit = {"position": {"column": "x", "unit": "mm"}, "height": {"column": "z", "unit": "um"}}
    single, files, _ = run_with(tmp_path, {"file": "one.txt"})
    assert (list(single), files) == ([END], ["one.txt"])
    several, files, _ = run_with(tmp_path, [{"file": "map.txt", **unit}, {"file": "one.txt"}])
    assert list(several) == [f"{END}[{number}]" for number in range(5)]
    assert files == ["map.txt", "one.txt"]
    run = RawRun(manifest_with(), {}, {}, {}, {}, (), profiles=several)
    assert list(profiles_at(run, END)) == list(several)


def test_errors_name_the_place_in_run_toml(tmp_path):
    (tmp_path / "one.txt").write_text("mm um\n" + bare(X, grooved(X)), encoding="utf-8")
    (tmp_path / "folder").mkdir()
    with pytest.raises(ReaderError, match=r"end_values\.flat_disc_profile\[1\]\.file"):
        run_with(tmp_path, [{"file": "one.txt"}, {"file": "folder"}])
    with pytest.raises(ReaderError, match=r"flat_disc_profile\.reader of one\.txt: found the unknown reader 'dektac'"):
        run_with(tmp_path, {"file": "one.txt", "reader": "dektac"})


def test_reader_named_wins():
    with pytest.raises(ReaderError, match="no section 'Scan Data'"):
        profiles("mm um\n" + bare(X, grooved(X)), reader="dektak")


def test_positions_that_were_rounded_are_spread_evenly():
    rounded = np.round(np.linspace(0, 50, 1001), 1)
    text = "um um\n" + "".join(f"{a:.1f}\t{b:.4f}\n" for a, b in zip(rounded, np.sin(rounded), strict=True))
    _, (profile,), notes = profiles(text)
    np.testing.assert_allclose(profile.position, np.linspace(0, 50e-6, 1001), atol=1e-12)
    assert len(notes) == 1
    assert "rounded" in notes[0]


def test_positions_that_repeat_otherwise_are_refused():
    with pytest.raises(ReaderError, match=r"found the position 0\.01 mm 2 times"):
        profiles("um um\n" + "".join(f"{a}.0\t{a / 7:.3f}\n" for a in (*range(11), 10, *range(30, 60))))


def test_radius_of_the_unworn_surface_by_key():
    twin = manifest_with()
    assert reference_radius(twin, "end_values.curved_disc_profile[3]") == twin.described.curved_disc.crown_radius
    assert reference_radius(twin, "interruptions[0].flat_disc_profile") is None
    pin = RunManifest.model_validate(
        twin.model_dump(exclude={"contact", "conditions"}, exclude_none=True, by_alias=True)
        | {
            "contact": {
                "kind": "pin-on-disc",
                "pin": {"shape": "spherical", "radius": "3 mm", **_steel()},
                "disc": _steel(),
            },
            "conditions": {"normal_load": "5 N", "sliding_speed": "0.1 m/s"},
        }
    )
    assert reference_radius(pin, "end_values.pin_profile").value == pytest.approx(3e-3)
    assert reference_radius(pin, "end_values.disc_profile[0]") is None


def _steel() -> dict:
    return {"material": "steel", "youngs_modulus": "210 GPa", "poisson_ratio": 0.3}

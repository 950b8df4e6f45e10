"""Profiles that nobody on this project measured: detected, and read as the notes beside them say."""

from pathlib import Path

import numpy as np
import pytest

from tribopipe.base.errors import FitError, ReaderError
from tribopipe.documents.manifest import ProfileSource
from tribopipe.evaluation.measurements.track_profile import Level, examined
from tribopipe.readers.profiles import Units, profiles_in
from tribopipe.readers.reader import Hints, candidates, detect, readers
from tribopipe.results.run import SourceFile

REAL_DATA = Path(__file__).resolve().parents[2] / "shared" / "realdata"
EXAMPLES = "profil-surfacetopography/test/file_format_examples"
BEARINGS = "profil-roller-bearing-cr"
MAP, POINTS = ["x", "y", "z"], ["x", "z"]

# Reader, axes, rows, units, and the ranges of positions and heights, in those units.
FILES = {
    f"{EXAMPLES}/dektak-1.csv": ("dektak", POINTS, 9600, ["um", "micrometer"], (0, 1499.8), (-0.00933, 16.58112)),
    f"{EXAMPLES}/gwyddion-export-english.txt": ("gwyddion-text", MAP, 12, ["µm", "nm", "m"], (2.0567, 10.283), (-6, 9)),
    f"{EXAMPLES}/gwyddion-export-german.txt": ("gwyddion-text", MAP, 12, ["µm", "nm", "m"], (2.0567, 10.283), (-6, 9)),
    f"{EXAMPLES}/nonuniform.asc": ("points", POINTS, 134, [None] * 2, (39.199303, 1723.8003), (166.48382, 227.8895)),
    f"{EXAMPLES}/opdx-3.txt": ("points", POINTS, 3001, [None] * 2, (0, 4.9966689e-05), (-2.1191196e-09, 1.5032702e-08)),
    f"{EXAMPLES}/xy-1.txt": ("points", POINTS, 132, [None] * 2, (13.381669, 200.5721), (17.549103, 30.854306)),
    f"{EXAMPLES}/xy-2.txt": ("points", POINTS, 24, ["µm", "µm"], (13.381669, 42.591941), (17.549103, 29.477905)),
    f"{EXAMPLES}/xy-4.txt": ("points", POINTS, 10001, [None] * 2, (0, 0.995613), (-0.053303, 0.003775)),
    "profil-nanovea-st400/test_data/test1.txt": ("points", MAP, 10201, [None] * 3, (0, 0.5), (384.9515, 503.2302)),
    f"{BEARINGS}/81212-RE-1.txt": ("points", POINTS, 8064, [None] * 2, (0, 9.398834), (-13.879324, 0.989736)),
    f"{BEARINGS}/NU206-IR-1.txt": ("points", POINTS, 7900, [None] * 2, (0, 13.713542), (-234.770099, 0.429585)),
    f"{BEARINGS}/NU206-IR-2.txt": ("points", POINTS, 8064, [None] * 2, (0, 13.998264), (-251.34103, 3.061952)),
    f"{BEARINGS}/NU206-RE-1.txt": ("points", POINTS, 7952, [None] * 2, (0, 9.859871), (-96.103005, 1.144085)),
    f"{BEARINGS}/NU206-RE-2.txt": ("points", POINTS, 8064, [None] * 2, (0, 9.99876), (-321.976464, 1.503531)),
    f"{BEARINGS}/NU208-IR-1.txt": ("points", POINTS, 8064, [None] * 2, (0, 12.998388), (-168.928491, 2.561337)),
    f"{BEARINGS}/NU2208-IR-1.txt": ("points", POINTS, 8063, [None] * 2, (0, 18.995288), (-269.522512, 2.363538)),
}


def source(name: str) -> SourceFile:
    path = REAL_DATA / name
    if not path.is_file():
        pytest.skip(f"real data not here: {name}")
    return SourceFile(path.name, path.read_bytes())


def profiles(name: str, position: str | None = None, height: str | None = None):
    found = source(name)
    return profiles_in(found, ProfileSource(file=found.name), "end_values.disc_profile", Units(position, height))


@pytest.mark.parametrize("name", FILES)
def test_detected_and_read_as_the_notes_say(name):
    reader, axes, rows, units, along, heights = FILES[name]
    file = source(name)
    assert detect(file).name == reader
    table = readers()[reader].read(file, Hints())
    assert [column.axis for column in table.columns] == axes
    assert [column.unit for column in table.columns] == units
    assert {len(column.values) for column in table.columns} == {rows}
    assert {column.first_bad for column in table.columns} == {None}
    for column, (least, most) in ((table.columns[0], along), (table.columns[-1], heights)):
        assert np.min(column.values) == pytest.approx(least, rel=1e-4)
        assert np.max(column.values) == pytest.approx(most, rel=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("name", FILES)
def test_no_other_reader_of_profiles_claims_it(name):
    claimed = [reader.name for reader, match in candidates(source(name), "profile") if match.confidence >= 0.5]
    assert claimed == [FILES[name][0]]


@pytest.mark.slow
def test_no_reader_of_profiles_claims_signals():
    folders = [path for path in REAL_DATA.glob("*") if path.is_dir() and not path.name.startswith("profil-")]
    files = [path for folder in folders for path in folder.rglob("*") if path.is_file()]
    if not files:
        pytest.skip("real data not here")
    claimed = {
        path.name: reader.name
        for path in files
        for reader, match in candidates(SourceFile(path.name, path.read_bytes()[: 1 << 19]), "profile")[:1]
        if match.confidence >= 0.5
    }
    assert claimed == {}


def test_dektak_scan_in_si():
    _, (scan,), notes = profiles(f"{EXAMPLES}/dektak-1.csv")
    assert notes == []
    assert (len(scan.position), scan.position[-1]) == (9600, pytest.approx(1.4998e-3))
    assert np.ptp(scan.height) == pytest.approx(16.6e-6, rel=1e-3)
    found = examined(scan, None)
    assert isinstance(found, Level)
    # The tilt of 16.6 µm is gone; what is left is the bow of the stage, and dust.
    assert np.std(scan.height - found.unworn) < 0.12e-6


def test_map_gives_a_profile_for_each_scan_line():
    _, lines, _ = profiles("profil-nanovea-st400/test_data/test1.txt", "mm", "um")
    assert len(lines) == 101
    for line in lines:
        np.testing.assert_allclose(line.position, np.linspace(0, 0.5e-3, 101), atol=1e-12)
    assert max(np.max(line.height) for line in lines) == pytest.approx(503.2302e-6)


@pytest.mark.slow
def test_units_that_a_file_does_not_say_have_to_be_said():
    with pytest.raises(ReaderError, match=r"xy-4\.txt, column 'x': found no unit; expected a unit for position"):
        profiles(f"{EXAMPLES}/xy-4.txt")
    _, (profile,), _ = profiles(f"{EXAMPLES}/xy-4.txt", "mm", "um")
    assert profile.position[-1] == pytest.approx(0.995613e-3)


@pytest.mark.slow
def test_rollers_whose_ends_drop_off_have_no_track():
    for name in FILES:
        if name.startswith(BEARINGS):
            _, (profile,), _ = profiles(name, "mm", "um")
            try:
                found = examined(profile, None)
            except FitError:
                continue
            assert isinstance(found, Level), name

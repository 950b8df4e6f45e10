"""Readers that a lab describes in TOML: the one of the documentation, and every way in which one can be wrong."""

import json
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator
from small_exports import check_every_cut, claimed_by, read

from tribopipe.base.errors import ManifestError, ReaderError
from tribopipe.readers.harmonize import read_run
from tribopipe.readers.reader import Reader
from tribopipe.readers.toml_reader import DescribedReader, described_reader
from tribopipe.results.json_schema import schema_text
from tribopipe.results.run import SourceFile

DOCUMENT = (Path(__file__).resolve().parents[1] / "docs" / "readers.md").read_text(encoding="utf-8")
PROFILE, MANIFEST = re.findall(r"```toml\n(.*?)```", DOCUMENT, re.DOTALL)[:2]
EXPORT = re.findall(r"```text\n(.*?)```", DOCUMENT, re.DOTALL)[0].encode()

HEAD = 'schema = "tribopipe.reader/1"\nname = "rig"\ntitle = "Rig"\n'
LEAST = HEAD + '[columns]\nt = { signal = "time", unit = "s" }\n'


@pytest.fixture
def made(tmp_path):
    """Give a function that writes a profile and makes its reader."""

    def make(written: str) -> DescribedReader:
        path = tmp_path / "rig.toml"
        path.write_text(written, encoding="utf-8")
        return described_reader(path)

    return make


def refusal(made, written: str) -> str:
    with pytest.raises(ManifestError) as caught:
        made(written)
    message = str(caught.value)
    assert "\n" not in message
    return message.partition("rig.toml: ")[2]


def columns(table) -> list[tuple[str, str | None, str | None]]:
    return [(column.name, column.unit, column.signal) for column in table.columns]


# --- the example of the documentation ---


def test_the_example_is_short_and_fits_its_schema():
    assert len(PROFILE.splitlines()) < 20
    assert f"in {len(PROFILE.splitlines())} lines" in DOCUMENT
    Draft202012Validator(json.loads(schema_text("reader"))).validate(tomllib.loads(PROFILE))


@pytest.mark.parametrize("end", [b"\n", b"\r\n", b"\r"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "cp1252"])
def test_the_example_reads_its_file(made, end, encoding):
    reader = made(PROFILE)
    assert isinstance(reader, Reader)
    content = EXPORT.replace(b"\n", end).decode().encode(encoding)
    assert reader.match(SourceFile("x", content)).confidence >= 0.9
    table = read(reader, content)
    assert columns(table) == [
        ("Zeit", "s", "time"),
        ("Ft", "V", None),
        ("Ft, calibrated", "N", "friction_force"),
        ("Weg", "um", None),
        ("Weg, calibrated", "um", "depth"),
        ("Notiz", None, None),
    ]
    values = [column.values for column in table.columns]
    assert values[0].tolist() == [0.0, 0.1, 0.2]
    assert values[1].tolist() == [0.012, 0.512, 0.514]
    assert values[2] == pytest.approx([0.0, 1.02, 1.02 + 0.98 * 0.002 / 0.501])
    assert values[4].tolist() == [-102.5, -102.4, -102.1]
    assert values[5].tolist() == ["start", "", ""]
    assert table.facts == {"started": "2024-05-03T14:05:00", "conditions.normal_load": "5.0 N"}
    assert table.notes == (
        "'Ft, calibrated' is in N with the calibration 'load cell, 2024-03'",
        "'Weg, calibrated' is 'Weg' × -1",
    )
    assert table.header.encode().startswith(b"Pin-on-disc rig 12")


def test_the_example_claims_its_files_alone(made):
    assert claimed_by(made(PROFILE)) == []
    assert made(LEAST).match(SourceFile("x", EXPORT)).confidence == 0.0


@pytest.mark.slow
def test_the_example_cut_anywhere(made):
    check_every_cut(made(PROFILE), EXPORT, from_byte=EXPORT.index(b"Zeit"))


# --- where the table is ---


def test_names_given_for_a_file_that_has_none(made):
    reader = made('names = ["t", "V"]\nseparator = ","\n' + LEAST)
    assert columns(read(reader, b"0.5,1\n1.0,2\n")) == [("t", "s", "time"), ("V", None, None)]
    below = made('names = ["t", "V"]\nseparator = ","\nheader_lines = 2\n' + LEAST)
    table = read(below, b"Rig 3\n7,8\n0.5,1\n1.0,2\n")
    assert table.columns[0].values.tolist() == [0.5, 1.0]
    assert table.header == "Rig 3\n7,8\n"


def test_units_above_the_names_and_columns_between_blanks(made):
    reader = made('separator = " "\nheader_lines = 2\nunits_row = "above"\n' + LEAST.replace(', unit = "s"', ""))
    table = read(reader, b"Rig 3\n  ms   N\n   t  Ft\n   5   1,5\n  10  -1,5\n")
    assert columns(table) == [("t", "ms", "time"), ("Ft", "N", None)]
    assert table.columns[1].values.tolist() == [1.5, -1.5]


def test_a_table_found_by_itself(made):
    table = read(made(LEAST), b"Rig 3\n\nt;Ft [N]\n0,5;1\n1,0;2\n")
    assert columns(table) == [("t", "s", "time"), ("Ft [N]", "N", None)]
    assert table.columns[0].values.tolist() == [0.5, 1.0]


def test_profile_of_heights(made):
    reader = made(
        HEAD + 'holds = "profile"\nseparator = "\\t"\nheader_lines = 0\n[columns]\n"X" = { axis = "x", unit = "mm" }\n'
        '"Z [nm]" = { axis = "z", scale = 1e-3, unit = "um" }\n'
    )
    assert reader.holds == "profile"
    table = read(reader, b"X\tZ [nm]\n0.1\t1500\n0.2\t-2500\n")
    assert [(column.name, column.unit, column.axis) for column in table.columns] == [
        ("X", "mm", "x"),
        ("Z [nm]", "nm", None),
        ("Z [nm], calibrated", "um", "z"),
    ]
    assert table.columns[2].values == pytest.approx([1.5, -2.5])


@pytest.mark.parametrize(
    ("place", "content", "message"),
    [
        ('starts_at = "^t;"', b"Zeit;Ft\n0;1\n", r"found no line that matches '\^t;' among the first 2"),
        ("header_lines = 9", b"t;Ft\n0;1\n", "found 2 lines; expected a table below the first 9"),
        ("header_lines = 0", b"u;Ft\n0;1\n", "found no column 't' for time"),
        (
            'header_lines = 0\nunits_row = "below"',
            b"t;Ft\n0;1\n1;2\n",
            "line 2: found the number '0'; expected the row of",
        ),
        ("header_lines = 0", b"t;Ft\n", "no data rows below the header"),
        ("header_lines = 0", b"t;Ft\n0;1\n1\n2;3\n", "line 3: found 1 field, expected 2"),
        ("header_lines = 0", b"t;Ft\n0;1\n1;2;3\n", "line 3: found 3 fields, expected 2"),
        ("header_lines = 0", b"", "empty file"),
        ("header_lines = 0", b"t;Ft\n\x00\x01", "zero byte"),
    ],
)
def test_files_that_are_not_as_described(made, place, content, message):
    reader = made(f'separator = ";"\n{place}\n{LEAST}')
    with pytest.raises(ReaderError, match=rf"^test\.txt.*{message}"):
        read(reader, content)


def test_a_column_described_with_its_unit_and_without(made):
    with pytest.raises(ReaderError, match=r"found 't \[s\]' twice in the profile 'rig'"):
        read(made(LEAST + '"t [s]" = {}\n'), b"t [s];Ft\n0;1\n1;2\n")


def test_encoding_and_decimal_sign_told(made):
    reader = made('encoding = "shift_jis"\ndecimal = ","\n' + LEAST.replace("\nt =", '\n"時間" ='))
    table = read(reader, "時間\tFt\n0,5\t1\n1\t2\n".encode("shift_jis"))
    assert table.columns[0].values.tolist() == [0.5, 1.0]


# --- calibrations ---


def calibrated(made, calibration: str, content: bytes = b"t;F\n0;0\n1;1\n2;2\n3;nan\n", column: str = ""):
    profile = HEAD + f'[columns]\nF = {{ calibration = "c"{column} }}\n[calibrations.c]\nreading = "V"\nunit = "N"\n'
    return read(made(profile + calibration), content)


def test_points_in_any_order(made):
    table = calibrated(made, "points = [[3, 30], [0, -1], [2, 10]]")
    assert table.columns[2].values == pytest.approx([-1, 4.5, 10, np.nan], nan_ok=True)
    assert columns(table)[1:] == [("F", "V", None), ("F, calibrated", "N", None)]


def test_polynomial(made):
    table = calibrated(made, "polynomial = [1, 0, 2]\nrange = [0, 2]")
    assert table.columns[2].values == pytest.approx([1, 3, 9, np.nan], nan_ok=True)


@pytest.mark.parametrize("held", ["points = [[0, 0], [1.5, 3]]", "polynomial = [0, 2]\nrange = [0, 1.5]"])
def test_nothing_is_extrapolated(made, held):
    with pytest.raises(
        ReaderError, match=r"found 2 V in row 3 of the table, outside the range of the calibration 'c', 0 to 1"
    ):
        calibrated(made, held)
    table = calibrated(made, f'{held}\noutside = "missing"')
    assert table.columns[2].values == pytest.approx([0, 2, np.nan, np.nan], nan_ok=True)
    assert table.notes[-1].endswith("; 1 readings outside the range of the calibration 'c', 0 to 1.5 V are missing")


def test_scale_comes_before_the_calibration(made):
    content = b"t;F [mV]\n0;500\n1;1000\n"
    table = calibrated(made, "points = [[0, 0], [1, 10]]", content, ', unit = "V", scale = 1e-3')
    assert columns(table)[1:] == [("F [mV]", "mV", None), ("F [mV], calibrated", "N", None)]
    assert table.columns[2].values == pytest.approx([5, 10])
    assert table.notes[0] == "'F [mV], calibrated' is 'F [mV]' × 0.001"
    with pytest.raises(ReaderError, match="in mV; expected V, the unit of calibration"):
        calibrated(made, "points = [[0, 0], [1, 10]]", content)


def test_a_name_that_is_taken(made):
    with pytest.raises(ReaderError, match="found the column 'F, calibrated' in the file, although"):
        calibrated(made, "points = [[0, 0], [1, 10]]", b"t;F;F, calibrated\n0;0;0\n1;1;1\n")


def test_what_is_no_number_cannot_be_calibrated(made):
    with pytest.raises(ReaderError, match=r"line 3, column 'F': found '8.0.1'; expected a number"):
        calibrated(made, "points = [[0, 0], [1, 10]]", b"t;F\n0;1\n1;8.0.1\n")


READINGS = st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=20)


@settings(max_examples=50, deadline=None)
@given(st.lists(st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)), min_size=2, max_size=6), READINGS)
def test_calibrated_values_stay_within_the_points(tmp_path_factory, points, readings):
    if len({reading for reading, _ in points}) < len(points):
        return
    path = tmp_path_factory.mktemp("profile") / "rig.toml"
    path.write_text(
        HEAD + '[columns]\nF = { calibration = "c" }\n[calibrations.c]\nreading = "V"\nunit = "N"\n'
        f'outside = "missing"\npoints = {[list(point) for point in points]}\n',
        encoding="utf-8",
    )
    content = "t;F\n" + "".join(f"{n};{reading!r}\n" for n, reading in enumerate(readings)) + "99;\n"
    made = read(described_reader(path), content.encode()).columns[2].values[:-1]
    inside = [min(points)[0] <= reading <= max(points)[0] for reading in readings]
    assert np.isfinite(made).tolist() == inside
    values = [value for _, value in points]
    assert all(min(values) - 1e-9 <= value <= max(values) + 1e-9 for value in made[inside])


# --- facts ---


def test_facts_of_the_header(made):
    facts = (
        '[facts]\noperator = "Operator: .*"\n"conditions.track_radius" = { pattern = "R=([0-9.]+)", unit = "mm" }\n'
        '"contact.pin.material" = "Ball (.*)"\ntitle = "Not there"\n'
    )
    table = read(made(LEAST + facts), b"Operator: X\rBall 100Cr6\r\nR=6.5\n\nt;Ft\n0.5;1\n1;2\n")
    assert table.facts == {
        "operator": "Operator: X",
        "conditions.track_radius": "6.5 mm",
        "contact.pin.material": "100Cr6",
    }


def test_a_date_that_is_written_otherwise(made):
    reader = made(LEAST + '[facts]\nstarted = { pattern = "On (.*)", date = "%d.%m.%Y" }\n')
    with pytest.raises(ReaderError, match=r"started: found '2024-05-03'; expected a date in the form '%d\.%m\.%Y'"):
        read(reader, b"On 2024-05-03\nt;Ft\n0.5;1\n1;2\n")


# --- profiles that are wrong ---


def with_calibration(held: str, column: str = "") -> str:
    calibration = f'[calibrations.c]\nreading = "V"\nunit = "N"\n{held}\n'
    return f'{LEAST}F = {{ calibration = "c"{column} }}\n{calibration}'


@pytest.mark.parametrize(
    ("written", "message"),
    [
        (HEAD, "columns: missing"),
        (HEAD + "[columns]\n", "columns: found"),
        (
            LEAST.replace('"rig"', '"My Rig!"'),
            "name: found 'My Rig!'; expected at most 60 lowercase letters",
        ),
        (LEAST.replace('"time"', '"tme"'), "columns.t.signal: found 'tme'; expected"),
        (LEAST.replace('"s"', '"seconds since"'), "columns.t.unit: found 'seconds since', which is not a unit"),
        (LEAST + 'u = { signal = "time" }', "columns.u.signal: found 'time', which is also the signal of 't'"),
        ('detect = "("\n' + LEAST, "detect: found '(', which is not a regular expression"),
        ('separator = ";;"\n' + LEAST, "separator: found ';;'; expected one character"),
        ("header_lines = 3\n" + LEAST, "separator: missing"),
        (
            'header_lines = 3\nstarts_at = "^t"\nseparator = ";"\n' + LEAST,
            "header_lines: found header_lines in addition to starts_at",
        ),
        ('units_row = "below"\n' + LEAST, "units_row: found units_row without the position of the header row"),
        ('names = ["x", "F"]\nseparator = ";"\n' + LEAST, "columns.t: found a column that is not in names"),
        ("colums = 3\n" + LEAST, "colums: unknown key; did you mean 'columns'"),
        (LEAST + 'F = { calibration = "c" }', "columns.F.calibration: found 'c', which is not defined"),
        (LEAST + '[facts]\n"conditions.load" = "x"', "facts.conditions.load: found a key unknown in run.toml"),
        (with_calibration(""), "calibrations.c: found neither points nor polynomial"),
        (with_calibration("points = [[0, 1]]"), "calibrations.c: points: found one pair"),
        (with_calibration("points = [[0, 1], [0, 2]]"), "points: found the reading 0 twice"),
        (with_calibration("polynomial = [0, 1]"), "range: found a polynomial without a range"),
        (with_calibration("polynomial = [0, 1]\nrange = [2, 1]"), "range: found [2.0, 1.0]"),
        (with_calibration("points = [[0, nan], [1, 2]]"), "finite number"),
        (
            with_calibration("points = [[0, 1], [1, 2]]", ', unit = "mV"'),
            "columns.F.unit: found 'mV'; expected 'V'",
        ),
    ],
)
def test_wrong_profiles_are_refused_with_their_key(made, written, message):
    assert message in refusal(made, written)


def test_no_such_profile(tmp_path):
    with pytest.raises(ManifestError, match="no such file"):
        described_reader(tmp_path / "rig.toml")


# --- in a run ---


def test_a_run_names_the_profile_of_the_example(tmp_path):
    run = 'schema = "tribopipe.run/1"\nid = "r7"\n[conditions]\nnormal_load = "5 N"\nsliding_speed = "100 mm/s"\n'
    for name, written in (("run.toml", run + MANIFEST), ("our-rig.toml", PROFILE), ("test_07.txt", EXPORT.decode())):
        (tmp_path / name).write_text(written, encoding="utf-8")
    found = read_run(tmp_path)
    assert found.columns["friction_force"][1] == pytest.approx(1.02)
    assert found.columns["depth"] == pytest.approx([-102.5e-6, -102.4e-6, -102.1e-6])
    assert found.extras["Ft"].values.tolist() == [0.012, 0.512, 0.514]
    assert [source.name for source in found.sources] == ["run.toml", "our-rig.toml", "test_07.txt"]


# --- profiles, and decimal commas in quotation marks ---

QUOTED = b'"Lateral","Height"\n' + b"".join(b'"0,%05d","0,%02d"\n' % (50 * n, n % 7) for n in range(1, 40))


def test_a_described_reader_of_profiles_is_named_in_run_toml(sample_run):
    (sample_run / "stylus.toml").write_text(
        HEAD.replace("Rig", "Stylus")
        + 'holds = "profile"\nseparator = ","\ndecimal = ","\nheader_lines = 0\n[columns]\n'
        'Lateral = { axis = "x", unit = "mm" }\nHeight = { axis = "z", unit = "um" }\n',
        encoding="utf-8",
    )
    (sample_run / "track.csv").write_bytes(QUOTED)
    manifest = sample_run / "run.toml"
    text = manifest.read_text(encoding="utf-8")
    profile = '[end_values]\ndisc_profile = { file = "track.csv", reader = "stylus.toml" }\n'
    manifest.write_text(text.replace("[end_values]\n", profile), encoding="utf-8")
    run = read_run(sample_run)
    profile = run.profiles["end_values.disc_profile"]
    assert profile.position[:2] == pytest.approx([5e-7, 1e-6], rel=1e-12)
    assert profile.height[:7] == pytest.approx(np.array([1, 2, 3, 4, 5, 6, 0]) * 1e-8, rel=1e-12)
    assert {"stylus.toml", "track.csv"} <= {source.name for source in run.sources}


def test_a_described_reader_of_profiles_that_is_not_there(sample_run):
    manifest = sample_run / "run.toml"
    text = manifest.read_text(encoding="utf-8")
    profile = '[end_values]\ndisc_profile = { file = "signals.csv", reader = "stylus.toml" }\n'
    manifest.write_text(text.replace("[end_values]\n", profile), encoding="utf-8")
    with pytest.raises(ReaderError, match=r"stylus.toml: no such file; expected the description of a reader"):
        read_run(sample_run)


@pytest.mark.parametrize("decimal", ['decimal = ","\n', ""])
def test_quoted_decimal_commas_between_commas(made, decimal):
    reader = made(f'separator = ","\nheader_lines = 0\n{decimal}' + LEAST)
    table = read(reader, b'"t","V"\n"0,00050","0,03"\n"0,00100","-1"\n')
    assert [column.values.tolist() for column in table.columns] == [[0.0005, 0.001], [0.03, -1.0]]

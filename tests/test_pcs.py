"""Test data files of PCS Instruments: tables inside steps, steps without tables, and files that are no tests."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from read_tables import column, read_or_refused, values

from tribopipe.base.errors import ReaderError
from tribopipe.readers.delimited import DelimitedReader
from tribopipe.readers.formats.pcs import PcsReader
from tribopipe.readers.reader import Hints, Reader, ReadTable
from tribopipe.results.run import SourceFile

READER = PcsReader()
REAL_DATA = Path(__file__).resolve().parents[2] / "shared" / "realdata" / "pcs-ehd-labview" / "examples" / "data_import"
NAMES = ["Step Time (s)", "Rolling Speed (mm/s)", "", "Lube Temp (°C)", "Ball Load (N)", "Sliding Speed (mm/s)"]
NAMES += ["Rolling Speed (mm/s)", "Traction Force (N)", "Traction Coeff (-)", "Ball Speed 2", ""]
STEPS = [
    [
        ["10", "20.2", "", "40.4", "20.025", "10.10", "20.21", "0.7975", "0.0398", "", ""],
        ["18", "25.3", "", "40.4", "19.994", "12.65", "25.32", "0.8714", "0.0436", "", ""],
        ["25", "31.8", "", "40.3", "20.038", "15.90", "31.84", "0.8415", "0.0420", "", ""],
    ],
    [
        ["10", "20.2", "", "99.9", "20.011", "10.10", "20.22", "0.6003", "0.0300", "", ""],
        ["17", "25.3", "", "100.1", "20.005", "12.65", "25.30", "0.5871", "0.0293", "", ""],
    ],
]
NAMED = [number for number, name in enumerate(NAMES) if name]
TRUTH = np.array(
    [
        [*(float(row[number] or "nan") for number in NAMED), segment]
        for segment, rows in enumerate(STEPS, 1)
        for row in rows
    ]
)


def write(steps: list[list[list[str]]] = STEPS, names: list[str] = NAMES, end: str = "\r\n") -> bytes:
    lines = ["MTM2 Test Data File", "Profile description:\tStribeck", "Disc track radius:\t20.5"]
    lines += ["Lubricant name:\tPAO 6", "Comments:", "", "Number of steps in profile:\t4"]
    lines += ["Test started at 03/02/2017 15:47", ""]
    for number, rows in enumerate(steps):
        lines += [
            f'Step {2 * number + 1} "Zero" started at 03/02/2017 15:48',
            "Step type\tZERO\tStep description\tZero",
        ]
        lines += ["       Ball load = 19.9 N", "Trigger position = 233", ""]
        lines += [f'Step {2 * number + 2} "Curve {number}" started at 03/02/2017 16:09']
        lines += ["Step type\tTRACTION\tStep description\tCurve", "\t".join(names)]
        lines += ["\t".join(row) for row in rows] + [""]
    lines += ["All steps completed, test completed normally at 13/02/2017 16:35"]
    return "".join(line + end for line in lines).encode()


SMALL = write()


def read(content: bytes, **hints: str) -> ReadTable:
    return READER.read(SourceFile("test.txt", content), Hints(**hints))


def test_small_file():
    assert isinstance(READER, Reader)
    table = read(SMALL)
    assert [(each.name, each.signal, each.unit) for each in table.columns] == [
        ("Step Time (s)", "time", "s"),
        ("Rolling Speed (mm/s)", None, "mm/s"),
        ("Lube Temp (°C)", "temperature", "°C"),
        ("Ball Load (N)", "normal_force", "N"),
        ("Sliding Speed (mm/s)", "sliding_speed", "mm/s"),
        ("Rolling Speed (mm/s) (2)", None, "mm/s"),
        ("Traction Force (N)", "friction_force", "N"),
        ("Traction Coeff (-)", "friction_coefficient", "-"),
        ("Ball Speed 2", None, None),
        ("segment", None, "1"),
    ]
    assert np.array_equal(values(table), TRUTH, equal_nan=True)
    assert "segments are the tables of step 2 'Curve 0', step 4 'Curve 1'" in table.notes
    assert table.header.startswith("MTM2 Test Data File\r\n")
    assert "Ball load = 19.9 N\r\n" in table.header
    assert "20.025" not in table.header


def test_facts():
    assert read(SMALL).facts == {
        "instrument": "PCS Instruments MTM2",
        "title": "Stribeck",
        "conditions.medium": "PAO 6",
        "conditions.track_radius": "20.5 mm",
        "started": "2017-02-03T15:47:00",
    }


@pytest.mark.parametrize(
    ("written", "started"),
    [
        (b"2/13/2017 3:35 PM", "2017-03-02T15:47:00"),
        (b"13.02.2017 16:35:10", "2017-02-03T15:47:00"),
        (b"12/02/2017 16:35", None),
    ],
)
def test_order_of_day_and_month_is_not_guessed(written, started):
    table = read(SMALL.replace(b"13/02/2017 16:35", written))
    assert table.facts.get("started") == started
    assert any("order of day and month is ambiguous" in note for note in table.notes) == (started is None)


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r", "\r\r\n"])
def test_line_ends(end):
    assert np.array_equal(values(read(write(end=end))), TRUTH, equal_nan=True)


@settings(max_examples=40, deadline=None)
@given(st.permutations(range(len(NAMES))))
def test_columns_in_any_order(order):
    # The first field of a row is a number, the last one is empty.
    order = [0, *(n for n in order if n not in (0, 10)), 10]
    table = read(write([[[row[n] for n in order] for row in rows] for rows in STEPS], [NAMES[n] for n in order]))
    for name in ("Step Time (s)", "Ball Load (N)", "Traction Coeff (-)"):
        assert np.array_equal(column(table, name).values, TRUTH[:, NAMED.index(NAMES.index(name))])
        assert column(table, name).signal


def test_an_empty_channel_has_no_meaning():
    steps = [[[*row[:7], "", *row[8:]] for row in rows] for rows in STEPS]
    force = column(read(write(steps)), "Traction Force (N)")
    assert force.signal is None
    assert np.isnan(force.values).all()


def test_names_of_images_are_kept():
    names = [*NAMES[:9], "Image file name", ""]
    steps = [[[*row[:9], f"im{n}.bmp", ""] for n, row in enumerate(rows)] for rows in STEPS]
    assert column(read(write(steps, names)), "Image file name").values.tolist()[:2] == ["im0.bmp", "im1.bmp"]


def test_latin_degrees():
    content = SMALL.decode().encode("cp1252")
    table = read(content)
    assert column(table, "Lube Temp (°C)").unit == "°C"
    assert "cp1252" in table.notes[0]


def test_row_with_too_few_fields_is_named():
    with pytest.raises(ReaderError, match=r"line 19: found \d+ fields, expected"):
        read(SMALL.replace(b"18\t25.3\t\t40.4\t", b"18\t"))


def test_a_quotation_mark_and_a_long_word_before_a_last_row_are_refused():
    row = "\t".join(STEPS[0][-1]).encode()
    with pytest.raises(ReaderError, match=r"^test\.txt, line 20: found a field of more than 131,072 characters"):
        read(SMALL.replace(row, b'"' + b"x" * 140_000 + row))


def test_numbers_without_names_are_refused():
    names = "\t".join(NAMES).encode() + b"\r\n"
    with pytest.raises(ReaderError, match=r"line 17: found data with no header line"):
        read(SMALL.replace(names, b"", 1))


@pytest.mark.slow
def test_cut_anywhere():
    for size in range(0, len(SMALL) - 70, 3):  # the line that closes the test has 68 bytes
        try:
            table = read(SMALL[:size])
        except ReaderError as error:
            assert str(error).startswith("test.txt")  # noqa: PT017
            continue
        found = values(table)
        width = found.shape[1]
        assert width in (len(NAMED), len(NAMED) + 1)
        assert np.array_equal(found, TRUTH[: len(found)], equal_nan=True), size
        assert any("no line states" in note for note in table.notes)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, len(SMALL) - 1), st.binary(max_size=4))
def test_whatever_bytes_are_put_in_nothing_but_reader_errors_is_raised(at, put):
    read_or_refused(READER, "test.txt", SMALL[:at] + put + SMALL[at:])


@pytest.mark.parametrize(
    "content",
    [b"", b" \r\n\t\r\n", b"\0\1", write([]), SMALL[: SMALL.index(b"10\t")], b"1\t2\n3\t4\n", b"Time\tFz\n1\t2\n"],
)
def test_no_table(content):
    with pytest.raises(ReaderError, match=r"^test\.txt"):
        read(content)


def test_colours_of_a_spacer_layer_are_refused_by_name():
    source = SourceFile("map.txt", b"Mapper Spacer Calibration File\r\nFilm\tR\tG\tB\r\n-10\t35\t64\t171\r\n")
    match = READER.match(source)
    assert match.confidence == 0.0
    assert "Mapper Spacer Calibration File" in match.why
    with pytest.raises(ReaderError, match=r"found 'Mapper Spacer Calibration File'; .*no test data"):
        READER.read(source, Hints())


@pytest.mark.parametrize("size", [60, 400, len(SMALL)])
def test_found_by_content(size):
    source = SourceFile("x.csv", SMALL[:size])
    assert READER.match(source).confidence > max(0.9, DelimitedReader().match(source).confidence)


@pytest.mark.parametrize("content", [b"", b"\0\1\2", b"Time\tFz\n1\t2\n", b"My Test Data File\nTime\tFz\n1\t2\n"])
def test_other_files_are_left_alone(content):
    assert READER.match(SourceFile("x.txt", content)).confidence < 0.5


def unnamed(content: bytes) -> bytes:
    """Write the steps as the software of the MTM does: without their names, which the line below tells."""
    lines = content.decode().split("\r\n")
    named = {number: line.split('"') for number, line in enumerate(lines) if line.startswith("Step ") and '"' in line}
    for number, (step, name, started) in named.items():
        lines[number] = step.rstrip() + started
        lines[number + 1] = f"Step type\tPOD_TIMED\tStep description\t{name}\tStep duration\t02:05:00"
        lines[number + 1] += "\r\nDisc track radius used for this step (mm)\t21.232"
    return "\r\n".join(line for line in lines if not line.startswith("Disc track radius:")).encode()


def test_steps_without_names_in_their_first_line():
    table = read(unnamed(SMALL))
    assert np.array_equal(values(table), TRUTH, equal_nan=True)
    assert "segments are the tables of step 2 'Curve 0', step 4 'Curve 1'" in table.notes
    assert table.facts["conditions.track_radius"] == "21.232 mm"
    assert not any("is assumed to be in mm" in note for note in table.notes)


def test_track_radii_that_differ_from_step_to_step_are_told():
    table = read(unnamed(SMALL).replace(b"21.232", b"20.0", 1))
    assert "conditions.track_radius" not in table.facts
    assert any("track radius" in note and "20.0" in note and "21.232" in note for note in table.notes)


def test_file_that_begins_with_its_first_step():
    content = unnamed(SMALL)
    content = content[content.index(b"Step 1") :]
    assert READER.match(SourceFile("x.txt", content)).confidence >= 0.9
    table = read(content)
    assert np.array_equal(values(table), TRUTH, equal_nan=True)
    assert table.facts == {"instrument": "PCS Instruments", "conditions.track_radius": "21.232 mm"}


def test_many_steps_are_not_listed_one_by_one():
    table = read(write([STEPS[0]] * 9))
    assert any("step 8 'Curve 3', and 5 more" in note for note in table.notes)


def test_load_of_a_pin_where_no_ball_is_loaded():
    names = [*NAMES[:-1], "Pin Load (N)"]
    on_pin = [[*row[:4], "", *row[5:-1], "11.8"] for row in STEPS[0]]
    assert column(read(write([on_pin], names)), "Pin Load (N)").signal == "normal_force"
    on_ball = [[*row[:-1], "0.1"] for row in STEPS[0]]
    table = read(write([on_ball], names))
    assert column(table, "Ball Load (N)").signal == "normal_force"
    assert column(table, "Pin Load (N)").signal is None


def test_temperature_of_the_lubricant_by_its_longer_name():
    names = [{"Lube Temp (°C)": "Lube RTD Temp (degC)"}.get(name, name) for name in NAMES]
    found = column(read(write(STEPS, names)), "Lube RTD Temp (degC)")
    assert (found.signal, found.unit) == ("temperature", "degC")


def test_colours_of_a_film_are_refused_by_name():
    source = SourceFile("map.txt", b"SLIM Mapper Analysis File\r\nSelection type:\tCircle\r\nX\tY\tR\r\n1\t2\t3\r\n")
    match = READER.match(source)
    assert (match.confidence, match.known_as) == (0.0, "a 'SLIM Mapper Analysis File'")


def _real(name: str) -> SourceFile:
    path = REAL_DATA / name
    if not path.is_file():
        pytest.skip(f"real data not here: {name}")
    return SourceFile(path.name, path.read_bytes())


def test_real_test_of_an_ehd_rig():
    source = _real("demo_3.txt")
    assert READER.match(source).confidence >= 0.9
    table = READER.read(source, Hints())
    assert np.bincount(column(table, "segment").values.astype(int)).tolist() == [0, 21, 21]
    load, time = column(table, "Ball Load (N)"), column(table, "Step Time (s)")
    assert (load.signal, load.unit, time.signal, time.unit) == ("normal_force", "N", "time", "s")
    assert load.values.min() > 19.8
    assert load.values.max() < 20.2
    assert (time.values[0], time.values[20], time.values[-1]) == (10, 127, 129)
    assert column(table, "Lube Temp (°C)").values[[0, -1]].tolist() == [40.4, 99.3]
    assert column(table, "Traction Coeff (-)").signal is None
    assert table.facts["started"] == "2017-02-28T15:47:00"
    assert table.facts["conditions.track_radius"] == "36.273 mm"


def test_real_colours_of_a_spacer_layer_are_no_test():
    source = _real("demo_4.txt")
    assert READER.match(source).confidence == 0.0
    with pytest.raises(ReaderError, match="Mapper Spacer Calibration File"):
        READER.read(source, Hints())

"""Frames of a load-cell indicator: bytes or names of control characters, a motion flag, and no time."""

from pathlib import Path

import numpy as np
import pytest
from hanging import ends_soon
from hypothesis import given, settings
from hypothesis import strategies as st
from small_exports import FRAMES, check_every_cut, claimed_by, read

from tribopipe.base.errors import ReaderError
from tribopipe.readers.delimited import DelimitedReader
from tribopipe.readers.formats.serial_frames import SerialFramesReader
from tribopipe.readers.reader import Hints, Reader
from tribopipe.results.run import SourceFile

READER = SerialFramesReader()
REAL_FILE = Path(__file__).resolve().parents[2] / "shared" / "realdata" / "pinondiskapp-es" / "data" / "celda_sim.csv"
NO_TIME = (
    "found frames without time stamps; expected a time or sliding distance for each frame; map time or sliding "
    "distance from a file with one row per frame"
)


def test_is_a_reader_and_claims_its_files_alone():
    assert isinstance(READER, Reader)
    assert claimed_by(READER) == ["load-cell-frames"]


@pytest.mark.parametrize("start", [b"<STX>", b"\x02"])
@pytest.mark.parametrize("end", [b"<CR><LF>\n", b"<CR><LF>", b"\r\n", b"\r", b"<CR><LF>\r\n"])
def test_small_file(start, end):
    content = FRAMES.replace(b"<STX>", start).replace(b"<CR><LF>\n", end)
    assert READER.match(SourceFile("x", content)).confidence >= 0.9
    table = read(READER, content)
    assert [(column.name, column.unit, column.signal) for column in table.columns] == [
        ("load", "kgf", None),
        ("motion", "1", None),
    ]
    assert table.columns[0].values.tolist() == [0.0, 0.072, -0.458]
    assert table.columns[1].values.tolist() == [0.0, 1.0, 1.0]


@pytest.mark.parametrize(("unit", "read_as"), [("G ", "gf"), ("kgM", "kgf"), ("LB ", "lbf"), ("N", "N")])
def test_units(unit, read_as):
    table = read(READER, f"\x02  -1,25{unit}\r\n".encode())
    assert (table.columns[0].unit, table.columns[0].values.tolist()) == (read_as, [-1.25])


@settings(max_examples=50, deadline=None)
@given(st.lists(st.tuples(st.integers(-99999, 99999), st.booleans()), min_size=1, max_size=30), st.data())
def test_written_frames_come_back_exactly_and_cut_ones_do_not(frames, data):
    written = [f"\x02{number / 1000:8.3f}KG{'M' if moves else ' '}\r\n".encode() for number, moves in frames]
    content = b"".join(written)
    table = read(READER, content)
    assert table.columns[0].values.tolist() == [number / 1000 for number, _ in frames]
    assert table.columns[1].values.tolist() == [float(moves) for _, moves in frames]
    assert table.notes == (NO_TIME,)
    cut = content[: data.draw(st.integers(0, len(content)))]
    if cut.count(b"\n"):
        assert (
            read(READER, cut).columns[0].values.tolist()[: cut.count(b"\n")]
            == table.columns[0].values.tolist()[: cut.count(b"\n")]
        )


def test_cut_anywhere_it_is_right_or_refused():
    check_every_cut(READER, FRAMES, ends=(b"\r", b"\n", b"<CR>", b"<LF>"))


def test_broken_frames_are_missing_samples_with_a_count():
    table = read(READER, FRAMES + b"<STX>   0.0\x00<CR><LF>\n" + FRAMES)
    assert np.isnan(table.columns[0].values).tolist() == [False, False, False, True, False, False, False]
    assert table.notes == (
        "1 of 7 frames are corrupted and treated as missing samples; the first is frame 4: '0.0\\x00<CR><LF>'",
        NO_TIME,
    )


def test_what_stands_before_the_first_frame_is_the_header():
    assert read(READER, b"\xef\xbb\xbf" + FRAMES).columns[0].values.tolist() == [0.0, 0.072, -0.458]
    assert read(READER, b"COM3 9600 8N1\r\n072KG <CR><LF>\n" + FRAMES).header == "COM3 9600 8N1\r\n072KG <CR><LF>\n"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "no complete frame"),
        (b"   0.072KGM\r\n   0.073KGM\r\n", "no complete frame"),
        (FRAMES[:12], "no complete frame"),
        (FRAMES + b"<STX>   0.072N <CR><LF>", "frames in KG and N"),
        (FRAMES.decode().encode("utf-16"), "no complete frame"),
        (b"Time;Force\n1;2\n", "no complete frame"),
    ],
)
def test_other_files_are_refused(content, message):
    with pytest.raises(ReaderError, match=rf"^test\.txt: found {message}"):
        read(READER, content)
    assert READER.match(SourceFile("x", content[:2000])).confidence < 0.5 or content.startswith(FRAMES)


def test_one_endless_line_is_refused_at_once():
    with ends_soon(), pytest.raises(ReaderError, match="no complete frame"):
        read(READER, b"<STX>" + b"7" * 30_000_000)


def test_real_file():
    if not REAL_FILE.is_file():
        pytest.skip("real data not here: pinondiskapp-es")
    source = SourceFile("celda_sim.csv", REAL_FILE.read_bytes())
    assert READER.match(source).confidence > 0.9 > DelimitedReader().match(source).confidence
    table = READER.read(source, Hints())
    load, motion = (column.values for column in table.columns)
    assert (len(load), load.min(), load.max()) == (13_439, 0.0, 0.458)
    assert (np.count_nonzero(motion == 0), np.count_nonzero(motion == 1)) == (4348, 9091)
    assert table.notes == (NO_TIME,)

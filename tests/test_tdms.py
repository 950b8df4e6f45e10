"""TDMS files: channels as columns, time from waveforms, groups as segments; damaged ones refused or flagged."""

import struct
import sys
from contextlib import suppress

import numpy as np
import pytest
from built_files import tdms
from hypothesis import given, settings
from hypothesis import strategies as st

from tribopipe.base.errors import ReaderError
from tribopipe.readers.formats.tdms import TdmsReader
from tribopipe.readers.reader import Hints, ReadTable
from tribopipe.results.run import SourceFile

READER = TdmsReader()
START = np.datetime64("2022-05-12T12:21:58")
WAVE = {"wf_increment": 0.1, "wf_start_offset": 0.0, "wf_start_time": START}
FORCE = (np.arange(5) + 0.25, WAVE | {"unit_string": "N"})
COUNT = (np.arange(5, dtype="i2"), {"NI_UnitDescription": "Deg C"})
SMALL = tdms({"Test": {"Fz": FORCE, "Heat": COUNT}}, author="N. N.", title="Run 5", description="dry")


def read(content: bytes) -> ReadTable:
    return READER.read(SourceFile("run.tdms", content), Hints())


def columns(table: ReadTable) -> dict[str, list]:
    return {column.name: column.values.tolist() for column in table.columns}


def test_channels_time_and_facts():
    table = read(SMALL)
    assert [(column.name, column.unit, column.signal) for column in table.columns] == [
        ("Time", "s", "time"),
        ("Fz", "N", None),
        ("Heat", "degC", None),
    ]
    found = columns(table)
    assert found["Time"] == pytest.approx([0, 0.1, 0.2, 0.3, 0.4], abs=1e-15)
    assert found["Fz"] == [0.25, 1.25, 2.25, 3.25, 4.25]
    assert found["Heat"] == [0, 1, 2, 3, 4]
    assert table.facts == {
        "operator": "N. N.",
        "title": "Run 5",
        "comment": "dry",
        "started": "2022-05-12T12:21:58+00:00",
    }
    assert "/'Test'/'Fz' unit_string = N\n" in table.header
    assert table.notes == ()


def test_segments_written_one_by_one_are_one_table():
    groups = {"Test": {"Fz": FORCE, "Heat": COUNT}}
    assert len(read(tdms(groups, groups, groups)).columns[0].values) == 15


def test_groups_of_the_same_channels_are_segments():
    table = read(tdms({"Stroke 1": {"Fz": FORCE}, "Stroke 2": {"Fz": (np.array([7.0]), FORCE[1])}}))
    found = columns(table)
    assert found["Fz"] == [0.25, 1.25, 2.25, 3.25, 4.25, 7.0]
    assert found["segment"] == [1, 1, 1, 1, 1, 2]
    assert found["Time"][-1] == 0


def test_segments_keep_the_order_of_the_file():
    forces = {f"Stroke {number}": {"Fz": (np.array([number, -1.0]), WAVE)} for number in (1, 2, 10)}
    assert columns(read(tdms(forces)))["Fz"][::2] == [1, 2, 10]


def test_different_groups_are_refused_by_name():
    with pytest.raises(ReaderError, match=r"run\.tdms: found different tables in the groups 'Slow' .* and 'Fast'"):
        read(tdms({"Slow": {"Fz": FORCE, "T": COUNT}, "Fast": {"Fx": FORCE, "Fy": COUNT}}))


def test_a_group_of_settings_is_left_out_with_a_note():
    table = read(tdms({"Settings": {"Load": (np.array([5.0]), {})}, "Test": {"Fz": FORCE}}))
    assert [column.name for column in table.columns] == ["Time", "Fz"]
    assert table.notes == ("group 'Settings' contains no test data and is omitted",)


def test_a_channel_of_time_stamps_is_the_time():
    stamps = START + np.array([0, 1500, 2250], dtype="m8[ms]")
    table = read(tdms({"Test": {"Clock": (stamps.astype("M8[us]"), {}), "Fz": (np.arange(3.0), WAVE)}}))
    clock = table.columns[0]
    assert (clock.name, clock.unit, clock.signal, clock.values.tolist()) == ("Clock", "s", "time", [0, 1.5, 2.25])
    assert [column.name for column in table.columns] == ["Clock", "Fz"]
    assert table.notes == (
        "channel 'Clock' contains dates; they are converted to seconds since 2022-05-12T12:21:58 UTC",
    )


def test_a_channel_called_time_wins_over_the_waveform():
    found = columns(
        read(tdms({"Test": {"Time [s]": (np.array([5.0, 6.0]), WAVE), "Fz": (np.array([1.0, 2.0]), WAVE)}}))
    )
    assert found == {"Time [s]": [5, 6], "Fz": [1, 2]}


def test_texts_are_kept():
    state = read(tdms({"Test": {"Fz": (np.array([1.0, 2.0]), WAVE), "State": (["on", "off"], {})}})).columns[-1]
    assert state.values.tolist() == ["on", "off"]
    assert state.first_bad == (1, "on")


def test_an_unknown_unit_is_noted():
    table = read(tdms({"Test": {"Fz": (np.array([1.0, 2.0]), WAVE | {"unit_string": "clicks!"})}}))
    assert table.columns[1].unit is None
    assert table.notes == ("channel 'Fz' has the unknown unit 'clicks!'; specify its unit in run.toml",)


def test_unit_in_the_name():
    assert read(tdms({"Test": {"Fz [mN]": (np.array([1.0, 2.0]), {})}})).columns[0].unit == "mN"


def test_a_start_that_was_never_set_is_no_fact():
    said = WAVE | {"wf_start_time": np.datetime64("1904-01-01T00:00:00")}
    assert read(tdms({"Test": {"Fz": (np.array([1.0, 2.0]), said)}})).facts == {}


def test_channels_of_different_length_or_rate_are_refused():
    with pytest.raises(ReaderError, match="found 2 samples of 'B' and 3 of 'A' in the group 'T'"):
        read(tdms({"T": {"A": (np.arange(3.0), {}), "B": (np.arange(2.0), {})}}))
    with pytest.raises(ReaderError, match="different sampling intervals in the channels 'A' and 'B'"):
        read(tdms({"T": {"A": (np.arange(3.0), WAVE), "B": (np.arange(3.0), WAVE | {"wf_increment": 0.2})}}))


def test_interrupted_file_is_read_as_far_as_it_goes():
    groups = {"Test": {"Fz": FORCE, "Heat": COUNT}}
    content = bytearray(tdms(groups, groups))
    second = content.index(b"TDSm", 4)
    content[second + 12 : second + 20] = b"\xff" * 8
    table = read(bytes(content[:-3]))
    assert columns(table)["Heat"] == [0, 1, 2, 3, 4, 0, 1, 2]
    assert columns(table)["Fz"] == [0.25, 1.25, 2.25, 3.25, 4.25, 0.25, 1.25, 2.25]
    assert "stopped before the file was complete" in table.notes[0]


CUT = tdms({"Test": {"Fz": FORCE, "Heat": COUNT}}, {"Test": {"Fz": FORCE, "Heat": COUNT}})


@pytest.mark.slow
def test_cut_anywhere_it_is_refused_or_flagged():
    whole = columns(read(CUT))
    edge = CUT.index(b"TDSm", 4)
    for size in range(len(CUT)):
        try:
            table = read(CUT[:size])
        except ReaderError:
            continue
        assert table.notes or size == edge
        for name, values in columns(table).items():
            assert values == whole[name][: len(values)]


@settings(max_examples=60, deadline=None)
@given(st.integers(0, len(CUT) - 1), st.integers(0, 255))
def test_a_byte_changed_raises_nothing_else(place, byte):
    content = bytearray(CUT)
    content[place] = byte
    source = SourceFile("run.tdms", bytes(content))
    READER.match(source)
    with suppress(ReaderError):
        read(source.content)


def test_broken_chain_and_boasting_channels_are_refused():
    with pytest.raises(ReaderError, match="found no segment at byte"):
        read(SMALL + bytes(40))
    boast = SMALL.replace(struct.pack("<IQ", 1, 5), struct.pack("<IQ", 1, 5 << 40), 1)
    assert boast != SMALL
    with pytest.raises(ReaderError, match="the channels contain 48 bytes in total, but the segments 50"):
        read(boast)


def test_channels_that_are_no_numbers_are_left_out():
    wave = (np.array([1 + 2j, 3 + 4j]), {})
    table = read(tdms({"Test": {"Impedance": wave, "Fz": (np.array([1.0, 2.0]), {})}}))
    assert [column.name for column in table.columns] == ["Fz"]
    assert table.notes == ("channel 'Impedance' contains neither numbers nor text and is omitted",)
    with pytest.raises(ReaderError, match="found no samples in any channel"):
        read(tdms({"Test": {"Impedance": wave}}))


def test_nothing_in_it():
    with pytest.raises(ReaderError, match="found no samples in any channel"):
        read(tdms({"Test": {"Fz": (np.array([]), {})}}))


def test_match_by_the_magic_alone(monkeypatch):
    monkeypatch.setitem(sys.modules, "nptdms", None)
    assert READER.match(SourceFile("run.csv", SMALL)).confidence >= 0.9
    for content in (b"", b"TDS", b"TDSh", b"Time;Fz\n1;2\n"):
        assert READER.match(SourceFile("run.tdms", content)).confidence == 0
    with pytest.raises(ReaderError, match=r'npTDMS is not installed.*pip install "tribopipe\[tdms\]"'):
        read(SMALL)

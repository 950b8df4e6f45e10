"""Anton Paar and CSM tribometers: TRB³, nano, and old exports trimmed to five columns."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_exports import TRB3, TRIMMED, check_cut, check_every_cut, claimed_by, read

from tribopipe.base.errors import ReaderError
from tribopipe.readers.delimited import DelimitedReader
from tribopipe.readers.formats.anton_paar import AntonPaarReader
from tribopipe.readers.reader import Reader, ReadTable
from tribopipe.results.run import SourceFile

READER = AntonPaarReader()
NANO = (
    "Nano Tribometer\r\nLinear mode\r\nDate: 2021-11-04\r\nTime: 9:05:07\r\nRadius: 5.00 [mm]\r\n"
    "Normal load\t50,0 [mN]\r\n"
    "Temperature: 23.0 [°C]\r\nHumidity: 41 %\r\nAtmosphere: Air\r\nOperator: B. Example\r\n\r\n"
    "Time [s]\tDistance [m]\tlaps\tSequence ID\tCycle ID\tMax linear speed [m/s]\tNominal Load [mN]\tµ\t"
    "Linear Position [mm]\tNormal force [mN]\tFriction force [mN]\tPenetration depth [µm]\r\n"
    "0.01\t0.0001\t0.5\t1\t1\t0.01\t50\t0.2\t-0.5\t49.8\t9.96\t0.1\r\n"
    "0.02\t0.0002\t1\t1\t2\t0.01\t50\t-0.21\t0.5\t50.1\t-10.5\t0.2\r\n"
)


def meanings(table: ReadTable) -> dict[str, tuple[str | None, str | None]]:
    return {column.name: (column.unit, column.signal) for column in table.columns}


def values(table: ReadTable) -> list[list[float]]:
    return [column.values.tolist() for column in table.columns]


def test_is_a_reader_and_claims_its_files_alone():
    assert isinstance(READER, Reader)
    assert claimed_by(READER) == ["anton-paar", "anton-paar, trimmed"]


def test_trb3():
    table = read(READER, TRB3)
    assert meanings(table) == {
        "Time [s]": ("s", "time"),
        "Distance [m]": ("m", "sliding_distance"),
        "Laps": ("1", None),
        "Sequence ID": (None, None),
        "Cycle ID": (None, None),
        "Max Linear Speed [m/s]": ("m/s", None),
        "Nominal Load [N]": ("N", None),
        "µ": ("1", "friction_coefficient"),
        "Angle [°]": ("°", None),
        "Friction Force [N]": ("N", "friction_force"),
        "Temperature [°C]": ("°C", "temperature"),
        "Humidity [%]": ("%", "relative_humidity"),
        "Penetration Depth [µm]": ("µm", "depth"),
    }
    assert table.columns[7].values.tolist() == [0.1532, 0.1611, 0.17]
    assert table.columns[11].values.tolist() == [44.0, 44.1, -1064.6]
    assert table.columns[12].values.tolist() == [0.012, -0.5, 1.125]
    assert table.facts == {"conditions.normal_load": "5 N", "conditions.sliding_speed": "0.1 m/s"}
    assert table.notes == ()


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "cp1252"])
@pytest.mark.parametrize("end", ["\n", "\r", "\r\n"])
@pytest.mark.parametrize("decimal", [".", ","])
def test_dialects(encoding, end, decimal):
    content = TRB3.decode("utf-8-sig").replace("\r\n", end).replace(".", decimal).encode(encoding)
    assert READER.match(SourceFile("x", content)).confidence >= 0.9
    table = read(READER, content)
    assert values(table) == values(read(READER, TRB3))
    assert meanings(table) == meanings(read(READER, TRB3))


def test_nano_in_linear_mode_with_settings_above():
    table = read(READER, NANO.encode())
    assert meanings(table)["Normal force [mN]"] == ("mN", "normal_force")
    assert meanings(table)["Friction force [mN]"] == ("mN", "friction_force")
    assert meanings(table)["Nominal Load [mN]"] == ("mN", None)
    assert values(table)[10] == [9.96, -10.5]
    assert table.header.startswith("Nano Tribometer\r\nLinear mode")
    assert table.facts == {  # neither radius nor speed: the pin does not run in a circle
        "started": "2021-11-04T09:05:07",
        "instrument": "Anton Paar Nano Tribometer",
        "conditions.normal_load": "50 mN",
        "conditions.temperature": "23.0 °C",
        "conditions.relative_humidity": "41 %",
        "conditions.medium": "Air",
        "operator": "B. Example",
    }


def test_old_export_trimmed_to_five_columns():
    table = read(READER, TRIMMED)
    assert meanings(table) == {
        "Time": ("s", "time"),
        "Distance": ("m", "sliding_distance"),
        "Laps": ("1", None),
        "mu": ("1", "friction_coefficient"),
        "FrictionForce": (None, "friction_force"),
    }
    assert values(table) == [
        [0.05, 0.15, 1.0],
        [0.001, 0.002, 0.012],
        [0.0, 0.01, 0.02],
        [0.153, 0.16, -0.171],
        [0.765, 0.8, -0.8554],
    ]
    assert table.notes == (
        "the file contains no units; the usual units of these tribometers are assumed: Time in s, Distance in m",
        "'FrictionForce' may be in N or mN; map it with its unit in run.toml",
    )
    assert table.facts == {}


@pytest.mark.parametrize(
    ("sign", "lost"), [("µ", "?"), ("µ", "\ufffd"), ("°", "?"), ("µ", "Âµ"), ("°", "Â°"), ("µ", "μ")]
)
def test_signs_lost_or_decoded_twice(sign, lost):
    written = TRB3.decode("utf-8-sig").replace(sign, lost)
    table = read(READER, written.encode())
    found = [(column.unit, column.signal) for column in table.columns]
    assert found[7] == ("1", "friction_coefficient")
    assert (found[8][0], found[10][0]) in {("°", "°C"), ("deg", "degC")}
    assert found[12][0] in {"µm", "um", "μm"}
    assert [signal for _, signal in found] == [column.signal for column in read(READER, TRB3).columns]


def test_several_loads_are_no_fact():
    table = read(READER, TRB3.replace(b"0.1\t5\t0.17", b"0.1\t10\t0.17"))
    assert "conditions.normal_load" not in table.facts
    assert table.notes == ("the nominal load has 2 values from 5 to 10",)


def test_settings_that_contradict_each_other_are_no_facts():
    settings = b"Normal load: 5 [N]\r\nNormal load: 10 [N]\r\nTemperature: warm\r\nDate: 04/11/2021\r\n"
    table = read(READER, settings + TRIMMED)
    assert table.facts == {}
    assert table.header.startswith("Normal load")


@settings(max_examples=25, deadline=None)
@given(st.permutations(range(13)), st.lists(st.integers(-(10**6), 10**6), min_size=13, max_size=13))
def test_columns_in_any_order(order, numbers):
    names = TRB3.decode("utf-8-sig").partition("\r\n")[0].split("\t")
    rows = [[names[at] for at in order], [f"{numbers[at] / 1000:.3f}" for at in order]]
    table = read(READER, "".join("\t".join(row) + "\r\n" for row in rows).encode())
    expected = meanings(read(READER, TRB3))
    assert meanings(table) == expected
    assert {column.name: column.values.tolist() for column in table.columns} == {
        name: [number / 1000] for name, number in zip(names, numbers, strict=True)
    }


@pytest.mark.slow
def test_cut_anywhere_it_is_right_or_refused():
    check_every_cut(READER, TRIMMED)
    for size in range(3, len(TRB3), 5):
        check_cut(READER, TRB3, size)


def test_a_cut_file_is_not_left_to_another_reader():
    for size in range(TRB3.index(b"\n") + 40, len(TRB3), 11):
        source = SourceFile("x", TRB3[:size])
        assert READER.match(source).confidence > DelimitedReader().match(source).confidence


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "empty file"),
        (TRB3[: TRB3.index(b"\n") + 1], "no data row"),
        (TRB3[: TRB3.index(b"\n") - 3], "no data row"),
        (TRB3[TRB3.index(b"\n") + 1 :], "header row with Time"),
        (TRIMMED.replace(b"0,16 \t", b""), "line 3: found 4 fields, expected 5"),
        (TRIMMED.replace(b"0,16 \t", b"0,16 \t1\t"), "line 3: found 6 fields, expected 5"),
        (TRIMMED.replace(b"\t", b" "), "header row with Time"),
        (b"\x00\x01" + TRIMMED, "zero byte"),
    ],
)
def test_broken_files_are_refused(content, message):
    with pytest.raises(ReaderError, match=message):
        read(READER, content)


def test_what_is_no_number_leaves_its_column_as_text():
    column = read(READER, TRIMMED.replace(b"-0,171", b"-0.171")).columns[3]
    assert column.first_bad == (4, "-0.171")
    assert np.asarray(column.values).dtype == object

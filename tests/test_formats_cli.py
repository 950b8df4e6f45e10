"""`tribopipe formats`: which formats there are, which a file is of, and what is in it."""

import json
from pathlib import Path

import pytest

from tribopipe.base.errors import ReaderError
from tribopipe.readers.column_meanings import meanings_of
from tribopipe.readers.export_files import chosen_reader, read_export
from tribopipe.readers.reader import Hints, Match, ReadColumn, ReadTable, readers
from tribopipe.results.run import SourceFile

DWF = b"          TIME;          FF;\r        0,9150;        4,80;;\r        1,8240;       16,13;;\r"
TABLE = b"Time [s],COF,Temp [degC],remark,Humidity [%]\n0,0.5,,a,45\n1,0.7,21.5,b,46\n2,0.6,22,c,47\n"


@pytest.fixture
def files(tmp_path) -> dict[str, Path]:
    """One file each of a format, a table and neither, under names that say nothing."""
    written = {"first": DWF, "second": TABLE, "third": b"dear diary,\n\nnothing today\n", "empty": b""}
    for name, content in written.items():
        (tmp_path / name).write_bytes(content)
    return {name: tmp_path / name for name in written}


def detected(result) -> list[dict]:
    return json.loads(result.stdout)["files"]


def test_all_readers_are_listed_with_what_they_need(run_cli):
    listed = run_cli("formats", "list", "--json")
    assert listed.exit_code == 0
    formats = {one["name"]: one for one in json.loads(listed.stdout)["formats"]}
    assert set(formats) == set(readers())
    assert formats["ducom-winducom"]["holds"] == "signals"
    assert formats["dektak"]["holds"] == "profile"
    assert {name: one["extra"] for name, one in formats.items() if one["extra"]} == {
        "workbook": "excel",
        "ni-tdms": "tdms",
        "surface-topography": "surface",
    }
    shown = run_cli("formats", "list")
    assert shown.stderr == ""
    assert "tribopipe[excel]" in shown.stdout
    assert "Optimol SRV" in shown.stdout


def test_a_format_is_told_with_what_is_in_the_file(run_cli, files):
    (told,) = detected(run_cli("formats", "detect", files["first"], "--json"))
    assert told["file"] == str(files["first"])
    assert (told["format"], told["holds"], told["confidence"]) == ("ducom-winducom", "signals", 0.95)
    assert "WINDUCOM" in told["why"]
    assert told["candidates"][0]["format"] == "delimited"
    assert told["rows"] == 2
    common = {"axis": None, "missing": 0, "proposed_unit": None}
    assert told["columns"] == [
        {"name": "TIME", "unit": "s", "signal": "time", "least": 0.915, "largest": 1.824} | common,
        {"name": "FF", "unit": "N", "signal": "friction_force", "least": 4.8, "largest": 16.13} | common,
    ]


def test_columns_without_numbers_and_missing_ones_are_told(run_cli, files):
    (told,) = detected(run_cli("formats", "detect", files["second"], "--json"))
    found = {column["name"]: column for column in told["columns"]}
    assert (found["Temp [degC]"]["least"], found["Temp [degC]"]["missing"]) == (21.5, 1)
    assert (found["remark"]["least"], found["remark"]["signal"]) == (None, None)
    assert found["COF"]["signal"] == "friction_coefficient"


def test_people_see_units_in_brackets(run_cli, files):
    shown = run_cli("formats", "detect", files["second"])
    assert shown.exit_code == 0
    assert "Time [s]" in shown.output
    assert "friction_coefficient, from its name" in shown.output


def test_an_unknown_file_is_refused_with_the_reasons(run_cli, files):
    refused = run_cli("formats", "detect", files["third"], "--json")
    assert refused.exit_code == 1
    (told,) = detected(refused)
    assert {one["format"] for one in told["candidates"]} == set(readers())
    assert "found no known format; read as a plain table: " in told["error"]
    (error,) = [line for line in refused.stderr.splitlines() if line.startswith("error: ")]
    assert str(files["third"].parent) in error
    assert "ducom-winducom" in refused.stderr


@pytest.mark.parametrize("name", ["empty", "missing"])
def test_files_that_hold_nothing_are_refused(run_cli, files, name):
    refused = run_cli("formats", "detect", files["first"].parent / name)
    assert refused.exit_code == 1
    assert "Traceback" not in refused.stderr


def test_one_unknown_file_among_others_fails_alone(run_cli, files):
    result = run_cli("formats", "detect", files["first"], files["third"], files["first"].parent, "--json")
    assert result.exit_code == 3
    assert [file.get("format") for file in detected(result)] == ["ducom-winducom", None, None]
    assert "found a folder" in detected(result)[2]["error"]


def test_a_reader_can_be_named(run_cli, files):
    (told,) = detected(run_cli("formats", "detect", files["first"], "--reader", "delimited", "--json"))
    assert (told["format"], told["why"]) == ("delimited", "specified by name")
    refused = run_cli("formats", "detect", files["first"], "--reader", "delimted")
    assert refused.exit_code == 1
    assert "did you mean 'delimited'" in refused.stderr


def test_a_reader_can_be_described(run_cli, files, tmp_path):
    rig = tmp_path / "our-rig.toml"
    rig.write_text(
        'schema = "tribopipe.reader/1"\nname = "our-rig"\ntitle = "Our rig"\n'
        '[columns.COF]\nsignal = "friction_coefficient"\n',
        encoding="utf-8",
    )
    (told,) = detected(run_cli("formats", "detect", files["second"], "--reader", rig, "--json"))
    assert (told["format"], told["title"]) == ("our-rig", "Our rig")
    assert chosen_reader(str(tmp_path / "our-rig.toml")).name == "our-rig"


class Sure:
    """Knows every file, equally sure."""

    holds = "signals"

    def __init__(self, name: str) -> None:
        self.name = self.title = name

    def match(self, _: SourceFile) -> Match:
        return Match(0.99, "it is always sure")

    def read(self, source: SourceFile, hints: Hints) -> ReadTable:
        raise AssertionError((source, hints))


def test_two_that_are_equally_sure_are_named(monkeypatch, files):
    pairs = tuple((name, Sure(name)) for name in ("one", "other"))
    monkeypatch.setattr("tribopipe.readers.reader._loaded", lambda: pairs)
    with pytest.raises(ReaderError, match="first: found a file that the readers one and other recognize"):
        read_export(files["first"])


def column(name: str, unit: str | None = None, signal=None) -> ReadColumn:
    import numpy as np

    return ReadColumn(name, np.zeros(2), unit, signal)


@pytest.mark.parametrize(
    ("name", "unit", "signal"),
    [
        ("Czas", "s", "time"),
        ("t", "min", "time"),
        ("t", "°C", "temperature"),
        ("tiempo[s]", "s", "time"),
        ("distancia [m]", "m", "sliding_distance"),
        ("Ft", "N", "friction_force"),
        ("Reibungskraft (mN)", "mN", "friction_force"),
        ("fuerza[kg]", "kg", "friction_force"),
        ("Siła tarcia", "N", "friction_force"),
        ("µ", None, "friction_coefficient"),
        ("Coeff. of friction", "1", "friction_coefficient"),
        ("F_n", "N", "normal_force"),
        ("fz_N", "N", "normal_force"),
        ("Last", "N", "normal_force"),
        ("Penetration Depth [µm]", "µm", "depth"),
        ("Verschleiß", "um", "depth"),
        ("sliding distance", "mm", "sliding_distance"),
        ("rH", "%", "relative_humidity"),
        ("Revolutions", None, "rotations"),
        ("Angle", "deg", None),
    ],
)
def test_meanings_by_name(name, unit, signal):
    meaning = meanings_of([column(name, unit)]).get(name)
    assert (meaning and meaning.signal) == signal
    assert meaning is None or (meaning.doubt, meaning.by) == ("", "from its name")


@pytest.mark.parametrize(
    ("columns", "doubted"),
    [
        ([column("Time")], {"Time"}),
        ([column("RH", "1")], {"RH"}),
        ([column("Ft", "V")], {"Ft"}),
        ([column("Friction", "%")], {"Friction"}),
        ([column("Ft", "V"), column("Friction", "N")], set()),
        ([column("RH")], {"RH"}),
        ([column("Weg", "um")], {"Weg"}),
        ([column("COF"), column("mu")], {"COF", "mu"}),
        ([column("COF"), column("friction_coefficient")], set()),
        ([column("COF"), column("x", None, "friction_coefficient")], set()),
    ],
)
def test_what_a_name_leaves_open_is_doubted(columns, doubted):
    assert {name for name, meaning in meanings_of(columns).items() if meaning.doubt} == doubted


def test_no_two_columns_are_one_signal():
    columns = [column("A", "N", "normal_force"), column("B", "N", "normal_force"), column("Fz", "N"), column("A")]
    assert meanings_of(columns) == {"B": meanings_of(columns)["B"]}

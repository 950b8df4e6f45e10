"""`tribopipe new` of a month of tests: a folder of exports, and a table of what was measured on each."""

import json
import re
import tomllib
from pathlib import Path

import pytest
from built_files import xlsx
from hypothesis import given, settings
from hypothesis import strategies as st

from tribopipe.base.errors import ManifestError, ReaderError
from tribopipe.readers.draft.measurements_table import read_ends

HEAD = "run;normal load [N];pin_scar_diameter [um];u(pin_scar_diameter) [um];disc_wear_volume [mm^3];Bemerkung im Heft"


@pytest.fixture
def lab(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "exports").mkdir()
    return tmp_path


def export(number: int, rows: int = 30) -> bytes:
    body = "".join(f"{n / 10:.1f};{2 + number / 100 + n % 3 / 10:.2f}\n" for n in range(rows))
    return f"Time [s];Friction force [N]\n{body}".encode()


def month(lab: Path, count: int) -> None:
    for number in range(1, count + 1):
        (lab / "exports" / f"test_{number}.csv").write_bytes(export(number))


def ends(lab: Path, *rows: str, head: str = HEAD) -> Path:
    path = lab / "ends.csv"
    path.write_text("\n".join([head, *rows, ""]), encoding="utf-8")
    return path


def run_toml(lab: Path, name: str) -> dict:
    return tomllib.loads((lab / name / "run.toml").read_text(encoding="utf-8"))


@pytest.mark.slow
def test_thirty_runs_get_their_loads_scars_and_volumes_in_one_command(run_cli, lab):
    month(lab, 30)
    ends(lab, *(f"test_{n};{n};{400 + n},5;3;0,0{n:02};schön" for n in range(1, 31)))
    made = run_cli("new", "exports", "--ends", "ends.csv", "--json")
    assert made.exit_code == 0, made.stderr
    runs = json.loads(made.stdout)["runs"]
    assert [run["id"] for run in runs] == [f"test_{n}" for n in range(1, 31)]
    assert all((run["still_to_be_filled_in"], run["problem"]) == ([], None) for run in runs)
    for n in (1, 7, 30):
        document = run_toml(lab, f"test_{n}")
        assert document["conditions"]["normal_load"] == f"{n} N"
        assert document["end_values"] == {
            "pin_scar_diameter": {"value": f"{400 + n}.5 um", "standard_uncertainty": "3 um"},
            "disc_wear_volume": f"0.0{n:02} mm^3",
        }
    text = (lab / "test_7" / "run.toml").read_text(encoding="utf-8")
    assert "# from ends.csv, line 8" in text
    assert run_cli("check", "test_7", "--json").exit_code in (0, 1)


def test_a_workbook_tells_the_same(run_cli, lab):
    month(lab, 2)
    rows = [
        ["file", "Normalkraft [N]", "Kalottendurchmesser [µm]"],
        ["test_1.csv", 5.0, 412.5],
        ["test_2.csv", 7.5, None],
    ]
    (lab / "ends.xlsx").write_bytes(xlsx({"Mai": rows}))
    assert run_cli("new", "exports", "--ends", "ends.xlsx").exit_code == 0
    assert run_toml(lab, "test_1")["end_values"] == {"pin_scar_diameter": "412.5 µm"}
    assert run_toml(lab, "test_2")["conditions"] == {"normal_load": "7.5 N"}


@pytest.mark.parametrize(
    ("rows", "head", "told"),
    [
        (
            ["test_1;5;400;3;0,1;", "TEST_1;6;400;3;0,1;"],
            HEAD,
            r"line 3: found the run 'TEST_1' twice, first in line 2",
        ),
        (["test_9;5;400;3;0,1;"], HEAD, r"line 2: found the run 'test_9', for which no file.*did you mean"),
        (
            ["test_1;5;400"],
            "run;normal_load [N];pin_scar_diameter",
            r"line 2: end_values.pin_scar_diameter: found '400' without a unit",
        ),
        (["test_1;5"], "run;normal_load", r"line 2: conditions.normal_load: found"),
        (["test_1;1,000"], "run;normal_load [N]", "thousands"),
        (["test_1;-5"], "run;normal_load [N]", "a positive value"),
        (["test_1;5"], "run;normal_load [mm]", "'mm', which is not a unit of force"),
        (["test_1;5"], "run;wear volume [mm^3]", "may refer to the pin or the disc"),
        (["test_1;5;6"], "run;normal_load [N];Last [N]", "a second column for conditions.normal_load"),
        (["test_1;3"], "run;u(normal_load) [N]", "an uncertainty without a value"),
        ([";5"], "run;normal_load [N]", "a row without a run"),
        (["5;test_1"], "normal_load [N];run", "expected the column 'run'"),
        ([], HEAD, "found 1 rows"),
    ],
)
def test_a_table_that_cannot_be_is_refused_and_nothing_is_made(run_cli, lab, rows, head, told):
    month(lab, 2)
    ends(lab, *rows, head=head)
    refused = run_cli("new", "exports", "--ends", "ends.csv")
    assert refused.exit_code == 1
    assert re.search(told, refused.stderr)
    assert sorted(path.name for path in lab.iterdir()) == ["ends.csv", "exports"]


def test_columns_that_mean_nothing_and_runs_without_a_row_are_named(run_cli, lab):
    month(lab, 2)
    ends(lab, "test_1;5;400;3;0,1;x")
    made = run_cli("new", "exports", "--ends", "ends.csv")
    assert made.exit_code == 0
    assert "ends.csv has no row for this run" in made.stderr
    assert "ends.csv: column 'Bemerkung im Heft' is not a key of run.toml and is not used" in made.stderr


def test_what_a_table_says_stays_before_a_header_that_says_otherwise(run_cli, lab):
    (lab / "exports" / "test_1.csv").write_bytes(b"Normalkraft;9 N\n\n" + export(1))
    ends(lab, "test_1;5;400;3;0,1;")
    made = run_cli("new", "exports", "--ends", "ends.csv")
    assert run_toml(lab, "test_1")["conditions"] == {"normal_load": "5 N"}
    assert "found 5 N from ends.csv, line 2, but 9 N from test_1.csv" in made.stderr


@pytest.mark.slow
def test_a_folder_of_exports_is_a_run_each_and_all_else_is_named(run_cli, lab):
    month(lab, 4)
    exports = lab / "exports"
    (exports / "copy of test_1.csv").write_bytes(export(1))
    (exports / "test_5.csv").write_bytes(export(5, rows=6))
    (exports / "lab.toml").write_text("", encoding="utf-8")
    (exports / "notes.txt").write_text("Läufe vom Mai.\n", encoding="utf-8")
    (exports / "test_2.txt").write_bytes(export(22))
    made = run_cli("new", "exports", "--set", "conditions.normal_load=5 N", "--into", "runs", "--json")
    assert made.exit_code == 0, made.stderr
    told = json.loads(made.stdout)
    assert [run["id"] for run in told["runs"]] == ["copy-of-test_1", "test_2", "test_3", "test_4", "test_5"]
    assert {one["file"]: one["why"].partition(";")[0] for one in told["left_out"]} == {
        "lab.toml": "not an instrument export",
        "notes.txt": "no reader recognizes its format",
        "test_1.csv": "an exact duplicate of copy of test_1.csv",
        "test_2.txt": "another file is already used for the run test_2",
    }
    note = "this test is 17 % as long as the others in the folder: was it stopped early?"
    assert told["runs"][4]["notes"] == [note]
    again = run_cli("new", "exports", "--set", "conditions.normal_load=5 N", "--into", "runs")
    assert again.exit_code == 1
    assert "found no file from which a run can be created" in again.stderr


def test_a_broken_export_stops_no_other_and_is_a_failure(run_cli, lab):
    month(lab, 2)
    (lab / "exports" / "torn.csv").write_bytes(export(3) + b"0.5;1;2;3\n")
    made = run_cli("new", "exports", "--set", "conditions.normal_load=5 N")
    assert made.exit_code == 3
    assert "skipped: torn.csv: line 32: found 4 fields" in made.stderr
    assert (lab / "test_2" / "run.toml").is_file()


def test_one_id_for_several_runs_and_an_empty_folder_are_refused(run_cli, lab):
    month(lab, 1)
    assert "found one ID for several runs" in run_cli("new", "exports", "--id", "x").stderr
    (lab / "empty").mkdir()
    assert "found no file from which" in run_cli("new", "empty").stderr


TEXT = st.text(st.characters(exclude_categories=["Cs"]), max_size=12)


@given(st.lists(st.lists(TEXT, min_size=1, max_size=4), max_size=5), st.sampled_from(";,\t"))
@settings(max_examples=100)
def test_any_table_is_read_or_refused_in_a_sentence(tmp_path_factory, rows, separator):
    path = tmp_path_factory.mktemp("ends") / "ends.csv"
    written = [["run", "normal_load [N]", "pin_scar_diameter"], *rows]
    path.write_text("\n".join(map(separator.join, written)), encoding="utf-8")
    try:
        table = read_ends(path)
    except (ManifestError, ReaderError) as error:
        refused = str(error)
    else:
        refused = ""
    assert not refused or refused.startswith("ends.csv")
    if refused:
        return
    assert len({row.run.casefold() for row in table.rows}) == len(table.rows)


PAIRS = st.tuples(st.decimals("0.01", "999", places=2), st.decimals("1", "900", places=1))


@given(st.lists(PAIRS, min_size=1, max_size=6), st.sampled_from([(";", ","), (";", "."), (",", "."), ("\t", ",")]))
def test_values_are_read_as_they_were_written(tmp_path_factory, values, signs):
    separator, decimal = signs
    path = tmp_path_factory.mktemp("ends") / "ends.csv"
    lines = [["run", "normal_load [N]", "pin_scar_diameter [um]"]]
    lines += [[f"r{n}", *(str(one).replace(".", decimal) for one in pair)] for n, pair in enumerate(values)]
    path.write_text("\n".join(map(separator.join, lines)), encoding="utf-8")
    table = read_ends(path)
    for row, (load, scar) in zip(table.rows, values, strict=True):
        found = {key: given_value.value for key, given_value in row.values.items()}
        assert found == {"conditions.normal_load": f"{load} N", "end_values.pin_scar_diameter": f"{scar} um"}

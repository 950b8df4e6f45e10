"""`tribopipe ls` and `tribopipe export runs`: what is listed, how it looks, and that it is quick."""

import csv
import io
import json
import re
import shutil
import subprocess
import sys

import pytest
from archived_files import edited
from folders import set_key, tree_bytes

from tribopipe.archive.catalog.listing import COLUMNS
from tribopipe.archive.store import Archive
from tribopipe.cli import output
from tribopipe.documents.annotation import Mark

pytestmark = pytest.mark.usefixtures("few_draws")

RUN, HEAVIER = "si3n4-air-200mN", "si3n4-air-400mN"


@pytest.fixture
def ls(run_cli, archive, sample_run):
    """List an archive of a processed run, and of one as ingested that is heavier."""
    set_key(sample_run, "title", '"\\u001b[31mred <script>\\u202e"')
    run_cli("ingest", sample_run, "--archive", archive)
    return lambda *arguments: run_cli("ls", *arguments, "--archive", archive)


# --- the table ---


def test_usual_columns_are_those_something_is_known_of(ls):
    told = ls()
    assert told.exit_code == 0
    title, _, head, rule, first, second, *_ = told.stdout.splitlines()
    assert title.startswith("2 runs in ")
    assert title.endswith("; k_D from Archard's law; ± is one standard uncertainty")
    assert re.split("  +", head.strip()) == [
        *(
            "run",
            "tribometer",
            "materials",
            "medium",
            "load, mN",
            "steady-state μ",
            "k_D, 10⁻⁹ mm³/(N·mm)",
            "started",
            "stage",
        )
    ]
    assert set(rule.strip()) == {"─"}
    assert re.match(rf" {RUN} +pin-on-disc +Si3N4 +air +200\.0 ± 2\.0 +0\.\d+ ± ", first)
    assert re.match(
        rf" {HEAVIER} +pin-on-disc +Si3N4 +air +400\.0 ± 4\.0 +– +– +2006-03-01 \d\d:\d\d +ingested$", second
    )
    assert max(map(len, told.output.splitlines())) <= 160


def test_columns_and_order_are_chosen(ls):
    told = ls("--columns", "id,K-D,load", "--sort", "-load").stdout.splitlines()
    assert re.split("  +", told[2].strip()) == ["run", "k_D, 10⁻⁹ mm³/(N·mm)", "load, mN"]
    assert [line.split()[0] for line in told[4:6]] == [HEAVIER, RUN]


def test_columns_are_explained(ls):
    told = ls("--columns", "help")
    assert [
        name for name, column in COLUMNS.items() if f" {name} " not in told.stdout or column.help not in told.stdout
    ] == []
    explained = json.loads(ls("--columns", "help", "--json").stdout)["columns"]
    assert [column["name"] for column in explained] == list(COLUMNS)
    assert explained[13] == {"name": "load", "unit": "mN", "kind": "number", "meaning": "Nominal normal load."}


def test_runs_are_chosen(ls):
    assert "1 run in " in ls("--where", "load > 300 mN").stdout
    assert "0 runs in " in ls("--where", "tag=run-in").stdout
    assert ls("--where", "tag=run-in").exit_code == 0


@pytest.mark.parametrize("arguments", [["--where", "lod>1"], ["--sort", "-lod"], ["--columns", "id,lod"]])
def test_what_is_not_understood_is_refused(ls, arguments):
    told = ls(*arguments)
    assert told.exit_code == 1
    assert "did you mean 'load'?" in told.stderr
    assert told.stderr.count("\n") == 1


def test_a_load_without_a_unit_is_refused_since_the_list_has_no_one_unit_of_it(ls):
    told = ls("--where", "load>55")
    assert told.exit_code == 1
    assert "write 55 mN or 55 N" in told.stderr


def test_hostile_texts_are_shown_without_steering_the_terminal(ls):
    told = ls("--columns", "id,title").stdout
    assert "\\x1b[31mred <script>\\u202e" in told
    assert "\x1b" not in told


def test_unreadable_runs_are_told_with_the_others(ls, archive):
    (archive / "broken.h5").write_bytes(b"no HDF5")
    told = ls()
    assert told.exit_code == 3
    assert "2 runs in " in told.stdout
    assert "broken.h5: found a file that is damaged or not HDF5" in told.stderr
    assert ls("--where", "load>300mN").exit_code == 3
    told = ls("--json")
    assert told.exit_code == 3
    assert len(json.loads(told.stdout)["runs"]) == 2


def test_json_tells_what_is_known_in_si(ls, archive):
    Archive(archive).mark(RUN, Mark(kind="bad", reason="slipped", date="2026-01-05T08:00:00+00:00"))
    first, second = json.loads(ls("--json").stdout)["runs"]
    assert set(first) == set(second) == {*COLUMNS, "normal_load"}
    assert first["normal_load"] == first["load"] == {"value": 0.2, "unit": "N", "standard_uncertainty": 0.002}
    assert (first["marked_bad"], second["marked_bad"]) == ("slipped", None)
    assert (second["steps"], second["k_d"], second["tags"]) == ([], None, [])
    assert first["steps"] == Archive(archive).step_names(RUN)
    assert first["started"] == "2006-03-01T09:30:00+01:00"
    assert first["k_d"]["unit"] == "m^2/N"


@pytest.mark.parametrize(
    ("cells", "width"), [(["abc"], 3), (["漢字"], 4), (["e\u0301"], 1), (["µm ± 2"], 6), (["a\nb"], 3), (["\x07"], 4)]
)
def test_columns_stand_beneath_each_other_whatever_is_in_them(capsys, cells, width):
    output.table("title", ["", "next"], [[cell, "x"] for cell in cells])
    *_, row, last = capsys.readouterr().out.splitlines()
    assert last == ""
    assert row.endswith("   x")
    assert output._width(row) == 1 + width + 3 + 1


@pytest.fixture
def terminal(monkeypatch):
    """Make stdout a terminal of some width."""

    def become(columns: int) -> None:
        monkeypatch.setattr(sys.stdout, "isatty", lambda: True, raising=False)
        monkeypatch.setenv("COLUMNS", str(columns))

    return become


def widest(text: str) -> int:
    """Width of the widest line, but for a folder that has a line of its own, as nothing shortens a path."""
    lines = re.sub("\x1b.*?m", "", text).splitlines()
    return max(output._width(line) for line in lines if not re.fullmatch(r" *\S+;", line))


def test_wide_tables_break_texts_and_heads_on_a_narrow_terminal(capsys, terminal):
    rows = [["run-1", "13.58 ± 0.25 mN", "many words that can be broken " * 3], ["run-2", "1 ± 2 mN", "few"]]
    output.table("", ["run", "a long head", "about"], rows)
    assert widest(capsys.readouterr().out) > 100
    terminal(60)
    output.table("", ["run", "a long head", "about"], rows)
    shown = capsys.readouterr().out
    assert widest(shown) <= 60
    assert "run-1  13.58 ± 0.25 mN  many words" in shown
    terminal(40)
    output.table("", ["run", "first", "second", "third"], [["run-1", "x" * 20, "y" * 20, "z" * 5]])
    lines = capsys.readouterr().out.splitlines()
    assert [line.split() for line in lines if line.strip()] == [
        *(["\x1b[1m", "run-1\x1b[0m"], ["first", "x" * 20], ["second", "y" * 20], ["third", "z" * 5])
    ]


def test_numbers_are_not_broken_across_lines(capsys, terminal):
    terminal(60)
    output.print_result(f"{'word ' * 9}(1.350 ± 0.029)×10⁻⁵ mm³/(N·m)")
    assert "(1.350 ± 0.029)×10⁻⁵ mm³/(N·m)" in capsys.readouterr().out.splitlines()[1]


def test_narrow_terminals_keep_what_matters_and_twenty_rows(ls, terminal, monkeypatch):
    terminal(80)
    monkeypatch.setattr("tribopipe.cli.listing._ROWS", 1)
    assert "and 1 more: add --all" in ls().stdout
    shown = ls("--all").stdout
    assert HEAVIER in shown
    assert widest(shown) <= 80
    assert [name for name in ("load", "steady-state μ", "k_D") if name not in shown] == []
    assert "tribometer" not in shown


def test_pipes_get_every_row(ls, monkeypatch):
    monkeypatch.setattr("tribopipe.cli.listing._ROWS", 1)
    assert "more" not in ls().stdout


@pytest.mark.slow
def test_a_run_fitted_with_another_law_alone_has_a_coefficient(run_cli, sample_run, other_run, tmp_path):
    at = ("--archive", tmp_path / "both")
    run_cli("ingest", sample_run, other_run, *at)
    run_cli("fit", RUN, *at)
    run_cli("fit", HEAVIER, "--law", "sarkar", *at)
    title, _, head, _, first, second, *_ = run_cli("ls", *at).stdout.splitlines()
    assert "Archard" not in title
    assert "law" in head.split()
    assert [("Archard" in line, "Sarkar" in line) for line in (first, second)] == [(True, False), (False, True)]
    assert all(re.search(r"\d ± \d", line) for line in (first, second))


def test_factors_of_units_are_those_of_the_units():
    from tribopipe.archive.catalog.listing import PER_SI
    from tribopipe.base.units import KINDS, interval_from_si

    for column in COLUMNS.values():
        if column.kind == "number" and column.unit in PER_SI:
            assert PER_SI[column.unit] == pytest.approx(interval_from_si(1.0, KINDS[column.measures].si, column.unit))
        elif column.kind == "number":
            assert column.unit == "°C"


# --- quick ---


@pytest.mark.slow
def test_listing_what_is_known_imports_nothing_heavy(ls, archive):
    ls()
    code = (
        "import sys; sys.argv = ['tribopipe', 'ls', '--where', 'material=Si3N4', '--archive', sys.argv[1]]\n"
        "from tribopipe.cli.app import main\n"
        "try:\n    main()\nexcept SystemExit:\n    pass\n"
        "print(*{name.partition('.')[0] for name in sys.modules})"
    )
    done = subprocess.run([sys.executable, "-c", code, archive], capture_output=True, text=True, encoding="utf-8")
    assert done.returncode == 0, done.stderr
    heavy = {"h5py", "pandas", "scipy", "matplotlib", "numpy", "pint", "rich"}
    assert heavy & set(done.stdout.split()) == set()


# --- as CSV ---


@pytest.mark.usefixtures("ls")
def test_csv_has_units_and_uncertainties(run_cli, archive):
    told = run_cli("export", "runs", "--archive", archive, "--sort", "-load")
    assert told.exit_code == 0
    rows = list(csv.DictReader(io.StringIO(told.stdout)))
    assert [row["id"] for row in rows] == [HEAVIER, RUN]
    assert (rows[1]["load [mN]"], rows[1]["load uncertainty [mN]"]) == ("200.0", "2.0")
    assert rows[0]["k_d [mm³/(N·mm)]"] == ""
    fit = Archive(archive).steps(RUN)["wear_fit_archard"].result.first.wear_coefficient
    assert float(rows[1]["k_d [mm³/(N·mm)]"]) == pytest.approx(fit.value * 1e6, rel=1e-12)
    assert float(rows[1]["k_d uncertainty [mm³/(N·mm)]"]) == pytest.approx(fit.standard_uncertainty * 1e6, rel=1e-12)


@pytest.mark.usefixtures("ls")
def test_csv_is_written_to_a_file(run_cli, archive, tmp_path):
    told = run_cli(
        *("export", "runs", "--archive", archive, "--where", "load<300mN"),
        *("--columns", "id,title,temperature", "-o", tmp_path / "runs.csv"),
    )
    assert told.exit_code == 0
    assert "1 run written to " in told.stderr
    lines = (tmp_path / "runs.csv").read_bytes().decode("utf-8").split("\r\n")
    assert lines[0] == "id,title,temperature [°C],temperature uncertainty [°C]"
    assert lines[1].startswith(f"{RUN},")


def test_formulas_in_texts_stay_texts(archive, run_cli):
    with edited(archive / f"{RUN}.h5") as file:
        note = file["entry/manifest/data"]
        note[()] = note.asstr()[()].replace('"comment":null', '"comment":"=1+1"')
    told = run_cli("export", "runs", "--archive", archive, "--columns", "comment")
    assert told.stdout.splitlines() == ["comment", "'=1+1"]


def test_copied_archive_lists_the_same(ls, run_cli, archive, tmp_path):
    before = ls("--json").stdout
    moved = shutil.copytree(archive, tmp_path / "moved")
    assert run_cli("ls", "--json", "--archive", moved).stdout == before


def test_run_that_was_deleted_is_listed_no_more(run_cli, archive):
    assert run_cli("ls", "--archive", archive).exit_code == 0
    for path in archive.glob("*.h5"):
        path.unlink()
    told = run_cli("ls", "--archive", archive, "--json")
    assert json.loads(told.stdout)["runs"] == []


@pytest.mark.parametrize("command", ["ls", "process {}", "ingest {}", "fit", "show some", "export runs", "verify"])
def test_run_folder_is_no_archive(run_cli, sample_run, command):
    before = tree_bytes(sample_run)
    told = run_cli(*command.format(sample_run).split(), "--archive", sample_run)
    assert told.exit_code != 0
    assert "found a run folder; expected a folder of archived runs" in told.stderr
    assert {path.name for path in sample_run.iterdir()} == {path.split("/")[0] for path in before}
    assert tree_bytes(sample_run) == before


def test_a_date_without_a_time_is_listed_without_one(run_cli, sample_run, tmp_path):
    set_key(sample_run, "started", "2024-05-12")
    assert run_cli("ingest", sample_run, "--archive", tmp_path / "a").exit_code == 0
    for command in (["ls", "--columns", "id,started"], ["show", HEAVIER, "-v"]):
        shown = run_cli(*command, "--archive", tmp_path / "a").stdout
        assert re.search(r"2024-05-12(?! 00:00)", shown)

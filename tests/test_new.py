"""`tribopipe new`: from exports to a run folder, with everything they tell and a line for what only the lab knows."""

import errno
import json
import os
import re
import subprocess
import sys
import tomllib
from functools import reduce
from pathlib import Path

import numpy as np
import pytest
from folders import ROOT, tree_bytes
from hypothesis import given, settings
from hypothesis import strategies as st

from tribopipe.base.errors import ManifestError, ReaderError
from tribopipe.documents.lab_template import read_template
from tribopipe.documents.manifest import RunManifest, read_manifest
from tribopipe.readers.draft.blanks import BLANKS, ask_for_missing
from tribopipe.readers.draft.folder import Wanted, fit_for_id, make_run
from tribopipe.readers.draft.known_values import Given, Known, comment, problem_of, toml, value_of
from tribopipe.readers.draft.run_files import Group
from tribopipe.readers.draft.run_toml import Draft, manifest_text
from tribopipe.readers.draft.value_sources import gather
from tribopipe.readers.export_files import Export
from tribopipe.readers.harmonize import read_run
from tribopipe.readers.reader import Match, ReadColumn, ReadTable, reader_named
from tribopipe.results.run import SourceFile

pytestmark = pytest.mark.usefixtures("few_draws")

REAL = Path(__file__).resolve().parents[2] / "shared" / "realdata" / "winducom-dwf-al10cu"
REAL_FILES = sorted(REAL.glob("*/*.dwf"))
LOAD = "conditions.normal_load=50 N"
BODIES = """
[contact]
kind = "pin-on-disc"
[contact.pin]
shape = "flat"
radius = "4 mm"
material = "Al10Cu"
youngs_modulus = "72 GPa"
poisson_ratio = 0.33
[contact.disc]
material = "steel"
youngs_modulus = "210 GPa"
poisson_ratio = 0.3
"""


def dwf(rows: int = 400) -> bytes:
    lines = ["          TIME;          FF;\r"]
    for n in range(rows):
        time, force = f"{0.98 * (n + 1):.4f}".replace(".", ","), f"{22 + (n * 7 % 13) / 10:.2f}".replace(".", ",")
        lines.append(f"{time:>14};{force:>12};;\r")
    return "".join(lines).encode("ascii")


def table(name: str, values, *, time="Time [s]") -> bytes:
    return "".join([f"{time},{name}\n", *(f"{n / 10:.1f},{value:.3f}\n" for n, value in enumerate(values))]).encode()


@pytest.fixture
def lab(tmp_path, monkeypatch) -> Path:
    """A folder in which to work."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def export(lab) -> Path:
    path = lab / "7-Al10Cu-50N-140m-328rpm.dwf"
    path.write_bytes(dwf())
    return path


def put(folder: Path, **files: bytes) -> list[Path]:
    for name, content in files.items():
        (folder / f"{name}.csv").write_bytes(content)
    return [folder / f"{name}.csv" for name in files]


def document(folder: Path) -> dict:
    return tomllib.loads((folder / "run.toml").read_text(encoding="utf-8"))


def answering(*answers: str):
    """Answer the first questions so, and leave the others open; keeps what was asked."""
    left, asked = list(answers), []

    def ask(question: str) -> str:
        asked.append(question)
        return left.pop(0) if left else ""

    ask.asked = asked
    return ask


# --- one WINDUCOM file and one answered question ---


def test_one_row_is_a_row(run_cli, lab):
    (lab / "short.csv").write_text("time [s],friction force [N]\n0,1\n", encoding="utf-8")
    assert "short.csv: 1 row, " in run_cli("new", "short.csv").stderr


@pytest.mark.slow
def test_one_file_and_one_answer_end_in_a_run_that_process_takes(run_cli, lab, export, monkeypatch):
    ask = answering("50 N")
    monkeypatch.setattr("tribopipe.cli.new._somebody_to_ask", lambda: ask)
    made = run_cli("new", export, "--json")
    assert made.exit_code == 0, made.stderr
    assert ask.asked[0].startswith(
        "conditions.normal_load, nominal normal load; required (50 N: suggested by the file name"
    )
    told = json.loads(made.stdout)
    assert told["id"] == "7-Al10Cu-50N-140m-328rpm"
    assert told["files"] == [{"format": "ducom-winducom", "names": [export.name]}]
    assert (told["still_to_be_filled_in"], told["problem"]) == ([], None)
    folder = lab / told["folder"]
    assert (folder / export.name).read_bytes() == export.read_bytes() == dwf()
    assert document(folder) == {
        "schema": "tribopipe.run/1",
        "id": "7-Al10Cu-50N-140m-328rpm",
        "conditions": {"normal_load": "50 N"},
        "signals": [
            {
                "file": export.name,
                "reader": "ducom-winducom",
                "columns": {"time": "TIME", "friction_force": "FF"},
            }
        ],
    }
    processed = run_cli("process", folder, "--archive", lab / "archive", "--no-figures")
    assert processed.exit_code == 0, processed.stderr


@pytest.mark.slow
@pytest.mark.skipif(not REAL_FILES, reason="the real WINDUCOM runs are not beside this checkout")
def test_a_real_file_and_one_answer_end_in_a_run_that_process_takes(run_cli, lab):
    made = make_run(Wanted(REAL_FILES[:1]), answering("50 N"), str)
    assert (made.missing, made.problem) == ((), None)
    processed = run_cli("process", made.folder, "--archive", lab / "archive", "--no-figures")
    assert processed.exit_code == 0, processed.stderr
    assert (made.folder / REAL_FILES[0].name).read_bytes() == REAL_FILES[0].read_bytes()


def terminal_text(ours: int) -> str:
    """Read a pseudo-terminal until whoever writes to it has ended."""
    read = b""
    while True:
        try:
            part = os.read(ours, 1 << 12)
        except OSError:  # how Linux tells the end
            part = b""
        if not part:
            return read.decode()
        read += part


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals on Windows")
@pytest.mark.parametrize("stopped", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_a_terminal_is_asked(lab, export, stopped):
    import pty

    ours, theirs = pty.openpty()
    command = [sys.executable, "-m", "tribopipe", "new", str(export)]
    with subprocess.Popen(command, stdin=theirs, stdout=subprocess.PIPE, stderr=theirs, cwd=lab) as process:
        os.close(theirs)
        os.write(ours, b"50\n" + (b"\x04" if stopped else b"50 N\n" + b"\n" * 20))
        shown = terminal_text(ours)
        os.close(ours)
        assert process.stdout.read() == b""
        process.wait(timeout=60)
    assert "conditions.normal_load" in shown
    assert "without a unit" in shown
    if stopped:
        assert process.returncode == 1
        assert [path.name for path in lab.iterdir()] == [export.name]
    else:
        assert process.returncode == 0
        assert document(lab / export.stem)["conditions"] == {"normal_load": "50 N"}


def test_nobody_is_asked_without_a_terminal_and_what_is_missing_is_said(run_cli, lab, export):
    made = run_cli("new", export)
    assert made.exit_code == 0
    assert made.stdout == ""
    assert "still missing: conditions.normal_load\n" in made.stderr
    assert re.search(r"Next: edit (\S+run)\.toml, then tribopipe process \S+\n", made.stderr)
    text = (lab / export.stem / "run.toml").read_text(encoding="utf-8")
    assert '# normal_load = "50 N"' in text
    assert '# rotational_speed = "328 rpm"' in text
    assert "suggested by the file name" in text
    with pytest.raises(ManifestError, match=r"conditions\.normal_load: missing"):
        read_manifest(lab / export.stem / "run.toml")


# --- questions ---


def test_wrong_answers_are_explained_and_asked_again(export):
    heard = []
    ask = answering("50", "fifty newton", "-3 N", "50 N")
    made = make_run(Wanted([export]), ask, heard.append)
    assert len(heard) == 3
    assert "without a unit" in heard[0]
    assert "not a number with a unit" in heard[1]
    assert "a positive value" in heard[2]
    assert document(made.folder)["conditions"] == {"normal_load": "50 N"}


def test_bodies_are_asked_for_once_the_shape_is_told(export):
    shape = "truncated-sphere"
    ask = answering(
        *("50 N", "2.4 m/s", shape, "4 mm", "5 mm", "0.1 mm", "Al10Cu", "72 GPa", "0.33", "304", "210 GPa", "0.3")
    )
    made = make_run(Wanted([export]), ask, str)
    contact = document(made.folder)["contact"]
    assert contact == {
        "kind": "pin-on-disc",
        "pin": {
            "shape": shape,
            "radius": "4 mm",
            "flat_radius": "0.1 mm",
            "material": "Al10Cu",
            "youngs_modulus": "72 GPa",
            "poisson_ratio": 0.33,
        },
        "disc": {"material": "304", "youngs_modulus": "210 GPa", "poisson_ratio": 0.3},
    }
    assert made.bodies_lack == ()
    assert read_run(made.folder).manifest.described.disc.material == "304"


def test_what_is_typical_of_a_material_is_offered_as_soon_as_it_is_named(export):
    ask = answering("50 N", "2.4 m/s", "spherical", "D = 6 mm", "100Cr6", "y", "y", "C45", "200 GPa", "y")
    contact = document(make_run(Wanted([export]), ask, str).folder)["contact"]
    assert "(210 GPa: typical of steel; enter y to accept; press Enter to skip)" in ask.asked[5]
    assert (contact["pin"]["youngs_modulus"], contact["pin"]["poisson_ratio"]) == ("210 GPa", 0.3)
    assert (contact["disc"]["youngs_modulus"], contact["disc"]["poisson_ratio"]) == ("200 GPa", 0.3)


def test_what_is_typical_of_a_material_is_taken_only_where_it_is_accepted(run_cli, lab):
    head = b"Ball;100Cr6\nDisc;PEEK CF30\n\n"
    put(lab, a=head + table("Friction force [N]", [1.0, 2.0]))
    offered, taken = (run_cli("new", "a.csv", "--id", name, *more) for name, more in (("b", []), ("c", ["--accept"])))
    keys = "contact.pin.youngs_modulus, contact.pin.poisson_ratio"
    assert f"suggested in run.toml: {keys}; to accept, remove the # from these lines, or delete" in offered.stderr
    assert "contact.pin.youngs_modulus = 210 GPa, typical of steel" in taken.stderr
    assert '# youngs_modulus = "210 GPa"      # typical of steel\n' in (lab / "b" / "run.toml").read_text(
        encoding="utf-8"
    )
    assert taken.stderr.count("typical of") == 3  # nothing is of a polymer with fibers


def test_of_a_pin_without_a_shape_nothing_more_is_asked(export):
    ask = answering("50 N", "", "")
    make_run(Wanted([export]), ask, str)
    assert [question.partition(",")[0] for question in ask.asked] == [
        *("conditions.normal_load", "conditions.sliding_speed", "contact.pin.shape"),
    ]


@pytest.mark.parametrize("stop", [KeyboardInterrupt, EOFError])
def test_a_stop_leaves_nothing_behind(lab, export, stop):
    def ask(_: str) -> str:
        raise stop

    with pytest.raises(stop):
        make_run(Wanted([export], into=lab / "runs"), ask, str)
    assert list(tree_bytes(lab)) == [export.name]


def test_a_failure_while_writing_leaves_nothing_behind(lab, export, monkeypatch):
    def fails(_: object) -> None:
        raise OSError("disk full")

    monkeypatch.setattr("tribopipe.readers.draft.folder.read_run", fails)
    with pytest.raises(OSError, match="disk full"):
        make_run(Wanted([export]))
    assert [path.name for path in lab.iterdir()] == [export.name]


def test_a_place_that_cannot_be_written_is_named_and_not_what_was_to_be_made_beside_it(export, monkeypatch):
    def refuse(path: Path, *_, **__):
        if path.suffix == ".part":
            raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(Path, "mkdir", refuse)
    with pytest.raises(ManifestError, match=rf"^{export.stem}: cannot be created \(Permission denied\); .*--into$"):
        make_run(Wanted([export], settings=[LOAD]))


# --- several files ---


def test_files_that_continue_each_other_are_put_in_natural_order(lab):
    files = put(lab, **{f"stroke {n}": table("Ff [N]", [n, n + 0.5]) for n in (10, 2, 1)})
    made = make_run(Wanted(files, settings=[LOAD]))
    assert made.folder.name == "stroke-1"
    (signals,) = document(made.folder)["signals"]
    assert signals["files"] == ["stroke 1.csv", "stroke 2.csv", "stroke 10.csv"]
    assert signals["columns"] == {"time": "Time [s]", "friction_force": "Ff [N]"}
    assert made.groups[0].rows == 6
    assert made.notes[-1].startswith("3 files are treated as one test, in sequence, although the clock restarts")


@pytest.mark.parametrize(
    "names",
    [
        ["test", "test2", "test10"],
        ["run", "run-1", "run-2"],
        ["x", "x (2)", "x (10)"],
        ["x", "x_1", "x_2"],
        ["log", "log.1", "log.2"],
        ["test.log", "test2.log"],
    ],
)
def test_first_file_has_no_number(lab, names):
    files = put(lab, **{name: table("Ff [N]", [1, 2]) for name in reversed(names)})
    made = make_run(Wanted(files, settings=[LOAD]))
    assert made.groups[0].names == tuple(f"{name}.csv" for name in names)


def test_times_in_another_order_than_the_names_are_noted(lab):
    first, second = table("Ff [N]", range(30)), table("Ff [N]", range(30)).replace(b"\n", b"\n1")
    later = second.removesuffix(b"1").replace(b"1Time", b"Time")
    made = make_run(Wanted(put(lab, a=later, b=first), settings=[LOAD]))
    assert made.notes == (
        "2 files are treated as one test in the order of their names, although their recorded times give the order "
        "b.csv, a.csv; if the times are correct, correct the order of files in run.toml",
    )


def test_files_whose_clock_goes_on_need_no_word_about_it(lab):
    first, second = table("Ff [N]", range(30)), table("Ff [N]", range(30)).replace(b"\n", b"\n1")
    made = make_run(Wanted(put(lab, a=first, b=second.removesuffix(b"1").replace(b"1Time", b"Time")), settings=[LOAD]))
    assert made.groups[0].rows == 60
    assert made.notes == ()


def test_channels_over_the_same_time_base_stand_side_by_side(lab):
    files = put(lab, force=table("Ff [N]", range(30)), wear=table("Verschleiß [µm]", range(30)))
    made = make_run(Wanted(files, settings=[LOAD, "conditions.sliding_speed=0.1 m/s"]))
    assert made.problem is None
    assert [signals["file"] for signals in document(made.folder)["signals"]] == ["force.csv", "wear.csv"]
    run = read_run(made.folder)
    assert run.columns["depth"][-1] == pytest.approx(29e-6)
    assert run.columns["friction_force"][-1] == 29


@pytest.mark.parametrize(
    ("other", "told"),
    [
        (
            table("Wear [um]", range(20)),
            "wear.csv: found 20 rows and columns that differ from those of force.csv, which has 30 rows",
        ),
        (
            table("Wear [um]", range(30)).replace(b"\n0.5,", b"\n0.55,"),
            "wear.csv: found times that differ from those in force.csv",
        ),
    ],
)
def test_files_of_different_tests_are_refused_by_name(lab, other, told):
    files = put(lab, force=table("Ff [N]", range(30)), wear=other)
    with pytest.raises(ReaderError, match=told):
        make_run(Wanted(files))
    assert set(tree_bytes(lab)) == {"force.csv", "wear.csv"}


@pytest.mark.parametrize("name", ["run.toml", "RUN.TOML"])
def test_a_file_with_the_manifest_s_name_is_refused(lab, name):
    (lab / name).write_bytes(table("Ff [N]", range(30)))
    with pytest.raises(ReaderError, match="found the same name for the manifest"):
        make_run(Wanted([lab / name]))


def test_files_of_one_name_are_refused(lab):
    for folder in ("a", "b"):
        (lab / folder).mkdir()
        put(lab / folder, same=table("Ff [N]", range(30)))
    with pytest.raises(ReaderError, match=r"same\.csv: found the same name"):
        make_run(Wanted([lab / "a" / "same.csv", lab / "b" / "same.csv"]))


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"", "found no known format"),
        (b"just words\n", "found no known format"),
        (dwf()[:-1] + b"1,0", "row|line"),
    ],
)
def test_files_that_cannot_be_read_leave_no_folder(lab, content, told):
    (lab / "odd.dwf").write_bytes(content)
    with pytest.raises(ReaderError, match=told):
        make_run(Wanted([lab / "odd.dwf"]))
    assert list(tree_bytes(lab)) == ["odd.dwf"]


def test_nothing_is_ever_overwritten(run_cli, lab, export):
    (lab / export.stem).mkdir()
    refused = run_cli("new", export)
    assert refused.exit_code == 1
    assert "found an existing folder" in refused.stderr
    assert run_cli("new", export, "--id", "another", "--into", lab / "deep" / "er").exit_code == 0
    before = tree_bytes(lab / "deep")
    assert run_cli("new", export, "--id", "another", "--into", lab / "deep" / "er").exit_code == 1
    assert tree_bytes(lab / "deep") == before
    assert set(before) == {f"er/another/{export.name}", "er/another/run.toml"}


# --- what columns mean ---


def test_columns_are_known_by_their_names_where_the_unit_fits(lab):
    names = ["Zeit [s]", "Weg [m]", "Reibkraft [N]", "µ", "Last [N]", "Temp", "Feuchte [%]", "Fluss [l]", "Speed [rpm]"]
    rows = [";".join(names), *(";".join([f"{n}.5"] * len(names)) for n in range(5))]
    (lab / "a.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    made = make_run(Wanted([lab / "a.csv"], settings=[LOAD]))
    assert document(made.folder)["signals"][0]["columns"] == {
        "time": "Zeit [s]",
        "sliding_distance": "Weg [m]",
        "normal_force": "Last [N]",
        "friction_force": "Reibkraft [N]",
        "friction_coefficient": "µ",
        "relative_humidity": "Feuchte [%]",
    }
    text = (made.folder / "run.toml").read_text(encoding="utf-8")
    assert '# temperature = { column = "Temp", unit = "degC" }' in text
    assert "its unit is unknown" in text
    assert '# Kept, but not used as signals: "Fluss [l]" (l), "Speed [rpm]" (rpm)' in text
    assert "# N, from its name" in text


def test_a_signal_by_the_format_whose_unit_is_not_known_is_left_to_the_lab(lab):
    rows = b"".join(b"%d\t0,%d\t0,1\t0,2%d\t1,1\r\n" % (n, n, n) for n in range(1, 9))
    (lab / "a.txt").write_bytes(b"Time\tDistance\t Laps\t mu\tFrictionForce\r\n" + rows)
    made = make_run(Wanted([lab / "a.txt"], settings=[LOAD]))
    assert made.problem is None
    columns = document(made.folder)["signals"][0]["columns"]
    known = {"time": "Time", "rotations": "Laps", "sliding_distance": "Distance", "friction_coefficient": "mu"}
    assert columns == known
    text = (made.folder / "run.toml").read_text(encoding="utf-8")
    assert '# friction_force = { column = "FrictionForce", unit = "mN" }' in text
    assert "from the format, its unit is unknown" in text


def test_two_columns_that_could_be_one_signal_are_left_to_the_lab(lab):
    (lab / "a.csv").write_bytes(b"Time [s],COF,mu\n1,0.5,0.6\n2,0.5,0.6\n3,0.5,0.6\n")
    made = make_run(Wanted([lab / "a.csv"], settings=[LOAD]))
    assert document(made.folder)["signals"][0]["columns"] == {"time": "Time [s]"}
    text = (made.folder / "run.toml").read_text(encoding="utf-8")
    assert '# friction_coefficient = "COF"' in text
    assert "another column could also be this signal" in text


def test_a_run_without_friction_and_depth_is_said_to_be_one(lab):
    (lab / "a.csv").write_bytes(b"Time [s],Fn [N]\n1,0.5\n2,0.5\n3,0.5\n")
    made = make_run(Wanted([lab / "a.csv"], settings=[LOAD, "conditions.sliding_speed=1 m/s"]))
    assert "found time, normal_force among the signals, but neither friction nor depth" in made.problem


def test_files_without_any_known_column_still_become_a_folder(lab):
    (lab / "a.csv").write_bytes(b"CH1,CH2\n1,0.5\n2,0.5\n3,0.5\n")
    made = make_run(Wanted([lab / "a.csv"]))
    assert made.missing == ("conditions.normal_load",)
    assert "none of which is recognized as a signal" in made.problem
    assert "[signals.columns]" in (made.folder / "run.toml").read_text(encoding="utf-8")


# --- template, settings, headers ---


def test_a_template_gives_what_stays_the_same(lab):
    (lab / "lab.toml").write_text(
        'schema = "tribopipe.template/1"\noperator = "A. \\"T\\""\n' + BODIES + '[conditions]\nmedium = "air"\n'
        'sliding_speed = { value = "0.1 m/s", standard_uncertainty = "1 %" }\n'
        '[signals]\nseparator = ";"\ndecimal = ","\ncolumns = { time = { column = "A", unit = "s" }, depth = "gone" }\n'
        "[sensors]\ndepth_scale = 0.99\n",
        encoding="utf-8",
    )
    (lab / "x.csv").write_bytes(b"A;Ft [N]\n0,5;1,0\n1,5;1,2\n2,5;1,1\n")
    made = make_run(Wanted([lab / "x.csv"], template=lab / "lab.toml", settings=["conditions.medium=oil", LOAD]))
    assert (made.missing, made.bodies_lack, made.problem) == ((), (), None)
    run = read_run(made.folder)
    assert run.manifest.operator == 'A. "T"'
    assert run.manifest.conditions.medium == "oil"
    assert run.manifest.conditions.sliding_speed.standard_uncertainty == pytest.approx(0.001)
    assert run.manifest.sensors.depth_scale.value == 0.99
    assert run.manifest.described.sliding_tip.shape == "flat"
    assert run.columns["time"].tolist() == [0.5, 1.5, 2.5]
    text = (made.folder / "run.toml").read_text(encoding="utf-8")
    assert "# from lab.toml" in text
    assert "pin_scar_diameter" not in text  # a flat pin has none


def test_a_unit_of_a_template_that_contradicts_the_file_is_noted(lab):
    columns = 'time = "Time [s]"\nfriction_force = { column = "Ft", unit = "mN" }\n'
    text = f'schema = "tribopipe.template/1"\n[signals.columns]\n{columns}'
    (lab / "lab.toml").write_text(text, encoding="utf-8")
    made = make_run(Wanted(put(lab, a=table("Ft [N]", [1, 2])), template=lab / "lab.toml", settings=[LOAD]))
    assert made.notes == ("a.csv: column 'Ft [N]' is in N in the file, but is read in mN as stated in lab.toml",)


@pytest.mark.parametrize(
    ("written", "told"),
    [
        (
            '[conditions]\nnormal_laod = "5 N"',
            r"lab\.toml: conditions\.normal_laod: unknown key; did you mean 'normal_",
        ),
        ('[conditions]\nnormal_load = "5 mm"', r"lab\.toml: conditions\.normal_load: found the unit 'mm'"),
        ("[signals]\ncolumns.tme = 'x'", r"signals\.columns\.tme: unknown key; did you mean 'time'"),
        ("id = 'x'", "id: unknown key"),
        ("[conditions]\nstroke = '1 mm'\ntrack_radius = '3 mm'", "stroke: found stroke in addition to track_radius"),
        ("[conditions", "invalid TOML"),
    ],
)
def test_a_template_that_cannot_be_is_refused_with_the_key(lab, export, written, told):
    (lab / "lab.toml").write_text(f'schema = "tribopipe.template/1"\n{written}\n', encoding="utf-8")
    with pytest.raises(ManifestError, match=told):
        make_run(Wanted([export], template=lab / "lab.toml"))


@pytest.mark.parametrize(
    ("setting", "told"),
    [
        ("conditions.normal_load", "found no '='"),
        ("conditions.normal_laod=5 N", "did you mean 'normal_load'"),
        ("conditions.load=5 N", r"did you mean 'normal_load'\?"),  # and no key of a four-ball test
        ("conditions.normal_load=5", "without a unit|bare number"),
        ("conditions=5 N", "a key that cannot be set; expected a key such as conditions.normal_load"),
        ("signals.reader=x", "a key that cannot be set"),
        ("contact.pin.radius.value=x", "a key that cannot be set"),
        ("id=x", "a key that cannot be set"),
        ("conditions.normal_load={ value = '5 mm' }", "found the unit 'mm'"),
    ],
)
def test_settings_that_cannot_be_are_refused(export, setting, told):
    with pytest.raises(ManifestError, match=told):
        make_run(Wanted([export], settings=[setting]))


def test_a_body_of_another_tribometer_is_refused_with_those_of_this_one(export):
    with pytest.raises(ManifestError, match=r"contact\.disc: unknown key; available: flat, kind, pin$"):
        make_run(Wanted([export], settings=["contact.kind=reciprocating", "contact.disc.material=steel"]))


@pytest.mark.parametrize("order", [1, -1])
def test_a_ball_that_a_person_describes_is_a_spherical_pin(order):
    settings = ["contact.kind=reciprocating", "contact.ball.diameter=6 mm", "contact.ball.material=Al2O3"]
    values = gather({}, "", settings[::order], []).values
    pin = {name: values[f"contact.pin.{name}"] for name in ("shape", "radius", "material")}
    assert pin == {"shape": "spherical", "radius": "3 mm", "material": "Al2O3"}


BALL = """\
schema = "tribopipe.template/1"
[contact]
kind = "{kind}"
[contact.ball]
diameter = {{ value = "6 mm", standard_uncertainty = "0.1 %" }}
material = "Al2O3"
"""


@pytest.mark.parametrize("kind", ["pin-on-disc", "reciprocating"])
def test_a_ball_of_a_template_is_a_pin_of_its_diameter(lab, kind):
    (lab / "lab.toml").write_text(BALL.format(kind=kind), encoding="utf-8")
    known = gather(read_template(lab / "lab.toml"), "lab.toml", [LOAD], [])
    radius = {"value": "3 mm", "standard_uncertainty": "0.003 mm"}
    found = {key: known.values[f"contact.pin.{key}"] for key in ("shape", "radius", "material")}
    assert found == {"shape": "spherical", "radius": radius, "material": "Al2O3"}


def test_a_template_with_a_ball_and_a_pin_is_refused(lab):
    (lab / "lab.toml").write_text(BALL.format(kind="pin-on-disc") + "[contact.pin]\n", encoding="utf-8")
    with pytest.raises(ManifestError, match=r"contact\.ball: found a ball in addition to a pin"):
        read_template(lab / "lab.toml")


def test_keys_that_a_template_may_have_are_those_of_its_contact(lab):
    (lab / "lab.toml").write_text(BALL.format(kind="reciprocating") + "[contact.disc]\n", encoding="utf-8")
    with pytest.raises(ManifestError, match=r"contact\.disc: unknown key; (?!.*flat_disc)"):
        read_template(lab / "lab.toml")


def test_the_template_of_the_documentation_is_one(tmp_path):
    told = (ROOT / "docs" / "new_run.md").read_text(encoding="utf-8")
    (written,) = re.findall(r"(?s)```toml\n(.*?)```", told)
    (tmp_path / "lab.toml").write_text(written, encoding="utf-8")
    template = read_template(tmp_path / "lab.toml")
    assert template == tomllib.loads(written)
    known = gather(template, "lab.toml", [LOAD], [])
    assert (known.missing, known.bodies_lack) == ([], [])


def export_of(name: str, facts: dict[str, str], columns=(("time", "s"), ("friction_force", "N"))) -> Export:
    read = tuple(ReadColumn(column, np.arange(3.0), unit) for column, unit in columns)
    reader = reader_named("delimited")
    return Export(SourceFile(name, b""), reader, Match(0.7, "why"), (), ReadTable(read, facts=facts))


def drafted(*exports: Export, template=None, settings=()) -> tuple[Known, str]:
    known = gather(template or {}, "lab.toml", settings, exports)
    return known, manifest_text(Draft("run", [Group(exports)], known))


def test_headers_go_before_the_template_and_a_person_before_both():
    facts = {"conditions.normal_load": "10 N", "conditions.temperature": "23 degC", "started": "2022-05-12T12:21:58"}
    template = {"conditions": {"normal_load": "5 N", "temperature": "20 degC", "medium": "air"}}
    _, text = drafted(export_of("a.txt", facts), template=template, settings=["conditions.temperature=30 degC"])
    told = tomllib.loads(text)
    assert told["conditions"] == {"normal_load": "10 N", "medium": "air", "temperature": "30 degC"}
    assert told["started"].isoformat() == facts["started"]
    assert "# from a.txt; lab.toml gives 5 N" in text
    assert "# a.txt gives 23 degC" in text


def test_headers_that_differ_are_commented_with_both_names():
    said = [{"conditions.normal_load": f"{n} N", "started": f"2022-05-1{n}"} for n in (1, 2)]
    exports = [export_of(f"{n}.txt", facts) for n, facts in enumerate(said, 1)]
    known, text = drafted(*exports)
    assert known.missing == ["conditions.normal_load"]
    assert "conditions.normal_load" not in known.given
    assert re.search('(?m)^# normal_load = "1 N" +# given by 1.txt; the files do not agree$', text)
    assert re.search('(?m)^# normal_load = "2 N" +# given by 2.txt', text)
    assert str(tomllib.loads(text)["started"]) == "2022-05-11"


def test_facts_that_cannot_be_are_commented():
    facts = {
        "conditions.normal_load": "0 N",
        "conditions.stroke": "1 mm",
        "conditions.track_radius": "3 mm",
        "odd.x": "1",
    }
    _, text = drafted(export_of("a.txt", facts))
    assert tomllib.loads(text)["conditions"] == {"stroke": "1 mm"}
    assert '# normal_load = "0 N"' in text
    assert "a positive value" in text
    assert "found stroke in addition to track_radius" in text
    assert '# odd.x = "1"' in text


def test_half_described_bodies_stay_commented_until_they_are_whole():
    known, text = drafted(export_of("a.txt", {"contact.pin.material": "100Cr6", "contact.pin.radius": "3 mm"}))
    assert "contact" not in tomllib.loads(text)
    assert '# material = "100Cr6"' in text
    answers = answering("5 N", "1 m/s", "spherical", "210 GPa", "0.3", "steel", "210 GPa", "0.3")
    ask_for_missing(known, answers, str)
    assert known.bodies_lack == []
    whole = tomllib.loads(manifest_text(Draft("run", [Group((export_of("a.txt", {}),))], known)))
    assert whole["contact"]["pin"] == {
        "shape": "spherical",
        "radius": "3 mm",
        "material": "100Cr6",
        "youngs_modulus": "210 GPa",
        "poisson_ratio": 0.3,
    }


@pytest.mark.parametrize(
    "motion",
    [
        {"conditions.stroke": "1.5 mm", "conditions.frequency": "25 Hz"},
        {"conditions.rotational_speed": "197 rpm", "conditions.track_radius": "8 mm"},
        {"conditions.rotational_speed": "197 rpm", "contact.ring.radius": "17.5 mm"},
    ],
)
def test_a_speed_that_follows_from_the_motion_is_not_asked_for(motion):
    known, asked = drafted(export_of("a.txt", {}))[0], answering("5 N")
    for key, value in motion.items():
        assert known.take(key, value) is None
    ask_for_missing(known, asked, str)
    assert not any(question.startswith("conditions.sliding_speed") for question in asked.asked)


def test_only_the_lines_that_apply_are_to_be_uncommented():
    text = drafted(export_of("a.txt", {"contact.pin.material": "100Cr6"}))[1]
    assert "# at the start of the names of these tables, and of the lines that apply: lines without a source" in text


def test_times_that_are_no_numbers_are_reported_with_their_line(run_cli, lab):
    put(lab, a=table("Depth [um]", range(50)).replace(b"4.9,", b"a while later,"))
    made = run_cli("new", "a.csv", "--set", LOAD)
    assert made.exit_code == 0, made.stderr
    assert "still to be corrected: a.csv, line 51, column 'Time [s]': found 'a while later'" in made.stderr


TEXTS = st.text(max_size=30)
FACTS = st.dictionaries(
    st.sampled_from(
        ["title", "operator", "comment", "instrument", "conditions.medium", "conditions.normal_load", "started"]
    )
    | TEXTS,
    TEXTS | st.sampled_from(['"quoted"', "a\nb = 1", "5 N", "true", "1e3", "2022-01-01", "\x1b[0m", "'''", "\\"]),
    max_size=6,
)


@pytest.mark.slow
@given(facts=FACTS, name=TEXTS.filter(bool), column=TEXTS.map(str.strip).filter(bool))
@settings(max_examples=20)
def test_whatever_headers_and_names_hold_the_manifest_parses_back_equal(facts, name, column):
    known, text = drafted(export_of(name, facts, ((column, "N"), ("time", "s"))))
    told = tomllib.loads(text)
    assert told["signals"][0]["file"] == name
    assert told["signals"][0]["columns"]["time"] == "time"
    for key, value in known.values.items():
        assert reduce(lambda table, name: table[name], key.split("."), told) == value
        assert value in (facts[key], value_of(facts[key]))


@given(st.recursive(TEXTS | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False),
                    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(TEXTS, inner, max_size=3)))  # fmt: skip
@settings(max_examples=100)
def test_values_parse_back_equal(value):
    assert tomllib.loads(f"x = {toml(value)}")["x"] == value


@given(TEXTS)
def test_comments_stay_comments(text):
    assert tomllib.loads(f"x = 1 # {comment(text)}\n") == {"x": 1}


def test_every_blank_is_a_key_with_an_example_that_fits():
    for key, blank in BLANKS.items():
        rolls = any(part in key for part in ("curved_disc", "flat_disc", "slip", "rotations"))
        beside = {"contact.kind": "twin-disc" if rolls else "pin-on-disc"}
        if key == "contact.pin.flat_radius":
            beside["contact.pin.shape"] = "truncated-sphere"
        assert problem_of(beside | {key: blank.value}) is None, key


def test_twin_discs_of_a_template_have_their_own_keys():
    template = {"contact": {"kind": "twin-disc", "curved_disc": {"rolling_radius": "20 mm"}}}
    known, text = drafted(export_of("a.txt", {}), template=template)
    assert known.missing == ["conditions.normal_load", "conditions.slip"]
    assert "# slip = " in text
    assert "stroke" not in text
    assert "pin_" not in text
    assert "contact.pin" not in text
    assert "# curved_disc_wear_depth" in text


# --- readers and profiles ---


def test_a_described_reader_goes_with_the_run(lab):
    (lab / "rigs").mkdir()
    (lab / "rigs" / "our-rig.toml").write_text(
        'schema = "tribopipe.reader/1"\nname = "our-rig"\ntitle = "Our rig"\n'
        '[columns.A]\nsignal = "time"\nunit = "s"\n[columns.B]\nsignal = "friction_force"\nunit = "N"\n',
        encoding="utf-8",
    )
    (lab / "lab.toml").write_text(
        'schema = "tribopipe.template/1"\n[signals]\nreader = "rigs/our-rig.toml"\n', encoding="utf-8"
    )
    (lab / "x.csv").write_bytes(b"A,B\n0.5,1.0\n1.5,1.2\n2.5,1.1\n")
    for number, how in enumerate([{"reader": "rigs/our-rig.toml"}, {"template": Path("lab.toml")}]):
        made = make_run(Wanted([Path("x.csv")], id=f"run-{number}", settings=[LOAD], **how))
        assert set(tree_bytes(made.folder)) == {"our-rig.toml", "run.toml", "x.csv"}
        assert document(made.folder)["signals"][0]["reader"] == "our-rig.toml"
        assert read_run(made.folder).columns["friction_force"].tolist() == [1.0, 1.2, 1.1]


def test_a_template_against_the_format_is_said_to_be_so(lab):
    (lab / "our-rig.toml").write_text(
        'schema = "tribopipe.reader/1"\nname = "our-rig"\ntitle = "Our rig"\n[columns]\nA = { signal = "time" }\n'
        'B = { signal = "depth", scale = -1.0 }\n',
        encoding="utf-8",
    )
    (lab / "lab.toml").write_text(
        'schema = "tribopipe.template/1"\n[signals]\nreader = "our-rig.toml"\ncolumns = { depth = "B" }\n',
        encoding="utf-8",
    )
    (lab / "x.txt").write_bytes(b"A [s];B [um]\n0;0.5\n1;0.6\n2;0.7\n")
    text = (make_run(Wanted([lab / "x.txt"], template=lab / "lab.toml")).folder / "run.toml").read_text("utf-8")
    assert "# µm, from lab.toml; the format defines 'B [um], calibrated' as this signal" in text


def test_a_reader_that_is_not_there_is_refused_with_the_nearest(export):
    with pytest.raises(ReaderError, match="did you mean 'ducom-winducom'"):
        make_run(Wanted([export], reader="ducom-windcom"))


PROFILE = "".join(f"{n * 0.001:.3f}\t{(n % 7) * 0.01:.3f}\n" for n in range(200)).encode()


def test_profiles_are_taken_as_end_values_of_the_body_named(lab, export):
    for name in ("a.txt", "b.txt"):
        (lab / name).write_bytes(PROFILE)
    known_profile = [f"disc={lab / name}" for name in ("a.txt", "b.txt")]
    made = make_run(Wanted([export], settings=[LOAD], profiles=known_profile))
    assert document(made.folder)["end_values"] == {"disc_profile": [{"file": "a.txt"}, {"file": "b.txt"}]}
    assert (made.folder / "b.txt").read_bytes() == PROFILE


def test_a_profile_among_the_files_is_left_to_the_lab(lab, export):
    (lab / "a.txt").write_bytes(PROFILE)
    made = make_run(Wanted([export, lab / "a.txt"], settings=[LOAD]))
    assert "end_values" not in document(made.folder)
    assert '# disc_profile = { file = "a.txt" }' in (made.folder / "run.toml").read_text(encoding="utf-8")
    assert (made.folder / "a.txt").exists()
    with pytest.raises(ReaderError, match=r"a\.txt: found a profile .* at least one signal file"):
        make_run(Wanted([lab / "a.txt"]))


@pytest.mark.slow
@pytest.mark.parametrize("names", [b"x [mm],z [um]\n", b"Across [mm],Up [um]\n"])
def test_a_profile_in_a_table_is_taken_where_its_columns_can_be_told(lab, export, names):
    (lab / "a.csv").write_bytes(names + PROFILE.replace(b"\t", b","))
    made = make_run(Wanted([export], settings=[LOAD], profiles=[f"disc={lab / 'a.csv'}"]))
    assert document(made.folder)["end_values"] == {"disc_profile": {"file": "a.csv"}}
    assert (made.problem, list(read_run(made.folder).profiles)) == (None, ["end_values.disc_profile"])


def test_profiles_whose_columns_are_named_wait_for_them_and_none_is_lost(lab, export):
    files = [lab / f"track-at-{angle}-degrees.csv" for angle in (0, 90, 180, 270)]
    for file in files:
        file.write_bytes(b"Across [mm],Up [um],Down [um]\n" + PROFILE.replace(b"\t", b",").replace(b"\n", b",0\n"))
    made = make_run(Wanted([export], settings=[LOAD], profiles=[f"disc={file}" for file in files]))
    text = (made.folder / "run.toml").read_text(encoding="utf-8")
    (line,) = [line for line in text.splitlines() if line.startswith("# disc_profile")]
    assert all(file.name in line for file in files)
    assert tomllib.loads(line.removeprefix("# "))["disc_profile"][3]["position"] == "…"
    assert made.notes[-1].startswith("end_values.disc_profile is commented out in run.toml: specify the columns")
    assert '"Across [mm]", "Up [um]"' in made.notes[-1]


@pytest.mark.parametrize(("written", "told"), [("a.txt", "found no '='"), ("bisc=a.txt", "'bisc'.*mean 'disc'")])
def test_a_profile_of_no_body_is_refused(export, written, told):
    with pytest.raises(ManifestError, match=told):
        make_run(Wanted([export], profiles=[written]))


# --- ids ---


@pytest.mark.parametrize(
    ("file", "run_id"),
    [
        ("1-2-MoS2-5.0-Al2O3-Al10Cu-50N-.dwf", "1-2-MoS2-5.0-Al2O3-Al10Cu-50N"),
        ("Prüfung 3 (Öl).txt", "Prufung-3-Ol"),
        ("Größe Nr. 7.csv", "Grosse-Nr.-7"),
        ("con.csv", "run-con"),
        ("测试.csv", "run-"),
        ("no suffix 2.5", "no-suffix-2.5"),
        ("..hidden.", "hidden"),
    ],
)
def test_ids_are_made_from_names_of_files(file, run_id):
    assert fit_for_id(file) == run_id


@given(st.text(max_size=200))
def test_every_name_gives_a_usable_id(file):
    frame = {"schema": "tribopipe.run/1", "id": fit_for_id(file), "conditions": {"normal_load": "1 N"}}
    RunManifest.model_validate(frame | {"signals": [{"file": "x"}]})


def test_an_id_that_cannot_be_is_refused_before_anything_is_asked(export):
    ask = answering()
    with pytest.raises(ManifestError, match="id: found 'a/b'"):
        make_run(Wanted([export], id="a/b"), ask)
    assert ask.asked == []


def test_given_by_a_person_has_no_origin():
    known = Known()
    assert known.take("conditions.normal_load", "5 N") is None
    assert known.given == {"conditions.normal_load": Given("5 N")}

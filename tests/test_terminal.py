"""What people see on a terminal: results on stdout, no line wider than the window, an answer on one screen."""

import json
import os
import re
import shlex
import shutil
import struct
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import pytest
from terminal_session import MARK

from tribopipe.base.column_formatting import in_power, number_column, power_for, rounded_value
from tribopipe.cli.output import _width, seen
from tribopipe.evaluation.checks.registry import CHECKS, load_checks
from tribopipe.results.finding import TITLES, title

LIGHT, HEAVY = "si3n4-air-200mN", "si3n4-air-400mN"
CODES = re.compile("\x1b\\[[0-9;?]*[A-Za-z]")
STUDY = f"""schema = "tribopipe.study/1"
id = "air"
fit = ["{LIGHT}"]
predict = ["{HEAVY}"]
laws = ["archard", "sarkar"]
"""
COMMANDS = {
    "": 30,
    "--help": 90,
    "process runs --no-figures": 1,
    "process runs --no-figures -v": None,
    "process runs --no-figures -vv": None,
    "ls": 30,
    "ls --all": 30,
    "ls --columns id,load,k_d,k_d_sarkar,wear_volume,disc_wear_volume,started,agreement": None,
    "ls --columns help": None,
    f"show {HEAVY}": 40,
    f"show {HEAVY} -v": None,
    f"show {HEAVY} --path /entry/wear_fit_archard": None,
    "study show": 30,
    "study show air": 30,
    "study show air -v": None,
    "study run air.study.toml --no-figures": 30,
    "check runs": None,
    "ingest runs": None,
    "correct-drift": None,
    "fit": None,
    "fit --force": None,
    f"fit {LIGHT} {HEAVY} --together": 30,
    f"predict {LIGHT} --load 800mN --at 50m": None,
    f"predict --from {LIGHT} --onto {HEAVY}": 30,
    f"plan {LIGHT} --interval 10%": None,
    f"tag {LIGHT} --add run-in": None,
    f'note {LIGHT} "The disc rang from 30 m on, and so did the arm of the tribometer, which nobody had clamped."': None,
    f"mark-bad {HEAVY} --reason slipped": None,
    f"mark-bad {HEAVY} --undo --reason held": None,
    f"remove {HEAVY} --force": None,
    f"restore {HEAVY}": None,
    "verify": None,
    f"reproduce {LIGHT}": 30,
    "study new runs --into drafted": None,
    "simulate virtual --plan plan.toml": 30,
    f"live runs/{LIGHT} --once": None,
    f"local-wear {LIGHT} --steps-per-decade 2": None,
    f"report {LIGHT} --output report.html": None,
    f"export csv {LIGHT} --what fit --output csv": None,
    "export dataset --eln book.eln --no-report": None,
    f"export umeshmotion {LIGHT} --output abaqus": None,
    "formats list": None,
    f"formats detect runs/{LIGHT}/signals.csv": None,
    f"new runs/{LIGHT}/signals.csv --into made": None,
    "schema export schemas": None,
    "help": None,
    "help reading_settles": None,
    **{f"{command} --help": None for command in ("process", "predict", "export", "study run", "sweep", "live")},
}
"""Commands with the lines that their answer may take."""
MESSAGES_ONLY = (
    *("process runs --no-figures", "correct-drift", "fit", "new", "restore", "export dataset", "report", "remove"),
    *("note", "tag", "mark-bad", "live"),
)
"""Commands that may have nothing but messages, or what follows a test, to tell."""
LONG = (
    *("fit", "predict --from", "reproduce", "local-wear", "live", "export dataset", "export umeshmotion", "report"),
    *("verify", "simulate", "schema", "process runs --no-figures -", "ls --columns", "plan", "remove", "restore"),
    *("tag", "note", "mark-bad", "ingest", "correct-drift", "export", "new", "study new", "study run", "formats"),
)
"""Commands that take long or show what others do, and so are run among the slow tests alone."""
WIDTHS = (
    pytest.param((80, False), id="80"),
    pytest.param((80, True), id="80, all", marks=pytest.mark.slow),
    pytest.param((120, True), id="120, all", marks=pytest.mark.slow),
)


@dataclass(frozen=True)
class Told:
    """What a command put on each stream, as a terminal shows it, and how it ended."""

    stdout: str
    stderr: str
    code: int

    @property
    def lines(self) -> list[str]:
        return [*shown(self.stdout), *shown(self.stderr)]


def shown(text: str) -> list[str]:
    """Return the lines that are left on a terminal, which are all but those of a progress bar."""
    if not text:
        return []
    lines = (line.rpartition("\r")[2] for line in CODES.sub("", text.replace("\r\n", "\n")).split("\n"))
    return [line for line in lines if "━" not in line and not line.startswith(MARK)][
        : None if text[-1:] != "\n" else -1
    ]


@pytest.fixture(scope="module")
def lab(short_runs, short_plan, tmp_path_factory) -> Path:
    """A folder with two short runs, a study of them, and the archive of both."""
    folder = tmp_path_factory.mktemp("lab")
    shutil.copytree(short_runs, folder / "runs")
    shutil.copy(short_plan, folder / "plan.toml")
    (folder / "air.study.toml").write_text(STUDY, encoding="utf-8")
    shutil.copy(folder / "air.study.toml", folder / "runs")
    return folder


@pytest.fixture(scope="module")
def processed(lab) -> Told:
    """The first `process` of the runs, at 80 columns."""
    return seen_at(80, lab, ["process runs --no-figures"])[0]


@pytest.fixture(scope="module", params=WIDTHS)
def session(request, lab, processed, tmp_path_factory) -> tuple[int, dict[str, Told]]:
    """What every command shows at a width, in a copy of the folder."""
    assert processed.code == 0
    folder = tmp_path_factory.mktemp("width") / "lab"
    shutil.copytree(lab, folder)
    width, with_long = request.param
    commands = [one for one in COMMANDS if with_long or not one.startswith(LONG)]
    return width, dict(zip(commands, seen_at(width, folder, commands), strict=True))


def seen_at(width: int, folder: Path, commands: list[str]) -> list[Told]:
    """Run commands in a pseudo-terminal of a width, stdout and stderr each in one of its own."""
    plan = folder.parent / f"{folder.name}-commands.json"
    plan.write_text(json.dumps([shlex.split(command) for command in commands]), encoding="utf-8")
    line = [sys.executable, str(Path(__file__).parent / "terminal_session.py"), str(plan)]
    places = [str(Path(__file__).parents[1]), str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")]
    environment = {name: value for name, value in os.environ.items() if name not in ("COLUMNS", "NO_COLOR", "LINES")}
    environment |= {"PYTHONPATH": os.pathsep.join(filter(None, places)), "TERM": "xterm", "MPLBACKEND": "Agg"}
    out, err = in_terminals(line, width, folder, environment)
    codes = [part[0] for part in err.split(MARK)[1:]]
    errors = [part[1:] if number else part for number, part in enumerate(err.split(MARK))]
    return [
        Told(stdout, stderr, int(code))
        for stdout, stderr, code in zip(out.split(MARK)[1:], errors, codes, strict=False)
    ]


def in_terminals(line: list[str], width: int, folder: Path, environment: dict[str, str]) -> tuple[str, str]:
    """Run a program whose stdout and stderr are pseudo-terminals, and return what it wrote on each."""
    fcntl, pty, termios = (pytest.importorskip(name) for name in ("fcntl", "pty", "termios"))
    pairs = [pty.openpty(), pty.openpty()]
    for _, slave in pairs:
        fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 50, width, 0, 0))
    (_, out), (_, err) = pairs
    with (
        ThreadPoolExecutor(2) as readers,
        subprocess.Popen(
            line, cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=out, stderr=err
        ) as running,
    ):
        for _, slave in pairs:
            os.close(slave)
        written = [readers.submit(read_all, master) for master, _ in pairs]
        running.wait(timeout=300)
        return written[0].result(timeout=30), written[1].result(timeout=30)


def read_all(master: int) -> str:
    """Read what a pseudo-terminal shows until nobody writes to it any more."""
    written = b""
    with suppress(OSError):
        while part := os.read(master, 65536):
            written += part
    os.close(master)
    return written.decode("utf-8")


# --- every command ---


@pytest.mark.slow
def test_no_line_is_wider_than_the_terminal(session):
    width, told = session
    wide = [(command, line) for command, one in told.items() for line in one.lines if _width(line) > width]
    assert wide == []


def test_answers_take_no_more_lines_than_a_screen(session):
    _, told = session
    long = {
        command: len(one.lines)
        for command, one in told.items()
        if (most := COMMANDS[command]) and len(one.lines) > most
    }
    assert long == {}


def test_commands_end_well_and_results_are_on_stdout(session):
    _, told = session
    failed = {command: one for command, one in told.items() if one.code and not command.startswith(("verify", "check"))}
    assert failed == {}
    empty = [
        command
        for command, one in told.items()
        if not CODES.sub("", one.stdout).strip() and not any(command.startswith(name) for name in MESSAGES_ONLY)
    ]
    assert empty == []


def test_help_cuts_no_sentence_off(session):
    _, told = session
    listed = told["--help"].stdout
    assert "..." not in listed.partition("COMMAND [ARGS]...")[2]
    assert "…" not in listed
    for panel in ("Workflow:", "Results:", "Studies:", "Archive maintenance:", "Simulation:"):
        assert f"\n{panel}\n" in listed.replace("\r\n", "\n")


def test_tables_lose_no_name_of_a_run(session):
    _, told = session
    for command in ("ls", "process runs --no-figures -v", "study show air", "ls --columns " + "id"):
        if command in told:
            text = CODES.sub("", told[command].stdout)
            assert LIGHT in text
            assert HEAVY in text


def test_nothing_is_minus_zero(session):
    _, told = session
    zeros = [
        (command, line)
        for command, one in told.items()
        for line in shown(one.stdout)
        if re.search(r"(?<![\d.×(])[-−]0(\.0*)?(?![\d.])", line)
    ]
    assert zeros == []


# --- process ---


def test_process_answers_in_a_row_per_run_and_one_per_study(processed):
    lines = shown(processed.stdout)
    assert lines[0].startswith("2 runs; k_D from Archard's law in 10")
    assert [len([line for line in lines if line.startswith(f" {run} ")]) for run in (LIGHT, HEAVY, "air")] == [1, 1, 1]
    (light,) = [line.split() for line in lines if line.startswith(f" {LIGHT} ")]
    assert light[1] == "200"
    assert light[3] == "±"
    assert "fitted" in light
    assert len(processed.lines) <= 30
    assert re.search(r"\d+ steps done, 0 unchanged, in archive", " ".join(shown(processed.stderr)))
    assert "Next: `tribopipe " in " ".join(shown(processed.stderr))


def test_nothing_to_do_is_one_line(session):
    _, told = session
    again = told["process runs --no-figures"]
    assert [line for line in again.lines if line.strip()] == [
        next(line for line in again.lines if line.startswith("Nothing to do: all "))
    ]


# --- numbers beneath each other ---


@pytest.mark.parametrize(
    ("numbers", "power", "cells"),
    [
        ([(1.358e-8, 2.5e-10), (7.85e-12, 8.2e-13), None], -12, ("13580 ± 250", " 7.85 ± 0.82", "–")),
        ([(1.358e-8, 2.5e-10), (9.65e-9, 1.9e-10)], -9, ("13.58 ± 0.25", " 9.65 ± 0.19")),
        (
            [(0.4951, 0.005), (0.384, 0.03), (-0.00001, 0.02)],
            0,
            ("0.4951 ± 0.0050", " 0.384 ± 0.030", " 0.000 ± 0.020"),
        ),
        ([(200.0, None), (1600.0, 16.0)], 0, (" 200", "1600 ± 16")),
        ([(0.0, 0.1)], 0, ("0.00 ± 0.10",)),
        ([], 0, ()),
    ],
)
def test_a_column_has_one_power_and_digits_by_uncertainty(numbers, power, cells):
    assert number_column(numbers) == (power, cells)


def test_numbers_too_far_apart_have_powers_of_their_own():
    numbers = [(1e-2, 1e-4), (1e-12, 1e-13)]
    assert power_for(numbers) is None
    assert number_column(numbers).cells == ("(1.000 ± 0.010)×10⁻²", "(1.00 ± 0.10)×10⁻¹²")
    assert in_power(numbers, None).unit("mN") == "mN"


@pytest.mark.parametrize(
    ("number", "written"),
    [((249.95, 2.5), "250"), ((0.4189, 0.0082), "0.419"), ((1600.0, 16.0), "1600"), ((0.2, None), "0.2")],
)
def test_a_value_alone_has_the_digits_that_are_sure(number, written):
    assert rounded_value(number) == written


# --- findings in short ---


def test_every_check_has_a_title():
    load_checks()
    own = {code for code, (_, check) in CHECKS.items() if check is not None} - {"steady_room"}
    assert own - set(TITLES) == set()
    assert title("steady-room") == "steady room"
    assert max(map(len, TITLES.values())) <= 52
    assert all(seen(one) == one for one in TITLES.values())


# --- errors, and runs with the same findings or without k_D ---


def test_errors_are_wrapped_to_the_terminal(tmp_path):
    (told,) = seen_at(80, tmp_path, ["ls"])
    assert told.code == 1
    assert told.lines[0].startswith("error: archive: found no archive")
    assert max(map(_width, told.lines)) <= 80


@pytest.fixture
def without_bodies(short_runs, tmp_path) -> Path:
    """A folder with two runs that do not describe the bodies."""
    for run_id in (LIGHT, HEAVY):
        shutil.copytree(short_runs / run_id, tmp_path / "runs" / run_id)
        described = tmp_path / "runs" / run_id / "run.toml"
        tables = re.split(r"(?m)^(?=\[)", described.read_text(encoding="utf-8"))
        kept = [table for table in tables if not table.startswith(("[contact", "[end_values"))]
        described.write_text("".join(kept), encoding="utf-8")
    return tmp_path


@pytest.mark.slow
def test_process_and_check_name_what_is_missing_and_repeat_no_sentence(without_bodies):
    checked, processed = seen_at(80, without_bodies, ["check runs", "process runs --no-figures"])
    assert any(line.startswith(f"{HEAVY}: ") and line.endswith(f": same as {LIGHT}") for line in checked.lines)
    assert f"no k_D, missing the two bodies ([contact]): {LIGHT}, {HEAVY}" in processed.lines

"""No text of a lab steers the terminal: not what run.toml, a note, the name of a file or the command line holds."""

import re
import shutil
import sys
import tomllib
from collections.abc import Iterator
from copy import deepcopy
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from hostile_runs import hostile_archive
from pydantic import ValidationError
from sweeps import others_slow
from test_cli_contract import FLAGS

from tribopipe.archive.lock import say_waiting
from tribopipe.base.errors import ManifestError
from tribopipe.cli.entry_point import _told
from tribopipe.cli.options import archived_ids
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.record import Record
from tribopipe.readers.draft.known_values import toml

RUN = "si3n4-air-200mN"
NASTY = "red \x1b[31m\x1b]0;owned\x07\x9b2J\r\u202e\x7fend"
BOLD = re.compile("\x1b\\[[01]m")
STEERS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")


@pytest.fixture
def on_terminal(run_cli, monkeypatch):
    """Run a command with a terminal as stdout, so that nothing is taken off what is written to it."""

    def run(*words):
        with monkeypatch.context() as patch:
            patch.setattr("sys.stdout.isatty", lambda: True)
            patch.setenv("COLUMNS", "100")
            return run_cli(*words)

    return run


def steering(told) -> list[str]:
    """Return what steers the terminal in what a command wrote."""
    return STEERS.findall(BOLD.sub("", told.stdout)) + STEERS.findall(told.stderr)


# --- run.toml ---


def text_places(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Give where a record has a text, or may have one."""
    if isinstance(value, Record):
        inner = [(name, getattr(value, name)) for name in type(value).model_fields]
    elif isinstance(value, dict):
        inner = list(value.items())
    elif isinstance(value, list | tuple):
        inner = list(enumerate(value))
    else:
        inner = []
        if value is None or isinstance(value, str):
            yield path
    for name, one in inner:
        yield from text_places(one, (*path, name))


def with_text(document: dict, path: tuple[Any, ...], text: str) -> dict:
    """Return a document with a text at a place. Raises ``TypeError`` where it has none there."""
    changed = deepcopy(document)
    at: Any = changed
    for name in path[:-1]:
        at = at[name]
    at[path[-1]] = text
    return changed


def hostile_documents(document: dict) -> tuple[dict, list[tuple[Any, ...]]]:
    """Return a run.toml with a hostile text wherever that is taken, and those places."""
    taken = []
    for path in text_places(RunManifest.model_validate(document)):
        try:
            changed = with_text(document, path, NASTY)
            RunManifest.model_validate(changed)
        except (ValidationError, ManifestError, TypeError, KeyError):
            continue
        document, taken = changed, [*taken, path]
    return document, taken


def hostile_run(folder: Path, into: Path, *, signals: bool) -> Path:
    """Copy a run folder with a hostile text wherever run.toml takes one, names of columns only where that is wanted."""
    shutil.copytree(folder, into)
    given = tomllib.loads((folder / "run.toml").read_text(encoding="utf-8"))
    document, taken = hostile_documents(given)
    assert {path[0] for path in taken} >= {"title", "operator", "instrument", "comment", "contact", "conditions"}
    assert any(path[0] == "signals" for path in taken)
    if not signals:
        document = document | {"signals": given["signals"]}
    text = "".join(f"{key} = {toml(value)}\n" for key, value in document.items())
    (into / "run.toml").write_text(text, encoding="utf-8", newline="\n")
    return into


# --- every command ---

AT = ["--archive", "archive"]
COMMANDS: dict[str, list[list[str]]] = {
    "formats list": [[]],
    "formats detect": [["columns/signals.csv"]],
    "new": [["bare.csv", "--into", "made", "--set", f"title={NASTY}"]],
    "check": [["texts", "columns"]],
    "ingest": [["texts", "columns", "--archive", "made"]],
    "process": [["texts", "columns", "--archive", "made", "--recipe", "recipe.toml"]],
    "simulate": [["made", "--plan", "plan.toml"]],
    "correct-drift": [[RUN, *AT]],
    "fit": [[RUN, *AT, "--recipe", "recipe.toml"]],
    "predict": [[RUN, *AT], ["--run", "columns", "--wear-coefficient", NASTY]],
    "local-wear": [[RUN, *AT, "--steps-per-decade", "2"]],
    "ls": [AT, [*AT, "--json"], [*AT, "--where", f"title={NASTY}"], [*AT, "--columns", NASTY]],
    "mark-bad": [[RUN, *AT, "--reason", NASTY, "--by", NASTY]],
    "tag": [[RUN, *AT], [RUN, *AT, "--add", NASTY]],
    "note": [[RUN, NASTY, "--by", NASTY, *AT]],
    "show": [[RUN, *AT], [RUN, *AT, "--json"], [RUN, *AT, "--path", "/"], [RUN, *AT, "--path", NASTY]],
    "study new": [["texts", "columns", "--into", "made"]],
    "study run": [["study.toml", *AT, "--recipe", "recipe.toml", "--no-figures"]],
    "study show": [["x", *AT], ["x", *AT, "--json"]],
    "study figures": [["x", "--into", "made", *AT]],
    "sweep": [["sweep.toml", *AT, "--dry-run"]],
    "plan": [[RUN, *AT, "--interval", "5 %"]],
    "export umeshmotion": [[RUN, "--output", NASTY, "--wear-coefficient", "13.5e-9 mm^3/(N*mm)", *AT]],
    "export csv": [[RUN, "--output", NASTY, *AT], [RUN, "--what", NASTY, *AT]],
    "export runs": [AT, [*AT, "--output", NASTY]],
    "export dataset": [["--ro-crate", NASTY, *AT, "--no-report"]],
    "import": [["crate", "--archive", "made"]],
    "reproduce": [[RUN, *AT]],
    "rescue": [[f"archive/{RUN}.h5", "--to", "made"]],
    "verify": [["archive"], ["archive", "--json"], ["archive", "--accept", NASTY]],
    "remove": [[RUN, *AT]],
    "restore": [[RUN, *AT]],
    "report": [[RUN, *AT, "--output", NASTY]],
    "browse": [["--archive", NASTY, "--no-browser"]],
    "demo": [["--folder", f"archive/{NASTY}", "--no-browser"]],
    "help": [[NASTY]],
    "watch": [["texts", "--once", "--settle", "0", "--archive", "made"]],
    "live": [["columns", "--once"]],
    "schema export": [[NASTY]],
}
"""Command lines that show texts of a lab; ``test_every_command_is_among_them`` finds any that is missing."""
SHORT = ("check", "predict", "ls", "tag", "note", "show", "study show", "verify", "remove")
"""Commands that are run among the default tests; all others show texts as these do."""


def test_every_command_is_among_them():
    assert COMMANDS.keys() == FLAGS.keys()


@pytest.fixture(scope="module")
def _made(short_runs, short_plan, tmp_path_factory) -> Path:
    place = tmp_path_factory.mktemp("steering") / "place"
    hostile_archive(short_runs / RUN, place / "archive", NASTY)
    hostile_run(short_runs / "si3n4-air-400mN", place / "texts", signals=False)
    hostile_run(short_runs / "si3n4-air-400mN", place / "columns", signals=True)
    shutil.copy(place / "texts" / "signals.csv", place / "bare.csv")
    shutil.copy(short_plan, place)
    (place / "recipe.toml").write_text(
        'schema = "tribopipe.recipe/1"\n[monte_carlo]\nsignificant_digits = 0\n', encoding="utf-8"
    )
    for name, kind in (("study", f'id = "y"\nfit = ["{RUN}"]\n'), ("sweep", f'[choices]\nruns = ["{RUN}"]\n')):
        text = f'schema = "tribopipe.{name}/1"\ntitle = {toml(NASTY)}\n{kind}'
        (place / f"{name}.toml").write_text(text, encoding="utf-8")
    return place


@pytest.fixture
def place(_made, tmp_path, monkeypatch) -> Path:
    """A folder with an archive, run folders and documents that have hostile texts."""
    monkeypatch.chdir(shutil.copytree(_made, tmp_path / "place"))
    return Path.cwd()


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such names of files")
@pytest.mark.parametrize(
    "command",
    others_slow(COMMANDS, *SHORT),
)
def test_no_command_is_steered(on_terminal, place, command):
    assert (place / "archive").is_dir()
    for line in COMMANDS[command]:
        told = on_terminal(*command.split(), *line)
        assert told.exit_code in (0, 1, 2, 3)
        assert steering(told) == [], line


@pytest.mark.parametrize("word", [NASTY, f"--{NASTY}", f"--archive={NASTY}"])
@pytest.mark.parametrize("command", ["", "show", "export runs", "fit", "nothing"])
def test_command_lines_that_are_not_understood_are_told_safely(on_terminal, tmp_path, monkeypatch, command, word):
    monkeypatch.chdir(tmp_path)
    told = on_terminal(*command.split(), "too-many", "words", word)
    assert told.exit_code in (1, 2)
    assert steering(told) == []


def test_texts_that_are_shown_say_what_would_have_steered(on_terminal, place):
    for command in ("show", "ls", "export runs", "study show"):
        (line, *_) = COMMANDS[command]
        shown = on_terminal(*command.split(), *line).stdout
        assert r"\x1b[31m\x1b]0;owned\x07\x9b2J" in shown, command
    assert place.is_dir()


def test_list_of_runs_as_csv_keeps_its_bytes_where_no_terminal_shows_them(run_cli, on_terminal, place):
    run_cli("export", "runs", *AT, "--output", "runs.csv")
    written = (place / "runs.csv").read_bytes().decode()
    assert STEERS.search(written)
    told = run_cli("export", "runs", *AT)
    assert (told.stdout, told.stderr) == (written, "")
    assert len(on_terminal("export", "runs", *AT).stdout.splitlines()) == 2


def test_names_of_files_that_no_run_has_are_not_completed(place):
    assert archived_ids(SimpleNamespace(params={"archive": place / "archive"})) == [RUN]
    if sys.platform != "win32":
        shutil.copy(place / "archive" / f"{RUN}.h5", place / "archive" / f"{NASTY}.h5")
    assert archived_ids(SimpleNamespace(params={"archive": place / "archive"})) == [RUN]


def test_warnings_are_told_safely():
    assert STEERS.search(_told(f"reader failed at {NASTY}", UserWarning, "x.py", 1)) is None


def test_waiting_is_told_safely(caplog):
    say_waiting(Path(NASTY), "a.h5", 3.0)
    assert STEERS.search(caplog.text) is None

"""Marks: a bad run stays whole in the archive, with who, when and why, and nothing is predicted from it."""

import getpass
import json
import re
import sys
from datetime import datetime, timedelta
from io import StringIO
from pathlib import Path

import h5py
import numpy as np
import pytest
from folders import set_key, tree_bytes
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError
from test_archive import nxcheck, run_with

from tribopipe.archive.store import Archive
from tribopipe.base.errors import ArchiveError
from tribopipe.cli.output import _NO_LAYOUT, progress, say
from tribopipe.documents.annotation import Mark
from tribopipe.documents.recipe import Recipe
from tribopipe.pipeline.stages import advance, ingest, predict_from_lightest, process

pytestmark = pytest.mark.usefixtures("few_draws")

RUN = "si3n4-air-200mN"
HEAVIER = "si3n4-air-400mN"
AGAIN = "si3n4-air-200mN-again"
DATE = "2026-07-01T10:00:00+00:00"
BAD = Mark(kind="bad", reason="the pin slipped in its holder", date=DATE, operator="anna")
GOOD = Mark(kind="good", reason="it was the run before", date=DATE)


@pytest.fixture
def mark_bad(run_cli, archive):
    """Run mark-bad on the archive."""
    return lambda *arguments: run_cli("mark-bad", *arguments, "--archive", archive)


def members(path: Path) -> dict[str, tuple]:
    """Everything a run file holds but its marks."""
    held: dict[str, tuple] = {}

    def keep(name: str, found: h5py.Group | h5py.Dataset) -> None:
        value = np.asarray(found[()]).tolist() if isinstance(found, h5py.Dataset) else None
        held[name] = repr(value), {key: repr(found.attrs[key]) for key in found.attrs}

    with h5py.File(path) as file:
        file.visititems(keep)
    return {name: content for name, content in held.items() if not name.startswith("entry/marks")}


def assert_refused(result, *words: str) -> None:
    (line,) = result.stderr.splitlines()
    assert (result.exit_code, result.stdout) == (1, "")
    assert line.startswith("error: ")
    assert [word for word in words if word not in line] == [], line


# --- the record ---


def test_reason_and_operator_are_stripped():
    mark = Mark(kind="bad", reason="  slipped\n", date=DATE, operator=" anna ")
    assert (mark.reason, mark.operator) == ("slipped", "anna")


@pytest.mark.parametrize("wrong", [{"reason": ""}, {"reason": " \t\n"}, {"operator": " "}, {"kind": "ugly"}])
def test_mark_that_says_nothing_is_refused(wrong):
    with pytest.raises(ValidationError):
        Mark(**{"kind": "bad", "reason": "slipped", "date": DATE} | wrong)


# --- the archive ---


@pytest.mark.slow
def test_history_is_kept_and_the_last_mark_counts(archive):
    store = Archive(archive)
    assert (store.marks(RUN), store.bad(RUN)) == ([], None)
    again = BAD.model_copy(update={"reason": "the disc was used before"})
    for mark, bad in ((BAD, BAD), (again, again), (GOOD, None), (BAD, BAD)):
        store.mark(RUN, mark)
        assert store.bad(RUN) == bad
    assert store.marks(RUN) == [BAD, again, GOOD, BAD]


@pytest.mark.slow
def test_all_else_in_the_file_stays_as_it_was(archive):
    store = Archive(archive)
    path, digest = store.path(RUN), store.raw_sha256(RUN)
    before, sources, steps = members(path), store.raw(RUN).sources, store.steps(RUN)
    assert {"entry/wear", "entry/raw/depth", "entry/wear_fit_sarkar"} <= set(before)
    store.mark(RUN, BAD)
    assert members(path) == before
    assert store.raw_sha256(RUN) == digest
    assert store.raw(RUN).sources == sources
    kept = {name: step.result_sha256 for name, step in store.steps(RUN).items()}
    assert kept == {name: step.result_sha256 for name, step in steps.items()}
    assert "wear_fit_sarkar" in kept


@pytest.mark.slow
def test_marks_outlive_steps_done_again_and_the_raw_part_written_anew(archive, short_runs):
    store = Archive(archive)
    store.mark(RUN, BAD)
    advance(store, RUN, "wear_fit_archard", Recipe(), force=True)
    assert store.marks(RUN) == [BAD]
    steps = store.step_names(RUN)
    assert ingest(short_runs / RUN, store).status == "unchanged"
    assert ingest(short_runs / RUN, store, force=True).status == "done"
    assert (store.marks(RUN), store.step_names(RUN)) == ([BAD], steps)


@pytest.mark.slow
def test_marked_run_conforms_to_nexus(archive):
    store = Archive(archive)
    for mark in (BAD, GOOD):
        store.mark(RUN, mark)
    warnings, errors, printed = nxcheck(store.path(RUN))
    assert (warnings, errors) == (0, 0), printed
    with h5py.File(store.path(RUN)) as file:
        assert file["entry/marks"].attrs["NX_class"] == "NXnote"


@pytest.mark.parametrize("history", [[], [BAD, GOOD]], ids=["never marked", "taken back"])
def test_what_was_not_marked_bad_cannot_be_taken_back(archive, history):
    store = Archive(archive)
    for mark in history:
        store.mark(RUN, mark)
    before = store.path(RUN).read_bytes()
    with pytest.raises(ArchiveError, match="found a run that is not marked as bad"):
        store.mark(RUN, GOOD)
    assert store.path(RUN).read_bytes() == before


def test_failed_mark_changes_nothing_and_leaves_nothing(archive, monkeypatch):
    def fail(*_):
        raise OSError(28, "No space left on device")

    before = tree_bytes(archive)
    monkeypatch.setattr("tribopipe.archive.run_files.write_marks", fail)
    with pytest.raises(ArchiveError, match="No space left on device"):
        Archive(archive).mark(RUN, BAD)
    assert tree_bytes(archive) == before


@pytest.mark.slow
@given(st.text(st.characters(codec="utf-8"), max_size=50).filter(str.strip))
def test_every_reason_comes_back_as_it_was_said(bare_run, tmp_path_factory, reason):
    store = Archive(tmp_path_factory.mktemp("archive"))
    store.add(run_with(bare_run, np.arange(10.0)))
    store.mark("bare", Mark(kind="bad", reason=reason, date=DATE))
    assert store.bad("bare").reason == reason.strip()


# --- references of predictions ---


@pytest.fixture
def repeated(archive, sample_run, other_run) -> Archive:
    """The run at 200 mN, one at 400 mN, and the first one once more."""
    store = Archive(archive)
    set_key(other_run, "id", f'"{AGAIN}"')
    outcomes = list(process([sample_run, other_run], store, Recipe(wear={"models": ["archard"]})))
    assert [outcome.error for outcome in outcomes if outcome.error] == []
    return store


def references(store: Archive) -> dict[str, str]:
    """Predict every run, and say from which."""
    outcomes = list(predict_from_lightest(store, store.ids(), ["archard"], Recipe()))
    assert [outcome.error for outcome in outcomes if outcome.error] == []
    return {outcome.run_id: outcome.result.reference for outcome in outcomes}


@pytest.mark.slow
def test_bad_run_is_no_reference_until_the_mark_is_taken_back(repeated):
    assert references(repeated) == {AGAIN: RUN, HEAVIER: RUN}
    repeated.mark(RUN, BAD)
    assert references(repeated) == {RUN: AGAIN, HEAVIER: AGAIN}
    repeated.mark(AGAIN, BAD)
    assert references(repeated) == {RUN: HEAVIER, AGAIN: HEAVIER}
    repeated.mark(HEAVIER, BAD)
    assert references(repeated) == {}
    repeated.mark(RUN, GOOD)
    assert references(repeated) == {AGAIN: RUN, HEAVIER: RUN}


# --- the command ---


def test_command_marks_and_takes_back(mark_bad, archive, monkeypatch):
    monkeypatch.setattr(getpass, "getuser", lambda: "otto")
    marked = mark_bad(RUN, "--reason", " slipped ", "--by", "anna")
    assert marked.exit_code == 0
    assert re.fullmatch(rf"{RUN}: marked bad by anna, \S+: slipped\n", marked.stdout)
    undone = mark_bad(RUN, "--undo", "--reason", "it was the run before")
    assert undone.exit_code == 0
    assert f"{RUN}: bad mark removed by otto, " in undone.output
    first, second = Archive(archive).marks(RUN)
    assert (first.kind, first.reason, first.operator) == ("bad", "slipped", "anna")
    assert (second.kind, second.reason, second.operator) == ("good", "it was the run before", "otto")
    for mark in (first, second):
        assert abs(datetime.now().astimezone() - datetime.fromisoformat(mark.date)) < timedelta(minutes=5)


def test_marked_bad_twice_adds_to_the_history(mark_bad):
    mark_bad(RUN, "--reason", "first", "--by", "anna")
    told = json.loads(mark_bad(RUN, "--reason", "second", "--by", "otto", "--json").stdout)
    assert told["id"] == RUN
    assert [set(mark) for mark in told["marks"]] == [{"kind", "reason", "date", "operator"}] * 2
    assert [(mark["kind"], mark["reason"], mark["operator"]) for mark in told["marks"]] == [
        ("bad", "first", "anna"),
        ("bad", "second", "otto"),
    ]


def test_what_is_said_of_a_run_does_not_steer_the_terminal(run_cli, mark_bad, archive):
    steering = "a title \x1b]0;owned\x07 and \x1b[31mred"
    for result in (mark_bad(RUN, "--reason", steering), run_cli("note", RUN, steering, "--archive", archive)):
        assert result.exit_code == 0, result.stderr
        assert r"\x1b]0;owned\x07" in result.stdout
        assert re.search("[\x07\x1b]", result.stderr) is None


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such names")
def test_files_that_were_written_are_told_without_steering_the_terminal(run_cli, archive, tmp_path):
    result = run_cli("export", "csv", RUN, "--output", tmp_path / "a\x1b]0;owned\x07\x1b[31m", "--archive", archive)
    assert result.exit_code == 0, result.stderr
    assert r"a\x1b]0;owned\x07\x1b[31m" in result.stdout
    assert re.search("[\x07\x1b]", result.stderr) is None


def test_what_is_said_keeps_its_lines_and_what_is_bold(capsys):
    say("a\n\tb \x1b[1mbold\x1b[0m \x1b[5mblinks\r\u202e")
    assert "a\n\tb " in capsys.readouterr().err
    assert (
        re.sub(_NO_LAYOUT, "!", "a\n\tb \x1b[1mbold\x1b[0m \x1b[5mblinks\r") == "a\n\tb \x1b[1mbold\x1b[0m ![5mblinks!"
    )


def test_bar_shows_the_name_of_a_hostile_file_as_it_is(monkeypatch):
    class Terminal(StringIO):
        def isatty(self) -> bool:
            return True

    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setenv("TERM", "xterm")
    with progress("verify", 2) as advance:
        advance("[red]a\x1b]0;owned\x07.h5")
    assert r"verify [red]a\x1b]0;owned\x07.h5" in terminal.getvalue()
    assert "\x1b]0" not in terminal.getvalue()


def test_reason_in_another_encoding_than_the_console_s_is_taken(run_cli, mark_bad, archive):
    marked = mark_bad(RUN, "--reason", "verschlei\udcdf", "--json")
    assert json.loads(marked.stdout)["marks"][0]["reason"] == "verschlei\udcdf"
    for command in (["show", RUN], ["show", RUN, "--json"], ["ls"], ["ls", "--json"]):
        assert run_cli(*command, "--archive", archive).exit_code == 0


@pytest.mark.parametrize("error", [KeyError("uid not found"), OSError("no user"), ImportError("no pwd")])
def test_mark_needs_no_user(mark_bad, archive, monkeypatch, error):
    def fail():
        raise error

    monkeypatch.setattr(getpass, "getuser", fail)
    assert mark_bad(RUN, "--reason", "slipped").exit_code == 0
    assert Archive(archive).bad(RUN).operator is None


@pytest.mark.slow
def test_list_shows_a_mark_only_where_there_is_one(run_cli, mark_bad, archive, sample_run):
    run_cli("ingest", sample_run, "--archive", archive)

    def listed() -> tuple[str, dict]:
        document = json.loads(run_cli("ls", "--archive", archive, "--json").stdout)
        return run_cli("ls", "--archive", archive).output, {run["id"]: run["marked_bad"] for run in document["runs"]}

    before, marks = listed()
    assert marks == {RUN: None, HEAVIER: None}
    assert " mark " not in before
    mark_bad(RUN, "--reason", "slipped")
    table, marks = listed()
    assert marks == {RUN: "slipped", HEAVIER: None}
    assert re.search(r"(?m)^ *run +mark +tribometer +materials ", table)
    assert re.search(rf"(?m)^ *{RUN} +bad ", table)
    assert re.search(rf"(?m)^ *{HEAVIER} +– ", table)
    mark_bad(RUN, "--undo", "--reason", "it did not")
    assert listed() == (before, {RUN: None, HEAVIER: None})


def test_show_tells_every_mark(run_cli, archive):
    store = Archive(archive)
    assert json.loads(run_cli("show", RUN, "--archive", archive, "--json").stdout)["marks"] == []
    for mark in (BAD, GOOD):
        store.mark(RUN, mark)
    shown = run_cli("show", RUN, "-v", "--archive", archive)
    assert f"  marked bad by anna, {DATE}: the pin slipped in its holder\n" in shown.stdout
    assert f"  bad mark removed, {DATE}: it was the run before\n" in shown.stdout
    told = json.loads(run_cli("show", RUN, "--archive", archive, "--json").stdout)
    assert told["marks"] == [BAD.model_dump(mode="json"), GOOD.model_dump(mode="json")]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([RUN, "--reason", ""], [RUN, "reason: found ''; expected the reason", "enter it"]),
        ([RUN, "--reason", " \n"], [RUN, "reason: found", "expected the reason"]),
        ([RUN, "--undo", "--reason", " "], ["reason: found ' '"]),
        ([RUN, "--reason", "slipped", "--by", ""], ["operator: found ''; expected the name"]),
        ([RUN, "--undo", "--reason", "good"], [RUN, "found a run that is not marked as bad", "`tribopipe ls`"]),
        (["si3n4-air-200mm", "--reason", "slipped"], ["found no run 'si3n4-air-200mm'", f"did you mean '{RUN}'?"]),
    ],
)
def test_bad_input_is_refused_in_a_sentence(mark_bad, archive, arguments, words):
    before = tree_bytes(archive)
    assert_refused(mark_bad(*arguments), *words)
    assert tree_bytes(archive) == before


@pytest.mark.parametrize("arguments", [[], [RUN], [RUN, "--undo"], ["--reason", "slipped"]], ids=repr)
def test_run_and_reason_must_be_named(mark_bad, archive, arguments):
    before = tree_bytes(archive)
    result = mark_bad(*arguments)
    assert result.exit_code == 2
    assert "Missing " in result.stderr
    assert tree_bytes(archive) == before


def test_help_tells_what_a_mark_does(run_cli):
    told = " ".join(run_cli("mark-bad", "--help").stdout.split())
    for words in (
        "exclude it from studies and predictions",
        "stay in the archive",
        "--undo",
        "--by",
    ):
        assert words in told
    assert re.search(r"(?m)^  mark-bad  ", run_cli("--help").stdout)

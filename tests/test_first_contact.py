"""What somebody meets who has never seen tribopipe: what to do next, pages of help, the demo, completion."""

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any, get_args

import pytest
import typer
from archived_files import with_sources, write_as_earlier
from folders import SAMPLES, replace_in
from hypothesis import given, settings
from hypothesis import strategies as st
from test_light_import import heavy_modules_after

from tribopipe.archive.store import Archive
from tribopipe.base import errors
from tribopipe.base.errors import CheckError, InternalError, TribopipeError
from tribopipe.cli.app import app
from tribopipe.cli.completion import SHELLS, complete
from tribopipe.cli.documentation import links, pages, sections
from tribopipe.cli.next_steps import Whereabouts, ids_in, look_around, next_steps
from tribopipe.documents.annotation import Mark
from tribopipe.evaluation.checks import (  # noqa: F401, which register their checks
    conditions,
    documents,
    end_values,
    samples,
)
from tribopipe.evaluation.checks.registry import CHECKS, refuse_errors
from tribopipe.evaluation.wear import findings as doubts
from tribopipe.pipeline.verify.file_findings import CheckName
from tribopipe.results.finding import Finding
from tribopipe.shipped import shipped

RUN = "si3n4-air-200mN"
NOW = "2026-03-01T12:00:00+00:00"
FOUND = (("warning", "load_sign"), ("error", "implausible_density"), ("error", "axis_constant"))
ROOT = typer.main.get_command(app)


def kinds_of_error(root=TribopipeError) -> set[str]:
    """Codes of the kinds of error that tribopipe itself has."""
    own = {root.code} if root.__module__ == errors.__name__ else set()
    return own.union(*map(kinds_of_error, root.__subclasses__()))


# --- what to do next ---


@pytest.fixture
def lab(tmp_path) -> Path:
    """A folder of somebody's."""
    (tmp_path / "lab").mkdir()
    return tmp_path / "lab"


@pytest.fixture
def commands(lab, run_cli):
    """The commands that `tribopipe` alone offers in it."""

    def offered() -> list[str]:
        done = run_cli(cwd=lab)
        assert (done.exit_code, done.stderr) == (0, "")
        return [line.strip() for line in done.stdout.splitlines() if line.startswith("    tribopipe")]

    return offered


def test_where_nothing_is_it_says_how_to_begin(commands, lab):
    assert commands() == ["tribopipe demo", "tribopipe new EXPORT", "tribopipe help tutorial"]
    assert list(lab.iterdir()) == []


def test_the_list_of_commands_is_still_there(run_cli):
    shown = run_cli("--help").stdout
    assert "Archive and evaluate tribometer tests" in shown
    assert all(f"  {name} " in shown for name in ("process", "demo", "help", "new"))


@pytest.mark.slow
def test_where_nothing_is_nothing_heavy_is_loaded(tmp_path):
    run = f"import os; os.chdir({str(tmp_path)!r}); from tribopipe.cli.app import app; app([], standalone_mode=False)"
    assert heavy_modules_after(run) <= {"pydantic"}


class Listed(dict[str, Any]):
    """A run as the catalogue would tell it."""

    @property
    def id(self) -> str:
        return self["id"]

    def text(self, name: str) -> str:
        held = self.get(name, "")
        return held if isinstance(held, str) else "; ".join(held)

    def texts(self, name: str) -> list[str]:
        return self.get(name, [])

    def value(self, name: str) -> float | None:
        return self.get(name)

    number = value


def listed(run_id: str, **known) -> Listed:
    """A run that is fitted, unless something else is known of it."""
    done = {"stage": "fitted", "steps": ["drift_correction"], "k_d": 1e-17, "load": 200.0, "tribometer": "pin-on-disc"}
    done |= {"end_depth": 1e-6}
    return Listed(id=run_id, run_toml=f"sha of {run_id}", **done | known)


def offered(archived=(), folders=(), **found) -> list[str]:
    """Commands offered where runs are archived and others lie in folders, which are called as the runs are."""
    runs = {Path("runs") / run_id: f"sha of {run_id}" for run_id in folders}
    there = Whereabouts(runs=runs, archived=list(archived), **found)
    return [command for step in next_steps(there) for command in step.commands]


PREDICT, REPORT, BROWSE = 'tribopipe predict a --load "400 mN"', "tribopipe report a", "tribopipe browse"
WARNED, DEPTH = 'tribopipe ls --where "findings>0"', "a depth signal"
AMEND = f"tribopipe process {Path('runs') / 'a'} --amend"
SCAR_ONLY = {"k_d": None, "end_depth": None, "wear_rate": 1e-14, "missing": [DEPTH]}
ONWARDS = [PREDICT, REPORT, BROWSE]


@pytest.mark.parametrize(
    ("archived", "commands"),
    [
        ([listed("a", stage="ingested", steps=[])], ["tribopipe correct-drift", "tribopipe fit", BROWSE]),
        ([listed("a", stage="corrected")], ["tribopipe fit", BROWSE]),
        ([listed("a")], ONWARDS),
        ([listed("a"), listed("b")], ["tribopipe study new", *ONWARDS]),
        ([listed("a"), listed("b", medium="water")], ONWARDS),
        ([listed("a", studies="s"), listed("b")], ONWARDS),
        ([listed("a", k_d=None)], [BROWSE]),
        ([listed("a", findings=2)], ["tribopipe show a", *ONWARDS]),
        ([listed("a", findings=2), listed("b", findings=1, medium="oil")], [WARNED, *ONWARDS]),
        ([listed("a", stage="ingested", steps=[], mark="bad")], [BROWSE]),
        ([listed("a", **SCAR_ONLY)], ["tribopipe help scar_only", REPORT, BROWSE]),
        ([listed("a", missing=["a friction signal"])], ONWARDS),
        ([listed("a", k_d=None, missing=[DEPTH, "an end value"])], [AMEND, BROWSE]),
        ([listed("a", k_d=None, end_depth=None, missing=[DEPTH])], [AMEND, BROWSE]),
        ([listed("a", end_depth=None)], [AMEND, *ONWARDS]),
        ([listed("a", end_depth=None, findings=1)], [AMEND, "tribopipe show a", *ONWARDS]),
        ([listed("a", end_depth=None, mark="bad")], [BROWSE]),
        ([listed("a", end_depth=None, tribometer="twin-disc")], ONWARDS),
    ],
)
def test_what_is_left_is_offered_and_then_what_can_be_made_of_it(archived, commands):
    assert offered(archived, ["a"]) == commands


def test_a_study_is_run_once_its_runs_are_archived(tmp_path):
    study = tmp_path / "s.study.toml"
    study.write_text('id = "s"', encoding="utf-8")
    run = f"tribopipe study run {study}"
    assert offered([listed("a")], ["a"], studies=[study]) == [run, BROWSE]
    assert run not in offered([listed("a")], ["a", "b"], studies=[study])
    assert offered([listed("a")], studies=[study], studied={"s"}) == [PREDICT, "tribopipe report s", BROWSE]


def test_files_that_cannot_be_read_come_first():
    assert offered([listed("b")], unreadable={"a": "found a damaged file"}) == ["tribopipe verify", BROWSE]


def test_an_export_is_named_where_nothing_else_is(commands, lab):
    for name in ("my test.csv", "photo.jpg"):
        (lab / name).touch()
    assert commands()[1] == 'tribopipe new "my test.csv"'
    assert "tribopipe help watch" not in commands()
    (lab / "other.csv").touch()
    assert commands()[1:3] == ['tribopipe new "my test.csv"', "tribopipe help watch"]


def test_run_folders_are_to_be_archived(commands, lab):
    for number in range(2):
        (lab / "my runs" / str(number)).mkdir(parents=True)
        (lab / "my runs" / str(number) / "run.toml").touch()
    assert commands() == ['tribopipe check "my runs"', 'tribopipe process "my runs"']


@pytest.fixture
def archived(lab, bare_run) -> Path:
    """The run folder in the lab of a run that is archived there, without signals."""
    folder, text = lab / "runs" / "bare", b'id = "bare"'
    folder.mkdir(parents=True)
    (folder / "run.toml").write_bytes(text)
    Archive(lab / "archive").add(with_sources(bare_run, run=text))
    return folder


def test_folders_are_known_by_their_run_toml(commands, lab, archived):
    steps = ["tribopipe correct-drift", "tribopipe fit", BROWSE]
    assert commands() == steps
    other = Path(shutil.copytree(archived, lab / "runs" / "other")).relative_to(lab)
    (lab / other / "run.toml").write_text('id = "other"', encoding="utf-8")
    assert commands() == [f"tribopipe check {other}", f"tribopipe process {other}", *steps]
    (archived / "run.toml").write_text('id = "bare" # amended', encoding="utf-8")
    assert commands()[2] == "tribopipe process runs --amend"  # with those beside it, which may stand on it


@pytest.mark.usefixtures("archived")
def test_a_damaged_or_earlier_file_is_not_taken_for_a_run_to_be_archived(commands, lab):
    path = Archive(lab / "archive").path("bare")
    whole = path.read_bytes()
    path.chmod(0o600)
    path.write_bytes(whole[:-1])
    assert commands() == ["tribopipe verify"]
    path.write_bytes(whole)
    write_as_earlier(path)
    assert commands() == ["tribopipe verify"]


@pytest.mark.slow
@pytest.mark.usefixtures("few_draws")
def test_followed_literally_it_leads_from_run_folders_to_a_report(commands, lab, short_runs, run_cli):
    shutil.copytree(short_runs, lab / "runs")
    run_cli("ingest", "runs", cwd=lab)
    done = []
    while (command := commands()[0]) != BROWSE:
        assert run_cli(*shlex.split(command)[1:], cwd=lab).exit_code == 0, command
        assert command not in done, "offered again when it was done"
        done += [command] if "predict" not in command else []
        if "predict" in command:
            assert run_cli(*shlex.split(commands()[1])[1:], cwd=lab).exit_code == 0
            break
    assert done == [
        "tribopipe correct-drift",
        "tribopipe fit",
        "tribopipe study new",
        "tribopipe study run study.toml",
    ]
    assert list(lab.glob("*.html")) != []


@pytest.mark.slow
@pytest.mark.usefixtures("few_draws")
def test_the_scar_of_a_run_without_end_values_is_asked_for_first(commands, lab, short_runs, run_cli):
    folder = Path(shutil.copytree(short_runs / RUN, lab / "runs" / RUN))
    replace_in(folder / "run.toml", r"\[end_values\]\n(.+\n)*", "")
    assert run_cli("process", "runs", "--no-figures", cwd=lab).exit_code == 0
    onwards = [f'tribopipe predict {RUN} --load "400 mN"', f"tribopipe report {RUN}"]
    assert commands() == [f"tribopipe process {Path('runs') / RUN} --amend", *onwards, BROWSE]
    said = " ".join(run_cli(cwd=lab).stdout.split())
    assert f"k_D of 1 run ({RUN}) is based on the depth sensor alone: measure the wear scar" in said
    Archive(lab / "archive").mark(RUN, Mark(kind="bad", reason="it rang", date=NOW))
    assert commands() == [BROWSE]


def test_what_cannot_be_read_is_named_and_hurts_nobody(commands, lab):
    (lab / "archive").mkdir()
    (lab / "archive" / "x.h5").write_bytes(b"no HDF5")
    (lab / "run").mkdir()
    (lab / "run" / "run.toml").write_bytes(b"\xff = not TOML")
    assert commands() == ["tribopipe verify", "tribopipe check run", "tribopipe process run"]


# --- help ---


def codes_of_fits() -> set[str]:
    source = Path(doubts.__file__).read_text(encoding="utf-8")
    return set(re.findall(r'(?:code=|_finding\(\s*|\(\s*(?="depends_on_))"(\w+)"', source))


def test_every_error_and_finding_has_a_section_and_no_section_is_of_nothing():
    codes = kinds_of_error() | CHECKS.keys() | codes_of_fits() | {f"verify-{name}" for name in get_args(CheckName)}
    assert codes == set(sections())
    assert all(len(said) > 20 for said in sections().values())


def test_each_section_is_opened_by_its_code(run_cli):
    shown = run_cli("help", "unit-error", "axis_constant").stdout
    assert "### unit-error" in shown
    assert "a number without a unit is rejected" in shown.lower()
    assert "### axis_constant" in shown
    assert "## " not in shown.replace("### ", "")


def test_pages_and_commands_are_opened_by_name(run_cli):
    assert run_cli("help", "end-values").stdout.startswith("# Enter post-test wear measurements")
    assert run_cli("help", "docs/end_values.md").stdout.startswith("# Enter post-test wear measurements")
    assert "Usage: tribopipe ingest" in run_cli("help", "ingest").stdout
    listed = run_cli("help").output
    assert all(f" {name} " in listed for name in pages())


@pytest.mark.parametrize("topic", ["unit_error", "Unit-Error", "AXIS-CONSTANT", "Process", "docs/local-wear.md"])
def test_how_a_topic_is_written_does_not_matter(run_cli, topic):
    assert run_cli("help", topic).stdout.startswith("#")


def test_commands_of_several_words_have_their_help(run_cli):
    assert "Usage: tribopipe study run" in run_cli("help", "study", "run").stdout
    both = run_cli("help", "fit", "unit-error").stdout
    assert "Usage: tribopipe fit [OPTIONS] [ID]..." in both
    assert "### unit-error" in both


@pytest.mark.parametrize(
    ("topic", "told"),
    [
        ("unit-eror", "did you mean 'unit-error'?"),
        ("Hegadekatte", "related pages: "),
        ("xyzzy", "`tribopipe help` lists the pages"),
        ("", "`tribopipe help` lists the pages"),
    ],
)
def test_an_unknown_topic_is_refused_with_what_is_near(run_cli, topic, told):
    refused = run_cli("help", topic)
    assert (refused.exit_code, refused.stdout) == (1, "")
    assert told in refused.stderr


@pytest.fixture
def on_a_terminal(monkeypatch):
    """Errors as they are told to people."""
    from tribopipe.cli import output

    said: list[str] = []
    monkeypatch.setattr(output, "sys", SimpleNamespace(stderr=SimpleNamespace(isatty=lambda: True)))
    monkeypatch.setattr(output, "say", said.append)
    return said


def test_on_a_terminal_an_error_is_followed_by_where_to_read_on(on_a_terminal, monkeypatch):
    from tribopipe.cli.output import exit_with, say_where_to_read

    say_where_to_read(["unit-error", "axis_constant", "unit-error", "of_a_plug_in"])
    assert on_a_terminal == ["more on this: tribopipe help unit-error axis_constant"]
    monkeypatch.setattr("tribopipe.cli.documentation.links", lambda codes: [f"https://x.org/{code}" for code in codes])
    say_where_to_read(["fit-error"])
    assert on_a_terminal[1:] == ["more on this: tribopipe help fit-error\nhttps://x.org/fit-error"]
    exit_with([], some_done=True, warned=["load_sign"])
    assert on_a_terminal[2].startswith("more on this: tribopipe help load_sign")


def test_elsewhere_an_error_is_one_line(run_cli):
    assert run_cli("show", "x", "--archive", "nowhere").stderr.count("\n") == 1


def test_an_installation_without_pages_still_tells_its_errors(on_a_terminal, monkeypatch):
    from tribopipe.cli.output import say_where_to_read

    sections.cache_clear()
    monkeypatch.setattr("tribopipe.shipped._FOLDERS", ())
    say_where_to_read(["unit-error"])
    assert on_a_terminal == []
    with pytest.raises(InternalError, match="reinstall tribopipe"):
        shipped("docs/messages.md")


def test_a_refused_run_leads_to_its_finding(bare_run):
    found = [Finding(severity=how, code=check, where="x", message="y", remedy="z") for how, check in FOUND]
    with pytest.raises(CheckError) as refused:
        refuse_errors(bare_run, found)
    assert refused.value.code == "implausible_density"


def test_links_lead_to_the_site_that_the_package_names(monkeypatch):
    def named(_):
        from email.message import Message

        told = Message()
        told["Project-URL"] = "Source, https://example.org/source"
        told["Project-URL"] = "Documentation, https://example.org/tribopipe/"
        return told

    monkeypatch.setattr("importlib.metadata.metadata", named)
    assert links(["axis_constant"]) == ["https://example.org/tribopipe/messages.html#axis-constant"]


# --- demo ---


def test_demo_leaves_a_folder_of_something_else_alone(run_cli, lab, monkeypatch):
    monkeypatch.setattr("tribopipe.browse.app.is_built", lambda: True)
    (lab / "thesis.docx").touch()
    refused = run_cli("demo", "--folder", lab)
    assert refused.exit_code == 1
    assert "found a folder with other files" in refused.stderr
    assert [path.name for path in lab.iterdir()] == ["thesis.docx"]


@pytest.mark.slow
def test_demo_records_processes_and_shows(lab, run_cli, monkeypatch):
    served = []
    monkeypatch.setattr("tribopipe.browse.app.is_built", lambda: True)
    monkeypatch.setattr("tribopipe.browse.server.serve", lambda archive, *_, **how: served.append((archive, how)))
    for _ in range(2):
        shown = run_cli("demo", "--no-browser", cwd=lab)
        assert shown.exit_code == 0
    demo = Path("tribopipe-demo")
    assert served == [(demo / "archive", {"open_browser": False})] * 2
    assert str(demo) in shown.stderr
    assert {path.name for path in (lab / demo).iterdir()} == {"runs", "archive", "plan.toml"}
    assert [path.name for path in lab.iterdir()] == [demo.name]
    archive = Archive(lab / demo / "archive")
    recorded = {path.parent.name for path in SAMPLES.glob("*/run.toml")}
    assert (set(archive.ids()), len(archive.study_ids())) == (recorded, 3)
    for run in sorted(recorded):
        assert (lab / demo / "runs" / run / "signals.csv").read_bytes() == (SAMPLES / run / "signals.csv").read_bytes()


# --- completion ---


def answer(shell: str, line: str) -> list[str]:
    """Return how the last word of a line may end, as a shell is told."""
    words = line.split(" ")
    told = {"COMP_WORDS": "\n".join(words), "COMP_CWORD": str(len(words) - 1), "_TYPER_COMPLETE_ARGS": line}
    told |= {"_TYPER_COMPLETE_WORD_TO_COMPLETE": words[-1], "_TYPER_COMPLETE_FISH_ACTION": "get-args"}
    text, code = complete(ROOT, shell, told)
    assert code == 0
    if shell == "zsh":
        text = text.removeprefix("_arguments '*: :((").removesuffix("))'")
        return [] if text == "_files" else [row.split('"')[1] for row in text.splitlines()]
    return [row.split("\t")[0].split(":::")[0] for row in text.splitlines()]


@pytest.fixture
def many(lab, monkeypatch) -> list[str]:
    """Ids of some runs in the archive here, as far as their names tell."""
    (lab / "archive").mkdir()
    ids = [f"run-{number:02}" for number in range(20)]
    for run_id in ids:
        (lab / "archive" / f"{run_id}.h5").touch()
    (lab / "other").mkdir()
    (lab / "other" / "elsewhere.h5").touch()
    monkeypatch.chdir(lab)
    return ids


@pytest.mark.parametrize("shell", SHELLS)
def test_commands_options_values_and_ids_are_completed(shell, many):
    assert {"process", "fit", "demo"} <= set(answer(shell, "tribopipe "))
    assert answer(shell, "tribopipe corr") == ["correct-drift"]
    assert answer(shell, "tribopipe study sh") == ["show"]
    assert answer(shell, "tribopipe show ") == many
    assert answer(shell, "tribopipe fit run-00 run-1") == many[10:]
    assert answer(shell, "tribopipe show --archive other ") == ["elsewhere"]
    assert answer(shell, "tribopipe fit --mod") == ["--model"]
    assert answer(shell, "tribopipe export --r") == ["--ro-crate"]
    assert answer(shell, "tribopipe show x --hel") == ["--help"]
    assert {"archard", "sarkar"} <= set(answer(shell, "tribopipe fit --model "))
    assert answer(shell, "tribopipe help unit-") == ["unit-error"]
    assert answer(shell, "tribopipe process ") == []
    assert answer(shell, "tribopipe fit --recipe ") == []


def test_where_files_are_wanted_shells_are_told_so():
    assert complete(ROOT, "zsh", {"_TYPER_COMPLETE_ARGS": "tribopipe process "}) == ("_files", 0)
    asked = {"_TYPER_COMPLETE_FISH_ACTION": "is-args", "_TYPER_COMPLETE_ARGS": "tribopipe process "}
    assert complete(ROOT, "fish", asked) == ("", 1)
    assert complete(ROOT, "fish", asked | {"_TYPER_COMPLETE_ARGS": "tribopipe "}) == ("", 0)


@settings(max_examples=25)
@given(st.sampled_from(SHELLS), st.text(max_size=40))
def test_no_line_is_too_odd(shell, text):
    told = {"COMP_WORDS": text, "COMP_CWORD": str(len(text.split())), "_TYPER_COMPLETE_ARGS": f"tribopipe {text}"}
    complete(ROOT, shell, told)


@pytest.mark.skipif(sys.platform == "win32", reason="there is no bash to ask")
def test_bash_is_answered_by_the_command_itself(many):
    script = Path(sys.executable).with_name("tribopipe")
    told = {"_TRIBOPIPE_COMPLETE": "complete_bash", "COMP_WORDS": "tribopipe\nshow\nrun-0", "COMP_CWORD": "2"}
    done = subprocess.run([script], env=os.environ | told, capture_output=True, text=True, encoding="utf-8")
    assert (done.returncode, done.stderr, done.stdout.split()) == (0, "", many[:10])


def test_completion_loads_nothing_heavy():
    run = (
        "import typer; from tribopipe.cli.app import app; from tribopipe.cli.completion import complete; "
        "complete(typer.main.get_command(app), 'zsh', {'_TYPER_COMPLETE_ARGS': 'tribopipe fit --model '})"
    )
    assert heavy_modules_after(run) == set()


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no pipes with names here")
def test_pipes_are_no_documents(tmp_path):
    (tmp_path / "run").mkdir()
    for path in (tmp_path / "run" / "run.toml", tmp_path / "study.toml"):
        os.mkfifo(path)
    found = look_around(tmp_path, tmp_path / "archive")
    assert found.runs == {}
    assert ids_in(found.studies) == {}

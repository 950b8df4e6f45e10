"""A second `process` with nothing to do says so from the signatures of files; any change has it look again."""

import json
import os
import shutil
import time
from importlib.metadata import EntryPoint

import pytest

from tribopipe.pipeline import last_pass, stages

NOTHING = "Nothing to do: all {} steps are unchanged; --force repeats them."
LIGHT = "si3n4-air-200mN"


@pytest.fixture(scope="module")
def passed(short_runs, tmp_path_factory):
    """A folder with run folders, a recipe, and an archive whose runs have been processed."""
    folder = tmp_path_factory.mktemp("passed")
    shutil.copytree(short_runs, folder / "runs")
    recipe = 'schema = "tribopipe.recipe/1"\n[monte_carlo]\nsignificant_digits = 0\n'
    (folder / "recipe.toml").write_text(recipe, encoding="utf-8")
    from tribopipe.archive.store import Archive
    from tribopipe.documents.recipe import Recipe
    from tribopipe.documents.record import load_toml
    from tribopipe.views.archived_figures import drawn, figure_steps

    store = Archive(folder / "archive")
    paths = stages.find_runs(folder / "runs")
    outcomes = list(stages.process(paths, store, load_toml(folder / "recipe.toml", Recipe)))
    list(drawn(figure_steps(store, outcomes)))
    return folder


@pytest.fixture
def lab(passed, tmp_path, monkeypatch):
    """A copy of that, made long ago, in the current folder; with the pass that found nothing to do."""
    shutil.copytree(passed, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    now = time.time_ns
    monkeypatch.setattr(last_pass.time, "time_ns", lambda: now() + 10_000_000_000)
    return tmp_path


@pytest.fixture
def process(lab, run_cli, monkeypatch):
    """Run `process`; return its last line, and whether it read any run."""
    looked = []
    through = stages.process
    monkeypatch.setattr(stages, "process", lambda *given, **named: looked.append(True) or through(*given, **named))

    def run(*words):
        looked.clear()
        result = run_cli("process", lab / "runs", "--recipe", "recipe.toml", "-j", "1", *words)
        assert result.exit_code == 0, result.stderr
        return result.stderr.splitlines()[-1], bool(looked)

    return run


@pytest.mark.slow
def test_the_second_pass_that_finds_nothing_to_do_reads_no_run(lab, process):
    first, second = process(), process()
    assert first[1]
    assert second == (first[0], False)
    steps = next(iter(json.loads((lab / "archive" / last_pass.FILE_NAME).read_text()).values()))["steps"]
    assert second[0] == NOTHING.format(steps)


def rewritten(path):
    """Write other content of the same size, and put the time of change back, as some copying programs do."""
    seen = path.stat()
    path.write_bytes(path.read_bytes()[:-1] + b" ")
    os.utime(path, ns=(seen.st_atime_ns, seen.st_mtime_ns))


CHANGES = {
    "run.toml": lambda lab: (lab / "runs" / LIGHT / "run.toml").touch(),
    "signals of the same size and time": lambda lab: rewritten(next((lab / "runs" / LIGHT).glob("*.csv"))),
    "a new run": lambda lab: shutil.copytree(lab / "runs" / LIGHT, lab / "runs" / "copy"),
    "a new file": lambda lab: (lab / "runs" / LIGHT / "profile.txt").write_text("1", encoding="utf-8"),
    "a study": lambda lab: (lab / "runs" / "study.toml").write_text("", encoding="utf-8"),
    "the recipe": lambda lab: (lab / "recipe.toml").touch(),
    "an archived run": lambda lab: (lab / "archive" / f"{LIGHT}.h5").touch(),
    "a figure": lambda lab: next((lab / "archive" / "figures").iterdir()).unlink(),
    "a run folder": lambda lab: shutil.rmtree(lab / "runs" / LIGHT),
}


@pytest.mark.slow
@pytest.mark.parametrize("change", CHANGES)
def test_any_change_has_the_next_pass_look_again(lab, change):
    asked = [lab / "runs"], lab / "archive", lab / "recipe.toml"
    before = last_pass.state_before(*asked, figures=["screen"])
    last_pass.keep_pass(lab / "archive", before, 3)
    assert last_pass.steps_unchanged(lab / "archive", last_pass.state_before(*asked, figures=["screen"])) == 3
    CHANGES[change](lab)
    assert last_pass.steps_unchanged(lab / "archive", last_pass.state_before(*asked, figures=["screen"])) is None


@pytest.mark.slow
def test_who_asks_for_more_gets_it(process, monkeypatch):
    process()
    monkeypatch.setattr("tribopipe.views.archived_figures.figure_steps", lambda *_: [])
    for word in ("--no-figures", "-v", "--json", "--amend", "--force"):
        assert process(word)[1], word


@pytest.mark.slow
def test_the_program_itself_is_looked_at(process, monkeypatch):
    process()
    monkeypatch.setattr(last_pass, "_program", lambda: iter([("tribopipe/laws.py", None)]))
    assert process()[1]


def test_a_module_of_the_package_is_among_what_is_looked_at():
    seen = {name for name, _ in last_pass._program()}
    assert stages.__file__ in seen
    assert len(seen) > 200


def test_folders_of_packages_need_not_be_there(monkeypatch, tmp_path):
    monkeypatch.setattr(last_pass.sysconfig, "get_path", lambda _: str(tmp_path / "none"))
    assert len({name for name, _ in last_pass._program()}) > 200


@pytest.mark.slow
def test_a_file_that_was_changed_just_now_is_read_each_time(lab, process, monkeypatch):
    monkeypatch.setattr(last_pass.time, "time_ns", lambda: (lab / "runs" / LIGHT / "run.toml").stat().st_ctime_ns)
    process()
    assert not (lab / "archive" / last_pass.FILE_NAME).exists()
    assert process()[1]


def test_folders_that_links_lead_to_are_read_each_time(lab):
    shutil.move(lab / "runs" / LIGHT, lab / "elsewhere")
    (lab / "runs" / LIGHT).symlink_to(lab / "elsewhere", target_is_directory=True)
    before = last_pass.state_before([lab / "runs"], lab / "archive", None, figures=["screen"])
    assert not before.settled


def test_an_archive_among_the_runs_is_no_input_of_its_own(lab):
    before = last_pass.state_before([lab], lab / "archive", None, figures=[])
    (lab / "archive" / "catalogue.sqlite").write_bytes(b"anything")
    assert last_pass.state_before([lab], lab / "archive", None, figures=[]) == before


def test_with_packages_that_add_to_tribopipe_every_pass_looks(lab, monkeypatch):
    theirs = EntryPoint("drum", "elsewhere:DRUM", "tribopipe.contacts")
    monkeypatch.setattr("tribopipe.base.plugins.declared", lambda _: (theirs,))
    before = last_pass.state_before([lab / "runs"], lab / "archive", None, figures=["screen"])
    last_pass.keep_pass(lab / "archive", before, 3)
    assert last_pass.steps_unchanged(lab / "archive", before) is None


@pytest.mark.parametrize("content", ["", "[]", "{", '{"a": 1}', "null", "\x00"])
def test_what_is_kept_may_be_anything(lab, content):
    (lab / "archive" / last_pass.FILE_NAME).write_text(content, encoding="utf-8")
    before = last_pass.state_before([lab / "runs"], lab / "archive", lab / "recipe.toml", figures=["screen"])
    assert last_pass.steps_unchanged(lab / "archive", before) is None
    last_pass.keep_pass(lab / "archive", before, 3)
    assert last_pass.steps_unchanged(lab / "archive", before) == 3


@pytest.mark.slow
def test_so_many_passes_are_kept(lab):
    for number in range(25):
        one = last_pass.state_before([lab / f"runs{number}"], lab / "archive", None, figures=["screen"])
        last_pass.keep_pass(lab / "archive", one._replace(settled=True), number)
    assert len(json.loads((lab / "archive" / last_pass.FILE_NAME).read_text())) == 20


@pytest.mark.slow
def test_verify_knows_what_is_kept(lab, process, run_cli):
    process()
    verified = run_cli("verify")
    assert (lab / "archive" / last_pass.FILE_NAME).is_file()
    assert verified.exit_code == 0
    assert last_pass.FILE_NAME not in verified.output

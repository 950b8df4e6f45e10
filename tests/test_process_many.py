"""`process` of several runs at once, of a part of them, and of those whose ids are the same."""

import json
import shutil
from pathlib import Path

import pytest
import typer
from folders import set_key
from sweeps import others_slow

from tribopipe.archive.step_names import StepName
from tribopipe.archive.store import Archive
from tribopipe.base.executor import Crew
from tribopipe.cli.options import Part, crew, seen_by
from tribopipe.cli.process import _say_missing
from tribopipe.cli.summary import _origin
from tribopipe.pipeline.stages import Outcome
from tribopipe.results.wear_fit import WearFit

LIGHT, HEAVY = "si3n4-air-200mN", "si3n4-air-400mN"


@pytest.fixture(scope="module")
def quick(tmp_path_factory) -> Path:
    """A recipe that leaves uncertainty at first order."""
    path = tmp_path_factory.mktemp("recipe") / "recipe.toml"
    path.write_text('schema = "tribopipe.recipe/1"\n[monte_carlo]\nsignificant_digits = 0\n', encoding="utf-8")
    return path


def results(folder: Path) -> dict[tuple[str, StepName], str]:
    archive = Archive(folder)
    steps = {
        (run_id, name): archive.fingerprints(run_id, name)
        for run_id in archive.ids()
        for name in archive.step_names(run_id)
    }
    return {step: found.result for step, found in steps.items()}


def steps_of(result) -> list[tuple[str, str, str]]:
    return [(step["id"], step["stage"], step["status"]) for step in json.loads(result.stdout)["steps"]]


# --- parts ---


@pytest.mark.slow
def test_a_part_takes_its_runs_and_leaves_what_needs_others(run_cli, short_runs, quick, tmp_path):
    words = ["process", short_runs, "--recipe", quick, "--archive", tmp_path / "archive", "--json"]
    second = run_cli(*words, "--shard", "2/2")
    assert second.exit_code == 0
    assert {run_id for run_id, _, _ in steps_of(second)} == {HEAVY}
    assert "Part 2 of 2 is done; run `process` without --shard for predictions, studies and figures." in second.stderr
    assert not (tmp_path / "archive" / "figures").exists()
    assert run_cli(*words, "--shard", "1/2").exit_code == 0
    assert {name for _, name in results(tmp_path / "archive")} & {"prediction_archard", "prediction_sarkar"} == set()
    last = run_cli(*words, "--no-figures")
    done = [(run_id, stage) for run_id, stage, status in steps_of(last) if status != "unchanged"]
    assert done == [(HEAVY, "prediction"), (HEAVY, "prediction")]


@pytest.mark.parametrize("written", ["0/2", "3/2", "1", "a/b", "1/0", "-1/2", "1/2/3"])
def test_what_is_no_part_is_wrong_usage(run_cli, short_runs, written):
    result = run_cli("process", short_runs, "--shard", written)
    assert (result.exit_code, result.stdout) == (2, "")
    assert "expected i/n with i from 1 to n" in result.stderr


def test_parts_are_disjoint_and_complete():
    runs = list(range(10))
    parts = [Part(number, 3).chosen(runs) for number in (1, 2, 3)]
    assert parts == [[0, 3, 6, 9], [1, 4, 7], [2, 5, 8]]


# --- crews ---


def test_crews_are_what_the_options_say(monkeypatch):
    monkeypatch.setattr("tribopipe.cli.options._cores", lambda: 5)
    asked = {(None, None): 1, (3, None): 3, (0, None): 5, (None, "local"): 5, (2, "local"): 2}
    assert {given: crew(*given).jobs for given in asked} == asked
    assert [crew(jobs, None, usual=0).jobs for jobs in (None, 0, 2)] == [5, 5, 2]
    assert crew(None, "tcp://10.0.0.1:8786").scheduler == "tcp://10.0.0.1:8786"
    with pytest.raises(typer.BadParameter, match="has its own workers"):
        crew(2, "tcp://10.0.0.1:8786")


def test_workers_of_a_scheduler_are_told_where_a_path_is():
    assert seen_by(Crew(), Path("runs")) == Path("runs")
    assert seen_by(Crew(scheduler="local"), Path("runs")) == Path.cwd() / "runs"


def test_an_archive_that_a_worker_does_not_see_is_not_begun_there(tmp_path, sample_run):
    import pickle

    from tribopipe.base.errors import ArchiveError
    from tribopipe.pipeline.stages import ingest

    folder = tmp_path / "archive"
    folder.mkdir()
    sent = pickle.dumps(Archive(folder))
    assert pickle.loads(sent).folder == folder  # noqa: S301
    folder.rmdir()
    with pytest.raises(ArchiveError, match="found that the archive folder no longer exists"):
        ingest(sample_run, pickle.loads(sent))  # noqa: S301
    assert not folder.exists()


@pytest.mark.parametrize(("runs", "words", "jobs"), [(2, (), 5), (1, (), 1), (1, ("-j", "3"), 3), (2, ("-j", "1"), 1)])
def test_process_takes_all_cores_unless_told_otherwise_or_alone(
    run_cli, short_runs, quick, tmp_path, monkeypatch, runs, words, jobs
):
    monkeypatch.setattr("tribopipe.cli.options._cores", lambda: 5)
    taken = []

    def stopped(*_, crew: Crew, **__):
        taken.append(crew.jobs)
        return iter(())

    monkeypatch.setattr("tribopipe.pipeline.stages.process", stopped)
    folders = [short_runs / name for name in (LIGHT, HEAVY)[:runs]]
    run_cli("process", *folders, "--recipe", quick, "--archive", tmp_path / "archive", *words)
    assert taken == [jobs]


@pytest.mark.slow
@pytest.mark.parametrize("command", others_slow(["process", "ingest", "correct-drift", "fit"]))
def test_what_is_printed_does_not_depend_on_which_worker_is_faster(
    run_cli, short_runs, quick, tmp_path, monkeypatch, command
):
    given = {"process": [short_runs], "ingest": [short_runs]}.get(command, [])
    words = [command, *given, *([] if command == "ingest" else ["--recipe", quick])]

    def printed(*how: str) -> tuple[str, str]:
        folder = tmp_path / "archive"
        if not given:
            run_cli("ingest", short_runs, "--archive", folder)
        result = run_cli(*words, *(["--no-figures"] if command == "process" else []), "--archive", folder, *how)
        shutil.rmtree(folder)
        return result.stdout, result.stderr

    alone = printed("-j", "1")
    monkeypatch.setattr("tribopipe.base.executor._as_done", last_first)
    assert printed("-j", "2") == alone
    assert all(name in "".join(alone) for name in (LIGHT, HEAVY))


def last_first(work, tasks, _):
    """Answer as workers would of whom the first is the slowest."""
    yield from reversed([(task, work(task)) for task in tasks])


@pytest.mark.slow
@pytest.mark.parametrize("how", [["-j", "2"], ["-j", "2", "--scheduler", "local"]], ids=["processes", "LocalCluster"])
def test_several_at_once_are_the_same_bit_for_bit(run_cli, short_runs, quick, tmp_path, how):
    runs = shutil.copytree(short_runs, tmp_path / "runs")
    again = shutil.copytree(runs / HEAVY, tmp_path / "runs" / "z-again")
    set_key(again, "id", f'"{HEAVY}-again"')
    broken = shutil.copytree(runs / HEAVY, tmp_path / "runs" / "a-broken")
    (broken / "run.toml").write_text("nothing", encoding="utf-8")
    for name in ("a", "b"):
        runs_of = f'fit = ["{LIGHT}"]\npredict = ["{HEAVY}"]\nlaws = ["archard"]\n'
        text = f'schema = "tribopipe.study/1"\nid = "{name}"\n{runs_of}'
        (runs / f"{name}.study.toml").write_text(text, encoding="utf-8")
    words = ["process", runs, "--recipe", quick, "--json"]
    one = run_cli(*words, "--archive", tmp_path / "one", "-j", "1")
    two = run_cli(*words, "--archive", tmp_path / "two", *how)
    assert (one.exit_code, two.exit_code) == (3, 3)
    assert json.loads(two.stdout) == json.loads(one.stdout.replace(str(tmp_path / "one"), str(tmp_path / "two")))
    assert results(tmp_path / "two") == results(tmp_path / "one")
    assert sorted(path.name for path in (tmp_path / "two" / "figures").iterdir()) == sorted(
        path.name for path in (tmp_path / "one" / "figures").iterdir()
    )
    assert run_cli("verify", "--archive", tmp_path / "two").exit_code == 0


@pytest.mark.slow
def test_of_runs_with_one_id_the_first_is_archived(run_cli, short_runs, tmp_path):
    for name, title in (("a", "first"), ("b", "second"), ("c", "third")):
        run = shutil.copytree(short_runs / LIGHT, tmp_path / "runs" / name)
        set_key(run, "title", f'"{title}"')
    words = ["ingest", tmp_path / "runs", "--archive", tmp_path / "archive", "--json"]
    result = run_cli(*words, "-j", "3")
    assert result.exit_code == 3
    assert [run["status"] for run in json.loads(result.stdout)["runs"]] == ["done", "failed", "failed"]
    assert Archive(tmp_path / "archive").manifest(LIGHT).title == "first"


def test_what_a_killed_writer_left_is_taken_away(archive):
    store = Archive(archive)
    left, figure = archive / f".{LIGHT}.h5.abc.part", archive / "notes.part"
    left.touch()
    figure.touch()
    store.tidy()
    assert not left.exists()
    assert figure.exists()


def test_what_a_run_without_k_d_is_missing_is_said_once(capsys):
    told: set[str] = set()
    for law in ("archard", "sarkar"):
        fit = WearFit(model=law, outcome="not fitted", missing=("a scar",))
        _say_missing(Outcome("one", "wear_fit", "done", fit), told)
    assert capsys.readouterr().err == "one: archard: no wear coefficient: missing a scar\n"


# --- tables of -v ---


def test_a_run_without_bodies_has_a_row_in_the_tables(run_cli, tmp_path):
    folder = tmp_path / "friction"
    folder.mkdir()
    rows = "".join(f"{second},{2 + 0.01 * (second % 3)}\n" for second in range(60))
    (folder / "signals.csv").write_text(f"Time [s],Friction force [N]\n{rows}", encoding="utf-8")
    (folder / "run.toml").write_text(
        'schema = "tribopipe.run/1"\nid = "friction"\n[conditions]\nnormal_load = "5 N"\nsliding_speed = "0.1 m/s"\n'
        '[[signals]]\nfile = "signals.csv"\n',
        encoding="utf-8",
    )
    done = run_cli("process", folder, "--archive", tmp_path / "archive", "--no-figures", "-v")
    assert done.exit_code == 0, done.stderr
    (row,) = (line for line in done.stdout.splitlines() if line.strip().startswith("friction "))
    assert row.split()[:3] == ["friction", "–", "–"]


@pytest.mark.parametrize(
    ("references", "shown"),
    [
        ({}, ""),
        ({"archard": None}, ""),
        ({"archard": "a", "sarkar": "a"}, "a"),
        ({"archard": "a", "sarkar": None}, "a"),
        ({"archard": "a", "sarkar": "b"}, "a (Archard), b (Sarkar)"),
    ],
)
def test_predictions_by_different_runs_name_each(references, shown):
    assert _origin(references) == shown

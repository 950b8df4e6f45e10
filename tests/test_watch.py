"""`tribopipe watch`: what is dropped settles, becomes a run once, and is processed; by a clock of the tests."""

import json
import shutil
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest
from folders import ROOT, tree_bytes
from hypothesis import given, settings
from hypothesis import strategies as st
from watch_bench import SETTLE, TEMPLATE, Bench, export

from tribopipe.archive.store import Archive
from tribopipe.base.errors import ArchiveError, ManifestError, TribopipeError
from tribopipe.extras.watch import processing
from tribopipe.extras.watch.drops import Drop, drops, is_held, moves
from tribopipe.extras.watch.journal import Entry, Journal, alone, counted
from tribopipe.extras.watch.watcher import Settling
from tribopipe.pipeline.stages import Outcome


def at_once(run: Path, **_) -> tuple[Outcome, ...]:
    """Stands for the line, which takes its time."""
    at_once.taken.append(run.name)
    return (Outcome(run.name, "ingest", "done"),)


@pytest.fixture
def taken(monkeypatch) -> list[str]:
    """The runs that were processed, by a line that does nothing."""
    at_once.taken = []
    monkeypatch.setattr(processing, "_through_the_line", at_once)
    return at_once.taken


@pytest.fixture
def bench(tmp_path, taken) -> Bench:
    bench = Bench(tmp_path)
    bench.taken = taken
    return bench


# --- settling ---


def drop(name: str, stamp: str) -> Drop:
    return Drop(name, (Path(name),), stamp)


def test_what_has_not_changed_for_a_while_has_settled():
    settling = Settling(10.0)
    assert settling.settled([drop("a", "1"), drop("b", "1")], 0.0) == []
    assert settling.settled([drop("a", "2"), drop("b", "1")], 9.0) == []
    assert settling.next == 10.0
    assert settling.settled([drop("a", "2"), drop("b", "1")], 10.0) == [drop("b", "1")]
    settling.forget(drop("b", "1"))
    assert (len(settling), settling.next) == (1, 19.0)
    assert settling.settled([drop("a", "2")], 19.0) == [drop("a", "2")]


def test_what_was_away_settles_anew():
    settling = Settling(10.0)
    settling.settled([drop("a", "1")], 0.0)
    settling.settled([], 5.0)
    assert settling.settled([drop("a", "1")], 11.0) == []


@given(st.lists(st.tuples(st.sampled_from("12"), st.floats(0, 8)), min_size=1, max_size=30))
def test_settled_means_seen_alike_for_so_long(seen):
    settling, now, since, before = Settling(10.0), 0.0, 0.0, ""
    for stamp, passed in seen:
        now += passed
        since = since if stamp == before else now
        assert bool(settling.settled([drop("a", stamp)], now)) == (now - since >= 10.0)
        before = stamp


# --- what lies there ---


def names(folder: Path, **how) -> list[str]:
    return [one.name for one in drops(folder, **how)]


def test_each_file_is_a_drop_but_for_what_is_unfinished_or_no_export(tmp_path):
    for name in ("a10.csv", "a2.csv", "day/b.csv", "day/deep/c.txt", "runs/x.csv", ".hidden/d.csv"):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(b"1")
    for name in ("e.tmp", "f.PART", "~$g.xlsx", ".h.csv", "i.csv~", "lab.toml", "Thumbs.db", "j.crdownload"):
        (tmp_path / name).write_bytes(b"1")
    (tmp_path / "empty.csv").touch()
    assert names(tmp_path, without={tmp_path / "runs"}) == ["a2.csv", "a10.csv", "day/b.csv", "day/deep/c.txt"]


def test_a_folder_is_one_drop_where_it_is_a_run_or_its_files_are_together(tmp_path):
    for name in ("a.csv", "one/1.csv", "one/2.csv", "two/1.csv", "two/our-rig.toml", "run/run.toml", "run/s.csv"):
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(b"1")
    assert names(tmp_path) == ["a.csv", "one/1.csv", "one/2.csv", "run", "two/1.csv"]
    found = {one.name: one for one in drops(tmp_path, together=True)}
    assert list(found) == ["a.csv", "one", "run", "two"]
    assert [path.name for path in found["one"].files] == ["1.csv", "2.csv"]
    assert [path.name for path in found["two"].files] == ["1.csv"]
    assert [one.is_run for one in found.values()] == [False, False, True, False]


def test_a_folder_waits_for_all_its_files(tmp_path):
    (tmp_path / "one").mkdir()
    (tmp_path / "one" / "1.csv").write_bytes(b"1")
    (tmp_path / "one" / "2.csv").touch()
    assert names(tmp_path, together=True) == []


def test_what_windows_keeps_to_another_program_is_held(tmp_path, monkeypatch):
    path = tmp_path / "a.csv"
    path.write_bytes(b"1")
    assert not is_held([path])
    error = PermissionError(13, "in use")
    monkeypatch.setattr(Path, "open", lambda *_: (_ for _ in ()).throw(error))
    assert not is_held([path])  # no permission: whoever reads it says so
    error.winerror = 32
    assert is_held([path])


# --- from a drop to a run ---


def test_an_export_becomes_a_run_once_it_has_settled(bench):
    bench.put("test_1.csv", export(1)[:60])
    assert bench.look() == []
    bench.put("test_1.csv", export(1))
    assert bench.look(SETTLE) == []
    assert bench.watcher.unsettled == 1
    assert bench.look(SETTLE) == [("made", "test_1.csv", "test_1"), ("done", "test_1.csv", "test_1")]
    assert (bench.made, bench.taken) == ({"test_1": export(1)}, ["test_1"])
    assert '\nnormal_load = "5 N"' in (bench.runs / "test_1" / "run.toml").read_text("utf-8")
    assert bench.look(SETTLE) == []
    assert tree_bytes(bench.folder) == {"test_1.csv": export(1)}


def test_what_is_handled_is_not_handled_by_the_next_watch(bench):
    bench.put("a.csv", export(1))
    bench.put("notes.txt", b"the disc rang\n")
    assert [kind for kind, *_ in bench.settled()] == ["made", "left", "done"]
    bench.start()
    assert bench.settled() == []
    assert bench.taken == ["a"]


def test_what_no_reader_knows_is_named_once_and_again_when_it_changes(bench):
    bench.put("notes.txt", b"the disc rang\n")
    bench.look()
    (told,) = bench.told(SETTLE)
    assert told.text.startswith("notes.txt: no run was created from it; found no known format")
    bench.put("notes.txt", b"the disc rang again\n")
    assert bench.settled() == [("left", "notes.txt", None)]
    bench.put("notes.txt", export(3))
    assert bench.settled() == [("made", "notes.txt", "notes"), ("done", "notes.txt", "notes")]


def test_the_same_bytes_under_another_name_are_the_same_run(bench):
    bench.put("a.csv", export(1))
    bench.put("b.csv", export(1))
    assert bench.settled() == [("made", "a.csv", "a"), ("same", "b.csv", "a"), ("done", "a.csv", "a")]
    (bench.folder / "a.csv").rename(bench.folder / "c.csv")
    assert bench.settled() == [("same", "c.csv", "a")]
    bench.put("d.csv", export(1))
    bench.look()
    assert [event.text for event in bench.told(SETTLE)] == ["d.csv: same content as a.csv, archived as a"]
    assert list(bench.made) == bench.taken == ["a"]


def test_other_bytes_under_the_same_name_are_another_run(bench):
    bench.put("a.csv", export(1))
    bench.settled()
    bench.put("a.csv", export(2))
    assert bench.settled() == [("made", "a.csv", "a-2"), ("done", "a.csv", "a-2")]
    bench.put("day 2/a.csv", export(3))
    assert [run for *_, run in bench.settled()] == ["a-3", "a-3"]
    bench.put("a.csv", export(1))
    assert bench.settled() == []
    assert bench.made == {"a": export(1), "a-2": export(2), "a-3": export(3)}


def test_an_id_of_the_archive_is_not_taken_for_other_bytes(bench, archive):
    assert bench.lab.archive == archive
    bench.put("si3n4-air-200mN.csv", export(1))
    assert [run for *_, run in bench.settled()] == ["si3n4-air-200mN-2"] * 2
    (bytes_,) = [one.content for one in Archive(archive).raw("si3n4-air-200mN").sources if one.name == "signals.csv"]
    bench.put("si3n4-air-200mN.txt", bytes_)
    assert [run for *_, run in bench.settled()] == ["si3n4-air-200mN"] * 2


@pytest.mark.usefixtures("taken")
def test_the_files_of_a_folder_are_one_run_where_they_are_together(tmp_path):
    bench = Bench(tmp_path, together=True)
    for number in (1, 2, 10):
        bench.put(f"test 7/part_{number}.csv", export(number))
    assert bench.settled() == [("made", "test 7", "test-7"), ("done", "test 7", "test-7")]
    text = (bench.runs / "test-7" / "run.toml").read_text("utf-8")
    assert text.index("part_2.csv") < text.index("part_10.csv")


def test_a_run_folder_is_taken_where_it_lies(bench):
    bench.put("day/run-7/run.toml", b"")
    assert bench.settled() == []
    bench.put("day/run-7/run.toml", b"id = 7")
    bench.put("day/run-7/signals.csv", export())
    assert bench.settled() == [("done", "day/run-7", "run-7")]
    assert bench.made == {}


def test_a_run_that_lacks_something_is_processed_once_that_is_filled_in(bench):
    bench.template.write_text('schema = "tribopipe.template/1"\n', encoding="utf-8")
    bench.put("a.csv", export(1))
    bench.look()
    (told,) = bench.told(SETTLE)
    assert told.kind == "waiting"
    assert "still to be filled in: conditions.normal_load; the run is processed automatically after" in told.text
    bench.start()
    assert bench.settled() == []
    manifest = bench.runs / "a" / "run.toml"
    filled = manifest.read_text("utf-8").replace("[conditions]", '[conditions]\nnormal_load = "5 N"')
    manifest.write_text(filled, encoding="utf-8")
    assert bench.look() == []
    assert bench.look(SETTLE) == [("done", "a.csv", "a")]
    assert bench.taken == ["a"]


def test_what_goes_on_while_it_is_read_settles_again(bench, monkeypatch):
    path, plain = bench.put("a.csv", export(1, rows=12)), processing.make_run

    def late(wanted):
        path.write_bytes(export(1, rows=20))
        monkeypatch.setattr(processing, "make_run", plain)
        return plain(wanted)

    monkeypatch.setattr(processing, "make_run", late)
    assert bench.settled() == []
    assert bench.made == {}
    assert [run for *_, run in bench.settled()] == ["a", "a"]
    assert bench.made == {"a": export(1, rows=20)}


def test_what_cannot_be_opened_is_tried_again_at_the_next_start(bench, monkeypatch):
    bench.put("a.csv", export(1))
    with monkeypatch.context() as patch:
        patch.setattr(
            processing, "content_of", lambda _: (_ for _ in ()).throw(PermissionError(13, "Permission denied"))
        )
        assert bench.settled() == [("left", "a.csv", None)]
        assert bench.settled() == []
    bench.start()
    assert [kind for kind, *_ in bench.settled()] == ["made", "done"]


def test_a_folder_that_goes_away_is_waited_for(bench, tmp_path):
    bench.put("a.csv", export(1))
    bench.look()
    bench.folder.rename(tmp_path / "away")
    assert [kind for kind, *_ in bench.look(SETTLE) + bench.look(SETTLE)] == ["gone"]
    (tmp_path / "away").rename(bench.folder)
    assert [kind for kind, *_ in bench.look(SETTLE) + bench.look(SETTLE)] == ["back", "made", "done"]


# --- processing ---


def failing(error: TribopipeError, run: Path, **_) -> tuple[Outcome, ...]:
    return (Outcome.failed(str(run), "ingest", error),)


def test_a_run_at_fault_is_tried_again_when_run_toml_changes(bench, monkeypatch):
    bench.put("a.csv", export(1))
    error = ManifestError("a: found it wanting")
    with monkeypatch.context() as patch:
        patch.setattr(processing, "_through_the_line", partial(failing, error))
        assert [kind for kind, *_ in bench.settled()] == ["made", "failed"]
    bench.start()
    assert bench.settled() == []
    manifest = bench.runs / "a" / "run.toml"
    manifest.write_bytes(manifest.read_bytes() + b"# mended\n")
    assert bench.settled() == [("done", "a.csv", "a")]


def test_a_run_is_evaluated_again_when_its_run_toml_is_amended(bench):
    bench.put("a.csv", export(1))
    assert [kind for kind, *_ in bench.settled()] == ["made", "done"]
    bench.start()
    assert bench.settled() == []
    manifest = bench.runs / "a" / "run.toml"
    manifest.write_bytes(manifest.read_bytes() + b"# measured today\n")
    assert bench.look() == []
    assert bench.look(SETTLE) == [("done", "a.csv", "a")]
    bench.start()
    assert bench.settled() == []
    assert bench.taken == ["a", "a"]


def test_what_is_no_fault_of_the_run_is_tried_again_at_the_next_start(bench, monkeypatch):
    bench.put("a.csv", export(1))
    with monkeypatch.context() as patch:
        patch.setattr(processing, "_through_the_line", partial(failing, ArchiveError("archive: no room")))
        assert [kind for kind, *_ in bench.settled()] == ["made", "failed"]
        assert bench.settled() == []
    bench.start()
    assert bench.look() == [("done", "a.csv", "a")]


def test_a_process_that_is_lost_over_a_run_is_a_failure(bench, monkeypatch):
    def fail(*_, **__):
        raise ZeroDivisionError

    monkeypatch.setattr("tribopipe.base.failures._kept", lambda _: "")
    monkeypatch.setattr(processing, "_through_the_line", fail)
    bench.put("a.csv", export(1))
    assert bench.settled() == [("made", "a.csv", "a"), ("failed", "a.csv", "a")]


@pytest.mark.slow
@pytest.mark.usefixtures("few_draws")
def test_an_export_goes_through_the_line_and_on(tmp_path):
    bench = Bench(tmp_path)
    bench.put("a.csv", export(1, rows=40))
    made, done = bench.told() + bench.told(SETTLE)
    assert done.text == "a: archived; evaluated"
    assert done.details[0].startswith("μ")
    assert {step["stage"] for step in done.as_json()["steps"]} >= {"ingest", "friction_fit", "wear_fit"}
    manifest = bench.runs / "a" / "run.toml"
    manifest.write_text(f"{manifest.read_text('utf-8')}# measured today\n", encoding="utf-8")
    bench.look()
    (done,) = bench.told(SETTLE)
    assert done.details[0] == "run.toml amended; the earlier version is kept"
    bench.put("a.csv", export(1, rows=60))
    bench.look()
    made, done = bench.told(SETTLE)
    assert made.text == "a.csv: run a-2, since data were added to the file after run a was created from it"
    archive = Archive(bench.lab.archive)
    assert archive.ids() == ["a", "a-2"]
    assert archive.bad("a").reason == "data were added to the file after ingestion; run a-2 contains the complete test"
    assert archive.bad("a-2") is None
    archive.path("a-2").write_bytes(b"damaged")
    bench.put("a.csv", export(1, rows=80))
    assert [(kind, run) for kind, _, run in bench.settled()] == [("made", "a-3"), ("failed", "a-3")]
    assert "a-3" in archive.ids()


# --- restarts ---


def test_a_watch_that_ends_after_a_run_is_made_leaves_it_to_the_next(bench):
    bench.put("a.csv", export(1))
    bench.look()
    bench.now += SETTLE
    assert next(bench.watcher.look(bench.now)).kind == "made"
    bench.start()
    assert bench.look() == [("done", "a.csv", "a")]
    assert bench.look(SETTLE) == []


def test_a_run_that_was_begun_is_made_under_its_id_even_if_the_file_was_renamed(bench, monkeypatch):
    def crash(_):
        raise KeyboardInterrupt

    bench.put("a.csv", export(1))
    for crashed in ("make_run", "_made"):
        with monkeypatch.context() as patch:
            patch.setattr(processing, crashed, lambda *_: crash(_))
            bench.start()
            bench.look()
            with pytest.raises(KeyboardInterrupt):
                bench.look(SETTLE)
    assert bench.made == {"a": export(1)}
    (bench.runs / ".a.0123abcd.part").mkdir()
    (bench.folder / "a.csv").rename(bench.folder / "b.csv")
    bench.start()
    assert bench.settled() == [("made", "b.csv", "a"), ("done", "b.csv", "a")]
    assert bench.made == {"a": export(1)}


def test_without_its_journal_a_watch_finds_the_runs_that_are_there(bench):
    bench.put("a.csv", export(1))
    bench.settled()
    shutil.rmtree(bench.runs / ".watch")
    (bench.runs / ".watch").mkdir()
    bench.start()
    assert bench.settled() == [("made", "a.csv", "a"), ("done", "a.csv", "a")]
    assert bench.made == {"a": export(1)}


def test_a_line_cut_in_the_middle_is_passed_over(tmp_path):
    (tmp_path / ".watch").mkdir()
    journal, path = Journal(tmp_path), tmp_path / ".watch" / "journal.jsonl"
    entry = Entry(name="Prüfung.csv", stamp="1", sha256="ab", state="begun", run="a")
    journal.note(entry)
    done = entry.model_copy(update={"state": "done"})
    journal.note(done)
    path.write_bytes(path.read_bytes() + b'{"name": "b.csv", "st')
    again = Journal(tmp_path)
    assert (again.newest(entry.name), again.newest("b.csv"), again.run_of("ab")) == (done, None, done)
    assert len(path.read_bytes().splitlines()) == 1


def test_one_watch_alone_makes_runs_in_a_folder(tmp_path):
    with (
        alone(tmp_path / "runs"),
        pytest.raises(ArchiveError, match="another `tribopipe watch`"),
        alone(tmp_path / "runs"),
    ):
        pass
    with alone(tmp_path / "runs"):
        pass


steps = st.one_of(
    st.tuples(st.just("write"), st.integers(0, 3)),
    st.tuples(st.just("look"), st.floats(0, 2 * SETTLE)),
    st.tuples(st.just("crash"), st.integers(0, 4)),
)


@pytest.mark.slow
@settings(max_examples=6)
@given(plan=st.lists(steps, max_size=20))
def test_whatever_happens_when_each_file_is_one_run(plan, tmp_path_factory):
    """Files grow in chunks, looks are taken and cut short at any event; chunks come faster than files settle."""
    with pytest.MonkeyPatch.context() as patch:
        at_once.taken = []
        patch.setattr(processing, "_through_the_line", at_once)
        bench = Bench(tmp_path_factory.mktemp("lab"))
        whole = {f"f{number}.csv": export(number, rows=8) for number in range(4)}
        written = dict.fromkeys(whole, 0)
        for what, how in plan:
            if what == "write":
                name = f"f{how}.csv"
                written[name] = len(whole[name])
                bench.put(name, whole[name][: written[name] // 2])
                bench.look()
                bench.put(name, whole[name])
            elif what == "look":
                bench.look(how)
            else:
                for _ in zip(range(how), bench.watcher.look(bench.now + SETTLE), strict=False):
                    pass
                bench.start()
        for _ in range(3):
            bench.look(SETTLE)
        expected = {name.removesuffix(".csv"): whole[name] for name, size in written.items() if size}
        assert sorted(bench.made.items()) == sorted(expected.items())
        assert set(at_once.taken) == set(expected)


# --- the command ---


@pytest.fixture
def lab(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "in").mkdir()
    (tmp_path / "lab.toml").write_text(TEMPLATE, encoding="utf-8")
    return tmp_path


@pytest.mark.usefixtures("taken")
def test_once_deals_with_what_is_there_and_says_so(run_cli, lab):
    (lab / "in" / "a.csv").write_bytes(export(1))
    (lab / "in" / "notes.txt").write_bytes(b"the disc rang\n")
    command = ["watch", "in", "--template", "lab.toml", "--settle", "0", "--once", "--json"]
    done = run_cli(*command)
    assert done.exit_code == 3
    told = [json.loads(line) for line in done.stdout.splitlines()]
    assert [(one["event"], one["file"], one["id"]) for one in told] == [
        ("made", "a.csv", "a"),
        ("left", "notes.txt", None),
        ("done", "a.csv", "a"),
    ]
    assert done.stderr.splitlines()[-1] == "1 archived, 1 ignored"
    assert (lab / "runs" / "a" / "a.csv").read_bytes() == export(1)
    again = run_cli(*command)
    assert (again.exit_code, again.stdout, again.stderr) == (0, "", "")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["away"], "found no folder at this path"),
        (["in", "--runs", "."], "found a folder within the folder of runs or the archive"),
        (["in", "--template", "run.toml"], "run.toml"),
    ],
)
def test_what_cannot_be_watched_is_refused(run_cli, lab, words, told):
    done = run_cli("watch", *words, "--once", cwd=lab)
    assert done.exit_code == 1
    assert told in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_an_end_is_told_in_a_line():
    assert counted([]) == "nothing new"
    assert counted(["made", "done", "made", "failed", "done"]) == "2 archived, 1 failed"


def test_what_has_gone_has_moved(tmp_path):
    assert moves(Drop("a", (tmp_path / "a",), "1"))


# --- with a real clock, and signals ---


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="Windows sends no signals to a process")
def test_few_files():
    script = ROOT / "benchmarks" / "watched_folder.py"
    command = [sys.executable, str(script), "--files", "8", "--seconds", "16", "--settle", "2"]
    done = subprocess.run(command, capture_output=True, text=True, encoding="utf-8")
    assert done.returncode == 0, done.stdout + done.stderr

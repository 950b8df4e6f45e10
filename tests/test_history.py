"""The history of an archive: loss, exchange and rollback are seen whatever came after, a killed writer is none."""

import io
import json
import os
import random
import shutil
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from itertools import count, takewhile
from pathlib import Path

import numpy as np
import pytest
from archived_files import edited
from folders import tree_bytes
from killed import Killed, dying_at
from sweeps import others_slow
from test_archive import run_with

import tribopipe.pipeline.verify.history as verifying
from tribopipe.archive import history
from tribopipe.archive.file_signature import stamps
from tribopipe.archive.history import FILE_NAME, FIRST, Account, chained, entry, hash_of
from tribopipe.archive.lock import LOCKS
from tribopipe.archive.removal import remove, restore
from tribopipe.archive.store import Archive
from tribopipe.archive.studyfile import StoredStudy
from tribopipe.base.errors import ArchiveError
from tribopipe.base.files import sha256_of
from tribopipe.documents.annotation import Annotation
from tribopipe.documents.study import Study
from tribopipe.pipeline.verify.archive import verify
from tribopipe.results.finding import Finding
from tribopipe.results.run import RawRun
from tribopipe.results.study import MeasuredCurve, StudyCurve, StudyResult

DATE = "2026-11-01T08:00:00+00:00"
CATALOGUE = "catalogue.sqlite"
RUN, OTHER, STUDY = "bare", "other", "both"
FILES = [f"{RUN}.h5", f"{OTHER}.h5", f"studies/{STUDY}.h5"]


def note(text: str) -> Annotation:
    return Annotation(kind="note", text=text, date=DATE)


def study(title: str) -> StoredStudy:
    document = Study(id=STUDY, title=title, fit=(RUN,), predict=(OTHER,), laws=("archard",))
    result = StudyResult(id=STUDY, title=title, tribometer="pin-on-disc", correction="model", laws=())
    values = np.arange(3.0)
    told = ("fitted", "pin", "wear_depth", "sliding_distance")
    curve = StudyCurve(RUN, "archard", *told, values, values, values, values, MeasuredCurve(values, values, values))
    return StoredStudy(document, result, "inputs", {}, "0.1.0", DATE, curves=(curve,))


def called(bare: RawRun, name: str) -> RawRun:
    run = run_with(bare, np.arange(10.0))
    return run_with(bare, np.arange(10.0), manifest=run.manifest.model_copy(update={"id": name}))


def rewrite(folder: Path, name: str, text: str) -> None:
    """Write a file of the archive anew, as a command does."""
    if name.startswith("studies/"):
        Archive(folder).put_study(study(text))
    else:
        Archive(folder).annotate(Path(name).stem, note(text))


@pytest.fixture(scope="module")
def _made(bare_run, tmp_path_factory) -> Path:
    archive = Archive(tmp_path_factory.mktemp("made") / "archive")
    for name in (RUN, OTHER):
        archive.add(called(bare_run, name))
    archive.put_study(study("first"))
    return archive.folder


@pytest.fixture
def folder(_made, tmp_path) -> Path:
    """An archive of two small runs and a study of them."""
    return Path(shutil.copytree(_made, tmp_path / "archive"))


def errors(folder: Path, against: str = "") -> list[Finding]:
    """Return what verify finds, but for notes."""
    return [one for one in verify(Archive(folder), against=against).findings if one.severity != "note"]


def alarms(folder: Path) -> list[Finding]:
    """Return what only the history finds, which takes less time."""
    looks, _ = verifying.look_into_history(folder, stamps(folder).keys())
    return [one for look in looks for one in look.findings if one.severity != "note"]


def told(folder: Path) -> set[tuple[str, str, str]]:
    findings = verify(Archive(folder)).findings
    return {(one.where.partition(":")[0], one.severity, one.code) for one in findings if one.code != "catalog"}


def wrong(*names: str) -> set[tuple[str, str, str]]:
    return {(name, "error", "history") for name in names}


# --- loss, exchange, rollback ---


def delete(path: Path, older: Path, another: Path) -> None:  # noqa: ARG001
    path.unlink()


def exchange(path: Path, older: Path, another: Path) -> None:  # noqa: ARG001
    shutil.copyfile(another, path)


def roll_back(path: Path, older: Path, another: Path) -> None:  # noqa: ARG001
    shutil.copyfile(older, path)


ATTACKS = (delete, exchange, roll_back)
Attack = Callable[[Path, Path, Path], None]


def seen(run_cli, folder: Path, name: str) -> bool:
    """Tell whether `verify` ends with exit code 1 and names the file."""
    done = run_cli("verify", folder)
    return done.exit_code == 1 and f"error: {name}: found" in done.output


def attacked(run_cli, folder: Path, name: str, attack: Attack, another: Path, *, catalogue: bool) -> list[bool]:
    """Attack a file; tell whether it is seen at once, after `ls`, and after everything else was written to."""
    if catalogue:
        run_cli("ls", "--archive", folder)
    older = Path(shutil.copy(folder / name, folder.parent / "older"))
    rewrite(folder, name, "second")
    if not catalogue:
        (folder / CATALOGUE).unlink(missing_ok=True)
    assert run_cli("verify", folder).exit_code == 0
    attack(folder / name, older, another)
    at_once = seen(run_cli, folder, name)
    run_cli("ls", "--archive", folder)
    after_ls = seen(run_cli, folder, name)
    (folder / CATALOGUE).unlink()
    run_cli("ls", "--archive", folder)
    return [at_once, after_ls, seen(run_cli, folder, name)]


@pytest.mark.parametrize(
    ("name", "attack"),
    [
        pytest.param(name, attack, marks=() if number == place else pytest.mark.slow)
        for number, name in enumerate(FILES)
        for place, attack in enumerate(ATTACKS)
    ],
)
@pytest.mark.parametrize("catalogue", others_slow([True, False], True))
def test_loss_exchange_and_rollback_are_seen(run_cli, folder, tmp_path, name, attack, catalogue):
    elsewhere = Path(shutil.copytree(folder, tmp_path / "elsewhere"))
    rewrite(elsewhere, name, "of another")
    outcome = attacked(run_cli, folder, name, attack, elsewhere / name, catalogue=catalogue)
    assert outcome == [True, True, True]


@pytest.mark.slow
@pytest.mark.parametrize("ls", [False, True])
def test_two_runs_in_the_place_of_each_other_are_both_named(run_cli, folder, ls):
    """Though no file of the archive is lost or older."""
    if ls:
        run_cli("ls", "--archive", folder)
    one, other = (folder / name for name in FILES[:2])
    kept = one.read_bytes()
    shutil.copyfile(other, one)
    other.write_bytes(kept)
    for _ in range(2):
        done = run_cli("verify", folder)
        assert done.exit_code == 1
        assert all(f"error: {name}: found" in done.output for name in FILES[:2])
        run_cli("ls", "--archive", folder)


@pytest.mark.skipif(os.name == "nt", reason="Windows has other rights")
def test_a_read_only_run_stays_and_no_alarm_follows(run_cli, folder):
    """The history has announced the write by then."""
    path = folder / FILES[0]
    path.chmod(0o444)
    before = path.read_bytes()
    refused = run_cli("note", RUN, "dry", "--archive", folder)
    assert (refused.exit_code, path.read_bytes(), path.stat().st_mode & 0o777) == (1, before, 0o444)
    assert "read-only" in refused.stderr
    assert "damaged" not in refused.stderr
    assert run_cli("verify", folder).exit_code == 0
    path.chmod(0o644)
    assert run_cli("note", RUN, "dry", "--archive", folder).exit_code == 0
    assert errors(folder) == []


@pytest.mark.slow
@pytest.mark.parametrize("attack", [exchange, roll_back])
def test_writing_to_an_exchanged_file_does_not_hide_it(folder, tmp_path, attack):
    older = Path(shutil.copy(folder / FILES[0], tmp_path))
    another = Path(shutil.copy(folder / FILES[0], tmp_path / "another"))
    with edited(another) as file:
        file.attrs["creator_version"] = "another"
    rewrite(folder, FILES[0], "second")
    attack(folder / FILES[0], older, another)
    rewrite(folder, FILES[0], "third")
    rewrite(folder, FILES[0], "fourth")
    (finding,) = errors(folder)
    assert (finding.where, finding.code) == (FILES[0], "history")
    assert "a file that had been replaced before tribopipe changed it on" in finding.message


def test_rollback_says_from_when_to_when(folder, tmp_path):
    older = shutil.copy(folder / FILES[0], tmp_path)
    since = Account(folder).read().files[FILES[0]].date
    rewrite(folder, FILES[0], "second")
    shutil.copy(older, folder)
    (finding,) = errors(folder)
    assert f"found the version written on {since}; expected the version written on 20" in finding.message
    assert f"tribopipe verify --accept {RUN}`" in finding.remedy


def test_a_run_alone_is_held_against_the_history_too(folder, tmp_path, run_cli):
    older = shutil.copy(folder / FILES[0], tmp_path)
    rewrite(folder, FILES[0], "second")
    shutil.copy(older, folder)
    assert run_cli("verify", folder, "--run", RUN).exit_code == 1
    assert run_cli("verify", folder, "--run", OTHER).exit_code == 0


def test_what_is_damaged_is_told_once(folder):
    path = folder / FILES[0]
    content = bytearray(path.read_bytes())
    content[120] ^= 1
    path.write_bytes(content)
    assert [(one.where, one.code) for one in errors(folder)] == [(FILES[0], "seal")]


# --- acknowledged ---


def test_a_run_that_is_gone_is_reported_until_somebody_accepts_that(run_cli, folder):
    (folder / FILES[1]).unlink()
    for _ in range(2):
        assert seen(run_cli, folder, FILES[1])
    done = run_cli("verify", folder, "--accept", OTHER, "--json")
    assert done.exit_code == 0
    assert f"{FILES[1]}: accepted as it is\n" in done.output
    last = json.loads((folder / FILE_NAME).read_text(encoding="utf-8").splitlines()[-1])
    assert (last["event"], last["file"], "after" in last) == ("accepted", FILES[1], False)
    assert json.loads(done.stdout)["head"] == Account(folder).read().head
    assert run_cli("verify", folder).exit_code == 0


@pytest.mark.parametrize("wanted", others_slow([STUDY, f"studies/{STUDY}", f"studies/{STUDY}.h5"]))
def test_an_older_study_is_accepted(run_cli, folder, tmp_path, wanted):
    older = shutil.copy(folder / FILES[2], tmp_path)
    rewrite(folder, FILES[2], "second")
    shutil.copy(older, folder / "studies")
    assert run_cli("verify", folder, "--accept", wanted).exit_code == 0
    rewrite(folder, FILES[2], "third")
    assert run_cli("verify", folder).exit_code == 0


@pytest.mark.parametrize("wanted", [RUN, "bear", FILE_NAME])
def test_nothing_is_accepted_that_was_not_reported(run_cli, folder, wanted):
    (folder / FILES[1]).unlink()
    before = tree_bytes(folder)
    done = run_cli("verify", folder, "--accept", wanted)
    assert done.exit_code == 1
    assert "found nothing to accept for" in done.output
    assert tree_bytes(folder) == before


# --- the whole archive ---


@pytest.mark.slow
def test_the_whole_archive_put_back_is_seen_by_a_hash_kept_elsewhere(run_cli, folder, tmp_path):
    older = shutil.copytree(folder, tmp_path / "older")
    rewrite(folder, FILES[0], "second")
    shown = run_cli("verify", folder).output
    head = shown.partition("last hash ")[2].split()[0]
    assert run_cli("verify", folder, "--against", head).exit_code == 0
    rewrite(folder, FILES[0], "third")
    assert run_cli("verify", folder, "--against", head.upper()).exit_code == 0
    shutil.rmtree(folder)
    shutil.copytree(older, folder)
    assert run_cli("verify", folder).exit_code == 0
    done = run_cli("verify", folder, "--against", head)
    assert done.exit_code == 1
    assert f"error: {FILE_NAME}: found no line with the hash {head} in the history" in done.stdout


# --- put in by hand ---


@pytest.mark.slow
def test_a_file_put_in_by_hand_is_told_once(folder, tmp_path, bare_run):
    Archive(tmp_path / "second").add(called(bare_run, "third"))
    shutil.copy(tmp_path / "second" / "third.h5", folder)
    assert told(folder) == {("third.h5", "note", "history")}
    assert told(folder) == set()
    (folder / "third.h5").unlink()
    assert told(folder) == wrong("third.h5")


@pytest.mark.slow
def test_a_file_put_in_by_hand_and_written_to_is_told_once(folder, tmp_path, bare_run):
    Archive(tmp_path / "second").add(called(bare_run, "third"))
    shutil.copy(tmp_path / "second" / "third.h5", folder)
    rewrite(folder, "third.h5", "mine")
    assert told(folder) == {("third.h5", "note", "history")}
    assert told(folder) == set()


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such names")
def test_a_file_with_a_name_that_no_run_has_hurts_nobody(folder):
    shutil.copy(folder / FILES[0], folder / "odd\n\x1b[31m:.h5")
    assert {severity for _, severity, _ in told(folder)} == {"error"}
    shutil.copy(folder / FILES[2], folder / "studies" / "a:b.h5")
    assert told(folder) == told(folder)


def test_where_nobody_can_write_files_are_held_against_the_history_all_the_same(folder, monkeypatch):
    def refuse(*_, **__):
        raise PermissionError

    shutil.copy(folder / FILES[0], folder / "studies" / "odd.h5")
    (folder / FILES[1]).unlink()
    monkeypatch.setattr(verifying, "writers_lock", refuse)
    monkeypatch.setattr(verifying, "append", refuse)
    assert wrong(FILES[1]) <= told(folder)


# --- the history itself ---


def lines_of(folder: Path) -> list[bytes]:
    return (folder / FILE_NAME).read_bytes().splitlines(keepends=True)


def dropped(lines: list[bytes], place: int) -> list[bytes]:
    return lines[:place] + lines[place + 1 :]


def changed(lines: list[bytes], place: int) -> list[bytes]:
    return [*lines[:place], lines[place].replace(b"20", b"19", 1), *lines[place + 1 :]]


def garbled(lines: list[bytes], place: int) -> list[bytes]:
    return [*lines[:place], b"\x00\xff{\n", *lines[place + 1 :]]


def doubled(lines: list[bytes], place: int) -> list[bytes]:
    return [*lines[: place + 1], *lines[place:]]


def cut(lines: list[bytes], place: int) -> list[bytes]:
    return lines[:place]


def cut_within(lines: list[bytes], place: int) -> list[bytes]:
    return [*lines[:place], lines[place][: len(lines[place]) // 2]]


@pytest.mark.parametrize("tamper", [dropped, changed, garbled, doubled, cut, cut_within])
def test_a_history_that_is_not_as_it_was_written_is_seen(folder, tamper):
    rewrite(folder, FILES[0], "second")
    lines = lines_of(folder)
    for place in range(len(lines)):
        (folder / FILE_NAME).write_bytes(b"".join(tamper(lines, place)))
        assert FILE_NAME in {one.where.partition(":")[0] for one in alarms(folder)}, place


@pytest.mark.slow
def test_a_removed_history_is_seen_and_the_next_write_does_not_hide_it(run_cli, folder):
    (folder / FILE_NAME).unlink()
    assert seen(run_cli, folder, FILE_NAME)
    rewrite(folder, FILES[0], "second")
    assert told(folder) == wrong(FILE_NAME) | {(name, "note", "history") for name in FILES}
    assert told(folder) == wrong(FILE_NAME) | {(name, "note", "history") for name in FILES}
    assert run_cli("verify", folder, "--accept", FILE_NAME).exit_code == 0
    assert told(folder) == set()
    (folder / FILES[1]).unlink()
    assert told(folder) == wrong(FILES[1])


@pytest.mark.slow
def test_an_archive_without_a_history_begins_one_once_that_is_accepted(run_cli, folder):
    (folder / FILE_NAME).unlink()
    shutil.rmtree(folder / LOCKS)
    assert seen(run_cli, folder, FILE_NAME)
    assert run_cli("verify", folder, "--accept", FILE_NAME).exit_code == 0
    assert told(folder) == set()
    assert set(Account(folder).read().files) == set(FILES)


def test_an_archive_without_a_history_that_is_written_to_says_what_was_there(folder):
    (folder / FILE_NAME).unlink()
    shutil.rmtree(folder / LOCKS)
    rewrite(folder, FILES[0], "second")
    (finding,) = errors(folder)
    assert "starts on" in finding.message
    assert "after 3 runs and studies were archived" in finding.message


@pytest.mark.slow
def test_a_cut_history_is_seen_after_the_next_write(run_cli, folder):
    lines = lines_of(folder)
    (folder / FILE_NAME).write_bytes(b"".join(lines[:-2]))
    rewrite(folder, FILES[0], "second")
    assert told(folder) == wrong(FILE_NAME) | {(FILES[2], "note", "history")}
    assert run_cli("verify", folder, "--accept", FILE_NAME).exit_code == 0
    assert told(folder) == set()


@pytest.mark.slow
def test_what_is_accepted_of_a_history_is_that_and_no_more(run_cli, folder):
    lines = lines_of(folder)
    (folder / FILE_NAME).write_bytes(b"".join(changed(lines, 2)))
    assert run_cli("verify", folder, "--accept", FILE_NAME).exit_code == 0
    assert told(folder) == set()
    (folder / FILE_NAME).write_bytes(b"".join(changed(lines_of(folder), 4)))
    assert told(folder) == wrong(FILE_NAME)


@pytest.mark.slow
@pytest.mark.parametrize(
    "content",
    others_slow(
        [b"x" * 200_000, b"\xff\xfe\n" * 9, b"[" * 60_000 + b"\n", b'{"event":"done","date":"","file":"../a.h5"}\n'],
    ),
)
def test_a_hostile_history_is_told_in_a_sentence(run_cli, folder, content):
    (folder / FILE_NAME).write_bytes(content)
    done = run_cli("verify", folder)
    assert done.exit_code == 1
    assert f"error: {FILE_NAME}: " in done.stdout
    assert "bug in tribopipe" not in done.output
    noted = run_cli("note", RUN, "dry", "--archive", folder)
    assert noted.exit_code == 0 or f"{FILE_NAME}: found a last line of more than 65,536 bytes" in noted.output
    assert wrong(FILE_NAME) <= told(folder)
    shutil.rmtree(folder / LOCKS)
    assert wrong(FILE_NAME) <= told(folder)


def test_a_history_that_is_no_file_is_told_in_a_sentence(run_cli, folder):
    (folder / FILE_NAME).unlink()
    (folder / FILE_NAME).mkdir()
    assert seen(run_cli, folder, FILE_NAME)
    before = (folder / FILES[0]).read_bytes()
    done = run_cli("note", RUN, "dry", "--archive", folder)
    assert (done.exit_code, len(done.output.splitlines())) == (1, 1)
    assert (folder / FILES[0]).read_bytes() == before


def test_a_line_says_what_was_written_and_follows_the_one_before(folder):
    lines = [line.rstrip(b"\n") for line in lines_of(folder)]
    read = [json.loads(line) for line in lines]
    assert [one.get("previous", FIRST) for one in read] == [FIRST, *map(hash_of, lines[:-1])]
    changes = {one["file"]: one["after"] for one in read if one["event"] == "written"}
    assert list(changes) == FILES
    for name, state in changes.items():
        assert state.encode() in (folder / name).read_bytes()[:512]


@pytest.mark.slow
def test_a_history_of_which_nothing_is_left_but_the_end_is_seen(folder):
    shutil.rmtree(folder / LOCKS)
    for lines in (lines_of(folder)[1:], [b"half\n", *lines_of(folder)[1:]], [b"half\n"]):
        (folder / FILE_NAME).write_bytes(b"".join(lines))
        assert wrong(FILE_NAME) <= told(folder)


def test_a_first_line_that_was_half_written_is_passed_over(bare_run, tmp_path):
    (tmp_path / FILE_NAME).write_bytes(b'{"date":"20')
    assert told(tmp_path) == set()
    Archive(tmp_path).add(called(bare_run, RUN))
    assert told(tmp_path) == set()


# --- killed ---


def change_run(archive: Archive, bare: RawRun) -> None:  # noqa: ARG001
    archive.annotate(RUN, note("dry"))


def add_run(archive: Archive, bare: RawRun) -> None:
    archive.add(called(bare, "third"))


def change_study(archive: Archive, bare: RawRun) -> None:  # noqa: ARG001
    archive.put_study(study("second"))


def take_in(archive: Archive, bare: RawRun) -> None:  # noqa: ARG001
    (kept,) = archive.folder.glob(f"removed/*/{FILES[1]}")
    archive.adopt(OTHER, [kept.read_bytes()], sha256_of(kept))


def take_out(archive: Archive, bare: RawRun) -> None:  # noqa: ARG001
    remove(archive, OTHER, force=True)


def put_back(archive: Archive, bare: RawRun) -> None:  # noqa: ARG001
    restore(archive, OTHER)


MOMENTS = [(history, "_added"), (history, "_keep_head"), (Path, "mkdir")]
"""At which processes end, beside those at which files are put on the disk and given their name."""


@pytest.mark.slow
@pytest.mark.parametrize(
    "change",
    others_slow(
        [change_run, add_run, take_out, change_study, take_in, put_back],
        change_run,
    ),
)
def test_wherever_a_writer_is_killed_there_is_no_alarm(folder, bare_run, tmp_path, change):
    if change in (take_in, put_back):
        remove(Archive(folder), OTHER, force=True)
    ended = 0
    for moment in count():
        at = Path(shutil.copytree(folder, tmp_path / f"moment-{moment}"))
        before = tree_bytes(at)
        with pytest.MonkeyPatch.context() as patch:
            dying_at(patch, moment, MOMENTS)
            try:
                change(Archive(at), bare_run)
                break
            except Killed:
                ended += 1
        if moment % 2:  # a look in between settles what was left open
            assert alarms(at) == []
        rewrite(at, FILES[0], "next")
        assert alarms(at) == []
        missing = before.keys() - tree_bytes(at).keys() - {FILES[1]}
        assert {name for name in missing if not name.startswith("removed/")} == set()
        assert (at / FILES[1]).is_file() or list(at.glob(f"removed/*/{FILES[1]}"))
    assert errors(at) == []
    assert ended > 6


def test_what_a_killed_writer_left_open_is_settled_and_then_a_rollback_is_seen(folder, tmp_path):
    older = shutil.copy(folder / FILES[0], tmp_path)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(history, "_keep_head", lambda *_: patch.setattr(history, "_added", killed))
        with pytest.raises(Killed):
            rewrite(folder, FILES[0], "second")
    assert (folder / FILES[0]).read_bytes() != Path(older).read_bytes()
    assert errors(folder) == []
    shutil.copy(older, folder)
    assert told(folder) == wrong(FILES[0])


def killed(*_):
    raise Killed


def test_a_line_that_was_half_written_is_passed_over(folder, tmp_path):
    rewrite(folder, FILES[0], "second")
    lines = lines_of(folder)
    head = hash_of(lines[-2].rstrip(b"\n"))
    for length in range(0, len(lines[-1]), 7):
        at = Path(shutil.copytree(folder, tmp_path / "archive-cut"))
        (at / FILE_NAME).write_bytes(b"".join(lines[:-1]) + lines[-1][:length])
        (at / LOCKS / "history.head").write_text(head, encoding="ascii")
        account = Account(at).read()
        assert (account.problems, account.missing()) == ([], None)
        history.append(at, [entry("done", FILES[0])])
        account.read()
        assert (account.problems, account.missing(), account.files[FILES[0]].unconfirmed) == ([], None, False)
        shutil.rmtree(at)


def test_a_write_that_was_done_is_not_called_failed_where_that_cannot_be_noted(folder, monkeypatch):
    plain, calls = history.append, count()

    def without_room(*arguments):
        if next(calls):
            raise OSError(28, "No space left on device")
        plain(*arguments)

    with monkeypatch.context() as patch:
        patch.setattr(history, "append", without_room)
        rewrite(folder, FILES[0], "second")
    assert [one.text for one in Archive(folder).annotations(RUN)] == ["second"]
    assert errors(folder) == []


def test_without_room_for_a_line_nothing_is_written(folder, monkeypatch):
    before = tree_bytes(folder)

    def no_room(*_):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(history, "chained", no_room)
        with pytest.raises(ArchiveError, match="No space left"):
            rewrite(folder, FILES[0], "second")
    assert tree_bytes(folder) == before


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="Windows forks no processes")
@pytest.mark.parametrize("times", [4, 60])
def test_writers_killed_at_any_moment_raise_no_alarm(folder, tmp_path, times):
    from forks import forked
    from forks import killed as ended_by_that

    parent = os.getpid()

    def write(name: str) -> None:
        for number in takewhile(lambda _: os.getppid() == parent, count()):
            rewrite(folder, name, str(number))

    chance = random.Random(21)  # noqa: S311
    for _ in range(times):
        writers = [forked(partial(write, name), tmp_path / "said") for name in (*FILES, FILES[0])]
        time.sleep(chance.uniform(0.0, 0.2))
        for writer in writers:
            assert ended_by_that(writer)
            if chance.random() < 0.2:
                assert alarms(folder) == []
    assert errors(folder) == []
    assert Account(folder).read().lines > times


# --- several at once ---


@pytest.mark.slow
def test_many_writers_share_one_history(bare_run, tmp_path):
    folder = tmp_path / "archive"

    def write(writer: int) -> None:
        archive = Archive(folder)
        for number in range(3):
            archive.add(called(bare_run, f"run-{writer}-{number}"))
            archive.annotate(f"run-{writer}-{number}", note("first"))

    with ThreadPoolExecutor(4) as pool:
        written = [pool.submit(write, writer) for writer in range(4)]
        while not all(one.done() for one in written):
            assert not folder.is_dir() or errors(folder) == []
    assert [one.result() for one in written] == [None] * 4
    account = Account(folder).read()
    assert (account.problems, account.lines) == ([], 1 + 2 * 2 * 12)
    assert errors(folder) == []


@pytest.mark.slow
def test_a_batch_of_several_processes_writes_one_history(run_cli, short_runs, tmp_path):
    done = run_cli("process", short_runs, "--archive", tmp_path / "archive", "-j", "2", "--no-figures")
    assert done.exit_code == 0
    assert errors(tmp_path / "archive") == []
    assert {known.unconfirmed for known in Account(tmp_path / "archive").read().files.values()} == {False}


@pytest.mark.slow
def test_a_write_reads_the_end_of_the_history_alone(folder, monkeypatch):
    long, head = chained((entry("done", FILES[0]) for _ in range(20_000)), Account(folder).read().head)
    with (folder / FILE_NAME).open("ab") as file:
        file.write(long)
    (folder / LOCKS / "history.head").write_text(head, encoding="ascii")
    monkeypatch.setattr(history, "_has_line", killed)
    sizes = []

    class Counted(io.FileIO):
        def read(self, size=-1, /):
            sizes.append(size)
            return super().read(size)

    monkeypatch.setattr(history, "_opened", lambda path, _: Counted(path, "r+"))
    for _ in range(5):
        history.append(folder, [entry("done", FILES[0])])
    assert len(sizes) == 5
    assert 0 < min(sizes) <= max(sizes) < 5000
    assert Account(folder).read().problems == []


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="Windows has other rights")
def test_those_who_may_write_into_the_archive_may_write_its_history(bare_run, tmp_path):
    (tmp_path / "shared").mkdir()
    (tmp_path / "shared").chmod(0o2775)
    Archive(tmp_path / "shared").add(called(bare_run, RUN))
    assert (tmp_path / "shared" / FILE_NAME).stat().st_mode & 0o020
    (tmp_path / "own").mkdir(mode=0o700)
    Archive(tmp_path / "own").add(called(bare_run, RUN))
    assert not (tmp_path / "own" / FILE_NAME).stat().st_mode & 0o022


def test_a_history_of_another_account_is_replaced_where_the_folder_may_be_written(folder, monkeypatch):
    plain = Path.open

    def refuse(path, mode="r", *more, **named):
        if path.name == FILE_NAME and mode == "r+b":
            raise PermissionError(13, "Permission denied", str(path))
        return plain(path, mode, *more, **named)

    before = (folder / FILE_NAME).read_bytes()
    with monkeypatch.context() as patch:
        patch.setattr(Path, "open", refuse)
        rewrite(folder, FILES[0], "second")
    assert (folder / FILE_NAME).read_bytes().startswith(before)
    assert errors(folder) == []
    assert not [path for path in folder.iterdir() if path.name.endswith(".part")]


# --- removed on purpose ---


def test_a_removed_run_is_listed_no_more_and_comes_back(run_cli, folder):
    content = (folder / FILES[1]).read_bytes()
    refused = run_cli("remove", OTHER, "--archive", folder)
    assert refused.exit_code == 1
    assert refused.stderr.startswith(f"error: {folder / FILES[1]}: found a run that belongs to the study {STUDY};")
    done = run_cli("remove", OTHER, "--force", "--archive", folder, "--json")
    (file,) = json.loads(done.stdout)["files"]
    assert (done.exit_code, file["id"], file["error"]) == (0, OTHER, None)
    assert Path(file["file"]).read_bytes() == content
    assert Archive(folder).ids() == [RUN]
    assert [run["id"] for run in json.loads(run_cli("ls", "--archive", folder, "--json").stdout)["runs"]] == [RUN]
    assert run_cli("verify", folder).exit_code == 0
    back = run_cli("restore", OTHER, "--archive", folder)
    assert (back.exit_code, (folder / FILES[1]).read_bytes()) == (0, content)
    assert told(folder) == set()


def test_a_removed_study_comes_back(run_cli, folder):
    assert run_cli("remove", STUDY, "--study", "--archive", folder).exit_code == 0
    assert Archive(folder).study_ids() == []
    assert run_cli("remove", OTHER, "--archive", folder).exit_code == 0
    assert run_cli("restore", STUDY, "--study", "--archive", folder).exit_code == 0
    assert Archive(folder).study_ids() == [STUDY]
    assert errors(folder) == []


def test_of_runs_removed_several_times_the_last_comes_back(folder, bare_run):
    archive, kept = Archive(folder), []
    for text in ("second", "third"):
        rewrite(folder, FILES[1], text)
        kept.append(remove(archive, OTHER, force=True))
        archive.add(called(bare_run, OTHER))
    with pytest.raises(ArchiveError, match="found an existing file"):
        restore(archive, OTHER)
    remove(archive, OTHER, force=True)
    restore(archive, OTHER)
    assert archive.annotations(OTHER) == []
    assert all(path.is_file() for path in kept)
    assert errors(folder) == []


def test_a_removed_run_may_be_put_back_by_hand(folder):
    remove(Archive(folder), OTHER, force=True).rename(folder / FILES[1])
    assert told(folder) == {(FILES[1], "note", "history")}
    assert told(folder) == set()


def test_a_removed_run_that_is_damaged_stays_where_it_is(folder):
    kept = remove(Archive(folder), OTHER, force=True)
    kept.write_bytes(kept.read_bytes()[:-1])
    with pytest.raises(ArchiveError, match=rf"{OTHER}\.h5: cannot be added to the archive; .*damaged"):
        restore(Archive(folder), OTHER)
    assert kept.is_file()
    assert Archive(folder).ids() == [RUN]
    assert errors(folder) == []


@pytest.mark.parametrize(
    ("words", "found"),
    [
        (["remove", "othr"], "did you mean 'other'?"),
        (["remove", "bth", "--study"], "did you mean 'both'?"),
        (["restore", OTHER], "none are available"),
    ],
)
def test_what_is_not_there_is_neither_removed_nor_restored(run_cli, folder, words, found):
    before = tree_bytes(folder)
    done = run_cli(*words, "--archive", folder)
    assert (done.exit_code, found in done.stderr) == (1, True)
    assert tree_bytes(folder) == before


def test_others_are_removed_where_one_cannot_be(run_cli, folder):
    done = run_cli("remove", "nobody", RUN, "--force", "--archive", folder)
    assert done.exit_code == 3
    assert Archive(folder).ids() == [OTHER]

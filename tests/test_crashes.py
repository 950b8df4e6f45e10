"""Interrupts, full disks, archives that go away and mistakes of our own: a sentence, nothing half-written, and the rest
of a batch is done. What kills processes at random moments stands in benchmarks/reliability."""

import errno
import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import h5py
import pytest
from folders import ROOT
from listening import listening
from matplotlib.figure import Figure

from tribopipe.archive.lock import writers_lock
from tribopipe.archive.store import Archive
from tribopipe.base import failures as faults
from tribopipe.base import process_lifecycle
from tribopipe.base.errors import ArchiveError, InternalError, ReaderError, TribopipeError
from tribopipe.base.files import leftovers, write_file
from tribopipe.base.process_lifecycle import ONE_THREAD
from tribopipe.documents.annotation import Annotation
from tribopipe.pipeline.verify import nexus
from tribopipe.readers.subprocess_readers import answer_of
from tribopipe.results.run import SourceFile
from tribopipe.views.archived_figures import run_is_drawn
from tribopipe.views.run_figures import save_beside, save_figures

RUN = "si3n4-air-200mN"
WRITING = "tribopipe.archive.file_access.LateErrors"
NOTE = Annotation(kind="note", text="dry", date="2026-01-05T08:00:00+00:00", operator="anna")
posix = pytest.mark.skipif(sys.platform == "win32", reason="Windows sends no signals to a process")


def no_room(*_, **__):
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


# --- interrupts ---


def interrupted(code: str, number: int = signal.SIGINT, said: str = "begun", **how) -> subprocess.CompletedProcess:
    """Start the command with some code as its module `tribopipe.cli.app`, and send it a signal once it says so."""
    how = {"preexec_fn": listening, **how}
    script = (
        "import sys, types\n"
        "app = types.ModuleType('tribopipe.cli.app')\n"
        f"exec({code!r}, app.__dict__)\n"
        "sys.modules['tribopipe.cli.app'] = app\n"
        "from tribopipe.cli.entry_point import main\n"
        "main()\n"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **how
    )
    assert process.stdout.readline().strip() == said
    process.send_signal(number)
    out, err = process.communicate(timeout=30)
    return subprocess.CompletedProcess(script, process.returncode, out, err)


WAITS = "import time\ndef main():\n    print('begun', flush=True)\n    time.sleep(20)\n"


@posix
@pytest.mark.parametrize(
    ("number", "how"),
    [(signal.SIGINT, "interrupted"), (signal.SIGTERM, "terminated"), (1, "ended because the terminal was closed")],
)
def test_a_signal_ends_the_command_with_one_sentence(number, how):
    done = interrupted(WAITS, number)
    assert done.returncode == 128 + number
    assert done.stderr == f"{how}; archived results are kept; run the same command again to continue\n"


@posix
def test_an_exception_that_is_swallowed_hides_no_interrupt():
    swallows = (
        "import time\n"
        "class Late:\n"
        "    def __del__(self):\n"
        "        print('begun', flush=True)\n"
        "        time.sleep(20)\n"
        "def main():\n"
        "    Late()\n"
    )
    done = interrupted(swallows)
    assert done.returncode == 130
    assert done.stderr.startswith("interrupted;")
    assert len(done.stderr.splitlines()) == 1


@posix
def test_ctrl_c_while_modules_are_imported():
    script = (
        "import os, signal, sys\n"
        "class Slow:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        "        if name == 'typer':\n"
        "            os.kill(os.getpid(), signal.SIGINT)\n"
        "sys.meta_path.insert(0, Slow())\n"
        "from tribopipe.cli.entry_point import main\n"
        "main()\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, preexec_fn=listening)
    assert (done.returncode, done.stderr.partition(";")[0]) == (130, "interrupted")


@pytest.mark.slow
@posix
def test_what_nohup_has_ignored_stays_ignored():
    code = "import time\ndef main():\n    print('begun', flush=True)\n    time.sleep(0.3)\n    print('done')\n"
    done = interrupted(code, preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_IGN))
    assert (done.returncode, done.stdout.strip(), done.stderr) == (0, "done", "")


@posix
def test_an_interrupted_write_leaves_nothing(tmp_path):
    code = (
        "import time\n"
        "from pathlib import Path\n"
        "from tribopipe.base.files import replacing\n"
        "def main():\n"
        f"    with replacing(Path({str(tmp_path / 'run.h5')!r})) as part:\n"
        "        part.write_text('half')\n"
        "        print('begun', flush=True)\n"
        "        time.sleep(20)\n"
    )
    assert interrupted(code).returncode == 130
    assert list(tmp_path.iterdir()) == []


def test_what_was_begun_is_undone_in_turn_and_no_more_once_it_is_done():
    undone = []
    with process_lifecycle.undone_by(lambda: undone.append("outer")):
        with process_lifecycle.undone_by(lambda: undone.append("done")):
            pass
        with process_lifecycle.undone_by(lambda: undone.append("inner")):
            process_lifecycle.undo_all()
    assert undone == ["inner", "outer"]
    process_lifecycle.undo_all()
    assert undone == ["inner", "outer"]


def test_a_reader_of_its_own_process_ends_with_the_command(monkeypatch):
    plain = subprocess.Popen.communicate

    def interrupted_meanwhile(process, *given, **named):
        process_lifecycle.undo_all()
        return plain(process, *given, **named)

    monkeypatch.setattr(subprocess.Popen, "communicate", interrupted_meanwhile)
    with pytest.raises(ReaderError, match="memory, or fails"):
        answer_of("nexus_fields.py", SourceFile("run.h5", b""), remedy="none")


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such limits")
def test_a_limit_that_is_there_already_is_no_damage():
    """A node of a cluster may allow less than a reader asks for; nobody can ask for more than that."""
    script = """
import json, resource
resource.setrlimit(resource.RLIMIT_AS, (700 << 20, 700 << 20))
resource.setrlimit(resource.RLIMIT_CPU, (50, 100))
from tribopipe.readers.subprocess_readers import answer_of
from tribopipe.results.run import SourceFile
asked = SourceFile("a pattern", json.dumps(["b(.)", ["a", "abc"]]).encode())
print(answer_of("regex_search.py", asked, remedy="none").decode())
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, env=os.environ | ONE_THREAD)
    assert done.stdout.strip() == '[1, "c"]', done.stderr


# --- errors of the system ---


@pytest.mark.parametrize("number", [errno.EMFILE, errno.ENFILE, errno.ENOMEM, errno.ESTALE, errno.EACCES, errno.EIO])
@pytest.mark.parametrize("call", ["open", "File", "read"])
def test_a_sound_file_that_the_system_does_not_give_is_not_called_damaged(archive, monkeypatch, call, number):
    """Whoever is told to restore a copy may overwrite what is good."""

    def fail(*_, **__):
        if call == "read":  # as h5py says it
            raise OSError(f"Can't synchronously read data (file read failed: errno = {number}, error message = '…')")
        raise MemoryError if number == errno.ENOMEM else OSError(number, os.strerror(number))

    patched = {"open": (Path, "open"), "File": (h5py, "File"), "read": (h5py.Group, "__getitem__")}[call]
    monkeypatch.setattr(*patched, fail)
    with pytest.raises((ArchiveError, OSError, MemoryError)) as raised:
        Archive(archive).raw(RUN)
    told = str(faults.in_a_sentence(raised.value, RUN))
    assert re.search("damaged|copy|bug in tribopipe", told) is None
    assert os.strerror(number) in told or "too little memory" in told


def test_a_part_that_hdf5_was_not_given_is_not_called_missing(archive, monkeypatch):
    plain = h5py.h5o.open

    def fail(place, name, *given, **named):
        if name.endswith(b"archived/raw_sha256"):  # as h5py says it, line end and all
            raise KeyError("Unable to synchronously open object (file read failed: time = Tue\n, errno = 5, error")
        return plain(place, name, *given, **named)

    monkeypatch.setattr(h5py.h5o, "open", fail)
    with pytest.raises(ArchiveError, match=r"cannot be read \(.*error\)") as raised:
        Archive(archive).raw_sha256(RUN)
    assert "damaged" not in str(raised.value)


def test_parts_are_not_asked_for_by_what_hides_errors_of_the_system(archive, monkeypatch):
    """Of a part that HDF5 was not given, h5py's values() and items() give None, as of one that is not there."""
    whole = Archive(archive).raw(RUN)
    monkeypatch.setattr(h5py.Group, "get", lambda *_, **__: None)
    read = Archive(archive).cleaned(RUN)
    assert [source.name for source in read.sources] == [source.name for source in whole.sources]


@pytest.mark.slow
def test_verify_says_nothing_else_of_a_file_that_the_system_does_not_give(run_cli, archive, monkeypatch):
    plain, calls = nexus._field, iter(range(5))

    def fail(dataset):
        if next(calls, None) is None:
            raise OSError(f"Can't synchronously read data (file read failed: time = x\n, errno = {errno.ESTALE}, ")
        return plain(dataset)

    monkeypatch.setattr(nexus, "_field", fail)
    told = run_cli("verify", archive)
    assert told.exit_code == 1
    (said,) = [line for line in told.output.splitlines() if line.startswith(("error", "warning"))]
    assert said.startswith(f"error: {RUN}.h5: cannot be read ({os.strerror(errno.ESTALE)}); ")


@pytest.mark.parametrize("number", [errno.EMFILE, errno.EIO])
def test_a_write_that_is_done_is_not_called_failed(archive, monkeypatch, number):
    """Whoever believed so would write a note twice."""
    failing = {"stat": False}
    replace, stat = Path.replace, Path.stat

    def replaced(part, path):
        failing["stat"] = True
        return replace(part, path)

    def seen(path, **how):
        if failing["stat"] and path.suffix == ".h5":
            raise OSError(number, os.strerror(number))
        return stat(path, **how)

    with monkeypatch.context() as patch:
        patch.setattr(Path, "replace", replaced)
        patch.setattr(Path, "stat", seen)
        Archive(archive).annotate(RUN, NOTE)
    assert Archive(archive).annotations(RUN) == [NOTE]


# --- no room ---


@pytest.fixture
def store(archive) -> Archive:
    return Archive(archive)


@pytest.mark.slow
def test_what_a_killed_writer_left_goes_with_the_next_write_of_anything(store):
    left = [store.folder / f".{RUN}.h5.abcdefgh.part", store.folder / "studies" / ".one.h5.abcdefgh.part"]
    written = store.folder / ".written.h5.abcdefgh.part"
    left[1].parent.mkdir(exist_ok=True)
    for part in (*left, written):
        part.write_bytes(b"half")
    with writers_lock(store.folder, "written"):
        store.annotate(RUN, NOTE)
    assert [part.exists() for part in (*left, written)] == [False, False, True]
    Archive(store.folder).annotate(RUN, NOTE)
    assert leftovers(store.folder) == []


def test_what_a_killed_writer_left_of_figures_goes_once_these_are_drawn_again(store):
    figures = store.folder / "figures"
    own = write_file_in(figures, f".{RUN}-friction.png.abcdefgh.part")
    young, old = (write_file_in(figures, f".{name}-friction.png.abcdefgh.part") for name in ("young", "old"))
    os.utime(old, (0, 0))
    save_beside(store, RUN, {f"{RUN}-friction.png": Figure()})
    assert [part.exists() for part in (own, young, old)] == [False, True, False]


@pytest.mark.parametrize(
    "call", ["os.open", "os.fsync", "os.replace", "tribopipe.archive.file_access.LateErrors.write_all"]
)
def test_without_room_a_file_stays_as_it_was(store, monkeypatch, call):
    before = store.path(RUN).read_bytes()
    with monkeypatch.context() as patch:
        patch.setattr(call, no_room)
        with pytest.raises(ArchiveError, match=r"cannot be written \(No space left on device\)"):
            store.annotate(RUN, NOTE)
    assert store.path(RUN).read_bytes() == before
    assert leftovers(store.folder) == []
    store.annotate(RUN, NOTE)
    assert store.annotations(RUN) == [NOTE]


def test_without_room_an_error_names_the_file_that_was_wanted(tmp_path, monkeypatch):
    monkeypatch.setattr("os.fsync", no_room)
    with pytest.raises(OSError, match="No space left") as raised:
        write_file(tmp_path / "report.html", b"<p>")
    assert raised.value.filename == str(tmp_path / "report.html")


def test_without_room_no_figure_takes_its_place(tmp_path, monkeypatch):
    (tmp_path / "a.png").write_bytes(b"old, by tribopipe")
    monkeypatch.setattr("os.fsync", no_room)
    with pytest.raises(ArchiveError, match="figures cannot be written"):
        save_figures(tmp_path, {"a.png": Figure(), "b.png": Figure()})
    assert [(path.name, path.read_bytes()) for path in tmp_path.iterdir()] == [("a.png", b"old, by tribopipe")]


@pytest.mark.slow
def test_a_batch_goes_on_where_figures_have_no_room(run_cli, archive, short_runs, monkeypatch):
    (archive / "figures").mkdir()
    monkeypatch.setattr("tribopipe.views.archived_figures.save_run_figures", no_room)
    monkeypatch.setattr("tribopipe.views.archived_figures.run_is_drawn", lambda *_: False)
    done = run_cli("process", short_runs / RUN, "--archive", archive)
    assert done.exit_code == 1
    assert f"\n {RUN} " in done.stdout
    assert done.stderr.splitlines()[-1].startswith(f"error: {RUN}: cannot be read or written (No space left on device)")


def test_figures_that_an_interrupt_prevented_are_drawn_next_time(store):
    assert not run_is_drawn(store, RUN)
    figures = store.folder / "figures"
    write_file_in(figures, f"{RUN}-friction.png")
    assert not run_is_drawn(store, RUN)
    first = write_file_in(figures, f"{RUN}-depth.png")
    assert run_is_drawn(store, RUN)
    os.utime(first, (0, 0))
    assert not run_is_drawn(store, RUN)


def write_file_in(folder: Path, name: str) -> Path:
    folder.mkdir(exist_ok=True)
    write_file(folder / name, b"picture")
    return folder / name


@pytest.mark.slow
def test_where_one_run_cannot_be_written_the_others_are(run_cli, archive, monkeypatch):
    plain = Archive.annotate
    shutil.copyfile(archive / f"{RUN}.h5", archive / "again.h5")

    def annotate(store, run_id, *added):
        return no_room() if run_id == RUN else plain(store, run_id, *added)

    monkeypatch.setattr(Archive, "annotate", annotate)
    for command in (["note", RUN, "again", "dry"], ["tag", RUN, "again", "--add", "dry"]):
        done = run_cli(*command, "--archive", archive)
        assert done.exit_code == 3
        assert done.output.splitlines()[0].startswith("again: ")
        assert done.stderr.splitlines()[-1].startswith(f"error: {RUN}: cannot be read or written (No space left")


# --- an archive that goes away, or may not be read ---


def test_an_archive_that_has_gone_is_not_begun_anew(store, tmp_path):
    run = store.raw(RUN)
    shutil.move(store.folder, tmp_path / "elsewhere")
    with pytest.raises(ArchiveError, match="found that the archive folder no longer exists"):
        store.add(run)
    assert not store.folder.exists()


def test_a_file_that_may_not_be_read_is_not_called_damaged(store, monkeypatch):
    def refuse(path):
        raise PermissionError(errno.EACCES, "Permission denied", str(path))

    monkeypatch.setattr("tribopipe.archive.file_access.is_sealed", refuse)
    with pytest.raises(ArchiveError, match=r"si3n4-air-200mN\.h5: cannot be read \(Permission denied\)"):
        store.manifest(RUN)


# --- mistakes of our own ---


@pytest.fixture
def fresh_faults(tmp_path, monkeypatch):
    """Have tracebacks kept here, in a file not begun yet."""
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    faults._file.cache_clear()
    yield tmp_path
    faults._file.cache_clear()


def test_a_mistake_in_one_run_does_not_end_the_batch(run_cli, short_runs, tmp_path, monkeypatch, fresh_faults):
    from tribopipe.evaluation.checks import registry

    def stumble(run):
        return 1 // 0 if run.id == RUN else registry.check_run(run)

    monkeypatch.setattr("tribopipe.pipeline.stages.check_run", stumble)
    done = run_cli("ingest", short_runs, "--archive", tmp_path / "archive")
    (kept,) = fresh_faults.glob("tribopipe-fault-*.txt")
    assert done.exit_code == 3
    assert Archive(tmp_path / "archive").ids() == ["si3n4-air-400mN"]
    assert "Traceback" not in done.stderr
    assert f"{RUN}: found a bug in tribopipe (ZeroDivisionError: " in done.stderr
    assert str(kept) in done.stderr
    assert "in stumble" in kept.read_text(encoding="utf-8")


@pytest.mark.usefixtures("fresh_faults")
def test_a_mistake_anywhere_is_one_sentence(run_cli, archive, monkeypatch):
    monkeypatch.setattr("tribopipe.archive.store.Archive.outline", lambda *_: {}["depth"])
    done = run_cli("show", RUN, "--archive", archive)
    assert done.exit_code == 1
    assert len(done.stderr.splitlines()) == 1
    assert done.stderr.startswith("error: found a bug in tribopipe (KeyError: ")


def test_tracebacks_of_a_process_are_kept_in_one_file(fresh_faults):
    told = {str(faults.in_a_sentence(KeyError(name), "run")) for name in ("a", "b")}
    (kept,) = fresh_faults.glob("tribopipe-fault-*.txt")
    assert all(str(kept) in sentence for sentence in told)
    assert kept.read_text(encoding="utf-8").count("KeyError") == 2


@pytest.mark.usefixtures("fresh_faults")
def test_a_traceback_that_cannot_be_kept_is_told(monkeypatch):
    monkeypatch.setattr("tempfile.NamedTemporaryFile", no_room)
    told = faults.in_a_sentence(KeyError("a"), "run")
    assert isinstance(told, InternalError)
    assert str(told).endswith("please report it; its traceback could not be saved (No space left on device)")


@pytest.mark.parametrize(
    ("error", "told"),
    [
        (OSError(errno.ENOSPC, "No space left on device", "a.csv"), "a.csv: cannot be read or written (No space left"),
        (OSError(errno.EACCES, "Permission denied"), "run: cannot be read or written (Permission denied)"),
        (OSError("odd"), "run: cannot be read or written (odd)"),
        (MemoryError(), "run: found too little memory"),
        (ArchiveError("as it stands"), "as it stands"),
    ],
)
def test_what_goes_wrong_outside_is_told_as_such(error, told):
    found = faults.in_a_sentence(error, "run")
    assert isinstance(found, TribopipeError)
    assert not isinstance(found, InternalError)
    assert str(found).startswith(told)


# --- few points of what the benchmarks try at many ---


@pytest.mark.slow
@posix
@pytest.mark.parametrize(
    "words",
    [
        ["kills.py", "--points", "3"],
        ["interrupts.py", "--points", "2", "--runs", "2"],
        ["many_writers.py", "--points", "8"],
        ["full_disk.py", "--points", "1"],
        ["killed_commands.py", "--points", "1"],
        ["injected_errors.py", "--points", "4"],
    ],
    ids=lambda words: words[0],
)
def test_few_points(words):
    script = ROOT / "benchmarks" / "reliability" / words[0]
    done = subprocess.run([sys.executable, str(script), *words[1:]], capture_output=True, text=True, encoding="utf-8")
    assert done.returncode == 0, done.stdout + done.stderr

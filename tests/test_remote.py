"""Archives on remote storage: what is read is what the folder holds, nothing is written, and failures are sentences."""

import json
import os
import pickle
import sqlite3
import subprocess
import sys
import warnings
from contextlib import closing
from pathlib import Path

import fsspec
import numpy as np
import pytest
from browse_client import serving as client_of
from folders import tree_bytes
from range_server import serving

from tribopipe.archive import remote, remote_blocks
from tribopipe.archive.catalog.catalog import Catalogue, Known, Note, keep
from tribopipe.archive.catalog.database import FILE_NAME
from tribopipe.archive.remote import archive_path
from tribopipe.archive.store import Archive, open_archive
from tribopipe.base.errors import ArchiveError
from tribopipe.documents.annotation import Annotation, Mark

RUN, FILE = "si3n4-air-200mN", "si3n4-air-200mN.h5"
NAMED = "found the address of a remote archive, which can only be read"


@pytest.fixture
def listed(archive) -> Path:
    """The archive of one processed run, with its catalog."""
    Catalogue(archive).refresh()
    return archive


@pytest.fixture
def server(listed):
    with serving(listed) as running:
        yield running


@pytest.fixture
def in_blocks(monkeypatch):
    """Have every run read in small blocks."""
    monkeypatch.setattr(remote, "LARGEST_WHOLE", 1000)
    for module in (remote, remote_blocks):
        monkeypatch.setattr(module, "BLOCK", 4096)


def fetched(server) -> list[str]:
    return [request.name for request in server.requests]


def sentence(answer) -> str:
    """Return the only line of what is said on stderr, without the hint at `tribopipe help`."""
    assert answer.exit_code == 1
    assert answer.stdout == ""
    (line,) = [line for line in answer.stderr.splitlines() if line.startswith("error: ")]
    assert "Traceback" not in answer.stderr
    return line


def same_columns(run, other) -> bool:
    return run.columns.keys() == other.columns.keys() and all(
        np.array_equal(run.columns[name], other.columns[name], equal_nan=True) for name in run.columns
    )


# --- reading ---


def test_list_is_that_of_the_folder(run_cli, server, listed):
    assert (
        run_cli("ls", "--json", "--archive", server.address).stdout
        == run_cli("ls", "--json", "--archive", listed).stdout
    )
    assert fetched(server) == [FILE_NAME]


def test_title_of_the_list_has_the_address(run_cli, server):
    assert run_cli("ls", "--archive", f"{server.address}/").stdout.startswith(f"1 run in {server.address};")


def test_run_is_shown_as_from_the_folder(run_cli, server, listed):
    there = run_cli("show", RUN, "--archive", server.address)
    assert there.stdout == run_cli("show", RUN, "--archive", listed).stdout.replace(str(listed), server.address)
    assert fetched(server) == [FILE_NAME, FILE]


@pytest.mark.slow
def test_figures_are_saved_in_the_current_folder(run_cli, server, tmp_path):
    (here := tmp_path / "here").mkdir()
    done = run_cli("show", RUN, "--plot", "--archive", server.address, cwd=here)
    assert done.exit_code == 0, done.stderr
    drawn = sorted(path.name for path in (here / "figures").iterdir())
    assert f"{RUN}-depth.png" in drawn
    assert str(Path("figures") / f"{RUN}-depth.png") in done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("as_blocks", [False, True])
def test_pages_and_plots_are_those_of_the_folder(request, server, listed, as_blocks):
    if as_blocks:
        request.getfixturevalue("in_blocks")
    wanted = ["/api/runs?where=", f"/api/runs/{RUN}", f"/api/runs/{RUN}/plots/wear?width=300", "/api/studies"]
    viewed = f"/h5/data?file={FILE}&path=/entry/raw/depth&format=json"
    with client_of(archive_path(server.address)) as away, client_of(listed) as here:
        for target in (*wanted, viewed):
            ours, theirs = away.send(target), here.send(target)
            assert ours.status == theirs.status == 200
            assert (
                {**dict(ours.json), "revision": ""} == {**dict(theirs.json), "revision": ""}
                if isinstance(ours.json, dict)
                else ours.json == theirs.json
            )
        about = away.send("/api/archive").json
    assert about["folder"] == server.address
    assert about["runs"] == 1


@pytest.mark.slow
def test_exports_and_reports_are_written_here(run_cli, server, tmp_path):
    (here := tmp_path / "here").mkdir()
    for command in (
        ["export", "csv", RUN],
        ["export", "runs", "-o", "runs.csv"],
        ["export", "--ro-crate", "crate", "--no-report"],
        ["report", RUN],
    ):
        done = run_cli(*command, "--archive", server.address, cwd=here)
        assert done.exit_code == 0, done.stderr
    assert {path.name for path in here.iterdir()} >= {"csv", "runs.csv", "crate", f"{RUN}.html"}


def test_archive_in_python(server, listed):
    away, here = Archive(server.address), Archive(listed)
    assert repr(away) == f"Archive('{server.address}', 1 runs)"
    assert away.ids() == here.ids() == [RUN]
    assert away.study_ids() == []
    assert same_columns(away[RUN].run, here[RUN].run)
    assert away.table().equals(here.table())
    assert str(away.path(RUN)) == f"{server.address}/{FILE}"
    assert same_columns(pickle.loads(pickle.dumps(away)).raw(RUN), here.raw(RUN))  # noqa: S301
    assert open_archive(server.address).ids() == [RUN]
    with pytest.raises(ArchiveError, match=f"{server.address}: found no run 'other'; expected the ID"):
        away.raw("other")


def test_studies_of_a_run_are_found_in_the_catalog(listed, server):
    with closing(sqlite3.connect(listed / FILE_NAME, isolation_level=None)) as catalog:
        note = Note("studies/air.h5", Known("1 2 3 4", settled=True, sha256="0"), members=[(RUN, None)])
        keep(catalog, [note])
    assert Archive(server.address).studies_of(RUN) == ["air"]
    assert Archive(server.address).study_ids() == ["air"]
    assert Archive(server.address).ids() == [RUN]
    assert fetched(server) == [FILE_NAME]


@pytest.mark.slow
@pytest.mark.usefixtures("in_blocks")
def test_large_run_is_read_in_blocks(server, listed):
    away, here = Archive(server.address), Archive(listed)
    assert away.outline(RUN) == here.outline(RUN)
    size = (listed / FILE).stat().st_size
    assert sum(request.sent for request in server.requests if request.name == FILE) < size
    assert {request.status for request in server.requests} == {200, 206}  # 200 for the catalog, and for the length
    assert same_columns(away.raw(RUN), here.raw(RUN))
    assert away.step_names(RUN) == here.step_names(RUN)


@pytest.mark.usefixtures("in_blocks")
def test_server_without_ranges_sends_a_large_run_once(listed):
    with serving(listed, ranges=False) as server:
        assert same_columns(Archive(server.address).raw(RUN), Archive(listed).raw(RUN))
        assert [one.method for one in server.requests if one.name == FILE] == ["GET"]


def test_other_storage(listed):
    memory = fsspec.filesystem("memory")
    for path in (FILE_NAME, FILE):
        memory.pipe_file(f"/lab/{path}", (listed / path).read_bytes())
    before = memory.cat(memory.find("/lab"))
    away = Archive("memory://lab")
    assert away.ids() == [RUN]
    assert same_columns(away.raw(RUN), Archive(listed).raw(RUN))
    assert memory.cat(memory.find("/lab")) == before


# --- nothing is written ---


@pytest.mark.slow
def test_nothing_is_written_and_the_temporary_folder_goes(server, listed, tmp_path):
    (scratch := tmp_path / "scratch").mkdir()
    before, times = tree_bytes(listed), {path: path.stat().st_mtime_ns for path in listed.rglob("*")}
    command = [sys.executable, "-m", "tribopipe", "show", RUN, "-v", "--archive", server.address]
    done = subprocess.run(command, cwd=scratch, env={**os.environ, "TMPDIR": str(scratch)}, capture_output=True)
    assert done.returncode == 0, done.stderr
    assert tree_bytes(listed) == before
    assert {path: path.stat().st_mtime_ns for path in listed.rglob("*")} == times
    assert {request.method for request in server.requests} <= {"GET", "HEAD"}
    assert list(scratch.iterdir()) == []


WRITING = {
    "ingest": ["ingest", "runs"],
    "process": ["process", "runs"],
    "correct-drift": ["correct-drift"],
    "fit": ["fit"],
    "predict": ["predict"],
    "mark-bad": ["mark-bad", RUN, "--reason", "slipped"],
    "tag": ["tag", RUN, "--add", "a"],
    "note": ["note", RUN, "text"],
    "remove": ["remove", RUN],
    "restore": ["restore", RUN],
    "verify": ["verify"],
    "reproduce": ["reproduce"],
    "import": ["import", "crate"],
    "study run": ["study", "run", "study.toml"],
    "study figures": ["study", "figures", "study"],
    "watch": ["watch", "exports"],
    "local-wear": ["local-wear", RUN],
}


@pytest.mark.parametrize("command", WRITING.values(), ids=WRITING)
def test_commands_that_write_refuse_before_they_begin(run_cli, server, tmp_path, command):
    (here := tmp_path / "here").mkdir()
    said = sentence(run_cli(*command, "--archive", server.address, cwd=here))
    assert said.startswith(f"error: {server.address}: {NAMED}; expected a folder on this computer")
    assert server.requests == []
    assert list(here.iterdir()) == []


def test_an_archive_given_as_an_argument_is_refused_as_well(run_cli, server, tmp_path):
    said = sentence(run_cli("verify", server.address, cwd=tmp_path))
    assert said.startswith(f"error: {server.address}: {NAMED}; expected a folder on this computer")
    assert server.requests == []


def test_python_refuses_to_write(server, listed):
    away, run = Archive(server.address), Archive(listed).raw(RUN)
    signed = {"date": "2026-01-05T08:00:00+00:00", "operator": "anna"}
    for act in (
        away.begin,
        lambda: away.add(run, force=True),
        lambda: away.mark(RUN, Mark(kind="bad", reason="slipped", **signed)),
        lambda: away.annotate(RUN, Annotation(kind="tag", text="a", **signed)),
    ):
        with pytest.raises(ArchiveError, match=NAMED):
            act()


# --- what fails ---


def spoil(content: bytes):
    return lambda listed, _: (listed / FILE_NAME).write_bytes(content)


def of_another_version(listed, _):
    with closing(sqlite3.connect(listed / FILE_NAME)) as catalog:
        catalog.execute("PRAGMA user_version = 1")


def fault(kind, name=FILE_NAME):
    return lambda _, server: server.faults.update({name: kind})


def cut_off(listed, _):
    os.truncate(listed / FILE, 20_000)


LS, SHOW = ["ls"], ["show", RUN]
FAILURES = {
    "no catalog": (
        LS,
        lambda listed, _: (listed / FILE_NAME).unlink(),
        FILE_NAME,
        "found no such file; expected an ar",
    ),
    "no SQLite": (
        LS,
        spoil(b"<html>log in</html>" * 99),
        FILE_NAME,
        "found a catalog that cannot be used (file is not",
    ),
    "other version": (
        LS,
        of_another_version,
        FILE_NAME,
        "cannot be used (written by another version); expected one wr",
    ),
    "refused": (LS, fault("refused"), FILE_NAME, "access denied (status 403); expected permission to read; check"),
    "silent": (LS, fault("silent"), FILE_NAME, "found no response in time; expected a file; check the connection"),
    "cut": (LS, fault("cut"), FILE_NAME, "cannot be read ("),
    "run refused": (SHOW, fault("refused", FILE), FILE, "access denied (status 403); expected permission to read"),
    "run silent": (
        SHOW,
        fault("silent", FILE),
        FILE,
        "found no response in time; expected a file; check the connection",
    ),
    "run cut": (SHOW, fault("cut", FILE), FILE, "cannot be read ("),
    "run gone": (SHOW, lambda listed, _: (listed / FILE).unlink(), FILE, "found no such file; expected"),
}


@pytest.mark.parametrize(("command", "spoiled", "name", "said"), FAILURES.values(), ids=FAILURES)
def test_what_cannot_be_read_is_one_sentence(
    run_cli, server, listed, monkeypatch, request, command, spoiled, name, said
):
    if request.node.callspec.id.endswith("silent"):
        monkeypatch.setattr(remote, "ANSWER_WITHIN", 0.3)
    spoiled(listed, server)
    line = sentence(run_cli(*command, "--archive", server.address))
    assert line.startswith(f"error: {server.address}/{name}: ")
    assert said in line
    assert line.count("; ") >= 2


@pytest.mark.filterwarnings("ignore:.*differs from the catalog")
def test_truncated_run_is_one_sentence(run_cli, server, listed):
    cut_off(listed, server)
    line = sentence(run_cli("show", RUN, "--archive", server.address))
    assert f"{server.address}/{FILE}: found a damaged file (its length differs from that in its header)" in line


@pytest.mark.usefixtures("in_blocks")
@pytest.mark.parametrize(
    ("spoiled", "said"),
    [
        (cut_off, "found a damaged file (its length differs from that in its header)"),
        (fault("refused", FILE), "access denied (status 403)"),
        (fault("cut", FILE), "cannot be read ("),
    ],
)
def test_damage_of_a_run_in_blocks_is_one_sentence(run_cli, server, listed, spoiled, said):
    spoiled(listed, server)
    assert f"{server.address}/{FILE}: {said}" in sentence(run_cli("show", RUN, "--archive", server.address))


@pytest.mark.slow
@pytest.mark.usefixtures("in_blocks")
@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda path, _: os.utime(path, ns=(1, 1)), "found that the file changed while it was being read"),
        (lambda _, server: server.faults.update({FILE: "refused"}), "access denied"),
    ],
)
def test_run_that_changes_while_its_blocks_are_read_is_refused(server, listed, change, said):
    away = Archive(server.address)
    away.manifest(RUN)
    change(listed / FILE, server)
    with pytest.raises(ArchiveError, match=said):
        away.raw(RUN)


def test_changed_run_is_read_with_a_warning(server, listed):
    Archive(listed).mark(RUN, Mark(kind="bad", reason="slipped", date="2026-01-05T08:00:00+00:00", operator="anna"))
    away = Archive(server.address)
    with pytest.warns(UserWarning, match=f"{FILE}: found content that differs from the catalog") as warned:
        assert away.bad(RUN).reason == "slipped"
    assert "run `tribopipe ls` on the computer" in str(warned[0].message)


@pytest.mark.parametrize("name", ["../outside.h5", "/outside.h5", "a/b.h5", ".hidden.h5", "C:x.h5", "x\\y.h5"])
def test_names_that_lead_out_of_the_folder_are_passed_over(server, listed, name):
    with closing(sqlite3.connect(listed / FILE_NAME, isolation_level=None)) as catalog:
        keep(catalog, [Note(name, Known("1 2 3 4", settled=True, sha256="0"), cells={})])
    assert Archive(server.address).ids() == [RUN]


def test_no_server_is_one_sentence(run_cli, listed):
    with serving(listed) as gone:
        pass
    line = sentence(run_cli("ls", "--archive", gone.address))
    assert line.startswith(f"error: {gone.address}/{FILE_NAME}: cannot be read (")


def test_unknown_storage_is_one_sentence(run_cli):
    line = sentence(run_cli("ls", "--archive", "nowhere://lab/archive"))
    assert line.startswith("error: nowhere://lab/archive: cannot be read (Protocol not known: nowhere")


@pytest.mark.parametrize(("package", "address"), [("fsspec", "https://lab/a"), ("aiohttp", "https://lab/b")])
def test_missing_packages_are_named(run_cli, monkeypatch, package, address):
    for name in [name for name in sys.modules if name.split(".")[0] == package]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, package, None)
    line = sentence(run_cli("ls", "--archive", address))
    assert f"found no package {package}; expected the packages for remote archives" in line
    assert 'run `pip install "tribopipe[remote]"`' in line


# --- local archives ---


@pytest.mark.slow
def test_local_archive_needs_no_package_of_the_extra(listed):
    code = (
        f"import sys; from tribopipe.archive.store import Archive; a = Archive({str(listed)!r}); a.raw(a.ids()[0]); "
        "a.table(); print({'fsspec', 'aiohttp', 's3fs'} & {name.split('.')[0] for name in sys.modules})"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, encoding="utf-8", check=True)
    assert done.stdout.strip() == "set()"


@pytest.mark.parametrize("folder", ["archive", "/data/archive", "C:/archive", "C:\\archive", "a:b/c", "./x/y:z"])
def test_folders_stay_folders(folder):
    assert archive_path(folder) == Path(folder)
    assert type(archive_path(Path(folder))) is type(Path())


def test_folder_named_like_an_address_stays_a_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "data:" / "archive").mkdir(parents=True)
    assert type(archive_path(Path("data:/archive"))) is type(Path())


def test_nothing_is_warned_of(server):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert json.loads(json.dumps(Archive(server.address).ids())) == [RUN]

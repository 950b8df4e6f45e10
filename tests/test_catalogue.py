"""The catalogue never lies: whatever happens to the archive or to the catalogue itself, it tells what is there."""

import json
import os
import random
import shutil
import sqlite3
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from archived_files import edited
from hanging import ends_soon
from sweeps import others_slow

from tribopipe.archive import file_signature as stamps
from tribopipe.archive.catalog.catalog import Catalogue
from tribopipe.archive.catalog.database import FILE_NAME
from tribopipe.archive.catalog.listing import COLUMNS
from tribopipe.archive.catalog.reading import read_cells
from tribopipe.archive.nexus import text
from tribopipe.archive.store import Archive
from tribopipe.base.units import SPECIFIC_WEAR_RATE, WEAR_COEFFICIENT, pretty
from tribopipe.documents.annotation import Mark
from tribopipe.results.wear_fit import WearFit

pytestmark = pytest.mark.usefixtures("few_draws")

RUN, OTHER = "si3n4-air-200mN", "si3n4-air-other"
BAD = Mark(kind="bad", reason="slipped", date="2026-01-01T00:00:00+00:00")


def listed(folder: Path, where: str = "", sort: str = "id") -> list[str]:
    """Ids by a catalogue opened anew."""
    catalogue = Catalogue(folder)
    catalogue.refresh()
    return [run.id for run in catalogue.runs(where, sort)]


def retitled(path: Path, title: str) -> bytes:
    """Give a run another title of the same length, and return what the file was."""
    before = path.read_bytes()
    with edited(path) as file:
        note = file["entry/manifest/data"]
        old = file["entry/title"].asstr()[()]
        assert len(old) == len(title)
        note[()] = text(file, "entry/manifest/data").replace(old, title)
    return before


def titles(folder: Path) -> list[str]:
    catalogue = Catalogue(folder)
    catalogue.refresh()
    return [run.text("title") for run in catalogue.runs()]


@pytest.fixture
def two(archive) -> Path:
    """An archive of a processed run under two ids."""
    shutil.copy(archive / f"{RUN}.h5", archive / f"{OTHER}.h5")
    return archive


@pytest.fixture
def reads(monkeypatch) -> list[str]:
    """The ids of runs that are read from now on."""
    read: list[str] = []

    def watched(archive: Archive, run_id: str):
        read.append(run_id)
        return read_cells(archive, run_id)

    monkeypatch.setattr("tribopipe.archive.catalog.reading.read_cells", watched)
    return read


@pytest.fixture
def no_change_times(monkeypatch) -> None:
    """Leave out what os.utime cannot set: the times of change of POSIX, which Windows has not."""
    seen = stamps._stamp
    monkeypatch.setattr(stamps, "_stamp", lambda entry: (one := seen(entry)) and one._replace(changed=0))


# --- what it says ---


@pytest.mark.slow
def test_cells_say_what_the_results_say(sample_archive):
    catalogue = Catalogue(sample_archive.folder)
    catalogue.refresh()
    for run in catalogue.runs():
        fit = sample_archive.steps(run.id)["wear_fit_archard"].result
        assert run.value("k_d") == fit.first.wear_coefficient.value
        assert run.uncertainty("k_d") == fit.first.wear_coefficient.standard_uncertainty
        assert fit.first.wear_coefficient.shown("mm^3/(N*mm)") == f"{run.text('k_d')} mm³/(N·mm)"
        assert run.number("k_d") == pytest.approx(fit.first.wear_coefficient.value * 1e6, rel=1e-12)
        assert run.number("load") == pytest.approx(sample_archive.manifest(run.id).conditions.normal_load.value * 1e3)
        assert run.texts("material") == [run.text("pin_material")]


@pytest.mark.parametrize("which", others_slow(["disc_pair", "disc_archive"]))
def test_cells_of_two_discs_say_what_the_results_say(which, request):
    archive = request.getfixturevalue(which)
    discs = Catalogue(archive.folder)
    discs.refresh()
    for run in discs.runs():
        fit = archive.steps(run.id)["wear_fit_archard"].result
        assert isinstance(fit, WearFit)
        assert run.value("k_d_disc") == fit.bodies["flat_disc"].wear_coefficient.value
        assert run.value("rotations") == archive.raw(run.id).columns["rotations"][-1]


@pytest.mark.parametrize("law", ["two__stage", "late_"])
def test_steps_keep_their_names_whatever_the_law_is_called(archive, law, run_cli):
    with edited(archive / f"{RUN}.h5") as file:
        file["entry"].move("wear_fit_archard", f"wear_fit_{law}")
    names = Archive(archive).step_names(RUN)
    assert f"wear_fit_{law}" in names
    told = json.loads(run_cli("ls", "--json", "--archive", archive).stdout)
    assert told["runs"][0]["steps"] == names
    assert listed(archive, "steps=preprocessing") == listed(archive, "steps~preproc") == [RUN]
    assert listed(archive, "steps=clean_up") == listed(archive, "steps=none") == []


def test_units_of_columns_are_those_of_their_kinds():
    units = {column.unit for column in COLUMNS.values() if column.measures == "wear coefficient"}
    assert units == {pretty(WEAR_COEFFICIENT), pretty(SPECIFIC_WEAR_RATE)}


def test_every_column_can_be_asked_for(sample_archive):
    catalogue = Catalogue(sample_archive.folder)
    catalogue.refresh()
    for name, column in COLUMNS.items():
        for run in catalogue.runs(f"{name}!=none", f"-{name}"):
            assert run.text(name)
            assert column.kind != "number" or isinstance(run.number(name), float)


@pytest.mark.slow
def test_studies_and_verdicts_stand_with_the_runs(tmp_path, sample_archive):
    from tribopipe.documents.recipe import Recipe
    from tribopipe.documents.study import Study
    from tribopipe.pipeline.studies import run_study
    from tribopipe.results.study import AGREEMENT

    archive = Archive(Path(shutil.copytree(sample_archive.folder, tmp_path / "archive")))
    catalogue = Catalogue(archive.folder)
    catalogue.refresh()
    assert catalogue.runs("study!=none") == []
    study = Study(id="air", fit=("si3n4-air-200mN",), predict=("si3n4-air-400mN",), laws=("archard",))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tribopipe.physics.uncertainty.BLOCK", 200)
        assert next(run_study(archive, study, Recipe())).status != "failed"
    catalogue.refresh()
    runs = catalogue.runs("study=air")
    assert [run.id for run in runs] == ["si3n4-air-200mN", "si3n4-air-400mN"]
    verdicts = {one.id: AGREEMENT[one.outcome] for one in archive.study("air").result.laws[0].runs}
    assert [run.text("agreement") for run in runs] == [f"Archard in air: {verdicts[run.id]}" for run in runs]
    (archive.study_folder / "air.h5").unlink()
    catalogue.refresh()
    assert catalogue.runs("study!=none") == []


def test_order_is_natural_and_unknown_comes_last(two):
    archive = Archive(two)
    with edited(archive.path(OTHER)) as file:
        del file["entry/wear_fit_archard"]
    assert listed(two) == [RUN, OTHER]
    assert listed(two, sort="k_d") == listed(two, sort="-k_d") == [RUN, OTHER]
    assert listed(two, sort="-id") == [OTHER, RUN]
    assert listed(two, sort="material,-id") == [OTHER, RUN]


# --- what happens to the archive ---


def test_nothing_is_read_twice(two, reads, monkeypatch):
    monkeypatch.setattr(stamps, "_SETTLED_AFTER", 0)
    assert Catalogue(two).waiting() == [f"{RUN}.h5", f"{OTHER}.h5"]
    assert listed(two) == [RUN, OTHER]
    assert Catalogue(two).waiting() == []
    assert listed(two) == [RUN, OTHER]
    assert reads == [RUN, OTHER]


def test_read_just_after_it_was_written_is_compared_once_more(two, reads):
    for _ in range(2):
        assert Catalogue(two).waiting() == [f"{RUN}.h5", f"{OTHER}.h5"]
        assert listed(two) == [RUN, OTHER]
    assert reads == [RUN, OTHER]


def test_files_added_removed_and_replaced_are_noticed(two):
    assert listed(two) == [RUN, OTHER]
    (two / f"{OTHER}.h5").unlink()
    assert listed(two) == [RUN]
    shutil.copy(two / f"{RUN}.h5", two / f"{OTHER}.h5")
    Archive(two).mark(OTHER, BAD)
    assert listed(two, "mark=bad") == [OTHER]


@pytest.mark.usefixtures("no_change_times")
def test_replaced_moments_later_by_one_of_equal_size_and_time_is_noticed(archive):
    path = archive / f"{RUN}.h5"
    os.utime(path)
    (title,) = titles(archive)
    seen = path.stat()
    before = retitled(path, title.replace("air", "oil"))
    assert (path.stat().st_size, path.read_bytes() != before) == (seen.st_size, True)
    os.utime(path, ns=(seen.st_atime_ns, seen.st_mtime_ns))
    assert titles(archive) == [title.replace("air", "oil")]


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no time of change")
def test_changed_long_after_and_given_its_old_time_is_noticed(archive, monkeypatch):
    path = archive / f"{RUN}.h5"
    monkeypatch.setattr(stamps, "_SETTLED_AFTER", 0)
    (title,) = titles(archive)
    seen = path.stat()
    retitled(path, title.replace("air", "oil"))
    os.utime(path, ns=(seen.st_atime_ns, seen.st_mtime_ns))
    assert titles(archive) == [title.replace("air", "oil")]


@pytest.mark.usefixtures("no_change_times")
def test_clock_set_back_is_noticed(archive):
    path = archive / f"{RUN}.h5"
    future = time.time_ns() + 3_600_000_000_000
    os.utime(path, ns=(future, future))
    (title,) = titles(archive)
    retitled(path, title.replace("air", "oil"))
    os.utime(path, ns=(future, future))
    assert titles(archive) == [title.replace("air", "oil")]


def test_touched_file_is_not_read_again(archive, reads):
    listed(archive)
    os.utime(archive / f"{RUN}.h5")
    listed(archive)
    assert reads == [RUN]


def test_revision_changes_with_every_change(two):
    catalogue = Catalogue(two)
    seen = [catalogue.revision, catalogue.revision]
    assert len(set(seen)) == 1
    Archive(two).mark(RUN, BAD)
    seen.append(catalogue.revision)
    (two / f"{OTHER}.h5").unlink()
    seen.append(catalogue.revision)
    (two / "studies").mkdir()
    shutil.copy(two / f"{RUN}.h5", two / "studies" / "x.h5")
    seen.append(catalogue.revision)
    assert len(set(seen)) == 4


def test_removed_while_it_is_read_is_left_out(two, monkeypatch):
    def gone(archive: Archive, run_id: str):
        archive.path(run_id).unlink()
        return read_cells(archive, run_id)

    monkeypatch.setattr("tribopipe.archive.catalog.reading.read_cells", gone)
    catalogue = Catalogue(two)
    catalogue.refresh()
    assert (catalogue.runs(), catalogue.unreadable) == ([], [])


@pytest.mark.parametrize("content", ["empty", "missing"])
def test_archive_without_runs_is_an_empty_list(tmp_path, content):
    folder = tmp_path / "archive"
    if content == "empty":
        folder.mkdir()
    assert listed(folder) == []
    assert Catalogue(folder).revision
    assert folder.exists() is (content == "empty")


# --- what cannot be read ---


def marks_are_numbers(path):
    with edited(path) as file:
        file["entry/marks/data"] = "[1, 2]"


def manifest_is_no_json(path):
    with edited(path) as file:
        file["entry/manifest/data"][()] = "[" * 2000


def cut_short(path):
    path.write_bytes(path.read_bytes()[:3000])


@pytest.mark.parametrize(
    "damage", [cut_short, marks_are_numbers, manifest_is_no_json], ids=lambda damage: damage.__name__
)
def test_unreadable_runs_are_told_each_time_and_not_read_again(two, reads, damage, monkeypatch):
    monkeypatch.setattr(stamps, "_SETTLED_AFTER", -(10**15))
    damage(two / f"{OTHER}.h5")
    for _ in range(2):
        catalogue = Catalogue(two)
        catalogue.refresh()
        assert [run.id for run in catalogue.runs()] == [RUN]
        ((name, sentence),) = catalogue.unreadable
        assert name == f"{OTHER}.h5"
        assert sentence.startswith(str(two / name))
        assert "expected" in sentence
        assert "\n" not in sentence
    assert reads.count(OTHER) == 1


def test_study_that_cannot_be_read_is_told(archive):
    (archive / "studies").mkdir()
    (archive / "studies" / "x.h5").write_bytes(b"no HDF5")
    catalogue = Catalogue(archive)
    catalogue.refresh()
    assert [name for name, _ in catalogue.unreadable] == ["studies/x.h5"]


def test_what_is_no_file_of_ours_is_passed_over(archive):
    (archive / "folder.h5").mkdir()
    (archive / ".hidden.h5").write_bytes(b"")
    (archive / "notes.txt").write_text("x", encoding="utf-8")
    assert listed(archive) == [RUN]


# --- what happens to the catalogue itself ---


def filled(path: Path) -> bytes:
    with sqlite3.connect(path) as connection:
        connection.execute("UPDATE runs SET title = 'something else'")
    connection.close()
    return path.read_bytes()


def zero_bytes(path):
    path.write_bytes(b"")


def no_database(path):
    path.write_bytes(b"no database at all" * 500)


def halved(path):
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def pages_overwritten(path):
    content = path.read_bytes()
    path.write_bytes(content[:4096] + b"\xff" * (len(content) - 4096))


def tables_dropped(path):
    connection = sqlite3.connect(path)
    connection.executescript("DROP VIEW listed; DROP TABLE runs;")
    connection.close()


def of_another_version(path):
    filled(path)
    connection = sqlite3.connect(path)
    connection.execute("PRAGMA user_version = 7")
    connection.close()


def removed(path):
    path.unlink()


def a_folder(path):
    path.unlink()
    path.mkdir()


HARM = [zero_bytes, no_database, halved, pages_overwritten, tables_dropped, of_another_version, removed, a_folder]


@pytest.mark.parametrize("harm", HARM, ids=lambda harm: harm.__name__)
def test_harmed_catalogue_tells_the_same(two, harm):
    path, before = two / FILE_NAME, titles(two)
    harm(path)
    assert titles(two) == before
    assert path.is_dir() is (harm is a_folder)
    assert titles(two) == before


@pytest.mark.skipif(sys.platform == "win32", reason="Windows keeps an open file from being harmed")
@pytest.mark.parametrize("harm", HARM, ids=lambda harm: harm.__name__)
def test_catalogue_harmed_while_it_is_open_tells_the_same(two, harm):
    catalogue = Catalogue(two)
    catalogue.refresh()
    before = [run.text("title") for run in catalogue.runs()]
    harm(two / FILE_NAME)
    catalogue.refresh()
    assert [run.text("title") for run in catalogue.runs()] == before


def test_folder_that_cannot_be_written_is_listed_in_memory(two, monkeypatch, reads):
    assert listed(two) == [RUN, OTHER]
    content = (two / FILE_NAME).read_bytes()
    Archive(two).mark(RUN, BAD)
    connect = sqlite3.connect

    def read_only(name: str, **options):
        if name == ":memory:":
            return connect(name, **options)
        return connect(f"file:{name}?mode=ro", **options | {"uri": True})

    monkeypatch.setattr(sqlite3, "connect", read_only)
    del reads[:]
    assert listed(two, "mark=bad") == [RUN]
    assert set(reads) == {RUN}
    assert (two / FILE_NAME).read_bytes() == content
    (two / FILE_NAME).unlink()
    assert listed(two, "mark=bad") == [RUN]
    assert not (two / FILE_NAME).exists()


@pytest.mark.slow
def test_locked_catalogue_hangs_nobody_who_goes_back_to_it_at_the_next_look(two, monkeypatch, caplog):
    """One that browses or watches would work in memory for the rest of its life."""
    listed(two)
    monkeypatch.setattr("tribopipe.archive.catalog.database.SILENT", 0.1)
    monkeypatch.setattr("tribopipe.archive.catalog.database._WAIT", 0.2)
    other = sqlite3.connect(two / FILE_NAME, isolation_level=None)
    other.execute("BEGIN EXCLUSIVE")
    Archive(two).mark(RUN, BAD)
    catalogue = Catalogue(two)
    catalogue.refresh()
    assert [run.id for run in catalogue.runs("mark=bad")] == [RUN]
    Archive(two).mark(OTHER, BAD)
    monkeypatch.setattr("tribopipe.archive.catalog.database.SILENT", 120.0)  # nor is waited for any more
    with ends_soon():
        catalogue.refresh()
    assert [run.id for run in catalogue.runs("mark=bad")] == [RUN, OTHER]
    (told,) = caplog.messages
    assert "another tribopipe process is writing catalogue.sqlite; waiting" in told
    monkeypatch.setattr("tribopipe.archive.catalog.database.SILENT", 0.1)
    other.execute("ROLLBACK")
    assert other.execute("SELECT count(*) FROM runs WHERE mark = 'bad'").fetchone()[0] == 0
    catalogue.refresh()
    assert other.execute("SELECT count(*) FROM runs WHERE mark = 'bad'").fetchone()[0] == 2
    assert [run.id for run in catalogue.runs("mark=bad")] == [RUN, OTHER]
    other.execute("BEGIN EXCLUSIVE")  # waited for, and announced, once more
    Archive(two).mark(OTHER, Mark(kind="good", reason="seen again", date=BAD.date))
    catalogue.refresh()
    assert [run.id for run in catalogue.runs("mark=bad")] == [RUN]
    assert len(caplog.messages) == 2
    other.execute("ROLLBACK")
    other.close()
    assert [run.id for run in catalogue.runs("mark=bad")] == [RUN]
    assert listed(two, "mark=bad") == [RUN]


@pytest.mark.slow
@pytest.mark.parametrize(("pause", "code", "kept"), [(0.0, "FULL", 1), (60.0, "FULL", 0), (60.0, "CANTOPEN", 1)])
def test_a_file_that_was_refused_once_is_tried_again(two, monkeypatch, pause, code, kept):
    """At once where there were too many open files for a moment; after a pause where runs may be read in vain."""
    listed(two)
    connect = sqlite3.connect

    def refuse(name: str, **options):
        if name == ":memory:":
            return connect(name, **options)
        error = sqlite3.OperationalError(code)
        error.sqlite_errorcode = getattr(sqlite3, f"SQLITE_{code}")
        raise error

    monkeypatch.setattr("tribopipe.archive.catalog.database._PAUSE", pause)
    catalogue = Catalogue(two)
    with monkeypatch.context() as patch:
        patch.setattr(sqlite3, "connect", refuse)
        catalogue.refresh()
    Archive(two).mark(RUN, BAD)
    catalogue.refresh()
    assert [run.id for run in catalogue.runs("mark=bad")] == [RUN]
    file = sqlite3.connect(two / FILE_NAME)
    assert file.execute("SELECT count(*) FROM runs WHERE mark = 'bad'").fetchone()[0] == kept
    file.close()


def test_archive_that_begins_later_gets_its_catalogue(two, tmp_path):
    """As of one that watches a folder before the first run is there."""
    catalogue = Catalogue(tmp_path / "later")
    catalogue.refresh()
    shutil.copytree(two, tmp_path / "later")
    catalogue.refresh()
    assert [run.id for run in catalogue.runs()] == [RUN, OTHER]
    file = sqlite3.connect(tmp_path / "later" / FILE_NAME)
    assert file.execute("SELECT count(*) FROM runs").fetchone()[0] == 2
    file.close()


@pytest.mark.slow
def test_catalogue_is_waited_for_that_somebody_else_begins(two, monkeypatch, caplog):
    monkeypatch.setattr("tribopipe.archive.catalog.database.SILENT", 0.1)
    other = sqlite3.connect(two / FILE_NAME, isolation_level=None, check_same_thread=False)
    other.execute("BEGIN EXCLUSIVE")
    done = threading.Timer(0.5, lambda: other.execute("ROLLBACK"))
    done.start()
    same = (two / FILE_NAME).stat().st_ino
    assert listed(two) == [RUN, OTHER]
    done.join()
    assert (two / FILE_NAME).stat().st_ino == same  # nor is what another process begins taken for damaged
    other.close()
    assert "waiting up to" in caplog.text
    assert (two / FILE_NAME).stat().st_size > 0


def test_interrupted_refresh_keeps_what_was_read(two, monkeypatch, reads):
    monkeypatch.setattr("tribopipe.archive.catalog.catalog._BATCH", 1)

    def interrupt(name: str) -> None:
        raise KeyboardInterrupt(name)

    first = []
    with pytest.raises(KeyboardInterrupt):
        Catalogue(two).refresh(lambda name: interrupt(name) if first else first.append(name))
    assert listed(two) == [RUN, OTHER]
    assert len(reads) == 3


@pytest.mark.slow
def test_bytes_changed_at_random_change_nothing_that_is_told(two, monkeypatch):
    monkeypatch.setattr(stamps, "_SETTLED_AFTER", -(10**15))

    def told() -> list[list[str]]:
        catalogue = Catalogue(two)
        catalogue.refresh()
        return [[run.text(name) for name in COLUMNS] for run in catalogue.runs()]

    before, content, chance = told(), (two / FILE_NAME).read_bytes(), random.Random(1)  # noqa: S311
    for _ in range(25):
        changed = bytearray(content)
        for _ in range(chance.choice([1, 5, 50])):
            changed[chance.randrange(len(changed))] = chance.randrange(256)
        (two / FILE_NAME).write_bytes(changed)
        assert told() == before


@pytest.mark.slow
def test_threads_and_processes_refresh_at_once(two):
    code = "from tribopipe.archive.catalog.catalog import Catalogue\nfrom pathlib import Path\n"
    code += f"c = Catalogue(Path({str(two)!r}))\nc.refresh()\nprint(*[run.id for run in c.runs()])"
    others = [subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) for _ in range(2)]
    catalogue, found = Catalogue(two), []

    def look() -> None:
        catalogue.refresh()
        found.append([run.id for run in catalogue.runs()])

    threads = [threading.Thread(target=look) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [[RUN, OTHER]] * 4
    assert [other.communicate()[0].split() for other in others] == [[RUN, OTHER]] * 2


def test_values_reach_the_database_as_they_are(archive):
    store = Archive(archive)
    hostile = "'); DROP TABLE runs; -- <script>\x1b[31m\udcdf"
    store.mark(RUN, Mark(kind="bad", reason=hostile, date=BAD.date))
    catalogue = Catalogue(archive)
    catalogue.refresh()
    (run,) = catalogue.runs('marked_bad~"drop table"')
    assert run.text("marked_bad") == hostile.replace("\udcdf", "\\udcdf")

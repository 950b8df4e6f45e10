"""Slow checks of a large archive are not repeated each time, and nothing wrong is shown all the same."""

import shutil
import sqlite3
import time
from contextlib import closing
from pathlib import Path

import pytest
from test_catalogue import BAD, OTHER, RUN, listed, retitled, titles

from tribopipe.archive import file_signature
from tribopipe.archive.catalog import catalog, database, recent_checks
from tribopipe.archive.catalog.catalog import Catalogue
from tribopipe.archive.catalog.database import FILE_NAME
from tribopipe.archive.catalog.recent_checks import Check, CheckNote
from tribopipe.archive.store import Archive

pytestmark = pytest.mark.usefixtures("few_draws")


@pytest.fixture
def two(archive, monkeypatch) -> Path:
    """An archive of a processed run under two ids, listed so often that nothing of it needs to be looked at."""
    monkeypatch.setattr(file_signature, "_SETTLED_AFTER", 0)
    monkeypatch.setattr(recent_checks, "_LONG", 0.0)
    monkeypatch.setattr(recent_checks, "_SHARE", 1e9)
    shutil.copy(archive / f"{RUN}.h5", archive / f"{OTHER}.h5")
    for _ in range(3):
        time.sleep(0.01)
        listed(archive)
    return archive


@pytest.fixture
def looks(monkeypatch) -> list[str]:
    """What is looked at in full from now on: "files" or "catalog"."""
    looked: list[str] = []
    for module, function, what in ((catalog, "stamps", "files"), (database, "_refuse_damaged", "catalog")):
        original = getattr(module, function)

        def watched(argument, original=original, what=what):
            looked.append(what)
            return original(argument)

        monkeypatch.setattr(module, function, watched)
    return looked


def test_nothing_is_looked_at_again(two, looks):
    assert listed(two) == listed(two, "title!=none") == [RUN, OTHER]
    assert looks == []


def test_small_archives_are_looked_at_each_time(two, looks, monkeypatch):
    monkeypatch.setattr(recent_checks, "_LONG", 60.0)
    assert listed(two) == listed(two) == [RUN, OTHER]
    assert looks == ["catalog", "files", "catalog", "files"]


@pytest.mark.slow
def test_whatever_is_put_into_the_folder_or_removed_is_noticed(two):
    Archive(two).mark(RUN, BAD)
    assert listed(two, "mark=bad") == [RUN]
    (two / f"{OTHER}.h5").unlink()
    assert listed(two) == [RUN]
    Path(shutil.copy(two / f"{RUN}.h5", two / "part")).replace(two / f"{OTHER}.h5")
    assert listed(two, "mark=bad") == [RUN, OTHER]
    (two / "studies").mkdir()
    (two / "studies" / "x.h5").write_bytes(b"no HDF5")
    catalogue = Catalogue(two)
    catalogue.refresh()
    assert [name for name, _ in catalogue.unreadable] == ["studies/x.h5"]


def test_changed_just_before_it_is_looked_at_is_looked_at_again(two, looks, monkeypatch):
    monkeypatch.setattr(file_signature, "_SETTLED_AFTER", 3_600_000_000_000)
    assert listed(two) == listed(two) == [RUN, OTHER]
    assert looks.count("files") == 2


def test_a_file_overwritten_in_place_is_noticed_after_a_while(two, monkeypatch):
    (title, _) = titles(two)
    retitled(two / f"{RUN}.h5", title.replace("air", "oil"))
    monkeypatch.setattr(recent_checks, "_SHARE", 0.0)
    assert sorted(titles(two)) == sorted([title, title.replace("air", "oil")])


def test_the_browser_notices_the_same(two, monkeypatch):
    catalogue = Catalogue(two)
    before = catalogue.revision
    assert catalogue.revision == before
    Archive(two).mark(RUN, BAD)
    after = catalogue.revision
    assert after != before
    time.sleep(0.01)
    assert catalogue.revision == after
    retitled(two / f"{OTHER}.h5", titles(two)[0].replace("air", "oil"))
    monkeypatch.setattr(recent_checks, "_SHARE", 0.0)
    assert catalogue.revision != after


def test_clock_set_back_ends_a_check(tmp_path):
    note = CheckNote(tmp_path, "files")
    note.keep(Check("state", time.time() + 3600, 10.0))
    assert note.valid_for("state") is None
    note.keep(Check("state of two words", time.time(), 10.0))
    assert note.valid_for("state of two words").took == 10.0
    assert note.valid_for("other") is None
    (tmp_path / ".locks" / "files.checked").write_bytes(b"\xff no note")
    assert note.valid_for("state") is None


def test_own_writes_need_no_further_check(two, looks):
    Archive(two).mark(RUN, BAD)
    assert listed(two, "mark=bad") == [RUN]
    assert "catalog" not in looks
    assert listed(two, "mark=bad") == [RUN]
    assert "catalog" not in looks


def test_catalog_that_somebody_else_wrote_is_checked(two, looks):
    before = titles(two)
    with closing(sqlite3.connect(two / FILE_NAME)) as connection, connection:
        connection.execute("UPDATE runs SET title = 'something else'")
    assert titles(two) == before
    assert looks.count("catalog") >= 1


def test_own_writes_do_not_vouch_for_what_somebody_else_wrote(two):
    catalogue, before = Catalogue(two), titles(two)
    catalogue.refresh()
    with closing(sqlite3.connect(two / FILE_NAME)) as connection, connection:
        connection.execute("UPDATE runs SET title = 'something else' WHERE id = ?", [OTHER])
    Archive(two).mark(RUN, BAD)
    catalogue.refresh()
    assert titles(two) == before


@pytest.mark.parametrize("table", ["runs SET title = 'something else'", "members SET agreement = 'something else'"])
def test_a_row_changed_without_a_trace_is_not_shown(two, table):
    """As by a disk that returns other bytes."""
    state = CheckNote(two, "catalogue")
    with closing(sqlite3.connect(two / FILE_NAME)) as connection, connection:
        *_, total = ("x", "s", RUN, "agrees", database.sum_of(("x", "s", RUN, "agrees")))
        connection.execute("INSERT INTO members VALUES ('x', 's', ?, 'agrees', ?)", [RUN, total])
        connection.execute(f"UPDATE {table}")
    state.keep(Check(Catalogue(two)._database._state(), time.time(), 10.0))
    catalogue = Catalogue(two)
    catalogue.refresh()
    shown = [run.text(name) for run in catalogue.runs() for name in ("title", "agreement")]
    assert "something else" not in shown

"""What is read of an archived run only when it is asked for, and what is kept from one step of it to the next."""

import shutil
from dataclasses import replace

import numpy as np
import pytest

from tribopipe.archive.single_run import OneRun
from tribopipe.archive.store import Archive
from tribopipe.base.errors import ArchiveError
from tribopipe.documents.recipe import Recipe
from tribopipe.pipeline.stages import clean_archived
from tribopipe.results.run import SourceFile, UnheldSource

RUN = "si3n4-air-200mN"


@pytest.fixture
def store(archive) -> Archive:
    return Archive(archive)


def test_source_files_are_read_when_their_bytes_are_asked_for(store, short_runs):
    sources = store.raw(RUN).sources
    assert [source.content for source in sources] == [(short_runs / RUN / one.name).read_bytes() for one in sources]
    assert [source.size for source in sources] == [len(source.content) for source in sources]
    store.path(RUN).rename(store.folder / "elsewhere.h5")
    with pytest.raises(ArchiveError, match="cannot be read"):
        sources[0].content  # noqa: B018


def test_source_files_of_another_run_by_now_are_refused(store):
    old = store.raw(RUN)
    store.path(RUN).unlink()
    store.add(replace(old, sources=(SourceFile("run.toml", b"#"), SourceFile("b.csv", b"b;c"))))
    with pytest.raises(ArchiveError, match="found another file at /entry/source_files/file_1 than"):
        old.sources[1].content  # noqa: B018


@pytest.mark.parametrize("written", [b"a;b\n1;2\n", b""])
def test_a_source_that_is_written_into_meanwhile_is_refused(store, written):
    growing = UnheldSource("signals.csv", 4, "", lambda: iter([written]))
    folder = store.folder / "new"
    with pytest.raises(ArchiveError, match=r"signals.csv: found more or fewer bytes than the 4 that were read"):
        Archive(folder).add(replace(store.raw(RUN), sources=(growing,)))
    assert [path.name for path in folder.iterdir() if path.is_file()] == []


def test_a_cleaned_run_is_read_once_while_it_is_that_of_the_file(store):
    kept = OneRun(store)
    first = kept.cleaned(RUN)
    assert kept.cleaned(RUN) is first
    assert all(np.array_equal(first.columns[name], values) for name, values in store.cleaned(RUN).columns.items())
    with pytest.raises(ValueError, match="read-only"):
        first.columns["depth"][0] = 0
    clean_archived(store, RUN, Recipe(clean_up=()))
    second = kept.cleaned(RUN)
    assert second is not first
    shutil.copyfile(store.path(RUN), store.path("other"))
    assert kept.cleaned("other") is not second

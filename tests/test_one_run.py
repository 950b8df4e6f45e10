"""What is read of an archived run only when it is asked for, and what is kept from one step of it to the next."""

import shutil
from dataclasses import replace

import numpy as np
import pytest

from tribopipe.archive.deferred_write import OneRun
from tribopipe.archive.store import Archive
from tribopipe.base.errors import ArchiveError
from tribopipe.documents.annotation import Annotation
from tribopipe.documents.recipe import Recipe
from tribopipe.pipeline.stages import advance, process
from tribopipe.results.evaluation import DriftCorrection, FrictionFit
from tribopipe.results.run import SourceFile, UnheldSource

pytestmark = pytest.mark.usefixtures("few_draws")

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
    with pytest.raises(ArchiveError, match="found that /entry/source_files/file_1 has changed"):
        old.sources[1].content  # noqa: B018


@pytest.mark.parametrize("written", [b"a;b\n1;2\n", b""])
def test_a_source_that_is_written_into_meanwhile_is_refused(store, written):
    growing = UnheldSource("signals.csv", 4, "", lambda: iter([written]))
    folder = store.folder / "new"
    with pytest.raises(ArchiveError, match=r"signals.csv: found that the size, initially 4 bytes, changed"):
        Archive(folder).add(replace(store.raw(RUN), sources=(growing,)))
    assert [path.name for path in folder.iterdir() if path.is_file()] == []


def test_a_cleaned_run_is_read_once_while_it_is_that_of_the_file(store):
    kept = OneRun(store, RUN)
    first = kept.cleaned(RUN)
    assert kept.cleaned(RUN) is first
    assert all(np.array_equal(first.columns[name], values) for name, values in store.cleaned(RUN).columns.items())
    with pytest.raises(ValueError, match="read-only"):
        first.columns["depth"][0] = 0
    advance(store, RUN, "clean_up", Recipe(clean_up=()))
    second = kept.cleaned(RUN)
    assert second is not first
    shutil.copyfile(store.path(RUN), store.path("other"))
    assert kept.cleaned("other") is not second


@pytest.mark.slow
def test_steps_are_shown_at_once_and_stored_together(store):
    there = store.path(RUN).read_bytes()
    kept = OneRun(store, RUN)
    fit = replace(store.step(RUN, "friction_fit"), result=FrictionFit(outcome="none"))
    kept.put_step(RUN, fit)
    assert kept.result(RUN, "friction_fit", FrictionFit) == fit.result
    assert "wear_fit_sarkar" not in kept.step_names(RUN)  # it stood on the fit that was there
    kept.put_step(RUN, store.step(RUN, "specific_wear"))
    assert store.path(RUN).read_bytes() == there
    store.annotate(RUN, Annotation(kind="note", text="seen meanwhile", date="2026-11-24T00:00:00+00:00"))
    kept.store()
    assert "wear_fit_sarkar" not in store.step_names(RUN)
    assert store.result(RUN, "friction_fit", FrictionFit) == fit.result
    assert [one.text for one in store.annotations(RUN)] == ["seen meanwhile"]
    assert kept.steps(RUN).keys() == store.steps(RUN).keys()


@pytest.mark.slow
def test_steps_together_make_what_they_make_one_after_the_other(store):
    steps = list(store.steps(RUN).values())
    drift = replace(steps[1], result=steps[1].result.model_copy(update={"notes": ("another",)}))
    together, apart = (Archive(store.folder.parent / name) for name in ("together", "apart"))
    for archive in (together, apart):
        archive.add(store.raw(RUN))
    for put in (steps, [steps[0], drift]):
        together.put_steps(RUN, put)
        for step in put:
            apart.put_step(RUN, step)
        assert together.step_names(RUN) == apart.step_names(RUN) != []
        assert [together.fingerprints(RUN, name) for name in together.step_names(RUN)] == [
            apart.fingerprints(RUN, name) for name in apart.step_names(RUN)
        ]


def test_steps_made_from_what_another_process_has_changed_are_refused_and_nothing_is_stored(store):
    kept = OneRun(store, RUN)
    fit = store.step(RUN, "wear_fit_archard")
    kept.put_step(RUN, fit)
    drift = store.step(RUN, "drift_correction")
    store.put_step(RUN, replace(drift, result=DriftCorrection(outcome="uncorrected", missing=("a depth",))))
    there = store.path(RUN).read_bytes()
    with pytest.raises(ArchiveError, match="found that another tribopipe process has changed the drift correction"):
        kept.store()
    assert store.path(RUN).read_bytes() == there


@pytest.mark.slow
def test_run_whose_file_cannot_be_written_has_failed_once(short_runs, tmp_path, monkeypatch):
    def full(*_: object) -> None:
        raise ArchiveError("no room")

    archive = Archive(tmp_path / "archive")
    monkeypatch.setattr(Archive, "put_steps", full)
    outcomes = list(process([short_runs / RUN], archive))
    assert [(outcome.stage, outcome.status) for outcome in outcomes] == [("ingest", "done"), ("clean_up", "failed")]
    assert archive.steps(RUN) == {}

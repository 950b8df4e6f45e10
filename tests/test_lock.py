"""One writer at a time: across threads and processes, and after a holder that was killed."""

import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from test_archive import run_with, step

from tribopipe.archive import lock
from tribopipe.archive.lock import LOCKS, writers_lock
from tribopipe.archive.store import Archive
from tribopipe.base.errors import ArchiveError
from tribopipe.documents.annotation import Annotation, Mark
from tribopipe.results.evaluation import DriftCorrection
from tribopipe.results.wear_fit import WearFit

_HOLDER = """
import sys, time
from pathlib import Path
from tribopipe.archive.lock import writers_lock
with writers_lock(Path(sys.argv[1]), "bare"):
    print("held", flush=True)
    time.sleep(60)
"""


@pytest.fixture
def holder(tmp_path):
    """Another process that holds the lock of the run "bare"."""
    process = subprocess.Popen([sys.executable, "-c", _HOLDER, str(tmp_path)], stdout=subprocess.PIPE)
    assert process.stdout.readline().strip() == b"held"
    yield process
    process.kill()
    process.wait()
    process.stdout.close()


@pytest.mark.usefixtures("holder")
def test_another_process_is_waited_for_and_named(tmp_path, monkeypatch):
    monkeypatch.setattr(lock, "_WAIT", 0.05)
    monkeypatch.setattr(lock, "SILENT", 0.05)
    with (
        pytest.raises(ArchiveError, match="another tribopipe process that has been writing bare"),
        writers_lock(tmp_path, "bare"),
    ):
        pass


@pytest.mark.slow
@pytest.mark.usefixtures("holder")
def test_a_wait_is_announced_within_two_seconds(tmp_path):
    held_up = "from pathlib import Path; import sys; from tribopipe.archive.lock import writers_lock as lock\n"
    code = f"{held_up}with lock(Path(sys.argv[1]), 'bare'): pass"
    waiting = subprocess.Popen(
        [sys.executable, "-c", code, str(tmp_path)], stderr=subprocess.PIPE, text=True, encoding="utf-8"
    )
    said = waiting.stderr.readline()
    waiting.kill()
    waiting.communicate()
    assert said == f"{tmp_path}: another tribopipe process is writing bare; waiting up to 300 s\n"
    assert lock.SILENT < 2


def test_a_lock_ends_with_its_holder(holder, tmp_path):
    holder.kill()
    holder.wait()
    with writers_lock(tmp_path, "bare"):
        pass


def test_names_that_differ_in_case_share_a_lock(tmp_path, monkeypatch):
    monkeypatch.setattr(lock, "_WAIT", 0.05)
    monkeypatch.setattr(lock, "SILENT", 0.05)
    with writers_lock(tmp_path, "Bare"), pytest.raises(ArchiveError), writers_lock(tmp_path, "bARE"):
        pass


@pytest.mark.slow
def test_locks_do_not_grow_with_the_archive(tmp_path):
    for number in range(600):
        with writers_lock(tmp_path, f"run-{number}"):
            pass
    assert len(list((tmp_path / LOCKS).iterdir())) <= 256


@pytest.mark.slow
def test_nothing_that_many_say_at_once_is_lost(bare_run, tmp_path):
    archive = Archive(tmp_path)
    archive.add(run_with(bare_run, np.arange(10.0)))
    start = threading.Barrier(8)

    def say(number: int) -> None:
        start.wait()
        archive.annotate("bare", Annotation(kind="note", text=f"note {number}", date="2026-01-01T00:00:00+00:00"))
        archive.mark("bare", Mark(kind="bad", reason=f"reason {number}", date="2026-01-01T00:00:00+00:00"))

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(say, range(8)))
    assert {one.text for one in archive.annotations("bare")} == {f"note {number}" for number in range(8)}
    assert {mark.reason for mark in archive.marks("bare")} == {f"reason {number}" for number in range(8)}


@pytest.mark.slow
def test_a_step_made_from_what_another_has_replaced_meanwhile_is_refused(bare_run, tmp_path):
    archive = Archive(tmp_path)
    archive.add(run_with(bare_run, np.arange(10.0)))
    first = step("drift_correction", DriftCorrection(outcome="uncorrected", missing=("an end value",)))
    fit = step("wear_fit_archard", WearFit(model="archard", outcome="not fitted"))
    stands_on = {"raw": archive.raw_sha256("bare"), "clean_up": "", "drift_correction": first.result_sha256}
    archive.put_step("bare", first)
    archive.put_step("bare", replace(fit, stands_on=stands_on))
    archive.put_step("bare", step("drift_correction", DriftCorrection(outcome="uncorrected", missing=("a depth",))))
    with pytest.raises(ArchiveError, match="changed the drift correction since the wear fit archard"):
        archive.put_step("bare", replace(fit, stands_on=stands_on))
    assert archive.step_names("bare") == ["drift_correction"]

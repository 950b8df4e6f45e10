"""Run folders that went wrong in some hundred drawn ways: archived, or refused in one sentence; never anything else.

benchmarks/reliability/fuzz_manifests.py and fuzz_signals.py do the same 100 000 times, in watched processes.
"""

import random
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import fuzz_manifests
import fuzz_signals
import pytest
from fuzzing import MOST_MEMORY, Case, Trial, drawn_for, rows_of, try_all

pytestmark = pytest.mark.slow

SUBJECTS = {"documents": fuzz_manifests, "signal files": fuzz_signals}
PROGRAM = Path(__file__).with_name("fuzz_documents.py")


@pytest.mark.slow
@pytest.mark.parametrize("subject", SUBJECTS.values(), ids=SUBJECTS)
def test_what_cases_are_made_of_is_sound(tmp_path, subject):
    trial = Trial(tmp_path, subject.sound())
    became = {case.made_of: trial.run(case) for case in subject.unchanged()}
    assert became
    assert set(became.values()) == {("taken", "")}, became


@pytest.mark.parametrize("subject", SUBJECTS.values(), ids=SUBJECTS)
def test_some_cases(tmp_path, subject):
    trial = Trial(tmp_path, subject.sound())
    became = {number: trial.run(subject.make(drawn_for(0, number))) for number in range(60)}
    assert [told for told in became.items() if told[1][0] == "fault"] == []
    assert {how for how, _ in became.values()} == {"taken", "refused"}


@pytest.mark.parametrize("subject", SUBJECTS.values(), ids=SUBJECTS)
def test_a_case_is_the_same_whenever_it_is_made(subject):
    assert subject.make(drawn_for(7, 11)) == subject.make(drawn_for(7, 11))


def test_a_fault_is_found(tmp_path, monkeypatch):
    trial = Trial(tmp_path, fuzz_signals.sound())
    for fault in (ZeroDivisionError("x"), MemoryError()):
        monkeypatch.setattr("fuzzing.ingest", lambda *_, fault=fault: (_ for _ in ()).throw(fault))
        became, said = trial.run(fuzz_signals.sound())
        assert became == "fault"
        assert type(fault).__name__ in said


def dies(draw: random.Random) -> Case:
    """End the process in one case of four."""
    if draw.random() < 0.25:
        sys.exit(3)
    return fuzz_signals.sound()


@pytest.mark.slow
def test_a_process_that_dies_is_a_fault_and_begun_anew():
    found = try_all(dies, fuzz_signals.sound(), points=12, seed=1)
    assert found.counts.total() == 12
    assert found.counts["fault"] == sum(drawn_for(1, number).random() < 0.25 for number in range(12)) > 0
    assert {fault.said for fault in found.faults} == {"ended its process with 3"}
    assert not all(row.holds for row in rows_of(found, 12))


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="memory is told by Linux")
def test_memory_of_whoever_starts_the_processes_does_not_count():
    large = b"x" * (3 * MOST_MEMORY // 2)
    found = try_all(fuzz_signals.make, fuzz_signals.sound(), points=2, seed=0)
    assert found.largest is not None
    assert 0 < found.largest.memory < MOST_MEMORY < len(large)


@pytest.mark.slow
@pytest.mark.parametrize("subject", SUBJECTS.values(), ids=SUBJECTS)
def test_many_cases_in_processes_of_their_own(subject):
    found = try_all(subject.make, subject.sound(), points=500, seed=0)
    assert [row for row in rows_of(found, 500) if not row.holds] == [], found.faults


@pytest.mark.slow
@pytest.mark.skipif(find_spec("atheris") is None, reason="atheris is not installed")
def test_documents_found_by_coverage(tmp_path):
    command = [sys.executable, str(PROGRAM), "12", "1", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=150, errors="replace")
    faults = {path.name: path.read_bytes()[:2000] for path in tmp_path.iterdir() if path.is_file()}
    assert done.returncode == 0, f"{faults}\n{done.stderr[-4000:]}"

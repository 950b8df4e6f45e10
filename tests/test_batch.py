"""Batches: each task is answered once, whatever becomes of those who do it."""

import multiprocessing
import os
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest
from batch_work import (
    killed_at,
    killed_once,
    linear_algebra_threads,
    process_number,
    refuse_three,
    squared,
)
from listening import listening
from waiting import wait_until

from tribopipe.base import dask_workers
from tribopipe.base.errors import BatchError, FitError, InternalError
from tribopipe.base.executor import Crew, as_done, at_work, in_turn
from tribopipe.base.files import leftovers

TWO = Crew(jobs=2)


@pytest.fixture(scope="module")
def two() -> Iterator[Crew]:
    """Two workers that stay for all these tests."""
    with at_work(TWO) as crew:
        yield crew


@pytest.fixture(params=["alone", "two"])
def crew(request) -> Crew:
    return Crew() if request.param == "alone" else request.getfixturevalue("two")


def test_every_task_is_answered_once(crew):
    assert sorted(as_done(squared, range(20), crew)) == [(number, number**2) for number in range(20)]


def test_no_task_is_no_answer(crew):
    assert list(as_done(squared, [], crew)) == []


def test_a_process_of_its_own_answers_in_order():
    assert [number for number, _ in as_done(squared, range(20))] == list(range(20))


@pytest.mark.slow
def test_answers_in_turn_wait_for_those_before_them(two):
    naps = [0.3, 0.0, 0.0, 0.1, 0.0, 0.2]
    assert [nap for nap, _ in as_done(time.sleep, naps, two)] != naps
    assert [nap for nap, _ in in_turn(time.sleep, naps, two)] == naps


def test_answers_in_turn_name_their_tasks(crew):
    answers = list(in_turn(partial(int, base=0), ["run-1", "0x10", "run-3"], crew))
    assert [task for task, _ in answers] == ["run-1", "0x10", "run-3"]
    assert [str(answer).split(":")[0] for _, answer in answers] == ["run-1", "16", "run-3"]


def test_failures_are_sentences_and_stop_no_other(crew):
    answers = dict(as_done(refuse_three, range(8), crew))
    assert isinstance(answers[3], FitError)
    assert isinstance(answers[5], InternalError)
    assert "ZeroDivisionError: five)" in str(answers[5])
    assert [answers[number] for number in (0, 1, 2, 4, 6, 7)] == [0, 1, 2, 4, 6, 7]


def test_a_failure_names_its_task(crew):
    (_, answer), *_ = as_done(partial(int, base=0), ["run-7"], crew)
    assert str(answer).startswith("run-7: found a bug in tribopipe (ValueError: ")


@pytest.mark.slow
def test_an_answer_that_cannot_be_sent_is_a_failure(two):
    assert isinstance(dict(as_done(open_null, [1], two))[1], InternalError)
    assert dict(as_done(squared, [1], two)) == {1: 1}


def open_null(_: int) -> object:
    return Path(os.devnull).open(encoding="utf-8")


def test_tasks_are_taken_as_they_are_needed(crew):
    taken = []

    def tasks() -> Iterator[int]:
        for number in range(1000):
            taken.append(number)
            yield number

    answers = as_done(squared, tasks(), crew)
    for _ in range(10):
        next(answers)
    assert len(taken) <= 13
    answers.close()
    assert dict(as_done(squared, [7], crew)) == {7: 49}


def test_workers_use_one_thread_and_leave_this_process_as_it_is(monkeypatch):
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "7")
    with at_work(TWO) as crew:
        assert dict(as_done(linear_algebra_threads, [1], crew)) == {1: "1"}
    assert os.environ["OPENBLAS_NUM_THREADS"] == "7"


@pytest.mark.slow
def test_tasks_of_lost_workers_are_done_by_others(two, tmp_path):
    markers = [tmp_path / f"task-{number}" for number in range(4)]
    assert {name for _, name in as_done(killed_once, markers, two)} == {"task-0", "task-1", "task-2", "task-3"}


@pytest.mark.slow
def test_a_task_that_loses_every_worker_fails_alone(two):
    answers = dict(as_done(partial(killed_at, bad=4), range(12), two))
    error = answers.pop(4)
    assert isinstance(error, BatchError)
    assert "4 workers were killed or ran out of memory" in str(error)
    assert answers == {number: number for number in range(12) if number != 4}


@pytest.mark.slow
def test_a_worker_lost_with_nothing_to_do_is_replaced(two):
    lost = {number for _, number in as_done(process_number, range(4), two)}
    for number in lost:
        os.kill(number, signal.SIGTERM)
    wait_until(lambda: not lost & {child.pid for child in multiprocessing.active_children()})
    assert dict(as_done(squared, range(4), two)) == {0: 0, 1: 1, 2: 4, 3: 9}


@pytest.mark.slow
def test_no_worker_is_left():
    with at_work(TWO) as crew:
        numbers = {number for _, number in as_done(process_number, range(4), crew)}
    assert os.getpid() not in numbers
    assert not numbers & {child.pid for child in multiprocessing.active_children()}


_BATCH = """
import sys
from pathlib import Path
from batch_work import written_for_ever
from tribopipe.base.executor import Crew, as_done
from tribopipe.cli.entry_point import _end, _look_after
if __name__ == "__main__":
    _look_after(_end)
    list(as_done(written_for_ever, [Path(name) for name in sys.argv[1:]], Crew(jobs=2)))
"""


@pytest.mark.skipif(os.name == "nt", reason="sends signals as a terminal does")
@pytest.mark.parametrize(
    ("kill", "number"),
    [(os.killpg, "SIGINT"), pytest.param(os.kill, "SIGKILL", marks=pytest.mark.slow)],
    ids=["Ctrl-C", "killed"],
)
def test_workers_end_with_who_began_them_and_leave_nothing_half_written(tmp_path, kill, number):
    script, paths = tmp_path / "batch.py", [tmp_path / "one.h5", tmp_path / "two.h5"]
    script.write_text(_BATCH, encoding="utf-8")
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parent)}
    command = [sys.executable, str(script), *map(str, paths)]
    how = {"start_new_session": True, "preexec_fn": listening, "env": environment}
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, **how) as begun:
        wait_until(lambda: all(path.with_suffix(".begun").exists() for path in paths))
        assert len(leftovers(tmp_path)) == 2
        kill(begun.pid, getattr(signal, number))
        said = begun.stderr.read()  # until the last of them has ended
    assert leftovers(tmp_path) == []
    if number == "SIGINT":
        assert said == "interrupted; archived results are kept; run the same command again to continue\n"
        assert begun.returncode == 130


# --- Dask ---


def test_without_dask_it_is_said_how_to_install_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(BatchError, match=r'pip install "tribopipe\[hpc\]"'):
        list(as_done(squared, [1], Crew(scheduler="local")))


@pytest.mark.slow
@pytest.mark.parametrize("address", ["nonsense", "tcp://10.0.0.1", "10.0.0.1:8786", ""])
def test_what_is_no_address_is_refused(address):
    with pytest.raises(BatchError, match="expected an address such as tcp://"):
        list(as_done(squared, [1], Crew(scheduler=address)))


@pytest.mark.slow
def test_a_scheduler_that_does_not_answer_is_one_sentence(monkeypatch):
    monkeypatch.setattr(dask_workers, "_ANSWERS_WITHIN", 1)
    with socket.socket() as deaf:
        deaf.bind(("127.0.0.1", 0))
        with pytest.raises(BatchError, match="found no Dask scheduler at tcp://127"):
            list(as_done(squared, [1], Crew(scheduler=f"tcp://127.0.0.1:{deaf.getsockname()[1]}")))


def test_a_worker_of_another_version_is_refused():
    answer = dask_workers._answer_on_worker("0.0.1", squared, 2)
    assert isinstance(answer, BatchError)
    assert "expected 0.0.1, as on this machine" in str(answer)


@pytest.mark.slow
def test_a_cluster_here_answers_and_outlives_its_workers(tmp_path):
    said = []
    with at_work(Crew(2, "local", said.append)) as here:
        assert sorted(as_done(squared, range(20), here)) == [(number, number**2) for number in range(20)]
        answers = dict(as_done(refuse_three, range(8), here))
        assert isinstance(answers[3], FitError)
        assert isinstance(answers[5], InternalError)
        answers = dict(as_done(killed_once, [tmp_path / f"task-{number}" for number in range(4)], here))
        assert sorted(answers.values()) == ["task-0", "task-1", "task-2", "task-3"]
        answers = dict(as_done(partial(killed_at, bad=4), range(8), here))
        assert "4 workers were killed or ran out of memory" in str(answers.pop(4))
        assert answers == {number: number for number in range(8) if number != 4}
        begun = as_done(process_number, range(100), here)
        next(begun)
        begun.close()
        assert dict(as_done(squared, [5], here)) == {5: 25}
    assert re.fullmatch(r"cluster of 2 workers; dashboard at http://127\.0\.0\.1:\d+/status", said[0])
    assert set(said[1:]) <= {"waiting for workers: the scheduler has none at present"}


KILLED_ONCE = """
import sys
from pathlib import Path
from batch_work import killed_once
from tribopipe.base.executor import Crew, as_done
if __name__ == "__main__":
    assert dict(as_done(killed_once, [Path(sys.argv[1])], Crew(1, "local"))) == {Path(sys.argv[1]): "task"}
"""


@pytest.mark.slow
def test_a_worker_here_that_is_long_in_coming_back_is_waited_for(tmp_path):
    script = tmp_path / "killed.py"
    script.write_text(KILLED_ONCE, encoding="utf-8")
    hasty = {"DASK_DISTRIBUTED__DEPLOY__LOST_WORKER_TIMEOUT": "10ms", "PYTHONPATH": str(Path(__file__).parent)}
    command = [sys.executable, str(script), str(tmp_path / "task")]
    subprocess.run(command, env=os.environ | hasty, check=True, timeout=100)

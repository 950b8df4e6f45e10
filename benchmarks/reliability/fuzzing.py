"""Run folders that went wrong, in great number, given to tribopipe as a user would.

Each is archived, or refused in one sentence; it takes at most 5 s and 1 GB; and where it is refused, the archive holds
the bytes it held. Cases are made from a seed and a number alone, so that one can be looked at again by itself. They run
in processes of their own, which are ended where they do not answer, and begun again.
"""

import argparse
import os
import random
import re
import shutil
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import NamedTuple

from told import Row, asked, tell

from tribopipe.archive.history import FILE_NAME as HISTORY
from tribopipe.archive.lock import LOCKS
from tribopipe.archive.store import Archive
from tribopipe.base.errors import InternalError, TribopipeError
from tribopipe.documents.lab_template import read_template
from tribopipe.documents.manifest import read_manifest
from tribopipe.documents.plan import Plan
from tribopipe.documents.recipe import Recipe
from tribopipe.documents.record import load_toml
from tribopipe.documents.study import Study
from tribopipe.pipeline.stages import ingest
from tribopipe.readers.toml_reader import described_reader

ROOT = Path(__file__).parents[2]
_STATUS = Path("/proc/self/status")
LONGEST_SECONDS = 5.0
MOST_MEMORY = 1 << 30
_ADDRESSES = 2 << 30
"""Of address space, beside what the libraries take: threads reserve much of it without using it."""
_NO_SENTENCE = ("Traceback", " object at 0x", "<class ", "pydantic", "errors.pydantic.dev")
_LONGEST_SENTENCE = 1500
READ: Mapping[str, Callable[[Path], object]] = {
    "run": read_manifest,
    "recipe": lambda path: load_toml(path, Recipe),
    "study": lambda path: load_toml(path, Study),
    "plan": lambda path: load_toml(path, Plan),
    "template": read_template,
    "reader": described_reader,
}
"""How each kind of document is read."""


class Case(NamedTuple):
    """One folder that went wrong."""

    made_of: str
    """What it was made of, such as "si3n4-air-400mN/run.toml"."""
    files: Mapping[str, bytes]
    """What the folder holds, by name."""
    kind: str = "run"
    """What is read: the run folder, or its one document."""


Make = Callable[[random.Random], Case]


class Answer(NamedTuple):
    """What became of one case."""

    number: int
    made_of: str
    became: str
    """taken, refused, or fault."""
    said: str
    seconds: float
    memory: int
    """Most bytes that its process ever used until then."""


@dataclass
class Found:
    """What became of all cases."""

    counts: Counter[str] = field(default_factory=Counter)
    faults: list[Answer] = field(default_factory=list)
    slowest: Answer | None = None
    largest: Answer | None = None
    sentences: set[str] = field(default_factory=set)

    def add(self, answer: Answer) -> None:
        """Count a case."""
        self.counts[answer.became] += 1
        if answer.became == "fault":
            self.faults.append(answer)
        elif answer.became == "refused":
            self.sentences.add("".join(sign for sign in answer.said if sign.isalpha())[-60:])
        if self.slowest is None or answer.seconds > self.slowest.seconds:
            self.slowest = answer
        if self.largest is None or answer.memory > self.largest.memory:
            self.largest = answer


class Trial:
    """A folder for the case at hand, and an archive that holds one run already."""

    def __init__(self, scratch: Path, sound: Case) -> None:
        self.folder = scratch / "run"
        self.archive = scratch / "archive"
        self._lay_out(sound)
        ingest(self.folder, Archive(self.archive))
        self.begun = (self.archive / HISTORY).stat().st_size
        self.held = self._held()

    def _lay_out(self, case: Case) -> None:
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir(parents=True)
        for name, content in case.files.items():
            (self.folder / name).write_bytes(content)

    def _held(self) -> dict[str, bytes]:
        """Give the bytes of all that the archive holds, but its locks, and of its history those that came first."""
        files = (path for path in self.archive.rglob("*") if path.is_file() and path.parent.name != LOCKS)
        held = {path.relative_to(self.archive).as_posix(): path.read_bytes() for path in files}
        return held | {HISTORY: held[HISTORY][: self.begun]}

    def run(self, case: Case) -> tuple[str, str]:
        """Return what became of a case, and what was said of it."""
        self._lay_out(case)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                self._give(case)
        except InternalError:
            return "fault", traceback.format_exc()
        except TribopipeError as error:
            unlike = self._unlike_a_sentence(str(error))
            changed = "; the archive was changed" if self._held() != self.held else ""
            return ("fault", f"{unlike}{changed}: {error}") if unlike or changed else ("refused", str(error))
        except Exception:  # noqa: BLE001 - which is what is looked for
            return "fault", traceback.format_exc()
        self._forget_what_was_added()
        return ("taken", "") if self._held() == self.held else ("fault", "changed a run that was archived before")

    def _give(self, case: Case) -> None:
        if case.kind == "run":
            ingest(self.folder, Archive(self.archive))
        else:
            READ[case.kind](next(self.folder / name for name in case.files))

    def _unlike_a_sentence(self, said: str) -> str:
        plain = said.replace(str(self.folder), "RUN")
        if not plain.isprintable() or len(plain) > _LONGEST_SENTENCE:
            return "not in one line, or longer than a sentence"
        return next((f"holds {sign!r}" for sign in _NO_SENTENCE if sign in plain), "")

    def _forget_what_was_added(self) -> None:
        for name in self._held().keys() - self.held.keys():
            (self.archive / name).unlink()


def drawn_for(seed: int, number: int) -> random.Random:
    """Return what a case is drawn from."""
    return random.Random(f"{seed}/{number}")  # noqa: S311 - no secret


def _answered(trial: Trial, make: Make, seed: int, number: int) -> Answer:
    case = make(drawn_for(seed, number))
    start = time.perf_counter()
    became, said = trial.run(case)
    taken = time.perf_counter() - start
    if taken > LONGEST_SECONDS:
        became, said = "fault", f"took {taken:.1f} s; {said}"
    return Answer(number, case.made_of, became, said, taken, _memory())


def _memory() -> int:
    """Return the most bytes that this process ever used; 0 where the system does not tell.

    Linux counts the peak of the process that started this one in ``ru_maxrss``, but not in ``VmHWM``.
    """
    if _STATUS.exists():
        (peak,) = re.findall(r"^VmHWM:\s*(\d+) kB$", _STATUS.read_text(encoding="ascii"), re.MULTILINE)
        return int(peak) << 10
    if sys.platform == "win32":
        return 0
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def _bound_memory() -> None:
    """Let an allocation fail rather than the computer."""
    if sys.platform == "linux":
        import resource

        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        most = pages * resource.getpagesize() + _ADDRESSES
        resource.setrlimit(resource.RLIMIT_AS, (most, most))


def _work(told: Connection, make: Make, sound: Case, seed: int, numbers: range, scratch: Path) -> None:
    """Try cases one after the other; say which is begun, and what became of it."""
    trial = Trial(scratch, sound)
    _bound_memory()
    for number in numbers:
        told.send(number)
        told.send(_answered(trial, make, seed, number))
    told.close()


class _Worker:
    """A process that tries every so manieth case."""

    def __init__(self, make: Make, sound: Case, seed: int, numbers: range, scratch: Path) -> None:
        self.make, self.sound, self.seed, self.numbers, self.scratch = make, sound, seed, numbers, scratch
        self.process: BaseProcess
        self.told: Connection
        self.at: int | None = None
        self.since = time.monotonic()

    def start(self) -> None:
        """Begin with the first number that is left."""
        context = get_context("spawn")
        self.told, theirs = context.Pipe(duplex=False)
        scratch = Path(tempfile.mkdtemp(dir=self.scratch))
        words = (theirs, self.make, self.sound, self.seed, self.numbers, scratch)
        self.process = context.Process(target=_work, args=words)
        self.process.start()
        theirs.close()
        self.at = None

    def heard(self) -> Answer | None:
        """Take what the process says, which is an answer or the number of a case. Raises ``EOFError`` at its end."""
        said: int | Answer = self.told.recv()
        self.since = time.monotonic()
        if isinstance(said, Answer):
            self.at = None
            return said
        self.at, self.numbers = said, self.numbers[self.numbers.index(said) + 1 :]
        return None

    @property
    def hangs(self) -> bool:
        """Whether a case takes more than twice the time it may take."""
        return self.at is not None and time.monotonic() - self.since > 2 * LONGEST_SECONDS

    def end(self) -> None:
        """End the process."""
        self.process.kill()
        self.process.join()
        self.told.close()


def try_all(make: Make, sound: Case, points: int, seed: int, jobs: int = 2) -> Found:
    """Try so many cases in so many processes."""
    found = Found()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as scratch:
        workers = [_Worker(make, sound, seed, range(job, points, jobs), Path(scratch)) for job in range(jobs)]
        for worker in workers:
            worker.start()
        working = workers
        try:
            while working:
                wait([worker.told for worker in working], timeout=1)
                working = [worker for worker in working if _goes_on(worker, found)]
        finally:
            for worker in workers:
                worker.end()
    return found


def _goes_on(worker: _Worker, found: Found) -> bool:
    """Take what a worker has to say; begin it anew where it died or hangs. Tell whether it has cases left."""
    try:
        while worker.told.poll():
            answer = worker.heard()
            if answer is not None:
                found.add(answer)
    except EOFError:
        worker.process.join()
    else:
        if not worker.hangs:
            return True
    lost = "gave no answer" if worker.hangs else f"ended its process with {worker.process.exitcode}"
    worker.end()
    if worker.at is not None:
        found.add(Answer(worker.at, "", "fault", lost, time.monotonic() - worker.since, 0))
        worker.start()
        return True
    return False


def rows_of(found: Found, points: int) -> Iterator[Row]:
    """Tell what became of the cases."""
    counts = found.counts
    yield Row("cases", f"{counts.total()}", f"{points}", holds=counts.total() == points)
    yield Row("archived", f"{counts['taken']}")
    yield Row("rejected with a one-sentence error, archive unchanged", f"{counts['refused']}")
    yield Row("different error messages", f"{len(found.sentences)}")
    numbers = ", ".join(str(fault.number) for fault in found.faults[:20])
    yield Row("other outcomes", f"{counts['fault']}" + (f": {numbers}" if numbers else ""), "0", not found.faults)
    if found.slowest is not None and found.largest is not None:
        slow, large = found.slowest, found.largest
        told = f"{slow.seconds:.2f} s, case {slow.number} of {slow.made_of}"
        yield Row("longest time", told, f"{LONGEST_SECONDS:.0f} s", slow.seconds <= LONGEST_SECONDS)
        told = f"{large.memory / 1e6:.0f} MB, case {large.number} of {large.made_of}"
        yield Row("highest memory of a process", told, f"{MOST_MEMORY / 1e6:.0f} MB", large.memory <= MOST_MEMORY)


def main(name: str, title: str, description: str | None, make: Make, sound: Case) -> int:
    """Try as many cases as are asked for, or one alone, and tell what became of them."""
    parser = asked(description, points=100_000)
    parser.add_argument("--jobs", type=int, default=min(2, os.cpu_count() or 1), help="processes (%(default)s)")
    parser.add_argument("--only", type=int, metavar="K", help="try case K alone, and say what becomes of it")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="with --only: where to leave the case")
    options = parser.parse_args()
    if options.only is not None:
        return _tell_one(options, make, sound)
    found = try_all(make, sound, options.points, options.seed, options.jobs)
    for fault in found.faults[:20]:
        print(f"case {fault.number} of {fault.made_of}: {fault.said[-_LONGEST_SENTENCE:]}\n", file=sys.stderr)
    return tell(name, title, options, rows_of(found, options.points), (description or "").partition("\n\n")[2])


def _tell_one(options: argparse.Namespace, make: Make, sound: Case) -> int:
    with tempfile.TemporaryDirectory() as scratch:
        answer = _answered(Trial(Path(scratch), sound), make, options.seed, options.only)
        if options.keep is not None:
            shutil.copytree(Path(scratch) / "run", options.keep)
    print(f"{answer.made_of}, {answer.seconds:.2f} s, {answer.became}: {answer.said}")
    return int(answer.became == "fault")

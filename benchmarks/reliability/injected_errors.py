"""Errors of the system at every call on files of an archive, for ten errors and eight commands.

    python benchmarks/reliability/injected_errors.py

A library in front of the C library counts the calls on files below the archive, those of HDF5 and SQLite too, and lets
one of them fail. No sound file may be called damaged then, no write that is complete may be called failed, none that is
not may be called done, and nothing but sentences may be said. Linux with a C compiler only.
"""

import ctypes
import errno
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter, defaultdict
from collections.abc import Callable, Sequence
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass, field
from io import StringIO
from itertools import product
from pathlib import Path
from random import Random
from typing import NamedTuple

from forks import command, ended, forked
from held import contents, differences
from short_runs import quick_recipe, short_runs
from told import Row, asked, tell

from tribopipe.archive.store import Archive
from tribopipe.base.files import leftovers

ERRORS = tuple(map(errno.errorcode.__getitem__, (1, 5, 12, 13, 23, 24, 28, 30, 116, 122)))
"""EPERM, EIO, ENOMEM, EACCES, ENFILE, EMFILE, ENOSPC, EROFS, ESTALE, EDQUOT."""
RUN = "run-000"
NOTE = "written once"
_SOURCE = Path(__file__).with_name("failing_calls.c")
_PRELOAD = "LD_PRELOAD"
_NOT_SOUND = re.compile(r"damag|restore|from a backup|rescue|not HDF5|another program|no seal")
_CALLED_FAILED = re.compile(r"cannot be (?:written|read or written|archived|taken in)")
_UNFORESEEN = re.compile(r"Traceback|fault of tribopipe|Exception ignored")
WRONG = {
    "called damaged": "intact files reported as damaged",
    "called failed": "completed writes reported as failed",
    "called done": "incomplete writes reported as completed",
    "unforeseen": "tracebacks, internal errors",
    "without a word": "failures without an error message",
    "other words": "exit code 0, but different output than without errors",
    "changed": "unreadable files, or files with neither the old nor the new content",
}


class Given(NamedTuple):
    """What a command begins with."""

    words: Sequence[object]
    """Behind `tribopipe`."""
    archive: str
    """Which archive it is given: "whole", "corrected" or "none"."""
    writes: bool = False


@dataclass
class Found:
    """What was found of one command."""

    calls: list[str] = field(default_factory=list)
    """Calls on files of the archive where none fails, by their names."""
    tried: int = 0
    codes: Counter[int] = field(default_factory=Counter)
    parts: int = 0
    """Temporary files left, to be removed by the next writer."""
    wrong: dict[str, list[str]] = field(default_factory=lambda: defaultdict(list))


class Trial(NamedTuple):
    """What a command did of which a call failed."""

    where: str
    code: int
    said: str
    was_written: bool
    """Whether the call came after a file had its name, and before its lock was let go."""

    def __str__(self) -> str:
        return f"{self.where}: exit code {self.code}: {self.said[-600:]}"


class Bench:
    """Archives that commands are given, and what becomes of them."""

    def __init__(self, scratch: Path) -> None:
        self.scratch, self.said, self.told = scratch, scratch / "said", scratch / "told"
        self.archive, self.whole, self.out = scratch / "archive", scratch / "whole", scratch / "out"
        self.run, self.recipe = short_runs(scratch / "runs", 1)[0], quick_recipe(scratch)
        process = ["process", self.run, "--recipe", self.recipe, "--no-figures"]
        quietly([*process, "--archive", self.whole])
        corrected = ["--archive", scratch / "corrected"]
        quietly(["ingest", self.run, *corrected])
        quietly(["correct-drift", RUN, "--recipe", self.recipe, *corrected])
        crate = scratch / "crate"
        quietly(["export", "dataset", "--ro-crate", crate, "--no-report", "--archive", self.whole])
        at = ["--archive", self.archive]
        self.commands = {
            "show": Given(["show", RUN, *at], "whole"),
            "note": Given(["note", RUN, NOTE, *at], "whole", writes=True),
            "verify": Given(["verify", self.archive], "whole"),
            "ls": Given(["ls", *at], "whole"),
            "process": Given([*process, *at], "none", writes=True),
            "fit": Given(["fit", RUN, "--recipe", self.recipe, *at], "corrected", writes=True),
            "import": Given(["import", crate, *at], "none", writes=True),
            "export dataset": Given(["export", "dataset", "--ro-crate", self.out, "--no-report", *at], "whole"),
            "export csv": Given(["export", "csv", RUN, "--output", self.out, *at], "whole"),
        }
        self.before = contents(self.whole)
        self.after: dict[str, dict[str, dict[str, bytes]]] = {}
        self.words_of: dict[str, str] = {}

    def prepare(self, one: Given) -> None:
        """Put the archive there that a command is given."""
        for folder in (self.archive, self.out):
            shutil.rmtree(folder, ignore_errors=True)
        if one.archive != "none":
            shutil.copytree(self.whole.with_name(one.archive), self.archive)

    def run_with(self, one: Given, place: int = 0, error: int = 0) -> tuple[int, str, list[str]]:
        """Run a command of which one call fails; return its exit code, what it said, and all calls by their names."""
        self.said.unlink(missing_ok=True)

        def work() -> None:
            library = ctypes.CDLL(None)
            library.name_of.restype = ctypes.c_char_p
            library.fail(os.fsencode(self.archive), place, error)
            try:
                command(*one.words)()
            finally:
                calls = library.counted()
                library.fail(b"/", -1, 0)
                names = [library.name_of(n + 1).decode() for n in range(calls)] if not place else []
                self.told.write_text("\n".join(names), encoding="utf-8")

        code = ended(forked(work, self.said))
        return code, self.said.read_text(encoding="utf-8"), self.told.read_text(encoding="utf-8").split()

    def look(self, name: str, trial: "Trial", found: Found) -> None:
        """Look at what a command said and left of which a call failed."""
        found.tried += 1
        found.codes[trial.code] += 1
        found.parts += sum(len(leftovers(folder)) for folder in (self.archive, self.archive / "studies"))
        wrong = self._said_wrongly(name, trial)
        try:
            wrong += self._left_wrongly(name, trial, contents(self.archive))
        except (OSError, KeyError, RuntimeError):
            wrong.append("changed")
        for what in wrong:
            found.wrong[what].append(str(trial))

    def _said_wrongly(self, name: str, trial: "Trial") -> list[str]:
        said, code, refused = trial.said, trial.code, "is not readable" in trial.said
        tests = {
            "called damaged": _NOT_SOUND.search(said),
            "unforeseen": _UNFORESEEN.search(said) or (code not in (0, 1, 3) and not refused),
            "without a word": code and "error: " not in said and not refused,
            "other words": not code and _dateless(said) != _dateless(self.words_of[name]),
            "called failed": trial.was_written and _CALLED_FAILED.search(said),
        }
        return [what for what, holds in tests.items() if holds]

    def _left_wrongly(self, name: str, trial: "Trial", now: dict[str, dict[str, bytes]]) -> list[str]:
        if not self.commands[name].writes:
            return ["changed"] if differences(now, self.before) else []
        if not self._is_done(name, now):
            return [] if trial.code else ["called done"]
        return ["called failed"] if name == "note" and trial.code else []

    def _is_done(self, name: str, now: dict[str, dict[str, bytes]]) -> bool:
        """Tell whether all is in the archive that a command writes."""
        if name == "note":
            return [one.text for one in Archive(self.archive).annotations(RUN)] == [NOTE]
        return not differences(now, self.after[name])

    def undisturbed(self, name: str) -> Found:
        """Run a command of which nothing fails; count its calls."""
        one = self.commands[name]
        self.prepare(one)
        code, said, names = self.run_with(one)
        if code:
            raise RuntimeError(f"{name}: exit code {code}: {said}")
        self.after[name] = contents(self.archive)
        self.words_of[name] = said
        return Found(names)


def quietly(words: Sequence[object]) -> None:
    """Run a command in this process, so that what is forked has everything imported."""
    given = sys.argv
    try:
        with redirect_stderr(StringIO()) as said, redirect_stdout(StringIO()):
            command(*words)()
    except SystemExit as ending:
        if ending.code:
            raise RuntimeError(f"{words}: exit code {ending.code}: {said.getvalue()}") from None
    finally:
        sys.argv = given


def _dateless(said: str) -> str:
    return re.sub(r"\d{4}-\d\d-\d\dT[\d:+]+", "", said)


def is_written(calls: Sequence[str], place: int) -> bool:
    """Tell whether the call of a place comes after a file was given its name, and before its lock was let go."""
    last = next((name for name in reversed(calls[: place - 1]) if name in ("create", "rename", "flock")), "")
    return last == "rename"


def tries(calls: Sequence[str], points: int, chance: Random) -> list[tuple[int, str]]:
    """Give as many places and errors as are wanted: each error at each kind of call first, then any that are drawn.

    Without a number of points it is each error at each kind of call.
    """
    places = defaultdict(list)
    for place, name in enumerate(calls, 1):
        places[name].append(place)
    each = [(chance.choice(places[name]), error) for name, error in product(places, ERRORS)]
    more = [(chance.randint(1, len(calls)), chance.choice(ERRORS)) for _ in range(max(points - len(each), 0))]
    return sorted({*chance.sample(each, min(points or len(each), len(each))), *more})


def bench_of(
    scratch: Path, points: int, chance: Random, tell_progress: Callable[[str], object] = lambda _: None
) -> dict[str, Found]:
    """Let calls of all commands fail; return what was found."""
    bench = Bench(scratch)
    for one in bench.commands.values():  # so that what is forked has everything imported
        bench.prepare(one)
        quietly(one.words)
    results = {}
    for name, one in bench.commands.items():
        results[name] = found = bench.undisturbed(name)
        for place, error in tries(found.calls, points, chance):
            bench.prepare(one)
            code, said, _ = bench.run_with(one, place, getattr(errno, error))
            where = f"{name}, call {place} of {len(found.calls)} ({found.calls[place - 1]}), {error}"
            bench.look(name, Trial(where, code, said, is_written(found.calls, place)), found)
        tell_progress(f"{name}: {found.tried} tried, {sum(map(len, found.wrong.values()))} wrong")
    return results


def rows(results: dict[str, Found]) -> list[Row]:
    """Return what was found as rows of a table."""
    kinds = sum((Counter(found.calls) for found in results.values()), Counter[str]())
    told = ", ".join(f"{count} {name}" for name, count in kinds.most_common())
    made = [Row("system calls on files of the archive", told)]
    for name, found in results.items():
        codes = ", ".join(f"{count} with exit code {code}" for code, count in sorted(found.codes.items()))
        made.append(Row(f"`{name}`: {len(found.calls)} calls; errors injected", f"{found.tried}: {codes}"))
    for what, title in WRONG.items():
        count = sum(len(found.wrong[what]) for found in results.values())
        made.append(Row(title, f"{count} of {sum(found.tried for found in results.values())}", "0", not count))
    made.append(Row("temporary files left for the next command", str(sum(found.parts for found in results.values()))))
    return made


def preloaded(scratch: Path) -> dict[str, str] | None:
    """Return the environment of a process with the library in front; none where it cannot be made here."""
    compiler, library = shutil.which("cc"), scratch / "failing_calls.so"
    if compiler is None or sys.platform != "linux":
        return None
    made = subprocess.run([compiler, "-shared", "-fPIC", "-O1", "-o", library, _SOURCE, "-ldl"], check=False)
    return None if made.returncode else os.environ | {_PRELOAD: str(library)}


def main() -> int:
    """Inject, and tell what was found."""
    options = asked(__doc__, points=0).parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        if str(os.environ.get(_PRELOAD, "")).endswith("failing_calls.so"):
            say = lambda text: print(text, file=sys.stderr, flush=True)  # noqa: E731
            results = bench_of(Path(scratch), options.points, Random(options.seed), say)  # noqa: S311
        else:
            with_library = preloaded(Path(scratch))
            if with_library is None:
                print("not tried: it takes Linux and a C compiler")
                return 0
            return subprocess.run([sys.executable, *sys.argv], check=False, env=with_library).returncode
    for found in results.values():
        for what, wrong in found.wrong.items():
            print(*(f"{what}: {text}\n" for text in wrong[:6]), sep="\n", file=sys.stderr)
    return tell(
        "injected_errors",
        "Injected operating system errors",
        options,
        rows(results),
        f"The archive contains one short run. Errors: {', '.join(ERRORS)}. Each command starts with an intact "
        "archive, or with none if it creates one. One system call fails at a time: "
        + (
            f"{options.points} random combinations of an error and a kind of call, and others at random calls of any "
            "kind."
            if options.points
            else "each error at each kind of call in each command, at a random call of this kind."
        ),
    )


if __name__ == "__main__":
    sys.exit(main())

"""Mutants: one change of meaning each in tribopipe, and the default test that must fail with it.

    python tests/mutants.py            checks those of mutants.toml; CI does
    python tests/mutants.py --only drift
    python tests/mutants.py --survey   looks for a test that fails with each mutant without killed_by
    python tests/mutants.py --draw     shows the drawn mutants, drawn again from the code as it is now

Each mutant is made in a copy of the package, never in the work tree. A test that fails kills it; a test that cannot be
collected or imported, or that passes, does not.
"""

import argparse
import compileall
import json
import os
import py_compile
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue
from tempfile import TemporaryDirectory

from mutant_reach import reach
from mutant_sites import bounds, draw, function_at

ROOT = Path(__file__).parents[1]
LIST = ROOT / "tests" / "mutants.toml"
WORKERS = 2
LONGEST = 120.0
"""Seconds that a test may take with a mutant: one that makes it endless is killed as well."""
FAILED = 1
"""Exit code of pytest where tests failed; others are passes, wrong uses and what cannot be collected."""
TRIED = (10, 40, 150, 100_000)
"""Tests that a survey tries in one process, one after the other."""


@dataclass(frozen=True)
class Mutant:
    """One change of meaning."""

    changes: str
    """What it means, in a sentence."""
    file: str
    old: str
    new: str
    within: str = ""
    """The function, with its class, that old stands in once; the whole file where none is named."""
    drawn: int | None = None
    """Its number in the draw; none of one that was chosen."""
    killed_by: str | None = None
    """The test that must fail."""

    def applied(self, source: str) -> str:
        """Return a source with the change made. Raises ``LookupError`` where the old text is not there once."""
        lines = source.splitlines(keepends=True)
        first, last = bounds(source, self.within)
        before, part, after = ("".join(some) for some in (lines[:first], lines[first:last], lines[last:]))
        if part.count(self.old) != 1:
            raise LookupError(f"found the old text {part.count(self.old)} times, expected once")
        return before + part.replace(self.old, self.new) + after


@dataclass(frozen=True)
class PackageCopy:
    """The package in a folder of its own, which tests import instead of that of the work tree."""

    folder: Path

    @classmethod
    def made(cls, folder: Path) -> "PackageCopy":
        """Copy the package, and what it finds beside it in a checkout, and compile it.

        By the hash of each source: a change within the second in which a file was written would go unnoticed else.
        """
        unneeded = shutil.ignore_patterns("__pycache__", "node_modules")
        for name in ("tribopipe", "docs", "sample_runs"):
            shutil.copytree(ROOT / name, folder / name, ignore=unneeded)
        checked = py_compile.PycInvalidationMode.CHECKED_HASH
        compileall.compile_dir(folder / "tribopipe", quiet=1, invalidation_mode=checked)
        _declare(folder / "tribopipe-0.dist-info")
        return cls(folder)

    def again(self, folder: Path) -> "PackageCopy":
        """Return another copy of this one."""
        return PackageCopy(shutil.copytree(self.folder, folder))

    @property
    def package(self) -> Path:
        """The folder of the package."""
        return self.folder / "tribopipe"

    @contextmanager
    def with_mutant(self, mutant: Mutant) -> Iterator[None]:
        """Make a change, and take it back."""
        path = self.folder / mutant.file
        source = path.read_bytes()
        path.write_text(mutant.applied(source.decode()), encoding="utf-8", newline="")
        try:
            yield
        finally:
            path.write_bytes(source)

    def run(self, *arguments: str, longest: float | None = None) -> subprocess.CompletedProcess[str]:
        """Run Python with the copied package. Raises ``TimeoutExpired`` where it takes longer than that."""
        told = os.environ | {
            "PYTHONPATH": str(self.folder),
            "PYTHONDONTWRITEBYTECODE": "1",
            "HYPOTHESIS_STORAGE_DIRECTORY": str(self.folder / "hypothesis"),
        }
        whole = [sys.executable, "-P", *arguments]
        return subprocess.run(whole, cwd=ROOT, env=told, capture_output=True, text=True, check=False, timeout=longest)

    def tested(self, tests: Sequence[str], processes: int = 0) -> tuple[int, str]:
        """Run tests until one fails; return the exit code of pytest and what it printed."""
        quick = ("-x", "-q", f"-n{processes}", "--tb=line", "-p", "no:cacheprovider")
        try:
            ended = self.run("-m", "pytest", *quick, *tests, longest=LONGEST * len(tests))
        except subprocess.TimeoutExpired:
            return FAILED, f"FAILED {tests[0]} - it does not end"
        return ended.returncode, ended.stdout + ended.stderr


def _declare(folder: Path) -> None:
    """Declare the entry points of the work tree for a copy, whatever was installed last."""
    groups = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["entry-points"]
    parts = [
        "\n".join([f"[{group}]", *(f"{name} = {value}" for name, value in of.items())]) for group, of in groups.items()
    ]
    folder.mkdir()
    (folder / "METADATA").write_text("Metadata-Version: 2.1\nName: tribopipe\nVersion: 0\n", encoding="utf-8")
    (folder / "entry_points.txt").write_text("\n".join(parts), encoding="utf-8")


def mutants(kind: str = "mutant") -> list[Mutant]:
    """Return the mutants of the list; those of the kind "survivor" are waiting for a test."""
    return [Mutant(**one) for one in _listed().get(kind, [])]


def _listed() -> dict:
    return tomllib.loads(LIST.read_text(encoding="utf-8"))


def misplaced(listed: Sequence[Mutant]) -> Iterator[str]:
    """Yield a sentence for each mutant whose place has changed."""
    for mutant in listed:
        try:
            mutant.applied((ROOT / mutant.file).read_text(encoding="utf-8"))
        except (LookupError, OSError) as error:
            within = f", {mutant.within}" if mutant.within else ""
            yield f"{mutant.changes}: {mutant.file}{within}: {error}: {mutant.old!r}; adapt the entry in {LIST.name}"


def check(listed: Sequence[Mutant]) -> list[str]:
    """Return a sentence for each mutant that its test does not kill."""
    if wrong := [*misplaced(listed), *(f"{one.changes}: no killed_by" for one in listed if one.killed_by is None)]:
        return wrong

    def survived(copy: PackageCopy, mutant: Mutant) -> str:
        code, printed = copy.tested([str(mutant.killed_by)])
        print("killed  " if code == FAILED else f"exit {code}  ", mutant.changes, flush=True)  # noqa: T201
        return "" if code == FAILED else f"{mutant.changes}: {mutant.killed_by}: exit code {code}\n{printed}"

    with TemporaryDirectory(prefix="mutants-") as name:
        first = PackageCopy.made(Path(name) / "0")
        if wrong := list(_unsound(first, sorted({one.killed_by for one in listed if one.killed_by}))):
            return wrong
        return [told for told in _with_each(first, listed, survived) if told]


def _with_each(
    first: PackageCopy, listed: Sequence[Mutant], judge: Callable[[PackageCopy, Mutant], str]
) -> Iterator[str]:
    """Yield what is said of each mutant while it is made in a copy that no other one is made in meanwhile."""
    free: SimpleQueue[PackageCopy] = SimpleQueue()
    free.put(first)
    for number in range(1, WORKERS):
        free.put(first.again(first.folder.with_name(str(number))))

    def judged(mutant: Mutant) -> str:
        copy = free.get()
        try:
            with copy.with_mutant(mutant):
                return judge(copy, mutant)
        finally:
            free.put(copy)

    with ThreadPoolExecutor(WORKERS) as pool:
        yield from pool.map(judged, listed)


def _unsound(copy: PackageCopy, tests: Sequence[str]) -> Iterator[str]:
    """Yield what is wrong with tests before anything is changed: the copy must be what they import, and pass."""
    where = copy.run("-c", "import tribopipe; print(tribopipe.__file__)").stdout.strip()
    if Path(where).parent.resolve() != copy.package.resolve():
        yield f"tests import {where}, expected the copy in {copy.folder}"
    code, printed = copy.tested(tests, WORKERS)
    if code:
        yield f"exit code {code} without any mutant:\n{printed}"


def survey(listed: Sequence[Mutant], most: int) -> Iterator[str]:
    """Yield for each mutant the first default test that fails with it, of those that run its function, quickest first.

    At most so many are tried for each. Which do is measured once by a run of all tests, and kept in build.
    """
    kept = ROOT / "build" / "mutant-reach.json"
    with TemporaryDirectory(prefix="mutants-") as name:
        if not kept.exists():
            kept.parent.mkdir(exist_ok=True)
            kept.write_text(json.dumps(reach(PackageCopy.made(Path(name) / "reach").package, ROOT)), encoding="utf-8")
        tests = json.loads(kept.read_text(encoding="utf-8"))

        def told(copy: PackageCopy, mutant: Mutant) -> str:
            return f"{mutant.changes}: {_killer(copy, _near(tests, mutant)[:most]) or 'survives'}"

        yield from _with_each(PackageCopy.made(Path(name) / "0"), listed, told)


def _near(tests: Mapping[str, Sequence[str]], mutant: Mutant) -> Sequence[str]:
    """Return the tests that run the function of a mutant, or any of its module where it is in none.

    Those in a file named after the module come first.
    """
    found = tests.get(f"{mutant.file}::{_function_of(mutant)}", [])
    return sorted(found, key=lambda test: Path(mutant.file).stem not in test.partition("::")[0])


def _function_of(mutant: Mutant) -> str:
    source = (ROOT / mutant.file).read_text(encoding="utf-8")
    first, _ = bounds(source, mutant.within)
    start = len("".join(source.splitlines(keepends=True)[:first]))
    return function_at(source, 1 + source.count("\n", 0, source.index(mutant.old, start)))


def _killer(copy: PackageCopy, tests: Sequence[str]) -> str | None:
    left = list(tests)
    for count in TRIED:
        some, left = left[:count], left[count:]
        code, printed = copy.tested(some) if some else (0, "")
        if code == FAILED:
            return next(line for line in printed.splitlines() if line.startswith(("FAILED", "ERROR")))
        if code:
            return f"exit code {code}: {printed}"
    return None


def drawn() -> Iterator[str]:
    """Yield the draw that the list states, as entries of it."""
    rule = _listed()["draw"]
    for number, one in enumerate(draw(ROOT, rule["groups"], rule["seed"], rule["count"]), 1):
        entry = {"drawn": number, "changes": one.kind, "file": one.file, "within": one.within}
        entry |= {"old": one.old, "new": one.new}
        lines = [f"{key} = {json.dumps(value, ensure_ascii=False)}" for key, value in entry.items() if value != ""]
        yield "\n".join(["[[mutant]]", *lines, ""])


def main() -> None:
    """Run as the docstring of this file says."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="part of the file or of the sentence of a mutant")
    parser.add_argument("--survey", action="store_true", help="look for a test that kills")
    parser.add_argument("--most", type=int, default=100_000, help="tests that a survey tries for a mutant")
    parser.add_argument("--draw", action="store_true", help="show the drawn mutants")
    asked = parser.parse_args()
    if asked.draw:
        print("\n".join(drawn()))  # noqa: T201
        return
    every = [*mutants(), *mutants("survivor")] if asked.survey else mutants()
    listed = [one for one in every if asked.only in one.file or asked.only in one.changes]
    if asked.survey:
        for line in survey([one for one in listed if one.killed_by is None], asked.most):
            print(line, flush=True)  # noqa: T201
        return
    wrong = check(listed)
    waiting = f"; {len(mutants('survivor'))} more are waiting for a test" if mutants("survivor") else ""
    print(f"{len(listed) - len(wrong)} of {len(listed)} mutants killed{waiting}", *wrong, sep="\n")  # noqa: T201
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()

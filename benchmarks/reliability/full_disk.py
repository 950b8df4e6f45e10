"""A disk that is full, at every write of `tribopipe process`, and small disks of many sizes.

    python benchmarks/reliability/full_disk.py --points 100

Files are opened anew, written, synced and given their names through a few calls of the system. One of these calls, the
k-th of a batch, says that there is no room; in every other batch so do all after it. What is said has to be a sentence
for each failure, nothing may be half-written, and the same command has to complete once there is room. POSIX only; as
root on Linux the same is tried with the real command on small disks in memory.
"""

import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass, field
from errno import ENOSPC
from io import StringIO
from pathlib import Path

from forks import command, ended, forked
from held import contents, differences, figures
from no_room import Layer
from short_runs import quick_recipe, short_runs
from told import Row, asked, tell

from tribopipe.base.files import leftovers

RUNS = 2
COMMAND = Path(sys.executable).with_name("tribopipe")
DISKS = 10


@dataclass
class Found:
    """What was found after full disks."""

    tried: int = 0
    codes: dict[int, int] = field(default_factory=dict)
    """How often each exit code."""
    sentences: int = 0
    """The most that one command said."""
    wrong: list[str] = field(default_factory=list)
    """What was not as it should be."""
    left: int = 0
    """Temporary files left."""
    unfinished: list[str] = field(default_factory=list)
    """Where the next command, with room, did not end in the same archive and figures."""


class Lab:
    """Run folders, and what an archive of them holds that always had room."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.said = folder, folder / "said"
        runs = short_runs(folder / "runs", RUNS)
        # In this process alone: the layer that says the disk is full is in no worker.
        self.words = ["process", *map(str, runs), "--jobs", "1", "--recipe", str(quick_recipe(folder)), "--archive"]
        undisturbed = folder / "undisturbed"
        _in_this_process(self.words, undisturbed)
        self.whole, self.figures = contents(undisturbed), figures(undisturbed)
        self.size = sum(path.stat().st_size for path in undisturbed.rglob("*") if path.is_file())

    def process(self, archive: Path, layer: Callable[[], object] = lambda: None) -> tuple[int, str]:
        """Run the command above a layer that fails; return its exit code and what it said."""
        self.said.unlink(missing_ok=True)

        def work() -> None:
            layer()
            command(*self.words, archive)()

        return ended(forked(work, self.said)), self.said.read_text(encoding="utf-8")

    def check(self, found: Found, where: str, archive: Path, code: int, said: str) -> None:
        """Look at what a command said and left that ran out of room."""
        found.tried += 1
        found.codes[code] = found.codes.get(code, 0) + 1
        sentences = [line for line in said.splitlines() if line.startswith("error: ")]
        found.sentences = max(found.sentences, len(sentences))
        if code not in (1, 3) or "Traceback" in said or not any(os.strerror(ENOSPC) in line for line in sentences):
            found.wrong.append(f"{where}: exit code {code}: {said[-500:]}")
        try:
            there = contents(archive)
        except (OSError, KeyError, RuntimeError) as error:
            found.wrong.append(f"{where}: {error}")
            return
        changed = [name for name in differences(there, self.whole) if "entry/raw" in name or "entry/source" in name]
        found.wrong += [f"{where}: {name}" for name in changed]
        found.left += sum(len(leftovers(folder)) for folder in (archive, archive / "figures"))

    def check_done(self, found: Found, where: str, archive: Path, code: int, said: str) -> None:
        """Look at what a command left that had room again."""
        apart = differences(contents(archive), self.whole)
        apart += sorted(name for name, _ in figures(archive).items() ^ self.figures.items())
        if code or apart:
            found.unfinished.append(f"{where}: exit code {code}: {apart[:3]} {said[-300:]}")


def _in_this_process(words: list[str], archive: Path) -> None:
    """Process here, so that what is forked has everything imported."""
    given = sys.argv
    try:
        with redirect_stderr(StringIO()), redirect_stdout(StringIO()):
            command(*words, archive)()
    except SystemExit as ending:
        if ending.code:
            raise RuntimeError(f"exit code {ending.code}") from None
    finally:
        sys.argv = given


def calls(lab: Lab) -> int:
    """Return how many calls of the system it takes where there is room."""
    told, archive = lab.folder / "calls", lab.folder / "counted"
    code, said = lab.process(archive, Layer(0, for_good=False, told=told))
    if code:
        raise RuntimeError(said)
    return int(told.read_text(encoding="utf-8"))


def without_room(lab: Lab, points: int) -> tuple[Found, int]:
    """Let calls fail, as many as points, spread over all; return what was found, and how many calls there are."""
    found, total = Found(), calls(lab)
    for point in range(points):
        at, for_good, archive = 1 + point * total // points, bool(point % 2), lab.folder / "archive"
        where = f"call {at} of {total}{' and all after it' if for_good else ''}"
        lab.check(found, where, archive, *lab.process(archive, Layer(at, for_good=for_good)))
        lab.check_done(found, where, archive, *lab.process(archive))
        shutil.rmtree(archive)
    return found, total


def on_small_disks(lab: Lab, count: int) -> Found:
    """Process on disks from an eighth of the room that it takes to almost all."""
    found = Found()
    for number in range(count):
        size = int(lab.size * (0.125 + 0.85 * number / count))
        with small_disk(lab.folder / "disk", size) as disk:
            archive, where = disk / "archive", f"disk of {size} bytes"
            lab.check(found, where, archive, *_real([*lab.words, str(archive)]))
            _others(found, where, archive)
            subprocess.run(["mount", "-o", f"remount,size={4 * lab.size}", str(disk)], check=True)
            lab.check_done(found, where, archive, *_real([*lab.words, str(archive)]))
    return found


def _others(found: Found, where: str, archive: Path) -> None:
    """List and export with the disk full: the one needs no room, the other says so."""
    code, said = _real(["ls", "--archive", str(archive)])
    if archive.is_dir() and (code not in (0, 3) or "Traceback" in said):
        found.wrong.append(f"{where}: ls: exit code {code}: {said[-300:]}")
    runs = [path.stem for path in archive.glob("*.h5")]
    for words in (
        ["export", "csv", *runs, "--output", str(archive / "csv")],
        ["report", *runs, "-o", str(archive / "r.html")],
    ):
        code, said = _real([*words, "--archive", str(archive)]) if runs else (1, "")
        if code not in (0, 1, 3) or "Traceback" in said or leftovers(archive / "csv") or leftovers(archive):
            found.wrong.append(f"{where}: {words[0]}: exit code {code}: {said[-300:]}")
    shutil.rmtree(archive / "csv", ignore_errors=True)


def _real(words: list[str]) -> tuple[int, str]:
    done = subprocess.run([str(COMMAND), *words], check=False, capture_output=True, text=True, encoding="utf-8")
    return done.returncode, done.stderr


@contextmanager
def small_disk(at: Path, size: int) -> Iterator[Path]:
    """Give a disk in memory of so many bytes."""
    at.mkdir(exist_ok=True)
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(at)], check=True)
    try:
        yield at
    finally:
        subprocess.run(["umount", str(at)], check=True)


def may_mount() -> bool:
    """Tell whether small disks can be had here."""
    try:
        with tempfile.TemporaryDirectory() as folder, small_disk(Path(folder) / "disk", 1 << 20):
            return True
    except (OSError, subprocess.CalledProcessError):
        return False


def rows(what: str, found: Found) -> list[Row]:
    """Return what was found as rows of a table."""
    codes = ", ".join(f"{count} with exit code {code}" for code, count in sorted(found.codes.items()))
    return [
        Row(what, f"{found.tried}: {codes}"),
        Row("most sentences in one error message", str(found.sentences)),
        Row("tracebacks, wrong exit codes, unreadable or changed files", str(len(found.wrong)), "0", not found.wrong),
        Row("temporary files left behind", str(found.left), "0", not found.left),
        Row(
            "commands not completed when repeated with free space",
            str(len(found.unfinished)),
            "0",
            not found.unfinished,
        ),
    ]


def main() -> int:
    """Fill disks, and tell what was found."""
    options = asked(__doc__, points=100).parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # so that no small disk stays behind
    with tempfile.TemporaryDirectory() as scratch:
        lab = Lab(Path(scratch))
        injected, total = without_room(lab, options.points)
        disks = on_small_disks(lab, min(DISKS, options.points)) if may_mount() else Found()
    for found in (injected, disks):
        print(*found.wrong[:5], *found.unfinished[:5], sep="\n", file=sys.stderr)
    told = rows("system calls that fail because the disk is full", injected)
    told += rows("small disks", disks) if disks.tried else [Row("small disks", "not tried: they need root on Linux")]
    return tell(
        "full_disk",
        "Full disks",
        options,
        told,
        f"`tribopipe process` on {RUNS} short runs with figures makes {total} system calls that need disk space. In "
        "every second test, the disk remains full after the first failed call.",
    )


if __name__ == "__main__":
    sys.exit(main())

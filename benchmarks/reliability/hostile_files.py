"""Archived files that somebody made to do harm, sealed, and every command that reads them.

    python benchmarks/reliability/hostile_files.py

Each is put in the place of a good run or study; each command then works in a process of its own, one after another. It
has to say one sentence, or to do its work where nothing is wrong with what it reads, within 2 s more than it takes with
the good file, and within 500 MB. POSIX only.
"""

import os
import shutil
import signal
import sys
import tempfile
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from http.client import HTTPConnection
from pathlib import Path
from random import Random
from typing import NamedTuple

from forks import command, forked
from hostile_made import INSIDE, OUTSIDE, STUDY, make_hostile
from short_runs import quick_recipe, short_runs
from told import Row, asked, tell

from tribopipe.archive.store import Archive
from tribopipe.browse.server import HOST, running
from tribopipe.documents.recipe import Recipe
from tribopipe.documents.record import load_toml
from tribopipe.documents.study import Study
from tribopipe.pipeline.stages import process
from tribopipe.pipeline.studies import run_study

NAMES = [*INSIDE, *OUTSIDE, *STUDY]
SECONDS, MEGABYTES = 2.0, 500.0
RUN, STUDY_ID = "run-000", "study"
_STUCK = 30
"""Seconds after which a process is ended."""
_A_MEGABYTE = 1 << 20 if sys.platform == "darwin" else 1 << 10
"""What the system counts memory in."""

Commands = Mapping[str, Callable[[], object]]


class Seen(NamedTuple):
    """What a command did with a file."""

    name: str
    code: int
    seconds: float
    """Of work, which do not depend on what else the machine does."""
    megabytes: float
    said: str

    @property
    def is_sound(self) -> bool:
        """Whether it did its work, or refused in a sentence that says what it expected.

        The work of ``reproduce`` is to say what is archived otherwise than it comes out now.
        """
        refused = self.code in (1, 3) and ("expected" in self.said or ", recomputed " in self.said)
        return (self.code == 0 or refused) and "Traceback" not in self.said


def commands(archive: Path, out: Path) -> Commands:
    """Return all that reads the run and the study of an archive, by names."""
    where, run = ("--archive", archive), RUN
    told = {
        "ls": ("ls", *where),
        "show": ("show", run, *where),
        "show --json": ("show", run, "--json", *where),
        "show --path": ("show", run, "--path", "/entry", *where),
        "show --path raw": ("show", run, "--path", "/entry/raw", *where),
        "verify": ("verify", archive),
        "report": ("report", run, "--run", "-o", out / "run.html", *where),
        "export csv": ("export", "csv", run, "-o", out / "csv", *where),
        "reproduce": ("reproduce", run, *where),
        "rescue": ("rescue", archive / f"{run}.h5", "--to", out / "rescued"),
        "study show": ("study", "show", STUDY_ID, *where),
        "report of a study": ("report", STUDY_ID, "-o", out / "study.html", *where),
        "fit": ("fit", run, "--force", *where),
        "tag": ("tag", run, "--add", "seen", *where),
    }
    pages = {
        "browse runs": ("/api/runs", f"/api/runs/{RUN}"),
        "browse plots": (f"/api/runs/{RUN}/plots/depth", f"/api/runs/{RUN}/csv/raw", f"/api/studies/{STUDY_ID}"),
        "browse HDF5": (
            *(f"/h5/{route}?file={RUN}.h5&path=/entry/raw/depth" for route in ("attr", "data", "meta", "stats")),
            *(f"/h5/{route}?file={RUN}.h5" for route in ("meta", "paths")),
        ),
    }
    return {name: command(*words) for name, words in told.items()} | {
        name: partial(_browse, archive, targets) for name, targets in pages.items()
    }


def _browse(archive: Path, targets: Iterable[str]) -> None:
    """Ask the server; an answer that tells a mistake of its own counts as one."""
    with running(archive) as site:
        for target in targets:
            connection = HTTPConnection(HOST, site.port, timeout=_STUCK)
            connection.request("GET", target, headers=site.headers)
            answer = connection.getresponse()
            if answer.status >= 500:
                print(target, answer.read().decode(), "Traceback")
            connection.close()


def seen(name: str, work: Callable[[], object], said: Path) -> Seen:
    """Let a process of its own do some work, and say how it went."""
    said.unlink(missing_ok=True)
    child = forked(lambda: (signal.alarm(_STUCK), work()), said)
    _, status, used = os.wait4(child, 0)
    told = said.read_text(encoding="utf-8", errors="replace") if said.exists() else ""
    worked = used.ru_utime + used.ru_stime
    return Seen(name, os.waitstatus_to_exitcode(status), worked, used.ru_maxrss / _A_MEGABYTE, told)


def good_archive(folder: Path) -> Path:
    """Return an archive of two processed runs of 126 samples, and a study of them."""
    recipe, archive = load_toml(quick_recipe(folder), Recipe), Archive(folder / "good")
    done = list(process(short_runs(folder / "runs", 2), archive, recipe))
    done += run_study(archive, Study(id=STUDY_ID, fit=(RUN,), predict=("run-001",)), recipe)
    if failed := [one for one in done if one.error]:
        raise RuntimeError(failed)
    return archive.folder


def spoilt(good: Path, name: str, folder: Path) -> Path:
    """Return a copy of an archive in which one file is hostile."""
    archive = Path(shutil.copytree(good, folder / "archive"))
    path = Path("studies", f"{STUDY_ID}.h5") if name in STUDY else Path(f"{RUN}.h5")
    make_hostile(good / path, name, archive / path)
    return archive


def attacked(names: list[str], folder: Path, chosen: Callable[[str], bool] = lambda _: True) -> list[Row]:
    """Return a row for each hostile file: what the first refusal said, and the most that any command took."""
    good = good_archive(folder)
    usual = {one.name: one for one in _all_seen(good, folder, chosen)}
    rows = [Row("valid file", _told(list(usual.values())), "all commands succeed", _is_well(usual.values()))]
    for name in names:
        with tempfile.TemporaryDirectory(dir=folder) as scratch:
            found = _all_seen(spoilt(good, name, Path(scratch)), Path(scratch), chosen)
        broken = [one.name for one in found if not _holds(one, usual[one.name])]
        told = _told(found) + (f"; BROKEN by {', '.join(broken)}" if broken else "")
        rows.append(Row(name, told, f"{SECONDS:g} s more than usual, {MEGABYTES:g} MB", not broken))
    return rows


def _all_seen(archive: Path, folder: Path, chosen: Callable[[str], bool]) -> list[Seen]:
    out = folder / "out"
    out.mkdir()
    found = [seen(name, work, folder / "said.txt") for name, work in commands(archive, out).items() if chosen(name)]
    shutil.rmtree(out)
    return found


def _is_well(found: Iterable[Seen]) -> bool:
    return all(one.code == 0 for one in found)


def _holds(one: Seen, usual: Seen) -> bool:
    return one.is_sound and one.seconds <= usual.seconds + SECONDS and one.megabytes <= MEGABYTES


def _told(found: list[Seen]) -> str:
    refused = [one for one in found if one.code]
    slowest, largest = max(found, key=lambda one: one.seconds), max(found, key=lambda one: one.megabytes)
    said = f"rejected by {len(refused)} of {len(found)}: {_sentence(refused[0].said)}" if refused else "read correctly"
    return f"{said}; {slowest.seconds:.1f} s ({slowest.name}), {largest.megabytes:.0f} MB ({largest.name})"


def _sentence(said: str) -> str:
    """Return what was found, without the path before it and what to do after it."""
    line = next((line for line in said.splitlines() if "found " in line), said.strip())
    return line[line.find("found ") :].partition(";")[0].replace("|", "¦")[:140]


def main() -> int:
    """Try as many hostile files as are asked for; chance chooses which where these are not all."""
    options = asked(__doc__, points=len(NAMES)).parse_args()
    names = Random(options.seed).sample(NAMES, min(options.points, len(NAMES)))  # noqa: S311
    with tempfile.TemporaryDirectory() as scratch:
        rows = attacked(sorted(names, key=NAMES.index), Path(scratch))
    return tell(
        "hostile_files",
        "Hostile archived files",
        options,
        rows,
        f"{len(names)} files are read in {len(commands(Path(), Path()))} ways each, each time in a separate process. "
        "The table lists the longest time and the highest memory; a process that has only imported all modules uses "
        "200 MB.",
    )


if __name__ == "__main__":
    sys.exit(main())

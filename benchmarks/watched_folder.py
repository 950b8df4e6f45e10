"""Exports dropped into a watched folder in random chunks and order, while `tribopipe watch` is killed and ended.

    python benchmarks/watched_folder.py --write docs/results/watched_folder.md

A process writes virtual exports: each in several chunks with pauses shorter than what counts as settled, some under a
temporary name first, some into folders, all of them mixed. Meanwhile the watch is killed once and interrupted once, and
started again. In the end there has to be one run for each export, once, byte for byte. POSIX only.
"""

import hashlib
import json
import os
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from multiprocessing import get_context
from pathlib import Path
from random import Random
from typing import NamedTuple

from labs import Report, arguments

from tribopipe.archive.store import Archive
from tribopipe.base.files import leftovers
from tribopipe.documents.plan import Plan
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.record import load_toml
from tribopipe.extras.simulate import simulate_plan
from tribopipe.readers.draft.known_values import toml

COMMAND = Path(sys.executable).with_name("tribopipe")
_PLAN = Path(__file__).parents[1] / "sample_runs" / "plan.toml"
_LENGTH = 5.0
"""Sliding distance of a test, m: 126 samples."""
_CHUNKS = (2, 8)
_PAUSE = 0.5
"""Longest pause within an export, as part of what counts as settled."""
_PATIENCE = 120.0
"""How long the watch may take once all is written, s, beside 5 s for each export."""


class Chunk(NamedTuple):
    """What is appended to a file at a time."""

    at: float
    """s after the start."""
    path: Path
    content: bytes
    becomes: Path | None
    """Name that the file is given after it, where it had a temporary one."""


@dataclass
class Watched:
    """What was seen of a watch that was ended and started again."""

    codes: list[int] = field(default_factory=list)
    """Exit codes, one for each start."""
    events: list[dict[str, str]] = field(default_factory=list)
    said: str = ""
    begun: float = 0.0
    """When the first chunk could be written, s since 1970."""

    @property
    def archived(self) -> dict[str, float]:
        """When each export was said to be archived first, s since 1970, by its path in the folder."""
        ends = [(one["file"], datetime.fromisoformat(one["time"]).timestamp()) for one in self.events if _is_done(one)]
        return dict(reversed(ends))


def _is_done(event: dict[str, str]) -> bool:
    return event["event"] == "done"


# --- what is dropped ---


def exports(folder: Path, count: int) -> dict[str, bytes]:
    """Record so many virtual tests; write the lab's template beside them, and return the exports by name."""
    series = load_toml(_PLAN, Plan).series[0]
    runs = tuple(series.runs[0].model_copy(update={"id": f"test_{n:03}", "seed": n}) for n in range(count))
    length = Quantity(value=_LENGTH, unit="m")
    series = series.model_copy(update={"sliding_distance": length, "runs": runs})
    simulate_plan(Plan(schema="tribopipe.plan/1", series=(series,)), folder / "recorded")
    known = tomllib.loads((folder / "recorded" / "test_000" / "run.toml").read_text(encoding="utf-8"))
    told = {"schema": "tribopipe.template/1"} | {key: known[key] for key in ("contact", "conditions", "end_values")}
    text = "".join(f"{key} = {toml(value)}\n" for key, value in told.items())
    (folder / "lab.toml").write_text(text, encoding="utf-8")
    (folder / "recipe.toml").write_text(
        'schema = "tribopipe.recipe/1"\n[monte_carlo]\nsignificant_digits = 0\n', encoding="utf-8"
    )
    found = {f"{run.id}.csv": (folder / "recorded" / run.id / "signals.csv").read_bytes() for run in runs}
    shutil.rmtree(folder / "recorded")
    return found


def schedule(whole: dict[str, bytes], folder: Path, seconds: float, settle: float, chance: Random) -> list[Chunk]:
    """Cut exports into chunks, and mix them over so many seconds."""
    chunks: list[Chunk] = []
    for number, (name, content) in enumerate(whole.items()):
        path = folder / ("day 1" if number % 5 == 4 else "") / name
        chunks += _cut(path, content, number % 5 == 3, seconds, _PAUSE * settle, chance)
    return sorted(chunks, key=lambda chunk: chunk.at)


def _cut(path: Path, content: bytes, hidden: bool, seconds: float, pause: float, chance: Random) -> Iterator[Chunk]:
    """Cut one export; a hidden one has another name until it is whole."""
    pauses = [0.0, *(chance.uniform(0.0, pause) for _ in range(chance.randint(*_CHUNKS) - 1))]
    places = sorted(chance.randrange(1, len(content)) for _ in pauses[1:])
    at = chance.uniform(0.0, max(0.0, seconds - sum(pauses)))
    part = path.with_name(f"{path.name}.part") if hidden else path
    for wait, start, end in zip(pauses, [0, *places], [*places, len(content)], strict=True):
        at += wait
        yield Chunk(at, part, content[start:end], path if hidden and end == len(content) else None)


def write(chunks: Sequence[Chunk]) -> None:
    """Write chunks when they are due."""
    start = time.monotonic()
    for chunk in chunks:
        time.sleep(max(0.0, chunk.at - (time.monotonic() - start)))
        with chunk.path.open("ab") as file:
            file.write(chunk.content)
        if chunk.becomes is not None:
            chunk.path.rename(chunk.becomes)


# --- the watch ---


def watch(lab: Path, settle: float, chunks: Sequence[Chunk], moments: Sequence[float]) -> Watched:
    """Watch while chunks are written; kill the watch at the first moment, s, and interrupt it at the second."""
    found, out, err = Watched(), lab / "events.jsonl", lab / "said.txt"
    words = ["in", "--template", "lab.toml", "--recipe", "recipe.toml", "--settle", str(settle), "--no-figures"]
    writer = get_context("spawn").Process(target=write, args=(chunks,))
    with out.open("wb") as events, err.open("wb") as said:

        def started() -> "subprocess.Popen[bytes]":
            command = [str(COMMAND), "watch", *words, "--json"]
            return subprocess.Popen(command, cwd=lab, stdout=events, stderr=said, start_new_session=True)

        process = started()
        writer.start()
        start, found.begun = time.monotonic(), time.time()
        for moment, number in zip(moments, (signal.SIGKILL, signal.SIGINT), strict=True):
            time.sleep(max(0.0, moment - (time.monotonic() - start)))
            found.codes.append(_end(process, number))
            process = started()
        writer.join()
        _wait_for(out, len({chunk.becomes or chunk.path for chunk in chunks if not _is_part(chunk)}))
        time.sleep(2 * settle)  # for what comes twice
        found.codes.append(_end(process, signal.SIGINT))
    found.events, found.said = _events(out), err.read_text(encoding="utf-8")
    return found


def _is_part(chunk: Chunk) -> bool:
    return chunk.path.suffix == ".part" and chunk.becomes is None


def _end(process: "subprocess.Popen[bytes]", number: int) -> int:
    os.killpg(process.pid, number)
    return process.wait(60)


def _wait_for(out: Path, count: int) -> None:
    """Wait until so many exports are said to be archived."""
    end = time.monotonic() + _PATIENCE + 5 * count
    while time.monotonic() < end and len({one["file"] for one in _events(out) if _is_done(one)}) < count:
        time.sleep(0.5)


def _events(out: Path) -> list[dict[str, str]]:
    """Return what was told so far; a kill may cut a line."""
    found = []
    for line in out.read_text(encoding="utf-8").splitlines():
        try:
            found.append(json.loads(line))
        except ValueError:
            continue
    return found


# --- what has to hold ---


class Row(NamedTuple):
    """One thing that was looked at."""

    what: str
    found: str
    asked: str = ""
    holds: bool = True


def rows(lab: Path, whole: dict[str, bytes], found: Watched) -> list[Row]:
    """Hold folder, runs and archive against what was dropped."""
    dropped = sorted(map(_sha256, whole.values()))
    made = [path.read_bytes() for path in (lab / "runs").glob("*/*.csv")]
    archive, count = Archive(lab / "archive"), str(len(whole))
    sources = [one.sha256 for run_id in archive.ids() for one in archive.outline(run_id).sources if one.name in whole]
    lying = {path.name: path.read_bytes() for path in (lab / "in").rglob("*") if path.is_file()}
    differing = {name for name, _ in lying.items() ^ whole.items()}
    others = [one for one in found.events if one["event"] not in ("made", "done")]
    left = [*leftovers(archive.folder), *(lab / "runs").glob(".*.part")]
    for part in leftovers(archive.folder):
        part.unlink()  # as `tribopipe verify` says
    verified = subprocess.run([str(COMMAND), "verify"], cwd=lab, capture_output=True, check=False).returncode
    codes = [-signal.SIGKILL, 130, 130]
    return [
        Row("run folders, one per export", str(len(made)), count, sorted(map(_sha256, made)) == dropped),
        Row("archived runs, one per export", str(len(archive.ids())), count, sorted(sources) == dropped),
        Row("modified exports", str(len(differing)), "0", not differing),
        Row("failures, duplicates, skipped files", str(len(others)), "0", not others),
        Row("exit code of `tribopipe verify`", str(verified), "0", verified == 0),
        Row("exit codes of `tribopipe watch`", _listed(found.codes), _listed(codes), found.codes == codes),
        Row("tracebacks", str(found.said.count("Traceback")), "0", "Traceback" not in found.said),
        Row("temporary files left by the kill", str(len(left))),
    ]


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _listed(codes: Sequence[int]) -> str:
    return ", ".join(str(int(code)) for code in codes)


def waits(chunks: Sequence[Chunk], found: Watched, folder: Path) -> Row:
    """Tell how long it took from the last chunk of an export to its run in the archive."""
    ends = {(chunk.becomes or chunk.path).relative_to(folder).as_posix(): found.begun + chunk.at for chunk in chunks}
    taken = [found.archived[name] - at for name, at in ends.items() if name in found.archived]
    shown = f"median {statistics.median(taken):.1f} s, longest {max(taken):.1f} s" if taken else "none"
    return Row("time from the last chunk to the archived run", shown)


def main() -> int:
    """Drop, watch, and tell what was found; the exit code is 1 where anything does not hold."""
    parser = arguments(__doc__ or "")
    parser.add_argument("--files", type=int, default=50, help="number of exports (%(default)s)")
    parser.add_argument("--seconds", type=float, default=60.0, help="over which they are dropped (%(default)s)")
    parser.add_argument("--settle", type=float, default=3.0, help="what counts as settled, s (%(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="what chance is drawn from (%(default)s)")
    options = parser.parse_args()
    # Who is started in the background ignores Ctrl-C, and so does what it starts.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    chance = Random(options.seed)  # noqa: S311
    with tempfile.TemporaryDirectory() as scratch:
        lab = Path(scratch)
        (lab / "in" / "day 1").mkdir(parents=True)
        whole = exports(lab, options.files)
        chunks = schedule(whole, lab / "in", options.seconds, options.settle, chance)
        moments = [options.seconds * chance.uniform(*part) for part in ((0.3, 0.45), (0.6, 0.75))]
        found = watch(lab, options.settle, chunks, moments)
        table = [*rows(lab, whole, found), waits(chunks, found, lab / "in")]
    print(found.said, file=sys.stderr)
    report = Report("A watched folder", options)
    report.say(
        f"{options.files} exports are written in {len(chunks)} chunks over {options.seconds:.0f} s, in random order. "
        f"`tribopipe watch --settle {options.settle:g}` is killed after {moments[0]:.0f} s and interrupted after "
        f"{moments[1]:.0f} s, and restarted each time."
    )
    held = {True: "yes", False: "NO"}
    cells = [[row.what, row.found, row.asked, held[row.holds] if row.asked else ""] for row in table]
    report.table(["Quantity", "Result", "Required", "Met"], cells)
    report.finish()
    return 0 if all(row.holds for row in table) else 1


if __name__ == "__main__":
    sys.exit(main())

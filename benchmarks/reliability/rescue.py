"""How much of the source files `tribopipe rescue` saves from damaged archived runs.

    python benchmarks/reliability/rescue.py --write

A run of each tribometer is processed completely, and its file is damaged in three ways, at random positions: one bit
flipped, a page of 4096 bytes zeroed, the file truncated. The rescued files are compared with the run folder.
"""

import random
import sys
import tempfile
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Literal

from told import Row, asked, tell

from tribopipe.archive.rescue import rescue
from tribopipe.archive.store import Archive
from tribopipe.base.errors import TribopipeError
from tribopipe.pipeline.stages import process

SAMPLES = Path(__file__).parents[2] / "sample_runs"
RUNS = ("si3n4-air-200mN", "si3n4-twin-disc-4pct-100k")
_NOT_ARCHIVED = "truth.json"
_PAGE = 4096
Saved = Literal["all sources", "some", "none", "WRONG"]


def flip_a_bit(content: bytearray, place: int) -> bytearray:
    """Flip a bit of a byte."""
    content[place] ^= 1 << place % 8
    return content


def zero_a_page(content: bytearray, place: int) -> bytearray:
    """Zero the page that a byte is in, as file systems do that lost it."""
    start = place // _PAGE * _PAGE
    end = min(start + _PAGE, len(content))
    content[start:end] = bytes(end - start)
    return content


def cut_off(content: bytearray, place: int) -> bytearray:
    """Cut all off from a byte on."""
    return content[:place]


DAMAGES: dict[str, Callable[[bytearray, int], bytearray]] = {
    "one bit flipped": flip_a_bit,
    "a page of 4096 bytes zeroed": zero_a_page,
    "file truncated": cut_off,
}


def saved_from(damaged: bytearray, run_id: str, folder: Path) -> Saved:
    """Return how many of a run's source files are saved from a damaged file; WRONG where one is not what it was."""
    path = folder / f"{run_id}.h5"
    path.write_bytes(damaged)
    with tempfile.TemporaryDirectory(dir=folder) as into:
        try:
            found = rescue(path, Path(into))
        except TribopipeError:
            return "none"
        same = [(found.folder / name).read_bytes() == (SAMPLES / run_id / name).read_bytes() for name in found.whole]
    if not all(same):
        return "WRONG"
    return "all sources" if set(found.whole) == _sources(run_id) else "some"


def _sources(run_id: str) -> set[str]:
    names = {path.relative_to(SAMPLES / run_id).as_posix() for path in (SAMPLES / run_id).rglob("*") if path.is_file()}
    return names - {_NOT_ARCHIVED}


def trials(points: int, seed: int, folder: Path) -> dict[str, Counter[Saved]]:
    """Damage runs in each way, and count what is saved."""
    archive, chance = Archive(folder / "archive"), random.Random(seed)  # noqa: S311
    failed = [one for one in process([SAMPLES / run_id for run_id in RUNS], archive) if one.error is not None]
    if failed:
        raise RuntimeError(failed)
    counts: dict[str, Counter[Saved]] = {name: Counter() for name in DAMAGES}
    for name, damage in DAMAGES.items():
        for number in range(points):
            run_id = RUNS[number % len(RUNS)]
            content = bytearray(archive.path(run_id).read_bytes())
            counts[name][saved_from(damage(content, chance.randrange(len(content))), run_id, folder)] += 1
    return counts


def rows(counts: dict[str, Counter[Saved]]) -> list[Row]:
    """Return what was found: of flips, nearly all have to leave every source; nothing wrong may ever be saved."""
    found = []
    for name, count in counts.items():
        total = count.total()
        words = ", ".join(f"{outcome} in {count[outcome]}" for outcome in ("all sources", "some", "none"))
        enough = name != "one bit flipped" or count["all sources"] >= 0.9 * total
        wanted = "all sources in 90 %" if name == "one bit flipped" else ""
        found.append(Row(f"{name}, {total} times: rescued", words, wanted, holds=enough))
    wrong = sum(count["WRONG"] for count in counts.values())
    return [*found, Row("rescued files with wrong content", str(wrong), "none", holds=not wrong)]


def main() -> int:
    """Damage, rescue and tell."""
    options = asked(__doc__, points=300).parse_args()
    with tempfile.TemporaryDirectory() as folder:
        counts = trials(options.points, options.seed, Path(folder))
    return tell(
        "rescue", "Source files rescued from damaged runs", options, rows(counts), (__doc__ or "").split("\n\n")[2]
    )


if __name__ == "__main__":
    sys.exit(main())

"""One bit flipped at random places of archived files, looked for by `tribopipe verify`, and by HDF5 alone.

    python benchmarks/reliability/bit_flips.py --write

Runs of both tribometers, taken through the whole line, and a study are archived. A bit is flipped at places drawn
evenly over all bytes, and at as many again drawn evenly over the kinds of bytes there are: the seal, the superblock of
HDF5, headers with their attributes, trees and heaps, texts, small fields, chunks of columns, and source files. Each
flipped file is looked at by `verify`; then, in a process of its own that may be ended, by HDF5 alone, to see what it
would have noticed; then by `verify` again under a seal made anew, which is how a flip would look that came before
sealing, or was meant.
"""

import random
import re
import shutil
import sys
import tempfile
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from apart import Apart, NoAnswerError
from file_bytes import Extent, content, extents
from told import Row, asked, tell

from tribopipe.archive.seal import seal_file
from tribopipe.archive.step_names import STEPS
from tribopipe.archive.store import Archive
from tribopipe.documents.recipe import Recipe
from tribopipe.documents.study import Study
from tribopipe.pipeline.stages import process
from tribopipe.pipeline.studies import run_study
from tribopipe.pipeline.verify.archive import look_at, recompute
from tribopipe.pipeline.verify.file_findings import Look

SAMPLES = Path(__file__).parents[2] / "sample_runs"
RUNS = ("si3n4-air-200mN", "si3n4-air-400mN", "si3n4-twin-disc-4pct-100k")
STUDY = Study(id="si3n4", fit=RUNS[:1], predict=RUNS[1:2])
_PATIENCE, _LONG_PATIENCE = 20.0, 300.0
"""How long one look at a file may take, s, which takes a tenth of a second; and how long all its steps once more."""
_TRIED_AGAIN = 3
"""Flips of each kind of content that are looked for by computing everything again, which takes seconds."""
_NOTICED, _SAME, _OTHER = "error", "unchanged content", "changed content, no error"
_STEP = "|".join(STEPS)
_CONTENT = {
    rf"^/entry/({_STEP})/parameters/.*": "parameters of a step, as viewers show them",
    rf"^/entry/({_STEP})/": "/entry/STEP/",
    r"^/entry/curve_\d+/.*": "curves of a study",
    r"^/entry/wear/.*": "the plot that opens first",
    r"^/entry/(conditions|end_values|[a-z_]+/properties)/.*": "conditions, end values and bodies, as viewers show them",
    r"_\d+/": "_N/",
}
"""Paths in a file, and what they hold where several hold the like."""


class Flip(NamedTuple):
    """One bit of one file."""

    name: str
    place: int
    bit: int
    kind: str


def fill(folder: Path) -> None:
    """Archive runs of both tribometers, taken through the whole line, and a study of two of them."""
    archive = Archive(folder)
    outcomes = [*process([SAMPLES / run_id for run_id in RUNS], archive), *run_study(archive, STUDY, Recipe())]
    failed = [one for one in outcomes if one.status == "failed"]
    if failed:
        raise RuntimeError(failed)


def draw(folder: Path, points: int, seed: int) -> list[Flip]:
    """Draw places evenly over all bytes, and as many again evenly over the kinds of bytes."""
    chance = random.Random(seed)  # noqa: S311
    pieces = [(name, extent) for name in _names(folder) for extent in extents(folder / name)]
    by_kind = defaultdict(list)
    for piece in pieces:
        by_kind[piece[1].kind].append(piece)
    kinds = sorted(by_kind)
    evenly = [_drawn(pieces, chance) for _ in range(points)]
    return evenly + [_drawn(by_kind[kinds[number % len(kinds)]], chance) for number in range(points)]


def _names(folder: Path) -> list[str]:
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*.h5"))


def _drawn(pieces: Sequence[tuple[str, Extent]], chance: random.Random) -> Flip:
    name, extent = chance.choices(pieces, weights=[extent.end - extent.start for _, extent in pieces])[0]
    return Flip(name, chance.randrange(extent.start, extent.end), chance.randrange(8), extent.kind)


@dataclass
class Seen:
    """What became of a flip."""

    flip: Flip
    found: bool
    """By verify, as it is."""
    alone: str = _SAME
    """What HDF5 makes of it: that it notices, reads the same or other content, hangs, or ends the process."""
    changed: tuple[str, ...] = ()
    """Parts that read other than they were, without a word from HDF5."""
    sealed_anew: str = ""
    """What finds it under a seal made anew: names of checks; empty where nothing does."""
    computed_again: str | None = None
    """What does where everything is computed again; none where that was not tried."""


@dataclass(frozen=True)
class Trial:
    """Files of a sound archive, flipped one at a time in a copy."""

    sound: Path
    copy: Path

    @contextmanager
    def flipped(self, flip: Flip) -> Iterator[Path]:
        """Flip a bit for a while."""
        path = self.copy / flip.name
        as_it_was = path.read_bytes()
        changed = bytearray(as_it_was)
        changed[flip.place] ^= 1 << flip.bit
        path.write_bytes(changed)
        yield path
        path.write_bytes(as_it_was)

    def look(self, flip: Flip, hdf5: Apart, verify: Apart) -> Seen:
        """See who finds a flip."""
        with self.flipped(flip) as path:
            seen = Seen(flip, found=bool(_checks((self.copy, flip.name))))
            if flip.kind == "seal":
                return seen
            seen.alone, seen.changed = self._alone(flip, _answer(hdf5, path))
            if seen.changed:
                seal_file(path)
                seen.sealed_anew = _answer(verify, (self.copy, flip.name))
        return seen

    def _alone(self, flip: Flip, now: dict[str, str] | str) -> tuple[str, tuple[str, ...]]:
        if isinstance(now, str):
            return now, ()
        was = _content(self.sound / flip.name)
        changed = tuple(sorted(part for part in was | now if was.get(part) != now.get(part)))
        return _OTHER if changed else _SAME, changed

    def compute_again(self, seen: Seen, again: Apart) -> None:
        """See whether computing everything again finds a flip that nothing else does under a seal made anew."""
        with self.flipped(seen.flip) as path:
            seal_file(path)
            seen.computed_again = _answer(again, (self.copy, seen.flip.name))


def _answer(apart: Apart, question: object) -> Any:
    try:
        return apart.ask(question)
    except NoAnswerError as why:
        return str(why)


_content = cache(content)


def _noticed(path: Path) -> dict[str, str] | str:
    """Return what HDF5 reads, or that it says that something is wrong."""
    try:
        return content(path)
    except Exception:  # noqa: BLE001 - whatever it says, it was noticed
        return _NOTICED


def _checks(asked_for: tuple[Path, str]) -> str:
    """Return the checks of verify that find something wrong with a file."""
    look, _ = look_at(*asked_for)
    return _named(look)


def _computed_again(asked_for: tuple[Path, str]) -> str:
    """Return the same of computing everything again that a file holds."""
    folder, name = asked_for
    return _named(recompute(Archive(folder), name))


def _named(look: Look) -> str:
    return ", ".join(sorted({finding.code for finding in look.findings if finding.severity != "note"}))


def flip_bits(points: int, seed: int, scratch: Path) -> list[Seen]:
    """Archive runs, flip bits, and return what became of each."""
    trial = Trial(scratch / "sound", scratch / "copy")
    fill(trial.sound)
    shutil.copytree(trial.sound, trial.copy)
    with Apart(_noticed, _PATIENCE) as hdf5, Apart(_checks, _PATIENCE) as verify:
        every = [trial.look(flip, hdf5, verify) for flip in draw(trial.sound, points, seed)]
    with Apart(_computed_again, _LONG_PATIENCE) as again:
        for alike in _by_content(_hidden(every)).values():
            for seen in alike[:_TRIED_AGAIN]:
                trial.compute_again(seen, again)
    return every


def _hidden(every: Sequence[Seen]) -> list[Seen]:
    """Return what none of the checks finds under a seal made anew."""
    return [seen for seen in every if seen.changed and not seen.sealed_anew]


def _by_content(hidden: Sequence[Seen]) -> dict[str, list[Seen]]:
    found = defaultdict(list)
    for seen in hidden:
        found[_held(seen)].append(seen)
    return dict(sorted(found.items()))


def _held(seen: Seen) -> str:
    """Return what kind of content a flip changed."""
    part = seen.changed[0]
    for pattern, kind in _CONTENT.items():
        part = re.sub(pattern, kind, part)
    return part


def rows_of(every: Sequence[Seen]) -> list[Row]:
    """Return what was asked for, and what would be without a seal."""
    found, alone = sum(seen.found for seen in every), Counter(seen.alone for seen in every)
    changed, hidden = sum(bool(seen.changed) for seen in every), len(_hidden(every))
    return [
        Row("flips detected by `verify`", f"{found} of {len(every)}", "all", holds=found == len(every)),
        *(Row(f"HDF5 without the seal: {what}", str(count)) for what, count in sorted(alone.items())),
        Row("changed content, seal recomputed: detected by other checks", f"{changed - hidden} of {changed}"),
    ]


def by_kind(every: Sequence[Seen]) -> str:
    """Return a table of what HDF5 alone makes of flips of each kind of bytes."""
    columns = sorted({seen.alone for seen in every})
    counts = Counter((seen.flip.kind, seen.alone) for seen in every)
    lines = [["Location", "Flips", *columns, "Detected with a recomputed seal"], ["---"] * (len(columns) + 3)]
    for kind in sorted({seen.flip.kind for seen in every}):
        of_kind = [seen for seen in every if seen.flip.kind == kind]
        changed = sum(bool(seen.changed) for seen in of_kind)
        found = f"{changed - len(_hidden(of_kind))} of {changed}" if changed else "–"
        lines.append([kind, str(len(of_kind)), *(str(counts[kind, what]) for what in columns), found])
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def by_content(every: Sequence[Seen]) -> str:
    """Return a list of what no check sees under a seal made anew, and whether computing it again does."""
    lines = ["Changes that no check detects if the seal is recomputed:", ""]
    for held, alike in _by_content(_hidden(every)).items():
        tried = [seen.computed_again for seen in alike if seen.computed_again is not None]
        lines.append(f"* {held}: {len(alike)}; `--recompute` detects {sum(map(bool, tried))} of {len(tried)} tested")
    return "\n".join(lines)


def main() -> None:
    """Flip bits, and tell what became of them."""
    options = asked(__doc__, points=2000).parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        every = flip_bits(options.points, options.seed, Path(scratch))
    about = (
        f"The archive contains {len(RUNS)} runs and a study. {options.points} bit flips are distributed evenly over "
        f"all bytes, and another {options.points} evenly over the types of content."
    )
    sys.exit(
        tell("bit_flips", "Single flipped bits", options, rows_of(every), about, by_kind(every), by_content(every))
    )


if __name__ == "__main__":
    main()

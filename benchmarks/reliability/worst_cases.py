"""Every reader, documents and crates on 16, 64 and 128 KB of worst cases: time has to grow with size.

    python benchmarks/reliability/worst_cases.py

Twelve alphabets make a careless regular expression begin anew at every character. Readers are asked whether a file is
theirs, and to read it; documents are parsed, and crates of such metadata imported.
"""

import json
import resource
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple
from zipfile import ZIP_DEFLATED, ZipFile

from told import Row, asked, tell

from tribopipe.archive.store import Archive
from tribopipe.base.errors import TribopipeError
from tribopipe.documents.toml import parse_toml
from tribopipe.extras.fair.restore import restore
from tribopipe.readers.reader import Hints
from tribopipe.readers.registry import readers
from tribopipe.results.run import SourceFile

ALPHABETS = {
    "blanks": " ",
    "tabs": "\t",
    "line ends": "\n",
    "letters": "a",
    "digits": "1",
    "zeros and points": "0.",
    "quotes": '"',
    "escaped quotes": '\\"',
    "brackets": "[",
    "separators": ";,",
    "dotted names": "a.",
    "words": "ab 12 ",
}
SIZES = 16 << 10, 64 << 10, 128 << 10
MOST, FLOOR = 2.5, 0.1
"""How many times as long twice the size may take, where it takes longer than so many seconds."""
MEGABYTES = 500.0
_A_MEGABYTE = 1 << 20 if sys.platform == "darwin" else 1 << 10


class Taken(NamedTuple):
    """Work that something took on an alphabet of each size, s."""

    what: str
    alphabet: str
    seconds: tuple[float, ...]

    @property
    def is_linear(self) -> bool:
        """Whether it grows no faster than the size, as far as the clock tells."""
        return self.seconds[-1] < max(FLOOR, MOST * self.seconds[-2])


def text_of(alphabet: str, size: int) -> str:
    """Return so many bytes of an alphabet, and one character at the end that keeps a pattern from matching all."""
    return (ALPHABETS[alphabet] * size)[: size - 1] + "!"


def timed(what: str, alphabet: str, work: Callable[[str], object]) -> Taken:
    """Do some work on each size of an alphabet; the least of three counts, where it is short."""
    taken = []
    for size in SIZES:
        text, best = text_of(alphabet, size), float("inf")
        for _ in range(3):
            start = time.process_time()
            work(text)
            best = min(best, time.process_time() - start)
            if best > 1.0:
                break
        taken.append(best)
    return Taken(what, alphabet, tuple(taken))


def all_readers() -> list[Taken]:
    """Time every reader, documents and crates on every alphabet."""
    works: dict[str, Callable[[str], object]] = {name: partial(_read, one) for name, one in readers().items()}
    works |= {"a document": _parse, "a crate": _import}
    return [timed(name, one, work) for name, work in works.items() for one in ALPHABETS]


def _read(reader: Any, text: str) -> None:
    source = SourceFile("export.txt", text.encode())
    with suppress(TribopipeError), warnings.catch_warnings(action="ignore"):
        reader.match(source)
        reader.read(source, Hints())


def _parse(text: str) -> None:
    with suppress(TribopipeError):
        parse_toml(Path("run.toml"), text.encode())


def _import(text: str) -> None:
    """Import crates with a text as their metadata, and as a text within them."""
    for metadata in (text, json.dumps({"@graph": [{"@id": text, "contentSize": text, "sha256": text}]})):
        with tempfile.TemporaryDirectory() as folder, suppress(TribopipeError):
            path = Path(folder, "crate.zip")
            with ZipFile(path, "w", ZIP_DEFLATED) as packed:
                packed.writestr("ro-crate-metadata.json", metadata)
            restore(path, Archive(Path(folder, "archive")))


def rows(found: list[Taken]) -> list[Row]:
    """Return what was found as rows of a table."""
    slow, worst = [one for one in found if not one.is_linear], max(found, key=lambda one: one.seconds[-1])
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / _A_MEGABYTE
    return [
        Row("readers, documents and crates", str(len({one.what for one in found}))),
        Row("longest at 128 KB", f"{worst.seconds[-1]:.2f} s (`{worst.what}`, {worst.alphabet})"),
        Row(f"of {len(found)}, more than {MOST} times as long at 128 KB", str(len(slow)), "0", not slow),
        Row("peak of memory", f"{peak:.0f} MB", f"< {MEGABYTES:.0f} MB", peak < MEGABYTES),
    ]


def main() -> int:
    """Time, and tell what was found."""
    options = asked(__doc__, points=1).parse_args()
    found = all_readers()
    for one in found:
        if not one.is_linear:
            print(one, file=sys.stderr)
    return tell(
        "worst_cases",
        "Readers on worst cases",
        options,
        rows(found),
        f"Processor time on 16, 64 and 128 KB of each of: {', '.join(ALPHABETS)}; the least of three. Where 128 KB "
        f"take less than {FLOOR * 1e3:.0f} ms, the ratio says nothing.",
    )


if __name__ == "__main__":
    sys.exit(main())

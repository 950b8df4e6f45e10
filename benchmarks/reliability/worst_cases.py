"""Every pattern, every reader, documents and crates on 16, 64 and 128 KB of worst cases: time has to grow with size.

    python benchmarks/reliability/worst_cases.py

Twelve alphabets make a careless regular expression begin anew at every character. Each pattern is called as the package
calls it. Readers are asked whether a file is theirs, and to read it: one of an alphabet alone, and one of their format
with the alphabet in its first line, or in a row. Documents are parsed, and crates of such metadata imported.
"""

import gc
import json
import re
import resource
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple
from zipfile import ZIP_DEFLATED, ZipFile

from mutations import of_tests
from own_patterns import LONGEST, OwnPattern, own_patterns
from told import Row, asked, tell

from tribopipe.archive.store import Archive
from tribopipe.base.errors import TribopipeError
from tribopipe.documents.toml import parse_toml
from tribopipe.extras.fair.restore import restore
from tribopipe.readers.reader import Hints, readers
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
MOST = 2.5
"""How many times as long twice the size may take."""
TIMES, TRIES = 3, 40
"""How often each size is timed, and at most where it does not look linear: other processes make times longer only."""
SHORTEST = 2e-3
"""What takes less is repeated until it takes as long, s."""
AT_MOST = 0.1
"""How long a pattern may take on the longest text that it is given, where that is bounded, s."""
MEGABYTES = 500.0
_A_MEGABYTE = 1 << 20 if sys.platform == "darwin" else 1 << 10


class Taken(NamedTuple):
    """Work that something took on an alphabet of each size, s."""

    what: str
    alphabet: str
    seconds: tuple[float, ...]

    @property
    def is_linear(self) -> bool:
        """Whether it grows no faster than the size."""
        return self.seconds[-1] < MOST * self.seconds[-2]


def text_of(alphabet: str, size: int) -> str:
    """Return so many bytes of an alphabet, and one character at the end that keeps a pattern from matching all."""
    return (ALPHABETS[alphabet] * size)[: size - 1] + "!"


def timed(what: str, alphabet: str, work: Callable[[Any], object], prepared: Callable[[str], Any] = str) -> Taken:
    """Do some work on what is prepared of each size of an alphabet, again and again; the least counts."""
    texts = [prepared(text_of(alphabet, size)) for size in SIZES]
    taken = Taken(what, alphabet, tuple(_seconds(work, text) for text in texts))
    for number in range(1, TRIES):
        if number >= TIMES and taken.is_linear:
            break
        again = (_seconds(work, text) for text in texts)
        taken = taken._replace(seconds=tuple(map(min, taken.seconds, again)))
    return taken


def _seconds(work: Callable[[Any], object], text: Any) -> float:
    """Return the processor time that some work takes, s."""
    count, taken = 1, 0.0
    while True:
        start = time.process_time()
        for _ in range(count):
            work(text)
        taken = time.process_time() - start
        if taken >= SHORTEST:
            return taken / count
        count = max(2 * count, int(1.2 * count * SHORTEST / max(taken, 1e-7)))


def all_patterns() -> list[Taken]:
    """Time every pattern on every alphabet; those given short texts only are left to ``longest_texts``."""
    patterns = [one for one in own_patterns().patterns if one.where not in LONGEST]
    return [
        timed(f"{one.where}, {one.call}", name, called(one), _as_given(one)) for one in patterns for name in ALPHABETS
    ]


def longest_texts() -> dict[str, float]:
    """Return the processor time of patterns whose texts are bounded on the longest text, at worst, s."""
    patterns = [one for one in own_patterns().patterns if one.where in LONGEST]
    return {
        one.where: max(_seconds(called(one), _as_given(one)(text_of(name, LONGEST[one.where]))) for name in ALPHABETS)
        for one in patterns
    }


def called(one: OwnPattern) -> Callable[[Any], object]:
    """Return what a pattern is called by, for a text, or for bytes."""
    call = getattr(one.pattern, one.call)
    if one.call in ("sub", "subn"):
        call = partial(call, type(one.pattern.pattern)())
    return (lambda text: sum(1 for _ in call(text))) if one.call == "finditer" else call


def _as_given(one: OwnPattern) -> Callable[[str], Any]:
    """Return what makes of a text what a pattern is for."""
    return str.encode if isinstance(one.pattern.pattern, bytes) else str


def all_readers() -> list[Taken]:
    """Time every reader, documents and crates on every alphabet."""
    taken = [
        timed(f"{name}{where}", one, partial(_read, reader), partial(_source, *place))
        for name, reader in readers().items()
        for where, place in _places(name).items()
        for one in ALPHABETS
    ]
    taken += [timed("a document", one, _parse, str.encode) for one in ALPHABETS]
    return taken + [timed("a crate", one, _import) for one in ALPHABETS]


def _places(reader: str) -> dict[str, tuple[str, bytes, bytes]]:
    """Return names of files, and what stands in them before and behind a text, by where that is."""
    at = {"": ("export.txt", b"", b"")}
    examples = of_tests("reader_examples").EXAMPLES.get(reader)
    if examples is None:  # as of one that another package is for
        return at
    name, content = examples[0].name, examples[0].content
    ends = [found.start() for found in re.finditer(rb"\r?\n|\r", content)] or [len(content)]
    for where, end in ((", in its first line", ends[0]), (", in a row", ends[-1])):
        at[where] = (name, content[:end], content[end:])
    return at


def _source(name: str, before: bytes, behind: bytes, text: str) -> SourceFile:
    inserted = text.encode()[len(before) + len(behind) :]  # so that the size is that of the file
    return SourceFile(name, before + inserted + behind)


def _read(reader: Any, source: SourceFile) -> None:
    with suppress(TribopipeError), warnings.catch_warnings(action="ignore"):
        reader.match(source)
        reader.read(source, Hints())


def _parse(content: bytes) -> None:
    with suppress(TribopipeError):
        parse_toml(Path("run.toml"), content)


def _import(text: str) -> None:
    """Import crates with a text as their metadata, and as a text within them."""
    for metadata in (text, json.dumps({"@graph": [{"@id": text, "contentSize": text, "sha256": text}]})):
        with tempfile.TemporaryDirectory() as folder, suppress(TribopipeError):
            path = Path(folder, "crate.zip")
            with ZipFile(path, "w", ZIP_DEFLATED) as packed:
                packed.writestr("ro-crate-metadata.json", metadata)
            restore(path, Archive(Path(folder, "archive")))


def rows(patterns: list[Taken], found: list[Taken], bounded: dict[str, float]) -> list[Row]:
    """Return what was found as rows of a table."""
    made = [*_rows("regular expressions", patterns), *_rows("readers, documents and crates", found)]
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / _A_MEGABYTE
    longest = f"{1e3 * max(bounded.values()):.2f} ms (`{max(bounded, key=bounded.__getitem__)}`)"
    return [
        *made,
        Row("regular expressions with input of limited length", str(len(bounded))),
        Row(
            "longest time with the longest input", longest, f"< {AT_MOST * 1e3:.0f} ms", max(bounded.values()) < AT_MOST
        ),
        Row("peak memory", f"{peak:.0f} MB", f"< {MEGABYTES:.0f} MB", peak < MEGABYTES),
    ]


def _rows(what: str, found: list[Taken]) -> Iterator[Row]:
    slow, worst = [one for one in found if not one.is_linear], max(found, key=lambda one: one.seconds[-1])
    steep = max(found, key=lambda one: one.seconds[-1] / one.seconds[-2])
    yield Row(what, str(len({one.what for one in found})))
    yield Row("longest time for 128 KB", f"{worst.seconds[-1]:.3f} s (`{worst.what}`, {worst.alphabet})")
    ratio = steep.seconds[-1] / steep.seconds[-2]
    told = f"{len(slow)} of {len(found)}; largest ratio {ratio:.2f} (`{steep.what}`, {steep.alphabet})"
    yield Row(f"cases that take at least {MOST} times as long for 128 KB as for 64 KB", told, "0", not slow)


def main() -> int:
    """Time, and tell what was found."""
    options = asked(__doc__, points=1).parse_args()
    gc.freeze()  # what was imported is not looked through again and again
    patterns = all_patterns()
    print(f"patterns: {time.process_time():.0f} s", file=sys.stderr, flush=True)
    found = all_readers()
    for one in (*patterns, *found):
        if not one.is_linear:
            print(one, file=sys.stderr)
    return tell(
        "worst_cases",
        "Regular expressions and readers with worst-case input",
        options,
        rows(patterns, found, longest_texts()),
        f"CPU time is measured for 16, 64 and 128 KB of each of these alphabets: {', '.join(ALPHABETS)}. It is the "
        f"minimum of {TIMES} repeats, or of up to {TRIES} if the time does not appear to be linear. Calls that take "
        f"less than {SHORTEST * 1e3:.0f} ms are repeated until they take {SHORTEST * 1e3:.0f} ms in total, so that "
        "all ratios are meaningful. Each regular expression is called as in the package; each reader reads a file "
        "that contains only the alphabet, and a file in its format with the alphabet in the first line or in a row.",
    )


if __name__ == "__main__":
    sys.exit(main())

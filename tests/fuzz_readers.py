"""A program that tries readers on files that went wrong: nothing but ReaderError, nothing slow, no end of memory.

    python tests/fuzz_readers.py seeded|guided SECONDS SEED FOLDER [READER…]

``seeded`` changes the examples by drawn rules; ``guided`` lets atheris (Linux only) look for new paths through
tribopipe.readers. The first fault ends the program with status 1 or higher; FOLDER holds the file that caused it.
"""

import contextlib
import faulthandler
import random
import sys
import time
import warnings
from collections.abc import Sequence
from pathlib import Path

LONGEST_SECONDS = 5
MOST_MEMORY = 3 << 30
TOKENS = (
    *(b"", b"\0", b"\r", b"\n", b"\r\n", b"\t", b";", b",", b'"', b"#", b" ", b"-", b"=", b"[", b"(", b"\x1a", b"\x81"),
    *(b"nan", b"inf", b"1e999", b"-1e-999", b"99999999999999999999", b"0x1", b"1,5", b"1.5", b"1_0", b"\xef\xbb\xbf"),
    *(b"\xff\xff\xff\xff", b"\xff\xff\xff\x7f", "µ".encode(), "٣".encode(), b"\xff\xfe", b"31/02/2024", b"25:61:61"),
)


def mutated(draw: random.Random, content: bytes, other: bytes) -> bytes:
    """Change a file in one to four places."""
    for _ in range(draw.randint(1, 4)):
        first, last = sorted(draw.randrange(len(content) + 1) for _ in range(2))
        near = min(last, first + draw.choice((0, 1, 8)))
        content = draw.choice(
            (
                content[:last],
                content[first:],
                content[:first] + draw.choice(TOKENS) + content[near:],
                content[:first] + draw.choice(TOKENS) * draw.choice((2, 100, 5000)) + content[near:],
                content[:first] + content[last:],
                content[:last] + content[first:],
                content[:first] + bytes([draw.randrange(256)]) + content[first + 1 :],
                content[:first] + other[draw.randrange(len(other)) :],
            )
        )
    return content[: 1 << 20]


class Trial:
    """The readers, their examples, and what is done with a file."""

    def __init__(self, names: Sequence[str], folder: Path) -> None:
        from reader_examples import EXAMPLES

        from tribopipe.readers.reader import Hints, readers

        self.hints = Hints()
        self.readers = [(name, reader) for name, reader in readers().items() if name in (names or EXAMPLES)]
        self.seeds = [
            bytes([number]) + example.content
            for number, (name, _) in enumerate(self.readers)
            for example in EXAMPLES[name]
        ]
        self.folder = folder
        self.files = 0

    def run(self, data: bytes) -> None:
        """Give a file to a reader; its number is the first byte."""
        from tribopipe.base.errors import ReaderError
        from tribopipe.results.run import SourceFile

        if not data:
            return
        name, reader = self.readers[data[0] % len(self.readers)]
        source = SourceFile("fuzzed", data[1:])
        started = time.perf_counter()
        self.files += 1
        try:
            reader.match(source)
            with contextlib.suppress(ReaderError):
                reader.read(source, self.hints)
            if time.perf_counter() - started > LONGEST_SECONDS:
                raise TimeoutError(f"more than {LONGEST_SECONDS} s")
        except BaseException:
            (self.folder / f"fault-{name}").write_bytes(source.content)
            raise


def seeded(trial: Trial, seconds: float, seed: int) -> None:
    """Try examples changed by drawn rules."""
    draw = random.Random(seed)  # noqa: S311 - no secret
    ends = time.monotonic() + seconds
    while time.monotonic() < ends:
        start = draw.choice(trial.seeds)
        data = start[:1] + mutated(draw, start[1:], draw.choice(trial.seeds)[1:])
        (trial.folder / "last").write_bytes(data)
        faulthandler.dump_traceback_later(6 * LONGEST_SECONDS, exit=True)
        trial.run(data)


def guided(trial: Trial, seconds: float, seed: int) -> None:
    """Let atheris look for new paths; it ends the process."""
    import atheris

    corpus = trial.folder / "corpus"
    corpus.mkdir()
    for number, data in enumerate(trial.seeds):
        (corpus / f"{number}").write_bytes(data)
    options = (f"-max_total_time={seconds:.0f}", f"-seed={seed}", f"-rss_limit_mb={MOST_MEMORY >> 20}")
    options += (f"-timeout={6 * LONGEST_SECONDS}", f"-artifact_prefix={trial.folder}/", "-max_len=8192")
    atheris.Setup([sys.argv[0], *options, str(corpus)], trial.run)
    atheris.Fuzz()


def bound_memory() -> None:
    """Let an allocation fail rather than the computer."""
    if sys.platform != "win32":
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))


def main() -> None:
    how, seconds, seed, folder, *names = sys.argv[1:]
    loaded: contextlib.AbstractContextManager = contextlib.nullcontext()
    if how == "guided":
        import atheris

        loaded = atheris.instrument_imports(include=["tribopipe.readers"])
    else:
        bound_memory()
    with loaded:
        trial = Trial(names, Path(folder))
    warnings.simplefilter("error")
    {"guided": guided, "seeded": seeded}[how](trial, float(seconds), int(seed))
    print(f"{trial.files} files")  # noqa: T201 - a program


if __name__ == "__main__":
    main()

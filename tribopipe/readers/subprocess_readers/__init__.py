"""Programs that read what a library may choke on: a process of its own has bounded time and memory.

A damaged workbook can make python-calamine end its process, a flipped bit can make HDF5 ask for all memory. The
programs are started as scripts, so that they load nothing but the library they need: they know nothing of tribopipe.
Each gets the file by standard input, or its path, and answers by standard output.
"""

import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from tribopipe.base.errors import ReaderError
from tribopipe.base.process_lifecycle import undone_by
from tribopipe.results.run import SourceFile

_LEAST_SECONDS = 20.0
"""Limit of elapsed (wall-clock) time, which includes the time of other programs."""
_LEAST_SECONDS_OF_WORK = 2
_BYTES_A_SECOND = 1_000_000
_LEAST_MEMORY = 1 << 30
_MEMORY_A_BYTE = 100


def answer_of(program: str, source: SourceFile, *arguments: str, remedy: str) -> bytes:
    """Let a program next to this file read a file; the time and memory it may take grow with the file.

    Raises ``ReaderError`` with the remedy where the program ends without an answer, or takes too much of either.
    """
    return _answer(program, source.name, len(source.content), arguments, remedy, source.content)


def answer_about(program: str, path: Path, size: int, *, remedy: str) -> bytes:
    """Let a program next to this file read parts of a file, whose bytes in use are counted. As ``answer_of``."""
    return _answer(program, str(path), size, [str(path)], remedy)


def _answer(program: str, name: str, size: int, arguments: Sequence[str], remedy: str, content: bytes = b"") -> bytes:
    bounded = str(Path(__file__).with_name("bounded.py"))
    memory = str(_LEAST_MEMORY + _MEMORY_A_BYTE * size)
    more = size // _BYTES_A_SECOND
    seconds, of_work = _LEAST_SECONDS + more, str(_LEAST_SECONDS_OF_WORK + more)
    started = subprocess.Popen(  # noqa: S603 - a program of our own
        [sys.executable, "-P", bounded, memory, of_work, program, *arguments],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},  # each thread would reserve memory
    )
    with started as reader, undone_by(reader.kill):
        try:
            answer, errors = reader.communicate(content, timeout=seconds)
        except subprocess.TimeoutExpired:
            raise _damaged(name, f"reading takes more than {seconds:.0f} s", remedy) from None
    if reader.returncode:
        said = errors.decode(errors="replace").strip().splitlines()
        known = reader.returncode == 1 and said
        raise _damaged(name, said[-1] if known else "reading takes too much time or memory, or fails", remedy)
    return answer


def _damaged(name: str, why: str, remedy: str) -> ReaderError:
    return ReaderError(f"{name}: found a file that cannot be read ({why}); expected a complete file; {remedy}")

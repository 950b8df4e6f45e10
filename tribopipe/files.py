"""Files read fast, files written whole or not at all, and names in the order people expect."""

import os
import re
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path

_LARGE = 8 << 20
_THREADS = 2


def read_file(path: Path) -> bytes:
    """Return a file's bytes; the halves of a large one are read at once, as taking the memory is what takes time.

    Raises ``OSError`` where the file cannot be read, or became shorter meanwhile.
    """
    size = path.stat().st_size
    if size < _LARGE:
        return path.read_bytes()
    buffer = BytesIO(bytes(size))  # of memory not touched yet
    ends = [size * part // _THREADS for part in range(_THREADS + 1)]
    with buffer.getbuffer() as view, ThreadPoolExecutor(_THREADS) as pool:
        list(pool.map(lambda start, end: _fill(path, start, view[start:end]), ends[:-1], ends[1:]))
    return buffer.getvalue()


def _fill(path: Path, start: int, part: memoryview) -> None:
    with part, path.open("rb") as file:
        file.seek(start)
        if file.readinto(part) < len(part):
            raise OSError(0, "the file became shorter while it was read")


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Give the name of a temporary file beside ``path`` that takes its place on success and vanishes on failure.

    The content is on the disk before it is given its name, so that a crash leaves the old file or the new one.
    """
    handle, name = tempfile.mkstemp(prefix=f".{path.name}.", suffix=".part", dir=path.parent)
    os.close(handle)
    part = Path(name)
    try:
        yield part
        with part.open("rb+") as written:
            os.fsync(written.fileno())
        part.chmod(0o666 & ~_umask())
        part.replace(path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def write_file(path: Path, content: bytes) -> None:
    """Write a file whole or not at all."""
    with replacing(path) as part:
        part.write_bytes(content)


def natural_order(name: str) -> list[tuple[str, int]]:
    """Return a key that sorts "400mN" before "1200mN"."""
    return [(text, int(digits or 0)) for text, digits in re.findall(r"(\D*)(\d{0,18})", name)]


def _umask() -> int:
    """Return the process's umask; a file made by mkstemp is private, one of ours is as any other."""
    mask = os.umask(0)
    os.umask(mask)
    return mask

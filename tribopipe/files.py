"""Files written whole or not at all, and names in the order people expect."""

import os
import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


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

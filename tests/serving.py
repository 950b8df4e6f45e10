"""`tribopipe browse` started as a user starts it."""

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Address:
    """Where a server listens, and its key."""

    base: str
    key: str

    def of(self, path: str = "/") -> str:
        """Return the address of a page, with the key."""
        return f"{self.base}{path}{'&' if '?' in path else '?'}key={self.key}"


@contextmanager
def served(archive: Path, **env: str) -> Iterator[Address]:
    """Run `tribopipe browse` on an archive, and say where it listens."""
    command = [
        sys.executable,
        "-m",
        "tribopipe",
        "browse",
        "--archive",
        str(archive.absolute()),
        "--no-browser",
    ]
    told = {"stderr": subprocess.PIPE, "encoding": "utf-8", "env": {**os.environ, **env}}
    process = subprocess.Popen(command, cwd=archive, **told)  # not where a module of the sources would be found first
    try:
        yield _address(process)
    finally:
        process.terminate()
        process.wait(10)
        assert process.stderr is not None
        process.stderr.close()


def _address(process: "subprocess.Popen[str]") -> Address:
    assert process.stderr is not None
    said = []
    for line in process.stderr:
        if found := re.search(r"(http://127\.0\.0\.1:\d+)/\?key=([\w-]{22}) ", line):
            return Address(*found.groups())
        said.append(line)
    raise AssertionError(f"the server ended without saying where it listens: {''.join(said)}")

"""Every reader on files that went wrong, for a bounded time: by drawn rules, and led by coverage where atheris is."""

import contextlib
import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest
from reader_examples import EXAMPLES

from tribopipe.base.errors import ReaderError
from tribopipe.readers.reader import Hints, readers
from tribopipe.results.run import SourceFile

PROGRAM = Path(__file__).with_name("fuzz_readers.py")
OTHERS_DO_THE_READING = ("workbook", "matlab", "tribopipe-hdf5")
"""These start a process for each file, so that coverage shows nothing and files are few."""
IN_PROCESS = [name for name in EXAMPLES if name not in OTHERS_DO_THE_READING]

pytestmark = pytest.mark.slow


def fuzz(how: str, seconds: int, folder: Path, names: list[str], seed: int = 1) -> None:
    command = [sys.executable, str(PROGRAM), how, str(seconds), str(seed), str(folder), *names]
    done = subprocess.run(command, capture_output=True, text=True, timeout=seconds + 60, errors="replace")
    faults = {path.name: path.read_bytes()[:2000] for path in folder.iterdir() if path.is_file()}
    assert done.returncode == 0, f"{faults}\n{done.stderr[-4000:]}"


def test_files_changed_by_drawn_rules(tmp_path):
    fuzz("seeded", 10, tmp_path, IN_PROCESS)


@pytest.mark.parametrize("name", OTHERS_DO_THE_READING)
def test_files_read_by_a_process_of_their_own(tmp_path, name):
    fuzz("seeded", 5, tmp_path, [name])


@pytest.mark.parametrize("name", IN_PROCESS)
def test_fields_longer_than_any_in_any_line(name):
    reader = readers()[name]
    for content in (example.content for example in EXAMPLES[name]):
        for start in (0, *(end.end() for end in re.finditer(rb"\r\n?|\n", content[:6000]))):
            for put in (b"9" * 140_000, b'"' + b"x" * 140_000, b"1," * 70_000):
                source = SourceFile("long", content[:start] + put + content[start:])
                reader.match(source)
                with contextlib.suppress(ReaderError):
                    reader.read(source, Hints())


@pytest.mark.skipif(find_spec("atheris") is None, reason="atheris is not installed")
def test_files_found_by_coverage(tmp_path):
    fuzz("guided", 12, tmp_path, IN_PROCESS)

"""Programs that read what a library may choke on end where they take too much memory, whatever the system bounds."""

import subprocess
import sys
from pathlib import Path

import pytest

from tribopipe.readers import subprocess_readers
from tribopipe.readers.subprocess_readers.bounded import peak_memory

FOLDER = Path(subprocess_readers.__file__).parent
TAKES = """
import time
from bounded import peak_memory, watch_memory
watch_memory(peak_memory() + {room})
taken = b"x" * (200 << 20)  # zeros alone would take no memory
time.sleep({rests})
print("done")
"""
BETWEEN = "import subprocess, sys; sys.exit(subprocess.run([sys.executable, '-c', sys.argv[1]]).returncode)"
"""Linux counts the peak of who starts a process in that of the process: a small one has to start it."""


@pytest.mark.slow
@pytest.mark.parametrize(("room", "rests", "code"), [(100 << 20, 30, 3), (400 << 20, 0.2, 0)])
def test_a_process_ends_soon_after_it_took_too_much(room, rests, code):
    program = TAKES.format(room=room, rests=rests)
    command = [sys.executable, "-c", BETWEEN, program]
    ended = subprocess.run(command, cwd=FOLDER, capture_output=True, text=True, timeout=20)
    assert (ended.returncode, ended.stdout) == (code, "" if code else "done\n")


@pytest.mark.slow
def test_memory_is_counted_in_bytes():
    before = peak_memory()
    held = b"x" * (300 << 20)
    assert peak_memory() >= min(before + len(held) // 2, len(held))

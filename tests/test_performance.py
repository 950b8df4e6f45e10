"""The benchmarks of performance, in small: that each case runs and is weighed."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
TOLD = {"a": 3, "b": 6, "c": 8, "d": 3, "e": 2, "f": 2, "g": 2, "i": 4}
"""Lines about each case in all tables together."""


@pytest.mark.slow
@pytest.mark.parametrize("letter", TOLD)
def test_each_case_is_timed_and_weighed(letter, tmp_path):
    page = tmp_path / "performance.md"
    words = ("--small", "--repeats", "1", "--only", letter, "--earlier", str(ROOT), "--write", str(page))
    command = [sys.executable, str(ROOT / "benchmarks" / "performance"), *words]
    subprocess.run(command, check=True, cwd=tmp_path, capture_output=True)
    lines = [line for line in page.read_text(encoding="utf-8").splitlines() if line.startswith(f"| ({letter})")]
    assert len(lines) >= TOLD[letter]
    if sys.platform == "linux":
        assert all(" MB" in line for line in lines[-1:])

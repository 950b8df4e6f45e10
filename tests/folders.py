"""Looking at folders, and spoiling the files of a run folder."""

import re
import tomllib
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).parents[1]
SAMPLES = ROOT / "sample_runs"
_KINDS = {
    path.parent.name: tomllib.loads(path.read_text(encoding="utf-8"))["contact"]["kind"]
    for path in sorted(SAMPLES.glob("*/run.toml"))
}
SAMPLE_IDS = [run_id for run_id, kind in _KINDS.items() if kind == "pin-on-disc"]
"""Of the pin-on-disc runs."""
DISC_IDS = [run_id for run_id, kind in _KINDS.items() if kind == "twin-disc"]
"""Of the twin-disc runs."""
DISC_PAIR = ["si3n4-twin-disc-4pct-100k", "si3n4-twin-disc-10pct-1000k-a"]
"""Of a short twin-disc run, and of one that is predicted from it."""
FURTHER_IDS = [run_id for run_id in _KINDS if run_id not in {*SAMPLE_IDS, *DISC_IDS}]
"""Of one run of each further contact."""
ALL_IDS = [*SAMPLE_IDS, *DISC_IDS, *FURTHER_IDS]
"""Of every sample run."""


_PASSED_OVER = {"catalogue.sqlite", "processed.json", ".locks"}
"""What looking and writing make beside the files of an archive."""


def tree_bytes(folder: Path) -> dict[str, bytes]:
    """Give the content of every file of a folder, by its path in it, but for what only saves time, and locks."""
    files = (path for path in sorted(folder.rglob("*")) if path.is_file() and not {*path.parts} & _PASSED_OVER)
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


def set_key(run: Path, key: str, value: str) -> None:
    """Give a key of run.toml another value, where it first stands."""
    replace_in(run / "run.toml", rf"(?m)^{re.escape(key)} = .*$", f"{key} = {value}")


def replace_in(path: Path, pattern: str, text: str) -> None:
    """Replace the first match of a pattern in a text file, which must be there."""
    changed, count = re.subn(pattern, lambda _: text, path.read_text(encoding="utf-8"), count=1)
    assert count == 1, f"{pattern} stands nowhere in {path}"
    path.write_text(changed, encoding="utf-8", newline="\n")


def edit_rows(run: Path, edit: Callable[[list[str]], list[str]]) -> None:
    """Pass the lines of signals.csv through a function."""
    path = run / "signals.csv"
    lines = path.read_text(encoding="ascii").splitlines()
    path.write_text("\n".join(edit(lines)) + "\n", encoding="ascii", newline="\n")

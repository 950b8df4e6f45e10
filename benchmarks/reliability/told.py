"""What the benchmarks of reliability share: how they are asked, and how they tell what they found.

    options = asked(__doc__, points=500).parse_args()
    rows = [Row("files that cannot be read", "0 of 3000", "none", holds=True), …]
    sys.exit(tell("kills", "Killed at random moments", options, rows, "A paragraph of what was done."))

A test calls what makes the rows, with few points, and asserts that all of them hold.
"""

import argparse
import os
import platform
import sys
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tribopipe import __version__

RESULTS = Path(__file__).parents[2] / "docs" / "results"


class Row(NamedTuple):
    """One thing that was looked at."""

    what: str
    """Such as "files that cannot be read"."""
    found: str
    asked: str = ""
    """What has to be found, such as "none"; empty of what is only told."""
    holds: bool = True


def asked(description: str | None, points: int, seed: int = 1) -> argparse.ArgumentParser:
    """Return a parser of what all these benchmarks understand; the first line of the description is the help."""
    parser = argparse.ArgumentParser(description=(description or "").partition("\n")[0])
    parser.add_argument("--points", type=int, default=points, help="how many are tried (%(default)s)")
    parser.add_argument("--seed", type=int, default=seed, help="what chance is drawn from (%(default)s)")
    parser.add_argument("--write", action="store_true", help="write what was found into docs/results")
    return parser


def tell(name: str, title: str, options: argparse.Namespace, rows: Iterable[Row], *paragraphs: str) -> int:
    """Print what was found as Markdown, and write it to docs/results/reliability-NAME.md where that is wanted.

    Return the exit code: 1 where anything does not hold.
    """
    rows = list(rows)
    parts = [f"# {title}", _origin(name), *paragraphs, _table(rows)]
    document = "\n\n".join(parts) + "\n"
    print(document, end="", flush=True)
    if options.write:
        (RESULTS / f"reliability-{name}.md").write_text(document, encoding="utf-8")
    return 0 if all(row.holds for row in rows) else 1


def _origin(name: str) -> str:
    words = [word for word in sys.argv[1:] if word != "--write"]
    if "--kept" in words:  # which only says where a count was interrupted
        del words[(at := words.index("--kept")) : at + 2]
    return "\n".join(
        [
            f"* Command: `{' '.join(['python', f'benchmarks/reliability/{name}.py', *words])}`",
            f"* Date: {datetime.now(UTC):%Y-%m-%d}",
            f"* tribopipe {__version__}, Python {platform.python_version()}, numpy {np.__version__}",
            f"* Machine: {platform.machine()}, {os.cpu_count()} processors, {platform.system()}",
        ]
    )


def _table(rows: Sequence[Row]) -> str:
    held = {True: "yes", False: "NO"}
    cells = [("Quantity", "Result", "Required", "Met")]
    cells += [(row.what, row.found, row.asked, held[row.holds] if row.asked else "") for row in rows]
    widths = [max(len(line[column]) for line in cells) for column in range(4)]
    lines = [[cell.ljust(width) for cell, width in zip(line, widths, strict=True)] for line in cells]
    lines.insert(1, ["-" * width for width in widths])
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)

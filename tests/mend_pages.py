"""Write the numbers that commands print now into the pages that show them: `python tests/mend_pages.py docs/sweep.md`.

Of an output whose words are as the page has them only the numbers, and the widths of columns, are changed; any other
difference is printed and left to a writer, as is the text around. `git diff docs` then lists what has changed.
"""

import os
import re
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import documented_runs
import pytest
from documented import blocks, difference
from folders import ROOT
from test_documented import archived_samples, follow

_DIGITS = r"\d[\d,.]*(?:×10[⁻⁰¹²³⁴-⁹]+)?"
_PART = re.compile(rf"(?P<signed>[+−-]{_DIGITS})|(?P<number>{_DIGITS})|(?P<gap> {{2,}})|(?P<any>─*…)|(?P<rule>─+)")
_LIKE = {"signed": rf"([+−-]{_DIGITS})", "number": rf"([+−-]?{_DIGITS})", "gap": "( {2,})", "rule": "(─+)"}


def mended(shown: tuple[str, ...], printed: str) -> tuple[str, ...] | None:
    """Return what a page shows with the numbers that were printed; none where more than numbers differ."""
    found = "\n".join(line.rstrip() for line in printed.splitlines()).strip("\n")
    text = "\n".join(shown).strip("\n")
    match = re.fullmatch("\n".join(map(_pattern, text.split("\n"))), found)
    if match is None:
        return None
    groups = iter(match.groups())
    return tuple(_PART.sub(lambda part: part[0] if part["any"] else next(groups), text).split("\n"))


def _pattern(line: str) -> str:
    """Return a pattern of lines like this one, whatever their numbers and the widths of their columns."""
    if line.strip() == "…":
        return r"[^\n]*(?:\n[^\n]*)*?"
    pattern, end = "", 0
    for part in _PART.finditer(line):
        like = r"[^\n]*?" if part["any"] else _LIKE[part.lastgroup or ""]
        pattern, end = pattern + re.escape(line[end : part.start()]) + like, part.end()
    return pattern + re.escape(line[end:]) + r"\s*?"


def mend(page: str, archive: Path) -> None:
    """Follow a page as the tests do, and mend the numbers that it shows."""
    path, changes = ROOT / page, []

    def compared(shown: tuple[str, ...], printed: str) -> str:
        wrong = difference(shown, printed)
        numbers = mended(shown, printed) if wrong else None
        if numbers is None:
            return wrong
        changes.append(("\n".join(shown).strip("\n"), "\n".join(numbers)))
        return ""

    with TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as patch:
        for module in ("documented_runs", "test_documented"):
            patch.setattr(f"{module}.difference", compared)
        here = documented_runs.PageFolder(Path(folder), archive)
        try:
            for block in blocks(page):
                here.lay(block.said.get("given", ""))
                follow(block, here)
        except AssertionError as error:
            sys.stdout.write(f"{error}\n")
    text = path.read_text(encoding="utf-8")
    for old, new in changes:
        text = text.replace(old, new, 1)
    path.write_text(text, encoding="utf-8", newline="\n")
    sys.stderr.write(f"{page}: {len(changes)} outputs mended\n")


if __name__ == "__main__":
    os.environ["MPLBACKEND"] = "Agg"
    with TemporaryDirectory() as base:
        where = type("Base", (), {"getbasetemp": staticmethod(lambda: Path(base))})
        samples = archived_samples.__wrapped__(where)
        for name in sys.argv[1:]:
            mend(name, samples)

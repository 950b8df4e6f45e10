"""Problems of runs in short: a line for each, with the runs that have it."""

from collections.abc import Iterable, Sequence
from typing import TypeAlias

from tribopipe.results.finding import Finding
from tribopipe.results.finding_titles import title

Problems: TypeAlias = dict[tuple[str, str], list[str]]
"""Runs by the severity and the code of what was found in them."""


def by_kind(found: Iterable[tuple[str, Finding]]) -> Problems:
    """Return the runs that have each problem, each once."""
    problems: Problems = {}
    for run_id, finding in found:
        ids = problems.setdefault((finding.severity, finding.code), [])
        if run_id not in ids:
            ids.append(run_id)
    return problems


def short_lines(problems: Problems, width: int | None, most: int) -> list[str]:
    """Write problems as lines that fit a width, as many as ``most``; the last one counts those that are left."""
    shown = list(problems.items()) if len(problems) <= most else list(problems.items())[: most - 1]
    lines = [_shortened(f"{severity}: {title(code)}: ", ids, width) for (severity, code), ids in shown]
    if len(shown) < len(problems):
        lines.append(f"and {len(problems) - len(shown)} more: `tribopipe show RUN`, or -v")
    return lines


def _shortened(what: str, ids: Sequence[str], width: int | None) -> str:
    """Name as many runs as fit on a line, and count the others."""
    for named in range(len(ids), 0, -1):
        left = f" and {len(ids) - named} more" if named < len(ids) else ""
        line = f"{what}{', '.join(ids[:named])}{left}"
        if width is None or len(line) <= width:
            return line
    return f"{what}{len(ids)} run{'' if len(ids) == 1 else 's'}"

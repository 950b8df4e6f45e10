"""A sweep done: what is missing of its table is found case by case, and kept as it comes."""

import time
from collections.abc import Iterator, Sequence
from pathlib import Path

from tribopipe.archive.store import Archive
from tribopipe.base.errors import TribopipeError
from tribopipe.base.executor import Crew, as_done
from tribopipe.documents.recipe import Recipe
from tribopipe.documents.sweep import Choices, Sweep
from tribopipe.extras.sweep.cases import FAILED, Case, Ensemble, Row, read_rows, write_rows
from tribopipe.extras.sweep.choices import choices
from tribopipe.extras.sweep.predictions import predictions
from tribopipe.extras.sweep.virtual_tests import virtual_tests

_LEAST_PAUSE = 2.0
"""Between two writings of the table, s."""
_SHARE = 20
"""Pauses last at least so many times as long as writing takes."""


def ensemble(sweep: Sweep, path: Path, archive: Path, recipe: Recipe) -> Ensemble:
    """Return all cases of the sweep that a document at ``path`` asks for.

    Raises ``TribopipeError`` where a key or value is wrong, or a run is not there.
    """
    where = str(path)
    if sweep.virtual_tests is not None:
        return virtual_tests(sweep, sweep.virtual_tests, path.parent, recipe, where)
    if sweep.predictions is not None:
        return predictions(sweep, sweep.predictions, path.parent, Archive(archive), recipe, where)
    return choices(sweep, sweep.choices or Choices(), Archive(archive), recipe, where)


class Table:
    """The rows of a sweep as they are found, and the file that keeps them, if any."""

    def __init__(self, ensemble: Ensemble, cases: Sequence[Case], path: Path | None = None) -> None:
        """Begin the table of an ensemble, of which these cases are to be done here."""
        self.ensemble, self.cases, self.path = ensemble, cases, path
        self.rows: dict[str, list[Row]] = {}
        self._pause_ends = 0.0

    def reuse(self, path: Path) -> int:
        """Take rows over from a file; return of how many cases it has rows that are not of this sweep as it is now.

        Raises ``ManifestError`` where it is no table of such a sweep.
        """
        found, wanted = read_rows(path, self.ensemble), {case.fingerprint for case in self.ensemble.cases}
        self.rows |= {fingerprint: rows for fingerprint, rows in found.items() if fingerprint in wanted}
        return len(found.keys() - wanted)

    @property
    def missing(self) -> list[Case]:
        """Cases without rows."""
        return [case for case in self.cases if case.fingerprint not in self.rows]

    @property
    def has_answers(self) -> bool:
        """True if at least one case was completed without error."""
        return any(row.outcome != FAILED for rows in self.rows.values() for row in rows)

    def fill(self, crew: Crew) -> Iterator[tuple[Case, TribopipeError | None]]:
        """Do what is missing; give each case as it ends, with the error where it failed.

        The file is written at once, which shows whether it can be, now and then, and at the end.
        """
        self._keep()
        try:
            for case, answer in as_done(find, self.missing, crew):
                error = answer if isinstance(answer, TribopipeError) else None
                rows = [Row("", FAILED, {}, str(error))] if isinstance(answer, TribopipeError) else answer
                self.rows[case.fingerprint] = rows
                self._keep()
                yield case, error
        finally:
            self._pause_ends = 0.0
            self._keep()

    def _keep(self) -> None:
        begun = time.monotonic()
        if self.path is not None and begun >= self._pause_ends:
            write_rows(self.path, self.ensemble, self.rows)
            ended = time.monotonic()
            self._pause_ends = ended + max(_LEAST_PAUSE, _SHARE * (ended - begun))


def find(case: Case) -> list[Row]:
    """Do one case, wherever that is."""
    return case.job()

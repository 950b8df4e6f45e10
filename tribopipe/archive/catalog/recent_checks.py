"""Slow checks that need not be repeated yet: when they were last made, on what, and how long they took.

Only a check that took long is noted, so that a small archive is checked every time. A check is repeated once what was
checked looks different, and in any case when 100 times its duration has passed: at most 1 % of the time is spent on it.
The notes are kept with the locks, since a new file there does not change the time of the folder above it.
"""

import os
import time
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from tribopipe.archive.lock import LOCKS
from tribopipe.base.files import write_file

_LONG = 0.1
"""Duration above which a check is noted, s."""
_SHARE = 100.0
"""How many times its duration a check is valid."""


class Check(NamedTuple):
    """A check that found nothing wrong."""

    state: str
    """Stamp of what was checked."""
    at: float
    """When it was made, s since 1970."""
    took: float
    """Its duration, s."""

    def is_valid_for(self, state: str) -> bool:
        """Return whether the check need not be repeated for what bears a stamp now."""
        age = time.time() - self.at
        return self.took > _LONG and self.state == state and 0 <= age < _SHARE * self.took


class CheckNote:
    """The last check of one kind, as all processes that use the archive know it."""

    def __init__(self, archive: Path, name: str) -> None:
        self._archive, self._name = archive, name

    @property
    def _path(self) -> Path:
        return Path(os.fspath(self._archive), LOCKS, f"{self._name}.checked")

    def valid_for(self, state: str) -> Check | None:
        """Return the check that need not be repeated; none where it must be."""
        try:
            at, took, checked = self._path.read_text("utf-8").split(" ", 2)
            check = Check(checked, float(at), float(took))
        except (OSError, ValueError):
            return None
        return check if check.is_valid_for(state) else None

    def keep(self, check: Check) -> None:
        """Note a check if it took long and the folder can be written; it helps, so that nothing fails without it."""
        if check.took > _LONG:
            with suppress(OSError):
                path = self._path
                path.parent.mkdir(exist_ok=True)
                write_file(path, f"{check.at!r} {check.took!r} {check.state}".encode())

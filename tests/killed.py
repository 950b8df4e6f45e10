"""A process that ends all of a sudden, as when somebody kills it or the power fails."""

import os
from collections.abc import Iterable
from pathlib import Path

import pytest


class Killed(BaseException):
    """The end of a process, after which nothing is tidied up."""


def dying_at(patch: pytest.MonkeyPatch, moment: int, also: Iterable[tuple[object, str]] = ()) -> None:
    """Let the process end at a moment: as files are put on the disk and given their name, or at other calls."""
    calls = iter(range(moment))

    def ending(function):
        def until_then(*arguments, **named):
            if next(calls, None) is None:
                raise Killed
            return function(*arguments, **named)

        return until_then

    for owner, name in ((os, "fsync"), (Path, "replace"), (Path, "chmod"), *also):
        patch.setattr(owner, name, ending(getattr(owner, name)))
    patch.setattr(Path, "unlink", lambda *_, **__: None)

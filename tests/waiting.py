"""Tests wait for what happens, not for a time that a busy machine may exceed."""

import time
from collections.abc import Callable

LONGEST = 30.0
"""s."""


def wait_until(holds: Callable[[], object]) -> None:
    """Wait until something holds; fail where it never does."""
    latest = time.monotonic() + LONGEST
    while not holds():
        assert time.monotonic() < latest
        time.sleep(0.01)

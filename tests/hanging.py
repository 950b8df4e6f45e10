"""A guard against work without end; how fast something is, is measured in benchmarks/."""

import time
from collections.abc import Iterator
from contextlib import contextmanager

_LONGEST_SECONDS = 60.0
"""What takes milliseconds where it is bounded stays far below it on any machine; what is not bounded does not."""


@contextmanager
def ends_soon() -> Iterator[None]:
    """Fail where somebody would think that the program hangs."""
    start = time.monotonic()
    yield
    assert time.monotonic() - start < _LONGEST_SECONDS

"""What processes take from the environment they start in."""

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

ONE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "VECLIB_MAXIMUM_THREADS": "1",
}
"""One thread for linear algebra, read as it is loaded: with more of them sums come out other in their last bits."""


@contextmanager
def inherited(variables: Mapping[str, str]) -> Iterator[None]:
    """Have processes that begin meanwhile find these variables; for this one they are afterwards as they were."""
    before = {name: os.environ[name] for name in variables if name in os.environ}
    os.environ.update(variables)
    try:
        yield
    finally:
        for name in variables:
            del os.environ[name]
        os.environ.update(before)

"""Terms of a depth reading besides wear whose shape is known: offsets, a line, settling, temperature, a counterbody.

Offsets and the rate of the line have flat priors; a settling or a thermal term is one alternative among several, with a
normal prior of its amplitude about zero, and is averaged over by its evidence.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tribopipe.run import Column

SETTLING_TIMES = (0.04, 0.06, 0.09, 0.13, 0.19, 0.28, 0.4, 0.6)
"""Time constants of an exponential settling, as shares of the test."""
AMPLITUDES = (0.03, 0.15, 0.6)
"""Standard deviations of the amplitude of a term, as shares of the wear at the end."""
_LEAST_WARMING = 0.05
"""Standard deviation of a recorded temperature, K, below which nothing follows from it."""


@dataclass(frozen=True)
class Alternative:
    """Terms that a reading may have besides the line, with the prior of their amplitudes."""

    name: str
    """"none", "settling" or "temperature"."""
    columns: tuple[int, ...]
    """Which of the optional columns."""
    deviation: float
    """Prior standard deviation of each amplitude, as a share of the wear at the end."""
    probability: float
    """Prior probability."""


@dataclass(frozen=True)
class OptionalTerms:
    """Columns of optional terms at each block, of amplitude one, and their alternatives."""

    columns: Column
    """Shape (blocks, terms)."""
    alternatives: tuple[Alternative, ...]
    time_constants: tuple[float | None, ...]
    """Of each column: of settling, as a share of the test; none of temperature."""


def settling(time: Column, constant: float) -> Column:
    """Return 1 − exp(−t/τ) from the first sample on, with t and τ as shares of the test."""
    return np.asarray(-np.expm1(-(time - time[0]) / constant))


def optional_terms(time: Column, temperature: Column | None) -> OptionalTerms:
    """Return the optional terms of a reading.

    Parameters
    ----------
    time
        Mean time of each block as a share of the test, shape (blocks,).
    temperature
        Mean temperature of each block, K; none where it was not recorded or did not move.

    Returns
    -------
    OptionalTerms
        Settling with each time constant, temperature, each alone with each prior amplitude, and none of them.
    """
    columns, constants = [settling(time, constant) for constant in SETTLING_TIMES], [*SETTLING_TIMES]
    warming = temperature is not None and float(np.std(temperature)) > _LEAST_WARMING
    if temperature is not None and warming:
        columns.append((temperature - temperature[0]) / float(np.ptp(temperature)))
    found = (*_alternatives(len(SETTLING_TIMES), warming=warming),)
    return OptionalTerms(np.column_stack(columns), found, (*constants, *([None] if warming else [])))


def _alternatives(settlings: int, *, warming: bool) -> Iterator[Alternative]:
    share = 0.5 / (1 + warming)
    yield Alternative("none", (), 0.0, 0.5)
    for deviation in AMPLITUDES:
        each = share / len(AMPLITUDES)
        for place in range(settlings):
            yield Alternative("settling", (place,), deviation, each / settlings)
        if warming:
            yield Alternative("temperature", (settlings,), deviation, each)

"""A check of the room temperature, because the machine and the depth sensor expand with it."""

from collections.abc import Iterator

import numpy as np

from tribopipe.evaluation.checks.registry import Trouble, check
from tribopipe.results.run import RawRun

MAX_CHANGE = 5.0
"""Largest change in temperature without a warning, K."""


@check("warning")
def room_temperature(run: RawRun) -> Iterator[Trouble]:
    """Warn if the temperature changes by more than 5 K."""
    temperature = run.columns.get("temperature")
    if temperature is None:
        return
    change = float(np.nanmax(temperature) - np.nanmin(temperature))
    if change > MAX_CHANGE:
        yield Trouble(
            "temperature",
            f"found a change of {change:.1f} K; expected at most {MAX_CHANGE:g} K",
            "check for thermal drift, and keep the room temperature constant",
        )

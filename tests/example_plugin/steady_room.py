"""A check: whether the room stayed as warm as it was, since steel and the depth sensor grow with it."""

from collections.abc import Iterator

import numpy as np

from tribopipe.evaluation.checks.registry import Trouble, check
from tribopipe.results.run import RawRun

MOST = 5.0
"""K."""


@check("warning")
def room_stays_as_warm(run: RawRun) -> Iterator[Trouble]:
    """Warn of a temperature that moves by more than 5 K."""
    temperature = run.columns.get("temperature")
    if temperature is not None and np.nanmax(temperature) - np.nanmin(temperature) > MOST:
        moved = float(np.nanmax(temperature) - np.nanmin(temperature))
        yield Trouble(
            "temperature",
            f"found that it moves by {moved:.1f} K; expected at most {MOST:g} K",
            "look for drift that follows it, and keep the room steady",
        )

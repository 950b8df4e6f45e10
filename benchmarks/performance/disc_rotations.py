"""(e) 10⁸ rotations of two discs, compared with the published scheme, which takes one step per rotation."""

import time
from collections.abc import Iterator

import numpy as np
from case import Pair, Row, Setting
from twin_disc import CURVED, FLAT, MANY_ROTATIONS, PUBLISHED, discs

from tribopipe.physics.twin_disc import published_wear

_PLACES = 101


def rows(setting: Setting) -> Iterator[Row]:
    """Yield the pair."""
    steps = setting.of(100_000, small=1000)
    yield Pair(
        f"two discs, 10⁸ rotations, {_PLACES} points",
        lambda: discs(PUBLISHED).worn(np.linspace(0.0, MANY_ROTATIONS, _PLACES), CURVED, FLAT),
        lambda: published_wear(discs(PUBLISHED), np.ones(steps), CURVED, FLAT),
        f"one step of the published scheme per rotation; extrapolated from {steps:,} steps",
        scaled=MANY_ROTATIONS / steps,
        clock=time.process_time,
    )

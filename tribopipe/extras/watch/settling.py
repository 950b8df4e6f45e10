"""When what was dropped has settled: nobody has written to it for a while."""

import math
from collections.abc import Iterable
from pathlib import Path

from tribopipe.extras.watch.drops import Drop


class Settling:
    """What was seen to change last when. It uses the clock it is given, never by those of drives and shares."""

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds
        self._seen: dict[tuple[Path, ...], tuple[str, float]] = {}

    def settled(self, drops: Iterable[Drop], now: float) -> list[Drop]:
        """Return the drops that have not changed for the settling time, and forget those that are gone."""
        drops = list(drops)
        self._seen = {drop.files: (drop.stamp, self._since(drop, now)) for drop in drops}
        return [drop for drop in drops if now - self._seen[drop.files][1] >= self.seconds]

    def forget(self, drop: Drop) -> None:
        """Remove a drop that was processed."""
        self._seen.pop(drop.files, None)

    @property
    def next(self) -> float:
        """When the next one may have settled, by the same clock; infinite where there is none."""
        return min((since + self.seconds for _, since in self._seen.values()), default=math.inf)

    def __len__(self) -> int:
        return len(self._seen)

    def _since(self, drop: Drop, now: float) -> float:
        stamp, since = self._seen.get(drop.files, ("", now))
        return since if stamp == drop.stamp else now

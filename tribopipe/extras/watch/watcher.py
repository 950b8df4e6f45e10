"""The watch: whenever it looks, what has settled is made into runs, and these are processed.

A look is taken when something in the folder may have changed, as the system shows, or by asking again and again. What
was dropped has settled when nobody has written to it for a while.
"""

import math
from collections.abc import Iterable, Iterator
from pathlib import Path
from time import monotonic, sleep

from tribopipe.extras.watch.drops import Drop, drops, is_held
from tribopipe.extras.watch.journal import Event, Journal
from tribopipe.extras.watch.lab import Lab
from tribopipe.extras.watch.processing import changed, processed, take, try_again

_TICK = 1000
"""Interval between checks whether a scan is due although nothing changed, ms."""
_QUIET, _LONGEST = 500, 2000
"""Changes are reported once there was none for so long, or that long after the first, ms."""
_POLL_EVERY = 2000
"""Polling interval of a network share, ms."""


def changes(folder: Path, *, poll: bool) -> Iterator[bool]:
    """Yield, at least each second and for ever, whether anything below a folder has changed.

    With ``poll`` the folder is listed again and again, since changes by other machines on a share are not reported.
    """
    from watchfiles import watch

    for found in watch(
        folder,
        watch_filter=None,
        debounce=_LONGEST,
        step=_QUIET,
        rust_timeout=_TICK,
        yield_on_timeout=True,
        force_polling=poll or None,  # as the library knows best
        poll_delay_ms=_POLL_EVERY,
        ignore_permission_denied=True,
    ):
        yield bool(found)


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


_AT_ONCE = 32
"""Drops made into runs before these are processed."""
_LOOK_EVERY = 30.0
"""Longest time between scans without a reported change, s."""


def watched(lab: Lab, *, poll: bool) -> Iterator[Event]:
    """Watch for ever. With ``poll`` the folder is listed again and again, as network shares need it."""
    watcher = Watcher(lab)
    yield from watcher.look(monotonic())
    for changed_now in changes(lab.folder, poll=poll):
        if changed_now or watcher.is_due(monotonic()):
            yield from watcher.look(monotonic())


def look_once(lab: Lab) -> Iterator[Event]:
    """Deal with what is there; what is still written is left for the next time."""
    watcher = Watcher(lab)
    yield from watcher.look(monotonic())
    if watcher.unsettled:
        sleep(lab.settle)
        yield from watcher.look(monotonic())


class Watcher:
    """Looks into a lab's folder when requested, and remembers what it did."""

    def __init__(self, lab: Lab) -> None:
        self._lab = lab
        self._journal = Journal(lab.runs)
        self._dropped, self._mended = Settling(lab.settle), Settling(lab.settle)
        self._next = 0.0
        self._gone = False

    @property
    def unsettled(self) -> int:
        """How many drops are there that may still be written."""
        return len(self._dropped)

    def is_due(self, now: float) -> bool:
        """Return whether a look is worth its while though nothing shows a change."""
        return now >= self._next

    def look(self, now: float) -> Iterator[Event]:
        """Deal with what has settled by a time, s, of a clock that never goes back; yield what happens."""
        for run in self._mended.settled(changed(self._lab, self._journal), now):
            try_again(run, self._journal)
        there = self._there()
        yield from self._came_or_went(there is None)
        settled = [drop for drop in self._dropped.settled(there or (), now) if not is_held(drop.files)]
        yield from processed(self._lab, self._journal)
        for at in range(0, len(settled), _AT_ONCE):
            for drop in settled[at : at + _AT_ONCE]:
                self._dropped.forget(drop)
                yield from take(drop, self._lab, self._journal)
            yield from processed(self._lab, self._journal)
        self._next = min(self._dropped.next, self._mended.next, now + _LOOK_EVERY)

    def _there(self) -> list[Drop] | None:
        """Return the drops that were not dealt with; None if the folder cannot be seen now."""
        try:
            there = drops(self._lab.folder, together=self._lab.together, without={self._lab.runs, self._lab.archive})
        except OSError:
            return None
        return [drop for drop in there if not self._journal.knows(drop)]

    def _came_or_went(self, gone: bool) -> Iterator[Event]:
        if gone and not self._gone:
            waits = "not available; expected a connected folder; reconnect its drive or network share to continue"
            yield Event("gone", f"{self._lab.folder}: {waits}")
        if self._gone and not gone:
            yield Event("back", f"{self._lab.folder}: available again")
        self._gone = gone

"""The watch: whenever it looks, what has settled is made into runs, and these are processed."""

from collections.abc import Iterator
from time import monotonic, sleep

from tribopipe.extras.watch.changes import changes
from tribopipe.extras.watch.drafting import take
from tribopipe.extras.watch.drops import Drop, drops, is_held
from tribopipe.extras.watch.event import Event
from tribopipe.extras.watch.journal import Journal
from tribopipe.extras.watch.lab import Lab
from tribopipe.extras.watch.processing import changed, processed, try_again
from tribopipe.extras.watch.settling import Settling

_AT_ONCE = 32
"""Drops made into runs before these are processed."""
_LOOK_EVERY = 30.0
"""How long no look is taken where nothing shows a change, s."""


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
        """Return the drops that were not dealt with; none where the folder cannot be seen now."""
        try:
            there = drops(self._lab.folder, together=self._lab.together, without={self._lab.runs, self._lab.archive})
        except OSError:
            return None
        return [drop for drop in there if not self._journal.knows(drop)]

    def _came_or_went(self, gone: bool) -> Iterator[Event]:
        if gone and not self._gone:
            waits = "cannot be seen now; expected it to stay; connect its drive or share, which is waited for"
            yield Event("gone", f"{self._lab.folder}: {waits}")
        if self._gone and not gone:
            yield Event("back", f"{self._lab.folder}: there again")
        self._gone = gone

"""Limits for clients: how long the server waits for one, and how many it serves; an idle client keeps no place.

uvicorn bounds none of these. Times are by the clock of the event loop.
"""

import asyncio
import sys
from math import inf
from operator import attrgetter

from uvicorn.protocols.http.h11_impl import H11Protocol, RequestResponseCycle

_REQUEST_WITHIN = 10.0
"""How long a client may take to state what it wants, s."""
_TAKEN_WITHIN = 30.0
"""How long it may take nothing of an answer, s."""
_MOST = 600
"""Connections, where the system allows twice as many open files."""
_WITHOUT_LIMIT = 400


class PatientProtocol(H11Protocol):
    """One connection, closed where its client keeps it waiting; of too many, the longest without a request goes."""

    _asking: asyncio.TimerHandle | None = None
    _taking: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Begin to wait for a request, in the place of the longest wait where there are too many."""
        super().connection_made(transport)
        self._asking = self.loop.call_later(_REQUEST_WITHIN, transport.abort)
        if len(self.connections) > most_connections():
            ours = [one for one in self.connections if isinstance(one, PatientProtocol)]
            min(ours, key=attrgetter("until")).give_way()

    def data_received(self, data: bytes) -> None:
        """Wait no more once a request is whole; of the next one, wait again."""
        super().data_received(data)
        if self._is_answering():
            _end(self._asking)
            self._asking = None
        elif self._asking is None:
            self._asking = self.loop.call_later(_REQUEST_WITHIN, self.transport.abort)

    def pause_writing(self) -> None:
        """Begin to wait for the client to take what was sent."""
        super().pause_writing()
        self._taking = self.loop.call_later(_TAKEN_WITHIN, self.transport.abort)

    def resume_writing(self) -> None:
        """Wait no more: it took something."""
        super().resume_writing()
        _end(self._taking)

    def connection_lost(self, exc: Exception | None) -> None:
        """Wait for nothing any more."""
        _end(self._asking)
        _end(self._taking)
        super().connection_lost(exc)

    def give_way(self) -> None:
        """Close before a request has come."""
        _end(self._asking)
        self._asking = None
        self.transport.abort()

    def _is_answering(self) -> bool:
        cycle: RequestResponseCycle | None = self.cycle
        return cycle is not None and not cycle.response_complete

    @property
    def until(self) -> float:
        """When it is closed unless a request comes; never where there is one."""
        return inf if self._asking is None else self._asking.when()


def _end(timer: asyncio.TimerHandle | None) -> None:
    if timer is not None:
        timer.cancel()


def most_connections() -> int:
    """Return how many connections there may be, with room left for as many open files."""
    if sys.platform == "win32":
        return _WITHOUT_LIMIT
    import resource

    open_files, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    return _MOST if open_files == resource.RLIM_INFINITY else max(16, min(_MOST, open_files // 2))

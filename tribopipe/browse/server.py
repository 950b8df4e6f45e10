"""The server of one person's browser: on this machine alone, at a port of its own, with limits for clients.

uvicorn bounds neither how long it waits for a client nor how many it serves; an idle client keeps no place. Times are
by the clock of the event loop.
"""

import asyncio
import socket
import sys
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from math import inf
from operator import attrgetter
from pathlib import Path
from threading import Thread
from threading import enumerate as enumerate_threads

import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol, RequestResponseCycle

from tribopipe.archive.catalog.query import Asked
from tribopipe.base.errors import ArchiveError
from tribopipe.base.units import show
from tribopipe.browse.app import create_app
from tribopipe.browse.guard import Key
from tribopipe.browse.library import FIRST_ROWS, Library

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
            _end_connection(self._asking)
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
        _end_connection(self._taking)

    def connection_lost(self, exc: Exception | None) -> None:
        """Wait for nothing any more."""
        _end_connection(self._asking)
        _end_connection(self._taking)
        super().connection_lost(exc)

    def give_way(self) -> None:
        """Close before a request has come."""
        _end_connection(self._asking)
        self._asking = None
        self.transport.abort()

    def _is_answering(self) -> bool:
        cycle: RequestResponseCycle | None = self.cycle
        return cycle is not None and not cycle.response_complete

    @property
    def until(self) -> float:
        """When it is closed unless a request comes; never where there is one."""
        return inf if self._asking is None else self._asking.when()


def _end_connection(timer: asyncio.TimerHandle | None) -> None:
    if timer is not None:
        timer.cancel()


def most_connections() -> int:
    """Return how many connections there may be, with room left for as many open files."""
    if sys.platform == "win32":
        return _WITHOUT_LIMIT
    import resource

    open_files, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    return _MOST if open_files == resource.RLIM_INFINITY else max(16, min(_MOST, open_files // 2))


HOST = "127.0.0.1"
_ACCEPTED_AT_ONCE = 64
"""Connections, before any of them is looked at: all at once would take more open files than there may be."""
_PATIENCE = 2
"""How long answers under way may take after Ctrl-C, s."""


@dataclass(frozen=True)
class Site:
    """Where a server listens, and what it wants to see."""

    port: int
    key: Key

    def address(self, path: str = "/") -> str:
        """Return the address of a page, with the key."""
        return self.key.address(f"http://{HOST}:{self.port}{path}")

    @property
    def headers(self) -> dict[str, str]:
        """What a client that is no browser has to send."""
        return {"Cookie": self.key.cookie(self.port)}


def serve(archive: Path, port: int, tell: Callable[[str], None], *, open_browser: bool) -> None:
    """Serve an archive until Ctrl-C, at a free port where ``port`` is 0; give the address, and show it in the browser.

    Raises ``ArchiveError`` where the port is taken.
    """
    with listening(port) as listener:
        site = Site(listener.getsockname()[1], Key())
        others = set(enumerate_threads())
        # Nothing is told before all is there: Ctrl-C while modules are being imported would leave them half imported.
        with suppress(KeyboardInterrupt), _ready(archive, site.key) as server:
            tell(site.address())
            if open_browser:
                once = site.key.address_for_once(f"http://{HOST}:{site.port}/")
                browser = Thread(target=webbrowser.open, args=[once], daemon=True)
                browser.start()
                others.add(browser)
            server.run(sockets=[listener])
        for worker in set(enumerate_threads()) - others:
            worker.join(_PATIENCE)  # Python cannot end while another thread is inside the HDF5 library


@contextmanager
def running(archive: Path) -> Iterator[Site]:
    """Serve an archive in a thread meanwhile."""
    key = Key()
    with listening(0) as listener, _ready(archive, key) as server:
        thread = Thread(target=server.run, kwargs={"sockets": [listener]}, daemon=True)
        thread.start()
        try:
            yield Site(listener.getsockname()[1], key)
        finally:
            server.should_exit = True
            thread.join()


@contextmanager
def _ready(archive: Path, key: Key) -> Iterator[uvicorn.Server]:
    """Yield a server whose library reads ahead while it runs."""
    app = create_app(archive, key)
    app.state.library.aside.submit(_get_ready, app.state.library)
    config = uvicorn.Config(
        app,
        log_level="critical",
        lifespan="off",
        http=PatientProtocol,
        backlog=_ACCEPTED_AT_ONCE,
        ws="none",
        server_header=False,
        timeout_graceful_shutdown=_PATIENCE,
    )
    try:
        yield uvicorn.Server(config)
    finally:
        app.state.library.aside.shutdown(wait=False, cancel_futures=True)


def _get_ready(library: Library) -> None:
    """Read while the browser opens what is asked for first: the table of all runs, and the units of measurement."""
    show(1.0, None, "m", "um")
    library.runs(Asked(), most=FIRST_ROWS)


def listening(port: int) -> socket.socket:
    """Return a socket at a port that nobody else has. Raises ``ArchiveError`` where it is taken."""
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        if hasattr(socket, "SO_EXCLUSIVEADDRUSE"):  # on Windows others could share it otherwise
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_EXCLUSIVEADDRUSE, 1)
        listener.bind((HOST, port))
        listener.listen()
    except OSError as error:
        listener.close()
        raise ArchiveError(
            f"--port {port}: cannot be used ({error.strerror or error}); expected a free port; omit --port to use any "
            "free port"
        ) from None
    return listener

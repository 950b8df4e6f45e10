"""A web server of one folder, as a lab may run it: files with range requests, and a delay and faults on demand.

Python's own server knows no ranges. This one counts what it is asked and what it sends, and takes nothing in.
"""

import re
import time
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Event, Thread
from typing import Literal, NamedTuple

_RANGE = re.compile(r"bytes=(\d*)-(\d*)")

Fault = Literal["refused", "silent", "cut"]
"""Status 403, no answer at all, or the connection ends after half the bytes."""


class Request(NamedTuple):
    """What was asked, and what was sent."""

    method: str
    name: str
    status: int
    sent: int
    """Bytes of the content."""


class RangeServer(ThreadingHTTPServer):
    """A server of a folder at a port of its own."""

    daemon_threads = True

    def __init__(self, folder: Path, delay: float = 0.0, *, ranges: bool = True) -> None:
        super().__init__(("127.0.0.1", 0), _Handler)
        self.folder, self.delay, self.ranges = folder, delay, ranges
        self.faults: dict[str, Fault] = {}
        self.requests: list[Request] = []
        self.closing = Event()

    @property
    def address(self) -> str:
        """Address of the folder."""
        return f"http://127.0.0.1:{self.server_port}"

    @property
    def sent(self) -> int:
        """Bytes of content sent so far."""
        return sum(request.sent for request in self.requests)


@contextmanager
def serving(folder: Path, delay: float = 0.0, *, ranges: bool = True) -> Iterator[RangeServer]:
    """Serve a folder meanwhile; ``delay`` is what each request takes before its answer begins, s."""
    with RangeServer(folder, delay, ranges=ranges) as server:
        thread = Thread(target=server.serve_forever, args=(0.01,), daemon=True)
        thread.start()
        try:
            yield server
        finally:
            server.closing.set()
            server.shutdown()
            thread.join()


class _Handler(BaseHTTPRequestHandler):
    server: RangeServer
    protocol_version = "HTTP/1.1"

    def do_GET(self) -> None:
        self._answer(with_content=True)

    def do_HEAD(self) -> None:
        self._answer(with_content=False)

    def log_message(self, *_: object) -> None:
        """Print nothing."""

    def send_error(self, code: int, message: str | None = None, explain: str | None = None) -> None:
        """Answer what fails, methods that write among it, and count it."""
        self._count(code, 0)
        super().send_error(code, message, explain)

    def _answer(self, *, with_content: bool) -> None:
        time.sleep(self.server.delay)
        name = self.path.strip("/")
        fault, path = self.server.faults.get(name), self.server.folder / name
        if fault == "silent":
            self.server.closing.wait()
            self.close_connection = True
        elif fault == "refused":
            self.send_error(403)
        elif not path.is_file():
            self.send_error(404)
        elif self.headers.get("If-Match", _version(path)) != _version(path):
            self.send_error(412)
        else:
            self._send(path, with_content=with_content, is_cut=fault == "cut")

    def _send(self, path: Path, *, with_content: bool, is_cut: bool) -> None:
        size = path.stat().st_size
        start, end = self._range(size)
        status = 206 if self.server.ranges and "Range" in self.headers else 200
        self.send_response(status)
        self.send_header("Content-Length", str(end - start))
        self.send_header("ETag", _version(path))
        if self.server.ranges:
            self.send_header("Accept-Ranges", "bytes")
        if status == 206:
            self.send_header("Content-Range", f"bytes {start}-{end - 1}/{size}")
        self.end_headers()
        if with_content:
            count = (end - start) // 2 if is_cut else end - start
            self._count(status, count)
            with path.open("rb") as file:
                file.seek(start)
                self.wfile.write(file.read(count))
            self.close_connection |= is_cut
        else:
            self._count(status, 0)

    def _range(self, size: int) -> tuple[int, int]:
        """Return the first byte that is wanted, and the one after the last."""
        found = _RANGE.fullmatch(self.headers.get("Range", "")) if self.server.ranges else None
        if found is None:
            return 0, size
        if not found[1]:
            return max(size - int(found[2]), 0), size
        return min(int(found[1]), size), min(int(found[2]) + 1, size) if found[2] else size

    def _count(self, status: int, sent: int) -> None:
        self.server.requests.append(Request(self.command, self.path.strip("/"), status, sent))


def _version(path: Path) -> str:
    seen = path.stat()
    return f'"{seen.st_size:x}-{seen.st_mtime_ns:x}"'

"""`tribopipe browse` under load: many downloads, reports whose readers leave, and requests that nobody ends.

    python benchmarks/reliability/browse_load.py

A server of its own process gets, over the loopback interface alone: 500 downloads of a run of 2 MB at once, whose
clients read nothing at first; 60 reports, whose clients leave after a second; 1100 connections with half a request.
Memory is the peak of the server, idle is what it computes from 5 s after the clients left. Linux only (/proc).
"""

import os
import re
import resource
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from http.client import HTTPConnection
from pathlib import Path
from typing import IO, NamedTuple

from short_runs import quick_recipe, short_runs
from told import Row, asked, tell

from tribopipe.archive.store import Archive
from tribopipe.documents.recipe import Recipe
from tribopipe.documents.record import load_toml
from tribopipe.pipeline.stages import process

RUN, HOST = "run-000", "127.0.0.1"
DOWNLOADS, REPORTS, HALF_OPEN = 500, 60, 1100
MEGABYTES, IDLE = 300.0, 0.2
"""Marks: peak of memory, MB, and seconds of work in the five that begin 5 s after the clients left."""
_TIMES = 100
"""How much longer than a short run is the one that is downloaded."""


class Server(NamedTuple):
    """A server at work."""

    number: int
    port: int
    cookie: str
    said: IO[str]

    def request(self, target: str) -> bytes:
        """Return a request as its page sends it."""
        lines = [f"GET {target} HTTP/1.1", f"Host: {HOST}:{self.port}", f"Cookie: {self.cookie}", "", ""]
        return "\r\n".join(lines).encode()

    def seconds(self) -> float:
        """Return how long it has computed, s."""
        fields = Path(f"/proc/{self.number}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
        return sum(map(int, fields[11:13])) / os.sysconf("SC_CLK_TCK")

    def peak(self) -> float:
        """Return the most memory that it had so far, MB."""
        status = Path(f"/proc/{self.number}/status").read_text(encoding="ascii")
        return int(re.findall(r"VmHWM:\s+(\d+)", status)[0]) / 1000

    def answers_within(self) -> float:
        """Return how long it takes to say which revision the archive has, s."""
        start = time.monotonic()
        connection = HTTPConnection(HOST, self.port, timeout=60)
        connection.request("GET", "/api/revision", headers={"Cookie": self.cookie})
        if connection.getresponse().status != 200:
            raise RuntimeError("no answer")
        connection.close()
        return time.monotonic() - start


@contextmanager
def served(archive: Path, said: Path) -> Iterator[Server]:
    """Serve an archive in a process of its own."""
    words = [sys.executable, "-m", "tribopipe", "browse", "--archive", str(archive), "--no-browser"]
    with said.open("w", encoding="utf-8") as told:
        running = subprocess.Popen(words, stderr=told, stdout=told)
    few, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))  # of the clients, in this process
    try:
        while not (found := re.search(r":(\d+)/\?key=([\w-]{22})", said.read_text(encoding="utf-8"))):
            time.sleep(0.1)
        with said.open(encoding="utf-8") as lines:
            yield Server(running.pid, int(found[1]), f"tribopipe-{found[1]}={found[2]}", lines)
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (few, most))
        running.terminate()
        running.wait(20)


def connected(server: Server, sent: bytes, count: int, held: ExitStack) -> list[socket.socket]:
    """Open connections, and send the same on each."""
    made = []
    for _ in range(count):
        made.append(held.enter_context(socket.create_connection((HOST, server.port), timeout=120)))
        made[-1].sendall(sent)
    return made


def downloads(server: Server, size: int) -> list[Row]:
    """Ask for so many files before the first is read."""
    with ExitStack() as held:
        clients = connected(server, server.request(f"/api/runs/{RUN}/file"), DOWNLOADS, held)
        time.sleep(2.0)
        others = server.answers_within()
        whole = sum(_length(client) > size for client in clients)
    peak = server.peak()
    return [
        Row(f"complete downloads of {size / 1e6:.2g} MB, simultaneous", str(whole), str(DOWNLOADS), whole == DOWNLOADS),
        Row("peak memory of the server", f"{peak:.0f} MB", f"< {MEGABYTES:.0f} MB", peak < MEGABYTES),
        Row("response time of another request", f"{others:.2f} s"),
    ]


def _length(client: socket.socket) -> int:
    """Read an answer to its end; return how long it is with its head."""
    length, wanted, head = 0, -1, b""
    while length != wanted:
        piece = client.recv(1 << 20)
        if not piece:
            break
        length += len(piece)
        if wanted < 0:
            head += piece
            if (end := head.find(b"\r\n\r\n")) >= 0:
                said = re.search(rb"content-length: (\d+)", head[:end], re.IGNORECASE)
                wanted = end + 4 + int(said[1]) if said else -2
    return length


def idle_after(server: Server) -> Row:
    """Wait for 5 s, and return what the server computes in the next five."""
    time.sleep(5.0)
    start = server.seconds()
    time.sleep(5.0)
    busy = server.seconds() - start
    return Row("CPU time in 5 s, starting 5 s after the disconnection", f"{busy:.2f} s", f"< {IDLE:g} s", busy < IDLE)


def reports(server: Server) -> list[Row]:
    """Ask for reports, and leave."""
    with ExitStack() as held:
        connected(server, server.request(f"/api/runs/{RUN}/report"), REPORTS, held)
        time.sleep(1.0)
    idle = idle_after(server)
    peak = server.peak()
    return [
        Row("reports requested by clients that disconnect after 1 s", str(REPORTS)),
        Row(f"afterwards: {idle.what}", *idle[1:]),
        Row("afterwards: peak memory of the server", f"{peak:.0f} MB", f"< {MEGABYTES:.0f} MB", peak < MEGABYTES),
    ]


def half_open(server: Server) -> list[Row]:
    """Begin requests, end none, and ask for something meanwhile."""
    with ExitStack() as held:
        connected(server, server.request("/api/runs")[:-2], HALF_OPEN, held)
        others = server.answers_within()
    idle = idle_after(server)
    peak = server.peak()
    return [
        Row("incomplete requests", str(HALF_OPEN)),
        Row("meanwhile: response time of another request", f"{others:.2f} s", "< 2 s", others < 2),
        Row(f"afterwards: {idle.what}", *idle[1:]),
        Row("afterwards: peak memory of the server", f"{peak:.0f} MB", f"< {MEGABYTES:.0f} MB", peak < MEGABYTES),
    ]


def rows(folder: Path) -> list[Row]:
    """Put load on a server; return what was found as rows of a table."""
    archive = folder / "archive"
    recipe = load_toml(quick_recipe(folder), Recipe)
    failed = [one for one in process(short_runs(folder / "runs", 1, _TIMES), Archive(archive), recipe) if one.error]
    if failed:
        raise RuntimeError(failed)
    with served(archive, folder / "said") as server:
        server.answers_within()
        found = [*downloads(server, (archive / f"{RUN}.h5").stat().st_size), *reports(server), *half_open(server)]
        said = server.said.read()
    loud = len(re.findall("Traceback|Error|out of system", said))
    return [*found, Row("tracebacks, or errors reported by the server", str(loud), "0", not loud)]


def main() -> int:
    """Load, and tell what was found."""
    options = asked(__doc__, points=1).parse_args()
    if not Path("/proc/self/stat").exists():
        print("not tried: it takes Linux")
        return 0
    most = resource.getrlimit(resource.RLIMIT_NOFILE)
    if most[1] != resource.RLIM_INFINITY and most[1] < 2 * HALF_OPEN:
        print("not tried: it takes more open files than are allowed here")
        return 0
    with tempfile.TemporaryDirectory() as folder:
        # The server begins with what a shell gives.
        resource.setrlimit(resource.RLIMIT_NOFILE, (min(1024, most[0]), most[1]))
        told = rows(Path(folder))
    return tell(
        "browse_load",
        "The web server under load",
        options,
        told,
        "One server is tested under one type of load after another, over the loopback interface. It can have up to "
        "1024 files open.",
    )


if __name__ == "__main__":
    sys.exit(main())

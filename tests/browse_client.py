"""A server of the archive's pages on a port of its own, asked by hand: no client mends what an attack sends."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from http.client import HTTPConnection
from pathlib import Path
from typing import Any
from urllib.parse import quote, urlencode

from tribopipe.browse.server import HOST, Site, running


@dataclass(frozen=True)
class Answer:
    """What came back."""

    status: int
    headers: dict[str, str]
    body: bytes

    @property
    def json(self) -> Any:
        return json.loads(self.body)

    @property
    def error(self) -> str:
        return self.json["error"]


class Client:
    """Asks a server whatever it is told to."""

    def __init__(self, site: Site) -> None:
        self.site, self.port = site, site.port

    def send(self, target: str, method: str = "GET", body: bytes | None = None, **headers: str) -> Answer:
        """Send a request to a target as it stands, with the key; headers with _ for -."""
        sent = {"Host": f"{HOST}:{self.port}", **self.site.headers} | {
            name.replace("_", "-"): value for name, value in headers.items()
        }
        connection = HTTPConnection(HOST, self.port, timeout=20)
        try:
            connection.putrequest(method, target, skip_host=True, skip_accept_encoding=True)
            if body is not None:
                sent["Content-Length"] = str(len(body))
            for name, value in sent.items():
                connection.putheader(name, value)
            connection.endheaders(body)
            got = connection.getresponse()
            return Answer(got.status, {name.lower(): value for name, value in got.getheaders()}, got.read())
        finally:
            connection.close()

    def get(self, *parts: str, **query: object) -> Answer:
        """Ask for parts of a path, each quoted, with a query; ``from_`` is "from"."""
        named = {name.rstrip("_"): value for name, value in query.items()}
        asked = f"?{urlencode(named, doseq=True)}" if named else ""
        return self.send("/" + "/".join(quote(part, safe="") for part in parts) + asked)


@contextmanager
def serving(folder: Path) -> Iterator[Client]:
    """Serve an archive in a thread."""
    with running(folder) as site:
        yield Client(site)

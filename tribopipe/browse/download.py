"""Files to be saved, under the names that somebody gave them."""

import os
from collections.abc import Iterable
from pathlib import Path
from urllib.parse import quote

from anyio import Semaphore
from anyio.to_thread import run_sync
from starlette.responses import Response, StreamingResponse
from starlette.types import Receive, Scope, Send

CSV = "text/csv; charset=utf-8"
_OCTETS = "application/octet-stream"
_PIECE = 1 << 16
_AT_ONCE = 32
"""Files sent at the same time; more of them wait."""


def download(parts: Iterable[bytes], name: str, media_type: str = _OCTETS) -> Response:
    """Return bytes for the browser to save, never to show.

    The name is given twice (RFC 6266): in plain letters, and as it is. Neither can end the header.
    """
    return StreamingResponse(parts, media_type=media_type, headers=_headers(name))


class Files:
    """Files of the disk, sent piece by piece, a few of them at the same time."""

    def __init__(self) -> None:
        self._places = Semaphore(_AT_ONCE)

    def download(self, path: Path, media_type: str) -> Response:
        """Return a file for the browser to save; one that takes its place meanwhile is not mixed with it."""
        return _Sent(path, self._places, media_type)


class _Sent(Response):
    """A file as it was when its turn came."""

    def __init__(self, path: Path, places: Semaphore, media_type: str) -> None:
        super().__init__(media_type=media_type, headers=_headers(path.name))
        self._path, self._places = path, places

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:  # noqa: ARG002
        """Send the file. Raises ``OSError`` before anything is sent where it cannot be opened."""
        async with self._places:
            with await run_sync(self._path.open, "rb") as file:
                self.headers["content-length"] = str(os.fstat(file.fileno()).st_size)
                await send({"type": "http.response.start", "status": self.status_code, "headers": self.raw_headers})
                while piece := await run_sync(file.read, _PIECE):
                    await send({"type": "http.response.body", "body": piece, "more_body": True})
        await send({"type": "http.response.body", "body": b"", "more_body": False})


def _headers(name: str) -> dict[str, str]:
    last = name.replace("\\", "/").rpartition("/")[2]
    plain = "".join(sign if sign.isascii() and (sign.isalnum() or sign in "-_. ") else "_" for sign in last) or "file"
    whole = quote(last.encode("utf-8", "replace"), safe="")
    return {"Content-Disposition": f"attachment; filename=\"{plain}\"; filename*=UTF-8''{whole}"}

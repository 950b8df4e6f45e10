"""Responses of the server: JSON, failures as one sentence, and files under names that somebody gave them."""

import os
from collections.abc import Iterable, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

import orjson
from anyio import Semaphore
from anyio.to_thread import run_sync
from starlette.responses import Response, StreamingResponse
from starlette.types import Receive, Scope, Send

from tribopipe.documents.record import Record

_OPTIONS = orjson.OPT_SERIALIZE_NUMPY | orjson.OPT_NON_STR_KEYS


class JsonAnswer(Response):
    """Data classes, records, arrays and JSON types; what is not finite is null."""

    media_type = "application/json"

    def render(self, content: Any) -> bytes:
        """Return the JSON of an answer, which may be JSON already."""
        return content if isinstance(content, bytes) else encoded(content)


def encoded(content: Any) -> bytes:
    """Return JSON of data classes, records, arrays and JSON types; letters that no UTF-8 has become question marks."""
    try:
        return orjson.dumps(content, default=_plain, option=_OPTIONS)
    except orjson.JSONEncodeError:
        return orjson.dumps(_legible(content), default=_plain, option=_OPTIONS)


def _legible(content: Any) -> Any:
    if isinstance(content, str):
        return content.encode("utf-8", "replace").decode()
    if is_dataclass(content):
        return {field.name: _legible(getattr(content, field.name)) for field in fields(content)}
    if isinstance(content, Mapping):
        return {_legible(name): _legible(value) for name, value in content.items()}
    return [_legible(item) for item in content] if isinstance(content, list | tuple) else content


def _plain(value: object) -> Any:
    if isinstance(value, Record):
        return value.model_dump(mode="json", by_alias=True)
    if isinstance(value, Mapping):
        return dict(value)
    raise TypeError(f"{type(value).__name__} is not JSON")


def failure(status: int, sentence: str) -> JsonAnswer:
    """Return a failure; h5web looks for it under another name."""
    headers = {"Allow": "GET"} if status == 405 else None
    return JsonAnswer({"error": sentence, "message": sentence}, status, headers)


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

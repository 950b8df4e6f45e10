"""Files to be saved, under the names that somebody gave them."""

from collections.abc import Iterable
from urllib.parse import quote

from starlette.responses import Response, StreamingResponse

CSV = "text/csv; charset=utf-8"
_OCTETS = "application/octet-stream"


def download(parts: Iterable[bytes], name: str, media_type: str = _OCTETS) -> Response:
    """Return bytes for the browser to save, never to show.

    The name is given twice (RFC 6266): in plain letters, and as it is. Neither can end the header.
    """
    last = name.replace("\\", "/").rpartition("/")[2]
    plain = "".join(sign if sign.isascii() and (sign.isalnum() or sign in "-_. ") else "_" for sign in last) or "file"
    whole = quote(last.encode("utf-8", "replace"), safe="")
    headers = {"Content-Disposition": f"attachment; filename=\"{plain}\"; filename*=UTF-8''{whole}"}
    return StreamingResponse(parts, media_type=media_type, headers=headers)

"""What the server refuses before it looks at a request: the key, the host name, the method and the headers.

The server answers one person's browser on their own machine. The key stands in the address that is printed. The first
answer moves it into a cookie, which no script of a page can read and no other site can send, so that it stays in no
address and no history. Other pages that are open in that browser can reach the server too, so it answers to its own
name alone (which ends DNS rebinding). Keep the rest of guard's module docstring.
"""

import secrets
from collections.abc import Iterable, Mapping
from pathlib import Path, PurePosixPath, PureWindowsPath
from urllib.parse import urlencode

from anyio import create_task_group
from starlette.datastructures import Headers, MutableHeaders, QueryParams
from starlette.exceptions import HTTPException
from starlette.requests import HTTPConnection
from starlette.responses import RedirectResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from tribopipe.browse.responses import failure

_IN_ADDRESS = "key"
_BYTES = 16


class Key:
    """What one server wants to see, new for each."""

    def __init__(self) -> None:
        self._secret = secrets.token_urlsafe(_BYTES)
        self._once: set[str] = set()

    def address(self, base: str) -> str:
        """Return a URL of the server with the key."""
        return _with_key(base, self._secret)

    def address_for_once(self, base: str) -> str:
        """Return an address that lets in once: all accounts may see with what a browser was started."""
        self._once.add(once := secrets.token_urlsafe(_BYTES))
        return _with_key(base, once)

    def cookie(self, port: int) -> str:
        """Return the cookie that holds the key, whose name gives the port: browsers share cookies between ports."""
        return f"{_cookie_name(port)}={self._secret}"

    def is_told(self, query: QueryParams) -> bool:
        """Return whether the key stands in an address, or one that was made for once and has not been used."""
        told = query.get(_IN_ADDRESS, "")
        if told in self._once:
            self._once.remove(told)
            return True
        return self._is_mine(told)

    def is_kept(self, cookies: Mapping[str, str], port: int) -> bool:
        """Return whether a cookie holds the key."""
        return self._is_mine(cookies.get(_cookie_name(port), ""))

    def _is_mine(self, told: str) -> bool:
        return secrets.compare_digest(told.encode("utf-8", "replace"), self._secret.encode())


def without_key(path: str, query: QueryParams) -> str:
    """Return path and query of an address without the key."""
    left = [(name, value) for name, value in query.multi_items() if name != _IN_ADDRESS]
    return f"{path}?{urlencode(left)}" if left else path


def _with_key(base: str, key: str) -> str:
    return f"{base}{'&' if '?' in base else '?'}{_IN_ADDRESS}={key}"


def _cookie_name(port: int) -> str:
    return f"tribopipe-{port}"


NAMES = ("127.0.0.1", "localhost", "[::1]")
PAGE_POLICY = (
    "default-src 'self'; img-src 'self' data: blob:; style-src 'self' 'unsafe-inline'; font-src 'self' data:; "
    "object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
"""Scripts come from the bundle alone; h5web styles by attributes."""
REPORT_POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; font-src data:; frame-ancestors 'none'"
"""A report holds all it needs, and no script."""
_HEADERS = {
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
}
_NO_KEY = (
    "found no access key; expected the key from the address printed by `tribopipe browse`; open that address again"
)
_MISTAKE = "found an internal error ({0}: {1}); expected no exception; please report it with the address of the page"


class Guard:
    """Refuses requests under other names, from other pages, without the key, and all that would write."""

    def __init__(self, app: ASGIApp, key: Key) -> None:
        self._app, self._key = app, key

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or hand it on."""

        async def guarded(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in _HEADERS.items():
                    headers[name] = value
                headers.setdefault("Content-Security-Policy", PAGE_POLICY)
                headers.setdefault("Cache-Control", "no-store")
            await send(message)

        refused = _refusal(scope)
        if refused is not None:
            await failure(*refused)(scope, receive, guarded)
            return
        asked, port = HTTPConnection(scope), scope["server"][1]
        if self._key.is_told(asked.query_params):
            await _let_in(asked, self._key.cookie(port))(scope, receive, guarded)
            return
        if not self._key.is_kept(asked.cookies, port):
            await failure(401, _NO_KEY)(scope, receive, guarded)
            return
        try:
            await _while_asked(self._app, scope, receive, guarded)
        except Exception as error:  # noqa: BLE001, whatever it is, the page gets a sentence
            await failure(500, _MISTAKE.format(type(error).__name__, error))(scope, receive, guarded)


async def _while_asked(app: ASGIApp, scope: Scope, receive: Receive, send: Send) -> None:
    """Answer a request for as long as its client is there; what waits for its turn, or asks, ends with the client."""
    problem = None
    async with create_task_group() as tasks:

        async def watch() -> None:
            while (await receive())["type"] != "http.disconnect":
                pass
            tasks.cancel_scope.cancel()

        tasks.start_soon(watch)
        try:
            await app(scope, receive, send)
        except Exception as error:  # noqa: BLE001, so that it comes out alone, not in a group
            problem = error
        tasks.cancel_scope.cancel()
    if problem is not None:
        raise problem


def _let_in(asked: HTTPConnection, cookie: str) -> RedirectResponse:
    """Move the key from the address into a cookie."""
    headers = {"Set-Cookie": f"{cookie}; Path=/; HttpOnly; SameSite=Lax"}
    # Slashes at the start would lead to another server.
    path = "/" + asked.scope["raw_path"].decode("latin-1").lstrip("/")
    return RedirectResponse(without_key(path, asked.query_params), 303, headers)


def _refusal(scope: Scope) -> tuple[int, str] | None:
    """Return the status and the sentence of a refusal; none where there is nothing to refuse."""
    headers, names = Headers(scope=scope), _own_names(scope)
    if headers.getlist("host")[1:] or headers.get("host", "").lower() not in names:
        return (
            400,
            f"found the host {headers.get('host', '')!r}; expected {names[0]}; open the address printed by "
            "`tribopipe browse`",
        )
    if scope["method"] != "GET":
        return 405, f"found the method {scope['method']}; expected GET; the server is read-only"
    if _from_elsewhere(headers, names):
        return (
            403,
            "found a request from another website; expected a request from a page of this server; open the address "
            "printed by `tribopipe browse`",
        )
    return None


def _own_names(scope: Scope) -> list[str]:
    """Return what the server may be called in a request."""
    port = scope["server"][1]
    return [f"{name}:{port}" for name in NAMES] + (list(NAMES) if port == 80 else [])


def _from_elsewhere(headers: Headers, names: Iterable[str]) -> bool:
    """Return whether another page asks, other than by a link that was followed to here."""
    origin, site = headers.get("origin"), headers.get("sec-fetch-site", "none")
    if origin is not None and origin not in {f"http://{name}" for name in names}:
        return True
    followed = (headers.get("sec-fetch-mode"), headers.get("sec-fetch-dest")) == ("navigate", "document")
    return site not in ("none", "same-origin") and not followed


def inside(folder: Path, relative: str) -> Path:
    """Return the file of a relative path that lies in a folder, symbolic links followed.

    Raises ``HTTPException`` (404) where there is none, or it leads out of the folder.
    """
    named = relative.replace("\\", "/")
    odd = "\0" in named or PureWindowsPath(named).drive or PureWindowsPath(named).root
    if not odd and ":" not in named and ".." not in PurePosixPath(named).parts:
        try:
            found = (folder / named).resolve(strict=True)
        except (OSError, RuntimeError, ValueError):  # nothing there, a circle of links, or no name at all
            found = None
        if found is not None and found.is_relative_to(folder.resolve()) and found.is_file():
            return found
    raise HTTPException(
        404, f"found no {relative!r} in {folder}; expected a file in this folder; check whether it was moved"
    )

"""The key of a server: who cannot show it gets no answer, another account of the same machine neither.

It stands in the address that is printed. The first answer moves it into a cookie, which no script of a page can read
and no other site can send, so that it stays in no address and no history.
"""

import secrets
from collections.abc import Mapping
from urllib.parse import urlencode

from starlette.datastructures import QueryParams

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

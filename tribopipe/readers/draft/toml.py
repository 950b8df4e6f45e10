"""Values and comments of TOML, whatever a header or a file name holds."""

import json
import re
import tomllib
from collections.abc import Mapping
from datetime import date, datetime, time
from typing import Any

from tribopipe.documents.record import quoted

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
_LONGEST_COMMENT = 200


def toml(value: Any) -> str:
    """Write a value as TOML does."""
    if isinstance(value, str):
        return quoted(value)
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{toml_key(key)} = {toml(inner)}' for key, inner in value.items())} }}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(toml, value))}]"
    if isinstance(value, datetime | date | time):
        return value.isoformat()
    return json.dumps(value)


def toml_key(key: str) -> str:
    """Write a key, in quotes where it needs them."""
    return key if _BARE_KEY.fullmatch(key) else quoted(key)


def one_line(text: str) -> str:
    """Write a text in one line, without control characters."""
    return " ".join("".join(sign if sign.isprintable() else " " for sign in text).split())


def comment(text: str) -> str:
    """Write a text so that it can stand behind #."""
    plain = one_line(text)
    return plain if len(plain) <= _LONGEST_COMMENT else plain[: _LONGEST_COMMENT - 1] + "…"


def value_of(text: str) -> Any:
    """Give the value that a text is in TOML: 0.24, 2006-03-01, { value = "50 N" }; the text itself where it is none."""
    try:
        document = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return document["value"] if list(document) == ["value"] else text

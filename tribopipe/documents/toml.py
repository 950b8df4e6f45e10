"""TOML documents read from files, with limits on size and depth, in bounded time and memory."""

import json
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tribopipe.base.errors import ManifestError
from tribopipe.base.files import read_file

_MOST_BYTES = 1 << 20
_MOST_VALUES = 100_000
_MOST_LEVELS = 20
_MOST_BITS = 63
"""Largest number of bits of an integer, without its sign, as in TOML 1.0."""
_PART_OF_KEY = r"""(?:[A-Za-z0-9_-]+|"(?:[^"\\\n]|\\.)*"|'[^'\n]*')"""
_LONG_KEY = re.compile(rf"(?<![A-Za-z0-9_\\-])(?:{_PART_OF_KEY}[ \t]*\.[ \t]*){{{_MOST_LEVELS}}}")
"""tomllib takes time and memory by the square of the parts of a dotted key: 10 000 of them need gigabytes."""


def read_bytes(path: Path) -> bytes:
    """Read a document's bytes; ``ManifestError`` where there is no such file, or one too large for a document."""
    try:
        if path.is_dir():
            raise ManifestError(f"{path}: found a folder; expected a TOML file; specify the file itself")
        if (size := path.stat().st_size) > _MOST_BYTES:
            raise ManifestError(
                f"{path}: found {size:,} bytes; expected at most {_MOST_BYTES:,}, since documents are written by hand; "
                "specify a TOML file, and keep signals in separate files"
            )
        return read_file(path)
    except FileNotFoundError:
        raise ManifestError(f"{path}: no such file; expected an existing TOML file; check the path") from None
    except OSError as error:
        raise ManifestError(
            f"{path}: cannot be read ({error.strerror}); expected a readable file; check its permissions"
        ) from None


def parse_toml(path: Path, content: bytes) -> dict[str, Any]:
    """Parse TOML; ``ManifestError`` with line or key where it is none, or holds what no document needs."""
    try:
        text = content.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        raise ManifestError(
            f"{path}: byte {error.start} is not UTF-8; expected TOML in UTF-8; save the file as UTF-8"
        ) from None
    if (long := _LONG_KEY.search(text)) is not None:
        line = text.count("\n", 0, long.start()) + 1
        raise ManifestError(
            f"{path}, line {line}: found a key of more than {_MOST_LEVELS} parts; expected at most {_MOST_LEVELS}; "
            "correct that line"
        )
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ManifestError(f"{path}: invalid TOML: {error}; correct that line (strings need quotes)") from None
    except (ValueError, RecursionError):
        raise ManifestError(
            f"{path}: invalid TOML: tables or lists are nested too deeply, or a number has thousands of digits; "
            "correct the file"
        ) from None
    _refuse_absurd(path, document)
    return document


def _refuse_absurd(path: Path, document: dict[str, Any]) -> None:
    for count, (level, key, value) in enumerate(_values(document)):
        if count > _MOST_VALUES:
            raise ManifestError(
                f"{path}: found more than {_MOST_VALUES:,} values; expected fewer, since documents are written by "
                "hand; keep signals in separate files"
            )
        if level > _MOST_LEVELS:
            raise ManifestError(
                f"{path}: {key}: found more than {_MOST_LEVELS} nesting levels; expected at most {_MOST_LEVELS}; "
                "reduce the nesting of this key"
            )
        if isinstance(value, int) and value.bit_length() > _MOST_BITS:
            raise ManifestError(
                f"{path}: {key}: found an integer of more than 64 bits; expected at most 64 bits; use a smaller number"
            )
        if isinstance(value, str) and "\0" in value:
            raise ManifestError(
                f"{path}: {key}: found a null character (\\u0000) in a string; expected text without it; remove it"
            )


def _values(document: dict[str, Any]) -> Iterator[tuple[int, str, Any]]:
    """Give each value with its level and key; tables and lists before what is in them."""
    left: list[tuple[int, str, Any]] = [(0, "", document)]
    while left:
        level, key, value = left.pop()
        yield level, key, value
        if isinstance(value, dict):
            above = f"{key}." if key else ""
            left += [(level + 1, above + written_key(name), inner) for name, inner in value.items()]
        elif isinstance(value, list):
            left += [(level + 1, f"{key}[{at}]", inner) for at, inner in enumerate(value)]


def written_key(name: str) -> str:
    """Write a key as TOML does: in quotes where it is not of letters, digits, _ and - alone."""
    return name if re.fullmatch(r"[\w-]+", name, re.ASCII) else shortened(json.dumps(name))


def shortened(text: str) -> str:
    """Return a text, or the beginning of a long one."""
    return text if len(text) <= 60 else text[:57] + "…"

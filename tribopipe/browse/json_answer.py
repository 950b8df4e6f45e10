"""Answers in JSON: whatever the pages are made of, and failures as one sentence."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import orjson
from starlette.responses import Response

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
    raise TypeError(f"{type(value).__name__} is no JSON")


def failure(status: int, sentence: str) -> JsonAnswer:
    """Return a failure; h5web looks for it under another name."""
    headers = {"Allow": "GET"} if status == 405 else None
    return JsonAnswer({"error": sentence, "message": sentence}, status, headers)

"""The notes and findings of a result in the names of the contact that it is of."""

from collections.abc import Callable
from typing import Any, TypeVar

from tribopipe.documents.record import Record

R = TypeVar("R", bound=Record)


def reworded(result: R, worded: Callable[[str], str]) -> R:
    """Return a result whose sentences are those that ``worded`` makes of them."""
    changed: dict[str, Any] = {}
    if notes := getattr(result, "notes", ()):
        changed["notes"] = tuple(map(worded, notes))
    if findings := getattr(result, "findings", ()):
        changed["findings"] = tuple(
            one.model_copy(update={part: worded(getattr(one, part)) for part in ("where", "message", "remedy")})
            for one in findings
        )
    if anchor := getattr(result, "anchor", None):
        changed["anchor"] = worded(anchor)
    return result.model_copy(update=changed) if changed else result

"""Annotations of archived runs: tags for searching, notes, and marks as bad or good."""

import re
from collections.abc import Iterable
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, model_validator

from tribopipe.documents.record import Record

_TAG = re.compile(r"[^\s,]{1,60}")


class Annotation(Record):
    """One entry in the history of what people added to a run."""

    kind: Literal["tag", "untag", "note"]
    """Untag: takes a tag back."""
    text: str
    """The tag, or the note."""
    date: str
    """Date of the entry, ISO 8601."""
    operator: str | None = None
    """Name of the person who added the entry; None if unknown."""

    @model_validator(mode="after")
    def _says_something(self) -> Self:
        if self.kind == "note" and not self.text.strip():
            raise ValueError(f"found the note {self.text!r}; expected at least one word; enter the text of the note")
        if self.kind != "note" and not (_TAG.fullmatch(self.text) and self.text.isprintable()):
            raise ValueError(
                f"found the tag {self.text!r}; expected up to 60 characters without spaces or commas, such as "
                "'run-in'; use - instead of a space"
            )
        return self

    def __str__(self) -> str:
        who = f" by {self.operator}" if self.operator else ""
        done = {"tag": "tagged", "untag": "no longer tagged", "note": "note"}[self.kind]
        return f"{done}{who}, {self.date}: {self.text}"


def tags_after(history: Iterable[Annotation]) -> tuple[str, ...]:
    """Return the tags that are left at the end of a history, in the order in which they were given."""
    tags: dict[str, None] = {}
    for entry in history:
        if entry.kind == "tag":
            tags[entry.text] = None
        elif entry.kind == "untag":
            tags.pop(entry.text, None)
    return tuple(tags)


def _worded(meaning: str) -> AfterValidator:
    """Strip a text, and refuse one without a word."""

    def strip(text: str) -> str:
        stripped = text.strip()
        if not stripped:
            raise ValueError(f"found {text!r}; expected {meaning} (at least one word); enter it")
        return stripped

    return AfterValidator(strip)


class Mark(Record):
    """One entry in the history of marks of a run; the last one counts."""

    kind: Literal["bad", "good"]
    """Bad: excluded from studies and not used as a reference for predictions. Good: withdraws this mark."""
    reason: Annotated[str, _worded("the reason for the mark")]
    """Why, in the words of whoever marked it."""
    date: str
    """Date of the mark, ISO 8601."""
    operator: Annotated[str, _worded("the name of the operator")] | None = None
    """Name of the person who marked the run; None if unknown."""

    def __str__(self) -> str:
        who = f" by {self.operator}" if self.operator else ""
        done = "marked bad" if self.kind == "bad" else "bad mark removed"
        return f"{done}{who}, {self.date}: {self.reason}"

"""What people add to an archived run: tags to find it by, and notes."""

import re
from collections.abc import Iterable
from typing import Literal, Self

from pydantic import model_validator

from tribopipe.documents.record import Record

_TAG = re.compile(r"[^\s,]{1,60}")


class Annotation(Record):
    """One entry in the history of what people added to a run."""

    kind: Literal["tag", "untag", "note"]
    """Untag: takes a tag back."""
    text: str
    """The tag, or the note."""
    date: str
    """When it was added, ISO 8601."""
    operator: str | None = None
    """Who added it; none where nobody is known by name."""

    @model_validator(mode="after")
    def _says_something(self) -> Self:
        if self.kind == "note" and not self.text.strip():
            raise ValueError(f"found the note {self.text!r}; expected at least one word; write it")
        if self.kind != "note" and not (_TAG.fullmatch(self.text) and self.text.isprintable()):
            raise ValueError(
                f"found the tag {self.text!r}; expected up to 60 letters, digits and signs without a space or a comma, "
                "such as 'run-in'; write - for a space"
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

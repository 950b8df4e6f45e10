"""What people state about an archived run as a whole: that it is bad, or good after all, and why."""

from typing import Annotated, Literal

from pydantic import AfterValidator

from tribopipe.documents.record import Record


def _worded(meaning: str) -> AfterValidator:
    """Strip a text, and refuse one without a word."""

    def strip(text: str) -> str:
        stripped = text.strip()
        if not stripped:
            raise ValueError(f"found {text!r}; expected {meaning}, in at least one word; write it")
        return stripped

    return AfterValidator(strip)


class Mark(Record):
    """One entry in the history of marks of a run; the last one counts."""

    kind: Literal["bad", "good"]
    """Bad: left out of studies, and no reference of predictions. Good: takes that back."""
    reason: Annotated[str, _worded("why the run is marked")]
    """Why, in the words of whoever marked it."""
    date: str
    """When it was marked, ISO 8601."""
    operator: Annotated[str, _worded("who marks the run")] | None = None
    """Who marked it; none where nobody is known by name."""

    def __str__(self) -> str:
        who = f" by {self.operator}" if self.operator else ""
        return f"marked {self.kind}{who}, {self.date}: {self.reason}"

"""What a watch reports, as a sentence for people and as JSON for programs."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any, Literal

Kind = Literal["made", "done", "waiting", "failed", "same", "left", "gone", "back"]
_COUNTED: dict[Kind, str] = {
    "done": "archived",
    "waiting": "to be filled in",
    "failed": "failed",
    "same": "with bytes of other files",
    "left": "left alone",
}


@dataclass(frozen=True)
class Event:
    """Something that happened."""

    kind: Kind
    text: str
    """One sentence."""
    file: str | None = None
    """What was dropped: its path in the watched folder."""
    run: str | None = None
    """Id of the run, or the path of a run folder that was dropped."""
    details: tuple[str, ...] = ()
    """Further sentences: what was fitted, and what a person should look at."""
    more: Mapping[str, Any] = field(default_factory=dict)
    """Further JSON."""

    def as_json(self) -> dict[str, Any]:
        """Return the event as JSON types, with the current time."""
        now = datetime.now(UTC).isoformat(timespec="milliseconds")
        told = {"event": self.kind, "time": now, "file": self.file, "id": self.run, "text": self.text}
        return told | {"details": list(self.details)} | dict(self.more)


def counted(kinds: Iterable[Kind]) -> str:
    """Return how many drops came to which end."""
    kinds = list(kinds)
    counts = [f"{kinds.count(kind)} {words}" for kind, words in _COUNTED.items() if kind in kinds]
    return ", ".join(counts) or "nothing new"

"""What a check found in a run."""

from typing import Literal

from tribopipe.records.base import Record

Severity = Literal["error", "warning", "note"]


class Finding(Record):
    """One thing a person should know about a run before trusting it."""

    severity: Severity
    """Error: the run is refused. Warning: look before you trust it. Note: good to know."""
    code: str
    """Name of the check, by which scripts tell findings apart."""
    where: str
    """Key of run.toml, or the signal."""
    message: str
    """What was found, and what was expected."""
    remedy: str
    """How to mend it."""

    def __str__(self) -> str:
        return f"{self.where}: {self.message}; {self.remedy}"

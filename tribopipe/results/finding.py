"""What a check found in a run."""

from collections.abc import Iterable
from typing import Literal

from tribopipe.documents.record import Record

Severity = Literal["error", "warning", "note"]


class Finding(Record):
    """One thing a person should know about a run before trusting it."""

    severity: Severity
    """Error: the run is refused. Warning: look before you trust it. Note: good to know."""
    code: str
    """Name of the check, by which scripts distinguish findings."""
    where: str
    """Key of run.toml, or the signal."""
    message: str
    """What was found, and what was expected."""
    remedy: str
    """How to correct it."""

    def __str__(self) -> str:
        return f"{self.where}: {self.message}; {self.remedy}"


def first_of_each_code(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Return the first finding of each code at each place: two laws fitted to one reading share what speaks against it.

    Parameters
    ----------
    findings
        Findings of the fits of one run, the main law first.

    Returns
    -------
    tuple of Finding
        In the same order.
    """
    firsts: dict[tuple[str, str], Finding] = {}
    for finding in findings:
        firsts.setdefault((finding.code, finding.where), finding)
    return tuple(firsts.values())


def findings_of(results: Iterable[object]) -> tuple[Finding, ...]:
    """Return the findings against the results of a run, without duplicates of code and place."""
    return first_of_each_code(finding for result in results for finding in getattr(result, "findings", ()))

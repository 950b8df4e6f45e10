"""How a check is registered, and how all of them are run."""

from collections.abc import Callable, Iterator
from typing import NamedTuple

from tribopipe.clean_up.cleaning import CleanedRun, clean_run
from tribopipe.errors import CheckError
from tribopipe.records.finding import Finding, Severity
from tribopipe.run import RawRun


class Trouble(NamedTuple):
    """What a check has to say: where, what was found and expected, how to mend it."""

    where: str
    message: str
    remedy: str


Check = Callable[[RawRun], Iterator[Trouble]]
CleanedCheck = Callable[[RawRun, CleanedRun], Iterator[Trouble]]
CHECKS: dict[str, tuple[Severity, CleanedCheck]] = {}


def check(severity: Severity) -> Callable[[Check], Check]:
    """Register a function as a check of a severity; its name is the check's name."""

    def register(function: Check) -> Check:
        CHECKS[function.__name__] = (severity, lambda run, _: function(run))
        return function

    return register


def check_cleaned(severity: Severity) -> Callable[[CleanedCheck], CleanedCheck]:
    """Register a function as a check that looks at a run and at what clean-up makes of it."""

    def register(function: CleanedCheck) -> CleanedCheck:
        CHECKS[function.__name__] = (severity, function)
        return function

    return register


def check_run(run: RawRun) -> list[Finding]:
    """Run every check on a run and return what they found, errors first."""
    from tribopipe.checks import documents, end_values, samples  # noqa: F401 - importing registers their checks

    cleaned = clean_run(run)
    found = [
        Finding(severity=severity, check=name, where=trouble.where, message=trouble.message, remedy=trouble.remedy)
        for name, (severity, function) in CHECKS.items()
        for trouble in function(run, cleaned)
    ]
    order: list[Severity] = ["error", "warning", "note"]
    return sorted(found, key=lambda finding: order.index(finding.severity))


def refuse_errors(run: RawRun, findings: list[Finding]) -> None:
    """Raise ``CheckError`` with the first error among the findings."""
    errors = [finding for finding in findings if finding.severity == "error"]
    if errors:
        more = f" (and {len(errors) - 1} more; see `tribopipe check`)" if len(errors) > 1 else ""
        raise CheckError(f"{run.id}: {errors[0]}{more}")

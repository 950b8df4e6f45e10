"""Registration of checks, and the function that runs all of them.

A package adds checks by an entry point in the group ``tribopipe.checks`` whose value is a module that registers them;
tribopipe's own modules are declared the same way.
"""

from collections.abc import Callable, Iterator, Mapping
from functools import cache
from importlib.metadata import EntryPoint
from operator import attrgetter
from types import ModuleType
from typing import NamedTuple

from tribopipe.base.errors import CheckError
from tribopipe.base.plugins import Plugins
from tribopipe.evaluation.preprocessing.cleaning import CleanedRun, clean_run
from tribopipe.results.finding import Finding, Severity
from tribopipe.results.run import RawRun

GROUP = "tribopipe.checks"


class Trouble(NamedTuple):
    """Result of a check: location, what was found and expected, and the remedy."""

    where: str
    message: str
    remedy: str


Check = Callable[[RawRun], Iterator[Trouble]]
CleanedCheck = Callable[[RawRun, CleanedRun], Iterator[Trouble]]
CHECKS: dict[str, tuple[Severity, CleanedCheck]] = {}


def check(severity: Severity) -> Callable[[Check], Check]:
    """Register a function as a check of a severity; its name is the check's name."""

    def register(function: Check) -> Check:
        _register(severity, function, lambda run, _: function(run))
        return function

    return register


def check_cleaned(severity: Severity) -> Callable[[CleanedCheck], CleanedCheck]:
    """Register a function as a check that looks at a run and at what preprocessing makes of it."""

    def register(function: CleanedCheck) -> CleanedCheck:
        _register(severity, function, function)
        return function

    return register


def _register(severity: Severity, function: Callable[..., object], taken: CleanedCheck) -> None:
    name = function.__name__
    if name in CHECKS:
        raise ValueError(f"a check {name!r} already exists")
    CHECKS[name] = (severity, taken if _is_own(function) else _guarded(name, taken))


def _is_own(function: Callable[..., object]) -> bool:
    return function.__module__.startswith("tribopipe.")


def _guarded(name: str, function: CleanedCheck) -> CleanedCheck:
    """Return a check of another package as one that reports its own failure."""

    def guarded(run: RawRun, cleaned: CleanedRun) -> Iterator[Trouble]:
        try:
            yield from function(run, cleaned)
        except Exception as error:  # noqa: BLE001 - somebody else's code may raise anything
            yield Trouble("plugin", f"the check {name} failed ({error!r})", "report it to its author")

    return guarded


@cache
def load_checks() -> Mapping[str, ModuleType]:
    """Load the modules that register checks, and return them by name."""
    return dict(Plugins(GROUP, "check", EntryPoint.load, attrgetter("__name__")))


def check_run(run: RawRun) -> list[Finding]:
    """Run every check on a run and return what they found, errors first."""
    load_checks()
    cleaned = clean_run(run)
    worded = run.manifest.worded
    found = [
        Finding(severity=severity, code=name, **{part: worded(text) for part, text in trouble._asdict().items()})
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
        refused = CheckError(f"{run.id}: {errors[0]}{more}")
        refused.code = errors[0].code
        raise refused

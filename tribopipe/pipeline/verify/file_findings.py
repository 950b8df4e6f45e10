"""What is found while one file of the archive is looked at; a part that cannot be read does not hide the others."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Literal

from tribopipe.archive.file_access import NOT_READ
from tribopipe.base.errors import TribopipeError
from tribopipe.base.failures import number_of, unreadable
from tribopipe.results.finding import Finding, Severity

CheckName = Literal[
    "file",
    "seal",
    "content",
    "identity",
    "source",
    "raw",
    "result",
    "inputs",
    "reference",
    "study",
    "shown",
    "nexus",
    "folder",
    "history",
    "catalog",
    "recompute",
]
RESTORE = "restore the file from a backup, or save its intact source files with `tribopipe rescue`"


class Look:
    """One look at one file, and what was found so far."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.findings: list[Finding] = []
        self._not_given = False

    def error(self, check: CheckName, message: str, remedy: str = RESTORE, part: str = "") -> None:
        """Note that something is damaged."""
        self._find("error", check, message, remedy, part)

    def warning(self, check: CheckName, message: str, remedy: str, part: str = "") -> None:
        """Note that something is not to be trusted as it is."""
        self._find("warning", check, message, remedy, part)

    def note(self, check: CheckName, message: str, remedy: str, part: str = "") -> None:
        """Note what is good to know."""
        self._find("note", check, message, remedy, part)

    @contextmanager
    def reading(self, part: str = "") -> Iterator[None]:
        """Note that a part of the file cannot be read, where it turns out so, and go on after it.

        Where the system does not read it, nothing is known of the file, and nothing else is stated about it.
        """
        try:
            yield
        except TribopipeError as error:
            if error.__cause__ is not None and (number := number_of(error.__cause__)):
                self._give_up(number)
            self.refused("content", error, part)
        except NOT_READ as error:
            if number := number_of(error):
                self._give_up(number)
            why = (str(error).splitlines() or [""])[0]
            self.error(
                "content",
                f"found content that cannot be read ({why}); expected an unmodified tribopipe file",
                part=part,
            )

    def _give_up(self, number: int) -> None:
        if not self._not_given:
            message, _, remedy = unreadable(number).rpartition("; ")
            self.findings.clear()
            self.error("file", message, remedy)
            self._not_given = True

    def named(self, expected: str, *said: str) -> None:
        """Note where a file states that it is of another id than its name."""
        for one in sorted({*said} - {expected}):
            message = f"found content archived as {one!r}; expected {expected!r}, as in the file name"
            self.error("identity", message, f"rename the file to {one}.h5, or restore it from a backup")

    def take_over(self, other: "Look") -> None:
        """Add what another look at the same file found."""
        if not self._not_given:
            self.findings += other.findings

    def refused(self, check: CheckName, error: TribopipeError, part: str = "") -> None:
        """Take over the sentence of an error: where, what was found, what was expected, how to correct it."""
        sentence = str(error)
        place = sentence.find(f"{self.name}: ")
        told = sentence[place + len(self.name) + 2 :] if place >= 0 else sentence
        message, _, remedy = told.rpartition("; ")
        self.error(check, message or told, remedy if message else RESTORE, part)

    def _find(self, severity: Severity, check: CheckName, message: str, remedy: str, part: str) -> None:
        if self._not_given:
            return
        where = f"{self.name}: {part}" if part else self.name
        self.findings.append(Finding(severity=severity, code=check, where=where, message=message, remedy=remedy))

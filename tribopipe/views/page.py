"""A run or a study on one page, as text in order: alike for a terminal, a web page and a report.

Whoever shows a page escapes its texts for its output: they hold whatever a lab wrote.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from tribopipe.results.finding import Finding


@dataclass(frozen=True)
class Fact:
    """One thing known, as people read it: "normal load", "200.0 ± 2.0 mN"."""

    name: str
    value: str


@dataclass(frozen=True)
class FactGroup:
    """Things known that belong together, such as those of the pin."""

    title: str
    facts: tuple[Fact, ...]


@dataclass(frozen=True)
class TextTable:
    """A table of texts."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    spare: tuple[str, ...] = ()
    """Columns that a narrow terminal leaves out."""

    def without_spare(self) -> "TextTable":
        """Return the table without the columns that may be left out."""
        kept = [place for place, name in enumerate(self.columns) if name not in self.spare]
        columns, *rows = (tuple(row[place] for place in kept) for row in (self.columns, *self.rows))
        return TextTable(self.title, columns, tuple(rows))


@dataclass(frozen=True)
class StagePage:
    """One step that a run has been through."""

    name: str
    """As the archive calls it: "drift_correction"."""
    title: str
    """As people call it: "Drift correction"."""
    sentence: str
    """What it found."""
    facts: tuple[Fact, ...]
    """The numbers it found, one by one."""
    notes: tuple[str, ...]
    """What to beware of."""
    tables: tuple[TextTable, ...]
    """Budgets and the like."""
    path: str
    """Where it stands in the run's HDF5 file."""
    program_version: str
    date: str
    options: Mapping[str, object]
    """What the step was given, as JSON types."""
    inputs_sha256: str
    result_sha256: str


@dataclass(frozen=True)
class SourceEntry:
    """A file as it came, without its bytes."""

    number: int
    """Its place in /entry/source_files."""
    name: str
    size: int
    sha256: str


@dataclass(frozen=True)
class Remark:
    """A mark, tag or note that somebody gave to a run, or what was amended in its run.toml."""

    kind: str
    """"bad", "good", "tag", "untag", "note" or "amended"."""
    text: str
    date: str
    operator: str | None


@dataclass(frozen=True)
class RunPage:
    """One run."""

    id: str
    title: str
    tribometer: str | None
    bad: str | None
    """Why it is marked bad; none where it is not."""
    tags: tuple[str, ...]
    remarks: tuple[Remark, ...]
    """All annotations, oldest first."""
    facts: tuple[FactGroup, ...]
    """Test, bodies, post-test measurements, what was recorded."""
    findings: tuple[Finding, ...]
    stages: tuple[StagePage, ...]
    sources: tuple[SourceEntry, ...]
    raw_sha256: str
    studies: tuple[str, ...]
    """Ids of the studies it is part of."""


@dataclass(frozen=True)
class VerdictLine:
    """What a study states about one run under one law."""

    run_id: str
    role: str
    """"fitted" or "predicted"."""
    outcome: str
    sentence: str
    notes: tuple[str, ...]


@dataclass(frozen=True)
class LawPage:
    """One wear law in a study."""

    model: str
    heading: str
    """The law alone, such as "Archard's law"."""
    title: str
    """The law and its k_D with interval."""
    tables: tuple[TextTable, ...]
    sentences: tuple[str, ...]
    """Scatter between runs and the like."""
    verdicts: tuple[VerdictLine, ...]


@dataclass(frozen=True)
class StudyPage:
    """One study."""

    id: str
    title: str
    fitted: tuple[str, ...]
    predicted: tuple[str, ...]
    laws: tuple[LawPage, ...]
    sentences: tuple[str, ...]
    """What is stated about the study as a whole: which law the shapes prefer, what was left out, notes."""
    program_version: str
    date: str
    inputs_sha256: str

"""One run of an archive as Python sees it: ``archive["si3n4-air-200mN"]``, and its outline without arrays.

An outline is read as fast for two million samples as for a hundred.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

from tribopipe.archive import nexus
from tribopipe.archive.hdf5_compression import unpacked
from tribopipe.archive.long_recordings import recorded_samples
from tribopipe.archive.runfile import (
    members,
    read_environment,
    read_findings,
    read_fingerprints,
    read_manifest,
    read_marks,
    read_result,
)
from tribopipe.archive.steps import PREDICTIONS, WEAR_FITS, Step, StepName, StepsByLaw, step_in_words, steps_among
from tribopipe.documents.annotation import Mark
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.record import Record
from tribopipe.documents.signals import SIGNALS, SignalName
from tribopipe.results.evaluation import DriftCorrection, FrictionFit
from tribopipe.results.finding import Finding
from tribopipe.results.interactive import Tabular, UnitColumn, views
from tribopipe.results.run import CorrectedRun, Origin, RawRun
from tribopipe.results.wear_fit import WearFit
from tribopipe.results.wear_prediction import Band, WearCurves, WearPrediction

if TYPE_CHECKING:
    from tribopipe.archive.store import Archive


_TAIL = 1000
"""Samples at the end of a run among which the last known value of an axis is looked for."""


@dataclass(frozen=True)
class SourceOutline:
    """A file as it came, without its bytes."""

    name: str
    size: int
    sha256: str


@dataclass(frozen=True)
class StepOutline:
    """One step of one run without its curves and tables."""

    name: StepName
    result: Record
    inputs_sha256: str
    result_sha256: str
    options: Mapping[str, object]
    """Options of the step, as JSON types."""
    program_version: str
    date: str
    """Date of the computation, ISO 8601."""
    environment: Mapping[str, str] = field(default_factory=dict)
    """Versions of the software and the machine; empty if the file does not state them."""


@dataclass(frozen=True)
class RunOutline:
    """One run without its columns."""

    manifest: RunManifest
    samples: int
    """Number of samples that are evaluated."""
    recorded: int | None
    """Number of recorded samples, if the evaluated ones are means; otherwise none."""
    origins: Mapping[SignalName, Origin]
    """The signals it has, and whether each was measured or derived."""
    ends: Mapping[SignalName, float]
    """Last known time, sliding distance and rotations, SI, as preprocessed."""
    extras: tuple[str, ...]
    """Names of columns that no signal was made of."""
    sources: tuple[SourceOutline, ...]
    raw_sha256: str
    environment: Mapping[str, str]
    """Versions of the software at ingest; empty if the file does not state them."""
    findings: tuple[Finding, ...]
    marks: tuple[Mark, ...]
    """Oldest first; the last one counts."""
    steps: Mapping[StepName, StepOutline]
    """Steps of the run, in order."""


def read_outline(file: h5py.File) -> RunOutline:
    """Read a run without its columns and curves."""
    entry = file["entry"]
    raw, extras = entry["raw"], [*members(entry["extra_columns"])] if "extra_columns" in entry else ()
    names = [name for name in SIGNALS if name in raw]
    return RunOutline(
        manifest=read_manifest(file),
        samples=len(raw[names[0]]),
        recorded=recorded_samples(entry),
        origins={name: raw[name].attrs["origin"] for name in names},
        ends=_ends(entry, names),
        extras=tuple(str(column.attrs["column_name"]) for column in extras),
        sources=tuple(_source(note) for note in members(entry["source_files"])),
        raw_sha256=nexus.text(entry, "archived/raw_sha256"),
        environment=read_environment(entry),
        findings=tuple(read_findings(entry)),
        marks=tuple(read_marks(entry)),
        steps={name: step for name in steps_among(entry) if (step := _step(entry, name)) is not None},
    )


def _source(note: h5py.Group) -> SourceOutline:
    return SourceOutline(nexus.text(note, "file_name"), int(note["data"].size), nexus.text(note, "checksum"))


def _step(entry: h5py.Group, name: StepName) -> StepOutline | None:
    result, fingerprints = read_result(entry, name), read_fingerprints(entry, name)
    if result is None or fingerprints is None:
        return None
    return StepOutline(
        name=name,
        result=result,
        inputs_sha256=fingerprints.inputs,
        result_sha256=fingerprints.result,
        options=json.loads(nexus.text(entry[name], "options/data")),
        program_version=nexus.text(entry[name], "version"),
        date=nexus.text(entry[name], "date"),
        environment=nexus.told(entry[name], "environment"),
    )


def _ends(entry: h5py.Group, names: list[SignalName]) -> dict[SignalName, float]:
    axes: tuple[SignalName, ...] = ("time", "sliding_distance", "rotations")
    found = {name: _last(entry, name) for name in axes if name in names}
    return {name: value for name, value in found.items() if value is not None}


def _last(entry: h5py.Group, name: SignalName) -> float | None:
    """Return the last known value of an axis, preprocessed or else raw; none where its end is missing."""
    cleaned = isinstance(entry.get(f"clean_up/data/{name}", getlink=True), h5py.HardLink)
    tail = unpacked(entry["clean_up/data" if cleaned else "raw"][name], last=_TAIL).astype(np.float64)
    known = tail[np.isfinite(tail)]
    return float(known[-1]) if known.size else None


class ArchivedRun(Tabular):
    """A run in an archive. Each attribute is read from the file when it is used."""

    def __init__(self, archive: "Archive", run_id: str) -> None:
        self.archive, self._id = archive, run_id

    @property
    def id(self) -> str:
        """Name of the run."""
        return self._id

    @property
    def manifest(self) -> RunManifest:
        """Content of run.toml."""
        return self.archive.manifest(self.id)

    @property
    def raw(self) -> RawRun:
        """The run as it was ingested."""
        return self.archive.raw(self.id)

    @property
    def run(self) -> RawRun:
        """The run with preprocessed signals; as ingested if there was no preprocessing."""
        return self.archive.cleaned(self.id)

    @property
    def corrected(self) -> CorrectedRun:
        """The run corrected for drift. Raises ``ArchiveError`` if it has no drift correction."""
        correction = self.archive.needed_result(self.id, "drift_correction", DriftCorrection)
        step = self.archive.step(self.id, "drift_correction")
        curves = {} if step is None else {name: values for name, (values, _) in step.curves.items()}
        return CorrectedRun(self.run, correction, curves.get("wear_depth"), curves.get("wander"))

    @property
    def friction(self) -> FrictionFit | None:
        """Fit of the friction coefficient; none if the run has no such step."""
        fit = self.archive.result(self.id, "friction_fit", FrictionFit)
        return None if fit is None else fit.fitted_to(self.run)

    @property
    def fits(self) -> dict[str, WearFit]:
        """Wear fits by the name of the wear law."""
        steps = self._under(WEAR_FITS)
        return {
            law: self._drawable(step.result, step) for law, step in steps.items() if isinstance(step.result, WearFit)
        }

    @property
    def predictions(self) -> dict[str, WearPrediction]:
        """Predicted wear by the name of the wear law."""
        steps = self._under(PREDICTIONS)
        return {law: step.result for law, step in steps.items() if isinstance(step.result, WearPrediction)}

    @property
    def findings(self) -> list[Finding]:
        """Findings of the checks at ingest."""
        return self.archive.findings(self.id)

    @property
    def tags(self) -> tuple[str, ...]:
        """Tags that the run has now."""
        return self.archive.tags(self.id)

    def unit_columns(self) -> Mapping[str, UnitColumn]:
        """Return the signals, and the corrected wear where the run was corrected, each with its SI unit."""
        corrected = "drift_correction" in self.archive.step_names(self.id)
        return (self.corrected if corrected else self.run).unit_columns()

    def to_datatree(self) -> Any:
        """Return the tables of `tribopipe export csv` as an xarray DataTree, one group per table.

        Takes the package xarray: pip install "tribopipe[xarray]".
        """
        return views().datatree(self)

    def __len__(self) -> int:
        return self.archive.outline(self.id).samples

    def __str__(self) -> str:
        steps = ", ".join(map(step_in_words, self.archive.step_names(self.id)))
        return f"run {self.id}: {steps or 'ingested'}"

    def __repr__(self) -> str:
        return f"<{self}>"

    def _drawable(self, fit: WearFit, step: Step) -> WearFit:
        return fit.fitted_to(self.corrected, lambda: archived_curves(step))

    def _under(self, laws: StepsByLaw) -> dict[str, Step]:
        steps = self.archive.steps(self.id)
        return {law: step for name, step in steps.items() if (law := laws.law_of(name)) is not None}


def archived_curves(step: Step | None) -> WearCurves | None:
    """Return the fitted or predicted wear curves of a step; none if the step has no curves."""
    if step is None or not step.curves or not isinstance(step.result, WearFit | WearPrediction):
        return None
    names = [name for name in step.curves if f"{name}_lower" in step.curves]
    lines = {name: [step.curves[f"{name}{end}"][0] for end in ("", "_lower", "_upper")] for name in names}
    return WearCurves(step.result, {name: Band(*three, unit=step.curves[name][1]) for name, three in lines.items()})

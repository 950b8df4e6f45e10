"""The outline of an archived run: all but its arrays, read in a time that is independent of its length."""

from collections.abc import Mapping
from dataclasses import dataclass

import h5py
import numpy as np

from tribopipe.archive import nexus
from tribopipe.archive.hdf5_compression import unpacked
from tribopipe.archive.long_recordings import recorded_samples
from tribopipe.archive.runfile import (
    members,
    read_environment,
    read_findings,
    read_manifest,
    read_marks,
    read_step_base,
)
from tribopipe.archive.step_names import Step, StepName, StepOutline, steps_among
from tribopipe.documents.annotation import Mark
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.signals import AXES, SIGNALS, SignalName
from tribopipe.results.finding import Finding
from tribopipe.results.run import Origin
from tribopipe.results.wear_fit import WearFit
from tribopipe.results.wear_prediction import Band, WearCurves, WearPrediction

_TAIL = 1000
"""Samples at the end of a run among which the last known value of an axis is looked for."""


@dataclass(frozen=True)
class SourceOutline:
    """A file as it came, without its bytes."""

    name: str
    size: int
    sha256: str


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
    step = read_step_base(entry, name)
    if step is None:
        return None
    return StepOutline(**vars(step), result_sha256=nexus.text(entry[name], "fingerprints/result_sha256"))


def _ends(entry: h5py.Group, names: list[SignalName]) -> dict[SignalName, float]:
    found = {name: _last(entry, name) for name in AXES if name in names}
    return {name: value for name, value in found.items() if value is not None}


def _last(entry: h5py.Group, name: SignalName) -> float | None:
    """Return the last known value of an axis, preprocessed or else raw; none where its end is missing."""
    cleaned = isinstance(entry.get(f"clean_up/data/{name}", getlink=True), h5py.HardLink)
    tail = unpacked(entry["clean_up/data" if cleaned else "raw"][name], last=_TAIL).astype(np.float64)
    known = tail[np.isfinite(tail)]
    return float(known[-1]) if known.size else None


def archived_curves(step: Step | None) -> WearCurves | None:
    """Return the fitted or predicted wear curves of a step; none if the step has no curves."""
    if step is None or not step.curves or not isinstance(step.result, WearFit | WearPrediction):
        return None
    names = [name for name in step.curves if f"{name}_lower" in step.curves]
    lines = {name: [step.curves[f"{name}{end}"][0] for end in ("", "_lower", "_upper")] for name in names}
    return WearCurves(step.result, {name: Band(*three, unit=step.curves[name][1]) for name, three in lines.items()})

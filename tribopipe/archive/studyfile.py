"""One study as a NeXus HDF5 file, studies/<id>.h5 in the archive folder.

/entry                NXentry, opens on its first curve
  definition          NeXus application definition that the file follows: see ``tribopipe.archive.definitions``
  archived            NXcollection: format of this file, fingerprint of all the study was made from
  process             NXprocess: program, version, date, environment (JSON)
  study, result       NXnote: JSON, from which the records come back to the last digit
  options             NXnote: JSON of the recipe that was used
  stands_on           NXnote: JSON of the fingerprint of each run, as ingested
  curve_000 …         NXdata: one body of a run under one law, with its 95 % band; measured wear next to it, if recorded
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import h5py
import numpy as np
from pydantic import TypeAdapter

from tribopipe.archive import nexus
from tribopipe.archive.formats import STUDY, STUDY_FORMAT, write_definition
from tribopipe.base.arrays import Column
from tribopipe.base.units import from_si, to_si
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.signals import SIGNALS
from tribopipe.documents.study import Study
from tribopipe.physics.laws import law_heading
from tribopipe.results.study import MeasuredCurve, StudyCurve, StudyResult
from tribopipe.version import VERSION

_RESULT: TypeAdapter[StudyResult] = TypeAdapter(StudyResult)
_TOLD = ("run_id", "model", "role", "body", "what")
_UNITS: Mapping[str, tuple[str, str, str]] = {
    "wear_depth": ("m", "um", "length"),
    "wear_volume": ("m^3", "mm^3", "volume"),
}
"""SI unit, unit in the file, and kind of number of what a curve is of."""


@dataclass(frozen=True)
class StudyOutline:
    """A study without its curves."""

    study: Study
    result: StudyResult
    inputs_sha256: str
    """Fingerprint of version, options, and the runs it stands on."""
    options: Mapping[str, Any]
    program_version: str
    date: str
    stands_on: Mapping[str, str] = field(default_factory=dict, kw_only=True)
    """Its runs, each with the SHA-256 of what was ingested. Nothing where the file does not state it."""
    environment: Mapping[str, str] = field(default_factory=dict, kw_only=True)
    """Versions and machine, from ``tribopipe.archive.provenance``; empty if the file does not state them."""


@dataclass(frozen=True)
class StoredStudy(StudyOutline):
    """A study as the archive keeps it."""

    curves: tuple[StudyCurve, ...]


def write_study(file: h5py.File, stored: StoredStudy) -> None:
    """Write a study into an empty file."""
    file.attrs.update(NX_class="NXroot", default="entry", creator="tribopipe", creator_version=VERSION)
    entry = nexus.group(file, "entry", "NXentry")
    nexus.field(entry, "title", stored.study.title or stored.study.id)
    write_definition(entry, STUDY, STUDY_FORMAT.version)
    nexus.field(entry, "identifier_study", stored.study.id)
    archived = nexus.group(entry, "archived", "NXcollection")
    nexus.field(archived, "format", str(STUDY_FORMAT))
    nexus.field(archived, "inputs_sha256", stored.inputs_sha256)
    process = nexus.group(entry, "process", "NXprocess")
    nexus.field(process, "program", "tribopipe")
    nexus.field(process, "version", stored.program_version)
    nexus.field(process, "date", stored.date)
    nexus.document(process, "environment", dict(stored.environment))
    nexus.document(entry, "study", stored.study)
    nexus.document(entry, "result", stored.result)
    nexus.document(entry, "options", dict(stored.options))
    nexus.document(entry, "stands_on", dict(stored.stands_on))
    for number, curve in enumerate(stored.curves):
        _write_curve(entry, f"curve_{number:03}", curve)
    if stored.curves:
        entry.attrs["default"] = "curve_000"


def _write_curve(entry: h5py.Group, name: str, curve: StudyCurve) -> None:
    first, *others = lines = _lines(curve)
    data = nexus.group(entry, name, "NXdata", signal=first, axes=[curve.along])
    data.attrs["auxiliary_signals"] = others
    data.attrs[f"{curve.along}_indices"] = 0
    body, law = spoken(curve.body), law_heading(curve.model)
    nexus.field(data, "title", f"{curve.run_id}, {body}: {curve.role} with {law}")
    for told in _TOLD:
        nexus.field(data, told, getattr(curve, told))
    nexus.field(data, curve.along, curve.places, SIGNALS[curve.along].unit)
    si, unit, _ = _UNITS[curve.what]
    for line, values in lines.items():
        nexus.field(data, line, np.asarray(from_si(values, si, unit)), unit)


def _lines(curve: StudyCurve) -> dict[str, Column]:
    """Return what a curve has at each place, what was measured first."""
    by_law = {"predicted": curve.predicted, "lower": curve.lower, "upper": curve.upper}
    if curve.measured is None:
        return by_law
    band = {"measurement_lower": curve.measured.lower, "measurement_upper": curve.measured.upper}
    return {"measured": curve.measured.best, **by_law, **band}


def read_study(file: h5py.File) -> StoredStudy:
    """Read a study."""
    outline, entry = read_study_outline(file), file["entry"]
    curves = tuple(_read_curve(entry[name]) for name in sorted(entry) if name.startswith("curve_"))
    return StoredStudy(**vars(outline), curves=curves)


def read_study_outline(file: h5py.File) -> StudyOutline:
    """Read a study without its curves."""
    entry = file["entry"]
    return StudyOutline(
        study=read_study_document(file),
        result=_RESULT.validate_json(nexus.text(entry, "result/data")),
        inputs_sha256=nexus.text(entry, "archived/inputs_sha256"),
        options=json.loads(nexus.text(entry, "options/data")),
        program_version=nexus.text(entry, "process/version"),
        date=nexus.text(entry, "process/date"),
        stands_on=nexus.text_mapping(entry, "stands_on"),
        environment=nexus.text_mapping(entry["process"], "environment"),
    )


def read_study_document(file: h5py.File) -> Study:
    """Read which runs a study fits and predicts."""
    return Study.model_validate_json(nexus.text(file, "entry/study/data"))


def _read_curve(data: h5py.Group) -> StudyCurve:
    told: dict[str, Any] = {name: nexus.text(data, name) for name in _TOLD}
    along = next(name for name in data if name in SIGNALS)
    _, unit, kind = _UNITS[told["what"]]

    def line(name: str) -> Column:
        return np.asarray(to_si(nexus.floats(data, name), unit, kind))

    measured = None
    if "measured" in data:
        measured = MeasuredCurve(line("measured"), line("measurement_lower"), line("measurement_upper"))
    by_law = {name: line(name) for name in ("predicted", "lower", "upper")}
    return StudyCurve(**told, along=along, places=nexus.floats(data, along), **by_law, measured=measured)  # type: ignore[arg-type]

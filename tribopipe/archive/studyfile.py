"""One study as a NeXus HDF5 file, studies/<id>.h5 in the archive folder.

/entry                NXentry, opens on its first curve
  definition          NeXus application definition that the file follows: see ``tribopipe.archive.definitions``
  archived            NXcollection: format of this file, fingerprint of all the study was made from
  process             NXprocess: program, version, date, environment (JSON)
  study, result       NXnote: JSON, from which the records come back to the last digit
  options             NXnote: JSON of the recipe that was used
  stands_on           NXnote: JSON of the fingerprint of each run, as ingested
  curve_000 …         NXdata: one run under one law, measured wear beside the law with both 95 % bands
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import h5py
import numpy as np
from pydantic import TypeAdapter

from tribopipe.archive import nexus
from tribopipe.archive.definitions.names import STUDY, write_definition
from tribopipe.archive.formats import STUDY_FORMAT
from tribopipe.base.units import from_si, to_si
from tribopipe.documents.study import Study
from tribopipe.physics.laws import law_heading, law_title
from tribopipe.results.agreement import StudyResult
from tribopipe.results.disc_agreement import TwinDiscStudyResult
from tribopipe.results.study_curves import DiscStudyCurve, StudyCurve
from tribopipe.version import VERSION

_RESULT: TypeAdapter[StudyResult | TwinDiscStudyResult] = TypeAdapter(StudyResult | TwinDiscStudyResult)
_DISC_TOLD = ("run_id", "model", "role", "disc")
_DISC_LINES = ("predicted", "lower", "upper")
_DEPTHS = ("predicted", "lower", "upper", "measurement_lower", "measurement_upper")


@dataclass(frozen=True)
class StudyOutline:
    """A study without its curves."""

    study: Study
    result: StudyResult | TwinDiscStudyResult
    inputs_sha256: str
    """Fingerprint of version, options, and the runs it stands on."""
    options: Mapping[str, Any]
    program_version: str
    date: str
    stands_on: Mapping[str, str] = field(default_factory=dict, kw_only=True)
    """Its runs, each with the SHA-256 of what was ingested. Nothing where the file does not say."""
    environment: Mapping[str, str] = field(default_factory=dict, kw_only=True)
    """What it was computed with, as ``tribopipe.base.environment`` tells it. Nothing where the file does not say."""


@dataclass(frozen=True)
class StoredStudy(StudyOutline):
    """A study as the archive keeps it."""

    curves: tuple[StudyCurve | DiscStudyCurve, ...]


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
        if isinstance(curve, DiscStudyCurve):
            _write_disc_curve(entry, f"curve_{number:03}", curve)
        else:
            _write_curve(entry, f"curve_{number:03}", curve)
    if stored.curves:
        entry.attrs["default"] = "curve_000"


def _write_curve(entry: h5py.Group, name: str, curve: StudyCurve) -> None:
    data = nexus.group(entry, name, "NXdata", signal="measured", axes=["sliding_distance"])
    data.attrs["auxiliary_signals"] = list(_DEPTHS)
    data.attrs["sliding_distance_indices"] = 0
    nexus.field(data, "title", f"{curve.run_id}: {curve.role} by {law_title(curve.model)}")
    for told in ("run_id", "model", "role"):
        nexus.field(data, told, getattr(curve, told))
    nexus.field(data, "sliding_distance", curve.sliding_distance, "m")
    for depth in ("measured", *_DEPTHS):
        nexus.field(data, depth, np.asarray(from_si(getattr(curve, depth), "m", "um")), "um")


def _write_disc_curve(entry: h5py.Group, name: str, curve: DiscStudyCurve) -> None:
    data = nexus.group(entry, name, "NXdata", signal="predicted", axes=["rotations"])
    data.attrs["auxiliary_signals"] = list(_DISC_LINES)[1:]
    data.attrs["rotations_indices"] = 0
    law = law_heading(curve.model)
    nexus.field(data, "title", f"{curve.run_id}, {curve.disc.replace('_', ' ')}: {curve.role} by {law}")
    for told in _DISC_TOLD:
        nexus.field(data, told, getattr(curve, told))
    nexus.field(data, "rotations", curve.rotations, "1")
    for line in _DISC_LINES:
        nexus.field(data, line, np.asarray(from_si(getattr(curve, line), "m^3", "mm^3")), "mm^3")


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
        stands_on=nexus.told(entry, "stands_on"),
        environment=nexus.told(entry["process"], "environment"),
    )


def read_study_document(file: h5py.File) -> Study:
    """Read which runs a study fits and predicts."""
    return Study.model_validate_json(nexus.text(file, "entry/study/data"))


def _read_curve(data: h5py.Group) -> StudyCurve | DiscStudyCurve:
    if "rotations" in data:
        told = {name: nexus.text(data, name) for name in _DISC_TOLD}
        lines = {name: to_si(nexus.floats(data, name), "mm^3", "volume") for name in _DISC_LINES}
        return DiscStudyCurve(**told, rotations=nexus.floats(data, "rotations"), **lines)  # type: ignore[arg-type]
    told = {name: nexus.text(data, name) for name in ("run_id", "model", "role")}
    depths = {name: to_si(nexus.floats(data, name), "um", "length") for name in ("measured", *_DEPTHS)}
    return StudyCurve(**told, sliding_distance=nexus.floats(data, "sliding_distance"), **depths)  # type: ignore[arg-type]

"""One run as a NeXus HDF5 file.

/entry                   NXentry, opens on ``wear``
  definition             NeXus application definition that the file follows: see ``tribopipe.archive.definitions``
  archived               NXcollection: format of this file, fingerprint of the raw content, what it was ingested with
  pin, disc              NXsample; or curved_disc, flat_disc
  conditions, end_values NXcollection: as run.toml states them, in SI
  instrument             NXinstrument with an NXsensor for each recorded signal
  source_files           NXcollection of NXnote: the bytes as they came, with their SHA-256
  manifest, findings     NXnote: JSON
  raw                    NXdata: the signals in SI; each states whether it was measured or derived
  recorded               NXdata: every sample of the measured signals, where those in raw are means; see ``recorded``
  extra_columns          NXcollection: what the files held in addition
  profiles               NXcollection of NXdata: height against position across wear tracks
  clean_up               NXprocess as those below; data are the columns that differ from the raw ones
  drift_correction, friction_fit, specific_wear, wear_fit_<law>, prediction_<law>
                         NXprocess: program, version, date, parameters and data; result, options, what the step
                         stands on and the environment it was computed in (JSON)
  local_wear_<law>       NXprocess as those above; course and fields are NXdata over sliding distance or rotations,
                         fields over the places of the surface in addition
  wear                   NXdata: the corrected wear of the pin with the fitted laws, for viewers
  marks                  NXnote: JSON; who marked the run bad, or took that back, when and why
  annotations            NXnote: JSON; tags and notes, each with who and when
  earlier_manifests      NXcollection of NXnote: what run.toml stated before it was amended; see ``earlier``
"""

import json
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from hashlib import sha256
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from pydantic import ValidationError

from tribopipe.archive import nexus
from tribopipe.archive.file_access import opened
from tribopipe.archive.formats import RUN_FORMAT, run_name, write_definition
from tribopipe.archive.hdf5_compression import unpacked, unpacked_pieces
from tribopipe.archive.long_recordings import read_recording, write_recorded
from tribopipe.archive.provenance import environment, raw_digest
from tribopipe.archive.remote import archive_path
from tribopipe.archive.step_names import (
    STEPS,
    WEAR_FITS,
    Fingerprints,
    Step,
    StepBase,
    StepName,
    Table,
    downstream,
    steps_among,
)
from tribopipe.base.arrays import Column
from tribopipe.base.errors import ArchiveError, NotInstalledError
from tribopipe.base.units import from_si
from tribopipe.documents.annotation import Annotation, Mark
from tribopipe.documents.contact import Specimen
from tribopipe.documents.contact_kinds import ASSUMED, contact_described, contacts, spoken
from tribopipe.documents.manifest import RunManifest, unknown_kind
from tribopipe.documents.preprocessing import CleanUp
from tribopipe.documents.record import Record
from tribopipe.documents.signals import SENSED, SIGNALS, SignalName
from tribopipe.results.finding import Finding
from tribopipe.results.run import ExtraColumn, Profile, RawRun, SourceFile, UnheldSource, with_cleaned
from tribopipe.version import VERSION

MANIFEST_TEXT = "entry/manifest/data"
"""Where a run's manifest is, as JSON."""
EARLIER = "earlier_manifests"
_A_DEPTH = re.compile("(wear_)?depth(_lower|_upper)?")
"""Curves of a fit that are depths of the pin, or of both discs together."""


def write_raw(file: h5py.File, run: RawRun, findings: Sequence[Finding]) -> None:
    """Write a run as ingested into an empty file."""
    file.attrs.update(NX_class="NXroot", default="entry", creator="tribopipe", creator_version=VERSION)
    entry = nexus.group(file, "entry", "NXentry", default="raw")
    manifest = run.manifest
    nexus.field(entry, "title", manifest.title or manifest.id)
    write_definition(entry, run_name(manifest.tribometer), RUN_FORMAT.version)
    if manifest.started is not None:
        nexus.field(entry, "start_time", manifest.started.isoformat())
    nexus.field(entry, "identifier_run", manifest.id)
    archived = nexus.group(entry, "archived", "NXcollection")
    nexus.field(archived, "format", str(RUN_FORMAT))
    nexus.field(archived, "raw_sha256", raw_digest(run))
    nexus.document(archived, "environment", environment())
    _write_people_and_things(entry, run)
    _write_sources(entry, run)
    nexus.document(entry, "manifest", manifest)
    nexus.document(entry, "findings", [finding.model_dump(mode="json") for finding in findings])
    _write_columns(entry, run)
    write_recorded(entry, run)
    _write_profiles(entry, run)


def _write_people_and_things(entry: h5py.Group, run: RawRun) -> None:
    manifest = run.manifest
    if manifest.operator:
        nexus.field(nexus.group(entry, "user", "NXuser"), "name", manifest.operator)
    instrument = nexus.group(entry, "instrument", "NXinstrument")
    nexus.field(instrument, "name", manifest.instrument or "tribometer")
    for sensed in SENSED:
        if sensed in run.columns:
            sensor = nexus.group(instrument, sensed, "NXsensor")
            nexus.field(sensor, "name", SIGNALS[sensed].meaning)
    for name, body in manifest.bodies.items():
        _write_specimen(entry, name, body)
    nexus.summary(nexus.group(entry, "conditions", "NXcollection"), manifest.conditions)
    nexus.summary(nexus.group(entry, "end_values", "NXcollection"), manifest.end_values)


def _write_specimen(entry: h5py.Group, name: str, body: Specimen) -> None:
    sample = nexus.group(entry, name, "NXsample")
    nexus.field(sample, "name", f"{body.material} {spoken(name)}")
    properties = nexus.group(sample, "properties", "NXcollection")
    nexus.summary(properties, body)


def _write_sources(entry: h5py.Group, run: RawRun) -> None:
    sources = nexus.group(entry, "source_files", "NXcollection")
    for number, source in enumerate(run.sources):
        note = nexus.group(sources, f"file_{number}", "NXnote")
        nexus.field(note, "file_name", source.name)
        nexus.field(note, "type", "application/octet-stream")
        _write_bytes(note, source)
        nexus.field(note, "checksum", source.sha256)
        nexus.field(note, "algorithm", "sha256")
        if source.name in run.headers:
            nexus.field(note, "description", run.headers[source.name])


def _write_bytes(note: h5py.Group, source: SourceFile) -> None:
    """Write the bytes of a file as they come. Raises ``TribopipeError`` where they are not those that were read."""
    try:
        pieces = (np.frombuffer(piece, np.uint8) for piece in source.pieces())
        nexus.long_field(note, "data", pieces, source.size, np.uint8)
    except ValueError:
        raise ArchiveError(
            f"{source.name}: found that the size, initially {source.size:,} bytes, changed during archiving; expected "
            "a file that does not change; try again when the test has ended"
        ) from None


def _write_columns(entry: h5py.Group, run: RawRun) -> None:
    signal = next((name for name in ("depth", "friction_coefficient") if name in run.columns), None)
    axis = run.manifest.progress.signal
    others = [name for name in run.columns if name not in (axis, signal)]
    raw = nexus.group(entry, "raw", "NXdata", axes=[axis])
    raw.attrs[f"{axis}_indices"] = 0
    raw.attrs["signal"] = signal or others[0]
    if signal:
        raw.attrs["auxiliary_signals"] = others
    for name, values in run.columns.items():
        nexus.field(raw, name, values, SIGNALS[name].unit, origin=run.origins[name], long_name=SIGNALS[name].axis)
    if run.extras:
        collection = nexus.group(entry, "extra_columns", "NXcollection")
        for number, (label, extra) in enumerate(run.extras.items()):
            nexus.field(collection, f"column_{number}", extra.values, column_name=label, column_unit=extra.unit or "")


def _write_profiles(entry: h5py.Group, run: RawRun) -> None:
    if not run.profiles:
        return
    profiles = nexus.group(entry, "profiles", "NXcollection")
    for number, (name, profile) in enumerate(run.profiles.items()):
        data = nexus.group(profiles, f"profile_{number}", "NXdata", signal="height", axes=["position"])
        data.attrs["position_indices"] = 0
        nexus.field(data, "title", name)
        nexus.field(data, "position", profile.position, "m", long_name="position across the wear track (m)")
        nexus.field(data, "height", profile.height, "m", long_name="height, positive outward from the body (m)")
        if profile.across is not None:
            nexus.field(
                data, "across", profile.across, "m", long_name="position of the scan line in its height map (m)"
            )
            nexus.field(data, "scan", profile.scan)


def read_manifest(file: h5py.File) -> RunManifest:
    """Read a run's manifest.

    Raises ``NotInstalledError`` where the package that adds its kind of contact is not installed.
    """
    text = nexus.text(file, MANIFEST_TEXT)
    try:
        return RunManifest.model_validate_json(text)
    except ValidationError:
        if (kind := unknown_kind(json.loads(text))) is None:
            raise
        raise NotInstalledError(
            f"{file.filename}: found the contact kind {kind!r}, which is not installed; expected one of "
            f"{', '.join(contacts())}; install the package that provides it"
        ) from None


def read_raw(file: h5py.File) -> RawRun:
    """Read a run as it was ingested; the bytes of its source files stay where they are until they are asked for."""
    entry = file["entry"]
    raw = entry["raw"]
    columns = _read_signals(raw)
    headers: dict[str, str] = {}
    sources = []
    for note in members(entry["source_files"]):
        sources.append(_read_source(note))
        if "description" in note:
            headers[sources[-1].name] = nexus.text(note, "description")
    return RawRun(
        manifest=read_manifest(file),
        columns=columns,
        origins={name: raw[name].attrs["origin"] for name in columns},
        extras=dict(_read_extras(entry)),
        headers=headers,
        sources=tuple(sources),
        profiles=_read_profiles(entry),
        recording=read_recording(entry),
    )


def members(group: h5py.Group) -> Iterator[Any]:
    """Yield the members of a group; ``values`` of h5py gives None for parts of the file that cannot be read."""
    return (group[name] for name in group)


def _read_source(note: h5py.Group) -> SourceFile:
    """Read what a source file is."""
    data, checksum = note["data"], nexus.text(note, "checksum")
    read = partial(_source_again, archive_path(note.file.filename), note.name, checksum)
    return UnheldSource(nexus.text(note, "file_name"), int(data.size), checksum, read)


def _source_again(path: Path, part: str, checksum: str) -> Iterator[bytes]:
    """Read the bytes of a source file. Raises ``ArchiveError`` where the archived file is another one by now."""
    with opened(path) as file:
        if nexus.text(file, f"{part}/checksum") != checksum:
            raise ArchiveError(
                f"{path}: found that {part} has changed since it was read; expected an unchanged file; run the command "
                "again"
            )
        yield from source_pieces(file[part]["data"])


def source_pieces(data: h5py.Dataset) -> Iterator[bytes]:
    """Give the bytes of a source file, of which few are in memory at once."""
    for piece in unpacked_pieces(data):
        yield piece.astype(np.uint8).tobytes()


def source_sha256(data: h5py.Dataset) -> str:
    """Return the checksum of the bytes of a source file."""
    found = sha256()
    for piece in source_pieces(data):
        found.update(piece)
    return found.hexdigest()


def _read_signals(raw: h5py.Group) -> dict[SignalName, Column]:
    """Read the signals of a run. Raises ``ValueError`` where they are not columns of one length."""
    columns = {name: nexus.floats(raw, name) for name in SIGNALS if name in raw}
    if len({values.shape for values in columns.values()}) != 1 or next(iter(columns.values())).ndim != 1:
        raise ValueError(f"signals of different lengths in {raw.name}")
    return columns


def read_cleaned(file: h5py.File) -> RawRun:
    """Read a run with its preprocessed signals; as ingested where they were not."""
    run, step = read_raw(file), read_step(file["entry"], "clean_up")
    if step is None or not isinstance(step.result, CleanUp):
        return run
    columns = {name: step.curves[name][0] for name in SIGNALS if name in step.curves}
    return with_cleaned(run, step.result, columns)


def _read_profiles(entry: h5py.Group) -> dict[str, Profile]:
    kept = members(entry["profiles"]) if "profiles" in entry else ()
    return {nexus.text(data, "title"): _read_profile(data) for data in kept}


def _read_profile(data: h5py.Group) -> Profile:
    profile = Profile(nexus.floats(data, "position"), nexus.floats(data, "height"))
    if "across" not in data:
        return profile
    return replace(profile, across=float(nexus.floats(data, "across")), scan=nexus.text(data, "scan"))


def _read_extras(entry: h5py.Group) -> Iterator[tuple[str, ExtraColumn]]:
    if "extra_columns" not in entry:
        return
    for column in members(entry["extra_columns"]):
        values = column.asstr()[()] if h5py.check_string_dtype(column.dtype) else unpacked(column)
        yield column.attrs["column_name"], ExtraColumn(np.asarray(values), column.attrs["column_unit"] or None)


def write_step(entry: h5py.Group, step: Step) -> None:
    """Append a step with its result, curves and tables."""
    process = nexus.group(entry, step.name, "NXprocess")
    nexus.field(process, "program", "tribopipe")
    nexus.field(process, "version", step.program_version)
    nexus.field(process, "date", step.date)
    nexus.field(process, "sequence_index", [*STEPS, step.name].index(step.name) + 1)
    fingerprints = nexus.group(process, "fingerprints", "NXparameters")
    nexus.field(fingerprints, "inputs_sha256", step.inputs_sha256)
    nexus.field(fingerprints, "result_sha256", step.result_sha256)
    nexus.document(process, "result", step.result)
    nexus.document(process, "options", dict(step.options))
    nexus.document(process, "stands_on", dict(step.stands_on))
    nexus.document(process, "environment", dict(step.environment))
    nexus.summary(nexus.group(process, "parameters", "NXparameters"), step.result)
    if step.curves:
        _write_curves(process, step)
    for name, table in step.tables.items():
        _write_table(process, name, table)


def _write_curves(process: h5py.Group, step: Step) -> None:
    first, *others = step.curves
    data = _against_axis(process, "data", first, own=step.curves)
    if others:
        data.attrs["auxiliary_signals"] = others
    for name, (values, unit) in step.curves.items():
        nexus.field(data, name, values, unit)


def _write_table(process: h5py.Group, name: str, table: Table) -> None:
    first, *others = table.arrays
    data = nexus.group(process, name, "NXdata", signal=first, axes=list(table.axes))
    if others:
        data.attrs["auxiliary_signals"] = others
    for place, axis in enumerate(table.axes):
        data.attrs[f"{axis}_indices"] = place
    for arrays in table:
        for array, (values, unit) in arrays.items():
            nexus.field(data, array, values, unit)


def _read_tables(process: h5py.Group) -> Iterator[tuple[str, Table]]:
    for name, data in zip(process, members(process), strict=True):
        if data.attrs.get("NX_class") == "NXdata" and name != "data":
            yield name, Table(_read_arrays(data, data.attrs["axes"]), _read_arrays(data, _signals(data)))


def _signals(data: h5py.Group) -> list[str]:
    return [data.attrs["signal"], *data.attrs.get("auxiliary_signals", [])]


def _read_arrays(data: h5py.Group, names: Iterable[str]) -> dict[str, tuple[Column, str]]:
    return {str(name): (nexus.floats(data, name), str(data[name].attrs["units"])) for name in names}


def _against_axis(parent: h5py.Group, name: str, signal: str, own: Collection[str] = ()) -> h5py.Group:
    """Add a group for a plot against sliding distance or rotations, preprocessed or else raw.

    A group that has the axis among its ``own`` members is plotted against the number of the sample.
    """
    entry = parent.file["entry"]
    (axis,) = entry["raw"].attrs["axes"]
    if axis in own:
        return nexus.group(parent, name, "NXdata", signal=signal, axes=["."])
    data = nexus.group(parent, name, "NXdata", signal=signal, axes=[axis])
    data.attrs[f"{axis}_indices"] = 0
    mended = isinstance(entry.get(f"clean_up/data/{axis}", getlink=True), h5py.HardLink)
    data[axis] = h5py.SoftLink(f"/entry/{'clean_up/data' if mended else 'raw'}/{axis}")
    return data


def read_fingerprints(entry: h5py.Group, name: StepName) -> Fingerprints | None:
    """Read what a step was made from and what it found; none where the run has not been through it."""
    if name not in entry:
        return None
    stored = entry[name]["fingerprints"]
    return Fingerprints(nexus.text(stored, "inputs_sha256"), nexus.text(stored, "result_sha256"))


def read_result(entry: h5py.Group, name: StepName) -> Record | None:
    """Read the result of a step without its curves; none where the run has not been through it."""
    if name not in entry:
        return None
    return STEPS[name].parse(nexus.text(entry[name], "result/data"))


def read_step(entry: h5py.Group, name: StepName) -> Step | None:
    """Read a step with its curves; none where the run has not been through it."""
    base = read_step_base(entry, name)
    if base is None:
        return None
    process = entry[name]
    return Step(
        **vars(base),
        curves=_read_arrays(process["data"], _signals(process["data"])) if "data" in process else {},
        tables=dict(_read_tables(process)),
        stands_on=nexus.text_mapping(process, "stands_on"),
    )


def read_step_base(entry: h5py.Group, name: StepName) -> StepBase | None:
    """Read a step without its curves and tables; none where the run has not been through it."""
    if name not in entry:
        return None
    process = entry[name]
    return StepBase(
        name=name,
        result=STEPS[name].parse(nexus.text(process, "result/data")),
        inputs_sha256=nexus.text(process, "fingerprints/inputs_sha256"),
        options=json.loads(nexus.text(process, "options/data")),
        program_version=nexus.text(process, "version"),
        date=nexus.text(process, "date"),
        environment=nexus.text_mapping(process, "environment"),
    )


def read_environment(entry: h5py.Group) -> dict[str, str]:
    """Read what the run was ingested with; empty where the file does not state it."""
    return nexus.text_mapping(entry["archived"], "environment")


def write_marks(entry: h5py.Group, marks: Sequence[Mark]) -> None:
    """Write the history of marks, oldest first."""
    nexus.document(entry, "marks", [mark.model_dump(mode="json") for mark in marks])


def read_marks(entry: h5py.Group) -> list[Mark]:
    """Read the history of marks, oldest first; empty where the run was never marked."""
    return nexus.listed(entry, "marks", Mark)


def write_annotations(entry: h5py.Group, annotations: Sequence[Annotation]) -> None:
    """Write the history of tags and notes, oldest first."""
    nexus.document(entry, "annotations", [annotation.model_dump(mode="json") for annotation in annotations])


def read_annotations(entry: h5py.Group) -> list[Annotation]:
    """Read the history of tags and notes, oldest first; empty where there is none."""
    return nexus.listed(entry, "annotations", Annotation)


def read_findings(entry: h5py.Group) -> list[Finding]:
    """Read what the checks found when the run was ingested."""
    return nexus.listed(entry, "findings", Finding)


def write_wear_plot(entry: h5py.Group) -> None:
    """Write the group that viewers open first: corrected wear and the fitted laws, µm against m or rotations.

    Wear of the pin, or of both discs together; of two discs without a depth signal, the laws alone.
    """
    drawn = [name for name in steps_among(entry) if _is_drawn(name)]
    curves = wear_curves({name: step for name in drawn if (step := read_step(entry, name)) is not None})
    if not curves:
        return
    wear = _against_axis(entry, "wear", next(iter(curves)))
    if len(curves) > 1:
        wear.attrs["auxiliary_signals"] = list(curves)[1:]
    contact = contact_described(json.loads(nexus.text(entry, "manifest/data")).get("contact")) or ASSUMED
    worn = contact.fitted_bodies[0] if contact.tip_role else "two discs"
    nexus.field(wear, "title", f"Wear of the {worn}, run {nexus.text(entry, 'identifier_run')}")
    for name, values in curves.items():
        nexus.field(wear, name, values, "um")
    entry.attrs["default"] = "wear"


def wear_curves(steps: Mapping[StepName, Step]) -> dict[str, Column]:
    """Return what that group plots by name, µm: the corrected wear first, then the laws that were fitted."""
    correction = steps["drift_correction"].curves if "drift_correction" in steps else {}
    wanted = [name for name in ("pin_wear_depth", "wear_depth") if name in correction]
    curves = {name: correction[name][0] for name in wanted[:1]}
    for step_name, step in steps.items():
        law = WEAR_FITS.law_of(step_name) or ""
        for name, (values, _) in step.curves.items() if law else ():
            if _A_DEPTH.fullmatch(name):
                curves[law + name.removeprefix("wear_").removeprefix("depth")] = values
    return {name: np.asarray(from_si(values, "m", "um")) for name, values in curves.items()}


def _is_drawn(name: StepName) -> bool:
    return name == "drift_correction" or WEAR_FITS.law_of(name) is not None


def dropped_by(step: Step, entry: h5py.Group) -> set[str]:
    """Return what a step takes the place of: an earlier one of its name, and what stood on another result of that."""
    before = read_fingerprints(entry, step.name)
    changed = bool(step.curves) if before is None else before.result != step.result_sha256
    return {step.name, *(downstream(step.name, steps_among(entry)) if changed else ())}


def left_out_with(dropped: set[str]) -> set[str]:
    """Return members of an entry that go, and with them the plot of what they are drawn from."""
    # Clean-up makes the axis of what is drawn.
    plotted = any(name == "clean_up" or _is_drawn(name) for name in dropped)
    return dropped | {"wear"} if plotted else dropped


def copy_except(source: h5py.File, target: h5py.File, dropped: set[str]) -> h5py.Group:
    """Copy a run file but for some members of its entry, and the plot of them; what is copied keeps its bytes."""
    left_out = left_out_with(dropped)
    target.attrs.update(source.attrs)
    entry = nexus.group(target, "entry", "NXentry")
    entry.attrs.update(source["entry"].attrs)
    for name in source["entry"]:
        if name not in left_out:
            source.copy(f"entry/{name}", entry, name=name)
    return entry


def copy_additions(source: h5py.File, entry: h5py.Group, *, steps: bool) -> None:
    """Copy what a run file gained since it was ingested into another one's entry, with its steps or without."""
    noted = [name for name in ("marks", "annotations", EARLIER) if name in source["entry"]]
    for name in (*(steps_among(source["entry"]) if steps else ()), *noted):
        source.copy(f"entry/{name}", entry, name=name)

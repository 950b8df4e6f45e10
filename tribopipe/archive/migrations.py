"""What lies between one format of archived files and the next: a step for each version.

Format 2 has a seal, which whoever writes a file sees to, and may say of each step and study what it stands on and what
it was computed with. Fingerprints of format 1 were first counted with all that is null, and are all counted without.
Format 3 names the NeXus application definition that a file follows. Before, two zero offsets of a depth sensor were
shown as the ends of an interval.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias

import h5py

from tribopipe.archive import nexus
from tribopipe.archive.definitions.names import RUNS, STUDY, write_definition
from tribopipe.archive.digest import Part, columns_and_sources, digest
from tribopipe.archive.formats import RUN_FORMAT, STUDY_FORMAT
from tribopipe.archive.runfile import read_manifest, read_raw, read_step, source_sha256
from tribopipe.archive.steps import STEPS, StepName, inputs_digest, steps_among
from tribopipe.documents.record import Record

Migration: TypeAlias = Callable[[h5py.File, h5py.File], set[str]]
"""Writes an open file into an empty one as the next format has it; returns the paths of all that is not as it was,
with what lies below them. Raises ``ValueError`` where what it finds is damaged."""


def _run_to_2(old: h5py.File, new: h5py.File) -> set[str]:
    """Write a run of format 1 as one of format 2: steps say what they stand on where that is certain."""
    changed = _copied(old, new, "tribopipe.archive/2")
    entry, run = new["entry"], read_raw(old)
    changed |= _with_checksums(entry)
    changed |= _recounted(entry, "archived/raw_sha256", run.manifest, "manifest/data", columns_and_sources(run))
    steps = {name: step for name in steps_among(old["entry"]) if (step := read_step(old["entry"], name)) is not None}
    for name, step in steps.items():
        path = f"{name}/fingerprints/result_sha256"
        changed |= _recounted(entry, path, step.result, f"{name}/result/data", step.arrays)
    for name, step in steps.items():
        stands_on = _stands_on(entry, name)
        if inputs_digest(step.program_version, name, step.options, stands_on) == step.inputs_sha256:
            nexus.document(entry[name], "stands_on", stands_on)
            changed.add(f"entry/{name}/stands_on")
    return changed


def _study_to_2(old: h5py.File, new: h5py.File) -> set[str]:
    """Write a study of format 1 as one of format 2: what it stands on is said by its runs alone, and left out."""
    return _copied(old, new, "tribopipe.archive.study/2")


def _run_to_3(old: h5py.File, new: h5py.File) -> set[str]:
    """Write a run of format 2 as one of format 3: it names its definition, and shows no list as an interval."""
    changed = _copied(old, new, "tribopipe.archive/3")
    write_definition(new["entry"], RUNS[read_manifest(old).tribometer], 3)
    shown = {f"entry/{name}/parameters/joint_zero_offsets_{end}" for name in new["entry"] for end in ("lower", "upper")}
    taken = {path for path in shown | {f"{path}_errors" for path in shown} if path in new}
    for path in taken:
        del new[path]
    return changed | {"entry/definition"} | taken


def _study_to_3(old: h5py.File, new: h5py.File) -> set[str]:
    """Write a study of format 2 as one of format 3: it names its definition."""
    changed = _copied(old, new, "tribopipe.archive.study/3")
    write_definition(new["entry"], STUDY, 3)
    return changed | {"entry/definition"}


def _copied(old: h5py.File, new: h5py.File, written_as: str) -> set[str]:
    """Copy all of a file, and say its format."""
    new.attrs.update(old.attrs)
    old.copy("entry", new, name="entry")
    new["entry/archived/format"][()] = written_as
    return {"entry/archived/format"}


def _with_checksums(entry: h5py.Group) -> set[str]:
    """Give the sources checksums where they have none, as in the first files of format 1; return the paths of those.

    Raises ``ValueError`` where a source is not what was read.
    """
    added = set()
    for number, note in enumerate(entry["source_files"].values()):
        sha256 = source_sha256(note["data"])
        if "checksum" not in note:
            nexus.field(note, "checksum", sha256)
            nexus.field(note, "algorithm", "sha256")
            added |= {f"entry/source_files/file_{number}/{name}" for name in ("checksum", "algorithm")}
        elif nexus.text(note, "checksum") != sha256:
            raise ValueError(f"the checksum of {nexus.text(note, 'file_name')} is not that of its bytes")
    return added


def _recounted(entry: h5py.Group, path: str, record: Record, json: str, parts: Sequence[Part]) -> set[str]:
    """Count the fingerprint of a record, and of what belongs to it, as all are now; return the path if it is another.

    Raises ``ValueError`` where the one that is there was counted neither so nor in the first way.
    """
    stored, counted = nexus.text(entry, path), digest(record, *parts)
    if stored == counted:
        return set()
    if stored != digest(nexus.text(entry, json), *parts):
        raise ValueError(f"{path} is not the fingerprint of what is there")
    entry[path][()] = counted
    return {f"entry/{path}"}


def _stands_on(entry: h5py.Group, name: StepName) -> dict[str, str]:
    """Return what a step stands on within its run, each with its fingerprint."""
    stands_on = {"raw": nexus.text(entry, "archived/raw_sha256")}
    for base in STEPS[name].stands_on:
        stands_on[base] = nexus.text(entry, f"{base}/fingerprints/result_sha256") if base in entry else ""
    return stands_on


MIGRATIONS: Mapping[str, Mapping[int, Migration]] = {
    RUN_FORMAT.kind: {1: _run_to_2, 2: _run_to_3},
    STUDY_FORMAT.kind: {1: _study_to_2, 2: _study_to_3},
}
"""For each kind of file, how one of a version becomes one of the next."""

"""One study of the archive: its document, its result and curves, and the runs it stands on."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import h5py

from tribopipe.archive import nexus
from tribopipe.archive.digest import digest
from tribopipe.archive.studyfile import read_study
from tribopipe.documents.recipe import LawName
from tribopipe.pipeline.studies import known_by
from tribopipe.pipeline.verify.look import Look


@dataclass(frozen=True)
class SeenStudy:
    """What other files of the archive have to agree with."""

    stands_on: Mapping[str, str] = field(default_factory=dict)
    """SHA-256 of what was ingested of each of its runs."""
    references: tuple[str, ...] = ()
    """What predictions call it that were made with its k_D."""
    found: Mapping[LawName, str] = field(default_factory=dict)
    """SHA-256 of the k_D that it found under each law."""


def look_into_study(file: h5py.File, look: Look, study_id: str) -> SeenStudy:
    """Hold all that a study's file states about each other."""
    stored = read_study(file)
    look.named(study_id, nexus.text(file, "entry/identifier_study"), stored.study.id)
    left_out, runs = stored.result.left_out, stored.stands_on.values()
    if runs and stored.inputs_sha256 != digest(stored.program_version, stored.study, stored.options, *left_out, *runs):
        look.error("inputs", "found inputs that differ from those of the study; expected those of its SHA-256")
    fit = stored.study.fit
    return SeenStudy(
        stored.stands_on,
        (f"study {study_id}", *(fit if len(fit) == 1 else ())),
        {law.model: digest(*known_by(law).parts) for law in stored.result.laws},
    )

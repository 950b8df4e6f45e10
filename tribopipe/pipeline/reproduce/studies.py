"""A study computed again, from the runs as ingested on."""

from collections.abc import Mapping
from dataclasses import asdict
from io import BytesIO
from typing import Any

import h5py

from tribopipe.archive.store import Archive
from tribopipe.archive.studyfile import StoredStudy, read_study, write_study
from tribopipe.base.errors import ArchiveError
from tribopipe.pipeline.reproduce.comparing import redo
from tribopipe.pipeline.reproduce.redone import Reproduction
from tribopipe.pipeline.step_definitions import recipe_of
from tribopipe.pipeline.studies import PlannedStudy, planned_study


def reproduce_study(archive: Archive, study_id: str) -> Reproduction:
    """Evaluate a study again, by its own options, on the runs as they were ingested.

    Raises ``ArchiveError`` where there is no such study, or its file cannot be read.
    """
    stored = archive.study(study_id)

    def compute() -> Mapping[str, Any]:
        return _told(_as_archived(_planned_again(archive, stored).take()))

    versions = stored.environment or {"tribopipe": stored.program_version}
    return Reproduction(study_id, "study", (redo("study", _told(stored), compute, versions),))


def _planned_again(archive: Archive, stored: StoredStudy) -> PlannedStudy:
    """Plan a study again. Raises ``TribopipeError`` where its runs are gone, or are not the same any more."""
    planned = planned_study(archive, stored.study, recipe_of(stored.options))
    if tuple(planned.left_out) != stored.result.left_out:
        raise ArchiveError(
            f"study {stored.study.id}: found different runs marked bad from those at its evaluation; expected the "
            "same; run the study again"
        )
    changed = [run_id for run_id, sha256 in stored.stands_on.items() if planned.stands_on.get(run_id) != sha256]
    if changed:
        raise ArchiveError(
            f"study {stored.study.id}: found content of {', '.join(changed)} that differs from that at its evaluation; "
            "expected the same; run the study again"
        )
    return planned


def _as_archived(study: StoredStudy) -> StoredStudy:
    """Return a study as it is read back: its curves are written in µm and mm³, which rounds them."""
    with h5py.File(BytesIO(), "w", track_order=True) as file:
        write_study(file, study)
        return read_study(file)


def _told(study: StoredStudy) -> Mapping[str, Any]:
    return {"result": study.result, "curves": [asdict(curve) for curve in study.curves]}

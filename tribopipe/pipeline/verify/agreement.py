"""Whether files agree with each other: studies with their runs, predictions with the k_D they were made with."""

from collections.abc import Iterator, Mapping
from typing import TypeAlias

from tribopipe.documents.recipe import LawName
from tribopipe.pipeline.verify.look import Look
from tribopipe.pipeline.verify.runs import Borrowed, SeenRun
from tribopipe.pipeline.verify.studies import SeenStudy

Seen: TypeAlias = Mapping[str, SeenRun | SeenStudy]
"""By the id of the run, or by "study " and its id."""


def check_agreement(look: Look, mine: SeenRun | SeenStudy, seen: Seen) -> None:
    """Note where a file stands on something else than the archive holds."""
    if isinstance(mine, SeenStudy):
        for run_id, raw_sha256 in mine.stands_on.items():
            _check_member(look, run_id, raw_sha256, seen.get(run_id))
        return
    for borrowed in mine.borrowed:
        _check_borrowed(look, borrowed, set(_known(borrowed.reference, borrowed.law, seen)))


def _check_member(look: Look, run_id: str, raw_sha256: str, run: SeenRun | SeenStudy | None) -> None:
    if not isinstance(run, SeenRun):
        message = f"found that it is based on the run {run_id}, which could not be read; expected it in the archive"
        look.note("study", message, "restore that run if it should be there")
    elif raw_sha256 in run.earlier:
        message = f"found that it is based on {run_id} before its run.toml was amended; expected the current version"
        look.warning("study", message, "run the study again")
    elif run.raw_sha256 != raw_sha256:
        message = (
            f"found that it is based on a different run {run_id} from the one in the archive; expected the same one"
        )
        look.warning("study", message, "run the study again")


def _check_borrowed(look: Look, borrowed: Borrowed, known: set[str]) -> None:
    part = f"/entry/{borrowed.step}"
    if not known:
        message = f"found a prediction from {borrowed.reference}, whose k_D is not there; expected it in the archive"
        look.note("reference", message, "process it if it should be there", part)
    elif borrowed.sha256 not in known:
        message = (
            f"found a prediction from a k_D other than the current one of {borrowed.reference}; expected the current "
            "one"
        )
        look.warning("reference", message, "process both runs again, or run their study again", part)


def _known(reference: str, law: LawName, seen: Seen) -> Iterator[str]:
    """Return the SHA-256 of each k_D that a prediction may have been made with."""
    for name, one in seen.items():
        called = one.references if isinstance(one, SeenStudy) else (name,)
        if reference in called and law in one.found:
            yield one.found[law]

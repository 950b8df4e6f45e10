"""Verification of an archive: every file, what the files state about each other, and what lies around them.

Of each file its bytes, its format and all that it holds are checked.

If asked, every step is computed again from what was ingested, and compared with what is archived.
"""

from collections.abc import Callable, Collection
from dataclasses import dataclass
from functools import partial
from pathlib import Path, PurePosixPath
from typing import Any, NamedTuple

from tribopipe.archive.file_access import opened
from tribopipe.archive.file_signature import STUDIES, SUFFIX, Stamp, stamps
from tribopipe.archive.formats import RUN_FORMAT, STUDY_FORMAT, check_format
from tribopipe.archive.seal import check_every_byte, is_sealed
from tribopipe.archive.store import Archive
from tribopipe.base.errors import ArchiveError, TribopipeError, counted, did_you_mean
from tribopipe.base.executor import ALONE, Crew, in_turn
from tribopipe.base.failures import mended_by
from tribopipe.base.files import natural_order
from tribopipe.pipeline.recomputed_values import Redone
from tribopipe.pipeline.reproduce import reproduce, reproduce_study
from tribopipe.pipeline.verify.contents import SeenRun, SeenStudy, check_agreement, look_into_run, look_into_study
from tribopipe.pipeline.verify.file_findings import CheckName, Look
from tribopipe.pipeline.verify.folder import look_around, look_into_catalogue
from tribopipe.pipeline.verify.history import look_into_history
from tribopipe.pipeline.verify.nexus import check_nexus, read_tree
from tribopipe.results.finding import Finding


def recompute(archive: Archive, name: str) -> Look:
    """Return which steps of a run, or whether a study, come out other than they are archived, by their file's path."""
    look, called = Look(name), PurePosixPath(name).stem
    try:
        redone = (reproduce_study if _is_study(name) else reproduce)(archive, called)
    except TribopipeError as error:
        look.refused("recompute", error)
        return look
    for step in redone.steps:
        if not step.same:
            _tell(look, called, step)
    return look


def _tell(look: Look, name: str, step: Redone) -> None:
    part = "" if step.name == "study" else f"/entry/{step.name}"
    if step.outcome == "not compared":
        look.note(
            "recompute", f"found nothing to compare ({step.why}); expected the recomputed step", "process the run", part
        )
        return
    first, count = step.differences[0], len(step.differences)
    changed = ", ".join(f"{what} {then}, now {now}" for what, (then, now) in step.environment.items())
    message = (
        f"found {count} of {step.compared} recomputed values that differ, the largest difference in {first.where}: "
        f"archived {first.then}, now {first.now}{f' (computed with {changed})' if changed else ''}; expected the same "
        "values"
    )
    look.warning("recompute", message, f"`tribopipe reproduce {name}` lists them all", part)


def look_at(archive: Path, name: str) -> tuple[Look, SeenRun | SeenStudy | None]:
    """Look at a file of the archive by its path in it; return what was found, and what other files have to agree with.

    Damage of one file is given in what was found, never raised.
    """
    look, path = Look(name), archive / name
    if path.is_symlink():
        look.note(
            "file",
            "found a link; expected the file itself",
            "keep the target of the link for as long as the archive",
            "",
        )
    try:
        return look, _look_inside(path, look)
    except ArchiveError as error:
        look.refused("content", error)
    except OSError as error:
        why = f"cannot be read ({error.strerror or error}); expected a readable file"
        look.error("file", why, mended_by(error.errno or 0))
    return look, None


def _look_inside(path: Path, look: Look) -> SeenRun | SeenStudy | None:
    if is_sealed(path):
        try:
            check_every_byte(path)
        except ArchiveError as error:
            look.refused("seal", error)
            return None
    is_study = look.name.startswith(f"{STUDIES}/")
    with opened(path) as file:
        check_format(file, path, STUDY_FORMAT if is_study else RUN_FORMAT)
        check_nexus(read_tree(file, look), look)
        return (look_into_study if is_study else look_into_run)(file, look, path.stem)


Advance = Callable[[str], None]
_ROUNDS = 5
"""How often what was replaced meanwhile is looked at again."""


@dataclass(frozen=True)
class Verified:
    """Result of a verification."""

    runs: int
    studies: int
    size: int
    """Total size of the verified files, bytes."""
    recomputed: bool
    findings: tuple[Finding, ...]
    lines: int
    """Number of lines of the history."""
    head: str
    """Hash of its last line: kept elsewhere, it shows whether the whole archive was rolled back to an earlier state."""

    @property
    def sound(self) -> bool:
        """Whether nothing was found but notes."""
        return all(finding.severity == "note" for finding in self.findings)

    def __str__(self) -> str:
        files = f"{counted(self.runs, 'run')} and {counted(self.studies, 'study', 'studies')}"
        errors, warnings = (sum(one.severity == kind for one in self.findings) for kind in ("error", "warning"))
        verdict = "sound" if self.sound else f"{counted(errors, 'error')}, {counted(warnings, 'warning')}"
        done = "verified and recomputed" if self.recomputed else "verified"
        return f"{files}, {self.size / 1e6:.3g} MB, {done}: {verdict}"

    def as_json(self) -> dict[str, Any]:
        """Return it as JSON types."""
        told = {name: getattr(self, name) for name in ("sound", "runs", "studies", "size", "recomputed", "head")}
        return told | {"findings": [finding.model_dump(mode="json") for finding in self.findings]}


class _Looked(NamedTuple):
    """How a file looked, and what was found in it."""

    stamp: Stamp
    look: Look
    seen: SeenRun | SeenStudy | None


def verify(
    archive: Archive,
    run_ids: Collection[str] = (),
    *,
    again: bool = False,
    against: str = "",
    advance: Advance = lambda _: None,
    crew: Crew = ALONE,
) -> Verified:
    """Verify an archive, or only some of its runs; runs and studies are not changed.

    Parameters
    ----------
    archive
        What to verify. Its history gains a line for each file that was put in by hand, and for each write of which a
        killed process did not report whether it was done.
    run_ids
        Runs to verify; all, and the studies, where there are none.
    again
        Whether every step is computed again from what was ingested.
    against
        Hash of a line of the history that was kept elsewhere, or how it begins.
    advance
        Given the name of each file looked at.
    crew
        Who looks at the files, and computes again.
    """
    looked = _look_at_all(archive.folder, run_ids, advance, crew)
    sound = {name: one.seen for name, one in looked.items() if one.seen is not None}
    looks = [one.look for one in looked.values()]
    told, account = look_into_history(archive.folder, sound.keys(), looked.keys() if run_ids else None, against)
    looks += told
    if not run_ids:
        by_id = {_called(name): seen for name, seen in sound.items()}
        for name, seen in sound.items():
            check_agreement(looked[name].look, seen, by_id)
        looks += [
            *look_around(archive.folder),
            *look_into_catalogue(archive.folder, sound.keys(), account.files.keys()),
        ]
    for name, redone in in_turn(partial(recompute, archive), sound if again else (), crew):
        looked[name].look.take_over(_unanswered(name, "recompute", redone))
        advance(name)
    return Verified(
        runs=sum(not _is_study(name) for name in looked),
        studies=sum(map(_is_study, looked)),
        size=sum(one.stamp.size for one in looked.values()),
        recomputed=again,
        findings=tuple(finding for look in looks for finding in look.findings),
        lines=account.lines,
        head=account.head,
    )


def files_of(archive: Path, run_ids: Collection[str] = ()) -> dict[str, Stamp]:
    """Return the files to be looked at, by their path in the archive, in natural order; runs before studies.

    Raises ``ArchiveError`` where one of the runs asked for is not there.
    """
    there = stamps(archive)
    chosen = [f"{run_id}{SUFFIX}" for run_id in run_ids] or list(there)
    for name in chosen:
        if name not in there:
            known = did_you_mean(_called(name), map(_called, there))
            raise ArchiveError(
                f"{archive}: found no run {_called(name)!r}; expected the ID of an archived run; {known}"
            )
    return {name: there[name] for name in sorted(chosen, key=lambda name: (_is_study(name), natural_order(name)))}


def _look_at_all(archive: Path, run_ids: Collection[str], advance: Advance, crew: Crew) -> dict[str, _Looked]:
    """Look at files until none was replaced since it was looked at."""
    looked: dict[str, _Looked] = {}
    for _ in range(_ROUNDS):
        there = files_of(archive, run_ids)
        changed = {name: stamp for name, stamp in there.items() if name not in looked or looked[name].stamp != stamp}
        looked = {name: looked[name] for name in looked if name in there}
        if not changed:
            break
        for name, answer in in_turn(partial(look_at, archive), changed, crew):
            told = (_unanswered(name, "content", answer), None) if isinstance(answer, TribopipeError) else answer
            looked[name] = _Looked(changed[name], *told)
            advance(name)
    return looked


def _unanswered(name: str, check: CheckName, answer: Look | TribopipeError) -> Look:
    """Return a look as it is, or what is noted of a file whose worker gave no look."""
    if isinstance(answer, Look):
        return answer
    look = Look(name)
    look.refused(check, answer)
    return look


def _is_study(name: str) -> bool:
    return name.startswith(f"{STUDIES}/")


def _called(name: str) -> str:
    stem = PurePosixPath(name).stem
    return f"study {stem}" if _is_study(name) else stem

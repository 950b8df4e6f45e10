"""Every step computed again from what was ingested, and compared with what is archived."""

from tribopipe.archive.store import Archive
from tribopipe.base.errors import TribopipeError
from tribopipe.pipeline.reproduce import Redone, reproduce, reproduce_study
from tribopipe.pipeline.verify.look import Look


def recompute(archive: Archive, look: Look, name: str, *, study: bool) -> None:
    """Note which steps of a run, or whether a study, come out other than they are archived."""
    try:
        redone = (reproduce_study if study else reproduce)(archive, name)
    except TribopipeError as error:
        look.refused("recompute", error)
        return
    for step in redone.steps:
        if not step.same:
            _tell(look, name, step)


def _tell(look: Look, name: str, step: Redone) -> None:
    part = "" if step.name == "study" else f"/entry/{step.name}"
    if step.outcome == "not compared":
        look.note(
            "recompute", f"found nothing to compare ({step.why}); expected the recomputed step", "process it", part
        )
        return
    first, count = step.differences[0], len(step.differences)
    changed = ", ".join(f"{what} {then}, now {now}" for what, (then, now) in step.environment.items())
    message = (
        f"found {count} of {step.compared} values that differ when computed again, most of all {first.where}, archived "
        f"as {first.then}, now {first.now}{f' (computed with {changed})' if changed else ''}; expected the same"
    )
    look.warning("recompute", message, f"`tribopipe reproduce {name}` shows them all", part)

"""What was tested, in a sentence."""

from collections.abc import Iterable, Sequence

from tribopipe.archive.outline import RunOutline
from tribopipe.base.units import show, show_force
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.slip import stated_slip


def tested(runs: Sequence[RunOutline]) -> str:
    """Report what was tested in some runs: bodies, environment, loads, and how far at what speed."""
    bodies = _several(" on ".join(_bodies(run)) for run in runs if run.manifest.bodies)
    media = _several(run.manifest.conditions.medium for run in runs if run.manifest.conditions.medium)
    loads = _several(load_of(run) for run in sorted(runs, key=lambda run: run.manifest.conditions.normal_load.value))
    parts = [
        bodies or "bodies that are not described",
        f" in {media}" if media else "",
        f", under {loads}",
        _course(runs),
    ]
    return "".join(parts) + "."


def conditions(run: RunOutline) -> str:
    """Name a run by its load, and two discs by slip and rotations too."""
    found = stated_slip(run.manifest)
    return load_of(run) if found is None else f"{load_of(run)}, {_shown(found)} slip, {_rotations(run)} rotations"


def load_of(run: RunOutline) -> str:
    """Write the nominal load of a run without its uncertainty."""
    return show_force(run.manifest.conditions.normal_load.value)


def _bodies(run: RunOutline) -> list[str]:
    return [f"a {spoken(name)} of {body.material}" for name, body in run.manifest.bodies.items()]


def _course(runs: Sequence[RunOutline]) -> str:
    """Report how far the runs went, and at what speed."""
    slips = {run.manifest.id: found for run in runs if (found := stated_slip(run.manifest)) is not None}
    if slips:
        rolled = sorted(
            (run for run in runs if run.manifest.id in slips), key=lambda run: run.ends.get("rotations", 0.0)
        )
        turned = _several(map(_rotations, rolled))
        return f", at {_several(map(_shown, slips.values()))} slip, over {turned} rotations of the crowned disc"
    far = _several(show(run.ends["sliding_distance"], None, "m") for run in runs if "sliding_distance" in run.ends)
    speeds = [run.manifest.conditions.nominal_speed for run in runs]
    fast = _several(show(speed.value, None, "m/s", "mm/s") for speed in speeds if speed is not None)
    return (f", over {far}" if far else "") + (f" at {fast}" if fast else "")


def _shown(slip: Quantity) -> str:
    return show(slip.value, None, "1", "%")


def _rotations(run: RunOutline) -> str:
    return f"{run.ends.get('rotations', 0.0):,.0f}"


def _several(words: Iterable[str | None]) -> str:
    """Join distinct words: "a, b and c"."""
    each = [word for word in dict.fromkeys(words) if word]
    return " and ".join([", ".join(each[:-1]), each[-1]]) if len(each) > 1 else "".join(each)

"""Which runs may share one k_D: those of the same bodies in the same medium."""

from collections.abc import Sequence

from tribopipe.errors import FitError
from tribopipe.records.manifest import RunManifest


def check_bodies(study_id: str, manifests: Sequence[RunManifest]) -> None:
    """Refuse runs of other materials, geometry or medium under one k_D."""
    first = manifests[0]
    for other in manifests[1:]:
        for what, mine, theirs in zip(_BODY_KEYS, bodies(first), bodies(other), strict=True):
            if mine != theirs:
                raise FitError(
                    f"{study_id}: found {what} {theirs} in {other.id} and {mine} in {first.id}; expected the same "
                    "bodies in the same medium for one k_D; take one of them out of the study"
                )


_BODY_KEYS = ("contact", "pin shape", "pin radius in m", "pin material", "disc material", "medium")


def bodies(manifest: RunManifest) -> tuple[object, ...]:
    """Return what runs must have in common for one k_D."""
    contact = manifest.contact
    return (
        contact.kind,
        contact.pin.shape,
        contact.pin.radius.value,
        contact.pin.material,
        contact.disc.material,
        manifest.conditions.medium,
    )

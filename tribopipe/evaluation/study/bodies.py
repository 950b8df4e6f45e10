"""Which runs may share one k_D: those of the same bodies in the same environment."""

from collections.abc import Sequence

from tribopipe.base.errors import FitError
from tribopipe.documents.contact import Contact
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.slip import slip


def check_bodies(study_id: str, manifests: Sequence[RunManifest]) -> None:
    """Refuse runs of other materials, geometry or environment under one k_D."""
    first = manifests[0]
    for other in manifests[1:]:
        for what, mine, theirs in zip(_alike(first.described, first), bodies(first), bodies(other), strict=False):
            if mine != theirs:
                raise FitError(
                    f"{study_id}: found {what} {theirs} in {other.id} and {mine} in {first.id}; expected the same "
                    "materials and environment for one k_D; remove one of them from the study"
                )


def bodies(manifest: RunManifest) -> tuple[object, ...]:
    """Return what runs must have in common for one k_D, the tribometer first; the id alone of a run without bodies."""
    return (manifest.id,) if manifest.contact is None else tuple(_alike(manifest.contact, manifest).values())


def _alike(contact: Contact, manifest: RunManifest) -> dict[str, object]:
    """Return what runs must have in common for one k_D, by its name."""
    materials = {f"{spoken(name)} material": body.material for name, body in contact.bodies.items()}
    return {"contact": contact.kind, "medium": manifest.conditions.medium, **materials, **contact.alike}


def severity(manifest: RunManifest) -> tuple[float, float]:
    """Return normal load, N, and size of the slip, by which runs of the same bodies are ordered."""
    return manifest.conditions.normal_load.value, abs(slip(manifest).value)

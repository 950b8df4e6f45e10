"""Which runs may share one k_D: those of the same bodies in the same medium."""

from collections.abc import Sequence

from tribopipe.base.errors import FitError
from tribopipe.documents.contact import PinOnDisc
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.slip import slip


def check_bodies(study_id: str, manifests: Sequence[RunManifest]) -> None:
    """Refuse runs of other materials, geometry or medium under one k_D."""
    first = manifests[0]
    for other in manifests[1:]:
        for what, mine, theirs in zip(_body_keys(first), bodies(first), bodies(other), strict=False):
            if mine != theirs:
                raise FitError(
                    f"{study_id}: found {what} {theirs} in {other.id} and {mine} in {first.id}; expected the same "
                    "bodies in the same medium for one k_D; take one of them out of the study"
                )


def _body_keys(manifest: RunManifest) -> tuple[str, ...]:
    if isinstance(manifest.contact, PinOnDisc):
        return ("contact", "medium", "pin material", "disc material", "pin shape", "pin radius in m")
    radii = ("crown radius in m", "curved disc's radius in m", "flat disc's radius in m")
    return ("contact", "medium", "curved disc's material", "flat disc's material", *radii)


def bodies(manifest: RunManifest) -> tuple[object, ...]:
    """Return what runs must have in common for one k_D, the tribometer first; the id alone of a run without bodies."""
    contact = manifest.contact
    if contact is None:
        return (manifest.id,)
    common = (contact.kind, manifest.conditions.medium, *(body.material for body in contact.bodies.values()))
    if isinstance(contact, PinOnDisc):
        return (*common, contact.pin.shape, contact.pin.radius.value)
    curved, flat = contact.curved_disc, contact.flat_disc
    return (*common, curved.crown_radius.value, curved.rolling_radius.value, flat.rolling_radius.value)


def severity(manifest: RunManifest) -> tuple[float, float]:
    """Return normal load, N, and size of the slip, by which runs of the same bodies are ordered."""
    return manifest.conditions.normal_load.value, abs(slip(manifest).value)

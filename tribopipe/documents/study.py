"""study.toml: which runs identify a wear law, which ones it has to predict, and which runs may share one k_D."""

from collections import Counter
from collections.abc import Sequence
from typing import Literal, Self

from pydantic import Field, model_validator

from tribopipe.base.errors import FitError
from tribopipe.documents.contact import Contact
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.manifest import RunId, RunManifest
from tribopipe.documents.quantity import Length
from tribopipe.documents.recipe import LawName
from tribopipe.documents.record import Record

STUDY_NAME = "study.toml"
STUDY_SUFFIX = ".study.toml"
SharedInput = Literal[
    "normal_load",
    "pin_radius",
    "pin_modulus",
    "disc_modulus",
    "sliding_speed",
    "track_radius",
    "depth_scale",
    "crown_radius",
    "curved_radius",
    "flat_radius",
    "curved_modulus",
    "flat_modulus",
    "slip",
]


class Study(Record):
    """k_D is identified from some runs and used to predict others; the agreement with the law is given for each run."""

    schema_version: Literal["tribopipe.study/1"] = Field(default="tribopipe.study/1", alias="schema")
    """Version of this document."""
    id: RunId
    """Name of the study."""
    title: str | None = None
    """Title of the study, one line."""
    fit: tuple[RunId, ...] = Field(min_length=1)
    """Runs from which k_D is identified."""
    predict: tuple[RunId, ...] = ()
    """Runs that are predicted with it."""
    laws: tuple[LawName, ...] = Field(default=("archard", "sarkar"), min_length=1)
    """Wear laws."""
    shared: tuple[SharedInput, ...] = ("pin_modulus", "disc_modulus", "curved_modulus", "flat_modulus")
    """Inputs with the same error in all runs, such as the moduli of one material or the load from one load cell; inputs
    that do not apply to a run are ignored. Parameters of a wear law given in a recipe are always shared."""
    end_of_life: Length | None = None
    """Wear depth of the pin or the crowned disc, for which each run's sliding distance or rotations are calculated."""

    @model_validator(mode="after")
    def _each_run_has_one_place(self) -> Self:
        for name, listed in (("fit", self.fit), ("predict", self.predict), ("laws", self.laws)):
            twice = [one for one, count in Counter(listed).items() if count > 1]
            if twice:
                raise ValueError(f"{name}: found {twice[0]!r} twice; expected each entry once; remove one of the two")
        both = sorted(set(self.fit) & set(self.predict))
        if both:
            raise ValueError(
                f"predict: found {both[0]!r}, which is also in fit; expected runs that are not in fit, for an "
                "independent prediction; remove the run from one of the two"
            )
        return self


def check_bodies(study_id: str, fit: Sequence[RunManifest], predict: Sequence[RunManifest] = ()) -> None:
    """Refuse runs of other materials or environment under one k_D, and fitted ones of another geometry.

    Between contacts whose bodies have the same parts, k_D of one geometry predicts another.
    """
    first = fit[0]
    mine = _alike(first.described, first)
    for other in (*fit[1:], *predict):
        everything = other not in predict or other.contact is None or other.contact.roles != first.described.roles
        for what, one, another in zip(mine, mine.values(), bodies(other), strict=False):
            if one != another and (everything or what in _pair(first.described, first)):
                raise FitError(
                    f"{study_id}: found {what} {another} in {other.id} and {one} in {first.id}; expected the same "
                    "materials and environment in all runs with a common k_D; remove one of the two runs from the "
                    "study"
                )


def in_another_geometry(fit: RunManifest, predict: Sequence[RunManifest]) -> list[str]:
    """Return the runs whose contact or geometry is not that of the fitted ones."""
    return [other.id for other in predict if bodies(other) != bodies(fit)]


def bodies(manifest: RunManifest) -> tuple[object, ...]:
    """Return what runs must have in common for one k_D, the tribometer first; the id alone of a run without bodies."""
    return (manifest.id,) if manifest.contact is None else tuple(_alike(manifest.contact, manifest).values())


def _alike(contact: Contact, manifest: RunManifest) -> dict[str, object]:
    """Return what runs must have in common for one k_D, by its name."""
    return {**_pair(contact, manifest), "contact": contact.kind, **contact.alike}


def _pair(contact: Contact, manifest: RunManifest) -> dict[str, object]:
    """Return both materials and what is between them."""
    materials = {f"{spoken(name)} material": body.material for name, body in contact.bodies.items()}
    return {"medium": manifest.conditions.medium, **materials}


def severity(manifest: RunManifest) -> tuple[float, float]:
    """Return normal load, N, and size of the slip, by which runs of the same bodies are ordered."""
    slip = manifest.slip
    return manifest.conditions.normal_load.value, 0.0 if slip is None else abs(slip.value)

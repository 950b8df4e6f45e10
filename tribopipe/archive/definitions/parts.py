"""What a file of the archive is declared to hold: groups, fields and links, in the words of NeXus' NXDL."""

import re
from dataclasses import dataclass
from typing import Literal, TypeAlias

Kind = Literal["NX_CHAR", "NX_DATE_TIME", "NX_FLOAT", "NX_INT", "NX_POSINT", "NX_BINARY", "NX_CHAR_OR_NUMBER"]


@dataclass(frozen=True)
class FieldPart:
    """A dataset."""

    name: str
    """Capital letters in it stand for whatever a file puts there."""
    doc: str
    kind: Kind = "NX_CHAR"
    units: tuple[str, ...] = ()
    """Units that it may have, as files write them; none for what has no unit."""
    required: bool = False
    values: tuple[str, ...] = ()
    """Texts that it may hold; none where it may hold any."""
    attributes: tuple[str, ...] = ()
    """Names of its attributes with units."""


@dataclass(frozen=True)
class LinkPart:
    """A name for a field that lies elsewhere in the file."""

    name: str
    target: str
    """Where it usually leads, by names and classes."""
    required: bool = True


@dataclass(frozen=True)
class GroupPart:
    """A group with all that may be in it."""

    name: str
    """As that of a field; empty where groups of the class may have any name."""
    nx_class: str
    doc: str
    members: "tuple[Part, ...]" = ()
    required: bool = False
    attributes: tuple[str, ...] = ()
    """Names of its attributes with those that NeXus has for its class."""

    def member(self, name: str, nx_class: str | None) -> "Part | None":
        """Return what is declared of a member: by its name, or of a group by its class; none where it is not."""
        exactly = (part for part in self.members if part.name == name)
        partly = (part for part in self.members if is_partial(part.name) and _stands_for(part.name, name))
        classed = (part for part in self.members if not part.name and getattr(part, "nx_class", None) == nx_class)
        return next((part for found in (exactly, partly, classed) for part in found), None)


Part: TypeAlias = FieldPart | LinkPart | GroupPart


@dataclass(frozen=True)
class Definition:
    """A NeXus application definition."""

    name: str
    version: int
    """That of the format of its files."""
    doc: str
    entry: GroupPart


def is_partial(declared: str) -> bool:
    """Return whether a part of a declared name is what files put there."""
    return declared != declared.lower()


def _stands_for(declared: str, name: str) -> bool:
    return re.fullmatch(re.sub("[A-Z]+", r"\\w+", declared), name) is not None

"""The formats of archived files and the NeXus application definitions that they follow.

These are the present ones, and what is stated about files of another format.
"""

import re
from typing import NamedTuple

import h5py

from tribopipe.archive import nexus
from tribopipe.base.errors import ArchiveError

FORMAT_TEXT = "entry/archived/format"
"""Where a file states about which format it is."""
_FORMAT = re.compile(r"(tribopipe\.(?:run|study|archive(?:\.study)?))/(\d{1,6})")
_EARLIER = ("tribopipe.archive", "tribopipe.archive.study")
"""What runs and studies were called before the first release."""


class Format(NamedTuple):
    """What a file holds, and in which version of its layout."""

    kind: str
    version: int

    def __str__(self) -> str:
        return f"{self.kind}/{self.version}"


RUN_FORMAT = Format("tribopipe.run", 1)
STUDY_FORMAT = Format("tribopipe.study", 1)


def format_of(file: h5py.File) -> Format | None:
    """Return the format that a file states it has; none where it is not one of tribopipe."""
    if FORMAT_TEXT not in file:
        return None
    said = _FORMAT.fullmatch(nexus.text(file, FORMAT_TEXT))
    return None if said is None else Format(said[1], int(said[2]))


def check_format(file: h5py.File, path: object, expected: Format) -> None:
    """Raise ``ArchiveError`` where a file is of another format, saying what to do."""
    found = format_of(file)
    if found == expected:
        return
    if found is not None and found.kind in _EARLIER:
        remedy = (
            "save its source files with `tribopipe rescue`, and ingest them into another archive"
            if expected == RUN_FORMAT
            else "run the study again in another archive that contains its runs"
        )
        raise ArchiveError(
            f"{path}: found the format '{found}', written by a pre-release version of tribopipe; expected "
            f"'{expected}'; {remedy}"
        )
    if found is None or found.kind != expected.kind:
        holds = "run" if expected.kind == RUN_FORMAT.kind else "study"
        raise ArchiveError(
            f"{path}: found an HDF5 file that is not a tribopipe {holds}; expected a file written by tribopipe; "
            "move it out of the archive folder"
        )
    raise ArchiveError(
        f"{path}: found the format '{found}'; expected '{expected}'; use the tribopipe version that wrote it"
    )


FRICTION = "NXtribometry_friction"
"""Definition for runs without a description of the bodies: only friction is evaluated."""


def run_name(tribometer: str | None) -> str:
    """Return the definition that the file of a run on a kind of tribometer follows."""
    return FRICTION if tribometer is None else f"NXtribometry_{tribometer.replace('-', '_')}"


STUDY = "NXtribometry_study"


def write_definition(entry: h5py.Group, name: str, version: int) -> None:
    """Write the name of the definition that a file follows; its version is that of the format."""
    nexus.field(entry, "definition", name, version=str(version))

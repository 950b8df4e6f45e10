"""Names of the NeXus application definitions that archived files follow."""

from collections.abc import Mapping

import h5py

from tribopipe.archive import nexus
from tribopipe.documents.contact_kinds import SHIPPED

FRICTION = "NXtribometry_friction"
"""Of a run whose bodies are not described: friction alone is evaluated."""


def run_name(tribometer: str | None) -> str:
    """Return the definition that the file of a run on a kind of tribometer follows."""
    return FRICTION if tribometer is None else f"NXtribometry_{tribometer.replace('-', '_')}"


RUNS: Mapping[str | None, str] = {kind: run_name(kind) for kind in (*SHIPPED, None)}
"""By the tribometer of a run, of tribopipe itself kinds."""
STUDY = "NXtribometry_study"


def write_definition(entry: h5py.Group, name: str, version: int) -> None:
    """Report which definition a file follows; its version is that of the format."""
    nexus.field(entry, "definition", name, version=str(version))

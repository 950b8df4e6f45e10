"""Names of the NeXus application definitions that archived files follow."""

from collections.abc import Mapping

import h5py

from tribopipe.archive import nexus

RUNS: Mapping[str | None, str] = {
    "pin-on-disc": "NXtribometry_pin_on_disc",
    "twin-disc": "NXtribometry_twin_disc",
    None: "NXtribometry_friction",
}
"""By the tribometer of a run; of one whose bodies are not described, friction alone is evaluated."""
STUDY = "NXtribometry_study"


def write_definition(entry: h5py.Group, name: str, version: int) -> None:
    """Say which definition a file follows; its version is that of the format."""
    nexus.field(entry, "definition", name, version=str(version))

"""Columns of a run that were not recorded: its axes, and the friction coefficient."""

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.documents.manifest import RunManifest
from tribopipe.evaluation.axes import Columns, Origins, complete_axes
from tribopipe.results.run import Origin


def derive_missing(columns: Columns, origins: Origins, manifest: RunManifest) -> None:
    """Add the axes and the friction coefficient where they were not recorded, with their origins.

    Raises ``ReaderError`` where an axis is missing that cannot be derived.
    """
    complete_axes(columns, origins, manifest)
    if "friction_coefficient" not in columns and "friction_force" in columns:
        columns["friction_coefficient"], origins["friction_coefficient"] = coefficient(columns, manifest)


def coefficient(columns: Columns, manifest: RunManifest) -> tuple[Column, Origin]:
    """Return friction force over normal force, or over the nominal load where the normal force was not recorded."""
    measured = "normal_force" in columns
    force = columns["normal_force"] if measured else np.asarray(manifest.conditions.normal_load.value)
    with np.errstate(divide="ignore", invalid="ignore"):
        mu = columns["friction_force"] / force
    origin: Origin = "derived from measured load" if measured else "derived from nominal load"
    return np.where(np.isfinite(mu), mu, np.nan), origin

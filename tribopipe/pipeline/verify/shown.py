"""Whether what viewers show of a run is what its records state, from which everything else is computed."""

from collections.abc import Mapping

import h5py
import numpy as np

from tribopipe.archive import nexus
from tribopipe.archive.runfile import wear_curves
from tribopipe.archive.steps import Step, StepName
from tribopipe.archive.unpack import unpacked
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.record import Record
from tribopipe.pipeline.verify.look import Look

_REDO = "`tribopipe process --force` writes it again"


def check_shown(entry: h5py.Group, look: Look, manifest: RunManifest, steps: Mapping[StepName, Step]) -> None:
    """Note which fields for viewers show something else than the manifest, or the result of their step."""
    _compare(entry["conditions"], look, manifest.conditions)
    _compare(entry["end_values"], look, manifest.end_values)
    for name, body in manifest.bodies.items():
        _compare(entry[name]["properties"], look, body)
    for step in steps.values():
        _compare(entry[step.name]["parameters"], look, step.result)
    for name, values in wear_curves(steps).items():
        plotted = entry["wear"][name]
        if not np.array_equal(unpacked(plotted), values, equal_nan=True):
            look.warning(
                "shown", "found a curve that differs from that of its step; expected the same", _REDO, plotted.name
            )


def _compare(group: h5py.Group, look: Look, record: Record) -> None:
    """Compare the fields that are there: other versions of tribopipe may show more of a record, or less."""
    for name, value, unit in nexus.summarised(record):
        if name not in group:
            continue
        field = group[name]
        if (_said(field), field.attrs.get("units")) != (value, unit):
            message = f"found {_said(field)!r}; expected {value!r}, as in the record"
            look.warning("shown", message, _REDO, field.name)


def _said(field: h5py.Dataset) -> float | str:
    said = field.asstr()[()] if h5py.check_string_dtype(field.dtype) else field[()]
    return said.item() if isinstance(said, np.generic) else str(said)

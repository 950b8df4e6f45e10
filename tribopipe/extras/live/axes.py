"""Time and sliding distance of samples that come piece by piece, as if they had come at once."""

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ReaderError
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.signals import SignalName
from tribopipe.evaluation.derived_columns import derive_missing
from tribopipe.results.run import Origin

_AXES: tuple[SignalName, ...] = ("time", "rotations", "sliding_distance")
_NEEDED: tuple[SignalName, ...] = (*_AXES, "sliding_speed")


class Axes:
    """What the axes of a run have come to."""

    def __init__(self, manifest: RunManifest) -> None:
        self._manifest = manifest
        self._recorded: dict[SignalName, Column] = {}
        """The last sample, as recorded."""
        self._reached: dict[SignalName, float] = {}
        """The axes there, derived ones among them."""

    def completed(self, columns: dict[SignalName, Column]) -> tuple[dict[SignalName, Column], dict[SignalName, Origin]]:
        """Return samples with the axes that were not recorded, and the origins of all; those not placed are left out.

        Raises ``ReaderError`` where an axis restarts, or nothing shows the sliding distance of the pin.
        """
        placed = np.logical_and.reduce([np.isfinite(columns[name]) for name in _NEEDED if name in columns])
        joined = {
            name: np.concatenate([self._recorded.get(name, []), values[placed]]) for name, values in columns.items()
        }
        self._refuse_restarts(joined)
        origins: dict[SignalName, Origin] = dict.fromkeys(joined, "measured")
        self._recorded = {name: values[-1:] for name, values in joined.items()}
        if len(next(iter(joined.values()))):
            derive_missing(joined, origins, self._manifest)
            self._refuse_unknown(origins)
        first = len(self._reached) > 0
        for name in _AXES:
            if name in joined and name not in columns and first:
                joined[name] = joined[name] + (self._reached[name] - joined[name][0])
        self._reached = {name: float(joined[name][-1]) for name in _AXES if name in joined and len(joined[name])}
        return {name: values[int(first) :] for name, values in joined.items()}, origins

    def _refuse_restarts(self, columns: dict[SignalName, Column]) -> None:
        for name in _AXES:
            if name in columns and np.any(np.diff(columns[name]) < 0):
                raise ReaderError(
                    f"{self._manifest.id}: found a {name.replace('_', ' ')} that falls back; expected one test that "
                    "goes on; process the run when it has ended, which joins the parts of a test"
                )

    def _refuse_unknown(self, origins: dict[SignalName, Origin]) -> None:
        if origins["sliding_distance"] == "unknown":
            raise ReaderError(
                f"{self._manifest.id}: found neither distance nor speed of the pin; expected a sliding distance, "
                'or a speed; add conditions.sliding_speed = "400 mm/s" or the like to run.toml'
            )

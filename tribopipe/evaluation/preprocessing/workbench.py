"""The columns of one run while they are preprocessed, and a record of what was done to them."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column
from tribopipe.base.errors import counted
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.preprocessing import Change, CleaningStepName
from tribopipe.documents.signals import SignalName
from tribopipe.evaluation.derived_columns import Columns, Origins, derive_missing
from tribopipe.results.run import RawRun

Selection = NDArray[np.bool_]


class Bench:
    """Columns that steps change in turn; what is derived from a changed one is derived again."""

    step: CleaningStepName
    """The step that is being taken."""

    def __init__(self, run: RawRun) -> None:
        self.columns: Columns = dict(run.columns)
        self.origins: Origins = dict(run.origins)
        self.manifest: RunManifest = run.manifest
        self.changes: list[Change] = []
        self._settled: set[SignalName] = set()
        self._hidden: dict[SignalName, Selection] = {}
        self._stale = False

    def measured(self, name: SignalName) -> Column | None:
        """Return a column if it was measured and has a number in it."""
        values = self.columns.get(name)
        if values is None or self.origins[name] != "measured" or not np.any(np.isfinite(values)):
            return None
        return values

    def put(self, name: SignalName, values: Column, what: str, why: str, **more: Any) -> None:
        """Replace a column; one that is derived is not derived again hereafter."""
        before = self.columns[name]
        changed = np.count_nonzero((before != values) & ~(np.isnan(before) & np.isnan(values)))
        self.columns[name] = values
        self._stale = True
        if self.origins[name] != "measured":
            self._settled.add(name)
        self._tell(name, int(changed), what, why, **more)

    def mask(self, name: SignalName, where: Selection, what: str, why: str) -> None:
        """Make samples of a column missing, and leave it out where a measured one has no other."""
        values = self.columns[name]
        where = where & np.isfinite(values)
        samples = int(np.count_nonzero(where))
        if not samples:
            return
        if self.origins[name] == "measured" and samples == np.count_nonzero(np.isfinite(values)):
            self.leave_out(name, f"{what} throughout, so the run is processed without it", why)
            return
        self.columns[name] = np.where(where, np.nan, values)
        if self.origins[name] == "measured":
            self._stale = True
        else:
            self._hidden[name] = where | self._hidden.get(name, np.zeros_like(where))
        self._tell(name, samples, f"{counted(samples, 'sample')} masked: {what}", why)

    def leave(self, name: SignalName, what: str, why: str) -> None:
        """Report why a column stays as it is, where a recipe wants it changed."""
        self._tell(name, 0, what, why)

    def leave_out(self, name: SignalName, what: str, why: str) -> None:
        """Go on without a signal."""
        samples = len(self.columns.pop(name))
        del self.origins[name]
        self._stale = True
        self._tell(name, samples, what, why)

    def finish_step(self) -> None:
        """Derive again what is not measured, if anything it may depend on has changed."""
        if not self._stale:
            return
        kept = [name for name in self.columns if self.origins[name] == "measured" or name in self._settled]
        columns = {name: self.columns[name] for name in kept}
        origins = {name: self.origins[name] for name in kept}
        derive_missing(columns, origins, self.manifest)
        for name, where in self._hidden.items():
            if name in columns:
                columns[name] = np.where(where, np.nan, columns[name])
        self.columns, self.origins, self._stale = columns, origins, False

    def _tell(self, name: SignalName, samples: int, what: str, why: str, **more: Any) -> None:
        self.changes.append(Change(step=self.step, signal=name, samples=samples, what=what, why=why, **more))


def fewer(values: Column) -> Column:
    """Return at most some ten thousand samples, evenly spread and finite, by which a level can be found quickly."""
    some = values[:: max(1, len(values) // 10_000)]
    return some[np.isfinite(some)]

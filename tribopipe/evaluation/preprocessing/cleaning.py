"""Preprocessing of one run by the steps of a recipe, in their order."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.documents.preprocessing import CleaningStepName, CleanUp
from tribopipe.documents.recipe import Recipe
from tribopipe.documents.signals import SignalName
from tribopipe.evaluation.measurements.specific_wear import specific_wear
from tribopipe.evaluation.preprocessing.axes import join_axes
from tribopipe.evaluation.preprocessing.forces import invert, turn_friction, turn_load, zero_forces
from tribopipe.evaluation.preprocessing.idle import leave_out_idle
from tribopipe.evaluation.preprocessing.masking import mask_samples, mask_spikes, mask_unloaded_friction
from tribopipe.evaluation.preprocessing.strokes import average_strokes
from tribopipe.evaluation.preprocessing.workbench import Bench
from tribopipe.results.run import RawRun, with_cleaned
from tribopipe.results.specific_wear import SpecificWear

_TAKE: dict[CleaningStepName, Callable[[Bench, Any], None]] = {
    "continuous-axes": join_axes,
    "mask": mask_samples,
    "zero": zero_forces,
    "pressing-load": turn_load,
    "friction-sign": turn_friction,
    "idle": leave_out_idle,
    "unloaded-friction": mask_unloaded_friction,
    "stroke-wise-friction": average_strokes,
    "invert": invert,
    "despike": mask_spikes,
}


@dataclass(frozen=True, eq=False)
class CleanedRun:
    """A run whose signals were preprocessed, and what was done to them."""

    run: RawRun
    """The run with its cleaned columns in the place of the raw ones."""
    record: CleanUp
    columns: Mapping[SignalName, Column]
    """The columns that differ from the raw ones."""

    @cached_property
    def wear(self) -> SpecificWear:
        """Wear and specific wear rate of each body, computed once for all checks.

        Raises ``FitError`` for a mass without density, and for profiles of which nothing can be taken.
        """
        return specific_wear(self.run)


def clean_run(run: RawRun, recipe: Recipe | None = None) -> CleanedRun:
    """Preprocess the signals of a run as a recipe states; the run itself stays as it is.

    Columns that are derived from changed ones, such as the friction coefficient from forces, are derived again.
    """
    recipe = recipe or Recipe()
    bench = Bench(run)
    if len(run) > 1:
        for step in recipe.clean_up:
            bench.step = step.step
            _TAKE[step.step](bench, step)
            bench.finish_step()
    changed = {name: values for name, values in bench.columns.items() if not _same(values, run.columns.get(name))}
    record = CleanUp(
        changes=tuple(bench.changes),
        derived={name: bench.origins[name] for name in changed if bench.origins[name] != "measured"},
        left_out=tuple(name for name in run.columns if name not in bench.columns),
    )
    return CleanedRun(with_cleaned(run, record, changed), record, changed)


def _same(values: Column, before: Column | None) -> bool:
    return values is before or (before is not None and np.array_equal(values, before, equal_nan=True))

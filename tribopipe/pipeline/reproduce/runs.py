"""A run computed again, from its source files on."""

from collections.abc import Mapping
from typing import Any

from tribopipe.archive.steps import Step
from tribopipe.archive.store import Archive
from tribopipe.base.arrays import Column
from tribopipe.pipeline.reproduce.again import planned_again, read_again
from tribopipe.pipeline.reproduce.comparing import redo
from tribopipe.pipeline.reproduce.redone import Redone, Reproduction
from tribopipe.results.run import RawRun


def reproduce(archive: Archive, run_id: str) -> Reproduction:
    """Read a run again and take its steps again; each stands on what the archive holds of those before it.

    Raises ``ArchiveError`` where there is no such run, or its file cannot be read.
    """
    steps = archive.steps(run_id).values()
    return Reproduction(run_id, "run", (_raw(archive, run_id), *(_step(archive, run_id, step) for step in steps)))


def _raw(archive: Archive, run_id: str) -> Redone:
    run = archive.raw(run_id)
    return redo("raw", _told_of_run(run), lambda: _told_of_run(read_again(run)), archive.environment(run_id))


def _told_of_run(run: RawRun) -> Mapping[str, Any]:
    return {
        "manifest": run.manifest,
        "columns": run.columns,
        "origins": run.origins,
        "extra_columns": {name: vars(extra) for name, extra in run.extras.items()},
        "headers": run.headers,
        "profiles": {name: vars(profile) for name, profile in run.profiles.items()},
    }


def _step(archive: Archive, run_id: str, step: Step) -> Redone:
    def compute() -> Mapping[str, Any]:
        return _told_of_step(planned_again(archive, run_id, step).take())

    return redo(step.name, _told_of_step(step), compute, step.environment or {"tribopipe": step.program_version})


def _told_of_step(step: Step) -> Mapping[str, Any]:
    return {
        "result": step.result,
        "curves": _with_units(step.curves),
        "tables": {name: _with_units({**table.axes, **table.arrays}) for name, table in step.tables.items()},
    }


def _with_units(arrays: Mapping[str, tuple[Column, str]]) -> Mapping[str, Any]:
    return {name: {"values": values, "unit": unit} for name, (values, unit) in arrays.items()}

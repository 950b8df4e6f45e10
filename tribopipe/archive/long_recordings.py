"""What was recorded in a run that is too long to be held, sample by sample, with the means that it is evaluated by.

/entry/recorded          NXdata: the measured signals in SI, every sample, written and read in pieces
  /entry/recorded/@mean_of       samples of which a mean was taken
  /entry/recorded/first_of_mean  number of the first sample of each mean, from 0
"""

from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path

import h5py
import numpy as np

from tribopipe.archive import nexus
from tribopipe.archive.file_access import opened
from tribopipe.archive.hdf5_compression import unpacked, unpacked_pieces
from tribopipe.archive.remote import archive_path
from tribopipe.base.arrays import Column
from tribopipe.base.errors import ArchiveError
from tribopipe.documents.signals import SIGNALS, SignalName
from tribopipe.results.run import RawRun, Recording

RECORDED = "recorded"
_AXES: tuple[SignalName, ...] = ("rotations", "sliding_distance", "time")
"""Axes, at least one of which is recorded in any run."""


def write_recorded(entry: h5py.Group, run: RawRun) -> None:
    """Write what was recorded, where the run holds means of it. Raises ``TribopipeError`` if it is another by now."""
    if run.recording is None:
        return
    group = nexus.group(entry, RECORDED, "NXdata", mean_of=run.recording.samples)
    measured = [name for name in run.columns if run.origins[name] == "measured"]
    units = {name: SIGNALS[name].unit for name in measured}
    try:
        nexus.long_fields(group, units, run.recording.rows, run.recording.blocks())
    except ValueError:
        raise ArchiveError(
            f"{run.id}: found that the number of samples, initially {run.recording.rows:,}, changed during archiving; "
            "expected files that do not change; try again when the test has ended"
        ) from None
    for name in measured:
        group[name].attrs["long_name"] = SIGNALS[name].axis
    axis = next(name for name in _AXES if name in measured)
    group.attrs.update({"axes": [axis], f"{axis}_indices": 0})
    signal, *others = sorted((name for name in measured if name != axis), key=lambda name: name != "depth") or [axis]
    group.attrs["signal"] = signal
    if others:
        group.attrs["auxiliary_signals"] = others
    nexus.field(group, "first_of_mean", run.recording.starts)


def recorded_samples(entry: h5py.Group) -> int | None:
    """Return the number of recorded samples of which a run holds means; none where it holds every sample."""
    return len(entry[RECORDED][_names(entry)[0]]) if RECORDED in entry else None


def read_recording(entry: h5py.Group) -> Recording | None:
    """Read what a run holds means of, its samples when they are asked for; none where it holds every sample."""
    if RECORDED not in entry:
        return None
    group, names = entry[RECORDED], _names(entry)
    starts = unpacked(group["first_of_mean"]).astype(np.int64)
    again = partial(_blocks, archive_path(entry.file.filename), names)
    return Recording(len(group[names[0]]), int(group.attrs["mean_of"]), starts, again)


def _names(entry: h5py.Group) -> list[SignalName]:
    return [name for name in SIGNALS if name in entry[RECORDED]]


def _blocks(path: Path, names: list[SignalName]) -> Iterator[Mapping[SignalName, Column]]:
    """Yield all samples of a run, signal by signal. Raises ``ArchiveError`` for a damaged file."""
    with opened(path) as file:
        for name in names:
            for piece in unpacked_pieces(file["entry"][RECORDED][name]):
                yield {name: piece.astype(float)}

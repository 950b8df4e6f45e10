"""A run in memory: its manifest, its columns in SI, and where each of them came from."""

import hashlib
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal, cast

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column, robust_deviation
from tribopipe.base.units import show_force
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.preprocessing import CleanUp
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.signals import SIGNALS, SignalName
from tribopipe.results.evaluation import DriftCorrection
from tribopipe.results.interactive import Tabular, UnitColumn

Origin = Literal[
    "measured",
    "derived from nominal speed",
    "derived from measured speed",
    "derived from nominal slip",
    "derived from rotations",
    "derived from measured load",
    "derived from nominal load",
    "unknown",
]
"""Whether a signal was measured, or what it is derived from; unknown where it cannot be derived, and is NaN."""


@dataclass(frozen=True)
class SourceFile:
    """One file as the instrument wrote it."""

    name: str
    content: bytes = field(repr=False)

    @cached_property
    def sha256(self) -> str:
        """Checksum of the bytes."""
        return hashlib.sha256(self.content).hexdigest()

    @cached_property
    def size(self) -> int:
        """Number of bytes."""
        return len(self.content)

    def pieces(self) -> Iterator[bytes]:
        """Give the bytes one piece after the other. Raises ``TribopipeError`` where they are not there any more."""
        yield self.content


class UnheldSource(SourceFile):
    """A file whose bytes are not held in memory: they are read each time that they are asked for."""

    def __init__(self, name: str, size: int, sha256: str, read: Callable[[], Iterable[bytes]]) -> None:
        """Name a file; ``read`` gives its bytes in pieces, and raises ``TribopipeError`` where they are others."""
        self.__dict__.update(name=name, size=size, sha256=sha256, _read=read)

    @property
    def content(self) -> bytes:
        """The bytes, all at once."""
        return b"".join(self.pieces())

    def pieces(self) -> Iterator[bytes]:
        """Give the bytes one piece after the other. Raises ``TribopipeError`` where they are not there any more."""
        yield from self.__dict__["_read"]()


@dataclass(frozen=True)
class ExtraColumn:
    """A column tribopipe gives no meaning to, kept as it was found."""

    values: NDArray[Any]
    unit: str | None = None


@dataclass(frozen=True)
class Profile:
    """Height measured across a wear track, m; position and height of one length."""

    position: Column
    height: Column
    across: float | None = None
    """Position of a scan line across the lines of its height map, m; None of a profile that is in no map."""
    scan: str = ""
    """Name of that map."""


_BEFORE = ".before"


def before_key(key: str) -> str:
    """Return the key of a map measured before the test, by that of the map after it."""
    return f"{key}{_BEFORE}"


def paired_key(key: str) -> str | None:
    """Return the key of the map after the test by that of a scan line before it; none for one that is not before."""
    after, before, _ = key.partition(_BEFORE)
    return after if before else None


@dataclass(frozen=True)
class Recording:
    """Recorded data of a run that is too long to be kept in memory; the run itself holds block means of it."""

    rows: int
    """Samples that were recorded."""
    samples: int
    """Samples of which a mean was taken; of fewer with a restart and at both ends."""
    starts: NDArray[np.int64] = field(repr=False)
    """Number of the first sample of each mean, from 0."""
    blocks: Callable[[], Iterator[Mapping[SignalName, Column]]] = field(repr=False)
    """Gives the measured signals in SI block by block, each as often as it is asked; signals of one file together."""


AT_A_LEVER = "is treated as a force at"
"""Part of the note on a friction force where only a torque has one meaning."""
READ_IN = "is read in"
"""Part of the note on a unit that takes precedence over another one in the file."""
OF_ANOTHER_KIND = "a unit of another kind"
"""Part of that note where no factor converts one into the other."""


_FEWEST = 2
"""Samples of a load that is recorded."""


@dataclass(frozen=True, repr=False)
class RawRun(Tabular):
    """One run as ingested. Columns are float64, in SI, of one length; NaN marks a missing sample.

    Where more was recorded than memory should hold, they are means, and ``recording`` is what they are means of.
    """

    manifest: RunManifest
    columns: Mapping[SignalName, Column]
    """Signals by name, in SI."""
    origins: Mapping[SignalName, Origin]
    """Whether each signal was measured or derived, and from what."""
    extras: Mapping[str, ExtraColumn]
    """Columns of the files that no signal was made of."""
    headers: Mapping[str, str]
    """Lines above the data of each file, verbatim."""
    sources: tuple[SourceFile, ...]
    """run.toml first, then the instrument's files, byte for byte."""
    notes: tuple[str, ...] = ()
    """Notes of the readers on their files; kept in an archive among the findings."""
    unused: tuple[str, ...] = ()
    """Columns that seem to be signals and are not used, with the reason; kept in an archive among the findings."""
    earlier_steps: tuple[int, ...] = ()
    """Steps of the files, before the last that run.toml chooses, that it does not choose; none of an archived run."""
    profiles: Mapping[str, Profile] = field(default_factory=dict)
    """Profiles across wear tracks by where run.toml names them: "end_values.curved_disc_profile"."""
    recording: Recording | None = None
    """Recording of which the columns are means; None if the columns are as recorded."""

    @property
    def id(self) -> str:
        """Name of the run."""
        return self.manifest.id

    @property
    def single_profiles(self) -> dict[str, Profile]:
        """Profiles by their keys, without the height maps that are evaluated as the difference of two."""
        paired = {paired_key(key) for key in self.profiles} - {None}
        return {
            key: profile
            for key, profile in self.profiles.items()
            if not any(key == one or key.startswith((f"{one}[", f"{one}{_BEFORE}")) for one in paired)
        }

    @property
    def sliding_distance(self) -> Column:
        """Sliding distance of each sample, m."""
        return self.columns["sliding_distance"]

    @property
    def progress(self) -> Column:
        """What wear grows along at each sample: sliding distance, m, or rotations."""
        return self.columns[self.manifest.progress.signal]

    @property
    def end(self) -> float:
        """Sliding distance, m, or rotations at the end of the test, also where the last samples are missing."""
        return float(np.nanmax(self.progress))

    @cached_property
    def recorded_load(self) -> Quantity | None:
        """Mean of the recorded load over the sliding distance, N; None if none was recorded that presses.

        Its standard uncertainty is that of the channel's noise alone, by the differences of successive samples: what
        varies more slowly has really pressed.
        """
        force, slid = self.columns.get("normal_force"), self.columns.get("sliding_distance")
        if force is None or slid is None:
            return None
        seen = np.isfinite(force) & np.isfinite(slid)
        if np.count_nonzero(seen) < _FEWEST or not np.ptp(slid[seen]) > 0:
            return None
        force, slid = force[seen], slid[seen]
        mean = float(np.trapezoid(force, slid) / np.ptp(slid))
        noise = robust_deviation(np.diff(force)) / math.sqrt(2 * len(force))
        return Quantity(value=mean, unit="N", standard_uncertainty=noise) if mean > 0 else None

    def numbered(self, index: int) -> str:
        """Name what a row stands for by the numbers of samples, from 1: "sample 36", or "samples 701 to 720"."""
        if self.recording is None:
            return f"sample {index + 1}"
        first, last = np.append(self.recording.starts, self.recording.rows)[index : index + 2]
        return f"sample {last}" if last == first + 1 else f"samples {first + 1} to {last}"

    @property
    def samples(self) -> str:
        """How many samples there are, for people: "12,501 samples", or "1,000,001 means of 20,000,000 samples"."""
        of = "" if self.recording is None else f"means of {self.recording.rows:,} "
        return f"{len(self):,} {of}samples"

    def __len__(self) -> int:
        return len(self.sliding_distance)

    def unit_columns(self) -> dict[str, UnitColumn]:
        """Return the signals by name, each with its SI unit."""
        return {name: UnitColumn(values, SIGNALS[name].unit) for name, values in self.columns.items()}

    def __repr__(self) -> str:
        return f"<{self}>"

    def __str__(self) -> str:
        stated = self.manifest.conditions.normal_load
        load = show_force(stated.value, stated.standard_uncertainty)
        signals = ", ".join(self.columns)
        known = self.sliding_distance[np.isfinite(self.sliding_distance)]
        far = f"{np.max(known):.4g} m" if len(known) else "an unknown distance"
        if self.manifest.progress.kind == "count":
            far = self.manifest.progress.shown(float(np.nanmax(self.progress)))
        return f"run {self.id}: {load}, {far}, {self.samples} of {signals}"


@dataclass(frozen=True, repr=False)
class CorrectedRun(Tabular):
    """A run whose depth has been corrected for drift, as far as it has what that takes."""

    run: RawRun
    """As preprocessed, where it was."""
    correction: DriftCorrection
    wear_depth: Column | None
    """Wear of pin and disc at each sample, m; None if the run could not be corrected."""
    wander: Column | None = None
    """Slow component of that wear that is neither wear by Archard's law nor drift, m; None if hidden by noise."""
    pin_wear_depth: Column | None = None
    """The pin's part of the wear, m, where pin and disc wear together; None if it is unknown."""

    @property
    def id(self) -> str:
        """Name of the run."""
        return self.run.id

    def unit_columns(self) -> dict[str, UnitColumn]:
        """Return the signals of the run, the corrected wear, the pin's part of it and its wander, as far as known."""
        wear = {"wear_depth": self.wear_depth, "pin_wear_depth": self.pin_wear_depth, "wander": self.wander}
        known = {name: UnitColumn(values, "m") for name, values in wear.items() if values is not None}
        return self.run.unit_columns() | known

    def __len__(self) -> int:
        return len(self.run)

    def __repr__(self) -> str:
        return f"<{self}>"

    def __str__(self) -> str:
        return f"run {self.id}: {self.correction}"


def with_cleaned(run: RawRun, record: CleanUp, columns: Mapping[SignalName, Column]) -> RawRun:
    """Return a run with what its preprocessing made of it: some columns replaced, some left out."""
    if not columns and not record.left_out:
        return run
    kept = {**run.columns, **columns}
    origins = {**run.origins, **record.derived}
    names = [name for name in SIGNALS if name in kept and name not in record.left_out]
    return replace(
        run,
        columns={name: kept[name] for name in names},
        origins={name: cast("Origin", origins[name]) for name in names},
    )

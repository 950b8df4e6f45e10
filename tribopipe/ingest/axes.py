"""Time, sliding distance and rotations of a run, derived from one another where some were not recorded."""

import math

import numpy as np

from tribopipe.errors import ReaderError
from tribopipe.motion import slip_per_rotation
from tribopipe.records.manifest import RunManifest, TwinDisc
from tribopipe.records.signals import SignalName
from tribopipe.run import Column, Origin

Columns = dict[SignalName, Column]
Origins = dict[SignalName, Origin]


def complete_axes(columns: Columns, origins: Origins, manifest: RunManifest) -> None:
    """Add the axes that were not recorded, with their origins.

    Raises ``ReaderError`` where none was recorded, or where the speed that takes is not known.
    """
    if isinstance(manifest.contact, TwinDisc):
        _complete_rolling(columns, origins, manifest, manifest.contact)
    else:
        _complete_sliding(columns, origins, manifest)


def _complete_sliding(columns: Columns, origins: Origins, manifest: RunManifest) -> None:
    """Derive time or sliding distance of a pin from the other one and the speed, measured or nominal."""
    have_time, have_distance = "time" in columns, "sliding_distance" in columns
    if have_time and have_distance:
        return
    if not have_time and not have_distance:
        raise ReaderError(
            "found neither time nor sliding_distance among the signals; expected at least one; "
            "map one under [signals.columns] in run.toml"
        )
    speed = columns.get("sliding_speed")
    origin: Origin = "derived from measured speed" if speed is not None else "derived from nominal speed"
    if speed is None:
        nominal = manifest.conditions.sliding_speed
        if nominal is None:
            lacking = "sliding distance" if have_time else "time"
            raise ReaderError(
                f"run.toml: conditions.sliding_speed: missing; expected one, since the files hold no "
                f'{lacking}; add sliding_speed = "400 mm/s" or the like'
            )
        known = columns["time" if have_time else "sliding_distance"]
        speed = np.full_like(known, nominal.value)
    if have_time:
        columns["sliding_distance"] = _integrate(speed, columns["time"])
        origins["sliding_distance"] = origin
    else:
        with np.errstate(divide="ignore"):
            columns["time"] = _integrate(1 / speed, columns["sliding_distance"])
        origins["time"] = origin


def _complete_rolling(columns: Columns, origins: Origins, manifest: RunManifest, discs: TwinDisc) -> None:
    """Derive time, rotations and slip distance of two discs from one another, by nominal speed and slip.

    The curved disc does v₁/(2πr₁) rotations a second and slips by 2πr₁·|slip| in each.
    """
    if "time" not in columns and "rotations" not in columns and "sliding_distance" not in columns:
        raise ReaderError(
            "found neither time nor rotations among the signals; expected at least one; map one under "
            "[signals.columns] in run.toml"
        )
    slipped = slip_per_rotation(manifest)
    if "rotations" not in columns and "sliding_distance" in columns:
        columns["rotations"], origins["rotations"] = columns["sliding_distance"] / slipped, "derived from nominal slip"
    if "rotations" not in columns:
        columns["rotations"] = columns["time"] / _time_per_rotation(manifest, discs, "rotations")
        origins["rotations"] = "derived from nominal speed"
    if "time" not in columns:
        columns["time"] = columns["rotations"] * _time_per_rotation(manifest, discs, "time")
        origins["time"] = "derived from nominal speed"
    if "sliding_distance" not in columns:
        columns["sliding_distance"] = columns["rotations"] * slipped
        origins["sliding_distance"] = "derived from nominal slip"


def _time_per_rotation(manifest: RunManifest, discs: TwinDisc, lacking: str) -> float:
    speed = manifest.conditions.curved_disc_speed
    if speed is None:
        raise ReaderError(
            f"run.toml: conditions.curved_disc_speed: missing; expected one, since the files hold no {lacking}; "
            'add curved_disc_speed = "800 mm/s" or the like'
        )
    return 2 * math.pi * discs.curved_disc.rolling_radius.value / speed.value


def _integrate(rate: Column, over: Column) -> Column:
    """Integrate by trapezoids from 0, at the first sample's rate until the first sample."""
    inner = np.diff(over) * (rate[1:] + rate[:-1]) / 2
    return np.concatenate([[over[0] * rate[0]], over[0] * rate[0] + np.cumsum(inner)])

"""Columns of a run that were not recorded: time, sliding distance, rotations and the friction coefficient.

Axes are derived from one another. An axis that restarts, at each step or file of the test, is made continuous before
anything is derived from it.
"""

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ReaderError
from tribopipe.documents.contact import ROTATIONS, SLIDING
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.signals import SignalName
from tribopipe.physics.axis_faults import continuous, mended
from tribopipe.results.run import Origin

Columns = dict[SignalName, Column]
Origins = dict[SignalName, Origin]


def complete_axes(columns: Columns, origins: Origins, manifest: RunManifest) -> None:
    """Add the axes that were not recorded, with their origins.

    The sliding distance of a pin that cannot be derived, without a speed or a track radius, is NaN throughout.

    Raises ``ReaderError`` where no axis was recorded, or the speed is not known by which time follows from distance.
    """
    _COMPLETED[manifest.progress.signal](columns, origins, manifest)


def _complete_sliding(columns: Columns, origins: Origins, manifest: RunManifest) -> None:
    """Derive time or sliding distance of a pin from the other one, or from rotations or cycles."""
    cycle = manifest.conditions.cycle
    if "sliding_distance" not in columns and "rotations" in columns and cycle is not None:
        rotations = mended(columns["rotations"], columns.get("time")).values
        columns["sliding_distance"] = cycle * continuous(rotations)
        origins["sliding_distance"] = "derived from rotations"
    have_time, have_distance = "time" in columns, "sliding_distance" in columns
    if not have_time and not have_distance:
        raise ReaderError(
            "found neither time nor sliding_distance among the signals; expected at least one; map one under "
            "[signals.columns] in run.toml, or map a cycle count to rotations and state track_radius, stroke or the "
            "radius of the ring"
        )
    if not have_distance:
        _derive_distance(columns, origins, manifest)
    elif not have_time:
        _derive_time(columns, origins, manifest)


def _derive_distance(columns: Columns, origins: Origins, manifest: RunManifest) -> None:
    time = continuous(columns["time"])
    speed, origin = _speed(columns, manifest, time)
    if speed is None:
        columns["sliding_distance"], origins["sliding_distance"] = np.full(len(time), np.nan), "unknown"
    else:
        columns["sliding_distance"], origins["sliding_distance"] = _integrate(speed, time), origin


def _derive_time(columns: Columns, origins: Origins, manifest: RunManifest) -> None:
    distance = continuous(columns["sliding_distance"])
    speed, origin = _speed(columns, manifest, distance)
    if speed is None:
        raise ReaderError(
            "run.toml: conditions.sliding_speed: missing; expected a value, since the files contain no time; add "
            'sliding_speed = "400 mm/s", or rotational_speed and track_radius, or stroke and frequency'
        )
    with np.errstate(divide="ignore", invalid="ignore"):
        columns["time"], origins["time"] = _integrate(1 / speed, distance), origin


def _speed(columns: Columns, manifest: RunManifest, along: Column) -> tuple[Column | None, Origin]:
    """Return the magnitude of the sliding speed along time or distance, measured or nominal; None if it is unknown."""
    if "sliding_speed" in columns:
        # A speed with a sign is that of strokes, or of a disc that reverses: the bodies slide in both directions.
        return _bridged(np.abs(columns["sliding_speed"]), along), "derived from measured speed"
    nominal = manifest.conditions.nominal_speed
    return None if nominal is None else np.full(len(along), nominal.value), "derived from nominal speed"


def _bridged(speed: Column, along: Column) -> Column:
    """Interpolate missing speeds linearly, the nearest one at both ends; all stay missing where none is known.

    A single missing speed would otherwise make every later distance missing.
    """
    seen = np.isfinite(speed) & np.isfinite(along)
    if not np.any(seen):
        return speed
    return np.where(np.isfinite(speed), speed, np.interp(along, along[seen], speed[seen]))


def _complete_rolling(columns: Columns, origins: Origins, manifest: RunManifest) -> None:
    """Derive time, rotations and slip distance of two discs from one another, by nominal speed and slip.

    The crowned disc does v₁/(2πr₁) rotations a second and slips by 2πr₁·|slip| in each.
    """
    if "time" not in columns and "rotations" not in columns and "sliding_distance" not in columns:
        raise ReaderError(
            "found neither time nor rotations among the signals; expected at least one; map one under "
            "[signals.columns] in run.toml"
        )
    slipped = manifest.described.slip_per_rotation(manifest.conditions)
    if "rotations" not in columns and "sliding_distance" in columns:
        columns["rotations"] = continuous(columns["sliding_distance"]) / slipped
        origins["rotations"] = "derived from nominal slip"
    if "rotations" not in columns:
        columns["rotations"] = continuous(columns["time"]) / _time_per_rotation(manifest, "rotations")
        origins["rotations"] = "derived from nominal speed"
    if "time" not in columns:
        columns["time"] = continuous(columns["rotations"]) * _time_per_rotation(manifest, "time")
        origins["time"] = "derived from nominal speed"
    if "sliding_distance" not in columns:
        columns["sliding_distance"] = continuous(mended(columns["rotations"], columns.get("time")).values) * slipped
        origins["sliding_distance"] = "derived from nominal slip"


_COMPLETED = {SLIDING.signal: _complete_sliding, ROTATIONS.signal: _complete_rolling}
"""How axes are derived by what wear grows along."""


def _time_per_rotation(manifest: RunManifest, lacking: str) -> float:
    speed = manifest.conditions.curved_disc_speed
    if speed is None:
        raise ReaderError(
            f"run.toml: conditions.curved_disc_speed: missing; expected a value, since the files contain no {lacking}; "
            'add this key, such as curved_disc_speed = "800 mm/s"'
        )
    return manifest.described.travel / speed.value


def _integrate(rate: Column, over: Column) -> Column:
    """Integrate by trapezoids from 0, at the first sample's rate until the first sample."""
    inner = np.diff(over) * (rate[1:] + rate[:-1]) / 2
    return np.concatenate([[over[0] * rate[0]], over[0] * rate[0] + np.cumsum(inner)])


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

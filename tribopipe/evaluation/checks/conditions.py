"""Checks of the recorded channels against what run.toml states of the test, and against each other."""

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from tribopipe.base.arrays import Column, Numbers, robust_deviation
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import DefaultUncertainty
from tribopipe.documents.signals import SignalName
from tribopipe.evaluation.checks.channels import Channel, channels, disc_speeds, positions
from tribopipe.evaluation.checks.registry import Trouble, check, check_cleaned
from tribopipe.evaluation.checks.samples import speed_of_motion
from tribopipe.evaluation.preprocessing.cleaning import CleanedRun
from tribopipe.evaluation.preprocessing.strokes import Stroke, whole_strokes
from tribopipe.physics.axis_faults import continuous
from tribopipe.physics.identities import ROLES, Identity, Role, ratios
from tribopipe.results.input_quantities import relative_input
from tribopipe.results.run import RawRun

_TOLERANCE = 0.05
"""Share by which a channel may differ from a stated value, or one side of an identity from the other."""
_ROUNDED = 0.5e-3
"""m: half a digit of a radius that is recorded in whole mm."""
_WINDOWS, _FEWEST_SAMPLES = 200, 5
_PLATEAU, _GAP = 5, 2
"""Windows that show a level, and those between two levels in which a channel may be on its way."""
_FLAT, _NOISY, _STEP = 0.05, 0.15, 0.1
"""Shares of a level within which it is one, without noise and with it, and by which the next one differs."""
_LINE = 0.5
"""Sum of squares about levels over that about a straight line, from which on it is the line."""
_OFF = 0.05
"""Share of the usual value below which a channel is off."""
_NOT_ODD = (1, 99)
"""Percentiles beyond which samples are drawn in."""
_MOST_LEVELS = 6
_RECORDED = (
    *("normal_force", "nominal_load", "sliding_speed", "nominal_speed", "rotational_speed"),
    *("track_radius", "frequency", "stroke"),
)
_STATED = ("track_radius", "rotational_speed", "frequency", "stroke", "sliding_speed", "slip")
_STROKE_TOLERANCE = 0.1
_COUNTED_TOLERANCE = 0.02
"""Share by which the frequency of counted strokes may differ from a stated one."""


class Levels(NamedTuple):
    """Values that a channel holds one after the other."""

    values: list[float]
    change: int
    """First sample of the second level."""


@check("warning")
def conditions_change(run: RawRun) -> Iterator[Trouble]:
    """Find load, speed or track radius that steps within a run of one nominal value."""
    found = channels(run)
    reciprocating = run.manifest.conditions.stroke is not None
    for role in _RECORDED:
        channel = found.get(role)
        if channel is None or (role == "sliding_speed" and reciprocating):
            continue
        levels = levels_of(np.abs(channel.values))
        if levels is not None:
            yield Trouble(
                channel.label,
                f"found {_spoken([channel.shown(value) for value in levels.values])} in sequence, with the first "
                f"change at {run.numbered(levels.change)}; expected one value per run, as stated in run.toml",
                "create one run per step with `tribopipe new FILE --split COLUMN`, or select steps = [n] under "
                "[[signals]] in run.toml",
            )


def levels_of(values: Column) -> Levels | None:
    """Return the levels between which a channel steps, above zero; None if it holds one, drifts, or is too short."""
    size = max(_FEWEST_SAMPLES, -(-len(values) // _WINDOWS))
    count = len(values) // size
    if count < 2 * _PLATEAU + _GAP:
        return None
    blocks = values[: count * size].reshape(count, size)
    known = np.flatnonzero(np.all(np.isfinite(blocks), axis=1))
    medians = np.median(blocks[known], axis=1)
    on = medians > _OFF * np.percentile(medians, 90) if len(medians) else np.empty(0, dtype=bool)
    known, medians = known[on], medians[on]
    changes = _changes(medians)
    parts = np.split(medians, changes)
    if not changes or not _apart(parts):
        return None
    levels = [float(np.median(part)) for part in parts]
    first = max(0, int(known[changes[0]]) - _PLATEAU) * size
    return Levels(levels, first + _turn(values[first : first + 2 * _PLATEAU * size], levels[0], levels[1]))


def _apart(parts: Sequence[Column]) -> bool:
    """Return whether what follows each other are levels, and not the ups and downs of one."""
    medians = [float(np.median(part)) for part in parts]
    spread = max(float(np.subtract(*np.percentile(part, [75, 25]))) for part in parts)
    nearest = min(abs(other - one) for one, other in pairwise(medians))
    apart = nearest > _FLAT * min(medians) and spread < nearest / 2
    return min(map(len, parts)) >= _PLATEAU and apart and not _drifts(np.concatenate(parts), parts)


def _drifts(values: Column, parts: Sequence[Column]) -> bool:
    """Return whether a straight line fits the values as well as levels do."""
    place = np.arange(len(values))
    from_line = values - np.polyval(np.polyfit(place, values, 1), place)
    from_levels = np.concatenate([part - np.median(part) for part in parts])
    return bool(np.sum(from_levels**2) > _LINE * np.sum(from_line**2))


def _turn(values: Column, one: float, other: float) -> int:
    """Return the place from which on values are nearer to another level, with the fewest on the wrong side."""
    nearer = np.abs(values - other) < np.abs(values - one)
    wrong_before = np.concatenate([[0], np.cumsum(nearer)])
    wrong_after = np.concatenate([np.cumsum(~nearer[::-1])[::-1], [0]])
    return int(np.argmin(wrong_before + wrong_after))


def _changes(medians: Column) -> list[int]:
    """Return where one level follows another."""
    if len(medians) < 2 * _PLATEAU + _GAP:
        return []
    noise = robust_deviation(np.diff(medians)) / np.sqrt(2)
    plateaus = sliding_window_view(medians, _PLATEAU)
    middle = np.median(plateaus, axis=1)
    uneven = np.ptp(plateaus, axis=1) / middle
    before, after = slice(len(middle) - _PLATEAU - _GAP), slice(_PLATEAU + _GAP, None)
    low = np.minimum(middle[before], middle[after])
    flat = np.maximum(uneven[before], uneven[after]) <= np.minimum(np.maximum(_FLAT, 5 * noise / low), _NOISY)
    apart = np.abs(middle[after] - middle[before]) > np.maximum(_STEP * low, 5 * noise)
    found: list[int] = []
    for at in (np.flatnonzero(flat & apart) + _PLATEAU).tolist():
        if not found or at - found[-1] > _GAP + _PLATEAU:
            found.append(at + 1)
    return found


def _spoken(items: list[str]) -> str:
    if len(items) > _MOST_LEVELS:
        return f"{', '.join(items[:3])} … {items[-1]}"
    return f"{', '.join(items[:-1])} and {items[-1]}"


@check("warning")
def conditions_differ(run: RawRun) -> Iterator[Trouble]:
    """Compare what is stated of the motion with its channels."""
    found = channels(run)
    for name in _STATED:
        stated: Quantity | None = run.manifest.slip if name == "slip" else getattr(run.manifest.conditions, name)
        channel = found.get(name)
        if stated is None or channel is None or (name == "sliding_speed" and run.manifest.conditions.stroke):
            continue
        average, of = (_mean, "mean") if name == "slip" else (_usual, "median")
        recorded = average(channel.values)
        if recorded is not None and abs(recorded - abs(stated.value)) > _allowed(name, stated, channel):
            yield Trouble(
                f"conditions.{name}",
                f"found {channel.shown(stated.value)} in run.toml, but a {of} of {channel.shown(recorded)} in column "
                f"{channel.label!r}; expected agreement within {100 * _TOLERANCE:.0f} %",
                f"correct {name}, or the unit of the column",
            )
    yield from _slip_of_speeds(run)
    yield from _unmapped_cycles(run, found.get("cycles"))


def _unmapped_cycles(run: RawRun, counted: Channel | None) -> Iterator[Trouble]:
    """Compare a stated frequency with the cycles in a column that is not used."""
    stated = run.manifest.conditions.frequency
    if stated is None or counted is None or run.origins["time"] != "measured":
        return
    time = continuous(run.columns["time"])
    seen = np.isfinite(time) & np.isfinite(counted.values)
    cycles = np.diff(counted.values[seen])
    if not np.any(cycles) or np.any(cycles < 0):
        return
    frequency, tolerance = speed_of_motion(time[seen], counted.values[seen]), _TOLERANCE + 1 / float(np.sum(cycles))
    if abs(frequency - stated.value) > max(tolerance * stated.value, 3 * stated.u_or_zero):
        yield Trouble(
            "conditions.frequency",
            f"found {stated.value:.4g} Hz in run.toml, but {frequency:.4g} Hz by the counts in column "
            f"{counted.label!r}; expected agreement within {100 * tolerance:.2g} %",
            "correct frequency, in cycles of two strokes per second, unless the column counts strokes",
        )


def _slip_of_speeds(run: RawRun) -> Iterator[Trouble]:
    """Compare the stated slip with that of two recorded speeds, whichever of the discs each of them is of."""
    stated = run.manifest.slip
    if stated is None:
        return
    radii = run.manifest.described.rolling_radii
    shares = (relative_input(one, DefaultUncertainty().rolling_radius).spread / one.value for one in radii)
    allowed = max(_TOLERANCE * abs(stated.value), 3 * stated.u_or_zero, 3 * math.hypot(*shares))
    for one, other in disc_speeds(run):
        speeds = _mean(one.values), _mean(other.values)
        if not speeds[0] or not speeds[1]:
            continue
        ratio = radii[1].value / radii[0].value if one.unit == "rad/s" else 1.0
        slips = (speeds[1] / speeds[0] * ratio - 1, speeds[0] / speeds[1] * ratio - 1)
        recorded = min(slips, key=lambda slip: abs(slip - stated.value))
        if abs(recorded - stated.value) > allowed:
            yield Trouble(
                "conditions.slip",
                f"found {stated.shown('%')} in run.toml, but {100 * recorded:.3g} % from columns {one.label!r} and "
                f"{other.label!r}; expected a difference of at most {100 * allowed:.2g} percentage points",
                "correct slip, rolling_radius, or the units of the columns",
            )


@check("warning")
def stated_speeds_differ(run: RawRun) -> Iterator[Trouble]:
    """Compare a stated sliding speed with the one that the stated motion gives."""
    conditions = run.manifest.conditions
    stated, moved = conditions.sliding_speed, conditions.speed_of_motion
    if stated is None or moved is None or abs(moved.value - stated.value) <= _TOLERANCE * stated.value:
        return
    how = "stroke and frequency" if conditions.stroke is not None else "rotational speed and track radius"
    yield Trouble(
        "conditions.sliding_speed",
        f"found {stated.shown('mm/s')}, but {how} give {moved.shown('mm/s')}; expected agreement within "
        f"{100 * _TOLERANCE:.0f} %",
        "correct one of them; the stated sliding speed is used, as the average speed",
    )


@check("warning")
def track_beyond_disc(run: RawRun) -> Iterator[Trouble]:
    """Find a track outside the disc that it is on, as where its diameter is given as its radius."""
    radius, contact = run.manifest.conditions.track_radius, run.manifest.contact
    disc = None if contact is None else contact.disc_of_track
    diameter = None if disc is None else disc.diameter
    if radius is not None and diameter is not None and 2 * radius.value > diameter.value:
        yield Trouble(
            "conditions.track_radius",
            f"found a track radius of {radius.shown('mm')} on a disc {diameter.shown('mm')} in diameter; expected a "
            "track on the disc",
            "enter the radius of the track, not its diameter, and check contact.disc.diameter",
        )


def _on(values: Column) -> Column:
    """Return the sizes of what is on."""
    size = np.abs(values[np.isfinite(values)])
    return size[size > _OFF * np.percentile(size, 90)] if len(size) else size


def _usual(values: Column) -> float | None:
    """Return the median of what is on."""
    on = _on(values)
    return float(np.median(on)) if len(on) else None


def _mean(values: Column) -> float | None:
    """Return the mean of what is on, to which the sliding distance is proportional, with odd samples drawn in."""
    on = _on(values)
    return float(np.mean(np.clip(on, *np.percentile(on, _NOT_ODD)))) if len(on) else None


def _allowed(name: str, stated: Quantity, channel: Channel) -> float:
    rounded = _ROUNDED if name == "track_radius" and _in_whole_millimetres(channel.values) else 0.0
    return max(_TOLERANCE * abs(stated.value), 3 * stated.u_or_zero, rounded)


def _in_whole_millimetres(radius: Column) -> bool:
    millimetres = radius * 1000
    known = millimetres[np.isfinite(millimetres)]
    return bool(np.allclose(known, np.round(known), rtol=0, atol=1e-6))


@check("warning")
def channels_disagree(run: RawRun) -> Iterator[Trouble]:
    """Find identities between channels, and stated values where there is no channel, that do not hold."""
    found, conditions = channels(run), run.manifest.conditions
    values: dict[Role, Numbers] = {role: found[role].values for role in ROLES if role in found}
    labels: dict[Role, str] = {role: found[role].label for role in ROLES if role in found}
    stated: dict[Role, Quantity | None] = {
        "track_radius": conditions.track_radius,
        "rotational_speed": conditions.rotational_speed,
        "normal_force": conditions.normal_load,
    }
    for role, quantity in stated.items():
        if role not in values and quantity is not None:
            values[role] = quantity.value
            labels[role] = f"conditions.{'normal_load' if role == 'normal_force' else role}"
    slid = run.manifest.progress.signal == "sliding_distance"
    if slid and run.origins["sliding_distance"] == "derived from nominal speed":
        values["sliding_distance"], labels["sliding_distance"] = run.sliding_distance, "conditions.sliding_speed"
    for identity, ratio in ratios(values):
        recorded = [role for role in identity.roles if role in found]
        tolerance = _identity_tolerance({role: found[role].values for role in recorded})
        if recorded != ["time"] and recorded and abs(ratio - 1) > tolerance:
            yield Trouble(
                labels[recorded[0]],
                f"found that {identity.formula} does not hold for {_listed(identity, labels)}: the left side is "
                f"{ratio:.3g} times the right side; expected both sides to agree to within {100 * tolerance:.0f} %",
                "check the units and scales of these columns and values",
            )


def _listed(identity: Identity, labels: Mapping[Role, str]) -> str:
    return ", ".join(repr(labels[role]) if "." not in labels[role] else labels[role] for role in identity.roles)


def _identity_tolerance(values: Mapping[Role, Column]) -> float:
    """Allow for radii in whole mm and for the last, begun count of rotations."""
    allowed = _TOLERANCE
    if "track_radius" in values and _in_whole_millimetres(values["track_radius"]):
        allowed += _ROUNDED / float(np.nanmedian(values["track_radius"]))
    if "rotations" in values:
        counted = np.diff(values["rotations"])
        allowed += 1 / max(1.0, float(np.sum(counted[counted > 0])))
    return allowed


class _Strokes(NamedTuple):
    """Strokes found in a column with a sign."""

    name: str
    strokes: list[Stroke]


def _strokes_in(run: RawRun) -> _Strokes | None:
    """Find strokes in the friction force or coefficient, as measured; None if they have no sign, or it is steady."""
    names: tuple[SignalName, ...] = ("friction_force", "friction_coefficient")
    for name in names:
        if name in run.columns and (strokes := whole_strokes(run.columns[name])):
            return _Strokes(name, strokes)
    return None


@check("warning")
def strokes_differ(run: RawRun) -> Iterator[Trouble]:
    """Compare the stated frequency and stroke with the strokes that were recorded."""
    found, conditions = _strokes_in(run), run.manifest.conditions
    if found is None:
        return
    time = continuous(run.columns["time"])
    period, stated = _stroke_duration(time, found.strokes), _stated_frequency(run)
    step = float(np.median(np.diff(time)))
    if stated is not None and period is not None and stated.value * step < 0.5:
        frequency, tolerance = 1 / (2 * period), max(stated.tolerance, 2 * step / period / len(found.strokes))
        if abs(frequency - stated.value) > tolerance * stated.value:
            yield Trouble(
                stated.where,
                f"found {len(found.strokes)} strokes of {period:.4g} s each in {found.name}, that is, a frequency "
                f"of {frequency:.4g} Hz; expected {stated.words} within {100 * tolerance:.2g} %",
                f"correct {stated.remedy}; the sliding distance is computed from {stated.key}",
            )
    if conditions.stroke is not None:
        yield from _stroke_length(run, found.strokes, conditions.stroke.value)


class _Frequency(NamedTuple):
    """A stated or counted frequency of the cycles, 1/s, and the share of it by which the recorded one may differ."""

    key: str
    value: float
    tolerance: float
    words: str
    remedy: str

    @property
    def where(self) -> str:
        """Name the key of run.toml, or the signal."""
        return self.key if self.key == "rotations" else f"conditions.{self.key}"


def _stated_frequency(run: RawRun) -> _Frequency | None:
    """Return the frequency in run.toml, or that of the speed or count from which the distance is computed."""
    conditions, origin = run.manifest.conditions, run.origins["sliding_distance"]
    frequency, speed, stroke = conditions.frequency, conditions.sliding_speed, conditions.stroke
    if frequency is not None:
        tolerance = max(_COUNTED_TOLERANCE, 3 * frequency.u_or_zero / frequency.value)
        words, remedy = f"the stated {frequency.value:.4g} Hz", "frequency, in reciprocating cycles per second"
        return _Frequency("frequency", frequency.value, tolerance, words, remedy)
    if stroke is not None and origin == "derived from rotations":
        return _counted_frequency(run)
    if speed is None or stroke is None or origin != "derived from nominal speed":
        return None
    remedy = "stroke, the unit of time, or sliding_speed, which is the average speed, 2·stroke·frequency"
    by_speed = speed.value / (2 * stroke.value)
    words = f"{by_speed:.4g} Hz from sliding_speed and stroke"
    return _Frequency("sliding_speed", by_speed, _TOLERANCE, words, remedy)


def _counted_frequency(run: RawRun) -> _Frequency | None:
    """Return the frequency by the recorded cycles; None if none are counted."""
    time, rotations = (continuous(run.columns[name]) for name in ("time", "rotations"))
    seen = np.isfinite(time) & np.isfinite(rotations)
    cycles = float(np.ptp(rotations[seen])) if np.any(seen) else 0.0
    if not cycles:
        return None
    frequency = speed_of_motion(time[seen], rotations[seen])
    remedy = "the column of rotations, which is to count reciprocating cycles, not strokes"
    words = f"{frequency:.4g} Hz from the recorded cycles"
    return _Frequency("rotations", frequency, _TOLERANCE + 1 / cycles, words, remedy)


def _stroke_duration(time: Column, strokes: list[Stroke]) -> float | None:
    """Return how long a stroke takes, s, by those that are as long as most are."""
    durations = np.array([time[stroke.end] - time[stroke.start] for stroke in strokes if stroke.end < len(time)])
    durations = durations[np.isfinite(durations) & (durations > 0)]
    if not len(durations):
        return None
    usual = float(np.median(durations))
    return float(np.mean(durations[np.abs(durations - usual) < 0.5 * usual]))


def _stroke_length(run: RawRun, strokes: list[Stroke], stated: float) -> Iterator[Trouble]:
    spans = [(channel, _span(channel.values, strokes)) for channel in positions(run)]
    channel, span = max(spans, key=lambda one: one[1], default=(None, 0.0))
    if channel is not None and span > _STROKE_TOLERANCE * stated and abs(span - stated) > _STROKE_TOLERANCE * stated:
        yield Trouble(
            "conditions.stroke",
            f"found {channel.shown(stated)} in run.toml, but column {channel.label!r} changes by "
            f"{channel.shown(span)} per stroke; expected agreement within {100 * _STROKE_TOLERANCE:.0f} %",
            "correct stroke, the distance from one turning point to the next",
        )


def _span(position: Column, strokes: list[Stroke]) -> float:
    """Return how far a position moves in a stroke."""
    parts = [position[stroke.start : stroke.end] for stroke in strokes]
    spans = [float(np.ptp(seen)) for part in parts if len(seen := part[np.isfinite(part)])]
    return float(np.median(spans)) if spans else 0.0


@check_cleaned("warning")
def strokes_unused(run: RawRun, cleaned: CleanedRun) -> Iterator[Trouble]:
    """Find strokes in a recording of which no friction coefficient per stroke is taken."""
    if _averaged(cleaned):
        return
    found, stated = _strokes_in(run), run.manifest.conditions.stroke is not None
    mu = run.columns.get("friction_coefficient", np.empty(0))
    if found is not None and not stated and not whole_strokes(mu):
        yield Trouble(
            found.name,
            f"found {len(found.strokes)} reciprocating strokes, but no stroke in run.toml, so that no friction "
            "coefficient per stroke is computed; expected a value for conditions.stroke",
            'add it, such as conditions.stroke = "10 mm"; otherwise, means over strokes include the turning points',
        )
    signed = next((name for name, values in _other_forces(run) if whole_strokes(values)), None)
    if found is None and signed is not None:
        yield Trouble(
            "friction_force",
            f"found an unsigned friction force, although the column {signed!r} changes sign with the stroke; "
            "expected the signed channel in a reciprocating test",
            f"map friction_force to {signed!r} under [signals.columns], and state conditions.stroke",
        )


def _other_forces(run: RawRun) -> Iterator[tuple[str, Column]]:
    """Yield the columns of tangential forces that are not assigned to a signal."""
    for name, extra in run.extras.items():
        lateral = name.casefold().removeprefix("daq.")[:2] in ("fx", "fy", "ft", "ff")
        if lateral and extra.values.dtype.kind == "f":
            yield name, extra.values


def _averaged(cleaned: CleanedRun) -> bool:
    return any(change.step == "stroke-wise-friction" for change in cleaned.record.changes)


@check_cleaned("note")
def no_friction_per_stroke(run: RawRun, cleaned: CleanedRun) -> Iterator[Trouble]:
    """Report where a stroke is stated and no friction coefficient per stroke can be taken."""
    conditions = run.manifest.conditions
    if conditions.stroke is None or _averaged(cleaned) or "friction_coefficient" not in run.columns:
        return
    if _strokes_in(run) is not None:
        return  # friction_sign says what is wrong with them
    samples = _samples_in_a_stroke(run)
    few = samples is not None and samples < _FEWEST_SAMPLES
    reason = f"{samples:.2g} samples per stroke" if few else "no change of sign with the stroke"
    yield Trouble(
        "friction_coefficient",
        f"found {reason}, so that no friction coefficient per stroke is computed; expected a signed friction force "
        f"with at least {_FEWEST_SAMPLES} samples per stroke",
        "the recorded friction coefficient is used, including the turning points",
    )


def _samples_in_a_stroke(run: RawRun) -> float | None:
    """Return the samples per stroke by the stated frequency."""
    frequency, steps = run.manifest.conditions.frequency, np.diff(run.columns["time"])
    steps = steps[np.isfinite(steps) & (steps > 0)]
    return None if frequency is None or not len(steps) else 1 / (2 * frequency.value * float(np.median(steps)))

"""Checks of the recorded samples: order of time, gaps, missing and repeated samples, signs and magnitudes."""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column
from tribopipe.base.errors import FitError, counted
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.preprocessing import ContinuousAxes
from tribopipe.documents.quantity import Quantity, force
from tribopipe.documents.recipe import DefaultUncertainty, Recipe
from tribopipe.documents.signals import AXES, SIGNALS, SignalName
from tribopipe.evaluation.checks.registry import Trouble, check, check_cleaned
from tribopipe.evaluation.load_and_friction import load_path
from tribopipe.evaluation.measurements.kinds import end_wear
from tribopipe.evaluation.preprocessing.axes import is_coarse
from tribopipe.evaluation.preprocessing.cleaning import CleanedRun, clean_run
from tribopipe.evaluation.preprocessing.strokes import whole_strokes
from tribopipe.evaluation.stroke_friction import stroke_friction
from tribopipe.physics.axis_faults import mended, segments
from tribopipe.results.input_quantities import stated_or_default
from tribopipe.results.run import RawRun

_FEWEST = 2
_GAP, _AROUND = 10.0, 11
"""A step this many times the median step, of all and of so many around it, is a gap."""
_NEAR = 0.01
"""Share of a test within which an interruption is where it is stated."""
_LEAST_FRICTION = 1e-3
"""Smallest friction coefficient of a test, in superlubricity."""
_OFFSET = 0.1
"""Offset of friction over friction in a reciprocating test above which it is reported."""
_ZERO = 0.01
"""Standard uncertainty of the zero of a force over the usual force above which it is reported."""
_BOTH_WAYS = 0.2
"""Share of the samples with friction that have the rarer sign, in a test there and back."""
_ANOTHER_UNIT = 5.0
"""A measured load this many times the nominal one, or this fraction of it, is in another unit."""
_MOST_DRIFT = 5e-6
"""m: what a sensor may drift in a test without being wrong in sign or unit."""
_MOST_THERMAL_DRIFT = 100e-6
"""m: what a steel frame of half a metre grows by within 17 K."""
_STEADY_TEMPERATURE = 0.5
"""K: within it a temperature counts as steady."""
_OFF_PLAN = 0.05
"""Share of the planned distance or rotations by which a test may end elsewhere."""
_STILL, _LONGER = 0.05, 10
"""Share of the samples, and multiple of the second longest stretch, from which on equal readings are a standstill."""
_DEAD = 0.5
"""Share of samples of exactly zero from which on a channel of friction was off."""
_FEWEST_COPIED, _COPIED = 16, 0.9
"""Samples, and their share that is the same, from which on one part of a recording is a copy of another."""
_CLIPPED, _PILED_UP = 0.02, 5.0
"""Share of the samples at the end of a range, and multiple of those next to it, from which on a sensor is clipped."""
_FEWEST_LEVELS = 16
"""Different values of a signal below which the last one may hold many samples by rounding."""
_WITHOUT_FRICTION, _LOST = 0.05, 0.03
"""Share of the usual friction below which bodies do not touch, and that of ∫F_N ds from which on it is reported."""
_SLIPPERY = 0.01
"""Friction coefficient above which bodies slide."""
_PARTS = 100
"""Parts of a recording in which friction is compared with the usual."""
_LIKE_STROKE = 0.2
"""Relative difference from the stroke within which a depth is the position along it."""
_IDLE, _MOST_IDLE = 0.15, 20
"""Share of the usual friction that a sensor which is not zeroed may read without contact, and the number of parts at
one end of a recording that may be idle: low friction for longer, or under a recorded load, is that of a film."""
_FITTING = 0.25
"""Share of the wear within which a rise is that wear."""
_JOINED = Recipe(clean_up=(ContinuousAxes(carried_over="never"),))


def _joined(run: RawRun, name: SignalName) -> Column:
    """Return an axis as preprocessing joins it where it restarts."""
    return clean_run(run, _JOINED).run.columns[name]


def _axes(run: RawRun) -> list[SignalName]:
    return [name for name in AXES if name in run.columns]


def _measured(run: RawRun) -> Iterator[tuple[SignalName, Column]]:
    for name, values in run.columns.items():
        if run.origins[name] == "measured":
            yield name, values


def _shown(name: SignalName, value: float) -> str:
    return Quantity(value=float(value), unit=SIGNALS[name].unit).shown("um" if name == "depth" else None)


@check("error")
def no_samples(run: RawRun) -> Iterator[Trouble]:
    """Refuse a run of one sample or none."""
    if len(run) < _FEWEST:
        yield Trouble("signals", f"found {len(run)} samples; expected at least {_FEWEST}", "export the complete test")


@check("error")
def empty_channel(run: RawRun) -> Iterator[Trouble]:
    """Refuse a signal without one number in it."""
    for name, values in _measured(run):
        if len(values) and not np.any(np.isfinite(values)):
            yield Trouble(
                name,
                "found no numeric values in the column; expected a recorded signal",
                "map the column that contains this signal, or remove the signal from run.toml",
            )


@check("error")
def axis_incomplete(run: RawRun) -> Iterator[Trouble]:
    """Refuse missing samples of time, rotations or sliding distance, without which nothing can be placed."""
    for name in _axes(run):
        values = run.columns[name]
        missing = np.flatnonzero(~np.isfinite(values + _integrated(run, name)))
        unrecorded = run.origins[name] == "unknown" or (run.origins[name] == "measured" and len(missing) == len(values))
        if len(missing) > 0 and not unrecorded:
            source = "" if run.origins[name] == "measured" else f", {run.origins[name]}"
            yield Trouble(
                name,
                f"found {len(missing)} missing{source}, the first at {run.numbered(int(missing[0]))}; "
                "expected a value for every sample",
                "correct or delete those rows, or export again",
            )


def _integrated(run: RawRun, name: SignalName) -> Column:
    """Return the speed from which an axis was derived: it bridges missing speeds; zero without such a speed."""
    derived = run.origins[name] == "derived from measured speed"
    return run.columns["sliding_speed"] if derived else np.zeros(len(run))


@check("error")
def axis_backward(run: RawRun) -> Iterator[Trouble]:
    """Refuse time or sliding distance that goes back, unless it restarts, and rotations that are no count."""
    for name, values in _measured(run):
        if name not in AXES:
            continue
        verdict = ", which is not a count" if name == "rotations" else ""
        below, back = np.flatnonzero(values < 0), segments(_without_glitches(run, name)).fault
        if back is not None:
            before = values[:back][np.isfinite(values[:back])][-1]
            yield Trouble(
                name,
                f"found {_shown(name, values[back])} at {run.numbered(back)} after {_shown(name, before)}{verdict}; "
                "expected increasing values, or a restart at zero",
                "delete the rows that are out of order, or export again",
            )
        elif verdict and len(below):
            yield Trouble(
                name,
                f"found {_shown(name, values[below[0]])} at {run.numbered(below[0])}{verdict}; expected zero or a "
                "positive number",
                "map the column with the number of rotations",
            )


def _without_glitches(run: RawRun, name: SignalName) -> Column:
    return run.columns[name] if name == "time" else mended(run.columns[name], _clock(run)).values


def _clock(run: RawRun) -> Column | None:
    return run.columns.get("time") if run.origins.get("time") == "measured" else None


@check("warning")
def counter_glitch(run: RawRun) -> Iterator[Trouble]:
    """Name a few readings of a counter that fall back, or leap ahead, while time goes on."""
    for name, values in _measured(run):
        found = mended(values, _clock(run)).samples if name in AXES and name != "time" else ()
        if found:
            yield Trouble(
                name,
                f"found {counted(len(found), 'wrong reading')}, the first {values[found[0]]:g} "
                f"{SIGNALS[name].unit} at {run.numbered(found[0])} after {values[found[0] - 1]:g}; expected "
                "increasing values",
                "preprocessing interpolates between the adjacent readings; check the counter",
            )


@check("error")
def axis_constant(run: RawRun) -> Iterator[Trouble]:
    """Refuse a run in which no time passes or nothing moves."""
    for name in _axes(run):
        values = _joined(run, name)
        if len(values) >= _FEWEST and np.all(np.isfinite(values)) and not values[-1] > values[0]:
            yield Trouble(
                name,
                f"found {_shown(name, values[-1])} at both start and end; expected increasing values",
                "check the column, and the speeds in run.toml",
            )


@check("warning")
def distance_unknown(run: RawRun) -> Iterator[Trouble]:
    """Report that the sliding distance of a pin is unknown."""
    if run.origins["sliding_distance"] == "unknown":
        yield Trouble(
            "conditions",
            "found neither a sliding distance nor a speed; expected one of them, to calculate wear rates and "
            "friction against distance",
            "add sliding_speed, or track_radius and rotational_speed, or stroke and frequency",
        )


@check("note")
def samples_averaged(run: RawRun) -> Iterator[Trouble]:
    """Report that means stand for samples where there are more than memory should hold."""
    if run.recording is not None:
        yield Trouble(
            "signals",
            f"found {run.recording.rows:,} samples, more than the memory limit allows; expected a shorter recording",
            f"averages of {run.recording.samples} samples each are evaluated instead; all recorded samples are kept "
            "under /entry/recorded",
        )


@check_cleaned("note")
def signals_preprocessed(_: RawRun, cleaned: CleanedRun) -> Iterator[Trouble]:
    """Report what preprocessing will do to the signals, unless a recipe states otherwise."""
    for change in cleaned.record.changes:
        yield Trouble(
            change.signal,
            f"found a signal that requires preprocessing: {change.what} ({change.why}); expected a signal that can be "
            "used as recorded",
            f"the raw signal is kept; a recipe without {change.step!r} skips this step",
        )


@check_cleaned("warning")
def load_sign(run: RawRun, cleaned: CleanedRun) -> Iterator[Trouble]:
    """Find a measured load that pulls: its sign is the sensor's, not the contact's."""
    load = run.columns.get("normal_force")
    if load is None or not np.any(np.isfinite(load)) or "normal_force" in cleaned.record.left_out:
        return
    median = float(np.nanmedian(load[np.abs(load) >= np.nanpercentile(np.abs(load), 95) / 2]))
    if median <= 0:
        yield Trouble(
            "normal_force",
            f"found a median of {_shown('normal_force', median)} under load; expected a positive load, since a "
            "negative load means no contact",
            "preprocessing inverts the sign; export compressive loads as positive values, or remove the signal",
        )


@check_cleaned("error")
def load_unit(run: RawRun, cleaned: CleanedRun) -> Iterator[Trouble]:
    """Refuse a measured load many times the nominal one or a fraction of it: kN for N, or grams for newtons."""
    nominal = run.manifest.conditions.normal_load
    if _in_another_unit(run, cleaned):
        yield Trouble(
            "conditions.normal_load",
            f"found a nominal load of {force(nominal)} and a measured load with a median of "
            f"{_shown('normal_force', np.median(_load_where_it_is_on(run, cleaned.run)))}; expected agreement",
            "correct normal_load or the unit of the column; remove the signal from run.toml if it is not the load",
        )


@check_cleaned("warning")
def load_not_nominal(run: RawRun, cleaned: CleanedRun) -> Iterator[Trouble]:
    """Compare measured and nominal load by their uncertainty."""
    load, stated = _load_where_it_is_on(run, cleaned.run), run.manifest.conditions.normal_load
    if not len(load) or _in_another_unit(run, cleaned):
        return
    nominal, _ = stated_or_default(stated, DefaultUncertainty().normal_load * stated.value)
    median, allowed = float(np.median(load)), max(3 * nominal.u_or_zero, 0.02 * nominal.value)
    counts = "nominal" if cleaned.run.recorded_load is None else "recorded"
    if abs(median - nominal.value) > allowed:
        yield Trouble(
            "normal_force",
            f"found a median of {_shown('normal_force', median)} under load; expected the nominal load of "
            f"{nominal.shown()} within three standard uncertainties or 2 %",
            f"the {counts} load is used for friction and wear; check normal_load, and the unit and zero of the load "
            "cell",
        )
    elif (excess := float(np.mean(load)) - median) > allowed:
        yield Trouble(
            "normal_force",
            f"found a mean of {_shown('normal_force', median + excess)} and a median of "
            f"{_shown('normal_force', median)} under load; expected them to agree within three standard uncertainties "
            "or 2 %",
            f'the {counts} load is used for wear; if the peaks are artifacts of the load cell, add the step "mask" '
            "with limits.normal_force",
        )


def _in_another_unit(run: RawRun, cleaned: CleanedRun) -> bool:
    """Return whether the load that counts is many times the nominal one or a fraction of it."""
    load = _load_where_it_is_on(run, cleaned.run)
    if "normal_force" not in cleaned.run.columns or not len(load):
        return False
    ratio = float(np.median(load)) / run.manifest.conditions.normal_load.value
    return not 1 / _ANOTHER_UNIT < ratio < _ANOTHER_UNIT


def _load_where_it_is_on(run: RawRun, mended: RawRun) -> Column:
    """Return the samples under load of the preprocessed normal force, else of the recorded one."""
    cleaned, recorded = mended.columns.get("normal_force"), run.columns.get("normal_force")
    load = recorded if cleaned is None else cleaned
    if load is None or not np.any(np.isfinite(load)):
        return np.empty(0)
    usual = min(float(np.nanpercentile(load, 95)), run.manifest.conditions.normal_load.value)
    return load[load > max(0.0, usual / 2)]


@check("warning")
def missing_samples(run: RawRun) -> Iterator[Trouble]:
    """Count missing samples; fits exclude them."""
    for name, values in _measured(run):
        missing = int(np.count_nonzero(~np.isfinite(values)))
        if name not in AXES and 0 < missing < len(values):
            yield Trouble(
                name,
                f"found {missing} of {len(values)} samples missing, the first at "
                f"{run.numbered(int(np.flatnonzero(~np.isfinite(values))[0]))}; expected a value for each sample",
                "fits exclude them",
            )


@check("warning")
def repeated_samples(run: RawRun) -> Iterator[Trouble]:
    """Count samples that stand twice at the same time."""
    time = run.columns["time"]
    repeated = np.flatnonzero(np.diff(time) == 0)
    if len(repeated) and not is_coarse(time, [values for name, values in _measured(run) if name not in AXES]):
        yield Trouble(
            "time",
            f"found {len(repeated)} repeated time stamps, the first at {run.numbered(repeated[0] + 1)}; expected "
            "each time stamp once",
            "check for rows exported twice",
        )
    copies = _copies(run)
    if copies:
        yield Trouble(
            "time",
            f"found that the rows starting at {run.numbered(copies[0])} repeat those at the start of the recording; "
            "expected each sample once",
            "delete the copy: its sliding distance is counted again",
        )


def _copies(run: RawRun) -> list[int]:
    """Return where time restarts and every measured signal repeats what it was from the first sample on."""
    starts, measured = segments(run.columns["time"]).starts, [values for _, values in _measured(run)]
    moving = any(np.ptp(values[np.isfinite(values)]) > 0 for values in measured[1:] if np.any(np.isfinite(values)))
    return [start for start in starts if moving and _same(measured, start)]


def _same(measured: list[Column], start: int) -> bool:
    count = min(start, len(measured[0]) - start)
    same = [np.isclose(values[:count], values[start : start + count], equal_nan=True) for values in measured]
    return count >= _FEWEST_COPIED and float(np.mean(np.all(same, axis=0))) > _COPIED


_COUNTED = "; if so, map a measured distance or rotations, since the distance derived from speed includes the gaps"


@check("warning")
def recording_gap(run: RawRun) -> Iterator[Trouble]:
    """Find places where recording stopped for a while."""
    every = np.diff(run.columns["time"])
    known = np.flatnonzero(np.isfinite(every))
    steps = every[known]
    usual = float(np.median(steps[steps > 0])) if np.any(steps > 0) else 0.0
    long = known[steps > _GAP * np.maximum(usual, _around(steps))]
    gaps = [gap for gap in long.tolist() if not _is_stated_stop(run, gap)]
    if usual and gaps:
        yield Trouble(
            "time",
            f"found {_gaps(len(gaps))} of {every[gaps[0]]:.3g} s after {run.numbered(gaps[0])}; "
            f"expected steps of {usual:.3g} s",
            "check whether the test was stopped there" + (_COUNTED if _by_the_clock(run) else ""),
        )


def _around(steps: Column) -> Column:
    """Return the median of the sampling intervals around each one: from where the rate was changed, that of the new."""
    from scipy.ndimage import median_filter

    return np.asarray(median_filter(steps, size=_AROUND, mode="nearest")) if len(steps) else steps


def _gaps(count: int) -> str:
    return "a gap" if count == 1 else f"{count} gaps, the first"


def _by_the_clock(run: RawRun) -> bool:
    """Return whether the sliding distance goes on while nothing slides."""
    return run.origins[run.manifest.progress.signal] in ("derived from nominal speed", "derived from measured speed")


def _is_stated_stop(run: RawRun, sample: int) -> bool:
    """Return whether the test was interrupted after a sample as stated in run.toml, and did not slide meanwhile."""
    axis = run.columns[run.manifest.progress.signal]
    near = max(float(axis[sample + 1] - axis[sample]), _NEAR * float(np.nanmax(axis)))
    return not _by_the_clock(run) and any(abs(stop.place - axis[sample]) <= near for stop in run.manifest.interruptions)


@check("warning")
def dead_channel(run: RawRun) -> Iterator[Trouble]:
    """Find channels that never move, friction that is zero through most of a test, and depth that stands still."""
    for name, values in _measured(run):
        seen = values[np.isfinite(values)]
        if name not in ("depth", "friction_force", "friction_coefficient") or len(seen) <= _FEWEST:
            continue
        zero = float(np.mean(seen == 0)) if name != "depth" else 0.0
        found = f"0 in {100 * zero:.0f} % of the samples" if zero > _DEAD else None
        found = f"{_shown(name, seen[0])} throughout" if np.ptp(seen) == 0 else found
        if found is not None:
            yield Trouble(name, f"found {found}; expected a varying signal", "check whether the channel was on")
        elif name == "depth" and (still := _standstill(values)) is not None:
            first, count = still
            yield Trouble(
                name,
                f"found {_shown(name, values[first])} in {count} consecutive samples, starting at "
                f"{run.numbered(first)}; expected a varying signal",
                "check whether the sensor was on; if not, delete these values in a copy of the file",
            )


def _standstill(values: Column) -> tuple[int, int] | None:
    """Return first sample and number of equal readings in a row that noise and resolution do not explain."""
    starts = np.concatenate([[0], np.flatnonzero(np.diff(values) != 0) + 1])
    counts = np.diff(starts, append=len(values))
    if len(counts) < 2:
        return None
    longest = int(np.argmax(counts))
    value, others = values[starts[longest]], np.delete(counts, longest)
    # An end of the range is a matter of clipped_signal.
    clipped = value != 0 and value in (np.nanmin(values), np.nanmax(values))
    is_long = counts[longest] > max(_STILL * len(values), _LONGER * int(np.max(others)))
    return (int(starts[longest]), int(counts[longest])) if is_long and not clipped else None


@check("warning")
def clipped_signal(run: RawRun) -> Iterator[Trouble]:
    """Find depth or friction that reaches the end of its range, where samples pile up at one value."""
    for name, values in _measured(run):
        if name not in ("depth", "friction_force", "friction_coefficient"):
            continue
        levels, counts = np.unique(values[np.isfinite(values)], return_counts=True)
        for end, beside in ((-1, -2), (0, 1)):
            if len(levels) >= _FEWEST_LEVELS and levels[end] != 0 and _piled_up(counts, end, beside):
                yield Trouble(
                    name,
                    f"found {_shown(name, levels[end])}, the {'highest' if end else 'lowest'} value, in "
                    f"{100 * counts[end] / np.sum(counts):.0f} % of the samples; expected few samples with this value",
                    "check whether the sensor or its amplifier was saturated; if so, larger changes were not recorded: "
                    f"mask these samples by setting limits.{name} just {'below' if end else 'above'} this value for "
                    'the step "mask" in a recipe, or repeat the test with a larger measuring range',
                )


def _piled_up(counts: NDArray[np.intp], end: int, beside: int) -> bool:
    return bool(counts[end] > max(_CLIPPED * np.sum(counts), _PILED_UP * counts[beside]))


@check_cleaned("warning")
def contact_lost(run: RawRun, cleaned: CleanedRun) -> Iterator[Trouble]:
    """Find parts of a test that count as sliding under load, but have no friction."""
    names: tuple[SignalName, ...] = ("friction_force", "friction_coefficient")
    friction = next((run.columns[name] for name in names if name in run.columns), None)
    slid = cleaned.run.sliding_distance
    if friction is None or len(run) < _PARTS or not np.all(np.isfinite(slid)):
        return
    middle = _middle(friction)
    size = _size if middle is None else _swing
    parts = np.array_split(friction - (middle or 0.0), _PARTS)
    sizes = np.array([size(part[np.isfinite(part)]) for part in parts])
    ends = np.cumsum([0, *map(len, parts)]).clip(max=len(run) - 1)
    worked = np.diff(load_path(cleaned.run, slid[ends]))
    force = run.manifest.conditions.normal_load.value if "friction_force" in run.columns else 1.0
    usual = float(np.median(sizes))
    without = sizes < min(_WITHOUT_FRICTION * usual, _SLIPPERY * force)
    if cleaned.run.recorded_load is None:
        without |= _idle_ends(sizes, usual)
    lost = float(np.sum(worked[without]) / np.sum(worked)) if np.sum(worked) > 0 else 0.0
    idle = next((one.offset for one in cleaned.record.changes if one.step == "idle" and one.offset is not None), None)
    if idle is not None and idle.value > _LOST * (idle.value + float(np.ptp(slid))):
        yield Trouble(
            "friction_force",
            f"found no friction at the beginning or end of the recording; {idle.shown('m')} at the nominal speed do "
            "not count as sliding distance; expected friction throughout",
            "check that friction was recorded from the beginning to the end of sliding; if it was not, list the "
            'clean_up steps without "idle" in a recipe',
        )
    if lost > _LOST:
        begun = (
            ""
            if not without[0]
            else (
                '; if time or distance then starts above zero, set carried_over = "always" for the step '
                '"continuous-axes" in a recipe'
            )
        )
        yield Trouble(
            "friction_force",
            f"found almost no friction over {100 * lost:.0f} % of the sliding distance, first at "
            f"{run.numbered(int(ends[:-1][without][0]))}; expected friction wherever the bodies slide under load",
            "check whether the bodies were in contact and moving; if not, delete these rows, which make k_D "
            f"too small by about this fraction{begun}",
        )


def _idle_ends(sizes: Column, usual: float) -> NDArray[np.bool_]:
    """Return a mask of the parts, at either end, after which friction is at once more than half of the usual."""
    found = np.zeros(len(sizes), dtype=bool)
    for there, mask in ((sizes, found), (sizes[::-1], found[::-1])):
        idle = int(np.argmax(there > _IDLE * usual))
        if idle <= _MOST_IDLE and there[idle + 1] > usual / 2:
            mask[:idle] = True
    return found


def _size(friction: Column) -> float:
    """Return the size of a friction of one sign, whose noise about zero is none; infinity without samples."""
    return abs(float(np.median(friction))) if len(friction) else np.inf


def _swing(friction: Column) -> float:
    """Return the 90th percentile, at a small part of what NumPy's takes for few samples; infinity without samples."""
    if not len(friction):
        return np.inf
    friction = np.abs(friction)
    share, place = math.modf(0.9 * (len(friction) - 1))
    around = [int(place), min(int(place) + 1, len(friction) - 1)]
    below, above = np.partition(friction, around)[around]
    return float(below + share * (above - below))


def _middle(friction: Column) -> float | None:
    """Return the offset of a friction of strokes, which has both signs; none of one whose sign does not change."""
    ends = np.nanpercentile(friction, [5, 95]) if np.any(np.isfinite(friction)) else np.zeros(2)
    both_ways = ends[0] < 0 < ends[1] and np.min(np.abs(ends)) > _WITHOUT_FRICTION * np.max(np.abs(ends))
    return float(np.mean(ends)) if both_ways else None


@check_cleaned("warning")
def friction_offset(_: RawRun, cleaned: CleanedRun) -> Iterator[Trouble]:
    """Find friction that differs between forward and backward strokes, in a mean of |μ|."""
    strokes = stroke_friction(cleaned.run)
    if strokes is None or strokes.used == "half-difference":
        return
    offset, mu = abs(strokes.offset.value), strokes.half_difference.value
    if offset > _OFFSET * mu:
        yield Trouble(
            "friction_force",
            f"found a friction force that differs between forward and backward strokes, with an offset of {offset:.2g} "
            f"for a friction coefficient of {mu:.2g}; expected an offset of less than {100 * _OFFSET:.0f} %",
            'zero the friction force, or set method = "half-difference" for the step "stroke-wise-friction" in a '
            "recipe: half the difference does not depend on the offset",
        )


@check_cleaned("warning")
def uncertain_zero(_: RawRun, cleaned: CleanedRun) -> Iterator[Trouble]:
    """Find forces whose zero was not the same before and after the test, or was seen too shortly."""
    for change in cleaned.record.changes:
        if change.step != "zero" or change.offset is None:
            continue
        seen = cleaned.run.columns[change.signal]
        usual, spread = float(np.nanmedian(np.abs(seen))), change.offset.u_or_zero
        if spread > _ZERO * usual:
            yield Trouble(
                change.signal,
                f"found a {change.what.removesuffix(' subtracted')}, with a standard uncertainty of "
                f"{Quantity(value=spread, unit='N').shown('mN')}, {100 * spread / usual:.2g} % of the usual force; "
                f"expected at most {100 * _ZERO:.0f} %",
                "let the load cell warm up and zero it before the test; a zero that is different after the test is "
                "interpolated linearly in time",
            )


@check_cleaned("warning")
def friction_sign(run: RawRun, cleaned: CleanedRun) -> Iterator[Trouble]:
    """Find reciprocating friction that is not given stroke by stroke, so that its mean has no meaning."""
    mu = cleaned.run.columns.get("friction_coefficient", np.empty(0))
    rubbing = mu[np.isfinite(mu) & (mu != 0)]
    strokes = any(change.step == "stroke-wise-friction" for change in cleaned.record.changes)
    reciprocating = run.manifest.conditions.stroke is not None
    if reciprocating and not strokes and whole_strokes(mu, any_offset=True):
        yield Trouble(
            "friction_coefficient",
            "found an offset larger than the friction force itself; expected a friction force that changes sign with "
            "the stroke",
            'zero the friction force, or set method = "half-difference" for the step "stroke-wise-friction" in a '
            "recipe",
        )
    if len(rubbing) and _BOTH_WAYS <= (negative := float(np.mean(rubbing < 0))) <= 1 - _BOTH_WAYS:
        yield Trouble(
            "friction_coefficient",
            f"found {100 * negative:.0f} % negative values; expected values of one sign, or strokes that can be "
            "separated",
            "record at least 5 samples per stroke; a mean over both directions is not a friction coefficient"
            if reciprocating
            else "for a reciprocating test, state conditions.stroke and record at least 5 samples per stroke; "
            "otherwise, zero the force",
        )


@check_cleaned("warning")
def implausible_friction(run: RawRun, cleaned: CleanedRun) -> Iterator[Trouble]:
    """Catch a flipped sign or a wrong unit of friction."""
    mu = _friction(run, cleaned.run)
    if mu is None or not np.any(np.isfinite(mu)):
        return
    median, usual = float(np.nanmedian(mu)), float(np.nanmedian(np.abs(mu)))
    if not -_LEAST_FRICTION <= median <= 2.0 or 0 < usual < _LEAST_FRICTION:
        yield Trouble(
            "friction_coefficient",
            f"found a median of {median:.3g}; expected {_LEAST_FRICTION:g} to 2",
            "check the sign and unit of friction force and load",
        )


def _friction(run: RawRun, mended: RawRun) -> Column | None:
    """Return the friction coefficient as recorded in one direction; else after preprocessing, on which signs depend."""
    one_way = run.manifest.conditions.stroke is None and mended.origins.get("friction_coefficient") == "measured"
    recorded, mu = (one.columns.get("friction_coefficient") for one in (run, mended))
    beyond_all = mu is not None and not np.any(np.isfinite(mu))  # all of it was masked as impossible
    return recorded if one_way or beyond_all else mu


@check("error")
def interruption_after_end(run: RawRun) -> Iterator[Trouble]:
    """Refuse an interruption after the end of the test: what it measured would stand where there is no curve."""
    progress = run.manifest.progress
    if not run.manifest.interruptions or run.origins[progress.signal] == "unknown":
        return
    end = float(np.nanmax(_joined(run, progress.signal)))
    for number, stop in enumerate(run.manifest.interruptions):
        if stop.place > end:
            yield Trouble(
                f"interruptions[{number}].{progress.signal}",
                f"found {progress.shown(stop.place)} in a run of {progress.shown(end)}; expected an interruption "
                "within the run",
                f"state the {progress.words} since the start of the test; for the end of the test, use end_values",
            )


@check("warning")
def implausible_depth(run: RawRun) -> Iterator[Trouble]:
    """Compare the rise of the depth reading with the post-test measurement: sign, unit or a broken sensor."""
    read = run.columns.get("depth")
    if read is None or np.count_nonzero(np.isfinite(read)) < _FEWEST:
        return
    depth = run.manifest.depth_scale.value * read
    span = float(np.nanmax(depth) - np.nanmin(depth))
    name, radius = _worn_radius(run.manifest)
    if radius is not None and span > radius.value:
        yield Trouble(
            "depth",
            f"found readings that differ by {Quantity(value=span, unit='m').shown('um')}; expected less than the "
            f"{name} of {Quantity(value=radius.value, unit='m').shown('um')}",
            "check the column's unit",
        )
    stroke = run.manifest.conditions.stroke
    if stroke is not None and abs(span / stroke.value - 1) < _LIKE_STROKE:
        yield Trouble(
            "depth",
            f"found readings that differ by {Quantity(value=span, unit='m').shown('mm')}, about as much as the stroke "
            f"of {stroke.shown('mm')}; expected the wear depth, not the position along the stroke",
            "map another column to depth in run.toml, or none",
        )
    yield from _drifted(run, depth[np.isfinite(depth)])


def _drifted(run: RawRun, depth: Column) -> Iterator[Trouble]:
    """Compare the rise of the reading with the wear: drift, then the scar, sign and unit may be the reason."""
    total, rise = _lost(run), float(depth[-1] - depth[0])
    started_anew = any(stop.remounted for stop in run.manifest.interruptions)
    if total is None or started_anew or abs(rise - total.value) <= max(0.5 * total.value, _MOST_DRIFT):
        return
    listed = 'add the step "invert" with signals = ["depth"] after the default steps of a recipe'
    turn = f"if the depth signal decreases with wear, {listed}; otherwise, " if rise < 0 else ""
    others = f"{turn}check the sign and unit of the depth and of the post-test measurements{_misread_size(run, rise)}"
    drift = f"{_unmeasured_groove(run, total, rise)}{_thermal_drift(run)}"
    thermal = abs(rise - total.value) <= _MOST_THERMAL_DRIFT
    yield Trouble(
        "depth",
        f"found a change of {Quantity(value=rise, unit='m').shown('um')} in the depth signal, but a total wear depth "
        f"of {total.shown('um')}; expected about the same value",
        f"{drift}; or {others}" if thermal else f"{others}; thermal drift is rarely that large",
    )


def _unmeasured_groove(run: RawRun, total: Quantity, rise: float) -> str:
    """Name wear of a counterbody that nobody measured as the reason of a depth signal that is too large."""
    seen = run.manifest.pin is None or any(".disc_" in f".{name}" for name in run.manifest.end_values.model_fields_set)
    return "" if seen or rise < total.value else "measure the wear of the disc, if it has worn; otherwise, "


def _thermal_drift(run: RawRun) -> str:
    """Name thermal drift as the reason, and the temperature that moved, or the settling that shows it."""
    remedy = "thermal drift is likely: let the tribometer warm up before the test, and record the temperature"
    recorded = run.columns.get("temperature")
    seen = np.empty(0) if recorded is None else recorded[np.isfinite(recorded)]
    moved = float(np.ptp(seen)) if len(seen) else 0.0
    if moved > _STEADY_TEMPERATURE:
        return f"thermal drift is likely, since the temperature changed by {moved:.2g} K: keep it constant"
    return remedy if not len(seen) else remedy.removesuffix(", and record the temperature")


def _misread_size(run: RawRun, rise: float) -> str:
    """Name a scar given by its radius, or a ball by its diameter, where the other one would make the depths agree."""
    pin, end = run.manifest.pin, run.manifest.end_values
    scar = end.pin_scar_diameter
    if scar is None or pin is None or pin.constant_area:
        return ""
    contact = run.manifest.described
    twice = scar.model_copy(update={"value": 2 * scar.value})
    halved = pin.radius.model_copy(update={"value": pin.radius.value / 2})
    resized = contact.resized(halved)
    size = next(iter(contact.inputs))
    twice_as_large = "a diameter" if size.endswith("radius") else "twice the diameter"
    others: dict[str, dict[str, object]] = {
        "pin_scar_diameter is not a radius: twice": {"end_values": end.model_copy(update={"pin_scar_diameter": twice})},
        f"contact.{size} is not {twice_as_large}: half": {"contact": resized},
    }
    for words, changes in others.items():
        total = _lost(replace(run, manifest=run.manifest.model_copy(update=changes)))
        if total is not None and abs(rise - total.value) < _FITTING * total.value:
            return f", and that {words} that value would agree"
    return ""


def _worn_radius(manifest: RunManifest) -> tuple[str, Quantity | None]:
    """Return the radius that is worn flat, and what it is called; None if the bodies are not described."""
    return ("pin radius", None) if manifest.contact is None else manifest.contact.worn_radius


def _lost(run: RawRun) -> Quantity | None:
    """Return the depth that both bodies have lost at the end, m; None if that was not measured."""
    end = run.manifest.end_values
    if run.manifest.pin is not None:
        try:
            wear = end_wear(run, DefaultUncertainty())
        except FitError:
            return None
        return None if wear is None else wear.total
    if end.curved_disc_wear_depth is None or end.flat_disc_wear_depth is None:
        return None
    return Quantity(value=end.curved_disc_wear_depth.value + end.flat_disc_wear_depth.value, unit="m")


def broken_off(run: RawRun) -> str | None:
    """Report how far a test went that ended before its planned end; None if it did not."""
    progress, planned = run.manifest.progress, run.manifest.planned
    axis = _joined(run, progress.signal)
    reached = float(axis[-1]) if len(axis) else 0.0
    if planned is None or not reached < (1 - _OFF_PLAN) * planned:
        return None
    return f"{progress.shown(reached)} of the planned {progress.shown(planned)}"


@check("warning")
def distance_not_planned(run: RawRun) -> Iterator[Trouble]:
    """Find tests that were broken off, and speeds that do not fit time and distance, or rotations."""
    manifest, progress = run.manifest, run.manifest.progress
    planned, speed = manifest.planned, manifest.nominal_speed
    time, axis = _joined(run, "time"), _joined(run, progress.signal)
    reached = float(axis[-1]) if len(axis) else 0.0
    if planned is not None and np.isfinite(reached) and abs(reached / planned - 1) > _OFF_PLAN:
        yield Trouble(
            progress.signal,
            f"found {progress.shown(reached)} at the end; expected the planned {progress.shown(planned)}",
            f"correct {progress.signal} if the test was stopped early",
        )
    duration = float(time[-1] - time[0]) if len(time) > 1 else 0.0
    counted = run.origins[progress.signal] in ("measured", "derived from rotations")
    both = run.origins["time"] == "measured" and counted
    if speed is not None and both and duration > 0:
        travel = 1.0 if manifest.contact is None else manifest.contact.travel
        mean = speed_of_motion(time, axis) * travel
        if not 0.95 <= mean / speed.value <= 1.05:
            yield Trouble(
                progress.speed,
                f"found a mean speed of {mean:.4g} m/s from time and {progress.words}; expected the nominal "
                f"{speed.value:.4g} m/s",
                f"correct {progress.speed}, or the units of both columns",
            )


def speed_of_motion(time: Column, axis: Column) -> float:
    """Return the mean rate of a distance or count without the stops, in which it does not advance."""
    advances = np.concatenate([[True], np.diff(axis) > 0])
    steps, slid = np.diff(time[advances]), np.diff(axis[advances])
    if not len(steps):
        return 0.0
    moves = steps <= _GAP * np.median(steps)
    return float(np.sum(slid[moves]) / np.sum(steps[moves]))


@check_cleaned("warning")
def axis_offset(_: RawRun, cleaned: CleanedRun) -> Iterator[Trouble]:
    """Find counters that may be carried over from an earlier test, where no other axis shows it."""
    for name, values in _measured(cleaned.run):
        if name in AXES and len(values) > 1 and abs(values[0]) > 0.05 * (values[-1] - values[0]) > 0:
            yield Trouble(
                name,
                f"found {_shown(name, values[0])} at the first sample; expected a start near zero",
                'if the counter was not reset after an earlier test, set carried_over = "always" for the step '
                '"continuous-axes" in a recipe; otherwise, record the test from its start',
            )

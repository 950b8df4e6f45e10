"""Drift of the depth sensor, found together with wear or, as in the paper, before it.

By default the reading is fitted by one statistical model of wear and of everything else that the sensor reads
(tribopipe.physics.depth_model). The paper (Section 2) assumes that the capacitive sensor drifts linearly and matches
its curve at the largest sliding distance to the wear found on the pin, in two steps:

    wear(t) = g·(reading(t) − z) − ρ·(t − t₀),     ρ = (g·(reading(t_end) − z) − h_end) / (t_end − t₀)

with g the sensor's scale (1 unless run.toml states otherwise), the zero offset z at the start t₀ of sliding and h_end
the wear of pin plus disc, or of both discs, by the post-test measurements. The end reading is the value at the end
sliding of a
straight line through the last samples. z is that of a fit of the same model, with r(t) = (t − t₀) / (t_end − t₀),

    reading(t) − r·(reading(t_end) − h_end / g) = z·(1 − r) + q·h(s)

to the first samples, with h(s) the wear of a pin, or of two discs, that reaches the post-test measurement at the end:
neither wear nor drift within the window is taken for offset, even where the record begins long after sliding did.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tribopipe.base.arrays import Column, Numbers
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe
from tribopipe.evaluation.depth_reading import (
    MOST_DEVIATION,
    Share,
    best_pin,
    course_of_both,
    depth_model,
    depth_record,
    groove_share,
    pin_reading,
    reading_of_both,
    require_samples,
    sensor_scale,
    sliding_time,
)
from tribopipe.evaluation.load_and_friction import load_course
from tribopipe.evaluation.measurements.end_wear import EndWear, TotalWear
from tribopipe.evaluation.measurements.kinds import groove_alone, measurements_of
from tribopipe.evaluation.measurements.readings import combined
from tribopipe.evaluation.unmeasured_groove import wear_of_both
from tribopipe.physics.autocorrelation import inflation, left_of
from tribopipe.physics.depth_model.block_averages import baseline
from tribopipe.physics.depth_model.posterior import DepthPosterior, depth_posterior
from tribopipe.results.evaluation import DepthModel, DriftCorrection
from tribopipe.results.finding import Finding, reworded
from tribopipe.results.run import CorrectedRun, RawRun

_FEWEST_IN_WINDOW = 8
_LEAST_WEAR = 1e-9
"""Depth, m, whose shape serves where none was measured."""
_ON_THE_WAY = np.linspace(0.0, 1.0, 401)[1:] ** 2
"""Shares of the depth of a pin at which its part of the wear of both bodies is calculated."""


@dataclass(frozen=True)
class SensorTrace:
    """The depth reading and what the correction takes from it."""

    reading: Column
    ramp: Column
    """0 at the start of sliding, 1 at the last sample."""
    duration: float
    slid: float
    """Sliding distance at the end of the run, m, whether or not depth was still recorded there."""
    zero_offset: Quantity
    """Zero offset from the best estimates; u from the noise in the first samples."""
    end_reading: Quantity
    unworn_end: float = 0.0
    """Depth signal expected at the end without wear, m, from the best estimates."""
    lean: float = 0.0
    """Metres by which the zero offset falls for each metre that ``unworn_end`` is higher."""

    def zero(self, end_wear: Numbers, zero: Numbers, end: Numbers, scale: Numbers) -> Numbers:
        """Return the zero offset, m, for a post-test measurement, end reading (m) and scale of the sensor."""
        return zero - self.lean * (end - end_wear / scale - self.unworn_end)

    def wear(self, end_wear: Numbers, zero: Numbers, end: Numbers, scale: Numbers) -> Column:
        """Return the corrected depth, m, for a post-test measurement, zero offset, end reading (m) and sensor scale."""
        zero = self.zero(end_wear, zero, end, scale)
        return np.asarray(scale * (self.reading - zero - self.ramp * (end - zero)) + self.ramp * end_wear)


def read_trace(run: RawRun, end: EndWear | TotalWear, recipe: Recipe) -> SensorTrace:
    """Take zero offset and end reading from the depth signal of a run with this wear at its end.

    Raises ``FitError`` where fewer than 16 samples of depth are left.
    """
    seen = require_samples(run)
    distance, time, reading = run.sliding_distance, run.columns["time"], run.columns["depth"]
    placed = np.isfinite(distance) & np.isfinite(time)
    start, duration = sliding_time(distance[placed], time[placed])
    slid = float(distance[placed][-1])
    share = _worn_share(run, slid)(np.maximum(distance[seen], 0.0))
    if isinstance(end, EndWear):
        wear = _pin_wear(run, end, share, recipe)
    else:
        wear = course_of_both(run, recipe)(max(end.total.value, _LEAST_WEAR), share)
    ramp = (time - start) / duration
    s, y, noise = distance[seen], reading[seen], _noise(distance[seen], reading[seen], wear)
    first, rest = _windows(s, recipe.drift.window)
    last = _read(_weights(np.ones_like(s[rest:]), s[rest:] - slid), y[rest:], noise)
    unworn_end = last.value - end.total.value / sensor_scale(run, recipe).value
    begun = ramp[seen][:first]
    weights = _weights(1 - begun, wear[:first])
    return SensorTrace(
        reading=reading,
        ramp=ramp,
        duration=duration,
        slid=slid,
        zero_offset=_read(weights, y[:first] - begun * unworn_end, noise),
        end_reading=last,
        unworn_end=unworn_end,
        lean=float(weights @ begun),
    )


def _worn_share(run: RawRun, slid: float) -> Share:
    """Return what share of the volume at the end is worn at sliding distances, m, by Archard's law."""
    load = load_course(run)
    if load is None:
        return lambda distance: distance / slid
    whole = float(np.interp(slid, load.distance, load.path))
    return lambda distance: np.interp(distance, load.distance, load.path) / whole


def _pin_wear(run: RawRun, end: EndWear, share: Column, recipe: Recipe) -> Column:
    """Return the wear depth of a pin that reaches its post-test measurement, m, against the share of the distance."""
    pin = best_pin(run, end, recipe)
    return pin.worn(pin.volume(max(end.pin_depth.value, _LEAST_WEAR)) * share).depth


def _windows(s: Column, share: float) -> tuple[int, int]:
    """Return how many samples the first share of a recording holds, and where its last share begins."""
    window = share * (s[-1] - s[0])
    first = max(_FEWEST_IN_WINDOW, int(np.searchsorted(s, s[0] + window, side="right")))
    return first, min(len(s) - _FEWEST_IN_WINDOW, int(np.searchsorted(s, s[-1] - window)))


def _noise(s: Column, reading: Column, wear: Column) -> float:
    """Return the variance of the sensor's noise times its autocorrelation time, about a smooth curve, m².

    From the whole run: a window at its end holds too few independent samples to give it.
    """
    left, _ = left_of(reading, np.stack([np.ones_like(s), wear, s]))
    return inflation(left, 3)


def _weights(level: Column, slope: Column) -> Column:
    """Return what readings are weighted with for the amount of ``level`` in them, with one of ``slope``."""
    # Wear is micrometres: in units of its own largest value it weighs as much as the offset.
    # There is none where the whole window is before the start of sliding.
    design = np.column_stack([level, slope / (np.max(np.abs(slope)) or 1.0)])
    return np.asarray(np.linalg.pinv(design)[0])


def _read(weights: Column, reading: Column, noise: float) -> Quantity:
    """Return a weighted reading, m, with the standard uncertainty by this variance of its noise."""
    deviation = math.sqrt(max(0.0, noise * float(weights @ weights)))
    return Quantity(value=float(weights @ reading), unit="m", standard_uncertainty=deviation)


def correct_drift(run: RawRun, recipe: Recipe | None = None) -> CorrectedRun:
    """Subtract from a run's depth, m, what is drift.

    A run without depth passes through, and so does one without a post-test measurement where that is needed; the
    correction states what is missing.
    """
    recipe = recipe or Recipe()
    end, needed = _measured_wear(run, recipe)
    missing = [] if "depth" in run.columns else ["a depth signal"]
    alone = end is None and recipe.wear.correction == "model" and _tells_by_itself(run)
    if end is None and not alone:
        missing.append(needed)
    if missing:
        return CorrectedRun(run, DriftCorrection(outcome="uncorrected", missing=tuple(missing)), None)
    approach = wear_of_both(run, recipe) if isinstance(end, EndWear) else None
    if approach is not None:
        end, _ = _measured_wear(run, recipe, approach)
    two_step = None if end is None else _two_step(run, end, recipe, approach)
    if recipe.wear.correction == "two-step" and two_step is not None:
        return two_step
    return _by_model(run, end, recipe, None if two_step is None else two_step.correction)


def _measured_wear(
    run: RawRun, recipe: Recipe, approach: Quantity | None = None
) -> tuple[EndWear | TotalWear | None, str]:
    """Return the wear that was measured after a test, and what is missing where there is none."""
    if run.manifest.contact is None:
        return None, "the two bodies ([contact])"
    measured = measurements_of(run.manifest.contact)
    if measured.sensed is None:
        return measured.total(run, recipe), measured.needed
    return measured.sensed.end_wear(run, recipe.uncertainty, None, approach), measured.needed


def _tells_by_itself(run: RawRun) -> bool:
    """Return whether the depth reading of a run gives its wear without a measurement: that of a sliding pin does."""
    contact = run.manifest.contact
    return contact is not None and contact.sensor_tells and bool(np.any(np.isfinite(run.sliding_distance)))


def _by_model(
    run: RawRun, end: EndWear | TotalWear | None, recipe: Recipe, two_step: DriftCorrection | None
) -> CorrectedRun:
    """Subtract the mean of all that is not wear by the model: offsets, drift, settling, thermal expansion.

    The wear is taken to grow by Archard's law; what another law has differently is fitted with its k_D.
    """
    record = depth_record(run)
    samples, slid = record.samples, record.slid
    discs = end if isinstance(end, TotalWear) else None
    if discs is not None:
        reading = reading_of_both(run, samples, discs, recipe, slid)
    else:
        pin_end = end if isinstance(end, EndWear) else None
        pin = best_pin(run, pin_end, recipe)
        reading = pin_reading(run, samples, pin_end, recipe, pin=pin, share=_worn_share(run, slid))
    posterior = depth_posterior(reading)
    scale = sensor_scale(run, recipe)
    found = depth_model(posterior, record.duration, scale)
    time, segments = (run.columns["time"] - record.start) / record.duration, record.segments(run.sliding_distance)
    beside = baseline(posterior, time, segments, run.columns.get("temperature"))
    wear = scale.value * run.columns["depth"] - beside
    changed = {
        "correction": "model",
        "zero_offset": found.zero_offsets[0],
        "drift_rate": found.drift_rate,
        "two_step_rate": None if two_step is None else two_step.drift_rate,
        "model": found,
        "findings": () if discs is None else tuple(_contradictions(run, found, discs.total, recipe)),
    }
    correction = two_step or DriftCorrection(outcome="corrected")
    # f below the noise of the blocks, or as probable as noise with a short memory, would be noise that is drawn twice.
    wanders = found.evidence > 0 and found.wander.value > found.noise.value
    wander = np.interp(time, reading.time, posterior.wander) if wanders else None
    correction = reworded(correction.model_copy(update=changed), run.manifest.worded)
    # Without a measurement of either body, all that the sensor shows counts as wear of the pin.
    alone = end is None and groove_alone(run, recipe.uncertainty) is None
    return CorrectedRun(
        run, correction, wear, wander, wear if alone else _part_of_pin(end, wear, _groove(end, posterior))
    )


def _contradictions(run: RawRun, found: DepthModel, measured: Quantity, recipe: Recipe) -> Iterator[Finding]:
    """Report where the reading of two discs shows another wear than what was measured on them."""
    scale = sensor_scale(run, recipe)
    read = combined(lambda depth, by: depth * by / scale.value, (found.end_depth_by_reading, scale), "m")
    spread = math.hypot(read.u_or_zero, measured.u_or_zero)
    deviation = (read.value - measured.value) / max(spread, 1e-15)
    if abs(deviation) > MOST_DEVIATION:
        yield Finding(
            severity="warning",
            code="reading_contradicts_measurement",
            where="depth",
            message=(
                f"found a total wear depth (both discs) of {read.shown('um')} from the depth signal and of "
                f"{measured.shown('um')} from the post-test measurements, {abs(deviation):.1f} standard uncertainties "
                "apart: the depth signal is not used, and k_D of both discs is based on the measurements"
            ),
            remedy="check for thermal drift, an unmeasured disc, and wrong units",
        )


def _two_step(run: RawRun, end: EndWear | TotalWear, recipe: Recipe, approach: Quantity | None = None) -> CorrectedRun:
    """Subtract the straight line between zero offset and end reading."""
    trace = read_trace(run, end, recipe)
    scale = sensor_scale(run, recipe)
    wear = trace.wear(end.total.value, trace.zero_offset.value, trace.end_reading.value, scale.value)

    def zero_of(worn: float, first: float, last: float, by: float) -> float:
        return float(trace.zero(worn, first, last, by))

    def gap_of(worn: float, first: float, last: float, by: float) -> float:
        return (last - zero_of(worn, first, last, by)) * by - worn

    measured = (end.total, trace.zero_offset, trace.end_reading, scale)
    gap = combined(gap_of, measured, "m")
    rate = combined(lambda drifted: drifted / trace.duration, (gap,), "m/s")
    correction = DriftCorrection(
        outcome="corrected",
        anchor=end.anchor,
        correction="two-step",
        zero_offset=combined(zero_of, measured, "m"),
        drift_rate=rate,
        two_step_rate=rate,
        discrepancy=gap,
        end_wear_depth=end.total,
        pin_wear_depth=end.pin_depth if isinstance(end, EndWear) else None,
        disc_wear_depth=end.disc.quantity if isinstance(end, EndWear) and end.disc else None,
        approach=approach,
    )
    return CorrectedRun(
        run, reworded(correction, run.manifest.worded), wear, None, _part_of_pin(end, wear, _groove(end))
    )


def _groove(end: EndWear | TotalWear | None, posterior: DepthPosterior | None = None) -> float:
    """Return the depth of the groove next to a pin that was measured, m: as measured, or what the reading has of it."""
    if isinstance(end, EndWear) and end.disc is not None:
        return end.disc.quantity.value
    if not isinstance(end, EndWear) or posterior is None or not posterior.reading.known:
        return 0.0
    return float(posterior.terms[0][posterior.first_known])


def _part_of_pin(end: EndWear | TotalWear | None, wear: Column, groove: float) -> Column | None:
    """Return the pin's part of the wear of both bodies, m, as they wear together; None if the pin was not measured."""
    if not isinstance(end, EndWear):
        return None
    pin = end.pin_depth.value
    if pin <= 0 or groove <= 0 or not end.tip.widens:
        return wear * (pin / (pin + groove) if pin + groove else 1.0)
    depths = pin * _ON_THE_WAY
    both = depths + groove * groove_share(end.tip.on_track(end.tip.radius), depths, pin)
    return wear * np.interp(wear, both, depths / both)

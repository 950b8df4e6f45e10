"""The depth reading of a run as tribopipe.physics.depth_model takes it, and what that model found of it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column
from tribopipe.base.errors import FitError
from tribopipe.contacts.kinds import Terms, sensed_wear, wear_of
from tribopipe.documents.contact import Tip
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.quantity import Quantity, meters
from tribopipe.documents.recipe import Recipe
from tribopipe.evaluation.load_and_friction import contact_load
from tribopipe.evaluation.measurements.end_wear import EndWear, TotalWear
from tribopipe.evaluation.measurements.kinds import end_wear, groove_alone
from tribopipe.evaluation.measurements.worn_tip import WornTip
from tribopipe.evaluation.preprocessing.masking import spikes
from tribopipe.physics.calculation_methods import WearEngine
from tribopipe.physics.depth_model.block_averages import DepthSamples, steps
from tribopipe.physics.depth_model.posterior import SCORES, DepthPosterior, DepthReading, KnownTerm, MeasuredDepth
from tribopipe.physics.depth_model.terms import SETTLING_TIMES
from tribopipe.physics.pin_on_disc import PinContact
from tribopipe.physics.pin_on_track import OnTrack, depth_growth
from tribopipe.results.evaluation import DepthModel
from tribopipe.results.input_quantities import best_values, stated_or_default
from tribopipe.results.run import RawRun

FEWEST_SAMPLES = 16
MOST_DEVIATION = 3.0
"""Standard uncertainties by which reading and post-test measurement may differ."""
DECISIVE = 4.6
"""ln of the odds, 100 to 1, from which on one account of a reading is ruled out by another.

Where it is true, the odds are as large in less than one of a hundred runs (Markov's inequality).
"""
_COURSE = 0.13
"""Standard uncertainty of the exponent of a disc's course, relative to that by Archard's law."""
_SPIKE_WINDOW, _SPIKE_THRESHOLD = 31, 20.0
"""Samples, and standard deviations off their median, beyond which one is a spike."""
_MOST_SPIKES = 0.02
"""Share of the samples above which they are no spikes."""
_HARDLY = 0.01
"""Share of the pin's wear depth by which a disc may wear and still count as one that does not."""
_LEAST_DEPTH, _LEAST_SHARE = 1e-9, 0.1
"""Wear depth of a pin, m, and share of what a sensor reads, that it counts as worn by at least to begin with."""
_SAME_PLACE = 0.01
"""Share of the distance within which a step belongs to a remounting."""
Course = Callable[[float, Column], Column]
"""Wear depth at each sliding distance, m, of a pin that ends at a depth, m."""
Share = Callable[[Column], Column]
"""Share of the wear volume at the end that is worn at each sliding distance, by a law."""


def sliding_time(distance: Column, time: Column) -> tuple[float, float]:
    """Return when sliding began, by the mean speed, and how long it lasted until the last sample, s."""
    if not distance[-1] > distance[0] or not time[-1] > time[0]:
        raise FitError(
            "drift correction: found no sliding between the first and last depth samples; expected increasing "
            "time and sliding distance; check both columns"
        )
    start = time[0] - distance[0] * (time[-1] - time[0]) / (distance[-1] - distance[0])
    return float(start), float(time[-1] - start)


def require_samples(run: RawRun) -> NDArray[np.bool_]:
    """Return which samples have depth, time and distance. Raises ``FitError`` where fewer than 16 have."""
    placed = np.isfinite(run.sliding_distance) & np.isfinite(run.columns["time"])
    seen = placed & np.isfinite(run.columns["depth"])
    if np.count_nonzero(seen) < FEWEST_SAMPLES:
        raise FitError(
            f"{run.id}: found {np.count_nonzero(seen)} valid depth samples; expected at least {FEWEST_SAMPLES} for "
            "drift correction; use a higher sampling rate"
        )
    return np.asarray(seen)


@dataclass(frozen=True)
class DepthRecord:
    """The depth reading of a run, and what it has in addition to valid samples."""

    samples: DepthSamples
    start: float
    """Time at the start of sliding, s."""
    duration: float
    """Duration of sliding, s."""
    slid: float
    """Sliding distance at the end, m, whether or not depth was still recorded there."""
    stops: tuple[float, ...]
    """Sliding distances after which a new zero offset holds, m: remountings and steps."""
    steps: tuple[float, ...]
    """Those at which the reading steps, m."""
    spikes: int
    """Number of samples that were left out as spikes."""

    def segments(self, distance: Column) -> NDArray[np.intp]:
        """Return the number of zero offsets that began before sliding distances, m."""
        return np.searchsorted(self.stops, distance)


def depth_record(run: RawRun) -> DepthRecord:
    """Return the depth reading of a run with its steps found and its spikes left out.

    Raises ``FitError`` where fewer than 16 samples have depth, time and distance, or where nothing slides.
    """
    seen = require_samples(run)
    distance, time = run.sliding_distance, run.columns["time"]
    placed = np.isfinite(distance) & np.isfinite(time)
    start, duration = sliding_time(distance[placed], time[placed])
    spiky = spikes(np.where(seen, run.columns["depth"], np.nan), _SPIKE_WINDOW, _SPIKE_THRESHOLD)
    if 0 < np.count_nonzero(spiky) < _MOST_SPIKES * np.count_nonzero(seen):
        seen = seen & ~spiky
    temperature = run.columns.get("temperature")
    if temperature is not None and not np.all(np.isfinite(temperature[seen])):
        temperature = None
    share, progress = (time[seen] - start) / duration, np.maximum(distance[seen], 0.0)
    depth = run.manifest.depth_scale.value * run.columns["depth"][seen]
    remounted = [stop.place for stop in run.manifest.interruptions if stop.remounted]
    # Samples before a step have the distance of the last of them at most.
    found = tuple(float(progress[at - 1]) for at in steps(share, progress, depth))
    new = tuple(place for place in found if all(abs(place - stop) > _SAME_PLACE * progress[-1] for stop in remounted))
    stops = tuple(sorted((*remounted, *new)))
    samples = DepthSamples(
        time=share,
        progress=progress,
        depth=depth,
        segments=np.searchsorted(stops, distance[seen]),
        temperature=None if temperature is None else temperature[seen],
        cycle=run.manifest.conditions.cycle,
    )
    slid = float(distance[placed][-1])
    return DepthRecord(samples, start, duration, slid, stops, new, int(np.count_nonzero(spiky & ~seen)))


def sensor_scale(run: RawRun, recipe: Recipe) -> Quantity:
    """Return by how much the depth sensor's reading is to be multiplied, with its uncertainty."""
    scale = run.manifest.depth_scale
    return stated_or_default(scale, recipe.uncertainty.depth_scale * abs(scale.value))[0]


def remountings(manifest: RunManifest, distance: Column) -> Column:
    """Return how often the specimens had been taken out before each sample."""
    stops = [stop.place for stop in manifest.interruptions if stop.remounted]
    return np.asarray(np.searchsorted(stops, distance), dtype=float)


def engine_of(pin: Tip, end: EndWear | None, recipe: Recipe) -> WearEngine:
    """Return the engine that a recipe asks for, or else the one that fits what was measured on the disc.

    The GIWM is made for a disc that does not wear. Where one does, beyond what its measurement may be off by twice and
    a hundredth of the pin's wear, or was not measured, k_D·F_N·s is the volume lost. A flat pin without a measured
    groove keeps its area either way.
    """
    if recipe.wear.engine is not None:
        return recipe.wear.engine
    if end is None or end.disc is None or pin.line:
        return "giwm" if pin.constant_area else "volume"
    return "volume" if wears_beside(end.disc.quantity, end.pin_depth.value) else "giwm"


def wears_beside(disc: Quantity, depth: float) -> bool:
    """Whether a disc has worn: more than its measurement may be off by, and than a hundredth of the other depth, m."""
    return disc.value > max(2 * disc.u_or_zero, _HARDLY * depth)


def best_pin(run: RawRun, end: EndWear | None, recipe: Recipe) -> PinContact:
    """Return the pin of a run by the best estimates of its inputs.

    Local wear counts as the GIWM here: of the drift the two differ by next to nothing.
    """
    contact = run.manifest.described
    values = {
        "normal_load": contact_load(run, recipe).value,
        "pin_radius": contact.equivalent_pin.radius.value,
        "pin_modulus": contact.sliding_tip.youngs_modulus.value,
        "disc_modulus": contact.counterbody.youngs_modulus.value,
    }
    engine = engine_of(contact.sliding_tip, end, recipe)
    return sensed_wear(contact, "giwm" if engine == "local" else engine).pin(values)


def pin_reading(
    run: RawRun,
    samples: DepthSamples,
    end: EndWear | None,
    recipe: Recipe,
    *,
    pin: PinContact,
    share: Share,
    free: Column | None = None,
) -> DepthReading:
    """Return the depth reading of a pin and its disc.

    Where the disc alone was measured, the sensor shows the wear of the pin next to the groove: H is that of the pin.

    Parameters
    ----------
    run
        The run, for what was measured where it was interrupted.
    samples
        Its depth reading.
    end
        What was measured after the test; None if the sensor alone has to show it.
    recipe
        Default uncertainties, and the prior of the drift.
    pin
        Depth against worn volume.
    share
        Share of the volume at the end that is worn at each sliding distance.
    free
        Columns of what else is free, shape (blocks, n).
    """
    groove = Groove.of(run, end, recipe) or Groove.unseen(end, recipe)
    alone = groove is not None and end is None

    def of_pin(end_depth: float, distance: Column) -> Column:
        worn = share(distance)
        depth = pin.worn(pin.volume(end_depth) * worn).depth
        return np.asarray(depth if groove is None else groove.deepened(depth, worn, end_depth))

    def of_both(end_depth: float, distance: Column) -> Column:
        depth = of_pin(end_depth, distance)
        return depth if groove is None else depth + groove.measured.value * groove.share(depth, end_depth)

    most = (
        float(np.min(pin.worn(pin.most_volume * (1 - 1e-9)).depth)) if np.all(np.isfinite(pin.most_volume)) else np.inf
    )
    return samples.reading(
        of_both if alone else of_pin,
        tuple(_measured_depths(run, end, recipe, pin, share)),
        drift_deviation=None if end is not None else recipe.drift.prior.value,
        known=() if groove is None else groove.terms(samples, of_pin, in_course=alone),
        guess=groove.pin_by(samples) if groove is not None and alone else None,
        free=free,
        most=most,
    )


@dataclass(frozen=True)
class Groove:
    """A groove that was measured, and the pin that is worn in it."""

    tip: WornTip
    measured: Quantity
    """m."""
    pin_depth: float | None
    """Wear depth of the pin as measured, m; None if it was not."""

    @classmethod
    def of(cls, run: RawRun, end: EndWear | None, recipe: Recipe) -> "Groove | None":
        """Return the groove that was measured next to the pin, or alone where the pin was not; None without one."""
        used = groove_alone(run, recipe.uncertainty) if end is None else end.disc
        tip = WornTip.of(run.manifest.described.equivalent_pin) if end is None else end.tip
        return None if used is None else cls(tip, used.quantity, None if end is None else end.pin_depth.value)

    @classmethod
    def unseen(cls, end: EndWear | None, recipe: Recipe) -> "Groove | None":
        """Return the groove that nobody measured, 0 within what it may be, next to a pin whose volume was measured.

        The volume holds with and without a groove, but the sensor has read the groove as well. Next to a pin of which
        a depth or a scar was measured, the groove is an input of k_D.
        """
        if end is None or end.disc is not None or not end.by_volume or not end.tip.widens:
            return None
        depth = max(end.pin_depth.value, 0.0)
        spread = recipe.uncertainty.unseen_groove * depth
        return cls(end.tip, Quantity(value=0.0, unit="m", standard_uncertainty=spread), depth) if spread else None

    def deepened(self, depth: Column, worn: Column, end_depth: float) -> Column:
        """Return the depth of the pin, m, which was deeper on its way than on a plane, while the groove was shallow."""
        pin, groove = end_depth if self.pin_depth is None else self.pin_depth, self.measured.value
        if not self.tip.widens or pin <= 0 or groove <= 0:
            return depth
        return depth * depth_growth(self.tip.on_track(self.tip.radius), worn, pin, groove)

    def share(self, pin: Column, end_depth: float) -> Column:
        """Return what share of the groove is worn where the pin is worn to some depths, m."""
        return groove_share(self.tip.on_track(self.tip.radius), pin, end_depth)

    def pin_by(self, samples: DepthSamples) -> float:
        """Return a first estimate of the depth of the pin, m: as measured, or what the reading shows more."""
        if self.pin_depth is not None:
            return max(self.pin_depth, _LEAST_DEPTH)
        read = float(np.ptp(samples.blocks.mean(samples.depth)))
        return max(read - self.measured.value, _LEAST_SHARE * read)

    def terms(self, samples: DepthSamples, of_pin: Course, *, in_course: bool) -> tuple[KnownTerm, KnownTerm]:
        """Return what the groove is worn by each block: as measured, and by another course.

        By first-order propagation, another exponent adds the logarithm of the share. Where the groove is in the course
        of the wear already, its terms are what its measurement is off by.
        """
        depth = self.pin_by(samples)
        share = self.share(of_pin(depth, samples.nodes.distance), depth)
        bent = share * np.log(np.maximum(share, 1e-9))
        spread = self.measured.u_or_zero
        return (
            KnownTerm(samples.nodes.averaged(share), 0.0 if in_course else self.measured.value, spread),
            KnownTerm(samples.nodes.averaged(bent), 0.0, _COURSE * abs(self.measured.value)),
        )


def groove_share(contact: OnTrack, pin: Column, end_depth: float) -> Column:
    """Return what share of a groove is worn where the pin is worn to some depths, m.

    By Archard's law the groove is as deep as the area that the pin has lost in its middle slice, over the length of the
    path and by the ratio of coefficients.
    """
    return np.asarray(contact.middle_slice(pin) / contact.middle_slice(end_depth))


def _measured_depths(
    run: RawRun, end: EndWear | None, recipe: Recipe, pin: PinContact, share: Share
) -> list[MeasuredDepth]:
    found = [] if end is None else [MeasuredDepth(_depths(end), lambda depth: depth)]
    for number, stop in enumerate(run.manifest.interruptions):
        between = end_wear(run, recipe.uncertainty, number)
        if between is not None and end is not None:
            worn = float(share(np.asarray([stop.place]))[0])
            found.append(MeasuredDepth(_depths(between), _worn_by_then(pin, worn)))
    return found


def _worn_by_then(pin: PinContact, share: float) -> Callable[[Column], Column]:
    return lambda end_depth: np.asarray(pin.worn(pin.volume(end_depth) * share).depth)


def _depths(end: EndWear) -> Column:
    """Return what depth a measurement on the pin means, m, were it off by each of ``SCORES``."""
    measured = end.pin.quantity
    moved = measured.value + SCORES * measured.u_or_zero
    return np.maximum.accumulate(end.pin_depth_of(moved, end.tip.radius))


def course_of_both(run: RawRun, recipe: Recipe, whole: float = 1.0) -> Course:
    """Return how deep two bodies that end at a depth, m, are on their way of some whole length, as if one alone wore.

    How wear is shared changes next to nothing of the shape of its sum.
    """
    wear = wear_of(run.manifest.described, Terms(run.manifest.slip, distance=recipe.wear.distance_per_rotation))
    first, *others = wear.coefficients
    stated = best_values(wear.inputs(run.manifest.conditions.normal_load, Recipe()))
    values = {**stated, first: 1.0, **dict.fromkeys(others, 0.0)}

    def course(end_depth: float, along: Column) -> Column:
        return wear.worn(values, wear.progress_to(values, end_depth) * along / whole)[wear.displacement]

    return course


def reading_of_both(run: RawRun, samples: DepthSamples, end: TotalWear, recipe: Recipe, slid: float) -> DepthReading:
    """Return the depth reading of two bodies that share one worn shape."""
    total = end.total
    measured = MeasuredDepth(total.value + SCORES * total.u_or_zero, lambda depth: depth)
    return samples.reading(course_of_both(run, recipe, slid), (measured,))


_PROBABLE = 0.5
_COVERAGE = np.array([0.025, 0.975])
"""Cumulative probabilities of the ends of a 95 % interval."""


def depth_model(posterior: DepthPosterior, duration: float, scale: Quantity) -> DepthModel:
    """Return what a posterior states about everything but wear.

    Parameters
    ----------
    posterior
        Of the reading by the best estimate of the sensor's scale.
    duration
        Sliding time, s.
    scale
        Scale of the sensor, whose uncertainty the posterior knows nothing of: it is in that of offset, drift and
        settling, since where the end of the wear is known, they take what the reading is too large or too small by.
    """
    reading, (mean, statistical) = posterior.reading, posterior.terms
    by_scale = scale.u_or_zero / scale.value * np.abs(posterior.terms_per_scale)
    deviation = np.hypot(statistical, by_scale)
    offsets = reading.offsets.shape[1]
    line = offsets + (0 if reading.free is None else reading.free.shape[1])
    first = line + 1 + len(reading.known)
    constants = reading.optional.time_constants
    amplitudes = mean[first:]
    settles = np.array([constant is not None for constant in constants])
    probability = posterior.settling_probability
    low, high = posterior.term_quantiles(line, _COVERAGE, float(by_scale[line])) / duration
    return DepthModel(
        zero_offsets=tuple(meters(mean[place], deviation[place]) for place in range(offsets)),
        drift_rate=Quantity(
            value=float(mean[line] / duration), unit="m/s", standard_uncertainty=float(deviation[line] / duration)
        ),
        drift_interval=(Quantity(value=float(low), unit="m/s"), Quantity(value=float(high), unit="m/s")),
        settling_probability=probability,
        settling=meters(float(np.sum(amplitudes[settles])), float(np.sqrt(np.sum(deviation[first:][settles] ** 2)))),
        settling_time=_settling_time(posterior, duration) if probability > _PROBABLE else None,
        thermal_probability=None if np.all(settles) else posterior.thermal_probability,
        thermal_shift=None if np.all(settles) else meters(amplitudes[~settles][0], deviation[first:][~settles][0]),
        wander=meters(float(np.sqrt(np.average(posterior.wander**2, weights=reading.samples)))),
        noise=meters(posterior.noise),
        blocks=len(reading.time),
        end_depth=meters(*posterior.together),
        end_depth_by_reading=meters(*posterior.alone),
        evidence=float(np.clip(posterior.log_odds, -99.0, 99.0)),
    )


def _settling_time(posterior: DepthPosterior, duration: float) -> Quantity:
    alternatives = posterior.reading.optional.alternatives
    settling = [-1 if one.column is None else one.column for one in alternatives]
    place = np.array(settling)[posterior.ways.alternative]
    constants = np.array(SETTLING_TIMES)
    times, weights = constants[place[place >= 0]], posterior.weights[place >= 0]
    mean = float(np.average(times, weights=weights))
    spread = float(np.sqrt(np.average((times - mean) ** 2, weights=weights)))
    return Quantity(value=mean * duration, unit="s", standard_uncertainty=spread * duration)

"""The joint fit of a run that is not over: drift and wear together, with prior knowledge in the place of ends.

The noise of the reading is that of the whole of it, or of its parts where something changed in between.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.special import chdtri

from tribopipe.base.arrays import Column, Values
from tribopipe.base.errors import FitError
from tribopipe.contacts.kinds import wear_of
from tribopipe.documents.contact import Contact
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.documents.signals import SignalName
from tribopipe.evaluation.depth_reading import engine_of, remountings
from tribopipe.evaluation.drift import SensorTrace
from tribopipe.evaluation.load_and_friction import applied_load
from tribopipe.evaluation.measurements.end_wear import EndWear
from tribopipe.evaluation.measurements.kinds import end_wear
from tribopipe.evaluation.measurements.readings import EndValueUsed
from tribopipe.evaluation.measurements.worn_tip import WornTip
from tribopipe.evaluation.wear.drift_and_wear import END_ANCHOR, Anchor, JointProblem, interruption_anchor
from tribopipe.evaluation.wear.inputs import instrument_inputs, law_as_given, law_inputs
from tribopipe.evaluation.wear.problem import NODES, about_smooth, unseen_groove_input
from tribopipe.extras.live.state import Means, State
from tribopipe.physics.autocorrelation import effective_samples, inflation
from tribopipe.physics.friction_path import MeasuredFriction
from tribopipe.physics.laws import law_named, law_title
from tribopipe.results.input_quantities import Input
from tribopipe.results.run import RawRun

_PARTS = 5
"""Number of parts of a test; the noise is estimated in each."""
_SMOOTH = 4
"""Powers of √s in a smooth curve: few, as each takes noise out of a short record."""
_PER_FREEDOM = 3.0
"""Independent samples that show as much of the noise as one that is known to be independent: over a window of M lags
the relative variance of an autocorrelation time τ is 2·(2M + 1)/n (N. Madras, A. D. Sokal, Journal of Statistical
Physics 50 (1988) 109), and a window of about 1.5·τ is summed."""
_SURE = 0.95
_LEAST = 1e-12
"""Standard deviation, m, below which a reading counts as without noise."""


@dataclass(frozen=True)
class Noise:
    """Noise of the depth signal, including its autocorrelation."""

    variance: float
    """Variance of one sample times the autocorrelation time, m²."""
    freedom: float
    """Degrees of freedom by which that is known."""

    @property
    def most(self) -> float:
        """Variance, m², that it is below with a probability of 95 %."""
        freedom = max(self.freedom, 1.0)
        return self.variance * freedom / float(chdtri(freedom, _SURE))


def noise_of(fine: Means, trace: SensorTrace, segments: Column, planned: float) -> Noise:
    """Return the noise of a reading about a smooth curve.

    It is that of the middle one of its parts where the whole is rougher than that can be: what changes in a test is no
    noise. A test is divided up to its ``planned`` distance, m.
    """
    each = float(fine.samples[0])
    whole = _noise(*about_smooth(trace, fine.sliding_distance, segments, _SMOOTH), each)
    parts = sorted(_parts(fine, planned, each), key=lambda part: part.variance)
    if parts and whole.variance > (middle := parts[(len(parts) - 1) // 2]).most:
        return middle
    return whole


def noise_of_all(fine: Means, trace: SensorTrace, segments: Column) -> Noise:
    """Return the noise of a whole run about a smooth curve, as the fit of a finished run takes it."""
    return _noise(*about_smooth(trace, fine.sliding_distance, segments), float(fine.samples[0]))


def _parts(fine: Means, planned: float, each: float) -> Iterator[Noise]:
    """Give the noise in each part of a test that is whole."""
    number = np.floor(fine.sliding_distance / planned * _PARTS)
    for part in range(min(int(number[-1]), _PARTS)):
        root, depth = fine.root[number == part], fine.depth[number == part]
        if len(root) > 2 * _SMOOTH:
            smooth = np.polynomial.Polynomial.fit(root, depth, _SMOOTH)
            yield _noise(depth - smooth(root), _SMOOTH + 1, each)


def _noise(residuals: Column, parameters: int, each: float) -> Noise:
    """Return the noise by residuals of means over so many samples ``each``."""
    variance = max(inflation(residuals, parameters) * each, _LEAST**2)
    return Noise(variance, (effective_samples(residuals) - parameters) / _PER_FREEDOM)


_DISC_POWER = 0.75
"""Exponent of s in ∫ds/a under a sphere, whose contact radius a grows as the fourth root of s.

It is 1 where the contact keeps its width: a block, or a flat pin.
"""
_LEAST_SPREAD = 1e-12
_AS_PLANNED = 0.98
"""Share of the planned distance at which a test has ended as planned."""


@dataclass(frozen=True)
class Known:
    """Information on a run before its end."""

    drift_rate: Quantity | None = None
    """m/s"""
    disc_wear: Quantity | None = None
    """Depth of the disc's wear at the planned end, m."""
    wear_coefficient: Quantity | None = None
    """k_D, m²/N; its standard uncertainty over its value is that of ln k_D."""
    notes: tuple[str, ...] = ()
    """Sources of the prior information."""


@dataclass(frozen=True)
class Belief:
    """One row of what is known beforehand, m or a logarithm."""

    name: str
    value: float
    spread: float


@dataclass(frozen=True)
class LiveProblem(JointProblem):
    """The joint fit of the samples so far."""

    beliefs: tuple[Belief, ...] = ()
    """Prior values of the current "drift" and "disc wear", m, and of "ln k_D"."""
    most_noise: float = math.inf
    """Upper limit of the noise with a probability of 95 %, m²."""
    freedom: float = math.inf
    """Degrees of freedom by which the noise is known."""
    sensor_drift: float = math.inf
    """Standard uncertainty, m, of the drift that a sensor may have in a test, if nothing is known of this one."""
    disc_known: bool = True
    """True if the wear of the disc was stated or measured."""

    @property
    def _believed(self) -> tuple[str, ...]:
        return tuple(belief.name for belief in self.beliefs)

    def rows(self, values: Values) -> Column:
        """Return the reading in true displacement, each depth measured on the pin, m, and what is known beforehand."""
        rows = super().rows(values)
        known = [belief.value for belief in self.beliefs]
        return np.concatenate([rows, np.broadcast_to(known, (*rows.shape[:-1], len(known)))], axis=-1)

    def modelled(self, values: Values) -> Callable[[Column], tuple[Column, Column]]:
        """Return each row as the law gives it, and its slope against ln k_D; drift and disc are fitted with it."""
        joint = super().modelled(values)
        of_k = np.asarray([name == "ln k_D" for name in self._believed], dtype=float)

        def model(log_coefficient: Column) -> tuple[Column, Column]:
            depth, slope = joint(log_coefficient)
            known = np.asarray(log_coefficient)[..., None] * of_k
            slopes = [slope, np.zeros_like(known) + of_k]
            return np.concatenate([depth, known], axis=-1), np.concatenate(slopes, axis=-1)

        return model

    @cached_property
    def root_weights(self) -> Column:
        """Inverse standard deviation of each row."""
        spreads = [max(belief.spread, _LEAST_SPREAD) for belief in self.beliefs]
        return np.concatenate([super().root_weights, 1 / np.asarray(spreads)])

    @cached_property
    def linear(self) -> Column:
        """Columns of zero offsets, drift and the disc's wear by now, in weighted rows."""
        offsets = np.equal.outer(self.segments, np.unique(self.segments)).astype(float)
        columns = [*offsets.T, self.trace.ramp]
        if "disc wear" in self._believed:
            columns.append(np.maximum(self.distance / self.trace.slid, 0.0) ** _disc_power(self.contact))
        fitted = ["offset"] * offsets.shape[1] + ["drift", "disc wear"][: len(columns) - offsets.shape[1]]
        beliefs = [[float(name == belief) for name in fitted] for belief in self._believed]
        anchors = np.zeros((len(self.anchors), len(columns)))
        rows = np.vstack([np.column_stack(columns), anchors, np.reshape(beliefs, (-1, len(columns)))])
        return np.asarray(rows * self.root_weights[:, None])

    @property
    def drift_column(self) -> int:
        """Which of what is fitted with k_D is the drift by now."""
        return len(np.unique(self.segments))

    @property
    def plausible_drift(self) -> tuple[float, float]:
        """Return what a sensor may have drifted by now and its standard uncertainty, m."""
        stated = [belief for belief in self.beliefs if belief.name == "drift"]
        return (stated[0].value, max(stated[0].spread, _LEAST_SPREAD)) if stated else (0.0, self.sensor_drift)

    @property
    def tells_drift(self) -> bool:
        """Whether wear and drift are distinguished: not of a flat pin, where both are linear, unless one is known."""
        return (
            not self.contact.sliding_tip.constant_area
            or bool(self.anchors)
            or bool({"drift", "ln k_D"} & {*self._believed})
        )

    @property
    def finished(self) -> bool:
        """True if the wear at the end of the run was measured."""
        return any(anchor.name == END_ANCHOR for anchor in self.anchors)


@dataclass(frozen=True)
class Asked:
    """Run that is followed, and its wear law."""

    run: RawRun
    """Run with its first samples only, which show the sources of its columns."""
    law: LawName = "archard"
    recipe: Recipe = field(default_factory=Recipe)
    known: Known = Known()
    planned: float | None = None
    """Sliding distance, m, at which the test is to end; None if it is not stated."""

    def ends_at(self, reached: float) -> bool:
        """Return whether a test that has come so far, m, has ended as planned; always so without a planned end."""
        return self.planned is None or reached >= _AS_PLANNED * self.planned


def live_problem(asked: Asked, state: State) -> LiveProblem:
    """Pose the fit of the samples so far. Raises ``FitError`` where the law needs a friction that was not recorded."""
    fine, manifest = state.means, asked.run.manifest
    contact = manifest.described
    segments = remountings(manifest, fine.sliding_distance)
    trace = _trace(fine, fine)
    stretches = _stretches(fine.sliding_distance if contact.sliding_tip.constant_area else fine.root, segments)
    means = state.pooled(stretches)
    # Before the end, an end value is that of another run, left in a copied run.toml, or measured further on.
    end = end_wear(asked.run, asked.recipe.uncertainty) if asked.ends_at(trace.slid) else None
    if end is None:
        noise = noise_of(fine, trace, segments, asked.planned or trace.slid)
    else:
        noise = noise_of_all(fine, trace, segments)
    anchors = _anchors(asked, trace.slid, end)
    worn = end or _worn_by_reading(contact, fine)
    disc_known = asked.known.disc_wear is not None if end is None else end.disc is not None
    inputs = _inputs(asked, fine, anchors, end)
    if not disc_known:
        inputs |= unseen_groove_input(asked.run, worn, asked.recipe, by_sensor=end is None)
    return LiveProblem(
        contact=contact,
        law=law_as_given(asked.law, asked.recipe),
        distance=mean_distance(contact, means),
        trace=_trace(means, fine),
        end=worn,
        friction=_friction(asked, fine),
        inputs=inputs,
        engine=engine_of(contact.sliding_tip, end, asked.recipe) if end else asked.recipe.wear.engine or "giwm",
        weights=means.samples,
        noise=noise.variance,
        most_noise=noise.most,
        freedom=noise.freedom,
        anchors=tuple(anchors),
        segments=remountings(manifest, means.sliding_distance),
        beliefs=() if end else tuple(_beliefs(asked, trace)),
        sensor_drift=asked.recipe.drift.prior.value,
        disc_known=disc_known,
    )


def _worn_by_reading(contact: Contact, fine: Means) -> EndWear:
    """Return the wear of a pin that nobody has measured yet: at most what the sensor has read."""
    read = Quantity(value=float(np.ptp(fine.depth)), unit="m")
    return EndWear(EndValueUsed("pin_wear_depth", read, "default"), None, WornTip.of(contact.equivalent_pin))


def _disc_power(contact: Contact) -> float:
    return _DISC_POWER if contact.sliding_tip.widens else 1.0


def mean_distance(contact: Contact, means: Means) -> Column:
    """Return where a pin is worn as in the mean of a stretch, m: at the mean of √s, or of s under a flat one."""
    return means.sliding_distance if contact.sliding_tip.constant_area else means.root**2


def _trace(means: Means, fine: Means) -> SensorTrace:
    """Return the reading of means, with drift counted from the first to the last sample."""
    begun, duration = fine.time[0], fine.time[-1] - fine.time[0]
    if not duration > 0:
        raise FitError("found samples at one time only; expected increasing times; check the clock")
    first, last = (Quantity(value=float(fine.depth[place]), unit="m") for place in (0, -1))
    return SensorTrace(
        reading=means.depth,
        ramp=(means.time - begun) / duration,
        duration=float(duration),
        slid=float(fine.sliding_distance[-1]),
        zero_offset=first,
        end_reading=last,
    )


def _stretches(to_come: Column, segments: Column) -> Column:
    """Return the numbers of stretches evenly spaced in the wear to come, none across a remounting."""
    within = np.minimum((to_come / to_come[-1] * NODES).astype(int), NODES - 1)
    return np.asarray(within + NODES * segments)


def _friction(asked: Asked, fine: Means) -> MeasuredFriction | None:
    if not law_named(asked.law).needs_friction:
        return None
    seen = np.isfinite(fine.friction)
    if not np.any(seen):
        raise FitError(
            f"{asked.run.id}: found no friction signal; expected one for {law_title(asked.law)}; map a friction column "
            "in run.toml, or follow the run with Archard's law"
        )
    return MeasuredFriction(fine.sliding_distance[seen], fine.friction[seen])


def _anchors(asked: Asked, slid: float, end: EndWear | None) -> list[Anchor]:
    """Return the depths measured on the pin so far, that at the end of a finished run first."""
    anchors = [] if end is None else [Anchor(END_ANCHOR, slid, end)]
    for number, stop in enumerate(asked.run.manifest.interruptions):
        wear = end_wear(asked.run, asked.recipe.uncertainty, number)
        if wear is not None and stop.place <= slid:
            anchors.append(Anchor(interruption_anchor(number + 1), stop.place, wear))
    return anchors


def _load(asked: Asked, fine: Means) -> Quantity:
    """Return the load so far, N: recorded, else nominal."""
    so_far: dict[SignalName, Column] = {"normal_force": fine.load, "sliding_distance": fine.sliding_distance}
    return applied_load(replace(asked.run, columns=so_far), asked.recipe)


def _inputs(asked: Asked, fine: Means, anchors: list[Anchor], end: EndWear | None) -> dict[str, Input]:
    manifest, recipe = asked.run.manifest, asked.recipe
    inputs = wear_of(manifest.described).inputs(_load(asked, fine), recipe)
    inputs |= instrument_inputs(asked.run, recipe)
    inputs |= law_inputs(law_named(asked.law), recipe)
    inputs |= {anchor.name: Input(anchor.wear.pin.quantity, anchor.wear.pin.source) for anchor in anchors}
    if end is not None and end.disc is not None:
        inputs["disc_end_value"] = Input(end.disc.quantity, end.disc.source)
    return inputs


def _beliefs(asked: Asked, trace: SensorTrace) -> list[Belief]:
    known, beliefs = asked.known, []
    if known.drift_rate is not None:
        rate = known.drift_rate
        beliefs.append(Belief("drift", rate.value * trace.duration, rate.u_or_zero * trace.duration))
    # The disc's wear grows with the distance, whether its end is near or not.
    share = (trace.slid / (asked.planned or trace.slid)) ** _disc_power(asked.run.manifest.described)
    default = asked.recipe.uncertainty.wear_depth
    disc = known.disc_wear or Quantity(value=0.0, unit="m", standard_uncertainty=default.value)
    beliefs.append(Belief("disc wear", disc.value * share, disc.u_or_zero * share))
    if known.wear_coefficient is not None:
        k = known.wear_coefficient
        beliefs.append(Belief("ln k_D", float(np.log(k.value)), k.u_or_zero / k.value))
    return beliefs

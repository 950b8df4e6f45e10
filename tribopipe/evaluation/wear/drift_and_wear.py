"""Drift and wear estimated together: zero offsets, drift rate and k_D in one least-squares fit.

    g·reading(t) = z + ρ·(t − t₀) + h(s; k_D)·(1 + disc/pin) + noise
    measured depth at an interruption or at the end = h(s; k_D) + its own error

Each row is weighted by its variance: the sensor's noise with its autocorrelation, and the uncertainty of each end
value. So the post-test measurement is one more measurement, not the truth that the curve is bent to; every
interruption adds another; and where the specimens were taken out, a new zero offset begins. The fit relies on the law's
shape to separate wear from drift, which correction in two steps does not.
"""

from collections.abc import Callable, Collection
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from tribopipe.base.arrays import Column, Numbers, Values
from tribopipe.documents.recipe import Recipe
from tribopipe.evaluation.depth_reading import remountings
from tribopipe.evaluation.measurements.end_wear import EndWear
from tribopipe.evaluation.measurements.kinds import end_wear
from tribopipe.evaluation.wear.law_parameters import with_fitted_law
from tribopipe.evaluation.wear.problem import NODES, WearProblem, posed_as
from tribopipe.results.input_quantities import Input
from tribopipe.results.run import CorrectedRun

_LEAST_SPREAD = 1e-12
"""Standard uncertainty, m, of a post-test measurement stated as exact: it cannot be weighted without bound."""
_LEAST_AREA = 1e-300
"""m², so that a pin that has lost nothing divides by no zero."""
END_ANCHOR = "pin_end_value"


def interruption_anchor(number: int) -> str:
    """Return the name of the input for what was measured at an interruption, the first of which is 1."""
    return f"pin_value_at_interruption_{number}"


@dataclass(frozen=True)
class Anchor:
    """Wear of the pin measured at one sliding distance."""

    name: str
    """Name of its input."""
    distance: float
    wear: EndWear


@dataclass(frozen=True)
class JointProblem(WearProblem):
    """One run with drift and wear in one fit: rows of the reading, and then one for each anchor."""

    anchors: tuple[Anchor, ...] = ()
    segments: Column = field(default_factory=lambda: np.zeros(1))
    """Number of remountings before each row of the reading."""

    def rows(self, values: Values) -> Column:
        """Return the reading in true displacement, and each depth measured on the pin, m."""
        reading = np.asarray(values["depth_scale"] * self.trace.reading)
        measured = [anchor.wear.pin_depth_of(values[anchor.name], values["pin_radius"]) for anchor in self.anchors]
        draws = reading.shape[:-1]
        return np.concatenate([reading, *(np.broadcast_to(depth, (*draws, 1)) for depth in measured)], axis=-1)

    def modelled(self, values: Values) -> Callable[[Column], tuple[Column, Column]]:
        """Return wear of pin and disc at each sample and of the pin at each anchor, and slopes against ln k_D, m."""
        pin, unit = self.pin(values), self.unit_volume(values, self._row_distance)
        grown = self._grown(self._row_distance)

        def model(log_coefficient: Column) -> tuple[Column, Column]:
            volume = np.exp(log_coefficient)[..., None] * unit
            state = pin.worn(volume)
            depth = np.array(state.depth * grown)
            depth[..., : len(self.distance)] += self.disc_wear(depth, state.radius * np.sqrt(grown), values)
            return depth, volume / state.area * grown

        return model

    @property
    def measured_inputs(self) -> Collection[str]:
        """Names of inputs that what is measured depends on, but not the model."""
        return ("depth_scale", *(anchor.name for anchor in self.anchors))

    @cached_property
    def _row_distance(self) -> Column:
        """Sliding distance of each row, m, that of the end anchor right after the reading's."""
        return np.concatenate([self.distance, [anchor.distance for anchor in self.anchors]])

    def disc_wear(self, depth: Column, half_chord: Column, values: Values) -> Numbers:
        """Return the disc's wear at each sample, m, for a pin that is this deep and wide there and, next, at the end.

        By Archard's law a point of the track wears in proportion to what the slice of the pin above it has lost: the
        middle one loses ∫2a·dh.
        """
        if "disc_end_value" not in values:
            return 0.0
        count = len(self.distance) + 1
        deep = np.concatenate([np.zeros_like(depth[..., :1]), depth[..., :count]], axis=-1)
        # Before the first sample, with next to no wear, the pin is taken for as wide as there.
        wide = np.concatenate([half_chord[..., :1], half_chord[..., :count]], axis=-1)
        lost = np.cumsum((wide[..., 1:] + wide[..., :-1]) * np.diff(deep), axis=-1)
        whole = np.maximum(lost[..., -1:], _LEAST_AREA)
        return np.asarray(values["disc_end_value"] * lost[..., :-1] / whole)

    @cached_property
    def root_weights(self) -> Column:
        """Inverse standard deviation of each row, 1/m."""
        spreads = [anchor.wear.pin_depth.u_or_zero for anchor in self.anchors]
        deviations = [*np.sqrt(self.noise / self.weights), *np.maximum(spreads, _LEAST_SPREAD)]
        return 1 / np.asarray(deviations)

    @cached_property
    def linear(self) -> Column:
        """Columns of the zero offsets and of the drift over the whole run, in weighted rows."""
        offsets = np.equal.outer(self.segments, np.unique(self.segments)).astype(float)
        columns = np.column_stack([offsets, self.trace.ramp])
        rows = np.vstack([columns, np.zeros((len(self.anchors), columns.shape[1]))])
        return np.asarray(rows * self.root_weights[:, None])

    def draw_noise(self, rng: Generator, count: int) -> Column:
        """Draw the noise of the reading, m; what is uncertain of an anchor is among the inputs."""
        return np.hstack([super().draw_noise(rng, count), np.zeros((count, len(self.anchors)))])

    def stretches(self, nodes: int) -> NDArray[np.intp]:
        """Return the number of the block of each sample; no block spans a remounting."""
        within: NDArray[np.intp] = super().stretches(nodes)
        return within + nodes * self.segments.astype(np.intp)

    def pooled(self) -> Self:
        """Return the problem itself: it is posed on pooled samples."""
        return self

    def reduced(self, nodes: int = NODES) -> Self:
        """Return the same problem on means over stretches of samples."""
        filled = np.flatnonzero(np.bincount(self.stretches(nodes)))
        return replace(super().reduced(nodes), segments=(filled // nodes).astype(float))

    def offsets_and_drift(self, coefficient: Column, values: Values, noise: Numbers = 0.0) -> Column:
        """Return the zero offsets and what drift adds over the run, m, for a k_D; one row a draw."""
        depth, _ = self.model(np.log(coefficient), values)
        residual = (self.rows(values) + noise - depth) * self.root_weights
        together = np.hstack([self.linear, self.law_columns])
        return np.asarray(residual @ np.linalg.pinv(together).T[:, : self.linear.shape[1]])

    def starting_depth(self, values: Values) -> Column:
        """Return the best estimate of the post-test measurement, m: from a low draw the search would end at no wear."""
        return np.broadcast_to(self.end_depth(self.values), np.shape(self.end_depth(values)))

    def measured(self, values: Values, coefficient: Column, noise: Numbers = 0.0) -> Column:
        """Return the pin's wear as the reading has it without drift, zero offset and disc wear found with a k_D, m."""
        count = len(self.distance)
        beside = self.linear[:count] / self.root_weights[:count, None]
        drift = self.offsets_and_drift(coefficient, values, noise) @ beside.T
        volume = np.asarray(coefficient)[..., None] * self.unit_volume(values, self._row_distance)
        state, grown = self.pin(values).worn(volume), self._grown(self._row_distance)
        disc = self.disc_wear(state.depth * grown, state.radius * np.sqrt(grown), values)
        return np.asarray((self.rows(values) + noise)[..., :count] - drift - disc)


def joint_problem(problem: WearProblem, corrected: CorrectedRun, recipe: Recipe) -> JointProblem:
    """Pose the joint fit of a run that a fit in two steps has been posed for."""
    manifest = corrected.run.manifest
    anchors, inputs = [Anchor(END_ANCHOR, problem.trace.slid, problem.end)], dict(problem.inputs)
    for name in ("zero_offset", "end_reading"):
        inputs.pop(name)
    for number, stop in enumerate(manifest.interruptions, start=1):
        wear = end_wear(corrected.run, recipe.uncertainty, number - 1)
        if wear is not None:
            anchors.append(Anchor(interruption_anchor(number), stop.place, wear))
            inputs[anchors[-1].name] = Input(wear.pin.quantity, wear.pin.source)
    joint = posed_as(
        problem,
        JointProblem,
        inputs=inputs,
        weights=np.ones(len(problem.distance)),
        anchors=tuple(anchors),
        segments=remountings(manifest, problem.distance),
    ).reduced()
    return with_fitted_law(joint)

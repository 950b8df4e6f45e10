"""The wear of one twin-disc run as a question: which k₁ and k₂ make both discs wear as was measured on them.

Rows are volumes, depths and track widths of both discs, at the end and where the test was interrupted, each over its
standard uncertainty. k₁ and k₂ are found by Gauss and Newton's method on their logarithms, for any values of the other
inputs, or for thousands of draws of them at once. Where nothing was measured on the flat disc it counts as unworn, and
k₁ alone is found: the paper's one-sided model.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.random import Generator

from tribopipe.base.arrays import Column, Values
from tribopipe.base.errors import FitError
from tribopipe.contacts.inputs import Input, best_values
from tribopipe.contacts.twin_disc import TwinDiscWear, disc_pair
from tribopipe.documents.contact import TwinDisc
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.documents.slip import slip
from tribopipe.evaluation.measurements.twin_disc import DiscMeasurement, Measured, disc_measurements
from tribopipe.evaluation.wear.given_parameters import law_as_given
from tribopipe.evaluation.wear.inputs import contact_inputs, draw_values, friction_along, law_friction, law_inputs
from tribopipe.evaluation.wear.scenario import effective_progress
from tribopipe.physics.conventions import DistanceConvention
from tribopipe.physics.friction_path import FrictionPath
from tribopipe.physics.laws import WearLaw, law_named
from tribopipe.physics.twin_disc import DiscWear
from tribopipe.results.evaluation import FrictionFit
from tribopipe.results.run import RawRun

_MOST_ITERATIONS = 60
_CONVERGED = 1e-12
_DRAWN = 1e-6
"""Of ln k_D in a draw: far below any uncertainty of k_D."""
_LEAST_LOG_K = 14.0
"""A k_D this many e-folds below where the search starts is no wear at all."""
_STEP = 1e-4
"""Of ln k in differences."""
_LEAST_SPREAD: dict[Measured, float] = {"wear_volume": 1e-20, "wear_depth": 1e-12, "track_width": 1e-9}
"""Standard uncertainty, SI, below which nothing is measured."""
_LEAST_DEPTH = 1e-12
"""Depth, m, from which the search starts where none was measured."""
_SLICE = 2_000
"""Draws solved at a time, so that their arrays stay in the processor's cache."""


@dataclass(frozen=True)
class DiscProblem:
    """One run and a law."""

    wearing: TwinDiscWear
    law: WearLaw
    measurements: tuple[DiscMeasurement, ...]
    inputs: Mapping[str, Input]
    friction: FrictionPath | None = None
    friction_covariance: tuple[tuple[float, ...], ...] | None = None
    """Of (A, b, c), where Eq. 7 is the friction."""

    @property
    def contact(self) -> TwinDisc:
        """The discs."""
        return self.wearing.contact

    @property
    def distance(self) -> DistanceConvention:
        """What counts as slid in one rotation."""
        return self.wearing.distance

    @cached_property
    def values(self) -> dict[str, float]:
        """Best estimates of the inputs, what was measured among them."""
        return best_values(self.inputs)

    @property
    def one_sided(self) -> bool:
        """Whether the flat disc counts as unworn."""
        return all(one.disc == "curved_disc" for one in self.measurements)

    @property
    def unknowns(self) -> int:
        """Number of wear coefficients that are found."""
        return 1 if self.one_sided else 2

    @cached_property
    def places(self) -> Column:
        """Rotations at which something was measured, each once."""
        return np.unique([one.rotations for one in self.measurements])

    def effective_rotations(self, values: Values, rotations: Column) -> Column:
        """Return the rotations in which Archard's law would wear as much: N·S(s)/s with the slip distance s."""
        friction = friction_along(self.friction, values, self.values)
        return effective_progress(self.law.at(values), rotations, np.asarray(rotations * self.wearing.slid), friction)

    def wear(self, coefficients: Column, values: Values, rotations: Column) -> DiscWear:
        """Return the discs after rotations, for k₁ and k₂ in m²/N: shape (2,), or (draws, 2) with columns of values."""
        first, second = coefficients[..., 0], coefficients[..., 1]
        if np.ndim(first):
            first, second = first[:, None], second[:, None]
        discs = disc_pair(self.contact, values, self.distance)
        return discs.worn(self.effective_rotations(values, rotations), first, second)

    def rows(self, values: Values) -> Column:
        """Return what was measured, SI: one value a row, or draws by rows."""
        return np.stack([_flat(values[one.name]) for one in self.measurements], axis=-1)

    def modelled(self, coefficients: Column, values: Values) -> Column:
        """Return what the law says each row is, SI."""
        return self._rows_of(self.wear(coefficients, values, self.places))

    def _rows_of(self, worn: DiscWear) -> Column:
        return np.stack([_modelled(worn, one)[..., at] for one, at in self._placed], axis=-1)

    @cached_property
    def _placed(self) -> list[tuple[DiscMeasurement, int]]:
        """Each measurement with its place among the rotations at which something was measured."""
        at = np.searchsorted(self.places, [one.rotations for one in self.measurements])
        return list(zip(self.measurements, at.tolist(), strict=True))

    @cached_property
    def root_weights(self) -> Column:
        """Inverse standard uncertainty of each row."""
        spreads = [
            max(self.inputs[one.name].spread, 1e-6 * abs(one.quantity.value), _LEAST_SPREAD[one.what])
            for one in self.measurements
        ]
        return 1 / np.asarray(spreads)

    def solve(self, values: Values, start: Column, tolerance: float = _CONVERGED) -> Column:
        """Return k₁ and k₂, m²/N, by least squares from a start; 0 where no wear fits best, NaN where none is found.

        Values of shape (draws, 1) give (draws, 2).
        """
        measured, free = self.rows(values), self.unknowns
        start = np.where(start > 0, start, self.scale)
        log_k = np.broadcast_to(np.log(start), (*measured.shape[:-1], 2)).copy()
        lowest, change = log_k - _LEAST_LOG_K, np.full(log_k.shape[:-1], np.inf)
        for _ in range(_MOST_ITERATIONS):
            model, slopes = self._model_and_slopes(self._coefficients(log_k), values)
            residual = (measured - model) * self.root_weights
            design = slopes[..., :free] * self.root_weights[:, None]
            step = np.clip(_least_squares(design, residual), -1.0, 1.0)
            moved = log_k.copy()
            moved[..., :free] = np.maximum(log_k[..., :free] + step, lowest[..., :free])
            change, log_k = np.max(np.abs(moved - log_k), axis=-1), moved
            if np.all(change < tolerance):
                break
        found = np.where(log_k <= lowest, 0.0, self._coefficients(log_k))
        return np.where((change < tolerance)[..., None], found, np.nan)

    def _coefficients(self, log_k: Column) -> Column:
        coefficients = np.exp(log_k)
        if self.one_sided:
            coefficients[..., 1] = 0.0
        return coefficients

    def _model_and_slopes(self, coefficients: Column, values: Values) -> tuple[Column, Column]:
        """Return what the law says each row is, and its slopes against ln k₁ and ln k₂.

        The slopes leave out that radii and slip change with wear, by parts in a thousand.
        """
        worn = self.wear(coefficients, values, self.places)
        recession = (worn.curved_rate + worn.flat_rate) * self.effective_rotations(values, self.places)
        part = worn.curved_rate / (worn.curved_rate + worn.flat_rate)
        widening = np.sqrt(np.square(values["crown_radius"]) - worn.half_width**2) / worn.half_width
        slopes = []
        for one, at in self._placed:
            curved = one.disc == "curved_disc"
            mine = part if curved else 1 - part
            if one.what == "track_width":
                grown, shift = 2 * recession * widening, np.zeros_like(part)
            else:
                radius = values["curved_radius" if curved else "flat_radius"]
                across = 4 * np.pi * radius * worn.half_width if one.what == "wear_volume" else 1.0
                # A disc's share w of the wear goes with its own ln k as w(1 − w), all of it with the recession.
                grown, shift = mine * across * recession, _modelled(worn, one) * (1 - mine)
            towards = (shift, -shift) if curved else (-shift, shift)
            both = [grown * share + part_of for share, part_of in zip((part, 1 - part), towards, strict=True)]
            slopes.append(np.stack(both, axis=-1)[..., at, :])
        return self._rows_of(worn), np.stack(slopes, axis=-2)

    @cached_property
    def scale(self) -> Column:
        """Coefficients of about the right size, m²/N, also for a disc on which no wear was found.

        As if the last thing measured on the curved disc, or its uncertainty where that is larger, were all its wear.
        """
        discs = disc_pair(self.contact, self.values, self.distance)
        last = {one.disc: one for one in self.measurements}
        curved, flat = last["curved_disc"], last.get("flat_disc")
        depth = {
            "wear_depth": lambda lost: lost,
            "wear_volume": lambda lost: discs.depth_of_area(lost / (2 * np.pi * self.values["curved_radius"])),
            "track_width": discs.depth_of_width,
        }[curved.what](_noticeable(curved))
        depth = max(float(depth), _LEAST_DEPTH)
        turns = float(self.effective_rotations(self.values, np.asarray(curved.rotations)))
        reached = float(discs.rotations(depth, 1.0))
        if not np.isfinite(reached):  # as if slip did not end before
            reached = float(disc_pair(self.contact, self.values, "contact-width").rotations(depth, 1.0))
        first = reached / turns
        same = flat is not None and flat.what == curved.what
        ratio = _noticeable(flat) / _noticeable(curved) if same and flat is not None else 0.5
        return np.array([first, first * max(ratio, 1e-6)])

    def coefficients(self) -> Column:
        """Return k₁ and k₂, m²/N, at the best estimates. Raises ``FitError`` where the curved disc shows no wear."""
        found = self.solve(self.values, self.scale)
        if not np.all(np.isfinite(found)):
            raise FitError(
                f"wear fit: found no k_D in {_MOST_ITERATIONS} iterations; expected end values that belong together, "
                "and discs that still slip at the end; check end values, rotations and slip"
            )
        if not found[0] > 0:
            raise FitError(
                "wear fit: found no wear of the curved disc; expected end values above zero; a longer or heavier test "
                "may show some"
            )
        return found

    def jacobian(self, coefficients: Column) -> Column:
        """Return the slopes of the weighted rows against the logarithms of what is found, by central differences."""
        columns = []
        for place in range(self.unknowns):
            low, high = (coefficients * np.exp(sign * _STEP * (np.arange(2) == place)) for sign in (-1, 1))
            columns.append((self.modelled(high, self.values) - self.modelled(low, self.values)) / (2 * _STEP))
        return np.stack(columns, axis=-1) * self.root_weights[:, None]

    def sensitivities(self, coefficients: Column) -> dict[str, Column]:
        """Return ∂ln k/∂x for each input, by central differences over its standard uncertainty."""
        jacobian = self.jacobian(coefficients)
        return {name: self._sensitivity(name, coefficients, jacobian) for name in self.inputs}

    def _sensitivity(self, name: str, coefficients: Column, jacobian: Column) -> Column:
        spread = self.inputs[name].spread
        if not spread:
            return np.zeros(self.unknowns)
        low, high = ({**self.values, name: self.values[name] + sign * spread} for sign in (-1, 1))
        change = self.rows(high) - self.rows(low)
        if name not in {one.name for one in self.measurements}:
            change = change - (self.modelled(coefficients, high) - self.modelled(coefficients, low))
        return _least_squares(jacobian, change * self.root_weights) / (2 * spread)

    def draw(self, rng: Generator, count: int, shared: Mapping[str, Column] | None = None) -> dict[str, Column]:
        """Draw each input, columns of shape (count, 1)."""
        return draw_values(self.inputs, self.friction_covariance, rng, count, shared)

    def solve_draws(self, values: Values, start: Column) -> Column:
        """Return k₁ and k₂, m²/N, of each draw: (draws, 2)."""
        count = len(np.asarray(values["normal_load"]))
        solved = []
        for first in range(0, count, _SLICE):
            some = {name: np.asarray(column)[first : first + _SLICE] for name, column in values.items()}
            solved.append(self.solve(some, start, _DRAWN))
        return np.concatenate(solved)


def _noticeable(one: DiscMeasurement) -> float:
    """Return what was measured, or what would have been noticed."""
    return max(one.quantity.value, one.quantity.standard_uncertainty or 0.0, _LEAST_SPREAD[one.what])


def _modelled(worn: DiscWear, one: DiscMeasurement) -> Column:
    if one.what == "track_width":
        return 2 * worn.half_width
    curved = one.disc == "curved_disc"
    if one.what == "wear_depth":
        return worn.curved_depth if curved else worn.flat_depth
    return worn.curved_volume if curved else worn.flat_volume


def _flat(values: object) -> Column:
    """Drop the axis that a column of draws, (draws, 1), has for broadcasting against rotations."""
    column = np.asarray(values, dtype=float)
    return column[..., 0] if column.ndim else column


def _least_squares(design: Column, rows: Column) -> Column:
    """Return the least-squares solution of each draw: (draws, rows, unknowns) and (draws, rows)."""
    scale = np.sqrt(np.sum(design**2, axis=-2))
    scaled = design / np.where(scale > 0, scale, 1.0)[..., None, :]
    normal = np.einsum("...ri,...rj->...ij", scaled, scaled)
    # A disc that shows no wear at all has no slope; its unknown then stays.
    normal = normal + 1e-12 * np.eye(normal.shape[-1])
    pull = np.einsum("...ri,...r->...i", scaled, rows)
    return np.linalg.solve(normal, pull[..., None])[..., 0] / np.where(scale > 0, scale, 1.0)


def disc_problem(
    run: RawRun, law: LawName, friction: FrictionFit | None, recipe: Recipe
) -> DiscProblem | tuple[str, ...]:
    """Pose the fit of k₁ and k₂ to a twin-disc run, or say what the run lacks for it.

    Raises ``FitError`` where local wear is asked for, which a pin alone is fitted by.
    """
    if recipe.wear.engine not in (None, "giwm"):
        raise FitError(
            f"{run.id}: found two discs to fit by --engine {recipe.wear.engine}; expected a pin; "
            "fit discs by the GIWM, --engine giwm"
        )
    measurements = disc_measurements(run, recipe.uncertainty)
    if not any(one.disc == "curved_disc" for one in measurements):
        return ("an end value of the curved disc (depth, track width or volume)",)
    known = law_friction(run, law, friction, recipe.wear.friction)
    if known is None:
        return ("a friction signal",)
    inputs = contact_inputs(run, recipe) | dict(known.inputs)
    inputs |= {one.name: Input(one.quantity, one.source) for one in measurements}
    inputs |= law_inputs(law_named(law), recipe)
    return DiscProblem(
        wearing=TwinDiscWear(run.manifest.twin_disc, slip(run.manifest), recipe.wear.distance_per_rotation),
        law=law_as_given(law, recipe),
        measurements=measurements,
        inputs=inputs,
        friction=known.path,
        friction_covariance=known.covariance,
    )

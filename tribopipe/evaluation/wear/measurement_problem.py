"""The wear of one run as a question to its post-test measurements: k_D that wears each body as measured.

Of thousands of draws, where the course of wear is explicit in some growth of the contact: a search for k_D that asks
for the wear after some progress inverts the course in each round, some thirty integrals for a draw of two discs. In
`ExplicitDraws` the growth at each place is found along with k_D by Newton's method, so that a round takes one
integral, and most draws start next to their solution: a quadratic in the inputs through the first of them gives it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from tribopipe.base.arrays import Column, Values
from tribopipe.base.errors import ContactError, FitError
from tribopipe.contacts.kinds import Terms, wear_of
from tribopipe.contacts.wear import ExplicitWear, MeasuredWear, Noticed, Row, State
from tribopipe.documents.contact import Contact
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.evaluation.load_and_friction import load_course
from tribopipe.evaluation.measurements.body_wear import BodyMeasurement
from tribopipe.evaluation.measurements.kinds import measurements_of
from tribopipe.evaluation.wear.inputs import (
    FrictionCovariance,
    contact_inputs,
    draw_values,
    friction_along,
    law_as_given,
    law_friction,
    law_inputs,
    per_draw,
)
from tribopipe.evaluation.wear.scenario import effective_progress
from tribopipe.physics.friction_path import FrictionPath
from tribopipe.physics.laws import WearLaw, law_named
from tribopipe.physics.load_course import LoadCourse
from tribopipe.physics.uncertainty import Inputs, extended
from tribopipe.results.evaluation import FrictionFit
from tribopipe.results.input_quantities import Input, best_values
from tribopipe.results.run import RawRun
from tribopipe.results.wear_fit import NO_FRICTION


def least_squares(design: Column, rows: Column) -> Column:
    """Return the least-squares solution of each draw: (draws, rows, unknowns) and (draws, rows)."""
    scale = np.sqrt(np.sum(design**2, axis=-2))
    scaled = design / np.where(scale > 0, scale, 1.0)[..., None, :]
    normal = np.einsum("...ri,...rj->...ij", scaled, scaled)
    # A body that shows no wear at all has no slope; its unknown then stays.
    normal = normal + 1e-12 * np.eye(normal.shape[-1])
    pull = np.einsum("...ri,...r->...i", scaled, rows)
    return np.linalg.solve(normal, pull[..., None])[..., 0] / np.where(scale > 0, scale, 1.0)


_FIRST = 500
"""Draws that the others' start is interpolated from."""
_EXPLICIT_SLICE = 2_000
"""Draws solved at a time, so that their arrays stay in the processor's cache."""
_MOST_ROUNDS = 12
_MISSED = 1e-5
"""Relative difference of progress to which a state is corrected by its slope; what is left is about its square."""


@dataclass(frozen=True)
class ExplicitDraws:
    """Draws of what was measured on the bodies, and of the inputs that their wear depends on."""

    wearing: ExplicitWear
    rows: Sequence[Row]
    root_weights: Column
    """Inverse standard uncertainty of each row."""
    unknowns: int
    """Number of k_D that are found; those of further bodies are 0."""
    values: dict[str, Column]
    """Columns of shape (draws, 1)."""
    measured: Column
    """(draws, rows)."""
    progress: Column
    """Effective progress at each place, (draws, places)."""

    def solved(self, start: Column, tolerance: float) -> Column:
        """Return the logarithms of k_D of each draw, (draws, bodies), NaN where one does not settle.

        ``start`` has the logarithms of k_D of each body and of the growth at each place, (bodies + places,).
        """
        starts = np.broadcast_to(start, (len(self.measured), len(start)))
        found = np.full(starts.shape, np.nan)
        for first, last in pairwise([0, *range(_FIRST, len(found), _EXPLICIT_SLICE), len(found)]):
            part = np.arange(first, last)
            found[part] = self._of(part).settled(starts[part], tolerance)
            if first == 0 and last < len(found):
                starts = self._foreseen(found, starts)
        return found[:, : len(start) - self.progress.shape[1]]

    def _of(self, draws: NDArray[np.intp]) -> "ExplicitDraws":
        values = {name: column[draws] for name, column in self.values.items()}
        return replace(self, values=values, measured=self.measured[draws], progress=self.progress[draws])

    def _foreseen(self, found: Column, starts: Column) -> Column:
        """Return starts of all draws by a quadratic through those that are found, where there are enough of these."""
        inputs = Inputs.of(np.concatenate(list(self.values.values()), axis=1))
        (known,) = np.nonzero(np.all(np.isfinite(found), axis=1))
        return extended(inputs, known, found[known]) if len(known) > 2 * inputs.terms.shape[1] else starts

    def settled(self, starts: Column, tolerance: float) -> Column:
        """Return logarithms of k_D and of growth from a start, NaN where a draw does not settle."""
        try:
            with np.errstate(all="ignore"):
                return self._newton(starts, tolerance)
        except (ContactError, np.linalg.LinAlgError):  # one of them is no contact, which the others are not to suffer
            return np.full(starts.shape, np.nan)

    def _newton(self, starts: Column, tolerance: float) -> Column:
        course, bodies = self.wearing.course(self.values), starts.shape[1] - self.progress.shape[1]
        log_k, log_growth = starts[:, :bodies].copy(), starts[:, bodies:]
        places = [row.place for row in self.rows]
        settled = np.zeros(len(starts), dtype=bool)
        for _ in range(_MOST_ROUNDS):
            coefficients = self._coefficients(log_k)
            reached = course.at(np.exp(log_growth), *(coefficients[:, [body]] for body in range(bodies)))
            missed = np.log(self.progress / reached.progress)
            slopes = self.wearing.slopes(self.values, reached.state, reached.progress, self.rows)
            # All k_D together count as progress does.
            model = self.wearing.measured(reached.state, self.rows) + np.sum(slopes, axis=-1) * missed[:, places]
            design = slopes[..., : self.unknowns] * self.root_weights[:, None]
            step = np.clip(least_squares(design, (self.measured - model) * self.root_weights), -1.0, 1.0)
            log_k[:, : self.unknowns] += step
            more = np.log(np.sum(self._coefficients(log_k), axis=1) / np.sum(coefficients, axis=1))
            log_growth = log_growth + np.clip(reached.slope * (missed + more[:, None]), -1.0, 1.0)
            settled = (np.max(np.abs(step), axis=1) < tolerance) & (np.max(np.abs(missed), axis=1) < _MISSED)
            if np.all(settled):
                break
        return np.where(settled[:, None], np.concatenate([log_k, log_growth], axis=1), np.nan)

    def _coefficients(self, log_k: Column) -> Column:
        coefficients = np.exp(log_k)
        coefficients[:, self.unknowns :] = 0.0
        return coefficients


_MOST_ITERATIONS = 60
_CONVERGED = 1e-12
_DRAWN = 1e-6
"""Tolerance of ln k_D in a draw: far below any uncertainty of k_D."""
_LEAST_LOG_K = 14.0
"""A k_D this many e-folds below where the search starts is no wear at all."""
_STEP = 1e-4
"""Step of ln k in difference quotients."""
_SLICE = 2_000
"""Draws solved at a time, so that their arrays stay in the processor's cache."""


@dataclass(frozen=True)
class MeasurementProblem:
    """One run and a law."""

    contact: Contact
    wearing: MeasuredWear
    law: WearLaw
    measurements: tuple[BodyMeasurement, ...]
    inputs: Mapping[str, Input]
    friction: FrictionPath | None = None
    friction_covariance: FrictionCovariance = None
    """Covariance of (A, b, c), if friction is from Eq. 7."""
    load: LoadCourse | None = None
    """Load along the test; None where it counts as constant."""

    @cached_property
    def values(self) -> dict[str, float]:
        """Best estimates of the inputs, what was measured among them."""
        return best_values(self.inputs)

    @cached_property
    def bodies(self) -> tuple[str, ...]:
        """The bodies whose k_D is found: those on which something was measured; others count as unworn."""
        measured = {one.body for one in self.measurements}
        return tuple(body for body in self.contact.fitted_bodies if body in measured)

    @property
    def unknowns(self) -> int:
        """Number of wear coefficients that are found."""
        return len(self.bodies)

    @property
    def one_sided(self) -> bool:
        """Whether the second body counts as unworn."""
        return self.unknowns < len(self.contact.fitted_bodies)

    @cached_property
    def places(self) -> Column:
        """Progress at which something was measured, each once."""
        return np.unique([one.place for one in self.measurements])

    def effective(self, values: Values, places: Column) -> Column:
        """Return the progress after which Archard's law would have worn as much."""
        friction = friction_along(self.friction, values, self.values)
        slid = np.asarray(places * self.wearing.slid)
        return effective_progress(self.law.at(values), places, slid, friction, self.load)

    def wear(self, coefficients: Column, values: Values, places: Column) -> State:
        """Return the contact at places, for k_D of both bodies, m²/N: (2,), or (draws, 2) with columns of values."""
        each = [coefficients[..., place] for place in range(coefficients.shape[-1])]
        if coefficients.ndim > 1:
            each = [one[:, None] for one in each]
        known = dict(zip(self.wearing.coefficients, each, strict=True))
        return self.wearing.worn({**values, **known}, self.effective(values, places))

    def rows(self, values: Values) -> Column:
        """Return what was measured, SI: one value a row, or draws by rows."""
        return np.stack([per_draw(values[one.name]) for one in self.measurements], axis=-1)

    def modelled(self, coefficients: Column, values: Values) -> Column:
        """Return each row as the law gives it, SI."""
        return self.wearing.measured(self.wear(coefficients, values, self.places), self._placed)

    @cached_property
    def _placed(self) -> list[Row]:
        """Each measurement with its place among those at which something was measured."""
        at = np.searchsorted(self.places, [one.place for one in self.measurements]).tolist()
        return [Row(one.body, one.what, place) for one, place in zip(self.measurements, at, strict=True)]

    @cached_property
    def root_weights(self) -> Column:
        """Inverse standard uncertainty of each row."""
        spreads = [
            max(self.inputs[one.name].spread, 1e-6 * abs(one.quantity.value), self.wearing.least[one.what])
            for one in self.measurements
        ]
        return 1 / np.asarray(spreads)

    def solve(self, values: Values, start: Column, tolerance: float = _CONVERGED) -> Column:
        """Return k_D, m²/N, by least squares from a start; 0 where no wear fits best, NaN where none is found.

        Values of shape (draws, 1) give (draws, 2).
        """
        measured, free = self.rows(values), self.unknowns
        start = np.where(start > 0, start, self.scale)
        log_k = np.broadcast_to(np.log(start), (*measured.shape[:-1], len(start))).copy()
        lowest, change = log_k - _LEAST_LOG_K, np.full(log_k.shape[:-1], np.inf)
        for _ in range(_MOST_ITERATIONS):
            state = self.wear(self._coefficients(log_k), values, self.places)
            slopes = self.wearing.slopes(values, state, self.effective(values, self.places), self._placed)
            residual = (measured - self.wearing.measured(state, self._placed)) * self.root_weights
            design = slopes[..., :free] * self.root_weights[:, None]
            step = np.clip(least_squares(design, residual), -1.0, 1.0)
            moved = log_k.copy()
            moved[..., :free] = np.maximum(log_k[..., :free] + step, lowest[..., :free])
            change, log_k = np.max(np.abs(moved - log_k), axis=-1), moved
            if np.all(change < tolerance):
                break
        found = np.where(log_k <= lowest, 0.0, self._coefficients(log_k))
        return np.where((change < tolerance)[..., None], found, np.nan)

    def _coefficients(self, log_k: Column) -> Column:
        coefficients = np.exp(log_k)
        coefficients[..., self.unknowns :] = 0.0
        return coefficients

    @cached_property
    def scale(self) -> Column:
        """Coefficients of about the right size, m²/N, also for a body on which no wear was found."""
        last = {one.body: one for one in self.measurements}
        return self.wearing.guess(self.values, {body: self._noticed(one) for body, one in last.items()})

    def _noticed(self, one: BodyMeasurement) -> Noticed:
        """Return what was measured, or what would have been noticed."""
        value = max(one.quantity.value, one.quantity.u_or_zero, self.wearing.least[one.what])
        return Noticed(one.what, value, float(self.effective(self.values, np.asarray(one.place))))

    def coefficients(self) -> Column:
        """Return k_D, m²/N, at the best estimates. Raises ``FitError`` where the first body shows no wear."""
        found, first = self.solve(self.values, self.scale), spoken(self.contact.fitted_bodies[0])
        if not np.all(np.isfinite(found)):
            raise FitError(
                f"wear fit: found no k_D in {_MOST_ITERATIONS} iterations; expected consistent post-test "
                "measurements, and discs that still slip at the end; check end_values, rotations and slip"
            )
        if not found[0] > 0:
            raise FitError(
                f"wear fit: found no wear of the {first}; expected positive post-test measurements; run a longer "
                f"test, or use a higher load"
            )
        return found

    def jacobian(self, coefficients: Column) -> Column:
        """Return the slopes of the weighted rows against the logarithms of what is found, by central differences."""
        columns, all_of_them = [], np.arange(len(coefficients))
        for place in range(self.unknowns):
            low, high = (coefficients * np.exp(sign * _STEP * (all_of_them == place)) for sign in (-1, 1))
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
        return least_squares(jacobian, change * self.root_weights) / (2 * spread)

    def limits(self, coefficients: Column) -> tuple[str, ...]:
        """Report where the bodies leave what the model describes at the end."""
        last = self.wear(coefficients, self.values, np.asarray(self.places[-1]))
        return self.wearing.notes(self.values, last)

    def draw(self, rng: Generator, count: int, shared: Mapping[str, Column] | None = None) -> dict[str, Column]:
        """Draw each input, columns of shape (count, 1)."""
        return draw_values(self.inputs, self.friction_covariance, rng, count, shared)

    def solve_draws(self, values: Values, start: Column) -> Column:
        """Return k_D of each body, m²/N, of each draw, (draws, bodies), from those at the best estimates.

        Columns of ``values`` are (draws, 1). 0 where no wear fits best, NaN where no k_D is found.
        """
        columns = {name: np.asarray(column, dtype=float) for name, column in values.items()}
        found = self._solve_explicitly(columns, start)
        (left,) = np.nonzero(~np.all(np.isfinite(found), axis=1))
        for first in range(0, len(left), _SLICE):
            some = left[first : first + _SLICE]
            found[some] = self.solve({name: column[some] for name, column in columns.items()}, start, _DRAWN)
        return found

    def _solve_explicitly(self, values: dict[str, Column], start: Column) -> Column:
        """Return k_D of Monte Carlo draws by explicit integration; NaN for draws without a converged solution."""
        wearing, measured, free = self.wearing, self.rows(values), self.unknowns
        none = np.full((len(measured), len(start)), np.nan)
        if not isinstance(wearing, ExplicitWear) or not np.all(start[:free] > 0):
            return none
        first = np.where(np.arange(len(start)) < free, start, 0.0)
        growth = wearing.course(self.values).growth(self.effective(self.values, self.places), *first)
        if not np.all(growth > 0):
            return none
        progress = np.broadcast_to(self.effective(values, self.places), (len(measured), len(self.places)))
        draws = ExplicitDraws(wearing, self._placed, self.root_weights, free, values, measured, progress)
        logarithms = np.log(np.concatenate([np.where(first > 0, first, 1.0), growth]))
        return self._coefficients(draws.solved(logarithms, _DRAWN))


def measurement_problem(
    run: RawRun, law: LawName, friction: FrictionFit | None, recipe: Recipe
) -> MeasurementProblem | tuple[str, ...]:
    """Pose the fit of k_D to what was measured on the bodies of a run, or report what is missing for it.

    Raises ``FitError`` where another engine than the GIWM is asked for, which needs a depth signal that gives the wear.
    """
    contact = run.manifest.described
    wearing = wear_of(contact, Terms(run.manifest.slip, "giwm", recipe.wear.distance_per_rotation))
    if recipe.wear.engine not in (None, "giwm") or not isinstance(wearing, MeasuredWear):
        raise FitError(
            f"{run.id}: found {contact.title} with --engine {recipe.wear.engine}; expected the GIWM, since the "
            "wear of these bodies cannot be determined from the depth signal; use --engine giwm"
        )
    measurements, first = measurements_of(contact).single(run, recipe.uncertainty), contact.fitted_bodies[0]
    if not any(one.body == first for one in measurements):
        return (f"a post-test measurement of the {spoken(first)} (wear depth, track width or wear volume)",)
    known = law_friction(run, law, friction, recipe.wear.friction)
    if known is None:
        return (NO_FRICTION,)
    inputs = contact_inputs(run, recipe) | dict(known.inputs)
    inputs |= {one.name: Input(one.quantity, one.source) for one in measurements}
    inputs |= law_inputs(law_named(law), recipe)
    return MeasurementProblem(
        contact=contact,
        wearing=wearing,
        law=law_as_given(law, recipe),
        measurements=measurements,
        inputs=inputs,
        friction=known.path,
        friction_covariance=known.covariance,
        load=load_course(run, wearing.slid),
    )

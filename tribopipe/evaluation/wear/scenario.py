"""Wear of a contact from known wear coefficients: at any place, and where a depth is reached.

`KnownWear` is k_D of the bodies as a prediction takes it over: with all that makes it mean what it does.
"""

import math
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from tribopipe.base.arrays import Column, Values
from tribopipe.base.errors import FitError
from tribopipe.base.units import KINDS
from tribopipe.contacts.kinds import Terms, wear_of
from tribopipe.contacts.wear import ContactWear, State, Steps
from tribopipe.documents.contact import Contact
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.evaluation.wear.inputs import distance_scale, friction_along, law_inputs, require_all
from tribopipe.physics.calculation_methods import DistanceConvention, WearEngine
from tribopipe.physics.friction_path import FrictionPath
from tribopipe.physics.laws import WearLaw, law_named
from tribopipe.physics.load_course import LoadCourse, effective_distance
from tribopipe.results.evaluation import COVERAGE_FACTOR
from tribopipe.results.input_quantities import Input, best_values
from tribopipe.results.run import RawRun
from tribopipe.results.wear_fit import HertzStart, LawValue, WearFit
from tribopipe.results.wear_prediction import Band, PredictedBody, PredictedContact, PredictedPoint

_UNWORN = Quantity(value=0.0, unit="m^2/N")


@dataclass(frozen=True)
class KnownWear:
    """k_D of each body, m²/N; a body that is left out does not wear."""

    bodies: Mapping[str, Quantity]
    """k_D of each body by name; the first is always known."""
    engine: WearEngine = "giwm"
    """Engine from which k_D was found; another engine gives another depth."""
    distance: DistanceConvention = "full-slip"
    """Sliding distance per rotation of bodies that roll; under another convention k_D has another meaning."""
    correlation: float = 0.0
    """Correlation between the k_D of both bodies."""
    parameters: tuple[LawValue, ...] = ()
    """Law parameters in addition to k_D."""
    covariance: tuple[tuple[float, ...], ...] | None = None
    """Covariance of ln k_D and the fitted law parameters."""
    left_out: tuple[str, ...] = ()
    """Bodies whose k_D is known, but not the length of the track along which they wear."""

    def along(self, path: Quantity | None, fitted_bodies: Collection[str]) -> "KnownWear":
        """Return k_D by which a run can be predicted: without the length of its track, that of the pin alone."""
        left_out = () if path else tuple(name for name in self.bodies if name not in fitted_bodies)
        kept = {name: found for name, found in self.bodies.items() if name not in left_out}
        return replace(self, bodies=kept, correlation=0.0, left_out=left_out) if kept and left_out else self

    @property
    def first(self) -> Quantity:
        """k_D of the body whose k_D is always known."""
        return next(iter(self.bodies.values()))

    def of(self, body: str) -> Quantity:
        """Return k_D of a body, 0 where it does not wear."""
        return self.bodies.get(body, _UNWORN)

    @property
    def parts(self) -> tuple[Quantity | str, ...]:
        """Everything that identifies it, for a fingerprint."""
        bodies = [part for name, found in self.bodies.items() for part in (name, found)]
        beside = [part for one in self.parameters for part in (one.name, one.value)]
        return *bodies, self.engine, self.distance, str(self.correlation), *beside, str(self.covariance)


def known_wear(fit: WearFit) -> KnownWear | None:
    """Return k_D of a fit; None if nothing was fitted."""
    if not fit.bodies:
        return None
    return KnownWear(
        {name: body.wear_coefficient for name, body in fit.bodies.items()},
        engine=fit.engine,
        distance=fit.distance_per_rotation or "full-slip",
        correlation=fit.correlation or 0.0,
        parameters=fit.parameters or (),
        covariance=fit.parameter_covariance,
    )


def given_wear(contact: Contact, coefficients: Mapping[str, Quantity], recipe: Recipe) -> KnownWear:
    """Return k_D that somebody states of bodies by name, those without one unworn, as a recipe takes it.

    The GIWM has no counterbody that wears: raises ``FitError`` where the recipe asks for it then.
    """
    stated = {name: coefficients[name] for name in contact.body_names if name in coefficients}
    both, engine = any(name not in contact.fitted_bodies for name in stated), recipe.wear.engine
    if both and engine == "giwm":
        raise FitError(
            f"wear coefficients: found values for the {' and '.join(map(spoken, stated))} with --engine giwm, which "
            "computes only the wear of the pin; expected --engine volume or local, or k_D of the pin alone"
        )
    if both:
        # Depths that are to be reached are those of the first body, so that it has to wear.
        stated = {name: k for name, k in stated.items() if k.value > 0 or name not in contact.fitted_bodies}
    usual: WearEngine = "volume" if both else "giwm"
    return KnownWear(stated, engine=engine or usual, distance=recipe.wear.distance_per_rotation)


def _no_gain(coefficient: Quantity) -> Quantity:
    """Return a k_D as bodies can wear by it: at least 0, and as uncertain as it is."""
    return coefficient.model_copy(update={"value": max(0.0, coefficient.value)})


MOST_STEPS = 5_000_000
"""A rotation of two discs at a time takes about a second for every million of them."""
_STEP = 1e-4
"""Relative step of an input in a difference quotient: small enough to stay linear however wide the uncertainty is."""
_UNITS = {
    **dict.fromkeys(("half_width", "half_length", "approach", "wear_depth", "track_depth"), "m"),
    **dict.fromkeys(("pin_volume", "track_volume"), "m^3"),
    "track_section": "m^2",
    "pressure": "Pa",
    "slip": "1",
}


@dataclass(frozen=True)
class Scenario:
    """Scenario of a wear prediction: contact, load, slip, law and k_D. Places are counted along the contact's progress.

    Uncertainties of the inputs are taken as independent of each other, but for what was fitted together.
    """

    contact: Contact
    normal_load: Quantity
    known: KnownWear
    model: LawName = "archard"
    friction: FrictionPath | None = None
    recipe: Recipe = field(default_factory=Recipe)
    speed: Quantity | None = None
    """Speed by which places follow from time, m/s."""
    slip: Quantity | None = None
    """Slip ratio of rolling bodies."""
    path: Quantity | None = None
    """Sliding distance between two passages of a pin at one place of its track, m."""
    there_and_back: bool = False
    """Whether that path is a stroke."""
    friction_inputs: Mapping[str, Input] = field(default_factory=dict)
    """A, b and c, where they were stated with their uncertainties."""
    load: LoadCourse | None = None
    """Load along the test; None where it counts as constant."""
    distance_inputs: Mapping[str, Input] = field(default_factory=dict)
    """What places along a run were derived from; empty for places that are wanted."""

    @cached_property
    def wear(self) -> ContactWear:
        """Wear model of the bodies."""
        known = self.known
        terms = Terms(self.slip, known.engine, known.distance, self.path, self.there_and_back, known.bodies)
        return wear_of(self.contact, terms)

    @property
    def first(self) -> str:
        """The body whose k_D is known first, and whose depth a place is found by."""
        return next(iter(self.known.bodies))

    @cached_property
    def law(self) -> WearLaw:
        """The law. Raises ``FitError`` where it is not installed here, or where nobody gave a parameter of it."""
        law = law_named(self.model)
        values = best_values(self._law_inputs(law))
        require_all(law, values)
        return law.at(values)

    def _law_inputs(self, law: WearLaw) -> dict[str, Input]:
        found = {law.input_of(one.name): Input(one.value, one.source) for one in self.known.parameters}
        return law_inputs(law, self.recipe) | found

    @cached_property
    def inputs(self) -> dict[str, Input]:
        """Everything uncertain that wear depends on, k_D among it."""
        bodies = zip(self.wear.coefficients, self.wear.bodies, strict=True)
        coefficients = {name: Input(_no_gain(self.known.of(body)), "fit") for name, body in bodies}
        friction = dict(self.friction_inputs) if self.law.needs_friction else {}
        others = coefficients | self._law_inputs(self.law) | friction | dict(self.distance_inputs)
        return self.wear.inputs(self.normal_load, self.recipe) | others

    @cached_property
    def values(self) -> dict[str, float]:
        """Best estimates of the inputs."""
        return best_values(self.inputs)

    @property
    def start(self) -> HertzStart | None:
        """Contact of the unworn bodies, where the published scheme starts from it."""
        return self.wear.start(self.values)

    def effective(self, places: Column, values: Values | None = None) -> Column:
        """Return the progress after which Archard's law has worn as much: N·S(s)/s with s the distance after N."""
        slid, known = np.asarray(places * self.wear.slid), values or self.values
        friction = friction_along(self.friction, known, self.values)
        effective = effective_progress(self.law.at(values or {}), places, slid, friction, self.load)
        return np.asarray(effective * distance_scale(known, self.values))

    def worn(self, places: Column, values: Values | None = None) -> State:
        """Return wear at places, in the limit of small steps. Raises ``ContactError`` where a body is worn away."""
        values = values or self.values
        return self.wear.worn(values, self.effective(places, values))

    def published(self, places: Column, steps: int) -> State:
        """Return wear at places by the paper's explicit Euler scheme, in so many equal steps up to the last of them.

        Raises ``FitError`` for more steps than can be waited for.
        """
        if not 1 <= steps <= MOST_STEPS:
            raise FitError(
                f"published scheme: found {steps:,} steps; expected 1 to {MOST_STEPS:,}; specify a different number "
                "with --steps, or use the exact scheme"
            )
        ends = np.linspace(0.0, float(np.max(places)), steps + 1)
        factor = self.law.rate_factor(ends * self.wear.slid, self.friction)
        return self.wear.published(self.values, Steps(ends, self.effective(ends), factor), places)

    def rate(self, places: Column) -> Column:
        """Return how fast the first body recedes, m over the unit of the progress."""
        factor = self.law.rate_factor(places * self.wear.slid, self.friction)
        return np.asarray(self.worn(places)["rate"] * factor)

    def first_depth(self, state: State) -> Column:
        """Return the wear depth of the first body, m."""
        return state[self.wear.bodies[self.first]["wear_depth"]]

    def place_at(self, depth: float) -> float:
        """Return where the first body has worn to a depth, m; infinite where it never has.

        Raises ``ContactError`` where it would be worn away before that.
        """
        from scipy.optimize import brentq

        if not self.known.first.value > 0:
            return math.inf
        wanted = float(self.wear.progress_to(self.values, depth))
        if not 0 < wanted < math.inf:
            return wanted

        def excess(place: float) -> float:
            return float(self.effective(np.asarray(place))) - wanted

        return float(brentq(excess, 0.0, _beyond(excess, wanted), xtol=1e-12 * wanted, rtol=1e-13))

    def notes(self, places: Column) -> tuple[str, ...]:
        """Report what the model assumes of the contact, and where wear at places leaves it."""
        return self.wear.notes(self.values, self.worn(np.asarray(np.max(places))) if np.size(places) else None)

    def points(self, places: Column, state: State) -> Iterator[PredictedPoint]:
        """Yield wear and contact at each place with their uncertainties, without time."""
        wear, spreads = self.wear, self.uncertainties(places)
        units = {**_UNITS, **wear.outcomes}
        effective = self.effective(places)
        # The model counts effective progress; what is slid in it is slid in the true one.
        truly = np.divide(places, effective, out=np.ones_like(places), where=effective > 0)
        slid = state["sliding_distance"] * truly if "sliding_distance" in state else places
        for place in range(len(places)):

            def told(name: str, at: int = place) -> Quantity:
                spread = float(spreads[name][at]) if name in spreads else None
                return Quantity(value=float(state[name][at]), unit=units[name], standard_uncertainty=spread)

            bodies = {
                body: PredictedBody(**{field: told(name) for field, name in named.items()})
                for body, named in wear.bodies.items()
            }
            where = {"sliding_distance": Quantity(value=float(slid[place]), unit="m")}
            progress = self.contact.progress
            where[progress.signal] = Quantity(value=float(places[place]), unit=KINDS[progress.kind].si)
            yield PredictedPoint(
                **where,
                bodies=bodies,
                contact=PredictedContact(
                    approach=told(wear.displacement),
                    half_width=told("half_width"),
                    half_length=told("half_length"),
                    mean_pressure=told("pressure"),
                ),
                slip=told("slip") if "slip" in state else None,
            )

    # --- uncertainty, to first order (JCGM 100:2008, 5.2.2) ---

    @cached_property
    def _together(self) -> tuple[tuple[str, ...], Column]:
        """k_D and the law parameters fitted with it, with their covariance."""
        known, names = self.known, self.wear.coefficients
        if known.covariance is None:
            spreads = [self.inputs[name].spread for name in names]
            correlations = np.where(np.eye(len(names), dtype=bool), 1.0, known.correlation)
            return names, np.outer(spreads, spreads) * correlations
        fitted = [
            self.law.input_of(one.name)
            for one in known.parameters
            if one.source == "fit" and one.value.standard_uncertainty is not None
        ]
        scale = np.array([known.first.value, *np.ones(len(fitted))])
        return (*names, *fitted), np.asarray(known.covariance) * np.outer(scale, scale)

    def uncertainties(self, places: Column, of: Collection[str] | None = None) -> dict[str, Column]:
        """Return the standard uncertainty of what is predicted with one, from all inputs or only those named."""
        together, covariance = self._together
        alone = [name for name, given in self.inputs.items() if given.spread > 0 and name not in together]
        variance = {outcome: np.zeros(np.shape(places)) for outcome in self.wear.uncertain}
        for name in alone if of is None else [name for name in alone if name in of]:
            for outcome, slope in self._slopes(places, name).items():
                variance[outcome] = variance[outcome] + (slope * self.inputs[name].spread) ** 2
        asked = [place for place, name in enumerate(together) if of is None or name in of]
        moved = [self._slopes(places, together[place]) for place in asked if covariance[place, place] > 0]
        asked = [place for place in asked if covariance[place, place] > 0]
        for outcome in self.wear.uncertain if moved else ():
            slopes = np.stack([one[outcome] for one in moved])
            variance[outcome] += np.einsum("i...,ij,j...->...", slopes, covariance[np.ix_(asked, asked)], slopes)
        return {outcome: np.sqrt(np.maximum(found, 0.0)) for outcome, found in variance.items()}

    def _slopes(self, places: Column, name: str) -> dict[str, Column]:
        """Return how each outcome moves with an input, over its unit."""
        middle = self.values[name]
        # A coefficient of 0 has nothing below it, and the depth of a cap no slope there: as far as it may be off.
        step = _STEP * abs(middle) or self.inputs[name].spread
        below = middle - step if middle else 0.0
        high, low = (self.worn(places, {**self.values, name: value}) for value in (middle + step, below))
        return {one: (high[one] - low[one]) / (middle + step - below) for one in self.wear.uncertain}

    # --- along a run ---

    def bands(self, run: RawRun) -> dict[str, Band]:
        """Return wear along the run it is predicted for, with bands of all inputs."""
        return self._bands(run, None)

    def fitted_bands(self, run: RawRun, fit: WearFit) -> dict[str, Band]:
        """Return wear along the run that k_D was fitted to, with bands of what was fitted."""
        first = next(iter(fit.bodies.values()))
        if self.known.covariance is not None or first.fitted_end_depth is None:
            return self._bands(run, self._together[0])
        # On a counterbody that wears, more volume is lost at the same depth: the curve ends on the fitted one.
        along, places = self._places(run)
        whole = float(self.effective(np.asarray(np.nanmax(along))))
        share = float(self.wear.progress_to(self.values, first.fitted_end_depth.value)) / whole if whole > 0 else 1.0
        coefficient = self.wear.coefficients[0]
        worn = [
            self.worn(places, {**self.values, coefficient: share * k.value})
            for k in (first.wear_coefficient, *first.interval)
        ]
        return {
            name: Band(*(_at(along, places, one[name]) for one in worn), unit=unit)
            for name, unit in self.wear.outcomes.items()
        }

    def _bands(self, run: RawRun, of: Collection[str] | None) -> dict[str, Band]:
        along, places = self._places(run)
        worn, spreads = self.worn(places), self.uncertainties(places, of)
        found: dict[str, Band] = {}
        for name, unit in self.wear.outcomes.items():
            half = COVERAGE_FACTOR * spreads[name]
            lines = (worn[name], np.maximum(worn[name] - half, 0.0), worn[name] + half)
            found[name] = Band(*(_at(along, places, line) for line in lines), unit=unit)
        return found

    def _places(self, run: RawRun) -> tuple[Column, Column]:
        """Return the progress of each sample, and the places along it at which wear is computed."""
        along, most = np.maximum(run.progress, 0.0), self.wear.most_places
        return along, along if most is None else _shares(most) * float(np.nanmax(along))


def _at(along: Column, places: Column, line: Column) -> Column:
    """Return a line at each sample, linear between the places at which it was computed."""
    return line if places is along else np.interp(along, places, line)


def _shares(most: int) -> Column:
    """Return fractions of the test length, denser at its start."""
    return np.unique(np.concatenate([np.linspace(0.0, 1.0, most // 2) ** power for power in (1, 3)]))


def effective_progress(
    law: WearLaw, places: Column, slid: Column, friction: FrictionPath | None, load: LoadCourse | None
) -> Column:
    """Return the progress in which Archard's law would wear as much, for sliding distance until then, m."""
    effective = effective_distance(law, slid, friction, load)
    # By the share of it Archard's law keeps every digit, and no slip is no wear.
    return places * np.divide(effective, slid, out=np.ones_like(effective), where=slid != 0)


def _beyond(excess: Callable[[float], float], start: float) -> float:
    """Return a place at or after the start where an excess, which grows, is not below zero.

    Raises ``FitError`` where there is none within a billion times the start.
    """
    for doublings in range(30):
        if excess(place := start * 2.0**doublings) >= 0:
            return place
    raise FitError(
        "wear law: found a wear depth that is never reached, since the wear rate decreases to zero; expected a depth "
        "that can be reached; specify a smaller depth"
    )

"""k_D of each body of one run by what was measured on the bodies after the test.

By the course of wear of the contact, or by the volumes lost, k_D = V/(F_N·S), whatever the shape of the bodies; with
what the uncertainties are made of.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.random import Generator

from tribopipe.base.arrays import Column, Numbers, Values
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.quantity import Quantity, wear_coefficient
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.evaluation.load_and_friction import load_course
from tribopipe.evaluation.measurements.body_wear import BodyWear as BodyLoss
from tribopipe.evaluation.measurements.body_wear import surest
from tribopipe.evaluation.measurements.kinds import worn_bodies
from tribopipe.evaluation.measurements.readings import SignalDepths
from tribopipe.evaluation.measurements.sliding_distance import told_by
from tribopipe.evaluation.wear.findings import unseen_groove
from tribopipe.evaluation.wear.inputs import (
    FrictionCovariance,
    distance_scale,
    draw_values,
    friction_along,
    law_as_given,
    law_friction,
    law_inputs,
    load_input,
)
from tribopipe.evaluation.wear.measurement_problem import MeasurementProblem, measurement_problem
from tribopipe.evaluation.wear.uncertainty import budget_lines, input_covariance
from tribopipe.physics.friction_path import FrictionPath
from tribopipe.physics.laws import WearLaw, law_named
from tribopipe.physics.load_course import LoadCourse, effective_distance
from tribopipe.results.evaluation import COVERAGE_FACTOR, FrictionFit
from tribopipe.results.finding import Finding
from tribopipe.results.input_quantities import Input, best_values
from tribopipe.results.run import CorrectedRun, RawRun
from tribopipe.results.wear_fit import NO_FRICTION, BodyWear, Contribution, ConventionCoefficients, FittedValue, WearFit

_SURE = 0.01
"""Probability under the law below which disagreement is worth a word."""


def measurement_fit(
    corrected: CorrectedRun, model: LawName, friction: FrictionFit | None, recipe: Recipe
) -> "MeasurementFit | tuple[str, ...]":
    """Fit k_D to what was measured on the bodies of a run, or report what is missing for it.

    Raises ``FitError`` where the first body shows no wear to fit.
    """
    problem = measurement_problem(corrected.run, model, friction, recipe)
    return MeasurementFit(model, problem) if isinstance(problem, MeasurementProblem) else problem


@dataclass(frozen=True)
class MeasurementFit:
    """k_D of the bodies of a run, from measurements at the end and at interruptions together."""

    model: LawName
    problem: MeasurementProblem

    @property
    def inputs(self) -> Mapping[str, Input]:
        """Everything uncertain that k_D depends on."""
        return self.problem.inputs

    @property
    def friction(self) -> FrictionPath | None:
        """Friction along the test."""
        return self.problem.friction

    @cached_property
    def coefficients(self) -> Column:
        """k_D of both bodies, m²/N, at the best estimates."""
        return self.problem.coefficients()

    def draw(self, rng: Generator, count: int) -> Column:
        """Draw k_D of each body that is fitted, m²/N: (draws, bodies)."""
        values = self.problem.draw(rng, count)
        return self.problem.solve_draws(values, self.coefficients)[:, : self.problem.unknowns]

    def result(self) -> WearFit:
        """Return k_D by first-order propagation, with all that the measurements show."""
        problem, found = self.problem, self.coefficients
        # Where no wear was found there is no logarithm; it is taken where wear would have been noticed.
        at = np.where(found > 0, found, problem.scale)
        bodies, covariance = _propagated(problem, found, at, problem.sensitivities(at))
        p_value = self._p_value()
        return WearFit(
            model=self.model,
            outcome="fitted",
            start=problem.wearing.start(problem.values),
            bodies=bodies,
            correlation=None if problem.one_sided else correlation(covariance),
            measurements=self._fitted_values(),
            p_value=p_value,
            notes=(*problem.limits(found), *_one_sided(problem), *_disagreement(p_value)),
            equivalents=self._equivalents(),
        )

    def _fitted_values(self) -> tuple[FittedValue, ...]:
        modelled = self.problem.modelled(self.coefficients, self.problem.values)
        return tuple(
            FittedValue(
                name=one.name,
                place=one.place,
                measured=one.quantity,
                fitted=Quantity(value=float(value), unit=one.quantity.unit),
            )
            for one, value in zip(self.problem.measurements, modelled, strict=True)
        )

    def _p_value(self) -> float | None:
        from scipy.stats import chi2

        problem, values = self.problem, self.problem.values
        residual = (problem.rows(values) - problem.modelled(self.coefficients, values)) * problem.root_weights
        spare = len(residual) - problem.unknowns
        return float(chi2.sf(residual @ residual, spare)) if spare > 0 else None

    def _equivalents(self) -> tuple[ConventionCoefficients, ...]:
        """Return k_D of the other ways of counting the distance that reach the same wear at the end."""
        problem = self.problem
        turns = problem.effective(problem.values, np.asarray(problem.places[-1]))
        found = problem.wearing.equivalents(problem.values, turns, self.coefficients)
        return tuple(
            ConventionCoefficients(
                distance_per_rotation=convention,
                bodies=dict(zip(problem.bodies, map(wear_coefficient, coefficients), strict=False)),
            )
            for convention, coefficients in found.items()
        )


def measurement_budgets(problem: MeasurementProblem, found: Column) -> list[tuple[Contribution, ...]]:
    """Return for each k_D that is found its uncertainty budget by first-order propagation, the largest part first."""
    return _budgets(problem, problem.sensitivities(found))


def _budgets(
    fit: "MeasurementProblem | VolumeFit", sensitivities: Mapping[str, Column]
) -> list[tuple[Contribution, ...]]:
    each = ({name: float(both[place]) for name, both in sensitivities.items()} for place in range(len(fit.bodies)))
    return [budget_lines(fit.inputs, fit.friction_covariance, mine) for mine in each]


def _propagated(
    fit: "MeasurementProblem | VolumeFit",
    found: Column,
    at: Column,
    sensitivities: Mapping[str, Column],
    least: float = 0.0,
) -> tuple[dict[str, BodyWear], Column]:
    """Return k_D of each body with interval and budget, and the covariance of ln k; sensitivities are those at ``at``.

    A body without wear has no budget, and no interval reaches below ``least``, m²/N.
    """
    slopes = np.array([*sensitivities.values()])
    covariance = slopes.T @ input_covariance(fit.inputs, fit.friction_covariance, [*sensitivities]) @ slopes
    spreads = at[: len(fit.bodies)] * np.sqrt(np.diag(covariance))
    bodies = {
        name: BodyWear(
            wear_coefficient=wear_coefficient(value, spread),
            interval=_first_order_interval(value, spread, least),
            budget=lines if value > 0 else (),
        )
        for name, value, spread, lines in zip(fit.bodies, found, spreads, _budgets(fit, sensitivities), strict=False)
    }
    return bodies, covariance


def _first_order_interval(value: float, spread: float, least: float) -> tuple[Quantity, Quantity]:
    """Return the 95 % interval by first-order propagation: measurements are normal, and k about in proportion."""
    half = COVERAGE_FACTOR * spread
    return wear_coefficient(max(least, value - half)), wear_coefficient(value + half)


def correlation(covariance: Column) -> float | None:
    """Return that of both k; None if one of them is exact."""
    product = math.sqrt(covariance[0, 0] * covariance[1, 1])
    return float(covariance[0, 1]) / product if product > 0 else None


def _one_sided(problem: MeasurementProblem) -> tuple[str, ...]:
    if not problem.one_sided:
        return ()
    unmeasured = spoken(problem.contact.fitted_bodies[-1])
    return (f"the {unmeasured} was not measured and is assumed to be unworn, as in the one-sided model",)


def _disagreement(p_value: float | None) -> tuple[str, ...]:
    if p_value is None or p_value > _SURE:
        return ()
    return (
        f"the measurements disagree with the law by more than their uncertainties (probability {p_value:.1g}): the "
        "uncertainties are too small, or the law does not apply",
    )


_BY_VOLUME = (
    "k_D is calculated from the wear volume alone, as V/(F_N·S): it is the mean over the test, and does not show "
    "whether the law holds during the test"
)


@dataclass(frozen=True)
class VolumeFit:
    """k_D of each body that has lost a measured volume."""

    model: LawName
    law: WearLaw
    slid: float
    """Sliding distance at the end, m."""
    bodies: tuple[str, ...]
    inputs: Mapping[str, Input]
    friction: FrictionPath | None = None
    friction_covariance: FrictionCovariance = None
    """Covariance of (A, b, c), if friction is from Eq. 7."""
    load: LoadCourse | None = None
    """Load along the test; None where it counts as constant."""
    limits: tuple[str, ...] = ()
    """Assumptions about the contact."""
    findings: tuple[Finding, ...] = ()
    contacts: Mapping[str, int] = field(default_factory=dict)
    """In how many contacts each body wears; in one where none is named."""

    @cached_property
    def values(self) -> dict[str, float]:
        """Best estimates of the inputs."""
        return best_values(self.inputs)

    def volume(self, body: str, values: Values) -> Numbers:
        """Return what a body has lost in all its contacts, m³."""
        shared = values.get(scale_of(body), 1.0) * values.get(unseen_groove_of(body), 1.0)
        return values[volume_of(body)] * shared

    def work(self, body: str, values: Values, places: Column) -> Column:
        """Return F_N·S of all contacts of a body at sliding distances, N·m.

        Its shape is (places,), or (draws, places) of columns of values.
        """
        return np.asarray(self.contacts.get(body, 1) * values["normal_load"] * self.effective(values, places))

    def effective(self, values: Values, places: Column) -> Column:
        """Return S, m, in which Archard's law would wear as much as this one until sliding distances, m."""
        friction = friction_along(self.friction, values, self.values)
        effective = effective_distance(self.law.at(values), places, friction, self.load)
        return np.asarray(effective * distance_scale(values, self.values))

    def of(self, *bodies: str) -> "VolumeFit | None":
        """Return the fit of some of the bodies only; None if it has none of them."""
        kept = tuple(body for body in self.bodies if body in bodies)
        left = {name(body) for body in self.bodies if body not in kept for name in _OF_A_BODY}
        inputs = {name: given for name, given in self.inputs.items() if name not in left}
        return replace(self, bodies=kept, inputs=inputs) if kept else None

    def coefficients(self, values: Values) -> Column:
        """Return k_D, m²/N: (bodies,), or (draws, bodies) of columns of values."""
        end = np.asarray([self.slid])
        return np.concatenate(
            [self.volume(body, values) / self.work(body, values, end) for body in self.bodies], axis=-1
        )

    def draw(self, rng: Generator, count: int) -> Column:
        """Draw k_D of each body, m²/N: (draws, bodies)."""
        return self.coefficients(draw_values(self.inputs, self.friction_covariance, rng, count))

    def result(self) -> WearFit:
        """Return k_D by first-order propagation."""
        found = self.coefficients(self.values)
        bodies, covariance = _propagated(self, found, self.scale, self.sensitivities(), least=-math.inf)
        return WearFit(
            model=self.model,
            engine="volume",
            outcome="fitted",
            bodies=bodies,
            correlation=correlation(covariance) if len(bodies) > 1 else None,
            basis="measurement",
            notes=(*self.limits, _BY_VOLUME),
            findings=self.findings,
        )

    def budgets(self) -> list[tuple[Contribution, ...]]:
        """Return for each k_D its uncertainty budget by first-order propagation, the largest part first."""
        return _budgets(self, self.sensitivities())

    def sensitivities(self) -> dict[str, Column]:
        """Return ∂ln k/∂x of each body for each input."""
        return {name: self._sensitivity(name) for name in self.inputs}

    @cached_property
    def scale(self) -> Column:
        """Size of each k_D, m²/N: without wear, of that which would have been noticed."""
        found, end = np.abs(self.coefficients(self.values)), np.asarray([self.slid])
        noticed = [self.inputs[volume_of(body)].spread / self.work(body, self.values, end)[0] for body in self.bodies]
        return np.where(found > 0, found, noticed)

    def _sensitivity(self, name: str) -> Column:
        """Return ∂ln k/∂x of each body, by central differences over the standard uncertainty."""
        spread = self.inputs[name].spread
        if not spread:
            return np.zeros(len(self.bodies))
        low, high = (self.coefficients({**self.values, name: self.values[name] + sign * spread}) for sign in (-1, 1))
        return np.asarray((high - low) / (2 * spread * self.scale))


def volume_fit(
    run: RawRun,
    model: LawName,
    friction: FrictionFit | None,
    recipe: Recipe,
    signal: SignalDepths | None = None,
) -> VolumeFit | tuple[str, ...] | None:
    """Pose k_D of the bodies of a pin's run whose lost volume was measured.

    None where no volume was, or without a sliding distance. ``signal`` is what only the depth signal shows of their
    depths. Reports what else the law needs and the run does not have. Raises ``FitError`` for a mass without density,
    and for profiles of which nothing can be taken.
    """
    slid, lost = run.columns.get("sliding_distance"), _lost(run, recipe, signal)
    if slid is None or not np.any(slid > 0) or not lost:
        return None
    law, given = law_named(model), law_inputs(law_named(model), recipe)
    missing = tuple(spoken(name) for name in law.parameters() if law.input_of(name) not in given)
    known = law_friction(run, model, friction, recipe.wear.friction)
    if missing or known is None:
        return missing or (NO_FRICTION,)
    inputs = {volume_of(body): Input(volume, way.source) for body, (way, volume) in lost.items()}
    inputs |= {"normal_load": load_input(run, recipe), **known.inputs, **given}
    if told := told_by(run, recipe.uncertainty):
        inputs[told.name] = told.given
    end = float(np.nanmax(slid))
    law, limits, load = law_as_given(model, recipe), run.manifest.described.limits, load_course(run)
    findings = tuple(unseen_groove(run, way.unseen_groove, recipe) for way, _ in lost.values() if way.unseen_groove)
    contact = run.manifest.described
    contacts = {contact.body_name(role): contact.contacts_of(role) for role in contact.roles}
    return VolumeFit(
        model, law, end, tuple(lost), inputs, known.path, known.covariance, load, limits, findings, contacts
    )


def _lost(run: RawRun, recipe: Recipe, signal: SignalDepths | None) -> dict[str, tuple[BodyLoss, Quantity]]:
    """Return what each body has lost, m³, and the way that gives it most certainly.

    It is below zero if a body has gained.
    """
    contact, found = run.manifest.described, {}
    for role, ways in worn_bodies(run, recipe.uncertainty, signal=signal or SignalDepths()).bodies.items():
        best, body = surest(ways, "volume"), contact.body_name(role)
        if best is not None and best.volume is not None and _is_known(best.volume):
            found[body] = best, best.volume
    return found


def _is_known(volume: Quantity) -> bool:
    """Return whether a volume is more than the statement that there was no wear."""
    return bool(volume.value or volume.standard_uncertainty)


def volume_of(body: str) -> str:
    """Return the name of the input that is the volume a body has lost."""
    return f"{body}_wear_volume"


def scale_of(body: str) -> str:
    """Return the name of the input by which that volume is wrong in all runs of bodies that are made alike."""
    return f"{body}_volume_scale"


def unseen_groove_of(body: str) -> str:
    """Return the name of the input by which that volume is wrong where the groove next to it was not measured."""
    return f"{body}_unseen_groove"


_OF_A_BODY = (volume_of, scale_of, unseen_groove_of)
"""Names of the inputs that belong to one body."""

"""k_D of bodies by the volumes that they have lost: k_D = V/(F_N·S), whatever their shape.

Archard's law in its integral form (J. F. Archard, J. Appl. Phys. 24 (1953) 981) needs no depth signal and no model of
the contact, and holds for either body. S is the law's effective sliding distance, s itself by Archard's law. What one
volume cannot show is whether the law holds on the way.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.random import Generator

from tribopipe.base.arrays import Column, Values
from tribopipe.contacts.inputs import Input, best_values
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.quantity import scaled, wear_coefficient
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.evaluation.measurements.body_wear import surest
from tribopipe.evaluation.measurements.disc_track import told_by
from tribopipe.evaluation.measurements.pin_on_disc import pin_on_disc_wear
from tribopipe.evaluation.wear.budget import budget_lines, input_covariance
from tribopipe.evaluation.wear.given_parameters import law_as_given
from tribopipe.evaluation.wear.inputs import (
    distance_scale,
    draw_values,
    friction_along,
    law_friction,
    law_inputs,
    load_input,
)
from tribopipe.evaluation.wear.measurement_fit import correlation, first_order_interval
from tribopipe.physics.friction_path import FrictionPath
from tribopipe.physics.laws import WearLaw, law_named
from tribopipe.results.evaluation import FrictionFit
from tribopipe.results.run import RawRun
from tribopipe.results.wear_fit import NO_FRICTION, BodyWear, WearFit

_BY_VOLUME = (
    "k_D from the wear volume alone, V/(F_N·S): it is the mean over the test, and does not show whether the law holds "
    "during the test"
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
    friction_covariance: tuple[tuple[float, ...], ...] | None = None
    """Of (A, b, c), where Eq. 7 is the friction."""
    limits: tuple[str, ...] = ()
    """What is assumed of the contact."""

    @cached_property
    def values(self) -> dict[str, float]:
        """Best estimates of the inputs."""
        return best_values(self.inputs)

    def of(self, *bodies: str) -> "VolumeFit | None":
        """Return the fit of some of the bodies only; none where it has none of them."""
        kept = tuple(body for body in self.bodies if body in bodies)
        left = {_volume_of(body) for body in self.bodies if body not in kept}
        inputs = {name: given for name, given in self.inputs.items() if name not in left}
        return replace(self, bodies=kept, inputs=inputs) if kept else None

    def coefficients(self, values: Values) -> Column:
        """Return k_D, m²/N: (bodies,), or (draws, bodies) of columns of values."""
        friction = friction_along(self.friction, values, self.values)
        effective = self.law.at(values).effective_distance(np.asarray([self.slid]), friction)
        work = values["normal_load"] * effective * distance_scale(values, self.values)
        return np.concatenate([values[_volume_of(body)] / work for body in self.bodies], axis=-1)

    def draw(self, rng: Generator, count: int) -> Column:
        """Draw k_D of each body, m²/N: (draws, bodies)."""
        drawn = draw_values(self.inputs, self.friction_covariance, rng, count)
        return np.maximum(self.coefficients(drawn), 0.0)

    def result(self) -> WearFit:
        """Return k_D by first-order propagation."""
        found = self.coefficients(self.values)
        sensitivities = {name: self._sensitivity(name, found) for name in self.inputs}
        names = [*self.inputs]
        slopes = np.array([sensitivities[name] for name in names])
        covariance = slopes.T @ input_covariance(self.inputs, self.friction_covariance, names) @ slopes
        spreads = found * np.sqrt(np.diag(covariance))
        bodies = {}
        for place, body in enumerate(self.bodies):
            mine = {name: float(both[place]) for name, both in sensitivities.items()}
            bodies[body] = BodyWear(
                wear_coefficient=wear_coefficient(found[place], spreads[place]),
                interval=first_order_interval(found[place], spreads[place]),
                budget=budget_lines(self.inputs, self.friction_covariance, mine),
            )
        return WearFit(
            model=self.model,
            engine="volume",
            outcome="fitted",
            bodies=bodies,
            correlation=correlation(covariance) if len(bodies) > 1 else None,
            basis="measurement",
            notes=(*self.limits, _BY_VOLUME),
        )

    def _sensitivity(self, name: str, found: Column) -> Column:
        """Return ∂ln k/∂x of each body, by central differences over the standard uncertainty."""
        spread = self.inputs[name].spread
        if not spread:
            return np.zeros(len(self.bodies))
        low, high = (self.coefficients({**self.values, name: self.values[name] + sign * spread}) for sign in (-1, 1))
        return np.asarray((high - low) / (2 * spread * found))


def volume_fit(
    run: RawRun, model: LawName, friction: FrictionFit | None, recipe: Recipe
) -> VolumeFit | tuple[str, ...] | None:
    """Pose k_D of the bodies of a pin's run whose lost volume was measured.

    None where no volume was, or without a sliding distance. Reports what else the law needs and the run does not have.
    Raises ``FitError`` for a mass without density, and for profiles of which nothing can be taken.
    """
    slid, lost = run.columns.get("sliding_distance"), _lost(run, recipe)
    if slid is None or not np.any(slid > 0) or not lost:
        return None
    law, given = law_named(model), law_inputs(law_named(model), recipe)
    missing = tuple(spoken(name) for name in law.parameters() if law.input_of(name) not in given)
    known = law_friction(run, model, friction, recipe.wear.friction)
    if missing or known is None:
        return missing or (NO_FRICTION,)
    inputs = {_volume_of(body): volume for body, volume in lost.items()}
    inputs |= {"normal_load": load_input(run, recipe), **known.inputs, **given}
    if told := told_by(run, recipe.uncertainty):
        inputs[told.name] = Input(told.quantity, told.source)
    end = float(np.nanmax(slid))
    law, limits = law_as_given(model, recipe), run.manifest.described.limits
    return VolumeFit(model, law, end, tuple(lost), inputs, known.path, known.covariance, limits)


def _lost(run: RawRun, recipe: Recipe) -> dict[str, Input]:
    """Return what each body has lost in one contact, m³, by what gives it most certainly; none of one that has not.

    Over a track of unknown length a counterbody wears by an unknown depth, and nothing could be predicted of it.
    """
    contact, found = run.manifest.sliding_pin, {}
    for role, ways in pin_on_disc_wear(run, recipe.uncertainty).bodies.items():
        best, body = surest(ways, "volume"), contact.body_name(role)
        placed = body in contact.fitted_bodies or run.manifest.path is not None
        if placed and best is not None and best.volume is not None and best.volume.value > 0:
            found[body] = Input(scaled(best.volume, 1 / contact.contacts_of(role)), best.source)
    return found


def _volume_of(body: str) -> str:
    return f"{body}_wear_volume"

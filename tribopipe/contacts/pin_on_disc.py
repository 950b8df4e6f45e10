"""A pin on a disc: from what run.toml states of it to the course of its wear."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tribopipe.base.arrays import Column, Values
from tribopipe.base.errors import ContactError
from tribopipe.contacts.inputs import Input, relative_input
from tribopipe.contacts.wear import State, Steps
from tribopipe.documents.contact import SlidingPin
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe
from tribopipe.physics.conventions import WearEngine
from tribopipe.physics.hertz import contact_modulus
from tribopipe.physics.local.sphere import LocalSphere
from tribopipe.physics.pin_on_disc import BlockOnCylinder, FlatPin, PinContact, RigidSphere, SphericalPin, WornState

_USUAL_STEPS = 50_000


@dataclass(frozen=True)
class PinWear:
    """Wear of a pin that slides, by an engine."""

    contact: SlidingPin
    engine: WearEngine = "giwm"

    coefficients: ClassVar[tuple[str, ...]] = ("wear_coefficient",)
    displacement: ClassVar[str] = "wear_depth"
    outcomes: ClassVar[Mapping[str, str]] = {"wear_depth": "m"}
    uncertain: ClassVar[tuple[str, ...]] = ("wear_depth",)
    most_places: ClassVar[int | None] = None
    slid: ClassVar[float] = 1.0

    @property
    def bodies(self) -> dict[str, dict[str, str]]:
        """Name of the wear depth of the pin in a state."""
        return {self.contact.fitted_bodies[0]: {"wear_depth": "wear_depth"}}

    @property
    def conditions(self) -> dict[str, Quantity]:
        """The radius of the tip."""
        return {"pin_radius": self.contact.pin.radius}

    def inputs(self, normal_load: Quantity, recipe: Recipe) -> dict[str, Input]:
        """Return load, tip radius and moduli with the uncertainties stated, or else the recipe's defaults."""
        defaults, contact = recipe.uncertainty, self.contact
        return {
            "normal_load": relative_input(contact.pressed_by(normal_load), defaults.normal_load, above_zero=True),
            "pin_radius": relative_input(contact.equivalent_pin.radius, defaults.pin_radius, above_zero=True),
            "pin_modulus": relative_input(contact.pin.youngs_modulus, defaults.youngs_modulus, above_zero=True),
            "disc_modulus": relative_input(
                contact.counterbody.youngs_modulus, defaults.youngs_modulus, above_zero=True
            ),
        }

    def pin(self, values: Values) -> PinContact:
        """Return the depth of the pin against worn volume."""
        return pin_curve(self.contact, values, self.engine)

    def worn(self, values: Values, progress: Column) -> State:
        """Return the pin after an effective sliding distance, m. Raises ``ContactError`` past the tip."""
        volume = values["wear_coefficient"] * values["normal_load"] * progress
        return _state(values, self.pin(values).worn(volume))

    def progress_to(self, values: Values, depth: float) -> Column:
        """Return the effective sliding distance, m, after which the pin has worn to a depth, m; infinite without wear.

        Raises ``ContactError`` past the tip.
        """
        rate = np.asarray(values["wear_coefficient"]) * values["normal_load"]
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(rate > 0, self.pin(values).volume(depth) / rate, np.inf)

    def local_amount(self, values: Values, progress: Column) -> Column:
        """Return k_D·S, m³/N."""
        return np.asarray(values["wear_coefficient"] * progress)

    def usual_steps(self, _: float, /) -> int:
        """Return the number of steps of the published scheme."""
        return _USUAL_STEPS

    def published(self, values: Values, steps: Steps, places: Column) -> State:
        """Return the pin at sliding distances by the paper's Euler steps: the geometry is that of the exact scheme.

        Each step takes the law's factor at its start (Fig. 2).
        """
        pin = self.pin(values)
        volumes = values["wear_coefficient"] * values["normal_load"] * steps.factor[:-1] * np.diff(steps.ends)
        depth = np.interp(places, steps.ends, pin.published_depth(volumes))
        return {**_state(values, pin.worn(pin.volume(depth))), "wear_depth": depth}

    def start(self, _: Values, /) -> None:
        """Return nothing: the published scheme starts without wear."""

    def notes(self, _: Values, __: State | None, /) -> tuple[str, ...]:
        """Return what the contact assumes; a tip that is worn away is refused."""
        return self.contact.limits


def _state(values: Values, worn: WornState) -> State:
    load, coefficient = values["normal_load"], values["wear_coefficient"]
    return {
        "wear_depth": worn.depth,
        "half_width": worn.half_width,
        "half_length": worn.radius,
        "pressure": np.asarray(load / worn.even_area),
        "rate": np.asarray(coefficient * load / worn.area),
    }


def pin_contact(contact: SlidingPin, values: Values) -> PinContact:
    """Build the pin's master curve from ``normal_load``, ``pin_radius``, ``pin_modulus`` and ``disc_modulus``.

    The flat of a truncated sphere is taken as run.toml states it: it is not among what is uncertain.
    """
    if contact.pin.shape == "flat":
        return FlatPin(values["pin_radius"])
    if contact.pin.line:
        return BlockOnCylinder(values["pin_radius"], contact.pin.line)
    modulus = contact_modulus(
        pin_modulus=values["pin_modulus"],
        pin_ratio=contact.pin.poisson_ratio.value,
        disc_modulus=values["disc_modulus"],
        disc_ratio=contact.counterbody.poisson_ratio.value,
    )
    return SphericalPin(
        normal_load=values["normal_load"],
        radius=values["pin_radius"],
        modulus=modulus,
        flat_radius=0.0 if contact.pin.flat_radius is None else contact.pin.flat_radius.value,
    )


def no_local_wear_of_a_block(contact: SlidingPin) -> ContactError:
    """Return the refusal of local wear of a line contact."""
    return ContactError(
        f"local wear: found {contact.title}, which touch in a line; expected a pin or ball; fit and predict it by "
        "volume"
    )


def pin_curve(contact: SlidingPin, values: Values, engine: WearEngine) -> PinContact:
    """Build the pin's curve by an engine, from the values that ``pin_contact`` takes.

    Raises ``ContactError`` for local wear of a truncated sphere, whose flat has an edge that Hertz's contact does not.
    """
    pin = pin_contact(contact, values)
    if engine == "local" and contact.pin.line:
        raise no_local_wear_of_a_block(contact)
    if engine == "giwm" or not isinstance(pin, SphericalPin):
        return pin
    if engine == "volume":
        return RigidSphere(pin.radius, pin.flat_radius)
    if contact.pin.flat_radius is not None:
        raise ContactError(
            f"local wear: found a truncated sphere with a flat of {contact.pin.flat_radius.shown('um')}; expected a "
            "whole sphere or a flat pin; fit and predict it with the GIWM, --engine giwm"
        )
    return LocalSphere(pin)

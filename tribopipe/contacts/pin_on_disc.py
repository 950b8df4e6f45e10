"""A pin alone that wears on a counterbody: from what run.toml states to the course of wear, by an engine.

The master curves are those of tribopipe.physics.pin_on_disc.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tribopipe.base.arrays import Column, Values
from tribopipe.base.errors import ContactError
from tribopipe.base.units import show
from tribopipe.contacts.wear import State, Steps
from tribopipe.documents.contact import SlidingPin
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe
from tribopipe.physics.calculation_methods import WearEngine
from tribopipe.physics.elastic_start import elastic_start
from tribopipe.physics.hertz import hertz_radius
from tribopipe.physics.local.sphere import LocalSphere
from tribopipe.physics.pin_on_disc import BlockOnCylinder, FlatPin, PinContact, RigidSphere, SphericalPin, WornState
from tribopipe.results.input_quantities import Input, relative_input

_ELASTIC = 0.02
"""Share by which a wear depth without elastic deformation may be too large."""

_USUAL_STEPS = 50_000


@dataclass(frozen=True)
class PinWear:
    """Wear of a pin that slides, by an engine."""

    contact: SlidingPin
    engine: WearEngine = "giwm"
    stroke: Quantity | None = None
    """Stroke, m, of a pin that slides there and back."""

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
        """The radius that is worn flat, by the name of its body, such as "ring_radius" of a block on a ring."""
        name, radius = self.contact.worn_radius
        return {self.contact.worded(name).replace(" ", "_"): radius}

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

    def notes(self, values: Values, last: State | None) -> tuple[str, ...]:
        """Return what the contact assumes, a stroke within the scar, and a scar too small for a rigid one.

        A tip that is worn away is refused.
        """
        if last is None:
            return self.contact.limits
        found = (*self.contact.limits, *fretting(self.stroke, last))
        return found if self.engine != "volume" else (*found, *neglected_deformation(self.contact, values, last))


def fretting(stroke: Quantity | None, last: State) -> Iterator[str]:
    """Warn of a stroke no longer than the contact, of which the equations for sliding hold for volumes alone."""
    length = 2 * float(last["half_length"])
    if stroke is not None and stroke.value <= length:
        yield (
            f"warning: found a stroke of {stroke.shown('mm')}, not longer than the contact of "
            f"{show(float(f'{length:.3g}'), None, 'm', 'mm')}; expected a longer stroke: at this stroke, parts of both "
            "bodies never leave the contact (fretting); do not use the wear depths; the wear volumes, k_D·F_N·s, "
            "remain valid"
        )


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
    return SphericalPin(
        normal_load=values["normal_load"],
        radius=values["pin_radius"],
        modulus=contact.reduced_modulus(values["pin_modulus"], values["disc_modulus"]),
        flat_radius=contact.pin.flat,
    )


def no_local_wear_of_a_block(contact: SlidingPin) -> ContactError:
    """Return the refusal of local wear of a line contact."""
    return ContactError(
        f"local wear: found {contact.title}, a line contact; expected a pin or ball; use `tribopipe predict --engine "
        "volume`"
    )


def no_local_wear_of_a_flat_tip(contact: SlidingPin, instead: WearEngine) -> ContactError:
    """Return the refusal of local wear of a truncated sphere, whose flat has an edge."""
    return ContactError(
        f"local wear: found a truncated sphere with a flat of {show(contact.flat_end, None, 'm', 'um')}; expected a "
        f"full sphere or a flat pin; use --engine {instead}"
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
        raise no_local_wear_of_a_flat_tip(contact, "giwm")
    return LocalSphere(pin)


def neglected_deformation(contact: SlidingPin, values: Values, last: State) -> Iterator[str]:
    """Warn of wear depths of a rigid ball and its track that elastic deformation changes."""
    if contact.pin.line or contact.flat_end:
        return
    load, radius = values["normal_load"], values["pin_radius"]
    start = float(hertz_radius(normal_load=load, pin_radius=radius, modulus=contact.reduced_modulus()))
    width, length = float(last["half_width"]), float(last["half_length"])
    true = elastic_start(half_width=width, half_length=length, hertz_radius=start)
    depths = last["wear_depth"], last.get("track_depth", 0.0)
    both = zip(contact.body_names, (true.pin, true.groove), depths, strict=True)
    worn = {name: 1 / float(share) - 1 for name, share, depth in both if depth > 0}
    if not any(share > _ELASTIC for share in worn.values()):
        return
    by = " and ".join(f"{100 * share:.0f} % for the {name}" for name, share in worn.items())
    yield (
        f"warning: found a contact {show(2 * width, None, 'm', 'um')} wide and {show(2 * length, None, 'm', 'um')} "
        f"long after wear, compared with {show(2 * start, None, 'm', 'um')} before wear; expected a larger scar: "
        f"elastic deformation is neglected, so the wear depth is overestimated by about {by}; use --engine local, or "
        "the wear volumes, which remain valid"
    )

"""Two discs: from what run.toml states of them to the course of their wear."""

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields
from typing import ClassVar

import numpy as np

from tribopipe.base.arrays import Column, Values
from tribopipe.base.errors import ContactError
from tribopipe.base.units import show
from tribopipe.contacts.wear import Noticed, Reached, Row, State, Steps
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe
from tribopipe.documents.twin_disc import TwinDisc
from tribopipe.physics.calculation_methods import DistanceConvention
from tribopipe.physics.hertz import HARDNESS_UNIT, hertz_ellipse
from tribopipe.physics.twin_disc import DiscPair, DiscWear, published_wear
from tribopipe.results.input_quantities import Input, best_values, relative_input
from tribopipe.results.wear_fit import HertzStart
from tribopipe.results.wear_prediction import OUTCOMES

_CONVENTIONS: tuple[DistanceConvention, ...] = ("full-slip", "contact-width", "line-load", "volume-conserving")
_SAME = 1e-12
"""Relative difference of volumes that are the same."""
_MOST_PLACES = 600
_FLAT_CROWN = 0.5
"""Half width of the worn flat over the crown radius, beyond which the model was never tested."""
_SLIP_LOST = 0.25
"""Share of the slip, by which it may change before it is worth a word."""


@dataclass(frozen=True)
class TwinDiscWear:
    """Wear of two discs at a nominal slip, by rotations of the crowned one."""

    contact: TwinDisc
    slip: Quantity
    distance: DistanceConvention = "full-slip"

    coefficients: ClassVar[tuple[str, ...]] = ("curved_coefficient", "flat_coefficient")
    bodies: ClassVar[Mapping[str, Mapping[str, str]]] = {
        "curved_disc": {"wear_depth": "curved_depth", "wear_volume": "curved_volume"},
        "flat_disc": {"wear_depth": "flat_depth", "wear_volume": "flat_volume"},
    }
    displacement: ClassVar[str] = "depth"
    outcomes: ClassVar[Mapping[str, str]] = {str(name): unit for name, unit in OUTCOMES.items()}
    uncertain: ClassVar[tuple[str, ...]] = (*OUTCOMES, "slip")
    most_places: ClassVar[int | None] = _MOST_PLACES
    least: ClassVar[Mapping[str, float]] = {"wear_volume": 1e-20, "wear_depth": 1e-12, "track_width": 1e-9}

    @property
    def slid(self) -> float:
        """Slip distance in one rotation of the unworn crowned disc, m."""
        return 2 * math.pi * self.contact.curved_disc.rolling_radius.value * abs(self.slip.value)

    @property
    def conditions(self) -> dict[str, Quantity]:
        """The slip."""
        return {"slip": self.slip}

    def inputs(self, normal_load: Quantity, recipe: Recipe) -> dict[str, Input]:
        """Return load, radii, moduli and slip with the uncertainties stated, or else the recipe's defaults."""
        curved, flat, defaults = self.contact.curved_disc, self.contact.flat_disc, recipe.uncertainty
        return {
            "normal_load": relative_input(normal_load, defaults.normal_load, above_zero=True),
            "crown_radius": relative_input(curved.crown_radius, defaults.crown_radius, above_zero=True),
            "curved_radius": relative_input(curved.rolling_radius, defaults.rolling_radius, above_zero=True),
            "flat_radius": relative_input(flat.rolling_radius, defaults.rolling_radius, above_zero=True),
            "curved_modulus": relative_input(curved.youngs_modulus, defaults.youngs_modulus, above_zero=True),
            "flat_modulus": relative_input(flat.youngs_modulus, defaults.youngs_modulus, above_zero=True),
            "slip": relative_input(self.slip, defaults.slip, above_zero=self.slip.value != 0),
        }

    def pair(self, values: Values) -> DiscPair:
        """Return the pair of discs for values of the inputs."""
        return disc_pair(self.contact, values, self.distance)

    def worn(self, values: Values, progress: Column) -> State:
        """Return the discs after effective rotations. Raises ``ContactError`` past the crown."""
        return _state(self.pair(values).worn(progress, *_coefficients(values)))

    def course(self, values: Values) -> "TwinDiscCourse":
        """Return the course of wear, by how much more of the crown is cut off than at the start."""
        return TwinDiscCourse(self.pair(values))

    def progress_to(self, values: Values, depth: float) -> Column:
        """Return the effective rotations after which the crowned disc has worn by a depth, m; infinite if never.

        Raises ``ContactError`` past the crown.
        """
        return self.pair(values).rotations(depth, *_coefficients(values))

    def local_amount(self, values: Values, progress: Column) -> Column:
        """Return (k₁ + k₂·r₁/r₂)·N·|slip|, m²/N: both discs wear where they touch, so that their sum wears as one."""
        first, second = _coefficients(values)
        ratio = np.asarray(values["curved_radius"]) / values["flat_radius"]
        return np.asarray((first + second * ratio) * (progress * np.abs(values["slip"])))

    def measured(self, state: State, rows: Sequence[Row]) -> Column:
        """Return volumes, depths and track widths, SI: (..., rows)."""
        return np.stack([self._measured(state, row)[..., row.place] for row in rows], axis=-1)

    def _measured(self, state: State, row: Row) -> Column:
        if row.what == "track_width":
            return 2 * state["half_width"]
        return state[self.bodies[row.body][row.what]]

    def slopes(self, values: Values, state: State, progress: Column, rows: Sequence[Row]) -> Column:
        """Return the slopes of measurements against ln k₁ and ln k₂, SI: (..., rows, 2).

        They leave out that radii and slip change with wear, by parts in a thousand.
        """
        rate, half_width = state["curved_rate"] + state["flat_rate"], state["half_width"]
        recession, part = rate * progress, state["curved_rate"] / rate
        widening = np.sqrt(np.square(values["crown_radius"]) - half_width**2) / half_width
        slopes = []
        for row in rows:
            curved = row.body == "curved_disc"
            mine = part if curved else 1 - part
            if row.what == "track_width":
                grown, shift = 2 * recession * widening, np.zeros_like(part)
            else:
                radius = values["curved_radius" if curved else "flat_radius"]
                across = 4 * np.pi * radius * half_width if row.what == "wear_volume" else 1.0
                # A disc's share w of the wear goes with its own ln k as w(1 − w), all of it with the recession.
                grown, shift = mine * across * recession, self._measured(state, row) * (1 - mine)
            towards = (shift, -shift) if curved else (-shift, shift)
            both = [grown * share + part_of for share, part_of in zip((part, 1 - part), towards, strict=True)]
            slopes.append(np.stack(both, axis=-1)[..., row.place, :])
        return np.stack(slopes, axis=-2)

    def guess(self, values: Values, last: Mapping[str, Noticed]) -> Column:
        """Return k₁ and k₂ of about the right size, m²/N, also of a disc on which no wear was found.

        As if the last thing measured on the crowned disc were all its wear.
        """
        discs, curved, flat = self.pair(values), last["curved_disc"], last.get("flat_disc")
        depth = {
            "wear_depth": lambda lost: lost,
            "wear_volume": lambda lost: discs.depth_of_area(lost / (2 * np.pi * np.asarray(values["curved_radius"]))),
            "track_width": discs.depth_of_width,
        }[curved.what](curved.value)
        depth = max(float(depth), self.least["wear_depth"])
        reached = float(discs.rotations(depth, 1.0))
        if not np.isfinite(reached):  # as if slip did not end before
            reached = float(disc_pair(self.contact, values, "contact-width").rotations(depth, 1.0))
        first = reached / curved.progress
        ratio = flat.value / curved.value if flat is not None and flat.what == curved.what else 0.5
        return np.array([first, first * max(ratio, 1e-6)])

    def equivalents(
        self, values: Values, progress: Column, coefficients: Column
    ) -> Mapping[DistanceConvention, tuple[float, ...]]:
        """Return k₁ and k₂, m²/N, of the other conventions that reach the same volumes, or depth."""
        worn, found = self.pair(values).worn(progress, *coefficients), {}
        for convention in _CONVENTIONS:
            if convention != self.distance:
                # That way of counting may lose the slip before.
                with suppress(ContactError):
                    found[convention] = self._equivalent(values, convention, worn, progress)
        return found

    def _equivalent(
        self, values: Values, convention: DistanceConvention, worn: DiscWear, turns: Column
    ) -> tuple[float, float]:
        """Return k₁ and k₂ by which a convention reaches two volumes: by fixed point, since V grows about as k."""
        discs, curved, flat = (
            disc_pair(self.contact, values, convention),
            float(worn.curved_volume),
            float(worn.flat_volume),
        )
        total = float(discs.depth_of_area(curved / (2 * np.pi * float(values["curved_radius"]))))
        first = float(discs.rotations(total, 1.0)) / float(turns)
        second = first * flat / curved
        for _ in range(100):
            reached = discs.worn(turns, first, second)
            ratios = (curved / float(reached.curved_volume), flat / float(reached.flat_volume) if flat else 1.0)
            first, second = first * ratios[0], second * ratios[1]
            if max(abs(ratio - 1) for ratio in ratios) < _SAME:
                break
        return first, second

    def usual_steps(self, end: float) -> int:
        """Return one step per rotation, as in the paper."""
        return max(1, math.ceil(end))

    def published(self, values: Values, steps: Steps, places: Column) -> State:
        """Return the discs after rotations by the paper's Euler steps (Fig. 8 and A)."""
        worn = published_wear(self.pair(values), np.diff(steps.effective), *map(float, _coefficients(values)))
        return {name: np.interp(places, steps.ends, column) for name, column in _state(worn).items()}

    def start(self, values: Values) -> HertzStart:
        """Return Hertz's contact of the unworn discs, for single values of the inputs."""
        # The way of counting distance plays no part before anything is slid.
        load, crown, curved, flat, modulus, _ = (float(x) for x in disc_pair(self.contact, values, "full-slip").inputs)
        ellipse = hertz_ellipse(
            normal_load=load, radius_x=crown, radius_z=curved * flat / (curved + flat), modulus=modulus
        )
        return HertzStart(
            half_width=Quantity(value=ellipse.half_width, unit="m"),
            half_length=Quantity(value=ellipse.half_length, unit="m"),
            peak_pressure=Quantity(value=ellipse.peak_pressure, unit="Pa"),
        )

    def notes(self, values: Values, last: State | None) -> tuple[str, ...]:
        """Report where the discs leave what the model describes."""
        return () if last is None else tuple(self._notes(values, float(last["half_width"]), float(last["slip"])))

    def _notes(self, values: Values, half_width: float, slip_of_worn: float) -> Iterator[str]:
        contact, start, slipping = self.contact, self.start(values), float(values["slip"])
        crown, width = contact.curved_disc.crown_radius, 2 * half_width
        hardness = [body.vickers_hardness for body in contact.bodies.values() if body.vickers_hardness is not None]
        if hardness and start.peak_pressure.value > min(hardness) * HARDNESS_UNIT:
            softer = Quantity(value=min(hardness) * HARDNESS_UNIT, unit="Pa")
            yield (
                f"extrapolation: the Hertzian pressure of {start.peak_pressure.shown('GPa')} at the start exceeds the "
                f"hardness of the softer disc, {softer.shown('GPa')}: the material yields before it wears"
            )
        if half_width > _FLAT_CROWN * crown.value:
            yield (
                f"extrapolation: the worn flat is {show(width, None, 'm', 'mm')} wide, more than the crown radius of "
                f"{crown.shown('mm')}: the model, which assumes flat worn surfaces, has not been tested in this range"
            )
        widths = [disc.width.value for disc in (contact.curved_disc, contact.flat_disc) if disc.width is not None]
        if widths and width > min(widths):
            yield (
                f"extrapolation: the worn flat would be {show(width, None, 'm', 'mm')} wide, wider than the disc "
                f"({show(min(widths), None, 'm', 'mm')}): the contact cannot widen further, and the model no longer "
                "applies"
            )
        if abs(slip_of_worn - slipping) > _SLIP_LOST * abs(slipping):
            yield (
                f"wear changes the slip from {100 * slipping:.2f} % to {100 * slip_of_worn:.2f} % at constant "
                f"rotational speeds"
            )


@dataclass(frozen=True)
class TwinDiscCourse:
    """What two discs go through, by the height by which more of the crown is cut off than at the start, m."""

    discs: DiscPair

    def growth(self, progress: Column, *coefficients: Column) -> Column:
        """Return that height after effective rotations. Raises ``ContactError`` past the crown."""
        return self.discs.growth(progress, *coefficients)

    def at(self, growth: Column, *coefficients: Column) -> Reached:
        """Return the discs at such a height, to nine digits."""
        cut = self.discs.cut(growth, *coefficients)
        return Reached(cut._asdict(), cut.rotations, cut.slope)


def _coefficients(values: Values) -> tuple[Column, Column]:
    return np.asarray(values["curved_coefficient"]), np.asarray(values["flat_coefficient"])


def _state(worn: DiscWear) -> State:
    found = {one.name: np.asarray(getattr(worn, one.name)) for one in fields(DiscWear)}
    return found | {"depth": worn.curved_depth + worn.flat_depth, "rate": worn.curved_rate}


def disc_pair(contact: TwinDisc, values: Values, distance: DistanceConvention) -> DiscPair:
    """Build two discs from values of the inputs of ``TwinDiscWear``."""
    return DiscPair(
        normal_load=values["normal_load"],
        crown_radius=values["crown_radius"],
        curved_radius=values["curved_radius"],
        flat_radius=values["flat_radius"],
        modulus=contact.reduced_modulus(values["curved_modulus"], values["flat_modulus"]),
        slip=values["slip"],
        distance=distance,
    )


def nominal_pair(manifest: RunManifest, distance: DistanceConvention) -> DiscPair:
    """Return two discs as run.toml states them."""
    contact = TwinDisc.of(manifest.described, manifest.id)
    wear = TwinDiscWear(contact, contact.slip(manifest.conditions), distance)
    return wear.pair(best_values(wear.inputs(manifest.conditions.normal_load, Recipe())))

"""A pin and the track it slides on, both of which wear: from what run.toml states to the course of wear.

Each body loses V = k·F_N·S, and the shape of both follows from these volumes (tribopipe.physics.pin_on_track). No
elasticity enters: local wear removes the same volumes, and has the same shape once the pin is worn three times as deep
as the elastic approach (tribopipe.physics.elastic_start).
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from tribopipe.base.arrays import Column, Values
from tribopipe.base.errors import ContactError
from tribopipe.base.units import show
from tribopipe.contacts.pin_on_disc import neglected_deformation
from tribopipe.contacts.wear import State, Steps
from tribopipe.documents.contact import SlidingPin
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe
from tribopipe.physics.pin_on_disc import no_published_scheme
from tribopipe.physics.pin_on_track import BlockOnTrack, FlatOnTrack, OnTrack, SphereOnTrack, WornContact
from tribopipe.results.input_quantities import Input, relative_input

_SAME = 1e-6
"""Relative difference of volumes that are the same."""
_POINT = 1e-9
"""Length of a scar over the radius of its pin where rigid bodies touch in a line: none would make pressure infinite."""
_MOST_PLACES = 200


@dataclass(frozen=True)
class PinAndTrackWear:
    """Wear of a pin and of the track under it."""

    contact: SlidingPin
    path: Quantity
    """Sliding distance between two passages of the pin at one place of the track, m."""

    coefficients: ClassVar[tuple[str, ...]] = ("wear_coefficient", "track_coefficient")
    displacement: ClassVar[str] = "approach"
    outcomes: ClassVar[Mapping[str, str]] = {"wear_depth": "m"}
    uncertain: ClassVar[tuple[str, ...]] = (
        *("approach", "wear_depth", "track_depth", "pin_volume", "track_volume", "track_section"),
        *("half_width", "half_length", "pressure"),
    )
    most_places: ClassVar[int | None] = _MOST_PLACES
    slid: ClassVar[float] = 1.0

    @property
    def bodies(self) -> dict[str, dict[str, str]]:
        """Names of wear in a state, of pin and counterbody."""
        pin, counterbody = self.contact.body_names
        # A flat pin wears most at its two sides, where it meets no groove.
        edge = {"wear_depth_edge": "approach"} if self.contact.pin.shape == "flat" else {}
        return {
            pin: {"wear_depth": "wear_depth", "wear_volume": "pin_volume", **edge},
            counterbody: {
                "wear_depth": "track_depth",
                "wear_volume": "track_volume",
                "track_cross_section": "track_section",
            },
        }

    @property
    def conditions(self) -> dict[str, Quantity]:
        """The radius of the tip, and how long the track is."""
        return {"pin_radius": self.contact.pin.radius, "track_length": self.path}

    def inputs(self, normal_load: Quantity, recipe: Recipe) -> dict[str, Input]:
        """Return load, tip radius and track with the uncertainties stated, or else the recipe's defaults."""
        defaults = recipe.uncertainty
        return {
            "normal_load": relative_input(self.contact.pressed_by(normal_load), defaults.normal_load, above_zero=True),
            "pin_radius": relative_input(self.contact.equivalent_pin.radius, defaults.pin_radius, above_zero=True),
            "track_length": relative_input(self.path, defaults.track_radius, above_zero=True),
        }

    def tip(self, values: Values) -> OnTrack:
        """Return the unworn pin."""
        if self.contact.pin.line:
            return BlockOnTrack(values["pin_radius"], self.contact.pin.line)
        if self.contact.pin.shape == "flat":
            return FlatOnTrack(values["pin_radius"])
        return SphereOnTrack(values["pin_radius"], self._flat)

    @cached_property
    def _flat(self) -> float:
        return self.contact.flat_end

    def worn(self, values: Values, progress: Column) -> State:
        """Return both bodies after an effective sliding distance, m. Raises ``ContactError`` past the tip."""
        pin, track = (np.asarray(k * values["normal_load"] * progress) for k in _coefficients(values))
        section = track / values["track_length"]
        track = self.contact.contacts_per_turn * track
        tip = self.tip(values)
        worn = tip.worn(pin, section)
        _refuse_beyond(tip, worn, pin)
        return {
            "approach": worn.approach,
            "wear_depth": worn.pin_depth,
            "track_depth": worn.groove_depth,
            "pin_volume": pin,
            "track_volume": track,
            "track_section": section,
            "half_width": worn.half_width,
            "half_length": worn.half_length,
            "pressure": values["normal_load"] / np.maximum(worn.area, (_POINT * np.asarray(values["pin_radius"])) ** 2),
            "rate": self._rate(values, worn),
        }

    def _rate(self, values: Values, worn: WornContact) -> Column:
        """Return how fast the pin recedes in the middle, or the track under a pin that does not wear."""
        pin, track = _coefficients(values)
        load, slope = values["normal_load"], np.maximum(worn.groove_slope, _POINT * np.asarray(values["pin_radius"]))
        length = np.maximum(worn.half_length, _POINT * np.asarray(values["pin_radius"]))
        of_track = track * load / (values["track_length"] * slope)
        return np.where(pin > 0, pin * load / (2 * length * slope), of_track)

    def progress_to(self, values: Values, depth: float) -> Column:
        """Return the effective sliding distance after which the pin, or else the track, has worn to a depth, m.

        It is infinite where neither wears. Raises ``ContactError`` past the tip.
        """
        tip, load = self.tip(values), np.asarray(values["normal_load"])
        pin, track = _coefficients(values)
        wears = pin > 0
        ratio = np.divide(track, pin * values["track_length"], out=np.zeros_like(pin * load), where=wears)
        groove = np.where(wears, ratio * tip.middle_slice(depth), depth)
        worn = tip.at_depths(np.where(wears, depth, 0.0), groove)
        if not np.all(worn.approach < tip.most):
            raise _too_deep(worn, tip)
        lost = np.where(wears, worn.pin_volume, worn.groove_area * values["track_length"])
        rate = np.where(wears, pin, track) * load
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(rate > 0, lost / rate, np.inf)

    def local_amount(self, _: Values, __: Column, /) -> Column:
        """Refuse: local wear is computed of one body only."""
        raise ContactError(
            "local wear: found wear coefficients of both pin and counterbody; expected only that of the pin; omit the "
            "wear coefficient of the counterbody"
        )

    def usual_steps(self, _: float, /) -> int:
        """Return one step, since volumes are exact after any number of them."""
        return 1

    def published(self, _: Values, steps: Steps, __: Column, /) -> State:
        """Refuse: the paper's Euler steps are those of the GIWM."""
        raise no_published_scheme(steps.ends[1:], "wear volumes of pin and counterbody")

    def start(self, _: Values, /) -> None:
        """Return nothing: rigid bodies begin in a point."""

    def notes(self, values: Values, last: State | None) -> tuple[str, ...]:
        """Return what the contact assumes; worn coatings, a track too short for it, and a scar too small for it."""
        yielded = (
            ()
            if last is None
            else (*self._through(last), *self._short(last), *neglected_deformation(self.contact, values, last))
        )
        return *self.contact.limits, "wear volume of each body: k_D·F_N·s", *yielded

    def _through(self, last: State) -> Iterator[str]:
        for (name, body), depth in zip(self.contact.bodies.items(), ("wear_depth", "track_depth"), strict=True):
            coating, worn = body.coating_thickness, float(last[depth])
            if coating is not None and worn > coating.value:
                yield (
                    f"warning: found a wear depth of the {name} of {show(worn, None, 'm', 'um')}, more than its "
                    f"coating thickness of {coating.shown('um')}; expected wear within the coating, since k_D is that "
                    "of the coating"
                )

    def _short(self, last: State) -> Iterator[str]:
        if self.path.value > 2 * float(last["half_length"]):
            return
        yield (
            f"warning: the contact is {show(2 * float(last['half_length']), None, 'm', 'mm')} long and the wear track "
            f"{self.path.shown('mm')}, so that parts of the track never leave the contact; expected a track longer "
            "than the contact; use the wear volumes, which remain valid, not the wear depths"
        )


def _coefficients(values: Values) -> tuple[Column, Column]:
    return np.asarray(values["wear_coefficient"]), np.asarray(values["track_coefficient"])


def _refuse_beyond(tip: OnTrack, worn: WornContact, pin_volume: Column) -> None:
    """Raise ``ContactError`` where the contact is as wide as the sphere, so that no shape has these volumes."""
    found = np.isclose(worn.pin_volume, pin_volume, rtol=_SAME, atol=0)
    if not np.all((worn.approach < tip.most) & found):
        raise _too_deep(worn, tip)


def _too_deep(worn: WornContact, tip: OnTrack) -> ContactError:
    # Beyond the tip there is no such shape, and no depth of it.
    depth = np.max(np.where(np.isfinite(worn.approach), worn.approach, tip.most))
    return ContactError(
        f"contact: found scar and groove with a combined depth of {show(depth, None, 'm', 'um')} or more; expected "
        f"less than the tip height of {show(np.min(tip.most), None, 'm', 'um')}; check wear coefficients, load and "
        "sliding distance"
    )

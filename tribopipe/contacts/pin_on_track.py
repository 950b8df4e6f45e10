"""A pin and the track it slides on, both of which wear: from what run.toml states to the course of wear.

Each body loses V = k·F_N·S, and the shape of both follows from these volumes (tribopipe.physics.pin_on_track). Local
wear removes the same volumes; what elasticity makes of the shape while the scar is small is taken into account by the
engine "local" alone (tribopipe.physics.elastic_start).
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from tribopipe.base.arrays import Column, Values
from tribopipe.base.errors import ContactError
from tribopipe.base.units import show
from tribopipe.contacts.pin_on_disc import (
    PinWear,
    fretting,
    neglected_deformation,
    no_local_wear_of_a_block,
    no_local_wear_of_a_flat_tip,
)
from tribopipe.contacts.wear import State, Steps
from tribopipe.documents.contact import SlidingPin
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe
from tribopipe.physics.calculation_methods import WearEngine
from tribopipe.physics.elastic_start import ElasticSphereOnTrack
from tribopipe.physics.hertz import hertz_radius
from tribopipe.physics.pin_on_disc import no_published_scheme
from tribopipe.physics.pin_on_track import BlockOnTrack, FlatOnTrack, OnTrack, SphereOnTrack, WornContact
from tribopipe.physics.stroke_ends import Stroke
from tribopipe.results.input_quantities import Input, relative_input

_SAME = 1e-6
"""Relative difference of volumes that are the same."""
_POINT = 1e-9
"""Length of a scar over the radius of its pin where rigid bodies touch in a line: none would make pressure infinite."""
_MOST_PLACES = 200
_TURNS, _SETTLED = 20, 1e-9
"""In which a contact and the extension of its stroke, each of which follows from the other, are found."""
_SHORT_STROKE, _SHALLOWER = 25.0, 0.5
"""Half widths of the track in a stroke, below which wear is shallower by up to this share of one over their number."""


@dataclass(frozen=True)
class PinAndTrackWear:
    """Wear of a pin and of the track under it."""

    contact: SlidingPin
    path: Quantity
    """Sliding distance between two passages of the pin at one place of the track, m."""
    engine: WearEngine = "volume"
    """Rigid bodies, or as "local" those with an elastic start; the GIWM has no track that wears."""
    there_and_back: bool = False
    """Whether the path is a stroke, beyond the ends of which the groove extends."""

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
        return PinWear(self.contact, self.engine).conditions | {"track_length": self.path}

    def inputs(self, normal_load: Quantity, recipe: Recipe) -> dict[str, Input]:
        """Return load, tip radius and track with the uncertainties stated, or else the recipe's defaults."""
        defaults, alone = recipe.uncertainty, PinWear(self.contact, self.engine).inputs(normal_load, recipe)
        needed = alone if self.engine == "local" else ("normal_load", "pin_radius")
        track = relative_input(self.path, defaults.track_radius, above_zero=True)
        return {name: alone[name] for name in needed} | {"track_length": track}

    def tip(self, values: Values) -> OnTrack | ElasticSphereOnTrack:
        """Return the unworn pin. Raises ``ContactError`` for local wear of a block or a truncated sphere."""
        local = self.engine == "local"
        if self.contact.pin.line:
            if local:
                raise no_local_wear_of_a_block(self.contact)
            return BlockOnTrack(values["pin_radius"], self.contact.pin.line)
        if self.contact.pin.shape == "flat":
            return FlatOnTrack(values["pin_radius"])
        rigid = SphereOnTrack(values["pin_radius"], self._flat)
        if not local:
            return rigid
        if self._flat:
            raise no_local_wear_of_a_flat_tip(self.contact, "volume")
        return ElasticSphereOnTrack(rigid, self._hertz_radius(values))

    def _hertz_radius(self, values: Values) -> Column:
        modulus = self.contact.reduced_modulus(values["pin_modulus"], values["disc_modulus"])
        return np.asarray(
            hertz_radius(normal_load=values["normal_load"], pin_radius=values["pin_radius"], modulus=modulus)
        )

    @cached_property
    def _flat(self) -> float:
        return self.contact.flat_end

    def worn(self, values: Values, progress: Column) -> State:
        """Return both bodies after an effective sliding distance, m. Raises ``ContactError`` past the tip."""
        pin, track = (np.asarray(k * values["normal_load"] * progress) for k in _coefficients(values))
        tip = self.tip(values)
        worn, length = self._along(values, lambda length: tip.worn(pin, track / length))
        _refuse_beyond(tip, worn, pin)
        section, track = track / length, self.contact.contacts_per_turn * track
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
            "rate": self._rate(values, worn, length),
        }

    def _along(self, values: Values, worn_on: Callable[[Column], WornContact]) -> tuple[WornContact, Column]:
        """Return a contact that depends on its track's volume over its cross-section, and that length, m."""
        length = np.asarray(values["track_length"], dtype=float)
        worn = worn_on(length)
        if not self.there_and_back:
            return worn, length
        stroke = Stroke(length, self.contact.reduced_modulus() / values["normal_load"])
        for _ in range(_TURNS):
            before, length = length, stroke.extended(worn)
            worn = worn_on(length)
            if np.all(np.abs(length - before) <= _SETTLED * length):
                break
        return worn, length

    def _rate(self, values: Values, worn: WornContact, length: Column) -> Column:
        """Return how fast the pin recedes in the middle, or the track under a pin that does not wear."""
        pin, track = _coefficients(values)
        load, point = values["normal_load"], _POINT * np.asarray(values["pin_radius"])
        of_track = track * load / (length * np.maximum(worn.groove_slope, point))
        return np.where(pin > 0, pin * load / np.maximum(worn.pin_slope, point**2), of_track)

    def progress_to(self, values: Values, depth: float) -> Column:
        """Return the effective sliding distance after which the pin, or else the track, has worn to a depth, m.

        It is infinite where neither wears, and in draws in which both would have worn past the tip before. Raises
        ``ContactError`` where that is so in all draws.
        """
        tip, load = self.tip(values), np.asarray(values["normal_load"])
        pin, track = _coefficients(values)
        wears = pin > 0

        def reached(length: Column) -> WornContact:
            ratio = np.divide(track, pin * length, out=np.full(np.shape(pin * length * load), np.inf), where=wears)
            return tip.worn_to(depth, ratio)

        worn, length = self._along(values, reached)
        within = worn.approach < tip.most
        if not np.any(within):
            raise _too_deep(worn, tip)
        lost = np.where(wears, worn.pin_volume, worn.groove_area * length)
        rate = np.where(wears, pin, track) * load
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where((rate > 0) & within, lost / rate, np.inf)

    def local_amount(self, values: Values, progress: Column) -> Column:
        """Return k_1·S of the pin, m³/N."""
        return np.asarray(values["wear_coefficient"] * progress)

    def usual_steps(self, _: float, /) -> int:
        """Return one step, since volumes are exact after any number of them."""
        return 1

    def published(self, _: Values, steps: Steps, __: Column, /) -> State:
        """Refuse: the paper's Euler steps are those of the GIWM."""
        raise no_published_scheme(steps.ends[1:], "wear volumes of pin and counterbody")

    def start(self, _: Values, /) -> None:
        """Return nothing: the published scheme is not that of two bodies."""

    def notes(self, values: Values, last: State | None) -> tuple[str, ...]:
        """Return what the contact assumes; a track too short for it, and a scar too small for it."""
        always = (*self.contact.limits, "wear volume of each body: k_D·F_N·s")
        if last is None:
            return always
        # Within its contact, a stroke has no middle either.
        stroke = self.path if self.there_and_back else None
        short = (*fretting(stroke, last), *self._short(last)) or self._near_the_ends(last)
        shallow = self._neglected(values, last)
        return *always, *short, *shallow

    def _near_the_ends(self, last: State) -> Iterator[str]:
        """Warn of a stroke so short that the shape of the groove is that of its ends."""
        half, stroke = float(last["half_width"]), self.path.value
        worn = self.there_and_back and float(last["track_section"]) > 0
        if worn and stroke < _SHORT_STROKE * half:
            yield (
                f"warning: found a stroke of {self.path.shown('mm')}, {stroke / half:.0f} times the half-width of the "
                f"wear track; expected at least {_SHORT_STROKE:.0f} times the half-width: the wear depths at "
                f"mid-stroke are overestimated by up to {100 * _SHALLOWER * half / stroke:.0f} %; use the wear "
                "volumes, which remain valid"
            )

    def _neglected(self, values: Values, last: State) -> Iterator[str]:
        if self.engine != "local":
            yield from neglected_deformation(self.contact, values, last)

    def _short(self, last: State) -> Iterator[str]:
        if self.there_and_back or self.path.value > 2 * float(last["half_length"]):
            return
        yield (
            f"warning: the contact is {show(2 * float(last['half_length']), None, 'm', 'mm')} long and the wear track "
            f"{self.path.shown('mm')}, so that parts of the track never leave the contact; expected a track longer "
            "than the contact; use the wear volumes, which remain valid, not the wear depths"
        )


def _coefficients(values: Values) -> tuple[Column, Column]:
    return np.asarray(values["wear_coefficient"]), np.asarray(values["track_coefficient"])


def _refuse_beyond(tip: OnTrack | ElasticSphereOnTrack, worn: WornContact, pin_volume: Column) -> None:
    """Raise ``ContactError`` where the contact is as wide as the sphere, so that no shape has these volumes."""
    # A flat on the tip leaves a rounding error where the pin has lost nothing.
    found = (pin_volume <= 0) | np.isclose(worn.pin_volume, pin_volume, rtol=_SAME, atol=0)
    if not np.all((worn.approach < tip.most) & found):
        raise _too_deep(worn, tip)


def _too_deep(worn: WornContact, tip: OnTrack | ElasticSphereOnTrack) -> ContactError:
    # Beyond the tip there is no such shape, and no depth of it.
    depth = np.max(np.where(np.isfinite(worn.approach), worn.approach, tip.most))
    return ContactError(
        f"contact: found scar and groove with a combined depth of {show(depth, None, 'm', 'um')} or more; expected "
        f"less than the tip height of {show(np.min(tip.most), None, 'm', 'um')}; check wear coefficients, load and "
        "sliding distance"
    )

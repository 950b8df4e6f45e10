"""A virtual tribometer of a pin, ball or block on a counterbody.

Depth is wear of both bodies, offset, linear drift and correlated noise, digitised. Where k_D of both is given, either
loses k_D·F_N·S. Otherwise the pin wears by the GIWM, and the counterbody to a depth that is given, as the integral of
1/a over distance: Archard's law for a point of the track that passes under a contact of radius a once a turn. Post-test
measurements are drawn about their true values with their stated uncertainty; so are load, tip radius, moduli, speed and
sensor scale where a series has systematic errors, its manifests stating what was meant.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from tribopipe.base.arrays import Column
from tribopipe.documents.contact import SlidingPin
from tribopipe.documents.plan import Series, Truth, VirtualRun
from tribopipe.documents.quantity import Quantity
from tribopipe.evaluation.measurements.worn_tip import WornTip
from tribopipe.evaluation.wear.scenario import KnownWear, Scenario
from tribopipe.extras.simulate.instrument import (
    AnyVirtualTest,
    Layout,
    TrueValue,
    Written,
    measured,
    systematic_errors,
    written,
)


@dataclass(frozen=True)
class _Worn:
    """True wear of both bodies along a run, and what can be measured at its end."""

    pin_depth: Column
    disc_depth: Column
    scars: Mapping[str, float]
    """Sizes of the scar, m, by their keys; empty for a flat pin."""
    disc_volume: float | None = None
    """m³; None if only a depth is known."""


_MEASURED_BY = {  # end value -> unit in the file, method
    "pin_scar_diameter": ("um", "white-light"),
    "pin_scar_length": ("um", "white-light"),
    "pin_scar_width": ("um", "white-light"),
    "pin_wear_depth": ("um", "stylus"),
    "disc_wear_depth": ("nm", "stylus"),
    "disc_wear_volume": ("mm^3", "stylus"),
}


class VirtualTest(AnyVirtualTest):
    """One virtual run of a pin, ball or block."""

    series: Series
    run: VirtualRun
    measured_by = _MEASURED_BY

    def __init__(self, series: Series, run: VirtualRun) -> None:
        super().__init__(series, run)
        sampling = series.sensors.sampling_rate.value
        samples = round(series.sliding_distance.value / series.sliding_speed.value * sampling)
        self.time = np.arange(samples + 1) / sampling
        off = systematic_errors(run.seed, drawn=series.systematic_errors)
        self.distance = off(series.sliding_speed) * self.time
        self.depth_scale = off(series.depth_scale)
        contact = _off(series.contact, off)
        self.pin_radius = contact.equivalent_pin.radius.value
        self.load = Quantity(value=off(run.normal_load), unit="N")
        # Under Archard's law the effective distance wears as much as the distance does under this one.
        slid = self.law.effective_distance(self.distance, self.friction)
        disc = run.disc_wear_coefficient
        self.worn = self._pin_worn(contact, slid) if disc is None else self._both_worn(contact, slid, disc)
        self._force = "mN" if run.normal_load.value < _MICRO else "N"
        size, turned = "micro " if self._force == "mN" else "", series.contact.load_share != 1
        self.instrument = f"virtual {size}{series.contact.kind} tribometer"
        # Where several contacts share the load, the load cell measures a torque.
        self.friction_arm = (series.contact.friction_arm(None) or 1.0) if turned else 1.0
        self.layout = _layout(self._force, turned=turned)

    def _pin_worn(self, contact: SlidingPin, slid: Column) -> _Worn:
        """Return wear by the GIWM, and of a counterbody that wears to a given depth."""
        known = KnownWear({contact.fitted_bodies[0]: self.run.wear_coefficient})
        state = Scenario(contact, self.load, known).worn(slid)
        depth, tip = state["wear_depth"], WornTip.of(self.series.contact.equivalent_pin)
        scar = 2 * float(tip.scar_radius(depth[-1], self.pin_radius))
        sizes = {"pin_scar_diameter": scar} if tip.widens else {"pin_scar_length": scar} if tip.line else {}
        return _Worn(depth, self._given_disc_wear(state["half_width"]), sizes)

    def _both_worn(self, contact: SlidingPin, slid: Column, of_disc: Quantity) -> _Worn:
        """Return wear of both bodies by volume."""
        pin, disc = contact.body_names
        known = KnownWear({pin: self.run.wear_coefficient, disc: of_disc}, engine="volume")
        state = Scenario(contact, self.load, known, path=self.series.manifest(self.run).path).worn(slid)
        tip, length, width = contact.equivalent_pin, "half_length", "half_width"
        halves = {"pin_scar_length": length, "pin_scar_width": width} if tip.widens else {"pin_scar_length": length}
        sizes = {name: 2 * float(state[half][-1]) for name, half in halves.items()} if tip.widens or tip.line else {}
        return _Worn(state["wear_depth"], state["track_depth"], sizes, float(state["track_volume"][-1]))

    def _given_disc_wear(self, contact_radius: Column) -> Column:
        if self.run.disc_wear_depth is None:
            return np.zeros_like(self.distance)
        inverse = 1 / contact_radius
        grown = np.concatenate([[0.0], np.cumsum((inverse[1:] + inverse[:-1]) / 2 * np.diff(self.distance))])
        return np.asarray(grown / grown[-1] * self.run.disc_wear_depth.value)

    def truth(self) -> Truth:
        """Return what the run was made from."""
        volume = self.worn.disc_volume
        return Truth(
            **self.told(),
            wear_coefficient=self.run.wear_coefficient,
            end_pin_wear_depth=Quantity(value=float(self.worn.pin_depth[-1]), unit="m"),
            end_disc_wear_depth=Quantity(value=float(self.worn.disc_depth[-1]), unit="m"),
            disc_wear_coefficient=self.run.disc_wear_coefficient,
            end_disc_wear_volume=None if volume is None else Quantity(value=volume, unit="m^3"),
        )

    @property
    def displacement(self) -> Column:
        """Displacement by the wear of both bodies, as the sensor reads it, m."""
        worn = self.worn.pin_depth + self.worn.disc_depth
        return worn / (self.depth_scale * self.series.contact.depth_share)

    @property
    def loads(self) -> tuple[float, float]:
        """Normal load, N: the true one and the nominal one."""
        return self.load.value, self.run.normal_load.value

    @property
    def conditions(self) -> dict[str, str]:
        """The conditions, but for the medium, as run.toml has them."""
        series = self.series
        return {
            "normal_load": written(self.run.normal_load, self._force),
            "sliding_speed": written(series.sliding_speed, "mm/s"),
            "sliding_distance": written(series.sliding_distance, "m"),
        } | {name: written(size, "mm") for name in _TRACK if (size := getattr(series, name)) is not None}

    def end_values(self, rng: Generator) -> dict[str, Quantity]:
        """Draw the post-test measurements."""
        worn, disc, sensors = self.worn, self.run.disc_wear_depth, self.series.sensors
        if worn.scars and (sensors.pin_end_value == "pin_scar_diameter" or "pin_scar_diameter" not in worn.scars):
            ends = {name: measured(size, sensors.scar_uncertainty.value, rng) for name, size in worn.scars.items()}
        else:
            ends = {"pin_wear_depth": measured(float(worn.pin_depth[-1]), sensors.height_loss_uncertainty.value, rng)}
        if disc is not None:
            read = measured(float(worn.disc_depth[-1]), disc.u_or_zero, rng)
            ends["disc_wear_depth"] = read.model_copy(update={"value": max(read.value, 0.0)})
        if worn.disc_volume is not None:
            spread = sensors.disc_volume_uncertainty.value * worn.disc_volume
            ends["disc_wear_volume"] = measured(worn.disc_volume, spread, rng, "m^3")
        return ends


def _off(contact: SlidingPin, off: TrueValue) -> SlidingPin:
    """Return a contact whose tip radius and moduli are off."""

    def changed(quantity: Quantity) -> Quantity:
        return Quantity(value=off(quantity), unit=quantity.unit)

    pin = {"radius": changed(contact.pin.radius), "youngs_modulus": changed(contact.pin.youngs_modulus)}
    other = {"youngs_modulus": changed(contact.counterbody.youngs_modulus)}
    return contact.with_bodies(contact.pin.model_copy(update=pin), contact.counterbody.model_copy(update=other))


_MICRO = 2.0
"""Load, N, under which forces are written in mN."""


def _layout(force: str, *, turned: bool) -> Layout:
    decimals = 2 if force == "mN" else 4
    torque = Written("T [N*mm]", "N*m", "N*mm", 2)
    return {
        "time": Written("Time [s]", "s", "s", 1),
        "depth": Written("Depth [um]", "m", "um", 2),
        "friction_force": torque if turned else Written(f"Ff [{force}]", "N", force, decimals),
        "normal_force": Written(f"Fn [{force}]", "N", force, decimals),
    }


_TRACK = ("stroke", "track_radius")

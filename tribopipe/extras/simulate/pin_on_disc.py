"""A virtual tribometer of a pin, ball or block on a counterbody.

Depth is wear of both bodies, offset, linear drift and correlated noise, digitised. Where k_D of both is given, either
loses k_D·F_N·S. Otherwise the pin wears by the GIWM, and the counterbody to a depth that is given, as the integral of
1/a over distance: Archard's law for a point of the track that passes under a contact of radius a once a turn. Post-test
measurements are drawn about their true values with their stated uncertainty; so are load, tip radius, moduli, speed and
sensor scale where a series has systematic errors, its manifests stating what was meant.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.random import Generator

from tribopipe.base.arrays import Column
from tribopipe.documents.contact import Pin, SlidingPin, Specimen
from tribopipe.documents.plan import Sensors, Series, Truth, VirtualRun
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.record import quoted
from tribopipe.evaluation.load_and_friction import stated_path
from tribopipe.evaluation.measurements.pin_tip import PinTip
from tribopipe.evaluation.wear.scenario import KnownWear, Scenario
from tribopipe.extras.simulate.instrument import (
    Layout,
    TrueValue,
    Written,
    manifest_head,
    manifest_tail,
    measured,
    read_depth,
    read_forces,
    specimen,
    systematic_errors,
    true_law,
    true_parameters,
    write_run,
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


class VirtualTest:
    """One virtual run: its true state and what the instrument makes of it."""

    def __init__(self, series: Series, run: VirtualRun) -> None:
        self.series, self.run = series, run
        sampling = series.sensors.sampling_rate.value
        samples = round(series.sliding_distance.value / series.sliding_speed.value * sampling)
        self.time = np.arange(samples + 1) / sampling
        off = systematic_errors(run.seed, drawn=series.systematic_errors)
        self.distance = off(series.sliding_speed) * self.time
        self.depth_scale = off(series.depth_scale)
        self.friction = stated_path(run.friction)
        contact = _off(series.contact, off)
        self.pin_radius = contact.equivalent_pin.radius.value
        self.load = Quantity(value=off(run.normal_load), unit="N")
        self.law = true_law(series)
        # Under Archard's law the effective distance wears as much as the distance does under this one.
        slid = self.law.effective_distance(self.distance, self.friction)
        disc = run.disc_wear_coefficient
        self.worn = self._pin_worn(contact, slid) if disc is None else self._both_worn(contact, slid, disc)

    def _pin_worn(self, contact: SlidingPin, slid: Column) -> _Worn:
        """Return wear by the GIWM, and of a counterbody that wears to a given depth."""
        known = KnownWear({contact.fitted_bodies[0]: self.run.wear_coefficient})
        state = Scenario(contact, self.load, known).worn(slid)
        depth, tip = state["wear_depth"], PinTip.of(self.series.contact.equivalent_pin)
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
            id=self.run.id,
            law=self.series.law,
            law_parameters=true_parameters(self.law),
            wear_coefficient=self.run.wear_coefficient,
            friction=self.run.friction,
            zero_offset=self.run.zero_offset,
            drift_rate=self.run.drift_rate,
            end_pin_wear_depth=Quantity(value=float(self.worn.pin_depth[-1]), unit="m"),
            end_disc_wear_depth=Quantity(value=float(self.worn.disc_depth[-1]), unit="m"),
            disc_wear_coefficient=self.run.disc_wear_coefficient,
            end_disc_wear_volume=None if volume is None else Quantity(value=volume, unit="m^3"),
        )

    def record(self) -> tuple[dict[str, Column], dict[str, Quantity]]:
        """Return the instrument's columns, SI, and the uncertain post-test measurements, drawn with the run's seed."""
        run, sensors, rng = self.run, self.series.sensors, np.random.Generator(np.random.PCG64(self.run.seed))
        shown = (
            run.zero_offset.value
            + (self.worn.pin_depth + self.worn.disc_depth) / (self.depth_scale * self.series.contact.depth_share)
            + run.drift_rate.value * self.time
        )
        depth = read_depth(shown, self.time, sensors, rng)
        mu, nominal = self.friction.coefficient(self.distance), run.normal_load.value
        rubbing, load = read_forces(mu, self.load.value, nominal, sensors, rng)
        columns = {"time": self.time, "depth": depth, "normal_force": load, "friction_force": rubbing}
        return columns, self._end_values(sensors, rng)

    def _end_values(self, sensors: Sensors, rng: Generator) -> dict[str, Quantity]:
        worn, disc = self.worn, self.run.disc_wear_depth
        if worn.scars and (sensors.pin_end_value == "pin_scar_diameter" or "pin_scar_diameter" not in worn.scars):
            ends = {name: measured(size, sensors.scar_uncertainty.value, rng) for name, size in worn.scars.items()}
        else:
            ends = {"pin_wear_depth": measured(float(worn.pin_depth[-1]), sensors.height_loss_uncertainty.value, rng)}
        if disc is not None:
            read = measured(float(worn.disc_depth[-1]), disc.standard_uncertainty or 0.0, rng)
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


def _layout(contact: SlidingPin, force: str) -> Layout:
    decimals = 2 if force == "mN" else 4
    torque = Written("T [N*mm]", "N*m", "N*mm", 2)
    friction = torque if _turned(contact) else Written(f"Ff [{force}]", "N", force, decimals)
    return {
        "time": Written("Time [s]", "s", "s", 1),
        "depth": Written("Depth [um]", "m", "um", 2),
        "friction_force": friction,
        "normal_force": Written(f"Fn [{force}]", "N", force, decimals),
    }


_TRACK = ("stroke", "track_radius")
_MEASURED_BY = {  # end value -> unit in the file, method
    "pin_scar_diameter": ("um", "white-light"),
    "pin_scar_length": ("um", "white-light"),
    "pin_scar_width": ("um", "white-light"),
    "pin_wear_depth": ("um", "stylus"),
    "disc_wear_depth": ("nm", "stylus"),
    "disc_wear_volume": ("mm^3", "stylus"),
}


def _turned(contact: SlidingPin) -> bool:
    """Whether the load cell measures a torque, as where several contacts share the load."""
    return contact.load_share != 1


def simulate_run(series: Series, run: VirtualRun, folder: Path) -> Truth:
    """Write a run folder: run.toml, signals.csv and truth.json."""
    test = VirtualTest(series, run)
    columns, ends = test.record()
    truth = test.truth()
    force = "mN" if run.normal_load.value < _MICRO else "N"
    contact = series.contact
    if _turned(contact):
        columns["friction_force"] = columns["friction_force"] * (contact.friction_arm(None) or 1.0)
    write_run(folder, _layout(contact, force), columns, _manifest(series, run, ends, force), truth)
    return truth


def _manifest(series: Series, run: VirtualRun, ends: dict[str, Quantity], force: str) -> list[str]:
    bodies = [("", f"[contact.{name}]", *_body(body)) for name, body in series.contact.bodies.items()]
    size = "micro " if force == "mN" else ""
    return [
        *manifest_head(run.id, run.started, series.title, f"virtual {size}{series.contact.kind} tribometer"),
        "[contact]",
        f"kind = {quoted(series.contact.kind)}",
        *(line for lines in bodies for line in lines),
        "",
        "[conditions]",
        f"normal_load = {written(run.normal_load, force)}",
        f"sliding_speed = {written(series.sliding_speed, 'mm/s')}",
        f"sliding_distance = {written(series.sliding_distance, 'm')}",
        *(f"{name} = {written(length, 'mm')}" for name in _TRACK if (length := getattr(series, name)) is not None),
        f"medium = {quoted(series.medium)}",
        "",
        *manifest_tail(_layout(series.contact, force), ends, _MEASURED_BY, series.depth_scale, series.contact.worded),
    ]


def _body(body: Specimen) -> list[str]:
    """Return the lines of a body: the tip of a pin, and what is known of any specimen."""
    if not isinstance(body, Pin):
        return specimen(body)
    return [
        f"shape = {quoted(body.shape)}",
        f"radius = {written(body.radius, 'mm')}",
        *([] if body.flat_radius is None else [f"flat_radius = {written(body.flat_radius, 'um')}"]),
        *specimen(body),
    ]

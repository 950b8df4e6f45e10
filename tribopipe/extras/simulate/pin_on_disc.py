"""A virtual pin-on-disc tribometer.

Depth is pin wear (the closed form) plus disc wear, offset, linear drift and correlated noise, digitised. Disc wear
grows as the integral of 1/a over distance, which is Archard's law for a point of the track that passes under a contact
of radius a once a turn. The post-test measurement is drawn about its true value with its stated uncertainty; so are
load, tip
radius, moduli, speed and sensor scale where a series has systematic errors, its manifests stating what was meant.
"""

from pathlib import Path

import numpy as np
from numpy.random import Generator

from tribopipe.base.arrays import Column
from tribopipe.documents.contact import Pin, SlidingPin, Specimen
from tribopipe.documents.plan import Sensors, Series, Truth, VirtualRun
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.record import quoted
from tribopipe.evaluation.friction_paths import stated_path
from tribopipe.evaluation.measurements.pin_tip import PinTip
from tribopipe.evaluation.wear.known import KnownWear
from tribopipe.evaluation.wear.scenario import Scenario
from tribopipe.extras.simulate.drawing import TrueValue, measured, read_depth, read_forces, systematic_errors
from tribopipe.extras.simulate.true_law import true_law, true_parameters
from tribopipe.extras.simulate.writing import (
    Layout,
    Written,
    manifest_head,
    manifest_tail,
    specimen,
    write_run,
    written,
)


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
        archard = Scenario(contact, self.load, KnownWear({contact.fitted_bodies[0]: run.wear_coefficient}))
        state = archard.worn(self.law.effective_distance(self.distance, self.friction))
        self.pin_wear, self.disc_wear = state["wear_depth"], self._disc_wear(state["half_width"])

    def _disc_wear(self, contact_radius: Column) -> Column:
        if self.run.disc_wear_depth is None:
            return np.zeros_like(self.distance)
        inverse = 1 / contact_radius
        grown = np.concatenate([[0.0], np.cumsum((inverse[1:] + inverse[:-1]) / 2 * np.diff(self.distance))])
        return np.asarray(grown / grown[-1] * self.run.disc_wear_depth.value)

    def truth(self) -> Truth:
        """Return what the run was made from."""
        return Truth(
            id=self.run.id,
            law=self.series.law,
            law_parameters=true_parameters(self.law),
            wear_coefficient=self.run.wear_coefficient,
            friction=self.run.friction,
            zero_offset=self.run.zero_offset,
            drift_rate=self.run.drift_rate,
            end_pin_wear_depth=Quantity(value=float(self.pin_wear[-1]), unit="m"),
            end_disc_wear_depth=Quantity(value=float(self.disc_wear[-1]), unit="m"),
        )

    def record(self) -> tuple[dict[str, Column], dict[str, Quantity]]:
        """Return the instrument's columns, SI, and the uncertain post-test measurements, drawn with the run's seed."""
        run, sensors, rng = self.run, self.series.sensors, np.random.Generator(np.random.PCG64(self.run.seed))
        shown = (
            run.zero_offset.value
            + (self.pin_wear + self.disc_wear) / (self.depth_scale * self.series.contact.depth_share)
            + run.drift_rate.value * self.time
        )
        depth = read_depth(shown, self.time, sensors, rng)
        mu, nominal = self.friction.coefficient(self.distance), run.normal_load.value
        rubbing, load = read_forces(mu, self.load.value, nominal, sensors, rng)
        columns = {"time": self.time, "depth": depth, "normal_force": load, "friction_force": rubbing}
        return columns, self._end_values(sensors, rng)

    def _end_values(self, sensors: Sensors, rng: Generator) -> dict[str, Quantity]:
        pin, worn = self.series.contact.equivalent_pin, float(self.pin_wear[-1])
        if pin.line or (pin.widens and sensors.pin_end_value == "pin_scar_diameter"):
            scar = 2 * float(PinTip.of(pin).scar_radius(worn, self.pin_radius))
            name = "pin_scar_length" if pin.line else "pin_scar_diameter"
            ends = {name: measured(scar, sensors.scar_uncertainty.value, rng)}
        else:
            ends = {"pin_wear_depth": measured(worn, sensors.height_loss_uncertainty.value, rng)}
        disc = self.run.disc_wear_depth
        if disc is not None:
            read = measured(float(self.disc_wear[-1]), disc.standard_uncertainty or 0.0, rng)
            ends["disc_wear_depth"] = read.model_copy(update={"value": max(read.value, 0.0)})
        return ends


def _off(contact: SlidingPin, off: TrueValue) -> SlidingPin:
    """Return a contact whose tip radius and moduli are off."""

    def changed(quantity: Quantity) -> Quantity:
        return Quantity(value=off(quantity), unit=quantity.unit)

    pin = {"radius": changed(contact.pin.radius), "youngs_modulus": changed(contact.pin.youngs_modulus)}
    other = {"youngs_modulus": changed(contact.counterbody.youngs_modulus)}
    return contact.with_bodies(contact.pin.model_copy(update=pin), contact.counterbody.model_copy(update=other))


_WRITTEN: Layout = {
    "time": Written("Time [s]", "s", "s", 1),
    "depth": Written("Depth [um]", "m", "um", 2),
    "friction_force": Written("Ff [mN]", "N", "mN", 2),
    "normal_force": Written("Fn [mN]", "N", "mN", 2),
}
_MEASURED_BY = {  # end value -> unit in the file, method
    "pin_scar_diameter": ("um", "white-light"),
    "pin_scar_length": ("um", "white-light"),
    "pin_wear_depth": ("um", "stylus"),
    "disc_wear_depth": ("nm", "stylus"),
}


def simulate_run(series: Series, run: VirtualRun, folder: Path) -> Truth:
    """Write a run folder: run.toml, signals.csv and truth.json."""
    test = VirtualTest(series, run)
    columns, ends = test.record()
    truth = test.truth()
    write_run(folder, _WRITTEN, columns, _manifest(series, run, ends), truth)
    return truth


def _manifest(series: Series, run: VirtualRun, ends: dict[str, Quantity]) -> list[str]:
    bodies = [("", f"[contact.{name}]", *_body(body)) for name, body in series.contact.bodies.items()]
    return [
        *manifest_head(run.id, run.started, series.title, f"virtual micro {series.contact.kind} tribometer"),
        "[contact]",
        f"kind = {quoted(series.contact.kind)}",
        *(line for lines in bodies for line in lines),
        "",
        "[conditions]",
        f"normal_load = {written(run.normal_load, 'mN')}",
        f"sliding_speed = {written(series.sliding_speed, 'mm/s')}",
        f"sliding_distance = {written(series.sliding_distance, 'm')}",
        *([] if series.stroke is None else [f"stroke = {written(series.stroke, 'mm')}"]),
        f"medium = {quoted(series.medium)}",
        "",
        *manifest_tail(_WRITTEN, ends, _MEASURED_BY, series.depth_scale, series.contact.worded),
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

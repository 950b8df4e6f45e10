"""A virtual tribometer: run folders with a known truth, from the exact wear model and an instrument's imperfections.

Depth is pin wear (the closed form) plus disc wear, offset, linear drift and correlated noise, digitised. Disc wear
grows as the integral of 1/a over distance, which is Archard's law for a point of the track that passes under a contact
of radius a once a turn. The end value is drawn about its true value with its stated uncertainty; so are load, tip
radius, moduli, speed and sensor scale where a series has systematic errors, its manifests stating what was meant.
"""

import json
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.random import Generator

from tribopipe.files import write_file
from tribopipe.geometry import cap_radius
from tribopipe.records.base import quoted
from tribopipe.records.manifest import PinOnDisc, Specimen
from tribopipe.records.plan import Plan, Sensors, Series, Truth, VirtualRun
from tribopipe.records.quantity import Quantity
from tribopipe.run import Column
from tribopipe.units import from_si, interval_from_si
from tribopipe.wear.friction_path import stated_path
from tribopipe.wear.predict import WearScenario

SIGNALS_NAME, TRUTH_NAME = "signals.csv", "truth.json"


class VirtualTest:
    """One virtual run: its true state and what the instrument makes of it."""

    def __init__(self, series: Series, run: VirtualRun) -> None:
        self.series, self.run = series, run
        sampling = series.sensors.sampling_rate.value
        samples = round(series.sliding_distance.value / series.sliding_speed.value * sampling)
        self.time = np.arange(samples + 1) / sampling
        off = self._systematic_errors()
        self.distance = off(series.sliding_speed) * self.time
        self.depth_scale = off(series.depth_scale)
        self.friction = stated_path(run.friction)
        contact = _off(series.contact, off)
        self.pin_radius = contact.pin.radius.value
        load = Quantity(value=off(run.normal_load), unit="N")
        scenario = WearScenario(contact, load, run.wear_coefficient, series.law, self.friction)
        state = scenario.worn(self.distance)
        self.pin_wear, self.disc_wear = state.depth, self._disc_wear(state.radius)

    def _systematic_errors(self) -> Callable[[Quantity], float]:
        """Return what makes the true value of a quantity out of the stated one."""
        # A stream of its own, so that the noise is the same with these errors and without.
        rng = np.random.Generator(np.random.PCG64([self.run.seed, 1]))

        def off(stated: Quantity) -> float:
            error = (stated.standard_uncertainty or 0.0) * float(rng.standard_normal())
            return stated.value + (error if self.series.systematic_errors else 0.0)

        return off

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
            wear_coefficient=self.run.wear_coefficient,
            friction=self.run.friction,
            zero_offset=self.run.zero_offset,
            drift_rate=self.run.drift_rate,
            end_pin_wear_depth=Quantity(value=float(self.pin_wear[-1]), unit="m"),
            end_disc_wear_depth=Quantity(value=float(self.disc_wear[-1]), unit="m"),
        )

    def record(self) -> tuple[dict[str, Column], dict[str, Quantity]]:
        """Return the instrument's columns, SI, and the end values with their uncertainty, drawn with the run's seed."""
        sensors, rng = self.series.sensors, np.random.Generator(np.random.PCG64(self.run.seed))
        depth = self._depth_reading(sensors, rng)
        count = len(self.time)
        noise = _correlated(rng, count, sensors.friction_correlation_time.value * sensors.sampling_rate.value)
        mu = self.friction.coefficient(self.distance) + sensors.friction_noise.value * noise
        load = self.run.normal_load.value * (1 + sensors.load_noise.value * rng.standard_normal(count))
        columns = {"time": self.time, "depth": depth, "normal_force": load, "friction_force": mu * load}
        return columns, self._end_values(sensors, rng)

    def _end_values(self, sensors: Sensors, rng: Generator) -> dict[str, Quantity]:
        pin, worn = self.series.contact.pin, float(self.pin_wear[-1])
        if pin.shape == "spherical" and sensors.pin_end_value == "pin_scar_diameter":
            scar = 2 * float(cap_radius(height=worn, sphere_radius=self.pin_radius))
            ends = {"pin_scar_diameter": _measured(scar, sensors.scar_uncertainty.value, rng)}
        else:
            ends = {"pin_wear_depth": _measured(worn, sensors.height_loss_uncertainty.value, rng)}
        disc = self.run.disc_wear_depth
        if disc is not None:
            ends["disc_wear_depth"] = _measured(float(self.disc_wear[-1]), disc.standard_uncertainty or 0.0, rng)
        return ends

    def _depth_reading(self, sensors: Sensors, rng: Generator) -> Column:
        correlated = _correlated(
            rng, len(self.time), sensors.depth_correlation_time.value * sensors.sampling_rate.value
        )
        reading = (
            self.run.zero_offset.value
            + (self.pin_wear + self.disc_wear) / self.depth_scale
            + self.run.drift_rate.value * self.time
            + sensors.depth_noise.value * correlated
        )
        step = sensors.depth_resolution.value
        return np.asarray(np.round(reading / step) * step)


def _off(contact: PinOnDisc, off: Callable[[Quantity], float]) -> PinOnDisc:
    """Return a contact whose tip radius and moduli are off."""

    def changed(quantity: Quantity) -> Quantity:
        return Quantity(value=off(quantity), unit=quantity.unit)

    pin = {"radius": changed(contact.pin.radius), "youngs_modulus": changed(contact.pin.youngs_modulus)}
    disc = {"youngs_modulus": changed(contact.disc.youngs_modulus)}
    return contact.model_copy(
        update={"pin": contact.pin.model_copy(update=pin), "disc": contact.disc.model_copy(update=disc)}
    )


def _measured(true: float, spread: float, rng: Generator) -> Quantity:
    return Quantity(value=true + spread * float(rng.standard_normal()), unit="m", standard_uncertainty=spread)


def _correlated(rng: Generator, count: int, length: float) -> Column:
    """Draw first-order autoregressive noise of unit variance that forgets itself over ``length`` samples."""
    from scipy.signal import lfilter

    memory = math.exp(-1 / length)
    white = rng.standard_normal(count)
    start = white[:1] * memory
    shaped, _ = lfilter([math.sqrt(1 - memory**2)], [1.0, -memory], white[1:], zi=start)
    return np.concatenate([white[:1], shaped])


def simulate_run(series: Series, run: VirtualRun, folder: Path) -> Truth:
    """Write a run folder: run.toml, signals.csv and truth.json."""
    test = VirtualTest(series, run)
    columns, ends = test.record()
    folder.mkdir(parents=True, exist_ok=True)
    write_file(folder / SIGNALS_NAME, _csv(columns).encode("ascii"))
    write_file(folder / "run.toml", _manifest(series, run, ends).encode("utf-8"))
    truth = test.truth()
    document = truth.model_dump_json(indent=2, by_alias=True, exclude_none=True)
    write_file(folder / TRUTH_NAME, (document + "\n").encode("ascii"))
    return truth


_WRITTEN = {  # column -> header, SI unit, unit in the file, decimals
    "time": ("Time [s]", "s", "s", 1),
    "depth": ("Depth [um]", "m", "um", 2),
    "friction_force": ("Ff [mN]", "N", "mN", 2),
    "normal_force": ("Fn [mN]", "N", "mN", 2),
}


def _csv(columns: dict[str, Column]) -> str:
    shown = [
        [f"{value:.{digits}f}" for value in from_si(columns[name], si, unit).tolist()]
        for name, (_, si, unit, digits) in _WRITTEN.items()
    ]
    head = ",".join(header for header, *_ in _WRITTEN.values())
    return "\n".join([head, *map(",".join, zip(*shown, strict=True))]) + "\n"


def _manifest(series: Series, run: VirtualRun, ends: dict[str, Quantity]) -> str:
    pin, disc = series.contact.pin, series.contact.disc
    lines = [
        "#:schema ../../schemas/run.schema.json",
        "# Synthetic: written by `tribopipe simulate`; truth.json beside it says what it was made from.",
        'schema = "tribopipe.run/1"',
        f"id = {quoted(run.id)}",
        f"started = {run.started.isoformat()}",
        f"title = {quoted(series.title)}",
        'instrument = "virtual micro pin-on-disc tribometer"',
        "",
        "[contact]",
        'kind = "pin-on-disc"',
        "",
        "[contact.pin]",
        f"shape = {quoted(pin.shape)}",
        f"radius = {_written(pin.radius, 'mm')}",
        *_specimen(pin),
        "",
        "[contact.disc]",
        *_specimen(disc),
        "",
        "[conditions]",
        f"normal_load = {_written(run.normal_load, 'mN')}",
        f"sliding_speed = {_written(series.sliding_speed, 'mm/s')}",
        f"sliding_distance = {_written(series.sliding_distance, 'm')}",
        f"medium = {quoted(series.medium)}",
        "",
        "[[signals]]",
        f"file = {quoted(SIGNALS_NAME)}",
        "[signals.columns]",
        *(f"{name} = {{ column = {quoted(header)} }}" for name, (header, *_) in _WRITTEN.items()),
        "",
        "[end_values]",
        *(f"{name} = {_written(value, *_MEASURED_BY[name])}" for name, value in ends.items()),
        "",
        "[sensors]",
        f"depth_scale = {_written(series.depth_scale, '1')}",
    ]
    return "\n".join(lines) + "\n"


_MEASURED_BY = {  # end value -> unit in the file, method
    "pin_scar_diameter": ("um", "white-light"),
    "pin_wear_depth": ("um", "stylus"),
    "disc_wear_depth": ("nm", "stylus"),
}
_SPECIMEN_UNITS = {
    "material": None,
    "youngs_modulus": "GPa",
    "poisson_ratio": "1",
    "density": "g/cm^3",
    "surface_roughness": "um",
    "vickers_hardness": None,
    "fracture_toughness": "MPa*m^0.5",
    "diameter": "mm",
}


def _specimen(specimen: Specimen) -> list[str]:
    given = {name: getattr(specimen, name) for name in _SPECIMEN_UNITS}
    return [
        f"{name} = {_written(value, _SPECIMEN_UNITS[name] or '') if isinstance(value, Quantity) else json.dumps(value)}"
        for name, value in given.items()
        if value is not None
    ]


def _written(quantity: Quantity, unit: str, method: str | None = None) -> str:
    """Write a quantity as TOML, a table where it carries more than its value."""
    value = _number(from_si(quantity.value, quantity.unit, unit), unit)
    if quantity.standard_uncertainty is None and method is None:
        return value
    fields = [f"value = {value}"]
    if quantity.standard_uncertainty is not None:
        spread = interval_from_si(quantity.standard_uncertainty, quantity.unit, unit)
        fields.append(f"standard_uncertainty = {_number(spread, unit)}")
    if method is not None:
        fields.append(f"method = {quoted(method)}")
    return f"{{ {', '.join(fields)} }}"


def _number(value: float, unit: str) -> str:
    return f"{value:.6g}" if unit == "1" else quoted(f"{value:.6g} {unit}")


def simulate_plan(plan: Plan, folder: Path) -> list[Truth]:
    """Write every run of a plan into a folder of its own."""
    return [simulate_run(series, run, folder / run.id) for series in plan.series for run in series.runs]

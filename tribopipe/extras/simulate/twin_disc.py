"""A virtual twin-disc tribometer.

Depth is the wear of both discs by the exact model, offset, linear drift and correlated noise, digitised; rotations are
counted on the crowned disc. Worn volumes, depths and track widths are drawn about their true values with their stated
uncertainty; so are load, radii, moduli, slip and sensor scale where a series has systematic errors, its manifests
stating what was meant. Under Sarkar's law a rotation counts S(s)/s times, s being the slip distance. What two discs go
through depends on k_D and rotations by their product alone, so a rotation under fatigue counts as often as fatigue
multiplies k_D.
"""

import math
from pathlib import Path

import numpy as np
from numpy.random import Generator

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError
from tribopipe.contacts.twin_disc import disc_pair
from tribopipe.documents.plan import TwinDiscSensors, TwinDiscSeries, TwinDiscTruth, TwinDiscVirtualRun
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.record import quoted
from tribopipe.documents.twin_disc import CurvedDisc, FlatDisc
from tribopipe.evaluation.load_and_friction import stated_path
from tribopipe.extras.simulate.instrument import (
    Layout,
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


class VirtualTwinDiscTest:
    """One virtual run of two discs: its true state and what the instrument makes of it."""

    def __init__(self, series: TwinDiscSeries, run: TwinDiscVirtualRun) -> None:
        self.series, self.run, self.load = series, run, series.load_of(run)
        contact, off = series.contact, systematic_errors(run.seed, drawn=series.systematic_errors)
        per_second = series.curved_disc_speed.value / (2 * math.pi * contact.curved_disc.rolling_radius.value)
        self.time = _sampled(run.rotations / per_second, series.sensors.sampling_rate.value)
        self.rotations = per_second * self.time
        self.depth_scale = off(series.depth_scale)
        self.values = {
            "normal_load": off(self.load),
            "crown_radius": off(contact.curved_disc.crown_radius),
            "curved_radius": off(contact.curved_disc.rolling_radius),
            "flat_radius": off(contact.flat_disc.rolling_radius),
            "curved_modulus": off(contact.curved_disc.youngs_modulus),
            "flat_modulus": off(contact.flat_disc.youngs_modulus),
            "slip": off(run.slip),
        }
        self.slip_per_rotation = 2 * math.pi * self.values["curved_radius"] * abs(self.values["slip"])
        self.friction, self.law = stated_path(run.friction), true_law(series)
        try:
            self.state = disc_pair(contact, self.values, series.distance_per_rotation).worn(
                self._effective(self.rotations), run.curved_wear_coefficient.value, run.flat_wear_coefficient.value
            )
        except ContactError as error:
            raise ContactError(f"{run.id}: {error}") from None

    @property
    def distance(self) -> Column:
        """Distance slipped by the unworn discs, m."""
        return self.rotations * self.slip_per_rotation

    def _effective(self, rotations: Column) -> Column:
        """Return the rotations after which Archard's law without fatigue gives the same wear."""
        fatigue = self.run.fatigue
        if fatigue is None:
            return self._under_law(rotations)
        sound = self._under_law(np.minimum(rotations, fatigue.from_rotations))
        return sound + fatigue.factor * (self._under_law(rotations) - sound)

    def _under_law(self, rotations: Column) -> Column:
        slipped = self.law.effective_distance(rotations * self.slip_per_rotation, self.friction)
        return slipped / self.slip_per_rotation

    def truth(self) -> TwinDiscTruth:
        """Return what the run was made from."""
        run, state = self.run, self.state
        return TwinDiscTruth(
            id=run.id,
            law=self.series.law,
            law_parameters=true_parameters(self.law),
            distance_per_rotation=self.series.distance_per_rotation,
            curved_wear_coefficient=run.curved_wear_coefficient,
            flat_wear_coefficient=run.flat_wear_coefficient,
            fatigue=run.fatigue,
            friction=run.friction,
            zero_offset=run.zero_offset,
            drift_rate=run.drift_rate,
            end_curved_wear_depth=Quantity(value=float(state.curved_depth[-1]), unit="m"),
            end_flat_wear_depth=Quantity(value=float(state.flat_depth[-1]), unit="m"),
            end_curved_wear_volume=Quantity(value=float(state.curved_volume[-1]), unit="m^3"),
            end_flat_wear_volume=Quantity(value=float(state.flat_volume[-1]), unit="m^3"),
            end_track_width=Quantity(value=2 * float(state.half_width[-1]), unit="m"),
        )

    def record(self) -> tuple[dict[str, Column], dict[str, Quantity]]:
        """Return the instrument's columns, SI, and the uncertain post-test measurements, drawn with the run's seed."""
        run, sensors, rng = self.run, self.series.sensors, np.random.Generator(np.random.PCG64(self.run.seed))
        worn = self.state.curved_depth + self.state.flat_depth
        shown = run.zero_offset.value + worn / self.depth_scale + run.drift_rate.value * self.time
        depth = read_depth(shown, self.time, sensors, rng)
        mu, pressing = self.friction.coefficient(self.distance), self.values["normal_load"]
        rubbing, load = read_forces(mu, pressing, self.load.value, sensors, rng)
        columns = {
            "time": self.time,
            "rotations": self.rotations,
            "depth": depth,
            "normal_force": load,
            "friction_force": rubbing,
        }
        return columns, self._end_values(sensors, rng)

    def _end_values(self, sensors: TwinDiscSensors, rng: Generator) -> dict[str, Quantity]:
        truth = self.truth()
        ends: dict[str, Quantity] = {}
        for disc, depth, volume in (
            ("curved_disc", truth.end_curved_wear_depth, truth.end_curved_wear_volume),
            ("flat_disc", truth.end_flat_wear_depth, truth.end_flat_wear_volume),
        ):
            # All are drawn whatever is measured, so that none depends on which others are.
            drawn = {
                "wear_depth": _length(depth, sensors.wear_depth_uncertainty, rng),
                "track_width": _length(truth.end_track_width, sensors.track_width_uncertainty, rng),
                "wear_volume": _volume(volume, sensors.volume_uncertainty, rng),
            }
            ends |= {f"{disc}_{name}": value for name, value in drawn.items() if name in sensors.end_values}
        return ends


def _sampled(duration: float, rate: float) -> Column:
    """Return the times of samples at a rate, and one where the test stops, no sooner than half a step after."""
    steps = max(1, math.floor(duration * rate + 0.5))
    return np.append(np.arange(steps) / rate, duration)


def _length(true: Quantity, spread: Quantity, rng: Generator) -> Quantity:
    """Draw a depth or a width measured; none is below zero."""
    found = measured(true.value, spread.value, rng)
    return found.model_copy(update={"value": max(found.value, 0.0)})


def _volume(true: Quantity, share: Quantity, rng: Generator) -> Quantity:
    """Draw a volume measured, stated with an uncertainty that is a share of what was found; none is below zero."""
    found = max(true.value * (1 + share.value * float(rng.standard_normal())), 0.0)
    return Quantity(value=found, unit=true.unit, standard_uncertainty=share.value * found)


_WRITTEN: Layout = {
    "time": Written("Time [s]", "s", "s", 1),
    "rotations": Written("Rotations [-]", "1", "1", 0),
    "depth": Written("Depth [um]", "m", "um", 3),
    "friction_force": Written("Ff [mN]", "N", "mN", 2),
    "normal_force": Written("Fn [mN]", "N", "mN", 2),
}
_MEASURED_BY = {  # end value -> unit in the file, method
    f"{disc}_{name}": by
    for disc in ("curved_disc", "flat_disc")
    for name, by in (
        ("wear_depth", ("nm", "stylus")),
        ("track_width", ("um", "optical microscope")),
        ("wear_volume", ("mm^3", "white-light")),
    )
}


def simulate_twin_disc_run(series: TwinDiscSeries, run: TwinDiscVirtualRun, folder: Path) -> TwinDiscTruth:
    """Write a run folder: run.toml, signals.csv and truth.json. Raises ``ContactError`` where the wear is too much."""
    test = VirtualTwinDiscTest(series, run)
    columns, ends = test.record()
    truth = test.truth()
    write_run(folder, _WRITTEN, columns, _manifest(series, run, ends), truth)
    return truth


def _manifest(series: TwinDiscSeries, run: TwinDiscVirtualRun, ends: dict[str, Quantity]) -> list[str]:
    curved, flat = series.contact.curved_disc, series.contact.flat_disc
    return [
        *manifest_head(run.id, run.started, series.title, "virtual twin-disc tribometer"),
        "[contact]",
        'kind = "twin-disc"',
        "",
        "[contact.curved_disc]",
        f"rolling_radius = {written(curved.rolling_radius, 'mm')}",
        f"crown_radius = {written(curved.crown_radius, 'mm')}",
        *_width(curved),
        *specimen(curved),
        "",
        "[contact.flat_disc]",
        f"rolling_radius = {written(flat.rolling_radius, 'mm')}",
        *_width(flat),
        *specimen(flat),
        "",
        "[conditions]",
        f"normal_load = {written(series.load_of(run), 'mN')}",
        f"curved_disc_speed = {written(series.curved_disc_speed, 'mm/s')}",
        f"slip = {written(run.slip, '%')}",
        f"rotations = {run.rotations:.0f}",
        f"medium = {quoted(series.medium)}",
        "",
        *manifest_tail(_WRITTEN, ends, _MEASURED_BY, series.depth_scale),
    ]


def _width(disc: CurvedDisc | FlatDisc) -> list[str]:
    return [] if disc.width is None else [f"width = {written(disc.width, 'mm')}"]

"""A virtual twin-disc tribometer.

Depth is the wear of both discs by the exact model, offset, linear drift and correlated noise, digitised; rotations are
counted on the crowned disc. Worn volumes, depths and track widths are drawn about their true values with their stated
uncertainty; so are load, radii, moduli, slip and sensor scale where a series has systematic errors, its manifests
stating what was meant. Under Sarkar's law a rotation counts S(s)/s times, s being the slip distance. What two discs go
through depends on k_D and rotations by their product alone, so a rotation under fatigue counts as often as fatigue
multiplies k_D.
"""

import math

import numpy as np
from numpy.random import Generator

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError
from tribopipe.contacts.twin_disc import disc_pair
from tribopipe.documents.plan import TwinDiscSeries, TwinDiscTruth, TwinDiscVirtualRun
from tribopipe.documents.quantity import Quantity
from tribopipe.extras.simulate.instrument import AnyVirtualTest, Layout, Written, measured, systematic_errors, written

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


class VirtualTwinDiscTest(AnyVirtualTest):
    """One virtual run of two discs."""

    series: TwinDiscSeries
    run: TwinDiscVirtualRun
    instrument = "virtual twin-disc tribometer"
    layout = _WRITTEN
    measured_by = _MEASURED_BY

    def __init__(self, series: TwinDiscSeries, run: TwinDiscVirtualRun) -> None:
        super().__init__(series, run)
        self.load = series.load_of(run)
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
        self.distance = self.rotations * self.slip_per_rotation
        try:
            self.state = disc_pair(contact, self.values, series.distance_per_rotation).worn(
                self._effective(self.rotations), run.curved_wear_coefficient.value, run.flat_wear_coefficient.value
            )
        except ContactError as error:
            raise ContactError(f"{run.id}: {error}") from None

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
            **self.told(),
            distance_per_rotation=self.series.distance_per_rotation,
            curved_wear_coefficient=run.curved_wear_coefficient,
            flat_wear_coefficient=run.flat_wear_coefficient,
            fatigue=run.fatigue,
            end_curved_wear_depth=Quantity(value=float(state.curved_depth[-1]), unit="m"),
            end_flat_wear_depth=Quantity(value=float(state.flat_depth[-1]), unit="m"),
            end_curved_wear_volume=Quantity(value=float(state.curved_volume[-1]), unit="m^3"),
            end_flat_wear_volume=Quantity(value=float(state.flat_volume[-1]), unit="m^3"),
            end_track_width=Quantity(value=2 * float(state.half_width[-1]), unit="m"),
        )

    @property
    def displacement(self) -> Column:
        """Displacement by the wear of both discs, as the sensor reads it, m."""
        return (self.state.curved_depth + self.state.flat_depth) / self.depth_scale

    @property
    def loads(self) -> tuple[float, float]:
        """Normal load, N: the true one and the nominal one."""
        return self.values["normal_load"], self.load.value

    @property
    def counted(self) -> dict[str, Column]:
        """The rotations of the crowned disc."""
        return {"rotations": self.rotations}

    @property
    def conditions(self) -> dict[str, str]:
        """The conditions, but for the medium, as run.toml has them."""
        return {
            "normal_load": written(self.load, "mN"),
            "curved_disc_speed": written(self.series.curved_disc_speed, "mm/s"),
            "slip": written(self.run.slip, "%"),
            "rotations": f"{self.run.rotations:.0f}",
        }

    def end_values(self, rng: Generator) -> dict[str, Quantity]:
        """Draw the post-test measurements."""
        sensors = self.series.sensors
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

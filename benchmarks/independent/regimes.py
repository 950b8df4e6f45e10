"""The runs that are simulated: sound ones, faulty ones, and grids of disturbances."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np
from numpy.random import Generator

from independent.noise import Autoregressive, Column, Noise, Pink, Walk, White
from independent.wear import Shape

Group = Literal["sound", "fault", "grid", "corner"]
_STICK_SLIP = Autoregressive(0.02, 0.5)
Disturbance = Callable[[Generator, Column], Column]
"""What is added to the depth, m, at times in s."""
EndValue = Literal["pin_scar_diameter", "pin_scar_length", "pin_wear_depth", "pin_mass_loss"]


class Body(NamedTuple):
    """A material, SI."""

    material: str
    modulus: float
    ratio: float
    density: float


class Anchor(NamedTuple):
    """What is measured on the pin after the test."""

    name: EndValue
    spread: float
    """Standard uncertainty, m; of a mass a share of it."""
    misread: float = 1.0
    """Factor by which it is entered wrong."""


class Friction(NamedTuple):
    """μ(s) = A·exp(−s/c) + b."""

    amplitude: float
    steady: float
    running_in: float

    def at(self, distance: Column) -> Column:
        """Return μ at distances, m."""
        return np.asarray(self.amplitude * np.exp(-distance / self.running_in) + self.steady)


class Stroke(NamedTuple):
    """A reciprocating motion."""

    length: float
    frequency: float


class Change(NamedTuple):
    """k changes by a factor after a share of the distance."""

    after: float
    factor: float


@dataclass(frozen=True)
class Regime:
    """One kind of run; what a laboratory states is its nominal value with `UNCERTAIN` as its uncertainty."""

    name: str
    pin: Body
    disc: Body
    radius: float
    load: float
    speed: float
    distance: float
    rate: float
    """Samples per second."""
    coefficient: float
    """k_D, m²/N."""
    anchor: Anchor
    friction: Friction
    noise: tuple[Noise, ...]
    group: Group = "sound"
    shape: Shape = "spherical"
    law: Literal["archard", "sarkar"] = "archard"
    friction_noise: Autoregressive = _STICK_SLIP
    disc_wear: tuple[float, float] | None = None
    """Depth at the end and the standard uncertainty of its measurement, m."""
    disc_stated: bool = True
    stroke: Stroke | None = None
    disturbance: Disturbance | None = None
    change: Change | None = None
    load_error: float = 0.0
    """Share by which the load is off the nominal one beyond what is stated."""
    load_channel: bool = True
    drift: float = 15e-9 / 60
    """Drift rates are uniform between minus this and this, m/s."""
    ideal: bool = True
    """Whether drift is a line and noise is all there is besides, so that an ideal estimator is defined."""

    @property
    def duration(self) -> float:
        """Length of the test, s."""
        return self.distance / self.speed

    @property
    def both_wear(self) -> bool:
        """Whether the disc wears as well, by more than those of the paper, and its wear was measured."""
        return self.disc_stated and self.disc_wear is not None and self.disc_wear[0] > UM

    @property
    def samples(self) -> int:
        """Number of samples."""
        return round(self.duration * self.rate) + 1


UNCERTAIN = {"load": 0.01, "radius": 0.002, "pin_modulus": 0.02, "disc_modulus": 0.02, "speed": 0.005, "scale": 0.005}
"""Relative standard uncertainties that every run.toml states, and by which every run is off."""
UM = 1e-6
_UNWORN = (0.0, 0.02 * UM)
"""A disc that was looked at and has not worn."""
_SILICON_NITRIDE = Body("Si3N4", 304e9, 0.24, 3200.0)
_CARBIDE_PIN, _CARBIDE_DISC = Body("WC-Co", 320e9, 0.24, 15000.0), Body("WC-Co", 305e9, 0.24, 14100.0)
_STEEL = Body("100Cr6", 210e9, 0.3, 7800.0)
_PEEK = Body("PEEK", 3.6e9, 0.38, 1300.0)
_PTFE = Body("PTFE", 0.6e9, 0.46, 2200.0)
_USUAL = (White(0.05 * UM), Autoregressive(0.1 * UM, 0.5))

SI3N4 = Regime(
    name="Si3N4",
    pin=_SILICON_NITRIDE,
    disc=_SILICON_NITRIDE,
    radius=0.794e-3,
    load=0.2,
    speed=0.4,
    distance=500.0,
    rate=10.0,
    coefficient=1.35e-14,
    anchor=Anchor("pin_scar_diameter", 2 * UM),
    friction=Friction(0.226, 0.496, 32.877),
    noise=_USUAL,
    disc_wear=(0.12 * UM, 0.02 * UM),
)
WC_CO = replace(
    SI3N4,
    name="WC-Co by scar",
    pin=_CARBIDE_PIN,
    disc=_CARBIDE_DISC,
    load=0.4,
    coefficient=0.75e-17,
    friction=Friction(0.14, 0.21, 45.0),
    disc_wear=_UNWORN,
)
STEEL = replace(
    SI3N4,
    name="steel ball 5 N",
    pin=_STEEL,
    disc=_STEEL,
    radius=3e-3,
    load=5.0,
    speed=0.1,
    distance=1000.0,
    rate=2.0,
    coefficient=4.8e-16,
    anchor=Anchor("pin_scar_diameter", 3 * UM),
    friction=Friction(0.23, 0.62, 60.0),
    friction_noise=Autoregressive(0.015, 2.0),
    noise=(White(0.3 * UM), Autoregressive(0.2 * UM, 5.0)),
    disc_wear=(2.0 * UM, 0.1 * UM),
)
_RECIPROCATING = replace(
    STEEL,
    name="reciprocating",
    load=10.0,
    speed=2 * 10e-3 * 1.0,
    distance=36.0,
    rate=20.0,
    coefficient=6.5e-16,
    # ASTM G133 has both length and width measured; beside a groove the length alone tells the depth.
    anchor=Anchor("pin_scar_length", 3 * UM),
    friction=Friction(0.25, 0.40, 2.5),
    friction_noise=Autoregressive(0.02, 0.3),
    noise=(White(0.2 * UM), Autoregressive(0.1 * UM, 5.0)),
    disc_wear=(2.0 * UM, 0.1 * UM),
    stroke=Stroke(10e-3, 1.0),
)


def _sound() -> Iterator[Regime]:
    yield SI3N4
    yield replace(SI3N4, name="Si3N4, Sarkar", law="sarkar")
    yield WC_CO
    yield replace(WC_CO, name="WC-Co, ±250 nm", anchor=Anchor("pin_wear_depth", 0.25 * UM))
    yield replace(WC_CO, name="WC-Co, Sarkar", law="sarkar")
    yield STEEL
    yield replace(
        STEEL,
        name="polymer",
        pin=_PEEK,
        load=10.0,
        rate=1.0,
        coefficient=6e-15,
        anchor=Anchor("pin_scar_diameter", 10 * UM),
        friction=Friction(-0.12, 0.35, 90.0),
        disc_wear=_UNWORN,
    )
    yield replace(SI3N4, name="5 m", speed=0.05, distance=5.0, friction=Friction(0.226, 0.496, 0.5), disc_wear=_UNWORN)
    yield replace(SI3N4, name="60 samples", rate=59 / SI3N4.duration)
    yield replace(SI3N4, name="noise 1 µm", noise=(White(1 * UM), Autoregressive(1 * UM, 2.0)))
    yield replace(SI3N4, name="mass loss ±20 %", anchor=Anchor("pin_mass_loss", 0.2))
    yield _RECIPROCATING
    yield replace(
        STEEL,
        name="flat pin",
        pin=_PTFE,
        shape="flat",
        radius=1.5e-3,
        load=20.0,
        coefficient=1.8e-14,
        anchor=Anchor("pin_wear_depth", 1.5 * UM),
        disc_wear=None,
    )


def _settling(amplitude: float, share: float) -> Disturbance:
    """Return an exponential settling with a time constant that is a share of the test."""
    return lambda _, time: np.asarray(amplitude * -np.expm1(-time / (share * time[-1])))


def _sine(amplitude: float) -> Disturbance:
    def wave(rng: Generator, time: Column) -> Column:
        period, phase = rng.uniform(0.3, 1.0) * time[-1], rng.uniform(0, 2 * np.pi)
        return np.asarray(amplitude * np.sin(2 * np.pi * time / period + phase))

    return wave


def _step(height: float) -> Disturbance:
    def jump(rng: Generator, time: Column) -> Column:
        return np.asarray(rng.choice([-height, height]) * (time > rng.uniform(0.1, 0.9) * time[-1]))

    return jump


def _spikes(share: float, height: float) -> Disturbance:
    def spikes(rng: Generator, time: Column) -> Column:
        return np.asarray((rng.random(len(time)) < share) * height * rng.standard_normal(len(time)))

    return spikes


def _faults() -> Iterator[Regime]:
    silicon = replace(SI3N4, group="fault", ideal=False)
    carbide = replace(WC_CO, group="fault", ideal=False)
    pink, walk = Pink(0.1 * UM), Walk(0.3 * UM)
    yield replace(carbide, name="WC-Co, warm-up 0.5 µm", disturbance=_settling(0.5 * UM, 0.2))
    yield replace(silicon, name="Si3N4, warm-up 1 µm", disturbance=_settling(1 * UM, 0.2))
    yield replace(silicon, name="disc wear 5 µm unstated", disc_wear=(5 * UM, 0.0), disc_stated=False)
    yield replace(silicon, name="k doubles half way", change=Change(0.5, 2.0))
    yield replace(silicon, name="k falls to a third", change=Change(0.1, 1 / 3))
    yield replace(silicon, name="sine ±0.5 µm", disturbance=_sine(0.5 * UM))
    yield replace(silicon, name="step 1 µm", disturbance=_step(1 * UM))
    yield replace(silicon, name="spikes", disturbance=_spikes(0.002, 5 * UM))
    yield replace(silicon, name="1/f noise 0.1 µm", noise=(*_USUAL, pink), ideal=True)
    yield replace(silicon, name="random walk", noise=(*_USUAL, walk), ideal=True)
    yield replace(carbide, name="WC-Co, 1/f", noise=(*_USUAL, pink), ideal=True)
    yield replace(carbide, name="WC-Co, random walk", noise=(*_USUAL, walk), ideal=True)
    yield replace(silicon, name="load 5 % off, channel", load_error=0.05)
    yield replace(silicon, name="load 5 % off, no channel", load_error=0.05, load_channel=False)
    yield replace(silicon, name="scar radius for diameter", anchor=Anchor("pin_scar_diameter", 2 * UM, misread=0.5))


_TURN = 0.1 / (2 * np.pi * 5e-3)
"""Turns per second at 0.1 m/s on a track of 5 mm."""
_CYCLE = 2.3
"""Cycles per second of a reciprocating test; no multiple of 1 Hz, at which it is sampled."""


def _thermal(settling: float, runout: float, turn: float) -> Disturbance:
    def moved(rng: Generator, time: Column) -> Column:
        constant, phase = 60 * rng.uniform(10, 40), rng.uniform(0, 2 * np.pi)
        turning = runout * np.sin(2 * np.pi * turn * time + phase)
        return np.asarray(turning - settling * np.expm1(-time / constant))

    return moved


def _grid() -> Iterator[Regime]:
    """Yield thermal settling × runout × sampling × motion, in tests of 40 minutes."""
    noise = (White(0.5 * UM), Autoregressive(0.1 * UM, 2.0))
    base = replace(STEEL, group="grid", noise=noise, distance=240.0, coefficient=2e-15, disc_wear=_UNWORN, ideal=False)
    stroke = Stroke(20e-3, _CYCLE)
    speed = 2 * stroke.length * stroke.frequency
    there_and_back = replace(base, stroke=stroke, speed=speed, distance=speed * 2400.0, coefficient=2e-15 * 0.1 / speed)
    for settling in (0, 1, 3, 10):
        for runout in (0, 10):
            for rate in (1.0, 100.0):
                for motion, one, turn in (("pin", base, _TURN), ("reciprocating", there_and_back, _CYCLE)):
                    name = f"settling {settling} µm, runout {runout} µm, {rate:g} Hz, {motion}"
                    moved = _thermal(settling * UM, runout * UM, turn)
                    yield replace(one, name=name, rate=rate, disturbance=moved)


def _corner(runout: float, wobble: float) -> Disturbance:
    def moved(rng: Generator, time: Column) -> Column:
        slow = wobble * np.sin(2 * np.pi * time / 5400.0 + rng.uniform(0, 2 * np.pi))
        return np.asarray(slow + runout * np.sin(2 * np.pi * _TURN * time + rng.uniform(0, 2 * np.pi)))

    return moved


def _corners() -> Iterator[Regime]:
    """Yield runout × slow wobble on a steel ball that wears 5 µm in three hours."""
    base = replace(STEEL, group="corner", rate=10.0, coefficient=4.8e-17, disc_wear=_UNWORN, ideal=False)
    for runout in (0.0, 6.0):
        for wobble in (0.0, 0.7):
            name = f"runout {runout:g} µm, wobble {wobble:g} µm"
            yield replace(base, name=name, disturbance=_corner(runout * UM, wobble * UM))


REGIMES: dict[str, Regime] = {one.name: one for part in (_sound, _faults, _grid, _corners) for one in part()}
"""All regimes by name."""

"""One run of a regime: what was true, what its instrument recorded, and what its laboratory wrote down."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.random import Generator

from independent.noise import Column
from independent.regimes import UNCERTAIN, Friction, Regime
from independent.wear import Tip, disc_growth, less_deep, scar_diameter

_OFFSETS = (0.5e-6, 2.5e-6)
_STEP = 1e-8
"""Depth, m, to which readings are rounded."""
_LOAD_NOISE = 0.002
_COARSE = 300
"""Places at which a pin beside a groove is worn; between them its ratio to a pin on a plane is interpolated."""
_PER_CYCLE = 8
"""Samples per cycle from which the sign of reciprocating friction is recorded."""
Errors = Mapping[str, float]
"""Relative errors of the inputs by the names of `UNCERTAIN`; an input that is not there is as stated."""


@dataclass(frozen=True)
class Truth:
    """What a run was made from."""

    coefficient: float
    """Mean k_D over the run, m²/N."""
    friction: Friction
    drift: float
    """Of true displacement, m/s."""
    end_depth: float
    """Wear depth of the pin, m."""


@dataclass(frozen=True)
class Recorded:
    """A run as it leaves the laboratory."""

    document: dict[str, Any]
    """run.toml as a user writes it, with units."""
    columns: dict[str, Column]
    """What was recorded, by tribopipe's names of signals, SI."""
    truth: Truth


@dataclass(frozen=True)
class Course:
    """The wear of one run, without noise, offset and drift."""

    time: Column
    distance: Column
    shown: Column
    """Depth of pin and disc by the sensor, m."""
    anchor: float
    """What a perfect measurement of the pin would give, SI."""
    end_depth: float
    mean_factor: float
    """Mean k_D over the one at the start."""


def course(regime: Regime, errors: Errors, coefficient: float, disc: float) -> Course:
    """Return the wear of a pin with a true ``coefficient`` and of a disc with a true depth at the end."""
    off = {name: 1 + errors.get(name, 0.0) for name in UNCERTAIN}
    time = np.arange(regime.samples) / regime.rate
    distance = regime.speed * off["speed"] * time
    load = regime.load * (1 + regime.load_error) * off["load"]
    # Where both bodies wear, volumes are those of the shapes; the paper's elastic approach is for a disc that does not.
    modulus = np.inf if regime.both_wear else _contact_modulus(regime, off)
    tip = Tip(regime.shape, regime.radius * off["radius"], load, modulus)
    effective, factor = _effective(regime, distance)
    volume = coefficient * load * effective
    coarse = np.unique(np.linspace(0, len(distance) - 1, min(len(distance), _COARSE)).astype(int))
    grown = disc * disc_growth(tip.worn(volume).contact, distance) if disc else np.zeros_like(distance)
    beside = less_deep(tip, volume[coarse], grown[coarse])
    depth = tip.worn(volume).depth * np.interp(distance, distance[coarse], beside)
    end = float(depth[-1])
    anchor = _anchor(regime, tip, end, float(grown[-1]), float(volume[-1]))
    return Course(time, distance, (depth + grown) / off["scale"], anchor, end, factor)


def _contact_modulus(regime: Regime, off: Mapping[str, float]) -> float:
    if regime.shape == "flat":
        return float("inf")
    bodies = ((regime.pin, off["pin_modulus"]), (regime.disc, off["disc_modulus"]))
    return 1 / sum((1 - body.ratio**2) / (body.modulus * factor) for body, factor in bodies)


def _effective(regime: Regime, distance: Column) -> tuple[Column, float]:
    """Return ∫f·(k/k_0) ds, m, and the mean of k/k_0."""
    factor = np.ones_like(distance)
    if regime.law == "sarkar":
        factor = np.sqrt(1 + 3 * regime.friction.at(distance) ** 2)
    plain = _integral(factor, distance)
    if regime.change is None:
        return plain, 1.0
    before = np.minimum(plain, np.interp(regime.change.after * distance[-1], distance, plain))
    changed = before + regime.change.factor * (plain - before)
    return changed, float(changed[-1] / plain[-1])


def _integral(values: Column, over: Column) -> Column:
    return np.concatenate([[0.0], np.cumsum((values[1:] + values[:-1]) / 2 * np.diff(over))])


def _anchor(regime: Regime, tip: Tip, depth: float, groove: float, volume: float) -> float:
    if regime.anchor.name == "pin_scar_length":
        return tip.scar(depth)
    if regime.anchor.name == "pin_scar_diameter":
        return scar_diameter(tip, depth, groove)
    lost = volume if groove else tip.volume(depth)
    return lost * regime.pin.density if regime.anchor.name == "pin_mass_loss" else depth


def anchor_spread(regime: Regime, measured: float) -> float:
    """Return the standard uncertainty of what is measured on the pin, SI."""
    return regime.anchor.spread * (measured if regime.anchor.name == "pin_mass_loss" else 1.0)


def simulate(regime: Regime, rng: Generator) -> Recorded:
    """Draw one run."""
    errors = {name: share * float(rng.standard_normal()) for name, share in UNCERTAIN.items()}
    disc = (0.0, 0.0) if regime.disc_wear is None else regime.disc_wear
    worn = course(regime, errors, regime.coefficient, disc[0])
    offset, drift = rng.uniform(*_OFFSETS), rng.uniform(-regime.drift, regime.drift)
    depth = offset + drift * worn.time + worn.shown + _noise(regime, rng)
    if regime.disturbance is not None:
        depth = depth + regime.disturbance(rng, worn.time)
    forces = _forces(regime, worn, errors, rng)
    truth = Truth(
        coefficient=regime.coefficient * worn.mean_factor,
        friction=regime.friction,
        drift=drift * (1 + errors["scale"]),
        end_depth=worn.end_depth,
    )
    columns = {"time": worn.time, "depth": np.round(depth / _STEP) * _STEP, **forces}
    return Recorded(_document(regime, _end_values(regime, worn, disc, rng)), columns, truth)


def _noise(regime: Regime, rng: Generator) -> Column:
    drawn = [noise.draw(rng, regime.samples, 1 / regime.rate) for noise in regime.noise]
    return np.asarray(np.sum(drawn, axis=0))


def _forces(regime: Regime, worn: Course, errors: Errors, rng: Generator) -> dict[str, Column]:
    """Return what the force sensors recorded; a load cell is off by the error of the load."""
    jitter = 1 + _LOAD_NOISE * rng.standard_normal(regime.samples)
    pressed = regime.load * (1 + regime.load_error) * jitter
    mu = regime.friction.at(worn.distance) + regime.friction_noise.draw(rng, regime.samples, 1 / regime.rate)
    rubbing = mu * pressed * (1 + errors["load"])
    if regime.stroke is not None and regime.rate >= _PER_CYCLE * regime.stroke.frequency:
        rubbing = rubbing * np.sign(np.cos(2 * np.pi * regime.stroke.frequency * worn.time + 1e-3))
    return {"normal_force": pressed, "friction_force": rubbing} if regime.load_channel else {"friction_force": rubbing}


def _end_values(regime: Regime, worn: Course, disc: tuple[float, float], rng: Generator) -> dict[str, Any]:
    anchor, spread = regime.anchor, anchor_spread(regime, worn.anchor)
    unit = "kg" if anchor.name == "pin_mass_loss" else "m"
    # Nobody writes down that a pin has grown.
    measured = max(worn.anchor + spread * rng.standard_normal(), 0.0) * anchor.misread
    found: dict[str, Any] = {anchor.name: stated(measured, spread, unit)}
    if regime.disc_wear is not None and regime.disc_stated:
        found["disc_wear_depth"] = stated(max(disc[0] + disc[1] * rng.standard_normal(), 0.0), disc[1], "m")
    return found


def stated(value: float, spread: float, unit: str) -> dict[str, Any]:
    """Return a quantity as it stands in a run.toml."""
    if unit == "1":
        return {"value": float(value), "standard_uncertainty": float(spread)}
    return {"value": f"{float(value)!r} {unit}", "standard_uncertainty": f"{float(spread)!r} {unit}"}


def _document(regime: Regime, end_values: dict[str, Any]) -> dict[str, Any]:
    def within(name: str, value: float, unit: str) -> dict[str, Any]:
        return stated(value, UNCERTAIN[name] * value, unit)

    if regime.stroke is None:
        motion = {"sliding_speed": within("speed", regime.speed, "m/s")}
    else:
        stroke = within("speed", regime.stroke.length, "m")
        motion = {"stroke": stroke, "frequency": stated(regime.stroke.frequency, 0.0, "Hz")}
    contact: dict[str, Any] = {"kind": "pin-on-disc", "pin": {}, "disc": {}}
    for name, body in (("pin", regime.pin), ("disc", regime.disc)):
        contact[name] = {
            "material": body.material,
            "youngs_modulus": within(f"{name}_modulus", body.modulus, "Pa"),
            "poisson_ratio": body.ratio,
            "density": stated(body.density, 1e-6 * body.density, "kg/m^3"),
        }
    contact["pin"] |= {"shape": regime.shape, "radius": within("radius", regime.radius, "m")}
    return {
        "schema": "tribopipe.run/1",
        "id": "simulated",
        "contact": contact,
        "conditions": {"normal_load": within("load", regime.load, "N"), **motion},
        "signals": [{"file": "signals.csv"}],
        "sensors": {"depth_scale": within("scale", 1.0, "1")},
        "end_values": end_values,
    }

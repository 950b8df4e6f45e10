"""Three recordings as ordinary laboratories write them: ball on disc, reciprocating ball, and three replicates.

Each case returns its runs with their truth; `bench_files.py` writes the files. Depth is pin + disc + thermal settling +
day cycle + runout + noise + offset. The scar diameter is the mean of length and width.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.random import Generator

from independent.noise import Autoregressive
from independent.regimes import Friction
from independent.runs import Recorded, Truth, stated
from independent.wear import Tip, both_worn, less_deep, scar_diameter

_RADIUS = 3e-3
_UM = 1e-6
_SETTLING, _DAY = 2400.0, 5400.0
"""Time constant of settling and period of the day cycle, s."""
_SCAR = 3 * _UM
_KELVIN = 273.15


def ball_on_disc(rng: Generator) -> list[Recorded]:
    """Return case a: steel ball, 5 N, 1000 m at 50 Hz; post-test scar ± 3 µm and disc cross-section ± 2 %."""
    return [_rotating(rng, 5.0, 1000.0, 5e-3, 50.0, 4.8e-16, 5e-15, section=0.02)]


def replicates(rng: Generator) -> list[Recorded]:
    """Return case c: steel ball, 10 N, 360 m at 10 Hz, three times; post-test scars ± 3 µm."""
    coefficients = 4.8e-16 * (1 + 0.12 * rng.standard_normal(3))
    return [_rotating(rng, 10.0, 360.0, 6e-3, 10.0, float(k), 2e-16, section=None) for k in coefficients]


def _rotating(
    rng: Generator,
    load: float,
    distance: float,
    track: float,
    rate: float,
    coefficient: float,
    disc_coefficient: float,
    *,
    section: float | None,
) -> Recorded:
    speed, path = 0.1, 2 * np.pi * track
    time = np.arange(round(distance / speed * rate) + 1) / rate
    slid, count = speed * time, len(time)
    worn = both_worn(_RADIUS, disc_coefficient / coefficient, path, coefficient * load * slid)
    turns, phase = 2 * np.pi * speed / path * time, rng.uniform(0, 2 * np.pi)
    day = np.sin(2 * np.pi * time / _DAY)
    warm = -np.expm1(-time / _SETTLING)
    disturbed = _UM * (6 * warm + 0.7 * day + 6 * np.sin(turns + phase) + 0.8 * rng.standard_normal(count))
    pressed = load * (1 + 0.03 * np.sin(turns + phase + 1) + 0.01 * rng.standard_normal(count))
    friction = Friction(0.23, 0.62, 60.0)
    mu = friction.at(slid) + Autoregressive(0.015, 2.0).draw(rng, count, 1 / rate)
    ends = _scar(float(worn.ball[-1]), float(worn.groove[-1]), rng)
    if section is not None:
        volume = disc_coefficient * load * slid[-1]
        ends["disc_wear_volume"] = stated(volume * (1 + section * rng.standard_normal()), section * volume, "m^3")
    columns = {
        "time": time,
        "sliding_distance": slid,
        "friction_coefficient": mu,
        "normal_force": pressed,
        "depth": worn.ball + worn.groove + disturbed + rng.uniform(5, 50) * _UM,
        "temperature": _KELVIN + 22.5 + 3.5 * warm + 0.4 * day + 0.05 * rng.standard_normal(count),
    }
    motion = {"sliding_speed": f"{speed} m/s", "sliding_distance": f"{distance} m", "track_radius": f"{track} m"}
    truth = Truth(coefficient, friction, 0.0, float(worn.ball[-1]))
    return Recorded(_document(load, motion, ends), columns, truth)


def reciprocating(rng: Generator) -> list[Recorded]:
    """Return case b: steel ball, 10 N, stroke 20 mm at 2 Hz for 1800 s at 100 Hz; scar ± 3 µm, groove ± 0.2 µm."""
    load, half, frequency, rate, coefficient = 10.0, 10e-3, 2.0, 100.0, 2.0e-16
    time = np.arange(round(1800 * rate) + 1) / rate
    slid, cycle, count = 4 * half * frequency * time, 2 * np.pi * frequency * time, len(time)
    tip = Tip("spherical", _RADIUS, load, np.inf)
    groove = 4 * _UM * (slid / slid[-1]) ** 0.7
    some = np.linspace(0, count - 1, 400).astype(int)
    plane = tip.worn(coefficient * load * slid).depth
    less = less_deep(tip, coefficient * load * slid[some], groove[some])
    ball = plane * np.interp(slid, slid[some], less)
    disturbed = 1.2 * -np.expm1(-time / 600) + 2 * np.sin(cycle + 0.7) + 0.3 * rng.standard_normal(count)
    pressed = load + 0.2 * np.sin(cycle + 0.3) + 0.05 * rng.standard_normal(count)
    friction = Friction(0.25, 0.12, 8.0)
    mu = friction.at(slid) + Autoregressive(0.01, 1.0).draw(rng, count, 1 / rate)
    columns = {
        "time": time,
        "position": half * np.sin(cycle),
        "friction_force": mu * pressed * np.sign(np.cos(cycle + 1e-6)) + 0.11,
        "normal_force": pressed,
        "depth": ball + groove + disturbed * _UM + rng.uniform(5, 50) * _UM,
    }
    ends = _scar(float(ball[-1]), float(groove[-1]), rng)
    ends["disc_wear_depth"] = stated(4 * _UM + 0.2 * _UM * rng.standard_normal(), 0.2 * _UM, "m")
    motion = {"stroke": f"{2 * half} m", "frequency": f"{frequency} Hz"}
    truth = Truth(coefficient, friction, 0.0, float(ball[-1]))
    return [Recorded(_document(load, motion, ends), columns, truth)]


CASES: Mapping[str, Callable[[Generator], list[Recorded]]] = {
    "a: ball on disc": ball_on_disc,
    "b: reciprocating": reciprocating,
    "c: three replicates": replicates,
}
"""The cases by name."""


def _scar(depth: float, groove: float, rng: Generator) -> dict[str, Any]:
    diameter = scar_diameter(Tip("spherical", _RADIUS, 1.0, np.inf), depth, groove)
    return {"pin_scar_diameter": stated(diameter + _SCAR * rng.standard_normal(), _SCAR, "m")}


def _document(load: float, motion: dict[str, str], ends: dict[str, Any]) -> dict[str, Any]:
    steel = {"material": "100Cr6", "youngs_modulus": "210 GPa", "poisson_ratio": 0.3}
    return {
        "schema": "tribopipe.run/1",
        "id": "bench",
        "contact": {
            "kind": "pin-on-disc",
            "pin": {"shape": "spherical", "radius": "3 mm"} | steel,
            "disc": dict(steel),
        },
        "conditions": {"normal_load": f"{load} N", **motion},
        "signals": [{"file": "signals.csv"}],
        "end_values": ends,
    }

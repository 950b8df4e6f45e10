"""How often intervals of k_D by wear volume hold it, of either body of every contact.

    python benchmarks/contact_volumes.py --labs 1000 --write docs/results/contact_volumes.md

Each laboratory tests one pair of bodies with true coefficients of its own, under a load, with radii and a path that are
off within what its run.toml states, and measures scars, tracks, volumes and masses with errors drawn from what it
states of them. Where a ball lies in a groove, both shapes are found slice by slice; where not, closed formulas are
solved for the scar. Nothing of that is shared with tribopipe.
"""

import zlib
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from independent.wear import Outline, scar_outline
from labs import Report, arguments, in_parallel, share
from numpy.random import Generator
from scipy.optimize import brentq

from tribopipe.base.arrays import Column
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.recipe import MonteCarloRecipe, Recipe
from tribopipe.documents.signals import SignalName
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.results.run import RawRun

_LOAD, _RADIUS, _PATH, _DENSITY = 0.01, 0.001, 0.005, 0.005
"""Relative standard uncertainties that every laboratory states."""
_SCAR = 5e-6
"""m, of the microscope."""
_ENDS = 0.9
"""Length of both ends of a groove over half the length of the scar: strokes of 7 to 27 of these, cell by cell."""
_SPREAD = np.log(3.0)
"""Coefficients are between a third and three times the usual ones."""
_SOFT = {"youngs_modulus": "210 GPa", "poisson_ratio": 0.3}
FIRST_ORDER = Recipe(monte_carlo=MonteCarloRecipe(significant_digits=0))


class Lab(NamedTuple):
    """What one laboratory writes down, and what is true."""

    contact: dict[str, Any]
    conditions: dict[str, Any]
    ends: dict[str, Any]
    distance: float
    truth: dict[str, float]
    """k_D by body, m²/N."""


class Nominal(NamedTuple):
    """Draws what is true about what a laboratory states."""

    rng: Generator

    def off(self, value: float, relative: float) -> float:
        """Return a true value about a stated one."""
        return value * (1 + relative * float(self.rng.standard_normal()))

    def coefficient(self, usual: float) -> float:
        """Return a true coefficient."""
        return usual * float(np.exp(self.rng.uniform(-_SPREAD, _SPREAD)))

    def measured(self, true: float, spread: float, unit: str = "m") -> dict[str, Any]:
        """Return a measurement of a true value."""
        read = max(true + spread * float(self.rng.standard_normal()), 0.0)
        return {"value": read, "unit": unit, "standard_uncertainty": spread}

    def repeated(self, true: float, spread: float, count: int) -> dict[str, Any]:
        """Return readings of a true length that scatter, in µm."""
        readings = true + spread * self.rng.standard_normal(count)
        return {"values": [f"{1e6 * one:.2f} um" for one in readings], "standard_uncertainty": "0.5 um"}


def stated(value: float, relative: float, unit: str) -> dict[str, Any]:
    """Return a quantity with its standard uncertainty as run.toml states it."""
    return {"value": value, "unit": unit, "standard_uncertainty": relative * value}


def _ball_in_groove(draw: Nominal, kind: str) -> Lab:
    """Draw a ball whose counterbody wears as well: scar length and track width are measured."""
    reciprocating = kind == "reciprocating"
    load, distance, radius = (10.0, 400.0, 3e-3) if reciprocating else (5.0, 1000.0, 3e-3)
    path = 0.02 if reciprocating else 6e-3
    usual = (2e-14, 5e-14) if reciprocating else (1e-15, 4e-13)
    ball, track = (draw.coefficient(one) for one in usual)
    work = draw.off(load, _LOAD) * distance
    around = draw.off(path, _PATH) * (1 if reciprocating else 2 * np.pi)
    true_radius = draw.off(radius, _RADIUS)
    scar = Outline(0.0, 0.0)
    for _ in range(4 if reciprocating else 1):
        # The groove of a stroke is longer than it, by about half the length of the scar.
        longer = around + (_ENDS * scar.length if reciprocating else 0.0)
        scar = scar_outline(true_radius, track / ball / longer, ball * work)
    other = "flat" if reciprocating else "disc"
    pin = {"shape": "spherical", "radius": stated(radius, _RADIUS, "m"), "material": "ball", **_SOFT}
    key = "stroke" if reciprocating else "track_radius"
    return Lab(
        {"kind": kind, "pin": pin, other: {"material": "steel", **_SOFT}},
        {"normal_load": stated(load, _LOAD, "N"), key: stated(path, _PATH, "m")},
        {
            "pin_scar_length": draw.measured(2 * scar.length, _SCAR),
            f"{other}_track_width": draw.measured(2 * scar.width, _SCAR),
        },
        distance,
        {"pin": ball, other: track},
    )


def _block_on_ring(draw: Nominal, _: str) -> Lab:
    """Draw a block and its ring: the width of the scar is measured, and the ring is weighed."""
    load, distance, radius, width, density = 134.0, 586.0, 17.5e-3, 6.35e-3, 7850.0
    block, ring = draw.coefficient(5e-15), draw.coefficient(8e-16)
    work, true_radius = draw.off(load, _LOAD) * distance, draw.off(radius, _RADIUS)

    def lost(b: float) -> float:
        return float(
            width * (true_radius**2 * np.arcsin(b / 2 / true_radius) - b / 4 * np.sqrt(4 * true_radius**2 - b**2))
        )

    scar = brentq(lambda b: lost(b) - block * work, 1e-6, 1.9 * true_radius)
    mass = ring * work * draw.off(density, _DENSITY)
    return Lab(
        {
            "kind": "block-on-ring",
            "block": {"width": stated(width, 1e-4, "m"), "material": "bronze", **_SOFT},
            "ring": {
                "radius": stated(radius, _RADIUS, "m"),
                "material": "steel",
                "density": stated(density, _DENSITY, "kg/m^3"),
                **_SOFT,
            },
        },
        {"normal_load": stated(load, _LOAD, "N")},
        {"block_scar_width": draw.repeated(scar, 2 * _SCAR, 5), "ring_mass_loss": draw.measured(mass, 2e-8, "kg")},
        distance,
        {"block": block, "ring": ring},
    )


def _four_balls(draw: Nominal, _: str) -> Lab:
    """Draw four balls: six readings of scars, and the volume of the groove on the top ball."""
    load, distance, radius = 40.0, 1659.0, 6.35e-3
    ball, top = draw.coefficient(3e-16), draw.coefficient(3e-18)
    work = draw.off(load, _LOAD) / np.sqrt(6) * distance

    def lost(a: float) -> float:
        below = np.sqrt(radius**2 - a**2)
        return float(2 * np.pi * a**2 * (radius - below) - 4 * np.pi * (radius * a**2 / 2 - (radius**3 - below**3) / 3))

    scar = 2 * brentq(lambda a: lost(a) - ball * work, 1e-5, 0.9 * radius)
    groove = 3 * top * work
    return Lab(
        {"kind": "four-ball", "ball": {"diameter": stated(2 * radius, 1e-5, "m"), "material": "steel", **_SOFT}},
        {"normal_load": stated(load, _LOAD, "N")},
        {
            "ball_scar_diameter": draw.repeated(scar, _SCAR, 6),
            "top_ball_wear_volume": draw.measured(groove, 0.05 * groove, "m^3"),
        },
        distance,
        {"ball": ball, "top_ball": top},
    )


KINDS: dict[str, Callable[[Nominal, str], Lab]] = {
    "pin-on-disc": _ball_in_groove,
    "reciprocating": _ball_in_groove,
    "block-on-ring": _block_on_ring,
    "four-ball": _four_balls,
}


class Found(NamedTuple):
    """What was found of one body: whether the interval held, k_D and u over the truth."""

    kind: str
    body: str
    held: bool
    ratio: float
    relative: float


def outcomes(kind: str, seed: int) -> list[Found]:
    """Test one pair of bodies; a body without a k_D is not among them."""
    rng = np.random.default_rng(np.random.SeedSequence([seed, zlib.crc32(kind.encode())]))
    lab = KINDS[kind](Nominal(rng), kind)
    distance = np.linspace(0.0, lab.distance, 20)
    manifest = RunManifest.model_validate(
        {
            "schema": "tribopipe.run/1",
            "id": "lab",
            "contact": lab.contact,
            "conditions": lab.conditions,
            "signals": [{"file": "none.csv"}],
            "end_values": lab.ends,
        }
    )
    columns: dict[SignalName, Column] = {"time": distance.copy(), "sliding_distance": distance}
    run = RawRun(manifest, columns, dict.fromkeys(columns, "measured"), {}, {}, ())
    found = []
    for body, one in fit_wear(run, "archard", recipe=FIRST_ORDER).bodies.items():
        true, (low, high) = lab.truth[body], one.interval
        k = one.wear_coefficient
        held = low.value <= true <= high.value
        found.append(Found(kind, body, held, k.value / true, (k.standard_uncertainty or 0.0) / k.value))
    return found


def both(seed: int) -> list[Found]:
    """Test one pair of each contact."""
    return [found for kind in KINDS for found in outcomes(kind, seed)]


def main(words: Sequence[str] | None = None) -> None:
    """Count how often intervals hold."""
    options = arguments(__doc__ or "", labs=1000).parse_args(words)
    report = Report("k_D of either body by wear volume", options)
    seeds = range(options.first_seed, options.first_seed + options.labs)
    answers = [found for part in in_parallel(both, seeds, options) for found in part]
    rows = []
    for kind, body in dict.fromkeys((found.kind, found.body) for found in answers):
        of = [found for found in answers if (found.kind, found.body) == (kind, body)]
        bias = float(np.mean([found.ratio for found in of])) - 1
        spread = float(np.median([found.relative for found in of]))
        counted = share(sum(found.held for found in of), len(of))
        rows.append([kind, body, *counted, f"{100 * bias:+.1f} %", f"{100 * spread:.1f} %"])
    report.say(
        "95 % intervals of k_D by first-order propagation; bias is the mean of k_D divided by the true value, minus 1."
    )
    report.table(["contact", "body", "covered", "share", "95 %", "bias", "median u"], rows)
    report.finish()


if __name__ == "__main__":
    main()

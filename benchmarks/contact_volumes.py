"""How often intervals of k_D by wear volume hold it, of either body of every contact, and how wide and costly they are.

    python benchmarks/contact_volumes.py --labs 1000 --write docs/results/contact_volumes.md
    python benchmarks/contact_volumes.py --labs 1000 --only twin-disc --write docs/results/disc_volumes.md

Each laboratory tests one pair of bodies with true coefficients of its own, under a load, with radii and a path that are
off within what its run.toml states, and measures scars, tracks, volumes and masses with errors drawn from what it
states of them. Where a ball lies in a groove, both shapes are found slice by slice, and the groove's section differs
from that of rigid bodies as much as their sections differ among each other; where not, closed formulas are solved for
the scar; two discs wear by a differential equation of the rotations. Nothing of that is shared with tribopipe.

The ideal estimator knows all of this, and how each reading changes with each coefficient and each input at the truth:
its standard uncertainty is that of generalized least squares there.
"""

import math
import statistics
import time
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from independent.wear import Outline, scar_outline
from labs import Report, arguments, in_parallel, share
from numpy.random import Generator
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from tribopipe import read_run
from tribopipe.base.arrays import Column
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.recipe import MonteCarloRecipe, Recipe
from tribopipe.documents.signals import SignalName
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.wear.curve_fit import curve_fit
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.evaluation.wear.measurement_fit import measurement_fit, volume_fit
from tribopipe.results.run import RawRun

_LOAD, _RADIUS, _PATH, _DENSITY, _MODULUS, _SLIP = 0.01, 0.001, 0.005, 0.005, 0.02, 0.01
"""Relative standard uncertainties that every laboratory states."""
_SHAPE = (2 / 3 - 3 * np.pi / 16) / (2 / 3 + 3 * np.pi / 16) / np.sqrt(3)
"""That of the section of a real groove of known width: between those that rigid bodies make of it at the extremes."""
_SCAR = 5e-6
"""m, of the microscope."""
_EVENED = (0.04, 0.12, 0.4, 1.2, 4.0)
_ENDS = (0.01, 0.13, 0.46, 0.75, 0.96)
"""By how many half lengths of the scar the middle of a groove is longer than its stroke, as cells of ball and flat wear
pass by pass, for groove depths over the deflection times 0.4·(half length/stroke)²: about so for κb from 0.1 to 3.
"""
_SPREAD = np.log(3.0)
"""Coefficients are between a third and three times the usual ones."""
_STEP = 1e-4
"""Relative step of a difference quotient."""
_DRAWS = 10_000
_ALONE = Path(__file__).parents[1] / "sample_runs" / "si3n4-air-200mN"
_HARD: dict[str, Any] = {"youngs_modulus": 304e9, "poisson_ratio": 0.24}
_SOFT: dict[str, Any] = {"youngs_modulus": "210 GPa", "poisson_ratio": 0.3}
FIRST_ORDER = Recipe(monte_carlo=MonteCarloRecipe(significant_digits=0))
Truth = Mapping[str, float]


@dataclass(frozen=True)
class Rig:
    """A contact as a laboratory sets it up."""

    kind: str
    distance: float
    """m; of two discs, rotations."""
    usual: Mapping[str, float]
    """Usual k_D by body, m²/N."""
    inputs: Mapping[str, tuple[float, float]]
    """What is stated of load, radii, path and so on: value and relative standard uncertainty."""
    readings: Callable[["Rig", Truth], dict[str, float]]
    """What instruments without errors would read, SI, by coefficients and inputs."""
    document: Callable[["Rig"], dict[str, Any]]
    """Contact and conditions as run.toml states them."""
    repeats: Mapping[str, int]
    """Number of times that a length is read; once where it is not told."""

    def stated(self, name: str, unit: str, factor: float = 1.0) -> dict[str, Any]:
        """Return an input with its standard uncertainty as run.toml states it."""
        value, relative = self.inputs[name]
        return {"value": factor * value, "unit": unit, "standard_uncertainty": relative * factor * value}

    def spread(self, name: str, reading: float) -> float:
        """Return the standard uncertainty of a reading, SI."""
        if name.endswith("mass_loss"):
            return 2e-8
        if name.endswith("wear_volume"):
            return 0.05 * reading
        return 2 * _SCAR if name == "block_scar_width" else _SCAR

    def ideal(self, truth: Truth) -> dict[str, float]:
        """Return the relative standard uncertainty of each k_D by the ideal estimator."""
        best = self.readings(self, truth)
        slopes = {name: self._slope(name, truth) for name in truth}
        covariance = np.diag(
            [(self.spread(name, one) / one) ** 2 / self.repeats.get(name, 1) for name, one in best.items()]
        )
        for name, (_, relative) in self.inputs.items():
            covariance += relative**2 * np.outer(slopes[name], slopes[name])
        design = np.column_stack([slopes[body] for body in self.usual])
        found = np.linalg.inv(design.T @ np.linalg.solve(covariance, design))
        return dict(zip(self.usual, np.sqrt(np.diag(found)).tolist(), strict=True))

    def _slope(self, name: str, truth: Truth) -> Column:
        """Return how the logarithm of each reading changes with that of a coefficient or input."""
        low, high = (
            np.log(list(self.readings(self, {**truth, name: truth[name] * near}).values()))
            for near in (1 - _STEP, 1 + _STEP)
        )
        return np.asarray((high - low) / (2 * _STEP))

    def truth(self, rng: Generator) -> dict[str, float]:
        """Draw what is true."""
        coefficients = {
            body: usual * float(np.exp(rng.uniform(-_SPREAD, _SPREAD))) for body, usual in self.usual.items()
        }
        off = {name: value * (1 + u * float(rng.standard_normal())) for name, (value, u) in self.inputs.items()}
        return coefficients | off

    def run(self, truth: Truth, rng: Generator, without: str = "") -> RawRun:
        """Return the run as the laboratory writes it down, perhaps without one of its readings."""
        measured: dict[str, Any] = {}
        for name, true in self.readings(self, truth).items():
            spread, count = self.spread(name, true), self.repeats.get(name, 1)
            read = true + spread * rng.standard_normal(count)
            if count > 1:
                values = [f"{1e6 * one:.2f} um" for one in read]
                measured[name] = {"values": values, "standard_uncertainty": "0.5 um"}
                continue
            unit = "kg" if name.endswith("mass_loss") else "m^3" if name.endswith("wear_volume") else "m"
            measured[name] = {"value": max(float(read[0]), 0.0), "unit": unit, "standard_uncertainty": spread}
        document = {"schema": "tribopipe.run/1", "id": "lab", "signals": [{"file": "none.csv"}], "end_values": measured}
        measured.pop(without, None)
        distance = np.linspace(0.0, self.distance, 20)
        along: SignalName = "rotations" if self.kind == "twin-disc" else "sliding_distance"
        columns: dict[SignalName, Column] = {"time": distance.copy(), along: distance}
        manifest = RunManifest.model_validate(document | self.document(self))
        return RawRun(manifest, columns, dict.fromkeys(columns, "measured"), {}, {}, ())


def _ball_in_groove(rig: Rig, truth: Truth) -> dict[str, float]:
    """Return scar length and track width of a ball whose counterbody wears as well."""
    reciprocating = rig.kind == "reciprocating"
    (ball, other), work = rig.usual, truth["load"] * rig.distance
    around = truth["path"] * (1 if reciprocating else 2 * np.pi)
    scar = Outline(0.0, 0.0)
    for _ in range(6 if reciprocating else 1):
        longer = around + (_beyond_the_stroke(scar, truth) if reciprocating else 0.0)
        section = truth[other] / truth[ball] / longer / truth["shape"]
        scar = scar_outline(truth["radius"], section, truth[ball] * work)
    return {"pin_scar_length": 2 * scar.length, f"{other}_track_width": 2 * scar.width}


def _beyond_the_stroke(scar: Outline, truth: Truth) -> float:
    """Return how much longer than its stroke a groove with the section of its middle would be, m."""
    if not scar.length:
        return 0.0
    modulus = float(_SOFT["youngs_modulus"].split()[0]) * 1e9 / (1 - _SOFT["poisson_ratio"] ** 2) / 2
    groove, area = (scar.width**2 - scar.length**2) / 2 / truth["radius"], 2.9 * scar.width * scar.length
    deflection = truth["load"] / area * scar.length / 1.7 / modulus
    evened = 0.4 * groove / deflection * (scar.length / truth["path"]) ** 2
    return float(np.interp(np.log(evened), np.log(_EVENED), _ENDS, left=0.0)) * scar.length


def _ball(rig: Rig) -> dict[str, Any]:
    _, other = rig.usual
    pin = {"shape": "spherical", "radius": rig.stated("radius", "m"), "material": "ball", **_SOFT}
    key = "stroke" if rig.kind == "reciprocating" else "track_radius"
    return {
        "contact": {"kind": rig.kind, "pin": pin, other: {"material": "steel", **_SOFT}},
        "conditions": {"normal_load": rig.stated("load", "N"), key: rig.stated("path", "m")},
    }


_WIDTH = 6.35e-3
"""Width of the block, m."""


def _scar_of_block(rig: Rig, truth: Truth) -> dict[str, float]:
    """Return the width of the scar on a block, and the mass that its ring has lost."""
    work, radius = truth["load"] * rig.distance, truth["radius"]

    def lost(b: float) -> float:
        return float(_WIDTH * (radius**2 * np.arcsin(b / 2 / radius) - b / 4 * np.sqrt(4 * radius**2 - b**2)))

    scar = brentq(lambda b: lost(b) - truth["block"] * work, 1e-6, 1.9 * radius, xtol=1e-15, rtol=1e-13)
    return {"block_scar_width": scar, "ring_mass_loss": truth["ring"] * work * truth["density"]}


def _block(rig: Rig) -> dict[str, Any]:
    width = {"value": _WIDTH, "unit": "m", "standard_uncertainty": 1e-4 * _WIDTH}
    ring = {"radius": rig.stated("radius", "m"), "material": "steel", "density": rig.stated("density", "kg/m^3")}
    block = {"width": width, "material": "bronze", **_SOFT}
    return {
        "contact": {"kind": rig.kind, "block": block, "ring": ring | _SOFT},
        "conditions": {"normal_load": rig.stated("load", "N")},
    }


def _scars_of_balls(rig: Rig, truth: Truth) -> dict[str, float]:
    """Return the scar on each of three balls, and the volume of the groove on the top ball."""
    work, radius = truth["load"] / np.sqrt(6) * rig.distance, truth["radius"]

    def lost(a: float) -> float:
        below = np.sqrt(radius**2 - a**2)
        return float(2 * np.pi * a**2 * (radius - below) - 4 * np.pi * (radius * a**2 / 2 - (radius**3 - below**3) / 3))

    scar = 2 * brentq(lambda a: lost(a) - truth["ball"] * work, 1e-5, 0.9 * radius, xtol=1e-15, rtol=1e-13)
    return {"ball_scar_diameter": scar, "top_ball_wear_volume": 3 * truth["top_ball"] * work}


def _balls(rig: Rig) -> dict[str, Any]:
    ball = {"diameter": rig.stated("radius", "m", 2.0), "material": "steel", **_SOFT}
    return {
        "contact": {"kind": rig.kind, "ball": ball},
        "conditions": {"normal_load": rig.stated("load", "N")},
    }


def _volumes_of_discs(rig: Rig, truth: Truth) -> dict[str, float]:
    """Return what two discs have lost by Eq. 10 and 14 to 16 of the paper, integrated over the rotations."""
    load, crown, curved, flat = (truth[name] for name in ("load", "crown", "curved", "flat"))
    modulus = 1 / sum((1 - _HARD["poisson_ratio"] ** 2) / truth[name] for name in ("curved_modulus", "flat_modulus"))
    ratio = (1 + truth["slip"]) * curved / flat

    def state(first: float, second: float) -> tuple[float, float]:
        """Return half width and mean pressure."""
        equivalent, elastic = 1 / (1 / (curved - first) + 1 / (flat - second)), first + second + 1e-8
        for _ in range(60):
            height = first + second + elastic
            width = float(np.sqrt(height * (2 * crown - height)))
            length = np.pi / 4 * np.sqrt(2 * load / width * equivalent / np.pi / modulus)
            before, elastic = elastic, load / 2 / modulus / np.sqrt(width * length)
            if abs(elastic - before) < 1e-13 * elastic:
                break
        return width, float(np.pi / 4 * np.sqrt(load / 2 / width * modulus / np.pi / equivalent))

    def rates(_: float, worn: Column) -> list[float]:
        first, second = worn[0] * 1e-6, worn[1] * 1e-6
        width, pressure = state(first, second)
        slid = 2 * np.pi * (ratio * (flat - second) - (curved - first)) * pressure * rig.distance
        one, other = truth["curved_disc"] * slid, truth["flat_disc"] * slid * ratio
        lost = 4 * np.pi * width * (curved - first) * one, 4 * np.pi * width * (flat - second) * other
        return [1e6 * one, 1e6 * other, 1e12 * lost[0], 1e12 * lost[1]]

    found = solve_ivp(rates, (0.0, 1.0), np.zeros(4), method="DOP853", rtol=1e-9, atol=1e-12).y[2:, -1] * 1e-12
    return {"curved_disc_wear_volume": float(found[0]), "flat_disc_wear_volume": float(found[1])}


def _discs(rig: Rig) -> dict[str, Any]:
    discs = {
        f"{name}_disc": {
            "rolling_radius": rig.stated(name, "m"),
            "youngs_modulus": rig.stated(f"{name}_modulus", "Pa"),
            "poisson_ratio": _HARD["poisson_ratio"],
            "material": "Si3N4",
        }
        for name in ("curved", "flat")
    }
    discs["curved_disc"]["crown_radius"] = rig.stated("crown", "m")
    return {
        "contact": {"kind": rig.kind, **discs},
        "conditions": {
            "normal_load": rig.stated("load", "N"),
            "curved_disc_speed": "0.8 m/s",
            "slip": rig.stated("slip", "1"),
            "rotations": rig.distance,
        },
    }


def _of_ball(load: float, path: float) -> dict[str, tuple[float, float]]:
    return {"load": (load, _LOAD), "radius": (3e-3, _RADIUS), "path": (path, _PATH), "shape": (1.0, _SHAPE)}


RIGS = {
    rig.kind: rig
    for rig in (
        Rig("pin-on-disc", 1000.0, {"pin": 1e-15, "disc": 4e-13}, _of_ball(5.0, 6e-3), _ball_in_groove, _ball, {}),
        Rig("reciprocating", 400.0, {"pin": 2e-14, "flat": 5e-14}, _of_ball(10.0, 0.02), _ball_in_groove, _ball, {}),
        Rig(
            "block-on-ring",
            586.0,
            {"block": 5e-15, "ring": 8e-16},
            {"load": (134.0, _LOAD), "radius": (17.5e-3, _RADIUS), "density": (7850.0, _DENSITY)},
            _scar_of_block,
            _block,
            {"block_scar_width": 5},
        ),
        Rig(
            "four-ball",
            1659.0,
            {"ball": 3e-16, "top_ball": 3e-18},
            {"load": (40.0, _LOAD), "radius": (6.35e-3, 1e-5)},
            _scars_of_balls,
            _balls,
            {"ball_scar_diameter": 6},
        ),
        Rig(
            "twin-disc",
            1e6,
            {"curved_disc": 4.6e-18, "flat_disc": 2e-18},
            {
                "load": (0.25, _LOAD),
                "crown": (4e-3, 2 * _RADIUS),
                "curved": (4e-3, _RADIUS),
                "flat": (4e-3, _RADIUS),
                "curved_modulus": (_HARD["youngs_modulus"], _MODULUS),
                "flat_modulus": (_HARD["youngs_modulus"], _MODULUS),
                "slip": (0.04, _SLIP),
            },
            _volumes_of_discs,
            _discs,
            {},
        ),
    )
}


class Found(NamedTuple):
    """What was found of one body: whether its interval held, k_D over the truth, and u relative and over the ideal."""

    kind: str
    body: str
    held: bool
    ratio: float
    relative: float
    over_ideal: float


def made(rig: Rig, seed: int, without: str = "") -> tuple[Truth, RawRun]:
    """Return what is true in a laboratory, and its run, perhaps without one of its readings."""
    rng = np.random.default_rng(np.random.SeedSequence([seed, zlib.crc32(rig.kind.encode())]))
    truth = rig.truth(rng)
    return truth, rig.run(truth, rng, without)


def outcomes(rig: Rig, seed: int) -> list[Found]:
    """Test one pair of bodies; a body without a k_D is not among them."""
    truth, run = made(rig, seed)
    ideal, found = rig.ideal(truth), []
    for body, one in fit_wear(run, "archard", recipe=FIRST_ORDER).bodies.items():
        true, (low, high) = truth[body], one.interval
        k = one.wear_coefficient
        relative = (k.standard_uncertainty or 0.0) / k.value
        held = low.value <= true <= high.value
        found.append(Found(rig.kind, body, held, k.value / true, relative, relative / ideal[body]))
    return found


class Doubt(NamedTuple):
    """What was found without one reading: the bodies with a k_D, and whether a warning was given."""

    kind: str
    missing: str
    bodies: tuple[str, ...]
    warned: bool
    relative: float
    """u of the first k_D."""


def doubts(kinds: Sequence[str], seed: int) -> list[Doubt]:
    """Leave out each reading of each contact in turn."""
    found = []
    for rig in (RIGS[kind] for kind in kinds):
        for missing in rig.readings(rig, made(rig, seed)[0]):
            _, run = made(rig, seed, missing)
            fit = fit_wear(run, "archard", recipe=FIRST_ORDER)
            warned = any(one.severity == "warning" for one in fit.findings)
            ks = [one.wear_coefficient for one in fit.bodies.values()]
            relative = (ks[0].standard_uncertainty or 0.0) / ks[0].value if ks else math.nan
            found.append(Doubt(rig.kind, missing, tuple(fit.bodies), warned, relative))
    return found


def say_what_is_claimed(report: Report, answers: Sequence[Doubt]) -> None:
    """Count claims of both bodies where one reading is missing."""
    report.say("## With a missing measurement")
    report.say("If one of the two measurements is missing, k_D can be determined for at most one body.")
    rows = []
    for kind, missing in dict.fromkeys((one.kind, one.missing) for one in answers):
        of = [one for one in answers if (one.kind, one.missing) == (kind, missing)]
        several, warned = sum(len(one.bodies) > 1 for one in of), sum(one.warned for one in of)
        spread = float(np.median([one.relative for one in of]))
        body = spoken(of[0].bodies[0]) if of[0].bodies else "none"
        width = f"{100 * spread:.1f} %" if of[0].bodies else ""
        rows.append([kind, spoken(missing), f"{several} of {len(of)}", body, width, f"{warned}"])
    report.table(["contact", "not measured", "k_D of both", "k_D of", "median u", "warnings"], rows)


def _posed(run: RawRun) -> Any:
    """Return the fit of a run's measurements, before it is solved."""
    if run.manifest.slip is None:
        return volume_fit(run, "archard", None, Recipe())
    return measurement_fit(correct_drift(run, Recipe()), "archard", None, Recipe())


def say_how_long(report: Report, kinds: Sequence[str], seed: int, repeats: int) -> None:
    """Time draws of both k_D beside those of a pin alone with a depth signal."""
    alone = curve_fit(correct_drift(read_run(_ALONE), Recipe()), "archard", None, Recipe())
    fits: dict[str, Any] = {"pin-on-disc, pin alone, depth signal": alone}
    fits |= {kind: _posed(made(RIGS[kind], seed)[1]) for kind in kinds}
    times: dict[str, list[float]] = {name: [] for name in fits}
    for _ in range(repeats + 1):
        for name, fit in fits.items():
            begun = time.process_time()
            fit.draw(np.random.default_rng(1), _DRAWS)
            times[name].append(time.process_time() - begun)
    medians = {name: statistics.median(taken[1:]) for name, taken in times.items()}
    base = next(iter(medians.values()))
    report.say(f"## CPU time for {_DRAWS:,} Monte Carlo draws")
    report.say(f"Medians of {repeats} alternating repeats; an additional first repeat is not included.")
    report.table(
        ["k_D of", "time", "ratio"],
        [[name, f"{1e3 * took:.2f} ms", f"{took / base:.2f}"] for name, took in medians.items()],
    )


def both(kinds: Sequence[str], seed: int) -> list[Found]:
    """Test one pair of each contact."""
    return [found for kind in kinds for found in outcomes(RIGS[kind], seed)]


def main(words: Sequence[str] | None = None) -> None:
    """Count how often intervals hold, and time draws."""
    parser = arguments(__doc__ or "", labs=1000)
    parser.add_argument("--repeats", type=int, default=21, help="number of repeats of the timing (%(default)s)")
    parser.add_argument("--only", nargs="+", default=list(RIGS), choices=RIGS, help="contacts (all)")
    options = parser.parse_args(words)
    report = Report("k_D of each body from wear volumes", options)
    seeds = range(options.first_seed, options.first_seed + options.labs)
    answers = [found for part in in_parallel(partial(both, options.only), seeds, options) for found in part]
    rows = []
    for kind, body in dict.fromkeys((found.kind, found.body) for found in answers):
        of = [found for found in answers if (found.kind, found.body) == (kind, body)]
        bias = float(np.mean([found.ratio for found in of])) - 1
        spread, wider = (float(np.median([getattr(one, name) for one in of])) for name in ("relative", "over_ideal"))
        counted = share(sum(found.held for found in of), len(of))
        rows.append([kind, spoken(body), *counted, f"{100 * bias:+.1f} %", f"{100 * spread:.1f} %", f"{wider:.2f}"])
    report.say(
        "The 95 % intervals of k_D are from first-order propagation. The bias is the mean of k_D divided by the true "
        "value, minus 1. u is the standard uncertainty of k_D; the last column is the median of u divided by that of "
        "the ideal estimator."
    )
    report.table(["contact", "body", "covered", "fraction", "95 % CI", "bias", "median u", "u / ideal"], rows)
    without = in_parallel(partial(doubts, options.only), seeds, options)
    say_what_is_claimed(report, [one for part in without for one in part])
    say_how_long(report, options.only, options.first_seed, options.repeats)
    report.finish()


if __name__ == "__main__":
    main()

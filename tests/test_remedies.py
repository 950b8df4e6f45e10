"""Every key that a remedy names is one that run.toml accepts for this contact."""

import re

import numpy as np
import pytest

from tribopipe.base.errors import FitError
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.recipe import MonteCarloRecipe, Recipe
from tribopipe.documents.record import read_document
from tribopipe.evaluation.checks.registry import check_run
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.results.run import RawRun

STEEL = {"material": "100Cr6", "youngs_modulus": "210 GPa", "poisson_ratio": 0.3}
BALL = {"diameter": "6 mm", **STEEL}
CIRCLE, STROKE = {"track_radius": "6 mm"}, {"stroke": "10 mm"}
CONTACTS = {
    "sphere": (
        {"kind": "pin-on-disc", "pin": {"shape": "spherical", "radius": "3 mm", **STEEL}, "disc": STEEL},
        CIRCLE,
    ),
    "flat": ({"kind": "pin-on-disc", "pin": {"shape": "flat", "radius": "2 mm", **STEEL}, "disc": STEEL}, CIRCLE),
    "ball": ({"kind": "pin-on-disc", "ball": BALL, "disc": STEEL}, CIRCLE),
    "reciprocating": ({"kind": "reciprocating", "ball": BALL, "flat": STEEL}, STROKE),
    "block": (
        {"kind": "block-on-ring", "block": {"width": "6.35 mm", **STEEL}, "ring": {"radius": "17.5 mm", **STEEL}},
        {},
    ),
    "four balls": ({"kind": "four-ball", "ball": BALL}, {}),
}
KEY = re.compile(r"\b(?:pin|disc|ball|top_ball|flat|block|ring)_(?:scar|wear|track|mass)_[a-z]+\b")
UNITS = {"volume": "mm^3", "loss": "mg", "area": "um^2"}


def run_of(document: dict, depth: float) -> RawRun:
    """A run whose depth signal changes by a depth, m, and that nothing was measured of."""
    distance = np.linspace(0, 1000, 401)
    noise = 2e-8 * np.random.default_rng(1).standard_normal(distance.size)
    columns = {"time": distance / 0.1, "sliding_distance": distance, "depth": depth * np.sqrt(distance / 1000) + noise}
    manifest = read_document(document, RunManifest, where="run.toml")
    return RawRun(manifest, columns, dict.fromkeys(columns, "measured"), {}, {}, ())


def remedies(run: RawRun) -> list[str]:
    """What to do about a run, according to its checks and its fit."""
    found = [finding.remedy for finding in check_run(run)]
    try:
        fit = fit_wear(run, recipe=Recipe(monte_carlo=MonteCarloRecipe(significant_digits=0)))
    except FitError as error:
        return [*found, run.manifest.worded(str(error))]
    return [*found, *(finding.remedy for finding in fit.findings)]


@pytest.mark.slow
@pytest.mark.parametrize("depth", [10e-6, -10e-6])
@pytest.mark.parametrize("name", CONTACTS)
def test_keys_of_remedies_are_accepted(name, depth):
    contact, path = CONTACTS[name]
    document = {
        "schema": "tribopipe.run/1",
        "id": "run",
        "contact": contact,
        "conditions": {"normal_load": "5 N", "sliding_speed": "0.1 m/s", **path},
        "signals": [{"file": "signals.csv"}],
    }
    named = {key for remedy in remedies(run_of(document, depth)) for key in KEY.findall(remedy)}
    assert named
    for key in named:
        value = f"0.01 {UNITS.get(key.rpartition('_')[2], 'mm')}"
        bodies = {body: {**part, "density": "7.8 g/cm^3"} for body, part in contact.items() if isinstance(part, dict)}
        read_document(
            document | {"contact": contact | bodies, "end_values": {key: value}}, RunManifest, where="run.toml"
        )

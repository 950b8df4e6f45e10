"""Twin-disc runs in memory whose end values follow from known k₁ and k₂, and virtual ones with all errors."""

from dataclasses import replace

import numpy as np
from folders import SAMPLES

from tribopipe.contacts.twin_disc import nominal_pair
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.plan import Plan, TwinDiscSensors, TwinDiscVirtualRun
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import MonteCarloRecipe, Recipe, WearRecipe
from tribopipe.documents.record import load_toml
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.study.member import Member
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.evaluation.wear.scenario import KnownWear
from tribopipe.extras.simulate import VirtualTwinDiscTest
from tribopipe.physics.friction_path import junction_factor
from tribopipe.physics.twin_disc import DiscWear
from tribopipe.results.evaluation import DriftCorrection, FrictionFit
from tribopipe.results.run import CorrectedRun, RawRun
from tribopipe.results.wear_fit import WearFit

CONVENTIONS = ("full-slip", "contact-width", "volume-conserving")
K_1, K_2 = 4.6e-18, 2.0e-18
"""k_D of the curved and the cylindrical disc in full slip, m²/N."""
TYPICAL = {"full-slip": 1.0, "contact-width": 150.0, "volume-conserving": 3000.0}
"""What k_D is multiplied by to wear about as much under another convention."""
BODY = {
    "material": "Si3N4",
    "youngs_modulus": {"value": "304 GPa", "standard_uncertainty": "2 %"},
    "poisson_ratio": 0.24,
    "rolling_radius": {"value": "4 mm", "standard_uncertainty": "0.1 %"},
}
DOCUMENT = {
    "schema": "tribopipe.run/1",
    "id": "discs",
    "started": "2006-06-12T09:10:00+02:00",
    "contact": {
        "kind": "twin-disc",
        "curved_disc": BODY | {"crown_radius": {"value": "4 mm", "standard_uncertainty": "0.2 %"}},
        "flat_disc": BODY,
    },
    "conditions": {
        "normal_load": {"value": "250 mN", "standard_uncertainty": "1 %"},
        "curved_disc_speed": "800 mm/s",
        "slip": {"value": "4 %", "standard_uncertainty": "0.04 %"},
        "medium": "air",
    },
    "signals": [{"file": "signals.csv"}],
}
BARE = RunManifest.model_validate(DOCUMENT)
UNITS = {"wear_volume": "m^3", "wear_depth": "m", "track_width": "m"}


def recipe(convention: str = "full-slip", *, drawn: bool = False, **changes) -> Recipe:
    """A recipe of first order unless it is to draw."""
    how = MonteCarloRecipe() if drawn else MonteCarloRecipe(significant_digits=0)
    wear = WearRecipe(distance_per_rotation=convention, **changes)
    return Recipe(wear=wear, monte_carlo=how)


def known_pair(first: Quantity, second: Quantity | None = None, **how) -> KnownWear:
    """k_D of the crowned disc, and of the flat one where it wears."""
    return KnownWear({"curved_disc": first} | ({} if second is None else {"flat_disc": second}), **how)


def worn(rotations, convention="full-slip", first=K_1, second=K_2, manifest=BARE) -> DiscWear:
    """The exact model of a manifest."""
    return nominal_pair(manifest, convention).worn(np.asarray(rotations, float), first, second)


def ends_of(state: DiscWear, wanted: dict[str, float], at: int = 0) -> dict[str, dict]:
    """What would be measured without error: `{"curved_disc_wear_volume": relative uncertainty}`."""
    values = {
        "curved_disc_wear_volume": state.curved_volume,
        "flat_disc_wear_volume": state.flat_volume,
        "curved_disc_wear_depth": state.curved_depth,
        "flat_disc_wear_depth": state.flat_depth,
        "curved_disc_track_width": 2 * state.half_width,
        "flat_disc_track_width": 2 * state.half_width,
    }
    found = {}
    for name, share in wanted.items():
        value = float(np.atleast_1d(values[name])[at])
        unit = UNITS[name.split("_disc_")[1]]
        found[name] = {"value": value, "unit": unit, "standard_uncertainty": share * value}
    return found


def raw(ends: dict, stops: tuple[dict, ...] = (), rotations: float = 1e6, mu: float = 0.0, manifest=BARE) -> RawRun:
    """A run of a few samples with constant friction; stops are end values with their rotations."""
    document = manifest.model_dump(by_alias=True) | {"end_values": ends, "interruptions": list(stops)}
    turns = np.linspace(0.0, rotations, 21)
    slid = turns * 2 * np.pi * 4e-3 * 0.04
    columns = {"rotations": turns, "sliding_distance": slid, "time": turns * 2 * np.pi * 4e-3 / 0.8}
    columns["friction_coefficient"] = np.full(21, mu)
    return RawRun(RunManifest.model_validate(document), columns, dict.fromkeys(columns, "measured"), {}, {}, ())


def exact_run(
    wanted: dict[str, float],
    stops: dict[float, dict[str, float]] | None = None,
    *,
    convention: str = "full-slip",
    first: float = K_1,
    second: float = K_2,
    rotations: float = 1e6,
    mu: float = 0.0,
) -> RawRun:
    """A run measured without error, its wear that of Sarkar's law where there is friction."""
    factor, scale = float(junction_factor(mu)), TYPICAL[convention]

    def after(turns: float) -> DiscWear:
        return worn(turns * factor, convention, first * scale, second * scale)

    ends = ends_of(after(rotations), wanted)
    interruptions = tuple({"rotations": turns} | ends_of(after(turns), some) for turns, some in (stops or {}).items())
    return raw(ends, interruptions, rotations, mu)


def with_ends(run: RawRun, **ends) -> RawRun:
    """The run with other end values, as quantities; None takes one out."""
    changed = run.manifest.end_values.model_copy(update=ends)
    return replace(run, manifest=run.manifest.model_copy(update={"end_values": changed}))


# --- virtual runs with all their errors ---

SERIES = load_toml(SAMPLES / "plan.toml", Plan).twin_disc_series[0]
PLANNED = {run.id.removeprefix("si3n4-twin-disc-"): run for run in SERIES.runs}


def recorded(run: TwinDiscVirtualRun, sensors: TwinDiscSensors | None = None, *, off: bool = True) -> RawRun:
    """A virtual run as if it had been ingested: load, radii, moduli and slip off within what is stated."""
    series = SERIES.model_copy(update={"systematic_errors": off, "sensors": sensors or SERIES.sensors})
    columns, ends = VirtualTwinDiscTest(series, run).record()
    nominal = 2 * np.pi * 4e-3 * run.slip.value
    columns["sliding_distance"] = nominal * columns["rotations"]
    columns["friction_coefficient"] = columns["friction_force"] / columns["normal_force"]
    document = DOCUMENT | {
        "id": run.id,
        "contact": SERIES.contact.model_dump(),
        "conditions": {
            "normal_load": series.load_of(run).model_dump(),
            "curved_disc_speed": SERIES.curved_disc_speed.model_dump(),
            "slip": run.slip.model_dump(),
            "rotations": run.rotations,
            "medium": SERIES.medium,
        },
        "sensors": {"depth_scale": SERIES.depth_scale.model_dump()},
        "end_values": {name: value.model_dump() for name, value in ends.items()},
    }
    return RawRun(RunManifest.model_validate(document), columns, dict.fromkeys(columns, "measured"), {}, {}, ())


def member(run: TwinDiscVirtualRun, **options) -> Member:
    """A virtual run as it enters a study of Archard's law."""
    return Member(correct_drift(recorded(run, **options)), None)


def fit_discs(
    run: RawRun, law: str = "archard", friction: FrictionFit | None = None, recipe: Recipe | None = None
) -> WearFit:
    """Fit k₁ and k₂ of a run, whose depth signal plays no part in it."""
    return fit_wear(CorrectedRun(run, DriftCorrection(outcome="uncorrected"), None), law, friction, recipe)

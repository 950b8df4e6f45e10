"""Short runs that studies are tried on, of which some belong together."""

import shutil
from pathlib import Path

from folders import SAMPLES, replace_in, set_key

from tribopipe.archive.store import Archive
from tribopipe.documents.plan import Plan
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe
from tribopipe.documents.record import load_toml
from tribopipe.extras.simulate import simulate_plan
from tribopipe.pipeline.stages import advance, ingest

LIGHT, AGAIN, HEAVY = "si3n4-air-200mN", "si3n4-air-200mN-again", "si3n4-air-400mN"
OTHERS = {
    "other-material": ("material", '"SiC"'),
    "other-radius": ("radius", '"1 mm"'),
    "other-medium": ("medium", '"water"'),
}
"""A copy of the run at 400 mN with one key of run.toml changed."""
NO_END = "no-end-value"


def record_runs(folder: Path) -> Path:
    """Record 100 m at 200 mN, at 200 mN once more and at 400 mN, and runs that do not belong to these."""
    series = load_toml(SAMPLES / "plan.toml", Plan).series[0]
    light, heavy, _ = series.runs
    little = light.disc_wear_depth.model_copy(update={"value": 25e-9})
    light, heavy = (run.model_copy(update={"disc_wear_depth": little}) for run in (light, heavy))
    runs = (light, light.model_copy(update={"id": AGAIN, "seed": 141}), heavy)
    series = series.model_copy(update={"sliding_distance": Quantity(value=100.0, unit="m"), "runs": runs})
    simulate_plan(Plan(schema="tribopipe.plan/1", series=(series,)), folder)
    for name in (*OTHERS, NO_END):
        run = shutil.copytree(folder / HEAVY, folder / name)
        set_key(run, "id", f'"{name}"')
        if name in OTHERS:
            set_key(run, *OTHERS[name])
        else:
            replace_in(run / "run.toml", r"(?s)\[end_values\].*?(?=\[sensors\])", "")
    return folder


def fill(archive: Path, runs: Path) -> Archive:
    """Archive runs, corrected and with their friction."""
    store = Archive(archive)
    for run in sorted(runs.iterdir()):
        ingest(run, store)
        advance(store, run.name, "drift_correction", Recipe())
        advance(store, run.name, "friction_fit", Recipe())
    return store

"""Run folders of 126 samples each, which are processed in half a second, for what has to be done many times over."""

import re
import shutil
from pathlib import Path

from tribopipe.documents.plan import Plan
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.record import load_toml
from tribopipe.extras.simulate import simulate_plan

_PLAN = Path(__file__).parents[2] / "sample_runs" / "plan.toml"
_LENGTH = 5.0
"""Sliding distance, m."""


def short_runs(folder: Path, count: int, times: int = 1) -> list[Path]:
    """Write so many run folders, run-000 and on: one virtual test at each of three loads, and copies of those.

    They are so many times as long.
    """
    series = load_toml(_PLAN, Plan).series[0]
    series = series.model_copy(update={"sliding_distance": Quantity(value=times * _LENGTH, unit="m")})
    simulate_plan(Plan(schema="tribopipe.plan/1", series=(series,)), folder / "recorded")
    recorded = sorted((folder / "recorded").iterdir())
    runs = [_copy(recorded[number % len(recorded)], folder / f"run-{number:03}") for number in range(count)]
    shutil.rmtree(folder / "recorded")
    return runs


def quick_recipe(folder: Path) -> Path:
    """Write a recipe by which uncertainty stays at first order: a Monte Carlo would take most of the time."""
    path = folder / "recipe.toml"
    path.write_text('schema = "tribopipe.recipe/1"\n[monte_carlo]\nsignificant_digits = 0\n', encoding="utf-8")
    return path


def _copy(recorded: Path, run: Path) -> Path:
    shutil.copytree(recorded, run)
    manifest = run / "run.toml"
    text = manifest.read_text(encoding="utf-8")
    manifest.write_text(re.sub(r"(?m)^id = .*$", f'id = "{run.name}"', text, count=1), encoding="utf-8")
    return run

"""A virtual tribometer: run folders with a known truth, from the exact wear model and an instrument's imperfections."""

from pathlib import Path

from tribopipe.documents.plan import Plan, Truth, TwinDiscTruth
from tribopipe.extras.simulate.instrument import require_simulated
from tribopipe.extras.simulate.pin_on_disc import VirtualTest, simulate_run
from tribopipe.extras.simulate.twin_disc import VirtualTwinDiscTest, simulate_twin_disc_run

__all__ = ["VirtualTest", "VirtualTwinDiscTest", "simulate_plan", "simulate_run", "simulate_twin_disc_run"]


def simulate_plan(plan: Plan, folder: Path) -> list[Truth | TwinDiscTruth]:
    """Write every run of a plan into a folder of its own. Raises ``OutputError`` where another run is in one."""
    pin_ids = [run.id for series in plan.series for run in series.runs]
    for run_id in (*pin_ids, *(run.id for series in plan.twin_disc_series for run in series.runs)):
        require_simulated(folder / run_id)
    pins = [simulate_run(series, run, folder / run.id) for series in plan.series for run in series.runs]
    discs = [
        simulate_twin_disc_run(series, run, folder / run.id) for series in plan.twin_disc_series for run in series.runs
    ]
    return [*pins, *discs]

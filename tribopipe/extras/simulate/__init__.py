"""A virtual tribometer: run folders with a known truth, from the exact wear model and an instrument's imperfections."""

from pathlib import Path

from tribopipe.documents.plan import Plan, Truth, TwinDiscTruth
from tribopipe.extras.simulate.instrument import require_simulated
from tribopipe.extras.simulate.pin_on_disc import VirtualTest
from tribopipe.extras.simulate.twin_disc import VirtualTwinDiscTest

__all__ = ["VirtualTest", "VirtualTwinDiscTest", "simulate_plan"]


def simulate_plan(plan: Plan, folder: Path) -> list[Truth | TwinDiscTruth]:
    """Write every run of a plan into a folder of its own. Raises ``OutputError`` where another run is in one."""
    pins = [(VirtualTest, series, run) for series in plan.series for run in series.runs]
    discs = [(VirtualTwinDiscTest, series, run) for series in plan.twin_disc_series for run in series.runs]
    for _, _, run in (*pins, *discs):
        require_simulated(folder / run.id)
    return [test(series, run).write(folder / run.id) for test, series, run in (*pins, *discs)]

"""The same plot of several runs on one axis."""

from collections.abc import Collection, Sequence
from dataclasses import replace

from starlette.exceptions import HTTPException

from tribopipe.browse.plots import run_plots
from tribopipe.browse.samples import RunFile
from tribopipe.views.plot import Panel, Plot, axis_label

COMPARED = {"wear": "Wear", "friction": "Friction", "depth": "Depth signal"}
"""What can be compared, with its title."""


def compare(what: str, runs: Sequence[RunFile], extra: Collection[str], against: str | None) -> Plot:
    """Draw one plot of several runs; of laws those that are asked for: "fit", "prediction".

    Panels of one label become one. Raises ``HTTPException`` where none of the runs has such a plot, or they share no
    axis.
    """
    offers = [offer for run in runs for offer in run_plots(run) if offer.name == what]
    if not offers:
        raise HTTPException(404, f"found no {what} in these runs; expected a run that has some; choose others")
    axes = [name for name in offers[0].axes if all(name in offer.axes for offer in offers)]
    chosen = against if against in axes else axes[0]
    wanted = {"measured", *extra}
    panels: dict[str, Panel] = {}
    for offer in offers:
        for panel in offer.drawing(chosen).panels:
            kept = tuple(curve for curve in panel.curves if curve.role in wanted)
            there = panels.get(panel.label, replace(panel, curves=(), marks=()))
            if kept or panel.marks:
                curves, marks = (*there.curves, *kept), (*there.marks, *panel.marks)
                panels[panel.label] = replace(there, curves=curves, marks=marks)
    return Plot(COMPARED[what], "", chosen, axis_label(chosen), tuple(panels.values()))

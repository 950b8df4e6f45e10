"""How far UMESHMOTION's economy drifts from the Wear-Processor, and how corrections of the geometry bring it back.

    python benchmarks/economy.py

The question of the paper's Fig. 11, asked of its two discs (Table 3, all radii 4 mm) by finite elements. The economy
wears by the pressure before each increment and mends the contact instead of solving it; corrections move the mesh and
solve the contact. That is done once as it is, and once with a share of the carried stresses lost in each increment,
since what ABAQUS' advection loses is not known (tribopipe.physics.local.economy).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from labs import Report, arguments
from matplotlib.figure import Figure

from tribopipe.base.arrays import Column
from tribopipe.base.units import axis, from_si
from tribopipe.physics.hertz import contact_modulus
from tribopipe.physics.local.course import LocalWear
from tribopipe.physics.local.economy import wear_economically
from tribopipe.physics.local.finite_elements import QuarterDisc, quarter_disc
from tribopipe.views.layout import letter
from tribopipe.views.plot import power_of, powered_axis
from tribopipe.views.run_figures import PALETTE, key, save_figure, styled

LOAD, RADIUS, COEFFICIENT, RATIO = 0.3, 4e-3, 1e-16, 0.32
MODULUS = float(contact_modulus(pin_modulus=152e9, pin_ratio=RATIO, disc_modulus=152e9, disc_ratio=RATIO))
ROTATIONS, INCREMENTS = 2e6, 40
STRESS_LOSSES = 0.0, 0.015
CORRECTIONS = {"never corrected": None, "corrected every 20": 20, "every 10": 10, "every 5": 5}
"""Increments between corrections, by the names of the courses; after every single one, it is the Wear-Processor."""


_STYLES = ("-", (0, (5, 1.6)), (0, (5, 1.4, 1.2, 1.4)), (0, (1.2, 1.2)))


def discs(cells: tuple[int, int]) -> QuarterDisc:
    """Return a quarter of the paper's two discs."""
    return quarter_disc(
        normal_load=LOAD,
        modulus=MODULUS,
        poisson_ratio=RATIO,
        crown_radius=RADIUS,
        curved_radius=RADIUS,
        flat_radius=RADIUS,
        amount=COEFFICIENT * ROTATIONS,
        cells=cells,
    )


@dataclass(frozen=True)
class EngineCurve:
    """The course of wear by one engine or scheme."""

    name: str
    rotations: Column
    """Of the crowned disc."""
    depth: Column
    """m."""
    pressure: Column
    """In the middle of the contact, or on average, Pa."""


@styled
def plot_engines(curves: Sequence[EngineCurve], title: str = "") -> Figure:
    """Draw pressure and wear depth by several engines, and how far depths are off the first one's (Fig. 10 and 11)."""
    figure = Figure(figsize=(7.2, 3.3), dpi=150, layout="constrained")
    axes = list(figure.subplots(1, 3))
    power, first = power_of(max(float(curve.rotations[-1]) for curve in curves)), curves[0]
    for number, curve in enumerate(curves):
        along = curve.rotations / 10.0**power
        look = {"color": PALETTE[number % len(PALETTE)], "ls": _STYLES[number % len(_STYLES)], "label": curve.name}
        axes[0].plot(along, from_si(curve.pressure, "Pa", "MPa"), **look)
        axes[1].plot(along, from_si(curve.depth, "m", "um"), **look)
        reference = np.interp(curve.rotations, first.rotations, first.depth)
        worn = (reference > 0) & (curve.rotations <= first.rotations[-1])
        axes[2].plot(along[worn], 100 * (curve.depth[worn] / reference[worn] - 1), **look)
    labels = (axis("pressure", "MPa"), axis("wear depth", "um"), axis("depth deviation", "%"))
    for place, (ax, words) in enumerate(zip(axes, labels, strict=True)):
        ax.set_ylabel(words)
        ax.set_xlabel(powered_axis("rotations", power))
        letter(ax, place, "", len(axes))
    for ax in axes[:2]:
        ax.set_ylim(bottom=0.0)
    figure.suptitle(title, x=0.01, ha="left", fontsize=10, fontweight="bold")
    key(figure, axes, 4)
    return figure


def curve(words: str, course: LocalWear) -> EngineCurve:
    """Return a course as it is drawn."""
    return EngineCurve(words, course.amount / COEFFICIENT, course.depth, course.pressure[:, 0, 0])


def main() -> None:
    """Wear the discs by each scheme, print depths and pressures at the end, and draw them."""
    parser = arguments(__doc__ or "")
    parser.add_argument("--cells", type=int, nargs=2, default=(8, 4), help="cells across and along (%(default)s)")
    parser.add_argument("--figure", type=Path, help="file to draw into")
    options = parser.parse_args()
    report = Report("Accuracy of UMESHMOTION compared with the Wear-Processor", options)
    surface, amounts = discs(tuple(options.cells)), COEFFICIENT * ROTATIONS * np.arange(1, INCREMENTS + 1) / INCREMENTS
    increment = float(amounts[0])
    full = wear_economically(surface, amounts, increment=increment, correct_every=1)
    report.say(
        f"{options.cells[0]} × {options.cells[1]} cells on a quarter of the contact, {INCREMENTS} increments to "
        f"{ROTATIONS:.0e} slip rotations. ε is the fraction of the stresses that is lost in each increment. The table "
        "lists the deviations of wear depth and pressure in the middle of the contact from the results of the "
        f"Wear-Processor: at the end, where the Wear-Processor gives {1e6 * full.depth[-1]:.4f} µm and "
        f"{1e-6 * full.pressure[-1, 0, 0]:.1f} MPa, and the largest deviation during the test."
    )
    rows, drawn = [], [curve("Wear-Processor", full)]
    for loss in STRESS_LOSSES:
        for name, every in CORRECTIONS.items():
            course = wear_economically(surface, amounts, increment=increment, correct_every=every, stress_loss=loss)
            rows.append(
                [f"{loss:g}", f"every {every} increments" if every else "never", *compared(course.depth, full.depth)]
            )
            rows[-1] += compared(course.pressure[:, 0, 0], full.pressure[:, 0, 0])
            if loss:
                drawn.append(curve(name, course))
    report.table(
        ["ε", "geometry corrected", "depth, end", "depth, largest", "pressure, end", "pressure, largest"], rows
    )
    report.finish()
    if options.figure is not None:
        save_figure(plot_engines(drawn, f"UMESHMOTION scheme, stress loss ε = {STRESS_LOSSES[-1]:g}"), options.figure)


def compared(values: Column, true: Column) -> list[str]:
    """Say how far values are off at the end, and at most on the way there."""
    off = 100 * (values[1:] / true[1:] - 1)
    return [f"{off[-1]:+.2f} %", f"{off[np.argmax(np.abs(off))]:+.2f} %"]


if __name__ == "__main__":
    main()

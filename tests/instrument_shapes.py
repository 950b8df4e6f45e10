"""Synthetic exports with the shape, byte for byte, of what instruments write, and the truth they were made from."""

import math
from typing import NamedTuple

import numpy as np
from built_files import xlsx


class Rung(NamedTuple):
    """One step of a ladder of speeds and radii: its number, rpm, and distance slid in three minutes, m."""

    number: int
    rpm: float
    distance: float

    @property
    def radius(self) -> float:
        """Radius of the track, mm, for the distance to be what it is."""
        return 1000 * self.distance / (2 * math.pi * self.rpm * 3)


LADDER = (Rung(4, 119, 13.5), Rung(7, 143, 27.0), Rung(10, 168, 40.5), Rung(13, 191, 54.0))
RTEC_NAMES = (
    "Step, Timestamp, RecipeStep, DAQ.Fz (N),DAQ.Fx (N),DAQ.COF (),Rotary.Velocity (rpm),XYZ.X Position (mm),"
    "XYZ.Z Depth (mm),"
)


def rtec_ladder(rungs: tuple[Rung, ...] = LADDER, *, cumulative: bool = False, load: float = 5.0) -> bytes:
    """Write steps of 3 min at 10 Hz, each at its own speed and friction coefficient, 0.1 times its place from 1.

    Time begins again with each step, or goes on through all of them.
    """
    rng = np.random.default_rng(4)
    lines, before = [], 0.0
    for place, rung in enumerate(rungs, 1):
        time = np.arange(1, 1801) / 10 + before
        before = time[-1] if cumulative else 0.0
        mu = 0.1 * place + rng.normal(0, 0.004, len(time))
        force = load + rng.normal(0, 0.02, len(time))
        depth = 0.01 + 1e-5 * (time - time[0])
        for t, m, f, d in zip(time, mu, force, depth, strict=True):
            lines.append(
                f"{rung.number},{t:.2f},{place},{f:.4f},{-m * f:.4f},{m:.5f},{rung.rpm:.1f},{rung.radius:.3f},{d:.5f},\n"
            )
    top = b"RecipeName,UpperSample,Radius,TestDate,Operator\rLadder,ball,1,13/9/2026 3:42:07 AM,Ana\r\n"
    return top + f"{RTEC_NAMES}\r\n{''.join(lines)}\nTotalTime\n00:12:00.0000000\n".encode()


def workbook_of(names: list[str], rows: int = 60) -> bytes:
    """Write a workbook with one test of a rate of its own in each sheet, every clock from zero."""
    sheets = {}
    for place, name in enumerate(names, 1):
        table = [[t / 10, 0.5 * place, 5.0, 0.1 * place] for t in range(rows)]
        sheets[name] = [["Time [s]", "Friction Force [N]", "Normal Load [N]", "COF"], *table]
    return xlsx(sheets)

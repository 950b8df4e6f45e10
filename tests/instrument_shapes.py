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
            end = f"{rung.rpm:.1f},{rung.radius:.3f},{d:.5f},\n"
            lines.append(f"{rung.number},{t:.2f},{place},{f:.4f},{-m * f:.4f},{m:.5f},{end}")
    top = b"RecipeName,UpperSample,Radius,TestDate,Operator\rLadder,ball,1,13/9/2026 3:42:07 AM,Ana\r\n"
    return top + f"{RTEC_NAMES}\r\n{''.join(lines)}\nTotalTime\n00:12:00.0000000\n".encode()


def workbook_of(names: list[str], rows: int = 60) -> bytes:
    """Write a workbook with one test of a rate of its own in each sheet, every clock from zero."""
    sheets = {}
    for place, name in enumerate(names, 1):
        table = [[t / 10, 0.5 * place, 5.0, 0.1 * place] for t in range(rows)]
        sheets[name] = [["Time [s]", "Friction Force [N]", "Normal Load [N]", "COF"], *table]
    return xlsx(sheets)


PHOENIX_NAMES = (
    "Time", "This Step", "Step Time", "Test Time", "Sliding Velocity", "Speed", "Mass", "Load", "TOTAL REVOLUTIONS",
    "Specimen Temp", "Contact Potential", "Radius", "Distance", "Friction Force", "Friction Coefficient",
    "Displacement", "Friction Force",
)  # fmt: skip
PHOENIX_HEAD = (
    "Data file\t\tTEST_2.TSV", "Configuration file\t\tTE67.CFG", "Calibration file\t\tTE67.CAL",
    "Test control file\t\tWEAR.TCF", "", "test 2\t\tP-17", "17", "Ana", "", "",
    "Test started at 20:09:56 on 2019-04-09",
)  # fmt: skip


class Polymer(NamedTuple):
    """A flat pin of a polymer on a ring or disc, 60 N, at 1 Hz, and what is true of it."""

    rows: int = 1800
    radius: float = 25.0
    """Track, mm."""
    rpm: float = 191.0
    friction: float = 0.25
    wear: float = 404.0
    """Displacement of the sensor at the end, µm; it falls with wear."""

    @property
    def distance(self) -> float:
        """Distance slid, m."""
        return math.tau * self.radius / 1000 * self.rpm / 60 * self.rows


POLYMER = Polymer()


def phoenix(truth: Polymer = POLYMER, *, glitch: bool = False) -> bytes:
    """Write a test of a TE67: no units, two friction forces, and a counter that is one back once."""
    rng = np.random.default_rng(67)
    time = np.arange(1, truth.rows + 1)
    turns = np.floor(truth.rpm / 60 * time)
    if glitch:
        turns[57:60] = [186, 185, 188]
    speed = math.tau * truth.radius / 1000 * truth.rpm / 60
    mu = truth.friction + rng.normal(0, 0.005, truth.rows)
    load = 59.841 + rng.normal(0, 0.05, truth.rows)
    sensor = 120 - truth.wear * time / truth.rows + rng.normal(0, 0.3, truth.rows)
    rows = []
    for i, t in enumerate(time):
        numbers = [f"{t}", "1", "3600,", f"{t}", f"{speed:.4f}", f"{truth.rpm:.1f}", "6100", f"{load[i]:.3f}"]
        numbers += [f"{turns[i]:.0f}", "23.4", "0.012", f"{truth.radius:.0f}", f"{speed * t:.3f}"]
        numbers += [f"{mu[i] * load[i]:.4f}", f"{mu[i]:.5f}", f"{sensor[i]:.2f}", f"{0.97 * mu[i] * load[i] + 0.4:.4f}"]
        rows.append("\t" + "\t".join(number.replace(".", ",") for number in numbers))
    return "\r\n".join([*PHOENIX_HEAD, "\t" + "\t".join(PHOENIX_NAMES), *rows, ""]).encode()


class Reciprocation(NamedTuple):
    """A reciprocating test of 200 gf in segments, and what is true of it."""

    segments: int = 4
    strokes: int = 40
    """In each segment."""
    samples: int = 24
    """In each stroke."""
    frequency: float = 1.0
    stroke: float = 5.0
    """mm."""
    friction: float = 0.844
    """In the middle of a stroke; it falls towards both turning points."""


UMT_TOP = (
    "Created by CETR Data Viewer ver.2.19.106 05/12/22 14:43:46",
    "Created by CETR UMT ver.1.136.257 12 May 2022 12:21:50",
    "Total number of runs - 1",
)


RECIPROCATION = Reciprocation()


def umt(truth: Reciprocation = RECIPROCATION) -> bytes:
    """Write a test there and back: Fx has the sign of the stroke, Ff its size, and COF is Ff over Fz."""
    lines = [*UMT_TOP, f"Total number of steps = {truth.segments}", ""]
    rng = np.random.default_rng(12)
    count = truth.strokes * truth.samples
    for number in range(1, truth.segments + 1):
        lines += [f"Step No. {number}", "", "Set Force    = -200", f"Data Count   = {count}"]
        lines += [f"Started at: 12:{20 + number}:58.029 12 May 2022", ""]
        lines += ["Fx,Fz,Z,Y,X,V1,V2,V3,T,Ff,COF", "g,g,mm,mm,mm,mm/sec,mm/sec,mm/sec,sec,g,", ""]
        phase = (np.arange(count) + 0.5) / truth.samples
        time = phase / (2 * truth.frequency)
        load = -200 + rng.normal(0, 0.5, count)
        within = phase % 1
        shape = np.minimum(1.0, 8 * np.minimum(within, 1 - within))
        force = np.where(phase.astype(int) % 2, -1, 1) * truth.friction * shape * -load
        place = truth.stroke / 2 * (1 - np.cos(np.pi * phase))
        for fx, fz, x, t in zip(force, load, place, time, strict=True):
            ff = abs(fx)
            lines.append(f"{fx:.6f},{fz:.6f},-0.6850,0.000000,{x:.6f},0.0,0.0,0.0,{t:.4f},{ff:.6f},{ff / -fz:.6f}")
        lines.append("")
    return "".join(f"{line}\r\n" for line in lines).encode()


SRV_COLUMNS = {
    "Tick": "",
    "Time": "[s]",
    "Temperature 1": "[°C]",
    "OelPump Temperature": "[°C]",
    "Frequency": "[Hz]",
    "OelPump Speed": "[%]",
    "Stroke sliding speed average value current": "[m/s]",
    "Friction COF effective value": "",
    "Load": "[N]",
    "Friction absolute integral": "[1/µm]",
    "COF (peak)": "",
    "COF hysteresis value": "",
    "Stroke": "[mm]",
}


def srv(rows: int = 120) -> bytes:
    """Write the numeric sheet of an SRV: 50 Hz, 1 mm, 200 N, one row per second, friction defined in three ways."""
    rng = np.random.default_rng(50)
    table = [list(SRV_COLUMNS), [unit or None for unit in SRV_COLUMNS.values()]]
    for t in range(rows):
        friction = 0.11 + float(rng.normal(0, 0.001))
        row = [float(t), float(t), 50.1, 22.0, 50.0, 0.0, 0.1, friction, 200.0 + float(rng.normal(0, 0.2))]
        table.append([*row, 1.002 * friction, 1.55 * friction, 0.0, 1.0])
    return xlsx({"SheetName Numeric SRA": table})

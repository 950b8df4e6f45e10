"""Ten exports in the shapes of ten instruments, with what a lab knows beside them, and the commands a new user types.

    python tests/own_exports.py FOLDER

writes them into a folder and runs their commands; the table it prints is that of docs/own_file.md.
"""

import math
import shlex
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from built_files import xlsx
from instrument_shapes import POLYMER, phoenix, rtec_ladder, srv, umt

K_D = 2e-14
"""m²/N: the truth of all exports that have a depth."""
LOAD, RADIUS, SPEED, RATE, DURATION = 5.0, 3e-3, 0.1, 1.0, 3600.0
"""N, m, m/s, Hz, s."""
MU = 0.42


@dataclass(frozen=True)
class Case:
    """An export, or several, of one instrument, and what its user does."""

    title: str
    files: dict[str, bytes]
    commands: tuple[str, ...]
    """Without the `tribopipe` in front."""
    k_d: float | None = None
    """True wear coefficient, m²/N; none where the file holds friction alone."""
    template: str = ""
    """lab.toml: what the lab always does the same way."""
    recipe: str = ""
    """recipe.toml, where the lab has one."""
    typed: tuple[str, ...] = field(default=())
    """Values in the commands that neither the file, its name, the recording nor the template holds."""


def recorded(seed: int, *, load: float = LOAD) -> dict[str, np.ndarray]:
    """Record a ball that wears by Archard's law on a disc that does not, V = k_D·F·s and h = √(V/πR)."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, DURATION, 1 / RATE)
    s = SPEED * t
    mu = MU + rng.normal(0, 0.004, len(t))
    force = load + rng.normal(0, 0.01, len(t))
    depth = np.sqrt(K_D * load * s / (np.pi * RADIUS)) + rng.normal(0, 20e-9, len(t))
    return {"t": t, "s": s, "mu": mu, "load": force, "friction": mu * force, "depth": 1e6 * depth}


def rows(columns: list[tuple[np.ndarray, int]], separator: str, decimal: str = ".") -> str:
    lines = zip(*([f"{value:.{digits}f}" for value in values] for values, digits in columns), strict=True)
    return "".join(separator.join(line).replace(".", decimal) + "\r\n" for line in lines)


BALL = """\
schema = "tribopipe.template/1"
[contact]
kind = "pin-on-disc"
[contact.pin]
shape = "spherical"
material = "100Cr6"
youngs_modulus = "210 GPa"
poisson_ratio = 0.3
{radius}[contact.disc]
material = "AlSi10Mg"
youngs_modulus = "72 GPa"
poisson_ratio = 0.33
"""


def german() -> Case:
    run = recorded(1)
    head = (
        "Prüfstand;Tribometer 3\r\nVersuch;Kugel-Scheibe, trocken\r\nDatum;12.05.2022 14:30:00\r\nPrüfer;Müller\r\n"
        "Normalkraft;5 N\r\nBahnradius;5 mm\r\nGleitgeschwindigkeit;0,1 m/s\r\nKugel 100Cr6 D=6 mm\r\n"
        "Scheibe;AlSi10Mg\r\nTemperatur;23 °C\r\nLuftfeuchte;45 %\r\nUmgebung;Luft\r\n\r\n"
        "Zeit [s];Weg [m];Reibkraft [N];Reibwert;Verschleißweg [µm]\r\n"
    )
    columns = [(run["t"], 1), (run["s"], 3), (run["friction"], 4), (run["mu"], 4), (run["depth"], 4)]
    file = "Versuch_17.csv"
    content = (head + rows(columns, ";", ",")).encode("cp1252")
    return Case(
        "German header block",
        {file: content},
        (f"new {file} --template lab.toml", "process Versuch_17"),
        K_D,
        BALL.format(radius=""),
    )


def workbook() -> Case:
    sheets: dict[str, list[list[object]]] = {
        "Parameters": [
            ["Operator", "A. Tester"],
            ["Normal load", "5 N"],
            ["Track radius", "5 mm"],
            ["Ball diameter", "6 mm"],
            ["Ball material", "100Cr6"],
            ["Relative humidity", "45 %"],
        ]
    }
    for number in (1, 2):
        run = recorded(10 + number)
        table = np.column_stack([run["t"], run["s"], run["friction"], run["depth"]])[::4]
        names = ["Time (s)", "Sliding distance (m)", "Friction force (N)", "Linear wear (µm)"]
        sheets[f"Test {number}"] = [names, *table.tolist()]
    return Case(
        "Three-sheet workbook",
        {"tests.xlsx": xlsx(sheets)},
        ("new tests.xlsx --each-sheet --template lab.toml", "process ."),
        K_D,
        BALL.format(radius=""),
    )


FLAT = """\
schema = "tribopipe.template/1"
[contact]
kind = "pin-on-disc"
[contact.pin]
shape = "flat"
radius = "4 mm"
material = "PTFE compound"
youngs_modulus = "0.8 GPa"
poisson_ratio = 0.45
[contact.disc]
material = "100Cr6"
youngs_modulus = "210 GPa"
poisson_ratio = 0.3
"""


STEPS = (
    *("continuous-axes", "mask", "zero", "pressing-load", "friction-sign", "idle", "unloaded-friction"),
    "stroke-wise-friction",
)
DOWNWARDS = (
    'schema = "tribopipe.recipe/1"\n'
    + "".join(f'[[clean_up]]\nstep = "{step}"\n' for step in STEPS)
    + '[[clean_up]]\nstep = "invert"\nsignals = ["depth"]\n'
)
"""The sensor of the TE67 counts down as the pin wears."""


POLYMER_K_D = math.pi * 4e-3**2 * POLYMER.wear * 1e-6 / (59.841 * POLYMER.distance)
"""k_D = V/(F·s) of a flat pin, V = πR²·h."""


def compend() -> Case:
    return Case(
        "Phoenix Compend (TE67)",
        {"TEST_2.TSV": phoenix()},
        ("new TEST_2.TSV --template lab.toml --accept", "process TEST_2 --recipe recipe.toml"),
        POLYMER_K_D,
        FLAT,
        DOWNWARDS,
    )


def optimol() -> Case:
    return Case(
        "Optimol SRV",
        {"SRV-0815.xlsx": srv(600)},
        ("new SRV-0815.xlsx --template lab.toml --accept", "process SRV-0815"),
        None,
        'schema = "tribopipe.template/1"\n[signals]\n'
        'columns = { friction_coefficient = "Friction COF effective value" }\n',
    )


def cetr() -> Case:
    return Case("CETR / Bruker UMT, segments", {"umt_03.csv": umt()}, ("new umt_03.csv --accept", "process umt_03"))


def rtec() -> Case:
    return Case(
        "Rtec MFT, steps",
        {"ladder.csv": rtec_ladder()},
        ("new ladder.csv --split Step --accept", "process ."),
        None,
    )


def mtm() -> Case:
    rng = np.random.default_rng(8)
    names = [
        "Step Time (s)",
        "Lube Temp (°C)",
        "Ball Load (N)",
        "Sliding Speed (mm/s)",
        "Traction Force (N)",
        "Traction Coeff (-)",
    ]
    lines = [
        "MTM2 Test Data File",
        "Profile description:\tWear",
        "Disc track radius:\t20.5",
        "Lubricant name:\tPAO 6",
        "Number of steps in profile:\t1",
        "Test started at 13/02/2017 15:47",
        "",
        'Step 1 "Rub" started at 13/02/2017 15:48',
        "Step type\tTIMED\tStep description\tRub",
        "       Ball load = 20 N",
        "",
        "\t".join(names),
    ]
    for t in range(10, 6010, 10):
        mu, load = 0.09 + rng.normal(0, 0.001), 20 + rng.normal(0, 0.03)
        lines.append(f"{t}\t{40 + rng.normal(0, 0.1):.1f}\t{load:.3f}\t50.0\t{mu * load:.4f}\t{mu:.4f}")
    lines += ["", "All steps completed, test completed normally at 13/02/2017 17:35"]
    return Case(
        "PCS MTM",
        {"MTM run 4.txt": "".join(f"{line}\r\n" for line in lines).encode()},
        ("new 'MTM run 4.txt' --accept", "process MTM-run-4"),
        None,
    )


def csm() -> Case:
    run = recorded(5)
    n = len(run["t"])
    names = (
        "Time [s]\tDistance [m]\tLaps\tSequence ID\tCycle ID\tMax Linear Speed [m/s]\tNominal Load [N]\tµ\tAngle [°]\t"
        "Friction Force [N]\tTemperature [°C]\tHumidity [%]\tPenetration Depth [µm]\r\n"
    )
    laps = run["s"] / (2 * np.pi * 5e-3)
    columns = [
        (run["t"], 2),
        (run["s"], 3),
        (laps, 2),
        (np.ones(n), 0),
        (np.ones(n), 0),
        (np.full(n, SPEED), 1),
        (np.full(n, LOAD), 0),
        (run["mu"], 4),
        (360 * (laps % 1), 1),
        (run["friction"], 4),
        (np.full(n, 23.1), 1),
        (np.full(n, 44.0), 1),
        (run["depth"], 4),
    ]
    content = b"\xef\xbb\xbf" + (names + rows(columns, "\t")).encode()
    return Case(
        "Anton Paar / CSM",
        {"TRB3_ball D6.txt": content},
        ("new 'TRB3_ball D6.txt' --template lab.toml", "process TRB3_ball-D6"),
        K_D,
        BALL.format(radius='radius = "3 mm"\n'),
    )


def labview() -> Case:
    run = recorded(6)
    temperature = np.full(len(run["t"]), 23.5)
    columns = [(run["t"], 2), (run["friction"], 4), (run["load"], 3), (run["depth"], 4), (temperature, 1)]
    content = "Time (s)\tFx (N)\tFz (N)\tZ (Microns)\tTemp (Deg C)\r\n" + rows(columns, "\t")
    file = "2026-03-04_5N_100mms_ball6mm_r5mm.txt"
    return Case(
        "Plain LabVIEW columns",
        {file: content.encode()},
        (f"new {file} --template lab.toml --accept", f"process {file.removesuffix('.txt')}"),
        K_D,
        BALL.format(radius=""),
    )


def polish() -> Case:
    run = recorded(7, load=10.0)
    content = "      Czas        Ft\r\n         s         N\r\n" + "".join(
        f"{t:10.1f}{f:10.3f}\r\n".replace(".", ",") for t, f in zip(run["t"], run["friction"], strict=True)
    )
    return Case(
        "Polish space-padded columns",
        {"T01M_10N_0,1m_s.txt": content.encode("cp1250")},
        ("new T01M_10N_0,1m_s.txt --accept", "process T01M_10N_0-1m_s"),
        None,
    )


CASES = (german, workbook, compend, optimol, cetr, rtec, mtm, csm, labview, polish)


def written(case: Case, folder: Path) -> Path:
    """Write what a user starts with."""
    folder.mkdir(parents=True)
    for name, content in case.files.items():
        (folder / name).write_bytes(content)
    if case.template:
        (folder / "lab.toml").write_text(case.template, encoding="utf-8")
    if case.recipe:
        (folder / "recipe.toml").write_text(case.recipe, encoding="utf-8")
    return folder


def main(folder: Path) -> None:
    """Run the commands of each, and write the table of the page."""
    for make in CASES:
        case, said = make(), ""
        home, begun = written(case, folder / make.__name__), time.monotonic()
        for command in case.commands:
            done = subprocess.run(
                [sys.executable, "-m", "tribopipe", *shlex.split(command)],
                cwd=home,
                capture_output=True,
                text=True,
                check=False,
                encoding="utf-8",
            )
            said += f"$ tribopipe {command}   # exit {done.returncode}\n{done.stdout}{done.stderr}"
        (folder / f"{make.__name__}.log").write_text(said, encoding="utf-8")
        held, commands = "friction" if case.k_d is None else "wear rate", "`, `".join(case.commands)
        took = f"{time.monotonic() - begun:.0f} s"
        sys.stdout.write(f"| {case.title} | `{commands}` | {len(case.typed)} | {held} | {took} |\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]))

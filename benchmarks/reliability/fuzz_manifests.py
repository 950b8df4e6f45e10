"""run.toml and the other documents of a lab, changed 100 000 times: each is taken, or refused in one sentence.

In half of the cases, the structure of a document is changed (values of other types and magnitudes, other units,
look-alike letters, keys exchanged, renamed, nested, repeated); in a quarter, its lines; in a quarter, its bytes. The
originals are the sample runs, runs with all keys of run.toml, and recipes, studies, plans, templates and readers.
"""

import random
import sys
import tomllib
from collections.abc import Iterator, Mapping
from functools import cache

from fuzzing import ROOT, Case, main
from mutations import changed_bytes, changed_document, changed_lines

_SAMPLES = ROOT / "sample_runs"
_ROWS = 40
_PROFILE = "".join(f"{0.01 * x:.2f} {-min(0.0, 0.05 - 1e-4 * (x - 50) ** 2):.4f}\n" for x in range(101))
_EVERYTHING = """schema = "tribopipe.run/1"
id = "everything"
started = 2024-05-12T12:21:58+02:00
title = "All that a pin can have"
operator = "N. N."
[contact]
kind = "pin-on-disc"
[contact.pin]
shape = "truncated-sphere"
radius = { value = "0.794 mm", standard_uncertainty = "0.2 %" }
flat_radius = "20 um"
material = "Si3N4"
youngs_modulus = "304 GPa"
poisson_ratio = 0.24
density = "3.21 g/cm^3"
surface_roughness = "20 nm"
vickers_hardness = 1500
fracture_toughness = "7 MPa*m^0.5"
[contact.disc]
material = "Si3N4"
youngs_modulus = "304 GPa"
poisson_ratio = 0.24
density = "3.21 g/cm^3"
diameter = "30 mm"
[conditions]
normal_load = { value = "200 mN", standard_uncertainty = "1 %" }
stroke = "5 mm"
frequency = "10 Hz"
sliding_distance = "2 m"
medium = "air"
temperature = "23 degC"
relative_humidity = "45 %"
friction = { amplitude = 0.2, steady_state = 0.4, running_in_distance = "30 m" }
[[signals]]
files = ["one.csv", "two.csv"]
reader = "rig.toml"
[[signals]]
file = "signals.csv"
separator = ","
decimal = "."
encoding = "ascii"
[signals.columns]
depth = { column = "Depth", unit = "um" }
friction_force = "Ff [mN]"
[end_values]
pin_mass_loss = { values = ["1.2 ug", "1.3 ug", "1.1 ug", "1.2 ug"], method = "balance" }
[[end_values.disc_profile]]
file = "track.txt"
position = { column = "x", unit = "mm" }
height = { column = "z", unit = "um" }
[[interruptions]]
sliding_distance = "0.5 m"
pin_scar_diameter = { value = "100 um", standard_uncertainty = "2 um", method = "microscope" }
[[interruptions]]
sliding_distance = "1 m"
pin_wear_depth = "1.5 um"
remounted = true
[sensors]
depth_scale = { value = 1.02, standard_uncertainty = "0.5 %" }
"""
_RIG = """schema = "tribopipe.reader/1"
name = "rig"
title = "Our rig"
detect = "^Rig"
separator = ";"
decimal = ","
starts_at = "^t;"
units_row = "below"
[columns]
t = { signal = "time" }
w = { signal = "normal_force", calibration = "cell" }
h = { signal = "temperature", unit = "degC", scale = 1.0, offset = 0.5 }
[calibrations.cell]
reading = "V"
unit = "N"
points = [[0.0, 0.0], [5.0, 10.0], [10.0, 21.0]]
outside = "missing"
[facts]
"conditions.normal_load" = { pattern = 'Load: (\\S+)', unit = "N" }
started = { pattern = 'Date: (.*)', date = "%d.%m.%Y %H:%M" }
"""
_RECIPE = """schema = "tribopipe.recipe/1"
[[clean_up]]
step = "mask"
limits = { temperature = { lowest = "0 degC", highest = "80 degC" }, friction_coefficient = { lowest = -0.1 } }
[[clean_up]]
step = "zero"
windows = [{ start = "0 s", end = "5 s" }]
[[clean_up]]
step = "despike"
window = 11
signals = ["depth"]
[drift]
window = 0.02
prior = "0.1 um"
[friction]
start = "0 m"
end = "400 m"
[wear]
models = ["archard"]
engine = "giwm"
[uncertainty]
normal_load = 0.01
track_width = "2 um"
[monte_carlo]
significant_digits = 1
seed = 1
"""
_TEMPLATE = """schema = "tribopipe.template/1"
operator = "N. N."
[contact]
kind = "pin-on-disc"
[contact.pin]
shape = "spherical"
radius = "0.794 mm"
[conditions]
medium = "air"
[signals]
reader = "delimited"
[signals.columns]
depth = "Depth [um]"
[sensors]
depth_scale = 1.0
"""


def _rig_export(first: int) -> bytes:
    rows = "".join(
        f"{0.5 * n:.1f};{0.1 * (n % 7):.1f};23,5\n".replace(".", ",") for n in range(first, first + _ROWS // 2)
    )
    return f"Rig 5\nLoad: 0.2\nDate: 12.05.2022 12:21\nt;w;h\ns;V;degC\n{rows}".encode()


def _short(name: str) -> dict[str, bytes]:
    """Give a sample run with its first rows."""
    folder = _SAMPLES / name
    lines = (folder / "signals.csv").read_bytes().splitlines(keepends=True)
    return {"run.toml": (folder / "run.toml").read_bytes(), "signals.csv": b"".join(lines[: _ROWS + 1])}


def _with_everything() -> dict[str, bytes]:
    rows = "".join(f"{0.5 * n:.1f},{0.01 * n:.3f},{80 + n % 3}\n" for n in range(_ROWS))
    return {
        "run.toml": _EVERYTHING.encode(),
        "rig.toml": _RIG.encode(),
        "one.csv": _rig_export(0),
        "two.csv": _rig_export(_ROWS // 2),
        "signals.csv": f"Time [s],Depth,Ff [mN]\n{rows}".encode(),
        "track.txt": f"x z\n{_PROFILE}".encode(),
    }


@cache
def seeds() -> Mapping[str, tuple[str, dict[str, bytes]]]:
    """Give what cases are made of: for each document that is changed, what it is and the files beside it."""
    runs = {path.parent.name: _short(path.parent.name) for path in sorted(_SAMPLES.glob("*/run.toml"))}
    runs["everything"] = _with_everything()
    found = {f"{name}/run.toml": ("run", files) for name, files in runs.items()}
    found["everything/rig.toml"] = ("run", runs["everything"])
    plan = (_SAMPLES / "plan.toml").read_bytes()
    study = (_SAMPLES / "si3n4-twin-disc.study.toml").read_bytes()
    alone = {
        "plan": plan,
        "study": study,
        "recipe": _RECIPE.encode(),
        "template": _TEMPLATE.encode(),
        "reader": _RIG.encode(),
    }
    return found | {f"{kind}.toml": (kind, {f"{kind}.toml": content}) for kind, content in alone.items()}


def sound() -> Case:
    """Give a run that nothing is wrong with."""
    return Case("si3n4-air-400mN", _short("si3n4-air-400mN"))


def unchanged() -> Iterator[Case]:
    """Give what cases are made of, with nothing changed."""
    for made_of, (kind, files) in seeds().items():
        yield Case(made_of, files, kind)


def make(draw: random.Random) -> Case:
    """Change one document."""
    made_of = draw.choice(list(seeds()))
    kind, files = seeds()[made_of]
    name = made_of.rpartition("/")[2]
    return Case(made_of, {**files, name: _changed(draw, files[name])}, kind)


def _changed(draw: random.Random, content: bytes) -> bytes:
    how = draw.random()
    if how < 0.5:
        return changed_document(draw, tomllib.loads(content.decode()))
    if how < 0.75:
        return changed_lines(draw, content.decode())
    _, others = draw.choice(list(seeds().values()))
    return changed_bytes(draw, content, draw.choice(list(others.values())))


if __name__ == "__main__":
    sys.exit(main("fuzz_manifests", "Mutated documents", __doc__, make, sound()))

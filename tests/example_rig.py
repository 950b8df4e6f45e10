"""A run recorded by the rig of tests/example_plugin, whose wear runs in by its law."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from tribopipe.records.manifest import PinOnDisc
from tribopipe.records.quantity import Quantity
from tribopipe.wear.predict import WearScenario

PLUGIN = Path(__file__).parent / "example_plugin"
K_D, EXCESS, LENGTH = 5e-15, 4.0, 30.0
"""m²/N, a ratio, m: the truth."""
SPEED, DISTANCE, RATE = 0.4, 500.0, 4.0
"""m/s, m, Hz."""
OFFSET, DRIFT, NOISE = 3e-6, -1.5e-10, 30e-9
"""m, m/s, m: of the depth sensor."""
RUN = """\
schema = "tribopipe.run/1"
id = "run-in"
[contact]
kind = "pin-on-disc"
[contact.pin]
shape = "spherical"
radius = "0.794 mm"
material = "Si3N4"
youngs_modulus = "304 GPa"
poisson_ratio = 0.24
[contact.disc]
material = "Si3N4"
youngs_modulus = "304 GPa"
poisson_ratio = 0.24
[conditions]
normal_load = { value = "200 mN", standard_uncertainty = "1 mN" }
sliding_speed = { value = "400 mm/s", standard_uncertainty = "0.1 mm/s" }
[[signals]]
file = "run.rig"
[end_values]
pin_wear_depth = { value = "DEPTH um", standard_uncertainty = "0.05 um" }
"""


def record(folder: Path, law) -> Path:
    """Write a run folder: a log of the rig, and a run.toml that names it, with the pin's depth measured afterwards."""
    rng = np.random.default_rng(10)
    time = np.arange(0.0, DISTANCE / SPEED, 1 / RATE)
    depth = worn(law, SPEED * time)
    read = OFFSET + DRIFT * time + depth + NOISE * rng.standard_normal(len(time))
    room = 21.0 + 6.0 * time / time[-1]
    rows = "".join(
        f"{t:.2f};{1e6 * d:.4f};{100 + 2 * noise:.2f};{warm:.1f};\n"
        for t, d, noise, warm in zip(time, read, rng.standard_normal(len(time)), room, strict=True)
    )
    folder.mkdir()
    log = f"RIG LOG 2\nload=200 mN\nt/s;d/um;Ff/mN;T/degC;\n{rows}"
    (folder / "run.rig").write_text(log, encoding="utf-8")
    told = RUN.replace("DEPTH", f"{1e6 * depth[-1] + 0.02:.4f}")
    (folder / "run.toml").write_text(told, encoding="utf-8")
    return folder


def worn(law, distance):
    """Return the pin's wear depth, m, by the GIWM and the law with its true parameters."""
    body = {"material": "Si3N4", "youngs_modulus": "304 GPa", "poisson_ratio": 0.24}
    contact = PinOnDisc.model_validate(
        {"kind": "pin-on-disc", "pin": {"shape": "spherical", "radius": "0.794 mm", **body}, "disc": body}
    )
    load, k_d = Quantity(value=0.2, unit="N"), Quantity(value=K_D, unit="m^2/N")
    scenario = WearScenario(contact, load, k_d)
    true = replace(law, excess=EXCESS, length=LENGTH)
    return scenario.worn(true.effective_distance(distance, None)).depth

"""A run recorded by the rig of tests/example_plugin, whose wear runs in by its law."""

from pathlib import Path

import numpy as np

from tribopipe.documents.plan import Series
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import MonteCarloRecipe, Recipe, WearRecipe
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.preprocessing.cleaning import clean_run
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.evaluation.wear.prediction import predict_wear
from tribopipe.evaluation.wear.scenario import KnownWear, Scenario, known_wear
from tribopipe.extras.simulate import VirtualTest
from tribopipe.extras.sweep.virtual_tests import recorded_run
from tribopipe.results.wear_fit import WearFit

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
disc_wear_depth = { value = "0 nm", standard_uncertainty = "5 nm" }
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


def worn(law, distance, load=0.2):
    """Return the pin's wear depth, m, by the GIWM and the law with its true parameters, under a load in N."""
    k_d = Quantity(value=K_D, unit="m^2/N")
    scenario = Scenario(series_of().contact, Quantity(value=load, unit="N"), KnownWear({"pin": k_d}))
    true = law.at({"law_excess": EXCESS, "law_length": LENGTH})
    return scenario.worn(true.effective_distance(distance, None))["wear_depth"]


BODY = {"material": "Si3N4", "youngs_modulus": "304 GPa", "poisson_ratio": 0.24}
SERIES = {
    "title": "wear that runs in",
    "law": "running_in",
    "law_parameters": {"excess": EXCESS, "length": f"{LENGTH} m"},
    "contact": {"kind": "pin-on-disc", "pin": {"shape": "spherical", "radius": "0.794 mm", **BODY}, "disc": BODY},
    "medium": "air",
    "systematic_errors": True,
    "sliding_speed": {"value": "400 mm/s", "standard_uncertainty": "0.5 mm/s"},
    "sliding_distance": f"{DISTANCE} m",
    "sensors": {"depth_noise": "30 nm", "sampling_rate": "2 Hz"},
    "runs": [
        {
            "id": "run-in",
            "started": "2026-01-01T09:00:00+01:00",
            "seed": 1,
            "normal_load": {"value": "200 mN", "standard_uncertainty": "0.5 %"},
            "wear_coefficient": f"{K_D} m^2/N",
            "friction": {"amplitude": 0.2, "steady_state": 0.5, "running_in_distance": "20 m"},
            "zero_offset": "1 um",
            "drift_rate": "2 nm/min",
        }
    ],
}
"""Virtual runs whose wear runs in by the same truth."""
JOINT = Recipe(wear=WearRecipe(correction="model"), monte_carlo=MonteCarloRecipe(significant_digits=0))


def series_of(**changes) -> Series:
    """Return the series with other keys, as a plan would say them."""
    return Series.model_validate({**SERIES, **changes})


def virtual(series: Series, seed: int, law: str = "running_in", recipe: Recipe = JOINT) -> tuple[VirtualTest, WearFit]:
    """Record a run of the series with a seed, and fit a law to it."""
    run = series.runs[0].model_copy(update={"seed": seed})
    test = VirtualTest(series, run)
    return test, fit_wear(correct_drift(clean_run(recorded_run(series, test)).run, recipe), law, None, recipe)


def predicted(series: Series, fit: WearFit, load: float, at: float) -> Quantity:
    """Return the wear depth that a fit predicts under a load in N, 0.5 % uncertain, at a sliding distance in m."""
    known, pressed = known_wear(fit), Quantity(value=load, unit="N", standard_uncertainty=0.005 * load)
    return predict_wear(Scenario(series.contact, pressed, known, fit.model), [at]).prediction[0].contact.approach

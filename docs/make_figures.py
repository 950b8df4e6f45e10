"""Make the figures of README.md and docs/ from sample_runs: `python docs/make_figures.py`."""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, get_args

import numpy as np
from contact_drawings import (
    draw_block_on_ring,
    draw_four_ball,
    draw_pin_on_disc,
    draw_reciprocating,
    draw_twin_disc,
)
from explained_figures import plot_disc_model, plot_drift_and_wear, plot_euler_steps
from hand_formula_figures import plot_d4172, plot_g77, plot_g99, plot_g133

from tribopipe.archive.store import Archive
from tribopipe.documents.manifest import MANIFEST_NAME, read_manifest
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe
from tribopipe.documents.twin_disc import CurvedDisc, FlatDisc, TwinDisc
from tribopipe.evaluation.measurements.track_profile import examined
from tribopipe.evaluation.wear.local import local_scenario, wear_locally
from tribopipe.evaluation.wear.scenario import KnownWear, Scenario
from tribopipe.physics.calculation_methods import DistanceConvention
from tribopipe.pipeline.stages import find_runs, process
from tribopipe.pipeline.studies import load_studies, run_study
from tribopipe.results.run import Profile
from tribopipe.views.archived_figures import save_run_figures, save_study_figures
from tribopipe.views.local_wear_figures import plot_local_wear
from tribopipe.views.profile_figures import draw_profile
from tribopipe.views.run_figures import save_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HERE = Path(__file__).parent
FIGURES = HERE / "figures"
SAMPLES = HERE.parent / "sample_runs"
SHOWN = (
    "si3n4-air-200mN-depth",
    "si3n4-air-200mN-friction",
    "si3n4-air-wear-archard",
    "si3n4-air-wear-sarkar",
    "si3n4-air-friction",
    "si3n4-air-coefficient",
    "wc-co-water-wear-archard",
    "si3n4-twin-disc-wear-archard",
)
ROTATIONS = 2_000_000


def main() -> None:
    """Process the sample runs and their studies, and keep the figures that are shown, as SVG."""
    with TemporaryDirectory() as folder:
        for path in processed(Archive(Path(folder))):
            if path.stem in SHOWN:
                (FIGURES / path.name).write_bytes(path.read_bytes())
    counting = {distance: table_3(distance) for distance in get_args(DistanceConvention)}
    across = worn_track()
    title = "Profile across a wear track (simulated)"
    drawn = {
        "twin-disc-table3.svg": plot_disc_model(counting, ROTATIONS, ROTATIONS),
        "disc-track-profile.svg": draw_profile(across, examined(across, None), title),
        "euler-steps.svg": plot_euler_steps(),
        "drift-and-wear-shapes.svg": plot_drift_and_wear(),
        "hand-formulas-g99.svg": plot_g99(),
        "hand-formulas-g133.svg": plot_g133(),
        "hand-formulas-g77.svg": plot_g77(),
        "hand-formulas-d4172.svg": plot_d4172(),
        "pin-on-disc.svg": draw_pin_on_disc(),
        "twin-disc.svg": draw_twin_disc(),
        "reciprocating.svg": draw_reciprocating(),
        "block-on-ring.svg": draw_block_on_ring(),
        "four-ball.svg": draw_four_ball(),
        **local_wear(),
    }
    for name, figure in drawn.items():
        save_figure(figure, FIGURES / name)


def processed(archive: Archive) -> list[Path]:
    """Take the sample runs and their studies through the whole line, and return the figures drawn."""
    for outcome in process(find_runs(SAMPLES), archive):
        if outcome.error is not None:
            raise outcome.error
    written = save_run_figures(archive, "si3n4-air-200mN", ["svg"])
    for study in load_studies(sorted(SAMPLES.glob("*.study.toml"))):
        for outcome in run_study(archive, study, Recipe()):
            if outcome.error is not None:
                raise outcome.error
        written += save_study_figures(archive, study.id, formats=["svg"])
    return written


def local_wear() -> "dict[str, Figure]":
    """Wear the paper's pin under 200 mN, and its two discs of Table 3, at every point of their contact."""
    manifest, _ = read_manifest(SAMPLES / "si3n4-air-200mN" / MANIFEST_NAME)
    pin = local_scenario(manifest, {"pin": Quantity(value=13.5e-15, unit="m^2/N")})
    places = [0.01, 0.1, 1.0, 10.0, 100.0, 500.0]
    discs = table_3("volume-conserving")
    turns = [1e4, 1e5, 1e6, 1e7, 2e7]  # of the crowned disc, at a slip of 10 %
    return {
        "local-wear-pin.svg": plot_local_wear(wear_locally(pin, places), "Si₃N₄, 200 mN"),
        "local-wear-discs.svg": plot_local_wear(wear_locally(discs, turns), "Table 3"),
    }


def worn_track() -> Profile:
    """Make up a scan across a track on a disc: tilted and rough, with piled-up material and a grain of dust."""
    x = np.linspace(0.0, 2e-3, 4001)
    middle, half = 1.05e-3, 0.25e-3
    groove = 6e-6 * np.maximum(0.0, 1 - ((x - middle) / half) ** 2)
    left, right = (np.exp(-(((x - middle - side * 1.16 * half) / 35e-6) ** 2) / 2) for side in (-1, 1))
    dust = np.where(np.abs(x - 0.35e-3) < 4e-6, 1.2e-6, 0.0)
    noise = 0.06e-6 * np.random.default_rng(7).standard_normal(len(x))
    return Profile(x, 0.004 * x - groove + 1.4e-6 * left + 0.9e-6 * right + dust + noise)


def table_3(distance: DistanceConvention) -> Scenario:
    """Return the case of the paper's Table 3; the radii are in its Fig. 7 only, and chosen here."""
    zirconia = {"material": "ZrO2", "youngs_modulus": "152 GPa", "poisson_ratio": 0.32, "rolling_radius": "4 mm"}
    return Scenario(
        contact=TwinDisc(
            kind="twin-disc",
            curved_disc=CurvedDisc.model_validate({**zirconia, "crown_radius": "4 mm"}),
            flat_disc=FlatDisc.model_validate(zirconia),
        ),
        normal_load=Quantity(value=0.3, unit="N"),
        slip=Quantity(value=0.1, unit="1"),
        known=KnownWear({"curved_disc": Quantity(value=1e-16, unit="m^2/N")}, distance=distance),
    )


if __name__ == "__main__":
    main()

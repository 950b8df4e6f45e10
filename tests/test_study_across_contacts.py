"""k_D of a ball on a disc, by its scar alone, predicts a block on a ring: processed, verified, reproduced, reported."""

import math
import shutil

import numpy as np
import pytest
from folders import SAMPLES

from tribopipe.archive.store import Archive
from tribopipe.physics.geometry import scar_radius_at, worn_depth
from tribopipe.results.wear_prediction import WearPrediction

BLOCK, BALL = "peek-block-on-ring-50N", "peek-ball-10N"
WEAR, RADIUS, LOAD, DISTANCE = 8e-15, 5e-3, 10.0, 500.0
"""k_D of the block in sample_runs/plan.toml, m²/N; of a ball of the same material, its radius, load and distance."""
RUN = """schema = "tribopipe.run/1"
id = "peek-ball-10N"
[contact]
kind = "pin-on-disc"
[contact.ball]
diameter = "10 mm"
material = "PEEK"
youngs_modulus = "3.7 GPa"
poisson_ratio = 0.4
[contact.disc]
material = "100Cr6"
youngs_modulus = "210 GPa"
poisson_ratio = 0.3
[conditions]
normal_load = "10 N"
sliding_speed = "100 mm/s"
track_radius = "15 mm"
medium = "air"
[[signals]]
file = "signals.csv"
[end_values]
ball_scar_diameter = {{ value = "{scar:.5f} mm", standard_uncertainty = "0.01 mm" }}
disc_wear_depth = {{ value = "0 nm", standard_uncertainty = "50 nm" }}
"""
STUDY = f"""schema = "tribopipe.study/1"
id = "peek"
fit = ["{BALL}"]
predict = ["{BLOCK}"]
laws = ["archard"]
"""


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    folder = tmp_path_factory.mktemp("lab")
    shutil.copytree(SAMPLES / BLOCK, folder / "runs" / BLOCK)
    ball = folder / "runs" / BALL
    ball.mkdir()
    depth = float(worn_depth(volume=WEAR * LOAD * DISTANCE, sphere_radius=RADIUS, flat_radius=0.0))
    scar = 2e3 * float(scar_radius_at(depth=depth, sphere_radius=RADIUS))
    (ball / "run.toml").write_text(RUN.format(scar=scar), encoding="utf-8")
    rows = [f"{time:.2f},3.0" for time in np.linspace(0, DISTANCE / 0.1, 501)]
    (ball / "signals.csv").write_text("\n".join(["time [s],friction_force [N]", *rows]), encoding="utf-8")
    (folder / "runs" / "peek.study.toml").write_text(STUDY, encoding="utf-8")
    return folder


@pytest.mark.slow
def test_the_block_is_predicted_in_its_own_name(lab, run_cli):
    at = ("--archive", lab / "archive")
    done = run_cli("process", lab / "runs", "--no-figures", *at)
    assert done.exit_code == 0, done.stderr
    archive = Archive(lab / "archive")
    law = archive.study("peek").result.law("archard")
    assert law.first.wear_coefficient.value == pytest.approx(WEAR, rel=0.01)
    block = law.runs[1].bodies["block"]
    assert block.outcome == "supported"
    assert math.isclose(block.predicted.value, block.measured.value, rel_tol=0.02)
    predicted = archive.result(BLOCK, "prediction_archard", WearPrediction)
    assert predicted.prediction[-1].bodies["block"].wear_depth.value == pytest.approx(block.predicted.value, rel=0.01)
    for command in (("verify",), ("reproduce", BLOCK), ("study", "show", "peek", "-v"), ("study", "figures", "peek")):
        again = run_cli(*command, *at)
        assert again.exit_code == 0, again.stderr
    report = run_cli("report", "peek", "-o", lab / "report.html", *at)
    assert report.exit_code == 0, report.stderr
    assert "for a contact or geometry different from that of" in (lab / "report.html").read_text(encoding="utf-8")

"""The simulator behind benchmarks/misfit.py: its wear against closed forms, its noise, and the way into tribopipe."""

from dataclasses import replace

import numpy as np
import pytest
from independent.bench_cases import CASES
from independent.bench_files import manifest_text, write_recording
from independent.ideal import ideal_spread
from independent.noise import Autoregressive, Pink, Walk, White
from independent.regimes import REGIMES
from independent.runs import course
from independent.score import Outcome, outcome
from independent.wear import Tip, both_worn

from tribopipe.readers.harmonize import read_run


@pytest.mark.parametrize("flat", [0.0, 50e-6])
def test_a_rigid_tip_loses_the_volume_above_its_flat(flat):
    tip = Tip("truncated-sphere" if flat else "spherical", 3e-3, 5.0, np.inf, flat)
    volume = np.array([1e-14, 1e-12, 1e-11])
    assert [tip.volume(depth) for depth in tip.worn(volume).depth] == pytest.approx(volume, rel=2e-5)


def test_an_elastic_tip_wears_as_the_incremental_model_of_the_paper():
    # Explicit steps of the paper's flow chart, from Hertz-like contact: WC-Co, 400 mN, 500 m.
    radius, load, modulus, total = 0.794e-3, 0.4, 165.8e9, 0.75e-17 * 0.4 * 500
    steps, depth, elastic = 200_000, 0.0, 1.0e-7
    for _ in range(steps):
        height = depth + elastic
        contact = (height * (2 * radius - height)) ** 0.5
        elastic = load / (2 * modulus * contact)
        depth += total / steps / (np.pi * contact**2)
    assert Tip("spherical", radius, load, modulus).worn(np.array([total])).depth[0] == pytest.approx(depth, rel=2e-4)


@pytest.mark.parametrize(("ratio", "ball", "groove"), [(0.1, 23.2545, 0.02371), (60, 20.2757, 11.5808)])
def test_ball_and_groove_wear_by_the_cubic_outline(ratio, ball, groove):
    volume, path = 1.35e-14 * 0.2 * 500, 2 * np.pi * 4e-3
    worn = both_worn(0.794e-3, ratio, path, np.array([volume]))
    assert (worn.ball[0] * 1e6, worn.groove[0] * 1e6) == pytest.approx((ball, groove), rel=1e-3)
    half = (worn.ball[0] * 2 * 0.794e-3) ** 0.5
    assert worn.groove[0] / worn.ball[0] == pytest.approx(4 / 3 * ratio / path * half, rel=1e-9)


def test_a_disc_that_hardly_wears_hardly_changes_the_reading():
    regime = REGIMES["Si3N4"]
    plain, worn = (course(regime, {}, regime.coefficient, disc).shown for disc in (0.0, 0.1e-6))
    assert np.all(np.abs(worn - plain) < 0.12e-6)


@pytest.mark.slow
@pytest.mark.parametrize("noise", [White(1.0), Autoregressive(1.0, 2.0), Pink(1.0), Walk(1.0)])
def test_block_means_vary_as_their_covariance_says(noise):
    rng, blocks = np.random.default_rng(1), 8
    drawn = np.array([noise.draw(rng, 400, 0.1).reshape(blocks, -1).mean(axis=1) for _ in range(4000)])
    stated = noise.covariance(400, 0.1, blocks)
    assert np.cov(drawn.T) == pytest.approx(stated, abs=0.08 * np.max(stated))


def test_of_a_flat_pin_with_drift_the_anchor_alone_tells():
    regime = REGIMES["flat pin"]
    depth = regime.coefficient * regime.load * regime.distance / (np.pi * regime.radius**2)
    anchor_alone = np.hypot.reduce([1.5e-6 / depth, 0.01, 0.005, 2 * 0.002])
    assert ideal_spread(regime) == pytest.approx(anchor_alone, rel=0.01)


@pytest.mark.slow
def test_white_noise_tells_no_more_than_its_samples():
    loud = replace(REGIMES["Si3N4"], noise=(White(1e-3),))
    quiet = replace(loud, noise=(White(1e-9),))
    assert ideal_spread(loud) > 1.5 * ideal_spread(quiet)


def test_a_run_is_evaluated_as_process_does():
    from independent.runs import simulate

    found = outcome(simulate(REGIMES["flat pin"], np.random.default_rng(1)), "archard", judged=False)
    assert isinstance(found, Outcome)
    assert not found.beyond(4)


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_bench_cases_are_read_from_their_files(case, tmp_path):
    run = CASES[case](np.random.default_rng(1))[0]
    short = replace(run, columns={name: values[:300] for name, values in run.columns.items()})
    path = write_recording(case, [short], tmp_path)
    (tmp_path / "run.toml").write_text(manifest_text(case, short, "bench", file=path.name), encoding="utf-8")
    read = read_run(tmp_path)
    assert read.columns["depth"] == pytest.approx(short.columns["depth"], abs=0.6e-9)
    assert read.columns["normal_force"] == pytest.approx(short.columns["normal_force"], abs=0.6e-3)

"""The whole line on sample_runs, against the truth they were made from and the paper's own story."""

import json

import numpy as np
import pytest
from folders import FURTHER_IDS, SAMPLE_IDS, SAMPLES
from sweeps import others_slow

from tribopipe.documents.plan import Truth
from tribopipe.documents.recipe import Recipe
from tribopipe.evaluation.wear.prediction import fitted_curves, run_scenario
from tribopipe.evaluation.wear.scenario import known_wear
from tribopipe.pipeline.archived_results import archived_correction, archived_fit, archived_friction
from tribopipe.results.wear_prediction import WearPrediction

MM3_PER_N_MM = 1e-6  # m²/N


def truth_of(run_id: str) -> Truth:
    return Truth.model_validate(json.loads((SAMPLES / run_id / "truth.json").read_text(encoding="utf-8")))


def test_nine_in_ten_parameters_lie_in_their_95_percent_interval(sample_archive):
    held = []
    for run_id in SAMPLE_IDS:
        truth, friction = truth_of(run_id), archived_friction(sample_archive, run_id)
        low, high = (end.value for end in archived_fit(sample_archive, run_id, truth.law).first.interval)
        held.append(low <= truth.wear_coefficient.value <= high)
        for name in ("amplitude", "steady_state", "running_in_distance"):
            found = getattr(friction, name)
            held.append(abs(found.value - getattr(truth.friction, name).value) <= 1.96 * found.standard_uncertainty)
    assert len(held) == 28
    assert sum(held) >= 0.9 * len(held)


@pytest.mark.parametrize(("law", "coefficient"), [("archard", 13.5e-9), ("sarkar", 10.2e-9)])
def test_coefficients_of_the_paper_come_back_from_200_mn(sample_archive, law, coefficient):
    found = archived_fit(sample_archive, "si3n4-air-200mN", law).first.wear_coefficient.value / MM3_PER_N_MM
    assert found == pytest.approx(coefficient, rel=0.03)


def test_coefficient_of_tungsten_carbide_lies_in_its_interval(sample_archive):
    low, high = (end.value for end in archived_fit(sample_archive, "wc-co-water-400mN", "archard").first.interval)
    assert low <= 0.75e-11 * MM3_PER_N_MM <= high


def predicted_over_measured(archive, run_id: str) -> float:
    prediction = archive.step(run_id, "prediction_archard").result
    assert isinstance(prediction, WearPrediction)
    assert prediction.reference == "si3n4-air-200mN"
    measured = archived_fit(archive, run_id, "archard").first.measured_end_depth.value
    return prediction.prediction[0].contact.approach.value / measured


def test_400_mn_is_predicted_from_200_mn(sample_archive):
    assert predicted_over_measured(sample_archive, "si3n4-air-400mN") == pytest.approx(1.0, abs=0.05)


def test_800_mn_is_over_predicted_from_200_mn(sample_archive):
    assert predicted_over_measured(sample_archive, "si3n4-air-800mN") > 1.25


def test_800_mn_ends_only_slightly_deeper_than_400_mn():
    ratio = truth_of("si3n4-air-800mN").end_pin_wear_depth.value / truth_of("si3n4-air-400mN").end_pin_wear_depth.value
    assert 1.0 < ratio < 1.1


@pytest.mark.parametrize("run_id", others_slow(FURTHER_IDS))
def test_k_d_of_both_bodies_comes_back_in_every_further_contact(further_run, run_id):
    truth, fit = truth_of(run_id), archived_fit(further_run(run_id), run_id, "archard")
    true = (truth.wear_coefficient, truth.disc_wear_coefficient)
    assert len(fit.bodies) == 2
    for known, body in zip(true, fit.bodies.values(), strict=True):
        low, high = (end.value for end in body.interval)
        assert low <= known.value <= high
        assert high < 1.4 * low
    assert [one.code for one in further_run(run_id).findings(run_id) if one.severity != "note"] == []


@pytest.mark.slow
@pytest.mark.parametrize("run_id", others_slow(FURTHER_IDS))
def test_fitted_curve_of_every_further_contact_is_that_of_its_model(further_run, run_id):
    run, fit = (
        archived_correction(further_run(run_id), run_id).run,
        archived_fit(further_run(run_id), run_id, "archard"),
    )
    curve = fitted_curves(run, fit).bands["wear_depth"].best
    assert curve[-1] == pytest.approx(fit.first.fitted_end_depth.value, rel=1e-4)
    some = np.linspace(1, len(curve) - 1, 12).astype(int)
    scenario = run_scenario(run, "archard", known_wear(fit), None, Recipe())
    exact = scenario.worn(run.progress[some])["wear_depth"]
    assert curve[some] == pytest.approx(exact * curve[-1] / exact[-1], abs=5e-4 * curve[-1])

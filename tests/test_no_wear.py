"""Predictions by a k_D that is zero, or below zero within its uncertainty."""

import math

import pytest
from end_value_runs import RADIUS, described, run_of, si

from tribopipe.documents.recipe import MonteCarloRecipe, Recipe
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.evaluation.wear.prediction import predict_wear, wear_scenario
from tribopipe.evaluation.wear.scenario import known_wear
from tribopipe.physics.geometry import worn_depth

FIRST_ORDER = Recipe(monte_carlo=MonteCarloRecipe(significant_digits=0))


@pytest.mark.parametrize("lost", [0.0, -1e-12])
def test_predicted_depth_is_zero_and_as_uncertain_as_the_cap_of_the_uncertain_volume(lost):
    run = run_of(described(conditions={"normal_load": si(0.2, "N", 0.0)}, pin_wear_volume=si(lost, "m^3", 3e-12)))
    known = known_wear(fit_wear(run, "archard", recipe=FIRST_ORDER))
    found = predict_wear(wear_scenario(run.manifest, known, recipe=FIRST_ORDER), [500.0])
    depth = found.prediction[0].bodies["pin"].wear_depth
    cap = float(worn_depth(volume=3e-12, sphere_radius=RADIUS, flat_radius=0.0))
    assert depth.value == 0
    assert depth.standard_uncertainty == pytest.approx(cap, rel=1e-3)
    assert any("is negative" in note for note in found.notes) == (lost < 0)
    assert math.isfinite(found.bodies["pin"].wear_coefficient.value)

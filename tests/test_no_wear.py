"""Measurements that show no wear, and predictions by a k_D that is zero or below zero within its uncertainty."""

import math

import pytest
from end_value_runs import CIRCLE, RADIUS, described, run_of, si
from pydantic import ValidationError
from test_block_on_ring import RADIUS as RING_RADIUS
from test_block_on_ring import WIDTH, block_on_ring, read
from test_block_on_ring import run_of as block_run

from tribopipe.base.errors import FitError, ManifestError
from tribopipe.documents.recipe import DefaultUncertainty, MonteCarloRecipe, Recipe
from tribopipe.evaluation.checks.registry import check_run
from tribopipe.evaluation.measurements.pin_on_disc import pin_on_disc_wear
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.evaluation.wear.prediction import predict_wear, wear_scenario
from tribopipe.evaluation.wear.scenario import known_wear
from tribopipe.physics.geometry import cap_height, segment_area, worn_depth, worn_volume

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


@pytest.mark.parametrize("lost", [0.0, -1e-12])
def test_a_pin_without_wear_reaches_no_depth_beside_a_disc_that_wears(lost):
    ends = {"pin_wear_volume": si(lost, "m^3", 3e-12), "disc_track_area": si(1e-8, "m^2", 1e-10)}
    run = run_of(described(conditions={"normal_load": si(0.2, "N", 0.0), **CIRCLE}, **ends))
    known = known_wear(fit_wear(run, "archard", recipe=FIRST_ORDER))
    assert [*known.bodies] == ["pin", "disc"]
    scenario = wear_scenario(run.manifest, known, recipe=FIRST_ORDER)
    with pytest.raises(FitError, match="a pin that does not wear"):
        predict_wear(scenario, depths=[5e-6])
    assert predict_wear(scenario, [500.0]).prediction[0].bodies["disc"].wear_depth.value > 1e-6


SPREAD = 20e-6
UNSEEN = si(0.0, "m", SPREAD)
NO_GROOVE = {"disc_wear_depth": si(0.0, "m", 2e-8)}


def cap(scar):
    """Volume of a cap by the diameter of its base, m³."""
    return float(worn_volume(depth=cap_height(scar_radius=scar / 2, sphere_radius=RADIUS), sphere_radius=RADIUS))


@pytest.mark.parametrize("way", ["pin_scar_diameter", "pin_scar_length", "pin_scar_width"])
@pytest.mark.parametrize("disc", [{}, NO_GROOVE])
def test_no_scar_is_no_wear_within_the_cap_of_the_largest_scar_that_may_be_there(way, disc):
    run = run_of(described(conditions={"normal_load": si(0.2, "N"), **CIRCLE}, **{way: UNSEEN}, **disc))
    pin = next(one for one in pin_on_disc_wear(run, DefaultUncertainty()).bodies["pin"] if one.name == way)
    assert (pin.depth.value, pin.volume.value) == (0, 0)
    # The root mean square of a cap, about πd⁴/64R, over all scars is √105 that of the standard uncertainty.
    assert cap(1.96 * SPREAD) < 1.96 * pin.volume.standard_uncertainty < 1.05 * 1.96 * math.sqrt(105) * cap(SPREAD)
    assert not [finding for finding in check_run(run) if finding.severity != "note"]
    k = fit_wear(run, "archard", recipe=FIRST_ORDER).first
    assert k.wear_coefficient.value == 0
    assert k.interval[1].value >= cap(1.96 * SPREAD) / (0.2 * 500)


def test_no_scar_on_a_block_is_no_wear_within_the_segment_of_the_largest_one():
    run = block_run(block_scar_width={"value": "0 mm", "standard_uncertainty": "0.1 mm"})
    (block,) = pin_on_disc_wear(run, DefaultUncertainty()).bodies["pin"]
    most = WIDTH * float(segment_area(half_chord=1.96e-4 / 2, radius=RING_RADIUS))
    assert block.volume.value == 0
    assert 1.96 * block.volume.standard_uncertainty == pytest.approx(most, rel=0.03)


@pytest.mark.parametrize("key", ["disc_track_width", "disc_track_area"])
def test_no_track_is_no_wear_of_the_disc(key):
    value = si(0.0, "m", SPREAD) if key.endswith("width") else si(0.0, "m^2", 1e-12)
    run = run_of(described(conditions=CIRCLE, pin_scar_length=si(0.2e-3, "m", 2e-6), **{key: value}))
    disc = pin_on_disc_wear(run, DefaultUncertainty()).bodies["disc"]
    assert not any(way.depth is not None and way.depth.value > 0 for way in disc)
    assert fit_wear(run, "archard", recipe=FIRST_ORDER).bodies["pin"].wear_coefficient.value == pytest.approx(
        cap(0.2e-3) / (0.2 * 500), rel=0.02
    )


def test_a_scar_below_zero_is_refused():
    with pytest.raises(ManifestError, match=r"block_scar_width: found '-1.0 mm'; expected zero or a positive value"):
        read(block_on_ring(end_values={"block_scar_width": "-1.0 mm"}))


@pytest.mark.parametrize("disc", [{}, {"disc_wear_depth": si(3e-6, "m", 1e-7)}])
def test_a_flat_pin_that_became_longer_has_gained_material(disc):
    """Its area stays the same, so that a depth with its sign is a volume with its sign."""
    ends = {"pin_wear_depth": si(-2e-6, "m", 0.5e-6), **disc}
    run = run_of(described("flat", conditions={"normal_load": si(0.2, "N", 0.0), **CIRCLE}, **ends))
    fit = fit_wear(run, "archard", recipe=FIRST_ORDER)
    k, gained = fit.bodies["pin"].wear_coefficient, math.pi * RADIUS**2 * 2e-6
    assert k.value == pytest.approx(-gained / (0.2 * 500), rel=0.02)
    assert k.standard_uncertainty == pytest.approx(0.25 * gained / (0.2 * 500), rel=0.1)
    assert all(fit.bodies[body].wear_coefficient.value > 0 for body in fit.bodies if body == "disc")
    assert "material_gained" in {finding.code for finding in check_run(run)}


@pytest.mark.parametrize("key", ["pin_wear_depth", "disc_wear_depth"])
def test_a_gain_whose_volume_is_unknown_is_refused(key):
    with pytest.raises(ValidationError, match=f"{key}: found -2.00 ± 0.50 µm.*negative {key[:-5]}volume"):
        described(**{key: si(-2e-6, "m", 0.5e-6)})

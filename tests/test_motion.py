"""How two discs slip: by the speeds of both, or as it is stated."""

import math

import pytest
from disc_runs import BARE

from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.quantity import Quantity, wear_coefficient
from tribopipe.documents.recipe import DefaultUncertainty, Recipe
from tribopipe.evaluation.measurements.sliding_distance import distance_share
from tribopipe.evaluation.wear.inputs import contact_inputs
from tribopipe.evaluation.wear.prediction import wear_scenario
from tribopipe.evaluation.wear.scenario import given_wear
from tribopipe.results.run import RawRun

K_D = {"curved_disc": wear_coefficient(1e-18), "flat_disc": wear_coefficient(1e-18)}


def with_speeds(curved: float, flat: float, *spreads: float | None) -> RunManifest:
    """A twin-disc run of which both speeds are stated, m/s, with or without an uncertainty of each, and no slip."""
    each = zip((curved, flat), spreads or (None, None), strict=True)
    speeds = (Quantity(value=value, unit="m/s", standard_uncertainty=spread) for value, spread in each)
    changes = dict(zip(("curved_disc_speed", "flat_disc_speed"), speeds, strict=True)) | {"slip": None}
    return BARE.model_copy(update={"conditions": BARE.conditions.model_copy(update=changes)})


@pytest.mark.parametrize(("flat", "expected"), [(0.832, 0.04), (0.768, -0.04), (0.8, 0.0), (1.6, 1.0), (0.4, -0.5)])
def test_slip_is_above_zero_where_the_flat_disc_is_the_faster_one(flat, expected):
    assert with_speeds(0.8, flat).slip.value == pytest.approx(expected, abs=1e-12)


def test_slip_is_as_uncertain_as_the_ratio_of_both_speeds():
    # 0.1 % and 0.0962 % of the speeds, in quadrature, of the ratio of 1.04.
    by_hand = 1.04 * math.sqrt((0.8e-3 / 0.8) ** 2 + (0.8e-3 / 0.832) ** 2)
    assert with_speeds(0.8, 0.832, 0.8e-3, 0.8e-3).slip.standard_uncertainty == pytest.approx(by_hand, rel=1e-12)
    assert with_speeds(0.8, 0.832).slip.standard_uncertainty is None


@pytest.mark.parametrize("spreads", [(8e-3, None), (None, 8.32e-3), (8e-6, None)])
def test_one_uncertain_speed_makes_slip_uncertain_together_with_the_default(spreads):
    """The other speed counts by the default uncertainty of slip, a share of slip itself."""
    manifest = with_speeds(0.8, 0.832, *spreads)
    stated = 1.04 * next(spread / speed for spread, speed in zip(spreads, (0.8, 0.832), strict=True) if spread)
    assert manifest.slip.standard_uncertainty == pytest.approx(stated, rel=1e-12)
    expected, recipe = math.hypot(stated, 0.02 * 0.04), Recipe(uncertainty=DefaultUncertainty(slip=0.02))
    origins = {"sliding_distance": "derived from nominal slip", "rotations": "measured"}
    run = RawRun(manifest, {}, origins, {}, {}, ())
    scenario = wear_scenario(manifest, given_wear(manifest.described, K_D, recipe), recipe=recipe)
    for inputs in (contact_inputs(run, recipe), scenario.inputs):
        assert inputs["slip"].spread == pytest.approx(expected, rel=1e-12)
    rolled = manifest.described.curved_disc.rolling_radius
    along = (rolled.standard_uncertainty or recipe.uncertainty.rolling_radius * rolled.value) / rolled.value
    assert distance_share(run, recipe.uncertainty) == pytest.approx(math.hypot(expected / 0.04, along), rel=1e-9)


@pytest.mark.parametrize(("spread", "source"), [(None, "default"), (8e-4, "manifest")])
def test_default_of_slip_counts_where_no_speed_is_uncertain_and_not_where_both_are(spread, source):
    manifest = with_speeds(0.8, 0.832, spread, spread)
    slip = contact_inputs(RawRun(manifest, {}, {}, {}, {}, ()), Recipe())["slip"]
    stated = manifest.slip.standard_uncertainty
    assert (slip.source, slip.spread) == (source, pytest.approx(0.01 * 0.04 if stated is None else stated))


def test_stated_slip_counts_before_the_speeds():
    conditions = with_speeds(0.8, 0.832).conditions.model_copy(update={"slip": Quantity(value=0.02, unit="1")})
    assert BARE.model_copy(update={"conditions": conditions}).slip.value == 0.02


@pytest.mark.parametrize("flat", [0.832, 0.768])
def test_discs_slip_by_a_share_of_the_circumference_in_a_rotation(flat):
    run = with_speeds(0.8, flat)
    assert run.described.slip_per_rotation(run.conditions) == pytest.approx(2 * math.pi * 4e-3 * 0.04, rel=1e-12)

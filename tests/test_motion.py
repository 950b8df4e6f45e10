"""How two discs slip: by the speeds of both, or as it is stated."""

import math

import pytest
from disc_runs import BARE

from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.quantity import Quantity


def with_speeds(curved: float, flat: float, spread: float | None = None) -> RunManifest:
    """A twin-disc run of which both speeds are stated, m/s, and no slip."""
    speeds = (Quantity(value=value, unit="m/s", standard_uncertainty=spread) for value in (curved, flat))
    changes = dict(zip(("curved_disc_speed", "flat_disc_speed"), speeds, strict=True)) | {"slip": None}
    return BARE.model_copy(update={"conditions": BARE.conditions.model_copy(update=changes)})


@pytest.mark.parametrize(("flat", "expected"), [(0.832, 0.04), (0.768, -0.04), (0.8, 0.0), (1.6, 1.0), (0.4, -0.5)])
def test_slip_is_above_zero_where_the_flat_disc_is_the_faster_one(flat, expected):
    assert with_speeds(0.8, flat).slip.value == pytest.approx(expected, abs=1e-12)


def test_slip_is_as_uncertain_as_the_ratio_of_both_speeds():
    # 0.1 % and 0.0962 % of the speeds, in quadrature, of the ratio of 1.04.
    by_hand = 1.04 * math.sqrt((0.8e-3 / 0.8) ** 2 + (0.8e-3 / 0.832) ** 2)
    assert with_speeds(0.8, 0.832, 0.8e-3).slip.standard_uncertainty == pytest.approx(by_hand, rel=1e-12)
    assert with_speeds(0.8, 0.832).slip.standard_uncertainty is None


def test_stated_slip_counts_before_the_speeds():
    conditions = with_speeds(0.8, 0.832).conditions.model_copy(update={"slip": Quantity(value=0.02, unit="1")})
    assert BARE.model_copy(update={"conditions": conditions}).slip.value == 0.02


@pytest.mark.parametrize("flat", [0.832, 0.768])
def test_discs_slip_by_a_share_of_the_circumference_in_a_rotation(flat):
    run = with_speeds(0.8, flat)
    assert run.twin_disc.slip_per_rotation(run.conditions) == pytest.approx(2 * math.pi * 4e-3 * 0.04, rel=1e-12)

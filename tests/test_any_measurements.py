"""Post-test measurements of any size, in any combination: refused in one sentence, or finite wear of both bodies."""

import math

import pytest
from end_value_runs import CIRCLE, DENSITY, RADIUS, SHAPES, described, run_of, si
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from tribopipe.evaluation.checks.registry import check_run
from tribopipe.evaluation.measurements.specific_wear import specific_wear


def sized(low: float, high: float, unit: str) -> st.SearchStrategy[dict]:
    """A size between limits, evenly over its logarithm, with or without an uncertainty."""
    sizes = st.floats(math.log(low), math.log(high)).map(math.exp)
    return st.builds(lambda size, share: si(size, unit, share * size), sizes, st.sampled_from([0.0, 1e-3, 0.1]))


LENGTHS, DEPTHS = sized(1e-6, 3 * RADIUS, "m"), st.one_of(st.just(si(0.0, "m")), sized(1e-9, 3 * RADIUS, "m"))
VOLUMES, MASSES = sized(1e-18, 1e-6, "m^3"), sized(1e-18 * DENSITY, 1e-6 * DENSITY, "kg")
MEASUREMENTS = {
    **dict.fromkeys(("pin_scar_diameter", "pin_scar_length", "pin_scar_width", "disc_track_width"), LENGTHS),
    **dict.fromkeys(("pin_wear_depth", "disc_wear_depth"), DEPTHS),
    **dict.fromkeys(("pin_wear_volume", "disc_wear_volume"), VOLUMES),
    **dict.fromkeys(("pin_mass_loss", "disc_mass_loss"), MASSES),
    "disc_track_area": sized(1e-15, 1e-5, "m^2"),
}
STROKES = sized(1e-5, 1e-2, "m").map(lambda stroke: {"stroke": stroke, "sliding_speed": "400 mm/s"})
COMBINATIONS = st.lists(st.sampled_from(sorted(MEASUREMENTS)), min_size=1, max_size=3, unique=True).flatmap(
    lambda names: st.fixed_dictionaries({name: MEASUREMENTS[name] for name in names})
)


def assert_finite_wear(run):
    for body in specific_wear(run).bodies.values():
        for quantity in (body.depth, body.volume, body.specific_wear_rate):
            if quantity is not None:
                assert math.isfinite(quantity.value)
                assert math.isfinite(quantity.standard_uncertainty)
    assert all(finding.message for finding in check_run(run))


@pytest.mark.slow
@settings(max_examples=25)
@given(st.sampled_from(SHAPES), st.one_of(st.just(CIRCLE), STROKES), COMBINATIONS)
def test_any_measurements_are_refused_or_give_finite_wear(shape, path, end):
    try:
        run = run_of(described(shape, path, **end))
    except ValidationError:
        return
    assert_finite_wear(run)


@pytest.mark.slow
@pytest.mark.parametrize("volume", [0.005, 0.02])
def test_a_groove_on_a_stroke_shorter_than_its_scar_is_finite(volume):
    stroke = {"stroke": "0.05 mm", "sliding_speed": "400 mm/s"}
    assert_finite_wear(
        run_of(described("spherical", stroke, pin_scar_diameter="150 um", disc_wear_volume=f"{volume / 50} mm^3"))
    )

"""Axes that were not recorded, against motions whose time, distance and rotations are known in closed form."""

import numpy as np
import pytest
from disc_runs import BARE as DISCS

from tribopipe.base.errors import ReaderError
from tribopipe.documents.quantity import Quantity
from tribopipe.evaluation.derived_columns import complete_axes

UNEVEN = np.array([0.0, 0.5, 2.0, 3.0, 7.0, 7.5, 12.0])
"""s: between samples that are not evenly spaced a rectangle is off by more than rounding."""


def completed(columns: dict, manifest) -> tuple[dict, dict]:
    """The columns and their origins with the axes that were missing."""
    columns, origins = dict(columns), dict.fromkeys(columns, "measured")
    complete_axes(columns, origins, manifest)
    return columns, origins


def test_distance_by_a_measured_speed_that_grows_evenly_is_exact(bare_run):
    # v = v₀ + a·t, so s = v₀·t + a·t²/2, which trapezoids give exactly.
    columns = {"time": UNEVEN, "sliding_speed": 0.1 + 0.06 * UNEVEN}
    found, origins = completed(columns, bare_run.manifest)
    np.testing.assert_allclose(found["sliding_distance"], 0.1 * UNEVEN + 0.03 * UNEVEN**2, rtol=1e-13)
    assert origins["sliding_distance"] == "derived from measured speed"


def test_time_by_a_measured_speed_is_the_integral_of_its_inverse(bare_run):
    # 1/v = 2 + s/3, so t = 2·s + s²/6.
    columns = {"sliding_distance": UNEVEN, "sliding_speed": 1 / (2 + UNEVEN / 3)}
    found, origins = completed(columns, bare_run.manifest)
    np.testing.assert_allclose(found["time"], 2 * UNEVEN + UNEVEN**2 / 6, rtol=1e-13)
    assert origins["time"] == "derived from measured speed"


def test_a_signed_speed_of_strokes_gives_the_distance_of_both_directions(bare_run):
    # 5 mm at 10 Hz: a position of 2.5 mm·cos(2πft), so 2·5 mm·10 Hz = 0.1 m/s on average.
    time = np.linspace(0, 10, 10_001)
    columns = {"time": time, "sliding_speed": np.pi * 10 * 5e-3 * np.sin(2 * np.pi * 10 * time)}
    slid = completed(columns, bare_run.manifest)[0]["sliding_distance"]
    np.testing.assert_allclose(slid[::100], 0.1 * time[::100], rtol=1e-3, atol=1e-6)
    assert np.all(np.diff(slid) >= 0)


@pytest.mark.parametrize("sign", [-np.ones(len(UNEVEN)), np.where(UNEVEN < 5, 1, -1)])
def test_a_disc_that_turns_the_other_way_slides_as_well(bare_run, sign):
    found, _ = completed({"time": UNEVEN, "sliding_speed": 0.2 * sign}, bare_run.manifest)
    np.testing.assert_allclose(found["sliding_distance"], 0.2 * UNEVEN, rtol=1e-13)
    found, _ = completed({"sliding_distance": UNEVEN, "sliding_speed": 0.2 * sign}, bare_run.manifest)
    np.testing.assert_allclose(found["time"], UNEVEN / 0.2, rtol=1e-13)


def test_missing_speeds_are_bridged_over_time(bare_run):
    # Between its neighbors a speed that grows evenly is exact; at the ends the nearest one counts.
    speed = 0.1 + 0.06 * UNEVEN
    speed[[2, 3]] = np.nan
    slid = completed({"time": UNEVEN, "sliding_speed": speed}, bare_run.manifest)[0]["sliding_distance"]
    np.testing.assert_allclose(slid, 0.1 * UNEVEN + 0.03 * UNEVEN**2, rtol=1e-13)
    ends = np.full(len(UNEVEN), 0.2)
    ends[[0, -2, -1]] = np.nan, np.inf, np.nan
    slid = completed({"time": 3 + UNEVEN, "sliding_speed": ends}, bare_run.manifest)[0]["sliding_distance"]
    np.testing.assert_allclose(slid, 0.2 * (3 + UNEVEN), rtol=1e-13)


def test_missing_speeds_are_bridged_by_their_size(bare_run):
    speed = np.where(UNEVEN < 5, 0.2, -0.2)
    speed[4] = np.nan
    slid = completed({"time": UNEVEN, "sliding_speed": speed}, bare_run.manifest)[0]["sliding_distance"]
    np.testing.assert_allclose(slid, 0.2 * UNEVEN, rtol=1e-13)


def test_distance_is_missing_where_no_speed_or_no_time_is_known(bare_run):
    nothing = {"time": UNEVEN, "sliding_speed": np.full(len(UNEVEN), np.nan)}
    assert np.isnan(completed(nothing, bare_run.manifest)[0]["sliding_distance"]).all()
    hole = {"time": np.where(UNEVEN == 3, np.nan, UNEVEN), "sliding_speed": np.full(len(UNEVEN), 0.2)}
    assert np.isnan(completed(hole, bare_run.manifest)[0]["sliding_distance"][3:]).all()


def test_a_record_that_begins_late_has_slid_before_at_the_first_speed(bare_run):
    time = 10.0 + UNEVEN
    columns = {"time": time, "sliding_speed": np.full(len(time), 0.2)}
    np.testing.assert_allclose(completed(columns, bare_run.manifest)[0]["sliding_distance"], 0.2 * time, rtol=1e-13)


def test_nominal_speed_serves_where_none_was_measured(bare_run):
    found, origins = completed({"time": UNEVEN}, bare_run.manifest)
    np.testing.assert_allclose(found["sliding_distance"], 0.4 * UNEVEN, rtol=1e-13)
    assert origins["sliding_distance"] == "derived from nominal speed"


def test_rotations_give_distance_and_time_of_discs_by_radius_slip_and_speed():
    turns = np.array([0.0, 10.0, 25.0])
    found, origins = completed({"rotations": turns}, DISCS)
    np.testing.assert_allclose(found["time"], turns * 2 * np.pi * 4e-3 / 0.8, rtol=1e-13)
    np.testing.assert_allclose(found["sliding_distance"], turns * 2 * np.pi * 4e-3 * 0.04, rtol=1e-13)
    assert origins == {
        "rotations": "measured",
        "time": "derived from nominal speed",
        "sliding_distance": "derived from nominal slip",
    }


@pytest.mark.parametrize("axis", ["time", "rotations", "sliding_distance"])
def test_any_one_axis_of_discs_gives_the_other_two(axis):
    turns = np.array([0.0, 10.0, 25.0])
    whole = {
        "time": turns * 2 * np.pi * 4e-3 / 0.8,
        "rotations": turns,
        "sliding_distance": turns * 2 * np.pi * 4e-3 * 0.04,
    }
    found, _ = completed({axis: whole[axis]}, DISCS)
    for name, expected in whole.items():
        np.testing.assert_allclose(found[name], expected, rtol=1e-13)


def test_no_axis_at_all_is_refused(bare_run):
    with pytest.raises(ReaderError, match="found neither time nor sliding_distance"):
        completed({"depth": UNEVEN}, bare_run.manifest)
    with pytest.raises(ReaderError, match="found neither time nor rotations"):
        completed({"depth": UNEVEN}, DISCS)


def test_time_of_discs_needs_a_speed():
    conditions = DISCS.conditions.model_copy(
        update={"curved_disc_speed": None, "flat_disc_speed": None, "slip": Quantity(value=0.04, unit="1")}
    )
    with pytest.raises(ReaderError, match="curved_disc_speed: missing"):
        completed({"rotations": UNEVEN}, DISCS.model_copy(update={"conditions": conditions}))

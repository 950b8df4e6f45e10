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

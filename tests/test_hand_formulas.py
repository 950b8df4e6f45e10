"""The formulas of standards: right where their assumptions hold, and as wrong as the manual states where not."""

import re
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[1] / "docs"))
from hand_formula_figures import elastic_ratio, flat_cap_ratio, groove_ratio, middle_ratio, taper_ratio, worn_ball

PAGE = (Path(__file__).parents[1] / "docs" / "hand_formulas.md").read_text(encoding="utf-8")


def at(groove_over_pin: float):
    return worn_ball(np.array([groove_over_pin]))


def test_cap_is_right_on_a_disc_that_does_not_wear():
    worn = at(1e-6)
    for size in (worn.half_width, worn.half_length):
        assert flat_cap_ratio(size, worn) == pytest.approx(1.0, abs=5e-3)


def test_segment_is_right_under_a_ball_that_does_not_wear():
    assert groove_ratio(at(1e6)) == pytest.approx(1.0, abs=1e-5)


def test_volume_of_a_long_track_is_its_section_times_the_stroke():
    assert middle_ratio(np.array([1e4]), at(100.0)) == pytest.approx(1.0, abs=1e-4)


@pytest.mark.parametrize(("slope", "width", "length"), [(0.075, 1.14, 0.94), (0.41, 1.83, 0.77), (2.0, 6.4, 0.48)])
def test_scar_of_two_worn_bodies_is_no_circle(slope, width, length):
    # Groove over pin depth is 4/3·κb; the published ratios are those of the paraboloid.
    worn = at(4 / 3 * slope)
    assert flat_cap_ratio(worn.half_width, worn) == pytest.approx(width, rel=0.01)
    assert flat_cap_ratio(worn.half_length, worn) == pytest.approx(length, rel=0.015)


def test_tapered_scar_loses_the_variance_of_its_width():
    taper = np.array([0.1, 0.3])
    assert taper_ratio(taper, 1e-5, 17.5e-3) == pytest.approx(1 / (1 + taper**2), rel=1e-4)


def test_the_manual_states_these_errors():
    half = at(0.5)
    stroke = middle_ratio(np.array([13.0, 5.0, 3.0]), at(1.0))
    taper = taper_ratio(np.array([0.1, 0.2]), 0.5e-3, 17.5e-3)
    for words in (
        f"gives {flat_cap_ratio(half.half_width, half)[0]:.1f} times",
        f"and {flat_cap_ratio(half.half_length, half)[0]:.2f} times when used with its length",
        f"then gives {groove_ratio(half)[0]:.1f} times",
        f"by {100 * (1 - stroke[0]):.1f} % for a stroke of 13 track widths, by {100 * (1 - stroke[1]):.0f} % for 5",
        f"and by {100 * (1 - stroke[2]):.0f} % for 3",
        f"by {100 * (1 - taper[0]):.0f} % if the width",
        f"by {100 * (1 - taper[1]):.0f} % if it deviates by 20 %",
        f"by more than {100 * (elastic_ratio(np.array([3.0]), 2)[0] - 1):.0f} %",
        f"is {100 * (elastic_ratio(np.array([2.0]), 3)[0] - 1):.0f} % too high",
        f"1.3 times this diameter, it is {100 * (elastic_ratio(np.array([1.3]), 3)[0] - 1):.0f} %",
    ):
        assert words in re.sub(r"\s+", " ", PAGE), words
    assert groove_ratio(at(23.0)) == pytest.approx(1.05, abs=0.002)

"""What docs/exact_and_published.md, drift.md, scar_only.md and distance_conventions.md derive, against the code."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import tribopipe
from tribopipe.documents.recipe import Recipe
from tribopipe.evaluation.wear.problem import wear_problem
from tribopipe.evaluation.wear.uncertainty import budget
from tribopipe.physics.hertz import contact_modulus, elastic_approach, hertz_radius
from tribopipe.physics.pin_on_disc import SphericalPin
from tribopipe.physics.twin_disc import DiscPair

SAMPLES = Path(__file__).parents[1] / "sample_runs"
RADIUS = 0.794e-3
SI3N4 = float(contact_modulus(pin_modulus=304e9, pin_ratio=0.24, disc_modulus=304e9, disc_ratio=0.24))
WC_CO = float(contact_modulus(pin_modulus=320e9, pin_ratio=0.24, disc_modulus=305e9, disc_ratio=0.24))
NITRIDE = SphericalPin(0.2, RADIUS, SI3N4), 13.5e-15 * 0.2 * 500.0
CARBIDE = SphericalPin(0.4, RADIUS, WC_CO), 0.75e-17 * 0.4 * 500.0


def error_of(pin: SphericalPin, volume: float, steps: int) -> float:
    return float(pin.published_depth(np.full(steps, volume / steps))[-1] / pin.worn(volume).depth - 1)


@given(st.floats(1.01, 30.0))
def test_one_curve_holds_for_all_shallow_caps(widened):
    load, radius, modulus = 1e-3, 1.0, 1e11
    pin = SphericalPin(load, radius, modulus)
    start = float(pin.worn(0.0).radius)
    height = float(elastic_approach(normal_load=load, modulus=modulus, contact_radius=start))
    volume = np.pi * start**2 * height * ((widened**4 - 1) / 2 + widened - 1)
    state = pin.worn(volume)
    assert start**3 == pytest.approx(load * radius / modulus, rel=1e-6)
    assert float(hertz_radius(normal_load=load, pin_radius=radius, modulus=modulus)) == pytest.approx(
        start * 0.75 ** (1 / 3), rel=1e-6
    )
    assert float(state.depth) == pytest.approx(height * (widened**2 - 1 / widened), rel=1e-5)
    assert float(state.radius) == pytest.approx(start * widened, rel=1e-5)


@pytest.mark.parametrize(("case", "steps", "within"), [(NITRIDE, 400_000, 0.02), (CARBIDE, 5_000, 0.03)])
def test_short_steps_are_ahead_by_the_latest_one_times_how_much_the_contact_widened(case, steps, within):
    pin, volume = case
    start, end = pin.worn(np.array([0.0, volume])).radius
    exponent = volume / (np.pi * end**2) / float(pin.worn(volume).depth)
    foretold = exponent / steps * (np.log(end / start) - 0.117)
    assert error_of(pin, volume, steps) == pytest.approx(foretold, rel=within)


def test_constant_of_short_steps_is_that_of_its_two_details():
    # Hertz's start swings in, and the elastic part is a step late.
    widened, swing = 0.75 ** (1 / 3), 0.0
    for _ in range(60):
        swing += 1 / widened**2 - 1
        widened = widened**-0.5
    assert swing == pytest.approx(0.153, abs=5e-4)
    assert swing - 2 / 3 * np.log(1.5) == pytest.approx(-0.117, abs=5e-4)


@pytest.mark.parametrize("steps", [300, 500, 1000])
def test_long_steps_are_ahead_by_what_the_first_one_runs_ahead(steps):
    pin, volume = NITRIDE
    radius = float(hertz_radius(normal_load=0.2, pin_radius=RADIUS, modulus=SI3N4))
    first = volume / steps / (np.pi * radius**2)
    ahead = float(pin.volume(first)) - volume / steps
    foretold = float(pin.worn(volume + ahead).depth / pin.worn(volume).depth - 1)
    assert error_of(pin, volume, steps) == pytest.approx(foretold, rel=0.02)
    short = np.pi * RADIUS / (2 * volume) * first**2
    assert error_of(pin, volume, steps) == pytest.approx(short, rel=0.12)


@pytest.mark.parametrize(("spacing", "share"), [("equal times", 8 / 5), ("equal logarithms", 4 / 3)])
def test_error_of_an_end_value_moves_k_d_by_what_the_samples_make_of_it(spacing, share):
    x = np.linspace(0.0, 1.0, 100_001)[1:] if spacing == "equal times" else np.logspace(-6, 0, 100_001)
    wear, ramp = np.sqrt(x), x
    slope = wear / 2  # dh/d ln k_D
    assert float(slope @ ramp / (slope @ slope)) == pytest.approx(share, rel=1e-3)


def test_budget_of_a_deep_scar_is_that_worked_out_on_paper():
    corrected = tribopipe.correct_drift(tribopipe.read_run(SAMPLES / "si3n4-air-200mN"))
    problem = wear_problem(corrected, "archard", None, Recipe())
    found = {line.name: line for line in budget(problem.condensed(), problem.coefficient())}
    by_offset = 16 / 15 * problem.trace.lean  # the offset is found beside what has drifted by the end
    on_paper = {
        "normal load": -1,
        "sliding speed": -1,
        "pin end value": 16 / 5 - 2 * by_offset,
        "pin radius": -3 / 5 + by_offset,
        "depth scale": 2 / 5 + by_offset,
        "end reading": -8 / 5 + by_offset,
        "zero offset": -16 / 15,
    }
    for name, sensitivity in on_paper.items():
        line = found[name]
        of = problem.end.pin_depth.value if name in ("end reading", "zero offset") else line.value.value
        share = sensitivity * line.value.standard_uncertainty / of
        assert line.relative == pytest.approx(share, rel=0.07), name


def test_offset_and_drift_take_all_but_a_225th_of_the_shape():
    x = np.linspace(0.0, 1.0, 100_001)
    line = np.column_stack([np.ones_like(x), x])
    left = np.sqrt(x) - line @ np.linalg.lstsq(line, np.sqrt(x))[0]
    assert float(np.mean(x)) / float(np.mean(left**2)) == pytest.approx(225, rel=1e-3)


def test_a_point_of_a_disc_is_in_contact_for_less_than_a_thousandth_of_a_turn():
    state = DiscPair(0.25, 4e-3, 4e-3, 4e-3, SI3N4, 0.04, "full-slip").worn(1e6, 4.6e-18, 2.0e-18)
    share = float(2 * state.half_length / (2 * np.pi * 4e-3))
    assert share == pytest.approx(2.8e-4, rel=0.01)

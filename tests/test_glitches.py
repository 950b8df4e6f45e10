"""Counters with a few wrong readings beside a clock that runs on."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tribopipe.evaluation.checks.registry import check_run
from tribopipe.evaluation.preprocessing.cleaning import clean_run
from tribopipe.physics.axis_faults import mended, segments
from tribopipe.readers.harmonize import read_run

CLOCK = np.arange(400.0)


@pytest.mark.parametrize(
    ("at", "wrong", "samples"),
    [
        (200, [199.0], (200,)),  # goes back by two, as 186, 185, 188
        (200, [0.0, 0.0], (200, 201)),
        (200, [5000.0], (200,)),  # leaps ahead
        (1, [399.0], (1,)),
    ],
)
def test_wrong_readings_are_interpolated(at, wrong, samples):
    counter = CLOCK + 1
    counter[at : at + len(wrong)] = wrong
    if wrong == [199.0]:
        counter[at - 1] = 200.0
    found = mended(counter, CLOCK)
    assert found.samples == samples
    assert found.values.tolist() == (CLOCK + 1).tolist()


@pytest.mark.parametrize("counter", [np.r_[0:50, 20:90], np.r_[5:0:-1], np.r_[0:50, 0, 0, 0, 53:100], np.r_[0:50, 0]])
def test_disorder_is_no_glitch(counter):
    counter = counter.astype(float)
    found = mended(counter, np.arange(len(counter), dtype=float))
    assert found.values is counter
    assert not found.samples


def test_nothing_is_mended_without_a_clock_that_runs_on():
    counter = np.r_[0:50, 3, 51:100].astype(float)
    assert mended(counter, None).values is counter
    assert mended(counter, counter).values is counter


@given(st.integers(2, 397), st.floats(-1e3, 1e3))
def test_one_wrong_reading_anywhere_moves_no_other_far(at, wrong):
    counter = CLOCK.copy()
    counter[at] = wrong
    found = mended(counter, CLOCK)
    if segments(counter).fault is not None and found.samples:
        assert np.max(np.abs(found.values - CLOCK)) <= 2.0


def test_a_glitch_of_the_counter_does_not_refuse_the_run(tmp_path):
    rows = [f"{n},{n // 2},{0.5 + 0.01 * (n % 3):.3f}" for n in range(400)]
    rows[373] = "373,185,0.5"  # 186, 185, 187
    rows[371], rows[372] = "371,186,0.5", "372,186,0.5"
    (tmp_path / "signals.csv").write_text("Time [s],rotations,mu\n" + "\n".join(rows) + "\n", encoding="utf-8")
    (tmp_path / "run.toml").write_text(
        'schema = "tribopipe.run/1"\nid = "run"\n[conditions]\nnormal_load = "5 N"\ntrack_radius = "10 mm"\n'
        '[[signals]]\nfile = "signals.csv"\n',
        encoding="utf-8",
    )
    run = read_run(tmp_path)
    findings = {finding.code: finding for finding in check_run(run)}
    assert not [finding for finding in findings.values() if finding.severity == "error"]
    warning = findings["counter_glitch"]
    assert (warning.severity, warning.where) == ("warning", "rotations")
    assert "185" in warning.message
    distance = clean_run(run).run.columns["sliding_distance"]
    assert np.all(np.diff(distance) >= 0)
    assert distance[-1] == pytest.approx(2 * np.pi * 0.01 * 199)
    assert run.columns["rotations"][373] == 185

"""Definitions of the friction coefficient of a reciprocating test against strokes of known friction."""

import math
from dataclasses import replace

import numpy as np
import pytest
from test_clean_up import LOAD, PHASE, STROKES, TRUTH, only
from test_clean_up import run_of as made_of

from tribopipe.documents.preprocessing import StrokeWiseFriction
from tribopipe.evaluation.friction import fit_friction
from tribopipe.evaluation.preprocessing.cleaning import clean_run
from tribopipe.evaluation.stroke_friction import stroke_friction

MU = 0.4


def recorded(bare, wave, offset=0.0):
    """Return a run whose friction has a shape along each stroke, 1 for the nominal friction."""
    force = LOAD * (MU * wave(PHASE % 1) * np.where(PHASE % 2 < 1, 1, -1) + offset)
    return made_of(bare, STROKES, time=TRUTH["time"], sliding_distance=TRUTH["sliding_distance"], friction_force=force)


def even(_):
    return np.ones_like(PHASE)


def sine(phase):
    return np.sin(np.pi * phase)


@pytest.mark.parametrize("offset", [0.0, 0.1, 0.6])
def test_half_difference_and_energy_do_not_depend_on_an_offset(bare_run, offset):
    found = stroke_friction(recorded(bare_run, even, offset))
    assert found.half_difference.value == pytest.approx(MU, rel=1e-9)
    assert found.loop_energy.value == pytest.approx(MU, rel=1e-9)
    assert found.offset.value == pytest.approx(offset, abs=1e-9)
    assert found.root_mean_square.value == pytest.approx(math.hypot(MU, offset), rel=1e-9)
    assert found.middle_of_stroke.value == pytest.approx(max(MU, offset), rel=1e-9)


def test_definitions_differ_where_friction_varies_along_the_stroke(bare_run):
    found = stroke_friction(recorded(bare_run, sine))
    assert found.peak.value == pytest.approx(MU, rel=0.01)
    assert found.loop_energy.value == pytest.approx(MU * 2 / math.pi, rel=0.05)
    assert found.root_mean_square.value == pytest.approx(MU / math.sqrt(2), rel=0.05)
    assert found.half_difference.value == pytest.approx(MU * 4 / math.pi * math.sin(math.pi / 4), rel=0.01)


@pytest.mark.parametrize("offset", [0.0, 0.1])
def test_energy_is_friction_over_the_distance_that_was_slid(bare_run, offset):
    run = recorded(bare_run, sine, offset)
    # Of a crank, which is slow where friction is low.
    stroke = run.manifest.conditions.stroke.value
    slid = stroke * (np.floor(PHASE) + (1 - np.cos(np.pi * (PHASE % 1))) / 2)
    found = stroke_friction(replace(run, columns={**run.columns, "sliding_distance": slid}))
    assert found.loop_energy.value == pytest.approx(MU * math.pi / 4, rel=0.01)


@pytest.mark.parametrize("slid", [np.floor(PHASE / 2), np.minimum(PHASE, 10.5)])
def test_energy_of_a_distance_that_is_not_known_within_a_stroke_is_that_at_constant_speed(bare_run, slid):
    run = recorded(bare_run, sine)
    found = stroke_friction(replace(run, columns={**run.columns, "sliding_distance": 5e-3 * slid}))
    assert found.loop_energy.value == pytest.approx(MU * 2 / math.pi, rel=0.05)


@pytest.mark.parametrize("method", ["half-difference", "middle-of-stroke"])
def test_the_definition_in_use_is_named(bare_run, method):
    run = recorded(bare_run, sine, offset=0.05)
    assert fit_friction(clean_run(run, only(StrokeWiseFriction(method=method))).run).strokes.used == method
    assert fit_friction(run).strokes.used is None


def test_strokes_without_load_do_not_count(bare_run):
    run = recorded(bare_run, even)
    load = np.where(np.arange(len(PHASE)) < 500, 1e-6, LOAD)
    columns = {
        **run.columns,
        "normal_force": load,
        "friction_force": np.where(load < LOAD, 1e-3, 1.0) * run.columns["friction_force"],
    }
    found = stroke_friction(replace(run, columns=columns, origins={**run.origins, "normal_force": "measured"}))
    assert found.peak.value == pytest.approx(MU, rel=1e-9)
    assert found.half_difference.value == pytest.approx(MU, rel=1e-9)


def test_other_runs_have_no_strokes(bare_run):
    steady = made_of(bare_run, {}, **TRUTH)
    assert stroke_friction(steady) is None

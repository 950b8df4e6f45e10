"""Clean-up: a signal spoilt in a known way comes back as it was, a clean one stays, and the raw one is kept."""

import dataclasses
import json
import math
import re
import tomllib

import numpy as np
import pytest
from folders import ROOT, edit_rows, replace_in
from hypothesis import given, settings
from hypothesis import strategies as st
from test_archive import nxcheck

from tribopipe.archive.store import Archive
from tribopipe.base.errors import ManifestError
from tribopipe.documents.preprocessing import (
    AUTOMATIC,
    ContinuousAxes,
    Despike,
    Invert,
    Mask,
    StrokeWiseFriction,
    TimeWindow,
    Zero,
)
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import MonteCarloRecipe, Recipe, WearRecipe
from tribopipe.documents.record import load_toml, read_document
from tribopipe.evaluation.checks.registry import check_run
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.preprocessing.cleaning import clean_run
from tribopipe.evaluation.preprocessing.masking import _lone_zeros, spikes
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.physics.axis_faults import continuous, segments
from tribopipe.pipeline.stages import advance, process
from tribopipe.readers.harmonize import read_run
from tribopipe.results.json_schema import schema_text
from tribopipe.results.run import RawRun

SAMPLES = 4000
LOAD = 0.2
RNG = np.random.default_rng(5)
LOADED = np.interp(np.arange(SAMPLES), [0, 300, 400, 3700, 3800], [0, 0, 1, 1, 0])
NOISE = RNG.normal(0, 1, (3, SAMPLES))
TRUTH = {
    "time": np.arange(SAMPLES) * 0.1,
    "sliding_distance": np.arange(SAMPLES) * 0.04,
    "normal_force": LOAD * LOADED + 1e-4 * NOISE[0],
    "friction_force": 0.3 * LOAD * LOADED + 1e-4 * NOISE[1],
    "depth": 1e-6 * np.sqrt(np.arange(SAMPLES) / SAMPLES) + 1e-8 * NOISE[2],
    "temperature": np.full(SAMPLES, 296.0),
    "relative_humidity": np.full(SAMPLES, 0.4),
}
PARTS = [1000, 2500]


def run_of(bare: RawRun, conditions=None, derived=(), **columns) -> RawRun:
    """Give a run of these columns, all measured but for those said to be derived."""
    manifest = bare.manifest
    if conditions:
        manifest = manifest.model_copy(update={"conditions": manifest.conditions.model_copy(update=conditions)})
    origins = {name: "derived from measured load" if name in derived else "measured" for name in columns}
    if "friction_coefficient" not in columns and "friction_force" in columns:
        with np.errstate(divide="ignore", invalid="ignore"):
            columns["friction_coefficient"] = columns["friction_force"] / columns.get("normal_force", LOAD)
        origins["friction_coefficient"] = f"derived from {'measured' if 'normal_force' in columns else 'nominal'} load"
    return dataclasses.replace(bare, manifest=manifest, columns=columns, origins=origins)


def only(*steps) -> Recipe:
    return Recipe(clean_up=steps)


def told(record) -> list[tuple[str, str]]:
    return [(change.step, change.signal) for change in record.changes]


def restarting(axis, *, gap=0.1):
    """Let an axis begin anew at PARTS, where ``gap`` is an interval of it."""
    return np.concatenate([part - part[0] + gap / 2 for part in np.split(axis, PARTS)])


# --- axes ---


def test_restarts_of_time_and_distance_are_joined_into_one_course(bare_run):
    spoilt = run_of(
        bare_run, time=restarting(TRUTH["time"]), sliding_distance=restarting(TRUTH["sliding_distance"], gap=0.04)
    )
    cleaned = clean_run(spoilt)
    np.testing.assert_allclose(cleaned.run.columns["time"], TRUTH["time"] + 0.05, atol=1e-9)
    np.testing.assert_allclose(cleaned.run.sliding_distance, TRUTH["sliding_distance"] + 0.02, atol=1e-9)
    assert [(change.signal, change.parts) for change in cleaned.record.changes] == [
        ("time", 3),
        ("sliding_distance", 3),
    ]
    assert spoilt.columns["time"][1000] == 0.05


def test_gap_between_segments_is_an_interval_of_the_one_before():
    np.testing.assert_allclose(continuous(np.array([0, 1, 2, 0, 10, 20.0])), [0, 1, 2, 3, 13, 23])


@pytest.mark.parametrize(
    ("axis", "expected"),
    [
        ([6.04, 0.15, 0.25, 0.35], [0.05, 0.15, 0.25, 0.35]),
        ([6.04, 0.0, 0.1, 0.2], [0.0, 0.1, 0.2, 0.3]),
        ([7, 0.0, 0.1, 0.2, 9.0, 0.1, 0.2], [0, 0.1, 0.2, 0.3, 9.1, 9.2, 9.3]),
    ],
)
def test_stale_first_value_is_placed_an_interval_before_the_second(axis, expected):
    np.testing.assert_allclose(continuous(np.array(axis)), expected, atol=1e-12)


@pytest.mark.parametrize(
    ("axis", "fault"),
    [
        (np.r_[0:50, 3, 51:100], 50),  # a lone wrong reading
        (np.r_[0:50, 0, 0, 52:100], 50),  # two of them
        (np.r_[0:4, 0.5, 5:50], 4),  # early in the run
        (np.r_[0:50, 0, 51], 50),  # at its end
        (np.r_[0:50, 48, 49, 52:100], 50),  # rows out of order
        (np.r_[0:50, 20:90], 50),  # an overlap
        (np.r_[5:0:-1], 1),  # a countdown
    ],
)
def test_disorder_is_no_restart(axis, fault):
    axis = axis.astype(float)
    assert segments(axis).fault == fault
    assert continuous(axis) is axis


@pytest.mark.slow
@settings(max_examples=60)
@given(st.lists(st.lists(st.floats(0.8, 1.25), min_size=4, max_size=30), min_size=1, max_size=6), st.floats(0, 1))
def test_joined_axes_never_go_back_and_stay_as_they_are(parts, start):
    axis = np.concatenate([start + np.cumsum(steps) - steps[0] for steps in parts])
    joined = continuous(axis)
    assert np.all(np.diff(joined) >= 0)
    assert continuous(joined) is joined
    np.testing.assert_allclose(joined[: len(parts[0])], axis[: len(parts[0])])


def test_missing_samples_stay_missing():
    joined = continuous(np.array([0, 1, np.nan, 2, 0, np.nan, 1, 2.0]))
    np.testing.assert_array_equal(joined, [0, 1, np.nan, 2, 3, np.nan, 4, 5])


@pytest.mark.parametrize("start", [1.6e9, 41_000.0])
def test_time_of_a_clock_begins_at_zero(bare_run, start):
    """Seconds since 1970, or of the day: no test is recorded from its last hundredth on."""
    manifest = bare_run.manifest
    columns = {name: TRUTH[name] for name in ("time", "friction_force")}
    spoilt = run_of(bare_run, **columns | {"time": TRUTH["time"] + start, "sliding_distance": TRUTH["time"] + start})
    spoilt.origins["sliding_distance"] = "derived from nominal speed"
    cleaned = clean_run(spoilt, only(ContinuousAxes())).run
    np.testing.assert_allclose(cleaned.columns["time"], TRUTH["time"], atol=1e-6)
    speed = manifest.conditions.nominal_speed.value
    np.testing.assert_allclose(cleaned.sliding_distance, TRUTH["time"] * speed, atol=1e-6)


def test_counter_carried_over_begins_at_zero_where_time_tells(bare_run):
    spoilt = run_of(bare_run, time=TRUTH["time"], sliding_distance=TRUTH["sliding_distance"] + 700)
    cleaned = clean_run(spoilt)
    np.testing.assert_allclose(cleaned.run.sliding_distance, TRUTH["sliding_distance"], atol=1e-9)
    assert cleaned.record.changes[0].offset.value == pytest.approx(700)


def test_late_start_of_all_axes_is_left_alone_unless_the_recipe_says_otherwise(bare_run):
    late = run_of(bare_run, time=TRUTH["time"] + 200, sliding_distance=TRUTH["sliding_distance"] + 80)
    assert clean_run(late).run is late
    cleaned = clean_run(late, only(ContinuousAxes(carried_over="always")))
    assert (cleaned.run.columns["time"][0], cleaned.run.sliding_distance[0]) == (0.0, 0.0)


def test_distance_follows_the_time_made_continuous(sample_run):
    """Already at ingest, and after clean-up all the same."""
    truth = read_run(sample_run)

    def restart(lines):
        rows = [line.split(",") for line in lines[1:]]
        for row in rows[600:]:
            row[0] = f"{float(row[0]) - 59.9:.3f}"
        return [lines[0], *(",".join(row) for row in rows)]

    edit_rows(sample_run, restart)
    raw = read_run(sample_run)
    assert raw.columns["time"][600] < raw.columns["time"][599]
    np.testing.assert_allclose(raw.sliding_distance, truth.sliding_distance, atol=1e-6)
    cleaned = clean_run(raw).run
    np.testing.assert_allclose(cleaned.columns["time"], truth.columns["time"], atol=1e-6)
    np.testing.assert_allclose(cleaned.sliding_distance, truth.sliding_distance, atol=1e-6)
    findings = {finding.code: finding for finding in check_run(raw)}
    assert findings["signals_preprocessed"].severity == "note"
    assert "joined at the only restart" in findings["signals_preprocessed"].message
    assert not [finding for finding in findings.values() if finding.severity == "error"]


# --- what a sensor cannot have seen ---


def test_impossible_values_and_sentinels_are_masked(bare_run):
    columns = {name: values.copy() for name, values in TRUTH.items()}
    columns["relative_humidity"][7:9] = -10.646, 1.2
    columns["temperature"][11] = -700.0
    columns["friction_force"][[20, 40, 60]] = 9.99e9, -9.99e9, 9.99e9
    columns["depth"][5:15] = 9.99e3
    cleaned = clean_run(run_of(bare_run, **columns), only(Mask())).run
    for name in ("relative_humidity", "temperature", "friction_force", "depth"):
        spoilt = columns[name] != TRUTH[name]
        assert spoilt.any()
        np.testing.assert_array_equal(cleaned.columns[name], np.where(spoilt, np.nan, TRUTH[name]))
    assert np.isnan(cleaned.columns["friction_coefficient"][[20, 40, 60]]).all()


def test_channel_without_a_possible_value_is_left_out(bare_run):
    dead = run_of(bare_run, **{**TRUTH, "relative_humidity": np.full(SAMPLES, -10.646)})
    cleaned = clean_run(dead)
    assert "relative_humidity" not in cleaned.run.columns
    assert cleaned.record.left_out == ("relative_humidity",)
    assert clean_run(cleaned.run).run is cleaned.run


@pytest.mark.parametrize("recorded", [False, True])
def test_dead_load_channel_gives_way_to_the_nominal_load(bare_run, recorded):
    load = 1e-8 * NOISE[0]
    columns = {name: TRUTH[name] for name in ("time", "sliding_distance", "friction_force")}
    if recorded:
        columns["friction_coefficient"] = np.sign(load) * 9e6
    cleaned = clean_run(run_of(bare_run, **columns, normal_force=load), only(*AUTOMATIC[:2])).run
    assert "normal_force" not in cleaned.columns
    assert cleaned.origins["friction_coefficient"] == "derived from nominal load"
    np.testing.assert_allclose(cleaned.columns["friction_coefficient"], TRUTH["friction_force"] / LOAD)


def test_load_that_makes_all_friction_impossible_gives_way_to_the_nominal_load(bare_run):
    """A dead channel that was not zeroed, or a load in a wrong unit: neither tells what pressed."""
    wrong = {**TRUTH, "normal_force": np.full(SAMPLES, LOAD / 200) + 1e-7 * NOISE[0]}
    cleaned = clean_run(run_of(bare_run, **wrong))
    assert cleaned.record.left_out == ("normal_force",)
    assert cleaned.run.origins["friction_coefficient"] == "derived from nominal load"
    assert "load_not_nominal" in {finding.code for finding in check_run(run_of(bare_run, **wrong))}
    little = run_of(bare_run, **{**wrong, "friction_force": 0.3 * wrong["normal_force"]})
    assert clean_run(little).record.left_out == ()


def test_limits_of_the_lab_have_the_unit_of_the_signal(bare_run, tmp_path):
    (tmp_path / "recipe.toml").write_text(
        '[[clean_up]]\nstep = "mask"\nlimits.temperature = { lowest = "0 degC", highest = "80 degC" }\n',
        encoding="utf-8",
    )
    temperature = TRUTH["temperature"].copy()
    temperature[3:6] = 272.0, 353.0, 354.0
    spoilt = run_of(bare_run, time=TRUTH["time"], sliding_distance=TRUTH["time"], temperature=temperature)
    cleaned = clean_run(spoilt, load_toml(tmp_path / "recipe.toml", Recipe))
    assert np.flatnonzero(np.isnan(cleaned.run.columns["temperature"])).tolist() == [3, 5]
    assert [change.samples for change in cleaned.record.changes] == [1, 1]


@pytest.mark.parametrize(
    "step",
    [
        Mask(),
        Mask(limits={"sliding_speed": {"highest": "1 m/s"}}),
        Despike(signals=("sliding_speed",)),
    ],
)
def test_masked_speeds_do_not_end_the_sliding_distance(bare_run, step):
    speed = 0.4 + 1e-3 * NOISE[2]
    speed[[100, 2000, 2001]] = 9999.0
    origins = {"sliding_distance": "derived from measured speed"}
    spoilt = run_of(bare_run, time=TRUTH["time"], sliding_speed=speed, sliding_distance=TRUTH["sliding_distance"])
    spoilt = dataclasses.replace(spoilt, origins={**spoilt.origins, **origins})
    cleaned = clean_run(spoilt, only(step)).run
    assert np.flatnonzero(np.isnan(cleaned.columns["sliding_speed"])).tolist() == [100, 2000, 2001]
    np.testing.assert_allclose(cleaned.sliding_distance, 0.4 * TRUTH["time"], rtol=1e-2, atol=1e-3)


def test_friction_without_load_is_masked(bare_run):
    cleaned = clean_run(run_of(bare_run, **TRUTH))
    mu, load = cleaned.run.columns["friction_coefficient"], TRUTH["normal_force"]
    np.testing.assert_array_equal(np.isnan(mu), load < 0.05 * LOAD)
    assert ("unloaded-friction", "friction_coefficient") in told(cleaned.record)


def test_spikes_are_masked_where_the_recipe_says_so(bare_run):
    spoilt = {**TRUTH, "depth": TRUTH["depth"].copy()}
    where = [100, 1500, 3999]
    spoilt["depth"][where] += [5e-7, -8e-7, 3e-7]
    assert clean_run(run_of(bare_run, **spoilt)).run.columns["depth"][1500] == spoilt["depth"][1500]
    cleaned = clean_run(run_of(bare_run, **spoilt), only(Despike(signals=("depth",)))).run
    assert np.flatnonzero(np.isnan(cleaned.columns["depth"])).tolist() == where


def test_steps_between_the_values_of_a_converter_are_no_spikes():
    coarse = np.round(np.linspace(0, 10, 4000) + 0.2 * RNG.normal(size=4000))
    assert not spikes(coarse, 11, 6.0).any()


@pytest.mark.parametrize("name", ["depth", "normal_force", "friction_force"])
def test_samples_lost_as_zeros_are_masked(bare_run, name):
    columns = {one: values[500:3500] for one, values in TRUTH.items()}
    lost = np.zeros(3000, dtype=bool)
    lost[RNG.choice(np.arange(10, 2990, 7), 150)] = True
    columns[name] = np.where(lost, 0.0, columns[name])
    cleaned = clean_run(run_of(bare_run, **columns))
    np.testing.assert_array_equal(np.isnan(cleaned.run.columns[name]), lost)


@given(st.lists(st.sampled_from([-1.0, 1.0]), min_size=3, max_size=60), st.integers(-5, 5), st.floats(0.3, 3.0))
def test_zeros_of_a_signal_that_passes_zero_are_kept(steps, start, scale):
    assert not np.any(_lone_zeros(scale * (start + np.cumsum(steps))))


def test_zeros_that_were_measured_are_kept(bare_run):
    """A pin that was lifted for ten samples, a load that is not yet on, and friction that turns."""
    load = np.where(LOADED > 0.5, 0.2, 0.0) + np.where(LOADED > 0.5, 1e-4 * NOISE[0], 0.0)
    load[2000:2010] = 0.0
    swing = 0.05 * np.sign(np.sin(np.arange(SAMPLES) / 20))
    cleaned = clean_run(run_of(bare_run, **TRUTH | {"normal_force": load, "friction_force": swing}), only(Mask()))
    assert cleaned.record.changes == ()


def test_a_row_before_the_first_restart_counts_for_nothing(bare_run):
    """A row of factors under the header, or the last sample of the test before."""
    columns = {name: np.concatenate([[1.0], values]) for name, values in TRUTH.items()}
    cleaned = clean_run(run_of(bare_run, **columns)).run
    assert all(np.isnan(cleaned.columns[name][0]) for name in ("depth", "friction_force", "normal_force"))
    np.testing.assert_array_equal(cleaned.columns["depth"][401:3701], TRUTH["depth"][400:3700])


# --- coarse clocks ---


@pytest.mark.parametrize("per_second", [2, 4, 7])
def test_times_of_a_clock_with_whole_seconds_are_spread(bare_run, per_second):
    true = np.arange(3000) / per_second
    true[1500:] += 120.0  # a pause
    columns = {name: values[:3000] for name, values in TRUTH.items()} | {"time": np.floor(true)}
    cleaned = clean_run(run_of(bare_run, **columns)).run.columns["time"]
    np.testing.assert_allclose(cleaned, true, atol=0.5)
    assert np.mean(np.abs(cleaned - true)) < 0.01
    assert np.all(np.diff(cleaned) > 0)


def test_times_of_rows_exported_twice_are_kept(bare_run):
    columns = {name: np.repeat(values[:2000], 2) for name, values in TRUTH.items()}
    run = run_of(bare_run, **columns)
    np.testing.assert_array_equal(clean_run(run).run.columns["time"], run.columns["time"])
    assert "repeated_samples" in [one.code for one in check_run(run)]


# --- idle ends ---


def idle_run(bare_run, before: int, after: int, *, low: float = 0.3, origin: str = "derived from nominal speed"):
    """Record 5 N at 0.1 m/s for 1800 s every 2 s, with the motor standing still at both ends; k_D is 2e-14 m²/N."""
    rng, count = np.random.default_rng(17), 900
    time = 2.0 * np.arange(before + count + after)
    slid = 0.1 * np.clip(time - 2 * before, 0, 2 * count)
    mu = np.where((slid > 0) & (time <= 2 * (before + count)), np.where(slid < 20, low, 0.3), 0.0)
    radius = bare_run.manifest.described.sliding_tip.radius.value
    depth = np.sqrt(2e-14 * 5 * slid / (np.pi * radius))
    columns = {
        "time": time,
        "sliding_distance": 0.1 * time,
        "friction_force": 5 * mu + rng.normal(0, 0.02, len(time)),
        "depth": depth + rng.normal(0, 20e-9, len(time)),
    }
    force = Quantity(value=5.0, unit="N")
    run = run_of(bare_run, {"normal_load": force, "sliding_speed": Quantity(value=0.1, unit="m/s")}, **columns)
    return dataclasses.replace(run, origins=run.origins | {"sliding_distance": origin}), slid


@pytest.mark.parametrize(("before", "after"), [(2, 0), (5, 0), (15, 0), (0, 20), (400, 100)])
def test_distance_by_the_nominal_speed_begins_and_ends_with_the_friction(bare_run, before, after):
    run, slid = idle_run(bare_run, before, after)
    cleaned = clean_run(run)
    np.testing.assert_allclose(cleaned.run.sliding_distance, slid, atol=0.21)
    idle = np.isnan(cleaned.run.columns["depth"])
    assert before + after - 2 <= int(np.count_nonzero(idle)) <= before + after + 6
    assert not np.any(idle[before + 6 : before + 899])
    codes = [one.code for one in check_run(run)]
    assert ("contact_lost" in codes) == (before + after > 30)


@pytest.mark.parametrize("before", [2, 5, 15])
def test_k_d_by_the_depth_signal_alone_is_right_though_the_motor_started_late(bare_run, before):
    """As by a distance that counts from the first sample, k_D came out as 45 %, nothing and a thousandth of it."""
    run, _ = idle_run(bare_run, before, 0)
    recipe = Recipe(monte_carlo=MonteCarloRecipe(significant_digits=0))
    fit = fit_wear(correct_drift(clean_run(run).run), recipe=recipe)
    assert fit.first.wear_coefficient.value == pytest.approx(2e-14, rel=0.05)


@pytest.mark.parametrize("recorded", [True, False])
@pytest.mark.parametrize(("rise", "displacement"), [(6.0, 1e-6), (20.0, 5e-6), (60.0, 5e-6)])
def test_displacement_while_the_load_comes_on_during_sliding_is_no_wear(bare_run, recorded, rise, displacement):
    """With 5 µm within 20 s, k_D by the depth signal alone came out as a tenth, or four times what it is."""
    run, slid = idle_run(bare_run, 0, 0)
    time, rng = run.columns["time"], np.random.default_rng(19)
    share = np.clip((time + 1) / rise, 0, 1) * np.clip((time[-1] - time + 1) / 10, 0, 1)
    work = 0.2 * 5 * np.concatenate([[0.0], np.cumsum((share[1:] + share[:-1]) / 2)])
    depth = run.columns["depth"] * np.sqrt(np.divide(work, 5 * slid, where=slid > 0, out=np.zeros_like(slid)))
    forces = {"normal_force": 5 * share, "friction_force": 1.5 * share}
    forces = {
        name: values + rng.normal(0, 0.02, len(time))
        for name, values in forces.items()
        if recorded or "n" not in name[:1]
    }
    noise = 200e-9 * rng.standard_normal(len(time))
    columns = {"time": time, "sliding_distance": slid, "depth": depth + displacement * (share - 1) + noise}
    run = run_of(bare_run, {"normal_load": Quantity(value=5.0, unit="N")}, **columns | forces)
    recipe = Recipe(monte_carlo=MonteCarloRecipe(significant_digits=0))
    fit = fit_wear(correct_drift(clean_run(run).run), recipe=recipe)
    assert fit.first.wear_coefficient.value == pytest.approx(2e-14, rel=0.1)


@pytest.mark.parametrize("origin", ["measured", "derived from rotations"])
def test_distance_that_was_measured_is_kept(bare_run, origin):
    cleaned = clean_run(idle_run(bare_run, 15, 0, origin=origin)[0])
    assert [change.signal for change in cleaned.record.changes if change.step == "idle"] == ["depth"]


def test_running_in_at_a_tenth_of_the_later_friction_slides(bare_run):
    assert clean_run(idle_run(bare_run, 0, 0, low=0.03)[0]).record.changes == ()


@pytest.mark.parametrize("friction", [True, False])
@pytest.mark.parametrize("displacement", [1e-6, 20e-6])
def test_displacement_while_the_load_comes_on_is_no_wear(bare_run, friction, displacement):
    """Of 1 µm before the motor starts k_D was 60 %, of 5 µm a 270th of what it is."""
    run, slid = idle_run(bare_run, 15, 10, origin="measured")
    loading = displacement * np.clip(run.columns["time"] / 20, 0, 1)
    kept = [name for name in run.columns if friction or not name.startswith("friction")]
    columns = {name: run.columns[name] for name in kept} | {"depth": run.columns["depth"] + loading}
    run = dataclasses.replace(run, columns=columns | {"sliding_distance": slid})
    recipe = Recipe(monte_carlo=MonteCarloRecipe(significant_digits=0))
    fit = fit_wear(correct_drift(clean_run(run).run), recipe=recipe)
    assert fit.first.wear_coefficient.value == pytest.approx(2e-14, rel=0.05)


def test_friction_that_was_not_recorded_from_the_start_shows_no_standstill(bare_run):
    run, _ = idle_run(bare_run, 0, 0)
    late = run.columns["friction_force"].copy()
    late[:50] = np.nan
    run = dataclasses.replace(run, columns=run.columns | {"friction_force": late})
    np.testing.assert_allclose(clean_run(run).run.sliding_distance, run.sliding_distance, rtol=1e-12)


# --- forces ---


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_offset_and_sign_of_the_forces_are_mended(bare_run, sign):
    """A load that reads −0.14 N, or upside down, before and after contact, as unzeroed load cells do."""
    columns = TRUTH | {
        "normal_force": sign * TRUTH["normal_force"] - sign * 0.08,
        "friction_force": -(TRUTH["friction_force"] - 0.012),
    }
    cleaned = clean_run(run_of(bare_run, **columns))
    np.testing.assert_allclose(cleaned.run.columns["normal_force"], TRUTH["normal_force"], atol=3e-5)
    np.testing.assert_allclose(cleaned.run.columns["friction_force"], TRUTH["friction_force"], atol=3e-5)
    mu = cleaned.run.columns["friction_coefficient"]
    assert np.nanmedian(mu) == pytest.approx(0.3, rel=2e-3)
    zero = next(change for change in cleaned.record.changes if change.step == "zero")
    assert abs(zero.offset.value + sign * 0.08) < 4 * zero.offset.standard_uncertainty < 1e-4
    assert [change.factor for change in cleaned.record.changes if change.factor] == [-1.0] * (1 + (sign < 0))


@pytest.mark.parametrize("moved", [0.0, 0.002, 0.06, -0.06])
def test_zero_that_moves_during_the_test_is_interpolated_and_reported(bare_run, moved):
    course = moved * TRUTH["time"] / TRUTH["time"][-1]
    columns = TRUTH | {
        "normal_force": TRUTH["normal_force"] - 0.08,
        "friction_force": TRUTH["friction_force"] - 0.012 + course,
    }
    run = run_of(bare_run, **columns)
    cleaned = clean_run(run)
    friction = cleaned.run.columns["friction_force"]
    np.testing.assert_allclose(friction, TRUTH["friction_force"], atol=1e-4 + 0.05 * abs(moved))
    zero = next(one.offset for one in cleaned.record.changes if one.signal == "friction_force" and one.step == "zero")
    assert zero.value == pytest.approx(-0.012 + moved / 2, abs=1e-3)
    assert zero.standard_uncertainty == pytest.approx(abs(moved) / math.sqrt(12), rel=0.08, abs=1e-4)
    (found,) = [one for one in check_run(run) if one.code == "uncertain_zero"] or [None]
    assert (found is None) == (abs(moved) < 0.05)


def test_zero_that_was_different_after_the_test_holds_between_stated_windows(bare_run):
    """At 10 s, 40 s and after the test: piecewise, not one line through all."""
    time = TRUTH["time"]
    course = np.interp(time, [0.0, 40.0, time[-1]], [0.0, 0.1, 0.1])
    windows = [TimeWindow(start=Quantity(value=at, unit="s"), end=Quantity(value=at + 2, unit="s")) for at in (9, 39)]
    windows.append(TimeWindow(start=Quantity(value=time[-1] - 2, unit="s"), end=Quantity(value=time[-1], unit="s")))
    force = np.where(np.any([(one.start.value <= time) & (time <= one.end.value) for one in windows], axis=0), 0.0, 0.3)
    run = run_of(bare_run, time=time, sliding_distance=TRUTH["sliding_distance"], friction_force=force + course)
    cleaned = clean_run(run, only(Zero(windows=tuple(windows)))).run.columns["friction_force"]
    later = time > 40
    np.testing.assert_allclose(cleaned[later], force[later], atol=4e-3)


def test_zero_in_stated_windows(bare_run):
    columns = TRUTH | {"normal_force": TRUTH["normal_force"] + 0.05, "friction_force": TRUTH["friction_force"] + 0.01}
    offset = run_of(bare_run, **columns)
    assert not [change for change in clean_run(offset).record.changes if change.step == "zero"]
    window = TimeWindow(start=Quantity(value=0.0, unit="s"), end=Quantity(value=25.0, unit="s"))
    cleaned = clean_run(offset, only(Zero(windows=(window,)))).run
    for name in ("normal_force", "friction_force"):
        np.testing.assert_allclose(cleaned.columns[name], TRUTH[name], atol=3e-5)


def test_recorded_friction_coefficient_gives_way_to_that_of_zeroed_forces(bare_run):
    """What an instrument divides before its forces are zeroed is off by their offsets."""
    forces = {"normal_force": TRUTH["normal_force"] - 0.03, "friction_force": TRUTH["friction_force"] + 0.01}
    recorded = forces["friction_force"] / forces["normal_force"]
    run = run_of(bare_run, **TRUTH | forces, friction_coefficient=recorded)
    cleaned = clean_run(run)
    mu = cleaned.run.columns["friction_coefficient"]
    assert np.nanmedian(mu) == pytest.approx(0.3, rel=2e-3)
    assert cleaned.run.origins["friction_coefficient"] == "derived from measured load"
    assert ("zero", "friction_coefficient") in told(cleaned.record)
    without = run_of(bare_run, **TRUTH, friction_coefficient=recorded)
    assert clean_run(without, only(Zero())).run.columns["friction_coefficient"] is recorded


@pytest.mark.parametrize("offset", [-0.003, 0.0, 0.002, 0.0036])
def test_zero_of_friction_is_seen_though_the_load_reads_a_little(bare_run, offset):
    """A friction of 16 mN and more is none of a load that may be 3.6 mN, or nothing; that load is left as it is."""
    columns = TRUTH | {
        "normal_force": TRUTH["normal_force"] + offset,
        "friction_force": TRUTH["friction_force"] + 0.016,
    }
    cleaned = clean_run(run_of(bare_run, **columns))
    np.testing.assert_allclose(cleaned.run.columns["friction_force"], TRUTH["friction_force"], atol=5e-5)
    load = cleaned.run.columns["normal_force"]
    np.testing.assert_allclose(load, TRUTH["normal_force"] + max(offset, 0.0), atol=5e-5)


def test_friction_of_a_small_load_is_no_zero(bare_run):
    columns = TRUTH | {
        "normal_force": TRUTH["normal_force"] + 0.0036,
        "friction_force": TRUTH["friction_force"] + 0.004,
    }
    assert not [change for change in clean_run(run_of(bare_run, **columns)).record.changes if change.step == "zero"]


def test_windows_without_samples_are_told(bare_run):
    window = TimeWindow(start=Quantity(value=1e4, unit="s"), end=Quantity(value=2e4, unit="s"))
    cleaned = clean_run(run_of(bare_run, **TRUTH), only(Zero(windows=(window,), signals=("normal_force",))))
    (change,) = cleaned.record.changes
    assert (change.signal, change.samples) == ("normal_force", 0)
    assert change.what == "not zeroed: 0 samples in the stated windows; expected at least 2"


def test_small_load_before_a_large_one_is_not_taken_for_none(bare_run):
    stairs = run_of(bare_run, **{**TRUTH, "normal_force": TRUTH["normal_force"] + 0.02})
    assert not [change for change in clean_run(stairs).record.changes if change.step == "zero"]


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(
    "shares",
    [
        pytest.param((0, 1, 1), id="begins without contact and ends under load"),
        pytest.param((1, 1, 0), id="begins under load"),
        pytest.param((0.2, 0.6, 1), id="loads that grow"),
        pytest.param((1, 0.6, 0.2), id="loads that fall"),
    ],
)
def test_a_load_is_never_taken_for_none(bare_run, shares, sign):
    """Where the channel counts downwards, full load is the least reading."""
    load = LOAD * np.repeat(shares, [1300, 1400, 1300])
    recorded = sign * load + 1e-4 * NOISE[0]
    run = run_of(bare_run, **TRUTH | {"normal_force": recorded, "friction_force": 0.3 * load})
    np.testing.assert_allclose(clean_run(run).run.columns["normal_force"], load, atol=1e-3)


def test_turned_load_is_a_warning_and_no_error(bare_run):
    findings = {f.code: f.severity for f in check_run(run_of(bare_run, **TRUTH | {"normal_force": -0.2 + 0 * LOADED}))}
    assert findings["load_sign"] == "warning"
    assert "error" not in findings.values()


@pytest.mark.slow
def test_depth_that_counts_down_gives_the_same_wear_once_it_is_turned_over(short_runs):
    truth = read_run(short_runs / "si3n4-air-400mN")
    falling = dataclasses.replace(truth, columns={**truth.columns, "depth": -truth.columns["depth"]})
    recipe = only(*AUTOMATIC, Invert(signals=("depth",)))
    cleaned = clean_run(falling, recipe)
    assert told(cleaned.record) == [("invert", "depth")]
    assert (cleaned.record.changes[0].factor, list(cleaned.columns)) == (-1.0, ["depth"])
    for name, values in truth.columns.items():
        np.testing.assert_array_equal(cleaned.run.columns[name], values)
    k_d, same, other = (
        fit_wear(correct_drift(run, recipe), "archard").first.wear_coefficient for run in (truth, cleaned.run, falling)
    )
    assert same == k_d
    assert other != k_d
    assert clean_run(falling).run is falling


def test_only_what_was_measured_is_turned_over(bare_run):
    run = run_of(bare_run, **{name: values for name, values in TRUTH.items() if name != "depth"})
    cleaned = clean_run(run, only(Invert(signals=("depth", "friction_coefficient"))))
    (change,) = cleaned.record.changes
    assert (change.what, change.samples) == ("sign not inverted, since it was not measured", 0)
    assert cleaned.run is run
    twice = clean_run(run, only(Invert(signals=("friction_force", "friction_force")))).run
    np.testing.assert_array_equal(twice.columns["friction_force"], -TRUTH["friction_force"])
    np.testing.assert_array_equal(twice.columns[MU], -run.columns[MU])


# --- strokes ---

MU = "friction_coefficient"
STROKE = 50
PHASE = np.arange(SAMPLES) / STROKE
SWING = np.clip(4 * np.sin(np.pi * PHASE), -1, 1)
STROKES = {"stroke": Quantity(value=5e-3, unit="m"), "frequency": Quantity(value=0.1, unit="1/s")}


def reciprocating(bare, offset=0.0, conditions=STROKES, **more):
    mu = 0.25 + 0.05 * np.floor(PHASE) / (SAMPLES / STROKE)
    force = LOAD * mu * SWING + offset + 1e-5 * NOISE[0]
    columns = {"time": TRUTH["time"], "sliding_distance": TRUTH["sliding_distance"], "friction_force": force, **more}
    return run_of(bare, conditions, **columns), mu


@pytest.mark.parametrize(("method", "offset"), [("middle-of-stroke", 0.0), ("half-difference", 0.01)])
def test_strokes_get_one_friction_coefficient_each(bare_run, method, offset):
    run, mu = reciprocating(bare_run, offset)
    cleaned = clean_run(run, only(StrokeWiseFriction(method=method)))
    found = cleaned.run.columns["friction_coefficient"]
    middle = np.abs(PHASE % 1 - 0.5) < 0.2
    np.testing.assert_allclose(found[middle], mu[middle], atol=1e-3)
    assert np.isnan(found[np.abs(PHASE % 1 - 0.5) > 0.4]).all()
    assert method in cleaned.record.changes[0].what
    assert cleaned.record.changes[0].parts == SAMPLES // STROKE
    assert cleaned.run.origins["friction_coefficient"] == "derived from nominal load"
    assert clean_run(cleaned.run, only(StrokeWiseFriction(method=method))).run is cleaned.run


@pytest.mark.parametrize("forth", [0.5, 0.6])
def test_each_stroke_counts_alike_however_long_it_takes(bare_run, forth):
    # Forth, a drive takes longer than back, and with an offset friction seems larger.
    force = LOAD * (np.where(forth > PHASE / 2 % 1, 0.3, -0.3) + 0.027)
    columns = {"time": TRUTH["time"], "sliding_distance": TRUTH["sliding_distance"], "friction_force": force}
    found = clean_run(run_of(bare_run, STROKES, **columns)).run.columns[MU]
    assert np.unique(found[np.isfinite(found)]) == pytest.approx([0.273, 0.327])
    assert np.nanmean(found) == pytest.approx(0.3, rel=1e-3)


def test_half_difference_finds_strokes_beside_any_offset(bare_run):
    run, mu = reciprocating(bare_run, offset=0.1)
    found = clean_run(run, only(StrokeWiseFriction(method="half-difference"))).run.columns["friction_coefficient"]
    assert np.nanmean(found) == pytest.approx(np.mean(mu), rel=1e-3)
    assert clean_run(run, only(StrokeWiseFriction())).run is run


@pytest.mark.parametrize("sentinels", [0, 30])
def test_strokes_are_found_beside_what_is_masked(bare_run, sentinels):
    """Sentinels among the forces, and noise over noise before contact, hide no stroke."""
    run, mu = reciprocating(bare_run, normal_force=LOAD * LOADED + 1e-4 * NOISE[0])
    force = run.columns["friction_force"] * LOADED + 2e-4 * NOISE[1]
    force[RNG.choice(np.arange(400, 3700), sentinels, replace=False)] = -99.0
    cleaned = clean_run(run_of(bare_run, STROKES, **run.columns | {"friction_force": force}, derived=[MU])).run
    found = cleaned.columns[MU]
    assert np.count_nonzero(np.isfinite(found)) > 1200
    np.testing.assert_allclose(found, np.where(np.isfinite(found), mu, np.nan), atol=2e-3)


def test_strokes_are_averaged_by_themselves_only_where_a_stroke_is_stated(bare_run):
    stated, _ = reciprocating(bare_run)
    silent, mu = reciprocating(bare_run, conditions=None)
    assert told(clean_run(stated).record) == [("stroke-wise-friction", "friction_coefficient")]
    assert clean_run(silent).run is silent
    asked = clean_run(silent, only(StrokeWiseFriction(only_with_stroke=False))).run
    assert np.nanmean(asked.columns["friction_coefficient"]) == pytest.approx(np.mean(mu), rel=1e-3)


def test_friction_that_does_not_go_there_and_back_is_left(bare_run):
    steady = run_of(bare_run, STROKES, **{**TRUTH, "friction_force": np.abs(TRUTH["friction_force"])})
    assert "stroke-wise-friction" not in dict(told(clean_run(steady).record))
    unsigned = run_of(bare_run, STROKES, **{**TRUTH, "friction_force": 0.05 * np.abs(np.sin(np.pi * PHASE))})
    assert clean_run(unsigned, only(StrokeWiseFriction(method="half-difference"))).run is unsigned
    noise = run_of(bare_run, STROKES, **{**TRUTH, "friction_force": 1e-3 * NOISE[1]})
    assert "stroke-wise-friction" not in dict(told(clean_run(noise).record))


# --- nothing to do, and doing it twice ---


def test_clean_run_is_left_alone_and_costs_no_copy(short_runs):
    run = read_run(short_runs / "si3n4-air-400mN")
    cleaned = clean_run(run)
    assert cleaned.run is run
    assert (cleaned.record.changes, dict(cleaned.columns)) == ((), {})


@settings(max_examples=25)
@given(
    st.sampled_from([1.0, -1.0]),
    st.floats(-0.1, 0.1),
    st.booleans(),
    st.floats(0, 500),
    st.lists(st.integers(0, SAMPLES - 1), max_size=5),
)
def test_cleaning_a_clean_run_changes_nothing(bare_run, sign, offset, restarts, start, faults):
    columns = {name: values.copy() for name, values in TRUTH.items()}
    columns["normal_force"] = sign * columns["normal_force"] + offset
    columns["relative_humidity"][faults] = -1.0
    columns["sliding_distance"] += start
    if restarts:
        columns["time"] = restarting(columns["time"])
    cleaned = clean_run(run_of(bare_run, **columns))
    again = clean_run(cleaned.run)
    assert again.record.changes == ()
    assert again.run is cleaned.run


def test_no_steps_no_changes(bare_run):
    spoilt = run_of(bare_run, **{**TRUTH, "normal_force": -TRUTH["normal_force"]})
    assert clean_run(spoilt, only()).run is spoilt


# --- recipe ---


@pytest.mark.parametrize(
    ("written", "message"),
    [
        ([{"step": "zeroing"}], r"clean_up\[0\].step: found 'zeroing'; expected 'continuous-axes', 'mask'"),
        ([{"step": "zero", "window": 3}], r"clean_up\[0\].window: unknown key; did you mean 'windows'"),
        ([{"step": "mask", "limits": {"heat": {}}}], r"clean_up\[0\].limits.heat: unknown key"),
        (
            [{"step": "mask", "limits": {"depth": {"lowest": "1 N"}}}],
            "found the unit 'N', which is not a unit of length",
        ),
        ([{"step": "despike", "window": 4}], "expected an odd number"),
        ([{"step": "invert"}], r"clean_up\[0\].signals: missing"),
        ([{"step": "invert", "signals": []}], "signals: found no signals; expected at least one signal"),
        ([{"step": "invert", "signals": ["time"]}], r"signals\[0\]: found 'time'; expected 'depth', 'normal_force'"),
        (
            [{"step": "zero", "windows": [{"start": "5 s", "end": "2 s"}]}],
            r"start: found 5 s, not before end \(2 s\)",
        ),
    ],
)
def test_recipe_that_cannot_be_meant_is_refused(written, message):
    with pytest.raises(ManifestError, match=message):
        read_document({"clean_up": written}, Recipe, where="recipe.toml")


def test_documented_recipes_are_recipes():
    text = (ROOT / "docs" / "clean_up.md").read_text(encoding="utf-8")
    default, *others = (tomllib.loads(block) for block in re.findall(r"```toml\n(.*?)```", text, re.DOTALL))
    assert Recipe.model_validate(default) == Recipe()
    for document in others:
        Recipe.model_validate(document if "clean_up" in document else {})


def test_recipe_comes_back_from_json():
    recipe = only(
        Zero(windows=(TimeWindow(start=Quantity(value=0.0, unit="s"), end=Quantity(value=1.0, unit="s")),)),
        Mask(limits={"depth": {"lowest": "-5 um"}}),
        Despike(),
    )
    assert Recipe.model_validate(json.loads(recipe.model_dump_json(by_alias=True))) == recipe
    assert '"despike"' in schema_text("recipe")


# --- archive and commands ---


@pytest.fixture
def spoilt_run(sample_run):
    """The sample run with its load upside down and its distance carried over and restarting."""
    truth = read_run(sample_run)

    def spoil(lines):
        head = lines[0].split(",")
        load = next(number for number, name in enumerate(head) if name.startswith("Fn"))
        rows = [line.split(",") for line in lines[1:]]
        for number, row in enumerate(rows):
            row[load] = f"-{row[load]}"
            row[0] = f"{float(row[0]) - (74.9 if number >= 750 else 0):.3f}"
        return [lines[0], *(",".join(row) for row in rows)]

    edit_rows(sample_run, spoil)
    return sample_run, truth


def results(archive: Archive, run_id: str) -> dict:
    return {
        name: (step.result, {curve: values.tobytes() for curve, (values, _) in step.curves.items()})
        for name, step in archive.steps(run_id).items()
        if name != "clean_up"
    }


@pytest.mark.slow
def test_clean_up_is_archived_beside_the_raw_run_and_can_be_taken_back(spoilt_run, tmp_path):
    folder, truth = spoilt_run
    archive, run_id = Archive(tmp_path / "archive"), truth.id
    raw = read_run(folder)
    archive.add(raw)
    whole = Recipe(wear=WearRecipe(models=("archard",)), monte_carlo=MonteCarloRecipe(significant_digits=0))
    without, joined = (whole.model_copy(update={"clean_up": steps}) for steps in ((), (ContinuousAxes(),)))
    outcomes = {outcome.stage: outcome for outcome in process([folder], archive, whole)}
    assert outcomes["clean_up"].status == "done"
    cleaned = archive.cleaned(run_id)
    for name in truth.columns:
        np.testing.assert_allclose(cleaned.columns[name], truth.columns[name], rtol=1e-6, atol=1e-9)
        np.testing.assert_array_equal(archive.raw(run_id).columns[name], raw.columns[name])
    first = results(archive, run_id)
    assert nxcheck(archive.path(run_id))[:2] == (0, 0)
    with archive.open(run_id) as file:
        link = file["entry/clean_up/data"]
        assert link.attrs["signal"] == "time"
        np.testing.assert_array_equal(file["entry/wear/sliding_distance"][()], cleaned.sliding_distance)
    assert {outcome.status for outcome in process([folder], archive, whole)} == {"unchanged"}
    list(process([folder], archive, joined))
    assert results(archive, run_id) != first
    assert archive.cleaned(run_id).columns["normal_force"][5] < 0
    advance(archive, run_id, "clean_up", without)
    assert archive.step_names(run_id) == ["clean_up"]
    assert archive.cleaned(run_id).columns["time"][750] < archive.cleaned(run_id).columns["time"][749]
    list(process([folder], archive, whole))
    assert results(archive, run_id) == first


def test_left_out_channels_stay_out_of_what_comes_back(bare_run, tmp_path):
    columns = {name: TRUTH[name] for name in ("time", "sliding_distance", "friction_force")}
    archive = Archive(tmp_path)
    archive.add(run_of(bare_run, **columns, normal_force=1e-8 * NOISE[0]))
    assert advance(archive, "bare", "clean_up", Recipe()).status == "done"
    cleaned = archive.cleaned("bare")
    assert "normal_force" not in cleaned.columns
    assert cleaned.origins["friction_coefficient"] == "derived from nominal load"
    assert "normal_force" in archive.raw("bare").columns


@pytest.mark.slow
def test_curves_are_drawn_against_the_cleaned_axis(bare_run, tmp_path):
    columns = TRUTH | {"sliding_distance": TRUTH["sliding_distance"] + 700}
    archive = Archive(tmp_path)
    archive.add(run_of(bare_run, **columns))
    advance(archive, "bare", "friction_fit", Recipe())
    with archive.open("bare") as file:
        drawn = file["entry/friction_fit/data"]
        assert drawn.attrs["axes"].tolist() == ["sliding_distance"]
        np.testing.assert_allclose(drawn["sliding_distance"][()], TRUTH["sliding_distance"], atol=1e-9)
        np.testing.assert_array_equal(file["entry/raw/sliding_distance"][()], columns["sliding_distance"])
    np.testing.assert_allclose(archive.cleaned("bare").sliding_distance, TRUTH["sliding_distance"], atol=1e-9)
    assert nxcheck(archive.path("bare"))[:2] == (0, 0)


def test_steps_stand_on_what_clean_up_found_and_not_on_its_options(archive):
    store = Archive(archive)
    before = results(store, "si3n4-air-200mN")
    assert advance(store, "si3n4-air-200mN", "clean_up", Recipe(clean_up=())).status == "done"
    assert results(store, "si3n4-air-200mN") == before


@pytest.mark.slow
def test_commands_say_what_was_cleaned_up(spoilt_run, run_cli, tmp_path):
    folder, truth = spoilt_run
    recipe = tmp_path / "recipe.toml"
    recipe.write_text("[monte_carlo]\nsignificant_digits = 0\n", encoding="utf-8")
    done = run_cli("process", folder, "--archive", "archive", "--recipe", recipe, "--no-figures", cwd=tmp_path)
    assert done.exit_code == 0, done.output
    (line,) = [line for line in done.output.splitlines() if line.startswith(f"{truth.id}: preprocessing: ")]
    assert "time: joined at the only restart" in line
    assert "normal_force: sign inverted" in line
    shown = run_cli("show", truth.id, "-v", cwd=tmp_path)
    assert "normal_force: sign inverted" in shown.output
    document = json.loads(run_cli("show", truth.id, "--json", cwd=tmp_path).stdout)
    assert [change["step"] for change in document["clean_up"]["changes"]] == ["continuous-axes", "pressing-load"]
    assert document["steps"][0] == "clean_up"
    recipe.write_text('clean_up = [{ step = "continuous-axes" }]\n', encoding="utf-8")
    again = run_cli("correct-drift", "--archive", "archive", "--recipe", recipe, cwd=tmp_path)
    assert "preprocessing: time: joined" in again.output


# --- axes from what the manifest says ---


def test_rotations_and_track_radius_give_the_distance_of_a_pin(sample_run):
    replace_in(sample_run / "run.toml", r"(?m)^\[conditions\]$", '[conditions]\ntrack_radius = "5 mm"')
    (sample_run / "signals.csv").write_text(
        "Time [s],Rotations [1],Depth [um]\n0,0,0\n1,2,1\n2,4,1\n", encoding="utf-8"
    )
    replace_in(sample_run / "run.toml", r"(?ms)^\[signals.columns\].*?(?=^\[end_values\])", "\n")
    run = read_run(sample_run)
    assert run.origins["sliding_distance"] == "derived from rotations"
    np.testing.assert_allclose(run.sliding_distance, 2 * np.pi * 5e-3 * np.array([0, 2, 4]))


@pytest.mark.parametrize(
    ("conditions", "speed"),
    [
        ('rotational_speed = "60 rpm"\ntrack_radius = "5 mm"', 2 * np.pi * 5e-3),
        ('stroke = "5 mm"\nfrequency = "2 Hz"', 0.02),
        ("", None),
    ],
)
def test_speed_follows_from_track_or_stroke_and_is_else_unknown(sample_run, conditions, speed):
    replace_in(sample_run / "run.toml", r"(?m)^sliding_speed = .*$", conditions)
    run = read_run(sample_run)
    if speed is None:
        assert run.origins["sliding_distance"] == "unknown"
        assert np.isnan(run.sliding_distance).all()
        assert "an unknown distance" in str(run)
        assert "distance_unknown" in [finding.code for finding in check_run(run)]
    else:
        np.testing.assert_allclose(run.sliding_distance, speed * run.columns["time"], rtol=1e-9)

"""Following a run: appended pieces give the whole, intervals hold the truth, and alarms are told once."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from independent.wear import worn_pair
from joint_fit import fit_joint
from listening import listening

from tribopipe.base.errors import FitError, ReaderError, UnitError
from tribopipe.documents.manifest import EndValues, RunManifest, read_manifest
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe, WearRecipe
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.wear.drift_and_wear import joint_problem
from tribopipe.evaluation.wear.problem import wear_problem
from tribopipe.evaluation.wear.scenario import KnownWear, Scenario
from tribopipe.extras.live.alarms import (
    StuckSensor,
    counterbody_alarms,
    departure,
    friction_alarms,
    load_alarms,
    recursive_residuals,
)
from tribopipe.extras.live.estimate import Posterior, posterior
from tribopipe.extras.live.follower import Follower
from tribopipe.extras.live.priors import _next, archived_coefficient, archived_drift, quantity_given
from tribopipe.extras.live.problem import Asked, Known, live_problem
from tribopipe.extras.live.session import Session
from tribopipe.extras.live.state import State
from tribopipe.readers.harmonize import read_run
from tribopipe.results.evaluation import DriftCorrection
from tribopipe.results.run import RawRun

END = 500.0
TRUE_K = Quantity(value=13.5e-15, unit="m^2/N")


def end_of(run) -> float:
    """Return the wear depth of a run at its end, m, by the true k_D."""
    manifest = run.manifest
    scenario = Scenario(manifest.described, manifest.conditions.normal_load, KnownWear({"pin": TRUE_K}))
    return float(scenario.worn(np.asarray(END))["wear_depth"])


def made_run(*, noise=1e-7, drift=2e-10, offset=1e-6, factor=1.0, shape="spherical", seed=1) -> RawRun:
    """Return 500 m at 10 Hz by Archard's law, with white noise, linear drift, and k_D times a factor from 250 m on."""
    from conftest import MANIFEST

    contact = {**MANIFEST["contact"], "pin": {**MANIFEST["contact"]["pin"], "shape": shape}}
    manifest = RunManifest.model_validate({**MANIFEST, "contact": contact})
    seconds = np.arange(12501) / 10
    distance = 0.4 * seconds
    slid = distance + (factor - 1) * np.maximum(distance - 250, 0)
    scenario = Scenario(manifest.described, manifest.conditions.normal_load, KnownWear({"pin": TRUE_K}))
    rng = np.random.default_rng(seed)
    depth = offset + scenario.worn(slid)["wear_depth"] + drift * seconds + noise * rng.standard_normal(len(seconds))
    columns = {"time": seconds, "sliding_distance": distance, "depth": depth}
    return RawRun(manifest, columns, dict.fromkeys(columns, "measured"), {}, {}, ())


PIN_K = 1e-15
"""k_D of a rigid pin, m²/N."""
BLOCK_K = 20e-15
LOAD = 5.0
PIN, RING, WIDTH = 3e-3, 20e-3, 6e-3
"""Radii of a pin and of a ring, and the width of a block, m."""
RIGID = {"material": "100Cr6", "youngs_modulus": "200000 GPa", "poisson_ratio": 0.3}
PAIR = {"kind": "pin-on-disc", "pin": {"shape": "spherical", "radius": f"{PIN} m", **RIGID}, "disc": RIGID}
BLOCK = {"kind": "block-on-ring", "block": {"width": f"{WIDTH} m", **RIGID}, "ring": {"radius": f"{RING} m", **RIGID}}
SECONDS = np.arange(12501) / 10
SLID = 0.4 * SECONDS


def recorded(contact: dict, measured: tuple[str, ...], *worn: np.ndarray) -> RawRun:
    """Return 500 m at 10 Hz with noise and 3 nm/min of drift; depths of the bodies in ``measured`` are stated."""
    from conftest import MANIFEST

    ends = {
        f"{body}_wear_depth": {"value": f"{depth[-1]} m", "standard_uncertainty": "0.1 um"}
        for body, depth in zip(measured, worn, strict=False)
    }
    conditions = {**MANIFEST["conditions"], "normal_load": f"{LOAD} N"}
    described = {**MANIFEST, "contact": contact, "conditions": conditions, "end_values": ends}
    depth = 1e-6 + np.sum(worn, axis=0) + 5e-11 * SECONDS + 1e-7 * np.random.default_rng(1).standard_normal(len(SLID))
    columns = {"time": SECONDS, "sliding_distance": SLID, "depth": depth}
    return RawRun(RunManifest.model_validate(described), columns, dict.fromkeys(columns, "measured"), {}, {}, ())


def grooved_run(groove: float, *, measured: bool = False) -> RawRun:
    """Return a run of a pin on a groove about ``groove`` times as deep as the pin, by an independent computation."""
    pin = PIN_K * LOAD * SLID
    cap = np.sqrt(pin[-1] / (np.pi * PIN))
    worn = worn_pair(PIN, pin, groove * 4 / 3 * cap * np.sqrt(2 * PIN * cap) * SLID / END)
    return recorded(PAIR, ("pin", "disc") if measured else (), worn.ball, worn.groove)


def ring_run(*, measured: bool = False) -> RawRun:
    """Return a run of a block, which loses segments of a circle, on a ring worn evenly by 5 µm."""
    depths = np.geomspace(1e-9, 1e-4, 2000)
    half = np.arccos(1 - depths / RING)
    segments = RING**2 * (half - np.sin(2 * half) / 2)
    block = np.interp(BLOCK_K * LOAD * SLID / WIDTH, segments, depths)
    return recorded(BLOCK, ("block", "ring") if measured else (), block, 5e-6 * SLID / END)


def followed(run: RawRun, share: float = 1.0, known: Known | None = None) -> tuple[Posterior, State]:
    """Return what is found after a share of a run."""
    state = State()
    state.add({name: values[: round(share * len(run))] for name, values in run.columns.items()})
    asked = Asked(replace(run, columns={}), known=known or Known(), planned=END)
    return posterior(live_problem(asked, state), asked.recipe.monte_carlo), state


def held(drawn: np.ndarray, true: float) -> bool:
    low, high = np.quantile(drawn, [0.025, 0.975])
    return bool(low <= true <= high)


# What was appended


LINES = [f"{0.1 * row:.2f},{1.5 + 0.01 * row:.2f},{40 + row % 7:.1f}\n" for row in range(60)]
TEXT = "".join(["Rig 7, µm\n", "Time [s],Depth [um],Ff [mN]\n", *LINES])


@pytest.fixture(scope="module")
def grown(tmp_path_factory) -> Path:
    """A run folder whose signals are written by the test."""
    folder = tmp_path_factory.mktemp("live") / "run"
    folder.mkdir()
    (folder / "run.toml").write_text(
        'schema = "tribopipe.run/1"\nid = "grown"\n[conditions]\nnormal_load = "200 mN"\nsliding_speed = "400 mm/s"\n'
        '[[signals]]\nfile = "signals.csv"\n[signals.columns]\ntime = "Time"\ndepth = "Depth"\nfriction_force = "Ff"\n',
        encoding="utf-8",
    )
    return folder


@settings(max_examples=10, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(ends=st.sets(st.integers(1, len(TEXT.encode()) - 1)), encoding=st.sampled_from(["utf-8", "cp1252"]))
def test_appended_in_pieces_of_any_size_a_file_gives_the_samples_of_the_whole(grown, ends, encoding):
    content, file, found = TEXT.encode(encoding), grown / "signals.csv", []
    file.write_bytes(b"")
    follower = Follower(read_manifest(grown / "run.toml")[0], grown)
    for first, last in zip([0, *sorted(ends)], [*sorted(ends), len(content)], strict=True):
        with file.open("ab") as appended:
            appended.write(content[first:last])
        found += follower.look()
    whole = read_run(grown)
    for name, values in whole.columns.items():
        joined = np.concatenate([one.columns[name] for one in found])
        np.testing.assert_allclose(joined, values, rtol=1e-12, atol=1e-15)
        assert found[-1].origins[name] == whole.origins[name]
    assert not any(one.anew for one in found)


@settings(max_examples=30)
@given(ends=st.sets(st.integers(1, 199)))
def test_samples_in_pieces_are_condensed_as_the_whole(ends):
    columns = {name: np.random.default_rng(seed).uniform(1, 2, 200) for seed, name in enumerate(("time", "depth"))}
    columns["sliding_distance"] = np.sort(columns["time"])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tribopipe.extras.live.state._MOST_SUMS", 8)
        whole, pieces = State(), State()
        whole.add(columns)
        for first, last in zip([0, *sorted(ends)], [*sorted(ends), 200], strict=True):
            pieces.add({name: values[first:last] for name, values in columns.items()})
        assert pieces.samples == whole.samples == 200
        assert len(pieces.means) == len(whole.means) == 7
        np.testing.assert_allclose(pieces.means.depth, whole.means.depth, rtol=1e-13)
        np.testing.assert_allclose(whole.means.depth[0], np.mean(columns["depth"][:32]), rtol=1e-13)


def test_several_files_of_a_test_are_read_again_as_they_grow_and_broken_ones_once_they_are_still(grown, tmp_path):
    folder = Path(shutil.copytree(grown, tmp_path / "run"))
    manifest = (folder / "run.toml").read_text(encoding="utf-8")
    (folder / "run.toml").write_text(manifest.replace('file = "signals.csv"', 'files = ["a.csv", "b.csv"]'), "utf-8")
    head = "Time [s],Depth [um],Ff [mN]\n"
    (folder / "a.csv").write_text(head + "".join(LINES[:30]), encoding="utf-8")
    (folder / "b.csv").write_text(head + "".join(LINES[30:40]), encoding="utf-8")
    follower = Follower(read_manifest(folder / "run.toml")[0], folder)
    assert [len(one.columns["depth"]) for one in follower.look()] == [40]
    assert not list(follower.look())
    (folder / "b.csv").write_text(head + "".join(LINES[30:])[:-12], encoding="utf-8")
    assert not list(follower.look())
    with pytest.raises(ReaderError, match="line 31: found 1 field, expected 3"):
        list(follower.look())
    (folder / "b.csv").write_text(head + "".join(LINES[30:]), encoding="utf-8")
    (added,) = follower.look()
    np.testing.assert_allclose(added.columns["time"], 0.1 * np.arange(40, 60))


def test_times_of_day_go_on_past_midnight_as_the_file_grows(grown, tmp_path):
    folder = Path(shutil.copytree(grown, tmp_path / "run"))
    clock = [f"{23 + minute // 60:02d}:{minute % 60:02d}:00".replace("24:", "00:") for minute in range(40, 80)]
    rows = [f"{time},{place}.5,80\n" for place, time in enumerate(clock)]
    signals = folder / "signals.csv"
    signals.write_text("Time,Depth [um],Ff [mN]\n" + "".join(rows[:25]), encoding="utf-8")
    follower = Follower(read_manifest(folder / "run.toml")[0], folder)
    found = [*follower.look()]
    with signals.open("a", encoding="utf-8") as file:
        file.writelines(rows[25:])
    found += follower.look()
    time = np.concatenate([one.columns["time"] for one in found])
    np.testing.assert_allclose(time, 60.0 * np.arange(40))


def session_of(folder: Path, **asked) -> Session:
    manifest, _ = read_manifest(folder / "run.toml")
    return Session(folder, Asked(RawRun(manifest, {}, {}, {}, {}, ()), **asked))


def test_a_file_that_is_cut_or_replaced_begins_anew_and_is_told_once(sample_run):
    signals = sample_run / "signals.csv"
    content = signals.read_bytes()
    session = session_of(sample_run)
    assert session.look().samples == 1251
    assert not session.alarmed
    signals.write_bytes(content[: len(content) // 2])
    found = session.look()
    assert [alarm.kind for alarm in found.alarms] == ["replaced"]
    assert found.samples < 700
    signals.write_bytes(b"Rig 7\n" + content)
    assert session.look().samples == 1251
    assert session.alarmed


def test_half_a_line_waits_for_its_other_half(sample_run):
    signals = sample_run / "signals.csv"
    content = signals.read_bytes()
    signals.write_bytes(content[:-3])
    session = session_of(sample_run)
    assert session.look().samples == 1250
    signals.write_bytes(content)
    assert session.look().samples == 1251
    assert not session.look().alarms


# What it tells


@pytest.mark.slow
@pytest.mark.usefixtures("few_draws")
@pytest.mark.parametrize("law", ["archard", "sarkar"])
def test_a_finished_run_has_the_joint_fit(sample_run, law):
    recipe = Recipe(wear=WearRecipe(friction="measured"))
    corrected = correct_drift(read_run(sample_run), recipe)
    fit = fit_joint(joint_problem(wear_problem(corrected, law, None, recipe), corrected, recipe))
    found = session_of(sample_run, law=law, recipe=recipe, planned=50.0).look().estimate
    assert found.finished
    spread = fit.wear_coefficient.standard_uncertainty
    assert abs(found.wear_coefficient.value - fit.wear_coefficient.value) < 0.05 * spread
    assert abs(found.drift_rate.value - fit.drift_rate.value) < 0.05 * fit.drift_rate.standard_uncertainty
    assert found.wear_coefficient.standard_uncertainty == pytest.approx(spread, rel=0.1)


@pytest.mark.parametrize("groove", [0.5, 1.0, 3.0])
def test_a_finished_run_whose_groove_was_measured_has_the_true_k_d(groove):
    run = grooved_run(groove, measured=True)
    found, _ = followed(run)
    assert found.problem.finished
    assert np.exp(found.best) == pytest.approx(PIN_K, abs=2 * np.std(found.coefficient))
    assert found.drift()[0] == pytest.approx(5e-11 * 1250, abs=1.5e-7)


def test_k_d_is_that_under_the_recorded_load():
    """Whether the nominal load is another one makes no difference."""
    run = grooved_run(0.5, measured=True)
    recorded_load = {"normal_force": np.full(len(run), LOAD)}
    stated = run.manifest.conditions.normal_load.model_copy(update={"value": 0.8 * LOAD})
    conditions = run.manifest.conditions.model_copy(update={"normal_load": stated})
    off = replace(
        run,
        manifest=run.manifest.model_copy(update={"conditions": conditions}),
        columns={**run.columns, **recorded_load},
        origins={**run.origins, "normal_force": "measured"},
    )
    found, _ = followed(off)
    assert np.exp(found.best) == pytest.approx(PIN_K, abs=2 * np.std(found.coefficient))


def test_a_finished_run_whose_ring_was_measured_has_the_true_k_d():
    found, state = followed(ring_run(measured=True))
    assert np.exp(found.best) == pytest.approx(BLOCK_K, abs=2 * np.std(found.coefficient))
    assert departure(found, ring_run().manifest, state, END) is None


@pytest.mark.slow
@pytest.mark.parametrize("groove", [0.5, 1.0, 3.0])
def test_a_drift_that_no_sensor_has_may_be_wear_of_the_disc_and_the_interval_holds_k_d_of_both(groove):
    run = grooved_run(groove)
    found, _ = followed(run)
    assert held(found.coefficient, PIN_K)
    assert abs(np.exp(found.best) - PIN_K) < 2.1 * np.std(found.coefficient)
    worn, depth = grooved_run(groove, measured=True).manifest.end_values.pin_wear_depth, found.depth(END)
    assert abs(np.mean(depth) - worn.value) < 2.1 * np.std(depth)
    (alarm,) = counterbody_alarms(found)
    assert alarm.kind == "counterbody"
    assert "the disc may be wearing" in alarm.message
    assert found.both_worn.coefficient == pytest.approx(PIN_K, rel=3 * found.both_worn.spread)


def test_wear_of_a_ring_is_named_and_leaves_k_d_of_the_block():
    found, _ = followed(ring_run())
    assert np.exp(found.best) == pytest.approx(BLOCK_K, abs=2 * np.std(found.coefficient))
    (alarm,) = counterbody_alarms(found)
    assert "the ring may be wearing" in alarm.message
    assert found.both_worn.depths(END)[1] == pytest.approx(5e-6, abs=0.5e-6)


@pytest.mark.parametrize("share", [0.1, 0.3, 1.0])
def test_of_a_disc_that_does_not_wear_nothing_is_told_and_a_stated_one_narrows_the_interval(share):
    run = grooved_run(0.0)
    unknown, _ = followed(run, share)
    stated, _ = followed(run, share, Known(disc_wear=Quantity(value=0.0, unit="m", standard_uncertainty=250e-9)))
    assert not list(counterbody_alarms(unknown))
    assert unknown.best == stated.best
    assert np.exp(stated.best) == pytest.approx(PIN_K, abs=2 * np.std(stated.coefficient))
    assert np.std(unknown.coefficient) > 1.1 * np.std(stated.coefficient)
    assert np.std(unknown.coefficient) > 0.15 * PIN_K


def altered(run: RawRun, depth: np.ndarray) -> RawRun:
    return replace(run, columns={**run.columns, "depth": depth})


@pytest.mark.parametrize("share", [0.3, 1.0])
def test_a_depth_signal_of_the_wrong_sign_is_refused_with_the_remedy(share):
    run = grooved_run(0.0)
    with pytest.raises(FitError, match=r"found a change of -\d.* µm in the depth signal.*\"invert\".*--recipe"):
        followed(altered(run, -run.columns["depth"]), share)


def test_live_with_a_wrong_sign_prints_one_sentence(run_cli, sample_run):
    manifest = sample_run / "run.toml"
    signals = sample_run / "signals.csv"
    names, *rows = signals.read_text(encoding="utf-8").splitlines()
    place = names.split(",").index(next(name for name in names.split(",") if "epth" in name))
    turned = [row.split(",") for row in rows]
    for row in turned:
        row[place] = str(-float(row[place]))
    signals.write_text("\n".join([names, *map(",".join, turned)]) + "\n", encoding="utf-8")
    text = manifest.read_text(encoding="utf-8")
    manifest.write_text(text[: text.index("[end_values]")] + text[text.index("[sensors]") :], encoding="utf-8")
    shown = run_cli("live", sample_run, "--once")
    assert "in the depth signal, which does not agree with wear" in shown.stdout
    assert "bug" not in shown.stderr


def test_without_wear_the_intervals_begin_at_zero():
    from tribopipe.extras.live.estimate import estimated

    run = made_run()
    noise = np.random.default_rng(1).standard_normal(len(run))
    flat = altered(run, 2e-6 + 5e-8 * noise - 1e-8 * np.sqrt(run.columns["time"] / run.columns["time"][-1]))
    found, _ = followed(flat)
    told = estimated(found, "archard", END)
    assert told.wear_coefficient.value == 0
    for low, high in (told.interval, told.wear_depth_interval, told.predicted_interval):
        assert low.value == 0 < high.value
    assert held(np.append(found.coefficient, 0.0), np.median(found.coefficient))
    assert told.interval[1].value == pytest.approx(np.quantile(found.coefficient, 0.95))


def test_a_drift_that_decreases_is_no_wear_of_the_disc():
    run = made_run()
    noise = 5e-8 * np.random.default_rng(1).standard_normal(len(run))
    found, _ = followed(altered(run, 2e-6 - 1.5e-6 * run.columns["time"] / run.columns["time"][-1] + noise), 0.9)
    assert found.both_worn is None
    (alarm,) = counterbody_alarms(found)
    assert alarm.kind == "drift"
    assert "k_D would be" not in alarm.message
    assert "check the sign of the depth signal, and for thermal drift" in alarm.message


def test_a_drift_beside_known_wear_of_the_ring_is_told():
    known = Known(disc_wear=Quantity(value=0.0, unit="m", standard_uncertainty=250e-9))
    found, _ = followed(ring_run(), known=known)
    (alarm,) = counterbody_alarms(found)
    assert alarm.kind == "drift"
    assert "where a sensor has 0 ± 250 nm: check the sensor, and for thermal drift" in alarm.message


def test_a_signal_that_settles_without_wear_is_refused():
    run = made_run()
    noise = 5e-8 * np.random.default_rng(1).standard_normal(len(run))
    with pytest.raises(FitError, match="which does not agree with wear"):
        followed(altered(run, 2e-6 - 5e-6 * (1 - np.exp(-run.columns["time"] / 125)) + noise), 0.9)


def test_before_the_planned_end_an_end_value_is_not_that_of_the_run_so_far(sample_run):
    signals = sample_run / "signals.csv"
    content = signals.read_bytes()
    signals.write_bytes(content[: len(content) // 2])
    stated, _ = read_manifest(sample_run / "run.toml")
    unstated = stated.model_copy(update={"end_values": EndValues()})
    begun, unmeasured = (
        Session(sample_run, Asked(RawRun(manifest, {}, {}, {}, {}, ()), planned=50.0)).look().estimate
        for manifest in (stated, unstated)
    )
    assert stated.end_values.pin_scar_diameter is not None
    assert not begun.finished
    assert begun == unmeasured


def test_with_hardly_any_noise_the_running_fit_is_the_truth_and_narrows():
    run = made_run(noise=1e-8)
    end = end_of(run)
    widths = []
    for share in (0.1, 0.3, 1.0):
        found, _ = followed(run, share)
        assert held(found.coefficient, TRUE_K.value)
        assert held(found.depth(END), float(end))
        widths.append(np.std(found.depth(END)))
    assert np.exp(found.best) == pytest.approx(TRUE_K.value, rel=3e-3)
    assert found.drift()[0] == pytest.approx(2e-10 * 1250, abs=2 * found.drift()[1])
    assert widths[0] > widths[1] > widths[2]


def test_known_drift_narrows_the_interval_and_known_k_d_more():
    run, disc = made_run(), Quantity(value=0.0, unit="m", standard_uncertainty=250e-9)
    drift = Quantity(value=0.0, unit="m/s", standard_uncertainty=2e-10)
    k = Quantity(value=13.6e-15, unit="m^2/N", standard_uncertainty=0.1e-15)
    widths = [
        np.std(np.log(followed(run, 0.1, Known(disc_wear=disc, **known))[0].coefficient))
        for known in ({}, {"drift_rate": drift}, {"drift_rate": drift, "wear_coefficient": k})
    ]
    assert widths[0] > 1.1 * widths[1]
    assert widths[1] > 1.1 * widths[2]


def test_of_a_flat_pin_nothing_is_told_unless_the_drift_is_known():
    run = made_run(shape="flat", noise=1e-9)
    with pytest.raises(FitError, match="flat pin, whose wear depth increases linearly with time, as does drift"):
        followed(run)
    known = Known(drift_rate=Quantity(value=2e-10, unit="m/s", standard_uncertainty=1e-13))
    found, _ = followed(run, known=known)
    assert held(found.coefficient, TRUE_K.value)


def test_too_few_samples_tell_nothing():
    with pytest.raises(FitError, match="too few independent samples"):
        followed(made_run(), 0.001)


# When the law stops holding


def test_squares_of_recursive_residuals_add_up_to_those_of_the_fit():
    rng = np.random.default_rng(1)
    design = np.column_stack([np.ones(30), np.arange(30.0), np.sqrt(np.arange(30.0))])
    measured = rng.standard_normal(30)
    places, residuals = recursive_residuals(design, measured)
    fitted = design @ np.linalg.lstsq(design, measured)[0]
    assert places == list(range(3, 30))
    assert np.sum(residuals**2) == pytest.approx(np.sum((measured - fitted) ** 2))


def test_wear_that_doubles_is_noticed_soon_and_sound_wear_never():
    def left(factor: float, share: float):
        run = made_run(factor=factor)
        found, state = followed(run, share)
        return departure(found, run.manifest, state, END)

    assert left(1.0, 0.5) is None
    assert left(1.0, 1.0) is None
    noticed = left(2.0, 0.6)
    assert 250 < noticed.noticed < 290
    assert 235 < noticed.since < 265
    assert noticed.deeper
    assert "has deviated from the wear law since about" in str(noticed.alarm)


def test_a_sensor_that_stands_still_is_stuck_and_one_that_is_coarse_is_not():
    along = np.arange(3000) * 0.04
    coarse, stuck = StuckSensor(), StuckSensor()
    coarse.add(np.round(np.sqrt(along), 1), along)
    assert not list(coarse.alarms())
    depth = np.random.default_rng(1).standard_normal(3000)
    depth[2000:] = depth[2000]
    for part in np.split(np.arange(3000), [300, 2100]):
        stuck.add(depth[part], along[part])
    (alarm,) = stuck.alarms()
    assert alarm.sliding_distance.value == along[2000]


def test_a_lost_load_and_a_jump_of_friction_are_told_with_their_place():
    state, along = State(), np.linspace(0.01, 100, 10000)
    columns = {"time": along, "sliding_distance": along, "depth": along}
    columns["normal_force"] = np.where(along < 60, 0.2, 0.1)
    columns["friction_coefficient"] = np.where(along < 40, 0.2, 0.5) + 0.1 * np.exp(-along / 5)
    state.add(columns)
    means = state.pooled(np.floor(state.means.sliding_distance))
    (load,), (friction,) = load_alarms(means, 0.2, 0.002), friction_alarms(means)
    assert load.sliding_distance.value == pytest.approx(60.5, abs=0.6)
    assert friction.sliding_distance.value == pytest.approx(40.5, abs=0.6)
    assert not list(friction_alarms(means[:30]))


@pytest.mark.parametrize(("factor", "spread", "told"), [(1.1, 0.01, True), (1.1, 0.05, False), (1.015, 0.0, False)])
def test_a_load_that_is_not_the_nominal_one_is_told(factor, spread, told):
    state, along = State(), np.linspace(0.01, 100, 10000)
    state.add({"time": along, "sliding_distance": along, "depth": along, "normal_force": np.full(10000, 0.2 * factor)})
    means = state.pooled(np.floor(state.means.sliding_distance))
    alarms = [*load_alarms(means, 0.2, 0.2 * spread)]
    assert [alarm.kind for alarm in alarms] == ["nominal load"] * told
    assert all("median load of 220 mN" in alarm.message and "200 mN" in alarm.message for alarm in alarms)


# What is known beforehand


@pytest.mark.parametrize("text", ["0 +- 5 nm/min", "0 ± 5 nm/min", "0 +/- 0.005 um/min"])
def test_a_drift_is_given_with_its_uncertainty(text):
    found = quantity_given("--drift", text, "drift rate")
    assert (found.value, found.standard_uncertainty) == (0.0, pytest.approx(5e-9 / 60))


@pytest.mark.parametrize("text", ["5 nm/min", "0 +- 5", "0 +- 0 nm/min", "0 +- 5 nm", "x +- 5 nm/min"])
def test_a_drift_without_uncertainty_or_unit_is_refused(text):
    with pytest.raises(UnitError, match="--drift: found"):
        quantity_given("--drift", text, "drift rate")


def test_the_next_value_is_as_uncertain_as_students_t_says():
    value, spread = _next([1.0, 2.0, 3.0, 4.0, 5.0], "x")
    assert value == 3.0
    assert spread == pytest.approx(np.sqrt(2.5 * (1 + 1 / 5) * 4 / 2))
    with pytest.raises(FitError, match="found 3 archived runs with a x"):
        _next([1.0, 2.0, 3.0], "x")


def test_archived_runs_on_the_instrument_tell_its_drift_and_too_few_of_the_bodies_no_k_d(sample_archive):
    manifest = sample_archive.manifest("si3n4-air-200mN")
    found = archived_drift(sample_archive, manifest)
    others = [run_id for run_id in sample_archive.ids() if run_id != manifest.id]
    rates = [sample_archive.result(run_id, "drift_correction", DriftCorrection).drift_rate.value for run_id in others]
    assert found.runs == tuple(others)
    assert found.quantity.value == pytest.approx(np.mean(rates))
    assert found.quantity.standard_uncertainty > np.std(rates, ddof=1)
    with pytest.raises(FitError, match="found 2 archived runs with a k_D of the same bodies"):
        archived_coefficient(sample_archive, manifest, "archard")


# The command


def test_once_as_json_is_one_line_in_si(run_cli, sample_run):
    found = run_cli("live", sample_run, "--once", "--json")
    (line,) = found.stdout.splitlines()
    told = json.loads(line)
    assert found.exit_code == 0
    assert told["id"] == "si3n4-air-400mN"
    low, high = (end["value"] for end in told["estimate"]["interval"])
    assert low < told["estimate"]["wear_coefficient"]["value"] < high
    assert told["alarms"] == []


@pytest.mark.slow
def test_alarms_make_the_exit_code_one_and_a_figure_is_kept(run_cli, sample_run, tmp_path):
    manifest = sample_run / "run.toml"
    written = manifest.read_text(encoding="utf-8").replace('value = "400 mN"', 'value = "800 mN"')
    manifest.write_text(written, encoding="utf-8")
    found = run_cli("live", sample_run, "--until-still", "0", "--every", "0.1", "--figure", tmp_path / "live.svg")
    assert found.exit_code == 1
    assert found.output.count("ALARM: found a load of 4") == 1
    assert "expected at 50 m" in found.output
    assert "fitted so far" in (tmp_path / "live.svg").read_text(encoding="utf-8")


@pytest.mark.slow
def test_a_test_that_stops_short_is_told_when_it_is_still(run_cli, sample_run):
    found = run_cli("live", sample_run, "--to", "70 m", "--until-still", "0", "--every", "0.1")
    assert found.exit_code == 1
    assert "at 50 m of 70 m): the test or its recording may have stopped" in found.stderr


def test_two_discs_are_refused_in_one_sentence(run_cli, sample_run):
    manifest = sample_run / "run.toml"
    text = manifest.read_text(encoding="utf-8").partition("[contact]")[0]
    manifest.write_text(
        text + '[contact]\nkind = "twin-disc"\n[contact.curved_disc]\nrolling_radius = "4 mm"\ncrown_radius = "4 mm"\n'
        'material = "a"\nyoungs_modulus = "300 GPa"\npoisson_ratio = 0.2\n[contact.flat_disc]\n'
        'rolling_radius = "4 mm"\n'
        'material = "a"\nyoungs_modulus = "300 GPa"\npoisson_ratio = 0.2\n[conditions]\nnormal_load = "1 N"\n'
        'slip = "4 %"\n[[signals]]\nfile = "signals.csv"\n',
        encoding="utf-8",
    )
    found = run_cli("live", sample_run, "--once")
    assert found.exit_code == 1
    assert (
        "whose wear cannot be determined from the depth signal during the test; expected a pin on a disc"
        in found.stderr
    )


def test_a_clock_that_begins_anew_ends_what_is_followed(run_cli, sample_run):
    signals = sample_run / "signals.csv"
    lines = signals.read_text(encoding="utf-8").splitlines(keepends=True)
    signals.write_text("".join(lines + lines[1:]), encoding="utf-8")
    found = run_cli("live", sample_run, "--once")
    assert found.exit_code == 1
    assert "found a time that decreases; expected a single continuous test" in found.stderr


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="Ctrl-C is sent by a console there")
def test_ctrl_c_ends_it_cleanly(sample_run):
    command = [sys.executable, "-m", "tribopipe", "live", str(sample_run), "--every", "0.1"]
    how = {"start_new_session": True, "preexec_fn": listening}
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(command, text=True, **pipes, **how) as process:
        assert process.stdout.readline().startswith("si3n4-air-400mN: 50 m")
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=30)
    assert process.returncode == 0
    assert "Traceback" not in said


@pytest.mark.slow
def test_intervals_hold_the_truth_about_as_often_as_they_say():
    held_k = held_depth = 0
    for seed in range(60):
        run = made_run(drift=2.5e-10 * (-1) ** seed, seed=seed)
        end = end_of(run)
        found, _ = followed(run, 0.25)
        held_k += held(found.coefficient, TRUE_K.value)
        held_depth += held(found.depth(END), float(end))
    assert held_k >= 53
    assert held_depth >= 53

"""Two virtual discs: their true state, what the instrument makes of it, and plans that cannot be."""

import json

import numpy as np
import pytest
from folders import SAMPLES, tree_bytes
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from tribopipe.base.errors import ContactError, ManifestError
from tribopipe.documents.manifest import read_manifest
from tribopipe.documents.plan import Fatigue, Plan, TwinDiscSeries, TwinDiscTruth, TwinDiscVirtualRun
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.record import load_toml, read_document
from tribopipe.extras.simulate import VirtualTwinDiscTest, simulate_plan
from tribopipe.physics.hertz import contact_modulus
from tribopipe.physics.twin_disc import DiscPair
from tribopipe.readers.harmonize import read_run

PLAN = load_toml(SAMPLES / "plan.toml", Plan)
SERIES = PLAN.twin_disc_series[0]
RUNS = {run.id.removeprefix("si3n4-twin-disc-"): run for run in SERIES.runs}
RUN = RUNS["4pct-250k"]
QUIET = {
    name: Quantity(value=1e-15, unit=unit)
    for name, unit in (("depth_noise", "m"), ("depth_resolution", "m"), ("friction_noise", "1"), ("load_noise", "1"))
}
ALL_MEASURED = ("wear_depth", "track_width", "wear_volume")


def virtual(run: TwinDiscVirtualRun = RUN, /, *, sensors=None, **changes) -> VirtualTwinDiscTest:
    """Simulate a run of the sample series, changed."""
    of_run = {name: changes.pop(name) for name in list(changes) if name in TwinDiscVirtualRun.model_fields}
    if sensors:
        changes["sensors"] = SERIES.sensors.model_copy(update=sensors)
    return VirtualTwinDiscTest(SERIES.model_copy(update=changes), run.model_copy(update=of_run))


def ratio(value: float, spread: float | None = None) -> Quantity:
    return Quantity(value=value, unit="1", standard_uncertainty=spread)


def pair(slip: float, distance: str = "full-slip") -> DiscPair:
    modulus = contact_modulus(pin_modulus=304e9, pin_ratio=0.24, disc_modulus=304e9, disc_ratio=0.24)
    return DiscPair(0.25, 4e-3, 4e-3, 4e-3, modulus, slip, distance)


def assert_states_agree(found, wanted, rtol=1e-12):
    for name in ("curved_depth", "flat_depth", "curved_volume", "flat_volume", "half_width"):
        np.testing.assert_allclose(getattr(found, name), getattr(wanted, name), rtol=rtol, atol=0)


# --- the truth ---


def test_discs_turn_at_their_speed_until_the_planned_rotations():
    test = virtual()
    assert test.rotations[0] == 0
    assert test.rotations[-1] == pytest.approx(RUN.rotations, rel=1e-14)
    per_second = 0.8 / (2 * np.pi * 4e-3)
    np.testing.assert_allclose(test.rotations, per_second * test.time, rtol=1e-14)
    np.testing.assert_allclose(np.diff(test.time)[:-1], 60, rtol=1e-12)
    assert 30 <= np.diff(test.time)[-1] <= 90


@pytest.mark.parametrize("rotations", [1.0, 1e3, 1909.0, 5e3, 1e6])
def test_last_sample_is_where_the_test_stops(rotations):
    test = virtual(rotations=rotations)
    assert test.rotations[-1] == pytest.approx(rotations, rel=1e-14)
    assert np.all(np.diff(test.time) > 0)
    assert len(test.time) >= 2


@pytest.mark.parametrize("convention", ["full-slip", "contact-width", "volume-conserving"])
@pytest.mark.parametrize("name", ["4pct-1000k", "10pct-1000k-a"])
def test_truth_is_the_exact_model(name, convention):
    run = RUNS[name]
    test = virtual(run, distance_per_rotation=convention)
    worn = pair(run.slip.value, convention).worn(test.rotations, 4.6e-18, 2.0e-18)
    assert_states_agree(test.state, worn)
    truth = test.truth()
    assert truth.end_curved_wear_depth.value == pytest.approx(worn.curved_depth[-1], rel=1e-12)
    assert truth.end_flat_wear_depth.value == pytest.approx(worn.flat_depth[-1], rel=1e-12)
    assert truth.end_curved_wear_volume.value == pytest.approx(worn.curved_volume[-1], rel=1e-12)
    assert truth.end_flat_wear_volume.value == pytest.approx(worn.flat_volume[-1], rel=1e-12)
    assert truth.end_track_width.value == pytest.approx(2 * worn.half_width[-1], rel=1e-12)
    assert truth.distance_per_rotation == convention


def test_sarkars_law_counts_each_rotation_by_its_friction():
    test = virtual(law="sarkar")
    slipped, friction = test.slip_per_rotation * test.rotations, RUN.friction
    fine = np.linspace(0, slipped[-1], 400_001)
    mu = friction.amplitude.value * np.exp(-fine / friction.running_in_distance.value) + friction.steady_state.value
    factor = np.sqrt(1 + 3 * mu**2)
    effective = np.concatenate([[0], np.cumsum((factor[1:] + factor[:-1]) / 2 * np.diff(fine))])
    rotations = np.interp(slipped, fine, effective) / test.slip_per_rotation
    assert_states_agree(test.state, pair(0.04).worn(rotations, 4.6e-18, 2.0e-18), rtol=1e-8)


def test_friction_acts_over_the_slip_distance():
    test = virtual(sensors=QUIET)
    columns, _ = test.record()
    mu = columns["friction_force"] / columns["normal_force"]
    distance = 2 * np.pi * 4e-3 * 0.04 * test.rotations
    friction = RUN.friction
    decay = friction.amplitude.value * np.exp(-distance / friction.running_in_distance.value)
    np.testing.assert_allclose(mu, decay + friction.steady_state.value, atol=1e-12)
    np.testing.assert_allclose(columns["normal_force"], 0.25, rtol=1e-12)


# --- fatigue ---


def test_fatigue_changes_nothing_before_it_sets_in():
    tired = virtual(fatigue=Fatigue(from_rotations=1e5, factor=3.0))
    sound = virtual()
    before = tired.rotations <= 1e5
    np.testing.assert_allclose(tired.state.curved_depth[before], sound.state.curved_depth[before], rtol=1e-13)
    assert np.all(tired.state.curved_depth[~before] > sound.state.curved_depth[~before])


def test_fatigue_is_another_k_d_from_the_worn_state_on():
    fatigue, first, second = Fatigue(from_rotations=1e5, factor=3.0), 4.6e-18, 2.0e-18
    modulus, crown, radius = float(pair(0.04).modulus), 4e-3, 4e-3

    def pressure_and_slip(h_1: float, h_2: float) -> tuple[float, float]:
        """Eq. 10, 15 and 16 of two worn discs."""
        r_1, r_2 = radius - h_1, radius - h_2
        equivalent = r_1 * r_2 / (r_1 + r_2)

        def excess(a: float) -> float:
            a_z = np.pi / 4 * np.sqrt(4 * 0.25 / (2 * a) * equivalent / (np.pi * modulus))
            return crown - np.sqrt(crown**2 - a**2) - h_1 - h_2 - 0.25 / (2 * modulus * np.sqrt(a * a_z))

        a = brentq(excess, 1e-6, 1e-3, xtol=1e-18, rtol=1e-14)
        return np.pi / 4 * np.sqrt(0.25 / (2 * a) * modulus / (np.pi * equivalent)), 2 * np.pi * (1.04 * r_2 - r_1)

    def rates(_turns, depths, factor):
        pressure, slid = pressure_and_slip(*depths)
        return factor * pressure * slid * np.array([first, second * 1.04])

    exactly = {"rtol": 1e-10, "atol": 1e-20, "method": "DOP853"}
    sound = solve_ivp(rates, (0, 1e5), [0, 0], args=(1.0,), **exactly)
    tired = solve_ivp(rates, (1e5, 2.5e5), sound.y[:, -1], args=(fatigue.factor,), **exactly)
    state = virtual(fatigue=fatigue).state
    assert (state.curved_depth[-1], state.flat_depth[-1]) == pytest.approx(tuple(tired.y[:, -1]), rel=1e-8, abs=0)


def test_fatigued_sample_run_ends_at_the_rotations_it_is_worth():
    test = virtual(RUNS["4pct-2000k"])
    worth = pair(0.04).worn(1.2e6 + 3 * 0.8e6, 4.6e-18, 2.0e-18)
    assert test.state.curved_volume[-1] == pytest.approx(worth.curved_volume, rel=1e-12)
    sound = pair(0.04).worn(2e6, 4.6e-18, 2.0e-18)
    assert test.state.curved_volume[-1] > 1.9 * sound.curved_volume


# --- what the instrument makes of it ---


def test_reading_without_noise_is_offset_drift_and_depth_over_the_scale():
    test = virtual(sensors=QUIET, depth_scale=ratio(1.02))
    columns, _ = test.record()
    worn = test.state.curved_depth + test.state.flat_depth
    wanted = RUN.zero_offset.value + RUN.drift_rate.value * test.time + worn / 1.02
    np.testing.assert_allclose(columns["depth"], wanted, atol=1e-13)
    np.testing.assert_array_equal(columns["rotations"], test.rotations)


def test_depth_is_digitised():
    step = SERIES.sensors.depth_resolution.value
    depth = virtual().record()[0]["depth"] / step
    np.testing.assert_allclose(depth, np.round(depth), atol=1e-6)


@pytest.mark.parametrize("measured", [(), ("wear_volume",), ("wear_depth", "track_width"), ALL_MEASURED])
def test_what_the_plan_says_is_measured_on_both_discs(measured):
    ends = virtual(sensors={"end_values": measured}).record()[1]
    assert set(ends) == {f"{disc}_{name}" for disc in ("curved_disc", "flat_disc") for name in measured}
    every = virtual(sensors={"end_values": ALL_MEASURED}).record()[1]
    assert ends == {name: every[name] for name in ends}


@pytest.mark.slow
def test_end_values_are_off_by_as_much_as_stated():
    errors: dict[str, list[float]] = {}
    for seed in range(200):
        test = virtual(sensors={"end_values": ALL_MEASURED}, rotations=1e4, seed=seed)
        truth, ends = test.truth(), test.record()[1]
        for disc in ("curved", "flat"):
            for name, true, spread in (
                ("wear_depth", getattr(truth, f"end_{disc}_wear_depth").value, 5e-8),
                ("track_width", truth.end_track_width.value, 4e-6),
                ("wear_volume", getattr(truth, f"end_{disc}_wear_volume").value, None),
            ):
                found = ends[f"{disc}_disc_{name}"]
                stated = 0.08 * found.value if spread is None else spread
                assert found.standard_uncertainty == pytest.approx(stated, rel=1e-12)
                assert found.value >= 0
                errors.setdefault(f"{disc} {name}", []).append((found.value - true) / (spread or 0.08 * true))
    for name, drawn in errors.items():
        if "wear_depth" in name:
            continue  # so shallow that some would have come out below zero, and are zero
        assert np.std(drawn) == pytest.approx(1, abs=4 / np.sqrt(2 * len(drawn))), name
        assert np.mean(drawn) == pytest.approx(0, abs=4 / np.sqrt(len(drawn))), name


# --- systematic errors ---


def noise_of(test: VirtualTwinDiscTest) -> dict[str, np.ndarray]:
    columns, _ = test.record()
    worn = test.state.curved_depth + test.state.flat_depth
    true = worn / test.depth_scale + test.run.drift_rate.value * test.time + test.run.zero_offset.value
    # The load cell shows the nominal load; friction acts under the true one.
    pressed = columns["normal_force"] * test.values["normal_load"] / test.load.value
    mu = columns["friction_force"] / pressed
    return {
        "depth": columns["depth"] - true,
        "friction": mu - test.friction.coefficient(test.distance),
        "load": columns["normal_force"],
    }


def test_noise_is_the_same_with_errors_and_without():
    with_errors, without = virtual(systematic_errors=True), virtual(systematic_errors=False)
    np.testing.assert_array_equal(with_errors.rotations, without.rotations)
    one, other = noise_of(with_errors), noise_of(without)
    np.testing.assert_array_equal(one["load"], other["load"])
    np.testing.assert_allclose(one["friction"], other["friction"], atol=1e-12)
    step = SERIES.sensors.depth_resolution.value
    np.testing.assert_allclose(one["depth"], other["depth"], atol=1.01 * step)
    assert np.all(with_errors.state.curved_depth[1:] != without.state.curved_depth[1:])


@pytest.mark.slow
def test_errors_are_as_large_as_stated_and_each_its_own():
    tests = [virtual(systematic_errors=True, rotations=1e3, seed=seed) for seed in range(300)]
    exact = virtual(systematic_errors=False)
    stated = {
        "normal_load": 0.01,
        "crown_radius": 0.002,
        "curved_radius": 0.001,
        "flat_radius": 0.001,
        "curved_modulus": 0.02,
        "flat_modulus": 0.02,
        "slip": 0.01,
    }
    assert set(stated) == set(exact.values)
    drawn = {
        name: np.array([test.values[name] / exact.values[name] - 1 for test in tests]) / share
        for name, share in stated.items()
    }
    drawn["depth_scale"] = np.array([test.depth_scale - 1 for test in tests]) / 0.005
    for name, errors in drawn.items():
        assert np.std(errors) == pytest.approx(1, abs=4 / np.sqrt(2 * len(errors))), name
        assert np.mean(errors) == pytest.approx(0, abs=4 / np.sqrt(len(errors))), name
    together = np.corrcoef(list(drawn.values()))
    assert np.max(np.abs(together - np.eye(len(drawn)))) < 4 / np.sqrt(len(tests))


def test_run_without_errors_is_what_its_manifest_says():
    test = virtual()
    assert test.depth_scale == 1
    assert test.values == {
        "normal_load": 0.25,
        "crown_radius": 4e-3,
        "curved_radius": 4e-3,
        "flat_radius": 4e-3,
        "curved_modulus": 304e9,
        "flat_modulus": 304e9,
        "slip": 0.04,
    }


# --- the run folder ---


@pytest.mark.parametrize("errors", [True, False])
def test_manifest_states_what_was_meant_whatever_is_off(tmp_path, errors):
    series = SERIES.model_copy(
        update={
            "systematic_errors": errors,
            "sensors": SERIES.sensors.model_copy(update={"end_values": ALL_MEASURED}),
        }
    )
    truth = VirtualTwinDiscTest(series, RUN).write(tmp_path)
    manifest, _ = read_manifest(tmp_path / "run.toml")
    assert manifest.contact == SERIES.contact
    assert manifest.conditions.normal_load == SERIES.normal_load
    assert manifest.conditions.curved_disc_speed == SERIES.curved_disc_speed
    assert manifest.conditions.slip == RUN.slip
    assert manifest.conditions.rotations == RUN.rotations
    assert manifest.sensors.depth_scale == SERIES.depth_scale
    _, ends = VirtualTwinDiscTest(series, RUN).record()
    for name, end in ends.items():
        found = getattr(manifest.end_values, name)
        assert found.value == pytest.approx(end.value, rel=1e-5)
        assert found.standard_uncertainty == pytest.approx(end.standard_uncertainty, rel=1e-5)
        assert found.method is not None
    told = TwinDiscTruth.model_validate(json.loads((tmp_path / "truth.json").read_text(encoding="utf-8")))
    assert told.curved_wear_coefficient == truth.curved_wear_coefficient
    assert told.end_track_width.value == pytest.approx(truth.end_track_width.value, rel=1e-11)
    assert told.end_flat_wear_volume.value == pytest.approx(truth.end_flat_wear_volume.value, rel=1e-11)


def test_width_of_a_disc_is_written(tmp_path):
    width = Quantity(value=2e-3, unit="m")
    curved = SERIES.contact.curved_disc.model_copy(update={"width": width})
    contact = SERIES.contact.model_copy(update={"curved_disc": curved})
    VirtualTwinDiscTest(SERIES.model_copy(update={"contact": contact}), RUN).write(tmp_path)
    assert read_manifest(tmp_path / "run.toml")[0].contact == contact


def test_run_is_read_as_it_was_recorded(tmp_path):
    VirtualTwinDiscTest(SERIES, RUN).write(tmp_path)
    run, (columns, _) = read_run(tmp_path), virtual().record()
    for name, digit in (
        ("time", 0.1),
        ("rotations", 1),
        ("depth", 1e-9),
        ("friction_force", 1e-5),
        ("normal_force", 1e-5),
    ):
        np.testing.assert_allclose(run.columns[name], columns[name], rtol=0, atol=0.51 * digit)
        assert run.origins[name] == "measured"
    assert run.columns["rotations"][-1] == RUN.rotations


def test_load_of_a_run_goes_before_that_of_its_series(tmp_path):
    own = RUN.model_copy(update={"normal_load": Quantity(value=0.3, unit="N")})
    VirtualTwinDiscTest(SERIES, own).write(tmp_path)
    assert read_manifest(tmp_path / "run.toml")[0].conditions.normal_load.value == pytest.approx(0.3)
    assert np.mean(virtual(own).record()[0]["normal_force"]) == pytest.approx(0.3, rel=1e-3)
    assert virtual(own).state.curved_volume[-1] > virtual().state.curved_volume[-1]


def test_same_plan_gives_the_same_bytes(tmp_path):
    plan = PLAN.model_copy(update={"series": ()})
    for folder in ("one", "other"):
        simulate_plan(plan, tmp_path / folder)
    one = tree_bytes(tmp_path / "one")
    assert len(one) == 3 * len(SERIES.runs)
    assert one == tree_bytes(tmp_path / "other")


def test_another_seed_gives_another_noise():
    one, other = virtual(seed=1).record(), virtual(seed=2).record()
    assert np.all(one[0]["normal_force"] != other[0]["normal_force"])
    assert one[1]["curved_disc_wear_volume"] != other[1]["curved_disc_wear_volume"]


def test_sample_runs_stay_small():
    sizes = [(SAMPLES / run.id / "signals.csv").stat().st_size for run in SERIES.runs]
    assert max(sizes) < 60_000


def test_command_tells_the_truth_of_both_discs(run_cli, tmp_path):
    text = (SAMPLES / "plan.toml").read_text(encoding="utf-8")
    head, _, rest = text.partition("[[series]]")
    plan = tmp_path / "plan.toml"
    plan.write_text(head + "[[twin_disc_series]]" + rest.partition("[[twin_disc_series]]")[2], encoding="utf-8")
    result = run_cli("simulate", tmp_path / "runs", "--plan", plan, "--json")
    assert result.exit_code == 0
    assert "Simulated runs in" in result.stderr
    assert "si3n4-twin-disc-4pct-2000k" in result.stderr
    assert "archard, fatigue" in result.stderr
    assert "true k_D, 10⁻¹² mm³/(N·mm)" in result.stderr
    assert [line.split()[-3] for line in result.stderr.splitlines() if " crowned " in line] == ["4.6"] * len(
        SERIES.runs
    )
    assert len(json.loads(result.stdout)["runs"]) == len(SERIES.runs)


# --- plans that cannot be ---


def written(series: TwinDiscSeries = SERIES) -> dict:
    """The plan of the discs as a document, to be spoiled."""
    document = series.model_dump(mode="json", exclude_none=True)
    document["runs"] = document["runs"][:2]
    return {"schema": "tribopipe.plan/1", "twin_disc_series": [document]}


def spoiled(key: str, value: object) -> dict:
    document = written()
    place = document["twin_disc_series"][0]
    *path, last = key.split(".")
    for step in path:
        place = place[int(step)] if step.isdigit() else place[step]
    if value is None:
        del place[last]
    else:
        place[last] = value
    return document


SPOILED = {
    "no slip": ("runs.0.slip", "0 %", ["twin_disc_series[0].runs[0].slip", "found zero slip", "pure rolling"]),
    "cylindrical disc stands": ("runs.1.slip", "-100 %", ["runs[1].slip", "-100 %", "stands still"]),
    "half a rotation": ("runs.0.rotations", 1.5, ["runs[0].rotations", "1.5", "whole"]),
    "rotations as a text": ("runs.0.rotations", "1e6", ["runs[0].rotations", "'1e6'", "number of rotations"]),
    "no load": ("normal_load", None, ["twin_disc_series[0]", "runs[0].normal_load", "missing", "250 mN"]),
    "late fatigue": (
        "runs.0.fatigue",
        {"from_rotations": 1e5, "factor": 2},
        ["runs[0]", "fatigue.from_rotations", "100000 in a run of 100000", "expected fewer"],
    ),
    "fatigue without wear": (
        "runs.0.fatigue",
        {"from_rotations": 10, "factor": 0},
        ["runs[0].fatigue.factor", "greater than 0"],
    ),
    "pin among discs": ("contact.kind", "pin-on-disc", ["contact.kind", "'pin-on-disc'", "twin-disc"]),
    "unknown end value": ("sensors.end_values", ["mass"], ["sensors.end_values[0]", "'mass'", "wear_volume"]),
    "unknown convention": ("distance_per_rotation", "half-slip", ["distance_per_rotation", "'half-slip'", "full-slip"]),
    "no k_D": ("runs.0.flat_wear_coefficient", None, ["runs[0].flat_wear_coefficient", "missing"]),
    "mistyped key": ("runs.0.sed", 1, ["runs[0].sed", "unknown key", "'seed'"]),
    "run twice": ("runs.0.id", RUNS["4pct-250k"].id, ["'si3n4-twin-disc-4pct-250k' twice", "rename"]),
}


@pytest.mark.parametrize("case", SPOILED)
def test_bad_plan_is_refused_in_one_sentence(case):
    key, value, words = SPOILED[case]
    with pytest.raises(ManifestError) as refused:
        read_document(spoiled(key, value), Plan, where="plan.toml")
    message = str(refused.value)
    assert message.startswith("plan.toml: ")
    assert "\n" not in message
    for word in words:
        assert word in message


def test_unspoiled_plan_is_read():
    assert len(read_document(written(), Plan, where="plan.toml").twin_disc_series[0].runs) == 2


def test_plan_of_nothing_is_refused():
    with pytest.raises(ManifestError, match=r"plan.toml: series: missing; .*\[\[twin_disc_series\]\]"):
        read_document({"schema": "tribopipe.plan/1"}, Plan, where="plan.toml")


def test_wear_beyond_the_crown_names_the_run(tmp_path):
    softer = RUN.model_copy(update={"curved_wear_coefficient": Quantity(value=1e-9, unit="m^2/N")})
    with pytest.raises(
        ContactError,
        match="4pct-250k: contact: found a wear depth of more than 4 mm, at which the crown is completely worn away",
    ):
        VirtualTwinDiscTest(SERIES, softer).write(tmp_path / "run")
    assert not (tmp_path / "run").exists()

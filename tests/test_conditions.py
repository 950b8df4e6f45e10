"""What is recorded of load and motion is held against run.toml and against itself; strokes are found and used."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from instrument_shapes import Polymer, Reciprocation, phoenix, rtec_ladder, srv, umt

from tribopipe.evaluation.checks.conditions import levels_of
from tribopipe.evaluation.checks.registry import check_run
from tribopipe.evaluation.preprocessing.cleaning import clean_run
from tribopipe.physics.identities import IDENTITIES, ratios
from tribopipe.readers.column_meanings import open_units, roles_of
from tribopipe.readers.draft.folder import Wanted, make_run
from tribopipe.readers.formats.umt import UmtReader
from tribopipe.readers.harmonize import read_run
from tribopipe.readers.reader import Hints, ReadColumn
from tribopipe.results.run import RawRun, SourceFile

TRUTH = Reciprocation()


def run_of(folder: Path, name: str, content: bytes, **conditions: str) -> RawRun:
    path = folder / name
    path.write_bytes(content)
    made = make_run(Wanted([path], folder, settings=[f"conditions.{key}={value}" for key, value in conditions.items()]))
    assert made.problem is None
    return read_run(made.folder)


def found_in(run: RawRun) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    for finding in check_run(run):
        found.setdefault(finding.code, []).append(str(finding))
    return found


# --- several levels under one nominal value ---


@pytest.mark.slow
def test_a_ladder_in_one_run_is_flagged(tmp_path):
    found = found_in(run_of(tmp_path, "log.csv", rtec_ladder(), normal_load="5 N", sliding_speed="0.1 m/s"))
    (told,) = found["conditions_change"]
    assert told.startswith(
        "Rotary.Velocity (rpm): found 119 rpm, 143 rpm, 168 rpm and 191 rpm in sequence, with the first change at "
        "sample 1801; expected one value per run, as stated in run.toml; create one run per step with"
    )


@pytest.mark.slow
def test_a_step_of_the_ladder_is_not_flagged(tmp_path):
    path = tmp_path / "log.csv"
    path.write_bytes(rtec_ladder())
    made = make_run(Wanted([path], tmp_path, settings=["conditions.normal_load=5 N"], split="Step"))
    assert "conditions_change" not in found_in(read_run(made.folder))


@pytest.mark.parametrize("ratio", [1.2, 2.0, 5.0])
@pytest.mark.parametrize("noise", [0.0, 0.01, 0.05])
def test_levels_are_found_where_they_are(ratio, noise):
    rng = np.random.default_rng(3)
    load = np.repeat([5.0, 5.0 * ratio, 5.0], [700, 900, 400]) * (1 + rng.normal(0, noise, 2000))
    levels = levels_of(load)
    assert levels is not None
    assert levels.values == pytest.approx([5, 5 * ratio, 5], rel=0.02)
    assert abs(levels.change - 700) <= 3


@given(st.integers(0, 2**32), st.floats(0, 0.3), st.integers(100, 5000))
def test_noise_and_drift_are_no_levels(seed, noise, rows):
    # Of fewer than 100 rows, one recording in 20,000 looks like two levels.
    rng = np.random.default_rng(seed)
    load = 5 * (1 + rng.normal(0, noise, rows)) * np.linspace(1, 1.15, rows)
    load[: rows // 20] *= np.linspace(0, 1, rows // 20)
    assert levels_of(np.abs(load)) is None


# --- identities ---


def test_identities_hold_for_what_they_are_true_of():
    rng = np.random.default_rng(9)
    time = np.cumsum(rng.uniform(0.5, 1.5, 200))
    turning, radius = 2 + np.sin(time / 30), 0.025
    angle = np.concatenate([[0], np.cumsum(np.diff(time) * (turning[1:] + turning[:-1]) / 2)])
    values = {
        "time": time,
        "rotational_speed": turning,
        "rotations": angle / (2 * np.pi),
        "track_radius": radius,
        "sliding_speed": radius * turning,
        "sliding_distance": radius * angle + 7,
        "mass": 6.1,
        "normal_force": np.full(200, -6.1 * 9.80665),
        "friction_force": np.sin(time) * 6.1 * 9.80665,
        "friction_coefficient": np.abs(np.sin(time)),
    }
    found = dict(ratios(values))
    assert set(found) == set(IDENTITIES)
    assert list(found.values()) == pytest.approx([1] * len(found))
    values["mass"] = 12.2
    assert {one.formula for one, ratio in ratios(values) if ratio != pytest.approx(1)} == {"m·g = F_N"}


POLYMER = Polymer(rows=300)
STATED = {"normal_load": "60 N", "track_radius": "25 mm", "rotational_speed": "191 rpm"}


def test_a_sound_recording_breaks_no_identity(tmp_path):
    found = found_in(run_of(tmp_path, "a.tsv", phoenix(POLYMER), **STATED))
    assert not found.keys() & {"channels_disagree", "conditions_differ", "conditions_change"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changed", "told"),
    [
        (
            {"track_radius": "30 mm"},
            "conditions.track_radius: found 30 mm in run.toml, but a median of 25 mm in column 'Radius'",
        ),
        (
            {"rotational_speed": "328 rpm"},
            "conditions.rotational_speed: found 328 rpm in run.toml, but a median of ",
        ),
    ],
)
def test_stated_values_are_held_against_their_channels(tmp_path, changed, told):
    found = found_in(run_of(tmp_path, "a.tsv", phoenix(POLYMER), **STATED | changed))
    assert any(one.startswith(told) for one in found["conditions_differ"])


@pytest.mark.slow
def test_a_friction_force_of_another_scale_is_flagged(tmp_path):
    run = run_of(tmp_path, "a.tsv", phoenix(POLYMER), **STATED)
    run.columns["friction_force"][:] *= 0.5
    (told,) = found_in(run)["channels_disagree"]
    assert told.startswith(
        "friction_force: found that F_f/F_N = μ does not hold for 'friction_force', 'normal_force', "
        "'friction_coefficient': the left side is 0.5 times the right side; expected both sides to agree to within 5 %"
    )


def test_units_that_a_header_leaves_open_follow_from_identities():
    rows = 100
    time = np.arange(rows) / 60  # min
    speed = 2 * np.pi * 0.025 * 191 / 60
    mu = 0.2 + 0.01 * np.sin(np.arange(rows))
    given_columns = {
        "Time": time,
        "Sliding Velocity": np.full(rows, speed),
        "Speed": np.full(rows, 191.0),
        "Radius": np.full(rows, 25.0),
        "Distance": speed * time * 60,
        "Mass": np.full(rows, 6100.0),
        "Load": np.full(rows, 59.841),
        "Friction Force": mu * 59.841,
        "Friction Coefficient": mu,
    }
    columns = [ReadColumn(name, values) for name, values in given_columns.items()]
    proposed = {role: (one.unit, one.why) for role, one in open_units(roles_of(columns)).items()}
    assert {role: unit for role, (unit, _) in proposed.items()} == {
        "time": "min",
        "sliding_speed": "m/s",
        "rotational_speed": "rpm",
        "track_radius": "mm",
        "sliding_distance": "m",
        "mass": "g",
        "normal_force": "N",
        "friction_force": "N",
        "friction_coefficient": "1",
    }
    assert proposed["normal_force"][1] == "F_f/F_N = μ, m·g = F_N"
    assert open_units(roles_of([ReadColumn("Load", np.ones(9)), ReadColumn("Time", np.arange(9.0))])) == {}


# --- there and back ---


def test_the_signed_channel_is_the_friction_force_of_a_reciprocating_test():
    table = UmtReader().read(SourceFile("a.txt", umt(TRUTH)), Hints())
    meant = {one.signal: one.name for one in table.columns if one.signal}
    assert meant["friction_force"] == "Fx"
    assert "Fx changes sign with each stroke and is the friction force; Ff is unsigned and is not used" in table.notes


@pytest.mark.slow
def test_the_middle_of_the_strokes_is_the_friction_coefficient(tmp_path):
    run = run_of(tmp_path, "a.txt", umt(TRUTH), normal_load="1.9613 N", stroke="5 mm", frequency="1 Hz")
    cleaned = clean_run(run)
    assert np.nanmean(cleaned.run.columns["friction_coefficient"]) == pytest.approx(TRUTH.friction, rel=1e-3)
    assert np.mean(run.columns["friction_coefficient"]) < 0.9 * TRUTH.friction
    found = found_in(run)
    assert not found.keys() & {"strokes_differ", "strokes_unused", "no_friction_per_stroke"}
    assert "conditions_differ" not in found


@pytest.mark.slow
def test_strokes_without_a_stated_stroke_are_flagged(tmp_path):
    found = found_in(run_of(tmp_path, "a.txt", umt(TRUTH), normal_load="1.9613 N", sliding_speed="10 mm/s"))
    (told,) = found["strokes_unused"]
    assert told.startswith(
        "friction_force: found 160 reciprocating strokes, but no stroke in run.toml, so that no friction "
        "coefficient per stroke is computed"
    )


@pytest.mark.slow
def test_a_frequency_that_the_strokes_contradict_is_flagged(tmp_path):
    found = found_in(run_of(tmp_path, "a.txt", umt(TRUTH), normal_load="1.9613 N", stroke="5 mm", frequency="0.1 Hz"))
    (told,) = found["strokes_differ"]
    assert told.startswith(
        "conditions.frequency: found 160 strokes of 0.5 s each in friction_force, that is, a frequency of 1 Hz; "
        "expected the stated 0.1 Hz"
    )


def counting(folder: Path, rows: int, per_cycle: int, pause: float = 0.0, **stated: str) -> RawRun:
    """A reciprocating test at 1 Hz for 100 s whose file counts so many times per cycle, and pauses after half of it."""
    time = np.linspace(0, 100, rows)
    friction = np.where(np.sin(2 * np.pi * time) >= 0, 0.2, -0.2)
    counted = np.floor(per_cycle * time)
    shown = time + pause * (time >= 50)
    lines = [f"{t:.4f},{n:g},{f:.3f}" for t, n, f in zip(shown, counted, friction, strict=True)]
    text = "\n".join(["time [s],Revolutions,friction force [N]", *lines])
    return run_of(folder, "log.csv", text.encode(), normal_load="1 N", stroke="5 mm", **stated)


@pytest.mark.slow
@pytest.mark.parametrize("stated", [{"frequency": "1 Hz"}, {"sliding_speed": "10 mm/s"}])
def test_a_count_of_strokes_is_no_count_of_cycles(tmp_path, stated):
    (told,) = found_in(counting(tmp_path, 200, 2, **stated))["distance_not_planned"]
    assert "found a mean speed of 0.02 m/s from time and sliding distance; expected the nominal 0.01 m/s" in told


@pytest.mark.parametrize(("counted", "told"), [(1, False), (2, True)])
def test_cycles_that_are_not_used_are_held_against_the_stated_frequency(tmp_path, counted, told):
    time = np.arange(0, 100, 0.5)
    lines = [f"{t:g},{np.floor(counted * t):g},0.3" for t in time]
    text = "\n".join(["time [s],Cycles,COF", *lines])
    found = found_in(run_of(tmp_path, "log.csv", text.encode(), normal_load="1 N", stroke="5 mm", frequency="1 Hz"))
    assert ("conditions_differ" in found) == told
    if told:
        (message,) = found["conditions_differ"]
        assert message.startswith(
            "conditions.frequency: found 1 Hz in run.toml, but 2 Hz by the counts in column 'Cycles'"
        )


def test_a_count_of_cycles_breaks_no_identity(tmp_path):
    found = found_in(counting(tmp_path, 4000, 1, frequency="1 Hz"))
    assert not found.keys() & {"distance_not_planned", "strokes_differ"}


@pytest.mark.parametrize("pause", [0.0, 30.0])
def test_counted_cycles_are_held_against_the_strokes_of_the_friction(tmp_path, pause):
    assert "strokes_differ" not in found_in(counting(tmp_path, 4000, 1, pause))


def test_counted_strokes_are_held_against_the_strokes_of_the_friction(tmp_path):
    (told,) = found_in(counting(tmp_path, 4000, 2))["strokes_differ"]
    assert told.startswith("rotations: found ")
    assert "a frequency of 1 Hz; expected 2 Hz from the recorded cycles" in told
    assert "which is to count reciprocating cycles, not strokes" in told


@pytest.mark.slow
def test_a_stroke_that_the_position_contradicts_is_flagged(tmp_path):
    found = found_in(run_of(tmp_path, "a.txt", umt(TRUTH), normal_load="1.9613 N", stroke="10 mm", frequency="1 Hz"))
    (told,) = found["strokes_differ"]
    assert told.startswith("conditions.stroke: found 10 mm in run.toml, but column 'X' changes by 4.9")


@pytest.mark.slow
def test_an_unsigned_channel_beside_a_signed_one_is_flagged(tmp_path):
    run = run_of(tmp_path, "a.txt", umt(TRUTH), normal_load="1.9613 N", stroke="5 mm", frequency="1 Hz")
    path = tmp_path / "a" / "run.toml"
    path.write_text(path.read_text(encoding="utf-8").replace('= "Fx"', '= "Ff"'), encoding="utf-8")
    run = read_run(tmp_path / "a")
    found = found_in(run)
    assert found["strokes_unused"][0].startswith(
        "friction_force: found an unsigned friction force, although the column 'Fx' changes sign with the stroke"
    )
    (told,) = found["no_friction_per_stroke"]
    assert told.startswith(
        "friction_coefficient: found no change of sign with the stroke, so that no friction coefficient per "
    )


# --- three definitions of friction ---


@pytest.mark.slow
def test_definitions_of_friction_are_named_and_none_is_taken_by_itself(tmp_path):
    path = tmp_path / "test.xlsx"
    path.write_bytes(srv())
    made = make_run(Wanted([path], tmp_path, settings=["conditions.normal_load=200 N"]))
    told = (
        "3 columns with different definitions of friction, 'Friction COF effective value' (median 0.11), 'Friction "
        "absolute integral' (median 0.11) and 'COF (peak)' (median 0.17); none is used; map the column whose values "
        "you report to friction_coefficient under [signals.columns]"
    )
    assert f"test.xlsx: {told}" in made.notes
    manifest = made.folder / "run.toml"
    text = manifest.read_text(encoding="utf-8")
    assert '# frequency = "50 Hz"' in text
    assert '# stroke = "1 mm"' in text
    for name in ("Friction COF effective value", "Friction absolute integral", "COF (peak)"):
        assert f'# friction_coefficient = "{name}"' in text
    manifest.write_text(text.replace('# friction_coefficient = "COF (peak)"', 'friction_coefficient = "COF (peak)"'))
    run = read_run(made.folder)
    assert np.median(run.columns["friction_coefficient"]) == pytest.approx(0.1705, abs=1e-3)
    taken = "'COF (peak)' is used; if you report the values of another column, map it to friction_coefficient"
    assert any(taken in note and "map the column" not in note for note in run.notes)


def test_one_definition_of_friction_needs_no_word(tmp_path):
    run = run_of(tmp_path, "a.txt", umt(TRUTH), normal_load="1.9613 N", stroke="5 mm", frequency="1 Hz")
    assert not any("definitions of friction" in note for note in run.notes)


def test_detect_proposes_units_and_names_the_steps(tmp_path, run_cli):
    rows = "".join(
        f"{t},{1 + t // 10},6100,59.841,{14.96 + t / 100:.3f},{(14.96 + t / 100) / 59.841:.6f}\n" for t in range(40)
    )
    (tmp_path / "a.csv").write_text(f"Time,Step,Mass,Load,Friction Force,COF\n{rows}")
    done = run_cli("formats", "detect", "a.csv", "--json", cwd=tmp_path)
    columns = {one["name"]: one for one in json.loads(done.stdout)["files"][0]["columns"]}
    assert {name: one["proposed_unit"] for name, one in columns.items()} == {
        "Time": None,
        "Step": None,
        "Mass": "g",
        "Load": "N",
        "Friction Force": "N",
        "COF": "1",
    }
    assert "step number" in done.stderr
    made = make_run(Wanted([tmp_path / "a.csv"], tmp_path))
    text = (made.folder / "run.toml").read_text(encoding="utf-8")
    assert '# normal_force = { column = "Load", unit = "N" }' in text
    assert "its unit is unknown; N is suggested by F_f/F_N = μ, m·g = F_N" in text

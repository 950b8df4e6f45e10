"""Four balls: the geometry by coordinates, wear by hand, torque, sinking top ball, and every command on one run."""

import json
from dataclasses import replace

import numpy as np
import pytest

from tribopipe.base.errors import ManifestError, TribopipeError
from tribopipe.documents.four_ball import FourBall
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import MonteCarloRecipe, Recipe
from tribopipe.documents.record import read_document
from tribopipe.evaluation.checks.registry import check_run
from tribopipe.evaluation.measurements.specific_wear import specific_wear
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.evaluation.wear.prediction import predict_wear, wear_scenario
from tribopipe.evaluation.wear.scenario import given_wear
from tribopipe.readers.harmonize import read_run

STEEL = {"material": "100Cr6", "youngs_modulus": "210 GPa", "poisson_ratio": 0.3}
RADIUS, LOAD = 6.35e-3, 392.0
"""m, N: ASTM D4172, condition B."""
FIRST_ORDER = Recipe(monte_carlo=MonteCarloRecipe(significant_digits=0))


def four_balls(**changes: object) -> dict:
    """Return a run.toml as a document."""
    return {
        "schema": "tribopipe.run/1",
        "id": "balls",
        "contact": {"kind": "four-ball", "ball": {"diameter": "12.7 mm", **STEEL}},
        "conditions": {"normal_load": "392 N", "rotational_speed": "1200 rpm"},
        "signals": [{"file": "balls.csv"}],
        **changes,
    }


def read(document: dict) -> RunManifest:
    return read_document(document, RunManifest, where="run.toml")


def centers() -> np.ndarray:
    """Return the centers of three balls that touch each other, and of the one that rests on them, m."""
    angles = 2 * np.pi * np.arange(3) / 3
    below = 2 * RADIUS / np.sqrt(3) * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(3)])
    height = np.sqrt((2 * RADIUS) ** 2 - np.sum(below[0] ** 2))
    return np.vstack([below, [0.0, 0.0, height]])


def test_loads_circle_and_torque_are_those_of_balls_in_space():
    balls = centers()
    normals = (balls[3] - balls[:3]) / (2 * RADIUS)
    share, *_ = np.linalg.lstsq(normals.T, np.array([0.0, 0.0, 1.0]), rcond=None)
    assert share == pytest.approx([FourBall.load_share] * 3, rel=1e-12)
    touching = (balls[3] + balls[:3]) / 2
    circle = np.hypot(touching[:, 0], touching[:, 1])
    run = read(four_balls())
    assert circle == pytest.approx([run.conditions.track_radius.value] * 3, rel=1e-12)
    # Each contact rubs with μ·F_n on the arm of the circle.
    torque = 3 * 0.1 * FourBall.load_share * LOAD * circle[0]
    assert torque / run.friction_arm / LOAD == pytest.approx(0.1, rel=1e-12)


def test_balls_approach_by_less_than_the_top_one_sinks():
    balls, sunk = centers(), 1e-9
    lowered = balls[3] - [0.0, 0.0, sunk]
    approach = 2 * RADIUS - np.linalg.norm(lowered - balls[0])
    assert approach / sunk == pytest.approx(FourBall.depth_share, rel=1e-6)


def volume_between(diameter: float) -> float:
    """Return the volume between two equal spheres within a circle, m³, up to its edge, by quadrature."""
    r = (np.arange(200_000) + 0.5) / 200_000 * diameter / 2
    gap = 2 * (RADIUS - np.sqrt(RADIUS**2 - r**2))
    edge = 2 * (RADIUS - np.sqrt(RADIUS**2 - diameter**2 / 4))
    return float(np.sum(2 * np.pi * r * (edge - gap)) * diameter / 2 / 200_000)


@pytest.fixture
def worn(tmp_path):
    """A run of an hour whose scars were measured, recorded by the torque."""
    time = np.arange(0.0, 3601.0, 10.0)
    rows = "".join(f"{t:g},{0.1 * LOAD * RADIUS / np.sqrt(2) * 1e3:.6f}\n" for t in time)
    (tmp_path / "balls.csv").write_text(f"time [s],torque [mN*m]\n{rows}".replace("mN*m", "N*mm"), encoding="utf-8")
    scars = [0.62, 0.633, 0.641, 0.615, 0.629, 0.637]
    columns = {"time": "time [s]", "friction_force": {"column": "torque [N*mm]"}}
    manifest = four_balls(
        signals=[{"file": "balls.csv", "columns": columns}],
        end_values={"ball_scar_diameter": {"values": [f"{d} mm" for d in scars], "standard_uncertainty": "5 um"}},
    )
    lines = read(manifest)
    (tmp_path / "run.toml").write_text(as_toml(manifest), encoding="utf-8")
    assert lines.end_values.pin_scar_diameter is not None
    return tmp_path


def as_toml(document: dict) -> str:
    """Write a document of tables, texts, numbers and lists; JSON's texts and lists are TOML's."""

    def inline(value: object) -> str:
        if isinstance(value, dict):
            return "{ " + ", ".join(f"{json.dumps(k)} = {inline(v)}" for k, v in value.items()) + " }"
        return json.dumps(value, ensure_ascii=False)

    lines = [f"{key} = {inline(value)}" for key, value in document.items() if key != "signals"]
    (signals,) = document["signals"]
    return "\n".join([*lines, "[[signals]]", *(f"{key} = {inline(value)}" for key, value in signals.items())]) + "\n"


def test_k_d_is_that_of_the_hand_calculation(worn):
    run = read_run(worn)
    slid = 2 * np.pi * 20 * 3600 * RADIUS / np.sqrt(3)
    assert run.sliding_distance[-1] == pytest.approx(slid, rel=1e-9)
    diameter = run.manifest.end_values.pin_scar_diameter.value
    by_hand = np.pi * diameter**4 / (32 * RADIUS) / (LOAD / np.sqrt(6) * slid)
    exact = volume_between(diameter) / (LOAD / np.sqrt(6) * slid)
    fit = fit_wear(run, "archard", recipe=FIRST_ORDER)
    assert list(fit.bodies) == ["ball"]
    # The sphere that stands for both balls has a cap that is a little larger.
    assert fit.k_d.value == pytest.approx(exact, rel=3e-3)
    assert by_hand == pytest.approx(exact, rel=2e-3)
    rate = specific_wear(run).pin.specific_wear_rate
    assert rate.value == pytest.approx(fit.k_d.value, rel=1e-9)
    assert run.columns["friction_coefficient"] == pytest.approx(0.1, rel=1e-6)
    assert any("0.408 of the applied load" in note for note in fit.notes)


def test_torque_is_named_as_what_it_was_taken_for(worn):
    assert "balls.csv: friction_force in N*mm is treated as a torque about the axis" in read_run(worn).notes


def test_force_of_an_unknown_lever_is_warned_of(worn):
    rows = (worn / "balls.csv").read_text(encoding="utf-8").replace("torque [N*mm]", "force [N]")
    (worn / "balls.csv").write_text(rows, encoding="utf-8")
    text = (worn / "run.toml").read_text(encoding="utf-8").replace("torque [N*mm]", "force [N]")
    (worn / "run.toml").write_text(text, encoding="utf-8")
    run = read_run(worn)
    assert "balls.csv: friction_force in N is treated as a force at 4.49 mm from the axis" in run.notes
    (found,) = [one for one in check_run(run) if one.code == "friction_lever"]
    assert (found.severity, found.where) == ("warning", "signals")


def as_a_force_at_a_lever(folder, source):
    """Write the friction as a force, N, at a lever of 100 mm, as run.toml has it."""
    for name, changes in {
        "balls.csv": {"torque [N*mm]": "force [N]"},
        "run.toml": {'{ "column" = "torque [N*mm]" }': f"{{ {source} }}"},
    }.items():
        text = (folder / name).read_text(encoding="utf-8")
        for old, new in changes.items():
            assert old in text
            text = text.replace(old, new)
        (folder / name).write_text(text, encoding="utf-8")


def test_force_at_a_lever_is_the_torque_that_it_makes(worn):
    torque = read_run(worn).columns["friction_force"]
    as_a_force_at_a_lever(worn, 'column = "force [N]", arm = "100 mm"')
    run = read_run(worn)
    assert run.columns["friction_force"] == pytest.approx(100 * torque, rel=1e-12)
    assert not [one for one in check_run(run) if one.code == "friction_lever"]


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ('column = "force [N]", unit = "N*mm", arm = "100 mm"', "a torque for friction_force and a lever arm"),
        (
            'column = "force [N]", arm = { value = "100 mm", standard_uncertainty = "1 mm" }',
            "arm: found a standard uncertainty",
        ),
        ('column = "force [N]", arm = "-100 mm"', "arm: found .*; expected a positive"),
        ('column = "force [N]", arm = "100 N"', "arm"),
    ],
)
def test_levers_that_are_none_are_refused(worn, source, message):
    as_a_force_at_a_lever(worn, source)
    with pytest.raises(TribopipeError, match=message):
        read_run(worn)


@pytest.mark.parametrize(("diameter", "found"), [("12.7 mm", 0), ("6.35 mm", 1), ("25.4 mm", 1), ("10 mm", 0)])
def test_radius_of_the_usual_ball_as_its_diameter_is_named(worn, diameter, found):
    document = four_balls()
    document["contact"]["ball"] = document["contact"]["ball"] | {"diameter": diameter}
    run = replace(read_run(worn), manifest=read(document))
    assert len([one for one in check_run(run) if one.code == "radius_or_diameter"]) == found


def passes(turns: int, ball: float, top: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the volumes, m³, that one ball and the top one lose where every contact of every turn is counted."""
    force, around, lost = LOAD / np.sqrt(6), 2 * np.pi * RADIUS / np.sqrt(3), np.zeros(4)
    for _ in range(turns):
        for contact in range(3):
            lost[contact] += ball * force * around
            lost[3] += top * force * around
    return lost[:3], lost[3]


def test_top_ball_wears_in_three_contacts_a_turn():
    run = read(four_balls())
    known = {"ball": Quantity(value=3e-18, unit="m^2/N"), "top_ball": Quantity(value=5e-18, unit="m^2/N")}
    scenario = wear_scenario(run, given_wear(run.described, known, Recipe()))
    turns = 1000
    (point,) = predict_wear(scenario, [turns * 2 * np.pi * RADIUS / np.sqrt(3)]).prediction
    below, above = passes(turns, 3e-18, 5e-18)
    assert point.bodies["ball"].wear_volume.value == pytest.approx(below[0], rel=1e-12)
    assert point.bodies["top_ball"].wear_volume.value == pytest.approx(above, rel=1e-12)
    # The whole groove has the section that its volume leaves on the circle.
    section = point.bodies["top_ball"].track_cross_section.value
    assert section == pytest.approx(above / (2 * np.pi * RADIUS / np.sqrt(3)), rel=1e-12)


def test_other_balls_touch_in_another_circle():
    run = read(four_balls())
    other = run.model_copy(update={"contact": run.contact.resized(Quantity(value=5e-3, unit="m"))})
    for manifest, radius in ((run, RADIUS), (other, 5e-3)):
        assert manifest.path.value == pytest.approx(2 * np.pi * radius / np.sqrt(3) / 3, rel=1e-12)


def test_k_d_of_the_top_ball_is_that_of_all_its_contacts(worn):
    run, manifest = read_run(worn), json.loads(json.dumps(four_balls()))
    lost = 2.4e-12
    manifest["end_values"] = {"top_ball_wear_volume": {"value": lost, "unit": "m^3", "standard_uncertainty": 1e-14}}
    fit = fit_wear(type(run)(read(manifest), run.columns, run.origins, {}, {}, ()), "archard", recipe=FIRST_ORDER)
    slid = float(run.sliding_distance[-1])
    assert list(fit.bodies) == ["top_ball"]
    assert fit.k_d.value == pytest.approx(lost / (3 * LOAD / np.sqrt(6) * slid), rel=1e-9)
    (volume,) = (part.value for part in fit.first.budget if part.name == "top ball wear volume")
    assert volume.value == pytest.approx(lost, rel=1e-9)  # as run.toml states it, not a third of it


PLAN = """\
schema = "tribopipe.plan/1"
[[series]]
title = "100Cr6 in base oil"
medium = "base oil"
sliding_speed = "460 mm/s"
sliding_distance = "1000 m"
sensors = { sampling_rate = "1 Hz" }
[series.contact]
kind = "four-ball"
[series.contact.ball]
diameter = { value = "12.7 mm", standard_uncertainty = "1 um" }
material = "100Cr6"
youngs_modulus = "210 GPa"
poisson_ratio = 0.3
[[series.runs]]
id = "balls-1"
started = 2026-03-01T09:30:00+01:00
seed = 3
normal_load = { value = "40 N", standard_uncertainty = "1 %" }
wear_coefficient = "3e-10 mm^3/(N*mm)"
friction = { amplitude = 0.03, steady_state = 0.08, running_in_distance = "60 m" }
zero_offset = "1.8 um"
drift_rate = "-9 nm/min"
"""
K_D = 3e-16


@pytest.fixture
def workspace(tmp_path, run_cli, few_draws):  # noqa: ARG001 - few while it is there
    """A run of four balls with the sinking of the top one, simulated."""
    (tmp_path / "plan.toml").write_text(PLAN, encoding="utf-8")
    done = run_cli("simulate", ".", "--plan", "plan.toml", cwd=tmp_path)
    assert done.exit_code == 0, done.stderr
    return tmp_path


@pytest.mark.slow
def test_k_d_follows_from_the_sinking_of_the_top_ball(workspace, run_cli):
    assert "[contact.top_ball]" in (workspace / "balls-1" / "run.toml").read_text(encoding="utf-8")
    (workspace / "recipe.toml").write_text('schema = "tribopipe.recipe/1"\n[wear]\nengine = "giwm"\n', encoding="utf-8")
    done = run_cli("process", "balls-1", "--recipe", "recipe.toml", "--json", cwd=workspace)
    assert done.exit_code == 0, done.stderr
    fit = json.loads(done.stdout)["runs"][0]["wear_fits"]["archard"]
    found = fit["bodies"]["ball"]["wear_coefficient"]
    assert fit["sensor"] is not None
    assert abs(found["value"] - K_D) < 2.5 * found["standard_uncertainty"]
    assert found["standard_uncertainty"] < 0.1 * K_D


@pytest.mark.slow
def test_every_command_takes_four_balls(workspace, run_cli):
    def tribopipe(*words: object) -> str:
        done = run_cli(*words, cwd=workspace)
        assert done.exit_code == 0, done.stderr
        assert "pin_" not in done.stderr
        return done.stdout

    tribopipe("check", "balls-1")
    tribopipe("ingest", "balls-1")
    tribopipe("correct-drift", "balls-1")
    tribopipe("fit", "balls-1", "--model", "sarkar")
    tribopipe("process", "balls-1")
    assert "ball" in tribopipe("predict", "balls-1", "--at", "400 m")
    tribopipe("predict", "balls-1", "--radius", "5 mm", "--at", "400 m")
    assert "top ball" in tribopipe("show", "balls-1")
    assert '"four-ball"' in tribopipe("ls", "--json")
    tribopipe("plan", "balls-1", "--interval", "3 %")
    tribopipe("live", "balls-1", "--once")
    tribopipe("report", "balls-1")
    tribopipe("export", "csv", "balls-1", "--output", "csv")
    tribopipe("export", "umeshmotion", "balls-1")
    tribopipe("export", "dataset", "--ro-crate", "crate.zip")
    tribopipe("verify")
    tribopipe("reproduce")


def test_what_was_read_goes_there_and_back():
    run = read(four_balls(end_values={"ball_scar_diameter": "0.6 mm", "top_ball_wear_depth": "1 um"}))
    assert run.end_values.disc_wear_depth.value == pytest.approx(1e-6)
    assert run.contact.top_ball == run.contact.ball
    stated = json.loads(run.model_dump_json(by_alias=True))
    assert "track_radius" not in stated["conditions"]
    assert {"ball_scar_diameter", "top_ball_wear_depth"} <= stated["end_values"].keys()
    assert RunManifest.model_validate(stated) == run


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"contact": {"kind": "four-ball", "ball": {"diameter": "12.7 mm", **STEEL}, "top_ball": STEEL}},
            r"contact\.top_ball\.diameter: missing",
        ),
        (
            {
                "contact": {
                    "kind": "four-ball",
                    "ball": {"diameter": "12.7 mm", **STEEL},
                    "top_ball": {"diameter": "10 mm", **STEEL},
                }
            },
            "found 10 mm, but ball.diameter is 12.7 mm; expected four balls of the same diameter",
        ),
        ({"contact": {"kind": "four-ball", "ball": STEEL}}, r"contact\.ball\.diameter: missing"),
        (
            {"contact": {"kind": "four-ball", "ball": {"diameter": 12.7, **STEEL}}},
            "found the number 12.7 without a unit",
        ),
        (
            {"conditions": {"normal_load": "392 N", "rotational_speed": "1200 rpm", "track_radius": "3.67 mm"}},
            r"conditions\.track_radius: found a track radius in addition to contact\.ball\.diameter",
        ),
        (
            {"end_values": {"ball_scar_diameter": "14 mm"}},
            "ball_scar_diameter: found 14000 µm, not less than the equivalent ball diameter of 6350 µm",
        ),
        ({"end_values": {"ball_scar_length": "6.4 mm"}}, "found 6400 µm, not less than the equivalent ball diameter"),
        ({"end_values": {"ball_wear_depth": "3.2 mm"}}, "found 3200 µm, not less than the equivalent ball radius"),
        ({"end_values": {"top_ball_wear_depth": "3.2 mm"}}, "found 3200 µm, not less than the equivalent ball radius"),
        (
            {"conditions": {"normal_load": "1600 N", "rotational_speed": "1200 rpm", "weld_load": "1569 N"}},
            r"conditions\.normal_load: found 1600 N, not less than the weld load of 1569 N",
        ),
        ({"end_values": {"ball_scar_diameter": "1 mm", "pin_scar_diameter": "1 mm"}}, "found this key in addition to"),
    ],
)
def test_what_does_not_fit_four_balls_is_refused_in_their_names(changes, words):
    with pytest.raises(ManifestError, match=words):
        read(four_balls(**changes))


def test_no_wear_is_predicted_at_the_weld_load(worn, run_cli):
    written = (worn / "run.toml").read_text(encoding="utf-8")
    limited = written.replace('"rotational_speed"', '"weld_load" = "1569 N", "rotational_speed"')
    (worn / "run.toml").write_text(limited, encoding="utf-8")
    words = ("predict", "--run", ".", "--wear-coefficient", "1e-9 mm^2/N", "--at", "500 m", "--load")
    assert run_cli(*words, "1500 N", cwd=worn).exit_code == 0
    refused = run_cli(*words, "1600 N", cwd=worn)
    assert refused.exit_code == 1
    assert "conditions.normal_load: found 1600 N, not less than the weld load of 1569 N" in refused.stderr


@pytest.mark.slow
def test_new_run_folder_has_the_names_of_the_balls(run_cli, tmp_path):
    rows = "".join(f"{60 * minute},{200 + minute % 3}\n" for minute in range(60))
    (tmp_path / "oil.csv").write_text(f"time [s],friction torque [N*mm]\n{rows}", encoding="utf-8")
    known = {f"contact.ball.{key}": value for key, value in {"diameter": "12.7 mm", **STEEL}.items()}
    known |= {"contact.kind": "four-ball", "conditions.normal_load": "392 N", "conditions.rotational_speed": "1200 rpm"}
    words = [word for key, value in known.items() for word in ("--set", f"{key}={value}")]
    done = run_cli("new", "oil.csv", *words, cwd=tmp_path)
    assert done.exit_code == 0, done.stderr
    written = (tmp_path / "oil" / "run.toml").read_text(encoding="utf-8")
    assert 'friction_force = "friction torque [N*mm]"' in written
    assert "# ball_scar_diameter = " in written
    assert "of the ball" in written
    assert "pin_" not in written
    assert "top_ball]" not in written
    assert run_cli("check", "oil", cwd=tmp_path).exit_code == 0


def test_torque_without_an_arm_is_kept_without_a_meaning(tmp_path):
    (tmp_path / "t.csv").write_text(
        "time [s],depth [um],friction torque [N*mm]\n0,1,2\n1,1,2\n2,1,2\n", encoding="utf-8"
    )
    document = {"schema": "tribopipe.run/1", "id": "t", "conditions": {"normal_load": "1 N", "sliding_speed": "1 m/s"}}
    (tmp_path / "run.toml").write_text(as_toml({**document, "signals": [{"file": "t.csv"}]}), encoding="utf-8")
    run = read_run(tmp_path)
    assert "friction_force" not in run.columns
    assert list(run.extras) == ["friction torque [N*mm]"]
    assert any("is a friction torque and is not used" in note for note in run.notes)
    assert not any("treated as a torque" in note for note in run.notes)


def test_rates_between_measurements_are_those_of_one_contact(worn):
    """Scars in between: the volume grows by k·F_n·s, and the diameter of the balls is one error for all of them."""
    slid, force = 2 * np.pi * 20 * 3600 * RADIUS / np.sqrt(3), LOAD / np.sqrt(6)
    shares = np.array([0.4, 0.6, 0.8, 1.0])
    scars = (shares * 9e-18 * force * slid * 32 * RADIUS / np.pi) ** 0.25
    stops = [
        {"sliding_distance": f"{share * slid:.6f} m", "ball_scar_diameter": f"{1e6 * scar:.3f} um"}
        for share, scar in zip(shares[:-1], scars[:-1], strict=True)
    ]
    ends = {"ball_scar_diameter": f"{1e6 * scars[-1]:.3f} um"}
    document = four_balls(interruptions=stops, end_values=ends)
    run = read_run(worn)
    found = specific_wear(type(run)(read(document), run.columns, run.origins, {}, {}, ())).pin
    rates = [one.specific_wear_rate.value for one in found.intervals]
    assert rates == pytest.approx([9e-18] * 4, rel=5e-3)
    assert found.steady_rate.value == pytest.approx(9e-18, rel=5e-3)

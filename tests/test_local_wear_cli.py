"""`tribopipe local-wear`: known depths, run folders and archived runs, and what is refused in one sentence."""

import json
import math

import numpy as np
import pytest
from folders import SAMPLES

PIN, DISCS = "si3n4-air-200mN", "si3n4-twin-disc-10pct-1000k-a"
K_D = "13.5e-9 mm^3/(N*mm)"
GIVEN = ("--wear-coefficient", K_D)
DEPTHS = {0.1: 0.32352, 1.0: 1.03758, 10.0: 3.29059, 100.0: 10.42579, 500.0: 23.37819}
"""Depth, µm, at sliding distances, m, of Si3N4 under 200 mN with that k_D."""
TABLE_3 = {1e5: 0.07280, 1e6: 0.39241, 2e6: 0.62771}
"""Depth, µm, after rotations of slip, of the discs of the paper's Table 3 with radii of 4 mm."""
ZIRCONIA = """
material = "ZrO2"
youngs_modulus = "152 GPa"
poisson_ratio = 0.32
rolling_radius = "4 mm"
"""
TABLE_3_TOML = f"""
schema = "tribopipe.run/1"
id = "table-3"
[contact]
kind = "twin-disc"
[contact.curved_disc]
crown_radius = "4 mm"
{ZIRCONIA}
[contact.flat_disc]
{ZIRCONIA}
[conditions]
normal_load = "0.3 N"
slip = "10 %"
[[signals]]
file = "signals.csv"
"""


def runs_of(result) -> list[dict]:
    assert result.exit_code == 0, result.stderr
    return json.loads(result.stdout)["runs"]


def micrometres(quantity) -> float:
    assert quantity["unit"] == "m"
    return quantity["value"] * 1e6


# --- a run folder ---


@pytest.fixture(scope="module")
def pin_points():
    """Points of the sample run by the API, with the last of them at its end."""
    from tribopipe.documents.manifest import read_manifest
    from tribopipe.documents.quantity import Quantity
    from tribopipe.evaluation.wear.local import default_places, local_scenario, wear_locally

    manifest, _ = read_manifest(SAMPLES / PIN / "run.toml")
    coefficient = Quantity(value=13.5e-15, unit="m^2/N")
    return wear_locally(local_scenario(manifest, {"pin": coefficient}), default_places(500.0)).result.points


def test_pin_folder_wears_as_deep_as_converged_steps_do(run_cli):
    places = [word for distance in DEPTHS for word in ("--at", f"{distance} m")]
    (run,) = runs_of(run_cli("local-wear", SAMPLES / PIN, *GIVEN, *places, "--json"))
    assert (run["id"], run["engine"], run["scheme"], run["reference"]) == (PIN, "rings", "implicit", None)
    for point, (distance, depth) in zip(run["points"], DEPTHS.items(), strict=True):
        assert point["sliding_distance"]["value"] == distance
        assert micrometres(point["wear_depth"]) == pytest.approx(depth, rel=1e-3)
        assert point["wear_volume"]["value"] == pytest.approx(13.5e-15 * 0.2 * distance, rel=1e-9)


def test_giwm_comes_nearer_as_the_pin_wears(pin_points):
    differences = [point.difference for point in pin_points]
    assert [point.sliding_distance.value for point in pin_points] == [0.01, 0.1, 1.0, 10.0, 100.0, 500.0]
    assert differences == sorted(differences, reverse=True)
    assert differences[0] > 0.4
    assert 0 < differences[-1] < 1e-3


def test_pressure_of_a_worn_pin_is_even(pin_points):
    first, last = pin_points[0], pin_points[-1]
    assert first.middle_pressure.value > 1.25 * first.mean_pressure.value
    assert last.mean_pressure.value == pytest.approx(0.2 / (math.pi * last.contact_radius.value**2))
    assert last.middle_pressure.value == pytest.approx(last.mean_pressure.value, rel=0.15)


def test_depths_are_as_uncertain_as_those_of_the_giwm(pin_points):
    from tribopipe.documents.manifest import read_manifest
    from tribopipe.documents.quantity import Quantity
    from tribopipe.evaluation.wear.local import local_scenario, wear_locally

    manifest, _ = read_manifest(SAMPLES / PIN / "run.toml")
    known = Quantity(value=13.5e-15, unit="m^2/N", standard_uncertainty=1.35e-15)
    scenario = local_scenario(manifest, {"pin": known})
    (point,) = wear_locally(scenario, [500.0]).result.points
    expected = scenario.uncertainties(np.array([500.0]))["wear_depth"][0]
    assert point.giwm_depth.standard_uncertainty == pytest.approx(expected)
    relative = expected / point.giwm_depth.value
    assert point.wear_depth.standard_uncertainty == pytest.approx(relative * point.wear_depth.value)
    assert relative == pytest.approx(0.05, rel=0.02)  # depth grows as the square root of k_D
    assert point.wear_volume.standard_uncertainty == pytest.approx(math.hypot(0.1, 0.01) * point.wear_volume.value)
    assert pin_points[-1].wear_depth.standard_uncertainty < point.wear_depth.standard_uncertainty / 5


def test_the_economy_needs_finite_elements(run_cli):
    refused = run_cli("local-wear", SAMPLES / PIN, *GIVEN, "--at", "1 m", "--scheme", "economy")
    assert refused.exit_code == 1
    assert "found --scheme economy for a pin; expected finite elements; add --engine fe" in refused.stderr


@pytest.mark.parametrize(
    ("shape", "disc", "of", "engines"),
    [
        ("spherical", K_D, "a pin on a counterbody that wears", "half-space"),
        ("flat", None, "a flat pin", "rings or half-space"),
    ],
)
def test_the_economy_asks_for_no_engine_that_is_then_refused(run_cli, tmp_path, shape, disc, of, engines):
    text = (SAMPLES / PIN / "run.toml").read_text(encoding="utf-8").partition("[end_values]")[0]
    text = text.replace('shape = "spherical"', f'shape = "{shape}"')
    text = text.replace("[conditions]", '[conditions]\ntrack_radius = "4 mm"')
    (tmp_path / "run.toml").write_text(text, encoding="utf-8")
    both = ("--wear-coefficient", f"pin={K_D}") + (("--wear-coefficient", f"disc={disc}") if disc else ())
    refused = run_cli("local-wear", tmp_path, *both, "--at", "1 m", "--scheme", "economy")
    assert refused.exit_code == 1
    assert f"found --scheme economy for {of}; expected finite elements, but only {engines}" in refused.stderr
    assert "omit --scheme" in refused.stderr
    assert "--engine fe" not in refused.stderr


def test_finite_elements_are_not_for_a_flat_pin(run_cli, tmp_path):
    text = (SAMPLES / PIN / "run.toml").read_text(encoding="utf-8")
    (tmp_path / "run.toml").write_text(text.replace("spherical", "flat").partition("[end_values]")[0], encoding="utf-8")
    refused = run_cli("local-wear", tmp_path, *GIVEN, "--at", "1 m", "--engine", "fe")
    assert refused.exit_code == 1
    assert "found the engine 'fe' for a flat pin; expected rings or half-space" in refused.stderr


@pytest.mark.slow
def test_the_economy_of_two_discs_ends_near_the_full_solution(run_cli, tmp_path):
    (tmp_path / "run.toml").write_text(TABLE_3_TOML, encoding="utf-8")
    told = "local-wear", tmp_path, "--wear-coefficient", "1e-10 mm^3/(N*mm)", "--at", "1e7", "--engine", "fe"
    (run,) = runs_of(run_cli(*told, "--scheme", "economy", "--update-mesh-every", "0", "--json"))
    assert (run["scheme"], run["update_mesh_every"], run["stress_loss"]) == ("economy", 0, 0.0)
    assert micrometres(run["points"][0]["wear_depth"]) == pytest.approx(TABLE_3[1e6], rel=5e-3)


@pytest.mark.slow
def test_explicit_steps_end_where_implicit_ones_do(run_cli):
    (run,) = runs_of(run_cli("local-wear", SAMPLES / PIN, *GIVEN, "--at", "1 m", "--scheme", "explicit", "--json"))
    assert micrometres(run["points"][0]["wear_depth"]) == pytest.approx(DEPTHS[1.0], rel=2e-3)


def test_explicit_steps_beyond_what_can_be_waited_for_are_refused(run_cli, monkeypatch):
    monkeypatch.setattr("tribopipe.physics.local.course._MOST_EXPLICIT_STEPS", 100)
    result = run_cli("local-wear", SAMPLES / PIN, *GIVEN, "--scheme", "explicit")
    assert result.exit_code == 1
    assert "use the implicit scheme" in result.stderr
    assert result.stderr.count("error: ") == 1


@pytest.mark.slow
def test_discs_of_table_3_wear_as_deep_as_the_issue_says(run_cli, tmp_path):
    (tmp_path / "run.toml").write_text(TABLE_3_TOML, encoding="utf-8")
    places = [word for turns in TABLE_3 for word in ("--at", f"{10 * turns:g}")]
    given = ("--wear-coefficient", "1e-10 mm^3/(N*mm)")
    (run,) = runs_of(run_cli("local-wear", tmp_path, *given, *places, "--steps-per-decade", 16, "--json"))
    assert run["engine"] == "half-space"
    for point, (turns, depth) in zip(run["points"], TABLE_3.items(), strict=True):
        assert point["slip_rotations"]["value"] == pytest.approx(turns)
        assert micrometres(point["wear_depth"]) == pytest.approx(depth, rel=5e-3)
        assert point["flat_disc_wear_depth"]["value"] == 0
        area = 1e-16 * turns * 0.3
        assert point["curved_disc_wear_volume"]["value"] == pytest.approx(2 * math.pi * 4e-3 * area, rel=1e-9)
    widths, lengths = ([point[half]["value"] for point in run["points"]] for half in ("half_width", "half_length"))
    assert widths == sorted(widths)
    assert lengths == sorted(lengths, reverse=True)


@pytest.mark.slow
def test_discs_share_wear_by_their_coefficients(run_cli):
    given = ("--wear-coefficient", "4e-9 mm^3/(N*mm)", "--wear-coefficient", "2e-9 mm^3/(N*mm)")
    (run,) = runs_of(run_cli("local-wear", SAMPLES / DISCS, *given, "--at", "1e4", "--steps-per-decade", 4, "--json"))
    (point,) = run["points"]
    assert point["curved_disc_wear_depth"]["value"] == pytest.approx(2 * point["flat_disc_wear_depth"]["value"])
    assert run["flat_disc_wear_coefficient"]["value"] == pytest.approx(2e-15)


@pytest.mark.slow
def test_sarkars_law_wears_more_than_archards(run_cli):
    ends = [
        runs_of(run_cli("local-wear", SAMPLES / PIN, *GIVEN, "--law", law, "--at", "100 m", "--json"))[0]["points"][0]
        for law in ("archard", "sarkar")
    ]
    assert ends[1]["wear_volume"]["value"] > 1.2 * ends[0]["wear_volume"]["value"]


# --- archived runs ---


@pytest.mark.slow
def test_archived_run_wears_by_its_own_k_d_over_its_own_course(run_cli, archive):
    (run,) = runs_of(run_cli("local-wear", PIN, "--archive", archive, "--json"))
    assert run["reference"] == PIN
    assert [point["sliding_distance"]["value"] for point in run["points"]] == pytest.approx(
        [0.001, 0.01, 0.1, 1, 10, 50]
    )
    again = run_cli("local-wear", "--archive", archive)
    assert "local wear unchanged, nothing to do" in again.stderr
    assert "unchanged" not in run_cli("local-wear", "--archive", archive, "--force").stderr
    assert "unchanged" not in run_cli("local-wear", "--archive", archive, "--at", "20 m").stderr


@pytest.mark.slow
def test_show_and_ls_tell_it(run_cli, archive):
    run_cli("local-wear", "--law", "sarkar", "--archive", archive)
    shown = run_cli("show", PIN, "-v", "--archive", archive).output
    assert "local_wear_sarkar" in shown
    assert "sarkar, rings, implicit: k_D = " in shown
    assert "local wear" in run_cli("ls", "--archive", archive).output
    assert "local wear by Sarkar" in run_cli("ls", "--columns", "id,steps", "--archive", archive).output
    document = json.loads(run_cli("show", PIN, "--archive", archive, "--json").stdout)
    assert document["local_wear"]["archard"] is None
    assert document["local_wear"]["sarkar"]["model"] == "sarkar"


@pytest.mark.slow
def test_figures_are_saved_where_asked(run_cli, archive, tmp_path):
    folder = tmp_path / "drawn"
    told = run_cli("local-wear", PIN, "--archive", archive, "--at", "1 m", "--figures", folder)
    assert told.exit_code == 0
    assert str(folder / f"{PIN}-local-wear.png") in told.output
    assert sorted(path.name for path in folder.iterdir()) == [f"{PIN}-local-pressure.png", f"{PIN}-local-wear.png"]


# --- what is refused ---


def said(result, exit_code=1) -> str:
    assert result.exit_code == exit_code
    assert "Traceback" not in result.output
    return result.output


def test_folder_without_k_d_says_what_to_do(run_cli):
    told = said(run_cli("local-wear", SAMPLES / PIN))
    assert '--wear-coefficient "13.5e-9 mm^3/(N*mm)"' in told


@pytest.mark.slow
def test_archived_run_without_k_d_says_what_to_do(run_cli, sample_run, tmp_path):
    run_cli("ingest", sample_run, cwd=tmp_path)
    told = said(run_cli("local-wear", cwd=tmp_path))
    assert "run `tribopipe fit --law archard" in told
    assert "--wear-coefficient" in told
    assert run_cli("local-wear", *GIVEN, cwd=tmp_path).exit_code == 0


def test_discs_have_no_rings(run_cli):
    told = said(run_cli("local-wear", SAMPLES / DISCS, *GIVEN, "--engine", "rings"))
    assert "found the engine 'rings' for two discs; expected half-space or fe" in told


def test_one_that_fails_does_not_stop_the_others(run_cli):
    told = said(run_cli("local-wear", SAMPLES / PIN, SAMPLES / DISCS, *GIVEN, "--engine", "rings"), exit_code=3)
    assert "500 m: " in told


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--at", "5"), "expected a distance"),
        (("--at", "1 m", "--wear-coefficient", K_D), "found too many values; expected one value for the pin"),
        (("--at", "0 m"), "expected one or more positive distances"),
        (("--at", "1 m", "--wear-coefficient", "1 m"), "--wear-coefficient"),
        (("--at", "1e9 m"), "more than the volume of the tip"),
    ],
)
def test_impossible_wishes_are_one_sentence(run_cli, arguments, words):
    told = said(run_cli("local-wear", SAMPLES / PIN, *GIVEN, *arguments))
    assert words in told
    assert told.count("error: ") == 1


def test_run_without_an_end_asks_for_a_place(run_cli, tmp_path):
    (tmp_path / "run.toml").write_text(TABLE_3_TOML, encoding="utf-8")
    told = said(run_cli("local-wear", tmp_path, *GIVEN))
    assert '--at "1e6"' in told

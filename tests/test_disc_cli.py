"""Twin-disc runs on the command line, as somebody new to it goes about it."""

import json
import re
import shutil
from types import SimpleNamespace

import pytest
from disc_runs import K_1, K_2, worn
from folders import DISC_IDS, DISC_PAIR, SAMPLES, tree_bytes
from test_archive import nxcheck

from tribopipe.archive.store import Archive
from tribopipe.cli.process_table import show_processed
from tribopipe.documents.record import load_toml
from tribopipe.documents.study import Study

RUN, FAST, LONG = "si3n4-twin-disc-4pct-250k", "si3n4-twin-disc-10pct-1000k-a", "si3n4-twin-disc-4pct-2000k"
SHOWN_K_1, SHOWN_K_2 = "4.6e-12 mm^3/(N*mm)", "2.0e-12 mm^3/(N*mm)"
GIVEN = ("--wear-coefficient", SHOWN_K_1, "--wear-coefficient", SHOWN_K_2)


@pytest.fixture(autouse=True)
def _draws(few_draws):
    """Few of them."""


def document_of(result) -> dict:
    assert result.exit_code == 0, result.stdout
    return json.loads(result.stdout)


@pytest.fixture(scope="module")
def _processed_discs(tmp_path_factory):
    """Three samples taken through the whole line; not to be written into."""
    from tribopipe.pipeline.stages import process

    folder = tmp_path_factory.mktemp("processed-discs") / "archive"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tribopipe.physics.uncertainty.BLOCK", 200)
        outcomes = list(process([SAMPLES / run_id for run_id in (RUN, FAST)], Archive(folder)))
    assert [one for one in outcomes if one.status == "failed"] == []
    return folder


@pytest.fixture
def home(_processed_discs, tmp_path):
    """A folder with an archive of two processed runs."""
    shutil.copytree(_processed_discs, tmp_path / "archive")
    return tmp_path


# --- from nothing to a prediction ---


@pytest.mark.slow
def test_commands_lead_from_a_folder_of_discs_to_a_prediction(run_cli, tmp_path):
    for command, words in (
        (("check", SAMPLES / RUN), ()),
        (("ingest", SAMPLES / RUN), (RUN,)),
        (("ls",), (RUN, "twin-disc", "Si3N4", "air", "250", "ingested")),
        (("correct-drift",), (RUN,)),
        (("fit", "--model", "sarkar"), ("sarkar", "crowned disc k_D = ", "cylindrical disc k_D = ")),
        (("predict", RUN, "--law", "sarkar", "--at", "1e6"), ("sarkar, exact, full-slip", " rotations")),
        (("ls", "--columns", "id,steps"), ("drift, friction, specific wear, Sarkar",)),
        (
            ("show", RUN, "-v"),
            ("wear_fit_sarkar", "uncertainty budget of k_D of the crowned disc", "wear volume of the crowned disc"),
        ),
    ):
        result = run_cli(*command, cwd=tmp_path)
        assert result.exit_code == 0, (command, result.stdout)
        said = " ".join(result.stdout.split())
        assert [word for word in words if word not in said] == [], (command, said)


def test_show_says_everything_in_json(run_cli, home):
    document = document_of(run_cli("show", RUN, "--json", cwd=home))
    assert document["manifest"]["contact"]["kind"] == "twin-disc"
    assert document["steps"] == [
        "clean_up",
        "drift_correction",
        "friction_fit",
        "specific_wear",
        "wear_fit_archard",
        "wear_fit_sarkar",
    ]
    assert document["marks"] == []


def test_show_has_the_other_ways_of_counting(run_cli, home):
    said = run_cli("show", RUN, "-v", cwd=home).stdout
    assert "k_D with other sliding-distance conventions" in said
    assert re.search(r"contact-width +│? *\S+×10⁻", said) or "contact-width" in said
    assert "volume-conserving" in said


def test_list_in_json_names_both_materials(run_cli, home):
    runs = {run["id"]: run for run in document_of(run_cli("ls", "--json", cwd=home))["runs"]}
    assert set(runs) == {RUN, FAST}
    assert runs[RUN]["tribometer"] == "twin-disc"
    assert (runs[RUN]["curved_disc_material"], runs[RUN]["flat_disc_material"]) == ("Si3N4", "Si3N4")
    assert runs[FAST]["steps"][-2:] == ["prediction_archard", "prediction_sarkar"]


def test_fit_in_json_holds_both_k_d(run_cli, home):
    (run,) = document_of(run_cli("fit", RUN, "--json", cwd=home))["runs"]
    assert run["id"] == RUN
    for disc, true in (("curved_disc", K_1), ("flat_disc", K_2)):
        found = run["bodies"][disc]["wear_coefficient"]
        assert abs(found["value"] - true) < 4 * found["standard_uncertainty"]
        assert found["unit"] == "m^2/N"


# --- predict ---


def test_predict_from_a_folder_with_two_k_d_is_the_model(run_cli, tmp_path):
    result = run_cli("predict", "--run", SAMPLES / RUN, *GIVEN, "--at", "1e5", "--at", "1e6", "--json", cwd=tmp_path)
    document = document_of(result)
    assert [point["rotations"]["value"] for point in document["prediction"]] == [1e5, 1e6]
    state = worn([1e5, 1e6])
    for place, point in enumerate(document["prediction"]):
        assert point["bodies"]["curved_disc"]["wear_volume"]["value"] == pytest.approx(
            float(state.curved_volume[place]), rel=1e-9
        )
        assert point["bodies"]["flat_disc"]["wear_depth"]["value"] == pytest.approx(
            float(state.flat_depth[place]), rel=1e-9
        )
        assert point["contact"]["half_width"]["value"] == pytest.approx(float(state.half_width[place]), rel=1e-9)
    assert list(tmp_path.iterdir()) == []


def test_predict_with_one_k_d_leaves_the_flat_disc_unworn(run_cli):
    document = document_of(
        run_cli("predict", "--run", SAMPLES / RUN, "--wear-coefficient", SHOWN_K_1, "--at", "1e6", "--json")
    )
    (point,) = document["prediction"]
    assert point["bodies"]["curved_disc"]["wear_volume"]["value"] == pytest.approx(
        float(worn(1e6, second=0.0).curved_volume)
    )
    assert point["bodies"]["flat_disc"]["wear_volume"]["value"] == 0


def test_predict_without_a_place_goes_to_the_planned_end(run_cli):
    document = document_of(run_cli("predict", "--run", SAMPLES / RUN, *GIVEN, "--json"))
    assert document["prediction"][0]["rotations"]["value"] == 250_000


@pytest.mark.slow
def test_predict_of_an_archived_run_takes_its_fit_to_its_end(run_cli, home):
    document = document_of(run_cli("predict", RUN, "--json", "--depth", "1 um", "--at", "250000", cwd=home))
    fit = document_of(run_cli("fit", RUN, "--json", cwd=home))["runs"][0]
    assert document["reference"] == RUN
    used, found = (one["bodies"]["curved_disc"]["wear_coefficient"] for one in (document, fit))
    assert used["value"] == found["value"]
    measured = {one["name"]: one["measured"]["value"] for one in fit["measurements"]}
    (point,), (reached,) = document["prediction"], document["reached"]
    assert point["bodies"]["curved_disc"]["wear_volume"]["value"] == pytest.approx(
        measured["curved_disc_wear_volume"], rel=1e-3
    )
    assert reached["bodies"]["curved_disc"]["wear_depth"]["value"] == pytest.approx(1e-6, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "bigger"),
    [
        (("--slip", "10 %"), True),
        (("--slip", "-4 %"), None),
        (("--load", "500 mN"), True),
        (("--load", "10 mN"), False),
    ],
)
def test_predict_elsewhere(run_cli, options, bigger):
    command = ["predict", "--run", SAMPLES / RUN, *GIVEN, "--at", "1e6", "--json"]
    here, there = (
        document_of(run_cli(*command, *more))["prediction"][0]["bodies"]["curved_disc"]["wear_volume"]["value"]
        for more in ((), options)
    )
    if bigger is None:
        assert there == pytest.approx(here, rel=0.05)
    else:
        assert (there > here) == bigger


def test_predict_on_another_crown(run_cli):
    command = ["predict", "--run", SAMPLES / RUN, *GIVEN, "--at", "1e6", "--json"]
    round_, sharp = (
        document_of(run_cli(*command, *more))["prediction"][0] for more in ((), ("--crown-radius", "1 mm"))
    )
    assert sharp["contact"]["half_width"]["value"] < round_["contact"]["half_width"]["value"]
    assert (
        sharp["bodies"]["curved_disc"]["wear_depth"]["value"] > round_["bodies"]["curved_disc"]["wear_depth"]["value"]
    )


@pytest.mark.slow
def test_another_speed_changes_the_time_only(run_cli):
    command = ["predict", "--run", SAMPLES / RUN, *GIVEN, "--at", "1e6", "--json"]
    one, other = (document_of(run_cli(*command, *more))["prediction"][0] for more in ((), ("--speed", "400 mm/s")))
    assert other["time"]["value"] == pytest.approx(2 * one["time"]["value"])
    assert other["bodies"]["curved_disc"]["wear_volume"] == one["bodies"]["curved_disc"]["wear_volume"]


@pytest.mark.parametrize("convention", ["contact-width", "volume-conserving"])
def test_predict_by_another_way_of_counting(run_cli, convention):
    document = document_of(
        run_cli(
            *["predict", "--run", SAMPLES / RUN, *GIVEN, "--at", "1e6", "--json"],
            *["--distance-per-rotation", convention],
        )
    )
    assert document["distance_per_rotation"] == convention
    (point,) = document["prediction"]
    assert point["bodies"]["curved_disc"]["wear_volume"]["value"] == pytest.approx(
        float(worn(1e6, convention).curved_volume), rel=1e-9
    )


def test_published_scheme_takes_its_steps(run_cli):
    document = document_of(
        run_cli(
            *["predict", "--run", SAMPLES / RUN, *GIVEN, "--at", "1e6", "--scheme", "published", "--steps", "5000"],
            "--json",
        )
    )
    assert (document["scheme"], document["steps"]) == ("published", 5000)
    assert abs(document["step_error"]) < 0.05


def test_depth_and_rotations_lead_to_each_other(run_cli):
    command = ["predict", "--run", SAMPLES / RUN, *GIVEN, "--json"]
    turns = document_of(run_cli(*command, "--depth", "2 um"))["reached"][0]["rotations"]["value"]
    (point,) = document_of(run_cli(*command, "--at", f"{turns:.17g}"))["prediction"]
    assert point["bodies"]["curved_disc"]["wear_depth"]["value"] == pytest.approx(2e-6, rel=1e-9)


def test_sarkar_takes_friction_from_the_command_line_or_the_signals(run_cli):
    command = ["predict", "--run", SAMPLES / RUN, *GIVEN, "--law", "sarkar", "--at", "250000", "--json"]
    stated = document_of(run_cli(*command, "--friction", "A=0.14 b=0.44 c=40 m"))["prediction"][0]
    fitted = document_of(run_cli(*command))["prediction"][0]
    assert fitted["bodies"]["curved_disc"]["wear_volume"]["value"] == pytest.approx(
        stated["bodies"]["curved_disc"]["wear_volume"]["value"], rel=0.01
    )
    assert stated["bodies"]["curved_disc"]["wear_volume"]["value"] > float(worn(250_000).curved_volume) * 1.2


@pytest.mark.slow
def test_predict_from_one_run_onto_another(run_cli, home):
    before = tree_bytes(home)
    result = run_cli("predict", "--from", RUN, "--onto", FAST, cwd=home)
    assert result.exit_code == 0, result.stderr
    assert "10 %" in result.stdout
    assert "Archard's law" in result.stdout
    document = document_of(run_cli("predict", "--from", RUN, "--onto", FAST, "--json", cwd=home))
    runs = json.dumps(document)
    assert RUN in runs
    assert FAST in runs
    assert tree_bytes(home) == before


@pytest.mark.slow
def test_predict_without_anything_goes_from_the_least_slip_to_the_others(run_cli, home):
    document = document_of(run_cli("predict", "--json", "--force", cwd=home))
    (run,) = document["runs"]
    assert (run["id"], run["reference"]) == (FAST, RUN)


# --- process ---


def test_the_table_names_the_convention_of_the_sliding_distance(disc_pair, capsys):
    show_processed(disc_pair, list(DISC_PAIR), [])
    counted, convention, *_ = capsys.readouterr().out.splitlines()
    assert counted.startswith("2 runs; k_D from ")
    assert convention == "k_D of twin discs: full-slip convention for the sliding distance"


def test_the_table_names_engines_where_they_differ(disc_pair, further_run, capsys):
    block = "peek-block-on-ring-50N"
    outlines = {run_id: disc_pair.outline(run_id) for run_id in DISC_PAIR} | {block: further_run(block).outline(block)}
    show_processed(SimpleNamespace(outline=outlines.__getitem__), list(outlines), [])
    rows = {line.split()[0]: line for line in capsys.readouterr().out.splitlines() if line.strip()}
    assert "volume" in rows[block].split()
    assert all("GIWM" in rows[run_id].split() for run_id in DISC_PAIR)
    show_processed(disc_pair, list(DISC_PAIR), [])
    assert "engine" not in capsys.readouterr().out


@pytest.mark.slow
def test_process_takes_all_disc_samples_through_the_line_once(run_cli, tmp_path):
    folder = tmp_path / "runs"
    for run_id in DISC_IDS[2:4]:
        shutil.copytree(SAMPLES / run_id, folder / run_id)
    command = ["process", folder, "--archive", tmp_path / "archive", "--no-figures", "--json"]
    first = document_of(run_cli(*command))
    assert {run["id"] for run in first["runs"]} == set(DISC_IDS[2:4])
    kept = tree_bytes(tmp_path / "archive")
    again = run_cli(*command)
    assert again.exit_code == 0, again.stderr
    assert tree_bytes(tmp_path / "archive") == kept
    store = Archive(tmp_path / "archive")
    for run_id in DISC_IDS[2:4]:
        warnings, errors, printed = nxcheck(store.path(run_id))
        assert (warnings, errors) == (0, 0), printed


@pytest.mark.slow
def test_processed_run_conforms_to_nexus(home):
    for run_id in (RUN, FAST):
        warnings, errors, printed = nxcheck(Archive(home / "archive").path(run_id))
        assert (warnings, errors) == (0, 0), printed


# --- studies ---


@pytest.mark.slow
def test_study_is_drafted_run_and_shown(run_cli, home):
    assert run_cli("study", "new", cwd=home).exit_code == 0
    study = load_toml(home / "study.toml", Study)
    assert (study.id, study.fit, study.predict) == ("si3n4-twin-disc-air", (RUN,), (FAST,))
    ran = run_cli("study", "run", "study.toml", "--no-figures", cwd=home)
    assert ran.exit_code == 0, ran.stderr
    assert "Archard's law" in ran.stdout
    shown = run_cli("study", "show", study.id, cwd=home)
    assert shown.exit_code == 0, shown.stderr
    for words in ("crowned disc", "cylindrical disc", RUN, FAST):
        assert words in shown.stdout
    document = document_of(run_cli("study", "show", study.id, "--json", cwd=home))
    assert '"twin-disc"' in json.dumps(document)


@pytest.mark.slow
def test_plan_tells_of_both_discs(run_cli, home):
    result = run_cli("plan", RUN, "--interval", "15 %", "--json", cwd=home)
    assert "k_D of the cylindrical disc" in json.dumps(document_of(result))
    assert "crowned disc" in result.stdout
    assert "cylindrical disc" in result.stdout


@pytest.mark.slow
def test_a_target_without_its_per_cent_sign_is_no_target_of_500_per_cent(run_cli, home):
    result = run_cli("plan", RUN, "--interval", "5", cwd=home)
    assert (result.exit_code, result.stdout) == (1, "")
    assert "--interval: found '5', which is 500 % of k_D; expected less than 100 %" in result.stderr


@pytest.mark.slow
def test_fit_drawn_another_way_is_another_fit(run_cli, home):
    recipe = home / "recipe.toml"
    recipe.write_text('schema = "tribopipe.recipe/1"\n[monte_carlo]\nsignificant_digits = 0\n', encoding="utf-8")
    (run,) = document_of(run_cli("fit", RUN, "--recipe", recipe, "--json", cwd=home))["runs"]
    assert run["bodies"]["curved_disc"]["monte_carlo"] is None


@pytest.mark.slow
def test_marked_run_is_no_reference(run_cli, home):
    assert run_cli("mark-bad", RUN, "--reason", "slipped", cwd=home).exit_code == 0
    (run,) = document_of(run_cli("predict", "--json", "--force", cwd=home))["runs"]
    assert (run["id"], run["reference"]) == (RUN, FAST)


@pytest.mark.slow
def test_figures_of_a_run_are_drawn(run_cli, tmp_path):
    result = run_cli("process", SAMPLES / RUN, "--archive", tmp_path / "archive")
    assert result.exit_code == 0, result.stderr
    assert LONG not in result.stderr

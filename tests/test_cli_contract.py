"""The command line as others rely on it: commands, flags, exit codes, and what --json puts on stdout."""

import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterator

import h5py
import numpy as np
import pytest
from folders import edit_rows, replace_in, set_key, tree_bytes

from tribopipe import __version__
from tribopipe.archive.store import Archive

pytestmark = pytest.mark.usefixtures("few_draws")

COMMON = {"--archive", "--json"}
STEP = COMMON | {"--recipe", "--force"}
MANY = {"--jobs", "--scheduler"}
FLAGS = {
    "formats list": {"--json"},
    "formats detect": {"--reader", "--sheet", "--json"},
    "new": {"--into", "--id", "--template", "--reader", "--set", "--profile", "--json"}
    | {"--sheet", "--each-sheet", "--each-row", "--split", "--accept", "--ends"},
    "check": {"--json"},
    "ingest": COMMON | MANY | {"--force", "--amend", "--shard"},
    "process": STEP
    | MANY
    | {"--amend", "--figures", "--no-figures", "--figure-format", "--format", "--shard", "--verbose"},
    "simulate": {"--plan", "--json"},
    "correct-drift": STEP | MANY,
    "fit": STEP | MANY | {"--model", "--law", "--together", "--engine", "--verbose"},
    "predict": STEP
    | {"--run", "--wear-coefficient", "--law", "--model", "--scheme", "--steps", "--friction", "--at", "--depth"}
    | {"--load", "--speed", "--radius", "--from", "--onto", "--slip", "--crown-radius", "--distance-per-rotation"}
    | {"--engine", "--verbose"},
    "local-wear": STEP
    | {"--law", "--model", "--wear-coefficient", "--engine", "--scheme", "--at", "--steps-per-decade"}
    | {"--update-mesh-every", "--stress-loss", "--figures"},
    "ls": COMMON | {"--where", "--sort", "--columns", "--all"},
    "mark-bad": COMMON | {"--reason", "--undo", "--by"},
    "tag": COMMON | {"--add", "--remove", "--by"},
    "note": COMMON | {"--by"},
    "show": COMMON | {"--path", "--rows", "--plot", "--radius", "--position-unit", "--height-unit", "--verbose"},
    "study new": {"--into", "--archive", "--force"},
    "study run": STEP | {"--figures", "--no-figures", "--verbose"},
    "study show": COMMON | {"--verbose"},
    "study figures": {"--into", "--figure-format", "--format", "--archive"},
    "sweep": COMMON
    | {"--recipe", "--force", "--out", "--reuse", "--figure", "--jobs", "--scheduler", "--shard", "--dry-run"},
    "plan": COMMON | {"--interval", "--model", "--law", "--recipe"},
    "export umeshmotion": COMMON
    | {"--law", "--model", "--wear-coefficient", "--friction", "--speed", "--until", "--element-size", "--jtyp"}
    | {"--output", "--force"},
    "export csv": COMMON | {"--what", "--output", "--force"},
    "export runs": {"--archive", "--where", "--sort", "--columns", "--output", "--decimal-comma", "--force"},
    "export dataset": COMMON | {"--ro-crate", "--eln", "--dataset", "--report", "--no-report", "--force"},
    "import": COMMON,
    "reproduce": COMMON,
    "rescue": {"--to", "--json"},
    "verify": COMMON | {"--run", "--recompute", "--against", "--accept", "--jobs"},
    "remove": COMMON | {"--study", "--force"},
    "restore": COMMON | {"--study"},
    "report": {"--output", "--details", "--standard", "--customer", "--pdf", "--run", "--archive", "--force"},
    "browse": {"--archive", "--port", "--no-browser"},
    "demo": {"--folder", "--port", "--no-browser"},
    "help": set(),
    "watch": COMMON
    | {"--template", "--runs", "--recipe", "--settle", "--together", "--poll", "--once", "--jobs"}
    | {"--figures", "--no-figures"},
    "live": {"--law", "--model", "--recipe", "--to", "--drift", "--disc-wear", "--drift-from", "--wear-from"}
    | {"--every", "--json", "--until-still", "--once", "--figure"},
    "schema export": set(),
}
K_D = "13.5e-9 mm^3/(N*mm)"


def document_of(result) -> dict:
    """The one JSON document on stdout."""
    return json.loads(result.stdout)


def objects_in(document: object) -> Iterator[dict]:
    if isinstance(document, dict):
        yield document
        document = list(document.values())
    for inner in document if isinstance(document, list) else ():
        yield from objects_in(inner)


def assert_quantity(found: object, unit: str) -> None:
    assert isinstance(found, dict)
    assert set(found) == {"value", "unit", "standard_uncertainty"}
    assert isinstance(found["value"], float)
    assert found["unit"] == unit
    assert found["standard_uncertainty"] is None or found["standard_uncertainty"] >= 0


# --- commands and flags ---


def test_commands_are_these(run_cli):
    listed = re.findall(r"(?m)^  ([a-z-]+)  ", run_cli("--help").stdout.partition("Workflow:")[2])
    assert len(listed) == len(set(listed))
    assert set(listed) == {command.partition(" ")[0] for command in FLAGS}


@pytest.mark.parametrize("command", FLAGS)
def test_flags_are_these_and_help_tells_them(run_cli, command):
    told = run_cli(*command.split(), "--help")
    assert told.exit_code == 0
    options = re.findall(r"(?m)^  (-.*?)(?:  |$)", told.stdout)
    assert {flag for option in options for flag in re.findall("--[a-z-]+", option)} == FLAGS[command] | {"--help"}


# --- exit codes ---


@pytest.mark.parametrize(
    "arguments",
    [
        "nonsense",
        "ingest",
        "process --archive a",
        "simulate runs",
        "show",
        "ls --jsn",
        "fit --model coulomb",
        "predict --steps 0",
        "predict --scheme euler",
        "predict --at 5",
        "predict some-id --run some-folder",
        "predict --run sample-run",
        "predict --from some-id",
        "predict --onto some-id",
        "predict some-id --from one --onto another",
        "study evaluate",
        "study run",
        "study figures --format gif",
        "plan some-id",
        "plan --interval 5%",
        "rescue archive/some-id.h5",
        "verify one --archive another",
        "verify --against 1234567",
        "verify --against noon0000",
        "remove",
        "restore --force some-id",
        "schema import",
    ],
)
def test_usage_errors_exit_with_2(run_cli, sample_run, arguments):
    result = run_cli(*arguments.split(), cwd=sample_run.parent)
    assert result.exit_code == 2
    assert result.stdout == ""
    assert "Usage: " in result.stderr
    assert "Traceback" not in result.stderr


def test_prediction_without_any_distance_is_a_usage_error(run_cli, sample_run):
    replace_in(sample_run / "run.toml", "(?m)^sliding_distance = .*\n", "")
    result = run_cli("predict", "--run", sample_run, "--wear-coefficient", K_D)
    assert result.exit_code == 2
    assert "--at" in result.stderr


def test_prediction_without_a_lighter_run_says_how_to_predict_one(run_cli, archive):
    told = run_cli("predict", "--archive", archive)
    assert "Nothing to predict: no comparable run" in told.stderr
    assert 'state what to predict, such as --at "500 m".' in told.stderr


def test_check_exits_with_0_on_notes_and_1_on_warnings(run_cli, sample_run):
    set_key(sample_run, "radius", '"0.794 mm"')
    noted = run_cli("check", sample_run, "--json")
    assert noted.exit_code == 0
    (run,) = document_of(noted)["runs"]
    assert run["id"] == "si3n4-air-400mN"
    assert [(finding["severity"], finding["where"]) for finding in run["findings"]] == [("note", "contact.pin.radius")]
    set_key(sample_run, "sliding_distance", '"500 m"')
    warned = run_cli("check", sample_run)
    assert warned.exit_code == 1
    assert "si3n4-air-400mN: warning: sliding_distance: found 50 m" in warned.stdout


def test_radius_that_nothing_can_be_compared_with_is_named_without_being_asked(run_cli, sample_run, archive):
    replace_in(sample_run / "run.toml", '(?m)^diameter = "1.588 mm"\n', "")
    set_key(sample_run, "radius", '"1.588 mm"')
    said = run_cli("ingest", sample_run, "--archive", archive)
    assert said.exit_code == 0
    assert "si3n4-air-400mN: note: contact.pin.radius: found a radius of 1.588 mm (a ball 3.176 mm" in said.stderr


def test_check_refuses_an_id_that_another_run_has(run_cli, sample_run, tmp_path):
    shutil.copytree(sample_run, tmp_path / "runs" / "copy")
    shutil.copytree(sample_run, tmp_path / "runs" / "first")
    result = run_cli("check", "runs", cwd=tmp_path)
    assert result.exit_code == 1
    assert "found the ID 'si3n4-air-400mN', which" in result.stderr


def test_check_tells_of_every_run_though_one_cannot_be_read(run_cli, sample_run, other_run):
    set_key(sample_run, "radius", "0.794")
    result = run_cli("check", sample_run, other_run, "--json")
    assert result.exit_code == 1
    told = {run.get("id"): run for run in document_of(result)["runs"]}
    assert told["si3n4-air-200mN"]["findings"] == []
    assert "without a unit" in told[None]["error"]
    assert told[None]["path"] == str(sample_run)


def test_folder_that_is_no_run_fails_alone(run_cli, sample_run, tmp_path):
    (tmp_path / "empty").mkdir()
    result = run_cli("ingest", tmp_path / "empty", sample_run, "--archive", tmp_path / "new", "--json")
    assert result.exit_code == 3
    assert [run["status"] for run in document_of(result)["runs"]] == ["failed", "done"]
    assert list(tree_bytes(tmp_path / "new")) == ["history.jsonl", "si3n4-air-400mN.h5"]


@pytest.mark.slow
def test_run_too_short_for_a_fit_is_archived_and_said_to_be(run_cli, sample_run, other_run, archive):
    edit_rows(sample_run, lambda lines: lines[:11])
    result = run_cli("process", sample_run, other_run, "--archive", archive)
    assert result.exit_code == 3
    (error,) = [line for line in result.stderr.splitlines() if line.startswith("error: ")]
    assert "si3n4-air-400mN: found 10 valid depth samples" in error
    assert Archive(archive).ids() == ["si3n4-air-200mN", "si3n4-air-400mN"]
    assert "k_D from Archard" in result.stdout


# --- one JSON document ---


JSON_COMMANDS = {
    "check": ["check", "sample-run"],
    "ingest": ["ingest", "sample-run"],
    "process": ["process", "sample-run", "--no-figures"],
    "simulate": ["simulate", "simulated", "--plan", "plan.toml"],
    "correct-drift": ["correct-drift"],
    "fit": ["fit"],
    "predict every run": ["predict"],
    "predict one": ["predict", "si3n4-air-200mN", "--at", "10 m"],
    "predict two": ["predict", "si3n4-air-200mN", "si3n4-air-200mN", "--at", "10 m"],
    "predict a folder": ["predict", "--run", "sample-run", "--wear-coefficient", K_D],
    "ls": ["ls"],
    "show": ["show", "si3n4-air-200mN"],
    "fit together": ["fit", "si3n4-air-200mN", "--together"],
    "predict onto": ["predict", "--from", "si3n4-air-200mN", "--onto", "si3n4-air-400mN"],
    "study run": ["study", "run", "study.toml", "--no-figures"],
    "study show": ["study", "show"],
    "study show one": ["study", "show", "alone"],
    "plan": ["plan", "si3n4-air-200mN", "--interval", "5 %"],
}
BEFORE = {
    "predict onto": ["ingest", "sample-run"],
    "study show": JSON_COMMANDS["study run"],
    "study show one": JSON_COMMANDS["study run"],
}
"""What has to be done first."""
LONG = {"predict two", "predict onto", "study show"}
"""Cases for the slow tests, each of which differs little from the one after or before it."""
STUDY = 'id = "alone"\nfit = ["si3n4-air-200mN"]\nlaws = ["archard"]\nend_of_life = "10 um"\n'


@pytest.mark.usefixtures("sample_run")
@pytest.mark.parametrize(
    "case", [pytest.param(case, marks=pytest.mark.slow if case in LONG else ()) for case in JSON_COMMANDS]
)
def test_json_is_one_document_of_quantities_with_units(run_cli, archive, short_plan, case):
    shutil.copy(short_plan, archive.parent)
    (archive.parent / "study.toml").write_text(STUDY, encoding="utf-8")
    if case in BEFORE:
        assert run_cli(*BEFORE[case], cwd=archive.parent).exit_code == 0
    result = run_cli(*JSON_COMMANDS[case], "--json", cwd=archive.parent)
    assert result.exit_code == 0
    quantities = [found for found in objects_in(document_of(result)) if isinstance(found.get("value"), float)]
    assert [
        found
        for found in quantities
        if set(found) - {"method", "readings"} != {"value", "unit", "standard_uncertainty"}
    ] == []


@pytest.mark.slow
def test_json_is_the_same_on_every_console(run_cli, sample_run, archive):
    set_key(sample_run, "title", '"Größe ≥ 3 µm"')
    run_cli("ingest", sample_run, "--archive", archive)
    for encoding in ("ascii", "cp1252", "utf-8"):
        told = subprocess.run(
            [sys.executable, "-m", "tribopipe", "show", "si3n4-air-400mN", "--json"],
            capture_output=True,
            cwd=archive.parent,
            env=os.environ | {"PYTHONIOENCODING": encoding},
            check=True,
        )
        assert json.loads(told.stdout.decode("utf-8"))["manifest"]["title"] == "Größe ≥ 3 µm"


def test_fit_tells_what_was_promised(run_cli, archive):
    result = run_cli("fit", "--model", "sarkar", "--archive", archive, "--json")
    (run,) = document_of(result)["runs"]
    assert run["id"] == "si3n4-air-200mN"
    assert run["model"] == "sarkar"
    assert_quantity(run["bodies"]["pin"]["wear_coefficient"], "m^2/N")
    assert run["bodies"]["pin"]["wear_coefficient"]["standard_uncertainty"] > 0
    assert run["friction"]["outcome"] == "exponential"
    assert_quantity(run["friction"]["amplitude"], "1")
    assert_quantity(run["friction"]["steady_state"], "1")
    assert_quantity(run["friction"]["running_in_distance"], "m")
    assert_quantity(run["drift_rate"], "m/s")
    assert_quantity(run["end_wear_depth"], "m")


@pytest.mark.slow
def test_fit_without_an_exponential_says_so(run_cli, sample_run, archive):
    run_cli("ingest", sample_run, "--archive", archive)
    result = run_cli("fit", "si3n4-air-400mN", "--archive", archive, "--json")
    friction = document_of(result)["runs"][0]["friction"]
    assert friction["outcome"] == "steady-only"
    assert friction["amplitude"] is None
    assert friction["running_in_distance"] is None
    assert_quantity(friction["steady_state"], "1")


def test_show_tells_friction_and_drift(run_cli, archive):
    shown = document_of(run_cli("show", "si3n4-air-200mN", "--archive", archive, "--json"))
    assert shown["id"] == "si3n4-air-200mN"
    assert_quantity(shown["drift_rate"], "m/s")
    assert_quantity(shown["friction"]["steady_state"], "1")
    assert shown["manifest"]["schema"] == "tribopipe.run/1"


@pytest.mark.parametrize("law", ["archard", "sarkar"])
@pytest.mark.parametrize("scheme", ["exact", "published"])
def test_predict_from_a_folder_tells_what_was_promised(run_cli, sample_run, law, scheme):
    options = ["--law", law, "--scheme", scheme, "--steps", "2000", "--friction", "A=0.226 b=0.496 c=32.877 m"]
    result = run_cli(
        *["predict", "--run", sample_run, "--wear-coefficient", "13.5e-9 mm^2/N", *options],
        *["--at", "50 m", "--at", "10 m", "--depth", "5 um", "--json"],
    )
    document = document_of(result)
    assert (document["model"], document["scheme"]) == (law, scheme)
    assert document["bodies"]["pin"]["wear_coefficient"]["value"] == 13.5e-15
    assert [point["sliding_distance"]["value"] for point in document["prediction"]] == [50.0, 10.0]
    for point in (*document["prediction"], *document["reached"]):
        assert_quantity(point["sliding_distance"], "m")
        assert_quantity(point["contact"]["approach"], "m")
    assert document["reached"][0]["contact"]["approach"]["value"] == 5e-6


def test_prediction_from_a_folder_needs_no_archive_and_leaves_none(run_cli, sample_run):
    result = run_cli("predict", "--run", sample_run, "--wear-coefficient", K_D, cwd=sample_run.parent)
    assert result.exit_code == 0
    assert [path.name for path in sample_run.parent.iterdir()] == ["sample-run"]


def test_failure_leaves_a_document_too(run_cli, sample_run, archive):
    set_key(sample_run, "radius", "0.794")
    result = run_cli("ingest", sample_run, "--archive", archive, "--json")
    assert result.exit_code == 1
    (run,) = document_of(result)["runs"]
    assert run["status"] == "failed"
    assert f"error: {run['error']}" in result.stderr


# --- doing it again ---


def science(archive) -> dict[str, tuple]:
    """Everything the files of an archive hold but when each step was done."""
    held = {}
    for path in archive.glob("*.h5"):
        with h5py.File(path) as file:
            names: list[str] = []
            file.visit(names.append)
            held |= {f"{path.name}:{name}": content_of(file[name]) for name in names if not name.endswith("/date")}
    return held


def content_of(found: h5py.Group | h5py.Dataset) -> tuple[dict[str, str], str]:
    value = repr(np.asarray(found[()]).tolist()) if isinstance(found, h5py.Dataset) else ""
    return {key: repr(np.asarray(attribute).tolist()) for key, attribute in found.attrs.items()}, value


@pytest.mark.slow
def test_second_process_does_nothing_and_says_so(run_cli, sample_run, archive):
    first = run_cli("process", sample_run, "--archive", archive, "--no-figures")
    assert "9 steps done, 0 unchanged" in first.stderr
    before = tree_bytes(archive)
    second = run_cli("process", sample_run, "--archive", archive, "--no-figures")
    assert second.exit_code == 0
    assert "Nothing to do: all 9 steps are unchanged; --force repeats them." in second.stderr
    assert tree_bytes(archive) == before


@pytest.mark.slow
def test_force_redoes_every_step_with_the_same_result(run_cli, sample_run, archive):
    run_cli("process", sample_run, "--archive", archive, "--no-figures")
    before = science(archive)
    again = run_cli("process", sample_run, "--archive", archive, "--no-figures", "--force")
    assert "9 steps done, 0 unchanged" in again.stderr
    assert science(archive) == before


@pytest.mark.slow
@pytest.mark.parametrize(
    "command", [["ingest", "sample-run"], ["correct-drift"], ["fit"], ["fit", "--model", "sarkar"]]
)
@pytest.mark.usefixtures("sample_run")
def test_command_done_twice_says_unchanged(run_cli, archive, command):
    first = run_cli(*command, cwd=archive.parent)
    before = tree_bytes(archive)
    result = run_cli(*command, cwd=archive.parent)
    assert result.exit_code == 0
    assert "unchanged, nothing to do" in result.output
    if command[0] != "ingest":
        assert result.stdout == f"{first.stdout.splitlines()[-1]}\n"
    assert tree_bytes(archive) == before


@pytest.mark.slow
def test_another_recipe_redoes_what_depends_on_it(run_cli, archive):
    (archive.parent / "recipe.toml").write_text("[friction]\nstart = '10 m'\n", encoding="utf-8")
    steps = Archive(archive).steps("si3n4-air-200mN")
    result = run_cli("fit", "--model", "sarkar", "--recipe", "recipe.toml", cwd=archive.parent)
    assert result.exit_code == 0
    changed = Archive(archive).steps("si3n4-air-200mN")
    assert changed["drift_correction"].result_sha256 == steps["drift_correction"].result_sha256
    assert changed["friction_fit"].result_sha256 != steps["friction_fit"].result_sha256
    assert changed["wear_fit_sarkar"].result_sha256 != steps["wear_fit_sarkar"].result_sha256


# --- from nothing to a prediction ---


@pytest.mark.slow
def test_commands_lead_from_an_empty_folder_to_a_prediction(run_cli, short_plan, tmp_path):
    shutil.copy(short_plan, tmp_path)
    for command, told in (
        ("simulate runs --plan plan.toml", "Simulated runs in runs"),
        ("check runs", "si3n4-air-400mN: no problems found"),
        ("ingest runs", "si3n4-air-400mN: archived"),
        ("correct-drift", "si3n4-air-400mN: drift "),
        ("fit --model sarkar", "si3n4-air-400mN: sarkar: pin k_D = "),
        ("predict --law sarkar", "si3n4-air-400mN: sarkar, exact: pin k_D = "),
        ("predict si3n4-air-200mN --law sarkar --at 100", "100"),
        ("ls --columns id,steps", "drift, friction, specific wear, Sarkar, predicted by Sarkar"),
        ("show si3n4-air-400mN -v", "prediction_sarkar"),
        ("process runs", "figures in "),
        ("schema export", "run.schema.json"),
    ):
        arguments = [f"{word} m" if word == "100" else word for word in command.split()]
        result = run_cli(*arguments, cwd=tmp_path)
        assert result.exit_code == 0, result.output
        assert told in result.output
        assert re.search("[\r\x1b]", result.output) is None, "a progress bar or colour outside a terminal"
    assert {path.name for path in tmp_path.iterdir()} == {"plan.toml", "runs", "archive", "schemas"}
    drawn = {
        f"figures/si3n4-air-{load}-{what}.png" for load in ("200mN", "400mN") for what in ("depth", "friction", "wear")
    }
    written = {"history.jsonl", "si3n4-air-200mN.h5", "si3n4-air-400mN.h5"}
    assert set(tree_bytes(tmp_path / "archive")) == written | drawn


def test_folders_of_run_folders_are_searched(run_cli, short_runs, tmp_path):
    result = run_cli("ingest", short_runs, "--archive", tmp_path / "new")
    assert result.exit_code == 0
    files = ["history.jsonl", "si3n4-air-200mN.h5", "si3n4-air-400mN.h5"]
    assert list(tree_bytes(tmp_path / "new")) == files


@pytest.mark.parametrize("command", ["ls", "ls --columns help", "show si3n4-air-200mN", "verify", "formats list"])
def test_what_a_command_found_is_on_stdout(run_cli, archive, command):
    result = run_cli(*command.split(), cwd=archive.parent)
    assert (result.exit_code, result.stderr) == (0, "")
    assert len(result.stdout.splitlines()) > 2 or command == "verify"
    assert "archive" in result.stdout or command != "verify"


def test_messages_are_on_stderr(run_cli, archive):
    result = run_cli("mark-bad", "nobody", "--reason", "slipped", cwd=archive.parent)
    assert (result.exit_code, result.stdout) == (1, "")
    assert result.stderr.startswith("error: ")


# --- as installed ---


def installed(*arguments: str, **options) -> subprocess.CompletedProcess:
    return subprocess.run(arguments, capture_output=True, text=True, encoding="utf-8", **options)


@pytest.mark.slow
def test_installed_command_tells_its_version():
    command = shutil.which("tribopipe", path=sysconfig.get_path("scripts"))
    assert command is not None, "install tribopipe into the environment of the tests"
    told = installed(command, "--version")
    assert (told.returncode, told.stdout, told.stderr) == (0, f"tribopipe {__version__}\n", "")


@pytest.mark.slow
def test_module_refuses_without_a_traceback(tmp_path):
    told = installed(sys.executable, "-m", "tribopipe", "ingest", "nowhere", cwd=tmp_path)
    assert (told.returncode, told.stdout) == (1, "")
    assert told.stderr.startswith("error: nowhere")
    assert len(told.stderr.splitlines()) == 1


@pytest.mark.slow
def test_console_without_greek_letters_shows_substitutes(archive):
    environment = os.environ | {"PYTHONIOENCODING": "ascii"}
    told = installed(
        *[sys.executable, "-m", "tribopipe", "show", "si3n4-air-200mN", "-v"], cwd=archive.parent, env=environment
    )
    assert told.returncode == 0
    assert "drift_correction" in told.stdout


def test_console_without_superscripts_still_shows_the_power_of_ten():
    import tribopipe.cli.app  # noqa: F401 - registers how errors of encoding are handled

    assert "(1.43 ± 0.03)×10⁻⁸ m²/N, μ − 1".encode("cp1252", "tribopipe-plain").decode("cp1252") == (
        "(1.43 ± 0.03)×10^-8 m²/N, u - 1"
    )

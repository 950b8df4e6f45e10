"""Studies and plans on the command line: what they say, what they keep, how they exit; bad input leaves no trace."""

import json
import re
import shutil
from pathlib import Path

import pytest
from folders import SAMPLES, tree_bytes
from study_runs import AGAIN, HEAVY, LIGHT, NO_END, fill
from sweeps import others_slow
from test_bad_input import assert_refused

from tribopipe.archive.store import Archive
from tribopipe.documents.plan import Plan
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe
from tribopipe.documents.record import load_toml
from tribopipe.documents.study import Study
from tribopipe.extras.simulate import simulate_plan
from tribopipe.pipeline.stages import ingest
from tribopipe.pipeline.studies import run_study, study_toml
from tribopipe.results.input_quantities import input_label
from tribopipe.results.study import Design, StudyResult
from tribopipe.results.wear_prediction import WearPrediction

# What is said and what is refused does not depend on how often one draws.
pytestmark = pytest.mark.usefixtures("few_draws")

CRUSHED = "si3n4-air-40N"
DOCUMENT = {"schema": "tribopipe.study/1", "id": "air", "fit": [LIGHT, AGAIN], "predict": [HEAVY], "laws": ["archard"]}
NAMES = ("wear-archard", "friction")
"""Figures of that study."""


@pytest.fixture(scope="module")
def ran(filled, tmp_path_factory) -> Path:
    """The archive with the study evaluated; not to be written into."""
    folder = Path(shutil.copytree(filled, tmp_path_factory.mktemp("ran") / "archive"))
    assert [outcome.error for outcome in run_study(Archive(folder), Study.model_validate(DOCUMENT), Recipe())] == [
        None
    ] * 2
    return folder


@pytest.fixture
def home(filled, tmp_path) -> Path:
    """A folder with an archive of runs, and the study beside it."""
    shutil.copytree(filled, tmp_path / "archive")
    write_study(tmp_path)
    return tmp_path


@pytest.fixture
def evaluated(ran, tmp_path) -> Path:
    """A folder with an archive that holds the study."""
    shutil.copytree(ran, tmp_path / "archive")
    write_study(tmp_path)
    return tmp_path


def write_study(folder: Path, name: str = "study.toml", **changes) -> Path:
    """Write the study, with keys changed."""
    document = DOCUMENT | changes
    path = folder / name
    path.write_text("".join(f"{key} = {json.dumps(value)}\n" for key, value in document.items()), encoding="utf-8")
    return path


def archived(folder: Path) -> Archive:
    return Archive(folder / "archive")


def plain(text: str) -> str:
    """Text without the padding of its tables."""
    return re.sub(r"[ ]+", " ", text)


def files(folder: Path) -> set[str]:
    return set(tree_bytes(folder))


# --- study new ---


def test_new_drafts_a_study_of_run_folders(run_cli, runs, tmp_path):
    result = run_cli("study", "new", runs / HEAVY, runs / AGAIN, runs / LIGHT, cwd=tmp_path)
    assert result.exit_code == 0
    (line,) = result.stdout.splitlines()
    assert line.startswith("study.toml: fitted: ")
    assert line.endswith(f"; predicted: {HEAVY}")
    study = load_toml(tmp_path / "study.toml", Study)
    assert (study.id, study.title) == ("si3n4-air", "Si3N4 on Si3N4 in air")
    assert (set(study.fit), study.predict) == ({LIGHT, AGAIN}, (HEAVY,))


@pytest.mark.slow
def test_new_drafts_a_study_for_each_set_of_bodies(run_cli, tmp_path):
    result = run_cli("study", "new", SAMPLES, "--into", tmp_path / "drafts")
    assert result.exit_code == 0
    assert files(tmp_path / "drafts") == {
        "si3n4-air.study.toml",
        "si3n4-twin-disc-air.study.toml",
        "wc-co-water.study.toml",
    }
    for path in (tmp_path / "drafts").iterdir():
        assert str(path) in result.stdout
        draft = load_toml(path, Study)
        if path.name == "si3n4-twin-disc-air.study.toml":
            assert draft.title == "Si3N4 on Si3N4 in air"
            assert {one.partition("pct")[0] for one in draft.fit} == {"si3n4-twin-disc-4"}
            assert {one.partition("pct")[0] for one in draft.predict} == {"si3n4-twin-disc-10"}
            continue
        given = load_toml(SAMPLES / path.name, Study)
        assert draft == given.model_copy(update={"end_of_life": None})


def test_new_takes_the_runs_of_the_archive_but_for_bad_ones(run_cli, home):
    (home / "study.toml").unlink()
    run_cli("mark-bad", AGAIN, "--reason", "slipped", cwd=home)
    result = run_cli("study", "new", cwd=home)
    assert result.exit_code == 0, result.stderr
    study = load_toml(home / "study.toml", Study)
    assert (study.fit, study.predict) == ((LIGHT,), (HEAVY,))
    assert f"{AGAIN}: excluded: marked bad: slipped" in result.stderr
    assert f"{NO_END}: excluded: missing: a post-test measurement of the pin" in result.stderr


def test_new_leaves_out_an_aborted_run_and_one_that_cannot_be_read(run_cli, runs, tmp_path):
    for run_id in (LIGHT, HEAVY, AGAIN):
        shutil.copytree(runs / run_id, tmp_path / run_id)
    table = (tmp_path / AGAIN / "signals.csv").read_text(encoding="utf-8").splitlines(keepends=True)
    (tmp_path / AGAIN / "signals.csv").write_text("".join(table[: len(table) // 2]), encoding="utf-8")
    shutil.copytree(tmp_path / HEAVY, tmp_path / "lost")
    described = (tmp_path / "lost" / "run.toml").read_text(encoding="utf-8").replace(f'"{HEAVY}"', '"lost"')
    (tmp_path / "lost" / "run.toml").write_text(described, encoding="utf-8")
    (tmp_path / "lost" / "signals.csv").unlink()
    result = run_cli("study", "new", tmp_path, "--into", tmp_path)
    assert result.exit_code == 0, result.stderr
    assert f"{AGAIN}: excluded: aborted: 49.96 m of the planned 100 m" in result.stderr
    assert "lost: excluded: " in result.stderr
    study = load_toml(tmp_path / "study.toml", Study)
    assert (study.fit, study.predict) == ((LIGHT,), (HEAVY,))


def test_new_drafts_no_law_that_needs_friction_where_a_run_has_none(run_cli, runs, tmp_path):
    for run_id in (LIGHT, HEAVY):
        shutil.copytree(runs / run_id, tmp_path / run_id)
    path = tmp_path / HEAVY / "run.toml"
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    path.write_text("".join(line for line in lines if not line.startswith("friction_force")), encoding="utf-8")
    assert run_cli("study", "new", tmp_path, "--into", tmp_path).exit_code == 0
    assert load_toml(tmp_path / "study.toml", Study).laws == ("archard",)


@pytest.mark.slow
def test_new_refuses_to_overwrite_unless_forced(run_cli, runs, tmp_path):
    path = tmp_path / "study.toml"
    path.write_bytes(b"# mine\n")
    command = ["study", "new", runs / LIGHT, runs / HEAVY, "--into", tmp_path]
    assert_refused(run_cli(*command), str(path), "found an existing file", "--force")
    assert path.read_bytes() == b"# mine\n"
    assert run_cli(*command, "--force").exit_code == 0
    assert load_toml(path, Study).predict == (HEAVY,)


@pytest.mark.slow
def test_new_writes_all_drafts_or_none(run_cli, tmp_path):
    taken = tmp_path / "wc-co-water.study.toml"
    taken.write_bytes(b"# mine\n")
    assert_refused(
        run_cli("study", "new", SAMPLES, "--into", tmp_path), taken.name, "found an existing file", "--force"
    )
    assert tree_bytes(tmp_path) == {taken.name: b"# mine\n"}


@pytest.mark.slow
def test_draft_runs_as_it_is(run_cli, runs, tmp_path):
    for run_id in (LIGHT, HEAVY):
        ingest(runs / run_id, Archive(tmp_path / "archive"))
    assert run_cli("study", "new", cwd=tmp_path).exit_code == 0
    result = run_cli("study", "run", "study.toml", "--no-figures", cwd=tmp_path)
    assert result.exit_code == 0, result.stderr
    assert archived(tmp_path).study_ids() == ["si3n4-air"]


# --- study run ---


@pytest.mark.slow
def test_run_says_k_d_verdicts_and_figures(run_cli, home):
    result = run_cli("study", "run", "study.toml", "-v", cwd=home)
    assert result.exit_code == 0
    law = archived(home).study("air").result.law("archard")
    assert "air, Archard's law: pin k_D = (1." in result.stdout
    for verdict in law.runs:
        assert f"{verdict.id}: {verdict.sentence}" in result.output
        assert f" {verdict.id} {verdict.role} " in f" {plain(result.output)}"
    assert re.search(r"between-run scatter of k_D of the pin \(2 runs\): \d+\.\d %; within a run: ", result.output)
    assert f"figures in {Path('archive') / 'figures'}" in result.output
    drawn = {f"air-{name}.{suffix}" for name in NAMES for suffix in ("svg", "png")}
    assert files(home / "archive" / "figures") == drawn
    assert re.search("[\r\x1b]", result.output) is None


@pytest.mark.slow
def test_run_as_json_is_the_result_as_archived(run_cli, home):
    result = run_cli("study", "run", "study.toml", "--no-figures", "--json", cwd=home)
    assert result.exit_code == 0
    assert StudyResult.model_validate(json.loads(result.stdout)) == archived(home).study("air").result
    assert not (home / "archive" / "figures").exists()


@pytest.mark.slow
def test_run_puts_its_predictions_into_the_runs(run_cli, home):
    run_cli("study", "run", "study.toml", "--no-figures", cwd=home)
    shown = json.loads(run_cli("show", HEAVY, "--json", cwd=home).stdout)
    predicted = shown["predictions"]["archard"]
    assert predicted["reference"] == "study air"
    (law,) = json.loads(run_cli("study", "show", "air", "--json", cwd=home).stdout)["laws"]
    assert predicted["bodies"]["pin"]["wear_coefficient"] == law["bodies"]["pin"]["wear_coefficient"]


@pytest.mark.slow
def test_second_run_says_unchanged_and_writes_nothing(run_cli, evaluated):
    before = tree_bytes(evaluated)
    result = run_cli("study", "run", "study.toml", "--no-figures", cwd=evaluated)
    assert result.exit_code == 0
    assert result.stderr.startswith("air: unchanged, nothing to do\n")
    assert re.search(r"Archard's law\n  k_D of the pin \(1\.\d+ ± ", result.stdout)
    assert tree_bytes(evaluated) == before


@pytest.mark.slow
def test_force_and_another_recipe_redo_a_study(run_cli, evaluated):
    (evaluated / "recipe.toml").write_text(
        '[drift]\nwindow = 0.05\n[wear]\ncorrection = "two-step"\n', encoding="utf-8"
    )
    dates = [archived(evaluated).study("air").date]
    before = archived(evaluated).study("air").result
    forced = run_cli("study", "run", "study.toml", "--no-figures", "--force", cwd=evaluated)
    assert "unchanged" not in forced.stderr
    assert archived(evaluated).study("air").result == before
    run_cli("study", "run", "study.toml", "--no-figures", "--recipe", "recipe.toml", cwd=evaluated)
    stored = archived(evaluated).study("air")
    assert stored.options["drift"]["window"] == 0.05
    assert stored.result != before
    assert dates[0] <= stored.date


@pytest.mark.slow
def test_run_leaves_out_what_is_marked_bad_and_says_so(run_cli, evaluated):
    run_cli("mark-bad", AGAIN, "--reason", "the pin slipped", cwd=evaluated)
    result = run_cli("study", "run", "study.toml", "--no-figures", "--json", cwd=evaluated)
    assert result.exit_code == 0
    assert f"excluded: {AGAIN} (marked bad: the pin slipped)\n" in result.stderr
    assert f"{AGAIN}: Archard's law" not in result.stderr
    told = json.loads(result.stdout)
    assert told["left_out"] == [{"id": AGAIN, "reason": "marked bad: the pin slipped"}]
    assert [run["id"] for run in told["laws"][0]["runs"]] == [LIGHT, HEAVY]
    assert f"note: k_D is identified from a single run, {LIGHT}" in result.output
    run_cli("mark-bad", AGAIN, "--undo", "--reason", "it did not", cwd=evaluated)
    again = run_cli("study", "run", "study.toml", "--no-figures", "-v", cwd=evaluated)
    assert "excluded" not in again.output
    assert f"{AGAIN}: Archard's law agrees with" in again.output


@pytest.mark.slow
def test_run_tells_where_a_depth_is_reached(run_cli, home):
    write_study(home, end_of_life="20 um")
    result = run_cli("study", "run", "study.toml", "--no-figures", "--json", cwd=home)
    (law,) = json.loads(result.stdout)["laws"]
    for run in law["runs"]:
        life = run["end_of_life"]
        assert life["wear_depth"] == {"value": 20e-6, "unit": "m", "standard_uncertainty": None}
        low, high = (end["value"] for end in life["interval"])
        assert low < life["place"]["value"] < high
        assert f"{run['id']}: the pin reaches a wear depth of 20 µm at " in result.stderr


@pytest.mark.slow
def test_study_on_other_laws_compares_them(run_cli, home):
    write_study(home, laws=["archard", "sarkar"])
    result = run_cli("study", "run", "study.toml", "--no-figures", "-v", cwd=home)
    assert result.exit_code == 0
    assert re.search(
        rf"(?m)^{HEAVY}: AIC (favors \w+'s law|does not discriminate between \w+'s law and \w+'s law) \(AIC minus ",
        result.stdout,
    )
    assert run_cli("study", "figures", "--format", "svg", cwd=home).exit_code == 0
    drawn = {f"air-{name}.svg" for name in ("wear-archard", "wear-sarkar", "friction", "coefficient")}
    assert files(home / "archive" / "figures") == drawn | captions(drawn)


def captions(drawn: set[str]) -> set[str]:
    """Name the files of the captions of figures."""
    return {Path(name).with_suffix(".txt").name for name in drawn}


# --- study show ---


def test_show_repeats_what_run_said(run_cli, evaluated):
    said = run_cli("study", "run", "study.toml", "--no-figures", "-v", cwd=evaluated).output
    shown = run_cli("study", "show", "air", "-v", cwd=evaluated)
    assert shown.exit_code == 0
    assert said == f"{shown.stdout}air: unchanged, nothing to do\n"
    told = run_cli("study", "show", "air", "--json", cwd=evaluated)
    assert StudyResult.model_validate(json.loads(told.stdout)) == archived(evaluated).study("air").result
    assert told.stderr == shown.stdout


def test_show_lists_studies(run_cli, evaluated):
    listed = run_cli("study", "show", cwd=evaluated)
    assert listed.exit_code == 0
    assert "1 studies in archive" in listed.stdout or "1 study in archive" in listed.stdout
    assert " air 2 runs 1 Archard: 1 consistent" in f" {plain(listed.stdout)}"
    told = run_cli("study", "show", "--json", cwd=evaluated)
    assert [Study.model_validate(one) for one in json.loads(told.stdout)["studies"]] == [Study.model_validate(DOCUMENT)]


def test_show_lists_nothing_where_there_is_no_study(run_cli, home):
    assert json.loads(run_cli("study", "show", "--json", cwd=home).stdout) == {"studies": []}
    assert "0 studies in archive" in run_cli("study", "show", cwd=home).stdout


@pytest.mark.parametrize("command", ["show", "figures"])
def test_unknown_study_suggests_the_nearest(run_cli, evaluated, command):
    before = tree_bytes(evaluated)
    assert_refused(run_cli("study", command, "aire", cwd=evaluated), "found no study 'aire'", "did you mean 'air'?")
    assert tree_bytes(evaluated) == before


@pytest.mark.parametrize("command", [["show"], ["show", "air"], ["figures"], ["run", "study.toml"], ["new"]], ids=repr)
def test_archive_that_is_not_there_is_named(run_cli, tmp_path, command):
    write_study(tmp_path)
    before = tree_bytes(tmp_path)
    result = run_cli("study", *command, "--archive", "nowhere", cwd=tmp_path)
    assert_refused(result, "nowhere", "no archive", "--archive")
    assert tree_bytes(tmp_path) == before


def test_runs_are_listed_without_studies(run_cli, evaluated):
    listed = json.loads(run_cli("ls", "--json", cwd=evaluated).stdout)["runs"]
    assert {run["id"] for run in listed} == set(archived(evaluated).ids())
    assert_refused(run_cli("show", "air", cwd=evaluated), "found the study 'air'", "tribopipe study show air")


# --- study figures ---


@pytest.mark.slow
def test_figures_are_drawn_in_the_format_asked_for(run_cli, evaluated):
    before = tree_bytes(evaluated / "archive")
    result = run_cli("study", "figures", "--format", "svg", "--into", "drawn", cwd=evaluated)
    assert result.exit_code == 0
    drawn = {f"air-{name}.svg" for name in NAMES}
    assert files(evaluated / "drawn") == drawn | captions(drawn)
    assert {Path(line).name for line in result.output.splitlines()} == drawn
    for name in drawn:
        assert b"<svg" in (evaluated / "drawn" / name).read_bytes()
    assert tree_bytes(evaluated / "archive") == before


@pytest.mark.slow
def test_figures_go_into_the_archive_s_own_folder(run_cli, evaluated):
    result = run_cli("study", "figures", "air", "--format", "pdf", cwd=evaluated)
    assert result.exit_code == 0
    drawn = {f"air-{name}.pdf" for name in NAMES}
    assert files(evaluated / "archive" / "figures") == drawn | captions(drawn)


def test_unknown_format_is_a_usage_error(run_cli, evaluated):
    before = tree_bytes(evaluated)
    result = run_cli("study", "figures", "--format", "gif", cwd=evaluated)
    assert (result.exit_code, result.stdout) == (2, "")
    assert "'gif'" in result.stderr
    assert "pdf, svg, png" in result.stderr
    assert tree_bytes(evaluated) == before


# --- fit --together, predict --from --onto ---


def test_fit_together_shows_one_coefficient_and_keeps_nothing(run_cli, home):
    before = tree_bytes(home)
    result = run_cli("fit", LIGHT, AGAIN, "--together", "-v", cwd=home)
    assert result.exit_code == 0
    assert "together, Archard's law: pin k_D = (1." in result.stdout
    assert "between-run scatter of k_D of the pin (2 runs)" in result.stdout
    assert f"{AGAIN}: Archard's law agrees with the wear at 200 mN" in result.output
    assert tree_bytes(home) == before


@pytest.mark.slow
def test_fit_together_as_json_is_a_study_result(run_cli, home):
    result = run_cli("fit", LIGHT, AGAIN, "--together", "--law", "sarkar", "--json", cwd=home)
    told = StudyResult.model_validate(json.loads(result.stdout))
    (law,) = told.laws
    assert (law.model, [run.role for run in law.runs]) == ("sarkar", ["fitted", "fitted"])
    assert law.first.between_runs.runs == 2
    assert law.first.interval[0].value < law.first.wear_coefficient.value < law.first.interval[1].value


@pytest.mark.slow
def test_prediction_onto_a_run_is_judged_and_not_kept(run_cli, home):
    before = tree_bytes(home)
    command = ["predict", "--from", LIGHT, "--from", AGAIN, "--onto", HEAVY]
    result = run_cli(*command, "--json", cwd=home)
    assert result.exit_code == 0
    (law,) = StudyResult.model_validate(json.loads(result.stdout)).laws
    assert [(run.id, run.role) for run in law.runs] == [(LIGHT, "fitted"), (AGAIN, "fitted"), (HEAVY, "predicted")]
    assert f"{HEAVY}: {law.runs[2].sentence}" in result.stderr
    assert "Archard's law predicts the wear at 400 mN" in result.stderr
    text = run_cli(*command, "-v", cwd=home)
    assert (text.exit_code, text.stdout) == (0, result.stderr)
    assert tree_bytes(home) == before


@pytest.mark.slow
def test_together_and_study_find_the_same(run_cli, evaluated):
    command = ["predict", "--from", LIGHT, "--from", AGAIN, "--onto", HEAVY, "--json"]
    told = StudyResult.model_validate(json.loads(run_cli(*command, cwd=evaluated).stdout))
    assert told.laws == archived(evaluated).study("air").result.laws


USAGE = {
    "from alone": ["predict", "--from", LIGHT],
    "onto alone": ["predict", "--onto", LIGHT],
    "a run beside": ["predict", AGAIN, "--from", LIGHT, "--onto", HEAVY],
    "a folder beside": ["predict", "--run", ".", "--from", LIGHT, "--onto", HEAVY],
    "a load beside": ["predict", "--from", LIGHT, "--onto", HEAVY, "--load", "2 N"],
    "a distance beside": ["predict", "--from", LIGHT, "--onto", HEAVY, "--at", "10 m"],
    "a depth beside": ["predict", "--from", LIGHT, "--onto", HEAVY, "--depth", "10 um"],
    "a coefficient beside": ["predict", "--from", LIGHT, "--onto", HEAVY, "--wear-coefficient", "1e-9 mm^2/N"],
    "the published scheme": ["predict", "--from", LIGHT, "--onto", HEAVY, "--scheme", "published"],
    "no study to run": ["study", "run"],
    "no such command": ["study", "evaluate", "study.toml"],
    "no interval": ["plan", LIGHT],
    "no run": ["plan", "--interval", "5 %"],
}


@pytest.mark.parametrize("case", USAGE)
def test_wrong_usage_exits_with_2_and_touches_nothing(run_cli, home, case):
    before = tree_bytes(home)
    result = run_cli(*USAGE[case], cwd=home)
    assert (result.exit_code, result.stdout) == (2, "")
    assert "Usage: " in result.stderr
    assert tree_bytes(home) == before


# --- plan ---


def test_plan_of_a_run_says_what_pays_and_what_would_do(run_cli, home):
    before = tree_bytes(home)
    result = run_cli("plan", LIGHT, "--interval", "5 %", "--json", cwd=home)
    assert result.exit_code == 0
    found = Design.model_validate(json.loads(result.stdout))
    assert (found.id, found.model, found.wanted, found.scatter) == (LIGHT, "archard", 0.05, None)
    assert str(found) in result.output
    assert "largest contribution: " in result.stderr
    assert "tests like this one would be sufficient" in result.stderr
    table = plain(result.stderr)
    for lever in found.levers:
        assert f"\n {input_label(lever.name)} " in table or f"\n{input_label(lever.name)} " in table
    text = run_cli("plan", LIGHT, "--interval", "5 %", cwd=home)
    assert (text.stdout, text.stderr) == (result.stderr, "")
    assert tree_bytes(home) == before


def test_plan_of_a_study_counts_with_its_scatter(run_cli, evaluated):
    result = run_cli("plan", "air", "--interval", "5 %", "--json", cwd=evaluated)
    assert result.exit_code == 0
    found = Design.model_validate(json.loads(result.stdout))
    between = archived(evaluated).study("air").result.law("archard").first.between_runs
    assert (found.id, found.scatter) == (LIGHT, between.scatter)
    assert "scatter between runs is unknown" not in result.stderr


def test_plan_of_what_is_good_enough_says_so(run_cli, home):
    result = run_cli("plan", LIGHT, "--interval", "90 %", cwd=home)
    assert result.exit_code == 0
    assert "no further test is needed" in result.stdout


INTERVALS = {
    "nonsense": ["--interval", "'nonsense'", "45 %"],
    "": ["--interval", "''"],
    "5 mm": ["--interval", "'mm'"],
    "0,5 %": ["--interval", "'0,5 %'", "point"],
    "nan %": ["--interval", "'nan %'"],
    "0 %": ["--interval: found 0", "a positive value", "'10 %'"],
    "-5 %": ["--interval: found -0.05", "a positive value"],
}


@pytest.mark.parametrize("interval", INTERVALS)
def test_interval_that_is_none_is_refused(run_cli, home, interval):
    before = tree_bytes(home)
    assert_refused(run_cli("plan", LIGHT, "--interval", interval, cwd=home), *INTERVALS[interval])
    assert tree_bytes(home) == before


@pytest.mark.parametrize("name", ["si3n4-air-200N", "a/b"])
def test_plan_of_what_is_not_archived_is_refused(run_cli, home, name):
    assert_refused(run_cli("plan", name, "--interval", "5 %", cwd=home), f"'{name}'", "expected")


def test_plan_of_a_bad_run_is_refused(run_cli, home):
    run_cli("mark-bad", LIGHT, "--reason", "slipped", cwd=home)
    assert_refused(run_cli("plan", LIGHT, "--interval", "5 %", cwd=home), LIGHT, "bad")


# --- process ---


@pytest.fixture
def lab(runs, tmp_path) -> Path:
    """A folder of two run folders with a study of them, and a recipe of one law."""
    for run_id in (LIGHT, HEAVY):
        shutil.copytree(runs / run_id, tmp_path / "runs" / run_id)
    write_study(tmp_path / "runs", fit=[LIGHT])
    (tmp_path / "recipe.toml").write_text('[wear]\nmodels = ["archard"]\n', encoding="utf-8")
    return tmp_path


@pytest.mark.slow
def test_process_does_runs_study_and_figures_and_the_second_time_nothing(run_cli, lab):
    command = ["process", "runs", "--recipe", "recipe.toml"]
    first = run_cli(*command, "-vv", cwd=lab)
    assert first.exit_code == 0
    store = archived(lab)
    law = store.study("air").result.law("archard")
    for verdict in law.runs:
        assert verdict.sentence in first.output
    assert (
        store.result(HEAVY, "prediction_archard", WearPrediction).first.wear_coefficient == law.first.wear_coefficient
    )
    # Of each run ingest, clean-up, drift, friction, specific wear and one fit; the study, and its prediction.
    assert "14 steps done, 0 unchanged" in first.output
    assert f"figures in {Path('archive') / 'figures'}" in first.output
    drawn = {f"{run}-{what}.png" for run in (LIGHT, HEAVY) for what in ("depth", "friction", "wear")}
    drawn |= {f"air-{name}.{suffix}" for name in NAMES for suffix in ("svg", "png")}
    assert files(lab / "archive" / "figures") == drawn
    before = tree_bytes(lab)
    second = run_cli(*command, cwd=lab)
    assert second.exit_code == 0
    assert "Nothing to do: all 14 steps are unchanged; --force repeats them." in second.output
    assert tree_bytes(lab) == before


@pytest.mark.slow
def test_process_as_json_holds_the_studies(run_cli, lab):
    result = run_cli("process", "runs", "--recipe", "recipe.toml", "--no-figures", "--json", cwd=lab)
    assert result.exit_code == 0
    told = json.loads(result.stdout)
    assert {run["id"] for run in told["runs"]} == {LIGHT, HEAVY}
    assert [StudyResult.model_validate(one) for one in told["studies"]] == [archived(lab).study("air").result]
    assert ("air", "study", "done") in [(step["id"], step["stage"], step["status"]) for step in told["steps"]]
    assert not (lab / "archive" / "figures").exists()


@pytest.mark.slow
def test_process_keeps_the_runs_though_a_study_fails(run_cli, lab):
    write_study(lab / "runs", fit=[LIGHT], predict=[HEAVY, "si3n4-air-80mN"])
    result = run_cli("process", "runs", "--recipe", "recipe.toml", "--no-figures", cwd=lab)
    assert result.exit_code == 3
    (error,) = [line for line in result.stderr.splitlines() if line.startswith("error: ")]
    assert "study air" in error
    assert "found no run 'si3n4-air-80mN'" in error
    assert "did you mean" in error
    store = archived(lab)
    assert store.study_ids() == []
    steps = ["clean_up", "drift_correction", "friction_fit", "specific_wear", "wear_fit_archard"]
    assert store.step_names(HEAVY) == steps


def test_process_refuses_a_study_that_cannot_be_read_before_it_begins(run_cli, lab):
    write_study(lab / "runs", predict=[LIGHT])
    result = run_cli("process", "runs", "--recipe", "recipe.toml", cwd=lab)
    assert_refused(result, "study.toml", f"found '{LIGHT}', which is also in fit")
    assert not (lab / "archive").exists()


def test_process_refuses_two_studies_of_one_id_before_it_begins(run_cli, lab):
    write_study(lab / "runs", "again.study.toml", fit=[LIGHT])
    result = run_cli("process", "runs", "--recipe", "recipe.toml", cwd=lab)
    assert_refused(result, "again.study.toml", "study.toml", "found 'air'", "change one of the IDs")
    assert not (lab / "archive").exists()


@pytest.mark.slow
def test_process_draws_run_and_study_of_one_name(run_cli, lab, monkeypatch):
    drawn = []
    monkeypatch.setattr(
        "tribopipe.views.archived_figures.save_run_figures", lambda _, run_id, __: drawn.append(("run", run_id))
    )
    monkeypatch.setattr(
        "tribopipe.views.archived_figures.save_study_figures", lambda _, name, __: drawn.append(("study", name))
    )
    write_study(lab / "runs", id=HEAVY, fit=[LIGHT])
    assert run_cli("process", "runs", "--recipe", "recipe.toml", cwd=lab).exit_code == 0
    assert sorted(drawn) == [("run", LIGHT), ("run", HEAVY), ("study", HEAVY)]


# --- bad input: one sentence, exit code 1, nothing half-written ---


DOCUMENTS = {
    "other material": ({"fit": [LIGHT, "other-material"]}, ["air", "pin material SiC in other-material", "Si3N4"]),
    "other radius": ({"fit": [LIGHT, "other-radius"]}, ["air", "pin radius in m 0.001 in other-radius", LIGHT]),
    "other medium": ({"predict": ["other-medium"]}, ["air", "medium water in other-medium", LIGHT]),
    "not archived": (
        {"fit": [LIGHT, "si3n4-air-20mN"]},
        ["study air", "archive", "found no run 'si3n4-air-20mN'", f"did you mean '{LIGHT}'?"],
    ),
    "no end value": (
        {"predict": [NO_END]},
        [NO_END, "without a post-test measurement", "remove the run from the study"],
    ),
    "circular": (
        {"predict": [HEAVY, LIGHT]},
        ["study.toml", f"predict: found '{LIGHT}', which is also in fit", "remove the run from one of the two"],
    ),
    "twice": ({"fit": [LIGHT, LIGHT]}, ["study.toml", f"fit: found '{LIGHT}' twice", "remove one"]),
    "nothing to fit": ({"fit": []}, ["study.toml", "fit"]),
    "unknown law": ({"laws": ["archad"]}, ["study.toml", "laws[0]", "'archad'", "archard"]),
    "unknown key": ({"fits": [LIGHT]}, ["study.toml", "fits: unknown key", "did you mean 'fit'?"]),
    "life past the tip": ({"end_of_life": "1 mm"}, ["1000 µm", "tip"]),
    "life without unit": ({"end_of_life": 40}, ["study.toml", "end_of_life", "number 40 without a unit"]),
}


@pytest.mark.parametrize(
    "case", others_slow(DOCUMENTS, "other radius", "not archived", "circular", "life without unit")
)
def test_bad_study_is_refused_and_the_archive_stays_as_it_was(run_cli, evaluated, case):
    changes, words = DOCUMENTS[case]
    write_study(evaluated, **changes)
    before = tree_bytes(evaluated)
    assert_refused(run_cli("study", "run", "study.toml", "--json", cwd=evaluated), *words)
    assert tree_bytes(evaluated) == before


def test_study_that_is_not_there_is_named(run_cli, home):
    before = tree_bytes(home)
    assert_refused(run_cli("study", "run", "studdy.toml", cwd=home), "studdy.toml", "no such file")
    assert tree_bytes(home) == before


CALLS = {
    "other material": (["fit", LIGHT, "other-material", "--together"], ["pin material SiC", "Si3N4"]),
    "other radius": (["fit", "other-radius", LIGHT, "--together"], ["pin radius in m", "0.000794", "0.001"]),
    "all runs": (["fit", "--together"], ["expected the same materials"]),
    "onto another material": (["predict", "--from", LIGHT, "--onto", "other-material"], ["pin material SiC"]),
    "not archived": (["fit", LIGHT, "si3n4-air-20mN", "--together"], ["'si3n4-air-20mN'", f"did you mean '{LIGHT}'?"]),
    "from what is not archived": (["predict", "--from", "si3n4", "--onto", LIGHT], ["found no run 'si3n4'"]),
    "onto what is not archived": (
        ["predict", "--from", LIGHT, "--onto", "si3n4-air-400N"],
        ["found no run 'si3n4-air-400N'", f"did you mean '{HEAVY}'?"],
    ),
    "onto itself": (
        ["predict", "--from", LIGHT, "--onto", HEAVY, "--onto", LIGHT],
        [f"found '{LIGHT}', which is also in fit", "remove the run from one of the two"],
    ),
    "from twice": (["predict", "--from", LIGHT, "--from", LIGHT, "--onto", HEAVY], [f"found '{LIGHT}' twice"]),
    "together with itself": (["fit", LIGHT, LIGHT, "--together"], [f"found '{LIGHT}' twice"]),
    "no id": (["predict", "--from", "a/b", "--onto", HEAVY], ["'a/b'", "letters"]),
    "no end value": (["fit", LIGHT, NO_END, "--together"], [NO_END, "without a post-test measurement"]),
}


@pytest.mark.parametrize("case", others_slow(CALLS, "other material", "onto itself", "not archived", "no id"))
def test_bad_call_is_refused_and_the_archive_stays_as_it_was(run_cli, home, case):
    arguments, words = CALLS[case]
    before = tree_bytes(home)
    assert_refused(run_cli(*arguments, "--json", cwd=home), *words)
    assert tree_bytes(home) == before


@pytest.fixture(scope="module")
def soft(tmp_path_factory) -> Path:
    """An archive of soft bodies under 200 mN, and under a load that crushes them; not to be written into."""
    folder = tmp_path_factory.mktemp("soft")
    series = load_toml(SAMPLES / "plan.toml", Plan).series[0]
    light = series.runs[0]
    crushed = light.model_copy(update={"id": CRUSHED, "normal_load": Quantity(value=40.0, unit="N"), "seed": 140})
    contact = series.contact.model_dump()
    contact["pin"]["vickers_hardness"] = contact["disc"]["vickers_hardness"] = 600
    contact = type(series.contact).model_validate(contact)
    distance = Quantity(value=100.0, unit="m")
    series = series.model_copy(update={"contact": contact, "runs": (light, crushed), "sliding_distance": distance})
    simulate_plan(Plan(schema="tribopipe.plan/1", series=(series,)), folder / "runs")
    return fill(folder / "archive", folder / "runs").folder


@pytest.mark.slow
def test_load_beyond_what_the_contact_bears_is_flagged_as_extrapolation(run_cli, soft):
    before = tree_bytes(soft)
    result = run_cli("predict", "--from", LIGHT, "--onto", CRUSHED, "--archive", soft, "--json")
    assert result.exit_code == 0
    (law,) = StudyResult.model_validate(json.loads(result.stdout)).laws
    fitted, predicted = law.runs
    assert [note for note in fitted.notes if "extrapolation" in note] == []
    worn, yields = (note for note in predicted.notes if note.startswith("extrapolation: "))
    assert "contact radius" in worn
    assert "half the tip radius" in worn
    assert "the Hertzian pressure of 6.8" in yields
    assert "exceeds the hardness of the softer body, 5.884 GPa" in yields
    for note in (worn, yields):
        assert f"{CRUSHED}: note: {note}\n" in result.stderr
    assert tree_bytes(soft) == before


def test_extrapolation_is_kept_with_the_study(run_cli, soft, tmp_path):
    shutil.copytree(soft, tmp_path / "archive")
    (tmp_path / "study.toml").write_text(
        study_toml(Study(id="soft", fit=(LIGHT,), predict=(CRUSHED,), laws=("archard",))), encoding="utf-8"
    )
    result = run_cli("study", "run", "study.toml", "--no-figures", cwd=tmp_path)
    assert result.exit_code == 0
    notes = archived(tmp_path).study("soft").result.law("archard").runs[1].notes
    assert len([note for note in notes if note.startswith("extrapolation: ")]) == 2
    assert f"extrapolation, see the notes: {CRUSHED}\n" in run_cli("study", "show", "soft", cwd=tmp_path).stdout
    shown = run_cli("study", "show", "soft", "-v", cwd=tmp_path).stdout
    assert all(f"{CRUSHED}: note: {note}\n" in shown for note in notes)

"""What is archived comes out the same again, number by number, and what does not is named."""

import json
import math
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from archived_files import edited
from folders import SAMPLES, replace_in, tree_bytes
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from study_runs import AGAIN, HEAVY, LIGHT

from tribopipe.archive.provenance import environment
from tribopipe.archive.step_names import inputs_digest
from tribopipe.archive.store import Archive
from tribopipe.documents.annotation import Mark
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe
from tribopipe.documents.study import Study
from tribopipe.evaluation.wear.local import LocalOptions
from tribopipe.pipeline.recomputed_values import compare
from tribopipe.pipeline.reproduce import reproduce, reproduce_study
from tribopipe.pipeline.stages import advance, ingest, predict_archived, wear_archived_locally
from tribopipe.pipeline.studies import run_study
from tribopipe.version import VERSION

# That the same comes out again does not depend on how often one draws.
pytestmark = pytest.mark.usefixtures("few_draws")

DISC = "si3n4-twin-disc-4pct-100k"
ODD = Recipe.model_validate(
    {
        "clean_up": [{"step": "mask", "limits": {"friction_coefficient": {"highest": 0.68}}}, {"step": "despike"}],
        "drift": {"window": 0.05},
        "friction": {"start": "3 m"},
        "wear": {"friction": "measured", "correction": "model"},
        "uncertainty": {"normal_load": 0.03},
        "monte_carlo": {"seed": 7},
    }
)
STUDY = Study(id="air", fit=(LIGHT, AGAIN), predict=(HEAVY,), laws=("archard",))
QUICK = LocalOptions(steps_per_decade=3)


@pytest.fixture(scope="module")
def _done(runs, tmp_path_factory) -> Path:
    """Two runs of a pin under an odd recipe, one predicted from the other and worn locally; two discs."""
    archive = Archive(tmp_path_factory.mktemp("reproduce") / "archive")
    for run in (runs / LIGHT, runs / HEAVY, SAMPLES / DISC):
        ingest(run, archive)
    advance(archive, HEAVY, "clean_up", Recipe())
    advance(archive, LIGHT, "wear_fit_sarkar", ODD)
    predict_archived(archive, HEAVY, LIGHT, "sarkar", ODD)
    wear_archived_locally(archive, LIGHT, "sarkar", ODD, QUICK, at=[1.0])
    known = {"pin": Quantity(value=13.5e-15, unit="m^2/N", standard_uncertainty=1e-16)}
    wear_archived_locally(archive, HEAVY, "archard", Recipe(), QUICK, coefficients=known, at=[0.1])
    advance(archive, DISC, "friction_fit", Recipe())
    advance(archive, DISC, "wear_fit_archard", Recipe.model_validate({"wear": {"distance_per_rotation": "line-load"}}))
    return archive.folder


@pytest.fixture
def done(_done, tmp_path) -> Archive:
    """Those runs, to write into."""
    return Archive(shutil.copytree(_done, tmp_path / "archive"))


@pytest.fixture(scope="module")
def _studied(filled, tmp_path_factory) -> Path:
    archive = Archive(shutil.copytree(filled, tmp_path_factory.mktemp("studied") / "archive"))
    list(run_study(archive, STUDY, Recipe()))
    return archive.folder


@pytest.fixture
def studied(_studied, tmp_path) -> Archive:
    """A study of three runs, to write into."""
    return Archive(shutil.copytree(_studied, tmp_path / "studied"))


def outcomes(reproduction) -> dict[str, str]:
    return {step.name: step.outcome for step in reproduction.steps}


def only(reproduction, name: str):
    """The step of a name; all others came out the same."""
    assert {step.name for step in reproduction.steps if not step.same} == {name}
    return next(step for step in reproduction.steps if step.name == name)


def edit_result(archive: Archive, run_id: str, step: str, *path: str, factor: float) -> None:
    """Change a number in the result of a step, behind the seal."""
    with edited(archive.path(run_id)) as file:
        kept = file[f"entry/{step}/result/data"]
        document = json.loads(kept.asstr()[()])
        inner = document
        for key in path[:-1]:
            inner = inner[key]
        inner[path[-1]] *= factor
        kept[()] = json.dumps(document)


# --- what steps tell ---


def test_steps_tell_what_they_stand_on_and_what_they_were_computed_with(done):
    steps = done.steps(LIGHT) | done.steps(HEAVY)
    for step in steps.values():
        assert step.environment == environment()
        assert inputs_digest(VERSION, step.name, step.options, step.stands_on) == step.inputs_sha256
    fit, predicted = steps["wear_fit_sarkar"], steps["prediction_sarkar"]
    assert list(fit.stands_on) == ["raw", "clean_up", "drift_correction", "friction_fit"]
    assert fit.stands_on["raw"] == done.raw_sha256(LIGHT)
    assert fit.stands_on["friction_fit"] == done.fingerprints(LIGHT, "friction_fit").result
    assert list(predicted.stands_on) == ["raw", "clean_up", "friction_fit", "wear_coefficient"]
    assert predicted.stands_on["friction_fit"] == ""
    assert done.environment(LIGHT) == environment()


@pytest.mark.slow
def test_study_tells_what_it_stands_on_and_what_it_was_computed_with(studied):
    stored = studied.study("air")
    assert stored.stands_on == {run_id: studied.raw_sha256(run_id) for run_id in (LIGHT, AGAIN, HEAVY)}
    assert stored.environment == environment()


# --- the same again ---


@pytest.mark.slow
@pytest.mark.parametrize("run_id", [LIGHT, HEAVY, DISC])
def test_every_step_comes_out_the_same_bit_for_bit_by_its_own_options(done, run_id):
    before = tree_bytes(done.folder)
    found = reproduce(done, run_id)
    assert {step.name: step.why for step in found.steps if step.outcome != "identical"} == {}
    assert [step.name for step in found.steps] == ["raw", *done.step_names(run_id)]
    assert found.same
    for redone in found.steps[1:]:
        step = done.step(run_id, redone.name)
        arrays = [
            *step.curves.values(),
            *(kept for table in step.tables.values() for told in table for kept in told.values()),
        ]
        assert redone.compared > sum(values.size for values, _ in arrays) or redone.name == "clean_up"
    assert tree_bytes(done.folder) == before


@pytest.mark.slow
def test_study_and_its_predictions_come_out_the_same_bit_for_bit(studied):
    (step,) = reproduce_study(studied, "air").steps
    assert (step.name, step.outcome) == ("study", "identical")
    assert step.compared > 500
    assert set(outcomes(reproduce(studied, HEAVY)).values()) == {"identical"}


@pytest.mark.slow
def test_prediction_from_the_one_run_of_a_study_is_found_in_the_study(studied):
    alone = STUDY.model_copy(update={"id": "alone", "fit": (AGAIN,)})
    list(run_study(studied, alone, Recipe()))
    assert AGAIN in studied.ids()
    assert "wear_fit_archard" not in studied.step_names(AGAIN)
    assert outcomes(reproduce(studied, HEAVY))["prediction_archard"] == "identical"


def test_run_with_files_in_folders_is_read_again(runs, tmp_path):
    run = shutil.copytree(runs / LIGHT, tmp_path / "run")
    (run / "as recorded" / "µ").mkdir(parents=True)
    (run / "signals.csv").rename(run / "as recorded" / "µ" / "signals.csv")
    replace_in(run / "run.toml", "signals.csv", "as recorded/µ/signals.csv")
    archive = Archive(tmp_path / "archive")
    ingest(run, archive)
    assert outcomes(reproduce(archive, LIGHT)) == {"raw": "identical"}


# --- what is not the same ---


@pytest.mark.slow
def test_changed_result_is_found_with_its_name(done):
    edit_result(done, LIGHT, "wear_fit_sarkar", "sensor", "drift_rate", "value", factor=1 + 1e-6)
    step = only(reproduce(done, LIGHT), "wear_fit_sarkar")
    (difference,) = step.differences
    assert (step.outcome, difference.where) == ("different", "result.sensor.drift_rate.value")
    assert difference.relative == pytest.approx(1e-6, rel=1e-3)
    assert difference.then == pytest.approx(difference.now * (1 + 1e-6), rel=1e-12)


@pytest.mark.slow
def test_what_rounding_may_do_counts_as_the_same(done):
    edit_result(done, HEAVY, "prediction_sarkar", "bodies", "pin", "wear_coefficient", "value", factor=1 + 1e-12)
    found = reproduce(done, HEAVY)
    assert found.same
    assert found.outcome == outcomes(found)["prediction_sarkar"] == "within 1e-9"


@pytest.mark.slow
def test_changed_arrays_are_found_with_their_elements(done):
    with edited(done.path(LIGHT)) as file:
        for part in ("raw/friction_force", "drift_correction/data/wear_depth", "local_wear_sarkar/course/depth"):
            file[f"entry/{part}"][7] *= 1.001
    steps = {step.name: step for step in reproduce(done, LIGHT).steps}
    for name, where in {
        "raw": "columns.friction_force[7]",
        "drift_correction": "curves.wear_depth.values[7]",
        "local_wear_sarkar": "tables.course.depth.values[7]",
    }.items():
        assert steps[name].outcome == "different"
        assert steps[name].differences[0].where == where
        assert steps[name].differences[0].relative == pytest.approx(1e-3, rel=1e-2)


@pytest.mark.slow
def test_changed_source_file_is_found(done):
    with edited(done.path(LIGHT)) as file:
        kept = file["entry/source_files/file_1/data"]
        content = kept[()].tobytes()
        place = re.search(rb"\n\d+", content).end() - 1
        kept[place] = ord(b"9") if content[place] != ord(b"9") else ord(b"8")
    assert only(reproduce(done, LIGHT), "raw").outcome == "different"


@pytest.mark.slow
def test_changed_study_is_found(studied):
    with edited(studied.study_folder / "air.h5") as file:
        file["entry/curve_001/predicted"][3] *= 1.01
    found = reproduce_study(studied, "air")
    assert only(found, "study").differences[0].where == "curves[1].predicted[3]"


@pytest.mark.slow
def test_versions_that_were_others_are_told(done):
    with edited(done.path(DISC)) as file:
        kept = file["entry/friction_fit/environment/data"]
        kept[()] = json.dumps(json.loads(kept.asstr()[()]) | {"numpy": "1.0"})
        del file["entry/wear_fit_archard/environment"]
        file["entry/wear_fit_archard/version"][()] = "0.0.9"
    steps = {step.name: step for step in reproduce(done, DISC).steps}
    assert steps["friction_fit"].environment == {"numpy": ("1.0", environment()["numpy"])}
    assert steps["wear_fit_archard"].environment == {"tribopipe": ("0.0.9", VERSION)}
    assert steps["drift_correction"].environment == {}


# --- what cannot be compared ---


def why(reproduction, name: str) -> str:
    step = only(reproduction, name)
    assert step.outcome == "not compared"
    assert "\n" not in step.why
    return step.why


@pytest.mark.slow
def test_prediction_from_a_k_d_that_has_changed_is_not_compared(done):
    advance(done, LIGHT, "wear_fit_sarkar", Recipe())
    assert "computed from wear coefficient that" in why(reproduce(done, HEAVY), "prediction_sarkar")


def test_prediction_from_a_run_that_is_gone_is_not_compared(done):
    done.path(LIGHT).unlink()
    assert LIGHT in why(reproduce(done, HEAVY), "prediction_sarkar")


@pytest.mark.slow
def test_step_on_another_base_than_the_archive_holds_is_not_compared(done):
    with edited(done.path(LIGHT)) as file:
        kept = file["entry/friction_fit/fingerprints/result_sha256"]
        kept[()] = "0" * 64
    found = reproduce(done, LIGHT)
    assert [name for name, outcome in outcomes(found).items() if outcome == "not compared"] == [
        "wear_fit_sarkar",
        "local_wear_sarkar",
    ]
    assert "computed from friction fit that" in found.steps[-1].why


@pytest.mark.slow
@pytest.mark.parametrize("options", [{}, {"local_wear": {"engine": "none such"}, "at": []}, {"local_wear": 3, "at": 4}])
def test_options_that_tell_nothing_are_refused_in_one_sentence(done, options):
    with edited(done.path(HEAVY)) as file:
        file["entry/local_wear_archard/options/data"][()] = json.dumps(options)
    assert HEAVY in why(reproduce(done, HEAVY), "local_wear_archard")


def test_study_of_which_a_run_was_marked_bad_is_not_compared(studied):
    studied.mark(AGAIN, Mark(kind="bad", reason="it slipped", date="2026-07-01T10:00:00+00:00"))
    assert "marked bad" in why(reproduce_study(studied, "air"), "study")


def test_study_of_which_a_run_is_gone_or_another_is_not_compared(studied):
    studied.path(HEAVY).unlink()
    assert HEAVY in why(reproduce_study(studied, "air"), "study")
    with edited(shutil.copy(studied.path(AGAIN), studied.path(HEAVY))) as file:
        file["entry/identifier_run"][()] = HEAVY
    assert HEAVY in why(reproduce_study(studied, "air"), "study")


@pytest.mark.slow
def test_source_file_outside_of_the_run_folder_is_not_written(done, tmp_path):
    with edited(done.path(LIGHT)) as file:
        file["entry/source_files/file_1/file_name"][()] = "../../escaped.csv"
    assert "inside the run folder" in why(reproduce(done, LIGHT), "raw")
    assert list(tmp_path.rglob("escaped.csv")) == []


@pytest.mark.slow
def test_step_that_cannot_be_computed_is_told_and_the_others_are_compared(done, monkeypatch):
    monkeypatch.setattr("tribopipe.base.failures._kept", lambda _: "")
    with edited(done.path(LIGHT)) as file:
        file["entry/drift_correction/data/wear_depth"][...] = np.nan
    found = outcomes(reproduce(done, LIGHT))
    assert (found["drift_correction"], found["wear_fit_sarkar"]) == ("different", "not compared")
    assert found["friction_fit"] == "identical"


# --- values ---


def compared(then, now):
    return compare("step", {"value": then}, {"value": now}, environment())


@pytest.mark.parametrize(
    ("then", "now", "outcome", "relative"),
    [
        (1.0, 1.0, "identical", None),
        (math.nan, math.nan, "identical", None),
        (0.0, -0.0, "within 1e-9", 0.0),
        (1.0, 1.0 + 5e-10, "within 1e-9", 5e-10),
        (1.0, 1.0 + 5e-9, "different", 5e-9),
        (1.0, -1.0, "different", 2.0),
        (0.0, 1e-30, "different", 1.0),
        (1.0, math.nan, "different", None),
        (math.inf, 1.0, "different", None),
        (1.7e308, -1.7e308, "different", None),
        (1.0, None, "different", None),
        (None, None, "identical", None),
        ("as it was", "as it was", "identical", None),
        ("as it was", "as it is", "different", None),
        (True, False, "different", None),
        (np.arange(3.0), np.arange(4.0), "different", None),
        (np.arange(3.0), None, "different", None),
        (np.array(["a", "b"], dtype=object), np.array(["a", "c"], dtype=object), "different", None),
        (np.array([2, 3]), np.array([2.0, 3.0]), "identical", None),
        (np.array([math.nan, math.inf]), np.array([math.nan, math.inf]), "identical", None),
    ],
)
def test_values_are_the_same_nearly_the_same_or_not(then, now, outcome, relative):
    found = compared(then, now)
    assert (found.outcome, compared(now, then).outcome) == (outcome, outcome)
    if relative is not None:
        assert found.differences[0].relative == pytest.approx(relative, rel=1e-6)
    json.dumps(found.as_json(), allow_nan=False)


@settings(max_examples=25)
@given(
    st.lists(st.floats(-1e300, 1e300), min_size=1, max_size=20),
    st.integers(0, 19),
    st.sampled_from([1e-15, 1e-12, 1e-8, 1e-3]),
)
def test_one_other_element_is_found(values, place, relative):
    then = np.array(values)
    at, now = place % len(then), then.copy()
    now[at] *= 1 + relative
    found = compared(then, now)
    assume(now[at] != then[at])
    (difference,) = found.differences
    assert difference.where == f"value[{at}]"
    assert found.outcome == ("within 1e-9" if abs(now[at] - then[at]) <= 1e-9 * abs(now[at]) else "different")


def test_nested_values_are_compared_by_their_keys():
    then = {"laws": [{"k": 1.0}, {"k": 2.0, "notes": ["a"]}]}
    now = {"laws": [{"k": 1.0}, {"k": 2.5, "notes": ["b"]}]}
    found = compare("study", then, now, {})
    assert [one.where for one in found.differences] == ["laws[1].notes[0]", "laws[1].k"]
    assert found.compared == 3


# --- the command ---


@pytest.mark.slow
def test_command_tells_people_and_programs(done, run_cli):
    finished = run_cli("reproduce", "--archive", done.folder)
    assert finished.exit_code == 0, finished.stderr
    assert all(run_id in finished.stdout for run_id in done.ids())
    assert "identical" in finished.stdout
    edit_result(done, DISC, "friction_fit", "mean", "value", factor=1.1)
    finished = run_cli("reproduce", DISC, "--archive", done.folder, "--json")
    assert finished.exit_code == 1
    assert "friction_fit: result.mean.value: archived " in finished.stderr
    (told,) = json.loads(finished.stdout)["reproduced"]
    assert (told["id"], told["kind"], told["outcome"]) == (DISC, "run", "different")
    step = next(step for step in told["steps"] if step["name"] == "friction_fit")
    assert [one["where"] for one in step["differences"]] == ["result.mean.value"]


@pytest.mark.slow
def test_one_unreadable_run_does_not_stop_the_others(done, run_cli):
    done.path(HEAVY).write_bytes(b"no HDF5")
    finished = run_cli("reproduce", DISC, HEAVY, "--archive", done.folder, "--json")
    assert finished.exit_code == 3
    document = json.loads(finished.stdout)
    assert [one["id"] for one in document["reproduced"]] == [DISC]
    assert HEAVY in document["errors"][0]


def test_empty_archive_and_unknown_id_are_refused(done, run_cli, tmp_path):
    (tmp_path / "empty").mkdir()
    finished = run_cli("reproduce", "--archive", tmp_path / "empty")
    assert (finished.exit_code, "found no runs" in finished.stderr) == (1, True)
    finished = run_cli("reproduce", "si3n4-air-200nM", "--archive", done.folder)
    assert finished.exit_code == 1
    assert "did you mean" in finished.stderr


# --- two processes, other threads ---

SLOW = ("si3n4-air-200mN", "wc-co-water-1600mN", DISC, "si3n4-twin-disc-4pct-250k")
_DATE = re.compile(rb"20\d\d-\d\d-\d\dT\d\d:\d\d:\d\d\+00:00")


def tribopipe(*arguments: object, **environ: str) -> str:
    command = [sys.executable, "-m", "tribopipe", *map(str, arguments)]
    settings = os.environ | {"PYTHONUTF8": "1"} | environ
    done = subprocess.run(command, capture_output=True, env=settings, encoding="utf-8")
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def processed(tmp_path_factory) -> tuple[Path, Path]:
    """The same runs and studies taken through the whole line by two processes that hash texts differently."""
    folder = tmp_path_factory.mktemp("twice")
    for run_id in SLOW:
        shutil.copytree(SAMPLES / run_id, folder / "runs" / run_id)
    fitted = 'schema = "tribopipe.study/1"\nid = "{}"\nfit = ["{}"]\npredict = ["{}"]\n'
    for name, fit, predict in (("discs", *SLOW[2:]),):
        (folder / "runs" / f"{name}.study.toml").write_text(fitted.format(name, fit, predict), encoding="utf-8")
    for seed in ("1", "2"):
        archive = folder / seed
        tribopipe("process", folder / "runs", "--archive", archive, "--no-figures", PYTHONHASHSEED=seed)
        worn = ("local-wear", SLOW[0], SLOW[2], "--steps-per-decade", 3, "--archive", archive)
        tribopipe(*worn, PYTHONHASHSEED=seed)
    return folder / "1", folder / "2"


@pytest.mark.slow
def test_two_processes_write_the_same_bytes_but_for_dates_and_seals(processed):
    first, second = (
        {name: _DATE.sub(b"", content[512:]) for name, content in tree_bytes(folder).items() if name.endswith(".h5")}
        for folder in processed
    )
    assert len(first) == len(SLOW) + 1
    assert [name for name in first if first[name] != second[name]] == []


@pytest.mark.slow
@pytest.mark.parametrize("threads", ["1", "4"])
def test_numbers_stay_within_1e_9_whatever_the_threads_of_linear_algebra(processed, threads):
    counts = {f"{library}_NUM_THREADS": threads for library in ("OPENBLAS", "OMP", "MKL")}
    document = json.loads(tribopipe("reproduce", "--archive", processed[0], "--json", **counts))
    assert document["errors"] == []
    assert len(document["reproduced"]) == len(SLOW) + 1
    found = {one["outcome"] for one in document["reproduced"]}
    assert found == {"identical"} if threads == "1" else found <= {"identical", "within 1e-9"}

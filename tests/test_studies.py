"""Studies on an archive: evaluated, kept, redone where something changed; a refused one leaves no trace."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from archived_files import edited
from folders import DISC_IDS, SAMPLE_IDS, SAMPLES, tree_bytes
from hypothesis import given, settings
from hypothesis import strategies as st
from study_runs import AGAIN, HEAVY, LIGHT, NO_END
from sweeps import others_slow
from test_archive import nxcheck

from tribopipe.archive.step_names import METHODS
from tribopipe.archive.store import Archive
from tribopipe.archive.studyfile import StoredStudy
from tribopipe.base.errors import ArchiveError, FitError, TribopipeError
from tribopipe.base.executor import Crew
from tribopipe.documents.annotation import Mark
from tribopipe.documents.manifest import RunManifest, manifest_path, read_manifest
from tribopipe.documents.recipe import DriftRecipe, Recipe, WearRecipe
from tribopipe.documents.record import load_toml
from tribopipe.documents.study import Study
from tribopipe.pipeline.stages import advance, ingest, process
from tribopipe.pipeline.studies import (
    draft_studies,
    evaluate_archived,
    find_studies,
    load_studies,
    members,
    plan_archived,
    process_studies,
    run_study,
    study_toml,
)
from tribopipe.results.study import LeftOut, MeasuredCurve, StudyResult
from tribopipe.results.wear_prediction import WearPrediction

# What is kept and what is refused does not depend on how often one draws.
pytestmark = pytest.mark.usefixtures("few_draws")

STUDY = Study(id="air", title="One law, two loads", fit=(LIGHT, AGAIN), predict=(HEAVY,))
QUICK = STUDY.model_copy(update={"laws": ("archard",)})
DATE = "2026-07-01T10:00:00+00:00"
BAD = Mark(kind="bad", reason="the pin slipped", date=DATE)
GOOD = Mark(kind="good", reason="it was another run", date=DATE)
OTHER_WINDOW = Recipe(drift=DriftRecipe(window=0.05), wear=WearRecipe(correction="two-step"))


@pytest.fixture(scope="module")
def raw(runs, tmp_path_factory) -> Path:
    """An archive of the same runs as ingested; not to be written into."""
    store = Archive(tmp_path_factory.mktemp("raw") / "archive")
    for run in runs.iterdir():
        ingest(run, store)
    return store.folder


@pytest.fixture(scope="module")
def ran(filled, tmp_path_factory):
    """The archive with the study evaluated under both laws, and what became of it; not to be written into."""
    store = Archive(shutil.copytree(filled, tmp_path_factory.mktemp("ran") / "archive"))
    return store, list(run_study(store, STUDY, Recipe()))


@pytest.fixture(scope="module")
def ran_quick(filled, tmp_path_factory):
    """The archive with the study evaluated under Archard's law alone; not to be written into."""
    store = Archive(shutil.copytree(filled, tmp_path_factory.mktemp("quick") / "archive"))
    return store, list(run_study(store, QUICK, Recipe()))


@pytest.fixture
def store(filled, tmp_path) -> Archive:
    """The archive of short runs, to write into."""
    return Archive(shutil.copytree(filled, tmp_path / "store"))


@pytest.fixture
def done(ran, tmp_path) -> Archive:
    """The archive with the study evaluated, to write into."""
    return Archive(shutil.copytree(ran[0].folder, tmp_path / "store"))


@pytest.fixture
def quick(ran_quick, tmp_path) -> Archive:
    """The archive with the study evaluated under Archard's law alone, to write into."""
    return Archive(shutil.copytree(ran_quick[0].folder, tmp_path / "store"))


def statuses(outcomes) -> list[tuple[str, str, str]]:
    assert [outcome.error for outcome in outcomes if outcome.error] == []
    return [(outcome.run_id, outcome.stage, outcome.status) for outcome in outcomes]


def result_of(outcomes) -> StudyResult:
    assert outcomes[0].error is None, outcomes[0].error
    return outcomes[0].result


def refusal(outcomes) -> str:
    """The sentence of a study that failed as a whole."""
    (outcome,) = outcomes
    assert (outcome.stage, outcome.status, outcome.result) == ("study", "failed", None)
    said = str(outcome.error)
    assert "\n" not in said
    return said


def assert_says(said: str, *words: str) -> None:
    assert [word for word in words if word not in said] == [], said


# --- evaluated and kept ---


def test_study_and_a_prediction_under_each_law_are_told(ran):
    _, outcomes = ran
    assert statuses(outcomes) == [
        ("air", "study", "done"),
        (HEAVY, "prediction", "done"),
        (HEAVY, "prediction", "done"),
    ]
    assert [prediction.result.model for prediction in outcomes[1:]] == ["archard", "sarkar"]
    result = result_of(outcomes)
    assert (result.id, result.title, result.left_out) == ("air", "One law, two loads", ())
    for law in result.laws:
        assert [(run.id, run.role) for run in law.runs] == [(LIGHT, "fitted"), (AGAIN, "fitted"), (HEAVY, "predicted")]
        assert law.first.between_runs.runs == 2


def test_study_is_read_back_to_the_last_digit(ran):
    store, outcomes = ran
    stored = store.study("air")
    assert stored.study == STUDY
    assert stored.result == result_of(outcomes)
    assert stored.options == Recipe().model_dump(mode="json", by_alias=True) | {"methods": METHODS}


@pytest.mark.slow
def test_curves_are_read_back_as_they_were_drawn(ran):
    store, outcomes = ran
    evaluation = evaluate_archived(store, STUDY, Recipe())
    assert evaluation.result == result_of(outcomes)
    curves = store.study("air").curves
    told = [(curve.run_id, curve.model, curve.role) for curve in curves]
    assert told == [(run.id, law.model, run.role) for law in evaluation.result.laws for run in law.runs]
    for found, drawn in zip(curves, evaluation.curves, strict=True):
        assert (found.body, found.what, found.along) == ("pin", "wear_depth", "sliding_distance")
        np.testing.assert_array_equal(found.places, drawn.places)
        for name in ("predicted", "lower", "upper"):
            # They are written in µm, for people to look at.
            np.testing.assert_allclose(getattr(found, name), getattr(drawn, name), rtol=1e-14, atol=1e-24)
        for name in ("best", "lower", "upper"):
            measured, as_drawn = (getattr(one.measured, name) for one in (found, drawn))
            np.testing.assert_allclose(measured, as_drawn, rtol=1e-14, atol=1e-24)
        assert np.all(found.lower[1:] < found.predicted[1:])
        assert np.all(found.predicted[1:] < found.upper[1:])


def test_curves_end_at_the_depths_of_the_verdicts(ran):
    store, _ = ran
    stored = store.study("air")
    verdicts = [run for law in stored.result.laws for run in law.runs]
    for curve, verdict in zip(stored.curves, verdicts, strict=True):
        assert curve.measured.best[-1] == pytest.approx(verdict.first.measured.value, rel=1e-12, abs=0)
        assert curve.predicted[-1] == pytest.approx(verdict.first.predicted.value, rel=1e-12, abs=0)
        low, high = (end.value for end in verdict.first.predicted_interval)
        assert (curve.lower[-1], curve.upper[-1]) == pytest.approx((low, high), rel=1e-12, abs=0)


@pytest.mark.slow
@settings(max_examples=15)
@given(
    st.text(st.characters(codec="utf-8", exclude_characters="\x00"), max_size=30),
    st.lists(st.floats(-1e-3, 1e-3), min_size=1, max_size=8),
)
def test_every_title_and_curve_comes_back(ran, tmp_path_factory, title, depths):
    stored = ran[0].study("air")
    values = np.array(depths)
    curve = replace(
        stored.curves[0],
        places=np.arange(len(depths), dtype=float),
        **dict.fromkeys(("predicted", "lower", "upper"), values),
        measured=MeasuredCurve(values, values, values),
    )
    study = stored.study.model_copy(update={"title": title})
    put = StoredStudy(study, stored.result, "inputs", {"told": 1}, "0.1.0", DATE, (curve,))
    fresh = Archive(tmp_path_factory.mktemp("archive"))
    fresh.put_study(put)
    got = fresh.study("air")
    assert (got.study, got.result, got.inputs_sha256, got.options) == (study, stored.result, "inputs", {"told": 1})
    assert (got.program_version, got.date) == ("0.1.0", DATE)
    np.testing.assert_allclose(got.curves[0].measured.best, depths, rtol=1e-14, atol=1e-24)


@pytest.mark.slow
def test_study_file_conforms_to_nexus(ran):
    store, _ = ran
    path = store.study_folder / "air.h5"
    warnings, errors, printed = nxcheck(path)
    assert (warnings, errors) == (0, 0), printed
    with h5py.File(path) as file:
        entry = file[file.attrs["default"]]
        opened = entry[entry.attrs["default"]]
        assert opened[opened.attrs["signal"]].attrs["units"] == "um"
        assert opened["title"][()].decode() == f"{LIGHT}, pin: fitted with Archard's law"


def test_studies_are_no_runs(ran, filled):
    store, _ = ran
    assert store.ids() == Archive(filled).ids()
    assert "air" not in store.ids()
    assert store.study_ids() == ["air"]
    assert Archive(filled).study_ids() == []
    assert store.study_folder == store.folder / "studies"


def test_predictions_of_a_study_carry_its_coefficient_and_its_name(ran):
    store, outcomes = ran
    for law in result_of(outcomes).laws:
        predicted = store.result(HEAVY, f"prediction_{law.model}", WearPrediction)
        assert predicted.first.wear_coefficient == law.first.wear_coefficient
        assert predicted.reference == "study air"
    for fitted in (LIGHT, AGAIN):
        assert [name for name in store.step_names(fitted) if name.startswith("prediction")] == []


@pytest.mark.slow
def test_prediction_from_one_run_refers_to_that_run(store):
    study = QUICK.model_copy(update={"fit": (AGAIN,)})
    outcomes = list(run_study(store, study, Recipe()))
    predicted = store.result(HEAVY, "prediction_archard", WearPrediction)
    assert predicted.reference == AGAIN
    assert predicted.first.wear_coefficient == result_of(outcomes).law("archard").first.wear_coefficient
    assert any(AGAIN in note and "replicate tests" in note for note in result_of(outcomes).notes)


@pytest.mark.slow
def test_study_of_runs_as_ingested_corrects_them_on_the_way(ran_quick, raw, tmp_path):
    store = Archive(shutil.copytree(raw, tmp_path / "store"))
    assert store.step_names(HEAVY) == []
    outcomes = list(run_study(store, QUICK, Recipe()))
    assert result_of(outcomes) == result_of(ran_quick[1])
    assert {"drift_correction", "friction_fit"} <= set(store.step_names(HEAVY))


@pytest.mark.slow
def test_run_whose_first_sample_is_a_stretch_of_its_own_is_judged_without_a_warning(short_runs, tmp_path):
    store = Archive(tmp_path / "archive")
    for run_id in (LIGHT, HEAVY):
        ingest(short_runs / run_id, store)
    first = members(store, (LIGHT,), Recipe())[0][LIGHT].pose("archard", Recipe())
    assert first.places[0] == 0.0
    (law,) = evaluate_archived(store, QUICK.model_copy(update={"fit": (LIGHT,)}), Recipe()).result.laws
    assert all(0 < run.first.change_point.p_value <= 1 for run in law.runs)


# --- redone or not ---


def test_second_run_of_a_study_does_nothing(done, ran):
    before = tree_bytes(done.folder)
    outcomes = list(run_study(done, STUDY, Recipe()))
    assert {status for *_, status in statuses(outcomes)} == {"unchanged"}
    assert len(outcomes) == 3
    assert result_of(outcomes) == result_of(ran[1])
    assert tree_bytes(done.folder) == before


@pytest.mark.slow
def test_force_redoes_a_study_with_the_same_result(quick, ran_quick):
    curves = quick.study("air").curves
    again = list(run_study(quick, QUICK, Recipe(), force=True))
    assert {status for *_, status in statuses(again)} == {"done"}
    assert result_of(again) == result_of(ran_quick[1])
    for found, before in zip(quick.study("air").curves, curves, strict=True):
        np.testing.assert_array_equal(found.measured.upper, before.measured.upper)


@pytest.mark.slow
@pytest.mark.parametrize(
    "changed",
    [{"shared": ("normal_load",)}, {"fit": (LIGHT,)}, {"predict": ()}, {"end_of_life": "20 um"}, {"laws": ("sarkar",)}],
    ids=lambda changed: next(iter(changed)),
)
def test_changed_document_redoes_the_study(quick, changed):
    study = Study.model_validate(QUICK.model_dump() | changed)
    assert study != QUICK
    assert next(run_study(quick, study, Recipe())).status == "done"
    assert quick.study("air").study == study
    assert next(run_study(quick, study, Recipe())).status == "unchanged"


@pytest.mark.slow
def test_another_recipe_redoes_the_study_and_the_first_one_again(quick, ran_quick):
    first = result_of(ran_quick[1])
    other = list(run_study(quick, QUICK, OTHER_WINDOW))
    assert statuses(other)[0] == ("air", "study", "done")
    assert result_of(other).laws != first.laws
    assert quick.study("air").options["drift"]["window"] == 0.05
    back = list(run_study(quick, QUICK, Recipe()))
    assert statuses(back)[0] == ("air", "study", "done")
    assert result_of(back) == first


@pytest.mark.slow
def test_run_corrected_by_another_recipe_meanwhile_is_corrected_again(quick, ran_quick):
    advance(quick, LIGHT, "drift_correction", OTHER_WINDOW)
    outcomes = list(run_study(quick, QUICK, Recipe()))
    assert result_of(outcomes) == result_of(ran_quick[1])
    assert evaluate_archived(quick, QUICK, Recipe()).result == result_of(ran_quick[1])


def test_lost_prediction_is_put_back_though_the_study_is_unchanged(done):
    lost = done.result(HEAVY, "prediction_archard", WearPrediction)
    with edited(done.path(HEAVY)) as file:
        del file["entry/prediction_archard"]
    assert [status for *_, status in statuses(list(run_study(done, STUDY, Recipe())))] == [
        "unchanged",
        "done",
        "unchanged",
    ]
    assert done.result(HEAVY, "prediction_archard", WearPrediction) == lost


# --- marks ---


@pytest.mark.slow
def test_run_marked_bad_is_left_out_until_the_mark_is_taken_back(quick, ran_quick):
    store, first = quick, result_of(ran_quick[1])
    store.mark(AGAIN, BAD)
    outcomes = list(run_study(store, QUICK, Recipe()))
    assert statuses(outcomes)[0] == ("air", "study", "done")
    without = result_of(outcomes)
    assert without.left_out == (LeftOut(id=AGAIN, reason="marked bad: the pin slipped"),)
    (law,) = without.laws
    assert [run.id for run in law.runs] == [LIGHT, HEAVY]
    assert law.first.between_runs is None
    assert AGAIN not in {curve.run_id for curve in store.study("air").curves}
    alone = evaluate_archived(store, QUICK.model_copy(update={"fit": (LIGHT,)}), Recipe()).result
    assert law == alone.law("archard")
    assert (
        store.result(HEAVY, "prediction_archard", WearPrediction).first.wear_coefficient == law.first.wear_coefficient
    )
    assert [status for *_, status in statuses(list(run_study(store, QUICK, Recipe())))] == ["unchanged", "unchanged"]
    store.mark(AGAIN, GOOD)
    back = list(run_study(store, QUICK, Recipe()))
    assert statuses(back)[0] == ("air", "study", "done")
    assert result_of(back) == first


@pytest.mark.slow
def test_another_reason_redoes_the_study(store):
    store.mark(AGAIN, BAD)
    list(run_study(store, QUICK, Recipe()))
    store.mark(AGAIN, BAD.model_copy(update={"reason": "the disc was used before"}))
    outcomes = list(run_study(store, QUICK, Recipe()))
    assert outcomes[0].status == "done"
    assert [one.reason for one in result_of(outcomes).left_out] == ["marked bad: the disc was used before"]


@pytest.mark.slow
def test_predicted_run_marked_bad_is_not_predicted(store):
    store.mark(HEAVY, BAD)
    outcomes = list(run_study(store, QUICK, Recipe()))
    assert statuses(outcomes) == [("air", "study", "done")]
    assert [one.id for one in result_of(outcomes).left_out] == [HEAVY]
    assert "prediction_archard" not in store.step_names(HEAVY)


def test_study_whose_fitted_runs_are_all_bad_is_refused(store):
    for run_id in (LIGHT, AGAIN):
        store.mark(run_id, BAD)
    before = tree_bytes(store.folder)
    said = refusal(list(run_study(store, QUICK, Recipe())))
    assert_says(
        said, "air", "no run left from which to identify k_D", "expected at least one", "`tribopipe mark-bad --undo`"
    )
    assert tree_bytes(store.folder) == before


# --- refused: one sentence, and the archive as it was ---


def test_run_that_is_not_archived_is_named_with_the_nearest(store):
    before = tree_bytes(store.folder)
    study = QUICK.model_copy(update={"predict": (HEAVY, "si3n4-air-800mN")})
    said = refusal(list(run_study(store, study, Recipe())))
    assert_says(said, "study air", "found no run 'si3n4-air-800mN'", f"did you mean '{HEAVY}'?")
    assert tree_bytes(store.folder) == before


@pytest.mark.parametrize(
    ("place", "other", "words"),
    [
        ("fit", "other-material", ["pin material SiC", "Si3N4"]),
        ("predict", "other-material", ["pin material SiC", "Si3N4"]),
        ("fit", "other-radius", ["pin radius in m 0.001", "0.000794"]),
        ("fit", "other-medium", ["medium water", "air"]),
        ("predict", "other-medium", ["medium water", "air"]),
    ],
)
def test_run_of_other_bodies_is_refused(store, other, words, place):
    before = tree_bytes(store.folder)
    study = QUICK.model_copy(update={place: (*getattr(QUICK, place), other)})
    said = refusal(list(run_study(store, study, Recipe())))
    assert_says(
        said, "air: found ", f"in {other}", LIGHT, *words, "expected the same materials", "remove one of the two runs"
    )
    assert tree_bytes(store.folder) == before


@pytest.mark.slow
def test_a_pin_of_another_radius_is_predicted_and_named(store):
    study = QUICK.model_copy(update={"predict": (*QUICK.predict, "other-radius")})
    outcomes = list(run_study(store, study, Recipe()))
    assert not any(outcome.error for outcome in outcomes)
    notes = store.study("air").result.notes
    assert any(note.startswith("other-radius: predicted with the same k_D for a contact or geometry") for note in notes)


@pytest.mark.slow
@pytest.mark.parametrize("place", ["fit", "predict"])
def test_run_without_an_end_value_is_refused(store, place):
    before = tree_bytes(store.folder)
    study = QUICK.model_copy(update={place: (*getattr(QUICK, place), NO_END)})
    said = refusal(list(run_study(store, study, Recipe())))
    assert_says(
        said, f"{NO_END}: found a run without a post-test measurement", "expected", "remove the run from the study"
    )
    assert tree_bytes(store.folder) == before


@pytest.mark.parametrize("wrong", others_slow(["si3n4-air-800mN", "other-medium", NO_END]))
def test_refused_study_does_not_correct_runs_on_the_way(raw, tmp_path, wrong):
    store = Archive(shutil.copytree(raw, tmp_path / "store"))
    before = tree_bytes(store.folder)
    refusal(list(run_study(store, QUICK.model_copy(update={"predict": (HEAVY, wrong)}), Recipe())))
    assert tree_bytes(store.folder) == before


@pytest.mark.slow
def test_depth_past_the_tip_as_end_of_life_is_refused(store):
    before = tree_bytes(store.folder)
    study = Study.model_validate(QUICK.model_dump() | {"end_of_life": "1 mm"})
    said = refusal(list(run_study(store, study, Recipe())))
    assert_says(said, "1000 µm", "tip")
    assert tree_bytes(store.folder) == before


def test_refused_study_leaves_the_earlier_one(done):
    kept = (done.study_folder / "air.h5").read_bytes()
    refusal(list(run_study(done, QUICK.model_copy(update={"fit": (LIGHT, "other-radius")}), Recipe())))
    assert (done.study_folder / "air.h5").read_bytes() == kept


@pytest.mark.slow
def test_failed_write_leaves_the_earlier_study(done, monkeypatch):
    def fail(*_):
        raise OSError(28, "No space left on device")

    before = tree_bytes(done.folder)
    monkeypatch.setattr("tribopipe.base.files.os.fsync", fail)
    said = refusal(list(run_study(done, QUICK, Recipe())))
    assert_says(said, "No space left on device", "--archive")
    assert tree_bytes(done.folder) == before


@pytest.mark.slow
def test_failed_study_does_not_stop_the_next(store):
    missing = QUICK.model_copy(update={"id": "missing", "fit": ("si3n4",)})
    outcomes = list(process_studies(store, [missing, QUICK], Recipe()))
    assert [(outcome.run_id, outcome.status) for outcome in outcomes] == [
        ("missing", "failed"),
        ("air", "done"),
        (HEAVY, "done"),
    ]
    assert store.study_ids() == ["air"]


def test_studies_with_a_run_in_common_are_taken_by_one_worker_after_the_other(store, monkeypatch):
    def named(identifier: str, *runs: str) -> Study:
        return QUICK.model_copy(update={"id": identifier, "fit": runs[:1], "predict": runs[1:]})

    studies = [named("a", "1", "2"), named("b", "3"), named("c", "4", "5"), named("d", "2", "4"), named("e", "6", "3")]
    taken = []

    def by_one(work, tasks, _):
        for task in tasks:
            taken.append([study.id for _, study in task])
            yield task, work(task)

    monkeypatch.setattr("tribopipe.pipeline.stages.in_turn", by_one)
    outcomes = list(process_studies(store, studies, Recipe(), crew=Crew(jobs=2)))
    assert taken == [["a", "c", "d"], ["b", "e"]]
    assert sorted((outcome.place, outcome.run_id, outcome.status) for outcome in outcomes) == [
        (place, name, "failed") for place, name in enumerate("abcde")
    ]


@pytest.mark.slow
def test_studies_by_a_crew_are_those_of_one_process(store, tmp_path):
    alone = Archive(shutil.copytree(store.folder, tmp_path / "alone"))
    other = QUICK.model_copy(update={"id": "other"})
    one = list(process_studies(alone, [QUICK, other], Recipe()))
    two = list(process_studies(store, [QUICK, other], Recipe(), crew=Crew(jobs=2)))
    told = [[(one.place, one.run_id, one.stage, one.status) for one in outcomes] for outcomes in (one, two)]
    assert told[0] == told[1]
    assert store.study_ids() == ["air", "other"]


@pytest.mark.slow
def test_an_unchanged_study_reads_no_run(store, monkeypatch):
    list(run_study(store, QUICK, Recipe()))

    def read(*_):
        raise AssertionError

    monkeypatch.setattr("tribopipe.pipeline.studies.clean_run", read)
    assert [outcome.status for outcome in run_study(store, QUICK, Recipe())] == ["unchanged", "unchanged"]


def not_hdf5(path: Path) -> None:
    path.write_bytes(b"no HDF5 at all")


def cut_short(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:2000])


def a_run(path: Path) -> None:
    shutil.copy(path.parents[1] / f"{LIGHT}.h5", path)


def later_format(path: Path) -> None:
    with edited(path) as file:
        file["entry/archived/format"][()] = "tribopipe.study/99"


def hollow(path: Path) -> None:
    with edited(path) as file:
        del file["entry/result"]


def other_document(path: Path) -> None:
    with edited(path) as file:
        file["entry/result/data"][()] = json.dumps({"id": "air"})


DAMAGE = {
    not_hdf5: "not HDF5",
    cut_short: "length differs",
    a_run: "not a tribopipe study",
    later_format: "study/99",
    hollow: "damaged",
    other_document: "damaged",
}


@pytest.mark.parametrize("damage", DAMAGE, ids=lambda damage: damage.__name__)
def test_damaged_study_file_is_named(done, damage):
    damage(done.study_folder / "air.h5")
    before = tree_bytes(done.folder)
    with pytest.raises(ArchiveError) as refused:
        done.study("air")
    assert "\n" not in str(refused.value)
    assert_says(str(refused.value), str(done.study_folder / "air.h5"), DAMAGE[damage], "expected")
    assert DAMAGE[damage] in refusal(list(run_study(done, STUDY, Recipe())))
    assert tree_bytes(done.folder) == before


def test_unknown_study_suggests_the_nearest(done):
    with pytest.raises(ArchiveError, match=r"found no study 'aire'; expected .*; did you mean 'air'\?"):
        done.study("aire")


# --- looking does not write ---


@pytest.fixture(scope="module")
def by_recipe(runs, tmp_path_factory) -> Path:
    """An archive of runs fitted by a recipe that is not the default one; not to be written into."""
    store = Archive(tmp_path_factory.mktemp("by-recipe") / "archive")
    for run_id in (LIGHT, HEAVY):
        ingest(runs / run_id, store)
        advance(store, run_id, "wear_fit_archard", OTHER_WINDOW)
    return store.folder


@pytest.mark.slow
@pytest.mark.parametrize("look", ["plan", "together"])
def test_what_only_looks_leaves_runs_fitted_by_another_recipe_alone(by_recipe, tmp_path, look):
    store = Archive(shutil.copytree(by_recipe, tmp_path / "store"))
    before = tree_bytes(store.folder)
    if look == "plan":
        plan_archived(store, LIGHT, "archard", 0.05, Recipe())
    else:
        evaluate_archived(store, QUICK.model_copy(update={"fit": (LIGHT,)}), Recipe())
    assert [store.step_names(run_id) for run_id in (LIGHT, HEAVY)] == [
        ["clean_up", "drift_correction", "wear_fit_archard"]
    ] * 2
    assert tree_bytes(store.folder) == before


# --- plans ---


@pytest.mark.slow
def test_plan_of_a_study_counts_with_its_scatter_and_its_shared_inputs(done, ran):
    law = result_of(ran[1]).law("archard")
    (by_run,), (by_study,) = (plan_archived(done, name, "archard", 0.05, Recipe()) for name in (LIGHT, "air"))
    assert (by_run.id, by_study.id) == (LIGHT, LIGHT)
    assert by_run.scatter is None
    assert by_study.scatter == law.first.between_runs.scatter
    assert by_study.levers == by_run.levers


def test_plan_of_something_unknown_is_refused_with_the_nearest(done):
    with pytest.raises(ArchiveError, match=f"did you mean '{LIGHT}'"):
        plan_archived(done, "si3n4-air-200N", "archard", 0.05, Recipe())


@pytest.mark.parametrize("name", ["a/b", "../air", "", "con"])
def test_plan_of_what_cannot_be_an_id_is_refused(done, name):
    with pytest.raises(TribopipeError):
        plan_archived(done, name, "archard", 0.05, Recipe())


@pytest.mark.parametrize("name", [LIGHT, "air"])
def test_plan_from_nothing_but_bad_runs_is_refused(done, name):
    for run_id in (LIGHT, AGAIN):
        done.mark(run_id, BAD)
    with pytest.raises(TribopipeError, match="bad"):
        plan_archived(done, name, "archard", 0.05, Recipe())


def test_plan_of_a_run_without_end_value_is_refused(done):
    with pytest.raises(FitError, match=f"{NO_END}: found a run without a post-test measurement"):
        plan_archived(done, NO_END, "archard", 0.05, Recipe())


# --- documents ---


def test_studies_are_found_beside_runs_and_below(tmp_path):
    for name in ("study.toml", "b.study.toml", "deeper/still/study.toml", "study.txt", "mystudy.toml", "run.toml"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(study_toml(STUDY), encoding="utf-8")
    found = [path.relative_to(tmp_path).as_posix() for path in find_studies(tmp_path)]
    assert sorted(found) == ["b.study.toml", "deeper/still/study.toml", "study.toml"]
    assert find_studies(tmp_path / "study.toml") == []
    assert find_studies(tmp_path / "nowhere") == []


def test_two_documents_of_one_id_are_refused(tmp_path):
    paths = [tmp_path / "study.toml", tmp_path / "air.study.toml"]
    for path in paths:
        path.write_text(study_toml(STUDY), encoding="utf-8")
    with pytest.raises(TribopipeError) as refused:
        load_studies(paths)
    said = str(refused.value)
    assert "\n" not in said
    assert_says(said, *map(str, paths), "id: found 'air'", "expected a unique ID for each study", "change one")
    assert load_studies(paths[:1]) == [STUDY]


def test_document_met_twice_is_one_study(tmp_path):
    # As in `tribopipe process runs runs/`.
    (tmp_path / "study.toml").write_text(study_toml(STUDY), encoding="utf-8")
    assert load_studies([*find_studies(tmp_path), *find_studies(tmp_path)]) == [STUDY]


def manifest(run_id: str) -> RunManifest:
    return read_manifest(manifest_path(SAMPLES / run_id))[0]


@pytest.fixture(scope="module")
def manifests() -> list[RunManifest]:
    return [manifest(run_id) for run_id in SAMPLE_IDS]


def changed(original: RunManifest, run_id: str, *, radius: float | None = None, **pin) -> RunManifest:
    """A manifest of another id, with a pin changed."""
    document = original.model_dump(by_alias=True) | {"id": run_id}
    if radius is not None:
        pin["radius"] = {"value": radius, "unit": "m"}
    document["contact"]["pin"] |= pin
    return RunManifest.model_validate(document)


def test_drafts_for_the_sample_runs_are_the_sample_studies(manifests):
    paths = [SAMPLES / f"{name}.study.toml" for name in ("si3n4-air", "wc-co-water")]
    written = [load_toml(path, Study).model_copy(update={"end_of_life": None, "title": None}) for path in paths]
    for order in (manifests, manifests[::-1]):
        drafts = [draft.model_copy(update={"title": None}) for draft in draft_studies(order)]
        assert sorted(drafts, key=lambda draft: draft.id) == written


def test_every_sample_study_is_looked_at():
    assert {path.name for path in SAMPLES.glob("*.study.toml")} == {
        "si3n4-air.study.toml",
        "si3n4-twin-disc.study.toml",
        "wc-co-water.study.toml",
    }


def test_draft_for_the_twin_disc_samples_fits_the_least_slip(manifests):
    discs = [manifest(run_id) for run_id in DISC_IDS]
    for order in ([*manifests, *discs], [*discs[::-1], *manifests]):
        (draft,) = (one for one in draft_studies(order) if one.id == "si3n4-twin-disc-air")
        assert set(draft.fit) == {run_id for run_id in DISC_IDS if "-4pct-" in run_id}
        assert set(draft.predict) == {run_id for run_id in DISC_IDS if "-10pct-" in run_id}
        assert set(draft.shared) == {"curved_modulus", "flat_modulus"}
        assert len(draft_studies(order)) == 3
    # The sample study leaves to be predicted what goes on for longer, which no draft can know.
    sample = load_toml(SAMPLES / "si3n4-twin-disc.study.toml", Study)
    assert {*sample.fit, *sample.predict} == {*draft.fit, *draft.predict}
    assert set(sample.fit) < set(draft.fit)


def test_draft_tells_bodies_and_medium(manifests):
    assert {draft.title for draft in draft_studies(manifests)} == {
        "Si3N4 on Si3N4 in air",
        "WC-Co on WC-Co in water",
    }


def test_replicates_under_the_lightest_load_are_fitted_together():
    light, heavy = manifest(LIGHT), manifest(HEAVY)
    (draft,) = draft_studies([heavy, light, changed(light, AGAIN)])
    assert set(draft.fit) == {LIGHT, AGAIN}
    assert draft.predict == (HEAVY,)
    (same_load,) = draft_studies([light, changed(light, AGAIN)])
    assert (same_load.fit, same_load.predict) == ((LIGHT, AGAIN), ())


@pytest.mark.parametrize("kept", [[], [LIGHT], [LIGHT, "wc-co-water-400mN"]], ids=len)
def test_runs_that_do_not_belong_together_make_no_draft(kept):
    with pytest.raises(FitError, match=rf"found {len(kept)} runs, but no two with the same bodies"):
        draft_studies([manifest(run_id) for run_id in kept])


def test_drafts_of_the_same_materials_but_another_radius_have_ids_of_their_own():
    light, heavy = manifest(LIGHT), manifest(HEAVY)
    thick = [changed(one, f"thick-{one.id}", radius=2e-3) for one in (light, heavy)]
    drafts = draft_studies([light, heavy, *thick])
    assert len(drafts) == 2
    assert len({draft.id for draft in drafts}) == 2


@pytest.mark.parametrize("material", ["Siliciumnitrid, " * 10, "CON", "µ°", '"quoted" \\'])
def test_every_material_gives_a_draft(material):
    runs = [changed(manifest(run_id), run_id, material=material) for run_id in (LIGHT, HEAVY)]
    runs = [run.model_copy(update={"conditions": run.conditions.model_copy(update={"medium": None})}) for run in runs]
    (draft,) = draft_studies(runs)
    assert (draft.fit, draft.predict) == ((LIGHT,), (HEAVY,))


IDS = st.from_regex(r"r[A-Za-z0-9._+-]{0,20}[A-Za-z0-9]", fullmatch=True)
TEXTS = st.text(st.characters(codec="utf-8", exclude_characters="\0"), min_size=1, max_size=40)


def read_back(study: Study, folder: Path) -> Study:
    path = folder / "study.toml"
    path.write_bytes(study_toml(study).encode("utf-8"))
    return load_toml(path, Study)


@pytest.mark.slow
@settings(max_examples=50)
@given(
    st.lists(IDS, min_size=2, max_size=6, unique=True),
    TEXTS | st.sampled_from(['"', "\\", '"""', "a\\nb", "µ ≥ 3", "# no comment", "\u2028", "\ufeff", "'''"]),
    st.lists(st.sampled_from(["archard", "sarkar"]), min_size=1, max_size=2, unique=True),
    st.lists(st.sampled_from(["normal_load", "pin_radius", "depth_scale"]), unique=True),
)
def test_written_study_is_read_back(tmp_path_factory, ids, title, laws, shared):
    study = Study(
        id=ids[0], title=title, fit=ids[: len(ids) // 2], predict=ids[len(ids) // 2 :], laws=laws, shared=shared
    )
    assert read_back(study, tmp_path_factory.mktemp("document")) == study


@pytest.mark.parametrize("character", [*map(chr, range(1, 32)), "\x7f", "\x85"], ids=lambda sign: f"{ord(sign):02x}")
def test_control_characters_in_a_title_come_back(tmp_path, character):
    study = STUDY.model_copy(update={"title": f"a{character}b"})
    assert read_back(study, tmp_path) == study


def test_study_without_a_title_is_titled_by_its_id(tmp_path):
    study = STUDY.model_copy(update={"title": None})
    assert read_back(study, tmp_path) == STUDY.model_copy(update={"title": "air"})


@pytest.mark.parametrize(
    "depth", ["40 um", "2 um", "12.3456 um", "0.5 nm", "50 mm", {"value": "40 um", "standard_uncertainty": "1 um"}]
)
def test_end_of_life_comes_back(tmp_path, depth):
    study = Study.model_validate(STUDY.model_dump() | {"end_of_life": depth})
    assert read_back(study, tmp_path) == study


# --- the whole line ---


@pytest.mark.slow
def test_runs_of_a_study_are_predicted_by_it_alone(runs, tmp_path):
    store = Archive(tmp_path / "archive")
    recipe = Recipe(wear={"models": ["archard"]})
    folders = [runs / run_id for run_id in (LIGHT, AGAIN, HEAVY)]
    outcomes = list(process(folders, store, recipe, studied={LIGHT, AGAIN, HEAVY}))
    assert {outcome.stage for outcome in outcomes} == {
        *("ingest", "clean_up", "drift_correction", "friction_fit", "specific_wear", "wear_fit")
    }
    assert "prediction_archard" not in store.step_names(HEAVY)
    list(run_study(store, QUICK, recipe))
    by_study = store.result(HEAVY, "prediction_archard", WearPrediction)
    assert by_study.reference == "study air"
    again = list(process(folders, store, recipe, studied={LIGHT, AGAIN, HEAVY}))
    assert {outcome.status for outcome in again} == {"unchanged"}
    assert store.result(HEAVY, "prediction_archard", WearPrediction) == by_study
    partly = list(process(folders, store, recipe, studied={LIGHT, HEAVY}))
    assert [(one.run_id, one.result.reference) for one in partly if one.stage == "prediction"] == [(AGAIN, LIGHT)]

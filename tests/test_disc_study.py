"""Studies of twin-disc runs: simulated laboratories, verdicts, what is refused, and what the archive keeps."""

import shutil

import numpy as np
import pytest
from disc_runs import K_1, K_2, PLANNED, SERIES, exact_run, member, recipe
from folders import DISC_IDS, SAMPLES, tree_bytes
from scipy.stats import binom
from test_archive import nxcheck

from tribopipe.archive.store import Archive
from tribopipe.base.errors import FitError, TribopipeError
from tribopipe.documents.annotation import Mark
from tribopipe.documents.plan import Fatigue
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe
from tribopipe.documents.record import load_toml
from tribopipe.documents.study import Study
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.study.evaluate import evaluate, posed
from tribopipe.evaluation.study.further_tests import designs
from tribopipe.evaluation.study.member import Member
from tribopipe.pipeline.stages import ingest
from tribopipe.pipeline.studies import run_study
from tribopipe.results.study import StudyResult

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("few_draws")]

FITTED, SLIPPING, LONG = ("4pct-100k", "4pct-250k", "4pct-500k", "4pct-1000k"), "10pct-1000k-a", "4pct-2000k"
FALSE = ("over-predicts", "under-predicts")
CURVES = "tribopipe.evaluation.study.measured_runs._curves"
"""The curves of a study, which take most of the time and decide nothing."""
SAMPLE_STUDY = load_toml(SAMPLES / "si3n4-twin-disc.study.toml", Study)
DATE = "2026-07-01T10:00:00+00:00"


def laboratory(seed: int, fitted=FITTED, predicted=(SLIPPING,), factor: float | None = None):
    """The result of Archard's law of one simulated laboratory; in 2 million rotations k_D may change by a factor."""
    rng, members = np.random.default_rng([seed, 4]), {}
    for name in (*fitted, *predicted):
        fatigue = Fatigue(from_rotations=1_200_000, factor=factor) if factor and name == LONG else None
        run = PLANNED[name].model_copy(update={"id": name, "seed": int(rng.integers(2**31)), "fatigue": fatigue})
        members[name] = member(run)
    study = Study(id="lab", fit=fitted, predict=predicted, laws=("archard",))
    return evaluate(study, members).result.law("archard")


@pytest.fixture
def no_curves(monkeypatch) -> None:
    """Leave out the curves of a study."""
    monkeypatch.setattr(CURVES, lambda *_: [])


def of(law, name: str):
    return next(run for run in law.runs if run.id == name)


def exact_member(name: str, share: float = 0.05, **options) -> Member:
    """A run measured without error."""
    wanted = {"curved_disc_wear_volume": share, "flat_disc_wear_volume": share}
    run = exact_run(options.pop("wanted", wanted), **options)
    manifest = run.manifest.model_copy(update={"id": name})
    return Member(correct_drift(type(run)(manifest, run.columns, run.origins, {}, {}, ())), None)


# --- against the truth ---


@pytest.fixture(scope="module")
def labs() -> list:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tribopipe.physics.uncertainty.BLOCK", 400)
        patch.setattr(CURVES, lambda *_: [])
        return [laboratory(seed) for seed in range(3)]


def test_runs_at_4_percent_slip_give_both_k_d_back(labs):
    held = sum(
        disc.interval[0].value <= true <= disc.interval[1].value
        for law in labs
        for disc, true in zip(law.bodies.values(), (K_1, K_2), strict=True)
    )
    assert held >= 4
    for law in labs:
        assert [*law.bodies] == ["curved_disc", "flat_disc"]
        for disc, true in zip(law.bodies.values(), (K_1, K_2), strict=True):
            assert disc.wear_coefficient.value == pytest.approx(true, rel=0.2)
            assert disc.wear_coefficient.standard_uncertainty < 0.12 * true
            assert disc.between_runs.runs == 4


def test_run_at_10_percent_slip_is_predicted_within_its_band(labs):
    inside, total = 0, 0
    for law in labs:
        run = of(law, SLIPPING)
        assert (run.role, run.end.value) == ("predicted", pytest.approx(1e6))
        for disc in run.bodies.values():
            low, high = (end.value for end in disc.measurement_interval)
            inside, total = inside + (low <= disc.measured.value <= high), total + 1
            assert disc.what == "wear_volume"
            assert abs(disc.e_n) < 1.5
    assert inside >= total - 2
    assert [of(law, SLIPPING).outcome for law in labs if of(law, SLIPPING).outcome in FALSE] == []


@pytest.mark.parametrize(("factor", "called"), [(3.0, "under-predicts"), (0.1, "over-predicts")])
def test_fatigue_at_high_rotations_is_called(factor, called):
    run = of(laboratory(7, ("4pct-500k", "4pct-1000k"), (LONG,), factor), LONG)
    assert run.outcome == called
    assert f"{called} the wear at 250 mN and 4.00 % slip" in run.sentence or called in run.sentence
    assert "fitted alone, this run gives" in run.sentence
    for disc in run.bodies.values():
        assert (disc.e_n > 1) == (called == "under-predicts")
        assert (disc.coefficient_ratio.value > 1) == (called == "under-predicts")


@pytest.mark.slow
@pytest.mark.usefixtures("no_curves")
def test_sound_laboratories_seldom_call_the_law_off(monkeypatch):
    """A sound run is called off in about one of a hundred: 5 runs in each of 30 laboratories."""
    monkeypatch.setattr("tribopipe.physics.uncertainty.BLOCK", 1_000)
    count, alarms, held = 30, 0, [0, 0]
    for seed in range(count):
        law = laboratory(1_000 + seed)
        alarms += sum(run.outcome in FALSE for run in law.runs)
        for place, true in enumerate((K_1, K_2)):
            low, high = [*law.bodies.values()][place].interval
            held[place] += low.value <= true <= high.value
    assert binom.sf(alarms - 1, 5 * count, 0.01) > 0.005, alarms
    assert min(binom.cdf(one, count, 0.95) for one in held) > 0.002, held


@pytest.mark.slow
@pytest.mark.usefixtures("no_curves")
@pytest.mark.parametrize(("factor", "called"), [(3.0, "under-predicts"), (0.1, "over-predicts")])
def test_fatigue_is_called_in_most_laboratories(factor, called):
    outcomes = [of(laboratory(seed, FITTED, (LONG,), factor), LONG).outcome for seed in range(10)]
    assert outcomes.count(called) >= 8, outcomes
    assert not set(outcomes) & (set(FALSE) - {called})


# --- without noise ---


@pytest.mark.slow
def test_exact_runs_give_exactly_their_k_d_and_are_supported():
    members = {name: exact_member(name, rotations=turns) for name, turns in (("a", 2e5), ("b", 1e6), ("c", 2e6))}
    law = evaluate(Study(id="s", fit=("a", "b"), predict=("c",), laws=("archard",)), members).result.laws[0]
    assert [disc.wear_coefficient.value for disc in law.bodies.values()] == pytest.approx([K_1, K_2], rel=1e-8)
    for run in law.runs:
        assert run.outcome == "supported"
        for disc in run.bodies.values():
            assert disc.e_n == pytest.approx(0.0, abs=1e-6)
            assert disc.coefficient_ratio.value == pytest.approx(1.0, rel=1e-8)


@pytest.mark.parametrize(("factor", "called"), [(4.0, "under-predicts"), (0.25, "over-predicts")])
def test_departure_of_one_disc_calls_the_run_off(factor, called):
    members = {"a": exact_member("a"), "b": exact_member("b", second=factor * K_2)}
    law = evaluate(Study(id="s", fit=("a",), predict=("b",), laws=("archard",)), members).result.laws[0]
    run = of(law, "b")
    assert run.outcome == called
    assert run.bodies["flat_disc"].outcome == called


def test_vague_measurement_decides_nothing():
    members = {"a": exact_member("a"), "b": exact_member("b", share=0.9)}
    law = evaluate(Study(id="s", fit=("a",), predict=("b",), laws=("archard",)), members).result.laws[0]
    assert of(law, "b").outcome == "not decidable"


def test_life_ends_where_the_curved_disc_reaches_the_depth():
    members = {"a": exact_member("a")}
    study = Study(id="s", fit=("a",), laws=("archard",), end_of_life=Quantity(value=2e-6, unit="m"))
    life = of(evaluate(study, members).result.laws[0], "a").end_of_life
    from disc_runs import worn

    turns = life.place.value
    assert float(worn(turns).curved_depth) == pytest.approx(2e-6, rel=0.05)
    assert life.interval[0].value < turns < life.interval[1].value


def test_one_sided_runs_make_a_one_sided_study():
    wanted = {"curved_disc_wear_volume": 0.05}
    members = {name: exact_member(name, wanted=wanted, second=0.0) for name in ("a", "b")}
    law = evaluate(Study(id="s", fit=("a",), predict=("b",), laws=("archard",)), members).result.laws[0]
    assert [*law.bodies] == ["curved_disc"]
    assert law.correlation is None
    assert [len(run.bodies) for run in law.runs] == [1, 1]


def test_one_run_alone_owns_up_to_what_is_not_known():
    result = evaluate(Study(id="s", fit=("a",), laws=("archard",)), {"a": exact_member("a")}).result
    assert result.notes[0].startswith("k_D is identified from a single run, a: ")


UNSEEN = 1e-13
"""Standard uncertainty of the volume of an unworn flat disc, m³."""


def unworn_flat_disc(name: str) -> Member:
    raw = exact_member(name, second=0.0).corrected.run
    none = raw.manifest.end_values.flat_disc_wear_volume.model_copy(update={"standard_uncertainty": UNSEEN})
    ends = raw.manifest.end_values.model_copy(update={"flat_disc_wear_volume": none})
    manifest = raw.manifest.model_copy(update={"end_values": ends})
    return Member(correct_drift(type(raw)(manifest, raw.columns, raw.origins, {}, {}, ())), None)


def test_plan_of_a_flat_disc_without_wear_says_so_with_what_would_have_been_noticed():
    run = posed(unworn_flat_disc("a"), "archard", Recipe())
    curved, flat = designs(run, "archard", 0.05)
    assert curved.half_width > 0
    found = flat.wear_coefficient
    # V = k·F_N·s of the flat disc.
    lost = float(run.problem.modelled(np.array([curved.wear_coefficient.value, 1e-19]), run.problem.values)[-1])
    assert (found.value, flat.half_width) == (0.0, None)
    assert found.standard_uncertainty == pytest.approx(1e-19 * UNSEEN / lost, rel=0.02)


def test_study_of_flat_discs_on_which_no_wear_was_found_is_refused_in_one_sentence():
    members = {name: unworn_flat_disc(name) for name in ("a", "b")}
    with pytest.raises(
        FitError, match="s: found no wear of the cylindrical disc in any run from which k_D is identified"
    ):
        evaluate(Study(id="s", fit=("a",), predict=("b",), laws=("archard",)), members)


# --- refused ---


def test_flat_disc_measured_in_some_fitted_runs_only_is_refused():
    members = {"a": exact_member("a"), "b": exact_member("b", wanted={"curved_disc_wear_volume": 0.05})}
    with pytest.raises(
        FitError, match="s: found no measurement of the cylindrical disc in b, although other runs have one"
    ):
        evaluate(Study(id="s", fit=("a", "b"), laws=("archard",)), members)


def test_run_without_end_values_is_refused_by_name():
    members = {"a": exact_member("a"), "b": exact_member("b", wanted={})}
    for study in (Study(id="s", fit=("a",), predict=("b",)), Study(id="s", fit=("b",))):
        with pytest.raises(FitError, match="b: found a run without a post-test measurement of the crowned disc"):
            evaluate(study.model_copy(update={"laws": ("archard",)}), members)


def test_run_without_wear_is_refused_by_name():
    blank = exact_member("b").corrected.run
    ends = blank.manifest.end_values
    none = ends.curved_disc_wear_volume.model_copy(update={"value": 0.0, "standard_uncertainty": 1e-13})
    manifest = blank.manifest.model_copy(
        update={"end_values": ends.model_copy(update={"curved_disc_wear_volume": none})}
    )
    raw = type(blank)(manifest, blank.columns, blank.origins, {}, {}, ())
    members = {"a": exact_member("a"), "b": Member(correct_drift(raw), None)}
    with pytest.raises(TribopipeError, match=r"\bb: "):
        evaluate(Study(id="s", fit=("a",), predict=("b",), laws=("archard",)), members)


@pytest.mark.parametrize(
    ("where", "key", "value", "words"),
    [
        ("curved_disc", "crown_radius", 5e-3, "crown radius in m"),
        ("flat_disc", "rolling_radius", 5e-3, "cylindrical disc's radius in m"),
    ],
)
def test_runs_of_other_discs_are_refused(where, key, value, words):
    one, other = exact_member("a"), exact_member("b").corrected.run
    disc = getattr(other.manifest.contact, where).model_copy(update={key: Quantity(value=value, unit="m")})
    contact = other.manifest.contact.model_copy(update={where: disc})
    manifest = other.manifest.model_copy(update={"contact": contact})
    raw = type(other)(manifest, other.columns, other.origins, {}, {}, ())
    members = {"a": one, "b": Member(correct_drift(raw), None)}
    with pytest.raises(FitError, match=f"s: found {words} 0.005 in b and 0.004 in a; expected the same materials"):
        evaluate(Study(id="s", fit=("a", "b"), laws=("archard",)), members)


# --- in the archive ---


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """All disc samples ingested and their study run; not to be written into."""
    store = Archive(tmp_path_factory.mktemp("kept") / "archive")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tribopipe.physics.uncertainty.BLOCK", 200)
        for run_id in DISC_IDS:
            ingest(SAMPLES / run_id, store)
        outcomes = list(run_study(store, SAMPLE_STUDY, Recipe()))
    assert [one for one in outcomes if one.status == "failed"] == []
    return store, outcomes


@pytest.fixture
def store(kept, tmp_path) -> Archive:
    return Archive(shutil.copytree(kept[0].folder, tmp_path / "archive"))


def test_sample_study_tells_the_story_of_the_paper(kept):
    law = kept[1][0].result.law("archard")
    assert [disc.wear_coefficient.value for disc in law.bodies.values()] == pytest.approx([K_1, K_2], rel=0.15)
    for disc, true in zip(law.bodies.values(), (K_1, K_2), strict=True):
        assert disc.interval[0].value < true < disc.interval[1].value
    told = {run.id.removeprefix("si3n4-twin-disc-"): run for run in law.runs}
    assert told[LONG].outcome == "under-predicts"
    assert told["10pct-1000k-a"].outcome not in FALSE
    assert told["10pct-1000k-b"].outcome not in FALSE
    assert [told[name].role for name in FITTED] == ["fitted"] * 4


def test_study_comes_back_from_the_archive(kept):
    store, outcomes = kept
    stored = store.study("si3n4-twin-disc")
    assert isinstance(stored.result, StudyResult)
    assert (stored.result, stored.study) == (outcomes[0].result, SAMPLE_STUDY)
    assert {(one.run_id, one.body) for one in stored.curves} == {
        (run_id, disc) for run_id in DISC_IDS for disc in ("curved_disc", "flat_disc")
    }
    for curve in stored.curves:
        assert np.all(curve.lower <= curve.upper)
        assert np.all(np.diff(curve.places) > 0)


@pytest.mark.slow
def test_curves_are_those_evaluated(kept):
    store, _ = kept
    from tribopipe.pipeline.studies import evaluate_archived

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tribopipe.physics.uncertainty.BLOCK", 200)
        again = evaluate_archived(store, SAMPLE_STUDY, Recipe())
    assert again.result == store.study("si3n4-twin-disc").result
    for mine, theirs in zip(again.curves, store.study("si3n4-twin-disc").curves, strict=True):
        assert (mine.run_id, mine.model, mine.role, mine.body) == (
            theirs.run_id,
            theirs.model,
            theirs.role,
            theirs.body,
        )
        for name in ("places", "predicted", "lower", "upper"):
            np.testing.assert_allclose(getattr(mine, name), getattr(theirs, name), rtol=1e-14)


def test_study_and_its_runs_conform_to_nexus(kept):
    store, _ = kept
    for path in (*(store.folder / "studies").glob("*"), store.path("si3n4-twin-disc-10pct-1000k-a")):
        warnings, errors, printed = nxcheck(path)
        assert (warnings, errors) == (0, 0), printed
    assert list((store.folder / "studies").glob("*"))


def test_second_run_of_a_study_does_nothing(store):
    before = tree_bytes(store.folder)
    assert {one.status for one in run_study(store, SAMPLE_STUDY, Recipe())} == {"unchanged"}
    assert tree_bytes(store.folder) == before


def test_predictions_go_into_the_runs(kept):
    store, _ = kept
    law = store.study("si3n4-twin-disc").result.law("archard")
    for run_id in SAMPLE_STUDY.predict:
        prediction = store.step(run_id, "prediction_archard").result
        assert prediction.reference == "study si3n4-twin-disc"
        assert prediction.bodies["curved_disc"].wear_coefficient.value == law.first.wear_coefficient.value
        (point,) = prediction.prediction
        told = of(law, run_id).first.predicted
        assert point.bodies["curved_disc"].wear_volume.value == pytest.approx(told.value, rel=1e-9)
        assert {"depth", "curved_volume", "flat_volume_upper"} <= set(store.step(run_id, "prediction_archard").curves)


@pytest.mark.slow
def test_run_marked_bad_is_left_out(store):
    bad = SAMPLE_STUDY.fit[0]
    store.mark(bad, Mark(kind="bad", reason="the discs jumped", date=DATE))
    first, *_ = run_study(store, SAMPLE_STUDY, Recipe())
    assert first.status == "done"
    assert [(one.id, one.reason) for one in first.result.left_out] == [(bad, "marked bad: the discs jumped")]
    law = first.result.law("archard")
    assert bad not in {run.id for run in law.runs}
    assert law.first.between_runs.runs == 3


@pytest.mark.slow
def test_mixture_of_a_pin_and_discs_is_refused_in_one_sentence(store):
    ingest(SAMPLES / "si3n4-air-200mN", store)
    before = tree_bytes(store.folder)
    for fit, predict in (
        (("si3n4-air-200mN",), (DISC_IDS[0],)),
        ((DISC_IDS[0],), ("si3n4-air-200mN",)),
        ((DISC_IDS[0], "si3n4-air-200mN"), ()),
    ):
        (outcome,) = run_study(store, Study(id="mixed", fit=fit, predict=predict, laws=("archard",)), Recipe())
        assert outcome.status == "failed"
        assert str(outcome.error).startswith("mixed: found contact ")
        assert "twin-disc" in str(outcome.error)
        assert "pin-on-disc" in str(outcome.error)
        assert "\n" not in str(outcome.error)
    assert tree_bytes(store.folder) == before


@pytest.mark.slow
def test_another_convention_is_another_study(store):
    short = SAMPLE_STUDY.model_copy(update={"fit": SAMPLE_STUDY.fit[:1], "predict": SAMPLE_STUDY.predict[:1]})
    assert {one.status for one in run_study(store, short, Recipe()) if one.stage == "study"} == {"done"}
    first, *rest = run_study(store, short, recipe("volume-conserving"))
    assert first.status == "done"
    assert first.result.law("archard").distance_per_rotation == "volume-conserving"
    assert {one.status for one in rest if one.stage == "prediction"} == {"done"}
    assert SERIES.distance_per_rotation == "full-slip"

"""study.toml: which runs identify a wear law and which ones it has to predict, and what a wrong one is told."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from tribopipe.base.errors import ManifestError
from tribopipe.documents.record import load_toml, read_document
from tribopipe.documents.study import Study

MINIMAL = {"schema": "tribopipe.study/1", "id": "si3n4", "fit": ["a"]}
IDS = st.text("abcdefgh0123456789", min_size=1, max_size=8)
WRITTEN = """
schema = "tribopipe.study/1"
id = "si3n4-air"
title = "Does the law from 200 mN hold at 800 mN?"
fit = ["si3n4-air-200mN", "si3n4-air-400mN"]
predict = ["si3n4-air-800mN"]
laws = ["sarkar"]
shared = ["normal_load", "depth_scale"]
end_of_life = "20 um"
"""


def refusal(**changes) -> str:
    """The sentence for a document with these keys changed; None takes a key out."""
    document = {key: value for key, value in (MINIMAL | changes).items() if value is not None}
    with pytest.raises(ManifestError) as refused:
        read_document(document, Study, where="study.toml")
    said = str(refused.value)
    assert "\n" not in said
    assert said.startswith("study.toml: ")
    return said


def test_a_study_is_read_from_toml_in_si(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text(WRITTEN, encoding="utf-8")
    study = load_toml(path, Study)
    assert (study.id, study.title) == ("si3n4-air", "Does the law from 200 mN hold at 800 mN?")
    assert study.fit == ("si3n4-air-200mN", "si3n4-air-400mN")
    assert study.predict == ("si3n4-air-800mN",)
    assert study.laws == ("sarkar",)
    assert study.shared == ("normal_load", "depth_scale")
    assert study.end_of_life.value == pytest.approx(20e-6, rel=1e-15)
    assert study.end_of_life.unit == "m"


def test_the_least_study_takes_both_laws_and_shares_what_one_material_shares():
    study = read_document(MINIMAL, Study, where="study.toml")
    assert study.laws == ("archard", "sarkar")
    assert study.shared == ("pin_modulus", "disc_modulus", "curved_modulus", "flat_modulus")
    assert (study.predict, study.end_of_life, study.title) == ((), None, None)


def test_a_study_that_shares_nothing_may_say_so():
    assert read_document(MINIMAL | {"shared": []}, Study, where="study.toml").shared == ()


def test_a_study_comes_back_from_its_own_json():
    study = read_document(MINIMAL | {"end_of_life": "1.5 um", "predict": ["b"]}, Study, where="study.toml")
    document = json.loads(study.model_dump_json(by_alias=True))
    assert document["schema"] == "tribopipe.study/1"
    assert read_document(document, Study, where="study.toml") == study


def test_a_study_cannot_change():
    study = read_document(MINIMAL, Study, where="study.toml")
    with pytest.raises(ValidationError, match="frozen"):
        study.fit = ("b",)


# --- each run has one place ---


def test_a_run_that_is_both_fitted_and_predicted_is_refused_by_name():
    said = refusal(fit=["light", "heavy"], predict=["other", "heavy"])
    assert "found 'heavy', which is also in fit" in said
    assert "remove the run from one of the two" in said
    assert "'other'" not in said
    assert "light" not in said


@pytest.mark.parametrize("role", ["fit", "predict"])
def test_a_run_that_stands_twice_in_one_list_is_refused_by_name(role):
    said = refusal(**{"fit": ["x"], role: ["a", "b", "c", "b"]})
    assert f"{role}: found 'b' twice; expected each entry once" in said


@given(fit=st.lists(IDS, min_size=1, max_size=6), predict=st.lists(IDS, max_size=6))
def test_a_study_is_accepted_exactly_where_each_run_has_one_place(fit, predict):
    document = MINIMAL | {"fit": fit, "predict": predict}
    if len({*fit, *predict}) == len(fit) + len(predict):
        study = read_document(document, Study, where="study.toml")
        assert (study.fit, study.predict) == (tuple(fit), tuple(predict))
    else:
        with pytest.raises(ManifestError) as refused:
            read_document(document, Study, where="study.toml")
        wrong = [run_id for run_id in {*fit, *predict} if (fit + predict).count(run_id) > 1]
        assert any(f"found {run_id!r}" in str(refused.value) for run_id in wrong)


# --- what is missing, mistyped or of the wrong kind ---


def test_a_study_that_fits_nothing_is_refused():
    said = refusal(fit=[])
    assert "fit: " in said
    assert "at least 1" in said


@pytest.mark.parametrize("key", ["id", "fit"])
def test_a_study_without_what_it_needs_says_which_key_is_missing(key):
    assert f"{key}: missing; add this key" in refusal(**{key: None})


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("predicts", "predict"),
        ("law", "laws"),
        ("shard", "shared"),
        ("end_of_live", "end_of_life"),
        ("tittle", "title"),
    ],
)
def test_an_unknown_key_is_refused_with_the_one_that_was_meant(written, meant):
    said = refusal(**{written: ["b"]})
    assert f"{written}: unknown key" in said
    assert "did you mean" in said
    assert f"'{meant}'" in said


def test_a_mistyped_fit_is_named_rather_than_only_missed():
    said = refusal(fit=None, fitt=["a"])
    assert "fitt: unknown key" in said
    assert "'fit'" in said


@pytest.mark.parametrize("bare", [20, 20e-6])
def test_an_end_of_life_without_a_unit_is_refused(bare):
    said = refusal(end_of_life=bare)
    assert f"end_of_life: found the number {bare!r} without a unit; expected a value with its unit" in said


@pytest.mark.parametrize("written", ["20 mN", "0 um", "-3 um", "deep"])
def test_an_end_of_life_that_is_no_depth_is_refused(written):
    assert "end_of_life: found" in refusal(end_of_life=written)


@pytest.mark.parametrize("laws", [["holm"], ["archard", "Sarkar"]])
def test_an_unknown_law_is_refused_with_the_known_ones(laws):
    said = refusal(laws=laws)
    assert f"laws[{len(laws) - 1}]: found the wear law {laws[-1]!r}, which is not installed" in said
    assert "available: archard, dissipated_energy, running_in, sarkar" in said or "did you mean 'sarkar'?" in said


def test_a_study_without_a_law_is_refused():
    assert "laws: " in refusal(laws=[])


def test_an_unknown_shared_input_is_refused_with_the_known_ones():
    said = refusal(shared=["normal_load", "end_reading"])
    assert "shared[1]: found 'end_reading'; expected " in said
    assert [name for name in ("normal_load", "pin_radius", "depth_scale", "sliding_speed") if name not in said] == []


@pytest.mark.parametrize("run_id", ["../secret", "a/b", "", "con"])
@pytest.mark.parametrize("key", ["fit", "predict"])
def test_a_name_that_no_run_can_have_is_refused(key, run_id):
    assert f"{key}[0]: found {run_id!r}" in refusal(**{"fit": ["x"], key: [run_id]})


def test_a_study_of_another_version_is_refused():
    said = refusal(schema="tribopipe.study/2")
    assert "schema: found 'tribopipe.study/2'; expected 'tribopipe.study/1'" in said

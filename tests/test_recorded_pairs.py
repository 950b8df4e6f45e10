"""Studies of runs with a depth signal in which both bodies wear: k_D of both, and a law held against both."""

from dataclasses import replace

import numpy as np
import pytest
from groove_and_depth_signal import MEASURED, PAIRS, RELATIVE, Truth, run_of
from test_volume_studies import QUICK

from tribopipe.documents.study import Study
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.study.evaluate import evaluate, posed
from tribopipe.evaluation.study.further_tests import designs
from tribopipe.evaluation.study.member import Member
from tribopipe.evaluation.study.recorded_pairs import RecordedPair
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.views.study_figures import plot_study_wear

K_BALL, K_DISC = PAIRS["both bodies"]
TRUTH = Truth(K_BALL, K_DISC)


def member(name: str, truth: Truth = TRUTH, measured: tuple[str, ...] = ("scar", "groove")) -> Member:
    """A run as a laboratory writes it down, with a scar on the ball, the depth of the groove or both measured."""
    manifests = []
    for one in measured:
        raw = run_of(truth, MEASURED[one], np.random.default_rng(len(name)), settles=False)
        manifests.append(raw.manifest)
    known = {MEASURED[one].key: manifest.end_values for one, manifest in zip(measured, manifests, strict=True)}
    ends = manifests[0].end_values.model_copy(update={key: getattr(end, key) for key, end in known.items()})
    manifest = raw.manifest.model_copy(update={"id": name, "end_values": ends})
    return Member(correct_drift(replace(raw, manifest=manifest), QUICK), None)


def studied(fit, predict=(), **more):
    members = {one.id: one for one in (*fit, *predict)}
    document = {"id": "pairs", "fit": [one.id for one in fit], "predict": [one.id for one in predict]}
    study = Study.model_validate({"schema": "tribopipe.study/1", "laws": ["archard"], **document, **more})
    return evaluate(study, members, QUICK)


@pytest.mark.slow
@pytest.mark.parametrize("measured", [("scar",), ("groove",), ("scar", "groove")])
def test_one_run_has_the_k_d_of_its_own_fit(measured):
    one = member("one", measured=measured)
    law, alone = studied([one]).result.laws[0], fit_wear(one.corrected, "archard", recipe=QUICK)
    assert list(law.bodies) == ["pin", "disc"]
    for body, found in law.bodies.items():
        own = alone.bodies[body].wear_coefficient
        assert found.wear_coefficient.value == pytest.approx(own.value, rel=1e-5)
        assert found.wear_coefficient.standard_uncertainty == pytest.approx(own.standard_uncertainty, rel=0.15)
    assert law.correlation == pytest.approx(alone.correlation, abs=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("measured", [("scar",), ("groove",), ("scar", "groove")])
def test_both_k_d_are_found_and_predict_a_run_of_both(measured):
    fit = [member("a" * n, measured=measured) for n in (1, 2, 3)]
    evaluation = studied(fit, [member("heavy", measured=measured)])
    law = evaluation.result.laws[0]
    for body, truth in (("pin", K_BALL), ("disc", K_DISC)):
        found = law.bodies[body].wear_coefficient
        assert abs(found.value - truth) < 3 * found.standard_uncertainty
    seen = {body: one.what for body, one in law.runs[-1].bodies.items()}
    assert seen == {"pin": "wear_depth" if "scar" in measured else "wear_volume", "disc": "wear_volume"}
    assert law.runs[-1].outcome == "supported"
    assert len(plot_study_wear(evaluation.result, "archard", evaluation.curves).axes) >= 2


@pytest.mark.slow
@pytest.mark.parametrize("body", ["pin", "disc"])
def test_a_law_is_rejected_for_the_body_it_fails_for(body):
    changed = Truth(K_BALL * 3, K_DISC) if body == "pin" else Truth(K_BALL, K_DISC * 3)
    (fitted, odd) = studied([member("one")], [member("other", changed)]).result.laws[0].runs
    assert fitted.outcome == "supported"
    assert odd.bodies[body].outcome == "under-predicts"
    assert odd.outcome == "under-predicts"


def test_what_both_bodies_depend_on_is_drawn_once():
    pair = posed(member("one"), "archard", QUICK)
    assert isinstance(pair, RecordedPair)
    drawn = pair.draw(np.random.default_rng(1), 500, {})
    assert np.all(drawn.pin.values["normal_load"] == drawn.counterbody.values["normal_load"])
    assert np.std(drawn.pin.values["normal_load"]) > 0.5 * RELATIVE["load"] * np.mean(drawn.pin.values["normal_load"])


@pytest.mark.slow
@pytest.mark.parametrize("measured", [("scar",), ("groove",), ("scar", "groove")])
def test_a_plan_tells_of_both(measured):
    plans = designs(posed(member("one", measured=measured), "archard", QUICK), "archard", 0.05)
    assert [plan.of for plan in plans] == ["k_D of the pin", "k_D of the disc"]


@pytest.mark.slow
def test_bodies_that_one_run_did_not_measure_are_left_to_the_others():
    both, pin = member("both"), member("pin", Truth(K_BALL, 0.0), measured=("scar",))
    assert list(studied([both, pin]).result.laws[0].bodies) == ["pin"]

"""Agreement of a law with runs: its classes by hand-made deviations, and on a few virtual runs whose truth is known."""

from dataclasses import replace

import numpy as np
import pytest
from test_identify import CASES, record

from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.quantity import EndValue, Quantity
from tribopipe.documents.recipe import Recipe, WearRecipe
from tribopipe.documents.study import Study
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.friction import fit_friction
from tribopipe.evaluation.study.evaluate import evaluate
from tribopipe.evaluation.study.member import Member
from tribopipe.evaluation.study.verdict import Comparison, decide, ratio
from tribopipe.results.run import RawRun
from tribopipe.results.study import RunVerdict

LAW = 10e-6
"""Depth that the law predicts, m."""
SCORES = np.linspace(0, 1, 20_001)
"""Probabilities of draws, evenly spaced: quantiles of what is made of them are known."""
BELOW, ABOVE = 1e-6, 3e-6
"""How far a measured depth may be off below and above, m: ends of a rectangular distribution with an edge at 0."""


def lopsided(deviation: float) -> Comparison:
    """One place, where a draw is off by −1 µm to 0 in one half of the cases and by 0 to 3 µm in the other."""
    errors = np.interp(SCORES, [0, 0.5, 1], [-BELOW, 0.0, ABOVE])[:, None]
    measured = np.array([LAW + deviation])
    return Comparison(measured, np.array([LAW]), measured + errors, np.full_like(errors, LAW))


def by_root(factor: float) -> np.ndarray:
    """Depth of a sphere, which grows with the root of k_D."""
    return np.array([LAW * factor**0.5])


@pytest.mark.parametrize(("level", "tail"), [(0.05, 0.025), (0.005, 0.0025)])
def test_limits_are_those_on_the_side_towards_agreement(level, tail):
    # A depth measured above the law agrees with it where the measurement may be too high by as much: the lower tail.
    assert lopsided(0.5e-6).limits(level)[0] == pytest.approx(BELOW * (1 - 2 * tail), rel=1e-9)
    assert lopsided(-0.5e-6).limits(level)[0] == pytest.approx(ABOVE * (1 - 2 * tail), rel=1e-9)


@pytest.mark.parametrize(
    ("deviation", "outcome"),
    [
        (0.94e-6, "supported"),
        (0.97e-6, "not decidable"),
        (0.999e-6, "under-predicts"),
        (-0.999e-6, "supported"),
        (-2.84e-6, "supported"),
        (-2.90e-6, "not decidable"),
        (-2.999e-6, "over-predicts"),
    ],
)
def test_a_law_is_called_off_on_either_side_by_the_limits_of_that_side(deviation, outcome):
    # 95 % limits are at 0.95 and 2.85 µm, those beyond which a law is called off at 0.995 and 2.985 µm.
    assert decide(lopsided(deviation), by_root) == outcome


def test_nothing_is_decided_where_twice_the_k_d_would_go_unnoticed():
    # √2 of 1 µm, and its half, are within what the measurement may be off by.
    assert decide(lopsided(0.0), lambda factor: 0.1 * by_root(factor)) == "not decidable"
    assert decide(lopsided(0.0), by_root) == "supported"


def along_the_curve(height: float, places: int = 5) -> Comparison:
    """Agreement at the end, and a deviation in the middle of the curve; errors of the places are independent."""
    errors = 1e-6 * np.random.default_rng(3).standard_normal((20_000, places))
    measured = np.full(places, LAW)
    measured[places // 2] += height
    return Comparison(measured, np.full(places, LAW), measured + errors, np.full_like(errors, LAW))


@pytest.mark.parametrize(
    ("deviations", "outcome"),
    [
        (2.2, "supported"),
        (2.8, "not decidable"),
        (4.0, "under-predicts"),
        (-2.8, "not decidable"),
        (-4.0, "over-predicts"),
    ],
)
def test_a_curve_is_held_against_limits_that_hold_anywhere_along_it(deviations, outcome):
    # Of five independent places 95 % of curves keep to 2.57 standard deviations, 99.5 % to 3.29 (Šidák).
    told = decide(along_the_curve(1e-6 * deviations), lambda factor: np.full(5, float(by_root(factor)[0])))
    assert told == outcome


@pytest.mark.parametrize(("least", "outcome"), [(3.9e-6, "under-predicts"), (4.1e-6, "supported")])
def test_a_departure_along_the_curve_matters_where_the_end_is_known_as_well(least, outcome):
    curve = replace(along_the_curve(4e-6), least=least)
    assert decide(curve, lambda factor: np.full(5, float(by_root(factor)[0]))) == outcome


def test_simultaneous_limits_of_independent_places_are_those_of_sidak():
    reached = along_the_curve(1e-6).along(0.05)[2]
    assert 1 / reached == pytest.approx(2.569, rel=0.02)


def test_ratio_of_k_d_is_as_uncertain_as_the_middle_of_its_draws():
    # A uniform distribution from 0.8 to 1.2 has 68.3 % within 0.4·0.683.
    drawn = 0.8 + 0.4 * SCORES
    found = ratio(2e-15, 2e-15 * drawn, 4e-15, np.full_like(drawn, 4e-15))
    assert found.value == pytest.approx(0.5)
    assert found.standard_uncertainty == pytest.approx(0.5 * 0.4 * 0.682690 / 2, rel=1e-3)


# --- runs whose truth is known ---

LIGHT, HEAVY = (CASES[f"si3n4-air-{load}mN"] for load in (200, 400))
TRUE = LIGHT[1].wear_coefficient.value


def member(case, name: str, wear_coefficient: float = TRUE, **changes) -> Member:
    """A virtual run with this k_D, m²/N, corrected."""
    k_d = Quantity(value=wear_coefficient, unit="m^2/N")
    sensors = {"sampling_rate": Quantity(value=0.5, unit="1/s")} | changes.pop("sensors", {})
    raw = record(*case, id=name, wear_coefficient=k_d, sensors=sensors, **changes)
    conditions = raw.manifest.conditions.model_copy(update={"medium": "air"})
    raw = replace(raw, manifest=raw.manifest.model_copy(update={"conditions": conditions}))
    return Member(correct_drift(raw, TWO_STEP), fit_friction(raw))


TWO_STEP = Recipe(wear=WearRecipe(correction="two-step"))


@pytest.fixture(scope="module")
def reference() -> Member:
    """The run that identifies k_D."""
    return member(LIGHT, "light", seed=1)


def told(reference: Member, other: Member, recipe: Recipe = TWO_STEP) -> RunVerdict:
    """What a study says of another run by the law of the reference."""
    study = Study(id="a-study", fit=["light"], predict=[other.id], laws=["archard"])
    return evaluate(study, {"light": reference, other.id: other}, recipe).result.law("archard").runs[1]


@pytest.mark.slow
@pytest.mark.usefixtures("few_draws")
@pytest.mark.parametrize(
    ("share", "outcome", "sign"), [(1.0, "supported", 0), (0.5, "over-predicts", -1), (2.0, "under-predicts", 1)]
)
def test_a_run_of_the_same_k_d_supports_the_law_and_one_of_another_does_not(reference, share, outcome, sign):
    found = told(reference, member(HEAVY, "heavy", share * TRUE, seed=2))
    assert found.outcome == outcome
    assert abs(found.first.coefficient_ratio.value - share) < 3 * found.first.coefficient_ratio.standard_uncertainty
    if sign:
        assert sign * found.first.e_n > 1
        assert sign * (found.first.measured.value - found.first.predicted.value) > 0
        assert f" {outcome} the wear at 400 mN" in found.sentence
    else:
        assert abs(found.first.e_n) < 1


@pytest.mark.slow
@pytest.mark.usefixtures("few_draws")
def test_a_run_that_nobody_can_tell_from_one_of_twice_the_k_d_decides_nothing(reference):
    vague = {"scar_uncertainty": EndValue(value=150e-6, unit="m"), "depth_noise": EndValue(value=300e-6, unit="m")}
    found = told(reference, member(HEAVY, "heavy", seed=2, sensors=vague), Recipe())
    assert found.outcome == "not decidable"
    assert found.sentence.startswith("Agreement with Archard's law at 400 mN is inconclusive")


def rigid(load: float) -> Member:
    """A steel ball that wears as a rigid one by Archard's law, under a sensor with 30 nm of noise and 30 nm/min drift.

    The model's elastic deflection, 0.15 µm at the start, is resolved by that noise; it is 0.2 % of the wear.
    """
    radius, time = 3e-3, np.arange(0.0, 3600.0, 4.0)
    worn = 5e-14 * load * 0.1 * time
    depths = np.linspace(0.0, 2e-4, 20_001)
    depth = np.interp(worn, np.pi * depths**2 * (radius - depths / 3), depths)
    rng = np.random.default_rng(int(load))
    columns = {
        "time": time,
        "sliding_distance": 0.1 * time,
        "depth": 3e-7 + depth + 5e-10 * time + 3e-8 * rng.standard_normal(len(time)),
    }
    steel = {"material": "100Cr6", "youngs_modulus": "210 GPa", "poisson_ratio": 0.3}
    pin = {"shape": "spherical", "radius": {"value": "3 mm", "standard_uncertainty": "6 um"}, **steel}
    scar = 2 * np.sqrt(2 * radius * depth[-1] - depth[-1] ** 2)
    ends = {
        "pin_scar_diameter": {"value": f"{scar} m", "standard_uncertainty": "3 um"},
        "disc_wear_depth": {"value": "0 um", "standard_uncertainty": "0.25 um"},
    }
    manifest = RunManifest.model_validate(
        {
            "schema": "tribopipe.run/1",
            "id": f"rigid-{load:g}N",
            "contact": {"kind": "pin-on-disc", "pin": pin, "disc": steel},
            "conditions": {"normal_load": f"{load} N", "sliding_speed": "0.1 m/s", "track_radius": "8 mm"},
            "signals": [{"file": "signals.csv"}],
            "end_values": ends,
        }
    )
    raw = RawRun(manifest, columns, dict.fromkeys(columns, "measured"), {}, {}, ())
    return Member(correct_drift(raw), None)


@pytest.mark.usefixtures("few_draws")
def test_what_a_quiet_sensor_resolves_is_no_reason_to_reject_a_law():
    members = {one.id: one for one in map(rigid, (2.0, 5.0, 10.0))}
    first, *others = members
    study = Study(id="a-study", fit=[first], predict=others, laws=["archard"])
    found = evaluate(study, members, Recipe()).result.law("archard").runs
    assert [run.outcome for run in found] == ["supported"] * 3

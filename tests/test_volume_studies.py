"""Studies of runs without a depth signal: wear volumes of known k_D, by hand, and held against the law."""

import math
from dataclasses import replace

import numpy as np
import pytest
from conftest import MANIFEST
from end_value_runs import CIRCLE, RADIUS, described, run_of, si
from test_volume_fit import SCAR, sample

from tribopipe.base.errors import FitError
from tribopipe.cli.overview import show_study_overview
from tribopipe.cli.process_table import _agreement
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.recipe import DefaultUncertainty, MonteCarloRecipe, Recipe
from tribopipe.documents.study import Study
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.study.evaluate import evaluate, posed
from tribopipe.evaluation.study.further_tests import designs
from tribopipe.evaluation.study.member import Member
from tribopipe.physics.geometry import scar_depth, worn_volume
from tribopipe.results.evaluation import COVERAGE_FACTOR
from tribopipe.views.study_figures import plot_study_wear

QUICK = Recipe(monte_carlo=MonteCarloRecipe(significant_digits=1))
K_PIN, K_DISC, SLID = 2e-14, 6e-14, 500.0


def member(name, load=0.2, *, load_share=0.0, path=CIRCLE, **ends):
    """A run at a load, N, with post-test measurements."""
    stated = {"normal_load": si(load, "N", load_share * load), "sliding_speed": si(0.4, "m/s"), **path}
    manifest = described(conditions=stated, **ends)
    return Member(correct_drift(replace(run_of(manifest.model_copy(update={"id": name})))), None)


def in_another_contact(name, contact, load=0.4, **ends):
    """A run of the same materials in another contact."""
    paths = {"pin-on-disc": CIRCLE, "reciprocating": {"stroke": si(5e-3, "m")}, "block-on-ring": {}}
    stated = {"normal_load": si(load, "N"), "sliding_speed": si(0.4, "m/s"), **paths[contact["kind"]]}
    conditions = {name: value for name, value in MANIFEST["conditions"].items() if name not in CIRCLE} | stated
    document = {**MANIFEST, "id": name, "contact": contact, "conditions": conditions, "end_values": ends}
    return Member(correct_drift(run_of(RunManifest.model_validate(document))), None)


def lost(factor=1.0, load=0.2, share=0.03, k=K_PIN):
    """A volume that a k_D times a factor gives at a load, uncertain by a share."""
    volume = k * factor * load * SLID
    return si(volume, "m^3", abs(share * volume))


def studied(fit, predict=(), **more):
    members = {one.id: one for one in (*fit, *predict)}
    document = {"id": "volumes", "fit": [one.id for one in fit], "predict": [one.id for one in predict]}
    study = Study.model_validate({"schema": "tribopipe.study/1", "laws": ["archard"], **document, **more})
    return evaluate(study, members, QUICK)


def test_k_d_is_the_mean_of_runs_that_agree_and_the_load_they_share_does_not_average_out():
    fit = [member(f"run-{n}", load_share=0.02, pin_wear_volume=lost()) for n in range(3)]
    law = studied(fit, shared=["normal_load"]).result.laws[0]
    found = law.first.wear_coefficient
    assert found.value == pytest.approx(K_PIN, rel=1e-12)
    assert found.standard_uncertainty == pytest.approx(K_PIN * math.hypot(0.03 / math.sqrt(3), 0.02), rel=0.03)
    assert law.engine == "volume"


def test_scatter_between_runs_is_that_of_their_volumes():
    factors = np.array([0.8, 1.0, 1.3, 1.1])
    fit = [member(f"run-{n}", pin_wear_volume=lost(one, share=1e-4)) for n, one in enumerate(factors)]
    between = studied(fit).result.laws[0].first.between_runs
    assert between.scatter == pytest.approx(np.std(factors, ddof=1) / np.mean(factors), rel=0.01)


def test_an_outlier_is_named_without_asking_for_details(capsys):
    fit = [member(f"run-{n}", pin_wear_volume=lost(factor)) for n, factor in enumerate((1.0, 0.97, 1.02, 1.01, 2.2))]
    result = studied(fit).result
    assert result.laws[0].outliers == ("run-4",)
    show_study_overview(result)
    assert "run-4: outlier; to exclude it: `tribopipe mark-bad run-4" in "".join(capsys.readouterr())
    assert [_agreement(one.id, "archard", [result]) for one in fit].count("outlier") == 1


@pytest.mark.parametrize(("factor", "outcome"), [(1.0, "supported"), (2.0, "under-predicts"), (0.5, "over-predicts")])
def test_volume_at_another_load_is_predicted(factor, outcome):
    fit = [member("light", pin_wear_volume=lost())]
    heavy = member("heavy", load=0.4, pin_wear_volume=lost(factor, load=0.4))
    evaluation = studied(fit, [heavy])
    run = evaluation.result.laws[0].runs[1]
    assert (run.outcome, run.first.what, run.end.unit) == (outcome, "wear_volume", "m")
    assert run.first.predicted.value == pytest.approx(K_PIN * 0.4 * SLID, rel=1e-9)
    assert run.first.coefficient_ratio.value == pytest.approx(factor, rel=1e-9)
    curve = evaluation.curves[1]
    assert curve.predicted[[0, -1]] == pytest.approx([0.0, K_PIN * 0.4 * SLID], rel=1e-9)


@pytest.mark.slow
def test_both_bodies_have_a_k_d_and_are_named():
    ends = {"pin_wear_volume": lost(), "disc_wear_volume": lost(k=K_DISC)}
    evaluation = studied([member("one", **ends)], [member("other", **ends)])
    law = evaluation.result.laws[0]
    assert {name: body.wear_coefficient.value for name, body in law.bodies.items()} == pytest.approx(
        {"pin": K_PIN, "disc": K_DISC}, rel=1e-9
    )
    assert "; disc " in law.runs[1].sentence
    assert plot_study_wear(evaluation.result, "archard", evaluation.curves).axes


def test_a_body_that_one_run_did_not_measure_is_left_to_the_others():
    both = member("both", pin_wear_volume=lost(), disc_wear_volume=lost(k=K_DISC))
    pin, disc = member("pin", pin_wear_volume=lost()), member("disc", disc_wear_volume=lost(k=K_DISC))
    assert list(studied([both, pin]).result.laws[0].bodies) == ["pin"]
    assert list(studied([both], [disc]).result.laws[0].runs[1].bodies) == ["disc"]
    with pytest.raises(FitError, match="no measurement of the pin in disc"):
        studied([pin], [disc])


def material():
    pin = described(conditions=CIRCLE).contact.pin
    return {"material": pin.material, "youngs_modulus": si(304e9, "Pa"), "poisson_ratio": 0.24}


def test_no_end_of_life_beside_a_groove_along_a_track_of_unknown_length():
    both = [member("one", path={}, pin_wear_volume=lost(), disc_wear_volume=lost(k=K_DISC))]
    result = studied(both, end_of_life=si(5e-6, "m")).result
    assert list(result.laws[0].bodies) == ["pin", "disc"]
    assert result.laws[0].runs[0].end_of_life is None
    assert any("track_radius or stroke is missing" in note for note in result.laws[0].runs[0].notes)


@pytest.mark.slow
def test_k_d_of_one_geometry_predicts_another():
    """k_D is of the materials: a block on a ring and a larger ball lose what its k_D says, in names of their own."""
    fit = [member("pin", pin_wear_volume=lost(), disc_wear_volume=lost(k=K_DISC))]
    ring = {"radius": si(17.5e-3, "m"), **material()}
    block = {"kind": "block-on-ring", "block": {"width": si(6e-3, "m"), **material()}, "ring": ring}
    ball = {"kind": "reciprocating", "ball": {"diameter": si(6e-3, "m"), **material()}, "flat": material()}
    volumes = {"block_wear_volume": lost(load=0.4), "ring_wear_volume": lost(load=0.4, k=3 * K_DISC)}
    others = [
        in_another_contact("block", block, **volumes),
        in_another_contact("ball", ball, ball_wear_volume=lost(load=0.4), flat_wear_volume=lost(load=0.4, k=K_DISC)),
    ]
    evaluation = studied(fit, others, end_of_life=si(1e-6, "m"))
    result = evaluation.result
    assert plot_study_wear(result, "archard", evaluation.curves).axes
    _, on_ring, on_flat = result.laws[0].runs
    assert {name: one.outcome for name, one in on_ring.bodies.items()} == {
        "block": "supported",
        "ring": "under-predicts",
    }
    assert on_ring.bodies["block"].predicted.value == pytest.approx(K_PIN * 0.4 * SLID, rel=1e-9)
    assert {name: one.outcome for name, one in on_flat.bodies.items()} == dict.fromkeys(("ball", "flat"), "supported")
    assert list(result.laws[0].bodies) == ["pin", "disc"]
    (note,) = [note for note in result.notes if "geometry" in note]
    assert note.startswith("block, ball: predicted with the same k_D for a contact or geometry different from")


@pytest.mark.slow
def test_the_exponent_of_pressure_is_that_of_one_body():
    """A run that measured the disc alone says nothing of the pin, whose k_D is another one."""

    def ends(load):
        return {"pin_wear_volume": lost(load=load), "disc_wear_volume": lost(load=load, k=K_DISC)}

    fit = [member(f"run-{load}", load=load, **ends(load)) for load in (0.2, 0.4, 0.8, 1.6)]
    disc = member("disc", load=3.2, disc_wear_volume=lost(load=3.2, k=K_DISC))
    found = studied(fit, [disc]).result.laws[0].pressure_exponent
    assert found.runs == 4
    assert found.exponent.value == pytest.approx(1.0, abs=0.01)


def test_a_ball_and_a_pin_of_its_radius_are_the_same_body():
    ball = {"kind": "pin-on-disc", "ball": {"diameter": si(2 * RADIUS, "m"), **material()}, "disc": material()}
    fit = [member("pin", pin_wear_volume=lost()), in_another_contact("ball", ball, ball_wear_volume=lost(load=0.4))]
    for runs in (fit, fit[::-1]):
        result = studied(runs).result
        (found,) = result.laws[0].bodies.values()
        assert found.wear_coefficient.value == pytest.approx(K_PIN, rel=1e-9)
        assert not [note for note in result.notes if "geometry" in note]


def test_other_materials_and_fits_of_other_geometries_are_refused():
    steel = {**material(), "material": "steel"}
    ball = {"kind": "reciprocating", "ball": {"diameter": si(6e-3, "m"), **steel}, "flat": material()}
    other = in_another_contact("ball", ball, ball_wear_volume=lost(load=0.4))
    with pytest.raises(FitError, match="found pin material steel in ball"):
        studied([member("pin", pin_wear_volume=lost())], [other])
    ball["ball"]["material"] = material()["material"]
    other = in_another_contact("ball", ball, ball_wear_volume=lost(load=0.4))
    with pytest.raises(FitError, match="found contact reciprocating in ball"):
        studied([member("pin", pin_wear_volume=lost()), other])


def test_a_gain_within_the_uncertainty_is_a_run_like_any_other():
    volumes = (-1e-13, 2e-13, 4e-13)
    fit = [member(f"run-{n}", pin_wear_volume=si(one, "m^3", 3e-13)) for n, one in enumerate(volumes)]
    found = studied(fit).result.laws[0].first.wear_coefficient
    assert found.value == pytest.approx(np.mean(volumes) / (0.2 * SLID), rel=3e-3)
    assert found.standard_uncertainty == pytest.approx(3e-13 / math.sqrt(3) / (0.2 * SLID), rel=0.05)


def test_runs_that_all_gained_are_refused():
    with pytest.raises(FitError, match="no wear of the pin"):
        studied([member(f"run-{n}", pin_wear_volume=si(-1e-13, "m^3", 3e-13)) for n in range(2)])


def test_end_of_life_is_where_the_cap_has_been_worn():
    law = studied([member("one", pin_wear_volume=lost(share=1e-6))], end_of_life=si(5e-6, "m")).result.laws[0]
    cap = float(worn_volume(depth=5e-6, sphere_radius=RADIUS, flat_radius=0.0))
    assert law.runs[0].end_of_life.place.value == pytest.approx(cap / (K_PIN * 0.2), rel=1e-3)


def test_end_of_life_has_no_upper_limit_where_the_groove_may_be_deeper_than_the_tip_before():
    # With k_D of the pin near zero in some draws, the pin reaches no depth before the groove is as deep as its tip.
    ends = {"pin_wear_volume": lost(share=0.4), "disc_wear_volume": lost(k=30 * K_DISC)}
    life = studied([member("one", **ends)], end_of_life=si(20e-6, "m")).result.laws[0].runs[0].end_of_life
    sure = {name: value | {"standard_uncertainty": 1e-3 * value["value"]} for name, value in ends.items()}
    expected = studied([member("one", **sure)], end_of_life=si(20e-6, "m")).result.laws[0].runs[0].end_of_life
    assert life.place.value == pytest.approx(expected.place.value, rel=0.05)
    assert life.interval[0].value < expected.interval[0].value


def test_density_is_off_by_the_same_in_all_runs():
    mass = si(3210.0 * K_PIN * 0.2 * SLID, "kg", 1e-15)
    law = studied([member(f"run-{n}", pin_mass_loss=mass) for n in range(4)]).result.laws[0]
    share = QUICK.uncertainty.density
    assert law.first.wear_coefficient.standard_uncertainty == pytest.approx(share * K_PIN, rel=0.05)


@pytest.mark.parametrize(
    ("way", "power"), [("pin_scar_diameter", 0.25), ("pin_wear_depth", 0.5), ("pin_wear_volume", 0)]
)
def test_a_longer_test_helps_as_far_as_its_measurement_does(way, power):
    scar = 0.2e-3
    depth = float(scar_depth(scar_radius=scar / 2, sphere_radius=RADIUS, flat_radius=0.0))
    value = {"pin_scar_diameter": si(scar, "m", 2e-6), "pin_wear_depth": si(depth, "m", 1e-7)}.get(
        way, lost(share=0.04)
    )
    # The best of no groove: with one that nobody measured, no test is long enough.
    unworn = QUICK.model_copy(update={"uncertainty": DefaultUncertainty(unseen_groove=0.0)})
    run = posed(member("one", load_share=0.0, **{way: value}), "archard", unworn)
    (now,), (then,) = (
        [line.relative for line in lines if line.name == "pin wear volume"]
        for (lines,) in (run.budgets(), run.budgets(16.0))
    )
    assert then / now == pytest.approx(16.0**-power, rel=0.02)
    (plan,) = designs(run, "archard", 0.05)
    assert (plan.sliding_distance is None) == (power == 0)


@pytest.mark.parametrize("factor", [0.0, -3.0, 1.0])
def test_k_d_that_is_not_above_zero_has_no_relative_interval(factor):
    """The pin is worn by 0, −3 u or u; the disc by 100 u."""
    spread, groove = 0.01 * K_DISC * 0.2 * SLID, K_DISC * 0.2 * SLID / (2 * math.pi * CIRCLE["track_radius"]["value"])
    ends = {"pin_wear_volume": si(factor * spread, "m^3", spread), "disc_track_area": si(groove, "m^2", 0.01 * groove)}
    pin, disc = designs(posed(member("one", **ends), "archard", QUICK), "archard", 0.05)
    found = pin.wear_coefficient
    assert found.value == pytest.approx(0.01 * K_DISC * factor, rel=1e-12, abs=0)
    assert found.standard_uncertainty == pytest.approx(0.01 * K_DISC, rel=1e-9)
    assert (pin.half_width, pin.levers, pin.replicates, pin.sliding_distance) == (None, (), None, None)
    assert f"found k_D of the pin = {found.shown('mm^3/(N*mm)')}" in str(pin)
    assert "sufficient" not in str(pin)
    assert disc.half_width == pytest.approx(COVERAGE_FACTOR * 0.01, rel=1e-9)
    assert "no further test is needed" in str(disc)


def test_cross_section_is_as_uncertain_in_a_longer_test_relative_to_itself():
    run = posed(member("one", disc_track_area=si(2e-10, "m^2", 2e-11)), "archard", QUICK)
    assert run.gains["disc"] == 0.0


def test_a_groove_that_nobody_measured_is_there_in_every_run_and_after_any_time():
    scar = {"pin_scar_diameter": si(0.2e-3, "m", 2e-6)}
    one = posed(member("one", load_share=0.0, **scar), "archard", QUICK)
    (plan,) = designs(one, "archard", 0.05)
    assert plan.sliding_distance is None
    (budget,) = one.budgets()
    assert budget[0].name == "pin unseen groove"
    assert budget[0].relative == pytest.approx(QUICK.uncertainty.unseen_groove / 3, rel=0.2)
    law = studied([member(f"run-{n}", load_share=0.0, **scar) for n in range(9)]).result.laws[0]
    assert law.first.wear_coefficient.standard_uncertainty > 0.045 * law.first.wear_coefficient.value


@pytest.mark.slow
def test_runs_with_and_without_a_depth_signal_share_a_study():
    recorded = sample(**SCAR)
    columns = {name: values[::40] for name, values in recorded.columns.items()}
    recorded = replace(recorded, columns=columns, extras={})
    columns = {name: values for name, values in columns.items() if name != "depth"}
    manifest = recorded.manifest.model_copy(update={"id": "scar"})
    curve, scar = (
        Member(correct_drift(run, QUICK), None)
        for run in (recorded, replace(recorded, manifest=manifest, columns=columns))
    )
    evaluation = studied([curve], [scar])
    first, other = evaluation.result.laws[0].runs
    assert (first.first.what, other.first.what) == ("wear_depth", "wear_volume")
    assert abs(other.first.e_n) < 1
    assert plot_study_wear(evaluation.result, "archard", evaluation.curves).axes

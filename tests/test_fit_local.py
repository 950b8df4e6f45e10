"""k_D by local wear: recovered from runs worn locally, held against the GIWM's, and predicted from as it was fitted."""

import json
import re
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from disc_runs import fit_discs
from folders import SAMPLES
from sweeps import others_slow
from test_identify import CASES, quiet, record
from test_verdict import SLOW, member_of, study
from test_verdict import edited as with_manifest

from tribopipe.archive.store import Archive
from tribopipe.base.errors import ContactError, FitError
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import MonteCarloRecipe, Recipe, WearRecipe
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.friction import fit_friction
from tribopipe.evaluation.study.evaluate import evaluate
from tribopipe.evaluation.study.recorded_runs import compare_engines, engine_notes
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.evaluation.wear.prediction import fitted_curves, predict_wear
from tribopipe.evaluation.wear.problem import WearProblem, wear_problem
from tribopipe.evaluation.wear.scenario import KnownWear, Scenario
from tribopipe.evaluation.wear.uncertainty import coefficient_draws
from tribopipe.pipeline.archived_results import archived_fit
from tribopipe.pipeline.stages import advance, predict_archived
from tribopipe.readers.harmonize import read_run
from tribopipe.results.run import RawRun

LIGHT, HEAVY, NITRIDE = "wc-co-water-400mN", "wc-co-water-1600mN", "si3n4-air-200mN"
FIRST_ORDER = MonteCarloRecipe(significant_digits=0)


def recipe(engine: str, correction: str = "two-step", **others: object) -> Recipe:
    wear = WearRecipe(engine=engine, correction=correction)
    return Recipe(wear=wear, monte_carlo=FIRST_ORDER).model_copy(update=others)


@pytest.fixture
def locally_worn(monkeypatch):
    """Record virtual runs whose pins wear by the pressure at each point."""
    monkeypatch.setattr("tribopipe.extras.simulate.pin_on_disc.KnownWear", partial(KnownWear, engine="local"))
    return record


@pytest.mark.parametrize(
    ("run_id", "correction", "within"),
    [(LIGHT, "two-step", 3e-3), (HEAVY, "two-step", 3e-3), (LIGHT, "model", 1e-4), (NITRIDE, "model", 1e-4)],
)
def test_coefficient_of_local_wear_comes_back(locally_worn, run_id, correction, within):
    series, run = CASES[run_id]
    raw = locally_worn(series, run, sensors=quiet() | SLOW, disc_wear_depth=None)
    how = recipe("local", correction)
    fit = fit_wear(correct_drift(raw, how), "archard", recipe=how)
    assert fit.engine == "local"
    assert fit.first.wear_coefficient.value == pytest.approx(run.wear_coefficient.value, rel=within)
    assert fit.first.fitted_end_depth.value == pytest.approx(fit.first.measured_end_depth.value, rel=2e-3)
    curve = fitted_curves(raw, fit, recipe=how)
    assert curve.bands["wear_depth"].best[-1] == pytest.approx(fit.first.fitted_end_depth.value, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("run_id", "least", "most"),
    others_slow([(LIGHT, 0.10, 0.20), (HEAVY, 0.14, 0.24), (NITRIDE, -0.01, 0.01)], (LIGHT, 0.10, 0.20)),
)
def test_giwm_finds_too_much_where_wear_is_shallow(locally_worn, run_id, least, most):
    series, run = CASES[run_id]
    raw = locally_worn(series, run, sensors=quiet() | SLOW)
    for correction in ("two-step", "model"):
        how = recipe("giwm", correction)
        found = fit_wear(correct_drift(raw, how), "archard", recipe=how).first.wear_coefficient.value
        assert least < found / run.wear_coefficient.value - 1 < most


def problem_of(raw: RawRun, engine: str) -> WearProblem:
    how = recipe(engine)
    problem = wear_problem(correct_drift(raw, how), "archard", None, how)
    assert isinstance(problem, WearProblem)
    return problem


@pytest.mark.slow
@pytest.mark.parametrize("run_id", [HEAVY, NITRIDE])
@pytest.mark.parametrize("engine", ["giwm", "volume"])
def test_fit_says_what_local_pressure_would_make_of_k_d(locally_worn, run_id, engine):
    raw = locally_worn(*CASES[run_id], disc_wear_depth=None)
    fit, local = (
        fit_wear(correct_drift(raw, how), recipe=how) for how in (recipe(engine, "model"), recipe("local", "model"))
    )
    found = [finding for finding in fit.findings if finding.code == "depends_on_engine"]
    one, other = (each.first.wear_coefficient for each in (fit, local))
    apart = abs(one.value - other.value) / one.standard_uncertainty
    assert [finding.severity for finding in found] == (["warning"] if apart > 3 else ["note"] if apart > 1 else [])
    if found:
        stated = float(re.search(r"would be ([\d.]+)×10⁻¹²", found[0].message)[1])
        assert stated == pytest.approx(other.value * 1e18, rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize(("run_id", "excess"), [(LIGHT, 0.12), (HEAVY, 0.17)])
@pytest.mark.parametrize("correction", ["two-step", "model"])
def test_unknown_pressure_enters_u_as_a_triangle_down_to_local_wear(locally_worn, run_id, excess, correction):
    """The excess of the GIWM's k_D is that of docs/fit_engine.md at 4.8 and 3.8 elastic approaches, interpolated."""
    series, run = CASES[run_id]
    raw = locally_worn(series, run, sensors=SLOW, disc_wear_depth=None)
    how = recipe("giwm", correction)
    fit = fit_wear(correct_drift(raw, how), recipe=how).first
    (line,) = (line for line in fit.budget if line.name == "pressure distribution")
    assert abs(line.relative) * 6**0.5 == pytest.approx(excess / (1 + excess), rel=0.2)
    assert abs(fit.wear_coefficient.value - run.wear_coefficient.value) < 3 * fit.wear_coefficient.standard_uncertainty
    assert "pressure distribution" not in [line.name for line in own_fit(raw, "local").budget]


def own_fit(raw: RawRun, engine: str):
    how = recipe(engine, "model")
    return fit_wear(correct_drift(raw, how), recipe=how).first


def test_reading_decides_between_the_engines_where_it_can(locally_worn):
    how, (series, run) = recipe("giwm", "model"), CASES[HEAVY]
    raw = locally_worn(series, run, sensors=quiet() | SLOW, disc_wear_depth=None)
    findings = fit_wear(correct_drift(raw, how), recipe=how).findings
    (found,) = (finding for finding in findings if finding.code == "depends_on_engine")
    assert found.severity == "warning"
    assert "the shape of the depth signal agrees better with it" in found.message
    assert found.remedy == "use --engine local"


@pytest.mark.slow
def test_reading_that_excludes_local_pressure_leaves_no_doubt():
    how, (series, run) = recipe("giwm", "model"), CASES[HEAVY]
    raw = record(series, run, sensors=quiet() | SLOW, disc_wear_depth=None)
    fit = fit_wear(correct_drift(raw, how), recipe=how)
    assert "pressure distribution" not in [line.name for line in fit.first.budget]
    assert "depends_on_engine" not in [finding.code for finding in fit.findings]
    found = evaluate(study((raw.id,)), {raw.id: member_of(raw)}, how).result.law("archard")
    assert [one.bodies["pin"].engines.trusted for one in found.runs] == [None]


def test_first_order_sensitivities_are_those_of_refitting(locally_worn):
    problem = problem_of(locally_worn(*CASES[LIGHT], sensors=SLOW), "local")
    best = problem.solve(problem.values)
    for name, given in problem.inputs.items():
        shifted = {**problem.values, name: problem.values[name] + 0.1 * given.spread}
        refitted = np.log(problem.solve(shifted) / best) / (0.1 * given.spread)
        assert problem.sensitivity(name, best) == pytest.approx(refitted, rel=0.1, abs=1e-3 / given.spread)


def test_draws_spread_about_the_truth(locally_worn):
    series, run = CASES[HEAVY]
    draw = coefficient_draws(problem_of(locally_worn(series, run, sensors=SLOW), "local"))
    low, high = np.quantile(draw(np.random.Generator(np.random.PCG64(1)), 400), [0.025, 0.975])
    assert low < run.wear_coefficient.value < high < 2 * run.wear_coefficient.value


@pytest.mark.slow
@pytest.mark.parametrize("run_id", [LIGHT, HEAVY])
def test_intervals_hold_the_truth_as_often_as_they_say(locally_worn, monkeypatch, run_id):
    monkeypatch.setattr("tribopipe.physics.uncertainty.BLOCK", 1_000)
    series, run = CASES[run_id]
    series = series.model_copy(update={"systematic_errors": True})
    how = Recipe(wear=WearRecipe(engine="local"))
    held, count = 0, 80
    for seed in range(count):
        raw = locally_worn(series, run, seed=50_000 + seed, sensors=SLOW)
        fit = fit_wear(correct_drift(raw, how), recipe=how)
        low, high = (end.value for end in fit.first.interval)
        held += low <= run.wear_coefficient.value <= high
    assert held / count == pytest.approx(0.95, abs=3 * np.sqrt(0.95 * 0.05 / count))


def scenario(engine: str) -> Scenario:
    series, run = CASES[HEAVY]
    return Scenario(series.contact, run.normal_load, KnownWear({"pin": run.wear_coefficient}, engine))


def test_prediction_by_local_wear_reaches_the_depth_it_predicts():
    local, giwm = (predict_wear(scenario(engine), [500.0]) for engine in ("local", "giwm"))
    depth = local.prediction[0].contact.approach.value
    assert (local.engine, giwm.engine) == ("local", "giwm")
    assert depth / giwm.prediction[0].contact.approach.value - 1 == pytest.approx(0.083, abs=0.001)
    (reached,) = predict_wear(scenario("local"), depths=[depth]).reached
    assert reached.sliding_distance.value == pytest.approx(500.0, rel=1e-9)
    assert "local contact pressure" in str(local)
    assert "local" not in str(giwm)


def test_a_rigid_ball_worn_too_deep_is_warned_of():
    rigid, local = (predict_wear(scenario(engine), [20.0]) for engine in ("volume", "local"))
    over = rigid.prediction[0].contact.approach.value / local.prediction[0].contact.approach.value - 1
    (warned,) = (note for note in rigid.notes if "elastic deformation is neglected" in note)
    assert float(warned.partition("is overestimated by about ")[2].split()[0]) / 100 == pytest.approx(over, abs=0.02)
    assert not any("elastic" in note for note in local.notes)


def test_distance_to_a_depth_is_as_uncertain_as_the_local_rate_has_it():
    known = scenario("local")
    known = replace(known, known=KnownWear({"pin": Quantity(value=7.5e-18, unit="m^2/N")}, "local"))
    (reached,) = predict_wear(known, depths=[0.5e-6]).reached
    at = reached.sliding_distance
    step = np.array([at.value * (1 - 1e-4), at.value * (1 + 1e-4)])
    rate = float(np.diff(known.worn(step)["wear_depth"])[0] / np.diff(step)[0])
    spread = float(known.uncertainties(np.array([at.value]))["wear_depth"][0])
    assert at.standard_uncertainty == pytest.approx(spread / rate, rel=1e-4)


def test_euler_steps_of_local_wear_are_refused():
    with pytest.raises(ContactError, match="exact scheme"):
        predict_wear(scenario("local"), [500.0], scheme="published", steps=10)


def test_discs_are_not_fitted_by_local_wear():
    run = read_run(SAMPLES / "si3n4-twin-disc-4pct-100k")
    with pytest.raises(FitError, match="--engine giwm"):
        fit_discs(run, "archard", fit_friction(run), recipe("local"))


@pytest.mark.parametrize("engine", ["giwm", "local"])
def test_study_says_where_the_engines_differ_and_which_to_trust(locally_worn, engine):
    posed = member_of(locally_worn(*CASES[HEAVY], sensors=SLOW)).pose("archard", recipe(engine))
    compared = compare_engines(posed.draw(np.random.Generator(np.random.PCG64(1)), 300, {}))
    assert compared.trusted == "local"
    assert 1.1 < compared.giwm.value / compared.local.value < 1.35
    (note,) = engine_notes(compared)
    for k in (compared.giwm, compared.local):
        assert k.shown("mm^3/(N*mm)") in note
    assert "use the local value" in note


def test_study_is_silent_where_wear_is_deep():
    posed = member_of(record(*CASES[NITRIDE], sensors=SLOW)).pose("archard", recipe("giwm"))
    compared = compare_engines(posed.draw(np.random.Generator(np.random.PCG64(1)), 300, {}))
    assert compared.trusted is None
    assert compared.local.value == pytest.approx(compared.giwm.value, rel=2e-3)
    assert engine_notes(compared) == ()


@pytest.mark.parametrize("factor", [0.9809, 1.0261])
def test_engines_are_compared_on_the_same_data_where_only_one_contradicts_the_measurement(factor):
    """A scar that is off by about three standard uncertainties; deep wear is the same by both."""
    raw = record(*CASES[NITRIDE], sensors=SLOW)
    scar = raw.manifest.end_values.pin_scar_diameter
    off = scar.model_copy(update={"value": factor * scar.value})
    ends = raw.manifest.end_values.model_copy(update={"pin_scar_diameter": off})
    posed = member_of(with_manifest(raw, end_values=ends)).pose("archard", recipe("giwm", "model"))
    assert posed.problem.basis != posed.problem.by_local_pressure.basis
    compared = compare_engines(posed.draw(np.random.Generator(np.random.PCG64(1)), 300, {}))
    assert compared.giwm.value == posed.coefficient
    assert compared.local.value == pytest.approx(compared.giwm.value, rel=3e-3)
    assert engine_notes(compared) == ()


def test_study_of_flat_pins_has_nothing_to_compare():
    raw = record(*CASES[NITRIDE], sensors=SLOW)
    contact = raw.manifest.contact
    flat = contact.model_copy(update={"pin": contact.pin.model_copy(update={"shape": "flat"})})
    ends = raw.manifest.end_values.model_copy(
        update={"pin_scar_diameter": None, "pin_wear_depth": Quantity(value=2e-5, unit="m")}
    )
    posed = member_of(with_manifest(raw, contact=flat, end_values=ends)).pose("archard", recipe("giwm"))
    assert compare_engines(posed.draw(np.random.Generator(np.random.PCG64(1)), 10, {})) is None


@pytest.mark.slow
def test_study_by_local_wear_records_its_engine(locally_worn, monkeypatch):
    monkeypatch.setattr("tribopipe.physics.uncertainty.BLOCK", 300)
    runs = {run_id: member_of(locally_worn(*CASES[run_id], sensors=SLOW)) for run_id in (LIGHT, HEAVY)}
    how = recipe("local", monte_carlo=MonteCarloRecipe())
    result = evaluate(study([HEAVY], [LIGHT], laws=["archard"], end_of_life="1 um"), runs, how).result
    law = result.law("archard")
    fitted, predicted = law.runs
    assert law.engine == "local"
    assert predicted.first.engines is None
    assert law.first.wear_coefficient.value == pytest.approx(fitted.first.engines.local.value, rel=1e-6)
    assert predicted.outcome in ("supported", "not decidable")
    document = json.loads(result.model_dump_json())
    assert document["laws"][0]["runs"][0]["bodies"]["pin"]["engines"]["trusted"] == "local"


@pytest.mark.slow
def test_fit_is_done_again_by_another_engine_and_predicted_from_as_it_was_fitted(archive):
    store, local, giwm = Archive(archive), recipe("local"), recipe("giwm")
    assert advance(store, NITRIDE, "wear_fit_archard", giwm).status == "done"
    assert advance(store, NITRIDE, "wear_fit_archard", local).status == "done"
    assert advance(store, NITRIDE, "wear_fit_archard", local).status == "unchanged"
    assert archived_fit(store, NITRIDE, "archard").engine == "local"
    # The recipe does not say by which engine a k_D that is there was found.
    assert predict_archived(store, NITRIDE, NITRIDE, "archard", giwm).result.engine == "local"


@pytest.mark.slow
def test_command_line_fits_by_either_engine_and_refuses_to_mix_them(archive, run_cli):
    place, how = ("--archive", archive), archive.parent / "recipe.toml"
    how.write_text("[monte_carlo]\nsignificant_digits = 0\n", encoding="utf-8")
    fitted = run_cli("fit", NITRIDE, "--engine", "local", "--recipe", how, "--json", *place)
    (found,) = json.loads(fitted.stdout)["runs"]
    assert (fitted.exit_code, found["engine"]) == (0, "local")
    assert "archard, local contact pressure: pin k_D" in fitted.stderr
    mixed = run_cli("predict", NITRIDE, "--at", "100 m", "--engine", "giwm", *place)
    assert mixed.exit_code == 1
    assert "fit again with --engine giwm" in mixed.stderr
    same = run_cli("predict", NITRIDE, "--at", "100 m", "--json", *place)
    assert json.loads(same.stdout)["engine"] == "local"


def test_given_coefficient_is_taken_by_the_engine_named(run_cli):
    given = ("--run", SAMPLES / LIGHT, "--wear-coefficient", "0.75e-11 mm^3/(N*mm)", "--at", "500 m", "--json")
    depths = [
        json.loads(run_cli("predict", *given, "--engine", engine).stdout)["prediction"][0]["contact"]["approach"]
        for engine in ("local", "giwm")
    ]
    assert depths[0]["value"] / depths[1]["value"] - 1 == pytest.approx(0.061, abs=0.001)


def test_engine_of_discs_is_refused_by_predict(run_cli):
    given = ("--run", SAMPLES / "si3n4-twin-disc-4pct-100k", "--wear-coefficient", "4.6e-12 mm^3/(N*mm)")
    refused = run_cli("predict", *given, "--at", "1e5", "--engine", "local")
    assert refused.exit_code == 2
    assert "wear of two discs is predicted with the GIWM" in refused.stderr

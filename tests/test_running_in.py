"""Exponential running-in: its parameters as given, as simulated, and as found from a recording."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from disc_runs import known_pair
from example_rig import EXCESS, JOINT, K_D, LENGTH, predicted, record, series_of, virtual, worn

from tribopipe.base.errors import FitError
from tribopipe.cli.live import live
from tribopipe.documents.plan import Plan
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe, WearRecipe
from tribopipe.documents.record import load_toml, read_document
from tribopipe.evaluation.wear.scenario import Scenario
from tribopipe.extras.simulate import VirtualTest, VirtualTwinDiscTest
from tribopipe.physics import laws

ROOT = Path(__file__).parents[1]


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"lenght": "30 m"}, r"running_in\.lenght: found a parameter.*did you mean 'length'\?"),
        ({"length": "30 N"}, r"running_in\.length: found the unit 'N', which is not a unit of distance"),
        ({"excess": -1.0}, r"running_in\.excess: found -1; expected 0 to 1000; correct it"),
        ({"length": "30 m"}, r"found no excess; expected values"),
    ],
)
def test_given_parameters_are_checked(given, words):
    from tribopipe.evaluation.wear.inputs import law_as_given

    recipe = read_document({"wear": {"parameters": {"running_in": given}}}, Recipe, where="recipe.toml")
    with pytest.raises(FitError, match=words):
        law_as_given("running_in", recipe)


def test_virtual_run_wears_by_the_true_parameters_of_its_law():
    series = series_of(systematic_errors=False)
    test = VirtualTest(series, series.runs[0])
    np.testing.assert_allclose(test.worn.pin_depth, worn(laws.law_named("running_in"), test.distance), rtol=1e-12)
    told = {name: (true.value, true.unit) for name, true in test.truth().law_parameters.items()}
    assert told == {"excess": (EXCESS, "1"), "length": (LENGTH, "m")}
    assert VirtualTest(series_of(law="archard", law_parameters={}), series.runs[0]).truth().law_parameters is None


def test_test_is_not_followed_under_a_law_whose_parameters_nobody_gave(tmp_path):
    with pytest.raises(FitError, match="found no excess or length; expected values"):
        live(record(tmp_path / "run", laws.law_named("running_in")), "running_in")


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"excess": 4.0}, "exponential running-in: found no length; .* under law_parameters of the series"),
        ({"excess": 4.0, "lenght": "30 m"}, r"law_parameters\.lenght: found a parameter .* did you mean 'length'\?"),
    ],
)
def test_virtual_run_needs_all_parameters_of_its_law(given, words):
    series = series_of(law_parameters=given)
    with pytest.raises(FitError, match=words):
        VirtualTest(series, series.runs[0])


def test_virtual_discs_wear_by_the_true_parameters_of_their_law():
    series = load_toml(ROOT / "sample_runs" / "plan.toml", Plan).twin_disc_series[0]
    series = series.model_copy(update={"distance_per_rotation": "volume-conserving"})
    given = {"law": "running_in", "law_parameters": {"excess": EXCESS, "length": f"{LENGTH} m"}}
    plain, run_in = (VirtualTwinDiscTest(series.model_copy(update=said), series.runs[0]) for said in ({}, given))
    law = laws.law_named("running_in").at({"law_excess": EXCESS, "law_length": LENGTH})
    longer = law.effective_distance(plain.distance[-1], None) / plain.distance[-1]
    volumes = [test.truth().end_curved_wear_volume.value for test in (plain, run_in)]
    assert volumes[1] == pytest.approx(longer * volumes[0], rel=1e-6)
    with pytest.raises(FitError, match="found no excess or length"):
        VirtualTwinDiscTest(series.model_copy(update={"law": "running_in"}), series.runs[0])


def discs_under_running_in(length: str | dict[str, str]) -> Scenario:
    """Return a scenario of two discs that run in over a length."""
    load, slip = (Quantity(value=value, unit=unit) for value, unit in ((0.25, "N"), (0.04, "1")))
    recipe = Recipe(wear=WearRecipe(parameters={"running_in": {"excess": EXCESS, "length": length}}))
    return Scenario(
        load_toml(ROOT / "sample_runs" / "plan.toml", Plan).twin_disc_series[0].contact,
        load,
        known_pair(*(Quantity(value=k_d, unit="m^2/N") for k_d in (4.6e-18, 2e-18))),
        "running_in",
        recipe=recipe,
        slip=slip,
    )


def test_wear_of_discs_is_as_uncertain_as_the_parameters_of_their_law():
    rotations = np.asarray([1e5])
    scenario = discs_under_running_in({"value": "30 m", "standard_uncertainty": "10 m"})
    spread = scenario.uncertainties(rotations, ("law_length",))["curved_depth"]
    low, high = (discs_under_running_in(length).worn(rotations)["curved_depth"] for length in ("20 m", "40 m"))
    np.testing.assert_allclose(spread, (high - low) / 2, rtol=0.05)


@pytest.mark.slow
def test_parameter_that_is_found_at_nothing_is_held_there_and_leaves_k_d_to_archard(monkeypatch):
    slow_at_first = replace(laws.law_named("running_in"), excess=-0.5, length=LENGTH)
    monkeypatch.setattr("tribopipe.extras.simulate.instrument.true_law", lambda _: slow_at_first)
    series = series_of(sliding_distance="100 m", systematic_errors=False)
    recipe = JOINT.model_copy(
        update={"wear": JOINT.wear.model_copy(update={"parameters": {"running_in": {"length": f"{LENGTH} m"}}})}
    )
    run_in, archard = (virtual(series, 1, law, recipe)[1] for law in ("running_in", "archard"))
    assert run_in.first.wear_coefficient.value == pytest.approx(archard.first.wear_coefficient.value, rel=1e-9)
    assert str(run_in.parameters[0].value) == "0"
    assert (
        "excess is fixed at its fitted value of 0, so that k_D and its uncertainty are those of a fit without it"
        in run_in.notes
    )


@pytest.mark.slow
def test_parameters_that_a_run_does_not_determine_are_stated():
    level = series_of(law="archard", law_parameters={}, sliding_distance="100 m", systematic_errors=False)
    fits = [virtual(series, 3)[1] for series in (level, series_of())]
    stated = [any("does not determine" in note for note in fit.notes) for fit in fits]
    wide = [any(one.value.standard_uncertainty > one.value.value for one in fit.parameters) for fit in fits]
    assert stated == wide == [True, False]


@pytest.mark.slow
def test_intervals_hold_the_truth_as_often_as_they_say():
    off: dict[str, list[float]] = {name: [] for name in ("k_d", "excess", "length", "later", "heavier")}
    for seed in range(24):
        series = series_of()
        _, fit = virtual(series, 1000 + seed)
        found = {one.name: one.value for one in fit.parameters} | {"k_d": fit.first.wear_coefficient}
        true = {"excess": EXCESS, "length": LENGTH, "k_d": K_D}
        for name, load, at in (("later", 0.2, 2000.0), ("heavier", 0.4, 500.0)):
            found[name] = predicted(series, fit, load, at)
            true[name] = worn(laws.law_named("running_in"), at, load)
        for name, quantity in found.items():
            off[name].append((quantity.value - true[name]) / quantity.standard_uncertainty)
    for name, deviations in off.items():
        held = np.count_nonzero(np.abs(deviations) < 1.96)
        assert held >= 19, (name, held)  # fewer of 24 would come about once in 200 tests by chance
        assert abs(np.mean(deviations)) < 0.7, name


@pytest.mark.slow
def test_parameters_that_a_run_hardly_shows_leave_k_d_right():
    series = series_of(law="archard", law_parameters={}, sliding_distance="100 m", systematic_errors=False)
    for seed in range(8):
        fit = virtual(series, seed)[1].first.wear_coefficient
        assert abs(fit.value - K_D) < 3 * fit.standard_uncertainty
        assert fit.standard_uncertainty < 0.5 * K_D

"""Dissipated energy: α from recordings that are simulated by it, against hand calculations."""

from dataclasses import replace

import numpy as np
import pytest
from example_rig import JOINT, K_D, series_of
from independent.regimes import REGIMES
from independent.runs import simulate
from independent.score import raw_run

from tribopipe.base.errors import FitError
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe, WearRecipe
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.friction import fit_friction
from tribopipe.evaluation.preprocessing.cleaning import clean_run
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.evaluation.wear.scenario import KnownWear, Scenario
from tribopipe.extras.simulate import VirtualTest
from tribopipe.extras.sweep.virtual_tests import recorded_run
from tribopipe.results.run import RawRun

LAW = "dissipated_energy"


def recorded(seed: int = 1, **friction: float | str) -> tuple[VirtualTest, RawRun]:
    """A run of 500 m under 200 mN whose wear is proportional to its friction work."""
    run = {**SERIES_RUN, "seed": seed, "friction": {**SERIES_RUN["friction"], **friction}}
    series = series_of(law=LAW, law_parameters={}, systematic_errors=False, runs=[run])
    test = VirtualTest(series, series.runs[0])
    return test, clean_run(recorded_run(series, test)).run


SERIES_RUN = series_of().runs[0].model_dump(mode="json", exclude_none=True)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_energy_wear_coefficient_comes_back(seed):
    _, run = recorded(seed)
    k_d = fit_wear(correct_drift(run, JOINT), LAW, fit_friction(run), JOINT).first.wear_coefficient
    assert abs(k_d.value - K_D) < 3 * k_d.standard_uncertainty
    assert k_d.standard_uncertainty < 0.1 * K_D


def test_wear_is_that_of_alpha_and_the_friction_work():
    """∫μ ds = b·s + A·c·(1 − exp(−s/c)) = 0.5·500 m + 0.2·20 m = 254 m: as deep as by Archard's law over 254 m."""
    test, _ = recorded()
    series = series_of()
    known = KnownWear({"pin": Quantity(value=K_D, unit="m^2/N")})
    scenario = Scenario(series.contact, series.runs[0].normal_load, known)
    (depth,) = scenario.worn(np.array([254.0]))["wear_depth"]
    assert test.truth().end_pin_wear_depth.value == pytest.approx(depth, rel=1e-6)


def test_constant_friction_gives_the_curve_of_archard_s_law():
    _, run = recorded(amplitude=0.0)
    run = replace(run, columns={**run.columns, "friction_coefficient": np.full(len(run), 0.5)})
    how = Recipe(wear=WearRecipe(friction="measured"), monte_carlo=JOINT.monte_carlo)
    energy, archard = (fit_wear(correct_drift(run, how), law, fit_friction(run), how).first for law in (LAW, "archard"))
    assert energy.wear_coefficient.value == pytest.approx(archard.wear_coefficient.value / 0.5, rel=1e-6)
    assert energy.fitted_end_depth.value == pytest.approx(archard.fitted_end_depth.value, rel=1e-6)


def test_run_without_friction_is_not_fitted_and_says_why():
    raw = raw_run(simulate(REGIMES["Si3N4"], np.random.default_rng(1)))
    silent = {name: column for name, column in raw.columns.items() if not name.startswith("friction")}
    raw = replace(raw, columns=silent)
    fit = fit_wear(correct_drift(raw), LAW, fit_friction(raw))
    assert fit.outcome == "not fitted"
    assert any("friction" in one for one in fit.missing)


def test_friction_of_the_wrong_sign_is_refused_in_one_sentence():
    _, run = recorded()
    run = replace(run, columns={**run.columns, "friction_coefficient": np.full(len(run), -0.5)})
    with pytest.raises(FitError, match=r"found a mean friction coefficient of -0\.5; expected a value above zero"):
        fit_wear(correct_drift(run), LAW, fit_friction(run), Recipe(wear=WearRecipe(friction="measured")))

"""k₁ and k₂ of one twin-disc run against the truth behind its end values."""

import math
from dataclasses import replace
from typing import get_args

import numpy as np
import pytest
from disc_runs import (
    BARE,
    CONVENTIONS,
    K_1,
    K_2,
    PLANNED,
    TYPICAL,
    exact_run,
    fit_discs,
    raw,
    recipe,
    recorded,
    with_ends,
    worn,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import least_squares
from scipy.stats import binom, chi2
from sweeps import others_slow

from tribopipe.base.errors import FitError, TribopipeError
from tribopipe.contacts.twin_disc import nominal_pair
from tribopipe.documents.quantity import EndValue, Quantity
from tribopipe.documents.recipe import DefaultUncertainty, MonteCarloRecipe, Recipe, WearRecipe
from tribopipe.evaluation.friction import fit_friction
from tribopipe.evaluation.wear.measurement_problem import measurement_problem
from tribopipe.physics.calculation_methods import DistanceConvention

pytestmark = pytest.mark.usefixtures("few_draws")

VOLUMES = {"curved_disc_wear_volume": 0.08, "flat_disc_wear_volume": 0.08}
MIXTURES = {
    "volumes": VOLUMES,
    "depths": {"curved_disc_wear_depth": 0.05, "flat_disc_wear_depth": 0.05},
    "depth and width": {"curved_disc_wear_depth": 0.05, "flat_disc_track_width": 0.02},
    "width and volume": {"curved_disc_track_width": 0.02, "flat_disc_wear_volume": 0.1},
    "volume and depth": {"curved_disc_wear_volume": 0.08, "flat_disc_wear_depth": 0.2},
    "all": {f"{disc}_{what}": 0.05 for disc in ("curved_disc", "flat_disc") for what in ("wear_volume", "wear_depth")}
    | {f"{disc}_track_width": 0.01 for disc in ("curved_disc", "flat_disc")},
}
STOPS = {"none": {}, "one": {2.5e5: VOLUMES}, "two": {1e5: {"curved_disc_track_width": 0.02}, 6e5: VOLUMES}}


def found(fit) -> tuple[float, ...]:
    return tuple(one.wear_coefficient.value for one in fit.bodies.values())


def volume(value: float, spread: float | None) -> EndValue:
    return EndValue(value=value, unit="m^3", standard_uncertainty=spread)


# --- without noise ---


@pytest.mark.parametrize("convention", CONVENTIONS)
@pytest.mark.parametrize("stops", ["none", pytest.param("two", marks=pytest.mark.slow)])
@pytest.mark.parametrize("mixture", others_slow(MIXTURES, first=3))
def test_both_coefficients_come_back_exactly(mixture, stops, convention):
    run = exact_run(MIXTURES[mixture], STOPS[stops], convention=convention)
    fit = fit_discs(run, recipe=recipe(convention))
    scale = TYPICAL[convention]
    assert (fit.outcome, fit.distance_per_rotation) == ("fitted", convention)
    assert found(fit) == pytest.approx((K_1 * scale, K_2 * scale), rel=1e-9)
    for one in fit.measurements:
        assert one.fitted.value == pytest.approx(one.measured.value, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("convention", CONVENTIONS)
@pytest.mark.parametrize("mu", [0.1, 0.9])
def test_sarkar_s_coefficients_are_smaller_by_his_factor(mu, convention):
    run = exact_run(MIXTURES["volumes"], STOPS["two"], convention=convention, mu=mu)
    scale, how = TYPICAL[convention], recipe(convention, friction="measured")
    assert found(fit_discs(run, "sarkar", recipe=how)) == pytest.approx((K_1 * scale, K_2 * scale), rel=1e-9)
    archard = found(fit_discs(run, "archard", recipe=how))
    sarkar = found(fit_discs(run, "sarkar", recipe=how))
    factor = math.sqrt(1 + 3 * mu**2)
    assert archard == pytest.approx([factor * one for one in sarkar], rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("convention", CONVENTIONS)
@pytest.mark.parametrize("what", ["wear_volume", "wear_depth", "track_width"])
def test_one_sided_wear_is_fitted_where_nothing_was_measured_on_the_flat_disc(what, convention):
    run = exact_run({f"curved_disc_{what}": 0.05}, convention=convention, second=0.0)
    fit = fit_discs(run, recipe=recipe(convention, drawn=True))
    assert "flat_disc" not in fit.bodies
    assert fit.correlation is None
    assert found(fit) == pytest.approx((K_1 * TYPICAL[convention],), rel=1e-9)
    assert "assumed to be unworn" in " ".join(fit.notes)
    assert fit.p_value is None


@pytest.mark.slow
@settings(max_examples=8)
@given(
    st.sampled_from(CONVENTIONS),
    st.sampled_from(sorted(MIXTURES)),
    st.floats(-1.5, 1.0),
    st.floats(-2.0, 2.0),
    st.floats(4.0, 6.3),
)
def test_any_pair_of_coefficients_comes_back(convention, mixture, log_first, log_ratio, log_turns):
    first, second = K_1 * 10**log_first, K_1 * 10 ** (log_first + log_ratio)
    run = exact_run(
        MIXTURES[mixture], convention=convention, first=first, second=second, rotations=float(round(10**log_turns))
    )
    scale = TYPICAL[convention]
    assert found(fit_discs(run, recipe=recipe(convention))) == pytest.approx(
        (first * scale, second * scale), rel=1e-7 if mixture in ("volumes", "depths", "all") else 1e-5
    )


def test_negative_slip_wears_as_well():
    document = BARE.model_dump(by_alias=True)
    document["conditions"]["slip"] = {"value": -0.04, "unit": "1", "standard_uncertainty": 0.0004}
    manifest = type(BARE).model_validate(document)
    state = worn(1e6, manifest=manifest)
    ends = {
        "curved_disc_wear_volume": {"value": float(state.curved_volume), "unit": "m^3"},
        "flat_disc_wear_volume": {"value": float(state.flat_volume), "unit": "m^3"},
    }
    fit = fit_discs(raw(ends, manifest=manifest), recipe=recipe())
    assert found(fit) == pytest.approx((K_1, K_2), rel=1e-9)


# --- uncertainty ---


def refitted(problem, changes, start) -> np.ndarray:
    """ln k₁ and ln k₂ by scipy's least squares with an input changed."""
    values = problem.values | changes

    def residual(log_k):
        return (problem.rows(values) - problem.modelled(np.exp(log_k), values)) * problem.root_weights

    return least_squares(residual, start, xtol=1e-15, ftol=1e-15, gtol=1e-15, x_scale=0.1, diff_step=1e-5).x


@pytest.mark.slow
@pytest.mark.parametrize("convention", CONVENTIONS)
@pytest.mark.parametrize("mixture", ["all", "depth and width"])
def test_budget_is_what_refits_with_each_input_moved_give(mixture, convention):
    assert_budget(exact_run(MIXTURES[mixture], STOPS["one"], convention=convention), convention)


@pytest.mark.slow
def test_budget_holds_where_the_elastic_contact_is_most_of_the_track():
    assert_budget(exact_run(MIXTURES["all"], first=0.02 * K_1, second=0.02 * K_2))


@pytest.mark.slow
@pytest.mark.parametrize("mixture", ["volumes"])
def test_budget_holds_where_wear_changes_the_slip(mixture):
    """Crowned disc 0.1 mm deep, slip from 4 % to 5.3 %."""
    assert_budget(exact_run(MIXTURES[mixture], first=300 * K_1, second=300 * K_2))


def assert_budget(run, convention="full-slip") -> None:
    how = recipe(convention)
    fit, problem = fit_discs(run, recipe=how), measurement_problem(run, "archard", None, how)
    start, moved = np.log(found(fit)), {}
    for name, given_ in problem.inputs.items():
        step = given_.spread / 10  # small enough to be linear
        low, high = (refitted(problem, {name: given_.quantity.value + sign * step}, start) for sign in (-1, 1))
        moved[name.replace("_", " ")] = (high - low) / 2 * 10
    for place, one in enumerate(fit.bodies.values()):
        assert {line.name for line in one.budget} == set(moved)
        combined = math.hypot(*(line.relative for line in one.budget))
        assert one.wear_coefficient.standard_uncertainty == pytest.approx(
            combined * one.wear_coefficient.value, rel=1e-9
        )
        for line in one.budget:
            assert line.relative == pytest.approx(moved[line.name][place], rel=0.01, abs=0.005 * combined), line.name
        assert combined == pytest.approx(math.hypot(*(part[place] for part in moved.values())), rel=0.01)
    first, second = np.array(list(moved.values())).T
    assert fit.correlation == pytest.approx(first @ second / math.sqrt(first @ first * (second @ second)), abs=0.01)


def test_shares_of_the_budget_fall():
    fit = fit_discs(exact_run(MIXTURES["all"]), recipe=recipe())
    for one in fit.bodies.values():
        shares = [abs(line.relative) for line in one.budget]
        assert shares == sorted(shares, reverse=True)


@pytest.mark.slow
def test_recorded_load_is_the_load():
    run = exact_run(VOLUMES)
    load = 1.05 * run.manifest.conditions.normal_load.value
    heavier = replace(run, columns={**run.columns, "normal_force": np.full(len(run), load)})
    # Volume is k_D times load times distance; a wider contact slides farther by the convention of the paper.
    conserving = Recipe.model_validate({"wear": {"distance_per_rotation": "volume-conserving"}})
    nominal, recorded = (fit_discs(one, recipe=conserving).bodies["curved_disc"] for one in (run, heavier))
    assert recorded.wear_coefficient.value == pytest.approx(nominal.wear_coefficient.value / 1.05, rel=1e-5)


def test_friction_has_a_line_in_the_budget_of_sarkar():
    run = recorded(PLANNED["4pct-250k"])
    friction = fit_friction(run)
    assert friction.outcome == "exponential"
    fit = fit_discs(run, "sarkar", friction, recipe())
    assert fit.friction == "fitted"
    for one in fit.bodies.values():
        (line,) = (line for line in one.budget if line.name == "friction fit")
        assert 0 < line.relative < 0.05
        combined = math.hypot(*(part.relative for part in one.budget))
        assert one.wear_coefficient.standard_uncertainty == pytest.approx(
            combined * one.wear_coefficient.value, rel=1e-9
        )


@pytest.mark.slow
@pytest.mark.parametrize("law", ["archard", "sarkar"])
def test_drawn_uncertainty_is_that_of_first_order_where_all_is_nearly_linear(monkeypatch, law):
    monkeypatch.setattr("tribopipe.physics.uncertainty.BLOCK", 4_000)
    run = exact_run({"curved_disc_wear_volume": 0.02, "flat_disc_wear_volume": 0.03}, mu=0.4)
    near, drawn = (fit_discs(run, law, recipe=recipe(drawn=drawn, friction="measured")) for drawn in (False, True))
    assert drawn.correlation == pytest.approx(near.correlation, abs=0.05)
    for one, other in zip(near.bodies.values(), drawn.bodies.values(), strict=True):
        assert other.wear_coefficient.value == one.wear_coefficient.value
        assert other.wear_coefficient.standard_uncertainty == pytest.approx(
            one.wear_coefficient.standard_uncertainty, rel=0.05
        )
        assert other.monte_carlo.stable
        assert other.monte_carlo.first_order_interval == one.interval
        assert other.budget == one.budget
        for end, drawn_end in zip(one.interval, other.interval, strict=True):
            assert drawn_end.value == pytest.approx(end.value, rel=0.02)


@pytest.mark.slow
def test_defaults_stand_in_for_uncertainties_that_nobody_stated_and_are_named():
    run = exact_run(VOLUMES)
    silent = with_ends(run, **{name: volume(getattr(run.manifest.end_values, name).value, None) for name in VOLUMES})
    fit = fit_discs(silent, recipe=Recipe(uncertainty=DefaultUncertainty(wear_volume=0.3)))
    (line,) = (line for line in fit.bodies["curved_disc"].budget if line.name == "curved disc wear volume")
    assert line.source == "default"
    assert line.relative == pytest.approx(0.3, rel=0.35)
    (note,) = (note for note in fit.notes if note.startswith("default uncertainty"))
    assert "wear volume of the crowned disc" in note
    assert "wear volume of the cylindrical disc" in note


def coverage(count: int) -> list[int]:
    """How many of so many simulated runs hold k₁, and k₂, in the 95 % interval."""
    held = [0, 0]
    for seed in range(count):
        run = recorded(PLANNED["4pct-500k"].model_copy(update={"seed": 10_000 + seed}))
        fit = fit_discs(run)
        for place, true in enumerate((K_1, K_2)):
            low, high = [*fit.bodies.values()][place].interval
            held[place] += low.value <= true <= high.value
    return held


def assert_binomial(held: list[int], count: int) -> None:
    for one in held:
        assert binom.cdf(one, count, 0.95) > 0.002, held
        assert binom.sf(one - 1, count, 0.95) > 0.002, held


@pytest.mark.slow
def test_intervals_hold_the_truth_in_95_percent_of_many_runs(monkeypatch):
    monkeypatch.setattr("tribopipe.physics.uncertainty.BLOCK", 1_000)
    assert_binomial(coverage(100), 100)


# --- what is said beside ---


@pytest.mark.slow
@pytest.mark.parametrize("convention", others_slow(CONVENTIONS))
def test_equivalents_reach_the_same_volumes(convention):
    run = exact_run(MIXTURES["volumes"], convention=convention)
    fit = fit_discs(run, recipe=recipe(convention))
    assert {one.distance_per_rotation for one in fit.equivalents} == set(get_args(DistanceConvention)) - {convention}
    state = worn(1e6, convention, *found(fit))
    for one in fit.equivalents:
        pair = nominal_pair(BARE, one.distance_per_rotation)
        other = pair.worn(1e6, one.bodies["curved_disc"].value, one.bodies["flat_disc"].value)
        assert float(other.curved_volume) == pytest.approx(float(state.curved_volume), rel=1e-9)
        assert float(other.flat_volume) == pytest.approx(float(state.flat_volume), rel=1e-9)
        again = fit_discs(run, recipe=recipe(one.distance_per_rotation))
        assert found(again) == pytest.approx((one.bodies["curved_disc"].value, one.bodies["flat_disc"].value), rel=1e-8)


def test_equivalents_of_one_sided_wear_leave_the_flat_disc_alone():
    fit = fit_discs(exact_run({"curved_disc_wear_volume": 0.05}, second=0.0), recipe=recipe())
    assert [[*one.bodies] for one in fit.equivalents] == [["curved_disc"]] * 3


@pytest.mark.slow
def test_equivalents_of_sarkar_count_his_rotations():
    run = exact_run(VOLUMES, mu=0.5)
    fit = fit_discs(run, "sarkar", recipe=recipe(friction="measured"))
    for one in fit.equivalents:
        again = fit_discs(run, "sarkar", recipe=recipe(one.distance_per_rotation, friction="measured"))
        assert found(again) == pytest.approx((one.bodies["curved_disc"].value, one.bodies["flat_disc"].value), rel=1e-8)


def test_consistent_values_are_called_so():
    fit = fit_discs(exact_run(MIXTURES["all"]), recipe=recipe())
    assert fit.p_value == pytest.approx(1.0)
    assert "disagrees" not in " ".join(fit.notes)


def test_p_value_of_what_just_determines_both_is_none():
    assert fit_discs(exact_run(VOLUMES), recipe=recipe()).p_value is None


@pytest.mark.slow
@pytest.mark.parametrize("factor", [0.5, 1.6])
def test_inconsistent_values_are_called_so(factor):
    run = exact_run(dict.fromkeys((*VOLUMES, "curved_disc_wear_depth"), 0.05))
    ends = run.manifest.end_values
    off = ends.curved_disc_wear_depth.model_copy(update={"value": ends.curved_disc_wear_depth.value * factor})
    fit = fit_discs(with_ends(run, curved_disc_wear_depth=off), recipe=recipe())
    assert fit.p_value < 1e-4
    assert any("disagree with the law" in note for note in fit.notes)


@pytest.mark.slow
def test_p_value_is_even_where_the_law_holds():
    """Of values drawn within their uncertainties, as often in each quarter."""
    rng, below = np.random.default_rng(5), []
    run = exact_run(dict.fromkeys((*VOLUMES, "curved_disc_wear_depth", "flat_disc_wear_depth"), 0.02))
    ends = run.manifest.end_values
    names = [name for name in type(ends).model_fields if isinstance(getattr(ends, name), EndValue)]
    for _ in range(80):
        drawn = {}
        for name in names:
            one = getattr(ends, name)
            drawn[name] = one.model_copy(update={"value": one.value + one.standard_uncertainty * rng.standard_normal()})
        below.append(fit_discs(with_ends(run, **drawn), recipe=recipe()).p_value)
    counts = np.histogram(below, bins=4, range=(0, 1))[0]
    assert chi2.sf(float(np.sum((counts - 20) ** 2 / 20)), 3) > 1e-3, counts


# --- where there is little or nothing ---


@pytest.mark.parametrize("ends", [{}, {"flat_disc_wear_volume": 0.05}, {"flat_disc_track_width": 0.05}])
def test_run_without_an_end_value_of_the_curved_disc_passes_through(ends):
    fit = fit_discs(exact_run(ends), recipe=recipe())
    assert fit.outcome == "not fitted"
    assert fit.bodies == {}
    assert fit.missing == ("a post-test measurement of the crowned disc (wear depth, track width or wear volume)",)


def test_run_without_friction_passes_through_under_sarkar():
    run = exact_run(VOLUMES)
    without = {name: column for name, column in run.columns.items() if name != "friction_coefficient"}
    fit = fit_discs(replace(run, columns=without), "sarkar")
    assert (fit.outcome, fit.missing) == ("not fitted", ("a friction signal",))


@pytest.mark.parametrize("spread", [1e-13, 0.0, None])
@pytest.mark.parametrize("drawn", [False, True])
def test_curved_disc_without_wear_is_refused_in_one_sentence(spread, drawn):
    run = with_ends(exact_run(VOLUMES), curved_disc_wear_volume=volume(0.0, spread))
    with pytest.raises(FitError, match="no wear of the crowned disc"):
        fit_discs(run, recipe=recipe(drawn=drawn))


@pytest.mark.slow
@pytest.mark.parametrize("drawn", [False, True])
@pytest.mark.parametrize("spread", [4e-13, 0.0, None])
def test_flat_disc_measured_as_unworn_is_a_measurement_like_any_other(spread, drawn):
    """k₂ = 0 is a value like any other; what may have been overlooked is in its interval."""
    unworn = with_ends(exact_run(VOLUMES, second=0.0), flat_disc_wear_volume=volume(0.0, spread))
    fit = fit_discs(unworn, recipe=recipe(drawn=drawn))
    assert fit.bodies["curved_disc"].wear_coefficient.value == pytest.approx(K_1, rel=1e-6)
    assert fit.bodies["flat_disc"].wear_coefficient.value == pytest.approx(0.0, abs=1e-4 * K_1)
    if spread and drawn:
        # 1.96 standard uncertainties of the volume, over the volume that k₂ would wear off.
        per_k = float(worn(1e6, second=K_2).flat_volume) / K_2
        assert fit.bodies["flat_disc"].interval[1].value == pytest.approx(1.96 * spread / per_k, rel=0.3)
        assert fit.bodies["flat_disc"].monte_carlo.draws >= 200


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.5, 1.0])
def test_flat_disc_whose_wear_is_hardly_measured_has_a_wide_interval(share):
    run = exact_run(VOLUMES)
    flat = run.manifest.end_values.flat_disc_wear_volume.value
    fit = fit_discs(with_ends(run, flat_disc_wear_volume=volume(flat, share * flat)))
    low, high = (end.value for end in fit.bodies["flat_disc"].interval)
    assert 0 <= low < K_2 < high
    assert high == pytest.approx(K_2 * (1 + 1.96 * share), rel=0.4)
    if share >= 1:
        assert low == 0


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.3, 0.6])
def test_slip_hardly_known_gives_an_interval_or_a_sentence(share):
    document = BARE.model_dump(by_alias=True)
    document["conditions"]["slip"] = {"value": 0.04, "unit": "1", "standard_uncertainty": share * 0.04}
    run = replace(
        exact_run(VOLUMES),
        manifest=type(BARE).model_validate(
            document | {"end_values": exact_run(VOLUMES).manifest.end_values.model_dump()}
        ),
    )
    try:
        fit = fit_discs(run)
    except TribopipeError as error:
        assert str(error).isprintable()  # noqa: PT017
    else:
        low, high = (end.value for end in fit.bodies["curved_disc"].interval)
        assert 0 < low < K_1 < high


@pytest.mark.slow
def test_wear_that_ran_until_the_slip_was_gone_is_not_called_none():
    """V₁ and V₂ then no longer depend on how long the discs turned, so that k_D follows from nothing."""
    run = exact_run(VOLUMES, first=1000 * K_1, second=30_000 * K_2)
    try:
        fit = fit_discs(run, recipe=recipe())
    except TribopipeError as error:
        assert "no wear" not in str(error)  # noqa: PT017
        assert "slip" in str(error)  # noqa: PT017
    else:
        assert any("slip" in note for note in fit.notes)


def test_measurement_known_exactly_counts_as_such():
    run = exact_run(VOLUMES)
    curved = run.manifest.end_values.curved_disc_wear_volume.value
    fit = fit_discs(with_ends(run, curved_disc_wear_volume=volume(curved, 0.0)), recipe=recipe())
    assert found(fit) == pytest.approx((K_1, K_2), rel=1e-9)
    (line,) = (line for line in fit.bodies["curved_disc"].budget if line.name == "curved disc wear volume")
    assert line.relative == 0


@pytest.mark.slow
def test_same_seed_draws_the_same_and_another_does_not():
    run = exact_run(VOLUMES)
    one, same, other = (
        fit_discs(run, recipe=Recipe(wear=WearRecipe(), monte_carlo=MonteCarloRecipe(seed=seed))) for seed in (1, 1, 2)
    )
    assert one == same
    assert one.bodies["curved_disc"].interval != other.bodies["curved_disc"].interval


def test_worn_flat_wider_than_the_disc_is_noted():
    document = BARE.model_dump(by_alias=True)
    document["contact"]["flat_disc"]["width"] = {"value": 1.5e-4, "unit": "m"}
    run = exact_run(VOLUMES)
    narrow = type(BARE).model_validate(document | {"end_values": run.manifest.end_values.model_dump()})
    fit = fit_discs(replace(run, manifest=narrow), recipe=recipe())
    (note,) = (note for note in fit.notes if "wider than the disc" in note)
    assert "0.15 mm" in note
    assert "the contact cannot widen further" in note


@pytest.mark.slow
def test_worn_flat_of_half_the_crown_radius_is_noted():
    fit = fit_discs(exact_run(VOLUMES, first=2000 * K_1, second=2000 * K_2), recipe=recipe())
    assert any("more than the crown radius of " in note for note in fit.notes)


def test_fit_says_itself_in_words():
    fit = fit_discs(exact_run(VOLUMES), recipe=recipe())
    assert str(fit).startswith("archard, full-slip: crowned disc k_D = (4.6")
    assert "cylindrical disc k_D = (2.0" in str(fit)
    assert isinstance(fit.bodies["curved_disc"].wear_coefficient, Quantity)

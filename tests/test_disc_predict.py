"""Predictions of two discs: the model they are, their uncertainty, and what is said beside."""

import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from disc_runs import (
    BARE,
    BODY,
    CONVENTIONS,
    DOCUMENT,
    K_1,
    K_2,
    TYPICAL,
    exact_run,
    fit_discs,
    known_pair,
    recipe,
    worn,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from sweeps import others_slow

from tribopipe.base.errors import ContactError, FitError
from tribopipe.contacts.twin_disc import disc_pair
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe
from tribopipe.evaluation.wear.prediction import predict_wear
from tribopipe.evaluation.wear.scenario import MOST_STEPS, Scenario, known_wear
from tribopipe.physics.friction_path import ExponentialFriction

FRICTION = ExponentialFriction(0.15, 0.42, 40.0)
CONTACT = {"half_width": "half_width", "half_length": "half_length", "mean_pressure": "pressure"}


def k_d(value: float, share: float | None = None) -> Quantity:
    return Quantity(value=value, unit="m^2/N", standard_uncertainty=None if share is None else share * value)


def scenario(convention="full-slip", first=0.08, second=0.09, correlation=-0.3, **changes) -> Scenario:
    """What the sample discs are predicted for, with relative uncertainties of both k_D."""
    scale = TYPICAL[convention]
    known = known_pair(k_d(K_1 * scale, first), k_d(K_2 * scale, second), correlation=correlation, distance=convention)
    given_ = {"slip": BARE.slip, "speed": BARE.conditions.curved_disc_speed} | changes
    return replace(Scenario(BARE.described, BARE.conditions.normal_load, known), **given_)


def ratio(value: float, spread: float | None = None) -> Quantity:
    return Quantity(value=value, unit="1", standard_uncertainty=spread)


# --- the values ---


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_prediction_is_the_model(convention):
    at = [0.0, 1.0, 2.5e5, 1e6]
    found = predict_wear(scenario(convention), at)
    state = worn(at, convention, K_1 * TYPICAL[convention], K_2 * TYPICAL[convention])
    for place, point in enumerate(found.prediction):
        assert point.rotations.value == at[place]
        assert point.time.value == pytest.approx(at[place] * 2 * math.pi * 4e-3 / 0.8)
        for name, field in CONTACT.items():
            there = getattr(point.contact, name).value
            assert there == pytest.approx(float(getattr(state, field)[place]), rel=1e-12), name
        for name in ("slip", "sliding_distance"):
            assert getattr(point, name).value == pytest.approx(float(getattr(state, name)[place]), rel=1e-12), name
        for body, what in product(("curved", "flat"), ("depth", "volume")):
            found_there = getattr(point.bodies[f"{body}_disc"], f"wear_{what}").value
            assert found_there == pytest.approx(float(getattr(state, f"{body}_{what}")[place]), rel=1e-12), body
        assert point.contact.approach.value == pytest.approx(float(state.curved_depth[place] + state.flat_depth[place]))
    assert (found.scheme, found.model, found.distance_per_rotation) == ("exact", "archard", convention)


def test_prediction_under_sarkar_turns_by_his_distance():
    found = predict_wear(scenario(model="sarkar", friction=FRICTION), [3e5])
    per_turn = 2 * math.pi * 4e-3 * 0.04
    fine = np.linspace(0, 3e5 * per_turn, 200_001)
    mu = 0.15 * np.exp(-fine / 40.0) + 0.42
    effective = np.trapezoid(np.sqrt(1 + 3 * mu**2), fine) / per_turn
    state = worn(effective)
    (point,) = found.prediction
    assert point.bodies["curved_disc"].wear_volume.value == pytest.approx(float(state.curved_volume), rel=1e-8)
    assert point.rotations.value == 3e5
    # The discs slid for as long as they turned, whatever friction did.
    assert point.sliding_distance.value == pytest.approx(3e5 * per_turn, rel=0.01)


@pytest.mark.slow
@settings(max_examples=10)
@given(st.sampled_from(CONVENTIONS), st.floats(-7.5, -4.5), st.booleans())
def test_depths_are_reached_where_they_are_predicted(convention, log_depth, sarkar):
    changes = {"model": "sarkar", "friction": FRICTION} if sarkar else {}
    one, depth = scenario(convention, **changes), 10**log_depth
    (reached,) = predict_wear(one, depths=[depth]).reached
    assert reached.bodies["curved_disc"].wear_depth.value == pytest.approx(depth, rel=1e-9)
    (back,) = predict_wear(one, [reached.rotations.value]).prediction
    assert back.bodies["curved_disc"].wear_depth.value == pytest.approx(depth, rel=1e-9)
    assert reached.time.value == pytest.approx(back.time.value)
    # What is uncertain of the depth is uncertain of the place by the slope.
    rate = float(one.worn(np.array([reached.rotations.value * 1.001]))["curved_depth"][0] - depth) / (
        reached.rotations.value * 0.001
    )
    assert reached.rotations.standard_uncertainty == pytest.approx(
        back.bodies["curved_disc"].wear_depth.standard_uncertainty / rate, rel=0.01
    )


def test_place_of_a_depth_is_as_uncertain_as_draws_have_it():
    """Under Sarkar too."""
    for changes in ({}, {"model": "sarkar", "friction": ExponentialFriction(0.0, 0.8)}):
        one = scenario(first=0.01, second=0.01, **changes)
        (reached,) = predict_wear(one, depths=[1e-6]).reached
        values = drawn(one, 4_000)
        pair = disc_pair(one.contact, values, "full-slip")
        turns = pair.rotations(1e-6, values["curved_coefficient"], values["flat_coefficient"])
        factor = math.sqrt(1 + 3 * 0.8**2) if changes else 1.0
        assert reached.rotations.value == pytest.approx(np.mean(turns) / factor, rel=0.01)
        assert reached.rotations.standard_uncertainty == pytest.approx(np.std(turns) / factor, rel=0.06)


# --- the uncertainty ---


def drawn(one: Scenario, count: int) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(1)
    values = {
        name: (given_.quantity.value + given_.spread * rng.standard_normal(count))[:, None]
        for name, given_ in one.inputs.items()
    }
    errors = rng.standard_normal((count, 2))
    errors[:, 1] = one.known.correlation * errors[:, 0] + math.sqrt(1 - one.known.correlation**2) * errors[:, 1]
    for place, name in enumerate(("curved_coefficient", "flat_coefficient")):
        given_ = one.inputs[name]
        values[name] = np.maximum(given_.quantity.value + given_.spread * errors[:, [place]], 0.0)
    return values


@pytest.mark.slow
@pytest.mark.parametrize("convention", others_slow(CONVENTIONS, first=1))
@pytest.mark.parametrize("correlation", [-0.6, 0.9])
def test_uncertainty_is_that_of_draws(convention, correlation):
    one = scenario(convention, correlation=correlation)
    (point,) = predict_wear(one, [1e6]).prediction
    values = drawn(one, 10_000)
    pair = disc_pair(one.contact, values, convention)
    state = pair.worn(np.array([1e6]), values["curved_coefficient"], values["flat_coefficient"])
    stated = {field: getattr(point.contact, name) for name, field in CONTACT.items()} | {"slip": point.slip}
    for name, found in stated.items():
        spread = float(np.std(getattr(state, name)))
        assert found.standard_uncertainty == pytest.approx(spread, rel=0.05), name
    both = float(np.std(state.curved_depth + state.flat_depth))
    assert point.contact.approach.standard_uncertainty == pytest.approx(both, rel=0.05)


def test_uncertainty_of_an_unworn_disc_is_none():
    known = known_pair(k_d(K_1, 0.05))
    (point,) = predict_wear(scenario(known=known), [1e6]).prediction
    assert point.bodies["flat_disc"].wear_volume.value == 0
    assert point.bodies["flat_disc"].wear_volume.standard_uncertainty == 0
    assert point.bodies["curved_disc"].wear_volume.standard_uncertainty > 0


def test_flat_disc_that_may_have_worn_after_all_is_as_uncertain_as_its_k_d():
    """k₂ = 0 ± 0.1 k₁, as of a disc on which no wear was found."""
    flat = Quantity(value=0.0, unit="m^2/N", standard_uncertainty=0.1 * K_1)
    (point,) = predict_wear(scenario(known=known_pair(k_d(K_1, 0.05), flat)), [1e6]).prediction
    assert point.bodies["flat_disc"].wear_volume.value == 0
    once = worn(1e6, second=0.1 * K_1)
    assert point.bodies["flat_disc"].wear_volume.standard_uncertainty == pytest.approx(float(once.flat_volume), rel=0.1)


@pytest.mark.parametrize("share", [0.5, 1.0])
def test_wide_uncertainty_of_k_d_stays_first_order(share):
    (point,) = predict_wear(scenario(first=share), [1e6]).prediction
    slope = (worn(1e6, first=1.01 * K_1).curved_volume - worn(1e6, first=0.99 * K_1).curved_volume) / 0.02
    assert point.bodies["curved_disc"].wear_volume.standard_uncertainty == pytest.approx(float(share * slope), rel=0.05)


@pytest.mark.slow
def test_own_end_values_come_back_from_a_fit():
    run = exact_run({"curved_disc_wear_volume": 0.05, "flat_disc_wear_volume": 0.06})
    fit = fit_discs(run, recipe=recipe())
    known = known_wear(fit)
    assert known.bodies == {name: body.wear_coefficient for name, body in fit.bodies.items()}
    assert (known.correlation, known.distance) == (fit.correlation, "full-slip")
    (point,) = predict_wear(scenario(known=known), [1e6]).prediction
    ends = run.manifest.end_values
    assert point.bodies["curved_disc"].wear_volume.value == pytest.approx(ends.curved_disc_wear_volume.value, rel=1e-9)
    assert point.bodies["flat_disc"].wear_volume.value == pytest.approx(ends.flat_disc_wear_volume.value, rel=1e-9)


# --- the paper's steps ---


@pytest.mark.slow
@pytest.mark.parametrize("convention", others_slow(CONVENTIONS, first=1))
def test_published_steps_close_in_on_the_exact_scheme(convention):
    errors = []
    for steps in (500, 5_000):
        found = predict_wear(scenario(convention), [1e6, 5e5], scheme="published", steps=steps)
        assert (found.scheme, found.steps) == ("published", steps)
        exact = predict_wear(scenario(convention), [1e6]).prediction[0].bodies["curved_disc"].wear_depth.value
        shown = found.prediction[0].bodies["curved_disc"].wear_depth.value
        assert found.step_error == pytest.approx(shown / exact - 1, rel=1e-9)
        errors.append(abs(found.step_error))
    assert errors[1] < errors[0]


def test_published_steps_are_those_of_the_scheme():
    one = scenario()
    found = predict_wear(one, [2e5, 1e5], scheme="published", steps=400)
    state = one.published(np.linspace(0, 2e5, 401), 400)
    for point, place in zip(found.prediction, (400, 200), strict=True):
        assert point.bodies["curved_disc"].wear_volume.value == pytest.approx(state["curved_volume"][place], rel=1e-12)
        assert point.contact.half_width.value == pytest.approx(state["half_width"][place], rel=1e-12)


def test_published_takes_a_step_a_rotation_unless_told():
    found = predict_wear(scenario(), [1500.5], scheme="published")
    assert found.steps == 1501
    assert predict_wear(scenario(), [0.0], scheme="published").prediction[0].contact.approach.value == 0


def test_coarse_steps_are_owned_up_to():
    found = predict_wear(scenario(), [1e6], scheme="published", steps=10)
    assert any(note.startswith("with 10 Euler steps of 1e+05 rotations, the final depth is ") for note in found.notes)


@pytest.mark.parametrize("steps", [0, -1, MOST_STEPS + 1])
def test_steps_that_cannot_be_waited_for_are_refused(steps):
    with pytest.raises(FitError, match=r"published scheme: found .* steps; expected 1 to 5,000,000"):
        scenario().published(np.array([1e6]), steps)


def test_a_rotation_at_a_time_of_too_many_is_refused():
    with pytest.raises(FitError, match="--steps"):
        predict_wear(scenario(), [1e8], scheme="published")


# --- what is said beside, and refused ---


def notes(at, **changes) -> str:
    return " | ".join(predict_wear(scenario(**changes), [at]).notes)


def test_nothing_is_said_of_a_sound_prediction():
    document = RunManifest.model_validate(DOCUMENT).model_dump(by_alias=True)
    assert notes(1e6) == ""
    assert document["id"] == "discs"


def test_flat_of_half_the_crown_is_noted():
    known = known_pair(k_d(2000 * K_1, 0.1), k_d(2000 * K_2, 0.1))
    assert "the worn flat is 5.1" in notes(1e6, known=known)
    assert "more than the crown radius of" in notes(1e6, known=known)


@pytest.mark.parametrize("disc", ["curved_disc", "flat_disc"])
def test_flat_wider_than_a_disc_is_noted(disc):
    contact = BARE.described
    width = {"width": Quantity(value=0.15e-3, unit="m")}
    contact = contact.model_copy(update={disc: getattr(contact, disc).model_copy(update=width)})
    assert "wider than the disc (0.15 mm)" in notes(1e6, contact=contact)
    assert notes(1e4, contact=contact) == ""


def test_slip_changed_by_wear_is_noted():
    known = known_pair(k_d(300 * K_1, 0.1), k_d(300 * K_2, 0.1))
    assert "wear changes the slip from 4.00 % to 5.30 % at constant rotational speeds" in notes(1e6, known=known)


def test_k_d_without_uncertainty_is_noted():
    assert "k_D is assumed to be exact" in notes(1e6, known=known_pair(k_d(K_1), k_d(K_2)))


def test_defaults_are_named():
    bare = {name: BODY[name] for name in ("material", "poisson_ratio")} | {"youngs_modulus": "304 GPa"}
    document = DOCUMENT | {
        "contact": {
            "kind": "twin-disc",
            "curved_disc": bare | {"rolling_radius": "4 mm", "crown_radius": "4 mm"},
            "flat_disc": bare | {"rolling_radius": "4 mm"},
        }
    }
    said = notes(1e6, contact=RunManifest.model_validate(document).described)
    assert said.startswith(
        "default uncertainty used for crown radius 4.0000 ± 0.0080 mm, rolling radius of the crowned disc"
    )


@pytest.mark.parametrize("at", [[-1.0], [float("nan")], [1e5, float("inf")]])
def test_rotations_that_are_no_count_are_refused(at):
    with pytest.raises(FitError, match=r"prediction: found rotations \[.*\]; expected no negative values"):
        predict_wear(scenario(), at)


@pytest.mark.parametrize("scheme", ["exact", "published"])
def test_wear_beyond_the_crown_is_refused(scheme):
    known = known_pair(k_d(1e5 * K_1, 0.1), k_d(1e5 * K_2, 0.1))
    with pytest.raises(ContactError, match="crown"):
        predict_wear(scenario(known=known), [1e6], scheme=scheme, steps=1000)


@pytest.mark.parametrize("depth", [4e-3, 1.0, float("inf")])
def test_depth_beyond_the_crown_is_refused(depth):
    with pytest.raises((ContactError, FitError)):
        predict_wear(scenario(), depths=[depth])


@pytest.mark.parametrize("depth", [0.0])
def test_no_depth_is_reached_at_once(depth):
    (reached,) = predict_wear(scenario(), depths=[depth]).reached
    assert reached.rotations.value == 0


@pytest.mark.parametrize("depth", [-1e-6, float("nan")])
def test_depth_that_is_none_is_refused(depth):
    with pytest.raises((ContactError, FitError)):
        predict_wear(scenario(), depths=[depth])


def test_depth_of_a_curved_disc_that_does_not_wear_is_refused():
    known = known_pair(Quantity(value=0.0, unit="m^2/N"), k_d(K_2, 0.1))
    with pytest.raises(FitError, match="a crowned disc that does not wear"):
        predict_wear(scenario(known=known), depths=[1e-6])


def test_elastic_contact_as_large_as_the_crown_is_refused():
    contact = BARE.described
    tiny = contact.curved_disc.model_copy(update={"crown_radius": Quantity(value=1e-9, unit="m")})
    with pytest.raises(ContactError, match="elastic contact as large as the crown"):
        predict_wear(scenario(contact=contact.model_copy(update={"curved_disc": tiny})), [1e6])


def test_sarkar_without_friction_is_refused():
    with pytest.raises(FitError, match=r"Sarkar's law: found no friction coefficient"):
        predict_wear(scenario(model="sarkar"), [1e6])


def test_another_slip_wears_in_proportion_while_little_is_worn():
    little, much = (predict_wear(scenario(slip=ratio(value)), [1e6]).prediction[0] for value in (0.04, 0.1))
    assert much.bodies["curved_disc"].wear_volume.value > 2.4 * little.bodies["curved_disc"].wear_volume.value
    assert Recipe().wear.distance_per_rotation == "full-slip"

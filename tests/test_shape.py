"""The shape of one run's curve: p-values that mean what they say, and departures from the law that are found."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pytest
from sweeps import others_slow
from test_identify import CASES, record

from tribopipe.base.arrays import Column
from tribopipe.base.errors import FitError
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName, Recipe, WearRecipe
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.friction import fit_friction
from tribopipe.evaluation.study.member import Member
from tribopipe.evaluation.study.recorded_runs import Shape, compare_laws
from tribopipe.physics.geometry import cap_radius
from tribopipe.physics.hertz import contact_modulus
from tribopipe.physics.pin_on_disc import SphericalPin
from tribopipe.results.run import RawRun

LIGHT, HEAVY, CARBIDE = "si3n4-air-200mN", "si3n4-air-800mN", "wc-co-water-400mN"
SLOW = {"sampling_rate": Quantity(value=2.0, unit="1/s")}
"""A fifth of the samples, as good as all of them: the noise remembers itself for 2 s."""


def shape_of(raw: RawRun, law: LawName = "archard") -> Shape:
    friction = fit_friction(raw) if law == "sarkar" else None
    return Shape(Member(correct_drift(raw), friction).pose(law, Recipe()))


def seeded(run_id: str, seed: int, law: LawName = "archard", **sensors) -> RawRun:
    series, run = CASES[run_id]
    return record(series.model_copy(update={"law": law}), run, seed=seed, sensors=SLOW | sensors)


def with_depth(raw: RawRun, added: Column) -> RawRun:
    """The run with something added to its depth reading, m."""
    return replace(raw, columns={**raw.columns, "depth": raw.columns["depth"] + added})


def changed(run_id: str, seed: int, ratio: float, at: float) -> RawRun:
    """A run whose k_D is ``ratio`` times as large after a share ``at`` of the distance, measured end value and all."""
    raw, run = seeded(run_id, seed), CASES[run_id][1]
    contact, distance = raw.manifest.contact, raw.sliding_distance
    modulus = contact_modulus(
        pin_modulus=contact.pin.youngs_modulus.value,
        pin_ratio=contact.pin.poisson_ratio.value,
        disc_modulus=contact.disc.youngs_modulus.value,
        disc_ratio=contact.disc.poisson_ratio.value,
    )
    load, radius = run.normal_load.value, contact.pin.radius.value
    pin = SphericalPin(normal_load=load, radius=radius, modulus=modulus)
    change = at * distance[-1]
    travelled = np.minimum(distance, change) + ratio * np.maximum(distance - change, 0.0)
    steady, other = (pin.worn(run.wear_coefficient.value * load * path).depth for path in (distance, travelled))
    end = raw.manifest.end_values
    error = end.pin_scar_diameter.value - 2 * float(cap_radius(height=steady[-1], sphere_radius=radius))
    scar = 2 * float(cap_radius(height=other[-1], sphere_radius=radius)) + error
    end = end.model_copy(
        update={"pin_scar_diameter": end.pin_scar_diameter.model_copy(update={"value": scar})},
    )
    manifest = raw.manifest.model_copy(update={"end_values": end})
    return with_depth(replace(raw, manifest=manifest), other - steady)


def bump(raw: RawRun, height: float) -> Column:
    """A smooth hill halfway along the run, m."""
    share = raw.sliding_distance / raw.sliding_distance[-1]
    return height * np.exp(-(((share - 0.5) / 0.2) ** 2))


# --- under the law ---


def sound_shape(seed: int) -> Shape:
    return shape_of(seeded((LIGHT, CARBIDE)[seed % 2], 3_000 + seed))


@pytest.fixture(scope="module")
def sound() -> list[Shape]:
    """Sixty runs of which the law is true, half of them in each condition."""
    return [sound_shape(seed) for seed in range(60)]


@pytest.mark.slow
def test_trends_of_sound_runs_are_as_improbable_as_they_say(sound):
    told = np.array([shape.trend().p_value for shape in sound])
    assert np.all((told > 0) & (told <= 1))
    assert 0.02 <= np.mean(told < 0.1) <= 0.22
    assert 0.3 <= np.mean(told < 0.5) <= 0.7


@pytest.mark.slow
def test_changes_of_sound_runs_are_as_improbable_as_they_say(sound):
    told = np.array([shape.change_point().p_value for shape in sound])
    assert np.all((told > 0) & (told <= 1))
    assert 0.02 <= np.mean(told < 0.1) <= 0.22
    assert 0.3 <= np.mean(told < 0.5) <= 0.7


@pytest.mark.slow
def test_residuals_of_sound_runs_are_as_large_as_their_noise(sound):
    # What is fitted: k_D, one zero offset, drift.
    reduced = [shape.sum_of_squares / (len(shape.residual) - 3) for shape in sound]
    assert np.mean(reduced) == pytest.approx(1, abs=4 * math.sqrt(2 / (37 * len(sound))))


@pytest.mark.slow
def test_residuals_hold_nothing_that_k_d_offset_or_drift_explain():
    for shape in (sound_shape(seed) for seed in range(6)):
        distance = shape.problem.distance
        for column in (np.ones_like(distance), shape.problem.trace.ramp, shape.slope):
            assert np.linalg.norm(shape.left_of(column)) < 1e-8 * np.linalg.norm(column * shape.root)


@pytest.mark.slow
@pytest.mark.parametrize("run_id", [LIGHT, CARBIDE])
def test_offset_and_drift_are_no_trend_and_no_change(run_id):
    raw = seeded(run_id, 11)
    plain = shape_of(raw)
    drifted = shape_of(with_depth(raw, 2e-6 - 1e-6 * raw.columns["time"] / raw.columns["time"][-1]))
    assert plain.trend().p_value > 0.05
    assert drifted.trend().p_value == pytest.approx(plain.trend().p_value, rel=1e-3)
    assert drifted.trend().amplitude.value == pytest.approx(plain.trend().amplitude.value, rel=1e-3, abs=0)
    assert drifted.change_point().p_value == pytest.approx(plain.change_point().p_value, abs=2e-3)
    assert drifted.coefficient == pytest.approx(plain.coefficient, rel=1e-6, abs=0)


# --- departures from the law ---


@pytest.mark.slow
@pytest.mark.parametrize("run_id", [LIGHT, HEAVY, CARBIDE])
def test_a_smooth_bump_is_a_trend(run_id):
    raw = seeded(run_id, 12)
    assert shape_of(with_depth(raw, bump(raw, 0.5e-6))).trend().p_value < 1e-3
    assert shape_of(raw).trend().p_value > 0.05


def test_amplitude_is_that_of_what_wear_offset_and_drift_leave_of_a_trend():
    raw = seeded(LIGHT, 13)
    share = raw.sliding_distance / raw.sliding_distance[-1]
    trend = 10e-6 * share**1.5
    # Wear of a sphere grows about as √s, as does its change with k_D.
    beside = np.column_stack([np.ones_like(share), share, np.sqrt(share)])
    left = trend - beside @ np.linalg.lstsq(beside, trend)[0]
    shape = shape_of(with_depth(raw, trend))
    found = shape.trend().amplitude
    assert found.value == pytest.approx(np.sqrt(np.mean(left**2)), rel=0.2, abs=0)
    assert found.unit == "m"


@pytest.mark.slow
@pytest.mark.parametrize("run_id", [LIGHT, HEAVY])
@pytest.mark.parametrize(("ratio", "at"), [(0.5, 0.5), (0.5, 0.3), (2.0, 0.4)])
def test_a_change_of_k_d_is_found_where_it_was_made(run_id, ratio, at):
    for seed in (21, 22, 23):
        shape = shape_of(changed(run_id, seed, ratio, at))
        found = shape.change_point()
        assert found.p_value < 0.01
        assert found.sliding_distance.value == pytest.approx(at * 500, abs=0.15 * 500)
        assert found.rate_ratio == pytest.approx(ratio, rel=0.2)
        assert shape.trend().p_value < 0.01


def test_a_change_that_is_none_is_not_found():
    shape = shape_of(changed(LIGHT, 24, 1.0, 0.5))
    assert shape.change_point().p_value > 0.05
    assert shape.change_point().rate_ratio == pytest.approx(1, abs=0.3)


def test_a_change_of_k_d_goes_by_the_law_s_own_distance():
    raw = changed(HEAVY, 25, 0.5, 0.5)
    assert shape_of(raw, "sarkar").change_point().rate_ratio == pytest.approx(0.5, rel=0.3)


def test_a_change_is_held_against_noise_of_the_seed_that_is_told():
    shape = shape_of(seeded(LIGHT, 27))
    first, again, other = (shape.change_point(seed).p_value for seed in (1, 1, 2))
    assert first == again == shape.change_point().p_value
    assert other != first
    assert other == pytest.approx(first, abs=0.05)


def test_a_run_of_few_samples_has_no_change_point():
    raw = seeded(LIGHT, 26)
    # Samples in seven clumps: as many stretches.
    kept = np.concatenate([np.arange(first, first + 4) for first in np.linspace(0, len(raw) - 4, 7).astype(int)])
    few = replace(raw, columns={name: column[kept] for name, column in raw.columns.items()})
    assert shape_of(few).change_point() is None
    assert 0 < shape_of(few).trend().p_value <= 1


# --- one law against the others ---

OWN = ("archard", "dissipated_energy", "running_in", "sarkar")
GIVEN = Recipe(wear=WearRecipe(parameters={"running_in": {"excess": 1.0, "length": "50 m"}}))


def comparison(raw: RawRun, laws: Sequence[LawName] = ("archard", "sarkar")):
    friction = fit_friction(raw)
    return compare_laws({law: Shape(Member(correct_drift(raw), friction).pose(law, GIVEN)) for law in laws})


@pytest.mark.parametrize("truth", ["archard", "sarkar"])
@pytest.mark.parametrize("seed", [31, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (32, 33, 34))])
def test_the_law_that_a_run_was_made_with_is_preferred(truth, seed):
    found = comparison(seeded(LIGHT, seed, truth))
    assert found.preferred == truth
    assert min(found.delta_aic.values()) == found.delta_aic[truth] == 0.0


@pytest.mark.parametrize("truth", others_slow(OWN))
@pytest.mark.parametrize("seed", [51, pytest.param(52, marks=pytest.mark.slow)])
def test_no_other_law_is_preferred_to_the_one_that_a_run_was_made_with(truth, seed):
    """Running-in, whatever the study gives of it, costs two parameters more than the other laws."""
    found = comparison(run_in(seed) if truth == "running_in" else seeded(LIGHT, seed, truth), OWN)
    assert found.preferred in (truth, None)
    assert found.delta_aic[truth] < 2
    others = [law for law in OWN if law not in (truth, "running_in")]
    assert all(found.delta_aic[law] > 2 for law in others)


def run_in(seed: int) -> RawRun:
    series, run = CASES[LIGHT]
    changes = {"law": "running_in", "law_parameters": {"excess": 4.0, "length": "60 m"}}
    changed = type(series).model_validate(series.model_dump(exclude_unset=True) | changes)
    return record(changed, run, seed=seed, sensors=SLOW)


@pytest.mark.slow
@pytest.mark.parametrize("truth", others_slow(["archard", "sarkar"], "sarkar"))
def test_no_law_is_preferred_where_wear_is_slight(truth):
    found = [comparison(seeded(CARBIDE, seed, truth)) for seed in (41, 42, 43)]
    assert [one.preferred for one in found] == [None] * 3
    assert max(max(one.delta_aic.values()) for one in found) < 2


def test_aic_is_that_of_the_sum_of_squares():
    raw = seeded(LIGHT, 35)
    archard, sarkar = shape_of(raw, "archard"), shape_of(raw, "sarkar")
    n, p = len(archard.residual), 4  # k_D, zero offset, drift and variance
    for shape in (archard, sarkar):
        aic = n * math.log(shape.residual @ shape.residual / n) + 2 * p + 2 * p * (p + 1) / (n - p - 1)
        assert shape.aic() == pytest.approx(aic, rel=1e-12)
    assert compare_laws({"archard": archard, "sarkar": archard}).preferred is None
    assert compare_laws({"archard": archard}) is None


def level(seed: int, law: LawName, sensors: Mapping[str, Quantity]) -> RawRun:
    """A run with the same friction all along."""
    series, run = CASES[LIGHT]
    constant = run.friction.model_copy(update={"amplitude": Quantity(value=0.0, unit="1")})
    series = series.model_copy(update={"law": law})
    return record(series, run.model_copy(update={"friction": constant}), seed=seed, sensors=SLOW | sensors)


def test_laws_that_constant_friction_makes_the_same_are_not_discriminated():
    quiet = {"friction_noise": Quantity(value=0.0, unit="1"), "load_noise": Quantity(value=0.0, unit="1")}
    found = comparison(level(61, "archard", quiet), ("archard", "dissipated_energy", "sarkar"))
    assert found.preferred is None
    assert max(found.delta_aic.values()) < 0.5


@pytest.mark.slow
@pytest.mark.parametrize("truth", ["archard", "dissipated_energy"])
def test_noise_of_constant_friction_does_not_decide_between_laws(truth):
    """It shifts AIC by several units, against the laws that friction enters."""
    found = [comparison(level(seed, truth, {}), ("archard", "dissipated_energy")) for seed in range(71, 77)]
    assert max(max(one.delta_aic.values()) for one in found) > 2
    assert [one.preferred for one in found] == [None] * 6


def test_law_whose_parameters_a_run_does_not_determine_is_not_compared(monkeypatch):
    def indistinct(_):
        raise FitError("wear fit: found a depth signal from which k_D and length cannot be separated")

    monkeypatch.setattr("tribopipe.evaluation.study.recorded_runs.with_fitted_law", indistinct)
    assert set(comparison(seeded(LIGHT, 36), OWN).delta_aic) == {"archard", "dissipated_energy", "sarkar"}

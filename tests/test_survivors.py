"""What no other default test had noticed when it was changed: by closed forms and by hand."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from test_agreement import LIGHT, TWO_STEP, member
from test_shape import changed

from tribopipe.archive.definitions.parts import shown_fields
from tribopipe.documents.manifest import EndValues
from tribopipe.documents.recipe import Recipe
from tribopipe.documents.record import Record
from tribopipe.evaluation.checks.material_ranges import CLASSES
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.study.member import Member
from tribopipe.evaluation.study.recorded_runs import life_of_pin
from tribopipe.evaluation.wear.findings import rate_change, wear_findings
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.physics.geometry import worn_volume
from tribopipe.readers.long_text import _both_ends


@pytest.fixture(scope="module")
def reference() -> Member:
    """A run whose k_D is known."""
    return member(LIGHT, "light", seed=1)


def test_noise_makes_k_d_as_uncertain_as_weighted_least_squares_has_it(reference):
    # Var(ln k_D) = σ²/Σ n·s², of rows that are means over n samples, with slopes s and the noise σ of one.
    problem = reference.pose("archard", TWO_STEP).problem
    assert np.ptp(problem.weights) > 0
    best = problem.coefficient()
    _, slope = problem.model(np.log(best), problem.values)
    by_hand = np.sqrt(problem.noise / float(problem.weights @ slope**2))
    assert problem.random_uncertainty(best) == pytest.approx(by_hand, rel=1e-9)


@pytest.mark.parametrize(("ratio", "at"), [(3.0, 0.4), (4.0, 0.35), (0.42, 0.53)])
def test_a_change_of_the_wear_rate_is_found_where_and_as_large_as_it_was_made(ratio, at):
    raw = changed("si3n4-air-200mN", seed=1, ratio=ratio, at=at)
    problem = Member(correct_drift(raw), None).pose("archard", Recipe()).problem
    found = rate_change(problem)
    assert found.distance == pytest.approx(at * 500, abs=0.03 * 500)
    assert found.ratio == pytest.approx(ratio, rel=0.15)


def test_wear_that_stops_is_not_called_another_k_d():
    """A motor that stands still while the clock and the recording run on."""
    raw = changed("si3n4-air-200mN", seed=1, ratio=1e-6, at=0.8)
    problem = Member(correct_drift(raw), None).pose("archard", Recipe()).problem
    (found,) = (finding for finding in wear_findings(problem) if finding.code == "wear_rate_changes")
    assert "wear stops after about 400 m" in found.message
    assert "delete the rows" in found.remedy


@pytest.mark.slow
@pytest.mark.usefixtures("few_draws")
@pytest.mark.parametrize(("measured", "words"), [(True, "is the mean over the test"), (False, "is not the mean")])
def test_k_d_is_called_the_mean_over_the_test_if_the_wear_was_measured(measured, words):
    raw = changed("si3n4-air-200mN", seed=1, ratio=4.0, at=0.35)
    if not measured:
        raw = replace(raw, manifest=raw.manifest.model_copy(update={"end_values": EndValues()}))
    fit = fit_wear(correct_drift(raw))
    (found,) = (finding for finding in fit.findings if finding.code == "wear_rate_changes")
    assert words in found.message
    assert ("measure the scar" in found.remedy) != measured


@pytest.mark.usefixtures("few_draws")
def test_life_by_archard_s_law_ends_where_k_d_load_and_distance_make_the_volume(reference):
    posed = reference.pose("archard", TWO_STEP)
    draws = posed.draw(np.random.default_rng(1), 400, {})
    depth, load, radius = 10e-6, 0.2, 0.794e-3
    found = life_of_pin(draws, np.full(400, posed.coefficient), depth)
    # A cap without the elastic approach, which is a few nm of 10 µm.
    expected = float(worn_volume(depth=depth, sphere_radius=radius)) / (posed.coefficient * load)
    assert found.place.value == pytest.approx(expected, rel=0.01)


def test_both_ends_of_a_long_text_have_no_line_twice():
    text = b"1\n2\n3\n4\n5\n"
    survey = SimpleNamespace(size=len(text), head=text[:4], tail=text[-8:])
    # The first line after the head may be cut, and is left out.
    assert _both_ends(survey) == b"1\n2\n4\n5\n"


class Told(Record):
    """A record for its declaration."""

    needed: float
    perhaps: float | None = None
    text: str


def test_declaration_of_a_record_requires_what_it_always_has():
    assert [(one.name, one.kind, one.required) for one in shown_fields(Told)] == [
        ("needed", "NX_FLOAT", True),
        ("perhaps", "NX_FLOAT", False),
        ("text", "NX_CHAR", True),
    ]


def test_no_cobalt_chromium_alloy_is_as_dense_as_nickel_tungsten():
    # ASTM F75, F90 and F562: 8.3 to 9.2 g/cm³.
    (alloy,) = [one for one in CLASSES if one.title == "cobalt-chromium alloy"]
    assert alloy.density[0] <= 8.3e3 / 1e3
    assert 9.2 <= alloy.density[1] < 10

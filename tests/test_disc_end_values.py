"""What was measured on two discs, as wear depth, and what that makes of the drift."""

import math

import numpy as np
import pytest
from disc_runs import BARE, DOCUMENT, PLANNED, SERIES, exact_run, raw, recorded, with_ends
from hypothesis import given
from hypothesis import strategies as st

from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.quantity import EndValue, Quantity
from tribopipe.documents.recipe import DefaultUncertainty, Recipe, WearRecipe
from tribopipe.evaluation.checks.end_values import impossible_measurement
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.measurements.twin_disc import disc_end_wear, disc_measurements, twin_disc_wear
from tribopipe.extras.simulate import VirtualTwinDiscTest
from tribopipe.readers.harmonize import read_run
from tribopipe.results.run import RawRun

CROWN, RADIUS = 4e-3, 4e-3
ALL = tuple(
    f"{disc}_{what}" for disc in ("curved_disc", "flat_disc") for what in ("wear_depth", "wear_volume", "track_width")
)


def length(value: float, spread: float | None = None) -> dict:
    return {"value": value, "unit": "m", "standard_uncertainty": spread}


def volume(value: float, spread: float | None = None) -> dict:
    return {"value": value, "unit": "m^3", "standard_uncertainty": spread}


def stiff() -> RunManifest:
    """Discs under next to no load, which do not flatten: the worn crown is a segment of a circle."""
    document = RunManifest.model_validate(DOCUMENT).model_dump(by_alias=True)
    document["conditions"]["normal_load"] = {"value": 1e-12, "unit": "N", "standard_uncertainty": 0.0}
    return RunManifest.model_validate(document)


def segment(depth: float) -> float:
    """Cross-section, m², of a circle's segment of this height."""
    return CROWN**2 * math.acos(1 - depth / CROWN) - (CROWN - depth) * math.sqrt(2 * CROWN * depth - depth**2)


DEPTHS = st.floats(math.log(1e-7), math.log(3e-4)).map(math.exp)


@pytest.mark.slow
@given(DEPTHS, st.floats(0.05, 1.0))
def test_volumes_give_the_height_of_the_segment_where_nothing_is_elastic(depth, share):
    around = 2 * math.pi * RADIUS * segment(depth)
    ends = {"curved_disc_wear_volume": volume(share * around), "flat_disc_wear_volume": volume((1 - share) * around)}
    wear = disc_end_wear(raw(ends, manifest=stiff()), Recipe())
    assert wear.total.value == pytest.approx(depth, rel=1e-4)
    assert wear.anchor == "curved_disc_wear_volume + flat_disc_wear_volume"


@given(DEPTHS, st.sampled_from(["curved_disc", "flat_disc"]))
def test_width_gives_the_height_of_the_segment_where_nothing_is_elastic(depth, disc):
    width = 2 * math.sqrt(2 * CROWN * depth - depth**2)
    wear = disc_end_wear(raw({f"{disc}_track_width": length(width)}, manifest=stiff()), Recipe())
    assert wear.total.value == pytest.approx(depth, rel=1e-4)
    assert wear.anchor == f"{disc}_track_width"


@pytest.mark.parametrize("depth", [0.8e-6, 5e-6, 80e-6])
def test_uncertainty_is_that_of_what_was_measured_over_its_slope(depth):
    spread = 0.01
    around, width = 2 * math.pi * RADIUS * segment(depth), 2 * math.sqrt(2 * CROWN * depth - depth**2)
    ends = {f"{disc}_wear_volume": volume(around / 2, spread * around / 2) for disc in ("curved_disc", "flat_disc")}
    by_volume = disc_end_wear(raw(ends, manifest=stiff()), Recipe()).total
    # dA/dh is the width.
    expected = spread * segment(depth) / math.sqrt(2) / width
    assert by_volume.standard_uncertainty == pytest.approx(expected, rel=2e-3)
    by_width = disc_end_wear(
        raw({"curved_disc_track_width": length(width, spread * width)}, manifest=stiff()), Recipe()
    ).total
    assert by_width.standard_uncertainty == pytest.approx(spread * width**2 / 4 / (CROWN - depth), rel=2e-3)


def test_depths_add_up():
    ends = {"curved_disc_wear_depth": length(1.2e-6, 3e-8), "flat_disc_wear_depth": length(0.5e-6, 4e-8)}
    wear = disc_end_wear(raw(ends), Recipe())
    assert wear.total.value == pytest.approx(1.7e-6, rel=1e-12)
    assert wear.total.standard_uncertainty == pytest.approx(5e-8, rel=1e-9)
    assert wear.anchor == "curved_disc_wear_depth + flat_disc_wear_depth"


@pytest.mark.parametrize("name", ["curved_disc_wear_depth", "curved_disc_wear_volume", "curved_disc_track_width"])
def test_disc_on_which_nothing_was_measured_counts_as_unworn(name):
    run = exact_run({name: 0.02}, second=0.0)
    state = run.manifest.end_values
    wear = disc_end_wear(run, Recipe())
    assert wear.anchor == name
    depth = exact_run({"curved_disc_wear_depth": 0.02}, second=0.0).manifest.end_values.curved_disc_wear_depth.value
    assert wear.total.value == pytest.approx(depth, rel=2e-4)
    assert state.flat_disc_wear_depth is None


@pytest.mark.parametrize("convention", ["full-slip", "contact-width", "volume-conserving"])
def test_all_ways_of_measuring_give_the_same_depth(convention):
    run = exact_run(dict.fromkeys(ALL, 0.02), convention=convention)
    ends = run.manifest.end_values
    depth = ends.curved_disc_wear_depth.value + ends.flat_disc_wear_depth.value
    how = Recipe(wear=WearRecipe(distance_per_rotation=convention))
    for kept in (("wear_depth",), ("wear_volume",), ("track_width",)):
        out = {name: None for name in ALL if not name.endswith(kept)}
        wear = disc_end_wear(with_ends(run, **out), how)
        # Of the volumes only their sum is taken, as if the crowned disc alone wore.
        assert wear.total.value == pytest.approx(depth, rel=2e-3), kept


@given(st.permutations([1e-3, 3e-2, 0.2]))
def test_the_most_certain_is_taken(shares):
    kinds = ("wear_depth", "wear_volume", "track_width")
    spreads = dict(zip(kinds, shares, strict=True))
    run = exact_run({name: spreads[name.split("_disc_")[1]] for name in ALL})
    ways = {}
    for kind in kinds:
        out = {name: None for name in ALL if not name.endswith(kind)}
        ways[kind] = disc_end_wear(with_ends(run, **out), Recipe())
    wear = disc_end_wear(run, Recipe())
    assert wear == min(ways.values(), key=lambda one: one.total.standard_uncertainty)


def test_nothing_measured_is_nothing():
    assert disc_end_wear(raw({}), Recipe()) is None
    assert disc_end_wear(raw({"flat_disc_wear_depth": length(1e-6)}), Recipe()) is None


def test_measurements_come_in_the_order_of_the_test_with_their_rotations():
    stops = {1e5: {"flat_disc_wear_depth": 0.1}, 4e5: {"curved_disc_track_width": 0.01}}
    run = exact_run({"flat_disc_wear_volume": 0.1, "curved_disc_wear_volume": 0.1}, stops)
    measured = disc_measurements(run, DefaultUncertainty())
    assert [(one.name, one.place) for one in measured] == [
        ("flat_disc_wear_depth_at_interruption_1", 1e5),
        ("curved_disc_track_width_at_interruption_2", 4e5),
        ("curved_disc_wear_volume", 1e6),
        ("flat_disc_wear_volume", 1e6),
    ]


def test_defaults_stand_in_where_no_uncertainty_was_stated():
    ends = {
        "curved_disc_wear_depth": length(1e-6),
        "curved_disc_wear_volume": volume(4e-12),
        "curved_disc_track_width": length(2e-4),
    }
    spreads = {
        one.what: (one.quantity.standard_uncertainty, one.source)
        for one in disc_measurements(raw(ends), DefaultUncertainty(wear_volume=0.2))
    }
    assert spreads == {
        "wear_depth": (250e-9, "default"),
        "wear_volume": (pytest.approx(0.8e-12), "default"),
        "track_width": (2e-6, "default"),
    }


def weighed(**ends) -> RawRun:
    """A run whose crowned disc, of 3.2 g/cm³, was weighed."""
    document = BARE.model_dump(by_alias=True)
    document["contact"]["curved_disc"]["density"] = "3.2 g/cm^3"
    mass = {"curved_disc_mass_loss": {"value": "0.0128 mg", "standard_uncertainty": "1 %"}}
    return raw(mass | ends, manifest=RunManifest.model_validate(document))


def test_mass_loss_gives_the_wear_volume():
    (found,) = disc_measurements(weighed(), DefaultUncertainty())
    assert (found.name, found.quantity.value) == ("curved_disc_wear_volume", pytest.approx(4e-12))
    assert found.quantity.standard_uncertainty == pytest.approx(4e-12 * math.hypot(0.01, 0.005), rel=1e-4)


@pytest.mark.parametrize(
    "other", [{"curved_disc_wear_volume": volume(4e-12)}, {"curved_disc_profile": [{"file": "crown.csv"}]}]
)
def test_mass_loss_next_to_a_volume_is_refused(other):
    with pytest.raises(ValueError, match="curved_disc_mass_loss: found a mass loss in addition to curved_disc"):
        weighed(**other)


def test_mass_loss_without_density_is_refused_by_check():
    run = raw({"flat_disc_mass_loss": {"value": "0.1 mg"}})
    assert [one.where for one in impossible_measurement(run)] == ["end_values.flat_disc_mass_loss"]
    assert not list(impossible_measurement(weighed()))


def test_flat_disc_measured_at_an_interruption_only_is_not_unworn_at_the_end():
    """Half way it had lost what cannot come back."""
    run = exact_run({"curved_disc_wear_volume": 0.02}, {5e5: {"flat_disc_wear_volume": 0.02}})
    both = exact_run({"curved_disc_wear_volume": 0.02, "flat_disc_wear_volume": 0.02})
    wear = disc_end_wear(run, Recipe())
    if wear is not None:
        assert wear.total.value == pytest.approx(disc_end_wear(both, Recipe()).total.value, rel=0.2)


# --- drift ---


@pytest.mark.slow
@pytest.mark.parametrize("name", ["4pct-250k", "4pct-1000k", "10pct-1000k-a", "10pct-1000k-b"])
def test_drift_of_a_sample_run_comes_back(name):
    test = VirtualTwinDiscTest(SERIES, PLANNED[name])
    truth, correction = test.truth(), correct_drift(recorded(PLANNED[name], off=False)).correction
    assert correction.outcome == "corrected"
    assert correction.anchor == "curved_disc_wear_volume + flat_disc_wear_volume"
    end = truth.end_curved_wear_depth.value + truth.end_flat_wear_depth.value
    for found, true in (
        (correction.drift_rate, truth.drift_rate.value),
        (correction.end_wear_depth, end),
        (correction.zero_offset, truth.zero_offset.value),
    ):
        assert abs(found.value - true) < 3.5 * found.standard_uncertainty
        assert found.standard_uncertainty < max(0.3 * abs(true), 3e-8)
    assert correction.pin_wear_depth is None


def test_corrected_curve_ends_at_the_end_value_and_follows_the_truth():
    sensors = SERIES.sensors.model_copy(
        update={"volume_uncertainty": Quantity(value=1e-4, unit="1"), "depth_noise": Quantity(value=1e-10, unit="m")}
    )
    run = recorded(PLANNED["4pct-1000k"], sensors, off=False)
    corrected = correct_drift(run)
    test = VirtualTwinDiscTest(SERIES, PLANNED["4pct-1000k"])
    true = test.state.curved_depth + test.state.flat_depth
    assert np.max(np.abs(corrected.wear_depth - true)) < 3e-9
    assert corrected.pin_wear_depth is None
    assert corrected.correction.drift_rate.value == pytest.approx(-0.2e-9 / 60, rel=0.02)


@pytest.mark.slow
def test_drift_pulls_follow_a_normal_distribution():
    pulls = []
    for seed in range(30):
        planned = PLANNED["4pct-250k"].model_copy(update={"seed": 500 + seed})
        correction = correct_drift(recorded(planned, off=False)).correction
        found = correction.drift_rate
        pulls.append((found.value - planned.drift_rate.value) / found.standard_uncertainty)
    assert abs(np.mean(pulls)) < 3 / math.sqrt(30)
    assert 0.3 < np.std(pulls) < 1.4  # noise correlated over a whole window counts for more than it is


def test_run_without_depth_or_end_value_passes_through():
    run = recorded(PLANNED["4pct-100k"])
    blind = {name: column for name, column in run.columns.items() if name != "depth"}
    no_depth = correct_drift(type(run)(run.manifest, blind, run.origins, {}, {}, ()))
    assert (no_depth.correction.outcome, no_depth.correction.missing) == ("uncorrected", ("a depth signal",))
    no_end = correct_drift(with_ends(run, curved_disc_wear_volume=None, flat_disc_wear_volume=None))
    assert no_end.correction.missing == (
        "a post-test measurement of the crowned disc (wear depth, track width or wear volume)",
    )
    assert no_end.wear_depth is None


def test_run_read_from_its_folder_is_the_run_in_memory(tmp_path):
    planned = PLANNED["4pct-100k"]
    VirtualTwinDiscTest(SERIES, planned).write(tmp_path / "run")
    read, here = correct_drift(read_run(tmp_path / "run")), correct_drift(recorded(planned, off=False))
    assert read.correction.drift_rate.value == pytest.approx(here.correction.drift_rate.value, rel=0.05)
    assert read.correction.end_wear_depth.value == pytest.approx(here.correction.end_wear_depth.value, rel=1e-4)


@pytest.mark.parametrize("value", [0.0, 1e-15])
def test_discs_without_wear_drift_by_all_they_show(value):
    run = recorded(PLANNED["4pct-100k"], off=False)
    none = EndValue(value=value, unit="m^3", standard_uncertainty=1e-13)
    correction = correct_drift(with_ends(run, curved_disc_wear_volume=none, flat_disc_wear_volume=none)).correction
    shown = correction.end_reading if hasattr(correction, "end_reading") else None
    assert shown is None or shown.value > 0
    assert correction.end_wear_depth.value == pytest.approx(0.0, abs=2e-9)
    assert BARE.contact.kind == "twin-disc"


def test_what_a_volume_was_calculated_from_is_named():
    worn = twin_disc_wear(weighed(), DefaultUncertainty(), None).bodies
    assert [one.name for one in worn["curved_disc"]] == ["curved_disc_mass_loss"]
    stated = twin_disc_wear(raw({"curved_disc_wear_volume": volume(4e-12)}), DefaultUncertainty(), None).bodies
    assert [one.name for one in stated["curved_disc"]] == ["curved_disc_wear_volume"]

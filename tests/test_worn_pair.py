"""Volumes of pin and disc where both wear: from depth, width, scar and volume, in any pair, against exact states."""

import math

import numpy as np
import pytest
from end_value_runs import CIRCLE, RADIUS, STROKE, described, run_of, si
from sweeps import others_slow

from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import DefaultUncertainty
from tribopipe.evaluation.checks.registry import check_run
from tribopipe.evaluation.measurements.pin_on_disc import end_wear, pin_on_disc_wear
from tribopipe.evaluation.measurements.readings import SignalDepths
from tribopipe.evaluation.measurements.specific_wear import specific_wear
from tribopipe.physics.pin_on_track import FlatOnTrack, SphereOnTrack
from tribopipe.physics.stroke_ends import Stroke

DEFAULTS = DefaultUncertainty()

RATIOS = [0.1, 1, 10, 60, 300]
PATH = 2 * math.pi * 8e-3


def state(ratio, tip=None):
    """Si3N4 at 0.2 N over 500 m, with a disc that wears so many times as fast as the pin."""
    volume = 1.35e-14 * 0.2 * 500
    return (tip or SphereOnTrack(RADIUS)).worn(volume, ratio * volume / PATH)


def readings(found, share=1e-4):
    """All end values of a state, each uncertain by a share."""
    volume = float(found.groove_area) * PATH
    values = {
        "pin_wear_depth": (found.pin_depth, "m"),
        "pin_scar_diameter": (found.half_length + found.half_width, "m"),
        "pin_scar_length": (2 * found.half_length, "m"),
        "pin_scar_width": (2 * found.half_width, "m"),
        "pin_wear_volume": (found.pin_volume, "m^3"),
        "disc_wear_depth": (found.groove_depth, "m"),
        "disc_track_width": (2 * found.half_width, "m"),
        "disc_wear_volume": (volume, "m^3"),
    }
    return {name: si(value, unit, share * float(value)) for name, (value, unit) in values.items()}


def wear(given, *names, shape="spherical", path=CIRCLE):
    end = {name: given[name] for name in names}
    return pin_on_disc_wear(run_of(described(shape, path, **end)), DEFAULTS)


@pytest.mark.parametrize("ratio", others_slow(RATIOS, first=2))
@pytest.mark.parametrize(
    "partner", ["disc_track_width", "pin_wear_depth", "pin_scar_diameter", "pin_scar_length", "pin_wear_volume"]
)
def test_disc_volume_from_groove_depth_and_one_more_reading(ratio, partner):
    found = state(ratio)
    disc = wear(readings(found), "disc_wear_depth", partner).bodies["disc"][0]
    truth = float(found.groove_area) * PATH
    assert disc.volume.value == pytest.approx(truth, rel=1e-6)
    assert abs(disc.volume.value - truth) <= 2 * disc.volume.standard_uncertainty
    # The shape is an uncertain input: 3π/16 to 2/3.
    assert disc.volume.standard_uncertainty > 0.03 * truth


@pytest.mark.parametrize("ratio", RATIOS)
def test_disc_volume_from_groove_depth_alone_is_within_its_uncertainty(ratio):
    found = state(ratio)
    worn = wear(readings(found), "disc_wear_depth")
    volume = worn.bodies["disc"][0].volume
    assert abs(volume.value - float(found.groove_area) * PATH) <= 2 * volume.standard_uncertainty
    assert any("the wear of the pin is unknown" in note for note in worn.notes)


@pytest.mark.parametrize("ratio", others_slow([10, 60, 300], 60))
@pytest.mark.parametrize("way", ["pin_wear_depth", "pin_scar_diameter", "pin_scar_length", "pin_wear_volume"])
@pytest.mark.parametrize("beside", ["disc_wear_depth", "disc_track_width", "pin_scar_width", "disc_wear_volume"])
def test_every_pair_tells_both_bodies(ratio, way, beside):
    found = state(ratio)
    worn = wear(readings(found), way, beside)
    pin = next(one for one in worn.bodies["pin"] if one.name == way)
    (disc,) = worn.bodies["disc"]
    assert pin.depth.value == pytest.approx(float(found.pin_depth), rel=1e-6)
    assert pin.volume.value == pytest.approx(float(found.pin_volume), rel=1e-6)
    assert disc.depth.value == pytest.approx(float(found.groove_depth), rel=1e-5)
    assert disc.volume.value == pytest.approx(float(found.groove_area) * PATH, rel=1e-5)


@pytest.mark.parametrize("way", ["pin_scar_diameter", "pin_scar_length", "pin_wear_volume"])
def test_anchor_is_the_depth_in_the_middle_of_both(way):
    found, given = state(300), readings(state(300))
    run = run_of(described(conditions=CIRCLE, **{name: given[name] for name in (way, "disc_wear_depth")}))
    end = end_wear(run, DEFAULTS)
    assert end.total.value == pytest.approx(float(found.approach), rel=1e-6)
    assert end.grown(end.pin_depth.value).pin_depth.value == pytest.approx(end.pin_depth.value, rel=1e-9)


def test_scar_of_unknown_direction_is_as_uncertain_as_it_is_oblong():
    found = state(300)
    given = readings(found)
    run = run_of(described(conditions=CIRCLE, pin_scar_diameter=given["pin_scar_diameter"], disc_wear_depth="41 um"))
    for reading in (2 * found.half_length, 2 * found.half_width):
        off = abs(float(reading) - given["pin_scar_diameter"]["value"])
        assert off < 2 * end_wear(run, DEFAULTS).pin.quantity.standard_uncertainty


@pytest.mark.parametrize("ratio", [1, 60])
def test_flat_pin_tells_the_volume_of_its_track(ratio):
    found = state(ratio, FlatOnTrack(RADIUS))
    (disc,) = wear(readings(found), "pin_wear_depth", "disc_wear_depth", shape="flat").bodies["disc"]
    assert disc.volume.value == pytest.approx(float(found.groove_area) * PATH, rel=1e-6)
    (alone,) = wear(readings(found), "disc_wear_depth", shape="flat").bodies["disc"]
    assert abs(alone.volume.value - float(found.groove_area) * PATH) <= 2 * alone.volume.standard_uncertainty


def test_a_depth_signal_shows_the_pin_beside_a_groove_but_is_no_measurement_of_it():
    found = state(60)
    run = run_of(described(conditions=CIRCLE, disc_wear_depth=readings(found)["disc_wear_depth"]))
    pin_depth = Quantity(value=float(found.pin_depth), unit="m", standard_uncertainty=1e-7)
    alone, together = specific_wear(run), specific_wear(run, signal=SignalDepths(pin=pin_depth))
    volume = float(found.groove_area) * PATH
    assert together.bodies["disc"].volume.value == pytest.approx(volume, rel=1e-3)
    assert together.bodies["disc"].volume.standard_uncertainty < 0.1 * alone.bodies["disc"].volume.standard_uncertainty
    assert together.bodies["pin"].volume is None
    assert any("from disc_wear_depth, the depth signal" in note for note in together.notes)


@pytest.mark.slow
def test_stroke_holds_its_ends_as_well():
    found = state(60)
    given = readings(found)
    (disc,) = wear(given, "pin_wear_depth", "disc_wear_depth", path=STROKE).bodies["disc"]
    run = run_of(described(conditions=STROKE))
    stiffness = run.manifest.contact.reduced_modulus() / run.manifest.conditions.normal_load.value
    stroke = float(Stroke(np.asarray(5e-3), stiffness).extended(found))
    assert stroke == pytest.approx(5.195e-3, abs=5e-6)
    expected = stroke * float(found.groove_area)
    assert disc.volume.value == pytest.approx(expected, rel=1e-6)
    # Ends that wear otherwise: a quarter of half the width of the groove.
    ends = 0.25 * float(found.half_width) / 5e-3
    assert disc.volume.standard_uncertainty > ends * disc.volume.value
    again = wear(given | {"disc_wear_volume": si(expected, "m^3")}, "pin_wear_volume", "disc_wear_volume", path=STROKE)
    assert again.bodies["disc"][0].depth.value == pytest.approx(float(found.groove_depth), rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("wrong", ["disc_wear_depth", "disc_track_width", "pin_scar_diameter"])
def test_contradictions_between_the_bodies_are_named(wrong):
    given = readings(state(60), share=0.01)

    def found(end):
        names = ("pin_wear_depth", "pin_scar_diameter", "disc_wear_depth", "disc_track_width")
        run = run_of(described(conditions=CIRCLE, **{name: end[name] for name in names}))
        return [one for one in check_run(run) if one.code == "measurements_disagree"]

    assert found(given) == []
    changed = {**given[wrong], "value": 1.5 * given[wrong]["value"]}
    findings = found(given | {wrong: changed})
    assert findings
    assert all(one.severity == "warning" for one in findings)
    assert any(wrong in one.message and "not their mean" in one.message for one in findings)


GAINS = ["disc_wear_depth", "disc_track_width", "disc_track_area", "disc_wear_volume"]


@pytest.mark.parametrize("beside", GAINS)
def test_groove_of_a_pin_that_has_gained_is_that_of_an_unworn_one(beside):
    found = SphereOnTrack(RADIUS).worn(0.0, 30e-12)
    given = readings(found) | {"disc_track_area": si(30e-12, "m^2", 3e-15)}
    worn = wear(given | {"pin_wear_volume": si(-5e-15, "m^3", 5e-16)}, "pin_wear_volume", beside)
    (disc,), (pin,) = worn.bodies["disc"], worn.bodies["pin"]
    assert disc.depth.value == pytest.approx(float(found.groove_depth), rel=1e-6)
    assert disc.volume.value == pytest.approx(30e-12 * PATH, rel=1e-6)
    assert disc.depth.standard_uncertainty < 3e-3 * disc.depth.value
    assert (pin.depth, pin.volume.value) == (None, -5e-15)


@pytest.mark.slow
@pytest.mark.parametrize("beside", GAINS)
@pytest.mark.parametrize("lost", [0.0, 0.2e-15, 0.5e-15])
@pytest.mark.parametrize("error", [-1, 0, 1])
def test_groove_beside_a_pin_that_hardly_wore_is_within_its_uncertainty(beside, lost, error):
    """u(V) of the pin is 0.5·10⁻⁶ mm³: at a reading below zero as well, the pin may have worn."""
    found = SphereOnTrack(RADIUS).worn(lost, 30e-12)
    given = readings(found) | {"disc_track_area": si(30e-12, "m^2", 3e-15)}
    read = si(lost + error * 0.5e-15, "m^3", 0.5e-15)
    (disc,) = wear(given | {"pin_wear_volume": read}, "pin_wear_volume", beside).bodies["disc"]
    for quantity, true in ((disc.depth, float(found.groove_depth)), (disc.volume, 30e-12 * PATH)):
        assert abs(quantity.value - true) <= 2.1 * quantity.standard_uncertainty + 1e-9 * true


def test_no_wear_is_as_uncertain_as_a_cap_of_its_uncertainty():
    """0 ± 0.1 µm: a cap of 0.1 µm holds πRh², and with a normal distribution the root mean square is √3 of it."""
    run = run_of(described(pin_wear_depth=si(0.0, "m", 1e-7)))
    (pin,) = pin_on_disc_wear(run, DEFAULTS).bodies["pin"]
    assert pin.volume.value == 0
    assert pin.volume.standard_uncertainty == pytest.approx(math.sqrt(3) * math.pi * RADIUS * 1e-14, rel=1e-3)
    found = specific_wear(run)
    assert found.outcome == "evaluated"
    assert found.pin.specific_wear_rate.standard_uncertainty > 0

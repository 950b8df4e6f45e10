"""End values of pin and disc: every way of measuring comes to the same depth and volume, with its uncertainty."""

import math
import re
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from conftest import MANIFEST
from end_value_runs import (
    CIRCLE,
    DENSITY,
    PIN_WAYS,
    RADIUS,
    SHAPES,
    STROKE,
    described,
    flat_of,
    groove,
    measured,
    run_of,
    si,
    track,
    volume_at,
)
from folders import ROOT
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError
from sweeps import others_slow

from tribopipe.base.errors import FitError
from tribopipe.documents.manifest import Conditions, EndValues, Interruption, RunManifest
from tribopipe.documents.quantity import Quantity, of_readings
from tribopipe.documents.recipe import DefaultUncertainty, MonteCarloRecipe, Recipe, WearRecipe
from tribopipe.evaluation.checks.registry import check_run
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.measurements.pin_on_disc import end_wear, pin_on_disc_wear
from tribopipe.evaluation.measurements.specific_wear import specific_wear
from tribopipe.evaluation.measurements.track_profile import worn_area
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.physics.geometry import cap_height, scar_radius_at, segment_area, worn_volume
from tribopipe.results.run import Profile

DEFAULTS = DefaultUncertainty()
WAYS_AND_SHAPES = [
    (way, shape)
    for way in PIN_WAYS
    for shape in SHAPES
    if not (shape == "flat" and way in ("pin_scar_diameter", "pin_profile"))
]


@pytest.mark.parametrize(("way", "shape"), WAYS_AND_SHAPES)
def test_every_way_of_measuring_the_pin_tells_its_depth_and_volume(way, shape):
    run, depth = measured(way, shape, 5e-6), 5e-6
    wear = end_wear(run, DEFAULTS)
    near = 2e-3 if way == "pin_profile" else 1e-9
    assert (wear.pin.name, wear.anchor) == (way, way)
    assert wear.pin_depth.value == pytest.approx(depth, rel=near)
    (found,) = pin_on_disc_wear(run, DEFAULTS).bodies["pin"]
    assert found.depth.value == pytest.approx(depth, rel=near)
    assert found.volume.value == pytest.approx(volume_at(shape, depth), rel=2 * near)
    assert wear.grown(2 * depth).pin_depth.value == pytest.approx(2 * depth, rel=2 * near)


@pytest.mark.parametrize(("way", "power"), [("pin_wear_volume", 1), ("pin_mass_loss", 0), ("pin_wear_depth", 0)])
def test_volume_is_as_uncertain_in_a_longer_test_relative_to_itself(way, power):
    wear = end_wear(measured(way, "spherical", 5e-6, 0.01), DEFAULTS)
    longer = wear.grown(2 * wear.pin_depth.value)
    times = longer.pin.quantity.value / wear.pin.quantity.value
    assert longer.pin.quantity.standard_uncertainty == pytest.approx(
        times**power * wear.pin.quantity.standard_uncertainty
    )


@pytest.mark.parametrize(("way", "shape"), WAYS_AND_SHAPES)
def test_depth_of_many_draws_is_that_of_each(way, shape):
    wear = end_wear(measured(way, shape, 5e-6, 0.01), DEFAULTS)
    rng = np.random.default_rng(1)
    values = wear.pin.quantity.value * (1 + 0.02 * rng.standard_normal((20, 1)))
    radii = RADIUS * (1 + 0.01 * rng.standard_normal((20, 1)))
    depths = wear.pin_depth_of(values, radii)
    assert depths.shape == (20, 1)
    for value, radius, depth in zip(values[:, 0], radii[:, 0], depths[:, 0], strict=True):
        assert float(wear.pin_depth_of(value, radius)) == pytest.approx(float(depth), rel=1e-12)


@pytest.mark.parametrize(("way", "power"), [("pin_scar_diameter", 2), ("pin_wear_volume", 0.5), ("pin_mass_loss", 0.5)])
def test_uncertainty_of_the_depth_is_that_of_the_end_value(way, power):
    wear = end_wear(measured(way, "spherical", 5e-6, 0.01), DEFAULTS)
    # Of a shallow cap d²/8R deep, πRh² large.
    assert wear.pin_depth.standard_uncertainty == pytest.approx(power * 0.01 * 5e-6, rel=5e-3)


def test_uncertainty_of_the_tip_radius_goes_into_the_volume_of_a_scar():
    run = measured("pin_scar_diameter", "spherical", 5e-6)
    pin = run.manifest.contact.pin
    stated = pin.radius.model_copy(update={"standard_uncertainty": 0.01 * RADIUS})
    contact = run.manifest.contact.model_copy(update={"pin": pin.model_copy(update={"radius": stated})})
    run = replace(run, manifest=run.manifest.model_copy(update={"contact": contact}))
    (found,) = pin_on_disc_wear(run, DefaultUncertainty(unseen_groove=0.0)).bodies["pin"]
    # πd⁴/64R.
    assert found.volume.standard_uncertainty / found.volume.value == pytest.approx(0.01, rel=0.01)


def test_error_of_the_radius_in_a_profile_is_followed():
    run = measured("pin_profile", "spherical", 5e-6)
    wear = end_wear(run, DEFAULTS)
    pin = run.manifest.contact.pin
    wider = pin.model_copy(update={"radius": Quantity(value=1.002 * RADIUS, unit="m")})
    contact = run.manifest.contact.model_copy(update={"pin": wider})
    other = end_wear(replace(run, manifest=run.manifest.model_copy(update={"contact": contact})), DEFAULTS)
    by_slope = float(wear.pin_depth_of(wear.pin.quantity.value, 1.002 * RADIUS))
    assert by_slope == pytest.approx(other.pin_depth.value, abs=0.1 * abs(other.pin_depth.value - wear.pin_depth.value))


@pytest.mark.parametrize("off", [-0.006, -0.004, -0.002, 0.002, 0.004])
@pytest.mark.parametrize("reach", [1.0, 1.6])
def test_profile_of_a_ball_that_is_a_little_off_is_taken(off, reach):
    """Less radius than stated lets all of the flanks stand above the arc through the profile's ends."""
    scar, radius = 300e-6, RADIUS * (1 + off)
    x = np.linspace(-reach * scar, reach * scar, 2000)
    noise = 20e-9 * np.random.default_rng(1).normal(size=len(x))
    track = worn_area(Profile(x, np.sqrt(radius**2 - np.maximum(np.abs(x), scar / 2) ** 2) + noise), RADIUS)
    depth = radius - math.sqrt(radius**2 - scar**2 / 4)
    assert abs(track.depth.value - depth) < 2 * track.depth.standard_uncertainty < 0.15 * depth


def test_of_a_map_of_the_tip_the_deepest_line_counts():
    x = np.linspace(-0.3e-3, 0.3e-3, 1201)
    scar = float(scar_radius_at(depth=5e-6, sphere_radius=RADIUS))
    lines = {}
    for number, y in enumerate(np.linspace(-0.2e-3, 0.2e-3, 41)):
        apart = np.hypot(x, y)
        lines[f"end_values.pin_profile[{number}]"] = Profile(x, np.sqrt(RADIUS**2 - np.maximum(apart, scar) ** 2))
    wear = end_wear(run_of(described(pin_profile={"file": "tip.csv"}), lines), DEFAULTS)
    assert wear.pin_depth.value == pytest.approx(5e-6, rel=5e-3)


def test_surest_end_value_is_taken():
    manifest = described(
        pin_wear_depth=si(5.0e-6, "m", 1e-6),
        pin_wear_volume=si(volume_at("spherical", 5.1e-6), "m^3", 0.02 * volume_at("spherical", 5.1e-6)),
        pin_scar_diameter=si(2 * float(scar_radius_at(depth=5.2e-6, sphere_radius=RADIUS)), "m", 4e-6),
    )
    assert end_wear(run_of(manifest), DEFAULTS).anchor == "pin_wear_volume"


# --- the disc ---


def grooved(shape, half, pin_depth, x):
    """Height across the groove of a pin worn by this depth."""
    scar = float(scar_radius_at(depth=pin_depth, sphere_radius=RADIUS, flat_radius=flat_of(shape)))
    _, profile = groove(half, scar)
    return -np.asarray([profile(min(abs(place), half)) for place in x])


@pytest.mark.slow
@pytest.mark.parametrize("pin_depth", [0.0, 4e-6])
@pytest.mark.parametrize("path", others_slow([CIRCLE, STROKE]))
def test_every_way_of_measuring_the_disc_tells_its_depth_and_volume(path, pin_depth):
    half = 0.12e-3
    flat = float(scar_radius_at(depth=pin_depth, sphere_radius=RADIUS))
    depth, volume = track(path, half, flat)
    x = np.linspace(-0.3e-3, 0.3e-3, 4001)
    ways = {
        "disc_wear_depth": si(depth, "m"),
        "disc_track_width": si(2 * half, "m"),
        "disc_track_area": si(track(CIRCLE, half, flat)[1] / (2 * math.pi * 8e-3), "m^2"),
        "disc_wear_volume": si(volume, "m^3"),
        "disc_mass_loss": si(volume * DENSITY, "kg"),
        "disc_profile": {"file": "track.csv"},
    }
    for way, value in ways.items():
        profiles = {"end_values.disc_profile": Profile(x, grooved("spherical", half, pin_depth, x) + 0.01 * x)}
        manifest = described(conditions=path, pin_wear_depth=si(pin_depth, "m"), **{way: value})
        (found,) = pin_on_disc_wear(run_of(manifest, profiles if way == "disc_profile" else {}), DEFAULTS).bodies[
            "disc"
        ]
        near = 0.01 if way == "disc_profile" else 1e-9
        assert found.name == way
        assert found.depth.value == pytest.approx(depth, rel=10 * near if pin_depth else near)
        assert found.volume.value == pytest.approx(volume, rel=near)


def test_cross_section_of_a_circle_needs_no_measurement_of_the_pin():
    """V = 2πR_t·A, uncertain by A, here of four places, and R_t alone; the depth is hardly known."""
    places = {"values": [f"{area} um^2" for area in (470, 490, 480, 480)]}
    run = run_of(described(conditions={"track_radius": si(8e-3, "m", 8e-5)}, disc_track_area=places))
    worn = pin_on_disc_wear(run, DEFAULTS)
    (found,) = worn.bodies["disc"]
    assert found.volume.value == pytest.approx(2 * math.pi * 8e-3 * 480e-12, rel=1e-9)
    share = math.hypot(run.manifest.end_values.disc_track_area.standard_uncertainty / 480e-12, 0.01)
    assert found.volume.standard_uncertainty == pytest.approx(share * found.volume.value, rel=1e-3)
    assert found.depth.standard_uncertainty > 0.1 * found.depth.value
    assert not any("rough" in note for note in worn.notes)


@pytest.mark.parametrize("shape", ["truncated-sphere", "flat"])
def test_cross_section_is_that_of_the_groove_under_any_pin(shape):
    ends = {"pin_wear_depth": si(4e-6, "m"), "disc_track_area": si(900e-12, "m^2")}
    wear = pin_on_disc_wear(run_of(described(shape, conditions=CIRCLE, **ends)), DEFAULTS).bodies["disc"][0]
    contact = wear.pair.contact()
    assert contact.groove_area == pytest.approx(900e-12, rel=1e-9)
    assert wear.depth.value == pytest.approx(float(contact.groove_depth), rel=1e-9)


@pytest.mark.slow
def test_several_profiles_tell_their_mean_and_how_far_they_scatter():
    x = np.linspace(-0.3e-3, 0.3e-3, 2001)
    shares = np.array([0.9, 1.0, 1.05, 1.1, 0.95])
    profiles = {
        f"end_values.disc_profile[{number}]": Profile(x, share * grooved("spherical", 0.12e-3, 0.0, x))
        for number, share in enumerate(shares)
    }
    files = [{"file": f"{number}.csv"} for number in range(len(shares))]
    run = run_of(described(conditions=CIRCLE, disc_profile=files), profiles)
    (found,) = pin_on_disc_wear(run, DEFAULTS).bodies["disc"]
    depth, _ = track(CIRCLE, 0.12e-3, 0.0)
    assert found.depth.value == pytest.approx(depth, rel=5e-3)
    scatter = np.std(shares, ddof=1) / math.sqrt(5) * math.sqrt(4 / 2)
    assert found.depth.standard_uncertainty / depth == pytest.approx(scatter, rel=0.05)
    few = run_of(described(conditions=CIRCLE, disc_profile=files[:2]), dict(list(profiles.items())[:2]))
    assert any("2 of the 4 recommended positions" in note for note in pin_on_disc_wear(few, DEFAULTS).notes)


def test_depth_of_the_disc_is_part_of_what_the_sensor_saw():
    x = np.linspace(-0.3e-3, 0.3e-3, 2001)
    profiles = {"end_values.disc_profile": Profile(x, grooved("spherical", 0.12e-3, 4e-6, x))}
    manifest = described(pin_wear_depth=si(4e-6, "m", 1e-8), disc_profile={"file": "track.csv"})
    wear = end_wear(run_of(manifest, profiles), DEFAULTS)
    assert wear.anchor == "pin_wear_depth + disc_profile"
    assert wear.total.value == pytest.approx(4e-6 + wear.disc.quantity.value, rel=1e-12)
    flat = float(scar_radius_at(depth=4e-6, sphere_radius=RADIUS))
    assert wear.disc.quantity.value == pytest.approx(track(CIRCLE, 0.12e-3, flat)[0], rel=0.1)


def test_track_no_wider_than_the_flat_on_the_pin_tells_nothing():
    manifest = described(
        conditions=CIRCLE, pin_scar_diameter=si(0.2e-3, "m", 1e-6), disc_track_width=si(0.199e-3, "m", 1e-6)
    )
    worn = pin_on_disc_wear(run_of(manifest), DEFAULTS)
    assert worn.bodies["disc"][0].depth is None
    assert worn.bodies["disc"][0].volume is None
    assert any("disc_track_width does not exceed the scar on the pin" in note for note in worn.notes)
    assert end_wear(run_of(manifest), DEFAULTS).anchor == "pin_scar_diameter"


@pytest.mark.parametrize(
    ("shape", "end", "conditions", "note"),
    [
        ("spherical", {"disc_wear_depth": "2 um"}, {}, "track_radius or stroke is missing"),
        ("flat", {"disc_track_width": "2 mm"}, CIRCLE, "wear volume of the disc cannot be determined"),
        ("flat", {"disc_wear_depth": "2 um"}, CIRCLE, "the wear of the pin is unknown"),
        ("spherical", {"disc_wear_depth": "2 um"}, CIRCLE, "the wear of the pin is unknown"),
        ("spherical", {"disc_wear_depth": "2 um", "pin_wear_depth": "1 um"}, CIRCLE, "from disc_wear_depth, pin"),
        ("spherical", {"disc_wear_depth": "2 um", "disc_track_width": "0.2 mm"}, STROKE, "at mid-stroke"),
    ],
)
def test_what_is_lacking_and_what_is_taken_for_granted_is_said(shape, end, conditions, note):
    worn = pin_on_disc_wear(run_of(described(shape, conditions, **end)), DEFAULTS)
    assert any(note in said for said in worn.notes)


# --- several readings ---


@given(st.lists(st.floats(1e-6, 1e-3), min_size=4, max_size=12), st.floats(0, 1e-6))
def test_readings_are_their_mean_with_student_s_uncertainty(readings, common):
    mean, spread = of_readings(readings, common)
    count, scatter = len(readings), float(np.std(readings, ddof=1))
    assert mean == pytest.approx(np.mean(readings))
    expected = math.sqrt(scatter**2 / count * (count - 1) / (count - 3) + common**2)
    assert spread == pytest.approx(expected, rel=1e-6, abs=1e-18)


def end_values(written):
    return EndValues.model_validate({"pin_scar_diameter": written}).pin_scar_diameter


def test_several_readings_of_one_end_value():
    texts = ["384 um", "380 um", "388 um", "0.386 mm"]
    found = end_values({"values": texts, "standard_uncertainty": "1 um", "method": "microscope"})
    assert found.value == pytest.approx(384.5e-6, rel=1e-12)
    scatter = np.std([384, 380, 388, 386], ddof=1) / 2 * 3**0.5
    assert found.standard_uncertainty == pytest.approx(math.hypot(scatter, 1) * 1e-6)
    assert (found.method, found.readings) == ("microscope", (384e-6, 380e-6, 388e-6, 386e-6))
    kept = EndValues(pin_scar_diameter=found)
    assert EndValues.model_validate_json(kept.model_dump_json(by_alias=True)) == kept
    two = end_values({"values": ["380 um", "388 um"]})
    assert two.standard_uncertainty == pytest.approx(
        12.7062 / 1.95996 * np.std([380, 388], ddof=1) / 2**0.5 * 1e-6, rel=1e-4
    )


@pytest.mark.parametrize("count", [2, 3, 4, 5])
@pytest.mark.parametrize("common", [0.0, 1.0])
def test_intervals_of_few_readings_hold_the_truth(count, common):
    rng = np.random.default_rng(count)
    held, runs = 0, 4000
    for readings in 100 + rng.standard_normal((runs, count)) + common * rng.standard_normal((runs, 1)):
        mean, spread = of_readings(readings, common)
        held += abs(mean - 100) < 1.96 * spread
    assert held / runs > 0.94


def test_readings_that_are_all_the_same_tell_no_scatter():
    assert end_values({"values": ["384 um"] * 4}).standard_uncertainty is None
    assert end_values({"values": ["384 um"] * 4, "standard_uncertainty": "1 %"}).standard_uncertainty == pytest.approx(
        3.84e-6
    )


@pytest.mark.parametrize(
    ("written", "message"),
    [
        ({"values": ["384 um"]}, "at least 2 readings"),
        ({"values": "384 um"}, "at least 2 readings"),
        ({"values": ["384 um", 380]}, "number 380.*without a unit"),
        ({"values": ["384 um", "380 s"]}, "not a unit of length"),
        ({"values": ["384 um", "-380 um"]}, "zero or a positive value"),
        ({"values": ["384 um", "380 um"], "value": "382 um"}, "one of the two"),
        ({"values": ["384 um", "380 um"], "unit": "um"}, "one of the two"),
    ],
)
def test_readings_that_are_none_are_refused(written, message):
    with pytest.raises(ValidationError, match=message):
        end_values(written)


def test_a_load_is_stated_once():
    document = {**MANIFEST, "conditions": {"normal_load": {"values": ["1 N", "2 N"]}}}
    with pytest.raises(ValidationError, match="without 'value'"):
        RunManifest.model_validate(document)


# --- what cannot be ---


@pytest.mark.parametrize(
    ("shape", "end", "where", "message"),
    [
        ("spherical", {"pin_mass_loss": "1 mg"}, "end_values.pin_mass_loss", "without a density"),
        ("flat", {"disc_mass_loss": "1 mg"}, "end_values.disc_mass_loss", "without a density"),
        ("spherical", {"pin_wear_volume": "2 mm^3"}, "end_values.pin_wear_volume", "tip with a volume of 1.048 mm³"),
        ("truncated-sphere", {"pin_scar_diameter": "100 um"}, "end_values.pin_scar_diameter", "flat of 120 µm"),
        ("flat", {"pin_profile": {"file": "a.csv"}}, "end_values.pin_profile", "flat pin"),
        ("spherical", {"disc_track_width": "1.6 mm"}, "end_values.disc_track_width", "diameter of the pin"),
        (
            "spherical",
            {"disc_track_area": "1 mm^2"},
            "end_values.disc_track_area",
            "a cross-section of (1.00 ± 0.10)×10⁶ µm²",
        ),
        ("spherical", {"disc_wear_volume": "51 mm^3"}, "end_values.disc_wear_volume", "tip height of 794 µm"),
        (
            "spherical",
            {"pin_wear_depth": "500 um", "disc_wear_depth": "500 um"},
            "end_values.disc_wear_depth",
            "combined depth",
        ),
    ],
)
def test_what_cannot_be_is_an_error_in_one_sentence(shape, end, where, message):
    run = run_of(described(shape, CIRCLE, density=False, **end))
    found = [one for one in check_run(run) if one.severity == "error"]
    (finding,) = [one for one in found if one.code == "impossible_measurement"]
    assert finding.where == where
    assert message in finding.message
    assert "; expected " in finding.message


@pytest.mark.parametrize(
    ("shape", "end"),
    [
        ("spherical", {"disc_track_area": "0.98 mm^2"}),  # half a circle of 0.794 mm has 0.990 mm²
        ("spherical", {"disc_wear_volume": "49 mm^3"}),
        ("spherical", {"pin_wear_depth": "500 um", "disc_wear_depth": "250 um"}),
        ("flat", {"disc_wear_volume": "51 mm^3", "disc_wear_depth": "1 mm"}),
    ],
)
def test_what_a_tip_can_just_reach_is_no_error(shape, end):
    assert [one for one in check_run(run_of(described(shape, CIRCLE, **end))) if one.severity == "error"] == []


def test_mass_without_density_is_refused_without_the_checks_as_well():
    run = run_of(described(density=False, pin_mass_loss="1 mg"))
    with pytest.raises(
        FitError, match=r"found a mass loss of the pin without a density; expected contact\.pin\.density"
    ):
        end_wear(run, DEFAULTS)
    with pytest.raises(FitError, match=r"end_values\.disc_mass_loss: found a mass loss of the disc"):
        end_wear(run_of(described(density=False, disc_mass_loss="1 mg", pin_wear_depth="1 um")), DEFAULTS)


def test_profile_without_a_flat_names_its_key():
    x = np.linspace(-0.3e-3, 0.3e-3, 500)
    unworn = {"end_values.pin_profile": Profile(x, np.sqrt(RADIUS**2 - x**2))}
    run = run_of(described(pin_profile={"file": "a.csv"}), unworn)
    with pytest.raises(FitError, match=r"bare: end_values\.pin_profile: profile: found "):
        end_wear(run, DEFAULTS)
    assert [one.where for one in check_run(run) if one.code == "no_wear_in_profile"] == ["end_values.pin_profile"]
    flat = run_of(described("flat", pin_profile={"file": "a.csv"}), unworn)
    with pytest.raises(FitError, match="profile of a flat pin"):
        end_wear(flat, DEFAULTS)


@pytest.mark.parametrize("way", PIN_WAYS[1:4])
def test_end_values_that_contradict_each_other_are_named(way):
    agreeing, wrong = (measured(way, "spherical", depth, 0.01).manifest.end_values for depth in (5e-6, 8e-6))
    beside = {"pin_wear_depth": si(5e-6, "m", 1e-7)}

    def found(end):
        given = {**end.model_dump(mode="json", exclude_none=True, exclude_defaults=True), **beside}
        return [one for one in check_run(run_of(described(**given))) if one.code == "measurements_disagree"]

    assert found(agreeing) == []
    (finding,) = found(wrong)
    assert f"from {way}" in finding.message


@pytest.mark.parametrize("shape", ["spherical", "flat"])
def test_gain_of_a_pin_that_shows_wear_is_named(shape):
    worn = {"pin_wear_depth": si(5e-6, "m", 1e-7)}
    volume = pin_on_disc_wear(run_of(described(shape, **worn)), DEFAULTS).bodies["pin"][0].volume.value

    def found(loss, spread):
        mass = si(loss * volume * DENSITY, "kg", spread * volume * DENSITY)
        run = run_of(described(shape, **worn, pin_mass_loss=mass))
        return [one for one in check_run(run) if one.code == "measurements_disagree"]

    assert found(-1.0, 1.0) == []
    (finding,) = found(-1.0, 0.1)
    assert "wear volume of the pin" in finding.message
    assert "from pin_mass_loss" in finding.message


def test_contradiction_names_what_depth_and_volume_follow_from():
    # A scar next to an unmeasured groove gives the depth most certainly, and a wear volume the volume.
    end = {"pin_scar_length": si(0.4e-3, "m", 5e-7), "pin_wear_volume": si(4e-12, "m^3", 8e-14)}
    run = run_of(described(**end))
    rate = specific_wear(run).pin
    assert (rate.depth_by, rate.volume_by) == ("pin_scar_length", "pin_wear_volume")
    (finding,) = (one for one in check_run(run) if one.code == "measurements_disagree")
    assert "pin_scar_length is used for the depth and pin_wear_volume for the volume" in finding.message


def test_volume_and_mass_of_the_disc_are_compared():
    end = {"disc_wear_volume": si(1e-12, "m^3", 1e-14), "disc_mass_loss": si(2e-12 * DENSITY, "kg", 1e-11)}
    findings = [one for one in check_run(run_of(described(**end))) if one.code == "measurements_disagree"]
    assert len(findings) == 1
    assert "volume of the disc" in findings[0].message


def test_examples_of_the_manual_can_be_written():
    text = (ROOT / "docs" / "end_values.md").read_text(encoding="utf-8")
    blocks = re.findall(r"(?s)```toml\n(.*?)```", text)
    assert len(blocks) == 5
    for block in blocks:
        document = tomllib.loads(block)
        for stop in document.get("interruptions", ()):
            assert Interruption.model_validate(stop).pin_mass_loss is not None
        stated = EndValues.model_validate(document.get("end_values", {}))
        assert (stated != EndValues()) == ("interruptions" not in document)
        Conditions.model_validate({"normal_load": "1 N", **document.get("conditions", {})})


def test_manual_states_the_errors_of_the_short_formulas():
    text = (ROOT / "docs" / "end_values.md").read_text(encoding="utf-8")
    shares = np.array([0.05, 0.1, 0.2, 0.3, 0.5, 0.8, 1.0])
    depth = cap_height(scar_radius=shares, sphere_radius=1.0)
    for row, error in (
        ("cap", np.pi * (2 * shares) ** 4 / 64 / worn_volume(depth=depth, sphere_radius=1.0) - 1),
        ("track", (2 * shares) ** 3 / 12 / segment_area(half_chord=shares, radius=1.0) - 1),
    ):
        (line,) = re.findall(rf"(?m)^\| {row}, π.*$", text)
        stated = [float(found.replace("−", "-")) for found in re.findall(r"(−[\d.]+) %", line)]
        np.testing.assert_allclose(stated, 100 * error, rtol=0.02)


# --- the whole line ---


@pytest.mark.slow
def test_every_way_of_measuring_leads_to_the_same_coefficient():
    from tribopipe.physics.pin_on_disc import SphericalPin

    distance, k, rng = np.linspace(0, 500, 1001), 13.5e-15, np.random.default_rng(4)
    modulus = 304e9 / (2 * (1 - 0.24**2))
    depth = SphericalPin(normal_load=0.2, radius=RADIUS, modulus=modulus).worn(k * 0.2 * distance).depth
    reading = 2e-6 + depth + 3e-9 * distance + 30e-9 * rng.standard_normal(len(distance))
    giwm, unworn = WearRecipe(engine="giwm"), DefaultUncertainty(unseen_groove=0.0)
    recipe = Recipe(wear=giwm, uncertainty=unworn, monte_carlo=MonteCarloRecipe(significant_digits=0))
    for way in PIN_WAYS:
        run = measured(way, "spherical", float(depth[-1]), 0.01)
        columns = {**run.columns, "depth": reading}
        run = replace(run, columns=columns, origins=dict.fromkeys(columns, "measured"))
        fit = fit_wear(correct_drift(run, recipe), "archard", None, recipe)
        found = fit.first.wear_coefficient
        assert abs(found.value - k) <= 2 * found.standard_uncertainty
        assert found.standard_uncertainty < 0.05 * k
        assert any(line.name == "pin end value" for line in fit.first.budget)
        assert way in ("pin_wear_volume", "pin_mass_loss") or "mm³" not in str(fit.first.budget[0].shown_in)

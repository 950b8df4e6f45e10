"""Specific wear rates: volume over load and distance of each body, archived, shown, and the same by every end value."""

import json
import math
import re
from dataclasses import replace

import h5py
import numpy as np
import pytest
from end_value_runs import CIRCLE, RADIUS, described, run_of, si, track

from tribopipe.archive.step_names import STEPS
from tribopipe.archive.store import Archive
from tribopipe.documents.recipe import MonteCarloRecipe, Recipe
from tribopipe.documents.record import Record
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.measurements.specific_wear import specific_wear
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.evaluation.wear.inputs import default_notes, instrument_inputs
from tribopipe.physics.pin_on_track import SphereOnTrack
from tribopipe.pipeline.stages import advance, ingest
from tribopipe.readers.harmonize import read_run
from tribopipe.results.run import RawRun
from tribopipe.results.specific_wear import SpecificWear

VOLUME = 2e-12
BOTH = {"pin_wear_volume": si(VOLUME, "m^3", 0.03 * VOLUME), "disc_wear_volume": si(3 * VOLUME, "m^3", 0.04 * VOLUME)}


def run_with(conditions=None, **end) -> RawRun:
    return run_of(described(conditions={"normal_load": si(0.2, "N", 0.002), **(conditions or {})}, **end))


def with_columns(run, **columns):
    there = {**run.columns, **columns}
    return replace(run, columns=there, origins={**dict.fromkeys(there, "measured"), **run.origins})


def test_rate_is_volume_over_load_and_distance():
    found = specific_wear(run_with(CIRCLE, **BOTH))
    assert (found.outcome, found.load, found.notes) == ("evaluated", "nominal", ())
    assert found.pin.specific_wear_rate.value == pytest.approx(VOLUME / (0.2 * 500))
    share = math.hypot(0.03, 0.01)
    assert found.pin.specific_wear_rate.standard_uncertainty == pytest.approx(share * VOLUME / 100, rel=1e-3)
    assert found.total.value == pytest.approx(4 * VOLUME / 100)
    # Load and distance are common to both bodies, so that their shares do not shrink in the sum.
    together = math.hypot(math.hypot(0.03, 0.04) / 4, 0.01)
    assert found.total.standard_uncertainty / found.total.value == pytest.approx(together, rel=1e-3)
    assert "2.000 ± 0.063)×10⁻⁵ mm³/(N·m)" in str(found)


@pytest.mark.parametrize(("grown", "other"), [("pin", "disc"), ("disc", "pin")])
def test_body_that_has_gained_material_keeps_its_sign_and_has_no_depth(grown, other):
    found = specific_wear(run_with(**BOTH | {f"{grown}_wear_volume": si(-VOLUME, "m^3")}))
    rate = found.bodies[grown]
    assert rate.specific_wear_rate.value == pytest.approx(-VOLUME / (0.2 * 500))
    assert rate.specific_wear_rate.standard_uncertainty > 0
    assert rate.depth is None
    assert found.bodies[other].specific_wear_rate.value > 0


def test_recorded_load_is_taken_as_its_mean_over_the_distance():
    run = run_with(**BOTH)
    force = np.where(run.sliding_distance < 250, 0.1, 0.4)
    force[10:20] = np.nan
    found = specific_wear(with_columns(run, normal_force=force))
    assert found.load == "measured"
    assert found.normal_load.value == pytest.approx(0.25, rel=2e-3)
    assert found.normal_load.standard_uncertainty == pytest.approx(0.01 * found.normal_load.value)
    assert found.pin.specific_wear_rate.value == pytest.approx(VOLUME / (0.25 * 500), rel=2e-3)


@pytest.mark.parametrize("force", [np.nan, 0.0, -0.2])
def test_load_that_says_nothing_is_not_taken(force):
    found = specific_wear(with_columns(run_with(**BOTH), normal_force=np.full(1001, force)))
    assert (found.load, found.normal_load.value) == ("nominal", 0.2)


def test_distance_is_as_uncertain_as_the_speed_it_was_derived_from():
    run = run_with({"sliding_speed": si(0.4, "m/s", 0.008)}, **BOTH)
    measured = specific_wear(run)
    derived = specific_wear(replace(run, origins={**run.origins, "sliding_distance": "derived from nominal speed"}))
    assert measured.sliding_distance.standard_uncertainty is None
    assert derived.sliding_distance.standard_uncertainty == pytest.approx(0.02 * 500)


@pytest.mark.parametrize(
    ("origin", "stated", "share"),
    [
        ("derived from nominal speed", {}, math.hypot(0.005, 0.01)),
        ("derived from nominal speed", {"track_radius": si(8e-3, "m", 1.6e-4)}, math.hypot(0.005, 0.02)),
        ("derived from nominal speed", {"rotational_speed": si(50, "rad/s", 0.05)}, math.hypot(0.001, 0.01)),
        ("derived from rotations", {}, 0.01),
        ("derived from rotations", {"track_radius": si(8e-3, "m", 1.6e-4)}, 0.02),
    ],
)
def test_distance_around_a_track_is_as_uncertain_as_its_radius(origin, stated, share):
    turning = {"sliding_speed": None, "rotational_speed": "500 rpm", "track_radius": "8 mm", **stated}
    run = run_with(turning, **BOTH)
    found = specific_wear(replace(run, origins={**run.origins, "sliding_distance": origin})).sliding_distance
    assert (found.value, found.standard_uncertainty) == (pytest.approx(500), pytest.approx(share * 500))


CIRCLING = {"rotational_speed": si(50, "rad/s", 0.05), "track_radius": si(8e-3, "m", 8e-6)}
STROKING = {"frequency": si(20, "1/s", 0.02), "stroke": si(10e-3, "m", 1e-5)}


@pytest.mark.parametrize(
    ("motion", "unstated", "share", "note"),
    [
        (CIRCLING, {}, math.hypot(1e-3, 1e-3), None),
        (CIRCLING, {"track_radius": "8 mm"}, math.hypot(1e-3, 0.01), "radius of the wear track 8.000 ± 0.080 mm"),
        (CIRCLING, {"rotational_speed": "500 rpm"}, math.hypot(5e-3, 1e-3), "rotational speed 500.0 ± 2.5 rpm"),
        (STROKING, {"stroke": "10 mm"}, math.hypot(1e-3, 0.01), "stroke 10.00 ± 0.10 mm"),
        (STROKING, {"frequency": "20 Hz"}, math.hypot(5e-3, 1e-3), "frequency 20.00 ± 0.10 Hz"),
    ],
)
def test_speed_is_as_uncertain_as_both_factors_and_its_defaults_are_named(motion, unstated, share, note):
    run = run_with({"sliding_speed": None, **motion, **unstated})
    derived = replace(run, origins={**run.origins, "sliding_distance": "derived from nominal speed"})
    speed = instrument_inputs(derived, Recipe())["sliding_speed"]
    assert speed.quantity.value == pytest.approx(0.4, rel=0.05)
    assert speed.spread == pytest.approx(share * speed.quantity.value)
    assert speed.source == ("default" if note else "manifest")
    assert default_notes({"sliding_speed": speed}) == ((f"default uncertainty used for {note}",) if note else ())


@pytest.mark.parametrize(
    ("end", "conditions", "note"),
    [
        ({}, {}, "no wear measurement of the pin"),
        ({"pin_wear_depth": "5 um", "disc_wear_depth": "1 um"}, {}, "track_radius or stroke is missing"),
        ({"pin_wear_depth": "5 um"}, {}, "no wear measurement of the disc"),
    ],
)
def test_what_is_lacking_is_said(end, conditions, note):
    found = specific_wear(run_with(conditions, **end))
    assert note in found.notes or any(note in said for said in found.notes)
    assert found.total is None
    assert found.outcome == ("evaluated" if end else "not evaluated")
    assert note in str(found)


def test_run_without_bodies_passes_through():
    manifest = run_with().manifest.model_copy(update={"contact": None})
    found = specific_wear(replace(run_with(), manifest=manifest))
    assert str(found) == "no specific wear rate; the bodies are not described in run.toml"
    still = run_with(**BOTH)
    still.columns["sliding_distance"][:] = 0
    assert "no sliding distance" in specific_wear(still).notes


def test_disc_takes_what_measures_it_before_what_follows_from_the_pin():
    depth, volume = track(CIRCLE, 0.12e-3, 0.0)
    end = {
        "pin_wear_depth": si(0.0, "m"),
        "disc_wear_depth": si(depth, "m", 1e-9),
        "disc_wear_volume": si(1.1 * volume, "m^3", 0.2 * volume),
    }
    found = specific_wear(run_with(CIRCLE, **end)).disc
    assert (found.volume_by, found.depth_by) == ("disc_wear_volume", "disc_wear_depth")
    assert [one.by for one in found.measured] == ["disc_wear_depth", "disc_wear_volume"]
    assert found.measured[0].volume.value == pytest.approx(volume, rel=1e-9)


def test_twin_discs_have_their_rates_too(disc_pair):
    (run_id, *_) = disc_pair.ids()
    found = disc_pair.needed_result(run_id, "specific_wear", SpecificWear)
    volume = disc_pair.manifest(run_id).end_values.curved_disc_wear_volume.value
    slid = float(np.nanmax(disc_pair.raw(run_id).sliding_distance))
    assert set(found.bodies) == {"curved_disc", "flat_disc"}
    rate = found.curved_disc.specific_wear_rate.value
    assert rate == pytest.approx(volume / (found.normal_load.value * slid), rel=1e-9)
    assert found.total.value == pytest.approx(rate + found.flat_disc.specific_wear_rate.value)


def test_slip_distance_is_as_uncertain_as_slip_and_rolling_radius(disc_pair):
    (run_id, *_) = disc_pair.ids()
    run = disc_pair.raw(run_id)
    found = specific_wear(run)
    slip, radius = run.manifest.slip, run.manifest.described.curved_disc.rolling_radius
    share = math.hypot(*(one.standard_uncertainty / one.value for one in (slip, radius)))
    assert share > 0.005
    assert found.sliding_distance.standard_uncertainty == pytest.approx(share * found.sliding_distance.value)
    volume, rate, load = found.curved_disc.volume, found.curved_disc.specific_wear_rate, found.normal_load
    together = math.hypot(share, *(one.standard_uncertainty / one.value for one in (volume, load)))
    assert rate.standard_uncertainty == pytest.approx(together * rate.value, rel=1e-2)


@pytest.mark.slow
def test_result_is_archived_and_done_once(sample_run, tmp_path, run_cli):
    store = Archive(tmp_path / "archive")
    run_id = ingest(sample_run, store).run_id
    first, second = (advance(store, run_id, "specific_wear", Recipe()) for _ in range(2))
    assert (first.status, second.status) == ("done", "unchanged")
    kept = store.result(run_id, "specific_wear", Record)
    assert kept == first.result == STEPS["specific_wear"].parse(first.result.model_dump_json())
    with h5py.File(store.path(run_id)) as file:
        fields = file["entry/specific_wear/parameters"]
        assert fields["pin_specific_wear_rate"][()] == kept.pin.specific_wear_rate.value
        assert fields["pin_specific_wear_rate"].attrs["units"] == "m^2/N"
        assert fields["pin_volume_errors"][()] == kept.pin.volume.standard_uncertainty
    shown = run_cli("show", run_id, "-v", "--archive", store.folder)
    assert "mm³/(N·m)" in shown.output
    assert "from the scar diameter" in shown.output
    document = json.loads(run_cli("show", run_id, "--archive", store.folder, "--json").stdout)
    assert document["specific_wear"]["pin"]["volume_by"] == "pin_scar_diameter"


def test_table_of_process_has_the_rates(archive, run_cli):
    from tribopipe.cli.summary import show_summaries

    document = json.loads(run_cli("show", "si3n4-air-200mN", "--archive", archive, "--json").stdout)
    assert document["specific_wear"]["outcome"] == "evaluated"
    assert document["specific_wear"]["disc"]["volume"] is None
    show_summaries(Archive(archive), ["si3n4-air-200mN"])


def test_rate_of_a_simulated_run_is_its_true_coefficient(short_runs):
    run = read_run(short_runs / "si3n4-air-400mN")
    truth = json.loads((short_runs / "si3n4-air-400mN" / "truth.json").read_text(encoding="ascii"))
    found = specific_wear(run).pin.specific_wear_rate
    assert abs(found.value - truth["wear_coefficient"]["value"]) < 3 * found.standard_uncertainty


@pytest.mark.slow
def test_simulated_run_tells_the_same_coefficient_by_every_end_value(sample_run):
    truth = json.loads((sample_run / "truth.json").read_text(encoding="ascii"))
    depth, k = truth["end_pin_wear_depth"]["value"], truth["wear_coefficient"]["value"]
    disc_depth = read_run(sample_run).manifest.end_values.disc_wear_depth.value
    state = SphereOnTrack(RADIUS).at_depths(depth, disc_depth)
    volume, scar = float(state.pin_volume), float(state.half_length + state.half_width)
    ways = {
        "pin_wear_depth": f"{depth * 1e6} um",
        "pin_scar_diameter": f"{scar * 1e6} um",
        "pin_wear_volume": f"{volume * 1e9} mm^3",
        "pin_mass_loss": f"{volume * 3200 * 1e6} mg",
    }
    recipe = Recipe(monte_carlo=MonteCarloRecipe(significant_digits=0))
    text = (sample_run / "run.toml").read_text(encoding="utf-8")
    found = {}
    for way, value in ways.items():
        stated = f'{way} = {{ value = "{value}", standard_uncertainty = "1 %" }}'
        changed = re.sub(r"(?m)^pin_scar_diameter = .*$", stated, text)
        changed = re.sub(r"(?m)^density = .*$", 'density = "3.2 g/cm^3"', changed)
        (sample_run / "run.toml").write_text(changed, encoding="utf-8")
        run = read_run(sample_run)
        found[way] = fit_wear(correct_drift(run, recipe), "archard", None, recipe).first.wear_coefficient
        assert abs(found[way].value - k) < 2 * found[way].standard_uncertainty
        rate = specific_wear(run, recipe).pin.specific_wear_rate
        assert abs(rate.value - k) < 2 * rate.standard_uncertainty
    assert np.ptp([one.value for one in found.values()]) < 0.01 * k

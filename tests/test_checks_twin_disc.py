"""Checks of twin-disc runs: what each finds, and what it leaves alone."""

import copy
import math
from dataclasses import replace

import numpy as np
import pytest
from test_profile import CROWN, TWIN, X, flattened, grooved, segment

from tribopipe.contacts.twin_disc import nominal_pair
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.recipe import Recipe
from tribopipe.evaluation.checks.registry import check_run
from tribopipe.physics.hertz import hertz_ellipse
from tribopipe.results.run import ExtraColumn, Profile, RawRun

TURNS = np.linspace(0, 10_000, 501)
AROUND = 2 * math.pi * 10e-3
DEPTH = 0.6e-6
"""h₁ + h₂ at the end, two thirds of it on the crowned disc."""


def sure(text):
    return {"value": text, "standard_uncertainty": "1 %"}


def _ends() -> dict:
    """End values that all say DEPTH, by the geometry of the worn flat."""
    manifest = RunManifest.model_validate(TWIN)
    pair = nominal_pair(manifest, Recipe().wear.distance_per_rotation)
    width = np.linspace(20e-6, 500e-6, 4001)
    width = float(np.interp(DEPTH, pair.depth_of_width(width), width))
    area = np.geomspace(1e-13, 1e-9, 4001)
    area = float(np.interp(DEPTH, pair.depth_of_area(area), area))
    both = {}
    for disc, share in (("curved_disc", 2 / 3), ("flat_disc", 1 / 3)):
        both[f"{disc}_wear_depth"] = sure(f"{share * DEPTH * 1e6:.6g} um")
        both[f"{disc}_track_width"] = sure(f"{width * 1e6:.6g} um")
        both[f"{disc}_wear_volume"] = sure(f"{share * area * AROUND * 1e9:.6g} mm^3")
    return both


ENDS = _ends()
SOUND = copy.deepcopy(TWIN) | {
    "conditions": {
        "normal_load": sure("250 mN"),
        "curved_disc_speed": "800 mm/s",
        "slip": sure("4 %"),
        "rotations": 10_000,
    },
    "end_values": ENDS,
}
for _disc in ("curved_disc", "flat_disc"):
    for _name, _value in (("youngs_modulus", "304 GPa"), ("rolling_radius", "10 mm")):
        SOUND["contact"][_disc][_name] = sure(_value)
SOUND["contact"]["curved_disc"]["crown_radius"] = sure("10 mm")

COLUMNS = {
    "time": TURNS * AROUND / 0.8,
    "rotations": TURNS,
    "sliding_distance": TURNS * AROUND * 0.04,
    "normal_force": 0.25 + 1e-4 * np.sin(TURNS),
    "depth": 1e-6 + DEPTH * np.sqrt(TURNS / 10_000),
}


def twin(changes=None, columns=None, profiles=None, derived=()) -> RawRun:
    """A sound run, but for some keys of run.toml ("conditions.slip"; None takes one out) and some columns."""
    document = copy.deepcopy(SOUND)
    for path, value in (changes or {}).items():
        *tables, last = path.split(".")
        table = document
        for name in tables:
            table = table[name]
        table.pop(last, None)
        if value is not None:
            table[last] = value
    signals = COLUMNS | (columns or {})
    origins = dict.fromkeys(signals, "measured") | {"sliding_distance": "derived from nominal slip"}
    origins |= dict.fromkeys(derived, "derived from nominal speed")
    manifest = RunManifest.model_validate(document)
    return RawRun(manifest, signals, origins, {}, {}, (), profiles=profiles or {})


def changed(name, where, value):
    values = COLUMNS[name].copy()
    values[where] = value
    return {name: values}


def found(run, check):
    return [finding for finding in check_run(run) if finding.code == check]


def test_sound_run_has_no_findings():
    assert check_run(twin()) == []


@pytest.mark.parametrize(("share", "flagged"), [(1.2, []), (0.6, ["end_values.curved_disc_track_width"])])
def test_a_track_narrower_than_the_elastic_contact_is_named(share, flagged):
    contact = RunManifest.model_validate(SOUND).described
    across, along = contact.unworn_radii
    ellipse = hertz_ellipse(normal_load=0.25, radius_x=across, radius_z=along, modulus=float(contact.reduced_modulus()))
    run = twin({"end_values.curved_disc_track_width": sure(f"{2e6 * share * ellipse.half_width:.4g} um")})
    assert [finding.where for finding in found(run, "scar_or_radius")] == flagged


@pytest.mark.parametrize(("width", "count"), [("100 um", 2), ("3 mm", 0)])
def test_wear_that_makes_the_contact_wider_than_a_disc_is_named(width, count):
    """By the depths, and by the volumes."""
    ends = {name: value for name, value in ENDS.items() if not name.endswith("track_width")}
    run = twin({"contact.flat_disc.width": width, "end_values": ends})
    assert len([one for one in found(run, "implausible_wear") if one.where == "end_values"]) == count


END = "end_values"
NO_ENDS = {END: {}}
ONLY_CURVED = {END: {"curved_disc_wear_depth": ENDS["curved_disc_wear_depth"]}}
STOP = {"rotations": 12_000, "curved_disc_wear_depth": "0.1 um"}

# Check, run, where, and some of what is said.
TROUBLE = {
    "g/cm³": (
        "implausible_density",
        {"contact.flat_disc.density": "3.2 kg/m^3"},
        {},
        "contact.flat_disc.density",
    ),
    "kPa": (
        "implausible_modulus",
        {"contact.curved_disc.youngs_modulus": "304 kPa"},
        {},
        "contact.curved_disc.youngs_modulus",
    ),
    "crown in m": (
        "implausible_conditions",
        {"contact.curved_disc.crown_radius": "10.5 m"},
        {},
        "contact.curved_disc.crown_radius",
    ),
    "rolling radius in m": (
        "implausible_conditions",
        {"contact.flat_disc.rolling_radius": "10 m"},
        {},
        "contact.flat_disc.rolling_radius",
    ),
    "speed": (
        "implausible_conditions",
        {"conditions.curved_disc_speed": "800 m/s"},
        {},
        "conditions.curved_disc_speed",
    ),
    "slip of 4": ("implausible_conditions", {"conditions.slip": 4}, {}, "conditions.slip"),
    "slip of 20": ("implausible_conditions", {"conditions.slip": 20}, {}, "conditions.slip"),
    "little slip": ("implausible_conditions", {"conditions.slip": "-0.05 %"}, {}, "conditions.slip"),
    "hardly any slip": ("implausible_conditions", {"conditions.slip": 1e-6}, {}, "conditions.slip"),
    "slip by speeds": (
        "implausible_conditions",
        {"conditions.slip": None, "conditions.flat_disc_speed": "800.1 mm/s"},
        {},
        "conditions.flat_disc_speed",
    ),
    "no end value": ("missing_input", NO_ENDS, {}, "end_values"),
    "cylindrical disc not measured": ("missing_input", ONLY_CURVED, {}, "end_values"),
    "late interruption": (
        "interruption_after_end",
        {"interruptions": [STOP]},
        {},
        "interruptions[0].rotations",
    ),
    "depth in nm": ("implausible_depth", {}, {"depth": COLUMNS["depth"] * 1e3}, "depth"),
    "broken off": ("distance_not_planned", {"conditions.rotations": 20_000}, {}, "rotations"),
    "speed by the clock": ("distance_not_planned", {}, {"time": COLUMNS["time"] * 2}, "curved_disc_speed"),
    "hole in the count": ("axis_incomplete", {}, changed("rotations", 7, np.nan), "rotations"),
    "count goes back once": ("counter_glitch", {}, changed("rotations", 7, 5.0), "rotations"),
    "count goes back": ("axis_backward", {}, changed("rotations", slice(7, 12), 5.0), "rotations"),
    "count below zero": ("axis_backward", {}, {"rotations": TURNS - 5.0}, "rotations"),
    "count stands still": ("axis_constant", {}, {"rotations": np.full(501, 3.0)}, "rotations"),
    "count carried over": ("signals_preprocessed", {}, {"rotations": TURNS + 5_000}, "rotations"),
    "load pulls": ("load_sign", {}, {"normal_force": -COLUMNS["normal_force"]}, "normal_force"),
}


@pytest.mark.parametrize("case", TROUBLE)
def test_check_finds(case):
    check, changes, columns, where = TROUBLE[case]
    findings = found(twin(changes, columns), check)
    assert [finding.where for finding in findings] == [where]
    assert "found" in findings[0].message
    assert "expected" in findings[0].message


ALONE = {
    "sizes": (
        "implausible_conditions",
        {"conditions.slip": "100 %", "contact.curved_disc.crown_radius": "1 m"},
        {},
    ),
    "least slip": ("implausible_conditions", {"conditions.slip": "0.1 %"}, {}),
    "an interruption": (
        "interruption_after_end",
        {"interruptions": [STOP | {"rotations": 9_999}]},
        {},
    ),
    "planned": ("distance_not_planned", {"conditions.rotations": 10_400}, {}),
    "wear during interruptions": (
        "missing_input",
        NO_ENDS | {"interruptions": [STOP | {"rotations": 99, "flat_disc_wear_depth": "0.1 um"}]},
        {},
    ),
    "drift": ("implausible_depth", {}, {"depth": COLUMNS["depth"] + 4e-6 * TURNS / 10_000}),
}


@pytest.mark.parametrize("case", ALONE)
def test_check_leaves_alone(case):
    check, changes, columns = ALONE[case]
    assert found(twin(changes, columns), check) == []


def test_derived_count_is_held_against_no_speed():
    assert found(twin(columns={"time": COLUMNS["time"] * 2}, derived=["rotations"]), "distance_not_planned") == []


@pytest.mark.parametrize(
    ("check", "changes", "columns", "words"),
    [
        ("load_sign", {}, {"normal_force": -COLUMNS["normal_force"]}, "a negative load means no contact"),
        ("axis_backward", {}, {"rotations": TURNS - 5.0}, "not a count"),
        ("axis_backward", {}, changed("rotations", slice(7, 12), 5.0), "not a count"),
        ("missing_input", ONLY_CURVED, {}, "one-sided model"),
        ("interruption_after_end", {"interruptions": [STOP]}, {}, "12,000 rotations in a run of 10,000"),
        ("implausible_depth", {}, {"depth": COLUMNS["depth"] * 1e5}, "crown radius"),
    ],
)
def test_check_says(check, changes, columns, words):
    assert words in found(twin(changes, columns), check)[0].message


@pytest.mark.parametrize(
    ("wrong", "factor"), [(name, 3.0) for name in ENDS] + [(name, 0.3) for name in ENDS if "flat_disc_wear" not in name]
)
def test_end_value_that_contradicts_the_others_is_found(wrong, factor):
    number, unit = ENDS[wrong]["value"].split()
    run = twin({f"end_values.{wrong}": sure(f"{float(number) * factor:.6g} {unit}")})
    findings = found(run, "measurements_disagree")
    assert {finding.where for finding in findings} == {"end_values"}
    assert any(wrong in finding.message for finding in findings)


@pytest.mark.parametrize("wrong", list(ENDS))
def test_small_differences_between_end_values_are_left_alone(wrong):
    number, unit = ENDS[wrong]["value"].split()
    run = twin({f"end_values.{wrong}": sure(f"{float(number) * 1.05:.6g} {unit}")})
    assert found(run, "measurements_disagree") == []


def test_uncertain_end_values_may_differ():
    width = ENDS["curved_disc_track_width"]["value"]
    vague = {"value": f"{float(width.split()[0]) * 1.3} um", "standard_uncertainty": "20 %"}
    changes = {"end_values.flat_disc_track_width": None, "end_values.curved_disc_track_width": vague}
    assert found(twin(changes), "measurements_disagree") == []


def test_volume_of_one_disc_alone_is_not_held_against_both():
    assert found(twin({"end_values.flat_disc_wear_volume": None}), "measurements_disagree") == []


@pytest.mark.parametrize("missing", [None, "conditions.slip"])
def test_inputs_without_an_uncertainty_are_named(missing):
    changes = {"contact.curved_disc.crown_radius": "10 mm", "end_values.flat_disc_wear_depth": "0.2 um"}
    if missing:
        changes |= {missing: None, "conditions.flat_disc_speed": "832 mm/s"}
    (finding,) = found(twin(changes), "unstated_uncertainty")
    speeds = ["conditions.curved_disc_speed", "conditions.flat_disc_speed"] if missing else []
    expected = ["contact.curved_disc.crown_radius", *speeds, "end_values.flat_disc_wear_depth"]
    assert finding.where.split(", ") == expected


SOURCE = {"file": "p.csv", "position": "x", "height": "z"}


def profiled(profile, **end):
    return twin(
        {END: {"curved_disc_profile": SOURCE, "flat_disc_wear_depth": "0 um", **end}},
        profiles={"end_values.curved_disc_profile": profile},
    )


def test_profile_counts_as_a_volume():
    cap = CROWN - math.sqrt(CROWN**2 - 1e-8)
    profile = Profile(X, flattened(X))
    assert segment(CROWN, 1e-4) > 0
    agreeing = {"curved_disc_track_width": sure("200 um"), "curved_disc_wear_depth": sure(f"{cap * 1e6} um")}
    assert found(profiled(profile, **agreeing, flat_disc_wear_volume=sure("0 mm^3")), "measurements_disagree") == []
    wrong = {"curved_disc_track_width": sure("100 um")}
    findings = found(profiled(profile, **wrong, flat_disc_wear_volume=sure("0 mm^3")), "measurements_disagree")
    assert any("curved_disc_wear_volume" in finding.message for finding in findings)


def test_profile_without_a_track_is_noted():
    run = profiled(Profile(X, flattened(X, half=1e-9)))
    (finding,) = found(run, "no_wear_in_profile")
    assert finding.where == "end_values.curved_disc_profile"
    assert "wear track" in finding.message
    assert found(run, "measurements_disagree") == []


def test_profile_of_the_flat_disc_needs_no_crown():
    run = twin(
        {"interruptions": [{"rotations": 100, "flat_disc_profile": SOURCE}]},
        profiles={"interruptions[0].flat_disc_profile": Profile(X, grooved(X, tilt=0.02))},
    )
    assert found(run, "missing_input") == []


RPM = 0.8 / AROUND * 60
"""Rotational speed of the crowned disc."""
LATE = np.arange(len(TURNS)) > 0.7 * len(TURNS)
"""Samples of the last 30 % of the test."""


@pytest.mark.parametrize(
    ("columns", "warns"),
    [
        ({"n1 [rpm]": ("rpm", RPM), "n2 [rpm]": ("rpm", 1.04 * RPM)}, False),
        ({"n1 [rpm]": ("rpm", RPM), "n2 [rpm]": ("rpm", 1.10 * RPM)}, True),
        ({"n1 [rpm]": ("rpm", RPM), "n2 [rpm]": ("rpm", RPM * np.where(LATE, 1.2, 1.04))}, True),
        ({"Slip [%]": ("%", np.where(LATE, 20, 4))}, True),
        ({"Slip [%]": ("%", np.where(np.arange(len(TURNS)) % 200, 4, 900))}, False),
        ({"Upper disc": ("m/s", 0.832), "Lower disc": ("m/s", 0.8)}, False),
        ({"Upper disc": ("m/s", 0.9), "Lower disc": ("m/s", 0.8)}, True),
        ({"Speed 1": ("m/s", 0.0), "Speed 2": ("m/s", 0.0)}, False),
        ({"Rolling speed": ("m/s", 0.8), "Sliding speed": ("m/s", 0.032)}, False),
        ({"Speed": ("rpm", RPM), "Set speed": ("rpm", RPM)}, False),
        ({"Speed": ("m/s", 0.8), "Speed 2": ("m/s", 0.7)}, False),
    ],
)
def test_slip_of_two_recorded_speeds_is_compared_with_the_stated_one(columns, warns):
    noise = 1e-3 * np.random.default_rng(1).standard_normal(len(TURNS))
    extras = {name: ExtraColumn(value * (1 + noise), unit) for name, (unit, value) in columns.items()}
    found = [one for one in check_run(replace(twin(), extras=extras)) if one.code == "conditions_differ"]
    assert [one.where for one in found] == (["conditions.slip"] if warns else [])


@pytest.mark.parametrize(("r_2", "warns"), [("10 mm", True), ("20 mm", False)])
def test_radii_make_slip_of_two_rotational_speeds(r_2, warns):
    extras = {f"Motor {disc} speed": ExtraColumn(np.full(len(TURNS), n), "rpm") for disc, n in ((1, 1.0), (2, 0.52))}
    run = replace(twin({"contact.flat_disc.rolling_radius": sure(r_2)}), extras=extras)
    found = [one for one in check_run(run) if one.code == "conditions_differ"]
    assert [one.where for one in found] == (["conditions.slip"] if warns else [])

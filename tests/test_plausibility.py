"""Inputs that are physically implausible: each is named by an error or a finding."""

from dataclasses import replace

import numpy as np
import pytest
from end_value_runs import run_of

from tribopipe.documents.manifest import RunManifest
from tribopipe.evaluation.checks.material_ranges import _TYPICAL, CLASSES, expected_of, typical_of
from tribopipe.evaluation.checks.registry import check_run

BENCH = {
    "schema": "tribopipe.run/1",
    "id": "ball",
    "contact": {
        "kind": "pin-on-disc",
        "pin": {
            "shape": "spherical",
            "material": "100Cr6",
            "radius": "3 mm",
            "youngs_modulus": "210 GPa",
            "poisson_ratio": 0.3,
        },
        "disc": {"material": "steel", "youngs_modulus": "210 GPa", "poisson_ratio": 0.3},
    },
    "conditions": {"normal_load": "5 N", "sliding_speed": "0.4 m/s"},
    "signals": [{"file": "signals.csv"}],
    "end_values": {"pin_scar_diameter": {"value": "600 um", "standard_uncertainty": "5 um"}},
}


def bench(changes=None, load=None):
    """A sound run of a steel ball on steel, but for keys of run.toml such as "contact.pin.radius"."""
    document = RunManifest.model_validate(BENCH).model_dump(mode="json", by_alias=True, exclude_none=True)
    for path, value in (changes or {}).items():
        *tables, last = path.split(".")
        table = document
        for name in tables:
            table = table[name]
        table[last] = value
    run = run_of(RunManifest.model_validate(document))
    if load is None:
        return run
    columns = {**run.columns, "normal_force": load * (1 + 1e-3 * np.cos(np.arange(len(run))))}
    return replace(run, columns=columns, origins={**run.origins, "normal_force": "measured"})


def flags(run):
    return [(one.severity, one.code, one.where) for one in check_run(run) if one.severity != "note"]


@pytest.mark.parametrize("load", [None, 5.0])
def test_sound_bench_has_no_flags(load):
    assert flags(bench(load=load)) == []


@pytest.mark.parametrize(
    ("changes", "load", "severity", "where"),
    [
        ({"conditions.normal_load": "5 kN"}, 5.0, "error", "conditions.normal_load"),
        ({"conditions.normal_load": "5 kN"}, None, "warning", "conditions.normal_load"),
        ({"conditions.normal_load": "5 N"}, 5000.0, "error", "conditions.normal_load"),
        ({"conditions.normal_load": "5 N"}, 5.25, "warning", "normal_force"),
        ({"contact.disc.youngs_modulus": "210 MPa"}, None, "error", "contact.disc.youngs_modulus"),
        ({"contact.pin.youngs_modulus": "21 GPa"}, None, "warning", "contact.pin.youngs_modulus"),
        ({"contact.pin.density": "0.785 g/cm^3"}, None, "warning", "contact.pin.density"),
        ({"contact.disc.vickers_hardness": 8.0}, None, "warning", "contact.disc.vickers_hardness"),
        ({"contact.pin.radius": "6 mm"}, None, "warning", "contact.pin.radius"),
        ({"contact.pin.radius": "6 mm", "contact.pin.diameter": "6 mm"}, None, "warning", "contact.pin.radius"),
        ({"end_values.pin_scar_diameter": "60 um"}, None, "warning", "end_values.pin_scar_diameter"),
        (
            {"end_values.pin_scar_diameter": "300 um", "end_values.disc_track_width": "600 um"},
            None,
            "warning",
            "end_values.pin_scar_diameter, end_values.disc_track_width",
        ),
    ],
)
def test_implausible_input_is_named(changes, load, severity, where):
    assert (severity, where) in [(one, there) for one, _, there in flags(bench(changes, load))]


def test_radius_that_only_a_diameter_could_tell_from_a_diameter_is_noted():
    """4 mm and 8 mm are both usual balls: the note says which one is meant."""
    notes = [one for one in check_run(bench({"contact.pin.radius": "4 mm"})) if one.where == "contact.pin.radius"]
    assert [(one.severity, one.code) for one in notes] == [("note", "radius_unchecked")]
    assert "8.000 mm" in notes[0].message or "8 mm" in notes[0].message


@pytest.mark.parametrize(
    ("material", "title", "modulus", "density"),
    [
        ("Si₃N₄", "silicon nitride", 310, 3.2),
        ("Al2O3 99.7 %", "alumina", 380, 3.9),
        ("3Y-TZP", "zirconia", 205, 6.05),
        ("SSiC", "silicon carbide", 410, 3.1),
        ("WC-6Co", "cemented carbide", 620, 14.9),
        ("AISI 52100", "steel", 210, 7.81),
        ("X5CrNi18-10", "steel", 200, 7.9),
        ("CuSn8", "copper alloy", 115, 8.8),
        ("EN AW-6082", "aluminum alloy", 70, 2.7),
        ("Ti6Al4V", "titanium alloy", 114, 4.43),
        ("PTFE", "PTFE", 0.5, 2.2),
        ("PEEK CF30", "PEEK", 24, 1.4),
        ("PA66", "polyamide", 3.0, 1.14),
        ("UHMWPE", "polyethylene", 0.7, 0.94),
        ("PPS + 40 % GF", "PPS", 15, 1.65),
        ("NBR 70", "rubber", 0.006, 1.2),
    ],
)
def test_materials_are_known_by_name_and_hold_their_handbook_values(material, title, modulus, density):
    known = expected_of(material)
    assert known.title == title
    assert known.modulus[0] <= modulus <= known.modulus[1]
    assert known.density[0] <= density <= known.density[1]


def test_composite_may_have_the_numbers_of_any_part():
    known = expected_of("PPS + 20 % PTFE")
    assert known.title == "PTFE or PPS"
    assert known.modulus == (0.2, 30)


@pytest.mark.parametrize("material", ["our own", "coating 7", "titanium nitride", "specimen A"])
def test_name_that_says_nothing_is_compared_with_nothing(material):
    assert expected_of(material) is None
    assert not [one for one in flags(bench({"contact.pin.material": material})) if one[2].startswith("contact.pin")]


@pytest.mark.parametrize(
    ("material", "title"),
    [("100Cr6", "steel"), ("Si₃N₄", "silicon nitride"), ("PTFE", "PTFE"), ("EN AW-6082", "aluminum alloy")],
)
def test_typical_values_lie_in_the_ranges_of_their_class(material, title):
    known, (found, typical) = expected_of(material), typical_of(material)
    assert found == known.title == title
    assert known.modulus[0] < typical.modulus < known.modulus[1]
    assert known.density[0] < typical.density < known.density[1]
    assert 0.1 <= typical.poisson_ratio < 0.5


@pytest.mark.parametrize(
    "material", ["PEEK CF30", "PPS + 40 % GF", "PTFE 25GF", "steel, DLC coated", "NBR 70", "our own"]
)
def test_nothing_is_typical_of_filled_coated_and_unknown_materials(material):
    assert typical_of(material) is None


def test_each_class_with_typical_values_is_one():
    assert _TYPICAL.keys() <= {one.title for one in CLASSES}
    for one in CLASSES:
        if typical := _TYPICAL.get(one.title):
            assert one.modulus[0] < typical.modulus < one.modulus[1]
            assert one.density[0] < typical.density < one.density[1]


def test_ranges_are_ranges():
    for one in CLASSES:
        for low, high in (one.modulus, one.density, one.hardness or (1, 2)):
            assert 0 < low < high


@pytest.mark.parametrize(("depth", "found"), [("2 mm", []), ("4 mm", ["end_values of the pin"])])
def test_flat_pin_worn_by_more_than_its_radius_is_named(depth, found):
    flat = {"contact.pin.shape": "flat", "end_values": {"pin_wear_depth": depth}}
    assert [where for _, code, where in flags(bench(flat)) if code == "implausible_wear"] == found


@pytest.mark.parametrize(("hardness", "found"), [(None, []), (1100.0, ["end_values of the disc"])])
def test_wear_beyond_abrasion_is_named_by_the_hardness(hardness, found):
    """A steel disc that loses 1 cm³ in 500 m under 5 N: k·H is 0.3 at HV 80, the softest steel, and 4 at HV 1100."""
    worn = {"end_values.disc_wear_volume": {"value": "900 mm^3", "standard_uncertainty": "1 mm^3"}}
    hard = {} if hardness is None else {"contact.disc.vickers_hardness": hardness}
    assert [where for _, code, where in flags(bench(worn | hard)) if code == "implausible_wear"] == found


@pytest.mark.parametrize(
    ("name", "value", "spread", "flagged"),
    [
        ("pin_wear_depth", "0 nm", "1 nm", False),
        ("pin_wear_volume", "1e-14 mm^3", "1e-14 mm^3", False),
        ("pin_wear_volume", "1e-14 mm^3", "1e-16 mm^3", True),
    ],
)
def test_a_body_that_is_stated_unworn_has_no_implausible_wear(name, value, spread, flagged):
    end = {name: {"value": value, "standard_uncertainty": spread}}
    messages = [one.message for one in check_run(bench({"end_values": end}))]
    assert any("found a dimensionless wear coefficient" in message for message in messages) == flagged

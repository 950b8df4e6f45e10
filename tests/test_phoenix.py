"""Files of Phoenix Tribology's Compend, whose header holds no units."""

from dataclasses import replace

import numpy as np
import pytest
from instrument_shapes import Polymer, phoenix
from read_tables import column

from tribopipe.base.errors import FitError, ReaderError
from tribopipe.documents.manifest import EndValues
from tribopipe.documents.quantity import EndValue
from tribopipe.documents.recipe import Recipe
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.preprocessing.cleaning import clean_run
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.readers.draft.folder import Wanted, make_run
from tribopipe.readers.formats.phoenix import PhoenixReader
from tribopipe.readers.harmonize import read_run
from tribopipe.readers.reader import Hints, Reader, ReadTable, detect
from tribopipe.results.run import SourceFile

TRUTH = Polymer(rows=300)


def read(content: bytes) -> ReadTable:
    return PhoenixReader().read(SourceFile("TEST_2.TSV", content), Hints())


def test_the_file_is_known_and_read():
    assert isinstance(PhoenixReader(), Reader)
    assert detect(SourceFile("TEST_2.TSV", phoenix(TRUTH))).name == "phoenix-compend"
    table = read(phoenix(TRUTH))
    assert {one.name: (one.unit, one.signal) for one in table.columns} == {
        "Time": ("s", "time"),
        "This Step": (None, None),
        "Step Time": ("s", None),
        "Test Time": ("s", None),
        "Sliding Velocity": ("m/s", "sliding_speed"),
        "Speed": ("rpm", None),
        "Mass": ("g", None),
        "Load": ("N", "normal_force"),
        "TOTAL REVOLUTIONS": ("1", None),
        "Specimen Temp": ("degC", "temperature"),
        "Contact Potential": ("mV", None),
        "Radius": ("mm", None),
        "Distance": ("m", "sliding_distance"),
        "Friction Force": ("N", "friction_force"),
        "Friction Coefficient": ("1", "friction_coefficient"),
        "Displacement": ("um", "depth"),
        "Friction Force (2)": ("N", None),
    }
    assert np.all(column(table, "Step Time").values == 3600)
    assert np.median(column(table, "Load").values) == pytest.approx(59.841, abs=0.01)
    assert table.facts == {"instrument": "Phoenix Tribology (Compend)", "started": "2019-04-09T20:09:56"}
    assert table.notes == (
        "column 18 is renamed 'Friction Force (2)', since another column is already called 'Friction Force'",
        "Displacement is assumed to be in µm, the unit used by the program; other columns cannot confirm this",
    )


def test_the_run_has_the_truth_s_distance_friction_and_wear(tmp_path):
    path = tmp_path / "TEST_2.TSV"
    path.write_bytes(phoenix(TRUTH))
    made = make_run(Wanted([path], tmp_path, settings=["conditions.normal_load=60 N"]))
    assert made.problem is None
    run = read_run(made.folder)
    assert run.sliding_distance[-1] == pytest.approx(TRUTH.distance, rel=1e-5)
    assert np.mean(run.columns["friction_coefficient"]) == pytest.approx(TRUTH.friction, abs=1e-3)
    assert run.columns["depth"][0] - run.columns["depth"][-1] == pytest.approx(TRUTH.wear * 1e-6, rel=0.01)


SETTINGS = [
    "conditions.normal_load=60 N",
    "contact.kind=pin-on-disc",
    "contact.pin.shape=flat",
    "contact.pin.radius=4 mm",
    "contact.pin.material=PPS",
    "contact.pin.youngs_modulus=3.6 GPa",
    "contact.pin.poisson_ratio=0.38",
    "contact.disc.material=steel",
    "contact.disc.youngs_modulus=210 GPa",
    "contact.disc.poisson_ratio=0.3",
]
AREA = np.pi * 4e-3**2


def wear_fit(folder, content: bytes, end: EndValue | None, *, turned: bool = True):
    path = folder / "TEST_2.TSV"
    path.write_bytes(content)
    made = make_run(Wanted([path], folder, settings=SETTINGS))
    assert made.problem is None
    run = read_run(made.folder)
    run = replace(run, manifest=run.manifest.model_copy(update={"end_values": EndValues(pin_wear_depth=end)}))
    # The displacement of this rig falls with wear.
    recipe = Recipe.model_validate({"clean_up": [{"step": "invert", "signals": ["depth"]}] if turned else []})
    return fit_wear(correct_drift(clean_run(run, recipe).run, recipe), "archard", None, recipe)


@pytest.mark.slow
def test_k_d_of_a_flat_pin_is_area_times_wear_over_load_and_distance(tmp_path):
    truth = Polymer()
    end = EndValue(value=404e-6, unit="m", standard_uncertainty=4e-6)
    fit = wear_fit(tmp_path, phoenix(truth), end)
    expected = AREA * truth.wear * 1e-6 / (59.841 * truth.distance)
    assert fit.first.wear_coefficient.value == pytest.approx(expected, rel=0.03)
    # Drift is a line of any rate, and so is the wear of a flat pin: the measurement alone tells, and load and radius.
    # A groove of 15 % of the depth, which nobody looked for, would have taken 2 % more from the pin.
    ideal = np.hypot(4 / 404, np.hypot(np.hypot(0.01, 2 * 0.002), 0.0207))
    assert fit.first.wear_coefficient.standard_uncertainty / expected < 1.5 * ideal
    assert [finding.code for finding in fit.findings if finding.severity != "note"] == ["disc_not_measured"]


@pytest.mark.slow
def test_k_d_of_a_flat_pin_by_the_sensor_alone_is_labeled(tmp_path):
    truth = Polymer()
    fit = wear_fit(tmp_path, phoenix(truth), None)
    expected = AREA * truth.wear * 1e-6 / (59.841 * truth.distance)
    assert fit.first.wear_coefficient.value == pytest.approx(expected, rel=0.03)
    # Of 0.3 µm of noise the line through 1800 samples leaves next to nothing; the prior of the drift, load, radius and
    # scale of the sensor are left; and a groove of 15 % of the depth of the pin, which the sensor reads as well.
    ideal = np.hypot(0.25 / 404, np.hypot(np.hypot(0.01, 2 * 0.002), np.hypot(0.005, 1 - 1.0207 / 1.15)))
    assert fit.first.wear_coefficient.standard_uncertainty / expected < 1.5 * ideal
    assert fit.basis == "reading"
    assert "no_post_test_measurement" in {finding.code for finding in fit.findings}


@pytest.mark.slow
def test_a_reading_that_falls_is_refused_where_nothing_else_gives_k_d(tmp_path):
    with pytest.raises(FitError) as caught:
        wear_fit(tmp_path, phoenix(Polymer()), None, turned=False)
    said = str(caught.value)
    assert said.startswith(
        "TEST_2: depth: found a depth signal that, fitted alone, gives a wear depth of -403.96 ± 0.25 µm; "
    )
    assert 'if the signal decreases with wear, add the step "invert" with signals = ["depth"]' in said


def test_of_two_friction_forces_that_of_the_coefficient_is_taken():
    lines = phoenix(TRUTH).decode().split("\r\n")
    swapped = []
    for line in lines:
        cells = line.split("\t")
        if len(cells) == 18:
            cells[14], cells[17] = cells[17], cells[14]
        swapped.append("\t".join(cells))
    table = read("\r\n".join(swapped).encode())
    assert next(one.name for one in table.columns if one.signal == "friction_force") == "Friction Force (2)"


def test_units_that_an_identity_contradicts_are_left_open():
    lines = phoenix(TRUTH).replace(b"\t6100\t", b"\t6,1\t")
    table = read(lines)
    assert next(one.unit for one in table.columns if one.name == "Mass") is None
    assert next(one.unit for one in table.columns if one.name == "Load") == "N"
    assert "m·g = F_N does not hold in g, N: the ratio of the left side to the right side is 0.001" in table.notes
    assert "the units of 'Mass' are unknown; the header contains none" in table.notes


def test_names_that_only_look_like_the_program_s_have_no_unit():
    table = read(phoenix(TRUTH).replace(b"\tTime\t", b"\tT\x10ime\t", 1))
    assert (column(table, "T\x10ime").unit, column(table, "T\x10ime").signal) == (None, None)
    assert column(table, "Friction Force").signal == "friction_force"


def test_a_speed_without_a_sliding_velocity_is_that_of_rotation():
    table = read(phoenix(TRUTH).replace(b"\tSliding Velocity\t", b"\tMotor Current\t", 1))
    assert (column(table, "Speed").unit, column(table, "Speed").signal) == ("rpm", None)
    assert column(table, "Friction Force").signal == "friction_force"


@pytest.mark.parametrize("unit", ["kg", "s"])
def test_a_friction_force_in_a_unit_of_no_force_is_not_held_against_the_load(unit):
    names = f"Friction Force [{unit}]\tFriction Coefficient"
    table = read(phoenix(TRUTH).replace(b"Friction Force\tFriction Coefficient", names.encode(), 1))
    assert column(table, "Friction Force").signal == "friction_force"
    assert column(table, f"Friction Force [{unit}]").signal is None


@pytest.mark.parametrize(("name", "number"), [("Load", 9), ("Displacement", 17), ("Contact Potential", 12)])
def test_an_unknown_unit_is_left_open_and_reported_with_line_and_column(name, number):
    names = phoenix(TRUTH).replace(b"\t%s\t" % name.encode(), b"\t%s [kgff]\t" % name.encode(), 1)
    table = read(names)
    line = next(place for place, one in enumerate(names.splitlines(), start=1) if b"This Step" in one)
    assert column(table, f"{name} [kgff]").unit is None
    said = f"line {line}, column {number}: '{name} [kgff]' has the unknown unit 'kgff'; specify its unit in run.toml"
    assert said in table.notes


def test_empty_brackets_are_no_unit():
    table = read(phoenix(TRUTH).replace(b"\tLoad\t", b"\tLoad []\t", 1))
    assert column(table, "Load []").unit == "N"
    assert not any("unknown unit" in note for note in table.notes)


def test_a_run_of_an_unknown_unit_says_so(tmp_path):
    path = tmp_path / "TEST_2.TSV"
    path.write_bytes(phoenix(TRUTH).replace(b"\tDisplacement\t", b"\tDisplacement [mikron]\t", 1))
    made = make_run(Wanted([path], tmp_path, settings=["conditions.normal_load=60 N"]))
    assert any("'Displacement [mikron]' has the unknown unit 'mikron'" in note for note in made.notes)
    assert not any("is assumed to be in µm" in note for note in made.notes)
    run = read_run(made.folder)
    assert "depth" not in run.columns
    assert any("'Displacement [mikron]' seems to be depth and is not used" in one for one in run.unused)


def test_a_counter_one_back_is_kept_as_it_is():
    turns = column(read(phoenix(TRUTH, glitch=True)), "TOTAL REVOLUTIONS").values
    assert turns[57:60].tolist() == [186, 185, 188]


def test_a_field_that_is_no_number_is_missing_and_named():
    table = read(phoenix(TRUTH).replace(b"\t6100\t", b"\tOVL\t", 1))
    mass = next(one for one in table.columns if one.name == "Mass")
    assert (mass.placeholders.line, mass.placeholders.text) == (13, "OVL")


@pytest.mark.parametrize("content", [b"Time\tThis Step\n1\t2\n", b"\tTime\tLoad\n\t1\t2\n"])
def test_other_files_are_left_alone(content):
    assert PhoenixReader().match(SourceFile("x", content)).confidence == 0
    with pytest.raises(ReaderError, match="found no header row with This Step"):
        read(content)

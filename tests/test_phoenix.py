"""Files of Phoenix Tribology's Compend, whose header holds no units."""

import numpy as np
import pytest
from instrument_shapes import Polymer, phoenix
from read_tables import column

from tribopipe.errors import ReaderError
from tribopipe.ingest.draft.folder import Wanted, make_run
from tribopipe.ingest.formats.phoenix import PhoenixReader
from tribopipe.ingest.harmonise import read_run
from tribopipe.ingest.reader import Hints, Reader, ReadTable
from tribopipe.ingest.registry import detect
from tribopipe.run import SourceFile

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
        "column 18 is called 'Friction Force (2)', since another is 'Friction Force' already",
        "Displacement is taken in µm, as the program writes it; no identity bears that out",
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
    assert "m·g = F_N does not hold in g, N: left over right is 0.001" in table.notes
    assert "the units of 'Mass' are left open; the header holds none" in table.notes


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
    with pytest.raises(ReaderError, match="found no row of names with This Step"):
        read(content)

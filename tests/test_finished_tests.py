"""`tribopipe new --each-row`: tables of finished tests, of which nothing was recorded."""

import json
import math
import re
import tomllib
from pathlib import Path

import pytest
from built_files import xlsx

from tribopipe.readers.harmonize import read_run

HEAD = (
    "specimen;normal load [N];sliding speed [m/s];sliding distance [m];ball diameter [mm];scar diameter [um];"
    "u(scar diameter) [um];Disc Mass Loss [mg];mean friction;lab book"
)
ROWS = ("A1;5;0,1;500;6;412;3;1,2;0,62;page 12", "A 2;10;0,1;500;6;530;3;;0,60;")
BODIES = """schema = "tribopipe.template/1"
[contact]
kind = "pin-on-disc"
[contact.pin]
material = "100Cr6"
youngs_modulus = "210 GPa"
poisson_ratio = 0.3
[contact.disc]
material = "Al10Cu"
youngs_modulus = "72 GPa"
poisson_ratio = 0.33
density = "2.8 g/cm^3"
[signals]
separator = "\\t"
decimal = ","
reader = "ducom-winducom"
"""


@pytest.fixture
def lab(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab.toml").write_text(BODIES, encoding="utf-8")
    return tmp_path


def table(lab: Path, *rows: str, head: str = HEAD) -> None:
    (lab / "tests.csv").write_text("\n".join([head, *rows, ""]), encoding="utf-8")


def run_toml(name: str) -> dict:
    return tomllib.loads((Path(name) / "run.toml").read_text(encoding="utf-8"))


@pytest.mark.slow
def test_each_row_is_a_run_with_its_wear_rate(run_cli, lab):
    table(lab, *ROWS)
    made = run_cli("new", "tests.csv", "--each-row", "--template", "lab.toml", "--json")
    assert made.exit_code == 0, made.stderr
    runs = json.loads(made.stdout)["runs"]
    assert [(run["id"], run["still_to_be_filled_in"], run["problem"]) for run in runs] == [
        ("A1", [], None),
        ("A-2", [], None),
    ]
    first, second = run_toml("A1"), run_toml("A-2")
    assert first["contact"]["pin"]["shape"] == "spherical"
    assert first["contact"]["pin"]["radius"] == "3 mm"
    assert first["end_values"] == {
        "pin_scar_diameter": {"value": "412 um", "standard_uncertainty": "3 um"},
        "disc_mass_loss": "1.2 mg",
    }
    assert first["comment"] == "mean friction: 0,62; lab book: page 12"
    assert second["comment"] == "mean friction: 0,60"
    assert (lab / "A1" / "signals.csv").read_text() == "time [s],sliding distance [m]\n0,0\n5000,500\n"
    assert "column 'lab book' is not a key of run.toml and is kept in the comment of each run" in made.stderr
    done = run_cli("process", "A1", "--no-figures", "--json")
    assert done.exit_code == 0, done.stderr
    height = 3.0 - math.sqrt(3.0**2 - 0.206**2)
    rates = json.loads(run_cli("show", "A1", "--json").stdout)["specific_wear"]
    volume = math.pi * height**2 * (9.0 - height) / 3
    assert rates["pin"]["specific_wear_rate"]["value"] == pytest.approx(volume * 1e-9 / (5 * 500), rel=1e-3)
    assert rates["disc"]["specific_wear_rate"]["value"] == pytest.approx(1.2e-6 / 2800 / (5 * 500), rel=1e-3)


def test_a_scar_wider_than_the_ball_is_named(run_cli, lab):
    table(lab, "A1;5;0.1;500;6;7000")
    made = run_cli("new", "tests.csv", "--each-row")
    assert (
        "the radius of the pin is not calculated from its diameter of 6 mm: end_values.pin_scar_diameter" in made.stderr
    )
    assert "contact.pin.radius" in made.stderr.rpartition("still to be filled in")[2]


def test_a_workbook_tells_the_same(run_cli, lab):
    head, row = (line.split(";") for line in (HEAD, ROWS[0].replace(",", ".")))
    (lab / "tests.xlsx").write_bytes(xlsx({"2026": [head, [float(c) if c[0].isdigit() else c for c in row]]}))
    assert run_cli("new", "tests.xlsx", "--each-row", "--template", "lab.toml").exit_code == 0
    assert run_toml("A1")["end_values"]["disc_mass_loss"] == "1.2 mg"


def test_numbers_of_specimens_in_a_workbook_are_whole(run_cli, lab):
    head, row = (line.split(";") for line in (HEAD, ROWS[0].replace(",", ".")))
    row[0] = "17"
    (lab / "tests.xlsx").write_bytes(xlsx({"2026": [head, [float(c) if c[0].isdigit() else c for c in row]]}))
    assert run_cli("new", "tests.xlsx", "--each-row", "--template", "lab.toml").exit_code == 0
    assert run_toml("17")["end_values"]["disc_mass_loss"] == "1.2 mg"


def test_what_is_missing_is_named(run_cli, lab):
    table(lab, "A1;;0.1;500;6;;;;0.6;")
    made = run_cli("new", "tests.csv", "--each-row", "--json")
    (run,) = json.loads(made.stdout)["runs"]
    assert run["still_to_be_filled_in"] == [
        *("conditions.normal_load", "contact.pin.material", "contact.pin.youngs_modulus", "contact.pin.poisson_ratio"),
        *("contact.disc.material", "contact.disc.youngs_modulus", "contact.disc.poisson_ratio"),
    ]
    assert run["problem"].startswith("found no post-test measurement; expected at least one")


@pytest.mark.parametrize(
    ("rows", "head", "told"),
    [
        ((ROWS[0], ROWS[0]), HEAD, "line 3: found the run 'A1' twice, first in line 2"),
        (("A 2;5;1;9;6;400", "A-2;5;1;9;6;400"), HEAD, "A-2: found two runs with that ID"),
        (("A1;5;0.1;500;400",), "run;normal load [N];sliding speed [m/s];sliding distance [m];scar diameter", "unit"),
        (
            ("A1;5;0.1;500;4",),
            "run;normal load [N];sliding speed [m/s];sliding distance [m];wear volume [mm^3]",
            "may refer",
        ),
        (
            ("A1;5;;500;6;400",),
            HEAD,
            "line 2: found no sliding_speed .*; expected the distance and the speed of each test",
        ),
        (("A1;5;1;;6;400",), HEAD, "line 2: found no sliding_distance"),
        (("A1;5;1;9;6;400;3;1;;;7",), HEAD, "line 2: found '7' in a column without a name"),
        (
            ("A1;5;0.1;500;6;4;400",),
            "run;normal load [N];sliding speed [m/s];sliding distance [m];ball diameter [mm];ball radius [mm];"
            "scar diameter [um]",
            "line 2: found a ball 6 mm in diameter with a radius of 4 mm",
        ),
        (
            ("A1;5;0.1;500;100;5;400",),
            "run;normal load [N];sliding speed [m/s];sliding distance [m];rotational_speed [rpm];track_radius [mm];"
            "scar diameter [um]",
            "line 2: found a sliding_speed of 100 mm/s, but 52.36 mm/s from rotational_speed and track_radius",
        ),
    ],
)
def test_a_row_that_cannot_be_is_refused_and_nothing_is_made(run_cli, lab, rows, head, told):
    table(lab, *rows, head=head)
    refused = run_cli("new", "tests.csv", "--each-row")
    assert refused.exit_code == 1
    assert re.search(told, refused.stderr), refused.stderr
    assert sorted(path.name for path in lab.iterdir()) == ["lab.toml", "tests.csv"]


AREAS = "Probe;Normalkraft [N];Gleitgeschwindigkeit [m/s];Gleitweg [m];disc_track_area [um^2];Legierung"


@pytest.mark.parametrize("option", [("tests.csv", "--each-row"), ("log.csv", "--ends", "tests.csv")])
@pytest.mark.parametrize(
    ("first", "second", "told"),
    [
        ("5;0,1;500;510;a", "5;0,1;500;1.020;b", "line 3, column 'disc_track_area [um^2]': found '1.020'"),
        ("5;0,1;500;510;a", "5;0,1;1.000;510;b", "line 3, column 'Gleitweg [m]': found '1.000'"),
        ("5;1;500;1.020 um^2;a", "5;1;500;0,5 um^2;b", "line 2, column 'disc_track_area [um^2]': found '1.020 um^2'"),
        ("5;1;500;1.020;1,5 h", "5;1;500;510;b", "line 2, column 'disc_track_area [um^2]': found '1.020'"),
    ],
)
def test_a_point_among_decimal_commas_may_stand_between_thousands(run_cli, lab, option, first, second, told):
    table(lab, f"log;{first}", f"P2;{second}", head=AREAS)
    (lab / "log.csv").write_text("Time [s];Friction force [N]\n0;2\n1;2\n2;3\n", encoding="utf-8")
    refused = run_cli("new", *option)
    assert refused.exit_code == 1
    assert told in refused.stderr
    assert "the point may be a decimal or a thousands separator" in refused.stderr


@pytest.mark.parametrize(("written", "number"), [("10000", 1e4), ("1e6", 1e6), ("1_000_000", 1e6)])
def test_rotations_of_a_pin_give_its_sliding_distance(run_cli, lab, written, number):
    head = "run;normal load [N];rotations;track_radius [mm];scar diameter [um];sliding speed [m/s]"
    table(lab, f"P1;5;{written};8;412;0.1", head=head)
    made = run_cli("new", "tests.csv", "--each-row", "--template", "lab.toml")
    assert made.exit_code == 0, made.stderr
    conditions = run_toml("P1")["conditions"]
    assert "rotations" not in conditions
    value, unit = conditions["sliding_distance"].split()
    assert (float(value), unit) == (pytest.approx(number * 2 * math.pi * 8e-3, rel=1e-5), "m")


@pytest.mark.parametrize(
    ("head", "row", "told"),
    [
        ("rotations;scar diameter [um]", "1e6;412", "line 2: found rotations without a track radius"),
        (
            "rotations;track_radius [mm];sliding distance [m]",
            "1e4;8;600",
            "line 2: found a sliding_distance of 600 m, but 502.655 m from rotations",
        ),
        ("rotations;track_radius [mm]", "many;8", "line 2: conditions.rotations: found 'many'"),
    ],
)
def test_rotations_that_give_no_distance_are_refused(run_cli, lab, head, row, told):
    table(lab, f"P1;5;0.1;{row}", head=f"run;normal load [N];sliding speed [m/s];{head}")
    refused = run_cli("new", "tests.csv", "--each-row")
    assert refused.exit_code == 1
    assert told in refused.stderr


DISC = 'rolling_radius = "20 mm"\nmaterial = "100Cr6"\nyoungs_modulus = "210 GPa"\npoisson_ratio = 0.3\n'
ROLLING = (
    'schema = "tribopipe.template/1"\n[contact]\nkind = "twin-disc"\n'
    f'[contact.curved_disc]\ncrown_radius = "50 mm"\n{DISC}density = "7.81 g/cm^3"\n[contact.flat_disc]\n{DISC}'
    '[conditions]\ncurved_disc_speed = "1 m/s"\nslip = "5 %"\n'
)


@pytest.mark.parametrize("written", ["100000", "1e5", "100_000"])
def test_a_row_of_two_discs_is_as_long_as_its_rotations(run_cli, lab, written):
    (lab / "discs.toml").write_text(ROLLING, encoding="utf-8")
    table(lab, f"D1;200;{written};9.8", head="run;normal load [N];rotations;curved_disc_mass_loss [mg]")
    made = run_cli("new", "tests.csv", "--each-row", "--template", "discs.toml")
    assert made.exit_code == 0, made.stderr
    assert run_toml("D1")["conditions"]["rotations"] == 1e5
    run = read_run(Path("D1"))
    assert run.columns["rotations"].tolist() == [0, 1e5]
    assert run.columns["time"][-1] == pytest.approx(1e5 * 2 * math.pi * 20e-3 / 1.0)


def test_a_row_of_two_discs_without_rotations_is_refused(run_cli, lab):
    (lab / "discs.toml").write_text(ROLLING, encoding="utf-8")
    table(lab, "D1;200;9.8", head="run;normal load [N];curved_disc_mass_loss [mg]")
    refused = run_cli("new", "tests.csv", "--each-row", "--template", "discs.toml")
    assert "line 2: found no conditions.rotations; expected the rotations, the speed and the radius" in refused.stderr


def test_a_count_for_another_contact_is_called_that(run_cli, lab):
    (lab / "log.csv").write_text("Time [s];Friction force [N]\n0;2\n1;2\n2;3\n", encoding="utf-8")
    refused = run_cli("new", "log.csv", "--set", "contact.kind=pin-on-disc", "--set", "conditions.rotations=1e6")
    assert "conditions.rotations: found a key that does not apply to pin-on-disc runs" in refused.stderr


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("5;1;1.000;412;a", "10;1;2.000;512;b"),
        ("5;1;1.000;412;1.4301", "10;1;500;512;1.3505"),
    ],
)
def test_a_point_without_any_other_decimal_sign_may_stand_between_thousands(run_cli, lab, first, second):
    table(lab, f"P1;{first}", f"P2;{second}", head=AREAS.replace("Legierung", "contact.disc.material"))
    refused = run_cli("new", "tests.csv", "--each-row")
    assert refused.exit_code == 1
    assert "line 2, column 'Gleitweg [m]': found '1.000', where the point may be a decimal or" in refused.stderr
    assert "write 1000, or append a zero as a further decimal" in refused.stderr


@pytest.mark.parametrize(
    ("row", "separator"),
    [
        ("5;1;1.000;512.5;a", ";"),
        ("5;1;1.000;510 ± 0.5;a", ";"),
        ("5;1;1.0000;512;a", ";"),
        ("5;1;1.000e3;512;a", ";"),
        ("5;1;1.000;512;a", ","),
        ("5;1;1.000;512;a", "\t"),
    ],
)
def test_a_point_is_decimal_where_it_is_shown_to_be_or_commas_separate_columns(run_cli, lab, row, separator):
    table(lab, f"P1;{row}".replace(";", separator), head=AREAS.replace(";", separator))
    made = run_cli("new", "tests.csv", "--each-row")
    assert "thousands" not in made.stderr
    if "±" not in row:
        assert made.exit_code == 0
        assert run_toml("P1")["conditions"]["sliding_distance"] == row.split(";")[2] + " m"


def test_points_are_decimal_where_no_number_has_a_decimal_comma(run_cli, lab):
    table(lab, "P1;5;0.1;500;1.020;1,3-diketone", "P2;5;0.1;500;510.5;b", head=AREAS)
    assert run_cli("new", "tests.csv", "--each-row").exit_code == 0
    assert run_toml("P1")["end_values"]["disc_track_area"] == "1.020 um^2"


def test_a_table_of_tests_is_not_taken_for_a_recording(run_cli, lab):
    table(lab, *(row.replace(",", ".") for row in ROWS))
    refused = run_cli("new", "tests.csv")
    assert refused.exit_code == 1
    assert "found a table of finished tests, one per row" in refused.stderr
    assert not (lab / "tests").exists()
    (lab / "log.csv").write_text("Test;Time [s];Friction force [N]\n1;0;2\n1;1;2\n1;2;3\n", encoding="utf-8")
    assert run_cli("new", "log.csv").exit_code == 0


@pytest.mark.parametrize("option", [("--ends", "tests.csv"), ("--id", "x"), ("--sheet", "x"), ("--split", "Step")])
def test_options_for_recordings_are_refused(run_cli, lab, option):
    table(lab, *ROWS)
    refused = run_cli("new", "tests.csv", "--each-row", *option)
    assert refused.exit_code == 1
    assert f"--each-row: found {option[0]} in addition" in refused.stderr
    assert "found 2 files" in run_cli("new", "tests.csv", "lab.toml", "--each-row").stderr


def test_four_balls_have_their_speed_from_their_diameter(run_cli, lab):
    (lab / "lab.toml").write_text(
        """schema = "tribopipe.template/1"
[contact]
kind = "four-ball"
[contact.ball]
diameter = "12.7 mm"
material = "100Cr6"
youngs_modulus = "210 GPa"
poisson_ratio = 0.3
[conditions]
rotational_speed = "1200 rpm"
sliding_distance = "1 km"
""",
        encoding="utf-8",
    )
    table(lab, "FB1;392;0,62", head="specimen;normal load [N];scar diameter [mm]")
    made = run_cli("new", "tests.csv", "--each-row", "--template", "lab.toml")
    assert made.exit_code == 0, made.stderr
    seconds = 1000 / (2 * math.pi * 20 * 6.35e-3 / math.sqrt(3))
    last = (lab / "FB1" / "signals.csv").read_text().splitlines()[-1].split(",")
    assert [float(number) for number in last] == pytest.approx([seconds, 1000])

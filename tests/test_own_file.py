"""Own file first: exports in the shapes of ten instruments, header lines, names of files, and what contradicts them."""

import json
import re
import shlex
import tomllib
from pathlib import Path

import numpy as np
import pytest
from folders import ROOT
from hypothesis import given, settings
from hypothesis import strategies as st
from instrument_shapes import SRV_COLUMNS, srv
from own_exports import CASES, written
from sweeps import others_slow

from tribopipe.base.errors import UnitError
from tribopipe.base.units import has_decimal_comma, is_unit, is_unit_of, parse, with_point
from tribopipe.readers.column_meanings import meanings_of
from tribopipe.readers.draft.folder import Wanted, make_run
from tribopipe.readers.draft.known_values import Known
from tribopipe.readers.draft.value_sources import doubt_names
from tribopipe.readers.export_files import read_export
from tribopipe.readers.formats.workbook import with_srv_meanings
from tribopipe.readers.harmonize import read_run
from tribopipe.readers.header_facts import header_facts
from tribopipe.readers.reader import ReadColumn, ReadTable

LOAD = "conditions.normal_load"


@pytest.fixture
def lab(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def table(head: str = "", *, load: float = 5.0, rows: int = 40, extra: str = "", value: str = "") -> str:
    body = "".join(f"{n / 10:.1f};{2.0 + n % 3 / 10:.1f};{load + n % 2 / 100:.2f}{value}\n" for n in range(rows))
    return f"{head}Time [s];Friction force [N];Normal force [N]{extra}\n{body}"


def drafted(path: Path, **wanted):
    made = make_run(Wanted([path], **wanted))
    text = (made.folder / "run.toml").read_text(encoding="utf-8")
    return made, text, tomllib.loads(text)


# --- ten instruments ---


@pytest.mark.slow
@pytest.mark.parametrize("make", others_slow(CASES, first=3), ids=lambda make: make.__name__)
def test_new_leaves_nothing_to_be_typed(run_cli, lab, monkeypatch, make):
    case = make()
    monkeypatch.chdir(written(case, lab / "user"))
    made = run_cli(*shlex.split(case.commands[0]), "--json")
    assert made.exit_code == 0, made.stderr
    told = json.loads(made.stdout)
    for one in told.get("runs", [told]):
        assert (one["still_to_be_filled_in"], one["problem"]) == ([], None)
    assert (len(case.commands), case.typed) == (2, ())


@pytest.mark.slow
@pytest.mark.parametrize("make", CASES, ids=lambda make: make.__name__)
def test_two_commands_end_in_a_wear_rate_or_in_friction(run_cli, lab, monkeypatch, make):
    case = make()
    monkeypatch.chdir(written(case, lab / "user"))
    assert run_cli(*shlex.split(case.commands[0])).exit_code == 0
    done = run_cli(*shlex.split(case.commands[1]), "--no-figures", "--json")
    assert done.exit_code == 0, done.stderr
    runs = json.loads(done.stdout)["runs"]
    assert runs
    for run in runs:
        assert run["friction"] is not None
        if case.k_d is not None:
            (body,) = run["wear_fits"]["archard"]["bodies"].values()
            assert body["wear_coefficient"]["value"] == pytest.approx(case.k_d, rel=0.05)


@pytest.mark.slow
def test_the_sources_that_the_page_shows_are_those_of_the_drafts(lab, monkeypatch, run_cli):
    drafts = ""
    for make in CASES:
        if make.__name__ in ("german", "compend", "polish"):
            case = make()
            monkeypatch.chdir(written(case, lab / make.__name__))
            assert run_cli(*shlex.split(case.commands[0])).exit_code == 0
            drafts += next(Path().glob("*/run.toml")).read_text(encoding="utf-8")
    page = (ROOT / "docs" / "own_file.md").read_text(encoding="utf-8")
    shown = re.findall(r"(?m)^\| `(.* = .*)` \| `(.*)` \|$", page)
    assert len(shown) == 6
    for line, source in shown:
        assert re.search(rf"(?m)^{re.escape(line)} +# {re.escape(source)}$", drafts), line


@pytest.mark.parametrize("make", CASES, ids=lambda make: make.__name__)
def test_the_page_has_the_commands_of_each_export(make):
    case, page = make(), (ROOT / "docs" / "own_file.md").read_text(encoding="utf-8")
    (row,) = [line for line in page.splitlines() if line.startswith(f"| {case.title} |")]
    assert f"`{case.commands[0]}`" in row
    held = "friction" if case.k_d is None else "wear rate"
    assert f"| {len(case.typed)} | {held} |" in row


# --- header lines ---

LINES = {
    "German": "Normalkraft;5 N\nBahnradius;5 mm\nGleitgeschwindigkeit;0,1 m/s\nLuftfeuchte;45 %",
    "English": "# Normal load: 5 N\n# Track radius: 5 mm\n# Sliding speed: 0.1 m/s\n# Relative humidity: 45 %",
    "French with articles": "Charge appliquée : 5 N\nRayon de la piste : 5 mm\nVitesse : 10 cm/s\nHumidité : 45 %",
    "French": "Charge normale = 5 N\nRayon de piste = 5 mm\nVitesse de glissement = 0,1 m/s\nHumidité = 45 %",
    "Spanish": "Carga normal\t5 N\nRadio de la pista\t5 mm\nVelocidad\t0,1 m/s\nHumedad relativa\t45 %",
    "Spanish machine": "Carga aplicada: 5 N\nRadio de giro: 5 mm\nVelocidad: 0,1 m/s\nHumedad: 45 %",
    "colon and comma": "Load (N):,5\nTrack Radius (mm):,5\nSpeed (m/s):,0.1\nHumidity (%):,45",
    "Polish": "Siła normalna  5 N\nPromień tarcia  5 mm\nPrędkość poślizgu  0,1 m/s\nWilgotność względna  45 %",
    "Portuguese": "Carga aplicada: 5 N\nRaio da pista: 5 mm\nVelocidade: 0,1 m/s\nUmidade relativa: 45 %",
    "Korean": "하중: 5 N\n마찰 반경: 5 mm\n미끄럼 속도: 0.1 m/s\n상대 습도: 45 %",
    "Chinese": "载荷：5 N\n摩擦半径：5 mm\n滑动速度：0.1 m/s\n相对湿度：45 %",
    "Japanese": "荷重（N）,5\n回転半径（mm）,5\n摺動速度（m/s）,0.1\n湿度（%）,45",
    "units in fields": '"Normal load","5","N"\n"Track radius","5","mm"\n"Speed","0.1","m/s"\n"RH","45","%"',
}


@pytest.mark.parametrize("language", LINES)
def test_header_lines_of_any_language_are_facts(language):
    found = header_facts(LINES[language])
    assert found.notes == ()
    speed = found.facts.pop("conditions.sliding_speed")
    assert parse(speed, "speed") == pytest.approx(0.1)
    assert found.facts == {
        LOAD: "5 N",
        "conditions.track_radius": "5 mm",
        "conditions.relative_humidity": "45 %",
    }
    assert found.lines[LOAD] == LINES[language].splitlines()[0]


@pytest.mark.parametrize(
    ("line", "facts"),
    [
        ("Kugel 100Cr6 D=6 mm", {"material": "100Cr6", "diameter": "6 mm", "shape": "spherical"}),
        ("Kugel;100Cr6;Ø 6 mm", {"material": "100Cr6", "diameter": "6 mm", "shape": "spherical"}),
        ("Ball: Si3N4, R = 3,175 mm", {"material": "Si3N4", "radius": "3.175 mm", "shape": "spherical"}),
        ("Bille Al2O3 diamètre 10 mm", {"material": "Al2O3", "diameter": "10 mm", "shape": "spherical"}),
        ("Kugel 100Cr6 D6 mm", {"material": "100Cr6", "diameter": "6 mm", "shape": "spherical"}),
        ("Ball diameter;6 mm", {"diameter": "6 mm"}),
        ("Diámetro de bola: 6,0 mm", {"diameter": "6.0 mm"}),
        ("Oberkörper;Kugel 100Cr6, Ø 10 mm", {"material": "100Cr6", "diameter": "10 mm", "shape": "spherical"}),
    ],
)
def test_a_ball_is_read_by_diameter_or_radius(line, facts):
    assert header_facts(line).facts == {f"contact.pin.{key}": value for key, value in facts.items()}


@pytest.mark.parametrize(
    ("lines", "told"),
    [
        ("Normalkraft;5", "no unit"),
        ("Normalkraft;5 mm", "'mm' is not a unit for the force"),
        ("Normalkraft;fünf", "no number"),
        ("Normalkraft;1,000 N", "thousands"),
        ("Normalkraft;1.000 N\nSpurtiefe;0,5", "the point may be a decimal or a thousands separator"),
        ("Normalkraft;1.000 N\nDrehzahl;1.000,0 1/min", "the point may be a decimal or a thousands separator"),
        ("Normalkraft;1.000,00 N", "the number in '1.000,00 N' for conditions.normal_load is not understood"),
        ("Normalkraft;1.000,00;N", "the number in '1.000,00' for conditions.normal_load is not understood"),
        ("Load: 1,000.5 N", "the number in '1,000.5 N' for conditions.normal_load is not understood"),
        ("Load: 1 000 N", "the number in '1 000 N' for conditions.normal_load is not understood"),
        ("Normalkraft;0 N", "cannot be a force"),
        ("Normal load [N];5;10;20", "several numbers follow the label of conditions.normal_load"),
        ("Normal load;5 N;10 N", "several numbers"),
        ("Load [N]: 5, 10, 20", "several numbers"),
        ("Load,5,N,10,N", "several numbers"),
        ("Luftfeuchte;4500 %", "cannot be a percentage"),
        ("Kugel 100Cr6 6 mm", "may be the radius or the diameter"),
        ("Normalkraft;5 N\nLoad;10 N", "different values for conditions.normal_load"),
        ("Radius (mm)\t5.00", "the radius of the wear track or that of the ball"),
        ("Date: 05/12/2022 14:30:00", "the order of day and month is ambiguous"),
    ],
)
def test_header_lines_that_cannot_be_taken_are_named(lines, told):
    found = header_facts(lines)
    assert any(told in note for note in found.notes)
    assert not {LOAD, "contact.pin.radius", "contact.pin.diameter"} & found.facts.keys()


def test_a_point_in_a_header_above_decimal_commas_may_stand_between_thousands():
    header = "Drehzahl;1.200 1/min\nSpurradius;8.5 mm\n"
    assert header_facts(header).facts["conditions.rotational_speed"] == "1.200 1/min"
    found = header_facts(header, commas=True)
    assert found.facts == {"conditions.track_radius": "8.5 mm"}
    assert "write 1200, or" in found.notes[0]


@pytest.mark.parametrize(("decimal", "known"), [(",", False), (".", True)])
def test_the_decimal_separator_of_the_data_rows_counts_for_the_header(tmp_path, decimal, known):
    rows = "".join(f"{n}.5;2.{n}1\n".replace(".", decimal) for n in range(9))
    path = tmp_path / "a.csv"
    path.write_text(f"Normalkraft;1.000 N\n\nZeit [s];Reibkraft [N]\n{rows}", encoding="utf-8")
    assert (LOAD in read_export(path).header.facts) == known


def test_a_row_of_units_states_nothing():
    """The s of seconds is not a label of the sliding distance."""
    assert header_facts("Zeit;Weg;Reibkraft\ns;m;N\n").notes == ()
    assert header_facts("s;m;\n").notes == ()
    assert header_facts("    (s)       (N)      (um)\n").notes == ()


@pytest.mark.parametrize(
    ("lines", "started"),
    [
        ("Datum;12.05.2022 14:30:00", "2022-05-12T14:30:00"),
        ("Datum;12.05.2022\nUhrzeit;14:30", "2022-05-12T14:30:00"),
        ("日付,2022年5月12日", "2022-05-12"),
        ("Date: 2022-05-12 14:30:00", "2022-05-12T14:30:00"),
        ("Date: 05/12/2022 14:30:00", None),
        ("Date:,05/23/2022\nStart Time:,14:30:00", "2022-05-23T14:30:00"),
        ("Test Date\t5/23/2022", "2022-05-23"),
        ("Fecha: 12/05/2022\nHora: 14:30:01", "2022-05-12T14:30:01"),
        ("Datum;31.02.2022", None),
    ],
)
def test_dates_are_those_that_can_be_told(lines, started):
    assert header_facts(lines).facts.get("started") == started


@pytest.mark.parametrize(
    ("line", "facts"),
    [
        ("Operator:,J. Smith", {"operator": "J. Smith"}),
        ("Lubricant\tNone", {}),
        ("Schmierstoff: keiner;;;", {}),
        ("Speed (RPM):,197", {"conditions.rotational_speed": "197 RPM"}),
        ("Temperatura: 22,5 ºC", {"conditions.temperature": "22.5 ºC"}),
        ("Test Load (lbs):,30", {LOAD: "133.447 N"}),
        ("Load: 500 g", {LOAD: "4.90332 N"}),
        ("Load;5 N\nNormalkraft;5,0;N\nTest load;5000 mN", {LOAD: "5 N"}),
        ("Load;5;N;Speed;0.1", {LOAD: "5 N"}),
        ("Schwingweite;1,00 mm", {"conditions.stroke": "1.00 mm"}),
        ("Ring Diameter (in):,1.3780", {"contact.ring.radius": "0.689 in"}),
        ("Block Width: 0.250 in", {"contact.block.width": "0.250 in"}),
    ],
)
def test_lines_of_other_machines_are_facts(line, facts):
    assert header_facts(line).facts == facts


KEYS = {
    "Normalkraft": (LOAD, "N"),
    "Track radius": ("conditions.track_radius", "mm"),
    "Vitesse": ("conditions.sliding_speed", "m/s"),
    "Frecuencia": ("conditions.frequency", "Hz"),
    "转速": ("conditions.rotational_speed", "rpm"),
    "Balldiameter": ("contact.pin.diameter", "mm"),
}


@given(
    label=st.sampled_from(sorted(KEYS)),
    number=st.decimals("0.01", "9999", places=2),
    comma=st.booleans(),
    between=st.sampled_from(["{};{} {}", "{}: {} {}", "# {} = {} {}", '"{}";"{}";"{}"', "{}\t{}\t{}", "{0} [{2}];{1}"]),
)
def test_whatever_its_punctuation_a_line_is_read_with_its_value(label, number, comma, between):
    key, unit = KEYS[label]
    written_number = str(number).replace(".", ",") if comma else str(number)
    found = header_facts(between.format(label, written_number, unit))
    assert found.facts == {key: f"{number} {unit}"}
    assert found.notes == ()


@given(st.text(max_size=300) | st.text("Kugel=;:,. D5NmØ\tR\n%", max_size=80))
@settings(max_examples=200)
def test_any_header_is_read_without_an_error_and_its_facts_can_be_written(header):
    found = header_facts(header)
    assert found.facts.keys() == found.lines.keys()
    known = Known()
    for key, value in found.facts.items():
        assert value
        if key.startswith("conditions.") and key != "conditions.medium":
            assert known.take_text(key, value) is None


def test_a_draft_names_the_line_that_a_value_is_from(lab):
    (lab / "a.csv").write_text(table("Normalkraft;5 N\nKugel 100Cr6 D=6 mm\nDatum;12.05.2022\n\n"), encoding="utf-8")
    made, text, document = drafted(lab / "a.csv")
    assert made.missing == ()
    assert document["conditions"] == {"normal_load": "5 N"}
    assert "# from a.csv, 'Normalkraft;5 N'" in text
    assert '# diameter = "6 mm"' in text
    assert '# radius = "3 mm"' in text
    assert "half of the diameter" in text


def test_half_the_diameter_of_a_header_goes_before_the_template_s_radius(lab):
    (lab / "lab.toml").write_text(
        'schema = "tribopipe.template/1"\n[contact]\nkind = "pin-on-disc"\n[contact.pin]\nradius = "5 mm"\n', "utf-8"
    )
    (lab / "a.csv").write_text(table("Normalkraft;5 N\nKugel 100Cr6 D=6 mm\n\n"), encoding="utf-8")
    _, text, _ = drafted(lab / "a.csv", template=lab / "lab.toml")
    assert "half of the diameter; lab.toml gives 5 mm" in text


# --- what contradicts ---


def test_a_header_that_the_recording_contradicts_is_named_and_not_taken(lab):
    (lab / "a.csv").write_text(table("Normalkraft;5 N\n\n", load=20.0), encoding="utf-8")
    made, text, document = drafted(lab / "a.csv", accept=True)
    assert made.missing == (LOAD,)
    assert "conditions" not in document or LOAD not in document["conditions"]
    assert any(
        "found 5 N from a.csv, 'Normalkraft;5 N', but a median of 'Normal force [N]' of 20" in n for n in made.notes
    )
    assert "which the recording contradicts" in text


def test_a_person_s_word_stays_and_is_named_where_the_recording_contradicts_it(lab):
    (lab / "a.csv").write_text(table(load=20.0), encoding="utf-8")
    made, _, document = drafted(lab / "a.csv", settings=[f"{LOAD}=5 N"])
    assert document["conditions"]["normal_load"] == "5 N"
    assert any("found 5 N as stated, but a median" in note for note in made.notes)


MISLEADING = {
    "Al5N_pin.csv": None,  # five nines of purity
    "Si3N4-pin.csv": None,
    "0-3N.csv": None,
    "run_3_5N.csv": None,
    "10N_vs_20N.csv": "and another value",
    "5N-Al_10N.csv": "and another value",
    "1,000N.csv": None,
    "20N_test.csv": "left open",  # 5 N were recorded
    "5kN.csv": "left open",
    "5mN_run.csv": "left open",
    "T5N7.csv": None,
    "N5.csv": None,
}


@pytest.mark.parametrize("name", others_slow(MISLEADING, first=4))
def test_misleading_names_of_files_are_not_taken(lab, name):
    (lab / name).write_text(table(load=5.0), encoding="utf-8")
    made, text, document = drafted(lab / name, accept=True)
    told = MISLEADING[name]
    if told is None:
        assert document["conditions"]["normal_load"] == "5.005 N"
        assert made.accepted == (f"{LOAD} = 5.005 N, median of 'Normal force [N]'",)
    else:
        assert made.missing == (LOAD,)
        assert any(note.startswith(f"{LOAD} is not filled in: ") for note in made.notes)
        assert told in text or told == "left open"


@pytest.mark.parametrize("name", ["dt_100ms.csv", "r5mm_r8mm.csv", "d6mm.csv", "6mm.csv"])
def test_lengths_and_times_of_unknown_meaning_are_not_offered(name):
    known = Known()
    doubt_names(known, [name])
    assert not any(known.offered(key) for key in known.doubts)


def test_a_name_that_contradicts_a_header_is_named(lab):
    (lab / "20N.csv").write_text(table("Normalkraft;5 N\n\n"), encoding="utf-8")
    made, _, document = drafted(lab / "20N.csv", accept=True)
    assert document["conditions"]["normal_load"] == "5 N"
    assert any("but '20N' in the file name" in note for note in made.notes)


def test_nothing_is_taken_without_accept_and_what_is_has_its_source(lab):
    (lab / "a_5N.csv").write_text(table(), encoding="utf-8")
    made, text, _ = drafted(lab / "a_5N.csv")
    assert (made.missing, made.accepted) == ((LOAD,), ())
    assert "# suggested by the file name, '5N'" in text
    made, text, document = drafted(lab / "a_5N.csv", accept=True, id="b")
    assert document["conditions"]["normal_load"] == "5 N"
    assert "# suggested by the file name, '5N', accepted" in text


def test_a_channel_that_is_not_steady_is_not_offered(lab):
    rows = "".join(f"{n / 10:.1f};2.0;{1 + n}\n" for n in range(40))
    (lab / "a.csv").write_text(f"Time [s];Friction force [N];Normal force [N]\n{rows}", encoding="utf-8")
    made, text, _ = drafted(lab / "a.csv", accept=True)
    assert made.missing == (LOAD,)
    assert "which is not steady" in text


def test_y_takes_what_is_offered_and_a_ball_may_be_given_by_its_diameter(lab):
    (lab / "a_5N.csv").write_text(table(), encoding="utf-8")
    answers, heard = iter(["y", "0,1 m/s", "spherical", "D = 6 mm", *[""] * 20]), []

    def ask(question: str) -> str:
        heard.append(question)
        return next(answers)

    made = make_run(Wanted([lab / "a_5N.csv"]), ask, str)
    text = (made.folder / "run.toml").read_text(encoding="utf-8")
    assert "enter y to accept" in heard[0]
    assert tomllib.loads(text)["conditions"] == {"normal_load": "5 N", "sliding_speed": "0.1 m/s"}
    assert '# radius = "3 mm"' in text
    assert '# diameter = "6 mm"' in text


# --- numbers, units and names that labs write ---


@pytest.mark.parametrize(("typed", "read"), [("0,1 m/s", "0.1 m/s"), ("-1,25 N", "-1.25 N"), ("0,100 N", "0.100 N"),
                                             ("5 N", "5 N"), ("1.5 N", "1.5 N"), ("1,2,3", "1,2,3")])  # fmt: skip
def test_a_decimal_comma_is_understood(typed, read):
    assert with_point(typed) == read


@pytest.mark.parametrize("typed", ["1,000 N", "12,345 N", "-1,000 m"])
def test_a_comma_that_may_stand_between_thousands_is_refused(typed):
    with pytest.raises(UnitError, match="thousands"):
        with_point(typed)


@pytest.mark.parametrize("typed", ["1.020", "1.000 N", "-12.345 m", "1.234.567 um"])
def test_a_point_among_decimal_commas_may_stand_between_thousands(typed):
    with pytest.raises(UnitError, match="the point may be a decimal or a thousands separator") as refused:
        with_point(typed, commas=True)
    thousands = typed.split()[0].replace(".", "")
    assert f"; write {thousands}, or append a zero as a further decimal" in str(refused.value)
    assert with_point(typed) == typed


@pytest.mark.parametrize("typed", ["0.450 N", "1.02 N", "1.0200 N", "1020", "1.2379 steel"])
def test_a_point_that_can_only_be_a_decimal_one_is_understood_among_decimal_commas(typed):
    assert with_point(typed, commas=True) == typed


@pytest.mark.parametrize(
    ("text", "shown"),
    [("0,5", True), ("5,0 N", True), ("1.000,00 N", True), ("12,500 mm", False), ("1.5", False), ("5", False),
     ("1,3-diketone", False), ("1,2,3", False), ("", False)],
)  # fmt: skip
def test_a_decimal_comma_is_told_from_other_commas(text, shown):
    assert has_decimal_comma(text) == shown


@given(st.decimals("-999", "999", places=2), st.sampled_from(["N", "mm", "m/s"]))
def test_numbers_with_either_sign_are_the_same(number, unit):
    assert with_point(f"{number} {unit}".replace(".", ",")) == f"{number} {unit}"


@pytest.mark.parametrize(
    ("text", "kind", "si"),
    [
        ("1 Newton", "force", 1.0),
        ("1 Microns", "length", 1e-6),
        ("2 gms", "mass", 2e-3),
        ("25 Deg C", "temperature", 298.15),
        ("25 deg C", "temperature", 298.15),
        ("60 U/min", "rotational speed", 6.283185307179586),
        ("60 RPM", "rotational speed", 6.283185307179586),
        ("60 tr/min", "rotational speed", 6.283185307179586),
        ("60 obr/min", "rotational speed", 6.283185307179586),
        ("5 UM", "length", 5e-6),
        ("5 ?m", "length", 5e-6),
        ("5 Âµm", "length", 5e-6),
        ("1 Min", "time", 60.0),
        ("3 sek", "time", 3.0),
        ("3 Sekunden", "time", 3.0),
        ("2 Stunden", "time", 7200.0),
        ("2 Kg", "mass", 2.0),
        ("45 %RH", "percentage", 0.45),
        ("45 % r.F.", "percentage", 0.45),
        ("5 Pa", "pressure", 5.0),
    ],
)
def test_units_that_labs_type_are_understood(text, kind, si):
    assert parse(text, kind) == pytest.approx(si, rel=1e-12)


def test_units_of_other_quantities_stay_what_they_are():
    assert is_unit_of("mN", "force")
    assert not any(is_unit(unit) for unit in ("std", "STD", "max", "RMS"))  # statistics of other columns
    assert not any(is_unit_of(unit, "temperature") for unit in ("rpm", "N", "C"))


NAMES = {
    "German": "Zeit [s];Weg [m];Normalkraft [N];Reibkraft [N];Verschleißweg [µm]",
    "English": "Time (s);Sliding distance (m);Fz (N);Fx (N);Z (Microns)",
    "French": "Temps (s);Distance de glissement (m);Force normale (N);Force de frottement (N);Usure (µm)",
    "Spanish": "Tiempo (s);Distancia (m);Carga (N);Fuerza de fricción (N);Profundidad de desgaste (µm)",
    "Polish": "Czas [s];Droga tarcia [m];Obciążenie [N];Siła tarcia [N];Zużycie liniowe [µm]",
    "Spanish machine": "Tiempo (s);Distancia (m);Carga aplicada (N);Fuerza Rozamiento (N);Desgaste (micras)",
    "French machine": "Temps [s];Distance [m];Force normale [N];Force de frottement [N];Profondeur de pénétration [µm]",
    "symbols": "t [s];s [m];F_N [N];F_R [N];Δh [µm]",
    "American units": "Time (min);Distance (m);Load (lbf);Friction Force (lbf);Wear (mils)",
    "Chinese": "时间（s）;滑动距离（m）;法向载荷（N）;摩擦力（N）;磨损深度（µm）",
    "Japanese": "時間(s);すべり距離(m);垂直荷重(N);摩擦力(N);摩耗深さ(µm)",
}


@pytest.mark.parametrize("language", NAMES)
def test_columns_of_seven_languages_are_known(lab, language):
    rows = "".join(f"{n}.5;{n}.25;5.0;2.1;0.{n}\n" for n in range(9))
    (lab / "a.csv").write_text(f"{NAMES[language]}\n{rows}", encoding="utf-8")
    export = read_export(lab / "a.csv")
    meanings = export.meanings
    assert [meanings[column.name].signal for column in export.table.columns] == [
        *("time", "sliding_distance", "normal_force", "friction_force", "depth")
    ]
    assert not any(meaning.doubt for meaning in meanings.values())


def test_axes_count_only_where_no_column_has_a_name_and_are_left_open_where_two_could_be_it(lab):
    rows = "".join(f"{n}.5;5.0;2.1;0.{n};0.5\n" for n in range(9))
    (lab / "a.csv").write_text(f"Time (s);Fx (N);Friction (N);Z (um);LVDT (um)\n{rows}", encoding="utf-8")
    found = {one.signal: name for name, one in read_export(lab / "a.csv").meanings.items()}
    assert found == {"time": "Time (s)", "friction_force": "Friction (N)", "depth": "LVDT (um)"}
    (lab / "b.csv").write_text(f"Time (s);Fx (N);Fy (N);Z (um);A (um)\n{rows}", encoding="utf-8")
    doubts = {name: one.doubt for name, one in meanings_of(read_export(lab / "b.csv").table.columns).items()}
    assert doubts["Fx (N)"] == doubts["Fy (N)"] == "another column could also be this signal"


@pytest.mark.parametrize(
    ("encoding", "header", "names"),
    [
        ("gb18030", "载荷：5 N", "时间(秒),摩擦力(N),磨损量(μm)"),
        ("cp932", "垂直荷重：5 N", "時間(s),摩擦力(N),摩耗深さ(μm)"),
        ("big5", "荷重：5 N", "時間(s),摩擦力(N),depth(um)"),
        ("cp949", "하중: 5 N", "시간(s),마찰력(N),마모량(um)"),
    ],
)
def test_an_export_in_an_eastern_encoding_is_read_as_such(lab, encoding, header, names):
    rows = "".join(f"{n}.5,2.1,0.{n}\r\n" for n in range(9))
    (lab / "a.csv").write_bytes(f"{header}\r\n\r\n{names}\r\n{rows}".encode(encoding))
    export = read_export(lab / "a.csv")
    assert {meaning.signal for meaning in export.meanings.values()} == {"time", "friction_force", "depth"}
    assert export.header.facts == {LOAD: "5 N"}
    assert any(f"read as {encoding}" in note for note in export.notes)


def test_a_word_of_tribometers_in_a_western_file_changes_nothing(lab):
    (lab / "a.csv").write_bytes("Größe öäüß;Kraft é\n1;2\n3;4\n".encode("cp1252"))
    assert [column.name for column in read_export(lab / "a.csv").table.columns] == ["Größe öäüß", "Kraft é"]


def test_a_length_that_may_be_the_depth_is_named(lab):
    (lab / "a.csv").write_text(table(extra=";Antaa (µm);X (mm)", value=";0.5;1.5"), encoding="utf-8")
    made, _, _ = drafted(lab / "a.csv")
    assert [note for note in made.notes if "depth" in note] == [
        "a.csv: no column was identified as the depth signal; if 'Antaa (µm)' is the depth, map it to depth under "
        "[signals.columns]"
    ]


@pytest.mark.parametrize(
    ("extra", "told"),
    [
        (";Friction max (N);Max COF", "if 'Friction max (N)' or 'Max COF' is the friction, map it"),
        (";Fx (N);Fy (N)", "column 'Fy (N)' seems to be friction_force and is not used: another column"),
        (";Friction", "column 'Friction' seems to be friction_force and is not used: its unit is unknown"),
        (";Torque (N.m)", "column 'Torque (N.m)' seems to be friction_force and is not used: it could also be"),
        (";COF;Fx (N);Fy (N)", None),
    ],
)
def test_columns_that_may_be_the_friction_are_named(lab, extra, told):
    rows = "".join(f"{n / 10:.1f};{n / 100:.2f}{';0.5' * extra.count(';')}\n" for n in range(40))
    (lab / "a.csv").write_text(f"Time [s];Wear (µm){extra}\n{rows}", encoding="utf-8")
    notes = [note for note in drafted(lab / "a.csv")[0].notes if "friction" in note.casefold()]
    assert (told is None and not notes) or any(told in note for note in notes)


@pytest.mark.parametrize(("stroke", "is_position"), [("1 mm", True), ("8 mm", False)])
def test_a_displacement_by_the_stroke_is_the_position_along_it(lab, stroke, is_position):
    (lab / "lab.toml").write_text(
        f'schema = "tribopipe.template/1"\n[contact]\nkind = "reciprocating"\n[conditions]\nstroke = "{stroke}"\n',
        "utf-8",
    )
    rows = "".join(f"{n / 100:.2f};{500 * np.sin(n):.1f};{2 * np.cos(n):.3f}\n" for n in range(500))
    (lab / "a.csv").write_text(f"Time [s];Displacement [µm];Friction force [N]\n{rows}", encoding="utf-8")
    made, _, document = drafted(lab / "a.csv", template=lab / "lab.toml")
    assert ("depth" in document["signals"][0]["columns"]) != is_position
    assert any("it may be the position along the stroke" in note for note in made.notes) == is_position


def test_a_time_that_is_text_is_named(lab):
    rows = "".join(f"1/2/25 9:00:0{n};0.5;5.{n}\n" for n in range(9))
    (lab / "a.csv").write_text(f"Time;COF;Fn [N]\n{rows}", encoding="utf-8")
    notes = drafted(lab / "a.csv")[0].notes
    assert any("it contains text, first '1/2/25 9:00:00' in line 2" in note for note in notes)


# --- other kinds of contact ---

STEEL = 'material = "100Cr6"\nyoungs_modulus = "210 GPa"\npoisson_ratio = 0.3\n'


@pytest.mark.parametrize(
    ("kind", "bodies", "header"),
    others_slow(
        [
            ("reciprocating", {"pin": 'shape = "spherical"\n', "flat": ""}, "Kugel D=10 mm\nHub;1 mm\nScheibe;100Cr6"),
            ("block-on-ring", {"block": "", "ring": ""}, "Block width;6 mm\nRing diameter;35 mm"),
            ("four-ball", {"ball": 'diameter = "12.7 mm"\n'}, ""),
        ],
    ),
)
def test_a_template_may_be_of_any_kind_of_contact(lab, kind, bodies, header):
    tables = "".join(f"[contact.{body}]\n{own}{STEEL}" for body, own in bodies.items())
    (lab / "lab.toml").write_text(f'schema = "tribopipe.template/1"\n[contact]\nkind = "{kind}"\n{tables}', "utf-8")
    (lab / "a.csv").write_text(table(f"Normalkraft;5 N\n{header}\n\n"), encoding="utf-8")
    made, _, document = drafted(lab / "a.csv", template=lab / "lab.toml")
    assert (made.missing, made.bodies_lack, made.problem) == ((), (), None)
    assert document["contact"]["kind"] == kind


def test_a_reciprocating_run_lacks_its_stroke(lab):
    (lab / "lab.toml").write_text('schema = "tribopipe.template/1"\n[contact]\nkind = "reciprocating"\n', "utf-8")
    (lab / "a.csv").write_text(table("Normalkraft;5 N\n\n"), encoding="utf-8")
    made, _, _ = drafted(lab / "a.csv", template=lab / "lab.toml")
    assert made.missing == ("conditions.stroke",)


@pytest.mark.slow
def test_blocks_and_rings_in_a_header_tell_the_kind(lab):
    (lab / "a.csv").write_text(table("Load;5 N\nBlock width;6 mm\nRing diameter;35 mm\n\n"), encoding="utf-8")
    _, text, _ = drafted(lab / "a.csv")
    assert '# kind = "block-on-ring"' in text
    assert '# radius = "17.5 mm"' in text


def test_another_material_than_that_of_the_template_s_modulus_is_named(lab):
    (lab / "lab.toml").write_text(
        f'schema = "tribopipe.template/1"\n[contact]\nkind = "pin-on-disc"\n[contact.pin]\n{STEEL}', "utf-8"
    )
    (lab / "a.csv").write_text(table("Normalkraft;5 N\nKugel Al2O3 D=6 mm\n\n"), encoding="utf-8")
    made, _, _ = drafted(lab / "a.csv", template=lab / "lab.toml")
    assert any("found Al2O3 from a.csv, 'Kugel Al2O3 D=6 mm', but 100Cr6 from lab.toml" in note for note in made.notes)


# --- from process to new ---


def test_process_of_a_file_or_a_folder_of_exports_points_to_new(run_cli, lab):
    (lab / "my exports").mkdir()
    (lab / "my exports" / "a.csv").write_text(table(), encoding="utf-8")
    for given_path in (Path("my exports") / "a.csv", Path("my exports")):
        refused = run_cli("process", given_path)
        assert refused.exit_code == 1
        assert f'tribopipe new "{given_path}"' in refused.stderr
        assert len(refused.stderr.strip().splitlines()) == 1


@pytest.mark.slow
def test_a_workbook_s_list_of_settings_fills_the_run(lab):
    case = next(make() for make in CASES if make.__name__ == "workbook")
    home = written(case, lab / "user")
    made, text, document = drafted(home / "tests.xlsx", sheet="Test 2", template=home / "lab.toml")
    assert document["operator"] == "A. Tester"
    assert document["contact"]["pin"]["radius"] == "3 mm"
    assert "from tests.xlsx, 'Normal load 5 N'" in text
    assert read_run(made.folder).columns["depth"].size


# --- Optimol SRV ---


def srv_table(**units: str) -> ReadTable:
    shown = {**SRV_COLUMNS, **units}
    columns = tuple(
        ReadColumn(name, np.ones(3), unit.strip("[]") or None) for name, unit in shown.items() if unit is not None
    )
    return ReadTable(columns)


@pytest.mark.slow
def test_the_columns_of_an_srv_are_signals_and_its_friction_is_left_to_the_lab(lab):
    (lab / "a.xlsx").write_bytes(srv(60))
    export = read_export(lab / "a.xlsx")
    assert {column.name: column.signal for column in export.table.columns if column.signal} == {
        "Time": "time",
        "Temperature 1": "temperature",
        "Stroke sliding speed average value current": "sliding_speed",
        "Load": "normal_force",
    }
    assert export.friction is None
    made, text, _ = drafted(lab / "a.xlsx", accept=True)
    assert made.missing == ()
    assert "one of 3 definitions of friction" in text


def test_a_column_of_an_srv_with_a_unit_of_another_kind_is_no_signal():
    signals = {column.name: column.signal for column in with_srv_meanings(srv_table(Load="[mm]")).columns}
    assert (signals["Load"], signals["Time"]) == (None, "time")


@given(st.lists(st.text(max_size=20), max_size=5))
def test_tables_of_other_instruments_stay_as_they_are(names):
    table = ReadTable(tuple(ReadColumn(name, np.ones(2), "N") for name in ["Time", "Load", *names]))
    assert with_srv_meanings(table) is table

"""Columns without [signals.columns]: what is promised is used, and what is not used is named."""

import json

import numpy as np
import pytest
from sweeps import others_slow

from tribopipe.base.errors import ReaderError
from tribopipe.evaluation.checks.registry import check_run
from tribopipe.readers import long_text
from tribopipe.readers.column_mapping import contradiction
from tribopipe.readers.export_files import read_export
from tribopipe.readers.harmonize import read_run
from tribopipe.readers.reader import ReadColumn

HEAD = 'schema = "tribopipe.run/1"\nid = "run"\n[conditions]\nnormal_load = "{load}"\nsliding_speed = "0.1 m/s"\n'
NAMES = "Time [s];Depth [um];Ff [mN];Fn [mN]"
ROWS = [f"{n * 0.1:.1f};{n * 0.01:.2f};{100 + n % 3}.0;{200 + n % 2}.0" for n in range(2000)]


def made(folder, rows=ROWS, *, names=NAMES, load="200 mN", more=""):
    (folder / "signals.csv").write_text("\n".join([names, *rows]) + "\n", encoding="utf-8")
    text = HEAD.format(load=load) + '[[signals]]\nfile = "signals.csv"\n' + more
    (folder / "run.toml").write_text(text, encoding="utf-8")
    return folder


def spoiled(row: int, column: int, text: str) -> list[str]:
    rows = list(ROWS)
    cells = rows[row].split(";")
    cells[column] = text
    rows[row] = ";".join(cells)
    return rows


def findings(run):
    return {finding.code: finding for finding in check_run(run)}


def test_what_detect_promises_is_used(tmp_path, run_cli):
    run = read_run(made(tmp_path, load="250 mN"))
    promised = json.loads(run_cli("formats", "detect", tmp_path / "signals.csv", "--json").stdout)["files"][0][
        "columns"
    ]
    assert {column["signal"] for column in promised} == {"time", "depth", "friction_force", "normal_force"}
    assert {name for name, origin in run.origins.items() if origin == "measured"} == {c["signal"] for c in promised}
    assert run.columns["normal_force"][:2] == pytest.approx([0.2, 0.201])
    assert run.origins["friction_coefficient"] == "derived from measured load"
    assert "found a median of 0.2005 N" in findings(run)["load_not_nominal"].message
    assert "signals.csv: column 'Fn [mN]' is interpreted as normal_force, from its name" in run.notes


GROUPED = ["59,841", "1.234,5", "1,234,567.8", "1 234.5", "1'234.5"]
MORE = "[signals.columns]\ntime = 'Time [s]'\nfriction_force = 'Ff [mN]'\nnormal_force = 'Fn [mN]'\n"


@pytest.mark.parametrize("more", ["", MORE], ids=["by name", "declared"])
@pytest.mark.parametrize(
    "token", others_slow(["OVL", "-", "---", "...", "*****", "#ERR", "1.#INF", "n/a"], "OVL", "1.#INF")
)
def test_a_placeholder_is_a_missing_sample_that_is_named(tmp_path, token, more):
    run = read_run(made(tmp_path, spoiled(1234, 2, token), more=more))
    assert np.flatnonzero(np.isnan(run.columns["friction_force"])).tolist() == [1234]
    assert "signals.csv: column 'Ff [mN]': 1 field contains a placeholder, treated as missing; the first is " + (
        f"{token!r} in line 1236"
    ) in " ".join(run.notes)
    assert "1 of 2000 samples missing, the first at" in findings(run)["missing_samples"].message


@pytest.mark.parametrize("more", ["", MORE], ids=["by name", "declared"])
@pytest.mark.parametrize("junk", ["8.0.1", "abc", *GROUPED])
def test_anything_else_is_refused_with_its_place(tmp_path, junk, more):
    with pytest.raises(ReaderError) as caught:
        read_run(made(tmp_path, spoiled(1234, 2, junk), more=more))
    said = str(caught.value)
    assert f"signals.csv, line 1236, column 'Ff [mN]': found {junk!r}; expected a number for friction_force" in said
    assert ("decimal separator of the others" in said) == (junk == "59,841")
    assert ("thousands separators" in said) == (junk in GROUPED)


def test_a_recorded_coefficient_is_not_replaced_by_another(tmp_path):
    names = "Time [s];COF;Ff [mN]"
    rows = [f"{n * 0.1:.1f};0.5;100" for n in range(2000)]
    rows[1000] = "100.0;OVL;100"
    run = read_run(made(tmp_path, rows, names=names, load="250 mN"))
    assert run.origins["friction_coefficient"] == "measured"
    assert np.nanmean(run.columns["friction_coefficient"]) == pytest.approx(0.5)
    rows[1000] = "100.0;0.5.0;100"
    with pytest.raises(ReaderError, match=r"line 1002, column 'COF': found '0\.5\.0'"):
        read_run(made(tmp_path, rows, names=names, load="250 mN"))


FACTORS = ["Revolutions [10^3]", "Revolutions (x1000)", "Laps [krev]", "N ×10³", "Umdr. [1000 Umdr.]", "count (1e3)"]


def counted(folder, column, unit=""):
    rows = [f"{row};{number / 1000:.3f}" for number, row in enumerate(ROWS)]
    made(folder, rows, names=f"{NAMES};{column}", more=f"{MORE}rotations = {{ column = {column!r}{unit} }}\n")
    path = folder / "run.toml"
    text = path.read_text(encoding="utf-8").replace("[[signals]]", 'track_radius = "10 mm"\n[[signals]]')
    path.write_text(text, encoding="utf-8")
    return read_run(folder)


@pytest.mark.parametrize("column", others_slow(FACTORS, FACTORS[0]))
def test_a_factor_in_a_name_is_not_read_over(tmp_path, column):
    with pytest.raises(ReaderError, match="which may be a factor; expected a unit for rotations"):
        counted(tmp_path, column)
    assert counted(tmp_path, column, ', unit = "kcount"').columns["rotations"][-1] == pytest.approx(1999)
    assert counted(tmp_path, column, ', unit = "count"').columns["rotations"][-1] == pytest.approx(1.999)


@pytest.mark.parametrize("column", ["Revolutions (total)", "cycles [1]", "max1000", "Laps (1000 Hz)", "Laps (Mcycles)"])
def test_other_brackets_in_a_name_are_no_factor(tmp_path, column):
    assert counted(tmp_path, column).columns["rotations"][-1] == pytest.approx(1.999e6 if "M" in column else 1.999)


@pytest.mark.parametrize("name", ["v [m/s]", "v (m/s)", "v_gleit [mm/s]"])
def test_the_symbol_of_the_sliding_speed_is_recognized_with_its_unit(tmp_path, name):
    run = read_run(made(tmp_path, names=NAMES.replace("Depth [um]", name)))
    factor = 1e-3 if "mm/s" in name else 1
    assert run.origins["sliding_speed"] == "measured"
    assert run.columns["sliding_speed"][-1] == pytest.approx(19.99 * factor)
    assert run.sliding_distance[-1] == pytest.approx(19.99 * factor * 199.9 / 2, rel=1e-3)
    assert f"signals.csv: column {name!r} is interpreted as sliding_speed, from its name" in run.notes


@pytest.mark.parametrize("name", ["v", "v [V]", "v1 [m/s]", "v_soll [m/s]", "Rolling speed (mm/s)", "wear rate [um/s]"])
def test_other_symbols_and_speeds_are_no_sliding_speed(tmp_path, name):
    run = read_run(made(tmp_path, names=NAMES.replace("Depth [um]", name)))
    assert run.origins.get("sliding_speed") != "measured"
    assert "unused_signal" not in findings(run)


def test_a_recorded_speed_goes_before_a_symbol(tmp_path):
    run = read_run(made(tmp_path, names=NAMES.replace("Depth [um]", "v [m/s]").replace("Ff [mN]", "Speed [m/s]")))
    assert run.columns["sliding_speed"][0] == 100
    assert "unused_signal" not in findings(run)


@pytest.mark.parametrize(
    ("names", "why"),
    [
        (NAMES.replace("Depth [um]", "Tempo [m/s]"), "is not used: it could also be another speed"),
        (
            NAMES.replace("Depth [um]", "v [m/s]").replace("Ff [mN]", "v_ist [m/s]"),
            "column 'v_ist [m/s]' seems to be sliding_speed and is not used: another",
        ),
        (
            NAMES.replace("Ff [mN]", "Ff"),
            "column 'Ff' seems to be friction_force and is not used: its unit is unknown",
        ),
        (NAMES.replace("Depth [um]", "Fz [N]"), "column 'Fz [N]' seems to be normal_force and is not used: another"),
    ],
)
def test_what_is_not_used_is_named(tmp_path, names, why):
    found = check_run(read_run(made(tmp_path, names=names)))
    warnings = [finding for finding in found if finding.code == "unused_signal"]
    assert {(warning.severity, warning.where) for warning in warnings} == {("warning", "signals")}
    assert any(why in warning.message for warning in warnings)


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("Humidity (RH)", "relative_humidity and is not used: its unit 'RH' is not a unit of percentage"),
        ("Temp (V)", "temperature and is not used: its unit 'V' is not a unit of temperature"),
        ("Wear [mg]", "depth and is not used: its unit 'mg' is not a unit of length"),
        ("Wear [0.1 µm]", "depth and is not used: '0.1 µm' is not a known unit"),
        ("COF (max)", "friction_coefficient and is not used: 'max' is not a known unit"),
        ("Friction (µ)", "friction_force and is not used: its unit is unknown"),
        ("Friction (u)", "friction_force and is not used: its unit is unknown"),
    ],
)
def test_a_unit_of_another_kind_is_named(tmp_path, name, why):
    run = read_run(made(tmp_path, names=f"Time [s];{name};Fz [mN];x"))
    assert run.unused == (f"signals.csv: column {name!r} seems to be {why}",)


@pytest.mark.parametrize(
    ("names", "doubtful"),
    [
        ("Time [s];Depth [um];Torque [N.m];Fn [mN]", True),
        ("Time [s];Depth [um];Drehmoment [mNm];Fn [mN]", True),
        ("Time [s];COF;Torque [N.m];Fn [mN]", False),
        ("Time [s];Depth [um];Torque [%];Fn [mN]", False),
    ],
)
def test_a_torque_may_be_that_of_the_drive(tmp_path, names, doubtful):
    run = read_run(made(tmp_path, names=names))
    assert "friction_force" not in run.columns
    found = findings(run).get("unused_signal")
    assert (found is not None and "torque of the drive" in found.message) == doubtful


def test_a_rotational_speed_is_no_doubtful_sliding_speed(tmp_path):
    assert not read_run(made(tmp_path, names="Time [s];Depth [um];Speed [rpm];Fn [mN]")).unused


@pytest.mark.parametrize("name", ["COF (µ)", "COF [μ]", "COF (u)"])
def test_a_lone_micro_is_no_unit(tmp_path, name):
    run = read_run(made(tmp_path, names=f"Time [s];Depth [um];{name};Fn [mN]"))
    assert run.columns["friction_coefficient"][:2] == pytest.approx([100, 101])
    assert not run.unused


@pytest.mark.parametrize(
    ("names", "more"),
    [
        ("Time [s];Temp (C);Ff [mN];Fn [mN]", ""),
        ("Time [s];Temperature (C);Ff [mN];Fn [mN]", ""),
        ("Time [s];temp_C;Ff [mN];Fn [mN]", ""),
        ("Time [s];Bath (C);Ff [mN];Fn [mN]", "[signals.columns]\ntime = 'Time [s]'\ntemperature = 'Bath (C)'\n"),
    ],
)
def test_coulombs_of_a_temperature_are_degrees(tmp_path, names, more):
    assert read_run(made(tmp_path, names=names, more=more)).columns["temperature"][0] == pytest.approx(273.15)


@pytest.mark.parametrize("form", ["(hh:mm:ss)", "[mm:ss]", "(h:mm:ss)", "(HH:MM:SS.sss)", "[hh:mm:ss,000]"])
def test_clock_form_behind_the_name_of_the_time_is_no_part_of_it(tmp_path, form):
    rows = [f"9:{n // 60:02d}:{n % 60:02d};{n * 0.01:.2f};100.0;200.0" for n in range(100)]
    run = read_run(made(tmp_path, rows, names=f"Time {form};Depth [um];Ff [mN];Fn [mN]"))
    assert run.origins["time"] == "measured"
    assert run.columns["time"][-1] == 99


@pytest.mark.parametrize(
    ("unit", "note"),
    [
        ("um", "column 'Depth [mm]' is in mm in the file, but is read in um as stated in run.toml"),
        ("millimeter", None),
    ],
)
def test_a_stated_unit_that_contradicts_the_file_is_noted(tmp_path, unit, note):
    more = f"[signals.columns]\ntime = 'Time [s]'\ndepth = {{ column = 'Depth', unit = '{unit}' }}\n"
    run = read_run(made(tmp_path, names=NAMES.replace("um", "mm"), more=more))
    assert run.columns["depth"][100] == pytest.approx(1e-6 if unit == "um" else 1e-3)
    assert [one for one in run.notes if "Depth" in one] == ([f"signals.csv: {note}"] if note else [])


@pytest.mark.parametrize(
    ("own", "stated", "noted"),
    [
        ("V", "N", True),
        ("degC", "um", True),
        ("rpm", "m/s", True),
        ("kg", "N", True),
        ("C", "K", True),
        ("kg", "kgf", False),
        ("kgf", "kg", False),
        ("C", "degC", False),
        ("°C", "C", False),
        ("F", "degF", False),
        ("S", "s", False),
        ("-", "N", False),
        ("1", "N", False),
        ("counts", "um", False),
        ("V", "1", False),
        ("wobble", "N", False),
        (None, "N", False),
    ],
)
def test_a_unit_of_another_kind_contradicts_unless_it_may_mean_the_same(own, stated, noted):
    why = contradiction(ReadColumn("U", np.zeros(3), own), stated, "run.toml")
    assert (why is not None) == noted
    if noted:
        assert f"column 'U' is in {own} in the file" in why
        assert f"is read in {stated} as stated in run.toml" in why


def test_a_column_read_in_a_unit_of_another_kind_is_warned_of(tmp_path):
    more = "[signals.columns]\ntime = 'Time [s]'\nnormal_force = { column = 'U', unit = 'N' }\n"
    found = findings(read_run(made(tmp_path, names=NAMES.replace("Fn [mN]", "U [V]"), more=more)))["units_disagree"]
    assert "column 'U [V]' is in V in the file, a unit of another kind, but is read in N" in found.message
    assert "map another column" in found.remedy


@pytest.mark.parametrize(
    ("scale", "noted"),
    [("", True), ("scale = 1", False), ("scale = -1", False), ("scale = 20", False), ("offset = 1", True)],
)
def test_a_described_unit_of_another_kind_is_noted_unless_a_scale_converts(tmp_path, scale, noted):
    text = 'schema = "tribopipe.reader/1"\nname = "rig"\ntitle = "Rig"\n[columns.U]\nsignal = "normal_force"\n'
    (tmp_path / "rig.toml").write_text(f'{text}unit = "N"\n{scale}\n', encoding="utf-8")
    folder = made(tmp_path, names=NAMES.replace("Fn [mN]", "U [V]"))
    row = 'file = "signals.csv"\n'
    told = (folder / "run.toml").read_text(encoding="utf-8").replace(row, f'{row}reader = "rig.toml"\n')
    (folder / "run.toml").write_text(told, encoding="utf-8")
    assert any("'U [V]' is in V in the file" in note for note in read_run(folder).notes) == noted


@pytest.mark.parametrize(("scale", "noted"), [("", True), ("scale = -1", True), ("scale = 1000", False)])
def test_a_described_unit_that_contradicts_the_file_is_noted(tmp_path, scale, noted):
    text = 'schema = "tribopipe.reader/1"\nname = "rig"\ntitle = "Rig"\n[columns.Depth]\nsignal = "depth"\n'
    (tmp_path / "rig.toml").write_text(f'{text}unit = "um"\n{scale}\n', encoding="utf-8")
    names, row = NAMES.replace("um", "mm"), 'file = "signals.csv"\nreader = "rig.toml"\n'
    folder = made(tmp_path, names=names)
    told = (folder / "run.toml").read_text(encoding="utf-8").replace('file = "signals.csv"\n', row)
    (folder / "run.toml").write_text(told, encoding="utf-8")
    note = "signals.csv: column 'Depth [mm]' is in mm in the file, but is read in um as stated in the profile 'rig'"
    assert (note in read_run(folder).notes) == noted


def test_words_under_the_name_of_a_signal_are_named(tmp_path):
    rows = [row.replace(";100.0;", ";on;").replace(";101.0;", ";off;").replace(";102.0;", ";on;") for row in ROWS]
    run = read_run(made(tmp_path, rows, names=NAMES.replace("Ff [mN]", "friction_force")))
    assert "'friction_force' seems to be friction_force and is not used: it contains text, first 'on'" in (
        findings(run)["unused_signal"].message
    )


def test_a_column_that_is_declared_leaves_synonyms_alone(tmp_path):
    run = read_run(made(tmp_path, more="[signals.columns]\nfriction_force = 'Ff [mN]'\n"))
    assert "normal_force" not in run.columns
    assert not run.unused


def test_placeholders_of_a_long_file_are_counted_over_its_blocks(tmp_path, monkeypatch):
    rows = spoiled(1500, 2, "OVL")
    rows[1900] = rows[1900].replace(rows[1900].split(";")[2], "---", 1)
    monkeypatch.setattr(long_text, "LARGE", 1)
    monkeypatch.setattr(long_text, "PIECE", 4096)
    monkeypatch.setattr(long_text, "TAIL", 4096)
    run = read_run(made(tmp_path, rows))
    assert run.notes[0] == (
        "signals.csv: column 'Ff [mN]': 2 fields contain placeholders, treated as missing; the first is 'OVL' in line "
        "1502"
    )
    assert np.flatnonzero(np.isnan(run.columns["friction_force"])).tolist() == [1500, 1900]


def test_detect_names_placeholders_and_words(tmp_path):
    made(tmp_path, spoiled(10, 2, "OVL"))
    assert "'OVL' in line 12" in " ".join(read_export(tmp_path / "signals.csv").notes)
    made(tmp_path, spoiled(10, 2, "8.0.1"))
    export = read_export(tmp_path / "signals.csv")
    assert "column 'Ff [mN]': kept as text, since line 12 contains '8.0.1', which is not a number" in export.notes
    assert export.meanings["Ff [mN]"].signal == "friction_force"


def test_farads_of_a_temperature_are_degrees(tmp_path):
    run = read_run(made(tmp_path, names="Time [s];Temp (F);Ff [mN];Fn [mN]"))
    assert run.columns["temperature"][0] == pytest.approx(255.372, abs=0.001)


@pytest.mark.parametrize(
    "names",
    [
        "time_s;wear_um;ff_mN;load_mN",
        "t_s;h_um;Friction_force_mN;Fn_mN",
        "Time, s;Wear, um;Friction force, mN;Load, mN",
        "Zeit in s;Verschleiß in µm;Reibkraft in mN;Normalkraft in mN",
        "Time {s};Wear <um>;Friction {mN};Load <mN>",
        "t/s;h/µm;Reibkraft/mN;Fn/mN",
        "Zeit / Time [s];Verschleiß / Wear [um];Reibkraft Fr [mN];Normalkraft F_N [mN]",
        "时间 Time (s);磨损量 Wear (um);Friction force(摩擦力)/mN;载荷Load/mN",
        "시간(s);마모깊이(um);마찰력(mN);수직하중(mN)",
        "Tempo (s);Profundidade do desgaste (um);Força de atrito (mN);Força normal (mN)",
        "Elapsed [s];Mean wear [um];Ff avg [mN];Actual load [mN]",
    ],
)
def test_names_of_other_labs_are_recognized_with_their_units(tmp_path, names):
    columns = read_run(made(tmp_path, names=names)).columns
    found = [float(columns[signal][1]) for signal in ("time", "depth", "friction_force", "normal_force")]
    assert found == pytest.approx([0.1, 0.01e-6, 0.101, 0.201])


@pytest.mark.parametrize(
    "name", ["Load max [mN]", "Load std [mN]", "Set load [mN]", "Load_min", "F_s [mN]", "Load_1", "Friction load [mN]"]
)
def test_names_with_another_meaning_are_no_load(tmp_path, name):
    assert "normal_force" not in read_run(made(tmp_path, names=NAMES.replace("Fn [mN]", name))).columns


def test_a_second_table_below_the_first_is_named(tmp_path):
    with pytest.raises(ReaderError, match="line 2002: found the header row again; expected one table per file; split"):
        read_run(made(tmp_path, rows=[*ROWS, NAMES, *ROWS]))

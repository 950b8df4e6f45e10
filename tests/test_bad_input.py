"""Bad input: one sentence that says where, what and how to mend it; exit code 1; the archive as it was."""

from functools import partial

import h5py
import pytest
from archived_files import edited
from folders import edit_rows, replace_in, set_key, tree_bytes
from hanging import ends_soon
from sweeps import others_slow

pytestmark = pytest.mark.usefixtures("few_draws")

HEADER = "Time [s],Depth [um],Ff [mN],Fn [mN]"
FILE_LINE = r'file = "signals\.csv"'


def complaint(result) -> str:
    """The one sentence of a refusal."""
    lines = result.stderr.splitlines()
    errors = [line for line in lines if line.startswith("error: ")]
    assert len(errors) == 1, result.stderr
    assert errors == lines, "a refusal says nothing else"
    assert result.stdout == ""
    return errors[0]


def assert_refused(result, *words: str) -> None:
    assert result.exit_code == 1
    said = complaint(result)
    assert [word for word in words if word not in said] == [], said


def rewrite(name: str, content: bytes):
    return lambda run: (run / name).write_bytes(content)


def remove(name: str):
    return lambda run: (run / name).unlink()


def into_folder(name: str):
    def spoil(run):
        (run / name).unlink()
        (run / name).mkdir()

    return spoil


def nameless_time(run):
    """Take the meaning of the first column away, in run.toml and by its name."""
    replace_in(run / "run.toml", "(?m)^time = .*\n", "")
    replace_in(run / "signals.csv", r"Time \[s\]", "Clock [s]")


def key(name: str, value: str):
    return lambda run: set_key(run, name, value)


def manifest(pattern: str, text: str):
    return lambda run: replace_in(run / "run.toml", pattern, text)


def rows(edit):
    return partial(edit_rows, edit=edit)


def field(line: int, column: int, text: str):
    """Put a text into one field; lines count from 1 as in an editor."""

    def edit(lines):
        cells = lines[line - 1].split(",")
        cells[column] = text
        return [*lines[: line - 1], ",".join(cells), *lines[line:]]

    return rows(edit)


def whole_column(column: int, text: str):
    def edit(lines):
        split = [line.split(",") for line in lines[1:]]
        return [lines[0], *(",".join([*cells[:column], text, *cells[column + 1 :]]) for cells in split)]

    return rows(edit)


def cut_last_row(run):
    path = run / "signals.csv"
    content = path.read_bytes()
    path.write_bytes(content[: content.rstrip().rfind(b",")])


# What is done to a sound run folder, and words that the refusal must hold.
SPOILED = {
    # files
    "no run.toml": (remove("run.toml"), ["sample-run", "run.toml", "tribopipe new"]),
    "run.toml is a folder": (into_folder("run.toml"), ["run.toml", "found a folder", "expected a TOML file"]),
    "no signal file": (remove("signals.csv"), ["signals.csv", "no such file", "run.toml"]),
    "misnamed signal file": (
        manifest(FILE_LINE, 'file = "signal.csv"'),
        ["signal.csv", "no such file", "did you mean 'signals.csv'?"],
    ),
    "signal file is a folder": (
        into_folder("signals.csv"),
        ["signals.csv", "found a folder", "expected a signal file"],
    ),
    "signal file outside the run folder": (
        manifest(FILE_LINE, 'file = "../signals.csv"'),
        ["run.toml", "signals[0].file", "../signals.csv", "run folder", "copy"],
    ),
    "signal file by an absolute path": (
        manifest(FILE_LINE, r'file = "C:\\data\\signals.csv"'),
        ["run.toml", "signals[0].file", "run folder", "copy"],
    ),
    "signal file with a control character": (
        manifest(FILE_LINE, r'file = "signals\u0000.csv"'),
        ["run.toml", "signals[0].file", "expected"],
    ),
    "empty signal file": (rewrite("signals.csv", b""), ["sample-run", "signals.csv", "empty", "copy it again"]),
    "header alone": (rewrite("signals.csv", HEADER.encode()), ["signals.csv", "no data row", "export"]),
    "no header": (rows(lambda lines: lines[1:]), ["signals.csv", "without a header row", "Time [s]"]),
    "binary file": (rewrite("signals.csv", bytes(range(256)) * 64), ["signals.csv", "expected text", "export"]),
    "unknown reader": (
        manifest(FILE_LINE, 'file = "signals.csv"\nreader = "delimted"'),
        ["sample-run", "reader", "'delimted'", "did you mean 'delimited'?"],
    ),
    # columns
    "wrong column name": (
        manifest("Depth \\[um\\]", "Dept [um]"),
        ["signals.csv", "'Dept [um]'", "depth", "did you mean 'Depth [um]'?"],
    ),
    "unit of another kind": (
        manifest(r'"Depth \[um\]"', '"Depth [um]", unit = "mN"'),
        ["signals.csv", "Depth [um]", "depth", "'mN'", "length", "'um'"],
    ),
    "unit that is none": (
        manifest(r'"Depth \[um\]"', '"Depth [um]", unit = "microns deep"'),
        ["signals.csv", "Depth [um]", "'microns deep'", "not a unit", "'um'"],
    ),
    "unknown signal": (
        manifest("(?m)^depth = ", "dept = "),
        ["run.toml", "signals[0].columns.dept", "unknown key", "did you mean 'depth'?"],
    ),
    "neither time nor distance": (
        nameless_time,
        ["run.toml", "neither time nor sliding_distance", "signals.columns"],
    ),
    # rows
    "text among numbers": (
        field(7, 1, "8.0.1"),
        ["sample-run", "signals.csv, line 7", "Depth [um]", "'8.0.1'", "expected a number", "correct"],
    ),
    "row cut in the middle of the file": (
        rows(lambda lines: [*lines[:500], lines[500].rpartition(",")[0], *lines[501:]]),
        ["signals.csv, line 501", "found 3 fields, expected 4", "delete that line"],
    ),
    "row cut at the end of the file": (cut_last_row, ["signals.csv, line 1252", "3 fields", "copy it again"]),
    "row too long": (
        rows(lambda lines: [*lines[:9], lines[9] + ",1.0", *lines[10:]]),
        ["signals.csv, line 10", "found 5 fields, expected 4", "correct that line"],
    ),
    "one sample": (rows(lambda lines: lines[:2]), ["signals", "1 sample", "at least 2", "export"]),
    "channel without a number": (whole_column(1, "NaN"), ["depth", "no numeric values", "remove the signal"]),
    "hole in time": (field(12, 0, ""), ["time", "1 missing", "sample 11", "delete those rows"]),
    "time runs backwards": (
        field(12, 0, "0.2"),
        ["time", "sample 11", "0.2 s", "0.9 s", "expected increasing values", "delete"],
    ),
    "time stands still": (whole_column(0, "1.0"), ["time", "expected increasing values", "check"]),
    # run.toml as a document
    "no TOML": (manifest("(?m)^medium = .*$", "medium = air"), ["run.toml", "invalid TOML", "line 38", "quotes"]),
    "run.toml in another encoding": (
        lambda run: (run / "run.toml").write_bytes('title = "Größe"'.encode("cp1252")),
        ["run.toml", "byte 11", "not UTF-8", "save"],
    ),
    "number too long for a computer": (manifest("poisson_ratio = .*", "poisson_ratio = " + "9" * 5000), ["run.toml"]),
    "other schema": (key("schema", '"tribopipe.run/9"'), ["run.toml", "schema", "tribopipe.run/9", "tribopipe.run/1"]),
    "unknown key": (
        manifest("(?m)^radius = ", "raduis = "),
        ["run.toml", "contact.pin.raduis", "unknown key", "did you mean 'radius'?"],
    ),
    "unknown key of two lines": (
        manifest("(?m)^radius = ", r'"rad\nius" = '),
        ["run.toml", "contact.pin", "unknown key"],
    ),
    "missing key": (manifest("(?m)^material = .*\n", ""), ["run.toml", "contact.pin.material", "missing", "add"]),
    "unknown contact": (
        key("kind", '"pin-on-disk"'),
        ["run.toml", "contact.kind", "'pin-on-disk'", "expected 'pin-on-disc'"],
    ),
    "id that is no file name": (key("id", '"a/b"'), ["run.toml", "id", "'a/b'", "letters"]),
    # quantities
    "bare number": (
        key("radius", "0.794"),
        ["run.toml", "contact.pin.radius", "number 0.794 without a unit", "'0.794 mm'"],
    ),
    "decimal comma": (key("radius", '"0,794 mm"'), ["run.toml", "contact.pin.radius", "'0,794 mm'", "point"]),
    "NaN": (key("poisson_ratio", "nan"), ["run.toml", "contact.pin.poisson_ratio", "nan", "finite"]),
    "infinite hardness": (key("vickers_hardness", "inf"), ["run.toml", "contact.pin.vickers_hardness", "finite"]),
    "NaN in a text": (key("radius", '"nan mm"'), ["run.toml", "contact.pin.radius", "'nan mm'", "'0.794 mm'"]),
    "too large for a number": (
        key("radius", '"1e99999999999999999999 mm"'),
        ["run.toml", "contact.pin.radius", "not finite", "'0.794 mm'"],
    ),
    "uncertainty without end": (
        key("radius", '{ value = "0.794 mm", standard_uncertainty = "1e999 %" }'),
        ["run.toml", "contact.pin.radius", "finite"],
    ),
    "load of zero": (
        key("normal_load", '"0 mN"'),
        ["run.toml", "conditions.normal_load", "'0 mN'", "a positive value"],
    ),
    "negative load": (
        key("normal_load", '"-400 mN"'),
        ["run.toml", "conditions.normal_load", "'-400 mN'", "a positive value", "sign"],
    ),
    "density in kg/m³ as in the paper's Table 1": (
        key("density", '"3.21 kg/m^3"'),
        ["contact.pin.density", "3.21 kg/m³", "expected the density of a solid", "3.21 g/cm³"],
    ),
    "scar wider than the pin": (
        key("pin_scar_diameter", '"1.6 mm"'),
        ["run.toml", "end_values.pin_scar_diameter", "1600 µm", "1588 µm", "check the units of both values"],
    ),
    "wear deeper than the pin's radius": (
        key("pin_scar_diameter", '"200 um"\npin_wear_depth = "0.8 mm"'),
        ["run.toml", "end_values.pin_wear_depth", "800 µm", "794.0 ± 1.6 µm", "check the units of both values"],
    ),
    "depth below zero": (
        key("pin_scar_diameter", '"200 um"\npin_wear_depth = "-1 um"'),
        ["run.toml", "end_values", "pin_wear_depth", "-1 µm", "zero or more"],
    ),
    "mass without a unit": (
        key("pin_scar_diameter", '"200 um"\npin_mass_loss = 3'),
        ["run.toml", "end_values.pin_mass_loss", "number 3 without a unit", "'1.2 mg'"],
    ),
    "one reading as several": (
        key("pin_scar_diameter", '{ values = ["200 um"] }'),
        ["run.toml", "end_values.pin_scar_diameter", "at least 2 readings"],
    ),
    "scar on a flat pin": (key("shape", '"flat"'), ["run.toml", "end_values.pin_scar_diameter", "flat pin"]),
    "more volume than the tip": (
        key("pin_scar_diameter", '"200 um"\npin_wear_volume = "2 mm^3"'),
        ["end_values.pin_wear_volume", "2 mm³", "1.048 mm³", "check the units of both values"],
    ),
    "wear below zero": (
        key("pin_scar_diameter", '"200 um"\npin_wear_depth = "-1 um"'),
        ["run.toml", "end_values", "pin_wear_depth", "-1 µm", "zero or more"],
    ),
}


@pytest.mark.parametrize("command", others_slow(["ingest", "process"], "process"))
@pytest.mark.parametrize("case", SPOILED)
def test_spoiled_run_is_refused_in_one_sentence(run_cli, sample_run, archive, case, command):
    spoil, words = SPOILED[case]
    spoil(sample_run)
    before = tree_bytes(archive)
    assert_refused(run_cli(command, sample_run, "--archive", archive), *words)
    assert tree_bytes(archive) == before


@pytest.mark.parametrize("command", ["ingest", "process", "check"])
def test_missing_run_folder_is_named(run_cli, archive, tmp_path, command):
    before = tree_bytes(archive)
    options = () if command == "check" else ("--archive", archive)
    assert_refused(run_cli(command, tmp_path / "nowhere", *options), "nowhere", "run.toml", "no such file", "check")
    assert tree_bytes(archive) == before


@pytest.mark.parametrize("command", ["ingest", "process"])
def test_id_taken_by_other_content_is_refused(run_cli, other_run, archive, command):
    before = tree_bytes(archive)
    set_key(other_run, "medium", '"nitrogen"')
    result = run_cli(command, other_run, "--archive", archive, "--force")
    assert_refused(result, "si3n4-air-200mN.h5", "different content", "or another ID", "--amend")
    assert tree_bytes(archive) == before


@pytest.mark.slow
def test_million_columns_are_refused_at_once(run_cli, sample_run, archive):
    names = ",".join(f"c{number}" for number in range(1_000_000))
    row = ",".join(["1"] * 1_000_000)
    (sample_run / "signals.csv").write_text(f"{names}\n{row}\n{row}\n", encoding="ascii")
    before = tree_bytes(archive)
    with ends_soon():
        assert_refused(run_cli("ingest", sample_run, "--archive", archive), "signals.csv", "1000 columns")
    assert tree_bytes(archive) == before


@pytest.mark.slow
@pytest.mark.parametrize(
    "command", others_slow([["ingest"], ["process", "--no-figures"]]), ids=lambda command: command[0]
)
@pytest.mark.parametrize("name", ["bad-run", "si3n4-air-200mN"])
def test_batch_keeps_what_is_sound_and_names_what_is_not(run_cli, sample_run, other_run, tmp_path, command, name):
    bad = sample_run.rename(tmp_path / name)  # which may be the id of the other one
    field(7, 1, "8.0.1")(bad)
    result = run_cli(*command, bad, other_run, "--archive", tmp_path / "new")
    assert result.exit_code == 3
    (error,) = [line for line in result.stderr.splitlines() if line.startswith("error: ")]
    assert str(bad) in error
    assert list(tree_bytes(tmp_path / "new")) == ["history.jsonl", "si3n4-air-200mN.h5"]


# --- archives ---


@pytest.mark.parametrize("command", ["ingest", "process"])
@pytest.mark.parametrize("below", ["", "deeper"])
def test_archive_that_cannot_be_written_is_named(run_cli, sample_run, tmp_path, command, below):
    taken = tmp_path / "taken"
    taken.write_bytes(b"a file, no folder")
    result = run_cli(command, sample_run, "--archive", taken / below)
    assert_refused(result, "taken", "cannot be written", "--archive")
    assert taken.read_bytes() == b"a file, no folder"


@pytest.mark.parametrize("command", ["ls", "show si3n4-air-200mN", "fit", "correct-drift", "predict"])
def test_archive_that_is_not_there_is_named(run_cli, tmp_path, command):
    result = run_cli(*command.split(), "--archive", tmp_path / "nowhere")
    assert_refused(result, "nowhere", "no archive", "tribopipe ingest", "--archive")
    assert not (tmp_path / "nowhere").exists()


def not_hdf5(path):
    path.write_bytes(b"no HDF5 at all")


def cut_short(path):
    path.write_bytes(path.read_bytes()[:2000])


def no_run(path):
    with h5py.File(path, "w") as file:
        file["entry/data"] = [1.0, 2.0]


def hollow(path):
    with edited(path) as file:
        del file["entry/manifest"]
        del file["entry/raw"]


def rotten(path):
    """Change bytes in the middle of the compressed samples of depth."""
    with h5py.File(path, "r") as file:
        chunk = file["entry/raw/depth"].id.get_chunk_info(0)
    content = bytearray(path.read_bytes())
    middle = chunk.byte_offset + chunk.size // 2
    content[middle : middle + 8] = b"\xff" * 8
    path.write_bytes(content)


SHALLOW = {
    not_hdf5: ("not HDF5", "move it out of the archive"),
    cut_short: ("length differs", "restore it from a backup"),
    no_run: ("not a tribopipe run", "move it out of the archive"),
}


@pytest.mark.parametrize("damage", SHALLOW, ids=lambda damage: damage.__name__)
@pytest.mark.parametrize("command", ["ls", "show si3n4-air-200mN", "fit", "correct-drift", "ingest other-run"])
def test_file_that_is_no_archived_run_is_named(run_cli, other_run, archive, damage, command):
    damage(archive / "si3n4-air-200mN.h5")
    before = tree_bytes(archive)
    result = run_cli(*command.split(), "--archive", archive, cwd=other_run.parent)
    assert_refused(result, "si3n4-air-200mN.h5", *SHALLOW[damage], "expected")
    assert tree_bytes(archive) == before


@pytest.mark.parametrize(
    ("damage", "command"),
    [
        (hollow, "show si3n4-air-200mN"),
        (hollow, "correct-drift --force"),
        (rotten, "show si3n4-air-200mN --path /entry/raw/depth"),
        (rotten, "correct-drift --force"),
    ],
)
def test_archived_run_with_damage_inside_is_named(run_cli, archive, damage, command):
    damage(archive / "si3n4-air-200mN.h5")
    before = tree_bytes(archive)
    result = run_cli(*command.split(), "--archive", archive)
    assert_refused(result, "si3n4-air-200mN.h5", "damaged", "expected", "restore")
    assert tree_bytes(archive) == before


@pytest.mark.parametrize("command", ["ls", "fit", "correct-drift"])
def test_damaged_file_does_not_stop_the_other_runs(run_cli, archive, command):
    not_hdf5(archive / "broken.h5")
    result = run_cli(command, "--archive", archive)
    assert result.exit_code == 3
    assert [line for line in result.stderr.splitlines() if line.startswith("error: ") and "broken.h5" in line]
    assert "si3n4-air-200mN" in result.output


@pytest.mark.slow
def test_new_run_is_archived_and_fitted_beside_a_damaged_file(run_cli, sample_run, archive):
    not_hdf5(archive / "broken.h5")
    result = run_cli("process", sample_run, "--archive", archive, "--no-figures")
    assert result.exit_code in (1, 3)
    assert len([line for line in result.stderr.splitlines() if line.startswith("error: ")]) == 1
    assert "broken.h5" in result.stderr
    assert "k_D from Archard's law" in result.stdout
    assert "steps done" in result.stderr


@pytest.mark.parametrize("command", ["show", "fit", "correct-drift", "predict"])
def test_unknown_id_suggests_the_nearest(run_cli, archive, command):
    before = tree_bytes(archive)
    result = run_cli(command, "si3n4-air-200N", "--archive", archive)
    assert_refused(result, "'si3n4-air-200N'", "did you mean 'si3n4-air-200mN'?")
    assert tree_bytes(archive) == before


# --- recipes, plans, options ---


RECIPES = {
    "unknown key": ("[drift]\nwindw = 0.1", ["recipe.toml", "drift.windw", "unknown key", "did you mean 'window'?"]),
    "bare length": ("[drift]\nprior = 1", ["recipe.toml", "drift.prior", "number 1 without a unit"]),
    "share above one": ("[drift]\nwindow = 1.5", ["recipe.toml", "drift.window", "1.5", "less than 0.5"]),
    "unknown law": ('[wear]\nmodels = ["archad"]', ["recipe.toml", "wear.models[0]", "'archad'", "archard"]),
    "no TOML": ("[drift", ["recipe.toml", "invalid TOML", "Expected ']'"]),
}


@pytest.mark.parametrize("case", RECIPES)
@pytest.mark.parametrize("command", ["process", "fit"])
def test_bad_recipe_is_refused(run_cli, sample_run, archive, tmp_path, case, command):
    text, words = RECIPES[case]
    recipe = tmp_path / "recipe.toml"
    recipe.write_text(text, encoding="utf-8")
    before = tree_bytes(archive)
    paths = [sample_run] if command == "process" else []
    assert_refused(run_cli(command, *paths, "--archive", archive, "--recipe", recipe), *words)
    assert tree_bytes(archive) == before


def test_unknown_key_of_a_plan_suggests_the_nearest(run_cli, short_plan, tmp_path):
    plan = tmp_path / "plan.toml"
    plan.write_bytes(short_plan.read_bytes())
    replace_in(plan, "(?m)^seed = ", "sed = ")
    result = run_cli("simulate", tmp_path / "runs", "--plan", plan)
    assert_refused(result, "plan.toml", "series[0].runs[0].sed", "unknown key", "did you mean 'seed'?")
    assert not (tmp_path / "runs").exists()


@pytest.mark.parametrize(
    "command", [["simulate", "taken/runs", "--plan", "plan.toml"], ["schema", "export", "taken/s"]]
)
def test_folder_that_cannot_be_made_is_named(run_cli, short_plan, tmp_path, command):
    (tmp_path / "taken").write_bytes(b"")
    (tmp_path / "plan.toml").write_bytes(short_plan.read_bytes())
    assert_refused(run_cli(*command, cwd=tmp_path), "taken", "cannot be")


K_D = ["--wear-coefficient", "13.5e-9 mm^3/(N*mm)"]
SARKAR = [*K_D, "--law", "sarkar", "--friction"]
OPTIONS = {
    "k_D without unit": (["--wear-coefficient", "13.5e-9"], ["--wear-coefficient", "'13.5e-9'", "mm^3/(N*mm)"]),
    "k_D in the unit of pressure": (["--wear-coefficient", "1 MPa"], ["--wear-coefficient", "'MPa'", "mm^3/(N*mm)"]),
    "k_D below zero": (["--wear-coefficient", "-1 mm^2/N"], ["--wear-coefficient", "'-1 mm^2/N'", "positive"]),
    "k_D that is text": (["--wear-coefficient", "much"], ["--wear-coefficient", "'much'", "13.5e-9 mm^3/(N*mm)"]),
    "friction in another form": ([*SARKAR, "0.4"], ["--friction", "'0.4'", "A=0.226 b=0.496 c=32.877 m"]),
    "friction with a bare distance": ([*SARKAR, "A=0.2 b=0.4 c=32"], ["--friction", "'32'", "distance", "500 m"]),
    "friction with a text": ([*SARKAR, "A=x b=0.4 c=32 m"], ["--friction", "'x'", "ratio"]),
    "friction with no running-in": ([*SARKAR, "A=0.2 b=0.4 c=0 m"], ["--friction", "c = 0 m", "positive"]),
    "distance in kg": ([*K_D, "--at", "5 kg"], ["--at", "'kg'", "distance"]),
    "distance below zero": ([*K_D, "--at", "-5 m"], ["--at", "-5", "negative"]),
    "distance without unit": ([*K_D, "--at", "500"], ["--at", "'500'", "without a unit", "500 m"]),
    "depth beyond the tip": ([*K_D, "--depth", "2 mm"], ["2000 µm", "tip", "794", "check"]),
    "distance beyond the tip": ([*K_D, "--at", "1e9 km"], ["tip", "check", "distance"]),
    "load of zero": ([*K_D, "--load", "0 N"], ["--load", "'0 N'", "positive"]),
    "speed in metres": ([*K_D, "--speed", "3 m"], ["--speed", "'m'", "speed"]),
    "radius in volts": ([*K_D, "--radius", "3 V"], ["--radius", "'V'", "length"]),
}


@pytest.mark.parametrize("case", OPTIONS)
def test_bad_option_of_predict_is_named(run_cli, sample_run, case):
    options, words = OPTIONS[case]
    assert_refused(run_cli("predict", "--run", sample_run, *options), *words)

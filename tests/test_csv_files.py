"""CSV of archived runs: the same numbers to the last digit, which ingest reads back."""

import csv
import io
import json
import shutil

import h5py
import numpy as np
import pytest
from archived_files import edited
from folders import replace_in
from hypothesis import given
from hypothesis import strategies as st

from tribopipe.archive.store import Archive
from tribopipe.base.errors import ArchiveError
from tribopipe.base.units import to_si
from tribopipe.pipeline.stages import ingest
from tribopipe.results.run import ExtraColumn, RawRun
from tribopipe.views.csv_files import CSV_KINDS, csv_kinds, csv_of, csv_parts

RUN = "si3n4-air-200mN"
HAS = ["raw", "cleaned", "corrected", "friction", "wear", "fit-archard", "fit-sarkar"]


def read(content: bytes) -> dict[str, list[str]]:
    """The columns of a CSV file as texts, by their heads."""
    head, *rows = csv.reader(io.StringIO(content.decode("utf-8"), newline=""), strict=True)
    return {name: [row[number] for row in rows] for number, name in enumerate(head)}


def csv_bytes(store: Archive, run_id: str, what: str) -> bytes:
    return b"".join(csv_parts(store, run_id, what))


def numbers(texts: list[str]) -> np.ndarray:
    return np.array([float(text) if text else np.nan for text in texts])


# --- what is written ---


@pytest.mark.slow
def test_run_has_these_tables(archive):
    store = Archive(archive)
    assert csv_kinds(store, RUN) == HAS
    assert set(HAS) <= set(CSV_KINDS)
    for what in HAS:
        assert len(read(csv_bytes(store, RUN, what))["time [s]"]) == 1251


def test_raw_and_wear_are_what_the_archive_holds(archive):
    store = Archive(archive)
    raw, told = store.raw(RUN), read(csv_bytes(store, RUN, "raw"))
    assert list(told) == [
        *("time [s]", "sliding_distance [m]", "normal_force [N]", "friction_force [N]"),
        *("friction_coefficient [1]", "depth [m]"),
    ]
    for values, texts in zip(raw.columns.values(), told.values(), strict=True):
        assert np.array_equal(values, numbers(texts))
    step = store.step(RUN, "drift_correction")
    corrected = read(csv_bytes(store, RUN, "corrected"))
    assert np.array_equal(numbers(corrected["pin_wear_depth [m]"]), step.curves["pin_wear_depth"][0])
    wear = read(csv_bytes(store, RUN, "wear"))
    assert np.allclose(to_si(numbers(wear["pin_wear_depth [um]"]), "um", "length"), step.curves["pin_wear_depth"][0])
    friction = read(csv_bytes(store, RUN, "friction"))
    fitted = store.step(RUN, "friction_fit").curves["friction_coefficient"][0]
    assert np.array_equal(numbers(friction["fitted_friction_coefficient [1]"]), fitted)
    assert np.array_equal(numbers(friction["friction_coefficient [1]"]), raw.columns["friction_coefficient"])


@given(
    st.lists(st.tuples(*[st.floats(allow_infinity=True, allow_nan=True)] * 2), min_size=1, max_size=20),
)
def test_numbers_come_back_to_the_last_digit(rows):
    columns = {f"c{number} [m]": np.array(values) for number, values in enumerate(zip(*rows, strict=True))}
    told = read(b"".join(csv_of(columns)))
    assert list(told) == list(columns)
    for name, texts in told.items():
        assert np.array_equal(numbers(texts), columns[name], equal_nan=True)
        assert np.array_equal(np.signbit(numbers(texts)), np.signbit(columns[name]) & ~np.isnan(columns[name]))


@given(st.lists(st.text(max_size=8), min_size=1, max_size=8))
def test_texts_are_never_formulas_and_else_stay(texts):
    columns = {"note": np.array(texts, dtype=object), "time [s]": np.arange(float(len(texts)))}
    told = read(b"".join(csv_of(columns)).replace(b"\x00", b"\\x00"))["note"]
    for text, field in zip(texts, told, strict=True):
        assert field.removeprefix("'") == text.replace("\x00", "\\x00").removeprefix("'")


@pytest.mark.parametrize("text", ["=1+1", "+A1", "-A1", "@SUM(A1)", "\t=1", "\r=1", '=HYPERLINK("http://x")'])
def test_formulas_are_made_harmless(text):
    columns = {text: np.array([text], dtype=object)}
    assert read(b"".join(csv_of(columns))) == {f"'{text}": [f"'{text}"]}


@pytest.mark.parametrize("text", ["-1.5", "+3", "-inf", "plain", "", "a=b", "1 µm, 'x'", 'say "so"', "two\r\nlines"])
def test_other_texts_stay_as_they_are(text):
    columns = {"note": np.array([text], dtype=object), "n": np.array([1.0])}
    assert read(b"".join(csv_of(columns)))["note"] == [text]


def test_rows_are_many_parts_of_one_file(monkeypatch):
    monkeypatch.setattr("tribopipe.views.csv_files._ROWS", 3)
    columns = {"a [m]": np.arange(8.0), "b [m]": -np.arange(8.0)}
    parts = list(csv_of(columns))
    assert len(parts) == 4
    assert b"".join(parts).count(b"\r\n") == 9
    assert numbers(read(b"".join(parts))["a [m]"]).tolist() == list(range(8))


def test_columns_without_a_meaning_are_written_too(bare_run, tmp_path):
    extras = {
        "Note": ExtraColumn(np.array(["=cmd", "fine"], dtype=object)),
        "P [bar]": ExtraColumn(np.array([1.0, np.nan]), "bar"),
        "Q": ExtraColumn(np.array([1.5, 2.5]), "mm"),
    }
    columns = {"time": np.array([0.0, 1.0]), "sliding_distance": np.array([0.0, 0.4])}
    run = RawRun(bare_run.manifest, columns, dict.fromkeys(columns, "measured"), extras, {}, ())
    store = Archive(tmp_path / "a")
    store.add(run)
    assert csv_kinds(store, "bare") == ["raw", "other-columns"]
    told = read(csv_bytes(store, "bare", "other-columns"))
    assert told == {"Note": ["'=cmd", "fine"], "P [bar]": ["1.0", ""], "Q [mm]": ["1.5", "2.5"]}


@pytest.mark.parametrize("what", ["prediction-archard", "local-wear-sarkar", "nonsense", "../raw", ""])
def test_what_a_run_lacks_is_one_sentence(archive, what):
    with pytest.raises(ArchiveError, match=f"{RUN}: found no table .*; expected one of: raw, cleaned, "):
        csv_parts(Archive(archive), RUN, what)


@pytest.mark.parametrize("how", ["link", "virtual"])
def test_nothing_of_another_file_iscsv_of(archive, tmp_path, how):
    with h5py.File(tmp_path / "other.h5", "w") as other:
        other["secret"] = np.arange(1251.0)
    with edited(archive / f"{RUN}.h5") as file:
        raw = file["entry/raw"]
        attributes = dict(raw["depth"].attrs)
        del raw["depth"]
        if how == "link":
            raw["depth"] = h5py.ExternalLink(str(tmp_path / "other.h5"), "/secret")
        else:
            layout = h5py.VirtualLayout(shape=(1251,), dtype="f8")
            layout[:] = h5py.VirtualSource(str(tmp_path / "other.h5"), "secret", shape=(1251,))
            raw.create_virtual_dataset("depth", layout).attrs.update(attributes)
    with pytest.raises(ArchiveError, match=r"found a (link to another file|virtual dataset) at /entry/raw/depth"):
        csv_bytes(Archive(archive), RUN, "raw")


# --- and read back ---


@pytest.mark.slow
@pytest.mark.parametrize("run_id", [RUN, "si3n4-twin-disc-4pct-100k"])
def test_raw_columns_give_the_same_run_again(short_runs, tmp_path, run_id):
    from folders import SAMPLES

    source = (short_runs if run_id == RUN else SAMPLES) / run_id
    first, second = Archive(tmp_path / "first"), Archive(tmp_path / "second")
    assert ingest(source, first).error is None
    folder = tmp_path / "again"
    folder.mkdir()
    shutil.copy(source / "run.toml", folder)
    replace_in(folder / "run.toml", r"(?s)\[signals\.columns\].*?(?=\n\[)", "")
    (folder / "signals.csv").write_bytes(csv_bytes(first, run_id, "raw"))
    outcome = ingest(folder, second)
    assert (outcome.error, outcome.findings) == (None, ())
    before, after = first.raw(run_id), second.raw(run_id)
    assert list(before.columns) == list(after.columns)
    for name, values in before.columns.items():
        assert np.array_equal(values, after.columns[name], equal_nan=True), name


# --- the command ---


def test_command_writes_what_a_run_has(run_cli, archive, tmp_path):
    told = run_cli("export", "csv", RUN, "--archive", archive, "-o", tmp_path / "out", "--json")
    assert told.exit_code == 0
    files = {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()}
    assert files == {f"{RUN}-{what}.csv": csv_bytes(Archive(archive), RUN, what) for what in HAS}
    assert [one["what"] for one in json.loads(told.stdout)["files"]] == HAS


def test_command_replaces_nothing_unless_forced(run_cli, archive, tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    (out / f"{RUN}-wear.csv").write_text("mine", encoding="utf-8")
    command = ["export", "csv", RUN, "--archive", archive, "-o", out, "--what", "raw, wear"]
    refused = run_cli(*command)
    assert refused.exit_code == 1
    assert "found an existing file" in refused.stderr
    assert [path.name for path in out.iterdir()] == [f"{RUN}-wear.csv"]
    assert run_cli(*command, "--force").exit_code == 0
    assert (out / f"{RUN}-wear.csv").read_bytes() == csv_bytes(Archive(archive), RUN, "wear")


def test_command_goes_on_where_a_table_or_a_run_is_not_there(run_cli, archive, tmp_path):
    out = tmp_path / "out"
    told = run_cli("export", "csv", RUN, "nobody", "--archive", archive, "-o", out, "--what", "fit,local-wear")
    assert told.exit_code == 3
    assert sorted(path.name for path in out.iterdir()) == [f"{RUN}-fit-archard.csv", f"{RUN}-fit-sarkar.csv"]
    lines = [line for line in told.stderr.splitlines() if line.startswith("error: ")]
    assert len(lines) == 2
    assert "found no table 'local-wear-archard'; expected one of: raw, " in lines[0]
    assert "found no run 'nobody'" in lines[1]
    assert run_cli("export", "csv", "nobody", "--archive", archive, "-o", out).exit_code == 1


def test_damaged_run_stops_no_other(run_cli, archive, sample_run, tmp_path):
    store = Archive(archive)
    other = ingest(sample_run, store).run_id
    with h5py.File(store.path(RUN)) as file:
        chunk = file["entry/raw/depth"].id.get_chunk_info(0)
    content = bytearray(store.path(RUN).read_bytes())
    middle = chunk.byte_offset + chunk.size // 2
    content[middle : middle + 8] = b"\xff" * 8
    store.path(RUN).write_bytes(content)
    told = run_cli("export", "csv", RUN, other, "--what", "raw", "--archive", archive, "-o", tmp_path / "out")
    assert told.exit_code == 3
    assert [path.name for path in (tmp_path / "out").iterdir()] == [f"{other}-raw.csv"]
    (line,) = [line for line in told.stderr.splitlines() if line.startswith("error: ")]
    assert f"{RUN}.h5: found a damaged file" in line


def test_unknown_table_is_a_usage_error(run_cli, archive):
    told = run_cli("export", "csv", RUN, "--archive", archive, "--what", "weer")
    assert told.exit_code == 2
    assert "did you mean 'wear'?" in told.stderr

"""Run folders made to hang, fill or fool a computer: refused in one sentence, at once, the archive as it was."""

import os
import re
import socket
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from built_files import Xml, ods, tdms, xlsx
from folders import replace_in, set_key, tree_bytes
from hanging import ends_soon
from reader_examples import EXAMPLES
from small_exports import UMT, read

from tribopipe.archive.store import Archive
from tribopipe.base.errors import ManifestError, ReaderError, TribopipeError
from tribopipe.base.files import found_below
from tribopipe.base.units import parse
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.plan import Plan
from tribopipe.documents.reader_profile import ReaderProfile
from tribopipe.documents.record import load_toml, read_document
from tribopipe.documents.toml import parse_toml
from tribopipe.pipeline.stages import find_runs, ingest
from tribopipe.readers import profiles
from tribopipe.readers.delimited import DelimitedReader
from tribopipe.readers.formats.umt import UmtReader
from tribopipe.readers.reader import readers
from tribopipe.readers.toml_reader import DescribedReader
from tribopipe.results.run import SourceFile


@pytest.fixture
def refusal(sample_run, archive):
    """Give a function that says how the run is refused, and checks that nothing else happened."""

    def refused() -> str:
        before = tree_bytes(archive)
        with ends_soon(), pytest.raises(TribopipeError) as caught:
            ingest(sample_run, Archive(archive))
        assert tree_bytes(archive) == before
        assert str(caught.value).isprintable()
        return str(caught.value)

    return refused


# --- what a run folder leads to ---


def linked(path: Path, target: Path | str) -> None:
    try:
        path.symlink_to(target)
    except OSError:
        pytest.skip("this system makes no links for us")


@pytest.mark.parametrize("name", ["signals.csv", "run.toml"])
@pytest.mark.parametrize("target", ["beside", "absolute", "nowhere"])
def test_a_link_out_of_the_run_folder_is_refused(sample_run, tmp_path, refusal, name, target):
    outside = (sample_run / name).rename(tmp_path / f"outside-{name}")
    linked(sample_run / name, {"beside": f"../{outside.name}", "absolute": outside, "nowhere": "/no/such"}[target])
    said = refusal()
    assert name in said
    assert "a link to a file outside the run folder" in said
    assert "replace the link" in said


def test_a_link_to_a_folder_outside_is_refused(sample_run, other_run, refusal):
    linked(sample_run / "data", other_run)
    set_key(sample_run, "file", '"data/signals.csv"')
    assert "a link to a file outside the run folder" in refusal()


def test_links_inside_the_run_folder_and_to_it_are_followed(sample_run, tmp_path):
    (sample_run / "signals.csv").rename(sample_run / "raw.csv")
    linked(sample_run / "signals.csv", "raw.csv")
    linked(tmp_path / "alias", sample_run)
    outcome = ingest(tmp_path / "alias", Archive(tmp_path / "new"))
    assert outcome.status == "done"


def test_a_link_to_itself_is_refused(sample_run, refusal):
    (sample_run / "signals.csv").unlink()
    linked(sample_run / "signals.csv", "signals.csv")
    assert "signals.csv" in refusal()


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such files in folders")
@pytest.mark.parametrize("name", ["signals.csv", "run.toml"])
def test_a_pipe_is_refused_and_not_waited_for(sample_run, refusal, name):
    (sample_run / name).unlink()
    os.mkfifo(sample_run / name)
    assert "a pipe or a device" in refusal()


@pytest.mark.skipif(not hasattr(socket, "AF_UNIX"), reason="no sockets in folders here")
def test_a_socket_is_refused(sample_run, refusal, monkeypatch):
    (sample_run / "signals.csv").unlink()
    monkeypatch.chdir(sample_run)  # since names of sockets are short
    with socket.socket(socket.AF_UNIX) as made:
        made.bind("signals.csv")
        assert "a pipe or a device" in refusal()


@pytest.mark.parametrize(
    "named", ["'../rig.toml'", "'/etc/rig.toml'", r"'C:\rig.toml'", r"'\\host\rig.toml'", r'"a\u0007.toml"']
)
def test_a_described_reader_lies_in_the_run_folder(sample_run, refusal, named):
    set_key(sample_run, "file", f"'signals.csv'\nreader = {named}")
    said = refusal()
    assert "signals[0].reader" in said
    assert "in the run folder" in said


def test_a_file_is_read_once(sample_run, refusal):
    replace_in(sample_run / "run.toml", r'(?m)^file = "(.*)"$', 'files = ["signals.csv", "signals.csv"]')
    assert "found the file 'signals.csv' twice" in refusal()


def test_a_profile_named_many_times_is_read_once(sample_run, tmp_path, monkeypatch):
    heights = (f"{0.001 * n:.3f} {n % 3} {n % 4}\n" for n in range(40))
    (sample_run / "track.txt").write_text("x [mm] a [um] b [um]\n" + "".join(heights), encoding="utf-8")
    read_often: list[str] = []
    reader_for = profiles._reader_for
    monkeypatch.setattr(profiles, "_reader_for", lambda *asked: read_often.append(asked[2]) or reader_for(*asked))
    named = [f'{{ file = "track.txt", position = "x", height = "{column}" }}' for column in ("a", "b")]
    replace_in(sample_run / "run.toml", r"(?m)^\[end_values\]$", f"[end_values]\ndisc_profile = [{', '.join(named)}]")
    ingest(sample_run, Archive(tmp_path / "new"))
    assert read_often == ["end_values.disc_profile[0]"]


def test_the_same_profile_is_no_second_measurement(sample_run, refusal):
    named = '{ file = "track.txt" }'
    replace_in(sample_run / "run.toml", r"(?m)^\[end_values\]$", f"[end_values]\ndisc_profile = [{named}, {named}]")
    assert "disc_profile: found the same profile of 'track.txt' twice" in refusal()


def test_folders_in_folders_in_folders(tmp_path):
    path = tmp_path
    for _ in range(400):
        path = path / "d"
        path.mkdir()
    (path / "run.toml").touch()
    assert found_below(tmp_path, "run.toml") == [path / "run.toml"]
    assert find_runs(tmp_path) == [path]


# --- documents ---


def absurd(text: str) -> str:
    """Say how a document of a run is refused."""
    with ends_soon(), pytest.raises(ManifestError) as caught:
        read_document(parse_toml(Path("run.toml"), text.encode()), RunManifest, where="run.toml")
    return str(caught.value)


DOCUMENTS = {
    "key of 400 000 parts": ("a" + ".a" * 400_000 + " = 1", "more than 20 parts"),
    "key of quoted parts": ('a."b"' + ".'c'" * 10_000 + " = 1", "line 1: found a key of more than 20 parts"),
    "key of parts with blanks": ("\n[a" + " . a" * 1000 + "]", "line 2: found a key of more than 20 parts"),
    "tables 50 deep": ("a = " + "{ a = " * 50 + "1" + " }" * 50, "a: found more than 20 nesting levels"),
    "lists 10 000 deep": ("a = " + "[" * 10_000 + "]" * 10_000, "nested too deeply"),
    "more values than any record has": ("interruptions = [" + "0," * 110_000 + "]", "more than 100,000 values"),
    "hexadecimal number of a megabyte": ("schema = 0x" + "F" * 1_000_000, "schema: found an integer"),
    "number of 4000 digits": (
        "[conditions]\nrotations = " + "9" * 4000,
        "conditions.rotations: found an integer of",
    ),
    "number of 5000 digits": ("schema = " + "9" * 5000, "thousands of digits"),
}


@pytest.mark.parametrize("case", DOCUMENTS)
def test_an_absurd_document_is_refused_at_once(case):
    text, words = DOCUMENTS[case]
    assert words in absurd(text)


def test_a_zero_byte_in_a_text_is_refused(sample_run, refusal):
    set_key(sample_run, "medium", r'"air\u0000"')
    assert "conditions.medium: found a null character" in refusal()


def test_a_name_too_long_for_any_file_is_refused(sample_run, refusal):
    set_key(sample_run, "file", '"' + "x" * 5000 + '"')
    assert "cannot be read" in refusal()


def test_dots_that_are_no_keys_are_left_alone():
    text = 'comment = "see a.b.c.d.e.f.g.h.i.j.k.l.m"\nnumbers = [' + "0.5, " * 500 + "]\n# z. B. u. a.\n"
    assert len(parse_toml(Path("x.toml"), text.encode())["numbers"]) == 500


def test_a_document_of_gigabytes_is_not_read(sample_run, refusal):
    with (sample_run / "run.toml").open("ab") as file:
        file.truncate(1 << 32)
    said = refusal()
    assert "found 4,294,967,296 bytes" in said
    assert "since documents are written by hand" in said


@pytest.mark.parametrize(
    "written",
    ["1e300 mN", "1e-60 N", "{ value = 1e300, unit = 'N' }", "{ value = '1 N', standard_uncertainty = '1e60 N' }"],
)
def test_what_nobody_can_have_measured_is_refused(sample_run, refusal, written):
    set_key(sample_run, "normal_load", written if written.startswith("{") else f'"{written}"')
    said = refusal()
    assert "conditions.normal_load" in said
    assert "which is not physically possible" in said


def test_a_unit_behind_a_megabyte_of_blanks():
    with ends_soon():
        with pytest.raises(TribopipeError):
            parse("1" + " " * 1_000_000 + "x", "length")
        assert parse("1 mm" + " " * 1_000_000, "length") == 1e-3


def test_what_a_sentence_quotes_is_cut_and_written_out():
    said = str(ManifestError("found " + "x" * 1_000_000 + "\n\x1b[31m; expected less; correct it"))
    assert len(said) < 1500
    assert said.startswith("found xxx")
    assert said.endswith("\\n\\x1b[31m; expected less; correct it")


def test_plans_without_end_are_refused(short_plan, tmp_path):
    plan = tmp_path / "plan.toml"
    plan.write_bytes(short_plan.read_bytes())
    replace_in(plan, "(?m)^sliding_distance = .*$", 'sliding_distance = "1e12 m"')
    with pytest.raises(ManifestError, match=r"sensors.sampling_rate: found 2.5e\+13 samples per run; expected at most"):
        load_toml(plan, Plan)


# --- readers that are described ---

RIG = {"schema": "tribopipe.reader/1", "name": "rig", "title": "Rig", "columns": {"t": {"signal": "time", "unit": "s"}}}


@pytest.mark.parametrize("pattern", ["a{99999999999}", "(" * 400, "[[a]", "(?P<a>", "a" * 501, "x**"])
def test_patterns_that_cannot_be_are_refused(pattern):
    with pytest.raises(ManifestError, match="rig: detect: "):
        read_document({**RIG, "detect": pattern}, ReaderProfile, where="rig")


@pytest.mark.slow
def test_a_pattern_that_never_ends_is_ended(monkeypatch):
    monkeypatch.setattr("tribopipe.readers.subprocess_readers._LEAST_SECONDS_OF_WORK", 1)
    profile = read_document(
        {**RIG, "detect": "^(a+)+$", "starts_at": "^(t+)+$", "separator": ";"}, ReaderProfile, where="rig"
    )
    content = b"t;w\n" + b"a" * 60 + b"b\n1;2\n"
    with ends_soon():
        match = DescribedReader(profile).match(SourceFile("x.csv", content))
    assert match.confidence == 0
    assert "found the pattern '^(a+)+$', which takes too long to match" in match.why


def test_a_date_written_twice_is_refused():
    fact = {"pattern": "Date: (.*)", "date": "%Y %Y"}
    described = {**RIG, "separator": ";", "starts_at": "^t;", "facts": {"started": fact}}
    profile = read_document(described, ReaderProfile, where="rig")
    with pytest.raises(ReaderError, match="expected a date in the form '%Y %Y'"):
        read(DescribedReader(profile), b"Date: 2024 2024\nt;w\n1;2\n2;3\n")


# --- signal files ---

LONG = 120_000


def match_and_read(reader, content: bytes) -> None:
    with ends_soon(), suppress(ReaderError):
        reader.match(SourceFile("x.csv", content))
        read(reader, content)


@pytest.mark.slow
@pytest.mark.parametrize("token", [b" ", b"[", b"(a", b"1\t", b","])
def test_a_line_that_repeats_one_sign_is_judged_at_once(token):
    line = token * (LONG // len(token))
    match_and_read(DelimitedReader(), b"Time [s];Dep" + line + b"th [um]\n0,5;1\n1,0;2\n")
    match_and_read(UmtReader(), UMT.replace(b"Created", line + b"Created", 1))
    match_and_read(UmtReader(), UMT.replace(b"Step No", b"Radius" + line + b"\nStep No", 1))


def test_the_load_is_looked_for_among_forces_beyond_all_use():
    """With warnings as errors: the mean of the two in the middle would overflow."""
    (example, *_) = EXAMPLES["bruker-umt"]
    content = re.sub(rb",-19[89]\.963455,", b",1e308,", example.content)
    assert content.count(b"1e308") == 4
    match_and_read(UmtReader(), content)


def test_a_thousand_columns_of_one_name():
    header, row = ",".join(["a"] * 1000), ",".join(["1.5"] * 1000)
    with ends_soon():
        table = read(DelimitedReader(), f"{header}\n{row}\n{row}\n".encode())
    assert [column.name for column in table.columns][::333] == ["a", "a (334)", "a (667)", "a (1000)"]


@pytest.mark.slow
def test_a_row_of_a_hundred_thousand_fields(sample_run, refusal):
    (example,) = EXAMPLES["anton-paar"]
    first = example.content.index(b"Time [s]\t")
    content = example.content[:first] + b"\t" * 100_000 + example.content[first:]
    match_and_read(readers()["anton-paar"], content)
    (sample_run / "signals.csv").write_bytes(content)
    assert "signals.csv" in refusal()


@pytest.mark.parametrize("written", ["1e308", "-1e200"])
def test_a_number_that_no_instrument_gives_is_refused(sample_run, refusal, written):
    replace_in(sample_run / "signals.csv", r"(?m)^0\.2,[^,]*,", f"0.2,{written},")
    said = refusal()
    assert "Depth [um]" in said
    assert "in row" in said
    assert "expected a value that an instrument can record for depth" in said


def test_segments_of_numbers_and_texts_are_texts():
    (example,) = EXAMPLES["labview-lvm"]
    content = example.content.replace(b"0.500000\t13.257429\t165.995293", b"0.500000\t13.257429\t8.0.1", 1)
    dx = read(readers()["labview-lvm"], content).columns[2]
    assert dx.first_bad is not None
    assert {type(value) for value in dx.values} == {str}


@pytest.mark.parametrize("encoding", ["unicode_escape", "idna", "punycode", "zlib", "undefined"])
def test_encodings_that_are_no_charsets_are_unknown(encoding):
    with pytest.raises(ReaderError, match=f"the unknown encoding '{encoding}'"):
        read(DelimitedReader(), b"Time [s];\\q\n1;2\n2;3\n", encoding=encoding)


def test_zero_bytes_that_pad_texts_of_tdms_are_left_out():
    values = np.arange(3.0)
    channels = {"Time\0": (values, {"unit_string": "s\0\0"}), "Fz": (["a\0", "b", "c"], {"note\0": "x\0"})}
    table = read(readers()["ni-tdms"], tdms({"T\0": channels}, author="N. N.\0"))
    assert [(column.name, column.unit) for column in table.columns] == [("Time", "s"), ("Fz", None)]
    assert table.columns[1].values.tolist() == ["a", "b", "c"]
    assert table.facts["operator"] == "N. N."
    assert "\0" not in table.header


@pytest.mark.parametrize(
    ("name", "count"),
    [
        ("kyowa-pcd", '"集録データ数/CH",3'.encode("shift_jis")),
        ("labview-lvm", b"Samples\t2"),
        ("bruker-umt", b"Total number of steps = 2"),
    ],
)
def test_a_number_of_samples_of_thousands_of_digits_is_none(name, count):
    (example,) = EXAMPLES[name]
    for digits in ("9" * 5000, str(2**60)):
        content = example.content.replace(count, count[:-1] + digits.encode(), 1)
        assert len(read(readers()[name], content).columns[0].values) == example.rows


FAR_AWAY = Xml('<c r="XFD1048576"><v>1</v></c>')
A_BILLION = Xml(
    '<table:table-cell table:number-columns-repeated="1000000000" office:value-type="float" office:value="1"/>'
)


@pytest.mark.slow
@pytest.mark.parametrize("bomb", [xlsx({"D": [["t", "w"], [FAR_AWAY]]}), ods({"D": [["t", "w"], [A_BILLION]]})])
def test_a_small_workbook_that_declares_billions_of_cells(bomb):
    with ends_soon(), pytest.raises(ReaderError):
        read(readers()["workbook"], bomb)

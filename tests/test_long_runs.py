"""Runs longer than memory should hold: read block by block as they are read whole, and means of them that are means."""

import math
import pickle
import re
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tribopipe.archive.provenance import raw_digest
from tribopipe.archive.store import Archive
from tribopipe.base.errors import ArchiveError, ReaderError
from tribopipe.evaluation.checks.registry import check_run
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.friction import fit_friction
from tribopipe.evaluation.preprocessing.cleaning import clean_run
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.pipeline.reproduce import reproduce
from tribopipe.pipeline.stages import ingest, process
from tribopipe.pipeline.verify.archive import verify
from tribopipe.readers import long_runs as means
from tribopipe.readers import long_text
from tribopipe.readers.delimited import DelimitedReader
from tribopipe.readers.draft.folder import Wanted, make_run
from tribopipe.readers.export_files import read_export
from tribopipe.readers.harmonize import read_run
from tribopipe.readers.long_runs import Means, samples_in_a_mean
from tribopipe.readers.long_text import OtherWords
from tribopipe.readers.reader import Hints, ReadTable
from tribopipe.results.run import RawRun, SourceFile
from tribopipe.results.wear_fit import WearFit

RUN = "si3n4-air-200mN"


@pytest.fixture
def _long(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have every file read block by block."""
    monkeypatch.setattr(long_text, "LARGE", 0)
    monkeypatch.setattr(long_text, "PIECE", 6000)
    monkeypatch.setattr(long_text, "TAIL", 300)


@pytest.fixture
def _by_means(_long, monkeypatch: pytest.MonkeyPatch) -> None:
    """Have a run of 1251 samples evaluated by means of 5."""
    monkeypatch.setattr(means, "MOST", 251)


# --- block by block ---


def by_blocks(path: Path, content: bytes, piece: int, hints: Hints) -> list[ReadTable] | None:
    """Read a file block by block; none where it has to be read whole."""
    path.write_bytes(content)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(long_text, "PIECE", piece)
        patch.setattr(long_text, "TAIL", 60)
        text = long_text.long_text(path, path.name, hints)
        words: long_text.Words = {}
        while text is not None:
            try:
                return list(text.tables(words))
            except OtherWords as other:
                words = other.found
    return None


def told(table: ReadTable) -> dict[str, list[object]]:
    return {one.name: [one.unit, one.first_bad, *map(repr, one.values.tolist())] for one in table.columns}


def joined(tables: list[ReadTable]) -> dict[str, list[object]]:
    whole = told(tables[0])
    for table in tables[1:]:
        for name, (_, _, *values) in told(table).items():
            whole[name] += values
    return whole


ENDS = ["\n", "\r\n", "\r\n\r\n", "\n \n", "\r"]
FIELDS = ["1{d}5", "-2{d}25e-3", "17", "", "0{d}001"]


@st.composite
def tables(draw: st.DrawFn) -> bytes:
    """Tables in many dialects, with missing values, columns without a name, and words in odd places."""
    separator = draw(st.sampled_from([",", ";", "\t"]))
    decimal = "." if separator == "," else draw(st.sampled_from(".,"))
    names = [
        "Time [s]",
        draw(st.sampled_from(["Höhe [µm]", "Depth [um]", '"Depth"'])),
        draw(st.sampled_from(["Ff", ""])),
    ]
    rows = draw(st.lists(st.lists(st.sampled_from(FIELDS), min_size=2, max_size=2), min_size=1, max_size=40))
    body = [[f"{n}.5".replace(".", decimal), *(cell.format(d=decimal) for cell in row)] for n, row in enumerate(rows)]
    for place in draw(st.lists(st.integers(0, len(body) - 1), max_size=2)):
        body[place][2] = draw(st.sampled_from(["stop", '"so it is"', "", "inf"]))
    ends = draw(st.lists(st.sampled_from(ENDS), min_size=1, max_size=3))
    lines = [separator.join(row) for row in [names, *body]]
    text = "".join(line + ends[n % len(ends)] for n, line in enumerate(lines))
    closing = draw(st.sampled_from(["", "End of the test\n"]))
    return (draw(st.sampled_from(["", "Operator: Bob\n\n"])) + text + closing).encode(
        draw(st.sampled_from(["utf-8", "utf-8-sig", "cp1252"]))
    )


@settings(max_examples=25, deadline=None)
@given(tables(), st.integers(30, 400))
def test_a_file_read_block_by_block_is_read_as_a_whole_one(tmp_path_factory, content, piece):
    path = tmp_path_factory.getbasetemp() / "signals.csv"
    try:
        whole = DelimitedReader().read(SourceFile(path.name, content), Hints())
    except ReaderError:
        with suppress(ReaderError):
            assert by_blocks(path, content, piece, Hints()) is None
        return
    blocks = by_blocks(path, content, piece, Hints())
    if blocks is None:
        return
    found = joined(blocks)
    empty = [f"column {number}" for number in range(1, 4)]
    assert {name: values for name, values in found.items() if name in told(whole) or name not in empty} == told(whole)
    assert all(table.header == whole.header for table in blocks)
    assert [*dict.fromkeys(note for table in blocks for note in table.notes)] == list(whole.notes)


CLEAN = [f"{n}.5,{n}.25,3" for n in range(100)]


@pytest.mark.parametrize(
    ("line", "row"),
    [(60, "60.5,1.0"), (60, "60.5,1.0,3,4"), (60, "60.5,oops,3"), (101, "99.5,1"), (7, "6.5,1.0"), (101, '99.5,"1,3')],
    ids=["too short", "too wide", "a word", "cut at the end", "too short in the first block", "a quote"],
)
@pytest.mark.usefixtures("_long")
def test_errors_name_the_line_and_say_the_same(sample_run, monkeypatch, line, row):
    lines = ["Time [s],Depth [um],Ff [N]", *CLEAN]
    lines[line - 1] = row
    signals = sample_run / "signals.csv"
    signals.write_bytes("\n".join(lines).encode())
    manifest = (sample_run / "run.toml").read_text(encoding="utf-8").replace("Ff [mN]", "Ff [N]")
    (sample_run / "run.toml").write_text("\n".join(one for one in manifest.splitlines() if "Fn" not in one))
    with pytest.raises(ReaderError, match=r"signals\.csv") as by_block:
        read_run(sample_run)
    monkeypatch.setattr(long_text, "LARGE", 1 << 40)
    with pytest.raises(ReaderError) as whole:
        read_run(sample_run)
    assert str(by_block.value) == str(whole.value)


@pytest.mark.parametrize(
    "content",
    [
        "Time;Depth\n1;2\n".encode("utf-16"),
        b'Time,Depth\n1,"2\n3"\n',
        b"Time;Depth\r1;2\r" * 20_000,
        "Zeit;Höhe\n1;2\n".encode() + b"\xc3",
    ],
    ids=["UTF-16", "quotes over lines", "lone CR", "cut in a letter"],
)
def test_what_cannot_be_cut_into_blocks_is_read_whole(tmp_path, content):
    assert by_blocks(tmp_path / "signals.csv", content, 100, Hints()) is None


@pytest.mark.usefixtures("_long")
def test_words_far_down_turn_a_column_into_texts_from_its_start(sample_run):
    signals = sample_run / "signals.csv"
    lines = signals.read_text().splitlines()
    noted = [lines[0] + ",Note", *(f"{line},{n}" for n, line in enumerate(lines[1:]))]
    noted[-2] = f"{lines[-2]},belt slips"
    signals.write_text("\n".join(noted) + "\n")
    run = read_run(sample_run)
    assert run.extras["Note"].values[:3].tolist() == ["0", "1", "2"]
    assert run.extras["Note"].values[-2] == "belt slips"


@pytest.mark.usefixtures("_long")
def test_a_long_run_is_the_run_that_it_is_when_read_whole(short_runs, monkeypatch):
    streamed = read_run(short_runs / RUN)
    monkeypatch.setattr(long_text, "LARGE", 1 << 40)
    whole = read_run(short_runs / RUN)
    assert streamed.recording is None
    assert raw_digest(streamed) == raw_digest(whole)
    assert streamed.sources[1].content == whole.sources[1].content
    assert (streamed.headers, streamed.notes) == (whole.headers, whole.notes)


def test_a_named_encoding_holds_for_blocks_too(tmp_path):
    content = "Time;Höhe [µm]\n0,5;1,5\n0,6;1,5\n".encode("cp1252")
    (table, *_) = by_blocks(tmp_path / "signals.csv", content, 1 << 20, Hints(encoding="cp1252")) or []
    assert [one.unit for one in table.columns] == [None, "µm"]
    assert by_blocks(tmp_path / "signals.csv", content, 10, Hints(encoding="utf-8")) is None
    assert by_blocks(tmp_path / "signals.csv", content, 10, Hints(encoding="shift_jis")) is None


# --- means ---


def taken(
    columns: dict[str, np.ndarray], samples: int, pieces: list[int]
) -> tuple[dict[str | int, np.ndarray], list[int]]:
    all_means, at = Means(samples), 0
    length = len(next(iter(columns.values())))
    for piece in [*pieces, length]:
        if at < length:
            all_means.add({name: values[at : at + piece] for name, values in columns.items()})
            at += piece
    found, starts = all_means.finish()
    assert all_means.rows == length
    return found, [int(start) for start in starts]


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.integers(1, 9), min_size=1, max_size=8),
    st.integers(1, 6),
    st.lists(st.integers(1, 12), max_size=8),
    st.integers(0, 1000),
)
def test_means_are_means_wherever_blocks_and_restarts_are(segments, samples, pieces, seed):
    time = np.concatenate([np.arange(length, dtype=float) for length in segments])
    rng = np.random.default_rng(seed)
    depth = np.where(rng.random(len(time)) < 0.2, math.nan, rng.normal(5, 1, len(time)))
    found, starts = taken({"time": time, "depth": depth}, samples, pieces)
    ends = [*starts[1:], len(time)]
    restarts = (np.flatnonzero(np.diff(time) < 0) + 1).tolist()
    alone = {0, len(time) - 1, *restarts, *(start - 1 for start in restarts)}
    assert starts[0] == 0
    for number, (start, end) in enumerate(zip(starts, ends, strict=True)):
        assert 0 < end - start <= samples
        assert end - start == 1 or not alone & set(range(start, end))
        assert found["time"][number] == pytest.approx(time[start:end].mean())
        seen = depth[start:end][np.isfinite(depth[start:end])]
        assert found["depth"][number] == pytest.approx(seen.mean() if len(seen) else math.nan, nan_ok=True)
    assert taken({"time": time, "depth": depth}, samples, [])[1] == starts


def test_what_does_not_move_stays_what_it_is_and_words_are_those_of_the_first():
    words = np.array([f"w{n}" for n in range(50)], dtype=object)
    found, starts = taken({"time": np.arange(50.0), "depth": np.full(50, 0.1), 0: words}, 7, [13])
    assert set(found["depth"].tolist()) == {0.1}
    assert found[0].tolist() == [f"w{start}" for start in starts]


def test_a_missing_time_is_not_lost_in_a_mean():
    time = np.arange(40.0)
    time[17] = math.nan
    found, _ = taken({"time": time, "depth": np.arange(40.0)}, 5, [])
    assert np.count_nonzero(np.isnan(found["time"])) == 1


def test_error_codes_do_not_pull_a_mean_and_a_load_that_sets_in_stays():
    force = np.ones(100)
    force[:30] = 1e-4
    force[[50, 51, 52, 70]] = -9999.0
    found, starts = taken({"time": np.arange(100.0), "normal_force": force}, 10, [])
    assert np.isfinite(found["normal_force"]).all()
    assert found["normal_force"].min() == 1e-4
    assert found["normal_force"].max() == 1.0
    assert len(starts) == 12


def test_spikes_in_a_long_run_count_as_little_as_they_do_in_every_sample():
    rng = np.random.default_rng(1)
    depth = rng.normal(size=20_000)
    depth[::997] += 50
    found, starts = taken({"time": np.arange(20_000.0), "depth": depth}, 20, [])
    counts = np.diff(starts, append=20_000)
    assert np.average(found["depth"], weights=counts) == pytest.approx(depth.mean())


@pytest.mark.usefixtures("_by_means")
def test_a_stroke_keeps_twenty_samples(sample_run):
    manifest = read_run(sample_run).manifest
    conditions = {"normal_load": "1 N", "stroke": "8 mm", "frequency": "5 Hz"}
    there_and_back = manifest.model_copy(update={"conditions": manifest.conditions.model_validate(conditions)})
    time = {"time": np.arange(1000) / 1010.0}
    assert samples_in_a_mean(10**9, there_and_back, time) == 5
    assert samples_in_a_mean(300, there_and_back, time) == 2
    assert samples_in_a_mean(10**9, there_and_back, {"sliding_distance": np.arange(1000) * 7.9e-5}) == 5
    assert samples_in_a_mean(10**9, there_and_back, {}) == 1
    assert samples_in_a_mean(10**9, manifest, time) == -(-(10**9) // 251)


# --- the run ---


def recorded(run: RawRun, name: str) -> np.ndarray:
    assert run.recording is not None
    return np.concatenate([block[name] for block in run.recording.blocks() if name in block])


@pytest.mark.usefixtures("_by_means")
def test_a_long_run_is_kept_as_recorded_beside_its_means(short_runs, tmp_path, monkeypatch):
    archive = Archive(tmp_path / "archive")
    ingest(short_runs / RUN, archive)
    assert any("1,251 samples, more than the memory limit" in finding.message for finding in archive.findings(RUN))
    run = archive.raw(RUN)
    assert "252 means of 1,251 samples of time" in str(run)
    assert [run.numbered(0), run.numbered(1), run.numbered(251)] == ["sample 1", "samples 2 to 6", "sample 1251"]
    assert run.recording.samples == 5
    sent = pickle.loads(pickle.dumps(run))  # noqa: S301 - of our own making
    assert np.array_equal(recorded(sent, "depth"), recorded(run, "depth"))
    assert [one for one in verify(archive).findings if one.severity != "note"] == []
    monkeypatch.setattr(long_text, "LARGE", 1 << 40)
    whole = read_run(short_runs / RUN)
    for name in ("time", "depth", "friction_force", "normal_force"):
        assert np.array_equal(recorded(run, name), whole.columns[name])
    assert run.sources[1].content == whole.sources[1].content


@pytest.mark.slow
@pytest.mark.usefixtures("_by_means")
def test_a_long_run_has_the_wear_coefficient_of_every_sample_and_is_reproduced(short_runs, tmp_path, monkeypatch):
    archive = Archive(tmp_path / "archive")
    outcomes = list(process([short_runs / RUN], archive))
    assert [outcome.error for outcome in outcomes if outcome.error] == []
    assert {step.outcome for step in reproduce(archive, RUN).steps} == {"identical"}
    monkeypatch.setattr(long_text, "LARGE", 1 << 40)
    every = fit_wear(correct_drift(read_run(short_runs / RUN)), "archard").first.wear_coefficient
    found = archive.result(RUN, "wear_fit_archard", WearFit).first.wear_coefficient
    # Noise is told from fewer means than samples, and with it what the reading weighs beside the measurement.
    assert abs(found.value - every.value) < 0.3 * every.standard_uncertainty


@pytest.mark.usefixtures("_by_means")
def test_strokes_in_files_of_their_own_are_joined_as_they_restart(sample_run, monkeypatch):
    lines = (sample_run / "signals.csv").read_text().splitlines()
    names = [f"stroke_{number}.csv" for number in range(1, 4)]
    for number, name in enumerate(names):
        (sample_run / name).write_text("\n".join([lines[0], *lines[1 + 400 * number : 401 + 400 * number]]) + "\n")
    manifest = (sample_run / "run.toml").read_text(encoding="utf-8")
    files = ", ".join(f'"{name}"' for name in names)
    (sample_run / "run.toml").write_text(manifest.replace('file = "signals.csv"', f"files = [{files}]"))
    run = read_run(sample_run)
    assert run.recording.rows == 1200
    assert sorted(set(run.extras["file"].values.tolist())) == [1, 2, 3]
    assert np.array_equal(run.recording.starts[run.extras["file"].values == 2][:2], [400, 401])
    monkeypatch.setattr(long_text, "LARGE", 1 << 40)
    assert np.array_equal(recorded(run, "depth"), read_run(sample_run).columns["depth"])


@pytest.mark.usefixtures("_by_means")
def test_a_clock_that_goes_back_within_a_mean_is_seen(sample_run):
    signals = sample_run / "signals.csv"
    lines = signals.read_text().splitlines()
    lines[603], lines[604] = lines[604], lines[603]
    signals.write_text("\n".join(lines) + "\n")
    (found,) = [one for one in check_run(read_run(sample_run)) if one.code == "axis_backward"]
    assert "at sample 604 after" in found.message


@pytest.mark.usefixtures("_by_means")
def test_a_clock_that_restarts_is_joined(sample_run):
    signals = sample_run / "signals.csv"
    head, *lines = signals.read_text().splitlines()
    split = [line.split(",", 1) for line in lines]
    again = [
        f"{time},{rest}" for (time, _), (_, rest) in zip([*split[:600], *split[: len(split) - 600]], split, strict=True)
    ]
    signals.write_text("\n".join([head, *again]) + "\n")
    run = read_run(sample_run)
    cleaned = clean_run(run).run.columns["time"]
    assert np.all(np.diff(cleaned) > 0)
    assert cleaned[-1] == pytest.approx(float(split[-1][0]), rel=0.02)


@pytest.mark.usefixtures("_by_means")
def test_a_file_that_grows_while_it_is_read_is_not_archived(sample_run, tmp_path):
    archive, run = Archive(tmp_path / "archive"), read_run(sample_run)
    with (sample_run / "signals.csv").open("a") as file:
        file.write("1e6,1,1,1\n")
    with pytest.raises((ReaderError, ArchiveError), match=r"nothing is written into|does not change"):
        archive.add(run)
    assert archive.ids() == []
    assert list(archive.folder.glob("*.part")) == []


@pytest.mark.usefixtures("_by_means")
def test_a_file_that_changes_in_place_is_not_archived(sample_run, tmp_path):
    archive, run = Archive(tmp_path / "archive"), read_run(sample_run)
    signals = sample_run / "signals.csv"
    content = signals.read_bytes()
    signals.write_bytes(content[:-2] + b"0\n" if content[-2:] != b"0\n" else content[:-2] + b"1\n")
    with pytest.raises(ReaderError, match="found a file that changed while it was read"):
        archive.add(run)
    assert archive.ids() == []


@pytest.mark.slow
@pytest.mark.usefixtures("_by_means")
def test_ingesting_a_long_run_again_changes_nothing(short_runs, tmp_path):
    archive = Archive(tmp_path / "archive")
    assert ingest(short_runs / RUN, archive).status == "done"
    assert ingest(short_runs / RUN, archive).status == "unchanged"
    assert ingest(short_runs / RUN, archive, force=True).status == "done"
    assert archive.raw(RUN).recording.rows == 1251


# --- files of an instrument ---


@pytest.mark.slow
@pytest.mark.usefixtures("_long")
def test_a_long_export_is_known_by_its_beginning_and_copied_whole(short_runs, tmp_path):
    signals = short_runs / RUN / "signals.csv"
    export = read_export(signals)
    assert (export.reader.name, export.rows) == ("delimited", 1251)
    assert len(export.table.columns[0].values) < 500
    assert "too large to read at once: only the first" in export.table.notes[-1]
    made = make_run(Wanted([signals], into=tmp_path, id="copy", settings=["conditions.normal_load=200 mN"]))
    assert (made.folder / "signals.csv").read_bytes() == signals.read_bytes()
    assert made.groups[0].rows == 1251


@pytest.mark.slow
@pytest.mark.usefixtures("_long")
def test_long_channels_side_by_side_are_means_of_the_same_samples(sample_run, monkeypatch):
    monkeypatch.setattr(means, "MOST", 251)
    head, *lines = (sample_run / "signals.csv").read_text().splitlines()
    names = head.split(",")
    assert names[:2] == ["Time [s]", "Depth [um]"]
    cells = [line.split(",") for line in [head, *lines]]
    for name, picked in (("depth.csv", (0, 1)), ("forces.csv", (0, 2, 3))):
        (sample_run / name).write_text("\n".join(",".join(row[n] for n in picked) for row in cells) + "\n")
    manifest = (sample_run / "run.toml").read_text(encoding="utf-8")
    start, end = manifest.index("[[signals]]"), manifest.index("[end_values]")
    columns = {"depth.csv": ("time", "depth"), "forces.csv": ("friction_force", "normal_force")}
    headers = dict(zip(("time", "depth", "friction_force", "normal_force"), names, strict=True))
    tables = [
        f'[[signals]]\nfile = "{file}"\n[signals.columns]\n' + "".join(f'{one} = "{headers[one]}"\n' for one in found)
        for file, found in columns.items()
    ]
    whole = read_run(sample_run)
    (sample_run / "run.toml").write_text(manifest[:start] + "\n".join(tables) + manifest[end:], encoding="utf-8")
    run = read_run(sample_run)
    for name in ("time", "depth", "friction_force", "normal_force"):
        assert np.array_equal(run.columns[name], whole.columns[name])
        assert np.array_equal(recorded(run, name), recorded(whole, name))


@pytest.mark.usefixtures("_by_means")
def test_friction_there_and_back_is_that_of_every_sample(sample_run, monkeypatch):
    head, *lines = (sample_run / "signals.csv").read_text().splitlines()
    rows = [line.split(",") for line in lines]
    turned = head.split(",").index("Ff [mN]")
    for number, row in enumerate(rows):
        row[turned] = row[turned] if number // 100 % 2 else f"-{row[turned]}"
    (sample_run / "signals.csv").write_text("\n".join([head, *map(",".join, rows)]) + "\n")
    manifest = (sample_run / "run.toml").read_text(encoding="utf-8")
    there_and_back = 'stroke = "4 m"\nfrequency = "0.05 Hz"\nsliding_distance = "50 m"'
    manifest = manifest.replace('sliding_speed = "400 mm/s"\n', "").replace('sliding_distance = "50 m"', there_and_back)
    (sample_run / "run.toml").write_text(re.sub(r"sliding_speed = .*\n", "", manifest), encoding="utf-8")
    by_means = read_run(sample_run)
    monkeypatch.setattr(long_text, "LARGE", 1 << 40)
    one, other = (fit_friction(clean_run(run).run) for run in (by_means, read_run(sample_run)))
    assert by_means.recording.samples == 5
    assert abs(one.steady_state.value - other.steady_state.value) < 0.2 * other.steady_state.standard_uncertainty

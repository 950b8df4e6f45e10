"""Several tests in one file: each step or sheet is a run of its own, or the file is refused or flagged."""

import json
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from instrument_shapes import LADDER, rtec_ladder, workbook_of
from sweeps import others_slow

from tribopipe.base.errors import ReaderError
from tribopipe.documents.manifest import SignalFile
from tribopipe.readers import long_text
from tribopipe.readers.column_mapping import Part
from tribopipe.readers.draft.folder import Wanted, make_runs
from tribopipe.readers.harmonize import read_run
from tribopipe.readers.steps import Steps
from tribopipe.results.run import ExtraColumn, UnheldSource

LOAD = "conditions.normal_load=5 N"


@pytest.fixture
def lab(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def put(lab: Path, name: str, content: bytes) -> Path:
    (lab / name).write_bytes(content)
    return lab / name


def run_folder(lab: Path, content: bytes, signals: str, conditions: str = "") -> Path:
    """Make a run folder of a file by hand."""
    folder = lab / "by-hand"
    folder.mkdir()
    put(folder, "log.csv", content)
    text = f'schema = "tribopipe.run/1"\nid = "by-hand"\n[conditions]\nnormal_load = "5 N"\n{conditions}\n'
    (folder / "run.toml").write_text(f'{text}[[signals]]\nfile = "log.csv"\n{signals}\n', encoding="utf-8")
    return folder


def with_radius(folder: Path, radius: float) -> None:
    """State the radius of the track, as the lab does from its recipe, and take the recorded speed on it."""
    path = folder / "run.toml"
    text = path.read_text(encoding="utf-8")
    text = text.replace('# track_radius = "6 mm"', f'track_radius = "{radius!r} mm"')
    path.write_text(text.replace('# sliding_speed = "Rotary', 'sliding_speed = "Rotary'), encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("cumulative", others_slow([False, True]), ids=["time begins again", "time goes on"])
def test_steps_of_a_ladder_are_runs_of_their_true_distances(lab, cumulative):
    export = put(lab, "ladder.csv", rtec_ladder(cumulative=cumulative))
    made = make_runs(Wanted([export], lab / "runs", settings=[LOAD], split="Step"))
    assert [one.folder.name for one in made] == [f"ladder-step-{rung.number}" for rung in LADDER]
    for place, (one, rung) in enumerate(zip(made, LADDER, strict=True), 1):
        assert one.problem is None
        assert (one.folder / "ladder.csv").read_bytes() == export.read_bytes()
        document = tomllib.loads((one.folder / "run.toml").read_text(encoding="utf-8"))
        assert document["signals"][0]["steps"] == [rung.number]
        with_radius(one.folder, rung.radius)
        run = read_run(one.folder)
        assert len(run) == 1800
        assert run.earlier_steps == tuple(before.number for before in LADDER[: place - 1])
        assert run.sliding_distance[-1] == pytest.approx(rung.distance, rel=1e-9)
        assert run.columns["time"][[0, -1]] == pytest.approx([0.1, 180.0])
        assert np.mean(run.columns["friction_coefficient"]) == pytest.approx(0.1 * place, abs=0.001)


@pytest.mark.slow
def test_recorded_load_and_speed_of_a_step_are_proposed_and_not_taken(lab):
    export = put(lab, "ladder.csv", rtec_ladder())
    made = make_runs(Wanted([export], lab, split="Step"))
    text = (made[1].folder / "run.toml").read_text(encoding="utf-8")
    assert re.search(
        r"^# rotational_speed = \"143 rpm\" +# median of 'Rotary.Velocity \(rpm\)' in step 7$", text, re.MULTILINE
    )
    assert re.search(r"^# normal_load = \"[45]\.?\d* N\" +# median of 'DAQ.Fz \(N\)' in step 7$", text, re.MULTILINE)
    assert made[1].missing == ("conditions.normal_load",)


def test_steps_chosen_in_run_toml(lab):
    run = read_run(run_folder(lab, rtec_ladder(), "steps = [7, 13]", 'sliding_speed = "0.1 m/s"'))
    assert set(run.extras["Step"].values) == {7, 13}
    assert run.sliding_distance[-1] == pytest.approx(36.0)
    assert run.earlier_steps == (4, 10)


def test_a_short_step_that_loads_the_specimens_has_not_worn_them(lab):
    rows = "".join(f"{t / 10:.1f},{1 + (t >= 9) + (t >= 100)},0.2\n" for t in range(200))
    signals = 'steps = [3]\n[signals.columns]\ntime = "Time [s]"\nfriction_coefficient = "COF"'
    run = read_run(run_folder(lab, f"Time [s],Step,COF\n{rows}".encode(), signals, 'sliding_speed = "0.1 m/s"'))
    assert run.earlier_steps == (2,)


def test_all_rows_are_read_where_no_step_is_chosen(lab):
    run = read_run(run_folder(lab, rtec_ladder(), "", 'sliding_speed = "0.1 m/s"'))
    assert len(run) == 7200


@pytest.mark.parametrize(
    ("signals", "told"),
    [
        (
            "steps = [5]",
            "log.csv: found the steps 4, 7, 10, 13; expected step 5, which is selected in run.toml; correct",
        ),
        ('steps = [4]\nstep_column = "Stepp"', "found no column 'Stepp' with step numbers"),
        (
            'steps = [4]\nstep_column = "XYZ.X Position (mm)"',
            r"line 4, column 'XYZ.X Position \(mm\)': found '6.018'; expected a step num",
        ),
        ("steps = [4, 4]", "steps: found step 4 twice"),
        (
            'sheet = "A"',
            "log.csv: found the sheet 'A' specified for a file in the format rtec-mft, which has no sheets",
        ),
    ],
)
def test_choices_that_cannot_be_are_refused(lab, signals, told):
    with pytest.raises(Exception, match=told):
        read_run(run_folder(lab, rtec_ladder(), signals, 'sliding_speed = "0.1 m/s"'))


def test_no_column_of_steps(lab):
    with pytest.raises(ReaderError, match=r"log\.csv: found no column with step numbers; expected one"):
        read_run(run_folder(lab, b"Time [s],Fx [N]\n" + b"0,1\n1,2\n" * 3, "steps = [1]"))


# --- steps against time ---


def changed(content: bytes, line: int, old: bytes, new: bytes) -> bytes:
    """Change a line; the lone CR at the top ends a line, too."""
    lines = content.split(b"\n")
    assert lines[line - 2].startswith(old)
    lines[line - 2] = new + lines[line - 2].removeprefix(old)
    return b"\n".join(lines)


def test_a_step_number_that_changes_where_time_goes_on_is_refused_with_its_line(lab):
    spoiled = changed(rtec_ladder(), 1001, b"4,", b"7,")
    told = r"log.csv, line 1001: found step 7 after step 4, but time continues from 99.7 s to 99.8 s; expected time to "
    with pytest.raises(ReaderError, match=told + r"restart with each step, as at line 1804; correct"):
        read_run(run_folder(lab, spoiled, "", 'sliding_speed = "0.1 m/s"'))


def test_time_that_begins_again_within_a_step_is_refused_with_its_line(lab):
    content = rtec_ladder().replace(b"\n10,", b"\n7,")
    told = r"line 3604: found a time of 0.1 s after 180 s within step 7; expected time to increase within a step"
    with pytest.raises(ReaderError, match=told):
        make_runs(Wanted([put(lab, "log.csv", content)], lab, split="Step"))
    assert [path.name for path in lab.iterdir()] == ["log.csv"]


def test_a_step_number_that_is_none_is_refused_with_its_line(lab):
    content = changed(rtec_ladder(), 501, b"4,", b",")
    with pytest.raises(ReaderError, match="line 501, column 'Step': found 'nan'; expected a step number"):
        make_runs(Wanted([put(lab, "log.csv", content)], lab, split="Step"))


def test_rows_given_part_after_part_are_those_given_at_once():
    rng = np.random.default_rng(1)
    numbers = np.repeat([1.0, 2.0, 3.0, 2.0, 4.0], 40)
    time = np.cumsum(rng.uniform(0.09, 0.11, len(numbers)))
    counter = np.cumsum(rng.integers(0, 3, len(numbers))).astype(float)
    part = Part({"time": time, "rotations": counter}, {"Step": ExtraColumn(numbers)})
    signals = SignalFile(file="x", steps=(2, 3), step_column="Step")
    whole = Steps(signals, "x").chosen(part, None)
    for size in (1, 7, 40, 63):
        reader = Steps(signals, "x")
        pieces = [
            reader.chosen(
                Part(
                    {name: values[at : at + size] for name, values in part.columns.items()},
                    {"Step": ExtraColumn(numbers[at : at + size])},
                ),
                None,
            )
            for at in range(0, len(numbers), size)
        ]
        for name, values in whole.columns.items():
            assert np.allclose(np.concatenate([piece.columns[name] for piece in pieces]), values)
    assert whole.columns["time"][0] == pytest.approx(time[40] - time[39])
    assert whole.columns["rotations"][-1] == counter[159] - counter[39]


def test_steps_of_a_file_too_long_to_be_held(lab, monkeypatch):
    rows = "".join(f"{t / 10:.1f},{1 + t // 50},{0.2 + t / 1000:.4f}\n" for t in range(200))
    signals = 'steps = [2, 4]\n[signals.columns]\ntime = "Time [s]"\nfriction_coefficient = "COF"'
    folder = run_folder(lab, f"Time [s],Step,COF\n{rows}".encode(), signals, 'sliding_speed = "0.1 m/s"')
    whole = read_run(folder)
    monkeypatch.setattr(long_text, "LARGE", 0)
    monkeypatch.setattr(long_text, "PIECE", 200)
    read = read_run(folder)
    assert isinstance(read.sources[1], UnheldSource)
    assert len(read) == len(whole) == 100
    assert read.earlier_steps == whole.earlier_steps == (1, 3)
    for name, values in whole.columns.items():
        assert np.allclose(read.columns[name], values)
    assert read.sliding_distance[-1] == pytest.approx(1.0)


def test_a_counter_that_is_one_back_is_not_begun_again():
    counter = np.array([100.0, 101, 102, 101, 104])
    part = Part({"rotations": counter}, {"Step": ExtraColumn(np.array([1.0, 2, 2, 2, 2]))})
    taken = Steps(SignalFile(file="x", steps=(2,), step_column="Step"), "x").chosen(part, None)
    assert taken.columns["rotations"].tolist() == [1, 2, 1, 4]


# --- workbooks ---


def test_a_workbook_of_three_tests_is_refused_with_the_choice(lab):
    export = put(lab, "tests.xlsx", workbook_of(["Run 1", "Run 2", "Run 3"]))
    told = "a test table in each of the sheets 'Run 1', 'Run 2' and 'Run 3'; expected one test; .*--sheet.*--each-sheet"
    with pytest.raises(ReaderError, match=told):
        make_runs(Wanted([export], lab / "runs"))
    assert not (lab / "runs").exists()


def test_one_sheet_is_one_run(lab):
    export = put(lab, "tests.xlsx", workbook_of(["Run 1", "Run 2", "Run 3"]))
    (made,) = make_runs(
        Wanted([export], lab / "runs", settings=[LOAD, "conditions.sliding_speed=0.1 m/s"], sheet="Run 2")
    )
    run = read_run(made.folder)
    assert run.manifest.signals[0].sheet == "Run 2"
    assert len(run) == 60
    assert np.all(run.columns["friction_coefficient"] == 0.2)


def test_a_template_may_name_the_sheet(lab):
    export = put(lab, "tests.xlsx", workbook_of(["Info", "Data"]))
    template = put(lab, "lab.toml", b'schema = "tribopipe.template/1"\n[signals]\nsheet = "Data"\n')
    (made,) = make_runs(Wanted([export], lab, settings=[LOAD], template=template))
    assert 'sheet = "Data"' in (made.folder / "run.toml").read_text(encoding="utf-8")


@pytest.mark.slow
def test_each_sheet_is_a_run(lab):
    export = put(lab, "tests.xlsx", workbook_of(["Run 1", "Run 2", "Run 3"]))
    settings = [LOAD, "conditions.sliding_speed=0.1 m/s"]
    made = make_runs(Wanted([export], lab / "runs", settings=settings, each_sheet=True))
    assert [one.folder.name for one in made] == ["tests-Run-1", "tests-Run-2", "tests-Run-3"]
    for place, one in enumerate(made, 1):
        run = read_run(one.folder)
        assert np.all(run.columns["friction_coefficient"] == pytest.approx(0.1 * place))
        assert run.sources[1].content == export.read_bytes()


def test_ingest_refuses_a_run_folder_without_the_choice(lab):
    export = put(lab, "tests.xlsx", workbook_of(["A", "B"]))
    (made,) = make_runs(Wanted([export], lab, settings=[LOAD], sheet="A"))
    path = made.folder / "run.toml"
    path.write_text(path.read_text(encoding="utf-8").replace('sheet = "A"', ""), encoding="utf-8")
    with pytest.raises(ReaderError, match="in each of the sheets 'A' and 'B'"):
        read_run(made.folder)


@pytest.mark.parametrize(
    ("wanted", "told"),
    [
        ({"sheet": "Run 4"}, "found no sheet 'Run 4'; expected one of 'Run 1', 'Run 2'"),
        ({"sheet": "Run 1", "id": "x", "split": "Step"}, "found no column 'Step' for the steps"),
    ],
)
def test_a_sheet_that_is_not_there(lab, wanted, told):
    export = put(lab, "tests.xlsx", workbook_of(["Run 1", "Run 2"]))
    with pytest.raises(ReaderError, match=told):
        make_runs(Wanted([export], lab, **wanted))


def test_each_sheet_takes_one_workbook(lab):
    export = put(lab, "log.csv", rtec_ladder())
    with pytest.raises(ReaderError, match="found a file in the format rtec-mft; expected a workbook"):
        make_runs(Wanted([export], lab, each_sheet=True))
    with pytest.raises(ReaderError, match="--each-sheet: found 2 files"):
        make_runs(Wanted([export, export], lab, each_sheet=True))


@pytest.mark.slow
def test_answers_are_asked_for_once_and_taken_for_all(lab):
    export = put(lab, "ladder.csv", rtec_ladder())
    asked = []

    def ask(question: str) -> str:
        asked.append(question)
        return "5 N" if question.startswith("conditions.normal_load") else ""

    made = make_runs(Wanted([export], lab, split="Step"), ask)
    assert len(asked) == 3
    assert all(one.missing == () for one in made)


def test_steps_left_together_are_said_to_be_so(lab):
    (made,) = make_runs(Wanted([put(lab, "ladder.csv", rtec_ladder())], lab, settings=[LOAD]))
    told = (
        "ladder.csv: column 'Step' contains the step numbers 4, 7, 10 and 13; all steps are treated as "
        "one test; if load, speed or track radius differ "
    )
    assert any(note.startswith(told) for note in made.notes)


def test_the_commands(run_cli, lab):
    put(lab, "tests.xlsx", workbook_of(["A", "B"]))
    put(lab, "ladder.csv", rtec_ladder())
    refused = run_cli("new", "tests.xlsx", cwd=lab)
    assert refused.exit_code != 0
    assert "--each-sheet" in refused.stderr
    sheets = run_cli("new", "tests.xlsx", "--each-sheet", "--json", cwd=lab)
    assert [one["id"] for one in json.loads(sheets.stdout)["runs"]] == ["tests-A", "tests-B"]
    steps = run_cli("new", "ladder.csv", "--split", "Step", "--set", LOAD, "--json", cwd=lab)
    assert [one["id"] for one in json.loads(steps.stdout)["runs"]] == [f"ladder-step-{rung.number}" for rung in LADDER]

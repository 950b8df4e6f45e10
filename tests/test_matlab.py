"""MAT-files: vectors of the workspace and of structs as columns, structs as tests, scalars as header."""

import numpy as np
import pytest
from built_files import mat
from sweeps import others_slow

from tribopipe.base.errors import ReaderError
from tribopipe.readers.draft.folder import Wanted, make_runs
from tribopipe.readers.formats.matlab import MatlabReader
from tribopipe.readers.header_facts import header_facts
from tribopipe.readers.reader import Hints, ReadTable
from tribopipe.results.run import SourceFile

READER = MatlabReader()
N = 40
TIME = np.arange(N) / 10


def read(content: bytes, sheet: str | None = None) -> ReadTable:
    return READER.read(SourceFile("run.mat", content), Hints(sheet=sheet))


def recorded(load: float = 5.0) -> dict[str, np.ndarray]:
    return {"time_s": TIME, "Fn_N": np.full(N, load), "Ft_N": 0.4 * load + 0.01 * TIME, "wear_um": TIME}


def columns(table: ReadTable) -> dict[str, list[float]]:
    return {column.name: column.values.tolist() for column in table.columns}


@pytest.mark.slow
@pytest.mark.parametrize(
    "variables", others_slow([recorded(), {"run": recorded()}, {"lab": {"run": {"data": recorded()}}}])
)
def test_vectors_are_columns_wherever_they_are(variables):
    table = read(mat(variables))
    assert columns(table) == {name: values.tolist() for name, values in recorded().items()}
    assert [column.unit for column in table.columns] == ["s", "N", "N", "um"]


@pytest.mark.slow
def test_rows_are_columns_too_and_integers_are_numbers():
    table = read(mat({"t": TIME[np.newaxis], "n": np.arange(N, dtype="int16")[:, np.newaxis]}))
    assert columns(table) == {"t": TIME.tolist(), "n": list(range(N))}


@pytest.mark.slow
@pytest.mark.parametrize(
    "names", others_slow([np.array(["Time", "Ft [N]"], dtype=object), np.array(["Time  ", "Ft [N]"])])
)
def test_matrix_next_to_the_names_of_its_columns(names):
    data = np.column_stack([TIME, 2 * TIME])
    assert columns(read(mat({"data": data, "colheaders": names}))) == {
        "Time": TIME.tolist(),
        "Ft [N]": (2 * TIME).tolist(),
    }


@pytest.mark.slow
def test_numbers_and_texts_are_the_header_with_those_outside():
    content = mat({"operator": "N. N.", "run": {"info": {"load_N": 5.0, "ball_diameter_mm": 6.0}, "data": recorded()}})
    assert header_facts(read(content).header).facts == {
        "operator": "N. N.",
        "conditions.normal_load": "5.0 N",
        "contact.pin.diameter": "6.0 mm",
    }


@pytest.mark.slow
def test_unit_at_the_end_of_a_name_unless_it_may_be_an_index():
    units = {"time_s": "s", "t_s": "s", "Ft_N": "N", "dist_m": "m", "wear_um": "um", "v_mps": "mps"}
    units |= dict.fromkeys(("F_N", "mu_s", "h_m", "F_t", "F_g", "v_max"))
    table = read(mat(dict.fromkeys(units, TIME)))
    assert {column.name: column.unit for column in table.columns} == units


@pytest.mark.slow
def test_vectors_of_other_lengths_are_left_out_with_a_note():
    table = read(mat(recorded() | {"calibration": np.arange(7.0)}))
    assert "calibration" not in columns(table)
    assert table.notes == (
        "variable 'calibration' is omitted: no vector of real numbers of the same length, and no list of column names",
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "left_out",
    others_slow(
        [
            np.arange(2.0 * N).reshape(N, 2),
            TIME * 1j,
            np.zeros((N, 2, 2)),
            np.ones((N, 2)) * 1j,
        ],
        first=2,
    ),
)
def test_matrices_without_names_and_complex_vectors_are_left_out_with_a_note(left_out):
    table = read(mat(recorded() | {"calibration": left_out}))
    assert list(columns(table)) == list(recorded())
    assert [note for note in table.notes if "'calibration'" in note] == list(table.notes) != []


@pytest.mark.slow
def test_what_is_no_signal_is_left_out_without_a_note():
    """Settings, texts, names of columns and matrices with names need no note."""
    named = {"data": np.column_stack([TIME, 2 * TIME]), "names": np.array(["A", "B"], dtype=object)}
    table = read(mat(recorded() | named | {"operator": "N. N.", "load_N": 5.0, "phase": 1j, "empty": np.zeros((0, 0))}))
    assert table.notes == ()
    assert {"A", "B"} < set(columns(table))


@pytest.mark.slow
def test_structs_of_an_array_are_tests(tmp_path):
    runs = np.array([{"load_N": load, "data": recorded(load)} for load in (5.0, 10.0)], dtype=object)
    content = mat({"runs": runs})
    with pytest.raises(ReaderError, match=r"'runs\(1\)\.data' and 'runs\(2\)\.data'; expected one test"):
        read(content)
    assert columns(read(content, "runs(2).data"))["Fn_N"][0] == 10
    with pytest.raises(ReaderError, match=r"found no sheet 'runs\(3\)'"):
        read(content, "runs(3)")
    (tmp_path / "a.mat").write_bytes(content)
    made = make_runs(Wanted([tmp_path / "a.mat"], into=tmp_path / "runs", each_sheet=True))
    assert [one.folder.name for one in made] == ["a-runs-1-data", "a-runs-2-data"]
    assert all((one.missing, one.problem) == ((), None) for one in made)
    loads = [(one.folder / "run.toml").read_text(encoding="utf-8") for one in made]
    assert 'normal_load = "5.0 N"' in loads[0]
    assert 'normal_load = "10.0 N"' in loads[1]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("content", "said"),
    others_slow(
        [
            (
                b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(512),
                r"version 7\.3 MAT-file; expected version 7 or earlier; save it",
            ),
            (mat({"a": 1.0, "b": TIME}), "no two vectors of equal length"),
            (mat({"a": np.zeros((3, 3))}), "no two vectors of equal length"),
            (mat(recorded())[:-5], "which end within a variable"),
            (mat(recorded())[:200], "which end within a variable"),
            (b"MATLAB 5.0 MAT-file".ljust(128) + b"\xff" * 64, "which end within a variable"),
        ],
        first=2,
    ),
)
def test_what_holds_no_table_is_refused_in_one_sentence(content, said):
    with pytest.raises(ReaderError, match=rf"^run\.mat: .*{said}"):
        read(content)

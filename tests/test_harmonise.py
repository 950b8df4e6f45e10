"""From files to one run: recognised and mapped columns, several files, and what is derived from what."""

import numpy as np
import pytest
from folders import replace_in

from tribopipe.base.errors import ManifestError, ReaderError
from tribopipe.readers.harmonize import read_run

ONE = "Time [s],Depth [um]\n0.0,0.1\n0.1,0.2\n0.2,0.4\n"
OTHER = "Time [s];Ff [mN];Note\n0,0;1,5;a\n0,1;1,6;b\n0,2;1,7;c\n"


def write_files(run, one: str, other: str, columns: str = 'friction_force = { column = "Ff", unit = "mN" }') -> None:
    (run / "depth.csv").write_text(one, encoding="utf-8")
    (run / "friction.csv").write_text(other, encoding="utf-8")
    files = f'[[signals]]\nfile = "depth.csv"\n[[signals]]\nfile = "friction.csv"\n[signals.columns]\n{columns}\n\n'
    replace_in(run / "run.toml", r"(?ms)^\[\[signals\]\].*?(?=^\[end_values\])", files)


def test_files_of_one_time_base_make_one_run(sample_run):
    write_files(sample_run, ONE, OTHER)
    run = read_run(sample_run)
    np.testing.assert_allclose(run.columns["depth"], [1e-7, 2e-7, 4e-7], rtol=1e-12)
    np.testing.assert_allclose(run.columns["friction_force"], [1.5e-3, 1.6e-3, 1.7e-3], rtol=1e-12)
    assert list(run.extras["Note"].values) == ["a", "b", "c"]
    assert [source.name for source in run.sources] == ["run.toml", "depth.csv", "friction.csv"]


def test_files_of_different_clocks_are_refused(sample_run):
    write_files(sample_run, ONE, OTHER.replace("0,1;", "0,15;"))
    with pytest.raises(ReaderError, match=r"friction.csv: found values of time that differ .* first at sample 2"):
        read_run(sample_run)


def test_files_of_different_length_are_refused(sample_run):
    write_files(sample_run, ONE + "0.3,0.5\n", OTHER)
    with pytest.raises(ReaderError, match="3 rows, but 4 in the previous files"):
        read_run(sample_run)


def test_friction_is_divided_by_the_nominal_load_where_none_was_measured(sample_run):
    write_files(sample_run, ONE, OTHER)
    run = read_run(sample_run)
    assert run.origins["friction_coefficient"] == "derived from nominal load"
    np.testing.assert_allclose(run.columns["friction_coefficient"], np.array([1.5, 1.6, 1.7]) / 400, rtol=1e-12)


@pytest.mark.parametrize(
    ("header", "scale", "derived", "expected"),
    [("Time [s]", 1.0, "sliding_distance", [0.0, 0.04, 0.08]), ("Sliding distance [m]", 0.4, "time", [0.0, 0.1, 0.2])],
)
def test_time_and_distance_follow_from_each_other(sample_run, header, scale, derived, expected):
    rows = "".join(f"{second * scale:.2f},{second}\n" for second in (0.0, 0.1, 0.2))
    write_files(sample_run, f"{header},Depth [um]\n{rows}", "", "")
    replace_in(sample_run / "run.toml", r'\[\[signals\]\]\nfile = "friction.csv"\n\[signals.columns\]\n', "")
    run = read_run(sample_run)
    assert run.origins[derived] == "derived from nominal speed"
    np.testing.assert_allclose(run.columns[derived], expected, atol=1e-12)


def write_strokes(run, *contents: str, columns: str = "") -> None:
    names = [f"stroke_{number}.csv" for number in range(1, len(contents) + 1)]
    for name, content in zip(names, contents, strict=True):
        (run / name).write_text(content, encoding="utf-8")
    listed = ", ".join(f'"{name}"' for name in names)
    signals = f"[[signals]]\nfiles = [{listed}]\n{columns}\n\n"
    replace_in(run / "run.toml", r"(?ms)^\[\[signals\]\].*?(?=^\[end_values\])", signals)


def test_files_that_continue_each_other_make_one_run(sample_run):
    swapped = "Depth [um],Time [s]\n0.5,0.3\n0.7,0.4\n"
    write_strokes(sample_run, ONE, swapped)
    run = read_run(sample_run)
    np.testing.assert_allclose(run.columns["time"], [0.0, 0.1, 0.2, 0.3, 0.4])
    np.testing.assert_allclose(run.columns["depth"], np.array([0.1, 0.2, 0.4, 0.5, 0.7]) * 1e-6)
    assert list(run.extras["file"].values) == [1, 1, 1, 2, 2]
    assert [source.name for source in run.sources] == ["run.toml", "stroke_1.csv", "stroke_2.csv"]
    assert list(run.headers) == ["stroke_1.csv", "stroke_2.csv"]


def test_files_may_continue_each_other_in_other_units(sample_run):
    write_strokes(sample_run, ONE, "Time [ms],Depth [nm]\n300,500\n")
    run = read_run(sample_run)
    np.testing.assert_allclose(run.columns["time"], [0.0, 0.1, 0.2, 0.3])
    np.testing.assert_allclose(run.columns["depth"], [1e-7, 2e-7, 4e-7, 5e-7])


def test_a_column_that_not_every_file_has_is_left_out_with_a_note(sample_run):
    write_strokes(sample_run, "Time [s],Depth [um],Oil\n0,1,2\n", "Time [s],Depth [um]\n1,1\n")
    run = read_run(sample_run)
    assert list(run.extras) == ["file"]
    assert any(
        "columns omitted, since not all files contain them in the same unit: 'Oil'" in note for note in run.notes
    )


def test_a_file_of_other_signals_does_not_continue_the_test(sample_run):
    write_strokes(sample_run, ONE, "Time [s],Friction force [N]\n0.3,1\n")
    with pytest.raises(ReaderError, match=r"friction_force, but time, depth in stroke_1.csv"):
        read_run(sample_run)


def test_a_bad_number_is_named_by_the_file_it_stands_in(sample_run):
    write_strokes(sample_run, ONE, "Time [s],Depth [um]\n0.3,off\n", columns='[signals.columns]\ndepth = "Depth"')
    with pytest.raises(ReaderError, match=r"stroke_2.csv, line 2, column 'Depth \[um\]': found 'off'"):
        read_run(sample_run)


def test_a_force_given_as_a_mass_is_its_weight(sample_run):
    write_files(sample_run, ONE, OTHER, 'friction_force = { column = "Ff", unit = "g" }')
    run = read_run(sample_run)
    np.testing.assert_allclose(run.columns["friction_force"], np.array([1.5, 1.6, 1.7]) * 9.80665e-3, rtol=1e-12)
    assert "friction.csv: friction_force in g is converted to the weight of that mass" in run.notes


def test_one_entry_names_a_file_or_files(sample_run):
    write_strokes(sample_run, ONE)
    replace_in(
        sample_run / "run.toml", r'files = \["stroke_1.csv"\]', 'file = "stroke_1.csv"\nfiles = ["stroke_1.csv"]'
    )
    with pytest.raises(ManifestError, match=r"found both file and files; expected one of the two"):
        read_run(sample_run)

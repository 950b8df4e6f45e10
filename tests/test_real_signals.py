"""Signal files that nobody on this project recorded: detected, and read as the notes beside them say."""

from pathlib import Path

import numpy as np
import pytest

from tribopipe.base.errors import ReaderError
from tribopipe.readers.reader import Hints, ReadTable, detect
from tribopipe.results.run import SourceFile

REAL_DATA = Path(__file__).resolve().parents[2] / "shared" / "realdata"
PCS = "pcs-ehd-labview/examples/data_import"
HOME_BUILT = "pinondiskapp-es/data"
LVM = {"X_Value": ("s", 0, 0.000714), "fx_N": ("N", 0.20669, 0.213159), "fz_N": ("N", 13.156782, 13.162599)}

# Reader, rows, and of columns their units and ranges, in those units.
FILES = {
    f"{PCS}/demo_1.txt": ("labview-lvm", 18, LVM),
    f"{PCS}/demo_2.txt": ("labview-lvm", 18, LVM),
    f"{PCS}/demo_3.txt": ("pcs-instruments", 42, {"Rolling Speed (mm/s)": ("mm/s", 20.1, 2000.7)}),
    f"{HOME_BUILT}/test.txt": (
        "delimited",
        8561,
        {
            "fuerza[kg]": ("kg", 0, 0.234),
            "distancia[m]": ("m", 0.04, 344.16),
            "tiempo[s]": ("s", 0.05, 3446.8),
            "temperatura[°C]": ("°C", 17.9, 18.8),
            "humedad[%]": ("%", 74.4, 78.7),
        },
    ),
    f"{HOME_BUILT}/celda_sim.csv": ("load-cell-frames", 13439, {"load": ("kgf", 0, 0.458)}),
    "nanotribometer-silicone-percycle/CoF-Measurements.csv": (
        "delimited",
        4308,
        {"NominalLoad": (None, 10, 7000), "CoF.mean": (None, 0.00307413, 2.9058121)},
    ),
}
SERIES = {"winducom-dwf-al10cu": "*/*.dwf", "newport-rheofriction": "*/*.txt"}
NO_DATA = ["LICENSE*", "README.md", "PROVENANCE.txt", "Experimental Conditions"]


def read(path: Path, reader: str) -> ReadTable:
    source = SourceFile(path.name, path.read_bytes())
    found = detect(source)
    assert found.name == reader
    return found.read(source, Hints())


def series(folder: str) -> list[Path]:
    found = sorted((REAL_DATA / folder).glob(SERIES[folder]))
    if not found:
        pytest.skip(f"real data not here: {folder}")
    return found


@pytest.mark.parametrize("name", FILES)
def test_detected_and_read_as_the_notes_say(name):
    reader, rows, columns = FILES[name]
    if not (REAL_DATA / name).is_file():
        pytest.skip(f"real data not here: {name}")
    table = read(REAL_DATA / name, reader)
    found = {column.name: column for column in table.columns}
    assert {len(column.values) for column in table.columns} == {rows}
    for column, (unit, least, largest) in columns.items():
        assert found[column].unit == unit
        np.testing.assert_allclose(
            [found[column].values.min(), found[column].values.max()], [least, largest], rtol=1e-6
        )


@pytest.mark.slow
def test_winducom_runs_have_their_rows():
    tables = [read(path, "ducom-winducom") for path in series("winducom-dwf-al10cu")]
    assert sorted(len(table.columns[0].values) for table in tables) == [427] * 10 + [460] * 2
    for table in tables:
        time, force = table.columns
        assert (time.name, time.unit, force.name, force.unit) == ("TIME", "s", "FF", "N")
        assert 0.9 <= time.values[0] <= 1.0
        assert 418.35 <= time.values[-1] <= 418.65
        assert np.all((force.values > 0) & (force.values < 50))


@pytest.mark.slow
def test_newport_runs_have_their_rows_and_loads():
    paths = series("newport-rheofriction")
    tables = [read(path, "newport-rheofriction") for path in paths]
    assert len(tables) == 48
    assert sum(len(table.columns[0].values) for table in tables) == 40_983
    for path, table in zip(paths, tables, strict=True):
        stated = path.stem.partition("rps")[2].removesuffix("N").replace("-", ".")
        assert float(table.facts["conditions.normal_load"].removesuffix(" N")) == float(stated)
        assert [column.unit for column in table.columns] == ["s", "s", "N", "N*m", "um", "rps", "mm/s"]


def test_a_colour_table_is_refused_by_name():
    path = REAL_DATA / PCS / "demo_4.txt"
    if not path.is_file():
        pytest.skip("real data not here: demo_4.txt")
    with pytest.raises(ReaderError, match=r"demo_4.txt: found a 'Mapper Spacer Calibration File'; expected"):
        detect(SourceFile(path.name, path.read_bytes()))


@pytest.mark.parametrize("pattern", NO_DATA)
def test_what_lies_beside_the_data_is_refused(pattern):
    found = sorted(REAL_DATA.rglob(pattern))
    if not found:
        pytest.skip(f"real data not here: {pattern}")
    for path in found:
        with pytest.raises(ReaderError, match="found no known format; read as a plain table: "):
            detect(SourceFile(path.name, path.read_bytes()))

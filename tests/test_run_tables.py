"""`tribopipe export runs`: what spreadsheets, papers and scripts open, read back by their own parsers."""

import io
import re
import shutil
import subprocess

import numpy as np
import openpyxl
import pandas
import pyarrow.parquet
import pytest
import python_calamine
from folders import SAMPLES

from tribopipe.archive.catalog.catalog import Catalogue
from tribopipe.archive.catalog.listing import COLUMNS, columns_named
from tribopipe.archive.store import Archive
from tribopipe.base.errors import NotInstalledError
from tribopipe.pipeline.stages import process
from tribopipe.views.run_tables import (
    FORMS,
    _rounded,
    _siunitx,
    runs_csv,
    runs_latex,
    runs_markdown,
    runs_parquet,
    runs_workbook,
    si_columns,
)

pytestmark = pytest.mark.usefixtures("few_draws")

NUMBERS = [column.name for column in COLUMNS.values() if column.kind == "number"]


@pytest.fixture
def runs(archive):
    catalogue = Catalogue(archive)
    catalogue.refresh()
    return catalogue.runs()


@pytest.fixture(scope="module")
def heavy_runs(tmp_path_factory):
    """Runs of 400 mN and 1600 mN, ingested only."""
    folder = tmp_path_factory.mktemp("heavy")
    for name in ("wc-co-water-400mN", "wc-co-water-1600mN"):
        shutil.copytree(SAMPLES / name, folder / name)
    text = (folder / "wc-co-water-400mN/run.toml").read_text(encoding="utf-8")
    strange = text.replace('comment = "', 'comment = "=1+1; 50 % | _a_ & µ ', 1)
    strange = strange if strange != text else 'comment = "=1+1; 50 % | _a_ & µ"\n' + text
    (folder / "wc-co-water-400mN/run.toml").write_text(strange, encoding="utf-8")
    archive = Archive(folder / "archive")
    for path in ("wc-co-water-400mN", "wc-co-water-1600mN"):
        list(process([folder / path], archive))
    catalogue = Catalogue(archive.folder)
    catalogue.refresh()
    return catalogue.runs(sort="load")


def expected(runs, name):
    return [np.nan if (number := run.number(name)) is None else number for run in runs]


def head_of(name, runs):
    unit = COLUMNS[name].unit
    if name == "load" and max(run.value("load") for run in runs) >= 1:
        unit = "N"
    return f"{name} [{unit}]" if unit else name


# --- by the parsers of the programs ---


def test_workbook_is_opened_with_every_number(runs):
    content = runs_workbook(runs)
    sheet = openpyxl.load_workbook(io.BytesIO(content)).active
    heads, *rows = sheet.iter_rows(values_only=True)
    assert len(rows) == len(runs)
    for name in NUMBERS:
        place = heads.index(head_of(name, runs))
        assert [row[place] for row in rows] == [run.number(name) for run in runs], name
        assert [row[place + 1] for row in rows] == [run.spread(name) for run in runs], name
    assert next(iter(rows))[heads.index("started")].isoformat() == "2006-03-01T09:30:00"
    # And by another reader than the package that wrote it.
    other = python_calamine.CalamineWorkbook.from_filelike(io.BytesIO(content)).get_sheet_by_name("runs").to_python()
    assert other[0] == list(heads)
    assert other[1][heads.index(head_of("k_d", runs))] == runs[0].number("k_d")


def test_german_csv_is_opened_with_german_settings(runs):
    content = runs_csv(runs, decimal_comma=True)
    assert content.startswith(b"\xef\xbb\xbfid;")  # by which Excel knows UTF-8
    table = pandas.read_csv(io.BytesIO(content), sep=";", decimal=",")
    for name in NUMBERS:
        assert table[head_of(name, runs)].dtype.kind in "fi", name
        assert np.array_equal(table[head_of(name, runs)].astype(float), expected(runs, name), equal_nan=True), name


def test_international_csv_is_opened_as_it_is(runs):
    table = pandas.read_csv(io.BytesIO(runs_csv(runs)))
    assert list(table) == [head for head in table if "Unnamed" not in head]
    for name in NUMBERS:
        assert np.array_equal(table[head_of(name, runs)].astype(float), expected(runs, name), equal_nan=True), name


def test_latex_has_a_cell_for_each_column(heavy_runs):
    text = runs_latex(heavy_runs).decode()
    form, body = re.search(r"(?s)\\begin\{tabular\}\{(.*?)\}\n(.*)\\end\{tabular\}", text).groups()
    kinds = re.findall(r"S\[table-format = -?\d+(?:\.\d+)?(?:\(\d+\))?\]|l", form)
    assert "".join(kinds) == form.replace("] ", "]").replace("l ", "l")
    rules = re.findall(r"\\(?:top|mid|bottom)rule", body)
    assert rules == ["\\toprule", "\\midrule", "\\bottomrule"]
    rows = [line.strip().removesuffix(" \\\\") for line in body.splitlines() if line.endswith(" \\\\")]
    assert len(rows) == 1 + len(heavy_runs)
    cells = [re.split(r"(?<!\\)&", row) for row in rows]
    assert {len(row) for row in cells} == {len(kinds)}
    for row in cells[1:]:
        for kind, cell in zip(kinds, row, strict=True):
            if kind != "l":
                assert re.fullmatch(r"-?\d+(\.\d+)?(\(\d+\))?|\{--\}", cell.strip()), cell
    assert text.count("{") == text.count("}")


def test_latex_states_value_unit_and_uncertainty(runs):
    text = runs_latex(runs, columns_named("id,load,k_d")).decode()
    k_d, u = runs[0].number("k_d"), runs[0].spread("k_d")
    assert "{load / \\unit{\\milli\\newton}}" in text
    assert "{$k_\\mathrm{D}$ / $10^{-8}$\\,\\unit{\\milli\\metre\\cubed\\per\\newton\\per\\milli\\metre}}" in text
    value, last = re.search(r"& (\d\.\d+)\((\d+)\) \\\\", text).groups()
    assert float(value) == pytest.approx(k_d * 1e8, abs=0.5 * 10 ** -len(value.partition(".")[2]))
    assert int(last) == pytest.approx(u * 1e8 * 10 ** len(value.partition(".")[2]), abs=0.5)
    assert "output-decimal-marker" not in text
    assert "\\sisetup{output-decimal-marker = {,}}" in runs_latex(runs, decimal_comma=True).decode()


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="needs pdflatex")
@pytest.mark.parametrize("comma", [False, True], ids=["point", "comma"])
def test_latex_is_typeset(heavy_runs, tmp_path, comma):
    table = runs_latex(heavy_runs, decimal_comma=comma).decode()
    preamble = "\\documentclass{standalone}\n" + re.search(r"(?m)^% (\\usepackage.*)", table).group(1)
    text = f"{preamble}\n\\begin{{document}}\n{table}\n\\end{{document}}\n"
    (tmp_path / "runs.tex").write_text(text, encoding="utf-8")
    made = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "runs.tex"]
    done = subprocess.run(made, cwd=tmp_path, capture_output=True, text=True, encoding="utf-8", errors="replace")
    assert done.returncode == 0, done.stdout
    assert (tmp_path / "runs.pdf").stat().st_size > 0


def test_parquet_is_read_as_the_table_of_the_archive(archive, runs):
    table = pandas.read_parquet(io.BytesIO(runs_parquet(runs)))
    known = Archive(archive).table()
    units = known.attrs["units"]
    pandas.testing.assert_frame_equal(table[[*units]], known[[*units]], check_exact=True)
    texts = known.columns.drop([*units])
    assert table[texts].astype(object).where(table[texts].notna(), None).equals(known[texts].astype(object))
    fields = pyarrow.parquet.read_schema(io.BytesIO(runs_parquet(runs)))
    assert {name: fields.field(name).metadata[b"unit"].decode() for name in units} == units
    assert list(table) == list(known)
    assert units["u_k_d"] == "m^2/N"


def test_chosen_columns_of_parquet_are_numbers_even_where_nothing_is_known(heavy_runs):
    content = runs_parquet(heavy_runs, columns_named("id,load,k_d"))
    assert pandas.read_parquet(io.BytesIO(content)).dtypes[["load", "k_d", "u_k_d"]].eq(float).all()


def test_markdown_is_a_table(heavy_runs):
    lines = runs_markdown(heavy_runs, columns_named("id,load,k_d,comment")).decode().splitlines()
    cells = [re.split(r"(?<!\\)\|", line)[1:-1] for line in lines]
    assert {len(row) for row in cells} == {4}
    assert cells[0][1].strip() == "load / N"
    assert cells[1][1].strip() == "---:"
    assert [row[1].strip() for row in cells[2:]] == ["0.4000 ± 0.0040", "1.600 ± 0.016"]


# --- loads, texts, digits ---


def test_loads_are_in_newton_where_one_is_a_newton(runs, heavy_runs):
    assert "load [mN]" in runs_csv(runs).decode()
    table = pandas.read_csv(io.BytesIO(runs_csv(heavy_runs)))
    assert table["load [N]"].tolist() == [0.4, 1.6]
    assert "load [mN]" not in table
    assert [run.number("load") for run in heavy_runs] == [400, 1600]  # what the list shows stays


@pytest.mark.parametrize("suffix", FORMS)
def test_texts_are_never_formulas_nor_markup(heavy_runs, suffix):
    content = FORMS[suffix](heavy_runs, columns_named("id,comment"))
    comment = heavy_runs[0].text("comment")
    assert comment.startswith("=1+1; 50 % | _a_ & µ")
    if suffix == ".xlsx":
        cell = openpyxl.load_workbook(io.BytesIO(content)).active["B2"]
        assert (cell.data_type, cell.value) == ("s", comment)
    elif suffix == ".csv":
        assert pandas.read_csv(io.BytesIO(content))["comment"][0] == f"'{comment}"
    elif suffix == ".parquet":
        assert pandas.read_parquet(io.BytesIO(content))["comment"][0] == comment
    elif suffix == ".tex":
        assert r"=1+1; 50 \% | \_a\_ \& $\mu$" in content.decode()
    else:
        assert r"=1+1; 50 % \| \_a\_ & µ" in content.decode()


@pytest.mark.parametrize(
    ("number", "spread", "power", "found"),
    [
        (1.3583e-8, 2.46e-10, -8, ("1.358", "25")),
        (200.0, 2.0, 0, ("200.0", "20")),
        (1234.0, 125.0, 0, ("1234", "125")),
        (-0.20, 0.32, 0, ("-0.20", "32")),
        (0.9996, 0.00996, 0, ("1.000", "10")),
        (500.0, None, 0, ("500", "")),
        (0.25, None, 0, ("0.25", "")),
        (0.0, None, 0, ("0", "")),
        (12.3456, 0.0, 0, ("12.35", "")),
        (None, None, 0, None),
    ],
)
def test_digits_follow_the_uncertainty(number, spread, power, found):
    assert _rounded(number, spread, power) == found


def test_every_unit_of_a_column_has_its_macros():
    for column in COLUMNS.values():
        if column.unit:
            assert re.fullmatch(r"(\\[a-zA-Z]+)+", _siunitx(column.unit)), column.unit
    assert _siunitx("mm³/(N·mm)") == r"\milli\metre\cubed\per\newton\per\milli\metre"
    assert _siunitx("nm/min") == r"\nano\metre\per\minute"


# --- the command ---


def test_suffix_chooses_the_form(run_cli, archive, tmp_path, runs):
    for suffix, write in FORMS.items():
        path = tmp_path / f"runs{suffix}"
        assert run_cli("export", "runs", "--archive", archive, "-o", path).exit_code == 0
        if suffix == ".xlsx":
            assert openpyxl.load_workbook(path).active["A2"].value == runs[0].id
        else:
            assert path.read_bytes() == write(runs)
    german = tmp_path / "german.csv"
    assert run_cli("export", "runs", "--archive", archive, "-o", german, "--decimal-comma").exit_code == 0
    assert german.read_bytes() == runs_csv(runs, decimal_comma=True)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["-o", "runs.ods"], "found the suffix .ods; expected one of .csv, .xlsx, .tex, .md"),
        (["-o", "runs.xlsx", "--decimal-comma"], "the decimal separator of a workbook"),
    ],
)
def test_other_forms_are_refused(run_cli, archive, options, said):
    told = run_cli("export", "runs", "--archive", archive, *options)
    assert told.exit_code == 2
    assert said in " ".join(told.stderr.replace("│", " ").split())


@pytest.mark.parametrize(
    ("package", "extra", "write"), [("openpyxl", "excel", runs_workbook), ("pyarrow", "parquet", runs_parquet)]
)
def test_form_without_its_package_names_the_extra(runs, monkeypatch, package, extra, write):
    monkeypatch.setitem(__import__("sys").modules, package, None)
    with pytest.raises(NotInstalledError, match=rf'pip install "tribopipe\[{extra}\]"'):
        write(runs)


def test_a_count_of_findings_has_no_uncertainty(runs):
    heads = runs_csv(runs, columns_named("load,findings")).decode().splitlines()
    assert heads[0] == "load [mN],load uncertainty [mN],findings"
    assert heads[1].split(",")[2] == "0.0"
    found = si_columns(runs)
    assert {"findings", "u_load"} <= found.values.keys()
    assert "u_findings" not in found.values.keys() | found.units.keys()

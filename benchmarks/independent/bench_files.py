"""The files of the bench cases, as three instruments write them, and a run.toml beside each."""

import json
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple
from xml.sax.saxutils import escape

from independent.noise import Column
from independent.runs import Recorded

_KELVIN = 273.15


class _Shown(NamedTuple):
    """A column of a file."""

    header: str
    signal: str
    factor: float = 1.0
    offset: float = 0.0
    decimals: int = 3

    def texts(self, columns: Mapping[str, Column]) -> list[str]:
        """Return the column's cells."""
        values = columns[self.signal] * self.factor + self.offset
        return [f"{value:.{self.decimals}f}" for value in values.tolist()]


_GERMAN = (
    _Shown("Zeit [s]", "time", decimals=2),
    _Shown("Weg [m]", "sliding_distance", decimals=4),
    _Shown("Reibwert [-]", "friction_coefficient", decimals=4),
    _Shown("Normalkraft [N]", "normal_force"),
    _Shown("Verschleißweg [µm]", "depth", 1e6),
    _Shown("Temperatur [°C]", "temperature", offset=-_KELVIN, decimals=2),
)
_ENGLISH = (
    _Shown("Time (s)", "time", decimals=2),
    _Shown("Position (mm)", "position", 1e3, decimals=4),
    _Shown("Fx (N)", "friction_force", decimals=4),
    _Shown("Fz (N)", "normal_force", decimals=4),
    _Shown("Z (um)", "depth", 1e6),
)
_ABOVE = (
    ("Prüfbericht", "Tribometer 2"),
    ("Normalkraft", "5 N"),
    ("Bahnradius", "5 mm"),
    ("Gleitgeschwindigkeit", "0,1 m/s"),
    ("Gegenkörper", "Kugel 100Cr6 D=6 mm"),
)


def _semicolons(runs: Sequence[Recorded], folder: Path) -> Path:
    """Write case a: cp1252, semicolons, decimal commas, a German block above the names."""
    cells = [[text.replace(".", ",") for text in column.texts(runs[0].columns)] for column in _GERMAN]
    above = [";".join(line) for line in _ABOVE]
    rows = map(";".join, zip(*cells, strict=True))
    text = "\r\n".join([*above, "", ";".join(column.header for column in _GERMAN), *rows, ""])
    return _written(folder / "Verschleiß.csv", text.encode("cp1252"))


def _tabs(runs: Sequence[Recorded], folder: Path) -> Path:
    """Write case b: tabs, no block above the names."""
    rows = map("\t".join, zip(*(column.texts(runs[0].columns) for column in _ENGLISH), strict=True))
    text = "\n".join(["\t".join(column.header for column in _ENGLISH), *rows, ""])
    return _written(folder / "recip.txt", text.encode("ascii"))


def _workbook(runs: Sequence[Recorded], folder: Path) -> Path:
    """Write case c: one workbook with a sheet per test and three rows above the names."""
    sheets = {f"Versuch {number}": _sheet(one, number) for number, one in enumerate(runs, 1)}
    path = folder / "Versuche.xlsx"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as book:
        for name, content in _book(tuple(sheets)):
            book.writestr(name, _XML + content)
        for number, sheet in enumerate(sheets.values(), 1):
            book.writestr(f"xl/worksheets/sheet{number}.xml", _XML + sheet)
    return path


class _Format(NamedTuple):
    """How a case is written."""

    write: Callable[[Sequence[Recorded], Path], Path]
    columns: tuple[_Shown, ...]


_FORMATS: Mapping[str, _Format] = {
    "a: ball on disc": _Format(_semicolons, _GERMAN),
    "b: reciprocating": _Format(_tabs, _ENGLISH),
    "c: three replicates": _Format(_workbook, _GERMAN),
}


def write_recording(case: str, runs: Sequence[Recorded], folder: Path) -> Path:
    """Write the instrument's file of a bench case into a folder and return its path."""
    folder.mkdir(parents=True, exist_ok=True)
    return _FORMATS[case].write(runs, folder)


def manifest_text(case: str, recorded: Recorded, run_id: str, **signals: object) -> str:
    """Return the run.toml of a run; ``signals`` are the keys of its one [[signals]], such as file and sheet."""
    document = recorded.document | {"id": run_id}
    lines = [f"{key} = {json.dumps(value)}" for key, value in document.items() if isinstance(value, str)]
    for key, value in document.items():
        if isinstance(value, dict):
            lines += _table(key, value)
    named = [f"{key} = {json.dumps(value, ensure_ascii=False)}" for key, value in signals.items()]
    columns = [
        f"{column.signal} = {json.dumps(column.header, ensure_ascii=False)}"
        for column in _FORMATS[case].columns
        if column.signal != "position"
    ]
    return "\n".join([*lines, "", "[[signals]]", *named, "", "[signals.columns]", *columns, ""])


def _table(name: str, table: dict[str, Any]) -> Iterator[str]:
    """Yield a table of TOML; a quantity is an inline table."""
    inner = {key: value for key, value in table.items() if isinstance(value, dict) and "value" not in value}
    yield from ("", f"[{name}]")
    for key, value in table.items():
        if key not in inner:
            yield f"{key} = {_inline(value)}"
    for key, value in inner.items():
        yield from _table(f"{name}.{key}", value)


def _inline(value: Any) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {json.dumps(part)}" for key, part in value.items()) + " }"
    return json.dumps(value)


def _written(path: Path, content: bytes) -> Path:
    path.write_bytes(content)
    return path


_XML = '<?xml version="1.0" encoding="UTF-8" standalone="yes"?>\n'
_OFFICE = "http://schemas.openxmlformats.org"
_MAIN = f"{_OFFICE}/spreadsheetml/2006/main"
_RELATIONS = f"{_OFFICE}/officeDocument/2006/relationships"
_SHEET_TYPE = "application/vnd.openxmlformats-officedocument.spreadsheetml"


def _sheet(recorded: Recorded, number: int) -> str:
    above = [["Prüfbericht", f"Versuch {number}"], ["Normalkraft", "10 N"], ["Bahnradius", "6 mm"]]
    head = [*above, [column.header for column in _GERMAN]]
    rows = ["<row>" + "".join(f'<c t="inlineStr"><is><t>{escape(text)}</t></is></c>' for text in row) for row in head]
    cells = zip(*(column.texts(recorded.columns) for column in _GERMAN), strict=True)
    rows += ["<row>" + "".join(f"<c><v>{text}</v></c>" for text in row) for row in cells]
    return f'<worksheet xmlns="{_MAIN}"><sheetData>{"</row>".join(rows)}</row></sheetData></worksheet>'


def _book(names: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Yield the parts of a workbook that hold its sheets together."""
    numbers = range(1, len(names) + 1)
    types = [
        f'<Override PartName="/xl/worksheets/sheet{n}.xml" ContentType="{_SHEET_TYPE}.worksheet+xml"/>' for n in numbers
    ]
    book_type = f'<Override PartName="/xl/workbook.xml" ContentType="{_SHEET_TYPE}.sheet.main+xml"/>'
    default = (
        '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
        '<Default Extension="xml" ContentType="application/xml"/>'
    )
    package = f"{_OFFICE}/package/2006"
    yield "[Content_Types].xml", f'<Types xmlns="{package}/content-types">{default}{book_type}{"".join(types)}</Types>'
    yield "_rels/.rels", _relations([("officeDocument", "xl/workbook.xml")])
    sheets = "".join(
        f'<sheet name="{name}" sheetId="{n}" r:id="rId{n}"/>' for n, name in zip(numbers, names, strict=True)
    )
    yield "xl/workbook.xml", f'<workbook xmlns="{_MAIN}" xmlns:r="{_RELATIONS}"><sheets>{sheets}</sheets></workbook>'
    yield "xl/_rels/workbook.xml.rels", _relations([("worksheet", f"worksheets/sheet{n}.xml") for n in numbers])


def _relations(targets: Sequence[tuple[str, str]]) -> str:
    links = [
        f'<Relationship Id="rId{number}" Type="{_RELATIONS}/{kind}" Target="{target}"/>'
        for number, (kind, target) in enumerate(targets, 1)
    ]
    return f'<Relationships xmlns="{_OFFICE}/package/2006/relationships">{"".join(links)}</Relationships>'

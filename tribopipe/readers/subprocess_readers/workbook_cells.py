"""Sheets of a spreadsheet as tab-separated text, in JSON. Argument: the decimal separator.

A row of cells is a line. Numbers are written with all their digits, dates and times of day in ISO 8601, durations as
PT12.5S, whatever their number format states; blanks, tabs and line ends inside a cell become one blank.
"""

import csv
import io
import json
import re
import sys
from collections.abc import Iterator
from datetime import date, time, timedelta
from typing import Any

_BLANKS = re.compile(r"[\s\x00-\x1f]+")


def main() -> None:
    """Answer with the sheets, or end with what is wrong."""
    try:
        sheets = list(_sheets(sys.stdin.buffer.read(), decimal=sys.argv[1]))
    except BaseException as error:  # noqa: BLE001 - a panic of Rust is no Exception
        sys.exit(f"{type(error).__name__}: {error}".replace("\n", " "))
    sys.stdout.buffer.write(json.dumps(sheets).encode("ascii"))


def _sheets(content: bytes, decimal: str) -> Iterator[dict[str, Any]]:
    from python_calamine import SheetTypeEnum, SheetVisibleEnum, load_workbook

    book = load_workbook(io.BytesIO(content))
    for sheet in book.sheets_metadata:
        if sheet.typ is SheetTypeEnum.WorkSheet:
            text = _text(book.get_sheet_by_name(sheet.name), decimal)
            yield {"name": sheet.name, "visible": sheet.visible is SheetVisibleEnum.Visible, "text": text}


def _text(sheet: Any, decimal: str) -> str:
    lines = io.StringIO()
    writer = csv.writer(lines, delimiter="\t", lineterminator="\n")
    for row in sheet.to_python(skip_empty_area=False):
        cells = [_cell(value, decimal) for value in row]
        writer.writerow(cells if any(cells) else [])
    return lines.getvalue()


def _cell(value: Any, decimal: str) -> str:
    if isinstance(value, float):
        return repr(value).replace(".", decimal)
    if isinstance(value, timedelta):
        return f"PT{value.total_seconds()!r}S"
    if isinstance(value, date | time):
        return value.isoformat()
    return _BLANKS.sub(" ", str(value)).strip()


if __name__ == "__main__":
    main()

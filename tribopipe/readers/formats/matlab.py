"""MAT-files (.mat), as MATLAB 5 to 7.2 and Octave save them: vectors of the workspace, of structs and their arrays.

    MATLAB 5.0 MAT-file, …    text of 116 bytes, then the variables, compressed since MATLAB 7
    MATLAB 7.3 MAT-file, …    HDF5 behind a block of 512 bytes, which is refused

* Vectors of one length in the workspace or in a struct are the columns of a table; so are the columns of a matrix next
  to a list of their names, as importdata makes it (data, colheaders). Shorter and longer vectors are left out, with a
  note.
* Several structs, or elements of an array of structs, that each hold a table are tests, one of which has to be chosen,
  as in a workbook: ``runs(2).data``.
* Numbers and texts next to the vectors, further outside or in structs of their own are the header, one line each.
* A unit may stand at the end of a name, as in any text: "time_s", "Fn_N", "wear_um".
* After the head, each variable has its type and length, 4 bytes each, and its contents.
* Tables, dates and other objects of MATLAB are left out, since only MATLAB reads them: table2struct helps.
"""

import json
import struct
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.errors import ReaderError
from tribopipe.readers.reader import Hints, Holds, Match, ReadColumn, ReadTable
from tribopipe.readers.subprocess_readers import answer_of
from tribopipe.readers.table_parts import join_parts, several_tests, tests_among, unknown_sheet
from tribopipe.readers.tables import split_name
from tribopipe.results.run import SourceFile

_MAGIC = b"MATLAB 5.0 MAT-file"
_HDF5 = b"MATLAB 7.3 MAT-file"
_HEAD, _TAG = 128, 8
"""Bytes before the variables, and before the contents of each: its type, and its length."""
_REMEDY = "save it again in MATLAB with save(…, '-v7')"
_OMITTED = "is omitted: no vector of real numbers of the same length, and no list of column names"


class MatlabReader:
    """MAT-files."""

    name = "matlab"
    title = "MATLAB or Octave (.mat), version 7 or earlier"
    holds: Holds = "signals"
    suffixes = (".mat",)

    def match(self, source: SourceFile) -> Match:
        """Judge by the text at the start."""
        if source.content.startswith((_MAGIC, _HDF5)):
            return Match(0.98, "the file starts with the name and version of a MAT-file")
        return Match(0.0, "the file does not start with the name of a MAT-file")

    def read(self, source: SourceFile, hints: Hints) -> ReadTable:
        """Parse the file; ``ReaderError`` where it is damaged, or holds no table, or several."""
        tables = _tables(source)
        tests = tests_among(tables)
        if hints.sheet is not None:
            if hints.sheet not in tables:
                raise unknown_sheet(source.name, hints.sheet, list(tables))
            return tables[hints.sheet]
        if len(tests) > 1:
            raise several_tests(source.name, list(tests))
        return join_parts(source.name, "struct", tables)

    def sheets(self, source: SourceFile, hints: Hints) -> list[str]:  # noqa: ARG002 - nothing of a binary file is open
        """Name the structs that hold a table like that of a test. Raises ``ReaderError`` where none does."""
        return list(tests_among(_tables(source)))


def _tables(source: SourceFile) -> dict[str, ReadTable]:
    if source.content.startswith(_HDF5):
        raise ReaderError(f"{source.name}: found a version 7.3 MAT-file; expected version 7 or earlier; {_REMEDY}")
    _refuse_cut(source)
    line, _, numbers = answer_of("matlab_arrays.py", source, remedy=_REMEDY).partition(b"\n")
    tables = dict(_read(json.loads(line), np.frombuffer(numbers, "<f8")))
    if not tables:
        raise ReaderError(
            f"{source.name}: found no two vectors of equal length; expected a vector for each signal, in the "
            "workspace or in a struct; convert tables with table2struct(…, 'ToScalar', true), and save them again"
        )
    return tables


def _refuse_cut(source: SourceFile) -> None:
    """Refuse a file that ends within a variable; one cut between two is not distinguished from a shorter one."""
    content, position = source.content, _HEAD
    order = ">" if content[_HEAD - 2 : _HEAD] == b"MI" else "<"
    while position + _TAG <= len(content):
        position += _TAG + struct.unpack_from(f"{order}4xI", content, position)[0]
    if position != len(content):
        raise ReaderError(
            f"{source.name}: found {len(content)} bytes, which end within a variable; expected a complete MAT-file; "
            f"{_REMEDY}, or copy it again"
        )


def _read(said: list[dict[str, Any]], numbers: NDArray[np.float64]) -> Iterator[tuple[str, ReadTable]]:
    start = 0
    for table in said:
        columns = []
        for column in table["columns"]:
            end = start + column["rows"]
            unit = split_name(column["name"])[1]
            columns.append(ReadColumn(column["name"], numbers[start:end].astype(np.float64), unit))
            start = end
        header = "".join(f"{_label(name)}\t{value}\n" for name, value in table["settings"])
        notes = [f"variable {name!r} {_OMITTED}" for name in table["omitted"]]
        yield table["name"] or "workspace", ReadTable(tuple(columns), header, tuple(notes))


def _label(name: str) -> str:
    bare, unit = split_name(name)
    return f"{bare} [{unit}]" if unit else bare

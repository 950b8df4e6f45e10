"""Columns padded with blanks, decimal comma, a row of names and a row of units: read by the generic reader."""

import pytest
from small_exports import read

from tribopipe.readers.delimited import DelimitedReader
from tribopipe.results.run import SourceFile

READER = DelimitedReader()


@pytest.mark.parametrize(
    "content",
    [
        "Czas  Ft\ns  N\n0,000  1,250\n0,100  -1,300\n10,200  1,275\n",
        "    Czas      Ft\r\n       s       N\r\n   0,000   1,250\r\n   0,100  -1,300\r\n  10,200   1,275\r\n",
        "Próbka: A12\nData: 12.05.2019\n\nCzas      Ft    \ns         N     \n0,0  1,25  \n0,1  -1,3\n10,2   1,275 \n",
        "Czas  Ft\r[s]  [N]\r0  1,250\r0,1  -1,300\r10,2  1,275\r",
    ],
    ids=["left", "right", "settings above", "brackets"],
)
@pytest.mark.parametrize("encoding", ["utf-8", "cp1250", "utf-16"])
def test_plain_columns(content, encoding):
    encoded = content.encode(encoding)
    assert READER.match(SourceFile("x", encoded)).confidence >= 0.5
    time, force = read(READER, encoded).columns
    assert (time.name, time.unit, time.values.tolist()) == ("Czas", "s", [0.0, 0.1, 10.2])
    assert (force.name, force.unit, force.values.tolist()) == ("Ft", "N", [1.25, -1.3, 1.275])

"""Binary files of profilometers: known by their marks, read where the package SurfaceTopography is installed."""

import io
import zipfile
from importlib.util import find_spec

import numpy as np
import pytest

from tribopipe.base.errors import ReaderError
from tribopipe.readers.formats import surface_topography
from tribopipe.readers.formats.surface_topography import SurfaceTopographyReader
from tribopipe.readers.reader import Hints, Reader
from tribopipe.results.run import SourceFile

READER = SurfaceTopographyReader()
SDF = b"""aISO-1.0
ManufacID   = Somebody
CreateDate  = 010120200000
ModDate     = 010120200000
NumPoints   = 3
NumProfiles = 2
Xscale      = 1e-6
Yscale      = 2e-6
Zscale      = 1e-9
Zresolution = -1
Compression = 0
DataType    = 7
CheckType   = 0
*
1 2 3
4 5 6
*
"""
needs_package = pytest.mark.skipif(find_spec("SurfaceTopography") is None, reason="SurfaceTopography is not installed")


def archive(*parts: str) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as file:
        for part in parts:
            file.writestr(part, "<a/>")
    return out.getvalue()


def confidence(content: bytes) -> float:
    return READER.match(SourceFile("a.bin", content)).confidence


def test_is_a_reader():
    assert isinstance(READER, Reader)
    assert READER.holds == "profile"


@pytest.mark.parametrize("mark", [*surface_topography._MARKS, archive("main.xml", "bindata/data.bin")])
def test_known_by_their_marks_below_every_reader_of_our_own(mark):
    assert 0.5 <= confidence(mark + b"\0\1\2") < 0.6


@pytest.mark.parametrize(
    "content", [b"", b"\0", b"x z\n1 2\n", b"PK\x03\x04", archive("xl/workbook.xml"), b"\x89HDF\r\n\x1a\n", b"II*\x00"]
)
def test_other_files_are_left_alone(content):
    assert confidence(content) == 0.0


def test_without_the_package_it_says_how_to_get_it(monkeypatch):
    monkeypatch.setattr(surface_topography, "find_spec", lambda _: None)
    with pytest.raises(ReaderError, match=r'a\.sdf: .*to be installed.*pip install "tribopipe\[surface\]"'):
        READER.read(SourceFile("a.sdf", SDF), Hints())


@needs_package
def test_map_is_read_scan_line_by_scan_line():
    x, y, z = READER.read(SourceFile("a.sdf", SDF), Hints()).columns
    assert [(column.axis, column.unit) for column in (x, y, z)] == [("x", "µm"), ("y", "µm"), ("z", "µm")]
    np.testing.assert_allclose(x.values, [0, 1, 2] * 2)
    np.testing.assert_allclose(y.values, [0] * 3 + [2] * 3)
    np.testing.assert_allclose(z.values, np.arange(1, 7) * 1e-3)


@needs_package
@pytest.mark.parametrize("size", [9, 60, 150])
def test_cut_files_are_refused(size):
    with pytest.raises(ReaderError, match=r"^a\.sdf: found a file that SurfaceTopography cannot read"):
        READER.read(SourceFile("a.sdf", SDF[:size]), Hints())

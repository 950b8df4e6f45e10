"""Binary files of profilometers and microscopes, through the package SurfaceTopography (MIT; 40 and more formats).

    pip install "tribopipe[surface]"

Recognised are formats whose files begin with marks of their own, or are archives with parts of known names: Gwyddion,
Dektak OPDx, Wyko OPD, Alicona, Digital Surf, Keyence, Nanoscope, MetroPro, X3P, PLUx and the like. The package reads
more; name the reader "surface-topography" in run.toml for those. It is never preferred to a reader of tribopipe itself.

What it reads of the default channel becomes columns x and z of a profile, or x, y and z of a map, scan line by scan
line, in the unit of the file, which is the same for all axes then. Points that were not measured are NaN. A file that
does not state how large it is cannot be read.
"""

import warnings
from importlib import import_module
from importlib.util import find_spec
from io import BytesIO
from typing import Any
from zipfile import BadZipFile, ZipFile

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.errors import ReaderError
from tribopipe.base.units import is_unit
from tribopipe.readers.reader import Axis, Hints, Holds, Match, ReadColumn, ReadTable
from tribopipe.results.run import SourceFile

_MARKS = {
    b"GWYP": "Gwyddion's own format",
    b"VCA DATA": "Dektak OPDx",
    b"\x01\x00Directory": "Wyko OPD",
    b"AliconaImaging": "Alicona AL3D",
    b"DIGITAL SURF": "Digital Surf SUR",
    b"DSCOMPRESSED": "Digital Surf SUR, compressed",
    b"VK4_": "Keyence VK4",
    b"VK6_": "Keyence VK6",
    b"VK7_": "Keyence VK7",
    b"KPK": "Keyence ZON",
    b"\\*File list": "Nanoscope",
    b"FRTM_GLIDERV": "FRT MicroProf",
    b"\x01\xb0\x93\xff": "NT-MDT",
    b"\x88\x1b\x03\x6f": "Zygo MetroPro",
    b"\x88\x1b\x03\x70": "Zygo MetroPro",
    b"\x88\x1b\x03\x71": "Zygo MetroPro",
    b"WSxM file copyright": "WSxM",
    b"aISO-1.0": "ISO 25178 SDF, ASCII",
    b"bISO-1.0": "ISO 25178 SDF, binary",
    b"fileformat = bcr": "BCR",
    b"Binary TrueMap Data File": "TrueMap TMD",
}
_ARCHIVES = {"main.xml": "X3P, ISO 25178-72", "index.xml": "Sensofar PLUx"}
_PACKAGE = "SurfaceTopography"


class SurfaceTopographyReader:
    """Formats that the package SurfaceTopography knows."""

    name = "surface-topography"
    title = "Binary files of profilometers (Gwyddion, OPDx, OPD, SUR, X3P, …)"
    holds: Holds = "profile"

    def match(self, source: SourceFile) -> Match:
        """Judge by the marks that a file begins with; whether the package is there is seen when reading."""
        found = next((title for mark, title in _MARKS.items() if source.content.startswith(mark)), None)
        found = found or _archive(source.content)
        if found is None:
            return Match(0.0, "no signature of a binary profilometer file")
        return Match(0.55, f"the file has the signature of {found}")

    def read(self, source: SourceFile, hints: Hints) -> ReadTable:  # noqa: ARG002 - a binary file takes no hints
        """Parse the file; ``ReaderError`` where the package is missing or cannot read it."""
        if find_spec(_PACKAGE) is None:
            raise ReaderError(
                f"{source.name}: found a file that requires the package SurfaceTopography; expected this package "
                "to be installed; run `pip install "
                '"tribopipe[surface]"`, or export the profile as text'
            )
        try:
            with warnings.catch_warnings(action="ignore"):
                return _table(source.content)
        except ReaderError as error:
            raise ReaderError(f"{source.name}: {error}") from None
        except Exception as error:  # noqa: BLE001 - readers of 40 formats may raise anything
            said = " ".join(str(error).split())[:120] or type(error).__name__
            raise ReaderError(
                f"{source.name}: found a file that SurfaceTopography cannot read ({said}); expected a complete "
                "file in a supported format; copy the file again from the instrument, or export the profile as "
                "text"
            ) from None


def _archive(content: bytes) -> str | None:
    """Recognise an archive by the names of its parts."""
    if not content.startswith(b"PK\x03\x04"):
        return None
    try:
        parts = set(ZipFile(BytesIO(content)).namelist())
    except (BadZipFile, ValueError, NotImplementedError):
        return None
    return next((title for part, title in _ARCHIVES.items() if part in parts), None)


def _table(content: bytes) -> ReadTable:
    opened = import_module(f"{_PACKAGE}.IO").open_topography(BytesIO(content))
    channel = opened.default_channel
    if channel.physical_sizes is None:
        raise ReaderError(
            "found a map or profile without lateral dimensions; expected them in units of length; export the data as "
            "text with positions"
        )
    surface = opened.topography()
    axes: tuple[Axis, ...] = ("x", "z") if surface.dim == 1 else ("x", "y", "z")
    unit = surface.unit if isinstance(surface.unit, str) and is_unit(surface.unit) else None
    columns = tuple(
        ReadColumn(axis, _by_scan_lines(values), unit, axis=axis)
        for axis, values in zip(axes, surface.positions_and_heights(), strict=True)
    )
    return ReadTable(columns, notes=tuple(_channel_note(opened.channels, channel)))


def _by_scan_lines(values: Any) -> NDArray[np.float64]:
    """Flatten what is indexed by x and y, and mark what was not measured."""
    filled: NDArray[np.float64] = np.ma.filled(np.ma.asarray(values, dtype=float), np.nan)
    return filled.T.ravel()


def _channel_note(channels: Any, taken: Any) -> list[str]:
    """Report which channel of several was read."""
    if len(channels) < 2:
        return []
    others = ", ".join(repr(str(one.name)) for one in channels if one.name != taken.name)
    return [f"read the channel {str(taken.name)!r}; the file also contains {others}"]

"""Binary files built part by part: spreadsheets of three kinds, TDMS, and a run as tribopipe archives it."""

import io
import struct
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

import numpy as np

from tribopipe.archive.store import Archive
from tribopipe.documents.manifest import RunManifest
from tribopipe.results.run import ExtraColumn, RawRun, SourceFile

Cell = Any
Rows = Sequence[Sequence[Cell]]
PACKAGE = "http://schemas.openxmlformats.org/package/2006"
OFFICE = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
MAIN = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"


class Xml(str):
    """A cell of .xlsx as XML, {ref} in the place of its reference; or one of .ods."""


def zipped(members: Mapping[str, str | bytes]) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in members.items():
            kind = zipfile.ZIP_STORED if name == "mimetype" else zipfile.ZIP_DEFLATED
            archive.writestr(zipfile.ZipInfo(name), text, kind)
    return out.getvalue()


def xlsx(sheets: Mapping[str, Rows], hidden: Sequence[str] = ()) -> bytes:
    """An Excel workbook. Cells: numbers, texts, None, or XML; number formats: 1 date, 2 duration, 3 time of day."""
    listed = "".join(
        f'<sheet name="{escape(name)}" sheetId="{number}" r:id="rId{number}"'
        f"{' state=' + chr(34) + 'hidden' + chr(34) if name in hidden else ''}/>"
        for number, name in enumerate(sheets, 1)
    )
    related = "".join(
        f'<Relationship Id="rId{number}" Type="{OFFICE}/worksheet" Target="worksheets/sheet{number}.xml"/>'
        for number in range(1, len(sheets) + 1)
    )
    members = {
        "[Content_Types].xml": f'<Types xmlns="{PACKAGE}/content-types"/>',
        "_rels/.rels": f'<Relationships xmlns="{PACKAGE}/relationships"><Relationship Id="rId1" '
        f'Type="{OFFICE}/officeDocument" Target="xl/workbook.xml"/></Relationships>',
        "xl/workbook.xml": f'<workbook xmlns="{MAIN}" xmlns:r="{OFFICE}"><sheets>{listed}</sheets></workbook>',
        "xl/_rels/workbook.xml.rels": f'<Relationships xmlns="{PACKAGE}/relationships">{related}'
        f'<Relationship Id="rIdS" Type="{OFFICE}/styles" Target="styles.xml"/></Relationships>',
        "xl/styles.xml": f'<styleSheet xmlns="{MAIN}"><numFmts count="1"><numFmt numFmtId="164" '
        'formatCode="[h]:mm:ss.0"/></numFmts><cellXfs count="4"><xf numFmtId="0"/><xf numFmtId="22"/>'
        '<xf numFmtId="164"/><xf numFmtId="21"/></cellXfs></styleSheet>',
    }
    for number, rows in enumerate(sheets.values(), 1):
        members[f"xl/worksheets/sheet{number}.xml"] = (
            f'<worksheet xmlns="{MAIN}"><sheetData>{"".join(map(_xlsx_row, range(1, len(rows) + 1), rows))}'
            "</sheetData></worksheet>"
        )
    return zipped(members)


def _xlsx_row(number: int, cells: Sequence[Cell]) -> str:
    found = (_xlsx_cell(f"{chr(ord('A') + column)}{number}", cell) for column, cell in enumerate(cells))
    return f'<row r="{number}">{"".join(found)}</row>'


def _xlsx_cell(ref: str, cell: Cell) -> str:
    if cell is None:
        return ""
    if isinstance(cell, Xml):
        return cell.replace("{ref}", ref)
    if isinstance(cell, str):
        return f'<c r="{ref}" t="inlineStr"><is><t>{escape(cell)}</t></is></c>'
    return f'<c r="{ref}"><v>{cell!r}</v></c>'


def ods(sheets: Mapping[str, Rows]) -> bytes:
    """An OpenDocument spreadsheet."""
    tables = "".join(
        f'<table:table table:name="{escape(name)}">{"".join(map(_ods_row, rows))}</table:table>'
        for name, rows in sheets.items()
    )
    names = " ".join(
        f'xmlns:{short}="urn:oasis:names:tc:opendocument:xmlns:{short}:1.0"' for short in ("office", "table", "text")
    )
    kind = "application/vnd.oasis.opendocument.spreadsheet"
    manifest = "urn:oasis:names:tc:opendocument:xmlns:manifest:1.0"
    return zipped(
        {
            "mimetype": kind,
            "META-INF/manifest.xml": f'<manifest:manifest xmlns:manifest="{manifest}">'
            f'<manifest:file-entry manifest:full-path="/" manifest:media-type="{kind}"/></manifest:manifest>',
            "content.xml": f"<office:document-content {names}><office:body><office:spreadsheet>{tables}"
            "</office:spreadsheet></office:body></office:document-content>",
        }
    )


def _ods_row(cells: Sequence[Cell]) -> str:
    return f"<table:table-row>{''.join(map(_ods_cell, cells))}</table:table-row>"


def _ods_cell(cell: Cell) -> str:
    if cell is None:
        return "<table:table-cell/>"
    if isinstance(cell, Xml):
        return cell
    if isinstance(cell, str):
        return f'<table:table-cell office:value-type="string"><text:p>{escape(cell)}</text:p></table:table-cell>'
    return f'<table:table-cell office:value-type="float" office:value="{cell!r}"><text:p>~</text:p></table:table-cell>'


def xls(sheets: Mapping[str, Rows]) -> bytes:
    """A BIFF8 stream of one or more sheets in an OLE2 file of 512-byte sectors."""
    bodies = [_biff_sheet(rows) for rows in sheets.values()]
    bound = [struct.pack("<HBB", 0, len(name), 0) + name.encode("latin-1") for name in sheets]
    start = len(_record(0x809, bytes(16)) + _record(0xA, b"")) + sum(len(name) + 4 + 4 for name in bound)
    stream = _bof(0x0005)
    for name, body in zip(bound, bodies, strict=True):
        stream += _record(0x85, struct.pack("<I", start) + name)
        start += len(body)
    return _ole2(stream + _record(0xA, b"") + b"".join(bodies))


def _record(kind: int, data: bytes) -> bytes:
    return struct.pack("<HH", kind, len(data)) + data


def _bof(kind: int) -> bytes:
    return _record(0x809, struct.pack("<HHHHII", 0x0600, kind, 0x0DBB, 0x07CC, 0, 6))


def _biff_sheet(rows: Rows) -> bytes:
    width = max(map(len, rows))
    body = _bof(0x0010) + _record(0x200, struct.pack("<IIHHH", 0, len(rows), 0, width, 0))
    for y, cells in enumerate(rows):
        for x, cell in enumerate(cells):
            place = struct.pack("<HHH", y, x, 0)
            if isinstance(cell, str):
                body += _record(0x204, place + struct.pack("<HB", len(cell), 1) + cell.encode("utf-16-le"))
            elif cell is not None:
                body += _record(0x203, place + struct.pack("<d", cell))
    return body + _record(0xA, b"")


def _ole2(stream: bytes) -> bytes:
    """One stream in a compound file: header, one sector of the allocation table, one of the directory, the stream."""
    size = max(len(stream), 4096)
    sectors = -(-size // 512)
    chain = [*range(3, 2 + sectors), 0xFFFFFFFE]
    table = struct.pack("<128I", 0xFFFFFFFD, 0xFFFFFFFE, *chain, *[0xFFFFFFFF] * (126 - sectors))
    header = struct.pack(
        "<8s16xHHHHH6xIIIIIIIII",
        b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1",
        *(0x3E, 3, 0xFFFE, 9, 6),
        *(0, 1, 1, 0, 4096, 0xFFFFFFFE, 0, 0xFFFFFFFE, 0),
    ) + struct.pack("<109I", 0, *[0xFFFFFFFF] * 108)
    entries = _entry("Root Entry", 5, 0xFFFFFFFE, 0, child=1) + _entry("Workbook", 2, 2, size) + bytes(256)
    return header + table + entries + stream.ljust(sectors * 512, b"\0")


def _entry(name: str, kind: int, start: int, size: int, child: int = 0xFFFFFFFF) -> bytes:
    written = (name + "\0").encode("utf-16-le")
    return struct.pack(
        "<64sHBBIII16xI8x8xIQ", written, len(written), kind, 1, 0xFFFFFFFF, 0xFFFFFFFF, child, 0, start, size
    )


def mat(variables: Mapping[str, Any]) -> bytes:
    """Make a MAT-file as MATLAB 7 saves it, always with the same date."""
    from scipy.io import savemat

    content = io.BytesIO()
    savemat(content, dict(variables), do_compression=True, oned_as="column")
    return content.getvalue()[:20].ljust(116) + content.getvalue()[116:]


def tdms(*segments: Mapping[str, Mapping[str, tuple[Any, Mapping[str, Any]]]], **properties: Any) -> bytes:
    """A TDMS file: for each segment the groups with channels, each of values and properties."""
    from nptdms import ChannelObject, RootObject, TdmsWriter

    out = io.BytesIO()
    with TdmsWriter(out) as writer:
        for groups in segments:
            channels = [
                ChannelObject(group, name, values, said)
                for group, named in groups.items()
                for name, (values, said) in named.items()
            ]
            writer.write_segment([RootObject(properties), *channels])
    return out.getvalue()


MANIFEST = {
    "schema": "tribopipe.run/1",
    "id": "bare",
    "started": "2006-03-01T09:30:00+01:00",
    "operator": "N. N.",
    "conditions": {"normal_load": "200 mN", "sliding_speed": "400 mm/s", "relative_humidity": "45 %", "medium": "air"},
    "signals": [{"file": "signals.csv"}],
}


def archived(folder: Path, rows: int = 3) -> bytes:
    """A run as tribopipe archives it: time and depth measured, sliding distance derived, two extra columns."""
    time = np.arange(rows) * 0.5
    remarks = np.array(["a", "ä", ""] * rows, dtype=object)[:rows]
    run = RawRun(
        RunManifest.model_validate(MANIFEST),
        {"time": time, "sliding_distance": 0.4 * time, "depth": 1e-6 * time, "temperature": 296.15 + 0 * time},
        {
            "time": "measured",
            "sliding_distance": "derived from nominal speed",
            "depth": "measured",
            "temperature": "measured",
        },
        {
            "Spin": ExtraColumn(time + 3, "rpm"),
            "Remark": ExtraColumn(remarks),
        },
        {"signals.csv": "Time [s];Depth [um]\n"},
        (SourceFile("run.toml", b"id"), SourceFile("signals.csv", b"Time [s];Depth [um]\n0;0\n")),
    )
    archive = Archive(folder)
    archive.add(run)
    (path,) = folder.glob("*.h5")
    return path.read_bytes()

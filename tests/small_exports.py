"""Small files of several vendors, written byte by byte, and what holds for any of them when it is cut."""

import re

import numpy as np

from tribopipe.base.errors import ReaderError
from tribopipe.readers.reader import Hints, Reader, ReadTable
from tribopipe.results.run import SourceFile

TRB3 = (
    b"\xef\xbb\xbf"
    + (
        "Time [s]\tDistance [m]\tLaps\tSequence ID\tCycle ID\tMax Linear Speed [m/s]\tNominal Load [N]\tµ\t"
        "Angle [°]\tFriction Force [N]\tTemperature [°C]\tHumidity [%]\tPenetration Depth [µm]\r\n"
        "0.10\t0.010\t0.00\t1\t1\t0.1\t5\t0.1532\t1.5\t0.766\t23.1\t44.0\t0.012\r\n"
        "0.20\t0.020\t0.01\t1\t1\t0.1\t5\t0.1611\t21.0\t0.8055\t23.1\t44.1\t-0.5\r\n"
        "0.30\t0.030\t0.02\t1\t2\t0.1\t5\t0.17\t40.25\t0.85\t23.2\t-1064.6\t1.125\r\n"
    ).encode()
)
TRIMMED = (
    b"Time \tDistance\t Laps\t mu\tFrictionForce\r\n"
    b"0,05\t 0,001\t0,00\t0,153 \t0,765\r\n"
    b"0,15\t 0,002\t0,01\t0,16 \t0,8\r\n"
    b"1\t 0,012\t0,02\t-0,171\t-0,8554\r\n"
)
T11 = (
    b"Time [s];Friction force [N];Displacement [um];Temperature2 [C];Temperature1 [C];Rotational speed [rpm];"
    b"Number of revolutions\r\n"
    b"0,0;1,25;0,0;22,5;23,125;0;0;\r\n"
    b"0,5;1,5;0,75;22,5;23,25;120;1;\r\n"
    b"1,0;0;1,5;22,75;23,5;120;2;\r\n"
)
KYOWA = (
    '"ID番号","PCD-400A"\r\n'
    '"タイトル","摩擦試験 No.3"\r\n'
    '"試験日時","2019/06/03","14:05:33"\r\n'
    '"測定CH数",2\r\n'
    '"デジタル入力","OFF"\r\n'
    '"サンプリング周波数(Hz)",100\r\n'
    '"集録データ数/CH",3\r\n'
    '"測定時間(sec)",0.03\r\n'
    '"CH名称","",""\r\n'
    '"CH No","CH1","CH2"\r\n'
    '"測定モード","ひずみ","ひずみ"\r\n'
    '"レンジ",10000,10000\r\n'
    '"校正係数",0.0125,0.0132\r\n'
    '"オフセット",0,0\r\n'
    '"ローパス",30\r\n'
    '"単位","g","g"\r\n'
    '"Time(sec)","CH1","CH2"\r\n'
    "0.00,1.25,-500.5\r\n"
    "0.01,1.375,-501\r\n"
    "0.02,-1.5,-499.875\r\n"
).encode("cp932")
FRAMES = b"<STX>   0.000KG <CR><LF>\n<STX>   0.072KGM<CR><LF>\n<STX>  -0.458KGM<CR><LF>\n"
NEWPORT = (
    b"0.050\t0.001\t0.700\t10.000\t2.500\t0.400\t0.000\t1.000\t60.000\t500.000\t10.000\t5000.000\t10.000\t10.000\t"
    b"10.000\t-10.000\r\n"
    b"12.035800;0.048575;-0.130228;-0.000320;499.720000;0.088757;0.050000\r\n"
    b"0.135000;0.148945;-0.133837;0.001561;495.790000;0.889057;0.050000\r\n"
    b"0.234400;0.249178;2.506000;0.001545;-491.740000;1.000837;0.050000\r\n"
)
WINDUCOM = b"          TIME;          FF;\r        0,9150;        4,80;;\r        1,8240;       16,13;;\r"
RTEC = (
    b"Step, Timestamp, RecipeStep, DAQ.Fz (N),DAQ.Fx (N),DAQ.COF (),\r\n1,0.01,1,5.1,0.5,0.1,\n1,0.02,1,5.2,0.6,0.12,\n"
)
UMT = (
    b"Created by CETR Data Viewer ver. 1.1\r\nStep No. 1\r\nFx,Fz,Z,T,Ff,COF\r\ng,g,mm,sec,g,\r\n\r\n"
    b"1.5,-500.1,0.1,0.01,1.5,0.003\r\n1.6,-500.2,0.1,0.02,1.6,0.0032\r\n"
)
PLAIN = b"Time [s],Fx [N],mu\n0.5,1.5,0.3\n1.0,1.6,0.32\n"
PROSE = "Läufe vom 3. Mai, 12 Stück.\nDavon 3 ohne Ergebnis.\n".encode("cp1252")

FILES = {
    "anton-paar": TRB3,
    "anton-paar, trimmed": TRIMMED,
    "t-11": T11,
    "kyowa-pcd": KYOWA,
    "load-cell-frames": FRAMES,
    "newport-rheofriction": NEWPORT,
    "winducom": WINDUCOM,
    "rtec": RTEC,
    "umt": UMT,
    "plain": PLAIN,
    "prose": PROSE,
    "empty": b"",
    "blank": b" \r\n\r\n",
    "binary": bytes(range(256)) * 40,
    "png": b"\x89PNG\r\n\x1a\n" + bytes(400),
    "utf-16": "Time;Depth\n1;2\n".encode("utf-16"),
}


def read(reader: Reader, content: bytes, **hints: str) -> ReadTable:
    return reader.read(SourceFile("test.txt", content), Hints(**hints))


def claimed_by(reader: Reader) -> list[str]:
    """Name the small files that a reader takes for its own."""
    return [name for name, content in FILES.items() if reader.match(SourceFile("x", content)).confidence >= 0.5]


ENDS = (b"\r", b"\n")


def check_cut(reader: Reader, content: bytes, size: int, ends: tuple[bytes, ...] = ENDS) -> None:
    """Check that a cut file is refused, or read as the first rows of the whole one, with a note where a row is cut."""
    whole, cut = read(reader, content), content[:size]
    try:
        table = read(reader, cut)
    except ReaderError:
        return
    rows = len(table.columns[0].values)
    for column, complete in zip(table.columns, whole.columns, strict=True):
        assert (column.name, column.unit, column.signal) == (complete.name, complete.unit, complete.signal)
        assert np.array_equal(column.values, complete.values[:rows], equal_nan=column.values.dtype.kind == "f")
    if rows < len(whole.columns[0].values) and not cut.endswith(ends):
        assert any(re.search("omitted|missing|declares", note) for note in table.notes)


def check_every_cut(reader: Reader, content: bytes, *, from_byte: int = 0, ends: tuple[bytes, ...] = ENDS) -> None:
    for size in range(from_byte, len(content)):
        check_cut(reader, content, size, ends)

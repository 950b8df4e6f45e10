"""Decoding of text files, and splitting into lines and rows of fields, for any encoding, line end and separator."""

import codecs
import csv
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import islice
from typing import NamedTuple

from tribopipe.base.errors import ReaderError
from tribopipe.results.run import SourceFile

BLANKS = " "
"""Separator that stands for any run of spaces and tabs."""
MOST_COLUMNS = 1000
SAMPLE_BYTES = 1 << 19
SAMPLE_LINES = 300
LONGEST_LINE = 1 << 17
_CONTROLS = bytes(set(range(32)) - set(b"\t\n\v\f\r\x1a\x1b"))
_EASTERN = {
    "gb18030": ("时间", "摩擦", "载荷", "磨损", "速度"),
    "cp932": ("時間", "摩擦", "荷重", "摩耗", "速度"),
    "big5": ("時間", "摩擦", "荷重", "磨損", "速度"),
    "cp949": ("시간", "마찰", "하중", "마모", "속도"),
}
"""Words of tribometers that show a Chinese, Japanese or Korean encoding."""
_NO_CHARSETS = ("unicode-escape", "raw-unicode-escape", "idna", "punycode")
"""Python codecs for text in ASCII that emit warnings or take quadratic time."""
LINE_END = re.compile(rb"\r\n?|\n")
_LINE = re.compile(r"[^\r\n]*(?:\r\n|\r|\n)|[^\r\n]+")


@dataclass(frozen=True)
class Text:
    """A file as UTF-8, whatever it was before."""

    name: str
    """Name of the file."""
    content: bytes
    start: int = 0
    """Offset of the first byte of text, after a byte order mark."""
    partial: bool = False
    """Whether this is only the beginning of the file."""
    notes: tuple[str, ...] = ()
    """Notes to the user about the encoding."""

    @property
    def unterminated(self) -> bool:
        """Whether the last line has no line end."""
        return not self.partial and not self.content.endswith((b"\r", b"\n"))


def decode(source: SourceFile, encoding: str | None = None, *, partial: bool = False) -> Text:
    """Decode a file by the encoding named, or find it.

    Raises ``ReaderError`` where the file is empty or binary, where the encoding is unknown, or where
    the file is not in it.
    """
    if not source.content:
        raise ReaderError(
            f"{source.name}: found an empty file; expected a header row and data rows; "
            "copy it again from the instrument"
        )
    encoding = encoding or _utf16(source.content)
    text = _guessed(source, partial) if encoding is None else _as_named(source, encoding, partial)
    _refuse_binary(text)
    return text


def _utf16(content: bytes) -> str | None:
    """Recognise UTF-16 by its byte order mark, or by the zeros in the codes of ASCII letters."""
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    head = content[:4096]
    for encoding, zeros in (("utf-16-le", head[1::2]), ("utf-16-be", head[::2])):
        if zeros.count(0) > 0.6 * len(zeros):
            return encoding
    return None


def _guessed(source: SourceFile, partial: bool) -> Text:
    content = source.content
    start = len(codecs.BOM_UTF8) if content.startswith(codecs.BOM_UTF8) else 0
    try:
        if not content.isascii():
            _strictly(content, "utf-8", partial)
    except UnicodeDecodeError as error:
        cut = error.reason == "unexpected end of data" and not content[: error.start].isascii()
        if start or cut:
            raise _undecodable(source.name, "utf-8", error) from None
        return _eastern(source, partial) or _western(source, partial)
    return Text(source.name, content, start, partial)


def eastern_encoding(head: bytes) -> str | None:
    """Recognize a Chinese, Japanese or Korean encoding by a word of tribometers; none where there is no such word."""
    found = (name for name, words in _EASTERN.items() if any(word.encode(name) in head for word in words))
    return next(found, None)


def _eastern(source: SourceFile, partial: bool) -> Text | None:
    encoding = eastern_encoding(source.content[:SAMPLE_BYTES])
    if encoding is None:
        return None
    try:
        text = _strictly(source.content, encoding, partial)
    except UnicodeDecodeError:
        return None
    return Text(source.name, text.encode(), 0, partial, (guessed_note(encoding),))


def _western(source: SourceFile, partial: bool) -> Text:
    try:
        encoding, text = "cp1252", _strictly(source.content, "cp1252", partial)
    except UnicodeDecodeError:
        encoding, text = "latin-1", _strictly(source.content, "latin-1", partial)
    return Text(source.name, text.encode(), 0, partial, (guessed_note(encoding),))


def guessed_note(encoding: str) -> str:
    """Report in which encoding a file was read that is not UTF-8."""
    return f"read as {encoding}, since it is not UTF-8; specify the encoding in run.toml if characters are wrong"


def _as_named(source: SourceFile, encoding: str, partial: bool) -> Text:
    try:
        if codecs.lookup(encoding).name in _NO_CHARSETS:
            raise LookupError
        "".encode(encoding)
    except (LookupError, ValueError):
        raise ReaderError(
            f"{source.name}: found the unknown encoding {encoding!r} in run.toml; expected an encoding such as "
            "'utf-8', 'cp1252' or 'shift_jis'; correct it"
        ) from None
    try:
        text = _strictly(source.content, encoding, partial).removeprefix("\ufeff")
        return Text(source.name, text.encode(), 0, partial)
    except UnicodeError as error:
        raise _undecodable(source.name, encoding, error) from None


def _strictly(content: bytes, encoding: str, partial: bool) -> str:
    return codecs.getincrementaldecoder(encoding)().decode(content, final=not partial)


def _undecodable(name: str, encoding: str, error: UnicodeError) -> ReaderError:
    where = f"byte {error.start}" if isinstance(error, UnicodeDecodeError) else "a character"
    return ReaderError(
        f"{name}: found {where}, which is not {encoding}; expected the entire file in that encoding; copy "
        "it again from the instrument, or specify its encoding in run.toml"
    )


def _refuse_binary(text: Text) -> None:
    zero = text.content.find(b"\0")
    head = text.content[:LONGEST_LINE]
    controls = len(head) - len(head.translate(None, _CONTROLS))
    if zero < 0 and controls <= len(head) // 100:
        return
    found = f"a zero byte at offset {zero}" if zero >= 0 else f"{controls} control characters"
    raise ReaderError(
        f"{text.name}: found {found}; expected text; export the table as text, or specify the reader for this format "
        f"in run.toml"
    )


class Row(NamedTuple):
    """One line split into fields; several lines where a quoted field holds line ends."""

    line: int
    """Number of the first line, counted from 1."""
    cells: list[str]


def sample_lines(text: Text) -> list[str]:
    """Return the first complete lines with their line ends, up to a few hundred.

    Raises ``ReaderError`` where there is nothing but blanks, or a line too long for a table.
    """
    lines, rest = lines_from(text, text.start)
    for number, line in enumerate([*lines, rest], 1):
        if len(line) > LONGEST_LINE:
            raise ReaderError(
                f"{text.name}, line {number}: found more than {LONGEST_LINE:,} characters in one line; expected a "
                f"table of at most {MOST_COLUMNS} columns; check that this file is a table and that its line endings "
                "are intact"
            )
    if not rest and len(lines) < SAMPLE_LINES and all(map(str.isspace, lines)):
        raise ReaderError(
            f"{text.name}: found only whitespace; expected a header row and data rows; copy the "
            "file again from the instrument"
        )
    return lines


def lines_from(text: Text, start: int) -> tuple[list[str], str]:
    """Give a sample of lines, and the beginning of the next one where it may be cut."""
    block = text.content[start : start + SAMPLE_BYTES]
    found = _LINE.finditer(block.decode(errors="ignore"))
    lines = [line[0] for line in islice(found, SAMPLE_LINES + 1)]
    at_end = not text.partial and start + len(block) == len(text.content)
    rest = "" if at_end or len(lines) > SAMPLE_LINES or not lines else lines.pop()
    return lines[:SAMPLE_LINES], rest


def split_rows(lines: Iterable[str], separator: str) -> Iterator[Row]:
    """Split lines into fields stripped of blanks, leaving out blank lines: those of spaces and tabs, as for pandas.

    Raises ``csv.Error`` where a quoted field runs on without end.
    """
    if separator == BLANKS:
        for number, line in enumerate(lines, 1):
            if line.strip(" \t\r\n"):
                yield Row(number, re.split(r"[ \t]+", line.strip(" \t\r\n")))
        return
    reader = csv.reader(lines, delimiter=separator, skipinitialspace=True)
    number = 1
    for fields in reader:
        if len(fields) > 1 or any(field.strip(" \t\r\n") for field in fields):
            yield Row(number, [field.strip() for field in fields])
        number = reader.line_num + 1


def sampled_rows(lines: list[str], separator: str) -> list[Row]:
    """Split lines of a sample into rows; none where a quoted field runs on without end."""
    try:
        return list(split_rows(lines, separator))
    except csv.Error:
        return []


def trimmed(cells: Iterable[str]) -> list[str]:
    """Leave out empty fields at the end."""
    kept = list(cells)
    while kept and not kept[-1]:
        del kept[-1]
    return kept

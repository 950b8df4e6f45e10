"""Delimited text that is longer than memory should hold: read block by block, each by the code that reads a whole file.

A file is gone through once to see whether it can be read so, and what holds for all of it: its encoding, its SHA-256,
how many lines it has. Its layout is found on its beginning and its end. Then its body comes in blocks of whole lines,
as often as it is asked for. What cannot be cut into blocks is read whole: UTF-16, texts in encodings that few use,
quoted fields over the ends of lines, and lines that end in lone carriage returns.
"""

import codecs
import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from tribopipe.base.errors import ReaderError
from tribopipe.base.files import pieces_of
from tribopipe.readers.delimited import has_rows, read_table, without_closing_words
from tribopipe.readers.layout import Layout, find_layout
from tribopipe.readers.reader import Hints, ReadTable
from tribopipe.readers.text import LONGEST_LINE, SAMPLE_BYTES, Text, decode, eastern_encoding, guessed_note
from tribopipe.results.run import SourceFile, UnheldSource

LARGE = 256 << 20
"""Bytes from which a file, or consecutive files together, are read block by block."""
PIECE = 8 << 20
"""Bytes of a block."""
HEAD = 2 * SAMPLE_BYTES
"""Bytes at the beginning on which the layout is found."""
TAIL = LONGEST_LINE
"""Bytes at the end that stay together, in which words may stand below the table."""
_ENCODINGS = {"utf-8": "utf-8", "utf-8-sig": "utf-8", "cp1252": "cp1252", "iso8859-1": "latin-1"}
"""Encodings in which a line end is a line end wherever it stands, by their names in Python."""
READER = "delimited"
"""Name of the reader whose files can be read so."""
_NOT_ASCII = bytes(range(128))
_UNDEFINED_IN_CP1252 = frozenset(b"\x81\x8d\x8f\x90\x9d")

Words = dict[int, tuple[int, str]]
"""Columns that hold words, by their numbers, each with line and text of the first."""


class OtherWords(Exception):  # noqa: N818 - no error, but a reason to begin again
    """A block holds words in columns that were numbers so far; ``found`` are all such columns."""

    def __init__(self, found: Words) -> None:
        super().__init__()
        self.found = found


def _unchanged(path: Path, name: str, sha256: str) -> Iterator[bytes]:
    """Give the bytes of a file in pieces. Raises ``ReaderError`` where they turn out to be others than before."""
    found = hashlib.sha256()
    try:
        for piece in pieces_of(path, PIECE):
            found.update(piece)
            yield piece
    except OSError as error:
        raise ReaderError(
            f"{name}: cannot be read ({error.strerror}); expected a readable file; check its permissions"
        ) from None
    if found.hexdigest() != sha256:
        raise changed(name)


def changed(name: str) -> ReaderError:
    """Report that a file is not what it was when it was first gone through."""
    return ReaderError(
        f"{name}: found a file that changed while it was read; expected a file that does not change; try again "
        "after the test has ended"
    )


class _Survey:
    """Properties of a file found in one pass over its bytes."""

    def __init__(self) -> None:
        self.size = self.lines = 0
        self.sha256 = hashlib.sha256()
        self.head = self.tail = b""
        self.streams = True
        """Whether it can be cut at its line ends."""
        self._utf8 = codecs.getincrementaldecoder("utf-8")()
        self._is_utf8 = True
        self._others: set[int] = set()
        self._quoted = False
        self._since_end = 0

    def see(self, piece: bytes) -> None:
        self.sha256.update(piece)
        self.size += len(piece)
        self.head += piece[: HEAD - len(self.head)]
        self.tail = (self.tail + piece)[-TAIL:]
        ends = piece.count(b"\n")
        self.lines += ends
        self._since_end = len(piece) - piece.rfind(b"\n") - 1 if ends else self._since_end + len(piece)
        self.streams &= b"\0" not in piece and self._since_end <= LONGEST_LINE and self._quotes_close(piece)
        self._decode(piece)

    def _quotes_close(self, piece: bytes) -> bool:
        """Return whether no line ends within quotes."""
        if not self._quoted and b'"' not in piece:
            return True
        codes = np.frombuffer(piece, np.uint8)
        within = np.logical_xor.accumulate(codes == ord('"')) ^ self._quoted
        self._quoted = bool(within[-1])
        return not np.any(within & ((codes == ord("\n")) | (codes == ord("\r"))))

    def _decode(self, piece: bytes) -> None:
        if piece.isascii() and not self._utf8.getstate()[0]:
            return
        self._others |= set(piece.translate(None, _NOT_ASCII))
        if self._is_utf8:
            try:
                self._utf8.decode(piece)
            except UnicodeDecodeError:
                self._is_utf8 = False
                self._utf8.reset()

    def encoding(self, named: str | None) -> str | None:
        """Return the encoding as ``decode`` finds it; none where that is not for blocks, or the file may be broken."""
        marked = self.head.startswith(codecs.BOM_UTF8)
        whole = self._is_utf8 and not self._utf8.getstate()[0]
        if named is not None:
            found = _ENCODINGS.get(_python_name(named))
            odd = (found == "utf-8" and not whole) or (found == "cp1252" and self._others & _UNDEFINED_IN_CP1252)
            return None if odd else found
        if whole or not self._others:
            return "utf-8"
        if marked or self._is_utf8 or eastern_encoding(self.head[:SAMPLE_BYTES]):
            return None
        return "latin-1" if self._others & _UNDEFINED_IN_CP1252 else "cp1252"


def _python_name(encoding: str) -> str:
    try:
        return codecs.lookup(encoding).name
    except (LookupError, ValueError):
        return ""


def long_text(path: Path, name: str, hints: Hints) -> "LongText | None":
    """Go through a file once; none where it has to be read whole.

    Raises ``OSError`` where it cannot be read, and ``ReaderError`` where it is no table.
    """
    survey = _Survey()
    for piece in pieces_of(path, PIECE):
        survey.see(piece)
    encoding = survey.encoding(hints.encoding)
    if not survey.streams or encoding is None:
        return None
    decode(SourceFile(name, survey.head), hints.encoding, partial=survey.size > HEAD)  # refuses what is no text
    marked = encoding == "utf-8" and survey.head.startswith(codecs.BOM_UTF8)
    ends = _both_ends(survey)[len(codecs.BOM_UTF8) if marked else 0 :]
    layout = find_layout(Text(name, ends.decode(encoding).encode()), hints)
    sha256 = survey.sha256.hexdigest()
    return LongText(
        source=UnheldSource(name, survey.size, sha256, partial(_unchanged, path, name, sha256)),
        encoding=encoding,
        layout=layout,
        start=len(layout.header.encode(encoding)) + (len(codecs.BOM_UTF8) if marked else 0),
        most_rows=survey.lines + (not survey.tail.endswith(b"\n")) - (layout.line - 1),
        note=() if encoding == "utf-8" or hints.encoding else (guessed_note(encoding),),
    )


def _both_ends(survey: _Survey) -> bytes:
    """Return the whole lines at the beginning and at the end of a file, or all of a short one."""
    behind = survey.size - len(survey.head)
    if not behind:
        return survey.head
    tail = survey.tail[-behind:]
    return survey.head[: survey.head.rfind(b"\n") + 1] + tail[tail.find(b"\n") + 1 :]


@dataclass(frozen=True)
class LongText:
    """A file of delimited text that is never held whole."""

    source: UnheldSource
    encoding: str
    layout: Layout
    start: int
    """Byte at which the body begins."""
    most_rows: int
    """Rows it has, or more where lines are blank."""
    note: tuple[str, ...] = ()
    """Notes to the user about the encoding."""

    @property
    def unnamed(self) -> set[str]:
        """How columns are called that the header leaves without a name."""
        return {f"column {number}" for number, name in enumerate(self.layout.names, 1) if not name}

    def tables(self, words: Words) -> Iterator[ReadTable]:
        """Give the rows block by block, with the same columns in each; those in ``words`` are texts.

        Raises ``OtherWords`` where a later block has words in other columns, too, and ``ReaderError`` as the reader of
        a whole file does.
        """
        begun, line = False, self.layout.line
        for block, last in self._blocks():
            text = self._text(block, partial=not last)
            layout = replace(self.layout, line=line, header="", words=frozenset(words))
            line += _lines(text.content)
            left_out: list[str] = []
            if last:
                text, left_out = without_closing_words(text, layout)
            if not has_rows(text, layout):
                continue
            table = read_table(text, layout, keep_empty=True)
            words = _with_words(words, table, begun=begun)
            begun = True
            columns = tuple(replace(column, first_bad=words.get(n)) for n, column in enumerate(table.columns))
            yield ReadTable(columns, self.layout.header, (*self.note, *table.notes, *left_out), decimal=table.decimal)

    def _text(self, block: bytes, *, partial: bool) -> Text:
        content = block if self.encoding == "utf-8" else block.decode(self.encoding).encode()
        return Text(self.source.name, content, partial=partial)

    def _blocks(self) -> Iterator[tuple[bytes, bool]]:
        """Yield the body in complete lines, and whether the block is the last one, with the end of the file."""
        rest, before, left = b"", self.start, self.source.size
        for piece in self.source.pieces():
            left -= len(piece)
            skipped, before = min(before, len(piece)), max(before - len(piece), 0)
            rest += piece[skipped:]
            cut = rest.rfind(b"\n") + 1
            if cut and left > TAIL:
                yield rest[:cut], False
                rest = rest[cut:]
        yield rest, True


def _with_words(words: Words, table: ReadTable, *, begun: bool) -> Words:
    """Add the columns in which a block has words. Raises ``OtherWords`` where blocks before it had numbers there."""
    found = {number: column.first_bad for number, column in enumerate(table.columns) if column.first_bad}
    new = {number: bad for number, bad in found.items() if number not in words}
    if new and begun:
        raise OtherWords(words | new)
    return words | new


def _lines(content: bytes) -> int:
    ends = content.count(b"\n")
    return ends + content.count(b"\r") - content.count(b"\r\n") if b"\r" in content else ends

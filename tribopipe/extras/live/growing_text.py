"""A file of delimited text that grows: what was appended, by the code that reads a whole file."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ReaderError
from tribopipe.documents.manifest import SignalFile
from tribopipe.documents.signals import SignalName
from tribopipe.readers.column_mapping import Arms, Meanings, hints_of, meanings_in, part_of
from tribopipe.readers.delimited import has_rows, read_table, without_closing_words
from tribopipe.readers.layout import Layout, find_layout
from tribopipe.readers.registry import detect
from tribopipe.readers.text import LONGEST_LINE, SAMPLE_BYTES, Text, decode
from tribopipe.results.run import SourceFile

_PIECE = 8 << 20
"""Bytes that are read at a time."""
_KNOWN_BY = 4096
"""Bytes at the beginning, and before where reading goes on, by which a file is known again."""
_FORMAT = "delimited"
_FEWEST_ROWS = 20
"""By which the head of a file is understood."""


class GrowingText:
    """The lines of a file so far, and the beginning of the next one."""

    def __init__(self, signals: SignalFile, arms: Arms) -> None:
        self._signals, self._name, self._arms = signals, signals.names[0], arms
        self.is_foreign = False
        """Whether it is no text of lines that can be read as it grows."""
        self._begin()

    def _begin(self) -> None:
        self._read = self._rows = self._lines = 0
        self._head = self._tail = self._waiting = b""
        self._layout: Layout | None = None
        self._meanings: Meanings = {}

    def begins_anew(self, path: Path) -> bool:
        """Return whether a file is another one than was read so far, or was cut; it is then read from its beginning."""
        with path.open("rb") as file:
            known = file.read(len(self._head)) == self._head
            file.seek(self._read - len(self._tail))
            known = known and file.read(len(self._tail)) == self._tail
        if not known:
            self._begin()
        return not known

    def appended(self, path: Path) -> Iterator[dict[SignalName, Column]]:
        """Give the signals of the lines that have come, in SI. Raises ``ReaderError`` where they are broken."""
        with path.open("rb") as file:
            file.seek(self._read)
            while (piece := file.read(_PIECE)) and not self.is_foreign:
                self._note(piece)
                yield from self._taken(piece)

    def _note(self, piece: bytes) -> None:
        self._read += len(piece)
        self._head += piece[: _KNOWN_BY - len(self._head)]
        self._tail = (self._tail + piece)[-_KNOWN_BY:]

    def _taken(self, piece: bytes) -> Iterator[dict[SignalName, Column]]:
        """Yield the signals of complete lines; incomplete lines, or lines before a known header, are kept for later."""
        self._waiting += piece
        whole = self._waiting[: self._waiting.rfind(b"\n") + 1]
        layout = self._layout or self._understood(whole)
        if layout is None or not whole:
            self.is_foreign = self.is_foreign or len(self._waiting) > len(whole) + LONGEST_LINE
            return
        text = decode(self._source(whole), self._signals.encoding)
        head = layout.header.encode()
        body = text.content[text.start + (len(head) if self._layout is None else 0) :]
        self._layout, self._waiting = layout, self._waiting[len(whole) :]
        rows = Text(self._name, head + body)
        if has_rows(rows, layout):
            yield self._signals_of(rows, replace(layout, line=layout.line + self._lines))
        self._lines += body.count(b"\n")

    def _signals_of(self, rows: Text, layout: Layout) -> dict[SignalName, Column]:
        table = read_table(without_closing_words(rows, layout)[0], layout)
        self._meanings = self._meanings or meanings_in(table, self._signals, self._name)
        columns = part_of(table, self._meanings, self._name, self._rows, self._arms).columns
        self._rows += len(next(iter(columns.values())))
        return columns

    def _understood(self, content: bytes) -> Layout | None:
        """Find the layout once there are enough rows for it; none before, and none of any other format."""
        try:
            text = decode(self._source(content), self._signals.encoding)
            layout = find_layout(text, hints_of(self._signals))
        except ReaderError:
            self.is_foreign = self._is_another(content) or len(content) > SAMPLE_BYTES
            return None
        if text.content.count(b"\n", text.start + len(layout.header.encode())) < _FEWEST_ROWS:
            return None
        self.is_foreign = b"\0" in content[:_KNOWN_BY] or self._is_another(content)
        return None if self.is_foreign else layout

    def _is_another(self, content: bytes) -> bool:
        if self._signals.reader is not None or self._signals.separator is not None:
            return False
        try:
            return detect(self._source(content), holds="signals").name != _FORMAT
        except ReaderError:
            return False

    def _source(self, content: bytes) -> SourceFile:
        return SourceFile(self._name, content)

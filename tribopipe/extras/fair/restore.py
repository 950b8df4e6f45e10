"""The way back: archived runs and studies taken out of a crate, byte for byte, into an archive.

A crate, folder or zip, is read as somebody sent it: its files are read as if somebody meant harm.
"""

import hashlib
import os
import re
import stat
import struct
import zlib
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path, PurePosixPath
from typing import IO, Any, Literal, NamedTuple
from urllib.parse import unquote
from zipfile import BadZipFile, ZipFile, ZipInfo

import orjson

from tribopipe.archive.file_signature import STUDIES, SUFFIX
from tribopipe.archive.store import Archive
from tribopipe.base.errors import ArchiveError, TribopipeError
from tribopipe.base.files import clear_leftovers_of, leads_out, write_file
from tribopipe.documents.dataset import DATASET_NAME, Dataset
from tribopipe.documents.record import read_document
from tribopipe.documents.toml import parse_toml
from tribopipe.extras.fair.graph import ARCHIVE, DATASET, METADATA

_MOST_METADATA = 40 << 20
"""Bytes, of which Python makes four of each where one character is beyond 16 bits."""
_MOST_PARTS = 3_000_000
"""Signs of JSON between its values, which take 350 MB at most once they are read."""
_MOST_DIRECTORY = 32 << 20
"""Bytes of the list of files of a zip: 300,000 of them."""
_FREE, _MOST_PACKED = 64 << 20, 200
"""Bytes that a packed file may unpack to whatever it is packed in, and so many times its packed size beyond."""
_PIECE = 1 << 20
_END = struct.Struct("<4s4H2LH")
_END_64, _PLACE_OF_SIZE_64 = 56, 40
_BROKEN = (BadZipFile, EOFError, NotImplementedError, RuntimeError, ValueError, zlib.error)
"""Exceptions from a zip that is damaged, encrypted, or compressed with an unsupported method."""


class Member(NamedTuple):
    """A file in a crate."""

    size: int
    open: Callable[[], IO[bytes]]


class Packed:
    """The files of a crate by their path in it."""

    def __init__(self, path: Path, members: dict[str, Member]) -> None:
        self.path = path
        self._members = members

    def __contains__(self, name: str) -> bool:
        return name in self._members

    def metadata(self) -> bytes:
        """Return the crate's metadata. Raises ``ArchiveError`` where there is none, or too much of it."""
        member = self._members.get(METADATA)
        if member is None:
            raise ArchiveError(
                f"{self.path}: found no {METADATA} in it; expected an RO-Crate or a .eln file, packed or unpacked; "
                "specify one of these"
            )
        if member.size > _MOST_METADATA:
            raise self.refused(f"{METADATA} of {member.size:,} bytes", f"at most {_MOST_METADATA:,}")
        with self._read(METADATA) as file:
            content = file.read(_MOST_METADATA)
        parts = sum(content.count(sign) for sign in b"{[:,")
        if parts > _MOST_PARTS:
            raise self.refused(f"{METADATA} of {parts:,} values", f"at most {_MOST_PARTS:,}")
        return content

    def pieces(self, name: str, size: int, sha256: str) -> Iterator[bytes]:
        """Give the bytes of a file in pieces.

        Raises ``ArchiveError`` where there is no such file, or it is not the one that was stated to be there: the last
        piece is given before its SHA-256 is known, so nothing may be made of them until the end.
        """
        member = self._members.get(name)
        if member is None:
            raise self.refused(f"no file {name!r}, which its metadata describes", "every file that it describes")
        if member.size != size:
            raise self.refused(f"{name!r} of {member.size:,} bytes", f"the {size:,} that its metadata states")
        found, left = hashlib.sha256(), size
        with self._read(name) as file:
            while piece := file.read(min(_PIECE, left + 1)):
                left -= len(piece)
                if left < 0:
                    break
                found.update(piece)
                yield piece
        if left or found.hexdigest() != sha256.lower():
            raise self.refused(
                f"{name!r} with content that differs from the packed file",
                "the content recorded by its SHA-256 checksum",
            )

    @contextmanager
    def _read(self, name: str) -> Iterator[IO[bytes]]:
        try:
            with self._members[name].open() as file:
                yield file
        except _BROKEN as error:
            raise self.refused(f"{name!r} damaged or encrypted ({error})", "a file that can be read") from None
        except OSError as error:
            raise ArchiveError(
                f"{self.path}: cannot be read ({error.strerror or error}); expected a readable crate; check its "
                "permissions and that its drive is connected"
            ) from None

    def refused(self, found: str, expected: str) -> ArchiveError:
        """Return the error for a crate that is not what it claims."""
        return ArchiveError(f"{self.path}: found {found}; expected {expected}; download or copy the crate again")


@contextmanager
def packed(path: Path) -> Iterator[Packed]:
    """Open a crate: a folder, a zip, or a .eln. Raises ``ArchiveError`` where it is none of these, or is hostile."""
    if path.is_dir():
        yield Packed(path, dict(_in_folder(path)))
        return
    if not path.is_file():
        raise ArchiveError(f"{path}: found no such file or folder; expected an RO-Crate or a .eln file; check the path")
    with _zip(path) as unpacking:
        yield Packed(path, _in_zip(path, unpacking))


def _in_folder(folder: Path) -> Iterator[tuple[str, Member]]:
    """Give the files of a folder that lie in it; links that lead out of it, pipes and devices are left out."""
    for place, _, names in os.walk(folder):
        for name in names:
            path = Path(place, name)
            if not leads_out(path, folder) and path.is_file():
                yield (
                    path.relative_to(folder).as_posix(),
                    Member(path.stat().st_size, partial(_opened, path)),
                )


def _opened(path: Path) -> IO[bytes]:
    return path.open("rb")


@contextmanager
def _zip(path: Path) -> Iterator[ZipFile]:
    try:
        with path.open("rb") as file:
            if _directory_size(file) > _MOST_DIRECTORY:
                raise ArchiveError(
                    f"{path}: found a file list of more than {_MOST_DIRECTORY:,} bytes; expected a crate of at most "
                    "a few thousand files; unpack the crate, and specify its folder"
                )
            unpacking = ZipFile(file)
            yield unpacking
    except _BROKEN as error:
        raise ArchiveError(
            f"{path}: found a damaged file, or one that is not a zip file ({error}); expected an RO-Crate or a "
            ".eln file; download or copy it again"
        ) from None
    except OSError as error:
        raise ArchiveError(
            f"{path}: cannot be read ({error.strerror or error}); expected a readable crate; check its permissions"
        ) from None


def _directory_size(file: IO[bytes]) -> int:
    """Return how long the list of files at the end of a zip is, bytes, as far as the zip states."""
    length = file.seek(0, os.SEEK_END)
    start = max(length - _END.size - 0xFFFF - _END_64 - 20, 0)
    file.seek(start)
    tail = file.read()
    place = tail.rfind(b"PK\5\6")
    sizes = [_END.unpack_from(tail, place)[5]] if 0 <= place <= len(tail) - _END.size else [0]
    large = tail.rfind(b"PK\6\6")
    if 0 <= large <= len(tail) - _END_64:
        sizes.append(int.from_bytes(tail[large + _PLACE_OF_SIZE_64 : large + _PLACE_OF_SIZE_64 + 8], "little"))
    file.seek(0)
    return max(sizes)


def _in_zip(path: Path, unpacking: ZipFile) -> dict[str, Member]:
    """Return the files of a zip, without the one folder that all of them are in where there is one.

    Raises ``ArchiveError`` where a name leads out of it or stands for two files, or one would unpack to far more than
    it is packed in.
    """
    entries = [entry for entry in unpacking.infolist() if not entry.filename.endswith("/")]
    twice = [name for name, count in Counter(entry.filename for entry in entries).items() if count > 1]
    if twice:
        raise _hostile(path, f"{twice[0]!r} twice", "each file once")
    for entry in entries:
        _refuse_hostile(path, entry)
    root = _root(entry.filename for entry in entries)
    return {
        entry.filename.removeprefix(root): Member(entry.file_size, partial(unpacking.open, entry)) for entry in entries
    }


def _refuse_hostile(path: Path, entry: ZipInfo) -> None:
    name = PurePosixPath(entry.filename)
    if name.is_absolute() or ".." in name.parts or "\\" in entry.filename or ":" in entry.filename:
        raise _hostile(path, f"the path {entry.filename!r}, which is outside the crate", "paths within the crate")
    kind = stat.S_IFMT(entry.external_attr >> 16)
    if kind and not stat.S_ISREG(kind):
        raise _hostile(path, f"a link or a device, {entry.filename!r}", "only files")
    if entry.file_size > _FREE + _MOST_PACKED * entry.compress_size:
        raise _hostile(
            path,
            f"{entry.filename!r}, which unpacks to {entry.file_size:,} bytes from {entry.compress_size:,}",
            f"at most {_MOST_PACKED} times as many",
        )


def _root(names: Iterator[str]) -> str:
    """Return the folder that the metadata lies in, as .eln files have it; nothing where there is none."""
    found = [name.removesuffix(METADATA) for name in names if PurePosixPath(name).name == METADATA]
    shallow = [folder for folder in found if folder.count("/") <= 1]
    return min(shallow, key=len, default="")


def _hostile(path: Path, found: str, expected: str) -> ArchiveError:
    return ArchiveError(f"{path}: found {found}; expected {expected}; do not unpack it unless you trust its source")


_ARCHIVED = re.compile(
    rf"{ARCHIVE}/(?P<study>{STUDIES}/)?(?P<id>[A-Za-z0-9][A-Za-z0-9._+-]{{0,99}}){re.escape(SUFFIX)}"
)
_SHA256 = re.compile(r"[0-9a-fA-F]{64}")
_SIZE = re.compile(r"\d{1,18}")
_MOST_DOCUMENT = 1 << 20


class Held(NamedTuple):
    """A file of a crate, as its metadata describes it."""

    name: str
    """Path in the crate."""
    size: int
    sha256: str


class ArchivedFile(NamedTuple):
    """A run or a study in a crate."""

    id: str
    study: bool
    held: Held


@dataclass
class Restored:
    """Outcome for each run and study of a crate."""

    done: dict[ArchivedFile, Literal["added", "unchanged"]] = field(default_factory=dict)
    failed: dict[ArchivedFile, TribopipeError] = field(default_factory=dict)
    dataset: Path | None = None
    """The dataset.toml that was written next to the archive; None if the crate has none, or one was there."""
    refused_dataset: TribopipeError | None = None
    """Why the crate's dataset.toml was not written."""


def restore(path: Path, archive: Archive, advance: Callable[[str], None] = lambda _: None) -> Restored:
    """Take every run and study of a crate into an archive; what is there already and the same stays.

    One that is damaged, or has the name of another one, is given in ``failed`` and does not stop the others; nor does a
    dataset.toml that cannot be read. Raises ``ArchiveError`` where the crate cannot be read, or holds no archived run.
    """
    found = Restored()
    with packed(path) as crate:
        described = _described(crate)
        files = list(_archived(described))
        if not files:
            raise ArchiveError(
                f"{path}: found no archived run in it; expected a crate written by `tribopipe export`; unpack any "
                "other crate, and use `tribopipe new` with its instrument files"
            )
        for one in files:
            try:
                found.done[one] = _taken(crate, one, archive)
            except TribopipeError as error:
                found.failed[one] = error
            advance(one.id)
        if found.done and DATASET in described:
            try:
                found.dataset = _dataset(crate, described[DATASET], archive)
            except TribopipeError as error:
                found.refused_dataset = error
    return found


def _described(crate: Packed) -> dict[str, Held]:
    """Return the files that the metadata describes with size and SHA-256, by their path."""
    try:
        graph = orjson.loads(crate.metadata())["@graph"]
        entities = [one for one in graph if isinstance(one, dict)]
    except (KeyError, TypeError, ValueError):
        raise crate.refused("metadata without a JSON-LD graph", "the metadata of an RO-Crate") from None
    held = (_held(one) for one in entities)
    return {one.name: one for one in held if one is not None}


def _held(entity: Mapping[str, Any]) -> Held | None:
    name, size, sha256 = (entity.get(key) for key in ("@id", "contentSize", "sha256"))
    if not isinstance(name, str) or not isinstance(sha256, str) or not _SHA256.fullmatch(sha256):
        return None
    if not _SIZE.fullmatch(str(size)):
        return None
    return Held(unquote(name).removeprefix("./"), int(str(size)), sha256.lower())


def _archived(described: Mapping[str, Held]) -> Iterator[ArchivedFile]:
    for name, held in described.items():
        matched = _ARCHIVED.fullmatch(name)
        if matched:
            yield ArchivedFile(matched["id"], matched["study"] is not None, held)


def _taken(crate: Packed, one: ArchivedFile, archive: Archive) -> Literal["added", "unchanged"]:
    pieces = crate.pieces(one.held.name, one.held.size, one.held.sha256)
    return archive.adopt(one.id, pieces, one.held.sha256, study=one.study)


def _dataset(crate: Packed, held: Held, archive: Archive) -> Path | None:
    """Write the crate's dataset.toml next to the archive where there is none, once it is known to be one."""
    path = archive.folder.resolve().parent / DATASET_NAME
    if path.exists():
        return None
    if held.size > _MOST_DOCUMENT:
        raise crate.refused(f"{held.name!r} of {held.size:,} bytes", f"at most {_MOST_DOCUMENT:,}")
    content = b"".join(crate.pieces(held.name, held.size, held.sha256))
    within = crate.path / held.name
    read_document(parse_toml(within, content), Dataset, where=str(within))
    try:
        with archive.alone_with(DATASET_NAME):
            clear_leftovers_of(path)
            write_file(path, content)
    except OSError as error:
        raise ArchiveError(
            f"{path}: cannot be written ({error.strerror or error}); expected a folder with free space and write "
            "permission; choose another archive with --archive"
        ) from None
    return path

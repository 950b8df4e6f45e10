"""Archives on remote storage, read only: https, S3 and whatever else fsspec knows by an address with ``://``.

A web server has no listing, so the catalog names the files of an archive. It is fetched as a whole into a temporary
folder; a run or study follows when it is first read, as one file, so that its seal can be checked before HDF5 looks at
it. Of a large file, HDF5 reads blocks by range requests, and its seal is not checked. The folder goes with the process.
fsspec is imported for an address alone.
"""

import os
import re
import sqlite3
import warnings
from collections import defaultdict
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from stat import S_IFREG, S_ISREG
from tempfile import TemporaryDirectory
from threading import Lock
from typing import TYPE_CHECKING, Any, NamedTuple

from tribopipe.archive.file_signature import STUDIES, Stamp
from tribopipe.archive.remote_blocks import BLOCK, BlockFile, RemoteBlocks
from tribopipe.base.errors import ArchiveError, printable
from tribopipe.base.files import sha256_of
from tribopipe.base.process_lifecycle import undone_at_end
from tribopipe.version import VERSION

CONNECT_WITHIN, ANSWER_WITHIN = 10.0, 30.0
"""How long a web server may take to accept a connection, and to send the next bytes, s."""
LARGEST_WHOLE = 16 << 20
"""Bytes of a file that is fetched as a whole; one request is quicker than those for its blocks."""
_ADDRESS = re.compile(r"\A([A-Za-z][A-Za-z0-9+.-]{1,31}):[/\\]{1,2}(?=[^/\\])")
"""How an address begins, as it is typed or as pathlib keeps it; the drives of Windows have one letter."""
_NAMES = re.compile(rf"(?:{STUDIES}/)?[^./\\:\0][^/\\:\0]*\.h5")
"""Names that a catalog may give to files: none of them leads out of the temporary folder."""
_CHANGED = 412
"""Status of a web server that has another file than it was asked for."""
_LONGEST = 200
"""Characters of what a storage states about an error."""

if TYPE_CHECKING:
    _SystemPath = Path
else:
    _SystemPath = type(Path())


class RemotePath(_SystemPath):
    """A path in a remote archive, written as its address; what the system opens is the local copy."""

    def __str__(self) -> str:
        return _ADDRESS.sub(r"\1://", super().__str__().replace("\\", "/"))

    def __fspath__(self) -> str:
        """Return the path of the local copy, which is fetched where there is none yet."""
        for place in (self, *self.parents):
            if (archive := _archives.get(str(place))) is not None:
                return str(archive.local(self.relative_to(place).as_posix()))
        return super().__str__()

    @property
    def blocks(self) -> RemoteBlocks | None:
        """The blocks of a large file; none of another one, which is fetched as a whole."""
        for place in (self, *self.parents):
            if (archive := _archives.get(str(place))) is not None:
                return archive.blocks(self.relative_to(place).as_posix())
        return None

    def stat(self, *, follow_symlinks: bool = True) -> os.stat_result:
        """Return what is known of the file; a large one is not fetched for that."""
        if (blocks := self.blocks) is not None:
            return os.stat_result((S_IFREG, 0, 0, 1, 0, 0, blocks.size, 0, 0, 0), {"st_mtime_ns": 0, "st_ctime_ns": 0})
        return super().stat(follow_symlinks=follow_symlinks)

    def exists(self, *, follow_symlinks: bool = True) -> bool:
        """Return whether there is such a file or folder."""
        try:
            self.stat(follow_symlinks=follow_symlinks)
        except FileNotFoundError:
            return False
        return True

    def is_file(self, *, follow_symlinks: bool = True) -> bool:
        """Return whether there is such a file."""
        return self.exists() and S_ISREG(self.stat(follow_symlinks=follow_symlinks).st_mode)

    def __reduce__(self) -> tuple[Any, ...]:
        """Be known to another process, too, which fetches its own copies."""
        root = next((str(place) for place in (self, *self.parents) if str(place) in _archives), None)
        return (_unpickled, (str(self), root))

    def resolve(self, strict: bool = False) -> "RemotePath":
        """Return the path itself: an address has no links. Raises ``FileNotFoundError`` as other paths do."""
        if strict:
            self.stat()
        return self

    def absolute(self) -> "RemotePath":
        """Return the path itself."""
        return self


def _unpickled(path: str, root: str | None) -> RemotePath:
    if root is not None:
        archive_path(root)
    return RemotePath(path)


def archive_path(folder: Path | str) -> Path:
    """Return the path of an archive: a remote one for an address with ``://``, else that of a folder."""
    if isinstance(folder, RemotePath):
        return folder
    text, path = str(folder), Path(folder)
    typed = "://" in text if isinstance(folder, str) else not path.exists()  # a path keeps one of the slashes
    if not typed or _ADDRESS.match(text) is None:
        return path
    remote = RemotePath(text)
    if not any(str(place) in _archives for place in (remote, *remote.parents)):
        _archives[str(remote)] = RemoteArchive(str(remote))
    return remote


def readable(path: Path) -> Path | BlockFile:
    """Return what HDF5 opens: the path, or the blocks of a large remote file."""
    blocks = path.blocks if isinstance(path, RemotePath) else None
    return path if blocks is None else BlockFile(blocks)


def refuse_writing(folder: Path) -> None:
    """Raise ``ArchiveError`` for a remote archive."""
    if isinstance(folder, RemotePath):
        raise ArchiveError(
            f"{folder}: found the address of a remote archive, which can only be read; expected a folder on this "
            "computer or a network share; specify one with --archive"
        )


class _Listed(NamedTuple):
    """What the catalog states about a file."""

    stamp: Stamp
    sha256: str
    members: frozenset[str]
    """Runs of a study."""


class RemoteArchive:
    """One archive on remote storage, and the local copies of its files; any thread may ask."""

    def __init__(self, address: str) -> None:
        self.address = address
        self._begin, self._locks = Lock(), defaultdict[str, Lock](Lock)
        self._copies: _Copies | None = None

    def local(self, name: str) -> Path:
        """Return the path of the local copy of a file, which is fetched first if the catalog lists it.

        Raises ``ArchiveError`` where it cannot be fetched.
        """
        copies = self._begun()
        path = copies.folder / name
        if (listed := copies.files.get(name)) is not None:
            with self._locks[name]:
                if not path.exists():
                    copies.storage.fetch(name, path)
                    self._warn_if_changed(name, path, listed)
        return path

    def blocks(self, name: str) -> RemoteBlocks | None:
        """Return the blocks of a large file; none where it is here as a whole, or the server knows no ranges.

        Raises ``ArchiveError`` where the first one cannot be fetched.
        """
        copies = self._begun()
        listed, path = copies.files.get(name), copies.folder / name
        if listed is None or listed.stamp.size <= LARGEST_WHOLE or path.exists():
            return None
        with self._locks[name]:
            if name not in copies.blocks:
                copies.blocks[name] = copies.storage.blocks(name, path)
        return copies.blocks[name]

    def stamps(self) -> Mapping[str, Stamp]:
        """Return the stamps of all runs and studies as the catalog has them, by their names."""
        return {name: listed.stamp for name, listed in self._begun().files.items()}

    def studies_of(self, run_id: str) -> list[str]:
        """Return the ids of the studies that a run is part of, as the catalog has them."""
        return [Path(name).stem for name, listed in self._begun().files.items() if run_id in listed.members]

    def _begun(self) -> "_Copies":
        with self._begin:
            if self._copies is None:
                self._copies = _Copies(self.address)
            return self._copies

    def _warn_if_changed(self, name: str, path: Path, listed: _Listed) -> None:
        if listed.sha256 and sha256_of(path) != listed.sha256:
            warnings.warn(
                f"{self.address}/{name}: found content that differs from the catalog, so lists may be out of date; "
                "expected an unchanged file; run `tribopipe ls` on the computer that stores the archive",
                stacklevel=2,
            )


_archives: dict[str, RemoteArchive] = {}
"""Archives that this process was given the address of."""


def stamps_of(archive: RemotePath) -> Mapping[str, Stamp]:
    """Return the stamps of all runs and studies of a remote archive. Raises ``ArchiveError`` where it is none."""
    return _archives[str(archive)].stamps()


def studies_with(archive: RemotePath, run_id: str) -> list[str]:
    """Return the ids of the studies of a remote archive that a run is part of, none of which is fetched for this."""
    return _archives[str(archive)].studies_of(run_id)


def names_in(folder: RemotePath) -> list[str]:
    """Return the names of the runs in a remote archive, or of the studies in its folder of studies."""
    of_studies = folder.name == STUDIES and str(folder) not in _archives
    listed = stamps_of(folder.parent if of_studies else folder)
    prefix = f"{STUDIES}/" if of_studies else ""
    names = (name.removeprefix(prefix) for name in listed if name.startswith(prefix))
    return [name for name in names if "/" not in name]


class _Copies:
    """The temporary folder with the catalog of an archive, and the storage that the other files come from."""

    def __init__(self, address: str) -> None:
        from tribopipe.archive.catalog.database import FILE_NAME

        self.storage = _Storage(address)
        self._scratch = TemporaryDirectory(prefix="tribopipe-")
        undone_at_end(self._scratch.cleanup)
        self.folder = Path(self._scratch.name)
        (self.folder / STUDIES).mkdir()
        self.storage.fetch(FILE_NAME, self.folder / FILE_NAME)
        self.blocks: dict[str, RemoteBlocks | None] = {}
        self.files = _files_in(self.folder, f"{address}/{FILE_NAME}")


def _files_in(folder: Path, where: str) -> dict[str, _Listed]:
    """Return what a catalog lists, and have it taken as it is: its files are not here to be looked at again.

    Raises ``ArchiveError`` where it is no catalog, damaged, or written by another version of tribopipe.
    """
    from tribopipe.archive.catalog.database import FILE_NAME, read_only

    try:
        read_only(folder).close()
        with sqlite3.connect(folder / FILE_NAME, isolation_level=None) as catalog:
            rows = catalog.execute("SELECT name, stamp, sha256 FROM files").fetchall()
            members = defaultdict[str, set[str]](set)
            for study, run in catalog.execute("SELECT file, run FROM members"):
                members[study].add(run)
            catalog.execute("UPDATE files SET settled = 1")
        catalog.close()
        return {
            name: _Listed(Stamp(*map(int, stamp.split())), sha256, frozenset(members[name]))
            for name, stamp, sha256 in rows
            if _NAMES.fullmatch(name)
        }
    except (sqlite3.DatabaseError, TypeError, ValueError) as error:
        raise ArchiveError(
            f"{where}: found a catalog that cannot be used ({_said(error)}); expected one written by tribopipe "
            f"{VERSION}; run `tribopipe ls` with this version on the computer that stores the archive"
        ) from None


class _Storage:
    """The files below an address."""

    def __init__(self, address: str) -> None:
        self._address, self._is_web = address, address.startswith(("http://", "https://"))
        with _sentences(address):
            from fsspec.core import url_to_fs

            self._files, self._root = url_to_fs(address, **(_http_options() if self._is_web else {}))

    def fetch(self, name: str, path: Path) -> None:
        """Copy a file, whole or not at all. Raises ``ArchiveError`` where that cannot be done."""
        part = path.with_name(f"{path.name}.part")
        with _sentences(f"{self._address}/{name}"):
            self._files.get_file(f"{self._root}/{name}", str(part))
        part.replace(path)

    def blocks(self, name: str, path: Path) -> RemoteBlocks | None:
        """Return the blocks of a file; none where the server knows no ranges, which may then have sent it whole.

        Raises ``ArchiveError`` where it cannot be read.
        """
        where, file = f"{self._address}/{name}", f"{self._root}/{name}"
        with _sentences(where):
            begins = self._files.cat_file(file, start=0, end=BLOCK)  # which tells more than info where it is refused
            if len(begins) > BLOCK:
                path.write_bytes(begins)
            if len(begins) != BLOCK:
                return None
            about = self._files.info(file)
        size, same = int(about["size"]), _if_unchanged(about.get("ETag", "")) if self._is_web else {}

        def fetch(start: int, end: int) -> bytes:
            with _sentences(where):
                found: bytes = self._files.cat_file(file, start=start, end=end, **same)
            return found

        return RemoteBlocks(where, size, fetch, path.with_name(f"{path.name}.blocks"))


def _http_options() -> dict[str, Any]:
    """Return how web servers are asked: through the proxy of the environment, and not waited for without end."""
    from aiohttp import ClientTimeout

    timeout = ClientTimeout(total=None, sock_connect=CONNECT_WITHIN, sock_read=ANSWER_WITHIN)
    return {"client_kwargs": {"timeout": timeout, "trust_env": True}}


def _if_unchanged(version: str) -> dict[str, Any]:
    """Return how a web server is asked for parts of a file as long as it is the same; weak ETags cannot be used."""
    return {"headers": {"If-Match": version}} if version.startswith('"') else {}


@contextmanager
def _sentences(where: str) -> Iterator[None]:
    """Raise ``ArchiveError`` in the place of whatever a storage raises."""
    try:
        yield
    except ImportError as error:
        package = (error.name or "s3fs").partition(".")[0]
        raise ArchiveError(
            f"{where}: found no package {package}; expected the packages for remote archives; run "
            '`pip install "tribopipe[remote]"`'
        ) from None
    except Exception as error:  # noqa: BLE001 - each storage has exceptions of its own
        raise ArchiveError(f"{where}: {_why(error)}") from None


def _why(error: Exception) -> str:
    """State in a sentence why a file cannot be fetched."""
    if isinstance(error, FileNotFoundError):
        return (
            "found no such file; expected an archive with a catalog written by `tribopipe ls`; check the address, "
            "and run `tribopipe ls` on the computer that stores the archive"
        )
    if isinstance(error, PermissionError) or getattr(error, "status", 0) in (401, 403):
        return f"access denied ({_said(error)}); expected permission to read; check the address and credentials"
    if getattr(error, "status", 0) == _CHANGED:
        return "found that the file changed while it was being read; expected an unchanged file; run the command again"
    if isinstance(error, TimeoutError):
        return "found no response in time; expected a file; check the connection, and try again"
    return f"cannot be read ({_said(error)}); expected a file; check the address and the connection, and try again"


def _said(error: Exception) -> str:
    """Return in one line what an error states."""
    status = getattr(error, "status", None)
    said = f"status {status}" if isinstance(status, int) else str(error) or type(error).__name__
    return printable(" ".join(said.split()))[:_LONGEST]

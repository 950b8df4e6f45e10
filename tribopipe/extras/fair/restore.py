"""The way back: archived runs and studies taken out of a crate, byte for byte, into an archive."""

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, NamedTuple
from urllib.parse import unquote

import orjson

from tribopipe.archive.store import STUDIES, SUFFIX, Archive
from tribopipe.base.errors import ArchiveError, TribopipeError
from tribopipe.base.files import clear_leftovers_of, write_file
from tribopipe.documents.dataset import DATASET_NAME, Dataset
from tribopipe.documents.record import read_document
from tribopipe.documents.toml import parse_toml
from tribopipe.extras.fair.layout import ARCHIVE, DATASET
from tribopipe.extras.fair.packed import Packed, packed

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
    """What became of each run and study of a crate."""

    done: dict[ArchivedFile, Literal["added", "unchanged"]] = field(default_factory=dict)
    failed: dict[ArchivedFile, TribopipeError] = field(default_factory=dict)
    dataset: Path | None = None
    """The dataset.toml that was written next to the archive; none where the crate has none, or one was there."""
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
                f"{path}: found no archived run in it; expected a crate that `tribopipe export` wrote; of another one, "
                "unpack it and point `tribopipe new` at the instrument's files"
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
        raise crate.refused("metadata that are no JSON-LD graph", "those of an RO-Crate") from None
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
            f"{path}: cannot be written ({error.strerror or error}); expected a folder with room and write permission; "
            "name an archive elsewhere with --archive"
        ) from None
    return path
